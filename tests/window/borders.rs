//! Section borders, dragged in the 3D view.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;

use crate::fake;
use crate::harness::{Window, settle, snapshot_view, with_sample};

const SETUP: &str = "
[[tool]]
number = 1
diameter = 30
[[tool]]
number = 2
diameter = 16
[[plunge.section]]
tool = 1
from = 1.0
to = 0.5
[[plunge.section]]
tool = 2
from = 0.5
to = 0.1
";

/// A window with the sample and a setup, in the view of the channel, without cutters over the handles.
fn with_borders(setup: &str) -> Window {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("setup.toml");
    std::fs::write(&path, setup).expect("writes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 760.0));
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::OpenSetup, path);
    settle(&mut window);
    window.state_mut().look_mut().layers.cutters = false;
    window.key_press(egui::Key::Num4);
    window.run_steps(10);
    settle(&mut window);
    window
}

fn borders(window: &Window) -> [f64; 4] {
    let sections = &window.state().state().document.edited.setup.plunge.sections;
    [sections[0].from, sections[0].to, sections[1].from, sections[1].to]
}

#[test]
fn a_border_is_dragged_along_the_hub_and_a_drag_is_one_step_to_undo() {
    let mut window = with_borders(SETUP);
    assert_eq!(borders(&window), [1.0, 0.5, 0.5, 0.1]);
    let grip = |window: &Window| {
        window.get_by_role_and_label(Role::Slider, "Border 1 | 2 in the view").rect().center()
    };
    let (start, camera) = (grip(&window), window.state().camera());
    let end = start + egui::vec2(-30.0, 60.0);
    window.drag_at(start);
    window.run_steps(1);
    for share in [0.3, 0.6, 1.0] {
        window.hover_at(start + share * (end - start));
        // Longer than the rest time that otherwise ends an undo step.
        window.run_steps(8);
    }
    settle(&mut window);
    let held = borders(&window);
    assert!((held[1] - 0.5).abs() > 0.03 && held[1] == held[2], "both sections follow: {held:?}");
    assert_eq!((held[0], held[3]), (1.0, 0.1), "the other ends stay");
    let planned = window.state().state().results.planned.clone().expect("planned");
    assert_eq!(planned.setup.plunge.sections[0].to, held[1], "planned while it is held");
    assert!(grip(&window).distance(end) < start.distance(end) * 0.6, "it follows the cursor");
    assert_eq!(window.state().camera(), camera, "the camera stays");
    snapshot_view(&mut window, "border");
    window.drop_at(end);
    window.run_steps(10);
    settle(&mut window);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(2);
    assert_eq!(borders(&window), [1.0, 0.5, 0.5, 0.1], "one step back is the whole drag");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Y);
    window.run_steps(2);
    assert_eq!(borders(&window), held, "and again");

    // Dragged far beyond the next border, it stops just before it.
    let start = grip(&window);
    window.drag_at(start);
    window.run_steps(1);
    window.hover_at(start + egui::vec2(-300.0, 600.0));
    window.run_steps(2);
    window.drop_at(start + egui::vec2(-300.0, 600.0));
    window.run_steps(2);
    let [from, to, _, last] = borders(&window);
    assert!(to < from && to > last, "{:?}", borders(&window));
}

#[test]
fn a_handle_moves_its_own_border_and_rest_milling_has_none() {
    // Rest milling of both halves, with a border at the same place.
    let rest = "[[plunge.section]]\ntool = 2\nfrom = 1.0\nto = 0.5\nrest = true\n\
                [[plunge.section]]\ntool = 2\nfrom = 0.5\nto = 0.1\nrest = true\n";
    let mut window = with_borders(&format!("{SETUP}{rest}"));
    assert!(window.query_by_label("Border 3 | 4 in the view").is_none(), "it would lie on the other");
    let start = window.get_by_role_and_label(Role::Slider, "Border 1 | 2 in the view").rect().center();
    let end = start + egui::vec2(-30.0, 60.0);
    window.drag_at(start);
    window.run_steps(1);
    window.hover_at(end);
    window.run_steps(3);
    window.drop_at(end);
    window.run_steps(3);
    settle(&mut window);
    let moved = borders(&window);
    assert!((moved[1] - 0.5).abs() > 0.03 && moved[1] == moved[2], "{moved:?}");
    let sections = &window.state().state().document.edited.setup.plunge.sections;
    assert_eq!((sections[2].to, sections[3].from), (0.5, 0.5), "rest milling stays");
}
