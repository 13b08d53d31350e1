//! The timeline of the shown plan: how much of it is cut.

use super::AppState;
use crate::app::model::look::REVEAL;
use crate::plunge::Position;

/// Positions that a playing timeline cuts per second at speed 1.
pub const PLAY_RATE: f64 = 15.0;

/// Where a timeline jumps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// The first plunge of a tool.
    Tool,
    /// The first plunge of a section.
    Section,
}

impl AppState {
    /// Indices of the first positions of each section, or after each tool change.
    pub fn boundaries(&self, of: Boundary) -> Vec<usize> {
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let key = |position: &Position| match of {
            Boundary::Section => position.section as u32,
            Boundary::Tool => plan.sections.get(position.section).map_or(0, |s| s.tool.number),
        };
        let keys: Vec<u32> = plan.positions.iter().map(key).collect();
        (0..keys.len()).filter(|&k| k == 0 || keys[k - 1] != keys[k]).collect()
    }

    /// Moves the timeline to the first plunge of the next or previous tool or section, and selects it. At the
    /// end of the timeline it starts from the selected position, else forward from the blank, backward from
    /// the end.
    pub fn jump_to_boundary(&mut self, of: Boundary, forward: bool) {
        let now = self.look.cut_count.or(self.look.selected.map(|k| k + 1));
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

    /// Moves the timeline by `step` positions and selects the position cut last. From the end it starts at
    /// the selected position, if there is one.
    pub fn step_timeline(&mut self, step: isize) {
        let count = self.position_count();
        if count == 0 {
            return;
        }
        let now = self.look.cut_count.unwrap_or_else(|| match self.look.selected {
            Some(k) => k + 1,
            None => count,
        });
        self.set_timeline(Some(now.saturating_add_signed(step).min(count)));
    }

    /// Sets the timeline to after `cut` positions; `None`: the end, with the selection unchanged.
    pub fn set_timeline(&mut self, cut: Option<usize>) {
        let count = self.position_count();
        self.look.cut_count = cut.map(|cut| cut.min(count));
        if let Some(cut) = self.look.cut_count {
            self.look.selected = cut.checked_sub(1);
            self.look.reveal_selection = if cut > 0 { REVEAL } else { 0 };
        }
    }

    /// Starts or stops playing; starts from the blank when the timeline is at the end. `time` in seconds.
    pub fn play(&mut self, time: f64) {
        if self.look.playing.take().is_some() || self.position_count() == 0 {
            return;
        }
        if self.look.cut_count.is_none_or(|cut| cut >= self.position_count()) {
            self.set_timeline(Some(0));
        }
        self.look.playing = Some(time);
    }

    /// Advances a playing timeline; returns the seconds until its next step.
    pub fn advance(&mut self, time: f64) -> Option<f64> {
        let since = self.look.playing?;
        let rate = PLAY_RATE * self.look.play_speed;
        let steps = ((time - since) * rate).floor().clamp(0.0, 1e6);
        if steps >= 1.0 {
            self.look.playing = Some(since + steps / rate);
            let at_end = |state: &Self| state.look.cut_count.is_none_or(|cut| cut >= state.position_count());
            if at_end(self) && self.look.play_loop {
                self.set_timeline(Some(0));
            } else {
                self.step_timeline(steps as isize);
            }
            if at_end(self) && !self.look.play_loop {
                self.look.playing = None;
            }
        }
        self.look.playing.map(|since| (since + 1.0 / rate - time).max(0.0))
    }

    /// Time of the program at the position of the timeline and at its end, s.
    pub fn clock(&self) -> Option<(f64, f64)> {
        let shown = self.shown()?;
        let count = shown.plan().positions.len();
        let at = |cut| shown.planned.time_after(shown.policy, cut);
        at(self.look.cut_count.unwrap_or(count)).zip(at(count))
    }
}
