//! Triangle mesh with adjacency: welded corners, neighbours across edges, connected pieces.

use super::TriangleMesh;
use super::disjoint_sets::DisjointSets;
use super::weld::{self, NONE, NumberMap};
use crate::geometry::{Meridional, Point, Vector};

/// Two neighbouring triangles meet in an edge of the part, not in a smooth face, where the cosine between
/// their normals is below this.
pub const SHARP: f64 = 0.82;
/// Largest sum of the normals of a surface with cracks, weighted by area, as a share of the area, and largest
/// number of its border edges, as a share of that of its triangles.
const CRACKS: (f64, f64) = (1e-3, 0.05);
/// Largest number of parts of an edge between which it has places.
const MAX_PARTS: f64 = 100.0;

/// Triangles over welded corners, without degenerate triangles.
#[derive(Clone, Debug, Default)]
pub struct MeshSurface {
    /// Corners, mm.
    pub points: Vec<Point>,
    /// Three indices into `points` each.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the triangles.
    pub normals: Vec<Vector>,
    /// Per triangle, the neighbour across the edge from corner k to corner k + 1 ([`NONE`]: a border, or an
    /// edge of more than two triangles).
    pub neighbours: Vec<[u32; 3]>,
    /// Per triangle, the number of its face: connected triangles of the given mesh, before welding, form one.
    /// [`NONE`]: no face, as in a mesh of single triangles.
    pub faces: Vec<u32>,
}

impl MeshSurface {
    /// The surface of a mesh.
    pub fn from_mesh(mesh: &TriangleMesh) -> Self {
        Self::of_faces(mesh, faces_of(mesh))
    }

    /// As [`Self::from_mesh`], with given face numbers of the triangles.
    pub fn of_faces(mesh: &TriangleMesh, faces: Vec<u32>) -> Self {
        let (to, points) = weld::equal(&mesh.points);
        let renumbered = |triangles: &[[u32; 3]], to: &[u32]| {
            triangles.iter().map(|t| t.map(|i| to[i as usize])).collect()
        };
        let surface = Self::over(points, renumbered(&mesh.triangles, &to), faces);
        // Only corners at borders can have been separated by rounding.
        let mut loose = vec![false; surface.points.len()];
        surface.border_edges().for_each(|((a, b), _)| (loose[a as usize], loose[b as usize]) = (true, true));
        match weld::near(&surface.points, &surface.triangles, &loose) {
            Some((to, points)) => Self::over(points, renumbered(&surface.triangles, &to), surface.faces),
            None => surface,
        }
    }

