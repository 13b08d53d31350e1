//! Single plunges that `minimal` adds to the rows of a section where they left the most, and rest milling
//! with a smaller cutter: single plunges only, where the layer is still thick.

use super::extras::PoolFan;
use super::pool_rounds::{PoolRounds, feet_along};
use super::rows::{SCALE_RADII, candidate_maker, rows_of_stretch};
use super::uncut_floor::cut_uncut_floor;
use super::{CandidateMaker, ExtraSearch, FloorHeightMap};
use crate::cutting::contact::{BlankTop, Columns};
use crate::monitor::Monitor;
use crate::plunge::choice::rest::{rest_threshold, rest_threshold_after};
use crate::plunge::context::PlanContext;
use crate::plunge::cut::SectionCut;
use crate::plunge::error::PlanError;
use crate::plunge::locked::cut_waiting;
use crate::plunge::position_limit::MAX_POSITIONS;
use crate::plunge::reasons::{AddedPlunges, StopReason};
use crate::plunge::row::RowMaker;
use crate::plunge::row_places::{row_ends, row_maker};
use crate::plunge::section_layout::{StretchLayout, section_layout};
use crate::setup::tool_of;

/// Settings of a search for single plunges.
#[derive(Clone, Copy, Debug)]
struct ExtraSettings {
    /// Minimum gain in each round, in multiples of the search's minimum: plunges with a large gain come
    /// first, as they free others of contact.
    rounds: &'static [f64],
    /// Spacing of the tried plunges along the channel, in step limits.
    step_share: f64,
    /// Maximum number of parts into which the gap between two rows is divided.
    parts: usize,
}

/// For additions to the rows of a section.
const BESIDE_ROWS: ExtraSettings = ExtraSettings { rounds: &[4.0, 2.0, 1.0], step_share: 0.5, parts: 4 };
/// As [`BESIDE_ROWS`], for rows of many places.
const BESIDE_MANY: ExtraSettings = ExtraSettings { rounds: &[4.0, 2.0], step_share: 0.75, parts: 2 };
/// For rest milling. The previous cutter is about twice as large, so its minimum gain is about eight times as
/// large. A plunge of the smaller cutter takes as much time, so it has to gain several times that.
const REST_MILLING: ExtraSettings = ExtraSettings { rounds: &[52.0, 26.0, 13.0], step_share: 0.7, parts: 3 };
/// As [`REST_MILLING`], after rows of many places.
const REST_AFTER_MANY: ExtraSettings = ExtraSettings { rounds: &[52.0, 26.0], step_share: 1.05, parts: 2 };
/// Maximum number of added plunges per plunge of the rows.
const MAX_ADDED_SHARE: usize = 2;
/// Number of positions from which on a plan gets no added plunges: the rest of the limit is reserved for
/// rows.
const MAX_POSITIONS_WITH_EXTRAS: usize = MAX_POSITIONS / 2;
/// Minimum spacing of tried plunges, in cutter radii.
const MIN_SPACING_RADII: f64 = 0.12;
/// Share of a stretch's floor that must have thick stock for rest milling.
const THICK_SHARE: f64 = 0.04;

/// Limits of the plunges to add.
#[derive(Clone, Copy, Debug)]
struct ExtraLimits {
    /// Maximum number for the section, and the number left until the limit of the whole plan.
    max_count: usize,
    left_in_plan: usize,
    /// Settings of the search.
    manner: ExtraSettings,
    /// Plunges are added only where stock is more than this above the allowance, and only if it is so on at
    /// least [`THICK_SHARE`] of the floor, mm.
    above: Option<f64>,
    /// If stock is more than this above the allowance on that share after the first round, the other rounds
    /// are left to a smaller cutter, mm.
    rest_from: Option<f64>,
}

/// Adds plunges where the rows of a section left the most, up to a multiple of their number.
pub(super) fn add_extras(
    context: &PlanContext,
    index: usize,
    cut: &mut SectionCut,
    monitor: &Monitor,
) -> Result<(), PlanError> {
    let planned: usize = cut.rows.iter().map(|row| row.len()).sum();
    let left_in_plan = MAX_POSITIONS_WITH_EXTRAS.saturating_sub(cut.columns.len());
    let rest_from = rest_threshold_after(context.setup, index)?;
    let most = MAX_ADDED_SHARE * planned;
    let manner = if context.thoroughness(index).is_full() { BESIDE_ROWS } else { BESIDE_MANY };
    let wanted = ExtraLimits { max_count: most, left_in_plan, manner, above: None, rest_from };
    add_plunges(context, index, context.layouts(index)?, cut, wanted, monitor)
}

/// Plans section `index`, a rest-milling section: no rows, only single plunges where earlier sections
/// left a thick layer.
///
/// # Errors
/// As [`Planner::plan`](crate::plunge::Planner::plan).
pub(in crate::plunge) fn rest_section(
    context: &PlanContext,
    index: usize,
    columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    let section = context.section(index);
    let layouts = section_layout(context.workpiece, context.setup, section, context.density)?;
    let above = Some(rest_threshold(tool_of(context.setup, section.tool)?));
    let left_in_plan = MAX_POSITIONS_WITH_EXTRAS.saturating_sub(columns.len());
    let mut cut = SectionCut::empty(section.direction(), columns);
    cut_waiting(context, index, context.locked(index), &mut cut, &monitor.ignoring_stop())?;
    let manner = if context.thoroughness(index).is_full() { REST_MILLING } else { REST_AFTER_MANY };
    let wanted = ExtraLimits { max_count: left_in_plan, left_in_plan, manner, above, rest_from: None };
    add_plunges(context, index, &layouts, &mut cut, wanted, monitor)?;
    Ok(cut)
}

