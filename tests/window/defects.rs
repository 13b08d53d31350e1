//! Defects that a programmer found in the window, each as it was found: they stay repaired.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::tasks::engine::Engine;
use vanecut::app::views::theme::Condition;
use vanecut::job::PlanOutcome;
use vanecut::setup::{PlungeChange, PlungeEdit};

use crate::fake;
use crate::flank;
use crate::harness::{Window, labels, pixels_in, press, settle, window, with_sample};
use crate::roles::{open_with_roles, wheel};

/// Number of pixels of a label that have the ink of a condition.
fn inked(window: &mut Window, label: &str, condition: Condition) -> usize {
    let rect = window.get_by_label(label).rect();
    let ink = condition.text(&window.ctx.global_style().visuals).to_array();
    let near = |pixel: &&[u8; 4]| pixel.iter().zip(ink).all(|(a, b)| a.abs_diff(b) < 24);
    pixels_in(window, rect).iter().filter(near).count()
}

#[test]
fn a_plan_that_misses_most_of_the_floor_has_no_green_headline() {
    let (engine, _) = fake::engine();
    let missing = move |outcome: &mut PlanOutcome| {
        outcome.after.summary.uncut_share = 0.75;
    };
    let mut sound = with_sample(engine.clone());
    let mut poor = with_sample(fake::with_changed_plans(engine, missing));
    let headline = "Interfering plunges 5 to 0";
    assert!(inked(&mut sound, headline, Condition::Sound) > 20);
    assert_eq!(inked(&mut sound, "1.2 %", Condition::Blocked), 0);
    assert_eq!(inked(&mut poor, headline, Condition::Sound), 0, "green over a plan that is not");
    assert!(inked(&mut poor, headline, Condition::Blocked) > 20, "as bad as its worst figure");
    assert!(inked(&mut poor, "75.0 %", Condition::Blocked) > 10, "and that one says so");
}

#[test]
fn the_picture_of_the_roles_shows_the_blades_whichever_way_the_wheel_lies() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut seen = Vec::new();
    for turn in [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]] {
        // The root turns the wheel about X: by nothing, or by half a turn.
        let path = wheel(folder.path(), |document| {
            let nodes = document["nodes"].as_array_mut().expect("nodes");
            let root = nodes.iter_mut().find(|node| node.get("children").is_some()).expect("a root");
            root.as_object_mut().expect("an object").remove("matrix");
            root["rotation"] = serde_json::json!(turn);
        });
        let (engine, _) = fake::engine();
        let mut window = open_with_roles(window(engine), path);
        let rect = window.get_by_label("Picture of the nodes").rect();
        let plain = pixels_in(&mut window, rect);
        window.get_by_label("blade_1").click();
        window.run_steps(4);
        settle(&mut window);
        let lit = pixels_in(&mut window, rect);
        let differs = |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 24);
        seen.push(plain.iter().zip(&lit).filter(differs).count());
    }
    assert!(seen.iter().all(|&pixels| pixels > 300), "pixels of one blade: {seen:?}");
}

#[test]
fn a_word_where_a_number_belongs_is_named_as_such() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("part.toml");
    let text = include_str!("../../assets/parts/pump6.toml").replace("blades = 6", "blades = nine");
    assert!(text.contains("blades = nine"));
    std::fs::write(&path, text).expect("writes");
    let (engine, _) = fake::engine();
    let engine = Engine { open: Engine::default().open, ..engine };
    let mut window = window(engine);
    window.state_mut().open_path(path);
    settle(&mut window);
    let said = &window.state().state().problems;
    assert!(said.iter().any(|p| p.message.contains("nine is not a value")), "{said:?}");
    assert!(!said.iter().any(|p| p.text().contains("nan")), "{said:?}");
    window.get_by_label_contains("nine is not a value");
}

#[test]
fn messages_leave_the_most_of_the_picture_free() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    // As it is at 150 % on a small screen.
    let mut window = with_sample(engine);
    window.run_steps(3);
    let view = window.get_by_label("3D view").rect();
    let lower = view.with_min_y(view.top() + 0.45 * view.height());
    let free = pixels_in(&mut window, lower);
    for name in ["a", "b", "c", "d", "e"] {
        window.state_mut().open_path(folder.path().join(name).with_extension("toml"));
        settle(&mut window);
    }
    assert_eq!(window.state().state().problems.len(), 5);
    assert!(pixels_in(&mut window, lower) == free, "the part can be seen below them");
}

#[test]
fn a_click_on_the_selected_row_leaves_it_selected_and_escape_does_not() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let selected = |window: &Window| window.state().state().look.selected;
    for _ in 0..2 {
        window.get_by_label("Position 3").click();
        window.run_steps(3);
        settle(&mut window);
        assert_eq!(selected(&window), Some(2));
    }
    // A field that is typed in has the key first.
    window.get_by_role_and_label(Role::SpinButton, "Step").click();
    window.run_steps(3);
    for left in [Some(2), None] {
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
        assert_eq!(selected(&window), left);
    }
    flank::plan_flank(&mut window, 10.0);
    for _ in 0..2 {
        window.get_by_label("Pass 2").click();
        window.run_steps(3);
        settle(&mut window);
        assert_eq!(window.state().state().look.flank.pass, Some(1));
    }
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert_eq!(window.state().state().look.flank.pass, None);
}

