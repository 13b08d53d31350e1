//! The 256 cases of marching cubes, as rings of edges.
//!
//! Corners of a cell are numbered by bits: 1 for +x, 2 for +y, 4 for +z. Edges are numbered 4 × axis + the
//! bits of their first corner without that of the axis.

use std::sync::LazyLock;

/// A ring of edges, counter-clockwise seen from outside the stock.
#[derive(Clone, Copy, Default)]
pub struct EdgeRing {
    edges: [u8; 12],
    len: u8,
    /// Of four edges, the first from which a diagonal does not lie in a face of the cell, where it could be
    /// that of the neighbour, too.
    pub diagonal: Option<u8>,
}

impl EdgeRing {
    fn new(edges: &[u8]) -> Self {
        let mut ring = Self { len: edges.len() as u8, ..Self::default() };
        ring.edges[..edges.len()].copy_from_slice(edges);
        if edges.len() == 4 {
            ring.diagonal = (0..2).find(|&k| !share_a_face(edges[k], edges[k + 2])).map(|k| k as u8);
        }
        ring
    }

    /// Its edges.
    #[inline]
    pub fn edges(&self) -> &[u8] {
        &self.edges[..usize::from(self.len)]
    }
}

/// The rings of a case; at most four, as each takes three of twelve edges.
#[derive(Clone, Copy, Default)]
pub struct CellCase {
    rings: [EdgeRing; 4],
    count: u8,
}

impl CellCase {
    fn new(case: usize) -> Self {
        let mut all = Self::default();
        for edges in rings(case) {
            all.rings[usize::from(all.count)] = EdgeRing::new(&edges);
            all.count += 1;
        }
        all
    }

    /// Its rings.
    #[inline]
    pub fn rings(&self) -> &[EdgeRing] {
        &self.rings[..usize::from(self.count)]
    }
}

/// The rings of each case; bit i of the case is set where corner i is in stock.
pub static CELLS: LazyLock<[CellCase; 256]> = LazyLock::new(|| std::array::from_fn(CellCase::new));

/// The axis of each edge and its first corner.
pub const EDGE_STARTS: [(usize, usize); 12] = {
    let mut starts = [(0, 0); 12];
    let mut edge = 0;
    while edge < 12 {
        starts[edge] = edge_start(edge as u8);
        edge += 1;
    }
    starts
};

/// The axis of an edge and its first corner.
const fn edge_start(edge: u8) -> (usize, usize) {
    let (axis, rest) = (edge as usize / 4, edge as usize % 4);
    let low = rest & ((1 << axis) - 1);
    (axis, low | (rest ^ low) << 1)
}

fn edge_between(a: usize, b: usize) -> u8 {
    let axis = (a ^ b).trailing_zeros() as usize;
    let start = a & b;
    let low = start & ((1 << axis) - 1);
    (4 * axis + (low | (start ^ low) >> 1)) as u8
}

/// Whether two edges of a cell lie on a common face.
fn share_a_face(a: u8, b: u8) -> bool {
    let faces = |edge: u8| {
        let (axis, start) = edge_start(edge);
        [(axis + 1) % 3, (axis + 2) % 3].map(|other| (other, start >> other & 1))
    };
    faces(a).iter().any(|face| faces(b).contains(face))
}

/// The rings of one case. On each face the surface cuts off every run of corners in stock by itself, which
/// both cells of the face see alike.
fn rings(case: usize) -> Vec<Vec<u8>> {
    let is_in = |corner: usize| case >> corner & 1 == 1;
    // For each crossed edge the one that follows it in its ring.
    let mut next = [u8::MAX; 12];
    for axis in 0..3 {
        let (b, c) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in 0..2 {
            let base = side << axis;
            let mut corners = [base, base | b, base | b | c, base | c];
            if side == 0 {
                corners.reverse();
            }
            for start in 0..4 {
                // A run of corners in stock begins after `start`.
                if is_in(corners[start]) || !is_in(corners[(start + 1) % 4]) {
                    continue;
                }
                let mut last = start + 1;
                while is_in(corners[(last + 1) % 4]) {
                    last += 1;
                }
                let enters = edge_between(corners[start], corners[(start + 1) % 4]);
                let leaves = edge_between(corners[last % 4], corners[(last + 1) % 4]);
                next[usize::from(enters)] = leaves;
            }
        }
    }
    let mut rings = Vec::new();
    for first in 0..12u8 {
        let mut ring = Vec::new();
        let mut edge = first;
        while next[usize::from(edge)] != u8::MAX {
            ring.push(edge);
            edge = std::mem::replace(&mut next[usize::from(edge)], u8::MAX);
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_their_corners_agree() {
        for edge in 0..12 {
            let (axis, start) = edge_start(edge);
            assert_eq!(start >> axis & 1, 0);
            assert_eq!(edge_between(start, start | 1 << axis), edge);
        }
    }

    #[test]
    fn every_crossed_edge_is_in_one_ring() {
        for case in 0..256usize {
            let mut edges: Vec<u8> = CELLS[case].rings().iter().flat_map(EdgeRing::edges).copied().collect();
            edges.sort_unstable();
            let crossed: Vec<u8> = (0..12)
                .filter(|&edge| {
                    let (axis, start) = edge_start(edge);
                    (case >> start ^ case >> (start | 1 << axis)) & 1 == 1
                })
                .collect();
            assert_eq!(edges, crossed, "case {case:08b}");
            assert!(CELLS[case].rings().iter().all(|ring| ring.edges().len() >= 3));
        }
    }
}
