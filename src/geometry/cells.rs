//! A uniform grid of points (spatial hash) for range queries in constant expected time.

use std::collections::HashMap;

use super::Point;

/// Points in a uniform grid, numbered in insertion order.
#[derive(Clone, Debug)]
pub struct ProximityGrid {
    /// Edge of a cell = radius of a query, mm.
    edge: f64,
    cells: HashMap<[i64; 3], Vec<(usize, Point)>>,
    count: usize,
}

impl ProximityGrid {
    /// An empty grid for queries of radius `reach` mm.
    pub fn new(reach: f64) -> Self {
        Self { edge: reach.max(1e-6), cells: HashMap::new(), count: 0 }
    }

    fn cell(&self, point: &Point) -> [i64; 3] {
        [point.x, point.y, point.z].map(|x| (x / self.edge).floor() as i64)
    }

    /// Adds the next point.
    pub fn push(&mut self, point: Point) {
        let cell = self.cell(&point);
        self.cells.entry(cell).or_default().push((self.count, point));
        self.count += 1;
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether a point with number ≥ `since` is within the query radius of `at`.
    pub fn any_near(&self, at: &Point, since: usize) -> bool {
        if since >= self.count {
            return false;
        }
        let [x, y, z] = self.cell(at);
        let about = |x: i64| x.saturating_sub(1)..=x.saturating_add(1);
        about(x).any(|x| {
            about(y).any(|y| {
                about(z).any(|z| {
                    let points = self.cells.get(&[x, y, z]).map_or(&[][..], Vec::as_slice);
                    // Latest first, so that the scan of a cell ends at `since`.
                    let mut late = points.iter().rev().take_while(|(number, _)| *number >= since);
                    late.any(|(_, p)| (p - at).norm_squared() < self.edge * self.edge)
                })
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    #[test]
    fn points_within_reach_are_found_from_a_number_on() {
        let at = |i: usize| Point::new((i * 37 % 101) as f64, (i * 53 % 89) as f64, (i % 7) as f64 - 3.0);
        let mut cells = ProximityGrid::new(6.0);
        (0..400).for_each(|i| cells.push(at(i)));
        assert_eq!(cells.len(), 400);
        let mut found = 0;
        for i in 0..300 {
            let place = at(i) + Vector::new(2.5, -3.5, 1.0);
            for since in [0, 250, 399, 400] {
                let near = (since..400).any(|k| (at(k) - place).norm() < 6.0);
                assert_eq!(cells.any_near(&place, since), near, "place {i} since {since}");
                found += usize::from(near);
            }
        }
        assert!(found > 100, "enough queries have a point nearby");
    }
}
