//! A programmer's whole session with a part: find interfering plunges, tune until there are none,
//! compare, plan flank milling, write files, and continue in a later session.

use std::path::Path;
use std::process::Command;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::state::Tone;
use vanecut::app::views::theme::Condition;
use vanecut::io::apt::read_apt;

use crate::drop::drop_on;
use crate::fake::shared_engine;
use crate::harness::{Window, settle, window, words};

/// A window on a small screen, with its home folder.
fn on_a_small_screen(home: &Path) -> Window {
    let mut window = window(shared_engine());
    window.set_size(egui::vec2(1280.0, 800.0));
    window.state_mut().set_home(home.to_owned());
    window.run_steps(3);
    window
}

fn choose(window: &mut Window, list: &str, entry: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).click_accesskit();
    window.run_steps(3);
    // A real click, as it closes the list.
    window.get_by_role_and_label(Role::Button, entry).click();
    window.run_steps(3);
    settle(window);
}

fn set(window: &mut Window, field: &str, value: f64) {
    window.get_by_role_and_label(Role::SpinButton, field).set_value_accesskit(value);
    window.run_steps(3);
    settle(window);
}

/// The two counts of the verdict.
fn interferential(window: &Window) -> (usize, usize) {
    let verdict = words(window, "Interfering plunges ").expect("a verdict");
    let counts = verdict.strip_prefix("Interfering plunges ").and_then(|counts| counts.split_once(" to "));
    let (before, after) = counts.unwrap_or_else(|| panic!("{verdict}"));
    (before.parse().expect("a count"), after.parse().expect("a count"))
}

fn save(window: &mut Window, purpose: Purpose, path: &Path) {
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, purpose, path.to_owned());
    window.run_steps(2);
    settle(window);
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert_eq!(notice.tone, Tone::Done, "{notice:?}");
    window.get_by_label(&notice.text);
}

