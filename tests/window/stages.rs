//! Preview of a running plan: each stage is shown when it arrives, and marked until its contact is checked.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::model::planned::Side;
use vanecut::app::model::preview::PreviewPlan;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::setup_file::read_setup_bytes;
use vanecut::job::{Listener, PlanJob, PlanRequest, PlanStage};
use vanecut::monitor::Monitor;
use vanecut::setup::AxisPolicy;

use crate::harness::{HANG, Window, settle, snapshot_view, window, with_sample};

const SETUP: &str = "[[tool]]\nnumber = 1\ndiameter = 30\ninsert_width = 10\noverhang = 120\n\
                     [[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.5\n";

/// The real planner, which waits after each stage until the test allows the next.
fn gated() -> (Engine, Arc<AtomicUsize>) {
    let (engine, allowed, _) = counted();
    (engine, allowed)
}

/// The same, with the number of plans that were begun.
fn counted() -> (Engine, Arc<AtomicUsize>, Arc<AtomicUsize>) {
    let allowed = Arc::new(AtomicUsize::new(usize::MAX));
    let begun = Arc::new(AtomicUsize::new(0));
    let rough = read_setup_bytes("s.toml", SETUP.as_bytes()).expect("a setup");
    let (job, gate, count) = (PlanJob::default(), Arc::clone(&allowed), Arc::clone(&begun));
    let plan = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        count.fetch_add(1, Ordering::SeqCst);
        // One tool, so that the plan is small.
        let mut request = request.clone();
        request.setup.tools.clone_from(&rough.tools);
        request.setup.plunge.sections.clone_from(&rough.plunge.sections);
        let request = &request;
        let reported = AtomicUsize::new(0);
        let listen = |stage: PlanStage| {
            let number = reported.fetch_add(1, Ordering::SeqCst) + 1;
            listener.notify(|| stage);
            while number >= gate.load(Ordering::SeqCst) && !monitor.is_cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
        };
        job.run_with_listener(request, monitor, Listener::new(&listen))
    };
    (Engine { plan: Arc::new(plan), ..Engine::default() }, allowed, begun)
}

fn until(window: &mut Window, what: &str, done: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    while !done(window) {
        assert!(start.elapsed() < HANG, "{what} does not come");
        std::thread::sleep(Duration::from_millis(2));
        window.step();
    }
}

fn coming(window: &Window) -> Option<(AxisPolicy, bool, usize)> {
    let cutters = window.state().state().preview_on(Side::After)?;
    Some((cutters.policy(), cutters.is_checked(), cutters.count()))
}

#[test]
fn the_first_plan_is_said_to_be_under_way() {
    let (engine, allowed) = gated();
    let mut window = window(engine);
    // Waits with the conventional plan.
    allowed.store(2, Ordering::SeqCst);
    window.state_mut().open_part(PartSource::Sample("impeller532".to_owned()));
    window.step();
    until(&mut window, "a stage", |window| window.state().state().results.preview.is_some());
    window.run_steps(2);
    // In the verdict, in the table, and in the status bar.
    assert_eq!(window.query_all_by_label("Calculating…").count(), 3);
    assert!(window.query_by_label("Not calculated yet").is_none());
    allowed.store(usize::MAX, Ordering::SeqCst);
    settle(&mut window);
    assert_eq!(window.query_all_by_label("Calculating…").count(), 0);
}

