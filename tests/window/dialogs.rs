//! The window's own file dialog.

use std::path::Path;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use crate::fake;
use crate::harness::{Window, click_enabled, settle, with_sample};

/// Types a name into the field of the dialog.
fn name_file(window: &mut Window, name: &Path) {
    window.get_by_role_and_label(Role::TextInput, "File").focus();
    window.run_steps(1);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text(name.display().to_string()));
    window.run_steps(2);
    settle(window);
}

fn press_enter(window: &mut Window) {
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    settle(window);
}

fn export(window: &mut Window) {
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::E);
    window.run_steps(3);
    settle(window);
    window.get_by_label("Export CL (APT)");
}

#[test]
fn a_wrong_ending_is_refused_and_nothing_is_replaced_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    std::fs::write(&path, "old").expect("writes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    export(&mut window);
    name_file(&mut window, &folder.path().join("p.glb"));
    window.get_by_label("The name must end in .apt or .cl");
    press_enter(&mut window);
    assert!(!folder.path().join("p.glb").exists(), "nothing is written");

    name_file(&mut window, &path);
    press_enter(&mut window);
    window.get_by_label("Replace p.apt?");
    assert_eq!(std::fs::read(&path).expect("reads"), b"old", "asked first");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    window.get_by_label("Export CL (APT)");
    press_enter(&mut window);
    window.get_by_label("Replace").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(vanecut::io::apt::read_apt(&path).is_ok(), "replaced");

    // A missing ending is added.
    export(&mut window);
    name_file(&mut window, &folder.path().join("q"));
    press_enter(&mut window);
    assert!(folder.path().join("q.apt").exists());

    export(&mut window);
    name_file(&mut window, &folder.path().join("no/such/p.apt"));
    let missing = format!("The folder {} does not exist", folder.path().join("no/such").display());
    window.get_by_label_contains(&missing);
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Export CL (APT)").is_none(), "one Esc closes it");
}

#[test]
fn folders_are_entered_and_only_files_that_fit_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).expect("creates");
    std::fs::write(inner.join("s.toml"), "[plunge]\nstep = 4.5\n").expect("writes");
    std::fs::write(inner.join("p.apt"), "").expect("writes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    window.key_press_modifiers(egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, egui::Key::O);
    window.run_steps(3);
    name_file(&mut window, folder.path());
    press_enter(&mut window);
    window.get_by_label(&folder.path().display().to_string());
    window.get_by_label("inner/").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(window.query_by_label("p.apt").is_none(), "no setup");
    window.get_by_label("s.toml").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Open").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, Some(4.5), "opened");
}
