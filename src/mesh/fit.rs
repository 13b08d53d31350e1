//! Smooth functions through scattered points: cubic splines on even knots, by least squares, with just enough
//! stiffness to bridge stretches without points.

use nalgebra::{DMatrix, DVector};

/// A function y(x) on an interval.
#[derive(Clone, Debug)]
pub struct SmoothFunction {
    start: f64,
    step: f64,
    coefficients: Vec<f64>,
}

/// Weight of the third differences of the coefficients against a point's: what they are bent by evenly costs nothing,
/// so that curves keep their direction and curvature where points are few.
const STIFFNESS: f64 = 1e-4;
/// As [`STIFFNESS`], of the second differences: just enough for points at two places.
const STRAIGHTNESS: f64 = 1e-9;

impl SmoothFunction {
    /// Fits (x, y) pairs with `spans` cubic pieces; `None` when the pairs have no extent or are not finite.
    pub fn fit(pairs: &[(f64, f64)], spans: usize) -> Option<Self> {
        let (low, high) = pairs
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.0), high.max(p.0)));
        if pairs.iter().any(|p| !(p.0.is_finite() && p.1.is_finite()))
            || high - low < 1e-9
            || pairs.is_empty()
        {
            return None;
        }
        let spans = spans.max(1);
        let mut function =
            Self { start: low, step: (high - low) / spans as f64, coefficients: vec![0.0; spans + 3] };
        let n = spans + 3;
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for &(x, y) in pairs {
            let (first, basis) = function.basis(x);
            for (i, b) in basis.iter().enumerate() {
                right[first + i] += b * y;
                for (j, c) in basis.iter().enumerate() {
                    matrix[(first + i, first + j)] += b * c;
                }
            }
        }
        let per_span = pairs.len() as f64 / spans as f64;
        add_differences(&mut matrix, &[1.0, -3.0, 3.0, -1.0], STIFFNESS * per_span);
        add_differences(&mut matrix, &[1.0, -2.0, 1.0], STRAIGHTNESS * per_span);
        let solved = matrix.cholesky()?.solve(&right);
        function.coefficients = solved.iter().copied().collect();
        function.coefficients.iter().all(|c| c.is_finite()).then_some(function)
    }

    /// First knot span of `x` and the four basis functions there.
    fn basis(&self, x: f64) -> (usize, [f64; 4]) {
        let last = self.coefficients.len() - 4;
        let at = (x - self.start) / self.step;
        let i = (at.max(0.0) as usize).min(last);
        let t = at - i as f64;
        let s = 1.0 - t;
        (
            i,
            [
                s * s * s / 6.0,
                (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
                t * t * t / 6.0,
            ],
        )
    }

    /// y at `x`.
    pub fn at(&self, x: f64) -> f64 {
        let (first, basis) = self.basis(x);
        basis.iter().enumerate().map(|(i, b)| b * self.coefficients[first + i]).sum()
    }

    /// Slope at `x`.
    pub fn slope(&self, x: f64) -> f64 {
        let h = 1e-4 * self.step;
        (self.at(x + h) - self.at(x - h)) / (2.0 * h)
    }

    /// Ends of the interval.
    pub fn domain(&self) -> (f64, f64) {
        (self.start, self.start + self.step * (self.coefficients.len() - 3) as f64)
    }

    /// Number of cubic pieces.
    pub fn spans(&self) -> usize {
        self.coefficients.len() - 3
    }
}

/// Adds the squares of differences of neighbouring coefficients to the normal equations.
fn add_differences(matrix: &mut DMatrix<f64>, row: &[f64], weight: f64) {
    for first in 0..=matrix.nrows().saturating_sub(row.len()) {
        for (i, x) in row.iter().enumerate() {
            for (j, y) in row.iter().enumerate() {
                matrix[(first + i, first + j)] += weight * x * y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_points_of_a_smooth_function_are_met_and_gaps_bridged() {
        let pairs: Vec<(f64, f64)> = (0..400)
            .map(|i| 10.0 * f64::from(i * 37 % 400) / 400.0)
            .filter(|x| !(4.0..4.6).contains(x))
            .map(|x| (x, x.sin()))
            .collect();
        let fitted = SmoothFunction::fit(&pairs, 50).unwrap();
        for i in 0..=990 {
            let x = 0.01 * f64::from(i);
            let limit = if (3.9..4.7).contains(&x) { 5e-3 } else { 2e-4 };
            assert!((fitted.at(x) - x.sin()).abs() < limit, "{x}: {}", fitted.at(x) - x.sin());
            assert!((fitted.slope(x) - x.cos()).abs() < 100.0 * limit);
        }
        assert!(SmoothFunction::fit(&[(1.0, 2.0), (1.0, 3.0)], 4).is_none());
    }

    #[test]
    fn few_points_of_a_curve_tell_its_direction_up_to_its_ends() {
        let arc = |x: f64| (100.0 - x * x).sqrt();
        let pairs: Vec<(f64, f64)> = (0..=12).map(|i| 0.5 * f64::from(i)).map(|x| (x, arc(x))).collect();
        let fitted = SmoothFunction::fit(&pairs, 16).unwrap();
        for i in 0..=600 {
            let x = 0.01 * f64::from(i);
            let off = fitted.slope(x) + x / arc(x);
            assert!(off.abs() < 2e-3, "slope {off} off at {x}");
        }
    }
}
