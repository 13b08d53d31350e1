//! The setup sheet of a plan: what one takes to the machine, as HTML that prints to A4. Here is that of
//! plunges, with what all sheets share; [`flank`] has that of flank plans.

mod drawing;
pub mod flank;
mod wheel;

use std::fmt::Write;
use std::path::Path;

use self::wheel::{CalledProgram, WheelLine, WheelTime};
use super::html::escaped;
use super::words::{
    as_sentence, channels_text, clearances_text, counted, finishing_text, minutes, minutes_text,
    tool_loads_text,
};
use super::{PagePicture, ReportPage};
use crate::job::{PlanOutcome, PolicyResult, Summary};
use crate::machine::{MachineTool, PlacedPart, SectionTime};
use crate::part::{Impeller, Workpiece};
use crate::plunge::channels::count_tool_loads;
use crate::plunge::{DropReason, UnappliedEdit};
use crate::setup::cutting_data::cutting_speed_at;
use crate::setup::{ChannelOrder, PlungePose, SectionKind, Setup, Tool};
use crate::verify::PlungeReport;

/// Faults that are listed one by one.
const MAX_FAULTS: usize = 5;

/// Rows of a table stay whole on a page, and its head is repeated.
const STYLE: &str = "@page{size:A4;margin:15mm}body{font-family:sans-serif;font-size:11pt;max-width:180mm;\
    margin:0 auto}h1{font-size:16pt;margin:0}h2{font-size:13pt;margin:14pt 0 4pt;break-after:avoid}\
    table{border-collapse:collapse;width:100%}th,td{border:1px solid #90a4ae;padding:2pt 5pt;\
    text-align:right}th:first-child,td:first-child{text-align:left}thead{display:table-header-group}\
    tr,figure,.tool,.keep{break-inside:avoid}figure{display:inline-block;margin:3pt;width:86mm}figure img{width:100%}\
    .tool{display:inline-block;vertical-align:top;margin:0 10pt 6pt 0;font-size:9pt}\
    .warning{border-left:4pt solid #d55e00;padding-left:20pt}";

/// Units of the sheet, whatever the window shows: it goes with the program.
const UNITS: &str = "Lengths are in mm and feed rates in mm/min, as in the program.";

/// What the sheet shows.
pub struct SheetInput<'a> {
    /// The plans.
    pub outcome: &'a PlanOutcome,
    /// The one of them that the sheet is for.
    pub shown: &'a PolicyResult,
    /// The judgement of its program.
    pub report: &'a PlungeReport,
    /// Channels of the program.
    pub channels: usize,
    /// The files of the program; none where it is not written with the sheet.
    pub files: &'a [ProgramFile],
    /// What else must be known of the setup before the program runs.
    pub remarks: &'a [String],
}

/// A file with a plan or its program.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramFile {
    /// Its name.
    pub name: String,
    /// What it is: the kind of file, and for which machine and control.
    pub about: String,
    /// Time of one run on its machine, s; `None` where the file is not for one.
    pub time_s: Option<f64>,
    /// Whether another program calls it, once for each channel.
    pub is_called_for_each_channel: bool,
}

impl ProgramFile {
    /// An APT file of that name.
    pub fn apt(name: impl Into<String>) -> Self {
        Self::of_kind(name, "APT")
    }

    /// The plan itself, in a file of that name.
    pub fn plan(name: impl Into<String>) -> Self {
        Self::of_kind(name, "plan")
    }

    fn of_kind(name: impl Into<String>, about: &str) -> Self {
        Self { name: name.into(), about: about.to_owned(), time_s: None, is_called_for_each_channel: false }
    }
}

/// Whether one of the files is called by another program, once for each channel.
fn is_called_for_each_channel(files: &[ProgramFile]) -> bool {
    files.iter().any(|file| file.is_called_for_each_channel)
}

/// The files in words; `plan` where there are none.
fn program_files(files: &[ProgramFile], plan: &str) -> String {
    let of = |file: &ProgramFile| {
        let time = file.time_s.map_or(String::new(), |time_s| format!(", {:.1} min", time_s / 60.0));
        format!("<code>{}</code> ({}{time})", escaped(&file.name), escaped(&file.about))
    };
    let files: Vec<String> = files.iter().map(of).collect();
    if files.is_empty() { escaped(plan) } else { files.join(", ") }
}

