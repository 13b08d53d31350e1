//! The stock as a solid in the 3D view.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::{Operation, PlaneOrientation, SectionPlaneLook};
use vanecut::app::model::planned::Side;
use vanecut::app::model::solid::SolidColours;
use vanecut::app::model::units::DisplayUnits;
use vanecut::error::ErrorCode;
use vanecut::io::apt::write_apt;
use vanecut::io::stl::read_stl_bytes;
use vanecut::toolpath::ClProgram;

use crate::fake;
use crate::flank;
use crate::harness::{
    Window, choose_in_file_menu, click_enabled, labels, pixels_in, settle, snapshot_view, with_sample,
};
use crate::program::{check, write};

/// A window with the layer shown, seen onto the channel.
fn with_stock() -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 760.0));
    window.run_steps(3);
    window.key_press(egui::Key::Num4);
    window.key_press(egui::Key::S);
    window.step();
    settle(&mut window);
    window
}

fn volume(window: &Window) -> f64 {
    window.state().solid(Side::After).expect("a solid").volume
}

#[test]
fn both_sides_say_how_much_stock_they_leave() {
    let mut window = with_stock();
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::B);
    window.run_steps(3);
    settle(&mut window);
    for side in [Side::Before, Side::After] {
        let solid = window.state().solid(side).expect("a solid");
        let (volume, collisions) = (DisplayUnits::Metric.volume(solid.volume), solid.collisions);
        window.get_by_label_contains(&format!("{}: stock {volume}", side.label()));
        let meet = format!("{collisions} moves meet stock");
        assert_eq!(labels(&window, &meet).is_empty(), collisions == 0, "{meet}");
    }
    snapshot_view(&mut window, "solid_both");
}

#[test]
fn the_solid_follows_the_timeline() {
    let mut window = with_stock();
    let done = volume(&window);
    let solid = window.state().solid(Side::After).expect("a solid");
    assert!(!solid.is_coarse, "fine in the end");
    let draft = solid.draft.as_ref().expect("for pictures in motion");
    assert!(3 * draft.triangles() < solid.mesh.triangles(), "{} triangles", draft.triangles());
    snapshot_view(&mut window, "stock");
    let count = window.state().state().position_count();
    let mut last = f64::INFINITY;
    for cut in [0, 1, count / 2, count] {
        window.state_mut().look_mut().cut_count = Some(cut);
        window.step();
        settle(&mut window);
        let now = volume(&window);
        assert!(now < last, "each position removes stock: {now} after {cut}, {last} before");
        if cut == count / 2 {
            snapshot_view(&mut window, "stock_half");
        }
        last = now;
    }
    assert!((last - done).abs() < 1e-6 * done, "{last} {done}");
    // Back again, from a checkpoint.
    window.state_mut().look_mut().cut_count = Some(1);
    window.step();
    settle(&mut window);
    assert!(volume(&window) > last);
    window.key_press(egui::Key::S);
    window.step();
    settle(&mut window);
    assert!(window.state().solid(Side::After).is_none(), "hidden, it is not kept");
}

#[test]
fn tools_sections_and_faults_colour_the_solid_and_the_section_plane_cuts_it() {
    let mut window = with_stock();
    window.get_by_label("Distance to part");
    for (colours, name) in
        [(SolidColours::Tool, "T1 D30"), (SolidColours::Section, "Section 1"), (SolidColours::Fault, "Sound")]
    {
        window.state_mut().look_mut().solid_colours = colours;
        window.step();
        settle(&mut window);
        let solid = window.state().solid(Side::After).expect("a solid");
        assert!(solid.names.iter().any(|(_, known)| known == name), "{colours:?}: {:?}", solid.names);
    }
    window.state_mut().look_mut().solid_colours = SolidColours::Distance;
    window.state_mut().look_mut().section =
        Some(SectionPlaneLook { across: PlaneOrientation::Row, ..Default::default() });
    window.step();
    settle(&mut window);
    let state = window.state().state();
    assert!(state.problems.is_empty() && state.look.section.is_some(), "{:?}", state.problems);
    // The controls of the plane do not hide the volume.
    let volume = window.get_by_label_contains("cm³").rect();
    assert!(!volume.intersects(window.get_by_label("Flip").rect()), "{volume:?}");
    assert!(volume.bottom() < window.get_by_label("Flip").rect().top(), "{volume:?}");
}

#[test]
fn the_legend_gives_the_distance_of_what_is_cut_and_nothing_of_the_blank() {
    let mut window = with_stock();
    let view = window.get_by_label("3D view").rect().shrink(60.0);
    let mut read = Vec::new();
    for k in 0..24 {
        let at = view.min
            + egui::vec2((k % 6) as f32 + 0.5, (k / 6) as f32 + 0.5) * view.size() / egui::vec2(6.0, 4.0);
        window.hover_at(at);
        window.run_steps(2);
        read.push(labels(&window, "").into_iter().find(|label| label.ends_with(" here")));
    }
    let cut = read.iter().flatten().count();
    assert!((1..20).contains(&cut), "{read:?}");
    assert!(!read.iter().flatten().any(|label| label == "0.00 mm here"), "{read:?}");
}

