//! Opens a part file of any format, by its extension.

use std::path::Path;

use super::source::{name_of, read_bytes};
use super::{InputError, geomturbo, gltf, native, step, stl, turbogrid};
use crate::error::ErrorCode;
use crate::mesh::options::{FileUnit, is_plausible_size};
use crate::mesh::{LengthUnit, MeshOptions, NamedMesh};
use crate::part::PartDescription;

/// Extensions of part files, as dialogs list them.
pub const EXTENSIONS: &[&str] =
    &["toml", "geomTurbo", "geomturbo", "inf", "step", "stp", "p21", "stl", "glb", "gltf"];

/// Extensions of those that come from CAD or as meshes, in small letters: roles of their bodies, unit, axis,
/// number of blades and sense of rotation are [`MeshOptions`].
const MESH_EXTENSIONS: [&str; 6] = ["step", "stp", "p21", "stl", "glb", "gltf"];

const CAN_OPEN: &str = "open a .toml, .geomTurbo, .inf (TurboGrid), .step, .stl, .glb or .gltf file";

/// Reads a part file: `.toml`, `.geomTurbo`, TurboGrid `.inf` with its `.curve` files beside it, CAD
/// bodies, `.step` or `.stp`, or a mesh, `.stl`, `.glb` or `.gltf`. The extension is case-insensitive. The
/// result is in mm and rad, about Z.
///
/// ```
/// let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
/// assert_eq!((part.name.as_str(), part.blade_count), ("impeller532", 17));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the file cannot be read, its extension is unknown, or it does not describe a part.
pub fn read_part(path: &Path) -> Result<PartDescription, InputError> {
    read_part_with(path, &MeshOptions::default())
}

/// As [`read_part`], with the user's options for a mesh; geomTurbo files take their unit, other formats
/// ignore them.
///
/// # Errors
/// As [`read_part`].
pub fn read_part_with(path: &Path, options: &MeshOptions) -> Result<PartDescription, InputError> {
    let name = name_of(path);
    let extension = extension_of(path);
    match extension.as_str() {
        "inf" => turbogrid::read(path).map(questioned),
        "glb" | "gltf" => gltf::read(path, options),
        "step" | "stp" | "p21" => step::read(path, options),
        "stl" => stl::read_part(path, options),
        "geomturbo" => geomturbo::read(&name, &read_bytes(path)?, options.unit),
        "toml" => read_part_bytes(&name, &read_bytes(path)?, &extension),
        other => Err(unknown(&name, other)),
    }
}

/// Checks by its extension that a file is a part, without reading it.
///
/// # Errors
/// When it has another one.
pub fn check_part_format(path: &Path) -> Result<(), InputError> {
    let extension = extension_of(path);
    match extension.as_str() {
        "inf" | "glb" | "gltf" | "step" | "stp" | "p21" | "stl" | "geomturbo" | "toml" => Ok(()),
        other => Err(unknown(&name_of(path), other)),
    }
}

fn extension_of(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Whether a part file comes from CAD or as a mesh, by its extension: such a part is read by [`MeshOptions`].
pub fn takes_mesh_options(path: &Path) -> bool {
    MESH_EXTENSIONS.contains(&extension_of(path).as_str())
}

/// The bodies of a part file from CAD or of meshes.
#[derive(Clone, Debug)]
pub struct FileBodies {
    /// Their meshes, in the frame of the file, with those names and numbers by which options give them roles.
    pub meshes: Vec<NamedMesh>,
    /// Unit of their coordinates.
    pub unit: FileUnit,
}

/// Reads the bodies of a part file from CAD or of meshes; those of CAD are coarser than a part has them.
///
/// # Errors
/// When the file cannot be read, or [`takes_mesh_options`] does not hold for it.
pub fn read_bodies(path: &Path) -> Result<FileBodies, InputError> {
    let extension = extension_of(path);
    let (meshes, unit) = match extension.as_str() {
        "glb" | "gltf" => (gltf::read_meshes(path)?, FileUnit::Specified(LengthUnit::Metre)),
        "step" | "stp" | "p21" => (step::read_meshes(path)?, FileUnit::Stated),
        "stl" => (stl::read_meshes(path)?, FileUnit::Assumed(LengthUnit::Millimetre)),
        other => return Err(unknown(&name_of(path), other)),
    };
    Ok(FileBodies { meshes, unit })
}

/// Reads a part from the bytes of a single file; `ext` is `toml`, `geomTurbo`, `step`, `stl`, `glb` or
/// `gltf` in any case. `name` is the file name used in messages; its stem names a part without a name.
///
/// # Errors
/// When the bytes do not describe a part in that format, or the format needs several files.
pub fn read_part_bytes(name: &str, bytes: &[u8], ext: &str) -> Result<PartDescription, InputError> {
    match ext.to_lowercase().as_str() {
        "toml" => native::read(name, bytes).map(questioned),
        "geomturbo" => geomturbo::read(name, bytes, None),
        "glb" | "gltf" => gltf::read_bytes(name, bytes, &MeshOptions::default()),
        "step" | "stp" | "p21" => step::read_bytes(name, bytes, &MeshOptions::default()),
        "stl" => stl::read_part_bytes(name, bytes, &MeshOptions::default()),
        "inf" => Err(InputError::new(
            ErrorCode::PartFile,
            name,
            0,
            "a TurboGrid part is several files",
            "open the .inf file from the folder that holds its .curve files",
        )),
        other => Err(unknown(name, other)),
    }
}

/// A part of a format with a certain unit; a line asks about a diameter that is not plausible.
fn questioned(mut part: PartDescription) -> PartDescription {
    let across = part.diameter();
    if !is_plausible_size(across) {
        part.notes.push(format!(
            "the wheel is {across:.4} mm across, which is hardly the size of an impeller: check the unit of \
             the lengths"
        ));
    }
    part
}

fn unknown(name: &str, extension: &str) -> InputError {
    let what = match extension {
        "" => "has no extension, so its format is unknown".to_owned(),
        "curve" => "is one piece of a TurboGrid part".to_owned(),
        other => format!("`.{other}` is not a part format"),
    };
    InputError::new(ErrorCode::FileFormat, name, 0, what, CAN_OPEN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_extensions_list_what_can_be_opened() {
        for name in ["a.iges", "noext", "b.curve"] {
            let error = read_part(Path::new(name)).unwrap_err();
            assert_eq!(error.code, ErrorCode::FileFormat, "{error}");
            assert!(error.help.contains(".geomTurbo"), "{error}");
        }
        assert_eq!(read_part_bytes("a.inf", b"x", "INF").unwrap_err().code, ErrorCode::PartFile);
    }

    #[test]
    fn every_extension_has_a_reader() {
        for extension in EXTENSIONS {
            let error = read_part_bytes("empty", b"", extension).unwrap_err();
            assert_ne!(error.help, CAN_OPEN, "{extension}: {error}");
            assert!(CAN_OPEN.contains(extension) || ["geomturbo", "stp", "p21"].contains(extension));
        }
    }

    #[test]
    fn a_missing_file_says_so() {
        let error = read_part(Path::new("no/such/part.TOML")).unwrap_err();
        assert!(error.to_string().starts_with("no/such/part.TOML: cannot be read: "), "{error}");
        assert_eq!(error.help, "check the path");
    }
}
