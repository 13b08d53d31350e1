//! Fillets at a blade's foot or tip. They belong to neither blade nor hub: the blade's sections are taken from between
//! them, and its sides run on straight from there.
//!
//! A blade's thickness changes evenly from hub to tip, so that at one height follows from those above it. Where a fillet
//! begins the blade is thicker than that, and the more so the nearer the hub.

use super::sides::Section;
use crate::geometry::{Point, Vector};

/// Heights that are looked at from the middle of the blade to either end.
const STEPS: usize = 24;
/// Steps over which the change of thickness is taken.
const BASE: usize = 8;
/// How much thicker a blade is than it should be where a fillet has begun, mm per mm of its height …
const BEGUN: f64 = 1e-3;
/// … and at its end: less is no fillet.
const WHOLE: f64 = 4e-3;
/// Zones along the blade that are judged each by itself: a fillet takes a larger share of the height where the blade is low.
const ZONES: usize = 6;
/// Places in each.
const PLACES: usize = 5;
/// Stretch of a side that is looked at: edges of a blade have shapes of their own.
const MIDDLE: (f64, f64) = (0.1, 0.9);

/// The heights of a blade between its fillets, of `low` to `high`; the same where it has none. `section` cuts the blade.
pub fn between_fillets(low: f64, high: f64, section: impl Fn(f64) -> Option<Section>) -> (f64, f64) {
    let middle = 0.5 * (low + high);
    let place = |end: f64, k: usize| middle + (end - middle) * k as f64 / STEPS as f64;
    let end = |end: f64| place(end, free_until(|k| section(place(end, k))));
    (end(low), end(high))
}

/// Number of the last section, counted from the middle towards an end, that no fillet has touched.
fn free_until(section: impl Fn(usize) -> Option<Section>) -> usize {
    // Within a fillet, a cut may fall to pieces.
    let sections: Vec<Section> = (0..=STEPS).map_while(section).collect();
    let Some(last) = sections.len().checked_sub(1).filter(|last| *last > 3) else { return STEPS };
    let height = 2.0 * (at(&sections[0], 0.5) - at(&sections[last], 0.5)).norm() * STEPS as f64 / last as f64;
    let thick: Vec<[f64; ZONES]> =
        sections.iter().map(|s| std::array::from_fn(|zone| thickness(s, zone))).collect();
    // Thicker at `k` than the even change up to `from` lets expect.
    let over = |from: usize, k: usize| {
        let base = BASE.min(from);
        let of_zone = |zone: usize| {
            let slope = (thick[from][zone] - thick[from - base][zone]) / base as f64;
            thick[k][zone] - thick[from][zone] - slope * (k - from) as f64
        };
        (0..ZONES).map(of_zone).fold(f64::NEG_INFINITY, f64::max)
    };
    let Some(begun) = (3..=last).find(|&k| over(k - 1, k) > BEGUN * height) else { return STEPS };
    // What has grown further at the end is a fillet; anything else is the blade's own shape.
    let free = begun.saturating_sub(2).max(1);
    if over(free, last) > WHOLE * height { free } else { STEPS }
}

/// Middle of a section.
fn at(section: &Section, w: f64) -> Point {
    nalgebra::center(&section.sides[0].point(w), &section.sides[1].point(w))
}

/// Thickness of a section in a zone, mm: median.
fn thickness(section: &Section, zone: usize) -> f64 {
    let mut thick: [f64; PLACES] = std::array::from_fn(|i| {
        let share = (zone as f64 + (i as f64 + 0.5) / PLACES as f64) / ZONES as f64;
        let w = MIDDLE.0 + (MIDDLE.1 - MIDDLE.0) * share;
        let across = section.sides[0].point(w) - section.sides[1].point(w);
        let along: Vector = at(section, w + 0.02) - at(section, w - 0.02);
        // At right angles to the middle line.
        (across.norm_squared() - across.dot(&along).powi(2) / along.norm_squared().max(1e-300))
            .max(0.0)
            .sqrt()
    });
    thick.sort_by(f64::total_cmp);
    thick[PLACES / 2]
}
