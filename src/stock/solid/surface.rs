//! The surface of a stock as closed triangles: extended marching cubes (Kobbelt, Botsch, Schwanecke, Seidel,
//! SIGGRAPH 2001) on the nodes of the lattice, with the ends of the spans as vertices.
//!
//! Vertices on the lines of the lattice are exact. In a cell whose normals differ a further vertex is put
//! where its tangent planes meet, so that edges stay sharp. On each face of a cell the surface depends on the
//! corners of this face alone, so neighbours agree, and every edge belongs to two triangles.

mod cells;
mod nodes;
mod slabs;

use std::collections::HashSet;

use nalgebra::{Matrix3, SymmetricEigen};
use rayon::prelude::*;

use super::SolidStock;
use super::lattice::Lattice;
use super::span::SpanEnd;
use crate::geometry::{Point, Vector};
use cells::{CELLS, EdgeRing};
use nodes::{EdgePlane, NodePlane};
use slabs::{FanSide, NumberedSlabs, SHARED, Slab, Vertices};

/// Planes of cells in one task.
const SLAB: usize = 16;
/// Distance of a vertex from the nodes of its edge, in spacings, so that vertices of different edges differ
/// in single precision, too.
const FROM_NODE: f64 = 2e-3;
/// Cosine of the angle between normals above which a cell has a sharp edge.
const SHARP_COSINE: f64 = 0.87;
/// Cosine of the angle between normals below which an edge is acute: where walls are curved, their tangent
/// planes meet far beyond it.
const ACUTE_COSINE: f64 = -0.5;
/// Eigenvalues below this share of the largest do not move a sharp vertex: there its planes are parallel.
const FLAT_SHARE: f64 = 0.05;
/// Distance of a sharp vertex from one of its planes, in spacings, above which they do not meet.
const PLANE_MISS: f64 = 0.05;
/// Distance of such a vertex from the nearest exact one, in spacings.
const NEAR_EXACT: f64 = 0.45;
/// Distance of a sharp vertex from the faces of its cell, in spacings.
const FROM_FACE: f64 = 0.02;

/// The surface of a stock; every edge has two triangles.
#[derive(Clone, Debug, Default)]
pub struct StockSurface {
    /// Vertices, mm.
    pub points: Vec<Point>,
    /// Unit normal out of the stock at each vertex; zero at vertices on sharp edges.
    pub normals: Vec<Vector>,
    /// Number of the move that cut each vertex, or [`SpanEnd::BLANK`].
    pub cut_by: Vec<u32>,
    /// Three indices of vertices each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl StockSurface {
    /// The surface of `stock`.
    pub fn from_stock(stock: &SolidStock) -> Self {
        let planes = stock.lattice.counts[0] - 1;
        let slabs: Vec<Slab> = (0..planes.div_ceil(SLAB))
            .into_par_iter()
            .map_init(
                || SlabMaker::new(stock),
                |maker, slab| {
                    maker.make(slab * SLAB, ((slab + 1) * SLAB).min(planes));
                    maker.take()
                },
            )
            .collect();
        let (Vertices { points, normals, cut_by }, triangles, sides) = NumberedSlabs::new(slabs).joined();
        let mut whole = Self { points, normals, cut_by, triangles };
        whole.flip_across_sharp_edges(sides);
        whole
    }

    /// Where two fans around sharp vertices meet, the common side is replaced by the edge between both sharp
    /// vertices, which is the sharp edge of the solid.
    fn flip_across_sharp_edges(&mut self, mut sides: Vec<FanSide>) {
        sides.par_sort_unstable();
        let mut joined: HashSet<(u32, u32)> = HashSet::new();
        for pair in sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 2) {
            // Fans list their centre first.
            let [c, a, b] = self.triangles[pair[0].1 as usize];
            let [d, ..] = self.triangles[pair[1].1 as usize];
            let flipped = [[c, a, d], [d, b, c]];
            let faces_out = flipped.iter().zip([a, b]).all(|(t, end)| {
                let [p, q, r] = t.map(|i| self.points[i as usize]);
                (q - p).cross(&(r - p)).dot(&self.normals[end as usize]) > 0.0
            });
            if c != d && faces_out && joined.insert((c.min(d), c.max(d))) {
                self.triangles[pair[0].1 as usize] = flipped[0];
                self.triangles[pair[1].1 as usize] = flipped[1];
            }
        }
    }

    /// Volume enclosed, mm³ (divergence theorem).
    pub fn volume(&self) -> f64 {
        let at = |i: u32| self.points[i as usize].coords;
        self.triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c)))).sum::<f64>() / 6.0
    }
}

