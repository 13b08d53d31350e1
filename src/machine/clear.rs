//! Links that leave the part: out along the axis to a sphere, around it while the axes turn, in again.
//!
//! On the sphere the way from its centre to the tip never points against the tool's axis, so that shank and
//! holder, further out along the axis, are further from the centre than the tip. Seen from the tool, such
//! ways fill a half-sphere, in which the shorter great circle from one to another stays: the tip follows it
//! while the rotary axes turn, whatever they do, and the tool keeps clear all the way.

use super::course::{Pose, even_turn, mixed_angles};
use super::model::MachineTool;
use super::placement::PlacedPart;
use crate::geometry::Point;
use crate::part::Impeller;
use crate::setup::AllowanceSetup;
use crate::toolpath::ClProgram;

/// Largest turn of a rotary axis in one step, rad.
const MAX_STEP_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Share of the clearance that a straight step may cut off the sphere.
const SAG_SHARE: f64 = 0.25;

/// Extent of the blank in the part frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlankSize {
    /// Largest distance from the axis of rotation.
    pub radius: f64,
    /// Lowest and highest z.
    pub z: (f64, f64),
}

impl BlankSize {
    /// That of the outline that the allowances give, else of the body between hub and shroud.
    pub fn from_part(part: &Impeller, allowances: &AllowanceSetup) -> Self {
        if let Some(outline) = allowances.blank_of(part).outline() {
            let (radius, z) = outline.bounds();
            return Self { radius, z };
        }
        let places = (0..=20).map(|i| f64::from(i) / 20.0);
        let points: Vec<_> = places.flat_map(|s| [part.hub.point(s), part.shroud.point(s)]).collect();
        let low = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        Self { radius: points.iter().map(|p| p.r).fold(0.0, f64::max), z: (low, high) }
    }
}

/// A sphere around all that is cut, with the widest tool and the clearance added, in program coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClearanceSphere {
    centre: Point,
    radius: f64,
    step_rad: f64,
}

impl ClearanceSphere {
    /// The sphere about all `tips` and the blank.
    pub fn new(
        machine: &MachineTool,
        placed: &PlacedPart,
        program: &ClProgram,
        tips: &[Point],
        blank: Option<BlankSize>,
    ) -> Self {
        let mut points = tips.to_vec();
        if let Some(blank) = blank {
            let rim = |z: f64| placed.point_in_program(&Point::new(blank.radius, 0.0, z));
            points.extend([rim(blank.z.0), rim(blank.z.1)]);
        }
        let low = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        let middle = 0.5 * (low + high);
        let centre = Point::new(0.0, 0.0, if middle.is_finite() { middle } else { 0.0 });
        let reach = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        // The holder is assumed to have twice the diameter of its cutter.
        let tool = program.tools.iter().map(|tool| tool.diameter).fold(0.0, f64::max);
        let radius = reach + tool + machine.links.clearance;
        let sag = (1.0 - SAG_SHARE * machine.links.clearance / radius).clamp(-1.0, 1.0);
        Self { centre, radius, step_rad: (2.0 * sag.acos()).clamp(1e-2, MAX_STEP_RAD) }
    }

    /// `pose` moved out along its axis onto the sphere.
    pub fn outside(&self, pose: &Pose) -> Pose {
        let from = pose.tip - self.centre;
        let along = from.dot(&pose.axis);
        let lift = (along * along + self.radius * self.radius - from.norm_squared()).max(0.0).sqrt() - along;
        Pose { tip: pose.tip + pose.axis * lift.max(0.0), ..*pose }
    }

    /// The poses of a link from one pose to another by way of the sphere, without the first.
    pub fn around(&self, machine: &MachineTool, from: &Pose, to: &Pose) -> Vec<Pose> {
        let (start, end) = (self.outside(from), self.outside(to));
        let seen =
            |pose: &Pose| machine.part_to_tool(&pose.angles, &(pose.tip - self.centre)).try_normalize(1e-9);
        let mut poses = Vec::new();
        if start != *from {
            poses.push(start);
        }
        if let (Some(a), Some(b)) = (seen(&start), seen(&end)) {
            let turn = (0..2).map(|i| (to.angles[i] - from.angles[i]).abs()).fold(a.angle(&b), f64::max);
            let steps = (turn / self.step_rad).ceil().clamp(1.0, 1e4) as usize;
            for k in 1..steps {
                let share = k as f64 / steps as f64;
                let angles = mixed_angles(&from.angles, &to.angles, share);
                let away = machine.tool_to_part(&angles, &even_turn(&a, &b, share));
                let tip = self.centre + away * self.radius;
                poses.push(Pose { tip, axis: machine.tool_axis(&angles), angles });
            }
        }
        poses.push(end);
        if end != *to {
            poses.push(*to);
        }
        poses
    }
}
