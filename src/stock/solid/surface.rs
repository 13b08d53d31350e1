//! The surface of a stock as closed triangles: extended marching cubes (Kobbelt, Botsch, Schwanecke, Seidel,
//! SIGGRAPH 2001) on the nodes of the lattice, with the ends of the spans as vertices.
//!
//! Vertices on the lines of the lattice are exact. In a cell whose normals differ a further vertex is put
//! where its tangent planes meet, so that edges stay sharp. On each face of a cell the surface depends on the
//! corners of this face alone, so neighbours agree, and every edge belongs to two triangles.

mod cells;
mod nodes;

use std::collections::HashSet;

use rayon::prelude::*;

use super::SolidStock;
use super::lattice::Lattice;
use super::span::SpanEnd;
use crate::geometry::{Point, Vector};
use cells::{CELLS, Loop, share_a_face};
use nodes::{EdgePlane, Nodes};

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

/// A side of a fan around a sharp vertex: its ends, and its triangle.
type FanSide = ((u32, u32), u32);

/// Triangles of some planes of cells.
#[derive(Default)]
struct Slab {
    surface: StockSurface,
    /// Vertices in the first and the last plane of nodes, by the number of their edge.
    first: Vec<(u32, u32)>,
    last: Vec<(u32, u32)>,
    sides: Vec<FanSide>,
}

impl StockSurface {
    /// The surface of `stock`.
    pub fn of(stock: &SolidStock) -> Self {
        let nodes = Nodes::of(stock);
        let planes = stock.lattice.counts[0] - 1;
        let slabs: Vec<Slab> = (0..planes.div_ceil(SLAB))
            .into_par_iter()
            .map(|slab| {
                let mut maker = SlabMaker::new(stock, &nodes);
                maker.make(slab * SLAB, ((slab + 1) * SLAB).min(planes));
                maker.slab
            })
            .collect();
        Self::joined(slabs)
    }

    /// Joins slabs at their common planes.
    fn joined(slabs: Vec<Slab>) -> Self {
        let mut whole = Self::default();
        let mut sides: Vec<FanSide> = Vec::new();
        let mut border: Vec<(u32, u32)> = Vec::new();
        for mut slab in slabs {
            slab.first.sort_unstable();
            slab.last.sort_unstable();
            let mut to = vec![u32::MAX; slab.surface.points.len()];
            for (key, own) in &slab.first {
                if let Ok(at) = border.binary_search_by_key(key, |(key, _)| *key) {
                    to[*own as usize] = border[at].1;
                }
            }
            for (own, point) in slab.surface.points.iter().enumerate() {
                if to[own] == u32::MAX {
                    to[own] = whole.points.len() as u32;
                    whole.points.push(*point);
                    whole.normals.push(slab.surface.normals[own]);
                    whole.cut_by.push(slab.surface.cut_by[own]);
                }
            }
            let before = whole.triangles.len() as u32;
            let new = |i: u32| to[i as usize];
            whole.triangles.extend(slab.surface.triangles.iter().map(|t| t.map(new)));
            sides.extend(slab.sides.iter().map(|&((a, b), t)| {
                let (a, b) = (new(a), new(b));
                ((a.min(b), a.max(b)), t + before)
            }));
            border = slab.last.iter().map(|&(key, own)| (key, new(own))).collect();
        }
        whole.flip_across_sharp_edges(sides);
        whole
    }

    /// Where two fans around sharp vertices meet, the common side is replaced by the edge between both sharp
    /// vertices, which is the sharp edge of the solid.
    fn flip_across_sharp_edges(&mut self, mut sides: Vec<FanSide>) {
        sides.sort_unstable();
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
    nodes: &'a Nodes,
    slab: Slab,
    /// Edges along y and z in the near and the far plane of nodes, and along x between them.
    near: EdgePlane,
    far: EdgePlane,
    between: EdgePlane,
}

impl<'a> SlabMaker<'a> {
    fn new(stock: &'a SolidStock, nodes: &'a Nodes) -> Self {
        let [_, columns, count] = stock.lattice.counts;
        let plane = || EdgePlane::new(2 * columns * count);
        let between = EdgePlane::new(columns * count);
        Self { stock, nodes, slab: Slab::default(), near: plane(), far: plane(), between }
    }

