//! `vanecut plan`.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::args::PlanArgs;
use super::open::OpenSetup;
use super::report::PlanFigures;
use super::watch::run_with_progress;
use super::{Failure, open, print_stdout, render, report};
use crate::io::apt::{read_apt_bytes, write_apt};
use crate::io::plan_file::write_plan;
use crate::io::setup_file::parse_axis_policy;
use crate::io::write::write_all_atomically;
use crate::job::{self, JobError, PlanOutcome, PlanRequest, Summary};
use crate::monitor::Monitor;
use crate::part::{Blank, Channel, Impeller};
use crate::plunge::whole::plan_channels;
use crate::setup::AxisPolicy;
use crate::toolpath::ClProgram;
use crate::verify::{PlungeReport, count_by_kind, report_plunges};

pub use crate::job::FIELD_CELLS;

/// Plans, writes the files and prints the figures.
///
/// # Errors
/// [`Failure::Input`] when an input is invalid; [`Failure::Work`] when planning is cancelled, the plan is
/// unfinished, does not converge, or its program has faults.
pub fn run(args: &PlanArgs) -> Result<(), Failure> {
    let (description, part) = open::part(&args.part, &args.mesh)?;
    let setup = open::setup(args.setup.as_deref(), &args.part, &part)?;
    let policy = match &args.axis {
        None => setup.setup.plunge.axis,
        Some(name) => parse_axis_policy(name)
            .map_err(|(what, cure)| Failure::Input(format!("--axis: {what}; {cure}")))?,
    };
    let channels = channel_count(&args.channels, &part)?;
    check_directory(&args.output)?;
    let outcome = plan_with_progress(part, &setup, policy, true)?;
    let after = &outcome.after;
    let text = write_plan(&description, &outcome.setup, &after.plan, channels);
    let program = write_apt(&program_of(&outcome, channels)?);
    create_directory(&args.output)?;
    let apt = args.output.join("plunge.apt");
    write_all_atomically(&[
        (args.output.join("plan.json"), text.as_bytes()),
        (apt.clone(), program.as_bytes()),
    ])?;
    if args.report {
        render::write_report(&args.output, &outcome)?;
    }
    // The report is that of the program as written: read back and verified as by `vanecut verify`.
    let name = apt.display().to_string();
    let written = read_apt_bytes(&name, program.as_bytes())?;
    let channel = Channel::of(&outcome.part);
    let report = report_plunges(&outcome.part, &channel, &outcome.setup, &written, FIELD_CELLS)
        .map_err(|fault| Failure::at(&name, fault.line, &fault.message))?;
    if args.json {
        print_stdout(&format!("{}\n", Value::Object(plan_json(&outcome, &report, channels))))?;
    } else {
        print_stdout(&plan_text(&outcome, &report, channels, args))?;
    }
    check_result(&outcome, &report, &name)
}

/// The program of the first `channels` channels of a plan.
fn program_of(outcome: &PlanOutcome, channels: usize) -> Result<ClProgram, Failure> {
    let (part, stock) = (&outcome.part, &outcome.setup.allowances);
    let blank = Blank::of(part, stock.inlet_extension);
    let monitor = Monitor::default();
    let plan = plan_channels(&outcome.after.plan, part, &blank, stock.safety_distance, channels, &monitor)
        .map_err(|_| Failure::Work("cancelled".to_owned()))?;
    Ok(ClProgram::of_plan(&part.name, &plan))
}

/// Runs the planning job, with progress on a terminal.
///
/// # Errors
/// [`Failure::Work`] when cancelled, [`Failure::Input`] when part and setup are incompatible.
pub fn plan_with_progress(
    part: Impeller,
    setup: &OpenSetup,
    policy: AxisPolicy,
    compare: bool,
) -> Result<PlanOutcome, Failure> {
    let request = PlanRequest {
        part: Arc::new(part),
        setup: setup.setup.clone(),
        policy,
        compare,
        field_cells: FIELD_CELLS,
    };
    run_with_progress(|monitor| job::run(&request, monitor)).map_err(|error| match error {
        JobError::Cancelled => Failure::Work("cancelled".to_owned()),
        JobError::Setup(fault) => setup.failure(&fault),
    })
}

fn channel_count(word: &str, part: &Impeller) -> Result<usize, Failure> {
    let all = part.blade_count;
    match word {
        "all" => Ok(all),
        _ => word.parse().ok().filter(|n| (1..=all).contains(n)).ok_or_else(|| {
            Failure::Input(format!("--channels {word}: not a number of channels; give 1 to {all}, or all"))
        }),
    }
}

/// Checks the output directory before planning, so that [`create_directory`] does not fail only after it.
///
/// # Errors
/// [`Failure::Input`] when `folder` exists and is not a directory.
pub fn check_directory(folder: &Path) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        let what = "is not a directory; give one that can be written";
        return Err(Failure::at(&folder.display().to_string(), 0, what));
    }
    Ok(())
}

