//! Lengths and time of a program.

use super::{ClProgram, Motion, RAPID_MM_PER_MIN};

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
}

impl Travel {
    /// Sums of all moves with a tool.
    pub fn of(program: &ClProgram) -> Self {
        let mut travel = Self::default();
        for pair in program.moves.windows(2) {
            let Some(tool) = pair[1].tool.filter(|_| pair[0].tool == pair[1].tool) else { continue };
            let length = (pair[1].tip - pair[0].tip).norm();
            match pair[1].motion {
                Motion::Rapid => {
                    travel.rapid += length;
                    travel.time += length / RAPID_MM_PER_MIN * 60.0;
                }
                Motion::Feed(feed) => {
                    travel.cut += length;
                    let known = program.tools.get(tool).and_then(|tool| tool.feed_mm_per_min);
                    travel.time += length / feed.or(known).unwrap_or(DEFAULT_FEED_MM_PER_MIN) * 60.0;
                }
            }
        }
        travel
    }
}
