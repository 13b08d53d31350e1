//! The timeline: how much of the shown operation is cut. It counts the plunges of a plunge plan, and the
//! moves of a flank plan or of a checked program.

use std::sync::Arc;

use super::AppState;
use crate::app::model::boundary::Boundary;
use crate::app::model::look::{Operation, REVEAL};
use crate::app::model::machine_list::fault_words;
use crate::app::model::shown_channels::ShownChannels;
use crate::app::model::timeline_program::TimelineProgram;
use crate::plunge::Position;

/// Positions that a playing timeline cuts per second at speed 1.
pub const PLAY_RATE: f64 = 15.0;
/// Moves in their place: they are shorter.
const MOVES_PLAY_RATE: f64 = 150.0;

impl AppState {
    /// What the timeline runs through; `None` before there is anything.
    pub fn timeline_program(&self) -> Option<TimelineProgram> {
        match self.look.operation {
            Operation::Roughing => {
                let shown = self.shown()?;
                let channels = self.shown_channels().map_or(1, ShownChannels::count);
                Some(TimelineProgram::Plunges(Arc::clone(shown.planned), shown.policy, channels))
            }
            Operation::Flank => self.results.flank_run.clone().map(TimelineProgram::Flank),
            Operation::Program => self.results.checked.clone().map(TimelineProgram::Checked),
        }
    }

    /// Name of the machine on which the timeline's program runs: the one that checked NC code was read for,
    /// otherwise that of the setup.
    pub fn timeline_machine(&self) -> Option<&str> {
        let checked = self.shown_program().filter(|checked| checked.on_machine.is_some());
        let of_setup = || self.document.edited.setup.machine.file.as_deref();
        checked.map(|checked| checked.request.machine.as_str()).or_else(of_setup)
    }

    /// Why the axes of that machine are not known: what is wrong, and what to do. `None` where they are, and
    /// while they are calculated.
    pub fn axes_fault(&self) -> Option<(String, String)> {
        match self.results.on_machine.as_ref()? {
            Err(error) => Some(fault_words(error)),
            Ok(plan) => {
                let (what, help) = plan.fault.as_ref()?;
                Some((format!("{}: {what}", plan.machine.name), help.clone()))
            }
        }
    }

    /// Whether the views show one tool alone: at the selected fault, or where the timeline stands.
    pub fn shows_one_tool(&self) -> bool {
        self.selected_finding().is_some() || self.shows_timeline_tool()
    }

    /// Whether the views show the tool where the timeline stands, alone: not while they show it at a fault.
    pub fn shows_timeline_tool(&self) -> bool {
        let shows_moves = self.shown_flank().is_some() || self.shown_program().is_some();
        shows_moves && self.selected_finding().is_none() && self.timeline_cut().is_some_and(|cut| cut > 0)
    }

    /// Whether the timeline counts moves, not plunges.
    pub fn timeline_is_of_moves(&self) -> bool {
        self.look.operation != Operation::Roughing
    }

    /// Number of steps of the timeline; 0 where the shown operation has none.
    pub fn timeline_len(&self) -> usize {
        match self.look.operation {
            Operation::Roughing => match self.shown_channels() {
                Some(channels) => channels.plunges.len(),
                None => self.position_count(),
            },
            Operation::Flank => self.results.passes.clock.len(),
            Operation::Program => {
                self.results.checked.as_ref().map_or(0, |checked| checked.program.moves.len())
            }
        }
    }

    /// Number of steps that are cut; `None`: all.
    pub fn timeline_cut(&self) -> Option<usize> {
        match self.look.operation {
            Operation::Roughing if self.shown_channels().is_some() => self.look.channels_cut,
            Operation::Roughing => self.look.cut_count,
            Operation::Flank => self.look.flank.cut,
            Operation::Program => self.look.program_cut,
        }
    }

