//! Smooth functions through scattered points: penalised least-squares cubic B-splines (P-splines), with knots
//! as dense as the points and just enough stiffness to bridge intervals without points.

use nalgebra::{DMatrix, DVector};

/// A function y(x) on an interval: a cubic spline.
#[derive(Clone, Debug)]
pub struct SmoothFunction {
    /// Ends of the cubic pieces, and [`DEGREE`] more knots beyond either end of the interval.
    knots: Vec<f64>,
    coefficients: Vec<f64>,
}

const DEGREE: usize = 3;
/// Smallest number of cubic pieces.
const MIN_SPANS: usize = 4;
/// Cubic pieces per distinct x of the points.
const SPANS_PER_PLACE: f64 = 2.0 / 3.0;
/// x values closer together than this share of the length of a piece, if all were equally long, count as one.
const ONE_PLACE: f64 = 0.125;
/// Weight of the third differences of the coefficients relative to that of a point. Constant curvature costs
/// nothing, so that curves keep direction and curvature where points are few.
const STIFFNESS: f64 = 1e-4;
/// As [`STIFFNESS`], for the second differences: just enough to make the fit unique with only two distinct x.
const STRAIGHTNESS: f64 = 1e-9;
/// Weight of a point above a lower envelope, how many times [`STIFFNESS`] it has, as it is to bridge
/// intervals with points above it only, and largest number of times that it is fitted.
const ABOVE: f64 = 1e-4;
const STIFFER: f64 = 100.0;
const MAX_REWEIGHTINGS: usize = 40;

impl SmoothFunction {
    /// Fits (x, y) pairs with two cubic pieces for every three distinct x, at most `max_spans`. `None` when
    /// the pairs have no extent in x or are not finite.
    pub fn fit(pairs: &[(f64, f64)], max_spans: usize) -> Option<Self> {
        Self::fit_weighted(pairs, |_| 1.0, STIFFNESS, max_spans)
    }

    /// The lower envelope of (x, y) pairs, by asymmetric least squares (Eilers and Boelens): points above the
    /// function weigh [`ABOVE`], as many as they are, those below 1. As [`Self::fit`] otherwise.
    pub fn fit_below(pairs: &[(f64, f64)], max_spans: usize) -> Option<Self> {
        let mut function = Self::fit(pairs, max_spans)?;
        let mut above = vec![false; pairs.len()];
        for _ in 0..MAX_REWEIGHTINGS {
            let now: Vec<bool> = pairs.iter().map(|(x, y)| *y > function.at(*x)).collect();
            if now == above {
                break;
            }
            above = now;
            let weight = |i: usize| if above[i] { ABOVE } else { 1.0 };
            function = Self::fit_weighted(pairs, weight, STIFFER * STIFFNESS, max_spans)?;
        }
        Some(function)
    }

    fn fit_weighted(
        pairs: &[(f64, f64)],
        weight: impl Fn(usize) -> f64,
        stiffness: f64,
        max_spans: usize,
    ) -> Option<Self> {
        if pairs.iter().any(|p| !(p.0.is_finite() && p.1.is_finite())) {
            return None;
        }
        let knots = knots(pairs, max_spans)?;
        let n = knots.len() - DEGREE - 1;
        let mut function = Self { knots, coefficients: vec![0.0; n] };
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let mut all = 0.0;
        for (k, &(x, y)) in pairs.iter().enumerate() {
            let weight = weight(k);
            all += weight;
            let (first, basis) = function.basis(x);
            for (i, b) in basis.iter().enumerate() {
                right[first + i] += weight * b * y;
                for (j, c) in basis.iter().enumerate() {
                    matrix[(first + i, first + j)] += weight * b * c;
                }
            }
        }
        let per_span = all / function.spans() as f64;
        function.add_differences(&mut matrix, 3, stiffness * per_span);
        function.add_differences(&mut matrix, 2, STRAIGHTNESS * per_span);
        let solved = matrix.cholesky()?.solve(&right);
        function.coefficients = solved.iter().copied().collect();
        function.coefficients.iter().all(|c| c.is_finite()).then_some(function)
    }

