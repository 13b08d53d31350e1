//! The cutter as a solid: a cylinder, unbounded towards the holder, with a sharp or rounded corner.

use super::{Point, Vector};

/// A cutter at one pose. Its bottom disc is centred at `tip`; its axis points to the holder.
#[derive(Clone, Copy, Debug)]
pub struct CutterSolid {
    /// Centre of the bottom, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Radius, mm.
    pub radius: f64,
    /// Radius of the rounded corner, mm; 0 for a sharp one.
    pub corner_radius: f64,
}

impl CutterSolid {
    /// Signed distance from `point` to the cutter's surface, mm; negative inside.
    #[inline]
    pub fn distance(&self, point: &Point) -> f64 {
        let d = point - self.tip;
        let height = d.dot(&self.axis);
        let radial = (d.norm_squared() - height * height).max(0.0).sqrt();
        // A rounded cutter is a sharp one that is smaller by the corner radius, offset outwards by it.
        let c = self.corner_radius;
        let (outside_radial, below) = (radial - (self.radius - c), c - height);
        let sharp = if outside_radial <= 0.0 && below <= 0.0 {
            outside_radial.max(below)
        } else {
            let (x, y) = (outside_radial.max(0.0), below.max(0.0));
            (x * x + y * y).sqrt()
        };
        sharp - c
    }

    /// Interval of h (mm) in which `origin + h · direction` (unit) is inside a cylinder of radius `radius`
    /// about the cutter's axis, from the tip plane upwards without bound; `None` if it misses.
    /// The corner rounding is ignored.
    #[inline]
    pub fn column_interval(&self, radius: f64, origin: &Point, direction: &Vector) -> Option<(f64, f64)> {
        let from_tip = origin - self.tip;
        let along = direction.dot(&self.axis);
        let height = from_tip.dot(&self.axis);
        let d_perp = direction - self.axis * along;
        let p_perp = from_tip - self.axis * height;
        let quadratic = [d_perp.norm_squared(), d_perp.dot(&p_perp), p_perp.norm_squared() - radius * radius];
        column_interval(quadratic, height, along)
    }
}

/// Interval of h in which a h² + 2 b h + c < 0 (inside an unbounded cylinder) and `height` + `along` · h is
/// positive (above its bottom); `None` if it is empty.
#[inline]
pub fn column_interval([a, b, c]: [f64; 3], height: f64, along: f64) -> Option<(f64, f64)> {
    let (mut low, mut high) = if a < 1e-18 {
        if c > 0.0 {
            return None;
        }
        (f64::NEG_INFINITY, f64::INFINITY)
    } else {
        let discriminant = b * b - a * c;
        if discriminant <= 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        ((-b - root) / a, (-b + root) / a)
    };
    if along.abs() < 1e-15 {
        if height < 0.0 {
            return None;
        }
    } else if along > 0.0 {
        low = low.max(-height / along);
    } else {
        high = high.min(-height / along);
    }
    (low < high).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit() -> impl Strategy<Value = Vector> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64)
            .prop_filter("not short", |(x, y, z)| x * x + y * y + z * z > 0.01)
            .prop_map(|(x, y, z)| Vector::new(x, y, z).normalize())
    }

    fn point(range: f64) -> impl Strategy<Value = Point> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| Point::new(x, y, z))
    }

    proptest! {
        #[test]
        fn the_interval_is_where_the_line_is_inside(
            tip in point(20.0), axis in unit(), origin in point(30.0), direction in unit(),
            radius in 1.0..15.0f64,
        ) {
            let cutter = CutterSolid { tip, axis, radius, corner_radius: 0.0 };
            let interval = cutter.column_interval(radius, &origin, &direction);
            for i in -200..200 {
                let h = 0.4 * f64::from(i) + 0.013;
                let d = cutter.distance(&(origin + direction * h));
                let inside = interval.is_some_and(|(low, high)| low < h && h < high);
                prop_assert!(inside == (d < 0.0) || d.abs() < 1e-6, "h {h}, d {d}, {interval:?}");
            }
        }

        #[test]
        fn a_rounded_corner_only_takes_away(tip in point(5.0), axis in unit(), p in point(30.0)) {
            let sharp = CutterSolid { tip, axis, radius: 8.0, corner_radius: 0.0 };
            let rounded = CutterSolid { corner_radius: 3.0, ..sharp };
            prop_assert!(rounded.distance(&p) >= sharp.distance(&p) - 1e-9);
        }
    }
}
