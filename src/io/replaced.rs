//! What a file that is written must not replace: what it is made of, and files of another kind.

use std::path::Path;

use super::InputError;
use super::setup_file::looks_like_setup;
use super::shop_tools::{LibraryFormat, is_absent, looks_like_library};
use super::source::{is_same_file, name_of, read_bytes};
use crate::error::ErrorCode;

/// Checks that `output` is none of the `inputs` that it is made of; names that are no files are none.
///
/// # Errors
/// When it is one of them.
pub fn check_is_no_input(output: &Path, inputs: &[&Path]) -> Result<(), InputError> {
    match inputs.iter().any(|input| input.is_file() && is_same_file(input, output)) {
        true => Err(unreplaced(output, "is the input file")),
        false => Ok(()),
    }
}

/// Checks that a setup may be written to `path`: nothing is there, or a setup.
///
/// # Errors
/// When another file is there.
pub fn check_replaced_setup(path: &Path) -> Result<(), InputError> {
    let is_setup =
        |bytes: Vec<u8>| looks_like_setup(&bytes) && !looks_like_library(LibraryFormat::Toml, &bytes);
    match is_absent(path) || read_bytes(path).is_ok_and(is_setup) {
        true => Ok(()),
        false => Err(unreplaced(path, "already exists and is not a setup")),
    }
}

/// That `path` stays as it is, since it is `what`.
pub fn unreplaced(path: &Path, what: &str) -> InputError {
    InputError::new(ErrorCode::FileNotWritten, &name_of(path), 0, what, "name another file to write")
}
