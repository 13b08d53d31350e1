//! Stages 4 and 5 of [plunge paper], fig. 16: the drop-cutter depth, at which a cutter lowered along its axis
//! touches a surface of revolution with its bottom ("slotting depth", [plunge paper], fig. 13 to 15).
//!
//! On a saddle the contact point lies on the rim of the bottom, and the rim is tangent to the surface there,
//! so the maximum height of the surface above the bottom is searched along the rim only. Where the surface is
//! convex under the disc (both principal curvatures bend away), the points whose normal is parallel to the
//! axis are candidates as well, and so are the circles that bound the surface; together they cover the whole
//! disc.

use crate::geometry::{Circle, Meridional, MeridionalCurve, Point, Vector, norm2, search};
use crate::setup::Tool;

/// A surface of revolution, offset to its outer side, that a flat bottom may touch but not enter.
#[derive(Clone, Debug)]
pub struct DepthSurface<'a> {
    curve: &'a MeridionalCurve,
    offset: f64,
    /// Range of arc length of the curve that belongs to the surface, mm.
    from: f64,
    to: f64,
    /// Circles about Z that bound the surface, and others to keep the offset from.
    edges: Vec<Meridional>,
    /// Intervals of arc length on which the surface is convex outwards in both directions, mm.
    bulges: Vec<(f64, f64)>,
}

/// Contact of a lowered bottom with the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Height of the bottom's centre above the reference point along the axis, mm.
    pub height: f64,
    /// Contact point on the offset surface, mm.
    pub point: Point,
    /// Arc length of the contact point on the curve, mm.
    pub arc: f64,
}

/// Samples of the rim before refinement. The height along the rim of a disc on a surface of revolution has
/// two waves; a maximum between two samples shows in their slopes.
const RIM_SAMPLES: usize = 12;
/// Angle between two samples, rad.
const RIM_STEP: f64 = std::f64::consts::TAU / RIM_SAMPLES as f64;
/// Tolerance of the rim angle of the maximum, rad.
const RIM_TOLERANCE: f64 = 1e-5;

/// Newton steps below which the intersection of a ray has converged, mm, while the rim is scanned. The error
/// is of the order of the step's square.
const SCAN_TOLERANCE: f64 = 1e-3;
/// As [`SCAN_TOLERANCE`], for the final result.
const RAY_TOLERANCE: f64 = 1e-5;

/// Rim of a disc in the plane of the reference point, and the axis along which the disc moves.
struct Rim {
    circle: Circle,
    axis: Vector,
}

/// Intersection of the surface with a ray along the axis from a point of the rim.
#[derive(Clone, Copy, Debug, Default)]
struct RimHit {
    /// Arc length, mm, and its derivative by the rim angle.
    arc: f64,
    arc_slope: f64,
    /// Height along the axis, mm, and its derivative by the rim angle.
    height: f64,
    height_slope: f64,
}

impl RimHit {
    /// Linear extrapolation by `turn` rad along the rim.
    fn extrapolated(&self, turn: f64) -> Self {
        let (arc, height) = (self.arc + turn * self.arc_slope, self.height + turn * self.height_slope);
        Self { arc, height, ..*self }
    }
}

/// (sin, cos) of the rim's samples.
fn rim_directions() -> &'static [(f64, f64); RIM_SAMPLES] {
    static DIRECTIONS: std::sync::OnceLock<[(f64, f64); RIM_SAMPLES]> = std::sync::OnceLock::new();
    DIRECTIONS.get_or_init(|| std::array::from_fn(|i| (RIM_STEP * i as f64).sin_cos()))
}

/// Derivative of the Hermite cubic through two hits: coefficients of u + v x + w x², with x from 0 at the
/// first to 1 at the second, mm.
fn hermite_slope(a: &(f64, RimHit), b: &(f64, RimHit)) -> (f64, f64, f64) {
    let (u, end) = (a.1.height_slope * (b.0 - a.0), b.1.height_slope * (b.0 - a.0));
    let rise = b.1.height - a.1.height;
    (u, 6.0 * rise - 4.0 * u - 2.0 * end, 3.0 * (u + end) - 6.0 * rise)
}

fn touch_at(height: f64, point: &Point, arc: f64) -> Touch {
    Touch { height, point: *point, arc }
}

impl<'a> DepthSurface<'a> {
    /// The surface of the whole `curve`, offset by `offset` mm (allowance plus corner radius) and bounded by
    /// the circles of its ends.
    pub fn new(curve: &'a MeridionalCurve, offset: f64) -> Self {
        Self::between(curve, offset, 0.0, curve.length())
    }

