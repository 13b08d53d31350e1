//! The verdict on a flank program.

use super::examine::StepResult;
use super::steps::CutterStep;
use super::uncovered::Uncovered;
use crate::flank::wall::DeviationMap;
use crate::stock::ResidualStatistics;
use crate::toolpath::RAPID_MM_PER_MIN;
use crate::verify::assembly::AssemblyDistances;
use crate::verify::fault::Fault;

/// Result of checking a flank program. Lengths mm; NaN where there is nothing to measure.
#[derive(Clone, Debug)]
pub struct FlankVerdict {
    /// Number of channels with cuts.
    pub channels: usize,
    /// Number of moves under feed.
    pub positions: usize,
    /// Number of tools used.
    pub tools: usize,
    /// How often a tool is loaded.
    pub tool_loads: usize,
    /// Cutting length, and rapid length.
    pub cut_length: f64,
    /// See `cut_length`.
    pub rapid_length: f64,
    /// Estimated time, s, without tool changes and accelerations.
    pub time_estimate: f64,
    /// Of it, the time under feed, s.
    pub feed_time: f64,
    /// Least distance of the cutter to the finished hub, capped at 1 mm above the allowance.
    pub min_hub_clearance: f64,
    /// The same to the blades.
    pub min_blade_clearance: f64,
    /// Least distance of the bottom to the blank in rapids across it.
    pub min_retract_clearance: f64,
    /// Greatest turn of the axis in one move under feed, rad.
    pub max_axis_change_rad: f64,
    /// Greatest overcut: cut below the blades' allowance, noses and blunt trailing edges included.
    pub max_overcut: f64,
    /// Greatest undercut: stock left on a wall above its allowance, where cutters come near to it; without
    /// noses, blunt trailing edges, and the foot of the wall that the tool corner does not reach.
    pub max_undercut: f64,
    /// Share of the walls to which no cutter comes near, of the channel with the most of it, 0…1.
    pub unmilled_wall_share: f64,
    /// The same wall by wall, in the order of `walls`; NaN where a wall is below what is judged.
    pub unmilled_walls: Vec<f64>,
    /// What is left on the walls of the first channel above the allowance: first and second main wall, then
    /// both sides of each splitter; NaN where no cutter comes near.
    pub walls: Vec<DeviationMap>,
    /// Shares of the floor on which more is left than the setup's scallop height, of the channel with the
    /// most of it.
    pub uncovered: Uncovered,
    /// Residual stock on the floor of that channel.
    pub layer: ResidualStatistics,
    /// Deepest cut: height above the bottom of the cutter of the stock over the floor that it removes at
    /// once, mm.
    pub deepest_cut: f64,
    /// Least distances of shank and holder to the finished part.
    pub assembly: AssemblyDistances,
    /// Remarks that are not faults.
    pub notes: Vec<String>,
    /// All faults, by line.
    pub faults: Vec<Fault>,
}

impl FlankVerdict {
    /// The verdict on a program without moves.
    pub(super) fn empty() -> Self {
        Self {
            channels: 0,
            positions: 0,
            tools: 0,
            tool_loads: 0,
            cut_length: 0.0,
            rapid_length: 0.0,
            time_estimate: 0.0,
            feed_time: 0.0,
            min_hub_clearance: f64::NAN,
            min_blade_clearance: f64::NAN,
            min_retract_clearance: f64::NAN,
            max_axis_change_rad: 0.0,
            max_overcut: 0.0,
            max_undercut: f64::NAN,
            unmilled_wall_share: 0.0,
            unmilled_walls: Vec::new(),
            walls: Vec::new(),
            uncovered: Uncovered::default(),
            layer: ResidualStatistics::default(),
            deepest_cut: 0.0,
            assembly: AssemblyDistances::NONE,
            notes: Vec::new(),
            faults: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, step: &CutterStep, look: &StepResult) {
        let length = step.length();
        match step.feed {
            Some(feed) => {
                self.cut_length += length;
                let time = length / feed.max(1e-6) * 60.0;
                self.time_estimate += time;
                self.feed_time += time;
                self.max_axis_change_rad = self.max_axis_change_rad.max(step.turn());
                self.min_hub_clearance = self.min_hub_clearance.min(look.clearance.hub);
                self.min_blade_clearance = self.min_blade_clearance.min(look.clearance.blade);
            }
            None => {
                self.rapid_length += length;
                self.time_estimate += length / RAPID_MM_PER_MIN * 60.0;
                self.min_retract_clearance = self.min_retract_clearance.min(look.retract);
            }
        }
    }
}
