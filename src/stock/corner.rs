//! The corner between the hub and a wall that leans over it: where beside the wall a cutter begins to cut.
//!
//! At one s the hub is the same all around. So a cutter is lowered onto it once for an axis, and then turned
//! about Z, its axis with it, until it clears the wall.

use super::hub_patch::HubPatch;
use super::overhang::{BladesOverFloor, WallTable, WallTables, s_of_row};
use crate::geometry::{CutterSolid, Point, Vector, frame_about, rotate_vector_z, rotate_z, wrap_angle};
use crate::part::{FinishedPart, SideProbe, Workpiece};

/// Rings of axes about the isoparametric one that are tried; the best is refined.
const RINGS: usize = 4;
/// Largest angle of an axis from the isoparametric one, rad.
const MAX_ANGLE: f64 = 75.0 * std::f64::consts::PI / 180.0;
/// Cosine of the largest angle of an axis from the hub normal: 85°.
const MIN_COSINE: f64 = 0.087;
/// Tolerance of the angles of an axis, rad.
const TOLERANCE: f64 = 0.01;
/// Points of the rim where the bottom may touch the hub.
const RIM_POINTS: usize = 16;
/// Number of steps by which a cutter is lowered onto the hub, and by which it is turned off the wall.
const STEPS: usize = 4;
/// Rays of the floor from wall to wall, and the share of their distance to which the border is found.
const RAYS: usize = 96;
/// See [`RAYS`].
const RAY_TOLERANCE: f64 = 0.02;
/// Share of the height of the stock below which a cutter has to be to remove any.
const MIN_CUT_SHARE: f64 = 0.9985;
/// Error of a pose that was not measured, in radii.
const DRAFT_ERROR: f64 = 0.05;
/// Weight of missing clearance relative to distance from the wall.
const PENALTY: f64 = 4.0;
/// Clearance that may be missing or left, mm.
const CLEARANCE_TOLERANCE: f64 = 0.01;
/// By which the border is put nearer to the wall than the search found it, in radii: what no plan can cut has
/// to be so, and the search may miss the best pose by little.
const BORDER_RADII: f64 = 0.005;
/// Angle to the limit, and distance to an opposite wall in radii, at which a pose is limited by it.
const LIMIT_ANGLE: f64 = std::f64::consts::PI / 180.0;
/// See [`LIMIT_ANGLE`].
const LIMIT_RADII: f64 = 0.05;
/// Number of times that a pose is measured and corrected.
const MEASURES: usize = 3;

/// Radius of the cutter, allowances and limits of its axis.
pub(super) struct ReachCutter {
    /// mm.
    pub(super) radius: f64,
    /// mm.
    pub(super) hub_allowance: f64,
    /// mm.
    pub(super) blade_allowance: f64,
    /// Largest angle of its axis from the isoparametric one, rad.
    pub(super) max_tilt_rad: f64,
}

impl ReachCutter {
    /// Distance of the axis from a wall, mm.
    fn reach(&self) -> f64 {
        self.radius + self.blade_allowance
    }
}

/// The corner between hub and one wall at a row of the tables, and a cutter in it.
pub(super) struct WallCorner<'a> {
    cutter: &'a ReachCutter,
    /// Points of the wall on the blade.
    wall: &'a [Point],
    finished: &'a FinishedPart,
    foot: Point,
    /// Unit normal of the hub at the foot.
    normal: Vector,
    /// Unit meridional direction at the foot.
    tangent: Vector,
    /// Unit circumferential direction at the foot, into the passage, and its sign about Z.
    around: Vector,
    sign: f64,
    hub: HubPatch,
    rays: FloorRays<'a>,
    axes: IsoparametricAxes,
    /// Two unit vectors perpendicular to the isoparametric axis beside the wall.
    turns: (Vector, Vector),
    /// Unit direction along the hub across the wall's foot, into the passage.
    across: Vector,
}

/// A pose of the cutter beside a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct CornerPose {
    /// Tangents of the angles of the axis to the isoparametric one beside the wall, and how far along the
    /// meridional direction it is from where the point of its bottom nearest to the wall is in the row, in
    /// radii.
    at: [f64; 3],
    /// Angle from the foot at which it begins to cut, rad.
    begin: f64,
    /// That angle before it was measured on the finished part, rad.
    drafted: f64,
    /// Centre of the bottom.
    pub(super) tip: Point,
    /// Unit axis.
    pub(super) axis: Vector,
}

