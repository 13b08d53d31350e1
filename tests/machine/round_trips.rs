//! What is posted is read back: every machine, control and output.

use vanecut::geometry::Point;
use vanecut::io::nc::read_post;
use vanecut::machine::{
    MachineProgram, MachineTool, MotionFault, OutputKind, StepMotion, TurnLink, gauge_length,
};
use vanecut::toolpath::{ClProgram, Motion, Move};

use super::programs::{
    MACHINES, OUTPUTS, largest_difference, machine, moved, placed, plunges, posted, read_back, sweeps, tilted,
};

fn check(program: &ClProgram, outputs: &[OutputKind]) {
    for name in MACHINES {
        let machine = machine(name);
        for (control, kinds) in OUTPUTS {
            for output in kinds.iter().filter(|kind| outputs.contains(kind)) {
                let case = format!("{name} {control} {}", output.name());
                let nc = posted(&machine, program, control, *output);
                let reading = read_back(&machine, control, &nc.text).expect(&case);
                let (tip, axis) = largest_difference(program, &reading).expect(&case);
                assert!(tip <= 1e-3 && axis <= 1e-4, "{case}: {tip} mm, {axis}°");
                assert!(reading.overruns.is_empty(), "{case}: {:?}", reading.overruns);
                let tools =
                    |p: &ClProgram| p.tools.iter().map(|t| (t.number, t.diameter)).collect::<Vec<_>>();
                assert_eq!(tools(program), tools(&reading.program), "{case}");
            }
        }
    }
}

#[test]
fn plunges_come_back() {
    check(&plunges(), &OutputKind::ALL);
}

#[test]
fn an_unfinished_program_is_known_by_its_name() {
    let name = "a wheel with a name that is too long for a head UNFINISHED";
    let program = ClProgram { part: name.to_owned(), ..plunges() };
    let machine = machine("ac-trunnion");
    for (control, kinds) in OUTPUTS {
        let unfinished = read_back(&machine, control, &posted(&machine, &program, control, kinds[0]).text);
        let unfinished = unfinished.expect(control).program;
        assert!(unfinished.is_unfinished() && unfinished.warnings.len() == 1, "{control}");
        let whole = read_back(&machine, control, &posted(&machine, &plunges(), control, kinds[0]).text);
        assert!(!whole.expect(control).program.is_unfinished(), "{control}");
    }
}

#[test]
fn turning_cuts_come_back() {
    check(&sweeps(), &[OutputKind::TcpAngles, OutputKind::TcpVectors, OutputKind::Joints]);
}

/// Feed rates and the kind of each move survive, with inverse time too.
#[test]
fn cuts_stay_cuts_and_rapids_rapids() {
    for program in [plunges(), sweeps()] {
        let length = |moves: &ClProgram| {
            let pairs = moves.moves.windows(2).filter(|p| p[0].tool == p[1].tool);
            let cuts = pairs.filter(|p| matches!(p[1].motion, Motion::Feed(_)));
            cuts.map(|p| (p[1].tip - p[0].tip).norm()).sum::<f64>()
        };
        for name in MACHINES {
            let machine = machine(name);
            for (control, output) in [("linuxcnc", OutputKind::Joints), ("heidenhain", OutputKind::TcpAngles)]
            {
                let nc = posted(&machine, &program, control, output);
                let reading = read_back(&machine, control, &nc.text).unwrap();
                let (cut, meant) = (length(&reading.program), length(&program));
                assert!((cut / meant - 1.0).abs() < 2e-3, "{name} {control}: {cut} of {meant} mm");
                for step in &reading.program.moves {
                    if let Motion::Feed(rate) = step.motion {
                        let rate = rate.expect("a feed rate");
                        assert!(rate > 0.0 && rate <= 840.0, "{name} {control} line {}: {rate}", step.line);
                    }
                }
            }
        }
    }
}

/// Blocks of less than a micrometre in inverse time: no F is larger than what the reader and controls take.
#[test]
fn blocks_of_no_length_have_a_feed_word_that_can_be_read() {
    let mut program = sweeps();
    let (a, b) = (program.moves[20].clone(), program.moves[21].clone());
    let between = |t: f64| Move {
        tip: a.tip + (b.tip - a.tip) * t,
        axis: (a.axis + (b.axis - a.axis) * t).normalize(),
        ..a.clone()
    };
    program.moves.splice(21..21, [1e-7, 2e-7, 3e-7].map(between));
    for name in MACHINES {
        let machine = machine(name);
        let nc = posted(&machine, &program, "fanuc", OutputKind::Joints);
        let rates = nc.text.split_whitespace().filter_map(|word| word.strip_prefix('F')?.parse::<f64>().ok());
        let fastest = rates.fold(0.0, f64::max);
        assert!(fastest > 0.0 && fastest <= 60.0 / machine.block_time_s, "{name}: F{fastest}");
        read_back(&machine, "fanuc", &nc.text).expect(name);
    }
}

/// Checks that the tip stays on its lines under feed, in joint space, sampled finely.
fn check_tip_on_lines(name: &str, program: &ClProgram, machine: &MachineTool, motion: &MachineProgram) {
    let length = gauge_length(machine, &program.tools[0]);
    for pair in motion.steps.windows(2) {
        let (a, b) = (&pair[0].pose, &pair[1].pose);
        if !matches!(pair[1].motion, StepMotion::Feed(_)) {
            continue;
        }
        let [from, to] = [a, b].map(|pose| machine.joints(&pose.tip, &pose.angles, length));
        for k in 1..20 {
            let share = f64::from(k) / 20.0;
            let at = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * share);
            let angles = std::array::from_fn(|i| a.angles[i] + (b.angles[i] - a.angles[i]) * share);
            let tip = machine.tip(&at, &angles, length);
            let line = b.tip - a.tip;
            let along = ((tip - a.tip).dot(&line) / line.norm_squared().max(1e-12)).clamp(0.0, 1.0);
            let off = (tip - (a.tip + line * along)).norm();
            assert!(off <= 0.01, "{name}: {off} mm");
        }
    }
    assert!(motion.tip_error <= 0.01 && motion.axis_error_rad.to_degrees() <= 0.02, "{name}");
}

