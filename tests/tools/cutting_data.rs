//! Feed rates, interruptions and lead-outs: in plans, in their programs, and as `verify` sees them.

use std::f64::consts::PI;
use std::path::Path;

use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::part_file::read_part;
use vanecut::io::{read_setup_with_defaults, write_setup};
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::{AxisPolicy, Setup};
use vanecut::toolpath::{ClProgram, Motion};
use vanecut::verify::{PlungeVerdict, verify};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/parts/{name}.toml"));
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

/// The outer half of a sample, planned by `minimal` with three teeth on a D 20, and the text of a setup.
fn planned(more: &str) -> PlanOutcome {
    let part = sample("impeller532");
    let text = format!(
        "{more}\n[[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.6\n\
         [[tool]]\nnumber = 1\ndiameter = 20\ninsert_width = 6.5\noverhang = 100\nteeth = 3\n"
    );
    let setup = read_setup_with_defaults("s.toml", text.as_bytes(), &Setup::for_part(&part)).expect("reads");
    let again = read_setup_with_defaults("s.toml", write_setup(&setup).as_bytes(), &Setup::for_part(&part));
    assert_eq!(again.expect("reads"), setup, "written and read");
    let request = PlanRequest {
        part: part.into(),
        setup,
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 64,
    };
    run(&request, &Monitor::default()).expect("a plan")
}

/// The program of a plan as it is written, and what `verify` says of it.
fn verified(outcome: &PlanOutcome) -> (ClProgram, PlungeVerdict) {
    let program = ClProgram::of_plan("wheel", &outcome.after.plan);
    let program = read_apt_bytes("p.apt", write_apt(&program).as_bytes()).expect("reads");
    let verdict =
        verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("is judged");
    (program, verdict)
}

#[test]
fn the_feed_rate_of_a_plunge_follows_its_engagement_and_material() {
    let outcome = planned("[stock]\nmaterial = \"titanium\"\n[plunge]");
    let tool = &outcome.after.plan.sections[0].tool;
    assert!((tool.spindle - 40e3 / (PI * 20.0)).abs() <= 0.5, "by the cutting speed of titanium");
    assert!((tool.plunge_feed - 0.08 * 3.0 * tool.spindle).abs() < 1e-9, "and its feed per tooth");
    let feed_per_tooth = |feed: f64| feed / (3.0 * tool.spindle);
    let (mut slow, mut fast) = (0, 0);
    for position in &outcome.after.plan.positions {
        let engagement = position.evaluation.engagement;
        let feed = position.evaluation.motion.feed_mm_per_min.expect("the teeth are known");
        assert!((0.05..=0.1).contains(&feed_per_tooth(feed)), "floor and ceiling: {}", feed_per_tooth(feed));
        if engagement.max_arc_rad > 4.5 {
            slow += 1;
            assert!(feed < tool.plunge_feed, "more than half is engaged");
        } else if engagement.max_arc_rad < 0.9 && !engagement.is_interrupted {
            fast += 1;
            assert!(feed > tool.plunge_feed, "little is engaged");
        }
    }
    assert!(slow > 0 && fast > 0, "{slow} with much engaged, {fast} with little engaged");
    let (program, verdict) = verified(&outcome);
    assert_eq!(verdict.faults.len(), 0, "{:?}", verdict.faults.first());
    let feeds = program.moves.iter().filter_map(|step| match step.motion {
        Motion::Feed(feed) => feed,
        Motion::Rapid => None,
    });
    for (feed, position) in feeds.zip(&outcome.after.plan.positions) {
        let planned = position.evaluation.motion.feed_mm_per_min.expect("a feed rate");
        assert!((feed - planned).abs() < 1e-5, "{feed} in the program, {planned} planned");
    }
    // The check measures engagement anew.
    for (found, planned) in verdict.cuts.iter().zip(&outcome.after.plan.positions) {
        let [found, planned] = [found.engagement, planned.evaluation.engagement].map(|e| e.max_arc_rad);
        assert!((found - planned).abs() < 0.4, "{found}, {planned} planned");
    }
}

#[test]
fn the_key_keeps_the_feed_rate_of_the_tool() {
    let outcome = planned("[plunge]\nadapt_feed = false");
    assert!(outcome.after.plan.positions.iter().all(|p| p.evaluation.motion.feed_mm_per_min.is_none()));
}

