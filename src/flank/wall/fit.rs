//! One position of a cylinder beside a wall: min-max fit of its axis.
//!
//! The axis runs through A beside the foot of the wall and B beside its tip. Three numbers are free: A along the wall's
//! normal at the foot, B along its normal at the tip, and B along the feed. With more freedom neighbouring positions
//! jump and the swept surface suffers.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Point, Vector};
use crate::part::BladeSide;

/// A wall with the side on which the cutter is.
#[derive(Debug)]
pub(super) struct Face<'a> {
    pub(super) side: &'a BladeSide,
    /// +1 where ∂S/∂u × ∂S/∂v points to the cutter.
    pub(super) sign: f64,
    /// Distance of the axis from the wall: radius and allowance, mm.
    pub(super) reach: f64,
}

/// An axis by two points on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) low: Point,
    pub(super) high: Point,
}

/// A line of the wall, hub side or tip side of its neighbours, as an axis sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Where the wall is nearest.
    pub(super) u: f64,
    /// Stock the cylinder leaves there, mm; negative where it cuts too much.
    pub(super) excess: f64,
    /// Unit vector from the wall to the axis.
    away: Vector,
    /// Place on the axis, 0 at the low point, 1 at the high one.
    share: f64,
}

/// An axis fitted to the wall, before it is decided how deep it may cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    start: Line,
    freedoms: [Vector; 3],
    /// The free numbers, mm.
    x: Vector3<f64>,
    /// How it sees the wall at the heights of the fit.
    seen: [Seen; MAX_LINES],
}

/// Steps of the fit, and steps of the search for the nearest place of a line of the wall.
const FIT_STEPS: usize = 12;
const NEAREST_STEPS: usize = 8;
/// Most exchanges per step towards the min-max solution.
const EXCHANGES: usize = 40;
/// A change of the free numbers below this ends the fit, mm.
const SETTLED: f64 = 2e-5;
/// Keeps the feed shift where it has nothing to say: on walls without twist.
const RIDGE: f64 = 1e-4;
/// Most lines of the wall looked at by one fit.
pub(super) const MAX_LINES: usize = 33;

impl Line {
    /// Unit direction, from the low point to the high one.
    pub(super) fn axis(&self) -> Vector {
        (self.high - self.low).normalize()
    }

    /// The axis a controller puts between this one and `next`: points linear, direction linear and normalised.
    pub(super) fn towards(&self, next: &Self, share: f64) -> Self {
        let low = self.low + (next.low - self.low) * share;
        let (a, b) = (self.axis(), next.axis());
        Self { low, high: low + (a + (b - a) * share) * (self.high - self.low).norm() }
    }

    /// Distance of a point from the line, mm.
    #[inline]
    pub(super) fn distance(&self, p: &Point, axis: &Vector) -> f64 {
        let d = p - self.low;
        let along = d.dot(axis);
        (d.norm_squared() - along * along).max(0.0).sqrt()
    }
}

impl Fitted {
    /// The axis itself.
    pub(super) fn line(&self) -> Line {
        self.at(&self.x)
    }

    /// Greatest deviation over the first `count` heights it was fitted at, mm: the least that a straight edge can have.
    pub(super) fn level(&self, count: usize) -> f64 {
        self.seen.iter().take(count).map(|s| s.excess.abs()).fold(0.0, f64::max)
    }

    /// The axis with other free numbers.
    fn at(&self, x: &Vector3<f64>) -> Line {
        let Self { start, freedoms, .. } = self;
        Line {
            low: start.low + freedoms[0] * x[0],
            high: start.high + freedoms[1] * x[1] + freedoms[2] * x[2],
        }
    }
}

