//! Stages of a row: the places at which a search looks for axes, and how fine its grid of lead angles is.

use rayon::prelude::*;

use super::candidate::{CandidateMaker, CandidateStage};
use super::path::{COST_OF_NEW_ROW, COST_PER_POSITION, PathSearch};

/// How often the interval between two stages is halved so that axes turn less.
const MAX_HALVINGS: usize = 4;
/// Share of the allowed axis change above which an interval between axes of the same lead angle is halved.
const TURN_SHARE: f64 = 0.7;
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

impl PathSearch<'_> {
    /// Makes the stages at every s, and between two of them where the axes turn too much, or those that the
    /// current grid needs and that earlier searches did not.
    pub(super) fn make_stages(&self, s: &[f64], stages: &mut RowStages) {
        let monitor = self.candidates.maker.monitor;
        if stages.fineness == 0 {
            (stages.places, stages.fineness) = (self.stages(s), self.candidates.fineness);
        }
        while stages.fineness < self.candidates.fineness && !monitor.is_cancelled() {
            stages.fineness *= 2;
            let maker = CandidateMaker { fineness: stages.fineness, ..self.candidates.clone() };
            let places = stages.places.par_iter_mut().filter_map(|(_, place)| place.as_mut());
            places.filter(|_| !monitor.is_cancelled()).for_each(|place| maker.refine(place));
        }
    }

    /// The stages at every s, and between two of them where the axes turn too much.
    fn stages(&self, s: &[f64]) -> Vec<StageAt> {
        let monitor = self.candidates.maker.monitor;
        let at = |s: f64| {
            (s, if monitor.is_cancelled() { None } else { self.candidates.stage_at(s).map(Box::new) })
        };
        let mut places: Vec<StageAt> = s.par_iter().map(|&s| at(s)).collect();
        for _ in 0..MAX_HALVINGS {
            let between: Vec<Option<StageAt>> = places
                .par_windows(2)
                .map(|pair| {
                    let [Some(a), Some(b)] = [&pair[0].1, &pair[1].1] else { return None };
                    let too_much = a.min_turn(b) > TURN_SHARE * self.max_axis_change_rad;
                    too_much.then(|| at(0.5 * (pair[0].0 + pair[1].0)))
                })
                .collect();
            if between.iter().all(Option::is_none) {
                break;
            }
            let mut refined = Vec::with_capacity(2 * places.len());
            for (place, between) in places.into_iter().zip(between.into_iter().chain([None])) {
                refined.push(place);
                refined.extend(between);
            }
            places = refined;
        }
        places
    }
}
