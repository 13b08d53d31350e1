//! Fixed axes for the inner passes of a region: as few runs of stations as possible, each with one axis,
//! constant in the frame of the part, that is free of collision.
//!
//! A station is a set of contacts of the tool on a layer, side by side across the region. Axes that suit all
//! contacts of a station are searched on a grid of directions. Greedy extension: a run continues while one of
//! its axes suits the next station as well, which minimises the number of runs for that grid. Where the grid
//! ends a run, directions between its nodes are tried. The search uses the fast approximate distances of
//! `scene` and `distance_table`; the axis of each run is then checked against the true surfaces.

mod directions;
mod distance_table;
mod overhang;
mod scene;
mod search;

use crate::cutting::assembly::{ASSEMBLY_TOLERANCE, AssemblySurroundings};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::{Circle, Point, Vector};
use crate::part::{ENDLESS, FinishedPart, Workpiece};
use crate::setup::{AssemblyPart, AssemblySegment, ClearanceSetup, Tool};
use distance_table::DistanceTable;
use scene::{BladePoints, Cone, MinDistances, NearPoints, ToolShape};

/// Missing clearance up to which an axis of the grid is a seed of that search, mm.
const SEED_SPARE: f64 = 1.5;
/// Maximum angle between a fixed axis and the normal of the layer, rad.
pub const MAX_TILT: f64 = 65.0 * std::f64::consts::PI / 180.0;
/// Tolerance of the final check of the distance from the hub, mm.
const HUB_TOLERANCE: f64 = 1e-4;
/// Error bound of the table of distances from the hub, mm.
const HUB_SLACK: f64 = 0.05;
/// Number of heights along the cutter at which its distance from the hub is evaluated.
const HUB_HEIGHTS: usize = 4;
/// Number of points on the holder's rim at which its distance from the blank is evaluated.
const RIM_POINTS: usize = 8;

/// Contact of a tool with a layer.
#[derive(Clone, Copy, Debug)]
pub struct LayerContact {
    /// Point of the layer, in the frame of the part.
    pub point: Point,
    /// Unit normal of the layer there, out of the stock.
    pub normal: Vector,
}

/// Limits of the axes.
#[derive(Clone, Copy, Debug)]
pub struct FixedAxisLimits {
    /// Stock that stays on the hub, mm.
    pub hub_allowance: f64,
    /// Stock that stays on the blades, mm.
    pub blade_allowance: f64,
    /// Height above a contact up to which stock may remain beside it, mm: the depth of the current layer. The
    /// layers above are cut before.
    pub stock_height: f64,
    /// Maximum angle between an axis and the normal of the layer, rad.
    pub max_tilt_rad: f64,
    /// Clearances of a given shank and holder beyond the allowances, mm.
    pub clearances: ClearanceSetup,
}

/// Stations `from` to `to` with one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedRun {
    /// First station.
    pub from: usize,
    /// Last station.
    pub to: usize,
    /// Unit axis, towards the holder, in the frame of the part.
    pub axis: Vector,
    /// Minimum distance of the cutter from the finished blades over the run, mm.
    pub clearance: f64,
}

/// Why an axis cannot be used at a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisObstacle {
    /// A blade is too near to the cutter.
    Blade,
    /// The hub is too near to the cutter.
    Hub,
    /// The shank meets a blade or the hub.
    Shank,
    /// The shank meets uncut stock.
    ShankInStock,
    /// The holder meets a blade or the hub.
    Holder,
    /// The holder meets uncut stock.
    Stock,
    /// The axis would tilt too far.
    Tilt,
    /// Every contact of the station has an axis, but they have none in common.
    NoCommonAxis,
}

impl AxisObstacle {
    /// Whether a longer overhang of `tool` may free the axis: it lifts the holder, and a shank whose lower
    /// end is not given by the flutes.
    pub fn is_freed_by_overhang(self, tool: &Tool) -> bool {
        match self {
            Self::Holder | Self::Stock => true,
            Self::Shank | Self::ShankInStock => tool.assembly.flute_length.is_none(),
            _ => false,
        }
    }
}

/// Contacts of a station without an axis. They belong to no run.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreachable {
    /// The station.
    pub station: usize,
    /// Indices of the contacts; all of them for [`AxisObstacle::NoCommonAxis`].
    pub contacts: Vec<usize>,
    /// The obstacle of the axis that comes nearest to being free.
    pub why: AxisObstacle,
}

