//! Imperfect meshes: triangle soups whose corners differ by rounding, and meshes with holes.

use nalgebra::Rotation3;
use vanecut::error::ErrorCode;
use vanecut::geometry::{Point, Vector, rotate_z};
use vanecut::mesh::solid::FaceKind;
use vanecut::mesh::tessellate::Tessellation;
use vanecut::mesh::{LengthUnit, MeshOptions, NamedMesh, Role, TriangleMesh, describe};
use vanecut::part::Impeller;

use super::body::Body;
use super::{COARSE, SAMPLES, back, named, same, sample, separate, turning};

/// Triangles without shared corners, each rounded to single precision in one of several frames.
fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    let mut soup = TriangleMesh::default();
    for (k, t) in mesh.triangles.iter().enumerate() {
        let angle = 0.7 * (k % 7) as f64;
        let turn = Rotation3::from_euler_angles(angle, 0.3 * angle, -angle);
        let shift = Vector::new(3.7, -1.9, 8.3) * (k % 5) as f64;
        soup.triangles.push([0, 1, 2].map(|c| (3 * k + c) as u32));
        soup.points.extend(t.map(|i| {
            let own = turn * mesh.points[i as usize] + shift;
            let rounded = Point::from(own.coords.map(|x| f64::from(x as f32)));
            turn.inverse() * (rounded - shift)
        }));
    }
    soup
}

fn changed(mut meshes: Vec<NamedMesh>, change: impl Fn(&TriangleMesh) -> TriangleMesh) -> Vec<NamedMesh> {
    meshes.iter_mut().for_each(|m| m.mesh = change(&m.mesh));
    meshes
}

#[test]
fn soups_of_triangles_with_rounded_corners_give_the_part_back() {
    for name in SAMPLES {
        let part = sample(name);
        same(&part, &back(changed(separate(&part), soup), &turning(&part)), 0.02);
    }
    let part = sample("impeller532.toml");
    let whole = vec![named("Solid1".into(), 0, Body::default().built_on(&part).whole())];
    same(&part, &back(changed(whole, soup), &turning(&part)), 0.02);
}

/// Removes runs of `width` triangles that begin at every `step`-th triangle in pseudo-random order.
fn holed(mesh: &TriangleMesh, step: usize, width: usize) -> TriangleMesh {
    let gone = |k: usize| {
        (0..width).any(|w| k >= w && (((k - w) * 2_654_435_761) % 4_294_967_296).is_multiple_of(step))
    };
    let triangles = mesh.triangles.iter().enumerate().filter(|(k, _)| !gone(*k)).map(|(_, t)| *t).collect();
    TriangleMesh { points: mesh.points.clone(), triangles }
}

#[test]
fn holes_are_filled_or_refused_with_their_place() {
    let refused = |error: String| {
        let has_cure = ["close the mesh", "close its gaps"].iter().any(|help| error.contains(help));
        assert!(has_cure, "{error}");
        println!("refused: {error}");
    };
    let judged = |part: &Impeller, meshes: Vec<NamedMesh>, what: &str| {
        println!("{what}");
        match describe("back", meshes, LengthUnit::Millimetre, &turning(part)) {
            Ok(again) => {
                same(part, &Impeller::build(&again).expect("an impeller"), 0.02);
                true
            }
            Err(error) => {
                refused(error.to_string());
                false
            }
        }
    };
    for name in SAMPLES {
        let part = sample(name);
        let meshes = separate(&part);
        for (step, width) in [(100, 1), (150, 2)] {
            let open = judged(&part, changed(meshes.clone(), |m| holed(m, step, width)), name);
            assert!(open || width > 1, "{name}: single triangles are found again");
        }
    }
    let part = sample("impeller532.toml");
    let whole =
        |step| vec![named("Solid1".into(), 0, holed(&Body::default().built_on(&part).whole(), step, 1))];
    assert!(judged(&part, whole(400), "in one mesh"));
    // A hole in the middle of each blade.
    let window = |m: &TriangleMesh| {
        let inside = |t: &[u32; 3]| {
            let c = t.iter().map(|i| m.points[*i as usize].coords).sum::<Vector>() / 3.0;
            let side = part.main.suction.point(0.5, 0.5);
            (c.xy().norm() - side.coords.xy().norm()).abs() < 6.0 && (c.z - side.z).abs() < 6.0
        };
        let triangles = m.triangles.iter().filter(|t| !inside(t)).copied().collect();
        TriangleMesh { points: m.points.clone(), triangles }
    };
    let mut meshes = separate(&part);
    meshes.iter_mut().filter(|m| m.name.starts_with("Blade")).for_each(|m| m.mesh = window(&m.mesh));
    let error = describe("back", meshes, LengthUnit::Millimetre, &turning(&part)).unwrap_err();
    assert_eq!(error.code, ErrorCode::MeshNotClosed, "{error}");
    assert!(error.message.contains("z ="), "{error}");
}

