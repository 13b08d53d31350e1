//! Flank milling of a wall (DESIGN section 6): a cylinder beside a blade side, position by position.
//!
//! Every position is fitted to the true surface; then the swept surface is judged, and positions between which it cuts
//! too deep are moved off the wall. Each axis is a line: a cutter slides along it to any depth, so that all layers use the
//! same lines.

mod fit;
mod swept;

use rayon::prelude::*;

use crate::geometry::{CutterSolid, Meridional, Point, Vector};
use crate::part::{Channel, Impeller, Passage, SideProbe, Tool};
use crate::plunge::slotting::DepthSurface;
use fit::{Face, Line};
pub use swept::DeviationMap;
use swept::{deviation_map, push_off, settle};

/// How a wall is to be milled. All lengths mm.
#[derive(Clone, Debug)]
pub struct WallMilling<'a> {
    /// The cutter.
    pub tool: &'a Tool,
    /// Stock that stays on the blades.
    pub blade_allowance: f64,
    /// Stock that stays on the hub: below it, and below the cutter's corner, nothing of the wall is cut.
    pub hub_allowance: f64,
    /// How much the swept cutter may cut below the allowance. With none, all that a straight edge cannot do is left.
    pub tolerance: f64,
    /// How far the pass reaches beyond either end of the wall.
    pub extension: f64,
    /// Greatest distance between stations.
    pub step: f64,
    /// How far the straight way between two stations may be off the wall's bend; sets their distance where it is smaller.
    pub chord_error: f64,
}

/// What stands in the way of a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Index of the blade side in [`Channel::sides`].
    pub side: usize,
    /// Where on it the cutter is nearest, LE 0 to TE 1.
    pub u: f64,
    /// See `u`; hub 0 to tip 1.
    pub v: f64,
    /// Distance there, mm; negative where the cutter cuts the blade.
    pub distance: f64,
}

/// One position of the cutter beside the wall.
#[derive(Clone, Copy, Debug)]
pub struct WallStation {
    /// u of the wall at which the position was fitted; beyond 0…1 where the wall runs on.
    pub u: f64,
    /// s of the foot of the axis on the hub.
    pub s: f64,
    /// Point of the axis next to the hub.
    pub foot: Point,
    /// Unit axis, towards the holder.
    pub axis: Vector,
    /// What the cutter would come too near to when it stands on the hub's allowance: another wall, a nose.
    pub blocked: Option<Obstacle>,
}

/// The positions of a cutter along a wall, from before its leading edge to beyond its end, and what they leave.
#[derive(Clone, Debug)]
pub struct WallAxes {
    /// The positions, inlet to outlet.
    pub stations: Vec<WallStation>,
    /// Swept deviation over the flank; nose and blunt trailing edge are not part of it.
    pub map: DeviationMap,
    /// Greatest cut below the allowance, mm.
    pub max_overcut: f64,
    /// Greatest stock left above the allowance, mm.
    pub max_undercut: f64,
}

/// Heights of the wall that a fit looks at.
const RULED_HEIGHTS: usize = 11;
const BOWED_HEIGHTS: usize = 25;
/// Lines of the wall that are judged, per height of a fit.
const JUDGED_PER_HEIGHT: usize = 2;
/// Greatest tilt of an axis along the feed from the plain offset, rad.
const MOST_TILT: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Turn between neighbouring axes that cannot come from the wall, rad.
const JUMP: f64 = 2.0 * MOST_TURN;
/// Samples along a wall for the spacing of stations.
const SPACING_SAMPLES: usize = 160;
/// Most stations of a wall.
const MAX_STATIONS: usize = 2000;
/// Rounds of moving positions off the wall between which the swept cutter cuts too deep.
const CORRECTIONS: usize = 4;
/// Distances are met to this, mm, and stay clear of the limit by three times as much.
const SETTLED: f64 = 1e-5;
/// See [`SETTLED`].
const MARGIN: f64 = 3.0 * SETTLED;
/// Greatest turn of the axis between stations, rad.
const MOST_TURN: f64 = 3.0 * std::f64::consts::PI / 180.0;

