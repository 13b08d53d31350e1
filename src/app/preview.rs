//! Preview of a running plan: the results so far, and the slot that passes them from the planner to the
//! window.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::job::{PlanOutcome, PlanStage, PolicyResult};
use crate::part::Impeller;
use crate::plunge::PlungePlan;
use crate::setup::{AxisPolicy, Setup};
use crate::stock::FloorGrid;

use super::planned::DisplayPlan;

/// Cutters of a policy's plan before its residual stock is computed.
#[derive(Clone, Debug)]
pub struct PreviewCutters {
    /// The plan so far.
    pub plan: Arc<PlungePlan>,
    /// Whether core contact is checked; before that no plunge may be shown as sound.
    pub is_checked: bool,
    /// Whether the axes are those of the last plan (warm start).
    pub is_warm_start: bool,
}

impl PreviewCutters {
    /// Number of interfering plunges; `None` while contact is not checked.
    pub fn interfering_count(&self) -> Option<usize> {
        self.is_checked.then(|| self.plan.positions.iter().filter(|p| p.contact.interferes()).count())
    }
}

/// Preview of a running plan.
#[derive(Clone, Debug)]
pub struct PlanPreview {
    /// Number of the task; see [`super::engine::PlanTask`].
    pub(super) task: u64,
    /// The setup as requested.
    pub setup: Setup,
    /// Latest stage of each policy, in order of arrival.
    cutters: Vec<PreviewCutters>,
    /// The finished policies, as a plan.
    pub planned: Option<Arc<DisplayPlan>>,
    part: Arc<Impeller>,
    resolved: Option<(Setup, Vec<Option<String>>)>,
}

impl PlanPreview {
    /// An empty preview.
    pub(super) fn new(task: u64, part: Arc<Impeller>, setup: Setup) -> Self {
        Self { task, setup, cutters: Vec::new(), planned: None, part, resolved: None }
    }

    /// Adds a stage.
    pub(super) fn add_stage(&mut self, stage: PlanStage) {
        match stage {
            PlanStage::Resolved(setup, reasons) => self.resolved = Some((setup, reasons)),
            PlanStage::Preview(plan) => {
                self.take_cutters(PreviewCutters {
                    plan: plan.into(),
                    is_checked: true,
                    is_warm_start: true,
                });
            }
            // The warm-start plan is shown already, and its contact is checked.
            PlanStage::Placed(plan) if self.has_warm_start(plan.policy) => {}
            PlanStage::Placed(plan) => {
                self.take_cutters(PreviewCutters {
                    plan: plan.into(),
                    is_checked: false,
                    is_warm_start: false,
                });
            }
            PlanStage::Evaluated(plan) => {
                self.take_cutters(PreviewCutters {
                    plan: plan.into(),
                    is_checked: true,
                    is_warm_start: false,
                });
            }
            // The conventional result arrives first. The requested policy is skipped: the finished plan
            // follows at once.
            PlanStage::Measured(_, result)
                if result.plan.policy == self.setup.plunge.axis && self.planned.is_some() => {}
            PlanStage::Measured(grid, result) => self.take_result(grid, result),
        }
    }

    fn take_cutters(&mut self, cutters: PreviewCutters) {
        self.cutters.retain(|known| known.plan.policy != cutters.plan.policy);
        self.cutters.push(cutters);
    }

    fn has_warm_start(&self, policy: AxisPolicy) -> bool {
        self.cutters.iter().any(|known| known.is_warm_start && known.plan.policy == policy)
    }

    /// Whether core contact is checked for any policy.
    pub(super) fn has_checked_stage(&self) -> bool {
        self.cutters.iter().any(|known| known.is_checked)
    }

    fn take_result(&mut self, grid: Arc<FloorGrid>, result: PolicyResult) {
        let Some((setup, reasons)) = self.resolved.clone() else { return };
        let outcome = match &self.planned {
            Some(planned) => {
                let mut outcome = (*planned.outcome).clone();
                outcome.others.push(result);
                outcome
            }
            None => PlanOutcome {
                part: Arc::clone(&self.part),
                setup,
                reasons,
                grid,
                before: result.clone(),
                after: result,
                whole: None,
                others: Vec::new(),
                elapsed: 0.0,
            },
        };
        self.planned = Some(Arc::new(DisplayPlan::new(self.setup.clone(), outcome)));
    }

    /// The cutters to show where `policy` is awaited: its own as soon as there are any, else the latest.
    pub fn cutters(&self, policy: AxisPolicy) -> Option<&PreviewCutters> {
        let own = self.cutters.iter().find(|known| known.plan.policy == policy);
        own.or_else(|| self.cutters.iter().rfind(|known| !known.is_warm_start))
    }
}

/// Single-entry slot for the latest preview; a newer one replaces it, nothing queues up.
#[derive(Clone, Debug, Default)]
pub(super) struct PreviewSlot(Arc<Mutex<Option<Arc<PlanPreview>>>>);

impl PreviewSlot {
    fn latest(&self) -> MutexGuard<'_, Option<Arc<PlanPreview>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the content by `coming`.
    pub(super) fn put(&self, coming: PlanPreview) {
        *self.latest() = Some(Arc::new(coming));
    }

    /// Takes the content out.
    pub(super) fn take(&self) -> Option<Arc<PlanPreview>> {
        self.latest().take()
    }
}
