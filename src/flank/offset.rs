//! Offsets of the hub, rounded where its radius of curvature is smaller than their height.
//!
//! Above a concave corner of radius ρ, as at the foot of a boss, an offset of more than ρ folds over itself.
//! The closing of mathematical morphology has no folds: the parallel at `height` + `radius`, without the
//! loops that are nearer to the hub, moved back by `radius`. It is the parallel at `height`, and above each
//! corner an arc of `radius` that joins its two branches.

use crate::geometry::{Meridional, MeridionalCurve, evenly};

/// Steps in which the curve is searched for folds.
const STEPS: usize = 1200;
/// Another part of the curve counts as nearer than a point's own foot by more than this share of the
/// distance.
const NEARER: f64 = 1e-7;
/// Least number of points of a parallel.
const MIN_POINTS: usize = 4;
/// Least distance between neighbouring points, as a share of a step.
const MIN_SPACING: f64 = 0.3;
/// Bisections of a step: to less than a nanometre.
const BISECTIONS: usize = 40;

/// Whether between two arc lengths (mm) the parallel of `curve` at `height` mm on its outer side is nearer
/// than that to another part of the curve.
pub fn folds_between(curve: &MeridionalCurve, height: f64, from: f64, to: f64) -> bool {
    evenly(from, to, STEPS + 1).into_iter().any(|t| !is_free(curve, height, t))
}

/// Whether no part of `curve` is nearer than `distance` (mm) to its parallel at arc length `t`.
fn is_free(curve: &MeridionalCurve, distance: f64, t: f64) -> bool {
    curve.project(curve.offset_derivative(t, distance).0).1 >= distance * (1.0 - NEARER)
}

/// The closed parallel of `curve` at `height` mm on its outer side, above its arc lengths `from` to `to`, mm,
/// with the same outer side. The curve goes on straight beyond its ends. `None` where hardly any of the
/// parallel at `height` + `radius` is left.
pub fn closed_parallel(
    curve: &MeridionalCurve,
    height: f64,
    radius: f64,
    from: f64,
    to: f64,
) -> Option<MeridionalCurve> {
    let reach = height + radius;
    let centre = |t: f64| curve.offset_derivative(t, reach).0;
    let is_free = |t: f64| is_free(curve, reach, t);
    // The last place on the side of `free` of the step from there to `folded`.
    let edge = |mut free: f64, mut folded: f64| {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (free + folded);
            *(if is_free(middle) { &mut free } else { &mut folded }) = middle;
        }
        free
    };
    let step = (to - from) / STEPS as f64;
    let mut points: Vec<Meridional> = Vec::with_capacity(STEPS + 1);
    // Points that nearly coincide, as next to a fold, would let a spline through them swing.
    let mut add = |p: Meridional| {
        if points.last().is_none_or(|last| last.distance(p) > MIN_SPACING * step) {
            points.push(p);
        }
    };
    let mut last_free: Option<f64> = None;
    for t in evenly(from, to, STEPS + 1) {
        if !is_free(t) {
            continue;
        }
        if let Some(last) = last_free.filter(|last| t - last > 1.5 * step) {
            let ends = [edge(last, last + step), edge(t, t - step)];
            let middle = centre(ends[0]).lerp(centre(ends[1]), 0.5);
            arc(middle, ends.map(|t| curve.at(t).normal), radius, step).for_each(&mut add);
        }
        add(curve.offset_derivative(t, height).0);
        last_free = Some(t);
    }
    (points.len() >= MIN_POINTS)
        .then(|| MeridionalCurve::through(&points).with_outer_side_towards(centre(last_free.unwrap_or(to))))
}

/// Points `step` mm apart on the shorter arc about `centre` between the directions against two `normals`.
fn arc(
    centre: Meridional,
    [a, b]: [Meridional; 2],
    radius: f64,
    step: f64,
) -> impl Iterator<Item = Meridional> {
    let angle = (a.r * b.z - a.z * b.r).atan2(a.r * b.r + a.z * b.z);
    let count = (angle.abs() * radius / step).ceil().max(1.0);
    (0..=count as usize).map(move |k| {
        let (sin, cos) = (angle * k as f64 / count).sin_cos();
        Meridional {
            r: centre.r - radius * (cos * a.r - sin * a.z),
            z: centre.z - radius * (sin * a.r + cos * a.z),
        }
    })
}
