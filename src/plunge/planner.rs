//! The planner as others use it: one context, and the steps of planning over it.

use super::context::PlanContext;
use super::cycle::place_plunges;
use super::edit_report::EditReport;
use super::edits::edit_plan;
use super::error::PlanError;
use super::evaluation::evaluate;
use super::locked::locked_plunges;
use super::needed_opening::opening_for;
use super::opening_section::plan_context;
use super::plan::PlungePlan;
use super::row_density::RowDensity;
use super::section_cache::SectionCache;
use super::subset::keep_plunges;
use super::warm_start::warm_start;
use super::whole_plan::PlacedPlan;
use crate::cutting::contact::Columns;
use crate::geometry::{Point, Vector};
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::setup::{AxisPolicy, PlungeEdit, Setup, Tool};

/// Planner for one part and one setup.
#[derive(Debug)]
pub struct Planner<'a> {
    context: PlanContext<'a>,
}

impl<'a> Planner<'a> {
    /// Planner for `workpiece` with a `setup` completed by [`super::sections::resolve`].
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        Self::with_rows(workpiece, setup, RowDensity::Dense)
    }

    /// As [`Self::new`]; `minimal` places its rows with this `density`.
    pub fn with_rows(workpiece: &'a Workpiece, setup: &'a Setup, density: RowDensity) -> Self {
        Self { context: plan_context(workpiece, setup, density) }
    }

    /// The same, with those plunges in every plan that `edits` lock: the others are planned around them.
    /// Caches of sections are then those of plans with the same locks.
    #[must_use]
    pub fn keeping_locked(mut self, edits: &[PlungeEdit]) -> Self {
        self.context.locked = locked_plunges(&self.context, edits);
        self
    }

    /// The same, but a plan of `minimal` ends after a section whose rows starve, see
    /// [`SectionPlan::is_unfinished`] of the later ones: another cutting order may cut that section, and then
    /// they are planned in vain.
    ///
    /// [`SectionPlan::is_unfinished`]: super::SectionPlan::is_unfinished
    #[must_use]
    pub fn ending_where_starved(mut self) -> Self {
        self.context.ends_where_starved = true;
        self
    }

    /// Number of sections that are cut before the first one with a locked plunge.
    pub fn sections_before_locked(&self) -> usize {
        let locked = &self.context.locked;
        locked.iter().position(|plunges| !plunges.is_empty()).unwrap_or(locked.len())
    }

    /// The workpiece that it plans for.
    pub fn workpiece(&self) -> &Workpiece {
        self.context.workpiece
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
        place_plunges(&self.context, policy, known, monitor)
    }

    /// The second half of planning: contact of the cores, retract points and links. A stopped monitor is
    /// ignored here, so that partial plans are measured too.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled.
    pub fn evaluate(&self, placed: PlacedPlan, monitor: &Monitor) -> Result<PlungePlan, PlanError> {
        evaluate(&self.context, placed, monitor)
    }

    /// Plan with the axes of the last finished plan by `policy` in the cache `known`, fitted to this setup.
    /// `None` when there is none, or its sections had other cutters.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn warm_start(
        &self,
        policy: AxisPolicy,
        known: &SectionCache,
        monitor: &Monitor,
    ) -> Result<Option<PlungePlan>, PlanError> {
        warm_start(&self.context, policy, known, monitor)
    }

    /// `plan` with only the plunges that are `kept`, one flag each, whose `columns` are given: contact,
    /// retracts and links are those of what is left, and a row is split where the axes of the plunges
    /// left in it differ by more than the setup allows. What the sections say of added plunges stays that of
    /// the search.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled.
    pub fn keep_plunges(
        &self,
        plan: &PlungePlan,
        kept: &[bool],
        columns: &Columns,
        monitor: &Monitor,
    ) -> Result<PlungePlan, PlanError> {
        keep_plunges(&self.context, plan, kept, columns, monitor)
    }

    /// `plan` with `edits` applied one after the other, evaluated anew, and what they did. A stopped monitor
    /// is ignored, as by [`Self::evaluate`].
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled; [`PlanError::Setup`] when locks make too many
    /// positions.
    pub fn edit_plunges(
        &self,
        plan: &PlungePlan,
        edits: &[PlungeEdit],
        monitor: &Monitor,
    ) -> Result<(PlungePlan, EditReport), PlanError> {
        edit_plan(&self.context, plan, edits, monitor)
    }

    /// The plunges above the shroud that `tool` comes near at one of `poses`, tips with unit axes.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn opening_for(
        &self,
        tool: &Tool,
        poses: impl Iterator<Item = (Point, Vector)>,
        monitor: &Monitor,
    ) -> Result<PlungePlan, PlanError> {
        opening_for(&self.context, tool, poses, monitor)
    }
}
