//! A layer: a surface of revolution through the channel, with walls and geodesics on it.
//!
//! Points of a layer are (x, y): arc length along its meridional curve, mm, and angle about the rotation
//! axis, rad, which grows from the wall at λ = 0 to the one at λ = 1.

use super::offset::{closed_parallel, folds_between};
use crate::geometry::{Meridional, MeridionalCurve, Point, Vector, evenly, norm2, search, wrap_angle};
use crate::part::{BladeSide, Impeller};

/// Number of points of the meridional curve of a layer; a C2 spline joins them.
const CURVE_POINTS: usize = 120;
/// Maximum length of the layer upstream of the leading edge, as a share of its length.
const UPSTREAM: f64 = 0.2;
/// Least length of a layer, mm.
const MIN_LENGTH: f64 = 1e-3;
/// Steps in which the part of a layer in the channel is searched.
const SEARCH_STEPS: usize = 400;
/// Radius of the rounding of a layer where the parallel of the hub folds, as a share of the layer's length:
/// some points of the layer's curve lie on it.
const CORNER_RADIUS: f64 = 0.03;

/// A point of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerPoint {
    /// Arc length along the layer's meridional curve, mm.
    pub x: f64,
    /// Angle, rad.
    pub y: f64,
}

impl LayerPoint {
    /// Linear interpolation from here (`share` = 0) to `other` (1).
    pub fn lerp(self, other: Self, share: f64) -> Self {
        Self { x: self.x + (other.x - self.x) * share, y: self.y + (other.y - self.y) * share }
    }
}

/// A surface of revolution on which passes are planned.
#[derive(Clone, Debug)]
pub struct LayerSurface {
    curve: MeridionalCurve,
    /// Arc length at which the channel begins (leading edge), mm.
    pub from: f64,
    /// Arc length at which it ends, mm: at the rim, or where the layer leaves the channel at the shroud.
    pub to: f64,
    /// Height above the hub, mm; for an isoparametric layer its height at the leading edge.
    pub height: f64,
    /// +1 where angles about the axis grow with y, −1 where they fall.
    turn: f64,
}

impl LayerSurface {
    /// The layer `height` mm above the hub; `None` where the channel is nowhere that deep. Where the parallel
    /// of the hub folds, as above the foot of a boss, the layer is rounded.
    pub fn at_height(part: &Impeller, height: f64) -> Option<Self> {
        let hub = part.hub.curve();
        // Ends where the offset of the hub crosses the straight lines of the leading edge and of the rim.
        let at = |t: f64| hub.offset_derivative(t, height).0;
        let beyond = |a: Meridional, b: Meridional| {
            move |p: Meridional| (b.r - a.r) * (p.z - a.z) - (b.z - a.z) * (p.r - a.r)
        };
        let inlet = beyond(part.hub.point(0.0), part.shroud.point(0.0));
        let outlet = beyond(part.hub.point(1.0), part.shroud.point(1.0));
        let (start, end) = (part.hub.arc_at(0.0), part.hub.arc_at(1.0));
        let reach = 2.0 * height + 0.1 * (end - start);
        let from = border(|t| inlet(at(t)), start, reach);
        let to = border(|t| outlet(at(t)), end, reach);
        if to - from < MIN_LENGTH {
            return None;
        }
        let extended = from - UPSTREAM * (to - from);
        let first = from.min(0.0);
        if !folds_between(hub, height, extended.max(first), to) {
            return Self::along(part, hub, height, [from, to], height);
        }
        let curve = closed_parallel(hub, height, CORNER_RADIUS * (to - from), first, to)?;
        let ends = [curve.project(at(from)).0, curve.length()];
        Self::along(part, &curve, 0.0, ends, height)
    }

