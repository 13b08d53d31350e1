//! Edits of a plan by hand ([`PlungeEdit`]): plunges left out, lifted, moved, kept whatever the planner
//! finds, and cut in another order. They apply in sequence to the plan that was found; then the edited plan
//! is evaluated as every other one is: contact, clearances, links and time are those of what will be cut.
//!
//! An edit names its plunge by its pose. Where the plan has no such plunge (any more) it does nothing and is
//! reported; a lock puts its plunge into the plan instead.

use std::ops::Range;

use super::context::PlanContext;
use super::cycle::{PlacedPlan, PlanError};
use super::edit_pose::{moved, position_at};
use super::evaluation::evaluate;
use super::inspect::run_around;
use super::plan::{PlungePlan, Position, Unevaluated};
use super::spacing::step_limit;
use crate::geometry::Point;
use crate::monitor::Monitor;
use crate::setup::{PlungeChange, PlungeEdit, PlungePose, SectionKind, SetupPlace, Tool};

/// Share of the step within which a locked plunge takes the place of one of the plan.
const NEAR_SHARE: f64 = 0.5;

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

/// What edits did to a plan.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EditReport {
    /// What was done to each plunge, in cutting order; empty for a plan without edits.
    pub marks: Vec<PlungeMark>,
    /// Indices of the edits whose plunge the plan does not have.
    pub unfitting: Vec<usize>,
}

impl EditReport {
    /// What was done to plunge `k`.
    pub fn mark(&self, k: usize) -> PlungeMark {
        self.marks.get(k).copied().unwrap_or_default()
    }
}

/// A plunge while a plan is edited.
struct Draft {
    position: Position<Unevaluated>,
    mark: PlungeMark,
}

impl Draft {
    fn pose(&self) -> PlungePose {
        PlungePose { tip: self.position.tip, axis: self.position.axis }
    }

    /// Section and row.
    fn row(&self) -> (usize, usize) {
        (self.position.section, self.position.row)
    }

    fn distance(&self, tip: &Point) -> f64 {
        (self.position.tip - tip).norm()
    }
}

/// A plan that is being edited.
struct Editor<'a> {
    context: &'a PlanContext<'a>,
    /// The tool and the kind of each section.
    sections: Vec<(Tool, SectionKind)>,
    plunges: Vec<Draft>,
}

