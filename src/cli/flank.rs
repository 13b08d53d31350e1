//! `vanecut flank`.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::args::FlankArgs;
use super::channels::{channel_keys, wheel_text};
use super::machine_figures::MachineFigures;
use super::output::{fault_list, head, number, tools_text};
use super::output_folder::{check_directory, create_directory, write_report};
use super::stdout::print_stdout;
use super::verify::flank::{cut_words, text as verdict_text, walls_text};
use super::watch::run_with_progress;
use super::{Failure, open};
use crate::error::ErrorCode;
use crate::flank::choice::overhang_note;
use crate::flank::curves::WIDEST_GAP;
use crate::flank::{FlankPlan, UncutLength};
use crate::io::apt::write_apt;
use crate::io::flank_file::write_flank;
use crate::io::setup_file::parse_flank_strategy;
use crate::io::write::write_all_atomically;
use crate::job::JobError;
use crate::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use crate::job::flank_channels::FlankProgram;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Impeller;
#[cfg(feature = "gpu")]
use crate::report::pictures::flank_pictures;
use crate::report::sheet::ProgramFile;
use crate::report::sheet::flank::{FlankSheetInput, flank_sheet};
use crate::report::words;
use crate::setup::{AssemblyPart, FlankStrategy};
use crate::verify::{FlankVerdict, count_by_kind};

/// Plans, writes the files and prints the figures.
///
/// # Errors
/// [`Failure::input`] when an input is invalid; [`Failure::work`] when planning is cancelled, nothing can be
/// cut, or the program has faults.
pub fn run(args: &FlankArgs) -> Result<(), Failure> {
    let (description, part) = open::part(&args.part, &args.mesh)?;
    let mut setup = open::setup(args.setup.as_deref(), &args.part, &part)?;
    if let Some(name) = &args.scheme {
        setup.setup.flank.strategy =
            parse_flank_strategy(name).map_err(|error| Failure::from(error).at("--scheme"))?;
    }
    args.several.order(&mut setup.setup.channels)?;
    let channels = args.several.count(&part)?;
    check_directory(&args.output)?;
    let request = FlankRequest { part: Arc::new(part), setup: setup.setup.clone() };
    let (outcome, program) = run_with_progress("planning", |monitor| {
        FlankJob::default().run_to_program(&request, channels, monitor)
    })
    .map_err(|error| match error {
        JobError::Cancelled => Cancelled.into(),
        JobError::Setup(fault) => setup.failure(fault),
    })?;
    let plan = &outcome.plan;
    if plan.moves.is_empty() {
        let most = plan.uncut.iter().max_by(|a, b| a.length.total_cmp(&b.length));
        let why = most.map_or("the cutter fits nowhere", |left| left.why.message);
        let what = format!("nothing could be cut: {why}");
        let help = help_for_nothing(&outcome);
        return Err(Failure::work(ErrorCode::NothingMoves, what, help).at_path(&args.part));
    }
    create_directory(&args.output)?;
    let written = write_apt(&program.program);
    let (json, apt) = (args.output.join("flank.json"), args.output.join("flank.apt"));
    let setup = setup.as_stored(&outcome.setup);
    let stored = write_flank(&description, &setup, &program.plan, &outcome.shown_walls(), channels);
    write_all_atomically(&[(json.clone(), stored.as_bytes()), (apt.clone(), written.as_bytes())])?;
    if args.report {
        write_sheet(&args.output, &outcome, &program)?;
    }
    let name = apt.display().to_string();
    let faults = &program.faults;
    let on_machine = outcome.clock.as_ref().map(|clock| MachineFigures::of_plan(clock, &program.program));
    if args.json {
        let mut map = object(&outcome, &program);
        map.extend(MachineFigures::keys_of(on_machine.as_ref(), &outcome.setup));
        map.extend(wheel_keys(&outcome, &program)?);
        map.insert("faults".into(), fault_list(faults));
        print_stdout(&format!("{}\n", Value::Object(map)))?;
    } else {
        let mut text = text(&outcome);
        text += &channels_text(&outcome, &program);
        text += &tools_text(&outcome.setup, outcome.plan.tools());
        text += &MachineFigures::text_of(on_machine.as_ref(), &outcome.setup);
        let (part, order) = (&outcome.workpiece.part, outcome.setup.channels);
        text += &wheel_text(part, order, outcome.wheel_time_s, outcome.machine_time.is_some());
        text += &format!("wrote {} and {}\n", json.display(), apt.display());
        print_stdout(&text)?;
    }
    let Some(first) = faults.first() else { return Ok(()) };
    let help = format!("in all {}: use a thinner cutter, or one with more overhang", count_by_kind(faults));
    Err(Failure::work(ErrorCode::ProgramFaults, first.to_string(), help).at_line(&name, first.line))
}

