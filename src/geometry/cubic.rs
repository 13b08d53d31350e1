//! Piecewise cubic curves: interpolating splines and B-splines in one form.

/// A C2 piecewise cubic curve in `D` dimensions over increasing knots; straight beyond its ends.
#[derive(Clone, Debug)]
pub struct Cubic<const D: usize> {
    knots: Vec<f64>,
    /// Per segment, the power-basis coefficients in (t − knot), lowest order first.
    segments: Vec<[[f64; D]; 4]>,
    /// First segment of each of equally wide buckets over the domain, to find a segment in O(1).
    buckets: Vec<u32>,
    buckets_per_unit: f64,
}

impl<const D: usize> Cubic<D> {
    /// The interpolating spline through `points` at `knots` (strictly increasing, at least two).
    /// End slopes come from the cubic through the outermost four points, so that a cubic is
    /// reproduced exactly.
    pub fn interpolate(knots: &[f64], points: &[[f64; D]]) -> Self {
        Self::interpolate_with_corners(knots, points, &[])
    }

    /// As [`Self::interpolate`], with corners at the points of these increasing indices: a spline from each
    /// to the next.
    pub fn interpolate_with_corners(knots: &[f64], points: &[[f64; D]], corners: &[usize]) -> Self {
        let n = points.len();
        assert!(n >= 2 && knots.len() == n, "a spline needs two points and a knot for each");
        let mut segments = Vec::with_capacity(n - 1);
        let mut from = 0;
        for to in corners.iter().copied().filter(|k| (1..n - 1).contains(k)).chain([n - 1]) {
            let (knots, points) = (&knots[from..=to], &points[from..=to]);
            let slopes = spline_slopes(knots, points);
            segments.extend((0..to - from).map(|i| {
                hermite(knots[i + 1] - knots[i], &points[i], &points[i + 1], &slopes[i], &slopes[i + 1])
            }));
            from = to;
        }
        Self::from_segments(knots.to_vec(), segments)
    }

    /// The B-spline with `control` points of `degree` 1 to 3 over a full non-decreasing knot vector of
    /// `control.len() + degree + 1` values.
    pub fn b_spline(control: &[[f64; D]], degree: usize, knots: &[f64]) -> Self {
        let spans: Vec<usize> = (degree..control.len()).filter(|&i| knots[i + 1] > knots[i]).collect();
        let mut breaks: Vec<f64> = spans.iter().map(|&i| knots[i]).collect();
        breaks.push(knots[control.len()]);
        let segments = spans
            .iter()
            .map(|&span| {
                let (a, b) = (knots[span], knots[span + 1]);
                // Four points determine the cubic of the span exactly.
                let at = |x: f64| de_boor(control, degree, knots, span, a + (b - a) * x);
                let (p0, p1, p2, p3) = (at(0.0), at(1.0 / 3.0), at(2.0 / 3.0), at(1.0));
                let h = b - a;
                let mut c = [[0.0; D]; 4];
                for k in 0..D {
                    c[0][k] = p0[k];
                    c[1][k] = (-5.5 * p0[k] + 9.0 * p1[k] - 4.5 * p2[k] + p3[k]) / h;
                    c[2][k] = (9.0 * p0[k] - 22.5 * p1[k] + 18.0 * p2[k] - 4.5 * p3[k]) / (h * h);
                    c[3][k] = (-4.5 * p0[k] + 13.5 * p1[k] - 13.5 * p2[k] + 4.5 * p3[k]) / (h * h * h);
                }
                c
            })
            .collect();
        Self::from_segments(breaks, segments)
    }

    fn from_segments(knots: Vec<f64>, segments: Vec<[[f64; D]; 4]>) -> Self {
        let count = (2 * segments.len()).max(1);
        let (start, end) = (knots[0], knots[knots.len() - 1]);
        let mut segment = 0;
        let buckets = (0..count)
            .map(|b| {
                let t = start + (end - start) * b as f64 / count as f64;
                while segment + 1 < segments.len() && knots[segment + 1] <= t {
                    segment += 1;
                }
                segment as u32
            })
            .collect();
        Self { knots, segments, buckets, buckets_per_unit: count as f64 / (end - start) }
    }

    /// The same curve from parameter `start` on, extended before it by its tangent.
    pub fn starting_at(&self, start: f64) -> Self {
        let (_, end) = self.domain();
        if start <= self.knots[0] || start >= end {
            return self.clone();
        }
        let first = self.segment(start);
        let (p, d1, d2) = self.derivatives(start);
        let mut segments = self.segments[first..].to_vec();
        let mut knots = self.knots[first..].to_vec();
        for k in 0..D {
            let cubic = segments[0][3][k];
            for (order, value) in [p[k], d1[k], d2[k] / 2.0, cubic].into_iter().enumerate() {
                segments[0][order][k] = value;
            }
        }
        knots[0] = start;
        Self::from_segments(knots, segments)
    }

