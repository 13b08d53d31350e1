//! The window, driven through accessible names on software Vulkan.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod agreement;
mod borders;
mod channels;
mod compare;
mod defects;
mod device;
mod dialogs;
mod dock;
mod documents;
mod drop;
mod edits;
mod fake;
mod flank;
mod flank_panel;
mod harness;

mod help;
mod large_library;
mod layout;
mod look;
mod machine;
mod machine_file;
mod mouse;
mod nc;
mod preview;
mod program;
mod project;
mod real;
mod recovery;
mod release;
mod review;
mod roles;
mod section;
mod small;
mod solid;
mod stages;
mod studies;
mod timeline;
mod tools;
mod tradeoff;
mod tuning;
mod typed;
mod units;
mod walk;
mod windows;

use std::sync::atomic::Ordering;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use harness::{settle, snapshot_ui, snapshot_view, turn_wheel, window, with_sample};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::planned::Side;
use vanecut::app::model::state::Tone;
use vanecut::geometry::Vector;
use vanecut::plunge::PlungePlan;

#[test]
fn nothing_open_offers_the_samples() {
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.run_steps(2);
    snapshot_ui(&mut window, "empty");
    window.get_by_label("impeller532").click();
    window.step();
    settle(&mut window);
    let state = window.state().state();
    assert_eq!(
        state.document.part.as_ref().map(|part| part.impeller.blade_count),
        Some(17),
        "the sample is open"
    );
    assert!(state.results.planned.is_some(), "its first plan comes by itself");
}

#[test]
fn the_repaired_plan_interferes_nowhere_and_both_can_be_seen() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Interfering plunges 5 to 0");
    snapshot_view(&mut window, "after");
    window.get_by_label("Before").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.side, Side::Before, "the switch shows the other plan");
    snapshot_view(&mut window, "before");
    window.key_press(egui::Key::B);
    window.run_steps(2);
    assert_eq!(window.state().state().look.side, Side::After, "so does its key");
}

#[test]
fn policies_are_compared_when_asked() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1180.0));
    window.run_steps(3);
    assert!(window.query_by_label("Stepped").is_none(), "only what was planned is listed");
    window.get_by_label("Compare all strategies").click();
    window.run_steps(2);
    window.key_press(egui::Key::F5);
    settle(&mut window);
    window.get_by_label("Stepped");
    assert_eq!(window.state().state().results.planned.as_ref().map(|p| p.outcome.policies().len()), Some(4));
}

#[test]
fn an_edited_setup_is_out_of_date_until_planned_again() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    let before = window.state().state().position_count();
    assert!(window.query_by_label("Out of date").is_none(), "fresh plan");
    let step = window.get_by_role_and_label(Role::SpinButton, "Step");
    step.set_value_accesskit(5.0);
    window.run_steps(3);
    window.get_by_label("Out of date");
    assert_eq!(
        window.state().state().document.edited.setup.plunge.step,
        Some(5.0),
        "the field edits the setup"
    );
    assert_eq!(window.state().state().position_count(), before, "nothing is planned behind the user's back");
    snapshot_view(&mut window, "out_of_date");
    window.get_by_role_and_label(Role::Button, "Calculate roughing").click();
    window.step();
    settle(&mut window);
    assert!(window.query_by_label("Out of date").is_none(), "planned again");
    assert!(window.state().state().position_count() > before, "a smaller step has more positions");
    window.get_by_label("Reset step").click();
    window.run_steps(2);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, None, "the dot resets");
}

#[test]
fn cancel_acts_at_once_and_keeps_the_last_good_plan() {
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    slow.store(true, Ordering::SeqCst);
    window.key_press(egui::Key::F5);
    window.step();
    assert!(window.state().is_busy(), "planning");
    window.step();
    window.get_by_label("Cancel").click();
    // The planner stalls until it is cancelled.
    settle(&mut window);
    let state = window.state().state();
    assert!(state.results.planned.is_some(), "the last good plan stays");
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert_eq!((notice.tone, notice.text.contains("cancelled")), (Tone::Done, true), "{notice:?}");
    slow.store(false, Ordering::SeqCst);
}