/// What to do where no pass could be cut: a longer overhang where one would do.
fn help_for_nothing(outcome: &FlankOutcome) -> String {
    let plan = &outcome.plan;
    let by_holder = plan.uncut.iter().any(|left| left.why.is_by(AssemblyPart::Holder));
    match overhang_note(&plan.tool, &plan.uncut, &outcome.workpiece.part) {
        Some(note) => note,
        None if by_holder && !plan.tool.assembly.is_empty() => {
            "no longer overhang would do: give a thinner holder, or a smaller [clearance]".to_owned()
        }
        None => "give a thinner or a longer cutter, or smaller allowances".to_owned(),
    }
}

/// Keys of the program of all channels, and of several ones.
fn wheel_keys(outcome: &FlankOutcome, program: &FlankProgram) -> Result<Map<String, Value>, Failure> {
    let mut map = channel_keys(outcome.setup.channels);
    map.insert("wheel_time".into(), json!(outcome.wheel_time_s.map(number)));
    if program.channels > 1 {
        let one = outcome.program_for_channels(1, &Monitor::default())?;
        map.insert("one_channel".into(), Value::Object(object(outcome, &one)));
    }
    Ok(map)
}

/// What the program of several channels is, as `vanecut verify` says it; nothing of one channel.
fn channels_text(outcome: &FlankOutcome, program: &FlankProgram) -> String {
    if program.channels <= 1 {
        return String::new();
    }
    let (count, order) = (words::channels_text(program.channels), outcome.setup.channels.words());
    let mut text = format!("as written, {count}, {order}:\n");
    if let Some(verdict) = &program.verdict {
        text += &verdict_text(verdict);
    }
    text += &format!("{}\n", words::tool_loads_text(program.program.tool_loads()));
    text
}

/// Writes `report.html`, with its pictures where the program draws any, into `folder`.
///
/// # Errors
/// [`Failure::work`] when drawing fails, [`Failure::input`] when a file cannot be written.
fn write_sheet(folder: &Path, outcome: &FlankOutcome, program: &FlankProgram) -> Result<(), Failure> {
    #[cfg(feature = "gpu")]
    let pictures = flank_pictures(outcome, "").map_err(Failure::of_work)?;
    // The sheet has its drawings all the same.
    #[cfg(not(feature = "gpu"))]
    let pictures = Vec::new();
    let files = [ProgramFile::plan("flank.json"), ProgramFile::apt("flank.apt")];
    let input = FlankSheetInput { outcome, program, files: &files, remarks: &[] };
    let document = flank_sheet(&input, pictures);
    write_report(folder, &document)
}

/// Number of regions of a channel.
fn region_count(part: &Impeller) -> usize {
    1 + 2 * part.splitters.len()
}

/// Stepover on the lowest layer, mm.
fn stepover(plan: &FlankPlan) -> f64 {
    plan.layout.layers.first().map_or(f64::NAN, |layer| layer.stepover)
}

