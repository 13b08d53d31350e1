//! Blade sides: smooth surfaces lofted through span sections.

use crate::geometry::cubic::{Cubic, chord_lengths};
use crate::geometry::{Point, Vector, rotate_z, search};

/// Distance in u from an end beyond which the side is certainly flank.
const STEADY_U: f64 = 0.08;
/// Least turn of the direction of a side at a rounded end, rad.
const ROUND_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// One side of a blade: S(u, v) with u from LE (0) to TE (1) and v from hub (0) to shroud (1). C2 in u;
/// linear in v between two sections (a ruled blade), C2 in v through three or more. Extended linearly beyond
/// its borders in both directions.
#[derive(Clone, Debug)]
pub struct BladeSide {
    /// v of the sections, first 0, last 1.
    stations: Vec<f64>,
    /// Between neighbouring sections: both section curves in one spline (xyz, xyz) …
    spans: Vec<Cubic<6>>,
    /// … and, with three or more sections, their derivatives by v.
    slopes: Vec<Cubic<6>>,
}

impl BladeSide {
    /// Lofts through `sections` of equally many points at common parameters `u`; `stations` are
    /// the sections' v, increasing.
    pub fn loft(u: &[f64], stations: &[f64], sections: &[Vec<Point>]) -> Self {
        let pair = |a: &[[f64; 3]], b: &[[f64; 3]]| -> Cubic<6> {
            let joined: Vec<[f64; 6]> =
                a.iter().zip(b).map(|(p, q)| [p[0], p[1], p[2], q[0], q[1], q[2]]).collect();
            Cubic::interpolate(u, &joined)
        };
        let points: Vec<Vec<[f64; 3]>> =
            sections.iter().map(|s| s.iter().map(|p| [p.x, p.y, p.z]).collect()).collect();
        let spans = points.windows(2).map(|w| pair(&w[0], &w[1])).collect();
        let mut slopes = Vec::new();
        if sections.len() > 2 {
            // A spline's slopes are linear in its points, so they may be lofted in u like the points.
            let mut by_section = vec![Vec::with_capacity(u.len()); sections.len()];
            for i in 0..u.len() {
                let column: Vec<[f64; 3]> = points.iter().map(|s| s[i]).collect();
                let spline = Cubic::interpolate(stations, &column);
                for (slopes, &v) in by_section.iter_mut().zip(stations) {
                    slopes.push(spline.derivatives(v).1);
                }
            }
            slopes = by_section.windows(2).map(|w| pair(&w[0], &w[1])).collect();
        }
        Self { stations: stations.to_vec(), spans, slopes }
    }

    /// Whether the side is ruled (two sections).
    pub fn is_ruled(&self) -> bool {
        self.slopes.is_empty()
    }

    /// Values of v of its sections, from 0 to 1; the side is a polynomial in v between them.
    pub fn stations(&self) -> &[f64] {
        &self.stations
    }

    /// Values of u at which the side has points; suitable for mesh lines.
    pub fn u_knots(&self) -> &[f64] {
        self.spans[0].knots()
    }

    /// Point at u (0 LE … 1 TE) and v (0 on the hub … 1 at the shroud).
    #[inline]
    pub fn point(&self, u: f64, v: f64) -> Point {
        self.point_and_rise(u, v).0
    }

    /// Point and derivative by v.
    #[inline]
    pub fn point_and_rise(&self, u: f64, v: f64) -> (Point, Vector) {
        let between = self.between(v);
        let slopes = self.slopes.get(between.span).map(|slopes| slopes.point(u));
        let (point, rise) = between.blended(&self.spans[between.span].point(u), slopes.as_ref());
        (Point::from(point), rise)
    }

    /// Point and derivatives by u and v.
    #[inline]
    pub fn derivatives(&self, u: f64, v: f64) -> (Point, Vector, Vector) {
        let between = self.between(v);
        let (c, cu, _) = self.spans[between.span].derivatives(u);
        let slopes = self.slopes.get(between.span).map(|slopes| slopes.derivatives(u));
        let (point, pv) = between.blended(&c, slopes.as_ref().map(|(m, ..)| m));
        let (pu, _) = between.blended(&cu, slopes.as_ref().map(|(_, mu, _)| mu));
        (Point::from(point), pu, pv)
    }

