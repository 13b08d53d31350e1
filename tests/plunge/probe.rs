//! Nearest distances between cutters and blade sides, compared with a dense scan.

use std::path::Path;

use vanecut::geometry::{CutterSolid, Point, Vector};
use vanecut::io::part_file::read_part;
use vanecut::part::{BladeSide, Channel, Impeller, SideProbe};

use super::samples::{SAMPLES, sample};

#[test]
fn nearest_is_never_beaten_by_a_dense_scan() {
    let part = sample("impeller532");
    let channel = Channel::from_part(&part);
    for (k, side) in channel.sides.iter().enumerate() {
        let probe = SideProbe::new(side, 0.0, 1.0);
        for i in 0..20 {
            let x = f64::from(i) / 20.0;
            let (s, lambda) = (0.05 + 0.9 * x, 0.3 + 0.4 * (7.0 * x).fract());
            let m = channel.full.point(&part, s, lambda, 0.0).expect("inside").point;
            let w = channel.full.point(&part, s - 0.1 * (3.0 * x).fract(), 0.5, 1.0).expect("inside").point;
            let axis = (w - m).normalize();
            let cutter = CutterSolid { tip: m + axis, axis, radius: 6.0, corner_radius: 0.0 };
            for (from, to) in [(0.0, 1.0), (0.0, 0.33), (0.33, 0.67), (0.67, 1.0)] {
                let found = probe.nearest(&cutter, from, to).distance;
                let mut least = f64::INFINITY;
                for a in 0..=600 {
                    for b in 0..=60 {
                        let v = from + (to - from) * f64::from(b) / 60.0;
                        least = least.min(cutter.distance(&side.point(f64::from(a) / 600.0, v)));
                    }
                }
                // The depth of a cut into the side needs to be accurate to 0.01 mm only: any cut is an error.
                let tolerance = if least < 0.0 { 0.01 } else { 1e-4 };
                assert!(
                    found - least < tolerance,
                    "side {k}, s {s:.3}, v {from} to {to}: found {found}, a scan finds {least}"
                );
            }
        }
    }
}

/// A wheel with noisy sections.
pub fn kj66() -> Impeller {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wheels/kj66_sections.toml");
    Impeller::build(&read_part(&file).expect("readable")).expect("an impeller")
}

/// Also where the lines of noisy sections run back on themselves.
#[test]
fn points_of_a_side_are_at_no_distance_from_it() {
    for (k, side) in Channel::from_part(&kj66()).sides.iter().enumerate() {
        let probe = SideProbe::new(side, 0.0, 1.0);
        for (i, j) in (0..=160).flat_map(|i| (0..=40).map(move |j| (i, j))) {
            let (u, v) = (f64::from(i) / 160.0, f64::from(j) / 40.0);
            let found = probe.nearest_to_point(&side.point(u, v)).distance;
            assert!(found < 2e-3, "side {k}, u {u}, v {v}: {found} mm");
        }
    }
}

/// Points and cutters close to noses, tips and hub, where sides bend most, and fold where their sections are
/// noisy: the nearest point may be on another part of the side than the nearest point of any grid.
#[test]
fn nothing_is_nearer_at_noses_and_folded_tips() {
    for (name, part) in [("impeller9x9", sample("impeller9x9")), ("pump6", sample("pump6")), ("kj66", kj66())]
    {
        let size = 0.02 * part.rim_radius();
        for (k, side) in Channel::from_part(&part).sides.iter().enumerate() {
            let probe = SideProbe::new(side, 0.0, 1.0);
            // Closer towards all borders.
            let place =
                |i: u32, n: u32| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(i) / f64::from(n)).cos();
            let places = (0..=400).flat_map(|a| (0..=80).map(move |b| (place(a, 400), place(b, 80))));
            let scan: Vec<Point> = places.map(|(u, v)| side.point(u, v)).collect();
            for i in 0..120 {
                let [a, b, c, d, e] = [0.618_034, 0.754_878, 0.569_840, 0.819_173, 0.671_044]
                    .map(|step: f64| (step * f64::from(i + 1)).fract());
                let beside = 0.03 * b;
                let (u, v) =
                    [(beside, a), (1.0 - beside, a), (a, 1.0 - beside), (a, 1.0 - beside)][i as usize % 4];
                let turn = std::f64::consts::TAU * c;
                let flat = (1.0 - (2.0 * d - 1.0).powi(2)).sqrt();
                let direction = Vector::new(flat * turn.cos(), flat * turn.sin(), 2.0 * d - 1.0);
                let point = side.point(u, v) + direction * (size * e * e);
                let found = probe.nearest_to_point(&point).distance;
                let least = scan.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
                assert!(
                    found - least < 1e-3,
                    "{name}, side {k}, {i}: {found} of a point, a scan finds {least}"
                );
                let radius = 0.5 * size * b + 0.01;
                let tip = point + direction * radius;
                let axis = direction.cross(&Vector::new(a - 0.5, b - 0.5, 0.1)).normalize();
                let cutter = CutterSolid { tip, axis, radius, corner_radius: 0.5 * radius };
                let found = probe.nearest(&cutter, 0.0, 1.0).distance;
                let least = scan.iter().map(|p| cutter.distance(p)).fold(f64::INFINITY, f64::min);
                let tolerance = if least < 0.0 { f64::INFINITY } else { 1e-3 };
                assert!(found - least < tolerance, "{name}, side {k}, {i}: {found}, a scan finds {least}");
            }
        }
    }
}

