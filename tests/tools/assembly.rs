//! Shank and holder against a part: closed forms, `verify` and `plan`.

use vanecut::cutting::assembly::{AssemblySurroundings, blade_distance, hub_distance};
use vanecut::geometry::{Frustum, Point, Vector};
use vanecut::io::{read_part_bytes, read_setup_bytes, write_setup};
use vanecut::part::{Channel, FinishedPart, Impeller};
use vanecut::setup::Setup;

/// A hub that is a cylinder of radius 30, or a plane z = 0, over its range, with a few thin blades on it.
fn wheel(hub: &str, shroud: &str) -> Impeller {
    wheel_with_blades(hub, shroud, 2.0)
}

/// The same with blades of a thickness.
fn wheel_with_blades(hub: &str, shroud: &str, t: f64) -> Impeller {
    let text = format!(
        "name = \"w\"\nblades = 3\n[hub]\npoints = {hub}\n[shroud]\npoints = {shroud}\n\
         [[main.span]]\nspan = 0.0\nangle = [[0.0, 0.0], [1.0, 0.0]]\nthickness = [[0.0, {t}], [1.0, {t}]]\n\
         [[main.span]]\nspan = 1.0\nangle = [[0.0, 0.0], [1.0, 0.0]]\nthickness = [[0.0, {t}], [1.0, {t}]]\n"
    );
    Impeller::build(&read_part_bytes("w.toml", text.as_bytes(), "toml").expect("readable")).expect("a wheel")
}

pub fn pump() -> Impeller {
    let text = include_bytes!("../../assets/parts/pump6.toml");
    Impeller::build(&read_part_bytes("pump6.toml", text, "toml").expect("readable")).expect("an impeller")
}

#[test]
fn a_holder_cone_beside_a_cylindrical_hub_in_closed_form() {
    // The cylinder is over z = 0; a curve through points waves near a bend, and ever less away from it.
    let along = |r: f64| (0..=20).map(|k| format!("[{r}, {}]", 200 - 10 * k)).collect::<Vec<_>>().join(", ");
    let part = wheel(
        &format!("[{}, [31, -12], [38, -26], [52, -36], [80, -40], [120, -41]]", along(30.0)),
        &format!("[{}, [61, -6], [66, -14], [76, -20], [95, -24], [120, -25]]", along(60.0)),
    );
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    for (off, lower, upper) in [(60.0, 10.0, 10.0), (60.0, 10.0, 24.0), (55.0, 20.0, 8.0)] {
        // Parallel axes: the widest circle is the nearest.
        let axis = Vector::new(0.0, 0.0, 1.0);
        let cone = Frustum { base: Point::new(off, 0.0, 120.0), axis, length: 40.0, radii: [lower, upper] };
        let expected = off - 30.0 - f64::max(lower, upper);
        assert!((hub_distance(&finished, &cone, 100.0) - expected).abs() < 1e-5, "{off} {lower} {upper}");
        // A radial axis: the centre of the lower end is nearest to a cylinder that it lies across.
        let axis = Vector::new(1.0, 0.0, 0.0);
        let cone = Frustum { base: Point::new(off, 0.0, 140.0), axis, length: 40.0, radii: [lower, upper] };
        let rim = off - 30.0;
        assert!((hub_distance(&finished, &cone, 100.0) - rim).abs() < 1e-5, "{off} {lower} {upper}");
    }
}

#[test]
fn a_holder_cone_above_a_plane_hub_in_closed_form() {
    let part = wheel("[[20, 0], [60, 0], [100, 0], [140, 0]]", "[[20, 40], [60, 40], [100, 40], [140, 40]]");
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    for tilt_deg in [0.0f64, 10.0, 25.0, 60.0] {
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        let axis = Vector::new(0.0, sin, cos);
        let base = Point::new(80.0, 0.0, 30.0);
        for [lower, upper, length] in [[15.0, 15.0, 30.0], [12.0, 22.0, 20.0], [5.0, 25.0, 12.0]] {
            let cone = Frustum { base, axis, length, radii: [lower, upper] };
            // The lowest point of either rim.
            let expected = (base.z - lower * sin).min(base.z + length * cos - upper * sin);
            let found = hub_distance(&finished, &cone, 200.0);
            assert!((found - expected).abs() < 1e-5, "{tilt_deg}° {lower} {upper}: {found}, not {expected}");
        }
    }
}

