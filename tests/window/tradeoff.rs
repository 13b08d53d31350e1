//! Time against stock: the goal in the setup, and the curve whose handle sets it.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::part_source::PartSource;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::setup_file::read_setup_bytes;
use vanecut::job::{Listener, PlanJob, PlanRequest};
use vanecut::monitor::Monitor;
use vanecut::setup::{Goal, SemiFinishing};

use crate::fake;
use crate::harness::{Window, press, scaled, settle, window, with_sample};

fn goal(window: &Window) -> Goal {
    window.state().state().document.edited.setup.plunge.goal
}

/// Chooses `entry` in a list beside the curve.
fn choose(window: &mut Window, list: &str, entry: &str) {
    let lists = window.get_all_by_role_and_label(Role::ComboBox, list);
    lists.last().expect("beside the curve").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, entry).click();
    window.run_steps(3);
    settle(window);
}

/// Types a number in a field beside the curve.
fn set(window: &mut Window, field: &str, value: f64) {
    let fields = window.get_all_by_role_and_label(Role::SpinButton, field);
    fields.last().expect("beside the curve").set_value_accesskit(value);
    window.run_steps(3);
    settle(window);
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
    let mut window = with_sample(fake::shared_engine());
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

/// The fake planner, whose plan of minimal is the real one of a rough setup.
fn rough() -> Engine {
    let setup = "[[tool]]\nnumber = 1\ndiameter = 20\ninsert_width = 6\noverhang = 90\n\
                 [[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.55\n";
    let rough = read_setup_bytes("s.toml", setup.as_bytes()).expect("a setup");
    let job = PlanJob::default();
    let plan = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        let mut request = PlanRequest { compare: false, field_cells: 128, ..request.clone() };
        request.setup.tools.clone_from(&rough.tools);
        request.setup.plunge.sections.clone_from(&rough.plunge.sections);
        job.run_with_listener(&request, monitor, listener)
    };
    Engine { plan: Arc::new(plan), ..Engine::default() }
}

/// A window in which the curve of a sample is just being weighed.
fn weighing() -> Window {
    weighing_with(rough())
}

fn weighing_with(engine: Engine) -> Window {
    let mut window = window(engine);
    window.state_mut().open_part(PartSource::Sample("pump6".to_owned()));
    window.set_size(egui::vec2(1280.0, 900.0));
    settle(&mut window);
    window.key_press(egui::Key::G);
    window.run_steps(2);
    window
}

/// At 150 % on a small screen the lines below the plot wrap: it shrinks so that all of them are visible.
#[test]
fn the_lines_below_the_curve_are_in_view_in_a_small_window() {
    let mut window = scaled(rough(), 1.5);
    window.state_mut().open_part(PartSource::Sample("pump6".to_owned()));
    window.set_size(egui::vec2(853.0, 533.0));
    settle(&mut window);
    window.key_press(egui::Key::G);
    window.run_steps(3);
    settle(&mut window);
    choose(&mut window, "Goal", "Least total");
    let panel = window.ctx.memory(|memory| {
        memory.area_rect(egui::Id::unique(("floating window", "Time against stock"))).expect("it is open")
    });
    for text in ["min per channel: hub stock ", "Other strategies: ", "With semi-finishing "] {
        let line = window.get_by_label_contains(text).rect();
        assert!(panel.contains_rect(line), "{text}: {line} in {panel}");
    }
}

#[test]
fn the_curve_has_progress_can_be_cancelled_and_is_kept() {
    let mut window = weighing();
    assert_eq!(window.state().running_task().map(|(name, _)| name), Some("Weighing plunges"));
    window.get_by_label_contains("Weighing the plunges ");
    window.get_by_label("Cancel curve").click();
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("The curve was cancelled.");
    assert!(window.query_by_role_and_label(Role::Slider, "Max time per channel").is_none());
    window.get_by_label("Calculate curve").click();
    window.run_steps(2);
    // Esc cancels it as everything that the status bar shows.
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("Calculate curve").click();
    window.run_steps(2);
    settle(&mut window);
    let known = slider(&window);
    // Closed and opened again, it is there at once.
    for _ in 0..2 {
        window.key_press(egui::Key::G);
        window.run_steps(2);
    }
    assert_eq!(window.state().running_task(), None);
    assert_eq!(slider(&window), known);

    assert!(window.query_by_label("Goal cannot be met").is_none());
    choose(&mut window, "Goal", "Least time");
    set(&mut window, "Max stock", 0.01);
    assert_eq!(goal(&window), Goal::Time { max_stock: 0.01 });
    window.get_by_label("Goal cannot be met");
    let outcome = &window.state().state().results.planned.as_ref().expect("planned").outcome;
    let left = outcome.after.summary.residual_p95 - outcome.setup.allowances.hub_allowance;
    window.get_by_label(&format!(
        "Goal cannot be met: the plan with the least stock leaves {left:.2} mm above the allowance (95 %), the \
         limit is 0.01 mm"
    ));
    window.get_by_label("Roughing: goal cannot be met");
}

