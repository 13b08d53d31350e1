//! How long a plan takes: on a machine by all of its axes, without one by feed rates and rapids alone.

use crate::machine::{
    BlankSize, MachineProgram, MachineTime, MachineTool, MotionOptions, OutputKind, PlacedPart, SectionTime,
    machine_program, section_times,
};
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::plunge::{PlungePlan, Position};
use crate::setup::AllowanceSetup;
use crate::toolpath::{ClProgram, RAPID_MM_PER_MIN, Travel};

/// Decimals of rotary positions, degrees: as the posts write them.
const ANGLE_DECIMALS: usize = 4;

/// Tells the time of plans of one part. The default knows no machine.
#[derive(Clone, Debug, Default)]
pub struct PlanClock {
    machine: Option<PlacedMachine>,
}

/// A machine with the part on it.
#[derive(Clone, Debug)]
struct PlacedMachine {
    machine: MachineTool,
    placed: PlacedPart,
    blank: BlankSize,
    /// Rate of the slower rotary axis, rad/s.
    turn_rad_per_s: f64,
}

impl PlanClock {
    /// The clock of `workpiece` on `machine`, as the machine file lays it.
    pub fn on_machine(machine: MachineTool, workpiece: &Workpiece, allowances: &AllowanceSetup) -> Self {
        let placed = PlacedPart::of(&machine.part, &workpiece.part);
        let blank = BlankSize::of(&workpiece.part, allowances);
        let turn_rad_per_s =
            machine.rotary.iter().map(|axis| axis.rapid_rad_per_s).fold(f64::INFINITY, f64::min);
        Self { machine: Some(PlacedMachine { machine, placed, blank, turn_rad_per_s }) }
    }

    /// The machine.
    pub fn machine(&self) -> Option<&MachineTool> {
        self.machine.as_ref().map(|on| &on.machine)
    }

    /// The motion of `program`, of the same part, on the machine with tips and rotary positions as `post` chooses
    /// them; `None` without a machine, and where it cannot run the whole program.
    pub fn motion(&self, program: &ClProgram) -> Option<MachineProgram> {
        let PlacedMachine { machine, placed, blank, .. } = self.machine.as_ref()?;
        let options = MotionOptions {
            blank: Some(*blank),
            ..MotionOptions::new(OutputKind::TcpAngles, ANGLE_DECIMALS)
        };
        machine_program(machine, placed, program, &options, &Monitor::default()).ok()
    }

    /// Times of the sections of `plan` on the machine, in cutting order; `None` as for [`Self::motion`].
    pub fn section_times(&self, plan: &PlungePlan) -> Option<Vec<SectionTime>> {
        let machine = self.machine()?;
        let program = ClProgram::of_plan("", plan);
        Some(section_times(machine, &program, &self.motion(&program)?))
    }

    /// Time of `plan` on the machine; see [`Self::section_times`].
    pub fn machine_time(&self, plan: &PlungePlan) -> Option<MachineTime> {
        self.section_times(plan).map(|times| MachineTime::of_sections(&times))
    }

    /// Time of `plan`, s: on the machine if it can run the plan, else without accelerations and tool changes.
    pub fn time_s(&self, plan: &PlungePlan) -> f64 {
        match self.machine_time(plan) {
            Some(time) => time.total_s,
            None => Travel::of(&ClProgram::of_plan("", plan)).time,
        }
    }

    /// Rate of links, mm/min.
    pub(super) fn link_rate(&self) -> f64 {
        self.machine.as_ref().map_or(RAPID_MM_PER_MIN, |on| on.machine.links.rate)
    }

    /// Time of the link between two positions, s, by the slower of its way and its turn; those that leave the part
    /// take longer.
    pub(super) fn link_s(&self, from: &Position, to: &Position) -> f64 {
        let way = (from.evaluation.retract - to.evaluation.retract).norm() / self.link_rate() * 60.0;
        let turn = |on: &PlacedMachine| from.axis.angle(&to.axis) / on.turn_rad_per_s;
        self.machine.as_ref().map_or(way, |on| way.max(turn(on)))
    }
}
