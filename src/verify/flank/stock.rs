//! Residual stock of a flank program over the floor, and collisions of rapids and holders with stock, by the
//! heightfield.

use std::sync::Arc;

use super::steps::CutterStep;
use super::uncovered::{SAMPLE_SCALLOP, Uncovered};
use crate::flank::fixed_axis::MAX_TILT;
use crate::geometry::CutterSolid;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::setup::{Setup, Tool};
use crate::stock::{
    CutterStretch, FieldCache, FieldCutter, FloorGrid, FloorSource, ResidualStatistics, statistics,
};

/// Cells of the floor along either direction.
const CELLS: usize = 256;
/// Stock that a rapid may touch over its whole bottom, mm: the field cannot distinguish it from scallops
/// between samples. Neither does a cutter cut where its flank only skims stock that stands beside it.
pub(super) const SKIM_DEPTH: f64 = 0.02;

/// A part of the tool that must not meet stock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StockProbe {
    /// The cutter in rapid.
    Rapid,
    /// The holder, under feed.
    Holder,
}

/// A sample of a step at which a probe is inside the outline of the blank.
pub(super) struct ProbeSample {
    /// Index of the step.
    pub(super) step: usize,
    pub(super) share: f64,
    pub(super) what: StockProbe,
}

/// A collision with stock; volume in mm³.
pub(super) struct StockCollision {
    /// Index of the step.
    pub(super) step: usize,
    pub(super) what: StockProbe,
    pub(super) volume: f64,
}

/// A floor after a program.
pub(super) struct FloorResult {
    /// Collisions with stock.
    pub(super) collisions: Vec<StockCollision>,
    /// Volume cut over the floor, mm³.
    pub(super) removed: f64,
    /// Depth of each step that removes stock, with its index: height above the bottom of the stock it
    /// removes, mm.
    pub(super) depths: Vec<(f64, usize)>,
    /// Residual stock, unless nothing is cut.
    left: Option<ResidualFloor>,
}

/// Residual stock over the floor.
struct ResidualFloor {
    grid: Arc<FloorGrid>,
    heights: Vec<f32>,
    /// The cutter with the smallest corner.
    finest: Tool,
}

impl FloorResult {
    /// The floor with too much stock, and statistics of the residual stock.
    ///
    /// # Errors
    /// When cancelled.
    pub(super) fn figures(
        &self,
        workpiece: &Workpiece,
        setup: &Setup,
        monitor: &Monitor,
    ) -> Result<(Uncovered, ResidualStatistics), Cancelled> {
        Ok(match &self.left {
            Some(ResidualFloor { grid, heights, finest }) => {
                let uncovered = Uncovered::from_workpiece(workpiece, setup, finest, grid, heights, monitor)?;
                (uncovered, statistics(grid, heights, |_| true))
            }
            None => (Uncovered { gap: 1.0, ..Uncovered::default() }, ResidualStatistics::default()),
        })
    }
}

/// The floor of a channel, with what is known of it after the last program.
pub(super) struct FloorCache {
    /// Radius of the cutter by which the floor was divided into cells.
    radius: f64,
    field: FieldCache,
}

impl FloorCache {
    /// The floor for cutters of which `finest` has the smallest corner; for more than one program where it
    /// `keeps` what it knows of the last.
    fn new(workpiece: &Workpiece, setup: &Setup, finest: &Tool, keeps: bool) -> Self {
        let radius = finest.radius();
        let cutters = &[CutterStretch { from: 1.0, to: 0.0, radius, tool: finest.number }];
        let source = FloorSource { workpiece, stock: &setup.allowances, cutters, max_tilt_rad: MAX_TILT };
        let grid = FloorGrid::new(&source, CELLS);
        Self { radius, field: if keeps { FieldCache::new(grid) } else { FieldCache::for_one(grid) } }
    }
}

/// The steps of one channel in order, as a sweep of cutters over the floor.
pub(super) struct Sweep<'a> {
    pub(super) tools: &'a [Tool],
    pub(super) steps: &'a [&'a CutterStep],
    /// Where probes are inside the blank, by step.
    pub(super) places: &'a [ProbeSample],
    /// Width of the rim of a cutter whose stock does not count for the depth of a cut, mm.
    pub(super) rim: f64,
}

