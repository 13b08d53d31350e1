//! Flank milling of a wall: tool axes along a blade side, position by position.
//!
//! Every position is fitted to the true surface. Then the swept surface is evaluated, and positions between
//! which it cuts too deep are moved off the wall. Each layer has axes of its own: they fit the strip of the
//! wall that the layer forms, up to where the flank begins on the layer above, and do not cut what is formed
//! above it.

mod bounds;
mod clearance;
mod fit;
mod milling;
mod minimax;
mod rays;
mod stations;
mod strip;
mod swept;

use rayon::prelude::*;

use crate::cutting::drop_cutter::DepthSurface;
use crate::flank::region::{Region, WallName};
use crate::geometry::{CutterSolid, Meridional, Point, Vector, evenly};
use crate::part::{BladeSide, FinishedPart, Passage, SideProbe};
use fit::{AxisLine, FittedAxis, OffsetSide};
pub use milling::{BladeObstacle, WallMilling, WallStation};
use stations::station_parameters;
use strip::{MAX_LEAD_ANGLE, MAX_UNFORMED, WallStrip};
pub use swept::DeviationMap;
use swept::{CORRECTIONS, DISTANCE_TOLERANCE, MARGIN, MapColumn, deviations, push_off};

/// The tool positions along a wall, from before its leading edge to beyond its end, and the deviation they
/// leave.
#[derive(Clone, Debug)]
pub struct WallAxes {
    /// Positions from inlet to outlet, by layer, hub first.
    by_layer: Vec<Vec<WallStation>>,
    /// Swept deviation over the flank, without nose and blunt trailing edge.
    pub map: DeviationMap,
    /// Maximum overcut: depth cut below the allowance, mm.
    pub max_overcut: f64,
    /// Maximum undercut: stock left above the allowance, mm.
    pub max_undercut: f64,
    /// Maximum forced deviation at a position on the wall, mm: no straight edge stays within less on both
    /// sides.
    pub forced: f64,
}

/// One side of a blade, milled with the flank of the cutter.
#[derive(Clone, Debug)]
pub struct MilledWall {
    /// The wall.
    pub wall: WallName,
    /// The region beside it.
    pub region: Region,
    /// Axes along it, and the deviation they leave.
    pub axes: WallAxes,
}

/// Distance of a point of a side from itself that rounding may cause, mm.
const SAME_SIDE: f64 = 1e-6;
/// Least allowed overcut of the axes along a wall, mm.
pub(super) const MIN_WALL_TOLERANCE: f64 = 5e-4;
/// Rows of a map per strip, where a wall is highest.
const ROWS_PER_STRIP: usize = 4;

/// A wall with positions fitted to it, before the allowed overcut is chosen.
pub struct WallFit<'a> {
    finished: &'a FinishedPart,
    milling: &'a WallMilling<'a>,
    face: OffsetSide<'a>,
    /// u of the positions.
    places: Vec<f64>,
    /// Surfaces that the tool rests on, hub first.
    layers: &'a [DepthSurface<'a>],
    /// One strip per layer.
    strips: Vec<WallStrip>,
    /// Index of the wall's own side among the blades.
    own_side: Option<usize>,
}

/// Positions along a wall that cut at most a tolerance below the allowance, and the deviation they leave.
pub struct SweptWall {
    tolerance: f64,
    /// Axes by strips.
    lines: Vec<Vec<AxisLine>>,
    /// Swept deviation over the flank.
    pub map: DeviationMap,
}

