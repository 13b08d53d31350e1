//! Intersection of the rays of a channel's floor with its walls.
//!
//! A ray from the hub stays in its meridional plane, and the hub is a surface of revolution: at height h the
//! rays of all cells of one s pass through the same meridional point, at which a wall has one angle θ(s, h).
//! Walls are tabulated over (s, h) by Newton's method and interpolated; beside a wall that leans over the
//! channel a ray ends where θ(s, h), less the angle of the blade allowance, passes over it.

use rayon::prelude::*;

use crate::geometry::{Meridional, Point, Vector, wrap_angle};
use crate::part::{Channel, Impeller, Wall, passage_angle};

/// Rows of the tables, at the midpoints of equal intervals of s.
pub(super) const ROWS: usize = 48;
/// Heights per row, evenly from the foot up.
pub(super) const LEVELS: usize = 25;
/// Greatest height in the tables, relative to the distance from hub to shroud at equal s.
const MAX_HEIGHT_SHARE: f64 = 1.5;

/// s of row `row` of the tables.
pub(super) fn s_of_row(row: usize) -> f64 {
    (row as f64 + 0.5) / ROWS as f64
}

/// The rows of the tables on either side of `s`, and the interpolation weight of the second.
pub(super) fn rows_beside(s: f64) -> (usize, usize, f64) {
    let at = (s * ROWS as f64 - 0.5).clamp(0.0, (ROWS - 1) as f64);
    let row = at as usize;
    (row, (row + 1).min(ROWS - 1), at - row as f64)
}

/// Height between two levels at `s`, mm.
fn level_height(part: &Impeller, s: f64) -> f64 {
    MAX_HEIGHT_SHARE * part.hub.point(s).distance(part.shroud.point(s)) / (LEVELS - 1) as f64
}

/// A wall at one s and h.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallNode {
    /// Angle from the wall's own foot, in the direction from the first wall of the channel to the second,
    /// rad.
    turn: f64,
    /// Angle that the blade allowance takes here, rad.
    margin: f64,
    /// Parameters on the blade side: LE 0 … TE 1, hub 0 … tip 1.
    u: f64,
    /// See `u`.
    pub(super) v: f64,
    /// The point of the wall, mm.
    pub(super) point: Point,
}

impl WallNode {
    /// Where no wall was found; all comparisons with it fail.
    const NONE: Self = Self {
        turn: f64::NAN,
        margin: f64::NAN,
        u: f64::NAN,
        v: f64::NAN,
        point: Point::new(f64::NAN, f64::NAN, f64::NAN),
    };

    /// Whether this is between LE and TE; beyond them the side is a linear extension.
    pub(super) fn is_on_blade(&self) -> bool {
        (0.0..=1.0).contains(&self.u)
    }

    /// Whether this is on the blade and not above its tip.
    fn is_inside(&self) -> bool {
        self.is_on_blade() && self.v <= 1.0
    }

    /// Share of the way from this node, on the blade, to `other` at which the edge is if that is beyond one,
    /// else 1.
    fn share_to_edge(&self, other: &Self) -> f64 {
        match (0.0..=1.0).contains(&other.u) {
            true => 1.0,
            false => ((f64::from(other.u > 1.0) - self.u) / (other.u - self.u)).clamp(0.0, 1.0),
        }
    }

    /// As [`Self::share_to_edge`], for the tip of the blade.
    fn share_to_tip(&self, other: &Self) -> f64 {
        if other.v > 1.0 { ((1.0 - self.v) / (other.v - self.v)).clamp(0.0, 1.0) } else { 1.0 }
    }
}

/// One wall, tabulated.
#[derive(Debug)]
pub(super) struct WallTable<'a> {
    wall: &'a Wall,
    /// +1 where the channel follows the wall in the direction of [`WallNode::turn`], −1 where it precedes it.
    pub(super) opening_sign: f64,
    /// [`LEVELS`] per row.
    nodes: Vec<WallNode>,
    /// Its points on the blade.
    points: Vec<Point>,
}

