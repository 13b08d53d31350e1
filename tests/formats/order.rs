//! Parts whose file has sections or curves in another order open as they are meant, with a line, or are
//! refused.

use std::path::Path;

use vanecut::error::ErrorCode;
use vanecut::geometry::Point;
use vanecut::io::read_part;
use vanecut::part::{BladeDescription, CurveDescription, Impeller, Meridional, PartDescription};

/// A compressor wheel with sections from hub to shroud.
fn wheel() -> PartDescription {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wheels/hecc.toml");
    read_part(&path).expect("readable")
}

/// Suction and pressure sections of the main blade.
fn sides(part: &mut PartDescription) -> [&mut Vec<Vec<Point>>; 2] {
    match &mut part.main {
        BladeDescription::Sections { suction, pressure, .. } => [suction, pressure],
        BladeDescription::Camber { .. } => panic!("the wheel has sections"),
    }
}

/// Largest distance of the surfaces of two parts at equal places, mm.
fn apart(one: &Impeller, other: &Impeller) -> f64 {
    let mut worst: f64 = 0.0;
    for k in 0..=20 {
        let x = f64::from(k) / 20.0;
        for (a, b) in [(&one.hub, &other.hub), (&one.shroud, &other.shroud)] {
            worst = worst.max(a.point(x).distance(b.point(x)));
        }
        for (a, b) in
            std::iter::once((&one.main, &other.main)).chain(one.splitters.iter().zip(&other.splitters))
        {
            for v in [0.0, 0.3, 0.7, 1.0] {
                worst = worst.max((a.suction.point(x, v) - b.suction.point(x, v)).norm());
                worst = worst.max((a.pressure.point(x, v) - b.pressure.point(x, v)).norm());
            }
        }
    }
    worst
}

/// Checks that a changed wheel is the one it was, with one note that has these words.
fn same_with_a_note(change: impl FnOnce(&mut PartDescription), words: &str) {
    let mut description = wheel();
    let before = Impeller::build(&description).expect("an impeller");
    assert!(before.notes.is_empty(), "{:?}", before.notes);
    change(&mut description);
    let after = Impeller::build(&description).unwrap_or_else(|error| panic!("{words}: {error}"));
    assert!(after.notes.len() == 1 && after.notes[0].contains(words), "{words}: {:?}", after.notes);
    let off = apart(&before, &after);
    assert!(off < 1e-6, "{words}: {off} mm off");
}

#[test]
fn sections_from_shroud_to_hub_are_taken_in_reverse() {
    let all = "the sections of the main blade run from shroud to hub";
    same_with_a_note(|part| sides(part).into_iter().for_each(|side| side.reverse()), all);
    let one = "the sections of the pressure side of the main blade run from shroud to hub";
    same_with_a_note(|part| sides(part)[1].reverse(), one);
}

#[test]
fn exchanged_sections_are_sorted() {
    let note = "the sections of the main blade are not in order from hub to shroud";
    same_with_a_note(|part| sides(part).into_iter().for_each(|side| side.swap(3, 8)), note);
    let note = "the sections of the suction side of the main blade are not in order";
    same_with_a_note(|part| sides(part)[0].swap(0, 1), note);
}

#[test]
fn sections_from_trailing_to_leading_edge_are_reversed_one_by_one() {
    let note = "section 4 of the pressure side of the main blade runs from trailing to leading edge";
    same_with_a_note(|part| sides(part)[1][3].reverse(), note);
    let note = "sections 1, 11 of the main blade run from trailing to leading edge";
    same_with_a_note(
        |part| sides(part).into_iter().for_each(|s| [0, 10].into_iter().for_each(|k| s[k].reverse())),
        note,
    );
    let note = "the sections of the main blade run from trailing to leading edge";
    same_with_a_note(|part| sides(part).into_iter().flatten().for_each(|section| section.reverse()), note);
}

#[test]
fn a_section_given_twice_is_left_out_once() {
    let twice = |part: &mut PartDescription| {
        for side in sides(part) {
            let section = side[5].clone();
            side.insert(5, section);
        }
    };
    same_with_a_note(twice, "a section of the main blade is given twice");
}

