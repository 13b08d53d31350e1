//! Machinability: reference values of a real compressor, and parts with known values.

use std::path::Path;

use vanecut::assess::Assessment;
use vanecut::assess::passage::PassageMeasure;
use vanecut::assess::reach::{ReachLimits, ReachMap, ReachSection, ReachSides};
use vanecut::io::read_part;
use vanecut::part::{
    BladeDescription, Channel, CurveDescription, Impeller, Meridional, PartDescription, SideProbe,
};
use vanecut::setup::{ClearanceSetup, SectionKind, Setup, Tool};

use super::samples::sample;

const LIMITS: ReachLimits = ReachLimits {
    hub_allowance: 0.5,
    blade_allowance: 0.5,
    max_tilt_rad: std::f64::consts::FRAC_PI_4,
    clearances: ClearanceSetup { shank: 1.0, holder: 1.0 },
};

fn open(path: &Path) -> Impeller {
    Impeller::build(&read_part(path).expect("readable")).expect("an impeller")
}

/// A real compressor.
fn compressor() -> Impeller {
    open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cc_autoblade/cc_autoblade.geomTurbo"))
}

fn assessed(part: &Impeller) -> Assessment {
    Assessment::from_workpiece(&Setup::default().allowances.workpiece_of(part.clone()), &[], &LIMITS)
}

#[track_caller]
fn near(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}

/// Minimum and maximum width at hub (0), half way (1) or shroud (2), mm.
fn range(passage: &PassageMeasure, height: usize) -> (f64, f64) {
    let widths = || passage.widths.iter().filter_map(|w| w.width[height]);
    (widths().fold(f64::INFINITY, f64::min), widths().fold(0.0, f64::max))
}

/// Reference values computed by independent code from the same file. It samples blades in steps of 1 %, hence
/// the tolerances: its largest tangents are at 95.4 % of the camber line, ours at 95.0 %.
#[test]
fn shape_of_a_real_compressor() {
    let part = compressor();
    let found = assessed(&part);
    let [main, splitter] = &found.blades[..] else { panic!("a main blade and a splitter") };
    near(main.twisting().to_degrees(), 76.6, 0.25, "twisting of the main blade");
    near(splitter.twisting().to_degrees(), 73.5, 0.25, "twisting of the splitter");
    near(found.twisting(), main.twisting(), 0.0, "twisting of the part");
    for (blade, wanted) in [(main, [84.8, 81.5, 77.7]), (splitter, [85.3, 82.9, 79.1])] {
        for (twist, wanted) in blade.shape.hub_mid_tip().iter().zip(wanted) {
            near(twist.max_tangent_rad.to_degrees(), wanted, 0.35, "largest tangent");
        }
        assert!(blade.envelope_gap() < 1e-9, "ruled walls have no gap: {}", blade.envelope_gap());
    }
    assert!(found.max_bow() < 1e-9, "ruled blades do not bend: {}", found.max_bow());
}

#[test]
fn passages_of_a_real_compressor() {
    let part = compressor();
    let found = assessed(&part);
    near(found.depth(), 65.35, 0.05, "depth");
    near(found.depths.iter().map(|d| d.1).fold(f64::INFINITY, f64::min), 13.6, 0.06, "least depth");
    let full = found.passage([None, None]).expect("the channel");
    let ((hub_min, hub_max), (tip_min, tip_max)) = (range(full, 0), range(full, 2));
    near(hub_min, 19.11, 0.02, "width at the hub");
    near(hub_max, 80.7, 0.1, "width at the hub");
    near(tip_min, 32.4, 0.1, "width at the tip");
    near(tip_max, 78.1, 0.4, "width at the tip");
    for (place, hub, tip) in [([None, Some(0)], 15.48, 27.36), ([Some(0), None], 14.57, 25.17)] {
        let beside = found.passage(place).expect("a passage beside the splitter");
        near(range(beside, 0).0, hub, 0.06, "width beside the splitter at the hub");
        near(range(beside, 2).0, tip, 0.08, "width beside the splitter at the tip");
    }
    let [hub, shroud] = Channel::from_part(&part).splitter_s.expect("a splitter");
    near(hub, 0.320, 0.003, "splitter on the hub");
    near(shroud, 0.429, 0.003, "splitter on the shroud");
}

