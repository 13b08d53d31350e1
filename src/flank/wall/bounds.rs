//! Lower bounds of functions between two positions, from values and slopes at both.

/// Turn between two unit directions, as the length of their difference, up to which [`bend_of_distance`]
/// holds.
const MAX_TURN: f64 = 0.5;

/// Bound on the negative second derivative of the distance of a point from a line, by the share of the way
/// from one line to the next: while it moves by `travel` mm without turning, the distance is convex. `turn`
/// is the length of the difference of its unit directions, `far` the greatest distance of the point from the
/// point of the line that moves straight, mm.
pub(super) fn bend_of_distance(travel: f64, turn: f64, far: f64) -> f64 {
    // At most 2 · travel · |a′| + far · (|a″| + |a′|²) for the unit direction a. With turns up to MAX_TURN,
    // |a′| ≤ 1.04 turn and |a″| ≤ 3.5 turn².
    if turn <= MAX_TURN { turn * (3.0 * travel + 5.0 * far * turn) } else { f64::INFINITY }
}

/// Lower bound on [0, 1] of a function with these (value, slope) at both ends, whose second derivative is
/// nowhere less than −`bend`.
pub(super) fn lower_bound_between([(start, rate), (end, end_rate)]: [(f64, f64); 2], bend: f64) -> f64 {
    // Less the parabola ½ · bend · x · (1 − x), which is 0 at both ends, it is convex: above its tangents.
    let (falling, rising) = (rate - 0.5 * bend, end_rate + 0.5 * bend);
    if falling >= 0.0 || rising <= 0.0 {
        return if falling >= 0.0 { start } else { end };
    }
    let meet = ((end - rising - start) / (falling - rising)).clamp(0.0, 1.0);
    if meet.is_nan() { f64::NEG_INFINITY } else { start + falling * meet }
}
