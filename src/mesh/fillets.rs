//! Fillets at a blade's foot or tip. They belong to neither blade nor hub: the blade's sections are taken from between
//! them, and its sides run on straight from there.
//!
//! Away from a fillet a side bends slowly from hub to tip, so the section at one height follows from the three above it.
//! Where a fillet begins, the section is wider than that, on both sides, and the more so the nearer the hub.

use super::sides::Section;
use crate::geometry::{Point, Vector};

/// Heights that are looked at from the middle of the blade to either end.
const STEPS: usize = 24;
/// How much wider a section is than it should be where a fillet has begun, mm per mm of the blade's height …
const BEGUN: f64 = 1e-3;
/// … and at the end of the blade: less is no fillet.
const WHOLE: f64 = 4e-3;
/// Zones along the blade that are judged each by itself: a fillet takes a larger share of the height where the blade is low.
const ZONES: usize = 6;
/// Places in each, on each side.
const PLACES: usize = 5;
/// Stretch of a side that is looked at: edges of a blade have shapes of their own.
const MIDDLE: (f64, f64) = (0.1, 0.9);

/// The heights of a blade between its fillets, of `low` to `high`; the same where it has none. `section` cuts the blade.
pub fn between_fillets(low: f64, high: f64, section: impl Fn(f64) -> Option<Section>) -> (f64, f64) {
    let middle = 0.5 * (low + high);
    let towards = |end: f64| free_until(|k| section(middle + (end - middle) * k as f64 / STEPS as f64));
    let to = |end: f64, free: usize| middle + (end - middle) * free as f64 / STEPS as f64;
    (to(low, towards(low)), to(high, towards(high)))
}

/// Number of the last section, counted from the middle towards an end, that no fillet has touched.
fn free_until(section: impl Fn(usize) -> Option<Section>) -> usize {
    let mut sections: Vec<Section> = Vec::with_capacity(STEPS + 1);
    for k in 0..=STEPS {
        match section(k) {
            Some(section) => sections.push(section),
            // Within a fillet, a cut may fall to pieces.
            None => break,
        }
    }
    let Some(last) = sections.len().checked_sub(1).filter(|last| *last > 3) else { return STEPS };
    let height = (at(&sections[0], 0, 0.5) - at(&sections[last], 0, 0.5)).norm() * STEPS as f64 / last as f64;
    let wider = |from: usize, k: usize| {
        (0..ZONES).map(|zone| widening(&sections, from, k, zone)).fold(f64::NEG_INFINITY, f64::max)
    };
    let begun = (3..=last).find(|&k| wider(k - 1, k) > 2.0 * BEGUN * height);
    let Some(begun) = begun else { return STEPS };
    // What has grown further at the end is a fillet; anything else is the blade's own shape.
    let free = begun.saturating_sub(2).max(2);
    let grown = |zone: usize| {
        let [first, before, end] = [0, free, last].map(|k| thickness(&sections[k], zone));
        end - before - (before - first) * (last - free) as f64 / free as f64
    };
    let most = (0..ZONES).map(grown).fold(f64::NEG_INFINITY, f64::max);
    if most > 2.0 * WHOLE * height { free } else { STEPS }
}

fn at(section: &Section, side: usize, w: f64) -> Point {
    section.sides[side].point(w)
}

/// Places of a zone along the sides.
fn places(zone: usize) -> impl Iterator<Item = f64> {
    (0..PLACES).map(move |i| {
        let share = (zone as f64 + (i as f64 + 0.5) / PLACES as f64) / ZONES as f64;
        MIDDLE.0 + (MIDDLE.1 - MIDDLE.0) * share
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Thickness of a section in a zone, mm: median.
fn thickness(section: &Section, zone: usize) -> f64 {
    let thick = |w: f64| {
        let across = at(section, 0, w) - at(section, 1, w);
        across.dot(&normal(section, w, &across))
    };
    median(places(zone).map(thick).collect())
}

/// How much wider section `k` is in a zone than sections `from`, `from` − 1 and `from` − 2 let expect, mm: median.
fn widening(sections: &[Section], from: usize, k: usize, zone: usize) -> f64 {
    let (a, b, c) = (&sections[from], &sections[from - 1], &sections[from - 2]);
    let x = (k - from) as f64;
    // The parabola through the three, x steps further on.
    let (wa, wb, wc) = (0.5 * (x + 1.0) * (x + 2.0), -x * (x + 2.0), 0.5 * x * (x + 1.0));
    let wider = |w: f64| {
        let off = |side: usize| -> (Vector, Point) {
            let [p, q, r] = [a, b, c].map(|s| at(s, side, w).coords);
            let expected = p * wa + q * wb + r * wc;
            (at(&sections[k], side, w).coords - expected, Point::from(p))
        };
        let ((one, p), (other, q)) = (off(0), off(1));
        let across = normal(a, w, &(p - q));
        (one - other).dot(&across)
    };
    median(places(zone).map(wider).collect())
}

/// Direction from side 1 to side 0 (roughly `across`) at right angles to the section's middle line.
fn normal(section: &Section, w: f64, across: &Vector) -> Vector {
    let middle = |w: f64| nalgebra::center(&at(section, 0, w), &at(section, 1, w));
    let along = (middle(w + 0.02) - middle(w - 0.02)).try_normalize(1e-12).unwrap_or_else(Vector::zeros);
    (across - along * along.dot(across)).try_normalize(1e-12).unwrap_or_else(Vector::zeros)
}
