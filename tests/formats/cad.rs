//! Parts from CAD: STEP and STL files, read and written.

use std::path::Path;
use std::sync::LazyLock;

use nalgebra::Rotation3;
use vanecut::geometry::{Meridional, MeridionalCurve, Point, Vector, rotate_z};
use vanecut::io::gltf;
use vanecut::io::step::{StepScene, read_bytes, read_scene_bytes, write_part};
use vanecut::io::stl::{read_part_bytes, write_stl};
use vanecut::io::{InputError, read_part};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{MeshOptions, Role, TriangleMesh};
use vanecut::part::{Blade, Impeller, PartDescription, SideProbe};

/// Compressor wheel of the KJ66 jet engine, from a CAD system; its licence is beside it.
const KJ66: &[u8] = include_bytes!("../data/step/kj66_impeller.step");

/// The part in it.
static KJ66_PART: LazyLock<Impeller> =
    LazyLock::new(|| built(&read_bytes("kj66.step", KJ66, &MeshOptions::default())));

/// Its bodies by coarse triangles.
pub static KJ66_COARSE: LazyLock<StepScene> =
    LazyLock::new(|| read_scene_bytes("kj66.step", KJ66, Some(0.05)).expect("sound"));

/// The same wheel as triangles, body by body.
const KJ66_MESH: &[u8] = include_bytes!("../data/wheels/kj66_cad.glb");

/// Wheels in one body with turned tips, made by the script beside them.
const OPEN_WHEEL: &[u8] = include_bytes!("../data/step/open_wheel.step");
const PLANE_BLADES: &[u8] = include_bytes!("../data/step/plane_blades.step");
/// A wheel in one body with a cover that bends about the blades, and a blade with a nose of its own.
const COVERED_WHEEL: &[u8] = include_bytes!("../data/step/covered_wheel.step");
/// The second with root fillets of 1.2 mm.
const FILLETED: &[u8] = include_bytes!("../data/step/filleted_blades.step");
const NOSE_BLADE: &[u8] = include_bytes!("../data/step/nose_blade.step");
/// A pump wheel whose hub is drawn in pieces, in one body, in several, and with blades that go on through
/// hub, cover and rim, made by the script beside them.
const PUMP_WHEEL: &[u8] = include_bytes!("../data/step/pump_wheel.step");
const PUMP_BODIES: &[u8] = include_bytes!("../data/step/pump_bodies.step");
const PUMP_COVERED: &[u8] = include_bytes!("../data/step/pump_covered.step");

/// Points of the hub of the KJ66 (r, z), of Open CASCADE's surface.
const KJ66_HUB: [(f64, f64); 11] = [
    (42.6663, 4.1065),
    (36.4429, 5.7784),
    (31.2761, 7.1478),
    (27.019, 8.4211),
    (23.5248, 9.8048),
    (20.6467, 11.5054),
    (18.2379, 13.7294),
    (16.1514, 16.6832),
    (14.2405, 20.5732),
    (12.3584, 25.606),
    (10.3582, 31.9879),
];

/// Points of both sides of the blade of median area of the KJ66, of Open CASCADE's surfaces, about Z.
const KJ66_BLADE: [[(f64, f64, f64); 10]; 2] = [
    [
        (42.5137, -24.2767, 14.5024),
        (16.4532, -30.8023, 36.102),
        (26.1108, -13.334, 10.5378),
        (24.6078, -15.0102, 15.3496),
        (39.1634, -19.8178, 11.1052),
        (20.1877, -18.196, 24.317),
        (33.7248, -24.4501, 20.1493),
        (26.8526, -29.49, 28.4876),
        (9.6401, -13.6322, 31.5602),
        (17.0808, -27.6845, 34.2644),
    ],
    [
        (34.8589, -28.1444, 23.3115),
        (16.6976, -31.9235, 37.1063),
        (36.1843, -19.225, 13.599),
        (30.5833, -23.3962, 22.1674),
        (25.9873, -13.12, 12.2545),
        (22.5088, -15.2117, 19.3988),
        (42.3254, -20.2424, 10.87),
        (27.9803, -27.783, 27.3699),
        (12.8032, -12.4633, 26.9599),
        (16.1988, -16.3485, 27.6439),
    ],
];

