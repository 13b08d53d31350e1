//! The planning job that window and command line share: request in, result out, progress and
//! cancel between.

pub mod summary;
pub mod worker;

use std::sync::Arc;

pub use summary::Summary;

use crate::monitor::Monitor;
use crate::part::{AxisPolicy, Channel, Impeller, Setup};
use crate::plunge::sections::{SetupFault, resolve};
use crate::plunge::{PlanError, Planner, PlungePlan};
use crate::residual::{
    FloorGrid, FloorSource, ResidualField, cutters_of, residual_field, stretches_of_setup,
};

/// What to plan.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// The part.
    pub part: Arc<Impeller>,
    /// The setup as the programmer gave it.
    pub setup: Setup,
    /// Policy of the result ("after"); "before" is always conventional.
    pub policy: AxisPolicy,
    /// Cells of the residual field along s and λ.
    pub field_cells: usize,
}

/// A plan with what it leaves.
#[derive(Clone, Debug)]
pub struct PolicyResult {
    /// The plan.
    pub plan: PlungePlan,
    /// Stock left on the hub after all positions.
    pub field: ResidualField,
    /// The numbers that decide.
    pub summary: Summary,
}

/// Result of a [`PlanRequest`].
#[derive(Clone, Debug)]
pub struct PlanOutcome {
    /// The part that was planned.
    pub part: Arc<Impeller>,
    /// The setup with everything that was chosen by default filled in (tools, sections).
    pub setup: Setup,
    /// Floor grid both fields stand on.
    pub grid: Arc<FloorGrid>,
    /// Conventional plan.
    pub before: PolicyResult,
    /// Plan by the policy asked for.
    pub after: PolicyResult,
    /// Wall time of the work, s.
    pub elapsed: f64,
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JobError {
    /// Cancelled; keep the last good result.
    #[error("cancelled")]
    Cancelled,
    /// The part and the setup do not go together: what, and what to do.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<PlanError> for JobError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(_) => Self::Cancelled,
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// Plans one channel. The one way to a plan for window and command line alike.
///
/// # Errors
/// [`JobError::Cancelled`] soon after `monitor` is told so; [`JobError::Setup`] when part and setup
/// do not go together.
pub fn run(request: &PlanRequest, monitor: &Monitor) -> Result<PlanOutcome, JobError> {
    let started = std::time::Instant::now();
    let part = &request.part;
    let channel = Channel::of(part);
    let setup = resolve(&request.setup, part, &channel)?;
    let planner = Planner::new(part, &channel, &setup);
    monitor.report(0.05);
    let conventional = || planner.plan(AxisPolicy::Conventional, monitor);
    let asked = || match request.policy {
        AxisPolicy::Conventional => Ok(None),
        policy => planner.plan(policy, monitor).map(Some),
    };
    let floor = || {
        let cutters = stretches_of_setup(&setup);
        let (blank, stock) = (planner.blank(), &setup.stock);
        let source = FloorSource { part, channel: &channel, blank, stock, cutters: &cutters };
        FloorGrid::new(&source, request.field_cells)
    };
    let with_floor = || -> Result<(PlungePlan, FloorGrid), PlanError> {
        let plan = conventional()?;
        monitor.check()?;
        Ok((plan, floor()))
    };
    let (before, after) = rayon::join(with_floor, asked);
    let ((before, grid), after) = (before?, after?);
    let measured = |plan: PlungePlan| -> Result<PolicyResult, JobError> {
        monitor.check().map_err(|_| JobError::Cancelled)?;
        Ok(with_field(plan, &grid))
    };
    let before = measured(before)?;
    let after = match after {
        Some(plan) => measured(plan)?,
        None => before.clone(),
    };
    monitor.report(1.0);
    let elapsed = started.elapsed().as_secs_f64();
    Ok(PlanOutcome { part: part.clone(), grid: Arc::new(grid), before, after, elapsed, setup })
}

/// Adds to a plan what it leaves on the hub.
fn with_field(plan: PlungePlan, grid: &FloorGrid) -> PolicyResult {
    let field = residual_field(grid, &cutters_of(&plan));
    let summary = Summary::of(&plan, grid, &field);
    PolicyResult { plan, field, summary }
}
