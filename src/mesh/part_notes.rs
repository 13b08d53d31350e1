//! Lines about what was derived from meshes, or is left of them.

use super::sides::{SideCurve, SpanSection};
use crate::geometry::{Meridional, MeridionalCurve};
use crate::part::Rotation;

/// Smallest wrap of a blade from which the sense of rotation is derived without a note, rad.
const CLEAR_WRAP: f64 = 0.1;
/// Smallest width of a ring of the hub past the trailing edge that is noted, as a share of its radius: a rim
/// may be chamfered or rounded.
const RING: f64 = 0.02;

/// The sense of rotation derived from a blade's wrap, with a note where the wrap is small.
pub fn sense_from_wrap(sections: &[SpanSection], inlet_up: bool) -> (Rotation, Option<String>) {
    let sides = || sections.iter().flat_map(|s| &s.sides);
    let wrap = sides().map(SideCurve::wrap_rad).sum::<f64>() / sides().count().max(1) as f64;
    let rotation = Rotation::about_z(-wrap, inlet_up);
    let note = (wrap.abs() < CLEAR_WRAP).then(|| {
        format!(
            "the blades wrap by only {:.1}°, so that the suction side is uncertain: assumed to turn \
             {rotation}, seen from the inlet; if that is wrong, give --rotation {}",
            wrap.abs().to_degrees(),
            rotation.reversed().name()
        )
    });
    (rotation, note)
}

/// A line about the ring that is left of a hub past the trailing edge of its blades.
pub fn ring_note(sections: &[SpanSection], hub: &MeridionalCurve) -> Option<String> {
    let ends = sections.first()?.sides.each_ref().map(|side| Meridional::from_point(&side.point(1.0)));
    let last = ends.map(|p| hub.project(p).0).into_iter().fold(0.0, f64::max);
    let (width, rim) = (hub.length() - last, hub.point(hub.length()).r);
    (width > RING * rim).then(|| {
        format!(
            "the hub goes on {width:.1} mm past the trailing edge, to r = {rim:.1} mm: this ring is not planned, \
             and the blank ends at the trailing edge; if it is larger, give it as a file"
        )
    })
}
