//! Key figures of a plan or program, or of one section of it.

use super::JudgedCut;
use crate::cutting::contact::CoreContact;
use crate::geometry::Vector;
use crate::machine::MachineTime;
use crate::plunge::{PlungePlan, Position};
use crate::stock::statistics::statistics_of_channels;
use crate::stock::{FloorGrid, ResidualField};
use crate::toolpath::{ClProgram, Travel};

/// Key figures of a plan or program, or of one section of it (mm; NaN where there is nothing to measure).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of positions.
    pub positions: usize,
    /// Interfering plunges: positions whose core meets stock.
    pub interfering: usize,
    /// Deepest contact of a core with stock.
    pub max_contact_depth: f64,
    /// Mean residual stock on the reachable floor that was cut.
    pub residual_mean: f64,
    /// 95th percentile of the residual stock.
    pub residual_p95: f64,
    /// Greatest residual stock.
    pub residual_max: f64,
    /// Share of the reachable floor that no position reaches.
    pub uncut_share: f64,
    /// Share of the whole floor that is inaccessible to every cutter; all other figures of the floor exclude
    /// it.
    pub inaccessible_share: f64,
    /// Least distance of the cutter to the finished hub.
    pub min_hub_clearance: f64,
    /// Least distance of the cutter to the finished blades.
    pub min_blade_clearance: f64,
    /// Least distance of the bottom at the retract point to the blank.
    pub min_retract_clearance: f64,
    /// Largest angle between neighbouring axes of a row, rad.
    pub max_axis_change_rad: f64,
    /// Cutting length, mm.
    pub cut_length: f64,
    /// Rapid length, mm.
    pub rapid_length: f64,
    /// Estimated time, s: cuts at their feed rates and rapids at [`crate::toolpath::RAPID_MM_PER_MIN`],
    /// without tool changes and accelerations.
    pub time_estimate: f64,
    /// Of it, the time under feed, s.
    pub feed_time: f64,
    /// How often a tool is loaded; 0 for sections.
    pub tool_loads: usize,
    /// Time on the machine of the setup; `None` without one, where it cannot run the whole plan, and for
    /// sections and programs, of which only their plan's is known.
    pub machine_time: Option<MachineTime>,
    /// Time of the program for all channels, s: on that machine, or without one as `time_estimate`; `None`
    /// where the machine cannot run it, and for plans that were not asked for.
    pub wheel_time_s: Option<f64>,
    /// Tool changes of each channel after the first in the order of the setup, s on that machine: 0 tool by
    /// tool.
    pub further_tool_changes_s: f64,
    /// Whether the machine of the setup, which runs the plan that was asked for, cannot run this one.
    pub is_refused: bool,
    /// Positions blocked by the blades, including those that were left out; `None` for a program, which does
    /// not contain them.
    pub blocked: Option<usize>,
}

/// Residual stock on the floors of several channels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floors<'a> {
    /// The floor of a channel.
    pub grid: &'a FloorGrid,
    /// Heights of its cells, and the number of channels that have them.
    pub heights: &'a [(&'a [f32], usize)],
}

/// What the figures of one cut are taken from, planned or found in a program.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutFigures<'a> {
    section: usize,
    row: usize,
    axis: &'a Vector,
    contact: &'a CoreContact,
    hub_clearance: f64,
    blade_clearance: f64,
    retract_clearance: Option<f64>,
}

impl<'a> CutFigures<'a> {
    /// Those of a position of a plan.
    fn of_position(position: &'a Position) -> Self {
        Self {
            section: position.section,
            row: position.row,
            axis: &position.axis,
            contact: &position.evaluation.contact,
            hub_clearance: position.hub_clearance,
            blade_clearance: position.blade_clearance,
            retract_clearance: Some(position.evaluation.retract_clearance),
        }
    }

    /// Those of a cut of a program.
    pub fn of_cut(cut: &'a JudgedCut) -> Self {
        Self {
            section: cut.section,
            row: cut.row,
            axis: &cut.axis,
            contact: &cut.contact,
            hub_clearance: cut.hub_clearance,
            blade_clearance: cut.blade_clearance,
            retract_clearance: cut.retract_clearance,
        }
    }
}

impl Summary {
    /// The best known time, s: on the machine of the setup, or else the estimate; NaN for a plan that this
    /// machine cannot run.
    pub fn time_s(&self) -> f64 {
        self.machine_time.map_or(self.estimate_s(), |time| time.total_s)
    }

    fn estimate_s(&self) -> f64 {
        if self.is_refused { f64::NAN } else { self.time_estimate }
    }

    /// The same of each further channel, s: with the tool changes that the order of the setup needs for it.
    pub fn time_of_further_channel_s(&self) -> f64 {
        let cut = |time: MachineTime| time.total_s - time.tool_changes_s;
        self.machine_time.map_or(self.estimate_s(), |time| cut(time) + self.further_tool_changes_s)
    }

