//! No input makes a reader, or the code that uses its result, panic or run long: random bytes, and valid
//! files that are cut off, with bytes changed and with numbers replaced.

use std::sync::LazyLock;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::plan_file::{read_plan_bytes, write_plan};
use vanecut::io::{read_part, read_part_bytes, read_setup_bytes, write_native};
use vanecut::job::{PlanRequest, resolve, run};
use vanecut::monitor::Monitor;
use vanecut::part::{BladeDescription, BladeSide, CurveDescription, Impeller, Meridional, PartDescription};
use vanecut::setup::{AxisPolicy, CutDirection, Setup};
use vanecut::toolpath::ClProgram;
use vanecut::verify::verify;

const PART: &str = r#"name = "small"
blades = 7
[hub]
control = [[8, 0], [8, 14], [16, 24], [40, 26]]
[shroud]
points = [[20, 0], [20.5, 8], [24, 15], [31, 19.5], [40, 21]]
[[main.span]]
span = 0.0
leading_edge = 0.1
angle = [[0.0, 20.0], [1.0, 35.0]]
thickness = [[0.0, 1.0], [1.0, 1.2]]
[[main.span]]
span = 1.0
leading_edge = 0.1
angle = [[0.0, 40.0], [1.0, 40.0]]
thickness = [[0.0, 0.8], [1.0, 1.0]]
[[splitter.span]]
span = 0.0
leading_edge = 0.5
theta_leading_edge = 50.0
angle = [[0.0, 25.0], [1.0, 35.0]]
thickness = [[0.0, 0.8], [1.0, 1.0]]
[[splitter.span]]
span = 1.0
leading_edge = 0.5
theta_leading_edge = 55.0
angle = [[0.0, 40.0], [1.0, 40.0]]
thickness = [[0.0, 0.8], [1.0, 0.8]]
"#;

const SETUP: &str = r#"part = "small"
[stock]
hub_allowance = 0.3
blade_allowance = 0.2
safety_distance = 2.0
inlet_extension = 0.0
[[tool]]
number = 1
diameter = 2.0
corner_radius = 0.1
insert_width = 0.8
[plunge]
axis = "conventional"
step = 1.0
stepover = 3.0
max_axis_change = 5.0
[[plunge.section]]
tool = 1
from = 1.0
to = 0.8
feed = "inward"
"#;

/// Files of the sample part and of a plan of it.
struct Samples {
    part: Impeller,
    setup: Setup,
    program: String,
    plan: String,
    sections: String,
    geomturbo: String,
    turbogrid: [String; 4],
}

static SAMPLES: LazyLock<Samples> = LazyLock::new(|| {
    let description = read_part_bytes("small.toml", PART.as_bytes(), "toml").unwrap();
    let part = Impeller::build(&description).unwrap();
    let setup = read_setup_bytes("setup.toml", SETUP.as_bytes()).unwrap();
    let request = PlanRequest {
        part: part.clone().into(),
        setup: setup.clone(),
        policy: AxisPolicy::Conventional,
        compare: false,
        field_cells: 16,
    };
    let mut plan = run(&request, &Monitor::default()).unwrap().before.plan;
    plan.positions.truncate(12);
    let by_sections = PartDescription {
        main: sections(&part.main.suction, &part.main.pressure),
        splitters: vec![sections(&part.splitters[0].suction, &part.splitters[0].pressure)],
        ..description.clone()
    };
    Samples {
        program: write_apt(&ClProgram::of_plan("small", &plan)),
        plan: write_plan(&description, &setup, &plan, 1),
        sections: write_native(&by_sections),
        geomturbo: geomturbo(&part),
        turbogrid: turbogrid(&part),
        part,
        setup,
    }
});

fn points_of(side: &BladeSide) -> Vec<Vec<vanecut::geometry::Point>> {
    let line = |v: f64| (0..=12).map(|i| side.point(f64::from(i) / 12.0, v)).collect();
    vec![line(-0.02), line(0.5), line(1.02)]
}

fn sections(suction: &BladeSide, pressure: &BladeSide) -> BladeDescription {
    BladeDescription::Sections { suction: points_of(suction), pressure: points_of(pressure), line: 0 }
}

/// Points along hub and shroud.
fn curves(part: &Impeller) -> [Vec<Meridional>; 2] {
    let along = |path: &vanecut::part::Flowpath| {
        let (from, to) = path.s_range();
        (0..=20).map(|i| path.point(from + (to - from) * f64::from(i) / 20.0)).collect()
    };
    [along(&part.hub), along(&part.shroud)]
}

