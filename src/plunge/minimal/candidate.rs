//! Candidates of one position of a row: an axis for each lead angle of a grid, with a tilt angle as close to
//! zero as walls and neighbouring rows allow, lowered onto the hub.
//!
//! The lead angle is the inclination of the axis from the hub normal along the row, positive towards the
//! uncut side. The tilt angle is that across the row.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::axis_frame::{AxisFrame, LEAD_STEP_DEG, LEAD_STEPS, LeadGrid, RowFrame};
use crate::cutting::contact::{BlankTop, Earlier, PlungeColumn, cuts_deeper_than};
use crate::geometry::{CutterSolid, Meridional, Point, Vector};
use crate::part::{Blank, FinishedPart};
use crate::plunge::assembly::{AssemblyRule, DropCause};
use crate::plunge::lane::{AxisEnds, is_wall};
use crate::plunge::reasons::DropReason;
use crate::plunge::row::{RowMaker, Station};
use crate::setup::Machine;

/// The grid is too coarse when from one lead angle to the next the axis moves on the shroud by more than this
/// share of the width of the cutting ring: the next core then meets stock that the last plunge left high
/// above the hub.
const COARSE_SHARE: f64 = 0.4;
/// Error of drafts beside a wall, mm; the exact axis is computed after a path is chosen.
const DRAFT_SLACK: f64 = 5e-3;
/// Factor by which the search widens the core, so that its few lines miss nothing of the real one.
const WIDER_CORE: f64 = 1.012;
/// Factor by which a cutter is widened to tell how deep it is in the blank: where it grazes an edge of it,
/// the depth jumps.
const WIDER_CUTTER: f64 = 1.01;
/// Strips of the floor, side by side across the row, and sample points of each along the row.
const STRIPS: usize = 9;
const ALONG: usize = 7;
/// Distance of the outermost point along the row, in cutter radii.
const REACH_ALONG_RADII: f64 = 0.9;

/// Maximum number of candidates of a position for which the smallest sufficient overhang is computed.
const MAX_CAUSES: usize = 8;
/// Number of tilt angles per lead angle.
const TILT_COUNT: usize = 3;
/// Tilt angles as shares from the row's own tilt angle (0) to zero tilt (1).
const ZERO_TILT_SHARES: [f64; TILT_COUNT] = [1.0, 0.5, 0.0];

/// One candidate position, not yet checked against the blades.
#[derive(Clone, Copy, Debug)]
pub struct RowCandidate {
    /// Axis and depth.
    pub station: Station,
    /// Layer left above the allowance when this cutter moves along the row, per strip of the row's floor, mm.
    layer: [f64; STRIPS],
    /// Layer left where nothing is cut, mm.
    uncut: f64,
}

/// Cost of a layer `e`, mm: e + e²/`scale`. The square gives weight to the thickest strips, hence to the
/// 95th percentile.
fn layer_cost(e: f64, scale: f64) -> f64 {
    e + e * e / scale
}

impl RowCandidate {
    /// Lift, mm, up to which the candidate costs at most `budget`; negative when it costs more without lift.
    pub fn affordable_lift(&self, budget: f64, scale: f64) -> f64 {
        let spare = budget - self.cost(0.0, scale);
        if spare < 0.0 {
            return spare;
        }
        let covered = self.layer.iter().filter(|e| **e < self.uncut);
        let (count, sum) = covered.fold((0.0, 0.0), |(count, sum), e| (count + 1.0, sum + e));
        if count == 0.0 || budget >= self.uncut_cost(scale) {
            return f64::INFINITY;
        }
        // Inverse of cost(l) = cost(0) + n/N·(l·(1 + 2·mean(e)/scale) + l²/scale) over the n covered ones of
        // N strips.
        let half = 0.5 * (scale + 2.0 * sum / count);
        (half * half + scale * spare * STRIPS as f64 / count).sqrt() - half
    }

    /// Cost when nothing is cut here, mm.
    pub fn uncut_cost(&self, scale: f64) -> f64 {
        layer_cost(self.uncut, scale)
    }

    /// Cost of the candidate when it stops `lift` mm short: the mean of [`layer_cost`] over the layers it
    /// leaves, mm. No layer is thicker than the uncut one.
    pub fn cost(&self, lift: f64, scale: f64) -> f64 {
        let cost = |e: &f64| layer_cost((e + lift).min(self.uncut.max(*e)), scale);
        self.layer.iter().map(cost).sum::<f64>() / STRIPS as f64
    }
}

/// The candidates of one lead angle, the cheapest first; without those beyond the limits of inclination.
pub type LeadCandidates = [Option<RowCandidate>; TILT_COUNT];