/// Points of Open CASCADE's surfaces of the same blade near the corner of leading edge and tip, which is
/// rounded.
const KJ66_EDGE: [(f64, f64, f64); 3] =
    [(10.0011, -27.0394, 39.6748), (9.1065, -24.9705, 39.7387), (11.5973, -26.9562, 38.2988)];

pub fn built(description: &Result<PartDescription, InputError>) -> Impeller {
    match description {
        Ok(description) => Impeller::build(description).expect("an impeller"),
        Err(error) => panic!("{error}"),
    }
}

fn sample(name: &str) -> Impeller {
    built(&read_part(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name)))
}

/// Largest distance of points of both sides of `other`, behind the nose, from those of `blade`.
fn sides_apart(blade: &Blade, other: &Blade) -> f64 {
    let sides = [(&blade.suction, &other.suction), (&blade.pressure, &other.pressure)];
    let apart = |(side, other): (&vanecut::part::BladeSide, &vanecut::part::BladeSide)| {
        let probe = SideProbe::new(side, 0.0, 1.0);
        let points = (0..=20)
            .flat_map(|i| (0..=6).map(move |j| (0.1 + 0.9 * f64::from(i) / 20.0, f64::from(j) / 6.0)));
        points.map(|(u, v)| probe.nearest_to_point(&other.point(u, v)).distance.abs()).fold(0.0, f64::max)
    };
    sides.into_iter().map(apart).fold(0.0, f64::max)
}

/// The rotation of `blade` by whole pitches that is nearest to `other`.
pub fn alike(blade: &Blade, other: &Blade, part: &Impeller) -> Blade {
    let off = |b: &Blade| (b.suction.point(0.5, 0.5) - other.suction.point(0.5, 0.5)).norm();
    let all = (0..part.blade_count).map(|k| blade.rotated(part.pitch() * k as f64));
    all.min_by(|a, b| off(a).total_cmp(&off(b))).expect("it has blades")
}

/// Largest distances of hub and blade sides of `other` from those of `part`, mm.
pub fn apart(part: &Impeller, other: &Impeller) -> (f64, f64) {
    assert_eq!((part.blade_count, part.splitters.len()), (other.blade_count, other.splitters.len()));
    let hub = (0..=100).map(|i| part.hub.curve().project(other.hub.point(f64::from(i) / 100.0)).1.abs());
    let mut sides = sides_apart(&part.main, &alike(&other.main, &part.main, other));
    for (a, b) in part.splitters.iter().zip(&other.splitters) {
        sides = sides.max(sides_apart(a, &alike(b, a, other)));
    }
    (hub.fold(0.0, f64::max), sides)
}

#[test]
fn a_wheel_from_cad_opens_without_a_question_where_its_surfaces_are() {
    let part = &*KJ66_PART;
    assert_eq!((part.blade_count, part.splitters.len()), (9, 0));
    for (r, z) in KJ66_HUB {
        let off = part.hub.curve().project(Meridional { r, z }).1.abs();
        assert!(off < 0.02, "the hub is {off} mm off at r = {r}");
    }
    let sides = [&part.main.suction, &part.main.pressure].map(|side| SideProbe::new(side, 0.0, 1.0));
    for points in KJ66_BLADE {
        let off = |probe: &SideProbe| {
            let distance = |(x, y, z)| probe.nearest_to_point(&Point::new(x, y, z)).distance.abs();
            points.into_iter().map(distance).fold(0.0, f64::max)
        };
        let nearer = off(&sides[0]).min(off(&sides[1]));
        assert!(nearer < 0.02, "a side of the blade is {nearer} mm off");
    }
    for (x, y, z) in KJ66_EDGE {
        let off = |probe: &SideProbe| probe.nearest_to_point(&Point::new(x, y, z)).distance.abs();
        let nearer = off(&sides[0]).min(off(&sides[1]));
        assert!(nearer < 0.01, "the blade is {nearer} mm off where its leading edge turns into the tip");
    }
}

