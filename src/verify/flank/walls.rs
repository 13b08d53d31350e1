//! Undercut and overcut of a program on the walls.

use rayon::prelude::*;

use super::steps::CutterStep;
use crate::flank::wall::DeviationMap;
use crate::geometry::{CutterSolid, Meridional, Point, Vector, evenly, search};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Channel, Impeller};
use crate::setup::Tool;

/// Number of steps with a common bound.
const CHUNK: usize = 16;
/// Samples of a wall along u and v.
const COLUMNS: usize = 64;
const LINES: usize = 12;
/// A wall counts as milled where cutters come this near to its allowance, mm.
const MILLED_DISTANCE: f64 = 0.5;

/// Deviation of the milled part of the walls from their allowance, mm.
#[derive(Clone, Debug, Default)]
pub(super) struct WallDeviation {
    /// Greatest cut below the allowance; NaN where no wall is milled.
    pub(super) overcut: f64,
    /// Greatest stock left above it.
    pub(super) undercut: f64,
    /// Share of the samples to which no cutter comes near, 0…1; 0 without samples.
    pub(super) unmilled_share: f64,
    /// The same wall by wall; NaN where a wall has no samples.
    pub(super) unmilled_walls: Vec<f64>,
    /// What is left, wall by wall; NaN where no cutter comes near.
    pub(super) maps: Vec<DeviationMap>,
}

struct Chunk<'a> {
    steps: Vec<&'a CutterStep>,
    /// A cutter in the middle, and bounds on the distance, mm, and angle, rad, of the others from it.
    middle: CutterSolid,
    moved: f64,
    turned: f64,
}

/// Deviation at all samples of the flanks more than `uncut` mm above the hub: below that a corner leaves
/// stock.
///
/// # Errors
/// When cancelled.
pub(super) fn wall_deviation(
    part: &Impeller,
    channel: &Channel,
    tools: &[Tool],
    steps: &[&CutterStep],
    allowance: f64,
    uncut: f64,
    monitor: &Monitor,
) -> Result<WallDeviation, Cancelled> {
    let chunks: Vec<Chunk> = steps.chunks(CHUNK).map(|steps| build_chunk(steps, tools)).collect();
    let hub = part.hub.curve();
    // Only the sides that face the channel: the back of a thin blade is near a cutter too.
    let splitters = channel.splitters.iter().flat_map(|splitter| [&splitter.near, &splitter.far]);
    let walls = channel.full.walls.iter().chain(splitters);
    let (mut maps, mut unmilled_walls, mut samples) = (Vec::new(), Vec::new(), 0);
    let mut milled: Vec<f64> = Vec::new();
    for wall in walls {
        let flank = wall.side();
        let (from, to) = flank.u_range();
        let (u, v) = (evenly(from, to, COLUMNS), evenly(0.0, 1.0, LINES));
        let places: Vec<Point> = u.iter().flat_map(|&u| v.iter().map(move |&v| flank.point(u, v))).collect();
        let left = |p: &Point| {
            monitor.check()?;
            let is_judged = hub.project(Meridional::from_point(p)).1 > uncut;
            let left = || nearest(p, &chunks, tools, allowance + MILLED_DISTANCE) - allowance;
            Ok(is_judged.then(left).map(|left| if left < MILLED_DISTANCE { left } else { f64::NAN }))
        };
        let left: Vec<Option<f64>> = places.par_iter().map(left).collect::<Result<_, Cancelled>>()?;
        let judged = left.iter().flatten().count();
        let known = milled.len();
        milled.extend(left.iter().flatten().copied().filter(|left| left.is_finite()));
        unmilled_walls.push(1.0 - (milled.len() - known) as f64 / judged as f64);
        samples += judged;
        maps.push(map_above_foot(u, &v, &left));
    }
    // Of walls that are no higher than the corners of the cutters nothing is judged.
    let unmilled_share = if samples > 0 { 1.0 - milled.len() as f64 / samples as f64 } else { 0.0 };
    let none = if milled.is_empty() { f64::NAN } else { 0.0 };
    Ok(WallDeviation {
        overcut: milled.iter().fold(none, |most, left| most.max(-left)),
        undercut: milled.iter().fold(none, |most, left| most.max(*left)),
        unmilled_share,
        unmilled_walls,
        maps,
    })
}

/// What is `left` at the samples of a wall, from the lowest row that is judged somewhere; 0 at its foot.
fn map_above_foot(u: Vec<f64>, v: &[f64], left: &[Option<f64>]) -> DeviationMap {
    let is_judged = |row: &usize| left.iter().skip(*row).step_by(LINES).any(Option::is_some);
    let lowest = (0..LINES - 2).find(is_judged).unwrap_or(LINES - 2);
    let deviation = left.chunks(LINES).flat_map(|column| &column[lowest..]);
    let deviation = deviation.map(|left| left.unwrap_or(0.0)).collect();
    DeviationMap { u, v: v[lowest..].to_vec(), deviation }
}

fn build_chunk<'a>(steps: &[&'a CutterStep], tools: &[Tool]) -> Chunk<'a> {
    let middle = steps[steps.len() / 2].cutter(tools, 0.5);
    let radius = steps.iter().map(|s| tools[s.tool].radius()).fold(0.0, f64::max);
    let ends = || steps.iter().flat_map(|s| [s.from, s.to]);
    let moved = ends().map(|(p, _)| (p - middle.tip).norm()).fold(0.0, f64::max);
    let turned = ends().map(|(_, a)| a.angle(&middle.axis)).fold(0.0, f64::max);
    Chunk {
        steps: steps.to_vec(),
        middle: CutterSolid { radius, corner_radius: 0.0, ..middle },
        moved,
        turned,
    }
}

/// Least distance of a point from the sweep of all steps, at most `below`. Branch and bound over the chunks.
fn nearest(point: &Point, chunks: &[Chunk], tools: &[Tool], below: f64) -> f64 {
    let mut least = below;
    for chunk in chunks {
        let lever = (point - chunk.middle.tip).norm() + chunk.moved;
        if chunk.middle.distance(point) - chunk.moved - chunk.turned * lever > least {
            continue;
        }
        for step in &chunk.steps {
            let tool = &tools[step.tool];
            let at = |share: f64| distance(point, step.at(share), tool);
            let (start, end) = (at(0.0), at(1.0));
            least = least.min(start).min(end);
            let length = step.length() + step.turn() * lever;
            if start.min(end) - length * length / (8.0 * tool.radius()) < least {
                least = least.min(search::minimum(at, 0.0, 1.0, 1e-3).1);
            }
        }
    }
    least
}

fn distance(point: &Point, (tip, axis): (Point, Vector), tool: &Tool) -> f64 {
    tool.placed(tip, axis).distance(point)
}