#[test]
fn blades_are_measured_as_by_dense_samples() {
    let part = pump();
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    let mut near = 0;
    for k in 0..24 {
        let a = f64::from(k) * 0.7;
        let r = part.rim_radius() * (0.5 + 0.02 * f64::from(k));
        let base = Point::new(r * a.cos(), r * a.sin(), 5.0 + f64::from(k % 5) * 4.0);
        let axis = Vector::new(0.3 * a.sin(), 0.2, 1.0).normalize();
        let cone = Frustum { base, axis, length: 25.0, radii: [6.0, 6.0 + f64::from(k % 4) * 3.0] };
        let found = blade_distance(&finished, &cone, 1000.0);
        let mut sampled = f64::INFINITY;
        for side in &channel.sides {
            for turn in 0..part.blade_count {
                let side = side.rotated(part.pitch() * turn as f64);
                for (i, j) in (0..=120).flat_map(|i| (0..=30).map(move |j| (i, j))) {
                    let p = side.point(f64::from(i) / 120.0, f64::from(j) / 30.0);
                    sampled = sampled.min(cone.distance(&p));
                }
            }
        }
        assert!(found < sampled + 1e-6, "{k}: {found} is not the least, {sampled} is there");
        assert!(found > sampled - 1.5, "{k}: {found} is far below {sampled}");
        near += usize::from(found < 30.0);
    }
    assert!(near > 5, "some are near");
}

#[test]
fn the_tip_and_the_blunt_end_of_a_thick_blade_are_in_the_way() {
    let (hub, shroud) =
        ("[[20, 0], [60, 0], [100, 0], [140, 0]]", "[[20, 40], [60, 40], [100, 40], [140, 40]]");
    let part = wheel_with_blades(hub, shroud, 12.0);
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    for blade in 0..part.blade_count {
        let turn = part.pitch() * blade as f64;
        // Thin pins over the middle of the tip, and beside the middle of the trailing edge.
        let pins = [
            (Point::new(80.0, 0.5, 42.0), Vector::z(), 2.0),
            (Point::new(143.0, 0.5, 20.0), Vector::x(), 143.0 - (140.0f64.powi(2) - 36.0).sqrt()),
        ];
        for (base, axis, expected) in pins {
            let (base, axis) =
                (vanecut::geometry::rotate_z(&base, turn), vanecut::geometry::rotate_vector_z(&axis, turn));
            let pin = Frustum { base, axis, length: 20.0, radii: [1.0, 1.0] };
            let found = blade_distance(&finished, &pin, 100.0);
            assert!((found - expected).abs() < 0.02, "{blade}: {found}, not {expected}");
        }
    }
}

const ASSEMBLY: &str = r#"[stock]
material = "1.4571"
[clearance]
shank = 0.2
holder = 1.5
[[tool]]
diameter = 12.0
overhang = 60.0
name = "D12 Z3"
flute_length = 20.0
teeth = 3
taper = 1.5
shank = [[11.0, 20.0], [10.0, 10.0]]
holder = [[20.0, 30.0, 25.0], [40.0, 40.0, 30.0]]
length_offset = 4
diameter_offset = 5
feed_per_tooth = 0.1
cutting_speed = 100
"#;

#[test]
fn a_setup_carries_the_assembly() {
    let setup = read_setup_bytes("s.toml", ASSEMBLY.as_bytes()).expect("reads");
    assert_eq!(read_setup_bytes("s.toml", write_setup(&setup).as_bytes()).expect("reads"), setup);
    let tool = &setup.tools[0];
    assert!((tool.spindle - 100e3 / (std::f64::consts::PI * 12.0)).abs() < 1e-9, "from the cutting speed");
    assert!((tool.plunge_feed - 0.3 * tool.spindle).abs() < 1e-9, "from the feed per tooth");
    let segments = tool.assembly.segments(tool.overhang);
    let ends: Vec<(f64, f64)> = segments.iter().map(|s| (s.from, s.from + s.length)).collect();
    // The last segment of the shank runs on to the holder.
    assert_eq!(ends, [(20.0, 40.0), (40.0, 60.0), (60.0, 85.0), (85.0, 115.0)]);
    assert_eq!((setup.clearances.shank, setup.clearances.holder), (0.2, 1.5));
    assert_eq!(
        read_setup_bytes("s.toml", b"[[tool]]\ndiameter = 5\n").unwrap().clearances,
        Setup::default().clearances
    );
}

