//! Flank plans of third-party wheels and of one with overlapping blades: `verify` finds no fault in their
//! programs.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use vanecut::error::ErrorCode;
use vanecut::flank::LayoutInputs;
use vanecut::flank::choice::choose_tool;
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::tool_library::flank_cutters;
use vanecut::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::{FlankStrategy, Setup, Tool};
use vanecut::toolpath::ClProgram;
use vanecut::verify::{FlankVerdict, verify_flank};

use super::parts::{cutter, described, part_at};

/// A pump with five nearly cylindrical blades that overlap far: blade angles at the leading edge are 70° from
/// the meridional direction, on a flat disc.
const OVERLAPPING: &str = r#"
name = "overlapping"
blades = 5
[hub]
control = [[20, -3], [30, 0], [45, 0], [54.5, 0]]
[shroud]
control = [[20.5, -14], [30, -12], [45, -9], [54.5, -7]]
[[main.span]]
span = 0.0
leading_edge = 0.12
theta_leading_edge = 0.0
angle = [[0.0, 68.0], [1.0, 62.0]]
thickness = [[0.0, 2.0], [1.0, 2.0]]
[[main.span]]
span = 1.0
leading_edge = 0.12
theta_leading_edge = 0.0
angle = [[0.0, 68.0], [1.0, 62.0]]
thickness = [[0.0, 2.0], [1.0, 2.0]]
"#;

fn overlapping() -> Impeller {
    described(OVERLAPPING)
}

fn kj66() -> Impeller {
    part_at("tests/data/wheels/kj66_sections.toml")
}

fn planned(part: &Impeller, setup: Setup) -> FlankOutcome {
    let request = FlankRequest { part: Arc::new(part.clone()), setup };
    FlankJob::default().run(&request, &Monitor::default()).expect("a plan")
}

/// The verdict of `verify` on the written program.
fn verdict(outcome: &FlankOutcome) -> FlankVerdict {
    let (part, plan) = (&outcome.workpiece.part, &outcome.plan);
    let text = write_apt(&ClProgram::of_flank(&part.name, &plan.tool, &plan.moves));
    let program = read_apt_bytes("flank.apt", text.as_bytes()).expect("readable");
    verify_flank(
        &outcome.setup.allowances.workpiece_of(part.clone()),
        &outcome.setup,
        &program,
        &Monitor::default(),
    )
    .expect("can be judged")
}

/// The plan of [`overlapping`], computed once.
static OVERLAPPING_PLAN: LazyLock<FlankOutcome> = LazyLock::new(|| planned(&overlapping(), Setup::default()));

#[test]
fn no_program_is_written_that_verify_faults() {
    // Fewer layers than in practice: a fault on one occurs on most.
    let mut few_layers = Setup::default();
    few_layers.flank.layer_depth = 10.0;
    for outcome in [&planned(&kj66(), few_layers), &*OVERLAPPING_PLAN] {
        let (part, plan) = (&outcome.workpiece.part, &outcome.plan);
        assert!(plan.faults.is_empty(), "{}: {:?}", part.name, plan.faults);
        assert!(plan.times.cut_length > 1000.0, "{}: {:?}", part.name, plan.times);
        let left: f64 = plan.uncut.iter().map(|l| l.length).sum();
        let all = plan.layout.totals[FlankStrategy::Balanced as usize].length;
        assert!(left < 0.5 * all, "{}: {left} of {all} mm left out", part.name);
        assert!(plan.uncut.iter().all(|l| l.length > 0.0 && !l.why.message.is_empty()));
        let verdict = verdict(outcome);
        assert_eq!(outcome.max_overcut(), verdict.max_overcut, "{}: as verify says", part.name);
        let shown: Vec<_> = verdict.faults.iter().take(5).collect();
        assert!(verdict.faults.is_empty(), "{}: {shown:#?}", part.name);
        assert!(verdict.max_overcut <= 0.005, "{}: {} mm over", part.name, verdict.max_overcut);
        let turn = verdict.max_axis_change_rad.to_degrees();
        assert!(turn <= 5.0, "{}: axes turn by {turn}° a move", part.name);
    }
}

#[test]
fn the_mouth_between_overlapping_blades_is_covered() {
    let outcome = &*OVERLAPPING_PLAN;
    let of = |scheme: FlankStrategy| outcome.plan.layout.totals[scheme as usize];
    // The chart does not resolve the ends of arcs around a nose.
    let gap = of(FlankStrategy::Balanced).coverage.largest_gap;
    assert!(gap < 1.2, "{gap} stepovers");
    assert!(of(FlankStrategy::Layers).length <= of(FlankStrategy::Isoparametric).length);
}

