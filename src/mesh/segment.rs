//! Segmentation of a wheel given as a single mesh: surfaces of revolution that touch the blades are hub and
//! cover, the rest is blades.

use super::describe::MOSTLY;
use super::profile::{Course, mean_point, meridional_normal};
use super::surface::{MeshSurface, NONE};
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve};
use crate::part::PartError;

/// Largest circumferential component in the normals of a surface of revolution.
const TURNED: f64 = 0.1;
/// Smallest cosine of the angle between neighbouring triangles of one face.
const SMOOTH: f64 = 0.9;
/// Distance from the hub's curve within which a corner is on the hub: mm, and share of the rim radius.
const ON_HUB: (f64, f64) = (0.02, 2e-4);
/// Smallest weight (area × border length) of the lighter one of hub and cover, as a share of the heavier one.
const COVER: f64 = 0.05;
/// Share of the largest blade's area below which a piece is discarded as a fragment.
const SCRAP: f64 = 0.05;

/// Share of its largest radius from which on a piece is looked at to tell a blade from a wheel.
const OUTER: f64 = 0.8;

/// The surfaces of a segmented wheel.
pub struct Segments {
    /// The hub, or its flow side.
    pub hub: MeshSurface,
    /// The shroud where it is a separate piece, or the cover.
    pub shroud: Option<MeshSurface>,
    /// Single blades.
    pub blades: Vec<MeshSurface>,
}

/// Whether a piece has points all around the axis near its largest radius, as a wheel of one piece has and a
/// blade has not.
fn goes_around(piece: &MeshSurface) -> bool {
    const SECTORS: usize = 24;
    let widest = piece.points.iter().map(|p| Meridional::of(p).r).fold(0.0, f64::max);
    let mut met = [false; SECTORS];
    for p in piece.points.iter().filter(|p| Meridional::of(p).r > OUTER * widest) {
        let share = p.y.atan2(p.x) / std::f64::consts::TAU + 0.5;
        met[((share * SECTORS as f64) as usize).min(SECTORS - 1)] = true;
    }
    2 * met.iter().filter(|m| **m).count() > SECTORS
}

/// Classifies disconnected pieces: surfaces of revolution are hub and shroud, all others blades. `None` where
/// there are no separate blades.
///
/// # Errors
/// Returns the number of bodies of revolution if there are more than two.
fn segment_disconnected(wheel: &MeshSurface) -> Result<Option<Segments>, usize> {
    let (mut round, mut blades) = (Vec::new(), Vec::new());
    for surface in wheel.clone().into_pieces() {
        let (mut across, mut area) = (0.0, 0.0);
        for t in 0..surface.triangles.len() {
            across += surface.area(t) * meridional_normal(&surface, t).1.abs();
            area += surface.area(t);
        }
        if across < TURNED * area { round.push(surface) } else { blades.push(surface) }
    }
    // One piece beside the hub is a blade where it does not go around the axis, else a wheel of one piece.
    if blades.len() < 2 && blades.first().is_none_or(goes_around) {
        return Ok(None);
    }
    if round.len() > 2 {
        return Err(round.len());
    }
    // The hub is nearest to the axis.
    let inner = |s: &MeshSurface| s.points.iter().map(|p| Meridional::of(p).r).fold(f64::INFINITY, f64::min);
    round.sort_by(|a, b| inner(a).total_cmp(&inner(b)));
    let mut round = round.into_iter();
    let Some(hub) = round.next() else { return Ok(None) };
    Ok(Some(Segments { hub, shroud: round.next(), blades }))
}

/// A face of revolution of a wheel: hub or cover.
struct RevolvedFace {
    /// Heights of all corners of the wheel over it, positive towards the blades, mm.
    heights: Vec<f64>,
    /// Smallest radius of its corners, mm.
    inner: f64,
}

