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

/// Where a cutter's bottom is nearest to the blank.
#[derive(Clone, Copy, Debug)]
pub struct NearBottom {
    /// Least distance of the bottom to the blank, mm. Negative when the bottom is in the blank.
    pub clearance: f64,
    /// The place of the bottom (before its corner is rounded) and the one of the blank's outline.
    point: Point,
    foot: Meridional,
}

impl NearBottom {
    /// Before anything was looked at.
    pub const NOWHERE: Self = Self {
        clearance: f64::INFINITY,
        point: Point::new(0.0, 0.0, 0.0),
        foot: Meridional { r: 0.0, z: 0.0 },
    };

    /// Looks for it on a dense rim and rings, independent of how the retract height was found.
    pub fn of(cutter: &CutterSolid, blank: &Blank) -> Self {
        let flat = cutter.radius - cutter.corner_radius;
        let centre = cutter.tip + cutter.axis * cutter.corner_radius;
        let mut warm = None;
        let mut nearest = Self::NOWHERE;
        let mut distance = |point: Point| {
            let (clearance, foot) = blank.nearest_top(Meridional::of(&point), &mut warm);
            if clearance < nearest.clearance {
                nearest = Self { clearance, point, foot };
            }
            (clearance, foot)
        };
        distance(centre);
        let half_way = Circle::new(&centre, &cutter.axis, 0.5 * flat);
        for i in 0..8 {
            distance(half_way.at((std::f64::consts::FRAC_PI_4 * f64::from(i)).sin_cos()).0);
        }
        let rim = Circle::new(&centre, &cutter.axis, flat);
        let on_rim = |phi: f64| {
            let (p, turning) = rim.at(phi.sin_cos());
            let (d, foot) = distance(p);
            (d, receding(&p, &turning, foot) * d.signum())
        };
        search::least_around::<16>(on_rim, 0.2);
        Self { clearance: nearest.clearance - cutter.corner_radius, ..nearest }
    }

    /// How fast the clearance grows while the tip of the `cutter` it is about moves by `motion` and its axis by
    /// `turning` (across it), mm per unit of both.
    pub fn growth(&self, cutter: &CutterSolid, motion: &Vector, turning: &Vector) -> f64 {
        let turn = cutter.axis.cross(turning);
        let velocity = motion + turn.cross(&(self.point - cutter.tip));
        let depth = self.clearance + cutter.corner_radius;
        receding(&self.point, &velocity, self.foot) * depth.signum()
    }
}

/// Least distance of a cutter's bottom to the blank, mm. Negative when the bottom is in the blank.
pub fn bottom_clearance(cutter: &CutterSolid, blank: &Blank) -> f64 {
    NearBottom::of(cutter, blank).clearance
}

/// Times a cutter is pulled back further before it has to do.
const MAX_PULLS: usize = 30;

/// Tip of `cutter` when it is pulled back along its axis until its bottom keeps `safety` mm from `blank`, and what it keeps
/// there; `clearance` is what it keeps now.
///
/// Where a [`RetractSurface`] has brought it this is seldom more than nothing: the flat ends of the blank lie between the
/// circles of that surface.
pub fn pulled_clear(cutter: &CutterSolid, clearance: f64, blank: &Blank, safety: f64) -> (Point, f64) {
    let (mut cutter, mut clearance) = (*cutter, clearance);
    for _ in 0..MAX_PULLS {
        if clearance >= safety {
            break;
        }
        cutter.tip += cutter.axis * (1.5 * (safety - clearance) + 1e-3);
        clearance = bottom_clearance(&cutter, blank);
    }
    (cutter.tip, clearance)
}
