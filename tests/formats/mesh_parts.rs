//! Parts that are converted to triangles and back stay the same.

mod body;
mod coarse;
mod faults;
mod nodes;
mod roles;

use std::path::Path;

use body::Body;
use nalgebra::Rotation3;
use vanecut::error::ErrorCode;
use vanecut::geometry::{Point, Vector, rotate_z};
use vanecut::io::gltf::GltfScene;
use vanecut::io::{read_part, read_part_bytes};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{LengthUnit, MeshOptions, NamedMesh, Role, TriangleMesh, describe};
use vanecut::part::{Blade, BladeSide, Impeller, Rotation, SideProbe};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

/// Triangles coarse enough for tests that read many wheels.
const COARSE: Fineness = Fineness { chord_error: 0.03, max_triangles: 1_000_000 };

fn named(name: String, node: usize, mesh: TriangleMesh) -> NamedMesh {
    NamedMesh { name, other_names: Vec::new(), node, instance: 0, mesh }
}

/// Hub, shroud and all blades of a part, each as a separate mesh, mm.
fn separate(part: &Impeller) -> Vec<NamedMesh> {
    let t = Tessellation::new(part, &COARSE);
    let mut meshes = vec![named("Hub".into(), 0, t.hub.mesh()), named("Shroud".into(), 1, t.shroud.mesh())];
    for k in 0..part.blade_count {
        let angle = part.pitch() * k as f64;
        let turned = |mesh: TriangleMesh| TriangleMesh {
            points: mesh.points.iter().map(|p| rotate_z(p, angle)).collect(),
            triangles: mesh.triangles,
        };
        meshes.push(named(format!("Blade_{k}"), meshes.len(), turned(t.main.mesh())));
        for s in &t.splitters {
            meshes.push(named(format!("Splitter_{k}"), meshes.len(), turned(s.mesh())));
        }
    }
    meshes
}

/// Options needed for triangles without metadata: the sample parts turn against the wrap of their blades.
fn turning(part: &Impeller) -> MeshOptions {
    MeshOptions { rotation: Some(part.rotation()), ..MeshOptions::default() }
}

fn back(meshes: Vec<NamedMesh>, options: &MeshOptions) -> Impeller {
    let description = describe("back", meshes, LengthUnit::Millimetre, options).expect("a part");
    Impeller::build(&description).expect("an impeller")
}

/// The part as a `.glb` file of `GltfScene`.
fn glb(part: &Impeller, fineness: &Fineness) -> Vec<u8> {
    GltfScene::of_part(part, &Tessellation::new(part, fineness)).glb()
}

/// The part written as `.glb` and read back.
fn through_glb(part: &Impeller) -> Impeller {
    let bytes = glb(part, &Fineness::default());
    Impeller::build(&read_part_bytes("back.glb", &bytes, "glb").expect("readable")).expect("an impeller")
}

/// Largest distance of points of `a` from the blade `b`, mm; half of the points are on the first tenth, at
/// the nose, where the sides of the two blades may begin at different lines.
fn off(a: &BladeSide, b: &Blade) -> f64 {
    let probes = [&b.suction, &b.pressure].map(|side| SideProbe::new(side, 0.0, 1.0));
    let mut worst: f64 = 0.0;
    // The side of `b` that is likely the nearer one.
    let mut near = 0;
    for i in 0..=300 {
        let x = f64::from(i) / 300.0;
        let u = if x < 0.5 { 0.2 * x } else { 0.1 + 1.8 * (x - 0.5) };
        for j in 0..=20 {
            let p = a.point(u, f64::from(j) / 20.0);
            let distance = |side: usize| probes[side].nearest_to_point(&p).distance;
            let to_near = distance(near);
            // Whatever the other one says, this point is not the worst.
            if to_near <= worst {
                continue;
            }
            let to_other = distance(1 - near);
            worst = worst.max(to_near.min(to_other));
            near = if to_other < to_near { 1 - near } else { near };
        }
    }
    worst
}

