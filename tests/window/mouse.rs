//! The mouse in the 3D view: presets and context menu.

use egui::accesskit::Role;
use egui::{Event, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::Queryable;
use vanecut::app::model::look::{Filter, Tab};
use vanecut::app::model::mouse_preset::MousePreset;
use vanecut::gpu::camera::Camera;

use crate::fake;
use crate::harness::{Window, run_by_search, settle, snapshot_view, window, with_sample, words};

fn button(window: &mut Window, pos: Pos2, button: PointerButton, modifiers: Modifiers, pressed: bool) {
    window.event(Event::PointerButton { pos, button, pressed, modifiers });
}

/// Drags across the view; returns the camera before and after.
fn drag(window: &mut Window, with: PointerButton, modifiers: Modifiers) -> (Camera, Camera) {
    let start = window.get_by_label("3D view").rect().center();
    let end = start + egui::vec2(40.0, 30.0);
    let before = window.state().camera().expect("a camera");
    window.hover_at(start);
    window.run_steps(1);
    window.event_modifiers(Event::PointerMoved(start), modifiers);
    window.event_modifiers(
        Event::PointerButton { pos: start, button: with, pressed: true, modifiers },
        modifiers,
    );
    window.step();
    window.event_modifiers(Event::PointerMoved(end), modifiers);
    window.step();
    window.event_modifiers(
        Event::PointerButton { pos: end, button: with, pressed: false, modifiers },
        modifiers,
    );
    window.run_steps(3);
    (before, window.state().camera().expect("a camera"))
}

fn turned((a, b): (Camera, Camera)) -> bool {
    (a.yaw_rad - b.yaw_rad).abs() > 0.05
}

fn moved((a, b): (Camera, Camera)) -> bool {
    (a.yaw_rad, a.pitch_rad) == (b.yaw_rad, b.pitch_rad) && a.target.distance(b.target) > 1.0
}

fn nearer((a, b): (Camera, Camera)) -> bool {
    (a.yaw_rad, a.pitch_rad) == (b.yaw_rad, b.pitch_rad) && b.distance < 0.95 * a.distance
}

#[test]
fn the_mouse_takes_other_habits_from_menu_and_palette_and_keeps_them() {
    use PointerButton::{Middle, Primary, Secondary};
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine.clone());
    window.state_mut().set_home(folder.path().join("home"));
    assert!(turned(drag(&mut window, Primary, Modifiers::NONE)));
    assert!(moved(drag(&mut window, Primary, Modifiers::SHIFT)));

    window.get_by_label("View").click();
    window.run_steps(2);
    window.get_by_label_contains("Mouse").click();
    window.run_steps(2);
    window.get_by_label("Mouse: NX").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.mouse, MousePreset::Nx);
    let (before, after) = drag(&mut window, Primary, Modifiers::NONE);
    assert_eq!(before, after, "the left button is for choosing");
    assert!(turned(drag(&mut window, Middle, Modifiers::NONE)));
    assert!(moved(drag(&mut window, Middle, Modifiers::SHIFT)));
    assert!(nearer(drag(&mut window, Middle, Modifiers::CTRL)));

    window.get_by_label("Navigation help").click();
    window.run_steps(2);
    window.get_by_label_contains("Drag with shift-middle: pan");
    window.get_by_label("Mouse: Blender").click();
    window.run_steps(3);
    assert!(turned(drag(&mut window, Primary, Modifiers::ALT)), "without a middle button");

    run_by_search(&mut window, "onshape");
    assert!(turned(drag(&mut window, Secondary, Modifiers::NONE)));
    assert!(window.query_by_label("Measure from here").is_none(), "a drag opens no menu");

    let mut again = crate::harness::window(engine);
    again.state_mut().set_home(folder.path().join("home"));
    again.run_steps(1);
    assert_eq!(again.state().state().look.mouse, MousePreset::Onshape, "the next start knows it");
}

/// Screen position of a cutter in the middle of the first row.
fn at_cutter(window: &Window) -> Pos2 {
    let rect = window.get_by_label("3D view").rect();
    let camera = window.state().camera().expect("a camera");
    let plan = &window.state().state().results.planned.as_ref().expect("planned").outcome.after.plan;
    let inside = plan.positions[8].tip + plan.positions[8].axis * 2.0;
    let point = glam::vec3(inside.x as f32, inside.y as f32, inside.z as f32);
    let pixel = camera.project(point, glam::vec2(rect.width(), rect.height())).expect("in front");
    rect.min + egui::vec2(pixel.x, pixel.y)
}

fn right_click(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    window.run_steps(1);
    for pressed in [true, false] {
        button(window, at, PointerButton::Secondary, Modifiers::NONE, pressed);
    }
    window.run_steps(3);
}

