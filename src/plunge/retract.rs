//! Stage 5: how far a cutter must be pulled back along its axis to be clear of the blank.

use super::slotting::DepthSurface;
use crate::geometry::{Circle, CutterSolid, Meridional, Point, Vector, receding, search};
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
    let flat = cutter.radius - cutter.corner_radius;
    let centre = cutter.tip + cutter.axis * cutter.corner_radius;
    let mut warm = None;
    let mut least = blank.clearance(Meridional::of(&centre), &mut warm);
    let half_way = Circle::new(&centre, &cutter.axis, 0.5 * flat);
    for i in 0..8 {
        let (p, _) = half_way.at((std::f64::consts::FRAC_PI_4 * f64::from(i)).sin_cos());
        least = least.min(blank.clearance(Meridional::of(&p), &mut warm));
    }
    let rim = Circle::new(&centre, &cutter.axis, flat);
    let on_rim = |phi: f64| {
        let (p, turning) = rim.at(phi.sin_cos());
        let (d, foot) = blank.nearest_top(Meridional::of(&p), &mut warm);
        (d, receding(&p, &turning, foot) * d.signum())
    };
    least.min(search::least_around::<16>(on_rim, 0.2)) - cutter.corner_radius
}
