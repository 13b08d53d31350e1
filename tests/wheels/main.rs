//! Random wheels: they are read, assessed, planned by every policy and verified.
//!
//! The default test run takes a few; `scripts/nightly` takes more, chosen by the variables `WHEELS_SEED` and
//! `WHEELS_COUNT`.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod formats;
mod judge;
mod leaning;
mod make;
mod sampled_tool;

use vanecut::assess::Assessment;
use vanecut::assess::reach::ReachLimits;
use vanecut::flank::LayoutInputs;
use vanecut::flank::choice::choose_tool;
use vanecut::geometry::wrap_angle;
use vanecut::io::part_file::read_part_bytes;
use vanecut::io::tool_library::flank_cutters;
use vanecut::io::write_native;
use vanecut::job::flank::{FlankJob, FlankRequest};
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::{Channel, Impeller};
use vanecut::setup::{AxisPolicy, CutDirection, FlankStrategy, SectionKind, Setup};
use vanecut::stock::{FloorGrid, FloorSource};

use make::Wheel;

/// The part of a wheel, written to a file and read back.
fn open(wheel: &Wheel) -> Impeller {
    let name = &wheel.description.name;
    let text = write_native(&wheel.description);
    let description = read_part_bytes(&format!("{name}.toml"), text.as_bytes(), "toml")
        .expect("what is written is readable");
    Impeller::build(&description).unwrap_or_else(|e| panic!("{name} ({}): {e}", wheel.remarks))
}

/// The least-stock plan of a wheel with the default setup.
fn planned(part: Impeller) -> PlanOutcome {
    let request = PlanRequest {
        setup: Setup::for_part(&part),
        part: part.into(),
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 128,
    };
    run(&request, &Monitor::default()).expect("a plan")
}

#[test]
fn the_same_seed_makes_the_same_wheels() {
    for index in [2, 18] {
        let text = |seed: u64| write_native(&make::wheel(seed, index).description);
        assert_eq!(text(5), text(5));
        assert_ne!(text(5), text(6));
    }
}

#[test]
fn every_kind_of_wheel_opens() {
    for seed in 1..=4 {
        for index in 0..20 {
            open(&make::wheel(seed, index));
        }
    }
}

#[test]
fn no_cutter_is_wider_than_the_passage_it_stands_in() {
    let limits = ReachLimits {
        hub_allowance: 0.1,
        blade_allowance: 0.1,
        max_tilt_rad: 0.5,
        clearances: Default::default(),
    };
    // All kinds of wheels in the nightly run, every fifth in the default one.
    let step = if is_gate() { 5 } else { 1 };
    for index in (0..20).step_by(step) {
        let wheel = make::wheel(1, index);
        let (name, part) = (&wheel.description.name, open(&wheel));
        let workpiece = Setup::for_part(&part).allowances.workpiece_of(part.clone());
        let found = Assessment::from_workpiece(&workpiece, &[], &limits);
        let largest = found.largest_cutter();
        assert!(largest > 0.0 && largest.is_finite(), "{name}: largest cutter {largest}");
        for passage in &found.passages {
            for cutter in &passage.cutters {
                let place = format!("{name}, {} at s = {:.2}", passage.blades.label(), cutter.s);
                assert!(
                    cutter.diameter <= cutter.section_width + 1e-6,
                    "{place}: D {} in a passage {} wide",
                    cutter.diameter,
                    cutter.section_width
                );
                let pitch = part.pitch().abs() * part.hub.point(cutter.s).r;
                assert!(cutter.section_width <= pitch, "{place}: {} of {pitch}", cutter.section_width);
            }
        }
        let flat = name.ends_with("cylindrical");
        let turn = found.blades[0].shape.normal_turn_rad.to_degrees();
        assert!(!flat || turn < 3.0, "{name}: cylindrical blades turn by {turn}°");
    }
}

