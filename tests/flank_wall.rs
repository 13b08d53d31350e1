//! Flank milling of walls against brute force, on real parts.

use std::path::Path;

use vanecut::flank::wall::{WallAxes, WallFit, WallMilling, WallStation};
use vanecut::formats::part_file::read_part;
use vanecut::geometry::{CutterSolid, Point, Vector, frame_about};
use vanecut::part::{BladeSide, BladeWall, Channel, Impeller, Passage, Tool, WallEnvelope};
use vanecut::plunge::clearance::FinishedPart;
use vanecut::plunge::slotting::DepthSurface;

/// Blades through three sections, bowed.
const BOWED: &str = "tests/cli/assess_bowed/part.toml";
const ALLOWANCE: f64 = 0.5;

fn part_at(path: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

fn tool(diameter: f64, corner_radius: f64) -> Tool {
    Tool {
        number: 1,
        diameter,
        corner_radius,
        insert_width: 0.45 * diameter,
        overhang: 6.0 * diameter,
        plunge_feed: 300.0,
        spindle: 5000.0,
    }
}

fn milling(tool: &Tool) -> WallMilling<'_> {
    WallMilling {
        tool,
        blade_allowance: ALLOWANCE,
        hub_allowance: ALLOWANCE,
        extension: 8.0,
        step: 4.0,
        chord_error: 0.001,
    }
}

/// Both main walls and both splitter walls of a channel.
fn walls(channel: &Channel) -> Vec<(&Passage, usize)> {
    let mut walls = vec![(&channel.full, 0), (&channel.full, 1)];
    if let [near, far] = &channel.beside_splitter[..] {
        walls.extend([(near, 1), (far, 0)]);
    }
    walls
}

fn fitted(part: &Impeller, channel: &Channel, tool: &Tool, tolerance: f64) -> Vec<WallAxes> {
    let (finished, milling) = (FinishedPart::new(part, &channel.sides), milling(tool));
    let fitted = |(passage, wall)| {
        let fit = WallFit::new(&finished, passage, wall, &milling).expect("a wall");
        fit.axes(fit.swept(tolerance))
    };
    walls(channel).into_iter().map(fitted).collect()
}

/// The cutter between two stations as a controller moves it; its bottom far below.
fn between(a: &WallStation, b: &WallStation, share: f64, radius: f64) -> CutterSolid {
    let axis = (a.axis + (b.axis - a.axis) * share).normalize();
    let tip = a.foot + (b.foot - a.foot) * share - axis * 1e3;
    CutterSolid { tip, axis, radius, corner_radius: 0.0 }
}

/// Least distance of `point` from the sweep, by looking at very many places of it.
fn swept_distance(stations: &[WallStation], point: &Point, radius: f64) -> f64 {
    let last = (stations.len() - 1) as f64;
    let at = |t: f64| {
        let i = (t as usize).min(stations.len() - 2);
        between(&stations[i], &stations[i + 1], t - i as f64, radius).distance(point)
    };
    let scan = |from: f64, to: f64, count: usize| {
        (0..=count)
            .map(|k| from + (to - from) * k as f64 / count as f64)
            .map(|t| (at(t), t))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("places")
    };
    let (_, t) = scan(0.0, last, 10 * stations.len());
    scan((t - 0.2).max(0.0), (t + 0.2).min(last), 4000).0
}

#[test]
fn the_map_tells_what_a_dense_sweep_leaves() {
    for name in ["assets/parts/impeller9x9.toml", BOWED] {
        let part = part_at(name);
        let channel = Channel::of(&part);
        let cutter = tool(6.0, 3.0);
        for ((passage, wall), axes) in
            walls(&channel).into_iter().zip(fitted(&part, &channel, &cutter, 0.005))
        {
            let (map, side) = (&axes.map, passage.walls[wall].side());
            assert!(
                map.u.len() > 40 && map.v.len() > 10,
                "{name}: a map of {} × {}",
                map.u.len(),
                map.v.len()
            );
            let mut looked = 0;
            for k in (0..map.deviation.len()).step_by(83) {
                // Exactly 0 stands where only the corner of the cutter comes.
                if map.deviation[k] == 0.0 {
                    continue;
                }
                looked += 1;
                let (u, v) = (map.u[k / map.v.len()], map.v[k % map.v.len()]);
                let left = swept_distance(&axes.stations, &side.point(u, v), cutter.radius()) - ALLOWANCE;
                assert!(
                    (left - map.deviation[k]).abs() < 1e-5,
                    "{name}, wall {wall}, u {u:.3} v {v:.3}: a sweep leaves {left}, the map says {}",
                    map.deviation[k]
                );
            }
            assert!(2 * 83 * looked > map.deviation.len(), "{name}, wall {wall}: {looked} places");
        }
    }
}

