//! Plans that are made for a machine run on it, by every policy.

use std::path::Path;

use vanecut::io::nc::read_post;
use vanecut::io::part_file::read_part;
use vanecut::io::setup_file::read_setup_with_defaults;
use vanecut::job::flank::{FlankJob, FlankRequest};
use vanecut::job::post::{PostRequest, post_program};
use vanecut::job::{PlanJob, PlanOutcome, PlanRequest, PolicyResult, run};
use vanecut::machine::{BlankSize, MachineTool, MotionOptions, OutputKind, PlacedPart, machine_program};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::plunge::{DropReason, LimitedBy};
use vanecut::setup::{AxisPolicy, ChannelOrder, ChannelSequence, ChannelSetup, Goal, SectionKind, Setup};
use vanecut::toolpath::ClProgram;

use super::programs::machine;

const SETUP: &str = "[plunge]\nstep = 12\nstepover = 14\n[[plunge.section]]\ntool = 52\nfrom = 1\nto = 0\n\
    [[tool]]\nnumber = 52\ndiameter = 12\ncorner_radius = 0.8\ninsert_width = 4\noverhang = 60\n";

/// Limit of time of a channel, min.
const LIMIT_MIN: f64 = 15.0;

/// Plans pump6 for `machine` by all policies and posts the plans; returns how many plunges are left out for
/// it, and how many are limited by it.
fn check(machine: &MachineTool) -> (usize, usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let part = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let mut setup =
        read_setup_with_defaults("setup.toml", SETUP.as_bytes(), &Setup::for_part(&part)).expect("a setup");
    setup.machine.max_axis_tilt_rad = machine.max_axis_tilt_rad();
    let request = PlanRequest {
        part: part.clone().into(),
        setup: setup.clone(),
        policy: AxisPolicy::Minimal,
        compare: true,
        field_cells: 64,
    };
    let outcome = run(&request, &Monitor::default()).expect("planned");
    let post = read_post("fanuc").unwrap();
    let (mut left_out, mut limited, mut policies) = (0, 0, 0);
    for result in outcome.policies() {
        let plan = &result.plan;
        policies += 1;
        for position in &plan.positions {
            assert!(setup.machine.excess_tilt_rad(&part, &position.axis) <= 1e-9, "{:?}", plan.policy);
        }
        left_out += plan.dropped.iter().filter(|dropped| dropped.why == DropReason::Machine).count();
        limited += plan.positions.iter().filter(|p| p.limited_by == Some(LimitedBy::Machine)).count();
        let program = ClProgram::of_plan(&part.name, plan);
        let placed = PlacedPart::from_placement(&machine.part, &part);
        for output in OutputKind::ALL {
            let options = MotionOptions::new(output, post.format.angle_decimals);
            let motion = machine_program(machine, &placed, &program, &options, &Monitor::default());
            assert!(motion.is_ok(), "{:?} {}: {:?}", plan.policy, output.name(), motion.err());
        }
    }
    assert_eq!(policies, 4);
    (left_out, limited)
}

#[test]
fn no_policy_plans_what_the_machine_does_not_reach() {
    let (left_out, _) = check(&machine("nutating-table"));
    assert!(left_out > 0, "conventional axes go beyond 90°");
    let mut narrow = machine("b-head-c-table");
    narrow.rotary[1].limits = Some((-30f64.to_radians(), 60f64.to_radians()));
    let (left_out, limited) = check(&narrow);
    assert!(left_out > 0 && limited > 0, "{left_out} left out, {limited} limited");
    assert_eq!(check(&machine("ac-trunnion")), (0, 0));
}

/// pump6 with few plunges of a short section, planned for the trunnion.
fn short_request(policy: AxisPolicy, compare: bool) -> PlanRequest {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let part = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let mut setup =
        read_setup_with_defaults("setup.toml", SETUP.as_bytes(), &Setup::for_part(&part)).expect("a setup");
    setup.machine.file = Some("ac-trunnion".to_owned());
    setup.plunge.sections[0].to = 0.8;
    setup.plunge.rest = false;
    PlanRequest { part: part.into(), setup, policy, compare, field_cells: 64 }
}

/// Time of a program as `post` gives it, s.
fn posted_s(program: &ClProgram, part: &Impeller, setup: &Setup) -> f64 {
    let post = PostRequest {
        machine: machine("ac-trunnion"),
        post: read_post("heidenhain").unwrap(),
        output: OutputKind::TcpAngles,
        inlet_up: part.out_of_inlet().z > 0.0,
        blank: Some(BlankSize::from_part(part, &setup.allowances)),
        calls: None,
    };
    post_program(program, &post, &Monitor::default()).expect("posted").time_s()
}

/// A plan for a machine has the time that its program takes there, and that time keeps to the limit of the
/// goal: by feeds and rapids alone the program took 17.3 min.
#[test]
fn goals_limit_the_time_on_the_machine() {
    let mut request = short_request(AxisPolicy::Minimal, false);
    request.setup.plunge.goal = Goal::Stock { max_time_min: Some(LIMIT_MIN) };
    let outcome = run(&request, &Monitor::default()).expect("planned");
    assert!(!outcome.misses_goal);
    let program = ClProgram::of_plan(&request.part.name, &outcome.after.plan);
    let posted = posted_s(&program, &request.part, &outcome.setup);
    assert!(posted <= 60.0 * LIMIT_MIN * 1.001, "{posted} s");
    let planned = outcome.after.summary.time_s();
    assert!((planned - posted).abs() < 1e-3 * posted, "{planned} s planned, {posted} s posted");
    // Rapids alone leave out turns and accelerations.
    assert!(outcome.after.summary.time_estimate < 0.97 * posted);
}

