//! The timeline: how much of the shown operation is cut. It counts the plunges of a plunge plan, and the
//! moves of a flank plan.

use super::AppState;
use crate::app::model::look::{Operation, REVEAL};
use crate::plunge::Position;

/// Positions that a playing timeline cuts per second at speed 1.
pub const PLAY_RATE: f64 = 15.0;
/// Moves of a flank plan in their place: they are shorter.
const FLANK_PLAY_RATE: f64 = 150.0;

/// Where a timeline jumps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// The first plunge of a tool.
    Tool,
    /// The first plunge of a section; of a flank plan the first move of a layer.
    Section,
}

impl AppState {
    fn is_of_flank(&self) -> bool {
        self.look.operation == Operation::Flank
    }

    /// Number of steps of the timeline; 0 where the shown operation has none.
    pub fn timeline_len(&self) -> usize {
        match self.look.operation {
            Operation::Roughing => self.position_count(),
            Operation::Flank => self.results.passes.clock.len(),
            Operation::Program => 0,
        }
    }

    /// Number of steps that are cut; `None`: all.
    pub fn timeline_cut(&self) -> Option<usize> {
        if self.is_of_flank() { self.look.flank.cut } else { self.look.cut_count }
    }

    /// What is selected, as the number of steps up to its end.
    fn selected_end(&self) -> Option<usize> {
        if self.is_of_flank() {
            return self.results.passes.passes.get(self.look.flank.pass?).map(|pass| pass.end);
        }
        self.look.selected.map(|k| k + 1)
    }

    /// Steps that a playing timeline cuts per second.
    pub fn play_rate(&self) -> f64 {
        self.look.play_speed * if self.is_of_flank() { FLANK_PLAY_RATE } else { PLAY_RATE }
    }

    /// Time of the program at the position of the timeline and at its end, s.
    pub fn clock(&self) -> Option<(f64, f64)> {
        let count = self.timeline_len();
        let cut = self.timeline_cut().unwrap_or(count);
        if self.is_of_flank() {
            let passes = &self.results.passes;
            return Some((passes.time_after(cut), passes.time_after(count)));
        }
        let shown = self.shown()?;
        let at = |cut| shown.planned.time_after(shown.policy, cut);
        at(cut).zip(at(count))
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
        if self.is_of_flank() {
            let layers = || self.results.passes.layer_starts.clone();
            return if of == Boundary::Section { layers() } else { Vec::new() };
        }
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let key = |position: &Position| match of {
            Boundary::Section => position.section as u32,
            Boundary::Tool => plan.sections.get(position.section).map_or(0, |s| s.tool.number),
        };
        let keys: Vec<u32> = plan.positions.iter().map(key).collect();
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
        if self.is_of_flank() {
            self.look.flank.cut = cut;
            if let Some(cut) = cut {
                self.look.flank.pass = self.results.passes.pass_after(cut);
                self.look.flank.reveal = true;
            }
            return;
        }
        self.look.cut_count = cut;
        if let Some(cut) = cut {
            self.look.selected = cut.checked_sub(1);
            self.look.reveal_selection = if cut > 0 { REVEAL } else { 0 };
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
            if self.is_at_end() && self.look.play_loop {
                self.set_timeline(Some(0));
            } else {
                self.step_timeline(steps as isize);
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
