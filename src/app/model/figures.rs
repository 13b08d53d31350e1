//! Figures of plans as texts, and the limits of what counts as good.

use std::sync::Arc;

use crate::job::flank::FlankOutcome;
use crate::job::{PolicyResult, Summary};
use crate::plunge::Condition;
use crate::report::words::NOT_ON_MACHINE;
use crate::setup::AxisPolicy;

use crate::app::model::units::DisplayUnits;

/// Label of an axis strategy.
pub fn policy_label(policy: AxisPolicy) -> &'static str {
    match policy {
        AxisPolicy::Conventional => "Isoparametric",
        AxisPolicy::Monotone => "Progressive",
        AxisPolicy::Minimal => "Min. stock",
        AxisPolicy::Staircase => "Stepped",
    }
}

/// What an axis strategy does, and its name in files and on the command line, which is another.
pub fn policy_tip(policy: AxisPolicy) -> &'static str {
    match policy {
        AxisPolicy::Conventional => {
            "Isoparametric axes, unchanged.\nIn files and on the command line: conventional"
        }
        AxisPolicy::Monotone => {
            "Progressive lead: the lead angle grows from position to position.\n\
             In files and on the command line: monotone"
        }
        AxisPolicy::Minimal => {
            "Minimum stock: the least stock on the hub without core contact.\n\
             In files and on the command line: minimal"
        }
        AxisPolicy::Staircase => {
            "Stepped depth: isoparametric axes, plunges end above contact.\n\
             In files and on the command line: staircase"
        }
    }
}

/// Largest share of the accessible floor that may stay uncut without a warning, or in gaps between flank
/// passes.
pub const MAX_GOOD_UNCUT_SHARE: f64 = 0.03;

/// Name of the share of the floor that a flank program leaves above the scallop height, and what it is.
pub const ABOVE_SCALLOP: &str = "Floor above scallop";
/// See [`ABOVE_SCALLOP`].
pub const ABOVE_SCALLOP_TIP: &str = "Share of the floor that keeps more stock than the scallop height";

/// What makes a plunge interfere.
pub const INTERFERING_TIP: &str =
    "Plunges whose core meets stock, or that exceed an allowance or the reach of the machine";

/// How many plunges interfere in the plans before and after. Where some of them do for a limit alone, the
/// number of those whose core meets stock is named too: documents and the command line list these by
/// themselves.
pub fn interfering_words(sides: [&PolicyResult; 2]) -> String {
    let [before, after] = sides.map(|result| result.plan.count_interfering());
    let contact = sides.map(|result| result.summary.interfering);
    let words = match [before, after] {
        [0, 0] => return "No plunge interferes".to_owned(),
        [before, after] => format!("Interfering plunges {before} to {after}"),
    };
    match contact == [before, after] {
        true => words,
        false => format!("{words} (core contact {} to {})", contact[0], contact[1]),
    }
}

/// A share of classes in whole per cent; what is not none or all does not look so.
pub fn format_class_share(share: f64) -> String {
    /// Rounding of sums.
    const NONE: f64 = 1e-9;
    match 100.0 * share {
        percent if percent < 0.5 && share > NONE => "< 1 %".to_owned(),
        percent if percent > 99.5 && share < 1.0 - NONE => "> 99 %".to_owned(),
        percent => format!("{percent:.0} %"),
    }
}

impl Condition {
    /// Name on screen.
    pub fn label(self) -> &'static str {
        match self {
            Self::Sound => "OK",
            Self::Blocked => "blocked",
            Self::Interfering => "interfering",
        }
    }
}

/// Mean and 95th percentile of the residual stock, without their unit.
pub fn format_residual(summary: &Summary, units: DisplayUnits) -> String {
    units.pair(summary.residual_mean, summary.residual_p95, 2)
}

/// A share in per cent.
pub fn format_percent(share: f64) -> String {
    if share.is_finite() { format!("{:.1} %", 100.0 * share) } else { "-".to_owned() }
}

/// Duration in s, min or h, from seconds.
pub fn format_duration(seconds: f64) -> String {
    DurationUnit::for_all([seconds]).text(seconds)
}

/// Unit of durations that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DurationUnit {
    /// s.
    Second,
    /// min.
    Minute,
    /// h.
    Hour,
}

impl DurationUnit {
    /// The unit that suits the shortest of `seconds`; plans that take no time do not count.
    pub fn for_all(seconds: impl IntoIterator<Item = f64>) -> Self {
        let known = seconds.into_iter().filter(|seconds| seconds.is_finite() && *seconds > 0.0);
        match known.fold(f64::INFINITY, f64::min) / 60.0 {
            minutes if minutes.is_infinite() => Self::Minute,
            minutes if minutes < 1.0 => Self::Second,
            minutes if minutes < 90.0 => Self::Minute,
            _ => Self::Hour,
        }
    }

    /// A duration in this unit, from seconds.
    pub fn text(self, seconds: f64) -> String {
        if !seconds.is_finite() || seconds < 0.0 {
            return "-".to_owned();
        }
        // Without the sign of a zero.
        let seconds = seconds.abs();
        match self {
            Self::Second => format!("{seconds:.0} s"),
            Self::Minute => format!("{:.0} min", seconds / 60.0),
            Self::Hour => format!("{:.1} h", seconds / 3600.0),
        }
    }
}

/// Units of the times of channels and of wheels that are compared.
#[derive(Clone, Copy, Debug)]
pub struct TimeUnits {
    /// Of channels.
    pub channel: DurationUnit,
    /// Of wheels.
    pub wheel: DurationUnit,
}

