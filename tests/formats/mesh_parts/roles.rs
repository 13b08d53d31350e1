//! Roles of bodies in assemblies: of the bodies beside a wheel, and where only some names are known.

use std::f64::consts::TAU;

use vanecut::error::ErrorCode;
use vanecut::geometry::{Meridional, Point, Vector, rotate_z};
use vanecut::mesh::describe::{describe, describe_source};
use vanecut::mesh::solid::Solid;
use vanecut::mesh::source::MeshSource;
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{LengthUnit, MeshOptions, NamedMesh, Role, TriangleMesh, grid_triangles};
use vanecut::part::{Impeller, PartDescription, PartError};

use super::body::Body;
use super::{named, sample, turning};

/// A closed body over a polygon in the meridional plane, with as many flats around the axis.
fn turned(outline: &[(f64, f64)], flats: usize) -> TriangleMesh {
    let around = |r: f64, z: f64| {
        (0..=flats).map(move |k| {
            let (sin, cos) = ((k % flats) as f64 * TAU / flats as f64).sin_cos();
            Point::new(r * cos, r * sin, z)
        })
    };
    let rings = outline.iter().chain(&outline[..1]);
    let points = rings.flat_map(|(r, z)| around(*r, *z)).collect();
    TriangleMesh { points, triangles: grid_triangles(outline.len() + 1, flats + 1, |_, _| true) }
}

/// Hub, shroud and blades, coarse: what is read is compared with what is read of them alone.
fn coarse(part: &Impeller) -> (TriangleMesh, TriangleMesh, Vec<TriangleMesh>) {
    let t = Tessellation::new(part, &Fineness { chord_error: 0.05, ..Fineness::default() });
    let turned = |mesh: &TriangleMesh, k: usize| TriangleMesh {
        points: mesh.points.iter().map(|p| rotate_z(p, part.pitch() * k as f64)).collect(),
        triangles: mesh.triangles.clone(),
    };
    let rows: Vec<TriangleMesh> = std::iter::once(&t.main).chain(&t.splitters).map(Solid::mesh).collect();
    let blades = (0..part.blade_count)
        .flat_map(|k| rows.iter().map(|row| turned(row, k)).collect::<Vec<_>>())
        .collect();
    (t.hub.mesh(), t.shroud.mesh(), blades)
}

/// The bodies of a wheel as a model has them: hub and blades, which have a number behind their name, and the
/// sheet over their tips if `with_shroud`.
fn wheel(part: &Impeller, (hub, blade): (&str, &str), with_shroud: bool) -> Vec<NamedMesh> {
    let (body, shroud, blades) = coarse(part);
    let mut meshes = vec![named(hub.to_owned(), 0, body)];
    meshes.extend(with_shroud.then(|| named("C1".to_owned(), 1, shroud)));
    meshes.extend(blades.into_iter().enumerate().map(|(k, mesh)| named(format!("{blade}{k}"), k + 2, mesh)));
    meshes
}

/// Shaft, washer, nut, housing, back wall and bolts around a wheel.
fn others(part: &Impeller) -> Vec<(&'static str, TriangleMesh)> {
    let (first, last) = (part.hub.point(0.0), part.hub.point(1.0));
    let rim = part.rim_radius();
    // From the back towards the inlet, so that z counts from the outlet.
    let up = (first.z - last.z).signum();
    let at = |r: f64, z: f64| (r, last.z + up * z);
    let (nose, high) = (first.r, (first.z - last.z).abs());
    let bore = coarse(part).0.points.iter().map(|p| Meridional::from_point(p).r).fold(rim, f64::min);
    let shaft = if bore > 1.0 { bore } else { 0.4 * nose };
    let bolt = |k: usize| {
        let mut mesh = turned(&[at(0.0, -0.4 * rim), at(3.0, -0.4 * rim), at(3.0, -2.0), at(0.0, -2.0)], 6);
        let angle = k as f64 * TAU / 6.0;
        let moved = Vector::new(angle.cos(), angle.sin(), 0.0) * (0.6 * rim);
        mesh.points.iter_mut().for_each(|p| *p += moved);
        mesh
    };
    let ring = |inner: f64, outer: f64, from: f64, to: f64| {
        [at(inner, from), at(outer, from), at(outer, to), at(inner, to)]
    };
    let bolts = (0..6).map(bolt).fold(TriangleMesh::default(), |mut all, bolt| {
        all.append(&bolt);
        all
    });
    vec![
        ("E1", turned(&ring(0.0, shaft, -2.0 * rim, high + rim), 96)),
        ("E2", turned(&ring(shaft, 0.9 * nose, high, high + 2.0), 96)),
        ("E3", turned(&ring(shaft, 0.9 * nose, high + 2.0, high + 12.0), 6)),
        ("E4", turned(&ring(1.06 * rim, 1.4 * rim, -0.5 * rim, 0.6 * high), 96)),
        ("E5", turned(&ring(0.7 * rim, 1.4 * rim, -0.9 * rim, -0.8 * rim), 96)),
        ("E6", bolts),
    ]
}

