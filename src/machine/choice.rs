//! The rotary positions of a whole program: dynamic programming over the two solutions of each direction and
//! their whole turns within the limits.
//!
//! A stretch of moves with one direction of the tool is one stage. A step from stage to stage costs the time
//! in which the slower rotary axis turns, and in a link what it takes to leave the part where joint space
//! strays from the planned turn. At a pole the rotary axis is free; it keeps its value through it.

use std::ops::Range;

use super::fault::MotionFault;
use super::limits::LimitFault;
use super::model::{MachineTool, TurnLink};
use crate::geometry::{Point, Vector, wrap_angle};
use crate::monitor::Monitor;

/// Stray of the axis in a link above which it leaves the part before it turns, rad.
pub(super) const MAX_LINK_STRAY: f64 = 1.0 * std::f64::consts::PI / 180.0;
/// What leaving the part costs beside the turn, s.
const CLEAR_COST_S: f64 = 4.0;
/// What unwinding an axis costs beside that, s.
const REWIND_COST_S: f64 = 10.0;
/// What a stray under feed costs, s/rad: points have to be added, and the axis hurries.
const STRAY_COST: f64 = 100.0;
/// What no program may do costs this, s: turning back in the middle of a cut.
const FORBIDDEN_S: f64 = 1e7;
/// Preference for less travel among choices of equal time, s/rad.
const TRAVEL_COST: f64 = 1e-3;
/// Turns under feed that are wider than this go the other way round, rad.
const HALF_TURN: f64 = std::f64::consts::PI * (1.0 + 1e-9);

/// A stretch of moves with one direction of the tool, in program coordinates.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// Direction, tip → holder.
    pub axis: Vector,
    /// Its moves.
    pub moves: Range<usize>,
    /// Whether the move that turns the tool into this direction is one under feed.
    pub feed_in: bool,
    /// Length of its tool, mm.
    pub length: f64,
    /// Line of its first move.
    pub line: usize,
}

/// One choice of a stage.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    angles: [f64; 2],
    branch: usize,
    cost: f64,
    from: usize,
}

/// A stage: a stretch and its candidates.
struct Stage {
    stretch: usize,
    candidates: Vec<Candidate>,
}

/// The chosen positions.
pub(super) struct Choice {
    /// Rotary positions of each stretch, rad; endless axes count on.
    pub angles: Vec<[f64; 2]>,
    /// Number of times a limited axis turns back by more than half a turn.
    pub rewinds: usize,
}

/// Chooses the rotary positions of all `stretches`; `tips` are those of all moves. Between the two solutions
/// the axes may only change where the tool axis deviates by at most `axis_tolerance` (rad) from its planned
/// turn.
///
/// # Errors
/// When the machine does not reach a direction, or only beyond its limits, no sequence of positions connects
/// the stretches, or on a cancel.
pub(super) fn choose(
    machine: &MachineTool,
    stretches: &[Stretch],
    tips: &[Point],
    axis_tolerance: f64,
    monitor: &Monitor,
) -> Result<Choice, MotionFault> {
    let mut stages: Vec<Stage> = Vec::with_capacity(stretches.len());
    let mut found = Found::default();
    for (index, stretch) in stretches.iter().enumerate() {
        if index % 512 == 0 {
            monitor.check()?;
        }
        let (solutions, count) = machine.solve(&stretch.axis);
        if count > 0 && solutions[0].first.is_none() {
            found.check(machine, stretch, &[]);
            continue;
        }
        let candidates = found.candidates(machine, stretch, tips);
        stages.push(Stage { stretch: index, candidates });
    }
    if let Some(fault) = found.fault(machine) {
        return Err(fault);
    }
    run(machine, stretches, &mut stages, axis_tolerance, monitor)?;
    assemble(machine, stretches, &stages, axis_tolerance)
}

/// The first position without a candidate, and how many there are.
#[derive(Default)]
struct Found {
    first: Option<(usize, LimitFault)>,
    worst: Option<LimitFault>,
    count: usize,
    steepest_rad: f64,
}

