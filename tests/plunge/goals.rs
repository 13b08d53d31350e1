//! Goals of a plan, and the curve of time against stock.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::setup_file::{read_setup_bytes, write_setup};
use vanecut::job::{PlanJob, PlanOutcome, PlanRequest, PolicyResult, run};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::plunge::{AddedPlunges, PlungePlan, RowDensity};
use vanecut::report::words::missed_goal;
use vanecut::setup::{AxisPolicy, Goal, PlungePose, SemiFinishing, Setup};
use vanecut::stock::{field_cutters, residual_field};
use vanecut::toolpath::ClProgram;
use vanecut::tradeoff::{Thinning, ThinningInput, ThinningLimits, Tradeoff};
use vanecut::verify::verify;

use super::samples::{sample, sample_job, sample_plans};

/// Rough settings, so that the plan is small.
const TOOL: &str = "[[tool]]\nnumber = 1\ndiameter = 20\ninsert_width = 6\noverhang = 90\n";
const SECTION: &str = "[[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.55\n";

fn setup(goal: &str) -> Setup {
    let text = format!("{TOOL}[plunge]\n{goal}\n{SECTION}");
    read_setup_bytes("s.toml", text.as_bytes()).expect("a setup")
}

fn planned(setup: Setup) -> PlanOutcome {
    // Goals share the search.
    static JOB: LazyLock<(PlanJob, Arc<Impeller>)> =
        LazyLock::new(|| (PlanJob::default(), sample("pump6").into()));
    let (job, part) = &*JOB;
    let request = PlanRequest {
        part: Arc::clone(part),
        setup,
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 128,
    };
    job.run(&request, &Monitor::default()).expect("a plan")
}

pub static WHOLE: LazyLock<PlanOutcome> = LazyLock::new(|| planned(setup("")));

/// Five points of its curve.
static CURVE: LazyLock<Vec<PolicyResult>> =
    LazyLock::new(|| WHOLE.time_stock_curve(5, &Monitor::default()).expect("not cancelled"));

/// A plan with a limit of time that none meets.
static HASTY: LazyLock<PlanOutcome> = LazyLock::new(|| planned(setup("goal = \"stock\"\nmax_time = 1")));

/// What the search found, before plunges are left out for the goal.
fn searched(outcome: &PlanOutcome) -> &PlungePlan {
    outcome.whole.as_ref().unwrap_or(&outcome.after.plan)
}

/// A sample planned with the defaults and a goal.
fn planned_sample(name: &str, goal: &str, field_cells: usize) -> PlanOutcome {
    let (job, part) = sample_job(name);
    let setup = read_setup_bytes("s.toml", format!("[plunge]\n{goal}\n").as_bytes()).expect("a setup");
    let (part, policy) = (Arc::clone(part), AxisPolicy::Minimal);
    let request = PlanRequest { part, setup, policy, compare: false, field_cells };
    job.run(&request, &Monitor::default()).expect("a plan")
}

/// Faults of the program of a plan.
fn faults(outcome: &PlanOutcome, plan: &PlungePlan) -> Vec<String> {
    let text = write_apt(&ClProgram::of_plan(&outcome.workpiece.part.name, plan));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable");
    let verdict = verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("judged");
    verdict.faults.into_iter().map(|fault| fault.to_string()).collect()
}