/// What to say below the times of a plan where the program of a file takes another time than `time_s`, by
/// more than a hundredth: it is for another machine than that of the setup, or in another output, such as
/// tilted planes.
fn other_times_text(files: &[ProgramFile], time_s: f64) -> &'static str {
    let differs = |of_file: f64| (of_file - time_s).abs() > 0.01 * time_s;
    match files.iter().filter_map(|file| file.time_s).any(differs) {
        true => " NC programs take the time that stands beside their names.",
        false => "",
    }
}

/// The part of a sheet.
struct SheetPart<'a> {
    workpiece: &'a Workpiece,
    setup: &'a Setup,
    /// The machine of the setup, if it is known.
    machine: Option<&'a MachineTool>,
}

/// The page of a sheet with this `body`, followed by the pictures.
fn page(part: &SheetPart, body: &str, pictures: Vec<PagePicture>) -> ReportPage {
    let figure = |picture: &PagePicture| {
        let (file, caption) = (escaped(&picture.name), escaped(&picture.caption));
        format!("<figure><img src=\"{file}\" alt=\"{caption}\"><figcaption>{caption}</figcaption></figure>\n")
    };
    let name = escaped(&part.workpiece.part.name);
    let page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <title>{name}: setup sheet</title>\n\
         <style>{STYLE}</style></head><body>\n<h1>{name}: setup sheet</h1>\n{body}{}</body></html>\n",
        pictures.iter().map(figure).collect::<String>(),
    );
    ReportPage { page, pictures }
}

/// The sheet with `pictures` of its plan.
pub fn setup_sheet(input: &SheetInput, pictures: Vec<PagePicture>) -> ReportPage {
    let PlanOutcome { workpiece, setup, clock, .. } = input.outcome;
    let part = SheetPart { workpiece, setup, machine: clock.machine() };
    let body = [
        part.text(),
        warnings_text(input),
        program_text(input),
        tools_text(input),
        sections_text(input),
        policies_text(input.outcome),
        heading_of(&pictures, "Stock before and after"),
    ];
    page(&part, &body.concat(), pictures)
}

/// Number of faults in words.
fn faults_text(count: usize) -> String {
    match count {
        0 => "no fault".to_owned(),
        _ => counted(count, "fault", "faults"),
    }
}

/// The heading over `pictures`, if there are any: a program without a renderer draws none.
fn heading_of(pictures: &[PagePicture], title: &str) -> String {
    if pictures.is_empty() { String::new() } else { format!("<h2>{title}</h2>\n") }
}

impl SheetPart<'_> {
    /// Part, blank and zero point.
    fn text(&self) -> String {
        let Workpiece { part, blank, .. } = self.workpiece;
        let setup = self.setup;
        let stock = &setup.allowances;
        let machine = match &setup.machine.file {
            Some(file) => {
                let tilt = setup.machine.max_axis_tilt_rad.to_degrees();
                let name = Path::new(file).file_name().map_or(file.into(), |name| name.to_string_lossy());
                format!("{}, tool axis up to {tilt:.0}°", escaped(&name))
            }
            None => "not named in the setup".to_owned(),
        };
        let material = stock.material.as_deref().map_or("not named in the setup".to_owned(), escaped);
        format!(
            "<p>{UNITS}</p>\n<p>D {:.2} mm, {} blades{}. Material: {material}. Machine: {machine}.</p>\n\
             <div class=\"keep\">{}<p>Zero of the program: the axis of rotation at z = 0 of the part; \
             Z along the axis. {} Hub blue, shroud dashed, blank grey. Stock that stays: hub {} mm, \
             blades {} mm.</p></div>\n",
            2.0 * part.rim_radius(),
            part.blade_count,
            if part.splitters.is_empty() { "" } else { " and splitters" },
            drawing::part_svg(part, blank),
            placement_text(part, self.machine),
            stock.hub_allowance,
            stock.blade_allowance,
        )
    }
}

/// How the part lies in NC programs, whose machine may want it turned over, in a sentence.
fn placement_text(part: &Impeller, machine: Option<&MachineTool>) -> String {
    let Some(machine) = machine else {
        return "APT programs take the part as it is drawn; the head of an NC program says how it is turned for \
                its machine."
            .to_owned();
    };
    let name = escaped(&machine.name);
    let lies = PlacedPart::from_placement(&machine.part, part).comments();
    let offset = escaped(&machine.part.offset_name);
    let inlet = if machine.part.inlet_up { "up" } else { "down" };
    match lies.is_empty() {
        true => {
            format!(
                "APT programs take the part as it is drawn, and NC programs for {name}, too: inlet {inlet}, \
                 work offset {offset}."
            )
        }
        false => format!(
            "APT programs take the part as it is drawn. <b>In NC programs for {name}: {}, inlet {inlet}, work \
             offset {offset}.</b>",
            lies.join(", ")
        ),
    }
}

