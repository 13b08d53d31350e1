//! A wheel in one mesh taken apart: what is turned and meets the blades is the hub, what stands on it the blades.

use super::TriangleMesh;
use super::profile::{Course, meridional_normal};
use super::surface::{NONE, Surface, pieces};
use crate::geometry::{Meridional, MeridionalCurve};
use crate::part::PartError;

/// Share of the circumference in the normals of turned faces, at most.
const TURNED: f64 = 0.1;
/// Turn between triangles of one face, as cosine.
const SMOOTH: f64 = 0.9;
/// Distance from the hub's curve within which a corner is on the hub: mm, and share of the size.
const ON_HUB: (f64, f64) = (0.02, 2e-4);
/// Share of the largest blade's area below which a piece is a scrap.
const SCRAP: f64 = 0.05;

/// A wheel taken apart.
pub struct Segments {
    /// The hub, or its flow side.
    pub hub: Surface,
    /// The shroud, where it is a piece of its own.
    pub shroud: Option<TriangleMesh>,
    /// Single blades.
    pub blades: Vec<TriangleMesh>,
}

/// Of pieces that do not hang together, those that are turned are hub and shroud, the others blades.
fn loose(wheel: &Surface) -> Option<Segments> {
    let mesh = TriangleMesh { points: wheel.points.clone(), triangles: wheel.triangles.clone() };
    let (mut round, mut blades) = (Vec::new(), Vec::new());
    for piece in pieces(&mesh) {
        let surface = Surface::of(&piece);
        let (mut across, mut area) = (0.0, 0.0);
        for t in 0..surface.triangles.len() {
            across += surface.area(t) * meridional_normal(&surface, t).1.abs();
            area += surface.area(t);
        }
        if across < TURNED * area { round.push(surface) } else { blades.push(piece) }
    }
    // The hub is nearest to the axis.
    let inner = |s: &Surface| s.points.iter().map(|p| Meridional::of(p).r).fold(f64::INFINITY, f64::min);
    round.sort_by(|a, b| inner(a).total_cmp(&inner(b)));
    let mut round = round.into_iter();
    let hub = round.next()?;
    let shroud = round.next().map(|s| TriangleMesh { points: s.points, triangles: s.triangles });
    (blades.len() > 1 && round.next().is_none()).then_some(Segments { hub, shroud, blades })
}

/// Hub and blades of a wheel in one mesh, about Z.
///
/// # Errors
/// When no turned face carries blades; says what to separate.
pub fn segmented(wheel: &Surface, name: &str) -> Result<Segments, PartError> {
    if let Some(segments) = loose(wheel) {
        return Ok(segments);
    }
    let unclear = |why: &str| {
        PartError::new(
            0,
            format!("hub and blades of the one mesh `{name}` cannot be told apart: {why}"),
            "export hub and blades as meshes of their own, or name them with --role NODE=hub and NODE=blade",
        )
    };
    let turned: Vec<bool> =
        (0..wheel.triangles.len()).map(|t| meridional_normal(wheel, t).1.abs() < TURNED).collect();
    let (face, count) =
        wheel.groups(|a, b| turned[a] && turned[b] && wheel.normals[a].dot(&wheel.normals[b]) > SMOOTH);
    // The hub is the large turned face that meets what is not turned along the longest border.
    let (mut areas, mut borders) = (vec![0.0; count], vec![0.0; count]);
    for t in (0..face.len()).filter(|&t| turned[t]) {
        areas[face[t] as usize] += wheel.area(t);
        for (k, &n) in wheel.neighbours[t].iter().enumerate() {
            if n != NONE && !turned[n as usize] {
                let corners = wheel.triangles[t];
                let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
                borders[face[t] as usize] += (wheel.points[b] - wheel.points[a]).norm();
            }
        }
    }
    let hub = (0..count)
        .max_by(|&a, &b| (areas[a] * borders[a]).total_cmp(&(areas[b] * borders[b])))
        .filter(|&f| areas[f] * borders[f] > 0.0)
        .ok_or_else(|| unclear("no face of it is turned about the axis and carries blades"))?;

    let size = wheel.points.iter().map(|p| Meridional::of(p).r).fold(0.0, f64::max);
    let tolerance = ON_HUB.0.max(ON_HUB.1 * size);
    let corners: Vec<Meridional> = wheel.points.iter().map(Meridional::of).collect();
    let of = |keep: &dyn Fn(usize) -> bool| -> Vec<Meridional> {
        let mut used = vec![false; corners.len()];
        for t in (0..face.len()).filter(|&t| keep(t)) {
            wheel.triangles[t].iter().for_each(|i| used[*i as usize] = true);
        }
        corners.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p).collect()
    };
    let standing = of(&|t| !turned[t]);
    let course = Course::of(&standing);
    let profile = course
        .curve(&of(&|t| turned[t] && face[t] as usize == hub))
        .filter(|p| p.residual < tolerance)
        .ok_or_else(|| {
            unclear("no turned face runs from inlet to outlet, as where fillets join it to the blades")
        })?;
    let middle =
        standing.iter().fold(Meridional::default(), |s, p| Meridional { r: s.r + p.r, z: s.z + p.z });
    let number = standing.len().max(1) as f64;
    let curve = MeridionalCurve::through(&profile.points)
        .facing(Meridional { r: middle.r / number, z: middle.z / number });
    let heights: Vec<f64> = corners.iter().map(|p| curve.project(*p).1).collect();
    let any =
        |t: usize, is: &dyn Fn(f64) -> bool| wheel.triangles[t].iter().any(|i| is(heights[*i as usize]));
    let below = |t: usize| any(t, &|h| h < -tolerance);
    let blade = |t: usize| !below(t) && any(t, &|h| h > tolerance);

    let blades = pieces(&mesh_of(wheel, &blade));
    let area = |mesh: &TriangleMesh| {
        let surface = Surface::of(mesh);
        (0..surface.triangles.len()).map(|t| surface.area(t)).sum::<f64>()
    };
    let measured: Vec<(f64, TriangleMesh)> = blades.into_iter().map(|m| (area(&m), m)).collect();
    let largest = measured.iter().map(|(a, _)| *a).fold(0.0, f64::max);
    let blades: Vec<TriangleMesh> =
        measured.into_iter().filter(|(a, _)| *a > SCRAP * largest).map(|(_, m)| m).collect();
    if blades.len() < 2 {
        return Err(unclear("what stands on its hub hangs together, as where a cover joins the blades"));
    }
    Ok(Segments { hub: wheel.part(|t| !below(t) && !blade(t)), shroud: None, blades })
}

fn mesh_of(wheel: &Surface, keep: &dyn Fn(usize) -> bool) -> TriangleMesh {
    let triangles = (0..wheel.triangles.len()).filter(|&t| keep(t)).map(|t| wheel.triangles[t]).collect();
    TriangleMesh { points: wheel.points.clone(), triangles }.compact()
}
