//! The faces at which a blank ends: the leading-edge line and the rim line, revolved about Z.

use std::f64::consts::TAU;

use crate::geometry::{Circle, Meridional, Point, Vector, norm2, search};

/// Places of a rim from which the search for its highest point on a face starts.
const RIM_PLACES: usize = 16;
/// Tolerance of that place, rad: the height is of second order in it.
const PLACE_TOLERANCE: f64 = 1e-5;
/// Times the place of the rim that is furthest inside is improved: in one step on a plane face, in a few on a
/// steep cone.
const PLACE_STEPS: usize = 3;

/// A conical or plane face, by the straight line of its meridional section.
#[derive(Clone, Copy, Debug)]
pub(super) struct EndFace {
    /// Its inner end, at the hub.
    pub hub: Meridional,
    /// Its outer end, at the shroud.
    pub shroud: Meridional,
}

impl EndFace {
    /// Height along `axis` (unit) above `centre`, mm, at which a disc of `radius` mm, lowered from above,
    /// touches the face between the circles of its ends; `None` where its rim misses it. Where it touches one
    /// of these circles first, that is higher.
    ///
    /// A cutter whose axis runs nearly along the face comes down beside the blank and enters it from the
    /// side; no circle of the face is then where it touches first.
    pub fn touch_height(&self, centre: &Point, axis: &Vector, radius: f64) -> Option<f64> {
        let rim = Circle::new(centre, axis, radius);
        let height = |angle: f64| {
            let (point, _) = rim.point_and_derivative(angle.sin_cos());
            self.highest_crossing(&point, axis).unwrap_or(f64::NEG_INFINITY)
        };
        let step = TAU / RIM_PLACES as f64;
        let sampled = (0..RIM_PLACES).map(|i| step * i as f64).map(|angle| (angle, height(angle)));
        let innermost = self.innermost_place(centre, axis, &rim).map(|angle| (angle, height(angle)));
        let (angle, best) = sampled.chain(innermost).max_by(|a, b| a.1.total_cmp(&b.1))?;
        if best == f64::NEG_INFINITY {
            return None;
        }
        let (_, refined) =
            search::minimum(|angle| -height(angle), angle - step, angle + step, PLACE_TOLERANCE);
        Some(best.max(-refined))
    }

    /// Angle on the rim of the point that stays inside of the face longest while the disc moves up: opposite
    /// to the face's normal where it leaves it.
    fn innermost_place(&self, centre: &Point, axis: &Vector, rim: &Circle) -> Option<f64> {
        // Radius vectors at angle 0 and at a quarter turn.
        let (east, north) = rim.point_and_derivative((0.0, 1.0));
        let east = east - centre;
        let mut at = centre + axis * self.highest_crossing(centre, axis).unwrap_or(0.0);
        let mut angle = None;
        for _ in 0..PLACE_STEPS {
            let normal = self.normal().direction_at_angle(at.y.atan2(at.x));
            let outward = if normal.dot(axis) < 0.0 { -normal } else { normal };
            let place = (-outward.dot(&north)).atan2(-outward.dot(&east));
            angle = Some(place);
            let (point, _) = rim.point_and_derivative(place.sin_cos());
            let Some(height) = self.highest_crossing(&point, axis) else { break };
            at = point + axis * height;
        }
        angle
    }

    /// Unit normal of the face in the meridional plane, to either side.
    fn normal(&self) -> Meridional {
        let (dr, dz) = (self.shroud.r - self.hub.r, self.shroud.z - self.hub.z);
        let length = norm2(dr, dz).max(f64::MIN_POSITIVE);
        Meridional { r: -dz / length, z: dr / length }
    }