#[test]
fn the_stick_out_frees_the_holder_and_no_shorter_one_does() {
    let part = pump();
    let channel = Channel::from_part(&part);
    let finished = FinishedPart::new(&part, &channel.sides);
    let text = "[[tool]]\ndiameter = 4\noverhang = 6\nholder = [[30, 40, 40]]\n";
    let setup = read_setup_bytes("s.toml", text.as_bytes()).expect("reads");
    let tool = &setup.tools[0];
    let around = AssemblySurroundings::new(&finished, &setup);
    let foot = part.hub.point(0.6);
    let pose = (foot.at_angle(0.2), part.hub.at(0.6).normal.direction_at_angle(0.2));
    let missing =
        |overhang: f64| around.at(tool, &tool.assembly.segments(overhang), pose, 0.0).holder.missing;
    assert!(missing(tool.overhang) > 1.0, "the short tool collides");
    let overhang = around.stick_out(tool, pose, f64::INFINITY).expect("a longer one does");
    assert!(missing(overhang) <= 1e-3, "{overhang}");
    assert!(missing(overhang - 1.0) > 0.0, "1 mm less does not do");
    assert_eq!(around.stick_out(tool, pose, overhang), Some(overhang));
    assert_eq!(around.stick_out(tool, pose, overhang - 1.0), None, "no more than asked for");
}

#[test]
fn a_tapered_cutter_is_refused_by_planners_with_a_cure() {
    let part = pump();
    let text = "[[tool]]\nnumber = 7\ndiameter = 4\ncorner_radius = 2\ntaper = 5\noverhang = 40\n";
    let setup = read_setup_bytes("s.toml", text.as_bytes()).expect("reads");
    let workpiece = setup.allowances.workpiece_of(part);
    let plunge = vanecut::job::resolve(&setup, &workpiece).expect_err("no other tool");
    let flank = vanecut::flank::choice::choose_tool(&workpiece, &setup, &[]).expect_err("no other tool");
    for fault in [plunge, flank] {
        let text = fault.to_string();
        assert!(text.contains("tool 7 widens by 5.0°") && text.contains("cylindrical"), "{text}");
    }
    // Beside another it is left out of the choice.
    let more = format!("{text}[[tool]]\nnumber = 8\ndiameter = 6\noverhang = 60\n");
    let setup = read_setup_bytes("s.toml", more.as_bytes()).expect("reads");
    let resolved = vanecut::job::resolve(&setup, &workpiece).expect("the other one");
    assert!(resolved.setup.plunge.sections.iter().all(|section| section.tool == 8));
}

/// The cone of a tapered cutter is judged as a holder of that shape that needs no clearance; points of the
/// wheel confirm it.
#[test]
fn the_edges_of_a_tapered_cutter_are_judged_as_a_cone_along_every_move() {
    use super::sampled_tool::{WheelPoints, collisions};
    use vanecut::verify::{FaultKind, verify};
    let text = "[[tool]]\nnumber = 1\ndiameter = 16\ncorner_radius = 2\noverhang = 60\nflute_length = 40\n";
    let mut setup: Setup = read_setup_bytes("s.toml", text.as_bytes()).expect("reads");
    setup.plunge.step = Some(12.0);
    let policy = vanecut::setup::AxisPolicy::Conventional;
    let request =
        vanecut::job::PlanRequest { part: pump().into(), setup, policy, compare: false, field_cells: 32 };
    let outcome = vanecut::job::run(&request, &Default::default()).expect("a plan");
    let mut program = vanecut::toolpath::ClProgram::of_plan("pump6", &outcome.after.plan);
    program.moves.truncate(60);
    let lines = |setup: &Setup, kinds: &[FaultKind]| -> std::collections::BTreeSet<usize> {
        let verdict = verify(&outcome.workpiece, setup, &program, &Default::default()).expect("a verdict");
        let near = |fault: &&vanecut::verify::Fault| {
            kinds.contains(&fault.kind) && fault.to_string().contains("comes within")
        };
        verdict.faults.iter().filter(near).map(|fault| fault.line).collect()
    };
    let cut = [FaultKind::HubAllowance, FaultKind::BladeAllowance];
    assert!(lines(&outcome.setup, &cut).is_empty(), "the cylinder is clear");
    let taper = 5f64.to_radians();
    let mut tapered = outcome.setup.clone();
    tapered.tools[0].assembly.taper_rad = Some(taper);
    // The same cone as a holder, by its closed form: tangent to the corner of 2 mm.
    let (from, lower) = (2.0 * (1.0 - taper.sin()), 6.0 + 2.0 * taper.cos());
    let mut holder = outcome.setup.clone();
    holder.clearances = vanecut::setup::ClearanceSetup { shank: 0.0, holder: 0.0 };
    let length = 40.0 - from;
    holder.tools[0].overhang = from;
    holder.tools[0].assembly.flute_length = None;
    holder.tools[0].assembly.holder = vec![[2.0 * lower, 2.0 * (lower + length * taper.tan()), length]];
    let found = lines(&tapered, &cut);
    assert_eq!(found, lines(&holder, &[FaultKind::HolderCollision]));
    assert!(!found.is_empty() && found.len() < program.moves.len(), "{} moves", found.len());
    let points = WheelPoints::from_workpiece(&outcome.workpiece);
    assert!(!collisions(&outcome.workpiece, &points, &holder, &program).is_empty(), "by points");
    let remark = vanecut::verify::unjudged_tools(&program, &tapered).expect("a remark");
    assert!(remark.contains("as cones against the part"), "{remark}");
}

