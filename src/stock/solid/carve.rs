//! Removes pieces of moves from the rays of a stock, tile by tile, and records what must not meet it.

use std::sync::Arc;

use rayon::prelude::*;

use super::lattice::Lattice;
use super::part::{Action, ToolPart};
use super::piece::{Extent, Piece, PieceOnRays};
use super::rays::{RayField, RayTile, TILE};
use super::span::{Span, SpanEnd, cut};
use crate::geometry::Point;

/// Cuts in a tile after which the bounds of its stock are computed anew; in between they are only too wide.
const REFRESH: u32 = 4;
/// Neighbouring rays along each side of a block, and blocks along each side of a tile.
const BLOCK: usize = 4;
const BLOCKS: usize = TILE / BLOCK;
/// Ends of the stock of a ray that has none.
const NO_STOCK: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);
/// A gap that holds nothing.
const NO_GAP: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// Stock that a part of a tool met in one move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Number of the move.
    pub number: u32,
    /// The part.
    pub part: ToolPart,
    /// Of the core: height above the bottom at the end of the plunge up to which it meets stock, mm. Of other
    /// parts: how deep stock gets into them, mm.
    pub depth: f64,
    /// Where this is, mm.
    pub point: Point,
}

/// Depth of contact above which it is reported, mm.
#[derive(Clone, Copy, Debug)]
pub struct ResolvedDepth {
    /// Of a cutter in rapid.
    pub cutter: f64,
    /// Of other parts.
    pub other: f64,
}