/// What must be known before the program runs.
fn warnings_text(input: &SheetInput) -> String {
    let plan = &input.shown.plan;
    let mut warnings = Vec::new();
    if plan.is_unfinished() {
        warnings.push("The plan is UNFINISHED: planning was stopped.".to_owned());
    }
    let faults = &input.report.verdict.faults;
    for fault in faults.iter().take(MAX_FAULTS) {
        warnings.push(format!("Line {}: {fault}", fault.line));
    }
    if faults.len() > MAX_FAULTS {
        warnings.push(format!("{} more faults; `vanecut verify` lists them.", faults.len() - MAX_FAULTS));
    }
    for why in DropReason::ALL {
        let count = plan.dropped.iter().filter(|dropped| dropped.why == why).count();
        if count > 0 {
            let left_out = counted(count, "position is", "positions are");
            warnings.push(format!("{left_out} left out {}.", why.words()));
        }
    }
    warnings.extend(unapplied_edits(input));
    warnings.extend_from_slice(input.remarks);
    let uncut = 100.0 * input.report.summary.uncut_share;
    if uncut >= 0.05 {
        warnings.push(format!("{uncut:.1} % of the reachable floor stays uncut."));
    }
    warnings.extend(tool_warnings(&input.outcome.setup, plan.tools()));
    let unknown = plan.tools().filter(|tool| tool.assembly.holder.is_empty());
    let unchecked = |tool: &Tool| match tool.assembly.is_empty() {
        true => format!("Shank and holder of tool {} are unknown and were not checked.", tool.number),
        false => format!("The holder of tool {} is unknown and was not checked.", tool.number),
    };
    let mut unchecked: Vec<(u32, String)> = unknown.map(|tool| (tool.number, unchecked(tool))).collect();
    unchecked.sort();
    unchecked.dedup();
    warnings.extend(unchecked.into_iter().map(|(_, text)| text));
    warning_list(warnings)
}

/// What must be known of the `tools` of a program before it runs.
fn tool_warnings<'t>(setup: &Setup, tools: impl Iterator<Item = &'t Tool>) -> Vec<String> {
    let remarks = setup.allowances.tool_remarks(tools).into_iter();
    remarks.map(|remark| format!("{}.", as_sentence(remark))).collect()
}

/// Edits by hand that the program does not contain, each with its reason.
fn unapplied_edits(input: &SheetInput) -> Vec<String> {
    let SheetInput { outcome, shown, .. } = input;
    // Edits belong to the plan that was asked for.
    if shown.plan.policy != outcome.after.plan.policy {
        return Vec::new();
    }
    let unapplied = &outcome.edits.unapplied;
    let line = |of: &UnappliedEdit| {
        let edit = outcome.setup.plunge.edits.get(of.index)?;
        let what = if edit.whole_row { "row of the plunge" } else { "plunge" };
        let PlungePose { tip, .. } = edit.plunge;
        let (place, reason) =
            (format!("({:.3}, {:.3}, {:.3})", tip.x, tip.y, tip.z), of.reason(|mm| format!("{mm:.3} mm")));
        Some(format!("Not applied: {} of the {what} at {place}: {reason}.", edit.change.name()))
    };
    let mut lines: Vec<String> = unapplied.iter().take(MAX_FAULTS).filter_map(line).collect();
    match unapplied.len().saturating_sub(MAX_FAULTS) {
        0 => {}
        more => {
            let edits = counted(more, "more edit by hand is", "more edits by hand are");
            lines.push(format!("{edits} not applied."));
        }
    }
    lines
}

/// The list of `warnings`, with what holds for every program.
fn warning_list(mut warnings: Vec<String>) -> String {
    warnings.push(
        "No program of this kind has been proven on your control: run it block by block and in air first."
            .to_owned(),
    );
    let items: String = warnings.iter().map(|text| format!("<li>{}</li>", escaped(text))).collect();
    format!("<h2>Before it runs</h2>\n<ul class=\"warning\">{items}</ul>\n")
}