/// The tips are known by their faces, of which the file says nothing by name, and the hub begins parallel to
/// the axis, so that its inlet circle is on a seam of its torus.
#[test]
fn the_same_wheel_as_triangles_opens_where_they_are() {
    // One of its bodies is a splinter far beside the wheel, which is 100.19 mm across.
    let in_metres = gltf::read_bytes("kj66.glb", KJ66_MESH, &MeshOptions::default()).expect_err("100 m");
    assert!(in_metres.to_string().contains("--unit mm (100.19"), "{in_metres}");
    let options = MeshOptions { unit: "mm".parse().ok(), ..MeshOptions::default() };
    let part = built(&gltf::read_bytes("kj66.glb", KJ66_MESH, &options));
    assert_eq!((part.blade_count, part.splitters.len()), (9, 0));
    for (r, z) in KJ66_HUB {
        let off = part.hub.curve().project(Meridional { r, z }).1.abs();
        assert!(off < 0.02, "the hub is {off} mm off at r = {r}");
    }
    let sides = [&part.main.suction, &part.main.pressure].map(|side| SideProbe::new(side, 0.0, 1.0));
    for (x, y, z) in KJ66_BLADE.into_iter().flatten() {
        let off = |probe: &SideProbe| probe.nearest_to_point(&Point::new(x, y, z)).distance.abs();
        let nearer = off(&sides[0]).min(off(&sides[1]));
        assert!(nearer < 0.05, "the blade is {nearer} mm off at ({x}, {y}, {z})");
    }
    // Its tips, which wave, make all of the shroud, from the leading edge to where they turn down at the rim.
    let (first, last) = (part.shroud.point(0.0), part.shroud.point(1.0));
    assert!(first.z > 39.0 && last.r > 47.5, "from {first:?} to {last:?}");
}

#[test]
fn a_cover_that_bends_about_the_blades_is_one() {
    let part = built(&read_bytes("covered.step", COVERED_WHEEL, &MeshOptions::default()));
    assert_eq!(part.blade_count, 3);
    // The shroud is an arc of radius 18 about (50, 27).
    for k in 0..=10 {
        let p = part.shroud.point(f64::from(k) / 10.0);
        let off = f64::hypot(p.r - 50.0, p.z - 27.0) - 18.0;
        assert!(off.abs() < 0.02, "the shroud is {off} mm off at r = {}", p.r);
    }
}

#[test]
fn a_narrow_round_face_is_round() {
    let scene = read_scene_bytes("nose.step", NOSE_BLADE, None).expect("sound");
    assert!(scene.notes().is_empty(), "{:?}", scene.notes());
    // Half way up the nose is at x = 0; between the seams of its face it would be at 2 to 4 mm.
    let mesh = &scene.bodies[0].mesh;
    let edges = mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let met = edges.filter_map(|(i, j)| {
        let (a, b) = (mesh.points[i as usize], mesh.points[j as usize]);
        let share = (15.0 - a.z) / (b.z - a.z);
        (0.0..=1.0).contains(&share).then(|| a.x + (b.x - a.x) * share)
    });
    let foremost = met.fold(f64::INFINITY, f64::min);
    assert!(foremost.abs() < 0.02, "the nose is at {foremost} mm");
}

