//! The loop of [plunge paper], fig. 16: conventional positions → step inspection → axis optimisation →
//! drop-cutter depth and safe height, repeated until it converges; then contact and clearances are measured.
//!
//! Here are the sections in sequence and the plan put together from them. A section goes to its policy in
//! `policies`, its rows are cut in `cut`, the plan is measured in `evaluation`.

use std::sync::Arc;

use super::assembly::DropCause;
use super::context::PlanContext;
use super::cut::{CutRow, PlacedCutter, SectionCut};
use super::opening::with_needed_opening;
use super::plan::{Dropped, PlungePlan, Position, SectionPlan, Unevaluated};
use super::policies::plan_section;
use super::row::Station;
use super::section_cache::SectionCache;
use crate::cutting::contact::Columns;
use crate::error::UserError;
use crate::monitor::{Cancelled, Monitor};
use crate::setup::{AxisPolicy, SetupFault, SetupPlace, tool_of};

/// Why planning failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part and setup do not match.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<PlanError> for UserError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(cancelled) => cancelled.into(),
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// A plan with final axes and depths; contact with stock and retract points are not computed yet.
#[derive(Debug)]
pub struct PlacedPlan {
    pub(super) plan: PlungePlan<Unevaluated>,
    /// Its plunges.
    pub(super) columns: Columns,
}

impl PlacedPlan {
    /// The plan without its evaluation.
    pub fn plan(&self) -> &PlungePlan<Unevaluated> {
        &self.plan
    }
}

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
        let cut = match cuts.last().filter(|last| last.is_unfinished()) {
            Some(last) => Arc::new(SectionCut::not_started(section, last.columns.clone())),
            None => known.get_or_make(index, context.setup, make)?,
        };
        cuts.push(cut);
        let planned = cuts.iter().flat_map(|cut| &cut.rows).map(|row| row.placed.len()).sum();
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

/// Assembles the plan of these sections with all their plunges.
pub(super) fn assemble_all(
    context: &PlanContext,
    policy: AxisPolicy,
    cuts: &[Arc<SectionCut>],
) -> Result<PlacedPlan, PlanError> {
    let mut plan = PlungePlan {
        policy,
        sections: Vec::new(),
        positions: Vec::new(),
        dropped: Vec::new(),
        iterations: 0,
        converged: true,
    };
    for (index, (section, cut)) in context.setup.plunge.sections.iter().zip(cuts).enumerate() {
        let tool = tool_of(context.setup, section.tool)?;
        let rule = context.assembly_rule(tool);
        plan.sections.push(SectionPlan {
            tool: tool.clone(),
            from: section.from,
            to: section.to,
            feed: cut.feed,
            rows: cut.rows.len(),
            kind: section.kind,
            added: cut.added,
        });
        for (row_index, CutRow { row, placed }) in cut.rows.iter().enumerate() {
            plan.iterations = plan.iterations.max(row.iterations);
            plan.converged &= row.converged;
            let missing = row.missing.iter();
            plan.dropped.extend(missing.map(|&(s, DropCause { why, stick_out })| Dropped {
                section: index,
                row: row_index,
                s,
                why,
                stick_out,
            }));
            for (station, placed) in row.stations.iter().zip(placed) {
                let placed = match placed {
                    Ok(placed) => placed,
                    Err(why) => {
                        let s = station.ends.s_hub;
                        let cause = match &rule {
                            Some(rule) => rule.cause(*why, (station.tip, station.axis), f64::INFINITY),
                            None => (*why).into(),
                        };
                        let DropCause { why, stick_out } = cause;
                        plan.dropped.push(Dropped { section: index, row: row_index, s, why, stick_out });
                        continue;
                    }
                };
                plan.positions.push(placed_position(station, placed, (index, row_index), row.lambda));
            }
        }
    }
    if plan.positions.is_empty() && plan.is_unfinished() {
        return Err(Cancelled.into());
    }
    let columns = cuts.last().map(|cut| cut.columns.clone()).unwrap_or_default();
    Ok(PlacedPlan { plan, columns })
}

/// The position of a cutter that is placed at `station`, in a section and row.
fn placed_position(
    station: &Station,
    placed: &PlacedCutter,
    (section, row): (usize, usize),
    lambda: f64,
) -> Position<Unevaluated> {
    Position {
        tip: placed.cutter.tip,
        axis: station.axis,
        section,
        row,
        s: station.ends.s_hub,
        lambda,
        alpha_rad: station.alpha_rad,
        contact_point: station.contact_point,
        lift: placed.lift,
        blocked: station.blocked,
        limited_by: station.limited_by,
        hub_clearance: placed.hub_clearance,
        blade_clearance: placed.blade_clearance,
        evaluation: Unevaluated,
    }
}
