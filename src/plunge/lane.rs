//! Lanes: a lane is a passage with the axes of one cutter that clear both of its walls.
//!
//! Axes along the walls are fitted (`wall_axis`) and kept in tables; those of the rows between are
//! interpolated.

mod fit_table;
mod wall_axis;

use super::spacing::row_distance;
use crate::geometry::{CutterSolid, Point, Vector, wrap_angle};
use crate::part::{FinishedPart, Impeller, Passage, SideProbe, Workpiece};
use crate::setup::{AllowanceSetup, Tool};
use fit_table::{FitNode, FitTable, Reading};

/// Maximum difference between two searches for the nearest point of a wall, mm: fits keep this as a margin.
const SEARCH_ERROR: f64 = 4e-6;
/// Step of s that gives the direction of the flow.
const FLOW_STEP: f64 = 1e-3;

/// A passage with the axes of one cutter along its walls.
#[derive(Debug)]
pub struct Lane<'a> {
    part: &'a Impeller,
    passage: &'a Passage,
    finished: &'a FinishedPart,
    /// Flanks with the straight extensions along which rows run out.
    probes: [SideProbe; 2],
    /// The same sides without extensions, each with the sign that makes ∂u × ∂v point into the passage.
    blades: [(SideProbe, f64); 2],
    radius: f64,
    corner_radius: f64,
    hub_allowance: f64,
    blade_allowance: f64,
    tables: [FitTable; 2],
}

/// An axis given by its ends: M on the allowance surface of the hub, W on the shroud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisEnds {
    /// s of M on the hub.
    pub s_hub: f64,
    /// s of W on the shroud.
    pub s_shroud: f64,
    /// Angle of M about Z, rad.
    pub theta_hub: f64,
    /// Angle of W about Z, rad.
    pub theta_shroud: f64,
}

/// The axis at `lambda` between those beside both walls at the same s.
fn between([low, high]: &[AxisEnds; 2], lambda: f64) -> AxisEnds {
    AxisEnds {
        theta_hub: low.theta_hub + lambda * (high.theta_hub - low.theta_hub),
        theta_shroud: low.theta_shroud + lambda * (high.theta_shroud - low.theta_shroud),
        ..*low
    }
}

/// Whether a row at `lambda` runs along one of its passage's walls.
pub fn is_wall(lambda: f64) -> bool {
    lambda == 0.0 || lambda == 1.0
}

/// +1 where increasing θ leads into a passage of `part` from this wall, else −1.
fn inward_sign(part: &Impeller, wall: usize) -> f64 {
    part.pitch().signum() * if wall == 0 { 1.0 } else { -1.0 }
}

impl<'a> Lane<'a> {
    /// The lane of `tool` through `passage`, one of `workpiece`, between its finished blades.
    pub fn new(workpiece: &'a Workpiece, passage: &'a Passage, tool: &Tool, stock: &AllowanceSetup) -> Self {
        let Workpiece { part, finished, .. } = workpiece;
        let (hub_allowance, blade_allowance) = (stock.hub_allowance, stock.blade_allowance);
        let probe = |i: usize| {
            // The flank is extended only as far as rows run beyond its ends: a longer extension would
            // obstruct tilted columns.
            let side = passage.walls[i].side();
            let (from, to) = side.u_range();
            let chord = (side.point(1.0, 0.5) - side.point(0.0, 0.5)).norm();
            let reach = (tool.radius() + blade_allowance) / chord.max(1e-6);
            SideProbe::new(side, from - (3.0 * reach).min(0.3), to + (4.0 * reach).clamp(0.1, 0.5))
        };
        let blade = |i: usize| {
            let side = passage.walls[i].whole_side();
            let (p, pu, pv) = side.derivatives(0.5, 0.5);
            let into_passage = Vector::new(-p.y, p.x, 0.0) * inward_sign(part, i);
            (SideProbe::new(side, 0.0, 1.0), pu.cross(&pv).dot(&into_passage).signum())
        };
        let spacing = (1.2 * tool.insert_width / part.hub.length()).clamp(0.004, 0.03);
        Self {
            tables: [FitTable::new(spacing), FitTable::new(spacing)],
            part,
            passage,
            finished,
            probes: [probe(0), probe(1)],
            blades: [blade(0), blade(1)],
            radius: tool.radius(),
            corner_radius: tool.corner_radius,
            hub_allowance,
            blade_allowance: blade_allowance + SEARCH_ERROR,
        }
    }

    /// M of `ends`, in the frame of the part, mm.
    pub fn hub_point(&self, ends: &AxisEnds) -> Point {
        let here = self.part.hub.at(ends.s_hub);
        let (p, n, a) = (here.point, here.normal, self.hub_allowance);
        crate::geometry::Meridional { r: p.r + a * n.r, z: p.z + a * n.z }.at_angle(ends.theta_hub)
    }

