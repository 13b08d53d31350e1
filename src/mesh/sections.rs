//! Slices of a blade's mesh at constant relative height between hub and shroud.

use std::collections::HashMap;

use super::creases::{find_creases, find_curvature_jumps};
use super::edge_curve::EdgeCurve;
use super::edge_lines::EdgeLines;
use super::normals::{CornerNormals, ExactNormals};
use super::surface::{MeshSurface, SHARP};
use super::weld::NONE;
use crate::geometry::cubic::chord_lengths;
use crate::geometry::{Meridional, MeridionalCurve, Point, Vector};

/// As [`SHARP`], between a side and a cap.
const CAP_TURN: f64 = 0.995;
/// Share of a shroud up to the ends of which tips go from which on it is their own.
const MOST: f64 = 0.95;
/// Range of a blade between its slanted edges, relative to its length.
const MIDDLE: std::ops::Range<f64> = 0.35..0.9;
/// Triangles within this share of the height from hub or shroud are caps of the blade.
const AT_END: f64 = 1e-4;
/// Triangles within this share of the rim radius that face outwards (normals within 8° of the radius) are its
/// cap at the rim.
const AT_RIM: f64 = 5e-3;
const RADIAL: f64 = 0.99;

/// Coordinates in the channel between a hub and a shroud: position along it, and height over the hub.
#[derive(Clone, Debug)]
pub struct ChannelCoordinates {
    hub: MeridionalCurve,
    shroud: MeridionalCurve,
    /// Arc lengths of hub and shroud at which the blades begin and end, mm.
    hub_ends: (f64, f64),
    shroud_ends: (f64, f64),
    /// Whether hub and shroud go on past both of their ends, along the tangents there.
    past_ends: bool,
    /// Whether the shroud does: it ends where the tips of the blades turn into leading and trailing edge.
    past_tips: bool,
}

impl ChannelCoordinates {
    /// The channel between `hub` and `shroud` over the extent of the corners `blade`; with `past_tips` the
    /// blades go on past the ends of the shroud, where their tips turn into leading and trailing edge.
    pub fn new(
        hub: &MeridionalCurve,
        shroud: &MeridionalCurve,
        blade: &[Meridional],
        past_tips: bool,
    ) -> Self {
        Self::over(hub, shroud, blade, (false, past_tips))
    }

    /// The same channel over the extent of `blade`, with hub and shroud that go on past their ends.
    pub fn going_on(&self, blade: &MeshSurface) -> Self {
        let corners: Vec<Meridional> = blade.points.iter().map(Meridional::from_point).collect();
        Self::over(&self.hub, &self.shroud, &corners, (true, self.past_tips))
    }

    fn over(
        hub: &MeridionalCurve,
        shroud: &MeridionalCurve,
        blade: &[Meridional],
        (past_ends, past_tips): (bool, bool),
    ) -> Self {
        let facing = |curve: &MeridionalCurve| curve.clone().with_outer_side_towards_most(blade);
        let (hub, shroud) = (facing(hub), facing(shroud));
        let (hub_ends, shroud_ends) = ((0.0, hub.length()), (0.0, shroud.length()));
        let whole = Self { hub, shroud, hub_ends, shroud_ends, past_ends, past_tips };
        let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        for p in blade {
            let placed = whole.placed(*p);
            let height = placed[0].1 + placed[1].1;
            for (ends, (t, distance)) in ends.iter_mut().zip(placed) {
                if distance < 0.25 * height {
                    *ends = (ends.0.min(t), ends.1.max(t));
                }
            }
        }
        let found = |ends: (f64, f64), all: (f64, f64)| if ends.0 < ends.1 { ends } else { all };
        let along = found(ends[1], shroud_ends);
        // Tips make a shroud up to its ends; another one may begin far ahead of the blades.
        let within = (along.0.max(shroud_ends.0), along.1.min(shroud_ends.1));
        let reaches = within.1 - within.0 > MOST * shroud_ends.1;
        let shroud_ends = match (past_tips, reaches) {
            (true, true) => shroud_ends,
            (true, false) => within,
            (false, _) => along,
        };
        Self { hub_ends: found(ends[0], hub_ends), shroud_ends, ..whole }
    }

