//! Flank milling of walls, compared with brute force on real parts.

use vanecut::cutting::drop_cutter::DepthSurface;
use vanecut::flank::layer::LayerSurface;
use vanecut::flank::wall::{WallAxes, WallFit, WallMilling, WallStation};
use vanecut::geometry::{CutterSolid, Meridional, MeridionalCurve, Point, Vector, frame_about};
use vanecut::part::{BladeSide, BladeWall, Channel, FinishedPart, Impeller, Passage, WallEnvelope};
use vanecut::setup::Tool;

use super::parts::{self, part_at};

/// A part with bowed blades through three span sections.
const BOWED: &str = "tests/cli/assess_bowed/part.toml";
const ALLOWANCE: f64 = 0.5;
const DEPTH: f64 = 3.0;

fn tool(diameter: f64, corner_radius: f64) -> Tool {
    parts::cutter(diameter, corner_radius, 6.0 * diameter)
}

fn milling(tool: &Tool) -> WallMilling<'_> {
    WallMilling {
        tool,
        blade_allowance: ALLOWANCE,
        hub_allowance: ALLOWANCE,
        lead_in_out: 8.0,
        step: 4.0,
        chord_error: 5e-4,
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

/// The layers of a channel, `depth` mm each, hub first, extrapolated beyond its ends.
fn layers_of(part: &Impeller, depth: f64) -> Vec<MeridionalCurve> {
    let heights = (0..).map(|k| (depth * f64::from(k)).max(ALLOWANCE));
    heights
        .map_while(|height| Some(LayerSurface::at_height(part, height)?.extended_meridian(25.0, 0.5)))
        .collect()
}

/// Drop-cutter surfaces of these layers.
fn rests<'a>(layers: &'a [MeridionalCurve], tool: &Tool) -> Vec<DepthSurface<'a>> {
    layers.iter().map(|layer| DepthSurface::new(layer, tool.corner_radius)).collect()
}

/// The axes along some walls of a channel, on these layers.
fn fitted_on(
    part: &Impeller,
    (channel, walls): (&Channel, &[(&Passage, usize)]),
    tool: &Tool,
    tolerance: f64,
    rests: &[DepthSurface],
) -> Vec<WallAxes> {
    let (finished, milling) = (FinishedPart::new(part, &channel.sides), milling(tool));
    let fitted = |&(passage, wall): &(&Passage, usize)| {
        let fit = WallFit::new(&finished, passage, wall, &milling, rests).expect("a wall");
        fit.axes(fit.sweep(tolerance))
    };
    walls.iter().map(fitted).collect()
}

/// Those along all walls, on layers of [`DEPTH`].
fn fitted(part: &Impeller, channel: &Channel, tool: &Tool, tolerance: f64) -> Vec<WallAxes> {
    let layers = layers_of(part, DEPTH);
    fitted_on(part, (channel, &walls(channel)), tool, tolerance, &rests(&layers, tool))
}

/// The positions of a cutter on one layer, with the offset of the tip from the foot along the axis, mm.
struct OnLayer<'a> {
    stations: &'a [WallStation],
    tips: Vec<Option<f64>>,
}

impl<'a> OnLayer<'a> {
    fn from_axes(axes: &'a WallAxes, number: usize) -> Self {
        let stations = axes.stations(number);
        let tip = |s: &WallStation| Some((s.tip? - s.foot).dot(&s.axis));
        Self { stations, tips: stations.iter().map(tip).collect() }
    }

    /// The cutter between a station and the next, interpolated as by a controller; `None` where it misses the
    /// layer.
    fn between(&self, station: usize, share: f64, tool: &Tool) -> Option<CutterSolid> {
        let [a, b] = [station, station + 1].map(|k| &self.stations[k]);
        let [from, to] = [self.tips[station]?, self.tips[station + 1]?];
        let axis = (a.axis + (b.axis - a.axis) * share).normalize();
        let tip = a.foot + (b.foot - a.foot) * share + axis * (from + (to - from) * share);
        Some(tool.placed(tip, axis))
    }