    /// The layer at the offset by `distance` of `curve`, where that is in the channel between two arc
    /// lengths, mm. The layer is `height` mm above the hub.
    fn along(
        part: &Impeller,
        curve: &MeridionalCurve,
        distance: f64,
        [mut from, to]: [f64; 2],
        height: f64,
    ) -> Option<Self> {
        let at = |t: f64| curve.offset_derivative(t, distance).0;
        let shroud = part.shroud.curve();
        let depth_left = |t: f64| {
            let p = at(t);
            let (arc, d) = shroud.project(p);
            // Beyond the ends of the shroud the lines of leading edge and rim bound the channel.
            if arc <= 0.0 || arc >= shroud.length() { d.abs() } else { -d }
        };
        let mut last = from;
        let mut inside = false;
        for t in evenly(from, to, SEARCH_STEPS + 1) {
            match (inside, depth_left(t) > -1e-6) {
                (false, true) => {
                    from = t;
                    inside = true;
                }
                (true, false) => {
                    last = search::root(&depth_left, last, t, 1e-9);
                    break;
                }
                _ => {}
            }
            last = t;
        }
        if !inside || last - from < MIN_LENGTH {
            return None;
        }
        // Upstream of the leading edge the layer follows the hub as far as that extends.
        let mut ahead = 0;
        let step = (last - from) / CURVE_POINTS as f64;
        let most = (UPSTREAM * CURVE_POINTS as f64) as usize;
        while ahead < most && from - step * (ahead + 1) as f64 > 0.0 {
            ahead += 1;
        }
        let points: Vec<Meridional> =
            (0..=CURVE_POINTS + ahead).map(|i| at(from + step * (i as f64 - ahead as f64))).collect();
        let outer = curve.offset_derivative(0.5 * (from + last), distance + 0.01 * curve.length()).0;
        Self::through(part, &points, ahead, outer, height)
    }

    /// The layer at the fraction `eta` from hub to shroud, but nowhere less than `least` mm above the hub.
    pub fn isoparametric(part: &Impeller, eta: f64, least: f64) -> Option<Self> {
        let hub = part.hub.curve();
        let step = 1.0 / CURVE_POINTS as f64;
        let upstream = part.hub.s_range().0.max(-UPSTREAM);
        let ahead = (-upstream / step).floor().max(0.0) as usize;
        let raised = |s: f64| {
            let p = part.meridional(s, eta);
            let (t, height) = hub.project(p);
            if height < least { hub.offset_derivative(t, least).0 } else { p }
        };
        let points: Vec<Meridional> =
            (0..=CURVE_POINTS + ahead).map(|i| raised(step * (i as f64 - ahead as f64))).collect();
        let height = part.hub.point(0.0).distance(points[ahead]);
        let outer = part.meridional(0.5, eta + 0.05);
        Self::through(part, &points, ahead, outer, height)
    }

    /// The layer through `points`, of which `ahead` are upstream of the leading edge.
    fn through(
        part: &Impeller,
        points: &[Meridional],
        ahead: usize,
        outer: Meridional,
        height: f64,
    ) -> Option<Self> {
        if points.windows(2).any(|p| p[0].distance(p[1]) <= 1e-9 || p[0].r.is_nan() || p[0].r <= 0.0) {
            return None;
        }
        let curve = MeridionalCurve::through(points).with_outer_side_towards(outer);
        let to = curve.length();
        let from = if ahead == 0 { 0.0 } else { curve.project(points[ahead]).0 };
        (to - from > MIN_LENGTH).then(|| Self { curve, from, to, height, turn: part.pitch().signum() })
    }

    /// Distance from the rotation axis at `x`, mm, and its derivative in x.
    #[inline]
    pub fn radius(&self, x: f64) -> (f64, f64) {
        let (p, d) = self.curve.offset_derivative(x, 0.0);
        (p.r, d.r)
    }

    /// The point in the frame of the part.
    pub fn point(&self, p: LayerPoint) -> Point {
        self.curve.point(p.x).at_angle(self.turn * p.y)
    }

    /// The point and the unit normal there, away from the hub.
    pub fn point_and_normal(&self, p: LayerPoint) -> (Point, Vector) {
        let here = self.curve.at(p.x);
        let theta = self.turn * p.y;
        (here.point.at_angle(theta), here.normal.direction_at_angle(theta))
    }

