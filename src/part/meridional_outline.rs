//! A turned body: a closed outline in the meridional plane, revolved about Z.
//!
//! Its edges lie in a binary tree of bounding boxes over consecutive edges, in preorder. Queries descend it
//! and skip the boxes that cannot change the result.

mod edge_box;
mod meridian_line;

use crate::error::{ErrorCode, UserError};
use crate::geometry::{Meridional, Point, Vector, norm2, search};
use edge_box::{EdgeBox, SAME, add_boxes};
use meridian_line::MeridianLine;

/// Largest number of points of an outline.
pub const MAX_OUTLINE_POINTS: usize = 4000;
/// Distance of a point from the line between its neighbours below which it is left out, mm.
const STRAIGHT: f64 = 1e-7;
/// Area below which an outline bounds nothing, mm².
const MIN_AREA: f64 = 1e-6;
/// Chords of a line in the body shorter than this do not count, mm.
const MIN_CHORD: f64 = 1e-7;
/// Contacts that only touch the body before a line is taken as outside.
const MAX_TOUCHES: usize = 16;
/// Lines along the rim of a disc, and steps of the refinement between two of them.
const RIM_LINES: usize = 24;
const RIM_TOLERANCE: f64 = 1e-4;
/// Distance to a raised outline at which sphere tracing ends, mm, and its least step.
const TRACE_TOLERANCE: f64 = 1e-4;
const TRACE_STEP: f64 = 1e-3;
const TRACE_STEPS: usize = 400;

/// Why points do not bound a body.
#[derive(Clone, Debug, PartialEq)]
pub enum OutlineFault {
    /// There are too few.
    TooFew(usize),
    /// There are too many.
    TooMany(usize),
    /// A coordinate is not a finite number, or r is negative. Index of the point.
    NoPoint(usize),
    /// It encloses no area.
    Flat,
    /// Two edges cross, at this place.
    Crossed {
        /// Radius, mm.
        r: f64,
        /// Height, mm.
        z: f64,
    },
}

impl OutlineFault {
    /// What is wrong and what to do.
    pub fn explained(&self) -> UserError {
        let in_order = "give the outline point by point, in order";
        let (what, help) = match self {
            Self::TooFew(count) => (format!("the outline has {count} different points"), "give at least 2"),
            Self::TooMany(count) => (
                format!("the outline has {count} points, more than {MAX_OUTLINE_POINTS}"),
                "leave out points",
            ),
            Self::NoPoint(index) => (
                format!("point {index} of the outline is not a finite r ≥ 0 and z"),
                "give the distance from the axis, then the height",
            ),
            Self::Flat => ("the outline encloses no area".to_owned(), in_order),
            Self::Crossed { r, z } => (format!("the outline crosses itself at r {r:.3}, z {z:.3}"), in_order),
        };
        UserError::new(ErrorCode::BlankFile, what, help)
    }
}

/// A closed outline (r, z), mm, to be revolved about Z.
#[derive(Clone, Debug)]
pub struct MeridionalOutline {
    points: Vec<Meridional>,
    /// The edges, without those on the axis.
    edges: Vec<(Meridional, Meridional)>,
    boxes: Vec<EdgeBox>,
    /// Points where the body has a convex edge.
    convex_edges: Vec<Meridional>,
}

impl PartialEq for MeridionalOutline {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points
    }
}

