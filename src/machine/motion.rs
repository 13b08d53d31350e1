//! A cutter-location program as the motion of a machine: rotary positions, points that keep the tool on its
//! course, and links that stay clear of the part.

use super::choice::{MAX_LINK_STRAY, Stretch, choose};
use super::clear::{BlankSize, ClearanceSphere};
use super::course::{Pose, even_turn, mixed_angles};
use super::fault::MotionFault;
use super::model::{MachineTool, OutputKind, TurnLink};
use super::placement::PlacedPart;
use super::step::{MachineStep, StepMotion};
use super::table::table_contact;
use crate::error::{ErrorCode, UserError};
use crate::geometry::Point;
use crate::monitor::Monitor;
use crate::toolpath::{ClProgram, ClTool, Motion};

/// Directions closer than this are the same, rad.
const SAME_AXIS_RAD: f64 = 1e-10;
/// Deviation of the tip and of the axis in links whose tip is held, mm and rad.
const LINK_TOLERANCE: (f64, f64) = (0.01, 0.02 * std::f64::consts::PI / 180.0);
/// Deviation of the bottom of a tool in a link that is no more than the rounding of a clearance, mm.
const SMALL_STRAY: f64 = 5e-4;
/// Halvings of a move under feed.
const MAX_HALVINGS: u32 = 40;
/// Points that one move may be split into.
const MAX_POINTS_PER_MOVE: usize = 20_000;
/// Share of a tolerance that splitting keeps to, as a move is sampled only.
const SAFE_SHARE: f64 = 0.8;
/// What to do where a program turns the tool under feed, which tilted planes cannot do.
pub const INSTEAD_OF_PLANES: &str = "give another --output, such as tcp-angles";

/// How to make the motion.
#[derive(Clone, Copy, Debug)]
pub struct MotionOptions {
    /// What the program will give.
    pub output: OutputKind,
    /// Largest deviation of the tip from its line under feed, mm.
    pub tip_tolerance: f64,
    /// Largest deviation of the axis from its even turn under feed, rad.
    pub axis_tolerance_rad: f64,
    /// Rounding of rotary positions, rad: they are chosen on this grid.
    pub angle_step_rad: f64,
    /// Radius and largest |z| of the blank in the part frame, mm; absent: what the moves say.
    pub blank: Option<BlankSize>,
}

impl MotionOptions {
    /// The options of a post with `angle_decimals` for rotary positions in degrees.
    pub fn new(output: OutputKind, angle_decimals: usize) -> Self {
        Self {
            output,
            tip_tolerance: 0.01,
            axis_tolerance_rad: 0.02f64.to_radians(),
            angle_step_rad: 10f64.powi(-(angle_decimals.min(9) as i32)).to_radians(),
            blank: None,
        }
    }
}

/// The motion of a machine.
#[derive(Clone, Debug, Default)]
pub struct MachineProgram {
    /// Its steps.
    pub steps: Vec<MachineStep>,
    /// Travel of both rotary axes, rad.
    pub rotary_travel: [f64; 2],
    /// Times that a limited axis turns back by more than half a turn.
    pub rewinds: usize,
    /// Links that leave the part before they turn.
    pub clear_links: usize,
    /// Largest deviation of the tip from its line under feed, mm.
    pub tip_error: f64,
    /// Largest deviation of the axis from its even turn under feed, rad.
    pub axis_error_rad: f64,
}

impl MachineProgram {
    /// The motion of a program whose poses are known, one for each move; moves without one are passed over.
    /// Moves of one line are one block: the axes run evenly to the end of the last.
    pub fn of_poses(program: &ClProgram, poses: &[Option<Pose>]) -> Self {
        let mut out = Self::default();
        for (source, (step, pose)) in program.moves.iter().zip(poses).enumerate() {
            let (Some(pose), Some(tool)) = (*pose, step.tool) else { continue };
            let ends_line = program.moves.get(source + 1).is_none_or(|next| next.line != step.line);
            if step.line > 0 && !ends_line {
                continue;
            }
            let motion = match step.motion {
                _ if out.steps.last().is_none_or(|before| before.tool != tool) => StepMotion::Approach,
                Motion::Feed(Some(rate)) if rate > 0.0 => StepMotion::Feed(rate),
                Motion::Feed(_) | Motion::Rapid => StepMotion::Link,
            };
            out.add_step(MachineStep { motion, pose, tool, source });
        }
        out
    }