/// Where a candidate is in its stage: index of the lead angle, and of the tilt angle.
pub type CandidateIndex = (usize, usize);

/// Result of checking a candidate against the blades.
#[derive(Clone, Debug)]
enum Cleared {
    /// Neither it nor the axis fitted again from it clears them.
    Blocked,
    /// It clears them as it is.
    AsItIs,
    /// Refitted, it clears them.
    Refitted(Box<RowCandidate>),
}

/// Results of the checks of one candidate, computed on first use: several searches visit the same candidates,
/// and most searches visit few of them.
#[derive(Clone, Debug, Default)]
struct Answers {
    cleared: OnceLock<Cleared>,
    is_long_enough: OnceLock<bool>,
    column: OnceLock<PlungeColumn>,
}

/// The candidates of one stage.
#[derive(Clone, Debug)]
pub struct CandidateStage {
    /// Candidates for each lead angle of the grid.
    by_lead: Vec<LeadCandidates>,
    answers: Vec<[Answers; TILT_COUNT]>,
    frame: AxisFrame,
    floor: FloorPoints,
}

impl CandidateStage {
    /// The candidates of every `stride`-th lead angle.
    pub fn leads(&self, stride: usize) -> impl Iterator<Item = &LeadCandidates> + Clone {
        self.by_lead.iter().step_by(stride)
    }

    /// Number of lead angles.
    pub fn lead_count(&self) -> usize {
        self.by_lead.len()
    }

    /// The candidates of lead angle `lead`.
    pub fn lead(&self, lead: usize) -> &LeadCandidates {
        &self.by_lead[lead]
    }

    /// All candidates of every `stride`-th lead angle.
    pub fn indices(&self, stride: usize) -> impl Iterator<Item = CandidateIndex> {
        let of_lead = |lead: usize| (0..TILT_COUNT).map(move |tilt| (lead, tilt));
        let all = (0..self.by_lead.len()).step_by(stride).flat_map(of_lead);
        all.filter(|&(lead, tilt)| self.by_lead[lead][tilt].is_some())
    }

    /// The cheapest candidate of every `stride`-th lead angle, if there is any.
    pub fn cheapest(&self, scale: f64, stride: usize) -> Option<CandidateIndex> {
        let cost = |lead: usize| self.by_lead[lead][0].map_or(f64::INFINITY, |c| c.cost(0.0, scale));
        let leads = (0..self.by_lead.len()).step_by(stride).filter(|&lead| self.by_lead[lead][0].is_some());
        leads.min_by(|&a, &b| cost(a).total_cmp(&cost(b))).map(|lead| (lead, 0))
    }

    /// A candidate.
    pub fn candidate(&self, (lead, tilt): CandidateIndex) -> Option<&RowCandidate> {
        self.by_lead[lead][tilt].as_ref()
    }

    /// Minimum angle between axes of the same lead angle at this stage and `next`, rad; 0 when there are
    /// none.
    pub fn min_turn(&self, next: &Self) -> f64 {
        let axes = |candidates: &LeadCandidates| candidates.map(|c| c.map(|c| c.station.axis));
        let turns = self.by_lead.iter().zip(&next.by_lead).flat_map(|(here, next)| {
            let (here, next) = (axes(here).into_iter().flatten(), axes(next));
            here.flat_map(move |a| next.into_iter().flatten().map(move |b| a.angle(&b)))
        });
        turns.reduce(f64::min).unwrap_or(0.0)
    }
}

/// Makes the candidates of one row. Lengths in mm, angles in rad.
#[derive(Clone)]
pub struct CandidateMaker<'a> {
    pub maker: &'a RowMaker<'a>,
    pub finished: &'a FinishedPart,
    pub top: &'a BlankTop<'a>,
    pub hub_allowance: f64,
    pub blade_allowance: f64,
    pub max_tilt_rad: f64,
    pub machine: &'a Machine,
    /// For a tool whose shank or holder is given.
    pub assembly: Option<AssemblyRule<'a>>,
    /// A blank that stands above the shroud, and the plunges that open it.
    pub opened: Option<(Earlier<'a>, &'a Blank)>,
    /// Layer e for which e²/`scale` equals e in the cost, mm.
    pub scale: f64,
    /// Floor that the row has to clear at an s: from half way to the previous row or wall to half way to the
    /// next one, as angles about Z from M, rad.
    pub floor: &'a (dyn Fn(f64) -> Option<[f64; 2]> + Sync),
    /// Maximum displacement of W across the row on the shroud without uncut stock between the rows, mm.
    pub max_side_shift: f64,
    /// Number of parts into which the steps of the grid of lead angles are divided.
    pub fineness: usize,
}