/// The tiles that each piece may meet: for each tile the indices of pieces, in order.
fn bins(lattice: &Lattice, field: &RayField, pieces: &[Piece]) -> Vec<Vec<u32>> {
    let (a, b) = Lattice::across(field.direction);
    let side = lattice.spacing * TILE as f64;
    let mut bins = vec![Vec::new(); field.tiles.len()];
    for (index, piece) in (0u32..).zip(pieces) {
        let (low, high) = piece.bounds();
        let range = |k: usize, count: usize| {
            let first = ((low[k] - lattice.origin[k]) / side).floor().max(0.0);
            let last = ((high[k] - lattice.origin[k]) / side).floor().min(count as f64 - 1.0);
            (first as usize, (last.max(-1.0) + 1.0) as usize)
        };
        let (rows, columns) = (range(a, field.tiles_across.0), range(b, field.tiles_across.1));
        // A tile is met only if its centre is near to the axis of the piece in the middle of its travel.
        let middle = piece.base + 0.5 * piece.travel;
        let (px, py) = (middle[a], middle[b]);
        let (dx, dy) = (piece.axis[a] * piece.outline.length, piece.axis[b] * piece.outline.length);
        let squared = dx * dx + dy * dy;
        let moved = 0.5 * piece.travel[a].hypot(piece.travel[b]);
        let reach = piece.outline.radius + moved + side * std::f64::consts::FRAC_1_SQRT_2;
        for i in rows.0..rows.1 {
            let x = lattice.origin[a] + (i as f64 + 0.5) * side - 0.5 * lattice.spacing - px;
            for j in columns.0..columns.1 {
                let tile = i * field.tiles_across.1 + j;
                if field.tiles[tile].is_empty() {
                    continue;
                }
                let y = lattice.origin[b] + (j as f64 + 0.5) * side - 0.5 * lattice.spacing - py;
                let share = if squared > 1e-12 { ((x * dx + y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
                let (x, y) = (x - share * dx, y - share * dy);
                if x * x + y * y <= reach * reach {
                    bins[tile].push(index);
                }
            }
        }
    }
    bins
}

/// Direction, first ray along both coordinates, tile, and indices of the pieces that may meet it.
type TileTask<'a> = (usize, usize, usize, &'a mut Arc<RayTile>, &'a [u32]);

/// Applies `pieces` in order to all rays of `fields`; returns for each move and part the deepest contact,
/// where it is more than `resolved`, sorted by move and part.
pub fn carve(
    lattice: &Lattice,
    fields: &mut [RayField; 3],
    pieces: &[Piece],
    resolved: ResolvedDepth,
) -> Vec<Contact> {
    let all: Vec<Vec<Vec<u32>>> = fields.par_iter().map(|field| bins(lattice, field, pieces)).collect();
    let mut tasks: Vec<TileTask> = Vec::new();
    for (field, bins) in fields.iter_mut().zip(&all) {
        let (direction, across) = (field.direction, field.tiles_across.1);
        for (index, (tile, bin)) in field.tiles.iter_mut().zip(bins).enumerate() {
            if !bin.is_empty() {
                tasks.push((direction, index / across * TILE, index % across * TILE, tile, bin));
            }
        }
    }
    let found: Vec<Vec<Contact>> = tasks
        .into_par_iter()
        .map_init(
            || (vec![Vec::new(); TILE * TILE], vec![NO_STOCK; TILE * TILE]),
            |(rays, ends), (direction, u, v, tile, bin)| {
                tile.load(rays);
                rays.iter().zip(ends.iter_mut()).for_each(|(spans, ends)| *ends = ends_of(spans));
                let (found, changes) = (Vec::new(), 0);
                let gaps = [NO_GAP; BLOCKS * BLOCKS];
                let mut carver =
                    TileCarver { lattice, direction, u, v, rays, ends, gaps, found, resolved, changes };
                let (mut range, mut changed) = (tile.range(), false);
                for &index in bin {
                    changed |= carver.apply(&pieces[index as usize], &mut range);
                }
                let found = carver.found;
                if changed {
                    *tile = Arc::new(RayTile::from_rays(rays));
                }
                found
            },
        )
        .collect();
    deepest(found.into_iter().flatten().collect())
}

/// The deepest contact of each move and part, sorted by them.
pub fn deepest(mut found: Vec<Contact>) -> Vec<Contact> {
    let place = |c: &Contact| [c.point.x, c.point.y, c.point.z];
    let order = |a: &Contact, b: &Contact| {
        let places = place(a).into_iter().zip(place(b));
        let nearer = places.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne());
        (a.number, a.part)
            .cmp(&(b.number, b.part))
            .then(b.depth.total_cmp(&a.depth))
            .then(nearer.unwrap_or(std::cmp::Ordering::Equal))
    };
    found.sort_by(order);
    found.dedup_by_key(|contact| (contact.number, contact.part));
    found
}

/// Where the stock of a ray begins and ends.
fn ends_of(spans: &[Span]) -> (f64, f64) {
    match (spans.first(), spans.last()) {
        (Some(head), Some(tail)) => (head.from, tail.to),
        _ => NO_STOCK,
    }
}

/// The gap between the spans of a ray around the coordinate `t`; [`NO_GAP`] where there is stock.
fn gap_around(spans: &[Span], t: f64) -> (f64, f64) {
    let mut low = f64::NEG_INFINITY;
    for span in spans {
        if span.from >= t {
            return (low, span.from);
        }
        if span.to > t {
            return NO_GAP;
        }
        low = span.to;
    }
    (low, f64::INFINITY)
}

/// The rays of a tile while pieces are applied to them.
struct TileCarver<'a> {
    lattice: &'a Lattice,
    direction: usize,
    /// First ray along both coordinates.
    u: usize,
    v: usize,
    rays: &'a mut [Vec<Span>],
    /// Of each ray where its stock begins and ends; [`NO_STOCK`] where it has none.
    ends: &'a mut [(f64, f64)],
    /// Of each block two coordinates between which none of its rays has stock. Stock is only removed, so that
    /// a gap stays one.
    gaps: [(f64, f64); BLOCKS * BLOCKS],
    found: Vec<Contact>,
    resolved: ResolvedDepth,
    /// Number of pieces that removed stock.
    changes: u32,
}

impl TileCarver<'_> {
    /// Applies one piece; `range` are bounds of all stock in the tile. Returns whether stock was removed.
    ///
    /// A tool moves in small steps, so most of the space that it sweeps has been cut already: blocks of rays
    /// are skipped where the piece stays within their gap.
    fn apply(&mut self, piece: &Piece, range: &mut (f64, f64)) -> bool {
        let (low, high) = piece.bounds();
        if low[self.direction] >= range.1 || high[self.direction] <= range.0 {
            return false;
        }
        let on_rays = PieceOnRays::new(piece, self.direction);
        let first = on_rays.local(&self.lattice.ray(self.direction, self.u, self.v));
        let steps = on_rays.steps(Lattice::across(self.direction), self.lattice.spacing);
        let to_middle = 0.5 * (BLOCK - 1) as f64;
        let of_ray = on_rays.extent(0.0);
        let of_block = on_rays.extent(to_middle * std::f64::consts::SQRT_2 * self.lattice.spacing);
        let mut changed = false;
        for block in 0..self.gaps.len() {
            let (u, v) = (block / BLOCKS * BLOCK, block % BLOCKS * BLOCK);
            let middle = moved(&first, u as f64 + to_middle, &steps.0);
            let (least, most) = of_block.on_ray(&moved(&middle, v as f64 + to_middle, &steps.1));
            let (from, to) = self.gaps[block];
            if least > most || from <= least && most <= to {
                continue;
            }
            for i in u..u + BLOCK {
                let row = moved(&first, i as f64, &steps.0);
                for j in v..v + BLOCK {
                    let origin = moved(&row, j as f64, &steps.1);
                    changed |= self.apply_to_ray((&on_rays, &of_ray), (i, j), &origin);
                }
            }
            self.gaps[block] = self.gap_of_block((u, v), 0.5 * (least + most));
        }
        self.changes += u32::from(changed);
        if changed && self.changes.is_multiple_of(REFRESH) {
            *range =
                self.ends.iter().fold(NO_STOCK, |(low, high), &(from, to)| (low.min(from), high.max(to)));
        }
        changed
    }

    /// Around the coordinate `t`, the gap of all rays of the block that begins at (`u`, `v`).
    fn gap_of_block(&self, (u, v): (usize, usize), t: f64) -> (f64, f64) {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in u..u + BLOCK {
            for spans in &self.rays[i * TILE + v..i * TILE + v + BLOCK] {
                let (from, to) = gap_around(spans, t);
                (low, high) = (low.max(from), high.min(to));
                if low > high {
                    return NO_GAP;
                }
            }
        }
        (low, high)
    }

    /// Applies a piece with its extent to the ray (`i`, `j`) of the tile through `origin` (in the frame of
    /// the piece). Returns whether stock was removed.
    #[inline]
    fn apply_to_ray(
        &mut self,
        (on_rays, extent): (&PieceOnRays, &Extent),
        (i, j): (usize, usize),
        origin: &[f64; 3],
    ) -> bool {
        let (from, to) = self.ends[i * TILE + j];
        if from > to {
            return false;
        }
        let (least, most) = extent.on_ray(origin);
        if from > most || to < least {
            return false;
        }
        let spans = &mut self.rays[i * TILE + j];
        if spans.iter().all(|span| span.from > most || span.to < least) {
            return false;
        }
        let Some(swept) = on_rays.interval(origin) else { return false };
        if swept.low >= to || swept.high <= from {
            return false;
        }
        match on_rays.action() {
            Action::Cut => {
                let changed = cut(spans, swept.low, swept.high, |at_high| {
                    let (t, share) =
                        if at_high { (swept.high, swept.high_share) } else { (swept.low, swept.low_share) };
                    // The stock lies on the other side of the cutter's surface.
                    SpanEnd::new(&-on_rays.normal(origin, t, share), on_rays.number())
                });
                self.ends[i * TILE + j] = ends_of(spans);
                changed
            }
            Action::Check(part) => {
                let ray = self.lattice.ray(self.direction, self.u + i, self.v + j);
                for span in spans.iter() {
                    let at = (swept.low.max(span.from), swept.high.min(span.to));
                    if at.0 < at.1 {
                        let rays = (origin, ray);
                        record(&mut self.found, on_rays, self.direction, rays, part, at, self.resolved);
                    }
                }
                false
            }
        }
    }
}

