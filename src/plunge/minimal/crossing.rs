//! Entry into a row from the previous row. In front of a splitter's nose the rows beside the splitter leave a
//! strip of stock, and a row that begins in it would have to stop short over a long distance; so would one
//! that begins anew where walls turn its axis. It is entered from the side, in steps no wider than the
//! inserts.

use super::candidate::{CandidateMaker, RowCandidate};
use super::path::PathSearch;
use crate::cutting::contact::{Columns, ContactSearch};
use crate::monitor::Cancelled;
use crate::plunge::row::{RowMaker, Station};

/// Step across in step limits of the row: the hub curves across the row, so smaller steps need smaller lifts.
const STEP_SHARE: f64 = 0.6;

/// A sequence of plunges from one row to the next.
pub struct RowCrossing<'a> {
    /// Search of the row to be reached.
    pub search: &'a PathSearch<'a>,
    /// λ of the row it starts from, which is already cut.
    pub from: f64,
    /// As [`CandidateMaker::max_side_shift`], of that row, mm.
    pub side_shift_from: f64,
    /// s along the channel.
    pub s: f64,
}

impl RowCrossing<'_> {
    /// Stations from the previous row to this one, the last of them on this row; empty where no axis fits.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn stations(&self, earlier: &Columns) -> Result<Vec<Station>, Cancelled> {
        let goal = self.search.candidates.maker;
        let foot = |lambda: f64| Some(goal.lane.hub_point(&goal.lane.isoparametric(lambda, self.s)?));
        let (Some(from), Some(to)) = (foot(self.from), foot(goal.lambda)) else { return Ok(Vec::new()) };
        let count = ((to - from).norm() / (STEP_SHARE * goal.step_limit)).ceil().clamp(1.0, 200.0) as usize;
        let mut columns = earlier.clone();
        let mut stations: Vec<Station> = Vec::with_capacity(count);
        for i in 1..=count {
            goal.monitor.check()?;
            let share = i as f64 / count as f64;
            let between = |from: f64, to: f64| from + (to - from) * share;
            let lambda = between(self.from, goal.lambda);
            let maker = RowMaker { lambda, ..goal.clone() };
            // The axis tilts as that of the previous row at first.
            let max_side_shift = between(self.side_shift_from, self.search.candidates.max_side_shift);
            let candidates =
                CandidateMaker { maker: &maker, max_side_shift, ..self.search.candidates.clone() };
            let Some((candidate, lift)) = self.best_candidate(&candidates, stations.last(), &columns) else {
                continue;
            };
            columns.push(candidates.column(&candidate.station).lifted(lift));
            stations.push(candidate.station);
        }
        Ok(stations)
    }

    /// The cheapest candidate and its lift, mm.
    fn best_candidate(
        &self,
        candidates: &CandidateMaker,
        before: Option<&Station>,
        columns: &Columns,
    ) -> Option<(RowCandidate, f64)> {
        let place = candidates.stage_at(self.s)?;
        let mut search = ContactSearch::default();
        let mut best: Option<(f64, RowCandidate, f64)> = None;
        for index in place.indices(1) {
            let Some(candidate) = candidates.cleared(&place, index) else { continue };
            if !candidates.is_cleared_long_enough(&place, index) {
                continue;
            }
            if before.is_some_and(|b| b.axis.angle(&candidate.station.axis) > self.search.max_axis_change_rad)
            {
                continue;
            }
            let column = candidates.column(&candidate.station);
            let lift =
                search.among(&column, columns.all().near(&column)).depth(self.search.blank, f64::INFINITY);
            let cost = candidate.cost(lift, candidates.scale);
            if best.is_none_or(|b| cost < b.0) {
                best = Some((cost, candidate, lift));
            }
        }
        best.map(|(_, candidate, lift)| (candidate, lift))
    }
}