/// Length of passes that were left out, mm.
fn left_out_length(plan: &FlankPlan) -> f64 {
    plan.uncut.iter().map(|stretch| stretch.length).sum()
}

/// The figures of a program of the plan; those of its layout, of what is left out and of its axes are those
/// of a channel.
fn object(outcome: &FlankOutcome, program: &FlankProgram) -> Map<String, Value> {
    let (part, plan) = (&outcome.workpiece.part, &outcome.plan);
    let curves = &plan.layout;
    let scheme = curves.strategy;
    let of = |scheme: FlankStrategy| &curves.totals[scheme as usize];
    let mut map = head(part, Some(program.channels));
    let mut put = |key: &str, value: Value| {
        map.insert(key.to_owned(), value);
    };
    put("scheme", json!(scheme));
    put("tool", json!(plan.tool));
    put("reason", json!(plan.reason));
    put("layers", json!(curves.layers.len()));
    put("regions", json!(region_count(part)));
    put("curves", json!(of(scheme).passes));
    put("interval", number(stepover(plan)));
    put("length", number(of(scheme).length));
    for other in FlankStrategy::ALL {
        put(&format!("length_{}", other.name()), number(of(other).length));
    }
    put("floor_length", number(curves.floor_length));
    put("seam_length", number(curves.seam_length));
    put("area", number(curves.area));
    put("largest_gap_over_interval", number(of(scheme).coverage.largest_gap));
    put("wide_area_share", number(curves.wide_share(scheme)));
    let judged = |figure: fn(&FlankVerdict) -> f64| number(program.verdict.as_ref().map_or(f64::NAN, figure));
    let overcut = program.verdict.as_ref().map_or_else(|| plan.max_overcut(), |v| v.max_overcut);
    put("max_overcut", number(overcut));
    put("max_undercut", judged(|v| v.max_undercut));
    put("unmilled_wall_share", judged(|v| v.unmilled_wall_share));
    put("planned_undercut", number(plan.max_undercut()));
    put("forced_deviation", number(plan.forced_deviation()));
    put("uncovered_share", judged(|v| v.uncovered.share()));
    put("positions", json!(program.positions()));
    put("tool_loads", json!(program.program.tool_loads()));
    let axes = plan.axes.iter().map(|a| {
        json!({
            "layer": a.layer + 1,
            "region": a.region,
            "axis": [a.axis.x, a.axis.y, a.axis.z],
            "clearance": number(a.clearance),
        })
    });
    put("fixed_axes", Value::Array(axes.collect()));
    put("left_out_length", number(left_out_length(plan)));
    put(
        "left_out",
        Value::Array(
            plan.uncut
                .iter()
                .map(|l| {
                    json!({
                        "layer": l.layer + 1, "region": l.region, "length": l.length, "why": l.why.message,
                        "overhang": l.overhang,
                    })
                })
                .collect(),
        ),
    );
    put("feed", number(plan.feeds.step_mm_per_min));
    put("slot_feed", number(plan.feeds.slot_mm_per_min));
    put("wall_feed", number(plan.feeds.wall_mm_per_min));
    put("ramp_feed", number(plan.feeds.ramp_mm_per_min));
    put("approach_feed", number(plan.feeds.approach_mm_per_min));
    put("cut_length", judged(|v| v.cut_length));
    put("pass_length", number(program.times.cut_length));
    put("link_length", number(program.times.link_length));
    put("rapid_length", judged(|v| v.rapid_length));
    put("min_hub_clearance", judged(|v| v.min_hub_clearance));
    put("min_blade_clearance", judged(|v| v.min_blade_clearance));
    put("min_retract_clearance", judged(|v| v.min_retract_clearance));
    put("max_axis_change", judged(|v| v.max_axis_change_rad.to_degrees()));
    put("residual_mean", judged(|v| v.layer.mean.into()));
    put("residual_p95", judged(|v| v.layer.p95.into()));
    put("residual_max", judged(|v| v.layer.max.into()));
    put("uncut_share", judged(|v| v.layer.uncut_share.into()));
    put("unreachable_share", judged(|v| v.layer.unreachable_share.into()));
    put("cut_time", number(program.times.cut_time));
    put("link_time", number(program.times.link_time));
    put("rapid_time", number(program.times.rapid_time));
    put("time_estimate", judged(|v| v.time_estimate));
    put("feed_time", judged(|v| v.feed_time));
    // Gaps of the isoparametric strategy are measured only if it is the chosen one.
    let measured = |s: FlankStrategy| s != FlankStrategy::Isoparametric || s == scheme;
    let by_scheme: Map<String, Value> = FlankStrategy::ALL
        .iter()
        .map(|&s| {
            let figures = of(s);
            let gap = if measured(s) { figures.coverage.largest_gap } else { f64::NAN };
            let wide = if measured(s) { curves.wide_share(s) } else { f64::NAN };
            (
                s.name().to_owned(),
                json!({
                    "curves": figures.passes,
                    "length": figures.length,
                    "largest_gap_over_interval": number(gap),
                    "wide_area_share": number(wide),
                }),
            )
        })
        .collect();
    put("by_scheme", Value::Object(by_scheme));
    put(
        "by_layer",
        Value::Array(
            curves
                .layers
                .iter()
                .enumerate()
                .map(|(number, layer)| {
                    json!({
                        "layer": number + 1,
                        "height": layer.layer.height,
                        "interval": layer.stepover,
                        "curves": layer.pass_curves.len(),
                        "length": layer.figures[scheme as usize].length,
                    })
                })
                .collect(),
        ),
    );
    put("elapsed", number(outcome.elapsed));
    map
}

