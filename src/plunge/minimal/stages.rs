//! Stages of a row: the places at which a search looks for axes, and how fine its grid of lead angles is.

use rayon::prelude::*;

use super::candidate::CandidateMaker;
use super::path::PathSearch;
use super::row_stages::{RowStages, StageAt};

/// How often the interval between two stages is halved so that axes turn less.
const MAX_HALVINGS: usize = 4;
/// Share of the allowed axis change above which an interval between axes of the same lead angle is halved.
const TURN_SHARE: f64 = 0.7;

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
