//! When a cutter fits a place of the channel.

use crate::part::Tool;
use crate::part::setup::Stock;
use crate::plunge::survey::Station;

/// Room a cutter needs between the allowances to tilt and lean, in diameters.
const TILT_ROOM: f64 = 1.12;
/// How much thicker than a cutter the cylinder must be that clears both walls with the conventional axis: for the
/// places between two stations.
const CLEAR_ROOM: f64 = 1.04;
/// How much longer an axis may get than the isoparametric one by leaning: by 30°.
const LEAN_LENGTH: f64 = 1.155;

/// What a cutter must leave free.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Stock that stays on the blades, mm.
    pub blade_allowance: f64,
    /// Air above the blank, mm.
    pub safety_distance: f64,
}

/// How a cutter fits a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// With room to tilt, and long enough.
    Good,
    /// With room to tilt, but its holder would come into the blank.
    Short,
    /// Without room to tilt.
    Tight,
    /// Not at all.
    Wide,
}

impl Rules {
    /// For what stays on a part and above it.
    pub fn new(stock: &Stock) -> Self {
        Self { blade_allowance: stock.blade_allowance, safety_distance: stock.safety_distance }
    }

    /// Room inside the allowances of a passage of this width, mm.
    pub fn room(&self, width: f64) -> f64 {
        width - 2.0 * self.blade_allowance
    }

    /// Free length a cutter needs at a station, mm.
    pub fn overhang(&self, station: &Station) -> f64 {
        LEAN_LENGTH * station.deepest + self.safety_distance
    }

    /// How `tool` fits at a station.
    pub fn fit(&self, tool: &Tool, station: &Station) -> Fit {
        let room = self.room(station.narrowest);
        // Where not even the cylinder finds an axis the cutter will not find one either.
        if room < tool.diameter || station.clear < tool.diameter {
            Fit::Wide
        } else if room < TILT_ROOM * tool.diameter || station.clear < CLEAR_ROOM * tool.diameter {
            Fit::Tight
        } else if tool.overhang < self.overhang(station) {
            Fit::Short
        } else {
            Fit::Good
        }
    }
}

/// Diameters of the cylinders that tell where each of the tools clears both walls, largest first, mm.
pub fn cylinders(tools: &[Tool]) -> Vec<f64> {
    let mut diameters: Vec<f64> = tools.iter().map(|tool| CLEAR_ROOM * tool.diameter).collect();
    diameters.sort_by(|a, b| b.total_cmp(a));
    diameters.dedup();
    diameters
}
