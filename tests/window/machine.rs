//! The plan on a machine: axes beside the timeline, in the table and in the plot.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::machine::PlanOnMachine;
use vanecut::geometry::rotate_vector_z;

use crate::fake;
use crate::harness::{Window, settle, with_sample, words};

/// A window with a planned sample on a machine.
pub fn with_machine(name: &str) -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 1000.0));
    window.run_steps(3);
    choose(&mut window, name);
    window
}

fn choose(window: &mut Window, name: &str) {
    window.get_by_role_and_label(Role::ComboBox, "Machine").click();
    window.run_steps(2);
    window.get_by_label(name).click();
    window.run_steps(3);
    settle(window);
}

fn on_machine(window: &Window) -> &PlanOnMachine {
    let plan = window.state().state().results.on_machine.as_ref().expect("known");
    plan.as_ref().expect("the machine is read")
}

/// Text of the line of the axes; a label and its text have the same.
fn line_of_axes(window: &Window) -> Option<String> {
    let mut lines = window.query_all_by(|node| node.value().is_some_and(|text| text.starts_with("X ")));
    lines.next()?.accesskit_node().value()
}

/// The line of the axes, as pairs of a letter and a number.
fn axes(window: &Window) -> Vec<(char, f64)> {
    let text = line_of_axes(window).expect("a line");
    let words: Vec<&str> = text.split_whitespace().collect();
    let pair = |pair: &[&str]| Some((pair[0].chars().next()?, pair[1].trim_end_matches('°').parse().ok()?));
    words.chunks_exact(2).map_while(pair).collect()
}

#[test]
fn without_a_machine_no_axes_are_shown() {
    let (engine, _) = fake::engine();
    let window = with_sample(engine);
    assert!(window.state().state().results.on_machine.is_none());
    assert_eq!(words(&window, "calculating…"), None);
    assert_eq!(line_of_axes(&window), None);
}

#[test]
fn the_axes_beside_the_timeline_hold_the_tool_where_the_position_says() {
    let mut window = with_machine("ac-trunnion");
    assert_eq!(window.state().state().document.edited.setup.machine.file.as_deref(), Some("ac-trunnion"));
    let tilt = window.state().state().document.edited.setup.machine.max_axis_tilt_rad.to_degrees();
    assert!((tilt - 120.0).abs() < 0.01, "the planner keeps to the tilt that the machine reaches: {tilt}");
    window.get_by_role_and_label(Role::Button, "Go to start").click();
    window.run_steps(2);
    let start = axes(&window);
    for _ in 0..5 {
        window.key_press(egui::Key::ArrowRight);
        window.run_steps(2);
    }
    let now = axes(&window);
    let letters: Vec<char> = now.iter().map(|(letter, _)| *letter).collect();
    assert_eq!(letters, ['X', 'Y', 'Z', 'A', 'C']);
    assert_ne!(start, now, "the axes move with the timeline");
    // From A and C back to the tool axis, by the closed form of a trunnion: C turns about Z, A about X.
    let state = window.state().state();
    assert_eq!(state.look.cut_count, Some(5));
    let plan = state.shown().expect("planned").plan();
    let (a, c) = (now[3].1.to_radians(), now[4].1.to_radians());
    let held = rotate_vector_z(&vanecut::geometry::Vector::new(0.0, -a.sin(), a.cos()), c);
    let machine = on_machine(&window);
    let axis = machine.placed.vector_in_part(&held);
    let stray = axis.angle(&plan.positions[4].axis).to_degrees();
    assert!(stray < 1e-3, "{now:?} holds the tool {stray}° off");
    let tip = machine.placed.point_in_part(&machine.plunges[4].expect("a position").pose.tip);
    assert!((tip - plan.positions[4].tip).norm() < 1e-9);
}

#[test]
fn a_machine_that_cannot_run_the_plan_says_why() {
    let mut window = with_machine("ac-trunnion");
    assert_eq!(on_machine(&window).fault, None);
    // A machine file of one's own, with hardly any tilt.
    let folder = tempfile::tempdir().unwrap();
    let text = include_str!("../../assets/machines/ac-trunnion.toml").replace("[-120, 120]", "[-5, 5]");
    std::fs::write(folder.path().join("narrow.toml"), text).unwrap();
    let setup = folder.path().join("setup.toml");
    std::fs::write(&setup, "[machine]\nfile = \"narrow.toml\"\nmax_axis_tilt = 90\n").unwrap();
    window.state_mut().open_path(setup);
    settle(&mut window);
    let fault = words(&window, "A would have to be").expect("the fault is shown");
    assert!(fault.starts_with("AC trunnion: "), "{fault}");
    assert!(on_machine(&window).plunges.is_empty());
    choose(&mut window, "None");
    assert!(window.state().state().results.on_machine.is_none());
    assert_eq!(words(&window, "A would have to be"), None);
}
