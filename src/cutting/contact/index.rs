//! Spatial index of plunges: a bounding-volume tree over grid cells of their tips and of a second point high
//! up their axes, so that a query visits only the plunges near a given axis.

use std::collections::HashMap;

use crate::geometry::{CutterSolid, Point, Vector};

/// Edge length of the cells of leaves, in cutter radii.
const EDGE_RADII: f64 = 3.0;
/// Factor by which the cells of the next level are wider.
const LEVEL_FACTOR: i32 = 3;
/// Height of the second point above the tip, in cutter radii.
const SECOND_RADII: f64 = 32.0;
/// Minimum radius used for cell sizes, mm.
const MIN_RADIUS: f64 = 1e-3;
/// Number of levels of the tree.
const LEVELS: usize = 5;
/// Number of pieces of an axis over which distances to other axes are bounded.
const AXIS_PIECES: usize = 4;

/// A query: everything within `reach` mm of an axis, from its tip to `top` mm above.
#[derive(Clone, Copy, Debug)]
pub struct AxisQuery {
    pub tip: Point,
    pub axis: Vector,
    pub reach: f64,
    pub top: f64,
}

impl AxisQuery {
    /// The point of the axis at a height, mm.
    fn at(&self, height: f64) -> Point {
        self.tip + self.axis * height
    }

    /// Whether the axis, up to `top`, comes within `distance` mm of the line through `tip` along `axis`.
    pub fn meets(&self, tip: &Point, axis: &Vector, distance: f64) -> bool {
        // The square of the distance at height h: a h² + 2 b h + c.
        let from_tip = self.tip - tip;
        let (along, up) = (self.axis.dot(axis), from_tip.dot(axis));
        let a = 1.0 - along * along;
        let b = from_tip.dot(&self.axis) - up * along;
        let c = from_tip.norm_squared() - up * up;
        let h = if a > 1e-12 { (-b / a).min(self.top).max(0.0) } else { 0.0 };
        (a * h + 2.0 * b) * h + c < distance * distance
    }
}

/// Bounds of all plunges of a node.
#[derive(Clone, Copy, Debug)]
struct NodeBounds {
    /// First tip and first axis.
    tip: Point,
    axis: Vector,
    /// Height of the second points, mm.
    second: f64,
    /// Maximum distances from the first plunge: of a tip, of a second point, of an axis; and maximum radius.
    aside: f64,
    aside_second: f64,
    turned: f64,
    radius: f64,
}

impl NodeBounds {
    fn of(cutter: &CutterSolid) -> Self {
        let CutterSolid { tip, axis, radius, .. } = *cutter;
        let second = SECOND_RADII * radius.max(MIN_RADIUS);
        Self { tip, axis, second, aside: 0.0, aside_second: 0.0, turned: 0.0, radius }
    }

    fn add(&mut self, cutter: &CutterSolid) {
        let (tip, axis) = (cutter.tip - self.tip, cutter.axis - self.axis);
        self.aside = self.aside.max(tip.norm());
        self.aside_second = self.aside_second.max((tip + axis * self.second).norm());
        self.turned = self.turned.max(axis.norm());
        self.radius = self.radius.max(cutter.radius);
    }

    /// Upper bound on the distance between points of the axes at the same height, mm.
    fn max_separation(&self, height: f64) -> f64 {
        let share = height / self.second;
        (1.0 - share).abs() * self.aside + share.abs() * self.aside_second
    }

    /// Whether a plunge of the node may meet the query; conservative.
    fn is_near(&self, around: &AxisQuery) -> bool {
        let reach = around.reach + self.radius;
        let (low, high) = (around.tip - self.tip, around.at(around.top) - self.tip);
        let (height_low, height_high) = (low.dot(&self.axis), high.dot(&self.axis));
        // Bounds the difference between the heights at which the axes are nearest.
        let elsewhere = self.aside + self.turned * low.norm().max(high.norm());
        let parted = |height: f64, elsewhere: f64| self.max_separation(height) + self.turned * elsewhere;
        // The bound is largest at one of the ends.
        let most = parted(height_low, elsewhere).max(parted(height_high, elsewhere));
        if !around.meets(&self.tip, &self.axis, reach + most) {
            return false;
        }
        // Refined piece by piece: the distance between straight axes is Lipschitz continuous with `slope`.
        let slope = around.axis.cross(&self.axis).norm();
        let half = 0.5 * around.top / AXIS_PIECES as f64;
        (0..AXIS_PIECES).any(|i| {
            let d = around.at(half * (2 * i + 1) as f64) - self.tip;
            let height = d.dot(&self.axis);
            let flat = (d - self.axis * height).norm();
            flat - slope * half < reach + parted(height, elsewhere + half)
        })
    }
}