impl Face<'_> {
    /// Unit normal towards the cutter, and unit tangent along growing u.
    pub(super) fn frame(&self, u: f64, v: f64) -> (Point, Vector, Vector) {
        let (p, pu, pv) = self.side.derivatives(u, v);
        let normal = pu.cross(&pv) * self.sign;
        let unit = |d: Vector| d.try_normalize(1e-12).unwrap_or_else(Vector::zeros);
        (p, unit(normal), unit(pu))
    }

    /// The axis beside u, both its ends off the wall by the reach.
    fn start(&self, u: f64) -> (Line, [Vector; 3]) {
        let ((p, n, _), (q, m, t)) = (self.frame(u, 0.0), self.frame(u, 1.0));
        (Line { low: p + n * self.reach, high: q + m * self.reach }, [n, m, t])
    }

    /// How `line` sees the wall at height `v`, nearest near `u`.
    pub(super) fn seen(&self, line: &Line, axis: &Vector, v: f64, u: f64) -> Seen {
        let mut u = u;
        let mut limit = f64::INFINITY;
        for _ in 0..NEAREST_STEPS {
            let (p, pu, puu) = self.side.along_u(u, v);
            let d = p - line.low;
            let flat = d - axis * d.dot(axis);
            let along = pu.dot(axis);
            let across = (pu.norm_squared() - along * along).max(1e-12);
            let bend = (across + flat.dot(&puu)).max(0.25 * across);
            let step = -flat.dot(&pu) / bend;
            // Newton without end would jump between the two flanks of a sharp bend.
            let step = step.clamp(-limit, limit);
            limit = 0.7 * step.abs().max(1e-12);
            u += step;
            if step.abs() < 1e-6 {
                break;
            }
        }
        let (p, pu, pv) = self.side.derivatives(u, v);
        let d = p - line.low;
        let along = d.dot(axis);
        let to_axis = axis * along - d;
        let distance = to_axis.norm();
        let outwards = pu.cross(&pv).dot(&to_axis) * self.sign >= 0.0;
        let sign = if outwards { 1.0 } else { -1.0 };
        Seen {
            u,
            excess: sign * distance - self.reach,
            away: to_axis * (sign / distance.max(1e-12)),
            share: along / (line.high - line.low).norm(),
        }
    }

    /// Least deviation of `line` along evenly spaced `heights`, the nearest place followed from `u` on. Between three
    /// heights the lowest place is that of a parabola.
    pub(super) fn least(&self, line: &Line, heights: &[f64], u: f64) -> f64 {
        let axis = line.axis();
        let (mut near, mut least) = (u, f64::INFINITY);
        let mut last = [f64::INFINITY; 2];
        for &v in heights {
            let seen = self.seen(line, &axis, v, near);
            near = seen.u;
            let [before, here] = last;
            if here <= before && here <= seen.excess && before.is_finite() {
                let bend = before - 2.0 * here + seen.excess;
                let drop = if bend > 0.0 { (seen.excess - before).powi(2) / (8.0 * bend) } else { 0.0 };
                least = least.min(here - drop);
            }
            least = least.min(seen.excess);
            last = [here, seen.excess];
        }
        least
    }

    /// How `line` sees the wall at `heights`, each followed from where it was `seen` before.
    fn look(&self, line: &Line, heights: &[f64], seen: &mut [Seen; MAX_LINES]) {
        let axis = line.axis();
        for (seen, &v) in seen.iter_mut().zip(heights) {
            *seen = self.seen(line, &axis, v, seen.u);
        }
    }

    /// The axis at `u` whose greatest deviation over the heights `v` is least. It tilts along the feed by no more than
    /// `most_tilt` (rad) from the plain offset. At most [`MAX_LINES`] heights count.
    pub(super) fn fit(&self, u: f64, heights: &[f64], most_tilt: f64) -> Fitted {
        let heights = &heights[..heights.len().min(MAX_LINES)];
        let count = heights.len();
        let (start, freedoms) = self.start(u);
        let blank = Seen { u, excess: 0.0, away: Vector::zeros(), share: 0.0 };
        let mut fitted = Fitted { start, freedoms, x: Vector3::zeros(), seen: [blank; MAX_LINES] };
        let most_shift = most_tilt.tan() * (start.high - start.low).norm();
        let most = |seen: &[Seen]| seen.iter().map(|s| s.excess.abs()).fold(0.0, f64::max);
        self.look(&fitted.line(), heights, &mut fitted.seen);
        let mut worst = most(&fitted.seen[..count]);
        let mut shorter = 1.0;
        for _ in 0..FIT_STEPS {
            let Some(step) = min_max_step(&fitted.seen[..count], &freedoms, fitted.x[2], most_shift) else {
                break;
            };
            let limit = 0.5 * self.reach * shorter;
            let step = step * (limit / step.amax().max(limit));
            let mut there = fitted.seen;
            self.look(&fitted.at(&(fitted.x + step)), heights, &mut there);
            let then = most(&there[..count]);
            if then >= worst {
                // Too far for slopes to tell the truth.
                shorter = (0.3 * step.amax() / self.reach).min(0.5 * shorter);
            } else {
                (fitted.x, fitted.seen, worst) = (fitted.x + step, there, then);
            }
            if step.amax() < SETTLED {
                break;
            }
        }
        fitted
    }

    /// A fitted axis moved along the normals until the least deviation over the heights it was fitted at is −`tolerance`
    /// or the deviations are as far above as below.
    pub(super) fn moved_off(&self, fitted: &Fitted, heights: &[f64], tolerance: f64) -> Line {
        let heights = &heights[..heights.len().min(MAX_LINES)];
        let (mut x, mut seen) = (fitted.x, fitted.seen);
        for _ in 0..3 {
            self.look(&fitted.at(&x), heights, &mut seen);
            let excess = || seen[..heights.len()].iter().map(|s| s.excess);
            let (low, high) =
                (excess().fold(f64::INFINITY, f64::min), excess().fold(f64::NEG_INFINITY, f64::max));
            let out = -tolerance.min(0.5 * (high - low)) - low;
            x[0] += out;
            x[1] += out;
        }
        fitted.at(&x)
    }
}

