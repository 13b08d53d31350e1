//! Inner passes: as few fixed axes as possible, blended towards the axes of near walls.

use super::stretches::pieces_between;
use super::wall_positions::{CHORD, LayerPose};
use super::{LayerPassMaker, PlannedLayer, RegionAxis};
use crate::flank::fixed_axis::{AxisObstacle, LayerContact};
use crate::flank::layer::LayerPoint;
use crate::flank::region::Region;
use crate::flank::strategies::PassRole;
use crate::flank::uncut::UncutReason;
use crate::geometry::{Point, Vector};

/// Spacing of the stations of the fixed-axis search, mm along the meridian, and their maximum number.
const STATION_STEP: f64 = 4.0;
const MAX_STATIONS: usize = 48;
/// Clearance beyond the allowance below which the move between two positions is checked as well, mm.
const NEAR: f64 = 0.05;
/// Maximum number of searches for axes, and the share of the last remaining length at which they end.
const ROUNDS: usize = 4;
const MAX_REMAINING_SHARE: f64 = 0.95;
/// Number of the first round of a search for passes along a wall.
const BESIDE_WALL: usize = ROUNDS;
/// Maximum number of contacts across a region per station.
const ACROSS: usize = 5;
/// Distance from the pass along a wall, in stepovers, below which the axis blends towards the wall's.
const BLEND_START: f64 = 1.75;
/// Distance, in stepovers, below which the axis is the wall's; the pass along the wall covers what is left
/// out there.
const BLEND_END: f64 = 0.5;
/// Maximum turn of the axis from position to position, rad: the tip of a ball end then stays within a µm of
/// its path.
pub(super) const MAX_TURN: f64 = 1.5 * std::f64::consts::PI / 180.0;
/// Maximum number of positions that a turn adds to a step.
const MAX_TURNS: f64 = 60.0;

