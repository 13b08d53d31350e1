//! A blank given as a closed triangle mesh.

use super::lattice::{Lattice, SolidError};
use super::rays::RayField;
use super::span::{Span, SpanEnd};
use crate::error::{ErrorCode, UserError};
use crate::geometry::{Point, Vector};
use crate::mesh::TriangleMesh;
use crate::mesh::weld;
use crate::part::BlankMesh;

/// Crossings of triangles and rays that fit the memory allowed.
const MAX_CROSSINGS: usize = 20_000_000;

/// Why a mesh does not bound a solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.explained())]
pub enum MeshFault {
    /// It has no triangles.
    Empty,
    /// It is open, or its triangles do not agree about the outside.
    Open {
        /// Number of edges without an opposite one.
        count: usize,
        /// The start of one of them, mm.
        x: f64,
        /// See `x`.
        y: f64,
        /// See `x`.
        z: f64,
    },
    /// It encloses no volume.
    Flat,
}

impl MeshFault {
    /// What is wrong and what to do.
    pub fn explained(&self) -> UserError {
        match self {
            Self::Empty => {
                UserError::new(ErrorCode::NoTriangles, "has no triangles", "export the blank again")
            }
            Self::Open { count, x, y, z } => UserError::new(
                ErrorCode::MeshNotClosed,
                format!(
                    "is not closed: {count} edges lack a neighbour, one of them at {x:.3}, {y:.3}, {z:.3}"
                ),
                "close the mesh and export it again",
            ),
            Self::Flat => {
                UserError::new(ErrorCode::MeshNotClosed, "encloses no volume", "export the blank again")
            }
        }
    }
}

/// A closed triangle mesh.
#[derive(Clone, Debug)]
pub struct MeshBlank {
    mesh: TriangleMesh,
    volume: f64,
}

/// Where a triangle crosses a ray.
struct Crossing {
    ray: u32,
    triangle: u32,
    at: f64,
    /// +1 where the ray enters the solid, else −1.
    enters: i32,
}

