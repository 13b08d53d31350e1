//! Rows of positions: stage 1 (conventional positions) and stage 2 (step inspection) of [plunge paper].

use super::lane::{AxisEnds, Lane};
use super::reasons::{Blocked, LimitedBy};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::{CutterSolid, Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Impeller;
use crate::setup::Tool;

/// Maximum number of samples or coarse stations along a row: a bound on time and memory where the step is
/// tiny beside the row.
const MAX_SAMPLES: usize = 4000;
/// Distance of the coarse stations of a row, in step limits: they only measure by how much a row that runs
/// oblique to the meridian is longer.
const COARSE_STEPS: f64 = 3.0;
/// Maximum number of stations for each coarse one: a bound where a row is stretched without limit.
const MAX_PER_COARSE: usize = 64;
/// Distance on the hub, in step limits, up to which another station between two would not help: their axes
/// spread.
const TOO_CLOSE_STEPS: f64 = 0.02;

/// One position while it is being planned.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Ends of the axis.
    pub ends: AxisEnds,
    /// s of W before axis optimisation.
    pub s_shroud_conventional: f64,
    /// Tip at the drop-cutter depth, frame of the part, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Contact point on the allowance surface of the hub, mm.
    pub contact_point: Point,
    /// α: angle between hub normal and axis, rad, positive towards the inlet.
    pub alpha_rad: f64,
    /// Why it lacks the axis the policy prescribes, if it does.
    pub blocked: Option<Blocked>,
    /// What keeps it from the axis that would leave the least stock.
    pub limited_by: Option<LimitedBy>,
}

impl Station {
    /// The station turned about Z by `angle_rad`.
    pub fn turned(&self, angle_rad: f64) -> Self {
        let ends = AxisEnds {
            theta_hub: self.ends.theta_hub + angle_rad,
            theta_shroud: self.ends.theta_shroud + angle_rad,
            ..self.ends
        };
        Self {
            ends,
            tip: rotate_z(&self.tip, angle_rad),
            axis: rotate_vector_z(&self.axis, angle_rad),
            contact_point: rotate_z(&self.contact_point, angle_rad),
            ..*self
        }
    }

    /// Distance of W from its conventional position, in s.
    pub fn shroud_shift(&self) -> f64 {
        (self.s_shroud_conventional - self.ends.s_shroud).abs()
    }
}

/// Makes the stations of one row; holds what is constant along it.
#[derive(Clone, Debug)]
pub struct RowMaker<'a> {
    /// The part.
    pub part: &'a Impeller,
    /// The passage with its wall axes for this cutter.
    pub lane: &'a Lane<'a>,
    /// Hub, offset by allowance and corner radius.
    pub hub: &'a DepthSurface<'a>,
    /// The tool.
    pub tool: &'a Tool,
    /// Position of the row across the passage, 0 at the suction wall, 1 at the pressure wall.
    pub lambda: f64,
    /// +1 when the row is cut outlet → inlet, −1 when it is cut inlet → outlet.
    pub direction_sign: f64,
    /// Upper limit of the step, mm.
    pub step_limit: f64,
    /// Checked for cancellation between stations.
    pub monitor: &'a Monitor,
}

/// The cuttable stretches of a row; see [`RowMaker::runs`].
#[derive(Clone, Debug, Default)]
pub struct Runs {
    /// First and last s of each stretch.
    pub stretches: Vec<(f64, f64)>,
    /// s of the samples at which no axis clears the walls.
    pub missing: Vec<f64>,
}

