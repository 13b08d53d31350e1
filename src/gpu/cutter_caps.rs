//! Where the section plane cuts tools: one quad of the plane per body of revolution, of which the shader
//! keeps what lies within the body. Tools overlap, so that the parity rule of the part does not hold for
//! them.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::cutters::{AssemblyPiece, CutterInstance, DrawnCutter};
use super::scene::SectionPlane;
use crate::palette::Rgb;

/// A body of a tool in the section plane. 52 bytes, matches `CapIn` of `shaders/scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CutterCap {
    /// Tip of the tool, mm.
    pub tip: [f32; 3],
    /// Height of the lower end above it, mm.
    pub low: f32,
    /// Unit axis, tip → holder.
    pub axis: [f32; 3],
    /// Height of the upper end, mm.
    pub high: f32,
    /// Radii at both ends, mm.
    pub radii: [f32; 2],
    /// Radius of the core, mm; 0 of shanks and holders.
    pub core_radius: f32,
    /// Corner radius at the lower end, mm.
    pub corner_radius: f32,
    /// Colour, as in [`CutterInstance::state`].
    pub state: u32,
}

/// Colour of shanks and holders in the section plane.
const ASSEMBLY_COLOUR: Rgb = [0.45, 0.48, 0.52];

impl CutterCap {
    fn of_cutter(cutter: &CutterInstance) -> Self {
        let CutterInstance { tip, radius, axis, height, core_radius, corner_radius, state, .. } = *cutter;
        Self { tip, low: 0.0, axis, high: height, radii: [radius; 2], core_radius, corner_radius, state }
    }

    fn of_piece(cutter: &CutterInstance, piece: &AssemblyPiece) -> Self {
        let mut coloured = *cutter;
        coloured.set_colour(Some(ASSEMBLY_COLOUR));
        let [low, high] = piece.heights;
        Self {
            low,
            high,
            radii: piece.radii,
            core_radius: 0.0,
            corner_radius: 0.0,
            state: coloured.state,
            ..Self::of_cutter(cutter)
        }
    }

    /// Whether the plane comes near enough to the body that it may cut it.
    fn may_meet(&self, plane: &SectionPlane) -> bool {
        let middle = Vec3::from_array(self.tip) + Vec3::from_array(self.axis) * 0.5 * (self.low + self.high);
        let reach = (0.5 * (self.high - self.low)).hypot(self.radii[0].max(self.radii[1]));
        (plane.normal.dot(middle) - plane.offset).abs() <= reach
    }
}

/// Appends the bodies of a cutter, drawn as `instance`, that `plane` may cut; shank and holder too if
/// `with_assembly`.
pub fn append_caps(
    cutter: &DrawnCutter,
    instance: &CutterInstance,
    with_assembly: bool,
    plane: &SectionPlane,
    into: &mut Vec<CutterCap>,
) {
    let pieces = cutter.assembly.iter().filter(|_| with_assembly);
    let caps = pieces.map(|piece| CutterCap::of_piece(instance, piece));
    let caps = std::iter::once(CutterCap::of_cutter(instance)).chain(caps);
    into.extend(caps.filter(|cap| cap.may_meet(plane)));
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn only_bodies_near_the_plane_are_drawn_in_it() {
        let instance =
            CutterInstance { axis: [0.0, 0.0, 1.0], radius: 5.0, height: 60.0, ..Default::default() };
        let holder = AssemblyPiece { heights: [60.0, 90.0], radii: [10.0, 20.0] };
        let cutter = DrawnCutter { instance, retract: Vec3::ZERO, section: 0, assembly: Arc::new([holder]) };
        let at = |offset: f32, with_assembly: bool| {
            let mut caps = Vec::new();
            let plane = SectionPlane { normal: Vec3::Z, offset };
            append_caps(&cutter, &instance, with_assembly, &plane, &mut caps);
            caps.iter().map(|cap| (cap.low, cap.high)).collect::<Vec<_>>()
        };
        assert_eq!(at(20.0, true), [(0.0, 60.0)], "through the cutter only");
        assert_eq!(at(85.0, true), [(60.0, 90.0)], "through the holder only");
        assert_eq!(at(85.0, false), []);
        assert_eq!(at(-40.0, true), [], "below the tip");
    }
}
