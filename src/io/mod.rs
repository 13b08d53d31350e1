//! Readers and writers: part files, setup, CL programs, plans.
//!
//! One file per format; [`part_file`] picks the reader by extension. For any input, a reader returns
//! a value or an [`InputError`]: it does not panic or loop endlessly, and its memory is a small
//! multiple of the file size. Limits: 64 MiB per file, 1,000,000 points, 1,000 blades,
//! |x| ≤ 1,000,000 mm; for meshes 512 MiB and 8,000,000 triangles.

pub mod apt;
pub mod blank_file;
pub mod flank_file;
pub mod geomturbo;
pub mod gltf;
pub mod machine_file;
pub mod native;
pub mod nc;
pub mod part_file;
pub mod plan_file;
pub mod project_file;
pub mod setup_file;
pub mod shop_tools;
pub(crate) mod source;
pub mod step;
pub mod stl;
mod stored;
pub(crate) mod table;
pub mod tool_file;
pub mod tool_library;
pub mod turbogrid;
pub mod write;

pub use gltf::GltfScene;
pub use native::write_native;
pub use part_file::{read_part, read_part_bytes, read_part_with};
pub use setup_file::{
    parse_axis_policy, parse_flank_strategy, read_setup, read_setup_bytes, read_setup_with_defaults,
    write_setup,
};
pub use write::write_atomically;

/// An error in user input. Displayed as `FILE:LINE: message; help`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct InputError {
    /// File as the user named it; empty when the error is not in a file.
    pub file: String,
    /// 1-based line number; 0 when there is none.
    pub line: usize,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

impl InputError {
    /// An error at `line` of `file` (0: no line).
    pub fn new(file: &str, line: usize, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line, message: message.into(), help: help.into() }
    }
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.file.is_empty(), self.line) {
            (true, _) => write!(f, "{}; {}", self.message, self.help),
            (false, 0) => write!(f, "{}: {}; {}", self.file, self.message, self.help),
            (false, line) => write!(f, "{}:{line}: {}; {}", self.file, self.message, self.help),
        }
    }
}
