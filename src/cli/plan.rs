//! `vanecut plan`.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::args::PlanArgs;
use super::channels::{channel_keys, wheel_text};
use super::curve::{check_policy, curve_text, point_object, time_stock_curve};
use super::edits::{unapplied_objects, unapplied_text};
use super::machine_figures::MachineFigures;
use super::open::OpenSetup;
use super::output::{PlungeFigures, SectionFigures, blades_text};
use super::output_folder::{check_directory, create_directory, write_report};
use super::stdout::print_stdout;
use super::watch::run_with_progress;
use super::{Failure, open, output};
use crate::error::ErrorCode;
use crate::io::apt::{read_apt_bytes, write_apt};
use crate::io::plan_file::write_plan;
use crate::io::setup_file::parse_axis_policy;
use crate::io::write::write_all_atomically;
use crate::job::{self, JobError, PlanOutcome, PlanRequest, Summary};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Impeller;
use crate::plunge::RowDensity;
#[cfg(feature = "gpu")]
use crate::report::pictures::plan_pictures;
use crate::report::sheet::{ProgramFile, SheetInput, setup_sheet};
use crate::report::words;
use crate::setup::AxisPolicy;
use crate::toolpath::min_rapid_length;
use crate::verify::{PlungeReport, count_by_kind, report_plunges};

use crate::job::FIELD_CELLS;

/// Plans, writes the files and prints the figures.
///
/// # Errors
/// [`Failure::input`] when an input is invalid; [`Failure::work`] when planning is cancelled, the plan is
/// unfinished, does not converge, or its program has faults.
pub fn run(args: &PlanArgs) -> Result<(), Failure> {
    let (description, part) = open::part(&args.part, &args.mesh)?;
    let mut setup = open::setup(args.setup.as_deref(), &args.part, &part)?;
    args.several.order(&mut setup.setup.channels)?;
    let policy = match &args.axis {
        None => setup.setup.plunge.axis,
        Some(name) => parse_axis_policy(name).map_err(|error| Failure::from(error).at("--axis"))?,
    };
    let channels = args.several.count(&part)?;
    check_directory(&args.output)?;
    args.pareto.map(|_| check_policy(policy)).transpose()?;
    let outcome = plan_with_progress(part, &setup, policy, true)?;
    let after = &outcome.after;
    let text = write_plan(&description, &setup.as_stored(&outcome.setup), &after.plan, channels);
    let program = outcome.program_for_channels(after, channels, &Monitor::default())?;
    let program = write_apt(&program);
    create_directory(&args.output)?;
    let apt = args.output.join("plunge.apt");
    write_all_atomically(&[
        (args.output.join("plan.json"), text.as_bytes()),
        (apt.clone(), program.as_bytes()),
    ])?;
    // The report is that of the program as written: read back and verified as by `vanecut verify`.
    let name = apt.display().to_string();
    let written = read_apt_bytes(&name, program.as_bytes())?;
    let report =
        report_plunges(&outcome.workpiece, &outcome.setup, &written, FIELD_CELLS, &Monitor::default())
            .map_err(|error| Failure::of_verify(&name, error))?;
    let min_rapids = min_rapid_length(&written);
    let on_machine = outcome.clock.on_machine().map(|clock| MachineFigures::of_plan(clock, &written));
    if args.report {
        let files = [ProgramFile::plan("plan.json"), ProgramFile::apt("plunge.apt")];
        let (shown, report, files) = (&outcome.after, &report, &files);
        let sheet = SheetInput { outcome: &outcome, shown, report, channels, files, remarks: &[] };
        write_sheet(&args.output, &sheet)?;
    }
    // The plan is written and printed even if the curve is stopped.
    let count = args.pareto.filter(|_| !after.plan.is_unfinished());
    let curve = count.map(|count| time_stock_curve(&outcome, usize::from(count)));
    if args.json {
        let mut object = plan_json(&outcome, &report, channels);
        object.insert("rapid_length_min".into(), json!(min_rapids.map(output::number)));
        object.extend(MachineFigures::keys_of(on_machine.as_ref(), &outcome.setup));
        if let Some(Ok(curve)) = &curve {
            object.insert("pareto".into(), curve.iter().map(|point| point_object(point, &outcome)).collect());
        }
        print_stdout(&format!("{}\n", Value::Object(object)))?;
    } else {
        print_stdout(&plan_text(&outcome, &report, (on_machine.as_ref(), min_rapids), channels, args))?;
        if let Some(Ok(curve)) = &curve {
            print_stdout(&curve_text(curve, &outcome))?;
        }
    }
    curve.transpose()?;
    check_result(&outcome, &report, &name)
}

