//! Wheels of CAD as bare triangles, as STL files have them: without faces, and without their normals.

use vanecut::geometry::Point;
use vanecut::io::step::{read_bytes, read_scene_bytes};
use vanecut::io::stl::{read_part_bytes, write_stl};
use vanecut::mesh::{MeshOptions, TriangleMesh};
use vanecut::part::SideProbe;

use crate::cad::{KJ66_COARSE, alike, apart, built};

/// Wheels of one solid, made by a script beside them: blunt cylindrical blades that lean, blades with plane
/// sides, and those with root fillets of 1.2 mm.
const WHEELS: [(&str, &[u8], f64); 3] = [
    ("open", include_bytes!("../data/step/open_wheel.step"), 0.05),
    ("plane", include_bytes!("../data/step/plane_blades.step"), 0.02),
    ("filleted", include_bytes!("../data/step/filleted_blades.step"), 0.02),
];

pub fn in_mm() -> MeshOptions {
    MeshOptions { unit: "mm".parse().ok(), ..MeshOptions::default() }
}

#[test]
fn wheels_of_one_solid_open_as_bare_triangles_where_their_surfaces_are() {
    for (name, file, limit) in WHEELS {
        let part = built(&read_bytes("wheel.step", file, &MeshOptions::default()));
        let scene = read_scene_bytes("wheel.step", file, None).expect("sound");
        let mut mesh = TriangleMesh::default();
        scene.bodies.iter().for_each(|body| mesh.append(&body.mesh));
        let stl = write_stl(&mesh.points, &mesh.triangles, name);
        let own = built(&read_part_bytes("wheel.stl", &stl, &in_mm()));
        let (hub, _) = apart(&part, &own);
        assert!(hub < 0.01, "{name}: the hub is {hub} mm off");
        let blade = alike(&own.main, &part.main, &own);
        for (side, own) in [(&part.main.suction, &blade.suction), (&part.main.pressure, &blade.pressure)] {
            let probe = SideProbe::new(side, 0.0, 1.0);
            // In the place of fillets the sides go on straight.
            let places =
                (2..=19).flat_map(|i| (3..=10).map(move |j| (0.05 * f64::from(i), 0.1 * f64::from(j))));
            let off = |(u, v)| probe.nearest_to_point(&own.point(u, v)).distance.abs();
            let sides = places.map(off).fold(0.0, f64::max);
            assert!(sides < limit, "{name}: a side is {sides} mm off");
        }
    }
}

/// Single triangles have no faces, and the blunt trailing edge is a narrow face of few of them.
#[test]
fn a_wheel_of_coarse_triangles_has_an_even_trailing_edge() {
    let mut mesh = TriangleMesh::default();
    KJ66_COARSE.bodies.iter().for_each(|body| mesh.append(&body.mesh));
    let description = read_part_bytes("kj66.stl", &write_stl(&mesh.points, &mesh.triangles, "x"), &in_mm());
    let part = built(&description);
    let jump = |note: &String| note.split_once("jumps by ")?.1.split(' ').next()?.parse::<f64>().ok();
    let jumps: Vec<f64> = description.expect("it opens").notes.iter().filter_map(jump).collect();
    assert!(jumps.iter().all(|size_mm| *size_mm < 0.15), "{jumps:?} mm");
    for side in [&part.main.suction, &part.main.pressure] {
        let radius = |v: f64| side.point(1.0, v).x.hypot(side.point(1.0, v).y);
        // The rim is a cylinder, which the edge leaves near the tip.
        let off = (1..=13).map(|k| (radius(0.05 * f64::from(k)) - 50.1).abs()).fold(0.0, f64::max);
        assert!(off < 0.03, "the trailing edge is {off} mm off the rim");
    }
}

/// A body of revolution: the closed line `outline` (r, z), mm, turned about Z.
pub fn turned(outline: &[(f64, f64)]) -> TriangleMesh {
    const SECTORS: u32 = 90;
    let n = outline.len() as u32;
    let angle = |k: u32| f64::from(k) * std::f64::consts::TAU / f64::from(SECTORS);
    let ring =
        |k: u32| outline.iter().map(move |(r, z)| Point::new(r * angle(k).cos(), r * angle(k).sin(), *z));
    let number = |k: u32, i: u32| (k % SECTORS) * n + i % n;
    let cell = |k: u32, i: u32| {
        let [a, b, c, d] = [number(k, i), number(k + 1, i), number(k + 1, i + 1), number(k, i + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..SECTORS).flat_map(|k| (0..n).flat_map(move |i| cell(k, i))).collect();
    TriangleMesh { points: (0..SECTORS).flat_map(ring).collect(), triangles }
}

/// A plate of twelve triangles, from x = 25 to 58 mm and 3 mm thick, on z = 4 mm, turned about Z.
pub fn plate(angle: f64) -> TriangleMesh {
    let corner = |k: u32| {
        let pick = |bit: u32, a: f64, b: f64| if k >> bit & 1 == 0 { a } else { b };
        let (x, y, z) = (pick(0, 25.0, 58.0), pick(1, -1.5, 1.5), pick(2, 4.0, 16.0));
        Point::new(x * angle.cos() - y * angle.sin(), x * angle.sin() + y * angle.cos(), z)
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { points: (0..8).map(corner).collect(), triangles }
}

/// Their slices have corners at their ends and next to nothing between them.
#[test]
fn plates_of_few_triangles_are_blades() {
    let mut wheel = turned(&[(8.0, 0.0), (60.0, 0.0), (60.0, 4.0), (8.0, 4.0)]);
    (0..6).for_each(|k| wheel.append(&plate(f64::from(k) * std::f64::consts::TAU / 6.0)));
    let part =
        built(&read_part_bytes("paddles.stl", &write_stl(&wheel.points, &wheel.triangles, "x"), &in_mm()));
    assert_eq!((part.blade_count, part.splitters.len()), (6, 0));
    let tip = part.shroud.point(0.5);
    assert!((tip.z - 16.0).abs() < 0.01 && (part.hub.point(0.5).z - 4.0).abs() < 0.01, "{tip:?}");
    for side in [&part.main.suction, &part.main.pressure] {
        let across = |u: f64, v: f64| {
            let p = side.point(u, v);
            let turn = (p.y.atan2(p.x) / part.pitch()).round() * part.pitch();
            (p.y * turn.cos() - p.x * turn.sin()).abs()
        };
        let off = [0.2, 0.5, 0.8].map(|u| (across(u, 0.5) - 1.5).abs()).into_iter().fold(0.0, f64::max);
        assert!(off < 0.01, "a side is {off} mm off");
    }
}
