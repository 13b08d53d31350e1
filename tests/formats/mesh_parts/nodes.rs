//! The list of mesh nodes that is presented to the user.

use std::path::Path;

use vanecut::io::gltf::read_meshes;
use vanecut::mesh::axis::Axis;
use vanecut::mesh::nodes::{guess_roles, nodes};
use vanecut::mesh::{NamedMesh, Role};

use super::{sample, separate};

#[test]
fn shapes_tell_hub_blades_and_splitters_where_names_do_not() {
    let part = sample("impeller9x9.toml");
    let mut meshes = separate(&part);
    let wanted: Vec<Option<Role>> = meshes
        .iter()
        .map(|m| match &m.name[..3] {
            "Hub" => Some(Role::Hub),
            "Bla" => Some(Role::Blade),
            "Spl" => Some(Role::Splitter),
            _ => None,
        })
        .collect();
    let named = nodes(&meshes);
    assert_eq!(guess_roles(&named)[1], Some(Role::Shroud), "names come first");
    assert!(named.iter().all(|node| node.key == node.name), "each has a name of its own");
    meshes.iter_mut().for_each(|m| m.name = "Solid".into());
    let nodes = nodes(&meshes);
    assert_eq!(guess_roles(&nodes), wanted);
    assert_eq!(nodes[3].key, "#3", "one name for all: by number");
    assert_eq!(nodes[0].revolution_axis(), Axis::Z);
    assert!(
        nodes[2].is_like(&nodes[4]) && !nodes[2].is_like(&nodes[3]),
        "blades are alike, splitters others"
    );
    let across = (nodes[0].high - nodes[0].low).amax();
    assert!((across - 2.0 * part.rim_radius()).abs() < 0.1, "{across}");
}

/// A file may have one blade and its splitter, for a pitch. Beside a blade alone anything else may lie.
#[test]
fn one_body_beside_the_only_blade_is_its_splitter_unless_it_is_longer() {
    let mut meshes = separate(&sample("impeller9x9.toml"));
    meshes.truncate(4);
    meshes.swap_remove(1);
    meshes.iter_mut().for_each(|m| m.name = "Solid".into());
    let roles = |meshes: &[NamedMesh]| guess_roles(&nodes(meshes));
    let (hub, blade, splitter) = (Some(Role::Hub), Some(Role::Blade), Some(Role::Splitter));
    assert_eq!(roles(&meshes), [hub, splitter, blade]);
    let mut bracket = meshes.clone();
    bracket[1].mesh.points.iter_mut().for_each(|p| p.z += 50.0);
    assert_eq!(roles(&bracket), [hub, None, blade]);
    meshes.push(NamedMesh { node: 9, ..bracket.swap_remove(1) });
    assert_eq!(roles(&meshes), [hub, None, blade, None], "which of them is not clear");
}

#[test]
fn one_node_alone_gets_no_role() {
    let part = sample("pump6.toml");
    let mut whole = separate(&part).swap_remove(0);
    for mesh in separate(&part).iter().skip(1) {
        whole.mesh.append(&mesh.mesh);
    }
    for name in ["Body", "Hub", "bladed disc"] {
        whole.name = name.into();
        assert_eq!(guess_roles(&nodes(&[whole.clone()])), [None], "{name}");
    }
}

/// Nine blades that a CAD system meshed one by one, with up to a third more triangles, beside hub and a
/// sliver.
#[test]
fn blades_that_were_meshed_one_by_one_are_alike() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/wheels/kj66_cad.glb");
    let nodes = nodes(&read_meshes(Path::new(file)).expect("reads"));
    let roles = guess_roles(&nodes);
    let count = |role| roles.iter().filter(|known| **known == role).count();
    assert_eq!((count(Some(Role::Hub)), count(Some(Role::Blade))), (1, 9), "{roles:?}");
    let least = nodes.iter().min_by_key(|node| node.triangles).expect("the sliver");
    assert_eq!(roles[least.node], None);
}
