//! Plans by what the setup asks for: least stock, least time, the balance of both, or the least time with
//! semi-finishing; and the curve between.

use std::sync::Arc;

use super::outcome::{PlanOutcome, PolicyResult, measure_residual};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::plunge::{PlanError, Planner, PlungePlan, RowDensity, SectionCache};
use crate::setup::{AxisPolicy, Goal, PlungeEdit, PlungePose, Setup};
use crate::stock::FloorGrid;
use crate::tradeoff::{PlanClock, Thinning, ThinningInput, ThinningLimits, Tradeoff, TradeoffPoint};

/// Cells along each side of the floor on which plunges are weighed; the grid of the figures is finer.
const CELLS: usize = 256;
/// Share of the work on a curve that is planning with fewer rows.
const SPARSE_SHARE: f64 = 0.7;
/// Plans made at most for a limit of time after the first one.
const MAX_ROUNDS: usize = 4;

/// What a goal is met from: the whole plan of `minimal`, and the floor of its channel.
#[derive(Clone, Copy)]
pub(super) struct WholeInput<'a> {
    pub workpiece: &'a Workpiece,
    pub setup: &'a Setup,
    pub plan: &'a PlungePlan,
    pub grid: &'a FloorGrid,
    /// Edits whose locked plunges the plan was made around; none of them is left out.
    pub locks: &'a [PlungeEdit],
    pub clock: &'a PlanClock,
}

/// The plan that a goal asks for.
#[derive(Debug, Default)]
pub(super) struct MetGoal {
    /// The plan, and how closely its rows lie; `None` where it is the whole plan.
    pub plan: Option<(PlungePlan, RowDensity)>,
    /// The plan with fewer rows, if it was made.
    pub sparse: Option<Arc<PlungePlan>>,
    /// Whether no plan meets the goal; this one comes nearest.
    pub misses_goal: bool,
    /// Whether a stop came before all plans were weighed: another one may meet the goal better.
    pub is_stopped: bool,
}

impl MetGoal {
    /// Puts the plan, where it is not the whole one, with its residual stock into `minimal`. Returns then the
    /// whole plan, and how closely the rows of the new one lie.
    pub fn replace_whole(
        &mut self,
        minimal: &mut PolicyResult,
        grid: &FloorGrid,
        clock: &PlanClock,
    ) -> Option<(PlungePlan, RowDensity)> {
        let (plan, density) = self.plan.take()?;
        let chosen = measure_residual(plan, grid, clock);
        Some((std::mem::replace(minimal, chosen).plan, density))
    }
}

/// The whole plan of `minimal`, with what it was planned for, and the floor on which its plunges are weighed.
struct WholePlan<'a> {
    workpiece: &'a Workpiece,
    setup: &'a Setup,
    plan: &'a PlungePlan,
    grid: &'a FloorGrid,
    locks: &'a [PlungeEdit],
    /// The plunges of `locks`.
    locked: Vec<PlungePose>,
    clock: &'a PlanClock,
}

impl<'a> WholePlan<'a> {
    /// The plan of `input`, weighed on `grid`.
    fn new(input: WholeInput<'a>, grid: &'a FloorGrid) -> Self {
        let WholeInput { workpiece, setup, plan, locks, clock, .. } = input;
        let locked = locks.iter().map(|edit| edit.plunge).collect();
        Self { workpiece, setup, plan, grid, locks, locked, clock }
    }

