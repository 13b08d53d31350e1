//! Leading and trailing edge of a blade from section to section: where one of them jumps, triangles are missing at the
//! blade's border, which no hole tells.

use super::sides::Section;
use crate::geometry::{Point, Vector};

/// Jump of an edge, as share of the blade's length, from which on it is one: whole blades stay ten times below.
const JUMP: f64 = 1e-3;
/// As [`JUMP`], of the way from one side to the other, from which on no shape of a blade explains it.
const TEAR: f64 = 4e-3;

/// What an edge does between two sections.
#[derive(Clone, Copy, Debug)]
pub struct Jump {
    /// Whether the sides part there, as no shape of a blade has it.
    pub torn: bool,
    /// Name of the edge.
    pub edge: &'static str,
    /// How far it jumps or its sides part, mm.
    pub by: f64,
    /// Where that is.
    pub at: Point,
}

/// The largest jump of an edge of a blade, if there is one; what is torn first.
pub fn jump(sections: &[Section]) -> Option<Jump> {
    let end_of = |s: &Section, side: usize, end: usize| s.sides[side].point(end as f64).coords;
    let length = sections.iter().map(|s| (end_of(s, 0, 1) - end_of(s, 0, 0)).norm()).fold(0.0, f64::max);
    let mut found: Option<Jump> = None;
    for (end, edge) in [(0, "leading edge"), (1, "trailing edge")] {
        let gap = |s: &Section| Vector::new(s.gaps[end], 0.0, 0.0);
        let place = |s: &Section| end_of(s, 0, end);
        let other = |s: &Section| end_of(s, 1, end);
        let largest = |values: &dyn Fn(&Section) -> Vector, parts: bool| {
            let values: Vec<Vector> = sections.iter().map(values).collect();
            let (k, by) = uneven(&values)?;
            let middle = Point::from(0.5 * (place(&sections[k]) + place(&sections[k + 1])));
            Some(Jump { torn: parts && by > TEAR * length, edge, by, at: middle })
        };
        let jumps = [largest(&gap, true), largest(&place, false), largest(&other, false)];
        for jump in jumps.into_iter().flatten().filter(|jump| jump.by > JUMP * length) {
            if found.is_none_or(|f| (jump.torn, jump.by) > (f.torn, f.by)) {
                found = Some(jump);
            }
        }
    }
    found
}

/// The step between neighbouring values that fits least between the steps before and behind it, and by how much.
fn uneven(values: &[Vector]) -> Option<(usize, f64)> {
    let steps: Vec<Vector> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let expected = |k: usize| match (k.checked_sub(1), steps.get(k + 1)) {
        (Some(before), Some(behind)) => Some(0.5 * (steps[before] + behind)),
        (None, Some(behind)) => steps.get(2).map(|further| 2.0 * behind - further),
        (Some(before), None) => Some(2.0 * steps[before] - steps[before.checked_sub(1)?]),
        (None, None) => None,
    };
    (0..steps.len())
        .filter_map(|k| Some((k, (steps[k] - expected(k)?).norm())))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_told_from_a_curved_edge() {
        let curved: Vec<Vector> =
            (0..13).map(|k| Vector::new(0.1 * f64::from(k * k), f64::from(k), 0.0)).collect();
        assert!(uneven(&curved).expect("enough of them").1 < 0.11);
        for from in 1..13 {
            let mut jumped = curved.clone();
            jumped[..from].iter_mut().for_each(|v| v.x += 5.0);
            let (k, by) = uneven(&jumped).expect("enough of them");
            assert!(by > 4.8, "{from}: {by} at {k}");
        }
    }
}