impl<'a> WallTable<'a> {
    fn new(part: &Impeller, wall: &'a Wall, opens: f64, blade_allowance: f64) -> Self {
        let mut nodes = vec![WallNode::NONE; ROWS * LEVELS];
        nodes.par_chunks_mut(LEVELS).enumerate().for_each(|(row, nodes)| {
            tabulate(part, wall, s_of_row(row), blade_allowance, nodes);
        });
        let points = points_on_blade(&nodes);
        Self { wall, opening_sign: opens, nodes, points }
    }

    /// Points of the wall on the blade.
    pub(super) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Direction of the foot of the wall along the hub at table row `row`, mm per row or two.
    pub(super) fn trace_at(&self, row: usize) -> Vector {
        let here = self.row(row)[0].point;
        let beside = |row: usize| Some(self.row(row)[0].point).filter(|p| p.x.is_finite());
        let before = row.checked_sub(1).and_then(beside).unwrap_or(here);
        let after = (row + 1 < ROWS).then(|| beside(row + 1)).flatten().unwrap_or(here);
        after - before
    }

    /// Whether the wall is over the floor of the passage anywhere above its foot in table row `row`.
    pub(super) fn leans_over(&self, row: usize) -> bool {
        self.row(row).iter().any(|node| node.is_on_blade() && node.turn * self.opening_sign > 1e-6)
    }

    /// Angle from θ = `from` to `to` on the side to which this wall opens the passage, rad.
    pub(super) fn turn_into_passage(&self, from: f64, to: f64, pitch: f64) -> f64 {
        let (low, high) = if self.opening_sign > 0.0 { (from, to) } else { (to, from) };
        passage_angle(low, high, pitch).abs()
    }

    /// The wall.
    pub(super) fn wall(&self) -> &'a Wall {
        self.wall
    }

    /// The levels of table row `row`, foot first.
    pub(super) fn row(&self, row: usize) -> &[WallNode] {
        &self.nodes[row * LEVELS..(row + 1) * LEVELS]
    }

    /// Angles at which the blade with its allowance begins over the floor at `s`, per level, rad; the foot of
    /// the wall is at `foot`. NaN where there is no blade; with `at_foot` the blade includes its foot.
    fn bounds(&self, s: f64, foot: f64, at_foot: bool) -> [f64; LEVELS] {
        let (first, second, share) = rows_beside(s);
        let (first, second) = (self.row(first), self.row(second));
        std::array::from_fn(|level| {
            let (a, b) = (&first[level], &second[level]);
            let between = |a: f64, b: f64| a + (b - a) * share;
            let there = (0.0..=1.0).contains(&between(a.u, b.u)) || (level == 0 && at_foot);
            let margin = self.opening_sign * between(a.margin, b.margin);
            if there { foot + between(a.turn, b.turn) + margin } else { f64::NAN }
        })
    }
}

/// The nodes of a table that are on the blade, and where its edges and its tip are between nodes.
fn points_on_blade(nodes: &[WallNode]) -> Vec<Point> {
    let mut points = Vec::new();
    for (k, node) in nodes.iter().enumerate() {
        if node.is_inside() {
            points.push(node.point);
        }
        let (row, level) = (k / LEVELS, k % LEVELS);
        let after = (row + 1 < ROWS).then(|| &nodes[k + LEVELS]);
        let above = (level + 1 < LEVELS).then(|| &nodes[k + 1]);
        for next in [after, above].into_iter().flatten() {
            if next.point.x.is_finite() && node.is_inside() != next.is_inside() {
                let (inside, outside) = if node.is_inside() { (node, next) } else { (next, node) };
                let share = inside.share_to_edge(outside).min(inside.share_to_tip(outside));
                points.push(inside.point + (outside.point - inside.point) * share);
            }
        }
    }
    points.retain(|point| point.x.is_finite());
    points
}

