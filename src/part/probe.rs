//! Nearest distances to a blade side: from a cutter, from a point, from a piece of shank or holder.

mod blocks;
mod grid;
mod query;
mod seeds;

use blocks::{BLOCK, Blocks, MAX_BLOCKS};
use grid::{CellSearch, FoundPoint, SideGrid, Tangent};
use query::{CutterQuery, DistanceQuery, FrustumQuery, PointQuery, endless_cylinder_around};
use seeds::{LineMinimum, MAX_LINES, MAX_V_LINES, Seed, Seeds};

use super::side::BladeSide;
use crate::geometry::{CutterSolid, Frustum, Point, Vector, search};

/// Argument tolerance of the searches in u. The distance is stationary there, so its error is far below 1 µm
/// on any machinable size.
const U_TOLERANCE: f64 = 2e-5;
/// Newton step in u after which no other is needed: the error is of the order of its square.
const U_STEP: f64 = 5e-5;
/// As [`U_TOLERANCE`], in v. Near the edge of the bottom the distance has a radius of curvature no greater
/// than itself: a tolerance that is harmless elsewhere would cost 10 µm there.
const V_TOLERANCE: f64 = 4e-6;
/// How much nearer than the point found by local searches another one may be, mm: outside the cutter, and
/// where it cuts the side, as the depth of a cut needs to be accurate to that only.
const NEARER: f64 = 1e-3;
const NEARER_INSIDE: f64 = 0.01;
/// Around a point that branch and bound found, the nearest one is searched this far, in cells.
const REFINED_SHARE: f64 = 0.25;
/// The whole range of v.
const FULL_V_RANGE: (f64, f64) = (0.0, 1.0);
/// Value of `enough` that never ends a search early.
const NO_EARLY_EXIT: f64 = f64::NEG_INFINITY;

/// A blade side with a coarse grid of its points, precomputed for many distance queries.
#[derive(Clone, Debug)]
pub struct SideProbe {
    grid: SideGrid,
    blocks: Blocks,
}

/// Nearest point of a side.
#[derive(Clone, Copy, Debug)]
pub struct NearestOnSide {
    /// Signed distance, mm; negative where the cutter cuts the side.
    pub distance: f64,
    /// Parameter along the side, LE 0 … TE 1.
    pub u: f64,
    /// Parameter across the side, hub 0 … shroud 1.
    pub v: f64,
    /// The point of the side.
    pub point: Point,
}

impl From<LineMinimum> for NearestOnSide {
    fn from(LineMinimum { distance, u, v, point, .. }: LineMinimum) -> Self {
        Self { distance, u, v, point }
    }
}

impl SideProbe {
    /// Grid over u in [`from`, `to`] (beyond 0…1 the side is extended linearly) and the whole range of v.
    pub fn new(side: &BladeSide, from: f64, to: f64) -> Self {
        let grid = SideGrid::new(side, from, to);
        let blocks = Blocks::new(&grid);
        Self { grid, blocks }
    }

    /// The blade side.
    pub fn side(&self) -> &BladeSide {
        &self.grid.side
    }

    /// Nearest point of the side to `cutter` over v in [`v_from`, `v_to`].
    pub fn nearest(&self, cutter: &CutterSolid, v_from: f64, v_to: f64) -> NearestOnSide {
        self.nearest_within(&CutterQuery { cutter }, (v_from, v_to), f64::INFINITY, NO_EARLY_EXIT)
            .unwrap_or_else(|| self.infinitely_far())
    }

    /// As [`Self::nearest`] over the whole side; `None` when the side is certainly further away than `cutoff`
    /// mm.
    pub fn nearest_below(&self, cutter: &CutterSolid, cutoff: f64) -> Option<NearestOnSide> {
        self.nearest_within(&CutterQuery { cutter }, FULL_V_RANGE, cutoff, NO_EARLY_EXIT)
    }

    /// Whether any point of the side is nearer to `cutter` than `limit` mm; faster than measuring the
    /// distance.
    pub fn is_within(&self, cutter: &CutterSolid, limit: f64) -> bool {
        let near = self.nearest_within(&CutterQuery { cutter }, FULL_V_RANGE, limit, limit);
        near.is_some_and(|near| near.distance < limit)
    }

