//! Tiles of the floor grid and the cutters that can reach each of them; shared by both kernels.

use rayon::prelude::*;

use super::field_cutter::FieldCutter;
use super::grid::FloorGrid;

/// Cells along one edge of a tile: one workgroup on the GPU, sixteen lanes of a row on the CPU.
pub const TILE: usize = 16;
/// Tiles along one edge of a block. Blocks reject most cutters before any tile is tested.
const BLOCK: usize = 8;
/// Added to the reach of every cutter, mm: more than single precision loses within 1 m of the origin.
pub(super) const REACH_MARGIN: f32 = 0.01;

/// For every tile the cutters that may reach its rays, in cutting order.
///
/// Tile (I, J) covers cells `16 I .. 16 I + 16` along s and `16 J .. 16 J + 16` along λ and has index
/// `I * across + J`. Its cutters are `list[offsets[tile]..offsets[tile + 1]]`, ascending.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileBins {
    /// Number of tiles along s.
    pub down: usize,
    /// Number of tiles along λ.
    pub across: usize,
    /// Start of each tile's part of `list`, and the length of `list` at the end.
    pub offsets: Vec<u32>,
    /// Indices of cutters.
    pub list: Vec<u32>,
}

impl TileBins {
    /// Assigns `cutters` to the tiles of `grid`. Conservative: a tile may get cutters that do not reach it.
    pub fn new(grid: &FloorGrid, cutters: &[FieldCutter]) -> Self {
        Self::sorted(grid, cutters, true)
    }

    /// As [`Self::new`], on the calling thread alone: a thread that waits for others takes on other work of
    /// theirs meanwhile.
    pub fn on_one_thread(grid: &FloorGrid, cutters: &[FieldCutter]) -> Self {
        Self::sorted(grid, cutters, false)
    }

    fn sorted(grid: &FloorGrid, cutters: &[FieldCutter], on_all_threads: bool) -> Self {
        let down = grid.rows.div_ceil(TILE);
        let across = grid.columns.div_ceil(TILE);
        let around = |tile: usize| Capsule::around_tile(grid, tile / across, tile % across);
        let capsules: Vec<Capsule> = mapped(down * across, 8, on_all_threads, around);
        let blocks_across = across.div_ceil(BLOCK);
        let of_block = |block: usize| -> Vec<u32> {
            let (i, j) = (block / blocks_across * BLOCK, block % blocks_across * BLOCK);
            let members = (i..(i + BLOCK).min(down))
                .flat_map(|i| (j..(j + BLOCK).min(across)).map(move |j| i * across + j));
            let capsule = Capsule::around(members.map(|tile| &capsules[tile]));
            let reaches = |k: &u32| capsule.within_reach(&cutters[*k as usize]);
            (0..cutters.len() as u32).filter(reaches).collect()
        };
        let reaching = mapped(down.div_ceil(BLOCK) * blocks_across, 1, on_all_threads, of_block);
        let of_tile = |tile: usize| -> Vec<u32> {
            let block = tile / across / BLOCK * blocks_across + tile % across / BLOCK;
            let reaches = |k: &u32| capsules[tile].within_reach(&cutters[*k as usize]);
            reaching[block].iter().copied().filter(reaches).collect()
        };
        let lists = mapped(capsules.len(), 8, on_all_threads, of_tile);
        let mut offsets = Vec::with_capacity(lists.len() + 1);
        let mut list = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        offsets.push(0);
        for cutters in lists {
            list.extend(cutters);
            offsets.push(list.len() as u32);
        }
        Self { down, across, offsets, list }
    }

    /// The cutters of tile (I, J), in cutting order.
    pub fn cutters_of(&self, down: usize, across: usize) -> &[u32] {
        let tile = down * self.across + across;
        &self.list[self.offsets[tile] as usize..self.offsets[tile + 1] as usize]
    }
}

/// The values for 0 to `count`, on all threads in pieces of at least `piece`, or on the calling one.
fn mapped<T: Send>(
    count: usize,
    piece: usize,
    on_all_threads: bool,
    value: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    if on_all_threads {
        (0..count).into_par_iter().with_min_len(piece).map(value).collect()
    } else {
        (0..count).map(value).collect()
    }
}

