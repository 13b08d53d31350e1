//! Layers and passes of the flank planner, compared with their definitions: geodesic distances by length
//! minimisation, gaps by dense sampling, and the published lengths of the strategies.

use std::path::Path;

use vanecut::error::ErrorCode;
use vanecut::flank::chart::LayerChart;
use vanecut::flank::choice::choose_tool;
use vanecut::flank::curves::{FlankError, FlankLayout, LayoutInputs};
use vanecut::flank::layer::{LayerPoint, LayerSurface};
use vanecut::flank::layer_walls::LayerWalls;
use vanecut::flank::region::WallName;
use vanecut::geometry::{Meridional, Point};
use vanecut::io::read_part;
use vanecut::io::tool_library::flank_cutters;
use vanecut::monitor::Monitor;
use vanecut::part::{Channel, Impeller};
use vanecut::setup::{FlankStrategy, Setup, Tool};

fn open(path: &Path) -> Impeller {
    Impeller::build(&read_part(path).expect("readable")).expect("an impeller")
}

fn sample(name: &str) -> Impeller {
    open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name))
}

/// The three sample parts, and a real compressor.
fn parts() -> Vec<Impeller> {
    let mut parts: Vec<Impeller> =
        ["impeller532.toml", "impeller9x9.toml", "pump6.toml"].map(sample).into_iter().collect();
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    parts.push(open(&tests.join("data/cc_autoblade/cc_autoblade.geomTurbo")));
    parts
}

fn planned(part: &Impeller, setup: &Setup) -> Result<(FlankLayout, Tool), FlankError> {
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let chosen = choose_tool(&workpiece, setup, flank_cutters()).map_err(FlankError::Setup)?;
    let source = LayoutInputs { workpiece: &workpiece, setup, tool: &chosen.tool };
    Ok((source.plan(&Monitor::default())?, chosen.tool))
}

/// Over the corner between boss and disc, sharp or rounded, the parallels of the hub fold: layers are rounded
/// there, and go on over the disc.
#[test]
fn layers_over_the_foot_of_a_boss_keep_their_height_above_the_hub() {
    let steps = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/step");
    for name in ["paddle_wheel.step", "paddle_foot.step"] {
        let part = open(&steps.join(name));
        let hub = part.hub.curve();
        for height in [1.0, 3.0, 6.0, 9.0, 11.0] {
            let layer = LayerSurface::at_height(&part, height).expect("the paddles are 12 mm high");
            let length = layer.to - layer.from;
            // From the boss of R 15 to the rim at R 60.
            assert!(length > 0.95 * (60.0 - 15.0 - height), "{name}, {height}: {length} mm long");
            let rounding = 0.03 * (std::f64::consts::SQRT_2 - 1.0) * (length + 12.0);
            for k in 0..=500 {
                let x = layer.to * f64::from(k) / 500.0;
                let (point, normal) = layer.point_and_normal(LayerPoint { x, y: 0.3 });
                let above = |p: &Point| hub.project(Meridional::from_point(p)).1;
                let here = above(&point);
                assert!(
                    here > height - 5e-3 && here < height + rounding,
                    "{name}, {height}: {here} mm above the hub {x} mm along the layer"
                );
                assert!(above(&(point + 0.1 * normal)) > here, "{name}, {height}: upside down at {x} mm");
            }
        }
    }
}

/// Length of the shortest path over the layer between two points, mm: minimised over chains of points.
fn shortest(layer: &LayerSurface, a: LayerPoint, b: LayerPoint) -> f64 {
    const LINKS: usize = 24;
    let mut chain: Vec<LayerPoint> = (0..=LINKS).map(|k| a.lerp(b, k as f64 / LINKS as f64)).collect();
    let mut pull = 0.5;
    let length = |chain: &[LayerPoint]| {
        chain
            .windows(2)
            .map(|p| {
                let middle = p[0].lerp(p[1], 0.5);
                [(p[0], middle), (middle, p[1])].map(|(p, q)| layer.segment_length(p, q)).iter().sum::<f64>()
            })
            .sum::<f64>()
    };
    let mut best = length(&chain);
    // Coordinate descent in y at even x (or in x where the path is circumferential), with halving steps.
    let across = (b.x - a.x).abs() < layer.radius(a.x).0 * (b.y - a.y).abs();
    let mut step = 0.02 * best.max(1.0) / if across { 1.0 } else { layer.radius(a.x).0 };
    while step > 1e-7 && pull > 0.0 {
        let mut better = false;
        for k in 1..LINKS {
            for sign in [1.0, -1.0] {
                let mut moved = chain.clone();
                // A smooth bump moves the chain without kinks.
                for (j, p) in moved.iter_mut().enumerate().take(LINKS).skip(1) {
                    let bump = (1.0 - (j as f64 - k as f64).abs() / 8.0).max(0.0);
                    if across {
                        p.x += sign * step * bump;
                    } else {
                        p.y += sign * step * bump;
                    }
                }
                let now = length(&moved);
                if now < best - 1e-12 {
                    (best, chain, better) = (now, moved, true);
                }
            }
        }
        if !better {
            step *= 0.5;
        }
        pull = if step > 1e-6 { 0.5 } else { 0.0 };
    }
    best
}

