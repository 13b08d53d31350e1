//! The flank planning job that window and command line share.

use std::sync::Arc;

use super::JobError;
use super::flank_check::{PlanCheck, WheelPlanner};
use super::flank_preparation::{Preparation, for_plunges};
use super::part_cache::PartCache;
use crate::flank::choice::ChannelSpace;
use crate::flank::{FlankError, FlankMove, FlankPlan, FlankStages, plan};
use crate::io::flank_file::{ShownWall, shown_walls};
use crate::io::tool_library::flank_cutters;
use crate::machine::{MachineClock, MachineTime};
use crate::monitor::Monitor;
use crate::part::{Impeller, Workpiece};
use crate::plunge::sections::keep_needed_tools;
use crate::setup::{Setup, Tool};
use crate::toolpath::{ClProgram, Travel};
use crate::verify::{Fault, FlankVerdict, time_of_channels_s};

/// Request for a flank plan.
#[derive(Clone, Debug)]
pub struct FlankRequest {
    /// The part.
    pub part: Arc<Impeller>,
    /// The setup as given by the user.
    pub setup: Setup,
}

/// Result of a [`FlankRequest`].
#[derive(Clone, Debug)]
pub struct FlankOutcome {
    /// The part that was planned, with its blank.
    pub workpiece: Arc<Workpiece>,
    /// The setup with the cutter filled in.
    pub setup: Setup,
    /// The tools of the setup as given.
    pub given_tools: Vec<Tool>,
    /// The space in the channel for which the cutter was chosen.
    pub space: ChannelSpace,
    /// Whether the stock above the shroud needs plunges, with a tool of the setup or of the library.
    pub needs_opening: bool,
    /// The plan.
    pub plan: FlankPlan,
    /// Faults that `verify` finds in the plan's program; empty unless a faulty move could not be removed.
    pub faults: Vec<Fault>,
    /// The other findings of `verify`; `None` if the program cannot be verified.
    pub verdict: Option<FlankVerdict>,
    /// What tells the time of programs on the machine of the setup, if it gives one.
    pub clock: Option<MachineClock>,
    /// Time of the program on that machine; `None` without one, and where it cannot run the program.
    pub machine_time: Option<MachineTime>,
    /// Estimated time of the program, s: feed rates and rapids, without tool changes and accelerations.
    pub time_estimate: f64,
    /// Time of the program of all channels in the order of the setup, s: on that machine, or estimated where
    /// there is none; `None` where the machine cannot run it.
    pub wheel_time_s: Option<f64>,
    /// How often a tool is loaded in it.
    pub wheel_tool_loads: usize,
    /// Wall-clock time of the job, s.
    pub elapsed: f64,
}

impl FlankOutcome {
    /// The outcome of the finished `plan` for `request`, which `check` has judged.
    fn new(
        request: &FlankRequest,
        prepared: &Preparation,
        plan: FlankPlan,
        check: &mut PlanCheck,
        monitor: &Monitor,
    ) -> Result<Self, JobError> {
        let Preparation { workpiece, clock, chosen, .. } = prepared;
        let part = &workpiece.part;
        let written = plan.in_one_channel(&part.name);
        let program = written.program();
        let machine_time = clock.as_ref().and_then(|clock| clock.time(&program));
        let wheel = written.in_channels(part, &workpiece.blank, &prepared.setup, part.blade_count, monitor);
        let wheel = wheel.map_err(FlankError::Cancelled)?.program;
        let wheel_time_s = match (clock, machine_time) {
            (Some(clock), Some(_)) => clock.time(&wheel).map(|time| time.total_s),
            _ => Some(Travel::from_program(&wheel).time),
        };
        let verdict = check.verdict(&program, monitor).map_err(FlankError::Cancelled)?;
        let mut setup = prepared.setup.clone();
        if !setup.tools.contains(&chosen.tool) {
            setup.tools.push(chosen.tool.clone());
        }
        setup.flank.tool = Some(chosen.tool.number);
        keep_needed_tools(&mut setup, prepared.opener.as_ref().map(|opener| opener.tool.number));
        Ok(Self {
            workpiece: Arc::clone(workpiece),
            setup,
            given_tools: request.setup.tools.clone(),
            space: prepared.space,
            needs_opening: prepared.needs_opening,
            plan,
            faults: check.take_faults(),
            verdict,
            clock: clock.clone(),
            machine_time,
            time_estimate: Travel::from_program(&program).time,
            wheel_time_s,
            wheel_tool_loads: wheel.tool_loads(),
            elapsed: 0.0,
        })
    }

    /// The program of the plan, with the plunges that open the stock before the passes.
    pub fn program(&self) -> ClProgram {
        self.plan.in_one_channel(&self.workpiece.part.name).program()
    }
}

impl From<FlankError> for JobError {
    fn from(error: FlankError) -> Self {
        match error {
            FlankError::Cancelled(_) => Self::Cancelled,
            FlankError::Setup(fault) => fault.into(),
        }
    }
}

/// Flank planner with a cache of the last plan's stages, so that only stale stages are computed again.
#[derive(Debug, Default)]
pub struct FlankJob {
    last: PartCache<FlankStages>,
}

