//! Stepover: the distance between neighbouring passes, by tool, scallop height and curvature of the surface
//! [flank paper, step 2 of the new tool path curves].

use crate::setup::Tool;

/// Radius of curvature beyond which a surface counts as flat, mm.
const FLAT_RADIUS: f64 = 1e9;

/// Stepover: the largest distance between neighbouring passes, mm along the surface, at which the scallop
/// between them is at most `scallop_height` mm high. `bulge` is the normal curvature of the surface across
/// the passes, 1/mm, positive where it is convex. The tool axis is along the normal. The result is at most
/// the tool diameter, and 0 for a scallop height of 0.
///
/// Across the passes the surface is taken as a circle of radius 1/`bulge`. Half way between two positions, at
/// arc length a from each, the point `scallop_height` above the surface is on the cutter: on a ball, on the
/// rounded corner of a bull end, or on the flat bottom. Solved for a by bisection.
pub fn stepover(tool: &Tool, scallop_height: f64, bulge: f64) -> f64 {
    let (flat, corner) = (tool.radius() - tool.corner_radius, tool.corner_radius);
    // Height of the cutter's profile at x from its axis.
    let profile = |x: f64| {
        let out = (x - flat).max(0.0).min(corner);
        corner - (corner * corner - out * out).sqrt()
    };
    let radius = if bulge.abs() * FLAT_RADIUS < 1.0 { FLAT_RADIUS.copysign(bulge) } else { 1.0 / bulge };
    // Height of the cutter above the top of the scallop at arc length a.
    let above = |a: f64| {
        let half = (0.5 * a / radius).sin();
        let turn = a / radius;
        let x = (radius + scallop_height) * turn.sin();
        // y of the point, less cancellation: (ρ + e) cos φ − ρ = e cos φ − ρ (1 − cos φ).
        let y = scallop_height * turn.cos() - 2.0 * radius * half * half;
        (x, profile(x.abs()) - y)
    };
    // A flat bottom rests on its rim where the surface is hollow: the height there counts from the rim.
    let lift = if radius < 0.0 { (0.5 * flat * flat / radius).abs() } else { 0.0 };
    if lift > scallop_height {
        return over_hollow(flat, scallop_height, -radius);
    }
    let (mut low, mut high) = (0.0, tool.radius());
    let fits = |a: f64| {
        let (x, above) = above(a);
        x.abs() <= tool.radius() && above + lift <= 0.0
    };
    if fits(high) {
        return 2.0 * high;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low + high
}

/// The stepover in a hollow of this `radius` where a bottom flat to the distance `flat` from its axis leaves
/// more than `scallop_height` in its middle: there the rims of the neighbouring positions cut. Within the arc
/// length that is returned from its rim the bottom leaves no more.
fn over_hollow(flat: f64, scallop_height: f64, radius: f64) -> f64 {
    // Distance of the bottom from the centre of the circle, and of the circle from the axis where it is
    // `scallop_height` below the bottom.
    let bottom = (radius * radius - flat * flat).max(0.0).sqrt();
    let inner = (radius * radius - (bottom + scallop_height).powi(2)).max(0.0).sqrt();
    let angle = |x: f64| (x / radius).min(1.0).asin();
    radius * (angle(flat) - angle(inner))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tool(diameter: f64, corner_radius: f64) -> Tool {
        Tool {
            number: 1,
            diameter,
            corner_radius,
            insert_width: 0.45 * diameter,
            overhang: 50.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: Default::default(),
        }
    }

    #[test]
    fn a_ball_on_flat_ground_follows_the_scallop_formula() {
        let (r, e) = (5.0f64, 0.25f64);
        let flat = 2.0 * (2.0 * r * e - e * e).sqrt();
        assert!((stepover(&tool(10.0, r), e, 0.0) - flat).abs() < 1e-6, "{flat}");
    }

    #[test]
    fn a_ball_leaves_the_scallop_height_on_a_cylinder() {
        // Two balls beside each other on a circle, and the height of their intersection above it.
        for (rho, convex) in [(40.0, true), (77.0, true), (30.0, false)] {
            let bulge = if convex { 1.0 / rho } else { -1.0 / rho };
            let (r, e) = (5.0, 0.25);
            let i = stepover(&tool(10.0, r), e, bulge);
            let turn: f64 = 0.5 * i / rho;
            let centre: f64 = if convex { rho + r } else { rho - r };
            // Distance from the circle's centre to where the balls meet, on the side of the surface.
            let root = (r * r - (centre * turn.sin()).powi(2)).sqrt();
            let cusp =
                if convex { centre * turn.cos() - root - rho } else { rho - centre * turn.cos() - root };
            assert!((cusp - e).abs() < 1e-6, "cusp {cusp} at {rho} {convex}, stepover {i}");
        }
    }

    #[test]
    fn in_a_hollow_the_rims_of_neighbours_cut_what_a_flat_bottom_leaves_in_its_middle() {
        let (rho, flat, e) = (20.0f64, 6.0f64, 0.25f64);
        // What stays on the circle at an angle, of cutters at whole numbers of steps of `turn`.
        let left = |at: f64, turn: f64| {
            let under = |k: i32| {
                let off: f64 = at - f64::from(k) * turn;
                let is_below = (rho * off.sin()).abs() <= flat;
                is_below.then(|| rho - (rho * rho - flat * flat).sqrt() / off.cos())
            };
            (-60..60).filter_map(under).fold(f64::INFINITY, f64::min)
        };
        let most =
            |turn: f64| (0..1000).map(|k| left(turn * f64::from(k) / 1000.0, turn)).fold(0.0, f64::max);
        let step = stepover(&tool(2.0 * flat, 0.0), e, -1.0 / rho);
        assert!(step > 0.3 && most(step / rho) < e, "{step}: {}", most(step / rho));
        // The steps of others bring a rim to its middle by chance: none of a range this much wider is enough.
        let wider = (20..40).map(|k| most(step * f64::from(k) / 10.0 / rho)).fold(0.0, f64::max);
        assert!(wider > e, "{wider}");
    }

    #[test]
    fn a_flat_end_covers_its_width_where_the_surface_is_flat_and_less_on_a_bulge() {
        let flat = tool(10.0, 0.0);
        assert!((stepover(&flat, 0.25, 0.0) - 10.0).abs() < 1e-6);
        let on_bulge = stepover(&flat, 0.25, 1.0 / 20.0);
        // cos φ = ρ / (ρ + e).
        let expected = 2.0 * 20.0 * (20.0f64 / 20.25).acos();
        assert!((on_bulge - expected).abs() < 1e-6, "{on_bulge} {expected}");
        let bull = stepover(&tool(10.0, 1.0), 0.25, 0.0);
        let corner = 4.0 + (2.0f64 * 0.25 - 0.0625).sqrt();
        assert!((bull - 2.0 * corner).abs() < 1e-6, "{bull}");
        assert!(stepover(&tool(10.0, 5.0), 0.0, 0.01) < 1e-12, "zero scallop height");
    }
}
