//! `vanecut plan --pareto`: time against stock.

use serde_json::{Value, json};

use super::Failure;
use super::output::number;
use super::watch::run_with_progress;
use crate::error::ErrorCode;
use crate::job::{PlanOutcome, PolicyResult};
use crate::monitor::Monitor;
use crate::report::words::{NOT_ON_MACHINE, minutes};
use crate::setup::{AxisPolicy, Goal};

/// Checks that a plan by `policy` has a curve.
///
/// # Errors
/// [`Failure::input`] when it is not `minimal`.
pub fn check_policy(policy: AxisPolicy) -> Result<(), Failure> {
    if policy == AxisPolicy::Minimal {
        return Ok(());
    }
    let help = "leave --axis out, or give --axis minimal";
    Err(Failure::input(ErrorCode::Arguments, "--pareto needs a plan of minimal", help))
}

/// At most `count` plans between the least stock and the least time.
///
/// # Errors
/// [`Failure::work`] when stopped.
pub fn time_stock_curve(outcome: &PlanOutcome, count: usize) -> Result<Vec<PolicyResult>, Failure> {
    let find = |monitor: &Monitor| outcome.time_stock_curve(count, monitor);
    run_with_progress("weighing the plunges", find).map_err(Failure::of_work)
}

/// A point of the curve as a JSON object: mm, s.
pub fn point_object(result: &PolicyResult, outcome: &PlanOutcome) -> Value {
    let s = &result.summary;
    json!({
        "time_estimate": number(s.time_estimate),
        "machine_time": s.machine_time.map(|time| number(time.total_s)),
        "finish_time": outcome.finishing_time_s(result).map(number),
        "positions": s.positions,
        "interferential": s.interfering,
        "residual_mean": number(s.residual_mean),
        "residual_p95": number(s.residual_p95),
        "uncut_share": number(s.uncut_share),
    })
}

/// The curve as a table, with the other policies beside it.
pub fn curve_text(curve: &[PolicyResult], outcome: &PlanOutcome) -> String {
    let machine = outcome.clock.machine().filter(|_| outcome.after.summary.machine_time.is_some());
    let counts_finishing = matches!(outcome.setup.plunge.goal, Goal::Total { .. });
    let line = |name: &str, result: &PolicyResult| {
        let s = &result.summary;
        let finishing = outcome.finishing_time_s(result).filter(|_| !s.is_refused);
        let total = finishing.map(|finishing| minutes(s) + finishing / 60.0);
        format!(
            "{name:<12} {:>9}{} {:>10} {:>13} {:>16} {:>12.1}{}\n",
            if s.is_refused { "-".to_owned() } else { format!("{:.1}", minutes(s)) },
            match (counts_finishing, total) {
                (false, _) => String::new(),
                (true, Some(total)) => format!(" {total:>10.1}"),
                (true, None) => format!(" {:>10}", "-"),
            },
            s.positions,
            s.interfering,
            format!("{:.2} / {:.2}", s.residual_mean, s.residual_p95),
            100.0 * s.uncut_share,
            if s.is_refused { format!("  {NOT_ON_MACHINE}") } else { String::new() },
        )
    };
    let on_machine = machine.map_or(String::new(), |machine| format!(" on {}", machine.name));
    let mut text = format!(
        "\ntime against stock, one channel{on_machine}\n{:<12} {:>9}{} {:>10} {:>13} {:>16} {:>12}\n",
        "plan",
        "time, min",
        if counts_finishing { " total, min" } else { "" },
        "positions",
        "core contact",
        "stock mean/95 %",
        "uncut, %"
    );
    for (number, point) in curve.iter().enumerate() {
        text += &line(&format!("minimal {}", number + 1), point);
    }
    for result in outcome.policies().iter().filter(|result| result.plan.policy != AxisPolicy::Minimal) {
        text += &line(result.plan.policy.name(), result);
    }
    text
}
