//! Wheels from CAD whose hub is more than the floor of the channels: bosses, eyes, vanes on the back.

use vanecut::geometry::{Meridional, Point};
use vanecut::io::step::{read_bytes, read_scene_bytes};
use vanecut::io::stl::{read_part_bytes, write_stl};
use vanecut::mesh::{MeshOptions, TriangleMesh};
use vanecut::part::Impeller;

use crate::cad::built;
use crate::cad_as_mesh::{in_mm, plate, turned};

/// Paddles that begin in the boss of their disc, and a covered wheel with an eye, made by the script beside
/// them.
const PADDLE_WHEEL: &[u8] = include_bytes!("../data/step/paddle_wheel.step");
const PADDLE_FOOT: &[u8] = include_bytes!("../data/step/paddle_foot.step");
const PADDLE_CORNER: &[u8] = include_bytes!("../data/step/paddle_corner.step");
const PADDLE_SPLINES: &[u8] = include_bytes!("../data/step/paddle_splines.step");
const PADDLE_FILLETS: &[u8] = include_bytes!("../data/step/paddle_fillets.stl");
const PUMP_EYE: &[u8] = include_bytes!("../data/step/pump_eye.step");

/// All bodies of a STEP file as an STL file.
fn as_stl(file: &[u8]) -> Vec<u8> {
    let scene = read_scene_bytes("wheel.step", file, None).expect("sound");
    let mut mesh = TriangleMesh::default();
    scene.bodies.iter().for_each(|body| mesh.append(&body.mesh));
    write_stl(&mesh.points, &mesh.triangles, "wheel")
}

/// Distance of a place from the hub's curve, mm.
fn off_hub(part: &Impeller, (r, z): (f64, f64)) -> f64 {
    part.hub.curve().project(Meridional { r, z }).1.abs()
}

/// Largest distance of both sides of a plane radial blade, `half` mm thick on either side, from their planes.
fn off_planes(part: &Impeller, half: f64) -> f64 {
    let across = |p: Point| {
        let turn = (p.y.atan2(p.x) / part.pitch()).round() * part.pitch();
        (p.y * turn.cos() - p.x * turn.sin()).abs()
    };
    let places = (2..=9).flat_map(|i| (1..=9).map(move |j| (0.1 * f64::from(i), 0.1 * f64::from(j))));
    let sides = [&part.main.suction, &part.main.pressure];
    let off = |(u, v): (f64, f64)| sides.map(|s| (across(s.point(u, v)) - half).abs());
    places.flat_map(off).fold(0.0, f64::max)
}

#[test]
fn what_rises_ahead_of_the_blades_is_part_of_the_hub() {
    // A disc with a boss in two steps, behind sharp corners.
    let steps = [(14.0, 4.0), (14.0, 12.0), (10.0, 12.0), (10.0, 20.0), (8.0, 20.0)];
    let outline: Vec<(f64, f64)> = [(8.0, 0.0), (60.0, 0.0), (60.0, 4.0)].into_iter().chain(steps).collect();
    let mut wheel = turned(&outline);
    (0..6).for_each(|k| wheel.append(&plate(f64::from(k) * std::f64::consts::TAU / 6.0)));
    let part = built(&read_part_bytes("nut.stl", &write_stl(&wheel.points, &wheel.triangles, "x"), &in_mm()));
    for place in [(10.0, 19.0), (10.0, 16.0), (12.0, 12.0), (14.0, 8.0), (20.0, 4.0), (57.0, 4.0)] {
        let off = off_hub(&part, place);
        assert!(off < 0.01, "the hub is {off} mm off {place:?}");
    }
    for corner in [(14.0, 4.0), (14.0, 12.0), (10.0, 12.0), (10.0, 20.0)] {
        let off = off_hub(&part, corner);
        assert!(off < 0.1, "the hub rounds its corner at {corner:?} by {off} mm");
    }
}

/// Three paddles of 3 mm, up to z = 16 mm, from a STEP file and from its triangles. They begin just behind
/// the wall of a boss; `places` are on the hub within `tolerance`, mm.
fn check_paddles(step: &[u8], places: &[(f64, f64)], tolerance: f64) {
    let from_step = built(&read_bytes("wheel.step", step, &MeshOptions::default()));
    let from_stl = built(&read_part_bytes("wheel.stl", &as_stl(step), &in_mm()));
    for (name, part) in [("STEP", from_step), ("STL", from_stl)] {
        assert_eq!((part.blade_count, part.splitters.len()), (3, 0), "{name}");
        let (hub, tip) = (part.hub.point(0.0), part.shroud.point(0.0));
        assert!((hub.r - 15.2).abs() < 0.2 && (tip.r - 15.2).abs() < 0.2, "{name}: {hub:?} {tip:?}");
        for &place in places {
            let off = off_hub(&part, place);
            assert!(off < tolerance, "{name}: the hub is {off} mm off {place:?}");
        }
        assert!((part.shroud.point(0.5).z - 16.0).abs() < 0.01, "{name}");
        let off = off_planes(&part, 1.5);
        assert!(off < 0.01, "{name}: a side is {off} mm off");
    }
}

#[test]
fn paddles_that_begin_in_a_boss_are_blades() {
    check_paddles(PADDLE_WHEEL, &[(15.0, 15.0), (15.0, 8.0), (20.0, 4.0), (55.0, 4.0)], 0.01);
}

#[test]
fn paddles_that_begin_in_a_boss_with_a_rounded_foot_are_blades() {
    // The wall, the middle of the corner at its foot, and the disc.
    let middle = 4.0 - 4.0 * std::f64::consts::FRAC_1_SQRT_2;
    let corner = (15.0 + middle, 4.0 + middle);
    check_paddles(PADDLE_FOOT, &[(15.0, 15.0), (15.0, 9.0), corner, (20.0, 4.0), (55.0, 4.0)], 0.02);
}

