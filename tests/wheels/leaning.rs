//! A wheel whose blades lean towards the pressure side: the wrap grows from hub to shroud.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

/// Wrap at hub and shroud, degrees.
const WRAP_DEG: [f64; 2] = [40.0, 68.0];
/// Points of a side of a section.
const POINTS: usize = 25;

fn between(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Radius and height at the share `span` from hub to shroud and the share `u` from inlet to outlet, mm.
/// Before the inlet both curves run along the axis.
fn meridional(span: f64, u: f64) -> [f64; 2] {
    let (sin, cos) = (u.max(0.0) * FRAC_PI_2).sin_cos();
    let r = between(between(15.0, 75.0, 1.0 - cos), between(41.25, 75.0, 1.0 - cos), span);
    let z = between(between(-52.5, 0.0, sin), between(-39.0, 0.0, sin) - 13.5, span);
    [r, z + 60.0 * u.min(0.0)]
}

/// A point of a side of the blade.
fn blade_point(span: f64, u: f64, side: f64) -> [f64; 3] {
    const STEP: f64 = 1e-4;
    let wrap = between(WRAP_DEG[0], WRAP_DEG[1], span).to_radians();
    let [[r, z], before, after] = [0.0, -STEP, STEP].map(|step| meridional(span, (u + step).max(0.0)));
    let along = (after[0] - before[0]).hypot(after[1] - before[1]) / (2.0 * STEP);
    // Half the thickness, round at the leading edge, as an angle across the camber line.
    let half = between(1.1, 0.6, span) * (1.0 - (1.0 - (12.0 * u).min(1.0)).powi(2)).sqrt() + 1e-3;
    let theta = wrap * u + side * half * 1f64.hypot(r * wrap / along) / r;
    [r * theta.cos(), r * theta.sin(), z]
}

/// The wheel as a native part file.
pub fn leaning_wheel() -> String {
    let share = |i: usize, count: usize| i as f64 / (count - 1) as f64;
    let mut text = "name = \"leaning\"\nblades = 12\n".to_owned();
    for (name, span) in [("hub", 0.0), ("shroud", 1.0)] {
        let points: Vec<_> = (0..23).map(|i| meridional(span, between(-0.1, 1.0, share(i, 23)))).collect();
        let _ = write!(text, "[{name}]\npoints = {points:?}\n");
    }
    for span in (0..5).map(|i| share(i, 5)) {
        let [suction, pressure] = [1.0, -1.0].map(|side| {
            let points = (0..POINTS).map(|i| blade_point(span, share(i, POINTS), side));
            points.collect::<Vec<_>>()
        });
        let _ = write!(text, "[[main.section]]\nsuction = {suction:?}\npressure = {pressure:?}\n");
    }
    text
}
