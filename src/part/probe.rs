//! Nearest distances to a blade side: from a cutter, from a point.

use super::side::BladeSide;
use crate::geometry::{CutterSolid, Point, Vector, search};

/// A blade side with a coarse grid of its points, made for many distance queries.
#[derive(Clone, Debug)]
pub struct SideProbe {
    side: BladeSide,
    u: Vec<f64>,
    v: Vec<f64>,
    /// Row by row of v.
    points: Vec<Point>,
    /// No point of the side is further than this from the nearest grid point, mm.
    grid_reach: f64,
}

/// Where a side is nearest.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Signed distance, mm; negative where the cutter cuts the side.
    pub distance: f64,
    /// Where on the side.
    pub u: f64,
    /// See `u`.
    pub v: f64,
    /// The point of the side.
    pub point: Point,
}

/// Lines of v in the grid of a side that is not ruled; a ruled one bends only by its twist.
const MAX_V_LINES: usize = 9;
const RULED_V_LINES: usize = 5;
/// Argument tolerance of the searches in u. The distance is stationary there, so that it is
/// met to far better than 1 µm on any machinable size.
const U_TOLERANCE: f64 = 2e-5;
/// As [`U_TOLERANCE`], in v.
const V_TOLERANCE: f64 = 1e-4;

impl SideProbe {
    /// Grid over u in [`from`, `to`] (beyond 0…1 the side runs on straight) and all of v.
    pub fn new(side: &BladeSide, from: f64, to: f64) -> Self {
        let count = 40;
        let mut u: Vec<f64> =
            (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect();
        // Noses are small: the grid is finer there.
        if from == 0.0 {
            u.extend([0.003, 0.007, 0.012, 0.018]);
            u.sort_by(f64::total_cmp);
        }
        let lines = if side.is_ruled() { RULED_V_LINES } else { MAX_V_LINES };
        let v: Vec<f64> = (0..lines).map(|j| j as f64 / (lines - 1) as f64).collect();
        let points: Vec<Point> = v.iter().flat_map(|&v| u.iter().map(move |&u| side.point(u, v))).collect();
        let n = u.len();
        let mut grid_reach = 0.0f64;
        for j in 0..lines {
            for i in 0..n {
                let here = points[j * n + i];
                if i + 1 < n && j + 1 < lines {
                    grid_reach = grid_reach.max((points[(j + 1) * n + i + 1] - here).norm());
                    grid_reach = grid_reach.max((points[(j + 1) * n + i] - points[j * n + i + 1]).norm());
                }
            }
        }
        Self { side: side.clone(), u, v, points, grid_reach }
    }

    /// The side itself.
    pub fn side(&self) -> &BladeSide {
        &self.side
    }

    /// Nearest distance from `cutter` to the side over v in [`v_from`, `v_to`].
    pub fn nearest(&self, cutter: &CutterSolid, v_from: f64, v_to: f64) -> Nearest {
        self.nearest_within(&CutterLines { cutter }, v_from, v_to, f64::INFINITY)
            .unwrap_or_else(|| self.nothing())
    }

    /// As [`Self::nearest`] over the whole side; `None` when the side is surely further than `cutoff` mm.
    pub fn nearest_below(&self, cutter: &CutterSolid, cutoff: f64) -> Option<Nearest> {
        self.nearest_within(&CutterLines { cutter }, 0.0, 1.0, cutoff)
    }

    /// As [`Self::nearest`], following a nearest place known to be close to `u` instead of searching
    /// the whole side: for iterations that end with [`Self::nearest`].
    pub fn nearest_from(&self, cutter: &CutterSolid, u: f64, v_from: f64, v_to: f64) -> Nearest {
        let query = CutterLines { cutter };
        let reach = 1.5 * (self.u[self.u.len() - 1] - self.u[0]) / self.u.len() as f64;
        let mut guess = u;
        let mut on_line = |v: f64| {
            let found = self.on_line(&query, v, guess, guess - 2.0 * reach, guess + 2.0 * reach);
            guess = found.0;
            found
        };
        let mut best = (f64::INFINITY, u, v_from);
        let mut consider = |v: f64, (u, d): (f64, f64)| {
            if d < best.0 {
                best = (d, u, v);
            }
            d
        };
        search::minimum(|v| consider(v, on_line(v)), v_from, v_to, 10.0 * V_TOLERANCE);
        for v in [v_from, v_to] {
            consider(v, on_line(v));
        }
        Nearest { distance: best.0, u: best.1, v: best.2, point: self.side.point(best.1, best.2) }
    }

    /// Nearest distance from `point` to the whole side.
    pub fn nearest_to_point(&self, point: &Point) -> Nearest {
        self.nearest_within(&PointLines { point }, 0.0, 1.0, f64::INFINITY).unwrap_or_else(|| self.nothing())
    }

    fn nothing(&self) -> Nearest {
        Nearest { distance: f64::INFINITY, u: 0.0, v: 0.0, point: self.points[0] }
    }

    /// Nearest place on the line `v`: Newton along u from `guess`, Brent where that does not do.
    fn on_line(&self, query: &impl Query, v: f64, guess: f64, low: f64, high: f64) -> (f64, f64) {
        let (low, high) = (low.max(self.u[0]), high.min(self.u[self.u.len() - 1]));
        let mut u = guess.clamp(low, high);
        for _ in 0..8 {
            let (p, pu, puu) = self.side.along_u(u, v);
            let Some((slope, bend)) = query.slope(&p, &pu, &puu) else { break };
            if bend <= 0.0 {
                break;
            }
            let next = (u - slope / bend).clamp(low, high);
            let moved = (next - u).abs();
            u = next;
            if moved < 0.1 * U_TOLERANCE {
                let p = self.side.point(u, v);
                if query.smooth_at(&p) {
                    return (u, query.distance(&p));
                }
                break;
            }
        }
        search::minimum(|u| query.distance(&self.side.point(u, v)), low, high, U_TOLERANCE)
    }

    fn nearest_within(&self, query: &impl Query, v_from: f64, v_to: f64, cutoff: f64) -> Option<Nearest> {
        // Best grid value per line of v, then the lines that can hold the minimum are refined.
        let n = self.u.len();
        let mut lines = [(f64::INFINITY, 0usize); MAX_V_LINES];
        for (j, line) in lines.iter_mut().enumerate().take(self.v.len()) {
            if self.v[j] < v_from - 1e-9 || self.v[j] > v_to + 1e-9 {
                continue;
            }
            for i in 0..n {
                let value = query.distance(&self.points[j * n + i]);
                if value < line.0 {
                    *line = (value, i);
                }
            }
        }
        let nearest_grid = lines.iter().map(|l| l.0).fold(f64::INFINITY, f64::min);
        if nearest_grid - self.grid_reach > cutoff {
            return None;
        }
        let bracket = |i: usize| (self.u[i.saturating_sub(1)], self.u[(i + 1).min(n - 1)]);
        let mut refined = [(0.0, f64::INFINITY); MAX_V_LINES];
        for j in 0..self.v.len() {
            if lines[j].0.is_finite() {
                let (low, high) = bracket(lines[j].1);
                refined[j] = self.on_line(query, self.v[j], self.u[lines[j].1], low, high);
            }
        }
        let best = refined.iter().map(|l| l.1).fold(f64::INFINITY, f64::min);
        let mut nearest = self.nothing();
        let mut consider = |v: f64, (u, d): (f64, f64)| {
            if d < nearest.distance {
                nearest = Nearest { distance: d, u, v, point: Point::origin() };
            }
            d
        };
        for j in 0..self.v.len() {
            let (u, value) = refined[j];
            let lower = |k: usize| refined[k].1 < value;
            let has_lower_neighbour = (j > 0 && lower(j - 1)) || (j + 1 < self.v.len() && lower(j + 1));
            if !value.is_finite() || value > best + 0.5 || has_lower_neighbour {
                continue;
            }
            let searched = |k: usize| refined[k].1.is_finite();
            let low = if j > 0 && searched(j - 1) { self.v[j - 1] } else { v_from };
            let high = if j + 1 < self.v.len() && searched(j + 1) { self.v[j + 1] } else { v_to };
            let (u_low, u_high) = bracket(lines[j].1);
            let drift = u_high - u_low;
            let mut guess = u;
            let mut on_line = |v: f64| {
                let found = self.on_line(query, v, guess, u_low - drift, u_high + drift);
                guess = found.0;
                found
            };
            // A kink (known roughly) splits the search: on either side of it there is one minimum.
            let (at_low, at_high) = (on_line(low), on_line(high));
            consider(low, at_low);
            consider(high, at_high);
            let mut from = low;
            let above = |v: f64| {
                let share = (v - low) / (high - low);
                query.height(&self.side.point(at_low.0 + share * (at_high.0 - at_low.0), v))
            };
            if above(low) < 0.0 && above(high) > 0.0 {
                from = search::root(above, low, high, 1e-6);
                search::minimum(|v| consider(v, on_line(v)), low, from, V_TOLERANCE);
            }
            consider(self.v[j], refined[j]);
            search::minimum(|v| consider(v, on_line(v)), from, high, V_TOLERANCE);
        }
        nearest.point = self.side.point(nearest.u, nearest.v);
        Some(nearest)
    }
}

/// What a side is near to.
trait Query {
    /// Signed distance of a point of the side, mm.
    fn distance(&self, p: &Point) -> f64;
    /// Where this changes its sign the distance may have a kink.
    fn height(&self, p: &Point) -> f64;
    /// First and second derivative by u of half the squared distance from the axis (or the point).
    fn slope(&self, p: &Point, pu: &Vector, puu: &Vector) -> Option<(f64, f64)>;
    /// Whether the minimum of that is the minimum of the distance.
    fn smooth_at(&self, p: &Point) -> bool;
}

struct CutterLines<'a> {
    cutter: &'a CutterSolid,
}

