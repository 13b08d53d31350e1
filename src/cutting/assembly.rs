//! Shank and holder of a tool against the finished part and the blank.
//!
//! Each cylinder or cone is measured on its own: against the blades of the whole wheel by the search of
//! [`SideProbe`], against the hub along circles of its surface.

use super::contact::{BlankTop, Earlier, PlungeColumn, core_contact_by};
use super::retract::bottom_clearance;
use crate::geometry::{
    Circle, CutterSolid, Frustum, Meridional, Point, Vector, distance_rate, norm2, rotate_vector_z, rotate_z,
    search,
};
use crate::part::{Blank, FinishedPart, SideProbe};
use crate::setup::{AssemblyPart, AssemblySegment, ClearanceSetup, Setup, Tool};

/// Depth in stock that is rounding, mm.
pub const STOCK_TOLERANCE: f64 = 0.01;
/// Clearance that may be missing by rounding, mm.
pub const ASSEMBLY_TOLERANCE: f64 = 1e-3;
/// Shares of the length of a segment at which circles are compared with the hub.
const CIRCLES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Tolerance of the search between them.
const CIRCLE_STEP: f64 = 1e-3;
/// Maximum number of points of an axis in the quick test, and their minimum distance, mm.
const MAX_AXIS_STEPS: usize = 24;
const MIN_AXIS_STEP: f64 = 0.5;
/// Maximum number of halvings of a cone against stock, and the difference of the radii of its ends below
/// which it counts as a cylinder of the larger one, mm.
const MAX_HALVINGS: u32 = 8;
const CYLINDER_STEP: f64 = 0.02;
/// Maximum number of slices of a piece whose distance from the blank is measured, and how much nearer it may
/// be between them, mm.
const MAX_SLICES: usize = 200;
const SLICE_TOLERANCE: f64 = 2e-3;
/// Least distance of a slice from the ends of the piece that it divides, as a share of that.
const MIN_INSET: f64 = 0.02;

/// Least distance of shank or holder, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartClearance {
    /// Signed distance to the finished part; infinite beyond the cap of the query.
    pub distance: f64,
    /// Clearance that is missing; negative where there is more than required.
    pub missing: f64,
}

impl PartClearance {
    /// Nothing near.
    pub const FAR: Self = Self { distance: f64::INFINITY, missing: f64::NEG_INFINITY };

    /// The lesser of each.
    pub fn worst_of(self, other: Self) -> Self {
        Self { distance: self.distance.min(other.distance), missing: self.missing.max(other.missing) }
    }

    /// Whether clearance is missing by more than rounding.
    pub fn collides(&self) -> bool {
        self.missing > ASSEMBLY_TOLERANCE
    }
}

/// Clearances of shank and holder over a move, with the worst poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssemblyClearance {
    /// Of the shank.
    pub shank: PartClearance,
    /// Of the holder.
    pub holder: PartClearance,
    /// Tip and axis where the holder misses most.
    pub worst: Option<(Point, Vector)>,
}

impl AssemblyClearance {
    /// Nothing near.
    pub const FAR: Self = Self { shank: PartClearance::FAR, holder: PartClearance::FAR, worst: None };

    /// The lesser of each.
    pub fn worst_of(self, other: Self) -> Self {
        let worst = if other.holder.missing > self.holder.missing { other.worst } else { self.worst };
        Self { shank: self.shank.worst_of(other.shank), holder: self.holder.worst_of(other.holder), worst }
    }

    /// How much further than required both are, mm; negative where one is too near.
    pub(super) fn slack(&self) -> f64 {
        -self.shank.missing.max(self.holder.missing)
    }

    /// Clearance of one of them, to change.
    pub fn of_part_mut(&mut self, part: AssemblyPart) -> &mut PartClearance {
        match part {
            AssemblyPart::Shank => &mut self.shank,
            AssemblyPart::Holder => &mut self.holder,
        }
    }

    /// Clearance of one of them.
    pub fn of_part(&self, part: AssemblyPart) -> PartClearance {
        match part {
            AssemblyPart::Shank => self.shank,
            AssemblyPart::Holder => self.holder,
        }
    }
}

