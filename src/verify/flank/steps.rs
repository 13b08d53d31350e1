//! Converts the moves of a program to steps of a cutter in the frame of channel 1.

use std::borrow::Cow;

use super::super::Fault;
use super::super::assembly::AssemblyStep;
use super::super::channels::{channel_at, channels_of, is_over_blades};
use crate::cutting::link::AxisTurn;
use crate::geometry::{CutterSolid, Point, Vector, rotate_vector_z, rotate_z};
use crate::part::{Channel, Impeller};
use crate::setup::{Setup, Tool};
use crate::toolpath::{ClProgram, Motion, is_axial};

/// A linear move of a cutter. Under feed the axis is interpolated linearly and normalised, as by a
/// controller; in rapid it turns at a constant rate, as links are planned.
#[derive(Clone, Debug)]
pub(super) struct CutterStep {
    /// Line of the program.
    pub(super) line: usize,
    /// Index of the tool.
    pub(super) tool: usize,
    /// `None` for a rapid; otherwise the feed rate, mm/min.
    pub(super) feed: Option<f64>,
    /// Number of pitches ahead of channel 1, into which the step is rotated.
    pub(super) channel: i64,
    pub(super) from: (Point, Vector),
    pub(super) to: (Point, Vector),
}

impl CutterStep {
    /// Tip and axis at the parameter `share`, 0…1.
    pub(super) fn at(&self, share: f64) -> (Point, Vector) {
        let ((p, a), (q, b)) = (self.from, self.to);
        if self.feed.is_none() {
            return (p + (q - p) * share, AxisTurn::new(a, &b).at(share).0);
        }
        let axis = (a + (b - a) * share).try_normalize(1e-9).unwrap_or(b);
        (p + (q - p) * share, axis)
    }

    /// The cutter at the parameter `share`, 0…1.
    pub(super) fn cutter(&self, tools: &[Tool], share: f64) -> CutterSolid {
        let (tip, axis) = self.at(share);
        tools[self.tool].placed(tip, axis)
    }

    /// As a move of shank and holder.
    pub(super) fn assembly_step(&self) -> AssemblyStep {
        AssemblyStep { tool: self.tool, from: self.from, to: self.to }
    }

    /// The step turned about the axis of rotation by `angle`, rad.
    fn turned(&self, angle: f64) -> Self {
        let turn = |(tip, axis): (Point, Vector)| (rotate_z(&tip, angle), rotate_vector_z(&axis, angle));
        Self { from: turn(self.from), to: turn(self.to), ..self.clone() }
    }

    /// Travel of the tip, mm.
    pub(super) fn length(&self) -> f64 {
        (self.to.0 - self.from.0).norm()
    }

    /// Turn of the axis, rad.
    pub(super) fn turn(&self) -> f64 {
        self.from.1.angle(&self.to.1)
    }

    /// Whether the cutter moves along its own axis.
    pub(super) fn is_axial(&self) -> bool {
        is_axial(&(self.to.0 - self.from.0), &self.from.1, &self.to.1)
    }

    /// Whether the cutter retracts along its own axis.
    pub(super) fn is_retract(&self) -> bool {
        self.is_axial() && (self.to.0 - self.from.0).dot(&self.to.1) >= 0.0
    }
}

/// The steps of a program, and its tools.
///
/// # Errors
/// A cut before any tool, a tool without diameter.
pub(super) fn steps_of(
    part: &Impeller,
    channel: &Channel,
    program: &ClProgram,
    setup: &Setup,
) -> Result<(Vec<CutterStep>, Vec<Tool>), Fault> {
    let tools: Vec<Tool> = program.tools.iter().map(|t| t.completed(setup)).collect();
    let mut steps: Vec<CutterStep> = Vec::with_capacity(program.moves.len());
    let mut last: Option<(usize, (Point, Vector))> = None;
    for (index, step) in program.moves.iter().enumerate() {
        let Some(number) = step.tool else {
            if matches!(step.motion, Motion::Feed(_)) && index > 0 {
                return Err(Fault::before_tool(step.line));
            }
            continue;
        };
        let tool = &tools[number];
        if tool.diameter <= 0.0 {
            return Err(Fault::without_diameter(step.line, tool));
        }
        let to = (step.tip, step.axis);
        let from = last.filter(|(tool, _)| *tool == number).map_or(to, |(_, at)| at);
        let feed = match step.motion {
            Motion::Rapid => None,
            Motion::Feed(rate) => Some(rate.unwrap_or(tool.plunge_feed)),
        };
        steps.push(CutterStep { line: step.line, tool: number, feed, channel: 0, from, to });
        last = Some((number, to));
    }
    rotate_into_channel(part, channel, &mut steps);
    Ok((steps, tools))
}

/// The steps that cut the floor of channel `number`, with their indices: its own, and the plunges of both
/// neighbours, turned to where they are seen from it. Above the shroud channels share plunges.
pub(super) fn floor_steps<'a>(
    part: &Impeller,
    steps: &'a [CutterStep],
    number: i64,
) -> Vec<(usize, Cow<'a, CutterStep>)> {
    let count = part.blade_count as i64;
    let seen = |(k, step): (usize, &'a CutterStep)| {
        let ahead = match (step.channel - number).rem_euclid(count) {
            0 => return Some((k, Cow::Borrowed(step))),
            1 => 1.0,
            behind if behind == count - 1 => -1.0,
            _ => return None,
        };
        let plunges = step.feed.is_some() && step.is_axial() && !step.is_retract();
        plunges.then(|| (k, Cow::Owned(step.turned(ahead * part.pitch()))))
    };
    steps.iter().enumerate().filter_map(seen).collect()
}

/// Rapids and the cuts after them, up to the next rapid, and the channel of most of these cuts.
struct ChannelRun {
    range: std::ops::Range<usize>,
    channel: Option<i64>,
    /// Cutting length, mm; 0 over the blades: plunges that open a channel there also reach over its
    /// neighbours.
    length: f64,
}

/// Rotates every run of cuts, with the rapids before it, into channel 1.
fn rotate_into_channel(part: &Impeller, channel: &Channel, steps: &mut [CutterStep]) {
    let mut stretches: Vec<ChannelRun> = Vec::new();
    let mut start = 0;
    while start < steps.len() {
        let rapids = steps[start..].iter().take_while(|s| s.feed.is_none()).count();
        let cuts = start + rapids
            ..start + rapids + steps[start + rapids..].iter().take_while(|s| s.feed.is_some()).count();
        let stride = (cuts.len() / 15).max(1);
        let tips = || steps[cuts.clone()].iter().step_by(stride).map(|s| &s.to.0);
        let votes: Vec<i64> = tips().filter_map(|tip| channel_at(part, channel, tip)).collect();
        let is_over_blades = tips().all(|tip| is_over_blades(part, tip));
        let count = |v: i64| votes.iter().filter(|w| **w == v).count();
        stretches.push(ChannelRun {
            range: start..cuts.end,
            channel: votes.iter().copied().max_by_key(|&v| (count(v), -v.abs(), v)),
            length: match is_over_blades {
                true => 0.0,
                false => steps[cuts.clone()].iter().map(CutterStep::length).sum(),
            },
        });
        start = cuts.end;
    }
    let votes: Vec<(Option<i64>, f64)> = stretches.iter().map(|s| (s.channel, s.length)).collect();
    for (stretch, channel) in stretches.iter().zip(channels_of(&votes)) {
        let back = -part.pitch() * channel as f64;
        for step in &mut steps[stretch.range.clone()] {
            *step = CutterStep { channel, ..step.turned(back) };
        }
    }
}
