//! The hub ahead of the blades: collars, nut seats and bosses behind sharp corners are faces of their own, on
//! which no blade stands. Tools have to keep clear of them, so that they belong to the curve of the hub.

use std::collections::HashMap;

use super::surface::MeshSurface;
use crate::geometry::{Meridional, MeridionalCurve, Point, norm2};

/// Number of half planes through the axis in which the body is cut, and the angle of the first, rad: that of
/// no likely edge.
const HALF_PLANES: usize = 48;
const FIRST_ANGLE: f64 = 0.0377;
/// Share of the half planes in which the outline has to be found.
const FOUND: f64 = 0.2;
/// Place on the hub's curve, as a share of its length, from which the outline is followed to the front.
const FROM: f64 = 0.015;
/// Depth behind the beginning of the curve, and distance outside of it, at which the outline is left, as a
/// share of the length of the curve: it has entered the bore, or a cover.
const DIP: f64 = 0.1;
const OUTSIDE: f64 = 0.05;
/// Turn of the outline from which on a place is a corner, rad.
const CORNER: f64 = 0.26;
/// Turn of the outline at which a wall ends in the rounded corner at its foot, rad.
const BENT: f64 = 0.02;
/// Length of the rounding on either side of a corner, and largest distance of points, as shares of the length
/// of the curve.
const ROUNDING: f64 = 1.0 / 600.0;
const SPACING: f64 = 1.0 / 512.0;
/// Points on the rounding of a corner, and how much further apart points are with the distance from it.
const AT_CORNER: usize = 8;
const GROWTH: f64 = 0.3;
const NOTHING: usize = usize::MAX;

