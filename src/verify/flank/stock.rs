//! What a flank program leaves over the floor, and rapids that run into stock, by the heightfield.

use rayon::prelude::*;

use super::steps::Step;
use crate::geometry::{Point, Vector};
use crate::part::{Blank, Channel, Setup, Tool};
use crate::plunge::clearance::FinishedPart;
use crate::residual::{
    CutterStretch, FieldCutter, FloorGrid, FloorSource, ResidualField, ResidualStatistics, residual_field,
    statistics,
};

/// Cells of the floor along either direction.
const CELLS: usize = 256;
/// Ridges between the places at which a sweep is looked at, mm.
const RIDGE: f64 = 0.01;
/// Stock that a rapid may touch over its whole bottom, mm: what the field cannot tell from ridges.
const SKIM: f64 = 0.02;
/// Every how many cells the distance to the blades is measured.
const WALL_STRIDE: usize = 4;

/// A place of a rapid within the outline of the blank.
pub(super) struct RapidPlace {
    /// Index of the step.
    pub(super) step: usize,
    pub(super) share: f64,
}

/// What is left.
pub(super) struct Floor {
    /// Share of the reachable floor on which more stays than the hub's allowance, the allowed error, and what the corner of
    /// the cutter leaves in the corner of a wall.
    pub(super) uncovered_share: f64,
    /// The layer.
    pub(super) layer: ResidualStatistics,
    /// Rapids that run into stock: index of the step and volume, mm³.
    pub(super) rapids: Vec<(usize, f64)>,
}

/// Walks `steps` (of one channel) in order.
pub(super) fn floor_after(
    finished: &FinishedPart,
    channel: &Channel,
    setup: &Setup,
    blank: &Blank,
    tools: &[Tool],
    steps: &[&Step],
    rapids: &[RapidPlace],
) -> Floor {
    let largest = steps.iter().filter(|s| s.feed.is_some()).map(|s| &tools[s.tool]);
    let Some(finest) = largest.min_by(|a, b| a.corner_radius.total_cmp(&b.corner_radius)) else {
        return Floor { uncovered_share: 1.0, layer: ResidualStatistics::default(), rapids: Vec::new() };
    };
    let source = FloorSource {
        part: finished.part,
        channel,
        blank,
        stock: &setup.stock,
        cutters: &[CutterStretch { from: 1.0, to: 0.0, radius: finest.radius() }],
    };
    let grid = FloorGrid::new(&source, CELLS);
    let (cutters, owners) = swept(tools, steps, rapids);
    let field = residual_field(&grid, &cutters);
    let mut struck: Vec<(usize, f64)> = Vec::new();
    for (trace, owner) in field.traces.iter().zip(&owners) {
        let Some(step) = *owner else { continue };
        let volume = f64::from(trace.removed_volume);
        if volume > SKIM * std::f64::consts::PI * tools[steps[step].tool].radius().powi(2) {
            match struck.last_mut().filter(|(last, _)| *last == step) {
                Some((_, sum)) => *sum += volume,
                None => struck.push((step, volume)),
            }
        }
    }
    Floor {
        uncovered_share: uncovered(finished, setup, finest, &grid, &field),
        layer: statistics(&grid, &field.heights, |_| true),
        rapids: struck,
    }
}

/// The cutter at many places of all steps in order; for those of rapids the step.
fn swept(tools: &[Tool], steps: &[&Step], rapids: &[RapidPlace]) -> (Vec<FieldCutter>, Vec<Option<usize>>) {
    let (mut cutters, mut owners) = (Vec::new(), Vec::new());
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    let mut add = |step: &Step, share: f64, owner: Option<usize>| {
        let (tip, axis) = step.at(share);
        let tool = &tools[step.tool];
        cutters.push(FieldCutter {
            tip: single(tip.coords.into()),
            radius: tool.radius() as f32,
            axis: single(axis.into()),
            core_radius: 0.0,
            corner_radius: tool.corner_radius as f32,
        });
        owners.push(owner);
    };
    let mut rapids = rapids.iter().peekable();
    for (index, step) in steps.iter().enumerate() {
        if step.feed.is_some() {
            let spacing = (8.0 * tools[step.tool].radius() * RIDGE).sqrt();
            let count = (step.length() / spacing).max(step.turn() / 0.02).ceil().clamp(1.0, 2000.0);
            (1..=count as usize).for_each(|k| add(step, k as f64 / count, None));
        }
        while let Some(place) = rapids.next_if(|place| place.step == index) {
            add(step, place.share, Some(index));
        }
    }
    (cutters, owners)
}

/// See [`Floor::uncovered_share`].
fn uncovered(
    finished: &FinishedPart,
    setup: &Setup,
    tool: &Tool,
    grid: &FloorGrid,
    field: &ResidualField,
) -> f64 {
    let allowance = setup.stock.hub_allowance;
    let corner = tool.corner_radius;
    // How far a corner that touches the floor's allowance over a cell is from the blades, on a coarser grid.
    let nodes = CELLS / WALL_STRIDE;
    let room: Vec<f64> = (0..nodes * nodes)
        .into_par_iter()
        .map(|k| {
            let (i, j) =
                (k / nodes * WALL_STRIDE + WALL_STRIDE / 2, k % nodes * WALL_STRIDE + WALL_STRIDE / 2);
            let cell = i * grid.columns + j;
            let double = |v: [f32; 3]| v.map(f64::from);
            let up = Vector::from(double(grid.normals[cell]));
            let centre = Point::from(double(grid.points[cell])) + up * (allowance + corner);
            finished.blade_distance(&centre)
        })
        .collect();
    let reach = corner + setup.stock.blade_allowance;
    // What a corner leaves that cannot come nearer to the wall; a sharp one leaves nothing.
    let beside_wall = |i: usize, j: usize| {
        let at = |x: usize| ((x as f64 + 0.5) / WALL_STRIDE as f64 - 0.5).clamp(0.0, (nodes - 1) as f64);
        let (y, x) = (at(i), at(j));
        let (y0, x0) = ((y as usize).min(nodes - 2), (x as usize).min(nodes - 2));
        let node = |i: usize, j: usize| room[i * nodes + j];
        let (fy, fx) = (y - y0 as f64, x - x0 as f64);
        let row = |i: usize| node(i, x0) * (1.0 - fx) + node(i, x0 + 1) * fx;
        let lacking = (reach - (row(y0) * (1.0 - fy) + row(y0 + 1) * fy)).clamp(0.0, corner);
        corner - (corner * corner - lacking * lacking).max(0.0).sqrt()
    };
    let limit = allowance + setup.flank.allowed_error + 2.0 * RIDGE;
    let (mut left, mut all) = (0.0, 0.0);
    for cell in 0..grid.rows * grid.columns {
        if !grid.floor[cell] || !grid.reachable[cell] {
            continue;
        }
        let area = f64::from(grid.areas[cell]);
        all += area;
        let over = f64::from(field.heights[cell]) - limit;
        if over > 0.0 && over > beside_wall(cell / grid.columns, cell % grid.columns) {
            left += area;
        }
    }
    if all > 0.0 { left / all } else { 0.0 }
}
