//! The loop of [plunge paper], fig. 16: conventional positions → step inspection → axis optimisation →
//! drop-cutter depth and safe height, repeated until it converges; then contact and clearances are measured.
//!
//! Here are the sections in sequence and the plan put together from them. A section goes to its policy in
//! `policies`, its rows are cut in `cut`, the plan is measured in `evaluation`.

use std::sync::Arc;

use super::context::PlanContext;
use super::cut::SectionCut;
use super::error::PlanError;
use super::needed_opening::with_needed_opening;
use super::policies::plan_section;
use super::section_cache::SectionCache;
use super::whole_plan::{PlacedPlan, assemble_all};
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, SetupPlace, tool_of};

/// The first half of planning: positions, axes and depths.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn place_plunges(
    context: &PlanContext,
    policy: AxisPolicy,
    known: &mut SectionCache,
    monitor: &Monitor,
) -> Result<PlacedPlan, PlanError> {
    // Enters the rayon pool once; otherwise every small parallel task would cross threads.
    rayon::scope(|_| place_plunges_in_pool(context, policy, known, monitor))
}

/// [`place_plunges`], running on a thread of the pool.
fn place_plunges_in_pool(
    context: &PlanContext,
    policy: AxisPolicy,
    known: &mut SectionCache,
    monitor: &Monitor,
) -> Result<PlacedPlan, PlanError> {
    let mut cuts: Vec<Arc<SectionCut>> = Vec::new();
    known.invalidate(context.setup)?;
    let sections = &context.setup.plunge.sections;
    let gives_up = context.ends_where_starved && policy == AxisPolicy::Minimal;
    for (index, section) in sections.iter().enumerate() {
        context.report_section(index, 0.0, monitor);
        let tool = tool_of(context.setup, section.tool)?;
        let place = SetupPlace::Section { index, tool: tool.number };
        let make = |before: Option<&SectionCut>| {
            let columns = before.map(|cut| cut.columns.clone()).unwrap_or_default();
            plan_section(context, index, policy, columns, monitor).map_err(|error| match error {
                PlanError::Setup(fault) if fault.place == SetupPlace::Whole => fault.at(place).into(),
                other => other,
            })
        };
        let ends = |last: &&Arc<SectionCut>| last.is_unfinished() || gives_up && last.is_starved();
        let cut = match cuts.last().filter(ends) {
            Some(last) => Arc::new(SectionCut::not_started(section, last.columns.clone())),
            None => known.get_or_make(index, context.setup, make)?,
        };
        cuts.push(cut);
        let planned = cuts.iter().flat_map(|cut| &cut.rows).map(|row| row.stations.len()).sum();
        context.check_count(planned, tool, place)?;
    }
    known.store_complete(sections.len());
    let placed = assemble_plan(context, policy, cuts)?;
    monitor.report(0.85);
    Ok(placed)
}

/// Assembles the plan of these sections, with those plunges above the shroud that it needs.
pub(super) fn assemble_plan(
    context: &PlanContext,
    policy: AxisPolicy,
    cuts: Vec<Arc<SectionCut>>,
) -> Result<PlacedPlan, PlanError> {
    let PlacedPlan { plan, columns } = assemble_all(context, policy, &cuts)?;
    let (plan, columns) = with_needed_opening(context, &plan, &columns).unwrap_or((plan, columns));
    Ok(PlacedPlan { plan, columns })
}