/// Newton step of the three free numbers towards the least greatest deviation, the third of them, which is `feed_shift`
/// now, within ±`most_shift`. `None` where they decide nothing.
fn min_max_step(
    seen: &[Seen],
    freedoms: &[Vector; 3],
    feed_shift: f64,
    most_shift: f64,
) -> Option<Vector3<f64>> {
    let mut rows = [Row::default(); MAX_LINES + 1];
    for (row, s) in rows.iter_mut().zip(seen) {
        let slope = Vector3::new(
            (1.0 - s.share) * s.away.dot(&freedoms[0]),
            s.share * s.away.dot(&freedoms[1]),
            s.share * s.away.dot(&freedoms[2]),
        );
        *row = Row { slope, at_rest: s.excess };
    }
    let count = seen.len();
    rows[count] = Row { slope: Vector3::new(0.0, 0.0, RIDGE), at_rest: RIDGE * feed_shift };
    let first = [0, count / 2, count - 1, count];
    let step = least_greatest(&rows[..=count], first)?;
    let shift = (feed_shift + step[2]).clamp(-most_shift, most_shift) - feed_shift;
    if shift == step[2] {
        return Some(step);
    }
    // Two numbers are left.
    for row in &mut rows[..count] {
        row.at_rest += row.slope[2] * shift;
        row.slope[2] = 0.0;
    }
    rows[count] = Row { slope: Vector3::z(), at_rest: 0.0 };
    let step = least_greatest(&rows[..=count], first)?;
    Some(Vector3::new(step[0], step[1], shift))
}

/// A deviation as a linear function of three numbers.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    slope: Vector3<f64>,
    /// Deviation where the numbers are zero.
    at_rest: f64,
}