/// A gap in stepovers; gaps are measured only up to the widest that counts.
fn gap_text(gap: f64) -> String {
    if gap < WIDEST_GAP - 1e-9 { format!("{gap:.3}") } else { format!("≥{WIDEST_GAP:.3}") }
}

fn text(outcome: &FlankOutcome) -> String {
    let (part, plan) = (&outcome.workpiece.part, &outcome.plan);
    let curves = &plan.layout;
    let mut text = format!(
        "{}: {} layers, {}, {} passes; cutter D {} R {}, stepover {:.3} mm at the hub\n",
        part.name,
        curves.layers.len(),
        words::counted(region_count(part), "region", "regions"),
        curves.totals[curves.strategy as usize].passes,
        plan.tool.diameter,
        plan.tool.corner_radius,
        stepover(plan),
    );
    if let Some(reason) = &plan.reason {
        text += &format!("cutter: {reason}\n");
    }
    text += "strategy       passes     length mm   of isoparametric   widest gap   wide area %\n";
    for scheme in FlankStrategy::ALL {
        let figures = &curves.totals[scheme as usize];
        let measured = scheme != FlankStrategy::Isoparametric || scheme == curves.strategy;
        let (gap, wide) = if measured {
            (gap_text(figures.coverage.largest_gap), format!("{:.3}", 100.0 * curves.wide_share(scheme)))
        } else {
            ("-".to_owned(), "-".to_owned())
        };
        text += &format!(
            "{:13}{:8}{:14.1}{:18.3}{gap:>13}{wide:>14}{}\n",
            scheme.name(),
            figures.passes,
            figures.length,
            figures.length / curves.totals[0].length,
            if scheme == curves.strategy { "  < written" } else { "" },
        );
    }
    if let Some(note) = curves.replacement_note() {
        text += &format!("{note}\n");
    }
    text += &format!(
        "floor {:.1} mm, seams {:.1} mm: {} is {:.3} times floor plus half the seams\n",
        curves.floor_length,
        curves.seam_length,
        curves.strategy.name(),
        curves.totals[curves.strategy as usize].length / (curves.floor_length + 0.5 * curves.seam_length),
    );
    text += &format!(
        "twist alone forces ±{:.4} mm on a straight cutting edge, in the strip of one layer\n",
        plan.forced_deviation(),
    );
    if let Some(verdict) = &outcome.verdict {
        // The planner measures depths more strictly than `verify`.
        text += &format!("{}\n", cut_words(verdict));
        text += &walls_text(verdict);
        text += &format!(
            "{:.2} % of the floor keeps more stock than the scallop height: {:.2} % fillet beside blades, \
             {:.2} % inaccessible, {:.2} % gaps of the program\n",
            100.0 * verdict.uncovered.share(),
            100.0 * verdict.uncovered.fillet,
            100.0 * verdict.uncovered.no_axis,
            100.0 * verdict.uncovered.gap,
        );
    }
    text += &format!(
        "{} positions, {} fixed axes; {:.0} mm cut, {:.0} mm links and approaches, {:.0} mm rapid: \
         {:.1} + {:.1} + {:.1} min\n",
        plan.positions(),
        plan.axes.len(),
        plan.times.cut_length,
        plan.times.link_length,
        plan.times.rapid_length,
        plan.times.cut_time / 60.0,
        plan.times.link_time / 60.0,
        plan.times.rapid_time / 60.0,
    );
    let feeds = &plan.feeds;
    text += &format!(
        "feed rates, mm/min: {:.0} beside earlier passes, {:.0} in full stock, {:.0} along walls, \
         {:.0} ramping down, {:.0} down to the stock\n",
        feeds.step_mm_per_min,
        feeds.slot_mm_per_min,
        feeds.wall_mm_per_min,
        feeds.ramp_mm_per_min,
        feeds.approach_mm_per_min,
    );
    for height in &curves.empty {
        text += &format!("nothing is planned {height} mm above the hub: the cutter fits nowhere there\n");
    }
    text += &left_out_lines(&plan.uncut);
    if let Some(note) = overhang_note(&plan.tool, &plan.uncut, &outcome.workpiece.part) {
        text += &format!("{note}\n");
    }
    text
}