#[test]
fn every_point_of_the_curve_is_a_sound_plan() {
    let curve = &*CURVE;
    assert!(curve.len() >= 4, "{} points", curve.len());
    let whole = WHOLE.whole.as_ref().expect("some plunges are not worth their time");
    // It begins with the whole plan, unless one with fewer rows leaves no more stock.
    let (first, kept) = (&curve[0], &WHOLE.after.summary);
    assert!(first.plan.positions.len() <= whole.positions.len());
    assert!(first.summary.residual_mean <= kept.residual_mean + 1e-6, "{:?} mm", first.summary.residual_mean);
    for pair in curve.windows(2) {
        let (slow, fast) = (&pair[0].summary, &pair[1].summary);
        assert!(fast.time_estimate < slow.time_estimate);
        assert!(fast.residual_mean >= slow.residual_mean - 1e-6, "less stock in less time");
    }
    // Convex within 3 %: no point is above the chord between any two others.
    let at = |k: usize| (curve[k].summary.time_estimate, curve[k].summary.residual_p95);
    for k in 0..curve.len() {
        for (a, b) in (0..k).flat_map(|a| (k + 1..curve.len()).map(move |b| (a, b))) {
            let ((t, p95), (from, most), (to, least)) = (at(k), at(a), at(b));
            let chord = most + (least - most) * (t - from) / (to - from);
            assert!(p95 <= 1.03 * chord, "point {k} leaves {p95} mm, the chord {a} to {b} {chord}");
        }
    }
    for point in curve {
        assert_eq!(
            faults(&WHOLE, &point.plan),
            Vec::<String>::new(),
            "{} plunges",
            point.plan.positions.len()
        );
        // The section ends half-way, so that .1 % more is the limit; and what the coarser cells miss.
        let (uncut, of_whole) = (point.summary.uncut_share, WHOLE.after.summary.uncut_share);
        assert!(uncut <= of_whole + 0.0015, "{uncut} is uncut, {of_whole} of the whole plan");
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
    let [thinning, again] = [(); 2].map(|()| thinned(ThinningLimits::LEAST_TIME));
    assert!(!thinning.is_empty());
    for count in [0, thinning.len() / 3, thinning.len()] {
        let kept = thinning.kept_without(count);
        assert_eq!(kept, again.kept_without(count), "the same order twice");
        assert_eq!(kept.iter().filter(|kept| !**kept).count(), count);
        let cutters: Vec<_> = field_cutters(thinning.plan())
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

/// The order in which the plunges of [`WHOLE`] go.
fn thinned(limits: ThinningLimits) -> Thinning<'static> {
    thinned_around(limits, &[])
}

/// The same, where the `locked` plunges stay.
fn thinned_around(limits: ThinningLimits, locked: &'static [PlungePose]) -> Thinning<'static> {
    let plan = WHOLE.whole.as_ref().expect("some plunges are not worth their time");
    let (setup, blank, grid) = (&WHOLE.setup, &WHOLE.workpiece.blank, &*WHOLE.grid);
    let clock = &*WHOLE.clock;
    Thinning::new(ThinningInput { plan, setup, blank, grid, limits, locked, clock }, &Monitor::default())
        .expect("not cancelled")
}

#[test]
fn locked_plunges_stay() {
    static LOCKED: LazyLock<Vec<PlungePose>> = LazyLock::new(|| {
        let thinning = thinned(ThinningLimits::LEAST_TIME);
        let kept = thinning.kept_without(5);
        let left_out = thinning.plan().positions.iter().zip(kept).filter(|(_, kept)| !kept);
        left_out.map(|(p, _)| PlungePose { tip: p.tip, axis: p.axis }).collect()
    });
    assert_eq!(LOCKED.len(), 5, "those that go first");
    let thinning = thinned_around(ThinningLimits::LEAST_TIME, &LOCKED);
    let kept = thinning.kept_without(thinning.len());
    let stays = |locked: &PlungePose| {
        let mut positions = thinning.plan().positions.iter().zip(&kept);
        positions.any(|(p, kept)| *kept && locked.is(&PlungePose { tip: p.tip, axis: p.axis }))
    };
    assert!(LOCKED.iter().all(stays));
}

#[test]
fn rows_beside_walls_keep_their_scallop_and_added_plunges_go() {
    let thinning = thinned(ThinningLimits::LEAST_TIME);
    let (plan, kept) = (thinning.plan(), thinning.kept_without(thinning.len()));
    let (mut left_out, mut added_gone) = (0, 0);
    for (index, section) in plan.sections.iter().enumerate() {
        let of_section: Vec<usize> =
            (0..plan.positions.len()).filter(|&k| plan.positions[k].section == index).collect();
        let (rows, added) = of_section.split_at(of_section.len() - section.added.expect("minimal").count);
        let on_wall = |k: &&usize| [0.0, 1.0].contains(&plan.positions[**k].lambda);
        added_gone += added.iter().filter(on_wall).filter(|k| !kept[**k]).count();
        for wall in [0.0, 1.0] {
            let mut row: Vec<usize> =
                rows.iter().copied().filter(|&k| plan.positions[k].lambda == wall).collect();
            row.sort_by(|&a, &b| plan.positions[a].s.total_cmp(&plan.positions[b].s));
            let step = |pair: &[usize]| (plan.positions[pair[0]].tip - plan.positions[pair[1]].tip).norm();
            let widest = |row: &[usize]| row.windows(2).map(step).fold(0.0, f64::max);
            let still: Vec<usize> = row.iter().copied().filter(|&k| kept[k]).collect();
            left_out += row.len() - still.len();
            // S = 2·√(2Rh − h²) with R = 10 mm and the default h = 0.6 mm; the whole plan may exceed it.
            let scallop = 2.0 * (2.0 * 10.0 * 0.6 - 0.6 * 0.6_f64).sqrt();
            assert!(widest(&still) <= widest(&row).max(scallop) + 1e-9, "wall {wall}: {}", widest(&still));
            assert_eq!((still.first(), still.last()), (row.first(), row.last()));
        }
    }
    assert!(added_gone > 0, "no added plunge beside a wall may go ({left_out} of the rows did)");
}

#[test]
fn less_time_beats_the_published_rule() {
    let name = "impeller532";
    let outcome = sample_plans(name);
    let allowance = outcome.setup.allowances.hub_allowance;
    let by_rule = |result: &&PolicyResult| result.plan.policy == AxisPolicy::Monotone;
    let policies = outcome.policies();
    let monotone = &policies.into_iter().find(by_rule).expect("all policies were planned").summary;
    let excess = monotone.residual_p95 - allowance;

    let in_its_time = format!("goal = \"stock\"\nmax_time = {}", monotone.time_estimate / 60.0);
    let in_its_time = planned_sample(name, &in_its_time, 512);
    let summary = &in_its_time.after.summary;
    assert!(summary.time_estimate <= monotone.time_estimate);
    assert!(summary.residual_p95 - allowance <= 0.75 * excess, "{} of {excess} mm", summary.residual_p95);

    let with_its_stock = planned_sample(name, &format!("goal = \"time\"\nmax_stock = {excess}"), 512);
    let summary = &with_its_stock.after.summary;
    let share = summary.time_estimate / monotone.time_estimate;
    assert!(summary.residual_p95 - allowance <= excess + 0.01 && share <= 0.8, "{share} of the time");
    for outcome in [&in_its_time, &with_its_stock] {
        assert!(outcome.after.summary.interfering == 0 && outcome.after.summary.uncut_share <= 0.0105);
        assert_eq!(faults(outcome, &outcome.after.plan), Vec::<String>::new());
    }
}

#[test]
#[ignore = "two plans of a sample, 34 s; scripts/nightly runs it"]
fn much_less_time_takes_fewer_rows() {
    let outcome = planned_sample("impeller9x9", "goal = \"time\"\nmax_stock = 2", 128);
    assert_eq!(outcome.density, RowDensity::Sparse);
    let whole = outcome.whole.as_ref().expect("plunges are left out");
    assert!(3 * outcome.after.plan.positions.len() < whole.positions.len(), "{}", whole.positions.len());
    assert_eq!(faults(&outcome, &outcome.after.plan), Vec::<String>::new());
}

#[test]
fn a_stop_while_fewer_rows_are_planned_keeps_a_sound_plan_that_is_marked() {
    let setup = read_setup_bytes("s.toml", b"[plunge]\ngoal = \"time\"\nmax_stock = 1.5\n").expect("a setup");
    let part = sample("impeller532").into();
    let request = PlanRequest { part, setup, policy: AxisPolicy::Minimal, compare: false, field_cells: 128 };
    let (monitor, done) = (Monitor::default(), AtomicBool::new(false));
    let outcome = std::thread::scope(|scope| {
        // The first planning ends at .6.
        scope.spawn(|| {
            while monitor.progress() < 0.63 && !done.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
            monitor.stop();
        });
        let outcome = run(&request, &monitor);
        done.store(true, Ordering::Relaxed);
        outcome.expect("a stop ends with the best plan so far")
    });
    assert!(monitor.is_stopped() && outcome.after.plan.is_unfinished());
    assert!(outcome.after.summary.interfering == 0 && outcome.after.summary.uncut_share <= 0.0105);
    assert_eq!(faults(&outcome, &outcome.after.plan), Vec::<String>::new());
}

#[test]
fn the_least_stock_takes_no_plunge_that_buys_nothing() {
    let (whole, plan) = (&CURVE[0].summary, &WHOLE.after.summary);
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
    assert!(time <= 0.8 * minutes && time > 0.7 * minutes, "{time} of {minutes} min");

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

/// No other point of the curve has a shorter total time. The slower semi-finishing is, the more plunges are
/// kept.
#[test]
#[ignore = "three plans and a curve; scripts/nightly runs it"]
fn the_least_total_counts_what_semi_finishing_takes() {
    let mut times = Vec::new();
    // The goal picks a point of the curve, and changes none.
    let curve = WHOLE.time_stock_curve(9, &Monitor::default()).expect("not cancelled");
    for keys in ["finish_rate = 100", "finish_rate = 1000", "finish_rate = 1e6"] {
        let outcome = planned(setup(&format!("goal = \"total\"\n{keys}")));
        let total = |result: &PolicyResult| {
            result.summary.time_s() + outcome.finishing_time_s(result).expect("the goal counts it")
        };
        let least = total(&outcome.after);
        assert!(searched(&outcome) == searched(&WHOLE), "{keys}: the curve is that of another plan");
        for point in &curve {
            // Links of a finished plan take a little longer than those that are weighed.
            let other = total(point);
            assert!(least <= 1.01 * other, "{keys}: {least} s, {other} s with {} s", point.summary.time_s());
        }
        assert_eq!(faults(&outcome, &outcome.after.plan), Vec::<String>::new());
        let read = read_setup_bytes("s.toml", write_setup(&outcome.setup).as_bytes()).expect("reads back");
        assert_eq!(read.plunge.goal, outcome.setup.plunge.goal);
        times.push(outcome.after.summary.time_s());
    }
    assert!(times.windows(2).all(|pair| pair[0] >= pair[1]) && times[0] > 1.3 * times[2], "{times:?}");
    assert_eq!(WHOLE.finishing_time_s(&WHOLE.after), None, "other goals do not count it");
}

/// Against every plan of the order, by rate and by passes.
#[test]
fn the_least_total_is_that_of_all_plans() {
    let allowance = WHOLE.setup.allowances.hub_allowance;
    let tradeoff = Tradeoff::new(thinned(ThinningLimits::LEAST_TIME));
    let thinning = tradeoff.thinning(0);
    let plan =
        |count: usize| (thinning.time_without(count), thinning.stock_without(count).excess_above(allowance));
    let plans: Vec<_> = (0..=thinning.len()).map(plan).collect();
    for finishing in [
        SemiFinishing::Rate { mm3_per_min: 150.0 },
        SemiFinishing::Rate { mm3_per_min: 2000.0 },
        SemiFinishing::Passes { depth: 0.21, pass_time_min: 1.5 },
        SemiFinishing::Passes { depth: 0.4, pass_time_min: 0.3 },
    ] {
        let total = |count: usize| {
            let (time_s, excess) = &plans[count];
            time_s + finishing.time_s(excess.volume, excess.p95)
        };
        let least = (0..plans.len()).map(total).fold(f64::INFINITY, f64::min);
        let chosen = tradeoff.choose(Goal::Total { finishing });
        let found = total(chosen.left_out);
        assert!(found <= 1.002 * least, "{finishing:?}: {found} s, {least} s without {}", chosen.left_out);
    }
}

/// What is left is measured anew on the finished plan: volume above the allowance by the rate, and passes by
/// the height of the 95th percentile.
#[test]
fn semi_finishing_goes_by_volume_or_by_passes() {
    let by_rate = planned(setup("goal = \"total\"\nfinish_rate = 500"));
    let (grid, heights) = (&by_rate.grid, &by_rate.after.field.heights);
    let allowance = by_rate.setup.allowances.hub_allowance;
    let cells = (0..heights.len()).filter(|&cell| grid.floor[cell] && grid.reachable[cell]);
    let volume: f64 =
        cells.map(|cell| f64::from(grid.areas[cell]) * (f64::from(heights[cell]) - allowance)).sum();
    let found = by_rate.finishing_time_s(&by_rate.after).expect("counted");
    assert!((found - 60.0 * volume / 500.0).abs() < 1e-3 * found, "{found} s for {volume} mm³");

    let by_pass = planned(setup("goal = \"total\"\nfinish_depth = 0.4\nfinish_pass_time = 3"));
    let excess = by_pass.after.summary.residual_p95 - allowance;
    let found = by_pass.finishing_time_s(&by_pass.after).expect("counted");
    assert_eq!(found, 180.0 * (excess / 0.4).ceil(), "{excess} mm");
}

#[test]
fn a_goal_that_cannot_be_met_is_reported_with_what_is_reached() {
    let millimetres = |mm: f64| format!("{mm:.3} mm");
    assert_eq!(missed_goal(&WHOLE, millimetres), None, "the least stock, whatever it takes");
    let hasty = &*HASTY;
    let minutes = hasty.after.summary.time_estimate / 60.0;
    let expected =
        format!("goal cannot be met: the fastest plan takes {minutes:.1} min, the limit is 1.0 min");
    assert_eq!(missed_goal(hasty, millimetres), Some(expected));
    let mut stopped = hasty.clone();
    let last = stopped.after.plan.sections.last_mut().expect("a section");
    last.added = Some(AddedPlunges::UNFINISHED);
    assert_eq!(missed_goal(&stopped, millimetres), None, "the finished plan may meet it");
    assert!(minutes < 0.75 * WHOLE.after.summary.time_estimate / 60.0, "it comes near: {minutes} min");
    let bare = planned(setup("goal = \"time\"\nmax_stock = 0.001"));
    let words = missed_goal(&bare, millimetres).expect("no plan leaves as little");
    let least = bare.after.summary.residual_p95 - bare.setup.allowances.hub_allowance;
    assert!(words.contains(&format!("leaves {least:.3} mm above")) && words.ends_with("0.001 mm"), "{words}");
    let roomy = planned(setup("goal = \"time\"\nmax_stock = 9.0"));
    assert_eq!(missed_goal(&roomy, millimetres), None);
}

/// The curve takes the plan with fewer rows that the goal has made, and can be cancelled.
#[test]
fn the_curve_takes_the_plan_with_fewer_rows_that_the_goal_made() {
    assert!(WHOLE.sparse.is_none(), "the least stock needs none");
    let hasty = &*HASTY;
    assert!(hasty.sparse.is_some());
    let anew = PlanOutcome { sparse: None, ..hasty.clone() };
    let monitor = Monitor::default();
    let points = hasty.time_stock_points(9, &monitor).expect("not cancelled");
    assert_eq!(monitor.progress(), 1.0);
    assert_eq!(points, anew.time_stock_points(9, &Monitor::default()).expect("not cancelled"));
    let cancelled = Monitor::default();
    cancelled.cancel();
    assert!(anew.time_stock_points(9, &cancelled).is_err());
}

#[test]
fn goals_that_make_no_sense_are_refused_with_their_line() {
    for (text, words) in [
        ("goal = \"fast\"", "use \"stock\", \"time\", \"balance\" or \"total\""),
        ("goal = \"total\"", "add `finish_rate`"),
        ("goal = \"total\"\nfinish_rate = 0", "greater than 0"),
        ("goal = \"total\"\nfinish_depth = 0.5", "add `finish_pass_time`"),
        ("goal = \"total\"\nfinish_pass_time = 5", "add `finish_depth`"),
        ("goal = \"total\"\nfinish_rate = 9\nfinish_depth = 0.5", "remove `finish_rate`"),
        ("goal = \"total\"\nfinish_rate = 9\nmax_time = 5", "remove `max_time`"),
        ("goal = \"balance\"\nfinish_rate = 9", "remove `finish_rate`"),
        ("finish_rate = 9", "add the goal"),
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
