//! Stage 5 of [plunge paper], safe height: how far a cutter must be retracted along its axis to be clear of
//! the blank.

use super::drop_cutter::DepthSurface;
use crate::geometry::{Circle, CutterSolid, Meridional, Point, Vector, distance_rate, norm2, search};
use crate::part::Blank;

/// Radius of the flat part of a bottom below which it is a point, that of a ball cutter, mm.
const MIN_FLAT: f64 = 1e-9;
/// Largest number of steps of the alternating projection.
const MAX_PROJECTIONS: usize = 8;
/// Maximum number of retract steps.
const MAX_RETRACT_STEPS: usize = 30;
/// Distance by which a tool retracts at most, in radii of the blank.
const MAX_RETRACT_RADII: f64 = 8.0;

/// The top of the blank as a drop-cutter surface: the shroud surface and the circles of the leading-edge line
/// and of the rim; or the outline of the blank.
#[derive(Debug)]
pub struct RetractSurface<'a> {
    blank: &'a Blank,
    /// Distance to keep from it, mm.
    distance: f64,
    /// The shroud and the circles of the ends; `None` for a blank with an outline.
    top: Option<DepthSurface<'a>>,
}

/// Shortest step of the search from above, in radii of the bottom raised by the distance.
const MIN_STEP_RADII: f64 = 0.01;
/// Tolerance of the height that the search from above finds, mm.
const HEIGHT_TOLERANCE: f64 = 1e-4;

impl<'a> RetractSurface<'a> {
    /// The surface at `distance` mm (safety distance plus corner radius) from `blank`.
    pub fn new(blank: &'a Blank, distance: f64) -> Self {
        let surface = || DepthSurface::new(&blank.shroud, distance).with_edges(blank.end_circles());
        Self { blank, distance, top: blank.outline().is_none().then(surface) }
    }

    /// Height above `tip` along `axis` (unit), mm, from which on a flat bottom of `radius` mm is clear of the
    /// blank; at least 0.
    pub fn height(&self, tip: &Point, axis: &Vector, radius: f64) -> f64 {
        let Some(surface) = &self.top else {
            return self.blank.outline_touch(tip, axis, radius, self.distance).map_or(0.0, |h| h.max(0.0));
        };
        let found = surface.touch(tip, axis, radius).map_or(0.0, |touch| touch.height.max(0.0));
        // The search for the shroud may end where the axis crosses it before, or on the far side.
        match self.blank.has_stock_above(tip, axis, radius, found) {
            true => self.height_from_above(tip, axis, radius, found),
            false => found,
        }
    }

    /// As [`Self::height`], which is at least `low` mm: steps down from above the wheel by the distance that
    /// is left (sphere tracing), then refines the border.
    fn height_from_above(&self, tip: &Point, axis: &Vector, radius: f64, low: f64) -> f64 {
        let gap = |height: f64| {
            let bottom = CutterSolid { tip: tip + axis * height, axis: *axis, radius, corner_radius: 0.0 };
            bottom_clearance(&bottom, self.blank) - self.distance
        };
        let reach = radius + self.distance;
        let mut above = self.blank.exit_height(tip, axis, reach);
        let mut left = gap(above);
        while left > 0.0 && above > low {
            let below = (above - left.max(MIN_STEP_RADII * reach)).max(low);
            left = gap(below);
            if left <= 0.0 {
                return search::root(gap, below, above, HEIGHT_TOLERANCE);
            }
            above = below;
        }
        above.max(low)
    }
}

/// The nearest points of a cutter's bottom and the blank.
#[derive(Clone, Copy, Debug)]
pub struct NearBottom {
    /// Minimum distance of the bottom to the blank, mm. Negative when the bottom is in the blank.
    pub clearance: f64,
    /// The point of the bottom, inset by the corner radius, and that of the blank's outline.
    point: Point,
    foot: Meridional,
}

impl NearBottom {
    /// Initial value of a minimum search.
    pub const NOWHERE: Self = Self {
        clearance: f64::INFINITY,
        point: Point::new(0.0, 0.0, 0.0),
        foot: Meridional { r: 0.0, z: 0.0 },
    };

