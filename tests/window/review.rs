//! The position table and the 3D view, linked in both directions.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::look::{Filter, TableColumn};
use vanecut::app::model::planned::Side;

use crate::fake;
use crate::harness::{Window, press, press_at_once, settle, with_sample};

fn tip_on_screen(window: &Window) -> glam::Vec2 {
    let rect = window.get_by_label("3D view").rect();
    let state = window.state().state();
    let tip = state.selected().expect("selected").tip;
    let size = glam::vec2(rect.width(), rect.height());
    let camera = window.state().camera().expect("a camera");
    let pixel = camera.project(glam::vec3(tip.x as f32, tip.y as f32, tip.z as f32), size).expect("in front");
    pixel / size
}

#[test]
fn a_click_on_a_head_sorts_and_a_second_one_turns_the_order() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::B);
    window.run_steps(2);
    window.get_by_label("Sort by contact").click();
    window.run_steps(3);
    let state = window.state().state();
    assert_eq!(state.look.sort.column, TableColumn::Contact);
    let plan = state.shown().expect("planned").plan();
    let rows = state.rows();
    let depth = |row: usize| plan.positions[rows[row]].evaluation.contact.depth;
    assert!(depth(0) > 0.0, "the deepest contact comes first");
    assert!((1..rows.len()).all(|row| depth(row) <= depth(row - 1)), "in order");
    let first = format!("Position {}", rows[0] + 1);
    let top = window.get_by_role_and_label(Role::Row, &first).rect().top();
    let below = format!("Position {}", rows[1] + 1);
    assert!(window.get_by_role_and_label(Role::Row, &below).rect().top() > top, "the picture agrees");
    window.get_by_label("Sort by contact").click();
    window.run_steps(3);
    let rows = window.state().state().rows();
    let plan = window.state().state().shown().expect("planned").plan();
    assert_eq!(plan.positions[rows[0]].evaluation.contact.depth, 0.0, "the other way round");
}

#[test]
fn up_and_down_follow_the_table_as_it_is_sorted_and_filtered() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::B);
    window.get_by_label("Sort by cutting order").click();
    window.run_steps(3);
    assert!(window.state().state().look.sort.descending, "last position first");
    window.state_mut().look_mut().filter = Filter::Interfering;
    window.run_steps(2);
    let rows = window.state().state().rows();
    assert_eq!(rows.len(), fake::FAULTS);
    assert!(rows[0] > rows[1], "descending");
    for &row in &rows {
        window.key_press(egui::Key::ArrowDown);
        window.run_steps(2);
        assert_eq!(window.state().state().look.selected, Some(row));
    }
    window.key_press(egui::Key::ArrowDown);
    window.key_press(egui::Key::ArrowUp);
    window.run_steps(2);
    assert_eq!(window.state().state().look.selected, Some(rows[rows.len() - 2]), "it ends at the end");
}

#[test]
fn without_interfering_plunges_the_key_for_them_says_so() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::N);
    window.run_steps(3);
    window.get_by_label("No plunge of this plan interferes");
}

#[test]
fn keys_that_are_pressed_within_one_frame_all_count() {
    use egui::Key::{ArrowDown, ArrowUp};
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().look_mut().selected = Some(0);
    window.run_steps(2);
    press_at_once(&mut window, [ArrowDown; 5]);
    let fifth = window.state().state().rows()[5];
    assert_eq!(window.state().state().look.selected, Some(fifth));
    press_at_once(&mut window, [ArrowUp, ArrowUp, ArrowDown]);
    let fourth = window.state().state().rows()[4];
    assert_eq!(window.state().state().look.selected, Some(fourth));
}

#[test]
fn choosing_a_row_flies_there() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let before = window.state().camera().expect("a camera");
    window.get_by_label("Position 4").click();
    window.run_steps(8);
    let after = window.state().camera().expect("a camera");
    assert!(after.distance < 0.6 * before.distance, "nearer: {} of {}", after.distance, before.distance);
    let place = tip_on_screen(&window);
    assert!((place - 0.5).abs().max_element() < 0.25, "in the middle: {place}");
}

#[test]
fn a_cutter_that_is_picked_is_the_row_that_is_shown() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1000.0, 760.0));
    window.run_steps(3);
    window.get_by_label("Position 9").click();
    window.run_steps(8);
    let rect = window.get_by_label("3D view").rect();
    let place = tip_on_screen(&window);
    window.state_mut().look_mut().selected = None;
    window.run_steps(2);
    // Just above the tip: inside the cutter.
    let at = rect.min + egui::vec2(place.x * rect.width(), place.y * rect.height() - 3.0);
    press(&mut window, at);
    window.run_steps(3);
    let picked = window.state().state().look.selected.expect("a cutter is there");
    assert!((7..=9).contains(&picked), "the ninth or one that overlaps it: {picked}");
    window.get_by_role_and_label(Role::Row, &format!("Position {}", picked + 1));
    // A click beside all cutters selects nothing.
    press(&mut window, rect.left_bottom() + egui::vec2(20.0, -100.0));
    window.run_steps(3);
    let outside = window.state().state().look.selected;
    assert!(outside.is_none_or(|k| k != picked), "{outside:?}");
}

#[test]
fn hidden_cutters_cannot_be_picked() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    let rect = window.get_by_label("3D view").rect();
    let camera = window.state().camera().expect("a camera");
    let position = &window.state().state().shown_on(Side::After).expect("planned").plan().positions[8];
    let inside = position.tip + position.axis * 3.0;
    let point = glam::vec3(inside.x as f32, inside.y as f32, inside.z as f32);
    let pixel = camera.project(point, glam::vec2(rect.width(), rect.height())).expect("in front");
    let at = rect.min + egui::vec2(pixel.x, pixel.y);
    press(&mut window, at);
    window.run_steps(3);
    assert!(window.state().state().look.selected.is_some(), "shown, it can");
    window.state_mut().look_mut().selected = None;
    window.state_mut().look_mut().layers.cutters = false;
    window.run_steps(2);
    press(&mut window, at);
    window.run_steps(3);
    assert_eq!(window.state().state().look.selected, None, "hidden, it cannot");
}