/// Checks that both parts have the same surfaces within `tolerance` mm, and the same blades.
fn same(one: &Impeller, other: &Impeller, tolerance: f64) {
    assert_eq!(one.blade_count, other.blade_count);
    assert_eq!(one.splitters.len(), other.splitters.len());
    assert!(other.notes.is_empty(), "{:?}", other.notes);
    for (name, a, b) in [("hub", &one.hub, &other.hub), ("shroud", &one.shroud, &other.shroud)] {
        for i in 0..=500 {
            let p = a.point(f64::from(i) / 500.0);
            let d = b.curve().project(p).1.abs();
            assert!(d < tolerance, "{}: {name} {d} mm off at {p:?}", one.name);
        }
    }
    let blades = std::iter::once((&one.main, &other.main)).chain(one.splitters.iter().zip(&other.splitters));
    for (a, b) in blades {
        let middle = |side: &BladeSide| side.point(0.5, 0.5);
        assert!((middle(&a.suction) - middle(&b.suction)).norm() < 0.05 * one.rim_radius(), "{}", one.name);
        for (name, side, blade) in [
            ("suction side", &a.suction, b),
            ("pressure side", &a.pressure, b),
            ("new suction side", &b.suction, a),
            ("new pressure side", &b.pressure, a),
        ] {
            let d = off(side, blade);
            println!("{} {name}: {d:.4} mm, ruled {}", one.name, side.is_ruled());
            assert!(d < tolerance, "{}: {name} {d} mm off", one.name);
        }
    }
}

/// Checks that the sides of every blade begin at the same line of the nose in both parts.
fn same_leading_edges(one: &Impeller, other: &Impeller) {
    for (a, b) in std::iter::once((&one.main, &other.main)).chain(one.splitters.iter().zip(&other.splitters))
    {
        for v in [0.0, 0.5, 1.0] {
            let apart = (a.suction.point(0.0, v) - b.suction.point(0.0, v)).norm();
            assert!(apart < 5e-4, "{}: leading edges {apart} mm apart at {v}", one.name);
        }
    }
}

#[test]
fn own_files_give_the_part_back() {
    for name in SAMPLES {
        let part = sample(name);
        let again = through_glb(&part);
        same(&part, &again, 0.02);
        same_leading_edges(&part, &again);
        assert!((part.pitch() - again.pitch()).abs() < 1e-12, "{name}: the suction side is the same one");
        // All three are ruled, and are recognised as ruled after reading.
        assert!(again.main.suction.is_ruled() && again.main.pressure.is_ruled(), "{name}");
    }
}

/// A real compressor.
fn compressor() -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cc_autoblade/cc_autoblade.geomTurbo");
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

#[test]
fn a_compressor_from_elsewhere_comes_back() {
    let part = compressor();
    let again = through_glb(&part);
    assert!((part.pitch() - again.pitch()).abs() < 1e-12, "with its sides");
    same(&part, &again, 0.02);
    same_leading_edges(&part, &again);
}

#[test]
fn bare_triangles_tell_the_sides_by_the_blades_wrap() {
    let part = compressor();
    let again = back(separate(&part), &MeshOptions::default());
    assert_eq!(again.rotation(), part.rotation(), "its file names the sides as the wrap does");
    same(&part, &again, 0.02);
    for name in SAMPLES {
        let part = sample(name);
        let angle = |p: Point| p.y.atan2(p.x);
        let side = &part.main.suction;
        let wrap = angle(side.point(1.0, 0.5)) - angle(side.point(0.1, 0.5));
        let meshes = separate(&part);
        let again = back(meshes.clone(), &MeshOptions::default());
        let inlet_up = part.out_of_inlet().z > 0.0;
        assert_eq!(again.rotation(), Rotation::about_z(-wrap, inlet_up), "{name}: against the wrap");
        assert!(again.notes.is_empty(), "{name}: {:?}", again.notes);
        for rotation in Rotation::ALL.into_iter().filter(|other| *other != again.rotation()) {
            let options = MeshOptions { rotation: Some(rotation), ..MeshOptions::default() };
            assert_eq!(back(meshes.clone(), &options).rotation(), rotation, "{name}: as given");
        }
    }
}

