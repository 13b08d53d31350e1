//! Lanes: passages as one cutter sees them, and the axes in them that clear both walls.
//!
//! A wall axis starts as the offset of the wall's ruling by R + allowance (paper C, fig. 5 to 7); that plain
//! offset gouges where rulings twist. It is corrected against the true surface until the cutter
//! is equally far from the wall near its root and near its tip and its nearest place anywhere is at the
//! allowance: a fit that is unique whether the wall bulges towards the cutter or away from it.

use super::fit_table::FitTable;
use crate::geometry::{CutterSolid, Point, Vector, wrap_angle};
use crate::part::{Impeller, Passage, SideProbe, Tool};

/// A passage with the cutter that is to work in it.
#[derive(Debug)]
pub struct Lane<'a> {
    part: &'a Impeller,
    passage: &'a Passage,
    probes: [SideProbe; 2],
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

/// How the clearance from one third of a wall stands, and answers to turning the ends of the axis.
#[derive(Clone, Copy, Debug)]
struct Answer {
    /// mm per rad of M.
    by_hub: f64,
    /// mm per rad of W.
    by_shroud: f64,
    /// Clearance beyond the allowance, mm.
    excess: f64,
}

/// A fit in progress: root, middle and tip third of the wall.
#[derive(Clone, Copy, Debug)]
struct FitState {
    answers: [Answer; 3],
    /// Distance from M to W, mm.
    height: f64,
}

impl FitState {
    fn nearest(&self) -> Answer {
        let [low, middle, high] = self.answers;
        [low, middle, high].into_iter().min_by(|a, b| a.excess.total_cmp(&b.excess)).unwrap_or(low)
    }

    /// How far from what a fit shall be, mm.
    fn merit(&self) -> f64 {
        let [low, _, high] = self.answers;
        self.nearest().excess.abs().max((low.excess - high.excess).abs())
    }

    /// Newton step of M's and W's angles towards root and tip equally far off and the nearest place at the
    /// allowance.
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

/// How far the side lean of a fitted axis may leave the plain offset of the ruling.
const LEAN_LIMIT_RAD: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// Clearance is met to this, mm, always on the safe side.
const FIT_TOLERANCE: f64 = 2e-7;
/// Two searches for the nearest place of a wall may differ by so much, mm: fits stay clear of it.
const SEARCH_ERROR: f64 = 4e-6;

impl<'a> Lane<'a> {
    /// `passage` of `part` for `tool`.
    pub fn new(
        part: &'a Impeller,
        passage: &'a Passage,
        tool: &Tool,
        hub_allowance: f64,
        blade_allowance: f64,
    ) -> Self {
        let probe = |i: usize| {
            // The flank runs on as far as rows reach beyond its ends; further out its extension would only
            // stand in the way of columns that lean over it.
            let side = passage.walls[i].side();
            let (from, to) = side.u_range();
            let chord = (side.point(1.0, 0.5) - side.point(0.0, 0.5)).norm();
            let reach = (tool.radius() + blade_allowance) / chord.max(1e-6);
            SideProbe::new(side, from - (3.0 * reach).min(0.3), to + (4.0 * reach).clamp(0.1, 0.5))
        };
        let spacing = (1.2 * tool.insert_width / part.hub.length()).clamp(0.004, 0.03);
        Self {
            tables: [FitTable::new(spacing), FitTable::new(spacing)],
            part,
            passage,
            probes: [probe(0), probe(1)],
            radius: tool.radius(),
            corner_radius: tool.corner_radius,
            hub_allowance,
            blade_allowance: blade_allowance + SEARCH_ERROR,
        }
    }

    /// M of `ends`.
    pub fn hub_point(&self, ends: &AxisEnds) -> Point {
        let here = self.part.hub.at(ends.s_hub);
        let (p, n, a) = (here.point, here.normal, self.hub_allowance);
        crate::geometry::Meridional { r: p.r + a * n.r, z: p.z + a * n.z }.at_angle(ends.theta_hub)
    }

    /// W of `ends`.
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

    /// +1 where growing θ leads into the passage from this wall.
    fn inward(&self, wall: usize) -> f64 {
        self.part.pitch().signum() * if wall == 0 { 1.0 } else { -1.0 }
    }

