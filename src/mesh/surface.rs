//! A mesh as a surface: coincident corners made one, neighbours across edges, connected pieces.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::TriangleMesh;
use crate::geometry::{Point, Vector};

/// Stands for no neighbour.
pub const NONE: u32 = u32::MAX;

/// Triangles over corners that are shared wherever they coincide; none without area.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Corners, mm.
    pub points: Vec<Point>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the triangles.
    pub normals: Vec<Vector>,
    /// Per triangle, what lies across the edge from corner k to corner k + 1 ([`NONE`]: a border, or an edge that
    /// more than two triangles share).
    pub neighbours: Vec<[u32; 3]>,
}

/// Mixes the bits of coordinates: quick, and good enough for a table of corners.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 ^= self.0 >> 32;
    }
}

type Table<K, V> = HashMap<K, V, BuildHasherDefault<Mixer>>;

/// For every corner of `points` the number of the first one at the same place, and the corners kept.
fn weld(points: &[Point]) -> (Vec<u32>, Vec<Point>) {
    let mut table: Table<(u64, u64, u64), u32> = Table::default();
    table.reserve(points.len() / 2);
    let mut kept = Vec::with_capacity(points.len() / 2);
    let to = points
        .iter()
        .map(|p| {
            // −0 and 0 are one place.
            let bits = |x: f64| (x + 0.0).to_bits();
            *table.entry((bits(p.x), bits(p.y), bits(p.z))).or_insert_with(|| {
                kept.push(*p);
                kept.len() as u32 - 1
            })
        })
        .collect();
    (to, kept)
}

impl Surface {
    /// The surface of a mesh.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let (to, points) = weld(&mesh.points);
        let mut triangles = Vec::with_capacity(mesh.triangles.len());
        let mut normals = Vec::with_capacity(mesh.triangles.len());
        for t in &mesh.triangles {
            let t = t.map(|i| to[i as usize]);
            let [a, b, c] = t.map(|i| points[i as usize]);
            let normal = (b - a).cross(&(c - a));
            let size = normal.norm();
            let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared());
            // A needle without area has no side to it.
            if size > 1e-9 * longest && size.is_finite() {
                triangles.push(t);
                normals.push(normal / size);
            }
        }
        let neighbours = neighbours(&triangles);
        Self { points, triangles, normals, neighbours }
    }

    /// Middle of a triangle.
    pub fn centre(&self, triangle: usize) -> Point {
        let [a, b, c] = self.triangles[triangle].map(|i| self.points[i as usize].coords);
        Point::from((a + b + c) / 3.0)
    }

    /// Area of a triangle, mm².
    pub fn area(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|i| self.points[i as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    }

    /// Numbers each triangle by the group it can be reached in across edges for which `joins` holds; returns the
    /// numbers and their count.
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

    /// The triangles for which `keep` holds, over the corners that they need.
    pub fn part(&self, keep: impl Fn(usize) -> bool) -> Self {
        let mesh = TriangleMesh {
            points: self.points.clone(),
            triangles: (0..self.triangles.len()).filter(|&t| keep(t)).map(|t| self.triangles[t]).collect(),
        };
        Self::of(&mesh.compact())
    }
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

/// The connected pieces of a mesh, each with the triangles in their order; pieces in the order of their first triangle.
pub fn pieces(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    let (to, points) = weld(&mesh.points);
    let mut parent: Vec<u32> = (0..points.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| root(&mut parent, to[i as usize]));
        parent[b as usize] = a;
        let c = root(&mut parent, c);
        parent[c as usize] = a;
    }
    let mut piece_of: Table<u64, usize> = Table::default();
    let mut lists: Vec<Vec<[u32; 3]>> = Vec::new();
    for t in &mesh.triangles {
        let t = t.map(|i| to[i as usize]);
        let root = root(&mut parent, t[0]);
        let piece = *piece_of.entry(u64::from(root)).or_insert_with(|| {
            lists.push(Vec::new());
            lists.len() - 1
        });
        lists[piece].push(t);
    }
    if lists.len() == 1 {
        return vec![TriangleMesh { points, triangles: lists.remove(0) }];
    }
    // One table serves all pieces: a corner belongs to one only.
    let mut renumbered = vec![NONE; points.len()];
    lists
        .into_iter()
        .map(|mut triangles| {
            let mut own = Vec::new();
            for i in triangles.iter_mut().flatten() {
                let new = &mut renumbered[*i as usize];
                if *new == NONE {
                    *new = own.len() as u32;
                    own.push(points[*i as usize]);
                }
                *i = *new;
            }
            TriangleMesh { points: own, triangles }
        })
        .collect()
}