#[test]
fn blades_that_hardly_wrap_are_asked_about() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml"))
        .expect("readable");
    let straight: String = text
        .lines()
        .map(|line| {
            if line.starts_with("angle") {
                "angle = [[0, 0.5], [1, 0.5]]\n".into()
            } else {
                format!("{line}\n")
            }
        })
        .collect();
    let part =
        Impeller::build(&read_part_bytes("radial.toml", straight.as_bytes(), "toml").expect("readable"))
            .expect("an impeller");
    let again = back(separate(&part), &MeshOptions::default());
    let note = again.notes.first().expect("a word about it");
    assert!(note.contains("--rotation") && !note.contains('\n'), "{note}");
    assert!(back(separate(&part), &turning(&part)).notes.is_empty(), "no note if the rotation is given");
}

const SAMPLES: [&str; 3] = ["impeller532.toml", "impeller9x9.toml", "pump6.toml"];

#[test]
fn a_wheel_in_one_mesh_is_taken_apart() {
    let part = sample("impeller532.toml");
    let joined = separate(&part).into_iter().fold(TriangleMesh::default(), |mut all, m| {
        all.append(&m.mesh);
        all
    });
    same(&part, &back(vec![named("Body".into(), 0, joined)], &turning(&part)), 0.02);
    let one = Body::default().built_on(&part).whole();
    same(&part, &back(vec![named("Solid1".into(), 0, one)], &turning(&part)), 0.02);
}

#[test]
fn fillets_belong_to_neither_hub_nor_blade() {
    let part = sample("impeller532.toml");
    let body = Body { fillet: 5.0, ..Body::default() }.built_on(&part);
    same(&part, &back(vec![named("Solid1".into(), 0, body.whole())], &turning(&part)), 0.05);
    // Fillets as part of the blades or of the hub.
    for with_blades in [true, false] {
        let (hub, blades) = body.separate(with_blades);
        let mut meshes = vec![named("hub".into(), 0, hub)];
        meshes.extend(blades.into_iter().map(|mesh| named("blades".into(), 1, mesh)));
        same(&part, &back(meshes, &turning(&part)), 0.05);
    }
}

#[test]
fn a_collar_with_a_rounded_edge_belongs_to_the_hub() {
    for (name, radius) in [("impeller532.toml", 1.0), ("impeller532.toml", 3.0)] {
        let part = sample(name);
        let shape = Body::default();
        let mut body = shape.built_on(&part);
        body.add_collar(&part, &shape, radius);
        println!("{name}, edge of {radius} mm");
        same(&part, &back(vec![named("Solid1".into(), 0, body.whole())], &turning(&part)), 0.02);
    }
}

#[test]
fn a_covered_wheel_in_one_mesh_is_taken_apart() {
    let part = sample("impeller532.toml");
    let body = Body { cover: true, fillet: 2.0, ..Body::default() }.built_on(&part);
    same(&part, &back(vec![named("Solid1".into(), 0, body.whole())], &turning(&part)), 0.05);
}

#[test]
fn a_body_whose_blades_hang_together_is_refused_with_what_to_separate() {
    let part = sample("impeller532.toml");
    let mut body = Body::default().built_on(&part);
    body.join_blades(&part);
    let meshes = vec![named("Solid1".into(), 0, body.whole())];
    let error =
        describe("back", meshes, LengthUnit::Millimetre, &MeshOptions::default()).map(|_| ()).unwrap_err();
    assert_eq!(error.code, ErrorCode::MeshInOne, "{error}");
}

