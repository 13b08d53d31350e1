//! The retract position, above all else at the upper end of Z: the way to it, what the axes do there, and the
//! way down to the first position that is given whole.

use super::NcState;
use super::place::{CoordinateMode, Place, RetractedTool};
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::nc::read::words::NcWord;
use crate::machine::{MoveAngles, Pose};
use crate::toolpath::{Motion, Move};

/// A position this near to the height of the retract position is at it, mm.
const AT_HEIGHT: f64 = 0.01;
/// Two places nearer than this are one, mm.
const SAME_PLACE: f64 = 1e-6;
/// Least rise of Z along the axis of the tool, for a height to say how far along it the tool stands.
const MIN_RISE: f64 = 0.05;

impl NcState<'_> {
    /// Checks that the tool is retracted.
    pub(super) fn check_retracted(&self, line: usize, when: &str) -> Result<(), InputError> {
        if self.retracted.is_some() {
            return Ok(());
        }
        Err(self.source.fault(line, format!("{when} where the tool stands"), "retract it before"))
    }

    /// To the retract position. What the control calls the upper end of Z the machine file says (`retract`);
    /// its reference point (`G28`) is that end.
    pub(super) fn go_home(&mut self, line: usize, words: &[NcWord]) -> Result<(), InputError> {
        self.check_free(line, "the tool goes to its retract position")?;
        if words.iter().any(|word| matches!(word, NcWord::Rotary(..))) {
            let what = "machine coordinates of rotary axes are not read";
            return Err(self.source.fault(line, what, "give them in a block of their own"));
        }
        let named = |axis: usize| {
            words.iter().find_map(|word| match word {
                NcWord::Linear(of, x) if *of == axis => Some(*x),
                _ => None,
            })
        };
        let is_reference = words.contains(&NcWord::HomeOver);
        if is_reference {
            if self.incremental != Some(true) || (0..3).filter_map(named).any(|x| x != 0.0) {
                let what = "G28 leads over another position than that of the tool";
                return Err(self.source.fault(line, what, "give G91 G28 Z0"));
            }
        } else if self.incremental == Some(true) {
            return Err(self.source.fault(line, "machine coordinates are not absolute", "give G90 before"));
        }
        self.at = [None; 3];
        let Some(z) = named(2) else {
            let Some(retracted) = &mut self.retracted else {
                let what = "the way to the retract position names no Z";
                return Err(self.source.fault(line, what, "retract Z first"));
            };
            for axis in (0..2).filter(|&axis| named(axis).is_some()) {
                retracted.xy[axis] = None;
            }
            return Ok(());
        };
        if named(0).or(named(1)).is_some() {
            let what = "X or Y moves while the tool is retracted";
            return Err(self.source.fault(line, what, "retract Z alone"));
        }
        let mut to = self.retracted.unwrap_or_default();
        let machine = self.machine();
        let called = if is_reference { 0.0 } else { machine.links.retract_z };
        to.z = machine.linear[2].limits.1 + z - called;
        if let Some(Place { pose, joints: Some([x, y, _]), .. }) = self.before {
            (to.xy, to.angles) = ([Some(x), Some(y)], pose.angles.map(Some));
        }
        if let Some((joints, angles)) = to.axes() {
            self.check_limits(line, &joints, &angles);
        }
        self.stand(line, to)
    }

    /// Positions axes at the retract height, or takes the tool there.
    fn stand(&mut self, line: usize, to: RetractedTool) -> Result<(), InputError> {
        let from = self.before.or_else(|| self.place_of(self.retracted.as_ref()?));
        self.before = None;
        if let (Some(from), Some(place), Some(tool)) = (from, self.place_of(&to), self.tool) {
            self.begin(line, &from, tool)?;
            let is_link = self.rapid != Some(false) || self.is_link_rate();
            let motion = if is_link { Motion::Rapid } else { Motion::Feed(self.rate) };
            // The rotary axes stand where they stood, whether the program named them or not.
            self.before = Some(Place { by_angles: true, ..from });
            self.add(line, motion, place, tool, true)?;
            self.before = None;
        }
        self.retracted = Some(to);
        Ok(())
    }

    /// Where the tool in the spindle is at the retract height, if all axes are known.
    fn place_of(&self, retracted: &RetractedTool) -> Option<Place> {
        let (joints, angles) = retracted.axes()?;
        let machine = self.machine();
        let tip = machine.tip(&joints, &angles, self.length_of(self.tool?));
        let pose = Pose { tip, axis: machine.tool_axis(&angles), angles };
        Some(Place { pose, by_angles: true, joints: Some(joints), is_joint_move: true })
    }

    /// Turns the tool square to a plane.
    pub(super) fn swivel(&mut self, line: usize, axis: &Vector) -> Result<(), InputError> {
        let (Some(retracted), Some(angles)) = (self.retracted, self.chosen_angles(axis)) else {
            return Ok(());
        };
        self.stand(line, RetractedTool { angles: angles.map(Some), ..retracted })
    }

    /// A block that does not give the position whole: single axes may only be positioned at the retract
    /// height, and not while the control holds the tip.
    pub(super) fn partly(&mut self, line: usize) -> Result<(), InputError> {
        let linear = self.at != [None; 3];
        if self.frame == CoordinateMode::Tip {
            if !linear {
                return Ok(());
            }
            let what = "the first position after TCP is on is not given whole";
            return Err(self.source.fault(line, what, "give X, Y and Z in one block"));
        }
        let Some(retracted) = self.retracted.filter(|_| self.at[2].is_none()) else {
            let what = "the position is not given whole";
            return Err(self.source.fault(line, what, "give X, Y and Z in one block"));
        };
        let mut to = retracted;
        for (known, named) in to.angles.iter_mut().zip(self.angles) {
            *known = named.or(*known);
        }
        if let CoordinateMode::Plane(frame) = self.frame {
            if let ([Some(x), Some(y)], Some(tool)) = ([self.at[0], self.at[1]], self.tool) {
                self.move_in_plane(&frame, [x, y], self.length_of(tool), &mut to);
            }
        } else {
            // The length of the tool does not count in X and Y.
            let zero = self.machine().zero(0.0);
            for axis in 0..2 {
                to.xy[axis] = self.at[axis].map(|x| x + zero[axis]).or(to.xy[axis]);
            }
        }
        self.stand(line, to)
    }

    /// X and Y of a tilted plane, from where the tool stands; where that is not known, at the retract height.
    fn move_in_plane(&self, frame: &[Vector; 3], [x, y]: [f64; 2], length: f64, to: &mut RetractedTool) {
        let machine = self.machine();
        let [Some(first), Some(second)] = to.angles else { return };
        let angles = [first, second];
        let joints = |along: f64| {
            let tip = Point::from(frame[0] * x + frame[1] * y + frame[2] * along);
            machine.joints(&tip, &angles, length)
        };
        let along = match to.axes() {
            Some((from, angles)) => machine.tip(&from, &angles, length).coords.dot(&frame[2]),
            None => {
                let rise = joints(1.0)[2] - joints(0.0)[2];
                if rise < MIN_RISE {
                    return;
                }
                (to.z - joints(0.0)[2]) / rise
            }
        };
        let [x, y, z] = joints(along);
        (to.xy, to.z) = ([Some(x), Some(y)], z);
    }

    /// The way down to the first position that is given whole starts where the axes stand; a program that
    /// another one calls may begin at the retract height, wherever they stand.
    pub(super) fn come_down(&mut self, line: usize, place: &Place, tool: usize) -> Result<(), InputError> {
        let Some(retracted) = self.retracted else {
            if self.before.is_none() {
                let what = "the first move begins where the tool happens to stand";
                return Err(self.source.fault(line, what, "retract it before"));
            }
            return Ok(());
        };
        let Some(start) = self.place_of(&retracted) else {
            if place.joints.is_some_and(|joints| joints[2] > retracted.z - AT_HEIGHT) {
                return Ok(());
            }
            let what = "the tool comes down from where the program does not say";
            return Err(self.source.fault(
                line,
                what,
                "give X, Y and the rotary axes at the retract position",
            ));
        };
        self.begin(line, &start, tool)?;
        self.before = Some(start);
        Ok(())
    }

    /// Where a way begins that does not go on from the last move.
    fn begin(&mut self, line: usize, start: &Place, tool: usize) -> Result<(), InputError> {
        let tip = self.context.placed.point_in_part(&start.pose.tip);
        let goes_on = |last: &Move| last.tool == Some(tool) && (last.tip - tip).norm() < SAME_PLACE;
        if self.out.program.moves.last().is_some_and(goes_on) {
            return Ok(());
        }
        self.push(line, Motion::Rapid, &start.pose, tool, MoveAngles::Retract(start.pose.angles))
    }
}
