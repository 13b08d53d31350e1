//! Plunges for floor that no plunge has cut yet: strips under walls that lean over the channel. The axes of
//! rows follow the walls, those added to them are inclined less; these strips need axes that lean further
//! along the wall or over its foot.
//!
//! The search is that of the other added plunges ([`ExtraSearch`]), with a wider fan of axes beside the walls
//! near uncut cells, and on a floor where cutting uncut cells is a gain of its own. Thinner layers still
//! count: the end of a wedge can only be reached once other plunges have cut the stock in front of it.

use super::extras::PoolFan;
use super::pool_rounds::{PoolRounds, feet_along};
use super::rows::candidate_maker;
use super::{CandidateMaker, ExtraSearch, FloorHeightMap};
use crate::cutting::contact::BlankTop;
use crate::monitor::Monitor;
use crate::plunge::context::PlanContext;
use crate::plunge::cut::SectionCut;
use crate::plunge::error::PlanError;
use crate::plunge::row::RowMaker;
use crate::plunge::row_places::{row_ends, row_maker};
use crate::plunge::section_layout::StretchLayout;

/// Uncut share of a stretch's floor from which on the search is worth its time. Less is mostly the corner
/// under a wall, which no axis reaches.
const MIN_UNCUT_SHARE: f64 = 0.02;
/// Minimum gain of a plunge in the first rounds, in multiples of the least gain of a search; the last one is
/// that of all rounds to come.
const ROUNDS: [f64; 3] = [160.0, 80.0, 40.0];
/// Maximum number of rounds. Plunges of one round free others of contact for the next.
const MAX_ROUNDS: usize = 20;
/// Share of the floor that a round has to cut for another one.
const MIN_CUT_SHARE: f64 = 5e-4;
/// Share of the floor that all rounds together have to cut; what cuts less is not worth its plunges.
const MIN_WORTHWHILE_SHARE: f64 = 5e-3;
/// Distance of uncut cells from the foot of an axis beside the wall up to which axes are tried there, in
/// cutter radii.
const NEAR_RADII: f64 = 2.0;
/// Spacing of the tried feet along a wall, in cutter radii.
const SPACING_RADII: f64 = 0.3;

/// Adds to `cut` up to `most` plunges by the tool of section `index` that cut floor in `layout` that is uncut
/// on `floor`, the floor after all plunges so far. Returns their number.
///
/// # Errors
/// As [`Planner::plan`](crate::plunge::Planner::plan).
pub(super) fn cut_uncut_floor(
    context: &PlanContext,
    (index, layout): (usize, &StretchLayout),
    floor: FloorHeightMap,
    cut: &mut SectionCut,
    most: usize,
    monitor: &Monitor,
) -> Result<usize, PlanError> {
    let workpiece = context.workpiece;
    let tool = context.tool_of_section(index)?;
    let top = BlankTop::new(&workpiece.blank);
    let floor = floor.for_uncut_cells(workpiece, context.setup.allowances.blade_allowance);
    let uncut_before = floor.uncut_share();
    if uncut_before < MIN_UNCUT_SHARE || monitor.is_stopped() {
        return Ok(0);
    }
    let lambdas = [0.0, 1.0];
    let makers: Vec<RowMaker> = lambdas
        .iter()
        .map(|&lambda| row_maker(context, layout, tool, (lambda, 2), cut.feed, monitor))
        .collect();
    let ends = row_ends(context, index, &layout.stretch, cut.feed.sign_along_s());
    let step = SPACING_RADII * tool.radius() / workpiece.part.hub.length();
    let is_near_uncut = |row: usize, s: f64| {
        let lane = makers[row].lane;
        let ends = lane.reference_axis(makers[row].lambda, s);
        let reach = NEAR_RADII * tool.radius();
        ends.is_some_and(|ends| floor.is_uncut_near(&workpiece.part, &lane.hub_point(&ends), reach))
    };
    let feet = feet_along(makers.len(), ends, step, is_near_uncut);
    let candidates: Vec<CandidateMaker> =
        makers.iter().map(|maker| candidate_maker(context, maker, &top)).collect();
    let search = ExtraSearch::new(&candidates, PoolFan::Wall, &feet, floor, &workpiece.blank);
    let mut pool =
        PoolRounds { context, stretch: &layout.stretch, tool, lambdas: &lambdas, search, budget: most };
    let mut added_in_all = 0;
    let (rows_before, columns_before) = (cut.rows.len(), cut.columns.len());
    for round in 0..MAX_ROUNDS {
        let uncut = pool.search.floor().uncut_share();
        added_in_all += pool.cut(ROUNDS[round.min(ROUNDS.len() - 1)], cut, monitor)?;
        if round + 1 >= ROUNDS.len() && uncut - pool.search.floor().uncut_share() < MIN_CUT_SHARE {
            break;
        }
    }
    if uncut_before - pool.search.floor().uncut_share() < MIN_WORTHWHILE_SHARE {
        cut.rows.truncate(rows_before);
        cut.columns.truncate(columns_before);
        return Ok(0);
    }
    Ok(added_in_all)
}