/// The numbers at which the greatest absolute deviation of `rows` is least, by exchange: four rows decide, and the one
/// that is furthest off takes the place of that which lets the level rise most. `first` are four different rows.
fn least_greatest(rows: &[Row], first: [usize; 4]) -> Option<Vector3<f64>> {
    let mut deciding = first;
    let mut best = level(rows, &deciding)?;
    for _ in 0..EXCHANGES {
        let (level_now, x) = best;
        let off = |row: &Row| (row.at_rest + row.slope.dot(&x)).abs();
        let worst = (0..rows.len()).max_by(|&i, &j| off(&rows[i]).total_cmp(&off(&rows[j])))?;
        if off(&rows[worst]) <= level_now * (1.0 + 1e-9) + 1e-12 || deciding.contains(&worst) {
            break;
        }
        let exchanged = (0..4).filter_map(|k| {
            let mut next = deciding;
            next[k] = worst;
            level(rows, &next).map(|there| (there, next))
        });
        let Some((there, next)) = exchanged.max_by(|a, b| a.0.0.total_cmp(&b.0.0)) else { break };
        (best, deciding) = (there, next);
    }
    Some(best.1)
}

/// The least greatest deviation of four rows alone, and the numbers at which it is met.
fn level(rows: &[Row], four: &[usize; 4]) -> Option<(f64, Vector3<f64>)> {
    let row = |k: usize| &rows[four[k]];
    let others = |k: usize| [(k + 1) % 4, (k + 2) % 4, (k + 3) % 4];
    // Weights with which the four slopes cancel each other.
    let weights: [f64; 4] = std::array::from_fn(|k| {
        let [a, b, c] = others(k);
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sign * row(a).slope.dot(&row(b).slope.cross(&row(c).slope))
    });
    let total: f64 = weights.iter().map(|w| w.abs()).sum();
    let level = weights.iter().enumerate().map(|(k, w)| w * row(k).at_rest).sum::<f64>() / total;
    let heaviest = (0..4).max_by(|&i, &j| weights[i].abs().total_cmp(&weights[j].abs()))?;
    let [a, b, c] = others(heaviest);
    let matrix = Matrix3::from_rows(&[row(a), row(b), row(c)].map(|r| r.slope.transpose()));
    let wanted = [a, b, c].map(|k| level * weights[k].signum() - row(k).at_rest);
    let x = matrix.try_inverse()? * Vector3::from(wanted);
    (level.is_finite() && x.iter().all(|x| x.is_finite())).then_some((level.abs(), x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parabola_through_a_quartic_is_chebyshev_s() {
        // Best quadratic approximation of x⁴ on [−1, 1]: x² − 1/8, greatest error 1/8.
        let rows: Vec<Row> = (0..=400)
            .map(|k| {
                let x = f64::from(k) / 200.0 - 1.0;
                Row { slope: -Vector3::new(1.0, x, x * x), at_rest: x.powi(4) }
            })
            .collect();
        let found = least_greatest(&rows, [0, 100, 200, 300]).expect("a parabola");
        assert!((found - Vector3::new(-0.125, 0.0, 1.0)).norm() < 1e-3, "{found}");
    }

    #[test]
    fn no_other_numbers_do_better_and_what_decides_nothing_stays() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for case in 0..50 {
            let mut rows: Vec<Row> = (0..12)
                .map(|_| Row { slope: Vector3::new(random(), random(), random()), at_rest: random() })
                .collect();
            if case % 2 == 0 {
                // The third number means nothing but to the last row.
                rows.iter_mut().for_each(|row| row.slope.z = 0.0);
            }
            rows.push(Row { slope: Vector3::new(0.0, 0.0, 1e-4), at_rest: 0.0 });
            let most = |x: &Vector3<f64>| {
                rows.iter().map(|r| (r.at_rest + r.slope.dot(x)).abs()).fold(0.0, f64::max)
            };
            let found = least_greatest(&rows, [0, 6, 11, 12]).expect("numbers");
            let least = most(&found);
            for _ in 0..2000 {
                let step = Vector3::new(random(), random(), random()) * 0.01;
                assert!(most(&(found + step)) >= least - 1e-9, "case {case}: {least} is not least");
            }
        }
    }
}