/// The isoparametric axes between the wall of a corner and the opposite one, turned about Z to the foot.
struct IsoparametricAxes {
    /// Of the cutter beside the wall, and beside the opposite one.
    ends: [Vector; 2],
    /// Angles of these from the foot, rad.
    places: [f64; 2],
}

impl IsoparametricAxes {
    /// The isoparametric axis with its foot `angle` from that of the wall.
    fn at(&self, angle: f64) -> Vector {
        let [from, to] = self.places;
        let share = if to > from { ((angle - from) / (to - from)).clamp(0.0, 1.0) } else { 0.5 };
        (self.ends[0] * (1.0 - share) + self.ends[1] * share).normalize()
    }
}

impl CornerPose {
    fn solid(&self, radius: f64) -> CutterSolid {
        CutterSolid { tip: self.tip, axis: self.axis, radius, corner_radius: 0.0 }
    }
}

impl<'a> WallCorner<'a> {
    /// `None` where the wall has no foot on the blade in this row, does not lean over the floor, or has no
    /// isoparametric axis beside it.
    pub(super) fn new(
        workpiece: &'a Workpiece,
        walls: &'a WallTables,
        (index, row): (usize, usize),
        over: &'a BladesOverFloor,
        cutter: &'a ReachCutter,
    ) -> Option<Self> {
        let part = &workpiece.part;
        let face = &walls.faces[index];
        let at_foot = &face.row(row)[0];
        if !at_foot.is_on_blade() || !face.leans_over(row) {
            return None;
        }
        let s = s_of_row(row);
        let foot = at_foot.point;
        let theta = foot.y.atan2(foot.x);
        let hub = HubPatch::new(part, s);
        let sign = part.pitch().signum() * face.opening_sign;
        let axis_beside = |table: &WallTable| {
            let offset = cutter.reach() * part.pitch().signum() * table.opening_sign;
            let [hub, shroud] = table.wall().ruling_offset(part, [s, s], offset)?;
            let axis = part.shroud.point(s).at_angle(shroud) - part.hub.point(s).at_angle(hub);
            Some((hub, rotate_vector_z(&axis, theta - hub).normalize()))
        };
        let turned = |to: f64| face.turn_into_passage(theta, to, part.pitch());
        let (near, own) = axis_beside(face)?;
        let far = walls.opposite(index, s).and_then(axis_beside);
        let other = far.map_or((own, turned(near)), |(far, axis)| (axis, turned(far)));
        let axes = IsoparametricAxes { ends: [own, other.0], places: [turned(near), other.1] };
        let [normal, tangent] = hub.directions(theta);
        let around = Vector::new(-theta.sin(), theta.cos(), 0.0) * sign;
        let trace = face.trace_at(row);
        let across = (around - trace * (around.dot(&trace) / trace.norm_squared().max(1e-12))).normalize();
        let rays = FloorRays::new(over, index, [face.opening_sign, sign], (foot, normal));
        let (wall, finished, turns) = (face.points(), &workpiece.finished, frame_about(&own));
        Some(Self {
            cutter,
            wall,
            finished,
            foot,
            normal,
            tangent,
            around,
            sign,
            hub,
            rays,
            axes,
            turns,
            across,
        })
    }

    /// The floor beside the foot that is inaccessible, and why.
    pub(super) fn inaccessible_strip(&self) -> InaccessibleStrip {
        // Where no pose cuts any floor of this row, it counts as accessible.
        let margin = BORDER_RADII * self.cutter.radius / self.hub.radius();
        let strip = |pose: CornerPose| InaccessibleStrip {
            angle: (pose.begin - margin).max(0.0),
            limit: self.limit_of(&pose),
        };
        self.best_pose().map_or(InaccessibleStrip::NONE, strip)
    }

