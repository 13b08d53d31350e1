//! Plans of `minimal` whose rows starve: where no core is free at some s, nothing behind it is either.

use super::{PlanOutcome, PolicyCache, PolicyResult, measure_residual};
use crate::monitor::Monitor;
use crate::plunge::sections::Resolved;
use crate::plunge::{DropReason, PlanError, Planner, SectionPlan, cutting_order};
use crate::setup::{AxisPolicy, CutDirection, SectionKind};
use crate::stock::{FloorGrid, ResidualField, statistics};
use crate::tradeoff::PlanClock;

/// Share of the floor that a plan may leave uncut without another cutting order being tried.
const STARVED_UNCUT: f64 = 0.05;
/// Share of that which another order has to leave at most.
const MUCH_LESS: f64 = 0.8;
/// What another direction is expected to leave where this one leaves less than the conventional plan, as a
/// multiple of that: what is known is kept.
const UNKNOWN: f64 = 1.05;

/// Whether the sections of `resolved` can be cut in another order than theirs.
pub(super) fn has_other_orders(resolved: &Resolved) -> bool {
    [0.5, 1.0, 0.0].into_iter().any(|s| cutting_order::from_both_ends(resolved, s).is_some())
}

/// The sections of `outcome` in another cutting order, where its plan of `minimal` starves and that leaves
/// much less uncut: from both ends of the channel up to where they leave least, or all from one end. The plan
/// is kept in `known`. Where that of `outcome` ended because it starves, what it did not reach counts as cut
/// by it.
///
/// # Errors
/// [`PlanError::Cancelled`] when `monitor` is cancelled, or stopped before all orders are compared.
pub(super) fn reordered(
    outcome: &PlanOutcome,
    known: &mut PolicyCache,
    monitor: &Monitor,
) -> Result<Option<Resolved>, PlanError> {
    let minimal = outcome.policies().into_iter().find(|result| result.plan.policy == AxisPolicy::Minimal);
    let Some(minimal) = minimal else { return Ok(None) };
    let lacks_contact = minimal.plan.dropped.iter().any(|dropped| dropped.why == DropReason::Contact);
    let uncut = uncut_where_planned(outcome, minimal);
    if !lacks_contact || uncut <= STARVED_UNCUT {
        return Ok(None);
    }
    monitor.check()?;
    let resolved = Resolved { setup: outcome.setup.clone(), reasons: outcome.reasons.clone() };
    for s in meeting_s(outcome, minimal).into_iter().chain([1.0, 0.0]) {
        let Some(turned) = cutting_order::from_both_ends(&resolved, s) else { continue };
        let mut planner = Planner::new(&outcome.workpiece, &turned.setup);
        if minimal.plan.is_unfinished() {
            planner = planner.ending_where_starved();
        }
        let known = known.policies.entry(AxisPolicy::Minimal).or_default();
        let plan = match planner.plan_cached(AxisPolicy::Minimal, known, &monitor.silent()) {
            Ok(plan) if !plan.is_unfinished() => plan,
            // It starves as well, unless a stop ended it.
            Ok(_) => {
                monitor.check()?;
                continue;
            }
            Err(PlanError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(PlanError::Setup(_)) => return Ok(None),
        };
        // Its time does not matter.
        let turned_uncut = measure_residual(plan, &outcome.grid, &PlanClock::default()).summary.uncut_share;
        if turned_uncut <= MUCH_LESS * uncut {
            return Ok(Some(turned));
        }
    }
    Ok(None)
}

/// Share of the floor that `result` leaves uncut; of one that ended because it starves, in the sections that
/// it planned.
fn uncut_where_planned(outcome: &PlanOutcome, result: &PolicyResult) -> f64 {
    if !result.plan.is_unfinished() {
        return result.summary.uncut_share;
    }
    let grid = &outcome.grid;
    let is_planned = |row: &usize| {
        let s = grid.s_of_row(*row);
        result.plan.sections.iter().any(|section| !section.is_unfinished() && has_rows_at(section, s))
    };
    let left = uncut_areas(grid, &result.field);
    let uncut: f64 = (0..grid.rows).filter(is_planned).map(|row| left[row]).sum();
    uncut / f64::from(statistics(grid, &result.field.heights, |_| true).area).max(f64::MIN_POSITIVE)
}

/// The s at which rows from the outlet and rows from the inlet should meet; `None` where that promises
/// little. What a plan leaves of the floor by rows in the same direction is known. In the other direction,
/// where they may not starve, it is expected to be what the conventional plan leaves, which ignores contact,
/// or as much as now.
fn meeting_s(outcome: &PlanOutcome, minimal: &PolicyResult) -> Option<f64> {
    let grid = &outcome.grid;
    let (here, free) = (uncut_areas(grid, &minimal.field), uncut_areas(grid, &outcome.before.field));
    // Whether rows in some direction, or in this one, were planned over a row of the floor.
    let is_planned = |row: usize, way: Option<CutDirection>| {
        let s = grid.s_of_row(row);
        let is_it = |section: &SectionPlan| {
            !section.is_unfinished() && has_rows_at(section, s) && way.is_none_or(|way| section.feed == way)
        };
        minimal.plan.sections.iter().any(is_it)
    };
    let left_by = |way: CutDirection, row: usize| match is_planned(row, Some(way)) {
        true => here[row],
        false => free[row].min(UNKNOWN * here[row]),
    };
    let left: Vec<[f64; 2]> = (0..grid.rows)
        .map(|row| [CutDirection::InletToOutlet, CutDirection::OutletToInlet].map(|way| left_by(way, row)))
        .collect();
    let now: f64 = (0..grid.rows).map(|row| if is_planned(row, None) { here[row] } else { free[row] }).sum();
    let (rows, least) = best_meeting(&left);
    (least <= MUCH_LESS * now).then_some(rows as f64 / grid.rows as f64)
}

/// Whether `section` cuts rows at `s`.
fn has_rows_at(section: &SectionPlan, s: f64) -> bool {
    section.kind == SectionKind::Rows && (section.to..=section.from).contains(&s)
}

/// How many of the rows of a floor, those at its inlet, should be cut from the inlet, the others from the
/// outlet, and what is left then, mm². `left` is what either direction leaves of each row, first from the
/// inlet.
fn best_meeting(left: &[[f64; 2]]) -> (usize, f64) {
    let mut sum: f64 = left.iter().map(|[_, from_outlet]| from_outlet).sum();
    let mut best = (0, sum);
    for (row, [from_inlet, from_outlet]) in left.iter().enumerate() {
        sum += from_inlet - from_outlet;
        if sum < best.1 {
            best = (row + 1, sum);
        }
    }
    best
}

/// Area of the accessible floor that is uncut, by rows of `grid`, mm².
fn uncut_areas(grid: &FloorGrid, field: &ResidualField) -> Vec<f64> {
    let of_row = |row: usize| {
        let left = statistics(grid, &field.heights, |other| other == row);
        f64::from(left.area) * f64::from(left.uncut_share)
    };
    (0..grid.rows).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_end_is_cut_by_the_rows_that_reach_it() {
        // Rows from the outlet reach the last two rows of the floor, those from the inlet the first three.
        let left = [[0.1, 4.0], [0.1, 4.0], [0.2, 4.0], [5.0, 0.5], [5.0, 0.5]];
        let (rows, least) = best_meeting(&left);
        assert_eq!(rows, 3);
        assert!((least - 1.4).abs() < 1e-12, "{least}");
    }

    #[test]
    fn floor_that_either_end_leaves_alike_is_cut_from_the_outlet() {
        assert_eq!(best_meeting(&[[1.0, 1.0], [1.0, 1.0]]), (0, 2.0));
        assert_eq!(best_meeting(&[[0.0, 3.0], [1.0, 2.0]]).0, 2, "all from the inlet");
    }
}
