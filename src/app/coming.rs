//! A plan in the making: what is known of it so far, and the slot in which the planner leaves that for the window.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::job::{PlanOutcome, PolicyResult, Stage};
use crate::part::{AxisPolicy, Impeller, Setup};
use crate::plunge::PlungePlan;
use crate::residual::FloorGrid;

use super::planned::Planned;

/// Cutters of a policy's plan before it is known what they leave on the hub.
#[derive(Clone, Debug)]
pub struct ComingCutters {
    /// The plan as far as it goes.
    pub plan: Arc<PlungePlan>,
    /// Whether contact is known; nothing must be called sound before that.
    pub judged: bool,
    /// Whether the axes are still those of the plan before.
    pub carried: bool,
}

impl ComingCutters {
    /// Positions whose core meets stock; `None` while that is not known.
    pub fn interferential(&self) -> Option<usize> {
        self.judged.then(|| self.plan.positions.iter().filter(|p| p.contact.interferes()).count())
    }
}

/// What is known of a plan in the making.
#[derive(Clone, Debug)]
pub struct Coming {
    /// Number of the task, see [`super::engine::PlanTask`].
    pub(super) task: u64,
    /// The setup as it was asked for.
    pub setup: Setup,
    /// Latest stage of each policy, in the order in which they came.
    cutters: Vec<ComingCutters>,
    /// The policies that are finished, as a plan of their own.
    pub planned: Option<Arc<Planned>>,
    part: Arc<Impeller>,
    resolved: Option<(Setup, Vec<Option<String>>)>,
}

impl Coming {
    /// Nothing is known yet.
    pub(super) fn new(task: u64, part: Arc<Impeller>, setup: Setup) -> Self {
        Self { task, setup, cutters: Vec::new(), planned: None, part, resolved: None }
    }

    /// Takes a stage in.
    pub(super) fn add(&mut self, stage: Stage) {
        match stage {
            Stage::Resolved(setup, reasons) => self.resolved = Some((setup, reasons)),
            Stage::Carried(plan) => {
                self.take_cutters(ComingCutters { plan: plan.into(), judged: true, carried: true });
            }
            // What stands there already is judged.
            Stage::Placed(plan) if self.has_carried(plan.policy) => {}
            Stage::Placed(plan) => {
                self.take_cutters(ComingCutters { plan: plan.into(), judged: false, carried: false });
            }
            Stage::Judged(plan) => {
                self.take_cutters(ComingCutters { plan: plan.into(), judged: true, carried: false });
            }
            // The one all others are compared with comes first; the one that was asked for is the end itself, or nearly.
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

    /// Whether contact is known of something.
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

    /// The cutters to be shown where `policy` is waited for: its own as soon as there are any, else the latest.
    pub fn cutters(&self, policy: AxisPolicy) -> Option<&ComingCutters> {
        let own = self.cutters.iter().find(|known| known.plan.policy == policy);
        own.or_else(|| self.cutters.iter().rfind(|known| !known.carried))
    }
}

/// Where the planner leaves the latest that is known. Nothing queues up.
#[derive(Clone, Debug, Default)]
pub(super) struct Slot(Arc<Mutex<Option<Arc<Coming>>>>);

impl Slot {
    fn latest(&self) -> MutexGuard<'_, Option<Arc<Coming>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves `coming` in place of what was there.
    pub(super) fn put(&self, coming: Coming) {
        *self.latest() = Some(Arc::new(coming));
    }

    /// Fetches what is there, once.
    pub(super) fn take(&self) -> Option<Arc<Coming>> {
        self.latest().take()
    }
}
