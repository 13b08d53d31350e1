//! Several channels of the shown plan: which are shown, and how far each is cut.

use std::sync::Arc;

use super::AppState;
use crate::app::model::flank_run::{FlankRun, WantedFlankRun};
use crate::app::model::look::Operation;
use crate::app::model::shown_channels::{ChannelProgress, ShownChannels};
use crate::geometry::{Point, Vector, rotate_vector_z, rotate_z};

impl AppState {
    /// Keeps the shown channels those of the shown plan, and their timeline at that of channel 1, which
    /// selections and edits move.
    pub fn follow_channels(&mut self) {
        let count = self.look.shown_channels;
        let shown = self.shown().filter(|_| count > 1 && self.look.operation == Operation::Roughing);
        let is_known = |known: &ShownChannels| {
            shown.is_some_and(|shown| known.is_of(shown.planned, shown.policy, count))
        };
        if !self.channels.as_ref().is_some_and(is_known) {
            self.channels =
                shown.and_then(|shown| ShownChannels::from_planned(shown.planned, shown.policy, count));
        }
        if count <= 1 {
            (self.look.channels_cut, self.look.selected_channel) = (None, 0);
        }
        // Until there is a plan, the timeline stays where it was.
        let Some(channels) = &self.channels else { return };
        if !channels.has_channel(self.look.selected_channel) {
            self.look.selected_channel = 0;
        }
        let len = channels.plunges.len();
        self.look.channels_cut = match (self.look.cut_count, self.look.channels_cut) {
            (None, _) => None,
            (Some(cut), Some(known)) if channels.cut_of_first(known) == cut => Some(known.min(len)),
            (Some(cut), _) => cut.checked_sub(1).map_or(Some(0), |last| channels.step_of(last, 0)),
        };
    }

    /// Keeps the shown flank program that of the flank plan: at first in one channel. Its timeline begins
    /// anew where that changes.
    pub fn follow_flank_channels(&mut self) {
        let Some(outcome) = &self.results.flank else {
            self.results.flank_run = None;
            return;
        };
        let order = self.document.edited.setup.channels;
        let known = self.results.flank_run.as_ref().filter(|run| Arc::ptr_eq(&run.outcome, outcome));
        // Of a plan that is not in view the channels can wait.
        let is_one = self.look.shown_channels <= 1 && self.look.operation == Operation::Flank;
        let keeps = |run: &Arc<FlankRun>| !is_one || run.is_of(outcome, order, 1);
        if !known.is_some_and(keeps) {
            self.show_flank_run(Arc::new(FlankRun::new(outcome, order, 1)));
        }
    }

    /// The flank program in as many channels as are shown, in the order in which they would be exported;
    /// `None` where it is shown already, and where it is not in view.
    pub fn wanted_flank_run(&self) -> Option<WantedFlankRun> {
        let outcome = self.results.flank.as_ref().filter(|_| self.look.operation == Operation::Flank)?;
        let order = self.document.edited.setup.channels;
        let count = outcome.workpiece.part.channels_within(self.look.shown_channels);
        let is_of = |run: &Arc<FlankRun>| run.is_of(outcome, order, count);
        let is_wanted = count > 1 && !self.results.flank_run.as_ref().is_some_and(is_of);
        is_wanted.then(|| WantedFlankRun { outcome: Arc::clone(outcome), order, count })
    }

    /// Shows a flank program.
    pub fn show_flank_run(&mut self, run: Arc<FlankRun>) {
        self.results.passes = Arc::clone(&run.passes);
        self.results.flank_run = Some(run);
        (self.look.flank.cut, self.look.flank.pass, self.look.playing) = (None, None, None);
    }

    /// The shown channels of the shown plan; `None` while that is one.
    pub fn shown_channels(&self) -> Option<&ShownChannels> {
        let shown = self.shown().filter(|_| self.look.operation == Operation::Roughing)?;
        let count = self.look.shown_channels;
        self.channels.as_ref().filter(|channels| channels.is_of(shown.planned, shown.policy, count))
    }

    /// How far each shown channel is cut; empty for one.
    pub fn channel_progress(&self) -> Vec<ChannelProgress> {
        self.shown_channels().map_or_else(Vec::new, |channels| channels.progress(self.look.channels_cut))
    }

    /// Number of steps of the timeline up to the end of position `position` of the channel that is `channel`
    /// pitches ahead of channel 1.
    pub fn step_of_position(&self, position: usize, channel: usize) -> usize {
        let channels = self.shown_channels();
        channels.and_then(|channels| channels.step_of(position, channel)).unwrap_or(position + 1)
    }

    /// Turn from channel 1 to that of the selected position, rad.
    pub fn selected_turn_rad(&self) -> f64 {
        let part = self.document.part.as_ref();
        part.map_or(0.0, |part| part.impeller.pitch() * self.look.selected_channel as f64)
    }

    /// Tip and axis of the selected position in its channel.
    pub fn selected_in_channel(&self) -> Option<(Point, Vector)> {
        let (position, turn) = (self.selected()?, self.selected_turn_rad());
        Some((rotate_z(&position.tip, turn), rotate_vector_z(&position.axis, turn)))
    }

    /// The position whose plunge is step `step` of the timeline (from 0), with the number of its channel.
    pub fn position_of_step(&self, step: usize) -> Option<(usize, usize)> {
        match self.shown_channels() {
            Some(channels) => channels.plunges.get(step).map(|plunge| (plunge.index, plunge.channel + 1)),
            None => (step < self.position_count()).then_some((step, 1)),
        }
    }
}