    /// What keeps the cutter of the best pose from getting nearer.
    fn limit_of(&self, pose: &CornerPose) -> CornerLimit {
        let theta = pose.tip.y.atan2(pose.tip.x);
        let angle = wrap_angle(theta - self.foot.y.atan2(self.foot.x));
        let axis = rotate_vector_z(&pose.axis, -angle);
        if self.axes.at(self.sign * angle).angle(&axis) > self.cutter.max_tilt_rad - LIMIT_ANGLE {
            return CornerLimit::MaxTilt;
        }
        let around = rotate_vector_z(&self.around, angle);
        let cutter = pose.solid(self.cutter.radius);
        let near = self.cutter.blade_allowance + LIMIT_RADII * self.cutter.radius;
        let is_ahead = |blade: &SideProbe| {
            blade.nearest_below(&cutter, near).is_some_and(|nearest| {
                let off = nearest.point - pose.tip;
                let aside = off - pose.axis * off.dot(&pose.axis);
                nearest.distance < near && aside.dot(&around) > 0.0
            })
        };
        if self.finished.blades().iter().any(is_ahead) {
            CornerLimit::OppositeWall
        } else {
            CornerLimit::Cutter
        }
    }

    /// The pose that begins to cut nearest to the wall: search over axes, measured on the finished part.
    pub(super) fn best_pose(&self) -> Option<CornerPose> {
        let mut drafts: Vec<CornerPose> = Vec::with_capacity(1 + 3 * RINGS * (RINGS + 1));
        // More than the limit where the axes beside both walls differ.
        let widest = self.cutter.max_tilt_rad + self.axes.ends[0].angle(&self.axes.ends[1]);
        let step = widest.min(MAX_ANGLE) / RINGS as f64;
        for ring in 0..=RINGS {
            let (tan, count) = ((step * ring as f64).tan(), (6 * ring).max(1));
            drafts.extend((0..count).filter_map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * (k as f64 + 0.5) / count as f64).sin_cos();
                self.draft([tan * cos, tan * sin, 0.0])
            }));
        }
        drafts.sort_by(|a, b| a.begin.total_cmp(&b.begin));
        let mut best: Option<CornerPose> = None;
        let margin = DRAFT_ERROR * self.cutter.radius / self.hub.radius();
        for draft in drafts {
            if best.is_some_and(|best| draft.begin >= best.begin + margin) {
                break;
            }
            self.measure_if_nearer(draft, &mut best);
        }
        // Compass search around the best one.
        let mut here = best?;
        let mut steps = [0.5 * step, 0.5 * step, 0.5];
        while steps[0] > TOLERANCE {
            let mut moved = false;
            for (k, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
                let mut at = here.at;
                at[k] += sign * steps[k];
                let mut found = Some(here);
                if let Some(draft) = self.draft(at).filter(|draft| draft.drafted < here.drafted) {
                    self.measure_if_nearer(draft, &mut found);
                }
                if let Some(found) = found.filter(|found| found.begin < here.begin) {
                    (here, moved) = (found, true);
                }
            }
            if !moved {
                steps = steps.map(|step| 0.5 * step);
            }
        }
        Some(here)
    }

    /// Corrects `draft` by its distances from the finished part, and keeps it if it begins to cut nearer to
    /// the wall than `best`.
    fn measure_if_nearer(&self, draft: CornerPose, best: &mut Option<CornerPose>) {
        let bound = best.map_or(f64::INFINITY, |best| best.begin);
        let ReachCutter { hub_allowance, blade_allowance, radius, .. } = *self.cutter;
        let mut cutter = draft.solid(radius);
        let cap = blade_allowance + 0.3 * radius;
        let turned = draft.tip.y.atan2(draft.tip.x) - self.foot.y.atan2(self.foot.x);
        let normal = rotate_vector_z(&self.normal, turned);
        for round in 0..MEASURES {
            let over = self.finished.hub_clearance(&cutter) - hub_allowance;
            let beside = self.finished.blade_clearance_below(&cutter, cap) - blade_allowance;
            let lacking = (-over.min(beside) - CLEARANCE_TOLERANCE).max(0.0);
            if let Some(begin) = self.rays.first_cut(&cutter, bound) {
                let begin = begin + PENALTY * lacking / self.hub.radius();
                if best.is_none_or(|best| begin < best.begin) {
                    *best = Some(CornerPose { begin, tip: cutter.tip, axis: cutter.axis, ..draft });
                }
            }
            if over.abs().max(beside.abs()) < CLEARANCE_TOLERANCE || round + 1 == MEASURES {
                break;
            }
            cutter.tip -= normal * over.clamp(-radius, radius);
            let turn = -self.sign * beside / (self.gain(&draft) * self.hub.radius());
            cutter.tip = rotate_z(&cutter.tip, turn);
            cutter.axis = rotate_vector_z(&cutter.axis, turn);
        }
    }

    /// Distance from the wall that a cutter gains per distance around Z.
    fn gain(&self, draft: &CornerPose) -> f64 {
        let theta = draft.tip.y.atan2(draft.tip.x);
        let around = Vector::new(-theta.sin(), theta.cos(), 0.0);
        (1.0 - around.dot(&draft.axis).powi(2)).sqrt().max(0.3)
    }

    /// The pose `at` an axis and a place along the meridional direction, beside the points of the wall;
    /// `None` beyond the limits of the axis and where it cuts nothing of the row.
    fn draft(&self, at: [f64; 3]) -> Option<CornerPose> {
        let cutter = self.cutter;
        let axis = (self.axes.ends[0] + self.turns.0 * at[0] + self.turns.1 * at[1]).normalize();
        if axis.dot(&self.normal) < MIN_COSINE {
            return None;
        }
        // The point of the bottom that is nearest to the wall is in the row.
        let outwards = (self.across - axis * axis.dot(&self.across)).normalize();
        let tip = self.lowered(&axis, (at[2] + outwards.dot(&self.tangent)) * cutter.radius);
        let turn = self.turn_off_wall(&tip, &axis);
        if self.axes.at(turn).angle(&axis) > cutter.max_tilt_rad {
            return None;
        }
        let turn = self.sign * turn;
        let (tip, axis) = (rotate_z(&tip, turn), rotate_vector_z(&axis, turn));
        let mut pose = CornerPose { at, begin: 0.0, drafted: 0.0, tip, axis };
        pose.begin = self.rays.first_cut(&pose.solid(cutter.radius), f64::INFINITY)?;
        pose.drafted = pose.begin;
        Some(pose)
    }

    /// The centre of the bottom `shift` mm from the foot along the meridional direction, as low as the hub
    /// with its allowance lets it.
    fn lowered(&self, axis: &Vector, shift: f64) -> Point {
        let radius = self.cutter.radius;
        let (u, v) = frame_about(axis);
        let rim: [Vector; RIM_POINTS] = std::array::from_fn(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / RIM_POINTS as f64).sin_cos();
            (u * cos + v * sin) * radius
        });
        let mut height = self.cutter.hub_allowance + radius * (1.0 - axis.dot(&self.normal).powi(2)).sqrt();
        let from = self.foot + self.tangent * shift;
        for _ in 0..STEPS {
            let centre = from + self.normal * height;
            let rise = |p: Point| self.hub.rise_to(self.cutter.hub_allowance, &p, &self.normal);
            let rises = rim.iter().map(|off| centre + off).chain([centre]).filter_map(rise);
            // A disc beyond the end of the hub touches nothing.
            height = (height + rises.fold(f64::NEG_INFINITY, f64::max)).max(-radius);
        }
        from + self.normal * height
    }

    /// The angle by which a cutter at the foot has to be turned about Z to clear the points of the wall, rad;
    /// at least so far that no floor is left between it and the foot.
    fn turn_off_wall(&self, tip: &Point, axis: &Vector) -> f64 {
        let reach = self.cutter.reach();
        let along_around = self.around.dot(axis);
        let half = (1.0 - along_around * along_around).sqrt().max(1e-3);
        let outwards = (self.around - axis * along_around) / half;
        let along = axis.cross(&outwards);
        let radius = self.hub.radius();
        let least = self.cutter.radius * half / radius;
        let mut turn = least;
        for _ in 0..STEPS {
            // The frame of the cutter turned.
            let angle = self.sign * turn;
            let [x, y, h] = [&along, &outwards, axis].map(|direction| rotate_vector_z(direction, angle));
            let tip = rotate_z(tip, angle);
            let lacking = self.wall.iter().fold(f64::NEG_INFINITY, |most, point| {
                let off = point - tip;
                let aside = off.dot(&x);
                let squared = reach * reach - aside * aside;
                if squared <= 0.0 || off.dot(&h) < 0.0 {
                    most
                } else {
                    most.max(off.dot(&y) + squared.sqrt())
                }
            });
            let next = (turn + lacking / (half * radius)).max(least);
            if (next - turn).abs() * radius < CLEARANCE_TOLERANCE {
                return next;
            }
            turn = next;
        }
        turn
    }
}

