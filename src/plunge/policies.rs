//! Which policy plans a section, and where it decides the axes.
//!
//! | policy | what it does | where |
//! |---|---|---|
//! | `conventional` | axes along the walls; cores may meet stock | `conventional` |
//! | `staircase` | the same axes; plunges stop short of stock | `staircase` |
//! | `monotone` | the lead angle grows along the row | [`super::monotone`] |
//! | `minimal` | the lead angles that leave least, cores free | `minimal`, from `section` on |
//!
//! The first three plan row by row and share the loop of `row_plan`. Rest-milling sections are cut by
//! `minimal` only, those that open the blank are the same for all policies (`opening`).

use super::context::PlanContext;
use super::cut::SectionCut;
use super::error::PlanError;
use super::locked::cut_waiting;
use super::opening_section::opening_section;
use super::{conventional, minimal, monotone, staircase};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, SectionKind};

/// Plans section `index` by `policy` after the plunges of `columns`.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn plan_section(
    context: &PlanContext,
    index: usize,
    policy: AxisPolicy,
    columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    let section = context.section(index);
    match (section.kind, policy) {
        (SectionKind::Opening, _) => opening_section(context, index, columns, monitor),
        (SectionKind::Rest, AxisPolicy::Minimal) => minimal::rest_section(context, index, columns, monitor),
        (SectionKind::Rest, _) => {
            let mut cut = SectionCut::empty(section.direction(), columns);
            cut_waiting(context, index, context.locked(index), &mut cut, monitor)?;
            Ok(cut)
        }
        (SectionKind::Rows, AxisPolicy::Conventional) => {
            conventional::plan_section(context, index, columns, monitor)
        }
        (SectionKind::Rows, AxisPolicy::Staircase) => {
            staircase::plan_section(context, index, columns, monitor)
        }
        (SectionKind::Rows, AxisPolicy::Monotone) => monotone::plan_section(context, index, columns, monitor),
        (SectionKind::Rows, AxisPolicy::Minimal) => minimal::plan_section(context, index, columns, monitor),
    }
}