impl MeridionalOutline {
    /// The outline through `points`. It is closed where the last point repeats the first; else both of its
    /// ends go straight to the axis, at their heights.
    ///
    /// # Errors
    /// When the points do not bound a body.
    pub fn new(points: &[Meridional]) -> Result<Self, OutlineFault> {
        if points.len() > MAX_OUTLINE_POINTS {
            return Err(OutlineFault::TooMany(points.len()));
        }
        let sound = |p: &Meridional| p.r.is_finite() && p.z.is_finite() && p.r >= -SAME;
        if let Some(index) = points.iter().position(|p| !sound(p)) {
            return Err(OutlineFault::NoPoint(index + 1));
        }
        let mut cleaned: Vec<Meridional> =
            points.iter().map(|p| Meridional { r: p.r.max(0.0), z: p.z }).collect();
        cleaned.dedup_by(|a, b| a.distance(*b) < SAME);
        let (Some(&first), Some(&last)) = (cleaned.first(), cleaned.last()) else {
            return Err(OutlineFault::TooFew(0));
        };
        if cleaned.len() < 2 {
            return Err(OutlineFault::TooFew(cleaned.len()));
        }
        if first.distance(last) < SAME {
            cleaned.pop();
        } else {
            cleaned
                .extend([last, first].iter().filter(|p| p.r > SAME).map(|p| Meridional { r: 0.0, z: p.z }));
        }
        Self::closed(cleaned)
    }

    /// The outline through points whose last is joined to the first.
    fn closed(points: Vec<Meridional>) -> Result<Self, OutlineFault> {
        let mut points = without_straight_points(points);
        let around = |points: &[Meridional]| {
            let edges = points.iter().zip(points.iter().cycle().skip(1));
            0.5 * edges.map(|(a, b)| a.r * b.z - b.r * a.z).sum::<f64>()
        };
        let area = around(&points);
        if points.len() < 3 || area.abs() < MIN_AREA {
            return Err(OutlineFault::Flat);
        }
        if area < 0.0 {
            points.reverse();
        }
        let count = points.len();
        let at = |i: usize| points[i % count];
        let edges: Vec<_> =
            (0..count).map(|i| (at(i), at(i + 1))).filter(|(a, b)| a.r > SAME || b.r > SAME).collect();
        if let Some(place) = crossing_of(&edges) {
            return Err(OutlineFault::Crossed { r: place.r, z: place.z });
        }
        // Counter-clockwise: a convex corner turns left.
        let turns_left = |a: Meridional, b: Meridional, c: Meridional| {
            (b.r - a.r) * (c.z - b.z) - (b.z - a.z) * (c.r - b.r) > 0.0
        };
        let convex_edges = (0..count)
            .filter(|&i| turns_left(at(i + count - 1), at(i), at(i + 1)))
            .map(at)
            .filter(|p| p.r > SAME)
            .collect();
        let mut boxes = Vec::new();
        add_boxes(&edges, 0, edges.len(), &mut boxes);
        Ok(Self { points, edges, boxes, convex_edges })
    }

    /// The points, counter-clockwise in the plane (r, z); the last is joined to the first.
    pub fn points(&self) -> &[Meridional] {
        &self.points
    }

    /// Largest radius, and the range of heights, mm.
    pub fn bounds(&self) -> (f64, (f64, f64)) {
        self.boxes.first().map_or((0.0, (0.0, 0.0)), |all| (all.high.r, (all.low.z, all.high.z)))
    }

    /// Whether `point` is in the body: the number of edges outside of it in r is odd.
    pub fn contains(&self, point: Meridional) -> bool {
        let mut inside = false;
        let mut index = 0;
        while let Some(here) = self.boxes.get(index) {
            if here.high.r <= point.r || here.high.z < point.z || here.low.z > point.z {
                index = here.next as usize;
                continue;
            }
            for (a, b) in self.leaf(here) {
                let crosses = (a.z > point.z) != (b.z > point.z)
                    && point.r < a.r + (b.r - a.r) * (point.z - a.z) / (b.z - a.z);
                inside ^= crosses;
            }
            index += 1;
        }
        inside
    }

    /// Distance from `point` to the surface, mm, negative in the body, and the nearest point of the surface.
    pub fn signed_distance(&self, point: Meridional) -> (f64, Meridional) {
        let (distance, foot) = self.nearest(point);
        (if self.contains(point) { -distance } else { distance }, foot)
    }

