//! Separates blade meshes into single blades, classifies main blades and splitters, and counts them.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::surface::MeshSurface;
use super::weld::{NONE, NumberMap};
use super::{Role, TriangleMesh};
use crate::error::ErrorCode;
use crate::geometry::{Meridional, Point, wrap_angle};
use crate::part::PartError;

/// Share of the longest blade's extent below which a blade is a splitter, where no name says so.
const SHORTER: f64 = 0.92;
/// Share of the longest blade's extent below which a piece is discarded as a fragment.
const SCRAP: f64 = 0.15;
/// Pieces with border corners closer together than this share of the size belong to one blade.
const TOUCHING: f64 = 1e-3;
/// Largest deviation of a blade from equal spacing, as a share of the pitch.
const OFF_PATTERN: f64 = 0.05;
/// Relative difference of areas up to which blades are copies of one.
const COPIES: f64 = 2e-3;

/// One blade.
#[derive(Clone, Debug)]
pub struct SingleBlade {
    /// Its triangles.
    surface: MeshSurface,
    /// Role of its mesh.
    role: Role,
    /// Mean angle of its area, rad: corners are denser beside seams, which copies have in different places.
    angle: f64,
    /// Radial plus axial extent, mm.
    length: f64,
}

/// The blades of one pitch: a main blade and its splitters.
#[derive(Clone, Debug)]
pub struct BladeRows {
    /// Number of main blades.
    pub count: usize,
    /// The first main blade.
    pub main: MeshSurface,
    /// One splitter for each position within the pitch, in the order of the file.
    pub splitters: Vec<MeshSurface>,
    /// How far the blades differ, where they are not copies.
    pub note: Option<String>,
}

/// Separates surfaces, each of one or more blades with their role, into single blades.
pub fn separate_blades(surfaces: Vec<(Role, MeshSurface)>) -> Vec<SingleBlade> {
    let (splitters, mains): (Vec<_>, Vec<_>) = surfaces.into_iter().partition(|(r, _)| *r == Role::Splitter);
    let mut found: Vec<SingleBlade> = Vec::new();
    // The sides of a blade may be separate meshes.
    for (role, surfaces) in [(Role::Blade, mains), (Role::Splitter, splitters)] {
        let all = surfaces.into_iter().flat_map(|(_, surface)| surface.into_pieces()).collect();
        found.extend(merge_touching(all).into_iter().map(|surface| SingleBlade::new(surface, role)));
    }
    let longest = found.iter().map(|b| b.length).fold(0.0, f64::max);
    found.retain(|b| b.length > SCRAP * longest);
    found
}

impl SingleBlade {
    fn new(surface: MeshSurface, role: Role) -> Self {
        let (mut sum, mut low, mut high) =
            (Point::origin(), (f64::INFINITY, f64::INFINITY), (0.0_f64, f64::NEG_INFINITY));
        for t in 0..surface.triangles.len() {
            let centre = surface.centre(t);
            sum += centre.coords * (surface.area(t) / Meridional::from_point(&centre).r.max(1e-9));
        }
        for p in &surface.points {
            let m = Meridional::from_point(p);
            low = (low.0.min(m.r), low.1.min(m.z));
            high = (high.0.max(m.r), high.1.max(m.z));
        }
        let length = (high.0 - low.0).max(0.0) + (high.1 - low.1).max(0.0);
        Self { surface, role, angle: sum.y.atan2(sum.x), length }
    }
}

