//! Fixed orientation for the inner curves of a region (DESIGN section 6): as few runs of stations as possible, in each of
//! which one axis, constant in the frame of the part, is free of collision.
//!
//! A station has contacts of the cutter on a layer, side by side across the region. Axes that suit all contacts of a
//! station are looked for on a grid of directions; a run goes on as long as one of them suits the next station too, which
//! makes the number of runs the least for that grid. Where the grid ends a run, directions between its nodes are tried.
//! The quick distances of [`scene`] decide in the search; the axis of each run is then measured against the true surfaces.

mod scene;
mod search;

use crate::geometry::{Circle, Point, Vector};
use crate::part::{Blank, Channel, Tool};
use crate::plunge::clearance::FinishedPart;
use crate::plunge::slotting::DepthSurface;
use scene::{BladePoints, Cone, DistanceTable, Least, Near, Shape};
use search::Greedy;

/// Where a cutter touches a layer.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Point of the layer.
    pub point: Point,
    /// Unit normal of the layer there, out of the stock.
    pub normal: Vector,
}

/// What bounds the axes.
#[derive(Clone, Copy, Debug)]
pub struct FixedAxisLimits {
    /// Stock that stays on the hub, mm.
    pub hub_allowance: f64,
    /// Stock that stays on the blades, mm.
    pub blade_allowance: f64,
    /// How far above a contact stock may still stand beside it, mm: the depth of the layer in work. What is above that is
    /// cut, as layers are cut from the top down.
    pub standing: f64,
    /// Largest angle between an axis and the layer's normal, rad.
    pub max_tilt: f64,
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
    /// Least distance of the cutters of the run to the finished blades, mm.
    pub clearance: f64,
}

/// What keeps a cutter from a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// A blade is too near to the cutter.
    Blade,
    /// The hub is too near to it.
    Hub,
    /// The holder meets a blade or the hub.
    Holder,
    /// The holder meets stock that still stands.
    Stock,
    /// The axis would tilt too far.
    Tilt,
    /// Every contact of the station has an axis, but there is none for all.
    NoCommonAxis,
}

/// Contacts of a station that have no axis. They belong to no run.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreachable {
    /// The station.
    pub station: usize,
    /// Which of its contacts, all of them for [`Obstacle::NoCommonAxis`].
    pub contacts: Vec<usize>,
    /// What stands in the way of the axis that comes nearest to being free.
    pub why: Obstacle,
}

/// Axes of a region.
#[derive(Clone, Debug, Default)]
pub struct FixedAxes {
    /// The runs, in order. A run may span stations, or contacts of them, that are named as unreachable.
    pub runs: Vec<FixedRun>,
    /// What no axis reaches.
    pub unreachable: Vec<Unreachable>,
}

/// Finds fixed axes of one cutter in one channel.
#[derive(Debug)]
pub struct FixedAxisSearch<'a> {
    tool: &'a Tool,
    limits: FixedAxisLimits,
    finished: &'a FinishedPart<'a>,
    blades: BladePoints,
    hub: DistanceTable,
    blank: DistanceTable,
    shape: Shape,
}

/// A contact with what axes of a cone can run into there.
#[derive(Debug)]
struct Place {
    contact: Contact,
    /// Centre of the corner that touches.
    centre: Point,
    /// How far above the hub stock may stand, mm.
    top: f64,
    cone: Cone,
    near: Near,
}

/// How much an axis has to spare at a contact, mm, and what is nearest.
#[derive(Clone, Copy, Debug)]
struct Spare {
    amount: f64,
    by: Obstacle,
}

/// Greatest angle between a fixed axis and the layer's normal, rad.
pub const MAX_TILT: f64 = 65.0 * std::f64::consts::PI / 180.0;
/// Distances from the hub are met to this in the end, mm.
const HUB_TOLERANCE: f64 = 1e-4;
/// The table of distances from the hub is good to this, mm.
const HUB_SLACK: f64 = 0.05;
/// Heights of the column at which its distance from the hub is looked at.
const HUB_HEIGHTS: usize = 4;
/// Places of the holder's rim at which its distance from the blank is looked at.
const RIM_POINTS: usize = 8;