    fn nearest(&self, point: Meridional) -> (f64, Meridional) {
        let mut best = (f64::INFINITY, point);
        let gap = |b: &EdgeBox| {
            norm2(
                (b.low.r - point.r).max(point.r - b.high.r).max(0.0),
                (b.low.z - point.z).max(point.z - b.high.z).max(0.0),
            )
        };
        // A first leaf, by the nearer box at each level, for a bound.
        let mut index = 0;
        while let Some(here) = self.boxes.get(index) {
            if here.edges.0 < here.edges.1 {
                best = nearest_of(self.leaf(here), point, best);
                break;
            }
            let second = self.boxes.get(index + 1).map_or(index + 1, |first| first.next as usize);
            let (a, b) = (self.boxes.get(index + 1), self.boxes.get(second));
            let is_second = a.zip(b).is_some_and(|(a, b)| gap(b) < gap(a));
            index = if is_second { second } else { index + 1 };
        }
        let mut index = 0;
        while let Some(here) = self.boxes.get(index) {
            if gap(here) >= best.0 {
                index = here.next as usize;
                continue;
            }
            best = nearest_of(self.leaf(here), point, best);
            index += 1;
        }
        best
    }

    /// The edges of a leaf; none of another box.
    fn leaf(&self, of: &EdgeBox) -> &[(Meridional, Meridional)] {
        &self.edges[of.edges.0 as usize..of.edges.1 as usize]
    }

    /// Highest h in [`low`, `high`] at which `origin + h · direction` (unit) is in the body.
    pub fn highest_inside(&self, origin: &Point, direction: &Vector, low: f64, high: f64) -> Option<f64> {
        let at = |h: f64| Meridional::from_point(&(origin + direction * h));
        if self.contains(at(high)) {
            return Some(high);
        }
        let line = MeridianLine::new(origin, direction);
        let mut high = high;
        for _ in 0..MAX_TOUCHES {
            let crossing = self.highest_crossing(&line, low, high)?;
            if self.contains(at(crossing - MIN_CHORD)) {
                return Some(crossing);
            }
            high = crossing - MIN_CHORD;
        }
        None
    }

    /// Highest h in [`low`, `high`] at which a line crosses the surface.
    fn highest_crossing(&self, line: &MeridianLine, low: f64, high: f64) -> Option<f64> {
        let mut best: Option<f64> = None;
        let mut index = 0;
        while let Some(here) = self.boxes.get(index) {
            let bottom = best.unwrap_or(low);
            if !line.may_meet(here, bottom, high) {
                index = here.next as usize;
                continue;
            }
            for (a, b) in self.leaf(here) {
                let found = line.crossings(*a, *b).into_iter().flatten();
                let highest = found.filter(|h| (low..=high).contains(h)).reduce(f64::max);
                best = best.into_iter().chain(highest).reduce(f64::max);
            }
            index += 1;
        }
        best
    }

