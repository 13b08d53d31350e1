//! The retract position: what a program does there and on the way to it is read as all other motion is.

use vanecut::io::nc::NcReading;
use vanecut::machine::{MachineTool, MoveAngles, OutputKind, gauge_length};

use super::figures::{MEANT, PLUNGED, kinds_of};
use super::links::found_by;
use super::programs::{MACHINES, OUTPUTS, machine, placed, plunges, posted, read_back};

/// Words with what they are changed to; each control has some of them.
const CHANGES: [(&str, &str); 38] = [
    // Units, absolute positions, feed per minute, work offset.
    ("G21 ", ""),
    (" G71", ""),
    ("BEGIN PGM RING MM", "BEGIN PGM RING"),
    ("G90 G94", "G90"),
    ("G54\n", "G55\n"),
    ("CYCL DEF 247 Q339=+1", "; "),
    ("CYCL DEF 247 Q339=+1", "CYCL DEF 247 Q339=+2"),
    // The way to the retract position.
    ("G91 G28 Z0.", "G28 Z0."),
    ("G91 G28 Z0.", "G91 Z0."),
    ("G91 G28 Z0.", "G91 G28"),
    ("G91 G28 Z0.", "G91 G28 Z-30."),
    ("G91 G28 Z0.", "G91 G28 X0. Z0."),
    ("G53 G0 Z0.", "G0 Z0."),
    ("G53 G0 Z0.", "G53 G0"),
    ("G53 G0 Z0.", "G53 G0 X0."),
    ("G0 SUPA Z0.0000 D0", "G0 Z0.0000 D0"),
    ("G0 SUPA Z0.0000 D0", "G0 SUPA D0"),
    ("L Z+0.0000 R0 FMAX M91", "L Z+0.0000 R0 FMAX"),
    ("L Z+0.0000 R0 FMAX M91", "L R0 FMAX M91"),
    // Whole blocks.
    ("G91 G28 Z0.", "M9"),
    ("G53 G0 Z0.", "M9"),
    ("G0 SUPA Z0.0000 D0", "M9"),
    ("L Z+0.0000 R0 FMAX M91", "M9"),
    // Tool and spindle.
    ("S1200 M3", "M3"),
    ("S1200 M3", "S1200 M4"),
    (" S1200", ""),
    (" M3\n", " M4\n"),
    ("TOOL CALL 4", "TOOL DEF 4"),
    // TCP and the tilted plane.
    ("ORIWKS ORIAXES", "ORIWKS"),
    ("ORIWKS ORIVECT", "ORIVECT"),
    ("G53.1", "M8"),
    (" TURN ", " STAY "),
    (" TURN ", " "),
    (",-1,100,1)", ",0,100,1)"),
    ("100000,57", "100001,57"),
    ("PLANE RESET", "M9 ;"),
    ("CYCLE800()", "M9"),
    ("G69", "M9"),
];

/// `text` with the occurrence of `from` at `place` changed.
fn changed(text: &str, place: usize, from: &str, to: &str) -> String {
    format!("{}{to}{}", &text[..place], &text[place + from.len()..])
}

#[test]
fn a_word_left_out_or_changed_between_the_cuts_is_refused() {
    let (machine, program) = (machine("ac-trunnion"), plunges());
    let mut tried = [0; CHANGES.len()];
    for (control, kinds) in OUTPUTS {
        for &output in kinds {
            let text = posted(&machine, &program, control, output).text;
            assert!(read_back(&machine, control, &text).is_ok());
            for (count, (from, to)) in tried.iter_mut().zip(CHANGES) {
                for (place, _) in text.match_indices(from) {
                    let line = 1 + text[..place].matches('\n').count();
                    let read = read_back(&machine, control, &changed(&text, place, from, to));
                    assert!(read.is_err(), "{control} {}: line {line}: {from} → {to}", output.name());
                    *count += 1;
                }
            }
        }
    }
    for (count, (from, to)) in tried.into_iter().zip(CHANGES) {
        assert!(count > 0, "{from} → {to} is in no program");
    }
}

/// Before the first tool the position of no axis is known: each has to be given before the tool comes down.
#[test]
fn a_tool_comes_down_from_a_position_that_is_given() {
    let program = plunges();
    for name in MACHINES {
        let machine = machine(name);
        for (control, kinds) in OUTPUTS {
            for &output in kinds {
                let text = posted(&machine, &program, control, output).text;
                let first = text.find("TOOL 4").unwrap();
                let ahead = text[first..].lines().take(6).filter(|line| {
                    let axes = line.split(' ').filter(|w| w.starts_with(['X', 'Y', 'A', 'B', 'C']));
                    axes.clone().any(|word| word[1..].parse::<f64>().is_ok()) && !line.contains('Z')
                });
                let ahead: Vec<&str> = ahead.collect();
                let case = format!("{name} {control} {}", output.name());
                assert_eq!(ahead.len(), 2, "{case}: {ahead:?}");
                for line in ahead {
                    // A plane turns the axes itself; no X and Y are known then.
                    if output == OutputKind::Plane && !line.contains(" X") {
                        continue;
                    }
                    let without = text.replacen(&format!("{line}\n"), "", 1);
                    assert!(read_back(&machine, control, &without).is_err(), "{case}: without {line}");
                }
            }
        }
    }
}