fn tabulate(part: &Impeller, wall: &Wall, s: f64, blade_allowance: f64, nodes: &mut [WallNode]) {
    let (hub, step) = (part.hub.at(s), level_height(part, s));
    let Some(foot) = wall.at(part, s, 0.0) else { return };
    let (mut theta, mut turn) = (foot.theta, 0.0);
    let (mut u, mut v) = ([foot.u; 2], [foot.v; 2]);
    for (level, node) in nodes.iter_mut().enumerate() {
        let h = step * level as f64;
        let at = Meridional { r: hub.point.r + h * hub.normal.r, z: hub.point.z + h * hub.normal.z };
        // Walls are nearly straight: the last two levels are extrapolated to the start value of the next.
        let Some(found) = wall.at_meridional(at, 2.0 * u[1] - u[0], 2.0 * v[1] - v[0]) else { return };
        let further = wrap_angle(found.theta - theta) * part.pitch().signum();
        if further.abs() > 0.5 * part.pitch().abs() {
            return;
        }
        (theta, turn) = (found.theta, turn + further);
        (u, v) = ([u[1], found.u], [v[1], found.v]);
        let slope = (1.0 / (at.r * at.r) + found.by_r * found.by_r + found.by_z * found.by_z).sqrt();
        *node = WallNode {
            turn,
            margin: blade_allowance * slope,
            u: found.u,
            v: found.v,
            point: at.at_angle(found.theta),
        };
    }
}

/// The tabulated walls of a channel: first and second wall, and of each splitter from the first wall to the
/// second the side that faces the first wall and the one that faces the second.
#[derive(Debug)]
pub(super) struct WallTables<'a> {
    part: &'a Impeller,
    /// s from which on each splitter has a foot on the hub.
    splitter_s: Vec<f64>,
    /// The walls.
    pub(super) faces: Vec<WallTable<'a>>,
}

impl<'a> WallTables<'a> {
    /// Tabulates the walls of `channel` with an allowance of `blade_allowance` mm.
    pub(super) fn new(part: &'a Impeller, channel: &'a Channel, blade_allowance: f64) -> Self {
        let [low, high] = &channel.full.walls;
        let mut walls = vec![(low, 1.0), (high, -1.0)];
        walls.extend(channel.splitters.iter().flat_map(|s| [(&s.near, -1.0), (&s.far, 1.0)]));
        let face = |(wall, opens)| WallTable::new(part, wall, opens, blade_allowance);
        Self {
            part,
            splitter_s: channel.splitters.iter().map(|splitter| splitter.s[0]).collect(),
            faces: walls.into_iter().map(face).collect(),
        }
    }

