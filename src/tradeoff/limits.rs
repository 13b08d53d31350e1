//! How far a plan may be thinned.

use crate::setup::Goal;

/// Share by which the stock above the allowance may rise while a plan still counts as one of the least stock.
pub(super) const AS_GOOD: f64 = 0.02;
/// Share of the floor that thinning may always leave uncut beside what the whole plan leaves uncut.
const MAX_MORE_UNCUT: f64 = 0.001;
/// Share of the floor up to which a plan counts as one that cuts the whole floor.
const CUTS_THE_FLOOR: f64 = 0.01;

/// What plunges may be left out for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinningLimits {
    /// Largest share by which the stock above the allowance may rise on any band of the floor.
    pub max_mean_rise: f64,
    /// Share of the reachable floor that may be uncut, unless the whole plan leaves more.
    pub max_uncut_share: f64,
    /// Share of it that may then be uncut beside what the whole plan leaves.
    pub max_more_uncut: f64,
}

impl ThinningLimits {
    /// As many plunges go as still leave the stock of the whole plan.
    pub const LEAST_STOCK: Self =
        Self { max_mean_rise: AS_GOOD, max_uncut_share: 0.0, max_more_uncut: MAX_MORE_UNCUT };
    /// As many go as can.
    pub const LEAST_TIME: Self = Self {
        max_mean_rise: f64::INFINITY,
        max_uncut_share: CUTS_THE_FLOOR,
        max_more_uncut: MAX_MORE_UNCUT,
    };

    /// Those of `goal`.
    pub fn from_goal(goal: Goal) -> Self {
        if goal == (Goal::Stock { max_time_min: None }) { Self::LEAST_STOCK } else { Self::LEAST_TIME }
    }

    /// Largest share of the floor that may be uncut, where the whole plan leaves `uncut_share`.
    pub(super) fn max_uncut_share(&self, uncut_share: f64) -> f64 {
        self.max_uncut_share.max(uncut_share + self.max_more_uncut)
    }
}
