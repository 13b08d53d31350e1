//! Readers and writers: part files, setup, CL programs, plans.
//!
//! One file per format; [`part_file`] picks the reader by extension. For any input, a reader returns
//! a value or an [`InputError`]: it does not panic or loop endlessly, and its memory is a small
//! multiple of the file size. Limits: 64 MiB per file, 1,000,000 points, 1,000 blades,
//! |x| ≤ 1,000,000 mm; for meshes 512 MiB and 8,000,000 triangles, for programs 512 MiB and 4,000,000 moves.

pub mod apt;
pub mod blank_file;
pub mod flank_file;
pub mod geomturbo;
pub mod gltf;
pub(crate) mod hash;
pub mod machine_file;
pub mod native;
pub mod nc;
pub mod part_file;
pub mod part_hash;
pub mod plan_file;
pub mod plan_inputs;
pub mod program_file;
pub mod project_file;
pub mod replaced;
pub mod setup_file;
pub(crate) mod sha256;
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

use crate::error::{ErrorCode, UserError};
use crate::part::PartError;

pub use gltf::GltfScene;
pub use native::write_native;
pub use part_file::{read_part, read_part_bytes, read_part_with};
pub use setup_file::{
    parse_axis_policy, parse_flank_strategy, read_setup, read_setup_bytes, read_setup_with_defaults,
    write_setup,
};
pub use write::write_atomically;

/// An error in user input or output, with its place. Displayed as `FILE:LINE: message; help`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct InputError {
    /// Its kind.
    pub code: ErrorCode,
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
    pub fn new(
        code: ErrorCode,
        file: &str,
        line: usize,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self { code, file: file.to_owned(), line, message: message.into(), help: help.into() }
    }

    /// An error of the whole of `file`.
    pub fn at_file(file: &str, error: UserError) -> Self {
        Self::new(error.code, file, 0, error.message, error.help)
    }

    /// The error of a part that `file` describes.
    pub fn of_part(file: &str, error: PartError) -> Self {
        Self::new(error.code, file, error.line, error.message, error.help)
    }

    /// The same error with a more exact code than that of its file.
    #[must_use]
    pub fn with_code(self, code: ErrorCode) -> Self {
        Self { code, ..self }
    }

    /// Where it is: `FILE:LINE`, `FILE`, or nothing.
    pub fn place(&self) -> String {
        match (self.file.is_empty(), self.line) {
            (true, _) => String::new(),
            (false, 0) => self.file.clone(),
            (false, line) => format!("{}:{line}", self.file),
        }
    }
}

impl From<InputError> for UserError {
    fn from(error: InputError) -> Self {
        Self::new(error.code, error.message, error.help)
    }
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.place().as_str() {
            "" => write!(f, "{}; {}", self.message, self.help),
            place => write!(f, "{place}: {}; {}", self.message, self.help),
        }
    }
}
