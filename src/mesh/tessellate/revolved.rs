//! Surfaces of revolution: the hub with its body, and the shroud.

use std::f64::consts::{PI, TAU};

use crate::geometry::{Meridional, MeridionalCurve, Point, Vector};
use crate::mesh::solid::{FaceKind, Grid, Solid};
use crate::part::body::{body_outline, inside};
use crate::part::{Flowpath, Impeller};

/// Smallest number of angular steps of a full turn.
const MIN_STEPS: usize = 24;
/// Largest change of direction of hub or shroud between rings beyond that of constant curvature, rad, in
/// units of chord error / curve length. Plans need accurate normals, and the chord error does not refine
/// where a bend begins.
const TURN: f64 = 3.0;
/// Rings closer together than this are merged, mm.
const SAME: f64 = 1e-9;

/// The hub with its body; closed.
pub(super) fn tessellate_hub(part: &Impeller, chord_error: f64) -> Solid {
    let outline = body_outline(part);
    let widest = outline.iter().map(|p| p.r).fold(0.0, f64::max);
    let error = chord_error_share(&part.hub, chord_error);
    let mut turned = RevolvedMesher::new(widest, error);
    let curve = part.hub.curve();
    let stations = stations(&part.hub, error);
    let rings: Vec<_> =
        stations.iter().map(|&t| (turned.ring(inside(curve.point(t))), curve.at(t).normal)).collect();
    turned.add(FaceKind::Hub, &rings);
    let Some((&(first, _), &(last, _))) = rings.first().zip(rings.last()) else { return turned.solid };
    let mut ends = [last; 5];
    for k in 1..4 {
        let same = outline[k].distance(outline[k - 1]) < SAME;
        ends[k] = if same { ends[k - 1] } else { turned.ring(outline[k]) };
    }
    ends[4] = first;
    for k in 1..5 {
        let (a, b) = (outline[k - 1], outline[k]);
        // At right angles to the outline; `add_grid` flips it to the side of the triangles.
        let normal = Meridional { r: b.z - a.z, z: a.r - b.r };
        turned.add(FaceKind::Body, &[(ends[k - 1], normal), (ends[k], normal)]);
    }
    orient_outwards(turned.solid)
}

/// The shroud: an open sheet with normals that point away from the channel.
pub(super) fn tessellate_shroud(part: &Impeller, chord_error: f64) -> Solid {
    let curve = part.shroud.curve();
    let error = chord_error_share(&part.shroud, chord_error);
    let stations = stations(&part.shroud, error);
    let widest = stations.iter().map(|&t| curve.point(t).r).fold(0.0, f64::max);
    let mut turned = RevolvedMesher::new(widest, error);
    let rings: Vec<_> =
        stations.iter().map(|&t| (turned.ring(inside(curve.point(t))), curve.at(t).normal)).collect();
    turned.add(FaceKind::Shroud, &rings);
    let mut solid = turned.solid;
    let away = solid.faces.iter().flat_map(|f| &f.corners).map(|corner| {
        let p = solid.points[corner.point as usize];
        let outer = curve.at(curve.project(Meridional::from_point(&p)).0).normal;
        corner.normal.dot(&outer.direction_at_angle(p.y.atan2(p.x)))
    });
    if away.sum::<f64>() < 0.0 {
        solid.reverse_orientation();
    }
    solid
}

/// Number of triangles of hub and shroud, computed without tessellating them.
pub(super) fn count_triangles(part: &Impeller, chord_error: f64) -> usize {
    let of = |path: &Flowpath, more: usize| {
        let error = chord_error_share(path, chord_error);
        2 * (stations(path, error).len() + more) * RevolvedMesher::new(part.rim_radius(), error).steps
    };
    of(&part.hub, 4) + of(&part.shroud, 0)
}

/// Reverses the orientation of a closed solid if it faces inwards.
pub(super) fn orient_outwards(mut solid: Solid) -> Solid {
    if solid.volume_sixfold() < 0.0 {
        solid.reverse_orientation();
    }
    solid
}

