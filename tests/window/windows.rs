//! The windows over the picture, and what Escape closes or cancels.

use std::sync::atomic::Ordering;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::panels::DockPanel;

use crate::fake;
use crate::harness::{self, settle, with_sample};

#[test]
fn escape_closes_the_window_in_front_before_it_cancels_the_calculation() {
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::A);
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("Machinability");
    harness::run_by_search(&mut window, "shop library");
    window.get_by_label("Shop library");
    slow.store(true, Ordering::SeqCst);
    window.key_press(egui::Key::F5);
    window.run_steps(2);
    assert_eq!(window.state().running_task().map(|(name, _)| name), Some("Calculating"));
    // The one that was opened last is in front.
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(
        window.query_by_label("Shop library").is_none()
            && window.state().state().look.panels.is_open(DockPanel::Machinability)
    );
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(!window.state().state().look.panels.is_open(DockPanel::Machinability));
    assert!(window.state().running_task().is_some(), "the calculation goes on");
    window.key_press(egui::Key::Escape);
    settle(&mut window);
    assert!(slow.load(Ordering::SeqCst), "by itself it would go on");
    assert_eq!(window.state().running_task(), None, "cancelled");
}

#[test]
fn escape_ends_the_typing_in_a_field_before_it_closes_the_window() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1700.0));
    window.run_steps(3);
    window.get_by_label("Shop library…").click();
    settle(&mut window);
    let field = window.get_all_by_role_and_label(Role::SpinButton, "Ø").next().expect("a field").rect();
    harness::press(&mut window, field.center());
    window.run_steps(2);
    window.event(egui::Event::Text("75".to_owned()));
    window.run_steps(2);
    assert!(window.ctx.text_edit_focused(), "it is typed in");
    let is_open =
        |window: &harness::Window| window.state().state().look.panels.is_open(DockPanel::ToolLibrary);
    for still_open in [true, false] {
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
        assert_eq!(is_open(&window), still_open);
    }
}

#[test]
fn a_window_that_is_clicked_comes_above_the_messages_and_a_new_one_above_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let fail = |window: &mut harness::Window, name: &str| {
        window.state_mut().open_path(folder.path().join(name));
        settle(window);
        window.run_steps(2);
    };
    window.key_press(egui::Key::A);
    window.run_steps(3);
    settle(&mut window);
    fail(&mut window, "missing.toml");
    let layer = |window: &harness::Window, at: egui::Pos2| window.ctx.layer_id_at(at).expect("a layer");
    let at = window.get_by_label("Dismiss").rect().center();
    let messages = layer(&window, at);
    let floating = window.get_by_label("Machinability").rect().center();
    let floating = layer(&window, floating);
    assert_ne!(messages, floating, "both are there");
    let is_above = |window: &harness::Window| {
        let order: Vec<_> = window.ctx.memory(|memory| memory.layer_ids().collect());
        let place = |layer| order.iter().position(|known| *known == layer);
        place(messages) > place(floating)
    };
    assert!(is_above(&window), "what is new is seen");
    let title = window.get_by_label("Machinability").rect().center();
    harness::press(&mut window, title);
    window.run_steps(3);
    assert!(!is_above(&window), "the window was clicked");
    fail(&mut window, "another.toml");
    assert!(is_above(&window), "what is new is seen");
}

#[test]
fn no_tooltip_stays_over_a_dialog() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let field = window.get_by_role_and_label(Role::SpinButton, "Stepover");
    let at = field.rect().center();
    window.hover_at(at);
    let shown =
        |window: &harness::Window| window.query_by_label_contains("distance of neighbouring rows").is_some();
    window.run_steps(10);
    assert!(shown(&window), "the tooltip of the field under the pointer");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(3);
    window.get_by_role_and_label(Role::TextInput, "Search commands");
    assert!(!shown(&window), "not over the dialog");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    window.hover_at(at + egui::vec2(2.0, 0.0));
    window.run_steps(10);
    assert!(shown(&window), "it is there again");
}
