//! The approach to the start of a pass: from above beyond the part, by a ramp where there is stock.

use crate::geometry::{Point, Vector};

/// Angle of ramps along a pass, rad; at most [`MAX_RAMP`] on a short one.
const RAMP: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Maximum length of the piece of a pass over which a ramp goes to and fro, mm.
const RAMP_LENGTH: f64 = 25.0;
/// Number of times that a ramp goes along it at that angle; on a shorter piece it is steeper.
const RAMP_TURNS: f64 = 12.0;
/// Maximum angle of a ramp, rad.
const MAX_RAMP: f64 = 2.0 * RAMP;

/// Height of stock above the start of a pass that a cutter takes without a ramp, mm: what the resolution of
/// heights may make of none.
const MIN_RAMP_HEIGHT: f64 = 0.05;
/// Distance above the stock from which a cutter goes slower at least, mm: narrow ribs between two looks.
const MIN_DISTANCE: f64 = 0.5;

/// Whether stock that stands `stands` mm above the start of a pass takes a ramp.
pub(super) fn needs_ramp(stands: f64) -> bool {
    stands > MIN_RAMP_HEIGHT
}

/// Length of a ramp from `height` mm above to and fro along `reach` mm of a pass, mm.
fn ramp_length(reach: f64, height: f64) -> f64 {
    (height / RAMP.tan()).min((RAMP_TURNS * reach).max(height / MAX_RAMP.tan()))
}

/// Which feed rate a move towards the start of a pass has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ApproachFeed {
    /// That through air, down to the stock.
    Down,
    /// That of the pass.
    Pass,
    /// That of ramps, down into stock.
    Ramp,
}

/// A move towards the start of a pass.
pub(super) struct ApproachStep {
    /// Tip and unit axis at its end.
    pub(super) position: (Point, Vector),
    /// Index of the pass position below it.
    pub(super) over: usize,
    /// Its feed rate.
    pub(super) feed: ApproachFeed,
}

/// The moves to the start of a pass from a point above it, `top` mm along its axis: down to `distance` mm
/// above the stock, which stands `stands` mm above the start, slower from there, and by a ramp into it.
pub(super) fn approach(
    positions: &[(Point, Vector)],
    top: f64,
    stands: f64,
    distance: f64,
) -> Vec<ApproachStep> {
    let (tip, axis) = positions[0];
    let mut steps = Vec::new();
    let slower_from = stands + distance.max(MIN_DISTANCE);
    if slower_from < top {
        let position = (tip + axis * slower_from, axis);
        steps.push(ApproachStep { position, over: 0, feed: ApproachFeed::Down });
    }
    if needs_ramp(stands) {
        let feeds = std::iter::once(ApproachFeed::Pass).chain(std::iter::repeat(ApproachFeed::Ramp));
        let ramp = ramp(positions, stands).into_iter().zip(feeds);
        steps.extend(ramp.map(|((position, over), feed)| ApproachStep { position, over, feed }));
    }
    // A ramp may end there at full depth.
    if steps.last().is_none_or(|last| last.position != positions[0]) {
        steps.push(ApproachStep { position: positions[0], over: 0, feed: ApproachFeed::Pass });
    }
    steps
}

