//! The setup sheet of a flank plan: as that of plunges, with its passes by layer.

use std::fmt::Write;

use super::wheel::{CalledProgram, WheelLine, WheelTime};
use super::{
    MAX_FAULTS, ProgramFile, SheetPart, faults_text, heading_of, is_called_for_each_channel,
    other_times_text, page, program_files, tool_card, tool_warnings, warning_list,
};
use crate::flank::UncutLength;
use crate::flank::choice::overhang_note;
use crate::job::flank::FlankOutcome;
use crate::job::flank_channels::FlankProgram;
use crate::machine::MachineClock;
use crate::report::words::{channels_text, left_out_text, tool_loads_text};
use crate::report::{PagePicture, ReportPage};
use crate::setup::{FlankFeedRates, FlankStrategy, Tool};
use crate::toolpath::{TOOL_CHANGE_S, Travel};

/// What the sheet shows.
pub struct FlankSheetInput<'a> {
    /// The plan, of one channel.
    pub outcome: &'a FlankOutcome,
    /// Its program.
    pub program: &'a FlankProgram,
    /// The files of its program; none where it is not written with the sheet.
    pub files: &'a [ProgramFile],
    /// What else must be known of the setup before the program runs.
    pub remarks: &'a [String],
}

/// The sheet with `pictures` of its plan.
pub fn flank_sheet(input: &FlankSheetInput, pictures: Vec<PagePicture>) -> ReportPage {
    let outcome = input.outcome;
    let FlankOutcome { workpiece, setup, clock, .. } = outcome;
    let part = SheetPart { workpiece, setup, machine: clock.as_ref().map(MachineClock::machine) };
    let body = [
        part.text(),
        warnings(input),
        program_text(input),
        tools_text(outcome),
        layers_text(outcome, input.program.channels),
        strategies_text(outcome, input.program.channels),
        heading_of(&pictures, "Passes"),
    ];
    page(&part, &body.concat(), pictures)
}

/// The tools in cutting order, each with the feed rates of what it cuts.
fn tools(outcome: &FlankOutcome) -> Vec<(&Tool, String)> {
    let plan = &outcome.plan;
    let FlankFeedRates {
        step_mm_per_min,
        slot_mm_per_min,
        wall_mm_per_min,
        ramp_mm_per_min,
        approach_mm_per_min,
    } = plan.feeds;
    let rates = format!(
        "passes {step_mm_per_min:.0}, in full stock {slot_mm_per_min:.0}, along walls {wall_mm_per_min:.0}, \
         ramps {ramp_mm_per_min:.0}, down to the stock {approach_mm_per_min:.0} mm/min"
    );
    let opening = plan.opening.iter().map(|opening| {
        let tool = &opening.tool;
        (tool, format!("plunges above the shroud, {:.0} mm/min", tool.plunge_feed))
    });
    opening.chain([(&plan.tool, rates)]).collect()
}

fn warnings(input: &FlankSheetInput) -> String {
    let FlankSheetInput { outcome, program, remarks, .. } = input;
    let (plan, faults) = (&outcome.plan, &program.faults);
    let mut found: Vec<String> =
        faults.iter().take(MAX_FAULTS).map(|fault| format!("Line {}: {fault}", fault.line)).collect();
    if faults.len() > MAX_FAULTS {
        let more = faults.len() - MAX_FAULTS;
        found.push(format!("{more} more faults; `vanecut verify` lists them."));
    }
    match &program.verdict {
        None => found.push("The program could not be verified.".to_owned()),
        Some(verdict) => {
            for (share, what) in [
                (verdict.layer.uncut_share.into(), "of the accessible floor stays uncut"),
                (verdict.unmilled_wall_share, "of the walls is not milled"),
                (verdict.uncovered.share(), "of the floor keeps more than the scallop height"),
            ] {
                if share >= 5e-4 {
                    found.push(format!("{:.1} % {what}.", 100.0 * share));
                }
            }
        }
    }
    found.extend_from_slice(remarks);
    let left_out: f64 = plan.uncut.iter().map(|stretch| stretch.length).sum();
    if let Some(longest) = plan.uncut.iter().max_by(|a, b| a.length.total_cmp(&b.length)) {
        let UncutLength { layer, why, .. } = longest;
        found.push(format!(
            "{} of passes are left out; the longest stretch, on layer {}: {}.",
            left_out_text(left_out, |mm| format!("{mm:.1} mm")),
            layer + 1,
            why.message
        ));
    }
    if let Some(note) = overhang_note(&plan.tool, &plan.uncut, &outcome.workpiece.part) {
        found.push(format!("T{}: {note}.", plan.tool.number));
    }
    found.extend(tool_warnings(&outcome.setup, plan.tools()));
    let assumed = tools(outcome).into_iter().filter(|(tool, _)| tool.assembly.holder.is_empty());
    let mut assumed: Vec<u32> = assumed.map(|(tool, _)| tool.number).collect();
    assumed.sort_unstable();
    assumed.dedup();
    found.extend(assumed.into_iter().map(|number| {
        format!("The holder of tool {number} is not given: a cylinder of twice its diameter is assumed.")
    }));
    warning_list(found)
}