/// Everything within `radius` of the segment from `foot` to `top`; contains all rays of a tile from the hub
/// to the blank. A sphere would be as wide as the channel is deep, and accept ten times the cutters.
#[derive(Clone, Copy, Debug)]
struct Capsule {
    foot: [f32; 3],
    top: [f32; 3],
    radius: f32,
}

impl Capsule {
    fn around_tile(grid: &FloorGrid, down: usize, across: usize) -> Self {
        // All rays get the greatest height: beside leaning walls, heights drop to zero from cell to cell.
        let rows = down * TILE..((down + 1) * TILE).min(grid.rows);
        let lanes = TILE.min(grid.columns - across * TILE);
        let cells_of = |row: usize| {
            let first = row * grid.columns + across * TILE;
            first..first + lanes
        };
        let heights = rows.clone().flat_map(|row| &grid.blank_heights[cells_of(row)]);
        let highest = heights.copied().fold(0.0, larger);
        let (mut feet, mut tops) = ([[0.0; 3]; TILE * TILE], [[0.0; 3]; TILE * TILE]);
        let mut count = 0;
        for row in rows {
            for (&foot, &normal) in grid.points[cells_of(row)].iter().zip(&grid.normals[cells_of(row)]) {
                feet[count] = foot;
                tops[count] = add_scaled(foot, normal, highest);
                count += 1;
            }
        }
        let (feet, tops) = (&feet[..count], &tops[..count]);
        let (foot, top) = (centre(feet), centre(tops));
        // Distance to a segment is convex along a ray, so the two ends of each ray decide.
        let squared = feet.iter().map(|&p| distance2(p, foot)).fold(0.0, larger);
        let squared = tops.iter().map(|&p| distance2(p, top)).fold(squared, larger);
        Self { foot, top, radius: squared.sqrt() }
    }

    fn around<'a>(members: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let feet: Vec<_> = members.clone().map(|member| member.foot).collect();
        let tops: Vec<_> = members.clone().map(|member| member.top).collect();
        let (foot, top) = (centre(&feet), centre(&tops));
        let radius = members
            .map(|m| distance2(m.foot, foot).max(distance2(m.top, top)).sqrt() + m.radius)
            .fold(0.0, f32::max);
        Self { foot, top, radius }
    }

    /// Whether the cutter's half-infinite cylinder may touch the capsule.
    fn within_reach(&self, cutter: &FieldCutter) -> bool {
        let axis = cutter.axis;
        let radius = self.radius + REACH_MARGIN;
        let from_tip = sub(self.foot, cutter.tip);
        let along = sub(self.top, self.foot);
        let (z0, dz) = (dot(from_tip, axis), dot(along, axis));
        // Part of the segment that is not wholly below the bottom plane.
        let below = -radius - z0;
        let (mut first, mut last) = (0.0_f32, 1.0_f32);
        if z0.min(z0 + dz) < -radius {
            if z0.max(z0 + dz) < -radius {
                return false;
            }
            // One end is above and one below, so dz is not 0.
            if dz > 0.0 { first = below / dz } else { last = below / dz }
        }
        // Nearest approach of that part to the axis.
        let across0 = add_scaled(from_tip, axis, -z0);
        let across = add_scaled(along, axis, -dz);
        let nearest = (-dot(across0, across) / dot(across, across).max(1e-12)).max(first).min(last);
        let gap = add_scaled(across0, across, nearest);
        let reach = radius + cutter.radius;
        dot(gap, gap) <= reach * reach
    }
}

/// Centre of the box around `points`.
fn centre(points: &[[f32; 3]]) -> [f32; 3] {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in points {
        for axis in 0..3 {
            low[axis] = if p[axis] < low[axis] { p[axis] } else { low[axis] };
            high[axis] = larger(high[axis], p[axis]);
        }
    }
    std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]))
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn add_scaled(a: [f32; 3], b: [f32; 3], scale: f32) -> [f32; 3] {
    [a[0] + b[0] * scale, a[1] + b[1] * scale, a[2] + b[2] * scale]
}

fn distance2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = sub(a, b);
    dot(d, d)
}
