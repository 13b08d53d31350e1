//! The check of a flank plan while it is made: what `verify` says of its program as it is written, of one
//! channel and of several.

use super::flank_preparation::Preparation;
use crate::flank::channels::{FlankChannel, FlankChannels};
use crate::flank::fault_removal::MoveFault;
use crate::flank::path::Times;
use crate::flank::{FlankError, FlankMove, FlankOpening, FlankPlan, MoveKind, UncutReason};
use crate::io::apt::as_written;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::setup::{Setup, Tool};
use crate::toolpath::ClProgram;
use crate::verify::{Fault, FaultKind, FlankVerdict, FlankVerifier, VerifyError};

/// Name of the program in messages.
pub(super) const NAME: &str = "flank.apt";

/// What a planner knows of a program of several channels.
pub(super) struct WheelPlanner<'a> {
    /// It has judged the program in standing stock.
    pub verifier: FlankVerifier<'a>,
    /// Moves of the passes that retract in rapid, and meet stock in some channel.
    pub retracts_in_stock: Vec<usize>,
}

/// The check of the plans of one request.
pub(super) struct PlanCheck<'a> {
    prepared: &'a Preparation,
    /// The setup as given.
    setup: &'a Setup,
    /// Number of channels whose program has to be free of faults, too.
    channels: usize,
    verifier: FlankVerifier<'a>,
    /// The verifier of the program of several channels.
    wheel_verifier: Option<FlankVerifier<'a>>,
    opening: Option<FlankOpening>,
    /// What was found in the last program of one channel.
    judged: JudgedProgram,
    /// See [`WheelPlanner::retracts_in_stock`].
    retracts_in_stock: Vec<usize>,
}

impl<'a> PlanCheck<'a> {
    /// A check of plans for `setup`, of the program of one channel and, if there are more, of `channels`.
    pub(super) fn new(prepared: &'a Preparation, setup: &'a Setup, channels: usize) -> Self {
        let verifier = || FlankVerifier::for_planner(&prepared.workpiece, &prepared.setup);
        Self {
            prepared,
            setup,
            channels,
            verifier: verifier(),
            wheel_verifier: (channels > 1).then(verifier),
            opening: None,
            judged: JudgedProgram::default(),
            retracts_in_stock: Vec::new(),
        }
    }

    /// The faults of single `moves` of passes with `tool`.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub(super) fn faults(
        &mut self,
        tool: &Tool,
        moves: &[FlankMove],
        monitor: &Monitor,
    ) -> Result<Vec<MoveFault>, Cancelled> {
        let Workpiece { part, blank, .. } = &*self.prepared.workpiece;
        // Of the moves before any is left out: those that remain need no more.
        if let (Some(opener), None) = (&self.prepared.opener, &self.opening) {
            self.opening = opener.opening(&self.prepared.workpiece, tool, moves, monitor)?;
        }
        self.lead_opening_to(tool, moves, monitor)?;
        let program = FlankChannel { part_name: &part.name, tool, moves, opening: self.opening.as_ref() };
        let (verifier, judged) = (&mut self.verifier, &mut self.judged);
        let found = faults_as_written(verifier, &program, self.setup, judged, monitor)?;
        let Some(wheel) = self.wheel_verifier.as_mut().filter(|_| found.is_empty()) else {
            return Ok(found);
        };
        let several = program.in_channels(part, blank, self.setup, self.channels, monitor)?;
        let judged = faults_of_channels(wheel, &several, &program, self.setup, monitor)?;
        self.retracts_in_stock = judged.retracts_in_stock;
        Ok(judged.faults)
    }

    fn lead_opening_to(
        &mut self,
        tool: &Tool,
        moves: &[FlankMove],
        monitor: &Monitor,
    ) -> Result<(), Cancelled> {
        let near = (&self.prepared.workpiece.blank, self.setup.allowances.safety_distance);
        self.opening.as_mut().map_or(Ok(()), |opening| opening.lead_to(moves, tool, near, monitor))
    }

    /// The plan of the last moves, with its opening, and under feed where a rapid would graze stock.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub(super) fn finished(&mut self, plan: FlankPlan, monitor: &Monitor) -> Result<FlankPlan, FlankError> {
        self.lead_opening_to(&plan.tool, &plan.moves, monitor)?;
        let plan = FlankPlan { opening: self.opening.take(), ..plan };
        let grazing = std::mem::take(&mut self.judged.grazing);
        let Some(slower) = plan.with_retracts_under_feed(&grazing) else { return Ok(plan) };
        // Where it would have faults of its own, the retract stays what is none.
        let written = slower.in_one_channel(&self.prepared.workpiece.part.name);
        let mut judged = JudgedProgram::default();
        faults_as_written(&mut self.verifier, &written, self.setup, &mut judged, monitor)?;
        if judged.faults.len() > self.judged.faults.len() {
            return Ok(plan);
        }
        self.judged = judged;
        Ok(slower)
    }

    /// What `verify` finds in the `program` of the finished plan; `None` if it cannot be verified.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub(super) fn verdict(
        &mut self,
        program: &ClProgram,
        monitor: &Monitor,
    ) -> Result<Option<FlankVerdict>, Cancelled> {
        let Ok(written) = as_written(NAME, program) else { return Ok(None) };
        match self.verifier.verdict(&written, &monitor.silent()) {
            Err(VerifyError::Cancelled(cancelled)) => Err(cancelled),
            verdict => Ok(verdict.ok()),
        }
    }

    /// The faults of the finished plan; the check is without them then.
    pub(super) fn take_faults(&mut self) -> Vec<Fault> {
        std::mem::take(&mut self.judged.faults)
    }

    /// What is known of the program of several channels; `None` for one.
    pub(super) fn into_wheel_planner(self) -> Option<WheelPlanner<'a>> {
        let retracts_in_stock = self.retracts_in_stock;
        self.wheel_verifier.map(|verifier| WheelPlanner { verifier, retracts_in_stock })
    }
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
    let Ok(program) = as_written(NAME, &written.program()) else {
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
    let Ok(program) = as_written(NAME, &several.program) else { return Ok(JudgedChannels::default()) };
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
        FaultKind::HolderInStock => {
            UncutReason::holder("the holder would meet stock that other passes leave")
        }
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