fn with_others(part: &Impeller, mut meshes: Vec<NamedMesh>) -> Vec<NamedMesh> {
    // Before and after the wheel.
    for (k, (name, mesh)) in others(part).into_iter().enumerate() {
        let body = named(name.to_owned(), 100 + k, mesh);
        if k % 2 == 0 { meshes.insert(0, body) } else { meshes.push(body) }
    }
    meshes
}

/// The part as a model from CAD with these bodies.
fn read(meshes: Vec<NamedMesh>, options: &MeshOptions) -> Result<PartDescription, PartError> {
    let axis = Some((Point::origin(), Vector::z()));
    let source = MeshSource { axis, ..MeshSource::from_unit(LengthUnit::Millimetre) };
    describe_source("model", meshes, source, options)
}

/// The notes of the part, which is otherwise `alone`.
fn notes_of(part: Result<PartDescription, PartError>, alone: &PartDescription) -> Vec<String> {
    let mut part = part.expect("a part");
    let notes = std::mem::take(&mut part.notes);
    let alone = PartDescription { notes: Vec::new(), roles_by_shape: part.roles_by_shape, ..alone.clone() };
    assert!(part == alone, "another part: {notes:?}");
    notes
}

#[test]
fn bodies_beside_a_wheel_are_left_out_with_a_line() {
    for (name, with_shroud) in [("pump6.toml", true), ("impeller9x9.toml", false)] {
        let part = sample(name);
        let options = turning(&part);
        let alone = read(wheel(&part, ("A1", "B"), with_shroud), &options).expect("a part");
        assert_eq!(alone.notes, [""; 0]);
        assert_eq!((alone.blade_count, alone.splitters.len()), (part.blade_count, part.splitters.len()));
        let meshes = with_others(&part, wheel(&part, ("A1", "B"), with_shroud));
        let notes = notes_of(read(meshes, &options), &alone);
        let said = notes.join("\n");
        assert!(notes.len() <= 2 && (1..5).all(|k| said.contains(&format!("`E{k}`"))), "{said}");
        // One by one, too, beside the wheel that opens faster.
        for (one, mesh) in others(&part).into_iter().filter(|_| with_shroud) {
            let mut meshes = wheel(&part, ("A1", "B"), with_shroud);
            meshes.push(named(one.to_owned(), 100, mesh));
            let notes = notes_of(read(meshes, &options), &alone);
            assert!(notes.len() == 1 && notes[0].contains(&format!("`{one}`")), "{one}: {notes:?}");
        }
    }
}

/// Splitters would be milled away.
#[test]
fn bodies_without_a_role_beside_those_that_have_one_are_named() {
    let part = sample("impeller9x9.toml");
    let mut meshes = wheel(&part, ("Hub", "Blade "), false);
    for (k, mesh) in meshes.iter_mut().skip(1).enumerate().filter(|(k, _)| k % 2 == 1) {
        mesh.name = format!("Body {k}");
    }
    let found = describe("model", meshes, LengthUnit::Millimetre, &turning(&part)).expect("a part");
    assert_eq!((found.blade_count, found.splitters.len()), (9, 0));
    let notes = found.notes.join("\n");
    assert!(
        notes.contains("left out, without a role: Body 1, Body 3, ") && notes.contains("--role"),
        "{notes}"
    );
}