/// What shank and holder must stay clear of.
#[derive(Clone, Copy, Debug)]
pub struct AssemblySurroundings<'a> {
    /// The finished part.
    pub finished: &'a FinishedPart,
    /// The blank.
    pub blank: Option<&'a Blank>,
    /// The plunges before the pose; without them all of the blank counts as standing.
    pub earlier: Option<Earlier<'a>>,
    /// Allowances on hub and blades, mm.
    pub allowances: [f64; 2],
    /// Clearances beyond them.
    pub clearances: ClearanceSetup,
}

impl<'a> AssemblySurroundings<'a> {
    /// The finished part with the allowances and clearances of `setup`.
    pub fn new(finished: &'a FinishedPart, setup: &Setup) -> Self {
        let allowances = [setup.allowances.hub_allowance, setup.allowances.blade_allowance];
        Self { finished, blank: None, earlier: None, allowances, clearances: setup.clearances }
    }

    /// As these, with the whole blank standing.
    pub fn with_blank(self, blank: &'a Blank) -> Self {
        Self { blank: Some(blank), ..self }
    }

    /// As these, with what `earlier` plunges left of the blank.
    pub fn after<'e>(&self, earlier: Earlier<'e>) -> AssemblySurroundings<'e>
    where
        'a: 'e,
    {
        AssemblySurroundings { earlier: Some(earlier), ..*self }
    }

    /// Clearance of one segment of `tool` in a pose; distances are measured up to `cap` mm.
    fn segment(
        &self,
        segment: &AssemblySegment,
        tool: &Tool,
        pose: (Point, Vector),
        cap: f64,
    ) -> PartClearance {
        let frustum = segment.placed(&pose.0, &pose.1);
        let PartClearance { distance, mut missing } = self.clearance_from_part(&frustum, segment.part, cap);
        let widest = frustum.radii[0].max(frustum.radii[1]);
        // A shank no wider than its cutter moves where the cutter has cut.
        if let Some(blank) = self.blank.filter(|_| widest > tool.radius()) {
            let clearance = self.clearances.of_part(segment.part);
            let short = clearance - blank_distance(&frustum, blank, clearance);
            if short > missing && !self.was_removed(&frustum, clearance, tool, pose, blank) {
                missing = short;
            }
        }
        PartClearance { distance, missing }
    }

    /// Clearance of a piece of a tool from the finished part; distances are measured up to `cap` mm.
    fn clearance_from_part(&self, frustum: &Frustum, part: AssemblyPart, cap: f64) -> PartClearance {
        let cap = cap.max(self.max_required(part));
        let hub = hub_distance(self.finished, frustum, cap);
        self.clearance_of([hub, blade_distance(self.finished, frustum, cap)], part, cap)
    }

    /// The greater of the distances that a part keeps from hub and blades, mm.
    pub(super) fn max_required(&self, part: AssemblyPart) -> f64 {
        self.allowances[0].max(self.allowances[1]) + self.clearances.of_part(part)
    }

    /// Clearance with these distances from hub and blades, measured up to `cap` mm.
    pub(super) fn clearance_of(&self, [hub, blade]: [f64; 2], part: AssemblyPart, cap: f64) -> PartClearance {
        let required = self.allowances.map(|allowance| allowance + self.clearances.of_part(part));
        let distance = hub.min(blade);
        PartClearance {
            distance: if distance < cap { distance } else { f64::INFINITY },
            missing: (required[0] - hub).max(required[1] - blade),
        }
    }

    /// The first part of `tool`, from the tip up, that misses more than `tolerance` mm of its clearance in a
    /// pose in which the cutter keeps its own; faster than [`Self::at`].
    pub fn first_obstacle(
        &self,
        tool: &Tool,
        segments: &[AssemblySegment],
        pose: (Point, Vector),
        tolerance: f64,
    ) -> Option<AssemblyPart> {
        let is_in_the_way = |segment: &&AssemblySegment| self.misses(segment, tool, pose, tolerance);
        segments.iter().find(is_in_the_way).map(|segment| segment.part)
    }

    /// Whether a segment misses more than `tolerance` mm of its clearance in a pose.
    pub(super) fn misses(
        &self,
        segment: &AssemblySegment,
        tool: &Tool,
        pose: (Point, Vector),
        tolerance: f64,
    ) -> bool {
        let frustum = segment.placed(&pose.0, &pose.1);
        let clearance = self.clearances.of_part(segment.part);
        let [hub, blade] = self.allowances.map(|allowance| allowance + clearance - tolerance);
        let widest = frustum.radii[0].max(frustum.radii[1]);
        // Within the column of the cutter, which keeps the allowances of blades up to any height.
        let is_covered = widest + clearance <= tool.radius();
        if hub_distance(self.finished, &frustum, hub) < hub {
            return true;
        }
        if let Some(blank) = self.blank.filter(|_| widest > tool.radius()) {
            let wanted = clearance - tolerance;
            let from_blank = |p: &Point| blank.nearest_top(Meridional::from_point(p), &mut None).0;
            if !is_clear_along(&frustum, wanted, from_blank)
                && blank_distance(&frustum, blank, wanted) < wanted
                && !self.was_removed(&frustum, clearance, tool, pose, blank)
            {
                return true;
            }
        }
        !is_covered && blade_is_within(self.finished, &frustum, blade)
    }

    /// Whether what `frustum` comes nearer to than `clearance` of the blank was removed before, or by the
    /// cutter of its own tool.
    pub(super) fn was_removed(
        &self,
        frustum: &Frustum,
        clearance: f64,
        tool: &Tool,
        pose: (Point, Vector),
        blank: &Blank,
    ) -> bool {
        let own = tool.placed(pose.0, pose.1);
        self.earlier.is_some_and(|earlier| {
            depth_in_stock(&frustum.widened(clearance), earlier, Some(&own), blank) == 0.0
        })
    }

    /// Clearance of `segments` of `tool` with its tip and unit axis at `pose`.
    pub fn at(
        &self,
        tool: &Tool,
        segments: &[AssemblySegment],
        pose: (Point, Vector),
        cap: f64,
    ) -> AssemblyClearance {
        let mut least = AssemblyClearance::FAR;
        for segment in segments {
            let of = least.of_part_mut(segment.part);
            *of = of.worst_of(self.segment(segment, tool, pose, cap.min(of.distance)));
        }
        least.worst = Some(pose);
        least
    }

    /// Signed distance of one segment of a tool to the finished part in a pose, mm, or `cap` where it is not
    /// nearer than that.
    pub fn distance(&self, segment: &AssemblySegment, pose: (Point, Vector), cap: f64) -> f64 {
        self.frustum_distance(&segment.placed(&pose.0, &pose.1), cap)
    }

    /// As [`Self::distance`], of a piece where it is.
    pub fn frustum_distance(&self, frustum: &Frustum, cap: f64) -> f64 {
        let hub = hub_distance(self.finished, frustum, cap);
        hub.min(blade_distance(self.finished, frustum, hub.max(0.0)))
    }
}

