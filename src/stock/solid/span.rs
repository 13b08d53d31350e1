//! Spans: the stretches of one ray that are stock, with what bounds them.

use crate::geometry::Vector;

/// Steps of a normal's two octahedral coordinates per unit.
const NORMAL_STEPS: f64 = 32_000.0;

/// What bounds a span at one end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpanEnd {
    /// Unit normal out of the stock as octahedral coordinates, which resolve 1e-4 rad.
    normal: [i16; 2],
    /// Number of the move that cut it; [`SpanEnd::BLANK`] on the surface of the blank.
    pub cut_by: u32,
}

impl SpanEnd {
    /// The value of `cut_by` on the surface of the blank.
    pub const BLANK: u32 = u32::MAX;

    /// An end with the unit `normal` out of the stock, left by move `cut_by`.
    pub fn new(normal: &Vector, cut_by: u32) -> Self {
        // Octahedral map: the sphere onto the octahedron |x| + |y| + |z| = 1, its lower half unfolded.
        let scale = (normal.x.abs() + normal.y.abs() + normal.z.abs()).max(1e-300);
        let (mut x, mut y) = (normal.x / scale, normal.y / scale);
        if normal.z < 0.0 {
            (x, y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
        }
        // Rounds by cutting off, which is one instruction.
        let stored = |v: f64| (v * NORMAL_STEPS + 0.5f64.copysign(v)) as i16;
        Self { normal: [stored(x), stored(y)], cut_by }
    }

    /// Unit normal out of the stock.
    pub fn normal(&self) -> Vector {
        let [mut x, mut y] = self.normal.map(|v| f64::from(v) / NORMAL_STEPS);
        let z = 1.0 - x.abs() - y.abs();
        if z < 0.0 {
            (x, y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
        }
        Vector::new(x, y, z).normalize()
    }
}

/// A stretch of a ray in stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Coordinate along the ray where the stock begins, mm.
    pub from: f64,
    /// Coordinate where it ends, mm; more than `from`.
    pub to: f64,
    /// The surface at `from`.
    pub start: SpanEnd,
    /// The surface at `to`.
    pub end: SpanEnd,
}

/// Removes the open interval (`low`, `high`) from the sorted, disjoint `spans` of a ray; `mark(at_high)`
/// gives the surface that the cut leaves at its ends. Returns whether anything was removed.
///
/// The ends of what remains are exactly those of the blank and of the cuts, so the result does not depend on
/// the order of the cuts.
pub fn cut(spans: &mut Vec<Span>, low: f64, high: f64, mut mark: impl FnMut(bool) -> SpanEnd) -> bool {
    // Spans before `first` end before the cut, those from `last` on begin after it.
    let first = spans.iter().position(|span| span.to > low).unwrap_or(spans.len());
    let last = first + spans[first..].iter().take_while(|span| span.from < high).count();
    if first == last || low >= high {
        return false;
    }
    let (head, tail) = (spans[first], spans[last - 1]);
    let before = (head.from < low).then(|| Span { to: low, end: mark(false), ..head });
    let behind = (tail.to > high).then(|| Span { from: high, start: mark(true), ..tail });
    match (before, behind) {
        (Some(before), Some(behind)) if last - first == 1 => {
            spans[first] = before;
            spans.insert(first + 1, behind);
        }
        _ => {
            let mut at = first;
            for kept in [before, behind].into_iter().flatten() {
                spans[at] = kept;
                at += 1;
            }
            spans.drain(at..last);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(from: f64, to: f64) -> Span {
        let end = SpanEnd::new(&Vector::z(), SpanEnd::BLANK);
        Span { from, to, start: end, end }
    }

    fn after(cuts: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let mut spans = vec![span(0.0, 10.0), span(20.0, 30.0)];
        for &(low, high) in cuts {
            cut(&mut spans, low, high, |_| SpanEnd::new(&Vector::x(), 1));
        }
        spans.iter().map(|span| (span.from, span.to)).collect()
    }

    #[test]
    fn a_cut_removes_its_interval_and_no_more() {
        assert_eq!(after(&[(12.0, 18.0)]), [(0.0, 10.0), (20.0, 30.0)]);
        assert_eq!(after(&[(-5.0, 4.0)]), [(4.0, 10.0), (20.0, 30.0)]);
        assert_eq!(after(&[(3.0, 4.0)]), [(0.0, 3.0), (4.0, 10.0), (20.0, 30.0)]);
        assert_eq!(after(&[(8.0, 25.0)]), [(0.0, 8.0), (25.0, 30.0)]);
        assert_eq!(after(&[(-1.0, 31.0)]), []);
        assert_eq!(after(&[(0.0, 10.0)]), [(20.0, 30.0)]);
        assert_eq!(after(&[(5.0, 5.0)]), [(0.0, 10.0), (20.0, 30.0)]);
        assert_eq!(after(&[(3.0, 4.0), (6.0, 7.0)]), after(&[(6.0, 7.0), (3.0, 4.0)]));
    }

    #[test]
    fn normals_survive_their_packing() {
        for i in 0..200 {
            let (a, z) = (2.4 * f64::from(i), f64::from(i) / 99.5 - 1.0);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let normal = Vector::new(r * a.cos(), r * a.sin(), z);
            assert!(SpanEnd::new(&normal, 0).normal().angle(&normal) < 1e-4, "{normal:?}");
        }
    }
}
