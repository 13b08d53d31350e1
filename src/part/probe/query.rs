//! What the distance of a blade side is measured to: a cutter, a point, a piece of shank or holder.

use crate::geometry::{CutterSolid, Frustum, Point, Vector, norm2};

/// The object to which the distance of a side is measured.
pub(super) trait DistanceQuery {
    /// Signed distance of a point of the side, mm.
    fn distance(&self, p: &Point) -> f64;
    /// Largest radius of curvature of its surface where the distance has that gradient, mm.
    fn radius(&self, gradient: &Vector) -> f64;
    /// Estimate of the square of the length of `edge` times the largest curvature of the distance along it
    /// beside the surface, mm.
    fn bend(&self, edge: &Vector, gradient: &Vector) -> f64;
    /// The distance may have a kink where this value changes its sign.
    fn height(&self, p: &Point) -> f64;
    /// Distance of a point of the side, and its gradient.
    fn gradient(&self, p: &Point) -> (f64, Vector);
    /// First and second derivative by u of a smooth function with the same minimum as the distance; `None`
    /// where there is none.
    fn slope(&self, p: &Point, pu: &Vector, puu: &Vector) -> Option<(f64, f64)>;
    /// Whether the minimum of that function is certainly the minimum of the distance.
    fn smooth_at(&self, p: &Point) -> bool;
}

/// Radius of curvature below which it does not matter, mm.
const THINNEST: f64 = 1e-3;

/// Radius of curvature of a surface of revolution of the radius `radius` where its normal is `gradient`, by
/// Meusnier's theorem: endless on flat ends.
fn revolved_radius(radius: f64, gradient: &Vector, axis: &Vector) -> f64 {
    let along = gradient.dot(axis);
    radius / (1.0 - along * along).max(0.0).sqrt()
}

/// Square of the length of `edge` across `gradient` and `axis`.
fn across(edge: &Vector, gradient: &Vector, axis: &Vector) -> f64 {
    let (along, away) = (edge.dot(axis), edge.dot(gradient));
    (edge.norm_squared() - along * along - away * away).max(0.0)
}

/// The distance from a cutter.
pub(super) struct CutterQuery<'a> {
    pub(super) cutter: &'a CutterSolid,
}

/// A point in cylindrical coordinates of a cutter.
struct AxisCoordinates {
    /// From the axis to the point, mm.
    flat: Vector,
    radial: f64,
    /// Distances beyond the cylinder and below the plane between which the corner is rounded, mm.
    beyond: f64,
    below: f64,
}

impl CutterQuery<'_> {
    #[inline]
    fn axis_coordinates(&self, p: &Point) -> AxisCoordinates {
        let c = self.cutter;
        let d = p - c.tip;
        let height = d.dot(&c.axis);
        let flat = d - c.axis * height;
        let radial = flat.norm();
        AxisCoordinates {
            flat,
            radial,
            beyond: radial - (c.radius - c.corner_radius),
            below: c.corner_radius - height,
        }
    }
}

