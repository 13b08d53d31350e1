//! Stage 4 and 5 of fig. 16: how deep a cutter may go along its axis until its bottom touches a
//! surface of revolution (paper A, fig. 13–15).
//!
//! On a saddle the touch point lies on the rim of the bottom and the rim is tangent to the surface
//! there, so the height of the surface above the bottom is searched along the rim only. Where the surface
//! bulges under the disc (both principal curvatures bend away) the points whose normal is the axis
//! count as well, and so do the circles in which the surface ends: together the whole disc.

use crate::geometry::{Circle, Meridional, MeridionalCurve, Point, Vector, norm2, search};
use crate::part::Tool;

/// A surface of revolution that a flat bottom may touch but not enter, offset to its outer side.
#[derive(Clone, Debug)]
pub struct DepthSurface<'a> {
    curve: &'a MeridionalCurve,
    offset: f64,
    /// Arc lengths of the offset curve that count.
    from: f64,
    to: f64,
    /// Circles in which the surface ends, and others to stay clear of by the offset.
    edges: Vec<Meridional>,
    /// Stretches of arc length at which the surface bulges outwards in both directions.
    bulges: Vec<(f64, f64)>,
}

/// Where a bottom comes to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Height of the bottom's centre above the reference point along the axis, mm.
    pub height: f64,
    /// Touch point on the offset surface.
    pub point: Point,
    /// Arc length on the curve of the place touched, mm.
    pub arc: f64,
}

/// Samples of the rim before refinement. The height along the rim of a disc on a surface of revolution has two
/// waves; a highest place between two samples shows in their slopes.
const RIM_SAMPLES: usize = 12;
/// Angle between two samples, rad.
const RIM_STEP: f64 = std::f64::consts::TAU / RIM_SAMPLES as f64;
/// The highest place of the rim is met to this, rad.
const RIM_TOLERANCE: f64 = 1e-5;

/// Newton steps below which a ray counts as met, mm: while the rim is scanned, and in the end. The error is then
/// of the order of the step's square.
const SCAN_TOLERANCE: f64 = 1e-3;
/// See [`SCAN_TOLERANCE`].
const RAY_TOLERANCE: f64 = 1e-5;

/// Rim of a disc in the plane of a reference point, and the axis along which it moves.
struct Rim {
    circle: Circle,
    axis: Vector,
}

/// Where a ray along the axis from a point of the rim meets the surface.
#[derive(Clone, Copy, Debug, Default)]
struct Hit {
    /// Arc length, mm, and its derivative by the angle of the rim.
    arc: f64,
    arc_slope: f64,
    /// Height along the axis, mm, and its derivative by the angle of the rim.
    height: f64,
    height_slope: f64,
}

impl Hit {
    /// The hit expected `turn` rad further along the rim.
    fn ahead(&self, turn: f64) -> Self {
        let (arc, height) = (self.arc + turn * self.arc_slope, self.height + turn * self.height_slope);
        Self { arc, height, ..*self }
    }
}

/// (sin, cos) of the rim's samples.
fn rim_directions() -> &'static [(f64, f64); RIM_SAMPLES] {
    static DIRECTIONS: std::sync::OnceLock<[(f64, f64); RIM_SAMPLES]> = std::sync::OnceLock::new();
    DIRECTIONS.get_or_init(|| std::array::from_fn(|i| (RIM_STEP * i as f64).sin_cos()))
}

/// Slope of the cubic with the heights and slopes of two hits: u + v x + w x², x from 0 at the first to 1 at the
/// other, mm.
fn hermite_slope(a: &(f64, Hit), b: &(f64, Hit)) -> (f64, f64, f64) {
    let (u, end) = (a.1.height_slope * (b.0 - a.0), b.1.height_slope * (b.0 - a.0));
    let rise = b.1.height - a.1.height;
    (u, 6.0 * rise - 4.0 * u - 2.0 * end, 3.0 * (u + end) - 6.0 * rise)
}

fn touch_at(height: f64, point: &Point, arc: f64) -> Touch {
    Touch { height, point: *point, arc }
}

impl<'a> DepthSurface<'a> {
    /// The whole `curve`, offset by `offset` mm (allowance plus corner radius), ending in circles.
    pub fn new(curve: &'a MeridionalCurve, offset: f64) -> Self {
        Self::between(curve, offset, 0.0, curve.length())
    }

    /// The stretch of `curve` between arc lengths `from` and `to`.
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

    /// Adds circles to stay clear of by the offset.
    pub fn with_edges(mut self, edges: impl IntoIterator<Item = Meridional>) -> Self {
        self.edges.extend(edges);
        self
    }

    /// Lowest place of a disc of `radius` mm whose centre moves on the line through `on_axis` along
    /// `axis` (unit), coming from above. `None` when the disc misses the surface.
    pub fn touch(&self, on_axis: &Point, axis: &Vector, radius: f64) -> Option<Touch> {
        let (middle, _) = self.curve.project(Meridional::of(on_axis));
        self.touch_near(on_axis, axis, radius, middle)
    }