fn program_text(input: &FlankSheetInput) -> String {
    let FlankSheetInput { outcome, program, files, .. } = *input;
    let faults = match &program.verdict {
        Some(_) => faults_text(program.faults.len()),
        None => "not verified".to_owned(),
    };
    let walls = match &program.verdict {
        Some(verdict) => format!(
            "Walls: {:.4} mm overcut, {:.4} mm undercut. Least clearance to the hub {:.4} mm, to the blank in \
             rapids {:.3} mm; axis change up to {:.1}° in a move. ",
            verdict.max_overcut,
            verdict.max_undercut,
            verdict.min_hub_clearance,
            verdict.min_retract_clearance,
            verdict.max_axis_change_rad.to_degrees(),
        ),
        None => String::new(),
    };
    let time_s = if is_called_for_each_channel(files) { outcome.time_s() } else { program.time_s() };
    let order = match program.channels {
        1 => String::new(),
        _ => {
            format!(", {}; {}", outcome.setup.channels.words(), tool_loads_text(program.program.tool_loads()))
        }
    };
    format!(
        "<h2>Program</h2>\n<p>{}, for {}{order}; checked as written: {faults}.</p>\n<p>{walls}{:.0} mm of \
         passes, {:.0} mm of links, {:.0} mm in rapid; {}{:.1} min per channel{}.{}</p>\n",
        program_files(files, "flank plan"),
        channels_text(program.channels),
        program.times.cut_length,
        program.times.link_length,
        program.times.rapid_length,
        program_time_text(program),
        outcome.time_s() / 60.0,
        wheel_text(outcome, files),
        other_times_text(files, time_s),
    )
}

/// The time of a program of several channels, before that of one.
fn program_time_text(program: &FlankProgram) -> String {
    if program.channels == 1 {
        return String::new();
    }
    let changes_s = match program.machine_time {
        Some(_) => 0.0,
        None => TOOL_CHANGE_S * program.program.tool_loads() as f64,
    };
    format!("{:.1} min for the program, ", (program.time_s() + changes_s) / 60.0)
}

/// What tables of the plan say before their text where the program has more channels than they do.
fn of_one_channel(channels: usize) -> &'static str {
    if channels == 1 { "" } else { "<p>Of one channel.</p>\n" }
}

/// The time of all channels, after that of one; nothing where the machine cannot run them.
fn wheel_text(outcome: &FlankOutcome, files: &[ProgramFile]) -> String {
    let Some(time_s) = outcome.wheel_time_s else { return String::new() };
    let channels = outcome.workpiece.part.blade_count;
    let machine = outcome.clock.as_ref().map(MachineClock::machine);
    let mut wheel = WheelLine {
        channels,
        order: outcome.setup.channels,
        tool_changes: outcome.wheel_tool_loads,
        time_s,
        of: match (machine, outcome.machine_time) {
            (Some(machine), Some(_)) => WheelTime::OnMachine(machine),
            (Some(machine), None) => WheelTime::Refused(machine),
            (None, _) => WheelTime::Estimated,
        },
    };
    if is_called_for_each_channel(files) {
        let tool_loads = outcome.program().tool_loads();
        wheel = wheel.in_calls(&CalledProgram {
            tool_loads,
            // A single tool stays from call to call.
            tool_changes: if tool_loads == 1 { 1 } else { tool_loads * channels },
            estimate_s: outcome.time_estimate,
            machine_time: outcome.machine_time,
        });
    }
    format!("; {}", wheel.words())
}

fn tools_text(outcome: &FlankOutcome) -> String {
    let cards = tools(outcome).into_iter().map(|(tool, feeds)| tool_card(tool, &feeds));
    format!("<h2>Tools</h2>\n{}", cards.collect::<String>())
}

