//! In which order single plunges are visited that may be cut in any order: a short path, by the way of the
//! tip and the turn of the axis from one to the next.
//!
//! The nearest unvisited place next, then 2-opt: a stretch of the path is reversed as long as that makes it
//! shorter.

use crate::geometry::{Point, Vector};

/// Length that counts like a turn of the axis by 1 rad, mm. From rest to rest a linear axis with 4 m/s² moves
/// as far in the time in which a rotary axis with 1000 °/s² turns by 10°, for each radian.
const LEVER_MM: f64 = 200.0;
/// Places of a path that are ordered together: the time of 2-opt grows with their square.
const MAX_TOGETHER: usize = 1500;
/// Maximum passes of 2-opt; it mostly ends before.
const MAX_PASSES: usize = 20;
/// Shortening below which a stretch is not reversed, mm.
const MIN_SHORTENING: f64 = 1e-6;

/// Where the tool is at the end of a plunge: its tip and its unit axis.
pub type PlungePlace = (Point, Vector);

/// Cost of the link between two places, mm.
fn link_cost((tip, axis): &PlungePlace, (other_tip, other_axis): &PlungePlace) -> f64 {
    // The chord between the axes: hardly less than the angle.
    (tip - other_tip).norm() + LEVER_MM * (axis - other_axis).norm()
}

/// An order of `places`, as indices, in which the path from `start` through them is short. Long lists are
/// ordered in parts, so they should already be roughly in order.
pub fn short_path(start: Option<&PlungePlace>, places: &[PlungePlace]) -> Vec<usize> {
    short_path_in_parts(start, places, MAX_TOGETHER)
}

/// As [`short_path`], in parts of at most `most` places.
fn short_path_in_parts(start: Option<&PlungePlace>, places: &[PlungePlace], most: usize) -> Vec<usize> {
    let mut order = Vec::with_capacity(places.len());
    let mut before = start.copied();
    for first in (0..places.len()).step_by(most) {
        let mut part: Vec<usize> = (first..places.len().min(first + most)).collect();
        nearest_next(before.as_ref(), places, &mut part);
        reverse_stretches(before.as_ref(), places, &mut part);
        before = part.last().map(|&last| places[last]);
        order.extend(part);
    }
    order
}

/// Orders `path` so that each place is the nearest to the one before it of those that are left.
fn nearest_next(start: Option<&PlungePlace>, places: &[PlungePlace], path: &mut [usize]) {
    let mut here = start.copied();
    for next in 0..path.len() {
        if let Some(here) = &here {
            let cost = |&k: &usize| link_cost(here, &places[path[k]]);
            let nearest = (next..path.len()).min_by(|a, b| cost(a).total_cmp(&cost(b)));
            path.swap(next, nearest.unwrap_or(next));
        }
        here = Some(places[path[next]]);
    }
}

/// 2-opt with a fixed start and an open end.
fn reverse_stretches(start: Option<&PlungePlace>, places: &[PlungePlace], path: &mut [usize]) {
    for _ in 0..MAX_PASSES {
        let mut is_shorter = false;
        for first in 0..path.len() {
            let before = if first == 0 { start } else { Some(&places[path[first - 1]]) };
            for last in first + 1..path.len() {
                let (from, to) = (&places[path[first]], &places[path[last]]);
                let after = path.get(last + 1).map(|&index| &places[index]);
                let link = |a: Option<&PlungePlace>, b: Option<&PlungePlace>| {
                    a.zip(b).map_or(0.0, |(a, b)| link_cost(a, b))
                };
                let now = link(before, Some(from)) + link(Some(to), after);
                let reversed = link(before, Some(to)) + link(Some(from), after);
                if reversed < now - MIN_SHORTENING {
                    path[first..=last].reverse();
                    is_shorter = true;
                }
            }
        }
        if !is_shorter {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(count: usize, seed: u64) -> Vec<PlungePlace> {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut place = || {
            let tip = Point::new(100.0 * random(), 40.0 * random(), 0.0);
            (tip, Vector::new(0.4 * random(), 0.4 * random(), 1.0).normalize())
        };
        (0..count).map(|_| place()).collect()
    }

    /// Cost of the path through `places` in `order`, from `start` if there is one, mm.
    fn path_cost(start: Option<&PlungePlace>, places: &[PlungePlace], order: &[usize]) -> f64 {
        let path: Vec<&PlungePlace> =
            start.into_iter().chain(order.iter().map(|&index| &places[index])).collect();
        path.windows(2).map(|pair| link_cost(pair[0], pair[1])).sum()
    }

    /// The cheapest of all orders.
    fn min_cost(
        start: &PlungePlace,
        places: &[PlungePlace],
        left: &mut Vec<usize>,
        so_far: &mut Vec<usize>,
    ) -> f64 {
        if left.is_empty() {
            return path_cost(Some(start), places, so_far);
        }
        let mut least = f64::INFINITY;
        for k in 0..left.len() {
            so_far.push(left.remove(k));
            least = least.min(min_cost(start, places, left, so_far));
            left.insert(k, so_far.pop().expect("was pushed"));
        }
        least
    }

    #[test]
    fn a_path_visits_every_place_once_and_is_nearly_the_shortest() {
        let (mut found, mut least) = (0.0, 0.0);
        for seed in 0..20 {
            let places = places(8, seed);
            let order = short_path(Some(&places[0]), &places[1..]);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..7).collect::<Vec<_>>());
            let cost = path_cost(Some(&places[0]), &places[1..], &order);
            let best = min_cost(&places[0], &places[1..], &mut (0..7).collect(), &mut Vec::new());
            assert!(cost >= best - 1e-9);
            (found, least) = (found + cost, least + best);
        }
        assert!(found < 1.06 * least, "{found} of {least}");
    }

    #[test]
    fn a_path_is_much_shorter_than_rows_that_all_begin_at_the_same_end() {
        let rows: Vec<PlungePlace> = (0..10)
            .flat_map(|row| (0..20).map(move |k| Point::new(5.0 * f64::from(k), f64::from(row), 0.0)))
            .map(|tip| (tip, Vector::z()))
            .collect();
        let all: Vec<usize> = (0..rows.len()).collect();
        let order = short_path(Some(&rows[0]), &rows);
        assert!(path_cost(Some(&rows[0]), &rows, &order) < 0.6 * path_cost(Some(&rows[0]), &rows, &all));
    }

    #[test]
    fn long_lists_are_ordered_in_parts() {
        let places = places(210, 1);
        let mut order = short_path_in_parts(None, &places, 100);
        assert!(order[..100].iter().all(|&index| index < 100), "the first part comes first");
        order.sort_unstable();
        assert_eq!(order, (0..places.len()).collect::<Vec<_>>());
        assert!(short_path(None, &[]).is_empty());
    }
}
