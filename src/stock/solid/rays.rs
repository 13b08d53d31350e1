//! All rays of one direction, in tiles.

use std::sync::Arc;

use rayon::prelude::*;

use super::lattice::Lattice;
use super::span::Span;

/// Rays along each side of a tile.
pub const TILE: usize = 16;

/// The spans of a square of rays, ray after ray.
#[derive(Clone, Debug, Default)]
pub struct RayTile {
    /// Where the spans of each ray end in `spans`; empty where no ray has any.
    ends: Vec<u32>,
    spans: Vec<Span>,
}

impl RayTile {
    /// The spans of a ray, by its number within the tile.
    #[inline]
    pub fn spans(&self, ray: usize) -> &[Span] {
        if self.ends.is_empty() {
            return &[];
        }
        let from = if ray == 0 { 0 } else { self.ends[ray - 1] as usize };
        &self.spans[from..self.ends[ray] as usize]
    }

    /// Whether no ray meets stock.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Number of spans.
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// Memory that it takes, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.spans.capacity() * size_of::<Span>()
            + self.ends.capacity() * size_of::<u32>()
    }

    /// Copies the spans of all rays.
    pub fn load(&self, rays: &mut [Vec<Span>]) {
        for (ray, spans) in rays.iter_mut().enumerate() {
            spans.clear();
            spans.extend_from_slice(self.spans(ray));
        }
    }

    /// The tile with the spans of all rays.
    pub fn from_rays(rays: &[Vec<Span>]) -> Self {
        let count: usize = rays.iter().map(Vec::len).sum();
        if count == 0 {
            return Self::default();
        }
        let (mut ends, mut spans) = (Vec::with_capacity(rays.len()), Vec::with_capacity(count));
        for ray in rays {
            spans.extend_from_slice(ray);
            ends.push(spans.len() as u32);
        }
        Self { ends, spans }
    }

    /// Least and greatest coordinate of stock on any ray.
    pub fn range(&self) -> (f64, f64) {
        self.spans
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s.from), high.max(s.to)))
    }
}

/// All rays of one direction.
#[derive(Clone, Debug)]
pub struct RayField {
    /// The coordinate along which they run: 0, 1 or 2.
    pub direction: usize,
    /// Number of rays along both coordinates across.
    pub counts: (usize, usize),
    /// Number of tiles along both.
    pub tiles_across: (usize, usize),
    /// Tiles, row by row of the first coordinate. Copies of a stock share those that no cut tells apart.
    pub tiles: Vec<Arc<RayTile>>,
}

impl RayField {
    /// Fills the rays along `direction`: `fill(u, v, spans)` adds those of one ray, sorted and disjoint.
    pub fn filled(
        lattice: &Lattice,
        direction: usize,
        fill: impl Fn(usize, usize, &mut Vec<Span>) + Sync,
    ) -> Self {
        let (a, b) = Lattice::across(direction);
        let counts = (lattice.counts[a], lattice.counts[b]);
        let tiles_across = (counts.0.div_ceil(TILE), counts.1.div_ceil(TILE));
        let tiles = (0..tiles_across.0 * tiles_across.1)
            .into_par_iter()
            .map_init(
                || vec![Vec::new(); TILE * TILE],
                |rays, tile| {
                    let (i, j) = (tile / tiles_across.1 * TILE, tile % tiles_across.1 * TILE);
                    for (k, spans) in rays.iter_mut().enumerate() {
                        spans.clear();
                        let (u, v) = (i + k / TILE, j + k % TILE);
                        if u < counts.0 && v < counts.1 {
                            fill(u, v, spans);
                        }
                    }
                    Arc::new(RayTile::from_rays(rays))
                },
            )
            .collect();
        Self { direction, counts, tiles_across, tiles }
    }

    /// The spans of ray (u, v).
    #[inline]
    pub fn spans(&self, u: usize, v: usize) -> &[Span] {
        let tile = (u / TILE) * self.tiles_across.1 + v / TILE;
        self.tiles[tile].spans((u % TILE) * TILE + v % TILE)
    }

    /// Sum of the lengths of all spans, mm. Tiles are summed in order, so it does not depend on threads.
    pub fn length(&self) -> f64 {
        let lengths: Vec<f64> = self
            .tiles
            .par_iter()
            .map(|tile| tile.spans.iter().map(|span| span.to - span.from).sum::<f64>())
            .collect();
        lengths.iter().sum()
    }
}