    /// As [`Self::nearest`], by a local search from a nearest point known to be close to `u`: for iterations
    /// that end with [`Self::nearest`].
    pub fn nearest_from(&self, cutter: &CutterSolid, u: f64, v_from: f64, v_to: f64) -> NearestOnSide {
        let query = CutterQuery { cutter };
        let reach = 1.5 * (self.grid.u[self.grid.u.len() - 1] - self.grid.u[0]) / self.grid.u.len() as f64;
        let mut guess = u;
        let lines = [v_from, 0.5 * (v_from + v_to), v_to].map(|v| {
            let line = self.on_line(&query, v, guess, guess - 2.0 * reach, guess + 2.0 * reach);
            guess = line.u;
            line
        });
        self.nearest_between(&query, &lines, reach)
    }

    /// Nearest point of the whole side to `point`.
    pub fn nearest_to_point(&self, point: &Point) -> NearestOnSide {
        self.nearest_within(&PointQuery { point }, FULL_V_RANGE, f64::INFINITY, NO_EARLY_EXIT)
            .unwrap_or_else(|| self.infinitely_far())
    }

    /// As [`Self::nearest_to_point`]; `None` when it is certainly more than `cutoff` mm away.
    pub fn nearest_to_point_below(&self, point: &Point, cutoff: f64) -> Option<NearestOnSide> {
        self.nearest_within(&PointQuery { point }, FULL_V_RANGE, cutoff, NO_EARLY_EXIT)
    }

    /// Signed distance from the whole side to a piece of shank or holder, mm; `None` when it is certainly
    /// more than `cutoff` mm.
    pub fn frustum_distance_below(&self, frustum: &Frustum, cutoff: f64) -> Option<f64> {
        if self.is_far_from(frustum, cutoff) {
            return None;
        }
        // An endless cylinder contains it, and is measured faster.
        let around = endless_cylinder_around(frustum);
        let near = self.nearest_below(&around, cutoff)?;
        let is_cylinder = frustum.radii[0] == frustum.radii[1];
        if is_cylinder && near.distance > 0.0 && (near.point - around.tip).dot(&around.axis) < frustum.length
        {
            return Some(near.distance);
        }
        let query = FrustumQuery { frustum };
        self.nearest_within(&query, FULL_V_RANGE, cutoff, NO_EARLY_EXIT).map(|near| near.distance)
    }

    /// Whether any point of the side is nearer to a piece of shank or holder than `limit` mm; faster than
    /// measuring the distance.
    pub fn frustum_is_within(&self, frustum: &Frustum, limit: f64) -> bool {
        if self.is_far_from(frustum, limit) {
            return false;
        }
        if !self.is_within(&endless_cylinder_around(frustum), limit) {
            return false;
        }
        let near = self.nearest_within(&FrustumQuery { frustum }, FULL_V_RANGE, limit, limit);
        near.is_some_and(|near| near.distance < limit)
    }

    /// Whether the balls about the side are further from the axis of a piece of shank or holder than its
    /// widest radius and `distance` mm.
    fn is_far_from(&self, frustum: &Frustum, distance: f64) -> bool {
        let widest = frustum.radii[0].max(frustum.radii[1]) + distance;
        self.blocks.strips.iter().all(|(centre, radius)| {
            let d = centre - frustum.base;
            let along = d.dot(&frustum.axis).clamp(0.0, frustum.length);
            let reach = widest + radius;
            (d - frustum.axis * along).norm_squared() > reach * reach
        })
    }

