//! Height map of the stock on the hub of a stretch, and the gain of one more plunge.

use rayon::prelude::*;

use crate::geometry::{CutterSolid, Meridional, Point, Vector, wrap_angle};
use crate::part::{Impeller, Workpiece};
use crate::plunge::section_layout::PassageStretch;
use crate::setup::Tool;

/// Edge length of a cell in cutter radii.
const CELL_RADII: f64 = 0.2;
/// Maximum number of cells along and across a stretch.
const MAX_CELLS: usize = 4000;
/// Distance from the tip up to which a cutter may change cells, in radii: the flank may meet stock on a hub
/// that rises beside it.
const REACH_RADII: f64 = 1.25;
/// Distance from the tip up to which a cell counts as well under a cutter, in radii.
const WELL_UNDER_RADII: f64 = 0.8;
/// Thickness at which the cost of a layer saturates, in cutter radii: uncut stock is as high as the channel.
const MAX_LAYER_RADII: f64 = 1.0;
/// Cost of a cell that no plunge has cut, beyond that of the thickest layer, in cutter radii.
const UNCUT_RADII: f64 = 1.0;
/// Layer above the allowance below which a cell counts as cut without looking where its stock ends, in cutter
/// radii.
const CUT_RADII: f64 = 0.3;
/// Share of the height of its stock at which a cell counts as cut: slightly less than what the figures of a
/// plan call uncut, so that they agree.
const CUT_SHARE: f64 = 0.995;
/// Tolerance of that height, in cutter radii, and maximum number of steps of its search.
const TOP_TOLERANCE_RADII: f64 = 1e-3;
const MAX_TOP_STEPS: usize = 60;

/// Gain of a plunge.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gain {
    /// Decrease of the cost of the floor, mm³.
    pub cost: f64,
    /// Maximum decrease of the height of a cell, mm.
    pub drop: f64,
}

/// One cell of the height map.
#[derive(Clone, Copy, Debug)]
struct FloorMapCell {
    point: Point,
    normal: Vector,
    area: f64,
    /// Height of the stock along the normal, mm; infinite where nothing was cut.
    height: f64,
    /// Height at which the stock ends without any plunge: at the outline of the blank, or at the allowance of
    /// a blade that leans over the cell, mm; infinite where that was not measured.
    top: f64,
}

impl FloorMapCell {
    fn is_uncut(&self, height: f64) -> bool {
        height >= CUT_SHARE * self.top
    }
}

/// What counts as a gain of a plunge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FloorGoal {
    /// Thinner layers.
    Layers,
    /// Thinner layers, and cells that no plunge has cut.
    UncutCells,
}

/// Cells at one s, evenly spaced from wall to wall.
#[derive(Clone, Debug)]
struct FloorMapRow {
    /// θ of the first wall's foot with its allowance, and the angle from cell to cell, rad.
    from: f64,
    step: f64,
    /// Radius, mm.
    r: f64,
    cells: Vec<FloorMapCell>,
}

/// Height map of the stock on the hub of a stretch.
#[derive(Clone, Debug)]
pub struct FloorHeightMap {
    rows: Vec<FloorMapRow>,
    /// s of the first row, and step of s from row to row.
    s_from: f64,
    s_step: f64,
    /// mm of hub per unit of s.
    length: f64,
    allowance: f64,
    /// Layer e for which e²/`scale` equals e in the cost, and the layer at which the cost saturates, mm.
    scale: f64,
    max_layer: f64,
    goal: FloorGoal,
}