impl<'a> FixedAxisSearch<'a> {
    /// For `tool` in `channel`, whose surfaces are those of `finished`, cut from `blank`.
    pub fn new(
        finished: &'a FinishedPart<'a>,
        channel: &Channel,
        blank: &Blank,
        tool: &'a Tool,
        limits: &FixedAxisLimits,
    ) -> Self {
        let reach = tool.radius() + limits.blade_allowance;
        let margin = tool.overhang + 2.0 * tool.holder_diameter();
        Self {
            tool,
            limits: *limits,
            finished,
            blades: BladePoints::new(&channel.sides, reach.max(1e-3)),
            hub: DistanceTable::of_hub(finished.part, margin),
            blank: DistanceTable::of_blank(finished.part, blank, margin),
            shape: Shape::of(tool),
        }
    }

    /// The runs of `stations`, contacts of the cutter on a layer in order along a region. `layer` is the surface of the
    /// layer offset by the corner radius: cutters with a flat bottom are lifted until they do not cut into it.
    pub fn runs(&self, stations: &[Vec<Contact>], layer: &DepthSurface) -> FixedAxes {
        Greedy::new(self, layer, stations.to_vec()).run()
    }

    /// What keeps every axis from `contact`; `None` where one is free. See [`Self::runs`] for `layer`.
    pub fn blocked(&self, contact: &Contact, layer: &DepthSurface) -> Option<Obstacle> {
        Greedy::new(self, layer, Vec::new()).blocked(&self.place(contact, None))
    }

    /// Tip of the cutter with `axis` at `contact`: touching it, and lifted along the axis where the bottom would cut into
    /// `layer` (see [`Self::runs`]).
    pub fn tip(&self, contact: &Contact, axis: &Vector, layer: &DepthSurface) -> Point {
        let tip = self.tool.tip_at_contact(&contact.point, &contact.normal, axis);
        if self.tool.radius() - self.tool.corner_radius < 1e-9 {
            return tip;
        }
        match layer.tip(self.tool, &tip, axis) {
            Some(lifted) if (lifted - tip).dot(axis) > 0.0 => lifted,
            _ => tip,
        }
    }

    /// A contact ready for axes of `cone`; `None`: for all it may have.
    fn place(&self, contact: &Contact, cone: Option<Cone>) -> Place {
        let cone = cone.unwrap_or(Cone { axis: contact.normal, angle: self.limits.max_tilt });
        let centre = contact.point + contact.normal * self.tool.corner_radius;
        let margin = self.limits.blade_allowance + self.blades.slack + search::SEED_SPARE;
        let near = self.blades.near(&centre, &cone, &self.shape, margin);
        Place { contact: *contact, centre, top: self.top(&centre), cone, near }
    }

    /// What `axis` has to spare at `place`, by the quick distances. Below `enough` it may be anything below.
    fn spare(&self, place: &Place, axis: &Vector, enough: f64) -> Spare {
        let along = place.contact.normal.dot(axis);
        let tilt = along.clamp(-1.0, 1.0).acos();
        if tilt > self.limits.max_tilt || axis.angle(&place.cone.axis) > place.cone.angle + 1e-9 {
            return Spare { amount: f64::NEG_INFINITY, by: Obstacle::Tilt };
        }
        let mut spare = Spare { amount: f64::INFINITY, by: Obstacle::Tilt };
        let mut bound = |amount: f64, by: Obstacle| {
            if amount < spare.amount {
                spare = Spare { amount, by };
            }
            spare.amount < enough
        };
        let rim = self.tool.radius() - self.tool.corner_radius;
        let across = (place.contact.normal - axis * along).try_normalize(1e-9).unwrap_or_else(Vector::zeros);
        let offset = across * rim;
        let allowance = self.limits.blade_allowance + self.blades.slack;
        let limits = Least { cutter: enough + allowance, holder: enough + allowance };
        let least = place.near.least(&self.shape, axis, &offset, limits);
        if bound(least.cutter - allowance, Obstacle::Blade)
            | bound(least.holder - allowance, Obstacle::Holder)
        {
            return spare;
        }
        // A leaning column may meet the hub again.
        let bottom = place.centre + offset;
        let (from, to) = (2.0 * self.tool.radius(), self.tool.overhang);
        let allowance = self.tool.radius() + self.limits.hub_allowance + HUB_SLACK;
        for k in 0..=HUB_HEIGHTS {
            let up = from + (to - from).max(0.0) * k as f64 / HUB_HEIGHTS as f64;
            if bound(self.hub.at(&(bottom + axis * up)) - allowance, Obstacle::Hub) {
                return spare;
            }
        }
        let holder = 0.5 * self.tool.holder_diameter();
        for up in [0.0, 2.0 * holder] {
            let middle = bottom + axis * (to - self.tool.corner_radius + up);
            bound(self.hub.at(&middle) - holder - HUB_SLACK, Obstacle::Holder);
        }
        let end = bottom + axis * (to - self.tool.corner_radius);
        bound(self.above_stock(&end, axis, place.top) - HUB_SLACK, Obstacle::Stock);
        spare
    }

