//! Nearest distances to a blade side: from a cutter, from a point, from a piece of shank or holder.

mod query;
mod seeds;

use query::{CutterQuery, DistanceQuery, FrustumQuery, PointQuery, endless_cylinder_around};
use seeds::{LineMinimum, MAX_LINES, MAX_V_LINES, Seed, Seeds};

use super::side::BladeSide;
use crate::geometry::{CutterSolid, Frustum, Point, Vector, search};

/// A blade side with a coarse grid of its points, precomputed for many distance queries.
#[derive(Clone, Debug)]
pub struct SideProbe {
    side: BladeSide,
    u: Vec<f64>,
    v: Vec<f64>,
    /// Points of the grid, line by line of v.
    points: Vec<Point>,
    /// Per point, an upper bound on the distance from it to the part of the side for which it is the nearest,
    /// mm.
    reaches: Vec<f64>,
    /// Runs of neighbouring points of each line, line by line: [`Self::blocks_per_line`] per line.
    blocks: Vec<GridBlock>,
    blocks_per_line: usize,
    /// Balls about the blocks with the same number on all lines: centre, and radius up to the part of the
    /// side that they represent, mm.
    strips: Vec<(Point, f64)>,
}

/// A run of points of one line of the grid in a bounding ball. A distance changes by at most the distance
/// between two points, so that of the centre decides whether the others matter.
#[derive(Clone, Copy, Debug)]
struct GridBlock {
    /// Index of the first point in the line, and one past the last.
    first: usize,
    last: usize,
    /// Index of the point in the middle.
    centre: usize,
    /// Furthest point of the run from the centre, mm.
    radius: f64,
    /// As `radius`, with the parts of the side that the points represent.
    reach: f64,
}

/// Points of a block, and largest number of blocks of a line: 41 points, and 4 more at each rounded end.
const BLOCK: usize = 6;
const MAX_BLOCKS: usize = 49usize.div_ceil(BLOCK);

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

const RULED_V_LINES: usize = 5;
/// Argument tolerance of the searches in u. The distance is stationary there, so its error is far below 1 µm
/// on any machinable size.
const U_TOLERANCE: f64 = 2e-5;
/// Newton step in u after which no other is needed: the error is of the order of its square.
const U_STEP: f64 = 5e-5;
/// As [`U_TOLERANCE`], in v. Near the edge of the bottom the distance has a radius of curvature no greater
/// than itself: a tolerance that is harmless elsewhere would cost 10 µm there.
const V_TOLERANCE: f64 = 4e-6;

/// The whole range of v.
const FULL_V_RANGE: (f64, f64) = (0.0, 1.0);
/// Value of `enough` that never ends a search early.
const NO_EARLY_EXIT: f64 = f64::NEG_INFINITY;

/// Upper bound on the distance of a point of a cell from its nearest corner, as a share of the longest
/// distance between two corners: 1/√3 for a flat cell, and a margin for curvature.
const CELL_REACH: f64 = 0.75;

