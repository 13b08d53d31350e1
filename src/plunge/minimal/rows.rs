//! Rows of a section: their places, the search for their axes, and their cuts.

use super::path::MINIMAL_MAX_LIFT_SHARE;
use super::{CandidateMaker, PathSearch, RowPath};
use crate::cutting::contact::{BlankTop, Columns};
use crate::geometry::wrap_angle;
use crate::monitor::Monitor;
use crate::plunge::assembly::DropCause;
use crate::plunge::context::PlanContext;
use crate::plunge::cut::{CutRow, PlannedRow, SectionCut, cut_row};
use crate::plunge::error::PlanError;
use crate::plunge::lane::{AxisEnds, Lane, is_wall};
use crate::plunge::reasons::DropReason;
use crate::plunge::row::{RowMaker, Station};
use crate::plunge::row_places::{row_ends, row_maker};
use crate::plunge::section_layout::{PassageStretch, StretchLayout};
use crate::plunge::spacing::max_shroud_spacing;
use crate::setup::{CutDirection, Tool};

/// Distance before its start at which a row may begin, in cutter diameters.
const RUN_UP_DIAMETERS: f64 = 1.5;
/// Layer e for which the square term of the cost equals e, in cutter radii.
pub const SCALE_RADII: f64 = 0.5;

/// Height of the wedge under a leaning wall from which on a row is inserted beside that wall, in cutter
/// radii.
const WEDGE_RADII: f64 = 0.2;

/// Lift from which on a place counts as open: it is tried again once all rows are cut, in cutter radii.
pub(super) const SHORT_RADII: f64 = 0.3;

/// A row as its path was cut.
pub(super) struct CutPath {
    pub row: CutRow,
    /// All plunges up to the end of the row.
    pub columns: Columns,
    /// Cost of the path with the lifts it was cut with, mm.
    pub cost: f64,
    /// s of its places from the start on at which a plunge stops far short or is left out, and the lift, mm;
    /// infinite for one that is left out.
    pub short: Vec<(f64, f64)>,
    /// Whether plunges of the path were left out.
    pub has_lost: bool,
    /// See [`RowPath::missing`].
    pub missing: Vec<(f64, DropCause)>,
}

impl CutPath {
    /// `short`, with the places that the path does not reach because of contact.
    pub fn open(&self) -> Vec<(f64, f64)> {
        let missing = self.missing.iter().filter(|(_, cause)| cause.why == DropReason::Contact);
        let mut open = self.short.clone();
        open.extend(missing.map(|(s, _)| (*s, f64::INFINITY)));
        open
    }
}

/// A row to be planned: its layout, λ of all rows of the stretch, and its index among them.
#[derive(Clone, Copy)]
pub(super) struct RowOf<'l> {
    pub layout: &'l StretchLayout<'l>,
    pub lambdas: &'l [f64],
    pub row: usize,
}

/// Places of a row: its stages, and the s at which it starts.
pub(super) struct RowPlaces {
    pub s: Vec<f64>,
    pub start: f64,
}

/// Calls `plan` with the search of a row, cut in direction `feed`, and its places.
pub(super) fn with_row_search<T>(
    context: &PlanContext,
    index: usize,
    RowOf { layout, lambdas, row }: RowOf,
    feed: CutDirection,
    monitor: &Monitor,
    plan: impl FnOnce(&PathSearch, &RowPlaces) -> T,
) -> Result<T, PlanError> {
    let StretchLayout { stretch, lane, .. } = layout;
    let tool = context.tool_of_section(index)?;
    let top = BlankTop::new(&context.workpiece.blank);
    let inward = feed.sign_along_s();
    let (start, end) = row_ends(context, index, stretch, inward);
    let maker = row_maker(context, layout, tool, (lambdas[row], lambdas.len()), feed, monitor);
    let search = PathSearch {
        candidates: CandidateMaker {
            floor: &|s| floor_of_row(context, stretch, lane, lambdas, row, s),
            max_side_shift: max_side_shifts(lane, stretch, tool, lambdas)[row],
            ..candidate_maker(context, &maker, &top)
        },
        blank: &context.workpiece.blank,
        max_axis_change_rad: context.setup.plunge.max_axis_change_rad,
        is_strict: false,
        refines: context.thoroughness(index).is_full(),
    };
    let run_up = RUN_UP_DIAMETERS * tool.diameter / context.workpiece.part.hub.length() * inward;
    let s = stage_positions(&maker, start + run_up, start, end);
    Ok(plan(&search, &RowPlaces { s, start }))
}

