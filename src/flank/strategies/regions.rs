//! Strategy by regions [flank paper, steps 1–8 of the new tool path curves]: in each region both walls are
//! offset towards each other, and each offset is kept where its own wall is the nearer one. In the middle
//! gaps of up to two stepovers may remain.

use super::pass_curve::{PassCurve, layer_margin, own_wall_margin};
use crate::flank::chart::LayerChart;

/// The curves of a layer, with lead-in and lead-out of `beyond` mm.
pub fn regions(chart: &LayerChart, beyond: f64) -> Vec<PassCurve> {
    let mut curves = Vec::new();
    for wall in chart.walls() {
        for (k, line) in chart.offsets(wall).iter().enumerate() {
            let own = chart.min_wall_distance + chart.stepover * k as f64;
            let pieces = chart.clip(line, |p| {
                let region = chart.borders.region(p);
                let Some(other) = region.and_then(|region| region.facing(wall)) else { return -1.0 };
                let ahead = chart.borders.ahead_of(p.x).map(|splitter| chart.distance(splitter.name(), p));
                let free = ahead.fold(f64::INFINITY, f64::min) - chart.min_wall_distance;
                let facing = chart.distance(other, p) - own;
                facing.min(layer_margin(chart, p, beyond)).min(free).min(own_wall_margin(chart, wall, own, p))
            });
            curves.extend(pieces.into_iter().map(|points| PassCurve::new(chart, wall, k, points)));
        }
    }
    curves
}
