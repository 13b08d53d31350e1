//! What must not pass: limits, missing words, and programs with one thing changed.

use vanecut::error::ErrorCode;
use vanecut::io::nc::{read_post, read_post_bytes, write_nc};
use vanecut::machine::{MachineTool, MotionFault, OutputKind};
use vanecut::toolpath::{ClProgram, Motion, Move};

use super::programs::{
    OUTPUTS, largest_difference, machine, moved, plunges, posted, read_back, sweeps, tilted,
};

fn fault_of(edit: impl Fn(&mut MachineTool)) -> MotionFault {
    let mut machine = machine("ac-trunnion");
    edit(&mut machine);
    let post = read_post("fanuc").unwrap();
    moved(&machine, &plunges(), &post, OutputKind::TcpAngles).unwrap_err()
}

#[test]
fn limits_and_reach_are_reported_with_their_number() {
    let tilt = fault_of(|m| m.rotary[1].limits = Some((-0.2, 0.5)));
    assert_eq!(tilt.explained().code, ErrorCode::AxisLimits, "{tilt}");
    assert!(tilt.limits_exceeded() > 3 && tilt.line() > 0 && !tilt.to_string().contains('\n'), "{tilt}");
    let travel = fault_of(|m| m.linear[0].limits = (-20.0, 20.0));
    assert_eq!(travel.explained().code, ErrorCode::AxisLimits, "{travel}");
    assert!(travel.to_string().contains("X "), "names the axis: {travel}");
    // How far the part would have to be moved: for the furthest position, not for the first.
    let mut program = plunges();
    let late = program.moves.len() - 2;
    program.moves[late].tip *= 4.0;
    let mut small = machine("ac-trunnion");
    small.linear[0].limits = (-20.0, 20.0);
    let fault = moved(&small, &program, &read_post("fanuc").unwrap(), OutputKind::TcpAngles).unwrap_err();
    let MotionFault::OutOfLimits { first, worst: Some(worst), .. } = &fault else { panic!("{fault}") };
    assert!(worst.excess() > first.excess().map(|mm| mm + 100.0), "{fault}");
    assert!(fault.to_string().contains(&format!(", up to {}", worst.where_to())), "{fault}");

    let mut steep = plunges();
    for step in &mut steep.moves {
        step.axis = -step.axis;
    }
    let post = read_post("linuxcnc").unwrap();
    let fault = moved(&machine("nutating-table"), &steep, &post, OutputKind::TcpAngles).unwrap_err();
    assert_eq!(fault.explained().code, ErrorCode::AxisLimits, "{fault}");
}

/// They were counted up to 1000 only, without a word.
#[test]
fn all_positions_beyond_a_limit_are_found() {
    let beyond = |repeats: usize| {
        let mut program = plunges();
        program.moves = std::iter::repeat_n(program.moves, repeats).flatten().collect();
        let mut machine = machine("ac-trunnion");
        let text = posted(&machine, &program, "fanuc", OutputKind::TcpAngles).text;
        machine.rotary[1].limits = Some((-0.01, 0.01));
        read_back(&machine, "fanuc", &text).expect("readable").overruns.len()
    };
    let (one, many) = (beyond(1), beyond(20));
    assert!(one > 3 && many > 1000 && many.abs_diff(20 * one) <= many / 50, "{one}, {many}");
}

/// A cut that leads the tool around the pole of the machine's first axis, 30° from it.
fn around_the_pole(degrees: &[f64]) -> ClProgram {
    let mut program = sweeps();
    let step = program.moves[1].clone();
    program.moves = (1..)
        .zip(degrees)
        .map(|(line, around)| Move { axis: tilted(30.0, *around), line, ..step.clone() })
        .collect();
    program.moves[0].motion = Motion::Rapid;
    program
}