    /// W of `ends`, in the frame of the part, mm.
    pub fn shroud_point(&self, ends: &AxisEnds) -> Point {
        self.part.shroud.point(ends.s_shroud).at_angle(ends.theta_shroud)
    }

    /// M and the unit axis of `ends`.
    pub fn line(&self, ends: &AxisEnds) -> (Point, Vector) {
        let m = self.hub_point(ends);
        (m, (self.shroud_point(ends) - m).normalize())
    }

    /// Spacing S of two neighbouring axes ([plunge paper], fig. 6): the larger of the distances of `next` at
    /// hub and shroud from the line through `tip` along the unit vector `axis`, mm.
    pub fn spacing(&self, (tip, axis): (Point, Vector), next: &AxisEnds) -> f64 {
        let across = |p: Point| {
            let d = p - tip;
            (d - axis * d.dot(&axis)).norm()
        };
        across(self.hub_point(next)).max(across(self.shroud_point(next)))
    }

    fn cutter(&self, ends: &AxisEnds) -> CutterSolid {
        let (tip, axis) = self.line(ends);
        CutterSolid { tip, axis, radius: self.radius, corner_radius: self.corner_radius }
    }

    /// +1 where increasing θ leads into the passage from this wall, else −1.
    pub fn inward_sign(&self, wall: usize) -> f64 {
        inward_sign(self.part, wall)
    }

    /// Both wall axes at the same s; `None` where a wall does not extend to these s or the cutter does not
    /// fit between them.
    pub fn wall_pair(&self, s_hub: f64, s_shroud: f64) -> Option<[AxisEnds; 2]> {
        let low = self.wall_axis(0, s_hub, s_shroud, None)?;
        let high = self.wall_axis(1, s_hub, s_shroud, None)?;
        self.ordered_pair(low, high)
    }

    /// The axes beside both walls, with the angles of that at λ = 1 wrapped next to those of the other;
    /// `None` where the cutter does not fit between them.
    fn ordered_pair(&self, low: AxisEnds, mut high: AxisEnds) -> Option<[AxisEnds; 2]> {
        let half = 0.5 * self.part.pitch();
        let beside = |a: f64, b: f64| a + wrap_angle(b - a - half) + half;
        high.theta_hub = beside(low.theta_hub, high.theta_hub);
        high.theta_shroud = beside(low.theta_shroud, high.theta_shroud);
        let open = |a: f64, b: f64| (b - a) * self.part.pitch().signum() >= 0.0;
        (open(low.theta_hub, high.theta_hub) && open(low.theta_shroud, high.theta_shroud))
            .then_some([low, high])
    }

