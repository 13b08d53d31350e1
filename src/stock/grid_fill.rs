//! Fills the grid of a floor: feet and normals of its cells, the stock over them, and which of them are
//! accessible.

use rayon::prelude::*;

use super::floor_source::FloorSource;
use super::grid::FloorGrid;
use super::obstacles::{InaccessibleFloor, inaccessible_floor};
use super::overhang::WallTables;
use super::reach::InaccessibleTables;
use crate::geometry::{Meridional, search};
use crate::part::{Blank, Workpiece};

impl FloorGrid {
    /// The floor of a channel in `cells` × `cells`.
    pub fn new(source: &FloorSource, cells: usize) -> Self {
        Self::with_causes(source, cells).0
    }

    /// As [`Self::new`], with its inaccessible floor by causes, the largest share first.
    pub fn with_causes(source: &FloorSource, cells: usize) -> (Self, Vec<InaccessibleFloor>) {
        let cells = cells.max(1);
        let count = cells * cells;
        let mut grid = Self {
            rows: cells,
            columns: cells,
            points: vec![[0.0; 3]; count],
            normals: vec![[0.0; 3]; count],
            blank_heights: vec![0.0; count],
            areas: vec![0.0; count],
            floor: vec![false; count],
            reachable: vec![true; count],
        };
        let walls =
            WallTables::new(&source.workpiece.part, &source.workpiece.channel, source.stock.blade_allowance);
        let reach = InaccessibleTables::new(source, &walls);
        (
            grid.points.par_chunks_mut(cells),
            grid.normals.par_chunks_mut(cells),
            grid.blank_heights.par_chunks_mut(cells),
            grid.areas.par_chunks_mut(cells),
            grid.floor.par_chunks_mut(cells),
            grid.reachable.par_chunks_mut(cells),
        )
            .into_par_iter()
            .enumerate()
            .for_each(|(i, (points, normals, blank_heights, areas, floor, reachable))| {
                let s = (i as f64 + 0.5) / cells as f64;
                GridRow { points, normals, blank_heights, areas, floor, reachable }
                    .fill(source, &walls, &reach, s);
            });
        let causes = inaccessible_floor(source, &grid, &walls, &reach);
        (grid, causes)
    }
}

/// One row of the lists of a [`FloorGrid`].
struct GridRow<'a> {
    points: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    blank_heights: &'a mut [f32],
    areas: &'a mut [f32],
    floor: &'a mut [bool],
    reachable: &'a mut [bool],
}

impl GridRow<'_> {
    fn fill(self, source: &FloorSource, walls: &WallTables, reach: &InaccessibleTables, s: f64) {
        let Workpiece { part, blank, .. } = source.workpiece;
        let hub = part.hub.at(s);
        let columns = self.points.len() as f64;
        let outline = {
            let (foot, normal) = (hub.point.at_angle(0.0), hub.normal.direction_at_angle(0.0));
            first_exit(blank, |h| Meridional::from_point(&(foot + normal * h)), 2.0 * part.rim_radius())
        };
        let over = walls.blades_over(s);
        let covered = reach.inaccessible_ranges(s, &over);
        let sign = part.pitch().signum();
        let cell = over.width.abs() / columns;
        let area = (cell * hub.point.r * part.hub.length() / columns) as f32;
        let turn = (cell * sign).sin_cos();
        let mut direction = (over.from + 0.5 * cell * sign).sin_cos();
        for j in 0..self.points.len() {
            let angle = (j as f64 + 0.5) * cell;
            let (sin, cos) = direction;
            self.points[j] = [(hub.point.r * cos) as f32, (hub.point.r * sin) as f32, hub.point.z as f32];
            self.normals[j] = [(hub.normal.r * cos) as f32, (hub.normal.r * sin) as f32, hub.normal.z as f32];
            self.areas[j] = area;
            let underside = over.underside(angle);
            let blank_height = outline.min(underside);
            self.blank_heights[j] = blank_height as f32;
            self.floor[j] = underside > 0.0;
            let holds_stock = blank_height > source.stock.hub_allowance || !self.floor[j];
            self.reachable[j] = holds_stock && (underside >= outline || !covered.contains(angle));
            direction = (sin * turn.1 + cos * turn.0, cos * turn.1 - sin * turn.0);
        }
    }
}

/// Height along a ray from the hub at which it first leaves the blank, mm.
fn first_exit(blank: &Blank, at: impl Fn(f64) -> Meridional, reach: f64) -> f64 {
    let mut warm = None;
    let mut depth = |h: f64| blank.depth_near(at(h), &mut warm);
    let stride = reach / 400.0;
    let mut inside = (0.0, 0.0);
    let mut h = 1e-3;
    while h < reach {
        let here = (h, depth(h));
        if here.1 <= 0.0 {
            return if inside.1 > 0.0 { search::root_from(depth, inside, here, h, 1e-6) } else { inside.0 };
        }
        // Sphere tracing: the outline is at least as far away as the point is deep.
        inside = here;
        h += stride.max(here.1);
    }
    reach
}
