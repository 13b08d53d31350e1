//! Tessellates a blade as a closed solid: both sides, tip on the shroud, foot on the hub, blunt edges.

use super::revolved::orient_outwards;
use crate::geometry::{Meridional, Point, Vector, wrap_angle};
use crate::mesh::solid::{FaceKind, Grid, Solid};
use crate::part::{Blade, BladeSide, Flowpath, Impeller};

/// Points of both sides closer together than this at an edge are merged, mm: files in single precision do not
/// resolve less.
const SAME: f64 = 1e-4;
/// Intervals of u and v before refinement: enough to detect every bend.
const FIRST_LINES: (usize, usize) = (16, 4);
/// Up to the first value of u (nose and transition), chords along the blade may use only the second value as
/// a share of the chord error. Plans need accurate normals there, whose error falls only with the root of the
/// chord error.
const NOSE: (f64, f64) = (0.08, 0.1);
/// Largest number of refinements, each of which halves intervals.
const ROUNDS: usize = 30;
/// Largest number of columns across tip and foot.
const MAX_ACROSS: usize = 64;

/// Tessellates a blade. `None` when more than `most` triangles would be needed.
pub(super) fn tessellate_blade(
    part: &Impeller,
    blade: &Blade,
    chord_error: f64,
    most: usize,
) -> Option<Solid> {
    let sides = [&blade.suction, &blade.pressure];
    let (us, vs) = refine_lines(sides, chord_error, most)?;
    let caps = [Cap::new(&part.hub, sides, 0.0, &us), Cap::new(&part.shroud, sides, 1.0, &us)];
    let across = caps.iter().map(|cap| cap.columns(0.4 * chord_error)).max().unwrap_or(1);
    if 4 * us.len() * (vs.len() + across) > most {
        return None;
    }
    let mut maker = BladeMesher::new(sides, &us, &vs);
    for (cap, kind) in caps.iter().zip([FaceKind::Foot, FaceKind::Tip]) {
        maker.close(cap, kind, across);
    }
    let last = us.len() - 1;
    for (row, kind) in [(0, FaceKind::LeadingEdge), (last, FaceKind::TrailingEdge)] {
        maker.close_edge(row, kind, across);
    }
    Some(orient_outwards(maker.solid))
}

/// Parameters of the mesh lines along u and along v, common to both sides.
fn refine_lines(sides: [&BladeSide; 2], chord_error: f64, most: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    let even = |n: usize| (0..=n).map(|i| i as f64 / n as f64).collect::<Vec<f64>>();
    let (mut us, mut vs) = (even(FIRST_LINES.0), even(FIRST_LINES.1));
    for _ in 0..ROUNDS {
        let (mut split_u, mut split_v) = (vec![false; us.len() - 1], vec![false; vs.len() - 1]);
        for side in sides {
            mark(side, &us, &vs, chord_error, &mut split_u, &mut split_v);
        }
        if !split_u.contains(&true) && !split_v.contains(&true) {
            break;
        }
        us = halved(&us, &split_u);
        vs = halved(&vs, &split_v);
        if 4 * us.len() * vs.len() > most {
            return None;
        }
    }
    Some((us, vs))
}

fn halved(lines: &[f64], split: &[bool]) -> Vec<f64> {
    let mut finer = vec![lines[0]];
    for (pair, &split) in lines.windows(2).zip(split) {
        if split {
            finer.push(0.5 * (pair[0] + pair[1]));
        }
        finer.push(pair[1]);
    }
    finer
}