#[test]
fn an_open_wheel_in_one_body_has_its_shroud_at_its_turned_tips() {
    let description = read_bytes("open_wheel.step", OPEN_WHEEL, &MeshOptions::default());
    assert_eq!(description.as_ref().map(|part| part.notes.clone()), Ok(Vec::new()));
    let part = built(&description);
    assert_eq!((part.blade_count, part.splitters.len()), (3, 0));
    for (name, curve, middle, radius) in
        [("hub", &part.hub, 40.0, 36.0), ("shroud", &part.shroud, 27.0, 18.0)]
    {
        let points = (0..=100).map(|k| curve.point(f64::from(k) / 100.0));
        let off = |p: Meridional| ((p.r - 50.0).hypot(p.z - middle) - radius).abs();
        assert!(points.map(off).fold(0.0, f64::max) < 1e-3, "{name}");
        // From the leading edge, which is straight across the blade, to the rim.
        assert!((curve.point(0.0).r - 39.992).abs() < 0.01, "{name}: from r = {}", curve.point(0.0).r);
        assert!((curve.point(1.0).r - 50.0).abs() < 5e-3, "{name}: to r = {}", curve.point(1.0).r);
    }
    for v in [0.0, 0.5, 1.0] {
        let [leading, trailing] =
            [0.0, 1.0].map(|u| Meridional::from_point(&part.main.suction.point(u, v)).r);
        assert!((leading - 40.0).abs() < 0.1 && (trailing - 50.0).abs() < 0.01, "{v}: {leading}, {trailing}");
    }
}

/// The face of the trailing edge goes on below the edge of the hub, in its rim. The blade is blunt, tapered.
#[test]
fn a_trailing_edge_that_goes_on_below_the_rim_is_cut_at_the_hub() {
    let part = built(&read_bytes("plane_blades.step", PLANE_BLADES, &MeshOptions::default()));
    assert_eq!((part.blade_count, part.splitters.len()), (3, 0));
    // The planes of the sides as the script has them: through (40, y, 3.4), 2 mm less at x = 56, and by z.
    let off = |p: &Point, y: f64, by_z: f64| {
        let across = |p: Point| p.y - (y - 2.0 * (p.x - 40.0) / 16.0 + by_z * (p.z - 3.4));
        (0..3).map(|k| across(rotate_z(p, part.pitch() * f64::from(k))).abs()).fold(f64::INFINITY, f64::min)
    };
    for side in [&part.main.suction, &part.main.pressure] {
        // From behind the corner of the blunt leading edge on.
        let points: Vec<Point> = (0..=20)
            .flat_map(|i| (0..=20).map(move |j| (0.4 + 0.03 * f64::from(i), f64::from(j) / 20.0)))
            .map(|(u, v)| side.point(u, v))
            .collect();
        let farthest = |y: f64, by_z: f64| points.iter().map(|p| off(p, y, by_z)).fold(0.0, f64::max);
        let nearer = farthest(-1.4, 0.9 / 27.6).min(farthest(1.2, -0.2 / 27.6));
        assert!(nearer < 0.01, "a side is {nearer} mm off its plane");
        let rim = [0.0, 0.5, 1.0].map(|v| Meridional::from_point(&side.point(1.0, v)).r);
        assert!(rim.iter().all(|r| (r - 50.0).abs() < 0.01), "{rim:?}");
    }
}

/// The faces of blunt ends and sides are one smooth patch by way of the fillet below them.
#[test]
fn blunt_blades_with_root_fillets_keep_their_edges() {
    let description = read_bytes("filleted.step", FILLETED, &MeshOptions::default());
    let notes = description.as_ref().map(|part| part.notes.join("; ")).expect("sound");
    assert!(!notes.contains("jumps"), "{notes}");
    let part = built(&description);
    assert_eq!((part.blade_count, part.splitters.len()), (3, 0));
    // The leading edge is the middle of the plane x = 40 mm, and the sides are planes, as without fillets.
    let least = |of: &dyn Fn(Point) -> f64, p: Point| {
        (0..3).map(|k| of(rotate_z(&p, part.pitch() * f64::from(k))).abs()).fold(f64::INFINITY, f64::min)
    };
    for side in [&part.main.suction, &part.main.pressure] {
        let across =
            |y: f64, by_z: f64| move |p: Point| p.y - (y - 2.0 * (p.x - 40.0) / 16.0 + by_z * (p.z - 3.4));
        let off = |y: f64, by_z: f64| {
            let places = (0..=30).flat_map(|i| (0..=10).map(move |j| (0.4 + 0.02 * f64::from(i), j)));
            let points = places.map(|(u, j)| side.point(u, f64::from(j) / 10.0));
            points.map(|p| least(&across(y, by_z), p)).fold(0.0, f64::max)
        };
        let nearer = off(-1.4, 0.9 / 27.6).min(off(1.2, -0.2 / 27.6));
        assert!(nearer < 0.02, "a side is {nearer} mm off its plane");
        for v in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let ahead = least(&|p: Point| (p.x - 40.0).hypot(p.y + 0.15), side.point(0.0, v));
            assert!(ahead < 0.25, "{v}: the leading edge is {ahead} mm off");
        }
    }
}

