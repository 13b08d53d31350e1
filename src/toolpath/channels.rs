//! The order in which a program does in several channels what it does in one.

use std::collections::HashSet;

use crate::geometry::{Point, rotate_z};
use crate::setup::{ChannelOrder, ChannelSetup};

/// Distance within which two plunges above the shroud are the same, mm.
const SAME_PLACE: f64 = 1e-3;

/// A step of a program of several channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelStep {
    /// Its channel, in pitches ahead of channel 1.
    pub channel: usize,
    /// Place of the channel in the sequence of channels, from 0.
    pub place: usize,
    /// Its index among the steps of one channel.
    pub index: usize,
}

/// The steps of a program for the first `channels` channels of the sequence of `order` on a wheel with
/// `count`, in cutting order. In one channel the steps come in `stretches` of these lengths, of which tool by
/// tool each is cut in all channels before the next one begins. Within a channel the steps keep their order,
/// so that each finds at least the stock gone that it finds gone in channel 1. Steps that are not new, by
/// channel and index, are left out.
pub fn order_steps(
    stretches: &[usize],
    order: ChannelSetup,
    channels: usize,
    count: usize,
    mut is_new: impl FnMut(usize, usize) -> bool,
) -> Vec<ChannelStep> {
    let whole = [stretches.iter().sum()];
    let stretches: &[usize] = match order.order {
        ChannelOrder::ChannelByChannel => &whole,
        ChannelOrder::ToolByTool => stretches,
    };
    let sequence = order.sequence.channels(count.max(channels));
    let mut steps = Vec::with_capacity(channels * whole[0]);
    let mut first = 0;
    for length in stretches {
        for (place, &channel) in sequence.iter().take(channels).enumerate() {
            let stretch = (first..first + length).filter(|&index| is_new(channel, index));
            steps.extend(stretch.map(|index| ChannelStep { channel, place, index }));
        }
        first += length;
    }
    steps
}

/// The places above the shroud where channels have plunged: neighbouring channels share plunges there.
#[derive(Debug, Default)]
pub struct OpenedPlaces {
    /// Cells of [`SAME_PLACE`], which is far below the distance of two plunges and far above rounding.
    known: HashSet<[i64; 3]>,
}

impl OpenedPlaces {
    /// Adds the plunge to `tip` of channel 1, turned by `angle` (rad); whether it is new. Neighbouring cells
    /// are looked at too: rounding may put the same place on either side of their border.
    pub fn open(&mut self, tip: &Point, angle: f64) -> bool {
        let tip = rotate_z(tip, angle);
        let [x, y, z] = [tip.x, tip.y, tip.z].map(|x| (x / SAME_PLACE).round() as i64);
        let near = || -1..=1_i64;
        let is_known =
            near().any(|dx| near().any(|dy| near().any(|dz| self.known.contains(&[x + dx, y + dy, z + dz]))));
        !is_known && self.known.insert([x, y, z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_known_again_on_either_side_of_a_border_of_cells() {
        let mut places = OpenedPlaces::default();
        let pitch = std::f64::consts::TAU / 6.0;
        for k in 0..200 {
            // On the border of two cells, and off it by what files are rounded by.
            let border = Point::new((f64::from(k) + 0.5) * 5.0 * SAME_PLACE, f64::from(k), 2.0);
            assert!(places.open(&border, 0.0), "{k} is new");
            for off in [-1e-6, 1e-6] {
                assert!(!places.open(&Point::new(border.x + off, border.y, border.z), 0.0), "{k}");
                let before = rotate_z(&border, -pitch);
                assert!(!places.open(&Point::new(before.x, before.y + off, before.z), pitch), "{k}");
            }
        }
    }
}