/// The tangent of a flank that runs nearly across the meridional direction leaves the flow path before it
/// gets far along it: rows that ended where it does left whole inlets uncut.
#[test]
fn walls_bound_the_passage_from_the_leading_edge_to_the_rim() {
    for index in 0..20 {
        let wheel = make::wheel(53, index);
        let part = open(&wheel);
        for (number, wall) in Channel::from_part(&part).full.walls.iter().enumerate() {
            for eta in [0.0, 0.3, 1.0] {
                let theta = |s: f64| wall.at(&part, s, eta).map(|place| place.theta);
                let mut before = theta(-0.1);
                for i in -99..=1100 {
                    let s = f64::from(i) / 1000.0;
                    let place = format!("{}, wall {number}, s {s}, η {eta}", wheel.description.name);
                    let here = theta(s);
                    assert!(here.is_some(), "{place}: no wall");
                    let jump = before.zip(here).map_or(0.0, |(a, b)| wrap_angle(a - b).abs());
                    assert!(jump < 0.1, "{place}: turns by {jump} rad");
                    before = here;
                }
            }
        }
    }
}

/// Wheels of the default test run, (seed, index): several kinds, chosen for plans with few positions.
const GATE: [(u64, usize); 2] = [(7, 9), (1, 11)];

/// Blades that lean along the rows let no axis lean towards the inlet; from the outlet more than half of the
/// floor would stay uncut.
#[test]
#[ignore = "a plan of 13 s; scripts/nightly runs it"]
fn blades_that_lean_along_the_rows_are_cut_from_the_inlet() {
    // Both in the nightly run.
    let wheels = [(9, 22), (41, 42)];
    for (seed, index) in wheels.into_iter().take(if is_gate() { 1 } else { 2 }) {
        let wheel = make::wheel(seed, index);
        let part = open(&wheel);
        let outcome = planned(part);
        let place = format!("seed {seed}, {} ({})", wheel.description.name, wheel.remarks);
        let sections = &outcome.setup.plunge.sections;
        let from_inlet: Vec<_> = sections
            .iter()
            .filter(|section| section.cut_direction == Some(CutDirection::InletToOutlet))
            .collect();
        assert!(from_inlet.len() > 1, "{place}: {sections:?}");
        assert_eq!(from_inlet[0].to, 0.0, "{place}: the innermost one first");
        assert!(from_inlet.windows(2).all(|pair| pair[0].from == pair[1].to), "{place}: then outwards");
        let summary = &outcome.after.summary;
        assert_eq!(summary.interfering, 0, "{place}");
        assert!(summary.uncut_share < 0.05, "{place}: {} uncut", summary.uncut_share);
    }
}

/// In a narrow passage between leaning blades no first core is free at the outlet, so that none behind it is;
/// from the inlet, where rows begin beside what an earlier section cut, nearly all of the floor is cut.
#[test]
#[ignore = "a plan of a minute; scripts/nightly runs it"]
fn sections_that_starve_from_the_outlet_are_cut_from_the_inlet() {
    let bytes = leaning::leaning_wheel();
    let description = read_part_bytes("leaning.toml", bytes.as_bytes(), "toml").expect("a part");
    let outcome = planned(Impeller::build(&description).expect("a wheel"));
    let sections = &outcome.setup.plunge.sections;
    let rows = sections.iter().filter(|section| section.kind == SectionKind::Rows);
    let directions: Vec<_> = rows.map(|section| section.cut_direction).collect();
    assert!(directions.len() > 1, "{sections:?}");
    assert!(directions.iter().all(|direction| *direction == Some(CutDirection::InletToOutlet)));
    let summary = &outcome.after.summary;
    assert_eq!(summary.interfering, 0);
    assert!(summary.uncut_share < 0.06, "{} uncut", summary.uncut_share);
}

