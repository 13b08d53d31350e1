//! Flank plans as cutter-location programs.

use super::path::MoveKind;
use super::{FlankMove, FlankOpening};
use crate::geometry::{Point, Vector};
use crate::setup::Tool;
use crate::toolpath::{ClProgram, ClTool, Motion, Move};

impl ClProgram {
    /// The program of a flank plan: its moves with one `tool`, each at its own feed rate.
    pub fn of_flank(part: &str, tool: &Tool, moves: &[FlankMove]) -> Self {
        let moves = moves.iter().map(|m| Move {
            motion: match m.kind {
                MoveKind::Rapid => Motion::Rapid,
                MoveKind::Approach | MoveKind::Cut | MoveKind::Link => Motion::Feed(Some(m.feed_mm_per_min)),
            },
            tip: m.tip,
            axis: m.axis,
            tool: Some(0),
            line: 0,
        });
        Self {
            part: part.to_owned(),
            tools: vec![ClTool::from_tool(tool)],
            moves: moves.collect(),
            ..Self::default()
        }
    }

    /// This program after the plunges of `opening`, if there are any.
    #[must_use]
    pub fn after_opening(mut self, opening: Option<&FlankOpening>) -> Self {
        let Some(FlankOpening { tool, plunges }) = opening else { return self };
        let number = Some(self.tools.len());
        self.tools.push(ClTool::from_tool(tool));
        let plunge = |&(retract, tip, axis): &(Point, Point, Vector)| {
            let motions = [
                (Motion::Rapid, retract),
                (Motion::Feed(Some(tool.plunge_feed)), tip),
                (Motion::Rapid, retract),
            ];
            motions.map(|(motion, tip)| Move { motion, tip, axis, tool: number, line: 0 })
        };
        self.moves.splice(0..0, plunges.iter().flat_map(plunge));
        self
    }
}
