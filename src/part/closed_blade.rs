//! A blade as a closed body: its sides, and the ruled faces between them at its tip and its ends.

use super::closed_surface::ClosedSurface;
use super::probe::{NearestOnSide, SideProbe};
use super::side::BladeSide;
use crate::geometry::{Point, Vector};

/// Distance of the ends of both sides, mm, up to which they meet in an edge.
const MEETING: f64 = 1e-4;
/// Intervals by which a ruled face follows its edges between two knots of either.
const REFINEMENT: usize = 3;
/// Cosine of the angle between a face's normal and the way to its nearest point above which the point is
/// beside the face, not beside one of its edges.
const BESIDE: f64 = 0.98;
/// Places along and across a blade by which it is triangulated, and at which its thickness is measured.
const ALONG: usize = 64;
const ACROSS: usize = 12;
/// Share of the triangles that tells how far they are from the surface: the others are those of folds.
const MOST: f64 = 0.9;

/// A face of a blade.
#[derive(Clone, Debug)]
struct BladeFace {
    probe: SideProbe,
    /// +1 where ∂u × ∂v points out of the blade, else −1.
    outward: f64,
}

/// A blade as a closed body on the hub.
///
/// Its tip is the ruled face between the upper edges of its sides, and where they do not meet at an end, a
/// ruled face closes that end, too. So are blades drawn.
#[derive(Clone, Debug)]
pub struct ClosedBlade {
    faces: Vec<BladeFace>,
    /// Ball around it: centre and radius, mm.
    ball: (Point, f64),
    half_thickness: f64,
    /// Its triangulated surface, and how far [`MOST`] of the triangles are from it at most, mm.
    surface: ClosedSurface,
    chord_error: f64,
}

impl ClosedBlade {
    /// The blade between its two sides.
    pub fn new(sides: [&BladeSide; 2]) -> Self {
        let at = |which: usize, u: f64, v: f64| sides[which].point(u, v);
        let middle = |u: f64, v: f64| nalgebra::center(&at(0, u, v), &at(1, u, v));
        // The direction from `inner`, a point in the blade, tells where its outside is.
        let face = |side: &BladeSide, inner: Point| {
            let (p, by_u, by_v) = side.derivatives(0.5, 0.5);
            let outward = 1f64.copysign(by_u.cross(&by_v).dot(&(p - inner)));
            BladeFace { probe: SideProbe::new(side, 0.0, 1.0), outward }
        };
        let mut faces: Vec<BladeFace> = sides.map(|side| face(side, middle(0.5, 0.5))).into();
        faces.push(face(&tip_face(sides), middle(0.5, 0.9)));
        for (end, before) in [(0.0, 0.1), (1.0, 0.9)] {
            faces.extend(end_face(sides, end).map(|strip| face(&strip, middle(before, 0.5))));
        }
        let balls: Vec<(Point, f64)> = faces.iter().map(|face| face.probe.bounding_ball()).collect();
        let centre = Point::from(balls.iter().map(|ball| ball.0.coords).sum::<Vector>() / balls.len() as f64);
        let radius = balls.iter().map(|(at, radius)| (at - centre).norm() + radius).fold(0.0, f64::max);
        let places = (0..=ALONG).flat_map(|i| (0..=ACROSS).map(move |j| (along(i), across(j))));
        let thickness = places.map(|(u, v)| (at(0, u, v) - at(1, u, v)).norm()).fold(0.0, f64::max);
        let (triangles, chord_error) = triangulated(sides);
        let surface = ClosedSurface::new(triangles);
        Self { faces, ball: (centre, radius), half_thickness: 0.5 * thickness, surface, chord_error }
    }

    /// Signed distance of `point` to the surface of the blade above the hub, mm; negative inside. `None` when
    /// it is outside and certainly more than `cutoff` mm away.
    pub fn distance_below(&self, point: &Point, cutoff: f64) -> Option<f64> {
        // Inside it may be deeper than that.
        let cutoff = cutoff.max(self.half_thickness);
        if (point - self.ball.0).norm() - self.ball.1 > cutoff {
            return None;
        }
        let mut nearest: Option<(&BladeFace, NearestOnSide)> = None;
        for face in &self.faces {
            let cutoff = nearest.as_ref().map_or(cutoff, |(_, near)| near.distance);
            let found = face.probe.nearest_to_point_below(point, cutoff);
            if let Some(near) = found.filter(|near| nearest.is_none() || near.distance < cutoff) {
                nearest = Some((face, near));
            }
        }
        let (face, near) = nearest?;
        let (p, by_u, by_v) = face.probe.side().derivatives(near.u, near.v);
        let normal = by_u.cross(&by_v).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let height = face.outward * normal.dot(&(point - p));
        // Beyond an edge the side of the face on which a point is says nothing. Nor does it where noisy
        // sections fold a face: what looks like a point inside is looked at twice, unless the triangles are
        // too coarse.
        let is_beside = height.abs() >= BESIDE * near.distance;
        let is_outside = if is_beside && (height > 0.0 || near.distance <= self.chord_error) {
            height > 0.0
        } else {
            !self.surface.contains(point)
        };
        Some(if is_outside { near.distance } else { -near.distance })
    }
}