    /// What is selected, as the number of steps up to its end.
    pub fn selected_end(&self) -> Option<usize> {
        match self.look.operation {
            Operation::Roughing => {
                self.look.selected.map(|k| self.step_of_position(k, self.look.selected_channel))
            }
            Operation::Flank => self.results.passes.passes.get(self.look.flank.pass?).map(|pass| pass.end),
            Operation::Program => self.selected_finding()?.first_move.map(|k| k + 1),
        }
    }

    /// Steps that a playing timeline cuts per second.
    pub fn play_rate(&self) -> f64 {
        self.look.play_speed * if self.timeline_is_of_moves() { MOVES_PLAY_RATE } else { PLAY_RATE }
    }

    /// The time of the shown program on the machine, step by step; `None` where that is not known.
    pub fn machine_clock(&self) -> Option<&[f64]> {
        let clock = &self.on_machine()?.clock;
        (!clock.is_empty() && clock.len() == self.timeline_len()).then_some(clock)
    }

    /// Time of the shown program from its start to the end of its first `cut` steps, s: on the machine, where
    /// that is known.
    pub fn time_after(&self, cut: usize) -> Option<f64> {
        if let Some(clock) = self.machine_clock() {
            return cut.checked_sub(1).map_or(Some(0.0), |last| clock.get(last).copied());
        }
        match self.look.operation {
            Operation::Roughing => match self.shown_channels() {
                // Links between channels take their time: only the written program has it.
                Some(_) => self.results.listing.as_ref()?.time_after(cut),
                None => self.shown().and_then(|shown| shown.planned.time_after(shown.policy, cut)),
            },
            Operation::Flank => Some(self.results.passes.time_after(cut)),
            Operation::Program => Some(self.results.checked.as_ref()?.time_after(cut)),
        }
    }

    /// Time of the program at the position of the timeline and at its end, s; see [`Self::time_after`].
    pub fn clock(&self) -> Option<(f64, f64)> {
        let count = self.timeline_len();
        let cut = self.timeline_cut().unwrap_or(count);
        self.time_after(cut).zip(self.time_after(count))
    }

    /// Moves the timeline by `step` steps and selects what was cut last. From the end it starts at the
    /// selection, if there is one.
    pub fn step_timeline(&mut self, step: isize) {
        let count = self.timeline_len();
        if count == 0 {
            return;
        }
        let now = self.timeline_cut().or(self.selected_end()).unwrap_or(count);
        self.set_timeline(Some(now.saturating_add_signed(step).min(count)));
    }

    /// Indices of the first steps of each section or layer, or after each tool change.
    pub fn boundaries(&self, of: Boundary) -> Vec<usize> {
        match (self.look.operation, of) {
            (Operation::Roughing, _) => {}
            (Operation::Flank, Boundary::Section) => return self.results.passes.layer_starts.clone(),
            (Operation::Flank, Boundary::Tool) => return Vec::new(),
            (Operation::Program, _) => {
                let checked = self.results.checked.as_ref();
                return checked.map_or_else(Vec::new, |checked| checked.boundaries(of));
            }
        }
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let key = |position: &Position| match of {
            Boundary::Section => position.section as u32,
            Boundary::Tool => plan.sections.get(position.section).map_or(0, |s| s.tool.number),
        };
        let keys: Vec<(usize, u32)> = match self.shown_channels() {
            Some(channels) => {
                // A tool may go on in the next channel, a section does not.
                let channel = |channel: usize| if of == Boundary::Section { channel } else { 0 };
                let plunges = channels.plunges.iter();
                plunges.map(|p| (channel(p.channel), key(&plan.positions[p.index]))).collect()
            }
            None => plan.positions.iter().map(|position| (0, key(position))).collect(),
        };
        (0..keys.len()).filter(|&k| k == 0 || keys[k - 1] != keys[k]).collect()
    }

