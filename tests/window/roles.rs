//! Mesh files whose nodes have no names: the dialog that assigns their roles.

use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::{Value, json};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::model::role_choices::RoleChoices;
use vanecut::geometry::rotate_z;
use vanecut::io::part_file::{FileBodies, read_bodies, read_part_with};
use vanecut::io::project_file::{PartLocation, read_project};
use vanecut::io::stl::write_stl;
use vanecut::io::{GltfScene, read_part_bytes};
use vanecut::mesh::nodes::nodes;
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{LengthUnit, MeshOptions, TriangleMesh};
use vanecut::part::{Impeller, PartDescription};

use crate::fake;
use crate::harness::{Window, click_enabled, press_at_once, settle, snapshot_view, window};

/// Writes a wheel with hub, shroud and six blades to a glTF file. `edit` changes its JSON document.
pub fn wheel(folder: &Path, edit: impl FnOnce(&mut Value)) -> PathBuf {
    let text = include_bytes!("../../assets/parts/pump6.toml");
    let part = Impeller::build(&read_part_bytes("pump6.toml", text, "toml").expect("reads")).expect("a part");
    let shape = Tessellation::new(&part, &Fineness { chord_error: 0.05, ..Fineness::default() });
    let bytes = GltfScene::of_part(&part, &shape).glb();
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let mut document: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    edit(&mut document);
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let binary = &bytes[20 + length..];
    let mut file = b"glTF".to_vec();
    for word in [2, 20 + json.len() + binary.len(), json.len(), 0x4E4F_534A] {
        file.extend((word as u32).to_le_bytes());
    }
    file.extend(json);
    file.extend(binary);
    let path = folder.join("wheel.glb");
    std::fs::write(&path, file).expect("writes");
    path
}

/// Removes all names, and adds a third body of revolution: a nut.
fn nameless(document: &mut Value) {
    for list in ["nodes", "meshes", "materials"] {
        for item in document[list].as_array_mut().expect("a list") {
            item.as_object_mut().expect("an object").remove("name");
        }
    }
    let nodes = document["nodes"].as_array_mut().expect("nodes");
    let nut = nodes.len();
    nodes.push(json!({ "mesh": nodes[0]["mesh"], "scale": [0.2, 0.2, 0.2] }));
    let root = nodes.iter_mut().find(|n| n.get("children").is_some()).expect("a root");
    root["children"].as_array_mut().expect("children").push(json!(nut));
}

/// Corners in another order would make sums that differ in the last bits, and they another plan.
#[test]
fn proposed_roles_make_the_part_that_shapes_make_alone() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wheels/kj66_cad.glb");
    let said = MeshOptions { unit: Some(LengthUnit::Millimetre), ..MeshOptions::default() };
    let FileBodies { meshes, unit } = read_bodies(&path).expect("meshes");
    let nodes = nodes(&meshes);
    let choices = RoleChoices::new(&nodes, unit, &said, true);
    assert!(choices.roles.iter().flatten().count() > 9, "hub and blades are proposed");
    let confirmed = choices.options(&nodes);
    let [alone, confirmed] =
        [said, confirmed].map(|options| read_part_with(&path, &options).expect("a part"));
    let text = |part: &PartDescription| format!("{:?} {:?} {:?}", part.hub, part.shroud, part.main);
    assert!(text(&alone) == text(&confirmed), "to the last bit");
    let (left_out, others) = confirmed
        .notes
        .iter()
        .partition::<Vec<&String>, _>(|note| note.starts_with("left out, without a role"));
    assert_eq!(left_out.len(), 1, "a sliver: {left_out:?}");
    assert_eq!(alone.notes.iter().collect::<Vec<_>>(), others);
}

/// Opens the dialog that assigns roles.
fn ask_for_roles(window: &mut Window) {
    window.get_by_label("File").click();
    window.run_steps(2);
    window.get_by_label("Assign surfaces…").click();
    window.run_steps(2);
    settle(window);
}

/// Opens the file of a wheel, and the dialog that assigns its roles.
pub fn open_with_roles(mut window: Window, path: PathBuf) -> Window {
    window.state_mut().open_path(path);
    settle(&mut window);
    ask_for_roles(&mut window);
    window
}

fn is_asked(window: &Window) -> bool {
    window.query_by_label("Assign surfaces, wheel.glb").is_some()
}

fn press(window: &mut Window, label: &str) {
    window.get_by_role_and_label(Role::Button, label).click();
    window.run_steps(3);
    settle(window);
}

fn choose(window: &mut Window, list: &str, item: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, item).click();
    window.run_steps(3);
}