    /// Projection of `point` onto the layer, with y next to `near`, and its height above the layer, mm.
    /// Beyond its ends the layer is extended straight. `guess` is an x near the result.
    pub fn project(&self, point: &Point, near: f64, guess: Option<f64>) -> (LayerPoint, f64) {
        let m = Meridional::from_point(point);
        let length = self.curve.length();
        let (x, d) = match guess {
            Some(x) => self.curve.project_near(m, x.clamp(0.0, length), 0.2 * length),
            None => self.curve.project(m),
        };
        let angle = self.turn * point.y.atan2(point.x);
        let y = near + wrap_angle(angle - near);
        if x > 0.0 && x < length {
            return (LayerPoint { x, y }, d);
        }
        let here = self.curve.at(x);
        let (dr, dz) = (m.r - here.point.r, m.z - here.point.z);
        let along = dr * here.tangent.r + dz * here.tangent.z;
        (LayerPoint { x: x + along, y }, dr * here.normal.r + dz * here.normal.z)
    }

    /// Length of a short segment from `a` to `b`, mm: of the chord with the radius at its middle.
    #[inline]
    pub fn segment_length(&self, a: LayerPoint, b: LayerPoint) -> f64 {
        let (r, _) = self.radius(0.5 * (a.x + b.x));
        norm2(b.x - a.x, r * (b.y - a.y))
    }

    /// Length of a polyline of short segments, mm.
    pub fn length(&self, points: &[LayerPoint]) -> f64 {
        points.windows(2).map(|p| self.segment_length(p[0], p[1])).sum()
    }

    /// Normal curvature of the layer across a direction at angle β = `slope` (rad) to the meridian, 1/mm,
    /// positive where the layer is convex towards the channel: cos²β·n_r/r + sin²β·κ of the meridian (Euler).
    pub fn curvature_across(&self, x: f64, slope: f64) -> f64 {
        let here = self.curve.at(x);
        let (sin, cos) = slope.sin_cos();
        cos * cos * here.normal.r / here.point.r.max(1e-9) - sin * sin * here.curvature
    }

    /// Largest absolute normal curvature of the layer at `x` in any direction, 1/mm.
    pub fn max_curvature(&self, x: f64) -> f64 {
        let here = self.curve.at(x);
        (here.normal.r / here.point.r.max(1e-9)).abs().max(here.curvature.abs())
    }

    /// The meridional curve of the layer, extended straight by `beyond` mm at both ends, through points about
    /// `step` mm apart.
    pub fn extended_meridian(&self, beyond: f64, step: f64) -> MeridionalCurve {
        let (from, to) = (self.from - beyond, self.to + beyond);
        let count = ((to - from) / step).ceil().clamp(64.0, 600.0) as usize;
        let at = |k: usize| self.curve.point(from + (to - from) * k as f64 / count as f64);
        // The extension ends before it reaches the rotation axis.
        let points: Vec<Meridional> =
            (0..=count).map(at).filter(|p| p.r > 1e-3 * self.radius(self.from).0.max(1.0)).collect();
        let middle = self.curve.at(0.5 * (self.from + self.to));
        let outer = Meridional {
            r: middle.point.r + 0.01 * self.to * middle.normal.r,
            z: middle.point.z + 0.01 * self.to * middle.normal.z,
        };
        MeridionalCurve::through(&points).with_outer_side_towards(outer)
    }