impl Editor<'_> {
    /// Number of the plunge at `pose`.
    fn find(&self, pose: &PlungePose) -> Option<usize> {
        self.plunges.iter().position(|draft| draft.pose().is(pose))
    }

    /// The plunges of the row of plunge `k`.
    fn row_of(&self, k: usize) -> Range<usize> {
        run_around(&self.plunges, k, Draft::row)
    }

    /// Applies the `edit` of this `index`; `false` where it does not fit the plan.
    fn apply(&mut self, index: usize, edit: &PlungeEdit) -> bool {
        let found = self.find(&edit.plunge);
        if let PlungeChange::Lock { tool, lift } = edit.change {
            return match found {
                Some(k) => {
                    self.plunges[k].mark = PlungeMark::Locked(index);
                    true
                }
                None => self.insert(&edit.plunge, tool, lift, PlungeMark::Locked(index)),
            };
        }
        let Some(k) = found else { return false };
        let range = if edit.whole_row { self.row_of(k) } else { k..k + 1 };
        match edit.change {
            PlungeChange::Delete => {
                self.plunges.drain(range);
                true
            }
            PlungeChange::Lift(by) => {
                self.lift(range, by);
                true
            }
            PlungeChange::Move(by) => {
                let (_, kind) = self.sections[self.plunges[k].position.section];
                // Plunges above the shroud do not end at the hub.
                if kind == SectionKind::Opening {
                    return false;
                }
                let context = self.context;
                self.replace(range, |tool, draft| {
                    let lift = draft.position.lift;
                    (moved(context, tool, &draft.pose(), lift, &by), lift)
                });
                true
            }
            PlungeChange::Reorder(before) => self.reorder(range, before.as_ref(), edit.whole_row),
            PlungeChange::Lock { .. } => true,
        }
    }

    /// Lets the plunges of `range` stop short by `by` mm more: what is said of their axes stays.
    fn lift(&mut self, range: Range<usize>, by: f64) {
        let finished = &self.context.workpiece.finished;
        for draft in &mut self.plunges[range] {
            let (tool, _) = &self.sections[draft.position.section];
            let pose = draft.pose().lifted(by);
            let cutter = tool.placed(pose.tip, pose.axis);
            draft.position.tip = pose.tip;
            draft.position.lift += by;
            draft.position.hub_clearance = finished.hub_clearance(&cutter);
            draft.position.blade_clearance = finished.blade_clearance(&cutter);
            draft.mark = draft.mark.edited();
        }
    }

    /// Gives the plunges of `range` the pose and the lift of `to`.
    fn replace(&mut self, range: Range<usize>, to: impl Fn(&Tool, &Draft) -> (PlungePose, f64)) {
        for draft in &mut self.plunges[range] {
            let (tool, _) = &self.sections[draft.position.section];
            let (pose, lift) = to(tool, draft);
            draft.position = position_at(self.context, tool, &pose, lift, draft.row());
            draft.mark = draft.mark.edited();
        }
    }

    /// Cuts the plunges of `range` before the plunge at `before`, or before its row where a `whole_row` goes;
    /// last of their section without one. A single plunge becomes one of the row into which it comes.
    fn reorder(&mut self, range: Range<usize>, before: Option<&PlungePose>, whole_row: bool) -> bool {
        let section = self.plunges[range.start].position.section;
        let target = match before {
            Some(pose) => {
                let Some(k) = self.find(pose) else { return false };
                if self.plunges[k].position.section != section || range.contains(&k) {
                    return false;
                }
                if whole_row { self.row_of(k).start } else { k }
            }
            None => {
                let last = self.plunges.iter().rposition(|draft| draft.position.section == section);
                last.map_or(range.end, |last| last + 1)
            }
        };
        let count = range.len();
        let joined = match before {
            Some(_) => self.plunges.get(target),
            None => self.plunges.get(target.saturating_sub(1)),
        };
        let row = joined.map(|draft| draft.position.row).filter(|_| !whole_row);
        let mut moved: Vec<Draft> = self.plunges.drain(range.clone()).collect();
        for draft in &mut moved {
            draft.position.row = row.unwrap_or(draft.position.row);
            draft.mark = draft.mark.edited();
        }
        let target = if target >= range.end { target - count } else { target };
        self.plunges.splice(target..target, moved);
        true
    }

    /// Puts the locked plunge at `pose` of tool number `tool` into the plan; `false` where no section has the
    /// tool.
    fn insert(&mut self, pose: &PlungePose, tool: u32, lift: f64, mark: PlungeMark) -> bool {
        let has_tool = |(known, _): &(Tool, SectionKind)| known.number == tool;
        let Some(section) = self.sections.iter().position(has_tool) else { return false };
        let tool = self.sections[section].0.clone();
        let same_tool = |draft: &Draft| self.sections[draft.position.section].0.number == tool.number;
        let near = self
            .plunges
            .iter()
            .enumerate()
            .filter(|(_, draft)| same_tool(draft))
            .map(|(k, draft)| (k, draft.distance(&pose.tip), draft.mark.is_locked()));
        let nearest_of = |locked: bool| {
            let of = near.clone().filter(|(.., is_locked)| locked || !is_locked);
            of.min_by(|(_, a, _), (_, b, _)| a.total_cmp(b))
        };
        let is_close = |(_, distance, _): &(usize, f64, bool)| {
            *distance <= NEAR_SHARE * step_limit(&self.context.setup.plunge, &tool, false)
        };
        let replaced = nearest_of(false).filter(is_close).map(|(k, ..)| k);
        let nearest = nearest_of(true).map(|(k, ..)| k);
        let (at, row) = match (replaced, nearest) {
            (Some(k), _) => (k, self.plunges[k].row()),
            (None, Some(k)) => (self.place_beside(k, &pose.tip), self.plunges[k].row()),
            (None, None) => {
                let at = self.plunges.iter().position(|draft| draft.position.section > section);
                (at.unwrap_or(self.plunges.len()), (section, 0))
            }
        };
        let position = position_at(self.context, &tool, pose, lift, row);
        let draft = Draft { position, mark };
        self.plunges.splice(at..at + usize::from(replaced.is_some()), [draft]);
        true
    }

    /// Number that a plunge at `tip` gets beside its nearest plunge `k`: before or after it, as its row runs.
    fn place_beside(&self, k: usize, tip: &Point) -> usize {
        let row = self.row_of(k);
        let own = &self.plunges[k].position.tip;
        let neighbour = |k: usize| row.contains(&k).then(|| &self.plunges[k]);
        let (previous, next) = (k.checked_sub(1).and_then(neighbour), neighbour(k + 1));
        let is_after = match (previous, next) {
            (Some(previous), Some(next)) => next.distance(tip) < previous.distance(tip),
            // At an end of the row it is outside where it is further from the only neighbour.
            (None, Some(next)) => next.distance(tip) <= next.distance(own),
            (Some(previous), None) => previous.distance(tip) >= previous.distance(own),
            (None, None) => true,
        };
        k + usize::from(is_after)
    }

    /// The edited plan, made of `plan`: rows are counted anew.
    fn finish(self, mut plan: PlungePlan<Unevaluated>) -> (PlungePlan<Unevaluated>, Vec<PlungeMark>) {
        let mut rows = vec![0; plan.sections.len()];
        let mut marks = Vec::with_capacity(self.plunges.len());
        let mut last = None;
        plan.positions.clear();
        for draft in self.plunges {
            let row = draft.row();
            if last.replace(row) != Some(row) {
                rows[row.0] += 1;
            }
            plan.positions.push(Position { row: rows[row.0] - 1, ..draft.position });
            marks.push(draft.mark);
        }
        for (section, rows) in plan.sections.iter_mut().zip(rows) {
            section.rows = rows;
        }
        (plan, marks)
    }
}