    /// As [`Self::new`], for the part of `curve` between arc lengths `from` and `to`, mm.
    pub fn between(curve: &'a MeridionalCurve, offset: f64, from: f64, to: f64) -> Self {
        let count = 256;
        let at = |i: usize| from + (to - from) * i as f64 / count as f64;
        let bulging = |t: f64| {
            let p = curve.at(t);
            p.curvature < -1e-7 && p.normal.r > 0.0
        };
        let mut bulges: Vec<(f64, f64)> = Vec::new();
        for i in 0..count {
            if bulging(at(i)) || bulging(at(i + 1)) {
                match bulges.last_mut() {
                    Some(last) if last.1 >= at(i) => last.1 = at(i + 1),
                    _ => bulges.push((at(i), at(i + 1))),
                }
            }
        }
        Self { curve, offset, from, to, edges: vec![curve.point(from), curve.point(to)], bulges }
    }

    /// Adds circles about Z to keep the offset from.
    pub fn with_edges(mut self, edges: impl IntoIterator<Item = Meridional>) -> Self {
        self.edges.extend(edges);
        self
    }

    /// Drop-cutter contact of a disc of `radius` mm whose centre moves on the line through `on_axis` along
    /// `axis` (unit) from above. `None` when the disc misses the surface.
    pub fn touch(&self, on_axis: &Point, axis: &Vector, radius: f64) -> Option<Touch> {
        let (middle, _) = self.curve.project(Meridional::from_point(on_axis));
        self.touch_near(on_axis, axis, radius, middle)
    }

    /// As [`Self::touch`], for a point on the axis known to be near arc length `middle` (mm) of the curve.
    pub fn touch_near(&self, on_axis: &Point, axis: &Vector, radius: f64, middle: f64) -> Option<Touch> {
        let rim = Rim { circle: Circle::new(on_axis, axis, radius), axis: *axis };
        let mut warm = RimHit { arc: middle, ..RimHit::default() };
        warm = self.ray(on_axis, &Vector::zeros(), axis, warm, SCAN_TOLERANCE).unwrap_or(warm);
        let mut hits = [None; RIM_SAMPLES];
        for (hit, &direction) in hits.iter_mut().zip(rim_directions()) {
            *hit = self.rim_hit(&rim, direction, warm, SCAN_TOLERANCE);
            warm = hit.map_or(warm, |h| h.extrapolated(RIM_STEP));
        }
        let mut best: Option<Touch> = None;
        let mut consider = |height: f64, at: &dyn Fn() -> Touch| {
            if best.is_none_or(|b| height > b.height) {
                best = Some(at());
            }
        };
        // Starts at the highest sample, so that most other intervals are pruned by its height.
        let (mut first, mut highest) = (0, f64::NEG_INFINITY);
        for (i, hit) in hits.iter().enumerate() {
            if let Some(hit) = hit.filter(|h| self.is_on_surface(h) && h.height > highest) {
                (first, highest) = (if hit.height_slope > 0.0 { i } else { i + RIM_SAMPLES - 1 }, hit.height);
            }
        }
        for k in 0..RIM_SAMPLES {
            let i = (first + k) % RIM_SAMPLES;
            let (Some(a), Some(b)) = (hits[i], hits[(i + 1) % RIM_SAMPLES]) else { continue };
            let (from, to) = (RIM_STEP * i as f64, RIM_STEP * (i + 1) as f64);
            for (angle, hit) in self.maxima_between(&rim, (from, a), (to, b), highest).into_iter().flatten() {
                highest = highest.max(hit.height);
                let (origin, _) = rim.circle.point_and_derivative(angle.sin_cos());
                consider(hit.height, &|| touch_at(hit.height, &(origin + axis * hit.height), hit.arc));
            }
        }
        self.bulge_touch(on_axis, axis, radius, middle, &mut consider);
        for edge in &self.edges {
            let known = best.map_or(f64::NEG_INFINITY, |b| b.height);
            best = self.edge_touch(*edge, on_axis, axis, radius, known).or(best);
        }
        best
    }

    /// Drop-cutter tip of `tool` on the line through `on_axis` along `axis` (unit). The offset of the surface
    /// must be the allowance under the cutter plus the corner radius. `None` when the bottom misses the
    /// surface.
    pub fn tip(&self, tool: &Tool, on_axis: &Point, axis: &Vector) -> Option<Point> {
        let touch = self.touch(on_axis, axis, tool.radius() - tool.corner_radius)?;
        Some(on_axis + axis * (touch.height - tool.corner_radius))
    }