/// Signed distance to the nearest blade of the whole wheel, mm, or `cap` where none is nearer than that.
pub fn blade_distance(finished: &FinishedPart, frustum: &Frustum, cap: f64) -> f64 {
    let mut least = cap;
    for_blades(finished, frustum, cap, |blade, turned| {
        if let Some(distance) = blade.frustum_distance_below(turned, least) {
            least = least.min(distance);
        }
        (least, false)
    });
    least
}

/// Whether a blade of the whole wheel is nearer than `limit` mm.
fn blade_is_within(finished: &FinishedPart, frustum: &Frustum, limit: f64) -> bool {
    let mut found = false;
    for_blades(finished, frustum, limit, |blade, turned| {
        found = blade.frustum_is_within(turned, limit);
        (limit, found)
    });
    found
}

/// Calls `look` with the sides of all blades of the wheel, and with `frustum` turned to where they are
/// measured, that may be nearer than `within` mm, and than the distance which it returned last, until it
/// returns `true`.
fn for_blades(
    finished: &FinishedPart,
    frustum: &Frustum,
    mut within: f64,
    mut look: impl FnMut(&SideProbe, &Frustum) -> (f64, bool),
) {
    let (centre, radius) = frustum.bounding_ball();
    for ball in finished.side_balls() {
        // Squared distances: of most balls no root is needed.
        let reach = within + radius + ball.radius;
        if reach <= 0.0 || (centre - ball.centre).norm_squared() > reach * reach {
            continue;
        }
        let turned = Frustum {
            base: rotate_z(&frustum.base, ball.to_channel_rad),
            axis: rotate_vector_z(&frustum.axis, ball.to_channel_rad),
            ..*frustum
        };
        let (distance, is_done) = look(finished.side_in(ball), &turned);
        if is_done {
            return;
        }
        within = distance;
    }
}