#[test]
fn a_cancelled_plan_of_a_new_setup_is_shown_as_the_best_so_far() {
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    let finished = window.state().state().position_count();
    assert!(window.query_by_label("Unfinished:").is_none(), "a finished plan");
    slow.store(true, Ordering::SeqCst);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(7.0);
    window.run_steps(3);
    assert!(window.state().is_busy(), "the edit is being planned");
    window.get_by_label("Cancel").click();
    settle(&mut window);
    let state = window.state().state();
    let shown = state.shown().expect("a plan").plan();
    assert!(shown.is_unfinished() && !shown.positions.is_empty(), "what was found until then");
    window.get_by_label("Roughing: unfinished");
    assert!(!state.out_of_date(), "it is of the setup as it stands");
    let notice = state.notice.clone().expect("a word about it");
    assert_eq!((notice.tone, notice.text.contains("best so far")), (Tone::Done, true), "{notice:?}");
    assert_eq!(state.results.figures(&state.document.edited.setup), None, "no figures to compare sets by");
    window.get_by_label("Unfinished:");
    // No curve is found of it: it says so, and does not wait for a plan that nobody asked for.
    window.key_press(egui::Key::G);
    window.run_steps(3);
    window.get_by_label("No plan of this setup was finished.");
    // A finished plan replaces it.
    slow.store(false, Ordering::SeqCst);
    window.get_by_label("Calculate it").click();
    window.step();
    settle(&mut window);
    assert!(window.query_by_label("Unfinished:").is_none(), "finished now");
    assert!(window.state().state().position_count() > finished / 2, "both rows");
}

#[test]
fn a_newer_request_supersedes_the_running_one() {
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    slow.store(true, Ordering::SeqCst);
    window.key_press(egui::Key::F5);
    window.step();
    slow.store(false, Ordering::SeqCst);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(4.0);
    window.run_steps(2);
    window.key_press(egui::Key::F5);
    settle(&mut window);
    assert!(!window.state().state().out_of_date(), "the newest request's plan is shown");
}

#[test]
fn a_row_of_the_table_selects_its_position() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    // The cut through it is computed beside the frames.
    settle(&mut window);
    assert_eq!(window.state().state().look.selected, Some(2), "the third in cutting order");
    snapshot_view(&mut window, "selected");
    window.key_press(egui::Key::ArrowRight);
    window.run_steps(2);
    assert_eq!(window.state().state().look.selected, Some(3), "the arrow goes on");
}

#[test]
fn faults_are_listed_and_can_be_stepped_through() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::B);
    window.key_press(egui::Key::N);
    window.run_steps(3);
    let state = window.state().state();
    let first = state.look.selected.expect("a fault is selected");
    let plan = &state.results.planned.as_ref().expect("planned").outcome.before.plan;
    assert!(plan.positions[first].evaluation.contact.interferes(), "it is one");
    window.get_by_role_and_label(Role::ComboBox, "Positions").click();
    window.run_steps(2);
    window.get_by_label("Interfering only").click();
    window.run_steps(2);
    assert_eq!(window.state().state().rows().len(), fake::FAULTS, "the filter leaves the faults");
}

#[test]
fn the_mouse_turns_shifts_and_zooms() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let rect = window.get_by_label("3D view").rect();
    let drag = |window: &mut harness::Window| {
        window.drag_at(rect.center());
        window.run_steps(1);
        window.hover_at(rect.center() + egui::vec2(60.0, 20.0));
        window.run_steps(1);
        window.drop_at(rect.center() + egui::vec2(60.0, 20.0));
        window.run_steps(3);
    };
    let start = window.state().camera().expect("a camera");
    drag(&mut window);
    let turned = window.state().camera().expect("a camera");
    assert!((turned.yaw_rad - start.yaw_rad).abs() > 0.1, "a drag turns");
    window.hover_at(rect.center());
    turn_wheel(&mut window, 120.0, 6);
    let zoomed = window.state().camera().expect("a camera");
    assert!(zoomed.distance < turned.distance, "the wheel goes nearer");

    let middle = |pos, pressed| {
        let (button, modifiers) = (egui::PointerButton::Middle, egui::Modifiers::NONE);
        egui::Event::PointerButton { pos, button, pressed, modifiers }
    };
    let end = rect.center() + egui::vec2(-40.0, 30.0);
    window.event(middle(rect.center(), true));
    window.run_steps(1);
    window.hover_at(end);
    window.run_steps(1);
    window.event(middle(end, false));
    window.run_steps(3);
    let shifted = window.state().camera().expect("a camera");
    assert_eq!(
        (shifted.yaw_rad, shifted.pitch_rad),
        (zoomed.yaw_rad, zoomed.pitch_rad),
        "the middle button does not turn"
    );
    assert!(shifted.target.distance(zoomed.target) > 1.0, "it shifts");

    // The harness clock advances by a quarter of a second per event.
    window.ctx.options_mut(|options| options.input_options.max_double_click_delay = 3.0);
    window.hover_at(rect.center());
    window.run_steps(4);
    for _ in 0..2 {
        for pressed in [true, false] {
            let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
            window.event(egui::Event::PointerButton { pos: rect.center(), button, pressed, modifiers });
        }
        window.run_steps(1);
    }
    window.run_steps(3);
    let centred = window.state().camera().expect("a camera");
    assert_eq!(
        (centred.yaw_rad, centred.pitch_rad),
        (shifted.yaw_rad, shifted.pitch_rad),
        "a double click does not turn"
    );
    assert_ne!(centred.target, shifted.target, "it centres what is under the cursor");
}

