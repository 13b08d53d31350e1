//! Rational B-spline curves and surfaces: evaluation, derivatives and the nearest point.
//!
//! The algorithms are those of L. Piegl and W. Tiller, The NURBS Book, A2.1 to A2.3 and section 6.1.

use crate::geometry::{Point, Vector};

/// Intervals across a surface at whose ends the tangent planes along a straight line are compared.
const DEVELOPABLE_STEPS: usize = 24;
/// Largest sine of the angle between the tangent planes of one line.
const MAX_TWIST_SINE: f64 = 1e-5;
/// Largest degree.
pub const MAX_DEGREE: usize = 25;
/// Points nearer to the surface than this end the search that begins at the point before, mm.
const NEAR: f64 = 2e-3;
/// Largest number of seeds for the nearest point.
const MAX_SEEDS: usize = 4096;

/// Values and first derivatives of the basis functions that are not zero at a parameter.
struct Basis {
    /// Index of the first of them.
    first: usize,
    values: [f64; MAX_DEGREE + 1],
    slopes: [f64; MAX_DEGREE + 1],
}

/// Degree and knots of one parameter.
#[derive(Clone, Debug)]
pub struct Knots {
    degree: usize,
    knots: Vec<f64>,
    count: usize,
}

impl Knots {
    /// Knots for `count` control points.
    ///
    /// # Errors
    /// What is wrong where they do not fit together.
    pub fn new(degree: usize, knots: Vec<f64>, count: usize) -> Result<Self, String> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(format!("has the degree {degree}, which is not between 1 and {MAX_DEGREE}"));
        }
        if count <= degree || knots.len() != count + degree + 1 {
            let n = knots.len();
            return Err(format!("has {n} knots for {count} control points of degree {degree}"));
        }
        if knots.windows(2).any(|w| w[1] < w[0]) {
            return Err("has knots that decrease".to_owned());
        }
        let own = Self { degree, knots, count };
        let (low, high) = own.domain();
        if high - low > 1e-12 * low.abs().max(high.abs()) { Ok(own) } else { Err("has no extent".to_owned()) }
    }

    /// The parameter's range.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.count])
    }

    /// The distinct knots within the range.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..=self.count].to_vec();
        breaks.dedup();
        breaks
    }

    fn basis(&self, t: f64) -> Basis {
        let (p, k) = (self.degree, &self.knots);
        let (low, high) = self.domain();
        let t = t.clamp(low, high);
        // The last span of some length that begins at or before t.
        let span = (p + k[p..self.count].partition_point(|x| *x <= t)).saturating_sub(1).max(p);
        let mut basis =
            Basis { first: span - p, values: [0.0; MAX_DEGREE + 1], slopes: [0.0; MAX_DEGREE + 1] };
        basis.values[0] = 1.0;
        for j in 1..=p {
            if j == p {
                // Derivatives from the functions of the degree below.
                for i in 0..p {
                    let (left, right) = (k[span + 1 + i - p], k[span + 1 + i]);
                    let w = if right > left { p as f64 * basis.values[i] / (right - left) } else { 0.0 };
                    basis.slopes[i] -= w;
                    basis.slopes[i + 1] += w;
                }
            }
            let mut carried = 0.0;
            for i in 0..j {
                let (left, right) = (k[span + 1 + i - j], k[span + 1 + i]);
                let w = if right > left { basis.values[i] / (right - left) } else { 0.0 };
                basis.values[i] = carried + (right - t) * w;
                carried = (t - left) * w;
            }
            basis.values[j] = carried;
        }
        basis
    }
}

fn point(q: [f64; 4]) -> Point {
    Point::new(q[0] / q[3], q[1] / q[3], q[2] / q[3])
}

/// A curve.
#[derive(Clone, Debug)]
pub struct NurbsCurve {
    /// Degree and knots.
    pub knots: Knots,
    /// Control points, weighted: (w x, w y, w z, w).
    pub control: Vec<[f64; 4]>,
}

