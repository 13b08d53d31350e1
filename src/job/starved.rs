//! Plans of `minimal` whose rows starve: where no core is free at the outlet, nothing behind it is either.

use super::{PlanOutcome, PolicyCache, measure_residual};
use crate::monitor::Monitor;
use crate::plunge::sections::Resolved;
use crate::plunge::{DropReason, PlanError, Planner, cutting_order};
use crate::setup::AxisPolicy;
use crate::tradeoff::PlanClock;

/// Share of the floor that a plan may leave uncut without another cutting order being tried.
const STARVED_UNCUT: f64 = 0.05;
/// Share of that which another order has to leave at most.
const MUCH_LESS: f64 = 0.8;

/// The sections of `outcome` all cut from the inlet, where its plan of `minimal` starves and that leaves much
/// less uncut. The plan is kept in `known`.
///
/// # Errors
/// [`PlanError::Cancelled`] when `monitor` is cancelled.
pub(super) fn from_inlet(
    outcome: &PlanOutcome,
    known: &mut PolicyCache,
    monitor: &Monitor,
) -> Result<Option<Resolved>, PlanError> {
    let minimal = outcome.policies().into_iter().find(|result| result.plan.policy == AxisPolicy::Minimal);
    let Some(minimal) = minimal.filter(|minimal| !minimal.plan.is_unfinished()) else { return Ok(None) };
    let lacks_contact = minimal.plan.dropped.iter().any(|dropped| dropped.why == DropReason::Contact);
    let uncut = minimal.summary.uncut_share;
    if !lacks_contact || uncut <= STARVED_UNCUT {
        return Ok(None);
    }
    let resolved = Resolved { setup: outcome.setup.clone(), reasons: outcome.reasons.clone() };
    let Some(turned) = cutting_order::all_from_inlet(&resolved) else { return Ok(None) };
    let planner = Planner::new(&outcome.workpiece, &turned.setup);
    let known = known.policies.entry(AxisPolicy::Minimal).or_default();
    let plan = match planner.plan_cached(AxisPolicy::Minimal, known, &monitor.silent()) {
        Ok(plan) if !plan.is_unfinished() => plan,
        Err(PlanError::Cancelled(cancelled)) if !monitor.is_stopped() => return Err(cancelled.into()),
        _ => return Ok(None),
    };
    // Its time does not matter.
    let turned_uncut = measure_residual(plan, &outcome.grid, &PlanClock::default()).summary.uncut_share;
    let is_better = turned_uncut <= MUCH_LESS * uncut;
    Ok(is_better.then_some(turned))
}
