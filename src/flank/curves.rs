//! Passes on all layers of a channel by every strategy, and figures to compare the strategies.

use rayon::prelude::*;

use super::chart::LayerChart;
use super::layer::{LayerPoint, LayerSurface};
use super::layer_walls::LayerWalls;
use super::stepover::stepover;
use super::strategies::{self, PassCurve, PassRole};
use crate::error::{ErrorCode, UserError};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::setup::{FlankStrategy, Setup, SetupFault, SetupPlace, Tool, round_down, round_up};

/// Maximum number of layers of a channel.
const MAX_LAYERS: usize = 1000;
/// Maximum number of passes side by side.
const MAX_ACROSS: f64 = 2000.0;
/// If the number of layers exceeds an integer by less than this, the layers become a little deeper instead of
/// one more.
const COUNT_SLACK: f64 = 0.05;
/// Nodes of the chart per stepover, and the limits of their spacing, mm.
const NODES_PER_STEPOVER: f64 = 6.0;
const NODE_SPACING: [f64; 2] = [0.05, 1.0];
/// Distance of an offset from the straight lines of which it is made where a wall is extended, in stepovers:
/// half of what is tolerated of the distance of an offset from its wall.
const EXTENSION_SAG: f64 = 0.01;
/// A gap counts as wide above this multiple of the stepover.
const WIDE: f64 = 1.02;
/// Gaps are measured up to this multiple of the stepover.
pub const WIDEST_GAP: f64 = 2.5;

/// Why the planning of passes failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlankError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The setup does not suit the part.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<FlankError> for UserError {
    fn from(error: FlankError) -> Self {
        match error {
            FlankError::Cancelled(cancelled) => cancelled.into(),
            FlankError::Setup(fault) => fault.into(),
        }
    }
}

/// How well passes cover a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Largest gap between neighbouring passes as a multiple of the stepover: twice the largest distance of a
    /// reachable point from the nearest pass. Measured up to 2.5.
    pub largest_gap: f64,
    /// Area in gaps wider than 1.02 times the stepover, mm².
    pub wide_area: f64,
}

/// Figures of one strategy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrategyFigures {
    /// Number of passes.
    pub passes: usize,
    /// Their length within the channel, mm.
    pub length: f64,
    /// How they cover the layer.
    pub coverage: Coverage,
}

/// A layer with the passes of one strategy.
#[derive(Clone, Debug)]
pub struct LayerLayout {
    /// The surface.
    pub layer: LayerSurface,
    /// Its walls.
    pub borders: LayerWalls,
    /// Stepover: largest allowed distance between neighbouring passes, mm.
    pub stepover: f64,
    /// The passes of the requested strategy.
    pub pass_curves: Vec<PassCurve>,
    /// By strategy, in the order of [`FlankStrategy::ALL`]. Those of the isoparametric strategy are set only
    /// where it was requested, and then no others are.
    pub figures: [StrategyFigures; 4],
    /// Area that the tool axis may reach, mm².
    pub area: f64,
    /// Lower bound on the length of passes: the area over the stepover, and half the length of the passes
    /// along walls, mm.
    pub floor_length: f64,
    /// Length of the lines where the fans of two walls meet, mm.
    pub seam_length: f64,
}

/// All layers of a channel.
#[derive(Clone, Debug)]
pub struct FlankLayout {
    /// Strategy of the setup.
    pub requested: FlankStrategy,
    /// Strategy of the passes: the requested one, or `Isoparametric` where `Layers` would be longer.
    pub strategy: FlankStrategy,
    /// The layers of that strategy, hub first.
    pub layers: Vec<LayerLayout>,
    /// Figures by strategy over all layers, in the order of [`FlankStrategy::ALL`].
    pub totals: [StrategyFigures; 4],
    /// Area that the tool axis may reach on the layers of constant depth, mm².
    pub area: f64,
    /// Lower bound on the length of passes there, mm.
    pub floor_length: f64,
    /// Length of the lines there where the fans of two walls meet, mm.
    pub seam_length: f64,
    /// Layers of constant depth on which the tool fits nowhere, by their height above the hub, mm.
    pub empty: Vec<f64>,
}

impl FlankLayout {
    /// What a user has to know where the passes are not by the requested strategy; `None` where they are.
    pub fn replacement_note(&self) -> Option<String> {
        (self.strategy != self.requested).then(|| {
            let [written, requested] = [self.strategy, self.requested].map(FlankStrategy::name);
            format!("{requested} would be longer than {written} here: {written} is written")
        })
    }

