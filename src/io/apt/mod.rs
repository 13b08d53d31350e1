//! Cutter-location programs in APT (ISO 4343): a writer and a tolerant reader.

mod read;
mod transform;
mod words;
mod write;

pub use read::{read_apt, read_apt_bytes};
pub(in crate::io) use write::section_words;
pub use write::write_apt;

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

#[cfg(test)]
mod tests;
