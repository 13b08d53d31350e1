//! One kinematics for every machine with two rotary axes: turns about lines, forwards and backwards.
//!
//! A table turns the part by `rot(direction, t)` about its point, a head turns the tool in the same manner;
//! the axes are listed from workpiece to tool. So, seen from the part, the tool stands along
//! `rot(k₁, ±t₁) · rot(k₂, ±t₂) · z`, with + for heads and − for tables, whatever the machine. The angles for
//! a direction are Paden and Kahan's second subproblem: two solutions, one at the edge of the reach, or none.

use super::model::{AxisSide, MachineTool, RotaryAxis};
use crate::geometry::{Point, Vector};

/// Direction of the tool nearer to the first rotary axis than this counts as the pole, rad: a sixth of the
/// rounding of angles in programs.
pub const POLE_RAD: f64 = 1e-7;
/// Excess beyond the edge of the reach that is rounding (a squared sine).
const EDGE: f64 = 1e-12;

/// `v` turned about the unit vector `k` by `angle` (rad), by the right hand (Rodrigues).
pub fn turned(k: &Vector, angle: f64, v: &Vector) -> Vector {
    let (sin, cos) = angle.sin_cos();
    v * cos + k.cross(v) * sin + k * (k.dot(v) * (1.0 - cos))
}

/// `p` turned about the line of a rotary axis.
fn turned_about(axis: &RotaryAxis, angle: f64, p: &Point) -> Point {
    axis.point + turned(&axis.direction, angle, &(p - axis.point))
}

/// A body of a machine, between two of its axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineBody {
    /// What the table axis of this index turns.
    Table(usize),
    /// What stands still.
    Base,
    /// What the linear axes move.
    Ram,
    /// What the head axis of this index turns.
    Head(usize),
}

/// Rotary positions for a direction of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleSolution {
    /// Position of the first axis, rad, in (−π, π]; `None` at the pole, where any will do.
    pub first: Option<f64>,
    /// Position of the second axis, rad, in (−π, π].
    pub second: f64,
}

impl MachineTool {
    fn sign(&self, axis: usize) -> f64 {
        if self.rotary[axis].side == AxisSide::Head { 1.0 } else { -1.0 }
    }

    /// `v`, given in the frame of the tool, in that of the part, at rotary positions `angles` (rad).
    pub fn tool_to_part(&self, angles: &[f64; 2], v: &Vector) -> Vector {
        let v = turned(&self.rotary[1].direction, self.sign(1) * angles[1], v);
        turned(&self.rotary[0].direction, self.sign(0) * angles[0], &v)
    }

    /// `v`, given in the frame of the part, in that of the tool: the inverse of [`Self::tool_to_part`].
    pub fn part_to_tool(&self, angles: &[f64; 2], v: &Vector) -> Vector {
        let v = turned(&self.rotary[0].direction, -self.sign(0) * angles[0], v);
        turned(&self.rotary[1].direction, -self.sign(1) * angles[1], &v)
    }

    /// Unit tool axis, tip → holder, in the frame of the part.
    pub fn tool_axis(&self, angles: &[f64; 2]) -> Vector {
        self.tool_to_part(angles, &Vector::z())
    }

    /// Where the heads bring the tip of a tool of `length` mm, seen from the gauge point at rest.
    fn tip_under_heads(&self, angles: &[f64; 2], length: f64) -> Point {
        let mut tip = Point::new(0.0, 0.0, -length);
        for (axis, angle) in self.rotary.iter().zip(angles).rev() {
            if axis.side == AxisSide::Head {
                tip = turned_about(axis, *angle, &tip);
            }
        }
        tip
    }

    /// Machine coordinates X Y Z that put the tip of a tool of `length` mm (gauge point to tip) on `tip`, in
    /// program coordinates, at rotary positions `angles` (rad).
    pub fn joints(&self, tip: &Point, angles: &[f64; 2], length: f64) -> [f64; 3] {
        let mut carried = self.part.origin + tip.coords;
        for (axis, angle) in self.rotary.iter().zip(angles) {
            if axis.side == AxisSide::Table {
                carried = turned_about(axis, *angle, &carried);
            }
        }
        (carried - self.tip_under_heads(angles, length)).into()
    }

