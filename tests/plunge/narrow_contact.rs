//! Contact that is narrower than the lines of a core are apart, and corners of the blank: against other
//! methods.

use std::f64::consts::FRAC_PI_6;

use vanecut::cutting::contact::{BlankTop, Columns, PlungeColumn, core_contact};
use vanecut::cutting::retract::RetractSurface;
use vanecut::geometry::{Circle, CutterSolid, Meridional, Point, Vector};
use vanecut::monitor::Monitor;
use vanecut::part::{Blank, Impeller, Workpiece};
use vanecut::stock::solid::{SolidBlank, SolidProgram, SolidStock, ToolPart, TurnedOutline};
use vanecut::toolpath::ClProgram;

use super::goals::WHOLE;
use super::probe::kj66;
use super::samples::{sample, sample_plans};

/// The next pseudo-random number in −1…1 (linear congruential, Knuth's constants).
fn next(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Random cutters near the hub of a wheel, with axes that lead out of it in all directions, also nearly along
/// the shroud or far across the passage.
fn random_cutters<'a>(part: &'a Impeller, state: &'a mut u64) -> impl Iterator<Item = CutterSolid> + 'a {
    let size = part.rim_radius();
    let cutter = move |_| {
        let s = 0.5 + 0.5 * next(state);
        let (foot, normal) = (part.hub.point(s), part.hub.normal(s));
        let axis = normal.direction_at_angle(0.0) + Vector::from_fn(|_, _| 2.0 * next(state));
        let tip = foot.lerp(part.shroud.point(s), 0.05 + 0.1 * next(state).abs()).at_angle(0.0);
        let radius = size * (0.02 + 0.06 * next(state).abs());
        Some(CutterSolid { tip, axis: axis.try_normalize(0.1)?, radius, corner_radius: 0.0 })
    };
    (0..400).filter_map(cutter)
}

/// Height that stock may have between the lines of a cutter that are looked at, in radii: the border of the
/// blank may be steep there.
const SLIVER_RADII: f64 = 0.15;

/// Height above its tip of the highest stock of `blank` on the axis of `cutter` and on the lines at `radius`
/// mm about it, mm; 0 where there is none. Short chords at the rim are not counted.
fn highest_stock(blank: &Blank, cutter: &CutterSolid, radius: f64) -> f64 {
    let rim = Circle::new(&cutter.tip, &cutter.axis, radius);
    let around = (0..12).map(|i| rim.point_and_derivative((FRAC_PI_6 * f64::from(i) + 0.1).sin_cos()).0);
    let step = 0.008 * blank.extent().0;
    let highest = |line: Point| {
        let solid = |h: f64| blank.depth(Meridional::from_point(&(line + cutter.axis * h))) > 0.0;
        let heights = (1..=400).rev().map(|k| f64::from(k) * step);
        heights.into_iter().find(|&h| solid(h) && solid(h - step)).unwrap_or(0.0)
    };
    around.chain([cutter.tip]).map(highest).fold(0.0, f64::max)
}

/// Nothing is cut before, so that the core meets the blank up to where it leaves it.
#[test]
fn a_core_meets_all_of_a_blank_that_nothing_was_cut_from() {
    let mut state = 5;
    for part in [kj66(), sample("impeller532"), sample("pump6")] {
        let blank = Blank::from_part(&part, 0.0);
        let top = BlankTop::new(&blank);
        for cutter in random_cutters(&part, &mut state) {
            let core_radius = 0.5 * cutter.radius;
            let column = PlungeColumn::new(cutter, core_radius, &top);
            let highest = highest_stock(&blank, &cutter, 0.999 * core_radius);
            let found = core_contact(&column, Columns::default().all(), &blank).depth;
            let missed = highest - found;
            assert!(
                missed < SLIVER_RADII * core_radius,
                "{}, {cutter:?}: {found}, not {highest} mm",
                part.name
            );
        }
    }
}

/// From the retract height on, nothing of the blank is under the bottom of a cutter.
#[test]
fn a_retracted_cutter_is_above_all_of_the_blank() {
    let mut state = 5;
    for part in [kj66(), sample("impeller532"), sample("pump6")] {
        let blank = Blank::from_part(&part, 0.0);
        let top = RetractSurface::new(&blank, 0.5);
        for cutter in random_cutters(&part, &mut state) {
            // The flat part of the bottom of an end mill, and that of a ball.
            for flat in [cutter.radius, 0.0] {
                let highest = highest_stock(&blank, &cutter, 0.999 * flat);
                let found = top.height(&cutter.tip, &cutter.axis, flat);
                let missed = highest - found;
                assert!(
                    missed < SLIVER_RADII * cutter.radius,
                    "{}, {cutter:?}, flat {flat}: {found}, not {highest} mm",
                    part.name
                );
            }
        }
    }
}

#[test]
fn chords_across_corners_of_the_blank_are_found() {
    let blank = Blank::from_part(&WHOLE.workpiece.part, 0.0);
    let shroud = &blank.shroud;
    let corners = [shroud.point(0.0), shroud.point(shroud.length())];
    let inside = blank.hub.point(0.5 * blank.hub.length()).lerp(shroud.point(0.5 * shroud.length()), 0.5);
    let mut state = 11;
    let mut short = 0;
    for case in 0..400 {
        let corner = corners[case % 2];
        // A point at most 0.4 mm inside the corner, and a line through it.
        let near = corner.lerp(inside, 0.4 * next(&mut state).abs() / corner.distance(inside));
        let direction = Vector::from_fn(|_, _| next(&mut state));
        let Some(direction) = direction.try_normalize(0.1) else { continue };
        let origin = Point::new(near.r, 0.0, near.z) - direction * 15.0;
        let found = blank.highest_inside(&origin, &direction, 0.0, 30.0, &mut None);
        let solid = |h: f64| blank.is_solid(Meridional::from_point(&(origin + direction * h)), &mut None);
        let samples: Vec<f64> = (0..=6000).map(|k| f64::from(k) * 0.005).filter(|&h| solid(h)).collect();
        let Some(&highest) = samples.last() else { continue };
        let unbroken = |(h, k): &(&f64, i32)| (highest - **h - 0.005 * f64::from(*k)).abs() < 1e-6;
        let chord = samples.iter().rev().zip(0..).take_while(unbroken).count();
        if chord < 5 {
            // Shorter than a stride.
            continue;
        }
        short += usize::from(chord < 100);
        let found = found.unwrap_or(f64::NEG_INFINITY);
        assert!(
            (found - highest).abs() < 0.006,
            "case {case}: {found} instead of {highest}, {chord} samples"
        );
    }
    assert!(short > 50, "{short} chords shorter than 0.5 mm");
}

/// Plunges at the inlet run nearly along the front face of the blank and come into it from the side, far
/// above the floor.
#[test]
fn a_column_reaches_up_to_where_the_last_of_its_lines_leaves_the_blank() {
    let blank = Blank::from_part(&WHOLE.workpiece.part, 0.0);
    let top = BlankTop::new(&blank);
    let (hub, shroud) = (blank.hub.point(0.0), blank.shroud.point(0.0));
    let mut state = 5;
    let mut high = 0;
    for case in 0..200 {
        let from = hub.lerp(shroud, 0.1 + 0.1 * next(&mut state));
        let tip = Point::new(from.r, 0.0, from.z) + Vector::z() * (2.0 + next(&mut state));
        let axis = Vector::new(1.0, 0.4 * next(&mut state), 0.2 * next(&mut state)).normalize();
        let radius = 1.5 + next(&mut state);
        let cutter = CutterSolid { tip, axis, radius: 2.0 * radius, corner_radius: 0.0 };
        let column = PlungeColumn::new(cutter, radius, &top);
        let rim = Circle::new(&tip, &axis, radius);
        let leaves = (0..360).filter_map(|i| {
            let (origin, _) = rim.point_and_derivative(f64::from(i).to_radians().sin_cos());
            blank.highest_inside(&origin, &axis, 0.0, 500.0, &mut None)
        });
        let highest = leaves.fold(0.0, f64::max);
        high += usize::from(highest > 20.0);
        assert!(column.top > highest - 1e-3, "case {case}: up to {}, lines up to {highest}", column.top);
    }
    assert!(high > 50, "{high} of 200 columns are in the blank far up");
}

#[test]
fn the_solid_finds_no_core_in_stock_where_a_plan_is_free() {
    // On the second wheel plunges at the inlet run along the front face.
    for outcome in [&*WHOLE, sample_plans("impeller532")] {
        let Workpiece { part, blank, .. } = &*outcome.workpiece;
        let outline = SolidBlank::Turned(TurnedOutline::of_blank(part, blank));
        let spacing = outline.default_spacing();
        for plan in [&outcome.after.plan, outcome.whole.as_ref().unwrap_or(&outcome.after.plan)] {
            let program = ClProgram::of_plan(&part.name, plan);
            let program = SolidProgram::new(&program, &outcome.setup).expect("it has tools");
            let mut stock = SolidStock::new(&outline, spacing).expect("it fits");
            let contacts =
                stock.make_moves(&program.tools, &program.moves, &Monitor::default()).expect("it ends");
            let deepest = contacts
                .iter()
                .filter(|contact| contact.part == ToolPart::Core)
                .map(|contact| contact.depth)
                .fold(0.0, f64::max);
            assert!(deepest < spacing, "{}: a core meets stock, {deepest} mm above its bottom", part.name);
        }
    }
}