/// Both search for the best axis, so a larger value than the reference is a better axis. The clearance of the
/// cutter found is measured independently.
#[test]
fn largest_cutters_of_a_real_compressor() {
    let part = compressor();
    let found = assessed(&part);
    let next = part.main.rotated(part.pitch());
    let blade = &part.splitters[0];
    let cases: [(_, _, &[(f64, f64)]); 3] = [
        (
            [None, None],
            [&part.main.suction, &next.pressure],
            &[(0.0, 21.1), (0.1, 20.6), (0.2, 25.1), (0.3, 30.8)],
        ),
        (
            [None, Some(0)],
            [&part.main.suction, &blade.pressure],
            &[(0.35, 15.5), (0.55, 22.3), (0.75, 31.2), (0.95, 41.2)],
        ),
        (
            [Some(0), None],
            [&blade.suction, &next.pressure],
            &[(0.35, 15.1), (0.55, 22.2), (0.75, 31.2), (0.95, 41.3)],
        ),
    ];
    for (place, sides, wanted) in cases {
        let passage = found.passage(place).expect("a passage");
        for &(s, wanted) in wanted {
            let cutter = passage.cutters.iter().find(|c| (c.s - s).abs() < 1e-9).expect("a cutter");
            let what = format!("{place:?} at {s}");
            assert!(cutter.diameter > wanted - 0.06, "{what}: {}, not {wanted}", cutter.diameter);
            assert!(cutter.diameter < 1.01 * wanted + 0.06, "{what}: {}, not {wanted}", cutter.diameter);
            let solid = vanecut::geometry::CutterSolid {
                tip: cutter.foot,
                axis: cutter.axis,
                radius: 0.5 * cutter.diameter,
                corner_radius: 0.0,
            };
            for side in sides {
                let clearance = SideProbe::new(side, 0.0, 1.0).nearest(&solid, 0.0, 1.0).distance;
                assert!(clearance > -1e-3, "{what}: cuts a wall by {clearance}");
            }
        }
    }
}

/// Six blades whose channels have parallel walls `width` apart: each wall is a plane along the rotation axis.
fn parallel_walls(width: f64) -> Impeller {
    let arc = |r0: f64, r1: f64, z1: f64| -> Vec<Meridional> {
        let quarter = |i: i32| (std::f64::consts::FRAC_PI_2 * f64::from(i) / 40.0).sin_cos();
        (0..=40)
            .map(quarter)
            .map(|(sin, cos)| Meridional { r: r0 + (r1 - r0) * (1.0 - cos), z: z1 * sin })
            .collect()
    };
    let (hub, shroud) = (arc(30.0, 100.0, 60.0), arc(60.0, 100.0, 40.0));
    let half_pitch = std::f64::consts::PI / 6.0;
    let wall = |curve: &[Meridional], sign: f64| {
        let on_plane = |m: &Meridional| m.at_angle(sign * (half_pitch - (0.5 * width / m.r).asin()));
        curve.iter().map(on_plane).collect::<Vec<_>>()
    };
    let side = |sign: f64| vec![wall(&hub, sign), wall(&shroud, sign)];
    let description = PartDescription {
        name: "parallel".to_owned(),
        blade_count: 6,
        count_line: 0,
        notes: Vec::new(),
        roles_by_shape: false,
        hub: CurveDescription::Points(hub.clone()),
        hub_line: 0,
        shroud: CurveDescription::Points(shroud.clone()),
        shroud_line: 0,
        main: BladeDescription::Sections { suction: side(1.0), pressure: side(-1.0), line: 0 },
        splitters: Vec::new(),
    };
    Impeller::build(&description).expect("an impeller")
}

#[test]
fn a_channel_between_parallel_walls_has_their_distance() {
    let part = parallel_walls(24.0);
    let found = assessed(&part);
    // At the ends, the nearest point of the other wall's plane may be beyond the edge of that wall.
    let full = found.passage([None, None]).expect("the channel");
    for station in full.widths.iter().filter(|w| (0.02..=0.98).contains(&w.s)) {
        for width in station.width {
            near(width.expect("measured"), 24.0, 1e-6, "width");
        }
    }
    assert!(full.cutters.len() > 15, "{} stations", full.cutters.len());
    for cutter in full.cutters.iter().filter(|c| (0.1..=0.9).contains(&c.s)) {
        near(cutter.diameter, 24.0, 0.02, "largest cutter");
    }
    assert!(found.max_bow() < 1e-9, "flat walls do not bend");
}

fn tool(diameter: f64, overhang: f64) -> Tool {
    Tool {
        number: 1,
        diameter,
        corner_radius: 0.0,
        insert_width: 0.3 * diameter,
        overhang,
        plunge_feed: 300.0,
        spindle: 3000.0,
        assembly: Default::default(),
    }
}

fn reach(part: &Impeller, tool: &Tool) -> ReachMap {
    let workpiece = Setup::default().allowances.workpiece_of(part.clone());
    ReachMap::new(&workpiece, &[ReachSection { from: 1.0, to: 0.0, tool, kind: SectionKind::Rows }], &LIMITS)
}

#[test]
fn a_slender_cutter_reaches_all_of_an_open_channel_and_a_wide_one_nothing() {
    let part = parallel_walls(24.0);
    let slender = reach(&part, &tool(12.0, 150.0));
    assert!(slender.share(|s| s.any) > 0.98, "{}", slender.share(|s| s.any));
    // 24 mm less the allowances.
    let fits = reach(&part, &tool(22.8, 150.0));
    assert!(fits.share(|s| s.any) > 0.9, "{}", fits.share(|s| s.any));
    let wide = reach(&part, &tool(23.2, 150.0));
    assert_eq!(wide.share(|s| s.any), 0.0);
}

