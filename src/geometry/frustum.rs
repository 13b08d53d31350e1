//! A truncated cone or cylinder: a piece of a shank or holder.

use super::{Point, Vector, norm2};

/// A truncated cone with flat ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Centre of the lower end, mm.
    pub base: Point,
    /// Unit axis, lower → upper end.
    pub axis: Vector,
    /// Length, mm.
    pub length: f64,
    /// Radius at the lower and at the upper end, mm.
    pub radii: [f64; 2],
}

impl Frustum {
    /// Height above the lower end and distance from the axis of a point, mm, and its unit direction away from
    /// the axis (zero on it).
    fn cylindrical(&self, point: &Point) -> (f64, f64, Vector) {
        let d = point - self.base;
        let height = d.dot(&self.axis);
        let flat = d - self.axis * height;
        let radial = flat.norm();
        (height, radial, flat / radial.max(1e-12))
    }

    /// It with `distance` mm more all around; its lower end is lower by that.
    pub fn widened(&self, distance: f64) -> Self {
        Self {
            base: self.base - self.axis * distance,
            length: self.length + 2.0 * distance,
            radii: self.radii.map(|radius| radius + distance),
            ..*self
        }
    }

    /// Signed distance from `point` to the surface, mm; negative inside.
    pub fn distance(&self, point: &Point) -> f64 {
        let (height, radial, _) = self.cylindrical(point);
        self.distance_and_gradient_2d(height, radial).0
    }

    /// Signed distance from `point` to the surface, and its gradient.
    pub fn distance_and_gradient(&self, point: &Point) -> (f64, Vector) {
        let (height, radial, away) = self.cylindrical(point);
        let (distance, [along, across]) = self.distance_and_gradient_2d(height, radial);
        (distance, self.axis * along + away * across)
    }

    /// Distance in the half plane of the axis to the trapezoid that is revolved, with its gradient by height
    /// and radial distance.
    fn distance_and_gradient_2d(&self, height: f64, radial: f64) -> (f64, [f64; 2]) {
        let [lower, upper] = self.radii;
        let (dh, dr) = (self.length, upper - lower);
        let slant = norm2(dh, dr);
        let slanted = (radial - lower) * dh - height * dr;
        let inside = height > 0.0 && height < self.length && slanted < 0.0;
        // Feet on the ends, which reach from the axis to the rim, and on the slanted side.
        let share = ((height * dh + (radial - lower) * dr) / (slant * slant)).clamp(0.0, 1.0);
        let feet =
            [[0.0, radial.min(lower)], [self.length, radial.min(upper)], [share * dh, lower + share * dr]];
        let normals = [[-1.0, 0.0], [1.0, 0.0], [-dr / slant, dh / slant]];
        let mut best = (f64::INFINITY, [0.0; 2]);
        for ([h, r], normal) in feet.into_iter().zip(normals) {
            let off = [height - h, radial - r];
            let distance = norm2(off[0], off[1]);
            if distance < best.0 {
                let sign = if inside { -1.0 } else { 1.0 };
                let gradient = if distance > 1e-9 { off.map(|x| sign * x / distance) } else { normal };
                best = (distance, gradient);
            }
        }
        (if inside { -best.0 } else { best.0 }, best.1)
    }

    /// A ball around it: centre and radius, mm.
    pub fn bounding_ball(&self) -> (Point, f64) {
        let widest = self.radii[0].max(self.radii[1]);
        (self.base + self.axis * (0.5 * self.length), norm2(0.5 * self.length, widest))
    }

    /// Radius at the share 0…1 of its length, mm.
    pub fn radius_at(&self, share: f64) -> f64 {
        self.radii[0] + (self.radii[1] - self.radii[0]) * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CONE: Frustum = Frustum {
        base: Point::new(0.0, 0.0, 10.0),
        axis: Vector::new(0.0, 0.0, 1.0),
        length: 30.0,
        radii: [10.0, 20.0],
    };

    /// Closed form: the rim of the lower end is nearest to a plane below, and the slanted side to a point
    /// beside it at (r − r₀) cos β, with β the half angle of the cone.
    #[test]
    fn distances_of_ends_and_side_in_closed_form() {
        for (p, expected) in [
            (Point::new(0.0, 0.0, 4.0), 6.0),
            (Point::new(9.0, 0.0, 4.0), 6.0),
            (Point::new(13.0, 0.0, 6.0), 5.0),
            (Point::new(0.0, 0.0, 47.0), 7.0),
            (Point::new(0.0, 19.0, 41.0), 1.0),
            (Point::new(0.0, 0.0, 11.0), -1.0),
        ] {
            assert!((CONE.distance(&p) - expected).abs() < 1e-12, "{p}");
        }
        let cos = 3.0 / 10f64.sqrt();
        for off in [-2.0, -0.5, 0.5, 4.0] {
            let p = Point::new(15.0 + off, 0.0, 25.0);
            assert!((CONE.distance(&p) - off * cos).abs() < 1e-12, "{off}");
        }
    }

    proptest! {
        #[test]
        fn the_gradient_is_that_of_the_distance(
            x in -40.0..40.0f64, y in -40.0..40.0f64, z in -20.0..60.0f64,
        ) {
            let p = Point::new(x, y, z);
            let (d, gradient) = CONE.distance_and_gradient(&p);
            let step = 1e-5;
            let onward = CONE.distance(&(p + gradient * step)) - d;
            // Along its gradient a distance grows at the rate 1, except across an edge of the medial axis.
            prop_assert!(onward <= step + 1e-12);
            prop_assert!(d < 0.0 || onward > step * (1.0 - 1e-3), "{onward}");
        }
    }
}
