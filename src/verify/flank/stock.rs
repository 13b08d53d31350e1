//! What a flank program leaves over the floor, and rapids and holders that run into stock, by the heightfield.

use super::steps::Step;
use super::uncovered::Uncovered;
use crate::geometry::CutterSolid;
use crate::part::{Blank, Channel, Setup, Tool};
use crate::plunge::clearance::FinishedPart;
use crate::residual::{
    CutterStretch, FieldCutter, FloorGrid, FloorSource, ResidualStatistics, residual_field, statistics,
};

/// Cells of the floor along either direction.
const CELLS: usize = 256;
/// Ridges between the places at which a sweep is looked at, mm.
pub(super) const RIDGE: f64 = 0.01;
/// Stock that a rapid may touch over its whole bottom, mm: what the field cannot tell from ridges.
const SKIM: f64 = 0.02;

/// What must not meet stock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Probe {
    /// The cutter in rapid.
    Rapid,
    /// The holder, under feed.
    Holder,
}

/// A place at which one of them is within the outline of the blank.
pub(super) struct Place {
    /// Index of the step.
    pub(super) step: usize,
    pub(super) share: f64,
    pub(super) what: Probe,
}

/// Stock that was met, mm³.
pub(super) struct Struck {
    /// Index of the step.
    pub(super) step: usize,
    pub(super) what: Probe,
    pub(super) volume: f64,
}

/// A floor after a program.
pub(super) struct Floor {
    /// What ran into stock.
    pub(super) struck: Vec<Struck>,
    /// What was cut over the floor, mm³.
    pub(super) removed: f64,
    /// How deep each step cuts, with its index: how far above the bottom the stock that it removes reaches, mm. Steps that
    /// remove nothing are missing.
    pub(super) depths: Vec<(f64, usize)>,
    /// What is left, unless nothing is cut.
    left: Option<Left>,
}

/// What is left over the floor.
struct Left {
    grid: FloorGrid,
    heights: Vec<f32>,
    /// The cutter with the smallest corner.
    finest: Tool,
}

impl Floor {
    /// Where more stays than may, and the layer.
    pub(super) fn figures(
        &self,
        finished: &FinishedPart,
        channel: &Channel,
        blank: &Blank,
        setup: &Setup,
    ) -> (Uncovered, ResidualStatistics) {
        match &self.left {
            Some(Left { grid, heights, finest }) => (
                Uncovered::of(finished, channel, blank, setup, finest, grid, heights),
                statistics(grid, heights, |_| true),
            ),
            None => (Uncovered { gap: 1.0, ..Uncovered::default() }, ResidualStatistics::default()),
        }
    }
}

/// Walks `steps` (of one channel) in order.
pub(super) fn floor_after(
    finished: &FinishedPart,
    channel: &Channel,
    setup: &Setup,
    blank: &Blank,
    tools: &[Tool],
    steps: &[&Step],
    places: &[Place],
) -> Floor {
    let largest = steps.iter().filter(|s| s.feed.is_some()).map(|s| &tools[s.tool]);
    let Some(finest) = largest.min_by(|a, b| a.corner_radius.total_cmp(&b.corner_radius)) else {
        return Floor { struck: Vec::new(), removed: 0.0, depths: Vec::new(), left: None };
    };
    let source = FloorSource {
        part: finished.part,
        channel,
        blank,
        stock: &setup.stock,
        cutters: &[CutterStretch { from: 1.0, to: 0.0, radius: finest.radius() }],
    };
    let grid = FloorGrid::new(&source, CELLS);
    let (cutters, owners) = swept(tools, steps, places);
    let field = residual_field(&grid, &cutters);
    let mut struck: Vec<Struck> = Vec::new();
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
        if volume > SKIM * std::f64::consts::PI * tools[steps[step].tool].radius().powi(2) {
            match struck.last_mut().filter(|last| last.step == step && last.what == what) {
                Some(last) => last.volume += volume,
                None => struck.push(Struck { step, what, volume }),
            }
        }
    }
    let left = Left { grid, heights: field.heights, finest: finest.clone() };
    Floor { struck, removed, depths, left: Some(left) }
}

/// Whose a cutter of a field is.
#[derive(Clone, Copy)]
enum Owner {
    /// Under feed in this step.
    Cut(usize),
    /// What must not meet stock in this step.
    Struck(usize, Probe),
}

/// The cutter at many places of all steps in order, after each step's `places` of what must not meet stock: a holder before
/// the cut that it is over, a rapid where it is. The core of those that cut is all of them: its contact is how deep they cut.
fn swept(tools: &[Tool], steps: &[&Step], places: &[Place]) -> (Vec<FieldCutter>, Vec<Owner>) {
    let (mut cutters, mut owners) = (Vec::new(), Vec::new());
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    let mut add = |solid: CutterSolid, owner: Owner| {
        cutters.push(FieldCutter {
            tip: single(solid.tip.coords.into()),
            radius: solid.radius as f32,
            axis: single(solid.axis.into()),
            core_radius: if matches!(owner, Owner::Cut(_)) { solid.radius as f32 } else { 0.0 },
            corner_radius: solid.corner_radius as f32,
        });
        owners.push(owner);
    };
    let mut places = places.iter().peekable();
    for (index, step) in steps.iter().enumerate() {
        let tool = &tools[step.tool];
        while let Some(place) = places.next_if(|place| place.step == index) {
            let solid = match place.what {
                Probe::Rapid => step.cutter(tools, place.share),
                Probe::Holder => {
                    let (tip, axis) = step.at(place.share);
                    tool.holder(tip, axis)
                }
            };
            add(solid, Owner::Struck(index, place.what));
        }
        if step.feed.is_some() {
            let spacing = (8.0 * tool.radius() * RIDGE).sqrt();
            let count = (step.length() / spacing).max(step.turn() / 0.02).ceil().clamp(1.0, 2000.0);
            (1..=count as usize).for_each(|k| add(step.cutter(tools, k as f64 / count), Owner::Cut(index)));
        }
    }
    (cutters, owners)
}
