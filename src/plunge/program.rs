//! Plunge plans as cutter-location programs.

use super::{PlungePlan, SectionPlan};
use crate::toolpath::{ClProgram, ClRow, ClSection, ClTool, Motion, Move};

/// Moves of a plunge in a program: to the retract point, to the tip, back.
pub const MOVES_PER_PLUNGE: usize = 3;

impl ClSection {
    fn of(section: &SectionPlan) -> Self {
        Self {
            from: section.from,
            to: section.to,
            diameter: section.tool.diameter,
            feed: section.feed,
            kind: section.kind,
        }
    }
}

impl ClProgram {
    /// The program of a plunge plan: per plunge a rapid to the retract point, a feed move to the tip and a
    /// rapid back, in cutting order, with sections and rows. Positions of a section that the plan lacks are
    /// left out. The part name of an unfinished plan ends in `UNFINISHED`.
    pub fn of_plan(part: &str, plan: &PlungePlan) -> Self {
        let part = if plan.is_unfinished() { format!("{part} UNFINISHED") } else { part.to_owned() };
        let mut program =
            Self { part, sections: plan.sections.iter().map(ClSection::of).collect(), ..Self::default() };
        for position in &plan.positions {
            let Some(tool) = plan.sections.get(position.section).map(|section| &section.tool) else {
                continue;
            };
            let (section, row) = (position.section, position.row);
            if program.rows.last().is_none_or(|last| (last.section, last.row) != (section, row)) {
                program.rows.push(ClRow { first_move: program.moves.len(), section, row });
            }
            let cutter = ClTool::of(tool);
            let known = program.tools.iter().position(|t| *t == cutter);
            let index = known.unwrap_or_else(|| {
                program.tools.push(cutter);
                program.tools.len() - 1
            });
            let plunge: [_; MOVES_PER_PLUNGE] = [
                (Motion::Rapid, position.evaluation.retract),
                (Motion::Feed(Some(tool.plunge_feed)), position.tip),
                (Motion::Rapid, position.evaluation.retract),
            ];
            program.moves.extend(plunge.map(|(motion, tip)| Move {
                motion,
                tip,
                axis: position.axis,
                tool: Some(index),
                line: 0,
            }));
        }
        program
    }
}
