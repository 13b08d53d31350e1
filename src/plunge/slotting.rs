//! Stage 4 and 5 of fig. 16: how deep a cutter may go along its axis until its bottom touches a
//! surface of revolution (paper A, fig. 13–15).
//!
//! On a saddle the touch point lies on the rim of the bottom and the rim is tangent to the surface
//! there, so the height of the surface above the bottom is searched along the rim only. Where the surface
//! bulges under the disc (both principal curvatures bend away) the points whose normal is the axis
//! count as well, and so do the circles in which the surface ends: together the whole disc.

use crate::geometry::{Meridional, MeridionalCurve, Point, Vector, frame_about, norm2, search};

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

/// Samples of the rim before refinement. The height along the rim of a disc on a surface of
/// revolution has two waves, so that these cannot miss one.
const RIM_SAMPLES: usize = 24;

/// Newton steps below which a ray counts as met, mm: while the rim is scanned, and in the end.
const SCAN_TOLERANCE: f64 = 1e-3;
/// See [`SCAN_TOLERANCE`].
const RAY_TOLERANCE: f64 = 1e-8;

/// (cos, sin) of the rim's samples.
fn rim_directions() -> &'static [(f64, f64); RIM_SAMPLES] {
    static DIRECTIONS: std::sync::OnceLock<[(f64, f64); RIM_SAMPLES]> = std::sync::OnceLock::new();
    DIRECTIONS.get_or_init(|| {
        std::array::from_fn(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / RIM_SAMPLES as f64).sin_cos();
            (cos, sin)
        })
    })
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
        let (e1, e2) = frame_about(axis);
        let rim = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            on_axis + (e1 * cos + e2 * sin) * radius
        };
        let start = self.ray(on_axis, axis, (middle, 0.0), SCAN_TOLERANCE).unwrap_or((middle, 0.0));
        let rim_directions = rim_directions();
        let mut hits = [None; RIM_SAMPLES];
        let mut warm = start;
        let step = std::f64::consts::TAU / RIM_SAMPLES as f64;
        for (i, hit) in hits.iter_mut().enumerate() {
            let (cos, sin) = rim_directions[i];
            let origin = on_axis + (e1 * cos + e2 * sin) * radius;
            *hit = self.rim_hit(&origin, axis, warm, SCAN_TOLERANCE);
            if let Some(found) = *hit {
                warm = found;
            }
        }
        let mut best: Option<Touch> = None;
        let mut consider = |height: f64, at: &dyn Fn() -> Touch| {
            if best.is_none_or(|b| height > b.height) {
                best = Some(at());
            }
        };
        let height = |i: usize| hits[i % RIM_SAMPLES].map_or(f64::NEG_INFINITY, |h| h.1);
        let highest = (0..RIM_SAMPLES).map(height).fold(f64::NEG_INFINITY, f64::max);
        for i in 0..RIM_SAMPLES {
            let Some(hit) = hits[i] else { continue };
            let (before, after) = (height(i + RIM_SAMPLES - 1), height(i + 1));
            if hit.1 < before || hit.1 < after {
                continue;
            }
            // What a parabola through the neighbours could still gain decides whether to refine.
            let gain = if before.is_finite() && after.is_finite() {
                2.0 * (hit.1 - before).max(hit.1 - after)
            } else {
                f64::INFINITY
            };
            if hit.1 + gain < highest {
                continue;
            }
            let mut found = hit;
            let mut top = (f64::NEG_INFINITY, step * i as f64, hit.0);
            search::minimum(
                |phi| match self.rim_hit(&rim(phi), axis, found, RAY_TOLERANCE) {
                    Some(h) => {
                        found = h;
                        if h.1 > top.0 {
                            top = (h.1, phi, h.0);
                        }
                        -h.1
                    }
                    None => -hit.1 + 1e3,
                },
                step * (i as f64 - 1.0),
                step * (i as f64 + 1.0),
                1e-5,
            );
            if top.0.is_finite() {
                consider(top.0, &|| touch_at(top.0, &(rim(top.1) + axis * top.0), top.2));
            }
        }
        self.bulge_touch(on_axis, axis, radius, middle, &mut consider);
        for edge in &self.edges {
            self.edge_touch(*edge, on_axis, axis, radius, &mut consider);
        }
        best
    }

    /// Ray hit from a warm start, or from scratch when that fails; only hits within the surface count.
    fn rim_hit(&self, origin: &Point, axis: &Vector, warm: (f64, f64), tolerance: f64) -> Option<(f64, f64)> {
        let hit = self.ray(origin, axis, warm, tolerance).or_else(|| {
            let (t, _) = self.curve.project(Meridional::of(origin));
            self.ray(origin, axis, (t, 0.0), tolerance)
        })?;
        (self.from..=self.to).contains(&hit.0).then_some(hit)
    }

    /// (arc length, height) at which `origin + height · axis` meets the offset surface: Newton from `start`
    /// until a step is shorter than `tolerance` mm (the error is then of the order of its square).
    fn ray(&self, origin: &Point, axis: &Vector, start: (f64, f64), tolerance: f64) -> Option<(f64, f64)> {
        let (mut t, mut h) = start;
        for _ in 0..25 {
            let p = origin + axis * h;
            let r = norm2(p.x, p.y);
            if r < 1e-9 {
                return None;
            }
            let radial = (p.x * axis.x + p.y * axis.y) / r;
            let (c, d) = self.curve.offset_derivative(t, self.offset);
            let (fr, fz) = (c.r - r, c.z - p.z);
            // [radial, −d.r; axis.z, −d.z] · (dh, dt) = (fr, fz)
            let determinant = -radial * d.z + d.r * axis.z;
            if determinant.abs() < 1e-12 {
                return None;
            }
            let dh = (-fr * d.z + d.r * fz) / determinant;
            let dt = (radial * fz - axis.z * fr) / determinant;
            h += dh;
            t += dt;
            if dh.abs() + dt.abs() < tolerance {
                return Some((t, h));
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

    /// A circle about Z that the disc must clear by the offset, also from beside.
    fn edge_touch(
        &self,
        edge: Meridional,
        on_axis: &Point,
        axis: &Vector,
        radius: f64,
        consider: &mut dyn FnMut(f64, &dyn Fn() -> Touch),
    ) {
        let limit = radius + self.offset;
        // (distance from the axis, height along it) of the circle's point at theta.
        let at = |theta: f64| {
            let d = edge.at_angle(theta) - on_axis;
            let height = d.dot(axis);
            ((d.norm_squared() - height * height).max(0.0).sqrt(), height)
        };
        // The circle's point nearest to the axis, by going back and forth twice.
        let mut theta = on_axis.y.atan2(on_axis.x);
        for _ in 0..3 {
            let foot = on_axis + axis * at(theta).1;
            theta = foot.y.atan2(foot.x);
        }
        if at(theta).0 > 1.5 * limit + 1.0 {
            return;
        }
        let lift = |theta: f64| {
            let (distance, height) = at(theta);
            let beside = (distance - radius).max(0.0);
            if beside >= self.offset.max(1e-12) {
                // Out of reach: a slope back towards the reach keeps the search going.
                return height - 1e3 - beside;
            }
            height + (self.offset * self.offset - beside * beside).max(0.0).sqrt()
        };
        let half = (1.6 * limit / edge.r).min(std::f64::consts::PI);
        let steps = 32;
        let sample = |i: usize| theta - half + 2.0 * half * i as f64 / steps as f64;
        let best = (0..=steps).max_by(|&a, &b| lift(sample(a)).total_cmp(&lift(sample(b)))).unwrap_or(0);
        let (low, high) = (sample(best.saturating_sub(1)), sample((best + 1).min(steps)));
        let (refined, value) = search::minimum(|x| -lift(x), low, high, 1e-9);
        let (theta, height) =
            if -value >= lift(sample(best)) { (refined, -value) } else { (sample(best), lift(sample(best))) };
        if at(theta).0 - radius < self.offset.max(1e-12) {
            consider(height, &|| {
                let point = edge.at_angle(theta);
                let plane = on_axis + axis * height;
                let nearest = {
                    let d = point - plane;
                    let flat = d - axis * d.dot(axis);
                    let n = flat.norm();
                    if n > radius { plane + flat * (radius / n) } else { plane + flat }
                };
                let (arc, _) = self.curve.project(edge);
                Touch { height, point: nearest, arc }
            });
        }
    }
}