/// Whether every point of `frustum` is `distance` mm or more from a surface, by the distances of points of
/// its axis (`from`, which may not change faster than the point moves): a quick test that may fail where it
/// is true.
fn is_clear_along(frustum: &Frustum, distance: f64, from: impl Fn(&Point) -> f64) -> bool {
    let widest = frustum.radii[0].max(frustum.radii[1]);
    let mut up = 0.0;
    for _ in 0..MAX_AXIS_STEPS {
        // No point of the frustum is farther from the axis at its height than its radius there.
        let spare = from(&(frustum.base + frustum.axis * up)) - widest - distance;
        if spare < 0.0 {
            return false;
        }
        if up >= frustum.length {
            return true;
        }
        up = (up + spare.max(MIN_AXIS_STEP)).min(frustum.length);
        if spare < MIN_AXIS_STEP {
            return false;
        }
    }
    false
}

/// Signed distance to the finished hub, mm, or `cap` where it is not nearer than that.
pub fn hub_distance(finished: &FinishedPart, frustum: &Frustum, cap: f64) -> f64 {
    let curve = finished.hub.curve();
    // Signed distance of a point, and its foot on the hub; beyond its ends the hub has an edge, no surface.
    let distance = |p: &Point| {
        let (t, d) = curve.project(Meridional::from_point(p));
        (if t <= 0.0 || t >= curve.length() { d.abs() } else { d }, curve.point(t))
    };
    let (centre, radius) = frustum.bounding_ball();
    if distance(&centre).0 - radius > cap || is_clear_along(frustum, cap, |p| distance(p).0) {
        return cap;
    }
    let on_circle = |share: f64, radius: f64| {
        let circle =
            Circle::new(&(frustum.base + frustum.axis * (share * frustum.length)), &frustum.axis, radius);
        let at = |phi: f64| {
            let (p, turning) = circle.point_and_derivative(phi.sin_cos());
            let (d, foot) = distance(&p);
            (d, distance_rate(&p, &turning, foot) * d.signum())
        };
        search::min_over_turn::<18>(at, 0.2)
    };
    let side = |share: f64| on_circle(share, frustum.radius_at(share));
    // No point of a circle is nearer than its centre less its radius: branch and bound.
    let bound = |share: f64| {
        distance(&(frustum.base + frustum.axis * (share * frustum.length))).0 - frustum.radius_at(share)
    };
    let bounds = CIRCLES.map(bound);
    let mut order: [usize; CIRCLES.len()] = std::array::from_fn(|k| k);
    order.sort_by(|&a, &b| bounds[a].total_cmp(&bounds[b]));
    let (mut best, mut lowest) = (0, f64::INFINITY);
    for k in order {
        if bounds[k] > lowest {
            break;
        }
        let here = side(CIRCLES[k]);
        if here < lowest || here == lowest && k < best {
            (best, lowest) = (k, here);
        }
    }
    let mut least = cap.min(lowest);
    // Inside the lower end, for convex hubs.
    if bounds[0] < least {
        least = least.min(on_circle(0.0, 0.5 * frustum.radii[0]));
    }
    // Between two circles the distance may be less, by no more than half their spacing.
    if lowest - 0.25 * frustum.length < cap {
        let last = CIRCLES.len() - 1;
        let (from, to) = (CIRCLES[best.saturating_sub(1)], CIRCLES[(best + 1).min(last)]);
        // At an end it is the least if it rises from there.
        let beside = match best {
            0 => Some(CIRCLE_STEP),
            best if best == last => Some(1.0 - CIRCLE_STEP),
            _ => None,
        };
        if beside.is_none_or(|share| side(share) < lowest) {
            least = least.min(search::minimum(side, from, to, CIRCLE_STEP).1);
        }
    }
    least
}

