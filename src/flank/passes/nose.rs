//! The pass along one side of a splitter, round its nose, and back along the other side.

use super::inner::MAX_TURN;
use super::wall_positions::{CHORD, LayerPose, WallPositions, split_into_runs};
use super::{LayerPassMaker, PassMaker, PlannedLayer};
use crate::flank::fixed_axis::LayerContact;
use crate::flank::layer::LayerPoint;
use crate::flank::layer_walls::LayerSplitter;
use crate::flank::region::{Region, WallName};
use crate::geometry::Vector;

/// Maximum number of steps that move a position off the nose.
const PUSHES: usize = 12;
/// Maximum depth of the recursive bisection between two positions beside a nose, and the shift off the nose
/// at which it goes on, mm.
const MAX_BISECTIONS: usize = 4;
const MIN_SHIFT: f64 = 5e-4;
/// Moves between two positions beside a nose are always bisected above this length, mm.
const LONG: f64 = 0.6;

impl LayerPassMaker<'_> {
    /// Adds one pass along one side of the splitter that divides `region`, round its nose, and back along the
    /// other side.
    pub(super) fn round_nose(
        &self,
        wall: WallName,
        region: Region,
        points: &[LayerPoint],
        made: &mut PlannedLayer,
    ) {
        // A curve along the first side alone may begin at the nose as well.
        let reversed: Vec<LayerPoint> = points.iter().rev().copied().collect();
        let begins_at_nose = points[0].x < points[points.len() - 1].x;
        let ends_on_first_side = self.chart.borders.nearest_region(points[points.len() - 1]).high == wall;
        let points = if begins_at_nose && ends_on_first_side { &reversed } else { points };
        let foremost = (0..points.len()).min_by(|&a, &b| points[a].x.total_cmp(&points[b].x)).unwrap_or(0);
        // Use the fitted axes beside the flanks; the arc round the nose joins them.
        let begins = |region: Region| {
            let ours = |m: &&WallPositions| m.wall == wall && m.region.shares_side(region, wall);
            self.milled.iter().find(ours).map_or(f64::INFINITY, |m| m.behind_nose)
        };
        let side = |region: Region, line: &[LayerPoint]| {
            let to = line.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
            self.wall_steps(wall, region, (begins(region), to))
        };
        let (down, up) = (&points[..=foremost], &points[foremost..]);
        let [low_side, high_side] = [Region { high: wall, ..region }, Region { low: wall, ..region }];
        let (low, high) = (side(low_side, down), side(high_side, up));
        self.cut_otherwise(&low, low_side, down, made);
        self.cut_otherwise(&high, high_side, up, made);
        let (mut low, mut high) = (split_into_runs(&low).into_iter(), split_into_runs(&high).into_iter());
        // The stretch of each side next to the nose joins the arc; the others are passes of their own.
        let mut around = low.next().unwrap_or_default();
        around.reverse();
        let after = high.next().unwrap_or_default();
        for positions in low.chain(high) {
            self.push_wall(wall, region, &positions, made);
        }
        let splitter = self.found.borders.splitter(wall);
        if let (Some(a), Some(b), Some(splitter)) = (around.last().copied(), after.first().copied(), splitter)
        {
            let mut round = vec![a];
            round.extend(self.arc(splitter, [down, &up[1..]], a, b));
            round.push(b);
            let mended = self.bisect_near_nose(splitter, round);
            around.extend(&mended[1..mended.len() - 1]);
        }
        around.extend(after);
        self.push_wall(wall, region, &around, made);
    }

    /// The positions with others inserted where the straight move between them would be too near to a blade.
    fn bisect_near_nose(&self, splitter: &LayerSplitter, positions: Vec<LayerPose>) -> Vec<LayerPose> {
        let mut mended: Vec<LayerPose> = Vec::with_capacity(positions.len());
        for next in positions {
            if let Some(last) = mended.last().copied() {
                self.bisect_move(splitter, [last, next], MAX_BISECTIONS, &mut mended);
            }
            mended.push(next);
        }
        mended
    }

    fn bisect_move(
        &self,
        splitter: &LayerSplitter,
        [a, b]: [LayerPose; 2],
        depth: usize,
        mended: &mut Vec<LayerPose>,
    ) {
        let middle = a.between(&b, 0.5);
        let free = self.push_off_nose(splitter, middle);
        // A long move may be too near elsewhere than at its middle.
        let long = (b.tip - a.tip).norm() > LONG;
        if depth == 0 || (free.tip - middle.tip).norm() < MIN_SHIFT && !long {
            return;
        }
        self.bisect_move(splitter, [a, free], depth - 1, mended);
        mended.push(free);
        self.bisect_move(splitter, [free, b], depth - 1, mended);
    }

    /// Positions round the nose from `a` to `b`, towards its foremost point and back. The axis turns evenly
    /// to the direction of the leading edge and from there to that of `b`. Positions too near to the nose are
    /// moved off it.
    fn arc(
        &self,
        splitter: &LayerSplitter,
        [down, up]: [&[LayerPoint]; 2],
        a: LayerPose,
        b: LayerPose,
    ) -> Vec<LayerPose> {
        let maker = self.maker;
        let edge = maker.leading_edge(splitter).unwrap_or_else(|| a.axis + b.axis);
        let edge = edge.try_normalize(1e-9).unwrap_or(a.axis);
        let mut placed = Vec::new();
        for (line, end, x) in [(down, 0, a.place.x), (up, 1, b.place.x)] {
            let arc: Vec<LayerPoint> = line.iter().copied().filter(|p| p.x < x).collect();
            if arc.is_empty() {
                continue;
            }
            let from = [a, b][end].axis;
            let dense = densify_evenly(&self.densify(&arc), from.angle(&edge));
            let total = self.layer.length(&dense).max(1e-9);
            let mut gone = 0.0;
            for (k, &p) in dense.iter().enumerate() {
                if k > 0 {
                    gone += self.layer.segment_length(dense[k - 1], p);
                }
                let share = gone / total;
                let axis = match end {
                    0 => a.axis + (edge - a.axis) * share,
                    _ => edge + (b.axis - edge) * share,
                };
                let axis = axis.normalize();
                let tip = maker.search.tip(&self.contact(p), &axis, self.surface) + axis * CHORD;
                placed.push(self.push_off_nose(splitter, LayerPose { tip, axis, place: p }));
            }
        }
        placed
    }

    /// The position, moved over the layer away from the splitter's nose until it keeps the allowance from all
    /// blades.
    fn push_off_nose(&self, splitter: &LayerSplitter, placed: LayerPose) -> LayerPose {
        let maker = self.maker;
        let mut contact = self.contact(placed.place);
        let LayerPose { mut tip, mut place, .. } = placed;
        for _ in 0..PUSHES {
            let cutter = maker.tool.placed(tip, placed.axis);
            let short = maker.setup.allowances.blade_allowance - maker.finished.blade_clearance(&cutter);
            let Some(away) = self.off_nose(splitter, &contact).filter(|_| short > 0.0) else { break };
            // Project back onto the layer, which may be curved.
            let moved = contact.point + away * (1.3 * short + 1e-4);
            (place, _) = self.layer.project(&moved, place.y, Some(place.x));
            contact = self.contact(place);
            tip = maker.search.tip(&contact, &placed.axis, self.surface) + placed.axis * CHORD;
        }
        LayerPose { tip, place, ..placed }
    }

    /// Unit vector along the layer away from the middle of the nose.
    fn off_nose(&self, splitter: &LayerSplitter, contact: &LayerContact) -> Option<Vector> {
        let away = contact.point - self.layer.point(splitter.nose);
        (away - contact.normal * away.dot(&contact.normal)).try_normalize(1e-9)
    }
}

/// The line with points added so that an axis which turns by `turn` (rad) along it turns little from one to
/// the next.
fn densify_evenly(line: &[LayerPoint], turn: f64) -> Vec<LayerPoint> {
    let pieces = line.len().saturating_sub(1).max(1);
    let count = (turn / MAX_TURN / pieces as f64).ceil().max(1.0) as usize;
    let between =
        line.windows(2).flat_map(|w| (1..=count).map(move |k| w[0].lerp(w[1], k as f64 / count as f64)));
    line.first().copied().into_iter().chain(between).collect()
}

impl PassMaker<'_> {
    /// Direction of the leading edge of a splitter, from hub to tip.
    fn leading_edge(&self, splitter: &LayerSplitter) -> Option<Vector> {
        let side = self.channel.splitters.get(splitter.number)?.far.whole_side();
        Some(side.point(0.0, 1.0) - side.point(0.0, 0.0))
    }
}
