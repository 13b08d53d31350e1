//! The frame of the axes of a place in a row, and the grid of lead angles that are tried.

use crate::geometry::Vector;
use crate::plunge::lane::AxisEnds;

/// First lead angle of the grid, degrees. The grid is shifted where the conventional axis has so large a lead
/// angle that `max_tilt` would leave less than half of the grid.
const FIRST_LEAD_DEG: f64 = -12.0;

/// Step of the grid of lead angles, degrees.
pub(super) const LEAD_STEP_DEG: f64 = 2.0;

/// Number of steps of the grid.
pub(super) const LEAD_STEPS: usize = 19;

/// Middle of the grid, degrees.
pub(super) const MIDDLE_LEAD_DEG: f64 = FIRST_LEAD_DEG + 0.5 * LEAD_STEP_DEG * LEAD_STEPS as f64;

/// Step of the grid around the conventional axis that is laid where no axis of the usual one clears the
/// blades, degrees: in a passage hardly wider than the cutter the usual step is too coarse.
const NARROW_STEP_DEG: f64 = 0.5;

/// Local frame at a position of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowFrame {
    /// Hub normal.
    pub(super) normal: Vector,
    /// Unit direction along the row, towards the uncut side.
    pub(super) feed: Vector,
    /// Unit direction across the row.
    pub(super) across: Vector,
    /// Distance and angle about Z that M moves per unit of s along the row, mm and rad.
    pub(super) path_by_s: (f64, f64),
}

/// Linearisation of the lead angle by s of W, around the axis with zero lead angle or a shifted one.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZeroLeadRef {
    pub(super) s_shroud: f64,
    /// Lead angle there, by which the whole grid is shifted, rad.
    pub(super) shift_rad: f64,
    /// Derivative of the tangent of the lead angle by s of W.
    pub(super) tan_lead_by_s: f64,
    /// Height of W above M along the normal, mm.
    pub(super) height: f64,
}

impl ZeroLeadRef {
    /// s of W for the lead angle `lead_rad` relative to the shift.
    pub(super) fn s_shroud_at_lead(&self, lead_rad: f64) -> f64 {
        self.s_shroud + ((lead_rad + self.shift_rad).tan() - self.shift_rad.tan()) / self.tan_lead_by_s
    }
}

/// Reference from which all axes at an s are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisFrame {
    pub(super) conventional: AxisEnds,
    pub(super) frame: RowFrame,
    pub(super) zero_lead: ZeroLeadRef,
    /// The conventional axis.
    pub(super) reference: Vector,
    /// Its lead angle relative to the shift of the grid, rad.
    pub(super) conventional_lead_rad: f64,
    pub(super) grid: LeadGrid,
}

/// Lead angles of a stage, relative to its shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeadGrid {
    first_deg: f64,
    step_deg: f64,
}

impl LeadGrid {
    pub(super) const USUAL: Self = Self { first_deg: FIRST_LEAD_DEG, step_deg: LEAD_STEP_DEG };

    /// The narrow grid around the lead angle `middle_rad`, which is one of its own.
    pub(super) fn narrow(middle_rad: f64) -> Self {
        let half = (LEAD_STEPS / 2) as f64 * NARROW_STEP_DEG;
        Self { first_deg: middle_rad.to_degrees() - half, step_deg: NARROW_STEP_DEG }
    }

    /// Lead angle `j` of the grid with its steps divided into `fineness` parts, rad.
    pub(super) fn lead_rad(&self, j: usize, fineness: usize) -> f64 {
        (self.first_deg + self.step_deg * j as f64 / fineness as f64).to_radians()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of whole plans hardly notice another grid: the search finds axes of nearly the same cost in
    /// it.
    #[test]
    fn the_grid_of_lead_angles_is_that_of_its_page() {
        let page = include_str!("../../../docs/algorithms/minimal.md");
        let row = page.lines().find(|line| line.contains("`FIRST_LEAD_DEG`")).expect("a row of the grid");
        let number = |word: &str| word.replace('\u{2212}', "-").parse::<f64>().ok();
        let numbers: Vec<f64> = row
            .split('|')
            .nth(1)
            .expect("a cell of values")
            .split([' ', '°', ','])
            .filter_map(number)
            .collect();
        let &[first, step, steps] = numbers.as_slice() else { panic!("not first, step and count: {row}") };
        assert_eq!(steps, LEAD_STEPS as f64, "{row}");
        for j in 0..=LEAD_STEPS {
            let lead = LeadGrid::USUAL.lead_rad(j, 1).to_degrees();
            assert!((lead - (first + step * j as f64)).abs() < 1e-9, "lead angle {j} is {lead}°: {row}");
        }
        let middle = 5f64.to_radians();
        assert!((LeadGrid::narrow(middle).lead_rad(LEAD_STEPS / 2, 1) - middle).abs() < 1e-12);
    }
}