    /// The walls that face wall `index` across a passage. The far side of a splitter is hidden behind its
    /// near side.
    pub(super) fn facing(&self, index: usize) -> impl Iterator<Item = &WallTable<'a>> {
        // Those that close the channel where `index` opens it, on the side to which it opens.
        let opens = self.faces.get(index).is_some_and(|face| face.opening_sign > 0.0);
        let is_facing = move |&other: &usize| match (index, other) {
            (0, 1) | (1, 0) => true,
            (0, other) => other % 2 == 0,
            (1, other) => other % 2 == 1,
            (_, 0) => !opens,
            (_, 1) => opens,
            (_, other) if opens => other % 2 == 0 && other > index,
            (_, other) => other % 2 == 1 && other < index,
        };
        (0..self.faces.len()).filter(move |other| *other != index).filter(is_facing).map(|k| &self.faces[k])
    }

    /// The wall across the passage from the foot of wall `index` at `s`, the nearest of those that face it.
    pub(super) fn opposite(&self, index: usize, s: f64) -> Option<&WallTable<'a>> {
        let pitch = self.part.pitch();
        let theta = |face: &WallTable| Some(face.wall.at(self.part, s, 0.0)?.theta);
        let own = &self.faces[index];
        let foot = theta(own)?;
        let is_there = |face: &&WallTable| {
            let of_splitter = self.faces.iter().position(|f| std::ptr::eq(f, *face)).filter(|&k| k >= 2);
            of_splitter.is_none_or(|k| s >= self.splitter_s[(k - 2) / 2])
        };
        let turn = |face: &WallTable| Some(own.turn_into_passage(foot, theta(face)?, pitch));
        let found = self.facing(index).filter(is_there).filter_map(|face| Some((turn(face)?, face)));
        found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, face)| face)
    }

    /// The blades over the floor at `s`.
    pub(super) fn blades_over(&self, s: f64) -> BladesOverFloor {
        let pitch = self.part.pitch();
        let level_height = level_height(self.part, s);
        let foot = |face: usize| Some(self.faces.get(face)?.wall.at(self.part, s, 0.0)?.theta);
        let (Some(from), Some(to)) = (foot(0), foot(1)) else {
            return BladesOverFloor {
                from: 0.0,
                width: pitch.abs(),
                feet: vec![f64::NAN; self.faces.len()],
                solids: Vec::new(),
                level_height,
            };
        };
        let across = |theta: f64| pitch.signum() * passage_angle(from, theta, pitch);
        let mut feet = vec![f64::NAN; self.faces.len()];
        (feet[0], feet[1]) = (0.0, across(to));
        let bounds = |face: usize, foot: f64, at_foot: bool| self.faces[face].bounds(s, foot, at_foot);
        let mut solids = vec![
            CoveredAngles::new([f64::NEG_INFINITY; LEVELS], bounds(0, 0.0, true)),
            CoveredAngles::new(bounds(1, feet[1], true), [f64::INFINITY; LEVELS]),
        ];
        for (near, &begins) in (2..).step_by(2).zip(&self.splitter_s) {
            let far = near + 1;
            if let (Some(at_near), Some(at_far)) = (foot(near), foot(far)) {
                let at_foot = s >= begins;
                (feet[near], feet[far]) = (across(at_near), across(at_far));
                solids.push(CoveredAngles::new(
                    bounds(near, feet[near], at_foot),
                    bounds(far, feet[far], at_foot),
                ));
            }
        }
        BladesOverFloor { from, width: feet[1], feet, solids, level_height }
    }
}

/// The blades over the floor at one s. Angles count from the foot of the first wall towards the second, rad.
#[derive(Clone, Debug)]
pub(super) struct BladesOverFloor {
    /// θ of the foot of the first wall.
    pub(super) from: f64,
    /// Angle of the foot of the second wall.
    pub(super) width: f64,
    /// Angles of the feet of all walls; NaN where there is none.
    pub(super) feet: Vec<f64>,
    /// Blades with their allowance.
    solids: Vec<CoveredAngles>,
    level_height: f64,
}

impl BladesOverFloor {
    /// Height at which the ray at `angle` enters a blade or its allowance, mm: 0 where its foot is in it,
    /// infinite where it never does.
    pub(super) fn underside(&self, angle: f64) -> f64 {
        let levels = self.solids.iter().filter_map(|solid| solid.first_level(angle));
        self.level_height * levels.fold(f64::INFINITY, f64::min)
    }
}

/// Angles that one blade covers, level by level.
#[derive(Clone, Copy, Debug)]
struct CoveredAngles {
    from: [f64; LEVELS],
    to: [f64; LEVELS],
    /// Least `from` and greatest `to`, for early rejection.
    span: (f64, f64),
}

impl CoveredAngles {
    fn new(from: [f64; LEVELS], to: [f64; LEVELS]) -> Self {
        // Both `min` and `max` ignore NaN.
        let least = from.into_iter().fold(f64::INFINITY, f64::min);
        let greatest = to.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self { from, to, span: (least, greatest) }
    }

    /// Fractional level at which the ray at `angle` enters from below.
    fn first_level(&self, angle: f64) -> Option<f64> {
        if angle <= self.span.0 || angle >= self.span.1 {
            return None;
        }
        let level = (0..LEVELS).find(|&k| angle > self.from[k] && angle < self.to[k])?;
        let Some(below) = level.checked_sub(1) else { return Some(0.0) };
        let (from, to) = (self.from[below], self.to[below]);
        let share = if angle <= from {
            (from - angle) / (from - self.from[level])
        } else if angle >= to {
            (angle - to) / (self.to[level] - to)
        } else {
            // The blade begins above the level below.
            1.0
        };
        Some(below as f64 + share)
    }
}
