//! The flank planning job that window and command line share.

use std::sync::Arc;

use super::JobError;
use super::machine::clock_of;
use super::part_cache::PartCache;
use crate::flank::channels::{FlankChannel, FlankChannels};
use crate::flank::choice::ChannelSpace;
use crate::flank::fault_removal::MoveFault;
use crate::flank::path::Times;
use crate::flank::{
    FlankError, FlankMove, FlankOpening, FlankPlan, FlankStages, MoveKind, UncutReason, plan,
};
use crate::io::apt::{read_apt_bytes, write_apt};
use crate::io::flank_file::{ShownWall, shown_walls};
use crate::io::tool_library::{flank_cutters, plunge_cutters};
use crate::machine::{MachineClock, MachineTime, MachineTool};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, Workpiece};
use crate::plunge::choice::choose_opening;
use crate::plunge::choice::times::MoveTimes;
use crate::plunge::sections::{check_part, keep_needed_tools};
use crate::plunge::{PlanError, Planner};
use crate::setup::{Setup, Tool};
use crate::toolpath::{ClProgram, Travel};
use crate::verify::{Fault, FaultKind, FlankVerdict, FlankVerifier, VerifyError};

/// Step of the plunges above the shroud, in radii of the cutter for the passes: the stairs that they leave on
/// a steep shroud are in the way of its holder.
const OPENING_STEP_RADII: f64 = 0.5;

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
        let part = &request.part;
        check_part(&request.setup, part)?;
        let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(part)));
        let clock = clock_of(&request.setup, &workpiece)?;
        let space = ChannelSpace::from_workpiece(&workpiece, &request.setup.allowances);
        let chosen = space.choose_tool(&request.setup, flank_cutters())?;
        let machine = clock.as_ref().map(MachineClock::machine);
        let opener = Opener::from_part(part, &request.setup, &chosen.tool, machine);
        let needs_opening = opener.is_some() || {
            let from_library = Setup { tools: Vec::new(), ..request.setup.clone() };
            Opener::from_part(part, &from_library, &chosen.tool, machine).is_some()
        };
        let is_opened = opener.is_some();
        let mut setup = request.setup.clone();
        let more =
            opener.iter().map(|opener| &opener.tool).filter(|tool| !request.setup.tools.contains(tool));
        setup.tools.extend(more.cloned());
        let judged = setup.clone();
        let mut verifier = FlankVerifier::for_planner(&workpiece, &judged);
        let mut wheel_verifier = (channels > 1).then(|| FlankVerifier::for_planner(&workpiece, &judged));
        let mut judged_last = JudgedProgram::default();
        let mut retracts_in_stock = Vec::new();
        let mut opening = None;
        let mut check = |tool: &Tool, moves: &[FlankMove], monitor: &Monitor| {
            // Of the moves before any is left out: those that remain need no more.
            if let (Some(opener), None) = (&opener, &opening) {
                opening = opener.opening(&workpiece, tool, moves, monitor)?;
            }
            let program = FlankChannel { part_name: &part.name, tool, moves, opening: opening.as_ref() };
            let found =
                faults_as_written(&mut verifier, &program, &request.setup, &mut judged_last, monitor)?;
            let Some(wheel) = wheel_verifier.as_mut().filter(|_| found.is_empty()) else { return Ok(found) };
            let several = program.in_channels(part, &workpiece.blank, &request.setup, channels, monitor)?;
            let judged = faults_of_channels(wheel, &several, &program, &request.setup, monitor)?;
            retracts_in_stock = judged.retracts_in_stock;
            Ok(judged.faults)
        };
        let planned = self.last.with(part, |stages| {
            plan(&workpiece, &request.setup, &chosen, is_opened, stages, &mut check, monitor)
        });
        let mut plan = FlankPlan { opening, ..planned? };
        let grazing = std::mem::take(&mut judged_last.grazing);
        if let Some(slower) = plan.with_retracts_under_feed(&grazing) {
            // Where it would have faults of its own, the retract stays what is none.
            let written = slower.in_one_channel(&part.name);
            let mut judged = JudgedProgram::default();
            let found = faults_as_written(&mut verifier, &written, &request.setup, &mut judged, monitor);
            found.map_err(FlankError::Cancelled)?;
            if judged.faults.len() <= judged_last.faults.len() {
                (plan, judged_last) = (slower, judged);
            }
        }
        let written = plan.in_one_channel(&part.name);
        let program = written.program();
        let machine_time = clock.as_ref().and_then(|clock| clock.time(&program));
        let time_estimate = Travel::from_program(&program).time;
        let wheel = written.in_channels(part, &workpiece.blank, &setup, part.blade_count, monitor);
        let wheel = wheel.map_err(FlankError::Cancelled)?.program;
        let wheel_time_s = match (&clock, machine_time) {
            (Some(clock), Some(_)) => clock.time(&wheel).map(|time| time.total_s),
            _ => Some(Travel::from_program(&wheel).time),
        };
        let verdict = match as_written(&program).map(|p| verifier.verdict(&p, &monitor.silent())) {
            Some(Err(VerifyError::Cancelled(_))) => return Err(JobError::Cancelled),
            Some(verdict) => verdict.ok(),
            None => None,
        };
        if !setup.tools.contains(&chosen.tool) {
            setup.tools.push(chosen.tool.clone());
        }
        setup.flank.tool = Some(chosen.tool.number);
        keep_needed_tools(&mut setup, opener.as_ref().map(|opener| opener.tool.number));
        let mut outcome = FlankOutcome {
            workpiece: Arc::clone(&workpiece),
            setup,
            given_tools: request.setup.tools.clone(),
            space,
            needs_opening,
            plan,
            faults: judged_last.faults,
            verdict,
            clock,
            machine_time,
            time_estimate,
            wheel_time_s,
            wheel_tool_loads: wheel.tool_loads(),
            elapsed: 0.0,
        };
        let planner = wheel_verifier.map(|verifier| WheelPlanner { verifier, retracts_in_stock });
        let result = planner.map(|planner| then(&outcome, planner)).transpose()?;
        outcome.elapsed = started.elapsed().as_secs_f64();
        Ok((outcome, result))
    }
}