#[test]
fn undo_brings_back_the_name_of_a_variant_and_not_the_time_before_it() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1180.0));
    window.run_steps(3);
    let names = |window: &Window| -> Vec<String> {
        window.state().state().document.edited.sets.iter().map(|set| set.name.clone()).collect()
    };
    // It is renamed at once, before the variant would have become a step by itself.
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::D);
    window.run_steps(2);
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert_eq!(notice.text, "The setup is saved as \"Variant 1\", under Variants");
    window.get_by_role_and_label(Role::TextInput, "Name of variant 1").click();
    window.run_steps(2);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text("Rough".to_owned()));
    window.run_steps(1);
    assert_eq!(names(&window), ["Rough"]);
    let undo = |window: &mut Window| {
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
        window.run_steps(1);
    };
    undo(&mut window);
    assert_eq!(names(&window), ["Variant 1"]);
    undo(&mut window);
    assert!(names(&window).is_empty());
}

#[test]
fn tools_that_are_taken_over_unchanged_leave_the_plans_as_they_are() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 1900.0));
    flank::plan_flank(&mut window, 10.0);
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(4);
    let planned = window.state().state().results.planned.clone().expect("planned");
    let flank = window.state().state().results.flank.clone().expect("planned");
    window.get_by_label("Edit tools and sections").click();
    window.run_steps(3);
    assert!(!window.state().is_busy(), "nothing is calculated");
    let assert_same = |window: &Window| {
        let state = window.state().state();
        assert!(!state.out_of_date() && !state.flank_is_stale());
        assert!(Arc::ptr_eq(state.results.planned.as_ref().expect("planned"), &planned));
        assert!(state.results.figures(&state.document.edited.setup).is_some(), "its figures are known");
    };
    assert!(!window.state().state().document.edited.setup.tools.is_empty(), "they can be edited");
    assert_same(&window);
    window.run_steps(8);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    assert!(!window.state().is_busy(), "nor when it is undone");
    assert_same(&window);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Y);
    window.run_steps(3);
    settle(&mut window);
    // An edit of a tool for plunges is one of the roughing plan.
    let header = window.get_all_by_label_contains("T1  Ø30").next().expect("a header").rect();
    press(&mut window, header.center());
    window.run_steps(10);
    window.get_by_role_and_label(Role::SpinButton, "Diameter").set_value_accesskit(28.0);
    window.run_steps(3);
    settle(&mut window);
    let state = window.state().state();
    assert!(!Arc::ptr_eq(state.results.planned.as_ref().expect("planned"), &planned), "planned anew");
    assert!(!state.flank_is_stale(), "the passes have a cutter of the library");
    assert!(Arc::ptr_eq(state.results.flank.as_ref().expect("planned"), &flank));
    // A ball end of the setup that fits is taken; here it is the one that was, or another one.
    let mut setup = state.document.edited.setup.clone();
    setup.tools.push(flank.plan.tool.clone());
    assert!(flank.would_choose_from(&setup));
    let last = setup.tools.last_mut().expect("tools");
    last.overhang += 5.0;
    assert!(!flank.would_choose_from(&setup));
}

#[test]
fn the_headline_says_what_it_counts() {
    let (engine, _) = fake::engine();
    let sound = move |outcome: &mut PlanOutcome| {
        let evaluation = outcome.after.plan.positions[0].evaluation;
        for position in &mut outcome.before.plan.positions {
            position.evaluation = evaluation;
        }
        outcome.before.summary.interfering = 0;
    };
    let window = with_sample(fake::with_changed_plans(engine, sound));
    assert_eq!(labels(&window, "No plunge"), ["No plunge interferes"]);
}

/// The plan of the tools that the program chose is the one that is edited by hand, too.
#[test]
fn a_plunge_is_lifted_twice_after_tools_are_taken_over() {
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 1900.0));
    window.run_steps(3);
    window.get_by_label("Edit tools and sections").click();
    window.run_steps(3);
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    window.key_press(egui::Key::E);
    window.run_steps(3);
    slow.store(true, Ordering::SeqCst);
    window.get_by_role_and_label(Role::SpinButton, "Lift by").set_value_accesskit(1.0);
    window.run_steps(3);
    for _ in 0..2 {
        window.get_by_role_and_label(Role::Button, "Lift").click();
        window.run_steps(3);
        assert!(window.state().is_busy(), "the plan has yet to follow");
    }
    let edits = window.state().state().document.edited.setup.plunge.edits.clone();
    assert!(matches!(edits[..], [PlungeEdit { change: PlungeChange::Lift(2.0), .. }]), "{edits:?}");
    // What is not taken meanwhile is said.
    window.key_press(egui::Key::Delete);
    window.run_steps(3);
    window.get_by_label("Roughing is still being calculated: edit it when that is done");
    slow.store(false, Ordering::SeqCst);
    settle(&mut window);
}

#[test]
fn there_is_nothing_to_cancel_before_anything_is_open() {
    let (engine, slow) = fake::engine();
    let mut window = window(engine);
    window.run_steps(3);
    assert!(window.query_by_label("Cancel").is_none());
    let preview = |window: &Window| window.get_by_label_contains("Preview").rect();
    let before = preview(&window);
    slow.store(true, Ordering::SeqCst);
    window.state_mut().open_part(PartSource::Sample("impeller532".to_owned()));
    window.run_steps(3);
    window.get_by_label("Cancel");
    assert_eq!(preview(&window), before, "nothing moves");
    slow.store(false, Ordering::SeqCst);
    settle(&mut window);
}