/// The rays of the floor beside a wall at one s, from its foot into the passage.
struct FloorRays<'a> {
    over: &'a BladesOverFloor,
    /// Angle of the foot as in [`BladesOverFloor`], rad.
    foot: f64,
    /// ±1: the direction of the passage in these angles, and about Z.
    into: [f64; 2],
    /// Foot and normal of the ray at the foot of the wall.
    first: (Point, Vector),
    /// Angle from one ray to the next, rad.
    step: f64,
    /// Foot and normal of each ray, and the height up to which there is stock, mm.
    rays: Vec<(Point, Vector, f64)>,
}

impl<'a> FloorRays<'a> {
    fn new(over: &'a BladesOverFloor, face: usize, into: [f64; 2], first: (Point, Vector)) -> Self {
        let step = over.width.abs() / RAYS as f64;
        let mut rays = Self { over, foot: over.feet[face], into, first, step, rays: Vec::new() };
        rays.rays = (0..RAYS).map(|k| rays.at(step * k as f64)).collect();
        rays
    }

    /// The ray at an angle from the foot.
    fn at(&self, angle: f64) -> (Point, Vector, f64) {
        let [in_row, about_z] = self.into.map(|sign| sign * angle);
        let height = self.over.underside(self.foot + in_row);
        (rotate_z(&self.first.0, about_z), rotate_vector_z(&self.first.1, about_z), height)
    }

