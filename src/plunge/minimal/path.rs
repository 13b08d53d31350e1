//! The cheapest path through the candidates of a row.

use rayon::prelude::*;

use super::candidate::{Candidate, CandidateMaker, Place};
use crate::geometry::Vector;
use crate::monitor::Cancelled;
use crate::part::Blank;
use crate::plunge::contact::{Column, Columns, ContactSearch};
use crate::plunge::plan::Held;
use crate::plunge::row::Station;

/// Positions of the own row that are looked at for contact, besides all earlier rows.
const LOOK_BACK: usize = 4;
/// Cost of a position as such, mm: of two paths that leave the same, the shorter.
const COST_PER_POSITION: f64 = 1e-3;
/// Times the way between two places is halved for their axes to turn less, and the share of the allowed change that
/// axes of the same tilt may use up.
const MAX_HALVINGS: usize = 4;
const TURN_SHARE: f64 = 0.7;
/// Cost by which a tilt may be behind the best one of its place and still be followed, mm.
const BEAM: f64 = 3.0;
/// Cost of ending a row and beginning another, mm.
const COST_OF_NEW_ROW: f64 = 5.0;
/// What a place without any axis costs beside one that leaves a thick layer, mm.
const COST_OF_MISSED: f64 = 30.0;
/// Lift of a position from which on finer tilts may free it, in cutter radii.
const COARSE_LIFT_RADII: f64 = 0.3;
/// Into how many parts the steps from tilt to tilt are divided at most.
const MOST_FINENESS: usize = 4;
/// Share of its cost that a path must gain by finer tilts for still finer ones to be looked at.
const LEAST_GAINED: f64 = 0.02;
/// Cost by which another axis must be better for a position to count as held back, mm.
const WORTH_TELLING: f64 = 0.02;
/// Lift kept above what the fewer lines of the search saw, mm.
const LIFT_MARGIN: f64 = 0.01;

/// A way along a row.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Stations with the lift the search gave them, mm.
    pub steps: Vec<(Station, f64)>,
    /// What it costs: the sum over its positions, and the places at the end that it does not reach.
    pub cost: f64,
    /// What no path could cost less than, by blades and contact or without them.
    pub least: f64,
    /// s of the places from the start on at which the cutter has no axis at all.
    pub missing: Vec<f64>,
}

impl Path {
    /// By how much one of its plunges stops short at most, mm.
    fn highest_lift(&self) -> f64 {
        self.steps.iter().map(|(_, lift)| *lift).fold(0.0, f64::max)
    }
}

/// A candidate reached, on the cheapest way to it.
#[derive(Clone, Copy, Debug)]
struct State {
    candidate: Candidate,
    column: Column,
    /// Of the way so far.
    cost: f64,
    /// How far the plunge stops short, mm.
    lift: f64,
    /// Place and tilt of the position before.
    before: Option<(usize, usize)>,
}

/// An s and what there is. A place is large, and they are moved about.
type PlaceAt = (f64, Option<Box<Place>>);
/// States of one place, by tilt.
type States = Vec<Option<State>>;

/// Searches one row.
pub struct PathSearch<'a> {
    /// Makes the candidates.
    pub candidates: CandidateMaker<'a>,
    /// The blank.
    pub blank: &'a Blank,
    /// Largest angle between neighbouring axes, rad.
    pub max_axis_change: f64,
}

/// What is the same for all candidates of a place.
struct Here<'h> {
    /// States of the places before.
    states: &'h [States],
    /// The last place that has any, and its states by cost, the cheapest first.
    last: Option<usize>,
    order: Vec<usize>,
    /// Whether a row may begin here.
    may_begin: bool,
    /// Whether the layer left here counts.
    counts: bool,
    /// Plunges of earlier rows.
    earlier: &'h Columns,
}

/// A candidate that the blades allow, and how contact sees it.
struct Leg {
    candidate: Candidate,
    column: Column,
    /// Among the plunges of earlier rows.
    search: ContactSearch,
}

