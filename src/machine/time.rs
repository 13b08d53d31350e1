//! How long the machine takes: every block in joint space, under speed, acceleration and jerk of each axis.
//!
//! A control looks ahead: at each corner between two blocks the speed is the highest at which no axis jumps
//! by more than its acceleration allows within the control's corner time; a forward and a backward pass over
//! the blocks make all corner speeds reachable (as LinuxCNC and Grbl plan). Within a block the speed follows
//! an S-curve: up, steady, down.

use super::model::MachineTool;
use super::motion::{MachineProgram, gauge_length};
use super::step::StepMotion;
use crate::geometry::Point;
use crate::toolpath::ClProgram;

/// mm to which a radian of a rotary axis is compared in the length of a block: it only scales speeds.
const MM_PER_RAD: f64 = 100.0;
/// Blocks shorter than this do not move.
const NO_MOTION: f64 = 1e-9;
/// Halvings in the search for a speed.
const HALVINGS: usize = 30;

/// Time of a section of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionTime {
    /// Number of the section, from 1; `None` for programs without sections.
    pub section: Option<usize>,
    /// Index of the tool.
    pub tool: usize,
    /// Under feed, s.
    pub feed_s: f64,
    /// In links, s.
    pub links_s: f64,
    /// Of `links_s`, what turns a rotary axis, s.
    pub turns_s: f64,
    /// Tool change before it, s.
    pub tool_change_s: f64,
}

impl SectionTime {
    /// All of it, s.
    pub fn total_s(&self) -> f64 {
        self.feed_s + self.links_s + self.tool_change_s
    }
}

/// Time of a program on its machine, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MachineTime {
    /// All of it, with accelerations and tool changes.
    pub total_s: f64,
    /// Of it, the tool changes.
    pub tool_changes_s: f64,
}

impl MachineTime {
    /// That of all `sections` of a program.
    pub fn of_sections(sections: &[SectionTime]) -> Self {
        Self {
            total_s: sections.iter().map(SectionTime::total_s).sum(),
            tool_changes_s: sections.iter().map(|section| section.tool_change_s).sum(),
        }
    }
}

/// A block: what its axes do.
struct Block {
    /// Length, and highest speed along it.
    length: f64,
    speed: f64,
    acceleration: f64,
    jerk: f64,
    /// Travel of the axes per unit of length.
    direction: [f64; 5],
    /// Corner speed at its end.
    exit: f64,
}

/// Times of all sections of `motion`, in their order.
pub fn section_times(
    machine: &MachineTool,
    program: &ClProgram,
    motion: &MachineProgram,
) -> Vec<SectionTime> {
    let mut sections: Vec<SectionTime> = Vec::new();
    for (k, (step, time)) in motion.steps.iter().zip(step_times(machine, program, motion)).enumerate() {
        let row = program.rows.partition_point(|row| row.first_move <= step.source);
        let section = row.checked_sub(1).and_then(|row| program.rows.get(row)).map(|row| row.section + 1);
        if sections.last().is_none_or(|last| (last.section, last.tool) != (section, step.tool)) {
            sections.push(SectionTime { section, tool: step.tool, ..SectionTime::default() });
        }
        let Some(last) = sections.last_mut() else { continue };
        let before = k.checked_sub(1).and_then(|k| motion.steps.get(k));
        match step.motion {
            StepMotion::Feed(_) => last.feed_s += time,
            StepMotion::Approach if before.is_some_and(|before| before.tool == step.tool) => {
                last.links_s += time;
            }
            StepMotion::Approach => last.tool_change_s += time,
            StepMotion::Link => {
                last.links_s += time;
                if before.is_some_and(|before| before.pose.angles != step.pose.angles) {
                    last.turns_s += time;
                }
            }
        }
    }
    sections
}

/// Time of each step, s, with the tool change where one leads to it.
fn step_times(machine: &MachineTool, program: &ClProgram, motion: &MachineProgram) -> Vec<f64> {
    let mut times = block_times(machine, program, motion);
    let mut tool = None;
    for (step, time) in motion.steps.iter().zip(&mut times) {
        if step.motion == StepMotion::Approach && tool != Some(step.tool) {
            *time = machine.tool_change_s;
        }
        tool = Some(step.tool);
    }
    times
}

