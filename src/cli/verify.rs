//! `vanecut verify`.

pub(super) mod flank;

use std::path::Path;

use serde_json::{Map, Value, json};

use super::args::VerifyArgs;
use super::machine_figures::MachineFigures;
use super::output::PlungeFigures;
use super::stdout::{MAX_SHOWN, print_stdout};
use super::watch::run_with_progress;
use super::{Failure, open, output};
use crate::error::ErrorCode;
use crate::io::apt::cut_off_error;
use crate::io::program_file::{NcTarget, ProgramReading, read_program_bytes};
use crate::job::FIELD_CELLS;
use crate::part::Impeller;
use crate::plunge::sections::check_part;
use crate::report::words;
use crate::toolpath::ClWarning;
use crate::verify::{PlungeReport, VerifyError, report_plunges, verify_flank};

/// Verifies a program and prints the findings.
///
/// # Errors
/// [`Failure::input`] when an input is invalid, [`Failure::work`] when the program has faults.
pub fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let started = std::time::Instant::now();
    let (_, part) = open::part(&args.part, &args.mesh)?;
    if args.program == Path::new("-") && args.setup.as_deref() == Some(Path::new("-")) {
        return Err(open::both_from_standard_input());
    }
    let opened = open::setup(args.setup.as_deref(), &args.part, &part)?;
    check_part(&opened.setup, &part).map_err(|fault| opened.failure(fault))?;
    let setup = &opened.setup;
    let (name, bytes) = open::named_bytes(&args.program)?;
    let target =
        args.machine.as_deref().map(|machine| NcTarget { machine, control: args.control.as_deref() });
    let ProgramReading { program, overruns, on_machine } =
        read_program_bytes(&name, &bytes, target, &part, setup)?;
    let workpiece = setup.allowances.workpiece_of(part);
    let part = &workpiece.part;
    let unjudged = |error: VerifyError| Failure::of_verify(&name, error);
    let (mut map, mut text, mut faults, notes) = if program.mills_along_curves() {
        let verdict =
            run_with_progress("checking", |monitor| verify_flank(&workpiece, setup, &program, monitor))
                .map_err(unjudged)?;
        (flank::object(part, &verdict), flank::text(&verdict), verdict.faults, verdict.notes)
    } else {
        let report = run_with_progress("checking", |monitor| {
            report_plunges(&workpiece, setup, &program, FIELD_CELLS, monitor)
        })
        .map_err(unjudged)?;
        (plunge_object(part, &report), plunge_text(&report), report.verdict.faults, report.notes)
    };
    if let Some(on_machine) = &on_machine {
        let figures = MachineFigures::of_program(on_machine, &program, &workpiece, setup);
        map.extend(figures.keys());
        text += &figures.text();
    }
    faults.extend(overruns);
    faults.sort_by_key(|fault| fault.line);
    if args.json {
        map.insert("elapsed".into(), output::number(started.elapsed().as_secs_f64()));
        map.insert("faults".into(), output::fault_list(&faults));
        let warning = |w: &ClWarning| json!({"line": w.line, "message": w.message});
        map.insert("notes".into(), json!(notes));
        map.insert("warnings".into(), program.warnings.iter().map(warning).collect());
        print_stdout(&format!("{}\n", Value::Object(map)))?;
    } else {
        for warning in &program.warnings {
            text += &format!("{name}:{}: {}\n", warning.line, warning.message);
        }
        for fault in faults.iter().take(MAX_SHOWN) {
            text += &format!("{name}:{}: {fault}\n", fault.line);
        }
        if faults.len() > MAX_SHOWN {
            text += &format!("… and {} more faults\n", faults.len() - MAX_SHOWN);
        }
        print_stdout(&text)?;
    }
    let what = match faults.len() {
        0 if program.is_unfinished() => {
            let what = "the program is unfinished: the calculation of its plan was stopped";
            let failure = Failure::work(ErrorCode::PlanIncomplete, what, "plan again to complete it");
            return Err(failure.at(name));
        }
        0 if program.is_cut_off => {
            return Err(Failure::of_work(cut_off_error()).at(name));
        }
        0 => return Ok(()),
        1 => "one fault found".to_owned(),
        n => format!("{n} faults found"),
    };
    Err(Failure::work(ErrorCode::ProgramFaults, what, "correct the program").at(name))
}

/// The JSON object of a plunge program.
fn plunge_object(part: &Impeller, report: &PlungeReport) -> Map<String, Value> {
    let mut map = output::plan_object(part, report.verdict.channels, &PlungeFigures::of_program(report), &[]);
    map.extend(output::assembly_keys(&report.verdict.assembly));
    map.insert("kind".into(), json!("plunge"));
    map.insert("cut_share".into(), output::number(1.0 - report.summary.uncut_share));
    map.insert("deepest_cut".into(), output::number(report.verdict.deepest_plunge));
    for key in [
        "max_overcut",
        "max_undercut",
        "uncovered_share",
        "uncovered_fillet_share",
        "uncovered_no_axis_share",
        "uncovered_gap_share",
    ] {
        map.insert(key.into(), Value::Null);
    }
    map
}

/// The text report of a plunge program.
fn plunge_text(report: &PlungeReport) -> String {
    let mut text = output::table([("program", PlungeFigures::of_program(report))].into_iter());
    text += &words::clearances_text(&report.summary, report.verdict.channels);
    text += &format!(
        "cuts {:.1} % of the reachable floor; deepest plunge {:.1} mm through the blank\n",
        100.0 * (1.0 - report.summary.uncut_share),
        report.verdict.deepest_plunge
    );
    text += &output::assembly_text(&report.verdict.assembly);
    text += &output::notes_text(&report.notes);
    text
}