/// The reason names what is missing, or too much.
#[test]
fn blades_alone_and_two_wheels_are_refused_with_what_they_are() {
    let part = sample("pump6.toml");
    let mut blades = TriangleMesh::default();
    separate(&part).iter().filter(|m| m.name.starts_with("Blade")).for_each(|m| blades.append(&m.mesh));
    let one = whole(&part, usize::MAX, |_, p| *p);
    let mut two = one.clone();
    let aside = Vector::new(1000.0, 0.0, 0.0);
    two.append(&TriangleMesh { points: one.points.iter().map(|p| p + aside).collect(), ..one });
    for (mesh, why) in [(blades, "no hub"), (two, "a second wheel 1000.0 mm beside the axis")] {
        let meshes = vec![named("Solid1".into(), 0, mesh)];
        let error = describe("back", meshes, LengthUnit::Millimetre, &MeshOptions::default()).unwrap_err();
        assert_eq!(error.code, ErrorCode::MeshInOne, "{error}");
        assert!(error.message.contains(why), "{error}");
    }
}

#[test]
fn one_blade_is_enough_with_the_number_of_blades_and_needs_no_shroud() {
    let part = sample("impeller9x9.toml");
    let mut meshes = separate(&part);
    meshes.truncate(4);
    meshes.remove(1);
    let error =
        describe("back", meshes.clone(), LengthUnit::Millimetre, &MeshOptions::default()).unwrap_err();
    assert_eq!(error.code, ErrorCode::BladeCount, "{error}");
    same(&part, &back(meshes, &MeshOptions { blades: Some(9), ..turning(&part) }), 0.02);
}

#[test]
fn the_sides_of_a_blade_may_be_meshes_of_their_own() {
    let part = sample("pump6.toml");
    let main = Tessellation::new(&part, &Fineness::default()).main;
    let mut meshes = separate(&part);
    meshes.retain(|m| !m.name.starts_with("Blade"));
    for k in 0..part.blade_count {
        for (n, face) in main.faces.iter().enumerate() {
            let at = |point: u32| rotate_z(&main.points[point as usize], part.pitch() * k as f64);
            let mesh = TriangleMesh {
                points: face.corners.iter().map(|corner| at(corner.point)).collect(),
                triangles: face.triangles.clone(),
            };
            meshes.push(named(format!("Blade_{k}_face_{n}"), meshes.len(), mesh));
        }
    }
    same(&part, &back(meshes, &turning(&part)), 0.02);
}

#[test]
fn splitters_without_a_name_are_recognised_by_their_length() {
    let part = sample("impeller9x9.toml");
    let mut meshes = separate(&part);
    meshes.iter_mut().filter(|m| m.name.starts_with("Splitter")).for_each(|m| m.name = "Vane".into());
    same(&part, &back(meshes, &turning(&part)), 0.02);
}

