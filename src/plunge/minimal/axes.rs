//! Axes of a row at one s: a grid of lead angles about the hub normal, and the axes of a lead angle with
//! several tilt angles.

use super::axis_frame::{AxisFrame, LeadGrid, MIDDLE_LEAD_DEG, RowFrame, ZeroLeadRef};
use super::candidate::CandidateMaker;
use crate::geometry::{Vector, wrap_angle};
use crate::plunge::lane::{AxisEnds, is_wall};
use crate::plunge::row::Station;

/// Distance between the fitted axis of a wall row and the plain offset of the ruling from which on axes
/// turned off the wall are tried too, in cutter radii.
const OFF_FOOT_RADII: f64 = 0.3;
/// Largest tilt angle by which they are turned from the ruling, degrees.
const MAX_TURNED_DEG: f64 = 24.0;
/// Least share of a turn of W about Z that is across the row: with less, turning does not change the tilt
/// angle.
const MIN_GAIN_SHARE: f64 = 0.2;

/// Step of s for finite differences.
const SLOPE_STEP: f64 = 2e-3;

impl CandidateMaker<'_> {
    /// The reference at `s_hub`.
    pub(super) fn axis_frame(&self, s_hub: f64) -> Option<AxisFrame> {
        let conventional = self.isoparametric(s_hub)?;
        let frame = self.row_frame(&conventional)?;
        let (_, reference) = self.maker.lane.line(&conventional);
        let lead_rad = reference.dot(&frame.feed).atan2(reference.dot(&frame.normal));
        // The grid is shifted towards positive lead angles only: with large negative ones each plunge would
        // end above the previous one. Where no others remain, the row ends.
        let moved_rad = (lead_rad - self.max_tilt_rad - MIDDLE_LEAD_DEG.to_radians()).max(0.0);
        let zero_lead = self.zero_lead_ref(&conventional, &frame, moved_rad)?;
        let (conventional_lead_rad, grid) = (lead_rad - moved_rad, LeadGrid::USUAL);
        Some(AxisFrame { conventional, frame, zero_lead, reference, conventional_lead_rad, grid })
    }

    /// Ends of the conventional axis at `s_hub`, whether or not it clears the walls.
    pub(super) fn isoparametric(&self, s_hub: f64) -> Option<AxisEnds> {
        self.maker.lane.reference_axis(self.maker.lambda, s_hub)
    }

    /// Local frame at the foot of a conventional axis.
    fn row_frame(&self, ends: &AxisEnds) -> Option<RowFrame> {
        let normal = self.maker.part.hub.normal(ends.s_hub).direction_at_angle(ends.theta_hub);
        let (before, after) =
            (self.isoparametric(ends.s_hub + SLOPE_STEP)?, self.isoparametric(ends.s_hub - SLOPE_STEP)?);
        let ahead = self.maker.lane.hub_point(&after) - self.maker.lane.hub_point(&before);
        let turn = wrap_angle(before.theta_hub - after.theta_hub);
        let flat = (ahead - normal * ahead.dot(&normal)) * self.maker.direction_sign;
        let length = flat.norm();
        if length < 1e-9 {
            return None;
        }
        let feed = flat / length;
        let path_by_s = (length / (2.0 * SLOPE_STEP), turn / (2.0 * SLOPE_STEP));
        Some(RowFrame { normal, feed, across: normal.cross(&feed), path_by_s })
    }

    /// Newton iteration for the s of W at which the lead angle is `moved_rad`.
    fn zero_lead_ref(&self, from: &AxisEnds, frame: &RowFrame, moved_rad: f64) -> Option<ZeroLeadRef> {
        let lane = self.maker.lane;
        let m = lane.hub_point(from);
        // The row's shroud curve; where it has no axis, the angles about Z of `from` are kept.
        let to_shroud = |s_shroud: f64| {
            let ends = lane
                .row_axis(self.maker.lambda, from.s_hub, s_shroud)
                .unwrap_or(AxisEnds { s_shroud, ..*from });
            lane.shroud_point(&ends) - m
        };
        // Tangent of the lead angle, from the one that is looked for.
        let excess = |w: &Vector| w.dot(&frame.feed) / w.dot(&frame.normal) - moved_rad.tan();
        let mut s_shroud = from.s_shroud;
        let mut slope = 0.0;
        for _ in 0..4 {
            let (before, after) = (to_shroud(s_shroud - SLOPE_STEP), to_shroud(s_shroud + SLOPE_STEP));
            slope = (excess(&after) - excess(&before)) / (2.0 * SLOPE_STEP);
            let step = 0.5 * (excess(&before) + excess(&after)) / slope;
            if !step.is_finite() {
                return None;
            }
            s_shroud -= step.clamp(-0.3, 0.3);
            if !(-1.0..2.0).contains(&s_shroud) {
                return None;
            }
        }
        let height = to_shroud(s_shroud).dot(&frame.normal);
        (slope * self.maker.direction_sign < 0.0 && height > 0.0).then_some(ZeroLeadRef {
            s_shroud,
            shift_rad: moved_rad,
            tan_lead_by_s: slope,
            height,
        })
    }

    /// Axes at `s_hub` with W at `s_shroud`: at a wall only the row's own one; between walls one for each of
    /// `shares` from the row's own tilt angle (0) to the smallest one that the limit of displacement across
    /// the row allows (1).
    pub(super) fn axes<const N: usize>(
        &self,
        s_shroud: f64,
        (s_hub, frame, zero_lead): (f64, &RowFrame, &ZeroLeadRef),
        shares: [f64; N],
    ) -> [Option<AxisEnds>; N] {
        let maker = self.maker;
        let mut only = [None; N];
        let Some(ends) = maker.lane.row_axis(maker.lambda, s_hub, s_shroud) else { return only };
        only[0] = Some(ends);
        if is_wall(maker.lambda) {
            self.add_turned(&mut only, &ends, (frame, zero_lead));
            return only;
        }
        if self.max_side_shift <= 0.0 {
            return only;
        }
        let w = maker.lane.shroud_point(&ends);
        let shift = (w - maker.lane.hub_point(&ends)).dot(&frame.across);
        let most = -shift.clamp(-self.max_side_shift, self.max_side_shift);
        // Turning W about Z changes the lead angle as well; s of W compensates that.
        let turn = Vector::new(-w.y, w.x, 0.0);
        let by_s = zero_lead.tan_lead_by_s * zero_lead.height;
        let gain = turn.dot(&frame.across);
        if gain.abs() < MIN_GAIN_SHARE * turn.norm() {
            return only;
        }
        shares.map(|share| {
            let angle = share * most / gain;
            let s_shroud = s_shroud - angle * turn.dot(&frame.feed) / by_s;
            let ends = maker.lane.row_axis(maker.lambda, s_hub, s_shroud)?;
            Some(AxisEnds { theta_shroud: ends.theta_shroud + angle, ..ends })
        })
    }

    /// Fills the free slots after the own axis `ends` of a wall row with axes of which W is turned off the
    /// wall. A twisted or bowed wall keeps the cutter that is fitted along it off its foot, where a strip
    /// stays uncut; an axis with less tilt gets nearer.
    fn add_turned<const N: usize>(
        &self,
        only: &mut [Option<AxisEnds>; N],
        ends: &AxisEnds,
        (frame, zero_lead): (&RowFrame, &ZeroLeadRef),
    ) {
        let (lane, wall) = (self.maker.lane, self.maker.lambda as usize);
        if lane.distance_from_plain(wall, ends) <= OFF_FOOT_RADII * self.maker.tool.radius() {
            return;
        }
        for (k, slot) in only.iter_mut().enumerate().skip(1) {
            let tilt_rad = (MAX_TURNED_DEG * k as f64 / (N - 1) as f64).to_radians();
            *slot = self.turned_off_wall(ends, tilt_rad, (frame, zero_lead));
        }
    }

    /// Stations of a wall row at `s_hub` with lead angles `leads_rad` (from that of the conventional axis),
    /// each with W turned off the wall by the tilt angles `turns_deg` (negative ones turn it over the
    /// wall's foot) and as near to the wall as it clears it. They are not checked against other blades.
    pub(super) fn wall_fan<const N: usize>(
        &self,
        s_hub: f64,
        leads_rad: impl Iterator<Item = f64>,
        turns_deg: &[f64; N],
    ) -> Vec<Station> {
        let Some(AxisFrame { conventional, frame, zero_lead, reference, conventional_lead_rad, .. }) =
            self.axis_frame(s_hub)
        else {
            return Vec::new();
        };
        let ends_at = |lead_rad: f64| {
            let s_shroud = zero_lead.s_shroud_at_lead(conventional_lead_rad + lead_rad);
            self.maker.lane.row_axis(self.maker.lambda, s_hub, s_shroud)
        };
        let turned = |ends: AxisEnds| {
            turns_deg.iter().filter_map(move |&turn_deg| match turn_deg {
                0.0 => Some(ends),
                _ => self.turned_off_wall(&ends, turn_deg.to_radians(), (&frame, &zero_lead)),
            })
        };
        leads_rad
            .filter_map(ends_at)
            .flat_map(turned)
            .filter_map(|ends| self.station_within_limits(ends, &reference))
            .map(|station| Station { s_shroud_conventional: conventional.s_shroud, ..station })
            .collect()
    }

    /// The axis `ends` of a wall row with W turned off the wall by the tilt angle `tilt_rad`.
    fn turned_off_wall(
        &self,
        ends: &AxisEnds,
        tilt_rad: f64,
        (frame, zero_lead): (&RowFrame, &ZeroLeadRef),
    ) -> Option<AxisEnds> {
        let (lane, wall) = (self.maker.lane, self.maker.lambda as usize);
        let w = lane.shroud_point(ends);
        let turn = Vector::new(-w.y, w.x, 0.0);
        let gain = turn.dot(&frame.across).abs().max(MIN_GAIN_SHARE * turn.norm());
        // Turning W about Z changes the lead angle as well; s of W compensates that.
        let by_s = zero_lead.tan_lead_by_s * zero_lead.height;
        let angle = tilt_rad.tan() * zero_lead.height / gain * lane.inward_sign(wall);
        let s_shroud = ends.s_shroud - angle * turn.dot(&frame.feed) / by_s;
        lane.turned_wall_axis(wall, (ends.s_hub, s_shroud), angle)
    }
}