impl WallStation {
    /// The tip of `tool` on this axis, lowered until its bottom touches `surface`: one that is offset by what shall
    /// stay under the cutter plus its corner radius. `None` where the cutter misses the surface.
    pub fn tip_on(&self, surface: &DepthSurface, tool: &Tool) -> Option<Point> {
        surface.tip(tool, &self.foot, &self.axis)
    }
}

impl WallAxes {
    /// Positions along `wall` (0 or 1) of `passage`. `None` where the wall has no direction to follow.
    pub fn fit(
        part: &Impeller,
        channel: &Channel,
        passage: &Passage,
        wall: usize,
        milling: &WallMilling,
    ) -> Option<Self> {
        let side = passage.walls.get(wall)?.side();
        let (p, pu, pv) = side.derivatives(0.5, 0.5);
        let inward = part.pitch().signum() * if wall == 0 { 1.0 } else { -1.0 };
        let into_passage = Vector::new(-p.y, p.x, 0.0) * inward;
        let sign = if pu.cross(&pv).dot(&into_passage) < 0.0 { -1.0 } else { 1.0 };
        let face = Face { side, sign, reach: milling.tool.radius() + milling.blade_allowance };
        let places = station_places(&face, milling)?;
        let count = if side.is_ruled() { RULED_HEIGHTS } else { BOWED_HEIGHTS };
        let uncut = milling.hub_allowance + milling.tool.corner_radius;
        let heights = |u: f64, count: usize| {
            let height = (side.point(u, 1.0) - side.point(u, 0.0)).norm();
            evenly((uncut / height.max(1e-9)).min(0.9), 1.0, count)
        };
        let fitted = |most_tilt: f64| -> Vec<Line> {
            let fit = |&u: &f64| face.fit(u, &heights(u, count), milling.tolerance, most_tilt);
            places.par_iter().map(fit).collect()
        };
        let mut lines = fitted(MOST_TILT);
        if lines.windows(2).any(|pair| pair[0].axis().angle(&pair[1].axis()) > JUMP) {
            // A strongly bowed wall has several best tilts, between which neighbours jump.
            lines = fitted(0.0);
        }
        let judged = JUDGED_PER_HEIGHT * (count - 1) + 1;
        let spare =
            |line: &Line, u: f64| face.least(line, &heights(u, judged), u) + milling.tolerance - MARGIN;
        settle(&face, &places, &mut lines, spare);

        let (first, last) = (side.u_knots()[0].max(0.0), 1.0);
        let on_wall = |u: &f64| (first..=last).contains(u);
        let low = |u: f64| heights(u, judged)[0];
        let lowest = places.iter().filter(|u| on_wall(u)).map(|&u| low(u)).fold(0.9, f64::min);
        let halves = places.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]);
        let map_u: Vec<f64> = halves.filter(on_wall).collect();
        let map_v = evenly(lowest, 1.0, judged);
        let judge = |lines: &[Line]| {
            let (mut map, segments) = deviation_map(&face, lines, &map_u, &map_v);
            // Below the cutter's corner its flank leaves nothing and takes nothing.
            for (k, deviation) in map.deviation.iter_mut().enumerate() {
                let (u, v) = (map_u[k / map_v.len()], map_v[k % map_v.len()]);
                if v < low(u) {
                    *deviation = 0.0;
                }
            }
            (map, segments)
        };
        let (mut map, mut segments) = judge(&lines);
        for _ in 0..CORRECTIONS {
            let mut spares = vec![0.0; lines.len() - 1];
            for (&deviation, &segment) in map.deviation.iter().zip(&segments) {
                spares[segment] = f64::min(spares[segment], deviation + milling.tolerance - MARGIN);
            }
            if spares.iter().all(|&spare| spare > -SETTLED) {
                break;
            }
            push_off(&face, &places, &mut lines, &spares);
            (map, segments) = judge(&lines);
        }
        Some(Self {
            stations: stations(part, channel, milling, &places, &lines),
            max_overcut: map.max_overcut(),
            max_undercut: map.max_undercut(),
            map,
        })
    }
}

/// `count` values from `from` to `to`.
fn evenly(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect()
}

