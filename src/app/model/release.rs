//! What speaks against running a program, asked about before it leaves the window.

use crate::plunge::DropReason;
use crate::setup::{TILT_TOLERANCE, falls_short};

use crate::app::model::field_faults::ReplacedValue;
use crate::app::model::figures::{MAX_GOOD_UNCUT_SHARE, format_percent, policy_label};
use crate::app::model::file_purpose::Purpose;
use crate::app::model::flank_skips::skipped_length;
use crate::app::model::look::Operation;
use crate::app::model::state::AppState;
use crate::app::model::verdict::uncut_words;
use crate::report::words::{as_sentence, counted};
use crate::verify::Fault;

const STALE: &str = "The setup was edited after this calculation";
const UNFINISHED: &str = "The calculation was cancelled: this is the best plan so far";

/// What speaks against running the program of `channels` channels that `purpose` writes, the gravest first;
/// none for other files.
pub fn concerns(state: &AppState, purpose: Purpose, channels: usize) -> Vec<String> {
    // No machine runs a model of the plan, but it may show another setup.
    match purpose {
        Purpose::ExportScene { .. } => return model_concerns(state, state.out_of_date()),
        Purpose::ExportStock { .. } => {
            let is_stale = state.operation_is_stale();
            let after_roughing = state.look.operation == Operation::Flank && state.out_of_date();
            return model_concerns(state, is_stale || after_roughing);
        }
        _ => {}
    }
    // Plans are those of one channel, and so is what is counted in them.
    let each = if channels > 1 { " in each channel" } else { "" };
    let mut found = match purpose.planned_operation() {
        Some(Operation::Roughing) => plunge_concerns(state, each),
        Some(Operation::Flank) => flank_concerns(state, each),
        Some(Operation::Program) | None => return Vec::new(),
    };
    // The post refuses such a program by itself.
    let is_apt = matches!(purpose, Purpose::ExportCl { .. } | Purpose::ExportFlank { .. });
    if is_apt && purpose.planned_operation() == Some(state.look.operation) {
        let on_machine = state.on_machine();
        let fault = on_machine.and_then(|on_machine| Some((on_machine, on_machine.fault.as_ref()?)));
        found.extend(fault.map(|(on, (what, _))| format!("{} cannot run it: {what}", on.machine.name)));
    }
    found.extend(faulty_values(state));
    found
}

/// Faulty values of the setup in the project that are named.
const MAX_NAMED: usize = 3;

/// What is said of faulty values of the setup in the project, the first by name.
pub fn faulty_values(state: &AppState) -> Option<String> {
    let replaced = &state.document.edited.replaced;
    let names: Vec<String> = replaced.iter().take(MAX_NAMED).map(ReplacedValue::name).collect();
    let names = match replaced.len() - names.len() {
        0 => names.join(", "),
        more => format!("{} and {more} more", names.join(", ")),
    };
    match replaced.len() {
        0 => None,
        1 => Some(format!(
            "1 value of the setup in the project was faulty: the default stands in its place ({names})"
        )),
        n => Some(format!(
            "{n} values of the setup in the project were faulty: defaults stand in their place ({names})"
        )),
    }
}

/// What speaks against a model of a plan: it is that of another setup, or not all of the plan.
fn model_concerns(state: &AppState, is_stale: bool) -> Vec<String> {
    let is_unfinished = state.results.planned.as_ref().is_some_and(|planned| planned.is_unfinished());
    let found = [(is_stale, STALE), (is_unfinished, UNFINISHED)];
    found.into_iter().filter(|(is_so, _)| *is_so).map(|(_, words)| words.to_owned()).collect()
}

