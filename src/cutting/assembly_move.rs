//! A move of shank and holder, and the places along it that have to be looked at.

use super::link::AxisTurn;
use crate::geometry::{Frustum, Point, Vector};
use crate::setup::{AssemblyPart, AssemblySegment};

/// Largest number of samples along a move.
const MAX_SAMPLES: usize = 400;
/// Least way between two samples, mm.
const MIN_WAY: f64 = 0.1;

/// Difference of two values below which the lesser is as good, mm.
const ENOUGH: f64 = 1e-3;

/// Way across the axis, and turn of it, up to which a move is one along the axis, mm and rad.
const MAX_ACROSS: f64 = 1e-4;
const MAX_AXIAL_TURN: f64 = 1e-9;
/// Length of the pieces of a cylinder that a move along the axis sweeps, mm.
const SWEPT_PIECE: f64 = 25.0;

/// What a segment sweeps over a move along its axis.
#[derive(Clone, Copy, Debug)]
pub struct SweptPiece {
    /// Shank or holder.
    pub part: AssemblyPart,
    /// The cylinder or cone.
    pub frustum: Frustum,
}

impl SweptPiece {
    /// It in short pieces, for measurements that compare a few circles of each.
    pub fn short_pieces(&self) -> impl Iterator<Item = Frustum> + use<> {
        let frustum = self.frustum;
        let is_cylinder = frustum.radii[0] == frustum.radii[1];
        let pieces = if is_cylinder { (frustum.length / SWEPT_PIECE).ceil().max(1.0) } else { 1.0 };
        let length = frustum.length / pieces;
        (0..pieces as usize).map(move |k| {
            let base = frustum.base + frustum.axis * (length * k as f64);
            Frustum { base, length, ..frustum }
        })
    }
}

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

    /// What `segments` sweep over a move along their axis: the distance of a piece is the least of all poses.
    /// `None` for other moves.
    pub fn swept(&self, segments: &[AssemblySegment]) -> Option<Vec<SweptPiece>> {
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
                if length > 0.0 {
                    let frustum = Frustum { base: tip + axis * from, axis, length, radii };
                    swept.push(SweptPiece { part: *part, frustum });
                }
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
        Some(swept)
    }

    /// Tip and axis at a share of the move, 0…1.
    pub fn pose(&self, share: f64) -> (Point, Vector) {
        if share >= 1.0 { self.to } else { (self.from + self.travel * share, self.turn.at(share).0) }
    }

    /// Looks at poses of the move, its end included, by conservative advancement: a distance changes by no
    /// more than the fastest point of the tool travels, so that what is spare at one pose says how far the
    /// next may be. `look` says what is spare at a pose, mm; `spare` is what is known of the start, 0 or less
    /// where nothing is. Ends at the first pose where less than `-tolerance` is spare.
    pub fn advance(
        &self,
        spare: f64,
        tolerance: f64,
        mut look: impl FnMut((Point, Vector)) -> f64,
    ) -> Advance {
        let mut spare = spare;
        // Where `spare` was found, and the next place to look at.
        let (mut share, mut next) = (0.0, 0.0);
        let end = |spare: f64| match spare {
            spare if spare < -tolerance => Advance::Blocked(1.0),
            spare => Advance::Free(spare),
        };
        if self.way < 1e-9 {
            return if spare > 0.0 { Advance::Free(spare) } else { end(look(self.to)) };
        }
        if spare > 0.0 {
            next = spare / self.way;
        }
        while next < 1.0 {
            spare = look(self.pose(next));
            if spare < -tolerance {
                return Advance::Blocked(next);
            }
            share = next;
            next += (spare / self.way).max(self.min_share());
        }
        let left = spare - (1.0 - share) * self.way;
        if left > 0.0 { Advance::Free(left) } else { end(look(self.to)) }
    }

    /// Least share of the move between two samples.
    pub fn min_share(&self) -> f64 {
        (1.0 / MAX_SAMPLES as f64).max(MIN_WAY / self.way)
    }

    /// The greatest value of `at` from share `from` of the move on, with its share, by Piyavskii's algorithm:
    /// `at` changes by no more than the fastest point of the tool travels. What is below `floor` is of no
    /// interest, no value exceeds `most`, and less than [`Self::min_share`] is not resolved.
    pub fn max_over(&self, from: f64, [floor, most]: [f64; 2], mut at: impl FnMut(f64) -> f64) -> (f64, f64) {
        // Tools mostly come nearest at the end of a move.
        let last = at(1.0);
        if from >= 1.0 || last >= most - ENOUGH {
            return (last, 1.0);
        }
        let first = at(from);
        let mut best = if first > last { (first, from) } else { (last, 1.0) };
        let bound = |[a, b]: [(f64, f64); 2]| 0.5 * (a.1 + b.1 + (b.0 - a.0) * self.way);
        let mut open = vec![[(from, first), (1.0, last)]];
        while best.0 < most - ENOUGH
            && let Some(next) = (0..open.len()).max_by(|&a, &b| bound(open[a]).total_cmp(&bound(open[b])))
        {
            let [low, high] = open.swap_remove(next);
            if bound([low, high]) <= best.0.max(floor) + ENOUGH {
                break;
            }
            let (width, least) = (high.0 - low.0, self.min_share());
            if width < 2.0 * least {
                continue;
            }
            // Where both bounds meet.
            let meet = 0.5 * (low.0 + high.0 + (high.1 - low.1) / self.way);
            let share = meet.clamp(low.0 + least, high.0 - least);
            let here = (share, at(share));
            if here.1 > best.0 {
                best = (here.1, share);
            }
            open.extend([[low, here], [here, high]]);
        }
        best
    }
}

