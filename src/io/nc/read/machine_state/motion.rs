//! Blocks that move: where tip and axis get to, and what the reader adds between two positions.

use std::f64::consts::TAU;

use super::place::{CoordinateMode, Place};
use super::{NcState, Said};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::nc::post::Dialect;
use crate::io::nc::read::AxisOverrun;
use crate::io::source;
use crate::machine::{LINEAR_NAMES, MoveAngles, Pose, gauge_length, mixed_angles};
use crate::toolpath::{Motion, Move};

/// A rate this near to that of links, or a block this near to the machine's fastest, is a rapid.
const RAPID_SHARE: f64 = 0.99;
const RAPID_TIME: f64 = 1.05;
/// Stray of the axis in joint space above which positions are added, rad.
const MAX_STRAY: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Stray of the tip above which positions are added, mm.
const MAX_TIP_STRAY: f64 = 0.02;
/// Turn of a rotary axis between added positions, rad, and their largest number.
const ADDED_TURN: f64 = 2.0 * std::f64::consts::PI / 180.0;
const MAX_ADDED: usize = 400;

impl NcState<'_> {
    /// A block that moves.
    pub(super) fn motion(&mut self, line: usize, rate_here: bool) -> Result<(), InputError> {
        let Some(rapid) = self.rapid else {
            return Err(self.source.fault(line, "a move without G0 or G1 before it", "give one of them"));
        };
        if self.awaits_swivel {
            let what = "a move in a tilted plane that the axes did not turn to";
            return Err(self.source.fault(line, what, "have them turn: G53.1, TURN"));
        }
        let [Some(x), Some(y), Some(z)] = self.at else { return self.partly(line) };
        let Some(tool) = self.tool else {
            return Err(self
                .source
                .fault(line, "a move before the first tool", "change to a tool before")
                .with_code(ErrorCode::ProgramTool));
        };
        if !self.length_on {
            return Err(self.source.fault(line, "a move without the tool's length", "give G43 or D1 before"));
        }
        if self.dialect == Dialect::Siemens && self.frame == CoordinateMode::Tip {
            let Said { orientation, interpolation, .. } = self.said;
            if !orientation || !interpolation {
                let what = "how the tool turns is not said";
                return Err(self.source.fault(line, what, "give ORIWKS and ORIAXES or ORIVECT after TRAORI"));
            }
        }
        if self.inverse == Some(true) && !rapid && !rate_here {
            return Err(self.source.fault(line, "no F in a block of inverse time", "give F in each block"));
        }
        if self.inverse.is_none() && !rapid {
            return Err(self.source.fault(line, "what F means is not said", "give G94 before"));
        }
        let place = self.place(line, [x, y, z], tool)?;
        self.come_down(line, &place, tool)?;
        let rapid = rapid || self.is_fast(&place);
        if !rapid && (!self.spindle_on || self.speed.is_none()) {
            let (what, help) = if self.spindle_on {
                ("a cut without a spindle speed", "give S after the tool change")
            } else {
                ("a cut while the spindle stands", "start it with M3")
            };
            return Err(self.source.fault(line, what, help));
        }
        let rate = match (self.inverse, self.rate) {
            (Some(true), Some(per_minute)) => {
                let travel = self.before.map_or(0.0, |b| (place.pose.tip - b.pose.tip).norm());
                Some(travel * per_minute).filter(|rate| *rate > 0.0)
            }
            (_, rate) => rate.filter(|rate| *rate > 0.0),
        };
        let motion = if rapid { Motion::Rapid } else { Motion::Feed(rate) };
        self.add(line, motion, place, tool, false)
    }

    /// The pose of a block, checked against the limits.
    fn place(&mut self, line: usize, at: [f64; 3], tool: usize) -> Result<Place, InputError> {
        let machine = self.machine();
        let length = self.length_of(tool);
        let whole = || self.source.fault(line, "the position of a rotary axis is not known", "give both");
        let angles = match self.angles {
            [Some(a), Some(b)] => Some([a, b]),
            _ => None,
        };
        let (pose, joints, by_angles) = match (self.frame, angles) {
            (CoordinateMode::Joints, angles) => {
                let angles = angles.ok_or_else(whole)?;
                let zero = machine.zero(length);
                let joints: [f64; 3] = std::array::from_fn(|i| at[i] + zero[i]);
                let tip = machine.tip(&joints, &angles, length);
                (Pose { tip, axis: machine.tool_axis(&angles), angles }, Some(joints), true)
            }
            (CoordinateMode::Tip, Some(angles)) => {
                let tip = Point::from(Vector::from(at));
                let joints = machine.joints(&tip, &angles, length);
                (Pose { tip, axis: machine.tool_axis(&angles), angles }, Some(joints), true)
            }
            (frame, _) => {
                let (tip, axis) = match frame {
                    CoordinateMode::Plane([x, y, z]) => (Point::from(x * at[0] + y * at[1] + z * at[2]), z),
                    _ => (Point::from(Vector::from(at)), self.vector.ok_or_else(whole)?),
                };
                let chosen = self.chosen_angles(&axis);
                let joints = chosen.map(|angles| machine.joints(&tip, &angles, length));
                (Pose { tip, axis, angles: chosen.unwrap_or_default() }, joints, false)
            }
        };
        if let Some(joints) = joints.filter(|_| by_angles) {
            self.check_limits(line, &joints, &pose.angles);
        }
        Ok(Place { pose, by_angles, joints, is_joint_move: self.frame == CoordinateMode::Joints })
    }

    /// Length of a tool from the gauge point, mm.
    pub(super) fn length_of(&self, tool: usize) -> f64 {
        self.out.program.tools.get(tool).map_or(0.0, |tool| gauge_length(self.machine(), tool))
    }

    /// Rotary positions that a control chooses for a direction: within the limits, the nearest to where the
    /// axes stand.
    pub(super) fn chosen_angles(&self, axis: &Vector) -> Option<[f64; 2]> {
        let machine = self.machine();
        let now = match (self.before, self.retracted) {
            (Some(Place { pose, joints: Some(_), .. }), _) => pose.angles,
            (_, Some(retracted)) => retracted.angles.map(Option::unwrap_or_default),
            _ => [0.0; 2],
        };
        let (solutions, count) = machine.solve(axis);
        let near = |axis: usize, angle: f64| {
            let turned = angle + TAU * ((now[axis] - angle) / TAU).round();
            let axis = &machine.rotary[axis];
            if axis.allows(turned) {
                return Some(turned);
            }
            let away = |a: &f64| (a - turned).abs();
            axis.turns_within_limits(angle).min_by(|a, b| away(a).total_cmp(&away(b)))
        };
        let solutions = solutions.iter().take(count).filter_map(|solution| {
            Some([near(0, solution.first.unwrap_or(now[0]))?, near(1, solution.second)?])
        });
        let turn = |angles: &[f64; 2]| (0..2).map(|i| (angles[i] - now[i]).abs()).fold(0.0, f64::max);
        solutions.min_by(|a, b| turn(a).total_cmp(&turn(b)))
    }

    pub(super) fn check_limits(&mut self, line: usize, joints: &[f64; 3], angles: &[f64; 2]) {
        let machine = self.machine();
        let mut found = Vec::new();
        if let Some(axis) = machine.linear_axis_beyond(joints) {
            found.push((LINEAR_NAMES[axis], joints[axis], machine.linear[axis].limits));
        }
        for (axis, angle) in machine.rotary.iter().zip(angles) {
            if let Some((low, high)) = axis.limits.filter(|_| !axis.allows(*angle)) {
                found.push((axis.letter, angle.to_degrees(), (low.to_degrees(), high.to_degrees())));
            }
        }
        for (letter, value, limits) in found {
            self.out.overruns.push(AxisOverrun { line, letter, value, limits });
        }
    }

    /// Whether a block under G1 runs as fast as links do.
    fn is_fast(&self, place: &Place) -> bool {
        let machine = self.machine();
        let Some(rate) = self.rate else { return false };
        if self.inverse != Some(true) {
            return self.is_link_rate();
        }
        let Some(before) = self.before.filter(|b| b.by_angles && place.by_angles) else { return false };
        let (Some(from), Some(to)) = (before.joints, place.joints) else { return false };
        let linear = (0..3).map(|i| 60.0 * (to[i] - from[i]).abs() / machine.linear[i].rapid);
        let turn = |i: usize| (place.pose.angles[i] - before.pose.angles[i]).abs();
        let rotary = (0..2).map(|i| turn(i) / machine.rotary[i].rapid_rad_per_s);
        60.0 / rate.max(1e-9) <= RAPID_TIME * linear.chain(rotary).fold(1e-6, f64::max)
    }

    /// Whether the feed rate is that of links.
    pub(super) fn is_link_rate(&self) -> bool {
        let limit = RAPID_SHARE * self.machine().links.rate;
        self.inverse != Some(true) && self.rate.is_some_and(|rate| rate >= limit)
    }

    /// Adds a move, and positions before it where the axes leave the even course between two blocks.
    pub(super) fn add(
        &mut self,
        line: usize,
        motion: Motion,
        place: Place,
        tool: usize,
        is_retract: bool,
    ) -> Result<(), InputError> {
        if let Some(before) = self.before.filter(|b| b.by_angles && place.by_angles) {
            let machine = self.machine();
            let length = self.length_of(tool);
            let (a, b) = (&before.pose, &place.pose);
            let ends = before.joints.zip(place.joints).filter(|_| place.is_joint_move);
            let joints = ends.is_some();
            let strays = machine.axis_stray((&a.axis, a.angles), (&b.axis, b.angles)) > MAX_STRAY
                || joints && machine.tip_stray(a, b, length) > MAX_TIP_STRAY;
            if strays {
                let turn = (0..2).map(|i| (b.angles[i] - a.angles[i]).abs()).fold(0.0, f64::max);
                let steps = ((turn / ADDED_TURN).ceil() as usize).clamp(2, MAX_ADDED);
                for k in 1..steps {
                    let share = k as f64 / steps as f64;
                    let angles = mixed_angles(&a.angles, &b.angles, share);
                    let tip = if let Some((from, to)) = ends {
                        let at = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * share);
                        machine.tip(&at, &angles, length)
                    } else {
                        a.tip + (b.tip - a.tip) * share
                    };
                    let pose = Pose { tip, axis: machine.tool_axis(&angles), angles };
                    self.push(line, motion, &pose, tool, named(is_retract, angles))?;
                }
            }
        }
        let angles = match (is_retract, place.by_angles) {
            (false, false) => MoveAngles::Chosen,
            _ => named(is_retract, place.pose.angles),
        };
        self.push(line, motion, &place.pose, tool, angles)?;
        self.before = Some(place);
        self.retracted = None;
        Ok(())
    }

    pub(super) fn push(
        &mut self,
        line: usize,
        motion: Motion,
        pose: &Pose,
        tool: usize,
        angles: MoveAngles,
    ) -> Result<(), InputError> {
        if self.out.program.moves.len() >= source::MAX_MOVES {
            return Err(self
                .source
                .fault(line, "the program has more than 4,000,000 moves", "split it")
                .with_code(ErrorCode::FileTooLarge));
        }
        let placed = &self.context.placed;
        if let (Motion::Feed(rate), Some(cutter)) = (motion, self.out.program.tools.get_mut(tool)) {
            cutter.feed_mm_per_min = cutter.feed_mm_per_min.or(rate);
        }
        self.out.program.moves.push(Move {
            motion,
            tip: placed.point_in_part(&pose.tip),
            axis: placed.vector_in_part(&pose.axis),
            tool: Some(tool),
            line,
        });
        self.out.angles.push(angles);
        Ok(())
    }
}

/// Rotary positions of a move that is known.
fn named(is_retract: bool, angles: [f64; 2]) -> MoveAngles {
    if is_retract { MoveAngles::Retract(angles) } else { MoveAngles::Named(angles) }
}