    /// Whether a hit is on the surface; beyond its ends the curve continues straight.
    fn is_on_surface(&self, hit: &RimHit) -> bool {
        (self.from..=self.to).contains(&hit.arc)
    }

    /// Local maxima of the height between two hits of the rim, each with its angle, on the surface only.
    /// Beyond its ends the bounding circles are considered instead.
    fn maxima_between(
        &self,
        rim: &Rim,
        a: (f64, RimHit),
        b: (f64, RimHit),
        known: f64,
    ) -> [Option<(f64, RimHit)>; 2] {
        let (inside, alike) =
            (self.is_on_surface(&a.1), self.is_on_surface(&a.1) == self.is_on_surface(&b.1));
        if !alike {
            return [self.maximum_up_to_end(rim, a, b, known), None];
        }
        match self.hit_at_arc_extremum(rim, a, b) {
            Some(m) => [self.maximum_up_to_end(rim, a, m, known), self.maximum_up_to_end(rim, m, b, known)],
            None if inside => [self.maximum_between(rim, a, b, known), None],
            None => [None, None],
        }
    }

    /// A hit at an extremum of the arc length between two others: beyond the end of the surface between two
    /// hits on it, or on the surface between two hits beyond the same end.
    fn hit_at_arc_extremum(&self, rim: &Rim, a: (f64, RimHit), b: (f64, RimHit)) -> Option<(f64, RimHit)> {
        if a.1.arc_slope * b.1.arc_slope >= 0.0 {
            return None;
        }
        // Estimate of the extremum: the intersection of both tangents.
        let turn = (b.1.arc - a.1.arc - b.1.arc_slope * (b.0 - a.0)) / (a.1.arc_slope - b.1.arc_slope);
        let turn = turn.clamp(0.0, b.0 - a.0);
        let other_way = |hit: &RimHit| self.is_on_surface(hit) != self.is_on_surface(&a.1);
        if !other_way(&a.1.extrapolated(turn)) {
            return None;
        }
        self.root_between(rim, (a, b), a.0 + turn, |hit| hit.arc_slope).filter(|(_, hit)| other_way(hit))
    }

    /// As [`Self::maximum_between`], between a hit on the surface and one beyond its end: the interval is cut
    /// at that end.
    fn maximum_up_to_end(
        &self,
        rim: &Rim,
        a: (f64, RimHit),
        b: (f64, RimHit),
        known: f64,
    ) -> Option<(f64, RimHit)> {
        let outside = if self.is_on_surface(&a.1) { b.1.arc } else { a.1.arc };
        let end = if outside > self.to { self.to } else { self.from };
        let share = (end - a.1.arc) / (b.1.arc - a.1.arc);
        let c = self.root_between(rim, (a, b), a.0 + share * (b.0 - a.0), |hit| hit.arc - end)?;
        if self.is_on_surface(&a.1) {
            self.maximum_between(rim, a, c, known)
        } else {
            self.maximum_between(rim, c, b, known)
        }
    }

    /// Local maximum of the height between two hits of the rim. `None` where the height is largest at one of
    /// the hits, or where a bound shows that it is at most `known` mm.
    fn maximum_between(
        &self,
        rim: &Rim,
        a: (f64, RimHit),
        b: (f64, RimHit),
        known: f64,
    ) -> Option<(f64, RimHit)> {
        let (rises, falls) = (a.1.height_slope >= 0.0, b.1.height_slope <= 0.0);
        let (u, v, w) = hermite_slope(&a, &b);
        if rises != falls {
            // Monotonic, unless the Hermite slope changes its sign in between, or nearly does.
            let share = -0.5 * v / w;
            let turns = (0.0..=1.0).contains(&share) && (u + 0.5 * v * share) * u < 0.1 * u * u;
            if !turns {
                return None;
            }
            let angle = a.0 + share * (b.0 - a.0);
            let middle = self.rim_hit(rim, angle.sin_cos(), a.1.extrapolated(angle - a.0), RAY_TOLERANCE)?;
            let (a, b) = if rises { (a, (angle, middle)) } else { ((angle, middle), b) };
            let arch = a.1.height_slope > 0.0 && b.1.height_slope < 0.0;
            return if arch { self.maximum_between(rim, a, b, known) } else { None };
        }
        if !rises {
            return None;
        }
        // The intersection of both tangents bounds a concave arch; doubled, in case it is not concave.
        let (rise, width) = (b.1.height - a.1.height, b.0 - a.0);
        let turn = (rise - b.1.height_slope * width) / (a.1.height_slope - b.1.height_slope);
        let ends = a.1.height.max(b.1.height);
        let arch = (0.0..=width).contains(&turn);
        if arch && ends + 2.0 * (a.1.height + a.1.height_slope * turn - ends) < known {
            return None;
        }
        let share = 2.0 * u / ((v * v - 4.0 * u * w).max(0.0).sqrt() - v);
        let guess = a.0 + width * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
        self.root_between(rim, (a, b), guess, |hit| hit.height_slope)
            .filter(|(_, hit)| self.is_on_surface(hit))
    }

