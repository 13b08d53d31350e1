//! A move of shank and holder, and the places along it that have to be looked at.

use super::link::AxisTurn;
use crate::geometry::{Frustum, Point, Vector};
use crate::setup::{AssemblyPart, AssemblySegment};

/// Largest number of samples along a move.
const MAX_SAMPLES: usize = 400;
/// Least way between two samples, mm.
const MIN_WAY: f64 = 0.1;

/// Way across the axis, and turn of it, up to which a move is one along the axis, mm and rad.
const MAX_ACROSS: f64 = 1e-4;
const MAX_AXIAL_TURN: f64 = 1e-9;
/// Length of the pieces of what a move along the axis sweeps, mm.
const SWEPT_PIECE: f64 = 25.0;

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

    /// What `segments` sweep over a move along their axis, in pieces: the distance of a piece is the least of
    /// all poses. `None` for other moves.
    pub fn swept(&self, segments: &[AssemblySegment]) -> Option<Vec<(AssemblyPart, Frustum)>> {
        let axis = self.to.1;
        let along = self.travel.dot(&axis);
        let across = (self.travel - axis * along).norm();
        let turn = (self.turn.at(0.0).0 - axis).norm();
        if across > MAX_ACROSS || turn > MAX_AXIAL_TURN {
            return None;
        }
        let (tip, way) = (self.from + axis * along.min(0.0), along.abs());
        let mut swept = Vec::with_capacity(2 * segments.len());
        for AssemblySegment { part, from, length, radii } in segments {
            let mut add = |from: f64, length: f64, radii: [f64; 2]| {
                let pieces = if radii[0] == radii[1] { (length / SWEPT_PIECE).ceil().max(1.0) } else { 1.0 };
                swept.extend((0..pieces as usize).map(|k| {
                    let base = tip + axis * (from + length * k as f64 / pieces);
                    (*part, Frustum { base, axis, length: length / pieces, radii })
                }));
            };
            let [lower, upper] = *radii;
            if lower == upper {
                add(*from, length + way, *radii);
            } else if lower < upper {
                // Where it widens its lowest place, and above it what its upper end passes.
                add(*from, *length, *radii);
                add(from + length, way, [upper; 2]);
            } else {
                add(*from, way, [lower; 2]);
                add(from + way, *length, *radii);
            }
        }
        Some(swept.into_iter().filter(|(_, frustum)| frustum.length > 0.0).collect())
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
