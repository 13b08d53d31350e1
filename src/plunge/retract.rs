//! Stage 5: how far a cutter must be pulled back along its axis to be clear of the blank.

use super::slotting::DepthSurface;
use crate::geometry::{CutterSolid, Meridional, Point, Vector};
use crate::part::Blank;

/// The top of the blank as something a bottom must clear: the shroud surface, touched on its rim like the hub,
/// and the circles of the leading-edge line and of the rim.
#[derive(Debug)]
pub struct RetractSurface<'a> {
    top: DepthSurface<'a>,
}

impl<'a> RetractSurface<'a> {
    /// For cutters that keep `distance` mm (safety distance plus corner radius) from `blank`.
    pub fn new(blank: &'a Blank, distance: f64) -> Self {
        Self { top: DepthSurface::new(&blank.shroud, distance).with_edges(blank.end_circles()) }
    }

    /// Height above `tip` along `axis` at which a flat bottom of `radius` is clear of the blank and
    /// stays so further up; at least 0.
    pub fn height(&self, tip: &Point, axis: &Vector, radius: f64) -> f64 {
        self.top.touch(tip, axis, radius).map_or(0.0, |touch| touch.height.max(0.0))
    }
}

/// Least distance of a cutter's bottom to the blank, mm: dense rim and rings, independent of how
/// the retract height was found. Negative when the bottom is in the blank.
pub fn bottom_clearance(cutter: &CutterSolid, blank: &Blank) -> f64 {
    let (e1, e2) = crate::geometry::frame_about(&cutter.axis);
    let flat = cutter.radius - cutter.corner_radius;
    let centre = cutter.tip + cutter.axis * cutter.corner_radius;
    let mut warm = None;
    let mut at = |rho: f64, phi: f64| {
        let p = centre + (e1 * phi.cos() + e2 * phi.sin()) * rho;
        blank.clearance(Meridional::of(&p), &mut warm)
    };
    let mut least = at(0.0, 0.0);
    let around = 24;
    let step = std::f64::consts::TAU / f64::from(around);
    let mut best = (f64::INFINITY, 0.0);
    for i in 0..around {
        let phi = step * f64::from(i);
        if i % 3 == 0 {
            least = least.min(at(0.5 * flat, phi));
        }
        let d = at(flat, phi);
        if d < best.0 {
            best = (d, phi);
        }
    }
    let (_, refined) =
        crate::geometry::search::minimum(|phi| at(flat, phi), best.1 - step, best.1 + step, 1e-5);
    least.min(best.0).min(refined) - cutter.corner_radius
}
