//! The heightfield of stock left on the hub: CPU twin of `shaders/residual.wgsl`.
//!
//! Every cell has a ray P + h·n from the finished hub along its normal. A plunge removes the cylinder
//! from its tip upwards, and the cell keeps the lowest height at which its ray enters one. Both kernels
//! do the same operations in the same order on f32; keep them that way, a test compares them.

use rayon::prelude::*;

use super::grid::FloorGrid;
use super::tiles::{TILE, TileBins};

/// Depth above which a cell counts as contact of the core, mm. The kernel gets it as a constant.
pub const CONTACT_TOLERANCE: f32 = crate::plunge::plan::CONTACT_TOLERANCE as f32;
/// Height by which a cell must drop to count as cut, mm. The kernel gets it as a constant.
pub const CUT_TOLERANCE: f32 = 1e-4;

// The constants below stand in `shaders/residual.wgsl` under the same names.

/// Height that no ray reaches, mm.
const FAR: f32 = 1e30;
/// Least squared sine between ray and axis: a ray along the axis meets the wall 1e6 radii away.
const MIN_SQUARED_SINE: f32 = 1e-12;
/// Least cosine between ray and axis: a ray along the bottom plane crosses it far away.
const MIN_COSINE: f32 = 1e-6;
/// Most Newton steps towards a rounded corner.
const CORNER_STEPS: u32 = 8;
/// Distance from the rounded corner that counts as on it, mm.
const CORNER_TOLERANCE: f32 = 2e-5;

/// One plunge as the kernels see it: a cylinder from the tip upwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldCutter {
    /// Tip M: centre of the bottom, mm.
    pub tip: [f32; 3],
    /// Radius R, mm.
    pub radius: f32,
    /// Unit axis, tip → holder.
    pub axis: [f32; 3],
    /// Core radius R − w, mm.
    pub core_radius: f32,
    /// Corner radius, mm.
    pub corner_radius: f32,
}

/// What the heightfield saw of one position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionTrace {
    /// Greatest height of stock in the core above its bottom, mm along the tool axis.
    pub contact_depth: f32,
    /// Cells in which the core meets stock.
    pub contact_cells: u32,
    /// Cells the cutter sweeps over.
    pub swept_cells: u32,
    /// Cells in which it removes stock; the rest of the swept cells is cut in air.
    pub cut_cells: u32,
}

impl PositionTrace {
    /// Joins what two parts of the grid saw of the same position.
    fn join(&mut self, other: &PositionTrace) {
        self.contact_depth = self.contact_depth.max(other.contact_depth);
        self.contact_cells += other.contact_cells;
        self.swept_cells += other.swept_cells;
        self.cut_cells += other.cut_cells;
    }
}

/// Heights of stock above the finished hub after some positions were cut.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualField {
    /// Height along the hub normal per cell, mm; the blank's height where nothing was cut.
    pub heights: Vec<f32>,
    /// Per position, in cutting order. Only cells of the floor count.
    pub traces: Vec<PositionTrace>,
}

/// Walks `cutters` in cutting order over every cell of `grid`.
///
/// For the state after k positions pass `&cutters[..k]`.
pub fn residual_field(grid: &FloorGrid, cutters: &[FieldCutter]) -> ResidualField {
    let bins = TileBins::new(grid, cutters);
    let mut heights = vec![0.0; grid.rows * grid.columns];
    let mut traces = vec![PositionTrace::default(); cutters.len()];
    if heights.is_empty() {
        return ResidualField { heights, traces };
    }
    // One task per row of tiles, as a row is one contiguous piece of the heights.
    let seen: Vec<Vec<PositionTrace>> = heights
        .par_chunks_mut(TILE * grid.columns)
        .enumerate()
        .map(|(down, heights)| {
            let mut seen = Vec::new();
            for across in 0..bins.across {
                let mut tile = Tile::load(grid, down, across);
                seen.extend(bins.cutters_of(down, across).iter().map(|&k| tile.cut(&cutters[k as usize])));
                tile.store(heights, across, grid.columns);
            }
            seen
        })
        .collect();
    // Sums and maxima: the result does not depend on how the tasks were shared out.
    for (&k, trace) in bins.list.iter().zip(seen.iter().flatten()) {
        traces[k as usize].join(trace);
    }
    ResidualField { heights, traces }
}

/// A value per lane: one row of a tile.
type Row<T> = [T; TILE];

/// The cells of one tile, by component, so that a row of them fits vector registers.
struct Tile {
    point: [[Row<f32>; TILE]; 3],
    normal: [[Row<f32>; TILE]; 3],
    blank: [Row<f32>; TILE],
    height: [Row<f32>; TILE],
    floor: [Row<u32>; TILE],
}

