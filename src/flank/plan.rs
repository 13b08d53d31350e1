//! The flank plan of a channel: passes, tool positions along them, and the program.

use std::sync::Arc;

use rayon::prelude::*;

use super::chart::LayerChart;
use super::choice::ChosenTool;
use super::curves::{FlankError, FlankLayout, LayoutInputs};
use super::fault_removal::{CheckedMoves, MoveCheck, MoveFault, remove_faults};
use super::opening::FlankOpening;
use super::passes::{PassMaker, PlannedLayer, RegionAxis};
use super::path::{FlankMove, LayerPasses, PathMaker, Times};
use super::region::{Region, WallName};
use super::uncut::UncutLength;
use super::wall::{MIN_WALL_TOLERANCE, MilledWall, SweptWall, WallFit, WallMilling};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::MeridionalCurve;
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::setup::{FlankFeedRates, FlankStrategy, Setup, Tool};

/// Allowed overcuts of the axes along a wall, mm: the first with a small undercut is used; if none has one,
/// the smallest.
const WALL_TOLERANCES: [f64; 3] = [MIN_WALL_TOLERANCE, 0.0025, 0.0045];
/// Undercut that counts as small, mm.
const MAX_SMALL_UNDERCUT: f64 = 0.005;
/// Reduction of the undercut per increase of the allowed overcut beyond which none is expected: the axes move
/// by the increase, and by their lever a little more.
const MAX_GAIN: f64 = 10.0;
/// Maximum distance between positions along a wall, mm, and maximum chord error of the straight moves between
/// them, mm.
const WALL_STEP: f64 = 4.0;
const WALL_CHORD: f64 = 5e-4;
/// Node spacing of the charts for links, mm.
const LINK_SPACING: f64 = 1.0;
/// A link may come nearer to a wall than a pass by this, mm: the error of the coarse chart is smaller.
const LINK_SLACK: f64 = 0.05;
/// Spacing of the points of the surface that the tool rests on, mm.
const GROUND_STEP: f64 = 0.5;

/// A flank plan of one channel.
#[derive(Clone, Debug)]
pub struct FlankPlan {
    /// The tool.
    pub tool: Tool,
    /// Why it was chosen; `None` where the setup names it.
    pub reason: Option<String>,
    /// The layers with their curves, and the comparison of strategies.
    pub layout: Arc<FlankLayout>,
    /// The walls with their fitted axes.
    pub walls: Arc<Vec<MilledWall>>,
    /// Fixed axes by layer and region.
    pub axes: Vec<RegionAxis>,
    /// Lengths of passes that are left out, with the reason.
    pub uncut: Vec<UncutLength>,
    /// What is cut before: plunges above the shroud, where the blank stands above it.
    pub opening: Option<FlankOpening>,
    /// The program.
    pub moves: Vec<FlankMove>,
    /// Faults that remain in the program.
    pub faults: Vec<MoveFault>,
    /// Feed rates by engagement.
    pub feeds: FlankFeedRates,
    /// Lengths and times.
    pub times: Times,
}

impl FlankPlan {
    /// The tools of its program: that of the passes, and that of the plunges before them.
    pub fn tools(&self) -> impl Iterator<Item = &Tool> {
        [&self.tool].into_iter().chain(self.opening.as_ref().map(|opening| &opening.tool))
    }

    /// Maximum overcut: depth cut below the blade allowance along the walls, mm.
    pub fn max_overcut(&self) -> f64 {
        self.walls.iter().map(|w| w.axes.max_overcut).fold(0.0, f64::max)
    }

    /// Maximum undercut: stock left above the blade allowance along the walls, mm.
    pub fn max_undercut(&self) -> f64 {
        self.walls.iter().map(|w| w.axes.max_undercut).fold(0.0, f64::max)
    }

    /// Maximum deviation that twist and bow of the walls force on a straight edge, mm.
    pub fn forced_deviation(&self) -> f64 {
        self.walls.iter().map(|w| w.axes.forced).fold(0.0, f64::max)
    }

    /// Number of positions at feed rate.
    pub fn positions(&self) -> usize {
        self.moves.iter().filter(|m| m.kind != super::path::MoveKind::Rapid).count()
    }
}

/// Stages of the last plan with their inputs, reused while these have not changed.
#[derive(Debug, Default)]
pub struct FlankStages {
    curves: Option<(Setup, Tool, Arc<FlankLayout>)>,
    walls: Option<(WallInputs, Tool, Arc<Vec<MilledWall>>)>,
}

