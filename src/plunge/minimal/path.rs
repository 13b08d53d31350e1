//! The cheapest path through the candidates of a row.

use rayon::prelude::*;

use super::candidate::{Candidate, CandidateMaker, TILTS};
use crate::geometry::CutterSolid;
use crate::monitor::Cancelled;
use crate::part::Blank;
use crate::plunge::contact::{Column, ContactSearch};
use crate::plunge::row::Station;

/// Positions of the own row that are looked at for contact, besides all earlier rows.
const LOOK_BACK: usize = 4;
/// Cost of a position as such, mm: of two paths that leave the same, the shorter.
const COST_PER_POSITION: f64 = 1e-3;
/// Lift kept above what the fewer lines of the search saw, mm.
const LIFT_MARGIN: f64 = 0.01;

/// A way along a row.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Stations with the lift the search gave them, mm.
    pub steps: Vec<(Station, f64)>,
    /// What it costs: the sum over its positions.
    pub cost: f64,
}

/// A candidate reached.
#[derive(Clone, Copy, Debug)]
struct State {
    cost: f64,
    lift: f64,
    /// Place and tilt of the position before.
    before: Option<(usize, usize)>,
}

/// Searches one row.
pub struct PathSearch<'a> {
    /// Makes the candidates.
    pub candidates: CandidateMaker<'a>,
    /// The blank.
    pub blank: &'a Blank,
    /// Largest angle between neighbouring axes, rad.
    pub max_axis_change: f64,
}

impl PathSearch<'_> {
    /// The cheapest path along the places `s` (in cutting order) after `earlier` plunges. The path may
    /// begin at any of the first `run_up` + 1 places; a layer left before them costs nothing.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn path(&self, s: &[f64], run_up: usize, earlier: &[Column]) -> Result<Path, Cancelled> {
        let monitor = self.candidates.maker.monitor;
        let places: Vec<[Option<Candidate>; TILTS]> = s
            .par_iter()
            .map(|&s| if monitor.is_cancelled() { [None; TILTS] } else { self.candidates.at(s) })
            .collect();
        let mut states: Vec<[Option<State>; TILTS]> = vec![[None; TILTS]; s.len()];
        let mut last: Option<usize> = None;
        for k in 0..s.len() {
            monitor.check()?;
            let near = self.near(&places[k], earlier);
            let (known, rest) = states.split_at_mut(k);
            let reach = |j: usize| self.reach(&places, known, last, (k, j), run_up, &near);
            let reached: Vec<Option<State>> = (0..TILTS).into_par_iter().map(reach).collect();
            rest[0].copy_from_slice(&reached);
            if rest[0].iter().any(Option::is_some) {
                last = Some(k);
            }
        }
        Ok(self.traced(&places, &states, last))
    }

    /// Earlier plunges that any candidate of a place may meet.
    fn near(&self, place: &[Option<Candidate>; TILTS], earlier: &[Column]) -> Vec<Column> {
        let columns: Vec<&Column> = place.iter().flatten().map(|c| &c.column).collect();
        let [Some(&first), Some(&last)] = [columns.first(), columns.last()] else { return Vec::new() };
        let middle = columns[columns.len() / 2];
        // The candidates fan out from one place on the hub: what none of three of them comes near
        // by the width of half the fan, none does.
        let top = columns.iter().map(|c| c.top).filter(|t| t.is_finite()).fold(0.0, f64::max);
        let fan = (first.cutter.axis - last.cutter.axis).norm() * 0.5;
        earlier
            .iter()
            .filter(|other| {
                [first, middle, last].iter().any(|c| {
                    (0..=4).any(|i| {
                        let h = top * f64::from(i) / 4.0;
                        let reach = other.cutter.radius + c.core_radius + fan * h + 0.125 * top;
                        distance_from_axis(&other.cutter, &c.cutter, h) < reach
                    })
                })
            })
            .copied()
            .collect()
    }

    /// The cheapest way to candidate `j` of place `k`.
    fn reach(
        &self,
        places: &[[Option<Candidate>; TILTS]],
        states: &[[Option<State>; TILTS]],
        last: Option<usize>,
        (k, j): (usize, usize),
        run_up: usize,
        near: &[Column],
    ) -> Option<State> {
        let candidate = places[k][j]?;
        let own = |lift: f64| {
            let layer = if k < run_up { 0.0 } else { candidate.cost(lift, self.candidates.scale) };
            layer + COST_PER_POSITION
        };
        let mut search = ContactSearch::default();
        let mut best: Option<State> = None;
        let mut consider = |cost_before: f64, before: Option<(usize, usize)>, search: &mut ContactSearch| {
            if best.is_some_and(|b| b.cost <= cost_before + own(0.0)) {
                return;
            }
            let mut path = [candidate.column; LOOK_BACK];
            let mut count = 0;
            let mut at = before;
            while let Some((k, j)) = at
                && count < LOOK_BACK
            {
                let (Some(passed), Some(state)) = (places[k][j], states[k][j]) else { break };
                path[count] = lifted(&passed.column, state.lift);
                count += 1;
                at = state.before;
            }
            let earlier = near.iter().chain(path[..count].iter().rev());
            let depth = search.depth(&candidate.column, earlier, self.blank);
            let lift = if depth > 0.0 { depth + LIFT_MARGIN } else { 0.0 };
            let cost = cost_before + own(lift);
            if best.is_none_or(|b| cost < b.cost) {
                best = Some(State { cost, lift, before });
            }
        };
        if let Some(last) = last {
            let mut order: [usize; TILTS] = std::array::from_fn(|i| i);
            let cost = |i: usize| states[last][i].map_or(f64::INFINITY, |s| s.cost);
            order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)));
            for i in order {
                let (Some(passed), Some(state)) = (places[last][i], states[last][i]) else { break };
                if passed.station.axis.angle(&candidate.station.axis) <= self.max_axis_change {
                    consider(state.cost, Some((last, i)), &mut search);
                }
            }
        }
        if k <= run_up || last.is_none() {
            consider(0.0, None, &mut search);
        }
        best
    }

    fn traced(
        &self,
        places: &[[Option<Candidate>; TILTS]],
        states: &[[Option<State>; TILTS]],
        last: Option<usize>,
    ) -> Path {
        let cost =
            |&(_, j): &(usize, usize)| last.and_then(|k| states[k][j]).map_or(f64::INFINITY, |s| s.cost);
        let end = last.and_then(|k| {
            (0..TILTS)
                .filter(|&j| states[k][j].is_some())
                .map(|j| (k, j))
                .min_by(|a, b| cost(a).total_cmp(&cost(b)))
        });
        let mut path = Path { steps: Vec::new(), cost: end.as_ref().map_or(0.0, cost) };
        let mut at = end;
        while let Some((k, j)) = at {
            let (Some(candidate), Some(state)) = (places[k][j], states[k][j]) else { break };
            path.steps.push((candidate.station, state.lift));
            at = state.before;
        }
        path.steps.reverse();
        path
    }
}

/// The column of a plunge that stops `lift` mm short.
fn lifted(column: &Column, lift: f64) -> Column {
    let mut column = *column;
    column.cutter.tip += column.cutter.axis * lift;
    column.top -= lift;
    column
}

/// Distance of the point `height` mm above the tip of `cutter` from the axis of `other`.
fn distance_from_axis(other: &CutterSolid, cutter: &CutterSolid, height: f64) -> f64 {
    let d = cutter.tip + cutter.axis * height - other.tip;
    (d - other.axis * d.dot(&other.axis)).norm()
}
