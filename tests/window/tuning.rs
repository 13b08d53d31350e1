//! Sliders with auto-update, variants, command palette.

use std::sync::atomic::Ordering;

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::setup::Setup;

use crate::fake;
use crate::harness::{Window, press, run_by_search, settle, snapshot_view, with_sample};

#[test]
fn a_slider_is_followed_live_and_stale_results_say_so() {
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    let before = window.state().state().position_count();
    slow.store(true, Ordering::SeqCst);
    window.get_by_role_and_label(Role::Slider, "Step").set_value_accesskit(5.0);
    window.run_steps(3);
    assert!(window.state().is_busy(), "planning by itself");
    window.get_by_label("Out of date");
    window.get_by_label("Out of date:");
    assert_eq!(window.state().state().position_count(), before, "the old result stays meanwhile");
    // A newer value replaces the running task.
    window.get_by_role_and_label(Role::Slider, "Step").set_value_accesskit(4.0);
    window.run_steps(3);
    slow.store(false, Ordering::SeqCst);
    settle(&mut window);
    assert!(!window.state().state().out_of_date(), "the newest value is planned");
    assert_eq!(window.state().state().position_count(), 80, "160 mm in steps of 4 mm, two rows");
    assert!(window.query_by_label("Out of date").is_none());
    window.get_by_label("Reset step").click();
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(window.state().state().position_count(), before, "the dot resets, and that is followed too");
}

#[test]
fn dragging_a_slider_plans_drafts_and_a_full_plan_at_the_end() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let rect = window.get_by_role_and_label(Role::Slider, "Step").rect();
    let cells = |window: &Window| {
        let planned = window.state().state().results.planned.clone().expect("planned");
        planned.setup.plunge.step
    };
    window.drag_at(rect.left_center() + egui::vec2(4.0, 0.0));
    window.run_steps(1);
    window.hover_at(rect.center());
    window.run_steps(2);
    settle(&mut window);
    let held = cells(&window);
    assert!(held.is_some(), "planned while the button is down");
    window.drop_at(rect.center());
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(cells(&window), window.state().state().document.edited.setup.plunge.step);
    assert!(!window.state().state().out_of_date());
}

#[test]
fn sets_are_kept_compared_used_and_removed_and_undo_covers_it() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1180.0));
    window.run_steps(2);
    // Keys of no command do nothing.
    window.key_press_modifiers(egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, egui::Key::D);
    window.run_steps(2);
    assert!(window.state().state().document.edited.sets.is_empty());
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::D);
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(5.0);
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("Save as variant").click();
    window.run_steps(10);
    let sets = window.state().state().document.edited.sets.clone();
    assert_eq!(sets.iter().map(|set| set.setup.plunge.step).collect::<Vec<_>>(), [None, Some(5.0)]);
    for set in &sets {
        assert!(window.state().state().results.figures(&set.setup).is_some(), "both were planned");
    }
    snapshot_view(&mut window, "what_if");
    window.get_by_label("Load Variant 1").click_accesskit();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, None, "the first set is active");
    window.run_steps(8);
    window.get_by_label("Remove Variant 2").click_accesskit();
    window.run_steps(8);
    assert_eq!(window.state().state().document.edited.sets.len(), 1);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(2);
    assert_eq!(window.state().state().document.edited.sets, sets, "undo brings it back");
    // Saving a variant is a step, too: undone, it is said, as the setup does not change.
    window.get_by_label("Save as variant").click();
    window.run_steps(4);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(2);
    assert_eq!(window.state().state().document.edited.sets, sets);
    window.get_by_label("Saving \"Variant 3\" is undone; Redo stores it again");
}

#[test]
fn the_palette_finds_and_runs_commands() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(3);
    window.event(egui::Event::Text("side by".to_owned()));
    window.run_steps(3);
    snapshot_view(&mut window, "palette");
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    use vanecut::app::model::look::Arrangement;
    assert_eq!(window.state().state().look.arrangement, Arrangement::Both, "the first that was found");
    assert!(window.query_by_role_and_label(Role::TextInput, "Search commands").is_none(), "and it is gone");
    for name in ["3D view, before", "3D view, after"] {
        window.get_by_label(name);
    }
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    assert!(window.query_by_role_and_label(Role::TextInput, "Search commands").is_none(), "Esc closes it");

    // What cannot be done now comes last: Enter takes the first.
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(2);
    window.event(egui::Event::Text("study".to_owned()));
    window.run_steps(3);
    let [open, shown] =
        ["Open study results…", "Study results"].map(|name| window.get_by_role_and_label(Role::Button, name));
    assert!(shown.accesskit_node().is_disabled(), "none is open");
    assert!(open.rect().top() < shown.rect().top());
    assert_eq!(window.query_all_by_label("not available now").count(), 1, "and says so");
    window.key_press(egui::Key::Escape);
    window.run_steps(2);

    // The switch of a panel is a command, too.
    assert!(!window.state().state().compare);
    run_by_search(&mut window, "compare all");
    assert!(window.state().state().compare);

    // So is that of each panel.
    use vanecut::app::model::panels::DockPanel;
    let is_open = |window: &Window, panel| window.state().state().look.panels.is_open(panel);
    for (typed, panel) in [
        ("setup panel", DockPanel::Setup),
        ("rotary axes panel", DockPanel::Axes),
        ("timeline panel", DockPanel::Timeline),
        ("table panel", DockPanel::Table),
        ("details panel", DockPanel::Details),
        ("enlarged sectional", DockPanel::SectionalView),
    ] {
        let before = is_open(&window, panel);
        run_by_search(&mut window, typed);
        assert_ne!(is_open(&window, panel), before, "{typed}");
    }
}