impl FlankOutcome {
    /// The best known time of the program, s: on the machine of the setup, or else the estimate.
    pub fn time_s(&self) -> f64 {
        self.machine_time.map_or(self.time_estimate, |time| time.total_s)
    }

    /// Whether its cutter was chosen from the library although the setup has tools: none of them suits.
    pub fn has_library_cutter(&self) -> bool {
        !self.given_tools.is_empty() && !self.given_tools.contains(&self.plan.tool)
    }

    /// Whether its cutter would be chosen again for a `setup` that may have other tools.
    pub fn would_choose_from(&self, setup: &Setup) -> bool {
        let same = || self.space.choose_tool(setup, flank_cutters()).is_ok_and(|c| c.tool == self.plan.tool);
        self.given_tools == setup.tools || same()
    }

    /// Whether plunges would open the channel with the same tool for a `setup` that may have other tools, or
    /// none are needed.
    pub fn would_open_with(&self, setup: &Setup) -> bool {
        // A tool of the library gets a number that none of the setup has.
        let numbers = |tools: &[Tool]| tools.iter().map(|tool| tool.number).collect::<Vec<_>>();
        let (was, is) = (&self.given_tools, &setup.tools);
        let has_own = for_plunges(is).next().is_some();
        !self.needs_opening
            || for_plunges(was).eq(for_plunges(is)) && (has_own || numbers(was) == numbers(is))
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

/// Those of `tools` that plunges take: of those with a round bottom a plunge leaves much.
fn for_plunges(tools: &[Tool]) -> impl Iterator<Item = &Tool> {
    tools.iter().filter(|tool| tool.is_flat() && !tool.is_tapered())
}

/// What removes the stock above the shroud before the passes.
struct Opener {
    /// Its tool, whose number no other tool of the setup has.
    tool: Tool,
    /// A setup with one section, which opens the blank.
    setup: Setup,
}

impl Opener {
    /// The opener for passes with `tool`; `None` where the blank hardly stands above the shroud.
    fn from_part(part: &Impeller, setup: &Setup, tool: &Tool, machine: Option<&MachineTool>) -> Option<Self> {
        let own: Vec<Tool> = for_plunges(&setup.tools).cloned().collect();
        let from = if own.is_empty() { plunge_cutters() } else { &own };
        let mut setup = setup.clone();
        let step = OPENING_STEP_RADII * tool.radius();
        setup.plunge.step = Some(setup.plunge.step.map_or(step, |given| given.min(step)));
        let setup = &setup;
        let mut section = choose_opening(setup, from, part, tool, None, MoveTimes::on(machine))?.section;
        let mut opener = from.iter().find(|tool| tool.number == section.tool)?.clone();
        if own.is_empty() {
            let numbers = setup.tools.iter().map(|tool| tool.number);
            opener.number = numbers.chain([tool.number]).max().unwrap_or(0) + 1;
        }
        section.tool = opener.number;
        let mut setup = Setup { tools: vec![opener.clone()], ..setup.clone() };
        setup.plunge.sections = vec![section];
        Some(Self { tool: opener, setup })
    }

    /// The plunges that `moves` of `tool` need.
    ///
    /// # Errors
    /// When cancelled.
    fn opening(
        &self,
        workpiece: &Workpiece,
        tool: &Tool,
        moves: &[FlankMove],
        monitor: &Monitor,
    ) -> Result<Option<FlankOpening>, Cancelled> {
        let poses =
            moves.iter().filter(|step| step.kind != MoveKind::Rapid).map(|step| (step.tip, step.axis));
        let planned = Planner::new(workpiece, &self.setup).opening_for(tool, poses, monitor);
        let plan = match planned {
            Err(PlanError::Cancelled(cancelled)) => return Err(cancelled),
            Err(PlanError::Setup(_)) => return Ok(None),
            Ok(plan) => plan,
        };
        let plunges = plan.positions.iter().map(|p| (p.evaluation.retract, p.tip, p.axis)).collect();
        Ok(Some(FlankOpening { tool: self.tool.clone(), plunges }))
    }
}

/// A program, written and read back; `None` if it cannot be read.
pub(super) fn as_written(program: &ClProgram) -> Option<ClProgram> {
    read_apt_bytes("flank.apt", write_apt(program).as_bytes()).ok()
}

/// What a planner knows of a program of several channels.
pub(super) struct WheelPlanner<'a> {
    /// It has judged the program in standing stock.
    pub verifier: FlankVerifier<'a>,
    /// Moves of the passes that retract in rapid, and meet stock in some channel.
    pub retracts_in_stock: Vec<usize>,
}

/// What the verifier says of a program of several channels, by moves of the passes of one.
#[derive(Default)]
struct JudgedChannels {
    faults: Vec<MoveFault>,
    /// See [`WheelPlanner::retracts_in_stock`].
    retracts_in_stock: Vec<usize>,
}

/// What the verifier says of a program of one channel.
#[derive(Default)]
struct JudgedProgram {
    /// Its faults.
    faults: Vec<Fault>,
    /// Moves of its passes that touch standing stock in rapid hardly less than what is a fault.
    grazing: Vec<usize>,
}

/// Verifies a program as it is written: stores what it finds in `judged`, and returns the faults of single
/// moves of its passes.
fn faults_as_written(
    verifier: &mut FlankVerifier,
    written: &FlankChannel,
    setup: &Setup,
    judged: &mut JudgedProgram,
    monitor: &Monitor,
) -> Result<Vec<MoveFault>, Cancelled> {
    let count = written.moves.len();
    let all = |message: &'static str| {
        let why = UncutReason::new(message);
        (0..count).map(|index| MoveFault { index, why, overcut: None, overhang: None }).collect()
    };
    let Some(program) = as_written(&written.program()) else {
        return Ok(all("its program cannot be read back"));
    };
    judged.faults = match verifier.faults(&program, monitor) {
        Ok(faults) => faults,
        Err(VerifyError::Cancelled(cancelled)) => return Err(cancelled),
        Err(VerifyError::Program(_)) => return Ok(all("its program cannot be verified")),
    };
    let before = program.moves.len() - count;
    let index = |line: usize| program.moves.partition_point(|m| m.line < line).checked_sub(before);
    judged.grazing = verifier.grazing_rapids().iter().filter_map(|&line| index(line)).collect();
    Ok(judged.faults.iter().filter_map(|fault| move_fault(fault, index(fault.line)?, setup)).collect())
}

