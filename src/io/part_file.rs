//! Opens a part file of any format, by its extension.

use std::path::Path;

use super::source::{name_of, read_bytes};
use super::{InputError, geomturbo, gltf, native, step, stl, turbogrid};
use crate::error::ErrorCode;
use crate::mesh::MeshOptions;
use crate::mesh::options::is_plausible_size;
use crate::part::PartDescription;

/// Extensions of part files, as dialogs list them.
pub const EXTENSIONS: &[&str] =
    &["toml", "geomTurbo", "geomturbo", "inf", "step", "stp", "p21", "stl", "glb", "gltf"];

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
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
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
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "inf" | "glb" | "gltf" | "step" | "stp" | "p21" | "stl" | "geomturbo" | "toml" => Ok(()),
        other => Err(unknown(&name_of(path), other)),
    }
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
