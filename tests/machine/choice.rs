//! The chosen rotary positions against all others, by trying them.

use vanecut::geometry::{Point, Vector, wrap_angle};
use vanecut::io::nc::read_post;
use vanecut::machine::{MachineTool, OutputKind, TurnLink};
use vanecut::toolpath::{ClProgram, Motion, Move};

use super::programs::{MACHINES, machine, moved, placed, plunges, tilted};

/// What unwinding an axis costs more than leaving the part, s.
const UNWINDING_S: f64 = 10.0;
/// Preference for less travel, s/rad.
const PER_RAD_S: f64 = 1e-3;

/// Plunges with these axes, all with one tool.
fn plunges_along(axes: &[Vector]) -> ClProgram {
    let mut program = plunges();
    let tool = program.moves[0].tool;
    program.moves.clear();
    for (k, axis) in axes.iter().enumerate() {
        let tip = Point::new(20.0 + 5.0 * k as f64, 0.0, -20.0);
        for (motion, tip) in [
            (Motion::Rapid, tip + axis * 60.0),
            (Motion::Feed(Some(240.0)), tip),
            (Motion::Rapid, tip + axis * 60.0),
        ] {
            program.moves.push(Move { motion, tip, axis: *axis, tool, line: program.moves.len() + 1 });
        }
    }
    program
}

/// Cost of turning from one pair of positions to another: the slower axis, some for travel, and unwinding.
fn turning(machine: &MachineTool, from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let turn: [f64; 2] = std::array::from_fn(|i| match machine.rotary[i].limits {
        None => wrap_angle(to[i] - from[i]).abs(),
        Some(_) => (to[i] - from[i]).abs(),
    });
    let time = (0..2).map(|i| turn[i] / machine.rotary[i].rapid_rad_per_s).fold(0.0, f64::max);
    let unwinds = turn.iter().any(|turn| *turn > std::f64::consts::PI * (1.0 + 1e-9));
    time + PER_RAD_S * (turn[0] + turn[1]) + if unwinds { UNWINDING_S } else { 0.0 }
}

/// Every link leaves the part, so that only the turns differ from choice to choice.
#[test]
fn no_other_positions_take_less_time() {
    let post = read_post("fanuc").unwrap();
    for name in MACHINES {
        let mut machine = machine(name);
        machine.links.turn = TurnLink::Clear;
        let mut choices = 0;
        for round in 0..12 {
            let axes: Vec<Vector> = (0..6)
                .map(|k| {
                    let at = f64::from(7 * round + k);
                    tilted(12.0 + (31.7 * at) % 70.0, (137.5 * at) % 360.0)
                })
                .collect();
            let program = plunges_along(&axes);
            let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
            let chosen: Vec<[f64; 2]> = (0..axes.len())
                .map(|k| motion.steps.iter().find(|step| step.source == 3 * k + 1).unwrap().pose.angles)
                .collect();
            let of_chosen = chosen.windows(2).map(|pair| turning(&machine, &pair[0], &pair[1])).sum::<f64>()
                + PER_RAD_S * chosen[0].iter().map(|angle| angle.abs()).sum::<f64>();

            let place = placed(&machine);
            let candidates: Vec<Vec<[f64; 2]>> = axes
                .iter()
                .map(|axis| {
                    let (solutions, count) = machine.solve(&place.vector_in_program(axis));
                    let all = solutions.into_iter().take(count).flat_map(|solution| {
                        let first = machine.rotary[0].turns_within_limits(solution.first.unwrap());
                        let second = machine.rotary[1].turns_within_limits(solution.second);
                        let second: Vec<f64> = second.collect();
                        first
                            .flat_map(move |a| second.clone().into_iter().map(move |b| [a, b]))
                            .collect::<Vec<_>>()
                    });
                    all.collect()
                })
                .collect();
            let mut least = f64::INFINITY;
            let mut tried = vec![(0.0, Vec::<[f64; 2]>::new())];
            while let Some((cost, sequence)) = tried.pop() {
                if sequence.len() == candidates.len() {
                    least = f64::min(least, cost);
                    continue;
                }
                for next in &candidates[sequence.len()] {
                    let more = match sequence.last() {
                        None => PER_RAD_S * (next[0].abs() + next[1].abs()),
                        Some(last) => turning(&machine, last, next),
                    };
                    let mut sequence = sequence.clone();
                    sequence.push(*next);
                    tried.push((cost + more, sequence));
                }
            }
            choices += candidates.iter().map(|of_axis| of_axis.len() - 1).sum::<usize>();
            // Positions are rounded to 1e-4°.
            assert!((of_chosen - least).abs() < 1e-4, "{name} {round}: {of_chosen} s, {least} s can be had");
        }
        assert!(choices > 12, "{name}: {choices} to choose from");
    }
}