#[test]
fn a_cutoff_leaves_out_only_what_is_further() {
    for name in SAMPLES {
        let part = sample(name);
        for (k, side) in Channel::from_part(&part).sides.iter().enumerate() {
            let probe = SideProbe::new(side, 0.0, 1.0);
            // Thin cutters at right angles to the side: the nearest point is between the points of any grid.
            for i in 0..400 {
                let (u, v) = ((0.618_034 * f64::from(i)).fract(), (0.754_878 * f64::from(i)).fract());
                let (point, along, up) = (side.point(u, v), side.point(u + 1e-4, v), side.point(u, v + 1e-4));
                let normal = (along - point).cross(&(up - point)).normalize();
                for axis in [normal, -normal] {
                    let cutter =
                        CutterSolid { tip: point + axis * 0.2, axis, radius: 0.1, corner_radius: 0.0 };
                    let cutoff = cutter.distance(&point) + 1e-9;
                    assert!(
                        probe.nearest_below(&cutter, cutoff).is_some(),
                        "{name}, side {k}, u {u:.4}, v {v:.4}: what is {cutoff} away is not found"
                    );
                }
            }
        }
    }
}

#[test]
fn whether_a_cutter_is_near_is_found_as_it_is_measured() {
    for name in SAMPLES {
        let part = sample(name);
        let channel = Channel::from_part(&part);
        let mut counts = [0, 0];
        for side in &channel.sides {
            let probe = SideProbe::new(side, 0.0, 1.0);
            for i in 0..300 {
                let x = f64::from(i) / 300.0;
                let (s, lambda) = (0.02 + 0.96 * x, 0.2 + 0.6 * (7.0 * x).fract());
                let Some(m) = channel.full.point(&part, s, lambda, 0.0) else { continue };
                let Some(w) = channel.full.point(&part, s - 0.1 * (3.0 * x).fract(), 0.5, 1.0) else {
                    continue;
                };
                let axis = (w.point - m.point).normalize();
                let radius = 0.02 * part.rim_radius() * (0.2 + (11.0 * x).fract());
                let cutter = CutterSolid { tip: m.point + axis, axis, radius, corner_radius: 0.3 * radius };
                let distance = probe.nearest(&cutter, 0.0, 1.0).distance;
                for off in [-1.0, -0.01, -1e-4, 1e-4, 0.01, 1.0] {
                    let is_near = probe.is_within(&cutter, distance + off);
                    assert_eq!(is_near, off > 0.0, "{name}, s {s:.3}: {distance} and {off} beside it");
                    counts[usize::from(is_near)] += 1;
                }
            }
        }
        assert!(counts[0] > 300 && counts[1] > 300, "{name}: {counts:?}");
    }
}

/// Distance of `cutter` from the point of `side` that pattern search finds starting at (`u`, `v`).
fn refined(cutter: &CutterSolid, side: &BladeSide, (u, v): (f64, f64)) -> f64 {
    let at = |u: f64, v: f64| cutter.distance(&side.point(u, v.clamp(0.0, 1.0)));
    let (mut best, mut step) = ((at(u, v), u, v), 1e-3);
    while step > 1e-9 {
        let mut moved = false;
        for (du, dv) in [
            (1.0, 0.0),
            (-1.0, 0.0),
            (0.0, 1.0),
            (0.0, -1.0),
            (1.0, 1.0),
            (-1.0, -1.0),
            (1.0, -1.0),
            (-1.0, 1.0),
        ] {
            let (u, v) = (best.1 + step * du, best.2 + step * dv);
            if at(u, v) < best.0 {
                (best, moved) = ((at(u, v), u, v), true);
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    best.0
}

#[test]
fn what_is_near_the_edge_of_the_bottom_is_met_to_a_tenth_of_a_micrometre() {
    let part = sample("impeller532");
    let channel = Channel::from_part(&part);
    let mut beside_the_edge = 0;
    for (k, side) in channel.sides.iter().enumerate() {
        let probe = SideProbe::new(side, 0.0, 1.0);
        for i in 0..200 {
            let x = f64::from(i) / 200.0;
            let lambda = 0.3 + 0.4 * (7.0 * x).fract();
            let Some(m) = channel.full.point(&part, 0.05 + 0.9 * x, lambda, 0.0) else { continue };
            let Some(w) = channel.full.point(&part, 0.9 * x, 0.5, 1.0) else { continue };
            let axis = (w.point - m.point).normalize();
            let mut cutter = CutterSolid { tip: m.point + axis, axis, radius: 5.0, corner_radius: 0.0 };
            for _ in 0..30 {
                let near = probe.nearest(&cutter, 0.0, 1.0);
                let d = near.point - cutter.tip;
                let across = d - axis * d.dot(&axis);
                cutter.tip += across.normalize() * (near.distance - 0.5);
            }
            let near = probe.nearest(&cutter, 0.0, 1.0);
            if !(0.1..1.0).contains(&near.distance) {
                continue;
            }
            beside_the_edge += i32::from((near.point - cutter.tip).dot(&axis) < 0.0);
            let least = refined(&cutter, side, (near.u, near.v));
            assert!(near.distance - least < 1e-7, "side {k}, {i}: {} instead of {least}", near.distance);
        }
    }
    assert!(beside_the_edge > 20, "{beside_the_edge} looked at below the bottom");
}