struct SlabMaker<'a> {
    stock: &'a SolidStock,
    /// Nodes of the near and the far plane.
    nodes: [NodePlane; 2],
    slab: Slab,
    /// Edges along y and z in the near and the far plane of nodes, and along x between them.
    near: EdgePlane,
    far: EdgePlane,
    between: EdgePlane,
    /// Whether the vertices of the near plane are those of the slab before.
    shares: bool,
}

impl<'a> SlabMaker<'a> {
    fn new(stock: &'a SolidStock) -> Self {
        let [_, columns, count] = stock.lattice.counts;
        let plane = || EdgePlane::new(2 * columns * count);
        let between = EdgePlane::new(columns * count);
        let nodes = [NodePlane::new(stock), NodePlane::new(stock)];
        Self { stock, nodes, slab: Slab::default(), near: plane(), far: plane(), between, shares: false }
    }

    /// The slab that was made. The next one will be of about the same size.
    fn take(&mut self) -> Slab {
        let next = Slab {
            own: Vertices::with_capacity(self.slab.own.points.len()),
            triangles: Vec::with_capacity(self.slab.triangles.len()),
            ..Slab::default()
        };
        std::mem::replace(&mut self.slab, next)
    }

    fn make(&mut self, from: usize, to: usize) {
        let mut nodes = std::mem::take(&mut self.nodes);
        nodes[1].fill(self.stock, from);
        for i in from..to {
            nodes.swap(0, 1);
            nodes[1].fill(self.stock, i + 1);
            self.shares = i == from && i > 0;
            self.make_plane(i, &nodes);
            let listed = |plane: &EdgePlane| -> Vec<(u32, u32)> {
                plane.used.iter().map(|&edge| (edge, plane.of[edge as usize])).collect()
            };
            if i == from {
                self.slab.first = listed(&self.near);
            }
            if i + 1 == to {
                self.slab.last = listed(&self.far);
            }
            self.near.clear();
            self.between.clear();
            std::mem::swap(&mut self.near, &mut self.far);
        }
        self.near.clear();
        self.nodes = nodes;
    }

    /// Makes the cells between nodes i and i + 1 along x, which are those of both planes.
    fn make_plane(&mut self, i: usize, [near, far]: &[NodePlane; 2]) {
        let words = near.words;
        let [_, columns, count] = self.stock.lattice.counts;
        for j in 0..columns - 1 {
            // The lines of nodes along the edges of the cells, in the order of their corners.
            let lines = [near.line(j), far.line(j), near.line(j + 1), far.line(j + 1)];
            let mut next = lines.map(|line| line[0]);
            for word in 0..words {
                let low = next;
                next = if word + 1 < words { lines.map(|line| line[word + 1]) } else { [0; 4] };
                let [a, b, c, d] = low;
                let (any, all) = (a | b | c | d, a & b & c & d);
                // Mostly whole words are in stock or outside.
                if any == 0 && (next[0] | next[1] | next[2] | next[3]) & 1 == 0 {
                    continue;
                }
                if all == u64::MAX && next[0] & next[1] & next[2] & next[3] & 1 == 1 {
                    continue;
                }
                let high: [u64; 4] = std::array::from_fn(|line| low[line] >> 1 | next[line] << 63);
                let [e, f, g, h] = high;
                let mut active = (any | e | f | g | h) & !(all & e & f & g & h);
                while active != 0 {
                    let bit = active.trailing_zeros();
                    active &= active - 1;
                    let k = 64 * word + bit as usize;
                    if k + 1 < count {
                        let at = |word: u64, corner: usize| ((word >> bit & 1) as usize) << corner;
                        let case = at(a, 0) | at(b, 1) | at(c, 2) | at(d, 3);
                        self.make_cell([i, j, k], case | at(e, 4) | at(f, 5) | at(g, 6) | at(h, 7));
                    }
                }
            }
        }
    }