    /// Minimum distance of `point` from the sweep, mm, by dense sampling.
    fn distance(&self, point: &Point, tool: &Tool) -> f64 {
        let last = (self.stations.len() - 1) as f64;
        let at = |t: f64| {
            let i = (t as usize).min(self.stations.len() - 2);
            self.between(i, t - i as f64, tool).map_or(f64::INFINITY, |there| there.distance(point))
        };
        let scan = |from: f64, to: f64, count: usize| {
            (0..=count)
                .map(|k| from + (to - from) * k as f64 / count as f64)
                .map(|t| (at(t), t))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .expect("places")
        };
        let (_, t) = scan(0.0, last, 10 * self.stations.len());
        scan((t - 0.2).max(0.0), (t + 0.2).min(last), 400).0
    }
}

/// Every STRIDE-th point of a map is checked.
const STRIDE: usize = 167;

#[test]
fn the_map_tells_what_a_dense_sweep_leaves() {
    for name in ["assets/parts/impeller9x9.toml", BOWED] {
        let part = part_at(name);
        let channel = Channel::from_part(&part);
        let cutter = tool(6.0, 3.0);
        let count = layers_of(&part, DEPTH).len();
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
            let on: Vec<OnLayer> = (0..count).map(|k| OnLayer::from_axes(&axes, k)).collect();
            let (mut looked, mut met) = (0, 0);
            for k in (0..map.deviation.len()).step_by(STRIDE) {
                let (u, v) = (map.u[k / map.v.len()], map.v[k % map.v.len()]);
                let point = side.point(u, v);
                // The deviation is 0 where only the corner of the cutter is; next to that it depends on the
                // axis.
                let (_, height) = part.hub.curve().project(Meridional::from_point(&point));
                if map.deviation[k] == 0.0 || height < ALLOWANCE + 1.5 * cutter.corner_radius {
                    continue;
                }
                looked += 1;
                let left = on.iter().map(|on| on.distance(&point, &cutter)).fold(f64::INFINITY, f64::min);
                // The corner leaves slightly more than the cylinder next to the lower end of the flank, and
                // the cutter of a lower layer may remove some stock above its strip. The map neglects both.
                let off = map.deviation[k] - (left - ALLOWANCE);
                assert!(
                    off > -3e-4 && off < 1e-3,
                    "{name}, wall {wall}, u {u:.3} v {v:.3}: the map says {}, {off} too much",
                    map.deviation[k]
                );
                met += usize::from(off.abs() < 1e-5);
            }
            assert!(4 * met > 3 * looked, "{name}, wall {wall}: only {met} of {looked} are met");
            assert!(2 * STRIDE * looked > map.deviation.len(), "{name}, wall {wall}: {looked} places");
        }
    }
}

#[test]
fn ruled_walls_are_met_within_five_micrometres() {
    for (name, cutters) in [
        ("assets/parts/impeller9x9.toml", [(4.0, 2.0), (10.0, 1.0)]),
        ("assets/parts/pump6.toml", [(6.0, 1.0), (12.0, 6.0)]),
    ] {
        let part = part_at(name);
        let channel = Channel::from_part(&part);
        for (diameter, corner_radius) in cutters {
            let cutter = tool(diameter, corner_radius);
            for (k, axes) in fitted(&part, &channel, &cutter, 5e-4).iter().enumerate() {
                assert!(
                    axes.max_overcut <= 6e-4 && axes.max_undercut <= 0.005,
                    "{name}, wall {k}, D {diameter} R {corner_radius}: {} mm over, {} mm under",
                    axes.max_overcut,
                    axes.max_undercut
                );
            }
        }
    }
}

#[test]
fn neighbouring_axes_turn_by_little() {
    let part = part_at("assets/parts/pump6.toml");
    let channel = Channel::from_part(&part);
    let cutter = tool(10.0, 5.0);
    let count = layers_of(&part, DEPTH).len();
    for axes in fitted(&part, &channel, &cutter, 0.0) {
        for layer in 0..count {
            let stations = axes.stations(layer);
            for pair in stations.windows(2) {
                let turn = pair[0].axis.angle(&pair[1].axis).to_degrees();
                let way = (pair[1].foot - pair[0].foot).norm();
                assert!(turn < 5.0 && way < 4.5 && way > 0.0, "{turn}° and {way} mm at u {}", pair[0].u);
            }
            for (below, here) in axes.stations(layer.saturating_sub(1)).iter().zip(stations) {
                let turn = below.axis.angle(&here.axis).to_degrees();
                assert!(turn < 2.0, "{turn}° from the layer below {layer}, at u {}", here.u);
            }
        }
    }
}