/// The setup reduced to what the curves depend on; changes of the rest do not make them stale.
fn curve_inputs(setup: &Setup) -> Setup {
    let mut flank = setup.flank.clone();
    (
        flank.feed_mm_per_min,
        flank.slot_feed_mm_per_min,
        flank.wall_feed_mm_per_min,
        flank.ramp_feed_mm_per_min,
        flank.approach_feed_mm_per_min,
    ) = (None, None, None, None, None);
    flank.tool = None;
    let mut stock = setup.allowances.clone();
    stock.safety_distance = 0.0;
    Setup { allowances: stock, flank, ..Setup::default() }
}

/// Cache key of the axes along the walls: reduced setup and heights of the layers, mm.
type WallInputs = (Setup, Vec<f64>);

/// The setup reduced to what the axes along the walls depend on, and the heights of the layers, mm.
fn wall_inputs(setup: &Setup, curves: &FlankLayout) -> WallInputs {
    let mut inputs = curve_inputs(setup);
    let (lead_in_out, strategy) = (inputs.flank.lead_in_out, curves.strategy);
    inputs.flank = Setup::default().flank;
    inputs.flank.lead_in_out = lead_in_out;
    if strategy == FlankStrategy::Isoparametric {
        inputs.flank.strategy = strategy;
    }
    (inputs, curves.layers.iter().map(|l| l.layer.height).collect())
}

/// Plans the channel of `workpiece` with the chosen tool. `is_opened` says whether plunges that are made
/// before remove what stands above its shroud. The `stages` of an earlier plan of the same part are reused
/// where their inputs have not changed. Moves that `check` rejects are removed from the program.
///
/// # Errors
/// [`FlankError::Cancelled`] soon after `monitor` is cancelled; [`FlankError::Setup`] when the setup does not
/// suit the part.
pub fn plan(
    workpiece: &Workpiece,
    setup: &Setup,
    chosen: &ChosenTool,
    is_opened: bool,
    stages: &mut FlankStages,
    check: &mut MoveCheck,
    monitor: &Monitor,
) -> Result<FlankPlan, FlankError> {
    let tool = &chosen.tool;
    let source = LayoutInputs { workpiece, setup, tool };
    let known_curves = stages.curves.take().filter(|(s, t, _)| *s == curve_inputs(setup) && t == tool);
    let curves = match known_curves {
        Some((_, _, curves)) => curves,
        None => Arc::new(source.plan(monitor)?),
    };
    stages.curves = Some((curve_inputs(setup), tool.clone(), curves.clone()));
    monitor.report(0.2);
    let grounds =
        curves.layers.par_iter().map(|l| l.layer.extended_meridian(ground_beyond(setup, tool), GROUND_STEP));
    let grounds: Vec<MeridionalCurve> = grounds.collect();
    let surfaces: Vec<DepthSurface> =
        grounds.par_iter().map(|ground| DepthSurface::new(ground, tool.corner_radius)).collect();
    let inputs = wall_inputs(setup, &curves);
    let known_walls = stages.walls.take().filter(|(known, t, _)| *known == inputs && t == tool);
    let walls = match known_walls {
        Some((_, _, walls)) => walls,
        None => Arc::new(fit_walls(workpiece, setup, tool, &surfaces, monitor)),
    };
    monitor.check()?;
    stages.walls = Some((inputs, tool.clone(), walls.clone()));
    monitor.report(0.3);

    let maker = PassMaker::new(workpiece, setup, tool, &walls);
    let clear = tool.radius() + setup.allowances.blade_allowance;
    let beyond = setup.flank.lead_in_out_for(tool) + LINK_SPACING;
    let made: Vec<(LayerChart, PlannedLayer)> = curves
        .layers
        .par_iter()
        .enumerate()
        .with_max_len(1)
        .map(|(number, l)| {
            monitor.check()?;
            let chart = LayerChart::new(&l.layer, &l.borders, clear, l.stepover, LINK_SPACING, beyond);
            let made = maker.layer(number, l, &chart, &surfaces[number]);
            Ok((chart, made))
        })
        .collect::<Result<_, FlankError>>()?;
    monitor.report(0.8);
    let (charts, made): (Vec<LayerChart>, Vec<PlannedLayer>) = made.into_iter().unzip();

    let mut axes = Vec::new();
    let mut left_out = Vec::new();
    let mut layers: Vec<LayerPasses> = Vec::with_capacity(made.len());
    for (made, (found, chart)) in made.into_iter().zip(curves.layers.iter().zip(&charts)) {
        axes.extend(made.axes);
        left_out.extend(made.uncut);
        layers.push(LayerPasses {
            number: layers.len(),
            layer: &found.layer,
            stepover: found.stepover,
            corner_radius: tool.corner_radius,
            passes: made.passes,
            fits: Box::new(|p, tip, axis| {
                chart.wall_margin(p) >= -LINK_SLACK && maker.find_obstacle(tip, axis).is_none()
            }),
        });
    }
    // Cutting order is from the top down.
    layers.reverse();
    let feeds = setup.flank.feed_rates_for(tool);
    let path = PathMaker {
        tool,
        feeds,
        blank: &workpiece.blank,
        ramp_height: is_opened.then_some(setup.flank.layer_depth),
        safety_distance: setup.allowances.safety_distance,
    };
    monitor.report(0.85);
    let lead_in_out = setup.flank.lead_in_out_for(tool);
    let CheckedMoves { moves, left_out: more, faults } = remove_faults(
        &path,
        &mut layers,
        lead_in_out,
        &|tip, axis| maker.way_off_blades(tip, axis),
        check,
        monitor,
    )?;
    left_out.extend(more);
    left_out.sort_by_key(|left| left.layer);
    monitor.report(1.0);
    let times = Times::from_moves(&moves);
    drop(layers);
    drop(charts);
    Ok(FlankPlan {
        tool: tool.clone(),
        reason: chosen.reason.clone(),
        layout: curves,
        walls,
        axes,
        uncut: left_out,
        opening: None,
        moves,
        faults,
        feeds,
        times,
    })
}