#[test]
fn a_fault_is_one_line_with_its_cure() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(12.0);
    window.run_steps(2);
    window.key_press(egui::Key::F5);
    settle(&mut window);
    window.get_by_label("The hub allowance of 12 mm leaves no channel at s 0.31");
    window.get_by_label("Fix: make it smaller");
    snapshot_ui(&mut window, "problem");
    window.get_by_label("Dismiss").click();
    window.run_steps(3);
    assert!(window.query_by_label("Fix: make it smaller").is_none(), "dismissed");
    assert!(window.state().state().results.planned.is_some(), "the last good plan stays");
}

#[test]
fn a_bad_file_is_named_and_the_open_part_stays() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().open_path("no/such/wheel.toml".into());
    settle(&mut window);
    let state = window.state().state();
    let notice = state.notice.clone().expect("a message");
    assert_eq!(notice.tone, Tone::Fault);
    assert!(notice.text.contains("no/such/wheel.toml"), "{notice:?}");
    assert!(state.document.part.is_some(), "what was open stays");
}

#[test]
fn a_click_on_a_cutter_selects_its_position() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    let rect = window.get_by_label("3D view").rect();
    let camera = window.state().camera().expect("a camera");
    let plan = &window.state().state().results.planned.as_ref().expect("planned").outcome.after.plan;
    // Half a radius above the tip of a cutter in the middle of the row: inside the cutter.
    let inside = plan.positions[8].tip + plan.positions[8].axis * 7.5;
    let point = glam::vec3(inside.x as f32, inside.y as f32, inside.z as f32);
    let pixel = camera.project(point, glam::vec2(rect.width(), rect.height())).expect("in front");
    let at = rect.min + egui::vec2(pixel.x, pixel.y);
    window.hover_at(at);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    window.run_steps(3);
    let selected = window.state().state().look.selected.expect("a cutter is there");
    assert!((6..=11).contains(&selected), "the cutter under the cursor or one in front of it: {selected}");
}

#[test]
fn fields_take_arithmetic_and_edits_can_be_undone() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.run_steps(6);
    window.get_by_role_and_label(Role::SpinButton, "Step").click();
    window.run_steps(2);
    window.event(egui::Event::Text("30/4 mm".to_owned()));
    window.run_steps(1);
    window.key_press(egui::Key::Enter);
    window.run_steps(8);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, Some(7.5), "30/4");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(2);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, None, "undone");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Y);
    window.run_steps(2);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, Some(7.5), "done again");
}

/// A worker knows one request: what is written meanwhile waits for its turn.
#[test]
fn files_that_are_written_at_once_are_all_written() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let folder = tempfile::tempdir().expect("a folder");
    let ctx = window.ctx.clone();
    let files: Vec<_> = (0..5).map(|k| folder.path().join(format!("{k}.glb"))).collect();
    for path in &files {
        window.state_mut().file_chosen(&ctx, Purpose::ExportScene { side: None }, path.clone());
    }
    settle(&mut window);
    assert!(files.iter().all(|path| path.exists()), "{:?}", std::fs::read_dir(folder.path()).expect("lists"));
}