/// Writes `report.html`, with its pictures where the program draws any, into `folder`.
///
/// # Errors
/// [`Failure::work`] when drawing fails, [`Failure::input`] when a file cannot be written.
fn write_sheet(folder: &Path, input: &SheetInput) -> Result<(), Failure> {
    #[cfg(feature = "gpu")]
    let pictures = plan_pictures(input.outcome, input.shown, "").map_err(Failure::of_work)?;
    // The sheet has its drawings all the same.
    #[cfg(not(feature = "gpu"))]
    let pictures = Vec::new();
    let document = setup_sheet(input, pictures);
    write_report(folder, &document)
}

/// Runs the planning job, with progress on a terminal.
///
/// # Errors
/// [`Failure::work`] when cancelled, [`Failure::input`] when part and setup are incompatible.
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
    run_with_progress("planning", |monitor| job::run(&request, monitor)).map_err(|error| match error {
        JobError::Cancelled => Cancelled.into(),
        JobError::Setup(fault) => setup.failure(fault),
    })
}

fn plan_json(outcome: &PlanOutcome, report: &PlungeReport, channels: usize) -> Map<String, Value> {
    let (part, grid, reasons) = (&outcome.workpiece.part, &outcome.grid, &outcome.reasons);
    let mut map = output::plan_object(part, channels, &written_figures(outcome, report, channels), reasons);
    let compared = |result| output::comparison_object(&PlungeFigures::of_result(result, grid), reasons);
    map.extend(output::assembly_keys(&report.verdict.assembly));
    map.insert("policy".into(), json!(outcome.after.plan.policy));
    if let Some(wheel) = outcome.after.summary.wheel_time_s {
        map.insert("wheel_time".into(), output::number(wheel));
    }
    map.extend(channel_keys(outcome.setup.channels));
    if channels > 1 {
        let one = PlungeFigures::of_result(&outcome.after, grid);
        map.insert("one_channel".into(), Value::Object(output::plan_object(part, 1, &one, reasons)));
    }
    map.insert("before".into(), compared(&outcome.before));
    let policies = outcome.policies().into_iter();
    let policies = policies.map(|result| (result.plan.policy.name().to_owned(), compared(result)));
    map.insert("policies".into(), Value::Object(policies.collect()));
    map.insert("inaccessible".into(), output::inaccessible_list(&outcome.inaccessible_floor));
    map.insert("edits".into(), json!(outcome.setup.plunge.edits.len()));
    map.insert("edits_unfitting".into(), json!(outcome.edits.unapplied.len()));
    map.insert("edits_not_applied".into(), unapplied_objects(outcome));
    map.insert("goal_met".into(), json!(!outcome.misses_goal));
    map.insert("finish_time".into(), json!(outcome.finishing_time_s(&outcome.after).map(output::number)));
    map.insert("faults".into(), output::fault_list(&report.verdict.faults));
    map.insert("elapsed".into(), output::number(outcome.elapsed));
    map
}

/// Figures of the plan, taken from its written program where possible.
fn written_figures<'a>(
    outcome: &'a PlanOutcome,
    report: &PlungeReport,
    channels: usize,
) -> PlungeFigures<'a> {
    let one = PlungeFigures::of_result(&outcome.after, &outcome.grid);
    // A program does not contain blocked positions; their number is the same in every channel.
    let with_blocked = |s: &Summary, one: &Summary| Summary {
        blocked: one.blocked.map(|blocked| blocked * channels),
        ..s.clone()
    };
    let written = |section: SectionFigures<'a>| {
        let summary = with_blocked(report.sections.get(section.index)?, &section.summary);
        Some(SectionFigures { summary, ..section })
    };
    PlungeFigures {
        summary: with_blocked(&report.summary, &one.summary),
        sections: one.sections.into_iter().filter_map(written).collect(),
        rows: report.verdict.rows(),
        plan: one.plan,
    }
}