    /// Adds a step, and its turn from the step before to the travel.
    fn add_step(&mut self, step: MachineStep) {
        if let Some(before) = self.steps.last() {
            for i in 0..2 {
                self.rotary_travel[i] += (step.pose.angles[i] - before.pose.angles[i]).abs();
            }
        }
        self.steps.push(step);
    }
}

/// Length from the gauge point to the tip of a tool, mm.
pub fn gauge_length(machine: &MachineTool, tool: &ClTool) -> f64 {
    tool.overhang.unwrap_or(0.0) + machine.holder_length
}

/// The motion of `machine` for `program`, whose part lies as `placed`.
///
/// # Errors
/// [`MotionFault`] when the machine cannot make a move, a move lacks a tool or a feed rate, or on a cancel.
pub fn machine_program(
    machine: &MachineTool,
    placed: &PlacedPart,
    program: &ClProgram,
    options: &MotionOptions,
    monitor: &Monitor,
) -> Result<MachineProgram, MotionFault> {
    let tips: Vec<Point> = program.moves.iter().map(|m| placed.point_in_program(&m.tip)).collect();
    let stretches = stretches(machine, placed, program)?;
    // The control turns vectors and planes evenly by itself, whatever the positions are.
    let tolerance = match options.output {
        OutputKind::TcpAngles | OutputKind::Joints => SAFE_SHARE * options.axis_tolerance_rad,
        OutputKind::TcpVectors | OutputKind::Plane => f64::INFINITY,
    };
    let choice = choose(machine, &stretches, &tips, tolerance, monitor)?;
    let sphere = ClearanceSphere::new(machine, placed, program, &tips, options.blank);
    let mut maker = MotionMaker {
        machine,
        options,
        sphere,
        out: MachineProgram::default(),
        lengths: program.tools.iter().map(|tool| gauge_length(machine, tool)).collect(),
        radii: program.tools.iter().map(|tool| 0.5 * tool.diameter).collect(),
    };
    maker.out.rewinds = choice.rewinds;
    let grid = |angle: f64| (angle / options.angle_step_rad).round() * options.angle_step_rad;
    for (count, (stretch, angles)) in stretches.iter().zip(&choice.angles).enumerate() {
        if count % 256 == 0 {
            monitor.check()?;
            monitor.report(0.5 + 0.5 * count as f64 / stretches.len() as f64);
        }
        for index in stretch.moves.clone() {
            let (Some(step), Some(tip)) = (program.moves.get(index), tips.get(index)) else { continue };
            let pose = Pose { tip: *tip, axis: stretch.axis, angles: angles.map(grid) };
            maker.add(step.motion, step.line, step.tool.unwrap_or(0), index, pose)?;
        }
    }
    maker.leave();
    maker.measure();
    if let Some(contact) = table_contact(machine, &maker.out.steps, &program.tools, &maker.lengths) {
        let line = program.moves.get(maker.out.steps[contact.step].source).map_or(0, |step| step.line);
        let tool = program.tools.get(contact.tool).map_or(0, |tool| tool.number);
        return Err(MotionFault::MeetsTable {
            line,
            tool,
            is_holder: contact.is_holder,
            depth: contact.depth,
        });
    }
    Ok(maker.out)
}