#[test]
fn a_scene_of_another_setup_is_asked_about() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.glb");
    let ctx = window.ctx.clone();
    window.get_by_role_and_label(Role::CheckBox, "Auto-update").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.0);
    window.run_steps(3);
    assert!(window.state().state().out_of_date());
    window.state_mut().file_chosen(&ctx, Purpose::ExportScene { side: None }, path.clone());
    window.run_steps(3);
    window.get_by_label("Export the scene of this plan?");
    window.get_by_label_contains("The setup was edited after this calculation");
    harness::click_enabled(&window, "Cancel");
    window.run_steps(3);
    settle(&mut window);
    assert!(!path.exists());
    window.state_mut().file_chosen(&ctx, Purpose::ExportScene { side: None }, path.clone());
    window.run_steps(3);
    harness::click_enabled(&window, "Recalculate");
    window.run_steps(3);
    settle(&mut window);
    assert!(path.exists() && !window.state().state().out_of_date(), "of the new plan");
}

#[test]
fn setup_cl_file_and_picture_are_written() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.0);
    window.run_steps(2);
    // A plan that ends after a file is written would take the word about it away.
    settle(&mut window);
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for (purpose, name) in [
        (Purpose::SaveSetup, "s.toml"),
        (Purpose::ExportCl { channels: 1 }, "p.apt"),
        (Purpose::ExportCl { channels: 17 }, "all.apt"),
        (Purpose::ExportScene { side: None }, "s.glb"),
        (Purpose::SavePicture, "v.png"),
    ] {
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, purpose, path(name));
        settle(&mut window);
        let notice = window.state().state().notice.clone().expect("a word about it");
        assert_eq!(notice.tone, Tone::Done, "{notice:?}");
    }
    let setup = vanecut::io::setup_file::read_setup(&path("s.toml"), &vanecut::setup::Setup::default())
        .expect("a setup");
    assert_eq!(setup.plunge.step, Some(6.0), "the setup as it was edited");
    let program = vanecut::io::apt::read_apt(&path("p.apt")).expect("a CL file");
    let positions =
        window.state().state().results.planned.as_ref().expect("planned").outcome.after.plan.positions.len();
    assert_eq!(program.moves.len(), 3 * positions, "down and back per position");
    let blades = window.state().state().document.part.as_ref().expect("open").impeller.blade_count;
    let all = vanecut::io::apt::read_apt(&path("all.apt")).expect("a CL file");
    assert_eq!(all.moves.len(), 3 * positions * blades, "of every channel");
    let scene = std::fs::read(path("s.glb")).expect("a scene");
    let node = format!("\"positions\":{positions},");
    assert!(
        scene.starts_with(b"glTF") && scene.windows(node.len()).any(|w| w == node.as_bytes()),
        "of the plan"
    );
    let picture = std::fs::read(path("v.png")).expect("a picture");
    assert!(picture.starts_with(b"\x89PNG"), "a PNG");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 1 }, path("no/such/folder/p.apt"));
    settle(&mut window);
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert_eq!(notice.tone, Tone::Fault, "what cannot be written is said");

    // The plan that is shown is written, not always that of "after".
    window.state_mut().look_mut().side = Side::Before;
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 1 }, path("before.apt"));
    window.run_steps(2);
    assert!(!path("before.apt").exists(), "a plan that interferes is asked about first");
    window.get_by_label("Export anyway").click();
    window.run_steps(2);
    settle(&mut window);
    let program = vanecut::io::apt::read_apt(&path("before.apt")).expect("a CL file");
    let planned = window.state().state().results.planned.clone().expect("planned");
    let tips = |plan: &PlungePlan| plan.positions.iter().map(|p| p.axis).collect::<Vec<_>>();
    let axes: Vec<_> = program.moves.iter().skip(1).step_by(3).map(|m| m.axis).collect();
    let near = |a: &[Vector], b: &[Vector]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).norm() < 1e-6)
    };
    assert!(
        near(&axes, &tips(&planned.outcome.before.plan)) && !near(&axes, &tips(&planned.outcome.after.plan))
    );
}

#[test]
fn the_light_theme_says_the_same() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("View").click();
    window.run_steps(2);
    window.get_by_label("Switch light and dark").click();
    window.run_steps(2);
    window.key_press(egui::Key::Num4);
    window.key_press(egui::Key::B);
    window.run_steps(4);
    snapshot_view(&mut window, "light");
}

#[test]
fn the_smallest_window_still_shows_everything() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(800.0, 500.0));
    window.run_steps(4);
    snapshot_view(&mut window, "smallest");
}
