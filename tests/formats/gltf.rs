//! Written glTF files: their structure and shapes.

mod file;
mod plan;

use std::collections::HashMap;
use std::path::Path;

use file::{GltfFile, Matrix};
use vanecut::geometry::rotate_z;
use vanecut::io::gltf::GltfScene;
use vanecut::io::part_file::read_part;
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::part::Impeller;

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    let description = read_part(&path).expect("sample parts are readable");
    Impeller::build(&description).expect("sample parts are impellers")
}

fn written(part: &Impeller, chord_error: f64) -> (Tessellation, GltfFile) {
    let shape = Tessellation::new(part, &Fineness { chord_error, ..Fineness::default() });
    let file = GltfFile::of_glb(&GltfScene::of_part(part, &shape).glb());
    (shape, file)
}

#[test]
fn every_part_of_a_part_is_a_named_node() {
    for (name, blades, splitters) in [("impeller532.toml", 17, 0), ("impeller9x9.toml", 9, 9)] {
        let part = sample(name);
        let (_, file) = written(&part, 0.1);
        file.check();
        let mut names = vec!["hub".to_owned(), "shroud".to_owned()];
        names.extend((1..=blades).map(|k| format!("blade_{k}")));
        names.extend((1..=splitters).map(|k| format!("splitter_{k}")));
        let found: Vec<String> = file.children_of_root().map(|node| file.name(node)).collect();
        assert_eq!(found, names);
        let facts = &file.root()["extras"]["vanecut"];
        assert_eq!(facts["rotation_axis"], "z");
        assert_eq!(facts["rotation"], part.rotation().name());
        assert_eq!(facts["blades"], blades);
        assert_eq!(facts["splitters"], splitters);
        assert_eq!(facts["chord_error"], 0.1);
    }
}

#[test]
fn the_blades_are_one_mesh_in_several_places() {
    let part = sample("impeller9x9.toml");
    let (shape, file) = written(&part, 0.1);
    let mesh_of = |name: &str| file.node(name)["mesh"].as_u64().expect("a mesh");
    for k in 0..9 {
        assert_eq!(mesh_of(&format!("blade_{}", k + 1)), mesh_of("blade_1"));
        for (kind, solid) in [("blade", &shape.main), ("splitter", &shape.splitters[0])] {
            let (points, _) = file.placed(&format!("{kind}_{}", k + 1));
            // Exactly the corners of the solid, rotated by the pitch, Y up, in metres.
            let expected: Vec<[f64; 3]> = solid
                .points
                .iter()
                .map(|p| rotate_z(p, f64::from(k) * part.pitch()))
                .map(|p| [p.x * 1e-3, p.z * 1e-3, -p.y * 1e-3])
                .collect();
            let near = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-7);
            assert!(points.iter().all(|p| expected.iter().any(|q| near(p, q))), "{kind} {k}");
            assert!(expected.iter().all(|p| points.iter().any(|q| near(p, q))), "{kind} {k}");
        }
    }
}

#[test]
fn hub_and_blades_are_closed_in_single_precision_too() {
    for name in ["impeller532.toml", "impeller9x9.toml", "pump6.toml"] {
        let part = sample(name);
        let (shape, file) = written(&part, 0.02);
        let mut bodies = vec![("hub", &shape.hub), ("blade_2", &shape.main)];
        bodies.extend(shape.splitters.first().map(|s| ("splitter_1", s)));
        for (node, solid) in bodies {
            let (points, triangles) = file.local(node);
            let mut edges: HashMap<(&[u32; 3], &[u32; 3]), i32> = HashMap::new();
            let mut sixfold = 0.0;
            let bits: Vec<[u32; 3]> = points.iter().map(|p| p.map(f32::to_bits)).collect();
            for t in &triangles {
                let [a, b, c] = t.map(|k| points[k as usize].map(f64::from));
                sixfold += a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]);
                for (p, q) in [(0, 1), (1, 2), (2, 0)] {
                    let (p, q) = (&bits[t[p] as usize], &bits[t[q] as usize]);
                    *edges.entry((p, q)).or_default() += 1;
                }
            }
            for ((p, q), count) in &edges {
                assert_eq!(
                    (*count, edges.get(&(*q, *p))),
                    (1, Some(&1)),
                    "{name} {node}: an edge of one triangle"
                );
            }
            let expected = solid.volume_sixfold() * 1e-9;
            assert!((sixfold / expected - 1.0).abs() < 1e-4, "{name} {node}: volume {sixfold} of {expected}");
        }
    }
}

#[test]
fn the_root_turns_the_axis_upright() {
    let part = sample("pump6.toml");
    let (_, file) = written(&part, 0.1);
    let root: Matrix = file.root_matrix();
    let turned = |p: [f64; 3]| root.apply(p);
    assert_eq!(turned([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0], "the axis of the wheel is the file's Y");
    assert_eq!(turned([1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
    let (hub, _) = file.placed("hub");
    let widest = hub.iter().map(|p| p[0].hypot(p[2])).fold(0.0, f64::max);
    assert!((widest - 1e-3 * part.rim_radius()).abs() < 1e-6, "radius {widest} m");
}

#[test]
fn the_scene_that_is_shipped_is_that_of_the_part() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller9x9.glb");
    let shipped = GltfFile::of_glb(&std::fs::read(path).expect("the file is there"));
    shipped.check();
    let (_, file) = written(&sample("impeller9x9.toml"), 0.05);
    assert_eq!(shipped.root()["extras"], file.root()["extras"], "the same facts");
    for node in ["hub", "shroud", "blade_1", "splitter_1"] {
        let ((a, s), (b, t)) = (shipped.local(node), file.local(node));
        assert_eq!((a.len(), s), (b.len(), t), "{node}: the same triangles");
        let near = |p: &[f32; 3], q: &[f32; 3]| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-6);
        assert!(a.iter().zip(&b).all(|(p, q)| near(p, q)), "{node}: the same corners");
    }
}

#[test]
fn as_text_the_triangles_lie_in_a_file_beside_it() {
    let part = sample("pump6.toml");
    let (shape, glb) = written(&part, 0.2);
    let (text, binary) = GltfScene::of_part(&part, &shape).gltf("a%20b.bin");
    let mut json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["buffers"][0]["uri"], "a%20b.bin");
    assert_eq!(binary, glb.binary);
    json["buffers"][0].as_object_mut().expect("a buffer").remove("uri");
    assert_eq!(json, glb.json, "else it is the same document");
}
