//! Programs that another one calls once a channel.

use std::f64::consts::TAU;

use vanecut::error::ErrorCode;
use vanecut::geometry::rotate_vector_z;
use vanecut::io::nc::{read_post, read_post_bytes};
use vanecut::job::post::{PostFault, PostRequest, PostedProgram, post_program};
use vanecut::machine::{ChannelCalls, MachineTool, OutputKind};
use vanecut::monitor::Monitor;
use vanecut::setup::ChannelSequence;
use vanecut::toolpath::Motion;

use super::programs::{MACHINES, machine, plunges, read_back, tilted};

fn called(
    machine: &MachineTool,
    control: &str,
    output: OutputKind,
    calls: ChannelCalls,
) -> Result<PostedProgram, PostFault> {
    let request = PostRequest {
        machine: machine.clone(),
        post: read_post(control).unwrap().into_subprogram().unwrap(),
        output,
        inlet_up: false,
        blank: None,
        calls: Some(calls),
    };
    post_program(&plunges(), &request, &Monitor::default())
}

/// A call for each of `count` channels.
fn each(count: usize) -> ChannelCalls {
    ChannelCalls::for_channels(1, count, ChannelSequence::Adjacent)
}

fn refusal(result: Result<PostedProgram, PostFault>) -> String {
    let fault = result.map(|_| ()).unwrap_err();
    let PostFault::Words(error) = &fault else { panic!("{fault}") };
    assert_eq!(error.code, ErrorCode::AxisLimits, "{fault}");
    assert!(!fault.to_string().contains('\n'), "{fault}");
    error.message.clone()
}

/// A subprogram makes the cuts of the program, in five controls. It chooses no work offset, and ends with a
/// return.
#[test]
fn subprograms_return() {
    let machine = machine("ac-trunnion");
    for (control, ends) in [
        ("heidenhain", "END PGM"),
        ("siemens", "M17"),
        ("fanuc", "M99"),
        ("haas", "M99"),
        ("linuxcnc", "ENDSUB"),
    ] {
        let posted = |post, calls| {
            let (output, machine) = (machine.output, machine.clone());
            let request = PostRequest { machine, post, output, inlet_up: false, blank: None, calls };
            post_program(&plunges(), &request, &Monitor::default()).unwrap().written.text
        };
        let post = read_post(control).unwrap();
        let whole = posted(post.clone(), None);
        let called = posted(post.into_subprogram().unwrap(), Some(each(6)));
        let cuts = |text: &str| {
            let moves = read_back(&machine, control, text).expect(control).program.moves;
            let cuts = moves.into_iter().filter(|m| m.motion != Motion::Rapid);
            cuts.map(|m| (m.motion, m.tip, m.axis)).collect::<Vec<_>>()
        };
        assert_eq!(cuts(&called), cuts(&whole), "{control}");
        assert!(whole.contains("M30") && !called.contains("M30") && called.contains(ends), "{called}");
        let comment = "TO BE CALLED 6 TIMES, THE WORK OFFSET TURNED ON BY 60 DEG";
        assert!(called.contains(comment) && !whole.contains("TO BE CALLED"), "{control}: {called}");
        assert!(called.contains("0, 60, 120, 180, 240, 300 DEG"), "{control}: {called}");
        let head: String = called.lines().take(6).collect();
        assert!(!head.contains("G54") && !head.contains("CYCL DEF 247"), "{head}");
    }
    let own = b"dialect = \"fanuc\"\n[on]\njoints = []\n";
    let error = read_post_bytes("own.toml", own).unwrap().into_subprogram().unwrap_err();
    assert!(error.message.contains("own.toml has no `sub_start`"), "{}", error.message);
}

