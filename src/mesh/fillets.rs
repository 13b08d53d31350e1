//! Detection of fillets at a blade's foot or tip. They belong to neither blade nor hub: the span sections are
//! taken between them, and the sides are extrapolated straight from there.
//!
//! The thickness of a blade changes almost linearly with height, so that it can be extrapolated towards
//! either end. In a fillet the blade is thicker than that, increasingly so towards the end.

use super::sides::SpanSection;

/// Number of heights that are examined from the middle of the blade to either end.
const STEPS: usize = 24;
/// Smallest excess growth of the thickness over a step within a fillet, mm per mm of the blade's height.
const BEGUN: f64 = 2.5e-4;
/// Smallest excess of the thickness at the end of a fillet, mm per mm of the blade's height.
const WHOLE: f64 = 4e-3;
/// Smallest excess growth of the thickness over the last step of a fillet, mm per mm of height: a fillet
/// meets the hub at a steep angle. The thickness of a blade may change unevenly, but hardly as fast.
const STEEP: f64 = 0.2;
/// Smallest excess of the thickness at the end of a fillet, in mean deviations of the growth away from it.
const NOISES: f64 = 4.0;
/// Fewest zones with a fillet: it need not go all around the blade.
const FEWEST: usize = 2;
/// Zones along the blade, each examined separately: a fillet takes a larger share of the height where the
/// blade is low.
const ZONES: usize = 6;
/// Samples in each zone.
const SAMPLES_PER_ZONE: usize = 5;
/// Range of a side that is examined, without the edges, whose thickness varies otherwise.
const MIDDLE: (f64, f64) = (0.1, 0.9);
/// Share of the thickness of the section before below which a section is broken, in this number of zones, and
/// largest number of broken sections at an end.
const BROKEN: (f64, usize) = (0.8, 3);
const MOST_BROKEN: usize = 2;
/// Search range for the nearest point of the other side, as a share of that side, in both directions.
const ASIDE: f64 = 0.15;

/// The range of heights of a blade between its fillets, within `low` to `high`, which is returned where there
/// are none. `section` slices the blade at a height.
pub fn between_fillets(low: f64, high: f64, section: impl Fn(f64) -> Option<SpanSection>) -> (f64, f64) {
    let middle = 0.5 * (low + high);
    let place = |end: f64, k: usize| middle + (end - middle) * k as f64 / STEPS as f64;
    let end = |end: f64| place(end, free_until(|k| section(place(end, k))));
    (end(low), end(high))
}

/// Index of the last section without fillet, counted from the middle towards an end.
fn free_until(section: impl Fn(usize) -> Option<SpanSection>) -> usize {
    let sections: Vec<SpanSection> = (0..=STEPS).map_while(section).collect();
    let Some(last) = sections.len().checked_sub(1).filter(|last| *last > 3) else { return STEPS };
    let thick: Vec<[f64; ZONES]> =
        sections.iter().map(|s| std::array::from_fn(|zone| thickness(s, zone))).collect();
    let whole = last_whole(&thick);
    let height = {
        let span = sections[0].sides[0].point(0.5) - sections[whole].sides[0].point(0.5);
        2.0 * span.norm() * STEPS as f64 / whole as f64
    };
    if let Some(begun) = fillet_begins(&thick[..=whole], height) {
        // Where the blade is lowest, at its trailing edge, the fillet may reach higher and round that edge.
        let has_round_tail = |section: &SpanSection| section.has_round_tail;
        let same = sections.iter().position(|s| has_round_tail(s) != has_round_tail(&sections[0]));
        return begun.min(same.unwrap_or(begun)).saturating_sub(3).max(1);
    }
    // Close to the end, where blade and hub meet, a slice may fall into pieces.
    if 3 * last >= 2 * STEPS && last < STEPS { last - 1 } else { STEPS }
}

/// Index of the last section that is whole: of the lowest rows of a fillet on a hub a slice may hold pieces
/// only, which are thinner by far than the section before.
fn last_whole(thick: &[[f64; ZONES]]) -> usize {
    let last = thick.len() - 1;
    let is_broken = |k: usize| {
        let thinner = (0..ZONES).filter(|zone| thick[k][*zone] < BROKEN.0 * thick[k - 1][*zone]);
        thinner.count() >= BROKEN.1
    };
    (1..=last).rev().take(MOST_BROKEN + 1).find(|&k| k > 3 && !is_broken(k)).unwrap_or(last)
}

