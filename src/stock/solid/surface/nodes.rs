//! Which nodes of the lattice are in stock, and the vertices on the edges between them.

use super::super::SolidStock;

/// One bit for each node of a plane across x: whether it is in stock. Bits of a line along z are consecutive.
#[derive(Default)]
pub struct NodePlane {
    /// Words of a line.
    pub words: usize,
    bits: Vec<u64>,
}

impl NodePlane {
    /// A plane of the lattice of `stock`, without nodes in stock.
    pub fn new(stock: &SolidStock) -> Self {
        let [_, columns, count] = stock.lattice.counts;
        let words = count.div_ceil(64);
        Self { words, bits: vec![0; columns * words] }
    }

    /// Takes plane `i` of `stock`, by its rays along z.
    pub fn fill(&mut self, stock: &SolidStock, i: usize) {
        let count = stock.lattice.counts[2];
        let (low, spacing) = (stock.lattice.origin.z, stock.lattice.spacing);
        let at = |k: usize| stock.lattice.coordinate(2, k);
        self.bits.fill(0);
        for (j, line) in self.bits.chunks_exact_mut(self.words).enumerate() {
            for span in stock.spans(2, i, j) {
                // The first node above the lower end, and the first that is not below the upper one.
                let first_from = |place: f64, is_before: &dyn Fn(f64) -> bool| {
                    let mut k = ((place - low) / spacing).floor().max(0.0) as usize;
                    while k < count && is_before(at(k)) {
                        k += 1;
                    }
                    k.min(count)
                };
                let first = first_from(span.from, &|z| z <= span.from);
                let end = first_from(span.to, &|z| z < span.to);
                set_bits(line, first, end);
            }
        }
    }

    /// The bits of line `j` along z.
    #[inline]
    pub fn line(&self, j: usize) -> &[u64] {
        &self.bits[j * self.words..(j + 1) * self.words]
    }
}

/// Sets the bits from `first` to before `end`.
fn set_bits(line: &mut [u64], first: usize, end: usize) {
    let mut bit = first;
    while bit < end {
        let until = end.min((bit / 64 + 1) * 64);
        let count = until - bit;
        line[bit / 64] |= (u64::MAX >> (64 - count)) << (bit % 64);
        bit = until;
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
