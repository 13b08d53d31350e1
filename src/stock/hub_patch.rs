//! The hub about a circle of it, for heights of points over it: exact around Z, and to second order along the
//! meridional curve.

use crate::geometry::{Meridional, Point, Vector, norm2};
use crate::part::Impeller;

/// The hub about a circle of it.
#[derive(Debug)]
pub(super) struct HubPatch {
    /// The point on the meridional curve, mm.
    point: Meridional,
    /// Unit normal and tangent (towards the outlet) of the curve.
    normal: Meridional,
    tangent: Meridional,
    /// Curvature of the curve, 1/mm; positive where it is concave towards the channel.
    curvature: f64,
    /// Arc lengths to the ends of the hub, towards the inlet and towards the outlet, mm.
    ends: [f64; 2],
}

impl HubPatch {
    /// The hub of `part` about its points at `s`.
    pub(super) fn new(part: &Impeller, s: f64) -> Self {
        let hub = part.hub.at(s);
        let ends = [part.hub.arc_at(s), (1.0 - s) * part.hub.length()];
        let (point, normal, tangent) = (hub.point, hub.normal, hub.tangent);
        Self { point, normal, tangent, curvature: hub.curvature, ends }
    }

    /// Radius of the point, mm.
    pub(super) fn radius(&self) -> f64 {
        self.point.r
    }

    /// Unit normal and unit tangent at the point with θ = `theta`.
    pub(super) fn directions(&self, theta: f64) -> [Vector; 2] {
        [self.normal, self.tangent].map(|direction| direction.direction_at_angle(theta))
    }

    /// Coordinates along tangent and normal of the curve, mm.
    fn in_curve_frame(&self, r: f64, z: f64) -> (f64, f64) {
        let (r, z) = (r - self.point.r, z - self.point.z);
        (r * self.tangent.r + z * self.tangent.z, r * self.normal.r + z * self.normal.z)
    }

    /// How far `point` has to be moved along the unit vector `direction` until it is `allowance` mm above the
    /// hub, to first order, mm; negative where it is higher. `None` beyond the ends of the hub.
    pub(super) fn rise_to(&self, allowance: f64, point: &Point, direction: &Vector) -> Option<f64> {
        let r = norm2(point.x, point.y);
        let (a, b) = self.in_curve_frame(r, point.z);
        if a < -self.ends[0] || a > self.ends[1] {
            return None;
        }
        let slope = self.curvature * a;
        let scale = 1.0 / (1.0 + slope * slope).sqrt();
        let height = (b - 0.5 * slope * a) * scale;
        let normal_r = (self.normal.r - slope * self.tangent.r) * scale;
        let normal_z = (self.normal.z - slope * self.tangent.z) * scale;
        let radial = (point.x * direction.x + point.y * direction.y) / r.max(1e-6);
        let gain = normal_r * radial + normal_z * direction.z;
        Some((allowance - height) / gain.max(0.1))
    }
}