impl TimeUnits {
    /// Those of times of channel and wheel, from seconds.
    pub fn for_all(times: &[(f64, f64)]) -> Self {
        Self {
            channel: DurationUnit::for_all(times.iter().map(|(channel, _)| *channel)),
            wheel: DurationUnit::for_all(times.iter().map(|(_, wheel)| *wheel)),
        }
    }

    /// Those of plunge plans for a wheel of `channels` channels.
    pub fn of_plans<'a>(summaries: impl IntoIterator<Item = &'a Summary>, channels: usize) -> Self {
        let known = summaries.into_iter().filter(|summary| !summary.is_refused);
        let times: Vec<(f64, f64)> = known.map(|summary| plan_times(summary, channels)).collect();
        Self::for_all(&times)
    }

    /// Time of one channel, and of the whole wheel; from seconds.
    pub fn text(self, channel_s: f64, wheel_s: f64) -> String {
        format!("{} per channel, {} wheel", self.channel.text(channel_s), self.wheel.text(wheel_s))
    }

    /// Time of a plunge plan for one channel, and for the whole wheel of `channels` channels.
    pub fn plan_text(self, summary: &Summary, channels: usize) -> String {
        if summary.is_refused {
            return NOT_ON_MACHINE.to_owned();
        }
        let (channel_s, wheel_s) = plan_times(summary, channels);
        self.text(channel_s, wheel_s)
    }
}

fn plan_times(summary: &Summary, channels: usize) -> (f64, f64) {
    (summary.time_s(), summary.time_of_channels_s(channels, channels))
}

/// Time of one channel, and of the whole wheel; from seconds.
pub fn format_times(channel_s: f64, wheel_s: f64) -> String {
    TimeUnits::for_all(&[(channel_s, wheel_s)]).text(channel_s, wheel_s)
}

/// Time of a plunge plan for one channel, and for the whole wheel of `channels` channels.
pub fn format_plan_times(summary: &Summary, channels: usize) -> String {
    TimeUnits::of_plans([summary], channels).plan_text(summary, channels)
}

/// A plan of one channel, for the time of its program in several.
#[derive(Clone, Debug)]
pub enum TimedPlan {
    /// Of plunges, by its figures.
    Plunges(Box<Summary>),
    /// A flank plan.
    Flank(Arc<FlankOutcome>),
}

impl TimedPlan {
    /// Time of its program for the first `count` of `channels` channels, and whether that counts tool
    /// changes; `None` where it is not known.
    pub fn program_time(&self, count: usize, channels: usize) -> Option<String> {
        let (time_s, on_machine) = match self {
            Self::Plunges(summary) => {
                (Some(summary.time_of_channels_s(count, channels)), summary.machine_time.is_some())
            }
            Self::Flank(outcome) => (outcome.time_of_channels_s(count), outcome.machine_time.is_some()),
        };
        let changes = if on_machine { "with" } else { "without" };
        Some(format!("Time {}, {changes} tool changes", format_duration(time_s?)))
    }
}

/// What times count that are those of the machine.
const ON_MACHINE: &str = "On the machine of the setup, with accelerations and tool changes";

/// What [`format_plan_times`] counts.
pub fn times_tip(summary: &Summary) -> &'static str {
    match summary.machine_time {
        Some(_) => ON_MACHINE,
        None if summary.is_refused => {
            "The machine of the setup, which runs the plan that was asked for, cannot run this one"
        }
        None => "From plunge feed rates and rapids; without tool changes",
    }
}

/// What the times of a flank plan count.
pub fn flank_times_tip(outcome: &FlankOutcome) -> &'static str {
    match (outcome.machine_time, &outcome.clock) {
        (Some(_), _) => ON_MACHINE,
        (None, Some(_)) => "From feed rates and rapids: the machine of the setup cannot run the program",
        (None, None) => "From feed rates and rapids; without tool changes",
    }
}

/// Time as h:mm:ss, from seconds.
pub fn format_clock(seconds: f64) -> String {
    let whole = seconds.round().clamp(0.0, 1e9) as u64;
    format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}

#[cfg(test)]
mod tests {
    use super::{DurationUnit, TimeUnits, format_duration, policy_tip};
    use crate::setup::AxisPolicy;

    #[test]
    fn times_that_are_compared_have_one_unit() {
        assert_eq!(format_duration(5400.0), "1.5 h", "alone");
        let units = TimeUnits::for_all(&[(5400.0, 33_480.0), (2640.0, 15_480.0)]);
        assert_eq!(units.text(5400.0, 33_480.0), "90 min per channel, 9.3 h wheel");
        assert_eq!(units.text(2640.0, 15_480.0), "44 min per channel, 4.3 h wheel");
        assert_eq!(DurationUnit::for_all([f64::NAN, 30.0]), DurationUnit::Second);
        assert_eq!(DurationUnit::Minute.text(f64::NAN), "-");
        assert_eq!(DurationUnit::for_all([0.0, 5400.0]), DurationUnit::Hour);
        assert_eq!(format_duration(-0.0), "0 min");
    }

    #[test]
    fn the_tip_of_a_strategy_has_its_name_in_files() {
        for policy in AxisPolicy::ALL {
            let tip = policy_tip(policy);
            assert!(tip.ends_with(&format!("In files and on the command line: {}", policy.name())), "{tip}");
        }
    }
}