/// Marks the intervals of u and v in which triangles are further from the side than `chord_error`.
fn mark(
    side: &BladeSide,
    us: &[f64],
    vs: &[f64],
    chord_error: f64,
    split_u: &mut [bool],
    split_v: &mut [bool],
) {
    let allowed = 0.9 * chord_error;
    let from_line = |m: Point, a: &Point, b: &Point| {
        let along = (b - a).try_normalize(1e-12).unwrap_or_else(Vector::zeros);
        let d = m - a;
        (d - along * d.dot(&along)).norm()
    };
    let rows: Vec<Vec<Point>> = us.iter().map(|&u| vs.iter().map(|&v| side.point(u, v)).collect()).collect();
    let between = |a: f64, b: f64, share: f64| a + (b - a) * share;
    let edge_u = |i: usize, j: usize| {
        let off = |share| {
            from_line(side.point(between(us[i], us[i + 1], share), vs[j]), &rows[i][j], &rows[i + 1][j])
        };
        [0.25, 0.5, 0.75].map(off).into_iter().fold(0.0, f64::max)
    };
    let edge_v = |i: usize, j: usize| {
        let off = |share| {
            from_line(side.point(us[i], between(vs[j], vs[j + 1], share)), &rows[i][j], &rows[i][j + 1])
        };
        [0.25, 0.5, 0.75].map(off).into_iter().fold(0.0, f64::max)
    };
    let columns = vs.len();
    let mut along_u = vec![0.0; (us.len() - 1) * columns];
    for i in 0..us.len() - 1 {
        for j in 0..columns {
            along_u[i * columns + j] = edge_u(i, j);
        }
    }
    for i in 0..us.len() - 1 {
        // Foot and tip share the chord error with the curvature of hub and shroud across them.
        let ends = along_u[i * columns].max(along_u[i * columns + columns - 1]);
        let share = if us[i] < NOSE.0 { NOSE.1 } else { 0.5 };
        if ends > share * chord_error {
            split_u[i] = true;
        }
        for j in 0..columns - 1 {
            let eu = along_u[i * columns + j].max(along_u[i * columns + j + 1]);
            let ev = edge_v(i, j).max(edge_v(i + 1, j));
            let corners = [rows[i][j], rows[i][j + 1], rows[i + 1][j], rows[i + 1][j + 1]];
            let mut inner = 0.0f64;
            for (x, y) in [(0.5, 0.5), (0.3, 0.3), (0.3, 0.7), (0.7, 0.3), (0.7, 0.7)] {
                let m = side.point(between(us[i], us[i + 1], x), between(vs[j], vs[j + 1], y));
                inner = inner.max(from_cell(&m, &corners));
            }
            if eu.max(ev).max(inner) <= allowed {
                continue;
            }
            let (length_u, length_v) = ((corners[2] - corners[0]).norm(), (corners[1] - corners[0]).norm());
            // A cell with nearly straight edges is twisted: its longer side is halved.
            let bent = eu.max(ev) > 0.4 * inner;
            if if bent { eu >= ev } else { length_u >= length_v } {
                split_u[i] = true;
            } else {
                split_v[j] = true;
            }
        }
    }
}

/// Distance of `m` from the nearer plane of a cell's two triangles, split as in [`crate::mesh::solid`].
fn from_cell(m: &Point, corners: &[Point; 4]) -> f64 {
    let distance = |t: [u32; 3]| {
        let [a, b, c] = t.map(|k| corners[k as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-30)?;
        Some((m - a).dot(&normal).abs())
    };
    let planes = crate::mesh::solid::split(corners, [0, 1, 2, 3]).map(distance);
    planes.into_iter().flatten().fold(f64::INFINITY, f64::min).min(1e9)
}

/// Cap of a blade at hub or shroud: the area of that surface of revolution between both sides.
struct Cap<'a> {
    path: &'a Flowpath,
    /// Whether it is the cap at the hub.
    at_hub: bool,
    /// Per u, arc length (mm) and angle (rad) of the suction side, and the differences to the pressure side.
    rows: Vec<[f64; 4]>,
}

impl<'a> Cap<'a> {
    fn new(path: &'a Flowpath, sides: [&BladeSide; 2], v: f64, us: &[f64]) -> Self {
        let place = |p: Point| (path.curve().project(Meridional::from_point(&p)).0, p.y.atan2(p.x));
        let rows = us
            .iter()
            .map(|&u| {
                let [(t0, a0), (t1, a1)] = sides.map(|side| place(side.point(u, v)));
                [t0, a0, t1 - t0, wrap_angle(a1 - a0)]
            })
            .collect();
        Self { path, at_hub: v < 0.5, rows }
    }

    fn point(&self, row: usize, share: f64) -> Point {
        let [t, angle, dt, turn] = self.rows[row];
        self.path.curve().point(t + dt * share).at_angle(angle + turn * share)
    }

    /// Number of columns across, so that chords stay within `error`, mm, of the surface.
    fn columns(&self, error: f64) -> usize {
        let bulge = |row: usize| {
            let (a, m, b) = (self.point(row, 0.0), self.point(row, 0.5), self.point(row, 1.0));
            (m.coords - 0.5 * (a.coords + b.coords)).norm()
        };
        let most = (0..self.rows.len()).map(bulge).fold(0.0, f64::max);
        ((most / error).sqrt().ceil() as usize).clamp(1, MAX_ACROSS)
    }
}

/// A blade under construction.
struct BladeMesher<'a> {
    solid: Solid,
    vs: &'a [f64],
    rows: usize,
    /// Points of both sides, rows LE → TE, columns hub → tip.
    sides: [Grid; 2],
    /// Points of foot and tip, rows LE → TE, columns suction → pressure side.
    caps: Vec<Grid>,
}

impl<'a> BladeMesher<'a> {
    fn new(sides: [&BladeSide; 2], us: &[f64], vs: &'a [f64]) -> Self {
        let mut solid = Solid::default();
        let suction = sample(&mut solid, sides[0], us, vs, None);
        let pressure = sample(&mut solid, sides[1], us, vs, Some(&suction));
        let normal = |side: &BladeSide, u: f64, v: f64| {
            let (_, du, dv) = side.derivatives(u, v);
            du.cross(&dv).try_normalize(1e-12).unwrap_or_else(Vector::zeros)
        };
        let last = vs.len() - 1;
        solid.add_grid(FaceKind::Suction, &suction, |i, j| normal(sides[0], us[i], vs[j]));
        let turned = mirrored(&pressure);
        solid.add_grid(FaceKind::Pressure, &turned, |i, j| normal(sides[1], us[i], vs[last - j]));
        Self { solid, vs, rows: us.len(), sides: [suction, pressure], caps: Vec::new() }
    }