/// The strategies beside each other: how long their passes are.
fn strategies_text(outcome: &FlankOutcome, channels: usize) -> String {
    let layout = &outcome.plan.layout;
    let before = layout.totals[FlankStrategy::Isoparametric as usize].length;
    let row = |strategy: &FlankStrategy| {
        let figures = &layout.totals[*strategy as usize];
        let is_cut = if *strategy == layout.strategy { ", which is cut" } else { "" };
        format!(
            "<tr><td>{}{is_cut}</td><td>{}</td><td>{:.0}</td><td>{:.1}</td></tr>",
            strategy.name(),
            figures.passes,
            figures.length,
            100.0 * figures.length / before,
        )
    };
    let rows: String = FlankStrategy::ALL.iter().map(row).collect();
    format!(
        "<div class=\"keep\"><h2>Before and after</h2>\n{}<table><thead><tr><th>strategy</th>\
         <th>passes</th><th>length, mm</th><th>of isoparametric, %</th></tr></thead><tbody>{rows}</tbody></table></div>\n",
        of_one_channel(channels),
    )
}

/// Times of the program of one channel, s.
struct LayerTimes {
    /// Of the plunges above the shroud, with what leads from them to the passes.
    opening: f64,
    /// Of each layer, with the rapids that lead to its passes.
    layers: Vec<f64>,
}

impl LayerTimes {
    /// Those on the machine of the setup, or without one by feed rates and rapids; `None` where the machine
    /// cannot run the program.
    fn from_outcome(outcome: &FlankOutcome) -> Option<Self> {
        let plan = &outcome.plan;
        let program = outcome.program();
        let ends = match &outcome.clock {
            Some(clock) => clock.move_clock(&program)?,
            None => Travel::clock(&program),
        };
        let first = program.moves.len() - plan.moves.len();
        let mut now = first.checked_sub(1).map_or(0.0, |last| ends[last]);
        let mut times = Self { opening: now, layers: vec![0.0; plan.layout.layers.len()] };
        for (step, end) in plan.moves.iter().zip(&ends[first..]) {
            times.layers[step.layer] += end - now;
            now = *end;
        }
        Some(times)
    }
}

/// The layers from the top down, as they are cut, after what is cut above the shroud.
fn layers_text(outcome: &FlankOutcome, channels: usize) -> String {
    let plan = &outcome.plan;
    let times = LayerTimes::from_outcome(outcome);
    let minutes = |time: fn(&LayerTimes, usize) -> f64, layer: usize| match &times {
        Some(times) => format!("{:.1}", time(times, layer) / 60.0),
        None => "–".to_owned(),
    };
    let mut rows = String::new();
    if let Some(opening) = &plan.opening {
        let _ = write!(
            rows,
            "<tr><td>above the shroud</td><td>{} plunges</td><td></td><td></td><td></td><td>{}</td></tr>",
            opening.plunges.len(),
            minutes(|times, _| times.opening, 0),
        );
    }
    for (number, layer) in plan.layout.layers.iter().enumerate().rev() {
        let length: f64 = layer.figures[plan.layout.strategy as usize].length;
        let left_out = plan.uncut.iter().filter(|u| u.layer == number).map(|u| u.length).reduce(|a, b| a + b);
        let left_out =
            left_out.map_or_else(|| "0".to_owned(), |length| left_out_text(length, |mm| format!("{mm:.1}")));
        let _ = write!(
            rows,
            "<tr><td>{}</td><td>{}</td><td>{:.2}</td><td>{length:.0}</td><td>{left_out}</td><td>{}</td></tr>",
            number + 1,
            layer.pass_curves.len(),
            layer.stepover,
            minutes(|times, layer| times.layers[layer], number),
        );
    }
    let note = plan.layout.replacement_note().map(|note| format!("<p>{note}.</p>\n")).unwrap_or_default();
    format!(
        "<h2>Layers</h2>\n<p>Strategy {}; layers of {} mm from the hub up, the top one is cut first.</p>\n{note}{}\
         <table><thead><tr><th>layer</th><th>passes</th><th>stepover, mm</th><th>length, mm</th>\
         <th>left out, mm</th><th>min</th></tr></thead><tbody>{rows}</tbody></table>\n",
        plan.layout.strategy.name(),
        outcome.setup.flank.layer_depth,
        of_one_channel(channels),
    )
}
