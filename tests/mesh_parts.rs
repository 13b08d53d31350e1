//! Parts that went through triangles are the parts they were.

use std::path::Path;

use nalgebra::Rotation3;
use vanecut::formats::gltf::GltfScene;
use vanecut::formats::{read_part, read_part_bytes};
use vanecut::geometry::{Meridional, Point, Vector, rotate_z};
use vanecut::job::{PlanRequest, run};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{MeshOptions, NamedMesh, Role, TriangleMesh, Unit, describe};
use vanecut::monitor::Monitor;
use vanecut::part::{AxisPolicy, Blade, BladeSide, Impeller, Setup, SideProbe};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

fn named(name: String, node: usize, mesh: TriangleMesh) -> NamedMesh {
    NamedMesh { name, other_names: Vec::new(), node, instance: 0, mesh }
}

/// Hub, shroud and all blades of a part, each in a mesh of its own, mm.
fn separate(part: &Impeller) -> Vec<NamedMesh> {
    let t = Tessellation::new(part, &Fineness::default());
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

fn back(meshes: Vec<NamedMesh>, options: &MeshOptions) -> Impeller {
    let description = describe("back", meshes, Unit::Millimetre, options).expect("a part");
    Impeller::build(&description).expect("an impeller")
}

/// The part as its own writer's file.
fn glb(part: &Impeller, fineness: &Fineness) -> Vec<u8> {
    GltfScene::of_part(part, &Tessellation::new(part, fineness)).glb()
}

/// The part as its own writer's file, read back.
fn through_glb(part: &Impeller) -> Impeller {
    let bytes = glb(part, &Fineness::default());
    Impeller::build(&read_part_bytes("back.glb", &bytes, "glb").expect("readable")).expect("an impeller")
}

/// Largest distance of points of `a` from the blade `b`, mm; half of the points on the first tenth, the nose, where
/// both sides may part at different lines.
fn off(a: &BladeSide, b: &Blade) -> f64 {
    let probes = [&b.suction, &b.pressure].map(|side| SideProbe::new(side, 0.0, 1.0));
    let mut worst: f64 = 0.0;
    for i in 0..=300 {
        let x = f64::from(i) / 300.0;
        let u = if x < 0.5 { 0.2 * x } else { 0.1 + 1.8 * (x - 0.5) };
        for j in 0..=20 {
            let p = a.point(u, f64::from(j) / 20.0);
            let distances = probes.each_ref().map(|probe| probe.nearest_to_point(&p).distance);
            worst = worst.max(distances[0].min(distances[1]));
        }
    }
    worst
}

/// Both parts have the same surfaces within `tolerance` mm, and the same blades.
fn same(one: &Impeller, other: &Impeller, tolerance: f64) {
    assert_eq!(one.blade_count, other.blade_count);
    assert_eq!(one.splitters.len(), other.splitters.len());
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

#[test]
fn own_files_give_the_part_back() {
    for name in ["impeller532.toml", "impeller9x9.toml", "pump6.toml"] {
        let part = sample(name);
        let again = through_glb(&part);
        same(&part, &again, 0.02);
        assert!((part.pitch() - again.pitch()).abs() < 1e-12, "{name}: the suction side is the same one");
        // All three are ruled, and known to be so again.
        assert!(again.main.suction.is_ruled() && again.main.pressure.is_ruled(), "{name}");
    }
}

#[test]
fn a_compressor_from_elsewhere_comes_back() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/cc_autoblade/cc_autoblade.geomTurbo");
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return;
    }
    let part = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let mut again = through_glb(&part);
    assert!((part.pitch().abs() - again.pitch().abs()).abs() < 1e-12);
    // A mesh does not tell which side this file calls the suction side.
    if part.pitch() * again.pitch() < 0.0 {
        for blade in std::iter::once(&mut again.main).chain(&mut again.splitters) {
            std::mem::swap(&mut blade.suction, &mut blade.pressure);
        }
        for splitter in &mut again.splitters {
            *splitter = splitter.rotated(part.pitch());
        }
    }
    same(&part, &again, 0.02);
}

