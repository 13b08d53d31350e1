//! The area of a blade in the meridional plane, and which bodies of revolution lie beside it.
//!
//! A flood over a grid: it starts where the blade is outside of all bodies and stops at their surfaces. What
//! it meets at once touches the blade, what it meets soon is beside it. A shaft in the hub's bore is never
//! met.

use std::collections::{HashSet, VecDeque};

use super::surface::MeshSurface;
use super::trim::BodyOutline;
use crate::geometry::{Meridional, Point, norm2};

/// Cells along the larger extent of the blade.
const CELLS: f64 = 128.0;
/// Distance in the meridional plane, in cells, below which triangles count as the same.
const SAME: f64 = 1.0 / 16.0;
/// Steps of the flood within which a body touches the blade, and within which it is beside it, such as a
/// casing over a gap.
const TOUCHES: u16 = 3;
const BESIDE: u16 = 8;
/// Share of the blade within a closed body from which on that body is around the wheel, such as a blank.
const ENCLOSED: f64 = 0.95;

/// How a body lies beside a blade.
#[derive(Clone, Debug, Default)]
pub struct Neighbourhood {
    /// Number of cells of its surface that touch the blade.
    pub touching: usize,
    /// Number of cells of its surface that touch the blade or are beside it.
    pub beside: usize,
    /// Whether all of them are at the outer end of the blade.
    pub only_at_rim: bool,
}

/// The area of a blade in the meridional plane.
pub struct MeridionalArea {
    /// Corner of the grid, with the smallest r and z.
    low: Meridional,
    /// Width of a cell, mm.
    cell: f64,
    columns: usize,
    rows: usize,
    /// Largest radius of the blade, mm.
    rim: f64,
    /// A point of the blade in each cell that it covers.
    covered: Vec<Option<Meridional>>,
}

impl MeridionalArea {
    /// The area of `blade` about Z; `None` where it has no extent.
    pub fn from_blade(blade: &MeshSurface) -> Option<Self> {
        let (mut low, mut high) = ((f64::INFINITY, f64::INFINITY), (0.0_f64, f64::NEG_INFINITY));
        for p in blade.points.iter().map(Meridional::from_point) {
            low = (low.0.min(p.r), low.1.min(p.z));
            high = (high.0.max(p.r), high.1.max(p.z));
        }
        let cell = (high.0 - low.0).max(high.1 - low.1) / CELLS;
        if !(cell.is_finite() && cell > 1e-9) {
            return None;
        }
        let margin = f64::from(BESIDE + 2) * cell;
        let low_corner = Meridional { r: low.0 - margin, z: low.1 - margin };
        let count = |from: f64, to: f64| ((to + margin - from) / cell).ceil() as usize + 1;
        let (columns, rows) = (count(low_corner.r, high.0), count(low_corner.z, high.1));
        let covered = vec![None; columns * rows];
        let mut area = Self { low: low_corner, cell, columns, rows, rim: high.0, covered };
        let mut covered = std::mem::take(&mut area.covered);
        area.each_point(blade, |cell, p| {
            covered[cell].get_or_insert(p);
        });
        area.covered = covered;
        Some(area)
    }

    /// Share of the corners of `other` that lie in the area or beside it.
    pub fn share_of(&self, other: &MeshSurface) -> f64 {
        let within = |p: &Meridional| {
            let reach = self.cell * f64::from(TOUCHES);
            let steps = [-reach, 0.0, reach];
            steps.iter().any(|dr| {
                steps.iter().any(|dz| {
                    let near = Meridional { r: p.r + dr, z: p.z + dz };
                    self.cell_of(near).is_some_and(|cell| self.covered[cell].is_some())
                })
            })
        };
        let count = other.points.iter().map(Meridional::from_point).filter(within).count();
        count as f64 / other.points.len().max(1) as f64
    }

