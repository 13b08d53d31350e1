//! One-sided envelope line of a plane curve (\[assessment paper\], fig. 5): the straight line that is nowhere
//! below the curve and has the smallest maximum gap to it.

/// A straight line y = `offset` + `slope` · x above a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvelopeLine {
    /// y at x = 0.
    pub offset: f64,
    /// dy/dx.
    pub slope: f64,
    /// Maximum gap between line and curve, measured along y.
    pub gap: f64,
}

impl EnvelopeLine {
    /// y of the line at `x`.
    pub fn y_at(&self, x: f64) -> f64 {
        self.offset + self.slope * x
    }
}

/// The envelope line above a densely sampled curve of (x, y) points; `None` for fewer than two points of
/// different x.
///
/// For a given slope, the line rests on the upper convex hull, and its gap is the width of the curve between
/// two lines of that slope. This width is convex and piecewise linear in the slope, with breakpoints where
/// one of the lines contains a hull edge. So the best slope is that of an edge of the upper *or* the lower
/// hull; for a curve that bows towards the line, it is that of the chord, a lower edge.
pub fn envelope_above(points: &[[f64; 2]]) -> Option<EnvelopeLine> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let (upper, lower) = (half_hull(&sorted, 1.0), half_hull(&sorted, -1.0));
    let line = |slope: f64| {
        let height = |p: &[f64; 2]| p[1] - slope * p[0];
        let offset = upper.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
        let lowest = lower.iter().map(height).fold(f64::INFINITY, f64::min);
        EnvelopeLine { offset, slope, gap: offset - lowest }
    };
    let reach = sorted.last()?[0] - sorted.first()?[0];
    let slopes = upper.windows(2).chain(lower.windows(2)).filter_map(|edge| {
        let (dx, dy) = (edge[1][0] - edge[0][0], edge[1][1] - edge[0][1]);
        // Vertical edges occur only at the ends of the curve, and have no slope.
        (dx > 1e-12 * reach).then_some(dy / dx)
    });
    slopes
        .map(line)
        .min_by(|a, b| a.gap.total_cmp(&b.gap).then(a.slope.abs().total_cmp(&b.slope.abs())))
        .filter(|line| line.gap.is_finite())
}

/// The upper (`side` +1) or lower (−1) half of the convex hull of points sorted by x (Andrew's monotone
/// chain).
fn half_hull(sorted: &[[f64; 2]], side: f64) -> Vec<[f64; 2]> {
    let mut hull: Vec<[f64; 2]> = Vec::with_capacity(sorted.len());
    for &p in sorted {
        while let [.., a, b] = hull[..] {
            let turn = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
            if side * turn < 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(p);
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sampled(count: usize, y: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        (0..=count).map(|i| i as f64 / count as f64).map(|x| [x, y(x)]).collect()
    }

    #[test]
    fn a_bow_towards_the_line_is_met_by_its_chord() {
        for count in [16, 17, 64, 201] {
            let bow = sampled(count, |x| 0.8 * (std::f64::consts::PI * x).sin());
            let line = envelope_above(&bow).expect("a curve");
            let top = bow.iter().map(|p| p[1]).fold(0.0, f64::max);
            assert!((line.gap - top).abs() < 1e-12 && line.slope.abs() < 1e-12, "{line:?} over {top}");
        }
        let line =
            envelope_above(&sampled(200, |x| 0.8 * (std::f64::consts::PI * x).sin())).expect("a curve");
        assert!((line.gap - 0.8).abs() < 5e-5, "{line:?}");
    }

    #[test]
    fn a_bow_away_from_the_line_is_bridged_by_its_chord() {
        let bow = sampled(100, |x| 0.3 * x - 0.8 * (std::f64::consts::PI * x).sin());
        let line = envelope_above(&bow).expect("a curve");
        assert!((line.gap - 0.8).abs() < 1e-12 && (line.slope - 0.3).abs() < 1e-12, "{line:?}");
    }

    #[test]
    fn what_has_no_length_has_no_line() {
        assert_eq!(envelope_above(&[]), None);
        assert_eq!(envelope_above(&[[1.0, 2.0]]), None);
        assert_eq!(envelope_above(&[[1.0, 2.0], [1.0, 3.0], [1.0, 2.5]]), None);
        assert_eq!(envelope_above(&[[0.0, f64::NAN], [1.0, 3.0]]), None);
    }

    proptest! {
        #[test]
        fn no_other_slope_does_better(
            heights in prop::collection::vec(-1.0..1.0f64, 2..30),
            folds in prop::collection::vec(0.0..1.0f64, 30),
        ) {
            let points: Vec<[f64; 2]> = heights.iter().zip(&folds)
                .enumerate().map(|(i, (&y, &x))| [x + 0.1 * i as f64, y]).collect();
            let line = envelope_above(&points).expect("points differ in x");
            for p in &points {
                let over = line.y_at(p[0]) - p[1];
                prop_assert!(over > -1e-9 && over < line.gap + 1e-9, "{over} of {line:?} at {p:?}");
            }
            for i in -4000..=4000 {
                let slope = line.slope + 0.005 * f64::from(i);
                let y = points.iter().map(|p| p[1] - slope * p[0]);
                let width = y.clone().fold(f64::NEG_INFINITY, f64::max) - y.fold(f64::INFINITY, f64::min);
                prop_assert!(width > line.gap - 1e-9, "slope {slope} leaves {width}, {line:?}");
            }
        }
    }
}
