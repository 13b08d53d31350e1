//! `minimal` for one section: rows are planned one after the other, each after the plunges of all previous
//! ones, in the cutting direction that leaves less.

use super::path::MINIMAL_MAX_LIFT_SHARE;
use super::row_stages::RowStages;
use super::rows::{CutPath, RowOf, RowPlaces, cut_path, cut_split, rows_of_stretch, with_row_search};
use super::second_pass::{OpenRow, cut_open_places};
use super::touch_up::add_extras;
use super::{PathSearch, RowCrossing};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::plunge::context::PlanContext;
use crate::plunge::cut::SectionCut;
use crate::plunge::error::PlanError;
use crate::plunge::locked::{cut_waiting, lock_into_row};
use crate::plunge::section_layout::StretchLayout;
use crate::setup::CutDirection;

/// Lift of a row's first position from which on the row is entered from the previous row, in cutter radii.
const CROSSING_RADII: f64 = 0.2;

/// Lower bound on the cost of a row in one direction, as a share of its lower bound in the other: the lead
/// angles of the grid mirror each other, floor and walls are the same.
const MIN_COST_SHARE: f64 = 0.9;

/// Share of the cost of a section that cutting it in the other direction has to stay below to be taken: where
/// both leave about as much, rows go on from where earlier sections ended, and more is added beside them.
const TURNED_COST_SHARE: f64 = 0.95;

/// Cost from which on the other direction is tried after rows of many places, in acceptable costs.
const MAX_COST_OF_MANY: f64 = 2.0;

/// A section planned in one cutting direction.
struct DirectedPlan {
    cut: SectionCut,
    /// Cost of its paths, mm.
    cost: f64,
    /// See [`RowPath::acceptable_cost`].
    acceptable_cost: f64,
    /// [`RowPath::min_cost`] of each row, mm.
    min_costs: Vec<f64>,
    /// Rows with places that contact left open.
    open: Vec<OpenRow>,
}

/// Shares of the work on a section, for its progress: the first and the second direction. The rest is for the
/// second pass and the added plunges.
const FIRST_SHARE: f64 = 0.4;
const SECOND_SHARE: f64 = 0.4;

/// Cost that a cutting direction has to stay below to be taken, and its part in the progress of the section.
struct DirectionLimit<'a> {
    /// Cost of the other direction, mm.
    cost: f64,
    /// [`DirectedPlan::min_costs`] of the other direction.
    min_costs: &'a [f64],
    /// Share of the work on the section that is done before this direction, and that of this direction.
    done_before: f64,
    share_of_work: f64,
}

impl DirectionLimit<'_> {
    /// Without another direction.
    const NONE: Self =
        Self { cost: f64::INFINITY, min_costs: &[], done_before: 0.0, share_of_work: FIRST_SHARE };

    /// Whether a section whose first `rows` rows cost `cost` mm cannot get cheaper than the limit.
    fn is_exceeded(&self, rows: usize, cost: f64) -> bool {
        let to_come: f64 = self.min_costs.iter().skip(rows).sum();
        cost + MIN_COST_SHARE * to_come >= self.cost
    }
}

/// Plans section `index` after the plunges of `columns`, in the cutting direction of the setup or else in the
/// one that leaves less.
///
/// # Errors
/// As [`Planner::plan`](crate::plunge::Planner::plan).
pub(in crate::plunge) fn plan_section(
    context: &PlanContext,
    index: usize,
    columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    let plan_in = |feed: CutDirection, limit: &DirectionLimit| {
        plan_in_direction(context, index, &columns, feed, limit, monitor)
    };
    let asked = context.section(index).cut_direction;
    let accepted = if context.thoroughness(index).is_full() { 1.0 } else { MAX_COST_OF_MANY };
    let first = plan_in(asked.unwrap_or(CutDirection::OutletToInlet), &DirectionLimit::NONE)?;
    let other = match &first {
        Some(first)
            if asked.is_none() && first.cost > accepted * first.acceptable_cost && !monitor.is_stopped() =>
        {
            let limit = DirectionLimit {
                cost: TURNED_COST_SHARE * first.cost,
                min_costs: &first.min_costs,
                done_before: FIRST_SHARE,
                share_of_work: SECOND_SHARE,
            };
            plan_in(CutDirection::InletToOutlet, &limit)?
        }
        _ => None,
    };
    // If stopped, discard the incomplete second direction.
    let other = other.filter(|_| !monitor.is_stopped());
    let Some(DirectedPlan { mut cut, open, .. }) = other.or(first) else {
        return Ok(SectionCut::empty(CutDirection::OutletToInlet, columns));
    };
    cut_open_places(context, index, &open, &mut cut, monitor)?;
    add_extras(context, index, &mut cut, monitor)?;
    Ok(cut)
}