    /// End point and heading of the geodesic from `start` with `heading` (rad from the meridian towards
    /// growing y) after `length` mm. Classical fourth-order Runge–Kutta.
    pub fn geodesic(&self, start: LayerPoint, heading: f64, length: f64) -> (LayerPoint, f64) {
        // Steps of 1/25 of the radius keep the fourth-order scheme accurate to nanometres.
        let longest = (0.04 * self.radius(start.x).0).max(1e-6);
        let steps = (length.abs() / longest).ceil().max(1.0);
        let h = length / steps;
        let rate = |x: f64, heading: f64| {
            let (r, slope) = self.radius(x);
            let r = r.max(1e-6);
            let (sin, cos) = heading.sin_cos();
            [cos, sin / r, -sin * slope / r]
        };
        let (mut x, mut y, mut psi) = (start.x, start.y, heading);
        for _ in 0..steps as usize {
            let a = rate(x, psi);
            let b = rate(x + 0.5 * h * a[0], psi + 0.5 * h * a[2]);
            let c = rate(x + 0.5 * h * b[0], psi + 0.5 * h * b[2]);
            let d = rate(x + h * c[0], psi + h * c[2]);
            let sum = |k: usize| h * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]) / 6.0;
            (x, y, psi) = (x + sum(0), y + sum(1), psi + sum(2));
        }
        (LayerPoint { x, y }, psi)
    }

    /// Angle of a short segment from `a` to `b` to the meridian, rad.
    pub fn heading(&self, a: LayerPoint, b: LayerPoint) -> f64 {
        let (r, _) = self.radius(0.5 * (a.x + b.x));
        (r * (b.y - a.y)).atan2(b.x - a.x)
    }

    /// Points at which the lines of constant `u` of a blade side are `raised` mm above the layer (at most as
    /// high as the tip of the side), projected onto the layer, with y next to `near`. Lines that do not reach
    /// it are skipped.
    pub fn trace(
        &self,
        side: &BladeSide,
        u: impl Iterator<Item = f64>,
        near: f64,
        raised: f64,
    ) -> Vec<LayerPoint> {
        let mut guess: Option<(f64, f64)> = None;
        let mut y = near;
        let mut points = Vec::new();
        for u in u {
            let Some((v, p)) = self.trace_line(side, u, guess, raised) else { continue };
            guess = Some((v, p.x));
            y += wrap_angle(p.y - y);
            points.push(LayerPoint { x: p.x, y });
        }
        points
    }

    /// The crossing of line u `raised` mm above the layer; where the side ends below that height, its tip, or
    /// the crossing with the layer itself.
    fn trace_line(
        &self,
        side: &BladeSide,
        u: f64,
        guess: Option<(f64, f64)>,
        raised: f64,
    ) -> Option<(f64, LayerPoint)> {
        let there = self.crossing(side, u, guess, raised);
        if raised == 0.0 || there.is_some_and(|(v, _)| v <= 1.0) {
            return there;
        }
        let (v, on_layer) = self.crossing(side, u, guess, 0.0)?;
        if v >= 1.0 {
            return Some((v, on_layer));
        }
        Some((1.0, self.project(&side.point(u, 1.0), 0.0, Some(on_layer.x)).0))
    }

    fn crossing(
        &self,
        side: &BladeSide,
        u: f64,
        guess: Option<(f64, f64)>,
        raised: f64,
    ) -> Option<(f64, LayerPoint)> {
        let (mut v, mut near) = guess.map_or((0.5, None), |(v, x)| (v, Some(x)));
        for _ in 0..30 {
            let (p, _, pv) = side.derivatives(u, v);
            let (place, height) = self.project(&p, 0.0, near);
            near = Some(place.x);
            let off = height - raised;
            if off.abs() < 1e-9 {
                return Some((v, place));
            }
            let normal = self.curve.at(place.x).normal;
            let radial = (p.x * pv.x + p.y * pv.y) / norm2(p.x, p.y).max(1e-9);
            let rate = radial * normal.r + pv.z * normal.z;
            let step = off / rate;
            if !step.is_finite() {
                return None;
            }
            v -= step.clamp(-0.3, 0.3);
            if !(-0.6..1.6).contains(&v) {
                return None;
            }
        }
        None
    }
}

/// Root of `f` nearest to `around`, bracketed by a scan within `reach` of it; `around` where there is none.
fn border(f: impl Fn(f64) -> f64, around: f64, reach: f64) -> f64 {
    let here = f(around);
    if here == 0.0 {
        return around;
    }
    let steps = 64;
    for k in 1..=steps {
        let d = reach * f64::from(k) / f64::from(steps);
        let last = reach * f64::from(k - 1) / f64::from(steps);
        for sign in [1.0, -1.0] {
            let (a, b) = (around + sign * last, around + sign * d);
            if f(a) * f(b) <= 0.0 {
                return search::root(&f, a, b, 1e-9);
            }
        }
    }
    around
}
