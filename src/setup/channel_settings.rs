//! In what order a program mills several channels of a wheel.

use std::f64::consts::TAU;

/// Imbalances and distances that differ by less are equal: they are computed from sines, and a difference of
/// channels of the same wheel is far greater.
const SAME: f64 = 1e-9;

/// What a program of several channels finishes first: key `order` of `[channels]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ChannelOrder {
    /// A tool, in all channels: it is loaded once.
    #[default]
    ToolByTool,
    /// A channel, with all its tools: they are loaded anew for each.
    ChannelByChannel,
}

impl ChannelOrder {
    /// All orders, the default first.
    pub const ALL: [Self; 2] = [Self::ToolByTool, Self::ChannelByChannel];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::ToolByTool => "tool_by_tool",
            Self::ChannelByChannel => "channel_by_channel",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::ToolByTool => "tool by tool",
            Self::ChannelByChannel => "channel by channel",
        }
    }
}

/// How channels follow each other: key `sequence` of `[channels]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ChannelSequence {
    /// Each is followed by its neighbour.
    #[default]
    Adjacent,
    /// Each is followed by the one opposite to it, so that the wheel is relieved evenly.
    Opposite,
}

impl ChannelSequence {
    /// All sequences, the default first.
    pub const ALL: [Self; 2] = [Self::Adjacent, Self::Opposite];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adjacent => "adjacent",
            Self::Opposite => "opposite",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Adjacent => "neighbouring channels",
            Self::Opposite => "opposite channels",
        }
    }

    /// The channels of a wheel with `count` channels, counted from 0, in the order in which they are cut. A
    /// program for fewer of them mills the first ones of this sequence, so that it is the beginning of the
    /// program for all.
    ///
    /// Opposite channels are found greedily. The next channel is always the one after which the centre of all
    /// channels cut so far is nearest to the axis of rotation: with an even count the one opposite to the
    /// last, with an odd count one beside that. Of equal ones it is the one farthest from all that are cut,
    /// and of those the first. That is a rule for any count, odd ones too, and what is removed stays balanced
    /// but for one channel.
    ///
    /// ```
    /// # use vanecut::setup::ChannelSequence;
    /// assert_eq!(ChannelSequence::Opposite.channels(8), [0, 4, 2, 6, 1, 5, 3, 7]);
    /// assert_eq!(ChannelSequence::Opposite.channels(5), [0, 2, 3, 1, 4]);
    /// ```
    pub fn channels(self, count: usize) -> Vec<usize> {
        if self == Self::Adjacent {
            return (0..count).collect();
        }
        let directions: Vec<[f64; 2]> = (0..count)
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / count as f64).sin_cos();
                [cos, sin]
            })
            .collect();
        let mut sequence = Vec::with_capacity(count);
        // Sum of the directions of what is cut, and pitches from each channel to the nearest of these.
        let mut sum = [0.0; 2];
        let mut distance = vec![count; count];
        while sequence.len() < count {
            let mut best: Option<(f64, usize)> = None;
            for (k, direction) in directions.iter().enumerate().filter(|(k, _)| distance[*k] > 0) {
                let off = (sum[0] + direction[0]).hypot(sum[1] + direction[1]);
                let is_better = best.is_none_or(|(least, known)| {
                    off < least - SAME || (off < least + SAME && distance[k] > distance[known])
                });
                if is_better {
                    best = Some((off, k));
                }
            }
            let Some((_, next)) = best else { break };
            sum = [sum[0] + directions[next][0], sum[1] + directions[next][1]];
            for (k, distance) in distance.iter_mut().enumerate() {
                let apart = k.abs_diff(next);
                *distance = (*distance).min(apart.min(count - apart));
            }
            sequence.push(next);
        }
        sequence
    }
}

/// `[channels]`: the order of a program of several channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChannelSetup {
    /// What is finished first.
    pub order: ChannelOrder,
    /// How channels follow each other.
    pub sequence: ChannelSequence,
}

impl ChannelSetup {
    /// In words, "tool by tool, opposite channels"; neighbouring channels are not named.
    pub fn words(self) -> String {
        match self.sequence {
            ChannelSequence::Adjacent => self.order.words().to_owned(),
            ChannelSequence::Opposite => format!("{}, {}", self.order.words(), self.sequence.words()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Greatest distance of the sum of the directions of what is cut from the axis, over all beginnings of
    /// `sequence`.
    fn max_imbalance(sequence: &[usize]) -> f64 {
        let mut sum = [0.0; 2];
        let mut largest = 0.0_f64;
        for k in sequence {
            let (sin, cos) = (TAU * *k as f64 / sequence.len() as f64).sin_cos();
            sum = [sum[0] + cos, sum[1] + sin];
            largest = largest.max(sum[0].hypot(sum[1]));
        }
        largest
    }

    /// That of one channel; a few large odd counts exceed it a little.
    const MAX_IMBALANCE: f64 = 1.01;

    #[test]
    fn each_channel_comes_once_and_the_wheel_stays_balanced() {
        for count in 0..=120 {
            for sequence in ChannelSequence::ALL {
                let mut channels = sequence.channels(count);
                if sequence == ChannelSequence::Opposite {
                    let imbalance = max_imbalance(&channels);
                    assert!(imbalance <= MAX_IMBALANCE, "{count}: {imbalance}, {channels:?}");
                }
                channels.sort_unstable();
                assert!(channels.into_iter().eq(0..count), "{count}, {sequence:?}");
            }
        }
        // Neighbours are what it is for: 17 channels, half of them cut.
        assert!(max_imbalance(&ChannelSequence::Adjacent.channels(17)) > 5.0);
    }

    #[test]
    fn with_an_even_count_pairs_are_opposite() {
        for count in (2..=60).step_by(2) {
            for pair in ChannelSequence::Opposite.channels(count).chunks(2) {
                assert_eq!(pair[0].abs_diff(pair[1]), count / 2, "{count}");
            }
        }
    }

    #[test]
    fn with_an_odd_count_channels_are_nearly_opposite() {
        assert_eq!(ChannelSequence::Opposite.channels(3), [0, 1, 2]);
        assert_eq!(ChannelSequence::Opposite.channels(7)[..4], [0, 3, 5, 1]);
        let of_17 = ChannelSequence::Opposite.channels(17);
        assert_eq!(of_17[..4], [0, 8, 12, 3]);
    }
}