#[test]
fn axes_that_cannot_stay_in_the_cut_are_refused_at_its_line() {
    let post = read_post("fanuc").unwrap();
    let fault_of = |edit: &dyn Fn(&mut MachineTool), degrees: &[f64]| {
        let mut machine = machine("ac-trunnion");
        edit(&mut machine);
        let program = around_the_pole(degrees);
        let fault = moved(&machine, &program, &post, OutputKind::TcpAngles).map(|_| ()).unwrap_err();
        (fault.explained().code, fault.line())
    };
    let turn = (0..=12).map(|k| 30.0 * f64::from(k)).collect::<Vec<f64>>();
    let narrow = |m: &mut MachineTool| m.rotary[0].limits = Some((-3.0, 3.0));
    let (code, line) = fault_of(&narrow, &turn);
    assert!(code == ErrorCode::AxisTurnsBack && line > 1, "{code} in line {line}");
    // The even turn between two directions passes nearer to the pole, where the second axis must not go.
    let tilt = 30f64.to_radians();
    let bounded = |m: &mut MachineTool| m.rotary[1].limits = Some((0.99 * tilt, 1.5));
    assert_eq!(fault_of(&bounded, &[0.0, 90.0]), (ErrorCode::AxisCannotFollow, 2));
}

#[test]
fn programs_lack_nothing() {
    let (ac, post) = (machine("ac-trunnion"), read_post("fanuc").unwrap());
    let mut program = plunges();
    let motion = moved(&ac, &program, &post, OutputKind::TcpAngles).unwrap();
    program.tools[0].number = 0;
    let error = write_nc(&program, &ac, &motion, &post, OutputKind::TcpAngles, &[]).unwrap_err();
    assert_eq!(error.code, ErrorCode::ProgramTool, "{error}");
    program.tools[0].number = 4;
    program.tools[1].spindle_rpm = None;
    let error = write_nc(&program, &ac, &motion, &post, OutputKind::TcpAngles, &[]).unwrap_err();
    assert_eq!(error.code, ErrorCode::ProgramTool, "{error}");
    let error =
        write_nc(&plunges(), &ac, &motion, &read_post("haas").unwrap(), OutputKind::Plane, &[]).unwrap_err();
    assert_eq!(error.code, ErrorCode::ControlOutput, "{error}");

    let mut program = plunges();
    program.moves[1].motion = Motion::Feed(None);
    let fault = moved(&ac, &program, &post, OutputKind::TcpAngles).unwrap_err();
    assert_eq!((fault.explained().code, fault.line()), (ErrorCode::ProgramFeedRate, 2), "{fault}");
    let fault = moved(&ac, &sweeps(), &post, OutputKind::Plane).unwrap_err();
    assert_eq!(fault.explained().code, ErrorCode::ControlOutput, "{fault}");
}

/// Whether a changed program is seen to be another one: it is refused, an axis is beyond its limits, a cut
/// has no feed rate, runs as a link, ends elsewhere, or is made with another tool.
fn is_caught(machine: &MachineTool, control: &str, program: &ClProgram, text: &str) -> bool {
    let Ok(reading) = read_back(machine, control, text) else { return true };
    let no_rate = reading.program.moves.iter().any(|m| m.motion == Motion::Feed(None));
    let differs = largest_difference(program, &reading).map_or(true, |(tip, axis)| tip > 1e-3 || axis > 1e-4);
    // Cuts with another tool end at the same places.
    let tools = |program: &ClProgram| {
        let mut used: Vec<u32> = Vec::new();
        for step in program.moves.iter().filter(|m| m.motion != Motion::Rapid) {
            let number = step.tool.map_or(0, |tool| program.tools[tool].number);
            if used.last() != Some(&number) {
                used.push(number);
            }
        }
        used
    };
    no_rate || differs || !reading.overruns.is_empty() || tools(program) != tools(&reading.program)
}

