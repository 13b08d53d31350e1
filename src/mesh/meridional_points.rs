//! Points of surfaces of revolution in the meridional plane, dense enough to fit a curve through them.

use std::collections::HashSet;

use super::normals::ExactNormals;
use super::surface::MeshSurface;
use crate::geometry::{Meridional, Vector, norm2};

/// Number of parts into which the extent of the triangles is divided: edges that are longer get points
/// between their ends.
const PARTS: f64 = 320.0;
/// Smallest cosine between an edge and the meridional curve at its ends.
const ALONG: f64 = 0.9;
/// Length of edges that are straight, as a share of the extent.
const STRAIGHT: f64 = 0.1;
/// Ends of edges that are nearer than this share of the extent are the same: edges all around have the same.
const SAME: f64 = 1e-6;

/// The corners of `triangles`, which lie on surfaces of revolution about Z, and points between those of long
/// edges.
///
/// Faces that are straight in the meridional plane, as discs, cones and cylinders are, have corners at their
/// ends only, and rounded ones have few: no fit could tell how the curve runs between them, least of all
/// where its curvature jumps from one face to the next. An edge with exact normals at its ends tells it:
/// cubic Hermite interpolation. Without them the corners are all there is, but for wide gaps between their
/// distances `along` the channel, over which edges are straight.
pub fn meridional_points(
    surface: &MeshSurface,
    triangles: &[usize],
    exact: &ExactNormals,
    along: impl Fn(Meridional) -> f64,
) -> Vec<Meridional> {
    if exact.is_empty() {
        return points_over_gaps(surface, triangles, along);
    }
    points_along(surface, triangles, 1.0 / PARTS, |[a, b], t, chord| {
        let tangent = |i: u32| tangent_along(surface, (i, t), chord, exact);
        Some([tangent(a)?, tangent(b)?])
    })
}

/// The corners of `triangles`, and points along the chords of their longest edges where there are no corners
/// in between: no function through the corners tells how the curve runs over a gap.
fn points_over_gaps(
    surface: &MeshSurface,
    triangles: &[usize],
    along: impl Fn(Meridional) -> f64,
) -> Vec<Meridional> {
    let mut points = corners_of(surface, triangles);
    let mut places: Vec<f64> = points.iter().map(|p| along(*p)).collect();
    places.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return points };
    let widest = STRAIGHT * (last - first);
    let gaps: Vec<[f64; 2]> =
        places.windows(2).filter(|w| w[1] - w[0] > widest).map(|w| [w[0], w[1]]).collect();
    if !gaps.is_empty() {
        let more = straight_points(surface, triangles).into_iter().skip(points.len());
        let is_in_gap = |p: &Meridional| gaps.iter().any(|[from, to]| (*from..*to).contains(&along(*p)));
        points.extend(more.filter(is_in_gap));
    }
    points
}

/// The corners of `triangles`.
pub fn corners_of(surface: &MeshSurface, triangles: &[usize]) -> Vec<Meridional> {
    let mut used = vec![false; surface.points.len()];
    for &t in triangles {
        surface.triangles[t].iter().for_each(|i| used[*i as usize] = true);
    }
    let own = surface.points.iter().zip(&used).filter(|(_, used)| **used);
    own.map(|(p, _)| Meridional::from_point(p)).collect()
}

/// As [`meridional_points`], of a mesh without exact normals: points are along the chords of its longest
/// edges, as such an edge would be far from the surface if it were not straight there.
pub fn straight_points(surface: &MeshSurface, triangles: &[usize]) -> Vec<Meridional> {
    points_along(surface, triangles, STRAIGHT, |_, _, chord| {
        let length = norm2(chord.r, chord.z);
        Some([Meridional { r: chord.r / length, z: chord.z / length }; 2])
    })
}

/// The corners of `triangles`, and points along their edges that are longer than the share `shortest` of the
/// extent, by the unit tangents at both ends of an edge, given its corners, its triangle, and its chord.
fn points_along(
    surface: &MeshSurface,
    triangles: &[usize],
    shortest: f64,
    tangents: impl Fn([u32; 2], usize, Meridional) -> Option<[Meridional; 2]>,
) -> Vec<Meridional> {
    let corners: Vec<Meridional> = surface.points.iter().map(Meridional::from_point).collect();
    let mut points = corners_of(surface, triangles);
    let extent = |of: &dyn Fn(&Meridional) -> f64| {
        let ends = |(a, b): (f64, f64), x: f64| (a.min(x), b.max(x));
        let (low, high) = points.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        high - low
    };
    let size = norm2(extent(&|p| p.r), extent(&|p| p.z));
    let spacing = size / PARTS;
    let rounded = |p: Meridional| [p.r, p.z].map(|x| (x / (SAME * size)).round() as i64);
    let mut seen = HashSet::new();
    for &t in triangles {
        let corner = surface.triangles[t];
        for k in 0..3 {
            let (i, j) = (corner[k], corner[(k + 1) % 3]);
            let (a, b) = if i < j { (i, j) } else { (j, i) };
            let (p, q) = (corners[a as usize], corners[b as usize]);
            let chord = Meridional { r: q.r - p.r, z: q.z - p.z };
            let length = norm2(chord.r, chord.z);
            if length <= shortest * size || !seen.insert((rounded(p), rounded(q))) {
                continue;
            }
            if let Some([from, to]) = tangents([a, b], t, chord) {
                let count = (length / spacing) as usize;
                points.extend((1..=count).map(|k| {
                    let x = k as f64 / (count + 1) as f64;
                    hermite((p, from), (q, to), length, x)
                }));
            }
        }
    }
    points
}

/// Unit tangent of the meridional curve at corner `i` of triangle `t`, in the direction of `chord`.
fn tangent_along(
    surface: &MeshSurface,
    (i, t): (u32, usize),
    chord: Meridional,
    exact: &ExactNormals,
) -> Option<Meridional> {
    let p = surface.points[i as usize];
    let n: Vector = exact.near(&p, &surface.normals[t])?;
    let r = norm2(p.x, p.y);
    // On the axis the meridional plane is that of the triangle.
    let c = if r > 1e-9 { p } else { surface.centre(t) };
    let radial = (n.x * c.x + n.y * c.y) / norm2(c.x, c.y).max(1e-12);
    let (tangent, size) = (Meridional { r: -n.z, z: radial }, norm2(n.z, radial));
    let along = (tangent.r * chord.r + tangent.z * chord.z) / (size * norm2(chord.r, chord.z));
    let sign = 1.0_f64.copysign(along) / size;
    (along.abs() > ALONG).then_some(Meridional { r: tangent.r * sign, z: tangent.z * sign })
}

/// Cubic Hermite interpolation between two points with unit tangents, `length` apart, at the share `x`.
fn hermite(
    (p, from): (Meridional, Meridional),
    (q, to): (Meridional, Meridional),
    length: f64,
    x: f64,
) -> Meridional {
    let (y, at_p, at_q) = (1.0 - x, x * (1.0 - x) * (1.0 - x), x * x * (1.0 - x));
    let (of_p, of_q) = (y * y * (1.0 + 2.0 * x), x * x * (3.0 - 2.0 * x));
    let blend = |p: f64, from: f64, q: f64, to: f64| of_p * p + of_q * q + length * (at_p * from - at_q * to);
    Meridional { r: blend(p.r, from.r, q.r, to.r), z: blend(p.z, from.z, q.z, to.z) }
}