    /// Highest h at which `origin + h · axis` is on the face.
    ///
    /// With the normal (m, n) the cone is m·r = c − n·z; the square of both sides is a quadratic in h, also
    /// for a plane, where m is 0 and both roots are the same.
    fn highest_crossing(&self, origin: &Point, axis: &Vector) -> Option<f64> {
        let Meridional { r: m, z: n } = self.normal();
        // From the plane of the face's inner end on: the numbers stay small, and so do rounding errors.
        let (level, rate) = (m * self.hub.r - n * (origin.z - self.hub.z), -n * axis.z);
        let a = rate * rate - m * m * (axis.x * axis.x + axis.y * axis.y);
        let b = rate * level - m * m * (origin.x * axis.x + origin.y * axis.y);
        let c = level * level - m * m * (origin.x * origin.x + origin.y * origin.y);
        let on_face = |h: f64| {
            let p = Meridional::from_point(&(origin + axis * h));
            let (dr, dz) = (self.shroud.r - self.hub.r, self.shroud.z - self.hub.z);
            let share = ((p.r - self.hub.r) * dr + (p.z - self.hub.z) * dz) / (dr * dr + dz * dz);
            // The other nappe of the cone solves the equation too.
            let is_same_side = (level + h * rate) * m >= 0.0 || m.abs() < 1e-9;
            (is_same_side && (0.0..=1.0).contains(&share)).then_some(h)
        };
        if a.abs() < 1e-15 {
            return (b.abs() > 1e-15).then(|| -0.5 * c / b).and_then(on_face);
        }
        // Parallel roots of a plane differ by rounding only.
        let root = (b * b - a * c).max(0.0).sqrt();
        let roots = [(-b + root) / a, (-b - root) / a];
        if b * b - a * c < -1e-12 * (b * b).max(1.0) {
            return None;
        }
        roots.into_iter().filter_map(on_face).max_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from −1 to 1, the same on every machine.
    fn dice() -> impl FnMut() -> f64 {
        let mut state = 17u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    #[test]
    fn the_touch_is_the_highest_point_of_the_rim_on_the_face() {
        let mut roll = dice();
        let mut touched = 0;
        for case in 0..200 {
            // Plane faces, nearly plane ones as interpolated curves have them, and cones of all slopes.
            let slope = [0.0, 1e-5, 10.0 * roll()][case % 3];
            let face = EndFace {
                hub: Meridional { r: 20.0, z: 5.0 },
                shroud: Meridional { r: 50.0, z: 5.0 + slope },
            };
            let tilt = if case % 2 == 0 { 0.1 } else { 1.0 };
            let axis = Vector::new(1.0, 0.6 * roll(), tilt * roll()).normalize();
            let centre = Point::new(20.0 + 8.0 * roll(), 10.0 * roll(), 5.0 + 4.0 * roll());
            let radius = 3.0 + 2.0 * roll();
            let rim = Circle::new(&centre, &axis, radius);
            // Brute force: signs of the distance from the line of the face, along lines of the rim.
            let (mut highest, mut at_radius) = (f64::NEG_INFINITY, 0.0);
            let distance = |p: Point| {
                let (p, normal) = (Meridional::from_point(&p), face.normal());
                (p.r - face.hub.r) * normal.r + (p.z - face.hub.z) * normal.z
            };
            for i in 0..180 {
                let (origin, _) = rim.point_and_derivative((TAU * f64::from(i) / 180.0).sin_cos());
                let at = |h: f64| origin + axis * h;
                let mut above = distance(at(100.0));
                for k in (-400..400).rev() {
                    let (low, high) = (0.25 * f64::from(k), 0.25 * f64::from(k + 1));
                    let (from, to) = (distance(at(low)), above);
                    above = from;
                    if from * to > 0.0 {
                        continue;
                    }
                    let h = low + (high - low) * from / (from - to);
                    let r = Meridional::from_point(&at(h)).r;
                    if (20.0..=50.0).contains(&r) {
                        if h > highest {
                            (highest, at_radius) = (h, r);
                        }
                        break;
                    }
                }
            }
            let found = face.touch_height(&centre, &axis, radius).unwrap_or(f64::NEG_INFINITY);
            // Near the circles of its ends the face is left to the touch of these.
            if (26.0..44.0).contains(&at_radius) {
                touched += 1;
                assert!(found > highest - 0.05, "case {case}: {found}, brute force {highest}");
            }
            // What is found is on the face, on a line of the rim.
            if found.is_finite() && found.abs() < 90.0 {
                let near = (0..7200).map(|i| {
                    let (origin, _) = rim.point_and_derivative((TAU * f64::from(i) / 7200.0).sin_cos());
                    distance(origin + axis * found).abs()
                });
                let nearest = near.fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.01, "case {case}: {nearest} mm off the face at {found}");
            }
        }
        assert!(touched > 40, "{touched} of 200 touch");
    }
}
