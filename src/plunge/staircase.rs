//! The policy `staircase`: the axes of [`super::conventional`], but each plunge stops short where its core
//! would meet stock.

use super::context::PlanContext;
use super::conventional::plan_row;
use super::cut::SectionCut;
use super::error::PlanError;
use super::row_plan::cut_rows;
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;

/// Largest lift of a plunge, as a share of its depth in the blank: a plunge that would cut anything is kept.
const STAIRCASE_MAX_LIFT_SHARE: f64 = 1.0;

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
    cut_rows(context, index, columns, Some(STAIRCASE_MAX_LIFT_SHARE), &plan_row, monitor)
}