fn plunge_concerns(state: &AppState, each: &str) -> Vec<String> {
    let Some(shown) = state.last_whole_plan(state.look.side) else { return Vec::new() };
    let (plan, summary) = (shown.plan(), &shown.planned.result(shown.policy).summary);
    let (allowances, units) = (&shown.planned.outcome.setup.allowances, state.look.units);
    let mut found = Vec::new();
    let wanted = shown.planned.setup.plunge.axis;
    if shown.policy != wanted {
        let [shown, wanted] = [shown.policy, wanted].map(policy_label);
        found.push(format!("The axis strategy is {shown}, not {wanted} as in the setup"));
    }
    if summary.interfering > 0 {
        found.push(format!(
            "The core meets stock in {} of {} plunges{each}, up to {} deep",
            summary.interfering,
            summary.positions,
            units.length(summary.max_contact_depth, 2)
        ));
    }
    for (name, kept, wanted) in [
        ("hub", summary.min_hub_clearance, allowances.hub_allowance),
        ("blades", summary.min_blade_clearance, allowances.blade_allowance),
        ("blank at retracts", summary.min_retract_clearance, allowances.safety_distance),
    ] {
        if falls_short(kept, wanted) {
            let (kept, unit) = (units.length(kept, 3), units.length_unit());
            found.push(format!("Clearance to {name} is {kept}, less than {} {unit}", units.short(wanted, 6)));
        }
    }
    let part = &shown.planned.outcome.workpiece.part;
    let machine = &shown.planned.outcome.setup.machine;
    let beyond =
        plan.positions.iter().filter(|p| machine.excess_tilt_rad(part, &p.axis) > TILT_TOLERANCE).count();
    if beyond > 0 {
        found.push(format!("{beyond} tool axes{each} are beyond the reach of the machine"));
    }
    found.extend(allowances.tool_remarks(plan.tools()).into_iter().map(as_sentence));
    if state.out_of_date() {
        found.push(STALE.to_owned());
    }
    if let Some(missed) = state.missed_goal() {
        found.push(missed);
    }
    found.extend(state.unapplied_words());
    if plan.is_unfinished() {
        found.push(UNFINISHED.to_owned());
    } else if !plan.converged {
        found.push("The calculation stopped at its limit of iterations before it converged".to_owned());
    }
    for why in DropReason::ALL {
        let count = plan.dropped.iter().filter(|dropped| dropped.why == why).count();
        if count > 0 {
            found.push(format!("Skipped positions {}: {count}{each}", why.words()));
        }
    }
    if summary.uncut_share > MAX_GOOD_UNCUT_SHARE {
        found
            .push(format!("{} of the accessible floor is not machined", format_percent(summary.uncut_share)));
    }
    found
}

/// The first faults of a program, which is judged as it is written in APT, and how many more there are.
pub fn fault_lines(faults: &[Fault]) -> Vec<String> {
    let line = |fault: &Fault| format!("Line {} of the APT program: {fault}", fault.line);
    let mut lines: Vec<String> = faults.iter().take(3).map(line).collect();
    match faults.len() - lines.len() {
        0 => {}
        more => lines.push(counted(more, "more fault", "more faults")),
    }
    lines
}

fn flank_concerns(state: &AppState, each: &str) -> Vec<String> {
    let Some(outcome) = &state.results.flank else { return Vec::new() };
    let mut found = fault_lines(&outcome.faults);
    if outcome.verdict.is_none() {
        found.push("The program could not be verified".to_owned());
    }
    found.extend(outcome.verdict.iter().flat_map(uncut_words).map(|[_, full]| full));
    let allowances = &outcome.setup.allowances;
    found.extend(allowances.tool_remarks(outcome.plan.tools()).into_iter().map(as_sentence));
    if state.flank_is_stale() {
        found.push(STALE.to_owned());
    }
    let lost = || skipped_length(&outcome.plan.uncut, state.look.units);
    match outcome.plan.uncut.len() {
        0 => {}
        1 => found.push(format!("1 stretch of a pass is left out{each}, {}", lost())),
        n => found.push(format!("{n} stretches of passes are left out{each}, together {}", lost())),
    }
    found
}
