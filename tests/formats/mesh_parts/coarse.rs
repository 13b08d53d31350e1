//! Meshes of few, long triangles, whose chords are far from the surfaces.

use vanecut::mesh::tessellate::{Fineness, Tessellation};

use super::{back, named, off, sample, turning};

/// Coarse feet dip into the hub here and there, and long edges along the hub are chords of its curve.
#[test]
fn coarse_wheels_in_one_mesh_open() {
    for name in ["pump6.toml", "impeller9x9.toml", "impeller532.toml"] {
        let part = sample(name);
        for chord_error in [0.5, 1.0, 2.0] {
            let fineness = Fineness { chord_error, ..Fineness::default() };
            let wheel = Tessellation::new(&part, &fineness).open_wheel(&part);
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
