//! Figures of a program in words, the same in documents and on the command line.

use crate::job::{PlanOutcome, PolicyResult};
use crate::setup::Goal;
use crate::verify::Summary;

/// `count` with the word for one, or for several.
pub fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// A text that begins with a capital letter, unless it begins with a name.
pub fn as_sentence(text: String) -> String {
    let word = text.split([' ', ',']).next().unwrap_or_default();
    if word.is_empty() || !word.bytes().all(|byte| byte.is_ascii_lowercase()) {
        return text;
    }
    let (first, rest) = text.split_at(1);
    first.to_ascii_uppercase() + rest
}

/// Text for the number of channels of a program.
pub fn channels_text(count: usize) -> String {
    if count == 1 { "one channel".to_owned() } else { format!("all {count} channels of the program") }
}

/// How often tools are loaded in a program.
pub fn tool_loads_text(count: usize) -> String {
    if count == 1 { "one tool is loaded once".to_owned() } else { format!("tools are loaded {count} times") }
}

/// Instead of the time of a plan that the machine of the setup cannot run.
pub const NOT_ON_MACHINE: &str = "not on this machine";

/// Best known time of a plan, min; NaN as of [`Summary::time_s`].
pub fn minutes(summary: &Summary) -> f64 {
    summary.time_s() / 60.0
}

/// The same in words.
pub fn minutes_text(summary: &Summary) -> String {
    if summary.is_refused { NOT_ON_MACHINE.to_owned() } else { format!("{:.1}", minutes(summary)) }
}

/// Text on clearances, axis change, lengths and time of a program of `channels` channels.
pub fn clearances_text(s: &Summary, channels: usize) -> String {
    format!(
        "least clearance: hub {:.4} mm, blades {:.4} mm, retracts {:.3} mm; \
         axis change up to {:.1}° within a row\n\
         {:.0} mm cut, {:.0} mm in rapid, about {:.0} min for {}, {:.0} of them under feed (tool changes and \
         accelerations left out)\n",
        s.min_hub_clearance,
        s.min_blade_clearance,
        s.min_retract_clearance,
        s.max_axis_change_rad.to_degrees(),
        s.cut_length,
        s.rapid_length,
        s.time_estimate / 60.0,
        channels_text(channels),
        s.feed_time / 60.0,
    )
}

/// A line on the time that semi-finishing takes after `result`, one of the results of `outcome`; `None` where
/// the goal does not count it.
pub fn finishing_text(outcome: &PlanOutcome, result: &PolicyResult) -> Option<String> {
    let finishing_min = outcome.finishing_time_s(result)? / 60.0;
    let together = minutes(&result.summary) + finishing_min;
    Some(format!(
        "semi-finishing takes about {finishing_min:.1} min per channel, together with plunging {together:.1} min"
    ))
}

/// Length of passes that are not cut, from mm, which `length` writes with one decimal.
pub fn left_out_text(length_mm: f64, length: impl Fn(f64) -> String) -> String {
    /// Shorter ones would be written as 0.0, mm.
    const SHORT_MM: f64 = 0.1;
    match length_mm < SHORT_MM {
        true => format!("less than {}", length(SHORT_MM)),
        false => length(length_mm),
    }
}

/// What keeps the plan of `outcome` from its goal, with lengths written by `length` (from mm); `None` where
/// the goal is met, and of an unfinished plan: the finished one may meet it.
pub fn missed_goal(outcome: &PlanOutcome, length: impl Fn(f64) -> String) -> Option<String> {
    if !outcome.misses_goal || outcome.after.plan.is_unfinished() {
        return None;
    }
    let summary = &outcome.after.summary;
    match outcome.setup.plunge.goal {
        Goal::Stock { max_time_min: Some(limit) } => Some(format!(
            "goal cannot be met: the fastest plan takes {:.1} min, the limit is {limit:.1} min",
            minutes(summary)
        )),
        Goal::Time { max_stock } => Some(format!(
            "goal cannot be met: the plan with the least stock leaves {} above the allowance (95 %), the limit is {}",
            length(summary.residual_p95 - outcome.setup.allowances.hub_allowance),
            length(max_stock),
        )),
        Goal::Stock { max_time_min: None } | Goal::Balance | Goal::Total { .. } => None,
    }
}
