//! Blades that begin in a boss of the hub: paddles of a pump or blower that stand on its disc and run into
//! the wall of the boss, which joins them to each other.

use std::collections::BTreeMap;

use super::TriangleMesh;
use super::nose::{outline_ahead, wall_of};
use super::surface::MeshSurface;
use super::trim::trimmed;
use super::weld::NONE;
use crate::geometry::{Meridional, MeridionalCurve, Point, Vector, norm2, wrap_angle};

/// Distance of the cut from the wall of a boss, as a share of the length of both curves: beyond the rounded
/// corner at its foot.
const CLEAR: f64 = 1.0 / 400.0;
/// Length of stretches of a hub's curve, as a share of it, angle between two of them from which on it turns
/// quickly, and angle by which it turns so at the foot of a boss, rad.
const STRETCH: f64 = 0.05;
const QUICK: f64 = 0.17;
const FOOT: f64 = 0.9;
/// Angle between curve and disc within which the rounded corner has ended, rad.
const STRAIGHT: f64 = 0.05;
/// Distance behind a wall up to which blades go on, in tolerances, and smallest way towards it of a step of
/// 1 mm.
const PAST_WALL: f64 = 50.0;
const LEAST_SPEED: f64 = 0.2;
/// Number of places on a curve.
const PLACES: usize = 240;

/// Arc length at which the rounded corner between the wall of a boss and the disc of a `hub` ends; `None`
/// where the curve does not turn quickly.
pub fn end_of_foot(hub: &MeridionalCurve) -> Option<f64> {
    let reach = STRETCH * hub.length();
    let at = |k: usize| hub.length() * k as f64 / PLACES as f64;
    let chord = |from: f64, to: f64| {
        let (a, b) = (hub.point(from), hub.point(to));
        (b.r - a.r, b.z - a.z)
    };
    let angle = |(a, b): (f64, f64), (c, d): (f64, f64)| (a * d - b * c).atan2(a * c + b * d).abs();
    let turns_quickly =
        |k: &usize| angle(chord(at(*k) - reach, at(*k)), chord(at(*k), at(*k) + reach)) > QUICK;
    // The last such stretch is nearest to the channel.
    let last = (0..=PLACES).rev().find(turns_quickly)?;
    let first = (0..=last).rev().take_while(turns_quickly).last()?;
    let disc = chord(at(last), at(last) + reach);
    let is_past = |s: &f64| angle(chord(s - 0.1 * reach, s + 0.1 * reach), disc) < STRAIGHT;
    let end = || (first..PLACES).map(at).find(is_past);
    if angle(chord(at(first) - reach, at(first)), disc) > FOOT { end() } else { None }
}

/// A boss of a hub in which blades begin.
#[derive(Clone, Copy)]
pub struct BossOfHub<'a> {
    /// The whole wheel.
    pub wheel: &'a MeshSurface,
    /// The hub from the wall of the boss on, or from the end of the rounded corner at its foot.
    pub hub: &'a [Meridional],
    /// The curve of the hub with the wall of the boss, where there is such a corner.
    pub rounded: Option<&'a MeridionalCurve>,
    /// A place over the hub.
    pub above: Meridional,
    /// Whether the inlet faces +Z.
    pub inlet_up: bool,
    /// Distance within which places are the same, mm.
    pub tolerance: f64,
}

/// Blades that were cut off at a boss.
pub struct CutBlades {
    /// What stands over the hub.
    pub pieces: Vec<MeshSurface>,
    /// How far the blades go on before the beginning of the hub, straight, mm.
    pub ahead_mm: f64,
}