/// Stretches of moves with one direction and one tool.
fn stretches(
    machine: &MachineTool,
    placed: &PlacedPart,
    program: &ClProgram,
) -> Result<Vec<Stretch>, MotionFault> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut tool = None;
    for (index, step) in program.moves.iter().enumerate() {
        let axis = placed.vector_in_program(&step.axis);
        let Some(cutter) = step.tool.and_then(|t| program.tools.get(t)) else {
            let help = "give the program LOADTL and CUTTER before it";
            let error = UserError::new(ErrorCode::ProgramTool, "the move has no tool", help);
            return Err(MotionFault::Lacks { line: step.line, error });
        };
        match stretches.last_mut() {
            Some(last)
                if tool == step.tool
                    && last.axis.cross(&axis).norm() < SAME_AXIS_RAD
                    && last.axis.dot(&axis) > 0.0 =>
            {
                last.moves.end = index + 1;
            }
            _ => stretches.push(Stretch {
                axis,
                moves: index..index + 1,
                feed_in: tool == step.tool && matches!(step.motion, Motion::Feed(_)),
                length: gauge_length(machine, cutter),
                line: step.line,
            }),
        }
        tool = step.tool;
    }
    Ok(stretches)
}

/// Makes the steps, one move at a time.
struct MotionMaker<'a> {
    machine: &'a MachineTool,
    options: &'a MotionOptions,
    sphere: ClearanceSphere,
    out: MachineProgram,
    /// Gauge lengths and radii of the tools, mm.
    lengths: Vec<f64>,
    radii: Vec<f64>,
}

