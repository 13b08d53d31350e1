//! Programs written and verified: those of whole wheels, mutated ones, and agreement of the figures reported
//! by `plan` and `verify` for the same program.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use serde_json::Value;
use vanecut::geometry::{Meridional, Vector};
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::part_file::{read_part, read_part_bytes};
use vanecut::job::{PlanOutcome, PlanRequest, Summary, run};
use vanecut::monitor::Monitor;
use vanecut::part::{Blank, Impeller};
use vanecut::setup::{AxisPolicy, Setup};
use vanecut::toolpath::{ClProgram, Motion, Move};
use vanecut::verify::{FaultKind, PlungeReport, PlungeVerdict, report_plunges, verify};

use super::samples::{SAMPLES, sample, sample_path, sample_plans};

/// The program of a plan, written to a file and read back.
fn written(outcome: &PlanOutcome, channels: usize) -> ClProgram {
    let program = outcome.program_for_channels(&outcome.after, channels, &Monitor::default());
    let text = write_apt(&program.expect("not cancelled"));
    read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable")
}

fn reported(outcome: &PlanOutcome, program: &ClProgram) -> PlungeReport {
    report_plunges(&outcome.workpiece, &outcome.setup, program, 512, &Monitor::default())
        .expect("can be judged")
}

/// The verdict alone, without figures of the floor.
fn judged(outcome: &PlanOutcome, program: &ClProgram) -> PlungeVerdict {
    verify(&outcome.workpiece, &outcome.setup, program, &Monitor::default()).expect("can be judged")
}

#[test]
fn programs_of_whole_wheels_have_no_fault() {
    for name in SAMPLES {
        let outcome = sample_plans(name);
        // Of the wheel with the most blades a part.
        let several = outcome.workpiece.part.blade_count.min(9);
        let (one, all) =
            (reported(outcome, &written(outcome, 1)), judged(outcome, &written(outcome, several)));
        for (verdict, channels) in [(&one.verdict, 1), (&all, several)] {
            assert!(verdict.faults.is_empty(), "{name}, {channels}: {:#?}", verdict.faults);
            assert_eq!(verdict.channels, channels, "{name}");
            assert_eq!(verdict.cuts.len(), channels * outcome.after.plan.positions.len(), "{name}");
        }
        assert_eq!(one.summary.positions, one.verdict.cuts.len(), "{name}");
        // The summary of one channel's plan equals that of its program.
        let (plan, program) = (&outcome.after.summary, &one.summary);
        check_published(name, plan);
        for (what, plan, program, tolerance) in [
            ("cut", plan.cut_length, program.cut_length, 1e-2),
            ("rapid", plan.rapid_length, program.rapid_length, 1e-2),
            ("time", plan.time_estimate, program.time_estimate, 1e-2),
            ("axis", plan.max_axis_change_rad, program.max_axis_change_rad, 1e-7),
            ("uncut", plan.uncut_share, program.uncut_share, 5e-5),
            ("unreachable", plan.inaccessible_share, program.inaccessible_share, 1e-6),
            ("mean", plan.residual_mean, program.residual_mean, 1e-4),
            ("p95", plan.residual_p95, program.residual_p95, 1e-3),
            ("retract", plan.min_retract_clearance, program.min_retract_clearance, 5e-4),
            ("hub", plan.min_hub_clearance, program.min_hub_clearance, 2e-6),
        ] {
            assert!(
                (plan - program).abs() <= tolerance,
                "{name}, {what}: {plan} in the plan, {program} written"
            );
        }
    }
}

/// A wheel of plane paddles on a disc whose boss, with a rounded foot, stands above them.
const BOSS: &str = r#"
name = "boss"
blades = 6
[hub]
points = [
  [15.0, 22.0], [15.0, 18.0], [15.0, 14.0], [15.0, 11.2], [15.0, 7.0], [15.2284, 5.8519], [15.8787, 4.8787],
  [16.8519, 4.2284], [18.0, 4.0], [21.0, 4.0], [24.0, 4.0], [30.0, 4.0], [40.0, 4.0], [50.0, 4.0], [60.0, 4.0],
]
[shroud]
points = [[15.3, 14.0], [30.0, 14.0], [45.0, 14.0], [60.0, 14.0]]
"#;

