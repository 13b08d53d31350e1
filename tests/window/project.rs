//! The project: saved, opened again, protected by a question before it closes, recovered after a crash.

use std::path::Path;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::{Layers, Operation};
use vanecut::app::model::part_source::PartSource;
use vanecut::app::model::state::Tone;
use vanecut::gpu::scene::FloorColours;
use vanecut::io::project_file::read_project;

use crate::dialogs::{name_file, press_enter};
use crate::fake;
use crate::flank::plan_flank;
use crate::harness::{
    Window, click_enabled, sample_in, settle, snapshot_ui, snapshot_view, window, with_sample, words,
};

fn save_as(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.to_owned());
    settle(window);
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert_eq!(notice.tone, Tone::Done, "{notice:?}");
}

fn edit_step(window: &mut Window, step: f64) {
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(step);
    window.run_steps(3);
    settle(window);
}

#[test]
fn a_project_opens_as_it_was_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tuning.vanecut");
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    first.state_mut().set_home(folder.path().join("home"));
    edit_step(&mut first, 6.0);
    first.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::D);
    first.key_press(egui::Key::Num4);
    first.run_steps(3);
    edit_step(&mut first, 8.0);
    assert!(first.state().state().document.is_unsaved());
    first.get_by_label("not saved yet •");
    save_as(&mut first, &path);
    assert!(!first.state().state().document.is_unsaved());
    first.get_by_label("tuning");
    let camera = first.state().camera().expect("a camera");
    let edited = first.state().state().document.edited.clone();
    drop(first);

    let mut second = window(engine);
    second.state_mut().set_home(folder.path().join("home"));
    second.run_steps(2);
    second.get_by_label("tuning").click();
    second.run_steps(2);
    settle(&mut second);
    let document = &second.state().state().document;
    assert_eq!(document.edited, edited, "setup and sets");
    assert!(!document.is_unsaved() && document.path.as_deref() == Some(path.as_path()));
    let again = second.state().camera().expect("a camera");
    assert!(
        (again.yaw_rad - camera.yaw_rad).abs() < 1e-5 && (again.distance - camera.distance).abs() < 1e-2,
        "the view"
    );
    let state = second.state().state();
    assert!(state.results.figures(&state.document.edited.sets[0].setup).is_some(), "figures of the set");
    assert!(state.problems.is_empty(), "{:?}", state.problems);
    // Saves to the same file without a dialog.
    edit_step(&mut second, 9.0);
    second.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::S);
    second.run_steps(2);
    settle(&mut second);
    assert_eq!(read_project(&path).expect("reads").setup.plunge.step, Some(9.0));
}

/// The text of a project in which `key`, which stands at the byte `at`, is −3.
fn with_faulty_value(text: &str, at: usize, key: &str) -> String {
    let end = at + text[at..].find("\\n").expect("more lines follow");
    format!("{}{key} = -3{}", &text[..at], &text[end..])
}

/// A window with a project, saved at `path`, whose setup has −3 for `keys`.
fn with_faulty_setup(path: &Path, keys: &[&str]) -> Window {
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    edit_step(&mut first, 6.0);
    save_as(&mut first, path);
    let mut text = std::fs::read_to_string(path).expect("reads");
    for key in keys {
        let at = text.find(&format!("{key} = ")).expect("it is written");
        text = with_faulty_value(&text, at, key);
    }
    std::fs::write(path, text).expect("writes");
    let mut second = window(engine);
    second.state_mut().open_path(path.to_owned());
    settle(&mut second);
    second
}

