//! Plans by what the setup asks for: least stock, least time, or the balance of both; and the curve between.

use super::{PlanOutcome, PolicyResult, measure_residual};
use crate::monitor::{Cancelled, Monitor};
use crate::plunge::{PlanError, Planner, PlungePlan};
use crate::setup::Setup;
use crate::stock::FloorGrid;
use crate::tradeoff::{Thinning, ThinningInput, ThinningLimits, TradeoffPoint, choose_point};

/// Cells along each side of the floor on which plunges are weighed; the grid of the figures is finer.
const CELLS: usize = 256;

/// The plan that the goal of `setup` asks for, from the `whole` plan of `minimal` over the floor `grid`;
/// `None` where that is the whole plan. An unfinished plan stays as it is.
///
/// # Errors
/// [`PlanError::Cancelled`] when `monitor` is cancelled.
pub(super) fn meet_goal(
    planner: &Planner,
    setup: &Setup,
    whole: &PlungePlan,
    grid: &FloorGrid,
    monitor: &Monitor,
) -> Result<Option<PlungePlan>, PlanError> {
    if whole.is_unfinished() || monitor.is_stopped() {
        return Ok(None);
    }
    let grid = &weighing_grid(grid);
    let limits = ThinningLimits::of(setup.plunge.goal);
    let input = ThinningInput { plan: whole, setup, blank: &planner.workpiece().blank, grid, limits };
    let thinning = Thinning::new(input, monitor)?;
    let count = choose_point(&thinning, setup.plunge.goal);
    if count == 0 {
        return Ok(None);
    }
    keep(planner, &thinning, whole, count, monitor).map(Some)
}

/// `whole` without the first `count` plunges of `thinning`.
fn keep(
    planner: &Planner,
    thinning: &Thinning,
    whole: &PlungePlan,
    count: usize,
    monitor: &Monitor,
) -> Result<PlungePlan, PlanError> {
    let kept = thinning.kept_without(count);
    planner.keep_plunges(whole, &kept, &thinning.columns_of(&kept), monitor)
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
        let planner = Planner::new(&self.workpiece, &self.setup);
        let plan = self.whole_plan();
        let grid = weighing_grid(&self.grid);
        let thinning = self.thinning(&grid, monitor)?;
        let points = thinning.points(count);
        let made = points.into_iter().map(|point| {
            let plan = keep(&planner, &thinning, plan, point.left_out, monitor)?;
            Ok(measure_residual(plan, &self.grid))
        });
        made.collect()
    }

    /// The points of [`Self::time_stock_curve`] without their plans, which takes a fraction of the time.
    ///
    /// # Errors
    /// [`Cancelled`] when `monitor` is cancelled.
    pub fn time_stock_points(
        &self,
        count: usize,
        monitor: &Monitor,
    ) -> Result<Vec<TradeoffPoint>, Cancelled> {
        let grid = weighing_grid(&self.grid);
        Ok(self.thinning(&grid, monitor)?.points(count))
    }

    /// The plan of `minimal` with all its plunges.
    fn whole_plan(&self) -> &PlungePlan {
        self.whole.as_ref().unwrap_or(&self.after.plan)
    }

    /// The order in which its plunges go, weighed over `grid`.
    fn thinning<'a>(&'a self, grid: &'a FloorGrid, monitor: &Monitor) -> Result<Thinning<'a>, Cancelled> {
        let (plan, setup, blank) = (self.whole_plan(), &self.setup, &self.workpiece.blank);
        let input = ThinningInput { plan, setup, blank, grid, limits: ThinningLimits::LEAST_TIME };
        Thinning::new(input, monitor)
    }
}
