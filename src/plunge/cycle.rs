//! The loop of [plunge paper], fig. 16: conventional positions → step inspection → axis optimisation →
//! drop-cutter depth and safe height, repeated until it converges; then contact and clearances are measured.
//!
//! Here are the sections in sequence and the plan put together from them. A section goes to its policy in
//! `policies`, its rows are cut in `cut`, the plan is measured in `evaluation`.

use std::sync::Arc;

use rayon::prelude::*;

use super::assembly::{AssemblyRule, DropCause};
use super::cut::{CutRow, PlacedCutter, SectionCut};
use super::plan::{Dropped, PlungePlan, Position, SectionPlan, Unevaluated};
use super::row::Station;
use super::section_cache::SectionCache;
use super::section_layout::StretchLayout;
use super::sections::{MAX_POSITIONS, too_many_positions};
use crate::cutting::contact::Columns;
use crate::error::UserError;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::setup::{AxisPolicy, SectionKind, SectionSetup, Setup, SetupFault, SetupPlace, Tool, tool_of};

/// Why planning failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part and setup do not match.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<PlanError> for UserError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(cancelled) => cancelled.into(),
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// Planner for one part and one setup; holds what all policies share.
#[derive(Debug)]
pub struct Planner<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) setup: &'a Setup,
    /// The plunges of the sections that open the blank.
    pub(super) opening: Columns,
    /// Layout of each section, independent of the policy; empty for sections that do not cut rows.
    layouts: Vec<Result<Vec<StretchLayout<'a>>, PlanError>>,
}

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

