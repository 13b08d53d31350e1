//! Channel coordinates: their borders are the walls, and their derivatives agree with differences.

use proptest::prelude::*;
use vanecut::part::{Channel, SideProbe};

use super::samples::{SAMPLES, sample};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn derivatives_are_slopes(
        s in 0.05..0.95f64, lambda in 0.02..0.98f64, eta in 0.02..0.98f64, which in 0usize..3,
    ) {
        let part = sample(SAMPLES[which]);
        let channel = Channel::from_part(&part);
        let at = |s, l, e| channel.full.point(&part, s, l, e).expect("inside");
        let here = at(s, lambda, eta);
        let h = 1e-5;
        let slope =
            |a: vanecut::part::ChannelPoint, b: vanecut::part::ChannelPoint| (a.point - b.point) / (2.0 * h);
        let numeric = [
            slope(at(s + h, lambda, eta), at(s - h, lambda, eta)),
            slope(at(s, lambda + h, eta), at(s, lambda - h, eta)),
            slope(at(s, lambda, eta + h), at(s, lambda, eta - h)),
        ];
        for (exact, numeric) in [here.by_s, here.by_lambda, here.by_eta].iter().zip(numeric) {
            prop_assert!(
                (exact - numeric).norm() < 1e-3 * (1.0 + exact.norm()),
                "exact {exact:?}, by differences {numeric:?}"
            );
        }
    }
}

#[test]
fn borders_of_the_coordinates_are_the_walls_hub_and_shroud() {
    for name in SAMPLES {
        let part = sample(name);
        let channel = Channel::from_part(&part);
        let walls = [&channel.sides[0], &channel.sides[3]].map(|side| SideProbe::new(side, 0.0, 1.0));
        for i in 2..=18 {
            let s = f64::from(i) / 20.0;
            for eta in [0.1, 0.5, 0.9] {
                for (lambda, wall) in [(0.0, &walls[0]), (1.0, &walls[1])] {
                    let p = channel.full.point(&part, s, lambda, eta).expect("inside").point;
                    let off = wall.nearest_to_point(&p).distance;
                    // The probe is accurate to 2e-5 of the chord.
                    assert!(off < 6e-3, "{name}: {off} mm off the wall at s {s}, λ {lambda}, η {eta}");
                }
                for (eta, path) in [(0.0, &part.hub), (1.0, &part.shroud)] {
                    let p = channel.full.point(&part, s, 0.4, eta).expect("inside").point;
                    let wanted = path.point(s);
                    assert!(
                        (p.x.hypot(p.y) - wanted.r).abs() + (p.z - wanted.z).abs() < 1e-9,
                        "{name}: on the surface"
                    );
                }
            }
        }
    }
}