/// Cuts the path of a row at `lambda` of the channel after the plunges of `earlier`.
pub(super) fn cut_path(
    context: &PlanContext,
    path: RowPath,
    search: &PathSearch,
    lambda: f64,
    earlier: &Columns,
    monitor: &Monitor,
) -> Result<CutPath, PlanError> {
    let maker = search.candidates.maker;
    let mut stations: Vec<Station> =
        path.steps.iter().filter_map(|step| maker.exact(&step.station)).collect();
    // Where the way out of the blank is oblique the exact axis may be much deeper in it than its draft.
    stations.retain(|station| search.candidates.is_long_enough(station));
    fill_steps(maker, &search.candidates, &mut stations);
    let row = PlannedRow { stations, iterations: 1, ..PlannedRow::empty(lambda) };
    let mut columns = earlier.clone();
    let row = cut_row(context, row, maker.tool, Some(MINIMAL_MAX_LIFT_SHARE), &mut columns, monitor)?;
    let cost = path.cost_as_cut(search.candidates.scale, |s| row.lift_at(s));
    let lift_of = |s: f64| row.lift_at(s).unwrap_or(f64::INFINITY);
    let has_lost = path.steps.iter().any(|step| lift_of(step.station.ends.s_hub).is_infinite());
    let cut_to = path.places().map(|s| (s, lift_of(s)));
    let short = cut_to.filter(|(_, lift)| *lift > SHORT_RADII * maker.tool.radius()).collect();
    Ok(CutPath { row, columns, cost, short, has_lost, missing: path.missing })
}

/// Candidates of a row without a floor to clear and without limit of its tilt angle.
pub(super) fn candidate_maker<'r>(
    context: &'r PlanContext,
    maker: &'r RowMaker<'r>,
    top: &'r BlankTop<'r>,
) -> CandidateMaker<'r> {
    let stock = &context.setup.allowances;
    CandidateMaker {
        maker,
        finished: &context.workpiece.finished,
        top,
        hub_allowance: stock.hub_allowance,
        blade_allowance: stock.blade_allowance,
        max_tilt_rad: context.setup.plunge.max_tilt_rad,
        machine: &context.setup.machine,
        assembly: context.assembly_rule(maker.tool),
        opened: context.workpiece.blank.outline().map(|_| (context.opening.all(), &context.workpiece.blank)),
        scale: SCALE_RADII * maker.tool.radius(),
        floor: &|_| None,
        max_side_shift: f64::INFINITY,
        fineness: 1,
    }
}

/// Cuts the stations of a row at `lambda` of the channel and adds them to `cut`, split into several rows
/// where the axis turns too much.
pub(super) fn cut_split(
    context: &PlanContext,
    stations: Vec<Station>,
    lambda: f64,
    tool: &Tool,
    cut: &mut SectionCut,
    monitor: &Monitor,
) -> Result<(), PlanError> {
    let row = PlannedRow { stations, iterations: 1, ..PlannedRow::empty(lambda) };
    let row = cut_row(context, row, tool, Some(MINIMAL_MAX_LIFT_SHARE), &mut cut.columns, monitor)?;
    cut.rows.extend(row.split_where_axes_turn(context.setup.plunge.max_axis_change_rad));
    Ok(())
}

/// Floor that row `row` has to clear at `s`: from half way to the previous row (or the wall's foot) to
/// half way to the next, as angles about Z from its M, rad. Rows without an axis at `s` are passed over.
fn floor_of_row(
    context: &PlanContext,
    stretch: &PassageStretch,
    lane: &Lane,
    rows: &[f64],
    row: usize,
    s: f64,
) -> Option<[f64; 2]> {
    let at = |lambda: f64| Some(lane.reference_axis(lambda, s)?.theta_hub);
    let here = at(rows[row])?;
    let walls = stretch.passage.wall_angles(&context.workpiece.part, s.clamp(0.0, 1.0), 0.0);
    let margin = context.setup.allowances.blade_allowance / context.workpiece.part.hub.point(s).r
        * context.workpiece.part.pitch().signum();
    let half_way = |other: usize| Some(0.5 * wrap_angle(at(rows[other])? - here));
    let foot = |wall: usize| {
        // Beyond the ends of a blade its end is used.
        let walls = walls?;
        let inward = if wall == 0 { margin } else { -margin };
        Some(wrap_angle(walls[wall] + inward - here))
    };
    let from = (0..row).rev().find_map(half_way).or_else(|| foot(0))?;
    let to = (row + 1..rows.len()).find_map(half_way).or_else(|| foot(1))?;
    Some([from, to])
}

