//! The window with the real planner.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::state::Tone;
use vanecut::app::tasks::engine::Engine;
use vanecut::setup::AxisPolicy;

use crate::harness::{settle, with_sample};

#[test]
fn the_count_of_interferential_positions_falls_to_none() {
    let mut window = with_sample(Engine::default());
    let step = window.get_by_role_and_label(Role::SpinButton, "Step");
    step.set_value_accesskit(7.0);
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Calculate roughing").click();
    window.step();
    settle(&mut window);
    let state = window.state().state();
    // A wider step may need other tools; the notice then says so.
    let fault = state.notice.as_ref().filter(|notice| notice.tone == Tone::Fault);
    assert_eq!(fault, None, "nothing went wrong");
    let planned = state.results.planned.as_ref().expect("planned");
    assert_eq!(planned.outcome.setup.plunge.step, Some(7.0), "planned with the step of the field");
    let [before, after] = [&planned.outcome.before.summary, &planned.outcome.after.summary];
    assert!(before.interfering > 0, "the conventional plan interferes");
    assert_eq!(after.interfering, 0, "the one by our policy does not");
    let verdict = format!("Interfering {} to 0", before.interfering);
    window.get_by_label(&verdict);
}

#[test]
fn conventional_as_the_policy_repairs_nothing() {
    let mut window = with_sample(Engine::default());
    window.get_by_role_and_label(Role::ComboBox, "Axis strategy").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Isoparametric").click();
    window.run_steps(2);
    assert_eq!(
        window.state().state().document.edited.setup.plunge.axis,
        AxisPolicy::Conventional,
        "the list edits the setup"
    );
    window.key_press(egui::Key::F5);
    window.step();
    settle(&mut window);
    let planned = window.state().state().results.planned.clone().expect("planned");
    let [before, after] = [&planned.outcome.before, &planned.outcome.after].map(|r| r.summary.interfering);
    assert_eq!(before, after, "both sides are the conventional plan");
}