/// The section planned in one direction, up to where it is stopped; `None` when it exceeds `limit`.
fn plan_in_direction(
    context: &PlanContext,
    index: usize,
    earlier: &Columns,
    feed: CutDirection,
    limit: &DirectionLimit,
    monitor: &Monitor,
) -> Result<Option<DirectedPlan>, PlanError> {
    let cut = SectionCut::empty(feed, earlier.clone());
    let (min_costs, open) = (Vec::new(), Vec::new());
    let mut directed = DirectedPlan { cut, cost: 0.0, acceptable_cost: 0.0, min_costs, open };
    match plan_rows(context, index, &mut directed, limit, monitor) {
        Err(PlanError::Cancelled(_)) if monitor.is_stopped() => Ok(Some(directed)),
        within => Ok(within?.then_some(directed)),
    }
}

/// Plans row after row into `directed`; `false` when it exceeds `limit`. Its rows are complete even when
/// this ends early.
fn plan_rows(
    context: &PlanContext,
    index: usize,
    directed: &mut DirectedPlan,
    limit: &DirectionLimit,
    monitor: &Monitor,
) -> Result<bool, PlanError> {
    let layouts = context.layouts(index)?;
    let DirectedPlan { cut, cost, acceptable_cost, min_costs, open } = directed;
    let feed = cut.feed;
    let tool = context.tool_of_section(index)?;
    let all_rows: usize = layouts.iter().map(|layout| layout.rows.len()).sum();
    let mut stages = RowStages::default();
    let is_thorough = context.thoroughness(index).is_full();
    // Found paths are cut even after a stop.
    let closing = &monitor.ignoring_stop();
    let mut waiting = context.locked(index);
    for (number, layout) in layouts.iter().enumerate() {
        let StretchLayout { stretch, .. } = layout;
        let lambdas = rows_of_stretch(context, layout, tool);
        for (row, &lambda) in lambdas.iter().enumerate() {
            let row_of = RowOf { layout, lambdas: &lambdas, row };
            let lambda = stretch.lambda_in_channel(lambda);
            let best = with_row_search(context, index, row_of, feed, monitor, |search, places| {
                let RowPlaces { s: places, start } = places;
                stages.next_row();
                let mut path = search.path(places, *start, &cut.columns, &mut stages)?;
                if let Some(first) = path.steps.first()
                    && row > 0
                    && first.lift > CROSSING_RADII * tool.radius()
                {
                    let s = first.station.ends.s_hub;
                    let crossing = RowCrossing { search, from: lambdas[row - 1], s };
                    cut_split(context, crossing.stations(&cut.columns)?, lambda, tool, cut, closing)?;
                    path = search.path(places, *start, &cut.columns, &mut stages)?;
                }
                *acceptable_cost += path.acceptable_cost;
                min_costs.push(path.min_cost);
                let best = cut_path(context, path, search, lambda, &cut.columns, closing)?;
                if !best.has_lost || !is_thorough {
                    return Ok(best);
                }
                let search = PathSearch { is_strict: true, candidates: search.candidates.clone(), ..*search };
                let limit = best.cost + stages.cost_beside_layers();
                match search.path_below(places, *start, &cut.columns, &mut stages, limit) {
                    Ok(None) => {}
                    Ok(Some(path)) => {
                        let strict = cut_path(context, path, &search, lambda, &cut.columns, closing)?;
                        if strict.cost < best.cost {
                            return Ok(strict);
                        }
                    }
                    // A stop during this search leaves the row as it was cut first.
                    Err(_) if monitor.is_stopped() => {}
                    Err(cancelled) => return Err(cancelled.into()),
                }
                Ok::<CutPath, PlanError>(best)
            })??;
            *cost += best.cost;
            let done = (min_costs.len() as f64 / all_rows as f64).min(1.0);
            let share = limit.done_before + limit.share_of_work * done;
            context.report_section(index, share, monitor);
            if limit.is_exceeded(min_costs.len(), *cost) {
                return Ok(false);
            }
            open.extend(OpenRow::new((number, row), best.open()));
            let before = cut.columns.len();
            cut.columns = best.columns;
            let (rule, columns) = ((tool, Some(MINIMAL_MAX_LIFT_SHARE)), (&mut cut.columns, before));
            let row = lock_into_row(context, rule, best.row, columns, &mut waiting, closing)?;
            cut.rows.extend(row.split_where_axes_turn(context.setup.plunge.max_axis_change_rad));
            cut.note_missing(lambda, best.missing);
        }
    }
    cut_waiting(context, index, waiting, cut, closing)?;
    Ok(true)
}