    /// The same curve up to parameter `end`, extended beyond it by its tangent.
    pub fn ending_at(&self, end: f64) -> Self {
        let (start, last) = self.domain();
        if end >= last || end <= start {
            return self.clone();
        }
        // Number of segments up to the one that contains `end` or ends there.
        let count = self.knots.partition_point(|&knot| knot < end);
        let mut knots = self.knots[..=count].to_vec();
        knots[count] = end;
        Self::from_segments(knots, self.segments[..count].to_vec())
    }

    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// Parameters at which segments meet.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Index of the segment that contains `t`; the first or last segment beyond the ends.
    #[inline]
    pub fn segment(&self, t: f64) -> usize {
        let bucket = ((t - self.knots[0]) * self.buckets_per_unit).max(0.0) as usize;
        let mut i = self.buckets[bucket.min(self.buckets.len() - 1)] as usize;
        while i + 1 < self.segments.len() && self.knots[i + 1] <= t {
            i += 1;
        }
        i
    }

    /// Power-basis coefficients of a segment in (t − its first knot), lowest order first.
    #[inline]
    pub fn coefficients(&self, segment: usize) -> &[[f64; D]; 4] {
        &self.segments[segment]
    }

    /// Point at `t`.
    #[inline]
    pub fn point(&self, t: f64) -> [f64; D] {
        let (start, end) = self.domain();
        let inside = t.clamp(start, end);
        if t != inside {
            return self.derivatives(t).0;
        }
        let i = self.segment(inside);
        let x = inside - self.knots[i];
        let c = &self.segments[i];
        std::array::from_fn(|k| c[0][k] + x * (c[1][k] + x * (c[2][k] + x * c[3][k])))
    }

    /// Point, first and second derivative at `t`.
    #[inline]
    pub fn derivatives(&self, t: f64) -> ([f64; D], [f64; D], [f64; D]) {
        let (start, end) = self.domain();
        let inside = t.clamp(start, end);
        let i = self.segment(inside);
        let x = inside - self.knots[i];
        let c = &self.segments[i];
        let (mut p, mut d1, mut d2) = ([0.0; D], [0.0; D], [0.0; D]);
        for k in 0..D {
            p[k] = c[0][k] + x * (c[1][k] + x * (c[2][k] + x * c[3][k]));
            d1[k] = c[1][k] + x * (2.0 * c[2][k] + x * 3.0 * c[3][k]);
            d2[k] = 2.0 * c[2][k] + 6.0 * x * c[3][k];
        }
        let beyond = t - inside;
        if beyond != 0.0 {
            for k in 0..D {
                p[k] += beyond * d1[k];
                d2[k] = 0.0;
            }
        }
        (p, d1, d2)
    }
}

/// Knots by accumulated chord length, starting at 0. The caller must remove repeated points first, as knots
/// must increase strictly.
pub fn chord_lengths<const D: usize>(points: &[[f64; D]]) -> Vec<f64> {
    let mut total = 0.0;
    let mut knots = vec![0.0];
    for pair in points.windows(2) {
        total += distance(&pair[0], &pair[1]);
        knots.push(total);
    }
    knots
}

/// Euclidean distance.
pub fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Power-basis coefficients of the cubic Hermite segment of length `h`.
fn hermite<const D: usize>(
    h: f64,
    p0: &[f64; D],
    p1: &[f64; D],
    m0: &[f64; D],
    m1: &[f64; D],
) -> [[f64; D]; 4] {
    let mut c = [[0.0; D]; 4];
    for k in 0..D {
        let chord = (p1[k] - p0[k]) / h;
        c[0][k] = p0[k];
        c[1][k] = m0[k];
        c[2][k] = (3.0 * chord - 2.0 * m0[k] - m1[k]) / h;
        c[3][k] = (m0[k] + m1[k] - 2.0 * chord) / (h * h);
    }
    c
}

/// Slopes of the C2 spline: a tridiagonal system with clamped ends, solved by the Thomas algorithm.
fn spline_slopes<const D: usize>(knots: &[f64], points: &[[f64; D]]) -> Vec<[f64; D]> {
    let n = points.len();
    let mut slopes = vec![[0.0; D]; n];
    for k in 0..D {
        slopes[0][k] = end_slope(knots, points, k, false);
        slopes[n - 1][k] = end_slope(knots, points, k, true);
    }
    if n < 3 {
        return slopes;
    }
    let mut upper = vec![0.0; n];
    let mut rhs = slopes.clone();
    for i in 1..n - 1 {
        let (h0, h1) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
        let (low, diagonal, high) = (h1, 2.0 * (h0 + h1), h0);
        let pivot = diagonal - low * upper[i - 1];
        upper[i] = high / pivot;
        for k in 0..D {
            let chord0 = (points[i][k] - points[i - 1][k]) / h0;
            let chord1 = (points[i + 1][k] - points[i][k]) / h1;
            let value = 3.0 * (h1 * chord0 + h0 * chord1);
            rhs[i][k] = (value - low * rhs[i - 1][k]) / pivot;
        }
    }
    for i in (1..n - 1).rev() {
        for k in 0..D {
            slopes[i][k] = rhs[i][k] - upper[i] * slopes[i + 1][k];
        }
    }
    slopes
}

