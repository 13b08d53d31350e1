//! How long a plan takes: on a machine by all of its axes, without one by feed rates and rapids alone.

use crate::machine::{MachineClock, MachineTime, MachineTool, SectionTime};
use crate::plunge::{PlungePlan, Position};
use crate::toolpath::{ClProgram, RAPID_MM_PER_MIN, Travel};

/// Tells the time of plans of one part. The default knows no machine.
#[derive(Clone, Debug, Default)]
pub struct PlanClock {
    machine: Option<MachineClock>,
    /// Whether the machine cannot run the plan that was asked for: then no plan is timed on it.
    refuses: bool,
}

impl PlanClock {
    /// The clock of plans on a machine; `None`: on none that is known.
    pub fn new(machine: Option<MachineClock>) -> Self {
        Self { machine, refuses: false }
    }

    /// The machine.
    pub fn machine(&self) -> Option<&MachineTool> {
        self.on_machine().map(MachineClock::machine)
    }

    /// The clock of the machine, whether plans are timed on it or not.
    pub fn on_machine(&self) -> Option<&MachineClock> {
        self.machine.as_ref()
    }

    /// The machine on which plans are timed.
    pub fn timing(&self) -> Option<&MachineClock> {
        self.machine.as_ref().filter(|_| !self.refuses)
    }

    /// The clock once the machine has refused the plan that was asked for: times of all plans are then given
    /// without it, so that they can be compared.
    pub fn after_refusal(&self) -> Self {
        Self { machine: self.machine.clone(), refuses: true }
    }

    /// Times of the sections of `plan` on the machine, in cutting order; `None` without a machine, and where
    /// it cannot run the whole plan.
    pub fn section_times(&self, plan: &PlungePlan) -> Option<Vec<SectionTime>> {
        self.timing()?.section_times(&ClProgram::of_plan("", plan))
    }

    /// Time of `plan` on the machine; see [`Self::section_times`].
    pub fn machine_time(&self, plan: &PlungePlan) -> Option<MachineTime> {
        self.section_times(plan).map(|times| MachineTime::of_sections(&times))
    }

    /// Time from the start of the program of `plan` to the end of each plunge, s: on the machine, where that
    /// can run it, else without accelerations and tool changes.
    pub fn plunge_clock(&self, plan: &PlungePlan) -> Vec<f64> {
        let program = ClProgram::of_plan("", plan);
        let on_machine = self.timing().and_then(|machine| machine.move_clock(&program));
        program.at_plunge_ends(&on_machine.unwrap_or_else(|| Travel::clock(&program)))
    }

    /// Time of `program`, s: on the machine, or `None` where it cannot run that; without a machine without
    /// accelerations and tool changes.
    pub fn program_time_s(&self, program: &ClProgram) -> Option<f64> {
        match self.timing() {
            Some(machine) => machine.time(program).map(|time| time.total_s),
            None => Some(Travel::from_program(program).time),
        }
    }

    /// Time of `plan`, s: on the machine, where one that it cannot run takes for ever; without a machine
    /// without accelerations and tool changes.
    pub fn time_s(&self, plan: &PlungePlan) -> f64 {
        match self.timing() {
            Some(_) => self.machine_time(plan).map_or(f64::INFINITY, |time| time.total_s),
            None => Travel::from_program(&ClProgram::of_plan("", plan)).time,
        }
    }

    /// Rate of links, mm/min.
    pub(super) fn link_rate(&self) -> f64 {
        self.machine().map_or(RAPID_MM_PER_MIN, |machine| machine.links.rate)
    }

    /// Time of the link between two positions, s: the longer of that of its length and that of the angle
    /// between the tool axes at the rate of the slower rotary axis. Links that leave the part take longer.
    pub(super) fn link_s(&self, from: &Position, to: &Position) -> f64 {
        let along = (from.evaluation.retract - to.evaluation.retract).norm() / self.link_rate() * 60.0;
        let turning = |machine: &MachineTool| {
            let [a, b] = machine.rotary.each_ref().map(|axis| axis.rapid_rad_per_s);
            from.axis.angle(&to.axis) / a.min(b)
        };
        self.machine().map_or(along, |machine| along.max(turning(machine)))
    }
}