#[test]
fn plans_of_own_files_are_the_same() {
    for name in ["impeller532.toml", "impeller9x9.toml", "pump6.toml"] {
        let part = sample(name);
        let plan = |part: &Impeller| {
            let request = PlanRequest {
                part: part.clone().into(),
                setup: Setup::default(),
                policy: AxisPolicy::Conventional,
                compare: false,
                field_cells: 16,
            };
            run(&request, &Monitor::default()).expect("a plan").after.plan
        };
        let (a, b) = (plan(&part), plan(&through_glb(&part)));
        let (mut moved, mut turned): (f64, f64) = (0.0, 0.0);
        for (p, q) in a.positions.iter().zip(&b.positions) {
            moved = moved.max((p.tip - q.tip).norm());
            turned = turned.max(p.axis.angle(&q.axis).to_degrees());
        }
        println!("{name}: {moved:.4} mm, {turned:.4}°");
        assert_eq!(a.positions.len(), b.positions.len());
        assert!(moved < 0.05 && turned < 0.1, "{name}: {moved} mm, {turned}°");
    }
}

/// A wheel in one mesh without inner walls: hub between the blades, rim, sides, tips and trailing edges share corners.
fn fused(part: &Impeller, along: usize, across: usize, high: usize) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    // Coincident corners are made one by the reader: each patch has its own.
    let mut patch = |rows: usize, columns: usize, at: &dyn Fn(usize, usize) -> Point| {
        let first = mesh.points.len() as u32;
        for i in 0..=rows {
            // Patches come to the same corners in different ways.
            let rounded = |p: Point| Point::from(p.coords.map(|x| (x * 1e5).round() / 1e5));
            mesh.points.extend((0..=columns).map(|j| rounded(at(i, j))));
        }
        let index = |i: usize, j: usize| first + (i * (columns + 1) + j) as u32;
        for i in 0..rows {
            for j in 0..columns {
                mesh.triangles.push([index(i, j), index(i + 1, j), index(i, j + 1)]);
                mesh.triangles.push([index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]);
            }
        }
    };
    let (suction, pressure) = (&part.main.suction, &part.main.pressure);
    let u = |i: usize| (i as f64 / along as f64).powi(2);
    let hub = part.hub.curve();
    let place = |p: Point| (hub.project(Meridional::of(&p)).0, p.y.atan2(p.x));
    for k in 0..part.blade_count {
        let turn = |p: Point| rotate_z(&p, part.pitch() * k as f64);
        let floor = |i: usize, j: usize| {
            // From the suction side of this blade to the pressure side of the next one.
            let ((t0, a0), (t1, a1)) = (place(suction.point(u(i), 0.0)), place(pressure.point(u(i), 0.0)));
            let width = (a1 - a0 + part.pitch()).rem_euclid(std::f64::consts::TAU.copysign(part.pitch()));
            let width = if part.pitch() < 0.0 && width > 0.0 { width - std::f64::consts::TAU } else { width };
            let x = j as f64 / across as f64;
            hub.point(t0 + (t1 - t0) * x).at_angle(a0 + width * x)
        };
        patch(along, across, &|i, j| turn(floor(i, j)));
        // Ahead of the blades, and down the rim.
        let nose = |i: usize, j: usize| {
            let p = floor(0, j);
            let (t, a) = place(p);
            if i == 8 { p } else { hub.point(t * (0.5 + i as f64 / 16.0)).at_angle(a) }
        };
        patch(8, across, &|i, j| turn(nose(i, j)));
        patch(2, across, &|i, j| {
            let p = turn(floor(along, j));
            Point::new(p.x, p.y, p.z + 4.0 * i as f64)
        });
        for side in [suction, pressure] {
            patch(along, high, &|i, j| turn(side.point(u(i), j as f64 / high as f64)));
        }
        patch(along, 1, &|i, j| turn([suction, pressure][j].point(u(i), 1.0)));
        patch(1, high, &|i, j| turn([suction, pressure][i].point(1.0, j as f64 / high as f64)));
    }
    mesh
}

