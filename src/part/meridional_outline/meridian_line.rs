//! A line in space against the boxes and edges of an outline.

use super::edge_box::{EdgeBox, SAME};
use crate::geometry::{Meridional, Point, Vector};

/// A line in space as it runs in the meridional plane: r² is a quadratic of the height along the line.
pub(super) struct MeridianLine {
    /// r² = a h² + 2 b h + c.
    a: f64,
    b: f64,
    c: f64,
    /// z = z0 + dz h.
    z0: f64,
    dz: f64,
}

impl MeridianLine {
    pub fn new(origin: &Point, direction: &Vector) -> Self {
        Self {
            a: direction.x * direction.x + direction.y * direction.y,
            b: origin.x * direction.x + origin.y * direction.y,
            c: origin.x * origin.x + origin.y * origin.y,
            z0: origin.z,
            dz: direction.z,
        }
    }

    pub fn r_squared(&self, h: f64) -> f64 {
        (self.a * h + 2.0 * self.b) * h + self.c
    }

    /// Whether the line may meet a box between heights `low` and `high`.
    pub fn may_meet(&self, other: &EdgeBox, low: f64, high: f64) -> bool {
        let (mut low, mut high) = (low, high);
        let (bottom, top) = (other.low.z - SAME, other.high.z + SAME);
        if self.dz.abs() > 1e-12 {
            let (p, q) = ((bottom - self.z0) / self.dz, (top - self.z0) / self.dz);
            (low, high) = (low.max(p.min(q)), high.min(p.max(q)));
        } else if self.z0 < bottom || self.z0 > top {
            return false;
        }
        if low > high {
            return false;
        }
        // r² is convex: largest at an end, least at its vertex.
        let vertex = if self.a > 1e-18 { (-self.b / self.a).clamp(low, high) } else { low };
        let (inner, outer) = ((other.low.r - SAME).max(0.0), other.high.r + SAME);
        self.r_squared(vertex) <= outer * outer
            && self.r_squared(low).max(self.r_squared(high)) >= inner * inner
    }

    /// Heights at which the line crosses the cone, cylinder or plane of an edge.
    pub fn crossings(&self, a: Meridional, b: Meridional) -> [Option<f64>; 2] {
        let (dr, dz) = (b.r - a.r, b.z - a.z);
        if dz.abs() <= 1e-9 * dr.abs() {
            if self.dz.abs() < 1e-12 {
                return [None; 2];
            }
            let h = (a.z - self.z0) / self.dz;
            let r = self.r_squared(h).max(0.0).sqrt();
            let (inner, outer) = (a.r.min(b.r) - 1e-9, a.r.max(b.r) + 1e-9);
            return [(inner..=outer).contains(&r).then_some(h), None];
        }
        // r = p + q h on the edge, so that (a − q²) h² + 2 (b − p q) h + c − p² = 0.
        let slope = dr / dz;
        let (p, q) = (a.r + slope * (self.z0 - a.z), slope * self.dz);
        let (low, high) = (a.z.min(b.z) - 1e-9, a.z.max(b.z) + 1e-9);
        let valid = |h: f64| {
            let z = self.z0 + self.dz * h;
            (h.is_finite() && (low..=high).contains(&z) && p + q * h >= -1e-9).then_some(h)
        };
        let (u, v, w) = (self.a - q * q, self.b - p * q, self.c - p * p);
        let scale = self.a + q * q;
        if u.abs() <= 1e-14 * scale {
            return [if v.abs() > 1e-300 { valid(-0.5 * w / v) } else { None }, None];
        }
        let discriminant = v * v - u * w;
        if discriminant < 0.0 {
            return [None; 2];
        }
        // The stable one of both formulas for each root.
        let t = -(v + discriminant.sqrt().copysign(v));
        let first = valid(t / u);
        let second = if t == 0.0 { first } else { valid(w / t) };
        [first, second]
    }
}
