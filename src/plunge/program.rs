//! Plunge plans as cutter-location programs.

use super::Position;
use super::{PlungePlan, SectionPlan};
use crate::geometry::{Point, Vector};
use crate::setup::Tool;
use crate::toolpath::{ClProgram, ClRow, ClSection, ClTool, Motion, Move, UNFINISHED};

impl ClSection {
    fn from_section(section: &SectionPlan) -> Self {
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
    /// The program of a plunge plan in cutting order, with sections and rows: per plunge a rapid to the
    /// retract point, and on down to where it approaches stock if the setup has that; a feed move to the tip,
    /// with its interruptions; a move off the stock where it has one; and a rapid back. Positions of a
    /// section that the plan lacks are left out. The part name of an unfinished plan ends in `UNFINISHED`.
    pub fn of_plan(part: &str, plan: &PlungePlan) -> Self {
        let part = if plan.is_unfinished() { format!("{part} {UNFINISHED}") } else { part.to_owned() };
        let mut program = Self {
            part,
            sections: plan.sections.iter().map(ClSection::from_section).collect(),
            ..Self::default()
        };
        for position in &plan.positions {
            let Some(tool) = plan.sections.get(position.section).map(|section| &section.tool) else {
                continue;
            };
            let (section, row) = (position.section, position.row);
            if program.rows.last().is_none_or(|last| (last.section, last.row) != (section, row)) {
                program.rows.push(ClRow { first_move: program.moves.len(), section, row });
            }
            let cutter = ClTool::from_tool(tool);
            let known = program.tools.iter().position(|t| *t == cutter);
            let index = known.unwrap_or_else(|| {
                program.tools.push(cutter);
                program.tools.len() - 1
            });
            program.moves.extend(plunge_moves(position, tool).into_iter().map(|(motion, tip)| Move {
                motion,
                tip,
                axis: position.axis,
                tool: Some(index),
                line: 0,
            }));
        }
        program
    }

    /// Index of the move to the bottom of each position of `plan`, whose program this is; `None` of positions
    /// that have no moves.
    pub fn bottoms_of(&self, plan: &PlungePlan) -> Vec<Option<usize>> {
        let starts = self.plunge_starts();
        let mut plunges = starts.iter().zip(starts.iter().skip(1).copied().chain([self.moves.len()]));
        let bottom = |position: &Position| {
            plan.sections.get(position.section)?;
            let (&first, end) = plunges.next()?;
            Some(first + self.moves[first..end].iter().position(|step| step.tip == position.tip)?)
        };
        plan.positions.iter().map(bottom).collect()
    }
}

/// The moves of a plunge, with the point to which each brings the tip.
fn plunge_moves(position: &Position, tool: &Tool) -> Vec<(Motion, Point)> {
    let (tip, axis) = (position.tip, position.axis);
    let evaluation = &position.evaluation;
    let feed = Motion::Feed(Some(evaluation.motion.feed_mm_per_min.unwrap_or(tool.plunge_feed)));
    let mut moves = vec![(Motion::Rapid, evaluation.retract)];
    if let Some(height) = evaluation.motion.approach {
        moves.push((Motion::Rapid, tip + axis * height));
    }
    // The rapid above the approach cuts nothing, so no chip has to be broken there.
    let start = evaluation.motion.approach.unwrap_or(f64::INFINITY);
    if let Some(pecking) = evaluation.motion.pecking.and_then(|pecking| pecking.below(start)) {
        for height in pecking.heights() {
            moves.push((feed, tip + axis * height));
            moves.push((Motion::Rapid, tip + axis * (height + pecking.back())));
        }
    }
    moves.push((feed, tip));
    if evaluation.motion.lead_out != Vector::zeros() {
        moves.push((feed, evaluation.motion.led_out(tip, &axis)));
    }
    moves.push((Motion::Rapid, evaluation.retract + evaluation.motion.lead_out));
    moves
}
