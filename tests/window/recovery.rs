//! Unsaved changes that a session left behind: where they are offered, and where they are saved.

use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::project_file::read_project;

use crate::dialogs::{name_file, press_enter};
use crate::fake;
use crate::harness::{Window, click_enabled, settle, window};

fn window_at(engine: &Engine, home: &Path) -> Window {
    let mut window = window(engine.clone());
    window.state_mut().set_home(home.to_owned());
    window.state_mut().use_own_file_dialogs();
    window.run_steps(2);
    window
}

/// As [`window_at`], with a part of `folder` open.
fn window_with_part(engine: &Engine, home: &Path, folder: &Path) -> Window {
    let mut window = window_at(engine, home);
    window.state_mut().open_path(part_in(folder));
    settle(&mut window);
    window
}

/// As [`window_with_part`], with its project saved at `path`.
fn window_with_saved(engine: &Engine, home: &Path, folder: &Path, path: &Path) -> Window {
    let mut window = window_with_part(engine, home, folder);
    save_as(&mut window, path);
    window
}

/// As [`window_at`], with the project at `path` open.
fn window_with_project(engine: &Engine, home: &Path, path: &Path) -> Window {
    let mut window = window_at(engine, home);
    window.state_mut().open_path(path.to_owned());
    settle(&mut window);
    window
}

fn save_as(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.to_owned());
    settle(window);
}

fn edit_step(window: &mut Window, step: f64) {
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(step);
    window.run_steps(3);
    settle(window);
}

/// Edits, and waits until the recovery copy is written.
fn edit_until_copied(window: &mut Window, step: f64) {
    edit_step(window, step);
    // The harness clock advances by a quarter of a second per frame.
    window.run_steps(14);
}

/// The same, and crashes: nothing of the window gets to run any more.
fn edit_and_crash(mut window: Window, step: f64) {
    edit_until_copied(&mut window, step);
    drop(window);
}

fn step(window: &Window) -> Option<f64> {
    window.state().state().document.edited.setup.plunge.step
}

fn press(window: &mut Window, modifiers: egui::Modifiers, key: egui::Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(3);
    settle(window);
}

/// Takes the offer to recover unsaved changes.
fn recover(window: &mut Window) {
    window.get_by_label("Recover").click();
    window.run_steps(3);
    settle(window);
}

/// A part file in `folder`.
fn part_in(folder: &Path) -> PathBuf {
    let part = folder.join("wheel.toml");
    std::fs::write(&part, include_str!("../../assets/parts/impeller532.toml")).expect("writes");
    part
}

#[test]
fn what_is_recovered_is_saved_beside_its_part_and_not_among_the_copies() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let first = window_with_part(&engine, &home, folder.path());
    edit_and_crash(first, 6.5);
    let mut second = window_at(&engine, &home);
    recover(&mut second);
    assert_eq!(step(&second), Some(6.5));
    press(&mut second, egui::Modifiers::COMMAND, egui::Key::S);
    second.get_by_label("Save project");
    second.get_by_label(&folder.path().display().to_string());
    press_enter(&mut second);
    let saved = folder.path().join("impeller532.vanecut");
    assert!(saved.exists(), "beside the part");
    let copies = std::fs::read_dir(home.join("recovery")).into_iter().flatten().count();
    assert_eq!(copies, 0, "nothing is left to recover");
}

/// A window that is started with another part does not show the start page, which offers them.
#[test]
fn unsaved_changes_of_another_part_are_named_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    edit_and_crash(window_with_part(&engine, &home, folder.path()), 6.5);
    let other = folder.path().join("other.toml");
    std::fs::write(&other, include_str!("../../assets/parts/pump6.toml")).expect("writes");
    let mut second = window_with_project(&engine, &home, &other);
    let said = "A session that ended without closing has left unsaved changes: wheel";
    second.get_by_label_contains(said);
    second.get_by_label_contains("Choose File > New to recover or discard them");
    second.get_by_label("Dismiss").click();
    second.run_steps(3);
    second.state_mut().open_path(other.clone());
    settle(&mut second);
    assert!(second.query_by_label_contains(said).is_none(), "it is known");
    press(&mut second, egui::Modifiers::COMMAND, egui::Key::N);
    recover(&mut second);
    assert_eq!(step(&second), Some(6.5));
}

