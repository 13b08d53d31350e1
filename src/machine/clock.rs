//! The time of programs of one part on one machine.

use super::clear::BlankSize;
use super::fault::MotionFault;
use super::model::MachineTool;
use super::motion::{MachineProgram, MotionOptions, machine_program};
use super::placement::PlacedPart;
use super::time::{MachineTime, SectionTime, move_clock, section_times};
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::setup::AllowanceSetup;
use crate::toolpath::ClProgram;

/// Decimals of rotary positions, degrees: as the posts write them.
const ANGLE_DECIMALS: usize = 4;

/// A machine with the part on it, as the machine file places it. It tells the time of programs as `post` does
/// that writes them with the output of the machine file.
#[derive(Clone, Debug)]
pub struct MachineClock {
    machine: MachineTool,
    placed: PlacedPart,
    blank: BlankSize,
}

impl MachineClock {
    /// The clock of `workpiece` on `machine`.
    pub fn new(machine: MachineTool, workpiece: &Workpiece, allowances: &AllowanceSetup) -> Self {
        let placed = PlacedPart::from_placement(&machine.part, &workpiece.part);
        let blank = BlankSize::from_part(&workpiece.part, allowances);
        Self { machine, placed, blank }
    }

    /// The machine.
    pub fn machine(&self) -> &MachineTool {
        &self.machine
    }

    /// The motion of `program`, of the same part.
    ///
    /// # Errors
    /// [`MotionFault`] when the machine cannot run the whole program.
    pub fn motion(&self, program: &ClProgram) -> Result<MachineProgram, MotionFault> {
        let Self { machine, placed, blank } = self;
        let options =
            MotionOptions { blank: Some(*blank), ..MotionOptions::new(machine.output, ANGLE_DECIMALS) };
        machine_program(machine, placed, program, &options, &Monitor::default())
    }

    /// Times of the sections of `program`, in cutting order; `None` where the machine cannot run it.
    pub fn section_times(&self, program: &ClProgram) -> Option<Vec<SectionTime>> {
        Some(section_times(&self.machine, program, &self.motion(program).ok()?))
    }

    /// Time from the start of `program` to the end of each of its moves, s; `None` where the machine cannot
    /// run it.
    pub fn move_clock(&self, program: &ClProgram) -> Option<Vec<f64>> {
        Some(move_clock(&self.machine, program, &self.motion(program).ok()?))
    }

    /// Time of `program`; `None` where the machine cannot run it.
    pub fn time(&self, program: &ClProgram) -> Option<MachineTime> {
        self.section_times(program).map(|times| MachineTime::of_sections(&times))
    }
}