impl MotionMaker<'_> {
    fn push(&mut self, motion: StepMotion, pose: Pose, tool: usize, source: usize) {
        self.out.add_step(MachineStep { motion, pose, tool, source });
    }

    /// The last step.
    fn last(&self) -> Option<MachineStep> {
        self.out.steps.last().copied()
    }

    /// Out along the axis to the clearance sphere.
    fn leave(&mut self) {
        if let Some(MachineStep { pose, tool, source, .. }) = self.last() {
            let out = self.sphere.outside(&pose);
            if out != pose {
                self.push(StepMotion::Link, out, tool, source);
            }
        }
    }

    fn approach(&mut self, pose: Pose, tool: usize, source: usize) {
        let outside = self.sphere.outside(&pose);
        self.push(StepMotion::Approach, outside, tool, source);
        if outside != pose {
            self.push(StepMotion::Link, pose, tool, source);
        }
    }

    fn add(
        &mut self,
        motion: Motion,
        line: usize,
        tool: usize,
        source: usize,
        pose: Pose,
    ) -> Result<(), MotionFault> {
        let from = match self.last() {
            Some(last) if last.tool == tool => last.pose,
            _ => {
                self.leave();
                self.approach(pose, tool, source);
                return self.check_feed(motion, line).map(|_| ());
            }
        };
        match motion {
            Motion::Rapid => self.link(from, pose, tool, source, line),
            Motion::Feed(_) => {
                let rate = self.check_feed(motion, line)?.unwrap_or_default();
                if self.options.output == OutputKind::Plane && from.angles != pose.angles {
                    let what = "the tool turns under feed, which planes cannot do";
                    let error = UserError::new(ErrorCode::ControlOutput, what, INSTEAD_OF_PLANES);
                    return Err(MotionFault::Lacks { line, error });
                }
                let tolerance = (self.options.tip_tolerance, self.options.axis_tolerance_rad);
                let (poses, stray) = self.split(from, pose, tolerance, line)?;
                self.out.axis_error_rad = self.out.axis_error_rad.max(stray);
                poses.into_iter().for_each(|pose| self.push(StepMotion::Feed(rate), pose, tool, source));
                Ok(())
            }
        }
    }

    /// The feed rate of a move, `None` for a rapid.
    fn check_feed(&self, motion: Motion, line: usize) -> Result<Option<f64>, MotionFault> {
        match motion {
            Motion::Feed(Some(rate)) if rate > 0.0 => Ok(Some(rate)),
            Motion::Feed(_) => {
                let what = "the move under feed has no feed rate";
                let help = "give the program FEDRAT before it";
                Err(MotionFault::Lacks {
                    line,
                    error: UserError::new(ErrorCode::ProgramFeedRate, what, help),
                })
            }
            Motion::Rapid => Ok(None),
        }
    }

    /// A link without cutting.
    fn link(
        &mut self,
        from: Pose,
        to: Pose,
        tool: usize,
        source: usize,
        line: usize,
    ) -> Result<(), MotionFault> {
        if from.angles == to.angles {
            self.push(StepMotion::Link, to, tool, source);
            return Ok(());
        }
        let stray = self.machine.axis_stray((&from.axis, from.angles), (&to.axis, to.angles));
        if self.options.output == OutputKind::Plane {
            self.out.clear_links += 1;
            self.leave();
            self.approach(to, tool, source);
            return Ok(());
        }
        if self.machine.links.turn == TurnLink::Feed && stray <= MAX_LINK_STRAY {
            // Past a pole there may be no way with the tip held: then the tool leaves the part.
            if let Ok((poses, _)) = self.split(from, to, LINK_TOLERANCE, line) {
                let poses = self.raised(from, poses, tool);
                poses.into_iter().for_each(|pose| self.push(StepMotion::Link, pose, tool, source));
                return Ok(());
            }
        }
        self.out.clear_links += 1;
        let step = self.options.angle_step_rad;
        for mut pose in self.sphere.around(self.machine, &from, &to) {
            pose.angles = pose.angles.map(|a| (a / step).round() * step);
            self.push(StepMotion::Link, pose, tool, source);
        }
        Ok(())
    }

    /// The positions of a link whose tip is held, with those between its ends raised along the axis, so that
    /// the bottom of the tool comes no nearer to the blank than on the planned way: between two positions the
    /// machine leaves it, most in the middle, by a parabola, and less than a line that rises from an end by
    /// four times as much.
    fn raised(&self, from: Pose, mut poses: Vec<Pose>, tool: usize) -> Vec<Pose> {
        let strays = matches!(self.options.output, OutputKind::TcpAngles | OutputKind::Joints);
        let (length, radius) = (self.lengths[tool], self.radii[tool]);
        let stray = |a: &Pose, b: &Pose| {
            let turn = self.machine.axis_stray((&a.axis, a.angles), (&b.axis, b.angles));
            let is_held = self.options.output != OutputKind::Joints;
            radius * turn + if is_held { 0.0 } else { self.machine.tip_stray(a, b, length) }
        };
        let Some(&end) = poses.last().filter(|_| strays) else { return poses };
        if poses.len() == 1 {
            if stray(&from, &end) < SMALL_STRAY {
                return poses;
            }
            poses.insert(0, self.middle(&from, &end, LINK_TOLERANCE.1).0);
        }
        let starts = std::iter::once(&from).chain(&poses);
        let most = starts.zip(&poses).map(|(a, b)| stray(a, b)).fold(0.0, f64::max);
        let inner = poses.len() - 1;
        for pose in &mut poses[..inner] {
            pose.tip += pose.axis * (4.0 * most);
        }
        poses
    }

    /// The poses of a move, its end last, so close that tip and axis keep to `tolerance` (mm, rad), and the
    /// largest angle by which they leave the even turn, rad.
    fn split(
        &self,
        from: Pose,
        to: Pose,
        tolerance: (f64, f64),
        line: usize,
    ) -> Result<(Vec<Pose>, f64), MotionFault> {
        let length = self.lengths.get(self.last().map_or(0, |last| last.tool)).copied().unwrap_or_default();
        let close = |a: &Pose, b: &Pose| match self.options.output {
            OutputKind::TcpVectors | OutputKind::Plane => true,
            _ if a.angles == b.angles => true,
            output => {
                let stray = self.machine.axis_stray((&a.axis, a.angles), (&b.axis, b.angles));
                stray <= SAFE_SHARE * tolerance.1
                    && (output != OutputKind::Joints
                        || self.machine.tip_stray(a, b, length) <= SAFE_SHARE * tolerance.0)
            }
        };
        let (mut out, mut largest) = (Vec::new(), 0.0);
        // A stack instead of recursion: ends still to reach, the nearest on top.
        let mut waiting = vec![(to, 0)];
        let mut at = from;
        while let Some((end, depth)) = waiting.pop() {
            if close(&at, &end) {
                out.push(end);
                at = end;
                continue;
            }
            if depth >= MAX_HALVINGS || out.len() > MAX_POINTS_PER_MOVE {
                let tolerance = format!("{} mm and {:.2}°", tolerance.0, tolerance.1.to_degrees());
                return Err(MotionFault::CannotFollow { line, tolerance });
            }
            let (middle, stray) = self.middle(&at, &end, tolerance.1);
            largest = f64::max(largest, stray);
            waiting.push((end, depth + 1));
            waiting.push((middle, depth + 1));
        }
        Ok((out, largest))
    }

    /// The pose half-way between two, and the angle by which its axis leaves the even turn, rad: the mean
    /// rotary positions where they keep to the turn, otherwise the nearest solution of its direction. Where
    /// the axis keeps to the turn all the way and only the tip strays, the way from one solution to the other
    /// may be meant: beside a pole no other positions in between lead there.
    fn middle(&self, from: &Pose, to: &Pose, tolerance: f64) -> (Pose, f64) {
        let grid = |angle: f64| (angle / self.options.angle_step_rad).round() * self.options.angle_step_rad;
        let tip = from.tip + (to.tip - from.tip) * 0.5;
        let axis = even_turn(&from.axis, &to.axis, 0.5);
        let mean = mixed_angles(&from.angles, &to.angles, 0.5).map(grid);
        let held = self.machine.tool_axis(&mean);
        let stray = self.machine.axis_stray((&from.axis, from.angles), (&to.axis, to.angles));
        if stray <= SAFE_SHARE * tolerance || held.angle(&axis) <= 0.25 * tolerance {
            let off = held.cross(&axis).norm().min(1.0).asin();
            return (Pose { tip, axis: held, angles: mean }, off);
        }
        let (solutions, count) = self.machine.solve(&axis);
        let near = |angle: f64, mean: f64| {
            use std::f64::consts::TAU;
            angle + TAU * ((mean - angle) / TAU).round()
        };
        let away = |a: &[f64; 2]| (a[0] - mean[0]).abs().max((a[1] - mean[1]).abs());
        let best = solutions
            .iter()
            .take(count)
            .map(|s| [s.first.map_or(mean[0], |a| near(a, mean[0])), near(s.second, mean[1])])
            .filter(|a| self.machine.rotary.iter().zip(a).all(|(axis, a)| axis.allows(*a)))
            .min_by(|a, b| away(a).total_cmp(&away(b)));
        (Pose { tip, axis, angles: best.map_or(mean, |a| a.map(grid)) }, 0.0)
    }

    /// Measures how far tip and axis leave their course under feed.
    fn measure(&mut self) {
        let joints = self.options.output == OutputKind::Joints;
        if !joints && self.options.output != OutputKind::TcpAngles {
            return;
        }
        let (mut tip, mut axis) = (0.0, self.out.axis_error_rad);
        for pair in self.out.steps.windows(2) {
            let [a, b] = pair else { continue };
            if !matches!(b.motion, StepMotion::Feed(_)) || a.pose.angles == b.pose.angles {
                continue;
            }
            let length = self.lengths.get(b.tool).copied().unwrap_or_default();
            let ends = ((&a.pose.axis, a.pose.angles), (&b.pose.axis, b.pose.angles));
            axis = f64::max(axis, self.machine.axis_stray(ends.0, ends.1));
            if joints {
                tip = f64::max(tip, self.machine.tip_stray(&a.pose, &b.pose, length));
            }
        }
        (self.out.tip_error, self.out.axis_error_rad) = (tip, axis);
    }
}
