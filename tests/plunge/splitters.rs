//! Several splitters in a pitch: passages, floor and rows beside each of them.

use vanecut::assess::Assessment;
use vanecut::assess::reach::{ReachLimits, ReachSection};
use vanecut::geometry::Point;
use vanecut::job::resolve;
use vanecut::monitor::Monitor;
use vanecut::part::{BladeDescription, Channel, Impeller};
use vanecut::plunge::Planner;
use vanecut::setup::{AxisPolicy, SectionKind, Setup};
use vanecut::stock::{FloorGrid, FloorSource, field_cutters, residual_field, statistics, stretches_of_setup};

use super::disc::{RIM, cutter, disc};

/// Radius at which the main blades begin, mm.
const BEGIN: f64 = 60.0;
/// Half the thickness of splitters, mm.
const HALF: f64 = 3.0;
/// Splitters: share of the pitch from the main blade, radius at which they begin, mm.
const SPLITTERS: [(f64, f64); 2] = [(1.0 / 3.0, 110.0), (2.0 / 3.0, 90.0)];

/// A straight radial blade from radius `from` at the angle `turn`, rad.
fn blade(from: f64, turn: f64, half: f64) -> BladeDescription {
    let side = |y: f64| {
        let point = |k: i32, z: f64| {
            let x = from + (RIM - from) * f64::from(k) / 20.0;
            Point::new(x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos(), z)
        };
        let section = |z: f64| (0..=20).map(|k| point(k, z)).collect();
        vec![section(-5.0), section(40.0)]
    };
    BladeDescription::Sections { suction: side(half), pressure: side(-half), line: 0 }
}

/// A flat disc with straight radial blades and two splitters in each pitch.
fn split_disc() -> Impeller {
    let pitch = std::f64::consts::TAU / 5.0;
    let splitters = SPLITTERS.iter().map(|&(share, from)| blade(from, share * pitch, HALF)).collect();
    disc((30.0, 20.0), 5, blade(BEGIN, 0.0, 1.5), splitters)
}

/// s at radius `r`.
fn s_at(r: f64) -> f64 {
    (r - BEGIN) / (RIM - BEGIN)
}

#[test]
fn each_splitter_divides_the_passage_that_it_stands_in() {
    let part = split_disc();
    let channel = Channel::from_part(&part);
    let counts = [80.0, 100.0, 130.0].map(|r| channel.passages_at(s_at(r)).len());
    assert_eq!(counts, [1, 2, 3]);
    let noses = channel.noses();
    assert!((noses[0][0] - s_at(90.0)).abs() < 0.01 && (noses[1][0] - s_at(110.0)).abs() < 0.01, "{noses:?}");
    // Neighbouring passages leave out the splitter between them.
    let s = s_at(130.0);
    let widths: Vec<f64> = channel
        .passages_at(s)
        .into_iter()
        .map(|k| channel.passages[k].wall_angles(&part, s, 0.0).expect("walls"))
        .map(|[from, to]| (to - from).abs() * 130.0)
        .collect();
    let third = 130.0 * part.pitch().abs() / 3.0;
    let expected = [third - 1.5 - HALF, third - 2.0 * HALF, third - 1.5 - HALF];
    assert!(
        widths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.1),
        "{widths:?}, expected {expected:?}"
    );
}

#[test]
fn the_machinability_is_that_of_all_passages() {
    let setup = Setup::default();
    let limits = ReachLimits {
        hub_allowance: 0.5,
        blade_allowance: 0.5,
        max_tilt_rad: 0.5,
        clearances: setup.clearances,
    };
    let tool = cutter(16.0, 5.0);
    let workpiece = setup.allowances.workpiece_of(split_disc());
    let sections = [ReachSection { tool: &tool, from: 1.0, to: 0.0, kind: SectionKind::Rows }];
    let found = Assessment::from_workpiece(&workpiece, &sections, &limits);
    let names: Vec<&str> = found.blades.iter().map(|blade| blade.name.as_str()).collect();
    assert_eq!(names, ["main", "splitter 1", "splitter 2"], "from the suction side of the main blade");
    let passages: Vec<String> = found.passages.iter().map(|passage| passage.blades.label()).collect();
    assert_eq!(
        passages,
        [
            "main to main blade",
            "main blade to splitter 2",
            "main blade to splitter 1",
            "splitter 1 to splitter 2",
            "splitter 2 to main blade"
        ],
        "the longer splitter divides the channel, the shorter one the passage beside it"
    );
    let keys: Vec<String> = found.passages.iter().map(|passage| passage.blades.key()).collect();
    assert_eq!(keys[1..4], ["main_to_splitter_2", "main_to_splitter_1", "splitter_1_to_splitter_2"]);
    // The narrowest place is behind the leading edge of the longer splitter, beside the main blade.
    let third = 90.0 * workpiece.part.pitch().abs() / 3.0 - 1.5 - HALF;
    let largest = found.largest_cutter();
    assert!((0.95 * third..1.05 * third).contains(&largest), "D {largest} beside {third} mm");
    // Cells of the floor lie in all three passages, and cutters reach most of them.
    let row =
        found.reach.as_ref().expect("a tool").rows.iter().find(|row| row.s > s_at(130.0)).expect("a row");
    let cells = |from: f64, to: f64| {
        row.cells.iter().filter(|cell| (from..to).contains(&(3.0 * cell.lambda))).count()
    };
    assert!((0..3).all(|k| cells(f64::from(k), f64::from(k + 1)) > 10));
    assert!(row.share(|sides| sides.any) > 0.8, "{}", row.share(|sides| sides.any));
}

#[test]
fn rows_run_beside_every_splitter_and_leave_no_floor_uncut() {
    let mut asked = Setup { tools: vec![cutter(16.0, 5.0)], ..Setup::default() };
    asked.plunge.rest = false;
    let workpiece = asked.allowances.workpiece_of(split_disc());
    let setup = resolve(&asked, &workpiece).expect("a setup").setup;
    let plan =
        Planner::new(&workpiece, &setup).plan(AxisPolicy::Minimal, &Monitor::default()).expect("a plan");
    let cutters = stretches_of_setup(&setup);
    let source = FloorSource::of_setup(&workpiece, &setup, &cutters);
    let grid = FloorGrid::new(&source, 200);
    let pitch = workpiece.part.pitch();
    let in_splitter = |p: &[f32; 3]| {
        let [x, y] = [p[0], p[1]].map(f64::from);
        SPLITTERS.iter().any(|&(share, from)| {
            let off = x.hypot(y) * (y.atan2(x) - share * pitch).rem_euclid(pitch).min(1.0);
            x.hypot(y) > from + 5.0 && off < HALF - 0.5
        })
    };
    let under = grid.points.iter().zip(&grid.floor).filter(|(p, floor)| **floor && in_splitter(p));
    assert_eq!(under.count(), 0, "feet of splitters are no floor");
    let heights = residual_field(&grid, &field_cutters(&plan)).heights;
    let figures = statistics(&grid, &heights, |_| true);
    assert!(figures.uncut_share < 0.02, "{}", figures.uncut_share);
    assert!(plan.dropped.len() * 20 < plan.positions.len(), "{} left out", plan.dropped.len());
}