#[test]
fn offsets_of_a_wall_keep_their_distance_over_the_layer() {
    let part = sample("impeller9x9.toml");
    let channel = Channel::from_part(&part);
    let layer = LayerSurface::at_height(&part, 6.0).expect("a layer");
    let borders = LayerWalls::from_part(&part, &channel, &layer, 20.0, 0.0, 0.03).expect("walls");
    for (wall, length) in [(&borders.low, 5.5), (&borders.low, 21.0), (&borders.high, 12.0)] {
        let offset = wall.offset(&layer, length);
        let inside: Vec<LayerPoint> =
            offset.into_iter().filter(|p| (layer.from + 8.0..layer.to - 8.0).contains(&p.x)).collect();
        assert!(inside.len() > 10);
        for p in inside.iter().step_by(inside.len() / 2) {
            // The nearest points of a dense sampling of the wall: candidates by straight distance, then every
            // fifth of them by path.
            let dense =
                wall.points.windows(2).flat_map(|w| (0..8).map(move |k| w[0].lerp(w[1], f64::from(k) / 8.0)));
            let mut places: Vec<(f64, LayerPoint)> =
                dense.map(|q| (layer.segment_length(q, *p), q)).collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            let near = places.iter().take(30).step_by(5);
            let least = near.map(|&(_, q)| shortest(&layer, *p, q)).fold(f64::INFINITY, f64::min);
            assert!((least - length).abs() < 0.02, "{length} mm asked, {least} found at {p:?}");
        }
    }
}

#[test]
fn a_chart_knows_distances_between_its_nodes() {
    let part = sample("impeller9x9.toml");
    let channel = Channel::from_part(&part);
    let layer = LayerSurface::at_height(&part, 0.5).expect("a layer");
    let borders = LayerWalls::from_part(&part, &channel, &layer, 20.0, 0.0, 0.03).expect("walls");
    let chart = LayerChart::new(&layer, &borders, 5.5, 3.0, 0.5, 5.0);
    let walls = [(WallName::Low, &borders.low), (WallName::High, &borders.high)];
    let mut looked = 0;
    for node in chart.free_nodes().iter().step_by(997) {
        for (name, wall) in walls {
            let known = chart.distance(name, node.point);
            let straight = wall
                .points
                .iter()
                .map(|&q| layer.segment_length(q, node.point))
                .fold(f64::INFINITY, f64::min);
            if known > 12.0 || !known.is_finite() {
                continue;
            }
            // Near a wall, the straight line is the geodesic, apart from the spacing of the wall's points.
            assert!(known <= straight + 0.02 && known > straight - 0.25, "{name:?}: {known} {straight}");
            looked += 1;
        }
    }
    assert!(looked > 10, "{looked} places");
}

#[test]
fn the_schemes_shorten_the_wheel_of_the_paper_as_published() {
    let part = sample("impeller9x9.toml");
    let (curves, tool) = planned(&part, &Setup::default()).expect("a plan");
    assert_eq!(curves.layers.len(), 9, "layers at the inlet");
    assert_eq!(tool.diameter, 10.0);
    let length = |scheme: FlankStrategy| curves.totals[scheme as usize].length;
    let layers = length(FlankStrategy::Layers) / length(FlankStrategy::Isoparametric);
    let regions = length(FlankStrategy::Regions) / length(FlankStrategy::Layers);
    assert!((0.48..=0.52).contains(&layers), "new layers: {layers}");
    assert!((0.76..=0.82).contains(&regions), "new regions: {regions}");
    assert!((0.37..=0.42).contains(&(layers * regions)), "together: {}", layers * regions);
}

#[test]
fn balanced_curves_leave_no_wide_gap_and_no_more_length_than_seams_ask_for() {
    for part in parts() {
        let (curves, _) = planned(&part, &Setup::default()).expect("a plan");
        let length = curves.totals[FlankStrategy::Balanced as usize].length;
        let bound = curves.floor_length + 0.55 * curves.seam_length;
        assert!(length <= 1.01 * bound, "{}: {length} mm, at most {bound}", part.name);
        let wide = curves.wide_share(FlankStrategy::Balanced);
        assert!(wide < 1e-4, "{}: {wide} of the area is wide", part.name);
        // The same measure finds the gaps that `regions` leaves in the middle between the fans of both walls.
        let fans = curves.wide_share(FlankStrategy::Regions);
        assert!((0.005..0.1).contains(&fans), "{}: {fans} of the fans' area is wide", part.name);
    }
}