/// The files and what `verify` says of the program.
fn program_text(input: &SheetInput) -> String {
    let summary = &input.report.summary;
    let faults = faults_text(input.report.verdict.faults.len());
    let order = match input.channels {
        1 => String::new(),
        _ => format!(", {}; {}", input.outcome.setup.channels.words(), tool_loads_text(summary.tool_loads)),
    };
    let files = program_files(input.files, input.shown.plan.policy.name());
    format!(
        "<h2>Program</h2>\n<p>{files}, for {}{order}; checked as written: {faults}.</p>\n<p>{}</p>\n",
        channels_text(input.channels),
        escaped(clearances_text(summary, input.channels).trim_end()).replace('\n', "<br>"),
    )
}

/// The tools that cut, each with its drawing.
fn tools_text(input: &SheetInput) -> String {
    let mut text = "<h2>Tools</h2>\n".to_owned();
    let mut seen = Vec::new();
    let setup = &input.outcome.setup;
    let plan = &input.shown.plan;
    for used in plan.tools() {
        let Some(tool) = setup.tools.iter().find(|tool| tool.number == used.number) else { continue };
        if seen.contains(&tool.number) {
            continue;
        }
        seen.push(tool.number);
        let per_tooth = |teeth| tool.plunge_feed / (f64::from(teeth) * tool.spindle);
        let tooth =
            tool.assembly.teeth.map(|teeth| format!(", {:.3} mm per tooth of {teeth}", per_tooth(teeth)));
        text += &tool_card(tool, &format!("plunge {} mm/min{}", tool.plunge_feed, tooth.unwrap_or_default()));
    }
    text
}

/// A tool with its drawing and the feed rates of what it cuts.
fn tool_card(tool: &Tool, feed_rates: &str) -> String {
    let rest = &tool.assembly;
    let length_offset = tool.length_offset_number();
    let diameter_offset = rest.diameter_offset.map_or(String::new(), |number| format!(", D{number}"));
    format!(
        "<div class=\"tool\">{}<br><b>T{}</b> {}<br>⌀{} R{} mm, insert width {} mm<br>overhang {} mm<br>\
         {} rev/min, {:.0} m/min, {feed_rates}<br>offset H{length_offset}{diameter_offset}</div>\n",
        drawing::tool_svg(tool),
        tool.number,
        rest.name.as_deref().map_or(String::new(), escaped),
        tool.diameter,
        tool.corner_radius,
        tool.insert_width,
        tool.overhang,
        tool.spindle,
        cutting_speed_at(tool.spindle, tool.diameter),
    )
}

/// The sections in cutting order, with times of one channel and of the wheel.
fn sections_text(input: &SheetInput) -> String {
    let (outcome, shown) = (input.outcome, input.shown);
    let on_machine = outcome.clock.section_times(&shown.plan);
    let mut rows = String::new();
    for (index, section) in shown.plan.sections.iter().enumerate().filter(|(_, section)| section.is_cut()) {
        let summary = Summary::of_section(&shown.plan, &outcome.grid, &shown.field, index);
        let kind = match section.kind {
            SectionKind::Rows => section.feed.words(),
            SectionKind::Rest => "rest milling",
            SectionKind::Opening => "above the shroud",
        };
        let _ = write!(
            rows,
            "<tr><td>{}</td><td>T{}</td><td>{:.2} to {:.2}</td><td>{kind}</td><td>{}</td>\
             <td>{:.2} / {:.2}</td><td>{}</td></tr>",
            index + 1,
            section.tool.number,
            section.from,
            section.to,
            summary.positions,
            summary.residual_mean,
            summary.residual_p95,
            match &on_machine {
                Some(times) => format!("{:.1}", section_minutes(times, index)),
                None if shown.summary.is_refused => "–".to_owned(),
                None => minutes_text(&summary),
            },
        );
    }
    let blades = outcome.workpiece.part.blade_count;
    let order = outcome.setup.channels;
    if shown.summary.is_refused {
        return sections_table(&rows, "The machine of the setup cannot run this plan.");
    }
    let tool_loads = |order: ChannelOrder, channels: usize| count_tool_loads(&shown.plan, order, channels);
    let machine = outcome.clock.machine().filter(|_| shown.summary.machine_time.is_some());
    let mut wheel = WheelLine {
        channels: blades,
        order,
        tool_changes: tool_loads(order.order, blades),
        time_s: shown.summary.time_of_channels_s(blades, blades),
        of: machine.map_or(WheelTime::Estimated, WheelTime::OnMachine),
    };
    if is_called_for_each_channel(input.files) {
        wheel = wheel.in_calls(&CalledProgram {
            tool_loads: tool_loads(ChannelOrder::ChannelByChannel, 1),
            tool_changes: tool_loads(ChannelOrder::ChannelByChannel, blades),
            estimate_s: shown.summary.time_estimate,
            machine_time: shown.summary.machine_time,
        });
    }
    let mut below = format!("One channel {:.1} min; {}.", minutes(&shown.summary), wheel.words());
    if let Some(finishing) = finishing_text(outcome, shown) {
        let _ = write!(below, " Afterwards {finishing}.");
    }
    let channels = if is_called_for_each_channel(input.files) { 1 } else { input.channels };
    below += other_times_text(input.files, shown.summary.time_of_channels_s(channels, blades));
    sections_table(&rows, &below)
}