impl MeshBlank {
    /// The solid in `mesh`, which may repeat its points.
    ///
    /// # Errors
    /// When it is open or encloses nothing.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, MeshFault> {
        let (to, points) = weld::equal(&mesh.points);
        let mut triangles: Vec<[u32; 3]> = mesh
            .triangles
            .iter()
            .map(|t| t.map(|i| to[i as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        if triangles.is_empty() {
            return Err(MeshFault::Empty);
        }
        // Every directed edge needs as many opposite ones: sorted by their ends, +1 and −1 cancel.
        let mut edges: Vec<((u32, u32), i32)> = triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
            .map(|(a, b)| if a < b { ((a, b), 1) } else { ((b, a), -1) })
            .collect();
        edges.sort_unstable();
        let open = |same: &&[((u32, u32), i32)]| same.iter().map(|edge| edge.1).sum::<i32>() != 0;
        let mut open = edges.chunk_by(|a, b| a.0 == b.0).filter(open);
        if let Some(first) = open.next() {
            let p = points[first[0].0.0 as usize];
            return Err(MeshFault::Open { count: 1 + open.count(), x: p.x, y: p.y, z: p.z });
        }
        let at = |i: u32| points[i as usize].coords;
        let volume = triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c)))).sum::<f64>() / 6.0;
        if !(volume.is_finite() && volume.abs() > 0.0) {
            return Err(MeshFault::Flat);
        }
        if volume < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(Self { mesh: TriangleMesh { points, triangles }, volume: volume.abs() })
    }

    /// The solid in a mesh that was read before.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_mesh(mesh: &BlankMesh) -> Result<Self, MeshFault> {
        Self::new(&TriangleMesh { points: mesh.points.clone(), triangles: mesh.triangles.clone() })
    }

    /// Its triangles, with corners joined and normals outwards.
    pub fn into_mesh(self) -> BlankMesh {
        BlankMesh { points: self.mesh.points, triangles: self.mesh.triangles }
    }

    /// Volume, mm³.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Lower and upper corner of the box around it, mm.
    pub fn bounds(&self) -> (Point, Point) {
        let first = self.mesh.points.first().copied().unwrap_or_else(Point::origin);
        self.mesh.points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
    }

    /// The rays of `lattice` in it.
    ///
    /// # Errors
    /// When its triangles cross so many rays that they would take too much memory.
    pub fn rays(&self, lattice: &Lattice) -> Result<[RayField; 3], SolidError> {
        let [x, y, z] = [0, 1, 2].map(|direction| self.field(lattice, direction));
        Ok([x?, y?, z?])
    }

    fn field(&self, lattice: &Lattice, direction: usize) -> Result<RayField, SolidError> {
        let columns = lattice.counts[Lattice::across(direction).1];
        let mut found = Vec::new();
        for index in 0..self.mesh.triangles.len() {
            self.cross(lattice, direction, index as u32, &mut found);
            if found.len() > MAX_CROSSINGS {
                return Err(SolidError::Pieces(lattice.spacing));
            }
        }
        found.sort_by(|a, b| a.ray.cmp(&b.ray).then(a.at.total_cmp(&b.at)).then(b.enters.cmp(&a.enters)));
        Ok(RayField::filled(lattice, direction, |u, v, spans| {
            let ray = (u * columns + v) as u32;
            let from = found.partition_point(|c| c.ray < ray);
            let mut depth = 0;
            let mut start: Option<&Crossing> = None;
            for crossing in found[from..].iter().take_while(|c| c.ray == ray) {
                depth += crossing.enters;
                match start {
                    None if depth > 0 => start = Some(crossing),
                    Some(first) if depth <= 0 => {
                        if first.at < crossing.at {
                            spans.push(Span {
                                from: first.at,
                                to: crossing.at,
                                start: self.end(first.triangle),
                                end: self.end(crossing.triangle),
                            });
                        }
                        start = None;
                    }
                    _ => {}
                }
            }
        }))
    }

    fn corners(&self, triangle: u32) -> [Point; 3] {
        self.mesh.triangles[triangle as usize].map(|i| self.mesh.points[i as usize])
    }

    fn end(&self, triangle: u32) -> SpanEnd {
        let [a, b, c] = self.corners(triangle);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector::z);
        SpanEnd::new(&normal, SpanEnd::BLANK)
    }

    /// Adds the rays that cross a triangle. Each edge is evaluated from its point of lower index, so two
    /// triangles agree on which side of their common edge a ray is.
    fn cross(&self, lattice: &Lattice, direction: usize, triangle: u32, found: &mut Vec<Crossing>) {
        let (a, b) = Lattice::across(direction);
        let indices = self.mesh.triangles[triangle as usize];
        let corners = self.corners(triangle);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        if normal[direction] == 0.0 {
            return;
        }
        let range = |axis: usize| {
            let of =
                |fold: fn(f64, f64) -> f64, start: f64| corners.iter().map(|p| p[axis]).fold(start, fold);
            let node = |x: f64| (x - lattice.origin[axis]) / lattice.spacing;
            let first = node(of(f64::min, f64::INFINITY)).floor().max(0.0) as usize;
            let last = node(of(f64::max, f64::NEG_INFINITY)).ceil().max(0.0) as usize;
            first..(last + 1).min(lattice.counts[axis])
        };
        for u in range(a) {
            for v in range(b) {
                let (x, y) = (lattice.coordinate(a, u), lattice.coordinate(b, v));
                let left_of = |k: usize| {
                    let (i, j) = (k, (k + 1) % 3);
                    let reversed = indices[i] > indices[j];
                    let (p, q) = if reversed { (corners[j], corners[i]) } else { (corners[i], corners[j]) };
                    let side = (q[a] - p[a]) * (y - p[b]) - (q[b] - p[b]) * (x - p[a]);
                    (side >= 0.0) != reversed
                };
                let sides = [left_of(0), left_of(1), left_of(2)];
                if sides[0] != sides[1] || sides[1] != sides[2] {
                    continue;
                }
                let p = corners[0];
                let off = (x - p[a]) * normal[a] + (y - p[b]) * normal[b];
                let at = p[direction] - off / normal[direction];
                let enters = if normal[direction] < 0.0 { 1 } else { -1 };
                let ray = (u * lattice.counts[b] + v) as u32;
                found.push(Crossing { ray, triangle, at, enters });
            }
        }
    }
}