    /// How each of `bodies` lies beside the blade.
    pub fn neighbourhoods(&self, bodies: &[&MeshSurface]) -> Vec<Neighbourhood> {
        let surfaces: Vec<Vec<usize>> = bodies.iter().map(|body| self.cells_of(body)).collect();
        let walls = |of: &dyn Fn(usize) -> bool| {
            let mut walls = vec![false; self.covered.len()];
            for (_, cells) in surfaces.iter().enumerate().filter(|(k, _)| of(*k)) {
                cells.iter().for_each(|cell| walls[*cell] = true);
            }
            walls
        };
        // The blade in pieces between the surfaces of the bodies; each is within a body or outside.
        let pieces = self.pieces(&walls(&|_| true));
        let outlines: Vec<Option<BodyOutline>> = bodies.iter().map(|b| BodyOutline::from_body(b)).collect();
        let within: Vec<Vec<bool>> = pieces
            .iter()
            .map(|piece| {
                let middle = self.covered[piece[piece.len() / 2]];
                let contains = |o: &Option<BodyOutline>| {
                    o.as_ref().zip(middle).is_some_and(|(outline, middle)| outline.contains(middle))
                };
                outlines.iter().map(contains).collect()
            })
            .collect();
        let all: usize = pieces.iter().map(Vec::len).sum();
        let encloses: Vec<bool> = (0..bodies.len())
            .map(|k| {
                let held = pieces.iter().zip(&within).filter(|(_, within)| within[k]);
                held.map(|(piece, _)| piece.len()).sum::<usize>() as f64 > ENCLOSED * all.max(1) as f64
            })
            .collect();
        let is_free =
            |within: &[bool]| !within.iter().zip(&encloses).any(|(within, around)| *within && !around);
        let free =
            pieces.iter().zip(&within).filter(|(_, within)| is_free(within)).flat_map(|(piece, _)| piece);
        let steps = self.flood(free.copied(), &walls(&|k| !encloses[k]));
        let outer = self.rim - f64::from(TOUCHES) * self.cell;
        let neighbourhood = |(cells, around): (&Vec<usize>, &bool)| {
            if *around {
                return Neighbourhood::default();
            }
            let met = || cells.iter().filter(|cell| steps[**cell] <= BESIDE);
            Neighbourhood {
                touching: cells.iter().filter(|cell| steps[**cell] <= TOUCHES).count(),
                beside: met().count(),
                only_at_rim: met().all(|cell| self.low.r + (cell % self.columns) as f64 * self.cell > outer),
            }
        };
        surfaces.iter().zip(&encloses).map(neighbourhood).collect()
    }

    /// The covered cells off the `walls`, in pieces that hang together.
    fn pieces(&self, walls: &[bool]) -> Vec<Vec<usize>> {
        let mut open: Vec<bool> =
            self.covered.iter().zip(walls).map(|(covered, wall)| covered.is_some() && !wall).collect();
        let mut pieces = Vec::new();
        for start in 0..open.len() {
            if !std::mem::take(&mut open[start]) {
                continue;
            }
            let (mut piece, mut next) = (vec![start], 0);
            while next < piece.len() {
                for cell in self.around(piece[next]) {
                    if std::mem::take(&mut open[cell]) {
                        piece.push(cell);
                    }
                }
                next += 1;
            }
            pieces.push(piece);
        }
        pieces
    }

    /// Number of steps from the cells `from` to each cell, up to [`BESIDE`]; it does not pass `walls`.
    fn flood(&self, from: impl Iterator<Item = usize>, walls: &[bool]) -> Vec<u16> {
        let mut steps = vec![u16::MAX; walls.len()];
        let mut waiting: VecDeque<usize> = from.collect();
        waiting.iter().for_each(|cell| steps[*cell] = 0);
        while let Some(cell) = waiting.pop_front() {
            for next in self.around(cell) {
                if steps[next] == u16::MAX {
                    steps[next] = steps[cell] + 1;
                    if !walls[next] && steps[next] < BESIDE {
                        waiting.push_back(next);
                    }
                }
            }
        }
        steps
    }

