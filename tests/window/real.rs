//! The window over the real planner.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::engine::Engine;
use vanecut::app::planned::Side;
use vanecut::part::AxisPolicy;

use crate::harness::{settle, snapshot_view, with_sample};

#[test]
#[ignore = "waits for the planner"]
fn the_count_of_interferential_positions_falls_to_none() {
    let mut window = with_sample(Engine::default());
    let step = window.get_by_role_and_label(Role::SpinButton, "Step");
    step.set_value_accesskit(7.0);
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Plan channel").click();
    window.step();
    settle(&mut window);
    let state = window.state().state();
    assert_eq!(state.notice, None, "nothing went wrong");
    let planned = state.planned.as_ref().expect("planned");
    assert_eq!(planned.outcome.setup.plunge.step, Some(7.0), "planned with the step of the field");
    let [before, after] = [Side::Before, Side::After].map(|side| &planned.result(side).summary);
    assert!(before.interferential > 0, "the conventional plan interferes");
    assert_eq!(after.interferential, 0, "the monotone one does not");
    let verdict = format!("Interferential {} to 0", before.interferential);
    window.get_by_label(&verdict);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    snapshot_view(&mut window, "impeller532");
}

#[test]
#[ignore = "waits for the planner"]
fn conventional_as_the_policy_repairs_nothing() {
    let mut window = with_sample(Engine::default());
    window.get_by_role_and_label(Role::ComboBox, "Axis policy").click();
    window.run_steps(2);
    window.get_by_label("Conventional").click();
    window.run_steps(2);
    assert_eq!(
        window.state().state().setup.plunge.axis,
        AxisPolicy::Conventional,
        "the list edits the setup"
    );
    window.key_press(egui::Key::F5);
    window.step();
    settle(&mut window);
    let planned = window.state().state().planned.clone().expect("planned");
    let [before, after] = [Side::Before, Side::After].map(|side| planned.result(side).summary.interferential);
    assert_eq!(before, after, "both sides are the conventional plan");
}

#[test]
#[ignore = "waits for the planner"]
fn the_planner_obeys_cancel_within_50_ms() {
    // The real planner, with a mark at its end: the window lets go at once whatever it does.
    let ended = Arc::new(AtomicBool::new(false));
    let mark = Arc::clone(&ended);
    let real = Engine::default();
    let plan = Arc::clone(&real.plan);
    let engine = Engine {
        plan: Arc::new(move |request, monitor| {
            let result = plan(request, monitor);
            mark.store(true, Ordering::SeqCst);
            result
        }),
        ..real
    };
    let mut window = with_sample(engine);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(0.5);
    window.run_steps(2);
    ended.store(false, Ordering::SeqCst);
    window.key_press(egui::Key::F5);
    window.step();
    std::thread::sleep(Duration::from_millis(30));
    let start = Instant::now();
    window.key_press(egui::Key::Escape);
    window.step();
    while !ended.load(Ordering::SeqCst) {
        assert!(start.elapsed() < Duration::from_secs(10), "the planner goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    let took = start.elapsed();
    assert!(took < Duration::from_millis(50), "the planner took {took:?} to stop");
    assert!(window.state().state().planned.is_some(), "the last good plan stays");
}