#[test]
fn deep_plunges_are_interrupted_and_stay_one_cut_each() {
    let outcome = planned("[plunge]\npeck = 10.0");
    let plan = &outcome.after.plan;
    let (program, verdict) = verified(&outcome);
    assert_eq!(verdict.faults.len(), 0, "{:?}", verdict.faults.first());
    assert_eq!(verdict.cuts.len(), plan.positions.len());
    for (found, planned) in verdict.cuts.iter().zip(&plan.positions) {
        assert!((found.tip - planned.tip).norm() < 2e-6);
    }
    let cuts = program.moves.iter().filter(|step| step.motion != Motion::Rapid).count();
    assert!(cuts > 2 * plan.positions.len(), "{cuts} moves for {} plunges", plan.positions.len());
    // Nothing goes down further at once.
    for pair in program.moves.windows(2) {
        if let Motion::Feed(_) = pair[1].motion
            && let Some(position) = plan.positions.iter().find(|p| (p.tip - pair[1].tip).norm() < 1e-5)
        {
            let pecking = position.evaluation.motion.pecking;
            let deep = (pair[0].tip - pair[1].tip).norm();
            assert!(pecking.is_none() || deep <= 10.5 + 1e-3, "{deep} mm at once");
        }
    }
}

#[test]
fn the_tool_leaves_the_stock_at_45_degrees_where_less_than_half_is_engaged() {
    let outcome = planned("[plunge]\nlead_out = 1.0");
    let plan = &outcome.after.plan;
    let mut lifted = 0;
    for position in &plan.positions {
        let (motion, engagement) = (position.evaluation.motion, position.evaluation.engagement);
        let way = motion.led_out(position.tip, &position.axis) - position.tip;
        if way.norm() == 0.0 {
            continue;
        }
        lifted += 1;
        assert!(engagement.bottom_arc_rad < PI, "{}", engagement.bottom_arc_rad);
        assert!((way.angle(&position.axis) - PI / 4.0).abs() < 1e-9, "at 45°");
        assert!(motion.lead_out.dot(&engagement.towards_stock) < 0.0, "away from the stock");
        assert!(motion.lead_out.norm() <= 1.0 + 1e-12);
    }
    assert!(lifted > plan.positions.len() / 4, "{lifted} of {}", plan.positions.len());
    let (program, verdict) = verified(&outcome);
    assert_eq!(verdict.faults.len(), 0, "{:?}", verdict.faults.first());
    assert_eq!(verdict.cuts.len(), plan.positions.len(), "a lead-out is not a cut");
    assert_eq!(program.moves.len(), 3 * plan.positions.len() + lifted);
    let same = |a: f64, b: f64| assert!((a - b).abs() < 5e-6, "{a}, {b}");
    for (found, planned) in verdict.cuts.iter().zip(&plan.positions) {
        same(found.hub_clearance, planned.hub_clearance);
        same(found.blade_clearance, planned.blade_clearance);
    }
}

#[test]
fn a_long_lead_out_ends_at_the_radius_of_the_cutter_and_hits_no_blade() {
    let outcome = planned("[plunge]\nlead_out = 1000.0");
    let ways = outcome.after.plan.positions.iter().map(|p| p.evaluation.motion.lead_out.norm());
    let longest = ways.fold(0.0, f64::max);
    assert!(longest > 0.0 && longest <= 10.0 + 1e-9, "{longest} mm");
    let (_, verdict) = verified(&outcome);
    assert_eq!(verdict.faults.len(), 0, "{:?}", verdict.faults.first());
}

#[test]
fn fine_interruptions_stay_within_their_plunge() {
    let outcome = planned("[stock]\nsafety_distance = 0.0\n[plunge]\npeck = 0.3");
    let plan = &outcome.after.plan;
    let (program, verdict) = verified(&outcome);
    assert!(program.moves.len() > 50 * plan.positions.len(), "{} moves", program.moves.len());
    assert_eq!(verdict.cuts.len(), plan.positions.len(), "each plunge counts once");
}

#[test]
fn a_lead_out_into_a_blade_is_found() {
    let outcome = planned("[plunge]\nlead_out = 1.0");
    let mut program = ClProgram::of_plan("wheel", &outcome.after.plan);
    // The first lead-out goes 60 mm to the other side.
    let k = (1..program.moves.len())
        .find(|&k| {
            let [before, step] = [&program.moves[k - 1], &program.moves[k]];
            step.motion != Motion::Rapid && before.motion != Motion::Rapid
        })
        .expect("a lead-out");
    let way = program.moves[k].tip - program.moves[k - 1].tip;
    let axis = program.moves[k].axis;
    let across = way - axis * way.dot(&axis);
    for step in &mut program.moves[k..=k + 1] {
        step.tip += -across.normalize() * 60.0 + axis * 60.0;
    }
    let program = read_apt_bytes("p.apt", write_apt(&program).as_bytes()).expect("reads");
    let verdict =
        verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("is judged");
    assert!(!verdict.faults.is_empty(), "through stock or a blade");
}
