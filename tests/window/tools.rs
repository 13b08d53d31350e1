//! Tools that the program chooses.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::state::Tone;

use crate::fake;
use crate::harness::{Window, settle, with_sample};

fn set_step(window: &mut Window, step: f64) {
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(step);
    window.run_steps(3);
    settle(window);
}

#[test]
fn a_tool_without_plunges_says_why() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    window.get_by_label("T2 Ø16: no plunges, nothing left that is thick enough for another cutter");
    let count = window.state().state().position_count();
    window.get_by_label(&format!("T1 Ø30: {count} plunges"));
}

#[test]
fn tools_that_are_chosen_anew_are_named_and_the_colour_scale_stays() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    let scale = window.state().state().range();
    set_step(&mut window, 6.0);
    assert!(window.query_by_label_contains("Chosen anew:").is_none(), "the same tools");
    set_step(&mut window, 30.0);
    window.get_by_label_contains("Chosen anew: Ø30 (1.00 to 0.50)");
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert!(notice.tone == Tone::Done && notice.text.contains("became Ø20"), "{notice:?}");
    let state = window.state().state();
    assert_eq!(state.range(), scale, "one colour means one height in both plans");
    assert_ne!(state.fitting_range(), scale, "although another would fit");
    let fitting = state.fitting_range();
    window.get_by_label("Fit scale").click();
    window.run_steps(3);
    assert_eq!(window.state().state().range(), fitting, "until it is asked for");
    assert!(window.query_by_label("Fit scale").is_none());
    set_step(&mut window, 29.0);
    assert!(window.query_by_label_contains("Chosen anew:").is_none(), "nothing changed this time");
}
