//! The blank of the setup: what planning, verification and files do with one that is not that of the edges.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use vanecut::error::ErrorCode;
use vanecut::geometry::Meridional;
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::setup_file::{read_setup, read_setup_bytes, write_setup, write_setup_beside};
use vanecut::io::stl::write_stl;
use vanecut::job::{JobError, PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::{Blank, BlankShape, Impeller};
use vanecut::plunge::channels::plan_channels;
use vanecut::plunge::{PlungePlan, Position};
use vanecut::setup::{
    AxisPolicy, ChannelOrder, ChannelSequence, ChannelSetup, SectionKind, SectionSetup, Setup, Tool,
    ToolAssembly,
};
use vanecut::stock::solid::{Contact, SolidBlank, SolidProgram, SolidStock, StockSurface};
use vanecut::toolpath::{ClProgram, Motion, Travel};
use vanecut::verify::{FaultKind, verify};

use super::samples::sample;

static PUMP: LazyLock<Arc<Impeller>> = LazyLock::new(|| sample("pump6").into());
static PART: LazyLock<Arc<Impeller>> = LazyLock::new(|| sample("impeller9x9").into());

/// One cutter in the outer half of the channel.
fn planned(blank: BlankShape) -> PlanOutcome {
    let tool = Tool {
        number: 1,
        diameter: 16.0,
        corner_radius: 0.8,
        insert_width: 5.0,
        overhang: 250.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    };
    let mut setup = Setup { tools: vec![tool], ..Setup::default() };
    setup.allowances.blank = blank;
    setup.plunge.sections =
        vec![SectionSetup { tool: 1, from: 1.0, to: 0.6, cut_direction: None, kind: SectionKind::Rows }];
    let part = Arc::clone(&PART);
    let request = PlanRequest { part, setup, policy: AxisPolicy::Staircase, compare: false, field_cells: 32 };
    run(&request, &Monitor::default()).expect("it can be planned")
}

/// The program as its file holds it.
fn written(outcome: &PlanOutcome) -> ClProgram {
    let text = write_apt(&ClProgram::of_plan("a", &outcome.after.plan));
    read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable")
}

fn kinds(setup: &Setup, program: &ClProgram) -> Vec<FaultKind> {
    let verdict = verify(&setup.allowances.workpiece_of(PART.clone()), setup, program, &Monitor::default())
        .expect("it can be checked");
    verdict.faults.iter().map(|fault| fault.kind).collect()
}

#[test]
fn a_plan_of_a_turned_blank_is_free_of_faults_and_of_the_cylinder() {
    let outcome = planned(BlankShape::Turned);
    let program = written(&outcome);
    assert!(outcome.after.plan.positions.len() > 10);
    assert_eq!(kinds(&outcome.setup, &program), []);
    // By the cylinder itself: at the ends of rapids every point of the bottom is outside.
    let blank = outcome.setup.allowances.blank_of(&PART);
    let (radius, (low, high)) = blank.outline().expect("a cylinder").bounds();
    let safety = outcome.setup.allowances.safety_distance;
    let mut least = f64::INFINITY;
    for step in program.moves.iter().filter(|step| step.motion == Motion::Rapid) {
        let (u, v) = vanecut::geometry::frame_about(&step.axis);
        for (share, turn) in (0..=8).flat_map(|i| (0..48).map(move |k| (f64::from(i) / 8.0, f64::from(k)))) {
            let (sin, cos) = (turn * std::f64::consts::TAU / 48.0).sin_cos();
            let p = Meridional::from_point(&(step.tip + (u * cos + v * sin) * (8.0 * share)));
            let (beyond, above) = ((p.r - radius).max(0.0), (p.z - high).max(low - p.z).max(0.0));
            least = least.min(beyond.hypot(above));
        }
    }
    // The corner radius keeps the rim of the bottom further away than the samples say.
    assert!(least > safety - 0.8, "{least} mm from the cylinder");
}

#[test]
fn a_rapid_that_only_the_turned_blank_is_in_the_way_of_is_found() {
    let outcome = planned(BlankShape::Edges);
    let program = written(&outcome);
    assert_eq!(kinds(&outcome.setup, &program), [], "free of the blank it was planned for");
    let mut turned = outcome.setup.clone();
    turned.allowances.blank = BlankShape::Turned;
    let found = kinds(&turned, &program);
    assert!(found.contains(&FaultKind::RapidClearance), "{found:?}");
}

/// A plan with the tools and sections that the setup leads to, by a policy that takes little time.
fn planned_as_chosen(setup: Setup) -> PlanOutcome {
    tried_as_chosen(AxisPolicy::Monotone, setup).expect("it can be planned")
}

fn tried_as_chosen(policy: AxisPolicy, setup: Setup) -> Result<PlanOutcome, JobError> {
    let part = Arc::clone(&PUMP);
    let request = PlanRequest { part, setup, policy, compare: false, field_cells: 64 };
    run(&request, &Monitor::default())
}

/// Sections and positions above the shroud, and those of the channel.
fn kinds_of(plan: &PlungePlan) -> [usize; 2] {
    let opens = |position: &&Position| plan.sections[position.section].kind == SectionKind::Opening;
    let above = plan.positions.iter().filter(opens).count();
    [above, plan.positions.len() - above]
}

/// What meets stock in a program, by the solid.
fn collisions(program: &ClProgram, setup: &Setup) -> Vec<Contact> {
    let blank = SolidBlank::from_part(&PUMP, &setup.allowances.blank_of(&PUMP));
    let mut stock = SolidStock::new(&blank, 1.0).expect("small");
    let program = SolidProgram::new(program, setup).expect("with tools");
    stock.make_moves(&program.tools, &program.moves, &Monitor::default()).expect("runs")
}

/// Plunges below what was opened feed only where stock stands: in a fraction of the time that they take from
/// the retract point; and approaches that end lower are faults.
fn assert_rapids_come_down_to_the_stock(plan: &PlungePlan, setup: &Setup, program: &ClProgram) {
    let mut slow = plan.clone();
    slow.positions.iter_mut().for_each(|position| position.evaluation.motion.approach = None);
    let [before, after] = [&slow, plan].map(|plan| Travel::from_program(&ClProgram::of_plan("a", plan)).time);
    assert!(after < 0.8 * before, "{after} s, {before} s without approaches");
    let begins = |k: &usize| {
        let [step, before] = [&program.moves[*k], &program.moves[*k - 1]];
        step.motion == Motion::Rapid
            && before.motion == Motion::Rapid
            && step.is_axial_from(before)
            && (step.tip - before.tip).dot(&step.axis) < 0.0
    };
    let approaches: Vec<usize> = (1..program.moves.len()).filter(begins).collect();
    assert!(approaches.len() > 100, "{}", approaches.len());
    // Half way from there to the tip.
    let mut low = program.clone();
    for &k in &approaches {
        low.moves[k].tip = program.moves[k].tip + (program.moves[k + 1].tip - program.moves[k].tip) * 0.5;
    }
    let verdict = verify(&setup.allowances.workpiece_of(PUMP.clone()), setup, &low, &Monitor::default())
        .expect("it can be checked");
    let lines: Vec<usize> = approaches.iter().map(|&k| program.moves[k].line).collect();
    assert!(verdict.faults.iter().all(|fault| lines.contains(&fault.line)));
    let count = |kind: FaultKind| verdict.faults.iter().filter(|fault| fault.kind == kind).count();
    let found = [FaultKind::RapidClearance, FaultKind::RapidInStock].map(count);
    assert_eq!(found[0] + found[1], verdict.faults.len());
    assert!(found[1] > 50, "{found:?} of {}", approaches.len());
}

#[test]
fn a_cylinder_is_opened_down_to_the_shroud_and_the_channel_planned_as_without_it() {
    // By the fastest policy without contact wherever sections end.
    let planned = |setup| tried_as_chosen(AxisPolicy::Staircase, setup).expect("it can be planned");
    let usual = planned(Setup::for_part(&PUMP)).after;
    let mut setup = Setup::for_part(&PUMP);
    setup.allowances.blank = BlankShape::Turned;
    setup.plunge.rapid_approach = true;
    let outcome = planned(setup);
    let plan = &outcome.after.plan;
    let [above, below] = kinds_of(plan);
    assert_eq!(kinds_of(&usual.plan)[0], 0, "nothing stands above the shroud of the usual blank");
    assert!(above > 20 && below * 100 >= 95 * usual.plan.positions.len(), "{above} above, {below} below");
    assert_eq!(plan.dropped.len(), usual.plan.dropped.len(), "{:?}", plan.dropped);
    let (mean, before) = (outcome.after.summary.residual_mean, usual.summary.residual_mean);
    assert!((mean / before - 1.0).abs() < 0.03, "{mean} mm left, {before} mm with the usual blank");
    let text = write_apt(&ClProgram::of_plan("a", plan));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable");
    let workpiece = outcome.setup.allowances.workpiece_of(PUMP.clone());
    let verdict =
        verify(&workpiece, &outcome.setup, &program, &Monitor::default()).expect("it can be checked");
    assert_eq!(verdict.faults, []);
    assert_eq!(collisions(&program, &outcome.setup), []);
    assert_rapids_come_down_to_the_stock(plan, &outcome.setup, &program);
    // Neighbouring channels share plunges above the shroud.
    let blank = outcome.setup.allowances.blank_of(&PUMP);
    let all = plan_channels(plan, &PUMP, &blank, &outcome.setup, PUMP.blade_count, &Monitor::default())
        .expect("runs");
    let [all_above, all_below] = kinds_of(&all);
    assert_eq!(all_below, PUMP.blade_count * below);
    assert!(all_above < PUMP.blade_count * above, "{all_above} of {above} for one channel");
    assert!(all.positions.iter().all(|position| !position.evaluation.contact.interferes()));
    // So they do where one channel is finished before the next.
    let mut setup = outcome.setup.clone();
    let sequence = ChannelSequence::Opposite;
    setup.channels = ChannelSetup { order: ChannelOrder::ChannelByChannel, sequence };
    let all = plan_channels(plan, &PUMP, &blank, &setup, PUMP.blade_count, &Monitor::default());
    let all = all.expect("runs");
    assert_eq!(kinds_of(&all), [all_above, all_below]);
    let text = write_apt(&ClProgram::of_plan("a", &all));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable");
    let verdict = verify(&workpiece, &setup, &program, &Monitor::default()).expect("it can be checked");
    assert_eq!(verdict.faults, []);
    assert_eq!(verdict.channels, PUMP.blade_count);
}

#[test]
#[ignore = "a plan of 21 s; scripts/nightly runs it"]
fn a_holder_passes_through_what_was_opened_and_no_more() {
    let tool = |number: u32, diameter: f64, overhang: f64| Tool {
        number,
        diameter,
        corner_radius: 0.0,
        insert_width: 0.35 * diameter,
        overhang,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: ToolAssembly { holder: vec![[2.0 * diameter, 3.0 * diameter, 60.0]], ..Default::default() },
    };
    let mut setup =
        Setup { tools: vec![tool(1, 40.0, 100.0), tool(2, 12.0, 60.0)], ..Setup::for_part(&PUMP) };
    setup.allowances.blank = BlankShape::Turned;
    let rows =
        |tool: u32, kind: SectionKind| SectionSetup { tool, from: 1.0, to: 0.4, cut_direction: None, kind };
    // At the outlet the blank stands highest above the hub.
    setup.plunge.sections = vec![SectionSetup { to: 0.9, ..rows(2, SectionKind::Rows) }];
    let closed = tried_as_chosen(AxisPolicy::Monotone, setup.clone())
        .map(|outcome| outcome.after.plan.positions.len());
    assert!(
        matches!(&closed, Err(JobError::Setup(fault)) if fault.code == ErrorCode::OverhangTooShort),
        "the tool is shorter than the blank stands above the hub: {closed:?}"
    );

    setup.plunge.sections = vec![rows(1, SectionKind::Opening), rows(2, SectionKind::Rows)];
    let outcome = planned_as_chosen(setup);
    let plan = &outcome.after.plan;
    let [above, below] = kinds_of(plan);
    assert!(above > 20 && below > 4 * plan.dropped.len(), "{above}, {below}, {} not", plan.dropped.len());
    let text = write_apt(&ClProgram::of_plan("a", plan));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable");
    let workpiece = outcome.setup.allowances.workpiece_of(PUMP.clone());
    let verdict =
        verify(&workpiece, &outcome.setup, &program, &Monitor::default()).expect("it can be checked");
    assert_eq!(verdict.faults, []);
    assert_eq!(collisions(&program, &outcome.setup), []);
}

#[test]
fn an_outline_like_the_cylinder_is_the_cylinder() {
    let blank = |shape: &BlankShape| Blank::shaped(&PART, 0.0, shape);
    let turned = blank(&BlankShape::Turned);
    let corners: Vec<String> =
        turned.outline().expect("a cylinder").points().iter().map(|p| format!("{} {}", p.r, p.z)).collect();
    let folder = tempfile::tempdir().unwrap();
    let outline = format!("# by hand\n{}\n{}\n", corners.join("\n"), corners[0]);
    std::fs::write(folder.path().join("blank.txt"), outline).unwrap();
    let solid = SolidStock::new(&SolidBlank::from_part(&PART, &turned), 3.0).expect("it fits");
    let surface = StockSurface::from_stock(&solid);
    let stl = write_stl(&surface.points, &surface.triangles, "blank");
    std::fs::write(folder.path().join("blank.stl"), stl).unwrap();
    let path = folder.path().join("s.toml");
    for (file, tolerance) in [("blank.txt", 1e-9), ("blank.stl", 1.0)] {
        std::fs::write(&path, format!("[stock]\nblank = \"{file}\"\n")).unwrap();
        let setup = read_setup(&path, &Setup::default()).expect("reads");
        let other = blank(&setup.allowances.blank);
        for i in 0..400 {
            let p = Meridional { r: 0.6 * f64::from(i % 20) * 13.0, z: 12.0 * f64::from(i / 20) - 100.0 };
            let (a, b) = (turned.clearance(p, &mut None), other.clearance(p, &mut None));
            // The bore is filled in the envelope of neither; the solid has its edges within its spacing.
            assert!((a - b).abs() < tolerance, "{file}, {p:?}: {a} {b}");
        }
        let volume = |blank: &Blank| SolidBlank::from_part(&PART, blank).volume();
        let ratio = volume(&other) / volume(&turned);
        assert!((ratio - 1.0).abs() < 1e-2, "{file}: {ratio} of its volume");
        // Within a plan the outline is enough; beside another file the path is relative to that.
        let embedded = read_setup_bytes("elsewhere/plan.json (setup)", write_setup(&setup).as_bytes());
        assert_eq!(embedded.expect("reads without the file"), setup);
        let copy = folder.path().join("copy.toml");
        let text = write_setup_beside(&setup, &copy);
        assert!(text.contains(&format!("blank = \"{file}\"")) && !text.contains("outline"), "{text}");
        std::fs::write(&copy, text).unwrap();
        assert_eq!(read_setup(&copy, &Setup::default()).expect("reads"), setup);
    }
}

#[test]
fn blanks_that_do_not_fit_are_named_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let read = |name: &str| {
        std::fs::write(&path, format!("[stock]\nblank = \"{name}\"\n")).unwrap();
        read_setup(&path, &Setup::default())
    };
    file("one.txt", "10 20\n");
    file("nan.txt", "10 20\n\nnan 3\n");
    file("three.txt", "10 20\n10 20 30\n");
    file("behind.txt", "10 20\n-10 20\n");
    file("crossed.txt", "1 0\n5 4\n5 0\n1 6\n1 0\n");
    file(
        "open.stl",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                      endloop\nendfacet\nendsolid a\n",
    );
    for (name, words) in [
        ("none.txt", "s.toml:2: no blank file `none.txt`"),
        ("one.txt", "one.txt: the outline has 1 different points"),
        ("nan.txt", "nan.txt:3: "),
        ("three.txt", "three.txt:2: the line is not `r z`"),
        ("behind.txt", "behind.txt:2: r is negative"),
        ("crossed.txt", "crosses itself at r 3.400, z 2.400"),
        ("open.stl", "open.stl: is not closed"),
    ] {
        let error = read(name).expect_err(name).to_string();
        assert!(error.contains(words) && error.contains("; ") && !error.contains('\n'), "{name}: {error}");
    }
    // A blank that is too small in one place.
    let radius = PART.rim_radius();
    let narrow = radius - 2.0;
    file("small.txt", &format!("0 400\n{narrow} 400\n{narrow} -400\n"));
    let setup = read("small.txt").expect("it is an outline");
    let fault = setup.allowances.check_blank(&PART).expect_err("it is too small").to_string();
    assert!(fault.contains("2.00 mm outside") && fault.contains(&format!("r {radius:.2}")), "{fault}");
    assert!(Path::new(&path).is_file());
}