/// λ of the rows, in dense plans with one more beside each wall that leans over the channel: half way to the
/// next row the tilt angle can be smaller, which removes part of the wedge under the wall.
pub(super) fn rows_of_stretch(context: &PlanContext, layout: &StretchLayout, tool: &Tool) -> Vec<f64> {
    let StretchLayout { stretch, lane, rows, .. } = layout;
    let mut lambdas: Vec<f64> = rows.iter().map(|row| row.lambda).collect();
    if lambdas.len() < 2 || !context.density.has_rows_beside_walls() {
        return lambdas;
    }
    let gap = lambdas[1];
    let wedge = |wall: usize| {
        (0..=8)
            .filter_map(|i| lane.lean_over(wall, stretch.s_at(f64::from(i) / 8.0)))
            .map(|lean| tool.diameter * lean.sin())
            .fold(0.0, f64::max)
    };
    for (wall, side) in [(0usize, 1.0), (1, -1.0)] {
        if wedge(wall) > WEDGE_RADII * tool.radius() {
            lambdas.push(wall as f64 + 0.5 * side * gap);
        }
    }
    lambdas.sort_by(f64::total_cmp);
    lambdas
}

/// Maximum displacement of W across each row without uncut stock between neighbours at the shroud, mm. It
/// grows with the distance from the walls, as neighbouring rows may be displaced together.
pub(super) fn max_side_shifts(lane: &Lane, stretch: &PassageStretch, tool: &Tool, rows: &[f64]) -> Vec<f64> {
    let widest = (0..=8)
        .filter_map(|i| lane.width(stretch.s_at(f64::from(i) / 8.0)))
        .fold(0.0, |widest: f64, (_, shroud)| widest.max(shroud));
    let slack = |i: usize| (max_shroud_spacing(tool) - widest * (rows[i + 1] - rows[i])).max(0.0);
    (0..rows.len())
        .map(|i| {
            let before: f64 = (0..i).map(slack).sum();
            let after: f64 = (i..rows.len() - 1).map(slack).sum();
            before.min(after)
        })
        .collect()
}

/// s of the stages of a row from `run_up` over `start` to `end`, no further apart than the step limit on hub
/// and shroud for conventional axes.
fn stage_positions(maker: &RowMaker, run_up: f64, start: f64, end: f64) -> Vec<f64> {
    let length = maker.part.hub.length().max(maker.part.shroud.length());
    let coarse = (((end - start).abs() * length / maker.step_limit / 3.0).ceil() as usize).clamp(1, 4000);
    let at = |i: usize| start + (end - start) * i as f64 / coarse as f64;
    let mut widest = (end - start).abs() / coarse as f64 * length;
    let mut before: Option<Station> = None;
    for i in 0..=coarse {
        let station = maker.isoparametric(at(i));
        if let (Some(a), Some(b)) = (&before, &station) {
            widest = widest.max(maker.spacing(a, b));
        }
        before = station;
    }
    let per_gap = (widest / maker.step_limit - 1e-9).ceil().clamp(1.0, 64.0) as usize;
    let count = coarse * per_gap;
    let step = (end - start) / count as f64;
    let first = ((run_up - start).abs() / step.abs()).ceil() as usize;
    (0..=first + count).map(|i| start + step * (i as f64 - first as f64)).collect()
}

/// Stage 2 of the planning loop: inserts stations between those whose spacing exceeds the step limit.
fn fill_steps(maker: &RowMaker, candidates: &CandidateMaker, stations: &mut Vec<Station>) {
    for _ in 0..6 {
        let mut filled: Vec<Station> = Vec::with_capacity(stations.len());
        for pair in stations.windows(2) {
            filled.push(pair[0]);
            if maker.needs_another(&pair[0], &pair[1], pair[1].ends.s_hub - pair[0].ends.s_hub) {
                filled.extend(station_between(maker, candidates, &pair[0].ends, &pair[1].ends));
            }
        }
        filled.extend(stations.last());
        let done = filled.len() == stations.len();
        *stations = filled;
        if done {
            break;
        }
    }
}

/// The station midway between two, if it clears the blades and the tool is long enough for it.
fn station_between(
    maker: &RowMaker,
    candidates: &CandidateMaker,
    a: &AxisEnds,
    b: &AxisEnds,
) -> Option<Station> {
    let middle = |x: f64, y: f64| 0.5 * (x + y);
    let (s_hub, s_shroud) = (middle(a.s_hub, b.s_hub), middle(a.s_shroud, b.s_shroud));
    let ends = if is_wall(maker.lambda) {
        maker.lane.row_axis(maker.lambda, s_hub, s_shroud)?
    } else {
        AxisEnds {
            s_hub,
            s_shroud,
            theta_hub: middle(a.theta_hub, b.theta_hub),
            theta_shroud: middle(a.theta_shroud, b.theta_shroud),
        }
    };
    let station = maker.exact(&maker.lower_to_hub(ends))?;
    (candidates.is_allowed(&station) && candidates.is_long_enough(&station)).then_some(station)
}