/// Time from the start of `program` to the end of each of its moves, s, with tool changes.
pub fn move_clock(machine: &MachineTool, program: &ClProgram, motion: &MachineProgram) -> Vec<f64> {
    let mut clock = vec![0.0; program.moves.len()];
    let mut now = 0.0;
    for (step, time) in motion.steps.iter().zip(step_times(machine, program, motion)) {
        now += time;
        if let Some(end) = clock.get_mut(step.source) {
            *end = now;
        }
    }
    // A move that moves nothing has no step.
    let mut last = 0.0;
    for end in &mut clock {
        last = f64::max(last, *end);
        *end = last;
    }
    clock
}

/// Time of each step, s.
pub fn block_times(machine: &MachineTool, program: &ClProgram, motion: &MachineProgram) -> Vec<f64> {
    let limits = axis_limits(machine);
    let mut blocks: Vec<Option<Block>> = Vec::with_capacity(motion.steps.len());
    let mut before: Option<[f64; 5]> = None;
    let mut tip = Point::origin();
    let mut tool = None;
    for step in &motion.steps {
        // The way from tool to tool is part of the tool change.
        if step.motion == StepMotion::Approach && tool != Some(step.tool) {
            before = None;
        }
        tool = Some(step.tool);
        let length = program.tools.get(step.tool).map_or(0.0, |tool| gauge_length(machine, tool));
        let [x, y, z] = machine.joints(&step.pose.tip, &step.pose.angles, length);
        let at = [x, y, z, step.pose.angles[0], step.pose.angles[1]];
        let travel = before.map_or([0.0; 5], |b| std::array::from_fn(|i| at[i] - b[i]));
        let rate = match step.motion {
            StepMotion::Feed(rate) => rate,
            StepMotion::Link | StepMotion::Approach => machine.links.rate,
        } / 60.0;
        let wanted = (step.pose.tip - tip).norm() / rate;
        blocks.push(before.and_then(|_| Block::new(machine, &limits, &travel, wanted)));
        (before, tip) = (Some(at), step.pose.tip);
    }
    let stops = |k: usize| motion.steps.get(k).is_some_and(|step| step.motion == StepMotion::Approach);
    look_ahead(&limits, machine.corner_time_s, &mut blocks, stops);
    let mut entry = 0.0;
    let mut times = Vec::with_capacity(blocks.len());
    for block in &blocks {
        times.push(match block {
            Some(block) => block.time(entry).max(machine.block_time_s),
            None => 0.0,
        });
        entry = block.as_ref().map_or(0.0, |block| block.exit);
    }
    times
}

impl MachineTool {
    /// Time of a straight move of the linear axis that takes longest for it, s: `length` (mm) from rest to
    /// rest, at no more than `rate` (mm/min).
    pub fn straight_s(&self, length: f64, rate: f64) -> f64 {
        (0..3).map(|i| self.lone_move_s(i, length, length / rate * 60.0)).fold(0.0, f64::max)
    }

    /// Time in which the slower rotary axis turns by `angle` (rad) from rest to rest, s.
    pub fn turn_s(&self, angle: f64) -> f64 {
        (3..5).map(|i| self.lone_move_s(i, angle, 0.0)).fold(0.0, f64::max)
    }

    /// Time of a move of one axis from rest to rest that is programmed to take `wanted` seconds.
    fn lone_move_s(&self, axis: usize, distance: f64, wanted: f64) -> f64 {
        let mut travel = [0.0; 5];
        travel[axis] = distance;
        let block = Block::new(self, &axis_limits(self), &travel, wanted);
        block.map_or(0.0, |block| block.time(0.0).max(self.block_time_s))
    }
}

/// Speed, acceleration and jerk of the five axes.
fn axis_limits(machine: &MachineTool) -> [(f64, f64, f64); 5] {
    std::array::from_fn(|i| match (machine.linear.get(i), machine.rotary.get(i.saturating_sub(3))) {
        (Some(axis), _) => (axis.rapid / 60.0, axis.acceleration, axis.jerk),
        (None, Some(axis)) => (axis.rapid_rad_per_s, axis.acceleration, axis.jerk),
        (None, None) => (f64::INFINITY, f64::INFINITY, f64::INFINITY),
    })
}