/// The outline of `body`, about Z, from the beginning of its `hub` towards the front: as far as it comes.
/// Empty where the hub begins at the front already. The hub's curve is within `tolerance`, mm, of the body.
///
/// Keyways, holes and blades interrupt the outline in some half planes: of those found it is the one that
/// encloses the median volume.
pub fn outline_ahead(
    body: &MeshSurface,
    hub: &[Meridional],
    inlet_up: bool,
    tolerance: f64,
) -> Vec<Meridional> {
    let curve = MeridionalCurve::through(hub);
    let reach = hub[0].r + OUTSIDE * curve.length() + curve.point(FROM * curve.length()).distance(hub[0]);
    let near: Vec<[u32; 3]> = body
        .triangles
        .iter()
        .filter(|t| t.iter().any(|i| Meridional::from_point(&body.points[*i as usize]).r < 2.0 * reach))
        .copied()
        .collect();
    let up = |p: Meridional| if inlet_up { p.z } else { -p.z };
    let mut found: Vec<(f64, Vec<Meridional>)> = Vec::new();
    for k in 0..HALF_PLANES {
        let angle = FIRST_ANGLE + std::f64::consts::TAU * k as f64 / HALF_PLANES as f64;
        let section = HalfPlaneSection::new(&body.points, &near, angle);
        let Some(mut line) = section.follow(&curve, &up, tolerance) else { continue };
        let top = line.iter().map(|p| up(*p)).fold(f64::NEG_INFINITY, f64::max);
        // A plane front is closed by itself.
        let first = line.iter().position(|p| up(*p) > top - 0.2 * tolerance).unwrap_or(0);
        line.truncate(first + 1);
        let slice = |w: &[Meridional]| (w[0].r * w[0].r + w[1].r * w[1].r) * (up(w[1]) - up(w[0]));
        found.push((line.windows(2).map(slice).sum(), line));
    }
    if (found.len() as f64) < FOUND * HALF_PLANES as f64 {
        return Vec::new();
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = found.len() / 2;
    let line = found.swap_remove(middle).1;
    let rises = line.last().is_some_and(|front| up(*front) > up(hub[0]) + tolerance);
    if rises { line } else { Vec::new() }
}

/// The wall of a boss along the outline `ahead` of a hub: up to the first corner over which it turns towards
/// the axis, or the end of the outline, and as far back from there as it is straight.
pub fn wall_of(ahead: &[Meridional], inlet_up: bool) -> Option<&[Meridional]> {
    let inwards = if inlet_up { 1.0 } else { -1.0 };
    let turn_at = |k: usize| inwards * turn(ahead[k - 1], ahead[k], ahead[k + 1]);
    let top = (1..ahead.len()).find(|k| *k + 1 == ahead.len() || turn_at(*k) > CORNER)?;
    let bottom = (1..top).rev().find(|k| turn_at(*k) < -BENT).unwrap_or(0);
    Some(&ahead[bottom..=top])
}

/// Angle between the directions of two stretches that meet in `b`, rad: positive from r towards z.
fn turn(a: Meridional, b: Meridional, c: Meridional) -> f64 {
    let (into, out) = ((b.r - a.r, b.z - a.z), (c.r - b.r, c.z - b.z));
    (into.0 * out.1 - into.1 * out.0).atan2(into.0 * out.0 + into.1 * out.1)
}

/// The curve of a hub with the outline `ahead` of it, which begins where the hub does: corners are rounded,
/// as a curve has a direction everywhere, by as little as it can follow.
pub fn joined_to(ahead: &[Meridional], hub: &[Meridional]) -> Vec<Meridional> {
    let flow = MeridionalCurve::through(hub);
    let mut front: Vec<Meridional> = ahead.iter().rev().copied().collect();
    front.dedup_by(|a, b| a.distance(*b) < 1e-6 * flow.length());
    if front.len() < 2 {
        return hub.to_vec();
    }
    let mut along = vec![0.0];
    for pair in front.windows(2) {
        along.push(along[along.len() - 1] + pair[0].distance(pair[1]));
    }
    let begin = along[along.len() - 1];
    let whole = begin + flow.length();
    let at = |s: f64| -> Meridional {
        if s >= begin {
            return flow.point(s - begin);
        }
        let k = along.partition_point(|x| *x <= s).clamp(1, along.len() - 1);
        front[k - 1].lerp(front[k], (s - along[k - 1]) / (along[k] - along[k - 1]))
    };
    let mut corners: Vec<f64> = Vec::new();
    for k in 1..front.len() {
        let next = front.get(k + 1).copied().unwrap_or_else(|| flow.point(ROUNDING * whole));
        if turn(front[k - 1], front[k], next).abs() > CORNER {
            corners.push(along[k]);
        }
    }
    // Stretches between the roundings, with the corner at the end of each.
    let mut points: Vec<Meridional> = Vec::new();
    let mut from = 0.0;
    for k in 0..=corners.len() {
        let room = |k: usize| {
            let (low, high) = (k.checked_sub(1).map_or(0.0, |b| corners[b]), corners.get(k + 1));
            let beside = (corners[k] - low).min(high.copied().unwrap_or(whole) - corners[k]);
            (ROUNDING * whole).min(0.4 * beside)
        };
        let round = (k < corners.len()).then(|| room(k));
        let to = round.map_or(whole, |round| corners[k] - round);
        let finest = ROUNDING * whole * 2.0 / AT_CORNER as f64;
        let mut s = from;
        while s < to {
            points.push(at(s));
            s += (finest + GROWTH * (s - from).min(to - s)).min(SPACING * whole);
            if to - s < 0.5 * finest {
                break;
            }
        }
        let Some(round) = round else { break };
        let (a, b, c) = (at(to), at(corners[k]), at(corners[k] + round));
        // A quadratic Bézier curve from one side of the corner to the other.
        points.extend((0..AT_CORNER).map(|k| {
            let x = k as f64 / AT_CORNER as f64;
            a.lerp(b, x).lerp(b.lerp(c, x), x)
        }));
        from = corners[k] + round;
    }
    points.push(at(whole));
    points
}

/// The section of a body with a half plane through Z, as a graph: places on edges of triangles, and the one
/// or two that each is joined to.
struct HalfPlaneSection {
    places: Vec<Meridional>,
    joined: Vec<[usize; 2]>,
}

impl HalfPlaneSection {
    fn new(points: &[Point], triangles: &[[u32; 3]], angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let aside = |p: &Point| p.y * cos - p.x * sin;
        let mut number: HashMap<(u32, u32), usize> = HashMap::new();
        let mut section = Self { places: Vec::new(), joined: Vec::new() };
        for t in triangles {
            let sides = t.map(|i| aside(&points[i as usize]) >= 0.0);
            if sides[0] == sides[1] && sides[1] == sides[2] {
                continue;
            }
            let mut ends = [NOTHING; 2];
            let mut count = 0;
            for k in 0..3 {
                if sides[k] == sides[(k + 1) % 3] {
                    continue;
                }
                let (a, b) = (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
                let (p, q) = (points[a as usize], points[b as usize]);
                let share = aside(&p) / (aside(&p) - aside(&q));
                let at = p + (q - p) * share;
                if at.x * cos + at.y * sin <= 0.0 {
                    break;
                }
                ends[count] = *number.entry((a, b)).or_insert_with(|| {
                    // Between corners at equal radii the chord is nearer to the axis than the surface.
                    section.places.push(Meridional::from_point(&p).lerp(Meridional::from_point(&q), share));
                    section.joined.push([NOTHING; 2]);
                    section.places.len() - 1
                });
                count += 1;
            }
            if count == 2 && ends[0] != ends[1] {
                for (a, b) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                    if let Some(free) = section.joined[a].iter_mut().find(|n| **n == NOTHING) {
                        *free = b;
                    }
                }
            }
        }
        section
    }

    /// From the beginning of `curve` along the section to the front; `None` where the section does not
    /// follow the beginning of the curve, as in a blade.
    fn follow(
        &self,
        curve: &MeridionalCurve,
        up: &dyn Fn(Meridional) -> f64,
        tolerance: f64,
    ) -> Option<Vec<Meridional>> {
        let (whole, begin) = (curve.length(), curve.point(0.0));
        let start = curve.point(FROM * whole);
        let stretches = (0..self.places.len()).flat_map(|a| self.joined[a].map(|b| (a, b)));
        let off = |&(a, b): &(usize, usize)| start.nearest_on_segment(self.places[a], self.places[b]).0;
        let (a, b) = stretches
            .filter(|(a, b)| *b != NOTHING && a < b)
            .min_by(|x, y| off(x).total_cmp(&off(y)))
            .filter(|x| off(x) < tolerance)?;
        let along = |k: usize| curve.project_past_ends(self.places[k]).0;
        let (mut before, mut here) = if along(a) > along(b) { (a, b) } else { (b, a) };
        // Over the beginning of the curve.
        let mut steps = 0;
        loop {
            let (t, height) = curve.project(self.places[here]);
            if height.abs() > tolerance || t <= 1e-9 * whole {
                break;
            }
            (before, here) = (here, self.next(before, here)?);
            steps += 1;
            if steps > self.places.len() {
                return None;
            }
        }
        if begin.nearest_on_segment(self.places[before], self.places[here]).0 > 2.0 * tolerance {
            return None;
        }
        let mut line = vec![begin];
        for _ in 0..self.places.len() {
            let p = self.places[here];
            let is_left = up(p) < up(begin) - DIP * whole || p.r > begin.r + OUTSIDE * whole;
            if is_left || p.r < 1e-6 * whole {
                break;
            }
            if norm2(p.r - begin.r, p.z - begin.z) > tolerance || line.len() > 1 {
                line.push(p);
            }
            let Some(next) = self.next(before, here) else { break };
            (before, here) = (here, next);
        }
        Some(line)
    }

    fn next(&self, before: usize, here: usize) -> Option<usize> {
        self.joined[here].into_iter().find(|n| *n != NOTHING && *n != before)
    }
}