    /// Axis along `wall` (0 or 1) with M at `s_hub` and W at `s_shroud`; `warm` is a neighbouring
    /// solution to start from. `None` where the wall does not reach.
    pub fn wall_axis(
        &self,
        wall: usize,
        s_hub: f64,
        s_shroud: f64,
        warm: Option<AxisEnds>,
    ) -> Option<AxisEnds> {
        let plain = self.plain_offset(wall, s_hub, s_shroud)?;
        let plain_lean = plain.theta_shroud - plain.theta_hub;
        let mut ends = match warm {
            Some(w) => AxisEnds { s_hub, s_shroud, theta_shroud: w.theta_shroud, theta_hub: w.theta_hub },
            None => plain,
        };
        // Where each third of the wall was nearest: found once, then followed.
        let mut places = [None; 3];
        let mut state = self.fit_state(wall, &ends, &mut places);
        for _ in 0..12 {
            if state.merit() < FIT_TOLERANCE {
                break;
            }
            let (dm, dw) = state.step()?;
            let r_hub = self.part.hub.point(s_hub).r.max(1e-6);
            let r_shroud = self.part.shroud.point(s_shroud).r.max(1e-6);
            // Several fits may exist on a twisted wall: stay on the branch of the ruling.
            let lean_limit = LEAN_LIMIT_RAD.tan() * state.height / r_shroud;
            let limit = 0.25 * self.radius / r_hub;
            // A step that makes things worse has left the stretch where slopes tell the truth: halve it.
            let mut scale = 1.0;
            let mut improved = false;
            for _ in 0..5 {
                let mut next = ends;
                next.theta_hub += (scale * dm).clamp(-limit, limit);
                next.theta_shroud += (scale * dw).clamp(-limit, limit);
                let lean = next.theta_shroud - next.theta_hub;
                next.theta_shroud =
                    next.theta_hub + lean.clamp(plain_lean - lean_limit, plain_lean + lean_limit);
                let mut there = places;
                let next_state = self.fit_state(wall, &next, &mut there);
                if next_state.merit() < state.merit() {
                    (ends, state, places, improved) = (next, next_state, there, true);
                    break;
                }
                scale *= 0.4;
            }
            if !improved {
                break;
            }
        }
        self.push_clear(wall, ends, 0.0)
    }

