//! Check of leading and trailing edge across the span sections: a jump reveals triangles missing at the
//! blade's border, which are not inside a border loop and therefore not found as a hole.

use super::sides::SpanSection;
use crate::geometry::{Point, Vector};

/// Smallest jump of an edge that is reported, as a share of the blade's length: ten times that of intact
/// blades.
const JUMP: f64 = 1e-3;
/// Smallest jump of the gap between the sides, as a share of the blade's length, that is certainly an error.
const TEAR: f64 = 4e-3;

/// A discontinuity of an edge between two sections.
#[derive(Clone, Copy, Debug)]
pub struct EdgeJump {
    /// Whether the gap between the sides jumps, which is an error in the mesh.
    pub is_gap: bool,
    /// Name of the edge.
    pub edge: &'static str,
    /// Size of the jump, mm.
    pub size_mm: f64,
    /// Its position, in the frame of the part.
    pub at: Point,
}

/// The largest jump of an edge of a blade, if there is one; gaps between the sides take precedence.
pub fn find_jump(sections: &[SpanSection]) -> Option<EdgeJump> {
    let end_of = |s: &SpanSection, side: usize, end: usize| s.sides[side].point(end as f64).coords;
    let length = sections.iter().map(|s| (end_of(s, 0, 1) - end_of(s, 0, 0)).norm()).fold(0.0, f64::max);
    let mut found: Option<EdgeJump> = None;
    for (end, edge) in [(0, "leading edge"), (1, "trailing edge")] {
        let gaps: Vec<f64> = sections.iter().map(|s| s.gaps[end]).collect();
        let jump = |found: Option<(usize, f64)>, of_gap: bool| {
            let (k, size_mm) = found?;
            let at = Point::from(0.5 * (end_of(&sections[k], 0, end) + end_of(&sections[k + 1], 0, end)));
            Some(EdgeJump { is_gap: of_gap && size_mm > TEAR * length, edge, size_mm, at })
        };
        let turns = turns_of_sides(sections, end).map(|turn| jump(turn, false));
        let jumps = [jump(largest_step(&gaps), true), turns[0], turns[1]];
        for jump in jumps.into_iter().flatten().filter(|jump| jump.size_mm > JUMP * length) {
            if found.is_none_or(|f| (jump.is_gap, jump.size_mm) > (f.is_gap, f.size_mm)) {
                found = Some(jump);
            }
        }
    }
    found
}

/// How far the leading (0) or the trailing edge (1) jumps aside over the sections at most, mm.
pub fn largest_jump(sections: &[SpanSection], edge: usize) -> f64 {
    turns_of_sides(sections, edge).into_iter().flatten().map(|(_, off)| off).fold(0.0, f64::max)
}

/// See [`largest_turn`]: of the ends of both sides at the leading (0) or the trailing edge (1).
fn turns_of_sides(sections: &[SpanSection], edge: usize) -> [Option<(usize, f64)>; 2] {
    [0, 1].map(|side| {
        let places: Vec<Vector> = sections.iter().map(|s| s.sides[side].point(edge as f64).coords).collect();
        largest_turn(&places)
    })
}

/// The step between neighbouring values that differs most from the mean of its neighbours (extrapolated at
/// the ends), and the difference.
fn largest_step(values: &[f64]) -> Option<(usize, f64)> {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let expected = |k: usize| match (k.checked_sub(1), steps.get(k + 1)) {
        (Some(before), Some(behind)) => Some(0.5 * (steps[before] + behind)),
        (None, Some(behind)) => steps.get(2).map(|further| 2.0 * behind - further),
        (Some(before), None) => Some(2.0 * steps[before] - steps[before.checked_sub(1)?]),
        (None, None) => None,
    };
    let off = |k: usize| Some((k, (steps[k] - expected(k)?).abs()));
    (0..steps.len()).filter_map(off).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The step between neighbouring places whose direction differs most from that between its neighbours
/// (extrapolated at the ends), and how far it is aside of that. Places are not evenly spaced along an edge:
/// directions change with the way along it.
fn largest_turn(places: &[Vector]) -> Option<(usize, f64)> {
    let steps: Vec<Vector> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let lengths: Vec<f64> = steps.iter().map(|step| step.norm().max(1e-12)).collect();
    let direction = |k: usize| steps[k] / lengths[k];
    // The direction at the middle of step `k` on the line through those at the middles of two others.
    let expected = |k: usize| -> Option<Vector> {
        let last = steps.len().checked_sub(1).filter(|last| *last > 1)?;
        let (a, b) = if k == 0 {
            (1, 2)
        } else if k == last {
            (k - 1, k - 2)
        } else {
            (k - 1, k + 1)
        };
        let middle = |i: usize| lengths[..i].iter().sum::<f64>() + 0.5 * lengths[i];
        let share = (middle(k) - middle(a)) / (middle(b) - middle(a));
        (direction(a) + (direction(b) - direction(a)) * share).try_normalize(1e-12)
    };
    let off = |k: usize| {
        let expected = expected(k)?;
        Some((k, (steps[k] - expected * expected.dot(&steps[k])).norm()))
    };
    (0..steps.len()).filter_map(off).max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_distinguished_from_a_curved_edge() {
        let curved: Vec<Vector> =
            (0..13).map(|k| Vector::new(0.1 * f64::from(k * k), f64::from(k), 0.0)).collect();
        let largest = |places: &[Vector]| largest_turn(places).expect("enough of them");
        assert!(largest(&curved).1 < 0.11);
        for from in 1..13 {
            let mut jumped = curved.clone();
            jumped[..from].iter_mut().for_each(|v| v.z += 5.0);
            let (k, by) = largest(&jumped);
            assert!(by > 3.0, "{from}: {by} at {k}");
        }
    }

    #[test]
    fn uneven_distances_along_an_edge_are_not_a_jump() {
        let uneven = |k: i32| f64::from(k) + 0.4 * f64::from(k % 2);
        let straight: Vec<Vector> = (0..13).map(|k| Vector::new(0.0, uneven(k), 0.0)).collect();
        assert!(largest_turn(&straight).expect("enough of them").1 < 1e-9);
        let gaps: Vec<f64> = (0..13).map(uneven).collect();
        assert!(largest_step(&gaps).expect("enough of them").1 > 0.7);
        // The distances grow along an arc, as they do towards the tip of a trailing edge that is high there.
        let at = |k: i32| 0.05 * 1.25_f64.powi(k);
        let arc: Vec<Vector> =
            (0..13).map(|k| Vector::new(40.0 * at(k).cos(), 40.0 * at(k).sin(), 0.0)).collect();
        assert!(largest_turn(&arc).expect("enough of them").1 < 0.08);
    }
}
