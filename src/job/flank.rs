//! The flank planning job that window and command line share.

use std::sync::Arc;

use super::JobError;
use super::part_cache::PartCache;
use crate::flank::choice::choose_tool;
use crate::flank::fault_removal::MoveFault;
use crate::flank::{FlankError, FlankMove, FlankPlan, FlankStages, plan};
use crate::io::apt::{read_apt_bytes, write_apt};
use crate::io::tool_library::flank_cutters;
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, Workpiece};
use crate::plunge::sections::check_part;
use crate::setup::{Setup, Tool};
use crate::toolpath::ClProgram;
use crate::verify::{Fault, FaultKind, FlankVerdict, FlankVerifier};

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
    /// The plan.
    pub plan: FlankPlan,
    /// Faults that `verify` finds in the plan's program; empty unless a faulty move could not be removed.
    pub faults: Vec<Fault>,
    /// The other findings of `verify`; `None` if the program cannot be verified.
    pub verdict: Option<FlankVerdict>,
    /// Wall-clock time of the job, s.
    pub elapsed: f64,
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
    /// # Errors
    /// [`JobError::Cancelled`] after a stop or cancel of `monitor`; [`JobError::Setup`] when part and setup
    /// are incompatible.
    pub fn run(&self, request: &FlankRequest, monitor: &Monitor) -> Result<FlankOutcome, JobError> {
        let started = std::time::Instant::now();
        let part = &request.part;
        check_part(&request.setup, part)?;
        let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(part)));
        let chosen = choose_tool(&workpiece, &request.setup, flank_cutters())?;
        let mut verifier = FlankVerifier::new(&workpiece, &request.setup);
        let mut faults = Vec::new();
        let mut check = |tool: &Tool, moves: &[FlankMove], monitor: &Monitor| {
            faults_as_written(&mut verifier, &part.name, tool, moves, &mut faults, monitor)
        };
        let plan = self
            .last
            .with(part, |stages| plan(&workpiece, &request.setup, &chosen, stages, &mut check, monitor))?;
        let verdict =
            program_as_written(&part.name, &plan.tool, &plan.moves).and_then(|p| verifier.verdict(&p).ok());
        let mut setup = request.setup.clone();
        if !setup.tools.contains(&chosen.tool) {
            setup.tools.push(chosen.tool.clone());
        }
        setup.flank.tool = Some(chosen.tool.number);
        let elapsed = started.elapsed().as_secs_f64();
        Ok(FlankOutcome { workpiece, setup, plan, faults, verdict, elapsed })
    }
}

impl FlankOutcome {
    /// Largest overcut below the blade allowance, mm: of the program if it can be verified, else of the
    /// positions along the walls.
    pub fn max_overcut(&self) -> f64 {
        self.verdict.as_ref().map_or_else(|| self.plan.max_overcut(), |verdict| verdict.max_overcut)
    }
}

/// The program of `moves`, written and read back; `None` if it cannot be read.
fn program_as_written(name: &str, tool: &Tool, moves: &[FlankMove]) -> Option<ClProgram> {
    let written = write_apt(&ClProgram::of_flank(name, tool, moves));
    read_apt_bytes("flank.apt", written.as_bytes()).ok()
}

/// Verifies the program of `moves` as written: stores all faults in `found`, and returns those of single
/// moves.
fn faults_as_written(
    verifier: &mut FlankVerifier,
    name: &str,
    tool: &Tool,
    moves: &[FlankMove],
    found: &mut Vec<Fault>,
    monitor: &Monitor,
) -> Result<Vec<MoveFault>, Cancelled> {
    let all = |why: &'static str| (0..moves.len()).map(|index| MoveFault { index, why }).collect();
    let Some(program) = program_as_written(name, tool, moves) else {
        return Ok(all("its program cannot be read back"));
    };
    let Ok(faults) = verifier.faults(&program, monitor) else {
        return Ok(all("its program cannot be verified"));
    };
    *found = faults?;
    let move_fault = |fault: &Fault| {
        let index = program.moves.partition_point(|m| m.line < fault.line);
        Some(MoveFault { index, why: fault_reason(fault.kind)? })
    };
    Ok(found.iter().filter_map(move_fault).collect())
}

/// Why a move with a fault is left out, as text for users; `None` for faults that do not concern a single
/// move.
fn fault_reason(kind: FaultKind) -> Option<&'static str> {
    Some(match kind {
        FaultKind::HubAllowance => "the cutter would come too near to the hub",
        FaultKind::BladeAllowance => "the cutter would come too near to a blade",
        FaultKind::ShankCollision => "the shank would come too near to the part",
        FaultKind::HolderCollision => "the holder would meet a blade or the hub",
        FaultKind::HolderInStock => "the holder would meet uncut stock",
        FaultKind::RapidClearance | FaultKind::RapidInStock | FaultKind::ToolInBlank => {
            "no rapid above the blank reaches it"
        }
        FaultKind::AxisTilt => "the tilt exceeds the limit of the machine",
        FaultKind::AxisTurn => "the axis would turn too far in one move",
        FaultKind::AxisLimit => "an axis of the machine would pass its limit",
        FaultKind::TooDeep => "the cut would be too deep in one pass",
        FaultKind::CoreContact => "the core of the cutter would plunge into uncut stock",
        FaultKind::NoFeed
        | FaultKind::SpindleStopped
        | FaultKind::CutsNothing
        | FaultKind::ToolDiffers
        | FaultKind::NotJudged => return None,
    })
}