/// The faults of the program of several channels, as those of the moves of the passes of one, `channel`.
/// Retracts that meet stock are not among them: the program is written with such ones under feed.
fn faults_of_channels(
    verifier: &mut FlankVerifier,
    several: &FlankChannels,
    channel: &FlankChannel,
    setup: &Setup,
    monitor: &Monitor,
) -> Result<JudgedChannels, Cancelled> {
    let Some(program) = as_written(&several.program) else { return Ok(JudgedChannels::default()) };
    let found = match verifier.faults(&program, monitor) {
        Ok(faults) => faults,
        Err(VerifyError::Cancelled(cancelled)) => return Err(cancelled),
        Err(VerifyError::Program(_)) => return Ok(JudgedChannels::default()),
    };
    let index_of = |line: usize| {
        let index = program.moves.partition_point(|m| m.line < line);
        channel.index_of_pass(several.origins.get(index).copied().flatten()?.index)
    };
    let mut faults: Vec<MoveFault> = Vec::new();
    let mut retracts_in_stock: Vec<usize> =
        verifier.grazing_rapids().iter().filter_map(|&line| index_of(line)).collect();
    for fault in &found {
        let Some(index) = index_of(fault.line) else { continue };
        let grazes = fault.kind == FaultKind::RapidInStock && is_retract(channel.moves, index);
        if grazes {
            retracts_in_stock.push(index);
        }
        let known = faults.iter().any(|known| known.index == index);
        faults.extend(move_fault(fault, index, setup).filter(|_| !grazes && !known));
    }
    faults.sort_by_key(|fault| fault.index);
    Ok(JudgedChannels { faults, retracts_in_stock })
}

