//! Flank plans as cutter-location programs.

use super::FlankMove;
use super::path::MoveKind;
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
}