impl SideProbe {
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
        let n = u.len();
        let mut reaches = vec![0.0f64; points.len()];
        for j in 0..lines - 1 {
            for i in 0..n - 1 {
                let corners = [j * n + i, j * n + i + 1, (j + 1) * n + i, (j + 1) * n + i + 1];
                let [a, b, c, d] = corners.map(|k| points[k]);
                let longest =
                    [d - a, c - b, b - a, d - c, c - a, d - b].iter().map(Vector::norm).fold(0.0, f64::max);
                for k in corners {
                    reaches[k] = reaches[k].max(CELL_REACH * longest);
                }
            }
        }
        let blocks_per_line = n.div_ceil(BLOCK);
        let block = |j: usize, b: usize| {
            let (first, last) = (b * BLOCK, ((b + 1) * BLOCK).min(n));
            let centre = (first + last) / 2;
            let off = |i: usize| (points[j * n + i] - points[j * n + centre]).norm();
            let radius = (first..last).map(off).fold(0.0, f64::max);
            let reach = (first..last).map(|i| off(i) + reaches[j * n + i]).fold(0.0, f64::max);
            GridBlock { first, last, centre, radius, reach }
        };
        let blocks = (0..lines)
            .flat_map(|j| (0..blocks_per_line).map(move |b| (j, b)))
            .map(|(j, b)| block(j, b))
            .collect();
        let strip = |b: usize| {
            let (first, last) = (b * BLOCK, ((b + 1) * BLOCK).min(n));
            let own = || (0..lines).flat_map(|j| (first..last).map(move |i| j * n + i));
            let sum: Vector = own().map(|k| points[k].coords).sum();
            let centre = Point::from(sum / (lines * (last - first)) as f64);
            (centre, own().map(|k| (points[k] - centre).norm() + reaches[k]).fold(0.0, f64::max))
        };
        let strips = (0..blocks_per_line).map(strip).collect();
        Self { side: side.clone(), u, v, points, reaches, blocks, blocks_per_line, strips }
    }

    /// The blade side.
    pub fn side(&self) -> &BladeSide {
        &self.side
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
        let reach = 1.5 * (self.u[self.u.len() - 1] - self.u[0]) / self.u.len() as f64;
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
        self.strips.iter().all(|(centre, radius)| {
            let d = centre - frustum.base;
            let along = d.dot(&frustum.axis).clamp(0.0, frustum.length);
            let reach = widest + radius;
            (d - frustum.axis * along).norm_squared() > reach * reach
        })
    }

    /// A ball around the side: centre and radius, mm.
    pub fn bounding_ball(&self) -> (Point, f64) {
        let sum = self.points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords);
        let centre = Point::from(sum / self.points.len() as f64);
        let grid = self.points.iter().zip(&self.reaches);
        (centre, grid.map(|(p, reach)| (p - centre).norm() + reach).fold(0.0, f64::max))
    }

    fn infinitely_far(&self) -> NearestOnSide {
        NearestOnSide { distance: f64::INFINITY, u: 0.0, v: 0.0, point: self.points[0] }
    }

    /// Nearest point on the line `v`: Newton's method along u from `guess`, Brent's method where that fails.
    fn on_line(&self, query: &impl DistanceQuery, v: f64, guess: f64, low: f64, high: f64) -> LineMinimum {
        let (low, high) = (low.max(self.u[0]), high.min(self.u[self.u.len() - 1]));
        let mut curve = self.side.line(v);
        let line = |u: f64| {
            let (point, pv) = self.side.point_and_rise(u, v);
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
        for (bound, (centre, radius)) in strips.iter_mut().zip(&self.strips) {
            *bound = query.distance(centre) - radius;
            nearest = nearest.min(*bound);
        }
        if nearest > cutoff {
            return None;
        }
        let seeds = self.seeds(query, &strips, (v_from, v_to), enough);
        if let Some(seed) = seeds.lines[..seeds.count].last().filter(|seed| seed.distance < enough) {
            let (u, v) = (self.u[seed.index], self.v[seed.line]);
            let point = self.points[seed.line * self.u.len() + seed.index];
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
        Some(self.nearest_between(query, &lines[..near.len()], drift))
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
        let spacing = 1.0 / (self.v.len() - 1) as f64;
        let stand_in = |v: f64| ((v / spacing).round().max(0.0) as usize).min(self.v.len() - 1);
        let within = self
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
        let cells = if (seed.v - self.v[seed.line]).abs() < 1e-9 { 1 } else { 3 };
        let last = self.u.len() - 1;
        let (low, high) = (self.u[seed.index.saturating_sub(cells)], self.u[(seed.index + cells).min(last)]);
        (self.on_line(query, seed.v, self.u[seed.index], low, high), high - low)
    }

    /// The nearest grid point of line `j`, given a lower bound on the distance of each strip.
    fn seed(&self, query: &impl DistanceQuery, strips: &[f64; MAX_BLOCKS], j: usize) -> Seed {
        let line = &self.points[j * self.u.len()..(j + 1) * self.u.len()];
        let reaches = &self.reaches[j * self.u.len()..(j + 1) * self.u.len()];
        let blocks = &self.blocks[j * self.blocks_per_line..(j + 1) * self.blocks_per_line];
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
        Seed { v: self.v[j], line: j, index: best.1, distance: best.0, bound }
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
