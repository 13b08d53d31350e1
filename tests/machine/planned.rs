//! Plans that are made for a machine run on it, by every policy.

use std::path::Path;

use vanecut::io::nc::read_post;
use vanecut::io::part_file::read_part;
use vanecut::io::setup_file::read_setup_with_defaults;
use vanecut::job::post::{PostRequest, post_program};
use vanecut::job::{PlanRequest, run};
use vanecut::machine::{BlankSize, MachineTool, MotionOptions, OutputKind, PlacedPart, machine_program};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::plunge::{DropReason, LimitedBy};
use vanecut::setup::{AxisPolicy, Goal, Setup};
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
        let placed = PlacedPart::of(&machine.part, &part);
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

/// A plan for a machine has the time that its program takes there, and that time keeps to the limit of the goal: by
/// feeds and rapids alone the program took 17.3 min.
#[test]
fn goals_limit_the_time_on_the_machine() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let part = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let mut setup =
        read_setup_with_defaults("setup.toml", SETUP.as_bytes(), &Setup::for_part(&part)).expect("a setup");
    setup.machine.file = Some("ac-trunnion".to_owned());
    setup.plunge.sections[0].to = 0.8;
    setup.plunge.rest = false;
    setup.plunge.goal = Goal::Stock { max_time_min: Some(LIMIT_MIN) };
    let request = PlanRequest {
        part: part.clone().into(),
        setup,
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 64,
    };
    let outcome = run(&request, &Monitor::default()).expect("planned");
    assert!(!outcome.misses_goal);
    let program = ClProgram::of_plan(&part.name, &outcome.after.plan);
    let post = PostRequest {
        machine: machine("ac-trunnion"),
        post: read_post("heidenhain").unwrap(),
        output: OutputKind::TcpAngles,
        inlet_up: part.out_of_inlet().z > 0.0,
        blank: Some(BlankSize::of(&part, &outcome.setup.allowances)),
        calls: None,
    };
    let posted = post_program(&program, &post, &Monitor::default()).expect("posted").time_s();
    assert!(posted <= 60.0 * LIMIT_MIN * 1.001, "{posted} s");
    let planned = outcome.after.summary.time_s();
    assert!((planned - posted).abs() < 1e-3 * posted, "{planned} s planned, {posted} s posted");
    // Rapids alone leave out turns and accelerations.
    assert!(outcome.after.summary.time_estimate < 0.97 * posted);
}
