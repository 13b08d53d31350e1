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

/// Weight of the second differences against a point's.
const STIFFNESS: f64 = 1e-4;

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
        let stiffness = STIFFNESS * pairs.len() as f64 / spans as f64;
        for i in 1..n - 1 {
            for (a, x) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                for (b, y) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                    matrix[(a, b)] += stiffness * x * y;
                }
            }
        }
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
}
