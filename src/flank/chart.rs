//! A chart of a layer: a grid over the channel with geodesic distances from the walls at its nodes.
//!
//! The distances come from the fans of the walls. Between two neighbouring rays and two lengths the distance
//! is interpolated linearly over two triangles. A node keeps the minimum over all triangles that hold it, so
//! the field is right behind focal points as well, where rays cross.

use super::layer::{LayerPoint, LayerSurface};
use super::layer_walls::{LayerWall, LayerWalls, y_at};
use super::region::WallName;

/// Number of walls of main blades; those of splitters come after them.
const MAIN_BLADES: usize = 2;
/// Maximum number of nodes along and across; finer charts gain nothing.
const MAX_NODES: usize = 1200;

/// A grid over a layer with a distance field per wall.
#[derive(Debug)]
pub struct LayerChart<'a> {
    /// The layer.
    pub layer: &'a LayerSurface,
    /// Its walls.
    pub borders: &'a LayerWalls,
    /// Least distance of the tool axis from a wall, mm.
    pub min_wall_distance: f64,
    rows: Vec<ChartRow>,
    columns: usize,
    step: f64,
    /// The walls: both main blades, then the splitters.
    walls: Vec<WallName>,
    /// Distance fields by wall, row by row, mm; infinite where no ray arrives.
    distances: Vec<Vec<f64>>,
    /// Offsets by wall: end points of its rays after `clear`, `clear` + `stepover`, `clear` + 2 `stepover`, …
    /// mm.
    offsets: Vec<Vec<Vec<LayerPoint>>>,
    /// Stepover: distance between neighbouring offsets, mm.
    pub stepover: f64,
}

#[derive(Clone, Copy, Debug)]
struct ChartRow {
    x: f64,
    radius: f64,
    low: f64,
    high: f64,
}

impl ChartRow {
    fn y(&self, column: f64, columns: usize) -> f64 {
        self.low + (self.high - self.low) * column / (columns - 1) as f64
    }

    fn column(&self, y: f64, columns: usize) -> f64 {
        (y - self.low) / (self.high - self.low) * (columns - 1) as f64
    }
}

/// A node of a chart.
#[derive(Clone, Copy, Debug)]
pub struct ChartNode {
    /// Its position.
    pub point: LayerPoint,
    /// Area that it represents, mm²: reduced at the limit of the tool axis, 0 beyond.
    pub free_area: f64,
    /// Index in the chart, row by row.
    pub index: usize,
}

impl<'a> LayerChart<'a> {
    /// A chart with nodes about `spacing` mm apart over the layer and `beyond` mm past its ends. `clear` is
    /// the least distance of the tool axis from a wall. The first offset of a wall is `clear` from it, the
    /// others follow at steps of `stepover` (all mm).
    pub fn new(
        layer: &'a LayerSurface,
        borders: &'a LayerWalls,
        clear: f64,
        stepover: f64,
        spacing: f64,
        beyond: f64,
    ) -> Self {
        let length = layer.to - layer.from;
        let inside = ((length / spacing).ceil() as usize).clamp(2, MAX_NODES);
        let step = length / inside as f64;
        let outside = (beyond / step).ceil() as usize + 1;
        let rows: Vec<ChartRow> = (0..inside + 2 * outside)
            .map(|i| {
                let x = layer.from + (i as f64 + 0.5 - outside as f64) * step;
                let radius = layer.radius(x).0.max(1e-6);
                let (low, high) = (borders.low.y_at(x), borders.high.y_at(x));
                ChartRow { x, radius, low, high: high.max(low + 1e-9) }
            })
            .collect();
        let widest = rows.iter().map(|r| r.radius * (r.high - r.low)).fold(0.0, f64::max);
        let columns = ((widest / spacing).ceil() as usize).clamp(3, MAX_NODES);
        let walls: Vec<WallName> = borders.all().map(|(name, _)| name).collect();
        let mut chart = Self {
            layer,
            borders,
            min_wall_distance: clear,
            columns,
            step,
            distances: vec![vec![f64::INFINITY; rows.len() * columns]; walls.len()],
            offsets: vec![Vec::new(); walls.len()],
            walls,
            rows,
            stepover,
        };
        let lengths: Vec<f64> = std::iter::once(0.0)
            .chain((0..).map(|k| clear + stepover * f64::from(k)).take_while(|l| *l < widest + stepover))
            .collect();
        // The rays start between two nodes: set the distance on the walls themselves.
        for i in 0..chart.rows.len() {
            if chart.rows[i].x >= borders.low.nose {
                chart.distances[0][i * columns] = 0.0;
            }
            if chart.rows[i].x >= borders.high.nose {
                chart.distances[1][(i + 1) * columns - 1] = 0.0;
            }
        }
        for (index, (_, wall)) in borders.all().enumerate() {
            chart.spread(index, wall, &lengths);
        }
        chart.close_splitters();
        chart
    }

