//! Parts that went through triangles are the parts they were.

use std::path::Path;

use vanecut::formats::read_part;
use vanecut::geometry::{Meridional, Point, rotate_z};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{MeshOptions, NamedMesh, TriangleMesh, Unit, describe};
use vanecut::part::{BladeSide, Impeller, PartDescription, SideProbe};

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
    let part = Impeller::build(&description).expect("an impeller");
    (description, part)
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
