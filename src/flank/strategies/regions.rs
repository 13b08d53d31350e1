//! Strategy by regions [flank paper, steps 1–8 of the new tool path curves]: in each region both walls are
//! offset towards each other, and each offset is kept where its own wall is the nearer one. In the middle
//! gaps of up to two stepovers may remain.

use super::{PassCurve, layer_margin, own_wall_margin};
use crate::flank::chart::{LayerChart, Region, WallName};

/// The curves of a layer, with lead-in and lead-out of `beyond` mm.
pub fn regions(chart: &LayerChart, beyond: f64) -> Vec<PassCurve> {
    let mut curves = Vec::new();
    for wall in WallName::ALL {
        for (k, line) in chart.offsets(wall).iter().enumerate() {
            let own = chart.min_wall_distance + chart.stepover * k as f64;
            let pieces = chart.clip(line, |p| {
                let Some(region) = chart.region(p) else { return -1.0 };
                let Some(other) = facing(wall, region) else { return -1.0 };
                let mut keep = (chart.distance(other, p) - own).min(layer_margin(chart, p, beyond));
                if region == Region::Inlet {
                    keep = keep.min(chart.distance(WallName::Splitter, p) - chart.min_wall_distance);
                }
                keep.min(own_wall_margin(chart, wall, own, p))
            });
            curves.extend(pieces.into_iter().map(|points| PassCurve::new(chart, wall, k, points)));
        }
    }
    curves
}

/// The wall opposite `wall` in a region; `None` where `wall` does not bound it.
fn facing(wall: WallName, region: Region) -> Option<WallName> {
    use Region::{HighSide, Inlet, LowSide};
    use WallName::{High, Low, Splitter};
    match (wall, region) {
        (High, Inlet) | (Splitter, LowSide) => Some(Low),
        (Low, Inlet) | (Splitter, HighSide) => Some(High),
        (Low, LowSide) | (High, HighSide) => Some(Splitter),
        (Splitter, Inlet) | (Low, HighSide) | (High, LowSide) => None,
    }
}
