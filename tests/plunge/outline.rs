//! Turned bodies by their outline, and the turned envelope of meshes: against plain searches.

use vanecut::geometry::{Circle, Meridional, Point, Vector};
use vanecut::part::{BlankFile, BlankMesh, MeridionalOutline, OutlineFault};

/// Deterministic pseudorandom numbers.
struct Dice(u64);

impl Dice {
    fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn axis(&mut self) -> Vector {
        Vector::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-0.3, 1.0))
            .try_normalize(1e-3)
            .unwrap_or_else(Vector::z)
    }

    fn point(&mut self) -> Point {
        Point::new(self.between(-60.0, 60.0), self.between(-60.0, 60.0), self.between(-30.0, 60.0))
    }
}

fn outline_from(points: &[[f64; 2]]) -> Result<MeridionalOutline, OutlineFault> {
    let points: Vec<Meridional> = points.iter().map(|p| Meridional { r: p[0], z: p[1] }).collect();
    MeridionalOutline::new(&points)
}

/// A cylinder, a stepped blank, one with a hollow front and a bore, and one of many short edges.
fn samples() -> Vec<MeridionalOutline> {
    let arc: Vec<[f64; 2]> = (0..=300)
        .map(|i| {
            let phi = std::f64::consts::FRAC_PI_2 * f64::from(i) / 300.0;
            [50.0 - 25.0 * phi.sin(), 30.0 - 25.0 * phi.cos()]
        })
        .chain([[8.0, 30.0], [8.0, -10.0], [50.0, -10.0], [50.0, 5.0]])
        .collect();
    [
        outline_from(&[[0.0, 30.0], [45.0, 30.0], [45.0, -5.0], [0.0, -5.0]]),
        outline_from(&[[20.0, 40.0], [20.0, 25.0], [32.0, 22.0], [50.0, 4.0], [50.0, -6.0]]),
        outline_from(&[
            [10.0, 0.0],
            [48.0, 0.0],
            [50.0, 20.0],
            [40.0, 35.0],
            [30.0, 12.0],
            [10.0, 30.0],
            [10.0, 0.0],
        ]),
        outline_from(&arc),
    ]
    .map(|outline| outline.expect("an outline"))
    .to_vec()
}

/// Inside by the winding of the outline about the point.
fn winds_about(outline: &MeridionalOutline, p: Meridional) -> bool {
    let points = outline.points();
    let turns = points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| {
        let (u, v) = ((a.r - p.r, a.z - p.z), (b.r - p.r, b.z - p.z));
        (u.0 * v.1 - u.1 * v.0).atan2(u.0 * v.0 + u.1 * v.1)
    });
    turns.sum::<f64>().abs() > 3.0
}

#[test]
fn distances_and_insides_are_those_of_a_plain_search() {
    let mut dice = Dice(3);
    for outline in samples() {
        let points = outline.points();
        for _ in 0..3000 {
            let p = Meridional { r: dice.between(0.0, 70.0), z: dice.between(-30.0, 60.0) };
            let mut distance = f64::INFINITY;
            for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
                if a.r > 0.0 || b.r > 0.0 {
                    let steps = 200;
                    let near = (0..=steps).map(|k| p.distance(a.lerp(*b, f64::from(k) / f64::from(steps))));
                    let near = near.fold(f64::INFINITY, f64::min);
                    distance = distance.min(near);
                }
            }
            let (found, foot) = outline.signed_distance(p);
            assert!((p.distance(foot) - found.abs()).abs() < 1e-9);
            assert!(
                found.abs() <= distance + 1e-9 && found.abs() > distance - 0.3,
                "{p:?}: {found} {distance}"
            );
            assert_eq!(found < 0.0, winds_about(&outline, p), "{p:?}");
        }
    }
}

#[test]
fn lines_enter_where_a_fine_scan_says() {
    let mut dice = Dice(5);
    let mut met = 0;
    for outline in samples() {
        for _ in 0..400 {
            let (origin, axis) = (dice.point(), dice.axis());
            let found = outline.highest_inside(&origin, &axis, -100.0, 100.0);
            let is_in = |h: f64| outline.contains(Meridional::from_point(&(origin + axis * h)));
            let step = 0.01;
            let scanned = (0..20_000).map(|k| 100.0 - step * f64::from(k)).find(|h| is_in(*h));
            match (found, scanned) {
                (Some(a), Some(b)) => assert!(a >= b - 1e-9 && a < b + step + 1e-9, "{a} {b}"),
                // A chord shorter than a step of the scan.
                (Some(a), None) => assert!(is_in(a - 1e-6) && !is_in(a - 2.0 * step), "{a}"),
                (a, b) => assert_eq!(a, b, "{origin:?} {axis:?}"),
            }
            met += usize::from(found.is_some());
        }
    }
    assert!(met > 400, "{met} lines met a body");
}

