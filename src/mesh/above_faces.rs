//! Which triangles of a wheel given as one mesh stand over its hub: its blades.

use super::revolved_face::RevolvedFace;
use super::revolved_patches::RevolvedPatches;
use super::surface::MeshSurface;
use super::trim::trimmed;

/// How far before and past the ends of the hub's curve a face of a blade may go on below it, as a share of
/// the length of the curve along the course.
const END_SLACK: f64 = 0.05;

/// Tells the triangles of a wheel by their heights over its hub and its cover.
pub(super) struct AboveFaces<'a> {
    pub patches: &'a RevolvedPatches<'a>,
    pub cover: Option<&'a RevolvedFace>,
}

impl AboveFaces<'_> {
    /// Whether the height over `face` of some corner of triangle `t` is such.
    fn any(&self, face: &RevolvedFace, t: usize, is: impl Fn(f64) -> bool) -> bool {
        self.patches.wheel.triangles[t].iter().any(|i| is(face.heights[*i as usize]))
    }

    fn is_below(&self, face: &RevolvedFace, t: usize) -> bool {
        self.any(face, t, |height| height < -self.patches.tolerance)
    }

    fn rises_over(&self, face: &RevolvedFace, t: usize) -> bool {
        self.any(face, t, |height| height > self.patches.tolerance)
    }

    /// Whether a triangle is on the curve of a face.
    fn lies_on(&self, face: &RevolvedFace, t: usize) -> bool {
        !self.is_below(face, t) && !self.rises_over(face, t)
    }

    /// The triangles of a wheel that are of a face. Of CAD, the lowest triangles of fillets are not.
    pub fn surface_of(&self, face: &RevolvedFace) -> MeshSurface {
        let RevolvedPatches { wheel, exact, turned, .. } = self.patches;
        wheel.subset(|t| self.lies_on(face, t) && (exact.is_empty() || turned[t]))
    }

    /// Where a face goes on past its curve it is not a blade, on whichever side of the curve's end it is.
    fn is_past(&self, face: &RevolvedFace, t: usize) -> bool {
        let RevolvedPatches { wheel, corners, course, .. } = self.patches;
        let outside = |i: &u32| {
            let x = course.coordinates_of(corners[*i as usize]).0;
            // A leading edge that is turned may lean ahead of the curve, and stand over it.
            face.at_end[*i as usize] && (x < face.extent.0 || x > face.extent.1)
        };
        self.patches.is_of(t, face.number) && wheel.triangles[t].iter().any(outside)
    }

    /// Whether a triangle is within the cover. Ahead of it blades may be higher than it goes on, in its eye.
    fn is_in_cover(&self, t: usize) -> bool {
        let Some(cover) = self.cover else { return true };
        let tolerance = self.patches.tolerance;
        let behind = |i: &u32| !cover.at_end[*i as usize] && cover.heights[*i as usize] < -tolerance;
        let is_behind = self.patches.wheel.triangles[t].iter().any(behind);
        !is_behind && self.rises_over(cover, t) && !self.is_past(cover, t)
    }

    /// Whether a triangle is of a face of a blade that goes on below the edge of the hub, as a trailing edge
    /// does in the rim.
    fn crosses(&self, hub: &RevolvedFace, t: usize) -> bool {
        let RevolvedPatches { wheel, corners, course, .. } = self.patches;
        let reach = END_SLACK * (hub.extent.1 - hub.extent.0);
        let within = |i: &u32| {
            let p = corners[*i as usize];
            let x = course.coordinates_of(p).0;
            // A rim at right angles to the hub may be wide.
            let is_at_end = || {
                let t = hub.curve.project_past_ends(p).0;
                t > -reach && t < hub.curve.length() + reach
            };
            (x > hub.extent.0 - reach && x < hub.extent.1 + reach) || is_at_end()
        };
        self.is_below(hub, t) && self.rises_over(hub, t) && wheel.triangles[t].iter().all(within)
    }

    /// What stands over a hub within the cover, trimmed at the hub's curve. `whole` is the face that this hub
    /// is a piece of, if it is one.
    pub fn over_hub(&self, hub: &RevolvedFace, whole: Option<&RevolvedFace>) -> MeshSurface {
        let RevolvedPatches { wheel, turned, tolerance, .. } = self.patches;
        let stands = |t: usize| !self.is_below(hub, t) && self.rises_over(hub, t) && !self.is_past(hub, t);
        let crossing: Vec<bool> = (0..wheel.triangles.len()).map(|t| self.crosses(hub, t)).collect();
        let is_wall = |t: usize| turned[t] && whole.is_some_and(|whole| self.lies_on(whole, t));
        let over_hub = wheel.subset(|t| (stands(t) || crossing[t]) && self.is_in_cover(t) && !is_wall(t));
        match crossing.contains(&true) {
            true => trimmed(&over_hub, &hub.curve, *tolerance),
            false => over_hub,
        }
    }
}
