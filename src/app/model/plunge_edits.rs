//! Edits of the selected plunge or its row. They are part of the setup: the plan is edited by planning again,
//! which finds the same plunges and applies them.

use std::ops::Range;

use crate::plunge::inspect::row_of;
use crate::plunge::{PlungeMark, PlungePlan, UnappliedEdit};
use crate::setup::edits::add_edit;
use crate::setup::{PlungeChange, PlungeEdit, PlungeMove, PlungePose};

use crate::app::model::look::Operation;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::state::AppState;

/// Where a plunge or row goes in the cutting order of its section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CuttingPlace {
    /// Before the one that is cut before it.
    Earlier,
    /// After the one that is cut after it.
    Later,
}

/// Pose of plunge `k`.
fn pose(plan: &PlungePlan, k: usize) -> Option<PlungePose> {
    plan.positions.get(k).map(|position| PlungePose { tip: position.tip, axis: position.axis })
}

impl AppState {
    /// The plan to which edits apply, if the active side shows it: that of the strategy of the setup.
    pub fn editable_plan(&self) -> Option<&PlungePlan> {
        if self.look.operation != Operation::Roughing {
            return None;
        }
        let shown = self.shown()?;
        let is_after = shown.policy == shown.planned.setup.plunge.axis;
        // After an undo, until the plan follows, its plunges are not those that further edits find.
        let (known, now) = (&shown.planned.setup.plunge.edits, &self.document.edited.setup.plunge.edits);
        (is_after && now.starts_with(known)).then(|| shown.plan())
    }

    /// Whether the plan that is edited is shown, but has edits that were taken back: the next one follows.
    pub fn shows_undone_edits(&self) -> bool {
        let Some(shown) = self.shown().filter(|_| self.look.operation == Operation::Roughing) else {
            return false;
        };
        shown.policy == shown.planned.setup.plunge.axis && self.editable_plan().is_none()
    }

