//! The path that a search found for a row.

use super::candidate::RowCandidate;
use crate::plunge::assembly::DropCause;
use crate::plunge::row::Station;

/// A position of a path.
#[derive(Clone, Debug)]
pub struct PathStep {
    /// Axis and depth.
    pub station: Station,
    /// Lift that the search gave it, mm.
    pub lift: f64,
    pub(super) candidate: RowCandidate,
    /// Whether the layer left there counts: not before the start of the row.
    pub(super) counts: bool,
}

/// A path along a row.
#[derive(Clone, Debug, Default)]
pub struct RowPath {
    /// Its positions in cutting order.
    pub steps: Vec<PathStep>,
    /// Cost: the sum over its positions and the stages that it does not reach, mm.
    pub cost: f64,
    /// Cost up to which a path is hardly worse than the lower bound on any path (blades and contact are
    /// ignored), mm.
    pub acceptable_cost: f64,
    /// Lower bound on the cost of any path, mm.
    pub min_cost: f64,
    /// s of the stages from the start on at which nothing is cut, and why.
    pub missing: Vec<(f64, DropCause)>,
    /// Cost of these stages, mm.
    pub(super) missing_cost: f64,
}

impl RowPath {
    /// Maximum lift of its plunges, mm.
    pub(super) fn highest_lift(&self) -> f64 {
        self.steps.iter().map(|step| step.lift).fold(0.0, f64::max)
    }

    /// s of the first position from which on plunges stop more than `lift` mm short, but for the `known`
    /// ones.
    pub(super) fn first_short(&self, lift: f64, known: &[f64]) -> Option<f64> {
        let is_short = |k: usize| self.steps[k].lift > lift;
        let begins = (0..self.steps.len()).filter(|&k| is_short(k) && (k == 0 || !is_short(k - 1)));
        begins.map(|k| self.steps[k].station.ends.s_hub).find(|s| !known.contains(s))
    }

    /// s of its positions from the start on.
    pub fn places(&self) -> impl Iterator<Item = f64> {
        self.steps.iter().filter(|step| step.counts).map(|step| step.station.ends.s_hub)
    }

    /// Cost of the path as it was cut: `lift_at` gives the lift (mm) at an s of the hub, `None` where the
    /// plunge was left out.
    pub fn cost_as_cut(&self, scale: f64, lift_at: impl Fn(f64) -> Option<f64>) -> f64 {
        let cost = |step: &PathStep| match lift_at(step.station.ends.s_hub) {
            Some(lift) => step.candidate.cost(lift, scale),
            None => step.candidate.uncut_cost(scale),
        };
        self.missing_cost + self.steps.iter().filter(|step| step.counts).map(cost).sum::<f64>()
    }
}