    /// Makes the triangles of a cell; bit i of `case` is set where corner i is in stock.
    fn make_cell(&mut self, cell: [usize; 3], case: usize) {
        for ring in CELLS[case].rings() {
            let mut vertices = [0u32; 12];
            for (vertex, &edge) in vertices.iter_mut().zip(ring.edges()) {
                *vertex = self.vertex(cell, edge, case);
            }
            self.close(cell, ring, &vertices[..ring.edges().len()]);
        }
    }

    /// The vertex on an edge of a cell.
    fn vertex(&mut self, cell: [usize; 3], edge: u8, case: usize) -> u32 {
        let (axis, start) = cells::EDGE_STARTS[usize::from(edge)];
        let node: [usize; 3] = std::array::from_fn(|k| cell[k] + (start >> k & 1));
        let [_, columns, count] = self.stock.lattice.counts;
        let place = node[1] * count + node[2];
        let (plane, place) = match (axis, start & 1) {
            (0, _) => (&mut self.between, place),
            (_, 0) => (&mut self.near, place + (axis - 1) * columns * count),
            (_, _) => (&mut self.far, place + (axis - 1) * columns * count),
        };
        let known = plane.of[place];
        if known != u32::MAX {
            return known;
        }
        let (point, end) = self.crossing(axis, node, case >> start & 1 == 1);
        let normal = end.map_or_else(Vector::zeros, |end| end.normal());
        let cut_by = end.map_or(SpanEnd::BLANK, |end| end.cut_by);
        let (plane, index) = match (axis, start & 1) {
            (0, _) => (&mut self.between, self.slab.own.push(point, normal, cut_by)),
            (_, 0) if self.shares => (&mut self.near, SHARED + self.slab.shared.push(point, normal, cut_by)),
            (_, 0) => (&mut self.near, self.slab.own.push(point, normal, cut_by)),
            (_, _) => (&mut self.far, self.slab.own.push(point, normal, cut_by)),
        };
        plane.of[place] = index;
        plane.used.push(place as u32);
        index
    }

    /// Where the surface crosses the edge from `node`, which is in stock or not, along `axis`.
    fn crossing(&self, axis: usize, node: [usize; 3], is_in: bool) -> (Point, Option<SpanEnd>) {
        let lattice = &self.stock.lattice;
        let (a, b) = Lattice::across(axis);
        let (low, high) = (lattice.coordinate(axis, node[axis]), lattice.coordinate(axis, node[axis] + 1));
        let spans = self.stock.spans(axis, node[a], node[b]);
        let between = |x: f64| (low..=high).contains(&x);
        let found = if is_in {
            spans.iter().find(|span| between(span.to)).map(|span| (span.to, span.end))
        } else {
            spans.iter().rev().find(|span| between(span.from)).map(|span| (span.from, span.start))
        };
        // A node on the surface can be in for one direction and out for another by rounding.
        let middle = 0.5 * (low + high);
        let nearest = || {
            spans
                .iter()
                .flat_map(|span| [(span.from, span.start), (span.to, span.end)])
                .min_by(|a, b| (a.0 - middle).abs().total_cmp(&(b.0 - middle).abs()))
        };
        let (t, end) = match found.or_else(nearest) {
            Some((t, end)) => (t, Some(end)),
            None => (middle, None),
        };
        let mut point = lattice.ray(axis, node[a], node[b]);
        let margin = FROM_NODE * lattice.spacing;
        point[axis] = t.clamp(low + margin, high - margin);
        (point, end)
    }

    /// The position and the normal of a vertex.
    #[inline]
    fn place(&self, vertex: u32) -> (Point, Vector) {
        let (vertices, k) = if vertex < SHARED {
            (&self.slab.own, vertex as usize)
        } else {
            (&self.slab.shared, (vertex - SHARED) as usize)
        };
        (vertices.points[k], vertices.normals[k])
    }

