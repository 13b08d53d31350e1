//! Stages of a row that are kept for the next.

use super::candidate::CandidateStage;

/// Cost of each position, mm: breaks ties in favour of the shorter path.
pub(super) const COST_PER_POSITION: f64 = 1e-3;
/// Cost of ending a row and beginning another, mm.
pub(super) const COST_OF_NEW_ROW: f64 = 5.0;
/// Number of successive searches with little gain from a finer grid after which rows skip it, and number of
/// rows that skip it before one tries again.
const MAX_VAIN: usize = 2;

const MAX_SKIPPED: usize = 3;

/// A stage with its s. Boxed, as stages are large and are moved.
pub(super) type StageAt = (f64, Option<Box<CandidateStage>>);

/// The stages of a row on the finest grid of lead angles so far. They do not depend on what was cut, so all
/// searches of a row share them.
#[derive(Default)]
pub struct RowStages {
    /// Number of successive searches on a finer grid that gained little; see [`MAX_VAIN`].
    pub(super) vain: usize,
    /// Number of rows that skipped the finer grid since.
    skipped: usize,
    pub(super) places: Vec<StageAt>,
    /// See [`CandidateMaker::fineness`]; 0 before the first search.
    pub(super) fineness: usize,
}

impl RowStages {
    /// Forgets the stages: those of the next row are others.
    pub fn next_row(&mut self) {
        *self = Self { vain: self.vain, skipped: self.skipped, ..Self::default() };
    }

    /// Whether this row tries a finer grid: after several that gained little only every few rows do.
    pub(super) fn tries_finer(&mut self) -> bool {
        let tries = self.vain < MAX_VAIN || self.skipped >= MAX_SKIPPED;
        self.skipped = if tries { 0 } else { self.skipped + 1 };
        tries
    }

    /// What a path along the stages may cost besides the layers that it leaves, mm.
    pub fn cost_beside_layers(&self) -> f64 {
        COST_PER_POSITION * self.places.len() as f64 + COST_OF_NEW_ROW
    }
}