/// The hub is drawn in pieces: cylinder, torus, disc. As bodies, it ends in a rim at which the blades end,
/// too.
#[test]
fn a_hub_of_several_faces_is_one_curve() {
    let cuts = ["into the hub", "into the cover", "past the rim of hub and cover"];
    // Where blades are cut off, new corners on the long lines of their sides are known by their ends only.
    for (name, bytes, expected, limit) in [
        ("pump_wheel.step", PUMP_WHEEL, &[][..], 5e-3),
        ("pump_bodies.step", PUMP_BODIES, &[], 5e-3),
        ("pump_covered.step", PUMP_COVERED, &cuts, 0.01),
    ] {
        let description = read_bytes(name, bytes, &MeshOptions::default());
        let notes = description.as_ref().map(|part| part.notes.clone()).expect(name);
        let is_said =
            |(note, place): (&String, &&str)| note.ends_with(&format!("{place}; they are cut off there"));
        assert!(
            notes.len() == expected.len() && notes.iter().zip(expected).all(is_said),
            "{name}: {notes:?}"
        );
        let part = built(&description);
        assert_eq!((part.blade_count, part.splitters.len()), (5, 0), "{name}");
        // Along the blades the hub is a plane, whose ends differ by rounding.
        assert_eq!(part.out_of_inlet().z, 1.0, "{name}");
        let off_hub = |p: Meridional| match (p.z > 40.0, p.r < 48.0) {
            (true, _) => p.r - 18.0,
            (_, true) => (p.r - 48.0).hypot(p.z - 40.0) - 30.0,
            _ => p.z - 10.0,
        };
        // From the cone z = 62 − 0.4 r, at right angles to it.
        let off_shroud = |p: Meridional| (p.z + 0.4 * p.r - 62.0) / 1.16_f64.sqrt();
        let farthest = |curve: &MeridionalCurve, off: &dyn Fn(Meridional) -> f64| {
            let points = (0..=400).map(|k| curve.point(curve.length() * f64::from(k) / 400.0));
            points.map(|p| off(p).abs()).fold(0.0, f64::max)
        };
        assert!(farthest(part.hub.curve(), &off_hub) < 2e-3, "{name}");
        assert!(farthest(part.shroud.curve(), &off_shroud) < 2e-3, "{name}");
        // The sides are arcs of 55.5 and 60.5 mm about an axis 60 mm beside that of the wheel.
        for side in [&part.main.suction, &part.main.pressure] {
            let off = |p: &Point, radius: f64| {
                let from_arc = |k: u32| {
                    let p = rotate_z(p, part.pitch() * f64::from(k));
                    ((p.x - 60.0).hypot(p.y) - radius).abs()
                };
                (0..5).map(from_arc).fold(f64::INFINITY, f64::min)
            };
            let points: Vec<Point> = (0..=20)
                .flat_map(|i| (0..=20).map(move |j| (0.2 + 0.04 * f64::from(i), f64::from(j) / 20.0)))
                .map(|(u, v)| side.point(u, v))
                .collect();
            let most = |radius: f64| points.iter().map(|p| off(p, radius)).fold(0.0, f64::max);
            let nearer = most(55.5).min(most(60.5));
            assert!(nearer < limit, "{name}: a side is {nearer} mm off its arc");
            let rim = [0.0, 0.5, 1.0].map(|v| Meridional::from_point(&side.point(1.0, v)).r);
            assert!(rim.iter().all(|r| (r - 100.0).abs() < 0.01), "{name}: {rim:?}");
        }
    }
}