/// Numbers of states, the cheapest first.
fn by_cost(states: &States) -> Vec<usize> {
    let cost = |i: usize| states[i].map_or(f64::INFINITY, |s| s.cost);
    let mut order: Vec<usize> = (0..states.len()).collect();
    order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)));
    order
}

impl PathSearch<'_> {
    /// The cheapest path along the places `s` (in cutting order) after `earlier` plunges. The path may begin anywhere
    /// up to s = `start`; a layer left before it costs nothing. Places are added where the axes turn too much from
    /// one to the next. Where one has to stop short, tilts are looked at more finely if the cutter is slender.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn path(&self, s: &[f64], start: f64, earlier: &Columns) -> Result<Path, Cancelled> {
        let radius = self.candidates.maker.tool.radius();
        let mut best = self.path_by(s, start, earlier)?;
        let mut finer = PathSearch { candidates: self.candidates.clone(), ..*self };
        while finer.candidates.fineness < MOST_FINENESS
            && best.highest_lift() > COARSE_LIFT_RADII * radius
            && finer.candidates.is_coarse(s)
        {
            finer.candidates.fineness *= 2;
            let path = match finer.path_by(s, start, earlier) {
                // What was found until now stands for itself.
                Err(_) if self.candidates.maker.monitor.is_stopped() => break,
                path => path?,
            };
            let gained = best.cost - path.cost;
            if gained > 0.0 {
                best = path;
            }
            if gained < LEAST_GAINED * best.cost {
                break;
            }
        }
        Ok(best)
    }

    /// [`Self::path`] by the tilts as they are.
    fn path_by(&self, s: &[f64], start: f64, earlier: &Columns) -> Result<Path, Cancelled> {
        let monitor = self.candidates.maker.monitor;
        let inward = self.candidates.maker.inward;
        let places = self.places(s);
        let mut states: Vec<States> = Vec::with_capacity(places.len());
        let mut last: Option<usize> = None;
        for (k, (s, place)) in places.iter().enumerate() {
            monitor.check()?;
            // Ahead of the start is where the cut has not come yet.
            let ahead = (start - s) * inward;
            let Some(place) = place else {
                states.push(States::new());
                continue;
            };
            let here = Here {
                states: &states,
                last,
                order: last.map_or_else(Vec::new, |last| by_cost(&states[last])),
                may_begin: ahead <= 1e-9 || last.is_none(),
                counts: ahead >= -1e-9,
                earlier,
            };
            let reached = self.reached(place, &here);
            if reached.iter().any(Option::is_some) {
                last = Some(k);
            }
            states.push(reached);
        }
        // A layer left before the start costs nothing.
        let counts = |s: f64| (start - s) * inward >= -1e-9;
        let least: f64 = places
            .iter()
            .filter(|(s, _)| counts(*s))
            .filter_map(|(_, place)| place.as_ref()?.cheapest(self.candidates.scale))
            .map(|cost| cost + COST_PER_POSITION)
            .sum();
        let path = self.traced(&places, &states, last);
        let missing = places.iter().filter(|(s, place)| counts(*s) && place.is_none()).map(|(s, _)| *s);
        let path = Path { missing: missing.collect(), least, ..path };
        let (Some(&end), [first, second, ..]) = (s.last(), s) else { return Ok(path) };
        let reached = path.steps.last().map_or(start, |(station, _)| station.ends.s_hub);
        let missed = ((end - reached) / (second - first)).abs();
        Ok(Path { cost: path.cost + COST_OF_MISSED * missed, ..path })
    }

    /// What there is at every s, and between two of them where the axes turn too much on the way.
    fn places(&self, s: &[f64]) -> Vec<PlaceAt> {
        let monitor = self.candidates.maker.monitor;
        let at =
            |s: f64| (s, if monitor.is_cancelled() { None } else { self.candidates.at(s).map(Box::new) });
        let mut places: Vec<PlaceAt> = s.par_iter().map(|&s| at(s)).collect();
        for _ in 0..MAX_HALVINGS {
            let between: Vec<Option<PlaceAt>> = places
                .par_windows(2)
                .map(|pair| {
                    let [Some(a), Some(b)] = [&pair[0].1, &pair[1].1] else { return None };
                    let too_much = a.least_turn(b) > TURN_SHARE * self.max_axis_change;
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

    /// States of a place. Tilts that cannot come near the best are left out, unless the best has to stop
    /// short or is blocked.
    fn reached(&self, place: &Place, here: &Here) -> States {
        let bounds: Vec<f64> = place.tilts.iter().map(|tilt| self.bound(tilt, here)).collect();
        let promising = bounds.iter().copied().fold(f64::INFINITY, f64::min) + BEAM;
        let reach = |j: usize| self.reach(j, place, here);
        let mut states: States = vec![None; bounds.len()];
        let mut fill = |wanted: &(dyn Fn(f64) -> bool + Sync)| {
            let reached: States = (0..bounds.len())
                .into_par_iter()
                .map(|j| if wanted(bounds[j]) { reach(j) } else { None })
                .collect();
            for (state, reached) in states.iter_mut().zip(reached) {
                *state = state.or(reached);
            }
            states.iter().flatten().map(|s| s.cost).fold(f64::INFINITY, f64::min)
        };
        if fill(&|bound| bound <= promising) > promising {
            fill(&|bound| bound > promising && bound.is_finite());
        }
        states
    }

    /// What a candidate costs in `here` when it stops `lift` mm short.
    fn own(&self, candidate: &Candidate, lift: f64, here: &Here) -> f64 {
        let layer = if here.counts { candidate.cost(lift, self.candidates.scale) } else { 0.0 };
        layer + COST_PER_POSITION
    }

    /// What the cheapest way before a place costs.
    fn least_before(here: &Here) -> f64 {
        let begin = if here.may_begin { 0.0 } else { f64::INFINITY };
        let cheapest = here.last.zip(here.order.first()).and_then(|(last, &i)| here.states[last][i].as_ref());
        cheapest.map_or(begin, |state| state.cost.min(begin))
    }

    /// Less than this no way through a tilt costs.
    fn bound(&self, candidates: &[Option<Candidate>], here: &Here) -> f64 {
        let Some(Some(cheapest)) = candidates.first() else { return f64::INFINITY };
        Self::least_before(here) + self.own(cheapest, 0.0, here)
    }

    /// The cheapest way to a tilt: to its cheapest candidate that the blades allow, or another where no axis before it is
    /// near enough to that one, or contact holds it back.
    fn reach(&self, tilt: usize, place: &Place, here: &Here) -> Option<State> {
        let before = Self::least_before(here);
        let mut first: Option<Leg> = None;
        let mut best: Option<State> = None;
        for candidate in place.tilts[tilt].iter().flatten() {
            // The others leave more; of free starts any will do.
            let is_done = |best: &State| match here.counts {
                true => best.cost <= before + self.own(candidate, 0.0, here),
                false => best.lift == 0.0,
            };
            if best.as_ref().is_some_and(is_done) {
                break;
            }
            let Some(candidate) = self.candidates.cleared(candidate, place) else { continue };
            let mut leg = self.leg(candidate, here);
            self.follow(&mut leg, here, &mut best);
            first.get_or_insert(leg);
        }
        // Where no axis can be had from the last ones, another row begins.
        if best.is_none()
            && here.counts
            && let Some(mut leg) = first
            && let (Some(last), Some(&cheapest)) = (here.last, here.order.first())
            && let Some(state) = &here.states[last][cheapest]
        {
            self.consider(&mut leg, here, (state.cost + COST_OF_NEW_ROW, Some((last, cheapest))), &mut best);
        }
        best
    }

    /// A candidate with what was cut near it.
    fn leg(&self, candidate: Candidate, here: &Here) -> Leg {
        let column = self.candidates.column(&candidate.station);
        let mut search = ContactSearch::default();
        search.among(&column, here.earlier.all().near(&column));
        Leg { candidate, column, search }
    }

    /// The cheapest way from the last axes, or from nowhere, if it is cheaper than `best`.
    fn follow(&self, leg: &mut Leg, here: &Here, best: &mut Option<State>) {
        let axis = leg.candidate.station.axis;
        if let Some(last) = here.last {
            for &i in &here.order {
                let Some(passed) = &here.states[last][i] else { break };
                if passed.candidate.station.axis.angle(&axis) <= self.max_axis_change {
                    self.consider(leg, here, (passed.cost, Some((last, i))), best);
                }
            }
        }
        if here.may_begin {
            self.consider(leg, here, (0.0, None), best);
        }
    }

    /// The way over `before`, which costs so much until there, if it is cheaper than `best`.
    fn consider(
        &self,
        leg: &mut Leg,
        here: &Here,
        (cost_before, before): (f64, Option<(usize, usize)>),
        best: &mut Option<State>,
    ) {
        let Leg { candidate, column, search } = leg;
        let affordable = match &best {
            None => f64::INFINITY,
            // Where the layer does not count a free start does, and of free starts the latest.
            Some(b) if !here.counts && b.lift > 0.0 => b.lift,
            Some(b) if !here.counts && cost_before + COST_PER_POSITION >= b.cost => return,
            Some(_) if !here.counts => 0.0,
            Some(b) => {
                candidate.affordable_lift(b.cost - cost_before - COST_PER_POSITION, self.candidates.scale)
            }
        };
        if affordable < 0.0 {
            return;
        }
        let mut passed = [*column; LOOK_BACK];
        let mut count = 0;
        let mut at = before;
        while let Some((k, j)) = at
            && let Some(state) = &here.states[k][j]
            && count < LOOK_BACK
        {
            passed[count] = state.column.lifted(state.lift);
            count += 1;
            at = state.before;
        }
        let passed = passed[..count].iter().rev().filter(|passed| column.may_meet(&passed.cutter));
        let depth = search.after(column, passed).depth(self.blank, affordable);
        let lift = if depth > 0.0 { depth + LIFT_MARGIN } else { 0.0 };
        let cost = cost_before + self.own(candidate, lift, here);
        let better = |b: &State| if here.counts { cost < b.cost } else { (lift, cost) < (b.lift, b.cost) };
        if best.as_ref().is_none_or(better) {
            *best = Some(State { candidate: *candidate, column: *column, cost, lift, before });
        }
    }

    /// The path that ends in the cheapest state of place `last`.
    fn traced(&self, places: &[PlaceAt], states: &[States], last: Option<usize>) -> Path {
        let cost = |&(k, j): &(usize, usize)| states[k][j].map_or(f64::INFINITY, |s| s.cost);
        let end = last
            .and_then(|k| (0..states[k].len()).map(|j| (k, j)).min_by(|a, b| cost(a).total_cmp(&cost(b))));
        let mut path = Path { cost: end.as_ref().map_or(0.0, cost), ..Path::default() };
        let mut at = end;
        while let Some((k, j)) = at
            && let Some(state) = &states[k][j]
        {
            let before = state.before.and_then(|(k, j)| states[k][j]).map(|s| s.candidate.station.axis);
            let held = places[k].1.as_ref().and_then(|place| self.held(place, state, before));
            path.steps.push((Station { held, ..state.candidate.station }, state.lift));
            at = state.before;
        }
        path.steps.reverse();
        path
    }

    /// What keeps a state from the cheapest candidate of its place.
    fn held(&self, place: &Place, state: &State, before: Option<Vector>) -> Option<Held> {
        let cost = |c: &Candidate| c.cost(0.0, self.candidates.scale);
        let cheapest =
            place.tilts.iter().filter_map(|tilt| tilt[0]).min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
        if state.lift == 0.0 && cost(&state.candidate) <= cost(&cheapest) + WORTH_TELLING {
            return None;
        }
        let turn = |before: Vector| before.angle(&cheapest.station.axis);
        Some(
            if self.candidates.cleared(&cheapest, place).is_none_or(|c| cost(&c) >= cost(&state.candidate)) {
                Held::Walls
            } else if before.is_some_and(|before| turn(before) > self.max_axis_change) {
                Held::AxisChange
            } else {
                Held::Contact
            },
        )
    }
}