#[test]
fn a_right_click_offers_what_can_be_done_with_the_position_there() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    let at = at_cutter(&window);
    right_click(&mut window, at);
    assert_eq!(window.state().state().look.selected, None, "a right click selects nothing");
    let title = words(&window, "At position ").expect("the menu names its position");
    let k = title.trim_start_matches("At position ").parse::<usize>().expect("a number") - 1;
    assert!((6..=11).contains(&k), "the cutter under the cursor or one in front of it: {k}");
    // The sectional view is computed on another thread.
    settle(&mut window);
    snapshot_view(&mut window, "right_click");
    window.get_by_role_and_label(Role::Button, "Simulate to here").click();
    window.run_steps(4);
    assert_eq!(window.state().state().look.cut_count, Some(k + 1), "cut until there");
    assert_eq!(window.state().state().look.selected, Some(k), "selected by the command");
    assert!(window.query_by_label("Simulate to here").is_none(), "the menu is gone");

    window.state_mut().look_mut().filter = Filter::Interfering;
    window.state_mut().look_mut().tab = Tab::Facts;
    window.run_steps(2);
    right_click(&mut window, at);
    window.get_by_role_and_label(Role::Button, "Show in table").click();
    window.run_steps(6);
    assert_eq!(window.state().state().look.filter, Filter::All, "a filter does not hide it");
    window.get_by_label(&format!("Position {}", k + 1));
    right_click(&mut window, at);
    window.get_by_role_and_label(Role::Button, "Open sectional view").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.tab, Tab::Section);

    right_click(&mut window, at);
    window.get_by_role_and_label(Role::Button, "Measure from here").click();
    window.run_steps(3);
    let points = window.state().state().look.measure.clone().expect("measuring");
    assert_eq!(points.len(), 1, "the first point is set");
    let rect = window.get_by_label("3D view").rect();
    let camera = window.state().camera().expect("a camera");
    let pixel = camera.project(points[0], glam::vec2(rect.width(), rect.height())).expect("in front");
    assert!((rect.min + egui::vec2(pixel.x, pixel.y)).distance(at) < 1.0, "where the click was");
}

#[test]
fn a_cutter_under_the_pointer_says_how_and_when_it_cuts() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    let at = at_cutter(&window);
    window.hover_at(at);
    window.run_steps(10);
    window.get_by_label_contains("T1 Ø30, section 1, row ");
    window.get_by_label_contains("300 mm/min, 1200 rev/min");
    window.get_by_label_contains("Cut after 0:");
}

#[test]
fn beside_the_cutters_a_right_click_offers_views_and_layers() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Position 3").click();
    window.run_steps(8);
    let corner = window.get_by_label("3D view").rect().right_center() - egui::vec2(6.0, 0.0);
    right_click(&mut window, corner);
    assert!(window.query_by_label("Simulate to here").is_none(), "no position is there");
    assert_eq!(window.state().state().look.selected, Some(2), "what is selected stays");
    window.get_by_label_contains("Top view").click();
    window.run_steps(3);
    let camera = window.state().camera().expect("a camera");
    assert!(camera.pitch_rad.abs() > 1.3, "along the axis: {}", camera.pitch_rad);
}

#[test]
fn without_a_part_a_right_click_does_nothing() {
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    right_click(&mut window, egui::pos2(450.0, 300.0));
    assert!(window.query_by_label("Fit").is_none());
}

#[test]
fn rows_and_plots_have_the_menu_of_their_position() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 760.0));
    window.run_steps(3);
    let row = window.get_by_role_and_label(Role::Row, "Position 4").rect().center();
    right_click(&mut window, row);
    assert_eq!(window.state().state().look.selected, None, "a right click selects nothing");
    window.get_by_label("At position 4");
    window.get_by_role_and_label(Role::Button, "Simulate to here").click();
    window.run_steps(4);
    assert_eq!(window.state().state().look.cut_count, Some(4));
    let plot = window.get_by_label("Contact along the row").rect();
    right_click(&mut window, plot.left_center() + egui::vec2(5.0, 0.0));
    window.get_by_label("At position 1");
    window.get_by_role_and_label(Role::Button, "Simulate to here").click();
    window.run_steps(4);
    assert_eq!(window.state().state().look.cut_count, Some(1));
}

#[test]
fn escape_closes_an_open_menu_before_it_ends_measuring() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::M);
    window.run_steps(2);
    let corner = window.get_by_label("3D view").rect().right_center() - egui::vec2(6.0, 0.0);
    right_click(&mut window, corner);
    window.get_by_label_contains("Top view");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label_contains("Top view").is_none(), "the menu is closed");
    assert!(window.state().state().look.measure.is_some(), "measuring goes on");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(window.state().state().look.measure.is_none(), "and ends at the next key");
}