    /// Height along `axis` (unit) above `centre` of the highest point of the body, raised by `offset` mm to
    /// its outside, that a disc of `radius` mm meets while it moves on the axis between heights `low` and
    /// `high`. `None` where the disc misses the body.
    ///
    /// The highest point is on a convex edge of the body within the disc, or above the rim of the disc: of
    /// the first all are considered, the second is searched.
    pub fn touch_height(
        &self,
        centre: &Point,
        axis: &Vector,
        (radius, offset): (f64, f64),
        (low, high): (f64, f64),
    ) -> Option<f64> {
        let mut best: Option<f64> = None;
        let heading = axis.y.atan2(axis.x);
        for edge in &self.convex_edges {
            for side in [0.0, std::f64::consts::PI] {
                let d = edge.at_angle(heading + side) - centre;
                let along = d.dot(axis);
                let height = along + offset;
                if best.is_none_or(|best| height > best) && (d - axis * along).norm() <= radius {
                    best = Some(height);
                }
            }
        }
        let (e1, e2) = crate::geometry::frame_about(axis);
        let height = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            let origin = centre + (e1 * cos + e2 * sin) * radius;
            if offset > 0.0 {
                self.trace_to_offset(&origin, axis, offset, (low, high))
            } else {
                self.highest_inside(&origin, axis, low, high)
            }
        };
        let step = std::f64::consts::TAU / RIM_LINES as f64;
        let lines: [Option<f64>; RIM_LINES] = std::array::from_fn(|i| height(step * i as f64));
        // Towards and away from the rotation axis, where a disc overlaps a cylinder first.
        let radial = Vector::new(centre.x, centre.y, 0.0);
        let inwards = radial.dot(&e2).atan2(radial.dot(&e1));
        best = [height(inwards), height(inwards + std::f64::consts::PI)]
            .into_iter()
            .chain(lines)
            .flatten()
            .chain(best)
            .reduce(f64::max);
        let floor = low - 1.0;
        let level = |i: usize| lines[i % RIM_LINES].unwrap_or(floor);
        for i in 0..RIM_LINES {
            let here = level(i);
            let is_peak = here > floor && here >= level(i + RIM_LINES - 1) && here >= level(i + 1);
            // A peak between lines is at most as steep as the lines beside it are apart.
            let rise = (here - level(i + RIM_LINES - 1)).max(here - level(i + 1)).min(2.0 * radius);
            if !is_peak || best.is_some_and(|best| here + rise <= best) {
                continue;
            }
            let middle = step * i as f64;
            let (_, value) = search::minimum(
                |phi| -height(phi).unwrap_or(floor),
                middle - step,
                middle + step,
                RIM_TOLERANCE,
            );
            best = best.into_iter().chain([-value]).reduce(f64::max).filter(|h| *h > floor);
        }
        best
    }

    /// Highest point of a line within `offset` mm of the body, by sphere tracing.
    fn trace_to_offset(
        &self,
        origin: &Point,
        axis: &Vector,
        offset: f64,
        (low, high): (f64, f64),
    ) -> Option<f64> {
        let mut h = high;
        for _ in 0..TRACE_STEPS {
            let gap = self.signed_distance(Meridional::from_point(&(origin + axis * h))).0 - offset;
            if gap < TRACE_TOLERANCE {
                return Some(h);
            }
            h -= gap.max(TRACE_STEP);
            if h < low {
                return None;
            }
        }
        // Grazing: taken as contact.
        Some(h)
    }
}

/// Without points on the line between their neighbours.
fn without_straight_points(points: Vec<Meridional>) -> Vec<Meridional> {
    let count = points.len();
    let mut kept: Vec<Meridional> = Vec::with_capacity(count);
    for (i, &p) in points.iter().enumerate() {
        let before = kept.last().copied().unwrap_or(points[count - 1]);
        let after = points[(i + 1) % count];
        let between = (p.r - before.r) * (after.r - p.r) + (p.z - before.z) * (after.z - p.z) > 0.0;
        if !(between && p.nearest_on_segment(before, after).0 < STRAIGHT) {
            kept.push(p);
        }
    }
    kept
}

fn nearest_of(
    edges: &[(Meridional, Meridional)],
    point: Meridional,
    best: (f64, Meridional),
) -> (f64, Meridional) {
    let feet = edges.iter().map(|(a, b)| point.nearest_on_segment(*a, *b));
    feet.fold(best, |best, foot| if foot.0 < best.0 { foot } else { best })
}

/// A place where two edges cross that have no end in common.
fn crossing_of(edges: &[(Meridional, Meridional)]) -> Option<Meridional> {
    let side =
        |a: Meridional, b: Meridional, p: Meridional| (b.r - a.r) * (p.z - a.z) - (b.z - a.z) * (p.r - a.r);
    for (i, &(a, b)) in edges.iter().enumerate() {
        let (low, high) = (a.z.min(b.z), a.z.max(b.z));
        for &(c, d) in &edges[i + 1..] {
            if c.z.max(d.z) < low || c.z.min(d.z) > high {
                continue;
            }
            let (p, q) = (side(a, b, c), side(a, b, d));
            if p * q < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
                return Some(c.lerp(d, p / (p - q)));
            }
        }
    }
    None
}
