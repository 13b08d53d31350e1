//! Bodies of a wheel whose roles nobody named: bodies of revolution are hub and cover, the rest are blades,
//! and slivers that modelling left over are dropped.

use super::profile::meridional_normal;
use super::segment::Segments;
use super::surface::MeshSurface;
use crate::geometry::Meridional;

/// Largest mean circumferential component of the normals of a body of revolution.
const TURNED: f64 = 0.1;
/// Shares of the largest blade's area and volume below which a body is a sliver.
const SLIVER: (f64, f64) = (0.12, 0.02);

/// A body with its name.
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its surface, about Z.
    pub surface: MeshSurface,
}

struct MeasuredBody {
    body: Body,
    area: f64,
    volume: f64,
    turned: bool,
}

impl MeasuredBody {
    fn from_body(body: Body) -> Self {
        let s = &body.surface;
        let (mut across, mut area, mut volume) = (0.0, 0.0, 0.0);
        for t in 0..s.triangles.len() {
            across += s.area(t) * meridional_normal(s, t).1.abs();
            area += s.area(t);
            let [a, b, c] = s.triangles[t].map(|i| s.points[i as usize].coords);
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        // An open surface has no volume.
        let volume = if s.border_edges().next().is_none() { volume.abs() } else { f64::INFINITY };
        Self { area, volume, turned: across < TURNED * area, body }
    }
}

/// Sorts bodies into hub, cover and blades; lines about dropped ones are added to `notes`. `Ok(None)` where
/// there is no body of revolution or there are fewer than two blades.
///
/// # Errors
/// Returns the number of bodies of revolution if there are more than two.
pub fn segment_bodies(bodies: Vec<Body>, notes: &mut Vec<String>) -> Result<Option<Segments>, usize> {
    let measured = bodies.into_iter().map(MeasuredBody::from_body);
    let (mut round, mut others): (Vec<MeasuredBody>, Vec<MeasuredBody>) = measured.partition(|m| m.turned);
    let most = |of: fn(&MeasuredBody) -> f64| others.iter().map(of).fold(0.0, f64::max);
    let (area, volume) = (most(|m| m.area), most(|m| if m.volume.is_finite() { m.volume } else { 0.0 }));
    let is_sliver = |m: &MeasuredBody| m.area < SLIVER.0 * area || m.volume < SLIVER.1 * volume;
    let mut dropped: Vec<String> = Vec::new();
    others.retain(|m| {
        if is_sliver(m) {
            dropped.push(format!("`{}` ({:.2} mm² of surface)", m.body.name, m.area));
        }
        !is_sliver(m)
    });
    if others.len() < 2 {
        return Ok(None);
    }
    // Washers and other small parts of revolution are no hub.
    let largest = round.iter().map(|m| m.area).fold(0.0, f64::max);
    round.retain(|m| m.area >= SLIVER.0 * largest);
    if round.len() > 2 {
        return Err(round.len());
    }
    // The hub is nearest to the axis.
    let inner = |m: &MeasuredBody| {
        m.body.surface.points.iter().map(|p| Meridional::from_point(p).r).fold(f64::INFINITY, f64::min)
    };
    round.sort_by(|a, b| inner(a).total_cmp(&inner(b)));
    let mut round = round.into_iter().map(|m| m.body.surface);
    let Some(hub) = round.next() else { return Ok(None) };
    if !dropped.is_empty() {
        let first = dropped.iter().take(4).cloned().collect::<Vec<_>>().join(", ");
        let more = if dropped.len() > 4 { format!(" and {} more", dropped.len() - 4) } else { String::new() };
        notes.push(format!("left out as too small for a blade: {first}{more}"));
    }
    let blades = others.into_iter().map(|m| m.body.surface).collect();
    Ok(Some(Segments { hub, shroud: round.next(), blades }))
}
