//! The window's own file dialog.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::planned::Side;
use vanecut::app::views::dialogs::SystemAnswer;
use vanecut::geometry::Point;
use vanecut::io::setup_file::read_setup;
use vanecut::io::stl::write_stl;
use vanecut::part::BlankShape;
use vanecut::setup::Setup;

use crate::fake;
use crate::harness::{HANG, Window, choose_in_file_menu, click_enabled, press, settle, with_sample};

/// Types a name into the field of the dialog.
pub fn name_file(window: &mut Window, name: &Path) {
    window.get_by_role_and_label(Role::TextInput, "File").focus();
    window.run_steps(1);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text(name.display().to_string()));
    window.run_steps(2);
    settle(window);
}

pub fn press_enter(window: &mut Window) {
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

/// Exports under a name that is typed.
fn export_as(window: &mut Window, name: &Path) {
    export(window);
    name_file(window, name);
    press_enter(window);
}

/// A dialog of the system that does not open, and says so only when that is asked of it.
struct SlowDialog(Arc<AtomicBool>);

impl SlowDialog {
    fn new(window: &mut Window) -> Self {
        let gives_up = Arc::new(AtomicBool::new(false));
        let waits = Arc::clone(&gives_up);
        window.state_mut().use_file_dialog(Arc::new(move |_, _, _| {
            let start = Instant::now();
            while !waits.load(Ordering::Relaxed) && start.elapsed() < HANG {
                std::thread::sleep(Duration::from_millis(5));
            }
            SystemAnswer::NotOpened
        }));
        Self(gives_up)
    }

    /// Gives up, and waits for the window's own dialog.
    fn give_up(&self, window: &mut Window) {
        self.0.store(true, Ordering::Relaxed);
        let start = Instant::now();
        while window.query_by_role_and_label(Role::TextInput, "File").is_none() {
            assert!(start.elapsed() < HANG, "no dialog");
            std::thread::sleep(Duration::from_millis(10));
            window.run_steps(1);
        }
        settle(window);
    }
}

fn type_keys(window: &mut Window, text: &str) {
    for letter in text.chars() {
        if let Some(key) = egui::Key::from_name(&letter.to_uppercase().to_string()) {
            window.key_press(key);
        }
        window.event(egui::Event::Text(letter.to_string()));
        window.run_steps(1);
    }
}

fn edits(window: &Window) -> usize {
    window.state().state().document.edited.setup.plunge.edits.len()
}

/// On a busy machine it takes seconds until it is known that no dialog of the system opens.
#[test]
fn keys_before_the_file_dialog_is_there_are_its_name_and_reach_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lbm.h");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::ArrowRight);
    window.run_steps(3);
    let look = |window: &Window| {
        let look = &window.state().state().look;
        (look.side, look.arrangement, look.layers.stock, look.measure.is_some())
    };
    let before = look(&window);
    choose_in_file_menu(&mut window, "Export NC program…");
    let dialog = SlowDialog::new(&mut window);
    window.get_by_label("Save as…").click();
    window.run_steps(2);
    std::thread::sleep(Duration::from_millis(1100));
    window.run_steps(2);
    window.get_by_label("Waiting for the system's file dialog (Esc: go on without it)");
    let typed = path.display().to_string();
    let (at_first, rest) = typed.split_at(typed.len() - "m.h".len());
    type_keys(&mut window, at_first);
    press_enter(&mut window);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::D);
    window.run_steps(2);
    assert_eq!((look(&window), edits(&window)), (before, 0), "nothing is switched or locked");
    assert!(window.state().state().document.edited.sets.is_empty(), "no variant is saved");
    dialog.give_up(&mut window);
    let name = |window: &Window| window.get_by_role_and_label(Role::TextInput, "File").value();
    assert_eq!(name(&window), Some(format!("{at_first}.h")), "as if it had been typed there");
    type_keys(&mut window, rest);
    press_enter(&mut window);
    if window.query_by_label("Export anyway").is_some() {
        click_enabled(&window, "Export anyway");
        window.run_steps(3);
        settle(&mut window);
    }
    assert!(path.exists(), "it is written where it was said");
    assert_eq!((look(&window), edits(&window)), (before, 0));
}

/// Who holds Enter on a command that opens the dialog has not read the name that it proposes.
#[test]
fn an_enter_that_is_held_does_not_confirm_the_proposed_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    export_as(&mut window, &folder.path().join("first.apt"));
    let held = |window: &mut Window| {
        let physical_key = Some(egui::Key::Enter);
        let (key, modifiers) = (egui::Key::Enter, egui::Modifiers::NONE);
        window.event(egui::Event::Key { key, physical_key, pressed: true, repeat: false, modifiers });
        window.run_steps(2);
    };
    held(&mut window);
    export(&mut window);
    for _ in 0..3 {
        held(&mut window);
    }
    window.get_by_label("Export CL (APT)");
    assert_eq!(std::fs::read_dir(folder.path()).expect("reads").count(), 1, "the first alone");
}