    /// The sections between which `v` lies.
    #[inline]
    fn between(&self, v: f64) -> Between {
        let inside = v.clamp(0.0, 1.0);
        let mut span = 0;
        while span + 1 < self.spans.len() && self.stations[span + 1] <= inside {
            span += 1;
        }
        let (from, to) = (self.stations[span], self.stations[span + 1]);
        Between { span, from, height: to - from, inside, v }
    }

    /// The curve of constant `v`, prepared for a search along it.
    pub fn line(&self, v: f64) -> SideLine<'_> {
        let Between { span, from, height: h, .. } = self.between(v);
        let x = (v - from) / h;
        let (slopes, weights) = match self.slopes.get(span) {
            None => (None, [1.0 - x, x, 0.0, 0.0]),
            // Linear extension beyond the end sections.
            Some(slopes) if x < 0.0 => (Some(slopes), [1.0, 0.0, h * x, 0.0]),
            Some(slopes) if x > 1.0 => (Some(slopes), [0.0, 1.0, 0.0, h * (x - 1.0)]),
            Some(slopes) => (Some(slopes), hermite_weights(x, h)),
        };
        SideLine {
            span: &self.spans[span],
            slopes,
            weights,
            segment: usize::MAX,
            cubic: [Vector::zeros(); 4],
        }
    }

    /// Bounds on its second derivatives over u from `from` to `to`, which may lie beyond its ends.
    pub(super) fn bends(&self, from: f64, to: f64) -> SideBends {
        let (start, end) = self.u_range();
        let mut knots = self.u_knots().to_vec();
        if from < start {
            knots.insert(0, from);
        }
        if to > end {
            knots.push(to);
        }
        let split = |a: &[f64; 6]| [Vector::new(a[0], a[1], a[2]), Vector::new(a[3], a[4], a[5])];
        let of_span = |span: usize| {
            let height = self.stations[span + 1] - self.stations[span];
            let nodes = knots.iter().map(|&u| {
                let ends = |curve: &Cubic<6>| {
                    let (c, cu, cuu) = curve.derivatives(u);
                    [split(&c), split(&cu), split(&cuu)]
                };
                let slopes = self.slopes.get(span).map(ends);
                BendNode::new(&ends(&self.spans[span]), slopes.as_ref(), height)
            });
            let nodes: Vec<BendNode> = nodes.collect();
            let patch = |k: usize| {
                let (a, b) = (&nodes[k], &nodes[k + 1]);
                let is_beyond = knots[k + 1] <= start || knots[k] >= end;
                let along = std::array::from_fn(|i| if i < 4 { a.along[i] } else { b.along[i - 4] });
                let third = (knots[k + 1] - knots[k]) / 3.0;
                let cubic = |i: usize| {
                    let inner = [a.across[i] + a.turns[i] * third, b.across[i] - b.turns[i] * third];
                    [a.across[i], inner[0], inner[1], b.across[i]]
                };
                let across = [cubic(0), cubic(1)];
                PatchBends {
                    along: if is_beyond { [Vector::zeros(); 8] } else { along },
                    across: std::array::from_fn(|i| across[i / 4][i % 4]),
                }
            };
            (0..knots.len() - 1).map(patch).collect()
        };
        let patches = (0..self.spans.len()).map(of_span).collect();
        SideBends { stations: self.stations.clone(), patches, knots }
    }

    /// The side rotated by `angle_rad` about Z.
    pub fn rotated(&self, angle_rad: f64) -> Self {
        let u = self.u_knots().to_vec();
        let sections: Vec<Vec<Point>> = self
            .stations
            .iter()
            .map(|&v| u.iter().map(|&u| rotate_z(&self.point(u, v), angle_rad)).collect())
            .collect();
        Self::loft(&u, &self.stations, &sections)
    }

    /// First and last u of the surface; beyond them it is extended linearly.
    pub fn u_range(&self) -> (f64, f64) {
        self.spans[0].domain()
    }

    /// Whether the side is rounded at its trailing edge.
    pub fn has_round_tail(&self) -> bool {
        let direction = |u: f64| self.derivatives(u, 0.5).1;
        direction(1.0).angle(&direction(1.0 - STEADY_U)) > ROUND_RAD
    }

    /// The side without its rounded ends: from where its direction comes within 10° of that at 8 % of the
    /// chord, to where it departs from that at 92 % by as much, extended linearly beyond both. An end is
    /// round where its direction turns by more than 30°; a blunt end with a corner and a sharp one are kept.
    pub fn flank(&self) -> Self {
        const STEPS: usize = 60;
        const STEADY_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
        // Length in u of the rounded end at u = `end` on the line `v`; `None` where that end is not round.
        let round = |end: f64, v: f64| {
            let u = |distance: f64| (end - distance).abs();
            let (_, steady, _) = self.derivatives(u(STEADY_U), v);
            let bend = |distance: f64| self.derivatives(u(distance), v).1.angle(&steady) - STEADY_RAD;
            if bend(0.0) < ROUND_RAD - STEADY_RAD {
                return None;
            }
            let at = |i: usize| STEADY_U * i as f64 / STEPS as f64;
            let last = (0..STEPS).rev().find(|&i| bend(at(i)) > 0.0)?;
            // Refined to the root: much depends on this border, and on a grid it would jump as the part
            // changes.
            Some(search::root(bend, at(last), at(last + 1), 1e-9))
        };
        let longest = |end: f64| [0.0, 0.5, 1.0].into_iter().filter_map(|v| round(end, v)).reduce(f64::max);
        let (nose, tail) = (longest(0.0), longest(1.0));
        let cut = |curves: &[Cubic<6>]| {
            let curves = curves.iter().map(|curve| {
                let curve = nose.map_or_else(|| curve.clone(), |length| curve.starting_at(length));
                tail.map_or_else(|| curve.clone(), |length| curve.ending_at(1.0 - length))
            });
            curves.collect()
        };
        Self { stations: self.stations.clone(), spans: cut(&self.spans), slopes: cut(&self.slopes) }
    }
}