    fn make(&mut self, from: usize, to: usize) {
        for i in from..to {
            self.make_plane(i);
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
    }

    /// Makes the cells between nodes i and i + 1 along x.
    fn make_plane(&mut self, i: usize) {
        let [_, columns, count] = self.stock.lattice.counts;
        for j in 0..columns - 1 {
            for word in 0..self.nodes.words {
                let lines =
                    [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| self.nodes.line(i, j));
                let any = |w: usize| lines.iter().fold(0, |bits, line| bits | line[w]);
                let all = |w: usize| lines.iter().fold(u64::MAX, |bits, line| bits & line[w]);
                let next = |of: &dyn Fn(usize) -> u64| {
                    let carried = if word + 1 < self.nodes.words { of(word + 1) << 63 } else { 0 };
                    (of(word) >> 1) | carried
                };
                let mut active = (any(word) | next(&any)) & !(all(word) & next(&all));
                while active != 0 {
                    let k = 64 * word + active.trailing_zeros() as usize;
                    active &= active - 1;
                    if k + 1 < count {
                        self.make_cell([i, j, k]);
                    }
                }
            }
        }
    }

    fn make_cell(&mut self, cell: [usize; 3]) {
        let corner = |bit: usize| std::array::from_fn(|axis| cell[axis] + (bit >> axis & 1));
        let case = (0..8).fold(0, |case, bit| case | usize::from(self.nodes.is_in(corner(bit))) << bit);
        for edges in &CELLS[case] {
            let mut ring = [0u32; 12];
            for (vertex, &edge) in ring.iter_mut().zip(edges) {
                *vertex = self.vertex(cell, edge);
            }
            self.close(cell, edges, &ring[..edges.len()]);
        }
    }

    /// The vertex on an edge of a cell.
    fn vertex(&mut self, cell: [usize; 3], edge: u8) -> u32 {
        let (axis, start) = cells::edge_start(edge);
        let node: [usize; 3] = std::array::from_fn(|k| cell[k] + (start >> k & 1));
        let [_, columns, count] = self.stock.lattice.counts;
        let place = node[1] * count + node[2];
        let (plane, place) = match (axis, node[0] == cell[0]) {
            (0, _) => (&mut self.between, place),
            (_, true) => (&mut self.near, place + (axis - 1) * columns * count),
            (_, false) => (&mut self.far, place + (axis - 1) * columns * count),
        };
        if plane.of[place] != u32::MAX {
            return plane.of[place];
        }
        let index = self.slab.surface.points.len() as u32;
        plane.of[place] = index;
        plane.used.push(place as u32);
        let (point, end) = self.crossing(axis, node);
        self.slab.surface.points.push(point);
        self.slab.surface.normals.push(end.map_or_else(Vector::zeros, |end| end.normal()));
        self.slab.surface.cut_by.push(end.map_or(SpanEnd::BLANK, |end| end.cut_by));
        index
    }

    /// Where the surface crosses the edge from `node` along `axis`.
    fn crossing(&self, axis: usize, node: [usize; 3]) -> (Point, Option<SpanEnd>) {
        let lattice = &self.stock.lattice;
        let (a, b) = Lattice::across(axis);
        let (low, high) = (lattice.coordinate(axis, node[axis]), lattice.coordinate(axis, node[axis] + 1));
        let spans = self.stock.spans(axis, node[a], node[b]);
        let between = |x: f64| (low..=high).contains(&x);
        let found = if self.nodes.is_in(node) {
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

    /// Fills a ring of vertices with triangles.
    fn close(&mut self, cell: [usize; 3], edges: &Loop, ring: &[u32]) {
        let surface = &mut self.slab.surface;
        let normal = |i: &u32| surface.normals[*i as usize];
        let pairs = ring.iter().enumerate().flat_map(|(i, a)| ring[..i].iter().map(move |b| (a, b)));
        let least = pairs.map(|(a, b)| normal(a).dot(&normal(b))).fold(1.0, f64::min);
        let sharp = least < SHARP_COSINE;
        if !sharp && ring.len() == 3 {
            surface.triangles.push([ring[0], ring[1], ring[2]]);
            return;
        }
        if !sharp && ring.len() == 4 {
            // A diagonal within a face of the cell could be that of its neighbour, too.
            for turn in 0..2 {
                if !share_a_face(edges[turn], edges[turn + 2]) {
                    let [a, b, c, d] = [0, 1, 2, 3].map(|k| ring[(turn + k) % 4]);
                    surface.triangles.extend([[a, b, c], [a, c, d]]);
                    return;
                }
            }
        }
        let (point, normal) = self.centre(cell, ring, (sharp, least < ACUTE_COSINE));
        let surface = &mut self.slab.surface;
        let centre = surface.points.len() as u32;
        surface.points.push(point);
        surface.normals.push(normal);
        surface.cut_by.push(surface.cut_by[ring[0] as usize]);
        for (i, &a) in ring.iter().enumerate() {
            let b = ring[(i + 1) % ring.len()];
            if sharp {
                self.slab.sides.push(((a, b), surface.triangles.len() as u32));
            }
            surface.triangles.push([centre, a, b]);
        }
    }

    /// The point of a cell nearest to all tangent planes of a ring, starting from its mean (least squares by
    /// eigenvectors), and the mean normal; zero where it is sharp.
    fn centre(&self, cell: [usize; 3], ring: &[u32], (sharp, acute): (bool, bool)) -> (Point, Vector) {
        let surface = &self.slab.surface;
        let at = |i: &u32| (surface.points[*i as usize], surface.normals[*i as usize]);
        let count = ring.len() as f64;
        let mean = Point::from(ring.iter().map(|i| at(i).0.coords).sum::<Vector>() / count);
        let normal: Vector = ring.iter().map(|i| at(i).1).sum();
        let mut matrix = nalgebra::Matrix3::zeros();
        let mut right = Vector::zeros();
        for (p, n) in ring.iter().map(at) {
            matrix += n * n.transpose();
            right += n * n.dot(&(p - mean));
        }
        let parts = matrix.symmetric_eigen();
        let largest = parts.eigenvalues.max();
        let mut point = mean;
        for k in 0..3 {
            let (value, direction) = (parts.eigenvalues[k], parts.eigenvectors.column(k));
            if value > FLAT_SHARE * largest && value > 0.0 {
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
        let miss = ring.iter().map(at).map(|(p, n)| n.dot(&(point - p)).abs()).fold(0.0, f64::max);
        if acute || miss > PLANE_MISS * lattice.spacing {
            let exact = ring.iter().map(|i| at(i).0);
            let nearest = exact.min_by(|a, b| (a - point).norm().total_cmp(&(b - point).norm()));
            let way = nearest.map_or_else(Vector::zeros, |nearest| point - nearest);
            let far = way.norm() / (NEAR_EXACT * lattice.spacing);
            if far > 1.0 {
                point -= way * (1.0 - 1.0 / far);
            }
        }
        let normal =
            if sharp { Vector::zeros() } else { normal.try_normalize(1e-9).unwrap_or_else(Vector::zeros) };
        (point, normal)
    }
}
