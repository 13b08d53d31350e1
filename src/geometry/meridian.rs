//! Meridional curves by arc length: the generatrices of hub, shroud and their offset surfaces.

use super::cubic::{Cubic, chord_lengths};
use super::{Meridional, norm2, search};

/// A C2 curve in the meridional plane, parametrised by arc length t (mm) from its start, with one side
/// defined as the outer side. It is extended beyond its ends by its tangents.
#[derive(Clone, Debug)]
pub struct MeridionalCurve {
    /// Power-basis coefficients of equally long segments.
    segments: Vec<[[f64; 2]; 4]>,
    /// Points at equal arc lengths, from which a projection starts.
    samples: Vec<[f64; 2]>,
    step: f64,
    per_step: f64,
    length: f64,
    /// +1: the normal is the tangent rotated by +90° (from r towards z); −1: by −90°.
    side: f64,
}

/// A point of a curve with its tangent, normal and curvature.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoint {
    /// The point, mm.
    pub point: Meridional,
    /// Unit tangent, in the direction of increasing t.
    pub tangent: Meridional,
    /// Unit normal on the outer side.
    pub normal: Meridional,
    /// Curvature, 1/mm: positive where the curve bends towards its normal.
    pub curvature: f64,
}

/// Newton step in arc length, mm, below which a projection has converged: the remaining error in arc length
/// is of second order in the step, that in the distance of fourth order.
const PROJECTION_STEP: f64 = 1e-4;
/// The same where steps are limited near a centre of curvature, as convergence is only linear there.
const LIMITED_PROJECTION_STEP: f64 = 1e-6;
/// Minimum divisor of a Newton step, as a share of the squared speed.
const MIN_BEND: f64 = 0.25;
/// Share of the length up to which a point past the end is projected onto the end.
const AT_END: f64 = 1e-4;
/// Number of intervals between the start points of a projection.
const PROJECTION_SAMPLES: usize = 48;

impl MeridionalCurve {
    /// Converts a curve of any parametrisation. `segments` of equal arc length are interpolated through exact
    /// points; with some hundreds of them the deviation is far below a nanometre.
    pub fn from_cubic(curve: &Cubic<2>, segments: usize) -> Self {
        let (lengths, parameters) = arc_length_table(curve);
        let total = lengths[lengths.len() - 1];
        let mut at = 0;
        let points: Vec<[f64; 2]> = (0..=segments)
            .map(|i| {
                let wanted = total * i as f64 / segments as f64;
                while at + 2 < lengths.len() && lengths[at + 1] < wanted {
                    at += 1;
                }
                // Newton iteration on the arc length inside one table interval.
                let share = (wanted - lengths[at]) / (lengths[at + 1] - lengths[at]);
                let mut t = parameters[at] + share * (parameters[at + 1] - parameters[at]);
                for _ in 0..3 {
                    let speed = speed(curve, t);
                    if speed > 0.0 {
                        t -= (lengths[at] + gauss_length(curve, parameters[at], t) - wanted) / speed;
                    }
                }
                curve.point(t)
            })
            .collect();
        let knots: Vec<f64> = (0..=segments).map(|i| total * i as f64 / segments as f64).collect();
        Self::from_uniform(&Cubic::interpolate(&knots, &points), total)
    }

    /// The interpolating curve through `points` (mm); neighbouring points must differ.
    pub fn through(points: &[Meridional]) -> Self {
        let raw: Vec<[f64; 2]> = points.iter().map(|p| [p.r, p.z]).collect();
        let curve = Cubic::interpolate(&chord_lengths(&raw), &raw);
        Self::from_cubic(&curve, (4 * raw.len()).clamp(256, 2048))
    }

    fn from_uniform(curve: &Cubic<2>, length: f64) -> Self {
        let knots = curve.knots();
        let count = knots.len() - 1;
        let segments = (0..count)
            .map(|i| {
                let (p, d1, d2) = curve.derivatives(knots[i]);
                let (q, ..) = curve.derivatives(knots[i + 1]);
                let h = knots[i + 1] - knots[i];
                let mut c = [p, d1, [d2[0] / 2.0, d2[1] / 2.0], [0.0; 2]];
                for k in 0..2 {
                    c[3][k] = (q[k] - p[k] - h * (d1[k] + h * c[2][k])) / (h * h * h);
                }
                c
            })
            .collect();
        let step = length / count as f64;
        let mut curve = Self { segments, samples: Vec::new(), step, per_step: 1.0 / step, length, side: 1.0 };
        let looks = PROJECTION_SAMPLES.min(count);
        curve.samples = (0..=looks).map(|i| curve.raw(length * i as f64 / looks as f64).0).collect();
        curve
    }