#[derive(Clone, Debug)]
struct IndexNode {
    bounds: NodeBounds,
    /// Index of the parent node in the next level.
    parent: u32,
    /// Ascending indices of plunges, or of nodes of the level below.
    members: Vec<u32>,
}

/// Radius of the cutters of a node, and the cells of their tips and second points.
type NodeKey = (u64, [[i32; 3]; 2]);

/// Spatial index of plunges.
#[derive(Clone, Debug, Default)]
pub struct PlungeIndex {
    /// Nodes by level, the leaves first.
    places: [Vec<IndexNode>; LEVELS],
    numbers: [HashMap<NodeKey, u32>; LEVELS],
    /// Leaf of each plunge.
    of_plunge: Vec<u32>,
}

impl PlungeIndex {
    /// Adds the next plunge.
    pub fn push(&mut self, cutter: &CutterSolid) {
        let radius = cutter.radius.max(MIN_RADIUS);
        let edge = EDGE_RADII * radius;
        let cell = |p: Point| [p.x, p.y, p.z].map(|x| (x / edge).floor() as i32);
        let second = cutter.tip + cutter.axis * (SECOND_RADII * radius);
        let key = (cutter.radius.to_bits(), [cell(cutter.tip), cell(second)]);
        let number = self.of_plunge.len() as u32;
        let leaf = self.node_at(0, key, cutter);
        let place = &mut self.places[0][leaf as usize];
        if place.members.is_empty() {
            place.bounds = NodeBounds::of(cutter);
        }
        place.members.push(number);
        self.of_plunge.push(leaf);
        let mut at = leaf;
        for places in &mut self.places {
            let place = &mut places[at as usize];
            place.bounds.add(cutter);
            at = place.parent;
        }
    }

    /// Index of the node of `level` at `key`, created for `cutter` where there is none.
    fn node_at(&mut self, level: usize, key: NodeKey, cutter: &CutterSolid) -> u32 {
        if let Some(&number) = self.numbers[level].get(&key) {
            return number;
        }
        let number = self.places[level].len() as u32;
        let mut parent = 0;
        if level + 1 < LEVELS {
            let (radius, cells) = key;
            let wider = cells.map(|cell| cell.map(|x| x.div_euclid(LEVEL_FACTOR)));
            parent = self.node_at(level + 1, (radius, wider), cutter);
            self.places[level + 1][parent as usize].members.push(number);
        }
        self.places[level].push(IndexNode { bounds: NodeBounds::of(cutter), parent, members: Vec::new() });
        self.numbers[level].insert(key, number);
        number
    }

    /// Removes all but the first `count` plunges. Bounds are not shrunk.
    pub fn truncate(&mut self, count: usize) {
        for leaf in self.of_plunge.drain(count.min(self.of_plunge.len())..).rev() {
            self.places[0][leaf as usize].members.pop();
        }
    }

    /// Indices below `count` of the plunges that may meet the query, in any order; may contain false
    /// positives.
    pub fn near(&self, around: &AxisQuery, count: usize) -> Vec<u32> {
        let mut found = Vec::new();
        for place in &self.places[LEVELS - 1] {
            self.gather(LEVELS - 1, place, around, count as u32, &mut found);
        }
        found
    }

    fn gather(&self, level: usize, place: &IndexNode, around: &AxisQuery, count: u32, found: &mut Vec<u32>) {
        if level == 0 && place.members.first().is_none_or(|&first| first >= count)
            || !place.bounds.is_near(around)
        {
            return;
        }
        let members = place.members.iter();
        match level.checked_sub(1) {
            None => found.extend(members.take_while(|&&number| number < count)),
            Some(below) => {
                for &number in members {
                    self.gather(below, &self.places[below][number as usize], around, count, found);
                }
            }
        }
    }
}
