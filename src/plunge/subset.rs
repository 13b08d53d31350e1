//! A plan with some of its plunges left out.

use super::context::PlanContext;
use super::error::PlanError;
use super::evaluation::measure;
use super::plan::{PlungePlan, Position};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;

/// `plan` with only the plunges that are `kept`, one flag each, whose `columns` are given: contact,
/// retracts and links are those of what is left, and a row is split where the axes of the plunges
/// left in it differ by more than the setup allows. What the sections say of added plunges stays that of
/// the search.
///
/// # Errors
/// [`PlanError::Cancelled`] when the monitor is cancelled.
pub(super) fn keep_plunges(
    context: &PlanContext,
    plan: &PlungePlan,
    kept: &[bool],
    columns: &Columns,
    monitor: &Monitor,
) -> Result<PlungePlan, PlanError> {
    let limit = context.setup.plunge.max_axis_change_rad;
    let mut thinned = PlungePlan { positions: Vec::with_capacity(plan.positions.len()), ..plan.clone() };
    let mut rows = vec![0; plan.sections.len()];
    let mut last: Option<&Position> = None;
    for (position, _) in plan.positions.iter().zip(kept).filter(|(_, kept)| **kept) {
        let same_row = last.is_some_and(|last| {
            (last.section, last.row) == (position.section, position.row)
                && last.axis.angle(&position.axis) <= limit
        });
        if !same_row {
            rows[position.section] += 1;
        }
        thinned.positions.push(Position { row: rows[position.section] - 1, ..position.clone() });
        last = Some(position);
    }
    for (section, rows) in thinned.sections.iter_mut().zip(rows) {
        section.rows = rows;
    }
    Ok(measure(context, thinned, columns, monitor)?)
}
