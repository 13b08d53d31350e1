//! The overhang with which passes could be cut that shank or holder forbid.

use super::PassMaker;
use super::wall_positions::LayerPose;
use crate::cutting::drop_cutter::DepthSurface;
use crate::flank::fixed_axis::{FixedAxisSearch, LayerContact};

impl PassMaker<'_> {
    /// Smallest overhang, in whole mm, with which the tool has an axis at each of `contacts` on a layer;
    /// `None` where there are none, or no longer tool has one.
    pub(super) fn overhang_for(&self, contacts: &[LayerContact], surface: &DepthSurface) -> Option<f64> {
        let is_free = |search: &FixedAxisSearch| {
            contacts.iter().all(|contact| search.blocked(contact, surface).is_none())
        };
        if contacts.is_empty() { None } else { self.min_overhang(is_free) }
    }

    /// Smallest overhang, in whole mm, with which the holder is clear at the ends of a stretch of blocked
    /// `poses` along a wall; `None` where no longer tool's is.
    pub(super) fn overhang_along_wall(&self, poses: &[LayerPose]) -> Option<f64> {
        let (first, last) = (poses.first()?, poses.last()?);
        self.min_overhang(|search| {
            [first, last].iter().all(|pose| search.obstacle_except_blades(pose.tip, pose.axis).is_none())
        })
    }

    fn min_overhang(&self, is_free: impl Fn(&FixedAxisSearch) -> bool) -> Option<f64> {
        FixedAxisSearch::min_overhang(self.workpiece, self.tool, &self.limits, is_free)
    }
}