/// Length by which the surface that the tool rests on extends beyond a layer, mm.
fn ground_beyond(setup: &Setup, tool: &Tool) -> f64 {
    setup.flank.lead_in_out_for(tool) + 4.0 * tool.radius()
}

/// All walls of the channel with axes fitted to them.
fn fit_walls(
    workpiece: &Workpiece,
    setup: &Setup,
    tool: &Tool,
    layers: &[DepthSurface],
    monitor: &Monitor,
) -> Vec<MilledWall> {
    let milling = WallMilling {
        tool,
        blade_allowance: setup.allowances.blade_allowance,
        hub_allowance: setup.allowances.hub_allowance,
        lead_in_out: setup.flank.lead_in_out_for(tool).max(1e-3),
        step: WALL_STEP,
        chord_error: WALL_CHORD,
    };
    let Workpiece { channel, finished, .. } = workpiece;
    let passages = channel.passages_at_outlet();
    let mut walls = vec![
        (WallName::Low, Region::INLET, &channel.full, 0),
        (WallName::High, Region::INLET, &channel.full, 1),
    ];
    for (number, beside) in passages.windows(2).enumerate() {
        let splitter = WallName::Splitter(number);
        let before = number.checked_sub(1).map_or(WallName::Low, WallName::Splitter);
        let is_last = number + 2 == passages.len();
        let after = if is_last { WallName::High } else { WallName::Splitter(number + 1) };
        walls.push((splitter, Region { low: before, high: splitter }, &beside[0], 1));
        walls.push((splitter, Region { low: splitter, high: after }, &beside[1], 0));
    }
    walls
        .into_par_iter()
        .filter(|_| !monitor.is_cancelled())
        .filter_map(|(wall, region, passage, number)| {
            let fit = WallFit::new(finished, passage, number, &milling, layers)?;
            let least = fit.sweep(WALL_TOLERANCES[0]);
            let is_small = |swept: &SweptWall| swept.map.max_undercut() <= MAX_SMALL_UNDERCUT;
            let others = || {
                let worth = |tolerance: f64| {
                    let gain = MAX_GAIN * (tolerance - WALL_TOLERANCES[0]);
                    least.map.max_undercut() - gain <= MAX_SMALL_UNDERCUT && !monitor.is_cancelled()
                };
                let mut more = WALL_TOLERANCES[1..].iter().filter(|&&tolerance| worth(tolerance));
                more.find_map(|&tolerance| Some(fit.sweep(tolerance)).filter(is_small))
            };
            let better = if is_small(&least) { None } else { others() };
            let swept = better.unwrap_or(least);
            Some(MilledWall { wall, region, axes: fit.axes(swept) })
        })
        .collect()
}
