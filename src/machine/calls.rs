//! Programs that another one calls once a channel, each time with the part turned on.

use std::f64::consts::TAU;

use super::model::{AxisSide, MachineTool, OutputKind};
use crate::error::{ErrorCode, UserError};
use crate::geometry::without_conversion_error;
use crate::setup::ChannelSequence;

/// Least |z| of the direction of an axis that turns the part about its own axis.
const VERTICAL: f64 = 1.0 - 1e-9;
/// Distance of the part's axis from that of its table below which they are the same, mm.
const CENTRED: f64 = 1e-3;

/// Turns that are looked at where the number of channels is not known.
const UNKNOWN_CALLS: usize = 24;

/// How often a program is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelCalls {
    /// Once: it mills this many channels itself.
    Once {
        /// The channels.
        channels: usize,
    },
    /// Once for each channel of a part.
    EachChannel {
        /// The channels of the part.
        count: usize,
        /// How they follow each other.
        sequence: ChannelSequence,
    },
    /// Once a channel of a part that is not known.
    Unknown,
}

/// Decimals of an angle in words, degrees.
const ANGLE_DECIMALS: usize = 4;
/// Longest line of a comment on the calls.
const MAX_COMMENT: usize = 60;

impl ChannelCalls {
    /// Those of a program for `channels` channels of a part with `channel_count`: one of several channels is
    /// called once, as it is not turned on from channel to channel.
    pub fn for_channels(channels: usize, channel_count: usize, sequence: ChannelSequence) -> Self {
        if channels > 1 {
            Self::Once { channels }
        } else {
            Self::EachChannel { count: channel_count.max(1), sequence }
        }
    }

    /// Number of calls, if it is known.
    pub fn count(self) -> Option<usize> {
        match self {
            Self::Once { .. } => Some(1),
            Self::EachChannel { count, .. } => Some(count.max(1)),
            Self::Unknown => None,
        }
    }

    /// Turn from channel to channel, rad, if it is known.
    pub fn turn_rad(self) -> Option<f64> {
        self.count().map(|count| TAU / count as f64)
    }

    /// Turn of the work offset in each call, degrees, in the sequence of the calls; `None` if it is not
    /// known.
    pub fn offsets_deg(self) -> Option<Vec<f64>> {
        let (count, sequence) = match self {
            Self::Once { .. } => (1, ChannelSequence::Adjacent),
            Self::EachChannel { count, sequence } => (count.max(1), sequence),
            Self::Unknown => return None,
        };
        let turn = |channel: usize| without_conversion_error(360.0 * channel as f64 / count as f64);
        Some(sequence.channels(count).into_iter().map(turn).collect())
    }

    /// Turn from the first to the last call, rad; less than a whole turn.
    pub fn whole_turn_rad(self) -> f64 {
        self.count().map_or(TAU, |count| TAU * (count - 1) as f64 / count as f64)
    }

    /// How often the program is to be called, and by how much the work offset turns in each call; `None` if
    /// that is not known.
    pub fn words(self) -> Option<String> {
        self.text(|angles| {
            let angles: Vec<String> = angles.iter().map(|angle| format!("{angle}°")).collect();
            angles.join(", ")
        })
    }

