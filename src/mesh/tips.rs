//! The shroud of an open wheel: the surface of revolution through the blade tips, which are known by their
//! sharp edges. See `tip_border` for tips that have none.

use super::profile::{Course, FittedProfile};
use super::surface::{MeshSurface, SHARP};
use super::weld::NONE;
use crate::geometry::{Meridional, MeridionalCurve};

/// Distance from the curve through the highest corners within which a corner is on the tip, mm per mm of
/// blade height.
const NEAR: f64 = 2e-3;

/// Length of sharp edges that are straight, as a share of the extent of a blade, and number of places on such
/// a length: the edges of a plate have corners at their ends only.
const STRAIGHT: f64 = 0.1;
const PLACES: usize = 5;

/// Largest slope of a tip over the hub, mm per mm.
const MAX_SLOPE: f64 = 1.0;

/// The meridional curve through the tips of `blades` over `hub`; `None` where none can be fitted.
pub fn fit_tip_curve(
    blades: &[MeshSurface],
    hub: &MeridionalCurve,
    course: &Course,
) -> Option<FittedProfile> {
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
    // Upper envelope with slopes up to STEEPEST: corners of leading and trailing edge are far below it.
    let mut least = vec![f64::NEG_INFINITY; over.len()];
    for forward in [true, false] {
        let (mut peak, mut at) = (f64::NEG_INFINITY, 0.0);
        for k in 0..over.len() {
            let i = if forward { k } else { over.len() - 1 - k };
            peak = (peak - MAX_SLOPE * (over[i].0 - at).abs()).max(over[i].1);
            at = over[i].0;
            least[i] = least[i].max(peak);
        }
    }
    let mut tips: Vec<Meridional> = over
        .iter()
        .zip(&least)
        .filter(|((_, d, _), least)| *d > *least - NEAR * height)
        .map(|(p, _)| p.2)
        .collect();
    // Refits with a shrinking band and drops the corners outside, which are not on the tip.
    let mut near = 16.0 * NEAR * height;
    for _ in 0..8 {
        let through = course.fit_curve(&tips)?;
        let curve = MeridionalCurve::through(&through.points).with_outer_side_towards(middle);
        let kept: Vec<Meridional> = tips.iter().filter(|p| curve.project(**p).1 < near).copied().collect();
        near = (0.5 * near).max(NEAR * height);
        let converged = kept.len() == tips.len();
        if kept.len() < 8 {
            break;
        }
        tips = kept;
        if converged && near <= NEAR * height {
            break;
        }
    }
    let curve = MeridionalCurve::through(&course.fit_curve(&tips)?.points).with_outer_side_towards(middle);
    let near: Vec<Meridional> =
        tips.iter().filter(|p| curve.project(**p).1.abs() < NEAR * height).copied().collect();
    course.fit_curve(&near)
}

/// Mean of the blades' corners in the meridional plane.
pub fn mean_corner(blades: &[MeshSurface]) -> Meridional {
    let all = blades.iter().flat_map(|b| b.points.iter().map(Meridional::from_point));
    let (sum, count) = all
        .fold((Meridional::default(), 0.0), |(s, n), p| (Meridional { r: s.r + p.r, z: s.z + p.z }, n + 1.0));
    Meridional { r: sum.r / f64::max(count, 1.0), z: sum.z / f64::max(count, 1.0) }
}

/// Corners at sharp edges and borders, and places along those that are long, if `sharp`, else all corners.
pub(super) fn edge_corners(blade: &MeshSurface, sharp: bool) -> Vec<Meridional> {
    let mut at_edge = vec![!sharp; blade.points.len()];
    let mut along: Vec<Meridional> = Vec::new();
    if sharp {
        let long = STRAIGHT * blade.extent().max();
        for (t, neighbours) in blade.neighbours.iter().enumerate() {
            for (k, n) in neighbours.iter().enumerate() {
                if *n != NONE && blade.normals[t].dot(&blade.normals[*n as usize]) >= SHARP {
                    continue;
                }
                let (i, j) = (blade.triangles[t][k], blade.triangles[t][(k + 1) % 3]);
                (at_edge[i as usize], at_edge[j as usize]) = (true, true);
                let (a, b) = (blade.points[i as usize], blade.points[j as usize]);
                let count = ((b - a).norm() / long) as usize * PLACES;
                let place = |m: usize| Meridional::from_point(&(a + (b - a) * (m as f64 / count as f64)));
                along.extend((1..count).map(place));
            }
        }
    }
    let corners = blade.points.iter().zip(&at_edge).filter(|(_, e)| **e);
    corners.map(|(p, _)| Meridional::from_point(p)).chain(along).collect()
}
