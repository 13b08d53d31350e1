//! What is known of the last plans of a part.

use std::collections::HashMap;

use super::machine::machine_of;
use super::outcome::{PlanOutcome, PlanRequest};
use crate::plunge::SectionCache;
use crate::setup::{AxisPolicy, PlungeEdit};

/// Cached sections of the last plans.
#[derive(Debug, Default)]
pub(super) struct PolicyCache {
    /// Of the plan of each policy.
    pub(super) policies: HashMap<AxisPolicy, SectionCache>,
    /// Of the plan of `minimal` with fewer rows.
    pub(super) sparse: SectionCache,
}

/// What is known of the last plans of a part.
#[derive(Debug, Default)]
pub(super) struct PlanCache {
    pub(super) plans: PolicyCache,
    /// The same with sections cut from the inlet or from both ends of the channel.
    pub(super) reordered: PolicyCache,
    /// The last finished outcome before its edits, with its request: an edit changes nothing else.
    pub(super) unedited: Option<(PlanRequest, PlanOutcome)>,
    /// The same, planned around the last locked plunges that the planner did not place by itself.
    pub(super) around: Option<(Vec<PlungeEdit>, PlanOutcome)>,
}

impl PlanCache {
    /// The outcome of `request`, which has no edits, if it is the last one.
    pub(super) fn unedited(&self, request: &PlanRequest) -> Option<PlanOutcome> {
        let (known, outcome) = self.unedited.as_ref()?;
        let is_same = known.setup.plans_equal_channel(&request.setup)
            && (known.policy, known.field_cells) == (request.policy, request.field_cells)
            && known.compare == request.compare
            // Its file may have changed since.
            && machine_of(&request.setup).is_ok_and(|machine| outcome.clock.machine() == machine.as_ref());
        is_same.then(|| outcome.clone())
    }
}
