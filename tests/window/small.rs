//! The smallest window with large text: 800 × 500 pixels at 150 % are 533 × 333 points.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use crate::fake;
use crate::harness::{Window, pixels_in, sample_in, scaled, settle, turn_wheel};

const SIZE: egui::Vec2 = egui::Vec2::new(533.0, 333.0);
/// Height of the status bar, points.
const STATUS: f32 = 28.0;

fn small_window() -> Window {
    let mut window = sample_in(scaled(fake::engine().0, 1.5));
    window.set_size(SIZE);
    window.run_steps(6);
    settle(&mut window);
    window
}

/// Drags the left button from a point by a way.
fn drag(window: &mut Window, from: egui::Pos2, way: egui::Vec2) {
    let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
    window.hover_at(from);
    window.run_steps(2);
    window.event(egui::Event::PointerButton { pos: from, button, pressed: true, modifiers });
    window.run_steps(2);
    window.hover_at(from + way);
    window.run_steps(2);
    window.event(egui::Event::PointerButton { pos: from + way, button, pressed: false, modifiers });
    window.run_steps(6);
}

#[test]
fn all_columns_are_reached_in_the_smallest_window_with_large_text() {
    let mut window = small_window();
    let last = |window: &Window| window.get_by_label("Sort by residual stock").rect();
    assert!(last(&window).left() > SIZE.x, "the table is beyond the edge: {}", last(&window));
    let step = window.get_by_role_and_label(Role::SpinButton, "Step").rect();
    assert!(step.left() > 0.0 && step.right() < SIZE.x, "the setup is whole: {step}");
    // The bar lies above the status bar.
    let bar = egui::pos2(100.0, SIZE.y - STATUS - 3.0);
    drag(&mut window, bar, egui::vec2(400.0, 0.0));
    assert!(last(&window).right() <= SIZE.x, "the table is in view: {}", last(&window));
    let picture = window.get_by_label("3D view").rect();
    for name in ["Layers", "Wheel", "Channel"] {
        let mut buttons = window.query_all_by_role_and_label(Role::Button, name).map(|node| node.rect());
        assert!(buttons.any(|rect| picture.contains_rect(rect)), "{name} within {picture}");
    }
    let buttons = ["Layers", "Wheel"].map(|name| {
        let mut found = window.query_all_by_role_and_label(Role::Button, name).map(|node| node.rect());
        found.find(|rect| picture.contains_rect(*rect)).expect("a button")
    });
    assert!(!buttons[0].intersects(buttons[1]), "{buttons:?}");
}

/// Nothing of the window is left to the black that a frame begins with.
#[test]
fn no_black_strips_lie_beside_the_bars_that_scroll_the_panels() {
    let mut window = small_window();
    let pixels = SIZE * 1.5;
    for strip in [
        egui::Rect::from_min_max(egui::pos2(0.0, pixels.y - 84.0), egui::pos2(pixels.x, pixels.y)),
        egui::Rect::from_min_max(egui::pos2(pixels.x - 36.0, 0.0), pixels.to_pos2()),
    ] {
        let seen = pixels_in(&mut window, strip);
        let black = seen.iter().filter(|[r, g, b, _]| r.max(g).max(b) < &16).count();
        assert_eq!(black, 0, "of {} in {strip}", seen.len());
    }
}

#[test]
fn the_verdict_is_whole_in_the_smallest_window_with_large_text() {
    let window = small_window();
    let setup = window.get_by_label("impeller532").rect();
    let times = window.query_all_by_label("Time").map(|node| node.rect());
    let time = times.min_by(|a, b| a.top().total_cmp(&b.top())).expect("a time");
    assert!(time.bottom() < setup.top() - 4.0, "{time} is above {setup}");
}

#[test]
fn all_layers_are_reached_in_a_low_window() {
    let mut window = small_window();
    window.get_by_role_and_label(Role::Button, "Layers").click_accesskit();
    window.run_steps(4);
    let last = |window: &Window| window.get_by_role_and_label(Role::SpinButton, "Channels shown").rect();
    assert!(last(&window).bottom() > SIZE.y, "the menu is higher than the window: {}", last(&window));
    let first = window.get_by_role_and_label(Role::CheckBox, "Hub").rect();
    assert!(first.top() > 0.0, "{first}");
    window.hover_at(first.center());
    window.run_steps(2);
    for _ in 0..20 {
        turn_wheel(&mut window, -60.0, 2);
    }
    window.run_steps(10);
    assert!(last(&window).bottom() < SIZE.y, "it scrolls to its end: {}", last(&window));
}

/// In a small window the message over two pictures is whole, with what to do.
#[test]
fn a_message_over_a_small_view_is_whole_with_its_cure() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("cut-off.glb");
    let header = [*b"glTF", 2_u32.to_le_bytes(), 695_520_u32.to_le_bytes(), 0_u32.to_le_bytes()];
    std::fs::write(&file, header.concat()).expect("writes");
    let mut window = sample_in(scaled(fake::engine().0, 1.0));
    window.set_size(egui::Vec2::new(800.0, 500.0));
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::B);
    window.run_steps(6);
    settle(&mut window);
    window.state_mut().open_path(file);
    settle(&mut window);
    window.run_steps(4);
    let cure = |window: &Window| window.get_by_label_contains("Fix: the file seems cut off").rect();
    let half = |side: &str| window.get_by_label(&format!("3D view, {side}")).rect();
    let (view, shown) = (half("before").union(half("after")), cure(&window));
    assert!(view.x_range().contains(shown.right()) && shown.bottom() < view.bottom(), "{shown} in {view}");
    window.hover_at(shown.center_top() - egui::vec2(0.0, 8.0));
    window.run_steps(2);
    for _ in 0..5 {
        turn_wheel(&mut window, -30.0, 2);
    }
    window.run_steps(10);
    assert_eq!(cure(&window), shown, "there is nothing to scroll to");
    let wipe = window.get_by_role_and_label(Role::Button, "Wipe").rect();
    assert!(wipe.right() < view.right(), "{wipe} in {view}");
}