    /// The same curve with its outer side towards the point `outside`.
    pub fn with_outer_side_towards(mut self, outside: Meridional) -> Self {
        let (t, _) = self.project(outside);
        let here = self.at(t);
        let towards = (outside.r - here.point.r) * here.normal.r + (outside.z - here.point.z) * here.normal.z;
        if towards < 0.0 {
            self.side = -self.side;
        }
        self
    }

    /// The same curve with its outer side towards most of `points`, by the sum of their distances. Their mean
    /// may be on the other side of a bent curve.
    pub fn with_outer_side_towards_most(mut self, points: &[Meridional]) -> Self {
        if points.iter().map(|p| self.project(*p).1).sum::<f64>() < 0.0 {
            self.side = -self.side;
        }
        self
    }

    /// Arc length from start to end, mm.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The segment at an arc length within the curve, and the arc length from its start.
    #[inline]
    fn segment(&self, inside: f64) -> (&[[f64; 2]; 4], f64) {
        let i = ((inside * self.per_step) as usize).min(self.segments.len() - 1);
        (&self.segments[i], inside - i as f64 * self.step)
    }

    #[inline]
    fn raw(&self, t: f64) -> ([f64; 2], [f64; 2], [f64; 2]) {
        let inside = t.clamp(0.0, self.length);
        let (c, x) = self.segment(inside);
        let (mut p, mut d1, mut d2) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for k in 0..2 {
            p[k] = c[0][k] + x * (c[1][k] + x * (c[2][k] + x * c[3][k]));
            d1[k] = c[1][k] + x * (2.0 * c[2][k] + x * 3.0 * c[3][k]);
            d2[k] = 2.0 * c[2][k] + 6.0 * x * c[3][k];
        }
        let beyond = t - inside;
        if beyond != 0.0 {
            for k in 0..2 {
                p[k] += beyond * d1[k];
                d2[k] = 0.0;
            }
        }
        (p, d1, d2)
    }

    /// Point at arc length `t`, mm.
    #[inline]
    pub fn point(&self, t: f64) -> Meridional {
        let (p, ..) = self.raw(t);
        Meridional { r: p[0], z: p[1] }
    }

    /// Point, tangent, normal and curvature at arc length `t`, mm.
    #[inline]
    pub fn at(&self, t: f64) -> CurvePoint {
        let (p, d1, d2) = self.raw(t);
        let speed = norm2(d1[0], d1[1]);
        let tangent = Meridional { r: d1[0] / speed, z: d1[1] / speed };
        let normal = Meridional { r: -self.side * tangent.z, z: self.side * tangent.r };
        let curvature = (d2[0] * normal.r + d2[1] * normal.z) / (speed * speed);
        CurvePoint { point: Meridional { r: p[0], z: p[1] }, tangent, normal, curvature }
    }

    /// Point of the curve offset by `distance` mm to its outer side, and its derivative with respect to t.
    #[inline]
    pub fn offset_derivative(&self, t: f64, distance: f64) -> (Meridional, Meridional) {
        let (p, d1, d2) = self.raw(t);
        let per_speed = 1.0 / norm2(d1[0], d1[1]);
        let (nr, nz) = (-self.side * d1[1] * per_speed, self.side * d1[0] * per_speed);
        let stretch = 1.0 - distance * (d2[0] * nr + d2[1] * nz) * per_speed * per_speed;
        (
            Meridional { r: p[0] + distance * nr, z: p[1] + distance * nz },
            Meridional { r: d1[0] * stretch, z: d1[1] * stretch },
        )
    }