#[test]
fn a_program_with_defaults_for_faulty_values_is_asked_about() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, program) = (folder.path().join("p.vanecut"), folder.path().join("p.apt"));
    let keys = [
        "hub_allowance",
        "blade_allowance",
        "safety_distance",
        "wall_scallop",
        "max_axis_change",
        "max_tilt",
    ];
    let mut window = with_faulty_setup(&path, &keys);
    window.get_by_label("2 more faults in the setups of the project");
    let shown = |window: &Window| window.state().state().field_faults().len();
    assert_eq!(shown(&window), keys.len(), "all are shown at their fields");
    window.get_by_label("Roughing: 6 faulty values");
    // What was read is not corrected.
    window.get_all_by_label("Dismiss").next().expect("a message").click();
    window.run_steps(3);
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    let ctx = window.ctx.clone();
    let export = Purpose::ExportCl { channels: 1 };
    window.state_mut().file_chosen(&ctx, export, program.clone());
    window.run_steps(3);
    window.get_by_label_contains("6 values of the setup in the project were faulty");
    window.get_by_label_contains("(Hub allowance, Blade allowance, Rapid clearance and 3 more)");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    settle(&mut window);
    assert!(!program.exists(), "not without an answer");
    // One that is edited is what the user wants; a default that is saved is a default still.
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(0.4);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(shown(&window), keys.len() - 1);
    window.state_mut().file_chosen(&ctx, export, program.clone());
    window.run_steps(3);
    window.get_by_label_contains("5 values of the setup in the project were faulty");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    save_as(&mut window, &path);
    assert_eq!(shown(&window), keys.len() - 1);
    assert_eq!(read_project(&path).expect("reads").setup_faults.len(), keys.len() - 1);
    window.state_mut().file_chosen(&ctx, export, program.clone());
    window.run_steps(3);
    window.get_by_label_contains("5 values of the setup in the project were faulty");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    // A default that is meant is kept by one click, as if it had been entered.
    let setup = window.state().state().document.edited.setup.clone();
    window.get_all_by_label("Keep the default").next().expect("one at each field").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(shown(&window), keys.len() - 2);
    assert!(window.state().state().document.edited.setup == setup, "nothing else changes");
    window.run_steps(8);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(shown(&window), keys.len() - 1, "it is undone");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Y);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(shown(&window), keys.len() - 2, "and done again");
    window.state_mut().file_chosen(&ctx, export, program.clone());
    window.run_steps(3);
    window.get_by_label_contains("4 values of the setup in the project were faulty");
    window.get_by_label("Export anyway").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(program.exists());
    // Whoever has the sheet alone knows it too.
    let sheet = folder.path().join("sheet.html");
    window.state_mut().file_chosen(
        &ctx,
        Purpose::ExportSheet { operation: Operation::Roughing },
        sheet.clone(),
    );
    window.run_steps(3);
    window.get_by_label("Export anyway").click();
    window.run_steps(3);
    settle(&mut window);
    let page = std::fs::read_to_string(&sheet).expect("a page");
    assert!(
        page.contains("<li>4 values of the setup in the project were faulty: defaults stand in"),
        "{page}"
    );
}

#[test]
fn a_faulty_value_of_a_variant_is_kept_until_it_is_edited() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    first.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::D);
    first.run_steps(3);
    edit_step(&mut first, 6.0);
    save_as(&mut first, &path);
    let text = std::fs::read_to_string(&path).expect("reads");
    let at = text.rfind("hub_allowance = ").expect("the variant comes last");
    std::fs::write(&path, with_faulty_value(&text, at, "hub_allowance")).expect("writes");
    let mut second = window(engine);
    second.state_mut().open_path(path.clone());
    settle(&mut second);
    let shown = |window: &Window| window.state().state().field_faults().len();
    assert_eq!(shown(&second), 0, "the fields are of the current setup");
    second.get_by_label("Load Variant 1").click_accesskit();
    second.run_steps(3);
    settle(&mut second);
    assert_eq!(shown(&second), 1);
    second.get_by_label("Roughing: 1 faulty value");
    save_as(&mut second, &path);
    let saved = read_project(&path).expect("reads");
    assert_eq!(
        (saved.setup_faults.len(), saved.sets[0].faults.len()),
        (1, 1),
        "nobody has said they are meant"
    );
    second.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(0.4);
    second.run_steps(3);
    settle(&mut second);
    assert_eq!(shown(&second), 0);
    save_as(&mut second, &path);
    let saved = read_project(&path).expect("reads");
    assert_eq!((saved.setup_faults.len(), saved.sets[0].faults.len()), (0, 1), "the variant is as it was");
}

