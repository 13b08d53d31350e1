//! Before and after in one window, and the tools of the 3D view.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::{Arrangement, PlaneOrientation};
use vanecut::app::model::planned::Side;
use vanecut::setup::AxisPolicy;

use crate::fake;
use crate::harness::{Window, press, settle, snapshot_view, with_sample, words};

fn wide(engine: vanecut::app::tasks::engine::Engine) -> Window {
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 760.0));
    window.run_steps(3);
    window.key_press(egui::Key::Num4);
    window.run_steps(3);
    let document = &window.state().state().document;
    assert!(!document.is_unsaved(), "looking changes nothing: {:?}", document.edited);
    window
}

#[test]
fn both_sides_share_one_camera_and_one_scale() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.get_by_label("Both").click();
    window.run_steps(4);
    snapshot_view(&mut window, "both");
    let (left, right) =
        (window.get_by_label("3D view, before").rect(), window.get_by_label("3D view, after").rect());
    assert!(left.right() <= right.left() + 1.0 && (left.width() - right.width()).abs() < 2.0);
    let before = window.state().camera().expect("a camera");
    window.drag_at(right.center());
    window.run_steps(1);
    window.hover_at(right.center() + egui::vec2(40.0, 10.0));
    window.run_steps(1);
    window.drop_at(right.center() + egui::vec2(40.0, 10.0));
    window.run_steps(3);
    let after = window.state().camera().expect("a camera");
    assert!((after.yaw_rad - before.yaw_rad).abs() > 0.1, "a drag on either side turns both");
    let field = window.get_by_role_and_label(Role::SpinButton, "Scale maximum");
    field.set_value_accesskit(2.0);
    window.run_steps(3);
    assert_eq!(window.state().state().range(), (0.0, 2.0), "one scale for both");
    window.get_by_label("Fit scale").click();
    window.run_steps(3);
    let state = window.state().state();
    assert_eq!(state.range(), state.fitting_range(), "and back");
}

/// The same in the list of strategies as in the headline.
#[test]
fn figures_of_strategies_are_marked_until_they_are_calculated_anew() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    assert!(window.query_by_label("0 interfering").is_some());
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.0);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.query_by_label("0 interfering").is_none());
    window.get_by_label("Out of date: 0 interfering");
    window.key_press(egui::Key::F5);
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("0 interfering");
}

#[test]
fn the_wipe_has_a_border_to_drag() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.get_by_label("Wipe").click();
    window.run_steps(4);
    let handle = window.get_by_role_and_label(Role::Slider, "Wipe divider").rect();
    let to = handle.center() - egui::vec2(80.0, 0.0);
    window.drag_at(handle.center());
    window.run_steps(1);
    window.hover_at(to);
    window.run_steps(1);
    window.drop_at(to);
    window.run_steps(3);
    assert!(window.state().state().look.wipe < 0.42, "{}", window.state().state().look.wipe);
    snapshot_view(&mut window, "wipe");
    window.key_press(egui::Key::B);
    window.run_steps(2);
    assert_eq!(window.state().state().look.arrangement, Arrangement::One, "B shows one alone");
}

#[test]
fn the_difference_of_two_plans_is_a_map_around_zero() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::D);
    window.run_steps(4);
    window.get_by_label("Stock after − before");
    snapshot_view(&mut window, "difference");
}

#[test]
fn either_side_shows_any_policy_that_was_planned() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.set_size(egui::vec2(1200.0, 1180.0));
    window.run_steps(3);
    window.get_by_label("Compare all strategies").click();
    window.run_steps(3);
    settle(&mut window);
    window.get_by_role_and_label(Role::ComboBox, "Axis strategy after").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Progressive").click();
    window.run_steps(3);
    let state = window.state().state();
    assert_eq!(state.policy(Side::After), Some(AxisPolicy::Monotone));
    assert_eq!(
        state.shown().expect("planned").plan().policy,
        AxisPolicy::Monotone,
        "table and picture follow"
    );
}

/// The map of the difference is that of whole plans, and says so while the timeline shows less.
#[test]
fn the_difference_says_that_it_is_that_of_whole_plans() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::D);
    window.run_steps(3);
    window.get_by_label("Stock after − before");
    window.key_press(egui::Key::Home);
    window.run_steps(3);
    window.get_by_label("Finished: after − before");
}

