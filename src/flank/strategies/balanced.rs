//! Balanced strategy: one fan from one wall, the first offset of the other wall, and an arc round the
//! splitter's nose. No gap is wider than the stepover, and no more passes are used than that needs.
//!
//! Upstream of the splitter the channel is not divided. The fan of one main blade runs from the inlet into
//! the passage beside it. The fan of the other blade fills the rest, up to the last offset of the first fan
//! that passes the nose on its own side. All curves run smoothly past the nose, and none ends within the
//! channel.

use super::{PassCurve, layer_margin, own_wall_margin};
use crate::flank::chart::{LayerChart, Region, WallName};

/// The curves of a layer, with lead-in and lead-out of `beyond` mm: the shorter of the two results with
/// either main blade first.
pub fn balanced(chart: &LayerChart, beyond: f64) -> Vec<PassCurve> {
    let length = |curves: &[PassCurve]| curves.iter().map(|c| c.length(chart.layer)).sum::<f64>();
    let [a, b] = [WallName::Low, WallName::High].map(|main| fans(chart, beyond, main));
    if length(&b) < length(&a) { b } else { a }
}

fn fans(chart: &LayerChart, beyond: f64, main: WallName) -> Vec<PassCurve> {
    let (other, own_side) = match main {
        WallName::Low => (WallName::High, Region::LowSide),
        _ => (WallName::Low, Region::HighSide),
    };
    let clear = chart.min_wall_distance;
    let at = |k: usize| clear + chart.stepover * k as f64;
    // Number of the last offset of the first fan that passes the nose on its own side; without a splitter all
    // do.
    let last = chart.borders.splitter.as_ref().map(|splitter| {
        let nose = chart.distance(main, splitter.nose);
        if nose.is_finite() { ((nose - clear) / chart.stepover).floor().max(0.0) as usize } else { 0 }
    });
    let mut curves = Vec::new();
    for wall in [main, other, WallName::Splitter] {
        for (k, line) in chart.offsets(wall).iter().enumerate() {
            let pieces = chart.clip(line, |p| {
                let Some(region) = chart.region(p) else { return -1.0 };
                let free_of = |wall: WallName| chart.distance(wall, p) - clear;
                let of_splitter = free_of(WallName::Splitter);
                let keep = match (wall, region, last) {
                    (WallName::Splitter, ..) if k > 0 => -1.0,
                    (WallName::Splitter, ..) => free_of(main).min(free_of(other)),
                    (w, Region::Inlet, None) if w == main || k == 0 => {
                        free_of(if w == main { other } else { main })
                    }
                    (_, Region::Inlet, None) => -1.0,
                    (w, Region::Inlet, Some(last)) if w == main && k > last => -1.0,
                    (w, Region::Inlet, Some(_)) if w == main => free_of(other).min(of_splitter),
                    (_, Region::Inlet, Some(last)) => {
                        let reached = if k == 0 { clear } else { at(last) };
                        (chart.distance(main, p) - reached).min(of_splitter)
                    }
                    (w, side, _) if (w == main) == (side == own_side) => of_splitter,
                    _ => -1.0,
                };
                keep.min(layer_margin(chart, p, beyond)).min(own_wall_margin(chart, wall, at(k), p))
            });
            curves.extend(pieces.into_iter().map(|points| PassCurve::new(chart, wall, k, points)));
        }
    }
    curves
}
