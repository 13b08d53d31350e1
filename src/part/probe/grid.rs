//! Points of a side on a grid, how far the side bends between them, and branch and bound over its cells.

use std::cell::LazyCell;

use super::query::DistanceQuery;
use super::seeds::MAX_V_LINES;
use crate::geometry::{Point, Vector};
use crate::part::side::{BladeSide, SideBends};

/// Points of a side where lines of constant u and v cross.
#[derive(Clone, Debug)]
pub(super) struct SideGrid {
    pub side: BladeSide,
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    /// Line by line of v.
    pub points: Vec<Point>,
    /// Cells between the lines, line by line of v.
    cells: Vec<GridCell>,
    /// Per cell, largest departure of the side from the bilinear patch of its corners, mm.
    sags: Vec<f64>,
}

/// How the side bends in a cell. Linear interpolation over a length h is off by up to h²/8 times the largest
/// second derivative: so far the side may depart from the bilinear patch of the four corners. That is split
/// into its part along the normal and across it, as the latter hardly changes distances: it comes from the
/// parameters of noisy sections.
#[derive(Clone, Copy, Debug)]
struct GridCell {
    normal: Vector,
    /// Departures by bending along u, and along v, mm.
    along: Sag,
    across: Sag,
    /// Range of the bending along u towards the normal, in the same measure; endless where that along v has
    /// both signs.
    bulge: [f64; 2],
    /// Largest radius of curvature of a distance for which it has one minimum along u in the cell, mm; 0
    /// where the side turns too much, or its lines may run back on themselves.
    safe_radius: f64,
}

/// A departure from a bilinear patch, mm.
#[derive(Clone, Copy, Debug, Default)]
struct Sag {
    /// Along the normal of the cell, and across it.
    normal: f64,
    tangential: f64,
}

/// Lines of v of a ruled side.
const RULED_V_LINES: usize = 5;
/// Sag of a cell, as a share of its length, up to which its direction turns by less than a quarter of a
/// radian.
const PLAIN_SAG: f64 = 0.03;
/// Departure across the normal, as a share of the length of a cell, below which its lines do not run back on
/// themselves: they do from a quarter on. Those of noisy sections do, and then have more than one minimum.
const EVEN_SAG: f64 = 0.2;
/// Bending along v that does not matter, as a departure from a bilinear patch, mm.
const STEADY: f64 = 5e-4;
/// Share of the tolerance of a search by which bounds may be too low.
const BOUND_SHARE: f64 = 0.25;
/// Share of the radius of the side up to which the radius of a distance is safe.
const SAFE_SHARE: f64 = 0.75;

impl Sag {
    /// Part along `gradient`, whose component along the normal of the cell is `cos`.
    fn along(self, cos: f64, sin: f64) -> f64 {
        cos * self.normal + sin * self.tangential
    }

    /// Widens it by the second derivative `bend` times `scale`; returns the part of that along `normal`, mm.
    fn include(&mut self, bend: &Vector, normal: &Vector, scale: f64) -> f64 {
        let height = bend.dot(normal);
        self.normal = self.normal.max(scale * height.abs());
        self.tangential = self.tangential.max(scale * (bend - normal * height).norm());
        scale * height
    }

    fn largest(self) -> f64 {
        self.normal.hypot(self.tangential)
    }
}

impl GridCell {
    fn new(corners: [&Point; 4], bends: &SideBends, u: [f64; 2], v: [f64; 2]) -> Self {
        let [a, b, c, d] = corners;
        let normal = (d - a).cross(&(c - b)).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let scale = |[from, to]: [f64; 2]| (to - from) * (to - from) / 8.0;
        let (mut along, mut across) = (Sag::default(), Sag::default());
        let mut bulges = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let widen = |[low, high]: [f64; 2], height: f64| [low.min(height), high.max(height)];
        for patch in bends.of_cell(u, v) {
            for bend in &patch.along {
                bulges[0] = widen(bulges[0], along.include(bend, &normal, scale(u)));
            }
            for bend in &patch.across {
                bulges[1] = widen(bulges[1], across.include(bend, &normal, scale(v)));
            }
        }
        let length = (b - a).norm().min((d - c).norm());
        let height = (c - a).norm().min((d - b).norm());
        let is_plain = along.normal <= PLAIN_SAG * length && across.normal <= PLAIN_SAG * height;
        // The radius of the side is at least length² / (8 sag).
        let radius = SAFE_SHARE * length * length / (8.0 * along.normal.max(1e-12));
        let is_even = along.tangential <= EVEN_SAG * length && across.tangential <= EVEN_SAG * height;
        let safe_radius = if is_plain { radius } else { 0.0 };
        // Along v local searches find one minimum, or one at either end, where the bending has one sign.
        let is_steady = bulges[1][0] > -STEADY || bulges[1][1] < STEADY;
        let (safe_radius, bulge) = match is_steady && is_even {
            true => (safe_radius, bulges[0]),
            false => (0.0, [f64::NEG_INFINITY, f64::INFINITY]),
        };
        Self { normal, along, across, bulge, safe_radius }
    }