impl NurbsCurve {
    /// The point at a parameter.
    pub fn at(&self, t: f64) -> Point {
        let b = self.knots.basis(t);
        let mut q = [0.0; 4];
        for (value, c) in b.values[..=self.knots.degree].iter().zip(&self.control[b.first..]) {
            for m in 0..4 {
                q[m] += value * c[m];
            }
        }
        point(q)
    }
}

/// A surface.
#[derive(Clone, Debug)]
pub struct NurbsSurface {
    knots: [Knots; 2],
    /// Weighted control points, those along v together.
    control: Vec<[f64; 4]>,
    closed: [bool; 2],
    /// Parameters and points from which the search for the nearest point may begin.
    seeds: Vec<([f64; 2], Point)>,
}

impl NurbsSurface {
    /// The surface over weighted control points, those along v together.
    pub fn new(u: Knots, v: Knots, control: Vec<[f64; 4]>) -> Self {
        let mut own = Self { knots: [u, v], control, closed: [false; 2], seeds: Vec::new() };
        for i in 0..2 {
            let ((low, high), (from, to)) = (own.domain(i), own.domain(1 - i));
            let at = |t: f64, share: f64| {
                let s = from + (to - from) * share;
                own.at(if i == 0 { [t, s] } else { [s, t] })
            };
            let meets = [0.0, 0.3, 0.7, 1.0].iter().all(|s| (at(low, *s) - at(high, *s)).norm() < 1e-5);
            own.closed[i] = meets && (at(low, 0.5) - at(0.5 * (low + high), 0.5)).norm() > 1e-4;
        }
        let mut per_span = 2 * own.knots[0].degree.max(own.knots[1].degree).clamp(2, 4);
        let spans = |own: &Self, i: usize| own.knots[i].breaks().len() - 1;
        while per_span > 1 && per_span * per_span * spans(&own, 0) * spans(&own, 1) > MAX_SEEDS {
            per_span -= 1;
        }
        let grid = |own: &Self, i: usize| {
            let breaks = own.knots[i].breaks();
            let stride = (breaks.len() / 64).max(1);
            let mut grid = Vec::new();
            for w in breaks.windows(2).step_by(stride) {
                grid.extend((0..per_span).map(|k| w[0] + (w[1] - w[0]) * k as f64 / per_span as f64));
            }
            grid.extend(breaks.last());
            grid
        };
        for u in grid(&own, 0) {
            for v in grid(&own, 1) {
                own.seeds.push(([u, v], own.at([u, v])));
            }
        }
        own
    }

    /// The range of parameter `i`.
    pub fn domain(&self, i: usize) -> (f64, f64) {
        self.knots[i].domain()
    }

    /// Whether it closes along parameter `i`.
    pub fn closed(&self, i: usize) -> bool {
        self.closed[i]
    }

    /// Whether its lines of parameter `i` are straight and it has one tangent plane along each, as a
    /// cylinder, cone or plane has.
    pub fn is_developable(&self, i: usize) -> bool {
        if self.knots[i].degree != 1 || self.knots[i].count != 2 {
            return false;
        }
        let ((from, to), (low, high)) = (self.domain(i), self.domain(1 - i));
        let at = |share: f64, t: f64| {
            let s = low + (high - low) * share;
            let (p, pu, pv) = self.derivatives(if i == 0 { [t, s] } else { [s, t] });
            (p, if i == 0 { pv } else { pu })
        };
        (0..=DEVELOPABLE_STEPS).all(|k| {
            let share = k as f64 / DEVELOPABLE_STEPS as f64;
            let ((a, at_a), (b, at_b)) = (at(share, from), at(share, to));
            let [n, m] = [at_a, at_b].map(|d| d.cross(&(b - a)).try_normalize(1e-12));
            n.zip(m).is_none_or(|(n, m)| n.cross(&m).norm() < MAX_TWIST_SINE)
        })
    }

    /// The distinct knots of parameter `i`.
    pub fn breaks(&self, i: usize) -> Vec<f64> {
        self.knots[i].breaks()
    }