/// `point` moved by `count` steps.
#[inline(always)]
fn moved(point: &[f64; 3], count: f64, step: &[f64; 3]) -> [f64; 3] {
    [point[0] + count * step[0], point[1] + count * step[1], point[2] + count * step[2]]
}

/// Records stock between two points of a ray in a part of a tool.
fn record(
    found: &mut Vec<Contact>,
    on_rays: &PieceOnRays,
    direction: usize,
    (origin, ray): (&[f64; 3], Point),
    part: ToolPart,
    (low, high): (f64, f64),
    resolved: ResolvedDepth,
) {
    let (depth, t) = if part == ToolPart::Core {
        let (a, b) = (on_rays.height(origin, low), on_rays.height(origin, high));
        if a > b { (a, low) } else { (b, high) }
    } else {
        on_rays.depth(origin, low, high)
    };
    if depth <= if part == ToolPart::Cutter { resolved.cutter } else { resolved.other } {
        return;
    }
    let mut point = ray;
    point[direction] = t;
    let contact = Contact { number: on_rays.number(), part, depth, point };
    // Pieces of one move follow each other: mostly the last contact is of the same move and part.
    let same = found.iter_mut().rev().take(4).find(|c| (c.number, c.part) == (contact.number, part));
    match same {
        Some(known) if known.depth >= depth => {}
        Some(known) => *known = contact,
        None => found.push(contact),
    }
}
