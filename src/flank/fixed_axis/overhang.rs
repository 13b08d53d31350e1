//! The overhang with which axes would be free that shank or holder forbid.

use super::{FixedAxisLimits, FixedAxisSearch};
use crate::part::Workpiece;
use crate::setup::Tool;

/// First extension of the search, mm; it doubles until it suffices.
const FIRST_EXTENSION: f64 = 8.0;
/// Largest extension that is looked at, mm.
const MAX_EXTENSION: f64 = 256.0;

impl FixedAxisSearch<'_> {
    /// Smallest overhang of `tool`, in whole mm, with which `is_free` holds, by bisection; 1 mm less does not
    /// do. `None` where no longer tool within reason suffices.
    pub fn min_overhang(
        workpiece: &Workpiece,
        tool: &Tool,
        limits: &FixedAxisLimits,
        is_free: impl Fn(&FixedAxisSearch) -> bool,
    ) -> Option<f64> {
        let suffices = |overhang: f64| {
            let longer = Tool { overhang, ..tool.clone() };
            is_free(&FixedAxisSearch::new(workpiece, &longer, limits))
        };
        let mut low = tool.overhang.floor();
        let mut extension = FIRST_EXTENSION;
        while !suffices(low + extension) {
            low += extension;
            extension *= 2.0;
            if low + extension > tool.overhang + MAX_EXTENSION {
                return None;
            }
        }
        let mut high = low + extension;
        while high - low > 1.0 {
            let middle = (0.5 * (low + high)).floor();
            if suffices(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(high)
    }
}