/// Chord error allowed each for chords along the meridian and around the axis, mm. Where the two curvatures
/// have opposite signs, as on most flowpaths, the errors have opposite signs, too, and do not add up.
fn chord_error_share(path: &Flowpath, chord_error: f64) -> f64 {
    let (start, end) = (path.arc_at(path.wheel_from()), path.arc_at(1.0));
    let opposite = (0..=200).all(|i| {
        let here = path.curve().at(start + (end - start) * f64::from(i) / 200.0);
        here.curvature * here.normal.r >= 0.0
    });
    if opposite { 0.95 * chord_error } else { 0.5 * chord_error }
}

/// Arc lengths of a flowpath, from its nose to the rim, between which chords stay within `error`, mm.
fn stations(path: &Flowpath, error: f64) -> Vec<f64> {
    let (start, end) = (path.arc_at(path.wheel_from()), path.arc_at(1.0));
    let mut stations = vec![start];
    let pieces = 4;
    let turn = TURN * error / (end - start);
    for k in 0..pieces {
        let at = |k: usize| start + (end - start) * k as f64 / pieces as f64;
        halve(path.curve(), at(k), at(k + 1), (error, turn), &mut stations);
    }
    stations
}

/// Bisects the interval from `a` (already in the list) to `b` until chords are within `error`, mm, of the
/// curve and the varying part of the curvature changes its direction by at most `turn`, rad, within each.
fn halve(curve: &MeridionalCurve, a: f64, b: f64, (error, turn): (f64, f64), into: &mut Vec<f64>) {
    let (p, q) = (curve.point(a), curve.point(b));
    let length = p.distance(q).max(1e-12);
    let off = |share: f64| {
        let m = curve.point(a + (b - a) * share);
        ((m.r - p.r) * (q.z - p.z) - (m.z - p.z) * (q.r - p.r)).abs() / length
    };
    let worst = [0.25, 0.5, 0.75].map(off).into_iter().fold(0.0, f64::max);
    let bends = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| curve.at(a + (b - a) * share).curvature);
    let (least, most) =
        bends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), k| (l.min(*k), m.max(*k)));
    let uneven = (most - least) * (b - a) / 8.0;
    if (worst > error || uneven > turn) && b - a > 1e-6 {
        let middle = 0.5 * (a + b);
        halve(curve, a, middle, (error, turn), into);
        halve(curve, middle, b, (error, turn), into);
    } else {
        into.push(b);
    }
}

/// A solid under construction from rings about the axis.
struct RevolvedMesher {
    solid: Solid,
    steps: usize,
}

/// Points of a ring: (index of the first, their number; one on the axis).
type PointRing = (u32, u32);

impl RevolvedMesher {
    /// Chooses the number of steps so that the sagitta at the radius `widest` stays within `error`, mm.
    fn new(widest: f64, error: f64) -> Self {
        let half_step = (1.0 - (error / widest.max(1e-9)).min(1.0)).acos();
        let steps = (PI / half_step.max(1e-6)).ceil() as usize;
        Self { solid: Solid::default(), steps: steps.max(MIN_STEPS) }
    }

    fn angle(&self, j: usize) -> f64 {
        TAU * (j % self.steps) as f64 / self.steps as f64
    }

    fn ring(&mut self, p: Meridional) -> PointRing {
        let first = self.solid.points.len() as u32;
        if p.r < SAME {
            self.solid.points.push(Point::new(0.0, 0.0, p.z));
            return (first, 1);
        }
        for j in 0..self.steps {
            self.solid.points.push(p.at_angle(self.angle(j)));
        }
        (first, self.steps as u32)
    }

    /// Adds the face through rings, each given with its meridional normal.
    fn add(&mut self, kind: FaceKind, rings: &[(PointRing, Meridional)]) {
        let columns = self.steps + 1;
        let points = rings
            .iter()
            .flat_map(|&((first, count), _)| (0..columns as u32).map(move |j| first + j % count))
            .collect();
        let grid = Grid { rows: rings.len(), columns, points };
        let directions: Vec<(f64, f64)> = (0..columns).map(|j| self.angle(j).sin_cos()).collect();
        self.solid.add_grid(kind, &grid, |i, j| {
            let ((_, count), n) = rings[i];
            let (sin, cos) = directions[j];
            // On the axis, only the axial component is common to all angles.
            let radial = if count > 1 { n.r } else { 0.0 };
            Vector::new(radial * cos, radial * sin, n.z).try_normalize(1e-9).unwrap_or_else(Vector::zeros)
        });
    }
}
