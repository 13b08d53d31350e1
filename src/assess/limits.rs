//! Limits of the axes, and the sides from which a point of the floor is reached.

use crate::setup::ClearanceSetup;

/// Minimum inclination of an axis that comes from one side, and step of the inclinations tested, rad.
pub const MIN_INCLINATION: f64 = 7.5 * std::f64::consts::PI / 180.0;

/// Limits of the axes.
#[derive(Clone, Copy, Debug)]
pub struct ReachLimits {
    /// Stock that stays on the hub, mm.
    pub hub_allowance: f64,
    /// Stock that stays on the blades, mm.
    pub blade_allowance: f64,
    /// Maximum angle between axis and hub normal along the flow, rad.
    pub max_tilt_rad: f64,
    /// Clearances of a given shank and holder beyond the allowances, mm.
    pub clearances: ClearanceSetup,
}

/// The sides from which a point is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReachSides {
    /// From the outlet.
    pub outlet: bool,
    /// From the inlet.
    pub inlet: bool,
    /// From either side, or with an axis near the hub normal.
    pub any: bool,
}

impl ReachSides {
    /// The classes of access in the order of tables: from any side, the outlet, the inlet, both.
    pub const CLASSES: [fn(Self) -> bool; 4] = [|s| s.any, |s| s.outlet, |s| s.inlet, Self::both];

    pub(super) fn or(self, other: Self) -> Self {
        Self {
            outlet: self.outlet || other.outlet,
            inlet: self.inlet || other.inlet,
            any: self.any || other.any,
        }
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self {
            outlet: self.outlet && other.outlet,
            inlet: self.inlet && other.inlet,
            any: self.any && other.any,
        }
    }

    /// From both sides.
    pub fn both(self) -> bool {
        self.outlet && self.inlet
    }
}
