//! Where stock is, coarsely: a cheap answer to whether a piece can meet any.

use super::lattice::Lattice;
use super::piece::Piece;
use super::rays::RayField;
use crate::geometry::Point;

/// Cells along the longest side of the stock.
const CELLS: f64 = 96.0;
/// Share of a cell below which a distance counts as contact.
const SMALLEST_STEP: f64 = 0.25;

/// Lower bounds of the distance to the stock as it was at first. As cuts only remove stock, they hold for all
/// states after it.
#[derive(Clone, Debug)]
pub struct NearStock {
    origin: Point,
    /// Side of a cell, mm.
    side: f64,
    counts: [usize; 3],
    /// From the centre of each cell to the nearest centre of a cell that holds stock, mm.
    distances: Vec<f32>,
}

impl NearStock {
    /// The cells that the spans on the rays of `fields` touch, and the distances to them.
    pub fn from_lattice(lattice: &Lattice, fields: &[RayField; 3]) -> Self {
        let (low, high) = lattice.bounds();
        let extent = high - low;
        let side = (extent.max() / CELLS).max(lattice.spacing);
        let counts: [usize; 3] = std::array::from_fn(|k| (extent[k] / side).ceil().max(1.0) as usize);
        let mut squares = vec![f32::INFINITY; counts.iter().product()];
        let cell = |k: usize, x: f64| (((x - low[k]) / side) as usize).min(counts[k] - 1);
        for field in fields {
            let (a, b) = Lattice::across(field.direction);
            let mut at = [0; 3];
            for u in 0..field.counts.0 {
                at[a] = cell(a, lattice.coordinate(a, u));
                for v in 0..field.counts.1 {
                    at[b] = cell(b, lattice.coordinate(b, v));
                    for span in field.spans(u, v) {
                        for along in cell(field.direction, span.from)..=cell(field.direction, span.to) {
                            at[field.direction] = along;
                            squares[(at[0] * counts[1] + at[1]) * counts[2] + at[2]] = 0.0;
                        }
                    }
                }
            }
        }
        for k in 0..3 {
            transform(&mut squares, counts, k);
        }
        let distances = squares.iter().map(|square| square.sqrt() * side as f32).collect();
        Self { origin: low, side, counts, distances }
    }

    /// A lower bound of the distance from `point` to stock, mm; 0 or less where it may be in stock.
    fn distance(&self, point: &Point) -> f64 {
        let mut index = 0;
        let mut outside = 0.0f64;
        for k in 0..3 {
            let at = (point[k] - self.origin[k]) / self.side;
            let inside = at.clamp(0.0, self.counts[k] as f64);
            outside += (at - inside) * (at - inside);
            index = index * self.counts[k] + (inside as usize).min(self.counts[k] - 1);
        }
        // The point and the stock are anywhere in their cells.
        let in_box = f64::from(self.distances[index]) - self.side * 3f64.sqrt();
        in_box.max(outside.sqrt() * self.side)
    }

    /// Whether stock may be in what `piece` sweeps: steps along its axis by the free distance (sphere
    /// tracing).
    pub fn may_meet(&self, piece: &Piece) -> bool {
        let wide = piece.outline.radius + piece.travel.norm();
        let mut height = 0.0;
        while height <= piece.outline.length {
            let free = self.distance(&(piece.base + piece.axis * height)) - wide;
            if free < SMALLEST_STEP * self.side {
                return true;
            }
            height += free;
        }
        false
    }
}

/// The pass along coordinate `axis` of the squared Euclidean distance transform, in cells: the lower envelope
/// of parabolas (Felzenszwalb and Huttenlocher, "Distance transforms of sampled functions", 2012).
fn transform(squares: &mut [f32], counts: [usize; 3], axis: usize) {
    let stride: usize = counts[axis + 1..].iter().product();
    let count = counts[axis];
    let mut line = vec![0.0f32; count];
    let mut parabolas: Vec<(usize, f32)> = Vec::with_capacity(count);
    for first in (0..squares.len()).filter(|index| (index / stride).is_multiple_of(count)) {
        for (k, value) in line.iter_mut().enumerate() {
            *value = squares[first + k * stride];
        }
        parabolas.clear();
        let height = |k: usize| line[k] + (k * k) as f32;
        for k in (0..count).filter(|&k| line[k].is_finite()) {
            let mut from = f32::NEG_INFINITY;
            while let Some(&(last, begins)) = parabolas.last() {
                from = (height(k) - height(last)) / (2.0 * (k - last) as f32);
                if from > begins {
                    break;
                }
                parabolas.pop();
                from = f32::NEG_INFINITY;
            }
            parabolas.push((k, from));
        }
        let mut lowest = 0;
        for k in 0..count {
            while parabolas.get(lowest + 1).is_some_and(|next| next.1 < k as f32) {
                lowest += 1;
            }
            if let Some(&(at, _)) = parabolas.get(lowest) {
                let away = k.abs_diff(at) as f32;
                squares[first + k * stride] = away * away + line[at];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transform_gives_the_nearest_of_all_cells() {
        let counts = [7, 5, 6];
        let cells: Vec<[usize; 3]> =
            (0..7).flat_map(|i| (0..5).flat_map(move |j| (0..6).map(move |k| [i, j, k]))).collect();
        let full = [[0usize, 0, 0], [6, 4, 1], [3, 2, 5], [3, 3, 5]];
        let mut squares: Vec<f32> =
            cells.iter().map(|c| if full.contains(c) { 0.0 } else { f32::INFINITY }).collect();
        for axis in 0..3 {
            transform(&mut squares, counts, axis);
        }
        for (cell, found) in cells.iter().zip(&squares) {
            let square =
                |other: &[usize; 3]| -> usize { (0..3).map(|k| cell[k].abs_diff(other[k]).pow(2)).sum() };
            let nearest = full.iter().map(square).min().expect("cells");
            assert!((found - nearest as f32).abs() < 1e-4, "{cell:?}: {found} instead of {nearest}");
        }
    }
}
