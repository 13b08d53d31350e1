//! What a planning job is asked, and what it finds.

use std::sync::Arc;

use crate::error::UserError;
use crate::monitor::Cancelled;
use crate::part::{Impeller, Workpiece};
use crate::plunge::{EditReport, PlanError, PlungePlan, RowDensity};
use crate::setup::{AxisPolicy, Goal, PlungeEdit, Setup, SetupFault};
use crate::stock::{FloorGrid, InaccessibleFloor, ResidualField, field_cutters, residual_field, statistics};
use crate::tradeoff::PlanClock;
use crate::verify::Summary;

/// Request for a plunge plan.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// The part.
    pub part: Arc<Impeller>,
    /// The setup as given by the user.
    pub setup: Setup,
    /// Axis policy of the result ("after"); "before" is always conventional.
    pub policy: AxisPolicy,
    /// Whether the other policies are also planned, for comparison.
    pub compare: bool,
    /// Cells of the residual field along s and λ.
    pub field_cells: usize,
}

/// A plan with its residual stock.
#[derive(Clone, Debug)]
pub struct PolicyResult {
    /// The plan.
    pub plan: PlungePlan,
    /// Residual stock on the channel floor after all positions.
    pub field: ResidualField,
    /// Summary figures of the plan.
    pub summary: Summary,
}

/// Result of a [`PlanRequest`].
#[derive(Clone, Debug)]
pub struct PlanOutcome {
    /// The part that was planned, with its blank.
    pub workpiece: Arc<Workpiece>,
    /// The setup with the default choices (tools, sections) filled in.
    pub setup: Setup,
    /// Why each section was chosen; `None` for sections given by the setup.
    pub reasons: Vec<Option<String>>,
    /// Floor grid of all fields.
    pub grid: Arc<FloorGrid>,
    /// What makes floor inaccessible, whichever the policy, the largest share first.
    pub inaccessible_floor: Vec<InaccessibleFloor>,
    /// Conventional plan.
    pub before: PolicyResult,
    /// Plan by the requested policy and goal.
    pub after: PolicyResult,
    /// The plan of `minimal` before plunges were left out for the goal and before edits; `None` where neither
    /// changed it, or it was not planned.
    pub whole: Option<PlungePlan>,
    /// The plan of `minimal` with fewer rows, if the goal needed it.
    pub sparse: Option<Arc<PlungePlan>>,
    /// How closely the rows of the plan of `minimal` lie that the goal chose.
    pub density: RowDensity,
    /// Whether no plan of `minimal` meets the goal; `after` comes nearest.
    pub misses_goal: bool,
    /// Plans by the other policies, if requested.
    pub others: Vec<PolicyResult>,
    /// What the edits of the setup did to the plan `after`; the other plans are as they were found.
    pub edits: EditReport,
    /// The edits of the setup whose locked plunges `after` was planned around; empty where the planner places
    /// all of them by itself.
    pub kept_locked: Vec<PlungeEdit>,
    /// What tells the time of plans: on the machine of the setup, if it gives one.
    pub clock: Arc<PlanClock>,
    /// Wall-clock time of the job, s.
    pub elapsed: f64,
}

impl PlanOutcome {
    /// Time that semi-finishing takes for what `result`, one of the results of this outcome, leaves in a
    /// channel, s; `None` where the goal does not count it.
    pub fn finishing_time_s(&self, result: &PolicyResult) -> Option<f64> {
        let Goal::Total { finishing } = self.setup.plunge.goal else { return None };
        let left = statistics(&self.grid, &result.field.heights, |_| true);
        let excess = left.excess_above(self.setup.allowances.hub_allowance);
        Some(finishing.time_s(excess.volume, excess.p95))
    }

    /// The result of every planned policy, in the order of [`AxisPolicy::ALL`].
    pub fn policies(&self) -> Vec<&PolicyResult> {
        // The requested plan first: with edits it differs from the one before even by the same policy.
        let all = || [&self.after, &self.before].into_iter().chain(&self.others);
        AxisPolicy::ALL.iter().filter_map(|policy| all().find(|r| r.plan.policy == *policy)).collect()
    }
}

/// Why a job has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JobError {
    /// Cancelled without a result; the caller keeps its last good one.
    #[error("cancelled")]
    Cancelled,
    /// Part and setup are incompatible: the fault and what to do about it.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<JobError> for UserError {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Cancelled => Cancelled.into(),
            JobError::Setup(fault) => fault.into(),
        }
    }
}

impl From<PlanError> for JobError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(_) => Self::Cancelled,
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// Computes the residual stock and the summary of a plan.
pub(super) fn measure_residual(plan: PlungePlan, grid: &FloorGrid, clock: &PlanClock) -> PolicyResult {
    let field = residual_field(grid, &field_cutters(&plan));
    let machine_time = clock.machine_time(&plan);
    let is_refused = clock.timing().is_some() && machine_time.is_none();
    let summary = Summary { machine_time, is_refused, ..Summary::from_plan(&plan, grid, &field) };
    PolicyResult { plan, field, summary }
}
