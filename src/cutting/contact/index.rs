//! Index of plunges in cutting order: which of them come near a given axis.
//!
//! Plunges that follow each other are mostly neighbours, so blocks of successive ones have small bounds, and
//! many blocks are ruled out by them. The others are tested plunge by plunge. Their numbers lie coordinate by
//! coordinate, so that the processor tests several plunges at once: that is faster than a tree with small
//! nodes.

use crate::geometry::{CutterSolid, Point, Vector};

/// Plunges of a block.
const BLOCK: usize = 32;
/// Height of the second point of an axis above its tip, in cutter radii.
const SECOND_RADII: f64 = 32.0;
/// Minimum radius used for that height, mm.
const MIN_RADIUS: f64 = 1e-3;
/// Number of pieces of an axis over which distances to other axes are bounded.
const AXIS_PIECES: usize = 4;
/// 1 − cos² of the angle between two axes, below which they are parallel.
const PARALLEL: f64 = 1e-12;

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

    /// Square of the distance, up to `top`, from the line through `tip` along `axis`, mm².
    #[inline(always)]
    fn squared_distance(&self, tip: [f64; 3], axis: [f64; 3]) -> f64 {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let own = [self.axis.x, self.axis.y, self.axis.z];
        let from_tip = [self.tip.x - tip[0], self.tip.y - tip[1], self.tip.z - tip[2]];
        // At height h it is a h² + 2 b h + c.
        let (along, up) = (dot(own, axis), dot(from_tip, axis));
        let a = 1.0 - along * along;
        let b = dot(from_tip, own) - up * along;
        let c = dot(from_tip, from_tip) - up * up;
        let lowest = (-b / a).min(self.top).max(0.0);
        let h = if a > PARALLEL { lowest } else { 0.0 };
        (a * h + 2.0 * b) * h + c
    }

    /// Whether the axis, up to `top`, comes within `distance` mm of the line through `tip` along `axis`.
    pub fn meets(&self, tip: &Point, axis: &Vector, distance: f64) -> bool {
        self.squared_distance([tip.x, tip.y, tip.z], [axis.x, axis.y, axis.z]) < distance * distance
    }
}

/// Bounds of all plunges of a block.
#[derive(Clone, Copy, Debug)]
struct BlockBounds {
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

impl BlockBounds {
    fn from_cutter(cutter: &CutterSolid) -> Self {
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

    /// Whether a plunge of the block may meet the query; conservative.
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

/// Successive plunges: coordinates of their tips and axes, and their radii, mm.
#[derive(Clone, Debug)]
struct PlungeBlock {
    bounds: BlockBounds,
    tips: [[f64; BLOCK]; 3],
    axes: [[f64; BLOCK]; 3],
    radii: [f64; BLOCK],
}

impl PlungeBlock {
    /// Without plunges; the first one will be `cutter`.
    fn starting_with(cutter: &CutterSolid) -> Self {
        let zeros = [[0.0; BLOCK]; 3];
        Self { bounds: BlockBounds::from_cutter(cutter), tips: zeros, axes: zeros, radii: [0.0; BLOCK] }
    }

    fn set(&mut self, place: usize, cutter: &CutterSolid) {
        self.bounds.add(cutter);
        for k in 0..3 {
            self.tips[k][place] = cutter.tip[k];
            self.axes[k][place] = cutter.axis[k];
        }
        self.radii[place] = cutter.radius;
    }

    /// Of each of its places, by how much the squared distance from the query exceeds what meets it, mm².
    fn gaps(&self, around: &AxisQuery) -> [f64; BLOCK] {
        let Self { tips: [tx, ty, tz], axes: [ax, ay, az], radii, .. } = self;
        let mut gaps = [0.0; BLOCK];
        for i in 0..BLOCK {
            let distance = around.reach + radii[i];
            let squared = around.squared_distance([tx[i], ty[i], tz[i]], [ax[i], ay[i], az[i]]);
            gaps[i] = squared - distance * distance;
        }
        gaps
    }
}

/// Index of plunges in cutting order.
#[derive(Clone, Debug, Default)]
pub struct PlungeIndex {
    blocks: Vec<PlungeBlock>,
    count: usize,
}

impl PlungeIndex {
    /// Adds the next plunge.
    pub fn push(&mut self, cutter: &CutterSolid) {
        let place = self.count % BLOCK;
        if place == 0 {
            self.blocks.push(PlungeBlock::starting_with(cutter));
        }
        if let Some(block) = self.blocks.last_mut() {
            block.set(place, cutter);
        }
        self.count += 1;
    }

    /// Removes all but the first `count` plunges. Bounds are not shrunk.
    pub fn truncate(&mut self, count: usize) {
        self.count = self.count.min(count);
        self.blocks.truncate(self.count.div_ceil(BLOCK));
    }

    /// Ascending indices below `count` of the plunges whose columns meet the query: those with an axis less
    /// than their radius and `reach` away.
    pub fn near(&self, around: &AxisQuery, count: usize) -> Vec<u32> {
        let count = count.min(self.count);
        let mut found = Vec::new();
        for (number, block) in self.blocks[..count.div_ceil(BLOCK)].iter().enumerate() {
            if !block.bounds.is_near(around) {
                continue;
            }
            let first = number * BLOCK;
            let places = (count - first).min(BLOCK);
            let gaps = block.gaps(around);
            found.extend((0..places).filter(|&place| gaps[place] < 0.0).map(|place| (first + place) as u32));
        }
        found
    }
}
