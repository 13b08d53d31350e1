//! The shroud of a wheel without one: the surface that the tips of the blades run along.

use super::profile::{Course, Profile};
use super::surface::{NONE, Surface};
use crate::geometry::{Meridional, MeridionalCurve};

/// Stretches of the hub, in each of which the highest corner is a tip.
const STRETCHES: usize = 24;
/// Turn across an edge, as cosine, from which on it counts as sharp.
const SHARP: f64 = 0.82;
/// Distance from the curve through the highest corners within which a corner is of the tip, mm per mm of blade height.
const NEAR: f64 = 2e-3;

/// Share of the height of the tips from which on a corner may be one.
const HIGH: f64 = 0.95;

/// The curve through the tips of `blades` over `hub`.
pub fn tip_curve(blades: &[Surface], hub: &MeridionalCurve, course: &Course) -> Option<Profile> {
    let middle = middle(blades);
    let hub = hub.clone().facing(middle);
    let mut edges: Vec<Meridional> = blades.iter().flat_map(|b| edge_corners(b, true)).collect();
    if edges.len() < 8 {
        // No sharp edge at the tip: rounded over. Every corner may be one.
        edges = blades.iter().flat_map(|b| edge_corners(b, false)).collect();
    }
    let over: Vec<(f64, f64)> = edges.iter().map(|p| hub.project(*p)).collect();
    let ends = over.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, (t, _)| (e.0.min(*t), e.1.max(*t)));
    let height = over.iter().map(|(_, d)| *d).fold(0.0, f64::max);
    let mut highest: Vec<Option<usize>> = vec![None; STRETCHES];
    for (i, (t, d)) in over.iter().enumerate() {
        let stretch = ((t - ends.0) / (ends.1 - ends.0).max(1e-9) * STRETCHES as f64) as usize;
        let best = &mut highest[stretch.min(STRETCHES - 1)];
        if best.is_none_or(|b| *d > over[b].1) {
            *best = Some(i);
        }
    }
    let peaks: Vec<(f64, f64)> = highest.into_iter().flatten().map(|i| over[i]).collect();
    let level = |t: f64| {
        let i = peaks.partition_point(|p| p.0 < t).clamp(1, peaks.len().max(2) - 1);
        let (a, b) = (*peaks.get(i - 1)?, *peaks.get(i)?);
        Some(a.1 + (b.1 - a.1) * ((t - a.0) / (b.0 - a.0).max(1e-9)).clamp(0.0, 1.0))
    };
    let mut tips: Vec<Meridional> = edges
        .iter()
        .zip(&over)
        .filter(|(_, (t, d))| level(*t).is_some_and(|level| *d > HIGH * level))
        .map(|(p, _)| *p)
        .collect();
    // What lies under the curve is of the blade's ends, not of its tip, and is dropped.
    let mut near = 16.0 * NEAR * height;
    for _ in 0..8 {
        let through = course.curve(&tips)?;
        let curve = MeridionalCurve::through(&through.points).facing(middle);
        let kept: Vec<Meridional> = tips.iter().filter(|p| curve.project(**p).1 < near).copied().collect();
        near = (0.5 * near).max(NEAR * height);
        let settled = kept.len() == tips.len();
        if kept.len() < 8 {
            break;
        }
        tips = kept;
        if settled && near <= NEAR * height {
            break;
        }
    }
    let curve = MeridionalCurve::through(&course.curve(&tips)?.points).facing(middle);
    let near: Vec<Meridional> =
        edges.iter().filter(|p| curve.project(**p).1.abs() < NEAR * height).copied().collect();
    course.curve(&near)
}

/// Middle of the blades in the meridional plane.
pub fn middle(blades: &[Surface]) -> Meridional {
    let all = blades.iter().flat_map(|b| b.points.iter().map(Meridional::of));
    let (sum, count) = all
        .fold((Meridional::default(), 0.0), |(s, n), p| (Meridional { r: s.r + p.r, z: s.z + p.z }, n + 1.0));
    Meridional { r: sum.r / f64::max(count, 1.0), z: sum.z / f64::max(count, 1.0) }
}

/// Corners at sharp edges and borders, or all of them.
fn edge_corners(blade: &Surface, sharp: bool) -> Vec<Meridional> {
    let mut at_edge = vec![!sharp; blade.points.len()];
    if sharp {
        for (t, neighbours) in blade.neighbours.iter().enumerate() {
            for (k, n) in neighbours.iter().enumerate() {
                if *n == NONE || blade.normals[t].dot(&blade.normals[*n as usize]) < SHARP {
                    at_edge[blade.triangles[t][k] as usize] = true;
                    at_edge[blade.triangles[t][(k + 1) % 3] as usize] = true;
                }
            }
        }
    }
    blade.points.iter().zip(&at_edge).filter(|(_, e)| **e).map(|(p, _)| Meridional::of(p)).collect()
}