/// Second derivatives of a side, patch by patch between its knots and stations.
#[derive(Debug)]
pub(super) struct SideBends {
    knots: Vec<f64>,
    stations: Vec<f64>,
    /// Per span between stations, those between knots.
    patches: Vec<Vec<PatchBends>>,
}

/// Vectors whose hull holds the second derivatives of a patch by u, and by v. That by u is linear in u and
/// cubic in v, that by v cubic in u and linear in v: these are their Bézier points.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchBends {
    pub along: [Vector; 8],
    pub across: [Vector; 8],
}

impl SideBends {
    /// The patches that a rectangle of u and v meets.
    pub fn of_cell(&self, u: [f64; 2], v: [f64; 2]) -> impl Iterator<Item = &PatchBends> {
        let met = |breaks: &[f64], [from, to]: [f64; 2]| {
            let first = breaks.partition_point(|&x| x <= from).clamp(1, breaks.len() - 1) - 1;
            first..breaks.partition_point(|&x| x < to).clamp(first + 1, breaks.len() - 1)
        };
        let (segments, spans) = (met(&self.knots, u), met(&self.stations, v));
        self.patches[spans].iter().flat_map(move |span| &span[segments.clone()])
    }
}

/// Second derivatives at one u: that by u as Bézier points over v, that by v at both stations with its
/// derivative by u.
struct BendNode {
    along: [Vector; 4],
    across: [Vector; 2],
    turns: [Vector; 2],
}