    /// Sets the distance to 0 inside each splitter and at the nodes next to its outline that no triangle of
    /// rays holds.
    fn close_splitters(&mut self) {
        let fields = self.distances.iter_mut().skip(MAIN_BLADES);
        for (splitter, field) in self.borders.splitters.iter().zip(fields) {
            let begins = splitter.nose.x - self.step;
            for (i, row) in self.rows.iter().enumerate().filter(|(_, row)| row.x > begins) {
                let margin = 2.0 * self.step / row.radius;
                let [low, high] = [0, 1].map(|side: usize| y_at(&splitter.sides[side], row.x));
                for j in 0..self.columns {
                    let y = row.y(j as f64, self.columns);
                    let here = &mut field[i * self.columns + j];
                    let inside = (low..=high).contains(&y);
                    if inside || here.is_infinite() && (low - margin..=high + margin).contains(&y) {
                        *here = 0.0;
                    }
                }
            }
        }
    }

    /// Computes the distance field and the offsets of one wall.
    fn spread(&mut self, index: usize, wall: &LayerWall, lengths: &[f64]) {
        let fan = wall.fan(self.layer, lengths);
        let places: Vec<Vec<(f64, f64)>> =
            fan.iter().map(|row| row.iter().map(|p| self.locate(*p)).collect()).collect();
        let mut field = std::mem::take(&mut self.distances[index]);
        for k in 1..places.len() {
            let (near, far) = (&places[k - 1], &places[k]);
            for j in 1..near.len() {
                let [a, b, c, d] = [near[j - 1], near[j], far[j - 1], far[j]];
                let (l, m) = (lengths[k - 1], lengths[k]);
                self.fill_triangle(&mut field, [(a, l), (b, l), (c, m)]);
                self.fill_triangle(&mut field, [(b, l), (d, m), (c, m)]);
            }
        }
        self.distances[index] = field;
        self.offsets[index] = fan.into_iter().skip(1).collect();
    }

    /// The walls on the layer: of both main blades, then of the splitters.
    pub fn walls(&self) -> impl Iterator<Item = WallName> {
        self.walls.iter().copied()
    }

    fn index(&self, wall: WallName) -> Option<usize> {
        self.walls.iter().position(|known| *known == wall)
    }

    /// True offsets of a wall: the first `clear` from it, the others at steps of the stepover. None of a wall
    /// that is not on the layer.
    pub fn offsets(&self, wall: WallName) -> &[Vec<LayerPoint>] {
        self.index(wall).map_or(&[], |index| &self.offsets[index])
    }

    /// Fractional row and column of a point.
    fn locate(&self, p: LayerPoint) -> (f64, f64) {
        let at = (p.x - self.rows[0].x) / self.step;
        let last = self.rows.len() - 1;
        let i = (at.floor().max(0.0) as usize).min(last - 1);
        let share = (at - i as f64).clamp(0.0, 1.0);
        let (a, b) = (&self.rows[i], &self.rows[i + 1]);
        if !(0.0..=last as f64).contains(&at) {
            let (low, high) = (self.borders.low.y_at(p.x), self.borders.high.y_at(p.x));
            return (at, ChartRow { low, high, ..*a }.column(p.y, self.columns));
        }
        let row =
            ChartRow { low: a.low + share * (b.low - a.low), high: a.high + share * (b.high - a.high), ..*a };
        (at, row.column(p.y, self.columns))
    }