/// Between walls that the cutter just passes the rows in the middle have no axis at all, those beside the
/// walls do: these end where their own axes do, not where those of their neighbours end.
#[test]
#[ignore = "a plan of half a minute; scripts/nightly runs it"]
fn rows_beside_walls_go_on_where_those_between_them_end() {
    let wheel = make::wheel(83, 34);
    let part = open(&wheel);
    let outcome = planned(part);
    let summary = &outcome.after.summary;
    assert_eq!(summary.interfering, 0, "{}", wheel.remarks);
    assert!(summary.uncut_share < 0.03, "{}: {} uncut", wheel.remarks, summary.uncut_share);
    let before_throat = outcome.after.plan.positions.iter().filter(|p| p.s < 0.1).count();
    assert!(before_throat > 20, "{}: {before_throat} plunges", wheel.remarks);
}

/// Under walls that lean over the channel a strip of floor needs axes that lean further than the walls do:
/// without them 3.8 and 4 % of the floor stayed uncut.
#[test]
#[ignore = "a plan of half a minute; scripts/nightly runs it"]
fn strips_under_leaning_walls_are_cut() {
    let wheel = make::wheel(127, 16);
    let outcome = planned(open(&wheel));
    let summary = &outcome.after.summary;
    let place = format!("seed 127, {} ({})", wheel.description.name, wheel.remarks);
    assert_eq!(summary.interfering, 0, "{place}");
    assert!(summary.uncut_share < 0.02, "{place}: {} uncut", summary.uncut_share);
    let allowance = outcome.setup.allowances.blade_allowance;
    assert!(summary.min_blade_clearance > allowance - 1e-5, "{place}: {}", summary.min_blade_clearance);
    let limit = outcome.setup.plunge.max_axis_change_rad;
    assert!(summary.max_axis_change_rad < limit + 1e-9, "{place}: {}", summary.max_axis_change_rad);
}

/// A plunge that clears a core only between two of the lines on which contact is evaluated is needed as well:
/// where it was left out as not worth its time, a later core met a sliver of stock .46 mm above its bottom.
#[test]
#[ignore = "a plan of 16 s; scripts/nightly runs it"]
fn cores_stay_free_where_plunges_are_left_out() {
    let wheel = make::wheel(53, 1);
    let outcome = planned(open(&wheel));
    let summary = &outcome.after.summary;
    let whole = outcome.whole.expect("plunges are left out").positions.len();
    assert!(summary.positions < whole, "{}: {whole} plunges", wheel.remarks);
    assert_eq!((summary.interfering, summary.max_contact_depth < 0.02), (0, true), "{}", wheel.remarks);
}

/// At slanted edges the blank ends a little above the hub: what may not be removed there is not left uncut.
#[test]
fn floor_that_holds_only_its_allowance_is_not_left_uncut() {
    let wheel = make::wheel(53, 22);
    let part = open(&wheel);
    let setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(std::sync::Arc::new(part));
    let grid = FloorGrid::new(&FloorSource::of_setup(&workpiece, &setup, &[]), 128);
    let allowance = setup.allowances.hub_allowance as f32;
    let thin: Vec<usize> = (0..grid.floor.len())
        .filter(|&cell| grid.floor[cell] && grid.blank_heights[cell] <= allowance)
        .collect();
    assert!(thin.len() > 100, "{}: {} cells", wheel.remarks, thin.len());
    assert!(thin.iter().all(|&cell| !grid.reachable[cell]), "{}", wheel.remarks);
}

/// Between two positions the tip moves straight. Where it rises while the axis turns, the axis gets nearer to
/// the wall than where its low point moves straight: 5.6 µm below the allowance.
#[test]
fn flanks_cut_no_wall_deeper_than_5_um() {
    let wheel = make::wheel(31, 7);
    let part = open(&wheel);
    let request = FlankRequest { setup: Setup::for_part(&part), part: part.into() };
    let outcome = FlankJob::default().run(&request, &Monitor::default()).expect("a plan");
    let overcut = outcome.max_overcut();
    assert!(overcut <= judge::MAX_OVERCUT, "{}: {overcut} mm over", wheel.remarks);
    // What cuts a little too deep is moved, not left out.
    let left =
        outcome.plan.uncut.iter().filter(|left| left.why.message.contains("would come too near to a blade"));
    assert_eq!(left.count(), 0, "{:?}", outcome.plan.uncut);
}