fn source(window: &Window) -> Option<PartSource> {
    window.state().state().document.part.as_ref().map(|part| part.source.clone())
}

#[test]
fn nodes_without_names_are_distinguished_by_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = wheel(folder.path(), nameless);
    let (engine, _) = fake::engine();
    let mut first = window(engine.clone());
    first.state_mut().open_path(path.clone());
    settle(&mut first);
    assert!(is_asked(&first), "{:?}", first.state().state().problems);
    assert!(first.state().state().problems.is_empty(), "the dialog itself says what is wrong");
    first.get_by_label_contains("which of them is the hub is not clear");
    // The guess by shape finds hub and blades. The shroud is assigned here and highlighted.
    first.get_by_label("Left out, without a role: node 1, node 9");
    choose(&mut first, "Role of node 1", "shroud");
    press(&mut first, "node 3");
    snapshot_view(&mut first, "roles");
    // A wrong choice opens the dialog again with an error.
    choose(&mut first, "Role of node 0", "ignore");
    choose(&mut first, "Role of node 9", "hub");
    press(&mut first, "Open the part");
    assert!(is_asked(&first) && source(&first).is_none(), "still asked");
    assert!(first.query_by_label_contains("which of them is the hub").is_none(), "another fault now");
    choose(&mut first, "Role of node 0", "hub");
    choose(&mut first, "Role of node 9", "ignore");
    assert!(first.query_by_label_contains("Left out").is_none(), "each has a role");
    press(&mut first, "Open the part");
    assert!(!is_asked(&first));
    let part = first.state().state().document.part.clone().expect("a part");
    assert_eq!(part.impeller.blade_count, 6);
    let Some(PartSource::Mesh(_, said)) = source(&first) else { panic!("the choices stay with the part") };
    assert!(first.state().state().document.is_unsaved(), "choices are something to lose");

    let project = folder.path().join("p.vanecut");
    let ctx = first.ctx.clone();
    first.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut first);
    let stored = read_project(&project).expect("reads").part;
    assert_eq!(stored, PartLocation::Mesh { file: path, choices: said.clone() });
    let mut second = window(engine);
    second.state_mut().open_path(project);
    settle(&mut second);
    assert!(!is_asked(&second) && second.state().state().problems.is_empty());
    let again = second.state().state().document.part.clone().expect("a part");
    assert_eq!((again.hash, again.source), (part.hash, part.source), "as it was saved");
    assert!(!second.state().state().document.is_unsaved());
}

#[test]
fn the_keyboard_is_enough_to_tell_nodes_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = wheel(folder.path(), nameless);
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.state_mut().open_path(path);
    settle(&mut window);
    // The first node is the hub, the second the shroud.
    use egui::Key;
    press_at_once(&mut window, [Key::ArrowDown, Key::H, Key::ArrowDown, Key::S]);
    window.key_press(Key::Enter);
    window.run_steps(2);
    settle(&mut window);
    assert!(!is_asked(&window));
    window.get_by_label_contains(
        "Left out, without a role: node 9; where one belongs to the wheel give the role",
    );
    let Some(PartSource::Mesh(_, said)) = source(&window) else { panic!("open") };
    let role = |node: &str| said.roles.iter().find(|(name, _)| name == node).map(|(_, role)| *role);
    assert_eq!(role("node 0"), Some(vanecut::mesh::Role::Hub));
    assert_eq!(role("node 1"), Some(vanecut::mesh::Role::Shroud));
    assert_eq!(role("node 7"), Some(vanecut::mesh::Role::Blade), "guessed by its shape");
    // What is left out is a note, and no problem.
    let damaged = folder.path().join("damaged.toml");
    std::fs::write(&damaged, "[").expect("written");
    window.state_mut().open_path(damaged);
    settle(&mut window);
    assert_eq!(window.state().state().problems.len(), 2);
    window.get_by_label("1 problem: see the message");
}

#[test]
fn roles_of_an_open_part_can_be_changed_and_its_setup_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = wheel(folder.path(), |_| ());
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.state_mut().open_path(path.clone());
    settle(&mut window);
    assert_eq!(source(&window), Some(PartSource::File(path.clone())), "names tell everything");
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.0);
    window.run_steps(2);
    settle(&mut window);
    ask_for_roles(&mut window);
    assert!(is_asked(&window));
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    settle(&mut window);
    assert!(!is_asked(&window) && source(&window) == Some(PartSource::File(path.clone())));

    ask_for_roles(&mut window);
    choose(&mut window, "Role of shroud", "ignore");
    choose(&mut window, "Sense of rotation", "clockwise");
    press(&mut window, "Open the part");
    let part = window.state().state().document.part.clone().expect("a part");
    let PartSource::Mesh(_, said) = part.source else { panic!("with choices") };
    assert_eq!(said.roles, [("shroud".to_owned(), vanecut::mesh::Role::Ignored)], "only what differs");
    assert_eq!(part.impeller.rotation(), vanecut::part::Rotation::Clockwise);
    assert_eq!(window.state().state().document.edited.setup.plunge.step, Some(6.0), "the setup stays");
}

