//! Balls about parts of the grid of a side.

use super::grid::SideGrid;
use crate::geometry::{Point, Vector};

/// Points of a block, and largest number of blocks of a line: 41 points, and 4 more at each rounded end.
pub(super) const BLOCK: usize = 6;
pub(super) const MAX_BLOCKS: usize = 49usize.div_ceil(BLOCK);

/// Upper bound on the distance of a point of a cell from its nearest corner, as a share of the longest
/// distance between two corners: 1/√3 for a flat cell, and a margin for curvature.
const CELL_REACH: f64 = 0.75;
/// Radius of a ball around points in space at most, as a share of the longest distance between two of them
/// (Jung's theorem): a point of their hull is not further than that from the nearest of them.
const JUNG: f64 = 0.612_372_435_695_794_5;

/// Runs of neighbouring points of the lines of a grid, with bounds on the distances of what they represent.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    /// Per point of the grid, an upper bound on the distance from it to the part of the side for which it is
    /// the nearest, mm.
    pub reaches: Vec<f64>,
    /// Line by line: [`Self::per_line`] per line.
    blocks: Vec<GridBlock>,
    per_line: usize,
    /// Balls about the cells after the points of the blocks with the same number on all lines: centre, and
    /// radius, mm.
    pub strips: Vec<(Point, f64)>,
}

/// A run of points of one line of the grid in a bounding ball. A distance changes by at most the distance
/// between two points, so that of the centre decides whether the others matter.
#[derive(Clone, Copy, Debug)]
pub(super) struct GridBlock {
    /// Index of the first point in the line, and one past the last.
    pub first: usize,
    pub last: usize,
    /// Index of the point in the middle.
    pub centre: usize,
    /// Furthest point of the run from the centre, mm.
    pub radius: f64,
    /// As `radius`, with the parts of the side that the points represent.
    pub reach: f64,
}

impl Blocks {
    pub fn new(grid: &SideGrid) -> Self {
        let points = &grid.points;
        let (n, lines) = (grid.u.len(), grid.v.len());
        let mut reaches = vec![0.0f64; points.len()];
        for (j, i) in (0..lines - 1).flat_map(|j| (0..n - 1).map(move |i| (j, i))) {
            let corners = grid.corners(i, j);
            let [a, b, c, d] = corners.map(|k| points[k]);
            let longest =
                [d - a, c - b, b - a, d - c, c - a, d - b].iter().map(Vector::norm).fold(0.0, f64::max);
            let reach = (CELL_REACH * longest).max(JUNG * longest + grid.sag(i, j));
            for k in corners {
                reaches[k] = reaches[k].max(reach);
            }
        }
        let per_line = n.div_ceil(BLOCK);
        let block = |j: usize, b: usize| {
            let (first, last) = (b * BLOCK, ((b + 1) * BLOCK).min(n));
            let centre = (first + last) / 2;
            let off = |i: usize| (points[j * n + i] - points[j * n + centre]).norm();
            let radius = (first..last).map(off).fold(0.0, f64::max);
            let reach = (first..last).map(|i| off(i) + reaches[j * n + i]).fold(0.0, f64::max);
            GridBlock { first, last, centre, radius, reach }
        };
        let numbers = (0..lines).flat_map(|j| (0..per_line).map(move |b| (j, b)));
        let blocks = numbers.map(|(j, b)| block(j, b)).collect();
        let strip = |b: usize| {
            let (first, last) = (b * BLOCK, ((b + 1) * BLOCK).min(n - 1));
            let own = || (0..lines).flat_map(|j| (first..=last).map(move |i| j * n + i));
            let sum: Vector = own().map(|k| points[k].coords).sum();
            let centre = Point::from(sum / (lines * (last + 1 - first)) as f64);
            let off = |k: usize| (points[k] - centre).norm();
            let of_cell = |(i, j): (usize, usize)| {
                grid.corners(i, j).map(off).into_iter().fold(0.0, f64::max) + grid.sag(i, j)
            };
            // A last strip of a single line has no cell of its own.
            let lone = own().map(off).fold(0.0, f64::max);
            let cells = (0..lines - 1).flat_map(|j| (first..last).map(move |i| (i, j)));
            (centre, cells.map(of_cell).fold(lone, f64::max))
        };
        let strips = (0..per_line).map(strip).collect();
        Self { reaches, blocks, per_line, strips }
    }

    /// Those of line `j`.
    pub fn of_line(&self, j: usize) -> &[GridBlock] {
        &self.blocks[j * self.per_line..(j + 1) * self.per_line]
    }
}