/// What stands over the hub, cut off at the wall of the boss ahead of the channel.
///
/// The wall is the outline of the wheel ahead of its hub up to its top, and goes on straight past it. Where
/// the foot of the boss is rounded, the blades are extended straight through that corner. `None` without
/// a boss, or where blades go on over it.
pub fn cut_off_boss(
    over_hub: &MeshSurface,
    boss: &BossOfHub,
    are_apart: fn(&[MeshSurface]) -> bool,
) -> Option<CutBlades> {
    let BossOfHub { wheel, hub, rounded, above, inlet_up, tolerance } = *boss;
    let ahead = outline_ahead(wheel, hub, inlet_up, tolerance);
    let front = *ahead.last()?;
    let mut line: Vec<Meridional> = wall_of(&ahead, inlet_up)?.iter().rev().copied().collect();
    line.dedup_by(|a, b| a.distance(*b) < tolerance);
    if line.len() < 2 {
        return None;
    }
    let wall = MeridionalCurve::through(&line).with_outer_side_towards(above);
    let over = |p: &Point| wall.project_past_ends(Meridional::from_point(p)).1;
    let extended = rounded.map(|curve| through_corner(over_hub, hub, curve, (&over, tolerance)));
    let over_hub = extended.as_ref().unwrap_or(over_hub);
    let up = |z: f64| if inlet_up { z } else { -z };
    let is_lost = |p: &Point| over(p) < -2.0 * tolerance && up(p.z) > up(front.z) + 2.0 * tolerance;
    if over_hub.points.iter().any(is_lost) {
        return None;
    }
    let cut_at = |wall: &MeridionalCurve| {
        let on_wall = |p: &Point| wall.project_past_ends(Meridional::from_point(p)).1.abs() < 1.5 * tolerance;
        let cut = trimmed(over_hub, wall, tolerance);
        let is_cut: Vec<bool> = cut.points.iter().map(on_wall).collect();
        cut.subset(|t| cut.triangles[t].iter().any(|i| !is_cut[*i as usize])).into_pieces()
    };
    let pieces = cut_at(&wall);
    if !are_apart(&pieces) {
        return None;
    }
    // A leading edge in the middle of chords across the cut would be behind the wall, or in the rounded
    // corner at its foot.
    let is_at = |p: &&Point| over(p).abs() < 1.5 * tolerance;
    let behind = |piece: &MeshSurface| {
        let mut cut = piece.points.iter().filter(is_at);
        let first = cut.next().map_or(0.0, |p| p.y.atan2(p.x));
        let turns = cut.map(|p| wrap_angle(p.y.atan2(p.x) - first));
        let (low, high) = turns.fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        hub[0].r * (1.0 - (0.5 * (high - low)).cos())
    };
    let sagitta = pieces.iter().map(behind).fold(0.0, f64::max);
    let clear = sagitta + CLEAR * (wall.length() + MeridionalCurve::through(hub).length());
    let moved: Vec<Meridional> =
        (0..=4).map(|k| wall.offset_derivative(0.25 * f64::from(k) * wall.length(), clear).0).collect();
    let moved = MeridionalCurve::through(&moved).with_outer_side_towards(above);
    let is_cut = |p: &Point| moved.project_past_ends(Meridional::from_point(p)).1.abs() < 1.5 * tolerance;
    let pieces = cut_at(&moved).into_iter().map(|piece| closed_along(piece, &is_cut)).collect();
    let begin = rounded.map_or(0.0, |_| moved.project_past_ends(hub[0]).1.max(0.0));
    Some(CutBlades { pieces, ahead_mm: begin })
}