    /// Cosine of the angle between a unit gradient and the normal, whatever its sign, and sine.
    fn angle(&self, gradient: &Vector) -> (f64, f64) {
        let cos = self.normal.dot(gradient);
        (cos.abs(), (1.0 - cos * cos).max(0.0).sqrt())
    }
}

/// Where local searches ended on the lines of v: the cell of u, and the point; `None` on lines without one.
pub(super) type Trace = [Option<(usize, Point)>; MAX_V_LINES];

/// A point of the side.
#[derive(Clone, Copy, Debug)]
pub(super) struct FoundPoint {
    pub distance: f64,
    pub u: f64,
    pub v: f64,
    pub point: Point,
}

/// A rectangle in u and v within a cell.
#[derive(Clone, Copy, Debug)]
struct Patch {
    u: [f64; 2],
    v: [f64; 2],
    /// At (u₀, v₀), (u₁, v₀), (u₀, v₁), (u₁, v₁).
    corners: [Point; 4],
    /// Shares of the sags of the cell, along u and v.
    shares: [f64; 2],
}

/// What is searched for, and what is known.
pub(super) struct CellSearch<'a, Q, F> {
    pub query: &'a Q,
    pub v_range: (f64, f64),
    /// That at a near point.
    tangent: Tangent,
    /// Most searches end before it is needed.
    trace: LazyCell<Trace, F>,
    /// Radius of curvature of the distance, mm.
    radius: f64,
    /// Certainly nothing is left that is nearer than this, mm.
    limit: f64,
    tolerance: f64,
    pub found: Option<FoundPoint>,
}

