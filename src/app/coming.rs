//! Preview of a running plan: the results so far, and the slot that passes them from the planner to the
//! window.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::job::{PlanOutcome, PolicyResult, Stage};
use crate::part::{AxisPolicy, Impeller, Setup};
use crate::plunge::PlungePlan;
use crate::residual::FloorGrid;

use super::planned::Planned;

/// Cutters of a policy's plan before its residual stock is computed.
#[derive(Clone, Debug)]
pub struct ComingCutters {
    /// The plan so far.
    pub plan: Arc<PlungePlan>,
    /// Whether core contact is checked; before that no plunge may be shown as sound.
    pub judged: bool,
    /// Whether the axes are those of the last plan (warm start).
    pub carried: bool,
}

impl ComingCutters {
    /// Number of interfering plunges; `None` while contact is not checked.
    pub fn interferential(&self) -> Option<usize> {
        self.judged.then(|| self.plan.positions.iter().filter(|p| p.contact.interferes()).count())
    }
}

/// Preview of a running plan.
#[derive(Clone, Debug)]
pub struct Coming {
    /// Number of the task; see [`super::engine::PlanTask`].
    pub(super) task: u64,
    /// The setup as requested.
    pub setup: Setup,
    /// Latest stage of each policy, in order of arrival.
    cutters: Vec<ComingCutters>,
    /// The finished policies, as a plan.
    pub planned: Option<Arc<Planned>>,
    part: Arc<Impeller>,
    resolved: Option<(Setup, Vec<Option<String>>)>,
}

impl Coming {
    /// An empty preview.
    pub(super) fn new(task: u64, part: Arc<Impeller>, setup: Setup) -> Self {
        Self { task, setup, cutters: Vec::new(), planned: None, part, resolved: None }
    }

    /// Adds a stage.
    pub(super) fn add(&mut self, stage: Stage) {
        match stage {
            Stage::Resolved(setup, reasons) => self.resolved = Some((setup, reasons)),
            Stage::Carried(plan) => {
                self.take_cutters(ComingCutters { plan: plan.into(), judged: true, carried: true });
            }
            // The warm-start plan is shown already, and its contact is checked.
            Stage::Placed(plan) if self.has_carried(plan.policy) => {}
            Stage::Placed(plan) => {
                self.take_cutters(ComingCutters { plan: plan.into(), judged: false, carried: false });
            }
            Stage::Judged(plan) => {
                self.take_cutters(ComingCutters { plan: plan.into(), judged: true, carried: false });
            }
            // The conventional result arrives first. The requested policy is skipped: the finished plan
            // follows at once.
            Stage::Measured(_, result)
                if result.plan.policy == self.setup.plunge.axis && self.planned.is_some() => {}
            Stage::Measured(grid, result) => self.take_result(grid, result),
        }
    }

    fn take_cutters(&mut self, cutters: ComingCutters) {
        self.cutters.retain(|known| known.plan.policy != cutters.plan.policy);
        self.cutters.push(cutters);
    }

    fn has_carried(&self, policy: AxisPolicy) -> bool {
        self.cutters.iter().any(|known| known.carried && known.plan.policy == policy)
    }

    /// Whether core contact is checked for any policy.
    pub(super) fn is_anything_judged(&self) -> bool {
        self.cutters.iter().any(|known| known.judged)
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
                others: Vec::new(),
                elapsed: 0.0,
            },
        };
        self.planned = Some(Arc::new(Planned::new(self.setup.clone(), outcome)));
    }

    /// The cutters to show where `policy` is awaited: its own as soon as there are any, else the latest.
    pub fn cutters(&self, policy: AxisPolicy) -> Option<&ComingCutters> {
        let own = self.cutters.iter().find(|known| known.plan.policy == policy);
        own.or_else(|| self.cutters.iter().rfind(|known| !known.carried))
    }
}

/// Single-entry slot for the latest preview; a newer one replaces it, nothing queues up.
#[derive(Clone, Debug, Default)]
pub(super) struct Slot(Arc<Mutex<Option<Arc<Coming>>>>);

impl Slot {
    fn latest(&self) -> MutexGuard<'_, Option<Arc<Coming>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the content by `coming`.
    pub(super) fn put(&self, coming: Coming) {
        *self.latest() = Some(Arc::new(coming));
    }

    /// Takes the content out.
    pub(super) fn take(&self) -> Option<Arc<Coming>> {
        self.latest().take()
    }
}