/// The words of a line that are numbers: where the number is, and its value.
fn numbers_of(line: &str) -> Vec<(std::ops::Range<usize>, f64)> {
    let mut found = Vec::new();
    let mut at = 0;
    for word in line.split(' ') {
        let address = word.len() - word.trim_start_matches(|c: char| c.is_ascii_uppercase()).len();
        // Siemens writes A3=0.5.
        let address = word.find('=').map_or(address, |sign| sign + 1);
        let is_axis = ["X", "Y", "Z", "A", "B", "C", "TX", "TY", "TZ", "I", "J", "K", "A3=", "B3=", "C3="]
            .contains(&&word[..address]);
        if let (true, Ok(value)) = (is_axis, word[address..].parse()) {
            found.push((at + address..at + word.len(), value));
        }
        at += word.len() + 1;
    }
    found
}

/// In every third cut: each sign turned, each number moved, and each F left out, one at a time.
#[test]
fn a_changed_number_of_a_cut_is_always_caught() {
    let program = plunges();
    for name in ["ac-trunnion", "bc-head"] {
        let machine = machine(name);
        for (control, kinds) in OUTPUTS {
            for &output in kinds {
                let text = posted(&machine, &program, control, output).text;
                assert!(!is_caught(&machine, control, &program, &text));
                let lines: Vec<&str> = text.lines().collect();
                let cuts = (0..lines.len()).filter(|&k| lines[k].contains(" F240"));
                let mut tried = 0;
                for cut in cuts.step_by(3) {
                    let mut check = |what: &str, line: String| {
                        let mut lines = lines.clone();
                        lines[cut] = &line;
                        let case =
                            format!("{name} {control} {}: {what}: {} → {line}", output.name(), lines[cut]);
                        assert!(is_caught(&machine, control, &program, &lines.join("\n")), "{case}");
                        tried += 1;
                    };
                    for (range, value) in numbers_of(lines[cut]) {
                        let (head, tail) = (&lines[cut][..range.start], &lines[cut][range.end..]);
                        if value.abs() > 0.01 {
                            check("sign", format!("{head}{:.4}{tail}", -value));
                        }
                        check("offset", format!("{head}{:.4}{tail}", value + 0.1));
                    }
                    check("no F", lines[cut].split(" F").next().unwrap().to_owned());
                }
                assert!(tried > 40, "{control}: {tried}");
            }
        }
    }
}

/// A mode that is left on, an offset that is not there, a spindle that stands: each line that sets one is
/// left out.
#[test]
fn a_mode_left_out_is_always_caught() {
    let program = plunges();
    let machine = machine("ac-trunnion");
    for (control, kinds) in OUTPUTS {
        for &output in kinds {
            let text = posted(&machine, &program, control, output).text;
            let lines: Vec<&str> = text.lines().collect();
            let on_and_off: &[&str] = match (control, output) {
                ("heidenhain", OutputKind::Plane) => &["PLANE SPATIAL", "PLANE RESET"],
                ("heidenhain", _) => &["M128", "M129"],
                ("siemens", OutputKind::Plane) => &["CYCLE800(0", "CYCLE800()"],
                ("siemens", OutputKind::Joints) => &[],
                ("siemens", _) => &["TRAORI", "TRAFOOF"],
                ("fanuc", OutputKind::Plane) => &["G68.2", "G69"],
                ("fanuc" | "haas" | "linuxcnc", OutputKind::Joints) => &["G43"],
                ("fanuc", OutputKind::TcpVectors) => &["G43.5", "G49"],
                ("fanuc", _) => &["G43.4", "G49"],
                ("haas", _) => &["G234", "G49"],
                _ => &["M428", "M429"],
            };
            let tool: &[&str] = match control {
                // `END PGM` is an end, too.
                "heidenhain" => &["TOOL CALL", "M3"],
                _ => &["M6", "M3", "M30"],
            };
            for word in on_and_off.iter().chain(tool) {
                let ends = |line: &str| line.split(' ').any(|part| part == *word);
                let says = |line: &&str| match word.starts_with('M') {
                    true => ends(line),
                    false => {
                        line.contains(word)
                            && !line.contains("G80")
                            && (*word != "G43" || !line.contains("G43."))
                    }
                };
                let places: Vec<usize> = (0..lines.len()).filter(|&k| says(&lines[k])).collect();
                assert!(!places.is_empty(), "{control} {}: no {word}", output.name());
                for place in places {
                    let without: Vec<&str> =
                        (0..lines.len()).filter(|&k| k != place).map(|k| lines[k]).collect();
                    let case =
                        format!("{control} {}: without line {}: {}", output.name(), place + 1, lines[place]);
                    assert!(is_caught(&machine, control, &program, &without.join("\n")), "{case}");
                }
            }
        }
    }
}

