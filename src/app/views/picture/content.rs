//! What a picture shows besides the part: one plan, its progress and its stock.

use std::sync::Arc;

use crate::app::model::planned::DisplayPlan;
use crate::gpu::stock_floor::StockState;
use crate::setup::AxisPolicy;

/// Content of a picture besides the part.
#[derive(Clone, Debug)]
pub struct Content {
    /// The set of plans.
    pub planned: Arc<DisplayPlan>,
    /// Policy of the shown plan.
    pub policy: AxisPolicy,
    /// Number of positions cut; `None`: all.
    pub cut: Option<usize>,
    /// Heights of stock per cell after n positions, mm, as the core computes them; `None`: those of the
    /// whole plan.
    pub heights: Option<Arc<Vec<f32>>>,
    /// Policy whose stock is subtracted from that of the whole plan, for a difference.
    pub more_than: Option<AxisPolicy>,
}

impl Content {
    /// Whether the same is drawn, apart from where its heights come from. Plans are immutable, so pointer
    /// equality suffices.
    pub(super) fn same_picture(&self, other: &Self) -> bool {
        self.same_plan(other) && self.cut == other.cut && self.more_than == other.more_than
    }

    pub(super) fn same_plan(&self, other: &Self) -> bool {
        self.policy == other.policy && Arc::ptr_eq(&self.planned, &other.planned)
    }

    pub(super) fn same_heights(&self, other: &Self) -> bool {
        match (&self.heights, &other.heights) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// Value of a cell of the plan's grid: stock, or a difference of stock, mm.
    pub(super) fn value(&self, cell: usize) -> Option<f32> {
        let left = |policy| self.planned.result(policy).field.heights.get(cell).copied();
        match (self.more_than, &self.heights) {
            (Some(other), _) => Some(left(self.policy)? - left(other)?),
            (None, Some(heights)) => heights.get(cell).copied(),
            (None, None) => left(self.policy),
        }
    }

    /// The stock to draw on the device, and the one to subtract from it.
    pub(super) fn stock_states(&self) -> Option<(StockState, Option<StockState>)> {
        let whole = |policy| {
            let program = Arc::clone(self.planned.program(policy)?);
            Some(StockState { count: program.cutters.len(), program })
        };
        let shown = whole(self.policy)?;
        match self.more_than {
            Some(other) => Some((shown, Some(whole(other)?))),
            None => Some((StockState { count: self.cut.unwrap_or(shown.count), ..shown }, None)),
        }
    }
}