/// Fixed axes of a region.
#[derive(Clone, Debug, Default)]
pub struct FixedAxes {
    /// The runs, in order. A run may span stations or contacts that are listed as unreachable.
    pub runs: Vec<FixedRun>,
    /// Contacts without an axis.
    pub unreachable: Vec<Unreachable>,
}

/// Searches fixed axes of one tool in one channel.
#[derive(Debug)]
pub struct FixedAxisSearch<'a> {
    tool: &'a Tool,
    limits: FixedAxisLimits,
    finished: &'a FinishedPart,
    blades: BladePoints,
    hub: DistanceTable,
    blank: DistanceTable,
    shape: ToolShape,
    /// Shank and holder where they are given.
    segments: Vec<AssemblySegment>,
}

/// A contact with the points that axes of a cone may collide with there.
#[derive(Debug)]
struct PreparedContact {
    contact: LayerContact,
    /// Centre of the corner that touches the layer.
    centre: Point,
    /// Height above the hub up to which stock may remain, mm.
    top: f64,
    cone: Cone,
    near: NearPoints,
}

/// Clearance of an axis at a contact beyond what it needs, mm, and the nearest obstacle.
#[derive(Clone, Copy, Debug)]
struct SpareClearance {
    amount: f64,
    by: AxisObstacle,
}

impl<'a> FixedAxisSearch<'a> {
    /// A search for `tool` in the channel of `workpiece`.
    pub fn new(workpiece: &'a Workpiece, tool: &'a Tool, limits: &FixedAxisLimits) -> Self {
        let Workpiece { part, channel, blank, finished } = workpiece;
        let reach = tool.radius() + limits.blade_allowance;
        let margin = tool.overhang + 2.0 * tool.holder_diameter();
        Self {
            tool,
            limits: *limits,
            finished,
            blades: BladePoints::new(&channel.sides, reach.max(1e-3)),
            hub: DistanceTable::of_hub(part, margin),
            blank: DistanceTable::of_blank(part, blank, margin),
            shape: ToolShape::from_tool(tool, &limits.clearances),
            segments: tool.assembly.segments(tool.overhang),
        }
    }

    /// Tip of the tool with `axis` at `contact`: in contact, and lifted along the axis where the bottom would
    /// cut into `layer` (see [`Self::runs`]).
    pub fn tip(&self, contact: &LayerContact, axis: &Vector, layer: &DepthSurface) -> Point {
        let tip = self.tool.tip_at_contact(&contact.point, &contact.normal, axis);
        if self.tool.radius() - self.tool.corner_radius < 1e-9 {
            return tip;
        }
        match layer.tip(self.tool, &tip, axis) {
            Some(lifted) if (lifted - tip).dot(axis) > 0.0 => lifted,
            _ => tip,
        }
    }

    /// Prepares a contact for axes of `cone`; `None` for all axes it may have.
    fn prepare_contact(&self, contact: &LayerContact, cone: Option<Cone>) -> PreparedContact {
        let cone = cone.unwrap_or(Cone { axis: contact.normal, angle: self.limits.max_tilt_rad });
        let centre = contact.point + contact.normal * self.tool.corner_radius;
        let margin = self.limits.blade_allowance + self.blades.slack + SEED_SPARE;
        let near = self.blades.near(&centre, &cone, &self.shape, margin);
        PreparedContact { contact: *contact, centre, top: self.top(&centre), cone, near }
    }