    /// Clearances of an axis from the thirds of a wall, and how they answer to turning M and W.
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
            let (away, clearance) = self.away(wall, &cutter, &near.point, near.distance);
            let share = (along / height).clamp(-0.2, 1.2);
            Answer {
                by_hub: (1.0 - share) * away.dot(&Vector::new(-m.y, m.x, 0.0)),
                by_shroud: share * away.dot(&Vector::new(-w.y, w.x, 0.0)),
                excess: clearance - self.blade_allowance,
            }
        });
        FitState { answers, height }
    }

    /// Direction in which the cutter leaves `point` of a wall, and its clearance there: negative without end
    /// when the axis itself is beyond the wall.
    fn away(&self, wall: usize, cutter: &CutterSolid, point: &Point, distance: f64) -> (Vector, f64) {
        let d = point - cutter.tip;
        let flat = -(d - cutter.axis * d.dot(&cutter.axis));
        let length = flat.norm();
        if length < 1e-9 {
            return (flat, -self.radius);
        }
        let away = flat / length;
        let into_passage = Vector::new(-point.y, point.x, 0.0) * self.inward(wall);
        if away.dot(&into_passage) >= 0.0 { (away, distance) } else { (-away, -length - self.radius) }
    }

    /// Turns both ends away from `wall` until the cutter, its bottom `lift` mm above M, keeps the
    /// allowance everywhere. `None` when turning does not help.
    fn push_clear(&self, wall: usize, mut ends: AxisEnds, lift: f64) -> Option<AxisEnds> {
        let mut place: Option<f64> = None;
        for _ in 0..20 {
            let mut cutter = self.cutter(&ends);
            cutter.tip += cutter.axis * lift;
            // Turned by micrometres, the cutter stays nearest to the same place.
            let near = match place {
                Some(u) => self.probes[wall].nearest_from(&cutter, u, 0.0, 1.0),
                None => self.probes[wall].nearest(&cutter, 0.0, 1.0),
            };
            let (away, clearance) = self.away(wall, &cutter, &near.point, near.distance);
            let short = self.blade_allowance - clearance;
            if short <= 0.0 {
                return Some(ends);
            }
            let turn = Vector::new(-near.point.y, near.point.x, 0.0);
            let gain = away.dot(&turn).abs().max(0.2 * turn.norm());
            let step = (short + FIT_TOLERANCE) / gain * self.inward(wall);
            if !step.is_finite() || step.abs() > 0.5 {
                return None;
            }
            place = (short < 0.01).then_some(near.u);
            ends.theta_hub += step;
            ends.theta_shroud += step;
        }
        None
    }

    /// The ruling's ends, each moved by R + allowance along the surface of hub or shroud.
    fn plain_offset(&self, wall: usize, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        let foot = self.passage.walls[wall].at(self.part, s_hub, 0.0)?;
        let top = self.passage.walls[wall].at(self.part, s_shroud, 1.0)?;
        let reach = self.radius + self.blade_allowance;
        let offset = |r: f64, theta_s: f64, length: f64| {
            let slope = r * theta_s / length;
            reach * (1.0 + slope * slope).sqrt().min(4.0) / r.max(1e-6) * self.inward(wall)
        };
        let (r_hub, r_shroud) = (self.part.hub.point(s_hub).r, self.part.shroud.point(s_shroud).r);
        let theta_shroud = foot.theta + wrap_angle(top.theta - foot.theta);
        Some(AxisEnds {
            s_hub,
            s_shroud,
            theta_hub: foot.theta + offset(r_hub, foot.theta_s, self.part.hub.length()),
            theta_shroud: theta_shroud + offset(r_shroud, top.theta_s, self.part.shroud.length()),
        })
    }

    /// Both wall axes at the same ends; `None` where a wall does not reach or the cutter does not
    /// fit between them.
    pub fn wall_pair(&self, s_hub: f64, s_shroud: f64) -> Option<[AxisEnds; 2]> {
        let low = self.wall_axis(0, s_hub, s_shroud, None)?;
        let mut high = self.wall_axis(1, s_hub, s_shroud, None)?;
        // Bring the second wall's angles next to the first's.
        let half = 0.5 * self.part.pitch();
        let beside = |a: f64, b: f64| a + wrap_angle(b - a - half) + half;
        high.theta_hub = beside(low.theta_hub, high.theta_hub);
        high.theta_shroud = beside(low.theta_shroud, high.theta_shroud);
        let open = |a: f64, b: f64| (b - a) * self.part.pitch().signum() >= 0.0;
        (open(low.theta_hub, high.theta_hub) && open(low.theta_shroud, high.theta_shroud))
            .then_some([low, high])
    }

    /// Distance across the flow between the two wall axes at `s`: on the hub and on the shroud, mm. `None` where the
    /// cutter does not fit.
    pub fn width(&self, s: f64) -> Option<(f64, f64)> {
        let pair = self.wall_pair(s, s)?;
        let step = 1e-3;
        let before = self.wall_axis(0, s - step, s - step, Some(pair[0]));
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

    /// By how much the conventional axis along `wall` leans over the channel from the hub normal, across the
    /// wall, rad; negative where the wall leans away. `None` where there is no axis.
    pub fn lean_over(&self, wall: usize, s: f64) -> Option<f64> {
        let ends = self.table_axis(wall, s, s)?;
        let along = self.hub_point(&self.table_axis(wall, s - 1e-3, s - 1e-3)?) - self.hub_point(&ends);
        let normal = self.part.hub.normal(s).direction_at_angle(ends.theta_hub);
        let (m, axis) = self.line(&ends);
        let across = normal.cross(&along).normalize();
        let into_passage = Vector::new(-m.y, m.x, 0.0) * self.inward(wall);
        let lean = axis.dot(&across) * across.dot(&into_passage).signum();
        Some(lean.atan2(axis.dot(&normal)))
    }

    /// Axis of `wall` read from its table of fits, a few µm from the exact one.
    fn table_axis(&self, wall: usize, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        let fit = |s_hub: f64, shift: f64| {
            let ends = self.wall_axis(wall, s_hub, s_hub - shift, None)?;
            Some([ends.theta_hub, ends.theta_shroud])
        };
        let [theta_hub, theta_shroud] = self.tables[wall].at(s_hub, s_hub - s_shroud, &fit)?;
        Some(AxisEnds { s_hub, s_shroud, theta_hub, theta_shroud })
    }

    /// Axis of the row at `lambda` between the walls, from the tables of fits: for searches.
    /// `None` where no axis clears both walls, or one next to it in the tables does not.
    pub fn row_axis(&self, lambda: f64, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        self.between(lambda, |wall| self.table_axis(wall, s_hub, s_shroud))
    }

    /// As [`Self::row_axis`], fitted anew: where the tables end.
    pub fn row_axis_fitted(&self, lambda: f64, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
        self.between(lambda, |wall| self.wall_axis(wall, s_hub, s_shroud, None))
    }

    /// The conventional axis of the row at `lambda` with M at `s`: M and W at the same fraction of arc length. Outside the
    /// channel both go on by the same distance, so that the axis stays as it is at the rim (or the leading edge).
    pub fn isoparametric(&self, lambda: f64, s: f64) -> Option<AxisEnds> {
        let inside = s.clamp(0.0, 1.0);
        let s_shroud = inside + (s - inside) * self.part.hub.length() / self.part.shroud.length();
        self.row_axis(lambda, s, s_shroud).or_else(|| self.row_axis_fitted(lambda, s, s_shroud))
    }

    /// The axis at `lambda` between the axes of both walls.
    fn between(&self, lambda: f64, axis: impl Fn(usize) -> Option<AxisEnds>) -> Option<AxisEnds> {
        if is_wall(lambda) {
            return axis(lambda as usize);
        }
        let (low, high) = (axis(0)?, axis(1)?);
        let half = 0.5 * self.part.pitch();
        let across = |a: f64, b: f64| wrap_angle(b - a - half) + half;
        let (hub, shroud) =
            (across(low.theta_hub, high.theta_hub), across(low.theta_shroud, high.theta_shroud));
        let sign = self.part.pitch().signum();
        (hub * sign >= 0.0 && shroud * sign >= 0.0).then_some(AxisEnds {
            theta_hub: low.theta_hub + lambda * hub,
            theta_shroud: low.theta_shroud + lambda * shroud,
            ..low
        })
    }

    /// A row's axis made exact: an axis at a wall, its bottom `lift` mm above M, rests at the
    /// allowance; others are good as they are.
    pub fn settled(&self, lambda: f64, ends: AxisEnds, lift: f64) -> Option<AxisEnds> {
        if is_wall(lambda) { self.push_clear(lambda as usize, ends, lift) } else { Some(ends) }
    }
}
