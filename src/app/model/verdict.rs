//! The worst of what is known of a plan: what colours the headline, and what the list of operations says.

use crate::job::PolicyResult;
use crate::job::flank::FlankOutcome;
use crate::plunge::Condition;
use crate::report::words::{NOT_ON_MACHINE, counted};
use crate::verify::FlankVerdict;

use super::figures::{MAX_GOOD_UNCUT_SHARE, format_percent};
use super::state::AppState;

/// Number of faults of an operation, in words.
pub fn count_faults(count: usize) -> String {
    counted(count, "fault", "faults")
}

/// Number of stretches of passes that are not cut, in words.
pub fn count_skipped_stretches(count: usize) -> String {
    format!("{} skipped", count_stretches(count))
}

/// Number of stretches of flank passes, in words.
pub fn count_stretches(count: usize) -> String {
    counted(count, "stretch", "stretches")
}

/// Number of faulty values of the setup in the file, in whose place defaults stand, in words.
fn faulty_values(state: &AppState) -> Option<String> {
    let count = state.document.edited.replaced.len();
    (count > 0).then(|| counted(count, "faulty value", "faulty values"))
}

/// The verdict on a plunge plan, and what is wrong with it, if anything is.
pub fn of_plunges(state: &AppState, result: &PolicyResult) -> (Condition, Option<String>) {
    let PolicyResult { plan, summary, .. } = result;
    let interfering = plan.count_interfering();
    let words = if plan.is_unfinished() {
        "unfinished".to_owned()
    } else if interfering > 0 {
        count_faults(interfering)
    } else if summary.is_refused {
        NOT_ON_MACHINE.to_owned()
    } else if let Some(words) = faulty_values(state) {
        words
    } else if !plan.converged {
        "not converged".to_owned()
    } else if state.missed_goal().is_some() {
        "goal cannot be met".to_owned()
    } else if let Some(words) = state.unapplied_words() {
        words
    } else if !plan.dropped.is_empty() {
        format!("{} skipped", plan.dropped.len())
    } else if summary.uncut_share > MAX_GOOD_UNCUT_SHARE {
        format!("{} not machined", format_percent(summary.uncut_share))
    } else {
        return (Condition::Sound, None);
    };
    (if interfering > 0 { Condition::Interfering } else { Condition::Blocked }, Some(words))
}

/// What a flank program leaves of floor and walls, where that is more than it may without a warning: in
/// short, and in full.
pub fn uncut_words(verdict: &FlankVerdict) -> impl Iterator<Item = [String; 2]> + use<> {
    let shares = [
        (verdict.layer.uncut_share.into(), "not machined", "of the accessible floor is not machined"),
        (
            verdict.uncovered.gap,
            "of the floor in gaps",
            "of the floor keeps more than the scallop height, in gaps between passes",
        ),
        (verdict.unmilled_wall_share, "of the walls not milled", "of the walls is not milled"),
    ];
    let many = shares.into_iter().filter(|(share, ..)| *share > MAX_GOOD_UNCUT_SHARE);
    many.map(|(share, short, full)| [short, full].map(|words| format!("{} {words}", format_percent(share))))
}

/// Whether a flank program leaves no more of floor and walls than it may without a warning.
pub fn is_flank_complete(verdict: &FlankVerdict) -> bool {
    uncut_words(verdict).next().is_none()
}

/// The verdict on a flank plan, and what is wrong with it, if anything is.
pub fn of_flank(state: &AppState, outcome: &FlankOutcome) -> (Condition, Option<String>) {
    let (faults, skipped) = (outcome.faults.len(), outcome.plan.uncut.len());
    if faults > 0 {
        (Condition::Interfering, Some(count_faults(faults)))
    } else if let Some(words) = faulty_values(state) {
        (Condition::Blocked, Some(words))
    } else if outcome.verdict.is_none() {
        (Condition::Blocked, Some("not verified".to_owned()))
    } else if skipped > 0 {
        (Condition::Blocked, Some(count_skipped_stretches(skipped)))
    } else if let Some([words, _]) = outcome.verdict.iter().flat_map(uncut_words).next() {
        (Condition::Blocked, Some(words))
    } else {
        (Condition::Sound, None)
    }
}
