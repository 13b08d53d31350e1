//! Vertex welding: merges corners with equal coordinates and, at borders, corners that differ by rounding.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::geometry::Point;

/// Index that means "no corner", "no neighbour" or "no face".
pub const NONE: u32 = u32::MAX;
/// Distance within which corners at borders are welded, as a share of the mesh's extent …
const NEAR: f64 = 1e-6;
/// … or, if that is more, as a share of the largest coordinate: single precision resolves 1.2e-7 of it.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Cell width of the search grid as a multiple of the welding distance: large enough that most searches stay
/// in one cell, small enough that few corners share one.
const CELL: f64 = 8.0;

/// Hasher for coordinate bits: faster than the default one and sufficient for a table of corners.
#[derive(Default)]
pub struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 ^= self.0 >> 32;
    }
}

/// A hash map with a fast hasher for numeric keys.
pub type NumberMap<K, V> = HashMap<K, V, BuildHasherDefault<Mixer>>;

/// Merges points with equal coordinates. Returns for each point its index among the kept ones, and these.
pub fn equal(points: &[Point]) -> (Vec<u32>, Vec<Point>) {
    let mut table: NumberMap<(u64, u64, u64), u32> = NumberMap::default();
    table.reserve(points.len() / 2);
    let mut kept = Vec::with_capacity(points.len() / 2);
    let to = points
        .iter()
        .map(|p| {
            // Adding 0 turns −0 into 0, so that both have the same bits.
            let bits = |x: f64| (x + 0.0).to_bits();
            *table.entry((bits(p.x), bits(p.y), bits(p.z))).or_insert_with(|| {
                kept.push(*p);
                kept.len() as u32 - 1
            })
        })
        .collect();
    (to, kept)
}

/// As [`equal`], for `loose` corners that differ by rounding; `None` where there are none. A corner is moved
/// by at most the welding distance, even in a chain of near corners, and the two ends of an edge that is
/// longer than rounding are never merged.
pub fn near(points: &[Point], triangles: &[[u32; 3]], loose: &[bool]) -> Option<(Vec<u32>, Vec<Point>)> {
    let (mut low, mut high) = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    for p in points {
        (low, high) = (low.inf(p), high.sup(p));
    }
    let rounding = ROUNDING * low.coords.amax().max(high.coords.amax());
    let distance = rounding.max(NEAR * (high - low).amax());
    if !(distance > 0.0 && distance.is_finite()) {
        return None;
    }
    let short = short_edges(points, triangles, rounding, distance);
    let cell = |x: f64| (x / (CELL * distance)).floor() as i64;
    // Linked lists per cell: the kept corner added last, and for each kept corner the one added before it.
    let mut cells: NumberMap<(i64, i64, i64), u32> = NumberMap::default();
    let mut before: Vec<u32> = Vec::new();
    let mut kept: Vec<Point> = Vec::with_capacity(points.len());
    let mut to: Vec<u32> = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        let mut nearest: Option<(f64, u32)> = None;
        if loose[i] {
            let apart: &[u32] = short.get(&(i as u32)).map_or(&[], Vec::as_slice);
            let reach = |x: f64| cell(x - distance)..=cell(x + distance);
            for (x, y) in reach(p.x).flat_map(|x| reach(p.y).map(move |y| (x, y))) {
                for z in reach(p.z) {
                    let mut at = cells.get(&(x, y, z)).copied().unwrap_or(NONE);
                    while at != NONE {
                        let d = (kept[at as usize] - p).norm();
                        let parted = || apart.iter().any(|&end| to.get(end as usize) == Some(&at));
                        if d <= distance && nearest.is_none_or(|n| (d, at) < n) && !parted() {
                            nearest = Some((d, at));
                        }
                        at = before[at as usize];
                    }
                }
            }
        }
        to.push(nearest.map_or(kept.len() as u32, |(_, at)| at));
        if nearest.is_none() {
            let own = kept.len() as u32;
            kept.push(*p);
            before.push(if loose[i] {
                cells.insert((cell(p.x), cell(p.y), cell(p.z)), own).unwrap_or(NONE)
            } else {
                NONE
            });
        }
    }
    (kept.len() < points.len()).then_some((to, kept))
}

/// For each corner, the other ends of its edges that are longer than `above` and at most `up_to`, mm.
fn short_edges(points: &[Point], triangles: &[[u32; 3]], above: f64, up_to: f64) -> NumberMap<u32, Vec<u32>> {
    let mut ends: NumberMap<u32, Vec<u32>> = NumberMap::default();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let length = (points[a as usize] - points[b as usize]).norm();
            if length > above && length <= up_to {
                ends.entry(a).or_default().push(b);
                ends.entry(b).or_default().push(a);
            }
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(x: &[f64]) -> Vec<Point> {
        x.iter().map(|x| Point::new(*x, 0.0, 0.0)).collect()
    }

    #[test]
    fn corners_that_rounding_parts_are_one_and_a_row_of_them_is_not() {
        // With an extent of 100, the welding distance is 1e-4.
        let parted = points(&[0.0, 100.0, 1e-5, 100.0 - 1e-5]);
        let (to, kept) = near(&parted, &[], &[true; 4]).expect("two are one with others");
        assert_eq!((to, kept.len()), (vec![0, 1, 0, 1], 2));
        assert!(near(&parted, &[], &[false; 4]).is_none(), "they are not at a border");
        // Each corner of the row is near to the next, and none may move further than the welding distance.
        let row: Vec<f64> = (0..50).map(|i| 0.8e-4 * f64::from(i)).chain([100.0]).collect();
        let (to, kept) = near(&points(&row), &[], &[true; 51]).expect("some are one");
        assert!(row.iter().zip(&to).all(|(x, k)| (x - kept[*k as usize].x).abs() <= 1e-4), "{to:?}");
        assert!(kept.len() >= 25, "{}", kept.len());
    }

    #[test]
    fn ends_of_a_short_edge_stay_two_and_those_of_a_rounded_one_do_not() {
        let corners = points(&[0.0, 0.9e-4, 100.0, 1e-7]);
        let (to, kept) = near(&corners, &[[0, 1, 2]], &[true; 4]).expect("one is another");
        assert_eq!((to, kept.len()), (vec![0, 1, 2, 0], 3));
        let (to, _) = near(&corners, &[[0, 3, 2]], &[true; 4]).expect("one is another");
        assert_eq!(to, vec![0, 0, 2 - 1, 0], "nothing stands between them");
    }
}
