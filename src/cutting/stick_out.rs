//! The overhang with which a holder that is in the way would be clear.

use super::assembly::{
    ASSEMBLY_TOLERANCE, AssemblySurroundings, blade_distance, blank_distance, hub_distance,
};
use crate::geometry::{Meridional, Point, Vector};
use crate::setup::{AssemblyPart, AssemblySegment, Tool};

/// Least distance that a search goes on by, and largest extension, mm.
const STEP: f64 = 0.05;
const MAX_EXTENSION: f64 = 1000.0;

impl AssemblySurroundings<'_> {
    /// The least overhang, in whole mm and at most `limit`, with which the holder of `tool` is clear at a
    /// pose; `None` where the shank is in the way, too, or no overhang within reason suffices.
    pub fn stick_out(&self, tool: &Tool, pose: (Point, Vector), limit: f64) -> Option<f64> {
        let segments = tool.assembly.segments(tool.overhang);
        let (holder, shank): (Vec<_>, Vec<_>) =
            segments.into_iter().partition(|segment| segment.part == AssemblyPart::Holder);
        let collides = |segment: &AssemblySegment| self.misses(segment, tool, pose, ASSEMBLY_TOLERANCE);
        // A shank whose lower end is known only gets longer with the overhang.
        let only_grows = tool.assembly.flute_length.is_some();
        if holder.is_empty() || only_grows && shank.iter().any(collides) {
            return None;
        }
        let limit = limit.min(tool.overhang + MAX_EXTENSION);
        let mut overhang = tool.overhang;
        while overhang <= limit {
            let rise = overhang - tool.overhang;
            let raised =
                |segment: &AssemblySegment| AssemblySegment { from: segment.from + rise, ..*segment };
            let pieces = || holder.iter().map(raised);
            // The blank is what a holder leaves last: the way out of it is found first, by single points.
            let missing =
                pieces().filter_map(|piece| self.depth_of_axis(&piece, tool, pose)).reduce(f64::max);
            let missing =
                missing.or_else(|| pieces().filter_map(|piece| self.shortfall(&piece, tool, pose)).next());
            if let Some(missing) = missing {
                // A holder that is raised by some distance gains at most that. Whole overhangs are proposed.
                overhang = (overhang + missing.max(STEP)).ceil();
                continue;
            }
            let whole = overhang.ceil();
            if overhang < whole {
                overhang = whole;
                continue;
            }
            let longer = tool.assembly.segments(whole);
            let mut shank = longer.iter().filter(|segment| segment.part == AssemblyPart::Shank);
            return (!shank.any(collides)).then_some(whole);
        }
        None
    }

    /// Clearance from the blank that the lower end of a segment's axis misses at a pose, mm: the segment
    /// misses no less. `None` where it misses none, or less of the blank stands.
    fn depth_of_axis(&self, segment: &AssemblySegment, tool: &Tool, pose: (Point, Vector)) -> Option<f64> {
        let blank = self.blank.filter(|_| self.earlier.is_none())?;
        let widest = segment.radii[0].max(segment.radii[1]);
        let low = Meridional::from_point(&(pose.0 + pose.1 * segment.from));
        let missing = self.clearances.of_part(segment.part) - blank.nearest_top(low, &mut None).0;
        (widest > tool.radius() && missing > STEP).then_some(missing)
    }

    /// Clearance that a segment misses at a pose, mm: of blank, hub or blades, of the first that it is too
    /// near to.
    fn shortfall(&self, segment: &AssemblySegment, tool: &Tool, pose: (Point, Vector)) -> Option<f64> {
        let frustum = segment.placed(&pose.0, &pose.1);
        let clearance = self.clearances.of_part(segment.part);
        let [hub, blade] = self.allowances.map(|allowance| allowance + clearance);
        let too_near = |missing: f64| Some(missing).filter(|missing| *missing > ASSEMBLY_TOLERANCE);
        let blank = || {
            let widest = frustum.radii[0].max(frustum.radii[1]);
            let blank = self.blank.filter(|_| widest > tool.radius())?;
            let missing = too_near(clearance - blank_distance(&frustum, blank, clearance))?;
            (!self.was_removed(&frustum, clearance, tool, pose, blank)).then_some(missing)
        };
        blank()
            .or_else(|| too_near(hub - hub_distance(self.finished, &frustum, hub)))
            .or_else(|| too_near(blade - blade_distance(self.finished, &frustum, blade)))
    }
}