/// Creates the output directory.
///
/// # Errors
/// [`Failure::Input`] when it cannot be created.
pub fn create_directory(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| {
        Failure::Input(format!(
            "{}: the directory cannot be created ({e}); give one that can be written",
            folder.display()
        ))
    })
}

fn plan_json(
    outcome: &PlanOutcome,
    report: &PlungeReport,
    channels: usize,
) -> serde_json::Map<String, Value> {
    let (part, grid, reasons) = (&outcome.part, &outcome.grid, &outcome.reasons);
    let mut map = report::plan_object(part, channels, &written_figures(outcome, report, channels), reasons);
    let compared = |result| report::comparison_object(&PlanFigures::of_result(result, grid), reasons);
    map.extend(report::assembly_keys(&report.verdict.assembly));
    map.insert("policy".into(), json!(outcome.after.plan.policy));
    if channels > 1 {
        let one = PlanFigures::of_result(&outcome.after, grid);
        map.insert("one_channel".into(), Value::Object(report::plan_object(part, 1, &one, reasons)));
    }
    map.insert("before".into(), compared(&outcome.before));
    let policies = outcome.policies().into_iter();
    let policies = policies.map(|result| (result.plan.policy.name().to_owned(), compared(result)));
    map.insert("policies".into(), Value::Object(policies.collect()));
    map.insert("faults".into(), report::fault_list(&report.verdict.faults));
    map.insert("elapsed".into(), report::number(outcome.elapsed));
    map
}

/// Figures of the plan, taken from its written program where possible.
fn written_figures<'a>(outcome: &'a PlanOutcome, report: &PlungeReport, channels: usize) -> PlanFigures<'a> {
    let one = PlanFigures::of_result(&outcome.after, &outcome.grid);
    // A program does not contain blocked positions; their number is the same in every channel.
    let with_blocked = |s: &Summary, one: &Summary| Summary { blocked: one.blocked * channels, ..s.clone() };
    let sections = report.sections.iter().zip(&one.sections);
    PlanFigures {
        summary: with_blocked(&report.summary, &one.summary),
        sections: sections.map(|(s, one)| with_blocked(s, one)).collect(),
        rows: report.verdict.plan.sections.iter().map(|section| section.rows).sum(),
        ..one
    }
}

fn plan_text(outcome: &PlanOutcome, report: &PlungeReport, channels: usize, args: &PlanArgs) -> String {
    let part = &outcome.part;
    let plan = &outcome.after.plan;
    let mut text = format!(
        "{}: {} blades{}, D {:.1}; {channels} of {} channels planned\n",
        part.name,
        part.blade_count,
        if part.splitters.is_empty() { "" } else { " and as many splitters" },
        2.0 * part.rim_radius(),
        part.blade_count
    );
    if channels > 1 {
        text += "one channel:\n";
    }
    let policies = outcome.policies().into_iter();
    text += &report::table(
        policies.map(|result| (result.plan.policy.name(), PlanFigures::of_result(result, &outcome.grid))),
    );
    if channels > 1 {
        text += &format!("{} as written, {}:\n", plan.policy.name(), report::channels_text(channels));
        text +=
            &report::table([(plan.policy.name(), written_figures(outcome, report, channels))].into_iter());
    } else {
        text += &format!("{} as written:\n", plan.policy.name());
    }
    text += &report::reasons_text(plan, &outcome.reasons);
    text += &report::added_text(plan);
    text += &report::clearances_text(&report.summary, channels);
    text += &report::assembly_text(&report.verdict.assembly);
    text += &report::convergence_text(plan);
    text += &report::limited_text(plan);
    text += &report::blocked_text(plan);
    text += &report::notes_text(&report.notes);
    text += &format!(
        "wrote {} and {}\n",
        args.output.join("plan.json").display(),
        args.output.join("plunge.apt").display()
    );
    text
}

/// Fails when the plan was stopped, its program has faults, or the planning loop did not converge.
fn check_result(outcome: &PlanOutcome, report: &PlungeReport, name: &str) -> Result<(), Failure> {
    let plan = &outcome.after.plan;
    if plan.is_unfinished() {
        let what = "stopped: the plan is unfinished, and so marked in the files; plan again to complete it";
        return Err(Failure::Work(what.to_owned()));
    }
    let faults = &report.verdict.faults;
    if let Some(first) = faults.first() {
        return Err(Failure::Work(format!(
            "{name}:{}: {}; in all {}: plan with --axis minimal, or use smaller cutters or steps",
            first.line,
            first.message,
            count_by_kind(faults)
        )));
    }
    if !plan.converged {
        let what = "the planning loop did not converge; use smaller cutters or steps";
        return Err(Failure::Work(what.to_owned()));
    }
    Ok(())
}
