//! Tool libraries of shops: Fusion (`.json`, `.tools`), FreeCAD (`.fctb`, `.fctl`), and Vanecut's own TOML.
//!
//! All lengths become mm. What a format does not say and is assumed, and what could not be taken over, is
//! listed with each tool.

mod expression;
mod freecad;
mod fusion;
mod fusion_merge;
mod fusion_units;
mod fusion_write;
mod json;
mod left_out;
mod length;
mod library;
mod toml_merge;
mod toml_write;
mod zip;

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::InputError;
use super::source::{Source, name_of, read_bytes_up_to};
use super::tool_file::read_tools_bytes;
use super::write::not_replaced;
use crate::error::ErrorCode;
use freecad::ToolBit;
pub use fusion_merge::{MergedLibrary, merge_fusion};
pub use fusion_write::{fusion_remarks, write_fusion};
use json::MAX_LIBRARY_BYTES;
pub use library::{LibraryTool, ToolLibrary};
pub use toml_merge::merge_toml;
pub use toml_write::write_toml;

/// Folders of tool bits beside that of a FreeCAD library: FreeCAD's own, and what people call it.
const BIT_FOLDERS: [&str; 2] = ["Bit", "ToolBits"];
/// Number of bytes by which the content of a file is recognised.
const LOOKED_AT: usize = 1 << 16;
/// Largest size of the file of one tool, bytes.
const MAX_BIT_BYTES: usize = 1 << 20;

/// Format of a library file, by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LibraryFormat {
    /// `[[tool]]` tables.
    Toml,
    /// Fusion JSON.
    FusionJson,
    /// Fusion JSON in a ZIP archive.
    FusionTools,
    /// One FreeCAD tool bit.
    FreeCadBit,
    /// A FreeCAD library, which names tool bits beside it.
    FreeCadLibrary,
}

impl LibraryFormat {
    /// The format of an extension without its dot, in lower case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "toml" => Self::Toml,
            "json" => Self::FusionJson,
            "tools" => Self::FusionTools,
            "fctb" => Self::FreeCadBit,
            "fctl" => Self::FreeCadLibrary,
            _ => return None,
        })
    }
}

impl LibraryFormat {
    /// The format of a file by its extension.
    ///
    /// # Errors
    /// When it has another one.
    pub fn of_path(path: &Path) -> Result<Self, InputError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        Self::of_extension(&extension).ok_or_else(|| {
            let (name, help) = (name_of(path), "give a .toml, .json, .tools, .fctb or .fctl file");
            Source::new(&name, ErrorCode::FileFormat).fault(0, "is not a tool library", help)
        })
    }
}

/// Whether bytes look like a tool library of one of the formats that share their extension with others: our
/// TOML (only `[[tool]]` tables) and Fusion JSON (a list `data`).
pub fn looks_like_library(format: LibraryFormat, bytes: &[u8]) -> bool {
    match format {
        LibraryFormat::Toml => {
            let text = String::from_utf8_lossy(bytes);
            let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
            let first = lines.find(|line| !line.starts_with('#'));
            // Of other tables it is a setup.
            let is_of_tool = |line: &str| {
                let name = line.trim_start_matches('[');
                name.len() == line.len() || !name.starts_with(char::is_alphabetic) || name.starts_with("tool")
            };
            first.is_some_and(|line| line.starts_with("[[tool]]")) && lines.all(is_of_tool)
        }
        LibraryFormat::FusionJson => {
            let start = &bytes[..bytes.len().min(LOOKED_AT)];
            let words = |word: &str| start.windows(word.len()).any(|w| w == word.as_bytes());
            words("\"data\"") && !words("\"vanecut") && (words("\"geometry\"") || words("\"guid\""))
                || words("\"data\"") && bytes.len() < 64
        }
        _ => true,
    }
}

/// Reads a tool library.
///
/// # Errors
/// When the file cannot be read or is not such a library.
pub fn read_library(path: &Path, format: LibraryFormat) -> Result<ToolLibrary, InputError> {
    let name = name_of(path);
    let bytes = read_bytes_up_to(path, MAX_LIBRARY_BYTES)?;
    match format {
        LibraryFormat::FreeCadLibrary => {
            let beside = |file: &str| {
                // Bits lie beside the library, or in a folder beside its own.
                let folder = path.parent().unwrap_or(Path::new(""));
                let others = BIT_FOLDERS.map(|name| folder.join("..").join(name).join(file));
                let beside = folder.join(file);
                let found =
                    others.iter().find(|place| !beside.is_file() && place.is_file()).unwrap_or(&beside);
                Ok((name_of(found), read_bytes_up_to(found, MAX_BIT_BYTES)?))
            };
            freecad::read_list(&name, &bytes, &beside)
        }
        _ => read_library_bytes(&name, &bytes, format),
    }
}

