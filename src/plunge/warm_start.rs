//! Warm start: a valid plan for a changed setup from the axes of the previous one, shown as a preview while
//! the full search runs. Each cutter is lowered onto the hub again and stops short where its core would meet
//! stock, as in `staircase`; axes along a wall turn until they clear it.

use std::sync::Arc;

use rayon::prelude::*;

use super::context::PlanContext;
use super::cut::{PlannedRow, SectionCut, cut_row};
use super::cycle::assemble_plan;
use super::error::PlanError;
use super::evaluation::evaluate;
use super::minimal::MINIMAL_MAX_LIFT_SHARE;
use super::opening_section::opening_section;
use super::plan::PlungePlan;
use super::row::Station;
use super::row_places::row_maker;
use super::section_cache::SectionCache;
use super::section_layout::{StretchLayout, section_layout};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, SectionKind, Tool, tool_of};

/// Plan with the axes of the last finished plan by `policy` in the cache `known`, fitted to this setup.
/// `None` when there is none, or its sections had other cutters.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn warm_start(
    context: &PlanContext,
    policy: AxisPolicy,
    known: &SectionCache,
    monitor: &Monitor,
) -> Result<Option<PlungePlan>, PlanError> {
    let Some(before) = known.last_complete(context.setup)? else { return Ok(None) };
    let placed = rayon::scope(|_| {
        let mut cuts: Vec<Arc<SectionCut>> = Vec::with_capacity(before.len());
        for (index, before) in before.iter().enumerate() {
            let columns = cuts.last().map(|cut| cut.columns.clone()).unwrap_or_default();
            cuts.push(Arc::new(warm_start_section(context, index, before, columns, monitor)?));
        }
        assemble_plan(context, policy, cuts)
    })?;
    evaluate(context, placed, monitor).map(Some)
}

/// Section `index` with the axes it had `before`, after the plunges of `columns`.
fn warm_start_section(
    context: &PlanContext,
    index: usize,
    before: &SectionCut,
    columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    let section = context.section(index);
    let tool = tool_of(context.setup, section.tool)?;
    if section.kind == SectionKind::Opening {
        return opening_section(context, index, columns, monitor);
    }
    let own;
    let layouts = match context.layouts(index)? {
        [] => {
            own = section_layout(context.workpiece, context.setup, section, context.density)?;
            &own
        }
        layouts => layouts,
    };
    let mut cut = SectionCut { added: before.added, ..SectionCut::empty(before.feed, columns) };
    for row in &before.rows {
        let lambda = row.lambda;
        let stations: Vec<&Station> = row.kept_stations().collect();
        let stations: Vec<Station> = stations
            .into_par_iter()
            .filter_map(|station| refit_station(context, station, lambda, layouts, tool, before, monitor))
            .filter(|station| {
                context.setup.machine.excess_tilt_rad(&context.workpiece.part, &station.axis) <= 0.0
            })
            .collect();
        let row = PlannedRow { stations, iterations: 1, ..PlannedRow::empty(lambda) };
        let row = cut_row(context, row, tool, Some(MINIMAL_MAX_LIFT_SHARE), &mut cut.columns, monitor)?;
        cut.rows.extend(row.split_where_axes_turn(context.setup.plunge.max_axis_change_rad));
    }
    Ok(cut)
}

/// Fits a station of the row at `lambda` of the channel again, keeping its axis where walls allow.
fn refit_station(
    context: &PlanContext,
    station: &Station,
    lambda: f64,
    layouts: &[StretchLayout],
    tool: &Tool,
    before: &SectionCut,
    monitor: &Monitor,
) -> Option<Station> {
    let s = station.ends.s_hub;
    let away = |layout: &&StretchLayout| {
        let StretchLayout { stretch, .. } = layout;
        let (low, high) = stretch.lambdas;
        ((s - stretch.from).max(stretch.to - s).max(0.0), (low - lambda).max(lambda - high).max(0.0))
    };
    let order = |a: (f64, f64), b: (f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    let layout = layouts.iter().min_by(|a, b| order(away(a), away(b)))?;
    // Only rows at a wall are fitted again; axes between the walls are kept.
    let walls = [0.0, 1.0];
    let at_wall = walls.into_iter().find(|&wall| layout.stretch.lambda_in_channel(wall) == lambda);
    let maker = row_maker(context, layout, tool, (at_wall.unwrap_or(0.5), 2), before.feed, monitor);
    let lowered =
        Station { s_shroud_conventional: station.s_shroud_conventional, ..maker.lower_to_hub(station.ends) };
    maker.exact(&lowered)
}
