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

const CAN_OPEN: &str = "open a .toml, .geomTurbo, .inf (TurboGrid), .step, .stl, .glb or .gltf file";

/// Formats of part files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PartFileFormat {
    Native,
    GeomTurbo,
    TurboGrid,
    Step,
    Stl,
    Gltf,
}

impl PartFileFormat {
    /// The format that an extension in any case stands for. `name` is the file name used in messages.
    fn from_extension(name: &str, extension: &str) -> Result<Self, InputError> {
        let extension = extension.to_lowercase();
        match extension.as_str() {
            "toml" => Ok(Self::Native),
            "geomturbo" => Ok(Self::GeomTurbo),
            "inf" => Ok(Self::TurboGrid),
            "step" | "stp" | "p21" => Ok(Self::Step),
            "stl" => Ok(Self::Stl),
            "glb" | "gltf" => Ok(Self::Gltf),
            other => Err(unknown(name, other)),
        }
    }

    fn of_file(path: &Path) -> Result<Self, InputError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Self::from_extension(&name_of(path), &extension)
    }
}

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
    match PartFileFormat::of_file(path)? {
        PartFileFormat::Native => native::read(&name, &read_bytes(path)?).map(questioned),
        PartFileFormat::GeomTurbo => geomturbo::read(&name, &read_bytes(path)?, options.unit),
        PartFileFormat::TurboGrid => turbogrid::read(path).map(questioned),
        PartFileFormat::Step => step::read(path, options),
        PartFileFormat::Stl => stl::read_part(path, options),
        PartFileFormat::Gltf => gltf::read(path, options),
    }
}

/// Checks by its extension that a file is a part, without reading it.
///
/// # Errors
/// When it has another one.
pub fn check_part_format(path: &Path) -> Result<(), InputError> {
    PartFileFormat::of_file(path).map(|_| ())
}

/// Whether a part file comes from CAD or as a mesh, by its extension: roles of its bodies, unit, axis, number
/// of blades and sense of rotation are [`MeshOptions`].
pub fn takes_mesh_options(path: &Path) -> bool {
    use PartFileFormat::{Gltf, Step, Stl};
    PartFileFormat::of_file(path).is_ok_and(|format| matches!(format, Step | Stl | Gltf))
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
    let (meshes, unit) = match PartFileFormat::of_file(path)? {
        PartFileFormat::Gltf => (gltf::read_meshes(path)?, FileUnit::Specified(LengthUnit::Metre)),
        PartFileFormat::Step => (step::read_meshes(path)?, FileUnit::Stated),
        PartFileFormat::Stl => (stl::read_meshes(path)?, FileUnit::Assumed(LengthUnit::Millimetre)),
        PartFileFormat::Native | PartFileFormat::GeomTurbo | PartFileFormat::TurboGrid => {
            let (what, help) = ("has no bodies", "give a .step, .stl, .glb or .gltf file");
            return Err(InputError::new(ErrorCode::FileFormat, &name_of(path), 0, what, help));
        }
    };
    Ok(FileBodies { meshes, unit })
}

/// Reads a part from the bytes of a single file; `ext` is `toml`, `geomTurbo`, `step`, `stl`, `glb` or
/// `gltf` in any case. `name` is the file name used in messages; its stem names a part without a name.
///
/// # Errors
/// When the bytes do not describe a part in that format, or the format needs several files.
pub fn read_part_bytes(name: &str, bytes: &[u8], ext: &str) -> Result<PartDescription, InputError> {
    match PartFileFormat::from_extension(name, ext)? {
        PartFileFormat::Native => native::read(name, bytes).map(questioned),
        PartFileFormat::GeomTurbo => geomturbo::read(name, bytes, None),
        PartFileFormat::Step => step::read_bytes(name, bytes, &MeshOptions::default()),
        PartFileFormat::Stl => stl::read_part_bytes(name, bytes, &MeshOptions::default()),
        PartFileFormat::Gltf => gltf::read_bytes(name, bytes, &MeshOptions::default()),
        PartFileFormat::TurboGrid => Err(InputError::new(
            ErrorCode::PartFile,
            name,
            0,
            "a TurboGrid part is several files",
            "open the .inf file from the folder that holds its .curve files",
        )),
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