    /// The four cells beside a cell, those that exist.
    fn around(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, row, columns, rows) =
            (cell % self.columns, cell / self.columns, self.columns, self.rows);
        [
            (column > 0).then(|| cell - 1),
            (column + 1 < columns).then(|| cell + 1),
            (row > 0).then(|| cell - columns),
            (row + 1 < rows).then(|| cell + columns),
        ]
        .into_iter()
        .flatten()
    }

    fn cell_of(&self, p: Meridional) -> Option<usize> {
        let (column, row) = ((p.r - self.low.r) / self.cell, (p.z - self.low.z) / self.cell);
        let inside = column >= 0.0 && row >= 0.0;
        let (column, row) = (column as usize, row as usize);
        (inside && column < self.columns && row < self.rows).then_some(row * self.columns + column)
    }

    /// The cells that a surface meets, in order.
    fn cells_of(&self, surface: &MeshSurface) -> Vec<usize> {
        let mut met = vec![false; self.covered.len()];
        self.each_point(surface, |cell, _| met[cell] = true);
        (0..met.len()).filter(|&cell| met[cell]).collect()
    }

    /// Calls `found` with points of a surface, of which neighbouring ones are less than half a cell apart in
    /// the meridional plane: triangles are halved until they are that small.
    ///
    /// Triangles of a body of revolution repeat all round the axis. One that differs from another by less
    /// than [`SAME`] in the meridional plane is passed over.
    fn each_point(&self, surface: &MeshSurface, mut found: impl FnMut(usize, Meridional)) {
        let high = Meridional {
            r: self.low.r + self.columns as f64 * self.cell,
            z: self.low.z + self.rows as f64 * self.cell,
        };
        let rounded = |p: &Point| {
            let m = Meridional::from_point(p);
            [m.r, m.z].map(|x| (x / (SAME * self.cell)).round() as i64)
        };
        let mut seen: HashSet<[[[i64; 2]; 3]; 2]> = HashSet::new();
        let mut waiting: Vec<[Point; 3]> = Vec::new();
        for t in &surface.triangles {
            let [a, b, c] = t.map(|i| surface.points[i as usize]);
            let middle = |a: &Point, b: &Point| rounded(&nalgebra::center(a, b));
            let corners = [rounded(&a), rounded(&b), rounded(&c)];
            let middles = [middle(&a, &b), middle(&b, &c), middle(&c, &a)];
            if !seen.insert([corners, middles]) {
                continue;
            }
            waiting.push([a, b, c]);
            while let Some(corners) = waiting.pop() {
                let m = corners.map(|p| Meridional::from_point(&p));
                let (below, above) = (
                    m.iter().all(|p| p.z < self.low.z) || m.iter().all(|p| p.r < self.low.r),
                    m.iter().all(|p| p.z > high.z),
                );
                // The distance of an edge from the axis is less than that of its ends by at most half of it.
                let edge = |k: usize| (corners[k], corners[(k + 1) % 3]);
                let width = (0..3).map(|k| norm2(edge(k).0.x - edge(k).1.x, edge(k).0.y - edge(k).1.y));
                let width = width.fold(0.0, f64::max);
                if below || above || m.iter().all(|p| p.r - width > high.r) {
                    continue;
                }
                for p in m {
                    if let Some(cell) = self.cell_of(p) {
                        found(cell, p);
                    }
                }
                let middle = |k: usize| nalgebra::center(&edge(k).0, &edge(k).1);
                let length = |k: usize| {
                    let (a, b, mid) = (m[k], m[(k + 1) % 3], Meridional::from_point(&middle(k)));
                    norm2(a.r - mid.r, a.z - mid.z) + norm2(b.r - mid.r, b.z - mid.z)
                };
                let lengths = [length(0), length(1), length(2)];
                let longest = (0..3).max_by(|&a, &b| lengths[a].total_cmp(&lengths[b])).unwrap_or(0);
                if lengths[longest] > 0.5 * self.cell {
                    let (a, b, c) = (longest, (longest + 1) % 3, (longest + 2) % 3);
                    let half = middle(longest);
                    waiting.push([corners[a], half, corners[c]]);
                    waiting.push([half, corners[b], corners[c]]);
                }
            }
        }
    }
}