    /// Least height of the end of a holder above stock that stands up to `top` mm above the hub, as far as there is any of the
    /// blank, or less where it is surely enough, mm.
    fn above_stock(&self, end: &Point, axis: &Vector, top: f64) -> f64 {
        let height = |p: &Point| {
            let off_blank = self.blank.at(p);
            if off_blank > 2.0 * HUB_SLACK { off_blank } else { off_blank.max(self.hub.at(p) - top) }
        };
        let (middle, radius) = (height(end), 0.5 * self.tool.holder_diameter());
        // No place is nearer than the middle by more than it is away from it.
        if middle > radius + 2.0 * HUB_SLACK {
            return middle - radius;
        }
        let rim = Circle::new(end, axis, radius);
        let place = |k: usize| rim.at((std::f64::consts::TAU * k as f64 / RIM_POINTS as f64).sin_cos()).0;
        (0..RIM_POINTS).map(|k| height(&place(k))).fold(middle, f64::min)
    }

    /// What the holder of the cutter with `axis` meets when the tip is at `tip`: a blade or the stock that stays on it, or the
    /// layer in work. Of the layers above nothing stands.
    pub fn holder_meets(&self, tip: Point, axis: Vector) -> Option<Obstacle> {
        let holder = self.tool.holder(tip, axis);
        if !self.finished.clears(&holder, self.limits.blade_allowance) {
            return Some(Obstacle::Holder);
        }
        let top = self.top(&(tip + axis * self.tool.corner_radius));
        (self.above_stock(&holder.tip, &axis, top) < HUB_SLACK).then_some(Obstacle::Stock)
    }

    /// What keeps the cutter with the tip at `tip` away: a blade too near to it, or what [`Self::beside_blades`] finds.
    pub fn meets(&self, tip: Point, axis: Vector) -> Option<Obstacle> {
        if !self.finished.clears(&self.tool.placed(tip, axis), self.limits.blade_allowance) {
            return Some(Obstacle::Blade);
        }
        self.beside_blades(tip, axis)
    }

    /// What keeps a cutter that is clear of the blades away from `tip`: the hub too near to it, or what its holder meets.
    pub fn beside_blades(&self, tip: Point, axis: Vector) -> Option<Obstacle> {
        let limit = self.limits.hub_allowance - HUB_TOLERANCE;
        let near_hub = |near: bool| near && self.finished.hub_clearance(&self.tool.placed(tip, axis)) < limit;
        if near_hub(self.is_near_hub(tip, axis)) {
            return Some(Obstacle::Hub);
        }
        self.holder_meets(tip, axis)
    }

    /// Whether the hub may be nearer to the cutter than its allowance, by the quick distances along its axis.
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

    /// How far above the hub stock may stand beside a cutter whose corner is centred at `centre`, mm.
    fn top(&self, centre: &Point) -> f64 {
        self.hub.at(centre) - self.tool.corner_radius + self.limits.standing
    }

    /// Whether the cutter with `axis` is free at `contact`, measured: `Ok` with the least distance to a blade, or `least` if
    /// it is not below that.
    fn measured(
        &self,
        contact: &Contact,
        axis: &Vector,
        layer: &DepthSurface,
        least: f64,
    ) -> Result<f64, Obstacle> {
        let tip = self.tip(contact, axis, layer);
        let cutter = self.tool.placed(tip, *axis);
        let nearest = self.finished.blade_clearance_below(&cutter, least);
        if nearest < self.limits.blade_allowance {
            return Err(Obstacle::Blade);
        }
        if self.finished.hub_clearance(&cutter) < self.limits.hub_allowance - HUB_TOLERANCE {
            return Err(Obstacle::Hub);
        }
        self.holder_meets(tip, *axis).map_or(Ok(nearest), Err)
    }
}