#[test]
fn a_channel_without_room_is_refused_with_values_that_work() {
    let part = overlapping();
    let mut setup = Setup::default();
    setup.allowances.blade_allowance = 40.0;
    let error = choose_tool(&setup.allowances.workpiece_of(part.clone()), &setup, flank_cutters())
        .expect_err("no room");
    assert_eq!(error.code, ErrorCode::CutterTooWide, "{error}");
    assert!(!error.help.contains("D -"), "a diameter that there is: {error}");
    setup.allowances.blade_allowance = 5.0;
    let chosen =
        choose_tool(&setup.allowances.workpiece_of(part.clone()), &setup, flank_cutters()).expect("a cutter");
    assert!(chosen.tool.diameter < 4.0, "{:?}", chosen);
}

/// A flat bottom leaves far more of the floor than a ball: the job on the whole wheel, by both.
#[test]
fn a_flat_end_is_taken_only_where_it_is_named() {
    let part = part_at("assets/parts/impeller532.toml");
    let mut setup = Setup::for_part(&part);
    // The first ball that fits has the number of the setup's own tool.
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let ball = choose_tool(&workpiece, &setup, flank_cutters()).expect("a cutter").tool;
    setup.tools = vec![Tool { number: ball.number, ..cutter(10.0, 0.0, 100.0) }];
    // Fewer layers than by default.
    setup.flank.layer_depth = 15.0;
    let outcome = planned(&part, setup.clone());
    let tool = &outcome.plan.tool;
    assert_eq!((tool.diameter, tool.number), (ball.diameter, ball.number + 1), "under a free number");
    assert!(outcome.has_library_cutter());
    let reason = outcome.plan.reason.as_deref().expect("chosen");
    assert!(reason.contains("from the tool library"), "{reason}");
    let gap = |outcome: &FlankOutcome| outcome.verdict.as_ref().expect("verified").uncovered.gap;
    setup.flank.tool = Some(ball.number);
    let named = planned(&part, setup.clone());
    assert!(named.plan.tool.is_flat() && !named.has_library_cutter(), "the one that is named");
    assert!(gap(&outcome) < 0.03 && gap(&named) > 0.1, "{} and {}", gap(&outcome), gap(&named));
    // A ball end of the setup that fits comes first, even beside a thicker flat end, or nearly flat one.
    setup.flank.tool = None;
    setup.tools.extend(
        [(2, 8.0, 4.0), (3, 9.0, 3.5)]
            .map(|(number, diameter, corner)| Tool { number, ..cutter(diameter, corner, 100.0) }),
    );
    let own = choose_tool(&workpiece, &setup, flank_cutters()).expect("a cutter");
    assert_eq!(own.tool.number, 2);
    // Where nothing suits in the library either, the tools of the setup are taken as they are.
    setup.tools.truncate(1);
    assert_eq!(choose_tool(&workpiece, &setup, &[]).expect("a cutter").tool, setup.tools[0]);
    let narrow = part_at("assets/parts/impeller9x9.toml");
    let setup = Setup { tools: vec![cutter(60.0, 30.0, 100.0)], ..Setup::for_part(&narrow) };
    let workpiece = setup.allowances.workpiece_of(narrow);
    let fault = choose_tool(&workpiece, &setup, &[]).expect_err("too thick");
    assert_eq!(fault.code, ErrorCode::CutterTooWide);
}

#[test]
fn the_ball_of_a_cutter_is_no_larger_than_the_channel_is_deep() {
    // Three blades far apart, in a channel 6.6 mm deep.
    let part = part_at("tests/data/step/covered_wheel.step");
    let setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(part);
    let chosen = choose_tool(&workpiece, &setup, flank_cutters()).expect("a cutter").tool;
    assert!((4.0..=6.6).contains(&chosen.corner_radius), "{chosen:?}");
    // A shop that has only larger ones cuts with them.
    let tools = vec![Tool { diameter: 20.0, corner_radius: 10.0, ..chosen }];
    let setup = Setup { tools, ..setup };
    assert_eq!(choose_tool(&workpiece, &setup, &[]).expect("a cutter").tool.diameter, 20.0);
}

#[test]
fn a_thicker_cutter_is_taken_where_the_thin_ones_are_too_short() {
    let part = kj66();
    let ball = |number: u32, diameter: f64, overhang: f64| Tool {
        number,
        ..cutter(diameter, 0.5 * diameter, overhang)
    };
    let chosen = |tools: Vec<Tool>| {
        let setup = Setup { tools, ..Setup::for_part(&part) };
        choose_tool(&setup.allowances.workpiece_of(part.clone()), &setup, flank_cutters())
            .expect("a cutter")
            .tool
            .number
    };
    // The passage is 4.9 mm wide and 28.3 mm deep.
    let [short, long, thick] = [ball(1, 2.0, 24.0), ball(2, 2.0, 40.0), ball(3, 3.0, 36.0)];
    assert_eq!(chosen(vec![short.clone(), long, thick.clone()]), 2, "the thin one that is long enough");
    assert_eq!(chosen(vec![short.clone(), thick]), 3, "the thick one, as the thin one is short");
    assert_eq!(chosen(vec![short.clone(), ball(4, 3.0, 20.0)]), 1, "none is longer");
    assert_eq!(chosen(vec![short, ball(5, 4.0, 60.0)]), 1, "what fills the passage does not help");
}

