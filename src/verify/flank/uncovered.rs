//! Floor on which a program leaves too much stock, by cause.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::cutting::drop_cutter::DepthSurface;
use crate::flank::fixed_axis::{FixedAxisLimits, FixedAxisSearch, LayerContact, MAX_TILT};
use crate::geometry::{Meridional, Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{FinishedPart, Workpiece};
use crate::setup::{Setup, Tool};
use crate::stock::FloorGrid;

/// Shares of the reachable floor with more stock than the hub's allowance and the scallop height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Uncovered {
    /// Beside a blade: no more than the fillet that the cutter's corner leaves where it is as near as it may
    /// be.
    pub fillet: f64,
    /// Inaccessible to the cutter: with every axis, blades or hub would be too near to it or to its holder.
    pub no_axis: f64,
    /// The rest: another program with the same cutter could remove it.
    pub gap: f64,
}

/// Scallop height between the samples of a sweep, mm.
pub(super) const SAMPLE_SCALLOP: f64 = 0.01;
/// Cells of a block, along and across; the axis search uses its first cell for all of it.
const BLOCK: usize = 8;
/// Largest number of steps in which a ball slides along the floor away from the blades.
const SLIDES: usize = 12;
/// Missing distance of the ball from the blades that is tolerated, mm.
const SLIDE_TOLERANCE: f64 = 1e-3;
/// Sine of the angle between floor and wall below which it does not slide.
const MIN_SLOPE: f64 = 0.1;

impl Uncovered {
    /// Total share.
    pub fn share(&self) -> f64 {
        self.fillet + self.no_axis + self.gap
    }

    /// Evaluates the cells of `grid` with residual heights `heights`, mm; `tool` is the one with the smallest
    /// corner.
    ///
    /// # Errors
    /// When cancelled.
    pub(super) fn from_workpiece(
        workpiece: &Workpiece,
        setup: &Setup,
        tool: &Tool,
        grid: &FloorGrid,
        heights: &[f32],
        monitor: &Monitor,
    ) -> Result<Self, Cancelled> {
        let stock = &setup.allowances;
        let limits = FixedAxisLimits {
            hub_allowance: stock.hub_allowance,
            blade_allowance: stock.blade_allowance,
            stock_height: setup.flank.layer_depth,
            max_tilt_rad: MAX_TILT,
            clearances: setup.clearances,
        };
        let search = FixedAxisSearch::new(workpiece, tool, &limits);
        let layer = DepthSurface::new(workpiece.part.hub.curve(), stock.hub_allowance + tool.corner_radius);
        let corner = CornerBall {
            finished: &workpiece.finished,
            radius: tool.corner_radius,
            hub_allowance: stock.hub_allowance,
            blade_allowance: stock.blade_allowance,
        };
        let allowed = setup.flank.scallop_height + 2.0 * SAMPLE_SCALLOP;
        let cells: Vec<usize> =
            (0..grid.floor.len()).filter(|&cell| grid.floor[cell] && grid.reachable[cell]).collect();
        let area_of = |cell: usize| f64::from(grid.areas[cell]);
        let whole: f64 = cells.iter().map(|&cell| area_of(cell)).sum();
        // Cells with too much stock, and for those that are not fillets the contact point of a corner that
        // would cut them.
        let left: Vec<(usize, Option<LayerContact>)> = cells
            .into_par_iter()
            .filter_map(|cell| {
                let over = f64::from(heights[cell]) - stock.hub_allowance - allowed;
                let double = |v: [f32; 3]| v.map(f64::from);
                let (foot, up) =
                    (Point::from(double(grid.points[cell])), Vector::from(double(grid.normals[cell])));
                let lower = || corner.contact_over(&foot, &up).filter(|(_, left)| *left < over);
                (over > 0.0).then(|| (cell, lower().map(|(contact, _)| contact)))
            })
            .collect();
        let mut blocks: BTreeMap<usize, (LayerContact, f64)> = BTreeMap::new();
        let mut fillet = 0.0;
        for (cell, contact) in left {
            let area = area_of(cell);
            let Some(contact) = contact else {
                fillet += area;
                continue;
            };
            let block = cell / grid.columns / BLOCK * grid.columns + cell % grid.columns / BLOCK;
            blocks.entry(block).or_insert((contact, 0.0)).1 += area;
        }
        let blocks: Vec<(LayerContact, f64)> = blocks.into_values().collect();
        let blocked = |(contact, area): &(LayerContact, f64)| {
            monitor.check()?;
            Ok(if search.blocked(contact, &layer).is_some() { [*area, 0.0] } else { [0.0, *area] })
        };
        let judged: Vec<[f64; 2]> = blocks.par_iter().map(blocked).collect::<Result<_, Cancelled>>()?;
        let share = |area: f64| area / whole.max(1e-9);
        // From 0: the sum of no numbers is -0.
        let sum = |k: usize| share(judged.iter().fold(0.0, |sum, areas| sum + areas[k]));
        Ok(Self { fillet: share(fillet), no_axis: sum(0), gap: sum(1) })
    }
}

/// The round corner of a cutter, as a ball on the floor.
struct CornerBall<'a> {
    finished: &'a FinishedPart,
    radius: f64,
    hub_allowance: f64,
    blade_allowance: f64,
}

impl CornerBall<'_> {
    /// The contact of the ball where it is nearest to the ray from `foot` along the hub's normal `up`, and
    /// the stock it leaves there above the allowance, mm: infinite where it misses the ray. `None` where it
    /// does not fit between the blades.
    fn contact_over(&self, foot: &Point, up: &Vector) -> Option<(LayerContact, f64)> {
        let hub = self.finished.hub.curve();
        let height = self.hub_allowance + self.radius;
        let (mut centre, mut normal) = (foot + up * height, *up);
        for slide in 0.. {
            let wanted = self.radius + self.blade_allowance;
            let near = self.finished.nearest_blade_below(&centre, wanted - SLIDE_TOLERANCE);
            let Some(near) = near else { break };
            let lacking = wanted - near.distance;
            let away = (centre - near.point).try_normalize(1e-9)?;
            let along = away - normal * away.dot(&normal);
            if slide == SLIDES || along.norm() < MIN_SLOPE {
                return None;
            }
            centre += along * (lacking / along.norm_squared());
            // Back onto the floor's offset.
            let at = Meridional::from_point(&centre);
            let (t, _) = hub.project(at);
            let place = hub.at(t);
            let angle = centre.y.atan2(centre.x);
            normal = place.normal.direction_at_angle(angle);
            centre = place.point.at_angle(angle) + normal * height;
        }
        let contact = LayerContact { point: centre - normal * self.radius, normal };
        let to_centre = centre - foot;
        let along = to_centre.dot(up);
        let across = to_centre.norm_squared() - along * along;
        let half = self.radius * self.radius - across;
        let left = if half > 0.0 { along - half.sqrt() - self.hub_allowance } else { f64::INFINITY };
        Some((contact, left))
    }
}