/// Reads a tool library from bytes; `name` is the file name used in messages.
///
/// # Errors
/// When the bytes are not such a library, or it is a FreeCAD library, whose tools are in other files.
pub fn read_library_bytes(
    name: &str,
    bytes: &[u8],
    format: LibraryFormat,
) -> Result<ToolLibrary, InputError> {
    match format {
        LibraryFormat::Toml => {
            let tools = read_tools_bytes(name, bytes)?.into_iter();
            let tools = tools.map(|tool| Arc::new(LibraryTool { tool, notes: Vec::new() }));
            Ok(ToolLibrary { tools: tools.collect(), ..ToolLibrary::default() })
        }
        LibraryFormat::FusionJson => fusion::read(name, bytes),
        LibraryFormat::FusionTools => fusion::read(name, &zip::json_member(name, bytes)?),
        LibraryFormat::FreeCadBit => match freecad::read_bit(name, bytes, None)? {
            ToolBit::Mill(tool) => Ok(ToolLibrary { tools: vec![Arc::new(*tool)], ..ToolLibrary::default() }),
            ToolBit::Other(shown, why) => {
                let what = format!("contains no mill: {shown}: {why}");
                Err(Source::new(name, ErrorCode::ToolFile).fault(0, what, "give an end mill"))
            }
        },
        LibraryFormat::FreeCadLibrary => freecad::read_list(name, bytes, &|file| {
            Err(Source::new(file, ErrorCode::ToolFile)
                .fault(0, "is not given", "give it beside the library")
                .with_code(ErrorCode::FileUnreadable))
        }),
    }
}

/// The text of a Fusion library with these tools for a file at `path`: a Fusion library that is there keeps
/// what it has beyond them.
///
/// # Errors
/// When the file that is there cannot be read, or is a damaged Fusion library or something else.
pub fn fusion_for(path: &Path, library: &ToolLibrary) -> Result<MergedLibrary, InputError> {
    if is_fusion_library(path) {
        return merge_fusion(&name_of(path), &read_bytes_up_to(path, MAX_LIBRARY_BYTES)?, library);
    }
    check_replaced_library(path)?;
    Ok(MergedLibrary::of_new_file(write_fusion(library), library))
}

/// The text of our TOML with these tools for a file at `path`: a library that is there keeps its other tools.
///
/// # Errors
/// When a file that exists cannot be read, or is not a tool library.
pub fn toml_for(path: &Path, library: &ToolLibrary) -> Result<MergedLibrary, InputError> {
    let existing = if is_absent(path) { Vec::new() } else { read_bytes_up_to(path, MAX_LIBRARY_BYTES)? };
    merge_toml(&name_of(path), &existing, library)
}

/// Checks that a tool library may be written to `path`: nothing is there, or a library of its format.
///
/// # Errors
/// When another file is there.
pub fn check_replaced_library(path: &Path) -> Result<(), InputError> {
    let is_fusion = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let (format, what) = match is_fusion {
        true => (LibraryFormat::FusionJson, "already exists and is not a Fusion tool library"),
        false => (LibraryFormat::Toml, "already exists and is not a tool library"),
    };
    let is_library = |bytes: Vec<u8>| looks_like_library(format, &bytes);
    if is_absent(path) || read_bytes_up_to(path, MAX_LIBRARY_BYTES).is_ok_and(is_library) {
        return Ok(());
    }
    Err(not_replaced(path, what))
}

/// Whether the file at `path` is missing or empty.
pub(super) fn is_absent(path: &Path) -> bool {
    std::fs::metadata(path).map_or(true, |found| found.is_file() && found.len() == 0)
}

/// Whether the file at `path` looks like a Fusion library, by its beginning.
pub fn is_fusion_library(path: &Path) -> bool {
    let Ok(file) = std::fs::File::open(path) else { return false };
    let mut start = Vec::new();
    let is_read = file.take(LOOKED_AT as u64).read_to_end(&mut start).is_ok();
    is_read && looks_like_library(LibraryFormat::FusionJson, &start)
}
