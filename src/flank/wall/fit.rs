//! One position of a cylinder beside a wall: minimax fit of its axis.
//!
//! The axis runs through A beside the foot of the wall and B beside its tip. It has three free parameters: A
//! along the wall's normal at the foot, B along its normal at the tip, and B along the feed. With more
//! freedom neighbouring positions jump and the swept surface suffers. On the strip that the cutter forms,
//! overcut and undercut count equally; above it, where others form the wall, only overcut counts.
//!
//! Each step solves the linearised problem by discrete Chebyshev approximation (`minimax.rs`).

use nalgebra::Vector3;

use super::minimax::{LinearDeviation, minimax};
use crate::geometry::{Point, Vector, evenly};
use crate::part::BladeSide;

/// A blade side with the side of the cutter and the distance of its axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffsetSide<'a> {
    pub(super) side: &'a BladeSide,
    /// +1 where ∂S/∂u × ∂S/∂v points to the cutter.
    pub(super) sign: f64,
    /// Distance of the axis from the wall: radius and allowance, mm.
    pub(super) reach: f64,
}

/// A tool axis by two points on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisLine {
    pub(super) low: Point,
    pub(super) high: Point,
}

/// The deviation of an axis from one line of constant v of the wall, and its gradient data.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineDeviation {
    /// u of the nearest point of the line.
    pub(super) u: f64,
    /// Stock that the cylinder leaves there, mm; negative for overcut.
    pub(super) excess: f64,
    /// Unit vector from the wall to the axis.
    away: Vector,
    /// Position along the axis, 0 at the low point, 1 at the high one.
    share: f64,
}

/// Heights (v) of the wall at which a fit evaluates the deviation, ascending.
#[derive(Clone, Debug)]
pub(super) struct FitHeights {
    v: Vec<f64>,
    /// Number of the lowest heights, which the cutter forms; at those above only overcut counts.
    formed: usize,
}

/// An axis fitted to the wall, before the allowed overcut is chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedAxis {
    start: AxisLine,
    freedoms: [Vector; 3],
    /// The free parameters, mm.
    x: Vector3<f64>,
    /// Minimax deviation over the heights of the fit, mm; above the formed ones only overcut counts.
    pub(super) level: f64,
}

/// Maximum number of steps of the fit, and of the Newton search for the nearest point of a line of the wall.
const FIT_STEPS: usize = 24;
const NEAREST_STEPS: usize = 8;
/// Maximum distance of an axis from the plain offset at its foot and tip, as a share of the height of the
/// wall, added to the reach: of the axis of a whole wall, and of one of a strip, which follows a bowed wall.
const MAX_STRAY: f64 = 0.15;
const MAX_STRIP_STRAY: f64 = 0.6;
/// Step of the free parameters below which the fit has converged, mm.
const STEP_TOLERANCE: f64 = 2e-5;
/// Regularisation of the free parameters where no deviation depends on them, as on the feed shift of walls
/// without twist: deviation per mm of shift.
const RIDGE: f64 = 1e-4;
/// Number of v at which the rise of a wall is evaluated.
const RISES: usize = 9;
/// Maximum number of lines of the wall in one fit.
pub(super) const MAX_LINES: usize = 33;

impl AxisLine {
    /// Unit direction, from the low point to the high one.
    pub(super) fn axis(&self) -> Vector {
        (self.high - self.low).normalize()
    }

    /// Moves both points off the wall at `u`, along its normals, by `out` mm.
    pub(super) fn shift(&mut self, face: &OffsetSide, u: f64, out: f64) {
        self.low += face.frame(u, 0.0).1 * out;
        self.high += face.frame(u, 1.0).1 * out;
    }

    /// The axis to which a controller interpolates between this one and `next`: points linear, direction
    /// linear and normalised.
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

impl FittedAxis {
    /// The axis.
    pub(super) fn line(&self) -> AxisLine {
        self.at(&self.x)
    }

    /// This axis, moved towards the one `beside` it until both are at most `max_shift` mm apart at the foot
    /// of the wall and at its tip.
    pub(super) fn within(&self, beside: &Self, max_shift: f64) -> Self {
        let step = self.x - beside.x;
        Self { x: beside.x + step * (max_shift / step.xy().amax().max(max_shift)), ..*self }
    }

    /// This axis, moved by `share` of the way to the one `beside` it.
    pub(super) fn towards(&self, beside: &Self, share: f64) -> Self {
        Self { x: self.x + (beside.x - self.x) * share, ..*self }
    }

    /// Distance from the one `beside` it, at the foot of the wall or at its tip, mm.
    pub(super) fn distance(&self, beside: &Self) -> f64 {
        (self.x - beside.x).amax()
    }

    /// Distance of the foot of the wall from its tip along the plain offset, mm.
    pub(super) fn height(&self) -> f64 {
        (self.start.high - self.start.low).norm()
    }

