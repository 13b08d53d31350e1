//! Checks a program from anywhere against the part, as `vanecut verify` does, and prepares what is shown of
//! it.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use crate::app::model::checked::{
    CheckRequest, CheckedProgram, FaultPlace, FigureValue, ProgramFigure, ProgramFinding,
};
use crate::app::model::figures::{ABOVE_SCALLOP, ABOVE_SCALLOP_TIP, MAX_GOOD_UNCUT_SHARE, format_percent};
use crate::app::model::listing::ProgramListing;
use crate::app::model::preview::ShownCutters;
use crate::app::model::verdict::is_flank_complete;
use crate::app::tasks::program_watch::stamp_of;
use crate::drawing::cutters::single_cutter;
use crate::drawing::flank::RAPID_COLOUR;
use crate::error::ErrorCode;
use crate::gpu::cutters::CutterState;
use crate::gpu::mesh::Segment;
use crate::io::InputError;
use crate::io::machine_file::machine_of_setup;
use crate::io::plan_inputs::is_plan_file;
use crate::io::program_file::{NcMachine, NcTarget, ProgramReading, read_program_bytes};
use crate::io::source::{MAX_PROGRAM_BYTES, name_of, read_bytes_up_to};
use crate::job::FIELD_CELLS;
use crate::job::machine_run::MachineRun;
use crate::machine::{BlankSize, MachineClock, MachineTime, section_times};
use crate::monitor::Monitor;
use crate::palette::{INTERFERING, category};
use crate::part::Workpiece;
use crate::plunge::sections::check_part;
use crate::setup::{Setup, Tool};
use crate::toolpath::{ClProgram, Motion, Move, Travel};
use crate::verify::{
    Fault, FlankVerdict, PlungeReport, VerifyError, count_by_kind, report_plunges, verify_flank,
};

/// Widths of the lines of rapids, cuts and faults, pixels.
const WIDTHS: [f32; 3] = [0.8, 1.6, 3.0];
/// Faults that are shown at their place; further ones are only listed.
const MAX_PLACES: usize = 5000;

/// Why a program is not checked.
#[derive(Debug)]
pub enum CheckError {
    /// It cannot be read or judged.
    Input(InputError),
    /// The work was cancelled.
    Cancelled,
}