#[test]
fn a_disc_touches_where_a_dense_disc_of_lines_does() {
    let mut dice = Dice(11);
    let mut met = 0;
    for outline in samples() {
        for _ in 0..60 {
            let (centre, axis, radius) = (dice.point(), dice.axis(), dice.between(1.0, 16.0));
            let range = (-150.0, 150.0);
            let found = outline.touch_height(&centre, &axis, (radius, 0.0), range);
            let mut dense = f64::NEG_INFINITY;
            for ring in 0..=24 {
                let circle = Circle::new(&centre, &axis, radius * f64::from(ring) / 24.0);
                for k in 0..120 {
                    let phi = std::f64::consts::TAU * f64::from(k) / 120.0;
                    let from = circle.point_and_derivative(phi.sin_cos()).0;
                    let height = outline.highest_inside(&from, &axis, range.0, range.1);
                    dense = dense.max(height.unwrap_or(f64::NEG_INFINITY));
                }
            }
            match found {
                None => assert!(dense == f64::NEG_INFINITY, "{centre:?} {axis:?} {radius}: {dense}"),
                Some(found) => {
                    assert!(found > dense - 0.02 * radius, "{centre:?} {axis:?} {radius}: {found} {dense}");
                    let higher = found - dense;
                    assert!(higher < 2.0 * radius || dense == f64::NEG_INFINITY, "{found} {dense}");
                    met += 1;
                }
            }
            // Raised by an offset the touch is higher by at least that.
            let raised = outline.touch_height(&centre, &axis, (radius, 2.0), range);
            if let Some(found) = found {
                assert!(raised.is_some_and(|raised| raised > found + 1.99), "{raised:?} {found}");
            }
        }
    }
    assert!(met > 60, "{met} discs met a body");
}

#[test]
fn what_bounds_no_body_is_refused() {
    assert_eq!(outline_from(&[[5.0, 1.0]]), Err(OutlineFault::TooFew(1)));
    assert_eq!(outline_from(&[[5.0, 1.0], [5.0, 1.0]]), Err(OutlineFault::TooFew(1)));
    assert_eq!(outline_from(&[[5.0, 1.0], [f64::NAN, 1.0], [5.0, 3.0]]), Err(OutlineFault::NoPoint(2)));
    assert_eq!(outline_from(&[[5.0, 1.0], [-2.0, 1.0]]), Err(OutlineFault::NoPoint(2)));
    assert_eq!(outline_from(&[[5.0, 1.0], [9.0, 1.0]]), Err(OutlineFault::Flat));
    let crossed = outline_from(&[[1.0, 0.0], [5.0, 4.0], [5.0, 0.0], [1.0, 6.0], [1.0, 0.0]]);
    let Err(OutlineFault::Crossed { r, z }) = crossed else { panic!("{crossed:?}") };
    assert!((r - 3.4).abs() < 1e-9 && (z - 2.4).abs() < 1e-9, "r {r}, z {z}");
    assert!(matches!(outline_from(&vec![[1.0, 2.0]; 5000]), Err(OutlineFault::TooMany(5000))));
}

/// A block of half-widths `x`, `y` between heights 0 and `z`.
fn block(x: f64, y: f64, z: f64) -> BlankMesh {
    let points = (0..8).map(|k| {
        let side = |bit: usize, size: f64| if k >> bit & 1 == 1 { size } else { -size };
        Point::new(side(0, x), side(1, y), if k >> 2 & 1 == 1 { z } else { 0.0 })
    });
    let triangles = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    BlankMesh { points: points.collect(), triangles }
}

#[test]
fn the_envelope_of_a_block_is_the_cylinder_through_its_corners() {
    let outline = BlankFile::envelope(&block(30.0, 40.0, 12.0)).expect("an envelope");
    let (radius, z) = outline.bounds();
    assert!((radius - 50.0).abs() < 1e-9 && z == (0.0, 12.0), "{radius} {z:?}");
    for (r, z, distance) in [(0.0, 6.0, -6.0), (49.0, 6.0, -1.0), (53.0, 16.0, 5.0), (20.0, 13.0, 1.0)] {
        let found = outline.signed_distance(Meridional { r, z }).0;
        assert!((found - distance).abs() < 1e-6, "r {r}, z {z}: {found}");
    }
}

#[test]
fn the_envelope_encloses_every_point_of_a_tilted_block() {
    let mut mesh = block(20.0, 8.0, 15.0);
    for p in &mut mesh.points {
        let (sin, cos) = 0.6f64.sin_cos();
        *p = Point::new(p.x * cos - p.z * sin + 3.0, p.y + 2.0, p.x * sin + p.z * cos);
    }
    let outline = BlankFile::envelope(&mesh).expect("an envelope");
    let mut least = f64::INFINITY;
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.points[i as usize]);
        for i in 0..=20 {
            for j in 0..=20 - i {
                let p = a + (b - a) * (f64::from(i) / 20.0) + (c - a) * (f64::from(j) / 20.0);
                let out = outline.signed_distance(Meridional::from_point(&p)).0;
                assert!(out < 5e-3, "{p} is {out} mm outside");
                least = least.min(-out);
            }
        }
    }
    assert!(least < 0.05, "it is close: {least}");
}
