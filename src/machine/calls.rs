//! Programs that another one calls once a channel, each time with the part turned on.

use std::f64::consts::TAU;

use super::model::{AxisSide, MachineTool, OutputKind};
use crate::error::{ErrorCode, UserError};

/// Least |z| of the direction of an axis that turns the part about its own axis.
const VERTICAL: f64 = 1.0 - 1e-9;
/// Distance of the part's axis from that of its table below which they are the same, mm.
const CENTRED: f64 = 1e-3;

/// Turns that are looked at where the number of channels is not known.
const UNKNOWN_CALLS: usize = 24;

/// How often a program is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelCalls {
    /// Once a channel of a part with this many.
    Channels(usize),
    /// Once a channel of a part that is not known.
    Unknown,
}

impl ChannelCalls {
    /// Those of a program for `channels` channels of a part with `channel_count`: one of several channels is
    /// called once, as it is not turned on from channel to channel.
    pub fn for_channels(channels: usize, channel_count: usize) -> Self {
        Self::Channels(if channels > 1 { 1 } else { channel_count })
    }

    /// Number of calls, if it is known.
    pub fn count(self) -> Option<usize> {
        match self {
            Self::Channels(count) => Some(count.max(1)),
            Self::Unknown => None,
        }
    }

    /// Turn from call to call, rad, if it is known.
    pub fn turn_rad(self) -> Option<f64> {
        self.count().map(|count| TAU / count as f64)
    }

    /// Turn from the first to the last call, rad; less than a whole turn.
    pub fn whole_turn_rad(self) -> f64 {
        self.count().map_or(TAU, |count| TAU * (count - 1) as f64 / count as f64)
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
