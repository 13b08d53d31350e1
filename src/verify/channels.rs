//! Assigns the cuts of a program to channels, counted in pitches ahead of channel 1.

use crate::geometry::{Meridional, Point};
use crate::part::{Channel, Impeller, passage_angle};

/// Least share of the cuts in a channel that counts, relative to the channel with the most.
const MIN_CHANNEL_SHARE: f64 = 0.1;

/// Channels of consecutive cuts, given as the channel of each (where it is known) and its weight. Over blades
/// that lean far a few cuts are found in a neighbouring channel, and beyond the blades none is known: these
/// get the channel of the cuts before them.
pub(super) fn channels_of(cuts: &[(Option<i64>, f64)]) -> Vec<i64> {
    let mut numbers: Vec<i64> = cuts.iter().filter_map(|cut| cut.0).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let weight = |number: i64| cuts.iter().filter(|cut| cut.0 == Some(number)).map(|cut| cut.1).sum::<f64>();
    let weights: Vec<f64> = numbers.iter().map(|&number| weight(number)).collect();
    let min_weight = MIN_CHANNEL_SHARE * weights.iter().copied().fold(0.0, f64::max);
    let counts = |number: &i64| numbers.binary_search(number).is_ok_and(|at| weights[at] >= min_weight);
    let mut last = cuts.iter().find_map(|cut| cut.0.filter(counts)).unwrap_or(0);
    cuts.iter()
        .map(|cut| {
            last = cut.0.filter(counts).unwrap_or(last);
            last
        })
        .collect()
}

/// s of a point, and its height over the hub as a share of the channel's depth; `None` beyond leading edge
/// and rim.
fn span_of(part: &Impeller, here: Meridional) -> Option<(f64, f64)> {
    let (t, height) = part.hub.curve().project(here);
    let s = part.hub.s_at(t);
    let depth = part.hub.point(s).distance(part.shroud.point(s));
    (0.0..=1.0).contains(&s).then_some((s, height / depth))
}

/// Whether a tip is over the blades, where all channels are one.
pub(super) fn is_over_blades(part: &Impeller, tip: &Point) -> bool {
    span_of(part, Meridional::from_point(tip)).is_some_and(|(_, eta)| eta >= 1.0)
}

/// Number of pitches by which a tip is ahead of channel 1; `None` beyond leading edge and rim, where there
/// are no walls.
pub(super) fn channel_at(part: &Impeller, channel: &Channel, tip: &Point) -> Option<i64> {
    let here = Meridional::from_point(tip);
    let (s, eta) = span_of(part, here)?;
    let eta = eta.clamp(0.0, 1.0);
    let [low, high] = channel.full.walls.each_ref().map(|wall| {
        let near = wall.at(part, s, eta)?;
        // Evaluated at the point itself: beside leaning blades the wall at equal s and height may be far
        // away.
        Some(wall.at_meridional(here, near.u, near.v).map_or(near.theta, |there| there.theta))
    });
    let low = low?;
    let high = low + passage_angle(low, high?, part.pitch());
    Some(channel_between(part, [low, high], tip))
}

/// As [`channel_at`]; beyond leading edge and rim the walls are continued along Z and r.
pub(super) fn nearest_channel(part: &Impeller, channel: &Channel, tip: &Point) -> Option<i64> {
    channel_at(part, channel, tip).or_else(|| {
        let here = Meridional::from_point(tip);
        let s = part.hub.s_at(part.hub.curve().project(here).0).clamp(0.0, 1.0);
        let [low, high] = channel.full.wall_angles(part, s, 0.0)?;
        Some(channel_between(part, [low, high], tip))
    })
}

/// Number of pitches by which a tip is ahead of the middle between the wall angles of channel 1 (rad).
fn channel_between(part: &Impeller, [low, high]: [f64; 2], tip: &Point) -> i64 {
    let ahead = ((tip.y.atan2(tip.x) - 0.5 * (low + high)) / part.pitch()).round() as i64;
    let count = part.blade_count as i64;
    let turns = ahead.rem_euclid(count);
    if turns > count / 2 { turns - count } else { turns }
}