    /// Moves the timeline to the first step of the next or previous tool, section or layer, and selects it.
    /// At the end of the timeline it starts from the selection, else forward from the blank, backward from
    /// the end.
    pub fn jump_to_boundary(&mut self, of: Boundary, forward: bool) {
        let now = self.timeline_cut().or(self.selected_end());
        let mut cuts = self.boundaries(of).into_iter().map(|k| k + 1);
        let next = match (now, forward) {
            (None, true) => cuts.next(),
            (None, false) => cuts.next_back(),
            (Some(now), true) => cuts.find(|&cut| cut > now),
            (Some(now), false) => cuts.rfind(|&cut| cut < now),
        };
        if next.is_some() {
            self.set_timeline(next);
        }
    }

    /// Sets the timeline to after `cut` steps; `None`: the end, with the selection unchanged.
    pub fn set_timeline(&mut self, cut: Option<usize>) {
        let count = self.timeline_len();
        let cut = cut.map(|cut| cut.min(count));
        match self.look.operation {
            Operation::Roughing => {
                let last = cut.and_then(|cut| self.position_of_step(cut.checked_sub(1)?));
                if let Some(channels) = self.shown_channels() {
                    let of_first = cut.map(|cut| channels.cut_of_first(cut));
                    (self.look.cut_count, self.look.channels_cut) = (of_first, cut);
                } else {
                    self.look.cut_count = cut;
                }
                if let Some(cut) = cut {
                    // The plunges of all channels are the same, and so are their rows of the table.
                    self.look.selected = last.map(|(k, _)| k);
                    self.look.selected_channel = last.map_or(0, |(_, channel)| channel - 1);
                    self.look.reveal_selection = if cut > 0 { REVEAL } else { 0 };
                }
            }
            Operation::Flank => {
                self.look.flank.cut = cut;
                if let Some(cut) = cut {
                    self.look.flank.pass = self.results.passes.pass_after(cut);
                    self.look.flank.reveal = true;
                }
            }
            Operation::Program => {
                self.look.program_cut = cut;
                // The tool is shown where the timeline stands, no more at the fault.
                if cut.is_some() {
                    self.look.finding = None;
                }
            }
        }
    }

    /// Starts or stops playing; starts from the blank when the timeline is at the end. `time` in seconds.
    pub fn play(&mut self, time: f64) {
        if self.look.playing.take().is_some() || self.timeline_len() == 0 {
            return;
        }
        if self.is_at_end() {
            self.set_timeline(Some(0));
        }
        self.look.playing = Some(time);
    }

    fn is_at_end(&self) -> bool {
        self.timeline_cut().is_none_or(|cut| cut >= self.timeline_len())
    }

    /// Advances a playing timeline; returns the seconds until its next step.
    pub fn advance(&mut self, time: f64) -> Option<f64> {
        let since = self.look.playing?;
        if self.timeline_len() == 0 {
            // A checked program has been opened meanwhile.
            self.look.playing = None;
            return None;
        }
        let rate = self.play_rate();
        let steps = ((time - since) * rate).floor().clamp(0.0, 1e6);
        if steps >= 1.0 {
            self.look.playing = Some(since + steps / rate);
            // At the end already where it was moved there: a step would begin at the selection.
            if !self.is_at_end() {
                self.step_timeline(steps as isize);
            } else if self.look.play_loop {
                self.set_timeline(Some(0));
            }
            if self.is_at_end() && !self.look.play_loop {
                self.look.playing = None;
            }
        }
        self.look.playing.map(|since| (since + 1.0 / rate - time).max(0.0))
    }

    /// Selects a pass of the flank plan and zooms to it. A timeline that is not at the end moves along.
    pub fn select_pass(&mut self, pass: Option<usize>) {
        self.look.flank.pass = pass;
        self.look.fly = pass.is_some();
        if let (Some(_), Some(end)) = (self.look.flank.cut, self.selected_end()) {
            self.look.flank.cut = Some(end);
        }
    }

    /// Selects the pass `step` after the selected one, in cutting order.
    pub fn select_next_pass(&mut self, step: isize) {
        let Some(last) = self.results.passes.passes.len().checked_sub(1) else { return };
        let next = self.look.flank.pass.map_or(0, |now| now.saturating_add_signed(step).min(last));
        self.select_pass(Some(next));
        self.look.flank.reveal = true;
    }
}