#[test]
fn a_project_with_a_faulty_setup_opens_and_says_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let mut second = with_faulty_setup(&path, &["hub_allowance"]);
    let state = second.state().state();
    assert!(state.document.part.is_some(), "the part is open");
    assert_eq!(state.document.edited.setup.plunge.step, Some(6.0), "what is sound stays");
    assert!(!state.document.is_unsaved(), "a saved one keeps the faulty value: nothing is to be lost");
    let said: Vec<_> = state.problems.iter().filter(|p| p.message.contains("Hub allowance")).collect();
    assert!(said.len() == 1 && said[0].help.contains("the default is used"), "{:?}", state.problems);
    let at_field = state.field_faults();
    assert_eq!(at_field.len(), 1, "at its field, too");
    let shown = words(&second, &at_field[0].text).expect("its text is shown");
    assert!(shown.starts_with("`hub_allowance`") || shown.starts_with("\"Hub allowance\""), "{shown}");
    let field = second.get_by_role_and_label(Role::SpinButton, "Hub allowance").rect();
    let text = second.get_by_label(&shown).rect();
    assert!(text.top() >= field.bottom() && text.top() < field.bottom() + 30.0, "{text} below {field}");
    second.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::S);
    second.run_steps(2);
    settle(&mut second);
    let saved = read_project(&path).expect("reads");
    assert_eq!(saved.setup_faults.len(), 1, "nobody has said that the default is meant");
    assert_eq!(second.state().state().field_faults().len(), 1);
    second.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(0.4);
    second.run_steps(3);
    settle(&mut second);
    assert!(second.state().state().field_faults().is_empty(), "the user has given another value");
    second.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::S);
    second.run_steps(2);
    settle(&mut second);
    assert!(read_project(&path).expect("reads").setup_faults.is_empty(), "saved, it is sound");
}

#[test]
fn a_setup_that_cannot_be_planned_says_so_at_its_field() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(12.0);
    window.run_steps(3);
    settle(&mut window);
    let shown = window.state().state().field_faults();
    assert_eq!(shown.len(), 0, "a fault without a place is in the banner alone");
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(16.0);
    window.run_steps(3);
    settle(&mut window);
    let shown = window.state().state().field_faults();
    assert_eq!(shown.len(), 1);
    window.get_by_label(&shown[0].text);
    window.set_size(egui::vec2(1280.0, 900.0));
    window.run_steps(3);
    snapshot_view(&mut window, "fault_at_field");
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(1.0);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().field_faults().is_empty(), "planned");
}

#[test]
fn rapid_approaches_are_switched_on_in_the_form() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1000.0));
    window.run_steps(3);
    let rapid = |window: &Window| window.state().state().document.edited.setup.plunge.rapid_approach;
    assert!(!rapid(&window));
    window.get_by_role_and_label(Role::CheckBox, "Rapid approach").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(rapid(&window));
    window.get_by_label("Reset rapid approach").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(!rapid(&window));
}

#[test]
fn a_second_window_on_a_project_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let (engine, _) = fake::engine();
    let is_open_twice = |window: &Window| {
        let problems = &window.state().state().problems;
        problems.iter().any(|p| p.message.contains("p.vanecut is open in another window"))
    };
    let opened = || {
        let mut window = window(engine.clone());
        window.state_mut().set_home(folder.path().join("home"));
        window.run_steps(2);
        window
    };
    let mut first = sample_in(opened());
    save_as(&mut first, &path);
    first.run_steps(2);
    let mut second = opened();
    second.state_mut().open_path(path.clone());
    settle(&mut second);
    assert!(is_open_twice(&second) && !is_open_twice(&first), "only the second one");
    // A new project lets the file go.
    first.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::N);
    first.run_steps(3);
    // The harness clock advances by a quarter of a second per frame.
    second.run_steps(8);
    assert!(!is_open_twice(&second), "{:?}", second.state().state().problems);
    assert!(second.query_by_label_contains("is open in another window").is_none());
    let mut third = opened();
    third.state_mut().open_path(path);
    settle(&mut third);
    assert!(is_open_twice(&third), "the second one still has it");
    drop(second);
    third.run_steps(8);
    assert!(!is_open_twice(&third), "{:?}", third.state().state().problems);
}

#[test]
fn a_part_that_changed_since_is_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = folder.path().join("wheel.toml");
    let text = include_str!("../../assets/parts/impeller532.toml");
    std::fs::write(&part, text).expect("writes");
    let path = folder.path().join("p.vanecut");
    let (engine, _) = fake::engine();
    let mut first = window(engine.clone());
    first.state_mut().open_path(part.clone());
    settle(&mut first);
    save_as(&mut first, &path);
    std::fs::write(&part, text.replace("blades = 17", "blades = 15")).expect("writes");
    let mut second = window(engine.clone());
    second.state_mut().open_path(path.clone());
    settle(&mut second);
    let problems = second.state().state().problems.clone();
    assert!(problems.iter().any(|p| p.message.contains("the part changed")), "{problems:?}");
    std::fs::remove_file(&part).expect("removes");
    // A recovery copy is known by its project.
    let text_of_project = std::fs::read_to_string(&path).expect("reads");
    let mut copy: serde_json::Value = serde_json::from_str(&text_of_project).expect("JSON");
    copy["original"] = path.to_string_lossy().into();
    let copy_path = folder.path().join("1-2.vanecut");
    std::fs::write(&copy_path, copy.to_string()).expect("writes");
    let mut of_copy = window(engine.clone());
    of_copy.state_mut().open_path(copy_path);
    settle(&mut of_copy);
    of_copy.get_by_label("The part of p.vanecut is not found");
    let mut third = window(engine);
    third.state_mut().open_path(path);
    settle(&mut third);
    // It was only renamed.
    let renamed = folder.path().join("renamed.toml");
    std::fs::write(&renamed, text).expect("writes");
    third.get_by_label("The part of p.vanecut is not found");
    third.get_by_label_contains(&part.display().to_string());
    third.state_mut().use_own_file_dialogs();
    third.get_by_label("Locate…").click();
    third.run_steps(3);
    name_file(&mut third, &renamed);
    press_enter(&mut third);
    let document = &third.state().state().document;
    assert_eq!(document.part.as_ref().map(|part| part.source.clone()), Some(PartSource::File(renamed)));
    assert!(document.is_unsaved(), "the project names the other file");
    let problems = &third.state().state().problems;
    assert!(problems.is_empty(), "it is the same part: {problems:?}");
}

