//! Settings of the flank planner: strategies, passes and feed rates.

use super::Tool;

/// Largest default of the feed rate down to the stock, mm/min.
const MAX_APPROACH: f64 = 5000.0;

/// Strategy of the flank planner: how passes fill the channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FlankStrategy {
    /// Isoparametric layers and passes through the whole channel, as commercial modules plan them.
    Isoparametric,
    /// Layers of constant depth, with isoparametric passes region by region.
    Layers,
    /// Layers of constant depth, and in each region fans of offsets from both walls ([flank paper]).
    Regions,
    /// Vanecut's own: as few offsets as keep every gap within the stepover.
    Balanced,
}

impl FlankStrategy {
    /// All strategies, from the longest toolpath to Vanecut's own.
    pub const ALL: [Self; 4] = [Self::Isoparametric, Self::Layers, Self::Regions, Self::Balanced];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Isoparametric => "isoparametric",
            Self::Layers => "layers",
            Self::Regions => "regions",
            Self::Balanced => "balanced",
        }
    }
}

/// `[flank]`.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankSetup {
    /// Number of the tool; absent: chosen for the part.
    pub tool: Option<u32>,
    /// Strategy of the result.
    pub strategy: FlankStrategy,
    /// Depth of a layer, mm.
    pub layer_depth: f64,
    /// Largest scallop height on the floor, mm.
    pub scallop_height: f64,
    /// Length of lead-in and lead-out beyond leading and trailing edge, mm along the meridian; absent: the
    /// cutter's radius.
    pub lead_in_out: Option<f64>,
    /// Feed rate of passes beside others, mm/min; absent: 0.016 diameters per revolution.
    pub feed_mm_per_min: Option<f64>,
    /// Feed rate of passes in full stock, mm/min; absent: 0.6 of `feed`.
    pub slot_feed_mm_per_min: Option<f64>,
    /// Feed rate of passes along the walls, mm/min; absent: 0.8 of `feed`.
    pub wall_feed_mm_per_min: Option<f64>,
    /// Feed rate of ramps down into stock, mm/min; absent: 0.5 of `feed`.
    pub ramp_feed_mm_per_min: Option<f64>,
    /// Feed rate down to the stock at the start of a pass, where the cutter meets none, mm/min; absent: four
    /// times `feed`, but no more than 5000 and no less than `feed`.
    pub approach_feed_mm_per_min: Option<f64>,
}

/// Feed rates of a flank plan by engagement, mm/min.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlankFeedRates {
    /// Passes beside others that are already cut.
    pub step_mm_per_min: f64,
    /// Passes with stock on both sides.
    pub slot_mm_per_min: f64,
    /// Passes along walls.
    pub wall_mm_per_min: f64,
    /// Ramps down into stock.
    pub ramp_mm_per_min: f64,
    /// Down to the stock.
    pub approach_mm_per_min: f64,
}

impl FlankSetup {
    /// Feed rates with `tool`.
    pub fn feed_rates_for(&self, tool: &Tool) -> FlankFeedRates {
        let step = self.feed_mm_per_min.unwrap_or(0.016 * tool.diameter * tool.spindle);
        FlankFeedRates {
            step_mm_per_min: step,
            slot_mm_per_min: self.slot_feed_mm_per_min.unwrap_or(0.6 * step),
            wall_mm_per_min: self.wall_feed_mm_per_min.unwrap_or(0.8 * step),
            ramp_mm_per_min: self.ramp_feed_mm_per_min.unwrap_or(0.5 * step),
            approach_mm_per_min: self
                .approach_feed_mm_per_min
                .unwrap_or((4.0 * step).min(MAX_APPROACH).max(step)),
        }
    }

    /// Length of lead-in and lead-out with `tool`, mm.
    pub fn lead_in_out_for(&self, tool: &Tool) -> f64 {
        self.lead_in_out.unwrap_or(tool.radius())
    }
}