    /// The order in which the plunges of `plan`, of the same channel, go within `limits`.
    fn thinning(
        &'a self,
        plan: &'a PlungePlan,
        limits: ThinningLimits,
        monitor: &Monitor,
    ) -> Result<Thinning<'a>, Cancelled> {
        let Self { workpiece, setup, grid, locked, clock, .. } = self;
        let blank = &workpiece.blank;
        Thinning::new(ThinningInput { plan, setup, blank, grid, limits, locked, clock }, monitor)
    }

    /// The plan of `minimal` with fewer rows, for less time than thinning reaches; `None` where it is not
    /// finished. Finished sections are kept in `known`.
    fn sparse_plan(
        &self,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<Option<PlungePlan>, Cancelled> {
        let planner = Planner::with_rows(self.workpiece, self.setup, RowDensity::Sparse);
        let planner = planner.keeping_locked(self.locks);
        match planner.plan_cached(AxisPolicy::Minimal, known, monitor) {
            Ok(plan) if !plan.is_unfinished() && !plan.positions.is_empty() => Ok(Some(plan)),
            Err(PlanError::Cancelled(cancelled)) if !monitor.is_stopped() => Err(cancelled),
            _ => Ok(None),
        }
    }

    /// The curve of time against stock from the order `first` of the whole plan on, with that of the `sparse`
    /// one.
    fn tradeoff(
        &'a self,
        first: Thinning<'a>,
        sparse: Option<&'a PlungePlan>,
        monitor: &Monitor,
    ) -> Result<Tradeoff<'a>, Cancelled> {
        // The bound is that of the whole plan: what the sparse one leaves does not add to it.
        let limits = ThinningLimits {
            max_uncut_share: first.max_uncut_share(),
            max_more_uncut: 0.0,
            ..ThinningLimits::LEAST_TIME
        };
        let tradeoff = Tradeoff::new(first);
        Ok(match sparse {
            Some(sparse) => tradeoff.and(self.thinning(sparse, limits, monitor)?),
            None => tradeoff,
        })
    }

    /// The plan at a point of `tradeoff`.
    fn plan_at(
        &self,
        tradeoff: &Tradeoff,
        point: TradeoffPoint,
        monitor: &Monitor,
    ) -> Result<PlungePlan, PlanError> {
        let planner = Planner::new(self.workpiece, self.setup);
        let thinning = tradeoff.thinning(point.plan);
        let kept = thinning.kept_without(point.left_out);
        planner.keep_plunges(thinning.plan(), &kept, &thinning.columns_of(&kept), monitor)
    }
}

/// The density of the rows of plan `number` of a [`Tradeoff`].
fn density_of(number: usize) -> RowDensity {
    if number == 0 { RowDensity::Dense } else { RowDensity::Sparse }
}

/// The plan that the goal of the setup asks for. An unfinished plan stays as it is, and so does one after
/// whose planning a stop came. `known` keeps the sections of the plan with fewer rows.
///
/// A stop ends the planning of fewer rows; the goal is then met from the whole plan alone.
///
/// # Errors
/// [`PlanError::Cancelled`] when `monitor` is cancelled.
pub(super) fn meet_goal(
    input: WholeInput,
    known: &mut SectionCache,
    monitor: &Monitor,
) -> Result<MetGoal, PlanError> {
    if input.plan.is_unfinished() || monitor.is_stopped() {
        return Ok(MetGoal { is_stopped: true, ..MetGoal::default() });
    }
    let goal = input.setup.plunge.goal;
    let closing = &monitor.ignoring_stop();
    let grid = weighing_grid(input.grid);
    let whole = WholePlan::new(input, &grid);
    let first = whole.thinning(whole.plan, ThinningLimits::from_goal(goal), closing)?;
    let takes_whole = first.is_least_stock_enough(goal);
    let sparse = match takes_whole {
        true => None,
        false => whole.sparse_plan(known, monitor)?.map(Arc::new),
    };
    let lacks_sparse = !takes_whole && sparse.is_none() && monitor.is_stopped();
    let tradeoff = whole.tradeoff(first, sparse.as_deref(), closing)?;
    let is_stopped = lacks_sparse || tradeoff.is_cut_short();
    let point = tradeoff.choose(goal);
    let mut misses_goal = !tradeoff.reaches(goal);
    if (point.plan, point.left_out) == (0, 0) {
        drop(tradeoff);
        return Ok(MetGoal { plan: None, sparse, misses_goal, is_stopped });
    }
    let (mut plan, mut made_at) = (whole.plan_at(&tradeoff, point, closing)?, point);
    // Links are raised where plunges beside them are gone, which takes time that the curve does not know.
    if let Goal::Stock { max_time_min: Some(limit) } = goal {
        let mut minutes = minutes_of(&plan, input.clock);
        for _ in 0..MAX_ROUNDS {
            if minutes <= limit {
                break;
            }
            let aim = made_at.time_s / 60.0 * limit / minutes;
            let point = tradeoff.choose(Goal::Stock { max_time_min: Some(aim) });
            if point == made_at {
                break;
            }
            (plan, made_at) = (whole.plan_at(&tradeoff, point, closing)?, point);
            minutes = minutes_of(&plan, input.clock);
        }
        misses_goal = minutes > limit;
    }
    drop(tradeoff);
    let plan = Some((plan, density_of(made_at.plan)));
    Ok(MetGoal { plan, sparse, misses_goal, is_stopped })
}

