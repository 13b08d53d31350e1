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
        let gap = |s: &SpanSection| Vector::new(s.gaps[end], 0.0, 0.0);
        let place = |s: &SpanSection| end_of(s, 0, end);
        let other = |s: &SpanSection| end_of(s, 1, end);
        let largest = |values: &dyn Fn(&SpanSection) -> Vector, parts: bool| {
            let values: Vec<Vector> = sections.iter().map(values).collect();
            let (k, by) = largest_irregularity(&values, parts)?;
            let middle = Point::from(0.5 * (place(&sections[k]) + place(&sections[k + 1])));
            Some(EdgeJump { is_gap: parts && by > TEAR * length, edge, size_mm: by, at: middle })
        };
        let jumps = [largest(&gap, true), largest(&place, false), largest(&other, false)];
        for jump in jumps.into_iter().flatten().filter(|jump| jump.size_mm > JUMP * length) {
            if found.is_none_or(|f| (jump.is_gap, jump.size_mm) > (f.is_gap, f.size_mm)) {
                found = Some(jump);
            }
        }
    }
    found
}

/// The step between neighbouring values that differs most from the mean of its neighbours (extrapolated at
/// the ends), and the difference: all of it with `whole`, else its part across the direction of that mean, as
/// places are not evenly spaced along an edge.
fn largest_irregularity(values: &[Vector], whole: bool) -> Option<(usize, f64)> {
    let steps: Vec<Vector> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let expected = |k: usize| match (k.checked_sub(1), steps.get(k + 1)) {
        (Some(before), Some(behind)) => Some(0.5 * (steps[before] + behind)),
        (None, Some(behind)) => steps.get(2).map(|further| 2.0 * behind - further),
        (Some(before), None) => Some(2.0 * steps[before] - steps[before.checked_sub(1)?]),
        (None, None) => None,
    };
    (0..steps.len())
        .filter_map(|k| {
            let expected = expected(k)?;
            let off = steps[k] - expected;
            let along = expected.try_normalize(1e-12).filter(|_| !whole);
            Some((k, (off - along.map_or_else(Vector::zeros, |e| e * e.dot(&off))).norm()))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_distinguished_from_a_curved_edge() {
        let curved: Vec<Vector> =
            (0..13).map(|k| Vector::new(0.1 * f64::from(k * k), f64::from(k), 0.0)).collect();
        let largest = |values: &[Vector]| largest_irregularity(values, false).expect("enough of them");
        assert!(largest(&curved).1 < 0.11);
        for from in 1..13 {
            let mut jumped = curved.clone();
            jumped[..from].iter_mut().for_each(|v| v.z += 5.0);
            let (k, by) = largest(&jumped);
            assert!(by > 4.8, "{from}: {by} at {k}");
        }
    }

    #[test]
    fn uneven_distances_along_an_edge_are_not_a_jump() {
        let uneven: Vec<Vector> =
            (0..13).map(|k| Vector::new(0.0, f64::from(k) + 0.4 * f64::from(k % 2), 0.0)).collect();
        assert!(largest_irregularity(&uneven, false).expect("enough of them").1 < 1e-9);
        assert!(largest_irregularity(&uneven, true).expect("enough of them").1 > 0.7);
    }
}
