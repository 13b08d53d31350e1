//! Meshes as they come: soups whose corners rounding has parted, and meshes with holes.

use nalgebra::Rotation3;
use vanecut::geometry::{Point, Vector};
use vanecut::mesh::{NamedMesh, TriangleMesh, Unit, describe};
use vanecut::part::Impeller;

use crate::body::Body;
use crate::{SAMPLES, back, named, same, sample, separate, turning};

/// Triangles that share no corners, each rounded to single precision in one of some frames of its own.
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
    let whole = vec![named("Solid1".into(), 0, Body::default().of(&part).whole())];
    same(&part, &back(changed(whole, soup), &turning(&part)), 0.02);
}

/// Every `step`-th triangle, scattered, and as many of its neighbours in the list as make `width` of them, taken out.
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
        let told = ["close the mesh", "close its gaps"].iter().any(|cure| error.contains(cure));
        assert!(told, "{error}");
        println!("refused: {error}");
    };
    let judged = |part: &Impeller, meshes: Vec<NamedMesh>, what: &str| {
        println!("{what}");
        match describe("back", meshes, Unit::Millimetre, &turning(part)) {
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
        for (step, width) in [(400, 1), (100, 1), (150, 2)] {
            let open = judged(&part, changed(separate(&part), |m| holed(m, step, width)), name);
            assert!(open || width > 1, "{name}: single triangles are found again");
        }
    }
    let part = sample("impeller532.toml");
    let whole = |step| vec![named("Solid1".into(), 0, holed(&Body::default().of(&part).whole(), step, 1))];
    assert!(judged(&part, whole(400), "in one mesh"));
    // A window in the middle of each blade.
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
    let error = describe("back", meshes, Unit::Millimetre, &turning(&part)).unwrap_err().to_string();
    assert!(error.contains("hole of") && error.contains("z ="), "{error}");
}
