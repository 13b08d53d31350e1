//! One figure has one text wherever it stands, and what is counted differently says so.

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::tasks::engine::Engine;
use vanecut::job::{Listener, PlanRequest};
use vanecut::machine::MachineTime;
use vanecut::monitor::Monitor;
use vanecut::plunge::Breach;

use crate::fake;
use crate::harness::{Window, labels, settle, with_sample};

/// The time of a wheel with its tool changes: 31.3 h, and 31.2 h if each channel counts without them.
#[test]
fn the_time_of_a_wheel_is_the_same_in_verdict_operations_and_variants() {
    let time = MachineTime { total_s: 7200.0, tool_changes_s: 600.0 };
    let mut window = with_sample(fake::engine_on_machine(time));
    window.set_size(egui::vec2(1100.0, 1180.0));
    window.run_steps(2);
    window.get_by_label("Save as variant").click();
    window.run_steps(4);
    settle(&mut window);
    let times = labels(&window, "2.0 h per channel");
    assert!(
        !times.is_empty() && times.iter().all(|text| text == "2.0 h per channel, 31.3 h wheel"),
        "{times:?}"
    );
    assert!(window.query_all_by_label_contains("2.0 h, wheel 31.3 h").count() > 0);
    assert_eq!(labels(&window, "31."), ["31.3 h", "31.3 h"], "of the current setup and the variant");
}

/// The fake planner, of whose plan after a plunge is out of the reach of the machine.
fn engine_with_breach() -> Engine {
    let (engine, _) = fake::engine();
    let plan = Arc::clone(&engine.plan);
    let beyond = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        let mut outcome = plan(request, monitor, listener)?;
        outcome.after.plan.positions[3].evaluation.breach = Some(Breach::Tilt);
        Ok(outcome)
    };
    Engine { plan: Arc::new(beyond), ..engine }
}

#[test]
fn the_headline_says_how_many_interfere_by_the_contact_of_their_core() {
    let window = with_sample(engine_with_breach());
    window.get_by_label("Interfering 5 to 1 (core contact 5 to 0)");
}

#[test]
fn the_head_of_a_plunge_says_what_is_wrong_with_it() {
    let mut window = with_sample(engine_with_breach());
    window.set_size(egui::vec2(1100.0, 900.0));
    window.state_mut().look_mut().select(Some(3));
    window.run_steps(6);
    let count = window.state().state().position_count();
    window.get_by_label(&format!("Position 4 of {count}: interfering"));
    window.get_by_label("axis beyond the reach of the machine");
}

/// The panel of the selected position stands on the lower edge.
#[test]
fn the_first_edit_by_hand_moves_no_button() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1000.0));
    window.state_mut().look_mut().select(Some(3));
    window.run_steps(6);
    window.get_by_label("By hand").click();
    window.run_steps(6);
    settle(&mut window);
    let lock = |window: &Window, name: &str| window.get_by_role_and_label(Role::Button, name).rect();
    let before = lock(&window, "Lock");
    window.get_by_role_and_label(Role::Button, "Lock").click();
    window.run_steps(8);
    settle(&mut window);
    window.run_steps(8);
    assert_eq!(window.state().state().document.edited.setup.plunge.edits.len(), 1);
    let after = window.get_by_role_and_label(Role::Button, "Delete").rect();
    assert!((after.top() - before.top()).abs() < 1.0, "{before} became {after}");
}