    fn fill_triangle(&self, field: &mut [f64], corners: [((f64, f64), f64); 3]) {
        let [((ax, ay), la), ((bx, by), lb), ((cx, cy), lc)] = corners;
        let (rows, columns) = (self.rows.len() as f64, self.columns as f64);
        let low_row = ax.min(bx).min(cx).max(0.0).ceil();
        let high_row = ax.max(bx).max(cx).min(rows - 1.0).floor();
        let low_column = ay.min(by).min(cy).max(0.0).ceil();
        let high_column = ay.max(by).max(cy).min(columns - 1.0).floor();
        if !(low_row <= high_row && low_column <= high_column) {
            return;
        }
        let twice = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if twice.abs() < 1e-12 {
            return;
        }
        for i in low_row as usize..=high_row as usize {
            for j in low_column as usize..=high_column as usize {
                let (x, y) = (i as f64 - ax, j as f64 - ay);
                let s = (x * (cy - ay) - y * (cx - ax)) / twice;
                let t = ((bx - ax) * y - (by - ay) * x) / twice;
                if s >= -1e-9 && t >= -1e-9 && s + t <= 1.0 + 1e-9 {
                    let distance = la + s * (lb - la) + t * (lc - la);
                    let here = &mut field[i * self.columns + j];
                    *here = here.min(distance);
                }
            }
        }
    }

    /// Distance of a point from a wall, mm; infinite where no ray of it arrives or the wall is not on the
    /// layer.
    pub fn distance(&self, wall: WallName, p: LayerPoint) -> f64 {
        let Some(field) = self.index(wall).map(|index| &self.distances[index]) else { return f64::INFINITY };
        let (row, column) = self.locate(p);
        let (last_row, last_column) = (self.rows.len() - 2, self.columns - 2);
        let i = (row.max(0.0) as usize).min(last_row);
        let j = (column.max(0.0) as usize).min(last_column);
        let (s, t) = (row - i as f64, column - j as f64);
        let at = |i: usize, j: usize| field[i * self.columns + j];
        let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
        let value = (1.0 - s) * ((1.0 - t) * a + t * b) + s * ((1.0 - t) * c + t * d);
        // Next to a node that no ray reaches the mean would be infinite.
        if value.is_finite() { value } else { a.min(b).min(c).min(d) }
    }

    /// Whether a point is between the walls of the channel or their extensions.
    pub fn is_between(&self, p: LayerPoint) -> bool {
        let (_, column) = self.locate(p);
        (0.0..=(self.columns - 1) as f64).contains(&column)
    }

    /// Distance of a point from the nearest wall beyond the least allowed one, mm. Negative where the tool
    /// axis would be too near to a wall, inside a splitter and beyond the walls.
    pub fn wall_margin(&self, p: LayerPoint) -> f64 {
        if self.borders.region(p).is_none() || !self.is_between(p) {
            return -self.min_wall_distance;
        }
        self.walls().map(|wall| self.distance(wall, p)).fold(f64::INFINITY, f64::min) - self.min_wall_distance
    }