impl BendNode {
    /// From points and, with three or more sections, their derivatives by v on both stations: values, first
    /// and second derivatives by u.
    fn new(points: &[[Vector; 2]; 3], slopes: Option<&[[Vector; 2]; 3]>, height: f64) -> Self {
        let [p0, p1] = points[2];
        let Some(slopes) = slopes else {
            let none = [Vector::zeros(); 2];
            return Self { along: [p0, p0, p1, p1], across: none, turns: none };
        };
        let [m0, m1] = slopes[2].map(|slope| slope * (height / 3.0));
        let by_v = |order: usize| {
            let ([p0, p1], [m0, m1]) = (points[order], slopes[order]);
            let chord = (p1 - p0) * (6.0 / (height * height));
            [chord - (m0 * 4.0 + m1 * 2.0) / height, (m0 * 2.0 + m1 * 4.0) / height - chord]
        };
        Self { along: [p0, p0 + m0, p1 - m1, p1], across: by_v(0), turns: by_v(1) }
    }
}

/// A value of v and the two sections it lies between, or beyond which it lies.
struct Between {
    /// Number of the lower section.
    span: usize,
    /// v of the lower section, and how much higher that of the upper one is.
    from: f64,
    height: f64,
    /// `v` within 0…1.
    inside: f64,
    v: f64,
}

impl Between {
    /// Value and derivative by v, given the values on both sections and, with three or more sections, their
    /// derivatives by v.
    #[inline]
    fn blended(&self, values: &[f64; 6], slopes: Option<&[f64; 6]>) -> (Vector, Vector) {
        let split = |a: &[f64; 6]| (Vector::new(a[0], a[1], a[2]), Vector::new(a[3], a[4], a[5]));
        let (p0, p1) = split(values);
        let h = self.height;
        let Some(slopes) = slopes else {
            return (p0 + (p1 - p0) * ((self.v - self.from) / h), (p1 - p0) / h);
        };
        let (m0, m1) = split(slopes);
        let x = (self.inside - self.from) / h;
        let [b0, b1, s0, s1] = hermite_weights(x, h);
        let mut value = p0 * b0 + p1 * b1 + m0 * s0 + m1 * s1;
        let x2 = x * x;
        let (d0, e0, e1) = (6.0 * (x2 - x) / h, 3.0 * x2 - 4.0 * x + 1.0, 3.0 * x2 - 2.0 * x);
        let rise = (p0 - p1) * d0 + m0 * e0 + m1 * e1;
        let beyond = self.v - self.inside;
        if beyond != 0.0 {
            value += rise * beyond;
        }
        (value, rise)
    }
}

/// Weights of a Hermite cubic at the share `x` of an interval of length `h`: of the values at both its ends,
/// and of the derivatives there.
#[inline]
fn hermite_weights(x: f64, h: f64) -> [f64; 4] {
    let (x2, x3) = (x * x, x * x * x);
    [2.0 * x3 - 3.0 * x2 + 1.0, -2.0 * x3 + 3.0 * x2, h * (x3 - 2.0 * x2 + x), h * (x3 - x2)]
}

/// A line of constant v of a side. At constant v the loft is one cubic in u per segment: its coefficients are
/// blended once per segment, not once per point.
#[derive(Debug)]
pub struct SideLine<'a> {
    span: &'a Cubic<6>,
    slopes: Option<&'a Cubic<6>>,
    /// Hermite weights of both sections, and of their derivatives by v.
    weights: [f64; 4],
    /// Segment of which `cubic` holds the coefficients.
    segment: usize,
    cubic: [Vector; 4],
}

impl SideLine<'_> {
    /// Point, first and second derivative by u.
    #[inline]
    pub fn at(&mut self, u: f64) -> (Point, Vector, Vector) {
        let (start, end) = self.span.domain();
        let inside = u.clamp(start, end);
        let segment = self.span.segment(inside);
        if segment != self.segment {
            self.blend(segment);
        }
        let x = inside - self.span.knots()[segment];
        let [c0, c1, c2, c3] = self.cubic;
        let slope = c1 + (c2 * 2.0 + c3 * (3.0 * x)) * x;
        let point = c0 + (c1 + (c2 + c3 * x) * x) * x;
        let beyond = u - inside;
        if beyond != 0.0 {
            return (Point::from(point + slope * beyond), slope, Vector::zeros());
        }
        (Point::from(point), slope, c2 * 2.0 + c3 * (6.0 * x))
    }

    fn blend(&mut self, segment: usize) {
        let [b0, b1, s0, s1] = self.weights;
        let c = self.span.coefficients(segment);
        let m = self.slopes.map(|slopes| slopes.coefficients(segment));
        for order in 0..4 {
            for k in 0..3 {
                let mut blended = b0 * c[order][k] + b1 * c[order][k + 3];
                if let Some(m) = m {
                    blended += s0 * m[order][k] + s1 * m[order][k + 3];
                }
                self.cubic[order][k] = blended;
            }
        }
        self.segment = segment;
    }
}

