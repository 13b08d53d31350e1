//! What the check of a plunge program found.

use super::{AssemblyDistances, Fault};
use crate::cutting::contact::{CoreContact, Engagement};
use crate::geometry::{Point, Vector};
use crate::plunge::SectionPlan;

/// Result of checking a plunge program.
#[derive(Clone, Debug)]
pub struct PlungeVerdict {
    /// Every cut as it was measured, in the order of the program.
    pub cuts: Vec<JudgedCut>,
    /// The sections that the program names; otherwise the cuts between two tool changes.
    pub sections: Vec<SectionPlan>,
    /// Number of channels with cuts.
    pub channels: usize,
    /// Deepest plunge: from its bottom to the top of the blank above it, mm.
    pub deepest_plunge: f64,
    /// Least distances of shank and holder to the finished part.
    pub assembly: AssemblyDistances,
    /// All faults, by line.
    pub faults: Vec<Fault>,
}

/// A cut of a program as it was measured, in the frame of channel 1: those of other channels are rotated into
/// it.
#[derive(Clone, Debug)]
pub struct JudgedCut {
    /// Centre of the bottom at the end of the cut, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Number of pitches by which its channel is ahead of channel 1.
    pub channel_offset: i64,
    /// Index into [`PlungeVerdict::sections`].
    pub section: usize,
    /// Row within the section.
    pub row: usize,
    /// Contact of the core with the stock that the cuts before it left.
    pub contact: CoreContact,
    /// Engagement of its circumference in that stock.
    pub engagement: Engagement,
    /// Least distance of the cutter to the finished hub along the cut, mm.
    pub hub_clearance: f64,
    /// The same to the finished blades, mm.
    pub blade_clearance: f64,
    /// Least distance of the bottom to the blank in the rapids of the cut, mm; `None` where it has none.
    pub retract_clearance: Option<f64>,
}

impl PlungeVerdict {
    /// Number of rows in all channels.
    pub fn rows(&self) -> usize {
        self.sections.iter().map(|section| section.rows).sum()
    }
}