fn geomturbo(part: &Impeller) -> String {
    let mut text =
        "GEOMETRY TURBO\nVERSION 3.6\nUNITS Meters\nUNITS-FACTOR 0.001\nNI_BEGIN CHANNEL\n".to_owned();
    for (name, points) in ["hub", "shroud"].iter().zip(curves(part)) {
        text += &format!("NI_BEGIN basic_curve\nNAME {name}_1\nNI_BEGIN zrcurve\nZR\n+{}\n", points.len());
        text.extend(points.iter().map(|p| format!("{:.6} {:.6}\n", p.z, p.r)));
        text += "NI_END zrcurve\nNI_END basic_curve\n";
    }
    for name in ["hub", "shroud"] {
        text += &format!("NI_BEGIN channel_curve {name}\nNAME {name}\nVERTEX CURVE_P {name}_1 0\n");
        text += &format!("VERTEX CURVE_P {name}_1 1\nNI_END channel_curve {name}\n");
    }
    text += "NI_END CHANNEL\nNI_BEGIN nirow\nNAME row\nPERIODICITY 7\nROTATION_SPEED -10000\n";
    for blade in [&part.main, &part.splitters[0]] {
        text += "NI_BEGIN NIBlade\nNI_BEGIN nibladegeometry\nunits 1\nnumber_of_blades 7\n";
        for (name, side) in [("suction", &blade.suction), ("pressure", &blade.pressure)] {
            let sections = points_of(side);
            text += &format!("{name}\nSECTIONAL\n{}\n", sections.len());
            for (k, points) in sections.iter().enumerate() {
                text += &format!("# section {}\nXYZ\n+{}\n", k + 1, points.len());
                text.extend(points.iter().map(|p| format!("{:.6} {:.6} {:.6}\n", p.x, p.y, p.z)));
            }
        }
        text += "NI_END nibladegeometry\nNI_END NIBlade\n";
    }
    text + "NI_END nirow\n"
}

/// The `.inf`, hub, shroud and profile files of a part.
fn turbogrid(part: &Impeller) -> [String; 4] {
    let inf = "Axis of Rotation: Z\nNumber of Blade Sets: 7\nNumber of Blades Per Set: 2\n\
               Geometry Units: MM\nHub Data File: hub.curve\nShroud Data File: shroud.curve\n\
               Profile Data File: profile.curve\n";
    let curve = |points: &Vec<Meridional>| -> String {
        points.iter().map(|p| format!("{:.6} 0.0 {:.6}\n", p.r, p.z)).collect()
    };
    let [hub, shroud] = curves(part);
    let mut profile = String::new();
    for (name, blade) in [("Main Blade", &part.main), ("Splitter", &part.splitters[0])] {
        profile += &format!("## {name}\n");
        for (k, (s, p)) in points_of(&blade.suction).iter().zip(points_of(&blade.pressure)).enumerate() {
            profile += &format!("# Profile {} at {}%\n", k + 1, 50 * k);
            for point in s.iter().chain(p.iter().rev()) {
                profile += &format!("{:.6} {:.6} {:.6}\n", point.x, point.y, point.z);
            }
        }
    }
    [inf.to_owned(), curve(&hub), curve(&shroud), profile]
}

/// One random change of a file.
#[derive(Clone, Debug)]
enum Change {
    Byte(Index, u8),
    Number(Index, &'static str),
    Remove(Index, u8),
    Repeat(Index, u8),
    Cut(Index),
}

const NUMBERS: [&str; 22] = [
    "0",
    "1",
    "-1",
    "2",
    "3",
    "7",
    "0.5",
    "1e-9",
    "-0.0",
    "1e6",
    "-1e5",
    "1e300",
    "nan",
    "inf",
    "99999",
    "200",
    "1000000",
    "1e-300",
    "45",
    "89.9",
    "4294967296",
    "0.001",
];

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        3 => (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Change::Byte(at, byte)),
        3 => (any::<Index>(), select(b"0123456789.-+e[], \n=\"".as_slice()))
            .prop_map(|(at, b)| Change::Byte(at, b)),
        8 => (any::<Index>(), select(NUMBERS.as_slice())).prop_map(|(at, number)| Change::Number(at, number)),
        2 => (any::<Index>(), 1u8..40).prop_map(|(at, count)| Change::Remove(at, count)),
        2 => (any::<Index>(), 1u8..60).prop_map(|(at, count)| Change::Repeat(at, count)),
        1 => any::<Index>().prop_map(Change::Cut),
    ]
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    vec(change(), 1..5)
}

/// Replacement numbers that leave many files valid.
const MILD_NUMBERS: [&str; 14] =
    ["0.2", "0.4", "0.8", "1", "1.5", "3", "5", "9", "12", "18", "22", "27", "35", "42"];

/// Up to two replaced numbers, after which a part or a setup is often still valid.
fn new_numbers() -> impl Strategy<Value = Vec<Change>> {
    let number = prop_oneof![4 => select(MILD_NUMBERS.as_slice()), 1 => select(NUMBERS.as_slice())];
    vec((any::<Index>(), number).prop_map(|(at, number)| Change::Number(at, number)), 0..3)
}