/// The faces of a blade between its sides: at its tip, and at ends where they do not meet.
pub(super) fn faces_between(sides: [&BladeSide; 2]) -> Vec<BladeSide> {
    let ends = [0.0, 1.0].into_iter().filter_map(|end| end_face(sides, end));
    std::iter::once(tip_face(sides)).chain(ends).collect()
}

/// The ruled face between the upper edges of the sides.
fn tip_face(sides: [&BladeSide; 2]) -> BladeSide {
    ruled(sides.map(BladeSide::u_knots), |which, u| sides[which].point(u, 1.0))
}

/// The ruled face between the sides at the end where u is `end`; `None` where they meet there.
fn end_face(sides: [&BladeSide; 2], end: f64) -> Option<BladeSide> {
    let stations = sides.map(BladeSide::stations);
    let at = |which: usize, v: f64| sides[which].point(end, v);
    let apart = refined(stations).into_iter().map(|v| (at(0, v) - at(1, v)).norm());
    (apart.fold(0.0, f64::max) > MEETING).then(|| ruled(stations, at))
}

/// u of place `i` along a blade, closer towards both ends.
fn along(i: usize) -> f64 {
    0.5 - 0.5 * (std::f64::consts::PI * i as f64 / ALONG as f64).cos()
}

/// v of place `j` across a blade.
fn across(j: usize) -> f64 {
    j as f64 / ACROSS as f64
}

/// The closed surface between two sides as triangles in one sense, and how far [`MOST`] of these are from the
/// sides at most, mm.
fn triangulated(sides: [&BladeSide; 2]) -> (Vec<[Point; 3]>, f64) {
    let mut triangles = Vec::new();
    let mut add = |[a, b, c, d]: [Point; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    let mut chord_errors = Vec::with_capacity(4 * ALONG * ACROSS);
    let at = |which: usize, u: f64, v: f64| sides[which].point(u, v);
    for (i, j) in (0..ALONG).flat_map(|i| (0..ACROSS).map(move |j| (i, j))) {
        let ([u0, u1], [v0, v1]) = ([along(i), along(i + 1)], [across(j), across(j + 1)]);
        let corners =
            [0, 1].map(|which| [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| at(which, u, v)));
        for (which, [a, b, c, d]) in corners.iter().enumerate() {
            let middle = at(which, 0.5 * (u0 + u1), 0.5 * (v0 + v1));
            for chord in [nalgebra::center(a, c), nalgebra::center(b, d)] {
                chord_errors.push((middle - chord).norm());
            }
        }
        let [[a, b, c, d], other] = corners;
        add([a, b, c, d]);
        add([other[0], other[3], other[2], other[1]]);
    }
    for i in 0..ALONG {
        let [u0, u1] = [along(i), along(i + 1)];
        add([at(0, u0, 1.0), at(0, u1, 1.0), at(1, u1, 1.0), at(1, u0, 1.0)]);
        add([at(0, u0, 0.0), at(1, u0, 0.0), at(1, u1, 0.0), at(0, u1, 0.0)]);
    }
    for j in 0..ACROSS {
        let [v0, v1] = [across(j), across(j + 1)];
        add([at(0, 1.0, v0), at(1, 1.0, v0), at(1, 1.0, v1), at(0, 1.0, v1)]);
        add([at(0, 0.0, v0), at(0, 0.0, v1), at(1, 0.0, v1), at(1, 0.0, v0)]);
    }
    chord_errors.sort_by(f64::total_cmp);
    let kept = (MOST * chord_errors.len() as f64) as usize;
    (triangles, chord_errors[kept])
}

/// The values of both lists, with some between them.
fn refined(knots: [&[f64]; 2]) -> Vec<f64> {
    let mut all: Vec<f64> = knots.concat();
    all.retain(|t| (0.0..=1.0).contains(t));
    all.extend([0.0, 1.0]);
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| *a - *b < 1e-6);
    let between = |pair: &[f64]| {
        let (a, b) = (pair[0], pair[1]);
        (0..REFINEMENT).map(move |i| a + (b - a) * i as f64 / REFINEMENT as f64)
    };
    all.windows(2).flat_map(between).chain([1.0]).collect()
}

/// The ruled face between two edges over 0 to 1, which is its u.
fn ruled(knots: [&[f64]; 2], edge: impl Fn(usize, f64) -> Point) -> BladeSide {
    let along = refined(knots);
    let edges = [0, 1].map(|which| along.iter().map(|&t| edge(which, t)).collect());
    BladeSide::loft(&along, &[0.0, 1.0], &edges)
}
