//! Blades that reach into hub or cover, as those of solids that were not united do: cut off where they enter.

use std::collections::HashMap;

use super::TriangleMesh;
use super::edge_curve::EdgeCurve;
use super::normals::ExactNormals;
use super::profile::FittedProfile;
use super::surface::MeshSurface;
use super::weld::NONE;
use crate::geometry::{Meridional, MeridionalCurve, Point, Vector};

/// Angles of the half planes that a body of revolution is cut with, rad: none is a likely angle of an edge.
const HALF_PLANES: [f64; 3] = [0.377, 2.531, 4.419];
/// Hub and cover end at one rim where their radii differ by this share at most.
const ONE_RIM: f64 = 0.02;

/// The outlines of a closed body of revolution in half planes through its axis.
pub struct BodyOutline {
    outlines: [Vec<[Meridional; 2]>; HALF_PLANES.len()],
}

impl BodyOutline {
    /// The outline of `body` about Z; `None` where it is not closed.
    pub fn from_body(body: &MeshSurface) -> Option<Self> {
        if body.triangles.is_empty() || body.border_edges().next().is_some() {
            return None;
        }
        Some(Self { outlines: HALF_PLANES.map(|angle| outline(body, angle)) })
    }

    /// Whether a point is within the body: parity of the outline above it, by majority of the half planes.
    pub fn contains(&self, p: Meridional) -> bool {
        let odd = |outline: &&Vec<[Meridional; 2]>| {
            let above = |[a, b]: &&[Meridional; 2]| {
                (a.r > p.r) != (b.r > p.r) && a.z + (b.z - a.z) * (p.r - a.r) / (b.r - a.r) > p.z
            };
            outline.iter().filter(above).count() % 2 == 1
        };
        2 * self.outlines.iter().filter(odd).count() > HALF_PLANES.len()
    }

    /// Whether the body is between two points: the line from one to the other crosses its outline, in most of
    /// the half planes.
    pub fn separates(&self, p: Meridional, q: Meridional) -> bool {
        let crosses = |[a, b]: &[Meridional; 2]| {
            (turn(p, q, *a) > 0.0) != (turn(p, q, *b) > 0.0)
                && (turn(*a, *b, p) > 0.0) != (turn(*a, *b, q) > 0.0)
        };
        let crossed = self.outlines.iter().filter(|outline| outline.iter().any(crosses));
        2 * crossed.count() > HALF_PLANES.len()
    }
}

/// Twice the area of the triangle of three points, positive where they turn left.
fn turn(a: Meridional, b: Meridional, c: Meridional) -> f64 {
    (b.r - a.r) * (c.z - a.z) - (b.z - a.z) * (c.r - a.r)
}

/// The section of a surface with the half plane at an angle about Z.
fn outline(body: &MeshSurface, angle: f64) -> Vec<[Meridional; 2]> {
    let (sin, cos) = angle.sin_cos();
    let aside = |p: &Point| p.y * cos - p.x * sin;
    let mut outline = Vec::new();
    for t in &body.triangles {
        let corners = t.map(|i| body.points[i as usize]);
        let mut ends = (0..3).filter_map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (s, e) = (aside(&a), aside(&b));
            let p = a + (b - a) * (s / (s - e));
            ((s >= 0.0) != (e >= 0.0)).then(|| Meridional { r: p.x * cos + p.y * sin, z: p.z })
        });
        if let (Some(a), Some(b)) = (ends.next(), ends.next())
            && a.r.max(b.r) > 0.0
        {
            outline.push([a, b]);
        }
    }
    outline
}

/// The greatest depth of corners of `blade` behind a curve with its outer side towards the blade, mm.
pub fn depth_behind(blade: &MeshSurface, curve: &MeridionalCurve) -> f64 {
    blade.points.iter().map(|p| -curve.project(Meridional::from_point(p)).1).fold(0.0, f64::max)
}

/// The straight line from the rim of a hub to that of a cover, and as much beyond both; `None` where they do
/// not end at nearly the same radius, as under a casing.
pub fn rim_line(hub: &FittedProfile, cover: &FittedProfile) -> Option<MeridionalCurve> {
    let (a, b) = (*hub.points.last()?, *cover.points.last()?);
    let is_rim = (a.r - b.r).abs() < ONE_RIM * a.r.max(b.r) && a.distance(b) > 1e-6 * a.r;
    is_rim.then(|| MeridionalCurve::through(&[-1.0, 0.0, 1.0, 2.0].map(|x| a.lerp(b, x))))
}

/// The part of `blade` on the outer side of a meridional curve, which goes on straight past its ends. Corners
/// within `tolerance` mm of the curve are on it.
pub fn trimmed(blade: &MeshSurface, curve: &MeridionalCurve, tolerance: f64) -> MeshSurface {
    trimmed_with_normals(blade, curve, tolerance, &ExactNormals::default()).0
}

