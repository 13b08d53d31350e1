//! A machine of one's own: a machine file that is opened in the list of machines.

use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::io::machine_file::read_machine;
use vanecut::io::project_file::read_project;

use crate::dialogs::{name_file, press_enter};
use crate::fake;
use crate::harness::{
    Window, choose_in_file_menu, choose_in_list, click_enabled, labels, sample_in, settle, window,
    with_sample,
};
use crate::nc::{ask, save};
use crate::program::check;

pub const TRUNNION: &str = include_str!("../../assets/machines/ac-trunnion.toml");

/// Writes a trunnion of another name, whose table tilts by 80 degrees.
pub fn own_machine(folder: &Path) -> PathBuf {
    let text = TRUNNION
        .replace("name = \"AC trunnion\"", "name = \"Mill 5\"")
        .replace("limits = [-120, 120]", "limits = [-80, 80]");
    let path = folder.join("own.toml");
    std::fs::write(&path, text).expect("writes");
    path
}

/// Opens a machine file from the list of machines, through the file dialog of the window.
pub fn open(window: &mut Window, path: &Path) {
    window.set_size(egui::vec2(1280.0, 1000.0));
    window.run_steps(3);
    window.state_mut().use_own_file_dialogs();
    choose_in_list(window, "Machine", "Open machine file…");
    settle(window);
    name_file(window, path);
    press_enter(window);
}

fn shown(window: &Window) -> Option<String> {
    window.get_by_role_and_label(Role::ComboBox, "Machine").value()
}

fn undo(window: &mut Window) {
    // An edit that stood for a while is one step.
    window.run_steps(60);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    settle(window);
}

#[test]
fn a_machine_file_is_opened_from_the_list_and_undone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = own_machine(folder.path());
    let mut window = with_sample(fake::engine().0);
    open(&mut window, &path);
    assert_eq!(shown(&window).as_deref(), Some("own.toml (Mill 5)"), "the name of the machine");
    let machine = window.state().state().document.edited.setup.machine.clone();
    assert_eq!(machine.file.as_deref(), path.to_str());
    assert!((machine.max_axis_tilt_rad.to_degrees() - 80.0).abs() < 0.01, "the planner keeps to its reach");
    let on_machine = window.state().state().on_machine().cloned().expect("on the machine");
    assert_eq!(on_machine.machine, read_machine(&path).expect("reads"), "the timeline runs on it");
    let resets = |window: &Window| window.query_by_label("Reset max machine tilt").is_some();
    assert!(!resets(&window), "it is the default on this machine");
    undo(&mut window);
    assert_eq!(shown(&window).as_deref(), Some("None"));
    assert_eq!(window.state().state().document.edited.setup.machine.file, None);
    // It stays in the list, as others do.
    choose_in_list(&mut window, "Machine", "bc-trunnion");
    settle(&mut window);
    assert!(!resets(&window));
    choose_in_list(&mut window, "Machine", "own.toml (Mill 5)");
    settle(&mut window);
    assert_eq!(window.state().state().document.edited.setup.machine, machine);
}

#[test]
fn a_project_names_the_machine_file_beside_it_and_opens_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, project) = (own_machine(folder.path()), folder.path().join("p.vanecut"));
    let mut first = with_sample(fake::engine().0);
    open(&mut first, &path);
    let ctx = first.ctx.clone();
    first.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut first);
    drop(first);
    let stored = read_project(&project).expect("reads").setup.machine.file;
    assert_eq!(stored.as_deref(), Some("own.toml"), "relative to the project");
    let mut second = window(fake::engine().0);
    second.state_mut().open_path(project.clone());
    settle(&mut second);
    assert_eq!(shown(&second).as_deref(), Some("own.toml (Mill 5)"));
    assert!(!second.state().state().document.is_unsaved());
    // A file that is gone is named at the field.
    std::fs::remove_file(&path).expect("removes");
    let mut third = window(fake::engine().0);
    third.state_mut().open_path(project);
    settle(&mut third);
    assert_eq!(shown(&third).as_deref(), Some("own.toml"));
    let named = labels(&third, "own.toml: cannot be read");
    assert_eq!(named.len(), 2, "at the list, and below the timeline: {:?}", labels(&third, ""));
    assert!(named.iter().all(|text| text.ends_with("; check the path")), "{named:?}");
    // And in place of the plot of the axes.
    third.get_by_label_contains("Rotary axes over the program: own.toml: cannot be read");
}