impl Tile {
    fn load(grid: &FloorGrid, down: usize, across: usize) -> Tile {
        let zero = [[0.0; TILE]; TILE];
        // Cells beyond the edge of the grid have nothing above them: no cutter finds stock there.
        let none = [[-1.0; TILE]; TILE];
        let mut tile =
            Tile { point: [zero; 3], normal: [zero; 3], blank: none, height: none, floor: [[0; TILE]; TILE] };
        for row in 0..TILE.min(grid.rows - down * TILE) {
            let first = (down * TILE + row) * grid.columns + across * TILE;
            for lane in 0..TILE.min(grid.columns - across * TILE) {
                let cell = first + lane;
                for axis in 0..3 {
                    tile.point[axis][row][lane] = grid.points[cell][axis];
                    tile.normal[axis][row][lane] = grid.normals[cell][axis];
                }
                tile.blank[row][lane] = grid.blank_heights[cell];
                tile.height[row][lane] = grid.blank_heights[cell];
                tile.floor[row][lane] = u32::from(grid.floor[cell]);
            }
        }
        tile
    }

    /// Writes the heights to their place in a row of tiles.
    fn store(&self, heights: &mut [f32], across: usize, columns: usize) {
        let first = across * TILE;
        let lanes = TILE.min(columns - first);
        for (row, line) in heights.chunks_exact_mut(columns).enumerate() {
            line[first..first + lanes].copy_from_slice(&self.height[row][..lanes]);
        }
    }

    /// Removes what `cutter` sweeps.
    ///
    /// Loops over the lanes of a row hold no branches, and counters are kept per lane until the end, so
    /// that the compiler turns each loop into vector instructions.
    fn cut(&mut self, cutter: &FieldCutter) -> PositionTrace {
        let mut seen = Seen::default();
        let squared_radius = cutter.radius * cutter.radius;
        let squared_core = cutter.core_radius * cutter.core_radius;
        let mut meetings = MeetingRow::default();
        for row in 0..TILE {
            let mut meets = 0;
            for lane in 0..TILE {
                let meeting = Meeting::new(
                    [self.point[0][row][lane], self.point[1][row][lane], self.point[2][row][lane]],
                    [self.normal[0][row][lane], self.normal[1][row][lane], self.normal[2][row][lane]],
                    cutter,
                );
                meets |= u32::from(meeting.discriminant(squared_radius) > 0.0);
                meetings.set(lane, meeting);
            }
            if meets == 0 {
                continue;
            }
            let (blank, floor) = (self.blank[row], self.floor[row]);
            let mut height = self.height[row];
            let mut entries: Row<f32> = std::array::from_fn(|lane| {
                let meeting = meetings.get(lane);
                let (entry, exit) = meeting.interval(squared_radius);
                let met = (meeting.discriminant(squared_radius) > 0.0) & (entry < exit);
                if met { entry } else { FAR }
            });
            if cutter.corner_radius > 0.0 {
                for lane in 0..TILE {
                    if entries[lane] < blank[lane] {
                        entries[lane] = meetings.get(lane).corner_entry(entries[lane], cutter);
                    }
                }
            }
            let mut core = 0;
            for lane in 0..TILE {
                core |= floor[lane] & mask(meetings.get(lane).may_touch(squared_core, height[lane]));
            }
            if core != 0 {
                for lane in 0..TILE {
                    let depth = meetings.get(lane).contact_depth(squared_core, height[lane]);
                    let depth = if floor[lane] != 0 { depth } else { 0.0 };
                    seen.depth[lane] = larger(seen.depth[lane], depth);
                    seen.contact[lane] += floor[lane] & mask(depth > CONTACT_TOLERANCE);
                }
            }
            for lane in 0..TILE {
                let left = smaller(height[lane], entries[lane]);
                seen.swept[lane] += floor[lane] & mask(entries[lane] < blank[lane]);
                seen.cut[lane] += floor[lane] & mask(height[lane] - left > CUT_TOLERANCE);
                height[lane] = left;
            }
            self.height[row] = height;
        }
        PositionTrace {
            contact_depth: seen.depth.into_iter().fold(0.0, larger),
            contact_cells: seen.contact.iter().sum(),
            swept_cells: seen.swept.iter().sum(),
            cut_cells: seen.cut.iter().sum(),
        }
    }
}

/// What each lane saw of one cutter.
#[derive(Default)]
struct Seen {
    depth: Row<f32>,
    contact: Row<u32>,
    swept: Row<u32>,
    cut: Row<u32>,
}

/// How one ray lies to one cutter's axis. At height h the ray is at height `z + h·slope` above the
/// bottom, and at squared distance `squared_distance + 2 h·closing + h²·squared_sine` from the axis.
#[derive(Clone, Copy)]
struct Meeting {
    z: f32,
    slope: f32,
    squared_sine: f32,
    closing: f32,
    squared_distance: f32,
}

impl Meeting {
    #[inline(always)]
    fn new(point: [f32; 3], normal: [f32; 3], cutter: &FieldCutter) -> Meeting {
        let axis = cutter.axis;
        let from_tip = [point[0] - cutter.tip[0], point[1] - cutter.tip[1], point[2] - cutter.tip[2]];
        let z = dot(from_tip, axis);
        let slope = dot(normal, axis);
        // Across the axis. Forming the vectors first keeps small tilts exact; 1 − slope² would not.
        let start = [from_tip[0] - axis[0] * z, from_tip[1] - axis[1] * z, from_tip[2] - axis[2] * z];
        let step = [normal[0] - axis[0] * slope, normal[1] - axis[1] * slope, normal[2] - axis[2] * slope];
        Meeting {
            z,
            slope,
            squared_sine: larger(dot(step, step), MIN_SQUARED_SINE),
            closing: dot(start, step),
            squared_distance: dot(start, start),
        }
    }