/// What is exported is the plan whose policy is shown, not the one of the setup.
#[test]
fn the_program_of_a_policy_is_that_of_the_plan_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shown.apt");
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.set_size(egui::vec2(1200.0, 1160.0));
    window.run_steps(3);
    window.get_by_label("Compare all strategies").click();
    window.run_steps(3);
    settle(&mut window);
    let tips = |window: &Window| -> Vec<_> {
        let shown = window.state().state().shown().expect("a plan");
        shown.plan().positions.iter().map(|position| position.tip).collect()
    };
    let of_setup = tips(&window);
    window.get_by_role_and_label(Role::ComboBox, "Axis strategy after").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Isoparametric").click();
    window.run_steps(3);
    let shown = tips(&window);
    assert_ne!(shown, of_setup, "another plan is shown");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 1 }, path.clone());
    window.run_steps(2);
    window.get_by_label("Export anyway").click();
    window.run_steps(2);
    settle(&mut window);
    let program = vanecut::io::apt::read_apt(&path).expect("a CL file");
    let written = |tip: &vanecut::geometry::Point| program.moves.iter().any(|m| (m.tip - tip).norm() < 1e-5);
    assert!(shown.iter().all(written), "every plunge of the shown plan is in the program");
    assert!(!of_setup.iter().any(written), "and none of the other plan");
}

#[test]
fn the_cube_turns_the_wheel_and_p_makes_rays_parallel() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    let before = window.state().camera().expect("a camera");
    window.get_by_label("View from −Z").click();
    window.run_steps(3);
    let camera = window.state().camera().expect("a camera");
    assert_ne!(before.pitch_rad, camera.pitch_rad);
    assert!(camera.basis().2.z < -0.99, "looking along Z: {:?}", camera.basis().2);
    window.key_press(egui::Key::P);
    window.run_steps(3);
    assert_eq!(window.state().camera().expect("a camera").projection, vanecut::gpu::Projection::Orthographic);
    snapshot_view(&mut window, "parallel");
}

#[test]
fn a_section_plane_cuts_the_part_open() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.key_press(egui::Key::X);
    window.run_steps(4);
    assert!(window.state().state().look.section.is_some());
    snapshot_view(&mut window, "section_plane");
    // Seen along its normal: hub and blades are filled where the plane cuts them.
    window.state_mut().look_mut().section.as_mut().expect("a plane").across = PlaneOrientation::X;
    window.get_by_label("View from +X").click();
    window.key_press(egui::Key::F);
    window.run_steps(4);
    snapshot_view(&mut window, "section_cap");
    window.get_by_role_and_label(Role::Slider, "Section plane").set_value_accesskit(12.0);
    window.get_by_label("Flip").click();
    window.run_steps(3);
    let section = window.state().state().look.section.expect("a plane");
    assert!(section.flipped && (section.offset - 12.0).abs() < 1e-3, "{section:?}");
    window.get_by_label("Close").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.section, None);
}

#[test]
fn two_clicks_measure_a_distance() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.key_press(egui::Key::M);
    window.run_steps(3);
    let rect = window.get_by_label("3D view").rect();
    for by in [egui::vec2(-30.0, 0.0), egui::vec2(40.0, 30.0)] {
        press(&mut window, rect.center() + by);
        window.run_steps(3);
    }
    let points = window.state().state().look.measure.clone().expect("measuring");
    assert_eq!(points.len(), 2, "{points:?}");
    let distance = points[0].distance(points[1]);
    assert!(distance > 1.0 && distance < 200.0, "{distance} mm on the wheel");
    assert_eq!(window.state().state().look.selected, None, "measuring selects nothing");
    snapshot_view(&mut window, "measure");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert_eq!(window.state().state().look.measure, None, "Esc ends it");
}

#[test]
fn layers_are_switched_from_the_view() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.get_by_label("Position 5").click();
    window.run_steps(6);
    window.get_by_label("Layers").click();
    window.run_steps(3);
    for name in ["Holders", "Rapids", "Axes", "Shroud"] {
        window.get_by_role_and_label(Role::CheckBox, name).click();
        window.run_steps(2);
    }
    let layers = window.state().state().look.layers;
    assert!(layers.holders && layers.links && layers.axes && layers.shroud, "{layers:?}");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    snapshot_view(&mut window, "layers");
}