impl FlankPlan {
    /// The plan with those of the moves `rapids` that are retracts made at the feed rate of their pass;
    /// `None` where there are none.
    pub(super) fn with_retracts_under_feed(&self, rapids: &[usize]) -> Option<Self> {
        let mut retracts = rapids.iter().filter(|&&index| is_retract(&self.moves, index)).peekable();
        retracts.peek()?;
        let mut plan = self.clone();
        for &index in retracts {
            let feed_mm_per_min = plan.moves[index - 1].feed_mm_per_min;
            plan.moves[index] = FlankMove { kind: MoveKind::Link, feed_mm_per_min, ..plan.moves[index] };
        }
        plan.times = Times::from_moves(&plan.moves);
        Some(plan)
    }
}

/// Whether move `index` is a retract along the axis, in rapid, from where the tool has cut.
fn is_retract(moves: &[FlankMove], index: usize) -> bool {
    let Some([.., from, to]) = moves.get(..=index) else { return false };
    from.kind != MoveKind::Rapid && to.kind == MoveKind::Rapid && from.axis == to.axis
}

/// The fault of move `index` of the passes; `None` for a fault that does not concern a single move.
fn move_fault(fault: &Fault, index: usize, setup: &Setup) -> Option<MoveFault> {
    let is_overcut = fault.kind == FaultKind::BladeAllowance;
    let overcut = fault.value.filter(|_| is_overcut).map(|near| setup.allowances.blade_allowance - near);
    Some(MoveFault { index, why: fault_reason(fault.kind)?, overcut, overhang: fault.overhang })
}

/// Why a move with a fault is left out; `None` for faults that do not concern a single
/// move.
fn fault_reason(kind: FaultKind) -> Option<UncutReason> {
    Some(match kind {
        FaultKind::HubAllowance => UncutReason::new("the cutter would come too near to the hub"),
        FaultKind::BladeAllowance => UncutReason::new("the cutter would come too near to a blade"),
        FaultKind::ShankCollision => UncutReason::shank("the shank would come too near to the part"),
        FaultKind::HolderCollision => UncutReason::holder("the holder would meet a blade or the hub"),
        FaultKind::HolderInStock => UncutReason::holder("the holder would meet uncut stock"),
        FaultKind::RapidClearance | FaultKind::RapidInStock | FaultKind::ToolInBlank => {
            UncutReason::new("no rapid above the blank reaches it")
        }
        FaultKind::AxisTilt => UncutReason::new("the tilt exceeds the limit of the machine"),
        FaultKind::AxisTurn => UncutReason::new("the axis would turn too far in one move"),
        FaultKind::AxisLimit => UncutReason::new("an axis of the machine would pass its limit"),
        FaultKind::TooDeep => UncutReason::new("the cut would be too deep in one pass"),
        FaultKind::CoreContact => UncutReason::new("the core of the cutter would plunge into uncut stock"),
        FaultKind::NoFeed
        | FaultKind::SpindleStopped
        | FaultKind::CutsNothing
        | FaultKind::ToolDiffers
        | FaultKind::NotJudged => return None,
    })
}