/// Applies a sweep. `cache` is `None`, or of the same workpiece and setup, and
/// whether it keeps what the next program may begin with.
pub(super) fn evaluate_floor(
    workpiece: &Workpiece,
    setup: &Setup,
    sweep: &Sweep<'_>,
    (cache, keeps): (&mut Option<FloorCache>, bool),
) -> FloorResult {
    let Sweep { tools, steps, .. } = *sweep;
    let largest = steps.iter().filter(|s| s.feed.is_some()).map(|s| &tools[s.tool]);
    let Some(finest) = largest.min_by(|a, b| a.corner_radius.total_cmp(&b.corner_radius)) else {
        return FloorResult { collisions: Vec::new(), removed: 0.0, depths: Vec::new(), left: None };
    };
    let known = cache.take().filter(|known| known.radius == finest.radius());
    let cache = cache.insert(known.unwrap_or_else(|| FloorCache::new(workpiece, setup, finest, keeps)));
    let (cutters, owners) = sweep_cutters(sweep);
    let field = cache.field.residual_field(cutters);
    let mut struck: Vec<StockCollision> = Vec::new();
    let (mut removed, mut depths): (f64, Vec<(f64, usize)>) = (0.0, Vec::new());
    for (trace, owner) in field.traces.iter().zip(&owners) {
        let volume = f64::from(trace.removed_volume);
        let (step, what) = match *owner {
            Owner::Struck(step, what) => (step, what),
            Owner::Cut(step) => {
                removed += volume;
                let depth = f64::from(trace.contact_depth);
                match depths.last_mut().filter(|last| last.1 == step) {
                    _ if volume <= 0.0 => {}
                    Some(last) => last.0 = last.0.max(depth),
                    None => depths.push((depth, step)),
                }
                continue;
            }
        };
        if volume > SKIM_DEPTH * std::f64::consts::PI * tools[steps[step].tool].radius().powi(2) {
            match struck.last_mut().filter(|last| last.step == step && last.what == what) {
                Some(last) => last.volume += volume,
                None => struck.push(StockCollision { step, what, volume }),
            }
        }
    }
    let left = ResidualFloor {
        grid: Arc::clone(cache.field.grid()),
        heights: field.heights,
        finest: finest.clone(),
    };
    FloorResult { collisions: struck, removed, depths, left: Some(left) }
}

/// Origin of a cutter of the field.
#[derive(Clone, Copy)]
enum Owner {
    /// A cut of this step.
    Cut(usize),
    /// A probe of this step.
    Struck(usize, StockProbe),
}

/// The cutter sampled along all steps in order, with the probes at the `places` of each step before its cuts.
/// For cuts the core is the whole cutter but its rim, so the contact depth is the depth of cut.
fn sweep_cutters(&Sweep { tools, steps, places, rim }: &Sweep<'_>) -> (Vec<FieldCutter>, Vec<Owner>) {
    let (mut cutters, mut owners) = (Vec::new(), Vec::new());
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    let mut add = |solid: CutterSolid, owner: Owner| {
        cutters.push(FieldCutter {
            tip: single(solid.tip.coords.into()),
            radius: solid.radius as f32,
            axis: single(solid.axis.into()),
            core_radius: match owner {
                Owner::Cut(_) => (solid.radius - rim).max(0.0) as f32,
                Owner::Struck(..) => 0.0,
            },
            corner_radius: solid.corner_radius as f32,
        });
        owners.push(owner);
    };
    let mut places = places.iter().peekable();
    for (index, step) in steps.iter().enumerate() {
        let tool = &tools[step.tool];
        while let Some(place) = places.next_if(|place| place.step == index) {
            let solid = match place.what {
                StockProbe::Rapid => step.cutter(tools, place.share),
                StockProbe::Holder => {
                    let (tip, axis) = step.at(place.share);
                    tool.holder(tip, axis)
                }
            };
            add(solid, Owner::Struck(index, place.what));
        }
        if step.feed.is_some() {
            let spacing = (8.0 * tool.radius() * SAMPLE_SCALLOP).sqrt();
            let count = (step.length() / spacing).max(step.turn() / 0.02).ceil().clamp(1.0, 2000.0);
            (1..=count as usize).for_each(|k| add(step.cutter(tools, k as f64 / count), Owner::Cut(index)));
        }
    }
    (cutters, owners)
}
