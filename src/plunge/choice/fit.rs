//! Rules for whether a cutter fits at a station of the channel.

use crate::plunge::survey::{PassageExtent, SurveyStation};
use crate::setup::{AllowanceSetup, Tool};

/// Width between the allowances that a cutter needs to be inclined, in diameters.
pub(super) const TILT_ROOM: f64 = 1.12;
/// Diameter of the cylinder that must clear both walls with the conventional axis, in diameters of the
/// cutter: a margin for s between two stations.
const CLEAR_ROOM: f64 = 1.04;
/// Factor by which an axis inclined by 30° is longer than the isoparametric one.
const LEAN_LENGTH: f64 = 1.155;

/// Clearances that the rules depend on.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Blade allowance, mm.
    pub blade_allowance: f64,
    /// Safety distance above the blank, mm.
    pub safety_distance: f64,
}

/// How a cutter fits a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolFit {
    /// Wide enough for inclined axes, and long enough.
    Good,
    /// Wide enough for inclined axes, but the holder would enter the blank.
    Short,
    /// Wide enough for inclined axes, but its given shank or holder comes too near to part or blank.
    Hindered,
    /// Too tight for inclined axes.
    Tight,
    /// The cutter is wider than the passage.
    Wide,
}

impl Rules {
    /// The rules for these allowances and distances.
    pub fn new(stock: &AllowanceSetup) -> Self {
        Self { blade_allowance: stock.blade_allowance, safety_distance: stock.safety_distance }
    }

    /// Width inside the allowances of a passage of `width` mm, mm.
    pub fn free_width(&self, width: f64) -> f64 {
        width - 2.0 * self.blade_allowance
    }

    /// Overhang that a tool needs at a station, mm.
    pub fn overhang(&self, station: &SurveyStation) -> f64 {
        LEAN_LENGTH * station.deepest + self.safety_distance
    }

    /// Whether any of `tools` fits between the walls of a passage, inside the allowances, and is long enough
    /// to reach its hub along the isoparametric axis.
    pub fn any_reaches(&self, tools: &[Tool], across: &PassageExtent) -> bool {
        let free = self.free_width(across.narrowest);
        tools.iter().any(|tool| tool.diameter <= free && tool.overhang >= across.depth)
    }

    /// How `tool` fits at a station.
    pub fn fit(&self, tool: &Tool, station: &SurveyStation) -> ToolFit {
        let free = self.free_width(station.narrowest);
        // Where no cylinder of its diameter clears the walls, the cutter has no axis either.
        if free < tool.diameter || station.clear_diameter < tool.diameter {
            ToolFit::Wide
        } else if free < TILT_ROOM * tool.diameter || station.clear_diameter < CLEAR_ROOM * tool.diameter {
            ToolFit::Tight
        } else if station.hindered.contains(&tool.number) {
            ToolFit::Hindered
        } else if tool.overhang < self.overhang(station) {
            ToolFit::Short
        } else {
            ToolFit::Good
        }
    }
}

/// Diameters of the cylinders to try with
/// [`Survey::try_cylinders`](crate::plunge::survey::Survey::try_cylinders) for these tools, largest first,
/// mm.
pub fn cylinders(tools: &[Tool]) -> Vec<f64> {
    let mut diameters: Vec<f64> = tools.iter().map(|tool| CLEAR_ROOM * tool.diameter).collect();
    diameters.sort_by(|a, b| b.total_cmp(a));
    diameters.dedup();
    diameters
}
