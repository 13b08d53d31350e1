//! Meshes of few, long triangles, whose chords are far from the surfaces, and of surfaces that the sides of a
//! blade cannot follow.

use vanecut::geometry::{Meridional, Vector};
use vanecut::mesh::tessellate::Fineness;
use vanecut::mesh::{LengthUnit, TriangleMesh, describe};

use super::{back, named, off, sample, separate, separate_at, turning};

/// Coarse feet dip into the hub here and there, and long edges along the hub are chords of its curve.
#[test]
fn coarse_wheels_in_one_mesh_open() {
    for name in ["pump6.toml", "impeller9x9.toml", "impeller532.toml"] {
        let part = sample(name);
        for chord_error in [0.5, 1.0, 2.0] {
            let fineness = Fineness { chord_error, ..Fineness::default() };
            let mut wheel = TriangleMesh::default();
            for body in separate_at(&part, &fineness).iter().filter(|body| body.name != "Shroud") {
                wheel.append(&body.mesh);
            }
            let again = back(vec![named(name.to_owned(), 0, wheel)], &turning(&part));
            let what = format!("{name} within {chord_error} mm");
            assert_eq!(again.blade_count, part.blade_count, "{what}");
            assert_eq!(again.splitters.len(), part.splitters.len(), "{what}");
            let hub = again.hub.curve();
            let places = (0..=50).map(|i| part.hub.point(f64::from(i) / 50.0));
            let hub_off = places.map(|p| hub.project(p).1.abs()).fold(0.0, f64::max);
            let side_off = off(&again.main.suction, &part.main).max(off(&again.main.pressure, &part.main));
            let is_near = hub_off < 0.6 * chord_error && side_off < chord_error;
            assert!(is_near, "{what}: hub {hub_off:.3} mm, sides {side_off:.3} mm");
        }
    }
}

/// What is not understood of a blade must not be cut unseen.
#[test]
fn sides_that_leave_the_mesh_are_noted() {
    let part = sample("pump6.toml");
    let notes = |peak_mm: f64| {
        let mut meshes = separate(&part);
        // The corner of each blade that is nearest to the middle of its channel.
        let aim = part.meridional(0.5, 0.5);
        for blade in meshes.iter_mut().filter(|mesh| mesh.name.starts_with("Blade")) {
            let far = |p: &&mut vanecut::geometry::Point| Meridional::from_point(p).distance(aim);
            let corner = blade.mesh.points.iter_mut().min_by(|a, b| far(a).total_cmp(&far(b))).expect("some");
            *corner += peak_mm * Vector::new(-corner.y, corner.x, 0.0).normalize();
        }
        describe("peaks", meshes, LengthUnit::Millimetre, &turning(&part)).expect("a part").notes
    };
    assert_eq!(notes(0.0), [""; 0]);
    let found = notes(3.0);
    let is_named = |note: &String| note.contains("mm off the file's surfaces at z = ");
    assert!(found.iter().any(is_named), "{found:?}");
}
