//! Intermediate results that a planning job reports while it runs.

use std::sync::Arc;

use super::outcome::PolicyResult;
use crate::part::Workpiece;
use crate::plunge::{PlungePlan, Unevaluated};
use crate::setup::Setup;
use crate::stock::{FieldCutter, FloorGrid, field_cutters};

/// An intermediate result of a planning job.
#[derive(Clone, Debug)]
pub enum PlanStage {
    /// The setup is complete.
    Resolved {
        /// See [`super::PlanOutcome::workpiece`].
        workpiece: Arc<Workpiece>,
        /// See [`super::PlanOutcome::setup`].
        setup: Setup,
        /// See [`super::PlanOutcome::reasons`].
        reasons: Vec<Option<String>>,
    },
    /// Plan of a policy with all positions placed.
    Placed(PlungePlan<Unevaluated>),
    /// Preview of the requested policy, evaluated: the axes of the last plan fitted to the new setup (warm
    /// start), available long before the search ends.
    Preview(PlungePlan),
    /// Plan of a policy with contact, clearances and retracts evaluated.
    Evaluated(PlungePlan),
    /// The same plan with its residual stock on the floor grid.
    Measured(Arc<FloorGrid>, PolicyResult),
}

impl PlanStage {
    /// The plunges of the stage, if it has a plan.
    pub fn cutters(&self) -> Option<Vec<FieldCutter>> {
        match self {
            Self::Resolved { .. } => None,
            Self::Placed(plan) => Some(field_cutters(plan)),
            Self::Preview(plan) | Self::Evaluated(plan) => Some(field_cutters(plan)),
            Self::Measured(_, result) => Some(field_cutters(&result.plan)),
        }
    }
}

/// Optional callback for job stages. It is called from any thread, but never concurrently for the same
/// policy.
#[derive(Clone, Copy, Default)]
pub struct Listener<'a>(Option<&'a (dyn Fn(PlanStage) + Sync)>);

impl<'a> Listener<'a> {
    /// Reports every stage to `listen`.
    pub fn new(listen: &'a (dyn Fn(PlanStage) + Sync)) -> Self {
        Self(Some(listen))
    }

    /// Whether there is a callback.
    pub fn has_callback(&self) -> bool {
        self.0.is_some()
    }

    /// Reports a stage; `stage` is evaluated only if there is a callback.
    pub fn notify(&self, stage: impl FnOnce() -> PlanStage) {
        if let Some(listen) = self.0 {
            listen(stage());
        }
    }
}
