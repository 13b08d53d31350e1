//! The moves of a flank program, with their times.

use crate::flank::region::Region;
use crate::geometry::{Point, Vector};

/// Kind of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MoveKind {
    /// Rapid: above the blank, or retracting along the tool axis.
    Rapid,
    /// At feed rate down to the start of a pass, or along it while still descending.
    Approach,
    /// Along a pass.
    Cut,
    /// At feed rate over the layer from one pass to the next.
    Link,
}

/// A straight move to a position, in the frame of the part.
#[derive(Clone, Copy, Debug)]
pub struct FlankMove {
    /// Kind of the move.
    pub kind: MoveKind,
    /// Tip of the tool at its end.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Feed rate, mm/min; for a rapid the speed that the time estimate assumes.
    pub feed_mm_per_min: f64,
    /// Its layer, 0 at the hub.
    pub layer: usize,
    /// Its region.
    pub region: Region,
    /// Whether it belongs to a pass along a wall.
    pub along_wall: bool,
}

/// The pass that a move of a program belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MoveOrigin {
    /// Index of the layer in cutting order.
    pub layer: usize,
    /// Index of the pass on that layer: the one that the move follows or leads to, or that a retract leaves.
    pub pass: usize,
    /// Index of the position of the pass at the end of the move.
    pub to: usize,
    /// Index of the position at its start, for a move along the pass.
    pub from: Option<usize>,
    /// Whether it leads to the end of another pass, from where the tool goes on over the layer.
    pub is_beside: bool,
}

/// Moves with their origins.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The moves.
    pub moves: Vec<FlankMove>,
    /// One origin per move.
    pub origins: Vec<MoveOrigin>,
}

/// Distance (mm) and turn (rad) below which two positions are the same in a program: it has six decimals.
const SAME_POSITION: f64 = 5e-6;
const SAME_AXIS: f64 = 1e-6;

/// Added to the safety distance of rapids, mm: where the tool bottom is near the blank at two points, the
/// nearer one may swap between two samples.
pub(in crate::flank) const RAPID_MARGIN: f64 = 0.05;

/// Lengths and times of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Times {
    /// Length along passes, mm.
    pub cut_length: f64,
    /// Length of links and approaches, mm.
    pub link_length: f64,
    /// Length of rapids, mm.
    pub rapid_length: f64,
    /// Time along passes, s.
    pub cut_time: f64,
    /// Time of links and approaches, s.
    pub link_time: f64,
    /// Time of rapids at 10 m/min, s.
    pub rapid_time: f64,
}

impl Times {
    /// Lengths and times of `moves` at their feed rates, without accelerations.
    pub fn from_moves(moves: &[FlankMove]) -> Self {
        let mut times = Self::default();
        for pair in moves.windows(2) {
            let length = (pair[1].tip - pair[0].tip).norm();
            let (lengths, time) = match pair[1].kind {
                MoveKind::Cut => (&mut times.cut_length, &mut times.cut_time),
                MoveKind::Approach | MoveKind::Link => (&mut times.link_length, &mut times.link_time),
                MoveKind::Rapid => (&mut times.rapid_length, &mut times.rapid_time),
            };
            *lengths += length;
            *time += 60.0 * length / pair[1].feed_mm_per_min;
        }
        times
    }

    /// Total time of the program, s.
    pub fn total(&self) -> f64 {
        self.cut_time + self.link_time + self.rapid_time
    }
}

/// Whether two positions of tip and axis are the same in a program.
pub(super) fn is_same((tip, axis): (Point, Vector), (other_tip, other_axis): (Point, Vector)) -> bool {
    (other_tip - tip).norm() < SAME_POSITION && other_axis.angle(&axis) < SAME_AXIS
}

/// Path length of the tip, mm.
pub(in crate::flank) fn path_length(positions: &[(Point, Vector)]) -> f64 {
    positions.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum()
}