/// Time of a plan, min.
fn minutes_of(plan: &PlungePlan, clock: &PlanClock) -> f64 {
    clock.time_s(plan) / 60.0
}

/// The cells of `grid` on which plunges are weighed.
fn weighing_grid(grid: &FloorGrid) -> FloorGrid {
    grid.every(grid.rows.max(grid.columns).div_ceil(CELLS))
}

impl PlanOutcome {
    /// At most `count` plans from the one with the least stock of this outcome to the fastest that still cuts
    /// the floor, by falling time; one plan where it has no choice.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when `monitor` is cancelled.
    pub fn time_stock_curve(&self, count: usize, monitor: &Monitor) -> Result<Vec<PolicyResult>, PlanError> {
        let clock = &self.clock;
        self.with_tradeoff(monitor, |whole, tradeoff| {
            let made = tradeoff.points(count).into_iter().map(|point| {
                Ok(measure_residual(whole.plan_at(tradeoff, point, monitor)?, &self.grid, clock))
            });
            made.collect()
        })?
    }

    /// The points of [`Self::time_stock_curve`] without their plans. The channel with fewer rows is planned
    /// for them all the same.
    ///
    /// # Errors
    /// [`Cancelled`] when `monitor` is cancelled.
    pub fn time_stock_points(
        &self,
        count: usize,
        monitor: &Monitor,
    ) -> Result<Vec<TradeoffPoint>, Cancelled> {
        self.with_tradeoff(monitor, |_, tradeoff| tradeoff.points(count))
    }

    /// Hands the curve of time against stock to `use_curve`.
    fn with_tradeoff<T>(
        &self,
        monitor: &Monitor,
        use_curve: impl FnOnce(&WholePlan, &Tradeoff) -> T,
    ) -> Result<T, Cancelled> {
        let plan = self.whole.as_ref().unwrap_or(&self.after.plan);
        let grid = weighing_grid(&self.grid);
        let (workpiece, setup, locks) = (&*self.workpiece, &self.setup, &*self.kept_locked);
        let input = WholeInput { workpiece, setup, plan, grid: &self.grid, locks, clock: &self.clock };
        let whole = WholePlan::new(input, &grid);
        let sparse = match &self.sparse {
            Some(sparse) => Some(Arc::clone(sparse)),
            None => {
                let planning = &monitor.span(0.0, SPARSE_SHARE);
                whole.sparse_plan(&mut SectionCache::default(), planning)?.map(Arc::new)
            }
        };
        monitor.check()?;
        monitor.report(SPARSE_SHARE);
        let first = whole.thinning(plan, ThinningLimits::LEAST_TIME, monitor)?;
        monitor.report(0.5 * (1.0 + SPARSE_SHARE));
        let tradeoff = whole.tradeoff(first, sparse.as_deref(), monitor)?;
        let used = use_curve(&whole, &tradeoff);
        monitor.report(1.0);
        Ok(used)
    }
}
