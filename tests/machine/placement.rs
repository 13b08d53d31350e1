//! How the part lies on the table: turned about Z, its origin elsewhere, its inlet up or down.

use vanecut::geometry::{Point, Vector};
use vanecut::io::nc::{read_post, write_nc};
use vanecut::job::post::{PostRequest, post_program};
use vanecut::machine::{MachineTool, OutputKind, PlacedPart, gauge_length};
use vanecut::monitor::Monitor;

use super::programs::{MACHINES, OUTPUTS, largest_difference, machine, moved, plunges, posted, read_back};

/// A part turned about the axis of its table stands, after C has turned as much, as it did before: all other
/// axes are the same.
#[test]
fn a_turned_part_turns_the_table_alone() {
    let post = read_post("fanuc").unwrap();
    let program = plunges();
    for name in ["ac-trunnion", "bc-trunnion", "b-head-c-table", "nutating-table"] {
        let joints = |clock: f64| {
            let mut machine = machine(name);
            machine.part.clock_rad = clock;
            // Whole turns of C do not matter here.
            machine.rotary[0].limits = None;
            let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
            let at = |k: usize| {
                let step = motion.steps.iter().find(|step| step.source == 3 * k + 1).unwrap();
                let length = gauge_length(&machine, &program.tools[step.tool]);
                let [c, tilt] = step.pose.angles;
                (machine.joints(&step.pose.tip, &step.pose.angles, length), c, tilt)
            };
            // The first plunges; near the pole, and with both solutions to choose from, others may differ.
            (1..6).map(at).collect::<Vec<_>>()
        };
        let clock = 37f64.to_radians();
        for ((xyz, c, tilt), (turned_xyz, turned_c, turned_tilt)) in
            joints(0.0).into_iter().zip(joints(clock))
        {
            // The other solution tilts the other way: then the table has turned by half a turn more.
            let same = (tilt - turned_tilt).abs() < 1e-5;
            let turn = vanecut::geometry::wrap_angle(turned_c - c - clock);
            if !same {
                continue;
            }
            assert!(turn.abs() < 1e-5, "{name}: C turns by {} instead of {clock}", turned_c - c);
            let off = (Vector::from(xyz) - Vector::from(turned_xyz)).norm();
            assert!(off < 1e-2, "{name}: {xyz:?} {turned_xyz:?}");
        }
    }
}

#[test]
fn a_part_that_lies_elsewhere_comes_back() {
    let program = plunges();
    for name in MACHINES {
        let mut machine = machine(name);
        machine.part.clock_rad = -73f64.to_radians();
        machine.part.origin = Point::new(40.0, -25.0, 130.0);
        for (control, kinds) in OUTPUTS {
            for &output in kinds {
                let case = format!("{name} {control} {}", output.name());
                let nc = posted(&machine, &program, control, output);
                let reading = read_back(&machine, control, &nc.text).expect(&case);
                let (tip, axis) = largest_difference(&program, &reading).expect(&case);
                assert!(tip <= 1e-3 && axis <= 1e-4, "{case}: {tip} mm, {axis}°");
                // Read for the same machine with the part turned otherwise, the cuts are elsewhere.
                let mut other = machine.clone();
                other.part.clock_rad = 0.0;
                let reading = read_back(&other, control, &nc.text).expect(&case);
                assert!(largest_difference(&program, &reading).is_err(), "{case}");
            }
        }
    }
}

/// Who sets up the part reads in the head of the program how it lies.
#[test]
fn the_head_of_a_program_says_how_the_part_is_turned() {
    let head = |inlet_up: bool, clock_deg: f64| {
        let mut machine = machine("ac-trunnion");
        machine.part.clock_rad = clock_deg.to_radians();
        let request = PostRequest {
            post: read_post("fanuc").unwrap(),
            output: OutputKind::TcpAngles,
            inlet_up,
            blank: None,
            calls: None,
            machine,
        };
        let text = post_program(&plunges(), &request, &Monitor::default()).unwrap().written.text;
        text.lines().take(8).filter(|line| line.to_lowercase().contains("part turned")).count()
    };
    let is_up = machine("ac-trunnion").part.inlet_up;
    let as_drawn = PlacedPart::new(&machine("ac-trunnion").part, is_up).comments();
    assert!(as_drawn.is_empty(), "it lies as it is drawn: {as_drawn:?}");
    // The made-up part lies with its inlet down.
    assert_eq!((head(!is_up, 0.0), head(!is_up, 30.0)), (1, 2));
    let comments = PlacedPart::new(&machine("ac-trunnion").part, !is_up).comments();
    assert_eq!(comments, ["part turned over by half a turn about its X"]);
}

/// The side that the machine wants up is up, whichever way the part is drawn.
#[test]
fn the_inlet_is_where_the_machine_wants_it() {
    for inlet_up in [true, false] {
        let mut part = machine("ac-trunnion").part;
        part.inlet_up = inlet_up;
        part.clock_rad = 0.4;
        for drawn_up in [true, false] {
            let placed = PlacedPart::new(&part, drawn_up);
            let out_of_inlet = Vector::new(0.0, 0.0, if drawn_up { 1.0 } else { -1.0 });
            let out = placed.vector_in_program(&out_of_inlet);
            assert_eq!(out.z > 0.0, inlet_up);
            let (p, v) = (Point::new(3.0, -8.0, 21.0), Vector::new(0.6, 0.0, 0.8));
            assert!((placed.point_in_part(&placed.point_in_program(&p)) - p).norm() < 1e-12);
            assert!((placed.vector_in_part(&placed.vector_in_program(&v)) - v).norm() < 1e-12);
            // It is turned, not mirrored.
            let [x, y, z] = [Vector::x(), Vector::y(), Vector::z()].map(|v| placed.vector_in_program(&v));
            assert!((x.cross(&y) - z).norm() < 1e-12);
        }
    }
}

/// Presets of Heidenhain have numbers; other controls take the name of the work offset as it is.
#[test]
fn the_work_offset_of_the_machine_file_is_chosen() {
    let program = plunges();
    let mut machine = machine("ac-trunnion");
    let posted = |machine: &MachineTool, control: &str| {
        let post = read_post(control).unwrap();
        let motion = moved(machine, &program, &post, OutputKind::TcpAngles).unwrap();
        write_nc(&program, machine, &motion, &post, OutputKind::TcpAngles, &[]).map(|written| written.text)
    };
    for (offset, preset) in [("G54", "+1"), ("g59", "+6"), ("7", "+7")] {
        machine.part.offset_name = offset.to_owned();
        let text = posted(&machine, "heidenhain").unwrap();
        assert!(text.contains(&format!("CYCL DEF 247 Q339={preset}\n")), "{offset}: {text}");
        assert!(read_back(&machine, "heidenhain", &text).is_ok(), "{offset}");
    }
    machine.part.offset_name = "G505".to_owned();
    assert!(posted(&machine, "siemens").unwrap().contains("G505\n"));
    let error = posted(&machine, "heidenhain").unwrap_err();
    assert_eq!(
        error.message,
        "the control heidenhain selects presets by number, but the work offset is `G505`"
    );
}