/// Sets the corner speeds.
fn look_ahead(
    limits: &[(f64, f64, f64); 5],
    corner_time: f64,
    blocks: &mut [Option<Block>],
    stops: impl Fn(usize) -> bool,
) {
    let mut entry = 0.0;
    for k in 0..blocks.len() {
        let (done, rest) = blocks.split_at_mut(k + 1);
        let Some(block) = done[k].as_mut() else {
            entry = 0.0;
            continue;
        };
        let corner = match rest.first() {
            Some(Some(next)) if !stops(k + 1) => block.corner(next, limits, corner_time),
            _ => 0.0,
        };
        block.exit = corner.min(block.reachable(entry));
        entry = block.exit;
    }
    let mut exit = 0.0;
    for k in (0..blocks.len()).rev() {
        let Some(block) = blocks[k].as_mut() else {
            exit = 0.0;
            continue;
        };
        block.exit = block.exit.min(exit);
        exit = block.reachable(block.exit);
    }
}

impl Block {
    /// A block of `travel` (mm, rad) that is programmed to take `wanted` seconds; `None` when nothing moves.
    fn new(
        machine: &MachineTool,
        limits: &[(f64, f64, f64); 5],
        travel: &[f64; 5],
        wanted: f64,
    ) -> Option<Self> {
        let scaled = |i: usize| travel[i] * if i < 3 { 1.0 } else { MM_PER_RAD };
        let length = (0..5).map(|i| scaled(i) * scaled(i)).sum::<f64>().sqrt();
        if length < NO_MOTION {
            return None;
        }
        let direction: [f64; 5] = std::array::from_fn(|i| travel[i] / length);
        let least = |limit: &dyn Fn(usize) -> f64| {
            let allowed = |i: usize| limit(i) / direction[i].abs().max(1e-12);
            (0..5).map(allowed).fold(f64::INFINITY, f64::min)
        };
        let speed = (length / wanted.max(machine.block_time_s)).min(least(&|i| limits[i].0));
        let (acceleration, jerk) = (least(&|i| limits[i].1), least(&|i| limits[i].2));
        Some(Self { length, speed, acceleration, jerk, direction, exit: 0.0 })
    }

    /// Highest speed at the corner to `next`.
    fn corner(&self, next: &Self, limits: &[(f64, f64, f64); 5], corner_time: f64) -> f64 {
        let jump = |i: usize| (next.direction[i] - self.direction[i]).abs().max(1e-12);
        let allowed = (0..5).map(|i| limits[i].1 * corner_time / jump(i)).fold(f64::INFINITY, f64::min);
        allowed.min(self.speed).min(next.speed)
    }

    /// Time of an S-curve over a change of speed.
    fn ramp_time(&self, change: f64) -> f64 {
        let (a, j) = (self.acceleration, self.jerk);
        if !j.is_finite() {
            change / a
        } else if change >= a * a / j {
            change / a + a / j
        } else {
            2.0 * (change / j).sqrt()
        }
    }

    /// Distance over which the speed changes between two values.
    fn ramp_length(&self, low: f64, high: f64) -> f64 {
        0.5 * (low + high) * self.ramp_time(high - low)
    }

    /// Highest speed at one end when that at the other is `from`.
    fn reachable(&self, from: f64) -> f64 {
        let (mut low, mut high) = (from.min(self.speed), self.speed);
        if self.ramp_length(low, high) <= self.length {
            return high;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.ramp_length(from, middle) <= self.length { low = middle } else { high = middle }
        }
        low
    }

    /// Time of the block with the speed `entry` at its start, s.
    fn time(&self, entry: f64) -> f64 {
        let exit = self.exit;
        let ramps = |peak: f64| self.ramp_length(entry, peak) + self.ramp_length(exit, peak);
        let (mut low, mut high) = (entry.max(exit), self.speed.max(entry).max(exit));
        if ramps(high) > self.length {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if ramps(middle) <= self.length { low = middle } else { high = middle }
            }
            high = low;
        }
        let steady = (self.length - ramps(high)).max(0.0);
        self.ramp_time(high - entry) + self.ramp_time(high - exit) + steady / high.max(1e-9)
    }
}