#[test]
fn a_tool_that_is_too_short_is_answered_by_a_length() {
    let request = |tool: &str| {
        let text = format!("[[tool]]\nnumber = 1\ndiameter = 8\noverhang = 9\n{tool}");
        let setup = read_setup_bytes("s.toml", text.as_bytes()).expect("reads");
        let policy = vanecut::setup::AxisPolicy::Conventional;
        vanecut::job::PlanRequest { part: pump().into(), setup, policy, compare: false, field_cells: 32 }
    };
    for tool in ["", "flute_length = 5\nholder = [[20, 30, 40]]\n"] {
        let mut request = request(tool);
        let error = vanecut::job::run(&request, &Default::default()).expect_err("too short").to_string();
        let length = error.split("give an overhang of ").nth(1).unwrap_or_else(|| panic!("{error}"));
        let length: f64 = length.split(' ').next().unwrap().parse().expect("a number");
        assert!((20.0..100.0).contains(&length), "{error}");
        request.setup.tools[0].overhang = length;
        let outcome = vanecut::job::run(&request, &Default::default()).expect("that length does");
        let plan = &outcome.after.plan;
        let short =
            |dropped: &&vanecut::plunge::Dropped| dropped.why == vanecut::plunge::DropReason::Overhang;
        let left = plan.dropped.iter().filter(short).count();
        assert!(left * 10 < plan.positions.len(), "{left} are too short, {} are cut", plan.positions.len());
    }
}

#[test]
fn a_holder_in_the_way_of_passes_is_answered_by_a_length() {
    use vanecut::flank::{UncutLength, UncutReason, choice::overhang_note, region::Region};
    let part = pump();
    let text = "[[tool]]\ndiameter = 6\ncorner_radius = 3\noverhang = 18\nholder = [[30, 40, 40]]\n";
    let mut tool = read_setup_bytes("s.toml", text.as_bytes()).expect("reads").tools[0].clone();
    let found = |why, overhang| [UncutLength { layer: 0, region: Region::INLET, length: 9.0, why, overhang }];
    let left = |why| found(why, None);
    let by_holder = UncutReason::holder("the holder meets the part");
    let note = overhang_note(&tool, &left(by_holder), &part).expect("too short");
    assert!(note.contains("give an overhang of 40 mm or more, instead of 18"), "{note}");
    let note = overhang_note(&tool, &found(by_holder, Some(33.0)), &part).expect("known");
    assert!(note.contains("an overhang of 33 mm would do, instead of 18"), "{note}");
    let several = [found(by_holder, Some(51.0)), left(by_holder)].concat();
    let note = overhang_note(&tool, &several, &part).expect("known in part");
    assert!(note.contains("give an overhang of 51 mm or more, instead of 18"), "{note}");
    assert_eq!(overhang_note(&tool, &left(UncutReason::new("a blade is too near")), &part), None);
    tool.overhang = 40.0;
    assert_eq!(overhang_note(&tool, &left(by_holder), &part), None);
    let by_shank = overhang_note(&tool, &left(UncutReason::shank("the shank meets the part")), &part);
    assert!(by_shank.expect("a thinner one").contains("a thinner neck"));
}

