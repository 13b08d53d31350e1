//! What tells a body of revolution about Z, and how far a body goes round it.

use super::profile::meridional_normal;
use super::surface::MeshSurface;
use crate::geometry::Meridional;

/// Largest circumferential component in the normals of a surface of revolution.
pub const TURNED: f64 = 0.1;
/// Number of sectors about the axis that are looked at.
pub const SECTORS: usize = 24;

/// Whether a body is one of revolution about Z: by the mean circumferential component of its normals.
pub fn is_round(body: &MeshSurface) -> bool {
    let (mut across, mut area) = (0.0, 0.0);
    for t in 0..body.triangles.len() {
        across += body.area(t) * meridional_normal(body, t).1.abs();
        area += body.area(t);
    }
    across < TURNED * area
}

/// Number of [`SECTORS`] in which a body has corners at more than a `share` of its largest radius; a corner
/// on the axis is in none.
pub fn sectors_met(body: &MeshSurface, share: f64) -> usize {
    let within = share * radii(body).1;
    let mut met = [false; SECTORS];
    for p in body.points.iter().filter(|p| Meridional::from_point(p).r > within) {
        let turn = p.y.atan2(p.x) / std::f64::consts::TAU + 0.5;
        met[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] = true;
    }
    met.iter().filter(|met| **met).count()
}

/// Smallest and largest distance of the corners of a body from Z, mm.
pub fn radii(body: &MeshSurface) -> (f64, f64) {
    let radii = body.points.iter().map(|p| Meridional::from_point(p).r);
    radii.fold((f64::INFINITY, 0.0), |(inner, outer), r| (inner.min(r), outer.max(r)))
}