impl SideGrid {
    /// Grid over u in [`from`, `to`] (beyond 0…1 the side is extended linearly) and the whole range of v.
    pub fn new(side: &BladeSide, from: f64, to: f64) -> Self {
        let count = 40;
        let mut u: Vec<f64> =
            (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect();
        // Noses are small: the grid is finer there.
        if from == 0.0 {
            u.extend([0.003, 0.007, 0.012, 0.018]);
            u.sort_by(f64::total_cmp);
        }
        if to == 1.0 && side.has_round_tail() {
            u.extend([0.982, 0.988, 0.993, 0.997]);
            u.sort_by(f64::total_cmp);
        }
        let lines = if side.is_ruled() { RULED_V_LINES } else { MAX_V_LINES };
        let v: Vec<f64> = (0..lines).map(|j| j as f64 / (lines - 1) as f64).collect();
        let points: Vec<Point> = v.iter().flat_map(|&v| u.iter().map(move |&u| side.point(u, v))).collect();
        let bends = side.bends(u[0], u[u.len() - 1]);
        let mut grid = Self { side: side.clone(), u, v, points, cells: Vec::new(), sags: Vec::new() };
        let numbers = (0..grid.v.len() - 1).flat_map(|j| (0..grid.u.len() - 1).map(move |i| (i, j)));
        let cell = |(i, j): (usize, usize)| {
            let corners = grid.corners(i, j).map(|k| &grid.points[k]);
            GridCell::new(corners, &bends, [grid.u[i], grid.u[i + 1]], [grid.v[j], grid.v[j + 1]])
        };
        grid.cells = numbers.map(cell).collect();
        grid.sags = grid.cells.iter().map(|cell| cell.along.largest() + cell.across.largest()).collect();
        grid
    }

    /// Indices in `points` of the corners of the cell after line `i` of u and line `j` of v.
    pub fn corners(&self, i: usize, j: usize) -> [usize; 4] {
        let n = self.u.len();
        [j * n + i, j * n + i + 1, (j + 1) * n + i, (j + 1) * n + i + 1]
    }

    fn cell(&self, i: usize, j: usize) -> &GridCell {
        &self.cells[j * (self.u.len() - 1) + i]
    }

    /// Largest departure of the side from the bilinear patch of a cell, mm.
    pub fn sag(&self, i: usize, j: usize) -> f64 {
        self.sags[j * (self.u.len() - 1) + i]
    }

    /// The cell of u that contains `u`, near the cell `guess`.
    pub fn cell_of(&self, u: f64, guess: usize) -> usize {
        let mut i = guess.min(self.u.len() - 2);
        while i > 0 && u < self.u[i] {
            i -= 1;
        }
        while i + 2 < self.u.len() && u > self.u[i + 1] {
            i += 1;
        }
        i
    }

    fn patch(&self, i: usize, j: usize, (v_from, v_to): (f64, f64)) -> Patch {
        let corners = self.corners(i, j).map(|k| self.points[k]);
        let (u, v) = ([self.u[i], self.u[i + 1]], [self.v[j], self.v[j + 1]]);
        let whole = Patch { u, v, corners, shares: [1.0; 2] };
        if v_from <= v[0] && v[1] <= v_to {
            return whole;
        }
        let v = v.map(|v| v.clamp(v_from, v_to));
        let corners = [(u[0], v[0]), (u[1], v[0]), (u[0], v[1]), (u[1], v[1])];
        Patch { v, corners: corners.map(|(u, v)| self.side.point(u, v)), ..whole }
    }

    /// Looks for points in the cells from line `first` to line `last` of u that are nearer than the limit of
    /// `search`, by branch and bound: a distance from a convex body is a convex function of the point, so
    /// that it is nowhere below its tangent at any point. What is not found is not there.
    pub fn look(
        &self,
        search: &mut CellSearch<'_, impl DistanceQuery, impl FnOnce() -> Trace>,
        (first, last): (usize, usize),
    ) {
        let n = self.u.len();
        let mut waiting = Vec::new();
        let tangent = search.tangent;
        for j in 0..self.v.len() - 1 {
            if self.v[j] >= search.v_range.1 || self.v[j + 1] <= search.v_range.0 {
                continue;
            }
            let mut last_tangent = None;
            let sags = &self.sags[j * (n - 1)..(j + 1) * (n - 1)];
            let (lower, upper) = (&self.points[j * n..], &self.points[(j + 1) * n..]);
            let mut left = tangent.at(&lower[first]).min(tangent.at(&upper[first]));
            for i in first..last {
                let right = tangent.at(&lower[i + 1]).min(tangent.at(&upper[i + 1]));
                let least = left.min(right);
                left = right;
                if search.is_beyond(least - sags[i]) {
                    continue;
                }
                let cell = self.cell(i, j);
                if search.knows(cell, i, j) {
                    continue;
                }
                let corners = self.corners(i, j).map(|k| &self.points[k]);
                let own = || Tangent::new(search.query, &nalgebra::center(corners[0], corners[3]));
                let last = last_tangent.get_or_insert_with(|| search.row_tangent(j).unwrap_or_else(own));
                if search.is_beyond(last.bound(&corners, cell)) {
                    continue;
                }
                *last = own();
                if search.is_beyond(last.bound(&corners, cell)) {
                    continue;
                }
                waiting.push(self.patch(i, j, search.v_range));
                self.branch(search, cell, &mut waiting);
            }
        }
    }

    /// Branch and bound over `waiting` patches of a cell.
    fn branch(
        &self,
        search: &mut CellSearch<'_, impl DistanceQuery, impl FnOnce() -> Trace>,
        cell: &GridCell,
        waiting: &mut Vec<Patch>,
    ) {
        while let Some(patch) = waiting.pop() {
            let [a, b, c, d] = patch.corners.each_ref();
            let tangent = Tangent::new(search.query, &nalgebra::center(a, d));
            let (cos, sin) = cell.angle(&tangent.gradient);
            let sags =
                [patch.shares[0] * cell.along.along(cos, sin), patch.shares[1] * cell.across.along(cos, sin)];
            let bound = tangent.least(&[a, b, c, d]) - sags[0] - sags[1];
            if search.is_beyond(bound) {
                continue;
            }
            // Halved across the direction in which more is lost, or else across the longer one.
            let loss = |edges: [Vector; 2], sag: f64| {
                let bends = edges.map(|edge| search.query.bend(&edge, &tangent.gradient));
                sag + bends[0].max(bends[1]) / 8.0
            };
            let losses = [loss([b - a, d - c], sags[0]), loss([c - a, d - b], sags[1])];
            let is_along = if losses[0].max(losses[1]) > 0.5 * (search.limit - bound) {
                losses[0] >= losses[1]
            } else {
                let squares = |p: Vector, q: Vector| p.norm_squared().max(q.norm_squared());
                squares(b - a, d - c) >= squares(c - a, d - b)
            };
            waiting.extend(patch.halves(is_along, |u, v| {
                let point = self.side.point(u, v);
                search.offer(&point, u, v);
                point
            }));
        }
    }
}

impl<'a, Q: DistanceQuery, F: FnOnce() -> Trace> CellSearch<'a, Q, F> {
    /// A search for points that are nearer than `known` mm by `tolerance` mm at most. `tangent` is that at a
    /// near point, where the distance has the radius of curvature `radius` mm; `trace` tells where local
    /// searches ended.
    pub fn new(
        (query, v_range): (&'a Q, (f64, f64)),
        (known, tolerance): (f64, f64),
        (tangent, radius): (Tangent, f64),
        trace: F,
    ) -> Self {
        let limit = known - tolerance;
        Self { query, v_range, tangent, trace: LazyCell::new(trace), radius, limit, tolerance, found: None }
    }

    /// Whether what is certainly not nearer than `bound` mm does not matter.
    #[inline]
    pub fn is_beyond(&self, bound: f64) -> bool {
        bound >= self.limit || bound.is_nan()
    }

    /// Whether local searches came by a cell so that its nearest point is known: along u the distance has one
    /// minimum there, as the side is straighter than the cutter or bulges towards it.
    fn knows(&self, cell: &GridCell, i: usize, j: usize) -> bool {
        let (Some((a, _)), Some((b, _))) = (self.trace[j], self.trace[j + 1]) else { return false };
        // Where they are apart, two minima exchange roles between the lines.
        if a.abs_diff(b) > 1 || i + 1 < a.min(b) || i > a.max(b) + 1 {
            return false;
        }
        if self.radius <= cell.safe_radius {
            return true;
        }
        let cos = cell.normal.dot(&self.tangent.gradient);
        if cos > 0.0 { cell.bulge[0] >= 0.0 } else { cell.bulge[1] <= 0.0 }
    }

    /// The tangent where the local search on the lower line of a row of cells ended.
    fn row_tangent(&self, j: usize) -> Option<Tangent> {
        let (_, point) = self.trace[j]?;
        Some(Tangent::new(self.query, &point))
    }

    fn offer(&mut self, point: &Point, u: f64, v: f64) {
        let distance = self.query.distance(point);
        // A part of the tolerance is left to the bounds, which else would have to be exact.
        if distance < self.limit + BOUND_SHARE * self.tolerance {
            self.found = Some(FoundPoint { distance, u, v, point: *point });
            self.limit = distance - self.tolerance;
        }
    }
}

/// A plane in space and distance that is nowhere above the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent {
    gradient: Vector,
    offset: f64,
}

impl Tangent {
    /// That at `point`.
    pub fn new(query: &impl DistanceQuery, point: &Point) -> Self {
        let (distance, gradient) = query.gradient(point);
        Self { gradient, offset: distance - gradient.dot(&point.coords) }
    }