    /// As [`Self::touch`], for a point on the axis known to be near arc length `middle` of the curve.
    pub fn touch_near(&self, on_axis: &Point, axis: &Vector, radius: f64, middle: f64) -> Option<Touch> {
        let rim = Rim { circle: Circle::new(on_axis, axis, radius), axis: *axis };
        let mut warm = Hit { arc: middle, ..Hit::default() };
        warm = self.ray(on_axis, &Vector::zeros(), axis, warm, SCAN_TOLERANCE).unwrap_or(warm);
        let mut hits = [None; RIM_SAMPLES];
        for (hit, &direction) in hits.iter_mut().zip(rim_directions()) {
            *hit = self.rim_hit(&rim, direction, warm, SCAN_TOLERANCE);
            warm = hit.map_or(warm, |h| h.ahead(RIM_STEP));
        }
        let mut best: Option<Touch> = None;
        let mut consider = |height: f64, at: &dyn Fn() -> Touch| {
            if best.is_none_or(|b| height > b.height) {
                best = Some(at());
            }
        };
        // From the highest sample on, so that most others need not be looked at.
        let (mut first, mut highest) = (0, f64::NEG_INFINITY);
        for (i, hit) in hits.iter().enumerate() {
            if let Some(hit) = hit.filter(|h| self.holds(h) && h.height > highest) {
                (first, highest) = (if hit.height_slope > 0.0 { i } else { i + RIM_SAMPLES - 1 }, hit.height);
            }
        }
        for k in 0..RIM_SAMPLES {
            let i = (first + k) % RIM_SAMPLES;
            let (Some(a), Some(b)) = (hits[i], hits[(i + 1) % RIM_SAMPLES]) else { continue };
            let (from, to) = (RIM_STEP * i as f64, RIM_STEP * (i + 1) as f64);
            for (angle, hit) in self.tops_between(&rim, (from, a), (to, b), highest).into_iter().flatten() {
                highest = highest.max(hit.height);
                let (origin, _) = rim.circle.at(angle.sin_cos());
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

    /// Tip of `tool` on the line through `on_axis` along `axis` (unit), lowered until its bottom touches the surface, which
    /// is offset by what shall stay under the cutter plus the corner radius. `None` when the bottom misses the surface.
    pub fn tip(&self, tool: &Tool, on_axis: &Point, axis: &Vector) -> Option<Point> {
        let touch = self.touch(on_axis, axis, tool.radius() - tool.corner_radius)?;
        Some(on_axis + axis * (touch.height - tool.corner_radius))
    }

    /// Whether a hit is on the stretch that counts; beyond it the surface runs on straight.
    fn holds(&self, hit: &Hit) -> bool {
        (self.from..=self.to).contains(&hit.arc)
    }

    /// Highest places of the rim between two of its hits, each with its angle, as far as the surface goes. Where it
    /// ends the circle of its end is what counts.
    fn tops_between(&self, rim: &Rim, a: (f64, Hit), b: (f64, Hit), known: f64) -> [Option<(f64, Hit)>; 2] {
        let (inside, alike) = (self.holds(&a.1), self.holds(&a.1) == self.holds(&b.1));
        if !alike {
            return [self.top_up_to_end(rim, a, b, known), None];
        }
        match self.excursion(rim, a, b) {
            Some(m) => [self.top_up_to_end(rim, a, m, known), self.top_up_to_end(rim, m, b, known)],
            None if inside => [self.top_between(rim, a, b, known), None],
            None => [None, None],
        }
    }

    /// A hit between two that are on the surface, or both beyond the same end, where it is the other way round.
    fn excursion(&self, rim: &Rim, a: (f64, Hit), b: (f64, Hit)) -> Option<(f64, Hit)> {
        if a.1.arc_slope * b.1.arc_slope >= 0.0 {
            return None;
        }
        // No further than the tangents' meeting point.
        let turn = (b.1.arc - a.1.arc - b.1.arc_slope * (b.0 - a.0)) / (a.1.arc_slope - b.1.arc_slope);
        let turn = turn.clamp(0.0, b.0 - a.0);
        let other_way = |hit: &Hit| self.holds(hit) != self.holds(&a.1);
        if !other_way(&a.1.ahead(turn)) {
            return None;
        }
        self.follow(rim, (a, b), a.0 + turn, |hit| hit.arc_slope).filter(|(_, hit)| other_way(hit))
    }

    /// As [`Self::top_between`], between a hit on the surface and one beyond its end.
    fn top_up_to_end(&self, rim: &Rim, a: (f64, Hit), b: (f64, Hit), known: f64) -> Option<(f64, Hit)> {
        let outside = if self.holds(&a.1) { b.1.arc } else { a.1.arc };
        let end = if outside > self.to { self.to } else { self.from };
        let share = (end - a.1.arc) / (b.1.arc - a.1.arc);
        let c = self.follow(rim, (a, b), a.0 + share * (b.0 - a.0), |hit| hit.arc - end)?;
        if self.holds(&a.1) { self.top_between(rim, a, c, known) } else { self.top_between(rim, c, b, known) }
    }

    /// Highest place of the rim between two of its hits. `None` where it is no higher inside than at its ends, or
    /// surely no higher than `known` mm.
    fn top_between(&self, rim: &Rim, a: (f64, Hit), b: (f64, Hit), known: f64) -> Option<(f64, Hit)> {
        let (rises, falls) = (a.1.height_slope >= 0.0, b.1.height_slope <= 0.0);
        let (u, v, w) = hermite_slope(&a, &b);
        if rises != falls {
            // Up or down all the way, unless the slope seems to change its sign between, or nearly.
            let share = -0.5 * v / w;
            let turns = (0.0..=1.0).contains(&share) && (u + 0.5 * v * share) * u < 0.1 * u * u;
            if !turns {
                return None;
            }
            let angle = a.0 + share * (b.0 - a.0);
            let middle = self.rim_hit(rim, angle.sin_cos(), a.1.ahead(angle - a.0), RAY_TOLERANCE)?;
            let (a, b) = if rises { (a, (angle, middle)) } else { ((angle, middle), b) };
            let arch = a.1.height_slope > 0.0 && b.1.height_slope < 0.0;
            return if arch { self.top_between(rim, a, b, known) } else { None };
        }
        if !rises {
            return None;
        }
        // Where the tangents of both meet bounds an arch; twice that, in case it is none.
        let (rise, width) = (b.1.height - a.1.height, b.0 - a.0);
        let turn = (rise - b.1.height_slope * width) / (a.1.height_slope - b.1.height_slope);
        let ends = a.1.height.max(b.1.height);
        let arch = (0.0..=width).contains(&turn);
        if arch && ends + 2.0 * (a.1.height + a.1.height_slope * turn - ends) < known {
            return None;
        }
        let share = 2.0 * u / ((v * v - 4.0 * u * w).max(0.0).sqrt() - v);
        let guess = a.0 + width * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
        self.follow(rim, (a, b), guess, |hit| hit.height_slope).filter(|(_, hit)| self.holds(hit))
    }

    /// The hit between two at which `value` is 0: it has different signs at them.
    fn follow(
        &self,
        rim: &Rim,
        (a, b): ((f64, Hit), (f64, Hit)),
        guess: f64,
        value: impl Fn(&Hit) -> f64,
    ) -> Option<(f64, Hit)> {
        let mut near = if (guess - a.0).abs() < (guess - b.0).abs() { a } else { b };
        let mut lost = false;
        let value_at = |angle: f64| {
            match self.rim_hit(rim, angle.sin_cos(), near.1.ahead(angle - near.0), RAY_TOLERANCE) {
                Some(hit) => near = (angle, hit),
                None => lost = true,
            }
            if lost { 0.0 } else { value(&near.1) }
        };
        search::root_from(value_at, (a.0, value(&a.1)), (b.0, value(&b.1)), guess, RIM_TOLERANCE);
        (!lost).then_some(near)
    }

    /// Where the rim at an angle, given as (sin, cos), is above the surface: from a warm start, or from scratch
    /// when that fails.
    fn rim_hit(&self, rim: &Rim, direction: (f64, f64), warm: Hit, tolerance: f64) -> Option<Hit> {
        let (origin, turning) = rim.circle.at(direction);
        self.ray(&origin, &turning, &rim.axis, warm, tolerance).or_else(|| {
            let (arc, _) = self.curve.project(Meridional::of(&origin));
            self.ray(&origin, &turning, &rim.axis, Hit { arc, ..Hit::default() }, tolerance)
        })
    }

    /// Where `origin + height · axis` meets the offset surface: Newton from `start` until a step is shorter than
    /// `tolerance` mm. Slopes are those along `turning`, the derivative of the origin.
    fn ray(
        &self,
        origin: &Point,
        turning: &Vector,
        axis: &Vector,
        start: Hit,
        tolerance: f64,
    ) -> Option<Hit> {
        let Hit { mut arc, mut height, .. } = start;
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
                return Some(Hit { arc, arc_slope, height, height_slope });
            }
            if !(dh.abs() < 1e6 && dt.abs() < 1e6) {
                return None;
            }
        }
        None
    }

    /// Points inside the disc at which the surface is level: its normal is the axis.
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

    /// Touch of a circle about Z that the disc must clear by the offset, also from beside, where it is higher than
    /// `known` mm.
    fn edge_touch(
        &self,
        edge: Meridional,
        on_axis: &Point,
        axis: &Vector,
        radius: f64,
        known: f64,
    ) -> Option<Touch> {
        let limit = radius + self.offset;
        // (distance from the axis, height along it) of a point.
        let seen = |point: &Point| {
            let d = point - on_axis;
            let height = d.dot(axis);
            ((d.norm_squared() - height * height).max(0.0).sqrt(), height)
        };
        // The circle's point nearest to the axis, by going back and forth twice.
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
        // The arc that counts is `half` wide on either side of it; no place of it is higher than this.
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
                // Out of reach: a slope back towards the reach keeps the search going.
                return height - 1e3 - beside;
            }
            height + (self.offset * self.offset - beside * beside).max(0.0).sqrt()
        };
        // Samples evenly along the arc, each turned on from the one before.
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