#[test]
fn a_project_opened_by_a_relative_path_is_recovered_where_it_belongs() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (part, project) = (part_in(folder.path()), folder.path().join("p.vanecut"));
    let (engine, _) = fake::engine();
    let mut first = window_at(&engine, &home);
    first.state_mut().open_path(part);
    settle(&mut first);
    save_as(&mut first, &project);
    drop(first);
    // As it is named when the program is started beside it.
    let depth = std::env::current_dir().expect("a folder").components().count() - 1;
    let relative = PathBuf::from("../".repeat(depth)).join(project.strip_prefix("/").expect("absolute"));
    assert!(relative.is_relative() && relative.exists());
    let mut second = window_at(&engine, &home);
    second.state_mut().open_path(relative);
    settle(&mut second);
    edit_and_crash(second, 6.5);
    let copies: Vec<PathBuf> =
        std::fs::read_dir(home.join("recovery")).expect("reads").flatten().map(|e| e.path()).collect();
    let original = read_project(&copies[0]).expect("a copy").original.expect("it has a file");
    assert!(original.is_absolute(), "{} says nothing in another folder", original.display());
    assert_eq!(original.canonicalize().ok(), project.canonicalize().ok());
}

#[test]
fn unsaved_changes_of_a_project_are_offered_when_it_is_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, project) = (folder.path().join("home"), folder.path().join("p.vanecut"));
    let (engine, _) = fake::engine();
    edit_and_crash(window_with_saved(&engine, &home, folder.path(), &project), 6.5);
    let opened = || window_with_project(&engine, &home, &project);
    let mut later = opened();
    later.get_by_label("Unsaved changes of p, just now");
    assert_eq!(step(&later), None, "as it was saved");
    later.get_by_label("Not now").click();
    later.run_steps(3);
    assert!(later.query_by_label("Unsaved changes of p, just now").is_none());
    drop(later);
    let mut recovered = opened();
    recover(&mut recovered);
    assert_eq!(step(&recovered), Some(6.5), "what was edited is there");
    let document = &recovered.state().state().document;
    assert!(document.is_unsaved() && document.path.as_deref() == Some(project.as_path()));
    // The crash leaves the copy of this session; this time it is not wanted.
    drop(recovered);
    let mut discarded = opened();
    discarded.get_by_label("Discard").click();
    discarded.run_steps(3);
    assert_eq!(step(&discarded), None, "as it was saved");
    drop(discarded);
    let mut last = opened();
    assert!(last.query_by_label("Recover").is_none(), "nothing is left");
    last.run_steps(1);
}

#[test]
fn what_was_saved_after_a_crash_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, project) = (folder.path().join("home"), folder.path().join("p.vanecut"));
    let (engine, _) = fake::engine();
    edit_and_crash(window_with_saved(&engine, &home, folder.path(), &project), 6.5);
    let opened = |answer: &str| {
        let mut window = window_with_project(&engine, &home, &project);
        window.get_by_label(answer).click();
        window.run_steps(3);
        settle(&mut window);
        window
    };
    let mut beside = opened("Not now");
    edit_step(&mut beside, 7.0);
    press(&mut beside, egui::Modifiers::COMMAND, egui::Key::S);
    drop(beside);
    let mut recovered = opened("Recover");
    assert_eq!(step(&recovered), Some(6.5));
    press(&mut recovered, egui::Modifiers::COMMAND, egui::Key::S);
    recovered.get_by_label("p.vanecut was changed on disk");
    assert_eq!(read_project(&project).expect("reads").setup.plunge.step, Some(7.0), "still there");
}

