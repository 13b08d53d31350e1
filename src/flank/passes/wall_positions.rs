//! Tool positions at the stations along a wall, on a layer.

use crate::flank::fixed_axis::{AxisObstacle, FixedAxisSearch};
use crate::flank::layer::{LayerPoint, LayerSurface};
use crate::flank::region::{Region, WallName};
use crate::flank::uncut::UncutReason;
use crate::flank::wall::MilledWall;
use crate::geometry::{Point, Vector};
use crate::setup::Tool;

/// Positions are raised by this above the layer, mm, so that the straight moves between them do not cut into
/// it.
pub(super) const CHORD: f64 = 0.005;
/// Reasons why a stretch along a wall is not cut.
const IN_THE_WAY: UncutReason = UncutReason::new("another blade blocks the cutter along the wall");
const HOLDER_IN_THE_WAY: UncutReason =
    UncutReason::holder("the holder meets a blade or stock along the wall");
const SHANK_IN_THE_WAY: UncutReason = UncutReason::shank("the shank meets a blade or stock along the wall");
const HUB_IN_THE_WAY: UncutReason = UncutReason::new("the hub is too near to the cutter along the wall");
const NEAR_FLOOR: UncutReason = UncutReason::new("the axis along the wall is within 10° of the floor");
/// Least cosine of the angle of the axis along a wall to the normal of the layer: 80°.
const MIN_NORMAL_COSINE: f64 = 0.17;

/// A tool position on a layer.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerPose {
    pub(super) tip: Point,
    pub(super) axis: Vector,
    pub(super) place: LayerPoint,
}

impl LayerPose {
    /// Interpolated position towards another one: tip linear, axis linear and normalised.
    pub(super) fn between(&self, other: &Self, share: f64) -> Self {
        let share = share.clamp(0.0, 1.0);
        Self {
            tip: self.tip + (other.tip - self.tip) * share,
            axis: (self.axis + (other.axis - self.axis) * share).normalize(),
            place: self.place.lerp(other.place, share),
        }
    }

    /// Interpolated tip and axis towards another position: the centre of the `corner` (mm) moves straight, so
    /// that its depth does not depend on the turn of the axis.
    pub(super) fn turned_to(&self, other: &Self, share: f64, corner: f64) -> (Point, Vector) {
        let axis = (self.axis + (other.axis - self.axis) * share).normalize();
        let [from, to] = [self, other].map(|placed| placed.tip + placed.axis * corner);
        (from + (to - from) * share - axis * corner, axis)
    }
}

/// The next step along a wall.
pub(super) enum WallStep {
    /// The pass continues to this position.
    To(LayerPose),
    /// A collision between two x of the layer, mm, with the pose that collides.
    Blocked { from: f64, to: f64, why: UncutReason, pose: LayerPose },
    /// The layer ends here and begins again further on; nothing of it is lost in between.
    Apart,
}

/// The runs of consecutive positions, in order.
pub(super) fn split_into_runs(steps: &[WallStep]) -> Vec<Vec<LayerPose>> {
    let runs = steps.split(|step| !matches!(step, WallStep::To(_)));
    let placed = |step: &WallStep| if let WallStep::To(placed) = step { Some(*placed) } else { None };
    runs.map(|run| run.iter().filter_map(placed).collect())
        .filter(|run: &Vec<LayerPose>| !run.is_empty())
        .collect()
}

/// The tool positions at the stations along a wall, on a layer.
pub(super) struct WallPositions {
    pub(super) wall: WallName,
    pub(super) region: Region,
    /// x of the first station on the flank itself, behind the nose.
    pub(super) behind_nose: f64,
    /// Position, and what is in its way, by station; `None` where the tool misses the layer.
    pub(super) placed: Vec<Option<(LayerPose, Option<UncutReason>)>>,
}

impl WallPositions {
    /// The positions of `tool` at all stations of a wall.
    pub(super) fn new(
        (tool, search): (&Tool, &FixedAxisSearch),
        (number, layer): (usize, &LayerSurface),
        milled: &MilledWall,
    ) -> Self {
        let mut y = None;
        let stations = milled.axes.stations(number);
        let placed = stations.iter().map(|station| {
            let tip = station.tip? + station.axis * CHORD;
            let axis = station.axis;
            let (place, _) = layer.project(&(tip + axis * tool.corner_radius), y.unwrap_or(0.0), None);
            y = Some(place.y);
            let up = layer.point_and_normal(place).1;
            let in_the_way = match station.blocked {
                Some(_) => Some(IN_THE_WAY),
                None if up.dot(&axis) < MIN_NORMAL_COSINE => Some(NEAR_FLOOR),
                None => search.obstacle_except_blades(tip, axis).map(|obstacle| match obstacle {
                    AxisObstacle::Hub => HUB_IN_THE_WAY,
                    AxisObstacle::Shank | AxisObstacle::ShankInStock => SHANK_IN_THE_WAY,
                    _ => HOLDER_IN_THE_WAY,
                }),
            };
            Some((LayerPose { tip, axis, place }, in_the_way))
        });
        let placed: Vec<Option<(LayerPose, Option<UncutReason>)>> = placed.collect();
        let flank = milled.axes.map.u.first().copied().unwrap_or(0.0);
        let on_flank = stations.iter().zip(&placed).filter(|(station, _)| station.u >= flank);
        let behind_nose = on_flank.filter_map(|(_, p)| *p).map(|(p, _)| p.place.x).next();
        Self {
            wall: milled.wall,
            region: milled.region,
            behind_nose: behind_nose.unwrap_or(f64::INFINITY),
            placed,
        }
    }

    /// Axis at `x`, interpolated between the free stations; beyond both ends that of the nearest.
    pub(super) fn axis(&self, x: f64) -> Option<Vector> {
        let free = |(placed, in_the_way): &'_ (LayerPose, Option<UncutReason>)| {
            in_the_way.is_none().then_some(*placed)
        };
        let stations = || self.placed.iter().flatten().filter_map(free);
        let mut last: Option<LayerPose> = None;
        for here in stations() {
            if here.place.x >= x {
                return Some(last.map_or(here.axis, |last| {
                    last.between(&here, (x - last.place.x) / (here.place.x - last.place.x).max(1e-9)).axis
                }));
            }
            last = Some(here);
        }
        last.map(|last| last.axis)
    }
}