impl DistanceQuery for CutterQuery<'_> {
    #[inline]
    fn distance(&self, p: &Point) -> f64 {
        self.cutter.distance(p)
    }

    fn radius(&self, gradient: &Vector) -> f64 {
        revolved_radius(self.cutter.radius, gradient, &self.cutter.axis)
    }

    fn bend(&self, edge: &Vector, gradient: &Vector) -> f64 {
        across(edge, gradient, &self.cutter.axis) / self.radius(gradient).max(THINNEST)
    }

    fn height(&self, p: &Point) -> f64 {
        -self.axis_coordinates(p).below
    }

    fn gradient(&self, p: &Point) -> (f64, Vector) {
        let AxisCoordinates { flat, radial, beyond, below } = self.axis_coordinates(p);
        let (away, down) = (flat / radial.max(1e-9), -self.cutter.axis);
        let (sharp, gradient) = if beyond > 0.0 && below > 0.0 {
            let length = norm2(beyond, below);
            (length, (away * beyond + down * below) / length)
        } else if beyond >= below {
            (beyond, away)
        } else {
            (below, down)
        };
        (sharp - self.cutter.corner_radius, gradient)
    }

    /// Derivatives of half the squared distance from the axis, or from the edge of the bottom for points
    /// below that.
    #[inline]
    fn slope(&self, p: &Point, pu: &Vector, puu: &Vector) -> Option<(f64, f64)> {
        let AxisCoordinates { flat, radial, beyond, below } = self.axis_coordinates(p);
        let climb = pu.dot(&self.cutter.axis);
        // Of half the squared distance from the axis: radial · radial', radial'² + radial · radial''.
        let (half, bend) = (flat.dot(pu), pu.norm_squared() - climb * climb + flat.dot(puu));
        if below <= 0.0 {
            return Some((half, bend));
        }
        if beyond <= 0.0 {
            return None;
        }
        let leaving = half / radial;
        let turning = (bend - leaving * leaving) / radial;
        Some((
            beyond * leaving - below * climb,
            leaving * leaving + beyond * turning + climb * climb - below * puu.dot(&self.cutter.axis),
        ))
    }

    fn smooth_at(&self, p: &Point) -> bool {
        // Under the bottom, and deep inside, another surface of the cutter may be nearer.
        let AxisCoordinates { radial, beyond, below, .. } = self.axis_coordinates(p);
        (beyond > 0.0 || below <= beyond) && radial > 0.5 * self.cutter.radius
    }
}

/// The distance from a point.
pub(super) struct PointQuery<'a> {
    pub(super) point: &'a Point,
}

impl DistanceQuery for PointQuery<'_> {
    #[inline]
    fn distance(&self, p: &Point) -> f64 {
        (p - self.point).norm()
    }

    fn radius(&self, _: &Vector) -> f64 {
        0.0
    }

    fn bend(&self, _: &Vector, _: &Vector) -> f64 {
        0.0
    }

    fn height(&self, _: &Point) -> f64 {
        1.0
    }

    fn gradient(&self, p: &Point) -> (f64, Vector) {
        let d = p - self.point;
        let distance = d.norm();
        (distance, d / distance.max(1e-9))
    }

    fn slope(&self, p: &Point, pu: &Vector, puu: &Vector) -> Option<(f64, f64)> {
        let d = p - self.point;
        Some((d.dot(pu), pu.norm_squared() + d.dot(puu)))
    }

    fn smooth_at(&self, _: &Point) -> bool {
        true
    }
}

/// A cylinder from the lower end of a piece of shank or holder up that contains it.
pub(super) fn endless_cylinder_around(frustum: &Frustum) -> CutterSolid {
    let radius = frustum.radii[0].max(frustum.radii[1]);
    CutterSolid { tip: frustum.base, axis: frustum.axis, radius, corner_radius: 0.0 }
}

/// The distance from a piece of shank or holder.
pub(super) struct FrustumQuery<'a> {
    pub(super) frustum: &'a Frustum,
}

impl DistanceQuery for FrustumQuery<'_> {
    #[inline]
    fn distance(&self, p: &Point) -> f64 {
        self.frustum.distance(p)
    }

    fn radius(&self, gradient: &Vector) -> f64 {
        revolved_radius(self.frustum.radii[0].max(self.frustum.radii[1]), gradient, &self.frustum.axis)
    }

    fn bend(&self, edge: &Vector, gradient: &Vector) -> f64 {
        across(edge, gradient, &self.frustum.axis) / self.radius(gradient).max(THINNEST)
    }

    fn height(&self, p: &Point) -> f64 {
        (p - self.frustum.base).dot(&self.frustum.axis)
    }

    fn gradient(&self, p: &Point) -> (f64, Vector) {
        self.frustum.distance_and_gradient(p)
    }

    /// The distance itself has kinks at edges, so lines are searched without derivatives.
    fn slope(&self, _: &Point, _: &Vector, _: &Vector) -> Option<(f64, f64)> {
        None
    }

    fn smooth_at(&self, _: &Point) -> bool {
        false
    }
}