impl FloorHeightMap {
    /// The uncut floor of `stretch` between the feet of the walls, each with `blade_allowance` mm.
    pub fn new(
        part: &Impeller,
        stretch: &PassageStretch,
        tool: &Tool,
        (hub_allowance, blade_allowance): (f64, f64),
        scale: f64,
    ) -> Self {
        let edge = CELL_RADII * tool.radius();
        let (from, to) = (stretch.from.min(1.0), stretch.to.max(0.0));
        let length = part.hub.length();
        let count = (((from - to) * length / edge).ceil() as usize).clamp(1, MAX_CELLS);
        let s_step = (to - from) / count as f64;
        let row = |i: usize| {
            let s = from + s_step * (i as f64 + 0.5);
            let hub = part.hub.at(s);
            let r = hub.point.r;
            let mut row = FloorMapRow { from: 0.0, step: 1.0, r, cells: Vec::new() };
            let Some([low, high]) = stretch.passage.wall_angles(part, s, 0.0) else { return row };
            let margin = blade_allowance / r * part.pitch().signum();
            let width = high - low - 2.0 * margin;
            if width * margin.signum() <= 0.0 && margin != 0.0 {
                return row;
            }
            let across = ((width.abs() * r / edge).ceil() as usize).clamp(1, MAX_CELLS);
            row.from = low + margin;
            row.step = width / across as f64;
            let area = (s_step * length * row.step * r).abs();
            row.cells = (0..across)
                .map(|j| {
                    let theta = row.from + row.step * (j as f64 + 0.5);
                    let (point, normal) = (hub.point.at_angle(theta), hub.normal.direction_at_angle(theta));
                    FloorMapCell { point, normal, area, height: f64::INFINITY, top: f64::INFINITY }
                })
                .collect();
            row
        };
        Self {
            rows: (0..count).map(row).collect(),
            s_from: from + 0.5 * s_step,
            s_step,
            length,
            allowance: hub_allowance,
            scale,
            max_layer: MAX_LAYER_RADII * tool.radius(),
            goal: FloorGoal::Layers,
        }
    }

    /// The same floor, on which it is a gain of its own to cut cells that no plunge has cut, whatever layer
    /// stays on them. Cells without stock to cut count as cut.
    pub fn for_uncut_cells(mut self, workpiece: &Workpiece, blade_allowance: f64) -> Self {
        let radius = self.max_layer / MAX_LAYER_RADII;
        let (thick, tolerance) = (self.allowance + CUT_RADII * radius, TOP_TOLERANCE_RADII * radius);
        let allowance = self.allowance;
        self.rows.par_iter_mut().flat_map_iter(|row| &mut row.cells).for_each(|cell| {
            if cell.height <= thick {
                return;
            }
            cell.top = top_of_stock(workpiece, (cell.point, cell.normal), blade_allowance, tolerance);
            if cell.top <= allowance + tolerance {
                cell.height = 0.0;
            }
        });
        self.goal = FloorGoal::UncutCells;
        self
    }

    /// Whether some uncut cell is within `reach` mm of `point`.
    pub fn is_uncut_near(&self, part: &Impeller, point: &Point, reach: f64) -> bool {
        self.cells_near(part, point, reach).any(|(i, from, to)| {
            self.rows[i].cells[from..to]
                .iter()
                .any(|cell| cell.is_uncut(cell.height) && (cell.point - point).norm() <= reach)
        })
    }

    /// Uncut share of the area.
    pub fn uncut_share(&self) -> f64 {
        let cells = || self.rows.iter().flat_map(|row| &row.cells);
        let uncut: f64 = cells().filter(|cell| cell.is_uncut(cell.height)).map(|cell| cell.area).sum();
        let all: f64 = cells().map(|cell| cell.area).sum();
        if all > 0.0 { uncut / all } else { 0.0 }
    }

    /// Share of the floor area with stock more than `excess` mm above the allowance, uncut cells included.
    pub fn share_above(&self, excess: f64) -> f64 {
        let (mut thick, mut all) = (0.0, 0.0);
        for cell in self.rows.iter().flat_map(|row| &row.cells) {
            all += cell.area;
            if cell.height - self.allowance > excess {
                thick += cell.area;
            }
        }
        if all > 0.0 { thick / all } else { 0.0 }
    }

    /// Whether some cell well under `cutter` has stock more than `excess` mm above the allowance.
    pub fn is_thick_under(&self, part: &Impeller, cutter: &CutterSolid, excess: f64) -> bool {
        let reach = WELL_UNDER_RADII * cutter.radius;
        self.cells_under(part, cutter).any(|(i, from, to)| {
            self.rows[i].cells[from..to].iter().any(|cell| {
                cell.height - self.allowance > excess && (cell.point - cutter.tip).norm() <= reach
            })
        })
    }

    /// Cost per mm² of a cell whose stock is `height` mm high, mm.
    fn cost(&self, cell: &FloorMapCell, height: f64) -> f64 {
        let e = (height - self.allowance).clamp(0.0, self.max_layer);
        let layer = e + e * e / self.scale;
        match self.goal {
            FloorGoal::UncutCells if cell.is_uncut(height) => {
                layer + UNCUT_RADII * self.max_layer / MAX_LAYER_RADII
            }
            _ => layer,
        }
    }