/// Machine coordinates of the moves of the second tool up to the first that the program gives whole, which is
/// one more.
fn way_down(machine: &MachineTool, reading: &NcReading) -> Vec<[f64; 3]> {
    let moves = reading.program.moves.iter().zip(&reading.angles);
    let second: Vec<_> = moves.filter(|(step, _)| step.tool == Some(1)).collect();
    let first_whole = second.iter().position(|(_, angles)| !angles.is_retract()).unwrap();
    let length = gauge_length(machine, &reading.program.tools[1]);
    let mut angles = [0.0; 2];
    let joints = second[..=first_whole].iter().map(|(step, at)| {
        // What a control chooses it has chosen at the retract position.
        angles = at.known().unwrap_or(angles);
        machine.joints(&placed(machine).point_in_program(&step.tip), &angles, length)
    });
    joints.collect()
}

#[test]
fn the_way_down_begins_where_the_axes_stand() {
    let program = plunges();
    for name in MACHINES {
        let machine = machine(name);
        let top = machine.linear[2].limits.1;
        for (control, kinds) in OUTPUTS {
            for &output in kinds {
                let case = format!("{name} {control} {}", output.name());
                let text = posted(&machine, &program, control, output).text;
                let reading = read_back(&machine, control, &text).unwrap();
                assert!(reading.angles.iter().any(|angles| matches!(angles, MoveAngles::Retract(_))));
                let way = way_down(&machine, &reading);
                let [from, to] = [way[way.len() - 2], way[way.len() - 1]];
                assert!((from[2] - top).abs() < 1e-3, "{case}: {from:?}");
                assert!((from[0] - to[0]).hypot(from[1] - to[1]) < 2e-3, "{case}: {from:?} to {to:?}");
                // Where X is another one there, the tool comes from there.
                let second = text.find("TOOL 7").unwrap();
                let place = second + text[second..].find(" X").unwrap() + 2;
                let end = place + text[place..].find(' ').unwrap();
                let x: f64 = text[place..end].parse().unwrap();
                let plus = if control == "heidenhain" && x + 30.0 >= 0.0 { "+" } else { "" };
                let other = format!("{}{plus}{:.4}{}", &text[..place], x + 30.0, &text[end..]);
                let reading = read_back(&machine, control, &other).unwrap();
                let way = way_down(&machine, &reading);
                let other = way[way.len() - 2];
                let moved = (other[0] - from[0], other[1] - from[1], other[2] - from[2]);
                assert!((moved.0 - 30.0).abs() < 1e-3, "{case}: {from:?}, {other:?}");
                assert!(moved.1.hypot(moved.2) < 1e-3, "{case}: {from:?}, {other:?}");
            }
        }
    }
}

/// The zero of the control's axes is where the builder put it: the machine file says what the control calls
/// the upper limit of Z.
#[test]
fn programs_retract_to_what_the_control_calls_the_upper_limit() {
    for (control, block) in [
        ("haas", "G53 G0 Z1400."),
        ("linuxcnc", "G53 G0 Z1400."),
        ("siemens", "G0 SUPA Z1400.0000 D0"),
        ("heidenhain", "L Z+1400.0000 R0 FMAX M91"),
    ] {
        let mut machine = machine("ac-trunnion");
        machine.links.retract_z = 1400.0;
        let text = PLUNGED.posted(&machine, control, OutputKind::TcpAngles).0.text;
        assert!(text.contains(block), "{control}");
        assert_eq!(found_by(&machine, control, &text), None, "{control}");
        let zero = block.replace("1400", "0");
        let place = text.rfind(block).unwrap();
        let lowered = changed(&text, place, block, &zero);
        assert_eq!(found_by(&machine, control, &lowered), Some("faults"), "{control}");
    }
}

/// Machine coordinates count from the upper end of Z: far below it, the tool goes into the part.
#[test]
fn a_retract_into_the_part_is_found() {
    let machine = machine("ac-trunnion");
    let text = PLUNGED.posted(&machine, "haas", OutputKind::TcpAngles).0.text;
    assert_eq!(found_by(&machine, "haas", &text), None, "{:?}", kinds_of(&MEANT.verdict));
    let place = text.rfind("G53 G0 Z0.").unwrap();
    let text = changed(&text, place, "G53 G0 Z0.", "G53 G0 Z-1300.");
    assert_eq!(found_by(&machine, "haas", &text), Some("faults"));
}