    /// Fills a ring of vertices with triangles.
    fn close(&mut self, cell: [usize; 3], ring: &EdgeRing, vertices: &[u32]) {
        let mut places = [(Point::origin(), Vector::zeros()); 12];
        let mut least = 1.0f64;
        for (i, &vertex) in vertices.iter().enumerate() {
            places[i] = self.place(vertex);
            for (_, normal) in &places[..i] {
                least = least.min(places[i].1.dot(normal));
            }
        }
        let sharp = least < SHARP_COSINE;
        if !sharp {
            match (vertices, ring.diagonal) {
                (&[a, b, c], _) => return self.slab.triangles.push([a, b, c]),
                (&[a, b, c, d], Some(0)) => return self.slab.triangles.extend([[a, b, c], [a, c, d]]),
                (&[a, b, c, d], Some(_)) => return self.slab.triangles.extend([[b, c, d], [b, d, a]]),
                _ => {}
            }
        }
        let (point, normal) = self.centre(cell, &places[..vertices.len()], (sharp, least < ACUTE_COSINE));
        let first = vertices[0];
        let cut_by = if first < SHARED {
            self.slab.own.cut_by[first as usize]
        } else {
            self.slab.shared.cut_by[(first - SHARED) as usize]
        };
        let centre = self.slab.own.push(point, normal, cut_by);
        for (i, &a) in vertices.iter().enumerate() {
            let b = vertices[(i + 1) % vertices.len()];
            if sharp {
                self.slab.sides.push(((a, b), self.slab.triangles.len() as u32));
            }
            self.slab.triangles.push([centre, a, b]);
        }
    }

    /// The point of a cell nearest to all tangent planes of a ring, starting from its mean (least squares by
    /// eigenvectors), and the mean normal; zero where it is sharp.
    fn centre(
        &self,
        cell: [usize; 3],
        ring: &[(Point, Vector)],
        (sharp, acute): (bool, bool),
    ) -> (Point, Vector) {
        let count = ring.len() as f64;
        let mean = Point::from(ring.iter().map(|(p, _)| p.coords).sum::<Vector>() / count);
        let normal: Vector = ring.iter().map(|(_, n)| n).sum();
        let mut matrix = Matrix3::zeros();
        let mut right = Vector::zeros();
        for (p, n) in ring {
            matrix += n * n.transpose();
            right += n * n.dot(&(p - mean));
        }
        let parts = SymmetricEigen::new(matrix);
        let largest = parts.eigenvalues.max();
        let mut point = mean;
        for (value, direction) in parts.eigenvalues.iter().zip(parts.eigenvectors.column_iter()) {
            if *value > FLAT_SHARE * largest && *value > 0.0 {
                point += direction * (direction.dot(&right) / value);
            }
        }
        let lattice = &self.stock.lattice;
        for k in 0..3 {
            let margin = FROM_FACE * lattice.spacing;
            let low = lattice.coordinate(k, cell[k]) + margin;
            point[k] = point[k].clamp(low, low + lattice.spacing - 2.0 * margin);
        }
        // Planes that do not meet in one point are not neighbours on the solid, and those of an acute edge
        // meet beyond it: then the vertex stays within half a spacing of one that is exact.
        let miss = ring.iter().map(|(p, n)| n.dot(&(point - p)).abs()).fold(0.0, f64::max);
        if acute || miss > PLANE_MISS * lattice.spacing {
            let exact = ring.iter().map(|(p, _)| *p);
            let nearest = exact.min_by(|a, b| (a - point).norm().total_cmp(&(b - point).norm()));
            let offset = nearest.map_or_else(Vector::zeros, |nearest| point - nearest);
            let far = offset.norm() / (NEAR_EXACT * lattice.spacing);
            if far > 1.0 {
                point -= offset * (1.0 - 1.0 / far);
            }
        }
        let normal =
            if sharp { Vector::zeros() } else { normal.try_normalize(1e-9).unwrap_or_else(Vector::zeros) };
        (point, normal)
    }
}