    fn over(points: Vec<Point>, corners: Vec<[u32; 3]>, faces_of: Vec<u32>) -> Self {
        let mut triangles = Vec::with_capacity(corners.len());
        let mut normals = Vec::with_capacity(corners.len());
        let mut faces = Vec::with_capacity(corners.len());
        for (t, face) in corners.into_iter().zip(faces_of) {
            let [a, b, c] = t.map(|i| points[i as usize]);
            let normal = (b - a).cross(&(c - a));
            let size = normal.norm();
            let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared());
            // A degenerate triangle has no normal.
            if size > 1e-9 * longest && size.is_finite() {
                triangles.push(t);
                normals.push(normal / size);
                faces.push(face);
            }
        }
        let neighbours = neighbours(&triangles);
        Self { points, triangles, normals, neighbours, faces }
    }

    /// The edges without a neighbour: their corners, in the order of their triangle, and that triangle.
    pub fn border_edges(&self) -> impl Iterator<Item = ((u32, u32), usize)> + '_ {
        self.neighbours.iter().zip(&self.triangles).enumerate().flat_map(|(i, (neighbours, t))| {
            (0..3).filter(|&k| neighbours[k] == NONE).map(move |k| ((t[k], t[(k + 1) % 3]), i))
        })
    }

    /// Adds triangles over the same corners; they belong to no face.
    pub fn with_triangles(self, triangles: Vec<[u32; 3]>) -> Self {
        let mut faces = self.faces;
        faces.resize(self.triangles.len() + triangles.len(), NONE);
        Self::over(self.points, self.triangles.into_iter().chain(triangles).collect(), faces)
    }

    /// Applies a rigid transform to all corners.
    pub fn transformed(self, to: impl Fn(&Point) -> Point) -> Self {
        let turned = |n: &Vector| to(&Point::from(*n)) - to(&Point::origin());
        let normals = self.normals.iter().map(turned).collect();
        Self { points: self.points.iter().map(&to).collect(), normals, ..self }
    }

    /// Centroid of a triangle.
    pub fn centre(&self, triangle: usize) -> Point {
        let [a, b, c] = self.triangles[triangle].map(|i| self.points[i as usize].coords);
        Point::from((a + b + c) / 3.0)
    }

    /// Area of a triangle, mm².
    pub fn area(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|i| self.points[i as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    }

    /// Sum of the normals of triangles, weighted by area, mm².
    pub fn sum_of_normals(&self, triangles: &[u32]) -> Vector {
        triangles.iter().map(|&t| self.normals[t as usize] * self.area(t as usize)).sum()
    }

    /// Volume that a closed surface encloses, mm³ (divergence theorem): negative where its normals point into
    /// it; `None` where it is open.
    pub fn signed_volume(&self) -> Option<f64> {
        if self.border_edges().next().is_some() {
            return None;
        }
        Some(self.volume_about(&Point::origin()))
    }

    /// Signed volume between the surface and a point, mm³.
    fn volume_about(&self, point: &Point) -> f64 {
        let volume = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.points[i as usize] - point);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.triangles.iter().map(volume).sum()
    }

    /// +1 where the normals of a closed surface point out of what it encloses, −1 where they point into it;
    /// `None` where it is open. Cracks, between triangles of faces that do not share their corners, do not
    /// open it.
    pub fn outward(&self) -> Option<f64> {
        let (mut sum, mut area) = (Vector::zeros(), 0.0);
        for t in 0..self.triangles.len() {
            sum += self.normals[t] * self.area(t);
            area += self.area(t);
        }
        let open = self.border_edges().count() as f64;
        if area <= 0.0 || sum.norm() > CRACKS.0 * area || open > CRACKS.1 * self.triangles.len() as f64 {
            return None;
        }
        // About a point of its own: cracks then leave out little.
        Some(self.volume_about(&self.points[self.triangles[0][0] as usize]).signum())
    }

    /// Extent along the axes of its corners, mm.
    pub fn extent(&self) -> Vector {
        let (low, high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        let ends = |(low, high): (Vector, Vector), p: &Point| (low.inf(&p.coords), high.sup(&p.coords));
        let (low, high) = self.points.iter().fold((low, high), ends);
        high - low
    }

    /// Places of its corners in the meridional plane, and of points along longer edges, `spacing` apart, mm.
    pub fn places(&self, spacing: f64) -> Vec<Meridional> {
        let mut places: Vec<Meridional> = self.points.iter().map(Meridional::from_point).collect();
        for (t, neighbours) in self.triangles.iter().zip(&self.neighbours) {
            for k in 0..3 {
                let (i, j) = (t[k], t[(k + 1) % 3]);
                // An edge of two triangles belongs to the one that has its corners in rising order.
                if i > j && neighbours[k] != NONE {
                    continue;
                }
                let (a, b) = (self.points[i as usize], self.points[j as usize]);
                let parts = ((b - a).norm() / spacing).min(MAX_PARTS) as usize;
                places.extend((1..parts).map(|m| {
                    let p = a + (b - a) * (m as f64 / parts as f64);
                    Meridional::from_point(&p)
                }));
            }
        }
        places
    }

    /// Numbers the groups of triangles that are connected across edges for which `joins` holds (flood fill);
    /// returns the group of each triangle and the number of groups.
    pub fn groups(&self, joins: impl Fn(usize, usize) -> bool) -> (Vec<u32>, usize) {
        let mut group = vec![NONE; self.triangles.len()];
        let mut count = 0;
        let mut waiting = Vec::new();
        for start in 0..group.len() {
            if group[start] != NONE {
                continue;
            }
            group[start] = count as u32;
            waiting.push(start);
            while let Some(t) = waiting.pop() {
                for &n in &self.neighbours[t] {
                    if n != NONE && group[n as usize] == NONE && joins(t, n as usize) {
                        group[n as usize] = count as u32;
                        waiting.push(n as usize);
                    }
                }
            }
            count += 1;
        }
        (group, count)
    }

    /// The triangles for which `keep` holds, without unused corners.
    pub fn subset(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.triangles.len()).filter(|&t| keep(t)).collect();
        let triangles = kept.iter().map(|&t| self.triangles[t]).collect();
        let mesh = TriangleMesh { points: self.points.clone(), triangles }.compact();
        Self::over(mesh.points, mesh.triangles, kept.iter().map(|&t| self.faces[t]).collect())
    }

    /// The surface with its corners in the order in which its triangles use them, as those of pieces are.
    /// Sums over corners then are those of the piece to the last bit.
    pub fn in_order_of_use(self) -> Self {
        let mut to = vec![NONE; self.points.len()];
        let mut points = Vec::with_capacity(self.points.len());
        let mut renumbered = |i: u32| {
            let new = &mut to[i as usize];
            if *new == NONE {
                *new = points.len() as u32;
                points.push(self.points[i as usize]);
            }
            *new
        };
        let triangles = self.triangles.iter().map(|corners| corners.map(&mut renumbered)).collect();
        Self { points, triangles, ..self }
    }

    /// The connected pieces in the order of their first triangles; each keeps the order of its triangles.
    pub fn into_pieces(self) -> Vec<Self> {
        let piece = connected(&self.triangles, self.points.len());
        let mut piece_of: NumberMap<u64, usize> = NumberMap::default();
        let mut pieces: Vec<Self> = Vec::new();
        // Index of a triangle or corner within its piece; a corner belongs to one piece only.
        let mut triangle_to = Vec::with_capacity(self.triangles.len());
        let mut corner_to = vec![NONE; self.points.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let number = *piece_of.entry(u64::from(piece[t])).or_insert_with(|| {
                pieces.push(Self::default());
                pieces.len() - 1
            });
            let piece = &mut pieces[number];
            triangle_to.push(piece.triangles.len() as u32);
            piece.normals.push(self.normals[t]);
            piece.faces.push(self.faces[t]);
            piece.triangles.push(corners.map(|i| {
                let new = &mut corner_to[i as usize];
                if *new == NONE {
                    *new = piece.points.len() as u32;
                    piece.points.push(self.points[i as usize]);
                }
                *new
            }));
        }
        let own = |n: u32| if n == NONE { NONE } else { triangle_to[n as usize] };
        for (piece, neighbours) in piece.iter().zip(&self.neighbours) {
            pieces[piece_of[&u64::from(*piece)]].neighbours.push(neighbours.map(own));
        }
        pieces
    }
}

