//! Which plunges above the shroud a plan needs: those that a tool of another section comes near.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::context::PlanContext;
use super::error::PlanError;
use super::evaluation::evaluate;
use super::opening_section::opening_section;
use super::plan::{PlungePlan, Unevaluated};
use super::whole_plan::{PlacedPlan, assemble_all};
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn};
use crate::geometry::{Point, Vector};
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, SectionKind, Setup, Tool};

/// `plan` with its `columns` without the plunges above the shroud that no tool of another section comes
/// near. `None` where it has none of them.
pub(super) fn with_needed_opening(
    context: &PlanContext,
    plan: &PlungePlan<Unevaluated>,
    columns: &Columns,
) -> Option<(PlungePlan<Unevaluated>, Columns)> {
    let is_opening = |section: usize| plan.sections[section].kind == SectionKind::Opening;
    let count = plan.positions.iter().take_while(|p| is_opening(p.section)).count();
    if count == 0 {
        return None;
    }
    let top = BlankTop::new(&context.workpiece.blank);
    let others = plan.positions[count..].iter().map(|position| {
        let tool = &plan.sections[position.section].tool;
        reach_column(tool, (position.tip, position.axis), context.setup, &top)
    });
    Some(keep_near(plan, columns, count, others))
}

/// The plunges above the shroud that `tool` comes near at one of `poses`, tips with unit axes.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn opening_for(
    context: &PlanContext,
    tool: &Tool,
    poses: impl Iterator<Item = (Point, Vector)>,
    monitor: &Monitor,
) -> Result<PlungePlan, PlanError> {
    let cut = Arc::new(opening_section(context, 0, Columns::default(), monitor)?);
    let PlacedPlan { plan, columns } = assemble_all(context, AxisPolicy::Conventional, &[cut])?;
    let top = BlankTop::new(&context.workpiece.blank);
    let near = poses.map(|pose| reach_column(tool, pose, context.setup, &top));
    let (plan, columns) = keep_near(&plan, &columns, plan.positions.len(), near);
    evaluate(context, PlacedPlan { plan, columns }, monitor)
}

/// What `tool` sweeps on its way into and out of a pose, with its holder all the way down: a column that is
/// as wide.
fn reach_column(tool: &Tool, (tip, axis): (Point, Vector), setup: &Setup, top: &BlankTop) -> PlungeColumn {
    let reach = tool.radius().max(0.5 * tool.holder_diameter()) + setup.clearances.holder;
    PlungeColumn::new(tool.placed(tip, axis), reach, top)
}

/// `plan` with its `columns`, of whose first `count` plunges, which are above the shroud, only those are kept
/// that come near to one of the columns of `others`, with those before them in their rows.
fn keep_near(
    plan: &PlungePlan<Unevaluated>,
    columns: &Columns,
    count: usize,
    others: impl Iterator<Item = PlungeColumn>,
) -> (PlungePlan<Unevaluated>, Columns) {
    // Number of plunges to keep of each row: up to the last one that is needed.
    let mut needed: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let mut number_in_row = Vec::with_capacity(count);
    for (k, position) in plan.positions[..count].iter().enumerate() {
        let before = k.checked_sub(1).map(|k| &plan.positions[k]);
        let same = before.is_some_and(|b| (b.section, b.row) == (position.section, position.row));
        number_in_row.push(if same { number_in_row[k - 1] + 1 } else { 0 });
    }
    for column in others {
        for near in columns.before(count).numbers_near(&column) {
            let near = near as usize;
            let other = &plan.positions[near];
            let kept = needed.entry((other.section, other.row)).or_default();
            *kept = (*kept).max(number_in_row[near] + 1);
        }
    }
    let mut kept = PlungePlan { positions: Vec::with_capacity(plan.positions.len()), ..plan.clone() };
    let mut left = Columns::default();
    let mut rows = vec![0; plan.sections.len()];
    let mut last = None;
    for (k, (position, column)) in plan.positions.iter().zip(columns.as_slice()).enumerate() {
        let place = (position.section, position.row);
        if k < count && needed.get(&place).is_none_or(|kept| number_in_row[k] >= *kept) {
            continue;
        }
        left.push(*column);
        let mut position = position.clone();
        if k < count {
            rows[place.0] += usize::from(last != Some(place));
            last = Some(place);
            position.row = rows[place.0] - 1;
        }
        kept.positions.push(position);
    }
    for (section, rows) in kept.sections.iter_mut().zip(rows) {
        if section.kind == SectionKind::Opening {
            section.rows = rows;
        }
    }
    (kept, left)
}