#[test]
fn blades_stand_across_a_corner_of_the_hub() {
    let from_step = built(&read_bytes("wheel.step", PADDLE_CORNER, &MeshOptions::default()));
    let from_stl = built(&read_part_bytes("wheel.stl", &as_stl(PADDLE_CORNER), &in_mm()));
    for (name, part) in [("STEP", from_step), ("STL", from_stl)] {
        assert_eq!((part.blade_count, part.splitters.len()), (3, 0), "{name}");
        for (place, tolerance) in [((50.0, 4.0 + 10.0 / 18.0), 0.01), ((23.0, 20.0 / 3.0), 0.05)] {
            let off = off_hub(&part, place);
            assert!(off < tolerance, "{name}: the hub is {off} mm off {place:?}");
        }
        assert!((part.shroud.point(0.5).z - 16.0).abs() < 0.01, "{name}");
        let begins = Meridional::from_point(&part.main.suction.point(0.0, 0.5)).r;
        assert!((begins - 22.0).abs() < 0.1, "{name}: the blades begin at r = {begins} mm");
        let middle = |k: i32| {
            let turn = f64::from(k) * part.pitch();
            Point::new(-43.0 * turn.sin(), 43.0 * turn.cos(), 0.0)
        };
        for (u, v) in [(0.1, 0.1), (0.1, 0.9), (0.3, 0.0), (0.5, 0.5), (0.9, 0.1), (0.9, 0.9)] {
            for side in [&part.main.suction, &part.main.pressure] {
                let p = side.point(u, v);
                let radii = (0..3).map(|k| (p.xy() - middle(k).xy()).norm());
                let off = radii.map(|r| (r - 45.4).abs().min((r - 48.0).abs())).fold(f64::INFINITY, f64::min);
                assert!(off < 0.02, "{name}: a side is {off} mm off at {u}, {v}");
            }
        }
    }
}

#[test]
fn plates_with_fillets_are_plane_as_bare_triangles() {
    let part = built(&read_part_bytes("wheel.stl", PADDLE_FILLETS, &in_mm()));
    assert_eq!((part.blade_count, part.splitters.len()), (3, 0));
    assert!(off_hub(&part, (40.0, 4.0)) < 0.01 && (part.shroud.point(0.5).z - 16.0).abs() < 0.01);
    let off = off_planes(&part, 1.5);
    assert!(off < 0.01, "a side is {off} mm off");
    for (u, r) in [(0.0, 25.0), (1.0, 60.0)] {
        for v in [0.1, 0.5, 0.9] {
            let p = part.main.suction.point(u, v);
            let off = (Meridional::from_point(&p).r - r).abs();
            assert!(off < 0.05, "the edge at r = {r} mm is {off} mm off at {v} of the height");
        }
    }
}

#[test]
fn a_wide_wheel_with_low_blades_opens_beside_other_bodies() {
    let description = read_bytes("wheel.step", PUMP_EYE, &MeshOptions::default());
    let part = built(&description);
    assert_eq!((part.blade_count, part.splitters.len()), (3, 0));
    let notes = description.map(|d| d.notes).unwrap_or_default();
    assert!(notes.iter().any(|n| n.starts_with("left out beside")), "{notes:?}");
    // Hub and inside of the cover, which the blades divide.
    for (r, z, w) in [(35.0, 7.0 - 33.0 / 46.0, 21.0), (60.0, 7.0 - 108.0 / 46.0, 16.0)] {
        let shroud = part.shroud.curve().project(Meridional { r, z: w }).1.abs();
        assert!(off_hub(&part, (r, z)) < 0.01 && shroud < 0.01, "{r}");
    }
    let off = off_planes(&part, 1.5);
    assert!(off < 0.01, "a side is {off} mm off");
    // The blades begin ahead of the cover, free in its eye.
    assert!(notes.iter().any(|n| n.contains("ahead of the shroud")), "{notes:?}");
    assert!(part.shroud.point(0.0).r < 26.5, "{:?}", part.shroud.point(0.0));
}

/// Checks that the triangles of a cylinder of the `radius` above z = `low` have chords within `sag` of it,
/// mm.
fn check_cylinder(file: &[u8], radius: f64, low: f64, sag: f64) {
    let scene = read_scene_bytes("wheel.step", file, None).expect("sound");
    let mesh = &scene.bodies[0].mesh;
    let radius_of = |p: &Point| p.x.hypot(p.y);
    let mut seen = 0;
    for t in &mesh.triangles {
        let corners = t.map(|i| mesh.points[i as usize]);
        if corners.iter().any(|p| (radius_of(p) - radius).abs() > 1e-6 || p.z < low - 1e-6) {
            continue;
        }
        seen += 1;
        let middle = |a: usize, b: usize| radius_of(&nalgebra::center(&corners[a], &corners[b]));
        let least = middle(0, 1).min(middle(1, 2)).min(middle(2, 0));
        assert!(least > radius - sag, "a chord is {} mm inside", radius - least);
    }
    assert!(seen > 50, "{seen} triangles of the cylinder of {radius} mm");
}

#[test]
fn triangles_beside_notches_follow_a_cylinder() {
    check_cylinder(PUMP_EYE, 30.0, 22.0, 0.04);
    // The same as a B-spline.
    check_cylinder(PADDLE_SPLINES, 15.0, 4.0, 0.04);
}

#[test]
fn splines_and_a_top_that_meets_the_axis_open_as_the_cylinders_they_are() {
    check_paddles(PADDLE_SPLINES, &[(15.0, 15.0), (15.0, 8.0), (20.0, 4.0), (55.0, 4.0)], 0.01);
}