/// Passes that were left out, by layer and reason, a line each.
fn left_out_lines(uncut: &[UncutLength]) -> String {
    let mut sums: Vec<UncutLength> = Vec::new();
    for left in uncut {
        match sums.iter_mut().find(|sum| (sum.layer, sum.why) == (left.layer, left.why)) {
            Some(sum) => sum.add(left.length, left.overhang),
            None => sums.push(left.clone()),
        }
    }
    let line = |UncutLength { layer, length, why, overhang, .. }: UncutLength| {
        let why = why.message;
        let length = words::left_out_text(length, |mm| format!("{mm:.1} mm"));
        let overhang = overhang.map_or(String::new(), |most| format!("; an overhang of {most} mm would do"));
        format!("left out: {length} of passes of layer {}, {why}{overhang}\n", layer + 1)
    };
    sums.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flank::UncutReason;
    use crate::flank::region::Region;

    #[test]
    fn passes_left_out_are_summed_by_layer_and_reason() {
        let left = |layer, length, message, overhang| UncutLength {
            layer,
            region: Region::INLET,
            length,
            why: UncutReason::new(message),
            overhang,
        };
        let uncut = [
            left(1, 0.04, "a blade is too near", None),
            left(0, 3.0, "the holder meets the part", Some(41.0)),
            left(0, 2.0, "the holder meets the part", Some(43.0)),
            left(1, 1.2, "a blade is too near", None),
            left(1, 0.02, "too short", None),
        ];
        assert_eq!(
            left_out_lines(&uncut),
            "left out: 1.2 mm of passes of layer 2, a blade is too near\n\
             left out: 5.0 mm of passes of layer 1, the holder meets the part; an overhang of 43 mm would do\n\
             left out: less than 0.1 mm of passes of layer 2, too short\n"
        );
    }
}