/// Files of the shop lie elsewhere than those of the part.
#[test]
fn a_setup_is_not_saved_beside_the_machine_file() {
    let [shop, own] = [tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder")];
    let path = own_machine(shop.path());
    let mut window = with_sample(fake::engine().0);
    open(&mut window, &path);
    let shows = |window: &Window, folder: &Path| {
        // Of a long path the end is shown.
        let name = folder.file_name().expect("a name").to_string_lossy();
        !labels(window, "").iter().all(|text| !text.ends_with(&*name))
    };
    let ask_to_save = |window: &mut Window| {
        choose_in_file_menu(window, "Save setup…");
        settle(window);
    };
    ask_to_save(&mut window);
    assert!(!shows(&window, shop.path()), "{:?}", labels(&window, "/"));
    name_file(&mut window, &own.path().join("s.toml"));
    press_enter(&mut window);
    open(&mut window, &path);
    ask_to_save(&mut window);
    assert!(shows(&window, own.path()), "that of the last setup: {:?}", labels(&window, ""));
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    choose_in_list(&mut window, "Machine", "Open machine file…");
    settle(&mut window);
    assert!(shows(&window, shop.path()), "machines are found where the last one was");
}

#[test]
fn faults_of_a_machine_file_stand_at_the_list_until_another_is_chosen_or_the_next_plan() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = own_machine(folder.path());
    let faulty = folder.path().join("faulty.toml");
    std::fs::write(&faulty, TRUNNION.replace("dir = [-1, 0, 0]", "dir = [0, 0, 0]")).expect("writes");
    let mut window = with_sample(fake::engine().0);
    open(&mut window, &faulty);
    let line = labels(&window, "faulty.toml:");
    assert_eq!(line.len(), 1, "{:?}", labels(&window, ""));
    assert!(
        line[0].contains(": dir is not ") && line[0].contains(';'),
        "what is wrong, and what to do: {line:?}"
    );
    assert_eq!(window.state().state().document.edited.setup.machine.file, None, "the machine stays");
    // A file with another ending is not opened.
    choose_in_list(&mut window, "Machine", "Open machine file…");
    settle(&mut window);
    let text = folder.path().join("notes.txt");
    std::fs::write(&text, "none").expect("writes");
    name_file(&mut window, &text);
    window.get_by_label("The name must end in .toml");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    assert_eq!(labels(&window, "faulty.toml:").len(), 1);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.0);
    window.run_steps(3);
    settle(&mut window);
    assert!(labels(&window, "faulty.toml:").is_empty(), "it is past");
    open(&mut window, &faulty);
    open(&mut window, &path);
    assert_eq!(shown(&window).as_deref(), Some("own.toml (Mill 5)"));
    assert!(labels(&window, "faulty.toml:").is_empty(), "{:?}", labels(&window, "faulty"));
    assert!(window.state().state().problems.is_empty(), "{:?}", window.state().state().problems);
    // One that is broken and mended is read with each calculation.
    let whole = std::fs::read_to_string(&path).expect("reads");
    for (text, is_faulty) in [(whole.replace("[-80, 80]", "[-80, 80, 3]"), true), (whole, false)] {
        std::fs::write(&path, text).expect("writes");
        window.key_press(egui::Key::F5);
        window.run_steps(3);
        settle(&mut window);
        assert_eq!(labels(&window, "own.toml:").is_empty(), !is_faulty, "{:?}", labels(&window, "own.toml"));
    }
}

#[test]
fn programs_are_exported_and_checked_for_the_machine_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = own_machine(folder.path());
    let mut window = sample_in(window(fake::engine().0));
    open(&mut window, &path);
    assert_eq!(window.state().state().check_machine(), path.to_str().expect("a name"), "before any export");
    ask(&mut window);
    let machine = window.get_by_role_and_label(Role::ComboBox, "NC machine");
    assert_eq!(machine.accesskit_node().value().as_deref(), Some("own.toml (Mill 5)"));
    let program = folder.path().join("wheel.h");
    save(&mut window, &program);
    let text = std::fs::read_to_string(&program).expect("written");
    assert!(text.contains("MILL 5"), "{}", &text[..400.min(text.len())]);
    check(&mut window, &program);
    let checked = window.state().state().results.checked.clone().expect("checked");
    let on_machine = checked.on_machine.as_ref().expect("NC code");
    assert_eq!(on_machine.machine, read_machine(&path).expect("reads"));
}