    /// The tip in program coordinates at machine coordinates `joints`: the inverse of [`Self::joints`].
    pub fn tip(&self, joints: &[f64; 3], angles: &[f64; 2], length: f64) -> Point {
        let mut tip = self.tip_under_heads(angles, length) + Vector::from(*joints);
        for (axis, angle) in self.rotary.iter().zip(angles).rev() {
            if axis.side == AxisSide::Table {
                tip = turned_about(axis, -angle, &tip);
            }
        }
        tip - self.part.origin.coords
    }

    /// A point of a body of the machine, in program coordinates, when the axes stand at `joints` (mm) and
    /// `angles` (rad). `point` is where it is with all rotary axes at 0: of tables and base in machine
    /// coordinates, of ram and heads seen from the gauge point.
    pub fn body_point(
        &self,
        body: MachineBody,
        point: &Point,
        joints: &[f64; 3],
        angles: &[f64; 2],
    ) -> Point {
        let mut at = *point;
        let is = |axis: usize, side: AxisSide| self.rotary[axis].side == side;
        match body {
            MachineBody::Table(first) => {
                for axis in (first..2).filter(|&axis| is(axis, AxisSide::Table)) {
                    at = turned_about(&self.rotary[axis], angles[axis], &at);
                }
            }
            MachineBody::Base => {}
            MachineBody::Ram => at += Vector::from(*joints),
            MachineBody::Head(last) => {
                for axis in (0..=last).rev().filter(|&axis| is(axis, AxisSide::Head)) {
                    at = turned_about(&self.rotary[axis], angles[axis], &at);
                }
                at += Vector::from(*joints);
            }
        }
        for axis in (0..2).rev().filter(|&axis| is(axis, AxisSide::Table)) {
            at = turned_about(&self.rotary[axis], -angles[axis], &at);
        }
        at - self.part.origin.coords
    }

    /// Machine coordinates of the program's zero: the tip there, all rotary axes at 0. Programs of joint
    /// positions count from it.
    pub fn zero(&self, length: f64) -> [f64; 3] {
        self.joints(&Point::origin(), &[0.0; 2], length)
    }

    /// Rotary positions at which the tool stands along the unit vector `axis`, in the frame of the part; none
    /// where the machine does not reach it. Limits are not looked at.
    pub fn solve(&self, axis: &Vector) -> ([AngleSolution; 2], usize) {
        let (k1, k2, z) = (&self.rotary[0].direction, &self.rotary[1].direction, Vector::z());
        let none = AngleSolution { first: None, second: 0.0 };
        let b = k1.dot(k2);
        let n2 = 1.0 - b * b;
        // The vector w with k₂·w = k₂·z and k₁·w = k₁·v is where both turns meet.
        let alpha = (k1.dot(axis) - b * k2.dot(&z)) / n2;
        let beta = (k2.dot(&z) - b * k1.dot(axis)) / n2;
        let gamma2 = (1.0 - alpha * alpha - beta * beta - 2.0 * alpha * beta * b) / n2;
        if gamma2 < -EDGE {
            return ([none; 2], 0);
        }
        let gamma = gamma2.max(0.0).sqrt();
        let at_pole = k1.cross(axis).norm() < POLE_RAD;
        let angles = |gamma: f64| {
            let w = k1 * alpha + k2 * beta + k1.cross(k2) * gamma;
            AngleSolution {
                first: (!at_pole).then(|| self.sign(0) * angle_about(k1, &w, axis)),
                second: self.sign(1) * angle_about(k2, &z, &w),
            }
        };
        let pair = [angles(gamma), angles(-gamma)];
        (pair, if gamma > 0.0 && !(at_pole && gamma < POLE_RAD) { 2 } else { 1 })
    }
}

/// Angle about the unit vector `k` that turns `from` into `to`, rad.
fn angle_about(k: &Vector, from: &Vector, to: &Vector) -> f64 {
    let (from, to) = (from - k * k.dot(from), to - k * k.dot(to));
    k.dot(&from.cross(&to)).atan2(from.dot(&to))
}