/// The table of sections with a line below.
fn sections_table(rows: &str, below: &str) -> String {
    format!(
        "<h2>Sections</h2>\n<table><thead><tr><th>section</th><th>tool</th><th>s</th><th>cut</th>\
         <th>plunges</th><th>stock mean / 95 %, mm</th><th>min</th></tr></thead>\
         <tbody>{rows}</tbody></table>\n\
         <p>{below}</p>\n",
    )
}

/// Time of section `index` of a plan on its machine, min.
fn section_minutes(times: &[SectionTime], index: usize) -> f64 {
    let own = times.iter().filter(|time| time.section == Some(index + 1));
    own.map(SectionTime::total_s).sum::<f64>() / 60.0
}

/// The policies beside each other.
fn policies_text(outcome: &PlanOutcome) -> String {
    let row = |result: &PolicyResult| {
        let s = &result.summary;
        format!(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.2}</td><td>{:.2} / {:.2}</td><td>{:.1}</td>\
             <td>{}</td></tr>",
            result.plan.policy.name(),
            s.positions,
            s.interfering,
            s.max_contact_depth,
            s.residual_mean,
            s.residual_p95,
            100.0 * s.uncut_share,
            minutes_text(s),
        )
    };
    let rows: String = outcome.policies().into_iter().map(row).collect();
    format!(
        "<div class=\"keep\"><h2>Before and after</h2>\n<table><thead><tr><th>plan</th><th>plunges</th>\
         <th>core contact</th><th>deepest contact, mm</th><th>stock mean / 95 %, mm</th><th>uncut, %</th><th>min</th></tr></thead>\
         <tbody>{rows}</tbody></table></div>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::machine_file::read_machine;
    use crate::io::part_file::read_part;
    use crate::io::tool_library::plunge_cutters;

    #[test]
    fn a_tool_that_turns_too_fast_and_a_shared_offset_stand_before_the_program() {
        let mut tools: Vec<Tool> = plunge_cutters().iter().rev().take(2).cloned().collect();
        for tool in &mut tools {
            tool.assembly.length_offset = Some(5);
        }
        let mut setup = Setup::default();
        setup.allowances.material = Some("nickel".to_owned());
        let warnings = tool_warnings(&setup, tools.iter());
        let [fast, offset] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(fast.starts_with("Much faster than the 30 m/min for nickel: T"), "{fast}");
        assert!(offset.ends_with(" have the same length offset, H5."), "{offset}");
    }

    #[test]
    fn a_part_that_an_nc_program_turns_over_is_said_to_be() {
        let part = read_part("assets/parts/pump6.toml".as_ref()).expect("readable");
        let part = Impeller::build(&part).expect("an impeller");
        let mut machine = read_machine("bc-trunnion".as_ref()).expect("known");
        let text = placement_text(&part, Some(&machine));
        assert!(text.contains("part turned over by half a turn about its X, inlet up"), "{text}");
        machine.part.inlet_up = false;
        let text = placement_text(&part, Some(&machine));
        assert!(text.ends_with("too: inlet down, work offset G54."), "{text}");
        assert!(placement_text(&part, None).contains("the head of an NC program says"));
    }

    #[test]
    fn a_heading_stands_over_pictures_only() {
        assert_eq!(heading_of(&[], "Passes"), "");
        let picture =
            PagePicture { name: "before.png".to_owned(), bytes: Vec::new(), caption: "before".to_owned() };
        assert_eq!(heading_of(&[picture], "Passes"), "<h2>Passes</h2>\n");
    }
}
