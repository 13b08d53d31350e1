//! Machinability of an impeller before any plan (paper C, section I): how twisted and bent the blades are, how deep and
//! narrow the passages, which cutter still fits, and which floor it reaches.
//!
//! | question | file |
//! |---|---|
//! | twisting and bending degree | [`shape`] |
//! | depth, width and largest cutter along s | [`passage`], [`cutter`] |
//! | reach of the cutters | [`reach`], and `stand` for a single place |
//! | what ruled walls leave on the blades | [`crate::part::envelope`] |

pub mod cutter;
pub mod passage;
pub mod reach;
pub mod shape;
mod stand;

use crate::part::{Blade, BladeWall, Channel, Impeller, WallEnvelope};
use passage::{PassageMeasure, Place};
use reach::{ReachLimits, ReachMap, Stretch};
use shape::BladeShape;

/// Curves per wall whose envelope is taken.
const ENVELOPE_CURVES: usize = 64;

/// One blade, measured.
#[derive(Clone, Debug)]
pub struct BladeMeasure {
    /// Twist and bend.
    pub shape: BladeShape,
    /// Envelopes of suction and pressure side.
    pub envelopes: [WallEnvelope; 2],
}

impl BladeMeasure {
    /// Measures a blade.
    pub fn of(blade: &Blade) -> Self {
        let envelope = |wall| WallEnvelope::of(blade, wall, ENVELOPE_CURVES);
        let envelopes = [envelope(BladeWall::Suction), envelope(BladeWall::Pressure)];
        Self { shape: BladeShape::of(blade), envelopes }
    }

    /// Twisting degree, rad.
    pub fn twisting(&self) -> f64 {
        self.shape.most_twisted().map_or(0.0, |twist| twist.degree)
    }

    /// Greatest gap between a wall and its envelope, mm.
    pub fn envelope_gap(&self) -> f64 {
        self.envelopes.iter().map(WallEnvelope::greatest_gap).fold(0.0, f64::max)
    }
}

/// Everything that was found out about a part.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// The main blade, then the splitter if there is one.
    pub blades: Vec<BladeMeasure>,
    /// Depth of the channel along s, (s, mm).
    pub depths: Vec<(f64, f64)>,
    /// The full channel, then the passages beside the splitter.
    pub passages: Vec<PassageMeasure>,
    /// Reach of the cutters; none were given: `None`.
    pub reach: Option<ReachMap>,
}

impl Assessment {
    /// Assesses `part` with its `channel`, and the reach of the cutters of `stretches`.
    pub fn of(part: &Impeller, channel: &Channel, stretches: &[Stretch<'_>], limits: &ReachLimits) -> Self {
        let blades =
            std::iter::once(&part.main).chain(part.splitters.first()).map(BladeMeasure::of).collect();
        Self {
            blades,
            depths: passage::depths(part, channel),
            passages: passage::measure(part, channel),
            reach: (!stretches.is_empty()).then(|| ReachMap::new(part, channel, stretches, limits)),
        }
    }

    /// Largest twisting degree of the blades, rad.
    pub fn twisting(&self) -> f64 {
        self.blades.iter().map(BladeMeasure::twisting).fold(0.0, f64::max)
    }

    /// Largest offset of a mid section from the straight line between hub and tip, mm.
    pub fn bending(&self) -> f64 {
        self.blades.iter().map(|b| b.shape.bend.offset).fold(0.0, f64::max)
    }

    /// Greatest depth of the channel, mm; NaN where none could be measured.
    pub fn depth(&self) -> f64 {
        self.depths.iter().map(|d| d.1).fold(f64::NAN, f64::max)
    }

    /// Least and greatest width of all passages, the distance between main blades past a splitter included,
    /// mm; NaN where none could be measured.
    pub fn width_range(&self) -> (f64, f64) {
        let widths = || self.passages.iter().flat_map(PassageMeasure::all_widths);
        (widths().fold(f64::NAN, f64::min), widths().fold(f64::NAN, f64::max))
    }

    /// Diameter of the largest cutter that fits everywhere along the channel, mm; NaN when none does.
    pub fn largest_cutter(&self) -> f64 {
        self.passages.iter().flat_map(|p| &p.cutters).map(|c| c.diameter).fold(f64::NAN, f64::min)
    }

    /// What was measured of one passage.
    pub fn passage(&self, place: Place) -> Option<&PassageMeasure> {
        self.passages.iter().find(|p| p.place == place)
    }
}
