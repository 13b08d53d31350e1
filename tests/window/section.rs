//! Sectional view, plots along the row and timeline.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::look::{DrawingPart, PlaneOrientation, SectionalLook};

use crate::fake;
use crate::harness::{
    Window, choose_in_list, labels, press, settle, snapshot_view, turn_wheel, type_into, with_sample,
};

/// A window with the conventional plan and its first fault selected, and the index of that position.
fn with_fault_selected() -> (Window, usize) {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 760.0));
    window.run_steps(3);
    window.key_press(egui::Key::B);
    window.key_press(egui::Key::N);
    window.run_steps(4);
    settle(&mut window);
    let k = window.state().state().look.selected.expect("a fault");
    (window, k)
}

#[test]
fn the_section_of_the_selected_position_is_drawn_with_its_figures() {
    let (mut window, k) = with_fault_selected();
    window.get_by_label(&format!("Sectional view through position {}", k + 1));
    window.get_by_label_contains("step ");
    snapshot_view(&mut window, "section");
    window.get_by_label("Figures").click();
    window.run_steps(3);
    window.get_by_label("Tool tip X Y Z");
}

/// While the drawing is still that of the position before, so are all figures below it.
#[test]
fn the_figures_below_the_section_are_those_of_the_drawing() {
    let (mut window, _) = with_fault_selected();
    let figures = |window: &Window| labels(window, "lead ").concat();
    let before = figures(&window);
    assert!(before.contains("tilt in this cut") && before.contains("max residual"), "{before}");
    let mut shown = Vec::new();
    window.key_press(egui::Key::ArrowDown);
    for _ in 0..3 {
        window.step();
        shown.push(figures(&window));
    }
    settle(&mut window);
    let after = figures(&window);
    assert_ne!(before, after);
    assert!(shown.iter().all(|shown| *shown == before || *shown == after), "{before}; {after}: {shown:?}");
}

/// A click on a tab finds it where it was, whatever the others show.
#[test]
fn the_tabs_of_a_position_stay_where_they_are_while_their_content_changes() {
    let (mut window, _) = with_fault_selected();
    let tabs = |window: &Window| {
        ["Sectional view", "Figures", "By hand"].map(|name| {
            window.get_all_by_label(name).map(|node| node.rect().center()).next_back().expect("a tab")
        })
    };
    // The highest content first, then the others.
    for name in ["Figures", "By hand", "Sectional view"] {
        window.get_by_label(name).click();
        window.run_steps(6);
    }
    let before = tabs(&window);
    for name in ["Figures", "By hand", "Sectional view"] {
        window.get_by_label(name).click();
        window.run_steps(6);
        assert_eq!(tabs(&window), before, "{name}");
        window.key_press(egui::Key::ArrowDown);
        window.run_steps(6);
        settle(&mut window);
        assert_eq!(tabs(&window), before, "{name} of another position");
    }
}

#[test]
fn the_cut_can_be_chosen_zoomed_and_enlarged() {
    let (mut window, k) = with_fault_selected();
    let cut = |window: &Window| {
        window.get_by_role_and_label(Role::ComboBox, "Cut").accesskit_node().value().expect("a plane")
    };
    assert_eq!(cut(&window), "Through contact", "where the core meets stock");
    window.get_by_role_and_label(Role::ComboBox, "Cut").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Across the row").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(cut(&window), "Across the row");
    let name = format!("Sectional view through position {}", k + 1);
    let at = window.get_by_label(&name).rect().center();
    window.hover_at(at);
    turn_wheel(&mut window, 240.0, 12);
    let zoom = window.state().state().look.sectional.docked.zoom;
    assert!(zoom > 1.5, "zoomed: {zoom}");
    window.get_by_label("Fit cut").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.sectional.docked.zoom, 1.0);
    let small = window.get_by_label(&name).rect();
    window.get_by_label("Enlarge").click();
    window.run_steps(4);
    let large = window.get_by_label(&format!("Enlarged sectional view through position {}", k + 1)).rect();
    assert!(large.area() > 2.0 * small.area(), "{large} for {small}");
    snapshot_view(&mut window, "section_enlarged");
    window.hover_at(large.center());
    turn_wheel(&mut window, 240.0, 12);
    let SectionalLook { docked, enlarged, .. } = window.state().state().look.sectional;
    assert!(enlarged.zoom > 1.5, "zoomed: {}", enlarged.zoom);
    assert_eq!(docked, DrawingPart::default(), "each drawing has a part of its own");
}

#[test]
fn a_click_on_a_plot_selects_the_position_there() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 760.0));
    window.run_steps(3);
    let rect = window.get_by_label("Lead angle along the row").rect();
    press(&mut window, rect.right_center() - egui::vec2(6.0, 0.0));
    window.run_steps(3);
    let last = window.state().state().position_count() / 2 - 1;
    assert_eq!(window.state().state().look.selected, Some(last), "the end of the first row");
    for name in ["Contact", "Stock", "Step"] {
        window.get_by_label(&format!("{name} along the row"));
    }
}