/// Retracts beside a boss are raised above its edge, and the links between them are those of the raised ones.
#[test]
fn links_over_the_edge_of_a_boss_keep_the_safety_distance() {
    let side = |y: f64, z: f64| [15.3, 26.0, 37.0, 48.0, 60.0].map(|x| [x, y, z]);
    let section =
        |z: f64| format!("[[main.section]]\nsuction = {:?}\npressure = {:?}\n", side(1.5, z), side(-1.5, z));
    let text = BOSS.to_owned() + &[4.0, 9.0, 14.0].map(section).concat();
    let part = read_part_bytes("boss.toml", text.as_bytes(), "toml").expect("readable");
    let request = PlanRequest {
        part: Impeller::build(&part).expect("an impeller").into(),
        setup: Setup::default(),
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 128,
    };
    let outcome = run(&request, &Monitor::default()).expect("a plan");
    let verdict = judged(&outcome, &written(&outcome, 1));
    assert!(verdict.cuts.len() > 100 && verdict.faults.is_empty(), "{:#?}", verdict.faults);
}

/// Machine time of one channel of each sample by `minimal`, s.
const TIMES: [(&str, f64); 3] = [("impeller532", 7140.0), ("impeller9x9", 3160.0), ("pump6", 5320.0)];

/// A plan of a sample keeps the figures that docs/results.md has for it: what leaves them by more than these
/// tolerances is another plan, and the table is made anew by `scripts/table --update`.
fn check_published(name: &str, plan: &Summary) {
    let results = include_str!("../../docs/results.md");
    let start = format!("| {name} | minimal | all |");
    let row = results.lines().find(|line| line.starts_with(&start)).expect("every sample has a row");
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let (mean, p95) = cells[8].split_once(" / ").expect("two figures");
    let (_, time) = TIMES.into_iter().find(|(sample, _)| *sample == name).expect("every sample has a time");
    assert_eq!(cells[6], plan.interfering.to_string(), "{name}: interfering");
    for (what, published, planned, tolerance) in [
        ("positions", number(cells[5]), plan.positions as f64, 0.03 * number(cells[5])),
        ("mean stock", number(mean), plan.residual_mean, 0.02),
        ("stock, 95 %", number(p95), plan.residual_p95, 0.05),
        ("uncut share", 0.01 * number(cells[9]), plan.uncut_share, 0.002),
        ("time", time, plan.time_estimate, 0.05 * time),
    ] {
        assert!((published - planned).abs() <= tolerance, "{name}, {what}: {planned}, published {published}");
    }
}

/// Runs the program; returns exit code, JSON object on standard output, and standard error.
fn command(arguments: &[&str]) -> (i32, Value, String) {
    let out = Command::new(env!("CARGO_BIN_EXE_vanecut")).args(arguments).output().expect("it starts");
    let text = String::from_utf8_lossy(&out.stderr).into_owned();
    (out.status.code().unwrap_or(-1), serde_json::from_slice(&out.stdout).unwrap_or_default(), text)
}