impl From<InputError> for CheckError {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

/// Reads and checks a program.
///
/// # Errors
/// [`CheckError`] when the program cannot be read, or cannot be judged at all, or when cancelled.
pub fn check(request: &CheckRequest, monitor: &Monitor) -> Result<CheckedProgram, CheckError> {
    let CheckRequest { path, machine, control, part, setup } = request;
    let name = name_of(path);
    check_part(setup, part)
        .map_err(|fault| InputError::new(fault.code, "", 0, fault.message.clone(), fault.help.clone()))?;
    if is_plan_file(path) {
        let help = "check the program that was written with it, or open the plan as a part";
        return Err(InputError::new(ErrorCode::FileFormat, &name, 0, "is a plan, not a program", help).into());
    }
    // Before its text: what is written meanwhile counts as a change.
    let stamp = stamp_of(path);
    let bytes = read_bytes_up_to(path, MAX_PROGRAM_BYTES)?;
    let target = NcTarget { machine: Path::new(machine), control: control.as_deref() };
    let ProgramReading { program, overruns, on_machine } =
        read_program_bytes(&name, &bytes, Some(target), part, setup)?;
    let workpiece = setup.allowances.workpiece_of(Arc::clone(part));
    let unjudged = |error: VerifyError| match error {
        VerifyError::Cancelled(_) => CheckError::Cancelled,
        VerifyError::Program(Fault { line, message, help, .. }) => {
            InputError::new(ErrorCode::ProgramTool, &name, line, message, help).into()
        }
    };
    let judged = if program.mills_along_curves() {
        Judged::of_flank(verify_flank(&workpiece, setup, &program, monitor).map_err(unjudged)?)
    } else {
        Judged::of_plunges(
            report_plunges(&workpiece, setup, &program, FIELD_CELLS, monitor).map_err(unjudged)?,
        )
    };
    let mut faults = judged.faults;
    faults.extend(overruns);
    faults.sort_by_key(|fault| fault.line);
    let reader = program.warnings.iter().map(|w| format!("Line {}: {}", w.line, w.message));
    let notes = judged.notes.into_iter().chain(reader).collect();
    let ends = program.moves.iter().map(|step| Some(step.line).filter(|&line| line > 0)).collect();
    let listing =
        ProgramListing::new(String::from_utf8_lossy(&bytes).into_owned(), ends, Travel::clock(&program));
    Ok(CheckedProgram {
        request: request.clone(),
        stamp,
        kind: judged.kind,
        summary: count_by_kind(&faults),
        lines: lines_of(&program, &faults),
        findings: findings_of(&program, setup, &listing, faults),
        figures: judged.figures,
        notes,
        time_estimate: judged.time,
        machine_time: time_on_machine(&program, on_machine.as_ref(), &workpiece, setup, monitor),
        is_complete: judged.is_complete && program.incomplete_words().is_none(),
        listing: Arc::new(listing),
        program,
        workpiece: Arc::new(workpiece),
        on_machine,
    })
}

/// Time of a program on the machine that NC code was posted for, or of APT on that of the setup, s; `None`
/// without a machine, and where it cannot run the program.
fn time_on_machine(
    program: &ClProgram,
    posted_for: Option<&NcMachine>,
    workpiece: &Workpiece,
    setup: &Setup,
    monitor: &Monitor,
) -> Option<f64> {
    let Some(on_machine) = posted_for else {
        // A machine that cannot be read is a problem of the setup, which is shown with its plan.
        let machine = machine_of_setup(setup).ok()??;
        let clock = MachineClock::new(machine, workpiece, &setup.allowances);
        return clock.time(program).map(|time| time.total_s);
    };
    let blank = BlankSize::from_part(&workpiece.part, &setup.allowances);
    let run = MachineRun::as_read(on_machine, program, blank, &monitor.silent()).ok()?;
    Some(MachineTime::of_sections(&section_times(&on_machine.machine, program, &run.motion)).total_s)
}

/// What both kinds of programs have in common.
struct Judged {
    kind: &'static str,
    faults: Vec<Fault>,
    figures: Vec<ProgramFigure>,
    notes: Vec<String>,
    time: f64,
    is_complete: bool,
}

impl Judged {
    fn of_plunges(report: PlungeReport) -> Self {
        let (summary, verdict) = (&report.summary, report.verdict);
        let figures = vec![
            ("Plunges", count(summary.positions), "Moves under feed"),
            ("Channels", count(verdict.channels), "Channels with cuts"),
            ("Core contact", count(summary.interfering), "Plunges whose core meets stock"),
            residual(summary.uncut_share, summary.residual_mean, summary.residual_p95),
            ("Not machined", FigureValue::Text(format_percent(summary.uncut_share)), UNCUT_TIP),
            (
                "Hub clearance",
                FigureValue::Length(summary.min_hub_clearance),
                "Least distance of a cutter to the finished hub",
            ),
            (
                "Blade clearance",
                FigureValue::Length(summary.min_blade_clearance),
                "Least distance to a finished blade",
            ),
            (
                "Rapid clearance",
                FigureValue::Length(summary.min_retract_clearance),
                "Least distance of rapids to the blank",
            ),
        ];
        Self {
            kind: "Plunge program",
            figures,
            time: summary.time_estimate,
            is_complete: summary.uncut_share <= MAX_GOOD_UNCUT_SHARE,
            notes: report.notes,
            faults: verdict.faults,
        }
    }