    /// Arc length and signed distance of a point from hub and shroud, mm.
    fn placed(&self, p: Meridional) -> [(f64, f64); 2] {
        let placed = |curve: &MeridionalCurve, past_ends: bool| match past_ends {
            true => curve.project_past_ends(p),
            false => curve.project(p),
        };
        let hub = placed(&self.hub, self.past_ends);
        let shroud = placed(&self.shroud, self.past_ends || self.past_tips);
        [hub, shroud]
    }

    /// Relative position (along from inlet 0 to outlet 1, height from hub 0 to shroud 1) of a point of the
    /// part's frame.
    pub fn coordinates_of(&self, p: &Point) -> (f64, f64) {
        let p = Meridional::from_point(p);
        let [(t, d), (u, e)] = self.placed(p);
        let height = if (d + e).abs() > 1e-12 { d / (d + e) } else { 0.5 };
        let share = |t: f64, ends: (f64, f64)| (t - ends.0) / (ends.1 - ends.0);
        let blend = height.clamp(0.0, 1.0);
        (share(t, self.hub_ends) * (1.0 - blend) + share(u, self.shroud_ends) * blend, height)
    }
}

/// A point of a slice.
#[derive(Clone, Copy, Debug)]
pub struct SlicePoint {
    /// The point, on the interpolated smooth surface.
    pub point: Point,
    /// Relative position from inlet (0) to outlet (1).
    pub along: f64,
    /// Whether the blade has a sharp edge here.
    pub edge: bool,
    /// Whether two faces of the mesh meet here smoothly.
    pub seam: bool,
    /// Distance of the point from its mesh edge, mm: the smaller, the more certain the point.
    pub chord_offset_mm: f64,
}

impl SlicePoint {
    /// Coordinates and [`Self::along`], to be interpolated.
    pub fn values(&self) -> [f64; 4] {
        [self.point.x, self.point.y, self.point.z, self.along]
    }

    /// A point with interpolated values: neither at an edge nor at a seam.
    pub fn from_values([x, y, z, along]: [f64; 4]) -> Self {
        Self { point: Point::new(x, y, z), along, edge: false, seam: false, chord_offset_mm: 0.0 }
    }
}

/// Chord lengths at points of a slice, given by their values; `None` where neighbours coincide.
pub fn knots_of(values: &[[f64; 4]]) -> Option<Vec<f64>> {
    let places: Vec<[f64; 3]> = values.iter().map(|p| [p[0], p[1], p[2]]).collect();
    let knots = chord_lengths(&places);
    (!knots.windows(2).any(|k| k[1] - k[0] < 1e-12)).then_some(knots)
}

/// Classifies triangles: 0 side, 1 cap at the hub, 2 at the shroud, 3 at the rim. Angles do not suffice,
/// because caps may meet the sides at flat angles.
fn classify_caps(surface: &MeshSurface, places: &[(f64, f64)]) -> Vec<u8> {
    let widest = surface.points.iter().map(|p| Meridional::from_point(p).r).fold(0.0, f64::max);
    let cap = |t: usize| {
        let corners = surface.triangles[t].map(|i| i as usize);
        let centre = surface.centre(t);
        let r = Meridional::from_point(&centre).r;
        let outwards = (surface.normals[t].x * centre.x + surface.normals[t].y * centre.y) / r.max(1e-9);
        if corners.iter().all(|&i| places[i].1 < AT_END) {
            1
        } else if corners.iter().all(|&i| places[i].1 > 1.0 - AT_END) {
            2
        } else if r > widest * (1.0 - AT_RIM) && outwards.abs() > RADIAL {
            3
        } else {
            0
        }
    };
    (0..surface.triangles.len()).map(cap).collect()
}

/// One piece of a slice: a loop, or a line with two ends.
#[derive(Clone, Debug)]
pub struct SlicePiece {
    /// Its points in order; the first point of a loop is not repeated.
    pub points: Vec<SlicePoint>,
    /// Whether it is a loop.
    pub closed: bool,
}

/// A blade prepared for slicing.
pub struct BladeSlicer<'a> {
    surface: &'a MeshSurface,
    band: &'a ChannelCoordinates,
    /// (along, height) of the corners.
    places: Vec<(f64, f64)>,
    /// Of each triangle, whether it meets its neighbours smoothly.
    smooth: Vec<[bool; 3]>,
    normals: CornerNormals,
    /// Directions of the edges of a mesh without exact normals.
    lines: EdgeLines,
}

