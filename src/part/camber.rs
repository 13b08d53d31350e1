//! Blade sections from camber angle and thickness, as designers give them.

use super::description::CamberSpan;
use crate::geometry::{Cubic, Meridional, MeridionalCurve, Point};

/// Points per side.
const POINTS: usize = 96;

/// Sections (suction, pressure) of a blade given by camber angle and thickness per span. `hub` and `shroud`
/// run to the rim; fractions of the spans are fractions of their whole arc length.
///
/// The camber line follows dθ = tan β dm / r from the leading edge; each side is half the thickness from
/// it, measured along the circumference as t / cos β so that the trailing edge ends on the rim. The nose is
/// a half ellipse twice as long as it is thick. The suction side is the convex one, opposite to the direction
/// in which the blade turns downstream.
pub(super) fn sections(
    spans: &[CamberSpan],
    hub: &MeridionalCurve,
    shroud: &MeridionalCurve,
) -> (Vec<Vec<Point>>, Vec<Vec<Point>>) {
    let turned = spans.iter().map(|s| s.angle.iter().map(|a| a.1).sum::<f64>()).sum::<f64>();
    let suction_side = if turned >= 0.0 { -1.0 } else { 1.0 };
    let mut suction = Vec::new();
    let mut pressure = Vec::new();
    for span in spans {
        let (one, other) = section(span, hub, shroud, suction_side);
        suction.push(one);
        pressure.push(other);
    }
    (suction, pressure)
}

fn section(
    span: &CamberSpan,
    hub: &MeridionalCurve,
    shroud: &MeridionalCurve,
    suction_side: f64,
) -> (Vec<Point>, Vec<Point>) {
    let curve = |fraction: f64| -> Meridional {
        hub.point(hub.length() * fraction).lerp(shroud.point(shroud.length() * fraction), span.span)
    };
    let angle = profile(&span.angle);
    let thickness = profile(&span.thickness);
    // Integrates the camber line by the trapezoidal rule.
    let fine = 2000;
    let mut theta = vec![span.theta_leading_edge];
    let mut length = vec![0.0];
    let at = |x: f64| curve(span.leading_edge + (1.0 - span.leading_edge) * x);
    for i in 0..fine {
        let (x0, x1) = (i as f64 / fine as f64, (i + 1) as f64 / fine as f64);
        let (a, b) = (at(x0), at(x1));
        let dm = a.distance(b);
        let turn = 0.5 * (angle(x0).tan() / a.r + angle(x1).tan() / b.r) * dm;
        theta.push(theta[i] + turn);
        let path = dm * (1.0 + (0.5 * (angle(x0).tan() + angle(x1).tan())).powi(2)).sqrt();
        length.push(length[i] + path);
    }
    let camber = |x: f64, table: &[f64]| {
        let position = x.clamp(0.0, 1.0) * fine as f64;
        let i = (position as usize).min(fine - 1);
        table[i] + (table[i + 1] - table[i]) * (position - i as f64)
    };
    let total = length[fine];
    let nose = (thickness(0.0) / total).min(0.2);
    let mut one = Vec::with_capacity(POINTS);
    let mut other = Vec::with_capacity(POINTS);
    for i in 0..POINTS {
        // A quarter of the points along the nose, at equal angles of its ellipse; the rest along the blade.
        let nose_points = POINTS / 4;
        let x = if i <= nose_points {
            let turn = std::f64::consts::FRAC_PI_2 * i as f64 / nose_points as f64;
            nose * (1.0 - turn.cos())
        } else {
            let k = (i - nose_points) as f64 / (POINTS - 1 - nose_points) as f64;
            // Spacing grows smoothly from that of the nose.
            nose + (1.0 - nose) * k * (0.35 + 0.65 * k.sqrt())
        };
        let round = if x < nose { (1.0 - (1.0 - x / nose).powi(2)).max(0.0).sqrt() } else { 1.0 };
        let here = at(x);
        let half = 0.5 * thickness(x) * round / (angle(x).cos() * here.r);
        let middle = camber(x, &theta);
        one.push(here.at_angle(middle + suction_side * half));
        other.push(here.at_angle(middle - suction_side * half));
    }
    (one, other)
}

/// A smooth function through (x, y) pairs; one pair is a constant.
fn profile(pairs: &[(f64, f64)]) -> impl Fn(f64) -> f64 {
    let spline = (pairs.len() > 1).then(|| {
        let x: Vec<f64> = pairs.iter().map(|p| p.0).collect();
        let y: Vec<[f64; 1]> = pairs.iter().map(|p| [p.1]).collect();
        Cubic::interpolate(&x, &y)
    });
    let constant = pairs.first().map_or(0.0, |p| p.1);
    move |x| spline.as_ref().map_or(constant, |s| s.point(x)[0])
}