    /// The same for the first `count` of `channels` channels, in the order of the setup. Where the time of
    /// all of them is not known, the links from channel to channel are left out.
    pub fn time_of_channels_s(&self, count: usize, channels: usize) -> f64 {
        match self.wheel_time_s {
            Some(wheel) => time_of_channels_s([self.time_s(), wheel], count, channels),
            None => self.time_s() + self.time_of_further_channel_s() * (count as f64 - 1.0),
        }
    }

    /// Figures of the whole plan.
    pub fn from_plan(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField) -> Self {
        let travel = Travel::from_program(&ClProgram::of_plan("", plan));
        let floors = Floors { grid, heights: &[(&field.heights, 1)] };
        let cuts = plan.positions.iter().map(CutFigures::of_position);
        Self { blocked: Some(blocked(plan, |_| true)), ..Self::of_cuts(cuts, &floors, travel, None) }
    }

    /// Figures of section `index` of the plan: its positions, and the floor between its borders. Lengths and
    /// time are those of its plunges and the links between them.
    pub fn of_section(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField, index: usize) -> Self {
        let floors = Floors { grid, heights: &[(&field.heights, 1)] };
        let positions: Vec<Position> =
            plan.positions.iter().filter(|p| p.section == index).cloned().collect();
        let own = PlungePlan { positions, ..plan.clone() };
        let travel = Travel::from_program(&ClProgram::of_plan("", &own));
        let range = plan.sections.get(index).map(|section| [section.from, section.to]);
        let cuts = own.positions.iter().map(CutFigures::of_position);
        let blocked = Some(blocked(plan, |section| section == index));
        Self { blocked, ..Self::of_cuts(cuts, &floors, travel, range) }
    }

    /// Figures of cuts, and of the floor between two s (from outlet to inlet; `None`: of the whole floor) in
    /// the state after the program. Figures that a program does not hold are `None`.
    pub(super) fn of_cuts<'a>(
        cuts: impl Iterator<Item = CutFigures<'a>>,
        floors: &Floors,
        travel: Travel,
        range: Option<[f64; 2]>,
    ) -> Self {
        let cuts: Vec<CutFigures> = cuts.collect();
        let least = |f: &dyn Fn(&CutFigures) -> Option<f64>| {
            cuts.iter().filter_map(f).fold(f64::NAN, |a, b| if a < b { a } else { b })
        };
        let grid = floors.grid;
        let ours = |row: usize| range.is_none_or(|[from, to]| (to..=from).contains(&grid.s_of_row(row)));
        let layer = statistics_of_channels(grid, floors.heights, ours);
        let turns =
            cuts.windows(2).filter(|pair| (pair[0].section, pair[0].row) == (pair[1].section, pair[1].row));
        Self {
            positions: cuts.len(),
            interfering: cuts.iter().filter(|cut| cut.contact.interferes()).count(),
            max_contact_depth: cuts.iter().map(|cut| cut.contact.depth).fold(0.0, f64::max),
            residual_mean: f64::from(layer.mean),
            residual_p95: f64::from(layer.p95),
            residual_max: f64::from(layer.max),
            uncut_share: f64::from(layer.uncut_share),
            inaccessible_share: f64::from(layer.unreachable_share),
            min_hub_clearance: least(&|cut| Some(cut.hub_clearance)),
            min_blade_clearance: least(&|cut| Some(cut.blade_clearance)),
            min_retract_clearance: least(&|cut| cut.retract_clearance),
            max_axis_change_rad: turns.map(|pair| pair[0].axis.angle(pair[1].axis)).fold(0.0, f64::max),
            cut_length: travel.cut,
            rapid_length: travel.rapid,
            time_estimate: travel.time,
            feed_time: travel.feed_time,
            tool_loads: travel.tool_loads,
            machine_time: None,
            wheel_time_s: None,
            further_tool_changes_s: 0.0,
            is_refused: false,
            blocked: None,
        }
    }
}

/// Time of the first `count` of `channels` channels, s, from those of one and of all: each further channel
/// takes as long as the others.
pub fn time_of_channels_s([one, all]: [f64; 2], count: usize, channels: usize) -> f64 {
    if count == channels {
        // Exactly that time: one that is off by rounding may be written with another last digit.
        return all;
    }
    one + (all - one) / (channels as f64 - 1.0) * (count as f64 - 1.0)
}

/// Number of positions of a plan that the blades block, or that were dropped, in the sections that count.
fn blocked(plan: &PlungePlan, counts: impl Fn(usize) -> bool) -> usize {
    plan.positions.iter().filter(|p| p.blocked.is_some() && counts(p.section)).count()
        + plan.dropped.iter().filter(|dropped| counts(dropped.section)).count()
}
