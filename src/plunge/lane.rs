//! Lanes: a lane is a passage with the axes of one cutter that clear both of its walls.
//!
//! A wall axis starts as the offset of the wall's ruling by R + allowance ([assessment paper], fig. 5 to 7).
//! This plain offset gouges where rulings twist. A damped Newton iteration corrects it against the true
//! surface until the cutter is equally far from the wall in the root third and in the tip third, and its
//! minimum distance equals the allowance. That fit is unique for walls that are convex and for walls that are
//! concave towards the cutter.
//!
//! Fits follow the flank, which is extended straight beyond its ends so that rows can run out. Where the wrap
//! angle is large or edges are swept, that extension may cross the channel and leave no fit. There the axis
//! is placed beside the finished blades only, with the tilt angle closest to the ruling's that clears them.

use super::fit_table::{FitNode, FitTable, Reading};
use crate::geometry::{CutterSolid, Point, Vector, norm2, wrap_angle};
use crate::part::{FinishedPart, Impeller, NearestOnSide, Passage, SideProbe, Workpiece};
use crate::setup::{AllowanceSetup, Tool};

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

/// Clearance from one third of a wall, and its derivatives by the angles of the ends of the axis.
#[derive(Clone, Copy, Debug)]
struct ClearanceResponse {
    /// Derivative by θ of M, mm/rad.
    by_hub: f64,
    /// Derivative by θ of W, mm/rad.
    by_shroud: f64,
    /// Clearance minus the allowance, mm.
    excess: f64,
}

/// State of the Newton iteration: responses of the root, middle and tip third of the wall.
#[derive(Clone, Copy, Debug)]
struct FitState {
    answers: [ClearanceResponse; 3],
    /// Distance from M to W, mm.
    height: f64,
}

impl FitState {
    fn nearest(&self) -> ClearanceResponse {
        let [low, middle, high] = self.answers;
        [low, middle, high].into_iter().min_by(|a, b| a.excess.total_cmp(&b.excess)).unwrap_or(low)
    }

    /// Residual of the fit, mm: 0 for an exact one.
    fn residual(&self) -> f64 {
        let [low, _, high] = self.answers;
        self.nearest().excess.abs().max((low.excess - high.excess).abs())
    }

    /// Newton step of the angles of M and W towards equal clearance at root and tip and a minimum clearance
    /// equal to the allowance.
    fn step(&self) -> Option<(f64, f64)> {
        let [low, _, high] = self.answers;
        let nearest = self.nearest();
        let (a11, a12) = (low.by_hub - high.by_hub, low.by_shroud - high.by_shroud);
        let (a21, a22) = (nearest.by_hub, nearest.by_shroud);
        let (b1, b2) = (high.excess - low.excess, -nearest.excess);
        let determinant = a11 * a22 - a12 * a21;
        let step = ((b1 * a22 - b2 * a12) / determinant, (a11 * b2 - a21 * b1) / determinant);
        (step.0.is_finite() && step.1.is_finite()).then_some(step)
    }
}

/// Whether a row at `lambda` runs along one of its passage's walls.
pub fn is_wall(lambda: f64) -> bool {
    lambda == 0.0 || lambda == 1.0
}

/// Maximum difference of the tilt angle of a fitted axis from that of the plain offset of the ruling.
const TILT_LIMIT_RAD: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// Tilt angles relative to the plain offset that are tried where no fit exists, degrees.
const TILT_OFFSETS_DEG: [f64; 15] =
    [0.0, 3.0, -3.0, 6.0, -6.0, 9.0, -9.0, 13.0, -13.0, 17.0, -17.0, 22.0, -22.0, 28.0, -28.0];