impl FlankJob {
    /// Plans one channel.
    ///
    /// ```no_run
    /// use vanecut::{job::flank::{FlankJob, FlankRequest}, monitor::Monitor, setup::Setup};
    /// # let part = vanecut::io::part_file::read_part("assets/parts/pump6.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let request = FlankRequest { setup: Setup::for_part(&part), part: part.into() };
    /// let outcome = FlankJob::default().run(&request, &Monitor::default())?;
    /// assert!(outcome.faults.is_empty() && !outcome.plan.moves.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`JobError::Cancelled`] after a stop or cancel of `monitor`; [`JobError::Setup`] when part and setup
    /// are incompatible.
    pub fn run(&self, request: &FlankRequest, monitor: &Monitor) -> Result<FlankOutcome, JobError> {
        self.run_for_channels(request, 1, monitor)
    }

    /// Plans one channel such that the program of the first `channels` channels has no faults either: the
    /// grid of the stock that `verify` looks at differs from channel to channel.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_for_channels(
        &self,
        request: &FlankRequest,
        channels: usize,
        monitor: &Monitor,
    ) -> Result<FlankOutcome, JobError> {
        let (outcome, _) = self.run_then(request, channels, monitor, |_, _| Ok(()))?;
        Ok(outcome)
    }

    /// As [`Self::run_for_channels`]. For several channels `then` gets the outcome and the verifier of the
    /// planner, which has judged the program of all of them as the last one.
    ///
    /// # Errors
    /// As [`Self::run`], and those of `then`.
    pub(super) fn run_then<T>(
        &self,
        request: &FlankRequest,
        channels: usize,
        monitor: &Monitor,
        then: impl FnOnce(&FlankOutcome, WheelPlanner) -> Result<T, JobError>,
    ) -> Result<(FlankOutcome, Option<T>), JobError> {
        let started = std::time::Instant::now();
        let prepared = Preparation::new(&request.part, &request.setup)?;
        let mut check = PlanCheck::new(&prepared, &request.setup, channels);
        let planned = self.last.with(&request.part, |stages| {
            let Preparation { workpiece, chosen, opener, .. } = &prepared;
            let mut faults =
                |tool: &Tool, moves: &[FlankMove], monitor: &Monitor| check.faults(tool, moves, monitor);
            plan(workpiece, &request.setup, chosen, opener.is_some(), stages, &mut faults, monitor)
        });
        let plan = check.finished(planned?, monitor)?;
        let mut outcome = FlankOutcome::new(request, &prepared, plan, &mut check, monitor)?;
        let result = check.into_wheel_planner().map(|planner| then(&outcome, planner)).transpose()?;
        outcome.elapsed = started.elapsed().as_secs_f64();
        Ok((outcome, result))
    }
}

impl FlankOutcome {
    /// The best known time of the program, s: on the machine of the setup, or else the estimate.
    pub fn time_s(&self) -> f64 {
        self.machine_time.map_or(self.time_estimate, |time| time.total_s)
    }

    /// The same for the first `count` channels, in the order of the setup; `None` where that of all of them
    /// is not known.
    pub fn time_of_channels_s(&self, count: usize) -> Option<f64> {
        let channels = self.workpiece.part.blade_count;
        self.wheel_time_s.map(|wheel| time_of_channels_s([self.time_s(), wheel], count, channels))
    }

    /// Whether its cutter was chosen from the library although the setup has tools: none of them suits.
    pub fn has_library_cutter(&self) -> bool {
        !self.given_tools.is_empty() && !self.given_tools.contains(&self.plan.tool)
    }

    /// Whether its cutter would be chosen again for a `setup` that may have other tools.
    pub fn would_choose_from(&self, setup: &Setup) -> bool {
        let chosen = || self.space.choose_tool(setup, flank_cutters());
        let same = || chosen().is_ok_and(|chosen| chosen.tool.cuts_like(&self.plan.tool));
        Tool::cut_alike(&self.given_tools, &setup.tools) || same()
    }

    /// Whether plunges would open the channel with the same tool for a `setup` that may have other tools, or
    /// none are needed.
    pub fn would_open_with(&self, setup: &Setup) -> bool {
        // A tool of the library gets a number that none of the setup has.
        let numbers = |tools: &[Tool]| tools.iter().map(|tool| tool.number).collect::<Vec<_>>();
        let (was, is) = (&self.given_tools, &setup.tools);
        let has_own = for_plunges(is).next().is_some();
        !self.needs_opening
            || Tool::cut_alike(for_plunges(was), for_plunges(is)) && (has_own || numbers(was) == numbers(is))
    }

    /// Largest overcut below the blade allowance, mm: of the program if it can be verified, else of the
    /// positions along the walls.
    pub fn max_overcut(&self) -> f64 {
        self.verdict.as_ref().map_or_else(|| self.plan.max_overcut(), |verdict| verdict.max_overcut)
    }

    /// Most stock left above the blade allowance, mm: by the program if it can be verified, else by the
    /// positions along the walls.
    pub fn max_undercut(&self) -> f64 {
        self.verdict.as_ref().map_or_else(|| self.plan.max_undercut(), |verdict| verdict.max_undercut)
    }

    /// The walls as they are displayed, to which these figures belong.
    pub fn shown_walls(&self) -> Vec<ShownWall> {
        shown_walls(&self.plan, self.verdict.as_ref())
    }
}