/// The table of the plan with what has to be said about it; `min_rapids` is that of [`min_rapid_length`].
fn plan_text(
    outcome: &PlanOutcome,
    report: &PlungeReport,
    (on_machine, min_rapids): (Option<&MachineFigures>, Option<f64>),
    channels: usize,
    args: &PlanArgs,
) -> String {
    let part = &outcome.workpiece.part;
    let plan = &outcome.after.plan;
    let mut text = format!(
        "{}: {}, D {:.1}; {channels} of {} channels planned\n",
        part.name,
        blades_text(part),
        2.0 * part.rim_radius(),
        part.blade_count
    );
    if channels > 1 {
        text += "one channel:\n";
    }
    let policies = outcome.policies().into_iter();
    text += &output::table(
        policies.map(|result| (result.plan.policy.name(), PlungeFigures::of_result(result, &outcome.grid))),
    );
    text += &outcome.policies().iter().map(|result| output::breach_text(&result.plan)).collect::<String>();
    if channels > 1 {
        let (policy, count) = (plan.policy.name(), words::channels_text(channels));
        text += &format!("{policy} as written, {count}, {}:\n", outcome.setup.channels.words());
        text +=
            &output::table([(plan.policy.name(), written_figures(outcome, report, channels))].into_iter());
    } else {
        text += &format!("{} as written:\n", plan.policy.name());
    }
    text += &output::inaccessible_text(&outcome.inaccessible_floor);
    text += &output::reasons_text(plan, &outcome.reasons);
    text += &output::added_text(plan);
    let edits = outcome.setup.plunge.edits.len();
    if edits > 0 {
        let count = outcome.edits.unapplied.len();
        text += &edits_text(edits, count);
        text += &unapplied_text(outcome);
    }
    if let Some(missed) = words::missed_goal(outcome, |mm| format!("{mm:.3} mm")) {
        text += &format!("{missed}\n");
    }
    // By how many plunges an edited plan is smaller says nothing of the goal.
    let whole = outcome.whole.as_ref().filter(|whole| whole.policy == plan.policy && edits == 0);
    if let Some(whole) = whole {
        let (found, kept) = (whole.positions.len(), plan.positions.len());
        text += &match outcome.density {
            RowDensity::Dense => format!(
                "{} of {found} plunges found are left out: they are not worth their time\n",
                found - kept
            ),
            RowDensity::Sparse => {
                format!("planned with fewer rows for the goal: {kept} plunges instead of {found}\n")
            }
        };
    }
    text += &words::clearances_text(&report.summary, channels);
    if channels > 1 {
        text += &format!("{}\n", words::tool_loads_text(report.summary.tool_loads));
    }
    if let Some(least) = min_rapids {
        let rapids = report.summary.rapid_length;
        text += &format!(
            "rapids {:.1} m; in no order of the cuts less than {:.1} m\n",
            rapids / 1e3,
            least / 1e3
        );
    }
    text += &MachineFigures::text_of(on_machine, &outcome.setup);
    let is_timed = outcome.clock.timing().is_some();
    text += &wheel_text(part, outcome.setup.channels, outcome.after.summary.wheel_time_s, is_timed);
    if let Some(finishing) = words::finishing_text(outcome, &outcome.after) {
        text += &format!("{finishing}\n");
    }
    text += &output::assembly_text(&report.verdict.assembly);
    text += &output::convergence_text(plan);
    text += &output::limited_text(plan, edits > 0);
    text += &output::blocked_text(plan);
    text += &output::tools_text(&outcome.setup, plan.tools());
    text += &output::notes_text(&report.notes);
    text += &format!(
        "wrote {} and {}\n",
        args.output.join("plan.json").display(),
        args.output.join("plunge.apt").display()
    );
    text
}

/// How many edits by hand a plan has, and how many of them are not in it.
fn edits_text(count: usize, unapplied: usize) -> String {
    format!("edited by hand: {}, {unapplied} not applied\n", words::counted(count, "edit", "edits"))
}

/// Fails when the plan was stopped, its program has faults, or the planning loop did not converge.
fn check_result(outcome: &PlanOutcome, report: &PlungeReport, name: &str) -> Result<(), Failure> {
    let plan = &outcome.after.plan;
    if plan.is_unfinished() {
        let what = "stopped: the plan is unfinished, and so marked in the files";
        return Err(Failure::work(ErrorCode::PlanIncomplete, what, "plan again to complete it"));
    }
    let faults = &report.verdict.faults;
    if let Some(first) = faults.first() {
        let counts = count_by_kind(faults);
        let cure = if faults.iter().all(|fault| fault.kind.is_of_assembly()) {
            "use a thinner shank, a longer overhang or smaller clearances"
        } else if plan.policy == AxisPolicy::Minimal {
            "use smaller cutters or steps"
        } else {
            "plan with --axis minimal, or use smaller cutters or steps"
        };
        let by_hand = match outcome.setup.plunge.edits.is_empty() {
            true => "",
            false => "take back the edits by hand that cause it ([[plunge.edit]] in the setup), or ",
        };
        let help = format!("in all {counts}: {by_hand}{cure}");
        let failure = Failure::work(ErrorCode::ProgramFaults, first.to_string(), help);
        return Err(failure.at(format!("{name}:{}", first.line)));
    }
    if !plan.converged {
        let what = "the planning loop did not converge";
        return Err(Failure::work(ErrorCode::PlanIncomplete, what, "use smaller cutters or steps"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::edits_text;

    #[test]
    fn one_edit_is_no_edits() {
        assert_eq!(edits_text(1, 0), "edited by hand: 1 edit, 0 not applied\n");
        assert_eq!(edits_text(2, 1), "edited by hand: 2 edits, 1 not applied\n");
    }
}
