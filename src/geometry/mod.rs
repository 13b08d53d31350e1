//! Geometry in f64, mm and rad: points, curves, the cutter solid, and numerical searches.

pub mod cells;
pub mod cubic;
pub mod cutter;
pub mod envelope;
mod frustum;
pub mod meridian;
pub mod search;

pub use cells::ProximityGrid;
pub use cubic::Cubic;
pub use cutter::CutterSolid;
pub use frustum::Frustum;
pub use meridian::MeridionalCurve;

/// A point in the part frame: rotation axis Z, mm.
pub type Point = nalgebra::Point3<f64>;
/// A vector in the part frame, mm (without unit for directions).
pub type Vector = nalgebra::Vector3<f64>;

/// `count` evenly spaced values from `from` to `to`, at least two.
pub fn evenly(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect()
}

/// A point by the bits of its coordinates, as a key; both zeros are one.
pub fn bits_of(p: &Point) -> [u64; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}

/// A point of the meridional plane (r, z), mm; also used for directions in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Meridional {
    /// Distance from the rotation axis.
    pub r: f64,
    /// Coordinate along the rotation axis.
    pub z: f64,
}

impl Meridional {
    /// The point `point` rotated about the rotation axis into the meridional plane.
    pub fn from_point(point: &Point) -> Self {
        Self { r: norm2(point.x, point.y), z: point.z }
    }

    /// This point at angle `theta` (rad) about the rotation axis.
    pub fn at_angle(self, theta: f64) -> Point {
        let (sin, cos) = theta.sin_cos();
        Point::new(self.r * cos, self.r * sin, self.z)
    }

    /// This direction at angle `theta` (rad) about the rotation axis.
    pub fn direction_at_angle(self, theta: f64) -> Vector {
        let (sin, cos) = theta.sin_cos();
        Vector::new(self.r * cos, self.r * sin, self.z)
    }

    /// Distance to `other`, mm.
    pub fn distance(self, other: Self) -> f64 {
        norm2(self.r - other.r, self.z - other.z)
    }

    /// `self + (other − self) · fraction`.
    pub fn lerp(self, other: Self, fraction: f64) -> Self {
        Self { r: self.r + (other.r - self.r) * fraction, z: self.z + (other.z - self.z) * fraction }
    }

    /// The point of the segment from `a` to `b` that is nearest to this one, with its distance, mm.
    pub fn nearest_on_segment(self, a: Self, b: Self) -> (f64, Self) {
        let (dr, dz) = (b.r - a.r, b.z - a.z);
        let length_squared = (dr * dr + dz * dz).max(f64::MIN_POSITIVE);
        let share = ((self.r - a.r) * dr + (self.z - a.z) * dz) / length_squared;
        let foot = a.lerp(b, share.clamp(0.0, 1.0));
        (self.distance(foot), foot)
    }
}

/// √(x² + y²). Lengths in mm neither overflow nor underflow when squared, and `f64::hypot`, which guards
/// against that, is ten times slower in hot loops.
#[inline]
pub fn norm2(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// `point` rotated about the rotation axis by `angle_rad`.
pub fn rotate_z(point: &Point, angle_rad: f64) -> Point {
    let (sin, cos) = angle_rad.sin_cos();
    Point::new(cos * point.x - sin * point.y, sin * point.x + cos * point.y, point.z)
}

/// `vector` rotated about the rotation axis by `angle_rad`.
pub fn rotate_vector_z(vector: &Vector, angle_rad: f64) -> Vector {
    let (sin, cos) = angle_rad.sin_cos();
    Vector::new(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y, vector.z)
}

/// Two unit vectors u, v such that (u, v, `axis`) is a right-handed orthonormal frame; `axis` is a unit
/// vector.
pub fn frame_about(axis: &Vector) -> (Vector, Vector) {
    let helper = if axis.z.abs() < 0.9 { Vector::z() } else { Vector::x() };
    let u = helper.cross(axis).normalize();
    (u, axis.cross(&u))
}

/// A circle in space.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    centre: Point,
    /// Radius vectors at angle 0 and at a quarter turn, mm.
    radii: (Vector, Vector),
}

impl Circle {
    /// A circle of `radius` mm about the unit vector `axis`; angles are measured from the first vector of
    /// [`frame_about`].
    pub fn new(centre: &Point, axis: &Vector, radius: f64) -> Self {
        let (e1, e2) = frame_about(axis);
        Self { centre: *centre, radii: (e1 * radius, e2 * radius) }
    }

    /// Point at an angle given as (sin, cos), and its derivative with respect to the angle.
    #[inline]
    pub fn point_and_derivative(&self, (sin, cos): (f64, f64)) -> (Point, Vector) {
        let (e1, e2) = self.radii;
        (self.centre + e1 * cos + e2 * sin, e2 * cos - e1 * sin)
    }
}

/// Derivative of the distance of `point` from the circle about the rotation axis through `foot`, as the
/// point moves along `direction`; mm per unit of `direction`.
pub fn distance_rate(point: &Point, direction: &Vector, foot: Meridional) -> f64 {
    let from = Meridional::from_point(point);
    let (dr, dz) = (from.r - foot.r, from.z - foot.z);
    let radial = (point.x * direction.x + point.y * direction.y) / from.r.max(1e-12);
    (dr * radial + dz * direction.z) / norm2(dr, dz).max(1e-12)
}

/// `value` without the error of converting its unit, and back: rounded to 1e-9. 5° would be
/// 5.000000000000001°, and 3 in 76.19999999999999 mm.
pub fn without_conversion_error(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// `angle` (rad) normalised to (−π, π].
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = (angle + PI).rem_euclid(TAU) - PI;
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::without_conversion_error;

    #[test]
    fn converted_numbers_are_those_that_people_write() {
        assert_eq!(without_conversion_error((std::f64::consts::TAU / 6.0).to_degrees()), 60.0);
        assert_eq!(without_conversion_error(3.0 * 25.4), 76.2);
    }
}