/// Slope at an end of the polynomial through the outermost (up to four) points.
fn end_slope<const D: usize>(knots: &[f64], points: &[[f64; D]], k: usize, last: bool) -> f64 {
    let n = points.len();
    let count = n.min(4);
    let index = |i: usize| if last { n - 1 - i } else { i };
    // Newton's divided differences, differentiated at the first node.
    let t: Vec<f64> = (0..count).map(|i| knots[index(i)]).collect();
    let mut table: Vec<f64> = (0..count).map(|i| points[index(i)][k]).collect();
    let mut slope = 0.0;
    let mut product = 1.0;
    for order in 1..count {
        for i in 0..count - order {
            table[i] = (table[i + 1] - table[i]) / (t[i + order] - t[i]);
        }
        if order > 1 {
            product *= t[0] - t[order - 1];
        }
        slope += table[0] * product;
    }
    slope
}

/// Point of a B-spline at `t` in the knot span `span`, by de Boor's algorithm.
fn de_boor<const D: usize>(
    control: &[[f64; D]],
    degree: usize,
    knots: &[f64],
    span: usize,
    t: f64,
) -> [f64; D] {
    let mut d = [[0.0; D]; 4];
    for j in 0..=degree {
        d[j] = control[span - degree + j];
    }
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let i = span - degree + j;
            let span_width = knots[i + degree + 1 - r] - knots[i];
            let alpha = if span_width > 0.0 { (t - knots[i]) / span_width } else { 0.0 };
            for k in 0..D {
                d[j][k] = (1.0 - alpha) * d[j - 1][k] + alpha * d[j][k];
            }
        }
    }
    d[degree]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cubic_at(t: f64) -> [f64; 2] {
        [1.0 + t - 2.0 * t * t + 0.3 * t * t * t, 5.0 - t * t * t]
    }

    #[test]
    fn a_cubic_is_reproduced_with_its_derivatives() {
        let knots = [0.0, 0.4, 1.0, 1.7, 2.0, 3.1];
        let points: Vec<_> = knots.iter().map(|&t| cubic_at(t)).collect();
        let spline = Cubic::interpolate(&knots, &points);
        for i in 0..=100 {
            let t = 3.1 * f64::from(i) / 100.0;
            let (p, d1, d2) = spline.derivatives(t);
            let expected = cubic_at(t);
            assert!((p[0] - expected[0]).abs() < 1e-10 && (p[1] - expected[1]).abs() < 1e-10, "point at {t}");
            assert!((d1[0] - (1.0 - 4.0 * t + 0.9 * t * t)).abs() < 1e-9, "slope at {t}");
            assert!((d2[1] + 6.0 * t).abs() < 1e-8, "second derivative at {t}");
        }
    }

    #[test]
    fn a_clamped_b_spline_without_inner_knots_is_a_bezier_curve() {
        let control = [[0.0, 0.0], [1.0, 2.0], [3.0, 2.0], [4.0, 0.0]];
        let curve = Cubic::b_spline(&control, 3, &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        let p = curve.point(0.5);
        assert!((p[0] - 2.0).abs() < 1e-12 && (p[1] - 1.5).abs() < 1e-12, "{p:?}");
    }

    #[test]
    fn a_cut_curve_is_the_same_inside_and_straight_beyond() {
        let knots = [0.0, 0.4, 1.0, 1.7, 2.0, 3.1];
        let points: Vec<_> = knots.iter().map(|&t| cubic_at(t)).collect();
        let spline = Cubic::interpolate(&knots, &points);
        for (from, to) in [(0.3, 2.5), (0.4, 1.7), (0.45, 0.9)] {
            let cut = spline.starting_at(from).ending_at(to);
            assert_eq!(cut.domain(), (from, to));
            for i in 0..=20 {
                let t = from + (to - from) * f64::from(i) / 20.0;
                let (a, b) = (cut.point(t), spline.point(t));
                assert!((a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12, "at {t}");
            }
            let (end, direction, _) = spline.derivatives(to);
            let beyond = cut.point(to + 0.5);
            assert!((beyond[0] - end[0] - 0.5 * direction[0]).abs() < 1e-12, "straight beyond {to}");
        }
    }

    proptest! {
        #[test]
        fn splines_interpolate_and_are_smooth(values in prop::collection::vec(-10.0..10.0f64, 4..12)) {
            let knots: Vec<f64> = (0..values.len()).map(|i| i as f64 + 0.3 * (i as f64).sin()).collect();
            let points: Vec<[f64; 1]> = values.iter().map(|&v| [v]).collect();
            let spline = Cubic::interpolate(&knots, &points);
            for (knot, value) in knots.iter().zip(&values) {
                prop_assert!((spline.point(*knot)[0] - value).abs() < 1e-9);
            }
            for &knot in &knots[1..knots.len() - 1] {
                let (_, d1a, d2a) = spline.derivatives(knot - 1e-9);
                let (_, d1b, d2b) = spline.derivatives(knot + 1e-9);
                prop_assert!((d1a[0] - d1b[0]).abs() < 1e-5 && (d2a[0] - d2b[0]).abs() < 1e-4);
            }
        }
    }
}