#[test]
fn roles_unit_and_axis_may_be_given_and_the_axis_is_found() {
    let part = sample("pump6.toml");
    let metres = |turn: &dyn Fn(Point) -> Point| {
        let mut meshes = separate(&part);
        for m in &mut meshes {
            m.mesh.points.iter_mut().for_each(|p| *p = turn(*p / 1000.0));
        }
        meshes
    };
    let build = |meshes, options: &MeshOptions| {
        Impeller::build(&describe("back", meshes, LengthUnit::Metre, options).expect("a part"))
            .expect("an impeller")
    };
    // Rotation axis along x, and along an oblique axis off the origin.
    same(&part, &build(metres(&|p| Point::new(p.z, p.x, p.y)), &turning(&part)), 0.02);
    let odd = Rotation3::from_euler_angles(0.3, 0.8, -0.4);
    let tilted = build(metres(&|p| odd * p + Vector::new(0.1, 0.2, -0.05)), &MeshOptions::default());
    assert_eq!(tilted.blade_count, 6);
    assert!((tilted.rim_radius() - part.rim_radius()).abs() < 0.02, "{}", tilted.rim_radius());
    // Millimetres in a file of metres.
    let huge = describe("back", separate(&part), LengthUnit::Metre, &MeshOptions::default()).unwrap_err();
    assert_eq!(huge.code, ErrorCode::MeshUnit, "{huge}");
    assert!(huge.help.contains("--unit mm"), "{huge}");
    let options = MeshOptions { unit: Some(LengthUnit::Millimetre), ..turning(&part) };
    same(&part, &build(separate(&part), &options), 0.02);
    // Names that do not indicate roles.
    let mut meshes = separate(&part);
    for (k, m) in meshes.iter_mut().enumerate() {
        m.name = format!("Body{k}");
    }
    let mut roles = vec![("body0".to_owned(), Role::Hub), ("Body1".to_owned(), Role::Shroud)];
    let wrong = MeshOptions { roles: roles.clone(), ..MeshOptions::default() };
    let error = describe("back", meshes.clone(), LengthUnit::Millimetre, &wrong).unwrap_err();
    assert_eq!(error.code, ErrorCode::MeshRoles, "{error}");
    let mut alike = meshes.clone();
    alike.iter_mut().for_each(|m| m.name = "Solid".into());
    roles.extend((2..8).map(|k| (format!("Body{k}"), Role::Blade)));
    let numbered =
        roles.iter().map(|(name, role)| (name.to_lowercase().replace("body", "#"), *role)).collect();
    same(&part, &back(alike, &MeshOptions { roles: numbered, ..turning(&part) }), 0.02);
    same(&part, &back(meshes, &MeshOptions { roles, ..turning(&part) }), 0.02);
}

/// Hub and blades in one mesh, without shroud; `blades` of them, the points of each changed by `change`.
fn whole(part: &Impeller, blades: usize, change: impl Fn(&str, &Point) -> Point) -> TriangleMesh {
    let mut whole = TriangleMesh::default();
    let mut left = blades;
    for mut m in separate(part) {
        let is_blade = m.name.starts_with("Blade");
        if m.name == "Shroud" || (is_blade && left == 0) {
            continue;
        }
        left -= usize::from(is_blade);
        m.mesh.points.iter_mut().for_each(|p| *p = change(&m.name, p));
        whole.append(&m.mesh);
    }
    whole
}

#[test]
fn a_wheel_in_one_mesh_may_stand_beside_the_axes_of_the_file() {
    let part = sample("pump6.toml");
    for along in [Vector::z(), Vector::x()] {
        let turn = Rotation3::rotation_between(&Vector::z(), &along).expect("not opposite");
        let mesh = whole(&part, 6, |_, p| turn * p + Vector::new(100.0, 200.0, -30.0));
        let again = back(vec![named("Solid1".into(), 0, mesh)], &MeshOptions::default());
        assert_eq!(again.blade_count, 6);
        assert!((again.rim_radius() - part.rim_radius()).abs() < 0.02, "{}", again.rim_radius());
    }
}

#[test]
fn hub_and_one_blade_in_one_mesh_are_enough_with_the_number_of_blades() {
    let part = sample("pump6.toml");
    let mesh = vec![named("Solid1".into(), 0, whole(&part, 1, |_, p| *p))];
    let error = describe("back", mesh.clone(), LengthUnit::Millimetre, &MeshOptions::default()).unwrap_err();
    assert_eq!(error.code, ErrorCode::BladeCount, "{error}");
    same(&part, &back(mesh, &MeshOptions { blades: Some(6), ..turning(&part) }), 0.02);
}

#[test]
fn what_is_no_hub_is_refused_with_its_place() {
    let part = sample("pump6.toml");
    let mut meshes = separate(&part);
    for p in &mut meshes[0].mesh.points {
        p.z += 0.01 * p.x;
    }
    let error = describe("back", meshes, LengthUnit::Millimetre, &MeshOptions::default()).unwrap_err();
    assert_eq!(error.code, ErrorCode::NotRevolved, "{error}");
    assert!(error.message.contains("at z ="), "{error}");
}
