//! A lazily filled table of fitted axes along one wall, interpolated between its nodes.
//!
//! A fit costs some tens of microseconds, and the searches of stage 3 need tens of thousands of them. As a
//! function of s and of the shift s(M) − s(W) a fit is smooth, so a few nodes serve all rows, iterations
//! and policies.

use std::sync::OnceLock;

use crate::geometry::wrap_angle;

/// A node of the table.
#[derive(Clone, Copy, Debug)]
pub struct FitNode {
    /// θ of M and W, rad.
    pub angles: [f64; 2],
    /// Difference of these angles from those of the plain offset of the ruling, rad.
    pub beside_plain: [f64; 2],
    /// Whether it is on the smooth branch of fits and may be interpolated with its neighbours.
    pub is_fitted: bool,
}

/// Result of a look-up.
#[derive(Clone, Copy, Debug)]
pub enum Reading {
    /// θ of M and W, rad, interpolated on the smooth branch of fits.
    Fitted([f64; 2]),
    /// Difference from the angles of the plain offset, rad, interpolated from the surrounding nodes that have
    /// an axis, and whether all of these are fits.
    Beside([f64; 2], bool),
    /// Outside the table.
    Outside,
    /// None of the surrounding nodes has an axis.
    Nothing,
}

/// Angles (M, W) of fits over s of M (rows) and shift s(M) − s(W) (columns).
#[derive(Debug)]
pub struct FitTable {
    spacing: f64,
    nodes: Vec<OnceLock<Option<FitNode>>>,
}

const S_FROM: f64 = -0.6;
const S_TO: f64 = 1.8;
/// Axes shift by more than the length of the channel where it is deeper than long.
const SHIFT_LIMIT: f64 = 2.0;
const SHIFT_SPACING: f64 = 0.05;
const COLUMNS: usize = (2.0 * SHIFT_LIMIT / SHIFT_SPACING) as usize + 1;
/// Shift from which columns are counted, and the index of its column.
const SHIFT_ORIGIN: f64 = -1.0;
const ORIGIN: isize = ((SHIFT_LIMIT + SHIFT_ORIGIN) / SHIFT_SPACING) as isize;

/// Computes one node from (s of M, shift).
type FitFn<'a> = &'a dyn Fn(f64, f64) -> Option<FitNode>;

impl FitTable {
    /// An empty table with rows `spacing` apart in s.
    pub fn new(spacing: f64) -> Self {
        let rows = ((S_TO - S_FROM) / spacing).ceil() as usize + 1;
        Self { spacing, nodes: (0..rows * COLUMNS).map(|_| OnceLock::new()).collect() }
    }

    /// Looks up (`s`, `shift`), computing missing nodes with `fit`: Lagrange interpolation, cubic in s and
    /// quadratic in shift, where all nodes are fits; otherwise bilinear interpolation of the differences from
    /// the plain offset.
    pub fn look_up(&self, s: f64, shift: f64, fit: FitFn) -> Reading {
        let rows = self.nodes.len() / COLUMNS;
        let x = (s - S_FROM) / self.spacing;
        let y = (shift - SHIFT_ORIGIN) / SHIFT_SPACING;
        let row = (x.floor() as isize - 1).clamp(0, rows as isize - 4);
        let column = (y.round() as isize - 1).clamp(-ORIGIN, COLUMNS as isize - 3 - ORIGIN);
        let (fx, fy) = (x - row as f64, y - column as f64);
        if !(0.0..=3.0).contains(&fx) || !(-0.5..=2.5).contains(&fy) {
            return Reading::Outside;
        }
        match self.interpolated((row as usize, (column + ORIGIN) as usize), (fx, fy), fit) {
            Some(angles) => Reading::Fitted(angles),
            None => self.beside(x, y, fit),
        }
    }

    /// Lagrange interpolation; `None` where one of its nodes is not a fit.
    fn interpolated(
        &self,
        (row, column): (usize, usize),
        (fx, fy): (f64, f64),
        fit: FitFn,
    ) -> Option<[f64; 2]> {
        let by_s = [
            -(fx - 1.0) * (fx - 2.0) * (fx - 3.0) / 6.0,
            fx * (fx - 2.0) * (fx - 3.0) / 2.0,
            -fx * (fx - 1.0) * (fx - 3.0) / 2.0,
            fx * (fx - 1.0) * (fx - 2.0) / 6.0,
        ];
        let by_shift = [(fy - 1.0) * (fy - 2.0) / 2.0, -fy * (fy - 2.0), fy * (fy - 1.0) / 2.0];
        let (mut base, mut sum): (Option<[f64; 2]>, [f64; 2]) = (None, [0.0; 2]);
        for (i, wx) in by_s.iter().enumerate() {
            for (j, wy) in by_shift.iter().enumerate() {
                let weight = wx * wy;
                // Exactly on a grid line the neighbouring nodes are not needed (and may not exist).
                if weight.abs() < 1e-12 {
                    continue;
                }
                let node = self.node(row + i, column + j, fit).filter(|node| node.is_fitted)?.angles;
                let zero = *base.get_or_insert(node);
                sum[0] += weight * wrap_angle(node[0] - zero[0]);
                sum[1] += weight * wrap_angle(node[1] - zero[1]);
            }
        }
        let base = base?;
        Some([base[0] + sum[0], base[1] + sum[1]])
    }

    /// Bilinear interpolation of the differences from the plain offset over those of the four nodes around
    /// (`x`, `y`) that have an axis.
    fn beside(&self, x: f64, y: f64, fit: FitFn) -> Reading {
        let rows = self.nodes.len() / COLUMNS;
        let (row, from) =
            (x.floor() as usize, (y.floor() as isize).clamp(-ORIGIN, COLUMNS as isize - 2 - ORIGIN));
        let (fx, fy) = (x - row as f64, y - from as f64);
        let column = (from + ORIGIN) as usize;
        let (mut weights, mut sum, mut all_fitted) = (0.0, [0.0; 2], true);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight =
                ((1.0 - fx) * (1 - i) as f64 + fx * i as f64) * ((1.0 - fy) * (1 - j) as f64 + fy * j as f64);
            if weight <= 1e-12 || row + i >= rows {
                continue;
            }
            let Some(node) = self.node(row + i, column + j, fit) else { continue };
            weights += weight;
            all_fitted &= node.is_fitted;
            for k in 0..2 {
                sum[k] += weight * node.beside_plain[k];
            }
        }
        if weights > 0.0 { Reading::Beside(sum.map(|x| x / weights), all_fitted) } else { Reading::Nothing }
    }

    fn node(&self, row: usize, column: usize, fit: FitFn) -> Option<FitNode> {
        *self.nodes[row * COLUMNS + column].get_or_init(|| {
            let s = S_FROM + self.spacing * row as f64;
            let shift = SHIFT_SPACING * (column as isize - ORIGIN) as f64 + SHIFT_ORIGIN;
            fit(s, shift)
        })
    }
}
