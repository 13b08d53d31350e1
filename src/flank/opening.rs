//! Plunges above the shroud that come before the passes.

use super::FlankMove;
use super::path::RAPID_MARGIN;
use crate::cutting::channel_link::{ChannelLink, MIN_LIFT};
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::Tool;
use crate::toolpath::{ClProgram, ClTool, Motion, Move};

/// Moves of a plunge: to above it, down, and back.
pub(super) const PLUNGE_MOVES: usize = 3;

/// Plunges that remove what stands above the shroud in the way of the tool for the passes.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankOpening {
    /// Their tool.
    pub tool: Tool,
    /// Retract point, tip and unit axis of each plunge, mm, part frame.
    pub plunges: Vec<(Point, Point, Vector)>,
    /// Tips and unit axes of the rapids from the last plunge to the first pass, mm, part frame; empty where
    /// there is nothing in the way, or a tool is changed between.
    pub link: Vec<(Point, Vector)>,
}

impl FlankOpening {
    /// Leads the link from the last plunge to the first of `moves`, which are those of the passes with
    /// `tool`, at the safety distance (mm) from `blank`. A tool is changed far from the part: the link is for
    /// passes with the tool of the plunges.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn lead_to(
        &mut self,
        moves: &[FlankMove],
        tool: &Tool,
        (blank, safety_distance): (&Blank, f64),
        monitor: &Monitor,
    ) -> Result<(), Cancelled> {
        self.link.clear();
        let (Some(&(from, _, axis)), Some(first)) = (self.plunges.last(), moves.first()) else {
            return Ok(());
        };
        if *tool == self.tool {
            let (from, to) = ((from, axis), (first.tip, first.axis));
            let safety = safety_distance + RAPID_MARGIN;
            let link = ChannelLink { tool, blank, safety, from, to, turn_rad: 0.0 }.positions(monitor)?;
            if (link[0].0 - from.0).norm() >= MIN_LIFT {
                self.link = link;
            }
        }
        Ok(())
    }

    /// Number of moves of the plunges and the link.
    pub(super) fn move_count(&self) -> usize {
        PLUNGE_MOVES * self.plunges.len() + self.link.len()
    }
}

impl ClProgram {
    /// This program after the plunges of `opening`, if there are any.
    #[must_use]
    pub fn after_opening(mut self, opening: Option<&FlankOpening>) -> Self {
        let Some(opening) = opening else { return self };
        let tool = ClTool::from_tool(&opening.tool);
        let index = self.tools.iter().position(|known| *known == tool).unwrap_or(self.tools.len());
        if index == self.tools.len() {
            self.tools.push(tool);
        }
        let to = |motion, tip, axis| Move { motion, tip, axis, tool: Some(index), line: 0 };
        let feed = Motion::Feed(Some(opening.tool.plunge_feed));
        let plunges = opening.plunges.iter().flat_map(|&(retract, tip, axis)| {
            [(Motion::Rapid, retract), (feed, tip), (Motion::Rapid, retract)]
                .map(|(motion, tip)| to(motion, tip, axis))
        });
        let link = opening.link.iter().map(|&(tip, axis)| to(Motion::Rapid, tip, axis));
        self.moves.splice(0..0, plunges.chain(link));
        self
    }
}
