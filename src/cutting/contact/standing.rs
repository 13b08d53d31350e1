//! How high stock stands in a cylinder after the plunges before: bounds from both sides.
//!
//! Branch and bound, the highest bound first, over a quadtree of the bottom of the cylinder. A cell stands
//! for the lines along the axis through it. Stock on its middle line bounds the height from below. From above
//! it is bounded by what is left of that line by plunges that are smaller by the half diagonal of the cell,
//! in a blank that is larger by it: what is missing there is missing on all lines of the cell. Thus no sliver
//! between two plunges is overlooked, however thin.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::columns::{BlankTop, Earlier, PlungeColumn};
use super::crossed::CoreLine;
use super::neighbours::Neighbours;
use super::remainder::LineRemainder;
use crate::geometry::{CutterSolid, Meridional, Vector, norm2};
use crate::part::Blank;

/// Difference of both bounds at which the search ends, mm.
const TOLERANCE: f64 = 0.05;
/// Number of times that the square around the bottom is divided: cells of a cutter of 30 mm are 0.1 mm wide.
const MAX_DIVISIONS: usize = 8;
/// Cells after which the search ends with the bounds that it has.
const MAX_CELLS: usize = 20_000;
/// Least step along a line towards the blank, mm.
const MIN_STEP: f64 = 0.01;

/// Bounds of the height above the bottom of a cylinder up to which stock stands in it, mm; 0 where none does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandingHeight {
    /// There is stock at this height.
    pub at_least: f64,
    /// There is none above this height.
    pub at_most: f64,
}

/// How high what the `earlier` plunges left of `blank` stands in the cylinder of a flat bottom, from there
/// up. Where it stands higher than `enough` mm, the search may end with any bounds above that.
pub fn standing_height(
    bottom: &CutterSolid,
    earlier: Earlier,
    blank: &Blank,
    top: &BlankTop,
    enough: f64,
) -> StandingHeight {
    let column = PlungeColumn::new(*bottom, bottom.radius, top);
    if column.top <= 0.0 {
        return StandingHeight { at_least: 0.0, at_most: 0.0 };
    }
    let near: Vec<PlungeColumn> = earlier.near(&column).copied().collect();
    let mut search = Search {
        column,
        blank,
        exact: Neighbours::around(&column, near.iter()),
        near,
        smaller: Vec::new(),
        warm: None,
    };
    let whole = search.cell(0.0, 0.0, 0);
    let mut highest = search.stock_on_middle(&whole);
    let mut queue = BinaryHeap::from([whole]);
    let mut cells = 0;
    while let Some(cell) = queue.pop() {
        let at_most = cell.at_most.max(highest);
        let is_found = at_most <= highest + TOLERANCE || highest > enough;
        if is_found || cell.divisions == MAX_DIVISIONS || cells >= MAX_CELLS {
            return StandingHeight { at_least: highest, at_most };
        }
        let half = 0.5 * search.half_width(cell.divisions);
        for (right, up) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let (x, y) = (cell.x + right * half, cell.y + up * half);
            if norm2(x, y) - std::f64::consts::SQRT_2 * half >= bottom.radius {
                continue;
            }
            cells += 1;
            let part = search.cell(x, y, cell.divisions + 1);
            if part.at_most > highest {
                highest = highest.max(search.stock_on_middle(&part));
                queue.push(part);
            }
        }
    }
    StandingHeight { at_least: highest, at_most: highest }
}

/// A square of the bottom, with the bound of the stock in it, mm.
#[derive(Clone, Copy, Debug)]
struct Cell {
    x: f64,
    y: f64,
    divisions: usize,
    at_most: f64,
}

/// By the bound; ties by place, so that the result does not depend on the heap.
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_bound = self.at_most.total_cmp(&other.at_most);
        by_bound.then(self.x.total_cmp(&other.x)).then(self.y.total_cmp(&other.y))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

/// The search in one cylinder.
struct Search<'a> {
    column: PlungeColumn,
    blank: &'a Blank,
    /// The plunges that may meet the cylinder.
    near: Vec<PlungeColumn>,
    exact: Neighbours,
    /// The plunges smaller by the half diagonal of the cells, by number of divisions.
    smaller: Vec<Neighbours>,
    /// Warm start: place on the shroud of the last query.
    warm: Option<f64>,
}

impl Search<'_> {
    /// Half the width of a cell, mm.
    fn half_width(&self, divisions: usize) -> f64 {
        self.column.cutter.radius * 0.5f64.powi(divisions as i32)
    }

    /// The cell about a place on the bottom.
    fn cell(&mut self, x: f64, y: f64, divisions: usize) -> Cell {
        let reach = std::f64::consts::SQRT_2 * self.half_width(divisions);
        while self.smaller.len() <= divisions {
            let reach = std::f64::consts::SQRT_2 * self.half_width(self.smaller.len());
            let axis = self.column.cutter.axis;
            let columns: Vec<PlungeColumn> =
                self.near.iter().filter_map(|column| shrunk(column, reach, &axis)).collect();
            self.smaller.push(Neighbours::around(&self.column, columns.iter()));
        }
        let line = self.exact.frame().line_at(x, y);
        let mut left = LineRemainder::whole(self.column.top);
        self.smaller[divisions].cut_line(&mut left, &line, f64::INFINITY, |_| {});
        Cell { x, y, divisions, at_most: self.near_blank(&left, &line, reach) }
    }

    /// Height up to which what is left of a line comes within `reach` mm of the blank, mm.
    fn near_blank(&mut self, left: &LineRemainder, line: &CoreLine, reach: f64) -> f64 {
        // The intervals of a line are in order of height.
        for &(low, high) in left.open[..left.count].iter().rev() {
            let mut h = high;
            while h > low {
                let free = self.blank.clearance(Meridional::from_point(&line.at(h)), &mut self.warm) - reach;
                if free < MIN_STEP {
                    return h;
                }
                h -= free;
            }
        }
        0.0
    }

    /// Height of the stock on the middle line of a cell, mm; 0 where that is beside the cylinder.
    fn stock_on_middle(&mut self, cell: &Cell) -> f64 {
        if norm2(cell.x, cell.y) > self.column.cutter.radius {
            return 0.0;
        }
        let line = self.exact.frame().line_at(cell.x, cell.y);
        let mut left = LineRemainder::whole(self.column.top);
        self.exact.cut_line(&mut left, &line, f64::INFINITY, |_| {});
        let highest = |&(low, high): &(f64, f64)| {
            self.blank.highest_inside(&line.origin, &line.axis, low, high, &mut self.warm)
        };
        left.open[..left.count].iter().rev().find_map(highest).unwrap_or(0.0)
    }
}

/// The plunge of `column` without what is nearer than `reach` mm, across `axis`, to what it does not remove;
/// `None` where nothing is left of it.
fn shrunk(column: &PlungeColumn, reach: f64, axis: &Vector) -> Option<PlungeColumn> {
    let CutterSolid { tip, axis: own, radius, corner_radius } = column.cutter;
    // Across the axis of the search a flat bottom comes nearer by less.
    let raise = if corner_radius > 0.0 { reach } else { reach * own.cross(axis).norm() };
    let cutter = CutterSolid {
        tip: tip + own * raise,
        axis: own,
        radius: radius - reach,
        corner_radius: (corner_radius - reach).max(0.0),
    };
    (cutter.radius > 0.0).then_some(PlungeColumn { cutter, ..*column })
}
