//! All layers of a channel with their curves, by every scheme, and how the schemes compare.

use rayon::prelude::*;

use super::border::Borders;
use super::chart::Chart;
use super::interval::interval;
use super::layer::{Layer, LayerPoint};
use super::schemes::{self, Curve, Role};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Channel, FlankScheme, Impeller, Setup, Tool};
use crate::plunge::sections::{SetupFault, SetupPlace};

/// Most layers of a channel.
const MAX_LAYERS: usize = 1000;
/// Most curves side by side.
const MAX_ACROSS: f64 = 2000.0;
/// A layer's depth short of a whole number by less than this share is a little deeper instead of one more.
const COUNT_SLACK: f64 = 0.05;
/// Nodes of the chart to an interval, and their spacing at most and at least, mm.
const NODES_PER_INTERVAL: f64 = 6.0;
const NODE_SPACING: [f64; 2] = [0.05, 1.0];
/// A gap counts as wide above this many intervals.
const WIDE: f64 = 1.02;
/// Gaps are measured up to this many intervals.
const WIDEST_GAP: f64 = 2.5;

/// Why there are no curves.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlankError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part and setup do not go together.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

/// How well curves cover a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Greatest gap between neighbouring curves, in intervals: twice the greatest distance of a reachable place from the
    /// nearest curve. Measured up to 2.5.
    pub largest_gap: f64,
    /// Area in gaps wider than 1.02 intervals, mm².
    pub wide_area: f64,
}

/// Curves of one scheme on one layer, measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurveFigures {
    /// Number of curves.
    pub curves: usize,
    /// Their length within the channel, mm.
    pub length: f64,
    /// How they cover the layer.
    pub coverage: Coverage,
}

/// A layer with the curves of one scheme.
#[derive(Clone, Debug)]
pub struct LayerCurves {
    /// The surface.
    pub layer: Layer,
    /// Its walls.
    pub borders: Borders,
    /// Largest distance between neighbouring curves, mm.
    pub interval: f64,
    /// The curves of the scheme that was asked for.
    pub curves: Vec<Curve>,
    /// By scheme, in the order of [`FlankScheme::ALL`]; of the isoparametric one only where it was asked for, and then
    /// nothing else.
    pub figures: [CurveFigures; 4],
    /// Area where the cutter's axis may be, mm².
    pub area: f64,
    /// Least length that could cover it: the area over the interval, and half the curves along the walls, mm.
    pub floor_length: f64,
    /// Length of the lines where the fans of two walls meet, mm.
    pub seam_length: f64,
}

/// All layers of a channel.
#[derive(Clone, Debug)]
pub struct FlankCurves {
    /// Scheme of the curves.
    pub scheme: FlankScheme,
    /// The layers of that scheme, hub first.
    pub layers: Vec<LayerCurves>,
    /// Figures by scheme over all layers, in the order of [`FlankScheme::ALL`].
    pub totals: [CurveFigures; 4],
    /// Sums over the layers of constant depth, mm², mm, mm.
    pub area: f64,
    /// See `area`.
    pub floor_length: f64,
    /// See `area`.
    pub seam_length: f64,
    /// Layers of constant depth on which the cutter fits nowhere, by their height above the hub, mm.
    pub empty: Vec<f64>,
}

impl FlankCurves {
    /// Share of the area in gaps wider than 1.02 intervals, of the scheme asked for.
    pub fn wide_share(&self, scheme: FlankScheme) -> f64 {
        let area = match scheme {
            FlankScheme::Isoparametric => self.layers.iter().map(|l| l.area).sum(),
            _ => self.area,
        };
        self.totals[scheme as usize].coverage.wide_area / f64::max(area, 1e-9)
    }
}

/// What curves are planned from.
#[derive(Clone, Copy, Debug)]
pub struct CurveSource<'a> {
    /// The part.
    pub part: &'a Impeller,
    /// Its channel.
    pub channel: &'a Channel,
    /// Allowances and `[flank]`.
    pub setup: &'a Setup,
    /// The cutter.
    pub tool: &'a Tool,
}

