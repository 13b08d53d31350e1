//! Times in joint space, against what one axis alone would take.

use vanecut::geometry::{Point, Vector};
use vanecut::io::nc::read_post;
use vanecut::machine::{OutputKind, block_times, section_times};
use vanecut::toolpath::{ClProgram, Motion, Move};

use super::programs::{machine, moved, plunges};

/// A straight cut of `length` mm along X at `rate`, between rapids that stop.
fn one_cut(length: f64, rate: f64) -> ClProgram {
    let mut program = plunges();
    program.moves.clear();
    program.tools.truncate(1);
    for (motion, x) in [(Motion::Rapid, 0.0), (Motion::Feed(Some(rate)), length), (Motion::Rapid, 0.0)] {
        let step =
            Move { motion, tip: Point::new(x, 0.0, -10.0), axis: -Vector::z(), tool: Some(0), line: 1 };
        program.moves.push(step);
    }
    program
}

/// Time of a cut from rest to rest by the textbook: both ramps of an S-curve and the way between them.
fn rest_to_rest(length: f64, speed: f64, acceleration: f64, jerk: f64) -> f64 {
    let ramp = speed / acceleration + acceleration / jerk;
    2.0 * ramp + (length - speed * ramp) / speed
}

#[test]
fn a_cut_from_rest_to_rest() {
    let machine = machine("ac-trunnion");
    let post = read_post("heidenhain").unwrap();
    let program = one_cut(200.0, 6000.0);
    let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
    let times = block_times(&machine, &program, &motion);
    let cut = motion.steps.iter().position(|step| step.source == 1).unwrap();
    let axis = &machine.linear[0];
    // It comes down before and turns round after: both ends are corners that nearly stop.
    let expected = rest_to_rest(200.0, 100.0, axis.acceleration, axis.jerk);
    let got = times[cut];
    assert!(got <= expected && got > 200.0 / 100.0 && expected - got < 0.1, "{got} s, {expected} s");
}

#[test]
fn slower_axes_take_longer_and_sections_add_up() {
    let program = plunges();
    let post = read_post("heidenhain").unwrap();
    let machine = machine("ac-trunnion");
    let total = |machine: &vanecut::machine::MachineTool| {
        let motion = moved(machine, &program, &post, OutputKind::TcpAngles).unwrap();
        let sections = section_times(machine, &program, &motion);
        let blocks: f64 = block_times(machine, &program, &motion).iter().sum();
        let sum: f64 = sections.iter().map(|s| s.feed_s + s.links_s).sum();
        assert!((sum - blocks).abs() < 1e-6 * blocks, "{sum} {blocks}");
        assert_eq!(sections.len(), 2, "one a tool");
        assert!(sections.iter().all(|s| s.tool_change_s == machine.tool_change_s && s.turns_s <= s.links_s));
        blocks
    };
    let usual = total(&machine);
    // 40 plunges of 50 mm at 240 mm/min.
    assert!(usual > 40.0 * 50.0 / 240.0 * 60.0, "{usual}");
    let mut slow = machine.clone();
    slow.rotary[0].rapid_rad_per_s /= 10.0;
    assert!(total(&slow) > usual + 1.0);
    let mut soft = machine.clone();
    soft.linear.iter_mut().for_each(|axis| axis.jerk /= 100.0);
    assert!(total(&soft) > usual + 1.0);
    let mut hard = machine;
    hard.linear.iter_mut().for_each(|axis| axis.jerk = f64::INFINITY);
    assert!(total(&hard) < usual);
}
