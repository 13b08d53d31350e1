//! Plans with the edits of the setup: the plan is found without them, which is kept for the next edit, and
//! the edits apply to it. Where they lock plunges that the planner does not place by itself, the requested
//! plan is made once more around these, and the edits apply to that one.

use super::cache::PlanCache;
use super::goal::{self, WholeInput};
use super::outcome::{JobError, PlanOutcome, PlanRequest, measure_residual};
use super::planning::{FIRST_SHARE, plan, plan_in_stages};
use super::stage::Listener;
use crate::error::ErrorCode;
use crate::monitor::Monitor;
use crate::plunge::{PlanError, Planner, SectionCache};
use crate::setup::{AxisPolicy, PlungeChange, PlungeEdit, Setup, SetupFault, SetupPlace};

/// Plans one channel with the edits of the setup and the cache `known`, reporting every stage to `listener`.
pub(super) fn plan_with_edits(
    request: &PlanRequest,
    known: &mut PlanCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlanOutcome, JobError> {
    let started = std::time::Instant::now();
    let mut unedited = request.clone();
    let edits = std::mem::take(&mut unedited.setup.plunge.edits);
    let locks: Vec<PlungeEdit> =
        edits.iter().filter(|edit| matches!(edit.change, PlungeChange::Lock { .. })).copied().collect();
    // Locked plunges may have the plan made twice.
    let share = if locks.is_empty() { 1.0 } else { 0.5 };
    let found = match known.unedited(&unedited) {
        Some(outcome) => outcome,
        None => {
            let outcome = plan(&unedited, known, &monitor.span(0.0, share), listener)?;
            let is_finished = !outcome.after.plan.is_unfinished() && !monitor.is_stopped();
            known.around = None;
            known.unedited = is_finished.then(|| (unedited, outcome.clone()));
            outcome
        }
    };
    let edited = |mut outcome: PlanOutcome| -> Result<PlanOutcome, JobError> {
        outcome.setup.flank = request.setup.flank.clone();
        outcome.setup.channels = request.setup.channels;
        if !edits.is_empty() {
            outcome.setup.plunge.edits.clone_from(&edits);
            outcome.apply_edits(monitor)?;
        }
        Ok(outcome)
    };
    let mut outcome = edited(found.clone())?;
    if outcome.edits.adds_locked
        && let Some(around) = known.around(&found, locks, &monitor.span(share, 1.0), listener)?
    {
        outcome = edited(around)?;
    }
    outcome.time_wheel(&monitor.ignoring_stop().silent()).map_err(|_| JobError::Cancelled)?;
    outcome.elapsed = started.elapsed().as_secs_f64();
    monitor.report(1.0);
    Ok(outcome)
}

impl PlanCache {
    /// The first `count` sections of the last plan of `policy` with this setup, as far as they are known.
    fn leading_sections(&self, setup: &Setup, policy: AxisPolicy, count: usize) -> SectionCache {
        let caches =
            [&self.plans, &self.reordered].into_iter().filter_map(|known| known.policies.get(&policy));
        let valid = |known: &&SectionCache| known.valid_prefix(setup).unwrap_or(0);
        caches.max_by_key(valid).map(|known| known.leading(count)).unwrap_or_default()
    }

    /// The plan `found` made again around the plunges that `locks` keep; `None` where it is not finished.
    fn around(
        &mut self,
        found: &PlanOutcome,
        locks: Vec<PlungeEdit>,
        monitor: &Monitor,
        listener: Listener,
    ) -> Result<Option<PlanOutcome>, JobError> {
        if found.after.plan.is_unfinished() || monitor.is_stopped() {
            return Ok(None);
        }
        if let Some((known, outcome)) = &self.around
            && *known == locks
        {
            return Ok(Some(outcome.clone()));
        }
        let outcome = {
            let policy = found.after.plan.policy;
            let sections = |count| self.leading_sections(&found.setup, policy, count);
            found.planned_around(&locks, sections, monitor, listener)?
        };
        if let Some(outcome) = &outcome {
            self.around = Some((locks, outcome.clone()));
        }
        Ok(outcome)
    }
}

impl PlanOutcome {
    /// The outcome with the requested plan made again around the plunges that `locks` keep; `None` after a
    /// stop. `sections` gives leading sections of the plan without them, by their number: those before the
    /// first that has a locked plunge are the same. Its stages are reported: they replace those of the plan
    /// without them.
    fn planned_around(
        &self,
        locks: &[PlungeEdit],
        sections: impl FnOnce(usize) -> SectionCache,
        monitor: &Monitor,
        listener: Listener,
    ) -> Result<Option<Self>, JobError> {
        let (workpiece, setup) = (&*self.workpiece, &self.setup);
        let policy = self.after.plan.policy;
        let planner = Planner::new(workpiece, setup).keeping_locked(locks);
        let planning = &monitor.span(0.0, FIRST_SHARE);
        let mut known = sections(planner.sections_before_locked());
        let planned = plan_in_stages(&planner, policy, &mut known, planning, listener);
        if planned.is_ok() {
            planning.report(1.0);
        }
        let plan = match planned {
            Ok(plan) if !plan.is_unfinished() => plan,
            Err(PlanError::Cancelled(_)) if !monitor.is_stopped() => return Err(JobError::Cancelled),
            Err(PlanError::Setup(fault)) => return Err(fault.into()),
            _ => return Ok(None),
        };
        let mut outcome = Self { kept_locked: locks.to_vec(), whole: None, sparse: None, ..self.clone() };
        outcome.after = measure_residual(plan, &self.grid, &self.clock);
        if policy == AxisPolicy::Minimal {
            let (plan, grid, clock) = (&outcome.after.plan, &self.grid, &self.clock);
            let input = WholeInput { workpiece, setup, plan, grid, locks, clock };
            let for_goal = &monitor.span(FIRST_SHARE, 1.0);
            let mut met = goal::meet_goal(input, &mut SectionCache::default(), for_goal)?;
            if met.is_stopped {
                return Ok(None);
            }
            if let Some((whole, density)) = met.replace_whole(&mut outcome.after, grid, clock) {
                (outcome.whole, outcome.density) = (Some(whole), density);
            }
            (outcome.sparse, outcome.misses_goal) = (met.sparse, met.misses_goal);
        }
        Ok(Some(outcome))
    }

    /// Applies the edits of the setup to the requested plan.
    fn apply_edits(&mut self, monitor: &Monitor) -> Result<(), JobError> {
        let edits = &self.setup.plunge.edits;
        let planner = Planner::new(&self.workpiece, &self.setup);
        let (plan, report) = planner.edit_plunges(&self.after.plan, edits, monitor)?;
        if plan.positions.is_empty() {
            let what = "the edits delete every plunge of the plan";
            let fault = SetupFault::new(ErrorCode::NothingMoves, what, "remove some of the edits");
            return Err(fault.at(SetupPlace::Plunge("edit")).into());
        }
        let edited = measure_residual(plan, &self.grid, &self.clock);
        let found = std::mem::replace(&mut self.after, edited).plan;
        if found.policy == AxisPolicy::Minimal && self.whole.is_none() {
            self.whole = Some(found);
        }
        self.edits = report;
        Ok(())
    }
}