impl<'a> BladeSlicer<'a> {
    /// Computes channel coordinates and normals of all corners, `exact` ones where there are any, and the
    /// smooth patches.
    pub fn new(surface: &'a MeshSurface, band: &'a ChannelCoordinates, exact: &ExactNormals) -> Self {
        let places: Vec<(f64, f64)> = surface.points.iter().map(|p| band.coordinates_of(p)).collect();
        let caps = classify_caps(surface, &places);
        let (patch, _) = surface.groups(|a, b| {
            let straight = surface.normals[a].dot(&surface.normals[b]);
            straight > SHARP && (caps[a] == caps[b] || straight > CAP_TURN)
        });
        let creases = find_creases(surface, exact);
        let joins = |t: usize, k: usize| {
            let n = surface.neighbours[t][k];
            n != NONE && patch[t] == patch[n as usize] && !creases[t][k]
        };
        let smooth: Vec<[bool; 3]> =
            (0..surface.triangles.len()).map(|t| [0, 1, 2].map(|k| joins(t, k))).collect();
        let jumps = find_curvature_jumps(surface);
        let mut normals = CornerNormals::new(surface, &smooth, &jumps);
        normals.replace_by(surface, exact);
        let lines = if exact.is_empty() { EdgeLines::new(surface, &smooth) } else { EdgeLines::default() };
        Self { surface, band, places, smooth, normals, lines }
    }

    /// (along, height) of the corners.
    pub fn places(&self) -> &[(f64, f64)] {
        &self.places
    }

    /// The range of heights covered by the blade everywhere between its slanted edges, from the lowest and
    /// the highest of its corners in each of `stretches` intervals between them.
    pub fn height_range(&self, stretches: usize) -> (f64, f64) {
        let mut spans = vec![(f64::INFINITY, f64::NEG_INFINITY); stretches];
        let ends =
            self.places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, p| (e.0.min(p.0), e.1.max(p.0)));
        // Past the ends of the shroud, where the tips turn into the edges, blades are lower.
        let ends = if self.band.past_tips { (ends.0.max(0.0), ends.1.min(1.0)) } else { ends };
        // The intervals divide the middle only: one that its end cut short would hold few points of the tips.
        let interval = |along: f64| {
            let share = (along - ends.0) / (ends.1 - ends.0);
            (share - MIDDLE.start) / (MIDDLE.end - MIDDLE.start) * stretches as f64
        };
        let mut reached = |at: f64, height: f64| {
            if (0.0..stretches as f64).contains(&at) {
                let span = &mut spans[at as usize];
                *span = (span.0.min(height), span.1.max(height));
            }
        };
        // Edges are sampled, too, so that every interval of a coarse mesh has points.
        for t in &self.surface.triangles {
            for k in 0..3 {
                let (a, b) = (self.places[t[k] as usize], self.places[t[(k + 1) % 3] as usize]);
                let (from, to) = (interval(a.0), interval(b.0));
                let steps = (to - from).abs().ceil().clamp(1.0, 2.0 * stretches as f64) as usize;
                for i in 0..steps {
                    let x = i as f64 / steps as f64;
                    reached(from + (to - from) * x, a.1 + (b.1 - a.1) * x);
                }
            }
        }
        let filled = || spans.iter().filter(|s| s.0 < s.1);
        let low = filled().map(|s| s.0).fold(f64::NEG_INFINITY, f64::max);
        let high = filled().map(|s| s.1).fold(f64::INFINITY, f64::min);
        (low, high)
    }

    /// Slices the blade at a relative height; returns the pieces, longest first.
    pub fn slice_at(&self, height: f64) -> Vec<SlicePiece> {
        let above = |i: u32| self.places[i as usize].1 >= height;
        let mut numbers: HashMap<(u32, u32), usize> = HashMap::new();
        let mut points: Vec<SlicePoint> = Vec::new();
        let mut links: Vec<[usize; 2]> = Vec::new();
        for t in 0..self.surface.triangles.len() {
            let corners = self.surface.triangles[t];
            let mut crossed = (0..3).filter(|&k| above(corners[k]) != above(corners[(k + 1) % 3]));
            let (Some(first), Some(second)) = (crossed.next(), crossed.next()) else { continue };
            let mut number = |k: usize| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                *numbers.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push(self.crossing(t, k, height));
                    points.len() - 1
                })
            };
            let link = [number(first), number(second)];
            links.push(link);
        }
        chained(&points, &links)
    }

    /// The intersection of the smooth surface over edge `k` of a triangle with the height: on a cubic Hermite
    /// curve from corner to corner, tangential to the surface at both.
    fn crossing(&self, t: usize, k: usize, height: f64) -> SlicePoint {
        let next = (k + 1) % 3;
        let corners = self.surface.triangles[t];
        let (i, j) = (corners[k] as usize, corners[next] as usize);
        let (a, b) = (self.surface.points[i], self.surface.points[j]);
        let (ha, hb) = (self.places[i].1, self.places[j].1);
        let across = self.surface.neighbours[t][k];
        let edge = !self.smooth[t][k];
        let chord = b - a;
        let tangent = |n: &Vector| chord - n * n.dot(&chord);
        let along_line =
            if edge { self.lines.tangents(self.surface, [corners[k], corners[next]]) } else { None };
        let (ta, tb) = match across {
            _ if let Some([from, to]) = along_line => (from, to),
            // A sharp edge is tangential to both of its faces.
            other if edge && other != NONE => {
                let there = |corner: u32| {
                    let o = other as usize;
                    let c = (0..3).find(|&c| self.surface.triangles[o][c] == corner).unwrap_or(0);
                    self.normals.per_triangle[o][c]
                };
                let both = |n: &Vector, m: &Vector| {
                    let along = n.cross(m);
                    match along.try_normalize(0.2) {
                        Some(e) => e * e.dot(&chord),
                        None => tangent(n),
                    }
                };
                (
                    both(&self.normals.per_triangle[t][k], &there(corners[k])),
                    both(&self.normals.per_triangle[t][next], &there(corners[next])),
                )
            }
            _ => (tangent(&self.normals.per_triangle[t][k]), tangent(&self.normals.per_triangle[t][next])),
        };
        let curve = EdgeCurve::from_tangents([a, b], [ta, tb]);
        let over = |p: &Point| self.band.coordinates_of(p).1 - height;
        let share = curve.zero_of([ha - height, hb - height], over);
        let point = curve.at(share);
        let seam = !edge && {
            let faces = [t, across as usize].map(|t| self.surface.faces[t]);
            faces[0] != faces[1] && !faces.contains(&NONE)
        };
        SlicePoint {
            point,
            along: self.band.coordinates_of(&point).0,
            edge,
            seam,
            chord_offset_mm: (point - curve.on_chord(share)).norm(),
        }
    }
}