/// Ramp down to and fro along the first piece of a pass, from `depth` mm above it: positions, each with the
/// index of the pass position below it.
fn ramp(positions: &[(Point, Vector)], depth: f64) -> Vec<((Point, Vector), usize)> {
    let mut along = vec![0.0];
    for pair in positions.windows(2) {
        let next = along[along.len() - 1] + (pair[1].0 - pair[0].0).norm();
        along.push(next);
        if next >= RAMP_LENGTH {
            break;
        }
    }
    let reach = along[along.len() - 1];
    if reach < 1e-6 {
        let (tip, axis) = positions[0];
        return vec![((tip + axis * depth, axis), 0)];
    }
    let total = ramp_length(reach, depth);
    let mut poses = vec![((positions[0].0 + positions[0].1 * depth, positions[0].1), 0)];
    let (mut at, mut gone, mut step) = (0usize, 0.0, 1isize);
    while gone < total {
        if at + 1 == along.len() {
            step = -1;
        } else if at == 0 {
            step = 1;
        }
        let next = (at as isize + step) as usize;
        gone += (along[next] - along[at]).abs();
        at = next;
        let (tip, axis) = positions[at];
        poses.push(((tip + axis * (depth * (1.0 - gone / total).max(0.0)), axis), at));
    }
    // Back to the position beside the start at full depth.
    poses.extend((1..at).rev().map(|k| (positions[k], k)));
    poses
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions along x, 0.1 mm apart, over `length` mm.
    fn straight(length: f64) -> Vec<(Point, Vector)> {
        let count = (10.0 * length).ceil().max(1.0);
        (0..=count as usize).map(|k| (Point::new(length * k as f64 / count, 0.0, 0.0), Vector::z())).collect()
    }

    #[test]
    fn a_ramp_descends_at_its_angle_along_a_pass_and_in_few_turns_on_a_short_one() {
        let rate = |poses: &[((Point, Vector), usize)]| {
            let steps = poses.windows(2).map(|pair| pair[1].0.0 - pair[0].0.0);
            let falls = steps.filter(|step| step.z < -1e-6).map(|step| -step.z / step.x.abs());
            falls.fold(0.0, f64::max)
        };
        let long = ramp(&straight(40.0), 3.0);
        assert!((rate(&long) - RAMP.tan()).abs() < 1e-9, "{}", rate(&long));
        for length in [0.3, 1.0, 3.0] {
            let positions = straight(length);
            let poses = ramp(&positions, 3.0);
            let rate = rate(&poses);
            assert!(rate > 1.01 * RAMP.tan() && rate < MAX_RAMP.tan() + 1e-9, "{rate} on {length}");
            // It ends at the full depth, ready for the pass.
            let deepest = poses.iter().map(|((tip, _), _)| tip.z).fold(f64::INFINITY, f64::min);
            assert!(deepest.abs() < 1e-9 && poses[0].0.0.z == 3.0);
        }
    }

    #[test]
    fn an_approach_ends_once_at_the_start_of_its_pass() {
        let mut ends_by_ramp = Vec::new();
        for eighths in 1..60 {
            // The steps have no rounding errors, so that a ramp may end just at the start.
            let at = |k: i32| (Point::new(f64::from(k) / 8.0, 0.0, 0.0), Vector::z());
            let positions: Vec<(Point, Vector)> = (0..=eighths).map(at).collect();
            for stands in [0.0, 1.0] {
                let steps = approach(&positions, 10.0, stands, 2.0);
                assert!(steps.last().is_some_and(|last| last.position == positions[0] && last.over == 0));
                let repeats = steps.windows(2).filter(|pair| pair[0].position == pair[1].position);
                assert_eq!(repeats.count(), 0, "{eighths}/8 mm");
                ends_by_ramp
                    .extend(steps.last().filter(|last| last.feed == ApproachFeed::Ramp).map(|_| eighths));
            }
        }
        assert!(!ends_by_ramp.is_empty());
    }

    #[test]
    fn an_approach_is_fast_to_a_distance_above_the_stock_and_ramps_only_into_it() {
        let positions = straight(40.0);
        let heights = |top: f64, stands: f64| -> Vec<(f64, ApproachFeed)> {
            let steps = approach(&positions, top, stands, 2.0);
            steps.iter().map(|step| (step.position.0.z, step.feed)).collect()
        };
        use ApproachFeed::{Down, Pass, Ramp};
        assert_eq!(heights(20.0, 0.0), [(2.0, Down), (0.0, Pass)]);
        assert_eq!(heights(20.0, 0.04), [(2.04, Down), (0.0, Pass)], "too little for a ramp");
        assert_eq!(heights(1.5, 0.0), [(0.0, Pass)], "from below the distance");
        let near = approach(&positions, 20.0, 0.0, 0.0);
        assert_eq!(near[0].position.0.z, 0.5, "never nearer than what ribs may stand unseen");
        let ramped = heights(20.0, 3.0);
        assert_eq!(ramped[..2], [(5.0, Down), (3.0, Pass)]);
        assert!(ramped.windows(2).all(|pair| pair[1].0 <= pair[0].0), "never up again");
        assert!(ramped[2..ramped.len() - 1].iter().all(|step| step.1 == Ramp));
    }
}