#[test]
fn escape_cancels_the_search_in_the_window_in_front_and_nothing_else() {
    let engine = Engine { flank: fake::engine().0.flank, ..rough() };
    let (engine, held) = fake::with_held_flank(engine);
    let mut window = weighing_with(engine);
    window.key_press(egui::Key::F6);
    window.run_steps(3);
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    window.get_by_label("Curve cancelled");
    held.store(false, Ordering::SeqCst);
    settle(&mut window);
    assert!(window.state().state().results.flank.is_some(), "it goes on");
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
    choose(&mut window, "Goal", "Least total");
    assert!(matches!(goal(&window), Goal::Total { finishing: SemiFinishing::Rate { .. } }));
    window.get_by_label_contains("With semi-finishing ");
    set(&mut window, "Finish rate", 250.0);
    let finishing = SemiFinishing::Rate { mm3_per_min: 250.0 };
    assert_eq!(goal(&window), Goal::Total { finishing });
    choose(&mut window, "Semi-finishing", "Passes");
    set(&mut window, "Finish depth", 0.8);
    set(&mut window, "Pass time", 7.0);
    let finishing = SemiFinishing::Passes { depth: 0.8, pass_time_min: 7.0 };
    assert_eq!(goal(&window), Goal::Total { finishing });
    for (entry, field) in
        [("Least time", Some("Max stock")), ("Balance", None), ("Least stock", Some("Max time"))]
    {
        choose(&mut window, "Goal", entry);
        assert!(window.query_by_label_contains("With semi-finishing ").is_none());
        for name in ["Max stock", "Max time", "Finish rate", "Finish depth"] {
            let shown = window.query_all_by_role_and_label(Role::SpinButton, name).count();
            assert_eq!(shown > 0, field == Some(name), "{name} with {entry}");
        }
    }
    // Before the plan of another goal is there, that is so as well.
    choose(&mut window, "Goal", "Least total");
    window.get_by_label_contains("With semi-finishing ");
    window.get_by_label("Auto-update").click_accesskit();
    window.run_steps(3);
    choose(&mut window, "Goal", "Least time");
    assert!(window.state().state().out_of_date());
    assert!(window.query_by_label_contains("With semi-finishing ").is_none());
    window.get_by_label("Auto-update").click_accesskit();
    window.run_steps(3);
    choose(&mut window, "Goal", "Least stock");
    assert_eq!(goal(&window), Goal::default());
    window.key_press(egui::Key::G);
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::ComboBox, "Goal").is_none(), "the usual one needs no row");
}

#[test]
fn what_was_typed_for_a_goal_is_there_when_it_is_chosen_again() {
    let mut window = weighing();
    settle(&mut window);
    // Only the values of the fields are looked at.
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    choose(&mut window, "Goal", "Least total");
    set(&mut window, "Finish rate", 900.0);
    choose(&mut window, "Semi-finishing", "Passes");
    set(&mut window, "Finish depth", 0.3);
    set(&mut window, "Pass time", 7.0);
    let passes = Goal::Total { finishing: SemiFinishing::Passes { depth: 0.3, pass_time_min: 7.0 } };
    assert_eq!(goal(&window), passes);
    choose(&mut window, "Semi-finishing", "Removal rate");
    assert_eq!(goal(&window), Goal::Total { finishing: SemiFinishing::Rate { mm3_per_min: 900.0 } });
    choose(&mut window, "Semi-finishing", "Passes");
    assert_eq!(goal(&window), passes);
    choose(&mut window, "Goal", "Least time");
    set(&mut window, "Max stock", 0.7);
    choose(&mut window, "Goal", "Least total");
    assert_eq!(goal(&window), passes);
    choose(&mut window, "Goal", "Least time");
    assert_eq!(goal(&window), Goal::Time { max_stock: 0.7 });
}
