//! Fast approximate distances from hub and blank for the fixed-axis search: tables over the meridional plane.

use crate::geometry::{Meridional, Point, norm2};
use crate::part::{Blank, Impeller};

/// A distance tabulated over the meridional plane, interpolated bilinearly.
#[derive(Debug)]
pub(super) struct DistanceTable {
    from: Meridional,
    spacing: f64,
    columns: usize,
    rows: usize,
    distance: Vec<f32>,
}

/// Nodes along the longer side of the table.
const NODES: f64 = 110.0;

impl DistanceTable {
    /// Signed distance from the hub, as far as `margin` mm beyond the part.
    pub(super) fn of_hub(part: &Impeller, margin: f64) -> Self {
        let curve = part.hub.curve();
        // Along a row the projection moves little: warm start.
        let mut warm: Option<f64> = None;
        Self::new(part, margin, |p, spacing, begins| {
            let (t, d) = match warm {
                Some(t) if !begins => curve.project_near(p, t, 4.0 * spacing),
                _ => curve.project(p),
            };
            warm = Some(t);
            // Beyond its ends the hub has an edge, not a surface.
            if t <= 0.0 || t >= curve.length() { d.abs() } else { d }
        })
    }

    /// Signed distance from the blank, as far as `margin` mm beyond the part.
    pub(super) fn of_blank(part: &Impeller, blank: &Blank, margin: f64) -> Self {
        let mut warm = None;
        Self::new(part, margin, |p, _, begins| {
            if begins {
                warm = None;
            }
            blank.clearance(p, &mut warm)
        })
    }

    /// Tabulates `distance` row by row. Its arguments are the node, the spacing of the nodes, mm, and whether
    /// to discard the warm start.
    fn new(part: &Impeller, margin: f64, mut distance: impl FnMut(Meridional, f64, bool) -> f64) -> Self {
        let (mut low, mut high) =
            (Meridional { r: f64::MAX, z: f64::MAX }, Meridional { r: f64::MIN, z: f64::MIN });
        for path in [part.hub.curve(), part.shroud.curve()] {
            for i in 0..=64 {
                let p = path.point(path.length() * f64::from(i) / 64.0);
                low = Meridional { r: low.r.min(p.r), z: low.z.min(p.z) };
                high = Meridional { r: high.r.max(p.r), z: high.z.max(p.z) };
            }
        }
        let from = Meridional { r: (low.r - margin).max(0.0), z: low.z - margin };
        let (width, height) = (high.r + margin - from.r, high.z + margin - from.z);
        let spacing = width.max(height) / NODES;
        let (columns, rows) = ((width / spacing) as usize + 2, (height / spacing) as usize + 2);
        let mut nodes = Vec::with_capacity(columns * rows);
        for i in 0..rows {
            for j in 0..columns {
                let p = Meridional { r: from.r + spacing * j as f64, z: from.z + spacing * i as f64 };
                nodes.push(distance(p, spacing, j % 8 == 0) as f32);
            }
        }
        Self { from, spacing, columns, rows, distance: nodes }
    }

    /// Signed distance of a point, mm, accurate to a few hundredths; infinite far from the part.
    pub(super) fn at(&self, p: &Point) -> f64 {
        let x = (norm2(p.x, p.y) - self.from.r) / self.spacing;
        let y = (p.z - self.from.z) / self.spacing;
        if !(x >= 0.0 && y >= 0.0 && x < (self.columns - 1) as f64 && y < (self.rows - 1) as f64) {
            return f64::INFINITY;
        }
        let (i, j) = (y as usize, x as usize);
        let (fx, fy) = (x - j as f64, y - i as f64);
        let node = |i: usize, j: usize| f64::from(self.distance[i * self.columns + j]);
        let row = |i: usize| node(i, j) + fx * (node(i, j + 1) - node(i, j));
        row(i) + fy * (row(i + 1) - row(i))
    }
}