#[test]
fn bodies_are_closed_at_any_fineness() {
    let fine = read_scene_bytes("kj66.step", KJ66, Some(0.005)).expect("sound");
    for (chord, scene) in [(0.05, &*KJ66_COARSE), (0.005, &fine)] {
        assert!(scene.notes().is_empty(), "{:?}", scene.notes());
        assert!(scene.bodies.iter().all(|body| body.solid && body.open_edges == 0), "at {chord} mm");
    }
}

#[test]
fn a_part_written_as_step_is_the_same_part() {
    let part = sample("impeller9x9.toml");
    let text = write_part(&part, "a.step");
    assert!(text.contains("AUTOMOTIVE_DESIGN") && text.is_ascii());
    let scene = read_scene_bytes("a.step", text.as_bytes(), Some(0.05)).expect("sound");
    assert!(scene.notes().is_empty(), "{:?}", scene.notes());
    assert_eq!(scene.bodies.iter().filter(|body| body.solid).count(), 19);
    for body in scene.bodies.iter().filter(|body| body.solid) {
        let corner = |i: u32| body.mesh.points[i as usize].coords;
        let sixfold: f64 =
            body.mesh.triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| a.dot(&b.cross(&c))).sum();
        assert!(sixfold > 0.0, "`{}` is inside out", body.name);
    }
    let (hub, sides) = apart(&part, &built(&read_bytes("a.step", text.as_bytes(), &MeshOptions::default())));
    assert!(hub < LIMIT && sides < NOSE_LIMIT, "hub {hub}, sides {sides} mm");
}

#[test]
#[ignore = "reads a large STEP file; scripts/nightly runs it"]
fn blades_that_go_on_past_the_ends_of_their_shroud_are_written_closed() {
    let part = &*KJ66_PART;
    let (tip, end) = (Meridional::from_point(&part.main.suction.point(1.0, 1.0)), part.shroud.point(1.0));
    assert!(tip.distance(end) > 0.5, "it goes on past it");
    let text = write_part(part, "a.step");
    let description = read_bytes("a.step", text.as_bytes(), &MeshOptions::default());
    // The notes of a part begin with those of its bodies.
    let notes = description.as_ref().map(|part| part.notes.join("; ")).expect("sound");
    assert!(!notes.contains("is not closed") && !notes.contains("is not whole"), "{notes}");
    // The hub goes on below their feet, and its shroud sheet ends where the tips turn into the edges.
    let again = built(&description);
    let (_, sides) = apart(part, &again);
    let off = |k: i32| again.hub.curve().project(part.hub.point(f64::from(k) / 100.0)).1.abs();
    let hub = (0..=100).map(off).fold(0.0, f64::max);
    assert!(hub < LIMIT && sides < 0.05, "hub {hub}, sides {sides} mm");
}

/// Largest distance of a part from itself after it was written and read, mm.
const LIMIT: f64 = 1e-3;
/// The same with the noses of its blades: those are fitted anew through sections of triangles.
const NOSE_LIMIT: f64 = 0.01;