    /// Angle from the foot of the first ray less than `bound` of which `cutter` removes stock, rad.
    fn first_cut(&self, cutter: &CutterSolid, bound: f64) -> Option<f64> {
        let is_cut = |(foot, normal, height): &(Point, Vector, f64)| {
            let entry = cutter.column_interval(cutter.radius, foot, normal);
            entry.is_some_and(|(low, high)| high > 0.0 && low < MIN_CUT_SHARE * height)
        };
        let count = (bound / self.step + 2.0).min(RAYS as f64) as usize;
        let first = self.rays[..count].iter().position(is_cut)?;
        let (mut out, mut cut) = (first.saturating_sub(1) as f64 * self.step, first as f64 * self.step);
        while cut - out > RAY_TOLERANCE * self.step {
            let middle = 0.5 * (out + cut);
            if is_cut(&self.at(middle)) { cut = middle } else { out = middle }
        }
        Some(cut)
    }
}

/// What keeps a cutter from getting nearer to the foot of a wall that leans over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CornerLimit {
    /// The largest angle of its axis from the isoparametric one: with more it would get nearer.
    MaxTilt,
    /// The wall on the other side of the passage.
    OppositeWall,
    /// Only hub and wall, as its bottom is wide: a smaller cutter would get nearer.
    Cutter,
}

impl CornerLimit {
    /// Its value in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MaxTilt => "max_tilt",
            Self::OppositeWall => "opposite_wall",
            Self::Cutter => "cutter",
        }
    }

    /// What limits the cutter, for users.
    pub fn words(self) -> &'static str {
        match self {
            Self::MaxTilt => "limited by max_tilt",
            Self::OppositeWall => "limited by the opposite wall",
            Self::Cutter => "limited by the cutter's diameter",
        }
    }
}

/// Inaccessible floor beside one wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct InaccessibleStrip {
    /// Angle from the foot of the wall, rad; 0 where all is accessible.
    pub(super) angle: f64,
    /// What makes it so.
    pub(super) limit: CornerLimit,
}

impl InaccessibleStrip {
    /// No inaccessible floor.
    pub(super) const NONE: Self = Self { angle: 0.0, limit: CornerLimit::Cutter };
}
