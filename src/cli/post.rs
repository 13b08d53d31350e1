//! `vanecut post`.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::args::PostArgs;
use super::stdout::print_stdout;
use super::{Failure, open, output};
use crate::error::ErrorCode;
use crate::geometry::without_conversion_error;
use crate::io::apt::{cut_off_error, read_apt_bytes};
use crate::io::flank_file::{is_flank, read_flank_bytes};
use crate::io::machine_file::read_machine;
use crate::io::nc::read_post;
use crate::io::plan_file::read_plan_bytes;
use crate::io::replaced::check_is_no_input;
use crate::io::setup_file::read_setup;
use crate::io::write_atomically;
use crate::job::post::{PostFault, PostRequest, PostedProgram, post_program};
use crate::machine::{BlankSize, ChannelCalls, MachineTool, MotionFault, OutputKind, SectionTime};
use crate::monitor::Monitor;
use crate::setup::{Setup, Tool};
use crate::toolpath::ClProgram;

/// A program with what its source says of the part.
struct PostSource {
    program: ClProgram,
    /// Whether the inlet points to +Z in the part frame.
    inlet_up: bool,
    blank: Option<BlankSize>,
    /// How often it is called as a subprogram.
    calls: ChannelCalls,
    /// File name for messages.
    name: String,
    /// Whether the lines of its moves are those of the file; in plans they are the numbers of the moves.
    has_lines: bool,
}

impl PostSource {
    /// Place of a move in messages.
    fn place(&self, line: usize) -> String {
        match (line, self.has_lines) {
            (0, _) => self.name.clone(),
            (_, true) => format!("{}:{line}", self.name),
            (_, false) => format!("{}: move {line}", self.name),
        }
    }
}

/// Posts a program and prints its figures.
///
/// # Errors
/// [`Failure::input`] when an input is invalid, [`Failure::work`] when the machine cannot run the program.
pub fn run(args: &PostArgs) -> Result<(), Failure> {
    let started = std::time::Instant::now();
    let (control, setup) = (args.control.as_deref().map(Path::new), args.setup.as_deref());
    check_is_no_input(&args.file, &[Some(&args.program), Some(&args.machine), control, setup])?;
    let machine = read_machine(&args.machine)?;
    let mut post = read_post(args.control.as_deref().unwrap_or(&machine.control))?;
    if args.subprogram {
        post = post.into_subprogram()?;
    }
    let output = match args.kind.as_deref() {
        None => machine.output,
        Some(name) => OutputKind::of_name(name).ok_or_else(|| {
            let known = OutputKind::ALL.map(OutputKind::name).join(", ");
            let what = format!("--output {name} is not known");
            Failure::input(ErrorCode::UnknownName, what, format!("use one of {known}"))
        })?,
    };
    if !post.outputs().any(|known| known == output) {
        let known: Vec<&str> = post.outputs().map(OutputKind::name).collect();
        let what = format!("the control {} does not take {}", post.name, output.name());
        let help = format!("give --output {}", known.join(" or "));
        return Err(Failure::input(ErrorCode::ControlOutput, what, help));
    }
    let mut source = read_source(args)?;
    if let Some(path) = &args.setup {
        fill_tools(&mut source.program, &read_setup(path, &Setup::default())?.tools);
    }
    let calls = args.subprogram.then_some(source.calls);
    let request =
        PostRequest { machine, post, output, inlet_up: source.inlet_up, blank: source.blank, calls };
    let posted = post_program(&source.program, &request, &Monitor::default());
    let posted = posted.map_err(|fault| match fault {
        PostFault::Motion(fault) => refused(args, &request.machine, &source, &fault),
        PostFault::Words(error) => Failure::from(error).at(&source.name),
    })?;
    write_atomically(&args.file, posted.written.text.as_bytes())?;
    if args.json {
        let mut map = object(&request, &source, &posted);
        map.insert("elapsed".into(), output::number(started.elapsed().as_secs_f64()));
        print_stdout(&format!("{}\n", Value::Object(map)))
    } else {
        print_stdout(&text(args, &request, &source, &posted))
    }
}