/// In a small window the names of the plots do not fit.
#[test]
fn a_plot_has_its_whole_name_under_the_pointer() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    for name in ["Lead angle", "Contact", "Stock", "Step", "Arc"] {
        let at = window.get_by_label(&format!("{name} along the row")).rect();
        window.hover_at(at.left_center() + egui::vec2(6.0, 0.0));
        window.run_steps(20);
        window.get_by_label_contains(&format!("{name}, 1 of the row: "));
    }
}

#[test]
fn the_timeline_shows_the_stock_as_it_is_then() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    let count = window.state().state().position_count();
    window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(10.0);
    window.run_steps(2);
    settle(&mut window);
    let look = &window.state().state().look;
    assert_eq!((look.cut_count, look.selected), (Some(10), Some(9)), "what was cut last is selected");
    window.get_by_label(&format!("10 of {count}"));
    snapshot_view(&mut window, "timeline");
    window.key_press(egui::Key::ArrowRight);
    window.run_steps(2);
    assert_eq!(window.state().state().look.cut_count, Some(11), "one more");
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::ArrowLeft);
    window.run_steps(2);
    assert_eq!(window.state().state().look.cut_count, Some(0), "it ends at the blank");
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::ArrowRight);
    window.run_steps(2);
    assert_eq!(window.state().state().look.cut_count, Some(count), "and at the end");
    // The text of the sectional view takes height from the table when it arrives: a row at the end may leave
    // the table in the frame of the click.
    for _ in 0..5 {
        settle(&mut window);
        window.run_steps(4);
        window.get_by_label(&format!("Position {}", count - 2)).click_accesskit();
        window.run_steps(3);
        if window.state().state().look.cut_count == Some(count - 2) {
            break;
        }
    }
    assert_eq!(window.state().state().look.cut_count, Some(count - 2), "the table moves it too");
    window.get_by_role_and_label(Role::Button, "Go to end").click();
    window.run_steps(2);
    assert_eq!(window.state().state().look.cut_count, None);
}

#[test]
fn play_runs_to_the_end_and_rests_there() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let count = window.state().state().position_count();
    window.get_by_role_and_label(Role::Button, "Play").click();
    window.step();
    window.step();
    assert!(window.state().state().look.playing.is_some(), "it plays");
    for _ in 0..40 {
        window.step();
    }
    let look = &window.state().state().look;
    assert_eq!((look.playing, look.cut_count), (None, Some(count)), "the end");
    window.key_press(egui::Key::Space);
    window.step();
    window.step();
    assert!(window.state().state().look.playing.is_some(), "space plays again, from the blank");
    window.key_press(egui::Key::Space);
    window.step();
    window.step();
    let cut = window.state().state().look.cut_count;
    assert!(window.state().state().look.playing.is_none() && cut < Some(count), "and stops: {cut:?}");
}

/// Whether any cutter is under the pointer where each of `positions` is cut, a little above its tip.
fn has_cutter(window: &mut Window, positions: [usize; 2]) -> [bool; 2] {
    let rect = window.get_by_label("3D view").rect();
    let camera = window.state().camera().expect("a camera");
    let plan = window.state().state().shown().expect("planned").plan();
    let places = positions.map(|k| &plan.positions[k]).map(|p| p.tip + p.axis * 3.0);
    places.map(|place| {
        let point = glam::vec3(place.x as f32, place.y as f32, place.z as f32);
        let pixel = camera.project(point, glam::vec2(rect.width(), rect.height())).expect("in front");
        window.event(egui::Event::PointerGone);
        window.run_steps(2);
        window.hover_at(rect.min + egui::vec2(pixel.x, pixel.y));
        window.run_steps(8);
        !labels(window, "Cut after ").is_empty()
    })
}

#[test]
fn the_controls_of_the_section_plane_are_all_there_in_a_small_window() {
    for (width, height) in [(800.0, 500.0), (1280.0, 860.0)] {
        let mut window = with_sample(fake::engine_with_holder());
        window.set_size(egui::vec2(width, height));
        window.run_steps(4);
        window.key_press(egui::Key::X);
        window.run_steps(4);
        settle(&mut window);
        let view = window.get_by_label("3D view").rect();
        let buttons =
            ["Wheel", "Channel"].map(|name| window.get_by_role_and_label(Role::Button, name).rect());
        for (role, name) in [
            (Role::ComboBox, "Section plane"),
            (Role::CheckBox, "Flip"),
            (Role::Button, "Close"),
            (Role::Slider, "Section plane"),
            (Role::SpinButton, "Section plane"),
        ] {
            let part = window.get_by_role_and_label(role, name).rect();
            assert!(view.contains_rect(part), "{name} {part} is not within {view}");
            for button in buttons {
                assert!(!button.intersects(part), "{name} {part} lies on {button}");
            }
        }
    }
}

