//! From curves on a layer to passes: positions of the tool.
//!
//! | file | contents |
//! |---|---|
//! | `stretches` | curves split by regions |
//! | `inner` | inner passes under fixed axes, blended towards those of near walls |
//! | `along_wall` | passes along walls with the axes fitted to them |
//! | `nose` | the pass round the nose of a splitter |
//! | `overhang` | the overhang that passes would need which shank or holder forbid |

mod along_wall;
mod inner;
mod nose;
mod overhang;
mod stretches;
mod wall_positions;

use super::chart::LayerChart;
use super::curves::LayerLayout;
use super::fixed_axis::{AxisObstacle, FixedAxisLimits, FixedAxisSearch, LayerContact, MAX_TILT};
use super::layer::{LayerPoint, LayerSurface};
use super::layer_regions::RegionStretch;
use super::path::Pass;
use super::region::Region;
use super::strategies::PassRole;
use super::uncut::{UncutLength, UncutReason};
use super::wall::MilledWall;
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::{Point, Vector};
use crate::part::{Channel, FinishedPart, Workpiece};
use crate::setup::{Setup, Tool};
use stretches::{CurvePiece, split_by_region};
use wall_positions::{CHORD, LayerPose, WallPositions};

/// Maximum turn of the axis from one position to the next, rad: a little less than 5°.
const MAX_STEP_TURN: f64 = 4.8 * std::f64::consts::PI / 180.0;
/// Turn of the axis from one position to the next at which a pass ends, rad.
const MAX_PASS_TURN: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Length below which a pass is left out, in stepovers: what it cuts its neighbours have cut.
const MIN_PASS: f64 = 0.1;
/// Why it is left out, as a message.
const TOO_SHORT: UncutReason = UncutReason::new("too short between obstacles for a pass");
/// Minimum and maximum step along inner passes, mm.
const STEPS: [f64; 2] = [0.2, 5.0];

/// A blade is near a cutter within this distance beyond the allowance, mm.
const NEAR_BLADE: f64 = 1.0;
/// Least share of the direction off a blade that lies across the axis, for a way across it.
const MIN_ACROSS: f64 = 0.2;

/// A fixed axis of the inner passes.
#[derive(Clone, Copy, Debug)]
pub struct RegionAxis {
    /// Layer, 0 at the hub.
    pub layer: usize,
    /// Region.
    pub region: Region,
    /// Start of its range along the layer, mm.
    pub from: f64,
    /// End of its range along the layer, mm.
    pub to: f64,
    /// Unit axis, tip → holder, in the frame of the part.
    pub axis: Vector,
    /// Minimum distance of the cutter from the blades, mm.
    pub clearance: f64,
}

/// The passes of a layer.
pub struct PlannedLayer {
    /// One per curve, or more where the axis jumps along it.
    pub passes: Vec<Pass>,
    /// Fixed axes of the inner passes.
    pub axes: Vec<RegionAxis>,
    /// Lengths that are not cut.
    pub uncut: Vec<UncutLength>,
}

/// Inputs to make the passes of one plan.
pub struct PassMaker<'a> {
    channel: &'a Channel,
    tool: &'a Tool,
    setup: &'a Setup,
    walls: &'a [MilledWall],
    search: FixedAxisSearch<'a>,
    /// The finished surfaces, which must not be cut.
    finished: &'a FinishedPart,
    workpiece: &'a Workpiece,
    limits: FixedAxisLimits,
}

impl<'a> PassMaker<'a> {
    /// A maker for `tool` in the channel of `workpiece`; `walls` holds the axes fitted to its walls.
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup, tool: &'a Tool, walls: &'a [MilledWall]) -> Self {
        let limits = FixedAxisLimits {
            hub_allowance: setup.allowances.hub_allowance,
            blade_allowance: setup.allowances.blade_allowance,
            stock_height: setup.flank.layer_depth + setup.flank.scallop_height,
            max_tilt_rad: MAX_TILT,
            clearances: setup.clearances,
        };
        Self {
            channel: &workpiece.channel,
            tool,
            setup,
            walls,
            search: FixedAxisSearch::new(workpiece, tool, &limits),
            finished: &workpiece.finished,
            workpiece,
            limits,
        }
    }

    /// What the cutter or the holder collides with at a position; `None` if it is free.
    pub fn find_obstacle(&self, tip: Point, axis: Vector) -> Option<AxisObstacle> {
        self.search.find_obstacle(tip, axis)
    }

    /// Unit direction across the axis in which a cutter gets off the nearest blade, and the length of the way
    /// for each mm of distance from it; `None` where no blade is near, or its bottom cuts from above.
    pub fn way_off_blades(&self, tip: Point, axis: Vector) -> Option<(Vector, f64)> {
        let cutter = self.tool.placed(tip, axis);
        let near =
            self.finished.nearest_within(&cutter, self.setup.allowances.blade_allowance + NEAR_BLADE)?;
        let height = (near.point - tip).dot(&axis).max(cutter.corner_radius);
        let away = (tip + axis * height - near.point).try_normalize(1e-9)?;
        let across = away - axis * away.dot(&axis);
        let share = across.norm();
        (share >= MIN_ACROSS).then(|| (across / share, 1.0 / share))
    }

    /// Passes of one layer. `surface` is the layer offset by the corner radius, on which the tool rests.
    pub fn layer(
        &self,
        number: usize,
        found: &LayerLayout,
        chart: &LayerChart,
        surface: &DepthSurface,
    ) -> PlannedLayer {
        let layer = &found.layer;
        let milled = self
            .walls
            .iter()
            .map(|wall| WallPositions::new((self.tool, &self.search), (number, layer), wall))
            .collect();
        let on = LayerPassMaker { maker: self, layer, found, number, chart, surface, milled };
        let mut made = PlannedLayer { passes: Vec::new(), axes: Vec::new(), uncut: Vec::new() };
        let mut inner: Vec<(Region, Vec<LayerPoint>)> = Vec::new();
        for curve in &found.pass_curves {
            for CurvePiece { role, region, points } in split_by_region(chart, curve) {
                match role {
                    PassRole::Inner => inner.push((region, points)),
                    PassRole::Wall(wall) => on.along_wall(wall, region, &points, &mut made),
                }
            }
        }
        for RegionStretch { region, .. } in found.borders.regions(layer.from, layer.to) {
            let lines = inner.iter().filter(|(r, _)| *r == region).map(|(_, points)| points.clone());
            on.make_inner_passes(region, lines.collect(), &mut made);
        }
        made
    }
}