    /// Root of `value` between two hits at which its signs differ; every evaluation starts warm from the last
    /// hit.
    fn root_between(
        &self,
        rim: &Rim,
        (a, b): ((f64, RimHit), (f64, RimHit)),
        guess: f64,
        value: impl Fn(&RimHit) -> f64,
    ) -> Option<(f64, RimHit)> {
        let mut near = if (guess - a.0).abs() < (guess - b.0).abs() { a } else { b };
        let mut lost = false;
        let value_at = |angle: f64| {
            match self.rim_hit(rim, angle.sin_cos(), near.1.extrapolated(angle - near.0), RAY_TOLERANCE) {
                Some(hit) => near = (angle, hit),
                None => lost = true,
            }
            if lost { 0.0 } else { value(&near.1) }
        };
        search::root_from(value_at, (a.0, value(&a.1)), (b.0, value(&b.1)), guess, RIM_TOLERANCE);
        (!lost).then_some(near)
    }

    /// The hit below the rim point at an angle, given as (sin, cos): from a warm start, or by projection when
    /// that fails.
    fn rim_hit(&self, rim: &Rim, direction: (f64, f64), warm: RimHit, tolerance: f64) -> Option<RimHit> {
        let (origin, turning) = rim.circle.point_and_derivative(direction);
        self.ray(&origin, &turning, &rim.axis, warm, tolerance).or_else(|| {
            let (arc, _) = self.curve.project(Meridional::from_point(&origin));
            self.ray(&origin, &turning, &rim.axis, RimHit { arc, ..RimHit::default() }, tolerance)
        })
    }

    /// Intersection of `origin + height · axis` with the offset surface: Newton iteration from `start` until
    /// a step is shorter than `tolerance` mm. Slopes are derivatives along `turning`, the derivative of the
    /// origin.
    fn ray(
        &self,
        origin: &Point,
        turning: &Vector,
        axis: &Vector,
        start: RimHit,
        tolerance: f64,
    ) -> Option<RimHit> {
        let RimHit { mut arc, mut height, .. } = start;
        for _ in 0..25 {
            let p = origin + axis * height;
            let r = norm2(p.x, p.y);
            if r < 1e-9 {
                return None;
            }
            let inverse = 1.0 / r;
            let (x, y) = (p.x * inverse, p.y * inverse);
            let radial = x * axis.x + y * axis.y;
            let (c, d) = self.curve.offset_derivative(arc, self.offset);
            // [radial, −d.r; axis.z, −d.z] · (dh, dt) = (fr, fz)
            let determinant = -radial * d.z + d.r * axis.z;
            if determinant.abs() < 1e-12 {
                return None;
            }
            let inverse = 1.0 / determinant;
            let solve =
                |fr: f64, fz: f64| ((-fr * d.z + d.r * fz) * inverse, (radial * fz - axis.z * fr) * inverse);
            let (dh, dt) = solve(c.r - r, c.z - p.z);
            height += dh;
            arc += dt;
            if dh.abs() + dt.abs() < tolerance {
                let (height_slope, arc_slope) = solve(-(x * turning.x + y * turning.y), -turning.z);
                return Some(RimHit { arc, arc_slope, height, height_slope });
            }
            if !(dh.abs() < 1e6 && dt.abs() < 1e6) {
                return None;
            }
        }
        None
    }