/// Few deep layers with few passes side by side, of which one more in a region counts.
#[test]
fn layers_of_constant_depth_are_never_longer_than_isoparametric_ones() {
    let mut replaced = Vec::new();
    for index in 0..20 {
        let wheel = make::wheel(4, index);
        let part = open(&wheel);
        let mut setup = Setup::for_part(&part);
        setup.flank.strategy = FlankStrategy::Layers;
        setup.flank.layer_depth *= 3.0;
        setup.flank.scallop_height *= 8.0;
        let workpiece = setup.allowances.workpiece_of(part);
        let tool = &choose_tool(&workpiece, &setup, flank_cutters()).expect("a cutter").tool;
        let inputs = LayoutInputs { workpiece: &workpiece, setup: &setup, tool };
        let layout = inputs.plan(&Monitor::default()).expect("passes");
        let [isoparametric, layers] =
            [FlankStrategy::Isoparametric, FlankStrategy::Layers].map(|s| layout.totals[s as usize].length);
        let written: f64 =
            layout.layers.iter().flat_map(|l| l.pass_curves.iter().map(|c| c.length(&l.layer))).sum();
        assert!(written > 0.0 && written <= isoparametric * (1.0 + 1e-9), "{}", wheel.remarks);
        assert_eq!(layout.replacement_note().is_some(), layers > isoparametric, "{}", wheel.remarks);
        if layers > isoparametric {
            replaced.push(index);
        }
    }
    assert!(!replaced.is_empty() && replaced.len() < 3, "{replaced:?}");
}

/// A number from an environment variable.
fn variable(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} is `{text}`, not a number")))
}

/// The wheels to plan, (seed, index), and whether they are those of the default test run.
fn wheels() -> (Vec<(u64, usize)>, bool) {
    match (variable("WHEELS_SEED"), variable("WHEELS_COUNT")) {
        (None, None) => (GATE.to_vec(), true),
        (seed, count) => {
            ((0..count.unwrap_or(200) as usize).map(|index| (seed.unwrap_or(1), index)).collect(), false)
        }
    }
}

/// Whether this is the default test run.
fn is_gate() -> bool {
    wheels().1
}

#[test]
fn wheels_are_planned_and_verified() {
    let (wheels, is_gate) = wheels();
    let first = wheels[0];
    judge_wheels(&wheels, |wheel, part| judge::faults(part, !is_gate || wheel == first));
}

#[test]
#[ignore = "plans of a made wheel, 9 s; scripts/nightly runs it"]
fn shanks_and_holders_of_random_assemblies_stay_clear() {
    let (wheels, is_gate) = wheels();
    let (wheels, schemes): (_, &[FlankStrategy]) = match is_gate {
        true => (&wheels[..1], &[FlankStrategy::Balanced]),
        false => (&wheels[..], &FlankStrategy::ALL),
    };
    judge_wheels(wheels, |(seed, index), part| {
        judge::assembly_faults(part, 1000 * seed + index as u64, schemes)
    });
}

/// Judges each wheel, (seed, index), and names those with faults.
fn judge_wheels(wheels: &[(u64, usize)], judge: impl Fn((u64, usize), &Impeller) -> Vec<String>) {
    let mut faults = Vec::new();
    for &(seed, index) in wheels {
        let wheel = make::wheel(seed, index);
        let started = std::time::Instant::now();
        let found = judge((seed, index), &open(&wheel));
        let verdict = if found.is_empty() { "good" } else { "FAULTS" };
        let name = &wheel.description.name;
        println!(
            "seed {seed}, {name}: {verdict}, {:.1} s ({})",
            started.elapsed().as_secs_f64(),
            wheel.remarks
        );
        for fault in found {
            println!("    {fault}");
            faults.push(format!("seed {seed}, {name}: {fault}"));
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