#[test]
fn from_a_dropped_part_to_files_and_back_on_another_day() {
    let part = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller532.toml");
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let mut window = on_a_small_screen(&home);
    drop_on(&mut window, &[&part]);
    window.get_by_label("impeller532");

    // Conventional axes: find the worst plunge and its reason.
    choose(&mut window, "Axis strategy", "Isoparametric");
    let (faults, same) = interferential(&window);
    assert!(faults > 100 && same == faults, "{faults} to {same}");
    window.get_by_label("Sort by contact").click();
    window.run_steps(3);
    let worst = window.state().state().rows()[0];
    window.get_by_role_and_label(Role::Row, &format!("Position {}", worst + 1)).click();
    window.run_steps(8);
    settle(&mut window);
    window.get_by_label(&format!("Sectional view through position {}", worst + 1));
    let count = window.state().state().position_count();
    let word = Condition::Interfering.label();
    window.get_by_label(&format!("Position {} of {count}: {word}", worst + 1));
    let why = words(&window, "Core hits stock ").expect("the reason");
    let depth = why.split_whitespace().nth(3).and_then(|depth| depth.parse::<f64>().ok());
    let deepest = window.state().state().selected().expect("selected").evaluation.contact.depth;
    assert!(deepest > 1.0 && depth.is_some_and(|depth| (depth - deepest).abs() < 0.006), "{why}");

    // Tuning: a shorter step alone is not enough, monotone axes remove most, the search removes all.
    set(&mut window, "Step", 4.0);
    let (finer, _) = interferential(&window);
    assert!(finer > 0, "a shorter step leaves {finer}");
    set(&mut window, "Max tilt", 50.0);
    choose(&mut window, "Axis strategy", "Progressive");
    let (_, few) = interferential(&window);
    assert!(few * 20 < finer, "the rule repairs most: {few} of {finer}");
    choose(&mut window, "Axis strategy", "Min. stock");
    let (before, after) = interferential(&window);
    assert!(before > 0 && after == 0, "{before} to {after}");
    assert!(words(&window, "Core hits stock").is_none(), "no reason is left");
    let setup = window.state().state().document.edited.setup.clone();
    assert_eq!(setup.plunge.step, Some(4.0), "the setup is what was tuned");

    // Residual stock before and after, side by side, at the same points of the hub.
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::B);
    window.key_press(egui::Key::Num4);
    window.state_mut().look_mut().layers.cutters = false;
    window.run_steps(6);
    settle(&mut window);
    let view = window.get_by_label("3D view, after").rect();
    let (mut left, mut left_before, mut places) = (0.0, 0.0, 0);
    // Points spread over the view in a pseudo-random order.
    for k in (1..400).map(|k| 147 * k % 400) {
        let share = egui::vec2((k % 20) as f32 / 20.0, (k / 20) as f32 / 20.0);
        window.hover_at(view.min + view.size() * share);
        window.step();
        let Some(said) = words(&window, ", before ") else { continue };
        let figures = said.trim_end_matches(" mm").split_once(", before ");
        let (here, before) = figures.unwrap_or_else(|| panic!("{said}"));
        left += here.parse::<f64>().expect("a figure");
        left_before += before.parse::<f64>().expect("a figure");
        places += 1;
        if places == 20 {
            break;
        }
    }
    assert!(places > 10, "{places} places of the hub have both figures");
    assert!(left < 0.9 * left_before, "{left} in place of {left_before} at {places} places");
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::B);
    window.run_steps(3);

    // Flank milling by regions.
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    choose(&mut window, "Strategy", "Regions");
    window.get_by_role_and_label(Role::Slider, "Layer depth").set_value_accesskit(10.0);
    window.run_steps(4);
    window.key_press(egui::Key::F6);
    window.run_steps(2);
    settle(&mut window);
    let flank = window.state().state().results.flank.clone().expect("planned");
    let figures = &flank.plan.layout.totals;
    let ratio = figures[flank.plan.layout.strategy as usize].length / figures[0].length;
    assert!(ratio < 0.5, "shorter than the isoparametric curves: {ratio}");
    window.get_by_label(&format!("{ratio:.3}"));
    window.get_by_label("region").click_accesskit();
    window.run_steps(4);
    window.get_by_label("walls").click_accesskit();
    window.run_steps(4);
    window.get_by_label("Residual on walls");

    // Files: they exist as reported, and `vanecut verify` accepts the CL file.
    let file = |name: &str| folder.path().join(name);
    save(&mut window, Purpose::ExportCl { channels: 1 }, &file("plunge.apt"));
    save(&mut window, Purpose::ExportFlank { channels: 1 }, &file("flank.apt"));
    save(&mut window, Purpose::SavePicture, &file("view.png"));
    let count = window.state().state().position_count();
    assert_eq!(read_apt(&file("plunge.apt")).expect("a CL file").moves.len(), 3 * count);
    assert_eq!(read_apt(&file("flank.apt")).expect("a CL file").moves.len(), flank.plan.moves.len());
    assert!(std::fs::read(file("view.png")).expect("a picture").starts_with(b"\x89PNG"));
    let verify = Command::new(env!("CARGO_BIN_EXE_vanecut"))
        .arg("verify")
        .args([&part, &file("plunge.apt")])
        .output()
        .expect("the program starts");
    assert!(verify.status.success(), "{}", String::from_utf8_lossy(&verify.stdout));

    // Closes with a selected position, and opens again.
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    window.get_by_label("Sort by cutting order").click();
    window.run_steps(8);
    window.key_press(egui::Key::ArrowDown);
    window.run_steps(8);
    settle(&mut window);
    let chosen = window.state().state().look.selected.expect("the next position") + 1;
    let said = words(&window, &format!("Position {chosen} of {count}")).expect("it is selected");
    save(&mut window, Purpose::SaveProject, &file("tuning.vanecut"));
    let camera = window.state().camera().expect("a camera");
    let edited = window.state().state().document.edited.clone();
    drop(window);

    let mut window = on_a_small_screen(&home);
    window.get_by_label("tuning").click();
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("impeller532");
    window.get_by_label(&said);
    window.get_by_label(&format!("Sectional view through position {chosen}"));
    assert_eq!(interferential(&window), (before, 0));
    let state = window.state().state();
    assert_eq!(state.document.edited, edited, "setup and sets");
    assert!(!state.document.is_unsaved());
    let again = window.state().camera().expect("a camera");
    assert!(
        again.target.distance(camera.target) < 1e-2 && (again.yaw_rad - camera.yaw_rad).abs() < 1e-4,
        "the view"
    );
    assert!(
        (again.distance - camera.distance).abs() < 1e-2 && (again.pitch_rad - camera.pitch_rad).abs() < 1e-4
    );
}