    /// Rows and their ranges of cells that `cutter` may change.
    fn cells_under(
        &self,
        part: &Impeller,
        cutter: &CutterSolid,
    ) -> impl Iterator<Item = (usize, usize, usize)> {
        self.cells_near(part, &cutter.tip, REACH_RADII * cutter.radius)
    }

    /// Rows and their ranges of cells within `reach` mm of `point`, along and across the rows.
    fn cells_near(
        &self,
        part: &Impeller,
        point: &Point,
        reach: f64,
    ) -> impl Iterator<Item = (usize, usize, usize)> {
        let s = part.hub.s_at(part.hub.curve().project(Meridional::from_point(point)).0);
        let theta = point.y.atan2(point.x);
        let row = |s: f64| (s - self.s_from) / self.s_step;
        let (a, b) = (row(s + reach / self.length), row(s - reach / self.length));
        let last = self.rows.len() as f64 - 1.0;
        let rows = if b < 0.0 || a > last {
            1..1
        } else {
            a.ceil().max(0.0) as usize..b.floor().min(last) as usize + 1
        };
        rows.filter_map(move |i| {
            let row = &self.rows[i];
            if row.cells.is_empty() {
                return None;
            }
            // Wraps θ to the nearest turn: passages are narrower than half a turn.
            let width = row.step * row.cells.len() as f64;
            let middle = 0.5 * width + wrap_angle(theta - row.from - 0.5 * width);
            let half = (reach / row.r / row.step).abs();
            let at = middle / row.step - 0.5;
            let last = row.cells.len() as f64 - 1.0;
            if at + half < 0.0 || at - half > last {
                return None;
            }
            Some((i, (at - half).ceil().max(0.0) as usize, (at + half).floor().min(last) as usize + 1))
        })
    }

    /// Height to which `cutter` lowers a cell, if it does.
    fn lowered_height(cell: &FloorMapCell, cutter: &CutterSolid) -> Option<f64> {
        // Early exit: most cut cells are below the plane of the bottom.
        let above = (cell.point - cutter.tip).dot(&cutter.axis) + cell.height * cell.normal.dot(&cutter.axis);
        if above <= 0.0 && cell.normal.dot(&cutter.axis) > 0.0 {
            return None;
        }
        let (low, high) = cutter.column_interval(cutter.radius, &cell.point, &cell.normal)?;
        (high > 0.0 && low < cell.height).then_some(low)
    }

    /// Gain of one more plunge of `cutter`.
    pub fn gain(&self, part: &Impeller, cutter: &CutterSolid) -> Gain {
        let mut gain = Gain::default();
        for (i, from, to) in self.cells_under(part, cutter) {
            for cell in &self.rows[i].cells[from..to] {
                // A cutter leaves at least the allowance.
                if cell.height > self.allowance
                    && let Some(low) = Self::lowered_height(cell, cutter)
                {
                    gain.cost += cell.area * (self.cost(cell, cell.height) - self.cost(cell, low));
                    gain.drop = gain.drop.max(cell.height - low);
                }
            }
        }
        gain
    }

    /// Removes the stock that a plunge cuts.
    pub fn cut(&mut self, part: &Impeller, cutter: &CutterSolid) {
        let ranges: Vec<(usize, usize, usize)> = self.cells_under(part, cutter).collect();
        for (i, from, to) in ranges {
            for cell in &mut self.rows[i].cells[from..to] {
                if let Some(low) = Self::lowered_height(cell, cutter) {
                    cell.height = low;
                }
            }
        }
    }
}

/// Height along a ray from the hub (foot and unit normal) at which the stock ends, at the outline of the
/// blank or at the allowance of a blade, mm; 0 where the foot is in the allowance. Sphere tracing.
fn top_of_stock(
    Workpiece { blank, finished, .. }: &Workpiece,
    (foot, normal): (Point, Vector),
    blade_allowance: f64,
    tolerance: f64,
) -> f64 {
    let mut warm = None;
    let mut height = tolerance;
    for _ in 0..MAX_TOP_STEPS {
        let point = foot + normal * height;
        let depth = blank.depth_near(Meridional::from_point(&point), &mut warm);
        if depth < tolerance {
            break;
        }
        let nearer = finished.nearest_blade_below(&point, depth + blade_allowance);
        let free = nearer.map_or(depth, |near| near.distance - blade_allowance);
        if free < tolerance {
            break;
        }
        height += free;
    }
    height
}
