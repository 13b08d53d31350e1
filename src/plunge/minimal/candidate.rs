//! What one position of a row may look like: an axis for each feed tilt of a grid, as upright across the row as
//! walls and neighbouring rows let it be, lowered onto the hub.

use crate::geometry::{CutterSolid, Meridional, Point, Vector, wrap_angle};
use crate::part::Machine;
use crate::plunge::clearance::FinishedPart;
use crate::plunge::contact::{BlankTop, Column};
use crate::plunge::lane::{AxisEnds, is_wall};
use crate::plunge::row::{RowMaker, Station};

/// Feed tilts looked at: from, and steps to the last one, degrees. Positive leans towards the uncut side. They are moved
/// where the conventional axis leans so far that its largest tilt back leaves less than half of them.
const TILT_FROM_DEG: f64 = -12.0;
/// See [`TILT_FROM_DEG`].
const TILT_STEP_DEG: f64 = 2.0;
/// See [`TILT_FROM_DEG`].
const TILT_STEPS: usize = 19;
/// The middle between the first and the last, degrees.
const MIDDLE_TILT_DEG: f64 = TILT_FROM_DEG + 0.5 * TILT_STEP_DEG * TILT_STEPS as f64;

/// Tilts are too coarse when from one to the next the axis moves on the shroud by more than this share of the ring that
/// the edges sweep: the next core then meets what the last plunge left high above the hub.
const COARSE_SHARE: f64 = 0.4;
/// Drafts beside a wall are a few µm off it; the exact axis is met once a path is chosen.
const DRAFT_SLACK: f64 = 5e-3;
/// The search looks at a core so much wider, that between its few lines nothing of the real one is missed.
const WIDER_CORE: f64 = 1.012;
/// Strips of the floor, side by side across the row, and points of each along it.
const STRIPS: usize = 9;
const ALONG: usize = 7;
/// Furthest point along the row, in radii.
const FURTHEST: f64 = 0.9;

/// One possible position, not yet looked at for blades.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Axis and depth.
    pub station: Station,
    /// Stock left above the allowance by moving this cutter on along the row, by strips of the row's floor, mm.
    layer: [f64; STRIPS],
}

impl Candidate {
    /// The greatest lift, mm, for which the candidate costs no more than `budget`; negative when it costs more as it is.
    pub fn affordable_lift(&self, budget: f64, scale: f64) -> f64 {
        // cost(l) = cost(0) + l·(1 + 2·mean(e)/scale) + l²/scale.
        let spare = budget - self.cost(0.0, scale);
        if spare < 0.0 {
            return spare;
        }
        let half = 0.5 * (scale + 2.0 * self.layer.iter().sum::<f64>() / STRIPS as f64);
        (half * half + scale * spare).sqrt() - half
    }

    /// What the candidate costs when it stops `lift` mm short: the mean of e + e²/`scale` of the layer e it
    /// leaves, mm. The square makes the 95th percentile count beside the mean.
    pub fn cost(&self, lift: f64, scale: f64) -> f64 {
        let weigh = |e: f64| e + e * e / scale;
        self.layer.iter().map(|e| weigh(e + lift)).sum::<f64>() / STRIPS as f64
    }
}

/// Ways to lean sideways at one tilt.
const LEANS: usize = 3;
/// Their shares of the way from the row's own lean to upright.
const UPRIGHT_SHARES: [f64; LEANS] = [1.0, 0.5, 0.0];

/// What one place offers.
#[derive(Clone, Debug)]
pub struct Place {
    /// For each tilt candidates, the best first. Those that limits forbid outright are missing.
    pub tilts: Vec<[Option<Candidate>; LEANS]>,
    floor: FloorPoints,
}

impl Place {
    /// What the cheapest candidate costs, if there is any.
    pub fn cheapest(&self, scale: f64) -> Option<f64> {
        self.tilts.iter().filter_map(|tilt| Some(tilt[0].as_ref()?.cost(0.0, scale))).reduce(f64::min)
    }

    /// The least angle between axes of the same tilt here and at `next`, rad; 0 when there are none.
    pub fn least_turn(&self, next: &Place) -> f64 {
        let axes = |tilt: &[Option<Candidate>; LEANS]| tilt.map(|c| c.map(|c| c.station.axis));
        let turns = self.tilts.iter().zip(&next.tilts).flat_map(|(here, next)| {
            let (here, next) = (axes(here).into_iter().flatten(), axes(next));
            here.flat_map(move |a| next.into_iter().flatten().map(move |b| a.angle(&b)))
        });
        turns.reduce(f64::min).unwrap_or(0.0)
    }
}

