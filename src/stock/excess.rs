//! Excess of stock: the distance of points to the finished surfaces of one channel.

use crate::geometry::{Meridional, Point};
use crate::part::{Impeller, SideProbe, Workpiece};

/// A side of a blade.
struct BladeFace {
    probe: SideProbe,
    /// Ball around it: centre and radius, mm.
    ball: (Point, f64),
    /// +1 where ∂u × ∂v points out of the blade, else −1.
    outward: f64,
}

/// The finished surfaces around channel 1 of a part, prepared for the distances of many points.
pub struct Excess<'a> {
    part: &'a Impeller,
    faces: Vec<BladeFace>,
}

impl<'a> Excess<'a> {
    /// The surfaces of `workpiece`.
    pub fn new(workpiece: &'a Workpiece) -> Self {
        let Workpiece { part, channel, .. } = workpiece;
        let sides = &channel.sides;
        // Both sides of each blade follow each other, so either tells where the inside of the other is.
        let face = |k: usize| {
            let (side, back) = (&sides[k], sides.get(k ^ 1));
            let (p, by_u, by_v) = side.derivatives(0.5, 0.5);
            let inward = back.map_or_else(crate::geometry::Vector::zeros, |back| back.point(0.5, 0.5) - p);
            let probe = SideProbe::new(side, 0.0, 1.0);
            let outward = if by_u.cross(&by_v).dot(&inward) > 0.0 { -1.0 } else { 1.0 };
            BladeFace { ball: probe.bounding_ball(), probe, outward }
        };
        Self { part, faces: (0..sides.len()).map(face).collect() }
    }

    /// Distance of `point` to the nearest finished surface, mm: stock that stands there, negative where the
    /// finished part is cut into.
    pub fn at(&self, point: &Point) -> f64 {
        let (part, m) = (self.part, Meridional::of(point));
        let (_, above_hub) = part.hub.curve().project(m);
        let (mut nearest, mut nearest_side) = (above_hub, None);
        for face in &self.faces {
            let (centre, radius) = face.ball;
            if (point - centre).norm() - radius > nearest.abs() {
                continue;
            }
            let Some(near) = face.probe.nearest_to_point_below(point, nearest.abs()) else { continue };
            if near.distance < nearest.abs() {
                let side = face.probe.side();
                let (p, by_u, by_v) = side.derivatives(near.u, near.v);
                let out = face.outward * by_u.cross(&by_v).dot(&(point - p));
                nearest = near.distance.copysign(out);
                nearest_side = Some((side, near.u));
            }
        }
        if let Some((side, u)) = nearest_side.filter(|_| nearest < 0.0) {
            // Between the sides of a blade, or of one prolonged: above its tip, that is the nearest surface. Tips
            // run along the shroud, and some at a distance below it; the foot on a side may lie below the end of
            // the side, as tips are cut at an angle to it.
            let above_shroud = |at: Meridional| part.shroud.curve().project(at).1;
            let above_tip = above_shroud(m) - above_shroud(Meridional::of(&side.point(u, 1.0)));
            if above_tip > 0.0 {
                return above_tip.min(-nearest);
            }
        }
        nearest
    }
}
