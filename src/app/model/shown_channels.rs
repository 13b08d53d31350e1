//! The channels that the views show, with their plunges in cutting order: what the timeline runs through
//! while there is more than one.

use std::sync::Arc;

use crate::app::model::planned::DisplayPlan;
use crate::plunge::channels::order_plunges;
use crate::setup::{AxisPolicy, ChannelSetup};
use crate::toolpath::ChannelStep;

/// Several channels of a plan, as its program cuts them.
#[derive(Debug)]
pub struct ShownChannels {
    planned: Arc<DisplayPlan>,
    policy: AxisPolicy,
    count: usize,
    /// Their plunges, in cutting order.
    pub plunges: Vec<ChannelStep>,
    /// The channels in their sequence, in pitches ahead of channel 1.
    sequence: Vec<usize>,
}

/// How far a channel is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelProgress {
    /// The channel, in pitches ahead of channel 1.
    pub channel: usize,
    /// Its plunges up to this one are cut.
    pub up_to: usize,
    /// Whether the last plunge of all was in it.
    pub is_current: bool,
}

impl ShownChannels {
    /// The first `count` channels of a plan in the order of its setup; `None` for one channel.
    pub fn from_planned(planned: &Arc<DisplayPlan>, policy: AxisPolicy, count: usize) -> Option<Self> {
        let part = &planned.outcome.workpiece.part;
        let count = count.min(part.blade_count);
        if count <= 1 {
            return None;
        }
        let (plan, order) = (planned.plan(policy), planned.outcome.setup.channels);
        let plunges = order_plunges(plan, part, order, count);
        let sequence = order.sequence.channels(part.blade_count).into_iter().take(count).collect();
        Some(Self { planned: Arc::clone(planned), policy, count, plunges, sequence })
    }

    /// Whether these are the first `count` channels of a plan.
    pub fn is_of(&self, planned: &Arc<DisplayPlan>, policy: AxisPolicy, count: usize) -> bool {
        let count = count.min(planned.outcome.workpiece.part.blade_count);
        Arc::ptr_eq(&self.planned, planned) && (self.policy, self.count) == (policy, count)
    }

    /// Number of channels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The order in which they are cut.
    pub fn order(&self) -> ChannelSetup {
        self.planned.outcome.setup.channels
    }

    /// Whether the channel that is `channel` pitches ahead of channel 1 is shown.
    pub fn has_channel(&self, channel: usize) -> bool {
        self.sequence.contains(&channel)
    }

    /// Number of plunges that are cut when position `position` of the channel that is `channel` pitches ahead
    /// of channel 1 is.
    pub fn step_of(&self, position: usize, channel: usize) -> Option<usize> {
        let is_it = |plunge: &ChannelStep| (plunge.channel, plunge.index) == (channel, position);
        self.plunges.iter().position(is_it).map(|index| index + 1)
    }

    /// How far each channel is cut after `cut` plunges (`None`: all), in their sequence.
    pub fn progress(&self, cut: Option<usize>) -> Vec<ChannelProgress> {
        let all = self.planned.plan(self.policy).positions.len();
        let begun = |up_to| move |&channel: &usize| ChannelProgress { channel, up_to, is_current: false };
        let Some(cut) = cut.map(|cut| cut.min(self.plunges.len())) else {
            return self.sequence.iter().map(begun(all)).collect();
        };
        let mut progress: Vec<ChannelProgress> = self.sequence.iter().map(begun(0)).collect();
        for plunge in &self.plunges[..cut] {
            progress[plunge.place].up_to = plunge.index + 1;
        }
        if let Some(last) = cut.checked_sub(1).map(|last| self.plunges[last]) {
            progress[last.place].is_current = true;
        }
        progress
    }

    /// Number of plunges of channel 1 that are cut after `cut` plunges of all.
    pub fn cut_of_first(&self, cut: usize) -> usize {
        let cut = &self.plunges[..cut.min(self.plunges.len())];
        cut.iter().rev().find(|plunge| plunge.channel == 0).map_or(0, |plunge| plunge.index + 1)
    }
}