impl<'a> WallFit<'a> {
    /// Fits positions along `wall` (0 or 1) of `passage`, between the surfaces of `finished`, for each of the
    /// `layers`, hub first, which are offset by the corner radius. `None` where the spacing of stations
    /// cannot be computed.
    pub fn new(
        finished: &'a FinishedPart,
        passage: &'a Passage,
        wall: usize,
        milling: &'a WallMilling<'a>,
        layers: &'a [DepthSurface<'a>],
    ) -> Option<Self> {
        let side = passage.walls.get(wall)?.side();
        let (p, pu, pv) = side.derivatives(0.5, 0.5);
        let inward = finished.pitch.signum() * if wall == 0 { 1.0 } else { -1.0 };
        let into_passage = Vector::new(-p.y, p.x, 0.0) * inward;
        let sign = if pu.cross(&pv).dot(&into_passage) < 0.0 { -1.0 } else { 1.0 };
        let face = OffsetSide { side, sign, reach: milling.tool.radius() + milling.blade_allowance };
        let places = station_parameters(&face, milling)?;
        let mut whole = WallStrip::whole(&face, &places, milling);
        let tilted =
            Some(whole.fit_axes(&face, &places, None, MAX_LEAD_ANGLE)).filter(|axes| whole.is_smooth(axes));
        // A strongly bowed wall has several locally best tilts, between which neighbours jump.
        whole.fitted = tilted.unwrap_or_else(|| whole.fit_axes(&face, &places, None, 0.0));
        let mut strips = whole.by_layer(&face, &places, milling, layers);
        strips.iter_mut().for_each(|strip| strip.fit_beside(&face, &places, &whole.fitted));
        let own_side = own_side(finished.blades(), side);
        let mut fit = Self { finished, milling, face, places, layers, strips, own_side };
        fit.strips = (0..layers.len()).map(|layer| fit.give_way(layer, &whole.fitted)).collect();
        Some(fit)
    }

    /// Forced deviation of the wall, mm: the maximum over its positions of the minimax deviation of a
    /// straight edge from its strip, not cutting the wall above by more.
    pub fn forced(&self) -> f64 {
        let (from, to) = self.flank_range();
        let on_wall = |(u, _): &(&f64, &FittedAxis)| (from..=to).contains(*u);
        let levels = |strip: &WallStrip| {
            let here = self.places.iter().zip(&strip.fitted).filter(on_wall);
            here.map(|(_, fitted)| fitted.level).fold(0.0, f64::max)
        };
        self.strips.iter().map(levels).fold(0.0, f64::max)
    }

    /// u at which the flank begins and ends, without its rounded ends.
    fn flank_range(&self) -> (f64, f64) {
        self.face.side.u_range()
    }

    /// The positions moved along the wall's normals, so that the swept cutter cuts at most `tolerance` mm
    /// below the allowance. With a tolerance of 0 the whole forced deviation is left as stock.
    pub fn sweep(&self, tolerance: f64) -> SweptWall {
        let (face, places) = (&self.face, &self.places);
        let columns = self.columns();
        let rows = self.rows();
        let swept = |(layer, strip): (usize, &WallStrip)| {
            let mut lines = strip.moved_off(face, places, tolerance);
            let judged = |column: &MapColumn, row: usize| strip.is_evaluated(column, row, &rows);
            let mut found = deviations(face, &lines, &columns, &rows, judged);
            for _ in 0..CORRECTIONS {
                let mut spares = vec![0.0; lines.len() - 1];
                for &(deviation, segment) in found.iter().flatten() {
                    spares[segment] = f64::min(spares[segment], deviation + tolerance - MARGIN);
                }
                if spares.iter().all(|&spare| spare > -DISTANCE_TOLERANCE) {
                    break;
                }
                push_off(face, places, &mut lines, &spares);
                found = deviations(face, &lines, &columns, &rows, judged);
            }
            if self.clear_own_blade(layer, &mut lines, tolerance) {
                found = deviations(face, &lines, &columns, &rows, judged);
            }
            (lines, found)
        };
        let swept: Vec<_> = self.strips.par_iter().enumerate().map(swept).collect();
        let mut deviation = vec![f64::INFINITY; columns.len() * rows.len()];
        let mut lines = Vec::with_capacity(swept.len());
        for (strip, (strip_lines, found)) in self.strips.iter().zip(swept) {
            let found = if self.has_rays(strip) { Vec::new() } else { found };
            for (least, found) in deviation.iter_mut().zip(found) {
                *least = found.map_or(*least, |(here, _)| f64::min(*least, here));
            }
            lines.push(strip_lines);
        }
        self.form_by_rays(&lines, &columns, &rows, &mut deviation);
        // Below the corner of the cutter its flank neither leaves nor removes stock.
        deviation.iter_mut().filter(|d| d.is_infinite()).for_each(|d| *d = 0.0);
        let u = columns.iter().map(|column| column.u).collect();
        SweptWall { tolerance, lines, map: DeviationMap { u, v: rows, deviation } }
    }

    /// Columns of the map: at the stations on the wall, and half way between them.
    fn columns(&self) -> Vec<MapColumn> {
        let (from, to) = self.flank_range();
        let on_wall = |column: &MapColumn| (from..=to).contains(&column.u);
        let halves = 0..2 * self.places.len() - 2;
        halves.map(|k| MapColumn::half(&self.places, k)).filter(on_wall).collect()
    }

    /// Rows of the map (v): from the lowest that any strip forms up to the tip.
    fn rows(&self) -> Vec<f64> {
        let at_stations = self.columns().into_iter().filter(|column| column.share == 0.0);
        let lows = at_stations.flat_map(|c| self.strips.iter().map(move |strip| strip.low[c.station]));
        let lowest = lows.fold(MAX_UNFORMED, f64::min);
        let least = self.strips.iter().map(WallStrip::evaluated_heights).max().unwrap_or(2);
        evenly(lowest, 1.0, (ROWS_PER_STRIP * self.strips.len() + 1).max(least))
    }

    /// The positions with their obstacles.
    pub fn axes(&self, swept: SweptWall) -> WallAxes {
        let by_layer: Vec<_> = (0..self.layers.len()).map(|k| self.stations(k, &swept)).collect();
        let [max_overcut, max_undercut] = self.max_deviations(&swept.map, &by_layer);
        WallAxes { by_layer, forced: self.forced(), max_overcut, max_undercut, map: swept.map }
    }

    /// Maximum overcut and undercut of a map, mm, over the points that some layer cuts: one whose strip holds
    /// the point and whose positions there are free.
    fn max_deviations(&self, map: &DeviationMap, by_layer: &[Vec<WallStation>]) -> [f64; 2] {
        let free = |layer: usize, station: usize| {
            let station = by_layer[layer].get(station);
            station.is_none_or(|s| s.tip.is_some() && s.blocked.is_none())
        };
        let comes = |column: &MapColumn, v: f64| {
            (0..by_layer.len()).any(|layer| {
                let strip = &self.strips[layer];
                strip.holds(column, v)
                    && free(layer, column.station)
                    && (column.share == 0.0 || free(layer, column.station + 1))
            })
        };
        let columns = self.columns();
        let places = columns.iter().flat_map(|column| map.v.iter().map(move |&v| (column, v)));
        let mut most = [0.0f64; 2];
        for ((column, v), &deviation) in places.zip(&map.deviation) {
            if comes(column, v) {
                most = [most[0].max(-deviation), most[1].max(deviation)];
            }
        }
        most
    }

    fn stations(&self, layer: usize, swept: &SweptWall) -> Vec<WallStation> {
        let hub = self.finished.hub.curve();
        let tool = self.milling.tool;
        let wanted = self.milling.blade_allowance - swept.tolerance;
        let station = |(k, line): (usize, &AxisLine)| {
            let axis = line.axis();
            let tip = self.layers[layer].tip(tool, &line.low, &axis);
            let s = self.finished.hub.s_at(hub.project(Meridional::from_point(&line.low)).0);
            let blocked = tip.and_then(|tip| {
                let cutter = tool.placed(tip, axis);
                let near = obstacles(self.finished, None, (&cutter, tool.overhang), wanted);
                near.min_by(|a, b| a.distance.total_cmp(&b.distance))
            });
            let (u, forced) = (self.places[k], self.strips[layer].fitted[k].level);
            WallStation { u, s, foot: line.low, axis, tip, forced, blocked }
        };
        swept.lines[layer].par_iter().enumerate().map(station).collect()
    }
}

impl WallAxes {
    /// The positions on a layer, numbered from 0 at the hub.
    pub fn stations(&self, layer: usize) -> &[WallStation] {
        self.by_layer.get(layer).map_or(&[], Vec::as_slice)
    }
}

/// The sides of blades, except that of index `but`, to which a cutter with its overhang is nearer than
/// `wanted` (mm), each where it is nearest.
fn obstacles<'a>(
    finished: &'a FinishedPart,
    but: Option<usize>,
    (cutter, overhang): (&'a CutterSolid, f64),
    wanted: f64,
) -> impl Iterator<Item = BladeObstacle> + 'a {
    let near = finished.sides_within(cutter, overhang, wanted, but);
    near.map(|(side, near)| BladeObstacle { side, u: near.u, v: near.v, distance: near.distance })
}

/// Index of the blade side that a wall is part of.
fn own_side(blades: &[SideProbe], wall: &BladeSide) -> Option<usize> {
    let (from, to) = wall.u_range();
    let on: Point = wall.point(0.5 * (from + to), 0.5);
    blades.iter().position(|probe| probe.nearest_to_point(&on).distance < SAME_SIDE)
}
