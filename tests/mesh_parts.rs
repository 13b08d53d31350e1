//! Parts that went through triangles are the parts they were.

use std::path::Path;

use vanecut::formats::gltf::GltfScene;
use vanecut::formats::{read_part, read_part_bytes};
use vanecut::geometry::{Meridional, Point, rotate_z};
use vanecut::job::{PlanRequest, run};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{MeshOptions, NamedMesh, TriangleMesh, Unit, describe};
use vanecut::monitor::Monitor;
use vanecut::part::{AxisPolicy, BladeSide, Impeller, PartDescription, Setup, SideProbe};

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

fn back(meshes: Vec<NamedMesh>, options: &MeshOptions) -> (PartDescription, Impeller) {
    println!("{} triangles", meshes.iter().map(|m| m.mesh.triangles.len()).sum::<usize>());
    let start = std::time::Instant::now();
    let description = describe("back", meshes, Unit::Millimetre, options).expect("a part");
    println!("describe {:?}", start.elapsed());
    if let vanecut::part::CurveDescription::Points(p) = &description.hub {
        println!("{:?} {:?} {}", p[0], p[p.len() - 1], p.len());
    }
    if let vanecut::part::BladeDescription::Sections { suction, pressure, .. } = &description.main {
        for s in [suction, pressure] {
            for q in s {
                println!("{:?} {:?} {:?} r {}", q[0], q[1], q[2], q[0].x.hypot(q[0].y));
            }
        }
    }
    let part = Impeller::build(&description).expect("an impeller");
    (description, part)
}

/// The part as its own writer's file, read back.
fn through_glb(part: &Impeller) -> Impeller {
    let bytes = GltfScene::of_part(part, &Tessellation::new(part, &Fineness::default())).glb();
    if let Ok(f) = std::env::var("KEEP") {
        std::fs::write(format!("{f}/{}.glb", part.name), &bytes).unwrap();
    }
    println!("{} MB", bytes.len() as f64 / 1e6);
    let start = std::time::Instant::now();
    let description = read_part_bytes("back.glb", &bytes, "glb").expect("readable");
    println!("read {:?}", start.elapsed());
    Impeller::build(&description).expect("an impeller")
}

/// Largest distance of points of `a` from `b`, mm, with where it is.
fn off(a: &BladeSide, b: &BladeSide) -> (f64, f64, f64) {
    let probe = SideProbe::new(b, 0.0, 1.0);
    let mut worst = (0.0, 0.0, 0.0);
    for i in 0..=300 {
        // Half of them on the first tenth: the nose.
        let x = f64::from(i) / 300.0;
        let u = if x < 0.5 { 0.2 * x } else { 0.1 + 1.8 * (x - 0.5) };
        for j in 0..=20 {
            let v = f64::from(j) / 20.0;
            let d = probe.nearest_to_point(&a.point(u, v)).distance;
            if d > worst.0 {
                worst = (d, u, v);
            }
        }
    }
    worst
}

fn same(one: &Impeller, other: &Impeller) {
    for (name, a, b) in [("hub", &one.hub, &other.hub), ("shroud", &one.shroud, &other.shroud)] {
        let mut worst: f64 = 0.0;
        for i in 0..=500 {
            let p: Meridional = a.point(f64::from(i) / 500.0);
            worst = worst.max(b.curve().project(p).1.abs());
        }
        println!("{name}: {worst:.5} mm; length {:.5} {:.5}", a.length(), b.length());
    }
    let blades = std::iter::once((&one.main, &other.main)).chain(one.splitters.iter().zip(&other.splitters));
    for (a, b) in blades {
        println!("suction {:?} {:?}", off(&a.suction, &b.suction), off(&b.suction, &a.suction));
        println!(
            "pressure {:?} {:?} ruled {}",
            off(&a.pressure, &b.pressure),
            off(&b.pressure, &a.pressure),
            b.suction.is_ruled()
        );
        let le = |s: &BladeSide, v: f64| -> Point { s.point(0.0, v) };
        println!(
            "LE {:.4} {:.4}",
            (le(&a.suction, 0.0) - le(&b.suction, 0.0)).norm(),
            (le(&a.suction, 1.0) - le(&b.suction, 1.0)).norm()
        );
    }
}

#[test]
fn separate_meshes_give_the_part_back() {
    for name in ["impeller532.toml", "impeller9x9.toml", "pump6.toml"] {
        let part = sample(name);
        let (description, again) = back(separate(&part), &MeshOptions::default());
        println!("{name}: {} blades {} splitters", description.blade_count, description.splitters.len());
        assert_eq!(description.blade_count, part.blade_count);
        assert_eq!(description.splitters.len(), part.splitters.len());
        same(&part, &again);
    }
}

#[test]
fn own_files_give_the_part_back() {
    for name in ["impeller532.toml", "impeller9x9.toml", "pump6.toml"] {
        let part = sample(name);
        same(&part, &through_glb(&part));
    }
}

/// Largest difference of the positions of two plans: mm of the tips, degrees of the axes.
fn plans(one: &Impeller, other: &Impeller) -> (f64, f64) {
    let plan = |part: &Impeller| {
        let request = PlanRequest {
            part: part.clone().into(),
            setup: Setup::default(),
            policy: AxisPolicy::Monotone,
            compare: false,
            field_cells: 16,
        };
        run(&request, &Monitor::default()).expect("a plan").after.plan
    };
    let (a, b) = (plan(one), plan(other));
    println!("positions {} {}", a.positions.len(), b.positions.len());
    a.positions.iter().zip(&b.positions).fold((0.0, 0.0), |worst: (f64, f64), (p, q)| {
        (worst.0.max((p.tip - q.tip).norm()), worst.1.max(p.axis.angle(&q.axis).to_degrees()))
    })
}

#[test]
fn plans_of_own_files_are_the_same() {
    for name in ["impeller532.toml", "impeller9x9.toml", "pump6.toml"] {
        let part = sample(name);
        println!("{name} {:?}", plans(&part, &through_glb(&part)));
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
    let (description, again) = back(vec![named("Body".into(), 0, joined)], &MeshOptions::default());
    assert_eq!(description.blade_count, 17);
    same(&part, &again);
    let one = fused(&part, 160, 24, 24);
    let (description, again) = back(vec![named("Solid1".into(), 0, one)], &MeshOptions::default());
    assert_eq!(description.blade_count, 17);
    same(&part, &again);
}

#[test]
fn one_blade_is_enough_with_the_number_of_blades() {
    let part = sample("impeller9x9.toml");
    let mut meshes = separate(&part);
    meshes.truncate(4);
    meshes.remove(1);
    let error = describe("back", meshes.clone(), Unit::Millimetre, &MeshOptions::default()).unwrap_err();
    assert!(error.to_string().contains("--blades N"), "{error}");
    let (description, again) = back(meshes, &MeshOptions { blades: Some(9), ..MeshOptions::default() });
    assert_eq!((description.blade_count, description.splitters.len()), (9, 1));
    same(&part, &again);
}
