//! Documents of the window: the setup sheet of a plan and the page of an assessment, as the command line
//! writes them. The names of their pictures begin with that of the page: a folder may hold many pages.

use std::path::Path;

use super::programs::{ProgramSource, UnwrittenProgram};
use crate::error::UserError;
use crate::io::InputError;
use crate::io::apt::as_written;
use crate::job::FIELD_CELLS;
use crate::job::assess::AssessedPart;
use crate::monitor::Monitor;
use crate::report::ReportPage;
use crate::report::assessment::assessment_page;
use crate::report::pictures::{flank_pictures, plan_pictures};
use crate::report::sheet::flank::{FlankSheetInput, flank_sheet};
use crate::report::sheet::{ProgramFile, SheetInput, setup_sheet};
use crate::verify::{VerifyError, report_plunges};

/// Content of a setup sheet.
pub struct SheetTask {
    /// The plan.
    pub source: ProgramSource,
    /// Its program files.
    pub files: Vec<ProgramFile>,
    /// What else must be known of the setup before the program runs.
    pub remarks: Vec<String>,
}

/// The setup sheet of a plan, to be saved at `path`. Its program is verified as it is written.
///
/// # Errors
/// When the pictures cannot be drawn, or the program cannot be verified or has faults that nobody was asked
/// about; when `monitor` is cancelled.
pub(super) fn sheet(
    path: &Path,
    task: &SheetTask,
    monitor: &Monitor,
) -> Result<ReportPage, UnwrittenProgram> {
    let fault = |error: UserError| InputError::at_file(&path.display().to_string(), error);
    let source = match &task.source {
        ProgramSource::Plunges(source) => source,
        ProgramSource::Flank(source) => {
            let outcome = &source.ordered();
            let program = &source.accepted_program(monitor)?;
            let pictures = flank_pictures(outcome, &prefix(path)).map_err(fault)?;
            let SheetTask { files, remarks, .. } = task;
            return Ok(flank_sheet(&FlankSheetInput { outcome, program, files, remarks }, pictures));
        }
    };
    let outcome = &source.planned.outcome;
    let shown = source.planned.result(source.policy);
    let written = as_written("the program", &source.accepted_program(monitor)?)?;
    let report = report_plunges(&outcome.workpiece, &outcome.setup, &written, FIELD_CELLS, monitor);
    let report = report.map_err(|error| match error {
        VerifyError::Program(error) => UnwrittenProgram::Failed(fault(error.into())),
        VerifyError::Cancelled(cancelled) => cancelled.into(),
    })?;
    let pictures = plan_pictures(outcome, shown, &prefix(path)).map_err(fault)?;
    let SheetTask { files, remarks, .. } = task;
    let input = SheetInput { outcome, shown, report: &report, channels: source.channels, files, remarks };
    Ok(setup_sheet(&input, pictures))
}

/// The page of an assessment, to be saved at `path`.
///
/// # Errors
/// When its pictures cannot be drawn.
pub(super) fn assessment(path: &Path, assessed: &AssessedPart) -> Result<ReportPage, InputError> {
    let name = path.display().to_string();
    assessment_page(assessed, &prefix(path)).map_err(|error| InputError::at_file(&name, error))
}

/// What the names of the pictures begin with that stand beside the page at `path`.
fn prefix(path: &Path) -> String {
    format!("{}-", path.file_stem().unwrap_or_default().to_string_lossy())
}
