//! Cutter-location programs in APT (ISO 4343): a writer and a tolerant reader.

mod read;
mod transform;
mod words;
mod write;

pub use read::{read_apt, read_apt_bytes};
pub(in crate::io) use write::section_words;
pub use write::write_apt;

use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::toolpath::ClProgram;

/// `program` as it is written and read back: with lines, and numbers rounded. `name` is the file name used in
/// messages.
///
/// # Errors
/// When it cannot be read back, as it is too long.
pub fn as_written(name: &str, program: &ClProgram) -> Result<ClProgram, InputError> {
    read_apt_bytes(name, write_apt(program).as_bytes())
}

/// What is wrong with a program that [`ClProgram::is_cut_off`].
pub fn cut_off_error() -> UserError {
    let help = "write or copy it again, or end it with FINI if it is whole";
    UserError::new(ErrorCode::FileCutOff, "the program has no end (FINI): it seems cut off", help)
}

#[cfg(test)]
mod tests;