/// Makes the candidates of one row.
#[derive(Clone)]
pub struct CandidateMaker<'a> {
    pub maker: &'a RowMaker<'a>,
    pub finished: &'a FinishedPart<'a>,
    pub top: &'a BlankTop<'a>,
    pub hub_allowance: f64,
    pub blade_allowance: f64,
    pub max_tilt: f64,
    pub machine: &'a Machine,
    /// Layer whose square weighs as much as itself, mm.
    pub scale: f64,
    /// What the row has to clear: from half way to the row or wall before it to half way to the next, as angles about Z
    /// from M. Depends on s.
    pub floor: &'a (dyn Fn(f64) -> Option<[f64; 2]> + Sync),
    /// How far W may leave the row's place on the shroud sideways, mm: further, and a ridge would stay.
    pub sideways: f64,
    /// Into how many parts the steps from tilt to tilt are divided.
    pub fineness: usize,
}

/// The directions that count at a place of a row.
#[derive(Clone, Copy, Debug)]
struct Frame {
    /// Hub normal.
    normal: Vector,
    /// Along the row, towards what is still uncut.
    feed: Vector,
    /// Across it.
    across: Vector,
    /// How far M goes and turns about Z per unit of s along the row, mm and rad.
    path_by_s: (f64, f64),
}

/// Points of the finished hub, strip by strip, with the normal there.
type FloorPoints = [[(Point, Vector); ALONG]; STRIPS];

/// How W answers at a place: where the axis stands upright, or nearly, and what moving W does.
#[derive(Clone, Copy, Debug)]
struct Upright {
    s_shroud: f64,
    /// Feed tilt there, by which all feed tilts are moved, rad.
    moved: f64,
    /// Tangent of the feed tilt gained per unit of s of W.
    tilt_by_s: f64,
    /// Height of W above M along the normal, mm.
    height: f64,
}

impl Upright {
    /// s of W for a feed tilt beside that, rad.
    fn tilted(&self, tilt: f64) -> f64 {
        self.s_shroud + ((tilt + self.moved).tan() - self.moved.tan()) / self.tilt_by_s
    }
}

/// What all axes at a place are made from.
struct Stand {
    conventional: AxisEnds,
    frame: Frame,
    upright: Upright,
    /// The conventional axis.
    reference: Vector,
}

/// Step of s for slopes.
const SLOPE_STEP: f64 = 2e-3;