/// Merges pieces whose borders touch, which are sides of one blade.
fn merge_touching(pieces: Vec<MeshSurface>) -> Vec<MeshSurface> {
    if pieces.len() < 2 {
        return pieces;
    }
    let size = pieces.iter().flat_map(|p| &p.points).map(|p| p.coords.norm()).fold(0.0, f64::max);
    let cell = (TOUCHING * size).max(1e-9);
    let key = |p: &Point| [p.x, p.y, p.z].map(|x| (x / cell).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let border =
        |piece: &MeshSurface| piece.border_edges().map(|((a, _), _)| piece.points[a as usize]).collect();
    let borders: Vec<Vec<Point>> = pieces.iter().map(border).collect();
    for (k, border) in borders.iter().enumerate() {
        for p in border {
            let list = cells.entry(key(p)).or_default();
            if list.last() != Some(&k) {
                list.push(k);
            }
        }
    }
    let mut group: Vec<usize> = (0..pieces.len()).collect();
    for (k, border) in borders.iter().enumerate() {
        for p in border {
            let [x, y, z] = key(p);
            for d in 0..27 {
                let near = [x + d % 3 - 1, y + d / 3 % 3 - 1, z + d / 9 - 1];
                for &other in cells.get(&near).into_iter().flatten() {
                    let (a, b) = (group[k].min(group[other]), group[k].max(group[other]));
                    if a != b {
                        group.iter_mut().filter(|g| **g == b).for_each(|g| *g = a);
                    }
                }
            }
        }
    }
    let mut whole: Vec<(usize, Vec<MeshSurface>)> = Vec::new();
    for (piece, group) in pieces.into_iter().zip(group) {
        match whole.iter_mut().find(|(g, _)| *g == group) {
            Some((_, parts)) => parts.push(piece),
            None => whole.push((group, vec![piece])),
        }
    }
    whole.into_iter().map(|(_, parts)| together(parts)).collect()
}

/// Merges parts whose borders touch into one surface; keeps their faces distinct.
fn together(mut parts: Vec<MeshSurface>) -> MeshSurface {
    if parts.len() == 1 {
        return parts.swap_remove(0);
    }
    let mut mesh = TriangleMesh::default();
    let mut faces = Vec::new();
    let mut numbers: NumberMap<(u64, u64), u32> = NumberMap::default();
    for (k, part) in parts.into_iter().enumerate() {
        faces.extend(part.faces.into_iter().map(|face| {
            let next = numbers.len() as u32;
            if face == NONE { NONE } else { *numbers.entry((k as u64, u64::from(face))).or_insert(next) }
        }));
        mesh.append(&TriangleMesh { points: part.points, triangles: part.triangles });
    }
    MeshSurface::of_faces(&mesh, faces)
}

impl BladeRows {
    /// Sorts blades into rows; `count` is the number of main blades, if given.
    ///
    /// # Errors
    /// Fails when there is no main blade and, unless `count` is given, when there is only one or they are not
    /// evenly spaced.
    pub fn from_blades(blades: Vec<SingleBlade>, count: Option<usize>) -> Result<Self, PartError> {
        let named = blades.iter().any(|b| b.role == Role::Splitter);
        let longest = blades.iter().map(|b| b.length).fold(0.0, f64::max);
        let is_splitter = |b: &SingleBlade| match named {
            true => b.role == Role::Splitter,
            false => b.length < SHORTER * longest,
        };
        let (splitters, mains): (Vec<SingleBlade>, Vec<SingleBlade>) =
            blades.into_iter().partition(is_splitter);
        let (pattern, note) = choose_pattern(&mains);
        let Some(main) = mains.get(pattern) else {
            return Err(PartError::new(
                ErrorCode::MeshRoles,
                0,
                "there is no main blade",
                "name one with --role NODE=blade",
            ));
        };
        let count = match count {
            Some(count) => count,
            None => count_from_spacing(&mains)?,
        };
        let pitch = TAU / count.max(1) as f64;
        let mut places: Vec<f64> = Vec::new();
        let mut kept = Vec::new();
        for splitter in splitters {
            let place = (splitter.angle - main.angle).rem_euclid(pitch);
            let apart = |a: f64| wrap_angle((a - place) * TAU / pitch).abs() * pitch / TAU;
            if places.iter().all(|a| apart(*a) > OFF_PATTERN * pitch) {
                places.push(place);
                kept.push(splitter.surface);
            }
        }
        Ok(Self { count, main: main.surface.clone(), splitters: kept, note })
    }
}

/// Index of the blade that stands for all: the first where they are copies, else the one of median area, with
/// a line about the difference.
fn choose_pattern(mains: &[SingleBlade]) -> (usize, Option<String>) {
    let area = |b: &SingleBlade| (0..b.surface.triangles.len()).map(|t| b.surface.area(t)).sum::<f64>();
    let mut areas: Vec<(f64, usize)> = mains.iter().map(area).zip(0..).collect();
    areas.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(least), Some(most), true) = (areas.first(), areas.last(), mains.len() > 2) else {
        return (0, None);
    };
    let spread = (most.0 - least.0) / most.0.max(1e-300);
    if spread < COPIES {
        return (0, None);
    }
    let pattern = areas[areas.len() / 2].1;
    let note = format!(
        "the {} blades differ by {:.1} % in area; the one of median area is the pattern",
        mains.len(),
        100.0 * spread
    );
    (pattern, Some(note))
}

/// Number of blades derived from the spacing of the given ones, of which some may be missing.
fn count_from_spacing(mains: &[SingleBlade]) -> Result<usize, PartError> {
    let mut angles: Vec<f64> = mains.iter().map(|b| (b.angle - mains[0].angle).rem_euclid(TAU)).collect();
    angles.sort_by(f64::total_cmp);
    if mains.len() == 1 {
        return Err(PartError::new(
            ErrorCode::BladeCount,
            0,
            "there is one main blade, and the file does not say how many the wheel has",
            "give their number with --blades N",
        ));
    }
    let gaps = angles.iter().zip(angles.iter().cycle().skip(1)).map(|(a, b)| (b - a).rem_euclid(TAU));
    let least = gaps.filter(|g| *g > 1e-9).fold(TAU, f64::min);
    let count = (TAU / least).round().max(1.0);
    let pitch = TAU / count;
    let off = |a: &f64| (a / pitch - (a / pitch).round()).abs();
    if let Some(angle) = angles.iter().find(|a| off(a) > OFF_PATTERN) {
        return Err(PartError::new(
            ErrorCode::BladeSpacing,
            0,
            format!(
                "the {} main blades are not evenly spaced: one is {:.1}° from the first, \
                 the closest pair {:.1}° apart",
                mains.len(),
                angle.to_degrees(),
                least.to_degrees()
            ),
            "give splitters their role with --role NODE=splitter, exclude other meshes with \
             --role NODE=ignore, or give --blades N",
        ));
    }
    Ok(count as usize)
}