    pub fn gradient(&self) -> &Vector {
        &self.gradient
    }

    /// Lower bound on the distance of a point, mm.
    #[inline]
    pub fn at(&self, point: &Point) -> f64 {
        self.offset + self.gradient.dot(&point.coords)
    }

    /// Lower bound on the distances of the hull of `corners`, mm.
    fn least(&self, corners: &[&Point; 4]) -> f64 {
        let [a, b, c, d] = corners.map(|corner| self.at(corner));
        a.min(b).min(c.min(d))
    }

    /// Lower bound on the distance of a cell, mm.
    fn bound(&self, corners: &[&Point; 4], cell: &GridCell) -> f64 {
        let (cos, sin) = cell.angle(&self.gradient);
        self.least(corners) - cell.along.along(cos, sin) - cell.across.along(cos, sin)
    }
}

impl Patch {
    /// Both halves along u or along v; `point` gives that at (u, v).
    fn halves(&self, is_along: bool, mut point: impl FnMut(f64, f64) -> Point) -> [Self; 2] {
        let [a, b, c, d] = self.corners;
        let (mut low, mut high) = (*self, *self);
        if is_along {
            let u = 0.5 * (self.u[0] + self.u[1]);
            let middle = self.v.map(|v| point(u, v));
            (low.u[1], high.u[0]) = (u, u);
            low.corners = [a, middle[0], c, middle[1]];
            high.corners = [middle[0], b, middle[1], d];
        } else {
            let v = 0.5 * (self.v[0] + self.v[1]);
            let middle = self.u.map(|u| point(u, v));
            (low.v[1], high.v[0]) = (v, v);
            low.corners = [a, b, middle[0], middle[1]];
            high.corners = [middle[0], middle[1], c, d];
        }
        let halved = usize::from(!is_along);
        low.shares[halved] *= 0.25;
        high.shares[halved] *= 0.25;
        [low, high]
    }
}
