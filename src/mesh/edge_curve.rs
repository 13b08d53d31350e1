//! The curve of a smooth surface over an edge of its triangles.

use crate::geometry::{Point, Vector};

/// Steps of regula falsi for the place where a quantity is 0.
const STEPS: usize = 4;
/// Share of its chord, squared, below which a tangent comes from a corner with an unreliable normal.
const SOUND: f64 = 0.5;

/// A cubic Hermite curve from end to end of an edge, tangential to the surface at both; the chord where the
/// tangents are not known.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeCurve {
    start: Point,
    chord: Vector,
    /// The tangents at both ends less the chord.
    turns: [Vector; 2],
}

impl EdgeCurve {
    /// The chord.
    pub fn straight([start, end]: [Point; 2]) -> Self {
        Self { start, chord: end - start, turns: [Vector::zeros(); 2] }
    }

    /// The curve with these tangents, as long as their share of the chord; the chord where one of them
    /// deviates far from it.
    pub fn from_tangents(ends: [Point; 2], tangents: [Vector; 2]) -> Self {
        let straight = Self::straight(ends);
        let least = SOUND * straight.chord.norm_squared();
        if tangents.iter().any(|tangent| tangent.norm_squared() <= least) {
            return straight;
        }
        Self { turns: tangents.map(|tangent| tangent - straight.chord), ..straight }
    }

    /// The curve that is perpendicular to these unit normals at its ends.
    pub fn from_normals(ends: [Point; 2], normals: &[Vector; 2]) -> Self {
        let chord = ends[1] - ends[0];
        Self::from_tangents(ends, normals.map(|normal| chord - normal * normal.dot(&chord)))
    }

    /// The point at the share `x` of the edge.
    pub fn at(&self, x: f64) -> Point {
        let (x2, x3) = (x * x, x * x * x);
        self.on_chord(x) + self.turns[0] * (x3 - 2.0 * x2 + x) + self.turns[1] * (x3 - x2)
    }

    /// The point of the chord at the share `x`.
    pub fn on_chord(&self, x: f64) -> Point {
        self.start + self.chord * x
    }

    /// The share of the edge at which a quantity is 0 that has values of different signs at its ends: regula
    /// falsi, as it is not linear along the edge.
    pub fn zero_of(&self, ends: [f64; 2], quantity: impl Fn(&Point) -> f64) -> f64 {
        let (mut low, mut high) = ((0.0, ends[0]), (1.0, ends[1]));
        let between = |low: (f64, f64), high: (f64, f64)| {
            let steepness = high.1 - low.1;
            let share = low.0 - low.1 * (high.0 - low.0) / steepness;
            if steepness.abs() > 1e-15 { share.clamp(0.0, 1.0) } else { 0.5 * (low.0 + high.0) }
        };
        let mut share = between(low, high);
        for _ in 0..STEPS {
            let here = quantity(&self.at(share));
            *if (here < 0.0) == (low.1 < 0.0) { &mut low } else { &mut high } = (share, here);
            if here == 0.0 || (high.1 - low.1).abs() < 1e-12 {
                break;
            }
            share = between(low, high);
        }
        share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_is_met_where_it_has_the_height() {
        // A twelfth of a circle of 10 mm, from 15° to 45°.
        let at = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (Point::new(10.0 * cos, 10.0 * sin, 0.0), Vector::new(cos, sin, 0.0))
        };
        let ((start, from), (end, to)) = (at(15.0), at(45.0));
        let curve = EdgeCurve::from_normals([start, end], &[from, to]);
        let height = |p: &Point| p.y - 5.0;
        let share = curve.zero_of([height(&start), height(&end)], height);
        let met = curve.at(share);
        assert!((met - at(30.0).0).norm() < 0.02, "{met}");
        assert!((curve.on_chord(share) - met).norm() > 0.3, "the arc is .34 mm over its chord");
        // A normal along the chord tells no tangent.
        let along = (end - start).normalize();
        let chord = EdgeCurve::from_normals([start, end], &[along, to]);
        assert_eq!(chord.at(0.5), chord.on_chord(0.5));
    }
}
