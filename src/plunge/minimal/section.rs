//! `minimal` for one section: rows are planned one after the other, each after the plunges of all previous
//! ones, in the cutting direction that leaves less.

use super::path::{MIN_SAVED_SHARE, MINIMAL_MAX_LIFT_SHARE};
use super::row_stages::{COST_OF_NEW_ROW, RowStages};
use super::rows::{
    CutPath, RowOf, RowPlaces, cut_path, cut_split, max_side_shifts, rows_of_stretch, with_row_search,
};
use super::second_pass::{OpenRow, cut_open_places};
use super::touch_up::add_extras;
use super::{PathSearch, RowCrossing, RowPath};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::plunge::context::PlanContext;
use crate::plunge::cut::SectionCut;
use crate::plunge::error::PlanError;
use crate::plunge::locked::{cut_waiting, lock_into_row};
use crate::plunge::row::RowMaker;
use crate::plunge::section_layout::StretchLayout;
use crate::setup::CutDirection;

/// Lift from which on a place of a row is entered from the previous row, in cutter radii.
const CROSSING_RADII: f64 = 1.0;

/// Maximum number of places at which a row is entered from the previous row.
const MAX_CROSSINGS: usize = 3;

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

/// The path of a row. Where it would stop short the row is entered from the previous row, if that saves more
/// than another row costs; these crossings are added to `cut`.
fn path_with_crossings(
    context: &PlanContext,
    search: &PathSearch,
    RowOf { layout, lambdas, row }: RowOf,
    places: &RowPlaces,
    cut: &mut SectionCut,
    stages: &mut RowStages,
) -> Result<RowPath, PlanError> {
    let RowPlaces { s: places, start } = places;
    let RowMaker { lambda, tool, monitor, .. } = search.candidates.maker;
    let mut path = search.path(places, *start, &cut.columns, stages)?;
    let Some(before) = row.checked_sub(1) else { return Ok(path) };
    let mut entered: Vec<f64> = Vec::new();
    while entered.len() < MAX_CROSSINGS
        && let Some(s) = path.first_short(CROSSING_RADII * tool.radius(), &entered)
    {
        entered.push(s);
        let side_shift_from = max_side_shifts(&layout.lane, &layout.stretch, tool, lambdas)[before];
        let crossing = RowCrossing { search, from: lambdas[before], side_shift_from, s };
        let (rows, columns) = (cut.rows.len(), cut.columns.len());
        let stations = crossing.stations(&cut.columns)?;
        let lambda = layout.stretch.lambda_in_channel(*lambda);
        cut_split(context, stations, lambda, tool, cut, &monitor.ignoring_stop())?;
        if cut.columns.len() == columns {
            continue;
        }
        let crossed = search.path(places, *start, &cut.columns, stages)?;
        if path.cost - crossed.cost > COST_OF_NEW_ROW.max(MIN_SAVED_SHARE * path.cost) {
            path = crossed;
        } else {
            cut.rows.truncate(rows);
            cut.columns.truncate(columns);
        }
    }
    Ok(path)
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
                stages.next_row();
                let path = path_with_crossings(context, search, row_of, places, cut, &mut stages)?;
                *acceptable_cost += path.acceptable_cost;
                min_costs.push(path.min_cost);
                let best = cut_path(context, path, search, lambda, &cut.columns, closing)?;
                if !best.has_lost || !is_thorough {
                    return Ok(best);
                }
                let search = PathSearch { is_strict: true, candidates: search.candidates.clone(), ..*search };
                let limit = best.cost + stages.cost_beside_layers();
                match search.path_below(&places.s, places.start, &cut.columns, &mut stages, limit) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::{
        BladeDescription, CamberSpan, CurveDescription, Impeller, Meridional, PartDescription,
    };
    use crate::plunge::opening_section::plan_context;
    use crate::plunge::row_density::RowDensity;
    use crate::plunge::survey::cylinder;
    use crate::setup::{SectionKind, SectionSetup, Setup, Tool};

    /// A blade with the same angle at the outlet of hub and shroud.
    fn blade(leading_edge: f64, theta_deg: f64) -> BladeDescription {
        let span = |span: f64, inlet_deg: f64, thickness: [f64; 2]| CamberSpan {
            span,
            leading_edge,
            theta_leading_edge: theta_deg.to_radians(),
            angle: vec![(0.0, inlet_deg.to_radians()), (1.0, 38.8f64.to_radians())],
            thickness: vec![(0.0, thickness[0]), (1.0, thickness[1])],
        };
        BladeDescription::Camber {
            spans: vec![span(0.0, 27.5, [4.5, 3.4]), span(1.0, 40.8, [1.7, 2.3])],
            line: 0,
        }
    }

    /// A wheel with splitters, and with channels ten diameters of the cutter deep.
    fn deep_wheel() -> Impeller {
        let curve = |control: [[f64; 2]; 4]| CurveDescription::BSpline {
            control: control.map(|[r, z]| Meridional { r, z }).to_vec(),
            degree: 3,
            knots: Vec::new(),
        };
        let part = PartDescription {
            name: "deep".to_owned(),
            hub: curve([[74.1, 0.0], [74.1, 100.2], [138.7, 161.7], [235.6, 161.7]]),
            shroud: curve([[135.9, 0.0], [135.9, 80.2], [170.8, 129.4], [235.6, 129.4]]),
            blade_count: 12,
            main: blade(0.06, 0.0),
            splitters: vec![blade(0.42, 15.0)],
            hub_line: 0,
            shroud_line: 0,
            count_line: 0,
            notes: Vec::new(),
            roles_by_shape: false,
        };
        Impeller::build(&part).expect("an impeller")
    }

    /// The last row of the first lane is beside a splitter, whose side turns its axes so far in the middle of
    /// the row that it begins anew there.
    #[test]
    fn a_row_that_begins_anew_in_full_stock_is_entered_from_the_side() {
        let cutter = Tool { number: 1, insert_width: 2.7, overhang: 95.0, ..cylinder(6.0) };
        let mut setup = Setup { tools: vec![cutter], ..Setup::default() };
        setup.plunge.max_axis_change_rad = 8.67f64.to_radians();
        setup.plunge.sections =
            vec![SectionSetup { tool: 1, from: 1.0, to: 0.8, cut_direction: None, kind: SectionKind::Rows }];
        let workpiece = setup.allowances.workpiece_of(deep_wheel());
        let context = plan_context(&workpiece, &setup, RowDensity::Dense);
        let layout = &context.layouts(0).expect("the cutter fits")[0];
        let lambdas = rows_of_stretch(&context, layout, &setup.tools[0]);
        let (feed, monitor) = (CutDirection::OutletToInlet, Monitor::default());
        let mut cut = SectionCut::empty(feed, context.opening.clone());
        // The last row and the one before it: how far their plunges stop short with and without crossings,
        // mm.
        let [_, (without, with)] = [lambdas.len() - 2, lambdas.len() - 1].map(|row| {
            let row_of = RowOf { layout, lambdas: &lambdas, row };
            with_row_search(&context, 0, row_of, feed, &monitor, |search, places| {
                let mut stages = RowStages::default();
                let path = search.path(&places.s, places.start, &cut.columns, &mut stages).expect("a path");
                let without = path.highest_lift();
                let path = path_with_crossings(&context, search, row_of, places, &mut cut, &mut stages);
                let path = path.expect("a path");
                let with = path.highest_lift();
                let row = cut_path(&context, path, search, lambdas[row], &cut.columns, &monitor);
                cut.columns = row.expect("a row").columns;
                (without, with)
            })
            .expect("not cancelled")
        });
        let radius = setup.tools[0].radius();
        assert!(without > radius, "the row is free from its start: {without} mm");
        assert!(with < 0.1 * radius, "plunges stop {with} mm short");
    }
}