#[test]
fn faulty_programs_name_their_line() {
    let machine = machine("ac-trunnion");
    let text = posted(&machine, &plunges(), "fanuc", OutputKind::TcpAngles).text;
    let line_of = |words: &str| 1 + text[..text.find(words).unwrap()].matches('\n').count();
    for (from, to, code, line) in [
        ("G43.4 H4", "G43.4", ErrorCode::NcBlock, line_of("G43.4 H4")),
        ("G43.4 H4", "G43.4 H5", ErrorCode::NcBlock, line_of("G43.4 H4")),
        // The spindle stands at the first cut; faster moves are links.
        ("S1200 M3", "S1200", ErrorCode::NcBlock, line_of(" F240")),
        ("T4 M6", "M6", ErrorCode::ProgramTool, line_of("T4 M6")),
        ("G21", "G20", ErrorCode::NcBlock, line_of("G21")),
        ("G1 X", "G2 X", ErrorCode::NcBlock, line_of("G1 X")),
        ("M30", "M0", ErrorCode::FileCutOff, text.lines().count()),
        (" A", " A1 A", ErrorCode::NcBlock, line_of(" A")),
        ("G54", "G54 G999", ErrorCode::NcBlock, line_of("G54")),
        ("(AC", "AC", ErrorCode::NcBlock, line_of("(AC")),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        let error = read_back(&machine, "fanuc", &changed).unwrap_err();
        assert_eq!((error.code, error.place()), (code, format!("p.nc:{line}")), "{from} → {to}: {error}");
    }
}

/// The length of a tool is that of the offset which the shop gives it, and no other passes.
#[test]
fn length_offsets_are_those_of_the_tools() {
    let mut program = plunges();
    program.tools[0].length_offset = Some(31);
    for (name, output, word) in [
        ("fanuc", OutputKind::TcpAngles, "G43.4 H"),
        ("fanuc", OutputKind::TcpVectors, "G43.5 H"),
        ("fanuc", OutputKind::Plane, "G43 H"),
        ("fanuc", OutputKind::Joints, "G43 H"),
        ("haas", OutputKind::TcpAngles, "G234 H"),
        ("haas", OutputKind::Joints, "G43 H"),
    ] {
        let machine = machine("ac-trunnion");
        let text = posted(&machine, &program, name, output).text;
        let first = |text: &str| text.lines().find_map(|line| line.split(word).nth(1).map(str::to_owned));
        assert_eq!(first(&text).as_deref(), Some("31"), "{name} {}", output.name());
        assert!(text.contains(&format!("{word}7\n")), "{name}: that of the second tool is its number");
        assert!(!is_caught(&machine, name, &program, &text), "{name} {}", output.name());
        let other = text.replacen(&format!("{word}31"), &format!("{word}4"), 1);
        assert!(is_caught(&machine, name, &program, &other), "{name} {}", output.name());
    }
}

#[test]
fn any_text_is_answered() {
    let machine = machine("ac-trunnion");
    let texts =
        ["", "\0", "%", "G", "N10", "0 L X", "0 TOOL CALL", "A3=", "CYCLE800(", "G1 X1e9", "é", "0 LN TX+0"];
    for (control, _) in OUTPUTS {
        let sound = posted(&machine, &plunges(), control, OutputKind::TcpAngles).text;
        for text in texts {
            assert!(read_back(&machine, control, text).is_err(), "{control}: {text:?}");
        }
        // Cut off anywhere, or with a line doubled or left out, it is answered without a panic.
        for k in (0..sound.len()).step_by(sound.len() / 60) {
            let _ = read_back(&machine, control, sound.get(..k).unwrap_or_default());
        }
    }
}

