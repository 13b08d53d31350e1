//! The cheapest path through the candidates of a row: dynamic programming over lead angles with a beam. A
//! stage is an s, a state a candidate reached at it, with a back-pointer to the previous state.

use rayon::prelude::*;

use super::axis_limits::AxisLimits;
use super::candidate::{CandidateMaker, CandidateStage, RowCandidate};
use super::row_path::{PathStep, RowPath};
use super::row_stages::{COST_OF_NEW_ROW, COST_PER_POSITION, RowStages, StageAt};
use crate::cutting::contact::{Columns, ContactSearch, PlungeColumn};
use crate::monitor::Cancelled;
use crate::part::Blank;
use crate::plunge::assembly::DropCause;
use crate::plunge::reasons::DropReason;
use crate::plunge::row::Station;

/// Maximum lift of a plunge as a share of its depth in the blank: what cuts less is not worth its time.
pub const MINIMAL_MAX_LIFT_SHARE: f64 = 0.8;
/// Number of previous positions of the own row that are checked for contact, besides all earlier rows.
const LOOK_BACK: usize = 4;
/// Beam: excess of a state's lower bound over the best one of its stage up to which it is expanded, in cutter
/// radii.
const BEAM_RADII: f64 = 0.15;
/// Lift from which on a finer grid of lead angles is tried, in cutter radii.
const COARSE_LIFT_RADII: f64 = 0.3;
/// Maximum number of parts into which the steps of the grid are divided.
const MAX_FINENESS: usize = 4;
/// Share of its cost that a path must save: by a finer grid for a still finer one to be tried, by a crossing
/// for this to be cut.
pub(super) const MIN_SAVED_SHARE: f64 = 0.02;
/// Excess over the lower bound that is acceptable, as a share of it. A stage counts with at most
/// [`CandidateMaker::scale`]: floor out of the reach of the row adds much to the bound and says nothing about
/// the path.
const ACCEPTED_EXCESS: f64 = 0.2;
/// Margin added to lifts found with the few lines of the search, mm.
pub(super) const SEARCH_LIFT_MARGIN_MM: f64 = 0.01;

/// A state: a candidate with the cheapest path to it.
#[derive(Clone, Copy, Debug)]
struct PathState {
    candidate: RowCandidate,
    column: PlungeColumn,
    /// Cost of the path up to here, mm.
    cost: f64,
    /// How far the plunge stops short, mm.
    lift: f64,
    /// Whether the plunge stops so short that it is left out.
    is_left_out: bool,
    /// Back-pointer: stage and lead angle of the previous position.
    before: Option<(usize, usize)>,
}

/// States of one stage, by lead angle.
type StageStates = Vec<Option<PathState>>;

/// Searches one row.
pub struct PathSearch<'a> {
    /// Makes the candidates.
    pub candidates: CandidateMaker<'a>,
    /// The blank.
    pub blank: &'a Blank,
    /// Largest angle between neighbouring axes, rad.
    pub max_axis_change_rad: f64,
    /// Whether a plunge that stops so short that it will be left out counts as removing nothing. Strictly it
    /// removes nothing, but the search does not know the positions that the row gets between its stages,
    /// which may remove the same stock; so the first search assumes that it does.
    pub is_strict: bool,
    /// Whether a finer grid of lead angles is tried where plunges have to stop short.
    pub refines: bool,
}

/// What all candidates of a stage share.
struct StageContext<'h> {
    /// States of the previous stages.
    states: &'h [StageStates],
    /// The last stage that has states, and these in order of cost, the cheapest first.
    last: Option<usize>,
    order: Vec<usize>,
    /// Whether a row may begin at this stage.
    may_begin: bool,
    /// Whether the layer left at this stage counts.
    counts: bool,
    /// Plunges of earlier rows.
    earlier: &'h Columns,
    /// Every how many lead angles of the stages belong to the grid.
    stride: usize,
    /// Cost that a path must stay below up to this stage, mm.
    limit: f64,
}

