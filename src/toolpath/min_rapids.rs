//! Lower bound on the rapids of a program whose cuts may come in any order.

use super::{ClProgram, Motion, Move};
use crate::geometry::Point;

/// Cuts of one tool beyond which no bound is computed: its time grows with their square.
const MAX_CUTS: usize = 10_000;

/// A cut under feed: where the tip is before it, and after the rapid that follows it, the retract.
#[derive(Clone, Copy, Debug)]
struct FreeCut {
    from: Point,
    to: Point,
}

/// Length that the rapids of `program` have at least, in whatever order each tool does its cuts, mm: the
/// retracts, and the shortest tree of links between all cuts of a tool (Prim's algorithm), as no path through
/// them is shorter. `None` for programs of very many cuts.
pub fn min_rapid_length(program: &ClProgram) -> Option<f64> {
    let mut least = 0.0;
    for moves in program.moves.chunk_by(|a, b| a.tool == b.tool).filter(|moves| moves[0].tool.is_some()) {
        let (cuts, retracts) = cuts_of(moves);
        if cuts.len() > MAX_CUTS {
            return None;
        }
        least += retracts + shortest_tree(&cuts);
    }
    Some(least)
}

/// The cuts of `moves`, all with one tool, and the length of their retracts, mm.
fn cuts_of(moves: &[Move]) -> (Vec<FreeCut>, f64) {
    let is_cut = |of: &Move| matches!(of.motion, Motion::Feed(_));
    let (mut cuts, mut retracts) = (Vec::new(), 0.0);
    for (k, pair) in moves.windows(2).enumerate() {
        let (before, here) = (&pair[0], &pair[1]);
        if !is_cut(here) {
            continue;
        }
        let begins = k == 0 || !is_cut(before);
        if begins {
            cuts.push(FreeCut { from: before.tip, to: here.tip });
        }
        let Some(cut) = cuts.last_mut() else { continue };
        cut.to = here.tip;
        if let Some(retract) = moves.get(k + 2).filter(|next| !is_cut(next)) {
            retracts += (retract.tip - here.tip).norm();
            cut.to = retract.tip;
        }
    }
    (cuts, retracts)
}

/// Length of the shortest tree of links between `cuts`, mm.
fn shortest_tree(cuts: &[FreeCut]) -> f64 {
    let link = |a: &FreeCut, b: &FreeCut| (b.from - a.to).norm().min((a.from - b.to).norm());
    let mut away: Vec<(usize, f64)> = (1..cuts.len()).map(|k| (k, f64::INFINITY)).collect();
    let (mut last, mut length) = (0, 0.0);
    while !away.is_empty() {
        for (k, nearest) in &mut away {
            *nearest = nearest.min(link(&cuts[last], &cuts[*k]));
        }
        let next = (0..away.len()).min_by(|&a, &b| away[a].1.total_cmp(&away[b].1)).unwrap_or(0);
        let (k, nearest) = away.swap_remove(next);
        length += nearest;
        last = k;
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::toolpath::Travel;

    /// A program of plunges 10 mm deep at these places, each with a rapid up and one to the next.
    fn plunges(places: &[[f64; 2]]) -> ClProgram {
        let mut program = ClProgram { tools: vec![Default::default()], ..ClProgram::default() };
        let mut add = |[x, y]: [f64; 2], z: f64, motion: Motion| {
            let tip = Point::new(x, y, z);
            program.moves.push(Move { motion, tip, axis: Vector::z(), tool: Some(0), line: 0 });
        };
        for &place in places {
            add(place, 10.0, Motion::Rapid);
            add(place, 0.0, Motion::Feed(None));
            add(place, 10.0, Motion::Rapid);
        }
        program
    }

    #[test]
    fn no_order_has_shorter_rapids() {
        let places = [[0.0, 0.0], [30.0, 0.0], [0.0, 20.0], [30.0, 25.0], [15.0, 5.0]];
        let least = min_rapid_length(&plunges(&places)).expect("few cuts");
        let mut order = [0, 1, 2, 3, 4];
        let mut shortest = f64::INFINITY;
        // All orders, by Heap's algorithm.
        let mut counts = [0; 5];
        let mut k = 0;
        while k < 5 {
            let program = plunges(&order.map(|index| places[index]));
            assert!((min_rapid_length(&program).expect("few cuts") - least).abs() < 1e-9, "of any order");
            shortest = shortest.min(Travel::from_program(&program).rapid);
            while k < 5 && counts[k] >= k {
                counts[k] = 0;
                k += 1;
            }
            if k < 5 {
                order.swap(if k % 2 == 0 { 0 } else { counts[k] }, k);
                counts[k] += 1;
                k = 1.min(k);
            }
        }
        assert!(least <= shortest && least > 0.7 * shortest, "{least} of {shortest}");
    }

    #[test]
    fn plunges_in_a_line_need_the_way_along_it() {
        let line = plunges(&[[0.0, 0.0], [5.0, 0.0], [10.0, 0.0]]);
        assert_eq!(min_rapid_length(&line), Some(40.0), "three retracts and two links");
        assert_eq!(min_rapid_length(&line), Some(Travel::from_program(&line).rapid));
        assert_eq!(min_rapid_length(&ClProgram::default()), Some(0.0));
    }
}
