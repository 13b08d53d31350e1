//! From a program's moves to steps of a cutter in the frame of channel 1.

use super::super::plunges::tool_of;
use super::super::{Fault, channel_of};
use crate::formats::apt::{ClProgram, Motion};
use crate::geometry::{CutterSolid, Point, Vector, rotate_vector_z, rotate_z};
use crate::part::{Channel, Impeller, Setup, Tool};

/// A straight move of a cutter: tip linear, axis linear and normalised, as a controller does it.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Line of the program.
    pub(super) line: usize,
    /// Index of the tool.
    pub(super) tool: usize,
    /// `None` for a rapid; else the feed, mm/min.
    pub(super) feed: Option<f64>,
    /// By how many pitches it lies ahead of channel 1, into which it is turned.
    pub(super) channel: i64,
    pub(super) from: (Point, Vector),
    pub(super) to: (Point, Vector),
}

impl Step {
    /// Tip and axis at `share` of the way.
    pub(super) fn at(&self, share: f64) -> (Point, Vector) {
        let ((p, a), (q, b)) = (self.from, self.to);
        let axis = (a + (b - a) * share).try_normalize(1e-9).unwrap_or(b);
        (p + (q - p) * share, axis)
    }

    /// The cutter at `share` of the way.
    pub(super) fn cutter(&self, tools: &[Tool], share: f64) -> CutterSolid {
        let (tip, axis) = self.at(share);
        tools[self.tool].placed(tip, axis)
    }

    /// Way of the tip, mm.
    pub(super) fn length(&self) -> f64 {
        (self.to.0 - self.from.0).norm()
    }

    /// Turn of the axis, rad.
    pub(super) fn turn(&self) -> f64 {
        self.from.1.angle(&self.to.1)
    }

    /// Whether the cutter stays in its own column.
    pub(super) fn is_axial(&self) -> bool {
        let travel = self.to.0 - self.from.0;
        let across = (travel - self.to.1 * travel.dot(&self.to.1)).norm();
        across < 1e-4 * (1.0 + travel.norm()) && self.turn() < 1e-5
    }

    /// Whether it goes up its own column.
    pub(super) fn is_way_out(&self) -> bool {
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
) -> Result<(Vec<Step>, Vec<Tool>), Fault> {
    let tools: Vec<Tool> = program.tools.iter().map(|t| tool_of(t, setup)).collect();
    let mut steps: Vec<Step> = Vec::with_capacity(program.moves.len());
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
        steps.push(Step { line: step.line, tool: number, feed, channel: 0, from, to });
        last = Some((number, to));
    }
    turn_into_channel(part, channel, &mut steps);
    Ok((steps, tools))
}

/// Turns every stretch of cuts, with the rapids that lead to it, into channel 1.
fn turn_into_channel(part: &Impeller, channel: &Channel, steps: &mut [Step]) {
    let mut start = 0;
    while start < steps.len() {
        let rapids = steps[start..].iter().take_while(|s| s.feed.is_none()).count();
        let cuts = steps[start + rapids..].iter().take_while(|s| s.feed.is_some()).count();
        let end = start + rapids + cuts;
        // Beyond the leading edge a cut may seem to lie in a neighbouring channel: most of it decides.
        let looked_at = if cuts > 0 { start + rapids..end } else { start..end };
        let stride = (looked_at.len() / 15).max(1);
        let mut votes: Vec<i64> =
            steps[looked_at].iter().step_by(stride).map(|s| channel_of(part, channel, &s.to.0)).collect();
        votes.sort_unstable();
        let count = |v: &i64| votes.iter().filter(|w| *w == v).count();
        let channel = votes.iter().copied().max_by_key(|v| (count(v), -v.abs(), *v)).unwrap_or(0);
        let back = -part.pitch() * channel as f64;
        let turned = |(p, a): (Point, Vector)| (rotate_z(&p, back), rotate_vector_z(&a, back));
        for step in &mut steps[start..end] {
            (step.channel, step.from, step.to) = (channel, turned(step.from), turned(step.to));
        }
        start = end;
    }
}