/// Saves the project in `folder`, and opens it in another window.
fn reopened(window: &mut Window, folder: &Path) -> Window {
    let project = folder.join("p.vanecut");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(window);
    let mut second = crate::harness::window(fake::engine().0);
    second.state_mut().open_path(project);
    settle(&mut second);
    second
}

#[test]
fn what_an_stl_file_leaves_open_is_given_in_the_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = include_bytes!("../../assets/parts/pump6.toml");
    let part = Impeller::build(&read_part_bytes("pump6.toml", text, "toml").expect("reads")).expect("a part");
    let shape = Tessellation::new(&part, &Fineness { chord_error: 0.02, ..Fineness::default() });
    let (mut wheel, blade) = (shape.hub.mesh(), shape.main.mesh());
    for k in 0..part.blade_count {
        let points = blade.points.iter().map(|p| rotate_z(p, part.pitch() * k as f64)).collect();
        wheel.append(&TriangleMesh { points, triangles: blade.triangles.clone() });
    }
    let inches: Vec<_> = wheel.points.iter().map(|p| p / 25.4).collect();
    let path = folder.path().join("wheel.stl");
    std::fs::write(&path, write_stl(&inches, &wheel.triangles, "pump6")).expect("writes");
    let mut window = window(fake::engine().0);
    window.state_mut().open_path(path.clone());
    settle(&mut window);
    let diameter = |window: &Window| {
        let part = window.state().state().document.part.clone().expect("a part");
        2.0 * part.impeller.rim_radius()
    };
    let across = diameter(&window);
    window.get_by_label_contains("mm are assumed; give the unit if they are not");
    window.get_by_label_contains("give it in File, Assign surfaces…");

    ask_for_roles(&mut window);
    window.get_by_label("Assign surfaces, wheel.stl");
    // Nothing is left to draw.
    let lists = window.query_all_by_role(Role::ComboBox);
    let labels = lists.filter_map(|list| list.accesskit_node().label());
    let bodies: Vec<String> = labels.filter(|label| label.starts_with("Role of ")).collect();
    let [body] = &bodies[..] else { panic!("one body: {bodies:?}") };
    for role in ["ignore", "automatic"] {
        choose(&mut window, body, role);
        window.state_mut().draw_waiting_pictures();
        window.render().expect("the window can be drawn");
    }
    choose(&mut window, "Unit of the file", "in");
    choose(&mut window, "Sense of rotation", "clockwise");
    press(&mut window, "Open the part");
    assert!(window.query_by_label("Assign surfaces, wheel.stl").is_none(), "it opened");
    let inches = diameter(&window);
    assert!((inches / across - 25.4).abs() < 0.01, "{across} mm, then {inches} mm");
    let document = &window.state().state().document;
    let part = document.part.as_ref().expect("a part");
    let wanted = vanecut::setup::Setup::for_part(&part.impeller);
    assert_eq!(document.edited.setup.allowances, wanted.allowances, "defaults follow the size");
    let (clearances, plunge) = (document.edited.setup.clearances, &document.edited.setup.plunge);
    assert_eq!((clearances, plunge.wall_scallop), (wanted.clearances, wanted.plunge.wall_scallop));
    assert_eq!(document.edited.setup.flank, wanted.flank);
    assert!(window.query_by_label_contains("mm are assumed").is_none(), "nothing is assumed any more");
    let mut second = reopened(&mut window, folder.path());
    assert!((diameter(&second) - inches).abs() < 1e-9, "the project keeps the choices");
    let part = second.state().state().document.part.clone().expect("a part");
    assert_eq!(part.impeller.rotation(), vanecut::part::Rotation::Clockwise);
    ask_for_roles(&mut second);
    let unit = second.get_by_role_and_label(Role::ComboBox, "Unit of the file").value();
    assert_eq!(unit.as_deref(), Some("in"));
}

/// The roles that the dialog shows.
fn shown_roles(window: &Window) -> Vec<String> {
    let is_of_body = |label: Option<String>| label.is_some_and(|label| label.starts_with("Role of "));
    let lists = window.query_all_by_role(Role::ComboBox);
    lists.filter(|list| is_of_body(list.accesskit_node().label())).filter_map(|list| list.value()).collect()
}