#[test]
fn a_wheel_in_one_mesh_is_taken_apart() {
    let part = sample("impeller532.toml");
    let joined = separate(&part).into_iter().fold(TriangleMesh::default(), |mut all, m| {
        all.append(&m.mesh);
        all
    });
    same(&part, &back(vec![named("Body".into(), 0, joined)], &MeshOptions::default()), 0.02);
    let one = fused(&part, 160, 24, 24);
    same(&part, &back(vec![named("Solid1".into(), 0, one)], &MeshOptions::default()), 0.02);
}

#[test]
fn one_blade_is_enough_with_the_number_of_blades_and_needs_no_shroud() {
    let part = sample("impeller9x9.toml");
    let mut meshes = separate(&part);
    meshes.truncate(4);
    meshes.remove(1);
    let error = describe("back", meshes.clone(), Unit::Millimetre, &MeshOptions::default()).unwrap_err();
    assert!(error.to_string().contains("--blades N"), "{error}");
    same(&part, &back(meshes, &MeshOptions { blades: Some(9), ..MeshOptions::default() }), 0.02);
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
    same(&part, &back(meshes, &MeshOptions::default()), 0.02);
}

#[test]
fn splitters_without_a_name_are_told_by_their_length() {
    let part = sample("impeller9x9.toml");
    let mut meshes = separate(&part);
    meshes.iter_mut().filter(|m| m.name.starts_with("Splitter")).for_each(|m| m.name = "Vane".into());
    same(&part, &back(meshes, &MeshOptions::default()), 0.02);
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
        Impeller::build(&describe("back", meshes, Unit::Metre, options).expect("a part"))
            .expect("an impeller")
    };
    // Along x and along an odd axis beside the origin.
    same(&part, &build(metres(&|p| Point::new(p.z, p.x, p.y)), &MeshOptions::default()), 0.02);
    let odd = Rotation3::from_euler_angles(0.3, 0.8, -0.4);
    let tilted = build(metres(&|p| odd * p + Vector::new(0.1, 0.2, -0.05)), &MeshOptions::default());
    assert_eq!(tilted.blade_count, 6);
    assert!((tilted.rim_radius() - part.rim_radius()).abs() < 0.02, "{}", tilted.rim_radius());
    // Millimetres in a file of metres.
    let huge = describe("back", separate(&part), Unit::Metre, &MeshOptions::default()).unwrap_err();
    assert!(huge.to_string().contains("--unit mm"), "{huge}");
    let options = MeshOptions { unit: Some(Unit::Millimetre), ..MeshOptions::default() };
    same(&part, &build(separate(&part), &options), 0.02);
    // Names that tell nothing.
    let mut meshes = separate(&part);
    for (k, m) in meshes.iter_mut().enumerate() {
        m.name = format!("Body{k}");
    }
    let mut roles = vec![("body0".to_owned(), Role::Hub), ("Body1".to_owned(), Role::Shroud)];
    let wrong = MeshOptions { roles: roles.clone(), ..MeshOptions::default() };
    assert!(
        describe("back", meshes.clone(), Unit::Millimetre, &wrong)
            .unwrap_err()
            .to_string()
            .contains("NODE=blade")
    );
    roles.extend((2..8).map(|k| (format!("Body{k}"), Role::Blade)));
    same(&part, &back(meshes, &MeshOptions { roles, ..MeshOptions::default() }), 0.02);
}

#[test]
fn what_is_no_hub_is_refused_with_its_place() {
    let part = sample("pump6.toml");
    let mut meshes = separate(&part);
    for p in &mut meshes[0].mesh.points {
        p.z += 0.01 * p.x;
    }
    let error = describe("back", meshes, Unit::Millimetre, &MeshOptions::default()).unwrap_err().to_string();
    assert!(error.contains("the hub is not a surface of revolution") && error.contains("at z ="), "{error}");
}
