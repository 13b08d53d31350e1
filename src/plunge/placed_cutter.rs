//! A cutter where a plunge ends.

use crate::geometry::CutterSolid;

/// A cutter at its final depth, with its clearances to the finished part, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedCutter {
    pub cutter: CutterSolid,
    pub hub_clearance: f64,
    pub blade_clearance: f64,
    /// Distance by which it stops short of the hub allowance, mm.
    pub lift: f64,
}