    /// Share of the area of a strategy in gaps wider than 1.02 times the stepover.
    pub fn wide_share(&self, strategy: FlankStrategy) -> f64 {
        let area = match strategy {
            FlankStrategy::Isoparametric => self.layers.iter().map(|l| l.area).sum(),
            _ => self.area,
        };
        self.totals[strategy as usize].coverage.wide_area / f64::max(area, 1e-9)
    }
}

/// Inputs of the planning of passes.
#[derive(Clone, Copy, Debug)]
pub struct LayoutInputs<'a> {
    /// The part and its channel.
    pub workpiece: &'a Workpiece,
    /// Allowances and `[flank]`.
    pub setup: &'a Setup,
    /// The tool.
    pub tool: &'a Tool,
}

impl LayoutInputs<'_> {
    /// Least distance of the tool axis from a wall, mm.
    fn clear(&self) -> f64 {
        self.tool.radius() + self.setup.allowances.blade_allowance
    }

    /// Depth of the channel where it is deepest: at the leading edge along it, elsewhere above the hub, mm.
    fn deepest(&self) -> f64 {
        const STATIONS: usize = 32;
        let (hub, shroud) = (&self.workpiece.part.hub, &self.workpiece.part.shroud);
        let above_hub = |k: usize| hub.curve().project(shroud.point(k as f64 / STATIONS as f64)).1.abs();
        (1..=STATIONS).map(above_hub).fold(hub.point(0.0).distance(shroud.point(0.0)), f64::max)
    }

    /// Number of layers where the channel is deepest.
    ///
    /// # Errors
    /// When the layer depth is not positive, exceeds the channel, or gives too many layers.
    fn layer_count(&self) -> Result<usize, SetupFault> {
        let (depth, height) = (self.setup.flank.layer_depth, self.deepest());
        let fault = |what: String, help: String| {
            Err(SetupFault::new(ErrorCode::LayerDepth, what, help).at(SetupPlace::Flank("layer_depth")))
        };
        if depth.is_nan() || depth <= 0.0 {
            return fault(format!("the depth of a layer is {depth} mm"), "give more than 0".to_owned());
        }
        if depth > height {
            return fault(
                format!("a layer of {depth} mm is deeper than the channel, {height:.2} mm"),
                format!("give at most {:.2}", round_down(height, 2)),
            );
        }
        let count = (height / depth - COUNT_SLACK).ceil().max(1.0);
        if count > MAX_LAYERS as f64 {
            return fault(
                format!("a layer depth of {depth} mm makes {count} layers"),
                format!("give at least {:.3} mm", round_up(height / MAX_LAYERS as f64, 3)),
            );
        }
        Ok(count as usize)
    }

    /// Plans the passes of all strategies; those of the strategy in the setup are kept. Where layers of
    /// constant depth would have longer passes than isoparametric ones, as few layers on a low channel may,
    /// these are kept instead.
    ///
    /// # Errors
    /// [`FlankError::Cancelled`] after a cancellation; [`FlankError::Setup`] where the layer depth or the
    /// scallop height is unusable or the tool fits nowhere.
    pub fn plan(&self, monitor: &Monitor) -> Result<FlankLayout, FlankError> {
        use FlankStrategy::{Isoparametric, Layers};
        let requested = self.plan_by(self.setup.flank.strategy, monitor)?;
        let length = |strategy: FlankStrategy| requested.totals[strategy as usize].length;
        if requested.strategy != Layers || length(Layers) <= length(Isoparametric) {
            return Ok(requested);
        }
        match self.plan_by(Isoparametric, monitor) {
            Ok(shorter) => Ok(FlankLayout { requested: Layers, ..shorter }),
            Err(FlankError::Cancelled(cancelled)) => Err(cancelled.into()),
            // Where the tool fits on none of the isoparametric layers they are no alternative.
            Err(FlankError::Setup(_)) => Ok(requested),
        }
    }

    fn plan_by(&self, strategy: FlankStrategy, monitor: &Monitor) -> Result<FlankLayout, FlankError> {
        let count = self.layer_count()?;
        let depth = self.setup.flank.layer_depth;
        // The lowest layer keeps the allowance of the hub.
        let heights = (0..count).map(|j| (j as f64 * depth).max(self.setup.allowances.hub_allowance));
        let deep: Vec<f64> = heights.collect();
        let baseline = |j: usize| -> Result<Option<LayerLayout>, FlankError> {
            monitor.check()?;
            let eta = j as f64 / count as f64;
            let Some(layer) =
                LayerSurface::isoparametric(&self.workpiece.part, eta, self.setup.allowances.hub_allowance)
            else {
                return Ok(None);
            };
            self.isoparametric_layer(layer, strategy == FlankStrategy::Isoparametric)
        };
        let ours = |j: usize| -> Result<Option<LayerLayout>, FlankError> {
            monitor.check()?;
            let Some(layer) = LayerSurface::at_height(&self.workpiece.part, deep[j]) else { return Ok(None) };
            self.layer(layer, strategy)
        };
        // One parallel list for both kinds of layers, so that no core idles. The layers next to the hub take
        // longest and come first.
        let done: Vec<Option<LayerLayout>> = (0..2 * count)
            .into_par_iter()
            .with_max_len(1)
            .map(|k| if k % 2 == 0 { ours(k / 2) } else { baseline(k / 2) })
            .collect::<Result<_, _>>()?;
        let mut result = FlankLayout {
            requested: strategy,
            strategy,
            layers: Vec::with_capacity(count),
            totals: [StrategyFigures::default(); 4],
            area: 0.0,
            floor_length: 0.0,
            seam_length: 0.0,
            empty: Vec::new(),
        };
        for (k, layer) in done.into_iter().enumerate() {
            let ours = k % 2 == 0;
            let Some(layer) = layer else {
                if ours {
                    result.empty.push(deep[k / 2]);
                }
                continue;
            };
            if ours {
                result.area += layer.area;
                result.floor_length += layer.floor_length;
                result.seam_length += layer.seam_length;
            }
            for (total, here) in result.totals.iter_mut().zip(&layer.figures) {
                total.passes += here.passes;
                total.length += here.length;
                total.coverage.largest_gap = total.coverage.largest_gap.max(here.coverage.largest_gap);
                total.coverage.wide_area += here.coverage.wide_area;
            }
            if ours != (strategy == FlankStrategy::Isoparametric) {
                result.layers.push(layer);
            }
        }
        if result.layers.iter().all(|layer| layer.area <= 0.0) {
            return Err(SetupFault::new(
                ErrorCode::CutterTooWide,
                format!("the cutter of D {} fits nowhere between the blades", self.tool.diameter),
                "give a thinner one, or a smaller blade allowance",
            )
            .at(SetupPlace::Tool(self.tool.number))
            .into());
        }
        Ok(result)
    }

    /// The walls on `layer`, traced `raised` mm above it.
    fn borders(&self, layer: &LayerSurface, raised: f64) -> Option<LayerWalls> {
        let Workpiece { part, channel, .. } = self.workpiece;
        let sag = EXTENSION_SAG * stepover(self.tool, self.setup.flank.scallop_height, 0.0);
        LayerWalls::from_part(part, channel, layer, self.beyond() + 2.0 * self.tool.radius(), raised, sag)
    }

    fn beyond(&self) -> f64 {
        self.setup.flank.lead_in_out_for(self.tool)
    }

    /// The stepover on `layer`, mm: the minimum over stations along the walls, by the curvature across them.
    ///
    /// # Errors
    /// When it is 0, or so small that there would be more than [`MAX_ACROSS`] passes side by side.
    fn layer_stepover(&self, layer: &LayerSurface, borders: &LayerWalls) -> Result<f64, SetupFault> {
        const STATIONS: usize = 20;
        let error = self.setup.flank.scallop_height;
        let mut least = f64::INFINITY;
        for k in 0..=STATIONS {
            let x = layer.from + (layer.to - layer.from) * k as f64 / STATIONS as f64;
            for wall in [&borders.low, &borders.high] {
                let ahead = x + 1e-3 * (layer.to - layer.from);
                let [a, b] = [x, ahead].map(|x| LayerPoint { x, y: wall.y_at(x) });
                let bulge = layer.curvature_across(x, layer.heading(a, b));
                least = least.min(stepover(self.tool, error, bulge));
            }
        }
        let pitch = layer.radius(layer.to).0 * (borders.high.y_at(layer.to) - borders.low.y_at(layer.to));
        if least.is_nan() || least * MAX_ACROSS <= pitch {
            return Err(SetupFault::new(
                ErrorCode::FineScallop,
                format!(
                    "a scallop height of {error} mm gives a stepover of {least:.4} mm: more than \
                     {MAX_ACROSS} passes side by side"
                ),
                "give a greater scallop height, or a tool with a larger corner radius",
            )
            .at(SetupPlace::Flank("scallop_height")));
        }
        Ok(least)
    }

    fn chart<'c>(&self, layer: &'c LayerSurface, borders: &'c LayerWalls, stepover: f64) -> LayerChart<'c> {
        let spacing = (stepover / NODES_PER_STEPOVER).clamp(NODE_SPACING[0], NODE_SPACING[1]);
        LayerChart::new(layer, borders, self.clear(), stepover, spacing, self.beyond())
    }

    /// A layer of constant depth with the passes of `strategy`.
    fn layer(&self, layer: LayerSurface, strategy: FlankStrategy) -> Result<Option<LayerLayout>, FlankError> {
        let Some(borders) = self.borders(&layer, self.tool.corner_radius) else { return Ok(None) };
        let stepover = self.layer_stepover(&layer, &borders)?;
        let (clear, beyond) = (self.clear(), self.beyond());
        let chart = self.chart(&layer, &borders, stepover);
        let nodes = FreeNodes::from_chart(&chart);
        let mut by_strategy = [
            Vec::new(),
            strategies::isoparametric_by_region(&layer, &borders, clear, stepover, beyond),
            strategies::regions(&chart, beyond),
            strategies::balanced(&chart, beyond),
        ];
        let walls: f64 = by_strategy[FlankStrategy::Balanced as usize]
            .iter()
            .filter(|curve| matches!(curve.role, PassRole::Wall(_)))
            .map(|curve| curve.length(&layer))
            .sum();
        let mut figures = [StrategyFigures::default(); 4];
        for (figures, curves) in figures.iter_mut().zip(&by_strategy).skip(1) {
            *figures = nodes.measure(&chart, curves);
        }
        let seam_length = chart.seam_length();
        let (area, floor_length) = (nodes.area, nodes.area / stepover + 0.5 * walls);
        let curves = std::mem::take(&mut by_strategy[strategy as usize]);
        Ok(Some(LayerLayout {
            layer,
            borders,
            stepover,
            pass_curves: curves,
            figures,
            area,
            floor_length,
            seam_length,
        }))
    }

    /// A layer of the isoparametric baseline; its coverage only where `wanted`.
    fn isoparametric_layer(
        &self,
        layer: LayerSurface,
        wanted: bool,
    ) -> Result<Option<LayerLayout>, FlankError> {
        // As published: offsets start from the walls where they cross the layer itself.
        let Some(borders) = self.borders(&layer, 0.0) else { return Ok(None) };
        let stepover = self.layer_stepover(&layer, &borders)?;
        let curves = strategies::isoparametric(&layer, &borders, self.clear(), stepover, self.beyond());
        let mut figures = [StrategyFigures::default(); 4];
        let mut area = 0.0;
        figures[0] = if wanted {
            let chart = self.chart(&layer, &borders, stepover);
            let nodes = FreeNodes::from_chart(&chart);
            area = nodes.area;
            nodes.measure(&chart, &curves)
        } else {
            let length = curves.iter().map(|c| c.length(&layer)).sum();
            StrategyFigures { passes: curves.len(), length, coverage: Coverage::default() }
        };
        let (floor_length, seam_length) = (0.0, 0.0);
        Ok(Some(LayerLayout {
            layer,
            borders,
            stepover,
            pass_curves: curves,
            figures,
            area,
            floor_length,
            seam_length,
        }))
    }
}

/// The nodes of a layer that passes have to cover.
struct FreeNodes {
    nodes: Vec<super::chart::ChartNode>,
    area: f64,
}

impl FreeNodes {
    fn from_chart(chart: &LayerChart) -> Self {
        let nodes = chart.free_nodes();
        let area = nodes.iter().map(|n| n.free_area).sum();
        Self { nodes, area }
    }

    fn measure(&self, chart: &LayerChart, curves: &[PassCurve]) -> StrategyFigures {
        let reach = 0.5 * WIDEST_GAP * chart.stepover;
        let nearest = chart.nearest_curve(curves.iter().map(|c| c.points.as_slice()), reach);
        let mut coverage = Coverage::default();
        for node in &self.nodes {
            let gap = 2.0 * nearest[node.index].min(reach) / chart.stepover;
            coverage.largest_gap = coverage.largest_gap.max(gap);
            if gap > WIDE {
                coverage.wide_area += node.free_area;
            }
        }
        let length = curves.iter().map(|c| c.length(chart.layer)).sum();
        StrategyFigures { passes: curves.len(), length, coverage }
    }
}