#[test]
fn joint_moves_keep_the_tip_on_its_line() {
    let program = sweeps();
    for name in MACHINES {
        let machine = machine(name);
        let post = read_post("linuxcnc").unwrap();
        let motion = moved(&machine, &program, &post, OutputKind::Joints).unwrap();
        check_tip_on_lines(name, &program, &machine, &motion);
    }
}

/// A cut that passes the pole by less than a hundredth of a degree turns the first axis by half a turn. Where
/// its limits forbid that, the program changes to the other solution: within the tolerance of the axis, so
/// the tip has to be held meanwhile.
#[test]
fn the_tip_is_held_while_axes_change_over_beside_the_pole() {
    let mut program = sweeps();
    let step = program.moves[1].clone();
    program.moves = (0..41)
        .map(|k| {
            let (along, beside) = (0.003 * f64::from(k - 20), 0.006_f64);
            let axis = tilted(along.hypot(beside), beside.atan2(along).to_degrees());
            let motion = if k == 0 { Motion::Rapid } else { step.motion };
            let tip = Point::new(30.0 + 0.3 * f64::from(k), 5.0, -15.0);
            Move { motion, tip, axis, line: usize::try_from(k).unwrap() + 1, ..step.clone() }
        })
        .collect();
    let post = read_post("linuxcnc").unwrap();
    for name in ["b-head-c-table", "bc-head", "ac-trunnion"] {
        let mut machine = machine(name);
        // The way through the pole's neighbourhood is closed somewhere on either solution.
        for closed in [-170.0, -100.0, -60.0, 10.0, 80.0, 130.0_f64] {
            let limits = (closed.to_radians(), closed.to_radians() + 3.6);
            machine.rotary[0].limits = Some(limits);
            let motion = moved(&machine, &program, &post, OutputKind::Joints);
            let motion = motion.unwrap_or_else(|fault| panic!("{name} from {closed}°: {fault}"));
            check_tip_on_lines(name, &program, &machine, &motion);
            let inside = |a: f64| a >= limits.0 - 1e-6 && a <= limits.1 + 1e-6;
            assert!(motion.steps.iter().all(|step| inside(step.pose.angles[0])), "{name} from {closed}°");
        }
    }
}

/// Links that leave the part stay outside the sphere of what is cut, whatever the axes do.
#[test]
fn clear_links_keep_clear() {
    let program = plunges();
    for name in MACHINES {
        let mut machine = machine(name);
        machine.links.turn = TurnLink::Clear;
        let post = read_post("fanuc").unwrap();
        let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
        assert!(motion.clear_links >= 37, "{name}: {}", motion.clear_links);
        let place = placed(&machine);
        let tips: Vec<_> = program.moves.iter().map(|m| place.point_in_program(&m.tip)).collect();
        let (low, high) =
            tips.iter().fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p.z), high.max(p.z)));
        let centre = Point::new(0.0, 0.0, 0.5 * (low + high));
        let reach = tips.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        for pair in motion.steps.windows(2) {
            let (a, b) = (&pair[0].pose, &pair[1].pose);
            let turns = (0..2).any(|i| (a.angles[i] - b.angles[i]).abs() > 1e-3);
            if !turns || pair[1].motion == StepMotion::Approach {
                continue;
            }
            for k in 0..=10 {
                let share = f64::from(k) / 10.0;
                let angles = std::array::from_fn(|i| a.angles[i] + (b.angles[i] - a.angles[i]) * share);
                let (tip, axis) = (a.tip + (b.tip - a.tip) * share, machine.tool_axis(&angles));
                let tool = &program.tools[pair[1].tool];
                // The axis of the tool, up to the spindle, and its radius around it.
                let along = -(tip - centre).dot(&axis);
                let nearest = tip + axis * along.clamp(0.0, 1000.0);
                let clear = (nearest - centre).norm() - 0.5 * tool.diameter - reach;
                assert!(clear > 10.0, "{name}: {clear} mm");
            }
        }
    }
}

/// A table with stops turns back in a link, and only there.
#[test]
fn limited_axes_unwind_in_links() {
    let mut machine = machine("b-head-c-table");
    let program = plunges();
    let post = read_post("siemens").unwrap();
    for limit in [360.0_f64, 200.0] {
        machine.rotary[0].limits = Some((-limit.to_radians(), limit.to_radians()));
        let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
        for step in &motion.steps {
            assert!(step.pose.angles[0].to_degrees().abs() <= limit + 1e-6);
        }
        if limit < 300.0 {
            assert!(motion.rewinds > 0, "the plunges go round more than once");
        }
    }
    let fault = |limit: f64| {
        let mut machine = super::programs::machine("b-head-c-table");
        machine.rotary[0].limits = Some((-limit.to_radians(), limit.to_radians()));
        moved(&machine, &sweeps(), &post, OutputKind::TcpAngles)
    };
    assert!(fault(360.0).is_ok());
    assert!(matches!(fault(20.0), Err(MotionFault::OutOfLimits { .. })));
}
