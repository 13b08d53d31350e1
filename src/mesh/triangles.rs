//! Triangles over shared points, and those of grids.

use std::collections::HashMap;

use crate::geometry::Point;

/// The triangles of a grid of corners, two for each cell with `keep(row, column)`. Corners are numbered row
/// by row.
pub fn grid_triangles(rows: usize, columns: usize, keep: impl Fn(usize, usize) -> bool) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * rows * columns);
    for i in 0..rows.saturating_sub(1) {
        for j in 0..columns.saturating_sub(1) {
            if keep(i, j) {
                let a = (i * columns + j) as u32;
                let (b, c, d) = (a + 1, a + columns as u32, a + columns as u32 + 1);
                triangles.extend([[a, c, b], [b, c, d]]);
            }
        }
    }
    triangles
}

/// Triangles over shared points, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The corners.
    pub points: Vec<Point>,
    /// Three indices into `points` each, counter-clockwise seen from outside the material.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Adds the triangles of another mesh.
    pub fn append(&mut self, other: &Self) {
        let first = self.points.len() as u32;
        self.points.extend_from_slice(&other.points);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// Some of the triangles, by their numbers, with the points that they have: takes time by these alone.
    #[must_use]
    pub fn some(&self, triangles: &[usize]) -> Self {
        let (mut to, mut points) = (HashMap::new(), Vec::new());
        let mut new = |i: u32| {
            *to.entry(i).or_insert_with(|| {
                points.push(self.points[i as usize]);
                points.len() as u32 - 1
            })
        };
        let triangles = triangles.iter().map(|t| self.triangles[*t].map(&mut new)).collect();
        Self { points, triangles }
    }

    /// The same triangles, without unused points.
    #[must_use]
    pub fn compact(&self) -> Self {
        let mut to = vec![u32::MAX; self.points.len()];
        let mut points = Vec::new();
        let triangles = self
            .triangles
            .iter()
            .map(|t| {
                t.map(|i| {
                    let new = &mut to[i as usize];
                    if *new == u32::MAX {
                        *new = points.len() as u32;
                        points.push(self.points[i as usize]);
                    }
                    *new
                })
            })
            .collect();
        Self { points, triangles }
    }
}

#[cfg(test)]
mod tests {
    use super::grid_triangles;

    #[test]
    fn cells_of_a_grid_become_two_triangles_each() {
        assert_eq!(grid_triangles(3, 3, |_, _| true).len(), 4 * 2);
        assert_eq!(grid_triangles(3, 3, |i, j| i != j).len(), 2 * 2);
        assert!(grid_triangles(1, 5, |_, _| true).is_empty());
    }
}
