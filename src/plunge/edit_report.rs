//! What edits by hand did to a plan, and why some of them could not be applied.

use super::plan::PlungePlan;
use crate::setup::PlungePose;

/// What the user did to a plunge of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlungeMark {
    /// Nothing: it is as the planner placed it.
    #[default]
    Planned,
    /// Lifted, moved, or cut in another order.
    Edited,
    /// Kept in every plan, by the edit of this index.
    Locked(usize),
}

impl PlungeMark {
    /// Whether the plunge is kept in every plan.
    pub fn is_locked(self) -> bool {
        matches!(self, Self::Locked(_))
    }

    /// The mark of a plunge that is edited: a locked one stays locked.
    pub(super) fn edited(self) -> Self {
        if self.is_locked() { self } else { Self::Edited }
    }
}

/// Why an edit could not be applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnappliedReason {
    /// No plunge of the plan is where the edit has it.
    NoPlunge,
    /// No plunge of the plan is where the edit has the one before which to cut.
    NoTarget,
    /// The plunge before which to cut belongs to another section.
    OtherSection,
    /// A row cannot be cut before itself.
    OwnRow,
    /// Plunges that open the blank end above the shroud, so that they cannot be moved over the hub.
    AboveShroud,
    /// No section has the tool of this number.
    NoTool(u32),
}

/// A plunge of a plan, and how far from another pose it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearPlunge {
    /// Its number in cutting order, from 0.
    pub index: usize,
    /// Distance of the tips, mm.
    pub distance: f64,
}

/// An edit that could not be applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnappliedEdit {
    /// Index of the edit in the setup.
    pub index: usize,
    /// Why.
    pub why: UnappliedReason,
    /// The plunge of the plan that is nearest to where the edit has its own; `None` where that is in the
    /// plan.
    pub nearest: Option<NearPlunge>,
}

impl UnappliedEdit {
    /// The edit of this `index` of the plunge at `pose`, which the edited `plan` lacks.
    pub(super) fn new<E>(
        index: usize,
        why: UnappliedReason,
        pose: &PlungePose,
        plan: &PlungePlan<E>,
    ) -> Self {
        let near = plan
            .positions
            .iter()
            .enumerate()
            .map(|(index, position)| NearPlunge { index, distance: (position.tip - pose.tip).norm() });
        let nearest = near.min_by(|a, b| a.distance.total_cmp(&b.distance));
        Self { index, why, nearest: nearest.filter(|_| why == UnappliedReason::NoPlunge) }
    }

    /// The reason as a clause, with lengths written by `length` (from mm); positions count from 1.
    pub fn reason(&self, length: impl Fn(f64) -> String) -> String {
        let words = match self.why {
            UnappliedReason::NoPlunge => "the plan has no plunge there",
            UnappliedReason::NoTarget => "the plan has no plunge where the next one was",
            UnappliedReason::OtherSection => "the plunge before which to cut is in another section",
            UnappliedReason::OwnRow => "a row cannot be cut before itself",
            UnappliedReason::AboveShroud => "plunges above the shroud cannot be moved",
            UnappliedReason::NoTool(number) => return format!("no section has tool {number}"),
        };
        match self.nearest {
            Some(NearPlunge { index, distance }) => {
                format!("{words}: the nearest is position {}, {} off", index + 1, length(distance))
            }
            None => words.to_owned(),
        }
    }
}

/// What edits did to a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditReport {
    /// What was done to each plunge, in cutting order; empty for a plan without edits.
    pub marks: Vec<PlungeMark>,
    /// The edits that could not be applied.
    pub unapplied: Vec<UnappliedEdit>,
    /// Whether a locked plunge was put into the plan that the planner had not placed.
    pub adds_locked: bool,
}

impl EditReport {
    /// What was done to plunge `k`.
    pub fn mark(&self, k: usize) -> PlungeMark {
        self.marks.get(k).copied().unwrap_or_default()
    }

    /// Indices of the edits that could not be applied.
    pub fn unapplied_indices(&self) -> Vec<usize> {
        self.unapplied.iter().map(|edit| edit.index).collect()
    }
}
