//! Reads the files named on the command line.

use std::io::Read;
use std::path::Path;

use super::Failure;
use super::args::MeshArgs;
use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::part_file::{check_part_format, read_part_with};
use crate::io::setup_file::{line_of_place, locate_machine, read_setup_with_defaults};
use crate::io::source::{MAX_PROGRAM_BYTES, name_of, read_bytes_up_to};
use crate::part::{Impeller, PartDescription};
use crate::setup::{Setup, SetupFault};

/// How messages name standard input.
const STANDARD_INPUT: &str = "standard input";

/// Checks that a file that is to be converted is there, and by its extension a part or a plan.
///
/// # Errors
/// [`Failure::input`] when it is not.
pub fn check_is_input(path: &Path) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return Ok(());
    }
    Ok(check_part_format(path)?)
}

/// Reads and builds a part, and prints its notes to stderr.
///
/// # Errors
/// [`Failure::input`] when the file cannot be read or does not describe an impeller.
pub fn part(path: &Path, mesh: &MeshArgs) -> Result<(PartDescription, Impeller), Failure> {
    let description = read_part_with(path, &mesh.options())?;
    let part = Impeller::build(&description)
        .map_err(|error| InputError::of_part(&path.display().to_string(), error))?;
    for note in &part.notes {
        eprintln!("vanecut: {}: {note}", path.display());
    }
    Ok((description, part))
}

/// The failure of a command that shall read both setup and program from standard input.
pub fn both_from_standard_input() -> Failure {
    let what = "standard input cannot be both setup and program";
    Failure::input(ErrorCode::Arguments, what, "give one as a file")
}

/// A setup with its source, for error messages.
pub struct OpenSetup {
    /// The setup.
    pub setup: Setup,
    /// Name for messages; that of the part if there is no setup file.
    name: String,
    bytes: Vec<u8>,
    /// The machine file as the setup names it; that of `setup` is located.
    machine_file: Option<String>,
}

impl OpenSetup {
    /// `setup`, made of this one, as it is stored in a plan: the machine file is named as it was given, since
    /// a plan is also read elsewhere.
    pub fn as_stored(&self, setup: &Setup) -> Setup {
        let mut stored = setup.clone();
        stored.machine.file.clone_from(&self.machine_file);
        stored
    }

    /// The failure for a setup fault found while planning, with the line of the setup file.
    pub fn failure(&self, fault: SetupFault) -> Failure {
        let line = line_of_place(&self.bytes, &fault.place);
        Failure::from(UserError::from(fault)).at_line(&self.name, line)
    }
}

/// Reads the setup for `part`, which was read from `part_path`. Without a path the part's defaults are used;
/// `-` reads standard input.
///
/// # Errors
/// [`Failure::input`] when the setup cannot be read or is invalid.
pub fn setup(path: Option<&Path>, part_path: &Path, part: &Impeller) -> Result<OpenSetup, Failure> {
    let defaults = Setup::for_part(part);
    let Some(path) = path else {
        let name = part_path.display().to_string();
        return Ok(OpenSetup { setup: defaults, name, bytes: Vec::new(), machine_file: None });
    };
    let (name, bytes) = named_bytes(path)?;
    let mut setup = read_setup_with_defaults(&name, &bytes, &defaults)?;
    let machine_file = setup.machine.file.clone();
    locate_machine(&mut setup, path)?;
    let opened = OpenSetup { setup, name, bytes, machine_file };
    opened.setup.allowances.check_blank(part).map_err(|fault| opened.failure(fault))?;
    Ok(opened)
}

/// Name for messages and bytes of a file, or of standard input for `-`.
///
/// # Errors
/// [`Failure::input`] when it cannot be read.
pub fn named_bytes(path: &Path) -> Result<(String, Vec<u8>), Failure> {
    if path != Path::new("-") {
        return Ok((name_of(path), read_bytes_up_to(path, MAX_PROGRAM_BYTES)?));
    }
    let mut bytes = Vec::new();
    // One byte over the limit, so that the reader can report that the input is too large.
    std::io::stdin().lock().take(MAX_PROGRAM_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(|error| {
        let what = format!("cannot be read ({error})");
        Failure::input(ErrorCode::FileUnreadable, what, "give a file").at(STANDARD_INPUT)
    })?;
    Ok((STANDARD_INPUT.to_owned(), bytes))
}