impl LayerPassMaker<'_> {
    /// Adds the inner passes of a region. Pieces for which the axes of one search leave too little clearance
    /// to a blade are searched again by themselves: a few passes may have a common axis where all those side
    /// by side have none.
    pub(super) fn make_inner_passes(
        &self,
        region: Region,
        lines: Vec<Vec<LayerPoint>>,
        made: &mut PlannedLayer,
    ) {
        self.search_in_rounds(region, lines, 0, made);
    }

    /// Adds passes along a wall whose own axes are blocked, with fixed axes.
    pub(super) fn make_passes_beside_wall(
        &self,
        region: Region,
        lines: Vec<Vec<LayerPoint>>,
        made: &mut PlannedLayer,
    ) {
        self.search_in_rounds(region, lines, BESIDE_WALL, made);
    }

    /// Adds the passes of `lines`, searched for from round `first` on; what remains is recorded as uncut.
    fn search_in_rounds(
        &self,
        region: Region,
        lines: Vec<Vec<LayerPoint>>,
        first: usize,
        made: &mut PlannedLayer,
    ) {
        let length = |lines: &[Vec<LayerPoint>]| lines.iter().map(|l| self.layer.length(l)).sum::<f64>();
        let mut rest = lines;
        for round in first..first + ROUNDS {
            let before = length(&rest);
            let (lost, (why, blocked)) = self.search_inner_passes(region, &rest, round, made);
            let left = length(&lost);
            if left <= 0.0 {
                return;
            }
            if round + 1 == first + ROUNDS || round > first && left > MAX_REMAINING_SHARE * before {
                let overhang = self.maker.overhang_for(&blocked, self.surface);
                self.record_uncut_by(made, region, left, (uncut_reason(why), overhang));
                return;
            }
            rest = lost;
        }
    }

    /// Adds the passes of some curves of a region; returns the remaining pieces, why they remain, and some of
    /// the contacts where shank or holder are what is in the way. Only in the first search do axes blend
    /// towards those of the walls.
    fn search_inner_passes(
        &self,
        region: Region,
        lines: &[Vec<LayerPoint>],
        round: usize,
        made: &mut PlannedLayer,
    ) -> (Vec<Vec<LayerPoint>>, (AxisObstacle, Vec<LayerContact>)) {
        let ends = |f: fn(f64, f64) -> f64, start: f64| {
            lines.iter().flat_map(|line| line.iter()).map(|p| p.x).fold(start, f)
        };
        let (from, to) = (ends(f64::min, f64::INFINITY), ends(f64::max, f64::NEG_INFINITY));
        if from >= to {
            return (lines.to_vec(), (AxisObstacle::Blade, Vec::new()));
        }
        let count = ((to - from) / STATION_STEP).ceil().clamp(1.0, MAX_STATIONS as f64) as usize;
        let width = (to - from) / count as f64;
        // A station is a strip across the region. Its contacts are on the curves at its start, middle and
        // end.
        let stations: Vec<Vec<LayerContact>> = (0..count)
            .map(|k| {
                let x = [0.0, 0.5, 1.0].map(|share| from + width * (k as f64 + share));
                x.iter().flat_map(|&x| self.across(lines, x, round)).map(|p| self.contact(p)).collect()
            })
            .collect();
        let found = self.maker.search.runs(&stations, self.surface);
        let border = |station: usize| from + width * station as f64;
        for run in &found.runs {
            made.axes.push(RegionAxis {
                layer: self.number,
                region,
                from: border(run.from),
                to: border(run.to + 1),
                axis: run.axis,
                clearance: run.clearance,
            });
        }
        let mut lost = Vec::new();
        for line in lines {
            for (group, run) in found.runs.iter().enumerate() {
                // Stations with contacts only near walls belong to no run of their own: the nearest run is
                // used.
                let from = if group == 0 { f64::NEG_INFINITY } else { border(run.from) };
                let to = found.runs.get(group + 1).map_or(f64::INFINITY, |next| border(next.from));
                for piece in pieces_between(line, from, to) {
                    lost.extend(self.make_fixed_axis_passes(region, (round, group), &piece, run.axis, made));
                }
            }
            if found.runs.is_empty() {
                lost.push(line.clone());
            }
        }
        let why = found.unreachable.first().map_or(AxisObstacle::Blade, |u| u.why);
        let blocked =
            found.unreachable.iter().filter(|u| u.why == why && why.is_freed_by_overhang(self.maker.tool));
        let blocked: Vec<LayerContact> =
            blocked.filter_map(|u| stations.get(u.station)?.get(*u.contacts.first()?).copied()).collect();
        // The ends of the stretch stand for it.
        let ends = blocked.first().into_iter().chain(blocked.last().filter(|_| blocked.len() > 1));
        (lost, (why, ends.copied().collect()))
    }

    /// Layer points of some lines at `x`: the outermost and some between.
    fn across(&self, lines: &[Vec<LayerPoint>], x: f64, round: usize) -> Vec<LayerPoint> {
        let mut places: Vec<LayerPoint> = lines
            .iter()
            .flat_map(|line| line.windows(2))
            .filter(|w| (w[0].x - x) * (w[1].x - x) <= 0.0 && w[0].x != w[1].x)
            .map(|w| w[0].lerp(w[1], (x - w[0].x) / (w[1].x - w[0].x)))
            .filter(|p| round > 0 || self.wall_weight(*p) == 0.0)
            .collect();
        places.sort_by(|a, b| a.y.total_cmp(&b.y));
        places.dedup_by(|a, b| (a.y - b.y).abs() < 1e-9);
        let n = places.len();
        if n <= ACROSS {
            return places;
        }
        (0..ACROSS).map(|k| places[k * (n - 1) / (ACROSS - 1)]).collect()
    }

    /// Adds the passes along `line` with one axis, blended towards that of a wall where the line is near it.
    /// Returns the pieces that are not cut because the cutter would be too near to a blade.
    fn make_fixed_axis_passes(
        &self,
        region: Region,
        (round, group): (usize, usize),
        line: &[LayerPoint],
        axis: Vector,
        made: &mut PlannedLayer,
    ) -> Vec<Vec<LayerPoint>> {
        let maker = self.maker;
        let mut open: Vec<(LayerPoint, (Point, Vector))> = Vec::new();
        let mut pieces = Vec::new();
        let mut lost: Vec<Vec<LayerPoint>> = Vec::new();
        let mut last: Option<(LayerPoint, bool)> = None;
        let dense = self.densify(line);
        for p in if round == 0 { self.densify_for_turn(dense, axis) } else { dense } {
            let turned = if round == 0 { self.blend_axis(p, axis) } else { axis };
            let tip = maker.search.tip(&self.contact(p), &turned, self.surface) + turned * CHORD;
            let before = open.last().map(|(_, before)| *before);
            if self.is_free((tip, turned), before) && maker.search.holder_obstacle(tip, turned).is_none() {
                open.push((p, (tip, turned)));
            } else {
                pieces.push(std::mem::take(&mut open));
            }
            let cut = !open.is_empty();
            // Next to a wall the pass along it cuts what an inner pass leaves out.
            if let Some((q, before)) = last.filter(|(_, before)| !(cut && *before))
                && (round >= BESIDE_WALL || self.wall_weight(p) < 1.0)
            {
                match lost.last_mut().filter(|piece| !before && piece.last() == Some(&q)) {
                    Some(piece) => piece.push(p),
                    None => lost.push(vec![q, p]),
                }
            }
            last = Some((p, cut));
        }
        pieces.push(open);
        for piece in pieces.into_iter().filter(|piece| piece.len() >= 2) {
            let placed: Vec<LayerPose> =
                piece.into_iter().map(|(place, (tip, axis))| LayerPose { tip, axis, place }).collect();
            self.push_passes((PassRole::Inner, region, group + round * MAX_STATIONS), &placed, made);
        }
        lost
    }

    /// Whether the cutter at a position, and on the move to it from the one `before`, keeps the allowances
    /// from hub and blades, and its holder clears them.
    fn is_free(&self, (tip, axis): (Point, Vector), before: Option<(Point, Vector)>) -> bool {
        let maker = self.maker;
        let allowance = maker.setup.allowances.blade_allowance;
        let overhang = maker.tool.overhang;
        let cutter = maker.tool.placed(tip, axis);
        let near = maker.finished.wheel_clearance_below(&cutter, overhang, allowance + NEAR);
        if near < allowance || maker.search.obstacle_except_blades(tip, axis).is_some() {
            return false;
        }
        // The move between two positions may be nearer to a convex wall than both, and much nearer where the
        // axis jumps from that of one wall to another.
        let Some((last, turned)) = before else { return true };
        let shares: &[f64] = if turned.angle(&axis) > 2.0 * MAX_TURN {
            &[0.25, 0.5, 0.75]
        } else if near < allowance + NEAR {
            &[0.5]
        } else {
            return true;
        };
        shares.iter().all(|&share| {
            let between = (turned + (axis - turned) * share).normalize();
            let cutter = maker.tool.placed(last + (tip - last) * share, between);
            maker.finished.clears_wheel(&cutter, overhang, allowance)
        })
    }

    /// The fixed `axis`, blended towards that of a wall near `p`.
    fn blend_axis(&self, p: LayerPoint, axis: Vector) -> Vector {
        let share = self.wall_weight(p);
        match self.wall_axis(p).filter(|_| share > 0.0) {
            Some(wall) => (axis + (wall - axis) * share).normalize(),
            None => axis,
        }
    }

    /// The line with points added so that the axis turns little from one to the next.
    fn densify_for_turn(&self, line: Vec<LayerPoint>, axis: Vector) -> Vec<LayerPoint> {
        let mut points = vec![line[0]];
        for w in line.windows(2) {
            let middle = w[0].lerp(w[1], 0.5);
            let [a, b, c] = [w[0], middle, w[1]].map(|p| self.blend_axis(p, axis));
            let count = ((a.angle(&b) + b.angle(&c)) / MAX_TURN).ceil().clamp(1.0, MAX_TURNS) as usize;
            points.extend((1..=count).map(|k| w[0].lerp(w[1], k as f64 / count as f64)));
        }
        points
    }

    /// Weight of a wall's own axis at a point near it: 0 in the middle of the channel, 1 next to the pass
    /// along the wall.
    fn wall_weight(&self, p: LayerPoint) -> f64 {
        let stepovers = self.chart.wall_margin(p) / self.found.stepover;
        ((BLEND_START - stepovers) / (BLEND_START - BLEND_END)).clamp(0.0, 1.0)
    }

    /// Axis of the pass along the wall that is nearest to `p`, beside `p`.
    fn wall_axis(&self, p: LayerPoint) -> Option<Vector> {
        let wall = self
            .chart
            .walls()
            .min_by(|a, b| self.chart.distance(*a, p).total_cmp(&self.chart.distance(*b, p)))?;
        // Ahead of the nose of a splitter both of its sides count.
        let beside = self.chart.borders.region(p).filter(|region| region.facing(wall).is_some());
        let ours = self.milled.iter().filter(|m| m.wall == wall);
        let ours = ours.filter(|m| beside.is_none_or(|region| m.region.shares_side(region, wall)));
        let axes: Vec<Vector> = ours.filter_map(|m| m.axis(p.x)).collect();
        axes.iter().sum::<Vector>().try_normalize(1e-9)
    }
}

/// The obstacle as the reason why passes are not cut.
fn uncut_reason(obstacle: AxisObstacle) -> UncutReason {
    match obstacle {
        AxisObstacle::Blade => UncutReason::new("a blade is too near"),
        AxisObstacle::Hub => UncutReason::new("the hub is too near"),
        AxisObstacle::Shank => UncutReason::shank("the shank meets the part"),
        AxisObstacle::ShankInStock => UncutReason::shank("the shank meets uncut stock"),
        AxisObstacle::Holder => UncutReason::holder("the holder meets the part"),
        AxisObstacle::Stock => UncutReason::holder("the holder meets uncut stock"),
        AxisObstacle::Tilt => UncutReason::new("the axis would tilt too far"),
        AxisObstacle::NoCommonAxis => UncutReason::new("no single axis suits all passes there"),
    }
}