#[test]
fn without_tolerance_nothing_is_cut_too_deep_and_a_bow_is_what_remains() {
    for (name, diameters) in [(BOWED, [4.0]), ("assets/parts/impeller9x9.toml", [8.0])] {
        let part = part_at(name);
        let channel = Channel::from_part(&part);
        let finished = FinishedPart::new(&part, &channel.sides);
        let count = layers_of(&part, DEPTH).len();
        for diameter in diameters {
            let cutter = tool(diameter, 0.0);
            let all = fitted(&part, &channel, &cutter, 0.0);
            for (k, axes) in all.iter().enumerate() {
                assert!(axes.max_overcut < 1e-6, "{name} {k}: {} mm over", axes.max_overcut);
                let wall = [BladeWall::Suction, BladeWall::Pressure][usize::from(k == 1 || k == 2)];
                let blade = if k < 2 { &part.main } else { &part.splitters[0] };
                let gap = WallEnvelope::from_blade(blade, wall, 40).max_gap();
                assert!(
                    axes.max_undercut < 1.05 * gap + 0.02,
                    "{name} {k}: {} mm under, the envelope leaves {gap}",
                    axes.max_undercut
                );
                let mut looked_at = 0;
                for number in 0..count {
                    let on = OnLayer::from_axes(axes, number);
                    let is_free = |i: &usize| on.stations[*i..*i + 2].iter().all(|s| s.blocked.is_none());
                    for i in (0..on.stations.len() - 1).filter(is_free).step_by(7) {
                        for there in [0.0, 0.25, 0.5, 0.75].map(|share| on.between(i, share, &cutter)) {
                            let Some(there) = there else { continue };
                            let clearance = finished.blade_clearance(&there);
                            let u = on.stations[i].u;
                            assert!(
                                clearance > ALLOWANCE - 2e-4,
                                "{name} {k}, D {diameter}, layer {number}, u {u}: {clearance}"
                            );
                            looked_at += 1;
                        }
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
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    // The narrowest width of the passage is 12.5 mm.
    let cutter = tool(16.0, 0.0);
    for axes in fitted(&part, &channel, &cutter, 0.005) {
        let stations = axes.stations(0);
        let blocked = stations.iter().filter(|s| s.blocked.is_some()).count();
        assert!(blocked > 3 && blocked < stations.len() / 2, "{blocked} of {}", stations.len());
        for station in stations {
            let Some(tip) = station.tip else { continue };
            let there = cutter.placed(tip, station.axis);
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
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    let layers = layers_of(&part, DEPTH);
    let first = &walls(&channel)[..1];
    for corner_radius in [0.0, 1.0, 3.0] {
        let cutter = tool(6.0, corner_radius);
        let axes = &fitted_on(&part, (&channel, first), &cutter, 0.0, &rests(&layers, &cutter))[0];
        let on_hub = axes.stations(0).iter().filter(|s| (0.05..0.95).contains(&s.s));
        for station in on_hub.step_by(5) {
            let tip = station.tip.expect("over the hub");
            let clearance = finished.hub_clearance(&cutter.placed(tip, station.axis));
            assert!(
                (clearance - ALLOWANCE).abs() < 1e-5,
                "corner {corner_radius}, s {}: {clearance} mm over the hub",
                station.s
            );
        }
    }
}

/// Distance of the wall's line at height `v`, near `u`, from an axis, mm.
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
    // A single layer forms the whole wall; of several, each forms its strip.
    for (name, diameter, depth) in [
        ("assets/parts/pump6.toml", 12.0, 100.0),
        ("assets/parts/pump6.toml", 12.0, 12.0),
        ("assets/parts/impeller532.toml", 6.0, 100.0),
        ("assets/parts/impeller532.toml", 6.0, 25.0),
    ] {
        let part = part_at(name);
        let channel = Channel::from_part(&part);
        let cutter = tool(diameter, 0.5 * diameter);
        let layers = layers_of(&part, depth);
        assert_eq!(layers.len() > 1, depth < 100.0, "{name}: {} layers", layers.len());
        let rests = rests(&layers, &cutter);
        // With this tolerance, overcut may equal undercut: each axis is the optimum of its station.
        let axes = fitted_on(&part, (&channel, &walls(&channel)), &cutter, 1.0, &rests);
        let walls = walls(&channel).into_iter().zip(axes);
        let ((passage, wall), axes) = walls.max_by(|a, b| a.1.forced.total_cmp(&b.1.forced)).expect("a wall");
        let on_flank = |s: &WallStation| s.u >= axes.map.u[0] && s.u <= 1.0;
        let all = (0..layers.len()).flat_map(|k| axes.stations(k).iter().map(move |station| (k, *station)));
        let worst = all.filter(|(_, s)| on_flank(s)).max_by(|a, b| a.1.forced.total_cmp(&b.1.forced));
        let ((layer, station), side) = (worst.expect("stations"), passage.walls[wall].side());
        assert_eq!(station.forced, axes.forced);
        let reach = cutter.radius() + ALLOWANCE;
        let height = (side.point(station.u, 1.0) - side.point(station.u, 0.0)).norm();
        // Height at which the flank begins on a layer; 1 where it does not.
        let begins = |layer: usize| {
            let centre = rests.get(layer).and_then(|rest| rest.tip(&cutter, &station.foot, &station.axis));
            let along = |p: Point| (p - station.foot).dot(&station.axis);
            let above = |v: f64| {
                centre.is_some_and(|c| along(side.point(station.u, v)) > along(c) + cutter.corner_radius)
            };
            (0..1000).map(|k| f64::from(k) * 1e-3).find(|v| above(*v)).unwrap_or(1.0)
        };
        let (from, to) = (begins(layer), begins(layer + 1));
        assert!(from < 0.9 && to > from, "{name}: a strip from {from} to {to}");
        let off = |line: (Point, Vector)| {
            let left = |v: f64| line_distance(side, v, station.u, line) - reach;
            let formed = (0..=20).map(|k| left(from + (to - from) * f64::from(k) / 20.0).abs());
            let above = (0..=20).map(|k| -left(to + (1.0 - to) * f64::from(k) / 20.0));
            formed.chain(above).fold(0.0, f64::max)
        };
        let (e1, e2) = frame_about(&station.axis);
        let mut state = 11u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        // Random search over lines around it, moved and tilted by amounts that shrink with the iterations.
        let mut best = ([0.0f64; 4], off((station.foot, station.axis)));
        let first = best.1;
        for round in 0..1500 {
            let size = 0.2 * (-f64::from(round) / 180.0).exp();
            let numbers = best.0.map(|x| x + size * random());
            let [a, b, c, d] = numbers;
            // A line further along the wall would be another position.
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
        assert!(station.forced > 3e-4, "{name}: {} mm tell nothing", station.forced);
        assert!(first < 1.2 * station.forced, "{name}: {first} mm, not {}", station.forced);
        assert!(best.1 > 0.85 * station.forced, "{name}: {} mm is less than {}", best.1, station.forced);
    }
}

#[test]
fn a_bowed_wall_is_followed_strip_by_strip() {
    // With axes near those of its whole walls a cutter left 1.6 mm on this wheel.
    let part = part_at("tests/data/wheels/hecc.toml");
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    let cutter = tool(6.0, 3.0);
    // Half as many layers, and every other wall, one of a blade and one of a splitter: each takes long on it.
    let layers = layers_of(&part, 2.0 * DEPTH);
    let some: Vec<_> = walls(&channel).into_iter().step_by(2).collect();
    let fitted = fitted_on(&part, (&channel, &some), &cutter, 0.001, &rests(&layers, &cutter));
    for (k, axes) in fitted.iter().enumerate() {
        assert!(axes.max_undercut < 0.6, "wall {k}: {} mm under", axes.max_undercut);
        assert!(axes.max_overcut < 0.003, "wall {k}: {} mm over", axes.max_overcut);
        let (mut stations, mut blocked) = (0, 0);
        for layer in 0..layers.len() {
            for station in axes.stations(layer) {
                let Some(tip) = station.tip else { continue };
                stations += 1;
                if station.blocked.is_some() {
                    blocked += 1;
                    continue;
                }
                // The round end too, which an inclined axis brings nearer to the wall than the flank.
                let clearance = finished.blade_clearance(&cutter.placed(tip, station.axis));
                assert!(
                    clearance > ALLOWANCE - 0.0012,
                    "wall {k}, layer {layer}, u {}: {clearance}",
                    station.u
                );
            }
        }
        assert!(20 * blocked < stations, "wall {k}: {blocked} of {stations} stations are blocked");
    }
}