#[test]
fn what_another_window_saved_before_a_crash_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, project) = (folder.path().join("home"), folder.path().join("p.vanecut"));
    let (engine, _) = fake::engine();
    let first = window_with_saved(&engine, &home, folder.path(), &project);
    let mut other = window_with_project(&engine, &home, &project);
    edit_step(&mut other, 7.0);
    press(&mut other, egui::Modifiers::COMMAND, egui::Key::S);
    assert_eq!(read_project(&project).expect("reads").setup.plunge.step, Some(7.0), "saved");
    drop(other);
    // Its copy is newer than what the other window has saved.
    edit_and_crash(first, 6.5);
    let mut recovered = window_with_project(&engine, &home, &project);
    recover(&mut recovered);
    assert_eq!(step(&recovered), Some(6.5));
    press(&mut recovered, egui::Modifiers::COMMAND, egui::Key::S);
    recovered.get_by_label("p.vanecut was changed on disk");
    assert_eq!(read_project(&project).expect("reads").setup.plunge.step, Some(7.0), "still there");
}

#[test]
fn a_message_on_the_start_page_does_not_hide_what_it_offers() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let first = window_with_part(&engine, &home, folder.path());
    edit_and_crash(first, 6.5);
    let mut second = window_at(&engine, &home);
    // As many as are shown without scrolling.
    for name in ["a", "b"] {
        second.state_mut().open_path(folder.path().join(name).with_extension("toml"));
        settle(&mut second);
    }
    let offer = second.get_by_label("Unsaved changes of wheel, just now").rect();
    let messages = second.get_all_by_label_contains("cannot be read").map(|message| message.rect());
    let shown = messages.filter(|message| message.intersects(offer)).count();
    assert_eq!(shown, 0, "it can be read at {offer}");
    assert!(offer.top() > 100.0, "below the messages");
}

#[test]
fn what_waited_for_a_cancelled_saving_waits_no_longer() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = window_at(&engine, &folder.path().join("home"));
    window.state_mut().open_path(part_in(folder.path()));
    settle(&mut window);
    edit_step(&mut window, 6.0);
    press(&mut window, egui::Modifiers::COMMAND, egui::Key::N);
    window.get_by_role_and_label(Role::Button, "Save").click();
    window.run_steps(3);
    window.get_by_label("Save project");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(window.state().state().document.part.is_some(), "the user stays");
    press(&mut window, egui::Modifiers::COMMAND, egui::Key::S);
    name_file(&mut window, &folder.path().join("p.vanecut"));
    press_enter(&mut window);
    settle(&mut window);
    let document = &window.state().state().document;
    assert!(!document.is_unsaved() && document.part.is_some(), "saved, and still open");
    // Another name is proposed from its own.
    press(&mut window, egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, egui::Key::S);
    let field = window.get_by_role_and_label(Role::TextInput, "File");
    assert_eq!(field.value().as_deref(), Some("p.vanecut"));
    click_enabled(&window, "Cancel");
    window.run_steps(2);
}

/// Nobody pauses for two seconds after each edit.
#[test]
fn edits_are_copied_while_editing_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let mut first = window_with_part(&engine, &home, folder.path());
    // An edit each half second of the window's clock, for six seconds.
    for k in 0..12 {
        let field = first.get_by_role_and_label(Role::SpinButton, "Step");
        field.set_value_accesskit(5.0 + 0.25 * f64::from(k));
        first.run_steps(2);
    }
    drop(first);
    let mut second = window_at(&engine, &home);
    recover(&mut second);
    // All but those of the last two seconds.
    let recovered = step(&second).expect("an edit");
    assert!(recovered >= 5.0 + 0.25 * 7.0, "{recovered}");
}

/// The program started with a part file shows no start page, which lists them.
#[test]
fn unsaved_changes_are_offered_where_their_part_is_opened_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let first = window_with_part(&engine, &home, folder.path());
    edit_and_crash(first, 6.5);
    let mut second = window_with_part(&engine, &home, folder.path());
    second.get_by_label_contains("Unsaved changes of wheel");
    assert_eq!(step(&second), None, "not before the answer");
    recover(&mut second);
    assert_eq!(step(&second), Some(6.5));
    assert!(second.query_by_label_contains("Unsaved changes of wheel").is_none());
}