    /// All nodes within the layer that the tool axis may reach.
    pub fn free_nodes(&self) -> Vec<ChartNode> {
        let mut nodes = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            if row.x < self.layer.from || row.x > self.layer.to {
                continue;
            }
            let across = row.radius * (row.high - row.low) / (self.columns - 1) as f64;
            for j in 0..self.columns {
                let index = i * self.columns + j;
                let least = self.distances.iter().map(|d| d[index]).fold(f64::INFINITY, f64::min);
                let free = least - self.min_wall_distance;
                let blur = 0.5 * (self.step + across);
                let share = (free / blur + 0.5).clamp(0.0, 1.0);
                if share <= 0.0 || !least.is_finite() {
                    continue;
                }
                let point = LayerPoint { x: row.x, y: row.y(j as f64, self.columns) };
                if self.borders.region(point).is_some() {
                    nodes.push(ChartNode { point, free_area: share * self.step * across, index });
                }
            }
        }
        nodes
    }

    /// Distance of every node from the nearest of the `curves`, mm; infinite where it is not below `reach`.
    pub fn nearest_curve<'c>(&self, curves: impl Iterator<Item = &'c [LayerPoint]>, reach: f64) -> Vec<f64> {
        let mut nearest = vec![f64::INFINITY; self.rows.len() * self.columns];
        for curve in curves {
            for pair in curve.windows(2) {
                self.stamp(&mut nearest, pair[0], pair[1], reach);
            }
        }
        for d in &mut nearest {
            *d = d.sqrt();
        }
        nearest
    }

    /// Updates the squared distances with those from one short straight segment.
    fn stamp(&self, nearest: &mut [f64], a: LayerPoint, b: LayerPoint, reach: f64) {
        let row_of = |x: f64| (x - self.rows[0].x) / self.step;
        let first = row_of(a.x.min(b.x) - reach).ceil().max(0.0) as usize;
        let last = row_of(a.x.max(b.x) + reach).floor().min((self.rows.len() - 1) as f64);
        if last < 0.0 {
            return;
        }
        for i in first..=last as usize {
            let row = &self.rows[i];
            let aside = reach / row.radius;
            let from = row.column(a.y.min(b.y) - aside, self.columns).ceil().max(0.0);
            let to = row.column(a.y.max(b.y) + aside, self.columns).floor().min((self.columns - 1) as f64);
            if from > to {
                continue;
            }
            let middle_radius = 0.5 * (row.radius + self.layer.radius(0.5 * (a.x + b.x)).0);
            let (dx, dy) = (b.x - a.x, middle_radius * (b.y - a.y));
            let squared = (dx * dx + dy * dy).max(1e-18);
            for j in from as usize..=to as usize {
                let (px, py) = (row.x - a.x, middle_radius * (row.y(j as f64, self.columns) - a.y));
                let t = ((px * dx + py * dy) / squared).clamp(0.0, 1.0);
                let (ex, ey) = (px - t * dx, py - t * dy);
                let here = &mut nearest[i * self.columns + j];
                *here = here.min(ex * ex + ey * ey);
            }
        }
    }

    /// Length of the lines equidistant from two walls, within the layer and where the tool axis may be, mm.
    pub fn seam_length(&self) -> f64 {
        let mut length = 0.0;
        let mut last: Vec<(usize, usize, LayerPoint)> = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            if row.x < self.layer.from || row.x > self.layer.to {
                continue;
            }
            let at = |w: usize, j: usize| self.distances[w][i * self.columns + j];
            let nearest = |j: usize| {
                (0..self.walls.len())
                    .filter(|&w| at(w, j).is_finite())
                    .min_by(|&a, &b| at(a, j).total_cmp(&at(b, j)))
            };
            let mut here = Vec::new();
            for j in 1..self.columns {
                let (Some(a), Some(b)) = (nearest(j - 1), nearest(j)) else { continue };
                if a == b {
                    continue;
                }
                let (before, after) = (at(b, j - 1) - at(a, j - 1), at(b, j) - at(a, j));
                let share = if (before - after).abs() > 1e-12 { before / (before - after) } else { 0.5 };
                let column = (j - 1) as f64 + share.clamp(0.0, 1.0);
                let point = LayerPoint { x: row.x, y: row.y(column, self.columns) };
                if self.wall_margin(point) > 0.0 {
                    here.push((a, b, point));
                }
            }
            for (a, b, p) in &here {
                let before = last.iter().filter(|(c, d, _)| c == a && d == b).map(|(_, _, q)| *q);
                let step = before.map(|q| self.layer.segment_length(q, *p)).fold(f64::INFINITY, f64::min);
                // A seam that begins in this row has run half a row already.
                length += if step.is_finite() { step } else { 0.5 * self.step };
            }
            last = here;
        }
        length
    }

    /// The pieces of `line` on which `keep` is not negative, cut at its zeros.
    pub fn clip(&self, line: &[LayerPoint], keep: impl Fn(LayerPoint) -> f64) -> Vec<Vec<LayerPoint>> {
        let mut pieces: Vec<Vec<LayerPoint>> = Vec::new();
        let mut open: Vec<LayerPoint> = Vec::new();
        let mut last: Option<(LayerPoint, f64)> = None;
        for &p in line {
            let value = keep(p);
            if let Some((q, before)) = last.filter(|(_, before)| (*before >= 0.0) != (value >= 0.0)) {
                open.push(crossing(q, p, before >= 0.0, &keep));
                if before >= 0.0 {
                    pieces.push(std::mem::take(&mut open));
                }
            }
            if value >= 0.0 {
                open.push(p);
            }
            last = Some((p, value));
        }
        pieces.push(open);
        pieces.retain(|piece| piece.len() >= 2 && self.layer.length(piece) > 1e-6);
        pieces
    }
}

/// Where between `a` and `b` the sign changes, by bisection: `keep` may be discontinuous.
fn crossing(a: LayerPoint, b: LayerPoint, a_is_kept: bool, keep: &impl Fn(LayerPoint) -> f64) -> LayerPoint {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if (keep(a.lerp(b, middle)) >= 0.0) == a_is_kept {
            low = middle;
        } else {
            high = middle;
        }
    }
    a.lerp(b, if a_is_kept { low } else { high })
}
