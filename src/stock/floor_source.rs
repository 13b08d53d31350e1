//! What a floor grid is made of: the part, its allowances, and the cutters that work on it.

use crate::part::Workpiece;
use crate::setup::{AllowanceSetup, Setup};

/// Inputs of a floor grid.
#[derive(Clone, Copy, Debug)]
pub struct FloorSource<'a> {
    /// The part, its channel, and the blank before the first cut.
    pub workpiece: &'a Workpiece,
    /// Allowances.
    pub stock: &'a AllowanceSetup,
    /// Ranges of s and the cutters used there. Without any, the whole floor counts as reachable.
    pub cutters: &'a [CutterStretch],
    /// Largest angle of an axis from the isoparametric one, rad.
    pub max_tilt_rad: f64,
}

impl<'a> FloorSource<'a> {
    /// The floor of `workpiece` with the allowances and the largest tilt of plunges of `setup`.
    pub fn of_setup(workpiece: &'a Workpiece, setup: &'a Setup, cutters: &'a [CutterStretch]) -> Self {
        Self { workpiece, stock: &setup.allowances, cutters, max_tilt_rad: setup.plunge.max_tilt_rad }
    }
}

/// A range of s and the radius of the cutter used there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutterStretch {
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// R, mm.
    pub radius: f64,
    /// Number of the tool.
    pub tool: u32,
}

impl CutterStretch {
    /// Distance of `s` from the range, 0 within it.
    pub(super) fn distance_to(&self, s: f64) -> f64 {
        (s - self.from).max(self.to - s).max(0.0)
    }
}