impl CandidateMaker<'_> {
    /// What there is at `s_hub`; `None` where the cutter does not fit at all.
    pub fn at(&self, s_hub: f64) -> Option<Place> {
        let Stand { conventional, frame, upright, reference } = self.stand(s_hub)?;
        let floor = self.floor_points(&conventional, &frame)?;
        let candidates = |j: usize| {
            let tilt = (TILT_FROM_DEG + TILT_STEP_DEG * j as f64 / self.fineness as f64).to_radians();
            let axes = self.axes(upright.tilted(tilt), (s_hub, &frame, &upright), UPRIGHT_SHARES);
            let mut candidates = axes.map(|ends| {
                let candidate = self.lowered(ends?, &floor, &reference)?;
                let station = Station { s_shroud_conventional: conventional.s_shroud, ..candidate.station };
                Some(Candidate { station, ..candidate })
            });
            let cost = |c: &Option<Candidate>| c.map_or(f64::INFINITY, |c| c.cost(0.0, self.scale));
            candidates.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
            candidates
        };
        let tilts = (0..=TILT_STEPS * self.fineness).map(candidates).collect();
        Some(Place { tilts, floor })
    }

    /// Whether the steps from tilt to tilt are too coarse for the cutter somewhere on a row along the places `s`.
    pub fn is_coarse(&self, s: &[f64]) -> bool {
        let tool = self.maker.tool;
        let step = (TILT_STEP_DEG / self.fineness as f64).to_radians();
        let most = COARSE_SHARE * (tool.radius() - tool.core_radius());
        let depth =
            |ends: &AxisEnds| (self.maker.lane.shroud_point(ends) - self.maker.lane.hub_point(ends)).norm();
        s.iter().filter_map(|&s| self.isoparametric(s)).any(|ends| step * depth(&ends) > most)
    }

    /// Stations at `s_hub` with feed `tilts` (rad; moved as those of [`Self::at`]), each with all `shares` of the way to
    /// upright across the row; blades not looked at.
    pub fn fan<const N: usize>(
        &self,
        s_hub: f64,
        tilts: impl Iterator<Item = f64>,
        shares: &[f64; N],
    ) -> Vec<Station> {
        let Some(Stand { conventional, frame, upright, reference }) = self.stand(s_hub) else {
            return Vec::new();
        };
        tilts
            .flat_map(|tilt| self.axes(upright.tilted(tilt), (s_hub, &frame, &upright), *shares))
            .flatten()
            .filter_map(|ends| self.within_tilt(ends, &reference))
            .map(|station| Station { s_shroud_conventional: conventional.s_shroud, ..station })
            .collect()
    }

    /// What all axes at `s_hub` are made from.
    fn stand(&self, s_hub: f64) -> Option<Stand> {
        let conventional = self.isoparametric(s_hub)?;
        let frame = self.frame(&conventional)?;
        let (_, reference) = self.maker.lane.line(&conventional);
        let tilt = reference.dot(&frame.feed).atan2(reference.dot(&frame.normal));
        // Axes that lean back without end leave each plunge above the one before: where no other is left a row ends.
        let moved = (tilt - self.max_tilt - MIDDLE_TILT_DEG.to_radians()).max(0.0);
        let upright = self.upright(&conventional, &frame, moved)?;
        Some(Stand { conventional, frame, upright, reference })
    }

    /// Ends of the conventional axis at `s_hub`, whether or not it clears the walls.
    fn isoparametric(&self, s_hub: f64) -> Option<AxisEnds> {
        self.maker.lane.guide(self.maker.lambda, s_hub)
    }

    /// Directions at the foot of a conventional axis.
    fn frame(&self, ends: &AxisEnds) -> Option<Frame> {
        let normal = self.maker.part.hub.normal(ends.s_hub).direction_at_angle(ends.theta_hub);
        let (before, after) =
            (self.isoparametric(ends.s_hub + SLOPE_STEP)?, self.isoparametric(ends.s_hub - SLOPE_STEP)?);
        let ahead = self.maker.lane.hub_point(&after) - self.maker.lane.hub_point(&before);
        let turn = wrap_angle(before.theta_hub - after.theta_hub);
        let flat = (ahead - normal * ahead.dot(&normal)) * self.maker.inward;
        let length = flat.norm();
        if length < 1e-9 {
            return None;
        }
        let feed = flat / length;
        let path_by_s = (length / (2.0 * SLOPE_STEP), turn / (2.0 * SLOPE_STEP));
        Some(Frame { normal, feed, across: normal.cross(&feed), path_by_s })
    }

    /// Where the axis stands upright in the plane of feed and hub normal, or `moved` (rad) from there.
    fn upright(&self, from: &AxisEnds, frame: &Frame, moved: f64) -> Option<Upright> {
        let lane = self.maker.lane;
        let m = lane.hub_point(from);
        // The row's shroud curve in the neighbourhood, its sides left as they are at the start.
        let to_shroud = |s_shroud: f64| {
            let ends = lane
                .row_axis(self.maker.lambda, from.s_hub, s_shroud)
                .unwrap_or(AxisEnds { s_shroud, ..*from });
            lane.shroud_point(&ends) - m
        };
        let tilt = |w: &Vector| w.dot(&frame.feed) / w.dot(&frame.normal) - moved.tan();
        let mut s_shroud = from.s_shroud;
        let mut slope = 0.0;
        for _ in 0..4 {
            let (before, after) = (to_shroud(s_shroud - SLOPE_STEP), to_shroud(s_shroud + SLOPE_STEP));
            slope = (tilt(&after) - tilt(&before)) / (2.0 * SLOPE_STEP);
            let step = 0.5 * (tilt(&before) + tilt(&after)) / slope;
            if !step.is_finite() {
                return None;
            }
            s_shroud -= step.clamp(-0.3, 0.3);
            if !(-1.0..2.0).contains(&s_shroud) {
                return None;
            }
        }
        let height = to_shroud(s_shroud).dot(&frame.normal);
        (slope * self.maker.inward < 0.0 && height > 0.0).then_some(Upright {
            s_shroud,
            moved,
            tilt_by_s: slope,
            height,
        })
    }

    /// Axes at `s_hub` with W at `s_shroud`: the row's own one at a wall; between walls one for each of `shares` of the way
    /// from the row's own to as upright across the row as `sideways` allows.
    fn axes<const N: usize>(
        &self,
        s_shroud: f64,
        (s_hub, frame, upright): (f64, &Frame, &Upright),
        shares: [f64; N],
    ) -> [Option<AxisEnds>; N] {
        let maker = self.maker;
        let mut only = [None; N];
        let Some(ends) = maker.lane.row_axis(maker.lambda, s_hub, s_shroud) else { return only };
        only[0] = Some(ends);
        if is_wall(maker.lambda) || self.sideways <= 0.0 {
            return only;
        }
        let w = maker.lane.shroud_point(&ends);
        let lean = (w - maker.lane.hub_point(&ends)).dot(&frame.across);
        let most = -lean.clamp(-self.sideways, self.sideways);
        // Turning W about Z tilts the axis along the row as well: s of W makes up for it.
        let turn = Vector::new(-w.y, w.x, 0.0);
        let by_s = upright.tilt_by_s * upright.height;
        let gain = turn.dot(&frame.across);
        if gain.abs() < 0.2 * turn.norm() {
            return only;
        }
        shares.map(|share| {
            let angle = share * most / gain;
            let s_shroud = s_shroud - angle * turn.dot(&frame.feed) / by_s;
            let ends = maker.lane.row_axis(maker.lambda, s_hub, s_shroud)?;
            Some(AxisEnds { theta_shroud: ends.theta_shroud + angle, ..ends })
        })
    }

    /// Whether the machine reaches the axis of a station and its cutter keeps clear of the blades.
    pub fn allowed(&self, station: &Station) -> bool {
        if self.machine.beyond(self.maker.part, &station.axis) > 0.0 {
            return false;
        }
        let slack = if is_wall(self.maker.lambda) { DRAFT_SLACK } else { 0.0 };
        self.finished.clears(&self.maker.cutter(station), self.blade_allowance - slack)
    }

    fn lowered(&self, ends: AxisEnds, floor: &FloorPoints, reference: &Vector) -> Option<Candidate> {
        Some(self.candidate(self.within_tilt(ends, reference)?, floor))
    }

    /// The station of an axis that the machine reaches, no further than the greatest tilt from `reference`.
    fn within_tilt(&self, ends: AxisEnds, reference: &Vector) -> Option<Station> {
        let (_, axis) = self.maker.lane.line(&ends);
        let reached =
            axis.angle(reference) <= self.max_tilt && self.machine.beyond(self.maker.part, &axis) <= 0.0;
        reached.then(|| self.maker.lowered(ends))
    }

    fn candidate(&self, station: Station, floor: &FloorPoints) -> Candidate {
        Candidate { station, layer: self.layer(&self.maker.cutter(&station), &station.ends, floor) }
    }

    /// A candidate of `place`, made to clear the blades; `None` where it cannot.
    pub fn cleared(&self, candidate: &Candidate, place: &Place) -> Option<Candidate> {
        if self.allowed(&candidate.station) {
            return Some(*candidate);
        }
        // Between two branches of fits the table is further off than a draft may be.
        let station = self.maker.exact(&candidate.station)?;
        (station.ends != candidate.station.ends && self.allowed(&station))
            .then(|| self.candidate(station, &place.floor))
    }

    /// The column of a station as contact sees it, its core a little wider than it is.
    pub fn column(&self, station: &Station) -> Column {
        let core_radius = WIDER_CORE * self.maker.tool.core_radius() + DRAFT_SLACK;
        Column::new(self.maker.cutter(station), core_radius, self.top)
    }

    /// The floor that the row has to clear around a place.
    fn floor_points(&self, ends: &AxisEnds, frame: &Frame) -> Option<FloorPoints> {
        let hub = &self.maker.part.hub;
        let [from, to] = (self.floor)(ends.s_hub)?;
        let reach = FURTHEST * self.maker.tool.radius() / frame.path_by_s.0;
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

    /// Layer left by strips: where the cutter comes nearest to the hub while it moves on.
    fn layer(&self, cutter: &CutterSolid, ends: &AxisEnds, floor: &FloorPoints) -> [f64; STRIPS] {
        // What the cutter never comes over stands as high as the channel.
        let uncut = (self.maker.lane.shroud_point(ends) - cutter.tip).norm();
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
