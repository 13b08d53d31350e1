//! The sample parts have their documented dimensions.

use std::path::Path;

use vanecut::error::ErrorCode;
use vanecut::geometry::{Meridional, Point};
use vanecut::io::part_file::read_part;
use vanecut::part::description::{BladeDescription, CurveDescription};
use vanecut::part::{BladeSide, Channel, Impeller, SideProbe};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    let description = read_part(&path).expect("sample parts are readable");
    Impeller::build(&description).expect("sample parts are impellers")
}

fn narrowest(part: &Impeller) -> f64 {
    let channel = Channel::from_part(part);
    let (a, b) = (&channel.sides[0], &channel.sides[3]);
    let probe = SideProbe::new(b, 0.0, 1.0);
    let mut least = f64::INFINITY;
    for i in 0..=100 {
        for j in 0..=10 {
            let p = a.point(f64::from(i) / 100.0, f64::from(j) / 10.0);
            least = least.min(probe.nearest_to_point(&p).distance);
        }
    }
    least
}

fn edges(part: &Impeller) -> (f64, f64) {
    let side = &part.main.suction;
    let along = |u: f64| (side.point(u, 1.0) - side.point(u, 0.0)).norm();
    (along(0.0), along(1.0))
}

#[test]
fn impeller532_is_paper_a_s() {
    let part = sample("impeller532.toml");
    assert_eq!(part.blade_count, 17);
    assert!((2.0 * part.rim_radius() - 532.0).abs() < 0.01, "diameter {}", 2.0 * part.rim_radius());
    let height = part.shroud.point(1.0).distance(part.hub.point(1.0));
    assert!((height - 32.0).abs() < 0.01, "outlet height {height}");
    assert!((narrowest(&part) - 12.5).abs() < 0.1, "narrowest width {}", narrowest(&part));
}

#[test]
fn impeller9x9_is_paper_b_s() {
    let part = sample("impeller9x9.toml");
    assert_eq!((part.blade_count, part.splitters.len()), (9, 1));
    let (le, te) = edges(&part);
    assert!((le - 27.042).abs() < 0.1, "leading edge {le}");
    assert!((te - 6.62).abs() < 0.05, "trailing edge {te}");
}

#[test]
fn pump6_is_strongly_wrapped() {
    let part = sample("pump6.toml");
    assert_eq!(part.blade_count, 6);
    let angle = |u: f64| {
        let p = part.main.suction.point(u, 0.0);
        p.y.atan2(p.x)
    };
    let wrap: f64 = (0..100)
        .map(|i| {
            let d = angle(f64::from(i + 1) / 100.0) - angle(f64::from(i) / 100.0);
            if d < -3.0 { d + std::f64::consts::TAU } else { d }
        })
        .sum();
    assert!(wrap.to_degrees() > 110.0, "wrap {}°", wrap.to_degrees());
}

/// Sections that end far from hub and shroud are not stretched to them.
#[test]
fn blades_that_do_not_reach_the_hub_are_refused() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let mut description = read_part(&path).expect("sample parts are readable");
    let part = Impeller::build(&description).expect("sample parts are impellers");
    let section = |side: &BladeSide, v: f64| (0..=20).map(|i| side.point(f64::from(i) / 20.0, v)).collect();
    let sections = |heights: [f64; 2]| {
        let [suction, pressure] =
            [&part.main.suction, &part.main.pressure].map(|side| heights.map(|v| section(side, v)).to_vec());
        BladeDescription::Sections { suction, pressure, line: 7 }
    };
    description.main = sections([0.0, 1.0]);
    assert!(Impeller::build(&description).is_ok());
    description.main = sections([0.6, 0.9]);
    let error = Impeller::build(&description).expect_err("the blade hangs in the channel");
    assert_eq!((error.code, error.line), (ErrorCode::BladeTooShort, 7), "{error}");
}

/// The hub of a wheel of mixed flow may leave below the inlet's outer diameter.
#[test]
fn the_outlet_of_mixed_flow_may_lie_below_the_shrouds_inlet() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let mut description = read_part(&path).expect("sample parts are readable");
    let curve = |ends: [[f64; 2]; 2], bulge: f64, u: f64| {
        let at = |k: usize| ends[0][k] + (ends[1][k] - ends[0][k]) * u;
        let sag = bulge * u * (1.0 - u);
        Meridional { r: at(0) - sag, z: at(1) - sag }
    };
    let hub = |u: f64| curve([[20.0, 60.0], [45.0, 12.0]], 20.0, u);
    let shroud = |u: f64| curve([[48.0, 60.0], [65.0, 34.0]], 12.0, u);
    let line = |f: &dyn Fn(f64) -> Meridional| (0..=40).map(|i| f(f64::from(i) / 40.0)).collect::<Vec<_>>();
    (description.hub, description.shroud) =
        (CurveDescription::Points(line(&hub)), CurveDescription::Points(line(&shroud)));
    let section = |f: &dyn Fn(f64) -> Meridional, half: f64| -> Vec<Point> {
        let place = |u: f64| f(u).at_angle(0.6 * u + half * (4.0 * u * (1.0 - u)).sqrt() / f(u).r);
        (0..=40).map(|i| place(f64::from(i) / 40.0)).collect()
    };
    let side = |half: f64| vec![section(&hub, half), section(&shroud, half)];
    description.main = BladeDescription::Sections { suction: side(1.0), pressure: side(-1.0), line: 1 };
    let part = Impeller::build(&description).expect("an impeller");
    let (rim, inlet) = (part.hub.point(1.0).r, part.shroud.point(0.0).r);
    assert!((rim - 45.0).abs() < 0.1 && (inlet - 48.0).abs() < 0.1, "{rim} {inlet}");
}
