//! Fillets at a blade's foot or tip. They belong to neither blade nor hub: the blade's sections are taken from between
//! them, and its sides run on straight from there.
//!
//! A blade's thickness changes evenly from hub to tip, so that at one height follows from those above it. Where a fillet
//! begins the blade is thicker than that, and the more so the nearer the hub.

use super::sides::Section;

/// Heights that are looked at from the middle of the blade to either end.
const STEPS: usize = 24;
/// Steps over which the change of thickness is taken.
const BASE: usize = 8;
/// How much thicker a blade is than it should be where a fillet has begun, mm per mm of its height …
const BEGUN: f64 = 1e-3;
/// … and at its end, nearly all along it: less is no fillet.
const WHOLE: f64 = 4e-3;
/// Zones along the blade that are judged each by itself: a fillet takes a larger share of the height where the blade is low.
const ZONES: usize = 6;
/// Places in each.
const PLACES: usize = 5;
/// Stretch of a side that is looked at: edges of a blade have shapes of their own.
const MIDDLE: (f64, f64) = (0.1, 0.9);
/// Share of a side in which the nearest point of the other side is looked for, either way.
const ASIDE: f64 = 0.15;

/// The heights of a blade between its fillets, of `low` to `high`; the same where it has none. `section` cuts the blade.
pub fn between_fillets(low: f64, high: f64, section: impl Fn(f64) -> Option<Section>) -> (f64, f64) {
    let middle = 0.5 * (low + high);
    let place = |end: f64, k: usize| middle + (end - middle) * k as f64 / STEPS as f64;
    let end = |end: f64| place(end, free_until(|k| section(place(end, k))));
    (end(low), end(high))
}

/// Number of the last section, counted from the middle towards an end, that no fillet has touched.
fn free_until(section: impl Fn(usize) -> Option<Section>) -> usize {
    let sections: Vec<Section> = (0..=STEPS).map_while(section).collect();
    let Some(last) = sections.len().checked_sub(1).filter(|last| *last > 3) else { return STEPS };
    let height = {
        let way = sections[0].sides[0].point(0.5) - sections[last].sides[0].point(0.5);
        2.0 * way.norm() * STEPS as f64 / last as f64
    };
    let thick: Vec<[f64; ZONES]> =
        sections.iter().map(|s| std::array::from_fn(|zone| thickness(s, zone))).collect();
    // In how many zones the blade is thicker at `k` by `share` of its height than the even change up to `from` lets expect.
    let thicker = |from: usize, k: usize, share: f64| {
        let base = BASE.min(from);
        let over = |zone: &usize| {
            let slope = (thick[from][*zone] - thick[from - base][*zone]) / base as f64;
            thick[k][*zone] - thick[from][*zone] - slope * (k - from) as f64
        };
        (0..ZONES).filter(|zone| over(zone) > share * height).count()
    };
    if let Some(begun) = (3..=last).find(|&k| thicker(k - 1, k, BEGUN) > 0) {
        // What has grown further at the end is a fillet; anything else is the blade's own shape.
        let free = begun.saturating_sub(2).max(1);
        if thicker(free, last, WHOLE) + 1 >= ZONES {
            return free;
        }
    }
    // Close to the end, where hub and blade meet, a cut may fall to pieces.
    if 3 * last >= 2 * STEPS && last < STEPS { last - 1 } else { STEPS }
}

/// Thickness of a section in a zone, mm: median of the distances from one side to the other.
fn thickness(section: &Section, zone: usize) -> f64 {
    let mut thick: [f64; PLACES] = std::array::from_fn(|i| {
        let share = (zone as f64 + (i as f64 + 0.5) / PLACES as f64) / ZONES as f64;
        let w = MIDDLE.0 + (MIDDLE.1 - MIDDLE.0) * share;
        let from = section.sides[0].point(w);
        let (mut nearest, mut reach) = ((w, f64::INFINITY), ASIDE);
        // First roughly, then closely about what was found.
        for _ in 0..2 {
            let about = nearest.0;
            for k in -20..=20 {
                let at = (about + reach * f64::from(k) / 20.0).clamp(0.0, 1.0);
                let distance = (section.sides[1].point(at) - from).norm();
                if distance < nearest.1 {
                    nearest = (at, distance);
                }
            }
            reach /= 15.0;
        }
        nearest.1
    });
    thick.sort_by(f64::total_cmp);
    thick[PLACES / 2]
}