/// The failure of a program that the machine cannot run; with `--json` the number of positions is printed.
fn refused(args: &PostArgs, machine: &MachineTool, source: &PostSource, fault: &MotionFault) -> Failure {
    let place = source.place(fault.line());
    if let MotionFault::Lacks { error, .. } = fault {
        return Failure::from(error.clone()).at(place);
    }
    if args.json {
        let mut map = Map::new();
        for key in [
            "blocks",
            "positions",
            "time",
            "time_by_section",
            "rotary_travel",
            "rewinds",
            "largest_tip_error",
        ] {
            map.insert(key.into(), Value::Null);
        }
        map.insert("limits_exceeded".into(), json!(fault.limits_exceeded()));
        // The fault itself is what counts; a closed output adds nothing to it.
        let _ = print_stdout(&format!("{}\n", Value::Object(map)));
    }
    Failure::of_work(fault.explained()).at(format!("{place}: {}", machine.name))
}

/// Reads a plan, a flank plan or an APT program.
fn read_source(args: &PostArgs) -> Result<PostSource, Failure> {
    let (name, bytes) = open::named_bytes(&args.program)?;
    if !bytes.trim_ascii_start().starts_with(b"{") {
        let program = read_apt_bytes(&name, &bytes)?;
        if program.moves.is_empty() {
            let what = "the program moves nothing";
            return Err(Failure::input(ErrorCode::NothingMoves, what, "give one with GOTO").at(name));
        }
        // The NC program would have its end: nobody could see that moves are missing.
        if program.is_cut_off {
            return Err(Failure::from(cut_off_error()).at(name));
        }
        // Tools come from the inlet: their axes point to its side.
        let up: f64 = program.moves.iter().map(|m| m.axis.z).sum();
        let (inlet_up, calls) = (up >= 0.0, ChannelCalls::Unknown);
        return Ok(PostSource { program, inlet_up, blank: None, calls, name, has_lines: true });
    }
    let (mut program, part, setup, channels) = if is_flank(&bytes) {
        let stored = read_flank_bytes(&name, &bytes)?;
        let missing = || Failure::input(ErrorCode::PlanFile, "has no tool", "plan it again").at(&name);
        let program = stored.program(&Monitor::default())?.ok_or_else(missing)?;
        (program, stored.part, stored.setup, stored.channels)
    } else {
        let stored = read_plan_bytes(&name, &bytes)?;
        (stored.program(&Monitor::default())?, stored.part, stored.setup, stored.channels)
    };
    if program.moves.is_empty() {
        let what = "the plan has no positions";
        return Err(
            Failure::input(ErrorCode::NothingMoves, what, "plan the part with tools that fit").at(name)
        );
    }
    let inlet_up = part.out_of_inlet().z > 0.0;
    for (number, step) in (1..).zip(&mut program.moves) {
        step.line = number;
    }
    Ok(PostSource {
        program,
        inlet_up,
        blank: Some(BlankSize::from_part(&part, &setup.allowances)),
        calls: ChannelCalls::for_channels(channels, part.blade_count, setup.channels.sequence),
        name,
        has_lines: false,
    })
}

/// Completes tools by those of the setup with the same number.
fn fill_tools(program: &mut ClProgram, tools: &[Tool]) {
    for tool in &mut program.tools {
        if let Some(known) = tools.iter().find(|known| known.number == tool.number) {
            tool.spindle_rpm = tool.spindle_rpm.or(Some(known.spindle));
            tool.overhang = tool.overhang.or(Some(known.overhang));
            tool.insert_width = tool.insert_width.or(Some(known.insert_width));
            tool.length_offset = tool.length_offset.or(known.assembly.length_offset);
        }
    }
}