#[test]
fn every_place_between_balanced_curves_is_near_one() {
    let part = sample("impeller9x9.toml");
    let channel = Channel::from_part(&part);
    let (curves, tool) = planned(&part, &Setup::default()).expect("a plan");
    let clear = tool.radius() + Setup::default().allowances.blade_allowance;
    for found in [&curves.layers[0], &curves.layers[4], &curves.layers[8]] {
        let layer = &found.layer;
        let borders =
            LayerWalls::from_part(&part, &channel, layer, 20.0, tool.corner_radius, 0.03).expect("walls");
        let chart = LayerChart::new(layer, &borders, clear, found.stepover, 0.3, 0.0);
        // Points of the passes at most an eighth of a millimetre apart, and random points between the walls,
        // which are not nodes of the plan's chart.
        let dense: Vec<LayerPoint> = found
            .pass_curves
            .iter()
            .flat_map(|c| c.points.windows(2))
            .flat_map(|w| {
                let count = (8.0 * layer.segment_length(w[0], w[1])).ceil().max(1.0) as usize;
                (0..=count).map(move |k| w[0].lerp(w[1], k as f64 / count as f64))
            })
            .collect();
        let mut looked = 0;
        let mut state = 12345u64;
        while looked < 400 {
            let mut random = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 11) as f64 / (1u64 << 53) as f64
            };
            let x = layer.from + (layer.to - layer.from) * random();
            let (a, b) = (borders.low.y_at(x), borders.high.y_at(x));
            let p = LayerPoint { x, y: a + (b - a) * random() };
            if chart.wall_margin(p) < 0.02 {
                continue;
            }
            looked += 1;
            let near = dense.iter().map(|&q| layer.segment_length(p, q)).fold(f64::INFINITY, f64::min);
            assert!(
                near <= 0.515 * found.stepover,
                "{near} mm from a curve at {p:?}, height {}",
                layer.height
            );
        }
    }
}

#[test]
fn curves_keep_clear_of_all_walls() {
    for part in parts() {
        let channel = Channel::from_part(&part);
        let setup = Setup::default();
        for scheme in [FlankStrategy::Regions, FlankStrategy::Balanced] {
            let mut setup = setup.clone();
            setup.flank.strategy = scheme;
            let (curves, tool) = planned(&part, &setup).expect("a plan");
            let clear = tool.radius() + setup.allowances.blade_allowance;
            for found in curves.layers.iter().step_by(3) {
                let layer = &found.layer;
                let borders = LayerWalls::from_part(&part, &channel, layer, 20.0, tool.corner_radius, 0.03)
                    .expect("walls");
                let chart = LayerChart::new(layer, &borders, clear, found.stepover, 0.4, 0.0);
                for p in found.pass_curves.iter().flat_map(|c| &c.points) {
                    if (layer.from..=layer.to).contains(&p.x) {
                        assert!(
                            chart.wall_margin(*p) > -0.06,
                            "{}: {p:?} {}",
                            part.name,
                            chart.wall_margin(*p)
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_planned_has_its_code() {
    let part = sample("impeller9x9.toml");
    let fault = |change: &dyn Fn(&mut Setup)| {
        let mut setup = Setup::default();
        change(&mut setup);
        match planned(&part, &setup) {
            Err(FlankError::Setup(fault)) => fault.code,
            other => panic!("no fault: {:?}", other.map(|(curves, _)| curves.totals)),
        }
    };
    let tool = |diameter: f64| Tool {
        number: 1,
        diameter,
        corner_radius: diameter / 2.0,
        insert_width: diameter / 4.0,
        overhang: 100.0,
        plunge_feed: 300.0,
        spindle: 1000.0,
        assembly: Default::default(),
    };
    for depth in [0.0, 40.0, 1e-9] {
        assert_eq!(fault(&|s| s.flank.layer_depth = depth), ErrorCode::LayerDepth, "{depth} mm");
    }
    assert_eq!(fault(&|s| s.flank.scallop_height = 0.0), ErrorCode::FineScallop);
    assert_eq!(fault(&|s| s.flank.tool = Some(9999)), ErrorCode::UndefinedTool);
    let thick = fault(&|s| {
        s.tools = vec![tool(60.0)];
        s.flank.tool = Some(1);
    });
    assert_eq!(thick, ErrorCode::CutterTooWide, "where it is named");
}

#[test]
fn a_cancelled_plan_says_so() {
    let setup = Setup::default();
    let workpiece = setup.allowances.workpiece_of(sample("impeller9x9.toml"));
    let tool = &flank_cutters()[24];
    let monitor = Monitor::default();
    monitor.cancel();
    let source = LayoutInputs { workpiece: &workpiece, setup: &setup, tool };
    assert!(matches!(source.plan(&monitor), Err(FlankError::Cancelled(_))));
}
