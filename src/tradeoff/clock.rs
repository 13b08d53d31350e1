//! How long a plan takes: on a machine by all of its axes, without one by feed rates and rapids alone.

use crate::machine::{
    BlankSize, MachineProgram, MachineTime, MachineTool, MotionOptions, PlacedPart, SectionTime,
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
    /// Whether the machine cannot run the plan that was asked for: then no plan is timed on it.
    refuses: bool,
}

impl PlanClock {
    /// The clock of `workpiece` on `machine`, in the position that the machine file gives.
    pub fn on_machine(machine: MachineTool, workpiece: &Workpiece, allowances: &AllowanceSetup) -> Self {
        let placed = PlacedPart::of(&machine.part, &workpiece.part);
        let blank = BlankSize::of(&workpiece.part, allowances);
        Self { machine: Some(PlacedMachine { machine, placed, blank, refuses: false }) }
    }

    /// The machine.
    pub fn machine(&self) -> Option<&MachineTool> {
        self.machine.as_ref().map(|on| &on.machine)
    }

    /// The machine on which plans are timed.
    fn timing(&self) -> Option<&PlacedMachine> {
        self.machine.as_ref().filter(|on| !on.refuses)
    }

    /// The clock once the machine has refused the plan that was asked for: times of all plans are then told without
    /// it, so that they can be compared.
    pub fn after_refusal(&self) -> Self {
        let machine = self.machine.clone();
        Self { machine: machine.map(|on| PlacedMachine { refuses: true, ..on }) }
    }

    /// The motion of `program`, of the same part, on the machine as `post` makes it with the output of the machine
    /// file; `None` without a machine, and where it cannot run the whole program.
    pub fn motion(&self, program: &ClProgram) -> Option<MachineProgram> {
        let PlacedMachine { machine, placed, blank, .. } = self.timing()?;
        let options =
            MotionOptions { blank: Some(*blank), ..MotionOptions::new(machine.output, ANGLE_DECIMALS) };
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

    /// Time of `plan`, s: on the machine, where one that it cannot run takes for ever; without a machine without
    /// accelerations and tool changes.
    pub fn time_s(&self, plan: &PlungePlan) -> f64 {
        match self.timing() {
            Some(_) => self.machine_time(plan).map_or(f64::INFINITY, |time| time.total_s),
            None => Travel::of(&ClProgram::of_plan("", plan)).time,
        }
    }

    /// Rate of links, mm/min.
    pub(super) fn link_rate(&self) -> f64 {
        self.machine.as_ref().map_or(RAPID_MM_PER_MIN, |on| on.machine.links.rate)
    }

    /// Time of the link between two positions, s: the longer of that of its length and that of the angle between
    /// the tool axes at the rate of the slower rotary axis. Links that leave the part take longer.
    pub(super) fn link_s(&self, from: &Position, to: &Position) -> f64 {
        let along = (from.evaluation.retract - to.evaluation.retract).norm() / self.link_rate() * 60.0;
        let turning = |on: &PlacedMachine| {
            let [a, b] = on.machine.rotary.each_ref().map(|axis| axis.rapid_rad_per_s);
            from.axis.angle(&to.axis) / a.min(b)
        };
        self.machine.as_ref().map_or(along, |on| along.max(turning(on)))
    }
}
