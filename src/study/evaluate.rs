//! One run: plan, write the program, judge it, and take its figures.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::result::{FIGURES, PROGRAM_VERSION, RunResult, RunStatus};
use super::runs::{RESULT_VERSION, Run, RunInput, RunList};
use crate::error::{ErrorCode, UserError};
use crate::io::apt::as_written;
use crate::job::{self, FIELD_CELLS, JobError, PlanOutcome, PlanRequest};
use crate::monitor::{Cancelled, Monitor};
use crate::setup::Setup;
use crate::toolpath::ClProgram;
use crate::verify::{count_by_kind, report_plunges};

/// Significant digits of figures.
const DIGITS: usize = 10;

/// Plans a run. Whatever goes wrong with it is its result.
///
/// # Errors
/// [`Cancelled`] after a stop or cancel of `monitor`: a plan that was cut short is not a result.
pub(super) fn evaluate(
    list: &RunList,
    run: &Run,
    input: RunInput<'_>,
    monitor: &Monitor,
) -> Result<RunResult, Cancelled> {
    let started = std::time::Instant::now();
    let keys = list.keys().into_iter().map(str::to_owned);
    let mut result = RunResult {
        vanecut_study_run: RESULT_VERSION,
        program: PROGRAM_VERSION.to_owned(),
        id: run.id.clone(),
        part: input.part.shown.clone(),
        part_hash: input.part.hash.clone(),
        varied: keys.zip(list.values(&run.choice).into_iter().cloned()).collect(),
        setup: input.setup_text,
        status: RunStatus::Error,
        error: None,
        policy: None,
        tools: Vec::new(),
        figures: FIGURES.iter().map(|name| ((*name).to_owned(), None)).collect(),
        elapsed: 0.0,
    };
    let planned = match input.setup {
        Err(fault) => Err(fault),
        Ok(setup) => match caught(|| plan(input.part.part.clone(), setup, monitor)) {
            Ok(Err(JobError::Cancelled)) => return Err(Cancelled),
            Ok(Err(JobError::Setup(fault))) => Err(fault.into()),
            Ok(Ok(outcome)) => judge(&outcome, &mut result, monitor),
            Err(defect) => Err(defect),
        },
    };
    if let Err(fault) = planned {
        result.status = RunStatus::Error;
        result.error = Some(fault.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
    }
    monitor.check()?;
    result.elapsed = started.elapsed().as_secs_f64();
    Ok(result)
}

/// What `planning` returns, or the fault of a planner that panics: one run must not end the others.
fn caught<T>(planning: impl FnOnce() -> T) -> Result<T, UserError> {
    catch_unwind(AssertUnwindSafe(planning)).map_err(|_| {
        UserError::new(ErrorCode::Defect, "the planner failed on this input", "report it with the part")
    })
}

fn plan(part: Arc<crate::part::Impeller>, setup: Setup, monitor: &Monitor) -> Result<PlanOutcome, JobError> {
    let policy = setup.plunge.axis;
    job::run(&PlanRequest { part, setup, policy, compare: false, field_cells: FIELD_CELLS }, monitor)
}

/// Takes the figures from the program as it would be written, as `vanecut plan` does.
fn judge(outcome: &PlanOutcome, result: &mut RunResult, monitor: &Monitor) -> Result<(), UserError> {
    let (part, plan) = (&outcome.workpiece.part, &outcome.after.plan);
    let program = as_written("", &ClProgram::of_plan(&part.name, plan))?;
    let report =
        report_plunges(&outcome.workpiece, &outcome.setup, &program, FIELD_CELLS, &monitor.silent())?;
    let (summary, faults) = (&report.summary, &report.verdict.faults);
    let sections = || report.verdict.sections.iter().filter(|section| section.is_cut());
    let figures: [f64; FIGURES.len()] = [
        summary.positions as f64,
        report.verdict.rows() as f64,
        sections().count() as f64,
        summary.time_estimate,
        outcome.after.summary.machine_time.map_or(f64::NAN, |time| time.total_s),
        summary.residual_mean,
        summary.residual_p95,
        summary.residual_max,
        summary.uncut_share,
        summary.inaccessible_share,
        summary.interfering as f64,
        summary.max_contact_depth,
        faults.len() as f64,
        // A program does not contain blocked positions.
        outcome.after.summary.blocked.map_or(f64::NAN, |blocked| blocked as f64),
        summary.min_hub_clearance,
        summary.min_blade_clearance,
        summary.min_retract_clearance,
        summary.max_axis_change_rad.to_degrees(),
        summary.cut_length,
        summary.rapid_length,
        plan.iterations as f64,
    ];
    let named = FIGURES.iter().zip(figures).map(|(name, value)| ((*name).to_owned(), rounded(value)));
    result.figures = named.collect::<BTreeMap<_, _>>();
    result.policy = Some(plan.policy.name().to_owned());
    result.tools = sections().map(|section| section.tool.diameter).collect();
    result.status = match (faults.is_empty(), plan.converged) {
        (false, _) => RunStatus::Faults,
        (true, false) => RunStatus::NotConverged,
        (true, true) => RunStatus::Done,
    };
    if let Some(first) = faults.first() {
        result.error = Some(format!("{first}; in all {}", count_by_kind(faults)));
    }
    Ok(())
}

/// A figure with as many digits as survive any reader; none where it is not finite.
fn rounded(value: f64) -> Option<f64> {
    let digits = DIGITS - 1;
    value.is_finite().then(|| format!("{value:.digits$e}").parse().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planner_that_panics_is_a_defect() {
        assert_eq!(caught(|| 3), Ok(3));
        let failed: Result<(), UserError> = caught(|| panic!("as a planner might"));
        assert_eq!(failed.map_err(|defect| defect.code), Err(ErrorCode::Defect));
    }
}
