//! Drop-cutter depth, compared with a brute-force scan of the disc.

use proptest::prelude::*;
use vanecut::cutting::drop_cutter::DepthSurface;
use vanecut::geometry::{Meridional, MeridionalCurve, Point, Vector, frame_about};
use vanecut::part::Impeller;

use super::samples::{SAMPLES, sample};

/// Distance of the flat disc (centre, axis, radius) from the surface, mm: minimum of a dense scan of signed
/// distances of disc points, refined by pattern search from the best ones.
fn min_distance(curve: &MeridionalCurve, centre: &Point, axis: &Vector, radius: f64) -> f64 {
    let (e1, e2) = frame_about(axis);
    let at = |rho: f64, phi: f64| {
        let p = centre + (e1 * phi.cos() + e2 * phi.sin()) * rho;
        let (t, d) = curve.project(Meridional::from_point(&p));
        // Beyond the ends there is no hub surface: the distance to its edge, which is not negative.
        if t <= 0.0 || t >= curve.length() { d.abs() } else { d }
    };
    let mut seeds = Vec::new();
    for i in 0..=24 {
        for j in 0..96 {
            let (rho, phi) = (radius * f64::from(i) / 24.0, std::f64::consts::TAU * f64::from(j) / 96.0);
            seeds.push((at(rho, phi), rho, phi));
        }
    }
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = f64::INFINITY;
    for &(mut value, mut rho, mut phi) in &seeds[..12] {
        let (mut dr, mut dp) = (radius / 24.0, std::f64::consts::TAU / 96.0);
        while dp * radius > 1e-6 {
            let mut moved = false;
            for (r, p) in [(rho + dr, phi), (rho - dr, phi), (rho, phi + dp), (rho, phi - dp)] {
                let r = r.clamp(0.0, radius);
                let d = at(r, p);
                if d < value {
                    (value, rho, phi, moved) = (d, r, p, true);
                }
            }
            if !moved {
                dr *= 0.5;
                dp *= 0.5;
            }
        }
        best = best.min(value);
    }
    best
}

fn check(part: &Impeller, s: f64, turn: f64, tilt: f64, heading: f64, radius: f64, offset: f64) {
    let hub = part.hub.at(s);
    let normal = hub.normal.direction_at_angle(turn);
    let (e1, e2) = frame_about(&normal);
    let axis = (normal + (e1 * heading.cos() + e2 * heading.sin()) * tilt.tan()).normalize();
    // The axis passes through the hub's curve, or its extension, at s.
    let on_axis = part.hub.point(s).at_angle(turn) + axis * 3.0;
    let surface = DepthSurface::new(part.hub.curve(), offset);
    let Some(touch) = surface.touch(&on_axis, &axis, radius) else { panic!("no touch at s {s}") };
    let distance = min_distance(part.hub.curve(), &(on_axis + axis * touch.height), &axis, radius);
    assert!(
        (distance - offset).abs() < 1e-3,
        "disc rests {distance} mm from the hub instead of {offset}: \
         s {s} turn {turn} tilt {tilt} heading {heading} radius {radius}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]
    #[test]
    fn the_disc_rests_exactly_at_its_offset(
        s in 0.02..1.02f64, turn in -3.0..3.0f64, tilt in 0.0..0.6f64, heading in 0.0..std::f64::consts::TAU,
        size in 0.0..1.0f64, offset in 0.05..2.0f64, which in 0usize..3,
    ) {
        let part = sample(SAMPLES[which]);
        let radius = part.rim_radius() * (0.005 + 0.05 * size);
        // Further out, a disc does not touch the hub.
        let s = s.min(1.0 + 0.5 * radius / part.hub.length());
        check(&part, s, turn, tilt, heading, radius, offset);
    }

    #[test]
    fn so_it_does_where_the_rim_cuts_it_off(
        out in -1.2..0.5f64, turn in -3.0..3.0f64, tilt in 0.0..0.6f64, heading in 0.0..std::f64::consts::TAU,
        size in 0.0..1.0f64, offset in 0.05..2.0f64, which in 0usize..3,
    ) {
        let part = sample(SAMPLES[which]);
        let radius = part.rim_radius() * (0.005 + 0.05 * size);
        check(&part, 1.0 + out * radius / part.hub.length(), turn, tilt, heading, radius, offset);
    }
}