    /// Width for rows between both wall axes at `s`, on the hub and on the shroud, mm: two rows are this
    /// times their difference in λ apart, perpendicular to the flow or to the axis, whichever is smaller. It
    /// is the largest of the widths beside the walls and at mid passage. The straight distance from wall to
    /// wall would mislead, because the flow turns with the wheel. `None` where the cutter does not fit.
    pub fn width(&self, s: f64) -> Option<(f64, f64)> {
        let pair = |s: f64| {
            let (low, high) = self.guide_axes(s, s, true)?;
            self.ordered_pair(low, high)
        };
        let here = pair(s)?;
        // Without rows there the flow has no length, and does not count.
        let before = pair(s - FLOW_STEP).unwrap_or(here);
        let turns = [here[1].theta_hub - here[0].theta_hub, here[1].theta_shroud - here[0].theta_shroud];
        let at_row = |lambda: f64| {
            let (row, before) = (between(&here, lambda), between(&before, lambda));
            let (foot, axis) = self.line(&row);
            let distance = |point: Point, before: Point, turn: f64| {
                row_distance(Vector::new(-point.y, point.x, 0.0) * turn, before - point, axis)
            };
            let hub = distance(foot, self.hub_point(&before), turns[0])?;
            Some((hub, distance(self.shroud_point(&row), self.shroud_point(&before), turns[1])?))
        };
        let widths = [0.0, 0.5, 1.0].into_iter().filter_map(at_row);
        widths.reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))
    }

    /// Lean of `wall` at `s`: angle of the conventional axis along it to the hub normal, across the wall,
    /// rad; positive over the channel. `None` where there is no axis.
    pub fn lean_over(&self, wall: usize, s: f64) -> Option<f64> {
        let ends = self.table_axis(wall, s, s, true)?;
        let along = self.hub_point(&self.table_axis(wall, s - FLOW_STEP, s - FLOW_STEP, true)?)
            - self.hub_point(&ends);
        let normal = self.part.hub.normal(s).direction_at_angle(ends.theta_hub);
        let (m, axis) = self.line(&ends);
        let across = normal.cross(&along).normalize();
        let into_passage = Vector::new(-m.y, m.x, 0.0) * self.inward_sign(wall);
        let lean = axis.dot(&across) * across.dot(&into_passage).signum();
        Some(lean.atan2(axis.dot(&normal)))
    }

    /// Axis of `wall` from its table of fits, a few µm from the exact one; beside steep or swept edges,
    /// where fits are not smooth, it may still have to be turned off the blades. With `refit` it is fitted
    /// exactly where the four surrounding nodes are fits and others of the interpolation are not; that is too
    /// slow for searches.
    fn table_axis(&self, wall: usize, s_hub: f64, s_shroud: f64, refit: bool) -> Option<AxisEnds> {
        let fit = |s_hub: f64, shift: f64| {
            let plain = self.plain_offset(wall, s_hub, s_hub - shift)?;
            let fitted = self.fit_axis(wall, s_hub, s_hub - shift, None);
            let is_fitted = fitted.is_some();
            let ends = fitted.or_else(|| self.axis_beside_blades(wall, s_hub, s_hub - shift))?;
            let beside = |a: f64, b: f64| wrap_angle(a - b);
            Some(FitNode {
                angles: [ends.theta_hub, ends.theta_shroud],
                beside_plain: [
                    beside(ends.theta_hub, plain.theta_hub),
                    beside(ends.theta_shroud, plain.theta_shroud),
                ],
                is_fitted,
            })
        };
        match self.tables[wall].look_up(s_hub, s_hub - s_shroud, &fit) {
            Reading::Fitted([theta_hub, theta_shroud]) => {
                Some(AxisEnds { s_hub, s_shroud, theta_hub, theta_shroud })
            }
            Reading::Beside([hub, shroud], all_fitted) => {
                let fitted =
                    if refit && all_fitted { self.fit_axis(wall, s_hub, s_shroud, None) } else { None };
                fitted.or_else(|| {
                    let plain = self.plain_offset(wall, s_hub, s_shroud)?;
                    Some(AxisEnds {
                        theta_hub: plain.theta_hub + hub,
                        theta_shroud: plain.theta_shroud + shroud,
                        ..plain
                    })
                })
            }
            Reading::Outside => self.wall_axis(wall, s_hub, s_shroud, None),
            Reading::Nothing => None,
        }
    }

    /// Axis of the row at `lambda` between the walls from the tables of fits, for searches. `None` where no
    /// axis beside its wall clears the blades, or the cutter does not fit between the walls.
    pub fn row_axis(&self, lambda: f64, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        self.axis_between(lambda, s_hub, s_shroud, false)
    }

    fn axis_between(&self, lambda: f64, s_hub: f64, s_shroud: f64, refit: bool) -> Option<AxisEnds> {
        if is_wall(lambda) {
            return self.table_axis(lambda as usize, s_hub, s_shroud, refit);
        }
        let (low, high) = self.guide_axes(s_hub, s_shroud, refit)?;
        Some(between(&self.ordered_pair(low, high)?, lambda))
    }

    /// The axes beside both walls between which rows are interpolated; where a wall has none, the plain
    /// offset of its ruling.
    fn guide_axes(&self, s_hub: f64, s_shroud: f64, refit: bool) -> Option<(AxisEnds, AxisEnds)> {
        let guide = |wall: usize| {
            let axis = self.table_axis(wall, s_hub, s_shroud, refit);
            axis.or_else(|| self.plain_offset(wall, s_hub, s_shroud))
        };
        Some((guide(0)?, guide(1)?))
    }

    /// The conventional axis of the row at `lambda` with M at `s`: M and W are at the same fraction of arc
    /// length. Outside the channel both move on by the same distance, so that the axis keeps its direction at
    /// the rim (or the leading edge).
    pub fn isoparametric(&self, lambda: f64, s: f64) -> Option<AxisEnds> {
        self.axis_between(lambda, s, self.isoparametric_shroud(s), true)
    }

    /// As [`Self::isoparametric`], with the plain offset of the ruling where no axis beside a wall clears the
    /// blades: the reference for inclined axes at the same s.
    pub fn reference_axis(&self, lambda: f64, s: f64) -> Option<AxisEnds> {
        let plain = || {
            let wall = is_wall(lambda).then_some(lambda as usize)?;
            self.plain_offset(wall, s, self.isoparametric_shroud(s))
        };
        self.isoparametric(lambda, s).or_else(plain)
    }

    /// s of W of the conventional axis with M at `s`.
    fn isoparametric_shroud(&self, s: f64) -> f64 {
        let inside = s.clamp(0.0, 1.0);
        inside + (s - inside) * self.part.hub.length() / self.part.shroud.length()
    }

    /// Exact axis of a row: at a wall, turned until the cutter, its bottom `lift` mm above M, clears the
    /// finished blade by the allowance; unchanged between the walls.
    pub fn exact_axis(&self, lambda: f64, ends: AxisEnds, lift: f64) -> Option<AxisEnds> {
        if is_wall(lambda) { self.push_clear(lambda as usize, ends, lift) } else { Some(ends) }
    }
}