/// Start and end of every number in a text.
fn numbers_in(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (at, byte) in bytes.iter().chain(b" ").enumerate() {
        let inside = byte.is_ascii_digit() || (start.is_some() && matches!(byte, b'.' | b'e'));
        match (start, inside) {
            (None, true) => start = Some(at),
            (Some(from), false) => {
                found.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn changed(text: &str, changes: &[Change]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for change in changes {
        if bytes.is_empty() {
            break;
        }
        let length = bytes.len();
        let end = |at: usize, count: u8| (at + usize::from(count)).min(length);
        match change {
            Change::Byte(at, byte) => bytes[at.index(length)] = *byte,
            Change::Number(at, number) => {
                let places = numbers_in(&bytes);
                if !places.is_empty() {
                    let (from, to) = places[at.index(places.len())];
                    bytes.splice(from..to, number.bytes());
                }
            }
            Change::Remove(at, count) => {
                let at = at.index(length);
                bytes.drain(at..end(at, *count));
            }
            Change::Repeat(at, count) => {
                let at = at.index(length);
                let piece = bytes[at..end(at, *count)].to_vec();
                bytes.splice(at..at, piece);
            }
            Change::Cut(at) => bytes.truncate(at.index(length)),
        }
    }
    bytes
}

/// Runs everything that is done with a part before planning.
fn prepare(description: &PartDescription) {
    if let Ok(part) = Impeller::build(description) {
        let _ = resolve(&Setup::default(), &Setup::default().allowances.workpiece_of(part));
    }
}

fn part(bytes: &[u8], extension: &str) {
    if let Ok(description) = read_part_bytes("a", bytes, extension) {
        prepare(&description);
    }
}

/// Makes a coarse plan if the files are valid.
fn planned(part: &[u8], setup: &[u8]) {
    let Ok(Ok(part)) = read_part_bytes("a", part, "toml").map(|description| Impeller::build(&description))
    else {
        return;
    };
    let Ok(setup) = read_setup_bytes("a", setup) else { return };
    let policy = setup.plunge.axis;
    let request = PlanRequest { part: part.into(), setup, policy, compare: false, field_cells: 16 };
    let _ = run(&request, &Monitor::default());
}

fn setup(bytes: &[u8]) {
    if let Ok(setup) = read_setup_bytes("a", bytes) {
        let _ = resolve(&setup, &setup.allowances.workpiece_of(SAMPLES.part.clone()));
    }
}

fn program(bytes: &[u8]) {
    if let Ok(program) = read_apt_bytes("a", bytes) {
        let _ = verify(
            &SAMPLES.setup.allowances.workpiece_of(SAMPLES.part.clone()),
            &SAMPLES.setup,
            &program,
            &Monitor::default(),
        );
    }
}

/// Number of changed files per reader: `FILES_COUNT`, else so few, as the gate draws the same ones each time.
fn cases() -> u32 {
    std::env::var("FILES_COUNT").ok().and_then(|count| count.parse().ok()).unwrap_or(128)
}

/// `PROPTEST_CASES` would override the numbers of all tests, also of those that take long.
fn config(cases: u32) -> ProptestConfig {
    let cases = cases.max(1);
    ProptestConfig { failure_persistence: None, max_shrink_iters: 200, cases, ..ProptestConfig::default() }
}

#[test]
fn the_samples_are_valid() {
    let s = &*SAMPLES;
    for (text, extension) in [(&s.sections, "toml"), (&s.geomturbo, "geomTurbo")] {
        let description = read_part_bytes("a", text.as_bytes(), extension).unwrap();
        assert!(matches!(description.main, BladeDescription::Sections { .. }));
        let part = Impeller::build(&description).unwrap();
        resolve(&Setup::default(), &Setup::default().allowances.workpiece_of(part.clone())).unwrap();
    }
    let description = read_turbogrid(&s.turbogrid, 0, s.turbogrid[0].as_bytes()).expect("a valid set");
    assert!(matches!(description.hub, CurveDescription::Points(_)));
    Impeller::build(&description).unwrap();
    let program = read_apt_bytes("a", s.program.as_bytes()).unwrap();
    verify(&s.setup.allowances.workpiece_of(s.part.clone()), &s.setup, &program, &Monitor::default())
        .unwrap();
    assert_eq!(read_plan_bytes("a", s.plan.as_bytes()).unwrap().plan.positions.len(), 12);
}

#[test]
fn a_plan_file_from_before_plunges_could_stop_short_is_read() {
    let written = &SAMPLES.plan;
    let whole = read_plan_bytes("a", written.as_bytes()).unwrap().plan;
    let mut file: serde_json::Value = serde_json::from_str(written).unwrap();
    for position in file["positions"].as_array_mut().unwrap() {
        let position = position.as_object_mut().unwrap();
        for key in ["lift", "held"] {
            assert!(position.remove(key).is_some(), "{key} is written today");
        }
    }
    let old = read_plan_bytes("a", file.to_string().as_bytes()).unwrap().plan;
    assert_eq!(old.positions.len(), whole.positions.len());
    for (old, new) in old.positions.iter().zip(&whole.positions) {
        assert_eq!((old.tip, old.axis, old.lift, old.limited_by), (new.tip, new.axis, 0.0, None));
    }
}

#[test]
fn a_plan_file_keeps_the_direction_in_which_each_section_is_cut() {
    let s = &SAMPLES;
    let mut plan = read_plan_bytes("a", s.plan.as_bytes()).unwrap().plan;
    let opposite = match plan.sections[0].feed {
        CutDirection::OutletToInlet => CutDirection::InletToOutlet,
        CutDirection::InletToOutlet => CutDirection::OutletToInlet,
    };
    plan.sections[0].feed = opposite;
    let stored = read_plan_bytes("a", s.plan.as_bytes()).unwrap();
    let written = write_plan(&stored.description, &stored.setup, &plan, 1);
    let read = read_plan_bytes("a", written.as_bytes()).unwrap();
    assert_eq!(read.plan.sections[0].feed, opposite, "the planner chose it, the setup does not name it");
    let program = write_apt(&read.program(&Monitor::default()).unwrap());
    assert_eq!(program.contains("OUTWARD"), opposite == CutDirection::InletToOutlet);
}

/// Reads the set with file `which` replaced.
fn read_turbogrid(files: &[String; 4], which: usize, bytes: &[u8]) -> Option<PartDescription> {
    let folder = tempfile::tempdir().unwrap();
    for (k, name) in ["part.inf", "hub.curve", "shroud.curve", "profile.curve"].iter().enumerate() {
        let content = if k == which { bytes } else { files[k].as_bytes() };
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    read_part(&folder.path().join("part.inf")).ok()
}

proptest! {
    #![proptest_config(config(cases() / 16))]

    // Fewer cases: small numbers may give a long plan; only the size of a plan is limited.
    #[test]
    fn changed_parts_planned(part_changes in new_numbers(), setup_changes in new_numbers()) {
        planned(&changed(PART, &part_changes), &changed(SETUP, &setup_changes));
    }
}

proptest! {
    #![proptest_config(config(cases() / 4))]

    // Fewer cases: of most files a part is still made, and tools chosen for it.
    #[test]
    fn changed_parts(changes in changes()) {
        let bytes = changed(PART, &changes);
        part(&bytes, "toml");
    }

    #[test]
    fn changed_sections(changes in changes()) {
        let bytes = changed(&SAMPLES.sections, &changes);
        part(&bytes, "toml");
    }

    #[test]
    fn changed_geomturbo(changes in changes()) {
        let bytes = changed(&SAMPLES.geomturbo, &changes);
        part(&bytes, "geomTurbo");
    }

    #[test]
    fn changed_turbogrid(which in 0usize..4, changes in changes()) {
        let files = &SAMPLES.turbogrid;
        let bytes = changed(&files[which], &changes);
        if let Some(description) = read_turbogrid(files, which, &bytes) {
            prepare(&description);
        }
    }
}

proptest! {
    #![proptest_config(config(cases()))]

    #[test]
    fn random_bytes(bytes in vec(any::<u8>(), 0..400)) {
        part(&bytes, "toml");
        part(&bytes, "geomTurbo");
        setup(&bytes);
        program(&bytes);
        let _ = read_plan_bytes("a", &bytes);
    }

    #[test]
    fn random_lines(lines in vec(
        "(NI_BEGIN|NI_END|CHANNEL|nirow|XYZ|ZR|[+]?[0-9]{1,7}|GOTO/|CUTTER/|LOADTL/1|FEDRAT/|[0-9.,-]{1,9}\
         |\\[\\[tool\\]\\]|\\[hub\\]|=| |\n){1,8}",
        0..30,
    )) {
        let text = lines.join("\n");
        part(text.as_bytes(), "toml");
        part(text.as_bytes(), "geomTurbo");
        setup(text.as_bytes());
        program(text.as_bytes());
        let _ = read_plan_bytes("a", text.as_bytes());
    }

    #[test]
    fn changed_setups(changes in changes()) {
        let bytes = changed(SETUP, &changes);
        setup(&bytes);
    }

    #[test]
    fn changed_programs(changes in changes()) {
        let bytes = changed(&SAMPLES.program, &changes);
        program(&bytes);
    }

    #[test]
    fn changed_plans(changes in changes()) {
        let bytes = changed(&SAMPLES.plan, &changes);
        let _ = read_plan_bytes("a", &bytes);
    }
}