#[test]
fn what_another_window_has_recovered_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let first = window_with_part(&engine, &home, folder.path());
    edit_and_crash(first, 6.5);
    let mut second = window_at(&engine, &home);
    let mut third = window_at(&engine, &home);
    for window in [&mut second, &mut third] {
        recover(window);
    }
    assert_eq!(step(&second), Some(6.5));
    let said = third.state().state().problems.last().cloned().expect("a problem");
    assert!(said.message.starts_with("Another window has recovered"), "{said:?}");
    assert!(third.query_by_label("Recover").is_none(), "it is offered no longer");
}

#[test]
fn a_recovered_project_still_has_the_faults_of_its_setup() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, project) = (folder.path().join("home"), folder.path().join("p.vanecut"));
    let (engine, _) = fake::engine();
    drop(window_with_saved(&engine, &home, folder.path(), &project));
    let text = std::fs::read_to_string(&project).expect("reads");
    let faulty = text.replacen("hub_allowance = 0.5", "hub_allowance = -3", 1);
    assert_ne!(faulty, text);
    std::fs::write(&project, faulty).expect("writes");
    let second = window_with_project(&engine, &home, &project);
    let said = second.state().state().field_faults();
    assert_eq!(said.len(), 1);
    edit_and_crash(second, 6.5);
    let mut third = window_at(&engine, &home);
    recover(&mut third);
    let state = third.state().state();
    assert_eq!(state.document.path.as_deref(), Some(project.as_path()));
    assert_eq!((step(&third), state.field_faults()), (Some(6.5), said), "the default is still one");
    third.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(0.4);
    third.run_steps(3);
    settle(&mut third);
    assert!(third.state().state().document.edited.replaced.is_empty());
}

#[test]
fn what_was_undone_is_not_offered_after_a_crash() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let mut first = window_with_part(&engine, &home, folder.path());
    edit_until_copied(&mut first, 6.5);
    let copies = || std::fs::read_dir(home.join("recovery")).into_iter().flatten().count();
    assert!(copies() > 0, "written");
    press(&mut first, egui::Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(step(&first), None);
    first.run_steps(2);
    drop(first);
    assert_eq!(copies(), 0, "nothing is left to recover");
}

/// A session that was killed holds its copy until the system has freed what it had.
#[test]
fn the_start_page_offers_the_copy_of_a_session_that_ends_after_it_is_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let mut dying = window_with_part(&engine, &home, folder.path());
    edit_until_copied(&mut dying, 7.5);
    let mut next = window_at(&engine, &home);
    next.run_steps(8);
    assert!(next.query_by_label("Recover").is_none(), "its session runs");
    drop(dying);
    next.run_steps(8);
    recover(&mut next);
    assert_eq!(step(&next), Some(7.5));
}

/// The same where the part is given at the start, as after a crash it mostly is.
#[test]
fn an_open_part_offers_the_copy_of_a_session_that_ends_after_it_is_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let mut dying = window_with_part(&engine, &home, folder.path());
    edit_until_copied(&mut dying, 7.5);
    let mut next = window_with_part(&engine, &home, folder.path());
    next.run_steps(8);
    assert!(next.query_by_label("Recover").is_none(), "its session runs");
    edit_step(&mut next, 3.0);
    drop(dying);
    next.run_steps(8);
    next.get_by_label("Unsaved changes of wheel, just now");
    recover(&mut next);
    // What was edited meanwhile is not lost unasked.
    assert_eq!(step(&next), Some(3.0));
    click_enabled(&next, "Don't save");
    next.run_steps(3);
    settle(&mut next);
    assert_eq!(step(&next), Some(7.5));
}