#[test]
fn posts_of_a_shop() {
    let text =
        "extends = \"fanuc\"\n[format]\nnumbers = []\n[blocks]\nend = [\"M5\", \"M9\", \"M30\", \"%\"]\n";
    let post = read_post_bytes("shop.toml", text.as_bytes()).unwrap();
    let machine = machine("ac-trunnion");
    let program = plunges();
    let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
    let nc = write_nc(&program, &machine, &motion, &post, OutputKind::TcpAngles, &[]).unwrap();
    assert!(nc.text.ends_with("M5\nM9\nM30\n%\n") && nc.text.contains("\nG43.4 H4\n"), "{}", nc.text);
    assert!(read_back(&machine, "fanuc", &nc.text).is_ok());
    for (text, line, code) in [
        ("extends = \"fanuk\"", 1, ErrorCode::UnknownName),
        ("extends = \"haas\"\n[blocks]\nend = [\"{toll}\"]", 3, ErrorCode::UnknownName),
        ("extends = \"haas\"\n[on]\nspiral = []", 3, ErrorCode::UnknownKey),
        ("[format]\ndecimals = 3", 1, ErrorCode::MissingKey),
    ] {
        let error = read_post_bytes("shop.toml", text.as_bytes()).unwrap_err();
        assert_eq!((error.line, error.code), (line, code), "{error}");
    }
}

/// A number of seven digits is more than controls take, and more than is read back.
#[test]
fn block_numbers_begin_again_after_six_digits() {
    let text = "extends = \"fanuc\"\n[format]\nnumbers = [999900, 50]\n";
    let post = read_post_bytes("long.toml", text.as_bytes()).unwrap();
    let machine = machine("ac-trunnion");
    let program = plunges();
    let motion = moved(&machine, &program, &post, OutputKind::TcpAngles).unwrap();
    let nc = write_nc(&program, &machine, &motion, &post, OutputKind::TcpAngles, &[]).unwrap();
    let numbers: Vec<&str> = nc.text.lines().filter_map(|line| line.strip_prefix('N')).collect();
    let numbers: Vec<&str> = numbers.iter().filter_map(|line| line.split(' ').next()).collect();
    assert!(numbers.len() > 4);
    assert!(numbers.chunks(2).all(|pair| pair[0] == "999900" && pair.get(1).is_none_or(|n| *n == "999950")));
    assert!(read_back(&machine, "fanuc", &nc.text).is_ok());
}

/// A program that is read for the control of another machine says for which one it seems to be.
#[test]
fn a_program_for_another_control_is_recognised() {
    let machine = machine("ac-trunnion");
    for (written, outputs) in OUTPUTS {
        let text = posted(&machine, &plunges(), written, outputs[0]).text;
        for (read, _) in OUTPUTS.into_iter().filter(|(read, _)| *read != written) {
            let Err(error) = read_back(&machine, read, &text) else { continue };
            if error.code != ErrorCode::NcBlock {
                continue;
            }
            let seems = error.help.contains(&format!("not for {read}"));
            let names = error.help.contains(written);
            assert!(!seems || names, "{written} read as {read}: {error}");
            // These have no grammar in common.
            let is_alike = |name: &str| matches!(name, "fanuc" | "haas" | "linuxcnc");
            assert!(seems || is_alike(written) && is_alike(read), "{written} read as {read}: {error}");
        }
    }
    for control in ["fanuc", "siemens"] {
        let error = read_back(&machine, control, "0 BEGIN PGM P MM\n").unwrap_err().to_string();
        assert!(error.contains("a word begins with a letter, not with `0 BEGIN PGM P MM`"), "{error}");
    }
    // A line that no control reads is a fault of its own.
    let text = posted(&machine, &plunges(), "fanuc", OutputKind::TcpAngles).text + "?\n";
    let error = read_back(&machine, "fanuc", &text).unwrap_err();
    assert!(!error.help.contains("seems"), "{error}");
}