/// A wheel with six blades, its diameter 200 mm times `scale`.
fn radial_wheel(scale: f64) -> Impeller {
    let line = |points: &[[f64; 2]]| {
        format!("{:?}", points.iter().map(|p| p.map(|x| x * scale)).collect::<Vec<_>>())
    };
    let span = |span: f64, angle: f64| {
        format!(
            "[[main.span]]\nspan = {span}\nleading_edge = 0.0\ntheta_leading_edge = 0.0\n\
             angle = [[0.0, {angle}], [1.0, 50.0]]\nthickness = [[0.0, {0}], [1.0, {0}]]\n",
            1.6 * scale
        )
    };
    let text = format!(
        "name = \"radial\"\nblades = 6\n[hub]\ncontrol = {}\n[shroud]\ncontrol = {}\n{}{}",
        line(&[[32.0, 9.0], [32.0, -25.0], [50.0, -54.0], [80.0, -54.0], [100.0, -54.0]]),
        line(&[[53.0, 16.0], [53.0, -14.0], [62.0, -38.0], [80.0, -43.5], [100.0, -45.0]]),
        span(0.0, 45.0),
        span(1.0, 60.0),
    );
    described(&text)
}

#[test]
fn small_wheels_are_covered_as_large_ones_are() {
    for scale in [1.0, 0.1] {
        let part = radial_wheel(scale);
        let setup = Setup::for_part(&part);
        let workpiece = setup.allowances.workpiece_of(part);
        let tool = choose_tool(&workpiece, &setup, flank_cutters()).expect("a tool").tool;
        let source = LayoutInputs { workpiece: &workpiece, setup: &setup, tool: &tool };
        let layout = source.plan(&Monitor::default()).expect("passes");
        let gap = layout.totals[FlankStrategy::Balanced as usize].coverage.largest_gap;
        let wide = layout.wide_share(FlankStrategy::Balanced);
        assert!(gap < 1.1 && wide < 1e-3, "D {}: {gap:.3} stepovers, {wide:.4}", 200.0 * scale);
    }
}

/// A cutter that leans over the channel beside its own may meet a blade that is not around its channel.
#[test]
fn a_blade_beyond_the_channel_is_in_the_way_of_a_leaning_cutter() {
    use vanecut::geometry::{CutterSolid, Point, Vector, rotate_z};
    use vanecut::mesh::{LengthUnit, MeshOptions};
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wheels/kj66_cad.glb");
    let options = MeshOptions { unit: Some(LengthUnit::Millimetre), ..MeshOptions::default() };
    let description = vanecut::io::part_file::read_part_with(&path, &options).expect("readable");
    let part = Impeller::build(&description).expect("an impeller");
    let setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(part);
    let axis = Vector::new(0.0164, -0.5844, 0.8113).normalize();
    let tip = Point::new(34.016, 32.234, 14.356);
    let cutter = CutterSolid { tip, axis, radius: 1.5, corner_radius: 1.5 };
    let (part, finished) = (&workpiece.part, &workpiece.finished);
    let mut sampled = f64::INFINITY;
    for turn in 0..part.blade_count {
        let grid = (0..=300).flat_map(|i| (0..=60).map(move |j| (f64::from(i) / 300.0, f64::from(j) / 60.0)));
        for (u, v) in grid {
            for side in &workpiece.channel.sides {
                let p = rotate_z(&side.point(u, v), part.pitch() * turn as f64);
                sampled = sampled.min(cutter.distance(&p));
            }
        }
    }
    assert!(sampled < -1.0, "the column goes through a blade: {sampled}");
    assert!(finished.wheel_clearance_below(&cutter, 36.0, 1.0) < sampled + 1e-6);
    assert!(finished.clears(&cutter, 0.0), "those around the channel are not in its way");
    assert!(!finished.clears_wheel(&cutter, 36.0, 0.0));
    assert_eq!(finished.sides_within(&cutter, 36.0, -1.0, None).count(), 2, "both sides of it");
    // A cutter that ends below it.
    assert!(finished.clears_wheel(&cutter, 9.0, 0.4));
    let goto = |up: f64| {
        let p = tip + axis * up;
        format!("GOTO/{},{},{},{},{},{}\n", p.x, p.y, p.z, axis.x, axis.y, axis.z)
    };
    let aside = format!("GOTO/{},{},{},{},{},{}\n", tip.x + 0.2, tip.y, tip.z, axis.x, axis.y, axis.z);
    let program = format!(
        "LOADTL/1\nCUTTER/3,1.5\nRAPID\n{}FEDRAT/300,MMPM\n{}{aside}{}FINI\n",
        goto(40.0),
        goto(0.0),
        goto(0.0)
    );
    let program = read_apt_bytes("p.apt", program.as_bytes()).expect("readable");
    let verdict = verify_flank(&workpiece, &setup, &program, &Monitor::default()).expect("a verdict");
    assert!(verdict.min_blade_clearance < sampled + 0.01, "{}", verdict.min_blade_clearance);
}
