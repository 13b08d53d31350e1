//! Contact that is narrower than the lines of a core are apart, and corners of the blank: against other
//! methods.

use vanecut::geometry::{Meridional, Point, Vector};
use vanecut::monitor::Monitor;
use vanecut::part::{Blank, Workpiece};
use vanecut::stock::solid::{SolidBlank, SolidProgram, SolidStock, ToolPart, TurnedOutline};
use vanecut::toolpath::ClProgram;

use super::goals::WHOLE;

/// The next pseudo-random number in −1…1 (linear congruential, Knuth's constants).
fn next(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[test]
fn chords_across_corners_of_the_blank_are_found() {
    let blank = Blank::of(&WHOLE.workpiece.part, 0.0);
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
        let solid = |h: f64| blank.is_solid(Meridional::of(&(origin + direction * h)), &mut None);
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

#[test]
fn the_solid_finds_no_core_in_stock_where_a_plan_is_free() {
    let Workpiece { part, blank, .. } = &*WHOLE.workpiece;
    let outline = SolidBlank::Turned(TurnedOutline::of_blank(part, blank));
    let spacing = outline.default_spacing();
    for plan in [&WHOLE.after.plan, WHOLE.whole.as_ref().unwrap_or(&WHOLE.after.plan)] {
        let program = SolidProgram::new(&ClProgram::of_plan("a", plan), &WHOLE.setup).expect("it has tools");
        let mut stock = SolidStock::new(&outline, spacing).expect("it fits");
        let contacts =
            stock.make_moves(&program.tools, &program.moves, &Monitor::default()).expect("it ends");
        let deepest = contacts
            .iter()
            .filter(|contact| contact.part == ToolPart::Core)
            .map(|contact| contact.depth)
            .fold(0.0, f64::max);
        assert!(deepest < spacing, "a core meets stock, {deepest} mm above its bottom");
    }
}