    /// The axis with other free parameters.
    fn at(&self, x: &Vector3<f64>) -> AxisLine {
        let Self { start, freedoms, .. } = self;
        AxisLine {
            low: start.low + freedoms[0] * x[0],
            high: start.high + freedoms[1] * x[1] + freedoms[2] * x[2],
        }
    }
}

impl OffsetSide<'_> {
    /// Point, unit normal towards the cutter, and unit tangent along growing u.
    pub(super) fn frame(&self, u: f64, v: f64) -> (Point, Vector, Vector) {
        let (p, pu, pv) = self.side.derivatives(u, v);
        let normal = pu.cross(&pv) * self.sign;
        let unit = |d: Vector| d.try_normalize(1e-12).unwrap_or_else(Vector::zeros);
        (p, unit(normal), unit(pu))
    }

    /// The plain offset at u, both its ends off the wall by the reach, and the directions of the free
    /// parameters.
    fn start(&self, u: f64) -> (AxisLine, [Vector; 3]) {
        let ((p, n, _), (q, m, t)) = (self.frame(u, 0.0), self.frame(u, 1.0));
        (AxisLine { low: p + n * self.reach, high: q + m * self.reach }, [n, m, t])
    }

    /// Deviation of `line` at height `v` of the wall. Newton search for the nearest point, from `u` on.
    pub(super) fn deviation_at(&self, line: &AxisLine, axis: &Vector, v: f64, u: f64) -> LineDeviation {
        let mut u = u;
        let mut limit = f64::INFINITY;
        let mut curve = self.side.line(v);
        for _ in 0..NEAREST_STEPS {
            let (p, pu, puu) = curve.at(u);
            let d = p - line.low;
            let flat = d - axis * d.dot(axis);
            let along = pu.dot(axis);
            let across = (pu.norm_squared() - along * along).max(1e-12);
            let bend = (across + flat.dot(&puu)).max(0.25 * across);
            let step = -flat.dot(&pu) / bend;
            // Shrinking the step limit stops Newton from oscillating between the two flanks of a sharp bend.
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
        LineDeviation {
            u,
            excess: sign * distance - self.reach,
            away: to_axis * (sign / distance.max(1e-12)),
            share: along / (line.high - line.low).norm(),
        }
    }

    /// Height of the wall along `line` above its low point at evenly spaced v, mm.
    pub(super) fn rise(&self, line: &AxisLine, u: f64) -> [f64; RISES] {
        let (axis, length) = (line.axis(), (line.high - line.low).norm());
        std::array::from_fn(|k| {
            self.deviation_at(line, &axis, k as f64 / (RISES - 1) as f64, u).share * length
        })
    }

    /// Minimum deviation of `line` over evenly spaced `heights`, mm, refined by parabolas through three
    /// heights. The nearest point is tracked from `u` on.
    pub(super) fn min_deviation(&self, line: &AxisLine, heights: &[f64], u: f64) -> f64 {
        let axis = line.axis();
        let (mut near, mut least) = (u, f64::INFINITY);
        let mut last = [f64::INFINITY; 2];
        for &v in heights {
            let seen = self.deviation_at(line, &axis, v, near);
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

    /// Updates the deviations of `line` at the heights `v`, each tracked from its last nearest point.
    fn update_deviations(&self, line: &AxisLine, v: &[f64], seen: &mut [LineDeviation; MAX_LINES]) {
        let axis = line.axis();
        for (seen, &v) in seen.iter_mut().zip(v) {
            *seen = self.deviation_at(line, &axis, v, seen.u);
        }
    }

    /// Minimax fit of the axis at `u` over the `heights`, started from the axis `beside` it or from the plain
    /// offset. Its angle along the feed to the plain offset is at most `max_tilt` (rad).
    pub(super) fn fit(
        &self,
        u: f64,
        heights: &FitHeights,
        beside: Option<&FittedAxis>,
        max_tilt: f64,
    ) -> FittedAxis {
        let (start, freedoms) = self.start(u);
        let rest = beside.map_or(Vector3::zeros(), |beside| beside.x);
        let mut fitted = FittedAxis { start, freedoms, x: rest, level: 0.0 };
        let height = (start.high - start.low).norm();
        let max_stray = self.reach + if beside.is_some() { MAX_STRIP_STRAY } else { MAX_STRAY } * height;
        let max_shift = max_tilt.tan() * height;
        let mut seen = [LineDeviation::at(u); MAX_LINES];
        // Twice: the first search at an inclined axis starts far from the nearest point and does not quite
        // converge.
        self.update_deviations(&fitted.line(), &heights.v, &mut seen);
        self.update_deviations(&fitted.line(), &heights.v, &mut seen);
        fitted.level = heights.max_deviation(&seen);
        let mut shorter = 1.0;
        for _ in 0..FIT_STEPS {
            let Some(step) = minimax_step(heights, &seen, &fitted, &rest, max_shift) else { break };
            let limit = 0.5 * self.reach * shorter;
            let step = step * (limit / step.amax().max(limit));
            let mut there = seen;
            self.update_deviations(&fitted.at(&(fitted.x + step)), &heights.v, &mut there);
            let then = heights.max_deviation(&there);
            // Far from its start an axis may fit another part of the wall.
            let strays = (fitted.x + step).xy().amax() > max_stray;
            if then >= fitted.level || strays {
                // Beyond the range of the linearisation.
                shorter = (0.3 * step.amax() / self.reach).min(0.5 * shorter);
            } else {
                (fitted.x, seen, fitted.level) = (fitted.x + step, there, then);
                shorter = f64::min(1.0, 3.0 * shorter);
            }
            if step.amax() < STEP_TOLERANCE {
                break;
            }
        }
        fitted
    }

    /// Maximum deviation of an axis fitted at `u` over the `heights`, mm.
    pub(super) fn max_deviation(&self, u: f64, fitted: &FittedAxis, heights: &FitHeights) -> f64 {
        let mut seen = [LineDeviation::at(u); MAX_LINES];
        for _ in 0..2 {
            self.update_deviations(&fitted.line(), &heights.v, &mut seen);
        }
        heights.max_deviation(&seen)
    }

    /// An axis fitted at `u`, moved along the normals until the minimum deviation over the `heights` is
    /// −`tolerance`, or the deviations are balanced about 0.
    pub(super) fn moved_off(
        &self,
        u: f64,
        fitted: &FittedAxis,
        heights: &FitHeights,
        tolerance: f64,
    ) -> AxisLine {
        let mut x = fitted.x;
        let mut seen = [LineDeviation::at(u); MAX_LINES];
        for _ in 0..3 {
            self.update_deviations(&fitted.at(&x), &heights.v, &mut seen);
            let excess = |count: usize| seen[..count].iter().map(|s| s.excess);
            let low = excess(heights.v.len()).fold(f64::INFINITY, f64::min);
            let high = excess(heights.formed).fold(f64::NEG_INFINITY, f64::max);
            let out = -tolerance.min(0.5 * (high - low)) - low;
            x[0] += out;
            x[1] += out;
        }
        fitted.at(&x)
    }
}

impl LineDeviation {
    /// Not evaluated yet; the search starts near `u`.
    fn at(u: f64) -> Self {
        Self { u, excess: 0.0, away: Vector::zeros(), share: 0.0 }
    }
}

impl FitHeights {
    /// `formed` heights from `low` to `top`, and `above` more from there to the tip of the wall; at most
    /// [`MAX_LINES`] in total.
    pub(super) fn new([low, top]: [f64; 2], formed: usize, above: usize) -> Self {
        let mut v = evenly(low, top, formed);
        v.extend((1..=above).map(|k| top + (1.0 - top) * k as f64 / above as f64));
        v.truncate(MAX_LINES);
        Self { v, formed: formed.min(MAX_LINES) }
    }

    /// Maximum deviation that counts, mm.
    fn max_deviation(&self, seen: &[LineDeviation]) -> f64 {
        let off = |(k, seen): (usize, &LineDeviation)| {
            if k < self.formed { seen.excess.abs() } else { -seen.excess }
        };
        seen.iter().take(self.v.len()).enumerate().map(off).fold(0.0, f64::max)
    }
}

/// Gauss–Newton step of the three free parameters towards the minimax deviation, for an axis that has `seen`
/// the wall at `heights`. The third parameter stays within ±`max_shift`; parameters without influence return
/// to `rest`. `None` where none has any.
fn minimax_step(
    heights: &FitHeights,
    seen: &[LineDeviation],
    FittedAxis { freedoms, x, .. }: &FittedAxis,
    rest: &Vector3<f64>,
    max_shift: f64,
) -> Option<Vector3<f64>> {
    let count = heights.v.len();
    let mut rows = [LinearDeviation::default(); MAX_LINES + 3];
    for (k, (row, s)) in rows.iter_mut().zip(&seen[..count]).enumerate() {
        let slope = Vector3::new(
            (1.0 - s.share) * s.away.dot(&freedoms[0]),
            s.share * s.away.dot(&freedoms[1]),
            s.share * s.away.dot(&freedoms[2]),
        );
        *row = LinearDeviation { slope, at_rest: s.excess, only_below: k >= heights.formed };
    }
    for k in 0..3 {
        let slope = Vector3::ith(k, RIDGE);
        rows[count + k] = LinearDeviation { slope, at_rest: RIDGE * (x[k] - rest[k]), only_below: false };
    }
    let rows = &mut rows[..count + 3];
    let first = [0, heights.formed / 2, heights.formed - 1, count + 2];
    let step = minimax(rows, first)?;
    let shift = (x[2] + step[2]).clamp(-max_shift, max_shift) - x[2];
    if shift == step[2] {
        return Some(step);
    }
    // The third parameter is at its limit: solve for the other two.
    for row in rows.iter_mut() {
        row.at_rest += row.slope[2] * shift;
        row.slope[2] = 0.0;
    }
    rows[count + 2] = LinearDeviation { slope: Vector3::z(), ..LinearDeviation::default() };
    let step = minimax(rows, first)?;
    Some(Vector3::new(step[0], step[1], shift))
}