#[test]
fn a_thin_cutter_reaches_as_much_as_a_thick_one() {
    // The cutter is thinner than the sampling of the floor: between two accessible samples, all is
    // accessible.
    let part = parallel_walls(24.0);
    for diameter in [0.4, 2.0] {
        let share = reach(&part, &tool(diameter, 150.0)).share(|s| s.any);
        assert!(share > 0.9, "D {diameter}: {share}");
    }
}

#[test]
fn a_short_overhang_leaves_what_the_holder_cannot_follow() {
    let part = sample("pump6");
    let (long, short) = (reach(&part, &tool(12.0, 80.0)), reach(&part, &tool(12.0, 30.0)));
    let all = |map: &ReachMap| {
        [map.share(|s| s.any), map.share(|s| s.outlet), map.share(|s| s.inlet), map.share(ReachSides::both)]
    };
    let (long, short) = (all(&long), all(&short));
    assert!(long[0] > 0.95, "{long:?}");
    assert!(short.iter().zip(&long).all(|(s, l)| s <= l), "{short:?} of {long:?}");
    assert!(short[3] < long[3] - 0.2, "{short:?} of {long:?}");
}

#[test]
fn stock_before_the_inlet_is_in_the_way_of_holders() {
    let part = sample("pump6");
    let tool = tool(12.0, 30.0);
    let share = |inlet_extension: f64| {
        let mut setup = Setup::default();
        setup.allowances.inlet_extension = inlet_extension;
        let workpiece = setup.allowances.workpiece_of(part.clone());
        let map = ReachMap::new(
            &workpiece,
            &[ReachSection { from: 1.0, to: 0.0, tool: &tool, kind: SectionKind::Rows }],
            &LIMITS,
        );
        map.share(|s| s.inlet)
    };
    let (short, long) = (share(0.0), share(20.0));
    assert!(long < short - 0.05, "{long} of {short} from the inlet");
}

/// Each tool is judged by itself where rest milling follows, and the whole by what either reaches.
#[test]
fn rest_milling_reaches_what_its_own_tool_does() {
    let part = sample("pump6");
    let workpiece = Setup::default().allowances.workpiece_of(part.clone());
    let (thick, thin) = (tool(30.0, 150.0), tool(10.0, 150.0));
    let section = |tool, from, to, kind| ReachSection { from, to, tool, kind };
    let map = |sections: &[ReachSection]| ReachMap::new(&workpiece, sections, &LIMITS);
    let alone = map(&[section(&thin, 1.0, 0.5, SectionKind::Rows)]).share_of_section(0, |s| s.any);
    let first = map(&[section(&thick, 1.0, 0.0, SectionKind::Rows)]);
    let both =
        map(&[section(&thick, 1.0, 0.0, SectionKind::Rows), section(&thin, 1.0, 0.5, SectionKind::Rest)]);
    assert_eq!(both.share_of_section(1, |s| s.any), alone);
    assert_eq!(both.share_of_section(0, |s| s.any), first.share(|s| s.any));
    assert!(alone > both.share_of_section(0, |s| s.any) + 0.02, "{alone}: the thinner one reaches more");
    assert!(both.share(|s| s.any) > first.share(|s| s.any) + 0.01, "{}", both.share(|s| s.any));
}

/// Two independent searches: a row is inaccessible where the cutter is larger than the largest that fits
/// nearby.
#[test]
fn reach_agrees_with_the_largest_cutter() {
    for (name, diameter) in [("impeller532", 25.0), ("pump6", 32.0)] {
        let part = sample(name);
        let map = reach(&part, &tool(diameter, 6.0 * diameter));
        let needed = diameter + 2.0 * LIMITS.blade_allowance;
        let (mut blocked, mut free) = (0, 0);
        for passage in &assessed(&part).passages {
            for cutter in passage.cutters.iter().filter(|c| (0.05..=0.95).contains(&c.s)) {
                // A cutter that cuts this floor row may be a radius away from it.
                let radius_in_s = 0.5 * diameter / part.hub.length();
                let largest_near = passage
                    .cutters
                    .iter()
                    .filter(|c| (c.s - cutter.s).abs() <= radius_in_s + 0.06)
                    .map(|c| c.diameter)
                    .fold(0.0, f64::max);
                let row = map
                    .rows
                    .iter()
                    .min_by(|a, b| (a.s - cutter.s).abs().total_cmp(&(b.s - cutter.s).abs()))
                    .expect("rows");
                let share = row.share(|s| s.any);
                if largest_near < needed {
                    assert_eq!(share, 0.0, "{name} at {}: largest cutter {largest_near}", cutter.s);
                    blocked += 1;
                }
                if cutter.diameter > 1.15 * needed {
                    assert!(share > 0.8, "{name} at {}: {share}, largest {}", cutter.s, cutter.diameter);
                    free += 1;
                }
            }
        }
        assert!(blocked > 1 && free > 1, "{name}: {blocked} stations blocked, {free} free");
    }
}