/// A slow frame holds many keys: those behind Ctrl+K are words, and no commands.
#[test]
fn what_is_typed_in_the_frame_that_opens_the_palette_is_searched() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let arrangement = |window: &Window| window.state().state().look.arrangement;
    let (before, edited) = (arrangement(&window), window.state().state().document.edited.clone());
    let mut modifiers = egui::Modifiers::COMMAND;
    for (key, text) in [(egui::Key::K, None), (egui::Key::B, Some("b")), (egui::Key::L, Some("l"))] {
        let held = std::mem::take(&mut modifiers);
        let physical_key = None;
        // All of them in one frame: `event` gives each a frame of its own.
        let events = &mut window.input_mut().events;
        events.push(egui::Event::Key { key, physical_key, pressed: true, repeat: false, modifiers: held });
        events.extend(text.map(|text| egui::Event::Text(text.to_owned())));
    }
    window.run_steps(3);
    let field = window.get_by_role_and_label(Role::TextInput, "Search commands");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("bl"));
    assert_eq!(arrangement(&window), before);
    assert_eq!(window.state().state().document.edited, edited);
    window.event(egui::Event::Text("ades".to_owned()));
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Blades");
}

#[test]
fn the_tilt_of_the_machine_is_a_field_that_can_be_undone() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.run_steps(6);
    let tilt =
        |window: &Window| window.state().state().document.edited.setup.machine.max_axis_tilt_rad.to_degrees();
    assert!((tilt(&window) - 180.0).abs() < 1e-9, "no limit by default");
    window.get_by_role_and_label(Role::SpinButton, "Max machine tilt").set_value_accesskit(75.0);
    window.run_steps(8);
    settle(&mut window);
    assert!((tilt(&window) - 75.0).abs() < 1e-9, "the field edits the setup");
    let planned = window.state().state().results.planned.clone().expect("planned");
    assert!(
        (planned.setup.machine.max_axis_tilt_rad.to_degrees() - 75.0).abs() < 1e-9,
        "and that is planned"
    );
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(2);
    assert!((tilt(&window) - 180.0).abs() < 1e-9, "undone");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Y);
    window.run_steps(2);
    window.get_by_label("Reset max machine tilt").click();
    window.run_steps(2);
    assert!((tilt(&window) - 180.0).abs() < 1e-9, "the dot resets");
}

#[test]
fn the_empty_palette_proposes_nothing_that_closes_the_project() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(3);
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().document.part.is_some(), "the project is still open");
    // A dozen commands can be clicked without scrolling.
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(3);
    let shown = window.state().state().look.layers.stock;
    let is_it = |label: String| label.starts_with("Stock");
    let seventh =
        window.get_by(|node| node.role() == Role::Button && node.label().is_some_and(is_it)).rect().center();
    press(&mut window, seventh);
    window.run_steps(3);
    assert_ne!(window.state().state().look.layers.stock, shown, "the seventh command is in view");
    for (typed, found) in [("simulate", "Simulate to here"), ("gcode", "Export NC program…")] {
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
        window.run_steps(3);
        window.event(egui::Event::Text(typed.to_owned()));
        window.run_steps(3);
        window.get_by_label_contains(found);
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
    }
}

#[test]
fn lead_out_peck_and_material_are_edited_and_saved() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 1000.0));
    window.run_steps(3);
    let setup = |window: &Window| window.state().state().document.edited.setup.clone();
    assert_eq!((setup(&window).plunge.lead_out, setup(&window).plunge.peck), (None, None));
    for (name, value) in [("Lead-out", 1.5), ("Peck depth", 20.0)] {
        window.get_by_role_and_label(Role::SpinButton, name).set_value_accesskit(value);
        window.run_steps(3);
    }
    assert_eq!((setup(&window).plunge.lead_out, setup(&window).plunge.peck), (Some(1.5), Some(20.0)));
    window.get_by_role_and_label(Role::ComboBox, "Material").click();
    window.run_steps(2);
    window.get_by_label("titanium").click();
    window.run_steps(3);
    assert_eq!(setup(&window).allowances.material.as_deref(), Some("titanium"));
    // A grade that is typed.
    window.get_by_role_and_label(Role::ComboBox, "Material").click();
    window.run_steps(2);
    window.get_by_label("Another material").click();
    window.run_steps(2);
    window.event(egui::Event::Text("1.4571".to_owned()));
    window.run_steps(1);
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(setup(&window).allowances.material.as_deref(), Some("1.4571"));
    assert!(setup(&window).allowances.cutting_data().is_some(), "a grade of a known group");
    snapshot_view(&mut window, "setup_fields");

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("setup.toml");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveSetup, path.clone());
    settle(&mut window);
    let saved = vanecut::io::setup_file::read_setup(&path, &Setup::default()).expect("readable");
    assert_eq!((saved.plunge.lead_out, saved.plunge.peck), (Some(1.5), Some(20.0)));
    assert_eq!(saved.allowances.material.as_deref(), Some("1.4571"));

    for name in ["Reset lead-out", "Reset peck depth", "Reset material"] {
        window.get_by_label(name).click();
        window.run_steps(3);
    }
    assert_eq!((setup(&window).plunge.lead_out, setup(&window).plunge.peck), (None, None));
    assert_eq!(setup(&window).allowances.material, None);
}