    /// The same for the head of a program, in lines that a control can show.
    pub fn comments(self) -> Vec<String> {
        let text = self.text(|angles| format!("{} deg", angles.join(", "))).unwrap_or_default();
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut().filter(|line| line.len() + word.len() < MAX_COMMENT) {
                Some(line) => *line += &format!(" {word}"),
                None => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// The words; `list` joins angles, which are in degrees.
    fn text(self, list: impl Fn(&[String]) -> String) -> Option<String> {
        let angle = |degrees: f64| {
            let text = format!("{degrees:.ANGLE_DECIMALS$}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        };
        let offsets: Vec<String> = self.offsets_deg()?.into_iter().map(angle).collect();
        Some(match self {
            Self::Once { channels } => format!("to be called once, for its {channels} channels"),
            Self::EachChannel { .. } if offsets.len() == 1 => "to be called once".to_owned(),
            Self::EachChannel { count, sequence: ChannelSequence::Adjacent } => {
                let step = list(&[angle(360.0 / count as f64)]);
                format!(
                    "to be called {count} times, the work offset turned on by {step} each time, to {}",
                    list(&offsets)
                )
            }
            Self::EachChannel { count, .. } => {
                format!("to be called {count} times, the work offset turned to {}", list(&offsets))
            }
            Self::Unknown => return None,
        })
    }
}

impl MachineTool {
    /// Whether the first rotary axis turns the part about the part's own axis.
    fn turns_part(&self) -> bool {
        let first = &self.rotary[0];
        let off = first.point - self.part.origin;
        first.side == AxisSide::Table && first.direction.z.abs() >= VERTICAL && off.x.hypot(off.y) <= CENTRED
    }

    /// Turns of the part, rad, of those calls that the machine does not run like the first one.
    pub fn unlike_calls(&self, calls: ChannelCalls) -> impl Iterator<Item = f64> + use<> {
        let count = if self.turns_part() { 1 } else { calls.count().unwrap_or(UNKNOWN_CALLS) };
        (1..count).map(move |call| TAU * call as f64 / count as f64)
    }

    /// The machine as a program that is called once a channel has it: its first rotary axis turns the part on
    /// from call to call, in positive direction, and keeps within its limits in the last one too. All else is
    /// the same in each call.
    ///
    /// # Errors
    /// When no table turns the part about its axis, and the program names positions of the axes, or when the
    /// range of the axis is too small for all calls.
    pub fn for_calls(&self, calls: ChannelCalls, output: OutputKind) -> Result<Self, UserError> {
        let turn = calls.whole_turn_rad();
        if turn == 0.0 {
            return Ok(self.clone());
        }
        let first = &self.rotary[0];
        if !self.turns_part() {
            // Vectors and planes turn with the offset, the positions of axes do not.
            if matches!(output, OutputKind::TcpVectors | OutputKind::Plane) {
                return Ok(self.clone());
            }
            let what = format!(
                "no table of {} turns the part about its axis, and the positions of {} and {} do not turn with \
                 the offset of a called program",
                self.name, self.rotary[0].letter, self.rotary[1].letter
            );
            return Err(UserError::new(ErrorCode::AxisLimits, what, INSTEAD_OF_CALLS));
        }
        let mut machine = self.clone();
        if let Some((low, high)) = first.limits {
            if high - turn <= low {
                let (letter, range) = (first.letter, (high - low).to_degrees());
                let what = format!(
                    "{letter} turns the part by {:.1}° from call to call in all, and has {range:.0}°",
                    turn.to_degrees()
                );
                return Err(UserError::new(ErrorCode::AxisLimits, what, INSTEAD_OF_CALLS));
            }
            machine.rotary[0].limits = Some((low, high - turn));
        }
        Ok(machine)
    }
}

/// What to do instead of calling a program.
pub const INSTEAD_OF_CALLS: &str =
    "post all channels (plan or flank with --channels all) without --subprogram";

#[cfg(test)]
mod tests {
    use super::*;

    fn each(count: usize, sequence: ChannelSequence) -> ChannelCalls {
        ChannelCalls::for_channels(1, count, sequence)
    }

    #[test]
    fn every_call_is_named_with_its_turn() {
        let adjacent = each(3, ChannelSequence::Adjacent);
        let words = "to be called 3 times, the work offset turned on by 120° each time, to 0°, 120°, 240°";
        assert_eq!(adjacent.words().as_deref(), Some(words));
        let opposite = each(7, ChannelSequence::Opposite);
        let words = opposite.words().expect("known");
        assert!(
            words.starts_with("to be called 7 times, the work offset turned to 0°, 154.2857°, "),
            "{words}"
        );
        assert_eq!(opposite.offsets_deg().expect("known").len(), 7);
        assert_eq!(each(1, ChannelSequence::Opposite).words().as_deref(), Some("to be called once"));
        let several = ChannelCalls::for_channels(3, 9, ChannelSequence::Opposite);
        assert_eq!(several.words().as_deref(), Some("to be called once, for its 3 channels"));
        assert_eq!(several.offsets_deg(), Some(vec![0.0]));
        assert_eq!((ChannelCalls::Unknown.words(), ChannelCalls::Unknown.comments().len()), (None, 0));
    }

    #[test]
    fn comments_are_short_lines_with_all_turns() {
        let calls = each(17, ChannelSequence::Opposite);
        let comments = calls.comments();
        assert!(comments.iter().all(|line| line.len() <= MAX_COMMENT && line.is_ascii()), "{comments:?}");
        let numbers: Vec<f64> =
            comments.join(" ").split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
        // The number of calls comes first.
        assert_eq!(numbers.len(), 18, "{comments:?}");
        for (named, wanted) in numbers[1..].iter().zip(calls.offsets_deg().expect("known")) {
            assert!((named - wanted).abs() < 1e-4, "{comments:?}");
        }
    }
}