/// Index of the step with which a fillet begins in a blade of some `height` (mm) that is `thick` (mm) in each
/// zone at the examined heights, from its middle to an end; `None` without one.
fn fillet_begins(thick: &[[f64; ZONES]], height: f64) -> Option<usize> {
    let last = thick.len() - 1;
    // From the end, the run of steps in which a zone grows faster than its growth in the half away from the
    // end lets expect. A single step does not count: close to the nose the thickness depends on where the
    // slice was divided.
    let begins = |zone: usize| -> Option<usize> {
        let gain = |k: usize| thick[k][zone] - thick[k - 1][zone];
        let median = |steps: std::ops::RangeInclusive<usize>| {
            let mut gains: Vec<f64> = steps.map(gain).collect();
            gains.sort_by(f64::total_cmp);
            gains[gains.len() / 2]
        };
        let quarter = last / 4;
        let (first, second) = (median(1..=quarter), median(quarter + 1..=2 * quarter));
        let rise = (second - first).max(0.0) / quarter as f64;
        let expected = |k: usize| second + rise * (k as f64 - 1.5 * quarter as f64 - 0.5).max(0.0);
        let mut over = vec![0.0; last + 1];
        for k in 1..=last {
            over[k] = over[k - 1] + gain(k) - expected(k);
        }
        let mut usual = over[..=2 * quarter].to_vec();
        usual.sort_by(f64::total_cmp);
        let usual = usual[usual.len() / 2];
        // Beside a blunt edge a zone holds part of that edge, and more or less of it from height to height.
        let noise =
            (1..=2 * quarter).map(|k| (gain(k) - second).abs()).sum::<f64>() / (2 * quarter).max(1) as f64;
        let whole = WHOLE * height + NOISES * noise;
        // Where a fillet begins, a slice may be divided at a wrong place: what is much too thick belongs to
        // it.
        let in_fillet = |k: usize| gain(k) > expected(k) + BEGUN * height || over[k] - usual > whole;
        let begun = (1..=last).rev().take_while(|&k| in_fillet(k)).last()?;
        // It is steepest where it ends: elsewhere a step may be one of a zone from face to face of a blunt
        // edge.
        let is_steep = gain(last) > expected(last) + STEEP * height / (2 * STEPS) as f64;
        (over[last] - usual > whole && is_steep).then_some(begun)
    };
    let begun: Vec<usize> = (0..ZONES).filter_map(begins).collect();
    begun.iter().min().copied().filter(|_| begun.len() >= FEWEST)
}

/// Thickness of a section in a zone, mm: median of the distances from one side to the nearest point of the
/// other.
fn thickness(section: &SpanSection, zone: usize) -> f64 {
    let mut thick: [f64; SAMPLES_PER_ZONE] = std::array::from_fn(|i| {
        let share = (zone as f64 + (i as f64 + 0.5) / SAMPLES_PER_ZONE as f64) / ZONES as f64;
        let w = MIDDLE.0 + (MIDDLE.1 - MIDDLE.0) * share;
        let from = section.sides[0].point(w);
        let (mut nearest, mut reach) = ((w, f64::INFINITY), ASIDE);
        // A coarse scan, then a fine one around its result.
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
    thick[SAMPLES_PER_ZONE / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHT: f64 = 20.0;
    const STEP: f64 = HEIGHT / (2 * STEPS) as f64;

    /// A blade that is `thickness` mm thick at distances from its middle to an end, alike in all zones.
    fn blade(thickness: impl Fn(f64) -> f64) -> Vec<[f64; ZONES]> {
        (0..=STEPS).map(|k| [thickness(k as f64 * STEP); ZONES]).collect()
    }

    #[test]
    fn a_fillet_begins_where_the_thickness_leaves_its_line() {
        const RADIUS: f64 = 1.5;
        let filleted = blade(|h| {
            let into = (RADIUS - (HEIGHT / 2.0 - h)).max(0.0);
            1.5 + 0.03 * h + 2.0 * (RADIUS - (RADIUS * RADIUS - into * into).sqrt())
        });
        let begun = fillet_begins(&filleted, HEIGHT).expect("a fillet") as f64 * STEP;
        let expected = HEIGHT / 2.0 - RADIUS;
        assert!((begun - expected).abs() < 2.0 * STEP, "{begun} mm from the middle, in place of {expected}");
    }

    #[test]
    fn sections_in_pieces_at_the_end_of_a_fillet_do_not_count() {
        let mut sections = blade(|h| 3.0 + 8.0 * (h - 8.5).max(0.0).powi(2));
        sections[STEPS] = [0.1, 0.2, 0.9, 1.6, 2.3, 3.1];
        let whole = last_whole(&sections);
        assert_eq!(whole, STEPS - 1);
        assert!(fillet_begins(&sections, HEIGHT).is_none());
        assert!(fillet_begins(&sections[..=whole], HEIGHT).is_some());
    }

    #[test]
    fn a_thickness_that_changes_unevenly_is_no_fillet() {
        // It falls towards the tip, and then stays.
        let tapered = blade(|h| 1.0 - 0.09 * h.min(4.0) - 0.02 * (h - 4.0).max(0.0));
        assert_eq!(fillet_begins(&tapered, HEIGHT), None);
        let beside_an_edge = [0.15, 0.9, 0.3, 1.3, 0.2, 0.9, 0.5, 0.2, 0.1];
        let noisy: Vec<[f64; ZONES]> = (0..=STEPS).map(|k| [beside_an_edge[k % 9]; ZONES]).collect();
        assert_eq!(fillet_begins(&noisy, HEIGHT), None);
        let waving = blade(|h| 1.0 + 0.15 * (h / 3.0).sin());
        assert_eq!(fillet_begins(&waving, HEIGHT), None);
    }
}
