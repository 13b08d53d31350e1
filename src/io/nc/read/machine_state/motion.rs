//! Blocks that move: where tip and axis get to, and what the reader adds between two positions.

use super::{CoordinateMode, NcState, Place};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::nc::read::{AxisOverrun, MAX_OVERRUNS};
use crate::io::source;
use crate::machine::{LINEAR_NAMES, Pose, gauge_length, mixed_angles};
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
        let [Some(x), Some(y), Some(z)] = self.at else {
            // Above the part only single axes may be positioned, and not while the control holds the tip.
            if self.frame == CoordinateMode::Tip && self.at != [None; 3] {
                let what = "the first position after TCP is on is not given whole";
                return Err(self.source.fault(line, what, "give X, Y and Z in one block"));
            }
            return Ok(());
        };
        let Some(tool) = self.tool else {
            return Err(self
                .source
                .fault(line, "a move before the first tool", "change to a tool before")
                .with_code(ErrorCode::ProgramTool));
        };
        if !self.length_on {
            return Err(self.source.fault(line, "a move without the tool's length", "give G43 or D1 before"));
        }
        if self.inverse && !rapid && !rate_here {
            return Err(self.source.fault(line, "no F in a block of inverse time", "give F in each block"));
        }
        let place = self.place(line, [x, y, z], tool)?;
        let rapid = rapid || self.is_fast(&place);
        if !rapid && !self.spindle_on {
            return Err(self.source.fault(line, "a cut while the spindle stands", "start it with M3"));
        }
        let rate = match (self.inverse, self.rate) {
            (true, Some(per_minute)) => {
                let travel = self.before.map_or(0.0, |b| (place.pose.tip - b.pose.tip).norm());
                Some(travel * per_minute).filter(|rate| *rate > 0.0)
            }
            (_, rate) => rate.filter(|rate| *rate > 0.0),
        };
        let motion = if rapid { Motion::Rapid } else { Motion::Feed(rate) };
        self.add(line, motion, place, tool)
    }

    /// The pose of a block, checked against the limits.
    fn place(&mut self, line: usize, at: [f64; 3], tool: usize) -> Result<Place, InputError> {
        let machine = self.machine();
        let length = self.out.program.tools.get(tool).map_or(0.0, |tool| gauge_length(machine, tool));
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
                (Pose { tip, axis: machine.tool_axis(&angles), angles }, joints, true)
            }
            (CoordinateMode::Tip, Some(angles)) => {
                let tip = Point::from(Vector::from(at));
                let joints = machine.joints(&tip, &angles, length);
                (Pose { tip, axis: machine.tool_axis(&angles), angles }, joints, true)
            }
            (CoordinateMode::Tip, None) => {
                let axis = self.vector.ok_or_else(whole)?;
                (Pose { tip: Point::from(Vector::from(at)), axis, angles: [0.0; 2] }, [0.0; 3], false)
            }
            (CoordinateMode::Plane([x, y, z]), _) => {
                let tip = Point::from(x * at[0] + y * at[1] + z * at[2]);
                (Pose { tip, axis: z, angles: [0.0; 2] }, [0.0; 3], false)
            }
        };
        if by_angles {
            self.check_limits(line, &joints, &pose.angles);
        }
        Ok(Place { pose, by_angles, joints, frame_is_joints: self.frame == CoordinateMode::Joints })
    }

    fn check_limits(&mut self, line: usize, joints: &[f64; 3], angles: &[f64; 2]) {
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
            if self.out.overruns.len() < MAX_OVERRUNS {
                self.out.overruns.push(AxisOverrun { line, letter, value, limits });
            }
        }
    }

    /// Whether a block under G1 runs as fast as links do.
    fn is_fast(&self, place: &Place) -> bool {
        let machine = self.machine();
        let Some(rate) = self.rate else { return false };
        if !self.inverse {
            return rate >= RAPID_SHARE * machine.links.rate;
        }
        let Some(before) = self.before.filter(|b| b.by_angles && place.by_angles) else { return false };
        let linear =
            (0..3).map(|i| 60.0 * (place.joints[i] - before.joints[i]).abs() / machine.linear[i].rapid);
        let turn = |i: usize| (place.pose.angles[i] - before.pose.angles[i]).abs();
        let rotary = (0..2).map(|i| turn(i) / machine.rotary[i].rapid_rad_per_s);
        60.0 / rate.max(1e-9) <= RAPID_TIME * linear.chain(rotary).fold(1e-6, f64::max)
    }

    /// Adds a move, and positions before it where the axes leave the even course between two blocks.
    fn add(&mut self, line: usize, motion: Motion, place: Place, tool: usize) -> Result<(), InputError> {
        if let Some(before) = self.before.filter(|b| b.by_angles && place.by_angles) {
            let machine = self.machine();
            let length = self.out.program.tools.get(tool).map_or(0.0, |tool| gauge_length(machine, tool));
            let (a, b) = (&before.pose, &place.pose);
            let joints = place.frame_is_joints && before.frame_is_joints;
            let strays = machine.axis_stray((&a.axis, a.angles), (&b.axis, b.angles)) > MAX_STRAY
                || joints && machine.tip_stray(a, b, length) > MAX_TIP_STRAY;
            if strays {
                let turn = (0..2).map(|i| (b.angles[i] - a.angles[i]).abs()).fold(0.0, f64::max);
                let steps = ((turn / ADDED_TURN).ceil() as usize).clamp(2, MAX_ADDED);
                for k in 1..steps {
                    let share = k as f64 / steps as f64;
                    let angles = mixed_angles(&a.angles, &b.angles, share);
                    let tip = if joints {
                        let at = std::array::from_fn(|i| {
                            before.joints[i] + (place.joints[i] - before.joints[i]) * share
                        });
                        machine.tip(&at, &angles, length)
                    } else {
                        a.tip + (b.tip - a.tip) * share
                    };
                    self.push(line, motion, tip, machine.tool_axis(&angles), tool, Some(angles))?;
                }
            }
        }
        let angles = place.by_angles.then_some(place.pose.angles);
        self.push(line, motion, place.pose.tip, place.pose.axis, tool, angles)?;
        self.before = Some(place);
        Ok(())
    }

    fn push(
        &mut self,
        line: usize,
        motion: Motion,
        tip: Point,
        axis: Vector,
        tool: usize,
        angles: Option<[f64; 2]>,
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
            tip: placed.point_in_part(&tip),
            axis: placed.vector_in_part(&axis),
            tool: Some(tool),
            line,
        });
        self.out.angles.push(angles);
        Ok(())
    }
}