/// Where no dialog of the system ever opens, Esc gives the keys back.
#[test]
fn escape_goes_on_without_the_file_dialog_of_the_system() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let dialog = SlowDialog::new(&mut window);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::E);
    window.run_steps(2);
    let side = |window: &Window| window.state().state().look.side;
    assert_eq!(side(&window), Side::After);
    type_keys(&mut window, "b");
    assert_eq!(side(&window), Side::After, "while it is awaited");
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    type_keys(&mut window, "b");
    assert_eq!(side(&window), Side::Before);
    dialog.0.store(true, Ordering::Relaxed);
    std::thread::sleep(Duration::from_millis(100));
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::TextInput, "File").is_none(), "it is not asked again");
}

#[test]
fn a_program_can_be_for_some_of_the_channels() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("three.apt");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    choose_in_file_menu(&mut window, "Export CL of several channels…");
    window.get_by_label("of 17, from the first on");
    window.get_by_role_and_label(Role::SpinButton, "Channels").set_value_accesskit(3.0);
    window.run_steps(2);
    window.get_by_label("Time 54 min, without tool changes");
    window.get_by_label("Save as…").click();
    window.run_steps(3);
    settle(&mut window);
    name_file(&mut window, &path);
    press_enter(&mut window);
    let program = vanecut::io::apt::read_apt(&path).expect("a CL file");
    let positions = window.state().state().position_count();
    assert_eq!(program.moves.len(), 3 * 3 * positions, "of three channels");
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
    export_as(&mut window, &folder.path().join("q"));
    assert!(folder.path().join("q.apt").exists());

    export(&mut window);
    name_file(&mut window, &folder.path().join("no/such/p.apt"));
    let missing = format!("The folder {} does not exist", folder.path().join("no/such").display());
    window.get_by_label_contains(&missing);
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Export CL (APT)").is_none(), "one Esc closes it");
}

/// The name that is proposed keeps its ending behind what is typed, and the list takes no keys.
#[test]
fn a_typed_ending_is_not_doubled_and_a_click_in_the_list_leaves_the_keys_to_the_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    export_as(&mut window, &folder.path().join("first.apt"));
    // The next dialog begins in that folder, with one file in its list.
    export(&mut window);
    let name = |window: &Window| window.get_by_role_and_label(Role::TextInput, "File").value();
    for letter in ["n", "e", "w", ".", "a", "p", "t"] {
        window.event(egui::Event::Text(letter.to_owned()));
        window.run_steps(2);
    }
    assert_eq!(name(&window).as_deref(), Some("new.apt"));
    let field = window.get_by_role_and_label(Role::TextInput, "File").rect();
    press(&mut window, field.center_top() - egui::vec2(0.0, 40.0));
    window.run_steps(3);
    window.event(egui::Event::Text("x".to_owned()));
    window.run_steps(2);
    assert_eq!(name(&window).as_deref(), Some("new.aptx"), "it goes on where it was");
    window.key_press(egui::Key::Backspace);
    window.run_steps(2);
    press_enter(&mut window);
    assert!(folder.path().join("new.apt").exists());
}

#[test]
fn a_click_beside_a_dialog_loses_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("typed.apt");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    let click_beside = |window: &mut Window| {
        press(window, egui::pos2(6.0, 560.0));
        window.run_steps(3);
    };
    export(&mut window);
    name_file(&mut window, &path);
    click_beside(&mut window);
    let field = window.get_by_role_and_label(Role::TextInput, "File");
    assert_eq!(field.value(), Some(path.display().to_string()), "as it was typed");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    if window.query_by_label("Export CL (APT)").is_some() {
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
    }
    assert!(window.query_by_label("Export CL (APT)").is_none(), "Esc closes it");
    choose_in_file_menu(&mut window, "Export CL of several channels…");
    window.get_by_role_and_label(Role::SpinButton, "Channels").set_value_accesskit(3.0);
    window.run_steps(2);
    click_beside(&mut window);
    window.get_by_label("Time 54 min, without tool changes");
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

