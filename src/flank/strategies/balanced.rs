//! Balanced strategy: in each region the fan of one wall, the first offset of the other wall, and arcs round
//! the noses of splitters. No gap is wider than the stepover, and no more passes are used than that needs.
//!
//! The fan of a region is that of the wall that begins further upstream; of two main blades either is tried.
//! Where a splitter divides the region downstream, this fan runs on beside it, and the fan of the other wall
//! fills the rest, up to the last offset of the first fan that passes the nose on its own side. So curves run
//! smoothly past the nose, and none ends within a channel with one splitter. Where a splitter divides the
//! passage beside another, fans change at the nose of the first.

use super::pass_curve::{PassCurve, layer_margin, own_wall_margin};
use crate::flank::chart::LayerChart;
use crate::flank::layer_regions::RegionStretch;
use crate::flank::region::{Region, WallName};

/// The curves of a layer, with lead-in and lead-out of `beyond` mm: the shorter of the two results with
/// either main blade first.
pub fn balanced(chart: &LayerChart, beyond: f64) -> Vec<PassCurve> {
    let length = |curves: &[PassCurve]| curves.iter().map(|c| c.length(chart.layer)).sum::<f64>();
    let [a, b] = [WallName::Low, WallName::High].map(|main| fans(chart, beyond, main));
    if length(&b) < length(&a) { b } else { a }
}

/// How the fans of both walls share a region.
struct FanShares {
    region: Region,
    /// The wall whose fan fills the region.
    main: WallName,
    /// Number of its last offset that passes the nose of the splitter that divides the region on its own
    /// side; `None` where none does.
    last: Option<usize>,
}

impl FanShares {
    fn from_chart(chart: &LayerChart, region: Region, first: WallName) -> Self {
        let begins = |wall| chart.borders.splitter(wall).map_or(f64::NEG_INFINITY, |s| s.nose.x);
        let Region { low, high } = region;
        let main = match () {
            () if region == Region::INLET => first,
            () if begins(high) < begins(low) => high,
            () => low,
        };
        let last = chart.borders.divider(region).map(|splitter| {
            let nose = chart.distance(main, splitter.nose);
            let passing = (nose - chart.min_wall_distance) / chart.stepover;
            if nose.is_finite() { passing.floor().max(0.0) as usize } else { 0 }
        });
        Self { region, main, last }
    }
}

fn fans(chart: &LayerChart, beyond: f64, first: WallName) -> Vec<PassCurve> {
    let (clear, borders) = (chart.min_wall_distance, chart.borders);
    let at = |k: usize| clear + chart.stepover * k as f64;
    let stretches = borders.regions(chart.layer.from, chart.layer.to);
    let shares: Vec<FanShares> = stretches
        .iter()
        .map(|RegionStretch { region, .. }| FanShares::from_chart(chart, *region, first))
        .collect();
    let second = if first == WallName::Low { WallName::High } else { WallName::Low };
    let splitters = borders.splitters.iter().map(|splitter| splitter.name());
    let mut curves = Vec::new();
    for wall in [first, second].into_iter().chain(splitters) {
        for (k, line) in chart.offsets(wall).iter().enumerate() {
            let pieces = chart.clip(line, |p| {
                let shares = borders.region(p).and_then(|region| shares.iter().find(|s| s.region == region));
                let Some(FanShares { region, main, last }) = shares else { return -1.0 };
                let others = chart.walls().filter(|other| *other != wall);
                let free = others.map(|other| chart.distance(other, p)).fold(f64::INFINITY, f64::min) - clear;
                let keep = match region.facing(wall) {
                    // Round the nose of a splitter ahead.
                    None if k == 0 && borders.ahead_of(p.x).any(|ahead| ahead.name() == wall) => free,
                    None => -1.0,
                    Some(_) if wall == *main => match last {
                        Some(last) if k > *last => -1.0,
                        _ => free,
                    },
                    Some(_) => match last {
                        None if k > 0 => -1.0,
                        None => free,
                        Some(last) => {
                            let reached = if k == 0 { clear } else { at(*last) };
                            free.min(chart.distance(*main, p) - reached)
                        }
                    },
                };
                keep.min(layer_margin(chart, p, beyond)).min(own_wall_margin(chart, wall, at(k), p))
            });
            curves.extend(pieces.into_iter().map(|points| PassCurve::new(chart, wall, k, points)));
        }
    }
    curves
}