/// What stands over the hub, with the sides of its blades going on straight from where they meet the rounded
/// corner at the foot of a boss until they are behind its wall: they begin in it, and not along the corner.
/// The hub without the corner is straight there. `rounded` is the curve with it, `over` the distance from the
/// wall.
fn through_corner(
    over_hub: &MeshSurface,
    hub: &[Meridional],
    rounded: &MeridionalCurve,
    (over, tolerance): (&dyn Fn(&Point) -> f64, f64),
) -> MeshSurface {
    // A curve through the corners of a mesh turns unsteadily: its direction is that of a chord.
    let curve = MeridionalCurve::through(hub);
    let (a, b) = (curve.point(0.0), curve.point(STRETCH * curve.length()));
    let length = a.distance(b).max(1e-9);
    let along_hub = Meridional { r: (b.r - a.r) / length, z: (b.z - a.z) / length };
    let begin = rounded.project(hub[0]).0;
    let is_foot = |p: &Point| {
        let (t, height) = rounded.project(Meridional::from_point(p));
        height.abs() < 1.5 * tolerance && t < begin + tolerance
    };
    let feet: Vec<bool> = over_hub.points.iter().map(is_foot).collect();
    let border: Vec<((u32, u32), usize)> = over_hub
        .border_edges()
        .filter(|((a, b), _)| [a, b].iter().all(|i| feet[**i as usize]))
        .filter(|((a, b), _)| [a, b].iter().any(|i| over(&over_hub.points[**i as usize]) > tolerance))
        .collect();
    let mut normal_of: BTreeMap<u32, Vector> = BTreeMap::new();
    for ((a, b), t) in &border {
        for i in [a, b] {
            *normal_of.entry(*i).or_insert_with(Vector::zeros) += over_hub.normals[*t];
        }
    }
    let mut mesh = TriangleMesh { points: over_hub.points.clone(), triangles: over_hub.triangles.clone() };
    let mut faces = over_hub.faces.clone();
    let mut moved: BTreeMap<u32, u32> = BTreeMap::new();
    for (i, normal) in normal_of {
        let p = over_hub.points[i as usize];
        let Some(normal) = normal.try_normalize(1e-9) else { continue };
        let radius = norm2(p.x, p.y).max(1e-9);
        let back = -Vector::new(along_hub.r * p.x / radius, along_hub.r * p.y / radius, along_hub.z);
        let along = back - normal * normal.dot(&back);
        let from = over(&p);
        let speed = from - over(&(p + along));
        if speed > LEAST_SPEED {
            moved.insert(i, mesh.points.len() as u32);
            mesh.points.push(p + along * ((from.max(0.0) + PAST_WALL * tolerance) / speed));
        }
    }
    for ((a, b), t) in border {
        if let (Some(c), Some(d)) = (moved.get(&a), moved.get(&b)) {
            mesh.triangles.extend([[b, a, *c], [b, *c, *d]]);
            faces.extend([over_hub.faces[t]; 2]);
        }
    }
    MeshSurface::of_faces(&mesh, faces)
}

/// The surface with triangles across its border where that `is_cut` off: between both of its stretches from
/// the hub to the tip, in the order of their places.
fn closed_along(surface: MeshSurface, is_cut: &dyn Fn(&Point) -> bool) -> MeshSurface {
    let cut: Vec<bool> = surface.points.iter().map(is_cut).collect();
    let mut next = vec![NONE; surface.points.len()];
    let mut has_before = vec![false; surface.points.len()];
    for ((a, b), _) in surface.border_edges() {
        if cut[a as usize] && cut[b as usize] {
            next[a as usize] = b;
            has_before[b as usize] = true;
        }
    }
    let starts = (0..next.len() as u32).filter(|&i| next[i as usize] != NONE && !has_before[i as usize]);
    let mut triangles = Vec::new();
    for start in starts {
        let mut line = vec![start];
        while line.len() <= next.len() {
            match next[line[line.len() - 1] as usize] {
                NONE => break,
                on => line.push(on),
            }
        }
        // The stretches are nearest to each other from end to end: a strip of the shorter diagonals.
        let (mut low, mut high) = (0, line.len() - 1);
        let at = |k: usize| surface.points[line[k] as usize];
        while high - low > 1 {
            let (up, down) = ((at(low + 1) - at(high)).norm(), (at(high - 1) - at(low)).norm());
            if up <= down {
                triangles.push([line[low + 1], line[low], line[high]]);
                low += 1;
            } else {
                triangles.push([line[high - 1], line[low], line[high]]);
                high -= 1;
            }
        }
    }
    if triangles.is_empty() {
        return surface;
    }
    let mesh = TriangleMesh { points: surface.points.clone(), triangles: surface.triangles.clone() };
    let last = surface.faces.iter().filter(|f| **f != NONE).max().map_or(0, |f| f + 1);
    let mut faces = surface.faces;
    faces.resize(mesh.triangles.len() + triangles.len(), last);
    let mut mesh = mesh;
    mesh.triangles.extend(triangles);
    MeshSurface::of_faces(&mesh, faces)
}
