//! Readers and writers on whole files: real parts, and damaged input of every format.

use std::path::PathBuf;

use proptest::prelude::*;
use vanecut::geometry::Point;
use vanecut::io::apt::read_apt_bytes;
use vanecut::io::{InputError, read_part, read_part_bytes, read_setup_bytes, write_native};
use vanecut::part::{BladeDescription, CurveDescription, PartDescription};

/// A real part.
fn sample(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn points(curve: &CurveDescription) -> &[vanecut::part::Meridional] {
    match curve {
        CurveDescription::Points(points) => points,
        CurveDescription::BSpline { control, .. } => control,
    }
}

fn sections(blade: &BladeDescription) -> (&[Vec<Point>], &[Vec<Point>]) {
    match blade {
        BladeDescription::Sections { suction, pressure, .. } => (suction, pressure),
        BladeDescription::Camber { .. } => panic!("sections expected"),
    }
}

#[test]
fn compressor_geomturbo() {
    let path = sample("cc_autoblade/cc_autoblade.geomTurbo");
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

/// θ from LE to TE along a side, rad.
fn wrap(side: &[Point]) -> f64 {
    side.windows(2).map(|p| turn(p[0], p[1])).sum()
}

/// Angle about Z from `a` to `b`, rad.
fn turn(a: Point, b: Point) -> f64 {
    (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y)
}

/// The pressure side leads when the wheel turns against the wrap of its blades. TurboGrid loops, which do
/// not name their sides, are split by this rule; it is checked against a file that names them.
#[test]
fn named_sides_agree_with_the_wrap() {
    let path = sample("cc_autoblade/cc_autoblade.geomTurbo");
    let part = read_part(&path).unwrap();
    for blade in [&part.main, &part.splitters[0]] {
        let (suction, pressure) = sections(blade);
        for (s, p) in suction.iter().zip(pressure) {
            let turns = -wrap(s).signum();
            let lead: f64 = (20..90).map(|k| turn(s[k], p[k])).sum();
            assert!(lead * turns > 0.0, "wrap {} lead {lead}", wrap(s));
        }
    }
}

#[test]
fn axial_turbogrid_set() {
    let path = sample("rotor37/rotor37_BladeGen.inf");
    let part = read_part(&path).expect("the axial rotor is a valid set of files");
    assert_eq!((part.name.as_str(), part.blade_count, part.splitters.len()), ("rotor37_BladeGen", 36, 0));
    let hub = points(&part.hub);
    assert!((hub[0].r - 175.26).abs() < 0.01 && (hub[0].z + 41.9).abs() < 1e-6, "{:?}", hub[0]);
    let (suction, pressure) = sections(&part.main);
    assert_eq!((suction.len(), pressure.len()), (6, 6));
    for (s, p) in suction.iter().zip(pressure) {
        assert_eq!(s[0], p[0], "both sides share the leading edge");
        assert!(s.len().abs_diff(p.len()) < 60, "the loop is split in the middle: {} {}", s.len(), p.len());
        let chord = |side: &[Point]| (side[0] - side[side.len() - 1]).norm();
        assert!((chord(s) - chord(p)).abs() < 1.0, "both sides end at the trailing edge");
        assert!(chord(s) > 50.0 && s[s.len() - 1].z > s[0].z + 20.0, "{} → {}", s[0], s[s.len() - 1]);
        // The suction side of a compressor blade is the longer side.
        let length = |side: &[Point]| side.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>();
        println!("suction {:.3} pressure {:.3} chord {:.3}", length(s), length(p), chord(s));
        assert!(length(s) > length(p), "suction {} pressure {}", length(s), length(p));
    }
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

const NATIVE: &str = r#"blades = 3
[hub]
points = [[20, 0.0], [50.0, 45.0]]
[shroud]
control = [[40.0, 0.0], [40.0, 25.0], [50.0, 38.0]]
degree = 2
[[main.span]]
span = 0.0
angle = [[0.0, 30.0], [1.0, 45.0]]
thickness = [[0.0, 2.0]]
[[main.span]]
span = 1.0
angle = [[0.0, 50.0]]
thickness = [[0.0, 1.0]]
"#;

const GEOMTURBO: &str = "UNITS Meters\nNI_BEGIN CHANNEL\n\
NI_BEGIN basic_curve\nNAME h\nNI_BEGIN zrcurve\nZR\n2\n0 .02\n.02 .05\nNI_END zrcurve\nNI_END basic_curve\n\
NI_BEGIN channel_curve hub\nVERTEX CURVE_P h 0\nVERTEX CURVE_P h 1\nNI_END channel_curve hub\n\
NI_BEGIN channel_curve shroud\nVERTEX CURVE_P h 1\nVERTEX CURVE_P h 0\nNI_END channel_curve shroud\n\
NI_END CHANNEL\nNI_BEGIN nirow\nPERIODICITY 5\nNI_BEGIN NIBlade\nNI_BEGIN nibladegeometry\n\
suction\nSECTIONAL\n2\nXYZ\n2\n0 0 0\n0 1 1\nZRTH\n2\n1 1 0\n2 2 1\n\
pressure\nSECTIONAL\n2\nXYZ\n2\n0 0 0\n0 1 1\nXYZ\n2\n0 0 0\n0 1 1\n\
NI_END nibladegeometry\nNI_END NIBlade\nNI_END nirow\n";

const SETUP: &str = "part = \"x\"\n[stock]\nhub_allowance = 0.5\n[[tool]]\ndiameter = 30.0\n\
[plunge]\naxis = \"monotone\"\nmax_tilt = 40\n\
[[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.6\nfeed = \"inward\"\n[flank]\ntool = 4\n";

const APT: &str = "PARTNO x\nUNITS/INCHES\nTLDATA/MILL,16.,0.8,75.,0.,0.\nLOAD/TOOL,3\n\
PPRINT/INSERT WIDTH 3 5.0\nMULTAX/ON\nFROM/0,0,9\nRAPID\nGOTO/1,2,3,$\n0.6,0,0.8 $$ x\nFEDRAT/MMPM,150.\n\
GODLTA/-1\nLOADTL/1,LENGTH,120.\n$$-> CUTTER / 3.0\nGOTO/1,2,3\nFINI\n";

const INF: &str = "! x\nAxis of Rotation: Z\nNumber of Blade Sets: 9\nGeometry Units: CM\n\
Hub Data File: c.curve\nShroud Data File: c.curve\nProfile Data File: p.curve\n";
const CURVE: &str = "2 0 0\n0 3 2\n5 0 3\n";
const PROFILE: &str = "## Main\n# Profile 1 at 0%\n2 0 0 le\n3 -1 1\n5 -3 2 te1\n5 -2.9 2 te2\n\
3 -.8 1\n2 0 0\n# Profile 2 at 100%\n2 0 1\n3 -1 2\n5 -3 3\n5 -2.9 3\n3 -.8 2\n2 0 1\n";

type Reader = fn(&[u8]) -> Result<(), InputError>;
/// Every reader of a single file, with a valid sample of its format.
const READERS: [(&str, Reader); 4] = [
    (NATIVE, |bytes| read_part_bytes("a.toml", bytes, "toml").map(drop)),
    (GEOMTURBO, |bytes| read_part_bytes("a.geomTurbo", bytes, "geomTurbo").map(drop)),
    (SETUP, |bytes| read_setup_bytes("a.toml", bytes).map(drop)),
    (APT, |bytes| read_apt_bytes("a.apt", bytes).map(drop)),
];

/// Reads a TurboGrid set of these three files.
fn read_set(inf: &[u8], curve: &[u8], profile: &[u8]) -> Result<(), InputError> {
    let folder = tempfile::tempdir().expect("a folder for the test's files");
    for (name, bytes) in [("a.inf", inf), ("c.curve", curve), ("p.curve", profile)] {
        std::fs::write(folder.path().join(name), bytes).expect("the folder can be written to");
    }
    read_part(&folder.path().join("a.inf")).map(drop)
}

fn check(result: Result<(), InputError>) {
    if let Err(error) = result {
        let text = error.to_string();
        assert!(!text.contains('\n') && text.len() < 500, "a fault is one short line: {text}");
        assert!(!error.message.is_empty() && !error.help.is_empty(), "a fault says what and what to do");
    }
}

#[test]
fn samples_of_the_mutations_are_valid() {
    for (sample, read) in READERS {
        read(sample.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{sample}"));
    }
    read_set(INF.as_bytes(), CURVE.as_bytes(), PROFILE.as_bytes()).unwrap();
}

#[test]
fn every_truncation_is_answered() {
    for (sample, read) in READERS {
        (0..sample.len()).for_each(|length| check(read(&sample.as_bytes()[..length])));
    }
    for length in 0..PROFILE.len() {
        check(read_set(INF.as_bytes(), CURVE.as_bytes(), &PROFILE.as_bytes()[..length]));
    }
}

/// Numbers and characters that are likely to break readers.
const HARMFUL: [&str; 12] = [
    "nan",
    "inf",
    "-1e300",
    "1e999",
    "99999999999999999999",
    "-0",
    "\0",
    "\u{fffd}",
    "[[[[[[",
    "$",
    "\"",
    "0x",
];

/// A sample with bytes changed, pieces replaced by harmful ones, repeated or removed.
fn mutated(sample: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let edit = (0..4_u8, any::<prop::sample::Index>(), any::<u8>());
    prop::collection::vec(edit, 1..6).prop_map(move |edits| {
        let mut bytes = sample.as_bytes().to_vec();
        for (kind, at, byte) in edits {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => {
                    let end = (at + usize::from(byte % 8)).min(bytes.len());
                    let piece = HARMFUL[usize::from(byte) % HARMFUL.len()];
                    bytes.splice(at..end, piece.bytes());
                }
                2 => {
                    let end = (at + usize::from(byte)).min(bytes.len());
                    bytes.drain(at..end);
                }
                _ => {
                    let end = (at + usize::from(byte)).min(bytes.len());
                    let piece = bytes[at..end].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
        }
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..400), text in "[ -~\n]{0,400}") {
        for (_, read) in READERS {
            check(read(&bytes));
            check(read(text.as_bytes()));
        }
    }

    #[test]
    fn damaged_files_are_answered(
        native in mutated(NATIVE), geomturbo in mutated(GEOMTURBO),
        setup in mutated(SETUP), apt in mutated(APT),
    ) {
        for ((_, read), bytes) in READERS.iter().zip([native, geomturbo, setup, apt]) {
            check(read(&bytes));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_sets_are_answered(
        inf in mutated(INF), curve in mutated(CURVE), profile in mutated(PROFILE), which in 0..3,
    ) {
        let pick = |k: i32, bytes: &[u8], good: &str| {
            if which == k { bytes.to_vec() } else { good.as_bytes().to_vec() }
        };
        check(read_set(&pick(0, &inf, INF), &pick(1, &curve, CURVE), &pick(2, &profile, PROFILE)));
    }
}