#[test]
fn ruled_walls_are_met_within_five_micrometres() {
    let part = part_at("assets/parts/impeller9x9.toml");
    let channel = Channel::of(&part);
    for diameter in [4.0, 6.0, 10.0] {
        let cutter = tool(diameter, 0.5 * diameter);
        for (k, axes) in fitted(&part, &channel, &cutter, 0.005).iter().enumerate() {
            assert!(
                axes.max_overcut <= 0.005 && axes.max_undercut <= 0.005,
                "wall {k}, D {diameter}: {} mm over, {} mm under",
                axes.max_overcut,
                axes.max_undercut
            );
        }
    }
}

#[test]
fn neighbouring_axes_turn_by_little() {
    let part = part_at("assets/parts/pump6.toml");
    let channel = Channel::of(&part);
    let cutter = tool(10.0, 5.0);
    for axes in fitted(&part, &channel, &cutter, 0.0) {
        for pair in axes.stations.windows(2) {
            let turn = pair[0].axis.angle(&pair[1].axis).to_degrees();
            let way = (pair[1].foot - pair[0].foot).norm();
            assert!(turn < 5.0 && way < 4.5 && way > 0.0, "{turn}° and {way} mm at u {}", pair[0].u);
        }
    }
}

#[test]
fn without_tolerance_nothing_is_cut_too_deep_and_a_bow_is_what_remains() {
    for name in [BOWED, "assets/parts/impeller9x9.toml"] {
        let part = part_at(name);
        let channel = Channel::of(&part);
        let finished = FinishedPart::new(&part, &channel.sides);
        for diameter in [4.0, 8.0] {
            let cutter = tool(diameter, 0.0);
            let all = fitted(&part, &channel, &cutter, 0.0);
            for (k, axes) in all.iter().enumerate() {
                assert!(axes.max_overcut < 1e-6, "{name} {k}: {} mm over", axes.max_overcut);
                let wall = [BladeWall::Suction, BladeWall::Pressure][usize::from(k == 1 || k == 2)];
                let blade = if k < 2 { &part.main } else { &part.splitters[0] };
                let gap = WallEnvelope::of(blade, wall, 40).greatest_gap();
                assert!(
                    axes.max_undercut < 1.05 * gap + 0.02,
                    "{name} {k}: {} mm under, the envelope leaves {gap}",
                    axes.max_undercut
                );
                let free = axes.stations.windows(2).filter(|w| w.iter().all(|s| s.blocked.is_none()));
                let mut looked_at = 0;
                for pair in free.step_by(3) {
                    for share in [0.0, 0.25, 0.5, 0.75] {
                        let mut there = between(&pair[0], &pair[1], share, cutter.radius());
                        there.tip += there.axis * (1e3 + ALLOWANCE);
                        let clearance = finished.blade_clearance(&there);
                        assert!(
                            clearance > ALLOWANCE - 1e-7,
                            "{name} {k}, D {diameter}, u {} + {share}: {clearance}",
                            pair[0].u
                        );
                        looked_at += 1;
                    }
                }
                assert!(looked_at > 40, "{name} {k}: only {looked_at} free places");
            }
        }
    }
}