/// Whether a layer point is beyond `layer`, at the inlet, the rim, or above the shroud, by at least half of
/// `lead_in_out` (mm).
pub(super) fn is_open(layer: &LayerSurface, p: LayerPoint, lead_in_out: f64) -> bool {
    p.x <= layer.from - 0.5 * lead_in_out || p.x >= layer.to + 0.5 * lead_in_out
}

/// Inputs to make the passes of one layer.
struct LayerPassMaker<'a> {
    maker: &'a PassMaker<'a>,
    layer: &'a LayerSurface,
    found: &'a LayerLayout,
    number: usize,
    chart: &'a LayerChart<'a>,
    surface: &'a DepthSurface<'a>,
    milled: Vec<WallPositions>,
}

impl LayerPassMaker<'_> {
    /// Whether a layer point is beyond the part, at the inlet, the rim, or above the shroud.
    fn is_open(&self, p: LayerPoint) -> bool {
        is_open(self.layer, p, self.maker.setup.flank.lead_in_out_for(self.maker.tool))
    }

    fn contact(&self, p: LayerPoint) -> LayerContact {
        let (point, normal) = self.layer.point_and_normal(p);
        LayerContact { point, normal }
    }

    /// Records a length of passes (mm) as not cut, for a reason that no overhang removes.
    fn record_uncut(&self, made: &mut PlannedLayer, region: Region, length: f64, why: UncutReason) {
        self.record_uncut_by(made, region, length, (why, None));
    }

    /// Records a length of passes (mm) as not cut, with the overhang that would do.
    fn record_uncut_by(
        &self,
        made: &mut PlannedLayer,
        region: Region,
        length: f64,
        (why, overhang): (UncutReason, Option<f64>),
    ) {
        if length <= 0.0 {
            return;
        }
        match made.uncut.iter_mut().find(|l| l.region == region && l.why == why) {
            Some(known) => known.add(length, overhang),
            None => made.uncut.push(UncutLength { layer: self.number, region, length, why, overhang }),
        }
    }

    /// Adds the passes through `placed`: one, or several where the axis jumps. Positions are inserted where
    /// the axis turns far from one to the next.
    fn push_passes(
        &self,
        (role, region, group): (PassRole, Region, usize),
        placed: &[LayerPose],
        made: &mut PlannedLayer,
    ) {
        let corner = self.maker.tool.corner_radius;
        for run in placed.chunk_by(|a, b| a.axis.angle(&b.axis) <= MAX_PASS_TURN) {
            let [first, .., last] = run else { continue };
            let length: f64 = run.windows(2).map(|pair| (pair[1].tip - pair[0].tip).norm()).sum();
            if length < MIN_PASS * self.found.stepover {
                self.record_uncut(made, region, length, TOO_SHORT);
                continue;
            }
            let mut positions = vec![(first.tip, first.axis)];
            for pair in run.windows(2) {
                let (a, b) = (&pair[0], &pair[1]);
                let count = (a.axis.angle(&b.axis) / MAX_STEP_TURN).ceil().max(1.0);
                positions.extend((1..count as usize).map(|k| a.turned_to(b, k as f64 / count, corner)));
                positions.push((b.tip, b.axis));
            }
            let ends = [first.place, last.place];
            let open = ends.map(|end| self.is_open(end));
            made.passes.push(Pass { role, region, group, positions, ends, open, linked: true });
        }
    }

    /// The line with points added so that the straight moves between them stay within [`CHORD`] of the layer.
    fn densify(&self, line: &[LayerPoint]) -> Vec<LayerPoint> {
        let mut points = vec![line[0]];
        for w in line.windows(2) {
            let middle = w[0].lerp(w[1], 0.5);
            let bend = self.layer.max_curvature(middle.x);
            let step = (8.0 * CHORD / bend.max(1e-9)).sqrt().clamp(STEPS[0], STEPS[1]);
            let count = (self.layer.segment_length(w[0], w[1]) / step).ceil().max(1.0) as usize;
            points.extend((1..=count).map(|k| w[0].lerp(w[1], k as f64 / count as f64)));
        }
        points
    }
}