#[test]
fn a_wheel_in_one_stl_opens_in_any_position_and_unit() {
    let part = sample("impeller9x9.toml");
    // Coarser than by default: the corners lie on the part.
    let shape = Tessellation::new(&part, &Fineness { chord_error: 0.02, ..Fineness::default() });
    let mut whole = shape.hub.mesh();
    for blade in [&shape.main, &shape.splitters[0]] {
        let mesh = blade.mesh();
        for k in 0..part.blade_count {
            let turn = part.pitch() * k as f64;
            let points = mesh.points.iter().map(|p| rotate_z(p, turn)).collect();
            whole.append(&TriangleMesh { points, triangles: mesh.triangles.clone() });
        }
    }
    let options = MeshOptions { rotation: Some(part.rotation()), ..MeshOptions::default() };
    let named = |name: &str, mesh: &TriangleMesh, options: &MeshOptions| {
        built(&read_part_bytes(name, &write_stl(&mesh.points, &mesh.triangles, "a"), options))
    };
    let read = |mesh: &TriangleMesh, options: &MeshOptions| named("a.stl", mesh, options);
    // The name of the file does not give the mesh a role.
    for name in ["a.stl", "hub.stl", "bladed disc.stl", "Impeller with cover.stl"] {
        let (hub, sides) = apart(&part, &named(name, &whole, &options));
        assert!(hub < 0.02 && sides < 0.02, "{name}: hub {hub}, sides {sides} mm");
    }
    // Inches, about an axis off the origin.
    let turn = Rotation3::from_axis_angle(&Vector::x_axis(), 0.5 * std::f64::consts::PI);
    let moved = whole.points.iter().map(|p| turn * p * (1.0 / 25.4)).collect();
    let moved = TriangleMesh { points: moved, triangles: whole.triangles };
    let inches = MeshOptions { unit: "in".parse().ok(), ..options };
    let other = read(&moved, &inches);
    assert!((other.rim_radius() - part.rim_radius()).abs() < 0.01, "{}", other.rim_radius());
}

#[test]
fn files_cut_off_or_changed_are_refused_in_one_line_or_read() {
    let part = sample("pump6.toml");
    let whole = write_part(&part, "a.step").into_bytes();
    let mut state = 7_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..6 {
        let error = read_scene_bytes("a.step", &whole[..next(whole.len() - 40)], Some(1.0));
        assert_eq!(error.expect_err("cut off").to_string().lines().count(), 1);
    }
    // In the middle of a reference the message has nothing to quote.
    let mark = whole.iter().rposition(|byte| *byte == b'#').expect("a reference");
    let error = read_scene_bytes("a.step", &whole[..=mark], Some(1.0)).expect_err("cut off").to_string();
    assert!(error.contains("the file ends instead of the number of an instance"), "{error}");
    for _ in 0..12 {
        let mut bytes = whole.clone();
        for _ in 0..=next(3) {
            let at = next(bytes.len());
            bytes[at] = b"0123456789#,.()'$*-E;"[next(21)];
        }
        if let Err(error) = read_scene_bytes("a.step", &bytes, Some(1.0)) {
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
    }
}

#[test]
fn a_body_without_a_name_has_that_of_its_product_and_a_mark_in_front_is_skipped() {
    let part = sample("pump6.toml");
    let text = write_part(&part, "a.step");
    let start = text.find("MANIFOLD_SOLID_BREP(").expect("a solid");
    let end = start + text[start..].find(',').expect("its shell");
    let unnamed = format!("\u{feff}{}MANIFOLD_SOLID_BREP(''{}", &text[..start], &text[end..]);
    let scene = read_scene_bytes("a.step", unnamed.as_bytes(), Some(1.0)).expect("sound");
    let names: Vec<String> = scene.into_meshes().into_iter().map(|mesh| mesh.name).collect();
    assert!(names.contains(&part.name) && names.iter().all(|name| !name.starts_with('#')), "{names:?}");
}

#[test]
fn a_refusal_says_what_was_not_whole() {
    let part = sample("pump6.toml");
    let text = write_part(&part, "a.step");
    // One face less, and a role for a body that is not there.
    let start = text.find("CLOSED_SHELL(").expect("a shell");
    let from = start + text[start..].find('#').expect("a face");
    let to = from + text[from..].find(',').expect("more faces") + 1;
    let open = format!("{}{}", &text[..from], &text[to..]);
    let options = MeshOptions { roles: vec![("nut".to_owned(), Role::Ignored)], ..MeshOptions::default() };
    let refused = |text: &str| read_bytes("a.step", text.as_bytes(), &options).expect_err("no such body");
    let (whole, open) = (refused(&text).to_string(), refused(&open).to_string());
    assert!(open.contains("is not closed") && !whole.contains("is not closed"), "{whole} / {open}");
    assert_eq!(open.lines().count(), 1);
}
