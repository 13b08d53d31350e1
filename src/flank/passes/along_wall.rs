//! Passes along walls, with the axes fitted to the wall.

use super::stretches::pieces_between;
use super::wall_positions::{LayerPose, WallPositions, WallStep, split_into_runs};
use super::{LayerPassMaker, PlannedLayer};
use crate::flank::layer::LayerPoint;
use crate::flank::region::{Region, WallName};
use crate::flank::strategies::PassRole;
use crate::flank::uncut::UncutReason;
use crate::setup::AssemblyPart;

/// Distance from the blades beyond the allowance at which the round end runs along a wall, mm.
const OFF_BLADE: f64 = 0.01;
/// Maximum number of steps that move a position off the blades, and the sine of the angle between layer and
/// wall below which it is not moved.
const MOVES_OFF: usize = 12;
const MIN_SLOPE: f64 = 0.1;

/// A stretch between two x of a layer, mm, along which the axes fitted to a wall are blocked.
struct BlockedRange {
    from: f64,
    to: f64,
    why: UncutReason,
    poses: Vec<LayerPose>,
}

impl LayerPassMaker<'_> {
    /// Adds the passes of a curve along a wall.
    pub(super) fn along_wall(
        &self,
        wall: WallName,
        region: Region,
        points: &[LayerPoint],
        made: &mut PlannedLayer,
    ) {
        if region.facing(wall).is_none() {
            self.round_nose(wall, region, points, made);
            return;
        }
        let from = points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        let to = points.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
        let steps = self.wall_steps(wall, region, (from, to));
        self.cut_otherwise(&steps, region, points, made);
        for positions in split_into_runs(&steps) {
            self.push_wall(wall, region, &positions, made);
        }
    }

    /// Cuts the stretches of a curve along a wall where the axes fitted to it are blocked with fixed axes,
    /// under which the round end touches the wall.
    pub(super) fn cut_otherwise(
        &self,
        steps: &[WallStep],
        region: Region,
        curve: &[LayerPoint],
        made: &mut PlannedLayer,
    ) {
        let mut lines = Vec::new();
        let blocked = |step: &WallStep| match step {
            WallStep::Blocked { from, to, why, pose } => Some((*from, *to, *why, *pose)),
            _ => None,
        };
        let mut ranges: Vec<BlockedRange> = Vec::new();
        for (from, to, why, pose) in steps.iter().filter_map(blocked) {
            // There is nothing to cut beyond the ends of the layer.
            let (from, to) = (from.max(self.layer.from), to.min(self.layer.to));
            match ranges.last_mut().filter(|last| from <= last.to + 1e-9) {
                _ if from >= to => {}
                Some(last) => {
                    last.to = to;
                    last.poses.push(pose);
                }
                None => ranges.push(BlockedRange { from, to, why, poses: vec![pose] }),
            }
        }
        for BlockedRange { from, to, why, poses } in ranges {
            let mut lost = 0.0;
            for piece in pieces_between(curve, from, to) {
                let length = self.layer.length(&piece);
                let free = self.pieces_off_blades(&piece);
                let kept: f64 = free.iter().map(|line| self.layer.length(line)).sum();
                lost += (length - kept).max(0.0);
                lines.extend(free);
            }
            let overhang = match why.is_by(AssemblyPart::Holder) && lost > 0.0 {
                true => self.maker.overhang_along_wall(&poses),
                false => None,
            };
            self.record_uncut_by(made, region, lost, (why, overhang));
        }
        if !lines.is_empty() {
            self.make_passes_beside_wall(region, lines, made);
        }
    }

    /// The pieces of a line along which the round end of the cutter fits, moved over the layer until it
    /// keeps the allowance from all blades.
    fn pieces_off_blades(&self, line: &[LayerPoint]) -> Vec<Vec<LayerPoint>> {
        let moved: Vec<Option<LayerPoint>> =
            self.densify(line).into_iter().map(|p| self.moved_off_blades(p)).collect();
        let runs = moved.split(Option::is_none).map(|run| run.iter().flatten().copied().collect());
        runs.filter(|run: &Vec<LayerPoint>| run.len() >= 2).collect()
    }

    /// The layer point nearest to `p` at which the round end keeps the allowance from all blades; `None`
    /// where none is found.
    fn moved_off_blades(&self, p: LayerPoint) -> Option<LayerPoint> {
        let (tool, finished) = (self.maker.tool, self.maker.finished);
        let wanted = tool.radius() + self.maker.setup.allowances.blade_allowance + OFF_BLADE;
        let mut place = p;
        for _ in 0..MOVES_OFF {
            let contact = self.contact(place);
            let centre = contact.point + contact.normal * tool.corner_radius;
            let Some(near) = finished.nearest_blade_below(&centre, wanted) else { return Some(place) };
            let lacking = wanted - near.distance;
            let away = (centre - near.point).try_normalize(1e-9)?;
            let along = away - contact.normal * away.dot(&contact.normal);
            if along.norm() < MIN_SLOPE {
                return None;
            }
            let moved = contact.point + along * (1.02 * lacking / along.norm_squared());
            place = self.layer.project(&moved, place.y, Some(place.x)).0;
        }
        None
    }

    pub(super) fn push_wall(
        &self,
        wall: WallName,
        region: Region,
        positions: &[LayerPose],
        made: &mut PlannedLayer,
    ) {
        self.push_passes((PassRole::Wall(wall), region, 0), positions, made);
    }

    /// The steps along a wall between two x: positions at both ends and at the stations between them.
    pub(super) fn wall_steps(&self, wall: WallName, region: Region, (from, to): (f64, f64)) -> Vec<WallStep> {
        let ours = |m: &&WallPositions| m.wall == wall && m.region.shares_side(region, wall);
        let Some(milled) = self.milled.iter().find(ours) else { return Vec::new() };
        let mut result = Vec::new();
        // Station at which the last step ended; from any other station the tool approaches anew.
        let mut reached = None;
        for (k, pair) in milled.placed.windows(2).enumerate() {
            let [Some((a, a_blocked)), Some((b, b_blocked))] = pair else { continue };
            let (low, high) = (a.place.x.max(from), b.place.x.min(to));
            if low >= high {
                continue;
            }
            if let Some(why) = a_blocked.or(*b_blocked) {
                let pose = if a_blocked.is_some() { *a } else { *b };
                result.push(WallStep::Blocked { from: low, to: high, why, pose });
                continue;
            }
            let at = |x: f64| a.between(b, (x - a.place.x) / (b.place.x - a.place.x));
            if reached.is_some_and(|reached| reached != k) {
                result.push(WallStep::Apart);
            }
            if !matches!(result.last(), Some(WallStep::To(_))) {
                result.push(WallStep::To(at(low)));
            }
            result.push(WallStep::To(at(high)));
            reached = Some(k + 1);
        }
        result
    }
}