    /// Spare clearance of `axis` at `place` by the fast distances, mm, but hardly more than `most`. Stops
    /// early below `enough`: the result is then only an upper bound.
    fn spare(&self, place: &PreparedContact, axis: &Vector, (enough, most): (f64, f64)) -> SpareClearance {
        let along = place.contact.normal.dot(axis);
        let tilt = along.clamp(-1.0, 1.0).acos();
        if tilt > self.limits.max_tilt_rad || axis.angle(&place.cone.axis) > place.cone.angle + 1e-9 {
            return SpareClearance { amount: f64::NEG_INFINITY, by: AxisObstacle::Tilt };
        }
        let mut spare = SpareClearance { amount: f64::INFINITY, by: AxisObstacle::Tilt };
        let mut bound = |amount: f64, by: AxisObstacle| {
            if amount < spare.amount {
                spare = SpareClearance { amount, by };
            }
            spare.amount < enough
        };
        let rim = self.tool.radius() - self.tool.corner_radius;
        let across = (place.contact.normal - axis * along).try_normalize(1e-9).unwrap_or_else(Vector::zeros);
        let offset = across * rim;
        // The tables of hub and stock come first: the points of the blades are many.
        // An inclined cutter may meet the hub again further up.
        let bottom = place.centre + offset;
        let (from, to) = (2.0 * self.tool.radius(), self.tool.overhang);
        let allowance = self.tool.radius() + self.limits.hub_allowance + HUB_SLACK;
        for k in 0..=HUB_HEIGHTS {
            let up = from + (to - from).max(0.0) * k as f64 / HUB_HEIGHTS as f64;
            if bound(self.hub.at(&(bottom + axis * up)) - allowance, AxisObstacle::Hub) {
                return spare;
            }
        }
        let is_given = !self.segments.is_empty();
        for &(from, holder) in &self.shape.holder {
            let allowance = if is_given { self.limits.hub_allowance } else { 0.0 };
            for up in [0.0, 2.0 * holder] {
                let middle = bottom + axis * (from + up);
                if bound(self.hub.at(&middle) - holder - allowance - HUB_SLACK, AxisObstacle::Holder) {
                    return spare;
                }
            }
            let end = bottom + axis * from;
            if bound(self.above_stock(&end, axis, holder, place.top) - HUB_SLACK, AxisObstacle::Stock) {
                return spare;
            }
        }
        let allowance = self.limits.blade_allowance + self.blades.slack;
        let both = |spare: f64| MinDistances { cutter: spare + allowance, holder: spare + allowance };
        let most = both(most.min(spare.amount));
        let least = place.near.min_distances(&self.shape, axis, &offset, both(enough), most);
        for (least, most, by) in [
            (least.cutter, most.cutter, AxisObstacle::Blade),
            (least.holder, most.holder, AxisObstacle::Holder),
        ] {
            if least < most && least - allowance < spare.amount {
                spare = SpareClearance { amount: least - allowance, by };
            }
        }
        spare
    }

    /// Minimum height of the end of a holder of `radius` mm above stock that is up to `top` mm high above the
    /// hub and within the blank, mm; where that is surely enough, a lower bound.
    fn above_stock(&self, end: &Point, axis: &Vector, radius: f64, top: f64) -> f64 {
        let height = |p: &Point| {
            let off_blank = self.blank.at(p);
            if off_blank > 2.0 * HUB_SLACK { off_blank } else { off_blank.max(self.hub.at(p) - top) }
        };
        let middle = height(end);
        // No point of the rim is nearer than the centre by more than the radius.
        if middle > radius + 2.0 * HUB_SLACK {
            return middle - radius;
        }
        let rim = Circle::new(end, axis, radius);
        let place = |k: usize| {
            rim.point_and_derivative((std::f64::consts::TAU * k as f64 / RIM_POINTS as f64).sin_cos()).0
        };
        (0..RIM_POINTS).map(|k| height(&place(k))).fold(middle, f64::min)
    }

    /// What shank or holder meet for a tool with `axis` and its tip at `tip`: the part with its allowances,
    /// and with the clearances of those that are given, or the current layer. The layers above are cut
    /// before.
    pub fn holder_obstacle(&self, tip: Point, axis: Vector) -> Option<AxisObstacle> {
        self.part_in_the_way(tip, axis).or_else(|| {
            let centre = tip + axis * self.tool.corner_radius;
            self.piece_in_stock(&centre, &axis, self.top(&centre))
        })
    }

    /// Whether shank or holder meet stock that is up to `top` mm high above the hub, with the corner of the
    /// tool centred at `centre`.
    fn piece_in_stock(&self, centre: &Point, axis: &Vector, top: f64) -> Option<AxisObstacle> {
        let is_in_stock = |&&(from, radius): &&(f64, f64)| {
            self.above_stock(&(centre + axis * from), axis, radius, top) < HUB_SLACK
        };
        let &(from, _) = self.shape.holder.iter().find(is_in_stock)?;
        // Where the clearance below the holder begins.
        let holder = self.tool.overhang - self.tool.corner_radius - self.limits.clearances.holder;
        let is_holder = self.tool.assembly.shank.is_empty() || from >= holder - 1e-9;
        Some(if is_holder { AxisObstacle::Stock } else { AxisObstacle::ShankInStock })
    }

