//! A move of shank and holder, and the places along it that have to be looked at.

use super::link::AxisTurn;
use crate::geometry::{Point, Vector};
use crate::setup::AssemblySegment;

/// Largest number of samples along a move.
const MAX_SAMPLES: usize = 400;
/// Least way between two samples, mm.
const MIN_WAY: f64 = 0.1;

/// A straight move of a tool; its axis turns at a constant rate.
pub struct AssemblyMove {
    from: Point,
    travel: Vector,
    turn: AxisTurn,
    to: (Point, Vector),
    /// Upper bound of the way of any point of the tool, mm.
    pub way: f64,
}

impl AssemblyMove {
    /// The move of `segments` from one pose to another.
    pub fn new(segments: &[AssemblySegment], from: (Point, Vector), to: (Point, Vector)) -> Self {
        let (travel, turn) = (to.0 - from.0, AxisTurn::new(from.1, &to.1));
        // No point of the tool is faster than its tip, and a turn about that.
        let reach =
            segments.iter().map(|s| s.from + s.length + s.radii[0].max(s.radii[1])).fold(0.0, f64::max);
        Self { from: from.0, travel, way: travel.norm() + from.1.angle(&to.1) * reach, turn, to }
    }

    /// Tip and axis at a share of the move, 0…1.
    pub fn pose(&self, share: f64) -> (Point, Vector) {
        if share >= 1.0 { self.to } else { (self.from + self.travel * share, self.turn.at(share).0) }
    }

    /// Looks at poses of the move, its end included, by conservative advancement: a distance changes by no
    /// more than the fastest point of the tool travels, so that what is spare at one pose says how far the
    /// next may be. `look` says what is spare at a pose, mm; `spare` is what is known of the start, 0 or less
    /// where nothing is. Returns what is spare at the end.
    pub fn advance(&self, spare: f64, mut look: impl FnMut((Point, Vector)) -> f64) -> f64 {
        let mut spare = spare;
        // Where `spare` was found, and the next place to look at.
        let (mut share, mut next) = (0.0, 0.0);
        if self.way < 1e-9 {
            return if spare > 0.0 { spare } else { look(self.to) };
        }
        if spare > 0.0 {
            next = spare / self.way;
        }
        while next < 1.0 {
            spare = look(self.pose(next));
            share = next;
            next += (spare / self.way).max(1.0 / MAX_SAMPLES as f64).max(MIN_WAY / self.way);
        }
        let left = spare - (1.0 - share) * self.way;
        if left > 0.0 { left } else { look(self.to) }
    }
}
