//! Machinability of an impeller before any plan [assessment paper, section I]: twist and bow of the blades,
//! depth and width of the passages, the largest cutter that fits, and the floor that the tools reach.
//!
//! | measure | module |
//! |---|---|
//! | twist and bow (twisting and bending degree in the paper) | [`shape`] |
//! | depth, width and largest cutter along s | [`passage`], [`cutter`] |
//! | reach of the tools | [`reach`], and `stand` for a single point |
//! | gap between free-form blades and ruled walls | [`crate::part::envelope`] |

pub mod cutter;
mod limits;
pub mod passage;
pub mod reach;
pub mod shape;
mod tool_placement;

use crate::part::{Blade, BladeWall, WallEnvelope, Workpiece, splitter_name};
use passage::PassageMeasure;
use reach::{ReachLimits, ReachMap, ReachSection};
use shape::BladeShape;

/// Number of curves per wall in its envelope.
const ENVELOPE_CURVES: usize = 64;

/// Measures of one blade.
#[derive(Clone, Debug)]
pub struct BladeMeasure {
    /// "main", or the splitter by its number where a pitch has several.
    pub name: String,
    /// Twist and bow.
    pub shape: BladeShape,
    /// Ruled envelopes of suction and pressure side.
    pub envelopes: [WallEnvelope; 2],
}

impl BladeMeasure {
    /// Measures a blade of this name.
    pub fn from_blade(name: String, blade: &Blade) -> Self {
        let envelope = |wall| WallEnvelope::from_blade(blade, wall, ENVELOPE_CURVES);
        let envelopes = [envelope(BladeWall::Suction), envelope(BladeWall::Pressure)];
        Self { name, shape: BladeShape::from_blade(blade), envelopes }
    }

    /// Twist, rad.
    pub fn twisting(&self) -> f64 {
        self.shape.max_twist().map_or(0.0, |twist| twist.angle_rad)
    }

    /// Maximum gap between a wall and its envelope, mm.
    pub fn envelope_gap(&self) -> f64 {
        self.envelopes.iter().map(WallEnvelope::max_gap).fold(0.0, f64::max)
    }
}

/// All measures of a part.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// The main blade, then the splitters of a pitch from its suction side on, as [`blades_of`] has them.
    pub blades: Vec<BladeMeasure>,
    /// Depth of the channel along s, as (s, mm).
    pub depths: Vec<(f64, f64)>,
    /// The whole channel, then the passages that splitters divide it into.
    pub passages: Vec<PassageMeasure>,
    /// Reach of the tools; `None` if none were given.
    pub reach: Option<ReachMap>,
}

impl Assessment {
    /// Assesses the part of `workpiece`, and the reach of the tools of `stretches`.
    ///
    /// ```
    /// use vanecut::{assess::{Assessment, reach::ReachLimits}, setup::Setup};
    /// # let part = vanecut::io::part_file::read_part("assets/parts/pump6.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let setup = Setup::for_part(&part);
    /// let limits = ReachLimits {
    ///     hub_allowance: setup.allowances.hub_allowance,
    ///     blade_allowance: setup.allowances.blade_allowance,
    ///     max_tilt_rad: setup.plunge.max_tilt_rad,
    ///     clearances: setup.clearances,
    /// };
    /// let assessment = Assessment::from_workpiece(&setup.allowances.workpiece_of(part), &[], &limits);
    /// assert!(assessment.largest_cutter() < assessment.width_range().1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_workpiece(
        workpiece: &Workpiece,
        stretches: &[ReachSection<'_>],
        limits: &ReachLimits,
    ) -> Self {
        let Workpiece { part, channel, .. } = workpiece;
        let measured = |(name, blade)| BladeMeasure::from_blade(name, blade);
        Self {
            blades: blades_of(workpiece).into_iter().map(measured).collect(),
            depths: passage::depths(part, channel),
            passages: passage::measure(part, channel),
            reach: (!stretches.is_empty()).then(|| ReachMap::new(workpiece, stretches, limits)),
        }
    }

    /// Maximum twist of the blades, rad.
    pub fn twisting(&self) -> f64 {
        self.blades.iter().map(BladeMeasure::twisting).fold(0.0, f64::max)
    }

    /// Maximum bow of the blades, mm: distance of the mid section from the straight line between hub and tip.
    pub fn max_bow(&self) -> f64 {
        self.blades.iter().map(|b| b.shape.bow.offset).fold(0.0, f64::max)
    }

    /// Maximum depth of the channel, mm; NaN where none could be measured.
    pub fn depth(&self) -> f64 {
        self.depths.iter().map(|d| d.1).fold(f64::NAN, f64::max)
    }

    /// Minimum and maximum width of all passages, mm, including that between main blades beside a splitter;
    /// NaN where none could be measured.
    pub fn width_range(&self) -> (f64, f64) {
        let widths = || self.passages.iter().flat_map(PassageMeasure::all_widths);
        (widths().fold(f64::NAN, f64::min), widths().fold(f64::NAN, f64::max))
    }

    /// Diameter of the largest cutter that fits everywhere along the channel, mm; NaN when none fits.
    pub fn largest_cutter(&self) -> f64 {
        self.passages.iter().flat_map(|p| &p.cutters).map(|c| c.diameter).fold(f64::NAN, f64::min)
    }

    /// The measures of the passage between two blades; see [`passage::PassageBlades::splitters`].
    pub fn passage(&self, splitters: [Option<usize>; 2]) -> Option<&PassageMeasure> {
        self.passages.iter().find(|passage| passage.blades.splitters == splitters)
    }
}

/// The blades around a channel with their names: the main blade, then the splitters of a pitch from its
/// suction side on.
pub fn blades_of(workpiece: &Workpiece) -> Vec<(String, &Blade)> {
    let Workpiece { part, channel, .. } = workpiece;
    let splitters = channel.splitters.iter().enumerate().map(|(number, walls)| {
        (splitter_name(number, channel.splitters.len()), &part.splitters[walls.index])
    });
    std::iter::once(("main".to_owned(), &part.main)).chain(splitters).collect()
}
