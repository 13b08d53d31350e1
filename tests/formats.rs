//! Readers and writers on whole files: real parts where they are at hand, and damaged input of
//! every format.

use std::path::PathBuf;

use vanecut::formats::{read_part, read_part_bytes, write_native};
use vanecut::part::{BladeDescription, CurveDescription, PartDescription};

/// A real part beside the project, where it is at hand.
fn sample(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if !path.exists() {
        println!("skipped: {name} is not at hand");
        return None;
    }
    Some(path)
}

fn points(curve: &CurveDescription) -> &[vanecut::part::Meridional] {
    match curve {
        CurveDescription::Points(points) => points,
        CurveDescription::BSpline { control, .. } => control,
    }
}

fn sections(
    blade: &BladeDescription,
) -> (&[Vec<vanecut::geometry::Point>], &[Vec<vanecut::geometry::Point>]) {
    match blade {
        BladeDescription::Sections { suction, pressure, .. } => (suction, pressure),
        BladeDescription::Camber { .. } => panic!("sections expected"),
    }
}

#[test]
fn compressor_geomturbo() {
    let Some(path) = sample("cc_autoblade/cc_autoblade.geomTurbo") else { return };
    let part = read_part(&path).expect("the compressor is a valid file");
    assert_eq!((part.name.as_str(), part.blade_count, part.splitters.len()), ("cc_autoblade", 12, 1));
    assert_eq!((points(&part.hub).len(), points(&part.shroud).len()), (100, 100));
    for blade in [&part.main, &part.splitters[0]] {
        let (suction, pressure) = sections(blade);
        assert_eq!((suction.len(), pressure.len(), suction[0].len()), (2, 2, 110));
        for (s, p) in suction.iter().zip(pressure) {
            let (te, le) = (s[109], s[0]);
            assert!((te.x.hypot(te.y) - 200.0).abs() < 3.0, "the blade ends at D 400: {te}");
            assert!(te.z > le.z, "points run LE → TE");
            assert!((s[0] - p[0]).norm() < 1e-3, "both sides share the leading edge: {} {}", s[0], p[0]);
        }
    }
    let again = read_part_bytes("cc_autoblade.toml", write_native(&part).as_bytes(), "toml").unwrap();
    assert_eq!(without_lines(again), without_lines(part));
}

/// The part with all line numbers 0.
fn without_lines(mut part: PartDescription) -> PartDescription {
    let blade = |blade: &mut BladeDescription| match blade {
        BladeDescription::Sections { line, .. } | BladeDescription::Camber { line, .. } => *line = 0,
    };
    blade(&mut part.main);
    part.splitters.iter_mut().for_each(blade);
    (part.hub_line, part.shroud_line, part.count_line) = (0, 0, 0);
    part
}
