//! The passes of a flank plan, in cutting order, with their times.

use crate::flank::region::Region;
use crate::flank::{FlankMove, FlankPlan, MoveKind};
use crate::geometry::{Point, Vector};
use crate::toolpath::{ClProgram, Travel};

/// Successive cutting moves of one layer and region.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankPass {
    /// Layer, 0 at the hub.
    pub layer: usize,
    /// Region of the channel.
    pub region: Region,
    /// Whether it follows a wall.
    pub along_wall: bool,
    /// Index of the move before its first one: the position where it begins.
    pub from: usize,
    /// Index after its last move.
    pub end: usize,
    /// Length, mm.
    pub length: f64,
    /// Time of its cutting moves, s.
    pub time: f64,
    /// Lowest and highest feed rate, mm/min.
    pub feeds: [f64; 2],
    /// Largest turn of the axis between its ends, rad.
    pub turn: f64,
}

/// The passes of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlankPasses {
    /// In cutting order.
    pub passes: Vec<FlankPass>,
    /// Time from the start of the program to the end of each move, s.
    pub clock: Vec<f64>,
    /// Indices of the first moves of each layer, in cutting order.
    pub layer_starts: Vec<usize>,
}

impl FlankPasses {
    /// The passes of `plan`. The plunges that open the stock come before them.
    pub fn from_plan(plan: &FlankPlan) -> Self {
        let opening = ClProgram::default().after_opening(plan.opening.as_ref());
        Self::of_moves(&plan.moves, clock_of(&plan.moves, Travel::from_program(&opening).time))
    }

    /// The passes of `moves`, with the time from the start of the program to the end of each, s.
    pub fn of_moves(moves: &[FlankMove], clock: Vec<f64>) -> Self {
        let mut found = Self::default();
        for (index, step) in moves.iter().enumerate() {
            let before = index.checked_sub(1).map(|before| &moves[before]);
            if before.is_none_or(|before| before.layer != step.layer) {
                found.layer_starts.push(index);
            }
            let length = before.map_or(0.0, |before| (step.tip - before.tip).norm());
            let ends = |index: usize| clock.get(index).copied().unwrap_or(0.0);
            let duration = ends(index) - index.checked_sub(1).map_or(0.0, ends);
            let Some(from) = index.checked_sub(1).filter(|_| step.kind == MoveKind::Cut) else { continue };
            let goes_on = |pass: &&mut FlankPass| {
                pass.end == index
                    && (pass.layer, pass.region, pass.along_wall)
                        == (step.layer, step.region, step.along_wall)
            };
            let known = found.passes.last_mut().filter(goes_on);
            let pass = match known {
                Some(pass) => pass,
                None => {
                    found.passes.push(FlankPass {
                        layer: step.layer,
                        region: step.region,
                        along_wall: step.along_wall,
                        from,
                        end: index,
                        length: 0.0,
                        time: 0.0,
                        feeds: [f64::INFINITY, 0.0],
                        turn: 0.0,
                    });
                    let last = found.passes.len() - 1;
                    &mut found.passes[last]
                }
            };
            pass.end = index + 1;
            pass.length += length;
            pass.time += duration;
            let [low, high] = pass.feeds;
            pass.feeds = [low.min(step.feed_mm_per_min), high.max(step.feed_mm_per_min)];
            pass.turn = pass.turn.max(moves[pass.from].axis.angle(&step.axis));
        }
        Self { clock, ..found }
    }

    /// Time after the first `count` moves, s.
    pub fn time_after(&self, count: usize) -> f64 {
        count.checked_sub(1).and_then(|last| self.clock.get(last)).copied().unwrap_or(0.0)
    }

    /// Index of the pass to which the last of the first `count` moves belongs, or else of the one before it;
    /// `None` before the first pass.
    pub fn pass_after(&self, count: usize) -> Option<usize> {
        // The pass begins with the move after `from`.
        self.passes.partition_point(|pass| pass.from + 1 < count).checked_sub(1)
    }
}

/// Time from the start of the program to the end of each of `moves`, which begin `start` (s) after it, s.
fn clock_of(moves: &[FlankMove], start: f64) -> Vec<f64> {
    let mut time = start;
    let ends = moves.iter().enumerate().map(|(index, step)| {
        let before = index.checked_sub(1).map(|before| &moves[before]);
        let length = before.map_or(0.0, |before| (step.tip - before.tip).norm());
        time += 60.0 * length / step.feed_mm_per_min.max(1e-6);
        time
    });
    ends.collect()
}

/// Middle of the moves of a pass, half of its extent, mm, and its axis there.
pub fn extent_of_pass(pass: &FlankPass, moves: &[FlankMove]) -> Option<(Point, f64, Vector)> {
    let moves = moves.get(pass.from..pass.end)?;
    let (first, last) = (moves.first()?.tip, moves.last()?.tip);
    let middle = first + 0.5 * (last - first);
    let reach = moves.iter().map(|step| (step.tip - middle).norm()).fold(1.0, f64::max);
    Some((middle, reach, moves[moves.len() / 2].axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(kind: MoveKind, x: f64, layer: usize, along_wall: bool) -> FlankMove {
        FlankMove {
            kind,
            tip: Point::new(x, 0.0, 0.0),
            axis: Vector::z(),
            feed_mm_per_min: 600.0,
            layer,
            region: Region::INLET,
            along_wall,
        }
    }

    #[test]
    fn cutting_moves_of_one_kind_are_a_pass() {
        use MoveKind::{Approach, Cut, Link, Rapid};
        let moves = [
            step(Rapid, 0.0, 1, false),
            step(Approach, 10.0, 1, false),
            step(Cut, 20.0, 1, false),
            step(Cut, 40.0, 1, false),
            step(Link, 45.0, 1, false),
            step(Cut, 55.0, 1, false),
            step(Cut, 65.0, 1, true),
            step(Rapid, 0.0, 0, false),
            step(Cut, 30.0, 0, false),
        ];
        let found = FlankPasses::of_moves(&moves, clock_of(&moves, 0.0));
        let ends: Vec<_> = found.passes.iter().map(|pass| (pass.from, pass.end, pass.length)).collect();
        assert_eq!(ends, [(1, 4, 30.0), (4, 6, 10.0), (5, 7, 10.0), (7, 9, 30.0)]);
        assert_eq!(found.layer_starts, [0, 7]);
        assert_eq!((found.time_after(0), found.time_after(4)), (0.0, 4.0), "600 mm/min");
        let passes: Vec<_> = (0..=9).map(|count| found.pass_after(count)).collect();
        let [none, first, second, third, last] = [None, Some(0), Some(1), Some(2), Some(3)];
        assert_eq!(passes, [none, none, none, first, first, first, second, third, third, last]);
        assert_eq!(found.passes[0].time, 3.0);
    }
}
