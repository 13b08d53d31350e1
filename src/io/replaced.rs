//! What a file that is written must not replace: what it is made of, and files of another kind.

use std::path::Path;

use super::InputError;
use super::setup_file::looks_like_setup;
use super::shop_tools::{LibraryFormat, is_absent, looks_like_library};
use super::source::{is_same_file, read_bytes};
use super::write::not_replaced;

/// Checks that `output` is none of the `inputs` that it is made of. Inputs that are not given are `None`;
/// names that are no files do not count.
///
/// # Errors
/// When it is one of them.
pub fn check_is_no_input(output: &Path, inputs: &[Option<&Path>]) -> Result<(), InputError> {
    match inputs.iter().flatten().any(|input| input.is_file() && is_same_file(input, output)) {
        true => Err(not_replaced(output, "is the input file")),
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
        false => Err(not_replaced(path, "already exists and is not a setup")),
    }
}
