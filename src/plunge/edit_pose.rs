//! Poses that are given by hand: a plunge moved over the hub and turned, and what a plan says of a pose that
//! its planner did not make.

use super::context::PlanContext;
use super::cut::raise_to_allowance;
use super::plan::{Position, Unevaluated};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::{Meridional, Point, Vector, wrap_angle};
use crate::setup::{PlungeMove, PlungePose, Tool};

/// Directions at a point of the hub, unit vectors of the part's frame, all at right angles to its normal.
struct FloorFrame {
    /// s and λ of the point.
    s: f64,
    lambda: f64,
    normal: Vector,
    /// Along the channel towards the inlet.
    inwards: Vector,
    /// Across it, towards its pressure side.
    across: Vector,
    /// Along the meridian towards the inlet: lead angles are measured in its plane.
    meridian: Vector,
    /// Around the axis of rotation, towards the pressure side.
    around: Vector,
}

impl FloorFrame {
    /// At the foot of `point` on the hub. Where the walls do not reach, the channel runs along the meridian.
    fn at(context: &PlanContext, point: &Point) -> Self {
        let (part, passage) = (&context.workpiece.part, &context.workpiece.channel.full);
        let (arc, _) = part.hub.curve().project(Meridional::from_point(point));
        let (s, theta) = (part.hub.s_at(arc), point.y.atan2(point.x));
        let foot = part.hub.at(s);
        let normal = foot.normal.direction_at_angle(theta);
        let lambda = passage.wall_angles(part, s, 0.0).map(|[low, high]| {
            let width = high - low;
            // The turn of the point from the middle of the channel: it may lie a little beyond a wall.
            0.5 + wrap_angle(theta - low - 0.5 * width) / width
        });
        let meridian = -foot.tangent.direction_at_angle(theta);
        let upstream = lambda.and_then(|lambda| Some(-passage.point(part, s, lambda, 0.0)?.by_s));
        let flat = upstream.map(|upstream| upstream - normal * upstream.dot(&normal));
        let inwards = flat.and_then(|flat| flat.try_normalize(1e-9)).unwrap_or(meridian);
        let sense = passage.wall_angles(part, 0.5, 0.0).map_or(1.0, |[low, high]| (high - low).signum());
        let around = Vector::new(-theta.sin(), theta.cos(), 0.0) * sense;
        let across = normal.cross(&inwards);
        let across = across * across.dot(&around).signum();
        Self { s, lambda: lambda.unwrap_or(0.5), normal, inwards, across, meridian, around }
    }
}

/// `vector` turned by `angle` (rad) from unit vector `from` towards unit vector `to`, at right angles to it
/// (Rodrigues' formula).
fn turned(vector: &Vector, from: &Vector, to: &Vector, angle: f64) -> Vector {
    let about = from.cross(to);
    let (sin, cos) = angle.sin_cos();
    vector * cos + about.cross(vector) * sin + about * (about.dot(vector) * (1.0 - cos))
}

/// The hub, offset by what a cutter has to keep from it with the middle of its corner.
fn depth_surface<'c>(context: &'c PlanContext, tool: &Tool) -> DepthSurface<'c> {
    let offset = context.setup.allowances.hub_allowance + tool.corner_radius;
    DepthSurface::new(context.workpiece.part.hub.curve(), offset)
}

/// The plunge of `pose`, which stops `lift` mm short, moved and turned `by`; lowered onto the hub allowance,
/// less the same lift.
pub(super) fn moved(
    context: &PlanContext,
    tool: &Tool,
    pose: &PlungePose,
    lift: f64,
    by: &PlungeMove,
) -> PlungePose {
    let foot = pose.lifted(-lift).tip;
    let FloorFrame { normal, inwards, across, meridian, around, .. } = FloorFrame::at(context, &foot);
    let axis = turned(&turned(&pose.axis, &normal, &meridian, by.lead_rad), &normal, &around, by.tilt_rad);
    let axis = axis.normalize();
    let on_axis = foot + inwards * by.along + across * by.across;
    let tip = depth_surface(context, tool).tip(tool, &on_axis, &axis).unwrap_or(on_axis);
    let (cutter, _) = raise_to_allowance(context, tool.placed(tip, axis));
    PlungePose { tip: cutter.tip, axis }.lifted(lift)
}

/// The position of a plunge at `pose` that stops `lift` mm short, in a section and row.
pub(super) fn position_at(
    context: &PlanContext,
    tool: &Tool,
    pose: &PlungePose,
    lift: f64,
    (section, row): (usize, usize),
) -> Position<Unevaluated> {
    let foot = pose.lifted(-lift).tip;
    let frame = FloorFrame::at(context, &foot);
    let bottom = tool.radius() - tool.corner_radius;
    let contact_point =
        depth_surface(context, tool).touch(&foot, &pose.axis, bottom).map_or(foot, |t| t.point);
    let FloorFrame { normal, meridian, .. } = FloorFrame::at(context, &contact_point);
    let cutter = tool.placed(pose.tip, pose.axis);
    let finished = &context.workpiece.finished;
    Position {
        tip: pose.tip,
        axis: pose.axis,
        section,
        row,
        s: frame.s,
        lambda: frame.lambda,
        alpha_rad: pose.axis.dot(&meridian).atan2(pose.axis.dot(&normal)),
        contact_point,
        lift,
        blocked: None,
        limited_by: None,
        hub_clearance: finished.hub_clearance(&cutter),
        blade_clearance: finished.blade_clearance(&cutter),
        evaluation: Unevaluated,
    }
}