#[test]
fn what_makes_no_wheel_has_a_code_by_what_is_missing() {
    let part = sample("pump6.toml");
    let whole = || separate(&part);
    let without = |gone: &str| whole().into_iter().filter(|m| !m.name.starts_with(gone)).collect::<Vec<_>>();
    let refused = |meshes: Vec<NamedMesh>, options: &MeshOptions| {
        let name = meshes.iter().map(|m| m.name.as_str()).collect::<Vec<_>>().join(", ");
        describe("back", meshes, LengthUnit::Millimetre, options).map(|_| ()).expect_err(&name)
    };
    let named_other = MeshOptions { roles: vec![("hat".into(), Role::Hub)], ..turning(&part) };
    assert_eq!(refused(whole(), &named_other).code, ErrorCode::UnknownName);
    assert_eq!(refused(without("Hub"), &turning(&part)).code, ErrorCode::MeshRoles);
    assert_eq!(refused(without("Blade"), &turning(&part)).code, ErrorCode::MeshRoles);
    let empty = vec![named("Hub".into(), 0, TriangleMesh::default())];
    assert_eq!(refused(empty, &turning(&part)).code, ErrorCode::NoTriangles);
    let mut meshes = without("Hub");
    meshes.push(named("Hub".into(), 99, TriangleMesh::default()));
    let error = refused(meshes, &turning(&part));
    assert_eq!(error.code, ErrorCode::NoRotationAxis, "{error}");
    // A blade that stands 10° beside its place.
    let mut meshes = whole();
    let blade = meshes.iter_mut().find(|m| m.name == "Blade_2").expect("a blade");
    blade.mesh.points.iter_mut().for_each(|p| *p = rotate_z(p, 10f64.to_radians()));
    let error = refused(meshes, &turning(&part));
    assert_eq!(error.code, ErrorCode::BladeSpacing, "{error}");
    // A spike in place of a blade: its only corner away from the hub does not say how the tips run.
    let hub = whole().into_iter().filter(|m| m.name == "Hub");
    let spike = named("Blade".into(), 1, spike_of(&part));
    let options = MeshOptions { blades: Some(part.blade_count), ..turning(&part) };
    let error = refused(hub.chain([spike]).collect(), &options);
    assert_eq!(error.code, ErrorCode::NoShroud, "{error}");
}

/// A pyramid from the foot of the main blade near the rim to its tip.
fn spike_of(part: &Impeller) -> TriangleMesh {
    let sides = [&part.main.suction, &part.main.pressure];
    let foot = [(0, 0.88), (0, 0.92), (1, 0.92), (1, 0.88)].map(|(side, u)| sides[side].point(u, 0.0));
    let points = foot.into_iter().chain([part.main.suction.point(0.84, 1.0)]).collect();
    let sloping = (0..4).map(|k| [k, (k + 1) % 4, 4]);
    TriangleMesh { points, triangles: [[0, 2, 1], [0, 3, 2]].into_iter().chain(sloping).collect() }
}

/// Blades with only their two sides, open at foot, tip and blunt edges, without the triangles whose corners
/// are all `gone`.
fn bitten(part: &Impeller, gone: impl Fn(FaceKind, &Point) -> bool) -> Vec<NamedMesh> {
    let main = Tessellation::new(part, &COARSE).main;
    let mut mesh = TriangleMesh { points: main.points.clone(), triangles: Vec::new() };
    for face in main.faces.iter().filter(|f| matches!(f.kind, FaceKind::Suction | FaceKind::Pressure)) {
        let corners = face.triangles.iter().map(|t| t.map(|c| face.corners[c as usize].point));
        mesh.triangles
            .extend(corners.filter(|t| !t.iter().all(|i| gone(face.kind, &mesh.points[*i as usize]))));
    }
    let mut meshes: Vec<NamedMesh> =
        separate(part).into_iter().filter(|m| !m.name.starts_with("Blade")).collect();
    meshes.push(named("Blade".into(), meshes.len(), mesh));
    meshes
}

#[test]
fn bites_out_of_a_border_are_refused_or_named() {
    let part = sample("impeller532.toml");
    let options = MeshOptions { blades: Some(part.blade_count), ..turning(&part) };
    let opened = |meshes| describe("back", meshes, LengthUnit::Millimetre, &options);
    let whole = opened(bitten(&part, |_, _| false)).expect("a part");
    same(&part, &Impeller::build(&whole).expect("an impeller"), 0.02);
    let (hub, rim) = (part.hub.point(0.0), part.rim_radius());
    let at_nose = |p: &Point| p.xy().coords.norm() < hub.r + 12.0 && (p.z - hub.z).abs() < 10.0;
    let at_rim = |p: &Point| p.xy().coords.norm() > rim - 15.0 && (p.z - part.hub.point(1.0).z).abs() < 8.0;
    // One side ends before the other, or the sides meet only at some heights.
    for (what, edge, meshes) in [
        ("a nose", "leading edge", bitten(&part, |_, p| at_nose(p))),
        ("one side", "trailing edge", bitten(&part, |kind, p| kind == FaceKind::Suction && at_rim(p))),
    ] {
        let error = opened(meshes).expect_err(what);
        assert_eq!(error.code, ErrorCode::MeshNotClosed, "{error}");
        assert!(error.message.contains(edge) && error.message.contains("z ="), "{error}");
    }
    // Both sides end early: this may be the shape of the blade.
    let cut = opened(bitten(&part, |_, p| at_rim(p))).expect("a part");
    let note = cut.notes.first().expect("a word about it");
    assert!(note.contains("trailing edge") && note.contains("jumps by") && note.contains("z ="), "{note}");
}