/// The time of the wheel is that of the program of all channels, with the links between them and, where a
/// section opens the stock, the plunges that neighbours share. Left out are retracts that links over the
/// blank between two channels raise: where it stands above the shroud they come to more.
#[test]
fn the_time_of_the_wheel_is_that_of_its_program() {
    let [by_tool, by_channel] = ChannelOrder::ALL;
    let [adjacent, opposite] = ChannelSequence::ALL;
    // The order of the channels does not change the plan of one: the job has it from the case before.
    let (job, short) = (PlanJob::default(), short_request(AxisPolicy::Monotone, false));
    for (blank, order, sequence) in [
        ("edges", by_tool, adjacent),
        ("edges", by_tool, opposite),
        ("edges", by_channel, opposite),
        ("turned", by_tool, adjacent),
        ("turned", by_channel, opposite),
    ] {
        let mut request = short.clone();
        if blank == "turned" {
            let text = "[stock]\nblank = \"turned\"\n[plunge]\nstep = 12\nstepover = 14\n[[tool]]\nnumber = 52\n\
                diameter = 12\ncorner_radius = 0.8\ninsert_width = 4\noverhang = 120\n";
            let defaults = Setup::for_part(&request.part);
            request.setup = read_setup_with_defaults("s.toml", text.as_bytes(), &defaults).expect("a setup");
            request.setup.machine.file = Some("ac-trunnion".to_owned());
            request.setup.plunge.rest = false;
        }
        request.setup.channels = ChannelSetup { order, sequence };
        let outcome = job.run(&request, &Monitor::default()).expect("planned");
        let (result, part) = (&outcome.after, &request.part);
        let place = format!("{blank}, {}", request.setup.channels.words());
        let opens = result.plan.sections.iter().any(|section| section.kind == SectionKind::Opening);
        assert_eq!(opens, blank == "turned");
        let channels = part.blade_count;
        let program = outcome.program_for_channels(result, channels, &Monitor::default()).expect("planned");
        let posted = posted_s(&program, part, &outcome.setup);
        let planned = result.summary.time_of_channels_s(channels, channels);
        assert!((planned - posted).abs() < 1e-6 * posted, "{place}: {planned} s planned, {posted} s posted");
        assert_eq!(result.summary.time_of_channels_s(1, channels), result.summary.time_s());
    }
}

/// A plan that the machine cannot run has no time, where it runs the one that was asked for.
#[test]
fn plans_that_the_machine_refuses_have_no_time() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own.toml");
    let mut request = short_request(AxisPolicy::Minimal, true);
    let tilts = |request: &PlanRequest| {
        let outcome = run(request, &Monitor::default()).expect("planned");
        let out = request.part.out_of_inlet();
        let steepest = |result: &PolicyResult| {
            result.plan.positions.iter().map(|p| p.axis.angle(&out).to_degrees()).fold(0.0, f64::max)
        };
        let steepest = outcome.policies().into_iter().map(|r| (r.plan.policy, steepest(r))).collect();
        (outcome, steepest)
    };
    let (outcome, steepest): (PlanOutcome, Vec<(AxisPolicy, f64)>) = tilts(&request);
    assert!(outcome.policies().iter().all(|result| !result.summary.is_refused));
    let of = |policy| steepest.iter().find(|(own, _)| *own == policy).unwrap().1;
    let (asked, other) = (of(AxisPolicy::Minimal), of(AxisPolicy::Monotone));
    assert!(other > asked + 1.0, "the other plan is steeper: {steepest:?}");
    // The planner may tilt as far as before, the machine may not.
    let limit = format!("[-{0:?}, {0:?}]", 0.5 * (asked + other));
    let text = include_str!("../../assets/machines/ac-trunnion.toml").replace("[-120, 120]", &limit);
    std::fs::write(&own, text).unwrap();
    request.setup.machine.file = Some(own.to_string_lossy().into_owned());
    let outcome = run(&request, &Monitor::default()).expect("planned");
    assert!(outcome.after.summary.machine_time.is_some());
    let refused: Vec<AxisPolicy> =
        outcome.policies().iter().filter(|r| r.summary.is_refused).map(|r| r.plan.policy).collect();
    assert_eq!(refused, [AxisPolicy::Monotone], "{steepest:?}");
    for result in outcome.policies() {
        let summary = &result.summary;
        assert_eq!(summary.is_refused, summary.time_s().is_nan(), "{:?}", result.plan.policy);
        assert_eq!(summary.is_refused, summary.machine_time.is_none(), "{:?}", result.plan.policy);
    }
}

/// A flank plan has the time of its program on the machine, the plunges that open the stock among it.
#[test]
fn flank_plans_have_the_time_of_their_program() {
    let mut request = short_request(AxisPolicy::Monotone, false);
    let text = "[stock]\nblank = \"turned\"\n[flank]\nlayer_depth = 30\nscheme = \"layers\"\n\
        scallop_height = 3\n[machine]\nfile = \"ac-trunnion\"\n";
    let defaults = Setup::for_part(&request.part);
    request.setup = read_setup_with_defaults("s.toml", text.as_bytes(), &defaults).expect("a setup");
    let request = FlankRequest { part: request.part, setup: request.setup };
    let outcome = FlankJob::default().run(&request, &Monitor::default()).expect("planned");
    assert!(outcome.plan.opening.is_some(), "the stock stands above the shroud");
    let posted = posted_s(&outcome.program(), &request.part, &outcome.setup);
    assert!((outcome.time_s() - posted).abs() < 1e-3 * posted, "{} s, {posted} s posted", outcome.time_s());
    assert!(outcome.time_estimate < posted && outcome.time_estimate > outcome.plan.times.total());
}
