//! Solids as smooth faces over shared points; normals are discontinuous only at the edges between faces.

use super::TriangleMesh;
use crate::geometry::{Point, Vector};

/// The part of an impeller that a face belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaceKind {
    /// Hub, from the nose ahead of the blades to the rim.
    Hub,
    /// Rim, back, bore and nose ring.
    Body,
    /// Shroud.
    Shroud,
    /// Suction side of a blade.
    Suction,
    /// Pressure side of a blade.
    Pressure,
    /// Tip of a blade, on the shroud.
    Tip,
    /// Foot of a blade, on the hub.
    Foot,
    /// Leading edge, where it is blunt.
    LeadingEdge,
    /// Trailing edge, where it is blunt.
    TrailingEdge,
}

/// A corner of a face: a point of the solid and the normal of this face there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceCorner {
    /// Index into [`Solid::points`].
    pub point: u32,
    /// Unit normal, pointing out of the material.
    pub normal: Vector,
}

/// A smooth piece of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidFace {
    /// The part of the impeller it belongs to.
    pub kind: FaceKind,
    /// Its corners; no point occurs twice.
    pub corners: Vec<FaceCorner>,
    /// Three indices into `corners` each, counter-clockwise seen from outside the material.
    pub triangles: Vec<[u32; 3]>,
}

/// Faces over shared points, mm, in the frame of the part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solid {
    /// The points.
    pub points: Vec<Point>,
    /// The faces.
    pub faces: Vec<SolidFace>,
}

impl Solid {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.faces.iter().map(|face| face.triangles.len()).sum()
    }

    /// All faces as one mesh over the shared points.
    pub fn mesh(&self) -> TriangleMesh {
        let whole = |face: &SolidFace, t: &[u32; 3]| t.map(|corner| face.corners[corner as usize].point);
        let triangles =
            self.faces.iter().flat_map(|face| face.triangles.iter().map(move |t| whole(face, t))).collect();
        TriangleMesh { points: self.points.clone(), triangles }
    }

    /// Six times the volume enclosed by the triangles, mm³ (divergence theorem); negative when they face
    /// inwards.
    pub fn volume_sixfold(&self) -> f64 {
        let mesh = self.mesh();
        let at = |i: u32| mesh.points[i as usize].coords;
        mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c)))).sum()
    }

    /// Reverses the orientation of every face: triangles and normals.
    pub fn reverse_orientation(&mut self) {
        for face in &mut self.faces {
            face.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            face.corners.iter_mut().for_each(|c| c.normal = -c.normal);
        }
    }

    /// Adds a face from a grid of point indices. Cells with coinciding corners become one triangle or none.
    /// `normal` gives the normal at a grid position; where it is zero, the area-weighted mean of the
    /// triangles around the corner is used. Normals are flipped to the side of the triangles.
    pub(super) fn add_grid(
        &mut self,
        kind: FaceKind,
        grid: &Grid,
        mut normal: impl FnMut(usize, usize) -> Vector,
    ) {
        let mut corner_of = vec![u32::MAX; self.points.len()];
        let mut corners: Vec<FaceCorner> = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..grid.rows {
            for j in 0..grid.columns {
                let point = grid.at(i, j);
                if corner_of[point as usize] == u32::MAX {
                    corner_of[point as usize] = corners.len() as u32;
                    corners.push(FaceCorner { point, normal: normal(i, j) });
                }
            }
        }
        for i in 1..grid.rows {
            for j in 1..grid.columns {
                let cell = [grid.at(i - 1, j - 1), grid.at(i - 1, j), grid.at(i, j - 1), grid.at(i, j)];
                for triangle in split(&self.points, cell) {
                    let [a, b, c] = triangle;
                    if a != b && b != c && c != a {
                        triangles.push(triangle.map(|p| corner_of[p as usize]));
                    }
                }
            }
        }
        if triangles.is_empty() {
            return;
        }
        let mut sums = vec![Vector::zeros(); corners.len()];
        for t in &triangles {
            let [a, b, c] = t.map(|k| self.points[corners[k as usize].point as usize]);
            let area = (b - a).cross(&(c - a));
            t.iter().for_each(|&k| sums[k as usize] += area);
        }
        for (corner, sum) in corners.iter_mut().zip(&sums) {
            if corner.normal.norm_squared() < 0.25 {
                corner.normal = *sum;
            }
            let outside = if corner.normal.dot(sum) < 0.0 { -corner.normal } else { corner.normal };
            corner.normal = outside.try_normalize(0.0).unwrap_or_else(Vector::z);
        }
        self.faces.push(SolidFace { kind, corners, triangles });
    }
}

/// Indices of points in rows and columns.
pub(super) struct Grid {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Row by row.
    pub points: Vec<u32>,
}

impl Grid {
    /// Index of the point in row `i`, column `j`.
    pub fn at(&self, i: usize, j: usize) -> u32 {
        self.points[i * self.columns + j]
    }
}

/// The two triangles of a cell (corners 00, 01, 10, 11) along its shorter diagonal.
pub(super) fn split(points: &[Point], [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    let at = |i: u32| &points[i as usize];
    if (at(a) - at(d)).norm_squared() < (at(b) - at(c)).norm_squared() {
        [[a, c, d], [a, d, b]]
    } else {
        [[a, c, b], [b, c, d]]
    }
}
