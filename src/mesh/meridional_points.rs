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
/// cubic Hermite interpolation. Without them the corners are all there is.
pub fn meridional_points(
    surface: &MeshSurface,
    triangles: &[usize],
    exact: &ExactNormals,
) -> Vec<Meridional> {
    let shortest = if exact.is_empty() { f64::INFINITY } else { 1.0 / PARTS };
    points_along(surface, triangles, shortest, |[a, b], t, chord| {
        let tangent = |i: u32| tangent_along(surface, (i, t), chord, exact);
        Some([tangent(a)?, tangent(b)?])
    })
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
    let mut used = vec![false; corners.len()];
    for &t in triangles {
        surface.triangles[t].iter().for_each(|i| used[*i as usize] = true);
    }
    let own = || corners.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p);
    let mut points: Vec<Meridional> = own().collect();
    if shortest.is_infinite() {
        return points;
    }
    let extent = |of: &dyn Fn(&Meridional) -> f64| {
        let (low, high) =
            own().map(|p| of(&p)).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
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