fn add_plunges(
    context: &PlanContext,
    index: usize,
    layouts: &[StretchLayout],
    cut: &mut SectionCut,
    wanted: ExtraLimits,
    monitor: &Monitor,
) -> Result<(), PlanError> {
    if monitor.is_stopped() {
        cut.added = Some(AddedPlunges::UNFINISHED);
        return Ok(());
    }
    let stock = &context.setup.allowances;
    let tool = context.tool_of_section(index)?;
    let top = BlankTop::new(&context.workpiece.blank);
    let scale = SCALE_RADII * tool.radius();
    let allowances = (stock.hub_allowance, stock.blade_allowance);
    let most = wanted.left_in_plan.min(wanted.max_count);
    let (mut added_in_all, mut stopped) = (0, StopReason::NothingWorthwhile);
    for layout in layouts.iter().take_while(|_| !monitor.is_stopped()) {
        let mut floor =
            FloorHeightMap::new(&context.workpiece.part, &layout.stretch, tool, allowances, scale);
        for column in cut.columns.as_slice().iter().take_while(|_| !monitor.is_cancelled()) {
            floor.cut(&context.workpiece.part, &column.cutter);
        }
        if wanted.above.is_some_and(|above| floor.share_above(above) < THICK_SHARE) {
            continue;
        }
        let rows = rows_of_stretch(context, layout, tool);
        let nearest = MIN_SPACING_RADII * tool.radius();
        let width = (0..=8)
            .filter_map(|i| layout.lane.width(layout.stretch.s_at(f64::from(i) / 8.0)))
            .fold(0.0, |widest: f64, (hub, _)| widest.max(hub));
        let lambdas = between_rows(&rows, nearest / width.max(1e-6), wanted.manner.parts);
        let maker =
            |&lambda: &f64| row_maker(context, layout, tool, (lambda, lambdas.len()), cut.feed, monitor);
        let makers: Vec<RowMaker> = lambdas.iter().map(maker).collect();
        let Some(first) = makers.first() else { continue };
        let ends = row_ends(context, index, &layout.stretch, cut.feed.sign_along_s());
        let step =
            (wanted.manner.step_share * first.step_limit).max(nearest) / context.workpiece.part.hub.length();
        let is_wanted = |row: usize, s: f64| match wanted.above {
            Some(above) => makers[row]
                .lane
                .isoparametric(makers[row].lambda, s)
                .map(|ends| makers[row].lane.line(&ends))
                .is_some_and(|(foot, axis)| {
                    floor.is_thick_under(&context.workpiece.part, &tool.placed(foot, axis), above)
                }),
            None => true,
        };
        let feet = feet_along(makers.len(), ends, step, is_wanted);
        let candidates: Vec<CandidateMaker> =
            makers.iter().map(|maker| candidate_maker(context, maker, &top)).collect();
        let search = ExtraSearch::new(&candidates, PoolFan::Row, &feet, floor, &context.workpiece.blank);
        let (stretch, budget) = (&layout.stretch, most / layouts.len());
        let mut pool = PoolRounds { context, stretch, tool, lambdas: &lambdas, search, budget };
        for (round, &times) in wanted.manner.rounds.iter().enumerate() {
            if round > 0
                && let Some(above) = wanted.rest_from
                && pool.search.floor().share_above(above) >= THICK_SHARE
            {
                stopped = StopReason::SmallerCutter;
                break;
            }
            added_in_all += pool.cut(times, cut, monitor)?;
        }
        let is_left = |above| pool.search.floor().share_above(above) >= THICK_SHARE;
        if !wanted.rest_from.is_some_and(is_left) {
            let floor = pool.search.into_floor();
            // The limit per plunge of the rows is for thinner layers.
            let most = wanted.left_in_plan.saturating_sub(added_in_all) / layouts.len();
            added_in_all += cut_uncut_floor(context, (index, layout), floor, cut, most, monitor)?;
        }
        if pool.budget == 0 && most > 0 {
            stopped = if wanted.left_in_plan <= wanted.max_count {
                StopReason::PlanFull
            } else {
                StopReason::ShareReached
            };
        }
    }
    if monitor.is_stopped() {
        stopped = StopReason::Cancelled;
    }
    cut.added = Some(AddedPlunges { count: added_in_all, stopped });
    Ok(())
}

/// The λ of `rows` and of more between them, no closer than `nearest`.
fn between_rows(rows: &[f64], nearest: f64, max_parts: usize) -> Vec<f64> {
    let mut lambdas = rows.to_vec();
    for pair in rows.windows(2) {
        let parts = (((pair[1] - pair[0]) / nearest) as usize).clamp(1, max_parts);
        lambdas.extend((1..parts).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64));
    }
    lambdas.sort_by(f64::total_cmp);
    lambdas
}