#[test]
fn what_a_step_file_leaves_open_is_given_in_the_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/step/plane_blades.step");
    let mut window = window(fake::engine().0);
    window.state_mut().open_path(PathBuf::from(file));
    settle(&mut window);
    let part = |window: &Window| window.state().state().document.part.clone().expect("a part").impeller;
    let before = part(&window);
    let other = before.rotation().reversed();

    ask_for_roles(&mut window);
    window.get_by_label("Assign surfaces, plane_blades.step");
    // The unit is that of the file, and the bodies that were found by their shapes stay so.
    assert!(window.query_by_role_and_label(Role::ComboBox, "Unit of the file").is_none());
    window.get_by_label("as in the file");
    let roles = shown_roles(&window);
    assert!(!roles.is_empty());
    assert!(roles.iter().all(|role| role == "automatic"), "{roles:?}");
    choose(&mut window, "Sense of rotation", &other.to_string());
    press(&mut window, "Open the part");
    let turned = part(&window);
    assert_eq!((turned.rotation(), turned.blade_count), (other, before.blade_count));
    let Some(PartSource::Mesh(_, said)) = source(&window) else { panic!("with choices") };
    assert_eq!((said.roles.len(), said.unit), (0, None), "only what was chosen");
    let second = reopened(&mut window, folder.path());
    assert_eq!(part(&second).rotation(), other, "the project keeps the choice");
}

/// Shapes decide again when only something else is chosen, and a role that is chosen counts.
#[test]
fn roles_of_names_that_make_no_wheel_are_not_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/step/pump_bodies.step");
    let mut pieces = std::fs::read_to_string(file).expect("a file");
    let body = "MANIFOLD_SOLID_BREP('";
    let bodies = pieces.matches(body).count();
    // The hub is called a blade, too.
    pieces = pieces.split(body).enumerate().fold(String::new(), |text, (k, piece)| match k {
        0 => piece.to_owned(),
        _ => format!("{text}{body}blade {k}{piece}"),
    });
    let path = folder.path().join("misnamed.step");
    std::fs::write(&path, pieces).expect("writes");
    let mut window = window(fake::engine().0);
    window.state_mut().open_path(path);
    settle(&mut window);
    window.get_by_label_contains("make no wheel");
    let part = |window: &Window| window.state().state().document.part.clone().expect("a part").impeller;
    let before = part(&window);
    let other = before.rotation().reversed();

    ask_for_roles(&mut window);
    assert_eq!(shown_roles(&window), vec!["automatic"; bodies]);
    choose(&mut window, "Sense of rotation", &other.to_string());
    press(&mut window, "Open the part");
    assert_eq!((part(&window).rotation(), part(&window).blade_count), (other, before.blade_count));
    let Some(PartSource::Mesh(_, said)) = source(&window) else { panic!("with choices") };
    assert_eq!(said.roles, [], "only what was chosen");

    let mut second = reopened(&mut window, folder.path());
    ask_for_roles(&mut second);
    assert_eq!(shown_roles(&second), vec!["automatic"; bodies]);
    choose(&mut second, "Role of blade 1", "hub");
    press(&mut second, "Open the part");
    assert_eq!(part(&second).blade_count, before.blade_count);
    let Some(PartSource::Mesh(_, said)) = source(&second) else { panic!("with choices") };
    assert_eq!(said.roles, [("blade 1".to_owned(), vanecut::mesh::Role::Hub)]);
    assert!(!part(&second).roles_by_shape, "the names of the others are right");
    ask_for_roles(&mut second);
    assert_eq!(shown_roles(&second)[..2], ["hub", "blade"]);
}

#[test]
fn the_number_of_blades_that_a_file_lacks_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = wheel(folder.path(), |document| {
        let names: Vec<Value> =
            document["nodes"].as_array().expect("nodes").iter().map(|n| n["name"].clone()).collect();
        let is_kept = |child: &Value| {
            let name = child.as_u64().and_then(|k| names[k as usize].as_str()).expect("a name");
            !name.contains("blade") || name.ends_with('1')
        };
        let nodes = document["nodes"].as_array_mut().expect("nodes");
        let root = nodes.iter_mut().find(|n| n.get("children").is_some()).expect("a root");
        root["children"].as_array_mut().expect("children").retain(is_kept);
    });
    let mut window = window(fake::engine().0);
    window.state_mut().open_path(path);
    settle(&mut window);
    assert!(is_asked(&window), "{:?}", window.state().state().problems);
    window.get_by_label_contains("There is one main blade");
    window.get_by_label("Fix: give the number of main blades");
}
