//! The program of a flank plan for several channels: what it cuts in one, turned by the pitch, and links from
//! channel to channel.

use super::opening::PLUNGE_MOVES;
use super::path::RAPID_MARGIN;
use super::{FlankMove, FlankOpening, FlankPlan};
use crate::cutting::channel_link::{ChannelLink, MIN_LIFT};
use crate::geometry::{Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::{Setup, Tool};
use crate::toolpath::{ChannelStep, ClProgram, Motion, Move, OpenedPlaces, order_steps};

/// What a flank plan cuts in one channel.
#[derive(Clone, Copy, Debug)]
pub struct FlankChannel<'a> {
    /// Name of the part.
    pub part_name: &'a str,
    /// The tool of the passes.
    pub tool: &'a Tool,
    /// Its moves.
    pub moves: &'a [FlankMove],
    /// What is cut before.
    pub opening: Option<&'a FlankOpening>,
}

/// A program of several channels.
#[derive(Clone, Debug, Default)]
pub struct FlankChannels {
    /// The program.
    pub program: ClProgram,
    /// For each of its moves the move of the program of one channel that it repeats, its `index`; `None` for
    /// moves from channel to channel.
    pub origins: Vec<Option<ChannelStep>>,
}

impl FlankPlan {
    /// What it cuts in one channel of the part of this name.
    pub fn in_one_channel<'a>(&'a self, part_name: &'a str) -> FlankChannel<'a> {
        let Self { tool, moves, opening, .. } = self;
        FlankChannel { part_name, tool, moves, opening: opening.as_ref() }
    }
}

impl FlankChannel<'_> {
    /// The index among its [`moves`](Self::moves) of move `index` of its program; `None` of the
    /// opening, with which that begins.
    pub fn index_of_pass(&self, index: usize) -> Option<usize> {
        index.checked_sub(self.opening.map_or(0, FlankOpening::move_count))
    }

    /// The program of one channel.
    pub fn program(&self) -> ClProgram {
        ClProgram::of_flank(self.part_name, self.tool, self.moves).after_opening(self.opening)
    }

    /// The program of the first `channels` channels of `part` in the order of `setup`. From channel to
    /// channel the tool leaves the part and goes round it, at the distances of `setup` from `blank`. Plunges
    /// above the shroud that channels share are cut once.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn in_channels(
        &self,
        part: &Impeller,
        blank: &Blank,
        setup: &Setup,
        channels: usize,
        monitor: &Monitor,
    ) -> Result<FlankChannels, Cancelled> {
        let one = self.program();
        let plunges: &[(Point, Point, Vector)] = self.opening.map_or(&[], |opening| &opening.plunges);
        let count = plunges.len();
        let mut writer = ChannelWriter {
            channel: self,
            part,
            blank,
            safety: setup.allowances.safety_distance + RAPID_MARGIN,
            written: FlankChannels {
                program: ClProgram { moves: Vec::new(), ..one.clone() },
                origins: Vec::new(),
            },
        };
        let mut opened = OpenedPlaces::default();
        // The steps of a channel: each plunge, and all passes.
        let stretches = [count, usize::from(!self.moves.is_empty())];
        let steps = order_steps(&stretches, setup.channels, channels, part.blade_count, |channel, index| {
            let plunge = plunges.get(index);
            plunge.is_none_or(|(_, tip, _)| opened.open(tip, part.pitch() * channel as f64))
        });
        let mut last: Option<ChannelStep> = None;
        for step in steps {
            let linked = last.filter(|last| (last.channel, last.index + 1) != (step.channel, step.index));
            let link = self.opening.filter(|_| step.index == count && linked.is_some());
            let first = PLUNGE_MOVES * step.index.min(count) + link.map_or(0, |opening| opening.link.len());
            let end = if step.index < count { first + PLUNGE_MOVES } else { one.moves.len() };
            writer.write(&one.moves[first..end], (first, step), linked, monitor)?;
            last = Some(step);
        }
        Ok(writer.written)
    }
}

struct ChannelWriter<'a> {
    channel: &'a FlankChannel<'a>,
    part: &'a Impeller,
    blank: &'a Blank,
    /// Distance of links from the blank, mm.
    safety: f64,
    written: FlankChannels,
}

impl ChannelWriter<'_> {
    /// Writes the `moves` of a step, the first of which is move `first` of one channel; after a link from the
    /// step `linked`, if any.
    fn write(
        &mut self,
        moves: &[Move],
        (first, step): (usize, ChannelStep),
        linked: Option<ChannelStep>,
        monitor: &Monitor,
    ) -> Result<(), Cancelled> {
        let angle = self.part.pitch() * step.channel as f64;
        for (k, of_one) in moves.iter().enumerate() {
            let (tip, axis) = (rotate_z(&of_one.tip, angle), rotate_vector_z(&of_one.axis, angle));
            let turned = Move { tip, axis, ..of_one.clone() };
            if let Some(last) = linked.filter(|_| k == 0) {
                self.link(&turned, self.turn(last.channel, step.channel), monitor)?;
            }
            self.written.program.moves.push(turned);
            self.written.origins.push(Some(ChannelStep { index: first + k, ..step }));
        }
        Ok(())
    }

    /// The turn from channel to channel the shorter way round, rad.
    fn turn(&self, from: usize, to: usize) -> f64 {
        let count = self.part.blade_count as i64;
        let ahead = (to as i64 - from as i64).rem_euclid(count);
        let shorter = if 2 * ahead > count { ahead - count } else { ahead };
        self.part.pitch() * shorter as f64
    }

    /// Writes the link to a `first` move in another channel, which leads there in rapid. The retract before
    /// goes on to the height of the link.
    fn link(&mut self, first: &Move, turn_rad: f64, monitor: &Monitor) -> Result<(), Cancelled> {
        let FlankChannels { program, origins } = &mut self.written;
        // A tool is changed far from the part.
        let Some(last) = program.moves.last_mut().filter(|last| last.tool == first.tool) else {
            return Ok(());
        };
        let tool = match (self.channel.opening, first.tool) {
            (Some(opening), Some(1)) => &opening.tool,
            _ => self.channel.tool,
        };
        let (from, to) = ((last.tip, last.axis), (first.tip, first.axis));
        let link = ChannelLink { tool, blank: self.blank, safety: self.safety, from, to, turn_rad };
        let mut positions = link.positions(monitor)?;
        let raised = positions[0].0;
        let is_raised = (raised - from.0).norm() >= MIN_LIFT;
        if !is_raised {
            // The last position is that of `first` itself.
            positions.pop();
        }
        let goes_on = is_raised && last.motion != Motion::Rapid;
        if !goes_on {
            last.tip = raised;
        }
        for (tip, axis) in positions.into_iter().skip(usize::from(!goes_on)) {
            program.moves.push(Move { motion: Motion::Rapid, tip, axis, tool: first.tool, line: 0 });
            origins.push(None);
        }
        Ok(())
    }
}
