//! The way along one side of a splitter, round its nose, and back along the other.

use super::along_wall::{IN_THE_WAY, Placed};
use super::{CHORD, LayerAxes, OnLayer, PassMaker};
use crate::flank::chart::{Region, WallName};
use crate::flank::fixed_axis::Contact;
use crate::flank::layer::LayerPoint;
use crate::geometry::Vector;

/// Rounds in which a position beside a nose is moved off it.
const PUSHES: usize = 12;
/// Times the way between two positions beside a nose is halved, and the push that asks for it, mm.
const MENDS: usize = 4;
const MENDED: f64 = 5e-4;

impl OnLayer<'_> {
    /// One pass along one side of the splitter, round its nose, and back along the other.
    pub(super) fn round_nose(&self, points: &[LayerPoint], made: &mut LayerAxes) {
        let Some(splitter) = &self.found.borders.splitter else { return };
        let foremost = (0..points.len()).min_by(|&a, &b| points[a].x.total_cmp(&points[b].x)).unwrap_or(0);
        // Beside the flanks from where they are settled; round the nose before.
        let settled = splitter.nose.x + self.maker.nose_length();
        let side = |region: Region, line: &[LayerPoint]| {
            let to = line.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
            self.wall_positions(WallName::Splitter, region, (settled, to))
        };
        let (down, up) = (&points[..=foremost], &points[foremost..]);
        let mut low = side(Region::LowSide, down);
        low.reverse();
        let high = side(Region::HighSide, up);
        let free = |placed: &[Result<Placed, f64>]| {
            placed.iter().filter_map(|p| p.as_ref().ok()).copied().collect::<Vec<Placed>>()
        };
        let (mut before, after) = (free(&low), free(&high));
        let blocked: f64 = low.iter().chain(&high).filter_map(|p| p.as_ref().err()).sum();
        self.leave_out(made, Region::LowSide, blocked, IN_THE_WAY);
        if let (Some(a), Some(b)) = (before.last().copied(), after.first().copied()) {
            let arc: Vec<LayerPoint> = points.iter().copied().filter(|p| p.x < settled).collect();
            let mut round = vec![a];
            round.extend(self.arc(&arc, a, b));
            round.push(b);
            let mended = self.mended(round);
            before.extend(&mended[1..mended.len() - 1]);
        }
        before.extend(after);
        self.push_wall(WallName::Splitter, Region::Inlet, &mut before, made);
    }

    /// The positions with others between them where the straight way would come too near to a blade.
    fn mended(&self, positions: Vec<Placed>) -> Vec<Placed> {
        let mut mended: Vec<Placed> = Vec::with_capacity(positions.len());
        for next in positions {
            if let Some(last) = mended.last().copied() {
                self.mend(last, next, MENDS, &mut mended);
            }
            mended.push(next);
        }
        mended
    }

    fn mend(&self, a: Placed, b: Placed, depth: usize, mended: &mut Vec<Placed>) {
        let middle = a.between(&b, 0.5);
        let free = self.off(middle);
        if depth == 0 || (free.tip - middle.tip).norm() < MENDED {
            return;
        }
        self.mend(a, free, depth - 1, mended);
        mended.push(free);
        self.mend(free, b, depth - 1, mended);
    }

    /// Positions on the way round the nose from `a` to `b`: the axis turns evenly, and the cutter is moved off the nose
    /// where it would come too near.
    fn arc(&self, arc: &[LayerPoint], a: Placed, b: Placed) -> Vec<Placed> {
        if arc.len() < 2 {
            return Vec::new();
        }
        let maker = self.maker;
        let dense = self.dense(arc);
        let total = self.layer.length(&dense).max(1e-9);
        let mut gone = 0.0;
        let mut placed = Vec::with_capacity(dense.len());
        for (k, &p) in dense.iter().enumerate() {
            if k > 0 {
                gone += self.layer.step(dense[k - 1], p);
            }
            let axis = (a.axis + (b.axis - a.axis) * (gone / total)).normalize();
            let tip = maker.search.tip(&self.contact(p), &axis, self.surface) + axis * CHORD;
            placed.push(self.off(Placed { tip, axis, place: p }));
        }
        placed
    }

    /// The cutter, moved over the layer away from the splitter's nose until it keeps the allowance from all blades.
    fn off(&self, placed: Placed) -> Placed {
        let maker = self.maker;
        let mut contact = self.contact(placed.place);
        let mut tip = placed.tip;
        for _ in 0..PUSHES {
            let cutter = maker.tool.placed(tip, placed.axis);
            let short = maker.setup.stock.blade_allowance - maker.finished.blade_clearance(&cutter);
            let Some(away) = self.off_nose(&contact).filter(|_| short > 0.0) else { break };
            contact.point += away * (1.3 * short + 1e-4);
            tip = maker.search.tip(&contact, &placed.axis, self.surface) + placed.axis * CHORD;
        }
        Placed { tip, ..placed }
    }

    /// Direction on the layer away from the middle of the nose.
    fn off_nose(&self, contact: &Contact) -> Option<Vector> {
        let nose = self.found.borders.splitter.as_ref()?.nose;
        let away = contact.point - self.layer.point(nose);
        (away - contact.normal * away.dot(&contact.normal)).try_normalize(1e-9)
    }
}

impl PassMaker<'_> {
    /// How far behind its foremost point a splitter's flanks are settled, mm.
    fn nose_length(&self) -> f64 {
        let Some(splitter) = self.part.splitters.first() else { return 0.0 };
        let thick = |u: f64| (splitter.suction.point(u, 0.0) - splitter.pressure.point(u, 0.0)).norm();
        0.6 * thick(0.1)
    }
}