    /// Positive if the whole line of the ray meets the cylinder of that squared radius.
    #[inline(always)]
    fn discriminant(&self, squared_radius: f32) -> f32 {
        self.closing * self.closing - self.squared_sine * (self.squared_distance - squared_radius)
    }

    /// Heights at which the ray enters (0 if its foot is inside) and leaves the cylinder above the bottom
    /// plane. Only meaningful for a positive discriminant, and empty unless entry < exit.
    #[inline(always)]
    fn interval(&self, squared_radius: f32) -> (f32, f32) {
        let half = larger(self.discriminant(squared_radius), 0.0).sqrt();
        let inverse = 1.0 / self.squared_sine;
        let enter = (-self.closing - half) * inverse;
        let leave = (-self.closing + half) * inverse;
        let slope = if self.slope.abs() < MIN_COSINE { MIN_COSINE } else { self.slope };
        let bottom = -self.z / slope;
        let enter = if slope > 0.0 { larger(enter, bottom) } else { enter };
        let leave = if slope < 0.0 { smaller(leave, bottom) } else { leave };
        (larger(enter, 0.0), leave)
    }

    /// False only where [`Meeting::contact_depth`] is 0: the cylinder passes the ray by, or all stock lies
    /// below the bottom plane. Spares most rows the roots.
    #[inline(always)]
    fn may_touch(&self, squared_core: f32, height: f32) -> bool {
        let above = (self.z + height * self.slope > 0.0) | (self.slope <= 0.0);
        (self.discriminant(squared_core) > 0.0) & above
    }

    /// Height above the bottom of the highest stock in the core, for stock up to `height`; 0 if none.
    #[inline(always)]
    fn contact_depth(&self, squared_core: f32, height: f32) -> f32 {
        let (entry, exit) = self.interval(squared_core);
        let top = smaller(height, exit);
        // The top is the higher end unless the axis leans more than 90° from the hub normal.
        let depth = larger(self.z + top * self.slope, self.z + entry * self.slope);
        let meets = (self.discriminant(squared_core) > 0.0) & (entry < top);
        if meets { larger(depth, 0.0) } else { 0.0 }
    }

    /// Where the ray enters the cutter with its rounded corner, given where it enters the sharp one.
    ///
    /// The distance to the rounded body is convex along the ray and the sharp body contains the rounded
    /// one, so Newton steps from the sharp entry come closer without passing it.
    #[inline(always)]
    fn corner_entry(&self, sharp_entry: f32, cutter: &FieldCutter) -> f32 {
        let inner = cutter.radius - cutter.corner_radius;
        let mut height = sharp_entry;
        for _ in 0..CORNER_STEPS {
            let squared = self.squared_distance + height * (2.0 * self.closing + height * self.squared_sine);
            let distance = larger(squared, MIN_SQUARED_SINE).sqrt();
            let out = larger(distance - inner, 0.0);
            let down = larger(cutter.corner_radius - (self.z + height * self.slope), 0.0);
            let length = (out * out + down * down).sqrt();
            let gap = length - cutter.corner_radius;
            if gap <= CORNER_TOLERANCE {
                return height;
            }
            let receding = (self.closing + height * self.squared_sine) / distance;
            let rate = (out * receding - down * self.slope) / length;
            if rate >= 0.0 {
                return FAR;
            }
            height -= gap / rate;
        }
        height
    }
}

/// [`Meeting`]s of a row of cells, by component.
#[derive(Default)]
struct MeetingRow {
    z: Row<f32>,
    slope: Row<f32>,
    squared_sine: Row<f32>,
    closing: Row<f32>,
    squared_distance: Row<f32>,
}

impl MeetingRow {
    #[inline(always)]
    fn set(&mut self, lane: usize, meeting: Meeting) {
        self.z[lane] = meeting.z;
        self.slope[lane] = meeting.slope;
        self.squared_sine[lane] = meeting.squared_sine;
        self.closing[lane] = meeting.closing;
        self.squared_distance[lane] = meeting.squared_distance;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Meeting {
        Meeting {
            z: self.z[lane],
            slope: self.slope[lane],
            squared_sine: self.squared_sine[lane],
            closing: self.closing[lane],
            squared_distance: self.squared_distance[lane],
        }
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// All bits set if `condition` holds: combines with a lane's value where an `if` would become a branch.
#[inline(always)]
fn mask(condition: bool) -> u32 {
    u32::from(condition).wrapping_neg()
}

/// The larger of two numbers. Unlike `f32::max` it says nothing about NaN, and so is one instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; see [`larger`].
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
#[path = "field_tests.rs"]
pub(crate) mod tests;