#[test]
fn plan_and_verify_say_the_same() {
    let folder = tempfile();
    let [defaults, short] = ["defaults.toml", "short.toml"].map(|name| folder.join(name));
    std::fs::write(&defaults, "").unwrap();
    // `plan` makes the plans of all policies for each.
    let section = "[[tool]]\nnumber = 3\ndiameter = 16\n[[plunge.section]]\ntool = 3\nfrom = 1.0\nto = 0.8\n";
    std::fs::write(&short, section).unwrap();
    for (axis, channels, name, setup) in
        [("minimal", "3", "impeller532", &defaults), ("conventional", "1", "pump6", &short)]
    {
        let out = folder.join(format!("{axis}{channels}"));
        let (part, apt) = (sample_path(name), out.join("plunge.apt"));
        let [part, setup, out, apt] = [&part, setup, &out, &apt].map(|path| path.to_str().unwrap());
        let several = ["--axis", axis, "--channels", channels, "-o", out, "--json"];
        let (code, plan, text) = command(&[&["plan", part, "--setup", setup], &several[..]].concat());
        let (judged, program, _) = command(&["verify", part, apt, "--setup", setup, "--json"]);
        assert_eq!(code, judged, "{axis}, {channels}: {text}");
        let count = program["interferential"].as_u64().expect("a number");
        assert_eq!(code, i32::from(count > 0), "{axis}");
        assert!(count == 0 || text.contains(&format!("{count} plunges whose core meets stock")), "{text}");
        assert_eq!(plan["channels"].to_string(), channels, "{axis}");
        let only_planned = ["blocked", "held", "settled", "stopped", "rounds", "by_section", "elapsed"];
        let (plan_keys, program_keys) = (plan.as_object().unwrap(), program.as_object().unwrap());
        for (key, value) in plan_keys.iter().filter(|(key, _)| !only_planned.contains(&key.as_str())) {
            assert!(program_keys.get(key).is_none_or(|other| other == value), "{axis}, {key}: {value}");
        }
        let sections = |of: &Value| of["by_section"].as_array().cloned().expect("a list");
        assert_eq!(sections(&plan).len(), sections(&program).len(), "{axis}");
        for (plan, program) in sections(&plan).iter().zip(&sections(&program)) {
            for key in
                ["tool", "from", "to", "feed", "positions", "interferential", "residual_p95", "uncut_share"]
            {
                assert_eq!(plan[key], program[key], "{axis}, {key}");
            }
        }
        assert_eq!(plan["one_channel"].is_object(), channels != "1");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// A temporary directory of this test run.
fn tempfile() -> PathBuf {
    let folder = std::env::temp_dir().join(format!("vanecut-program-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A plan and program without faults, to be mutated.
static SOUND: LazyLock<(&PlanOutcome, ClProgram)> = LazyLock::new(|| {
    let outcome = sample_plans("impeller532");
    let program = written(outcome, 1);
    (outcome, program)
});

/// Faults of the program after a mutation: lines, kinds, values.
fn faults_after(mutate: impl FnOnce(&mut ClProgram)) -> Vec<(usize, FaultKind, Option<f64>)> {
    let (outcome, program) = &*SOUND;
    let mut program = program.clone();
    mutate(&mut program);
    let verdict = judged(outcome, &program);
    verdict.faults.into_iter().map(|f| (f.line, f.kind, f.value)).collect()
}

#[test]
fn a_sound_program_has_no_fault() {
    assert_eq!(faults_after(|_| ()), []);
}

#[test]
fn a_fault_names_the_move_that_is_wrong() {
    // Moves of a plunge: rapid to the retract point, plunge, rapid retract.
    let line = |index: usize| SOUND.1.moves[index].line;
    let low = faults_after(|p| {
        let (axis, retract) = (p.moves[30].axis, p.moves[30].tip);
        p.moves[30].tip = retract - axis * 3.0;
    });
    assert!(low.iter().any(|f| (f.0, f.1) == (line(30), FaultKind::RapidClearance)), "{low:?}");
    assert!(low.iter().all(|f| f.0 >= line(30) && f.0 <= line(31)), "{low:?}");
    assert!(low.iter().all(|f| f.2.is_some_and(f64::is_finite)), "with how much: {low:?}");
    let deep = faults_after(|p| {
        let axis = p.moves[31].axis;
        p.moves[31].tip -= axis * 0.3;
    });
    assert!(deep.iter().any(|f| (f.0, f.1) == (line(31), FaultKind::HubAllowance)), "{deep:?}");
    // The retract move of a plunge, shifted across.
    let aside = faults_after(|p| p.moves[32].tip += Vector::new(0.0, 0.0, 15.0));
    assert!(aside.iter().any(|f| (f.0, f.1) == (line(32), FaultKind::RapidClearance)), "{aside:?}");
}

#[test]
fn an_axis_that_flips_in_a_rapid_is_judged() {
    let line = SOUND.1.moves[30].line;
    let flipped = faults_after(|p| p.moves[30].axis = -p.moves[30].axis);
    assert!(flipped.iter().any(|f| f.0 == line), "{flipped:?}");
    // The tip is clear far above the part, but the flipped tool passes through all of it.
    let through = faults_after(|p| {
        let at = &mut p.moves[30];
        (at.tip, at.axis) = (at.tip + at.axis * 150.0, -at.axis);
    });
    let through: Vec<_> = through.into_iter().filter(|f| f.0 == line).map(|f| f.1).collect();
    assert!(through.contains(&FaultKind::ToolInBlank), "{through:?}");
    assert!(through.contains(&FaultKind::AxisTurn), "{through:?}");
}

#[test]
fn programs_that_do_nothing_sensible_are_faults() {
    let kinds =
        |faults: Vec<(usize, FaultKind, Option<f64>)>| faults.into_iter().map(|f| f.1).collect::<Vec<_>>();
    let off = kinds(faults_after(|p| p.moves.iter_mut().for_each(|m| m.tip += Vector::new(0.0, 0.0, 900.0))));
    assert!(off.contains(&FaultKind::CutsNothing), "{off:?}");
    // The bottom of the first plunge ends beyond the rim, its side cuts.
    let first_alone = kinds(faults_after(|p| p.moves.truncate(3)));
    assert!(!first_alone.contains(&FaultKind::CutsNothing), "{first_alone:?}");
    let unfed = faults_after(|p| {
        p.moves.iter_mut().filter(|m| m.motion != Motion::Rapid).for_each(|m| m.motion = Motion::Feed(None));
    });
    let first = SOUND.1.moves.iter().find(|m| m.motion != Motion::Rapid).unwrap().line;
    let count = SOUND.0.after.plan.positions.len() as f64;
    assert_eq!(unfed, [(first, FaultKind::NoFeed, Some(count))]);
    let thin = kinds(faults_after(|p| p.tools[0].diameter -= 1.0));
    assert!(thin.contains(&FaultKind::ToolDiffers), "{thin:?}");
    let short = kinds(faults_after(|p| p.tools[0].overhang = Some(20.0)));
    assert!(short.contains(&FaultKind::TooDeep), "{short:?}");
}

#[test]
fn a_tool_that_only_makes_rapids_has_no_section() {
    let (outcome, program) = &*SOUND;
    let mut program = program.clone();
    let first = program.moves.iter().find(|m| m.motion == Motion::Rapid && m.tool.is_some()).unwrap();
    let other = (0..program.tools.len()).find(|&tool| Some(tool) != first.tool).expect("rest milling");
    let idle = Move { tool: Some(other), ..first.clone() };
    program.moves.insert(0, idle);
    assert_eq!(judged(outcome, &program).sections.len(), outcome.after.plan.sections.len());
}

/// Distance from the top of a blank and from the nose upstream of it by brute force, by dense polygons.
struct BruteBlank {
    /// Shroud and both ends.
    top: Vec<Meridional>,
    /// The top and the hub under it.
    outline: Vec<Meridional>,
    /// From the axis along the front plane and the hub to the blank; empty where the blank begins with the
    /// hub.
    nose: Vec<Meridional>,
}

impl BruteBlank {
    fn new(part: &Impeller, blank: &Blank) -> Self {
        const COUNT: usize = 4000;
        let along = |curve: &vanecut::geometry::MeridionalCurve| -> Vec<Meridional> {
            (0..=COUNT).map(|i| curve.point(curve.length() * i as f64 / COUNT as f64)).collect()
        };
        let (hub, shroud) = (along(&blank.hub), along(&blank.shroud));
        let line =
            |a: Meridional, b: Meridional| (0..=COUNT).map(move |i| a.lerp(b, i as f64 / COUNT as f64));
        let mut top: Vec<Meridional> = line(hub[0], shroud[0]).collect();
        top.extend(&shroud);
        top.extend(line(shroud[COUNT], hub[COUNT]));
        let outline = top.iter().chain(hub.iter().rev()).copied().collect();
        let end = part.hub.arc_at(0.0);
        let at = |i: usize| part.hub.curve().point(end * i as f64 / COUNT as f64);
        let front = Meridional { r: 0.0, z: at(0).z };
        let mut nose: Vec<Meridional> = Vec::new();
        if end > 1e-3 {
            nose.extend(line(front, at(0)));
            nose.extend((0..=COUNT).map(at));
        }
        Self { top, outline, nose }
    }

    fn inside(outline: &[Meridional], p: Meridional) -> bool {
        let mut inside = false;
        for (i, a) in outline.iter().enumerate() {
            let b = outline[(i + 1) % outline.len()];
            if (a.z > p.z) != (b.z > p.z) && p.r < a.r + (p.z - a.z) / (b.z - a.z) * (b.r - a.r) {
                inside = !inside;
            }
        }
        inside
    }

    /// Distance from the top and the nose, negative in the blank (from the top) and in the nose (from the
    /// nose).
    fn clearance(&self, p: Meridional) -> f64 {
        let distance =
            |line: &[Meridional]| line.iter().map(|q| p.distance(*q)).fold(f64::INFINITY, f64::min);
        let (top, nose) = (distance(&self.top), distance(&self.nose));
        if Self::inside(&self.outline, p) {
            -top
        } else if self.in_nose(p) {
            -nose
        } else {
            top.min(nose)
        }
    }

    /// Whether a point is in the nose: the hub upstream of the blank, closed by planes at both of its ends.
    fn in_nose(&self, p: Meridional) -> bool {
        let axis = self.nose.last().map(|last| Meridional { r: 0.0, z: last.z });
        let closed: Vec<Meridional> = self.nose.iter().copied().chain(axis).collect();
        Self::inside(&closed, p)
    }
}

#[test]
fn distances_from_the_blank_are_those_of_brute_force() {
    let mut seed = 11u64;
    let mut dice = move |from: f64, to: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * ((seed >> 11) as f64 / (1u64 << 53) as f64)
    };
    for name in ["impeller532", "impeller9x9", "pump6", "kj66"] {
        let wheel = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wheels/kj66_sections.toml");
        let part = match name {
            "kj66" => Impeller::build(&read_part(&wheel).expect("readable")).expect("an impeller"),
            name => sample(name),
        };
        let blank = Blank::from_part(&part, 0.0);
        let brute = BruteBlank::new(&part, &blank);
        let (length, size) = (blank.shroud.length(), part.rim_radius());
        let middle = blank.shroud.point(0.5 * length);
        let grain = length / 4000.0;
        let mut looked_at = 0;
        for _ in 0..400 {
            let point = Meridional {
                r: (middle.r + dice(-1.0, 1.0) * size).abs(),
                z: middle.z + dice(-1.0, 1.0) * size,
            };
            let wanted = brute.clearance(point);
            let far = wanted.abs();
            // Below the hub, the distance from the top is not defined.
            if wanted >= 0.0 && blank.is_solid(point, &mut None) {
                continue;
            }
            looked_at += 1;
            for warm in [None, Some(0.0), Some(dice(0.0, length)), Some(length)] {
                let found = blank.clearance(point, &mut warm.clone());
                assert!(
                    (found - wanted).abs() < grain + 1e-3 * far.min(grain),
                    "{name}: {found} by {warm:?} at r {} z {}, {wanted} by brute force",
                    point.r,
                    point.z
                );
            }
        }
        assert!(looked_at > 150, "{name}: {looked_at}");
    }
}
