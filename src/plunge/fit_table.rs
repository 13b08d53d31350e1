//! A table of side fits along one wall, filled where it is needed and interpolated in between.
//!
//! A fit costs some tens of microseconds and the searches of stage 3 ask for tens of thousands of them; as a
//! function of s and of the tilt along the row it is smooth, so few serve all rows, rounds and policies.

use std::sync::OnceLock;

use crate::geometry::wrap_angle;

/// Angles (M, W) of fits over s of M (rows) and shift s(M) − s(W) (columns).
#[derive(Debug)]
pub struct FitTable {
    spacing: f64,
    nodes: Vec<OnceLock<Option<[f64; 2]>>>,
}

const S_FROM: f64 = -0.6;
const S_TO: f64 = 1.8;
const SHIFT_LIMIT: f64 = 1.0;
const SHIFT_SPACING: f64 = 0.05;
const COLUMNS: usize = (2.0 * SHIFT_LIMIT / SHIFT_SPACING) as usize + 1;

/// Makes one fit: (s of M, shift) to angles.
type Fit<'a> = &'a dyn Fn(f64, f64) -> Option<[f64; 2]>;

impl FitTable {
    /// An empty table with rows `spacing` apart in s.
    pub fn new(spacing: f64) -> Self {
        let rows = ((S_TO - S_FROM) / spacing).ceil() as usize + 1;
        Self { spacing, nodes: (0..rows * COLUMNS).map(|_| OnceLock::new()).collect() }
    }

    /// Angles at (`s`, `shift`) by cubic interpolation in s and quadratic in shift, the nodes it
    /// needs made by `fit`. `None` outside the table or where a fit does not exist.
    pub fn at(&self, s: f64, shift: f64, fit: Fit) -> Option<[f64; 2]> {
        let rows = self.nodes.len() / COLUMNS;
        let x = (s - S_FROM) / self.spacing;
        let y = (shift + SHIFT_LIMIT) / SHIFT_SPACING;
        let row = (x.floor() as isize - 1).clamp(0, rows as isize - 4);
        let column = (y.round() as isize - 1).clamp(0, COLUMNS as isize - 3);
        let (fx, fy) = (x - row as f64, y - column as f64);
        if !(0.0..=3.0).contains(&fx) || !(-0.5..=2.5).contains(&fy) {
            return None;
        }
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
                // On a line of the table its neighbours are not needed (and need not exist).
                if weight.abs() < 1e-12 {
                    continue;
                }
                let node = self.node(row as usize + i, column as usize + j, fit)?;
                let zero = *base.get_or_insert(node);
                sum[0] += weight * wrap_angle(node[0] - zero[0]);
                sum[1] += weight * wrap_angle(node[1] - zero[1]);
            }
        }
        let base = base?;
        Some([base[0] + sum[0], base[1] + sum[1]])
    }

    fn node(&self, row: usize, column: usize, fit: Fit) -> Option<[f64; 2]> {
        *self.nodes[row * COLUMNS + column].get_or_init(|| {
            let s = S_FROM + self.spacing * row as f64;
            let shift = SHIFT_SPACING * column as f64 - SHIFT_LIMIT;
            fit(s, shift)
        })
    }
}