#[test]
fn unsaved_changes_are_asked_for_before_they_are_lost() {
    let (engine, _) = fake::engine();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let mut window = with_sample(engine);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::N);
    window.run_steps(3);
    assert!(window.state().state().document.part.is_none(), "nothing to lose: closed at once");
    window.get_by_label("pump6").click();
    window.run_steps(2);
    settle(&mut window);
    save_as(&mut window, &path);
    edit_step(&mut window, 6.0);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::N);
    window.run_steps(3);
    window.get_by_label("Save the changes of p.vanecut?");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    assert!(window.state().state().document.part.is_some(), "still open");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::N);
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Save").click();
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(read_project(&path).expect("reads").setup.plunge.step, Some(6.0), "saved");
    assert!(window.state().state().document.part.is_none(), "and closed");
    snapshot_ui(&mut window, "empty_again");
}

#[test]
fn a_crash_loses_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let project = folder.path().join("p.vanecut");
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    first.state_mut().set_home(home.clone());
    save_as(&mut first, &project);
    let saved = std::fs::read(&project).expect("reads");
    edit_step(&mut first, 6.5);
    // The harness clock advances by a quarter of a second per frame; the copy is written within a second.
    first.run_steps(14);
    let recovery = home.join("recovery");
    let copies = || -> Vec<_> {
        std::fs::read_dir(&recovery).into_iter().flatten().flatten().map(|e| e.path()).collect()
    };
    let copy = copies().pop().expect("a copy");
    assert_eq!(std::fs::read(&project).expect("reads"), saved, "the project itself is untouched");
    let mut beside = window(engine.clone());
    beside.state_mut().set_home(home.clone());
    beside.run_steps(2);
    assert!(beside.query_by_label("Recover").is_none(), "its session runs");
    drop(beside);
    // The crash: nothing of the first window gets to run any more, and the system unlocks what it held. The
    // next start, at once, offers the copy.
    drop(first);
    let orphan = copy;
    let mut second = window(engine.clone());
    second.state_mut().set_home(home.clone());
    second.run_steps(2);
    second.get_by_label("Unsaved changes of p, just now");
    second.get_by_label("Recover").click();
    second.run_steps(2);
    settle(&mut second);
    let document = &second.state().state().document;
    assert_eq!(document.edited.setup.plunge.step, Some(6.5), "what was edited is there");
    assert!(document.is_unsaved(), "and not saved yet");
    assert_eq!(document.path.as_deref(), Some(project.as_path()), "it knows where it belongs");
    assert_eq!(std::fs::read(&project).expect("reads"), saved, "the project itself is still untouched");
    assert!(!orphan.exists() && copies().len() == 1, "this session keeps the copy now: {:?}", copies());
    second.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::S);
    second.run_steps(2);
    settle(&mut second);
    assert_eq!(read_project(&project).expect("reads").setup.plunge.step, Some(6.5), "saved where it belongs");
    assert!(copies().is_empty(), "nothing is left to recover");
}

fn save(window: &mut Window) {
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::S);
    window.run_steps(2);
    settle(window);
}

