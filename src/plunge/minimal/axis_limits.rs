//! What keeps a position from the axis that would leave the least stock there.

use super::candidate::{CandidateMaker, CandidateStage, RowCandidate};
use crate::geometry::Vector;
use crate::plunge::reasons::LimitedBy;

/// Saving of another axis from which on a position is reported as limited, mm.
const MIN_REPORTED_SAVING: f64 = 0.02;

/// What limits the axes of a row.
pub(super) struct AxisLimits<'a> {
    pub candidates: &'a CandidateMaker<'a>,
    /// Largest turn from the position before, rad.
    pub max_turn_rad: f64,
}

impl AxisLimits<'_> {
    /// What keeps the `chosen` candidate, with its lift (mm), from the cheapest one at its place; `before` is
    /// the axis of the position before. Candidates are those of every `stride`-th lead angle.
    pub fn what_limits(
        &self,
        place: &CandidateStage,
        (chosen, lift): (&RowCandidate, f64),
        before: Option<Vector>,
        stride: usize,
    ) -> Option<LimitedBy> {
        let cost = |c: &RowCandidate| c.cost(0.0, self.candidates.scale);
        let index = place.cheapest(self.candidates.scale, stride)?;
        let cheapest = place.candidate(index)?;
        let least = cost(cheapest).min(cost(chosen)) - MIN_REPORTED_SAVING;
        if self.candidates.machine_forbids_below(least, place, stride) {
            return Some(LimitedBy::Machine);
        }
        if lift == 0.0 && cost(chosen) <= cost(cheapest) + MIN_REPORTED_SAVING {
            return None;
        }
        let turn = |before: Vector| before.angle(&cheapest.station.axis);
        Some(if self.candidates.cleared(place, index).is_none_or(|c| cost(&c) >= cost(chosen)) {
            LimitedBy::Walls
        } else if before.is_some_and(|before| turn(before) > self.max_turn_rad) {
            LimitedBy::AxisChange
        } else {
            LimitedBy::Contact
        })
    }
}