impl RowMaker<'_> {
    /// The conventional station at `s`, lowered onto the hub. `None` where no axis clears the walls.
    pub fn isoparametric(&self, s: f64) -> Option<Station> {
        self.exact(&self.lower_to_hub(self.lane.isoparametric(self.lambda, s)?))
    }

    /// A station from the tables of fits, for searches: its axis from `s_hub` to `s_shroud` is a few µm off.
    pub fn draft(&self, s_hub: f64, s_shroud: f64) -> Option<Station> {
        Some(self.lower_to_hub(self.lane.row_axis(self.lambda, s_hub, s_shroud)?))
    }

    /// `draft` made exact: fixed-point iteration of drop-cutter depth and clearance from the wall at that
    /// depth.
    pub fn exact(&self, draft: &Station) -> Option<Station> {
        let mut station = *draft;
        for _ in 0..3 {
            let lift = (station.tip - self.lane.hub_point(&station.ends)).dot(&station.axis);
            let ends = self.lane.exact_axis(self.lambda, station.ends, lift)?;
            if ends == station.ends {
                break;
            }
            station = self.lower_to_hub(ends);
        }
        Some(Station {
            s_shroud_conventional: draft.s_shroud_conventional,
            blocked: draft.blocked,
            limited_by: draft.limited_by,
            ..station
        })
    }

    /// Stage 4 for a given axis: drop-cutter tip, contact point and α.
    pub fn lower_to_hub(&self, ends: AxisEnds) -> Station {
        let (m, axis) = self.lane.line(&ends);
        let corner = self.tool.corner_radius;
        let arc = self.part.hub.arc_at(ends.s_hub).clamp(0.0, self.part.hub.curve().length());
        let touch = self.hub.touch_near(&m, &axis, self.tool.radius() - corner, arc);
        let (tip, contact_point, alpha) = match touch {
            Some(t) => {
                // At an edge of the hub α refers to the normal of the hub surface.
                let theta = t.point.y.atan2(t.point.x);
                let normal = self.part.hub.curve().at(t.arc).normal.direction_at_angle(theta);
                (m + axis * (t.height - corner), t.point, self.alpha(&m, &axis, &normal, &ends))
            }
            // The bottom misses the hub: the tip stays at M, α refers to the hub normal there.
            None => {
                let normal = self.part.hub.normal(ends.s_hub).direction_at_angle(ends.theta_hub);
                (m, m, self.alpha(&m, &axis, &normal, &ends))
            }
        };
        Station {
            ends,
            s_shroud_conventional: ends.s_shroud,
            tip,
            axis,
            contact_point,
            alpha_rad: alpha,
            blocked: None,
            limited_by: None,
        }
    }

    /// Signed angle between `normal` and `axis` in the plane of normal and the direction towards the inlet.
    fn alpha(&self, m: &Point, axis: &Vector, normal: &Vector, ends: &AxisEnds) -> f64 {
        let step = 1e-4;
        let upstream = AxisEnds { s_hub: ends.s_hub - step, ..*ends };
        let towards = self.lane.hub_point(&upstream) - m;
        let flat = (towards - normal * towards.dot(normal)).normalize();
        axis.dot(&flat).atan2(axis.dot(normal))
    }

    /// Cutter of a station.
    pub fn cutter(&self, station: &Station) -> CutterSolid {
        self.tool.placed(station.tip, station.axis)
    }

    /// The stretches of s from `start` to `end` on which the conventional axis clears the walls, in cutting
    /// order, and the samples between them at which it does not. Sampled at the step limit.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn runs(&self, start: f64, end: f64) -> Result<Runs, Cancelled> {
        let length = (end - start).abs() * self.part.hub.length().max(self.part.shroud.length());
        let count = ((length / self.step_limit).ceil() as usize).clamp(1, MAX_SAMPLES);
        let mut runs = Runs::default();
        let mut open: Option<(f64, f64)> = None;
        for i in 0..=count {
            self.monitor.check()?;
            let s = start + (end - start) * i as f64 / count as f64;
            if self.isoparametric(s).is_some() {
                open = Some((open.map_or(s, |(from, _)| from), s));
            } else {
                runs.missing.push(s);
                runs.stretches.extend(open.take());
            }
        }
        runs.stretches.extend(open);
        Ok(runs)
    }

    /// Stage 1: isoparametric stations evenly spaced from s = `start` to s = `end`, no further apart than the
    /// step limit at hub and shroud, up to the first one at which no axis clears the walls.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn conventional(&self, start: f64, end: f64) -> Result<Vec<Station>, Cancelled> {
        let station = |s: f64| {
            self.monitor.check()?;
            Ok(self.isoparametric(s))
        };
        let run = (end - start).abs();
        let longest = run * self.part.hub.length().max(self.part.shroud.length());
        let coarse = ((longest / self.step_limit / COARSE_STEPS).ceil() as usize).clamp(1, MAX_SAMPLES);
        let at = |i: usize, n: usize| start + (end - start) * i as f64 / n as f64;
        let mut sparse = Vec::with_capacity(coarse + 1);
        for i in 0..=coarse {
            match station(at(i, coarse))? {
                Some(station) => sparse.push(station),
                None => break,
            }
        }
        // Rows run oblique to the meridian, so the spacing is measured on a coarse row first.
        let stretch = sparse.windows(2).map(|w| self.spacing(&w[0], &w[1])).fold(0.0, f64::max);
        let per_gap = ((stretch / self.step_limit - 1e-9).ceil() as usize).clamp(1, MAX_PER_COARSE);
        if per_gap == 1 {
            return Ok(sparse);
        }
        let n = coarse * per_gap;
        let last = sparse.len().saturating_sub(1) * per_gap;
        let mut stations = Vec::with_capacity(n + 1);
        for i in 0..=last {
            if i % per_gap == 0 {
                stations.push(sparse[i / per_gap]);
                continue;
            }
            match station(at(i, n))? {
                Some(station) => stations.push(station),
                None => break,
            }
        }
        Ok(stations)
    }

    /// Spacing of two neighbouring stations, mm; see [`Lane::spacing`].
    pub fn spacing(&self, a: &Station, b: &Station) -> f64 {
        self.lane.spacing((a.tip, a.axis), &b.ends)
    }

    /// Whether a station has to be inserted between `a` and `b`, which are `apart` in s: their spacing
    /// exceeds the step limit, and they are not yet so close on the hub that inserting would not help.
    pub fn needs_another(&self, a: &Station, b: &Station, apart: f64) -> bool {
        self.spacing(a, b) > self.step_limit * (1.0 + 1e-9)
            && apart.abs() * self.part.hub.length() > TOO_CLOSE_STEPS * self.step_limit
    }

    /// Stage 2: inserts isoparametric stations into `conventional` wherever the spacing of the `optimised`
    /// ones exceeds the step limit ([plunge paper], fig. 6). Returns the number inserted.
    pub fn inspect_steps(&self, optimised: &[Station], conventional: &mut Vec<Station>) -> usize {
        let mut refined = Vec::with_capacity(conventional.len());
        let mut inserted = 0;
        for i in 0..conventional.len() {
            refined.push(conventional[i]);
            if i + 1 == conventional.len() || self.monitor.is_cancelled() {
                continue;
            }
            let (a, b) = (conventional[i].ends.s_hub, conventional[i + 1].ends.s_hub);
            if !self.needs_another(&optimised[i], &optimised[i + 1], b - a) {
                continue;
            }
            let middle = 0.5 * (a + b);
            if let Some(station) = self.isoparametric(middle) {
                refined.push(station);
                inserted += 1;
            }
        }
        *conventional = refined;
        inserted
    }
}
