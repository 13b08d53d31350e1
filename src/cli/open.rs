//! Opening what the command line names.

use std::io::Read;
use std::path::Path;

use super::Failure;
use crate::formats::part_file::read_part;
use crate::formats::setup_file::{read_setup, read_setup_bytes};
use crate::part::{Impeller, PartDescription, Setup};

/// Most bytes taken from standard input.
const MAX_INPUT: u64 = 64 * 1024 * 1024;

/// Reads, trims and checks a part.
pub fn part(path: &Path) -> Result<(PartDescription, Impeller), Failure> {
    let description = read_part(path)?;
    let part = Impeller::build(&description).map_err(|e| {
        let line = if e.line > 0 { format!(":{}", e.line) } else { String::new() };
        Failure::Input(format!("{}{line}: {}; {}", path.display(), e.what, e.cure))
    })?;
    Ok((description, part))
}

/// Reads a setup; none given means the defaults.
pub fn setup(path: Option<&Path>) -> Result<Setup, Failure> {
    match path {
        None => Ok(Setup::default()),
        Some(path) if path == Path::new("-") => Ok(read_setup_bytes("standard input", &standard_input()?)?),
        Some(path) => Ok(read_setup(path)?),
    }
}

/// All of standard input.
pub fn standard_input() -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .take(MAX_INPUT)
        .read_to_end(&mut bytes)
        .map_err(|e| Failure::Input(format!("standard input cannot be read ({e}); give a file")))?;
    Ok(bytes)
}
