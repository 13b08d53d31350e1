//! Twist and bow of a blade (twisting and bending degree in [assessment paper, section I.B, fig. 1 and 2]).
//!
//! Both are taken on the camber surface, the mean of suction and pressure side at equal (u, v): on the sides
//! themselves the nose would dominate.

use crate::geometry::{Point, Vector};
use crate::part::Blade;

/// Shape of one blade.
#[derive(Clone, Debug)]
pub struct BladeShape {
    /// Twist of the camber lines, evenly spaced from hub to tip.
    pub twists: Vec<Twist>,
    /// Maximum turn of the normal of the camber surface from hub to tip, rad: 0 for cylindrical blades, whose
    /// twist is only the angle of their lines to the axis.
    pub normal_turn_rad: f64,
    /// Bow where its offset is greatest.
    pub bow: Bow,
    /// Bow where the angle between its chords is greatest.
    pub sharpest_bow: Bow,
}

/// Twist of one camber line LE → TE. Angles are to the rotation axis, 0 along it to π/2 across it, rad.
#[derive(Clone, Copy, Debug)]
pub struct Twist {
    /// v of the line, hub 0 to tip 1.
    pub v: f64,
    /// Twist: the larger angle of the two chords, rad.
    pub angle_rad: f64,
    /// Angles of the chords LE → split and split → TE, rad.
    pub chord_angles_rad: [f64; 2],
    /// Where the line is split, at its maximum curvature: fraction of its length from the LE.
    pub split: f64,
    /// Maximum angle of the tangent, rad. Unlike the twist it does not jump where two points have equal
    /// curvature.
    pub max_tangent_rad: f64,
    /// Where that is, as a fraction of the length.
    pub max_tangent_at: f64,
}

/// Bow of one curve hub → tip at mid span.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bow {
    /// u of the curve.
    pub u: f64,
    /// Distance of the mid section from the straight line between hub and tip, mm.
    pub offset: f64,
    /// Angle between the chords hub → mid and mid → tip, rad.
    pub angle_rad: f64,
}

/// Share of a camber line left out at both ends in the search for curvature and tangents: noses and blunt
/// edges are more curved than any blade.
const TRIM: f64 = 0.05;
/// Lines from hub to tip. The split jumps from line to line where two points have equal curvature, and the
/// twist with it by some degrees: the maximum needs lines on both sides of the jump.
const LINES: usize = 20;
/// Points along a line.
const STEPS: usize = 400;
/// Curvature is the turn over this many steps before and after a point, 1 % of the blade, so that noise of
/// digitised points does not decide.
const WINDOW: usize = 4;
/// Curves hub → tip.
const CURVES: usize = 40;

impl BladeShape {
    /// Measures a blade.
    pub fn from_blade(blade: &Blade) -> Self {
        let mut line = Vec::with_capacity(STEPS + 1);
        let twists = (0..=LINES).map(|k| measure_twist(blade, k as f64 / LINES as f64, &mut line)).collect();
        let curve_u = |i: usize| TRIM + (1.0 - 2.0 * TRIM) * i as f64 / CURVES as f64;
        let bends = || (0..=CURVES).map(|i| measure_bow(blade, curve_u(i)));
        let most = |of: fn(&Bow) -> f64| bends().max_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or_default();
        let turn = (0..=CURVES).map(|i| normal_turn(blade, curve_u(i))).fold(0.0, f64::max);
        Self { twists, normal_turn_rad: turn, bow: most(|b| b.offset), sharpest_bow: most(|b| b.angle_rad) }
    }

    /// The most twisted line; its twist is that of the blade.
    pub fn max_twist(&self) -> Option<&Twist> {
        self.twists.iter().max_by(|a, b| a.angle_rad.total_cmp(&b.angle_rad))
    }

    /// The lines at hub, mid span and tip.
    pub fn hub_mid_tip(&self) -> [Twist; 3] {
        [0, LINES / 2, LINES].map(|k| self.twists[k])
    }
}

fn camber(blade: &Blade, u: f64, v: f64) -> Point {
    nalgebra::center(&blade.suction.point(u, v), &blade.pressure.point(u, v))
}

/// Angle between a direction and the rotation axis, 0 to π/2.
fn from_axis(d: Vector) -> f64 {
    d.x.hypot(d.y).atan2(d.z.abs())
}