/// u of the stations: as far apart as `step` and the bend of the wall let them.
fn station_places(face: &Face, milling: &WallMilling) -> Option<Vec<f64>> {
    let side = face.side;
    let ends = [side.u_knots()[0], 1.0];
    let beyond = |u: f64| {
        let speed = [0.0, 1.0].map(|v| side.derivatives(u, v).1.norm());
        milling.extension / speed[0].min(speed[1]).max(1e-9)
    };
    let (from, to) = (ends[0] - beyond(ends[0]), ends[1] + beyond(ends[1]));
    let u = evenly(from, to, SPACING_SAMPLES + 1);
    let du = (to - from) / SPACING_SAMPLES as f64;
    let offsets = |v: f64| -> Vec<(Point, Vector)> {
        u.iter()
            .map(|&u| {
                let (p, n, _) = face.frame(u, v);
                (p + n * face.reach, n)
            })
            .collect()
    };
    // Stations per unit of u.
    let mut density = vec![0.0f64; u.len()];
    let edges = [0.0, 0.5, 1.0].map(offsets);
    let axis = |i: usize| edges[2][i].0 - edges[0][i].0;
    for i in 1..u.len() {
        let by_turn = axis(i - 1).angle(&axis(i)) / (MOST_TURN * du);
        density[i] = density[i].max(by_turn);
    }
    for line in &edges {
        for i in 0..u.len() {
            let k = i.clamp(1, SPACING_SAMPLES - 1);
            let (before, (here, normal), after) = (line[k - 1].0, line[k], line[k + 1].0);
            let speed = (after - before).norm() / (2.0 * du);
            let bend = ((after - here) - (here - before)).dot(&normal).abs() / (du * du);
            let by_bend = (bend / (8.0 * milling.chord_error.max(1e-6))).sqrt();
            density[i] = density[i].max(speed / milling.step.max(1e-3)).max(by_bend);
        }
    }
    let mut number = vec![0.0f64; u.len()];
    for i in 1..u.len() {
        // A narrow bend counts on both sides of it.
        let around = i.saturating_sub(2)..(i + 2).min(u.len());
        number[i] = number[i - 1] + du * density[around].iter().copied().fold(0.0, f64::max);
    }
    let total = number[SPACING_SAMPLES];
    if !total.is_finite() || total <= 0.0 {
        return None;
    }
    let count = (total.ceil() as usize).clamp(2, MAX_STATIONS);
    let mut at = 0;
    let place = |k: usize| {
        let wanted = total * k as f64 / count as f64;
        while at + 2 < u.len() && number[at + 1] < wanted {
            at += 1;
        }
        u[at] + du * (wanted - number[at]) / (number[at + 1] - number[at]).max(1e-12)
    };
    Some((0..=count).map(place).collect())
}

/// The positions with what stands in their way.
fn stations(
    part: &Impeller,
    channel: &Channel,
    milling: &WallMilling,
    places: &[f64],
    lines: &[Line],
) -> Vec<WallStation> {
    let probes: Vec<SideProbe> = channel.sides.iter().map(|side| SideProbe::new(side, 0.0, 1.0)).collect();
    let hub = part.hub.curve();
    let wanted = milling.blade_allowance - milling.tolerance;
    places
        .par_iter()
        .zip(lines)
        .map(|(&u, line)| {
            let axis = line.axis();
            let cutter = milling.tool.placed(line.low + axis * milling.hub_allowance, axis);
            let s = part.hub.s_at(hub.project(Meridional::of(&line.low)).0);
            WallStation { u, s, foot: line.low, axis, blocked: obstacle(&probes, &cutter, wanted) }
        })
        .collect()
}

/// The nearest of the sides that `cutter` comes nearer to than `wanted`.
fn obstacle(probes: &[SideProbe], cutter: &CutterSolid, wanted: f64) -> Option<Obstacle> {
    let near = |(side, probe): (usize, &SideProbe)| {
        let near = probe.nearest_below(cutter, wanted)?;
        Some(Obstacle { side, u: near.u, v: near.v, distance: near.distance }).filter(|n| n.distance < wanted)
    };
    probes.iter().enumerate().filter_map(near).min_by(|a, b| a.distance.total_cmp(&b.distance))
}
