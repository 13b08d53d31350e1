//! How far from the part's axis a machine can tilt the tool.

use std::f64::consts::{PI, TAU};

use super::model::MachineTool;
use crate::geometry::Vector;

/// Spacing of the tilts that are tried before the limit is bisected, rad.
const TILT_STEP: f64 = PI / 180.0;
/// Directions tried at each tilt, evenly about the part's axis.
const DIRECTIONS: usize = 72;
/// Bisections of the last step; what is left is below a thousandth of a degree.
const BISECTIONS: usize = 12;

impl MachineTool {
    /// The largest angle between tool axis and the part's axis, out of the inlet, up to which the rotary axes
    /// reach every direction within their limits, rad; π where they reach all. Linear axes are not
    /// considered: how far they must go depends on part and tool.
    pub fn max_axis_tilt_rad(&self) -> f64 {
        let up = if self.part.inlet_up { 1.0 } else { -1.0 };
        let reaches_all = |tilt: f64| {
            (0..DIRECTIONS).all(|i| {
                let (sin, cos) = (TAU * i as f64 / DIRECTIONS as f64).sin_cos();
                let axis = Vector::new(tilt.sin() * cos, tilt.sin() * sin, up * tilt.cos());
                self.can_reach(&axis)
            })
        };
        let steps = (PI / TILT_STEP).round() as usize;
        let Some(first) = (0..=steps).find(|&i| !reaches_all(PI * i as f64 / steps as f64)) else {
            return PI;
        };
        let (mut low, mut high) =
            (PI * first.saturating_sub(1) as f64 / steps as f64, PI * first as f64 / steps as f64);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if reaches_all(middle) { low = middle } else { high = middle }
        }
        low
    }

    /// Whether rotary positions within the limits hold the tool along the unit vector `axis`, in the frame of
    /// the program.
    fn can_reach(&self, axis: &Vector) -> bool {
        let (solutions, count) = self.solve(axis);
        let within =
            |index: usize, angle: f64| self.rotary[index].turns_within_limits(angle).next().is_some();
        solutions
            .iter()
            .take(count)
            .any(|solution| within(1, solution.second) && solution.first.is_none_or(|first| within(0, first)))
    }
}
