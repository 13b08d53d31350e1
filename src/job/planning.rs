//! The way from a request without edits to its plans: sections, stages, residual stock, goal.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::cache::{PlanCache, PolicyCache};
use super::goal::{self, MetGoal, WholeInput};
use super::machine::{clock_of, machine_of};
use super::nothing_cut::nothing_cut;
use super::outcome::{JobError, PlanOutcome, PlanRequest, PolicyResult, measure_residual};
use super::stage::{Listener, PlanStage};
use super::starved;
use crate::io::tool_library::plunge_cutters;
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::plunge::sections::{self, Resolved};
use crate::plunge::{EditReport, PlanError, Planner, PlungePlan, RowDensity, SectionCache, cutting_order};
use crate::setup::{AxisPolicy, Goal, Setup, SetupFault};
use crate::stock::{FloorGrid, FloorSource, InaccessibleFloor, stretches_of_setup};
use crate::tradeoff::PlanClock;

/// Share of the progress of planning `minimal` before its goal is met by plans with fewer plunges.
pub(super) const FIRST_SHARE: f64 = 0.6;

/// Completes the setup: missing tools and sections are chosen from the program's tool library, by their times
/// on the machine of the setup if it names one.
///
/// # Errors
/// [`SetupFault`] when part and setup are incompatible, or the machine file is not valid.
pub fn resolve(setup: &Setup, workpiece: &Workpiece) -> Result<Resolved, SetupFault> {
    let machine = machine_of(setup)?;
    let resolved = sections::resolve(setup, plunge_cutters(), workpiece, machine.as_ref())?;
    Ok(cutting_order::arrange(workpiece, resolved))
}

/// A plan on its way through the job.
enum JudgedPlan {
    /// Its residual stock is computed.
    Measured(Box<PolicyResult>),
    /// It was ready before the floor grid; its residual stock is computed at the end.
    Evaluated(PlungePlan),
}

/// Plans a request without edits, with the cache `known`.
pub(super) fn plan(
    request: &PlanRequest,
    known: &mut PlanCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlanOutcome, JobError> {
    let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(&request.part)));
    let resolved = resolve(&request.setup, &workpiece)?;
    // What starves is a search of `minimal`; plans of other policies stay as they are.
    let is_search = request.policy == AxisPolicy::Minimal;
    let may_turn = is_search && starved::has_other_orders(&resolved);
    let on_starving = if may_turn { OnStarving::End } else { OnStarving::GoOn };
    let plan_in = |resolved: Resolved, on_starving, known: &mut PolicyCache, monitor: &Monitor, listener| {
        plan_sections(request, &workpiece, (resolved, on_starving), known, monitor, listener)
    };
    let mut outcome = plan_in(resolved.clone(), on_starving, &mut known.plans, monitor, listener)?;
    if !is_search {
        return Ok(outcome);
    }
    let reordered = |outcome: &mut PlanOutcome, known: &mut PolicyCache| {
        let turned = starved::reordered(outcome, known, monitor);
        if monitor.is_stopped() && matches!(turned, Err(PlanError::Cancelled(_))) {
            outcome.after.plan.mark_unfinished();
            return Ok(None);
        }
        turned
    };
    let mut turned = reordered(&mut outcome, &mut known.reordered)?;
    if turned.is_none() && outcome.after.plan.is_unfinished() && !monitor.is_stopped() {
        // By what is planned so far no other order is better: the one that starves is planned to its end, and
        // all of it is compared.
        outcome = plan_in(resolved, OnStarving::GoOn, &mut known.plans, monitor, Listener::default())?;
        turned = reordered(&mut outcome, &mut known.reordered)?;
    }
    let Some(turned) = turned else { return Ok(outcome) };
    // Its sections are known; a stop leaves the rest to be finished.
    let closing = &monitor.ignoring_stop().silent();
    match plan_in(turned, OnStarving::GoOn, &mut known.reordered, closing, Listener::default()) {
        Err(JobError::Cancelled) => Err(JobError::Cancelled),
        turned => Ok(turned.unwrap_or(outcome)),
    }
}