/// Writes the points of the camber line at `v`, LE → TE, each with the length up to it, into `line`. Returns
/// the whole length.
fn camber_line(blade: &Blade, v: f64, line: &mut Vec<(f64, Point)>) -> f64 {
    line.clear();
    let mut length = 0.0;
    for i in 0..=STEPS {
        let p = camber(blade, i as f64 / STEPS as f64, v);
        length += line.last().map_or(0.0, |(_, last)| (p - last).norm());
        line.push((length, p));
    }
    length
}

/// Angle of the tangent along the camber line at `v`, as (fraction of the length from the LE, rad to the
/// axis), with the ends trimmed.
pub fn tangents(blade: &Blade, v: f64) -> Vec<(f64, f64)> {
    let mut line = Vec::with_capacity(STEPS + 1);
    let length = camber_line(blade, v, &mut line);
    line.windows(3)
        .map(|w| (w[1].0 / length, from_axis(w[2].1 - w[0].1)))
        .filter(|(at, _)| (TRIM..=1.0 - TRIM).contains(at))
        .collect()
}

/// Twist of the camber line at `v`. `line` is a buffer.
fn measure_twist(blade: &Blade, v: f64, line: &mut Vec<(f64, Point)>) -> Twist {
    let length = camber_line(blade, v, line);
    let step = |i: usize, j: usize| line[j].1 - line[i].1;
    let mut twist = Twist {
        v,
        angle_rad: 0.0,
        chord_angles_rad: [0.0; 2],
        split: 0.5,
        max_tangent_rad: 0.0,
        max_tangent_at: TRIM,
    };
    let (mut largest_curvature, mut split) = (f64::NEG_INFINITY, STEPS / 2);
    for i in WINDOW..=STEPS - WINDOW {
        let at = line[i].0 / length;
        if !(TRIM..=1.0 - TRIM).contains(&at) {
            continue;
        }
        let (before, after) = (step(i - WINDOW, i), step(i, i + WINDOW));
        let curvature = before.angle(&after) / (0.5 * (before.norm() + after.norm()));
        if curvature > largest_curvature {
            (largest_curvature, split) = (curvature, i);
            twist.split = at;
        }
        let tangent = from_axis(step(i - 1, i + 1));
        if tangent > twist.max_tangent_rad {
            (twist.max_tangent_rad, twist.max_tangent_at) = (tangent, at);
        }
    }
    // The chords run from end to end of the blade as in the paper; only the search is trimmed.
    twist.chord_angles_rad = [from_axis(step(0, split)), from_axis(step(split, STEPS))];
    twist.angle_rad = twist.chord_angles_rad[0].max(twist.chord_angles_rad[1]);
    twist
}

fn measure_bow(blade: &Blade, u: f64) -> Bow {
    let [hub, middle, tip] = [0.0, 0.5, 1.0].map(|v| camber(blade, u, v));
    let (lower, upper) = (middle - hub, tip - middle);
    let Some(straight) = (tip - hub).try_normalize(1e-12) else { return Bow { u, ..Bow::default() } };
    Bow { u, offset: (lower - straight * lower.dot(&straight)).norm(), angle_rad: lower.angle(&upper) }
}

