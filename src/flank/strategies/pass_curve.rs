//! The curve of a pass on a layer, and its margins to the ends of the layer and to its own wall.

use crate::flank::chart::LayerChart;
use crate::flank::layer::{LayerPoint, LayerSurface};
use crate::flank::region::{Region, WallName};

/// Tolerance of the distance of an offset from its wall, in stepovers: more than the error of the chart.
const OFFSET_TOLERANCE: f64 = 0.02;

/// Purpose of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassRole {
    /// Along a wall at the least distance: here the flank of the cutter mills the blade.
    Wall(WallName),
    /// Between the walls.
    Inner,
}

/// The curve of a pass on a layer, without tool axes.
#[derive(Clone, Debug)]
pub struct PassCurve {
    /// Purpose of the pass.
    pub role: PassRole,
    /// Region of its middle.
    pub region: Region,
    /// Its points, including lead-in and lead-out beyond the ends of the layer.
    pub points: Vec<LayerPoint>,
}

impl PassCurve {
    pub(super) fn new(chart: &LayerChart, wall: WallName, number: usize, points: Vec<LayerPoint>) -> Self {
        let role = if number == 0 { PassRole::Wall(wall) } else { PassRole::Inner };
        let region = chart.borders.region(points[points.len() / 2]).unwrap_or(Region::INLET);
        Self { role, region, points }
    }

    /// Length within the ends of the layer, mm.
    pub fn length(&self, layer: &LayerSurface) -> f64 {
        self.points
            .windows(2)
            .map(|p| layer.segment_length(p[0], p[1]) * share_inside(layer, p[0].x, p[1].x))
            .sum()
    }
}

/// Share of the interval from `a` to `b` (x) within the ends of the layer.
fn share_inside(layer: &LayerSurface, a: f64, b: f64) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    if high - low < 1e-12 {
        return if (layer.from..=layer.to).contains(&low) { 1.0 } else { 0.0 };
    }
    ((high.min(layer.to) - low.max(layer.from)) / (high - low)).max(0.0)
}

/// Not negative between the walls, within the layer and its lead-in and lead-out of `beyond` mm, measured
/// along the meridian.
pub(super) fn layer_margin(chart: &LayerChart, p: LayerPoint, beyond: f64) -> f64 {
    let inside = (p.x - chart.layer.from + beyond).min(chart.layer.to + beyond - p.x);
    // Arcs round a nose continue into the next channel.
    if inside >= 0.0 && chart.borders.have_noses() && !chart.is_between(p) { -1.0 } else { inside }
}

/// Not negative where an offset is not nearer to its own wall than it should be; behind focal points it is.
pub(super) fn own_wall_margin(chart: &LayerChart, wall: WallName, offset: f64, p: LayerPoint) -> f64 {
    chart.distance(wall, p) - offset + OFFSET_TOLERANCE * chart.stepover
}
