//! Control points of piecewise cubics, by their blossoms.

use crate::geometry::{Cubic, Meridional, MeridionalCurve};

/// Largest distance of the curves of hub and shroud from those of the part, mm.
const CURVE_ERROR: f64 = 1e-7;
/// Largest number of pieces of the curve of hub or shroud.
const MAX_PIECES: usize = 1024;

/// Control points of the C2 piecewise cubic `at` over `knots` as a clamped B-spline of degree 3.
///
/// The control point of three successive knots is the blossom of any piece between them (Ramshaw). Four
/// values of each piece determine it exactly.
pub fn control_points(knots: &[f64], at: impl Fn(f64) -> [f64; 3]) -> Vec<[f64; 3]> {
    let last = knots.len() - 1;
    let pieces: Vec<[[f64; 4]; 3]> = knots
        .windows(2)
        .map(|w| {
            let values = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|x| at(w[0] + (w[1] - w[0]) * x));
            std::array::from_fn(|k| {
                let [p0, p1, p2, p3] = values.map(|v| v[k]);
                [
                    p0,
                    -5.5 * p0 + 9.0 * p1 - 4.5 * p2 + p3,
                    9.0 * p0 - 22.5 * p1 + 18.0 * p2 - 4.5 * p3,
                    -4.5 * p0 + 13.5 * p1 - 13.5 * p2 + 4.5 * p3,
                ]
            })
        })
        .collect();
    // Index of the knot at place `i` of the full knot vector.
    let full = |i: usize| i.saturating_sub(3).min(last);
    (0..last + 3)
        .map(|i| {
            let piece = full(i + 2).min(last - 1);
            let (start, width) = (knots[piece], knots[piece + 1] - knots[piece]);
            let [a, b, c] = [1, 2, 3].map(|k| (knots[full(i + k)] - start) / width);
            let [sum, pairs, product] = [(a + b + c) / 3.0, (a * b + b * c + c * a) / 3.0, a * b * c];
            std::array::from_fn(|k| {
                let p = &pieces[piece][k];
                p[0] + p[1] * sum + p[2] * pairs + p[3] * product
            })
        })
        .collect()
}

/// Knots and control points of a stretch of a meridional curve, in the plane y = 0, within [`CURVE_ERROR`].
pub fn generatrix(curve: &MeridionalCurve, from: f64, to: f64) -> (Vec<f64>, Vec<[f64; 3]>) {
    let point = |t: f64| {
        let p = curve.point(t);
        Meridional { r: p.r.max(0.0), z: p.z }
    };
    let mut pieces = 16;
    loop {
        let at = |k: f64| from + (to - from) * k / pieces as f64;
        let knots: Vec<f64> = (0..=pieces).map(|k| at(k as f64)).collect();
        let points: Vec<[f64; 2]> = knots.iter().map(|t| [point(*t).r, point(*t).z]).collect();
        let spline = Cubic::interpolate(&knots, &points);
        let off = |k: f64| {
            let ([r, z], exact) = (spline.point(at(k)), point(at(k)));
            exact.distance(Meridional { r, z })
        };
        let worst = (0..4 * pieces).map(|k| off(k as f64 / 4.0)).fold(0.0, f64::max);
        if worst < CURVE_ERROR || pieces >= MAX_PIECES {
            let control = control_points(&knots, |t| {
                let [r, z] = spline.point(t);
                [r, 0.0, z]
            });
            return (knots, control);
        }
        pieces *= 2;
    }
}
