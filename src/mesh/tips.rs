//! The shroud of an open wheel: the surface of revolution through the blade tips.

use super::profile::{Course, FittedProfile};
use super::surface::{MeshSurface, NONE};
use crate::geometry::{Meridional, MeridionalCurve};

/// An edge is sharp where the cosine between its triangles is below this.
const SHARP: f64 = 0.82;
/// Distance from the curve through the highest corners within which a corner is on the tip, mm per mm of
/// blade height.
const NEAR: f64 = 2e-3;
/// Multiples of [`NEAR`] that are tried where the tips are wavy.
const WIDER: [f64; 3] = [1.0, 2.0, 4.0];
/// Share of the blade's extent along the channel that the curve has to cover.
const COVERED: f64 = 0.45;
/// Largest slopes of a tip over the hub, mm per mm, that are tried: over a strongly curved hub a tip falls
/// steeply towards the outlet.
const SLOPES: [f64; 3] = [1.0, 3.0, 8.0];

/// The meridional curve through the tips of `blades` over `hub`; `None` where none can be fitted.
///
/// Corners off the curve are dropped; where that leaves too little of the tips, as on wavy ones, more are
/// kept.
pub fn fit_tip_curve(
    blades: &[MeshSurface],
    hub: &MeridionalCurve,
    course: &Course,
) -> Option<FittedProfile> {
    let mut best: Option<(f64, FittedProfile)> = None;
    for (wider, slope) in WIDER.into_iter().flat_map(|w| SLOPES.map(|s| (w, s))) {
        let Some((covered, profile)) = fit_within(blades, hub, course, NEAR * wider, slope) else { continue };
        if covered >= COVERED {
            return Some(profile);
        }
        if best.as_ref().is_none_or(|b| covered > b.0) {
            best = Some((covered, profile));
        }
    }
    best.map(|(_, profile)| profile)
}

/// As [`fit_tip_curve`], with corners within `near_share` mm per mm of height and slopes up to `max_slope`;
/// also the share of the blade's extent that the curve covers.
fn fit_within(
    blades: &[MeshSurface],
    hub: &MeridionalCurve,
    course: &Course,
    near_share: f64,
    max_slope: f64,
) -> Option<(f64, FittedProfile)> {
    let middle = mean_corner(blades);
    let hub = hub.clone().with_outer_side_towards(middle);
    let mut edges: Vec<Meridional> = blades.iter().flat_map(|b| edge_corners(b, true)).collect();
    if edges.len() < 8 {
        // The tips have no sharp edges because they are rounded: every corner is a candidate.
        edges = blades.iter().flat_map(|b| edge_corners(b, false)).collect();
    }
    let mut over: Vec<(f64, f64, Meridional)> = edges
        .iter()
        .map(|p| {
            let (t, d) = hub.project(*p);
            (t, d, *p)
        })
        .collect();
    over.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let height = over.iter().map(|(_, d, _)| *d).fold(0.0, f64::max);
    // Upper envelope with slopes up to `max_slope`: corners of leading and trailing edge are far below it.
    let mut least = vec![f64::NEG_INFINITY; over.len()];
    for forward in [true, false] {
        let (mut peak, mut at) = (f64::NEG_INFINITY, 0.0);
        for k in 0..over.len() {
            let i = if forward { k } else { over.len() - 1 - k };
            peak = (peak - max_slope * (over[i].0 - at).abs()).max(over[i].1);
            at = over[i].0;
            least[i] = least[i].max(peak);
        }
    }
    let mut tips: Vec<Meridional> = over
        .iter()
        .zip(&least)
        .filter(|((_, d, _), least)| *d > *least - near_share * height)
        .map(|(p, _)| p.2)
        .collect();
    let extent = |tips: &[Meridional]| {
        let along = tips.iter().map(|p| course.coordinates_of(*p).0);
        let ends = along.fold((f64::INFINITY, f64::NEG_INFINITY), |e, x| (e.0.min(x), e.1.max(x)));
        ends.1 - ends.0
    };
    let whole = extent(&edges);
    // Refits with a shrinking band and drops the corners outside, which are not on the tip.
    let mut near = 16.0 * near_share * height;
    for _ in 0..8 {
        let through = course.fit_curve(&tips)?;
        let curve = MeridionalCurve::through(&through.points).with_outer_side_towards(middle);
        let kept: Vec<Meridional> = tips.iter().filter(|p| curve.project(**p).1 < near).copied().collect();
        near = (0.5 * near).max(near_share * height);
        let settled = kept.len() == tips.len();
        if kept.len() < 8 {
            break;
        }
        tips = kept;
        if settled && near <= near_share * height {
            break;
        }
    }
    let curve = MeridionalCurve::through(&course.fit_curve(&tips)?.points).with_outer_side_towards(middle);
    let near: Vec<Meridional> =
        tips.iter().filter(|p| curve.project(**p).1.abs() < near_share * height).copied().collect();
    Some((extent(&near) / whole.max(1e-300), course.fit_curve(&near)?))
}

/// Mean of the blades' corners in the meridional plane.
pub fn mean_corner(blades: &[MeshSurface]) -> Meridional {
    let all = blades.iter().flat_map(|b| b.points.iter().map(Meridional::of));
    let (sum, count) = all
        .fold((Meridional::default(), 0.0), |(s, n), p| (Meridional { r: s.r + p.r, z: s.z + p.z }, n + 1.0));
    Meridional { r: sum.r / f64::max(count, 1.0), z: sum.z / f64::max(count, 1.0) }
}

/// Corners at sharp edges and borders if `sharp`, else all corners.
fn edge_corners(blade: &MeshSurface, sharp: bool) -> Vec<Meridional> {
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