/// The first `count` of the 12 triangles of a box of 1200 × 1200 × 800 mm about the origin.
fn box_stl(count: usize) -> Vec<u8> {
    let corner = |k: usize| {
        let side = |bit: usize, half: f64| if k >> bit & 1 == 1 { half } else { -half };
        Point::new(side(0, 600.0), side(1, 600.0), side(2, 400.0))
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let points: Vec<Point> = (0..8).map(corner).collect();
    write_stl(&points, &triangles[..count], "box")
}

#[test]
fn a_blank_is_picked_from_a_file_and_saved_with_the_setup() {
    let folder = tempfile::tempdir().expect("a folder");
    let (casting, open) = (folder.path().join("casting.stl"), folder.path().join("open.stl"));
    std::fs::write(&casting, box_stl(12)).expect("writes");
    std::fs::write(&open, box_stl(11)).expect("writes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    let shape = |window: &Window| window.state().state().document.edited.setup.allowances.blank.clone();
    let ask = |window: &mut Window| {
        window.get_by_role_and_label(Role::ComboBox, "Blank").click_accesskit();
        window.run_steps(3);
        // A real click, as it closes the list.
        window.get_by_role_and_label(Role::Button, "From file").click();
        window.run_steps(3);
        settle(window);
        window.get_by_label("Open blank");
    };
    ask(&mut window);
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert_eq!(shape(&window), BlankShape::Edges, "nothing was chosen");

    ask(&mut window);
    name_file(&mut window, &open);
    press_enter(&mut window);
    window.get_by_label_contains("is not closed");
    assert_eq!(shape(&window), BlankShape::Edges, "a mesh with a hole is no blank");

    ask(&mut window);
    name_file(&mut window, &casting);
    press_enter(&mut window);
    let BlankShape::File(file) = shape(&window) else { panic!("{:?} is no file", shape(&window)) };
    assert!(file.path == casting && file.mesh.is_some(), "{:?}", file.path);
    window.get_by_role_and_label(Role::Button, "Blank file");

    // The setup beside it names it, and gives it again.
    let (ctx, path) = (window.ctx.clone(), folder.path().join("s.toml"));
    window.state_mut().file_chosen(&ctx, Purpose::SaveSetup, path.clone());
    settle(&mut window);
    let text = std::fs::read_to_string(&path).expect("written");
    assert!(text.contains("blank = \"casting.stl\""), "{text}");
    let read = read_setup(&path, &Setup::default()).expect("reads").allowances.blank;
    assert!(matches!(&read, BlankShape::File(again) if again.outline == file.outline), "{read:?}");
}

#[test]
fn a_save_that_fails_does_not_lead_the_next_dialog_to_its_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    let answers = [folder.path().join("first.toml"), inner.join("taken.toml"), inner.join("third.toml")];
    // A file cannot take the place of a folder.
    std::fs::create_dir_all(&answers[1]).expect("makes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let starts = Arc::new(Mutex::new(Vec::new()));
    let (asked, given) = (Arc::clone(&starts), answers.clone());
    window.state_mut().use_file_dialog(Arc::new(move |_, _, start| {
        let mut asked = asked.lock().expect("whole");
        asked.push(start.map(Path::to_owned));
        SystemAnswer::Chosen(given[asked.len() - 1].clone())
    }));
    for number in 1..=answers.len() {
        choose_in_file_menu(&mut window, "Save setup…");
        let start = Instant::now();
        while starts.lock().expect("whole").len() < number {
            assert!(start.elapsed() < HANG, "no dialog");
            window.run_steps(1);
        }
        settle(&mut window);
    }
    let starts = starts.lock().expect("whole");
    assert_eq!(starts[1..], [Some(folder.path().to_owned()), Some(folder.path().to_owned())]);
    assert!(answers[0].is_file() && answers[1].is_dir() && answers[2].is_file());
}

/// A slow frame brings several keys at once.
#[test]
fn what_is_typed_behind_the_shortcut_of_a_dialog_is_no_shortcut() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    let key = |key, modifiers| egui::Event::Key {
        key,
        pressed: true,
        modifiers,
        repeat: false,
        physical_key: None,
    };
    let keys = [key(egui::Key::E, egui::Modifiers::COMMAND), key(egui::Key::B, egui::Modifiers::NONE)];
    window.input_mut().events.extend(keys);
    window.step();
    window.run_steps(2);
    window.get_by_label("Export CL (APT)");
    assert_eq!(window.state().state().look.side, Side::After);
}

/// What a part is made of is nowhere else: no question is enough to replace it by a file made of it.
#[test]
fn neither_what_is_open_nor_a_file_of_another_kind_is_replaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let (part, library, setup) = (path("pump6.toml"), path("tools.toml"), path("setup.toml"));
    std::fs::write(&part, include_str!("../../assets/parts/pump6.toml")).expect("written");
    std::fs::write(&library, "[[tool]]\nnumber = 1\ndiameter = 10\n").expect("written");
    std::fs::write(&setup, "[plunge]\nstep = 2\n").expect("written");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().open_path(part.clone());
    settle(&mut window);
    window.state_mut().use_own_file_dialogs();
    let refusals = [
        (&part, "Is the part that is open: name another file to write"),
        (&library, "Already exists and is not a setup: name another file to write"),
    ];
    for (file, reason) in refusals {
        let before = std::fs::read(file).expect("reads");
        choose_in_file_menu(&mut window, "Save setup…");
        name_file(&mut window, file);
        press_enter(&mut window);
        window.get_by_label(reason);
        assert!(window.query_by_label("Replace").is_none(), "it is not asked about");
        name_file(&mut window, &setup);
        assert!(window.query_by_label(reason).is_none(), "another name is another matter");
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
        // The dialog of the system has asked whether to replace it.
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, Purpose::SaveSetup, file.clone());
        settle(&mut window);
        window.get_by_label_contains("name another file to write");
        window.get_by_label("Dismiss").click();
        window.run_steps(3);
        assert!(std::fs::read(file).expect("reads") == before, "{} is as it was", file.display());
    }
    choose_in_file_menu(&mut window, "Save setup…");
    name_file(&mut window, &setup);
    press_enter(&mut window);
    window.get_by_label("Replace").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(std::fs::read_to_string(&setup).expect("reads").contains("version = "), "a setup is replaced");
}
