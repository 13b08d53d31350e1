//! The policy `conventional` ([plunge paper], stages 1 and 2): axes along the walls, as close as the step
//! limit asks. Cores may meet stock.

use super::context::PlanContext;
use super::cut::{PlannedRow, SectionCut};
use super::error::PlanError;
use super::row_plan::{Contacts, RowAttempts, cut_rows};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;

/// Plans section `index` after the plunges of `columns`.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn plan_section(
    context: &PlanContext,
    index: usize,
    columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    cut_rows(context, index, columns, None, &plan_row, monitor)
}

/// Plans one row, from the first start that is free of stock.
pub(super) fn plan_row(row: &RowAttempts) -> Result<PlannedRow, PlanError> {
    let Some(start) = row.find_free_start(|_, first| first) else {
        row.maker.monitor.check()?;
        return Ok(PlannedRow::empty(row.maker.lambda));
    };
    let planned = row.converge(&start, Contacts::Allowed, |conventional, _| Some(conventional.to_vec()))?;
    Ok(planned.unwrap_or_else(|| PlannedRow::empty(row.maker.lambda)))
}
