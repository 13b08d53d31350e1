//! Rapid approach of a plunge: how far down along its axis a tool is clear of what earlier plunges left.

use super::contact::{BlankTop, Earlier, StandingHeight, standing_height};
use crate::geometry::{CutterSolid, Point, Vector};
use crate::part::Blank;
use crate::setup::{AssemblySegment, ClearanceSetup, Tool};

/// What a tool keeps clear of in an approach.
#[derive(Debug)]
pub struct ApproachRule<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// Its shank and holder.
    pub segments: &'a [AssemblySegment],
    /// The blank before the first cut.
    pub blank: &'a Blank,
    /// Its top.
    pub top: &'a BlankTop<'a>,
    /// Distance that cutter, shank and holder keep from the stock below them, mm.
    pub below: f64,
    /// Distance that they keep from the stock beside them, mm.
    pub aside: f64,
    /// What shank and holder keep beside them more.
    pub clearances: ClearanceSetup,
}

impl ApproachRule<'_> {
    /// Height above `tip` along the unit `axis` down to which the tool is clear of what the `earlier` plunges
    /// left, with its distances, mm. Where that is more than `enough` mm, it may be any height above it.
    pub fn height(&self, (tip, axis): (Point, Vector), earlier: Earlier, enough: f64) -> StandingHeight {
        let stands = |from: f64, radius: f64, enough: f64| {
            let bottom =
                CutterSolid { tip: tip + axis * (from - self.below), axis, radius, corner_radius: 0.0 };
            standing_height(&bottom, earlier, self.blank, self.top, enough)
        };
        let radius = self.tool.radius();
        let mut height = stands(0.0, radius + self.aside, enough);
        for segment in self.segments {
            let widest = segment.radii[0].max(segment.radii[1]);
            // A segment no wider than the cutter moves where that does.
            if widest > radius && height.at_least <= enough {
                let aside = widest + self.clearances.of_part(segment.part) + self.aside;
                let needed = stands(segment.from, aside, enough);
                height.at_least = height.at_least.max(needed.at_least);
                height.at_most = height.at_most.max(needed.at_most);
            }
        }
        height
    }
}