    fn of_flank(verdict: FlankVerdict) -> Self {
        let uncut = f64::from(verdict.layer.uncut_share);
        let figures = vec![
            ("Cutting moves", count(verdict.positions), "Moves under feed"),
            ("Channels", count(verdict.channels), "Channels with cuts"),
            (
                "Overcut of walls",
                FigureValue::Length(verdict.max_overcut),
                "Cut below the allowance of the blades",
            ),
            (
                "Left on walls",
                FigureValue::Length(verdict.max_undercut),
                "Stock left above the allowance of the blades",
            ),
            residual(uncut, verdict.layer.mean.into(), verdict.layer.p95.into()),
            (ABOVE_SCALLOP, FigureValue::Text(format_percent(verdict.uncovered.share())), ABOVE_SCALLOP_TIP),
            ("Not machined", FigureValue::Text(format_percent(uncut)), UNCUT_TIP),
            (
                "Walls not milled",
                FigureValue::Text(format_percent(verdict.unmilled_wall_share)),
                "Share of the walls to which no cutter comes near",
            ),
            (
                "Hub clearance",
                FigureValue::Length(verdict.min_hub_clearance),
                "Least distance of a cutter to the finished hub",
            ),
            (
                "Blade clearance",
                FigureValue::Length(verdict.min_blade_clearance),
                "Least distance to a finished blade",
            ),
        ];
        Self {
            kind: "Flank program",
            figures,
            time: verdict.time_estimate,
            is_complete: is_flank_complete(&verdict),
            notes: verdict.notes,
            faults: verdict.faults,
        }
    }
}

const RESIDUAL_TIP: &str = "Residual stock on the hub: mean and 95th percentile";
const UNCUT_TIP: &str = "Share of the accessible floor that is not cut";

/// The residual stock on the hub, which is that of what is cut: where nothing is, there is none to name.
fn residual(uncut_share: f64, mean: f64, p95: f64) -> ProgramFigure {
    let [mean, p95] = [mean, p95].map(|mm| if uncut_share < 1.0 { mm } else { f64::NAN });
    ("Residual", FigureValue::Residual(mean, p95), RESIDUAL_TIP)
}

fn count(number: usize) -> FigureValue {
    FigureValue::Text(number.to_string())
}

/// The moves as lines: rapids grey, cuts in the colour of their tool, those with a fault in that of faults.
fn lines_of(program: &ClProgram, faults: &[Fault]) -> Vec<Segment> {
    let to = |p: &crate::geometry::Point| [p.x as f32, p.y as f32, p.z as f32];
    let is_faulty = |line: usize| {
        line > 0
            && faults.binary_search_by_key(&line, |fault| fault.line).is_ok_and(|at| faults[at].line == line)
    };
    let same_tool = |pair: &&[Move]| pair[1].tool.is_some() && pair[0].tool == pair[1].tool;
    let line = |pair: &[Move]| {
        let step = &pair[1];
        let (colour, width) = match step.motion {
            _ if is_faulty(step.line) => (INTERFERING, WIDTHS[2]),
            Motion::Rapid => (RAPID_COLOUR, WIDTHS[0]),
            Motion::Feed(_) => {
                let tool = step.tool.unwrap_or_default();
                (category(tool), WIDTHS[1])
            }
        };
        Segment::coloured(to(&pair[0].tip), to(&step.tip), width, colour)
    };
    program.moves.windows(2).filter(same_tool).map(line).collect()
}

fn findings_of(
    program: &ClProgram,
    setup: &Setup,
    listing: &ProgramListing,
    faults: Vec<Fault>,
) -> Vec<ProgramFinding> {
    let mut moves: HashMap<usize, usize> = HashMap::new();
    for (index, step) in program.moves.iter().enumerate() {
        moves.entry(step.line).or_insert(index);
    }
    let finding = |(index, fault): (usize, Fault)| {
        let first_move = moves.get(&fault.line).copied().filter(|_| fault.line > 0);
        let step = first_move.and_then(|k| program.moves.get(k)).filter(|_| index < MAX_PLACES);
        let tool = step.and_then(|step| program.tools.get(step.tool?)).map(|tool| tool.completed(setup));
        let place = step.zip(tool).map(|(step, tool)| place_of(step, &tool));
        let text = listing.line(fault.line).unwrap_or_default().trim().to_owned();
        ProgramFinding { place, first_move, text, fault }
    };
    faults.into_iter().enumerate().map(finding).collect()
}

/// The tool at the end of a move.
fn place_of(step: &Move, tool: &Tool) -> FaultPlace {
    let cutter = single_cutter(tool, step.tip, step.axis, CutterState::Interfering);
    let cutter = ShownCutters { cutters: [cutter].into(), program: None };
    FaultPlace { tip: step.tip, axis: step.axis, radius: tool.radius(), cutter }
}

#[cfg(test)]
mod tests {
    use super::residual;
    use crate::app::model::units::DisplayUnits::Metric;

    #[test]
    fn what_is_not_cut_has_no_residual() {
        let text = |uncut_share: f64| residual(uncut_share, 0.4, 0.7).1.text(Metric);
        assert_eq!((text(0.2), text(1.0)), ("0.40/0.70 mm".into(), "-".into()));
    }
}
