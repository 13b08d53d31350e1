//! Blades that begin in a boss of the hub: paddles of a pump or blower that stand on its disc and run into
//! the wall of the boss, which joins them to each other.

use super::TriangleMesh;
use super::nose::{corners_of, outline_ahead};
use super::surface::MeshSurface;
use super::trim::trimmed;
use super::weld::NONE;
use crate::geometry::{Meridional, MeridionalCurve, Point, wrap_angle};

/// Distance of the cut from the wall of a boss, as a share of the length of both curves: beyond the rounded
/// corner at its foot.
const CLEAR: f64 = 1.0 / 400.0;

/// What stands over the hub, cut off at the wall of the boss ahead of the channel.
///
/// The wall is the outline of `wheel` ahead of its `hub` up to the first corner, and goes on straight past
/// it; the place `above` is on its outer side. `None` where there is no boss, or where blades go on over it.
pub fn cut_off_boss(
    wheel: &MeshSurface,
    over_hub: &MeshSurface,
    (hub, above): (&[Meridional], Meridional),
    inlet_up: bool,
    (tolerance, are_apart): (f64, fn(&[MeshSurface]) -> bool),
) -> Option<Vec<MeshSurface>> {
    let ahead = outline_ahead(wheel, hub, inlet_up, tolerance);
    let (corner, front) = (*corners_of(&ahead).first()?, *ahead.last()?);
    let mut line: Vec<Meridional> = ahead[..=corner].iter().rev().copied().collect();
    line.dedup_by(|a, b| a.distance(*b) < tolerance);
    if line.len() < 2 {
        return None;
    }
    let wall = MeridionalCurve::through(&line).with_outer_side_towards(above);
    let over = |p: &Point| wall.project_past_ends(Meridional::from_point(p)).1;
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
    Some(cut_at(&moved).into_iter().map(|piece| closed_along(piece, &is_cut)).collect())
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
