//! Shank and holder while planning: a position is kept only where both are clear of the finished part and of
//! the whole blank, or, where the blank stands above the shroud, of what earlier plunges left of it. Tools
//! without a given shank or holder are not held to this.

use super::reasons::DropReason;
use crate::cutting::assembly::AssemblySurroundings;
use crate::cutting::contact::Earlier;
use crate::geometry::{Point, Vector};
use crate::part::{Blank, FinishedPart};
use crate::setup::{AssemblyPart, AssemblySegment, Setup, Tool};

/// Clearance missing by rounding that a planned position may have, mm: below what `verify` tolerates.
const PLANNED_TOLERANCE: f64 = 5e-4;

/// Why a position is left out, and the overhang with which it could be cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DropCause {
    /// The reason.
    pub why: DropReason,
    /// Smallest overhang with which the holder would be clear, mm; `None` where more than the holder is in
    /// the way.
    pub stick_out: Option<f64>,
}

impl From<DropReason> for DropCause {
    fn from(why: DropReason) -> Self {
        Self { why, stick_out: None }
    }
}

/// Judges poses of one tool.
#[derive(Clone, Debug)]
pub struct AssemblyRule<'a> {
    around: AssemblySurroundings<'a>,
    tool: &'a Tool,
    segments: Vec<AssemblySegment>,
}

impl<'a> AssemblyRule<'a> {
    /// The rule for `tool`; `None` where neither shank nor holder is given.
    pub fn new(tool: &'a Tool, finished: &'a FinishedPart, blank: &'a Blank, setup: &Setup) -> Option<Self> {
        let around = AssemblySurroundings::new(finished, setup).with_blank(blank);
        let segments = tool.assembly.segments(tool.overhang);
        (!segments.is_empty()).then_some(Self { around, tool, segments })
    }

    /// The rule after `earlier` plunges, where the blank stands above the shroud.
    pub fn after<'e>(&self, earlier: Earlier<'e>) -> AssemblyRule<'e>
    where
        'a: 'e,
    {
        let around = match self.around.blank.is_some_and(|blank| blank.outline().is_some()) {
            true => self.around.after(earlier),
            false => self.around,
        };
        AssemblyRule { around, tool: self.tool, segments: self.segments.clone() }
    }

    /// What is in the way with the tip and axis at `pose`, the shank first.
    pub fn obstacle(&self, pose: (Point, Vector)) -> Option<DropReason> {
        let part = self.around.first_obstacle(self.tool, &self.segments, pose, PLANNED_TOLERANCE)?;
        Some(match part {
            AssemblyPart::Shank => DropReason::Shank,
            AssemblyPart::Holder => DropReason::Holder,
        })
    }

    /// `why`, with the smallest overhang that makes the holder clear at `pose`, if that is at most `limit`
    /// mm.
    pub fn cause(&self, why: DropReason, pose: (Point, Vector), limit: f64) -> DropCause {
        let by_length = matches!(why, DropReason::Holder | DropReason::Overhang);
        DropCause {
            why,
            stick_out: by_length.then(|| self.around.stick_out(self.tool, pose, limit)).flatten(),
        }
    }
}
