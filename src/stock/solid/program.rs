//! A program as moves of tool assemblies.

use super::assembly::SolidTool;
use super::motion::{SolidMove, ToolPose, tell_plunges_from_approaches};
use crate::error::{ErrorCode, UserError};
use crate::setup::Setup;
use crate::toolpath::{ClProgram, Motion};

/// Why a program cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{error}")]
pub struct ProgramFault {
    /// Line of the program; 0 when it is about all of it.
    pub line: usize,
    /// What is wrong and what to do.
    pub error: UserError,
}

/// A program that can be simulated.
#[derive(Clone, Debug)]
pub struct SolidProgram {
    /// The tools, as the moves refer to them.
    pub tools: Vec<SolidTool>,
    /// Moves with a tool, in order; `number` is that of the move in the program.
    pub moves: Vec<SolidMove>,
    /// Number of moves of the program, those without a tool included.
    pub count: usize,
}

impl SolidProgram {
    /// The moves of `program` with its tools, completed by `setup`. After a tool change the first move starts
    /// where it ends, as its position after the change is unknown.
    ///
    /// # Errors
    /// When no tool is loaded, a cut comes before any tool, or a tool has no diameter.
    pub fn new(program: &ClProgram, setup: &Setup) -> Result<Self, ProgramFault> {
        let fault = |line: usize, what: &str, help: &str| {
            Err(ProgramFault { line, error: UserError::new(ErrorCode::ProgramTool, what, help) })
        };
        if program.tools.is_empty() {
            return fault(0, "loads no tool", "add LOADTL and CUTTER before its cuts");
        }
        let tools: Vec<_> = program.tools.iter().map(|tool| tool.completed(setup)).collect();
        let mut moves: Vec<SolidMove> = Vec::with_capacity(program.moves.len());
        for (number, step) in program.moves.iter().enumerate() {
            let Some(tool) = step.tool else {
                if matches!(step.motion, Motion::Feed(_)) && number > 0 {
                    let help = "add LOADTL and CUTTER before it";
                    return fault(step.line, "cuts before any tool is loaded", help);
                }
                continue;
            };
            let size = &tools[tool];
            if size.diameter <= 0.0 {
                let what = format!("tool {} has the diameter {}", size.number, size.diameter);
                return fault(step.line, &what, "give CUTTER/ its diameter");
            }
            let to = ToolPose { tip: step.tip, axis: step.axis };
            let from = moves.last().filter(|last| last.tool == tool).map_or(to, |last| last.to);
            let rapid = step.motion == Motion::Rapid;
            moves.push(SolidMove { number: number as u32, tool, rapid, checks_core: true, from, to });
        }
        // As in `verify`: plunges are not checked against an assumed holder, approaches to passes not for
        // their core.
        let mills_along_curves = program.mills_along_curves();
        if mills_along_curves {
            tell_plunges_from_approaches(&mut moves);
        }
        let assembled = if mills_along_curves { SolidTool::from_tool } else { SolidTool::described };
        Ok(Self { tools: tools.iter().map(assembled).collect(), moves, count: program.moves.len() })
    }

    /// The moves before move `count` of the program.
    pub fn first(&self, count: usize) -> &[SolidMove] {
        &self.moves[..self.moves.partition_point(|step| (step.number as usize) < count)]
    }
}