/// Chains linked points into lines and loops, the longest first.
fn chained(points: &[SlicePoint], links: &[[usize; 2]]) -> Vec<SlicePiece> {
    let mut next: Vec<[Option<usize>; 2]> = vec![[None; 2]; points.len()];
    for [a, b] in links {
        for (from, to) in [(*a, *b), (*b, *a)] {
            if let Some(free) = next[from].iter_mut().find(|n| n.is_none()) {
                *free = Some(to);
            }
        }
    }
    let mut done = vec![false; points.len()];
    let mut cuts: Vec<(f64, SlicePiece)> = Vec::new();
    // Open lines first, each from one of its ends; then loops.
    let ends = (0..points.len()).filter(|&i| next[i][1].is_none()).collect::<Vec<_>>();
    for start in ends.into_iter().chain(0..points.len()) {
        if done[start] {
            continue;
        }
        let closed_if = next[start][1].is_some();
        let mut line = vec![start];
        done[start] = true;
        let mut at = start;
        while let Some(to) = next[at].iter().flatten().copied().find(|&n| !done[n]) {
            done[to] = true;
            line.push(to);
            at = to;
        }
        let closed = closed_if && line.len() > 2 && next[at].contains(&Some(start));
        let length: f64 = line.windows(2).map(|w| (points[w[1]].point - points[w[0]].point).norm()).sum();
        cuts.push((length, SlicePiece { points: line.into_iter().map(|i| points[i]).collect(), closed }));
    }
    cuts.sort_by(|a, b| b.0.total_cmp(&a.0));
    cuts.into_iter().map(|(_, cut)| cut).collect()
}
