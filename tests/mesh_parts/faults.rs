//! Meshes as they come: soups whose corners rounding has parted, and meshes with holes.

use nalgebra::Rotation3;
use vanecut::geometry::{Point, Vector};
use vanecut::mesh::{NamedMesh, TriangleMesh};

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
