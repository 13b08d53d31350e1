//! Goals of a plan, and the curve of time against stock.

use std::sync::LazyLock;

use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::setup_file::{read_setup_bytes, write_setup};
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::plunge::PlungePlan;
use vanecut::setup::{AxisPolicy, Goal, Setup};
use vanecut::stock::{field_cutters, residual_field};
use vanecut::toolpath::ClProgram;
use vanecut::tradeoff::{Thinning, ThinningInput, ThinningLimits};
use vanecut::verify::verify;

use super::samples::sample;

/// Rough settings, so that the plan is small.
const TOOL: &str = "[[tool]]\nnumber = 1\ndiameter = 20\ninsert_width = 6\noverhang = 90\n";
const SECTION: &str = "[[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.55\n";

fn setup(goal: &str) -> Setup {
    let text = format!("{TOOL}[plunge]\n{goal}\n{SECTION}");
    read_setup_bytes("s.toml", text.as_bytes()).expect("a setup")
}

fn planned(setup: Setup) -> PlanOutcome {
    let request = PlanRequest {
        part: sample("pump6").into(),
        setup,
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 128,
    };
    run(&request, &Monitor::default()).expect("a plan")
}

pub static WHOLE: LazyLock<PlanOutcome> = LazyLock::new(|| planned(setup("")));

/// Faults of the program of a plan.
fn faults(outcome: &PlanOutcome, plan: &PlungePlan) -> Vec<String> {
    let text = write_apt(&ClProgram::of_plan(&outcome.workpiece.part.name, plan));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable");
    let verdict = verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("judged");
    verdict.faults.into_iter().map(|fault| fault.to_string()).collect()
}

#[test]
fn every_point_of_the_curve_is_a_sound_plan() {
    let curve = WHOLE.time_stock_curve(5, &Monitor::default()).expect("not cancelled");
    assert!(curve.len() >= 4, "{} points", curve.len());
    let whole = WHOLE.whole.as_ref().expect("some plunges are not worth their time");
    assert_eq!(curve[0].plan.positions.len(), whole.positions.len());
    for pair in curve.windows(2) {
        let (slow, fast) = (&pair[0].summary, &pair[1].summary);
        assert!(fast.time_estimate < slow.time_estimate && fast.positions < slow.positions);
        assert!(fast.residual_mean >= slow.residual_mean - 1e-6, "less stock in less time");
    }
    for point in &curve {
        assert_eq!(
            faults(&WHOLE, &point.plan),
            Vec::<String>::new(),
            "{} plunges",
            point.plan.positions.len()
        );
        assert!(point.summary.uncut_share <= WHOLE.after.summary.uncut_share + 0.0015);
    }
    let (whole, fast) = (&curve[0].summary, &curve[curve.len() - 1].summary);
    assert!(
        fast.time_estimate < 0.75 * whole.time_estimate,
        "{} of {}",
        fast.time_estimate,
        whole.time_estimate
    );
}

#[test]
fn stock_after_leaving_plunges_out_is_that_of_the_field() {
    let plan = WHOLE.whole.as_ref().expect("some plunges are not worth their time");
    let input = ThinningInput {
        plan,
        setup: &WHOLE.setup,
        blank: &WHOLE.workpiece.blank,
        grid: &WHOLE.grid,
        limits: ThinningLimits::LEAST_TIME,
    };
    let thinning = Thinning::new(input, &Monitor::default()).expect("not cancelled");
    let again = Thinning::new(input, &Monitor::default()).expect("not cancelled");
    assert!(!thinning.is_empty());
    for count in [0, thinning.len() / 3, thinning.len()] {
        let kept = thinning.kept_without(count);
        assert_eq!(kept, again.kept_without(count), "the same order twice");
        assert_eq!(kept.iter().filter(|kept| !**kept).count(), count);
        let cutters: Vec<_> = field_cutters(plan)
            .into_iter()
            .zip(&kept)
            .filter(|(_, kept)| **kept)
            .map(|(cutter, _)| cutter)
            .collect();
        let field = residual_field(&WHOLE.grid, &cutters);
        let brute = vanecut::stock::statistics(&WHOLE.grid, &field.heights, |_| true);
        let found = thinning.stock_without(count);
        assert!((brute.mean - found.mean).abs() < 1e-4 && (brute.p95 - found.p95).abs() < 1e-3, "{count}");
        assert!((brute.uncut_share - found.uncut_share).abs() < 1e-5, "{count}");
    }
}

#[test]
fn the_least_stock_takes_no_plunge_that_buys_nothing() {
    let curve = WHOLE.time_stock_curve(2, &Monitor::default()).expect("not cancelled");
    let (whole, plan) = (&curve[0].summary, &WHOLE.after.summary);
    let allowance = WHOLE.setup.allowances.hub_allowance;
    let above = |figure: f64| figure - allowance;
    assert!(plan.positions < whole.positions && plan.time_estimate < 0.95 * whole.time_estimate);
    // 2 %, and what the coarser cells of the choice miss.
    assert!(above(plan.residual_mean) <= 1.03 * above(whole.residual_mean));
    assert!(above(plan.residual_p95) <= 1.03 * above(whole.residual_p95));
    assert_eq!(faults(&WHOLE, &WHOLE.after.plan), Vec::<String>::new());
}

#[test]
fn goals_keep_their_limits() {
    let whole = &WHOLE.after.summary;
    let minutes = whole.time_estimate / 60.0;
    let allowance = WHOLE.setup.allowances.hub_allowance;

    let within = planned(setup(&format!("goal = \"stock\"\nmax_time = {}", 0.8 * minutes)));
    let time = within.after.summary.time_estimate / 60.0;
    assert!(time <= 0.81 * minutes && time > 0.7 * minutes, "{time} of {minutes} min");

    let limit = 1.3 * (whole.residual_p95 - allowance);
    let fast = planned(setup(&format!("goal = \"time\"\nmax_stock = {limit}")));
    let stock = fast.after.summary.residual_p95 - allowance;
    assert!(stock <= limit + 1e-3, "{stock} of {limit} mm");
    assert!(fast.after.summary.time_estimate < 0.9 * whole.time_estimate);

    let balance = planned(setup("goal = \"balance\""));
    assert!(balance.after.summary.time_estimate < whole.time_estimate);
    for outcome in [&within, &fast, &balance] {
        assert_eq!(faults(outcome, &outcome.after.plan), Vec::<String>::new());
        let read = read_setup_bytes("s.toml", write_setup(&outcome.setup).as_bytes()).expect("reads back");
        assert_eq!(read.plunge.goal, outcome.setup.plunge.goal);
    }
    assert_eq!(balance.setup.plunge.goal, Goal::Balance);
}

#[test]
fn goals_that_make_no_sense_are_refused_with_their_line() {
    for (text, words) in [
        ("goal = \"fast\"", "use \"stock\", \"time\" or \"balance\""),
        ("goal = \"time\"", "add `max_stock`"),
        ("goal = \"time\"\nmax_stock = 1.0\nmax_time = 5", "remove `max_time`"),
        ("goal = \"balance\"\nmax_stock = 1.0", "remove `max_stock`"),
        ("max_stock = 1.0", "add the goal"),
        ("max_time = 0", "greater than 0"),
    ] {
        let error =
            read_setup_bytes("s.toml", format!("[plunge]\n{text}\n").as_bytes()).expect_err(text).to_string();
        assert!(error.starts_with("s.toml:") && error.contains(words), "{text}: {error}");
    }
}