#[test]
fn the_solid_is_exported_as_stl_and_gltf_and_nothing_else() {
    let mut window = with_stock();
    let folder = std::env::temp_dir().join(format!("vanecut-solid-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let ctx = window.ctx.clone();
    let mut export = |name: &str| {
        let path = folder.join(name);
        window.state_mut().file_chosen(&ctx, Purpose::ExportStock { side: None }, path.clone());
        window.step();
        settle(&mut window);
        std::fs::read(path).ok()
    };
    let (stl, glb) = (export("stock.stl").expect("written"), export("stock.glb").expect("written"));
    assert!(export("stock.step").is_none(), "not a format of solids");
    assert_eq!(&glb[..4], b"glTF");
    let mesh = read_stl_bytes("stock.stl", &stl).expect("opens");
    let six: f64 = mesh
        .triangles
        .iter()
        .map(|t| t.map(|i| mesh.points[i as usize].coords))
        .map(|[a, b, c]| a.dot(&b.cross(&c)))
        .sum();
    let drawn = volume(&window);
    assert!((six / 6.0 / drawn - 1.0).abs() < 2e-3, "{} {drawn}", six / 6.0);
    std::fs::remove_dir_all(&folder).unwrap();
    let problems = &window.state().state().problems;
    assert!(problems.iter().any(|p| p.code == Some(ErrorCode::FileFormat)), "{problems:?}");
}

/// Where both plans are shown, the dialog says which of them is written.
#[test]
fn the_dialog_of_scene_and_stock_names_the_side_where_both_are_shown() {
    let mut window = with_sample(fake::engine().0);
    window.state_mut().use_own_file_dialogs();
    let folder = tempfile::tempdir().expect("a folder");
    let asked = |window: &mut Window, item: &str, title: &str| {
        choose_in_file_menu(window, item);
        settle(window);
        window.get_by_label(title);
        let name = window.get_by_role_and_label(Role::TextInput, "File").value().expect("a proposal");
        click_enabled(window, "Cancel");
        window.run_steps(3);
        name
    };
    assert_eq!(asked(&mut window, "Export scene…", "Export scene"), "impeller532_scene.glb");
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::B);
    window.run_steps(3);
    let after = asked(&mut window, "Export scene…", "Export scene of the side After");
    assert_eq!(after, "impeller532_scene-after.glb");
    let stock = asked(&mut window, "Export stock…", "Export stock of the side After");
    assert_eq!(stock, "impeller532_stock-after.stl");
    window.state_mut().look_mut().side = Side::Before;
    window.run_steps(3);
    let before = asked(&mut window, "Export scene…", "Export scene of the side Before");
    assert_eq!(before, "impeller532_scene-before.glb");
    // It is that one, whatever is active when the name is chosen.
    let ctx = window.ctx.clone();
    let mut scene = |side: Option<Side>, name: &str| {
        let path = folder.path().join(name);
        window.state_mut().file_chosen(&ctx, Purpose::ExportScene { side }, path.clone());
        settle(&mut window);
        std::fs::read(path).expect("written")
    };
    let (active, before) = (scene(None, "a.glb"), scene(Some(Side::Before), "b.glb"));
    assert!(active == before && scene(Some(Side::After), "c.glb") != before);
}

/// Pixels of the view in the blue-green that lines of passes and programs have, and stock has not.
fn blue_green(window: &mut Window) -> usize {
    let view = window.get_by_label("3D view").rect();
    let is_it = |[r, g, b, _]: &&[u8; 4]| *g > r.saturating_add(60) && *b > r.saturating_add(60);
    pixels_in(window, view).iter().filter(is_it).count()
}

/// The stock of the plan says nothing about a program from elsewhere.
#[test]
fn the_stock_of_a_checked_program_is_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = with_stock();
    let of_plan = volume(&window);
    let mut plan = window.state().state().shown().expect("planned").plan().clone();
    plan.positions.truncate(8);
    let program = ClProgram::of_plan("impeller532", &plan);
    let path = write(folder.path(), "eight.apt", &write_apt(&program));
    window.key_press(egui::Key::S);
    check(&mut window, &path);
    assert_eq!(window.state().state().look.operation, Operation::Program);
    window.key_press(egui::Key::S);
    window.run_steps(2);
    settle(&mut window);
    let after = volume(&window);
    assert!(after > 1.001 * of_plan, "it takes less than the plan: {after} {of_plan}");
    assert!(blue_green(&mut window) < 10, "they do not hide what they leave");
    let solid = window.state().solid(Side::After).expect("a solid");
    assert!(!solid.is_coarse, "fine in the end");
    // The timeline is that of its moves.
    window.key_press(egui::Key::Home);
    window.run_steps(2);
    settle(&mut window);
    let blank = volume(&window);
    assert!(blank > after, "nothing is cut yet: {blank} {after}");
    window.state_mut().look_mut().solid_colours = SolidColours::Fault;
    window.key_press(egui::Key::End);
    window.run_steps(2);
    settle(&mut window);
    assert!((volume(&window) - after).abs() < 1e-6 * after);
    let solid = window.state().solid(Side::After).expect("a solid");
    assert!(solid.names.iter().any(|(_, name)| name == "Sound"), "{:?}", solid.names);
}

/// Their colours have another scale than those of the stock, and they would cover it.
#[test]
fn passes_do_not_hide_the_stock_that_they_leave() {
    let mut window = flank::with_plan();
    assert!(blue_green(&mut window) > 50, "the passes are shown");
    window.key_press(egui::Key::S);
    window.run_steps(2);
    settle(&mut window);
    assert!(window.query_by_label("layer 1, at the hub").is_none());
    let left = blue_green(&mut window);
    assert!(left < 10, "{left} pixels of passes");
}
