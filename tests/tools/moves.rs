//! Shank and holder over the moves of a program: `verify` skips most places, a dense scan none.

use std::collections::BTreeSet;
use std::fmt::Write;

use vanecut::cutting::assembly::AssemblySurroundings;
use vanecut::cutting::assembly_move::AssemblyMove;
use vanecut::geometry::{Point, Vector};
use vanecut::io::apt::read_apt_bytes;
use vanecut::io::read_setup_bytes;
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::Setup;
use vanecut::toolpath::ClProgram;
use vanecut::verify::{FaultKind, FlankVerifier, verify};

use crate::assembly::pump;

/// Way of the fastest point of the tool between two places that the scan looks at, mm.
const SPACING: f64 = 0.5;

/// Short cuts along the hub with the axis turning, and long rapids across the wheel between them.
fn program(part: &Impeller, overhang: f64) -> ClProgram {
    let mut text = format!("PARTNO PUMP6\nUNITS/MM\nMULTAX/ON\nLOADTL/1\nCUTTER/6,3,0,3,0,0,{overhang}\n");
    for row in 0..3 {
        text += "RAPID\n";
        for k in 0..24 {
            let s = 0.9 - 0.02 * f64::from(k);
            let (at, angle) = (part.hub.at(s), 0.3 * f64::from(row) + 0.01 * f64::from(k));
            let normal = at.normal.direction_at_angle(angle);
            let axis = (normal + Vector::new(0.02 * f64::from(k), 0.1 * f64::from(row), -0.2)).normalize();
            let tip = at.point.at_angle(angle) + normal * 1.5;
            let (p, a) = (tip, axis);
            // Every fourth place is reached and left along the axis.
            let ups: &[f64] = if k % 4 == 3 { &[18.0, 0.0, 18.0] } else { &[0.0] };
            for up in ups {
                let p = p + a * *up;
                writeln!(text, "GOTO/{:.6},{:.6},{:.6},{:.9},{:.9},{:.9}", p.x, p.y, p.z, a.x, a.y, a.z)
                    .unwrap();
            }
            if k == 0 {
                text += "FEDRAT/300,MMPM\n";
            }
        }
    }
    read_apt_bytes("p.apt", text.as_bytes()).expect("reads")
}

struct Scan {
    least: [f64; 2],
    /// Lines on which the holder misses clearance by more, or by less, than a little either way.
    surely: BTreeSet<usize>,
    perhaps: BTreeSet<usize>,
}

/// Distances of shank and holder at many places of every move.
fn scan(part: &Impeller, setup: &Setup, program: &ClProgram) -> Scan {
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let around = AssemblySurroundings::new(&workpiece.finished, setup);
    let tool = &setup.tools[0];
    let segments = tool.assembly.segments(tool.overhang);
    let mut scan = Scan { least: [f64::INFINITY; 2], surely: BTreeSet::new(), perhaps: BTreeSet::new() };
    let mut from: Option<(Point, Vector)> = None;
    for step in &program.moves {
        let to = (step.tip, step.axis);
        let moved = AssemblyMove::new(&segments, from.unwrap_or(to), to);
        let places = (moved.way / SPACING).ceil().max(1.0);
        for place in 0..=places as usize {
            let here = around.at(tool, &segments, moved.pose(place as f64 / places), f64::INFINITY);
            scan.least[0] = scan.least[0].min(here.shank.distance);
            scan.least[1] = scan.least[1].min(here.holder.distance);
            if here.holder.missing > 0.05 {
                scan.surely.insert(step.line);
            }
            if here.holder.missing > -0.05 {
                scan.perhaps.insert(step.line);
            }
        }
        from = Some(to);
    }
    scan
}

#[test]
fn distances_and_collisions_over_moves_are_those_of_a_dense_scan() {
    let part = pump();
    let mut collided = 0;
    for overhang in [60.0, 26.0] {
        let text = format!(
            "[[tool]]\nnumber = 1\ndiameter = 6\ncorner_radius = 3\noverhang = {overhang}\n\
             flute_length = 12\nshank = [[8, 48]]\nholder = [[24, 40, 30], [50, 50, 40]]\n"
        );
        let setup = read_setup_bytes("s.toml", text.as_bytes()).expect("reads");
        let program = program(&part, overhang);
        let scan = scan(&part, &setup, &program);
        let workpiece = setup.allowances.workpiece_of(part.clone());
        let monitor = Monitor::default();
        let faults = FlankVerifier::new(&workpiece, &setup).faults(&program, &monitor).expect("judged");
        let verdict = verify(&workpiece, &setup, &program, &monitor).expect("a verdict");
        let found = [verdict.assembly.shank, verdict.assembly.holder];
        for (found, scanned) in found.iter().zip(scan.least) {
            // Between two places half their spacing may be missed; those of `verify` are 0.25 mm apart.
            let within = -0.5 * SPACING..0.125;
            assert!(within.contains(&(found - scanned)), "{overhang}: {found}, not {scanned}");
        }
        let is_holder = |kind: FaultKind| kind == FaultKind::HolderCollision;
        let lines: BTreeSet<usize> =
            faults.iter().filter(|fault| is_holder(fault.kind)).map(|fault| fault.line).collect();
        assert!(scan.surely.is_subset(&lines), "missed: {:?}", scan.surely.difference(&lines));
        assert!(lines.is_subset(&scan.perhaps), "false: {:?}", lines.difference(&scan.perhaps));
        collided += lines.len();
    }
    assert!(collided > 10, "{collided} collisions were compared");
}
