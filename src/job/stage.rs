//! What a planning job tells while it works: each plan as soon as something true is known of it.

use std::sync::Arc;

use super::PolicyResult;
use crate::part::Setup;
use crate::plunge::PlungePlan;
use crate::residual::FloorGrid;

/// One step of a planning job.
#[derive(Clone, Debug)]
pub enum Stage {
    /// Tools and sections are chosen; with the reason for each section, see [`super::PlanOutcome::reasons`].
    Resolved(Setup, Vec<Option<String>>),
    /// The cutters of a policy's plan stand where they go. Nothing is known yet of contact, and of retracts.
    Placed(PlungePlan),
    /// A plan by the policy asked for with the axes of the plan before, judged: it is there long before the search.
    Carried(PlungePlan),
    /// Contact, clearances and retracts of a policy's plan are known.
    Judged(PlungePlan),
    /// What a policy's plan leaves on the hub is known too.
    Measured(Arc<FloorGrid>, PolicyResult),
}

/// Who is told of the stages of a job; may be nobody. It is called from any thread, by one at a time for each policy.
#[derive(Clone, Copy, Default)]
pub struct Listener<'a>(Option<&'a (dyn Fn(Stage) + Sync)>);

impl<'a> Listener<'a> {
    /// Tells `listen` of every stage.
    pub fn new(listen: &'a (dyn Fn(Stage) + Sync)) -> Self {
        Self(Some(listen))
    }

    /// Whether anybody listens.
    pub fn is_listening(&self) -> bool {
        self.0.is_some()
    }

    /// Tells of a stage, which is made only if somebody listens.
    pub fn tell(&self, stage: impl FnOnce() -> Stage) {
        if let Some(listen) = self.0 {
            listen(stage());
        }
    }
}