    /// A ball around the side: centre and radius, mm.
    pub fn bounding_ball(&self) -> (Point, f64) {
        let sum = self.grid.points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords);
        let centre = Point::from(sum / self.grid.points.len() as f64);
        let grid = self.grid.points.iter().zip(&self.blocks.reaches);
        (centre, grid.map(|(p, reach)| (p - centre).norm() + reach).fold(0.0, f64::max))
    }

    fn infinitely_far(&self) -> NearestOnSide {
        NearestOnSide { distance: f64::INFINITY, u: 0.0, v: 0.0, point: self.grid.points[0] }
    }

    /// Nearest point on the line `v`: Newton's method along u from `guess`, Brent's method where that fails.
    fn on_line(&self, query: &impl DistanceQuery, v: f64, guess: f64, low: f64, high: f64) -> LineMinimum {
        let (low, high) = (low.max(self.grid.u[0]), high.min(self.grid.u[self.grid.u.len() - 1]));
        let mut curve = self.grid.side.line(v);
        let line = |u: f64| {
            let (point, pv) = self.grid.side.point_and_rise(u, v);
            let (distance, gradient) = query.gradient(&point);
            LineMinimum { v, u, point, distance, slope: gradient.dot(&pv), height: query.height(&point) }
        };
        let mut u = guess.clamp(low, high);
        for _ in 0..8 {
            let (p, pu, puu) = curve.at(u);
            let Some((slope, bend)) = query.slope(&p, &pu, &puu) else { break };
            if bend <= 0.0 {
                break;
            }
            let next = (u - slope / bend).clamp(low, high);
            let moved = (next - u).abs();
            u = next;
            if moved < U_STEP {
                let line = line(u);
                if query.smooth_at(&line.point) {
                    return line;
                }
                break;
            }
        }
        let mut at = |u: f64| query.distance(&curve.at(u).0);
        let inner = search::minimum(&mut at, low, high, U_TOLERANCE);
        let [inner, low, high] = [inner, (low, at(low)), (high, at(high))];
        let end = if low.1 < high.1 { low } else { high };
        line(if end.1 < inner.1 { end.0 } else { inner.0 })
    }

    /// Nearest point over v from `v_from` to `v_to`; `None` when the side is certainly further away than
    /// `cutoff` mm. Returns early with the first point nearer than `enough` mm.
    fn nearest_within(
        &self,
        query: &impl DistanceQuery,
        (v_from, v_to): (f64, f64),
        cutoff: f64,
        enough: f64,
    ) -> Option<NearestOnSide> {
        let mut strips = [0.0; MAX_BLOCKS];
        let mut nearest = f64::INFINITY;
        for (bound, (centre, radius)) in strips.iter_mut().zip(&self.blocks.strips) {
            *bound = query.distance(centre) - radius;
            nearest = nearest.min(*bound);
        }
        if nearest > cutoff {
            return None;
        }
        let seeds = self.seeds(query, &strips, (v_from, v_to), enough);
        if let Some(seed) = seeds.lines[..seeds.count].last().filter(|seed| seed.distance < enough) {
            let (u, v) = (self.grid.u[seed.index], self.grid.v[seed.line]);
            let point = self.grid.points[seed.line * self.grid.u.len() + seed.index];
            return Some(NearestOnSide { distance: seed.distance, u, v, point });
        }
        if seeds.lower_bound > cutoff {
            return None;
        }
        let mut lines = [LineMinimum::default(); MAX_LINES];
        let mut drift = 0.0f64;
        let near = seeds.near(cutoff);
        for (line, seed) in lines.iter_mut().zip(near) {
            let (found, shift) = self.line_near(query, seed);
            if found.distance < enough {
                return Some(found.into());
            }
            *line = found;
            drift = drift.max(shift);
        }
        let near = self.nearest_between(query, &lines[..near.len()], drift);
        let known = || seeds.near(cutoff).iter().zip(&lines);
        Some(self.certified(query, &strips, (v_from, v_to), near, known, cutoff))
    }

    /// `near`, or a point that is nearer by more than a tolerance if there is one below `cutoff` mm. Given
    /// lower bounds on the distances of the strips, and what local searches found on lines of v.
    fn certified<'a, I: Iterator<Item = (&'a Seed, &'a LineMinimum)>>(
        &self,
        query: &impl DistanceQuery,
        strips: &[f64; MAX_BLOCKS],
        v_range: (f64, f64),
        near: NearestOnSide,
        known: impl Fn() -> I,
        cutoff: f64,
    ) -> NearestOnSide {
        let tolerance = (-near.distance).clamp(NEARER, NEARER_INSIDE);
        let tangent = Tangent::new(query, &near.point);
        let trace = || {
            let mut trace = [None; MAX_V_LINES];
            for (seed, line) in known() {
                let own = self.grid.v[seed.line];
                // A line between those of the grid bounds a cell that is cut off there.
                let row = if seed.v == v_range.0 && own > seed.v {
                    seed.line.saturating_sub(1)
                } else if seed.v == v_range.1 && own < seed.v {
                    (seed.line + 1).min(self.grid.v.len() - 1)
                } else {
                    seed.line
                };
                trace[row] = Some((self.grid.cell_of(line.u, seed.index), line.point));
            }
            trace
        };
        let at_least = cutoff.min(near.distance);
        let radius = query.radius(tangent.gradient()) + near.distance;
        let mut search = CellSearch::new((query, v_range), (at_least, tolerance), (tangent, radius), trace);
        for (b, (centre, radius)) in self.blocks.strips.iter().enumerate() {
            if search.is_beyond(strips[b].max(tangent.at(centre) - radius)) {
                continue;
            }
            let range = (b * BLOCK, ((b + 1) * BLOCK).min(self.grid.u.len() - 1));
            self.grid.look(&mut search, range);
        }
        search.found.map_or(near, |found| self.refined(query, &found, v_range))
    }

    /// The nearest point around one that was found.
    fn refined(&self, query: &impl DistanceQuery, found: &FoundPoint, v_range: (f64, f64)) -> NearestOnSide {
        let &FoundPoint { distance, u, v, point } = found;
        let mut best = NearestOnSide { distance, u, v, point };
        let reach =
            REFINED_SHARE / self.grid.u.len() as f64 * (self.grid.u[self.grid.u.len() - 1] - self.grid.u[0]);
        let height = REFINED_SHARE / self.grid.v.len() as f64;
        let mut at = u;
        let follow = |v: f64| {
            let line = self.on_line(query, v, at, u - reach, u + reach);
            at = line.u;
            if line.distance < best.distance {
                best = line.into();
            }
            line.distance
        };
        search::minimum(follow, (v - height).max(v_range.0), (v + height).min(v_range.1), V_TOLERANCE);
        best
    }

    /// Start values on the lines of the grid between `v_from` and `v_to`, and on these two, given a lower
    /// bound on the distance of each strip; stops at the first grid point nearer than `enough` mm.
    fn seeds(
        &self,
        query: &impl DistanceQuery,
        strips: &[f64; MAX_BLOCKS],
        (v_from, v_to): (f64, f64),
        enough: f64,
    ) -> Seeds {
        let mut seeds = Seeds::default();
        let spacing = 1.0 / (self.grid.v.len() - 1) as f64;
        let stand_in = |v: f64| ((v / spacing).round().max(0.0) as usize).min(self.grid.v.len() - 1);
        let within = self
            .grid
            .v
            .iter()
            .enumerate()
            .filter(|&(_, &v)| v > v_from + 1e-9 && v < v_to - 1e-9)
            .map(|(j, &v)| (v, j));
        let ends = |v: f64| std::iter::once((v, stand_in(v)));
        for (v, line) in ends(v_from).chain(within).chain(ends(v_to)) {
            let seed = self.seed(query, strips, line);
            seeds.push(Seed { v, line, ..seed });
            if seed.distance < enough {
                break;
            }
        }
        seeds
    }

    /// Nearest point on the line of a seed, and the width of the range of u that was searched.
    fn line_near(&self, query: &impl DistanceQuery, seed: &Seed) -> (LineMinimum, f64) {
        // Between grid lines the seed is of the next one: the nearest point may be a cell or two away.
        let cells = if (seed.v - self.grid.v[seed.line]).abs() < 1e-9 { 1 } else { 3 };
        let last = self.grid.u.len() - 1;
        let (low, high) =
            (self.grid.u[seed.index.saturating_sub(cells)], self.grid.u[(seed.index + cells).min(last)]);
        (self.on_line(query, seed.v, self.grid.u[seed.index], low, high), high - low)
    }

    /// The nearest grid point of line `j`, given a lower bound on the distance of each strip.
    fn seed(&self, query: &impl DistanceQuery, strips: &[f64; MAX_BLOCKS], j: usize) -> Seed {
        let line = &self.grid.points[j * self.grid.u.len()..(j + 1) * self.grid.u.len()];
        let reaches = &self.blocks.reaches[j * self.grid.u.len()..(j + 1) * self.grid.u.len()];
        let blocks = self.blocks.of_line(j);
        let mut best = (f64::INFINITY, 0);
        let mut bound = f64::INFINITY;
        let mut look = |b: usize| {
            let block = &blocks[b];
            if strips[b] > best.0 {
                bound = bound.min(strips[b]);
                return;
            }
            let centre = query.distance(&line[block.centre]);
            if centre - block.radius > best.0 {
                bound = bound.min(centre - block.reach);
                return;
            }
            for i in block.first..block.last {
                let value = query.distance(&line[i]);
                bound = bound.min(value - reaches[i]);
                // Of equally near points the first, independent of the order of the blocks.
                if value < best.0 || value == best.0 && i < best.1 {
                    best = (value, i);
                }
            }
        };
        // Branch and bound: the block of the nearest strip first, as it rules most others out.
        let nearest = (0..blocks.len()).min_by(|&a, &b| strips[a].total_cmp(&strips[b])).unwrap_or(0);
        look(nearest);
        (0..blocks.len()).filter(|&b| b != nearest).for_each(&mut look);
        Seed { v: self.grid.v[j], line: j, index: best.1, distance: best.0, bound }
    }

    /// Nearest point, given the nearest ones on neighbouring `lines`. Between two lines u is searched up to
    /// `drift` beyond that of both.
    fn nearest_between(
        &self,
        query: &impl DistanceQuery,
        lines: &[LineMinimum],
        drift: f64,
    ) -> NearestOnSide {
        let mut best = lines[0];
        for line in &lines[1..] {
            best = best.nearer_of(line);
        }
        for pair in lines.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let reach = (a.u.min(b.u) - drift, a.u.max(b.u) + drift);
            if a.height * b.height < 0.0 {
                // The distance has a kink at the bottom plane: at most one minimum on either side of it.
                let share = a.height / (a.height - b.height);
                let (u, v) = (a.u + share * (b.u - a.u), a.v + share * (b.v - a.v));
                let plane = self.on_line(query, v, u, reach.0, reach.1);
                best = best.nearer_of(&plane);
                self.search_between(query, (&a, &plane), reach, &mut best);
                self.search_between(query, (&plane, &b), reach, &mut best);
            } else {
                self.search_between(query, (&a, &b), reach, &mut best);
            }
        }
        best.into()
    }

    /// Searches between two lines for a point nearer than `best`, with u within `reach`.
    fn search_between(
        &self,
        query: &impl DistanceQuery,
        (a, b): (&LineMinimum, &LineMinimum),
        reach: (f64, f64),
        best: &mut LineMinimum,
    ) {
        let known = best.distance;
        let mut at = a.nearer_of(b);
        let mut follow = |v: f64| {
            at = self.on_line(query, v, at.u, reach.0, reach.1);
            *best = best.nearer_of(&at);
            at
        };
        let (falls, rises) = (a.slope < 0.0, b.slope > 0.0);
        let mut searched = !(falls && b.distance > a.distance || rises && a.distance > b.distance);
        if falls && rises {
            // For a convex distance the end tangents meet at a lower bound; twice as deep, in case it is not
            // convex.
            let (lower, width) = (a.distance.min(b.distance), b.v - a.v);
            let along = (b.distance - a.distance - b.slope * width) / (a.slope - b.slope);
            let bottom = a.distance + a.slope * along;
            let valley = (0.0..=width).contains(&along);
            if valley && lower - 2.0 * (lower - bottom) >= known {
                return;
            }
            let ends = ((a.v, a.slope), (b.v, b.slope));
            let slope_at = |v: f64| {
                let line = follow(v);
                searched = line.distance >= 0.0;
                line.slope
            };
            search::root_from(slope_at, ends.0, ends.1, a.v + along, V_TOLERANCE);
        }
        // Slopes are not enough where the distance falls from the nearer line and rises again to the other,
        // as two local minima in u exchange roles between them, nor inside the cutter, where several surfaces
        // meet.
        if !searched {
            search::minimum(|v| follow(v).distance, a.v, b.v, V_TOLERANCE);
        }
    }
}
