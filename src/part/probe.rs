//! Nearest distances to a blade side: from a cutter, from a point.

use super::side::BladeSide;
use crate::geometry::{CutterSolid, Point, search};

/// A blade side with a coarse grid of its points, made for many distance queries.
#[derive(Clone, Debug)]
pub struct SideProbe {
    side: BladeSide,
    u: Vec<f64>,
    v: Vec<f64>,
    /// Row by row of v.
    points: Vec<Point>,
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

const V_LINES: usize = 9;
/// Argument tolerance of the searches in u and v. The distance is stationary there, so that it is
/// met to far better than 1 µm on any machinable size.
const TOLERANCE: f64 = 2e-5;

impl SideProbe {
    /// Grid over u in [`from`, `to`] (beyond 0…1 the side runs on straight) and all of v.
    pub fn new(side: &BladeSide, from: f64, to: f64) -> Self {
        let count = 40;
        // Noses are small: the grid is finer there.
        let mut u: Vec<f64> =
            (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect();
        if from == 0.0 {
            u.extend([0.003, 0.007, 0.012, 0.018]);
            u.sort_by(f64::total_cmp);
        }
        let v: Vec<f64> = (0..V_LINES).map(|j| j as f64 / (V_LINES - 1) as f64).collect();
        let points = v.iter().flat_map(|&v| u.iter().map(move |&u| side.point(u, v))).collect();
        Self { side: side.clone(), u, v, points }
    }

    /// The side itself.
    pub fn side(&self) -> &BladeSide {
        &self.side
    }

    /// Nearest distance from `cutter` to the side over v in [`v_from`, `v_to`].
    pub fn nearest(&self, cutter: &CutterSolid, v_from: f64, v_to: f64) -> Nearest {
        // Walls start below the bottom: where they pass its height the distance has a kink.
        let bottom = cutter.tip + cutter.axis * cutter.corner_radius;
        self.nearest_by(|p| cutter.distance(p), |p| (p - bottom).dot(&cutter.axis), v_from, v_to)
    }

    /// Nearest distance from `point` to the whole side.
    pub fn nearest_to_point(&self, point: &Point) -> Nearest {
        self.nearest_by(|p| (p - point).norm(), |_| 1.0, 0.0, 1.0)
    }

    /// The least `distance` over the side. Where `height` changes its sign the distance may have a kink.
    fn nearest_by(
        &self,
        distance: impl Fn(&Point) -> f64,
        height: impl Fn(&Point) -> f64,
        v_from: f64,
        v_to: f64,
    ) -> Nearest {
        // Best grid value per line of v, then the lines that can hold the minimum are refined.
        let n = self.u.len();
        let mut lines = [(f64::INFINITY, 0usize); V_LINES];
        for (j, line) in lines.iter_mut().enumerate() {
            if self.v[j] < v_from - 1e-9 || self.v[j] > v_to + 1e-9 {
                continue;
            }
            for i in 0..n {
                let value = distance(&self.points[j * n + i]);
                if value < line.0 {
                    *line = (value, i);
                }
            }
            // The grid is coarse: how low the line really goes takes a short search.
            let i = line.1;
            let (low, high) = (self.u[i.saturating_sub(1)], self.u[(i + 1).min(n - 1)]);
            let along = |u: f64| distance(&self.side.point(u, self.v[j]));
            line.0 = line.0.min(search::minimum(along, low, high, 0.01 * (high - low)).1);
        }
        let best = lines.iter().map(|l| l.0).fold(f64::INFINITY, f64::min);
        let mut nearest = Nearest { distance: f64::INFINITY, u: 0.0, v: 0.0, point: Point::origin() };
        for j in 0..V_LINES {
            let (value, i) = lines[j];
            let lower = |k: usize| lines[k].0 < value;
            let has_lower_neighbour = (j > 0 && lower(j - 1)) || (j + 1 < V_LINES && lower(j + 1));
            if !value.is_finite() || value > best + 0.5 || (has_lower_neighbour && value > best) {
                continue;
            }
            let low = if j > 0 && lines[j - 1].0.is_finite() {
                self.v[j - 1]
            } else {
                v_from.max(self.v[j].min(v_from))
            };
            let high = if j + 1 < V_LINES && lines[j + 1].0.is_finite() {
                self.v[j + 1]
            } else {
                v_to.max(self.v[j])
            };
            let (mut u_low, mut u_high) = (self.u[i.saturating_sub(1)], self.u[(i + 1).min(n - 1)]);
            // Neighbouring lines may have their nearest point a little off.
            let drift = 0.5 * (u_high - u_low);
            (u_low, u_high) = ((u_low - drift).max(self.u[0]), (u_high + drift).min(self.u[n - 1]));
            let on_line =
                |v: f64| search::minimum(|u| distance(&self.side.point(u, v)), u_low, u_high, TOLERANCE);
            // Split at a kink: below it the side mostly recedes, above it the search is smooth.
            let lowest = low;
            let mut low = low;
            let (u_at_low, u_at_high) = (on_line(low).0, on_line(high).0);
            let above = |v: f64| {
                let share = (v - lowest) / (high - lowest);
                height(&self.side.point(u_at_low + share * (u_at_high - u_at_low), v))
            };
            if above(low) < 0.0 && above(high) > 0.0 {
                low = search::root(above, low, high, 1e-9);
            }
            let (v, _) = search::minimum(|v| on_line(v).1, low, high, 1e-4);
            for v in [v, low, high, lowest] {
                let (u, d) = on_line(v);
                if d < nearest.distance {
                    nearest = Nearest { distance: d, u, v, point: Point::origin() };
                }
            }
        }
        nearest.point = self.side.point(nearest.u, nearest.v);
        nearest
    }
}
