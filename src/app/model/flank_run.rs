//! The flank plan as the views show it: in one channel, or in several as their program mills them.

use std::borrow::Cow;
use std::sync::Arc;

use super::flank_passes::FlankPasses;
use crate::flank::channels::FlankChannels;
use crate::flank::{FlankMove, FlankPlan, MoveKind};
use crate::job::flank::FlankOutcome;
use crate::monitor::{Cancelled, Monitor};
use crate::setup::{ChannelSetup, Setup};
use crate::toolpath::{ClProgram, Travel};

/// A flank plan in the channels that are shown.
#[derive(Debug)]
pub struct FlankRun {
    /// The plan, of one channel.
    pub outcome: Arc<FlankOutcome>,
    /// The passes in all of its channels.
    pub passes: Arc<FlankPasses>,
    /// Steps of the timeline with a fault.
    pub faulty: Vec<usize>,
    order: ChannelSetup,
    count: usize,
    /// `None` for one channel.
    several: Option<SeveralChannels>,
}

/// A plan and the channels in which it is to be shown.
#[derive(Clone, Debug)]
pub struct WantedFlankRun {
    /// The plan, of one channel.
    pub outcome: Arc<FlankOutcome>,
    /// The order of the channels.
    pub order: ChannelSetup,
    /// Their number.
    pub count: usize,
}

impl PartialEq for WantedFlankRun {
    fn eq(&self, other: &Self) -> bool {
        let same = (self.order, self.count) == (other.order, other.count);
        same && Arc::ptr_eq(&self.outcome, &other.outcome)
    }
}

/// What a program of several channels adds to the plan of one.
#[derive(Debug)]
struct SeveralChannels {
    program: ClProgram,
    /// Its moves but for the plunges above the shroud, with links from channel to channel.
    moves: Vec<FlankMove>,
    /// For each of them its index in the program.
    indices: Vec<usize>,
    /// For each of them its index in the plan, if any, and its channel, in pitches ahead of channel 1.
    origins: Vec<(Option<usize>, usize)>,
}

impl FlankRun {
    /// A plan in its first `count` channels in this `order`.
    pub fn new(outcome: &Arc<FlankOutcome>, order: ChannelSetup, count: usize) -> Self {
        let count = outcome.workpiece.part.channels_within(count);
        let plan = &outcome.plan;
        let several = (count > 1).then(|| SeveralChannels::new(outcome, order, count));
        let (passes, faulty) = match &several {
            None => (FlankPasses::from_plan(plan), plan.faults.iter().map(|fault| fault.index).collect()),
            Some(several) => (several.passes(), several.faulty(plan)),
        };
        Self { outcome: Arc::clone(outcome), passes: Arc::new(passes), faulty, order, count, several }
    }

    /// Whether it is this plan in its first `count` channels in this `order`.
    pub fn is_of(&self, outcome: &Arc<FlankOutcome>, order: ChannelSetup, count: usize) -> bool {
        let count = outcome.workpiece.part.channels_within(count);
        // One channel has no order.
        let same = self.count == count && (count == 1 || self.order == order);
        same && Arc::ptr_eq(&self.outcome, outcome)
    }

    /// Number of channels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The order in which they are cut.
    pub fn order(&self) -> ChannelSetup {
        self.order
    }

    /// The moves of all channels, without the plunges that open the stock before the passes.
    pub fn moves(&self) -> &[FlankMove] {
        self.several.as_ref().map_or(&self.outcome.plan.moves, |several| &several.moves)
    }

    /// The whole program, and for each of the moves its index there.
    pub fn program(&self) -> (Cow<'_, ClProgram>, Vec<usize>) {
        match &self.several {
            Some(several) => (Cow::Borrowed(&several.program), several.indices.clone()),
            None => {
                let program = self.outcome.program();
                let count = program.moves.len();
                let passes = count - self.outcome.plan.moves.len()..count;
                (Cow::Owned(program), passes.collect())
            }
        }
    }

    /// The channel of a move, in pitches ahead of channel 1.
    pub fn channel_of(&self, index: usize) -> usize {
        let several = self.several.as_ref();
        several.and_then(|several| several.origins.get(index)).map_or(0, |&(_, channel)| channel)
    }

    /// Turns from channel 1 to each of the channels, rad.
    pub fn turns_rad(&self) -> Vec<f64> {
        let part = &self.outcome.workpiece.part;
        let channels = self.order.sequence.channels(part.blade_count).into_iter().take(self.count);
        if self.count == 1 { vec![0.0] } else { channels.map(|k| part.pitch() * k as f64).collect() }
    }
}

impl SeveralChannels {
    fn new(outcome: &FlankOutcome, order: ChannelSetup, count: usize) -> Self {
        let (plan, part) = (&outcome.plan, &outcome.workpiece.part);
        let one = plan.in_one_channel(&part.name);
        let setup = Setup { channels: order, ..outcome.setup.clone() };
        // Nothing cancels what is shown.
        let FlankChannels { program, origins } = one
            .in_channels(part, &outcome.workpiece.blank, &setup, count, &Monitor::default())
            .unwrap_or_else(|Cancelled| FlankChannels::default());
        let mut found = Self {
            program: ClProgram::default(),
            moves: Vec::new(),
            indices: Vec::new(),
            origins: Vec::new(),
        };
        for (index, (step, origin)) in program.moves.iter().zip(&origins).enumerate() {
            let (tip, axis) = (step.tip, step.axis);
            let shown = match origin {
                Some(of_one) => one
                    .index_of_pass(of_one.index)
                    .map(|k| (FlankMove { tip, axis, ..plan.moves[k] }, (Some(k), of_one.channel))),
                // A link from channel to channel. One between plunges above the shroud belongs to them.
                None => found.moves.last().zip(found.origins.last()).map(|(last, &(_, channel))| {
                    let link = FlankMove { kind: MoveKind::Rapid, tip, axis, along_wall: false, ..*last };
                    (link, (None, channel))
                }),
            };
            let Some((step, origin)) = shown else { continue };
            found.moves.push(step);
            found.origins.push(origin);
            found.indices.push(index);
        }
        Self { program, ..found }
    }

    fn passes(&self) -> FlankPasses {
        let clock = Travel::clock(&self.program);
        let at = |&index: &usize| clock.get(index).copied().unwrap_or(0.0);
        FlankPasses::of_moves(&self.moves, self.indices.iter().map(at).collect())
    }

    /// The steps that repeat a move of `plan` with a fault.
    fn faulty(&self, plan: &FlankPlan) -> Vec<usize> {
        let is_faulty = |index: usize| plan.faults.iter().any(|fault| fault.index == index);
        let steps = self.origins.iter().enumerate();
        steps.filter(|(_, (origin, _))| origin.is_some_and(is_faulty)).map(|(step, _)| step).collect()
    }
}
