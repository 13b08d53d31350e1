//! What a flank program is made of: the tool with its feed rates, and the passes of each layer.

use super::approach::ApproachFeed;
use crate::flank::engagement::CutPasses;
use crate::flank::layer::{LayerPoint, LayerSurface};
use crate::flank::region::Region;
use crate::flank::strategies::PassRole;
use crate::geometry::{Point, Vector};
use crate::part::Blank;
use crate::setup::{FlankFeedRates, Tool};

/// One continuous cut: a whole pass curve, or a piece of it with one fixed axis.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Purpose of the pass.
    pub role: PassRole,
    /// Its region.
    pub region: Region,
    /// Index of the fixed axis within the region; passes along walls come last.
    pub group: usize,
    /// Tip and unit axis (tip → holder) along it, in the frame of the part.
    pub positions: Vec<(Point, Vector)>,
    /// Layer points of both ends.
    pub ends: [LayerPoint; 2],
    /// Whether the ends are beyond the part.
    pub open: [bool; 2],
    /// Whether a link over the layer may lead to it; otherwise the tool approaches from above.
    pub linked: bool,
}

/// Inputs of the program.
pub struct PathMaker<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// Feed rates by engagement.
    pub feeds: FlankFeedRates,
    /// The blank, which rapids clear.
    pub blank: &'a Blank,
    /// Height of the ramps at ends within the part, mm, where plunges before the first pass leave stock that
    /// is not known here; all approaches then go at the feed rate of their pass. `None`: the blank stands
    /// before the first pass.
    pub ramp_height: Option<f64>,
    /// Clearance of the tool above the blank before a rapid, and above stock where it comes down to that, mm.
    pub safety_distance: f64,
}

/// Whether cutter and holder are free of collision, for a layer point and the tip and axis of a tool there.
pub type CollisionCheck<'a> = dyn Fn(LayerPoint, Point, Vector) -> bool + Sync + 'a;

/// The passes of a layer, and the layer.
pub struct LayerPasses<'a> {
    /// Number of the layer, 0 at the hub.
    pub number: usize,
    /// The surface.
    pub layer: &'a LayerSurface,
    /// Stepover, mm.
    pub stepover: f64,
    /// Corner radius of the tool, mm.
    pub corner_radius: f64,
    /// The passes, in any order.
    pub passes: Vec<Pass>,
    /// Collision check for links.
    pub fits: Box<CollisionCheck<'a>>,
}

impl PathMaker<'_> {
    /// Feed rate of a move towards a pass, mm/min, whose own is `feed`.
    pub(super) fn approach_feed(&self, kind: ApproachFeed, feed: f64) -> f64 {
        match kind {
            ApproachFeed::Down => self.feeds.approach_mm_per_min,
            ApproachFeed::Pass => feed,
            ApproachFeed::Ramp => self.feeds.ramp_mm_per_min,
        }
    }

    /// Feed rate over the layer to a pass from where another one ends, mm/min, whose own is `feed`: there may
    /// be stock on both sides.
    pub(super) fn link_feed(&self, feed: f64) -> f64 {
        feed.min(self.feeds.slot_mm_per_min)
    }

    /// Feed rate along a pass, mm/min, after those of `cut` on its layer.
    pub(super) fn feed_of(&self, pass: &Pass, cut: &CutPasses) -> f64 {
        let feeds = &self.feeds;
        let slots = cut.are_far_from(&pass.positions);
        match pass.role {
            PassRole::Wall(_) if slots => feeds.wall_mm_per_min.min(feeds.slot_mm_per_min),
            PassRole::Wall(_) => feeds.wall_mm_per_min,
            PassRole::Inner if slots => feeds.slot_mm_per_min,
            PassRole::Inner => feeds.step_mm_per_min,
        }
    }
}
