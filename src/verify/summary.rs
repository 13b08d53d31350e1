//! Key figures of a plan, or of one section of it.

use crate::plunge::{PlungePlan, Position};
use crate::stock::statistics::statistics_of_channels;
use crate::stock::{FloorGrid, ResidualField};
use crate::toolpath::{ClProgram, Travel};

/// Key figures of a plan, or of one section of it (mm; NaN where there is nothing to measure).
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
    /// Positions blocked by the blades, including those that were left out.
    pub blocked: usize,
}

/// Residual stock on the floors of several channels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floors<'a> {
    /// The floor of a channel.
    pub grid: &'a FloorGrid,
    /// Heights of its cells, and the number of channels that have them.
    pub heights: &'a [(&'a [f32], usize)],
}

impl Summary {
    /// Figures of the whole plan.
    pub fn of(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField) -> Self {
        let program = ClProgram::of_plan("", plan);
        Self::summarize(plan, &Floors { grid, heights: &[(&field.heights, 1)] }, &Travel::of(&program), None)
    }

    /// Figures of section `index` of the plan: its positions, and the floor between its borders. Lengths and
    /// time are those of its plunges and the links between them.
    pub fn of_section(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField, index: usize) -> Self {
        let floors = Floors { grid, heights: &[(&field.heights, 1)] };
        let positions = plan.positions.iter().filter(|p| p.section == index).cloned().collect();
        let travel = Travel::of(&ClProgram::of_plan("", &PlungePlan { positions, ..plan.clone() }));
        Self::summarize(plan, &floors, &travel, Some(index))
    }

    /// Figures of a plan read from a program, or of one section of it; `floors` is the state after the
    /// program.
    pub(super) fn summarize(
        plan: &PlungePlan,
        floors: &Floors,
        travel: &Travel,
        section: Option<usize>,
    ) -> Self {
        let ours = |p: &&Position| section.is_none_or(|s| p.section == s);
        let positions: Vec<&Position> = plan.positions.iter().filter(ours).collect();
        let least = |f: &dyn Fn(&Position) -> f64| {
            positions.iter().map(|p| f(p)).fold(f64::NAN, |a, b| if a < b { a } else { b })
        };
        let section_plan = section.and_then(|s| plan.sections.get(s));
        let grid = floors.grid;
        let ours = |row: usize| section_plan.is_none_or(|s| (s.to..=s.from).contains(&grid.s_of_row(row)));
        let layer = statistics_of_channels(grid, floors.heights, ours);
        let turns = positions
            .windows(2)
            .filter(|pair| (pair[0].section, pair[0].row) == (pair[1].section, pair[1].row));
        Self {
            positions: positions.len(),
            interfering: positions.iter().filter(|p| p.evaluation.contact.interferes()).count(),
            max_contact_depth: positions.iter().map(|p| p.evaluation.contact.depth).fold(0.0, f64::max),
            residual_mean: f64::from(layer.mean),
            residual_p95: f64::from(layer.p95),
            residual_max: f64::from(layer.max),
            uncut_share: f64::from(layer.uncut_share),
            inaccessible_share: f64::from(layer.unreachable_share),
            min_hub_clearance: least(&|p| p.hub_clearance),
            min_blade_clearance: least(&|p| p.blade_clearance),
            min_retract_clearance: least(&|p| p.evaluation.retract_clearance),
            max_axis_change_rad: turns.map(|pair| pair[0].axis.angle(&pair[1].axis)).fold(0.0, f64::max),
            cut_length: travel.cut,
            rapid_length: travel.rapid,
            time_estimate: travel.time,
            blocked: positions.iter().filter(|p| p.blocked.is_some()).count()
                + plan.dropped.iter().filter(|d| section.is_none_or(|s| d.section == s)).count(),
        }
    }
}