    /// The point at a parameter.
    pub fn at(&self, q: [f64; 2]) -> Point {
        self.derivatives(q).0
    }

    /// Point and first derivatives.
    pub fn derivatives(&self, q: [f64; 2]) -> (Point, Vector, Vector) {
        let (bu, bv) = (self.knots[0].basis(q[0]), self.knots[1].basis(q[1]));
        let columns = self.knots[1].count;
        let (mut p, mut pu, mut pv) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for i in 0..=self.knots[0].degree {
            let row = &self.control[(bu.first + i) * columns + bv.first..];
            let (mut r, mut rv) = ([0.0; 4], [0.0; 4]);
            for (j, c) in row[..=self.knots[1].degree].iter().enumerate() {
                for m in 0..4 {
                    r[m] += bv.values[j] * c[m];
                    rv[m] += bv.slopes[j] * c[m];
                }
            }
            for m in 0..4 {
                p[m] += bu.values[i] * r[m];
                pu[m] += bu.slopes[i] * r[m];
                pv[m] += bu.values[i] * rv[m];
            }
        }
        let at = point(p);
        let slope =
            |d: [f64; 4]| Vector::new(d[0] - at.x * d[3], d[1] - at.y * d[3], d[2] - at.z * d[3]) / p[3];
        (at, slope(pu), slope(pv))
    }

    /// The parameters within their ranges: a closed one wrapped, others clamped.
    pub fn within(&self, q: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| {
            let (low, high) = self.domain(i);
            if self.closed[i] { low + (q[i] - low).rem_euclid(high - low) } else { q[i].clamp(low, high) }
        })
    }

    /// Gauss-Newton iteration from `q`; returns the best parameters and their distance.
    fn improved(&self, p: &Point, mut q: [f64; 2]) -> ([f64; 2], f64) {
        let mut best = (q, f64::INFINITY);
        for _ in 0..30 {
            let (s, a, b) = self.derivatives(q);
            let r = p - s;
            if r.norm() < best.1 {
                best = (q, r.norm());
            }
            let (aa, ab, bb) = (a.dot(&a), a.dot(&b), b.dot(&b));
            let (ra, rb, det) = (r.dot(&a), r.dot(&b), aa * bb - ab * ab);
            let alone = |r: f64, d: f64| if d > 0.0 { r / d } else { 0.0 };
            let step = if det > 1e-14 * aa * bb {
                [(ra * bb - rb * ab) / det, (rb * aa - ra * ab) / det]
            } else {
                [alone(ra, aa), alone(rb, bb)]
            };
            let before = q;
            for i in 0..2 {
                let (low, high) = self.domain(i);
                q[i] += step[i].clamp(-0.25 * (high - low), 0.25 * (high - low));
            }
            q = self.within(q);
            let moved = (0..2).map(|i| (q[i] - before[i]).abs() / (self.domain(i).1 - self.domain(i).0));
            if moved.sum::<f64>() < 1e-13 {
                break;
            }
        }
        best
    }

    /// Parameters of the nearest point, sought from `hint` and, if that is not close, from the nearest seeds.
    pub fn nearest(&self, p: &Point, hint: Option<[f64; 2]>) -> [f64; 2] {
        let mut best = ([self.domain(0).0, self.domain(1).0], f64::INFINITY);
        if let Some(hint) = hint {
            best = self.improved(p, self.within(hint));
            if best.1 < NEAR {
                return best.0;
            }
        }
        let mut seeds: [(f64, [f64; 2]); 4] = [(f64::INFINITY, best.0); 4];
        for (q, s) in &self.seeds {
            let d = (s - p).norm_squared();
            if d < seeds[3].0 {
                seeds[3] = (d, *q);
                seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        for (_, seed) in seeds {
            let found = self.improved(p, seed);
            if found.1 < best.1 {
                best = found;
            }
            if best.1 < 0.1 * NEAR {
                break;
            }
        }
        best.0
    }
}