    /// Searches rim, a ring and centre of the bottom, independently of how the retract height was computed.
    pub fn from_cutter(cutter: &CutterSolid, blank: &Blank) -> Self {
        let flat = cutter.radius - cutter.corner_radius;
        let centre = cutter.tip + cutter.axis * cutter.corner_radius;
        let mut warm = None;
        let mut nearest = Self::NOWHERE;
        let mut distance = |point: Point| {
            let (clearance, foot) = blank.nearest_top(Meridional::from_point(&point), &mut warm);
            if clearance < nearest.clearance {
                nearest = Self { clearance, point, foot };
            }
            (clearance, foot)
        };
        distance(centre);
        if flat < MIN_FLAT {
            return Self { clearance: nearest.clearance - cutter.corner_radius, ..nearest };
        }
        let half_way = Circle::new(&centre, &cutter.axis, 0.5 * flat);
        for i in 0..8 {
            distance(half_way.point_and_derivative((std::f64::consts::FRAC_PI_4 * f64::from(i)).sin_cos()).0);
        }
        let rim = Circle::new(&centre, &cutter.axis, flat);
        let on_rim = |phi: f64| {
            let (p, turning) = rim.point_and_derivative(phi.sin_cos());
            let (d, foot) = distance(p);
            (d, distance_rate(&p, &turning, foot) * d.signum())
        };
        search::min_over_turn::<16>(on_rim, 0.2);
        if blank.outline().is_some() {
            nearest.settle(&centre, &cutter.axis, flat, blank);
        }
        Self { clearance: nearest.clearance - cutter.corner_radius, ..nearest }
    }

    /// Alternating projection between the bottom and the blank, from the nearest sample: an edge of the blank
    /// may be nearest between the samples. The clearance is that of the inset disc about `centre`.
    fn settle(&mut self, centre: &Point, axis: &Vector, flat: f64, blank: &Blank) {
        for _ in 0..MAX_PROJECTIONS {
            if self.clearance <= 0.0 {
                break;
            }
            let r = norm2(self.point.x, self.point.y).max(1e-12);
            let foot =
                Point::new(self.point.x * self.foot.r / r, self.point.y * self.foot.r / r, self.foot.z);
            let d = foot - centre;
            let across = d - axis * d.dot(axis);
            let point = centre + across * (flat / across.norm().max(1e-12)).min(1.0);
            let (clearance, foot) = blank.nearest_top(Meridional::from_point(&point), &mut None);
            if clearance > self.clearance - 1e-6 {
                break;
            }
            *self = Self { clearance, point, foot };
        }
    }

    /// Derivative of the clearance, mm per unit, while the tip of its `cutter` moves by `motion` and the axis
    /// by `turning` (perpendicular to it).
    pub fn clearance_rate(&self, cutter: &CutterSolid, motion: &Vector, turning: &Vector) -> f64 {
        let turn = cutter.axis.cross(turning);
        let velocity = motion + turn.cross(&(self.point - cutter.tip));
        let depth = self.clearance + cutter.corner_radius;
        distance_rate(&self.point, &velocity, self.foot) * depth.signum()
    }
}

/// Minimum distance of a cutter's bottom to the blank, mm. Negative when the bottom is in the blank.
pub fn bottom_clearance(cutter: &CutterSolid, blank: &Blank) -> f64 {
    NearBottom::from_cutter(cutter, blank).clearance
}

/// Whether a cutter's bottom enters the blank: [`bottom_clearance`] is negative. Faster where it is far away.
pub fn bottom_is_inside(cutter: &CutterSolid, blank: &Blank) -> bool {
    let centre = cutter.tip + cutter.axis * cutter.corner_radius;
    !blank.is_far(Meridional::from_point(&centre), cutter.radius) && bottom_clearance(cutter, blank) < 0.0
}

/// Distance by which a retract point over `blank` is moved up at most, mm. Beyond, no way up frees a tool, as
/// where its axis points into the part; that it is not clear is reported.
pub fn max_retract(blank: &Blank) -> f64 {
    MAX_RETRACT_RADII * blank.extent().0
}

/// Tip of `cutter` after retracting along its axis until its bottom keeps `safety` mm from `blank`, and the
/// clearance there; `clearance` is the current one, mm.
///
/// After [`RetractSurface::height`] this rarely moves the tip: only near the flat ends of the blank, which
/// that surface represents by their circles. It moves it by [`max_retract`] at most.
pub fn retract_clear(cutter: &CutterSolid, clearance: f64, blank: &Blank, safety: f64) -> (Point, f64) {
    let (mut cutter, mut clearance) = (*cutter, clearance);
    let most = max_retract(blank);
    let (mut way, mut gained) = (0.0_f64, true);
    for _ in 0..MAX_RETRACT_STEPS {
        if clearance >= safety || way >= most {
            break;
        }
        let missing = safety - clearance;
        // Small steps along a wall gain nothing: the way is doubled.
        let step = (1.5 * missing + 1e-3).max(if gained { 0.0 } else { way }).min(most - way);
        way += step;
        cutter.tip += cutter.axis * step;
        clearance = bottom_clearance(&cutter, blank);
        gained = safety - clearance < 0.5 * missing;
    }
    (cutter.tip, clearance)
}