    /// Adds the squared derivatives of an order to the normal equations. They are scaled by the mean length
    /// of the pieces around them, so that their weight is the same for long and short pieces.
    fn add_differences(&self, matrix: &mut DMatrix<f64>, order: usize, weight: f64) {
        for first in 0..self.coefficients.len() - order {
            let t = &self.knots[first..first + DEGREE + order + 1];
            // Row i: coefficient i of the derivative's spline as a linear form in coefficients first + k.
            let mut row = vec![vec![0.0; order + 1]; order + 1];
            for (k, own) in row.iter_mut().enumerate() {
                own[k] = 1.0;
            }
            for done in 0..order {
                for i in 0..order - done {
                    let width = t[i + DEGREE + 1] - t[i + done + 1];
                    let next: Vec<f64> = row[i]
                        .iter()
                        .zip(&row[i + 1])
                        .map(|(a, b)| (DEGREE - done) as f64 * (b - a) / width)
                        .collect();
                    row[i] = next;
                }
            }
            let unit = (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64;
            let row: Vec<f64> = row[0].iter().map(|x| x * unit.powi(order as i32)).collect();
            for (i, x) in row.iter().enumerate() {
                for (j, y) in row.iter().enumerate() {
                    matrix[(first + i, first + j)] += weight * x * y;
                }
            }
        }
    }

    /// Index of the piece that contains `x`, or of the nearest one.
    fn span(&self, x: f64) -> usize {
        self.ends()[1..self.spans()].partition_point(|end| *end <= x)
    }

    /// Index of the first of the four basis functions that are not zero at `x`, and their values (Cox–de
    /// Boor).
    fn basis(&self, x: f64) -> (usize, [f64; DEGREE + 1]) {
        let span = self.span(x);
        let at = span + DEGREE;
        let mut basis = [1.0, 0.0, 0.0, 0.0];
        for degree in 1..=DEGREE {
            let mut carry = 0.0;
            for r in 0..degree {
                let (below, above) = (self.knots[at + 1 + r - degree], self.knots[at + 1 + r]);
                let share = basis[r] / (above - below);
                basis[r] = carry + (above - x) * share;
                carry = (x - below) * share;
            }
            basis[degree] = carry;
        }
        (span, basis)
    }

    /// Value y at `x`.
    pub fn at(&self, x: f64) -> f64 {
        let (first, basis) = self.basis(x);
        basis.iter().enumerate().map(|(i, b)| b * self.coefficients[first + i]).sum()
    }

    /// Slope dy/dx at `x`, by central differences.
    pub fn slope(&self, x: f64) -> f64 {
        let span = self.span(x);
        let h = 1e-4 * (self.ends()[span + 1] - self.ends()[span]);
        (self.at(x + h) - self.at(x - h)) / (2.0 * h)
    }

    /// Ends of the cubic pieces.
    pub fn ends(&self) -> &[f64] {
        &self.knots[DEGREE..self.knots.len() - DEGREE]
    }

    fn spans(&self) -> usize {
        self.coefficients.len() - DEGREE
    }
}

/// Knots as dense as the distinct x of the points; `None` where these have no extent.
fn knots(pairs: &[(f64, f64)], max_spans: usize) -> Option<Vec<f64>> {
    let mut x: Vec<f64> = pairs.iter().map(|p| p.0).collect();
    x.sort_by(f64::total_cmp);
    let (low, high) = (*x.first()?, *x.last()?);
    if high - low < 1e-9 {
        return None;
    }
    let most = max_spans.max(1);
    let wanted = |places: &[f64]| (SPANS_PER_PLACE * places.len() as f64) as usize;
    // Where that makes too many pieces, near x count as one, so that regions with few points keep their
    // knots.
    let mut apart = ONE_PLACE * (high - low) / most as f64;
    let mut places = spread(&x, apart);
    while wanted(&places) > most {
        apart *= 1.25;
        places = spread(&x, apart);
    }
    let spans = wanted(&places).clamp(MIN_SPANS.min(most), most);
    let end = |k: usize| {
        let at = k as f64 / spans as f64 * (places.len() - 1) as f64;
        let i = (at as usize).min(places.len() - 2);
        places[i] + (places[i + 1] - places[i]) * (at - i as f64)
    };
    let ends: Vec<f64> = (0..=spans).map(end).collect();
    let (first, last) = (ends[1] - ends[0], ends[spans] - ends[spans - 1]);
    let before = (1..=DEGREE).rev().map(|k| low - first * k as f64);
    let after = (1..=DEGREE).map(|k| high + last * k as f64);
    Some(before.chain(ends.iter().copied()).chain(after).collect())
}

/// Thins increasing numbers to those more than `apart` from the one before; keeps the first and the last.
fn spread(x: &[f64], apart: f64) -> Vec<f64> {
    let (Some(&low), Some(&high)) = (x.first(), x.last()) else { return Vec::new() };
    let mut kept = vec![low];
    for &x in x {
        if x - kept[kept.len() - 1] > apart && high - x > apart {
            kept.push(x);
        }
    }
    kept.push(high);
    kept
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
    fn a_lower_envelope_leaves_out_what_is_above_it() {
        // Rows of a hub, and between them many more points of fillets, which have few on the hub.
        let hub = |x: f64| 0.02 * x * x;
        let rows = (0..=40).flat_map(|i| [(0.5 * f64::from(i), 0.0); 3]);
        let fillets = (0..2000).map(|i| (8.0 + 0.002 * f64::from(i), 0.01 * f64::from(i * 37 % 50)));
        let pairs: Vec<(f64, f64)> = rows.chain(fillets).map(|(x, over)| (x, hub(x) + over)).collect();
        let below = SmoothFunction::fit_below(&pairs, 240).unwrap();
        let off =
            (0..=200).map(|i| 0.1 * f64::from(i)).map(|x| (below.at(x) - hub(x)).abs()).fold(0.0, f64::max);
        assert!(off < 0.02, "{off}");
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

    #[test]
    fn a_bend_is_followed_where_points_are_dense_about_it() {
        // Straight, then a parabola: the second derivative jumps at 20.
        let bend = |x: f64| if x < 20.0 { 0.0 } else { 0.01 * (x - 20.0) * (x - 20.0) };
        let sparse = (0..=20).map(|i| 3.0 * f64::from(i));
        let dense = (0..=40).map(|i| 19.0 + 0.05 * f64::from(i));
        let pairs: Vec<(f64, f64)> = sparse.chain(dense).map(|x| (x, bend(x))).collect();
        let fitted = SmoothFunction::fit(&pairs, 160).unwrap();
        for i in 0..=600 {
            let x = 0.1 * f64::from(i);
            let off = fitted.slope(x) - if x < 20.0 { 0.0 } else { 0.02 * (x - 20.0) };
            assert!(off.abs() < 5e-4, "slope {off} off at {x}");
        }
    }
}