/// Plans by `policy`, and reports the stages of the plan.
pub(super) fn plan_in_stages(
    planner: &Planner,
    policy: AxisPolicy,
    known: &mut SectionCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlungePlan, PlanError> {
    let placed = planner.place_plunges(policy, known, monitor)?;
    listener.notify(|| PlanStage::Placed(placed.plan().clone()));
    let plan = planner.evaluate(placed, monitor)?;
    listener.notify(|| PlanStage::Evaluated(plan.clone()));
    Ok(plan)
}

/// Reports a preview of `minimal` by warm start where sections of `known` became stale: the axes of the last
/// plan, fitted to the new setup, are close to the result and give live feedback while a slider is dragged.
/// Failures are reported by the plan itself.
fn preview(
    planner: &Planner,
    setup: &Setup,
    known: &SectionCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<(), SetupFault> {
    if known.valid_prefix(setup)? < setup.plunge.sections.len()
        && let Ok(Some(plan)) = planner.warm_start(AxisPolicy::Minimal, known, monitor)
    {
        listener.notify(|| PlanStage::Preview(plan));
    }
    Ok(())
}

/// The clock by which all plans are compared: `clock`, or where the machine refuses the plan of `policy` one
/// without it. Times on the machine are then removed from all.
fn one_clock_of(
    policy: AxisPolicy,
    before: &mut PolicyResult,
    others: &mut [PolicyResult],
    clock: Arc<PlanClock>,
) -> Arc<PlanClock> {
    let asked = others.iter().find(|result| result.plan.policy == policy).unwrap_or(before);
    if clock.machine().is_none() || asked.summary.machine_time.is_some() {
        return clock;
    }
    for result in others.iter_mut().chain([before]) {
        (result.summary.machine_time, result.summary.is_refused) = (None, false);
    }
    Arc::new(clock.after_refusal())
}

/// What `minimal` does after a section whose rows starve.
#[derive(Clone, Copy, Debug)]
enum OnStarving {
    /// It plans the others.
    GoOn,
    /// It ends, see [`Planner::ending_where_starved`].
    End,
}

/// Plans the sections of `resolved`.
fn plan_sections(
    request: &PlanRequest,
    workpiece: &Arc<Workpiece>,
    (Resolved { setup, reasons }, on_starving): (Resolved, OnStarving),
    known: &mut PolicyCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlanOutcome, JobError> {
    let started = std::time::Instant::now();
    // A goal that asks for less time than the least stock takes has `minimal` plan twice.
    let may_plan_twice = request.policy == AxisPolicy::Minimal && setup.plunge.goal != Goal::default();
    let first_share = if may_plan_twice { FIRST_SHARE } else { 1.0 };
    let (monitor, for_goal) = (&monitor.span(0.0, first_share), &monitor.span(first_share, 1.0));
    listener.notify(|| PlanStage::Resolved {
        workpiece: Arc::clone(workpiece),
        setup: setup.clone(),
        reasons: reasons.clone(),
    });
    let planner = match on_starving {
        OnStarving::GoOn => Planner::new(workpiece, &setup),
        OnStarving::End => Planner::new(workpiece, &setup).ending_where_starved(),
    };
    let clock = Arc::new(PlanClock::new(clock_of(&setup, workpiece)?));
    // The conventional plan and the grid are needed for every result, so they are completed even after a
    // stop.
    let closing = &monitor.ignoring_stop();
    let judged = |policy, known: &mut SectionCache, monitor: &Monitor| {
        plan_in_stages(&planner, policy, known, monitor, listener)
    };
    let measured = |plan: PlungePlan, grid: &Arc<FloorGrid>| -> Result<PolicyResult, PlanError> {
        closing.check()?;
        let result = measure_residual(plan, grid, &clock);
        listener.notify(|| PlanStage::Measured(Arc::clone(grid), result.clone()));
        Ok(result)
    };
    let searched = known.policies.entry(request.policy).or_default();
    if listener.has_callback() && request.policy == AxisPolicy::Minimal {
        preview(&planner, &setup, searched, closing, listener)?;
    }
    // Then the conventional plan alone on all cores, as it is ready first.
    let known_conventional = known.policies.entry(AxisPolicy::Conventional).or_default();
    let before = judged(AxisPolicy::Conventional, known_conventional, &closing.silent())?;
    // The other policies take most of the time.
    monitor.report(0.1);
    let ready = OnceLock::new();
    let conventional = || -> Result<(PolicyResult, Arc<FloorGrid>, Vec<InaccessibleFloor>), PlanError> {
        let cutters = stretches_of_setup(&setup);
        let source = FloorSource::of_setup(workpiece, &setup, &cutters);
        let (grid, inaccessible_floor) = FloorGrid::with_causes(&source, request.field_cells);
        let grid = Arc::new(grid);
        let result = measured(before, &grid)?;
        // Cannot fail: this is the only place that sets it.
        let _ = ready.set(Arc::clone(&grid));
        Ok((result, grid, inaccessible_floor))
    };
    let wanted = |policy: &&AxisPolicy| {
        **policy != AxisPolicy::Conventional && (request.compare || **policy == request.policy)
    };
    let mut policies: Vec<(AxisPolicy, SectionCache)> = AxisPolicy::ALL
        .iter()
        .filter(wanted)
        .map(|&policy| (policy, known.policies.remove(&policy).unwrap_or_default()))
        .collect();
    let asked = || -> Result<Vec<JudgedPlan>, PlanError> {
        let asked = policies.par_iter_mut().map(|(policy, known)| {
            let plan = match *policy == request.policy {
                true => judged(*policy, known, monitor),
                false => judged(*policy, known, &monitor.silent()),
            };
            let cancelled = matches!(plan, Err(PlanError::Cancelled(_)));
            if *policy == request.policy {
                if cancelled {
                    // Without the requested plan the others are useless.
                    monitor.cancel();
                }
            } else if cancelled && monitor.is_stopped() || plan.as_ref().is_ok_and(PlungePlan::is_unfinished)
            {
                return Ok(None);
            }
            let plan = plan?;
            Ok(Some(match ready.get() {
                Some(grid) => JudgedPlan::Measured(Box::new(measured(plan, grid)?)),
                None => JudgedPlan::Evaluated(plan),
            }))
        });
        asked.filter_map(Result::transpose).collect()
    };
    let (before, asked) = rayon::join(conventional, asked);
    known.policies.extend(policies);
    let ((mut before, grid, inaccessible_floor), asked) = (before?, asked?);
    let mut others = asked
        .into_iter()
        .map(|judged| match judged {
            JudgedPlan::Measured(result) => Ok(*result),
            JudgedPlan::Evaluated(plan) => measured(plan, &grid),
        })
        .collect::<Result<Vec<PolicyResult>, _>>()?;
    let clock = one_clock_of(request.policy, &mut before, &mut others, clock);
    // The search of `minimal` adds plunges as long as they remove anything; the goal says which are worth it.
    let (mut whole, mut density, mut met) = (None, RowDensity::Dense, MetGoal::default());
    if let Some(minimal) = others.iter_mut().find(|result| result.plan.policy == AxisPolicy::Minimal) {
        let (plan, clock) = (&minimal.plan, &clock);
        let input = WholeInput { workpiece, setup: &setup, plan, grid: &grid, locks: &[], clock };
        met = goal::meet_goal(input, &mut known.sparse, for_goal)?;
        if let Some((plan, rows)) = met.replace_whole(minimal, &grid, clock) {
            (whole, density) = (Some(plan), rows);
        }
        if met.is_stopped {
            minimal.plan.mark_unfinished();
        }
    }
    let after = match others.iter().position(|result| result.plan.policy == request.policy) {
        Some(index) => others.remove(index),
        None => before.clone(),
    };
    if after.plan.positions.is_empty() {
        return Err(JobError::Setup(nothing_cut(&after.plan, &setup, &workpiece.part)));
    }
    let elapsed = started.elapsed().as_secs_f64();
    Ok(PlanOutcome {
        workpiece: Arc::clone(workpiece),
        setup,
        reasons,
        grid,
        inaccessible_floor,
        before,
        after,
        whole,
        sparse: met.sparse,
        density,
        misses_goal: met.misses_goal,
        others,
        edits: EditReport::default(),
        kept_locked: Vec::new(),
        clock,
        elapsed,
    })
}
