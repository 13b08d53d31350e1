//! Tools and the table that carries the part.

use vanecut::error::ErrorCode;
use vanecut::geometry::Point;
use vanecut::io::machine_file::read_machine_bytes;
use vanecut::io::nc::read_post;
use vanecut::machine::{MachineTable, MotionFault, OutputKind};
use vanecut::toolpath::{ClProgram, Motion, Move};

use super::programs::{MACHINES, machine, moved, plunges, tilted};

/// One plunge at radius 90, `height` above the part's origin, tilted by `tilt` outwards.
fn plunge(tilt: f64, height: f64) -> ClProgram {
    let mut program = plunges();
    let step = program.moves[0].clone();
    let (axis, tip) = (tilted(tilt, 0.0), Point::new(90.0, 0.0, -height));
    program.moves = [(Motion::Rapid, 40.0), (Motion::Feed(Some(240.0)), 0.0), (Motion::Rapid, 40.0)]
        .into_iter()
        .zip(1..)
        .map(|((motion, out), line)| Move { motion, tip: tip + axis * out, axis, line, ..step.clone() })
        .collect();
    program
}

/// A flat plunge outside of the table's edge does not meet it, nor one above it; the depth is that of the
/// lowest place.
#[test]
fn a_tool_below_the_upper_face_is_refused() {
    let post = read_post("fanuc").unwrap();
    for name in MACHINES {
        let mut machine = machine(name);
        let fault = |machine: &_, program: &ClProgram| {
            moved(machine, program, &post, OutputKind::TcpAngles).map(|_| ()).err()
        };
        // The part's origin is 60 mm above the machine's.
        machine.table = Some(MachineTable { radius: 300.0, top: 0.0 });
        assert_eq!(fault(&machine, &plunge(80.0, 10.0)), None, "{name}");
        // Level, with its axis 5 mm above the table: the cutter of 20 mm is 5 mm below its face, the holder
        // 15.
        let level = plunge(90.0 - 1e-6, -55.0);
        let Some(MotionFault::MeetsTable { tool, is_holder, depth, .. }) = fault(&machine, &level) else {
            panic!("{name}: {:?}", fault(&machine, &level));
        };
        assert!(tool == 4 && is_holder && (depth - 15.0).abs() < 0.01, "{name}: {depth}");
        let explained = fault(&machine, &level).unwrap().explained();
        assert_eq!(explained.code, ErrorCode::AssemblyCollides);
        assert!(explained.message.contains("the holder of tool 4 would go 15.0 mm below"), "{explained:?}");
        // 60 mm of the cutter are above a table whose edge is at 150; its holder begins outside of it.
        machine.table = Some(MachineTable { radius: 130.0, top: 0.0 });
        let Some(MotionFault::MeetsTable { is_holder, depth, .. }) = fault(&machine, &level) else {
            panic!("{name}: the cutter is above the table");
        };
        assert!(!is_holder && (depth - 5.0).abs() < 0.01, "{name}: {depth}");
        machine.table = Some(MachineTable { radius: 70.0, top: 0.0 });
        assert_eq!(fault(&machine, &level), None, "{name}");
        machine.table = None;
        assert_eq!(fault(&machine, &level), None, "{name}");
    }
}

/// A link is looked at between its ends: both are beside the table here.
#[test]
fn a_link_across_the_table_is_refused() {
    let post = read_post("fanuc").unwrap();
    let mut machine = machine("ac-trunnion");
    let mut program = plunge(60.0, 30.0);
    let step = program.moves[0].clone();
    // Level, across the way, 5 mm above the table.
    let aside = |x: f64, line| {
        let (axis, tip) = (tilted(90.0 - 1e-6, 90.0), Point::new(x, 0.0, 55.0));
        Move { motion: Motion::Rapid, tip, axis, line, ..step.clone() }
    };
    program.moves = vec![aside(450.0, 1), aside(-450.0, 2)];
    let fault = |machine: &_| moved(machine, &program, &post, OutputKind::TcpAngles).map(|_| ()).err();
    machine.table = Some(MachineTable { radius: 300.0, top: 0.0 });
    let Some(MotionFault::MeetsTable { line, .. }) = fault(&machine) else { panic!("{:?}", fault(&machine)) };
    assert_eq!(line, 2);
    machine.table = Some(MachineTable { radius: 300.0, top: -20.0 });
    assert_eq!(fault(&machine), None);
}

#[test]
fn the_table_is_read_from_the_machine_file() {
    let text = include_str!("../../assets/machines/ac-trunnion.toml");
    let read = |added: &str| read_machine_bytes("m.toml", format!("{text}\n{added}").as_bytes());
    assert_eq!(read("").unwrap().table, None);
    let given = read("[table]\nradius = 250\ntop = -5\n").unwrap().table;
    assert_eq!(given, Some(MachineTable { radius: 250.0, top: -5.0 }));
    assert_eq!(read("[table]\nradius = 250\n").unwrap().table.map(|table| table.top), Some(0.0));
    for (added, code) in [
        ("[table]\ntop = 3\n", ErrorCode::MissingKey),
        ("[table]\nradius = 250\nheight = 3\n", ErrorCode::UnknownKey),
        ("[table]\nradius = 0\n", ErrorCode::ValueRange),
    ] {
        assert_eq!(read(added).unwrap_err().code, code, "{added}");
    }
}
