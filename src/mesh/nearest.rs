//! Nearest-point search in the meridional plane.

use crate::geometry::Meridional;

/// Uniform grid over points of the meridional plane, for nearest-point queries.
pub struct MeridionalGrid<'a> {
    points: &'a [Meridional],
    low: Meridional,
    cell: f64,
    columns: usize,
    rows: usize,
    /// Index of the first entry of each cell; the entries are point indices.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl<'a> MeridionalGrid<'a> {
    /// Sorts the points into cells (counting sort).
    pub fn from_points(points: &'a [Meridional]) -> Self {
        let (mut low, mut high) = (
            Meridional { r: f64::INFINITY, z: f64::INFINITY },
            Meridional { r: f64::NEG_INFINITY, z: f64::NEG_INFINITY },
        );
        for p in points {
            low = Meridional { r: low.r.min(p.r), z: low.z.min(p.z) };
            high = Meridional { r: high.r.max(p.r), z: high.z.max(p.z) };
        }
        let cell = ((high.r - low.r).max(high.z - low.z) / 256.0).max(1e-6);
        let columns = ((high.r - low.r) / cell).max(0.0) as usize + 1;
        let rows = ((high.z - low.z) / cell).max(0.0) as usize + 1;
        let (columns, rows) = (columns.min(1024), rows.min(1024));
        let mut nearest = Self { points, low, cell, columns, rows, starts: Vec::new(), entries: Vec::new() };
        let mut counts = vec![0_u32; columns * rows + 1];
        let cells: Vec<usize> = points.iter().map(|p| nearest.cell_of(*p)).collect();
        cells.iter().for_each(|c| counts[c + 1] += 1);
        for c in 1..counts.len() {
            counts[c] += counts[c - 1];
        }
        nearest.starts = counts.clone();
        nearest.entries = vec![0; points.len()];
        for (i, c) in cells.iter().enumerate() {
            nearest.entries[counts[*c] as usize] = i as u32;
            counts[*c] += 1;
        }
        nearest
    }

    fn place(&self, p: Meridional) -> (usize, usize) {
        let at = |x: f64, most: usize| ((x / self.cell).max(0.0) as usize).min(most - 1);
        (at(p.r - self.low.r, self.columns), at(p.z - self.low.z, self.rows))
    }

    fn cell_of(&self, p: Meridional) -> usize {
        let (i, j) = self.place(p);
        i * self.rows + j
    }

    /// Index of the point nearest to `p`, searched in growing rings of cells; `None` without points.
    pub fn nearest(&self, p: Meridional) -> Option<u32> {
        let (ci, cj) = self.place(p);
        let mut best: Option<(f64, u32)> = None;
        for ring in 0..self.columns.max(self.rows) {
            let (i0, i1) = (ci.saturating_sub(ring), (ci + ring).min(self.columns - 1));
            let (j0, j1) = (cj.saturating_sub(ring), (cj + ring).min(self.rows - 1));
            let rows = (i0..=i1).flat_map(|i| {
                // Between the first and the last row of the ring, only both end cells belong to it.
                let whole = i.abs_diff(ci) == ring;
                let ends = [cj.checked_sub(ring), (cj + ring < self.rows).then_some(cj + ring)];
                let all = if whole { j0..j1 + 1 } else { 0..0 };
                let two = if whole { [None, None] } else { ends };
                all.chain(two.into_iter().flatten()).map(move |j| i * self.rows + j)
            });
            for cell in rows {
                for &k in &self.entries[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
                    let d = self.points[k as usize].distance(p);
                    if best.is_none_or(|(least, _)| d < least) {
                        best = Some((d, k));
                    }
                }
            }
            if best.is_some_and(|(d, _)| d <= ring as f64 * self.cell) {
                break;
            }
        }
        best.map(|(_, k)| k)
    }
}