impl Found {
    /// Notes what keeps the machine from `stretch`, if anything does.
    fn check(&mut self, machine: &MachineTool, stretch: &Stretch, tips: &[Point]) {
        if let Some(fault) = machine.limit_fault(&stretch.axis, tips, stretch.length) {
            self.count += 1;
            self.steepest_rad = self.steepest_rad.max(stretch.axis.angle(&Vector::z()));
            let is_worse = |worst: &LimitFault| fault.excess() > worst.excess();
            if fault.is_of_linear_axis() && self.worst.as_ref().is_none_or(is_worse) {
                self.worst = Some(fault.clone());
            }
            self.first.get_or_insert((stretch.line, fault));
        }
    }

    fn fault(self, machine: &MachineTool) -> Option<MotionFault> {
        let Self { first, worst, count, steepest_rad } = self;
        let (line, first) = first?;
        let reach_rad = machine.max_axis_tilt_rad();
        Some(MotionFault::OutOfLimits { line, first, worst, count, steepest_rad, reach_rad })
    }

    /// All positions of a stretch that the limits allow.
    fn candidates(&mut self, machine: &MachineTool, stretch: &Stretch, tips: &[Point]) -> Vec<Candidate> {
        let (solutions, count) = machine.solve(&stretch.axis);
        let tips = &tips[stretch.moves.clone()];
        let mut out = Vec::new();
        for (branch, solution) in solutions.iter().take(count).enumerate() {
            let first = solution.first.unwrap_or(0.0);
            let at = [first, solution.second];
            let is_beyond =
                |tip: &Point| machine.linear_axis_beyond(&machine.joints(tip, &at, stretch.length)).is_some();
            if tips.iter().any(is_beyond) {
                continue;
            }
            for first in machine.rotary[0].turns_within_limits(first) {
                for second in machine.rotary[1].turns_within_limits(solution.second) {
                    let angles = [first, second];
                    out.push(Candidate { angles, branch, cost: f64::INFINITY, from: usize::MAX });
                }
            }
        }
        if out.is_empty() {
            self.check(machine, stretch, tips);
        }
        out
    }
}

/// Turn of an axis from one position to another: an endless one goes the shorter way.
fn turn_of(machine: &MachineTool, axis: usize, from: f64, to: f64) -> f64 {
    if machine.rotary[axis].limits.is_none() { wrap_angle(to - from) } else { to - from }
}

/// Fills in the costs of all stages, forwards.
fn run(
    machine: &MachineTool,
    stretches: &[Stretch],
    stages: &mut [Stage],
    axis_tolerance: f64,
    monitor: &Monitor,
) -> Result<(), MotionFault> {
    let mut rest = stages.iter_mut();
    let Some(mut before) = rest.next() else { return Ok(()) };
    for candidate in &mut before.candidates {
        candidate.cost = TRAVEL_COST * (candidate.angles[0].abs() + candidate.angles[1].abs());
    }
    for (count, stage) in rest.enumerate() {
        if count % 256 == 0 {
            monitor.check()?;
        }
        let between = &stretches[before.stretch + 1..=stage.stretch];
        let feed = between.iter().all(|stretch| stretch.feed_in);
        let (from, to) = (&stretches[before.stretch].axis, &stretches[stage.stretch].axis);
        // The stray depends on the branches alone, as the nearest turn counts.
        let mut stray = [[None; 2]; 2];
        for candidate in &mut stage.candidates {
            for (index, earlier) in before.candidates.iter().enumerate() {
                let turn = [0, 1].map(|i| turn_of(machine, i, earlier.angles[i], candidate.angles[i]));
                let stray = stray[earlier.branch][candidate.branch].get_or_insert_with(|| {
                    let near = [0, 1].map(|i| earlier.angles[i] + wrap_angle(turn[i]));
                    machine.axis_stray((from, earlier.angles), (to, near))
                });
                // Points in between bring a stray within one solution down, but not one between the two.
                let lasting = earlier.branch != candidate.branch && *stray > axis_tolerance;
                let cost = earlier.cost + step_cost(machine, &turn, *stray, feed, lasting);
                if cost < candidate.cost {
                    (candidate.cost, candidate.from) = (cost, index);
                }
            }
        }
        before = stage;
    }
    Ok(())
}