#[test]
fn stages_of_the_new_setup_appear_one_by_one_and_none_is_called_sound_before_it_is_judged() {
    let (engine, allowed) = gated();
    let mut window = with_sample(engine);
    let old = window.state().state().results.planned.clone().expect("planned");
    let count = |window: &Window| window.state().state().position_count();
    let before = count(&window);
    // Waits after two stages: setup resolved, axes of the last plan.
    allowed.store(2, Ordering::SeqCst);
    window.get_by_role_and_label(Role::Slider, "Hub allowance").set_value_accesskit(0.7);
    window.step();
    until(&mut window, "the axes of the plan before", |window| coming(window).is_some());
    let (policy, judged, carried) = coming(&window).expect("cutters");
    assert_eq!((policy, judged), (AxisPolicy::Minimal, true));
    // The axes are those of the search, before plunges were left out.
    let found = old.outcome.whole.as_ref().map_or(before, |whole| whole.positions.len());
    assert!(carried <= found && carried > found * 9 / 10, "{carried} of {found} axes");
    window.step();
    window.get_by_label(&format!("New min. stock, axes as before: none of {carried} interferes"));
    window.get_by_label("Out of date");
    snapshot_view(&mut window, "carried");
    let on = |window: &Window, side: Side| window.state().state().preview_on(side).map(|c| c.policy());
    assert_eq!(on(&window, Side::Before), None, "nothing is known of the conventional plan");

    allowed.store(3, Ordering::SeqCst);
    until(&mut window, "the conventional cutters", |window| on(window, Side::Before).is_some());
    assert_eq!(on(&window, Side::After), Some(AxisPolicy::Minimal), "what is nearer to the end stays");
    window.get_by_label("Before").click();
    window.step();
    let cutters = |window: &Window| {
        let cutters = window.state().state().preview_on(Side::Before)?;
        Some((cutters.policy(), cutters.is_checked(), cutters.count()))
    };
    let (policy, judged, positions) = cutters(&window).expect("cutters");
    assert_eq!((policy, judged), (AxisPolicy::Conventional, false));
    let new = match window.state().state().preview_on(Side::Before).map(|cutters| &cutters.plan) {
        Some(PreviewPlan::Placed(plan)) => plan.positions[positions / 2].tip,
        other => panic!("not placed: {other:?}"),
    };
    let before = old.outcome.before.plan.positions[positions / 2].tip;
    assert!((new - before).norm() > 0.15, "0.2 mm higher above the hub");
    window.step();
    window.get_by_label(&format!("New isoparametric: {positions} positions, not checked yet"));
    window.get_by_label("Out of date");
    let conventional = old.outcome.before.plan.positions.len();
    assert_eq!(count(&window), conventional, "table and figures are still those of the whole plan");

    allowed.store(4, Ordering::SeqCst);
    until(&mut window, "contact", |window| cutters(window).is_some_and(|(_, judged, _)| judged));
    window.step();
    let faults = window.state().state().preview_on(Side::Before).and_then(|c| c.interfering_count());
    let faults = faults.expect("judged");
    assert!(faults > 0, "conventional axes interfere here");
    window.get_by_label(&format!("New isoparametric: {faults} of {positions} interfere"));

    // With its residual stock the before side is up to date, while the after side still waits.
    allowed.store(5, Ordering::SeqCst);
    until(&mut window, "the conventional plan", |window| !window.state().state().is_stale(Side::Before));
    let state = window.state().state();
    assert!(state.is_stale(Side::After), "the plan by the policy is not there yet");
    let shown = state.shown_on(Side::Before).expect("the conventional plan").plan();
    assert_eq!((shown.policy, shown.positions.len()), (AxisPolicy::Conventional, positions));
    assert!(Arc::ptr_eq(state.last_whole_plan(Side::After).expect("old").planned, &old));

    allowed.store(usize::MAX, Ordering::SeqCst);
    settle(&mut window);
    let state = window.state().state();
    assert!(!state.out_of_date() && state.results.preview.is_none());
    assert_eq!(state.shown_on(Side::Before).expect("planned").plan().positions.len(), positions);
    assert!(window.query_by_label("Out of date").is_none());
}

