//! Whether a tool can be placed on a point of the floor: for a given inclination along the flow, the axis is
//! interpolated between the walls and pushed off the one it is too near to. The cutter must clear the hub,
//! and the holder everything.

use super::limits::{MIN_INCLINATION, ReachLimits, ReachSides};
use crate::cutting::assembly::AssemblySurroundings;
use crate::geometry::{CutterSolid, Meridional, Point, Vector, frame_about};
use crate::part::{Blank, FinishedPart, Impeller, Passage, SideProbe, Workpiece};
use crate::setup::{AssemblySegment, Tool};

/// Maximum number of pushes of an axis between the walls before it counts as blocked.
const PUSHES: usize = 5;

/// An inclination of the axis in the meridional plane: the point it passes through, and the angles of the
/// walls there.
struct Inclination {
    /// Point on the axis about as high as the shroud.
    top: Meridional,
    /// Angles of the walls at that point.
    walls: [f64; 2],
}

/// The inclinations at one s; those towards one side in ascending order.
pub struct Inclinations {
    normal: Option<Inclination>,
    outlet: Vec<Inclination>,
    inlet: Vec<Inclination>,
}

/// All collision geometry of a tool.
pub struct ReachObstacles<'a> {
    part: &'a Impeller,
    sides: Vec<SideProbe>,
    finished: &'a FinishedPart,
    blank: &'a Blank,
    limits: ReachLimits,
}

impl<'a> ReachObstacles<'a> {
    /// The collision geometry of `workpiece`.
    pub fn new(workpiece: &'a Workpiece, limits: &ReachLimits) -> Self {
        let Workpiece { part, channel, blank, finished } = workpiece;
        Self {
            part,
            finished,
            sides: channel.sides.iter().map(|side| SideProbe::new(side, 0.0, 1.0)).collect(),
            blank,
            limits: *limits,
        }
    }

    /// Distance from `point` to the nearest blade side, mm.
    pub fn blade_distance(&self, point: &Point) -> f64 {
        self.sides.iter().map(|side| side.nearest_to_point(point).distance).fold(f64::INFINITY, f64::min)
    }

    /// A point of the hub allowance surface.
    fn foot(&self, s: f64, walls: [f64; 2], lambda: f64) -> Point {
        let hub = self.part.hub.at(s);
        let raised = |p: f64, n: f64| p + self.limits.hub_allowance * n;
        Meridional { r: raised(hub.point.r, hub.normal.r), z: raised(hub.point.z, hub.normal.z) }
            .at_angle(walls[0] + lambda * (walls[1] - walls[0]))
    }

    /// The inclinations at `s`, towards both sides.
    pub fn inclinations(&self, passage: &Passage, s: f64) -> Inclinations {
        let hub = self.part.hub.at(s);
        let depth = hub.point.distance(self.part.shroud.point(s));
        let aim = |alpha: f64| {
            let height = depth / alpha.cos().max(0.3);
            let (sin, cos) = alpha.sin_cos();
            let along = |n: f64, t: f64| height * (cos * n - sin * t);
            let top = Meridional {
                r: hub.point.r + along(hub.normal.r, hub.tangent.r),
                z: hub.point.z + along(hub.normal.z, hub.tangent.z),
            };
            let s_top = self.part.shroud.s_at(self.part.shroud.curve().project(top).0);
            Some(Inclination { top, walls: passage.wall_angles(self.part, s_top, 1.0)? })
        };
        let steps = (self.limits.max_tilt_rad / MIN_INCLINATION + 1e-9).floor() as usize;
        let towards =
            |sign: f64| (1..=steps).filter_map(|k| aim(sign * MIN_INCLINATION * k as f64)).collect();
        Inclinations { normal: aim(0.0), outlet: towards(-1.0), inlet: towards(1.0) }
    }

    /// The sides from which `tool` can be placed at `lambda` between `walls`, the angles of the walls on the
    /// hub at `s`.
    pub fn sides_at(
        &self,
        aims: &Inclinations,
        s: f64,
        walls: [f64; 2],
        lambda: f64,
        tool: &Tool,
    ) -> ReachSides {
        let foot = self.foot(s, walls, lambda);
        // The distance along the circumference is an upper bound on the distance from a wall.
        let around = lambda.min(1.0 - lambda) * (walls[1] - walls[0]).abs() * foot.x.hypot(foot.y);
        if around < tool.radius() + self.limits.blade_allowance {
            return ReachSides::default();
        }
        let segments = tool.assembly.segments(tool.overhang);
        let stands = |aim: &Inclination| self.is_placeable(&foot, aim, lambda, (tool, &segments));
        let (outlet, inlet) = (aims.outlet.iter().any(stands), aims.inlet.iter().any(stands));
        ReachSides { outlet, inlet, any: outlet || inlet || aims.normal.as_ref().is_some_and(stands) }
    }

