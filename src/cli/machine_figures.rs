//! What `vanecut plan` and `vanecut verify` say of a program on its machine: the time by all axes, and their
//! travel.

use serde_json::{Map, Value, json};

use crate::cli::output::{number, rotary_travel};
use crate::io::program_file::NcMachine;
use crate::job::machine_run::MachineRun;
use crate::machine::{
    BlankSize, MachineClock, MachineProgram, MachineTime, MachineTool, SectionTime, section_times,
};
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::setup::Setup;
use crate::toolpath::ClProgram;

/// Figures of a program on its machine.
pub(super) struct MachineFigures<'a> {
    machine: &'a MachineTool,
    /// Times by section and travel of both rotary axes (rad); `None` where the machine cannot run the
    /// program.
    run: Option<(Vec<SectionTime>, [f64; 2])>,
}

impl<'a> MachineFigures<'a> {
    /// The figures by the rotary positions that the program names; where it leaves them to the control, by
    /// those that `post` would choose.
    pub(super) fn of_program(
        on_machine: &'a NcMachine,
        program: &ClProgram,
        workpiece: &Workpiece,
        setup: &Setup,
    ) -> Self {
        let blank = BlankSize::from_part(&workpiece.part, &setup.allowances);
        let run = MachineRun::as_read(on_machine, program, blank, &Monitor::default()).ok();
        Self::of_motion(&on_machine.machine, program, run.map(|run| run.motion).as_ref())
    }

    /// The figures of a planned program by the rotary positions that `post` would choose.
    pub(super) fn of_plan(clock: &'a MachineClock, program: &ClProgram) -> Self {
        Self::of_motion(clock.machine(), program, clock.motion(program).ok().as_ref())
    }

    /// Keys of `--json` for a plan with `setup`; none where it names no machine. `figures`: those of its
    /// machine, `None` where that is not known.
    pub(super) fn keys_of(figures: Option<&Self>, setup: &Setup) -> Map<String, Value> {
        match (figures, &setup.machine.file) {
            (Some(figures), _) => figures.keys(),
            (None, Some(_)) => Self::no_keys(),
            (None, None) => Map::new(),
        }
    }

    /// A line of text for a plan with `setup`; see [`Self::keys_of`].
    pub(super) fn text_of(figures: Option<&Self>, setup: &Setup) -> String {
        match (figures, &setup.machine.file) {
            (Some(figures), _) => figures.text(),
            (None, Some(file)) => {
                format!("the machine file {file} is gone: times are those without a machine\n")
            }
            (None, None) => String::new(),
        }
    }

    fn of_motion(machine: &'a MachineTool, program: &ClProgram, motion: Option<&MachineProgram>) -> Self {
        let run = motion.map(|motion| (section_times(machine, program, motion), motion.rotary_travel));
        Self { machine, run }
    }

    /// Time of the program with its tool changes, s; NaN where it is not known.
    fn time_s(&self) -> f64 {
        self.run.as_ref().map_or(f64::NAN, |(times, _)| MachineTime::of_sections(times).total_s)
    }

    /// Keys of `--json`.
    pub(super) fn keys(&self) -> Map<String, Value> {
        let mut map = Map::new();
        map.insert("machine".into(), json!(self.machine.name));
        map.insert("machine_time".into(), number(self.time_s()));
        let travel = self.run.as_ref().map(|(_, travel)| rotary_travel(self.machine, *travel));
        map.insert("rotary_travel".into(), travel.unwrap_or_default());
        map
    }

    /// The same where the machine is not known.
    pub(super) fn no_keys() -> Map<String, Value> {
        ["machine", "machine_time", "rotary_travel"]
            .map(|key| (key.to_owned(), Value::Null))
            .into_iter()
            .collect()
    }

    /// A line of text.
    pub(super) fn text(&self) -> String {
        let name = &self.machine.name;
        let Some((times, travel)) = &self.run else {
            return format!(
                "on {name}: no rotary positions run the whole program, so its time is not known\n"
            );
        };
        let minutes = |of: fn(&SectionTime) -> f64| times.iter().map(of).sum::<f64>() / 60.0;
        let [first, second] =
            [0, 1].map(|i| format!("{} turns {:.0}°", self.machine.rotary[i].letter, travel[i].to_degrees()));
        format!(
            "on {name} {:.1} min with accelerations: {:.1} under feed, {:.1} in links, {:.1} for tool changes; \
             {first}, {second}\n",
            self.time_s() / 60.0,
            minutes(|time| time.feed_s),
            minutes(|time| time.links_s),
            minutes(|time| time.tool_change_s),
        )
    }
}
