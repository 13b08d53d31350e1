//! Which nodes of the lattice are in stock, and the vertices on the edges between them.

use rayon::prelude::*;

use super::super::SolidStock;

/// One bit for each node: whether it is in stock. Bits of a line along z are consecutive.
pub struct Nodes {
    /// Words of a line.
    pub words: usize,
    columns: usize,
    bits: Vec<u64>,
}

impl Nodes {
    /// The nodes of `stock`, by its rays along z.
    pub fn of(stock: &SolidStock) -> Self {
        let [rows, columns, count] = stock.lattice.counts;
        let words = count.div_ceil(64);
        let mut bits = vec![0u64; rows * columns * words];
        let (low, spacing) = (stock.lattice.origin.z, stock.lattice.spacing);
        bits.par_chunks_mut(columns * words).enumerate().for_each(|(i, plane)| {
            for (j, line) in plane.chunks_exact_mut(words).enumerate() {
                for span in stock.spans(2, i, j) {
                    let mut k = ((span.from - low) / spacing).floor().max(0.0) as usize;
                    while k < count && stock.lattice.coordinate(2, k) < span.to {
                        if stock.lattice.coordinate(2, k) > span.from {
                            line[k / 64] |= 1 << (k % 64);
                        }
                        k += 1;
                    }
                }
            }
        });
        Self { words, columns, bits }
    }

    /// The bits of the line (i, j) along z.
    #[inline]
    pub fn line(&self, i: usize, j: usize) -> &[u64] {
        let from = (i * self.columns + j) * self.words;
        &self.bits[from..from + self.words]
    }

    /// Whether a node is in stock.
    #[inline]
    pub fn is_in(&self, [i, j, k]: [usize; 3]) -> bool {
        self.line(i, j)[k / 64] >> (k % 64) & 1 == 1
    }
}

/// Vertices of edges in one plane, by the number of the edge in it.
pub struct EdgePlane {
    /// The vertex on each edge; `u32::MAX` where there is none yet.
    pub of: Vec<u32>,
    /// Edges with a vertex.
    pub used: Vec<u32>,
}

impl EdgePlane {
    /// A plane of `count` edges.
    pub fn new(count: usize) -> Self {
        Self { of: vec![u32::MAX; count], used: Vec::new() }
    }

    /// Forgets all vertices.
    pub fn clear(&mut self) {
        for &edge in &self.used {
            self.of[edge as usize] = u32::MAX;
        }
        self.used.clear();
    }
}