#[test]
fn the_section_plane_cuts_cutters_and_holders() {
    let mut window = with_sample(fake::engine_with_holder());
    window.set_size(egui::vec2(1280.0, 860.0));
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    window.state_mut().look_mut().select(Some(8));
    window.run_steps(4);
    settle(&mut window);
    // Both ends of the row, on different sides of the meridian of the selected position.
    let ends = [0, 15];
    assert_eq!(has_cutter(&mut window, ends), [true; 2]);
    window.key_press(egui::Key::X);
    window.run_steps(3);
    window.get_by_role_and_label(Role::ComboBox, "Section plane").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Meridional").click();
    window.run_steps(4);
    settle(&mut window);
    let one = has_cutter(&mut window, ends);
    window.get_by_label("Flip").click();
    window.run_steps(4);
    settle(&mut window);
    let other = has_cutter(&mut window, ends);
    assert_eq!(one, other.map(|is_there| !is_there), "each half has one end");
    assert_ne!(one[0], one[1]);

    // Through the axis of the selected tool: core, inserts, shank and holder in the face of the cut.
    window.get_by_role_and_label(Role::ComboBox, "Section plane").click();
    window.run_steps(2);
    window.get_by_label("Along the row").click();
    window.run_steps(3);
    window.state_mut().look_mut().layers.holders = true;
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "section_tools");
}

/// Turns the section plane into a meridional one, moved by `offset` mm.
fn cut_meridionally(window: &mut Window, offset: f64) {
    choose_in_list(window, "Section plane", "Meridional");
    window.get_by_role_and_label(Role::Slider, "Section plane").set_value_accesskit(offset);
    window.run_steps(4);
    settle(window);
}

#[test]
fn a_meridional_plane_contains_the_axis_and_turns_about_it() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 860.0));
    window.key_press(egui::Key::X);
    window.run_steps(3);
    cut_meridionally(&mut window, 12.0);
    let section = window.state().state().look.section.expect("a plane");
    assert_eq!((section.across, section.offset), (PlaneOrientation::Meridian, 12.0));
    snapshot_view(&mut window, "section_meridian");
    // Another orientation begins without offset.
    choose_in_list(&mut window, "Section plane", "Normal to X");
    assert_eq!(window.state().state().look.section.expect("a plane").offset, 0.0);
}

/// At Z 0 of the program, which is that of the part, the plane is at Z 0.
#[test]
fn the_offset_of_a_plane_across_an_axis_is_its_coordinate() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 860.0));
    window.key_press(egui::Key::X);
    window.run_steps(3);
    choose_in_list(&mut window, "Section plane", "Normal to Z");
    let offset = |window: &Window| window.state().state().look.section.expect("a plane").offset;
    let part = window.state().state().document.part.clone().expect("a part").impeller;
    let height = |u: f64| part.hub.point(u).z as f32;
    let first = offset(&window);
    assert!((height(0.0).min(height(1.0))..height(0.0).max(height(1.0))).contains(&first), "{first}");
    window.get_by_role_and_label(Role::Slider, "Section plane").set_value_accesskit(-20.0);
    window.run_steps(3);
    assert_eq!(offset(&window), -20.0);
    snapshot_view(&mut window, "section_z");
    // What is beyond its ends is not taken.
    type_into(&mut window, ("Section plane", 0), "5000");
    assert_eq!(offset(&window), -20.0);
    window.get_by_label_contains("5000 is too much: at most ");
}

#[test]
fn a_closed_section_plane_opens_as_it_was() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 860.0));
    let plane = |window: &Window| window.state().state().look.section.map(|s| (s.across, s.offset));
    window.key_press(egui::Key::X);
    window.run_steps(3);
    assert_eq!(plane(&window), Some((PlaneOrientation::Row, 0.0)));
    cut_meridionally(&mut window, 12.0);
    for close in ["the key", "the button"] {
        match close {
            "the key" => window.key_press(egui::Key::X),
            _ => window.get_by_role_and_label(Role::Button, "Close").click(),
        }
        window.run_steps(3);
        assert_eq!(plane(&window), None, "{close} closes it");
        window.key_press(egui::Key::X);
        window.run_steps(3);
        assert_eq!(plane(&window), Some((PlaneOrientation::Meridian, 12.0)), "after {close}");
    }
}

#[test]
fn the_sectional_view_shows_shank_and_holder_when_it_is_zoomed_out() {
    let mut window = with_sample(fake::engine_with_holder());
    window.set_size(egui::vec2(1280.0, 860.0));
    window.run_steps(3);
    window.get_by_label("Position 5").click();
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("Enlarge").click();
    window.run_steps(4);
    let at = window.get_by_label("Enlarged sectional view through position 5").rect().center();
    window.hover_at(at);
    for _ in 0..3 {
        turn_wheel(&mut window, -240.0, 12);
    }
    let zoom = window.state().state().look.sectional.enlarged.zoom;
    assert!(zoom < 0.3, "the whole tool: {zoom}");
    snapshot_view(&mut window, "section_holder");
}