fn section_object(program: &ClProgram, time: &SectionTime) -> Value {
    json!({
        "section": time.section,
        "tool": program.tools.get(time.tool).map(|tool| tool.number),
        "time": output::number(time.total_s()),
        "feed": output::number(time.feed_s),
        "links": output::number(time.links_s),
        "turns": output::number(time.turns_s),
        "tool_change": output::number(time.tool_change_s),
    })
}

fn object(request: &PostRequest, source: &PostSource, posted: &PostedProgram) -> Map<String, Value> {
    let PostSource { program, .. } = source;
    let PostRequest { machine, post, output, .. } = request;
    let PostedProgram { motion, written, times, .. } = posted;
    let mut map = Map::new();
    map.insert("machine".into(), json!(machine.name));
    map.insert("blocks".into(), json!(written.blocks));
    map.insert("positions".into(), json!(written.positions));
    map.insert("time".into(), output::number(posted.time_s()));
    map.insert("time_by_section".into(), times.iter().map(|time| section_object(program, time)).collect());
    map.insert("rotary_travel".into(), output::rotary_travel(machine, motion.rotary_travel));
    map.insert("rewinds".into(), json!(motion.rewinds));
    map.insert("clear_links".into(), json!(motion.clear_links));
    map.insert("limits_exceeded".into(), json!(0));
    map.insert("largest_tip_error".into(), output::number(posted.tip_error()));
    map.insert("largest_axis_error".into(), output::number(motion.axis_error_rad.to_degrees()));
    map.insert("control".into(), json!(post.name));
    map.insert("output".into(), json!(output.name()));
    if let Some(calls) = request.calls {
        map.insert("calls".into(), json!(calls.count()));
        map.insert(
            "call_turn".into(),
            json!(calls.turn_rad().map(|turn| without_conversion_error(turn.to_degrees()))),
        );
        map.insert("call_turns".into(), json!(calls.offsets_deg()));
    }
    map
}

fn text(args: &PostArgs, request: &PostRequest, source: &PostSource, posted: &PostedProgram) -> String {
    let PostSource { program, .. } = source;
    let PostRequest { machine, post, output, .. } = request;
    let PostedProgram { motion, written, times, .. } = posted;
    let minutes = |s: f64| format!("{:.1}", s / 60.0);
    let mut text = format!(
        "{}: {} for {}, {} {}\n",
        args.file.display(),
        written.block_words(),
        machine.name,
        post.name,
        output.name()
    );
    text += "section  tool   min  feed  links  turns  change\n";
    for time in times {
        let section = time.section.map_or("–".to_owned(), |section| section.to_string());
        let number = program.tools.get(time.tool).map_or(0, |tool| tool.number);
        let [total, feed, links, turns, change] =
            [time.total_s(), time.feed_s, time.links_s, time.turns_s, time.tool_change_s].map(minutes);
        text += &format!(
            "{section:>7}  {number:>4}  {total:>4}  {feed:>4}  {links:>5}  {turns:>5}  {change:>6}\n"
        );
    }
    text += &format!(
        "{} min in all; {} turns {:.0}°, {} turns {:.0}°; {} links leave the part, \
         {} of them unwind an axis\n",
        minutes(posted.time_s()),
        machine.rotary[0].letter,
        motion.rotary_travel[0].to_degrees(),
        machine.rotary[1].letter,
        motion.rotary_travel[1].to_degrees(),
        motion.clear_links,
        motion.rewinds
    );
    text += &format!("{}\n", post.retract_words(machine.links.retract_z));
    if let Some(words) = request.calls.and_then(ChannelCalls::words) {
        text += &format!("{words}\n");
    }
    text += &format!(
        "largest error of the tip {:.4} mm, of the axis {:.4}°\n",
        posted.tip_error(),
        motion.axis_error_rad.to_degrees()
    );
    text
}
