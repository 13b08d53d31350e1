//! One axis along a wall: fitted to it, or turned off it until it clears the blades.
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

use super::{AxisEnds, Lane, SEARCH_ERROR};
use crate::geometry::{CutterSolid, Vector, norm2, wrap_angle};
use crate::part::{NearestOnSide, SideProbe};

/// Maximum difference of the tilt angle of a fitted axis from that of the plain offset of the ruling.
const TILT_LIMIT_RAD: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// Tilt angles relative to the plain offset that are tried where no fit exists, degrees.
const TILT_OFFSETS_DEG: [f64; 15] =
    [0.0, 3.0, -3.0, 6.0, -6.0, 9.0, -9.0, 13.0, -13.0, 17.0, -17.0, 22.0, -22.0, 28.0, -28.0];
/// Minimum height of the channel for an axis, in hub allowances.
const MIN_HEIGHTS: f64 = 1.2;
/// Tolerance of the clearance, mm, always on the safe side.
const FIT_TOLERANCE: f64 = 2e-7;

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

impl Lane<'_> {
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
    pub(super) fn fit_axis(
        &self,
        wall: usize,
        s_hub: f64,
        s_shroud: f64,
        warm: Option<AxisEnds>,
    ) -> Option<AxisEnds> {
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
    pub(super) fn axis_beside_blades(&self, wall: usize, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
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
    pub(super) fn push_clear(&self, wall: usize, ends: AxisEnds, lift: f64) -> Option<AxisEnds> {
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
    pub(super) fn plain_offset(&self, wall: usize, s_hub: f64, s_shroud: f64) -> Option<AxisEnds> {
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
}