    /// Whether a tool can be placed at `foot` with an axis inclined as `aim` along the flow.
    fn is_placeable(
        &self,
        foot: &Point,
        aim: &Inclination,
        lambda: f64,
        (tool, segments): (&Tool, &[AssemblySegment]),
    ) -> bool {
        let mut theta = aim.walls[0] + lambda * (aim.walls[1] - aim.walls[0]);
        let mut last = 0.0;
        for _ in 0..PUSHES {
            let top = aim.top.at_angle(theta);
            let Some(axis) = (top - foot).try_normalize(1e-9) else { return false };
            let Some(push) = self.push(&tool.placed(*foot, axis), &top) else {
                return self.column_clears_hub(foot, &axis, tool)
                    && self.holder_clears(foot, &axis, tool, segments);
            };
            // Pushed clear of one wall and too near to the other: no axis fits between them.
            if !push.is_finite() || push.abs() > self.part.pitch().abs() || push * last < 0.0 {
                return false;
            }
            theta += push;
            last = push;
        }
        false
    }

    /// Angle about Z by which the upper end `top` of an axis must turn to clear a blade side that is too
    /// near, rad. `None` where all sides are clear, NaN where turning does not help.
    fn push(&self, cutter: &CutterSolid, top: &Point) -> Option<f64> {
        const MARGIN: f64 = 1e-3;
        let wanted = self.limits.blade_allowance;
        let near = self
            .sides
            .iter()
            .filter_map(|side| side.nearest_below(cutter, wanted))
            .find(|near| near.distance < wanted)?;
        let up = (near.point - cutter.tip).dot(&cutter.axis);
        let away = cutter.tip + cutter.axis * up - near.point;
        let share = up / (top - cutter.tip).norm();
        let gain = share * away.normalize().dot(&Vector::new(-top.y, top.x, 0.0));
        Some(if share > 0.02 { (wanted - near.distance + MARGIN) / gain } else { f64::NAN })
    }

    /// Whether the cutter stays out of the hub above its bottom: when inclined it may meet the hub again.
    fn column_clears_hub(&self, foot: &Point, axis: &Vector, tool: &Tool) -> bool {
        let curve = self.part.hub.curve();
        let radius = tool.radius();
        let (from, steps) = (2.0 * radius, 8);
        (0..=steps).all(|i| {
            let up = from + (tool.overhang - from).max(0.0) * f64::from(i) / f64::from(steps);
            let (t, distance) = curve.project(Meridional::from_point(&(foot + axis * up)));
            // Beyond its ends the hub has an edge, not a surface.
            distance.abs() >= radius && (distance > 0.0 || t <= 0.0 || t >= curve.length())
        })
    }

    /// Whether shank and holder clear the blades, the hub and the turned blank.
    fn holder_clears(&self, foot: &Point, axis: &Vector, tool: &Tool, segments: &[AssemblySegment]) -> bool {
        if !segments.is_empty() {
            let around = AssemblySurroundings {
                finished: self.finished,
                blank: Some(self.blank),
                earlier: None,
                allowances: [self.limits.hub_allowance, self.limits.blade_allowance],
                clearances: self.limits.clearances,
            };
            let found = around.at(tool, segments, (*foot, *axis), 0.0);
            if found.shank.collides() || found.holder.collides() {
                return false;
            }
        }
        if !tool.assembly.holder.is_empty() {
            return true;
        }
        let holder = tool.holder(*foot, *axis);
        let radius = holder.radius;
        let (e1, e2) = frame_about(axis);
        let around = 12;
        let rim = |k: i32, up: f64| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(around)).sin_cos();
            Meridional::from_point(&(holder.tip + axis * up + (e1 * cos + e2 * sin) * radius))
        };
        let mut warm = None;
        let outside = |p: Meridional, warm: &mut Option<f64>| self.blank.clearance(p, warm) >= 0.0;
        let mut bottom_clear = true;
        for up in [0.0, 2.0 * radius] {
            for k in 0..around {
                bottom_clear &= outside(rim(k, up), &mut warm);
            }
        }
        bottom_clear && !self.sides.iter().any(|side| side.is_within(&holder, 0.0))
    }
}
