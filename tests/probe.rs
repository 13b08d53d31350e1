//! Nearest distances between cutters and blade sides against a dense scan.

use std::path::Path;

use vanecut::formats::part_file::read_part;
use vanecut::geometry::CutterSolid;
use vanecut::part::{Channel, Impeller, SideProbe};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

#[test]
fn nearest_is_never_beaten_by_a_dense_scan() {
    let part = sample("impeller532.toml");
    let channel = Channel::of(&part);
    for (k, side) in channel.sides.iter().enumerate() {
        let probe = SideProbe::new(side, 0.0, 1.0);
        for i in 0..20 {
            let x = f64::from(i) / 20.0;
            let (s, lambda) = (0.05 + 0.9 * x, 0.3 + 0.4 * (7.0 * x).fract());
            let m = channel.full.point(&part, s, lambda, 0.0).expect("inside").point;
            let w = channel.full.point(&part, s - 0.1 * (3.0 * x).fract(), 0.5, 1.0).expect("inside").point;
            let axis = (w - m).normalize();
            let cutter = CutterSolid { tip: m + axis, axis, radius: 6.0, corner_radius: 0.0 };
            for (from, to) in [(0.0, 1.0), (0.0, 0.33), (0.33, 0.67), (0.67, 1.0)] {
                let found = probe.nearest(&cutter, from, to).distance;
                let mut least = f64::INFINITY;
                for a in 0..=600 {
                    for b in 0..=60 {
                        let v = from + (to - from) * f64::from(b) / 60.0;
                        least = least.min(cutter.distance(&side.point(f64::from(a) / 600.0, v)));
                    }
                }
                // Where the cutter cuts the side, how deep is good to 0.01 mm: that it cuts is what counts.
                let tolerance = if least < 0.0 { 0.01 } else { 1e-4 };
                assert!(
                    found - least < tolerance,
                    "side {k}, s {s:.3}, v {from} to {to}: found {found}, a scan finds {least}"
                );
            }
        }
    }
}