#[test]
fn a_plan_that_is_cancelled_half_way_leaves_the_one_before() {
    let (engine, allowed) = gated();
    let mut window = with_sample(engine);
    let old = window.state().state().results.planned.clone().expect("planned");
    allowed.store(3, Ordering::SeqCst);
    window.get_by_role_and_label(Role::Slider, "Step").set_value_accesskit(6.0);
    window.step();
    until(&mut window, "contact", |window| coming(window).is_some_and(|(_, judged, _)| judged));
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(coming(&window), None, "nothing half-done stays");
    let state = window.state().state();
    assert!(
        Arc::ptr_eq(state.shown_on(Side::Before).expect("a plan").planned, &old),
        "the plan before is shown"
    );
    window.get_by_label("Out of date");
}

#[test]
fn while_a_slider_is_held_something_true_of_the_new_setup_comes_before_the_next_movement_counts() {
    let (engine, allowed) = gated();
    let mut window = with_sample(engine);
    let rect = window.get_by_role_and_label(Role::Slider, "Step").rect();
    allowed.store(1, Ordering::SeqCst);
    window.drag_at(rect.left_center() + egui::vec2(4.0, 0.0));
    window.run_steps(1);
    let setup = |window: &Window| window.state().state().document.edited.setup.plunge.step;
    for x in [20.0, 24.0, 28.0] {
        window.hover_at(rect.left_center() + egui::vec2(x, 0.0));
        window.run_steps(2);
    }
    allowed.store(4, Ordering::SeqCst);
    until(&mut window, "contact", |window| coming(window).is_some_and(|(_, judged, _)| judged));
    // From here on an edit restarts planning at once.
    window.hover_at(rect.center());
    window.run_steps(2);
    let wanted = setup(&window);
    allowed.store(usize::MAX, Ordering::SeqCst);
    window.drop_at(rect.center());
    window.run_steps(2);
    settle(&mut window);
    let planned = window.state().state().results.planned.clone().expect("planned");
    assert_eq!(planned.setup.plunge.step, wanted, "the last movement is what is planned in the end");
}

/// A plan that is far on but would take long is given up for the next movement; what is shown stays what it
/// is.
#[test]
fn a_movement_restarts_a_plan_that_does_not_end_soon() {
    let (engine, allowed, begun) = counted();
    let mut window = with_sample(engine);
    let old = window.state().state().results.planned.clone().expect("planned");
    let rect = window.get_by_role_and_label(Role::Slider, "Step").rect();
    // Waits before the plan by the policy is judged: most of the work is done.
    allowed.store(6, Ordering::SeqCst);
    window.drag_at(rect.left_center() + egui::vec2(4.0, 0.0));
    window.run_steps(1);
    window.hover_at(rect.left_center() + egui::vec2(24.0, 0.0));
    window.run_steps(2);
    let far_on = |window: &Window| {
        let (_, progress) = window.state().running_task().unwrap_or_default();
        progress > 0.8 && coming(window).is_some_and(|(_, judged, _)| judged)
    };
    until(&mut window, "most of the plan", far_on);
    std::thread::sleep(Duration::from_millis(2600));
    window.step();
    let before = begun.load(Ordering::SeqCst);
    assert!(!window.state().state().is_stale(Side::Before) || window.query_by_label("Out of date").is_some());
    window.hover_at(rect.left_center() + egui::vec2(40.0, 0.0));
    window.run_steps(2);
    until(&mut window, "another plan", |_| begun.load(Ordering::SeqCst) > before);
    let state = window.state().state();
    assert!(
        Arc::ptr_eq(state.last_whole_plan(Side::After).expect("old").planned, &old),
        "the last plan is shown"
    );
    window.get_by_label("Out of date");
    allowed.store(usize::MAX, Ordering::SeqCst);
    let wanted = window.state().state().document.edited.setup.plunge.step;
    window.drop_at(rect.left_center() + egui::vec2(40.0, 0.0));
    window.run_steps(2);
    settle(&mut window);
    let planned = window.state().state().results.planned.clone().expect("planned");
    assert_eq!(planned.setup.plunge.step, wanted);
}
