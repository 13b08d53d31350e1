//! Lengths and time of a program.

use super::{ClProgram, Motion, Move, RAPID_MM_PER_MIN};

/// Feed rate assumed for a cut without one, mm/min.
const DEFAULT_FEED_MM_PER_MIN: f64 = 300.0;

/// Lengths and time of the moves of a program, without those to and from a tool change.
#[derive(Clone, Copy, Debug, Default)]
pub struct Travel {
    /// Cutting length, mm.
    pub cut: f64,
    /// Rapid length, mm.
    pub rapid: f64,
    /// Estimated time, s.
    pub time: f64,
    /// Of it, the time under feed, s.
    pub feed_time: f64,
    /// How often a tool is loaded.
    pub tool_loads: usize,
}

impl Travel {
    /// Time from the start to the end of each move of `program`, s; moves between tools take none.
    pub fn clock(program: &ClProgram) -> Vec<f64> {
        let mut time = 0.0;
        let first = program.moves.first().map(|_| 0.0);
        let rest = program.moves.windows(2).map(|pair| {
            time += Self::of_move(program, pair).map_or(0.0, |travel| travel.time);
            time
        });
        first.into_iter().chain(rest).collect()
    }

    /// Sums of all moves with a tool.
    pub fn from_program(program: &ClProgram) -> Self {
        let mut travel = Self { tool_loads: program.tool_loads(), ..Self::default() };
        for of_move in program.moves.windows(2).filter_map(|pair| Self::of_move(program, pair)) {
            travel.rapid += of_move.rapid;
            travel.cut += of_move.cut;
            travel.time += of_move.time;
            travel.feed_time += of_move.feed_time;
        }
        travel
    }

    /// The second of two successive moves; `None` without a tool, or where the tool changes.
    fn of_move(program: &ClProgram, pair: &[Move]) -> Option<Self> {
        let tool = pair[1].tool.filter(|_| pair[0].tool == pair[1].tool)?;
        let length = (pair[1].tip - pair[0].tip).norm();
        Some(match pair[1].motion {
            Motion::Rapid => {
                let time = length / RAPID_MM_PER_MIN * 60.0;
                Self { rapid: length, time, ..Self::default() }
            }
            Motion::Feed(feed) => {
                let known = program.tools.get(tool).and_then(|tool| tool.feed_mm_per_min);
                let feed = feed.or(known).unwrap_or(DEFAULT_FEED_MM_PER_MIN);
                let time = length / feed * 60.0;
                Self { cut: length, time, feed_time: time, ..Self::default() }
            }
        })
    }
}