#[test]
fn what_another_window_has_saved_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, other) = (folder.path().join("p.vanecut"), folder.path().join("q.vanecut"));
    let step = |path: &Path| read_project(path).expect("reads").setup.plunge.step;
    let (engine, _) = fake::engine();
    let opened = || {
        let mut window = window(engine.clone());
        window.state_mut().set_home(folder.path().join("home"));
        window.state_mut().use_own_file_dialogs();
        window.run_steps(2);
        window
    };
    let mut first = sample_in(opened());
    save_as(&mut first, &path);
    let mut second = opened();
    second.state_mut().open_path(path.clone());
    settle(&mut second);
    edit_step(&mut first, 6.0);
    save(&mut first);
    assert_eq!(step(&path), Some(6.0), "nobody else has saved");
    edit_step(&mut second, 7.0);
    save(&mut second);
    second.get_by_label("p.vanecut was changed on disk");
    click_enabled(&second, "Cancel");
    second.run_steps(3);
    settle(&mut second);
    assert_eq!(step(&path), Some(6.0), "nothing is lost");
    assert!(second.state().state().document.is_unsaved());
    save(&mut second);
    second.get_by_label("Overwrite").click();
    second.run_steps(3);
    settle(&mut second);
    assert_eq!(step(&path), Some(7.0), "as it was asked for");
    edit_step(&mut second, 7.5);
    save(&mut second);
    assert_eq!(step(&path), Some(7.5), "asked once");
    // The other way round; this time both are wanted.
    edit_step(&mut first, 8.0);
    save(&mut first);
    first.get_by_label("p.vanecut was changed on disk");
    first.get_by_label("Save as…").click();
    first.run_steps(3);
    settle(&mut first);
    name_file(&mut first, &other);
    press_enter(&mut first);
    assert_eq!((step(&path), step(&other)), (Some(7.5), Some(8.0)));
    assert!(!first.state().state().document.is_unsaved());
}

#[test]
fn a_part_that_was_opened_is_among_the_recent_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = folder.path().join("wheel.toml");
    let text = include_bytes!("../../assets/parts/pump6.toml");
    std::fs::write(&part, text).expect("writes");
    let (engine, _) = fake::engine();
    let mut first = window(engine.clone());
    first.state_mut().set_home(folder.path().join("home"));
    first.state_mut().open_path(part.clone());
    settle(&mut first);
    let part = std::path::absolute(part).expect("a path");
    assert_eq!(first.state().state().recents, std::slice::from_ref(&part));
    // The next window offers it.
    let mut next = window(engine);
    next.state_mut().set_home(folder.path().join("home"));
    next.run_steps(2);
    next.get_by_label("wheel.toml").click();
    next.run_steps(2);
    settle(&mut next);
    assert!(next.state().state().document.part.is_some());
}

#[test]
fn a_project_opens_in_the_operation_it_was_saved_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    plan_flank(&mut first, 10.0);
    save_as(&mut first, &path);
    assert!(read_project(&path).expect("reads").chosen.flank);
    let mut second = window(engine);
    second.state_mut().open_path(path);
    settle(&mut second);
    let state = second.state().state();
    assert_eq!(state.look.operation, Operation::Flank);
    assert!(state.results.flank.is_some() && state.results.planned.is_some(), "both are calculated");
}

#[test]
fn what_the_view_shows_is_saved_and_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    edit_step(&mut first, 6.0);
    first.get_by_role_and_label(Role::Button, "Layers").click();
    first.run_steps(2);
    for layer in ["Shroud", "Cutters", "Rapids"] {
        first.get_by_role_and_label(Role::CheckBox, layer).click();
        first.run_steps(2);
    }
    first.get_by_role_and_label(Role::RadioButton, "Core contact").click();
    first.run_steps(2);
    first.key_press(egui::Key::Escape);
    first.run_steps(2);
    let shown = first.state().state().look.layers;
    assert!(shown.shroud && shown.links && !shown.cutters && shown.floor == FloorColours::Interference);
    save_as(&mut first, &path);
    assert!(!first.state().state().document.is_unsaved());
    let mut second = window(engine.clone());
    second.state_mut().open_path(path.clone());
    settle(&mut second);
    assert_eq!(second.state().state().look.layers, shown);
    // An older project, and one of a newer window, open all the same.
    let text = std::fs::read_to_string(&path).expect("reads");
    let mut file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    file["layers"]["layers"]["floor"] = "temperature".into();
    for is_older in [false, true] {
        if is_older {
            file.as_object_mut().expect("an object").remove("layers");
        }
        std::fs::write(&path, file.to_string()).expect("writes");
        let mut third = window(engine.clone());
        third.state_mut().open_path(path.clone());
        settle(&mut third);
        assert_eq!(third.state().state().look.layers, Layers::default());
        assert_eq!(third.state().state().document.edited.setup.plunge.step, Some(6.0));
    }
}
