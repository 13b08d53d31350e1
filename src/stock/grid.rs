//! The grid of cells over a channel's hub floor.

use rayon::prelude::*;

use super::obstacles::{InaccessibleFloor, inaccessible_floor};
use super::overhang::WallTables;
use super::reach::{CutterStretch, InaccessibleTables};
use crate::geometry::{Meridional, search};
use crate::part::{Blank, Workpiece};
use crate::setup::{AllowanceSetup, Setup};

/// Inputs of a floor grid.
#[derive(Clone, Copy, Debug)]
pub struct FloorSource<'a> {
    /// The part, its channel, and the blank before the first cut.
    pub workpiece: &'a Workpiece,
    /// Allowances.
    pub stock: &'a AllowanceSetup,
    /// Ranges of s and the cutters used there. Without any, the whole floor counts as reachable.
    pub cutters: &'a [CutterStretch],
    /// Largest angle of an axis from the isoparametric one, rad.
    pub max_tilt_rad: f64,
}

impl<'a> FloorSource<'a> {
    /// The floor of `workpiece` with the allowances and the largest tilt of plunges of `setup`.
    pub fn of_setup(workpiece: &'a Workpiece, setup: &'a Setup, cutters: &'a [CutterStretch]) -> Self {
        Self { workpiece, stock: &setup.allowances, cutters, max_tilt_rad: setup.plunge.max_tilt_rad }
    }
}

/// Cells over the hub floor of one channel, `rows` along s (row 0 at s = 0, the leading edge;
/// last row at s = 1, the rim) times `columns` along λ (0 suction wall → 1 pressure wall).
/// Cell (i, j) is at index `i * columns + j` of every list. f32, mm.
#[derive(Clone, Debug)]
pub struct FloorGrid {
    /// Number of cells along s.
    pub rows: usize,
    /// Number of cells along λ.
    pub columns: usize,
    /// Foot of each cell's ray on the finished hub.
    pub points: Vec<[f32; 3]>,
    /// Unit normal of the hub at the foot, into the channel.
    pub normals: Vec<[f32; 3]>,
    /// Height along the normal at which the ray first leaves the stock before any cut, mm: at the outline of
    /// the blank, or at the underside of a blade that leans over the cell, less the blade allowance. 0 under
    /// a blade.
    pub blank_heights: Vec<f32>,
    /// Area of each cell, mm².
    pub areas: Vec<f32>,
    /// Whether the cell belongs to the floor (not under a splitter, not within the blade allowance).
    pub floor: Vec<bool>,
    /// Whether any cutter used there could remove stock from the cell. None can where no more than the hub
    /// allowance stands, as at a slanted edge of the blank, and in the corner under a wall that leans over
    /// the cell (see [`super::reach`]).
    pub reachable: Vec<bool>,
}

#[cfg(test)]
impl FloorGrid {
    /// A level floor of cells 1 mm wide under 20 mm of stock.
    pub(crate) fn flat(rows: usize, columns: usize) -> Self {
        let count = rows * columns;
        Self {
            rows,
            columns,
            points: (0..count).map(|k| [(k / columns) as f32, (k % columns) as f32, 0.0]).collect(),
            normals: vec![[0.0, 0.0, 1.0]; count],
            blank_heights: vec![20.0; count],
            areas: vec![1.0; count],
            floor: vec![true; count],
            reachable: vec![true; count],
        }
    }
}

impl FloorGrid {
    /// Every `stride`-th cell along both directions, each standing for those left out.
    pub fn every(&self, stride: usize) -> Self {
        let lines = |count: usize| -> Vec<usize> { (0..count).step_by(stride.max(1)).collect() };
        self.picked(&lines(self.rows), &lines(self.columns))
    }

    /// The cells where the lines `rows` along s and `columns` across meet; areas grow so that these cells
    /// stand for all.
    pub(super) fn picked(&self, rows: &[usize], columns: &[usize]) -> Self {
        let cells: Vec<usize> =
            rows.iter().flat_map(|i| columns.iter().map(move |j| i * self.columns + j)).collect();
        let growth = (self.rows * self.columns) as f32 / cells.len().max(1) as f32;
        Self {
            rows: rows.len(),
            columns: columns.len(),
            points: cells.iter().map(|&cell| self.points[cell]).collect(),
            normals: cells.iter().map(|&cell| self.normals[cell]).collect(),
            blank_heights: cells.iter().map(|&cell| self.blank_heights[cell]).collect(),
            areas: cells.iter().map(|&cell| self.areas[cell] * growth).collect(),
            floor: cells.iter().map(|&cell| self.floor[cell]).collect(),
            reachable: cells.iter().map(|&cell| self.reachable[cell]).collect(),
        }
    }

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

    /// s of the middle of row `row`.
    pub fn s_of_row(&self, row: usize) -> f64 {
        (row as f64 + 0.5) / self.rows as f64
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
            first_exit(blank, |h| Meridional::of(&(foot + normal * h)), 2.0 * part.rim_radius())
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
