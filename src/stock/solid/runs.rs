//! Runs of short cuts that count as one move.
//!
//! Programs of curved passes have moves much shorter than the cutter, and what neighbouring ones sweep is
//! nearly the same. A run of cuts is one straight move as long as every pose in it stays within a tolerance
//! of that move.

use super::assembly::SolidTool;
use super::motion::SolidMove;

/// Largest number of moves in a run.
pub const MAX_RUN: usize = 64;

/// The cut that stands for the longest run at the beginning of `moves`, and the length of the run; 1 where
/// the first move stands for itself: rapids, moves along the axis, tight curves.
///
/// No point of the cutter is further than `tolerance` mm from its place in one of the two.
pub(super) fn next_run(moves: &[SolidMove], tools: &[SolidTool], tolerance: f64) -> (SolidMove, usize) {
    let first = moves[0];
    let height = tools.get(first.tool).map_or(0.0, |tool| tool.cutting_length);
    let mut best = (first, 1);
    if first.is_whole() {
        return best;
    }
    let mut count = 1;
    while count < MAX_RUN.min(moves.len()) {
        let next = &moves[count];
        if next.is_whole() || next.tool != first.tool || next.from != moves[count - 1].to {
            break;
        }
        count += 1;
        let merged = SolidMove { to: next.to, ..first };
        if merged.is_whole() || !stays_near(&merged, &moves[..count - 1], height, tolerance) {
            break;
        }
        best = (merged, count);
    }
    best
}

/// Whether the ends of all `moves` are within `tolerance` of poses of `merged`, one after the other, over a
/// cutter of `height` mm.
fn stays_near(merged: &SolidMove, moves: &[SolidMove], height: f64, tolerance: f64) -> bool {
    let travel = merged.to.tip - merged.from.tip;
    let squared = travel.norm_squared();
    let mut before = 0.0;
    moves.iter().all(|step| {
        let share = (step.to.tip - merged.from.tip).dot(&travel) / squared.max(1e-12);
        let is_later = (before..=1.0).contains(&share);
        before = share;
        let pose = merged.pose(share);
        let off = (step.to.tip - pose.tip).norm() + height * (step.to.axis - pose.axis).norm();
        is_later && off <= tolerance
    })
}