    /// Projects a point onto the curve between its ends, by Newton iteration from the nearest sample: (arc
    /// length t in mm, signed distance in mm, positive on the outer side).
    pub fn project(&self, to: Meridional) -> (f64, f64) {
        // The distances first: without a branch between them they are computed several at a time.
        let mut distances = [0.0; PROJECTION_SAMPLES + 1];
        let squared = &mut distances[..self.samples.len()];
        for (squared, p) in squared.iter_mut().zip(&self.samples) {
            let (dr, dz) = (p[0] - to.r, p[1] - to.z);
            *squared = dr * dr + dz * dz;
        }
        let mut best = (f64::INFINITY, 0);
        for (i, &d) in squared.iter().enumerate() {
            if d < best.0 {
                best = (d, i);
            }
        }
        let apart = self.length / (self.samples.len() - 1) as f64;
        let mut found = self.project_near(to, apart * best.1 as f64, apart);
        // Other local minima among the samples may be nearer between two samples.
        let worth = found.1.abs() + 0.5 * apart;
        let last = self.samples.len() - 1;
        for (i, &here) in squared.iter().enumerate() {
            if here < worth * worth
                && i.abs_diff(best.1) > 1
                && (i == 0 || here <= squared[i - 1])
                && (i == last || here <= squared[i + 1])
            {
                let other = self.project_near(to, apart * i as f64, apart);
                if other.1.abs() < found.1.abs() {
                    found = other;
                }
            }
        }
        found
    }

    /// As [`Self::project`], but a point past the end, by more than a ten thousandth of the length, is
    /// projected onto the tangent there: t is then above the length.
    pub fn project_past_end(&self, to: Meridional) -> (f64, f64) {
        let (t, distance) = self.project(to);
        if t < self.length {
            return (t, distance);
        }
        match self.along_tangent(self.length, to) {
            (past, distance) if past >= AT_END * self.length => (t + past, distance),
            _ => (t, distance),
        }
    }

    /// As [`Self::project_past_end`], at both ends: before the first point t is negative.
    pub fn project_past_ends(&self, to: Meridional) -> (f64, f64) {
        let (t, distance) = self.project_past_end(to);
        if t > 0.0 {
            return (t, distance);
        }
        match self.along_tangent(0.0, to) {
            (past, distance) if past <= -AT_END * self.length => (past, distance),
            _ => (t, distance),
        }
    }

    /// A point projected onto the tangent at arc length `t`: distance from there along it, and signed
    /// distance, mm.
    fn along_tangent(&self, t: f64, to: Meridional) -> (f64, f64) {
        let CurvePoint { point, tangent, normal, .. } = self.at(t);
        let (dr, dz) = (to.r - point.r, to.z - point.z);
        (dr * tangent.r + dz * tangent.z, dr * normal.r + dz * normal.z)
    }

    /// As [`Self::project`], but only within `reach` mm of arc length about `guess`.
    pub fn project_near(&self, to: Meridional, guess: f64, reach: f64) -> (f64, f64) {
        let (low, high) = ((guess - reach).max(0.0), (guess + reach).min(self.length));
        let mut t = guess.clamp(low, high);
        for _ in 0..12 {
            let (p, d1, d2) = self.raw(t);
            let (dr, dz) = (to.r - p[0], to.z - p[1]);
            let squared_speed = d1[0] * d1[0] + d1[1] * d1[1];
            let along = dr * d1[0] + dz * d1[1];
            let bend = squared_speed - (dr * d2[0] + dz * d2[1]);
            let min_bend = MIN_BEND * squared_speed;
            let next = (t + along / bend.max(min_bend)).clamp(low, high);
            let moved = next - t;
            t = next;
            if moved.abs() < if bend < min_bend { LIMITED_PROJECTION_STEP } else { PROJECTION_STEP } {
                // At this distance, the second-order expansion of the curve is accurate enough.
                let rest = |k: usize, d: f64| d - moved * (d1[k] + 0.5 * moved * d2[k]);
                let (dr, dz) = (rest(0, dr), rest(1, dz));
                let across = dz * (d1[0] + moved * d2[0]) - dr * (d1[1] + moved * d2[1]);
                return (t, norm2(dr, dz).copysign(self.side * across));
            }
        }
        // Near a centre of curvature the limited Newton steps may not converge: use Brent's method instead.
        let squared = |t: f64| {
            let (p, ..) = self.raw(t);
            (to.r - p[0]).powi(2) + (to.z - p[1]).powi(2)
        };
        let (bracketed, least) = search::minimum(squared, low, high, 1e-9 * self.length);
        if least < squared(t) {
            t = bracketed;
        }
        let (p, d1, _) = self.raw(t);
        let (dr, dz) = (to.r - p[0], to.z - p[1]);
        (t, norm2(dr, dz).copysign(self.side * (dz * d1[0] - dr * d1[1])))
    }

    /// The piece between arc lengths `from` and `to` (mm), with the same outer side.
    pub fn piece(&self, from: f64, to: f64) -> Self {
        let count = self.segments.len();
        let length = to - from;
        let knots: Vec<f64> = (0..=count).map(|i| length * i as f64 / count as f64).collect();
        let points: Vec<[f64; 2]> = knots.iter().map(|t| self.raw(from + t).0).collect();
        let mut piece = Self::from_uniform(&Cubic::interpolate(&knots, &points), length);
        piece.side = self.side;
        piece
    }
}

