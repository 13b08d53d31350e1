//! The selected plunge stays the same one, or the nearest, when another plan is shown.

use std::sync::Arc;

use crate::plunge::{PlungePlan, Position};
use crate::setup::{AxisPolicy, PlungePose};

use super::AppState;
use crate::app::model::look::{Operation, REVEAL};
use crate::app::model::planned::{DisplayPlan, ShownPlan};

/// The selection, and the plan that it is in.
pub(super) struct KnownSelection {
    planned: Arc<DisplayPlan>,
    policy: AxisPolicy,
    /// Its number in that plan.
    index: usize,
    /// Pose of the plunge that was selected; that of `index` may be one near it.
    pose: PlungePose,
}

impl KnownSelection {
    fn is_in(&self, shown: ShownPlan<'_>) -> bool {
        Arc::ptr_eq(&self.planned, shown.planned) && self.policy == shown.policy
    }

    /// The plunge of another plan that takes its place, and the pose to follow on; `None` where that plan is
    /// empty.
    fn find_in(&self, shown: ShownPlan<'_>) -> Option<(usize, PlungePose)> {
        let positions = &shown.plan().positions;
        let same = positions.iter().position(|position| pose_of(position).is(&self.pose));
        // Back in the first plan it is the first plunge again: its pose stays.
        if let Some(k) = same {
            return Some((k, self.pose));
        }
        if !self.differs_by_hand(shown) {
            return nearest(shown.plan(), &self.pose).map(|k| (k, self.pose));
        }
        // An edit that moves or lifts it keeps its number; the next one takes that of one that is deleted.
        let k = self.index.min(positions.len().checked_sub(1)?);
        let is_moved = positions.len() == self.planned.plan(self.policy).positions.len();
        Some((k, if is_moved { positions.get(k).map(pose_of)? } else { self.pose }))
    }

    /// Whether another plan differs only by edits by hand.
    fn differs_by_hand(&self, shown: ShownPlan<'_>) -> bool {
        self.policy == shown.policy && self.planned.is_of_but_for_edits(&shown.planned.setup)
    }
}

/// Pose of a plunge.
fn pose_of(position: &Position) -> PlungePose {
    PlungePose { tip: position.tip, axis: position.axis }
}

/// The plunge whose tip is nearest; `None` where the plan is empty.
fn nearest(plan: &PlungePlan, pose: &PlungePose) -> Option<usize> {
    let distances = plan.positions.iter().map(|position| (position.tip - pose.tip).norm());
    distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}

impl AppState {
    /// Whether a position, pass or fault of the selected operation is selected.
    pub fn has_selection(&self) -> bool {
        let selected = match self.look.operation {
            Operation::Roughing => self.look.selected,
            Operation::Flank => self.look.flank.pass,
            Operation::Program => self.look.finding,
        };
        selected.is_some()
    }

    /// Ends the selection in the selected operation.
    pub fn deselect(&mut self) {
        match self.look.operation {
            Operation::Roughing => self.look.select(None),
            Operation::Flank => self.select_pass(None),
            Operation::Program => self.select_finding(None),
        }
    }

    /// Selects in a plan that is newly shown the plunge that was selected in the one before, or else the one
    /// nearest to it: its number means another plunge there. Call once per frame, and around a change of what
    /// is shown.
    pub(in crate::app) fn follow_selection(&mut self) {
        let Some(shown) = self.shown() else { return };
        let (planned, policy, plan) = (Arc::clone(shown.planned), shown.policy, shown.plan());
        let Some(selected) = self.look.selected else {
            self.known_selection = None;
            return;
        };
        let known = self.known_selection.as_ref().filter(|known| known.index == selected);
        let found = match known {
            Some(known) if known.is_in(shown) => return,
            Some(known) => known.find_in(shown),
            None => plan.positions.get(selected).map(|position| (selected, pose_of(position))),
        };
        self.known_selection = found.map(|(index, pose)| KnownSelection { planned, policy, index, pose });
        let index = found.map(|(index, _)| index);
        if index != Some(selected) {
            self.look.selected = index;
            self.look.reveal_selection = if index.is_some() { REVEAL } else { 0 };
            // A timeline that stands at it stays there.
            if let (Some(k), Some(cut)) = (index, self.look.cut_count)
                && cut == selected + 1
                && self.shown_channels().is_none()
            {
                self.look.cut_count = Some(k + 1);
            }
        }
    }
}
