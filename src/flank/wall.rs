//! Flank milling of a wall (DESIGN section 6): a cylinder beside a blade side, position by position.
//!
//! Every position is fitted to the true surface; then the swept surface is judged, and positions between which it cuts
//! too deep are moved off the wall. Each axis is a line: a cutter slides along it to any depth, so that all layers use the
//! same lines.

mod fit;
mod places;
mod swept;

use rayon::prelude::*;

use crate::geometry::{CutterSolid, Meridional, Point, Vector};
use crate::part::{Passage, SideProbe, Tool};
use crate::plunge::clearance::FinishedPart;
use crate::plunge::slotting::DepthSurface;
use fit::{Face, Fitted, Line};
use places::{evenly, station_places};
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
    /// The least that the greatest deviation of any straight edge from the wall can be here, mm: what the wall's twist and bow
    /// force.
    pub forced: f64,
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
    /// Greatest deviation that the wall forces at a position on it, mm: no straight edge stays within less, either way.
    pub forced: f64,
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

/// A wall with positions fitted to it, before it is decided how deep they may cut.
pub struct WallFit<'a> {
    finished: &'a FinishedPart<'a>,
    milling: &'a WallMilling<'a>,
    face: Face<'a>,
    /// u of the positions.
    places: Vec<f64>,
    fitted: Vec<Fitted>,
    /// Heights of the wall that the fit looked at.
    heights: usize,
}

/// Positions along a wall that cut no more than a tolerance below the allowance, and what they leave.
pub struct SweptWall {
    tolerance: f64,
    lines: Vec<Line>,
    /// Swept deviation over the flank.
    pub map: DeviationMap,
}

impl<'a> WallFit<'a> {
    /// Positions along `wall` (0 or 1) of `passage`, between the surfaces of `finished`. `None` where the wall has no
    /// direction to follow.
    pub fn new(
        finished: &'a FinishedPart<'a>,
        passage: &'a Passage,
        wall: usize,
        milling: &'a WallMilling<'a>,
    ) -> Option<Self> {
        let side = passage.walls.get(wall)?.side();
        let (p, pu, pv) = side.derivatives(0.5, 0.5);
        let inward = finished.part.pitch().signum() * if wall == 0 { 1.0 } else { -1.0 };
        let into_passage = Vector::new(-p.y, p.x, 0.0) * inward;
        let sign = if pu.cross(&pv).dot(&into_passage) < 0.0 { -1.0 } else { 1.0 };
        let face = Face { side, sign, reach: milling.tool.radius() + milling.blade_allowance };
        let places = station_places(&face, milling)?;
        let count = if side.is_ruled() { RULED_HEIGHTS } else { BOWED_HEIGHTS };
        let mut fit = Self { finished, milling, face, places, fitted: Vec::new(), heights: count };
        let fitted = |most_tilt: f64| -> Vec<Fitted> {
            let fitted = |&u: &f64| fit.face.fit(u, &fit.heights_at(u, count), most_tilt);
            fit.places.par_iter().map(fitted).collect()
        };
        let jumps = |pair: &[Fitted]| pair[0].line().axis().angle(&pair[1].line().axis()) > JUMP;
        let tilted = fitted(MOST_TILT);
        // A strongly bowed wall has several best tilts, between which neighbours jump.
        fit.fitted = if tilted.windows(2).any(jumps) { fitted(0.0) } else { tilted };
        Some(fit)
    }

    /// Heights of the wall at `u`, from the lowest that the flank cuts up to its tip.
    fn heights_at(&self, u: f64, count: usize) -> Vec<f64> {
        let uncut = self.milling.hub_allowance + self.milling.tool.corner_radius;
        let height = (self.face.side.point(u, 1.0) - self.face.side.point(u, 0.0)).norm();
        evenly((uncut / height.max(1e-9)).min(0.9), 1.0, count)
    }

    /// The positions moved along the wall's normals, so that the swept cutter cuts no more than `tolerance` mm below the
    /// allowance. With none, all that a straight edge cannot do is left.
    pub fn swept(&self, tolerance: f64) -> SweptWall {
        let (face, places) = (&self.face, &self.places);
        let judged = JUDGED_PER_HEIGHT * (self.heights - 1) + 1;
        let mut lines: Vec<Line> = self
            .places
            .par_iter()
            .zip(&self.fitted)
            .map(|(&u, fitted)| face.moved_off(fitted, &self.heights_at(u, self.heights), tolerance))
            .collect();
        let spare =
            |line: &Line, u: f64| face.least(line, &self.heights_at(u, judged), u) + tolerance - MARGIN;
        settle(face, places, &mut lines, spare);

        let (first, last) = (face.side.u_knots()[0].max(0.0), 1.0);
        let on_wall = |u: &f64| (first..=last).contains(u);
        let low = |u: f64| self.heights_at(u, judged)[0];
        let lowest = places.iter().filter(|u| on_wall(u)).map(|&u| low(u)).fold(0.9, f64::min);
        let halves = places.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]);
        let map_u: Vec<f64> = halves.filter(on_wall).collect();
        let map_v = evenly(lowest, 1.0, judged);
        let judge = |lines: &[Line]| {
            let (mut map, segments) = deviation_map(face, lines, &map_u, &map_v);
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
                spares[segment] = f64::min(spares[segment], deviation + tolerance - MARGIN);
            }
            if spares.iter().all(|&spare| spare > -SETTLED) {
                break;
            }
            push_off(face, places, &mut lines, &spares);
            (map, segments) = judge(&lines);
        }
        SweptWall { tolerance, lines, map }
    }

    /// The positions with what stands in their way.
    pub fn axes(&self, swept: SweptWall) -> WallAxes {
        let hub = self.finished.part.hub.curve();
        let wanted = self.milling.blade_allowance - swept.tolerance;
        let station = |((&u, line), fitted): ((&f64, &Line), &Fitted)| {
            let axis = line.axis();
            let cutter = self.milling.tool.placed(line.low + axis * self.milling.hub_allowance, axis);
            let s = self.finished.part.hub.s_at(hub.project(Meridional::of(&line.low)).0);
            let blocked = obstacle(self.finished.blades(), &cutter, wanted);
            WallStation { u, s, foot: line.low, axis, forced: fitted.level(self.heights), blocked }
        };
        let lines = self.places.par_iter().zip(&swept.lines).zip(&self.fitted);
        let stations: Vec<WallStation> = lines.map(station).collect();
        let flank = self.face.side.u_knots()[0].max(0.0);
        let forced = stations.iter().filter(|s| (flank..=1.0).contains(&s.u)).map(|s| s.forced);
        WallAxes {
            forced: forced.fold(0.0, f64::max),
            stations,
            max_overcut: swept.map.max_overcut(),
            max_undercut: swept.map.max_undercut(),
            map: swept.map,
        }
    }
}

/// The nearest of the sides that `cutter` comes nearer to than `wanted`.
fn obstacle(probes: &[SideProbe], cutter: &CutterSolid, wanted: f64) -> Option<Obstacle> {
    let near = |(side, probe): (usize, &SideProbe)| {
        let near = probe.nearest_below(cutter, wanted)?;
        Some(Obstacle { side, u: near.u, v: near.v, distance: near.distance }).filter(|n| n.distance < wanted)
    };
    probes.iter().enumerate().filter_map(near).min_by(|a, b| a.distance.total_cmp(&b.distance))
}