impl<'a> Planner<'a> {
    /// Planner for `workpiece` with a `setup` completed by [`super::sections::resolve`].
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        let mut planner = Self { workpiece, setup, opening: Columns::default(), layouts: Vec::new() };
        let shared = |section: &SectionSetup| match section.kind {
            SectionKind::Rows => planner.section_layout(section),
            SectionKind::Rest | SectionKind::Opening => Ok(Vec::new()),
        };
        planner.layouts = setup.plunge.sections.par_iter().map(shared).collect();
        // A section that cannot be planned is reported with its place when it is.
        planner.opening = planner.opening_columns().unwrap_or_default();
        planner
    }

    /// Layout of section `index`, the same for all policies; empty for one that does not cut rows.
    ///
    /// # Errors
    /// When the section's tool is missing.
    pub(super) fn shared_layouts(&self, index: usize) -> Result<&[StretchLayout<'a>], PlanError> {
        self.layouts[index].as_deref().map_err(PlanError::clone)
    }

    /// The workpiece that it plans for.
    pub fn workpiece(&self) -> &Workpiece {
        self.workpiece
    }

    /// Plans one channel by `policy`. When the monitor is stopped, the plan consists of what was found until
    /// then: all finished sections and the finished part of the current one, with contact and clearances.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled, or stopped before any position was found;
    /// [`PlanError::Setup`] when part and setup do not match.
    pub fn plan(&self, policy: AxisPolicy, monitor: &Monitor) -> Result<PlungePlan, PlanError> {
        self.plan_cached(policy, &mut SectionCache::default(), monitor)
    }

    /// As [`Self::plan`], reusing the sections in `known` that are still valid: the cache from earlier plans
    /// of the same part by the same policy. Finished sections are stored in it, even if planning is
    /// cancelled.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn plan_cached(
        &self,
        policy: AxisPolicy,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<PlungePlan, PlanError> {
        let plan = self.evaluate(self.place_plunges(policy, known, monitor)?, monitor)?;
        monitor.report(1.0);
        Ok(plan)
    }

    /// The first half of planning: positions, axes and depths.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn place_plunges(
        &self,
        policy: AxisPolicy,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<PlacedPlan, PlanError> {
        // Enters the rayon pool once; otherwise every small parallel task would cross threads.
        rayon::scope(|_| self.place_plunges_in_pool(policy, known, monitor))
    }

    /// [`Self::place_plunges`], running on a thread of the pool.
    fn place_plunges_in_pool(
        &self,
        policy: AxisPolicy,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<PlacedPlan, PlanError> {
        let mut cuts: Vec<Arc<SectionCut>> = Vec::new();
        known.invalidate(self.setup)?;
        let sections = &self.setup.plunge.sections;
        for (index, section) in sections.iter().enumerate() {
            self.report_section(index, 0.0, monitor);
            let tool = tool_of(self.setup, section.tool)?;
            let place = SetupPlace::Section { index, tool: tool.number };
            let make = |before: Option<&SectionCut>| {
                let columns = before.map(|cut| cut.columns.clone()).unwrap_or_default();
                self.plan_section(index, policy, columns, monitor).map_err(|error| match error {
                    PlanError::Setup(fault) if fault.place == SetupPlace::Whole => fault.at(place).into(),
                    other => other,
                })
            };
            let cut = match cuts.last().filter(|last| last.is_unfinished()) {
                Some(last) => Arc::new(SectionCut::not_started(section, last.columns.clone())),
                None => known.get_or_make(index, self.setup, make)?,
            };
            cuts.push(cut);
            let planned = cuts.iter().flat_map(|cut| &cut.rows).map(|row| row.placed.len()).sum();
            self.check_count(planned, tool, place)?;
        }
        known.store_complete(sections.len());
        let placed = self.assemble_plan(policy, cuts)?;
        monitor.report(0.85);
        Ok(placed)
    }

    /// Reports that a share (0…1) of the work on section `index` is done.
    pub(super) fn report_section(&self, index: usize, share: f64, monitor: &Monitor) {
        let done = (index as f64 + share) / self.setup.plunge.sections.len() as f64;
        monitor.report(0.1 + 0.7 * done);
    }

    /// Assembles the plan of these sections, with those plunges above the shroud that it needs.
    pub(super) fn assemble_plan(
        &self,
        policy: AxisPolicy,
        cuts: Vec<Arc<SectionCut>>,
    ) -> Result<PlacedPlan, PlanError> {
        let PlacedPlan { plan, columns } = self.assemble_all(policy, &cuts)?;
        let (plan, columns) = self.with_needed_opening(&plan, &columns).unwrap_or((plan, columns));
        Ok(PlacedPlan { plan, columns })
    }

    /// Assembles the plan of these sections with all their plunges.
    pub(super) fn assemble_all(
        &self,
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
        for (index, (section, cut)) in self.setup.plunge.sections.iter().zip(cuts).enumerate() {
            let tool = tool_of(self.setup, section.tool)?;
            let rule = self.assembly_rule(tool);
            plan.sections.push(SectionPlan {
                tool: tool.clone(),
                from: section.from,
                to: section.to,
                feed: cut.feed,
                rows: cut.rows.len(),
                kind: section.kind,
                added: cut.added,
            });
            for (row_index, CutRow { row, placed }) in cut.rows.iter().enumerate() {
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
                for (station, placed) in row.stations.iter().zip(placed) {
                    let placed = match placed {
                        Ok(placed) => placed,
                        Err(why) => {
                            let s = station.ends.s_hub;
                            let cause = match &rule {
                                Some(rule) => rule.cause(*why, (station.tip, station.axis)),
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

    /// The rule for shank and holder of `tool`; `None` where neither is given.
    pub(super) fn assembly_rule<'r>(&'r self, tool: &'r Tool) -> Option<AssemblyRule<'r>> {
        AssemblyRule::new(tool, &self.workpiece.finished, &self.workpiece.blank, self.setup)
            .map(|rule| rule.after(self.opening.all()))
    }

    pub(super) fn check_count(
        &self,
        positions: usize,
        tool: &Tool,
        place: SetupPlace,
    ) -> Result<(), PlanError> {
        if positions <= MAX_POSITIONS {
            return Ok(());
        }
        Err(too_many_positions(positions as f64, &self.setup.plunge, tool, place).into())
    }
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