#[test]
fn a_casing_over_a_gap_is_the_shroud_and_a_ring_round_the_rim_is_none() {
    let part = sample("pump6.toml");
    let options = turning(&part);
    let mut meshes = wheel(&part, ("A1", "B"), true);
    let casing = meshes.iter_mut().find(|mesh| mesh.name == "C1").expect("a casing");
    // 0.3 mm towards the inlet, which is below.
    casing.mesh.points.iter_mut().for_each(|p| p.z -= 0.3);
    let alone = read(meshes.clone(), &options).expect("a part");
    assert_ne!(alone.shroud, read(wheel(&part, ("A1", "B"), false), &options).expect("a part").shroud);
    let notes = notes_of(read(with_others(&part, meshes), &options), &alone);
    assert!(!notes.join("\n").contains("`C1`"), "{notes:?}");
}

#[test]
fn a_wheel_in_one_body_beside_a_shaft_is_taken_apart() {
    let part = sample("impeller532.toml");
    let whole = || vec![named("Solid1".into(), 0, Body::default().built_on(&part).whole())];
    let options = turning(&part);
    let alone = read(whole(), &options).expect("a part");
    let notes = notes_of(read(with_others(&part, whole()), &options), &alone);
    assert!(notes.len() == 1 && notes[0].contains("beside `Solid1`: "), "{notes:?}");
}

#[test]
fn several_bodies_that_may_be_the_hub_are_asked_for_their_roles() {
    let part = sample("impeller532.toml");
    let mut meshes = wheel(&part, ("B", "B"), true);
    let (rim, z) = (part.rim_radius(), part.hub.point(1.0).z);
    let ring = [(0.3, 0.5), (0.6, 0.5), (0.6, 0.7), (0.3, 0.7)].map(|(r, h)| (r * rim, z - h * rim));
    meshes.push(named("B99".to_owned(), 99, turned(&ring, 90)));
    let error =
        describe("back", meshes, LengthUnit::Millimetre, &MeshOptions::default()).map(|_| ()).unwrap_err();
    assert_eq!(error.code, ErrorCode::MeshRoles, "{error}");
    assert!(error.message.contains("3 separate bodies of revolution"), "{error}");
}

#[test]
fn shapes_tell_the_roles_that_names_do_not() {
    let part = sample("pump6.toml");
    let options = turning(&part);
    let alone = read(wheel(&part, ("A1", "B"), false), &options).expect("a part");
    for (hub, blade) in [
        ("Hub", "B"),
        ("A1", "Blade "),
        ("Laufrad", "Schaufel "),
        ("Moyeu", "Pale "),
        ("Cubo", "\u{c1}labe "),
    ] {
        let notes = notes_of(read(wheel(&part, (hub, blade), false), &options), &alone);
        assert_eq!(notes, [""; 0], "{hub}, {blade}");
    }
    let meshes = with_others(&part, wheel(&part, ("Laufrad", "Schaufel "), false));
    notes_of(read(meshes, &options), &alone);
}

#[test]
fn names_that_cannot_be_meant_count_less_than_shapes() {
    let part = sample("pump6.toml");
    let options = turning(&part);
    let alone = read(wheel(&part, ("A1", "B"), false), &options).expect("a part");
    // The names of other bodies are those of roles; hub and blades have none, some or all.
    for (hub, blade, other, is_called) in [
        ("A1", "Blade ", "E1", "Motor hub"),
        ("A1", "B", "E4", "Cover"),
        ("Hub", "Blade ", "E5", "Cover"),
        ("Hub", "B", "E5", "Blade guard"),
        ("Blade carrier", "Hub-piece ", "E2", "Ring"),
    ] {
        let mut meshes = with_others(&part, wheel(&part, (hub, blade), false));
        let body = meshes.iter_mut().find(|mesh| mesh.name == other).expect("a body");
        body.name = is_called.to_owned();
        let notes = notes_of(read(meshes, &options), &alone);
        let said = |note: &String| note.contains(is_called) || note.contains("their shapes decided");
        assert!(notes.iter().any(said), "{hub}, {blade}, {is_called}: {notes:?}");
    }
    // The user is not doubted.
    let mut options = options;
    options.roles.push(("E4".to_owned(), Role::Hub));
    let error = read(with_others(&part, wheel(&part, ("A1", "B"), false)), &options);
    assert!(error.is_err_and(|error| error.to_string().contains("hub")));
}
