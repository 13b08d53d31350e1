//! Programs of any kind: APT, or NC code that was posted for a machine.

use std::path::Path;

use super::InputError;
use super::apt::read_apt_bytes;
use super::machine_file::read_machine;
use super::nc::{AxisOverrun, ReadContext, is_apt, read_nc, read_post};
use super::tool_library::{flank_cutters, plunge_cutters};
use crate::error::ErrorCode;
use crate::machine::{MachineTool, MoveAngles, PlacedPart};
use crate::part::Impeller;
use crate::setup::{Setup, Tool};
use crate::toolpath::ClProgram;
use crate::verify::{Fault, FaultKind};

/// For what an NC program was posted.
#[derive(Clone, Copy, Debug)]
pub struct NcTarget<'a> {
    /// Name of a machine, or its file.
    pub machine: &'a Path,
    /// Control; `None`: that of the machine.
    pub control: Option<&'a str>,
}

/// A program as it was read.
#[derive(Clone, Debug)]
pub struct ProgramReading {
    /// The program, in the part frame.
    pub program: ClProgram,
    /// Positions beyond the limits of an axis, as faults; of APT there are none.
    pub overruns: Vec<Fault>,
    /// The machine that NC code was read for; `None` for APT.
    pub on_machine: Option<NcMachine>,
}

/// The machine of an NC program, with what the program says of its axes.
#[derive(Clone, Debug)]
pub struct NcMachine {
    /// The machine.
    pub machine: MachineTool,
    /// How the part lies on it.
    pub placed: PlacedPart,
    /// Rotary positions, one for each move.
    pub angles: Vec<MoveAngles>,
}

/// Reads the program `bytes` of file `name` for `part`: APT, or with a `target` the NC code that was posted
/// for it. Tools of NC code are those of `setup`, or else of the library.
///
/// # Errors
/// When the program is not valid, or machine or control are not known.
pub fn read_program_bytes(
    name: &str,
    bytes: &[u8],
    target: Option<NcTarget<'_>>,
    part: &Impeller,
    setup: &Setup,
) -> Result<ProgramReading, InputError> {
    let Some(target) = target.filter(|_| !is_apt(bytes)) else {
        let program = read_apt_bytes(name, bytes).map_err(|error| match error.code {
            // Without a word of APT it may be NC code, which says nothing without its machine.
            ErrorCode::NothingMoves | ErrorCode::AptStatement if !is_apt(bytes) => InputError {
                help: "give an APT program, or NC code with the --machine it is posted for".to_owned(),
                ..error
            },
            _ => error,
        })?;
        return Ok(ProgramReading { program, overruns: Vec::new(), on_machine: None });
    };
    let machine = read_machine(target.machine)?;
    let post = read_post(target.control.unwrap_or(&machine.control))?;
    let library = [plunge_cutters(), flank_cutters()].concat();
    let tools: Vec<Tool> = setup.tools.iter().chain(&library).cloned().collect();
    let placed = PlacedPart::from_placement(&machine.part, part);
    let context = ReadContext { machine: &machine, placed, tools: &tools };
    let reading = read_nc(name, bytes, post.dialect, &context)?;
    let overruns = reading.overruns.iter().map(overrun_fault).collect();
    let on_machine = Some(NcMachine { machine, placed, angles: reading.angles });
    Ok(ProgramReading { program: reading.program, overruns, on_machine })
}

/// The fault of a position beyond the limits of an axis.
fn overrun_fault(overrun: &AxisOverrun) -> Fault {
    let AxisOverrun { line, letter, value, limits: (low, high) } = overrun;
    let message = format!("{letter}{value:.3} is beyond the limits {low:.1} … {high:.1} of the axis");
    Fault {
        line: *line,
        kind: FaultKind::AxisLimit,
        value: Some(*value),
        message,
        help: String::new(),
        overhang: None,
    }
}