/// Sample points of the finished hub with their normals, by strips.
type FloorPoints = [[(Point, Vector); ALONG]; STRIPS];

impl CandidateMaker<'_> {
    /// The stage at `s_hub`; `None` where the cutter does not fit at all.
    pub fn stage_at(&self, s_hub: f64) -> Option<CandidateStage> {
        let frame = self.axis_frame(s_hub)?;
        let floor = self.floor_points(&frame.conventional, &frame.frame)?;
        let usual = self.stage_on(frame, floor);
        if self.is_open(&usual) {
            return Some(usual);
        }
        let grid = LeadGrid::narrow(frame.conventional_lead_rad);
        let narrow = self.stage_on(AxisFrame { grid, ..frame }, floor);
        Some(if self.is_open(&narrow) { narrow } else { usual })
    }

    /// Whether some candidate of a stage clears the blades; they are checked by cost, the cheapest first, as
    /// searches do.
    fn is_open(&self, stage: &CandidateStage) -> bool {
        let mut asked: Vec<(f64, CandidateIndex)> = stage
            .indices(1)
            .filter_map(|index| Some((stage.candidate(index)?.cost(0.0, self.scale), index)))
            .collect();
        asked.sort_by(|a, b| a.0.total_cmp(&b.0));
        asked.into_iter().any(|(_, index)| self.cleared(stage, index).is_some())
    }

    /// The stage with the grid of `frame`.
    fn stage_on(&self, frame: AxisFrame, floor: FloorPoints) -> CandidateStage {
        let by_lead: Vec<_> =
            (0..=LEAD_STEPS * self.fineness).map(|j| self.lead_candidates(j, &frame, &floor)).collect();
        let answers = by_lead.iter().map(|_| Default::default()).collect();
        CandidateStage { by_lead, answers, frame, floor }
    }

    /// Adds lead angles half way between those of `stage`, which has half the fineness of this maker.
    pub fn refine(&self, stage: &mut CandidateStage) {
        let CandidateStage { by_lead, answers, frame, floor } = stage;
        let count = LEAD_STEPS * self.fineness + 1;
        let coarse = std::mem::replace(by_lead, Vec::with_capacity(count));
        let known = std::mem::replace(answers, Vec::with_capacity(count));
        for (j, (candidates, answered)) in coarse.into_iter().zip(known).enumerate() {
            if j > 0 {
                by_lead.push(self.lead_candidates(2 * j - 1, frame, floor));
                answers.push(Default::default());
            }
            by_lead.push(candidates);
            answers.push(answered);
        }
    }

    /// The candidates of lead angle `j` of the grid.
    fn lead_candidates(&self, j: usize, at: &AxisFrame, floor: &FloorPoints) -> LeadCandidates {
        let AxisFrame { conventional, frame, zero_lead, reference, grid, .. } = at;
        let lead_rad = grid.lead_rad(j, self.fineness);
        let place = (conventional.s_hub, frame, zero_lead);
        let axes = self.axes(zero_lead.s_shroud_at_lead(lead_rad), place, ZERO_TILT_SHARES);
        let mut candidates = axes.map(|ends| {
            let candidate = self.lowered(ends?, floor, reference)?;
            let station = Station { s_shroud_conventional: conventional.s_shroud, ..candidate.station };
            Some(RowCandidate { station, ..candidate })
        });
        let cost = |c: &Option<RowCandidate>| c.map_or(f64::INFINITY, |c| c.cost(0.0, self.scale));
        candidates.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        candidates
    }

    /// Whether the grid of lead angles is too coarse for the cutter at one of the `s` of a row.
    pub fn is_coarse(&self, s: &[f64]) -> bool {
        let tool = self.maker.tool;
        let step = (LEAD_STEP_DEG / self.fineness as f64).to_radians();
        let most = COARSE_SHARE * (tool.radius() - tool.core_radius());
        let depth =
            |ends: &AxisEnds| (self.maker.lane.shroud_point(ends) - self.maker.lane.hub_point(ends)).norm();
        s.iter().filter_map(|&s| self.isoparametric(s)).any(|ends| step * depth(&ends) > most)
    }

    /// Stations at `s_hub` with lead angles `leads_rad` (shifted as the grid), each with the tilt angles
    /// given by `shares` (1 for zero tilt). They are not checked against the blades.
    pub fn axis_fan<const N: usize>(
        &self,
        s_hub: f64,
        leads_rad: impl Iterator<Item = f64>,
        shares: &[f64; N],
    ) -> Vec<Station> {
        let Some(AxisFrame { conventional, frame, zero_lead, reference, .. }) = self.axis_frame(s_hub) else {
            return Vec::new();
        };
        leads_rad
            .flat_map(|lead_rad| {
                self.axes(zero_lead.s_shroud_at_lead(lead_rad), (s_hub, &frame, &zero_lead), *shares)
            })
            .flatten()
            .filter_map(|ends| self.station_within_limits(ends, &reference))
            .map(|station| Station { s_shroud_conventional: conventional.s_shroud, ..station })
            .collect()
    }

    /// Whether the axis of a station is within the machine's limits and its cutter clears the blades.
    pub fn is_allowed(&self, station: &Station) -> bool {
        if self.machine.excess_tilt_rad(self.maker.part, &station.axis) > 0.0 {
            return false;
        }
        let slack = if is_wall(self.maker.lambda) { DRAFT_SLACK } else { 0.0 };
        self.finished.clears(&self.maker.cutter(station), self.blade_allowance - slack)
    }

    /// Whether an axis at one of every `stride` lead angles of `stage`, beyond the machine's limits but clear
    /// of the blades, would cost less than `cost`, mm.
    pub fn machine_forbids_below(&self, cost: f64, stage: &CandidateStage, stride: usize) -> bool {
        if self.machine.max_axis_tilt_rad >= PI {
            return false;
        }
        let AxisFrame { conventional, frame, zero_lead, reference, grid, .. } = &stage.frame;
        let forbidden = |ends: &AxisEnds| {
            let (_, axis) = self.maker.lane.line(ends);
            axis.angle(reference) <= self.max_tilt_rad
                && self.machine.excess_tilt_rad(self.maker.part, &axis) > 0.0
        };
        (0..stage.lead_count())
            .step_by(stride)
            .flat_map(|j| {
                let lead_rad = grid.lead_rad(j, self.fineness);
                let place = (conventional.s_hub, frame, zero_lead);
                self.axes(zero_lead.s_shroud_at_lead(lead_rad), place, ZERO_TILT_SHARES)
            })
            .flatten()
            .filter(forbidden)
            .map(|ends| self.candidate(self.maker.lower_to_hub(ends), &stage.floor))
            .any(|candidate| {
                candidate.cost(0.0, self.scale) < cost
                    && self.finished.clears(&self.maker.cutter(&candidate.station), self.blade_allowance)
            })
    }

    /// Whether the cutter of a station is longer than its depth in the blank, and shank and holder are clear.
    pub fn is_long_enough(&self, station: &Station) -> bool {
        self.is_longer_than_deep(station)
            && self.assembly.as_ref().is_none_or(|rule| rule.obstacle((station.tip, station.axis)).is_none())
    }

    fn is_longer_than_deep(&self, station: &Station) -> bool {
        let tool = self.maker.tool;
        let wide = WIDER_CUTTER * tool.radius();
        let column = PlungeColumn::new(self.maker.cutter(station), wide, self.top);
        match self.opened {
            Some((opening, blank)) => !cuts_deeper_than(&column, tool.overhang, opening, blank),
            None => column.top <= tool.overhang,
        }
    }

    /// Why none of these stations is long enough; of those with only the holder in the way, the least
    /// overhang that would do.
    pub fn why_too_short<'s>(&self, stations: impl Iterator<Item = &'s Station>) -> DropCause {
        let Some(rule) = &self.assembly else { return DropReason::Overhang.into() };
        let mut least: Option<DropCause> = None;
        for station in stations.take(MAX_CAUSES) {
            let pose = (station.tip, station.axis);
            let obstacle = match self.is_longer_than_deep(station) {
                true => rule.obstacle(pose),
                false => Some(DropReason::Overhang),
            };
            // Overhangs are whole numbers: another one counts if it is less by 1 mm.
            let limit = least.and_then(|least| least.stick_out).map_or(f64::INFINITY, |known| known - 1.0);
            let cause = rule.cause(obstacle.unwrap_or(DropReason::Overhang), pose, limit);
            if least.is_none() || cause.stick_out.is_some() {
                least = Some(cause);
            }
        }
        least.unwrap_or(DropReason::Overhang.into())
    }

    fn lowered(&self, ends: AxisEnds, floor: &FloorPoints, reference: &Vector) -> Option<RowCandidate> {
        Some(self.candidate(self.station_within_limits(ends, reference)?, floor))
    }

    /// The station of an axis, if it is within the machine's limits and inclined by at most `max_tilt` from
    /// `reference`.
    pub(super) fn station_within_limits(&self, ends: AxisEnds, reference: &Vector) -> Option<Station> {
        let (_, axis) = self.maker.lane.line(&ends);
        let reached = axis.angle(reference) <= self.max_tilt_rad
            && self.machine.excess_tilt_rad(self.maker.part, &axis) <= 0.0;
        reached.then(|| self.maker.lower_to_hub(ends))
    }

    fn candidate(&self, station: Station, floor: &FloorPoints) -> RowCandidate {
        let cutter = self.maker.cutter(&station);
        let height = (self.maker.lane.shroud_point(&station.ends) - cutter.tip).norm();
        RowCandidate {
            station,
            layer: self.layer(&cutter, height, floor),
            uncut: (height - self.hub_allowance).max(0.0),
        }
    }

    /// Candidate `index` of `place`, refitted if that is needed to clear the blades; `None` where that is
    /// impossible.
    pub fn cleared(&self, place: &CandidateStage, index: CandidateIndex) -> Option<RowCandidate> {
        let candidate = place.candidate(index)?;
        let (lead, tilt) = index;
        match place.answers[lead][tilt].cleared.get_or_init(|| self.clearing(candidate, place)) {
            Cleared::Blocked => None,
            Cleared::AsItIs => Some(*candidate),
            Cleared::Refitted(refitted) => Some(**refitted),
        }
    }

    fn clearing(&self, candidate: &RowCandidate, place: &CandidateStage) -> Cleared {
        if self.is_allowed(&candidate.station) {
            return Cleared::AsItIs;
        }
        // Between two branches of fits the table error exceeds that of a draft.
        let refitted = self.maker.exact(&candidate.station);
        let turned =
            refitted.filter(|station| station.ends != candidate.station.ends && self.is_allowed(station));
        turned.map_or(Cleared::Blocked, |station| {
            Cleared::Refitted(Box::new(self.candidate(station, &place.floor)))
        })
    }

    /// As [`Self::is_long_enough`], for a candidate of `place` as [`Self::cleared`] has it.
    pub fn is_cleared_long_enough(&self, place: &CandidateStage, index: CandidateIndex) -> bool {
        let (lead, tilt) = index;
        *place.answers[lead][tilt].is_long_enough.get_or_init(|| {
            self.cleared(place, index).is_some_and(|cleared| self.is_long_enough(&cleared.station))
        })
    }

    /// As [`Self::column`], for candidate `index` of `place` as [`Self::cleared`] has it.
    pub fn cleared_column(
        &self,
        place: &CandidateStage,
        (lead, tilt): CandidateIndex,
        cleared: &RowCandidate,
    ) -> PlungeColumn {
        *place.answers[lead][tilt].column.get_or_init(|| self.column(&cleared.station))
    }

    /// The column of a station for the contact search, with a slightly widened core.
    pub fn column(&self, station: &Station) -> PlungeColumn {
        let core_radius = WIDER_CORE * self.maker.tool.core_radius() + DRAFT_SLACK;
        PlungeColumn::new(self.maker.cutter(station), core_radius, self.top)
    }

    /// Sample points of the floor that the row has to clear around a position.
    fn floor_points(&self, ends: &AxisEnds, frame: &RowFrame) -> Option<FloorPoints> {
        let hub = &self.maker.part.hub;
        let [from, to] = (self.floor)(ends.s_hub)?;
        let reach = REACH_ALONG_RADII * self.maker.tool.radius() / frame.path_by_s.0;
        let along: [(f64, Meridional, Meridional); ALONG] = std::array::from_fn(|k| {
            let ds = reach * (2.0 * k as f64 / (ALONG - 1) as f64 - 1.0);
            let here = hub.at(ends.s_hub + ds);
            (ends.theta_hub + frame.path_by_s.1 * ds, here.point, here.normal)
        });
        Some(std::array::from_fn(|i| {
            let turn = from + (to - from) * (i as f64 + 0.5) / STRIPS as f64;
            along.map(|(theta, p, n)| (p.at_angle(theta + turn), n.direction_at_angle(theta + turn)))
        }))
    }

    /// Layer left per strip: minimum height of the cutter above the hub while it moves along the row, minus
    /// the allowance. Floor that the cutter never covers keeps stock up to the height `uncut`.
    fn layer(&self, cutter: &CutterSolid, uncut: f64, floor: &FloorPoints) -> [f64; STRIPS] {
        std::array::from_fn(|i| {
            let lowest = floor[i]
                .iter()
                .filter_map(|(p, n)| cutter.column_interval(cutter.radius, p, n))
                .filter(|(_, high)| *high > 0.0)
                .fold(uncut, |lowest, (low, _)| lowest.min(low));
            (lowest - self.hub_allowance).max(0.0)
        })
    }
}