/// As on a full disk: what could be read is not removed before it is written elsewhere.
#[cfg(target_os = "linux")]
#[test]
fn a_copy_stays_where_what_was_recovered_cannot_be_copied() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let near = folder.path().join("home");
    edit_and_crash(window_with_part(&engine, &near, folder.path()), 6.5);
    let mut left = std::fs::read_dir(near.join("recovery")).expect("reads").flatten().map(|e| e.path());
    let left = left.find(|path| path.extension().is_some_and(|e| e == "vanecut")).expect("a copy");
    // A path may have 4095 bytes: too few for the name of a new copy, enough for a short one.
    let mut home = folder.path().to_owned();
    let wanted = 4095 - "/recovery/1-1.vanecut".len();
    while home.as_os_str().len() < wanted {
        let rest = wanted - home.as_os_str().len() - 1;
        home.push("d".repeat(if rest > 202 { 200 } else { rest }));
    }
    std::fs::create_dir_all(home.join("recovery")).expect("makes");
    let copy = home.join("recovery/1-1.vanecut");
    std::fs::rename(left, &copy).expect("moves");
    let mut window = window_at(&engine, &home);
    recover(&mut window);
    assert_eq!(step(&window), Some(6.5));
    assert!(copy.exists(), "the only copy");
    window.get_by_label_contains("No recovery copy was written");
}

/// One colour means one height, also in the next session.
#[test]
fn colour_scales_stay_when_a_project_is_opened_again_or_recovered() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, path) = (folder.path().join("home"), folder.path().join("p.vanecut"));
    let (engine, _) = fake::engine();
    let mut first = window_with_saved(&engine, &home, folder.path(), &path);
    let scales = |window: &Window| {
        let look = &window.state().state().look;
        (look.range, look.wall_end)
    };
    let fitted = scales(&first);
    assert!(fitted.0.is_some() && fitted.1.is_none());
    let look = first.state_mut().look_mut();
    (look.range, look.wall_end) = (Some((0.35, 2.7)), Some(0.013));
    save_as(&mut first, &path);
    drop(first);
    let mut second = window_with_project(&engine, &home, &path);
    assert_eq!(scales(&second), (Some((0.35, 2.7)), Some(0.013)));
    // The copy has the scales of the moment, although the edit is older.
    edit_until_copied(&mut second, 7.0);
    let look = second.state_mut().look_mut();
    (look.range, look.wall_end) = (Some((0.1, 0.9)), None);
    second.run_steps(14);
    drop(second);
    let mut third = window_with_project(&engine, &home, &path);
    click_enabled(&third, "Recover");
    third.run_steps(3);
    settle(&mut third);
    assert_eq!((step(&third), scales(&third)), (Some(7.0), (Some((0.1, 0.9)), None)));
    // Those of a project of another program are fitted.
    let text = std::fs::read_to_string(&path).expect("reads");
    std::fs::write(&path, text.replace("2.7", "0.1")).expect("writes");
    let other = window_with_project(&engine, &folder.path().join("other"), &path);
    assert_eq!(scales(&other).0, fitted.0);
}

/// What moves under the pointer when an offer goes is not discarded by the same gesture.
#[test]
fn discarding_asks_and_copies_of_one_part_have_exact_ages() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    edit_and_crash(window_with_part(&engine, &home, folder.path()), 6.5);
    let mut second = window_with_part(&engine, &home, folder.path());
    second.get_by_label("Not now").click();
    second.run_steps(3);
    edit_and_crash(second, 5.5);
    let mut start = window_at(&engine, &home);
    let offers = |window: &Window| window.query_all_by_label_contains("Unsaved changes of wheel, ").count();
    assert_eq!(offers(&start), 2);
    assert_eq!(start.query_all_by_label_contains(" s ago").count(), 2, "not both `just now`");
    let discard = |window: &mut Window| {
        window.get_all_by_label("Discard").next().expect("an offer").click();
        window.run_steps(3);
        window.get_by_label_contains("Discard the unsaved changes of wheel");
    };
    discard(&mut start);
    start.key_press(egui::Key::Escape);
    start.run_steps(3);
    assert_eq!(offers(&start), 2, "both are still there");
    discard(&mut start);
    start.get_all_by_label("Discard").last().expect("the answer").click();
    start.run_steps(3);
    assert_eq!(offers(&start), 1);
}