/// Angle between the normals of the camber surface at hub and tip, rad.
fn normal_turn(blade: &Blade, u: f64) -> f64 {
    let [hub, tip] = [0.0, 1.0].map(|v| {
        let sides = [&blade.suction, &blade.pressure].map(|side| side.derivatives(u, v));
        (sides[0].1 + sides[1].1).cross(&(sides[0].2 + sides[1].2))
    });
    hub.angle(&tip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::BladeSide;

    /// A blade whose camber surface is `point(u, v)`, 2 mm thick along y.
    fn blade(sections: usize, point: impl Fn(f64, f64) -> Point) -> Blade {
        let u: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0).collect();
        let v: Vec<f64> = (0..sections).map(|k| k as f64 / (sections - 1) as f64).collect();
        let side = |y: f64| {
            let sections: Vec<Vec<Point>> = v
                .iter()
                .map(|&v| u.iter().map(|&u| point(u, v) + Vector::new(0.0, y, 0.0)).collect())
                .collect();
            BladeSide::loft(&u, &v, &sections)
        };
        Blade { suction: side(1.0), pressure: side(-1.0) }
    }

    #[test]
    fn a_flat_radial_blade_has_the_twist_of_its_stagger_and_no_bend() {
        for stagger in [0.0, 25f64.to_radians(), 60f64.to_radians()] {
            let shape = BladeShape::from_blade(&blade(2, |u, v| {
                Point::new(30.0 + 40.0 * v, 50.0 * u * stagger.sin(), -50.0 * u * stagger.cos())
            }));
            for t in &shape.twists {
                assert!((t.angle_rad - stagger).abs() < 1e-9, "degree {} at {}", t.angle_rad, t.v);
                assert!(
                    (t.max_tangent_rad - stagger).abs() < 1e-9,
                    "tangent {} at {}",
                    t.max_tangent_rad,
                    t.v
                );
            }
            assert!(shape.bow.offset < 1e-9 && shape.sharpest_bow.angle_rad < 1e-6, "{:?}", shape.bow);
        }
    }

    #[test]
    fn a_blade_of_two_flat_pieces_is_split_at_its_knee() {
        // 20° and 70° from the axis, joined by a short arc at 60 % of the length.
        let (knee, from, to) = (0.6, 20f64.to_radians(), 70f64.to_radians());
        let direction = |t: f64| from + (to - from) * ((t - knee) / 0.04 + 0.5).clamp(0.0, 1.0);
        let path = |u: f64| {
            let steps = 2000;
            let h = u / f64::from(steps);
            let sum = (0..steps).fold((0.0, 0.0), |(y, z), k| {
                let a = direction((f64::from(k) + 0.5) * h);
                (y + h * a.sin(), z + h * a.cos())
            });
            (100.0 * sum.0, 100.0 * sum.1)
        };
        let shape = BladeShape::from_blade(&blade(2, |u, v| {
            let (y, z) = path(u);
            Point::new(40.0 + 20.0 * v, y, z)
        }));
        let most = shape.max_twist().expect("lines");
        assert!((most.split - knee).abs() < 0.02, "split at {}", most.split);
        let chords = most.chord_angles_rad.map(f64::to_degrees);
        assert!((chords[0] - 20.0).abs() < 1.5 && (chords[1] - 70.0).abs() < 1.5, "{chords:?}");
        assert_eq!(most.angle_rad, most.chord_angles_rad[1]);
        assert!((most.max_tangent_rad - to).abs() < 5e-3, "{}", most.max_tangent_rad.to_degrees());
    }

    #[test]
    fn a_cylindrical_blade_does_not_turn_and_a_warped_one_does() {
        // An arc across the axis, its rulings along the axis; then turned by 30° from hub to tip.
        let arc = |u: f64| (60.0 * u.sin(), 60.0 * (1.0 - u.cos()));
        let flat = BladeShape::from_blade(&blade(3, |u, v| {
            let (x, y) = arc(u);
            Point::new(40.0 + x, y, 20.0 * v)
        }));
        assert!(flat.normal_turn_rad < 1e-6, "{}", flat.normal_turn_rad);
        assert!((flat.twists[0].angle_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "across the axis");
        let warp = 30f64.to_radians();
        let warped = BladeShape::from_blade(&blade(9, |u, v| {
            let (sin, cos) = (warp * v).sin_cos();
            Point::new(100.0 * u * cos, 100.0 * u * sin, 400.0 * v)
        }));
        assert!(
            (warped.normal_turn_rad - warp).abs() < 0.1 * warp,
            "{}",
            warped.normal_turn_rad.to_degrees()
        );
    }

    #[test]
    fn a_bow_is_its_offset_and_the_angle_of_its_chords() {
        // 1.5 mm at mid span of a blade 40 mm high, most at the trailing edge.
        let bow = |u: f64, v: f64| 1.5 * u * 4.0 * v * (1.0 - v);
        let shape =
            BladeShape::from_blade(&blade(5, |u, v| Point::new(30.0 + 40.0 * v, bow(u, v), 60.0 * u)));
        let expected = 1.5 * (1.0 - TRIM);
        assert!((shape.bow.offset - expected).abs() < 1e-9, "{:?}", shape.bow);
        assert!((shape.sharpest_bow.angle_rad - 2.0 * (expected / 20.0).atan()).abs() < 1e-9, "{shape:?}");
        assert!((shape.bow.u - (1.0 - TRIM)).abs() < 1e-12, "{:?}", shape.bow);
    }
}
