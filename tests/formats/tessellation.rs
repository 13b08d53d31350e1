//! Triangles of the sample parts: closed, on the surfaces, no further from them than the chord error.

use std::collections::HashMap;
use std::path::Path;

use vanecut::geometry::{Meridional, Point, Vector, rotate_z};
use vanecut::io::part_file::read_part;
use vanecut::mesh::TriangleMesh;
use vanecut::mesh::solid::{FaceKind, Solid};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::part::{Blade, Impeller, SideProbe};

const SAMPLES: [&str; 3] = ["impeller532.toml", "impeller9x9.toml", "pump6.toml"];

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    let description = read_part(&path).expect("sample parts are readable");
    Impeller::build(&description).expect("sample parts are impellers")
}

fn at(chord_error: f64) -> Fineness {
    Fineness { chord_error, ..Fineness::default() }
}

/// Number of times each edge occurs, forwards and backwards.
fn passes(mesh: &TriangleMesh) -> HashMap<(u32, u32), (u32, u32)> {
    let mut passes: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let count = passes.entry((p.min(q), p.max(q))).or_default();
            *if p < q { &mut count.0 } else { &mut count.1 } += 1;
        }
    }
    passes
}

fn closed_bodies(t: &Tessellation) -> Vec<(&'static str, &Solid)> {
    let mut all = vec![("hub", &t.hub), ("main", &t.main)];
    all.extend(t.splitters.iter().map(|s| ("splitter", s)));
    all
}

#[test]
fn hub_and_blades_are_closed_and_face_outwards_at_any_fineness() {
    for name in SAMPLES {
        let part = sample(name);
        for chord_error in [2.0, 0.1, 0.01] {
            let t = Tessellation::new(&part, &at(chord_error));
            assert_eq!(t.chord_error, chord_error);
            for (body, solid) in closed_bodies(&t) {
                for (edge, count) in passes(&solid.mesh()) {
                    assert_eq!(count, (1, 1), "{name} {body} at {chord_error}: edge {edge:?}");
                }
                assert!(solid.volume_sixfold() > 0.0, "{name} {body} faces inwards");
            }
            let once = passes(&t.shroud.mesh()).values().filter(|c| **c != (1, 1)).count();
            let rings = t.shroud.mesh().points.iter().filter(|p| on_end(&part, p)).count();
            assert_eq!(once, rings, "{name}: the shroud is open at its two ends only");
        }
    }
}

fn on_end(part: &Impeller, p: &Point) -> bool {
    let nose = part.shroud.wheel_from();
    [nose, 1.0].iter().any(|&s| part.shroud.point(s).distance(Meridional::from_point(p)) < 1e-6)
}

#[test]
fn corners_lie_on_the_surfaces_and_triangles_within_the_chord_error() {
    for name in SAMPLES {
        let part = sample(name);
        for chord_error in [0.3, 0.05, 0.01] {
            let t = Tessellation::new(&part, &at(chord_error));
            let mut blades = vec![(&t.main, &part.main)];
            blades.extend(t.splitters.iter().zip(&part.splitters));
            let mut worst: HashMap<&str, f64> = HashMap::new();
            for solid in [&t.hub, &t.shroud] {
                measure(&part, solid, None, chord_error, &mut worst);
            }
            for (solid, blade) in blades {
                measure(&part, solid, Some(blade), chord_error, &mut worst);
            }
            let mut worst: Vec<_> = worst.into_iter().collect();
            worst.sort_by(|a, b| a.0.cmp(b.0));
            println!("{name} at {chord_error}: {} triangles, {worst:.4?}", t.triangle_count());
        }
    }
}