/// Common parameters and sections of one side from raw section points (which may differ in number):
/// normalised chord length, averaged over the sections. Repeated points are dropped.
pub(super) fn common_parameters(sections: &[Vec<Point>]) -> (Vec<f64>, Vec<Vec<Point>>) {
    let raw: Vec<Vec<[f64; 3]>> = sections
        .iter()
        .map(|s| {
            let mut points: Vec<[f64; 3]> = s.iter().map(|p| [p.x, p.y, p.z]).collect();
            if sections.iter().any(|other| other.len() != s.len()) {
                points.dedup_by(|a, b| crate::geometry::cubic::distance(a, b) < 1e-9);
            }
            points
        })
        .collect();
    let normalised = |points: &[[f64; 3]]| -> Vec<f64> {
        let knots = chord_lengths(points);
        let total = knots[knots.len() - 1];
        knots.iter().map(|k| k / total).collect()
    };
    let same_count = raw.iter().all(|s| s.len() == raw[0].len());
    if same_count {
        let all: Vec<Vec<f64>> = raw.iter().map(|s| normalised(s)).collect();
        let n = raw[0].len();
        let mean: Vec<f64> =
            (0..n).map(|i| all.iter().map(|k| k[i]).sum::<f64>() / all.len() as f64).collect();
        // A point repeated in every section has no parameter of its own.
        let keep: Vec<usize> = (0..n).filter(|&i| i == 0 || mean[i] > mean[i - 1] + 1e-9).collect();
        let u = keep.iter().map(|&i| mean[i]).collect();
        let sections = sections.iter().map(|s| keep.iter().map(|&i| s[i]).collect()).collect();
        return (u, sections);
    }
    let densest = raw.iter().max_by_key(|s| s.len()).unwrap_or(&raw[0]);
    let u = normalised(densest);
    let resampled = raw
        .iter()
        .map(|s| {
            let spline = Cubic::interpolate(&normalised(s), s);
            u.iter().map(|&t| Point::from(Vector::from(spline.point(t)))).collect()
        })
        .collect();
    (u, resampled)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A side through `count` sections that is curved in both directions.
    fn side(count: usize) -> BladeSide {
        let u: Vec<f64> = (0..=12).map(|i| f64::from(i) / 12.0).collect();
        let stations: Vec<f64> = (0..count).map(|j| j as f64 / (count - 1) as f64).collect();
        let sections: Vec<Vec<Point>> = stations
            .iter()
            .map(|v| u.iter().map(|u| Point::new(40.0 * u, 9.0 * (u * u + v * v), 20.0 * v - u)).collect())
            .collect();
        BladeSide::loft(&u, &stations, &sections)
    }

    #[test]
    fn a_line_is_the_side_at_its_v() {
        for side in [side(2), side(5), side(4).flank()] {
            for v in [-0.2, 0.0, 0.13, 0.5, 0.77, 1.0, 1.1] {
                let mut line = side.line(v);
                for i in -3..=23 {
                    let u = f64::from(i) / 20.0;
                    let (p, pu, _) = side.derivatives(u, v);
                    let (q, qu, quu) = line.at(u);
                    assert!((p - q).norm() < 1e-11 && (pu - qu).norm() < 1e-9, "at ({u}, {v})");
                    let step = 1e-5;
                    let by_difference = (line.at(u + step).1 - line.at(u - step).1) / (2.0 * step);
                    let at_knot = side.u_knots().iter().any(|knot| (knot - u).abs() < 2.0 * step);
                    assert!(at_knot || (by_difference - quu).norm() < 1e-3, "second at ({u}, {v})");
                }
            }
        }
    }
}
