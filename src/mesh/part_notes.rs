//! Lines about what was derived from meshes, or is left of them.

use super::sides::{SideCurve, SpanSection};
use crate::geometry::{Meridional, MeridionalCurve, Point};
use crate::part::{Impeller, PartDescription, Rotation, SideProbe};

/// Smallest wrap of a blade from which the sense of rotation is derived without a note, rad.
const CLEAR_WRAP: f64 = 0.1;
/// Smallest width of a ring of the hub past the trailing edge that is noted, as a share of its radius: a rim
/// may be chamfered or rounded.
const RING: f64 = 0.02;

/// Heights in the channel, as shares of its own, between which corners of a mesh are held against the sides:
/// beyond are fillets and rounded tips.
const BESIDE: std::ops::Range<f64> = 0.3..0.8;
/// Places along the sides with which they are: beyond are the faces of blunt edges.
const ALONG: std::ops::Range<f64> = 0.03..0.97;
/// Most corners that are.
const CORNERS: usize = 400;
/// Distance of a corner from both sides that is noted, as a share of the diameter.
const OFF: f64 = 1e-3;

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

/// A line about sides of the main blade of `found` that leave the `corners` of its mesh: its sections were
/// misread somewhere.
pub fn sides_note(found: &PartDescription, corners: &[Point]) -> Option<String> {
    // What cannot be built says so itself.
    let part = Impeller::build(found).ok()?;
    let probes = [&part.main.suction, &part.main.pressure].map(|side| SideProbe::new(side, 0.0, 1.0));
    let is_beside = |p: &&Point| {
        let place = Meridional::from_point(p);
        let [low, high] = [&part.hub, &part.shroud].map(|path| path.curve().project(place).1.abs());
        BESIDE.contains(&(low / (low + high).max(1e-300)))
    };
    let stride = corners.len().div_ceil(CORNERS).max(1);
    let beside = corners.iter().step_by(stride).filter(is_beside);
    let distances = beside.filter_map(|p| {
        let nearest = probes.each_ref().map(|probe| probe.nearest_to_point(p));
        let nearest = nearest.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        ALONG.contains(&nearest.u).then_some((nearest.distance, p))
    });
    let (off, at) = distances.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let at = Meridional::from_point(at);
    (off > OFF * 2.0 * part.rim_radius()).then(|| {
        format!(
            "the sides of the main blade were not understood everywhere: they are {off:.2} mm off the file's \
             surfaces at z = {:.1}, r = {:.1} mm; do not cut this part before it is compared with the CAD model",
            at.z, at.r
        )
    })
}