/// Checks corners, and points all over the triangles, of every face whose exact surface the part has.
fn measure(
    part: &Impeller,
    solid: &Solid,
    blade: Option<&Blade>,
    chord_error: f64,
    worst: &mut HashMap<&'static str, f64>,
) {
    let probes = blade.map(|b| [&b.suction, &b.pressure].map(|side| SideProbe::new(side, 0.0, 1.0)));
    for face in &solid.faces {
        let revolved = |curve: &vanecut::geometry::MeridionalCurve, p: &Point| {
            curve.project(Meridional::from_point(p)).1.abs()
        };
        let distance = |p: &Point| match face.kind {
            FaceKind::Hub | FaceKind::Foot => Some(revolved(part.hub.curve(), p)),
            FaceKind::Shroud | FaceKind::Tip => Some(revolved(part.shroud.curve(), p)),
            FaceKind::Suction => probes.as_ref().map(|probes| probes[0].nearest_to_point(p).distance.abs()),
            FaceKind::Pressure => probes.as_ref().map(|probes| probes[1].nearest_to_point(p).distance.abs()),
            // Rings about the axis, and edges that are straight between the sides.
            FaceKind::Body | FaceKind::LeadingEdge | FaceKind::TrailingEdge => None,
        };
        // Sides are trimmed to hub and shroud at the points of their sections, and foot and tip end with
        // them; near a nose, the probe of a side has the same accuracy.
        let exact = if matches!(face.kind, FaceKind::Hub | FaceKind::Shroud) { 1e-9 } else { 1e-3 };
        for corner in &face.corners {
            let off = distance(&solid.points[corner.point as usize]).unwrap_or(0.0);
            assert!(off < exact, "{:?}: a corner is {off} mm off", face.kind);
            assert!((corner.normal.norm() - 1.0).abs() < 1e-9, "{:?}: normals have length 1", face.kind);
        }
        let stride = (face.triangles.len() / 4000).max(1);
        for triangle in face.triangles.iter().step_by(stride) {
            let [a, b, c] = triangle.map(|k| solid.points[face.corners[k as usize].point as usize]);
            for (x, y) in [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (1.0 / 3.0, 1.0 / 3.0), (0.2, 0.6), (0.6, 0.2)]
            {
                let p = a + (b - a) * x + (c - a) * y;
                let off = distance(&p).unwrap_or(0.0);
                assert!(off <= chord_error, "{:?} is {off} mm off, allowed {chord_error}", face.kind);
                let most = worst.entry(name_of(face.kind)).or_default();
                *most = most.max(off);
            }
        }
    }
}

fn name_of(kind: FaceKind) -> &'static str {
    match kind {
        FaceKind::Hub => "hub",
        FaceKind::Body => "body",
        FaceKind::Shroud => "shroud",
        FaceKind::Suction => "suction",
        FaceKind::Pressure => "pressure",
        FaceKind::Tip => "tip",
        FaceKind::Foot => "foot",
        FaceKind::LeadingEdge => "leading edge",
        FaceKind::TrailingEdge => "trailing edge",
    }
}

#[test]
fn normals_point_where_the_surfaces_do() {
    let part = sample("impeller9x9.toml");
    let t = Tessellation::new(&part, &at(0.05));
    for (solid, least) in [(&t.hub, 0.999), (&t.shroud, 0.999), (&t.main, 0.9), (&t.splitters[0], 0.9)] {
        for face in &solid.faces {
            let at = |k: u32| solid.points[face.corners[k as usize].point as usize];
            for triangle in &face.triangles {
                let [a, b, c] = triangle.map(at);
                let area: Vector = (b - a).cross(&(c - a));
                let mean: Vector = triangle.iter().map(|&k| face.corners[k as usize].normal).sum::<Vector>();
                let agreement = area.normalize().dot(&mean.normalize());
                assert!(agreement > least || area.norm() < 1e-4, "{:?}: {agreement}", face.kind);
            }
        }
    }
    let down = t.shroud.faces[0].corners[0];
    let p = t.shroud.points[down.point as usize];
    let outer = part.shroud.normal(part.shroud.wheel_from());
    let turned = rotate_z(&p, -p.y.atan2(p.x));
    assert!(turned.y.abs() < 1e-9);
    assert!(down.normal.dot(&outer.direction_at_angle(p.y.atan2(p.x))) > 0.999, "away from the hub");
}

#[test]
fn too_many_triangles_make_it_coarser_and_it_says_so() {
    let part = sample("pump6.toml");
    let asked = Fineness { chord_error: 1e-4, max_triangles: 40_000 };
    let t = Tessellation::new(&part, &asked);
    assert!(t.triangle_count() <= 40_000, "{} triangles", t.triangle_count());
    assert!(t.chord_error > 1e-3, "chord error {}", t.chord_error);
}