/// The numbers of the faces of the triangles of a mesh. Where most triangles share no corner with another
/// one, as in STL, they tell no faces.
fn faces_of(mesh: &TriangleMesh) -> Vec<u32> {
    let faces = connected(&mesh.triangles, mesh.points.len());
    let mut sizes = vec![0_u32; mesh.points.len()];
    faces.iter().for_each(|face| sizes[*face as usize] += 1);
    let alone = faces.iter().filter(|face| sizes[**face as usize] == 1).count();
    if 2 * alone > faces.len() { vec![NONE; faces.len()] } else { faces }
}

/// Labels the triangles by connected component over shared corners; `count` is the number of corners.
fn connected(triangles: &[[u32; 3]], count: usize) -> Vec<u32> {
    let mut sets = DisjointSets::new(count);
    for &[a, b, c] in triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    triangles.iter().map(|t| sets.root(t[0])).collect()
}

fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), 3 * i as u32 + k as u32));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    for pair in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [(.., a), (.., b)] = pair {
            neighbours[(a / 3) as usize][(a % 3) as usize] = b / 3;
            neighbours[(b / 3) as usize][(b % 3) as usize] = a / 3;
        }
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_triangles_tell_no_faces_and_those_with_common_corners_do() {
        let corner = |k: u32| Point::new(f64::from(k % 2), f64::from(k / 2), 0.0);
        let strip: Vec<[u32; 3]> = (0..8).map(|k| [k, k + 1, k + 2]).collect();
        let points: Vec<Point> = strip.iter().flatten().map(|k| corner(*k)).collect();
        let single = (0..8).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let soup = MeshSurface::from_mesh(&TriangleMesh { points, triangles: single });
        assert!(soup.faces.iter().all(|face| *face == NONE), "{:?}", soup.faces);
        let joined = TriangleMesh { points: (0..10).map(corner).collect(), triangles: strip };
        let joined = MeshSurface::from_mesh(&joined);
        assert!(joined.faces.iter().all(|face| *face == joined.faces[0] && *face != NONE));
    }
}
