//! Edits of a plan by hand ([`PlungeEdit`]): plunges left out, lifted, moved, kept whatever the planner
//! finds, and cut in another order. They apply in sequence to the plan that was found; then the edited plan
//! is evaluated as every other one is: contact, clearances, links and time are those of what will be cut.
//!
//! An edit names its plunge by its pose. Where the plan has no such plunge (any more) it does nothing and is
//! reported with the reason; a lock puts its plunge into the plan instead. The job then plans once more,
//! around what is locked (`locked`), and the edits apply to that plan.

use std::ops::Range;

use rayon::prelude::*;

use super::assembly::AssemblyRule;
use super::context::PlanContext;
use super::edit_pose::{moved, position_at};
use super::edit_report::{EditReport, PlungeMark, UnappliedEdit, UnappliedReason};
use super::error::PlanError;
use super::evaluation::evaluate;
use super::inspect::run_around;
use super::locked::replaced_within;
use super::plan::{PlungePlan, Position, Unevaluated};
use super::whole_plan::PlacedPlan;
use crate::cutting::contact::Columns;
use crate::geometry::Point;
use crate::monitor::Monitor;
use crate::setup::{PlungeChange, PlungeEdit, PlungePose, SectionKind, SetupPlace, Tool};

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

    /// Its tip, if it did not stop short.
    fn foot(&self) -> Point {
        self.pose().lifted(-self.position.lift).tip
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
    /// Whether a locked plunge was inserted.
    adds_locked: bool,
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

    /// Applies the `edit` of this `index`.
    ///
    /// # Errors
    /// Why it does not fit the plan.
    fn apply(&mut self, index: usize, edit: &PlungeEdit) -> Result<(), UnappliedReason> {
        let found = self.find(&edit.plunge);
        if let PlungeChange::Lock { tool, lift } = edit.change {
            return match found {
                Some(k) => {
                    self.plunges[k].mark = PlungeMark::Locked(index);
                    Ok(())
                }
                None => self.insert(&edit.plunge, tool, lift, PlungeMark::Locked(index)),
            };
        }
        let Some(k) = found else { return Err(UnappliedReason::NoPlunge) };
        let range = if edit.whole_row { self.row_of(k) } else { k..k + 1 };
        match edit.change {
            PlungeChange::Delete => {
                self.plunges.drain(range);
            }
            PlungeChange::Lift(by) => {
                self.lift(range.clone(), by);
                self.drop_doubles(range);
            }
            PlungeChange::Move(by) => {
                let (_, kind) = self.sections[self.plunges[k].position.section];
                // Plunges above the shroud do not end at the hub.
                if kind == SectionKind::Opening {
                    return Err(UnappliedReason::AboveShroud);
                }
                let context = self.context;
                self.replace(range.clone(), |tool, draft| {
                    let lift = draft.position.lift;
                    (moved(context, tool, &draft.pose(), lift, &by), lift)
                });
                self.drop_doubles(range);
            }
            PlungeChange::Reorder(before) => self.reorder(range, before.as_ref(), edit.whole_row)?,
            PlungeChange::Lock { .. } => {}
        }
        Ok(())
    }

    /// Drops those plunges of `range` that another one repeats: the planner has placed them already, as they
    /// are locked where the edit brings them.
    fn drop_doubles(&mut self, range: Range<usize>) {
        for k in range.rev() {
            let pose = self.plunges[k].pose();
            let others = self.plunges.iter().enumerate().filter(|(other, _)| *other != k);
            if others.map(|(_, draft)| draft.pose()).any(|other| other.is(&pose)) {
                self.plunges.remove(k);
            }
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
    ///
    /// # Errors
    /// Where it cannot go there.
    fn reorder(
        &mut self,
        range: Range<usize>,
        before: Option<&PlungePose>,
        whole_row: bool,
    ) -> Result<(), UnappliedReason> {
        let section = self.plunges[range.start].position.section;
        let target = match before {
            Some(pose) => {
                let k = self.find(pose).ok_or(UnappliedReason::NoTarget)?;
                if self.plunges[k].position.section != section {
                    return Err(UnappliedReason::OtherSection);
                }
                if range.contains(&k) {
                    return Err(UnappliedReason::OwnRow);
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
        Ok(())
    }

    /// Puts the locked plunge at `pose` of tool number `tool` into the plan.
    ///
    /// # Errors
    /// Where no section has the tool.
    fn insert(
        &mut self,
        pose: &PlungePose,
        tool: u32,
        lift: f64,
        mark: PlungeMark,
    ) -> Result<(), UnappliedReason> {
        let has_tool = |(known, _): &(Tool, SectionKind)| known.number == tool;
        let section = self.sections.iter().position(has_tool).ok_or(UnappliedReason::NoTool(tool))?;
        self.adds_locked = true;
        let tool = self.sections[section].0.clone();
        let foot = pose.lifted(-lift).tip;
        let same_tool = |draft: &Draft| self.sections[draft.position.section].0.number == tool.number;
        let near = self
            .plunges
            .iter()
            .enumerate()
            .filter(|(_, draft)| same_tool(draft))
            .map(|(k, draft)| (k, (draft.foot() - foot).norm(), draft.mark.is_locked()));
        let nearest_of = |locked: bool| {
            let of = near.clone().filter(|(.., is_locked)| locked || !is_locked);
            of.min_by(|(_, a, _), (_, b, _)| a.total_cmp(b))
        };
        let reach = replaced_within(self.context, &tool);
        let is_close = |(_, distance, _): &(usize, f64, bool)| *distance <= reach;
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
        Ok(())
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

/// Adds where shank or holder of a plunge are in the way. What the planner places is free of that; nothing
/// stops an edit, and what one leaves standing may be in the way of others.
fn add_assembly_breaches(context: &PlanContext, plan: &mut PlungePlan, columns: &Columns) {
    let rules: Vec<Option<AssemblyRule>> =
        plan.sections.iter().map(|section| context.assembly_rule(&section.tool)).collect();
    let blank = &context.workpiece.blank;
    plan.positions.par_iter_mut().enumerate().for_each(|(k, position)| {
        let (Some(rule), None) = (&rules[position.section], position.evaluation.breach) else { return };
        let pose = (position.tip, position.axis);
        position.evaluation.breach = rule.breach(pose, columns.before(k + 1), blank);
    });
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
    let mut editor = Editor { context, sections, plunges, adds_locked: false };
    let mut failed = Vec::new();
    for (index, edit) in edits.iter().enumerate() {
        monitor.ignoring_stop().check()?;
        if let Err(why) = editor.apply(index, edit) {
            failed.push((index, why));
        }
    }
    let adds_locked = editor.adds_locked;
    let (plan, marks) = editor.finish(plan);
    let unapplied = failed
        .into_iter()
        .map(|(index, why)| UnappliedEdit::new(index, why, &edits[index].plunge, &plan))
        .collect();
    if let Some(last) = plan.sections.last() {
        context.check_count(plan.positions.len(), &last.tool, SetupPlace::Plunge("edit"))?;
    }
    let columns = plan.columns(&context.workpiece.blank);
    let mut plan = evaluate(context, PlacedPlan { plan, columns: columns.clone() }, monitor)?;
    add_assembly_breaches(context, &mut plan, &columns);
    Ok((plan, EditReport { marks, unapplied, adds_locked }))
}