/// Segments a wheel given as one mesh about Z into hub, blades and, where there is one, cover.
///
/// # Errors
/// Fails when no surface of revolution touches blades, when there are more than two disconnected bodies of
/// revolution, or when the blades are connected with each other.
pub fn segment_wheel(wheel: &MeshSurface, name: &str) -> Result<Segments, PartError> {
    let unclear = |why: &str| {
        PartError::new(
            ErrorCode::MeshInOne,
            0,
            format!("hub and blades of the single mesh `{name}` cannot be separated: {why}"),
            "export hub and blades as separate meshes, or name them with --role NODE=hub and NODE=blade",
        )
    };
    match segment_disconnected(wheel) {
        Ok(Some(segments)) => return Ok(segments),
        Ok(None) => {}
        Err(count) => return Err(unclear(&format!("it has {count} bodies of revolution"))),
    }
    let turned: Vec<bool> =
        (0..wheel.triangles.len()).map(|t| meridional_normal(wheel, t).1.abs() < TURNED).collect();
    let (group, count) =
        wheel.groups(|a, b| turned[a] && turned[b] && wheel.normals[a].dot(&wheel.normals[b]) > SMOOTH);
    // Hub and cover are the large faces of revolution with the longest common borders with other faces.
    let (mut areas, mut borders) = (vec![0.0; count], vec![0.0; count]);
    for t in (0..group.len()).filter(|&t| turned[t]) {
        areas[group[t] as usize] += wheel.area(t);
        for (k, &n) in wheel.neighbours[t].iter().enumerate() {
            if n != NONE && !turned[n as usize] {
                let corners = wheel.triangles[t];
                let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
                borders[group[t] as usize] += (wheel.points[b] - wheel.points[a]).norm();
            }
        }
    }
    let weight = |f: usize| areas[f] * borders[f];
    let mut carrying: Vec<usize> = (0..count).filter(|&f| weight(f) > 0.0).collect();
    carrying.sort_by(|&a, &b| weight(b).total_cmp(&weight(a)));
    let heaviest = carrying.first().map_or(0.0, |&f| weight(f));
    carrying.retain(|&f| weight(f) > COVER * heaviest);
    if carrying.is_empty() {
        return Err(unclear("no surface of revolution about the axis touches blades"));
    }

    let size = wheel.points.iter().map(|p| Meridional::of(p).r).fold(0.0, f64::max);
    let tolerance = ON_HUB.0.max(ON_HUB.1 * size);
    let corners: Vec<Meridional> = wheel.points.iter().map(Meridional::of).collect();
    let of = |keep: &dyn Fn(usize) -> bool| -> Vec<Meridional> {
        let mut used = vec![false; corners.len()];
        for t in (0..group.len()).filter(|&t| keep(t)) {
            wheel.triangles[t].iter().for_each(|i| used[*i as usize] = true);
        }
        corners.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p).collect()
    };
    let standing = of(&|t| !turned[t]);
    let (course, middle) = (Course::of(&standing), mean_point(&standing));
    let face = |number: usize| -> Option<RevolvedFace> {
        let own = |t: usize| turned[t] && group[t] as usize == number;
        let points = of(&own);
        let triangles: Vec<usize> = (0..group.len()).filter(|&t| own(t)).collect();
        // A face with fillets continues smoothly up to the blades' noses: then the curve follows its bottom.
        let profile = course
            .fit_curve(&points)
            .filter(|p| p.max_deviation_mm < tolerance)
            .or_else(|| course.fit_bottom(&points, middle, tolerance))
            .filter(|p| p.area_share_on_curve(wheel, &triangles, tolerance) > MOSTLY)?;
        let curve = MeridionalCurve::through(&profile.points).with_outer_side_towards(middle);
        let heights = corners.iter().map(|p| curve.project(*p).1).collect();
        let inner = points.iter().map(|p| p.r).fold(f64::INFINITY, f64::min);
        Some(RevolvedFace { heights, inner })
    };
    // Blades that reach from edge to edge divide a face into patches, one for each channel: those on a curve that was
    // found before belong to it.
    let mut faces: Vec<(RevolvedFace, [f64; 2])> = Vec::new();
    for number in carrying {
        let mut own = vec![false; corners.len()];
        for t in (0..group.len()).filter(|&t| turned[t] && group[t] as usize == number) {
            wheel.triangles[t].iter().for_each(|i| own[*i as usize] = true);
        }
        let is_on = |face: &RevolvedFace| {
            face.heights.iter().zip(&own).all(|(height, own)| !own || height.abs() < tolerance)
        };
        let sums = [areas[number], borders[number]];
        match faces.iter_mut().find(|(face, _)| is_on(face)) {
            Some((_, all)) => *all = [all[0] + sums[0], all[1] + sums[1]],
            None => faces.extend(face(number).map(|face| (face, sums))),
        }
    }
    faces.sort_by(|(_, a), (_, b)| (b[0] * b[1]).total_cmp(&(a[0] * a[1])));
    let heaviest = faces.first().map_or(0.0, |(_, [area, border])| area * border);
    faces.retain(|(_, [area, border])| area * border > COVER * heaviest);
    faces.truncate(2);
    let mut faces: Vec<RevolvedFace> = faces.into_iter().map(|(face, _)| face).collect();
    // The hub is nearer to the axis.
    faces.sort_by(|a, b| a.inner.total_cmp(&b.inner));
    let mut faces = faces.into_iter();
    let Some(hub) = faces.next() else {
        return Err(unclear("no surface of revolution runs from inlet to outlet between the blades"));
    };
    let cover = faces.next();

    let any = |face: &RevolvedFace, t: usize, is: &dyn Fn(f64) -> bool| {
        wheel.triangles[t].iter().any(|i| is(face.heights[*i as usize]))
    };
    let below = |face: &RevolvedFace, t: usize| any(face, t, &|h| h < -tolerance);
    let stands = |face: &RevolvedFace, t: usize| !below(face, t) && any(face, t, &|h| h > tolerance);
    let lies = |face: &RevolvedFace, t: usize| !below(face, t) && !any(face, t, &|h| h > tolerance);
    let blade = |t: usize| stands(&hub, t) && cover.as_ref().is_none_or(|cover| stands(cover, t));

    let blades = wheel.subset(blade).into_pieces();
    let area = |blade: &MeshSurface| (0..blade.triangles.len()).map(|t| blade.area(t)).sum::<f64>();
    let measured: Vec<(f64, MeshSurface)> = blades.into_iter().map(|b| (area(&b), b)).collect();
    let largest = measured.iter().map(|(a, _)| *a).fold(0.0, f64::max);
    let blades: Vec<MeshSurface> =
        measured.into_iter().filter(|(a, _)| *a > SCRAP * largest).map(|(_, b)| b).collect();
    if blades.len() < 2 {
        return Err(unclear("the blades on its hub are connected with each other"));
    }
    let shroud = cover.map(|cover| wheel.subset(|t| lies(&cover, t)));
    Ok(Segments { hub: wheel.subset(|t| lies(&hub, t)), shroud, blades })
}