#[test]
fn the_value_under_the_cursor_is_that_of_both_sides() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.state_mut().look_mut().layers.cutters = false;
    window.get_by_label("Both").click();
    window.run_steps(4);
    let planned = window.state().state().results.planned.clone().expect("planned");
    let outcome = &planned.outcome;
    let camera = window.state().camera().expect("a camera");
    let stock = |result: &vanecut::job::PolicyResult, cell: usize| result.field.heights[cell];
    // Cells that both plans cut, and not alike, where no blade stands before them.
    let cut_apart = |cell: &usize| {
        let (i, j) = (cell / outcome.grid.columns, cell % outcome.grid.columns);
        if !(36..56).contains(&i) || !(8..24).contains(&j) {
            return false;
        }
        let (before, after) = (stock(&outcome.before, *cell), stock(&outcome.after, *cell));
        before < outcome.grid.blank_heights[*cell] - 1.0 && before - after > 0.1
    };
    let mut tested = 0;
    for cell in (0..outcome.grid.points.len()).filter(cut_apart).step_by(9) {
        let (before, after) = (stock(&outcome.before, cell), stock(&outcome.after, cell));
        for (name, words) in [
            ("3D view, before", format!("{before:.2}, after {after:.2} mm")),
            ("3D view, after", format!("{after:.2}, before {before:.2} mm")),
        ] {
            let rect = window.get_by_label(name).rect();
            let size = glam::vec2(rect.width(), rect.height());
            let point = glam::Vec3::from_array(outcome.grid.points[cell]);
            let Some(pixel) = camera.project(point, size) else { continue };
            let at = rect.min + egui::vec2(pixel.x, pixel.y);
            // Skip points under the legend or a button.
            if !rect.shrink(90.0).contains(at) {
                continue;
            }
            window.hover_at(at);
            window.run_steps(2);
            window.get_by_label(&words);
            tested += 1;
        }
    }
    assert!(tested >= 4, "places on the floor that can be seen: {tested}");
    let corner = window.get_by_label("3D view, before").rect().left_center() + egui::vec2(3.0, 0.0);
    window.hover_at(corner);
    window.run_steps(2);
    assert!(window.query_by_label_contains(", after ").is_none(), "nothing beside the channel");
}

#[test]
fn the_figure_under_a_resting_pointer_is_that_of_what_is_drawn() {
    let (engine, _) = fake::engine();
    let mut window = wide(engine);
    window.state_mut().look_mut().layers.cutters = false;
    window.key_press(egui::Key::Num4);
    window.run_steps(8);
    settle(&mut window);
    let rect = window.get_by_label("3D view").rect();
    let at = |k: usize| rect.min + rect.size() * egui::vec2((k % 24) as f32 / 24.0, (k / 24) as f32 / 24.0);
    let found = (1..576).map(|k| at(217 * k % 576)).find(|&at| {
        window.hover_at(at);
        window.step();
        words(&window, " mm here").is_some()
    });
    assert!(found.is_some(), "the floor is seen");
    window.run_steps(2);
    let stock = words(&window, " mm here").expect("a figure");
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::D);
    window.run_steps(4);
    let difference = words(&window, " mm here").expect("a figure");
    assert_ne!(difference, stock);
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::D);
    window.run_steps(4);
    assert_eq!(words(&window, " mm here"), Some(stock));
}

/// Flank passes and checked programs have no sides: a wipe would show two halves of different things.
#[test]
fn only_roughing_is_shown_in_two_views() {
    use vanecut::app::model::look::{Arrangement, Operation};
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::B);
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("3D view, before");
    for operation in [Operation::Flank, Operation::Program] {
        window.state_mut().look_mut().operation = operation;
        window.run_steps(3);
        settle(&mut window);
        assert!(window.query_by_label("3D view, before").is_none(), "{operation:?}");
        window.get_by_label("3D view");
        window.key_press(egui::Key::B);
        window.run_steps(3);
        assert_eq!(window.state().state().look.arrangement, Arrangement::Both, "nothing unseen changes");
    }
    window.state_mut().look_mut().operation = Operation::Roughing;
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("3D view, before");
}