impl PlungeMark {
    /// Whether the plunge is kept in every plan.
    pub fn is_locked(self) -> bool {
        matches!(self, Self::Locked(_))
    }

    /// The mark of a plunge that is edited: a locked one stays locked.
    fn edited(self) -> Self {
        if self.is_locked() { self } else { Self::Edited }
    }
}

/// `plan` with `edits`, evaluated anew. A stopped monitor is ignored, as in the evaluation of every plan.
///
/// # Errors
/// [`PlanError::Cancelled`] when the monitor is cancelled; [`PlanError::Setup`] when locks make too many
/// positions.
pub(super) fn edit_plan(
    context: &PlanContext,
    plan: &PlungePlan,
    edits: &[PlungeEdit],
    monitor: &Monitor,
) -> Result<(PlungePlan, EditReport), PlanError> {
    let mut plan = plan.clone().with_evaluations(|_| Unevaluated);
    let plunges = std::mem::take(&mut plan.positions).into_iter();
    let plunges = plunges.map(|position| Draft { position, mark: PlungeMark::Planned }).collect();
    let sections = plan.sections.iter().map(|section| (section.tool.clone(), section.kind)).collect();
    let mut editor = Editor { context, sections, plunges };
    let mut unfitting = Vec::new();
    for (index, edit) in edits.iter().enumerate() {
        monitor.ignoring_stop().check()?;
        if !editor.apply(index, edit) {
            unfitting.push(index);
        }
    }
    let (plan, marks) = editor.finish(plan);
    if let Some(last) = plan.sections.last() {
        context.check_count(plan.positions.len(), &last.tool, SetupPlace::Plunge("edit"))?;
    }
    let columns = plan.columns(&context.workpiece.blank);
    let plan = evaluate(context, PlacedPlan { plan, columns }, monitor)?;
    Ok((plan, EditReport { marks, unfitting }))
}