/// Cost of turning by `turn` (rad) between two stages, s; `lasting`: no points in between mend its stray.
fn step_cost(machine: &MachineTool, turn: &[f64; 2], stray: f64, feed: bool, lasting: bool) -> f64 {
    let time = |i: usize| turn[i].abs() / machine.rotary[i].rapid_rad_per_s;
    let cost = time(0).max(time(1)) + TRAVEL_COST * (turn[0].abs() + turn[1].abs());
    let wide = turn.iter().any(|t| t.abs() > HALF_TURN);
    if feed {
        cost + STRAY_COST * stray + if wide || lasting { FORBIDDEN_S } else { 0.0 }
    } else if wide {
        cost + CLEAR_COST_S + REWIND_COST_S
    } else if lasting
        || stray > MAX_LINK_STRAY
        || (machine.links.turn == TurnLink::Clear && *turn != [0.0; 2])
    {
        cost + CLEAR_COST_S
    } else {
        cost
    }
}

/// Reads the way back, counts endless axes on, and holds the first axis at poles.
fn assemble(
    machine: &MachineTool,
    stretches: &[Stretch],
    stages: &[Stage],
    axis_tolerance: f64,
) -> Result<Choice, MotionFault> {
    let mut picked: Vec<Option<[f64; 2]>> = vec![None; stretches.len()];
    let last = stages.last().and_then(|stage| {
        let order = |a: &usize, b: &usize| stage.candidates[*a].cost.total_cmp(&stage.candidates[*b].cost);
        (0..stage.candidates.len()).min_by(order)
    });
    if let (Some(mut at), Some(end)) = (last, stages.last()) {
        let cost = end.candidates[at].cost;
        for stage in stages.iter().rev() {
            let candidate = stage.candidates[at];
            picked[stage.stretch] = Some(candidate.angles);
            at = candidate.from;
        }
        if cost >= FORBIDDEN_S {
            return Err(turning_back(machine, stretches, &picked, axis_tolerance));
        }
    }
    let mut angles = Vec::with_capacity(stretches.len());
    let mut rewinds = 0;
    let first_known = picked.iter().flatten().next().map_or(0.0, |a| a[0]);
    let mut before: Option<[f64; 2]> = None;
    for (stretch, picked) in stretches.iter().zip(&picked) {
        let held = before.map_or(first_known, |b| b[0]);
        let wanted = match picked {
            Some(angles) => *angles,
            None => {
                let second = machine.solve(&stretch.axis).0[0].second;
                let near = before.map_or(second, |b| b[1]);
                let order = |a: &f64, b: &f64| (a - near).abs().total_cmp(&(b - near).abs());
                [held, machine.rotary[1].turns_within_limits(second).min_by(order).unwrap_or(second)]
            }
        };
        let here = before.map_or(wanted, |b| [0, 1].map(|i| b[i] + turn_of(machine, i, b[i], wanted[i])));
        rewinds += usize::from(before.is_some_and(|b| (0..2).any(|i| (here[i] - b[i]).abs() > HALF_TURN)));
        angles.push(here);
        before = Some(here);
    }
    Ok(Choice { angles, rewinds })
}

/// The fault of a program that turns an axis back in the middle of a cut.
fn turning_back(
    machine: &MachineTool,
    stretches: &[Stretch],
    picked: &[Option<[f64; 2]>],
    axis_tolerance: f64,
) -> MotionFault {
    let mut before: Option<[f64; 2]> = None;
    let mut last_axis = Vector::z();
    for (stretch, angles) in stretches.iter().zip(picked) {
        let Some(here) = angles else { continue };
        let back = |b: &[f64; 2]| {
            let turn = [0, 1].map(|i| turn_of(machine, i, b[i], here[i]).abs());
            let near = [0, 1].map(|i| b[i] + wrap_angle(here[i] - b[i]));
            let stray = machine.axis_stray((&last_axis, *b), (&stretch.axis, near));
            turn.iter().any(|t| *t > HALF_TURN) || stray > axis_tolerance
        };
        if stretch.feed_in && before.as_ref().is_some_and(back) {
            return MotionFault::TurnsBack { line: stretch.line, letter: machine.rotary[0].letter };
        }
        (before, last_axis) = (Some(*here), stretch.axis);
    }
    MotionFault::TurnsBack { line: 0, letter: machine.rotary[0].letter }
}