    /// Considers points inside the disc at which the normal of a convex surface is parallel to the axis.
    fn bulge_touch(
        &self,
        on_axis: &Point,
        axis: &Vector,
        radius: f64,
        middle: f64,
        consider: &mut dyn FnMut(f64, &dyn Fn() -> Touch),
    ) {
        let reach = 2.5 * radius + 2.0 * self.offset;
        let flat = axis.x.hypot(axis.y);
        let heading = axis.y.atan2(axis.x);
        for &(from, to) in &self.bulges {
            let (from, to) = (from.max(middle - reach), to.min(middle + reach));
            if from >= to {
                continue;
            }
            for side in [1.0, -1.0] {
                let wanted = Meridional { r: side * flat, z: axis.z };
                let level = |t: f64| {
                    let n = self.curve.at(t).normal;
                    n.r * wanted.z - n.z * wanted.r
                };
                let theta = if side > 0.0 { heading } else { heading + std::f64::consts::PI };
                let steps = 24;
                let at = |i: usize| from + (to - from) * i as f64 / steps as f64;
                for i in 0..steps {
                    let (a, b) = (at(i), at(i + 1));
                    if level(a) * level(b) > 0.0 {
                        continue;
                    }
                    let t = search::root(level, a, b, 1e-12);
                    let n = self.curve.at(t).normal;
                    if n.r * wanted.r + n.z * wanted.z <= 0.0 {
                        continue;
                    }
                    let point = self.curve.offset_derivative(t, self.offset).0.at_angle(theta);
                    let d = point - on_axis;
                    let height = d.dot(axis);
                    if (d - axis * height).norm() <= radius {
                        consider(height, &|| touch_at(height, &point, t));
                    }
                }
            }
        }
    }

    /// Contact with a circle about Z that the disc must clear by the offset in every direction, if it is
    /// higher than `known` mm.
    fn edge_touch(
        &self,
        edge: Meridional,
        on_axis: &Point,
        axis: &Vector,
        radius: f64,
        known: f64,
    ) -> Option<Touch> {
        let limit = radius + self.offset;
        // (distance from the tool axis, height along it) of a point.
        let seen = |point: &Point| {
            let d = point - on_axis;
            let height = d.dot(axis);
            ((d.norm_squared() - height * height).max(0.0).sqrt(), height)
        };
        // The circle's point nearest to the tool axis, by alternating projection.
        let beside = |p: &Point| {
            let scale = edge.r / norm2(p.x, p.y).max(1e-9);
            Point::new(p.x * scale, p.y * scale, edge.z)
        };
        let mut near = beside(on_axis);
        for _ in 0..3 {
            near = beside(&(on_axis + axis * seen(&near).1));
        }
        if seen(&near).0 > 1.5 * limit + 1.0 {
            return None;
        }
        // Only the arc of `half` rad to either side can make contact; `highest` bounds its height.
        let half = (1.6 * limit / edge.r).min(std::f64::consts::PI);
        let (toward, aside) = (near.x * axis.x + near.y * axis.y, near.x * axis.y - near.y * axis.x);
        let off = aside.abs().atan2(toward) - half;
        let highest = norm2(toward, aside) * if off > 0.0 { off.cos() } else { 1.0 };
        if highest + (edge.z - on_axis.z) * axis.z - on_axis.x * axis.x - on_axis.y * axis.y + self.offset
            <= known
        {
            return None;
        }
        let (sin, cos) = (near.y / edge.r, near.x / edge.r);
        let at = |turn: f64| {
            let (s, c) = turn.sin_cos();
            Point::new(edge.r * (cos * c - sin * s), edge.r * (sin * c + cos * s), edge.z)
        };
        let lift = |point: &Point| {
            let (distance, height) = seen(point);
            let beside = (distance - radius).max(0.0);
            if beside >= self.offset.max(1e-12) {
                // No contact here: a penalty that falls towards the contact range guides the search.
                return height - 1e3 - beside;
            }
            height + (self.offset * self.offset - beside * beside).max(0.0).sqrt()
        };
        // Evenly spaced samples of the arc, each rotated from the previous one.
        const STEPS: usize = 32;
        let step = 2.0 * half / STEPS as f64;
        let (s, c) = step.sin_cos();
        let mut place = at(-half);
        let mut best = (0, f64::NEG_INFINITY);
        for i in 0..=STEPS {
            let here = lift(&place);
            if here >= best.1 {
                best = (i, here);
            }
            place = Point::new(place.x * c - place.y * s, place.x * s + place.y * c, place.z);
        }
        let turn = |i: usize| step * i as f64 - half;
        let (low, high) = (turn(best.0.saturating_sub(1)), turn((best.0 + 1).min(STEPS)));
        let (refined, value) = search::minimum(|x| -lift(&at(x)), low, high, 1e-9);
        let (turn, height) = if -value >= best.1 { (refined, -value) } else { (turn(best.0), best.1) };
        let point = at(turn);
        if height <= known || seen(&point).0 - radius >= self.offset.max(1e-12) {
            return None;
        }
        let plane = on_axis + axis * height;
        let d = point - plane;
        let flat = d - axis * d.dot(axis);
        let n = flat.norm();
        let nearest = if n > radius { plane + flat * (radius / n) } else { plane + flat };
        Some(touch_at(height, &nearest, self.curve.project(edge).0))
    }
}