/// Positions in X and Y before the control holds the tip would turn with the offset: the tool would come down
/// beside the way that was looked at.
#[test]
fn nothing_moves_in_the_turned_offset_before_the_tip_is_held() {
    let machine = machine("ac-trunnion");
    for (control, on) in
        [("heidenhain", "M128"), ("siemens", "TRAORI"), ("fanuc", "G43.4"), ("linuxcnc", "M428")]
    {
        let posted = called(&machine, control, OutputKind::TcpAngles, each(7)).unwrap();
        let text = posted.written.text;
        let lines: Vec<&str> = text.lines().collect();
        let places: Vec<usize> = (0..lines.len()).filter(|&k| lines[k].contains(on)).collect();
        assert!(places.len() >= 2, "{control}: one a tool");
        for at in places {
            let since =
                (0..at).rev().find(|&k| lines[k].contains(" M3") || lines[k].ends_with("M6")).unwrap();
            let moves_linear = |line: &str| line.contains(" X") || line.contains(" Y");
            assert!(
                !lines[since + 1..=at].iter().any(|line| moves_linear(line)),
                "{control}: {:?}",
                &lines[since..=at]
            );
        }
        // The first position with the tip held is above the approach, at the top of Z.
        let reading = read_back(&machine, control, &text).unwrap();
        let tool = &reading.program.tools[0];
        let length = vanecut::machine::gauge_length(&machine, tool);
        let place = super::programs::placed(&machine);
        let [first, second] = [0, 1].map(|k| {
            let step = &reading.program.moves[k];
            machine.joints(&place.point_in_program(&step.tip), &reading.angles[k].known().unwrap(), length)
        });
        assert!((first[2] - machine.linear[2].limits.1).abs() < 1e-3, "{control}: Z {}", first[2]);
        assert!((first[0] - second[0]).abs() < 1e-3 && (first[1] - second[1]).abs() < 1e-3, "{control}");
    }
}

/// In every call the axes keep within their limits, and the tool stands in the channel that is called.
#[test]
fn an_axis_with_limits_has_room_for_all_calls() {
    let machine = machine("b-head-c-table");
    let limits = machine.rotary[0].limits.unwrap();
    for count in [1, 2, 7, 30] {
        for output in [OutputKind::TcpAngles, OutputKind::Joints] {
            let calls = each(count);
            let posted = called(&machine, "siemens", output, calls).unwrap();
            for call in 0..count {
                let turn = TAU * call as f64 / count as f64;
                for step in &posted.motion.steps {
                    let angles = [step.pose.angles[0] + turn, step.pose.angles[1]];
                    assert!(
                        angles[0] >= limits.0 - 1e-6 && angles[0] <= limits.1 + 1e-6,
                        "{count}: {angles:?}"
                    );
                    // C counts the tool about +Z of the part.
                    let meant = rotate_vector_z(&machine.tool_axis(&step.pose.angles), turn);
                    assert!((machine.tool_axis(&angles) - meant).norm() < 1e-9);
                }
            }
        }
    }
    let mut narrow = machine.clone();
    narrow.rotary[0].limits = Some((-1.5, 3.0));
    let message = refusal(called(&narrow, "siemens", OutputKind::TcpAngles, each(7)));
    assert!(message.starts_with("C turns the part"), "{message}");
    narrow.rotary[0].limits = Some((-4.0, 3.0));
    let message = refusal(called(&narrow, "siemens", OutputKind::TcpAngles, ChannelCalls::Unknown));
    assert!(message.contains("the calls leave"), "{message}");
}

/// Positions of the axes of a head do not turn with an offset; vectors do, and are looked at in every call.
#[test]
fn heads_are_refused_where_axes_are_named() {
    for name in MACHINES {
        let machine = machine(name);
        let calls = each(5);
        let angles = called(&machine, "fanuc", OutputKind::TcpAngles, calls);
        assert_eq!(angles.is_err(), name == "bc-head", "{name}");
        assert!(called(&machine, "fanuc", OutputKind::TcpVectors, calls).is_ok(), "{name}");
        assert!(called(&machine, "fanuc", OutputKind::TcpAngles, each(1)).is_ok(), "{name}");
    }
    let message = refusal(called(&machine("bc-head"), "fanuc", OutputKind::Joints, each(5)));
    assert!(message.contains("no table of BC head"), "{message}");
    // The first channel is reached, one of those turned on is not.
    let mut head = machine("bc-head");
    head.rotary[0].limits = Some((-1.0, 1.0));
    let post = read_post("fanuc").unwrap().into_subprogram().unwrap();
    let posted = |calls| {
        let (output, machine) = (OutputKind::TcpVectors, head.clone());
        let request =
            PostRequest { machine, post: post.clone(), output, inlet_up: false, blank: None, calls };
        let mut program = plunges();
        program.moves.truncate(3);
        for step in &mut program.moves {
            step.axis = tilted(30.0, 0.0);
        }
        post_program(&program, &request, &Monitor::default())
    };
    let alone = posted(Some(each(1)));
    assert!(alone.is_ok(), "{:?}", alone.err());
    assert!(matches!(posted(Some(each(4))), Err(PostFault::Motion(_))));
    assert!(matches!(posted(Some(ChannelCalls::Unknown)), Err(PostFault::Motion(_))));
}