    /// What of the tool meets the part or stock at a `place` that has no axis, where `axis` comes nearest to
    /// being free but for `why`.
    fn nearest_obstacle(&self, place: &PreparedContact, axis: &Vector, why: AxisObstacle) -> AxisObstacle {
        let LayerContact { point, normal, .. } = &place.contact;
        let tip = self.tool.tip_at_contact(point, normal, axis);
        let found = match why {
            AxisObstacle::Holder => self.part_in_the_way(tip, *axis),
            AxisObstacle::Stock => {
                self.piece_in_stock(&(tip + axis * self.tool.corner_radius), axis, place.top)
            }
            _ => None,
        };
        found.unwrap_or(why)
    }

    /// What of shank and holder meets the finished part: of those that are given segment by segment, of the
    /// assumed holder as a cylinder beside blades.
    fn part_in_the_way(&self, tip: Point, axis: Vector) -> Option<AxisObstacle> {
        let allowances = [self.limits.hub_allowance, self.limits.blade_allowance];
        if self.tool.assembly.holder.is_empty()
            && !self.finished.clears_wheel(&self.tool.holder(tip, axis), ENDLESS, self.limits.blade_allowance)
        {
            return Some(AxisObstacle::Holder);
        }
        if self.segments.is_empty() {
            return None;
        }
        let clearances = self.limits.clearances;
        let around = AssemblySurroundings {
            finished: self.finished,
            blank: None,
            earlier: None,
            allowances,
            clearances,
        };
        let part = around.first_obstacle(self.tool, &self.segments, (tip, axis), ASSEMBLY_TOLERANCE)?;
        Some(match part {
            AssemblyPart::Shank => AxisObstacle::Shank,
            AssemblyPart::Holder => AxisObstacle::Holder,
        })
    }

    /// What the tool collides with at `tip`: a blade too near to the cutter, or what
    /// [`Self::obstacle_except_blades`] finds.
    pub fn find_obstacle(&self, tip: Point, axis: Vector) -> Option<AxisObstacle> {
        let cutter = self.tool.placed(tip, axis);
        if !self.finished.clears_wheel(&cutter, self.tool.overhang, self.limits.blade_allowance) {
            return Some(AxisObstacle::Blade);
        }
        self.obstacle_except_blades(tip, axis)
    }

    /// What a tool whose cutter is clear of the blades collides with at `tip`: the hub, or what its holder
    /// meets.
    pub fn obstacle_except_blades(&self, tip: Point, axis: Vector) -> Option<AxisObstacle> {
        let limit = self.limits.hub_allowance - HUB_TOLERANCE;
        let near_hub = |near: bool| near && self.finished.hub_clearance(&self.tool.placed(tip, axis)) < limit;
        if near_hub(self.is_near_hub(tip, axis)) {
            return Some(AxisObstacle::Hub);
        }
        self.holder_obstacle(tip, axis)
    }

    /// Whether the hub may be nearer to the cutter than its allowance, by the fast distances along its axis.
    fn is_near_hub(&self, tip: Point, axis: Vector) -> bool {
        let (corner, radius) = (self.tool.corner_radius, self.tool.radius());
        let reach = radius + self.limits.hub_allowance + 2.0 * HUB_SLACK;
        let step = 2.0 * radius;
        let heights = (self.tool.overhang / step).ceil().clamp(1.0, 12.0) as usize;
        (0..=heights).any(|k| {
            let up = corner + (self.tool.overhang - corner).max(0.0) * k as f64 / heights as f64;
            self.hub.at(&(tip + axis * up)) < reach
        })
    }

    /// Height above the hub up to which stock may remain beside a tool whose corner is centred at `centre`,
    /// mm.
    fn top(&self, centre: &Point) -> f64 {
        self.hub.at(centre) - self.tool.corner_radius + self.limits.stock_height
    }

    /// Checks the tool with `axis` at `contact` against the true surfaces; returns the minimum distance from
    /// a blade, mm, but at most `least`.
    ///
    /// # Errors
    /// The obstacle, if the tool is not free.
    fn check_exactly(
        &self,
        contact: &LayerContact,
        axis: &Vector,
        layer: &DepthSurface,
        least: f64,
    ) -> Result<f64, AxisObstacle> {
        let tip = self.tip(contact, axis, layer);
        let cutter = self.tool.placed(tip, *axis);
        let nearest = self.finished.wheel_clearance_below(&cutter, self.tool.overhang, least);
        if nearest < self.limits.blade_allowance {
            return Err(AxisObstacle::Blade);
        }
        if self.finished.hub_clearance(&cutter) < self.limits.hub_allowance - HUB_TOLERANCE {
            return Err(AxisObstacle::Hub);
        }
        self.holder_obstacle(tip, *axis).map_or(Ok(nearest), Err)
    }
}