#[test]
fn what_stands_in_the_way_is_named() {
    let part = part_at("assets/parts/impeller532.toml");
    let channel = Channel::of(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    // The passage is 12.5 mm wide at its narrowest.
    let cutter = tool(16.0, 0.0);
    for axes in fitted(&part, &channel, &cutter, 0.005) {
        let blocked = axes.stations.iter().filter(|s| s.blocked.is_some()).count();
        assert!(blocked > 3 && blocked < axes.stations.len() / 2, "{blocked} of {}", axes.stations.len());
        for station in &axes.stations {
            let there = cutter.placed(station.foot + station.axis * ALLOWANCE, station.axis);
            let clearance = finished.blade_clearance(&there);
            match station.blocked {
                Some(obstacle) => {
                    assert!((obstacle.distance - clearance).abs() < 1e-3 && clearance < ALLOWANCE - 0.005);
                    let near = channel.sides[obstacle.side].point(obstacle.u, obstacle.v);
                    assert!((there.distance(&near) - obstacle.distance).abs() < 1e-3);
                }
                None => assert!(clearance > ALLOWANCE - 0.006, "{clearance} at u {}", station.u),
            }
        }
    }
}

#[test]
fn cutters_of_all_shapes_come_to_rest_on_the_hub() {
    let part = part_at("assets/parts/impeller9x9.toml");
    let channel = Channel::of(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    for corner_radius in [0.0, 1.0, 3.0] {
        let cutter = tool(6.0, corner_radius);
        let surface = DepthSurface::new(part.hub.curve(), ALLOWANCE + corner_radius);
        let axes = &fitted(&part, &channel, &cutter, 0.0)[0];
        let on_hub = axes.stations.iter().filter(|s| (0.05..0.95).contains(&s.s));
        for station in on_hub.step_by(5) {
            let tip = station.tip_on(&surface, &cutter).expect("over the hub");
            let clearance = finished.hub_clearance(&cutter.placed(tip, station.axis));
            assert!(
                (clearance - ALLOWANCE).abs() < 1e-5,
                "corner {corner_radius}, s {}: {clearance} mm over the hub",
                station.s
            );
        }
    }
}

/// Distance of a line of the wall at height `v`, near `u`, from an axis.
fn line_distance(side: &BladeSide, v: f64, u: f64, (foot, axis): (Point, Vector)) -> f64 {
    let at = |u: f64| {
        let d = side.point(u, v) - foot;
        (d - axis * d.dot(&axis)).norm()
    };
    let (mut low, mut high) = (u - 0.05, u + 0.05);
    for _ in 0..3 {
        let step = (high - low) / 40.0;
        let best = (0..=40).map(|k| low + step * f64::from(k)).min_by(|a, b| at(*a).total_cmp(&at(*b)));
        let best = best.expect("places");
        (low, high) = (best - step, best + step);
    }
    at(0.5 * (low + high))
}

#[test]
fn no_straight_edge_does_better_than_what_is_said_to_be_forced() {
    for (name, diameter) in [("assets/parts/pump6.toml", 12.0), ("assets/parts/impeller532.toml", 6.0)] {
        let part = part_at(name);
        let channel = Channel::of(&part);
        let cutter = tool(diameter, 0.5 * diameter);
        // Cut as deep as left: each axis is the best of its own.
        let walls = walls(&channel).into_iter().zip(fitted(&part, &channel, &cutter, 1.0));
        let worst = |axes: &WallAxes| {
            let flank = axes.map.u[0];
            let on_flank = axes.stations.iter().filter(|s| s.u >= flank && s.u <= 1.0);
            on_flank.copied().max_by(|a, b| a.forced.total_cmp(&b.forced)).expect("stations")
        };
        let ((passage, wall), axes) = walls.max_by(|a, b| a.1.forced.total_cmp(&b.1.forced)).expect("a wall");
        let (station, side) = (worst(&axes), passage.walls[wall].side());
        assert_eq!(station.forced, axes.forced);
        assert!(station.forced > 2e-3, "{name}: {} mm tell nothing", station.forced);
        let reach = cutter.radius() + ALLOWANCE;
        let height = (side.point(station.u, 1.0) - side.point(station.u, 0.0)).norm();
        let from = (ALLOWANCE + cutter.corner_radius) / height;
        let off = |line: (Point, Vector)| {
            (0..=20)
                .map(|k| from + (1.0 - from) * f64::from(k) / 20.0)
                .map(|v| (line_distance(side, v, station.u, line) - reach).abs())
                .fold(0.0, f64::max)
        };
        let (e1, e2) = frame_about(&station.axis);
        let mut state = 11u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        // Lines around it, moved and tilted any way by some hundredths of a millimetre and less and less.
        let mut best = ([0.0f64; 4], off((station.foot, station.axis)));
        let first = best.1;
        for round in 0..1500 {
            let size = 0.2 * (-f64::from(round) / 180.0).exp();
            let numbers = best.0.map(|x| x + size * random());
            let [a, b, c, d] = numbers;
            // Far along the wall it would be another position.
            if (a * a + b * b).sqrt() > 0.3 {
                continue;
            }
            let foot = station.foot + e1 * a + e2 * b;
            let axis = (station.axis + (e1 * (c - a) + e2 * (d - b)) / height).normalize();
            let there = off((foot, axis));
            if there < best.1 {
                best = (numbers, there);
            }
        }
        assert!(first < station.forced + 1e-3, "{name}: {first} mm, not {}", station.forced);
        assert!(best.1 > 0.93 * station.forced, "{name}: {} mm is less than {}", best.1, station.forced);
    }
}