impl Query for CutterLines<'_> {
    #[inline]
    fn distance(&self, p: &Point) -> f64 {
        self.cutter.distance(p)
    }

    fn height(&self, p: &Point) -> f64 {
        (p - self.cutter.tip).dot(&self.cutter.axis) - self.cutter.corner_radius
    }

    #[inline]
    fn slope(&self, p: &Point, pu: &Vector, puu: &Vector) -> Option<(f64, f64)> {
        let a = &self.cutter.axis;
        let d = p - self.cutter.tip;
        let flat = d - a * d.dot(a);
        let along = pu.dot(a);
        Some((flat.dot(pu), pu.norm_squared() - along * along + flat.dot(puu)))
    }

    fn smooth_at(&self, p: &Point) -> bool {
        // Beside the column only: under the bottom, and inside, other faces may be nearer.
        let height = self.height(p);
        let d = p - self.cutter.tip;
        let radial = (d - self.cutter.axis * d.dot(&self.cutter.axis)).norm();
        height >= 0.0 && radial > 0.5 * self.cutter.radius
    }
}

struct PointLines<'a> {
    point: &'a Point,
}

impl Query for PointLines<'_> {
    #[inline]
    fn distance(&self, p: &Point) -> f64 {
        (p - self.point).norm()
    }

    fn height(&self, _: &Point) -> f64 {
        1.0
    }

    fn slope(&self, p: &Point, pu: &Vector, puu: &Vector) -> Option<(f64, f64)> {
        let d = p - self.point;
        Some((d.dot(pu), pu.norm_squared() + d.dot(puu)))
    }

    fn smooth_at(&self, _: &Point) -> bool {
        true
    }
}
