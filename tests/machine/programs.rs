//! Programs to post: made up, small, with everything that matters in them.

use std::path::Path;

use vanecut::geometry::{Point, Vector};
use vanecut::io::InputError;
use vanecut::io::machine_file::read_machine;
use vanecut::io::nc::{Dialect, NcProgram, NcReading, Post, ReadContext, read_nc, read_post, write_nc};
use vanecut::machine::{
    MachineProgram, MachineTool, MotionFault, MotionOptions, OutputKind, PlacedPart, machine_program,
};
use vanecut::monitor::Monitor;
use vanecut::toolpath::{ClProgram, ClTool, Motion, Move};

pub const MACHINES: [&str; 5] = ["ac-trunnion", "bc-trunnion", "b-head-c-table", "bc-head", "nutating-table"];
/// Every output that a control takes.
pub const OUTPUTS: [(&str, &[OutputKind]); 5] = [
    ("heidenhain", &[OutputKind::TcpAngles, OutputKind::TcpVectors, OutputKind::Plane]),
    ("siemens", &OutputKind::ALL),
    ("fanuc", &OutputKind::ALL),
    ("haas", &[OutputKind::TcpAngles, OutputKind::Joints]),
    ("linuxcnc", &[OutputKind::TcpAngles, OutputKind::Joints]),
];

pub fn machine(name: &str) -> MachineTool {
    read_machine(Path::new(name)).unwrap()
}

/// A direction by its tilt from −Z (the inlet of the made-up part is down) and its place around Z, degrees.
pub fn tilted(tilt: f64, around: f64) -> Vector {
    let (tilt, around) = (tilt.to_radians(), around.to_radians());
    Vector::new(tilt.sin() * around.cos(), tilt.sin() * around.sin(), -tilt.cos())
}

fn tool(number: u32, diameter: f64) -> ClTool {
    ClTool {
        number,
        diameter,
        corner_radius: 0.8,
        insert_width: Some(0.3 * diameter),
        overhang: Some(4.0 * diameter),
        feed_mm_per_min: None,
        spindle_rpm: Some(1200.0),
        length_offset: None,
    }
}

fn step(motion: Motion, tip: Point, axis: Vector, tool: usize) -> Move {
    Move { motion, tip, axis, tool: Some(tool), line: 0 }
}

/// Plunges of two tools around a ring: steep and flat ones, one at the pole, neighbours across it.
pub fn plunges() -> ClProgram {
    let mut program = ClProgram {
        part: "ring".to_owned(),
        tools: vec![tool(4, 20.0), tool(7, 12.0)],
        ..ClProgram::default()
    };
    for k in 0..40 {
        let around = 9.0 * f64::from(k) + 0.37;
        let tilt = match k {
            11 => 0.0,
            12 => 0.004,
            k => f64::from(k) * 2.2,
        };
        let axis = tilted(tilt, 2.3 * around);
        let place = around.to_radians();
        let tip = Point::new(90.0 * place.cos(), 90.0 * place.sin(), -20.0 - f64::from(k) * 0.5);
        let out = tip + axis * 50.0;
        let tool = usize::from(k >= 25);
        let plunge = [(Motion::Rapid, out), (Motion::Feed(Some(240.0)), tip), (Motion::Rapid, out)];
        program.moves.extend(plunge.map(|(motion, tip)| step(motion, tip, axis, tool)));
    }
    number(program)
}

/// A cut that turns the tool all the way, past the pole and over it.
pub fn sweeps() -> ClProgram {
    let mut program =
        ClProgram { part: "sweep".to_owned(), tools: vec![tool(3, 10.0)], ..ClProgram::default() };
    for (sweep, offset) in [(0, 0.8), (1, 0.0), (2, 30.0)] {
        for k in 0..60 {
            // From one side of the pole to the other, past it by the offset.
            let (a, b) = (f64::from(k - 30) * 1.1_f64, offset);
            let tilt = a.hypot(b);
            let axis = tilted(tilt, b.atan2(a).to_degrees() + 40.0 * f64::from(sweep));
            let tip = Point::new(60.0 + f64::from(k) * 0.7, f64::from(sweep) * 25.0, -15.0);
            let motion = if k == 0 { Motion::Rapid } else { Motion::Feed(Some(800.0)) };
            program.moves.push(step(motion, tip, axis, 0));
        }
        let (last, axis) = program.moves.last().map(|m| (m.tip, m.axis)).unwrap();
        program.moves.push(step(Motion::Rapid, last + axis * 40.0, axis, 0));
    }
    number(program)
}

fn number(mut program: ClProgram) -> ClProgram {
    for (line, step) in (1..).zip(&mut program.moves) {
        step.line = line;
    }
    program
}

pub fn placed(machine: &MachineTool) -> PlacedPart {
    PlacedPart::new(&machine.part, false)
}

pub fn moved(
    machine: &MachineTool,
    program: &ClProgram,
    post: &Post,
    output: OutputKind,
) -> Result<MachineProgram, MotionFault> {
    let options = MotionOptions::new(output, post.format.angle_decimals);
    machine_program(machine, &placed(machine), program, &options, &Monitor::default())
}

pub fn posted(machine: &MachineTool, program: &ClProgram, control: &str, output: OutputKind) -> NcProgram {
    let post = read_post(control).unwrap();
    let motion = moved(machine, program, &post, output).unwrap();
    write_nc(program, machine, &motion, &post, output, &[]).unwrap()
}

pub fn read_back(machine: &MachineTool, control: &str, text: &str) -> Result<NcReading, InputError> {
    let context = ReadContext { machine, placed: placed(machine), tools: &[] };
    let dialect = Dialect::ALL.into_iter().find(|dialect| dialect.name() == control).unwrap();
    read_nc("p.nc", text.as_bytes(), dialect, &context)
}

/// Pairs each cut of `program` with the read move that ends it, and returns the largest distances of tip (mm)
/// and axis (degrees). Moves in between have to lie on the way.
pub fn largest_difference(program: &ClProgram, reading: &NcReading) -> Result<(f64, f64), String> {
    let mut read = reading.program.moves.iter();
    let (mut tip, mut axis) = (0.0, 0.0);
    for cut in program.moves.iter().filter(|m| matches!(m.motion, Motion::Feed(_))) {
        let near = |m: &&Move| {
            matches!(m.motion, Motion::Feed(_))
                && (m.tip - cut.tip).norm() < 0.01
                && m.axis.cross(&cut.axis).norm() < 1e-4
        };
        let found = read.find(near).ok_or(format!("the cut of line {} is not there", cut.line))?;
        if found.motion == Motion::Feed(None) {
            return Err(format!("the cut of line {} has no feed rate", found.line));
        }
        tip = f64::max(tip, (found.tip - cut.tip).norm());
        axis = f64::max(axis, found.axis.cross(&cut.axis).norm().asin().to_degrees());
    }
    Ok((tip, axis))
}