/// As [`trimmed`], and the normals at the new corners on edges at both ends of which there are `exact` ones.
/// Triangles between straight lines are long and have corners at their ends only, so that a fit through
/// corners cannot find the normals between.
pub fn trimmed_with_normals(
    blade: &MeshSurface,
    curve: &MeridionalCurve,
    tolerance: f64,
    exact: &ExactNormals,
) -> (MeshSurface, Vec<(Point, Vector)>) {
    let height = |p: &Point| curve.project_past_ends(Meridional::from_point(p)).1;
    let on_curve = |h: f64| if h.abs() < tolerance { 0.0 } else { h };
    let heights: Vec<f64> = blade.points.iter().map(|p| on_curve(height(p))).collect();
    let mut mesh = TriangleMesh { points: blade.points.clone(), triangles: Vec::new() };
    let mut faces = Vec::new();
    let mut met: HashMap<(u32, u32), u32> = HashMap::new();
    let mut normals = Vec::new();
    for (index, (t, face)) in blade.triangles.iter().zip(&blade.faces).enumerate() {
        let flat = &blade.normals[index];
        let mut kept: Vec<u32> = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let over = [a, b].map(|i| heights[i as usize] >= 0.0);
            if over[0] {
                kept.push(a);
            }
            let ends_above = [a, b].iter().any(|i| heights[*i as usize] > 0.0);
            if over[0] != over[1] && ends_above {
                let (low, high) = (a.min(b), a.max(b));
                let ends = [low, high].map(|i| blade.points[i as usize]);
                let known = exact.near(&ends[0], flat).zip(exact.near(&ends[1], flat)).map(|(n, m)| [n, m]);
                let beside = blade.neighbours[index][k];
                let is_within = beside != NONE && blade.faces[beside as usize] == *face;
                let number = *met.entry((low, high)).or_insert_with(|| {
                    let at = [low, high].map(|i| heights[i as usize]);
                    let edge = match known.filter(|_| is_within) {
                        Some(normals) => EdgeCurve::from_normals(ends, &normals),
                        None => EdgeCurve::straight(ends),
                    };
                    mesh.points.push(edge.at(edge.zero_of(at, height)));
                    (mesh.points.len() - 1) as u32
                });
                if let Some([n, m]) = known {
                    let p = mesh.points[number as usize];
                    let share = (p - ends[0]).norm() / (ends[1] - ends[0]).norm();
                    normals.extend(n.lerp(&m, share).try_normalize(1e-12).map(|n| (p, n)));
                }
                kept.push(number);
            }
        }
        for k in 2..kept.len() {
            mesh.triangles.push([kept[0], kept[k - 1], kept[k]]);
            faces.push(*face);
        }
    }
    (MeshSurface::of_faces(&mesh.compact(), faces), normals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::grid_triangles;

    /// A closed ring of revolution: r from 2 to 5 mm, z from 0 to 1 mm.
    fn ring() -> MeshSurface {
        let outline = [(2.0, 0.0), (5.0, 0.0), (5.0, 1.0), (2.0, 1.0)];
        let mut points = Vec::new();
        for (r, z) in outline.into_iter().chain([outline[0]]) {
            points.extend((0..=60).map(|k| {
                let a = f64::from(k % 60) * std::f64::consts::TAU / 60.0;
                Point::new(r * a.cos(), r * a.sin(), z)
            }));
        }
        MeshSurface::from_mesh(&TriangleMesh { points, triangles: grid_triangles(5, 61, |_, _| true) })
    }

    #[test]
    fn points_within_a_closed_body_are_found() {
        let outline = BodyOutline::from_body(&ring()).expect("closed");
        for (r, z, within) in
            [(3.0, 0.5, true), (1.0, 0.5, false), (3.0, 1.5, false), (5.5, 0.5, false), (2.1, 0.1, true)]
        {
            assert_eq!(outline.contains(Meridional { r, z }), within, "{r} {z}");
        }
        let apart = |p: (f64, f64), q: (f64, f64)| {
            outline.separates(Meridional { r: p.0, z: p.1 }, Meridional { r: q.0, z: q.1 })
        };
        assert!(apart((3.0, -1.0), (3.0, 2.0)) && !apart((1.0, -1.0), (1.0, 2.0)));
        let open = ring().subset(|t| t > 0);
        assert!(BodyOutline::from_body(&open).is_none(), "it is open");
    }

    #[test]
    fn a_blade_is_cut_at_the_curve() {
        // A plate from z = -1 to 1 mm above a hub in the plane z = 0.
        let points =
            (0..5).flat_map(|i| [3.0, 6.0, 9.0].map(|x| Point::new(x, 0.0, -1.0 + 0.5 * f64::from(i) - 0.1)));
        let mesh = TriangleMesh { points: points.collect(), triangles: grid_triangles(5, 3, |_, _| true) };
        let hub = [2.0, 6.0, 10.0].map(|r| Meridional { r, z: 0.0 });
        let hub = MeridionalCurve::through(&hub).with_outer_side_towards(Meridional { r: 6.0, z: 5.0 });
        let plate = MeshSurface::from_mesh(&mesh);
        assert!((depth_behind(&plate, &hub) - 1.1).abs() < 1e-9);
        let cut = trimmed(&plate, &hub, 0.0);
        let area: f64 = (0..cut.triangles.len()).map(|t| cut.area(t)).sum();
        assert!((area - 6.0 * 0.9).abs() < 1e-9, "{area}");
        assert!(cut.points.iter().all(|p| p.z > -1e-12));
    }
}
