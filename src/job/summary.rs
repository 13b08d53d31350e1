//! The numbers that decide, of a whole plan or of one section of it.

use crate::plunge::choice::estimate::RAPID_FEED;
use crate::plunge::{PlungePlan, Position};
use crate::residual::{FloorGrid, ResidualField, statistics};

/// Numbers of one plan, or of one section of it (mm; NaN where there is nothing to measure).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of positions.
    pub positions: usize,
    /// Positions whose core meets stock.
    pub interferential: usize,
    /// Deepest contact.
    pub max_contact_depth: f64,
    /// Mean residual layer over the cut floor.
    pub residual_mean: f64,
    /// 95th percentile.
    pub residual_p95: f64,
    /// Greatest.
    pub residual_max: f64,
    /// Share of the floor no position reaches.
    pub uncut_share: f64,
    /// Least distance of the cutter to the finished hub.
    pub min_hub_clearance: f64,
    /// Least distance of the cutter to the finished blades.
    pub min_blade_clearance: f64,
    /// Least distance of the bottom at the retract point to the blank.
    pub min_retract_clearance: f64,
    /// Largest angle between neighbouring axes of a row, rad.
    pub max_axis_change: f64,
    /// Length under plunge feed, mm.
    pub cut_length: f64,
    /// Length in rapid, mm.
    pub rapid_length: f64,
    /// Time from feeds, s: plunges and rapids at [`RAPID_FEED`]; tool changes and accelerations are left out.
    pub time_estimate: f64,
    /// Positions the blades block, those left out included.
    pub blocked: usize,
}

impl Summary {
    /// Of the whole plan.
    pub fn of(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField) -> Self {
        Self::over(plan, grid, field, None)
    }

    /// Of section `index` of the plan: its positions, and the floor between its borders.
    pub fn of_section(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField, index: usize) -> Self {
        Self::over(plan, grid, field, Some(index))
    }

    fn over(plan: &PlungePlan, grid: &FloorGrid, field: &ResidualField, section: Option<usize>) -> Self {
        let ours = |p: &&Position| section.is_none_or(|s| p.section == s);
        let positions: Vec<&Position> = plan.positions.iter().filter(ours).collect();
        let least = |f: &dyn Fn(&Position) -> f64| {
            positions.iter().map(|p| f(p)).fold(f64::NAN, |a, b| if a < b { a } else { b })
        };
        let mask: Vec<bool> = match section.and_then(|s| plan.sections.get(s)) {
            None => grid.floor.clone(),
            Some(s) => grid
                .floor
                .iter()
                .enumerate()
                .map(|(cell, &floor)| floor && (s.to..=s.from).contains(&grid.s_of_row(cell / grid.columns)))
                .collect(),
        };
        let layer = statistics(grid, &field.heights, &mask);
        let mut summary = Self {
            positions: positions.len(),
            interferential: positions.iter().filter(|p| p.contact.interferes()).count(),
            max_contact_depth: positions.iter().map(|p| p.contact.depth).fold(0.0, f64::max),
            residual_mean: f64::from(layer.mean),
            residual_p95: f64::from(layer.p95),
            residual_max: f64::from(layer.max),
            uncut_share: f64::from(layer.uncut_share),
            min_hub_clearance: least(&|p| p.hub_clearance),
            min_blade_clearance: least(&|p| p.blade_clearance),
            min_retract_clearance: least(&|p| p.retract_clearance),
            blocked: positions.iter().filter(|p| p.blocked.is_some()).count()
                + plan.dropped.iter().filter(|d| section.is_none_or(|s| d.section == s)).count(),
            ..Self::default()
        };
        summary.add_motion(plan, &positions);
        summary
    }

    fn add_motion(&mut self, plan: &PlungePlan, positions: &[&Position]) {
        for (k, p) in positions.iter().enumerate() {
            let plunge = (p.retract - p.tip).norm();
            self.cut_length += plunge;
            self.rapid_length += plunge;
            self.time_estimate += plunge / plan.sections[p.section].tool.plunge_feed * 60.0;
            let Some(next) = positions.get(k + 1) else { continue };
            if next.section == p.section {
                self.rapid_length += (next.retract - p.retract).norm();
                if next.row == p.row {
                    self.max_axis_change = self.max_axis_change.max(p.axis.angle(&next.axis));
                }
            }
        }
        self.time_estimate += self.rapid_length / RAPID_FEED * 60.0;
    }
}
