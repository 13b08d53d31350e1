//! The planning job that window and command line share: request in, result out, progress and
//! cancel between.

pub mod worker;

use std::sync::Arc;

use crate::monitor::Monitor;
use crate::part::{AxisPolicy, Impeller, Setup};
use crate::plunge::PlungePlan;
use crate::residual::{FloorGrid, ResidualField};

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

/// Numbers of one plan, or of one section of it (mm; f64::NAN where there is nothing to measure).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of positions.
    pub positions: usize,
    /// Positions whose core meets stock.
    pub interferential: usize,
    /// Deepest contact.
    pub max_contact_depth: f64,
    /// Residual layer over the cut floor.
    pub residual_mean: f64,
    /// 95th percentile.
    pub residual_p95: f64,
    /// Greatest.
    pub residual_max: f64,
    /// Share of the floor no position reaches.
    pub uncut_share: f64,
    /// Least distance of the cutter to the finished hub.
    pub min_hub_clearance: f64,
    /// Least distance of the cutter to the finished blades.
    pub min_blade_clearance: f64,
    /// Least distance of the bottom at the retract point to the blank.
    pub min_retract_clearance: f64,
    /// Largest angle between neighbouring axes of a row, rad.
    pub max_axis_change: f64,
    /// Length under plunge feed, mm.
    pub cut_length: f64,
    /// Length in rapid, mm.
    pub rapid_length: f64,
    /// Time estimate, s.
    pub time_estimate: f64,
    /// Positions the blades block.
    pub blocked: usize,
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
    #[error("{what}; {cure}")]
    Setup {
        /// What is wrong.
        what: String,
        /// What to do about it.
        cure: String,
    },
}

/// Plans one channel. The one way to a plan for window and command line alike.
pub fn run(_request: &PlanRequest, _monitor: &Monitor) -> Result<PlanOutcome, JobError> {
    todo!()
}