#[test]
fn a_blade_without_thickness_is_refused() {
    let mut description = wheel();
    let [suction, pressure] = sides(&mut description);
    pressure.clone_from(suction);
    let error = Impeller::build(&description).map(|_| ()).expect_err("one surface");
    assert_eq!(error.code, ErrorCode::BladeValues, "{error}");
    assert!(error.message.contains("no thickness"), "{error}");
}

fn points(curve: &mut CurveDescription) -> &mut Vec<Meridional> {
    match curve {
        CurveDescription::Points(points) => points,
        CurveDescription::BSpline { .. } => panic!("the wheel has points"),
    }
}

#[test]
fn curves_from_outlet_to_inlet_are_reversed() {
    same_with_a_note(|part| points(&mut part.hub).reverse(), "the hub is given from outlet to inlet");
    same_with_a_note(|part| points(&mut part.shroud).reverse(), "the shroud is given from outlet to inlet");
    // A blade of camber lines, between splines with knots.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller532.toml");
    let mut description = read_part(&path).expect("readable");
    let before = Impeller::build(&description).expect("an impeller");
    for curve in [&mut description.hub, &mut description.shroud] {
        match curve {
            CurveDescription::Points(points) => points.reverse(),
            CurveDescription::BSpline { control, knots, .. } => {
                control.reverse();
                *knots = knots.iter().rev().map(|k| 1.0 - k).collect();
            }
        }
    }
    let after = Impeller::build(&description).expect("an impeller");
    assert_eq!(after.notes.len(), 2, "{:?}", after.notes);
    let off = apart(&before, &after);
    assert!(off < 1e-3, "{off} mm off");
}

/// The profile of a hub with bore and back: `points` run from the inlet to the rim.
fn body(points: &[Meridional]) -> Vec<Meridional> {
    let (first, rim) = (points[0], points[points.len() - 1]);
    let back = rim.z + 3.0 * (rim.z - first.z).signum();
    let bore = 0.5 * first.r;
    let at = |r: f64, z: f64| Meridional { r, z };
    let mut body = vec![at(bore, first.z)];
    body.extend(points);
    body.extend([at(rim.r, back), at(0.5 * rim.r, back), at(bore, back), at(bore, first.z)]);
    body
}

#[test]
fn of_the_profile_of_a_whole_hub_the_side_towards_the_blades_is_used() {
    let note = "the hub is the profile of its body";
    same_with_a_note(|part| part.hub = CurveDescription::Points(body(points(&mut part.hub))), note);
    // A face before the blades as near to the shroud as the one behind them.
    let mut description = wheel();
    let shroud = points(&mut description.shroud).clone();
    let beside = |off: f64| shroud.iter().map(move |p| Meridional { r: p.r, z: p.z + off });
    let mut both: Vec<Meridional> = beside(-0.4).collect();
    let rim = shroud.iter().map(|p| p.r).fold(0.0, f64::max);
    both.extend([-0.4, 0.4].map(|off| Meridional { r: rim + 1.0, z: shroud[shroud.len() - 1].z + off }));
    both.extend(beside(0.4).collect::<Vec<_>>().into_iter().rev());
    description.hub = CurveDescription::Points(both);
    let error = Impeller::build(&description).map(|_| ()).expect_err("two sides");
    assert!(error.message.contains("the hub runs past the rim"), "{error}");
}

#[test]
fn a_size_that_no_wheel_has_is_asked_about() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let text = std::fs::read_to_string(path).expect("readable");
    let read = |text: &str| vanecut::io::read_part_bytes("a.toml", text.as_bytes(), "toml").expect("a part");
    assert!(read(&text).notes.is_empty());
    // The curves in metres; the blades follow from angles.
    let scaled = |line: &str| -> Option<String> {
        let (r, z) = line.trim().strip_prefix('[')?.strip_suffix("],")?.split_once(", ")?;
        let metres = |mm: &str| mm.parse::<f64>().ok().map(|mm| mm * 0.001);
        Some(format!("[{}, {}],", metres(r)?, metres(z)?))
    };
    let curves: Vec<String> = text.lines().map(|line| scaled(line).unwrap_or_else(|| line.into())).collect();
    let curves = curves.join("\n");
    let notes = read(&curves).notes;
    assert!(notes.len() == 1 && notes[0].contains("mm across"), "{notes:?}");
}