    /// Why plunges of the shown plan take no edits; `None` where they do.
    pub fn why_not_edited(&self) -> Option<&'static str> {
        if self.takes_edits() {
            None
        } else if self.shows_undone_edits() {
            Some("The plan still has edits that were taken back: calculate it first")
        } else if self.editable_plan().is_none() {
            Some("Edits apply to the plan of the strategy of the setup: show the side \"After\" with it")
        } else {
            Some("The plan is older than the setup: calculate it first")
        }
    }

    /// Words on edits that do nothing in the last plan; `None` without any.
    pub fn unapplied_words(&self) -> Option<String> {
        match self.unapplied_edits().len() {
            0 => None,
            1 => Some("1 edit by hand not applied".to_owned()),
            n => Some(format!("{n} edits by hand not applied")),
        }
    }

    /// The last plan, if it has all edits of the setup.
    fn plan_with_all_edits(&self) -> Option<&DisplayPlan> {
        let planned = self.results.planned.as_deref()?;
        (planned.setup.plunge.edits == self.document.edited.setup.plunge.edits).then_some(planned)
    }

    /// Whether the plan that is shown is the one that the next edit changes: not while it has yet to follow
    /// the last one, or another change of the setup, for which it may have other plunges.
    pub fn takes_edits(&self) -> bool {
        !self.out_of_date() && self.editable_plan().is_some()
    }

    /// Pose of the selected plunge of the plan to which edits apply.
    fn selected_pose(&self) -> Option<PlungePose> {
        pose(self.editable_plan()?, self.look.selected?)
    }

    /// Whether the selected plunge may be lifted: also while the plan has yet to follow a lift of it, to
    /// which the next one adds.
    pub fn takes_lifts(&self) -> bool {
        let lifted = || {
            let planned = self.results.planned.as_ref()?;
            let (known, now) = (planned.setup.plunge.edits.len(), &self.document.edited.setup);
            let plunge = self.selected_pose().filter(|_| planned.is_of_but_for_edits(now))?;
            match now.plunge.edits.get(known..)? {
                [only] if matches!(only.change, PlungeChange::Lift(_)) => Some(only.plunge.is(&plunge)),
                _ => None,
            }
        };
        self.takes_edits() || lifted() == Some(true)
    }

    /// What was done by hand to plunge `k` of the shown plan.
    pub fn plunge_mark(&self, k: usize) -> PlungeMark {
        let shown = self.shown().filter(|shown| shown.policy == shown.planned.setup.plunge.axis);
        shown.map_or(PlungeMark::Planned, |shown| shown.planned.outcome.edits.mark(k))
    }

    /// The edits that do nothing in the last plan, each with the reason; empty until it has all edits of the
    /// setup.
    pub fn unapplied_edits(&self) -> &[UnappliedEdit] {
        self.plan_with_all_edits().map_or(&[], |planned| &planned.outcome.edits.unapplied)
    }

    /// Number of edits of the setup.
    pub fn edit_count(&self) -> usize {
        self.document.edited.setup.plunge.edits.len()
    }

    /// The plunges that an edit of the selected one is for.
    fn edited_range(&self, whole_row: bool) -> Option<Range<usize>> {
        let (plan, k) = (self.editable_plan()?, self.look.selected?);
        (k < plan.positions.len()).then(|| if whole_row { row_of(plan, k) } else { k..k + 1 })
    }

    /// Changes the edits of the setup, as one undo step.
    fn change_edits(&mut self, change: impl FnOnce(&mut Vec<PlungeEdit>)) {
        self.document.step();
        change(&mut self.document.edited.setup.plunge.edits);
        self.document.step();
    }

    /// Removes the edits of these indices.
    fn remove_edits_at(&mut self, removed: &[usize]) {
        self.change_edits(|edits| {
            let mut index = 0..;
            edits.retain(|_| index.next().is_none_or(|index| !removed.contains(&index)));
        });
    }

    /// Edits the selected plunge or its row, if the plan shown takes the edit.
    fn edit_selected(&mut self, whole_row: bool, change: PlungeChange) {
        let is_lift = matches!(change, PlungeChange::Lift(_));
        if !(self.takes_edits() || is_lift && self.takes_lifts()) {
            return;
        }
        if let Some(plunge) = self.selected_pose() {
            self.change_edits(|edits| add_edit(edits, PlungeEdit { plunge, whole_row, change }));
        }
    }

    /// Leaves the selected plunge or its row out.
    pub fn delete_selected(&mut self, whole_row: bool) {
        self.edit_selected(whole_row, PlungeChange::Delete);
    }

    /// Lets the selected plunge or its row stop short by `lift` mm more.
    pub fn lift_selected(&mut self, whole_row: bool, lift: f64) {
        self.edit_selected(whole_row, PlungeChange::Lift(lift));
    }

    /// Moves and turns the selected plunge or its row.
    pub fn move_selected(&mut self, whole_row: bool, by: PlungeMove) {
        self.edit_selected(whole_row, PlungeChange::Move(by));
    }

    /// Whether the selected plunge, or every plunge of its row, is locked.
    pub fn is_selected_locked(&self, whole_row: bool) -> bool {
        let range = self.edited_range(whole_row);
        range.is_some_and(|mut range| range.all(|k| self.plunge_mark(k).is_locked()))
    }

    /// Locks the selected plunge or its row; unlocks it where it is locked.
    pub fn toggle_lock(&mut self, whole_row: bool) {
        let range = self.edited_range(whole_row).filter(|_| self.takes_edits());
        let Some(range) = range else { return };
        let marks: Vec<PlungeMark> = range.clone().map(|k| self.plunge_mark(k)).collect();
        let locks = |mark: &PlungeMark| match mark {
            PlungeMark::Locked(index) => Some(*index),
            PlungeMark::Planned | PlungeMark::Edited => None,
        };
        if marks.iter().all(|mark| mark.is_locked()) {
            let locks: Vec<usize> = marks.iter().filter_map(locks).collect();
            self.remove_edits_at(&locks);
            return;
        }
        let Some(plan) = self.editable_plan() else { return };
        let lock = |(k, mark): (usize, &PlungeMark)| {
            let position = plan.positions.get(k).filter(|_| !mark.is_locked())?;
            let tool = plan.sections.get(position.section)?.tool.number;
            let change = PlungeChange::Lock { tool, lift: position.lift };
            Some(PlungeEdit { plunge: pose(plan, k)?, whole_row: false, change })
        };
        let added: Vec<PlungeEdit> = range.zip(&marks).filter_map(lock).collect();
        self.change_edits(|edits| edits.extend(added));
    }

    /// Before what the selected plunge or its row is cut when it goes earlier or later, and its own pose;
    /// `None` where it is the first or the last of its section.
    fn reordered(&self, whole_row: bool, to: CuttingPlace) -> Option<(Option<PlungePose>, PlungePose)> {
        let range = self.edited_range(whole_row)?;
        let plan = self.editable_plan()?;
        let section = plan.positions.get(range.start)?.section;
        let in_section = |k: usize| plan.positions.get(k).is_some_and(|p| p.section == section);
        let unit = |k: usize| if whole_row { row_of(plan, k) } else { k..k + 1 };
        let before = match to {
            CuttingPlace::Earlier => {
                let previous = range.start.checked_sub(1).filter(|&k| in_section(k))?;
                pose(plan, unit(previous).start)
            }
            CuttingPlace::Later => {
                let next = Some(range.end).filter(|&k| in_section(k))?;
                let after = unit(next).end;
                if in_section(after) { pose(plan, after) } else { None }
            }
        };
        Some((before, self.selected_pose()?))
    }

    /// Whether the selected plunge or its row can be cut earlier or later.
    pub fn can_reorder(&self, whole_row: bool, to: CuttingPlace) -> bool {
        self.reordered(whole_row, to).is_some()
    }

    /// Cuts the selected plunge or its row earlier or later. The selection follows.
    pub fn reorder_selected(&mut self, whole_row: bool, to: CuttingPlace) {
        let Some((before, selected)) = self.reordered(whole_row, to) else { return };
        self.edit_selected(whole_row, PlungeChange::Reorder(before));
        self.look.followed = Some(selected);
    }

    /// Selects the plunge that was selected before it was cut in another order.
    pub(in crate::app) fn follow_reordered(&mut self) {
        let Some(followed) = self.look.followed.take() else { return };
        let k = self.editable_plan().and_then(|plan| {
            let is_it = |k: &usize| pose(plan, *k).is_some_and(|pose| pose.is(&followed));
            (0..plan.positions.len()).find(is_it)
        });
        if k.is_some() {
            self.look.select(k);
        }
    }

    /// Removes the edits that do nothing in the last plan.
    pub fn remove_unapplied_edits(&mut self) {
        let removed: Vec<usize> = self.unapplied_edits().iter().map(|edit| edit.index).collect();
        self.remove_edits_at(&removed);
    }

    /// Removes all edits.
    pub fn remove_edits(&mut self) {
        self.change_edits(Vec::clear);
    }
}