/// A candidate that clears the blades, prepared for transitions from several previous states.
struct Transition {
    candidate: RowCandidate,
    column: PlungeColumn,
    /// Contact with the plunges of earlier rows.
    search: ContactSearch,
}

/// Indices of states, the cheapest first.
fn by_cost(states: &StageStates) -> Vec<usize> {
    let cost = |i: usize| states[i].map_or(f64::INFINITY, |s| s.cost);
    let mut order: Vec<usize> = (0..states.len()).collect();
    order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)));
    order
}

impl PathSearch<'_> {
    /// The cheapest path along `s` (in cutting order) after the `earlier` plunges. The path may begin
    /// anywhere up to s = `start`; a layer left before that is free. Stages are inserted where the axes turn
    /// too much from one to the next. Where a plunge has to stop short, the grid of lead angles is refined if
    /// it is coarse for the cutter.
    ///
    /// `stages` keeps the stages for further searches of the same row along the same `s`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn path(
        &self,
        s: &[f64],
        start: f64,
        earlier: &Columns,
        stages: &mut RowStages,
    ) -> Result<RowPath, Cancelled> {
        Ok(self.path_below(s, start, earlier, stages, f64::INFINITY)?.unwrap_or_default())
    }

    /// As [`Self::path`]; `None` where every path costs `limit` mm or more.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn path_below(
        &self,
        s: &[f64],
        start: f64,
        earlier: &Columns,
        stages: &mut RowStages,
        limit: f64,
    ) -> Result<Option<RowPath>, Cancelled> {
        let radius = self.candidates.maker.tool.radius();
        let Some(mut best) = self.path_on_grid(s, start, earlier, stages, limit)? else { return Ok(None) };
        let mut finer = PathSearch { candidates: self.candidates.clone(), ..*self };
        while self.refines
            && finer.candidates.fineness < MAX_FINENESS
            && best.highest_lift() > COARSE_LIFT_RADII * radius
            && finer.candidates.is_coarse(s)
            && (finer.candidates.fineness > self.candidates.fineness || stages.tries_finer())
        {
            finer.candidates.fineness *= 2;
            let path = match finer.path_on_grid(s, start, earlier, stages, best.cost) {
                // When stopped, the best path so far is the result.
                Err(_) if self.candidates.maker.monitor.is_stopped() => break,
                path => path?,
            };
            let path = path.filter(|path| path.cost < best.cost);
            let gained = path.as_ref().map_or(0.0, |path| best.cost - path.cost);
            best = path.unwrap_or(best);
            if gained < MIN_SAVED_SHARE * best.cost {
                stages.vain += 1;
                break;
            }
            stages.vain = 0;
        }
        Ok(Some(best))
    }

    /// [`Self::path`] with the current grid.
    fn path_on_grid(
        &self,
        s: &[f64],
        start: f64,
        earlier: &Columns,
        stages: &mut RowStages,
        limit: f64,
    ) -> Result<Option<RowPath>, Cancelled> {
        let monitor = self.candidates.maker.monitor;
        let inward = self.candidates.maker.direction_sign;
        let scale = self.candidates.scale;
        self.make_stages(s, stages);
        let stride = stages.fineness / self.candidates.fineness;
        let places = &stages.places;
        // A layer left before the start is free.
        let counts = |s: f64| (start - s) * inward >= -1e-9;
        let step = if let [first, second, ..] = s { (second - first).abs() } else { f64::INFINITY };
        // Stages between others count by their share of a step.
        let share = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(places.len() - 1));
            0.5 * (places[after].0 - places[before].0).abs() / step
        };
        let cheapest: Vec<Option<f64>> = places
            .iter()
            .map(|(_, place)| {
                let place = place.as_ref()?;
                Some(place.candidate(place.cheapest(scale, stride)?)?.cost(0.0, scale))
            })
            .collect();
        // Lower bound on the cost of the stages from the end to the current one.
        let least = |k: usize| match cheapest[k] {
            Some(cheapest) if counts(places[k].0) => cheapest * share(k).min(1.0),
            _ => 0.0,
        };
        let min_cost: f64 = (0..places.len()).map(least).sum();
        let mut to_come = min_cost;
        let mut states: Vec<StageStates> = Vec::with_capacity(places.len());
        let mut last: Option<usize> = None;
        for (k, (s, place)) in places.iter().enumerate() {
            monitor.check()?;
            to_come -= least(k);
            // Signed distance in s before the start, in cutting direction.
            let ahead = (start - s) * inward;
            let Some(place) = place else {
                states.push(StageStates::new());
                continue;
            };
            let here = StageContext {
                states: &states,
                last,
                order: last.map_or_else(Vec::new, |last| by_cost(&states[last])),
                may_begin: ahead <= 1e-9 || last.is_none(),
                counts: ahead >= -1e-9,
                earlier,
                stride,
                limit: limit - to_come,
            };
            let reached = self.stage_states(place, &here);
            if reached.iter().any(Option::is_some) {
                last = Some(k);
            } else if here.counts && limit.is_finite() && self.is_reachable(place, stride) {
                return Ok(None);
            }
            states.push(reached);
        }
        let mut path = self.trace_back(places, &states, last, (counts, stride));
        let uncut_costs = places.iter().filter_map(|(_, place)| Some(self.uncut_cost(place.as_ref()?)));
        let (count, sum) = uncut_costs.fold((0.0, 0.0), |(count, sum), cost| (count + 1.0, sum + cost));
        let mean_uncut_cost = sum / f64::max(count, 1.0);
        for (k, (s, place)) in places.iter().enumerate().filter(|(_, (s, _))| counts(*s)) {
            if let Some(cheapest) = cheapest[k] {
                let excess = ACCEPTED_EXCESS * cheapest.min(scale);
                path.acceptable_cost += cheapest + excess + COST_PER_POSITION;
            }
            if states[k].iter().any(Option::is_some) {
                continue;
            }
            let (cost, why) = match place {
                None => (mean_uncut_cost, DropReason::Blades.into()),
                Some(place) => (self.uncut_cost(place), self.why_unreached(place, stride)),
            };
            path.cost += cost * share(k);
            path.missing_cost += cost * share(k);
            path.missing.push((*s, why));
        }
        path.min_cost = min_cost;
        path.missing.sort_by(|(a, _), (b, _)| (a * inward).total_cmp(&(b * inward)));
        Ok((path.cost < limit).then_some(path))
    }

    /// Cost of a stage that no position of the row cuts, mm; 0 without candidates.
    fn uncut_cost(&self, place: &CandidateStage) -> f64 {
        let first = place.leads(1).flatten().flatten().next();
        first.map_or(0.0, |candidate| candidate.uncut_cost(self.candidates.scale))
    }

    /// Whether some candidate of a stage clears the blades and is long enough.
    fn is_reachable(&self, place: &CandidateStage, stride: usize) -> bool {
        place.indices(stride).any(|index| self.candidates.is_cleared_long_enough(place, index))
    }

    /// Why no candidate of a stage is on a path.
    fn why_unreached(&self, place: &CandidateStage, stride: usize) -> DropCause {
        if self.is_reachable(place, stride) {
            return DropReason::Contact.into();
        }
        let cleared = place.indices(stride).filter_map(|index| self.candidates.cleared(place, index));
        let cleared: Vec<RowCandidate> = cleared.collect();
        if cleared.is_empty() {
            let is_beyond = self.candidates.machine_forbids_below(f64::INFINITY, place, stride);
            return if is_beyond { DropReason::Machine } else { DropReason::Blades }.into();
        }
        self.candidates.why_too_short(cleared.iter().map(|c| &c.station))
    }

    /// States of a stage. Lead angles whose lower bound is outside the beam are expanded only if the best
    /// state inside it costs more than the beam allows, because of lifts or blades.
    fn stage_states(&self, place: &CandidateStage, here: &StageContext) -> StageStates {
        let bounds: Vec<f64> = place.leads(here.stride).map(|lead| self.lower_bound(lead, here)).collect();
        let beam = BEAM_RADII * self.candidates.maker.tool.radius();
        let promising = bounds.iter().copied().fold(f64::INFINITY, f64::min) + beam;
        let reach = |j: usize| self.cheapest_state(j * here.stride, place, here);
        let mut states: StageStates = vec![None; bounds.len()];
        let mut fill = |wanted: &(dyn Fn(f64) -> bool + Sync)| {
            let reached: StageStates = (0..bounds.len())
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

    /// Cost of a candidate alone when it stops `lift` mm short.
    fn own_cost(&self, candidate: &RowCandidate, lift: f64, here: &StageContext) -> f64 {
        let layer = if here.counts { candidate.cost(lift, self.candidates.scale) } else { 0.0 };
        layer + COST_PER_POSITION
    }

    /// Cost of the cheapest path to the previous stage.
    fn min_cost_before(here: &StageContext) -> f64 {
        let begin = if here.may_begin { 0.0 } else { f64::INFINITY };
        let cheapest = here.last.zip(here.order.first()).and_then(|(last, &i)| here.states[last][i].as_ref());
        cheapest.map_or(begin, |state| state.cost.min(begin))
    }

    /// Lower bound on the cost of a path through this lead angle.
    fn lower_bound(&self, candidates: &[Option<RowCandidate>], here: &StageContext) -> f64 {
        let Some(Some(cheapest)) = candidates.first() else { return f64::INFINITY };
        Self::min_cost_before(here) + self.own_cost(cheapest, 0.0, here)
    }

    /// The cheapest path to a lead angle: usually to its cheapest candidate that clears the blades, or to
    /// another one where the axis change or contact prevents that.
    fn cheapest_state(&self, lead: usize, place: &CandidateStage, here: &StageContext) -> Option<PathState> {
        let before = Self::min_cost_before(here);
        let mut first: Option<Transition> = None;
        let mut best: Option<PathState> = None;
        for (tilt, candidate) in place.lead(lead).iter().enumerate() {
            let Some(candidate) = candidate else { continue };
            // The other candidates cost more; before the start any state without lift is as good.
            let is_done = |best: &PathState| match here.counts {
                true => best.cost <= before + self.own_cost(candidate, 0.0, here),
                false => best.lift == 0.0,
            };
            if best.as_ref().is_some_and(is_done)
                || here.counts && before + self.own_cost(candidate, 0.0, here) >= here.limit
            {
                break;
            }
            if !self.candidates.is_cleared_long_enough(place, (lead, tilt)) {
                continue;
            }
            let Some(candidate) = self.candidates.cleared(place, (lead, tilt)) else { continue };
            let column = self.candidates.cleared_column(place, (lead, tilt), &candidate);
            let mut transition = Self::transition(candidate, column, here);
            self.extend_paths(&mut transition, here, &mut best);
            first.get_or_insert(transition);
        }
        // Where the axis change allows no transition, a new row begins.
        if best.is_none()
            && here.counts
            && let Some(mut transition) = first
            && let (Some(last), Some(&cheapest)) = (here.last, here.order.first())
            && let Some(state) = &here.states[last][cheapest]
        {
            self.consider_transition(
                &mut transition,
                here,
                (state.cost + COST_OF_NEW_ROW, Some((last, cheapest))),
                &mut best,
            );
        }
        best
    }

    /// A candidate with the earlier plunges near it.
    fn transition(candidate: RowCandidate, column: PlungeColumn, here: &StageContext) -> Transition {
        let mut search = ContactSearch::default();
        search.among(&column, here.earlier.all().near(&column));
        Transition { candidate, column, search }
    }

    /// Replaces `best` by a cheaper transition from the previous states or, where a row may begin, from none.
    fn extend_paths(&self, transition: &mut Transition, here: &StageContext, best: &mut Option<PathState>) {
        let axis = transition.candidate.station.axis;
        if let Some(last) = here.last {
            for &i in &here.order {
                let Some(passed) = &here.states[last][i] else { break };
                if passed.candidate.station.axis.angle(&axis) <= self.max_axis_change_rad {
                    self.consider_transition(transition, here, (passed.cost, Some((last, i))), best);
                }
            }
        }
        if here.may_begin {
            self.consider_transition(transition, here, (0.0, None), best);
        }
    }

    /// Replaces `best` by the transition from `before`, whose path costs `cost_before`, if that is cheaper.
    fn consider_transition(
        &self,
        transition: &mut Transition,
        here: &StageContext,
        (cost_before, before): (f64, Option<(usize, usize)>),
        best: &mut Option<PathState>,
    ) {
        let Transition { candidate, column, search } = transition;
        let affordable_below = |cost: f64| {
            candidate.affordable_lift(cost - cost_before - COST_PER_POSITION, self.candidates.scale)
        };
        let affordable = match &best {
            None if here.counts && here.limit.is_finite() => affordable_below(here.limit),
            None => f64::INFINITY,
            // Where the layer is free, prefer the smallest lift, then the latest start.
            Some(b) if !here.counts && b.lift > 0.0 => b.lift,
            Some(b) if !here.counts && cost_before + COST_PER_POSITION >= b.cost => return,
            Some(_) if !here.counts => 0.0,
            Some(b) => affordable_below(b.cost),
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
            if !(self.is_strict && state.is_left_out) {
                passed[count] = state.column.lifted(state.lift);
                count += 1;
            }
            at = state.before;
        }
        let passed = passed[..count].iter().rev().filter(|passed| column.may_meet(&passed.cutter));
        let depth = search.after(column, passed).depth(self.blank, affordable);
        let lift = if depth > 0.0 { depth + SEARCH_LIFT_MARGIN_MM } else { 0.0 };
        let is_left_out = lift > 0.0 && lift >= MINIMAL_MAX_LIFT_SHARE * column.top;
        let own = match self.is_strict && is_left_out && here.counts {
            true => candidate.uncut_cost(self.candidates.scale) + COST_PER_POSITION,
            false => self.own_cost(candidate, lift, here),
        };
        let cost = cost_before + own;
        if here.counts && cost >= here.limit {
            return;
        }
        let better =
            |b: &PathState| if here.counts { cost < b.cost } else { (lift, cost) < (b.lift, b.cost) };
        if best.as_ref().is_none_or(better) {
            *best =
                Some(PathState { candidate: *candidate, column: *column, cost, lift, is_left_out, before });
        }
    }

    /// Follows the back-pointers from the cheapest state of stage `last`.
    /// Stages whose s does not count are before the start of the row.
    fn trace_back(
        &self,
        places: &[StageAt],
        states: &[StageStates],
        last: Option<usize>,
        (counts, stride): (impl Fn(f64) -> bool, usize),
    ) -> RowPath {
        let cost = |&(k, j): &(usize, usize)| states[k][j].map_or(f64::INFINITY, |s| s.cost);
        let end = last
            .and_then(|k| (0..states[k].len()).map(|j| (k, j)).min_by(|a, b| cost(a).total_cmp(&cost(b))));
        let mut path = RowPath { cost: end.as_ref().map_or(0.0, cost), ..RowPath::default() };
        let mut at = end;
        while let Some((k, j)) = at
            && let Some(state) = &states[k][j]
        {
            let before = state.before.and_then(|(k, j)| states[k][j]).map(|s| s.candidate.station.axis);
            let held = places[k].1.as_ref().and_then(|place| {
                let limits =
                    AxisLimits { candidates: &self.candidates, max_turn_rad: self.max_axis_change_rad };
                limits.what_limits(place, (&state.candidate, state.lift), before, stride)
            });
            let station = Station { limited_by: held, ..state.candidate.station };
            let (s, counts) = (station.ends.s_hub, counts(station.ends.s_hub));
            let PathState { candidate, lift, .. } = *state;
            match self.is_strict && state.is_left_out {
                true if counts => {
                    path.missing.push((s, DropReason::Contact.into()));
                    path.missing_cost += candidate.uncut_cost(self.candidates.scale);
                }
                true => {}
                false => path.steps.push(PathStep { station, lift, candidate, counts }),
            }
            at = state.before;
        }
        path.steps.reverse();
        path
    }
}