/// The first part of `tool`, from the tip up, that is thicker than the cutter and in what the `earlier`
/// plunges left of `blank`, deeper than rounding, and how deep, mm; `cutter` is where a plunge ends.
pub fn part_in_stock(
    tool: &Tool,
    cutter: &CutterSolid,
    earlier: Earlier,
    blank: &Blank,
) -> Option<(AssemblyPart, f64)> {
    let segments = tool.assembly.segments(tool.overhang).into_iter();
    let thick = segments.filter(|segment| segment.radii[0].max(segment.radii[1]) > tool.radius());
    let mut depths = thick.map(|segment| {
        let placed = segment.placed(&cutter.tip, &cutter.axis);
        (segment.part, depth_in_stock(&placed, earlier, None, blank))
    });
    depths.find(|(_, depth)| *depth > STOCK_TOLERANCE)
}

/// Height above the lower end of a slice of `frustum` up to which it is in what the `earlier` plunges and
/// that of the `own` cutter left of `blank`, mm; 0 where it is clear.
pub fn depth_in_stock(frustum: &Frustum, earlier: Earlier, own: Option<&CutterSolid>, blank: &Blank) -> f64 {
    let top = BlankTop::new(blank);
    let own = own.map(|cutter| PlungeColumn { cutter: *cutter, core_radius: 0.0, top: 0.0 });
    // A cone is looked at as a cylinder that contains it, and in halves where that is in stock.
    let mut slices = vec![(0.0, 1.0, 0)];
    let mut deepest = 0.0f64;
    while let Some((from, to, halvings)) = slices.pop() {
        let [low, high] = [from, to].map(|share| frustum.radius_at(share));
        let radius = low.max(high);
        let tip = frustum.base + frustum.axis * (from * frustum.length);
        let solid = CutterSolid { tip, axis: frustum.axis, radius, corner_radius: 0.0 };
        // No point of the bottom is further from its centre than its radius.
        let centre = blank.clearance(Meridional::from_point(&tip), &mut None);
        if centre > radius || bottom_clearance(&solid, blank) > 0.0 {
            continue;
        }
        let column = PlungeColumn::new(solid, radius, &top);
        let depth = core_contact_by(&column, earlier.near(&column).chain(&own), blank).0;
        if depth > 0.0 && halvings < MAX_HALVINGS && (high - low).abs() > CYLINDER_STEP {
            let middle = 0.5 * (from + to);
            slices.extend([(from, middle, halvings + 1), (middle, to, halvings + 1)]);
        } else {
            deepest = deepest.max(depth);
        }
    }
    deepest
}

/// Signed distance to the top of the blank, mm; of what is further than `enough` mm that of an end or the
/// middle.
///
/// The least over slices, by Piyavskii's algorithm: no point of a slice moves faster than one of the widening
/// side, so neither does the distance of the slice. An edge of the blank may be nearest between two of them.
pub(super) fn blank_distance(frustum: &Frustum, blank: &Blank, enough: f64) -> f64 {
    let slice = |share: f64| {
        let tip = frustum.base + frustum.axis * (share * frustum.length);
        let radius = frustum.radius_at(share);
        bottom_clearance(&CutterSolid { tip, axis: frustum.axis, radius, corner_radius: 0.0 }, blank)
    };
    let rate = norm2(frustum.length, frustum.radii[1] - frustum.radii[0]);
    let [low, middle, high] = [0.0, 0.5, 1.0].map(|share| (share, slice(share)));
    let mut least = low.1.min(middle.1).min(high.1);
    let bound = |[a, b]: [(f64, f64); 2]| 0.5 * (a.1 + b.1 - (b.0 - a.0) * rate);
    let mut open = vec![[low, middle], [middle, high]];
    for _ in 0..MAX_SLICES {
        let next = (0..open.len()).min_by(|&a, &b| bound(open[a]).total_cmp(&bound(open[b])));
        let is_lower = |k: &usize| bound(open[*k]) < least.min(enough) - SLICE_TOLERANCE;
        let Some(next) = next.filter(is_lower) else { break };
        let [a, b] = open.swap_remove(next);
        // Where both bounds meet.
        let meet = 0.5 * (a.0 + b.0 + (a.1 - b.1) / rate);
        let inset = MIN_INSET * (b.0 - a.0);
        let share = meet.clamp(a.0 + inset, b.0 - inset);
        let here = (share, slice(share));
        least = least.min(here.1);
        open.extend([[a, here], [here, b]]);
    }
    least
}