/// Where a conservative advancement ended.
#[derive(Clone, Copy, Debug)]
pub enum Advance {
    /// At the end of the move, with this much spare, mm.
    Free(f64),
    /// At this share of the move, where too little is spare.
    Blocked(f64),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worst pose is that of a dense scan, found in few looks.
    #[test]
    fn the_greatest_value_over_a_move_is_that_of_a_dense_scan() {
        let axis = Vector::z();
        let step = AssemblyMove::new(&[], (Point::origin(), axis), (Point::new(60.0, 0.0, 0.0), axis));
        // They change by at most 1 mm a mm, as a clearance does: a valley, a rise to the end, a plateau.
        let values: [&dyn Fn(f64) -> f64; 3] =
            [&|x: f64| 3.0 - 0.9 * (x - 21.37).abs(), &|x: f64| 0.3 * x - 4.0, &|x: f64| {
                (8.0 * (x / 9.0).sin()).min(7.0 - 0.01 * x)
            }];
        for (number, value) in values.into_iter().enumerate() {
            let scanned = (0..=6000).map(|k| value(0.01 * f64::from(k))).fold(f64::NEG_INFINITY, f64::max);
            let mut looks = 0;
            let mut at = |share: f64| {
                looks += 1;
                value(60.0 * share)
            };
            let (found, share) = step.max_over(0.0, [0.0, f64::INFINITY], &mut at);
            assert!((scanned - 0.1..=scanned + 1e-9).contains(&found), "{number}: {found}, not {scanned}");
            assert!((value(60.0 * share) - found).abs() < 1e-12, "{number}");
            assert!(looks < 300, "{number}: {looks} looks");
            // Where the greatest is known, it ends there.
            let (known, _) = step.max_over(0.0, [0.0, scanned], value_of(value));
            assert!(known >= scanned - 0.1, "{number}: {known}");
        }
        let (below, _) = step.max_over(0.0, [0.0, f64::INFINITY], |share| -1.0 - share);
        assert_eq!(below, -1.0, "what is of no interest is not searched");
    }

    fn value_of(value: &dyn Fn(f64) -> f64) -> impl FnMut(f64) -> f64 {
        move |share| value(60.0 * share)
    }
}
