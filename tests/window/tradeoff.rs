//! Time against stock: the goal in the setup, and the curve whose handle sets it.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::tasks::engine::Engine;
use vanecut::setup::Goal;

use crate::fake;
use crate::harness::{Window, press, settle, with_sample};

fn goal(window: &Window) -> Goal {
    window.state().state().document.edited.setup.plunge.goal
}

/// Number of the slider of the window.
fn slider(window: &Window) -> (f64, f64, f64) {
    let slider = window.get_by_role_and_label(Role::Slider, "Max time per channel");
    let node = slider.accesskit_node();
    let number = |value: Option<f64>| value.expect("a number");
    (number(node.min_numeric_value()), number(node.numeric_value()), number(node.max_numeric_value()))
}

#[test]
fn the_handle_on_the_curve_sets_the_time_of_a_channel() {
    // The plunges of the fake plan are all needed.
    let mut window = with_sample(Engine::default());
    window.set_size(egui::vec2(1280.0, 900.0));
    window.run_steps(3);
    assert_eq!(goal(&window), Goal::default());
    window.key_press(egui::Key::G);
    window.run_steps(3);
    settle(&mut window);
    let (fastest, now, slowest) = slider(&window);
    assert!(fastest < now && now <= slowest, "{fastest} {now} {slowest}");
    let wanted = 0.5 * (fastest + slowest);
    window.get_by_role_and_label(Role::Slider, "Max time per channel").set_value_accesskit(wanted);
    window.run_steps(3);
    settle(&mut window);
    let Goal::Stock { max_time_min: Some(limit) } = goal(&window) else { panic!("{:?}", goal(&window)) };
    assert!((limit - wanted).abs() < 0.11, "{limit} for {wanted}");
    assert!(!window.state().state().out_of_date(), "the plan follows");
    window.get_by_label_contains(&format!("{limit:.1} min per channel: hub stock "));
    let mut fields = 0;
    for field in window.get_all_by_role_and_label(Role::SpinButton, "Max time") {
        let shown = field.accesskit_node().numeric_value().expect("a number");
        assert!((shown - limit).abs() < 1e-9, "a field shows {shown}");
        fields += 1;
    }
    assert_eq!(fields, 2, "beside the curve, and in the panel as it is not the default");
    let summary = &window.state().state().shown().expect("planned").planned.outcome.after.summary;
    assert!(summary.time_estimate <= 60.5 * limit && summary.interfering == 0, "{}", summary.time_estimate);

    // A click in the plot; its right end is whatever the least stock takes.
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    let plot = window.get_by_label("Hub stock over time of a channel").rect();
    press(&mut window, egui::pos2(plot.left() + 0.4 * plot.width(), plot.center().y));
    window.run_steps(3);
    let Goal::Stock { max_time_min: Some(clicked) } = goal(&window) else { panic!("{:?}", goal(&window)) };
    assert!((fastest..slowest).contains(&clicked) && clicked != limit, "{clicked}");
    press(&mut window, egui::pos2(plot.right() - 2.0, plot.center().y));
    window.run_steps(3);
    assert_eq!(goal(&window), Goal::default());
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    assert_eq!(goal(&window), Goal::Stock { max_time_min: Some(clicked) }, "one edit, one undo");
}

#[test]
fn the_goal_is_chosen_with_its_limit() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 900.0));
    window.run_steps(3);
    window.key_press(egui::Key::G);
    window.run_steps(3);
    settle(&mut window);
    for (entry, field) in
        [("Least time", Some("Max stock")), ("Balance", None), ("Least stock", Some("Max time"))]
    {
        let list = window.get_all_by_role_and_label(Role::ComboBox, "Goal").last();
        list.expect("beside the curve").click();
        window.run_steps(2);
        window.get_by_role_and_label(Role::Button, entry).click();
        window.run_steps(3);
        settle(&mut window);
        for name in ["Max stock", "Max time"] {
            let shown = window.query_all_by_role_and_label(Role::SpinButton, name).count();
            assert_eq!(shown > 0, field == Some(name), "{name} with {entry}");
        }
    }
    assert_eq!(goal(&window), Goal::default());
    window.key_press(egui::Key::G);
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::ComboBox, "Goal").is_none(), "the usual one needs no row");
}