/// As allowances do. A setup that was written keeps its clearances on every wheel.
#[test]
fn the_default_clearance_scales_with_the_wheel() {
    use vanecut::io::setup_file::read_setup_with_defaults;
    use vanecut::setup::ClearanceSetup;
    let hub = "[[5, 10], [6, 4], [9, 1], [16, 0]]";
    let small = Setup::for_part(&wheel_with_blades(hub, "[[9, 10], [10, 6], [12, 4], [16, 3]]", 0.5));
    let usual = Setup::for_part(&pump());
    assert_eq!(usual.clearances, ClearanceSetup::default());
    for clearance in [small.clearances.shank, small.clearances.holder] {
        assert!((0.1..0.4).contains(&clearance), "{clearance}");
        assert_eq!(clearance, 2.0 * small.allowances.hub_allowance);
    }
    let read = read_setup_with_defaults("s.toml", write_setup(&usual).as_bytes(), &small).expect("reads");
    assert_eq!(read.clearances, usual.clearances);
}

/// An edge of the blank beside the middle of a long holder: by points of the holder.
#[test]
fn a_holder_is_in_the_way_of_an_edge_of_the_blank_anywhere_along_it() {
    use vanecut::geometry::Meridional;
    let part = pump();
    let workpiece = Setup::for_part(&part).allowances.workpiece_of(part);
    let text = "[clearance]\nholder = 2\n[[tool]]\ndiameter = 6\noverhang = 30\nholder = [[14, 40, 90]]\n";
    let setup = read_setup_bytes("s.toml", text.as_bytes()).expect("reads");
    let (tool, blank) = (&setup.tools[0], &workpiece.blank);
    let around = AssemblySurroundings::new(&workpiece.finished, &setup).with_blank(blank);
    let segments = tool.assembly.segments(tool.overhang);
    let edges = blank.end_circles();
    let mut dice = super::sampled_tool::Dice::new(4);
    let mut beside_middle = 0;
    let enough = 20;
    for k in 0..600 {
        // A point of an edge that some height of the holder comes near to, from the side.
        let at = edges[k % edges.len()].at_angle(dice.between(0.0, std::f64::consts::TAU));
        let [x, y, z] = [(); 3].map(|()| dice.between(-1.0, 1.0));
        let Some(axis) = Vector::new(x, y, z).try_normalize(0.1) else { continue };
        let Some(aside) = axis.cross(&Vector::new(y, z, x)).try_normalize(0.1) else { continue };
        let share = dice.between(0.0, 1.0);
        let radius = 7.0 + 13.0 * share;
        let tip = at + aside * (radius + dice.between(0.2, 3.0)) - axis * (tool.overhang + 90.0 * share);
        let is_found = around.first_obstacle(tool, &segments, (tip, axis), 1e-3).is_some();
        // The points say what is to be found, and that enough of it is beside the middle.
        if is_found && beside_middle > enough {
            continue;
        }
        let frustum = segments[0].placed(&tip, &axis);
        let (e1, e2) = (aside, axis.cross(&aside));
        let point = |i: u32, j: u32| {
            let (share, (sin, cos)) =
                (f64::from(i) / 180.0, (f64::from(j) / 120.0 * std::f64::consts::TAU).sin_cos());
            frustum.base + axis * (90.0 * share) + (e1 * cos + e2 * sin) * (7.0 + 13.0 * share)
        };
        let sampled = |from: u32, to: u32| {
            let points = (from..=to).flat_map(|i| (0..120).map(move |j| point(i, j)));
            points.map(|p| blank.nearest_top(Meridional::from_point(&p), &mut None).0).fold(9.0, f64::min)
        };
        let nearest = sampled(0, 180);
        if nearest < setup.clearances.holder - 0.02 {
            assert!(is_found, "{k}: {nearest} mm beside {tip:.2?} {axis:.3?}");
            beside_middle += usize::from(sampled(0, 10).min(sampled(170, 180)) > 4.0);
        }
    }
    assert!(beside_middle > enough, "{beside_middle}");
}