fn speed(curve: &Cubic<2>, t: f64) -> f64 {
    let (_, d, _) = curve.derivatives(t);
    norm2(d[0], d[1])
}

/// Arc length between two parameters by five-point Gauss quadrature.
fn gauss_length(curve: &Cubic<2>, a: f64, b: f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    NODES.iter().map(|(x, w)| w * speed(curve, middle + half * x)).sum::<f64>() * half
}

/// Accumulated arc lengths and parameters at the quarters of all spline segments.
fn arc_length_table(curve: &Cubic<2>) -> (Vec<f64>, Vec<f64>) {
    let (mut lengths, mut parameters) = (vec![0.0], vec![curve.domain().0]);
    let mut total = 0.0;
    for pair in curve.knots().windows(2) {
        for quarter in 0..4 {
            let a = pair[0] + (pair[1] - pair[0]) * f64::from(quarter) / 4.0;
            let b = pair[0] + (pair[1] - pair[0]) * f64::from(quarter + 1) / 4.0;
            total += gauss_length(curve, a, b);
            lengths.push(total);
            parameters.push(b);
        }
    }
    (lengths, parameters)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quarter_circle() -> MeridionalCurve {
        // Axial at r = 50, radial at the end; the centre (100, 0) lies on the channel side.
        let points: Vec<Meridional> = (0..=40)
            .map(|i| {
                let a = std::f64::consts::FRAC_PI_2 * f64::from(i) / 40.0;
                Meridional { r: 100.0 - 50.0 * a.cos(), z: 50.0 * a.sin() }
            })
            .collect();
        MeridionalCurve::through(&points).with_outer_side_towards(Meridional { r: 100.0, z: 0.0 })
    }

    #[test]
    fn past_the_end_the_tangent_counts() {
        let curve = quarter_circle();
        // The curve ends radially at (100, 50); inside is below.
        for (r, z, past, distance) in
            [(103.0, 49.0, 3.0, 1.0), (103.0, 50.5, 3.0, -0.5), (100.0, 48.0, 0.0, 2.0)]
        {
            let (t, d) = curve.project_past_end(Meridional { r, z });
            assert!((t - curve.length() - past).abs() < 1e-4 && (d - distance).abs() < 1e-3, "{r}: {t} {d}");
        }
        let before = Meridional { r: 50.0, z: -3.0 };
        assert_eq!(curve.project_past_end(before), curve.project(before));
    }

    #[test]
    fn a_circle_has_its_length_curvature_normal_and_distances() {
        let curve = quarter_circle();
        assert!((curve.length() - 25.0 * std::f64::consts::PI).abs() < 1e-5, "length {}", curve.length());
        for i in 0..=20 {
            let t = curve.length() * f64::from(i) / 20.0;
            let here = curve.at(t);
            assert!((here.curvature - 0.02).abs() < 2e-4, "curvature {} at {t}", here.curvature);
            let centre = Meridional { r: 100.0, z: 0.0 };
            assert!((here.point.distance(centre) - 50.0).abs() < 1e-5);
            assert!((here.normal.r - (100.0 - here.point.r) / 50.0).abs() < 1e-4, "normal at {t}");
            let outside = here.point.lerp(centre, 0.1);
            let (back, d) = curve.project(outside);
            assert!((d - 5.0).abs() < 1e-4 && (back - t).abs() < 1e-3, "projection {back} {d}");
            let (offset, slope) = curve.offset_derivative(t, 5.0);
            assert!((offset.distance(centre) - 45.0).abs() < 1e-4);
            assert!((slope.r.hypot(slope.z) - 0.9).abs() < 1e-3, "offset shrinks a concave curve");
        }
    }

    #[test]
    fn parameter_is_arc_length() {
        let curve = quarter_circle();
        let mut walked = 0.0;
        let n = 5000;
        for i in 0..n {
            let a = curve.point(curve.length() * f64::from(i) / f64::from(n));
            let b = curve.point(curve.length() * f64::from(i + 1) / f64::from(n));
            walked += a.distance(b);
            let t = curve.length() * f64::from(i + 1) / f64::from(n);
            assert!((walked - t).abs() < 1e-5, "walked {walked} at {t}");
        }
    }
}