/// Minimum height of the channel for an axis, in hub allowances.
const MIN_HEIGHTS: f64 = 1.2;
/// Tolerance of the clearance, mm, always on the safe side.
const FIT_TOLERANCE: f64 = 2e-7;
/// Maximum difference between two searches for the nearest point of a wall, mm: fits keep this as a margin.
const SEARCH_ERROR: f64 = 4e-6;

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
        let inward = |wall: usize| part.pitch().signum() * if wall == 0 { 1.0 } else { -1.0 };
        let blade = |i: usize| {
            let side = passage.walls[i].whole_side();
            let (p, pu, pv) = side.derivatives(0.5, 0.5);
            let into_passage = Vector::new(-p.y, p.x, 0.0) * inward(i);
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

    fn cutter(&self, ends: &AxisEnds) -> CutterSolid {
        let (tip, axis) = self.line(ends);
        CutterSolid { tip, axis, radius: self.radius, corner_radius: self.corner_radius }
    }

    /// +1 where increasing θ leads into the passage from this wall, else −1.
    pub fn inward_sign(&self, wall: usize) -> f64 {
        self.part.pitch().signum() * if wall == 0 { 1.0 } else { -1.0 }
    }

    /// Axis along `wall` (0 or 1) with M at `s_hub` and W at `s_shroud`, starting from the neighbouring
    /// solution `warm`. `None` where the wall does not extend to these s, or no axis beside it clears the
    /// blades.
    pub fn wall_axis(
        &self,
        wall: usize,
        s_hub: f64,
        s_shroud: f64,
        warm: Option<AxisEnds>,
    ) -> Option<AxisEnds> {
        let fitted = self.fit_axis(wall, s_hub, s_shroud, warm);
        fitted.or_else(|| self.axis_beside_blades(wall, s_hub, s_shroud))
    }

    /// The axis along `wall` by damped Newton iteration, on the branch of the ruling; see
    /// [`Self::wall_axis`].
    fn fit_axis(&self, wall: usize, s_hub: f64, s_shroud: f64, warm: Option<AxisEnds>) -> Option<AxisEnds> {
        let plain = self.plain_offset(wall, s_hub, s_shroud)?;
        let plain_turn = plain.theta_shroud - plain.theta_hub;
        let mut ends = match warm {
            Some(w) => AxisEnds { s_hub, s_shroud, theta_shroud: w.theta_shroud, theta_hub: w.theta_hub },
            None => plain,
        };
        // Nearest u of each third of the wall: found globally once, then tracked.
        let mut places = [None; 3];
        let mut state = self.fit_state(wall, &ends, &mut places);
        for _ in 0..12 {
            if state.residual() < FIT_TOLERANCE {
                break;
            }
            let (dm, dw) = state.step()?;
            let r_hub = self.part.hub.point(s_hub).r.max(1e-6);
            let r_shroud = self.part.shroud.point(s_shroud).r.max(1e-6);
            // Several fits may exist on a twisted wall: stay on the branch of the ruling.
            let turn_limit = TILT_LIMIT_RAD.tan() * state.height / r_shroud;
            let limit = 0.25 * self.radius / r_hub;
            // Damping: a step that increases the residual is shortened.
            let mut scale = 1.0;
            let mut improved = false;
            for _ in 0..5 {
                let mut next = ends;
                next.theta_hub += (scale * dm).clamp(-limit, limit);
                next.theta_shroud += (scale * dw).clamp(-limit, limit);
                let turn = next.theta_shroud - next.theta_hub;
                next.theta_shroud =
                    next.theta_hub + turn.clamp(plain_turn - turn_limit, plain_turn + turn_limit);
                let mut there = places;
                let next_state = self.fit_state(wall, &next, &mut there);
                if next_state.residual() < state.residual() {
                    (ends, state, places, improved) = (next, next_state, there, true);
                    break;
                }
                scale *= 0.4;
            }
            if !improved {
                break;
            }
        }
        let (ends, near) = self.turn_off_side(&self.probes[wall], wall, ends, 0.0)?;
        // A cutter that touches the extension of a flank may be inside another blade.
        let (from, to) = self.passage.walls[wall].side().u_range();
        let on_flank = (from..=to).contains(&near.u);
        (on_flank || self.finished.clears(&self.cutter(&ends), self.blade_allowance - SEARCH_ERROR))
            .then_some(ends)
    }

    /// The axis beside `wall`, turned into the passage until it clears the finished blades, with the tilt
    /// angle closest to that of the ruling for which that is possible.
    fn axis_beside_blades(&self, wall: usize, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        let plain = self.plain_offset(wall, s_hub, s_shroud)?;
        let (m, w) = (self.hub_point(&plain), self.shroud_point(&plain));
        let unit = (w - m).norm() / norm2(w.x, w.y).max(1e-6);
        TILT_OFFSETS_DEG.iter().find_map(|tilt_deg| {
            let theta_shroud = plain.theta_shroud + tilt_deg.to_radians().tan() * unit;
            self.clear_of_blades(wall, AxisEnds { theta_shroud, ..plain })
        })
    }

    /// The axis along `wall` with W turned about Z by `turn` (rad) from where the plain offset of the ruling
    /// has it, as near to the wall as the finished blade allows. `None` where there is no ruling, or no such
    /// axis clears the blade.
    pub fn turned_wall_axis(
        &self,
        wall: usize,
        (s_hub, s_shroud): (f64, f64),
        turn: f64,
    ) -> Option<AxisEnds> {
        let plain = self.plain_offset(wall, s_hub, s_shroud)?;
        let theta_shroud = plain.theta_shroud + turn;
        self.push_clear(wall, AxisEnds { theta_shroud, ..plain }, 0.0)
    }

    /// Distance of M of `ends` beside `wall` from where the plain offset of the ruling has it, mm.
    pub fn distance_from_plain(&self, wall: usize, ends: &AxisEnds) -> f64 {
        self.plain_offset(wall, ends.s_hub, ends.s_shroud).map_or(0.0, |plain| {
            wrap_angle(ends.theta_hub - plain.theta_hub).abs() * self.part.hub.point(ends.s_hub).r
        })
    }

    /// Turns both ends of an axis into the passage from `wall` until the cutter clears all finished blades;
    /// `None` where that takes more than half the pitch.
    fn clear_of_blades(&self, wall: usize, mut ends: AxisEnds) -> Option<AxisEnds> {
        let limit = 0.5 * self.part.pitch().abs();
        let mut turned = 0.0;
        for _ in 0..12 {
            let cutter = self.cutter(&ends);
            let Some(near) = self.finished.nearest_within(&cutter, self.blade_allowance) else {
                return Some(ends);
            };
            let turning = Vector::new(-near.point.y, near.point.x, 0.0);
            let up = (near.point - cutter.tip).dot(&cutter.axis);
            let away = (cutter.tip + cutter.axis * up - near.point).try_normalize(1e-9)?;
            let gain = away.dot(&turning) * self.inward_sign(wall);
            // Without gain, the blade is on the far side of the passage, or the cutter has to pass through
            // its own blade.
            let short = if gain > 0.0 {
                self.blade_allowance - near.distance
            } else {
                self.blade_allowance + near.distance + 2.0 * self.radius
            };
            let step = (short + FIT_TOLERANCE) / gain.abs().max(0.2 * turning.norm());
            turned += step;
            if turned > limit {
                return None;
            }
            ends.theta_hub += step * self.inward_sign(wall);
            ends.theta_shroud += step * self.inward_sign(wall);
        }
        None
    }

    /// Clearances of an axis from the thirds of a wall, with their derivatives by the angles of M and W.
    fn fit_state(&self, wall: usize, ends: &AxisEnds, places: &mut [Option<f64>; 3]) -> FitState {
        let cutter = self.cutter(ends);
        let (m, w) = (self.hub_point(ends), self.shroud_point(ends));
        let height = (w - m).norm();
        let thirds = [(0.0, 0.33), (0.33, 0.67), (0.67, 1.0)];
        let mut third = 0;
        let answers = thirds.map(|(v_from, v_to)| {
            let near = match places[third] {
                Some(u) => self.probes[wall].nearest_from(&cutter, u, v_from, v_to),
                None => self.probes[wall].nearest(&cutter, v_from, v_to),
            };
            places[third] = Some(near.u);
            third += 1;
            let along = (near.point - m).dot(&cutter.axis);
            let (away, clearance) = self.direction_away(&self.probes[wall], wall, &cutter, &near);
            let share = (along / height).clamp(-0.2, 1.2);
            ClearanceResponse {
                by_hub: (1.0 - share) * away.dot(&Vector::new(-m.y, m.x, 0.0)),
                by_shroud: share * away.dot(&Vector::new(-w.y, w.x, 0.0)),
                excess: clearance - self.blade_allowance,
            }
        });
        FitState { answers, height }
    }

    /// Unit direction from the nearest point of a side of `wall` to the axis, and the clearance there. When
    /// the axis itself is beyond the wall, the direction is reversed and the clearance is negative.
    fn direction_away(
        &self,
        probe: &SideProbe,
        wall: usize,
        cutter: &CutterSolid,
        near: &NearestOnSide,
    ) -> (Vector, f64) {
        let d = near.point - cutter.tip;
        let flat = -(d - cutter.axis * d.dot(&cutter.axis));
        let length = flat.norm();
        if length < 1e-9 {
            return (flat, -self.radius);
        }
        let away = flat / length;
        let (_, pu, pv) = probe.side().derivatives(near.u, near.v);
        let beyond = away.dot(&pu.cross(&pv)) * self.blades[wall].1 < 0.0;
        // At the end of a blade a clear cutter may be beyond the plane of the side.
        let at_end = (near.u <= 1e-6 || near.u >= 1.0 - 1e-6) && near.distance > 0.0;
        if beyond && !at_end { (-away, -length - self.radius) } else { (away, near.distance) }
    }

    /// Turns both ends away from `wall` until the cutter, its bottom `lift` mm above M, keeps the allowance
    /// from the finished blade. `None` when turning does not achieve that.
    fn push_clear(&self, wall: usize, ends: AxisEnds, lift: f64) -> Option<AxisEnds> {
        self.turn_off_side(&self.blades[wall].0, wall, ends, lift).map(|(ends, _)| ends)
    }

    /// As [`Self::push_clear`], for the side of `probe`; also returns its nearest point to the final cutter.
    fn turn_off_side(
        &self,
        probe: &SideProbe,
        wall: usize,
        mut ends: AxisEnds,
        lift: f64,
    ) -> Option<(AxisEnds, NearestOnSide)> {
        let mut place: Option<f64> = None;
        for _ in 0..20 {
            let mut cutter = self.cutter(&ends);
            cutter.tip += cutter.axis * lift;
            // After a turn by micrometres the nearest point hardly moves: search locally.
            let near = match place {
                Some(u) => probe.nearest_from(&cutter, u, 0.0, 1.0),
                None => probe.nearest(&cutter, 0.0, 1.0),
            };
            let (away, clearance) = self.direction_away(probe, wall, &cutter, &near);
            let short = self.blade_allowance - clearance;
            if short <= 0.0 {
                return Some((ends, near));
            }
            let turn = Vector::new(-near.point.y, near.point.x, 0.0);
            let gain = away.dot(&turn).abs().max(0.2 * turn.norm());
            let step = (short + FIT_TOLERANCE) / gain * self.inward_sign(wall);
            if !step.is_finite() || step.abs() > 0.5 {
                return None;
            }
            place = (short < 0.01).then_some(near.u);
            ends.theta_hub += step;
            ends.theta_shroud += step;
        }
        None
    }

    /// The ends of the wall's ruling, each moved by R + allowance along the surface of hub or shroud. `None`
    /// where the wall does not extend to these s, or the channel is too low.
    fn plain_offset(&self, wall: usize, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        // Where the channel is hardly higher than the allowance the direction from M to W is undefined.
        let (hub, shroud) = (self.part.hub.at(s_hub), self.part.shroud.point(s_shroud));
        let (rise_r, rise_z) = (shroud.r - hub.point.r, shroud.z - hub.point.z);
        let height = rise_r * hub.normal.r + rise_z * hub.normal.z;
        if height < MIN_HEIGHTS * self.hub_allowance {
            return None;
        }
        let reach = (self.radius + self.blade_allowance) * self.inward_sign(wall);
        let [theta_hub, theta_shroud] =
            self.passage.walls[wall].ruling_offset(self.part, [s_hub, s_shroud], reach)?;
        Some(AxisEnds { s_hub, s_shroud, theta_hub, theta_shroud })
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

    /// Distance between the two wall axes at `s`, on the hub and on the shroud, mm: perpendicular to the flow
    /// or to the axis, whichever is smaller. `None` where the cutter does not fit.
    pub fn width(&self, s: f64) -> Option<(f64, f64)> {
        let (low, high) = self.guide_axes(s, s, true)?;
        let pair = self.ordered_pair(low, high)?;
        let step = 1e-3;
        let before = self.guide_axes(s - step, s - step, true).map(|(low, _)| low);
        let across = |from: Point, to: Point, along: Vector| {
            let d = to - from;
            (d - along * d.dot(&along)).norm()
        };
        let (_, axis) = self.line(&pair[0]);
        let ends = |at: &dyn Fn(&AxisEnds) -> Point| {
            let (from, to) = (at(&pair[0]), at(&pair[1]));
            let beside_axis = across(from, to, axis);
            let flow = before.map(|b| at(&b) - from).filter(|f| f.norm() > 1e-9);
            flow.map_or(beside_axis, |f| beside_axis.min(across(from, to, f.normalize())))
        };
        Some((ends(&|e| self.hub_point(e)), ends(&|e| self.shroud_point(e))))
    }

    /// Lean of `wall` at `s`: angle of the conventional axis along it to the hub normal, across the wall,
    /// rad; positive over the channel. `None` where there is no axis.
    pub fn lean_over(&self, wall: usize, s: f64) -> Option<f64> {
        let ends = self.table_axis(wall, s, s, true)?;
        let along = self.hub_point(&self.table_axis(wall, s - 1e-3, s - 1e-3, true)?) - self.hub_point(&ends);
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
        let [low, high] = self.ordered_pair(low, high)?;
        Some(AxisEnds {
            theta_hub: low.theta_hub + lambda * (high.theta_hub - low.theta_hub),
            theta_shroud: low.theta_shroud + lambda * (high.theta_shroud - low.theta_shroud),
            ..low
        })
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
