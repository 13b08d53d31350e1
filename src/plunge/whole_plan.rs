//! The plan put together from its sections.

use std::sync::Arc;

use super::assembly::DropCause;
use super::context::PlanContext;
use super::cut::{CutStation, SectionCut};
use super::error::PlanError;
use super::placed_cutter::PlacedCutter;
use super::plan::{Dropped, PlungePlan, Position, SectionPlan, Unevaluated};
use super::row::Station;
use crate::cutting::contact::Columns;
use crate::monitor::Cancelled;
use crate::setup::{AxisPolicy, tool_of};

/// A plan with final axes and depths; contact with stock and retract points are not computed yet.
#[derive(Debug)]
pub struct PlacedPlan {
    pub(super) plan: PlungePlan<Unevaluated>,
    /// Its plunges.
    pub(super) columns: Columns,
}

impl PlacedPlan {
    /// The plan without its evaluation.
    pub fn plan(&self) -> &PlungePlan<Unevaluated> {
        &self.plan
    }
}

/// Assembles the plan of these sections with all their plunges.
pub(super) fn assemble_all(
    context: &PlanContext,
    policy: AxisPolicy,
    cuts: &[Arc<SectionCut>],
) -> Result<PlacedPlan, PlanError> {
    let mut plan = PlungePlan {
        policy,
        sections: Vec::new(),
        positions: Vec::new(),
        dropped: Vec::new(),
        iterations: 0,
        converged: true,
    };
    for (index, (section, cut)) in context.setup.plunge.sections.iter().zip(cuts).enumerate() {
        let tool = tool_of(context.setup, section.tool)?;
        let rule = context.assembly_rule(tool);
        plan.sections.push(SectionPlan {
            tool: tool.clone(),
            from: section.from,
            to: section.to,
            feed: cut.feed,
            rows: cut.rows.len(),
            kind: section.kind,
            added: cut.added,
        });
        for (row_index, row) in cut.rows.iter().enumerate() {
            plan.iterations = plan.iterations.max(row.iterations);
            plan.converged &= row.converged;
            let missing = row.missing.iter();
            plan.dropped.extend(missing.map(|&(s, DropCause { why, stick_out })| Dropped {
                section: index,
                row: row_index,
                s,
                why,
                stick_out,
            }));
            for CutStation { station, placed } in &row.stations {
                let placed = match placed {
                    Ok(placed) => placed,
                    Err(why) => {
                        let s = station.ends.s_hub;
                        let cause = match &rule {
                            Some(rule) => rule.cause(*why, (station.tip, station.axis), f64::INFINITY),
                            None => (*why).into(),
                        };
                        let DropCause { why, stick_out } = cause;
                        plan.dropped.push(Dropped { section: index, row: row_index, s, why, stick_out });
                        continue;
                    }
                };
                plan.positions.push(placed_position(station, placed, (index, row_index), row.lambda));
            }
        }
    }
    if plan.positions.is_empty() && plan.is_unfinished() {
        return Err(Cancelled.into());
    }
    let columns = cuts.last().map(|cut| cut.columns.clone()).unwrap_or_default();
    Ok(PlacedPlan { plan, columns })
}

/// The position of a cutter that is placed at `station`, in a section and row.
fn placed_position(
    station: &Station,
    placed: &PlacedCutter,
    (section, row): (usize, usize),
    lambda: f64,
) -> Position<Unevaluated> {
    Position {
        tip: placed.cutter.tip,
        axis: station.axis,
        section,
        row,
        s: station.ends.s_hub,
        lambda,
        alpha_rad: station.alpha_rad,
        contact_point: station.contact_point,
        lift: placed.lift,
        blocked: station.blocked,
        limited_by: station.limited_by,
        hub_clearance: placed.hub_clearance,
        blade_clearance: placed.blade_clearance,
        evaluation: Unevaluated,
    }
}