    /// Closes foot or tip.
    fn close(&mut self, cap: &Cap, kind: FaceKind, across: usize) {
        let column = if cap.at_hub { 0 } else { self.vs.len() - 1 };
        let mut points = Vec::with_capacity(self.rows * (across + 1));
        for i in 0..self.rows {
            let ends = [self.sides[0].at(i, column), self.sides[1].at(i, column)];
            self.bridge(ends, across, |share| cap.point(i, share), &mut points);
        }
        let grid = Grid { rows: self.rows, columns: across + 1, points };
        let curve = cap.path.curve();
        let places: Vec<Vector> = grid
            .points
            .iter()
            .map(|&k| {
                let p = self.solid.points[k as usize];
                curve
                    .at(curve.project(Meridional::from_point(&p)).0)
                    .normal
                    .direction_at_angle(p.y.atan2(p.x))
            })
            .collect();
        let at = |i: usize, j: usize| places[i * (across + 1) + j];
        if cap.at_hub {
            self.solid.add_grid(kind, &mirrored(&grid), |i, j| at(i, across - j));
        } else {
            self.solid.add_grid(kind, &grid, at);
        }
        self.caps.push(grid);
    }

    /// Closes a blunt edge: straight from side to side, blended into hub and shroud at foot and tip.
    fn close_edge(&mut self, row: usize, kind: FaceKind, across: usize) {
        let point = |solid: &Solid, k: u32| solid.points[k as usize].coords;
        let mut points = Vec::with_capacity(self.vs.len() * (across + 1));
        let last = self.vs.len() - 1;
        for (j, &v) in self.vs.iter().enumerate() {
            let ends = [self.sides[0].at(row, j), self.sides[1].at(row, j)];
            if j == 0 || j == last {
                let cap = &self.caps[usize::from(j == last)];
                points.extend((0..=across).map(|k| cap.at(row, k)));
                continue;
            }
            let straight = |a: Vector, b: Vector, share: f64| a + (b - a) * share;
            let solid = &self.solid;
            // Offset of foot and tip from the straight line between their ends.
            let bulge = |cap: &Grid, k: usize, share: f64| {
                let (a, b) = (point(solid, cap.at(row, 0)), point(solid, cap.at(row, across)));
                point(solid, cap.at(row, k)) - straight(a, b, share)
            };
            let [a, b] = ends.map(|k| point(solid, k));
            let inner: Vec<Point> = (0..=across)
                .map(|k| {
                    let share = k as f64 / across as f64;
                    let (foot, tip) = (bulge(&self.caps[0], k, share), bulge(&self.caps[1], k, share));
                    Point::from(straight(a, b, share) + foot * (1.0 - v) + tip * v)
                })
                .collect();
            self.bridge(ends, across, |share| inner[(share * across as f64).round() as usize], &mut points);
        }
        let grid = Grid { rows: self.vs.len(), columns: across + 1, points };
        let oriented = if row == 0 { grid } else { mirrored(&grid) };
        self.solid.add_grid(kind, &oriented, |_, _| Vector::zeros());
    }

    /// Appends to `into` the points from one end to the other; all are the same where the ends are.
    fn bridge(&mut self, ends: [u32; 2], across: usize, at: impl Fn(f64) -> Point, into: &mut Vec<u32>) {
        into.push(ends[0]);
        for k in 1..across {
            if ends[0] == ends[1] {
                into.push(ends[0]);
            } else {
                into.push(self.solid.points.len() as u32);
                self.solid.points.push(at(k as f64 / across as f64));
            }
        }
        into.push(ends[1]);
    }
}

/// Samples a side into `solid`. At both edges it reuses coinciding points of the `other` side.
fn sample(solid: &mut Solid, side: &BladeSide, us: &[f64], vs: &[f64], other: Option<&Grid>) -> Grid {
    let mut points: Vec<u32> = Vec::with_capacity(us.len() * vs.len());
    for (i, &u) in us.iter().enumerate() {
        let at_edge = i == 0 || i == us.len() - 1;
        for (j, &v) in vs.iter().enumerate() {
            let p = side.point(u, v);
            let met = other.filter(|_| at_edge).map(|other| other.at(i, j));
            match met.filter(|&k| (solid.points[k as usize] - p).norm() < SAME) {
                Some(k) => points.push(k),
                None => {
                    points.push(solid.points.len() as u32);
                    solid.points.push(p);
                }
            }
        }
    }
    Grid { rows: us.len(), columns: vs.len(), points }
}

/// The grid with its columns reversed, which reverses the orientation of its triangles.
fn mirrored(grid: &Grid) -> Grid {
    let points = grid.points.chunks(grid.columns).flat_map(|row| row.iter().rev().copied()).collect();
    Grid { rows: grid.rows, columns: grid.columns, points }
}