impl CurveSource<'_> {
    /// Least distance of the cutter's axis from a wall, mm.
    fn clear(&self) -> f64 {
        self.tool.radius() + self.setup.stock.blade_allowance
    }

    /// Height of the leading edge, mm.
    fn leading_edge(&self) -> f64 {
        self.part.hub.point(0.0).distance(self.part.shroud.point(0.0))
    }

    /// Number of layers at the leading edge.
    ///
    /// # Errors
    /// When the depth is none, or makes too many.
    fn layer_count(&self) -> Result<usize, SetupFault> {
        let (depth, height) = (self.setup.flank.layer_depth, self.leading_edge());
        let fault = |what: String, cure: String| {
            Err(SetupFault::new(what, cure).at(SetupPlace::Flank("layer_depth")))
        };
        if depth.is_nan() || depth <= 0.0 {
            return fault(format!("the depth of a layer is {depth} mm"), "give more than 0".to_owned());
        }
        if depth > height {
            return fault(
                format!(
                    "a layer of {depth} mm is deeper than the channel, {height:.2} mm at the leading edge"
                ),
                format!("give at most {height:.2}"),
            );
        }
        let count = (height / depth - COUNT_SLACK).ceil().max(1.0);
        if count > MAX_LAYERS as f64 {
            return fault(
                format!("a layer depth of {depth} mm makes {count} layers"),
                format!("give at least {:.3} mm", height / MAX_LAYERS as f64),
            );
        }
        Ok(count as usize)
    }

    /// Plans the curves of all schemes; those of the setup's scheme are kept.
    ///
    /// # Errors
    /// [`FlankError`].
    pub fn plan(&self, monitor: &Monitor) -> Result<FlankCurves, FlankError> {
        let scheme = self.setup.flank.scheme;
        let count = self.layer_count()?;
        let depth = self.setup.flank.layer_depth;
        // The lowest layer keeps the allowance of the hub.
        let heights = (0..count).map(|j| (j as f64 * depth).max(self.setup.stock.hub_allowance));
        let deep: Vec<f64> = heights.collect();
        let baseline = |j: usize| -> Result<Option<LayerCurves>, FlankError> {
            monitor.check()?;
            let eta = j as f64 / count as f64;
            let Some(layer) = Layer::isoparametric(self.part, eta, self.setup.stock.hub_allowance) else {
                return Ok(None);
            };
            self.isoparametric_layer(layer, scheme == FlankScheme::Isoparametric)
        };
        let ours = |j: usize| -> Result<Option<LayerCurves>, FlankError> {
            monitor.check()?;
            let Some(layer) = Layer::at_height(self.part, deep[j]) else { return Ok(None) };
            self.layer(layer, scheme)
        };
        // One list, so that no core waits: the layers next to the hub are the longest and come first.
        let done: Vec<Option<LayerCurves>> = (0..2 * count)
            .into_par_iter()
            .with_max_len(1)
            .map(|k| if k % 2 == 0 { ours(k / 2) } else { baseline(k / 2) })
            .collect::<Result<_, _>>()?;
        let mut result = FlankCurves {
            scheme,
            layers: Vec::with_capacity(count),
            totals: [CurveFigures::default(); 4],
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
                total.curves += here.curves;
                total.length += here.length;
                total.coverage.largest_gap = total.coverage.largest_gap.max(here.coverage.largest_gap);
                total.coverage.wide_area += here.coverage.wide_area;
            }
            if ours != (scheme == FlankScheme::Isoparametric) {
                result.layers.push(layer);
            }
        }
        if result.layers.iter().all(|layer| layer.area <= 0.0) {
            return Err(SetupFault::new(
                format!("the cutter of D {} fits nowhere between the blades", self.tool.diameter),
                "give a thinner one, or a smaller blade allowance",
            )
            .at(SetupPlace::Tool(self.tool.number))
            .into());
        }
        Ok(result)
    }

    /// The walls on `layer`, taken `raised` mm above it.
    fn borders(&self, layer: &Layer, raised: f64) -> Option<Borders> {
        Borders::of(self.part, self.channel, layer, self.beyond() + 2.0 * self.tool.radius(), raised)
    }

    fn beyond(&self) -> f64 {
        self.setup.flank.extension_of(self.tool)
    }

    /// The interval on `layer`: the least that its curvature across the walls asks for.
    ///
    /// # Errors
    /// When it is nothing, or so small that curves would be without number.
    fn interval(&self, layer: &Layer, borders: &Borders) -> Result<f64, SetupFault> {
        const STATIONS: usize = 20;
        let error = self.setup.flank.allowed_error;
        let mut least = f64::INFINITY;
        for k in 0..=STATIONS {
            let x = layer.from + (layer.to - layer.from) * k as f64 / STATIONS as f64;
            for wall in [&borders.low, &borders.high] {
                let ahead = x + 1e-3 * (layer.to - layer.from);
                let [a, b] = [x, ahead].map(|x| LayerPoint { x, y: wall.y_at(x) });
                let bulge = layer.bulge_across(x, layer.heading(a, b));
                least = least.min(interval(self.tool, error, bulge));
            }
        }
        let pitch = layer.radius(layer.to).0 * (borders.high.y_at(layer.to) - borders.low.y_at(layer.to));
        if least.is_nan() || least * MAX_ACROSS <= pitch {
            return Err(SetupFault::new(
                format!("an error of {error} mm leaves {least:.4} mm between curves: more than {MAX_ACROSS} side by side"),
                "allow a greater error, or give a cutter with a larger corner",
            )
            .at(SetupPlace::Flank("allowed_error")));
        }
        Ok(least)
    }

    fn chart<'c>(&self, layer: &'c Layer, borders: &'c Borders, interval: f64) -> Chart<'c> {
        let spacing = (interval / NODES_PER_INTERVAL).clamp(NODE_SPACING[0], NODE_SPACING[1]);
        Chart::new(layer, borders, self.clear(), interval, spacing, self.beyond())
    }

    /// A layer of constant depth with the curves of `scheme`.
    fn layer(&self, layer: Layer, scheme: FlankScheme) -> Result<Option<LayerCurves>, FlankError> {
        let Some(borders) = self.borders(&layer, self.tool.corner_radius) else { return Ok(None) };
        let interval = self.interval(&layer, &borders)?;
        let (clear, beyond) = (self.clear(), self.beyond());
        let chart = self.chart(&layer, &borders, interval);
        let nodes = Nodes::of(&chart);
        let mut by_scheme = [
            Vec::new(),
            schemes::isoparametric_by_region(&layer, &borders, clear, interval, beyond),
            schemes::regions(&chart, beyond),
            schemes::balanced(&chart, beyond),
        ];
        let walls: f64 = by_scheme[FlankScheme::Balanced as usize]
            .iter()
            .filter(|curve| matches!(curve.role, Role::Wall(_)))
            .map(|curve| curve.length(&layer))
            .sum();
        let mut figures = [CurveFigures::default(); 4];
        for (figures, curves) in figures.iter_mut().zip(&by_scheme).skip(1) {
            *figures = nodes.measure(&chart, curves);
        }
        let seam_length = chart.seam_length();
        let (area, floor_length) = (nodes.area, nodes.area / interval + 0.5 * walls);
        let curves = std::mem::take(&mut by_scheme[scheme as usize]);
        Ok(Some(LayerCurves { layer, borders, interval, curves, figures, area, floor_length, seam_length }))
    }

    /// A layer of the baseline; its coverage only where `wanted`.
    fn isoparametric_layer(&self, layer: Layer, wanted: bool) -> Result<Option<LayerCurves>, FlankError> {
        // As published, from the walls where they cross the layer.
        let Some(borders) = self.borders(&layer, 0.0) else { return Ok(None) };
        let interval = self.interval(&layer, &borders)?;
        let curves = schemes::isoparametric(&layer, &borders, self.clear(), interval, self.beyond());
        let mut figures = [CurveFigures::default(); 4];
        let mut area = 0.0;
        figures[0] = if wanted {
            let chart = self.chart(&layer, &borders, interval);
            let nodes = Nodes::of(&chart);
            area = nodes.area;
            nodes.measure(&chart, &curves)
        } else {
            let length = curves.iter().map(|c| c.length(&layer)).sum();
            CurveFigures { curves: curves.len(), length, coverage: Coverage::default() }
        };
        let (floor_length, seam_length) = (0.0, 0.0);
        Ok(Some(LayerCurves { layer, borders, interval, curves, figures, area, floor_length, seam_length }))
    }
}

/// The places of a layer that curves have to cover.
struct Nodes {
    nodes: Vec<super::chart::Node>,
    area: f64,
}

impl Nodes {
    fn of(chart: &Chart) -> Self {
        let nodes = chart.free_nodes();
        let area = nodes.iter().map(|n| n.free_area).sum();
        Self { nodes, area }
    }

    fn measure(&self, chart: &Chart, curves: &[Curve]) -> CurveFigures {
        let reach = 0.5 * WIDEST_GAP * chart.interval;
        let nearest = chart.nearest_curve(curves.iter().map(|c| c.points.as_slice()), reach);
        let mut coverage = Coverage::default();
        for node in &self.nodes {
            let gap = 2.0 * nearest[node.index].min(reach) / chart.interval;
            coverage.largest_gap = coverage.largest_gap.max(gap);
            if gap > WIDE {
                coverage.wide_area += node.free_area;
            }
        }
        let length = curves.iter().map(|c| c.length(chart.layer)).sum();
        CurveFigures { curves: curves.len(), length, coverage }
    }
}
