//! The plunges of rows along the walls of a channel, as plunges are left out.

use super::neighbours::KeptNeighbours;
use crate::plunge::PlungePlan;
use crate::plunge::spacing::scallop_step;
use crate::setup::{SectionKind, Setup};

/// What keeps the scallop along walls within its limit: the rows beside them. Added plunges and those of rest
/// milling only cut deeper what these leave: without them a wall is as smooth.
pub(super) struct WallRows<'a> {
    plan: &'a PlungePlan,
    /// Largest distance of the neighbours of each plunge, mm; `None` for those that are not in a wall row.
    limits: Vec<Option<f64>>,
    /// Plunges of each wall and section in the order of s.
    rows: KeptNeighbours,
}

impl<'a> WallRows<'a> {
    /// Links the plunges of each wall and section in the order of s. A row may be split where axes turn, and
    /// a second pass may cut in between.
    pub fn new(plan: &'a PlungePlan, setup: &Setup) -> Self {
        let count = plan.positions.len();
        let (mut limits, mut rows) = (vec![None; count], KeptNeighbours::unlinked(count));
        for (index, section) in plan.sections.iter().enumerate() {
            if section.kind != SectionKind::Rows {
                continue;
            }
            let scallop = scallop_step(&setup.plunge, &section.tool);
            let limit = setup.plunge.step.map_or(scallop, |step| scallop.min(step));
            let of_section: Vec<usize> = (0..count).filter(|&k| plan.positions[k].section == index).collect();
            // The added ones come last.
            let added = section.added.map_or(0, |added| added.count).min(of_section.len());
            let of_rows = &of_section[..of_section.len() - added];
            for wall in [0.0, 1.0] {
                let mut row: Vec<usize> =
                    of_rows.iter().copied().filter(|&k| plan.positions[k].lambda == wall).collect();
                row.sort_by(|&a, &b| plan.positions[a].s.total_cmp(&plan.positions[b].s));
                rows.link(&row);
                row.iter().for_each(|&k| limits[k] = Some(limit));
            }
        }
        Self { plan, limits, rows }
    }

    /// Whether the plunges along its wall stay close enough without `plunge`. The ends of a row stay.
    pub fn stay_smooth_without(&self, plunge: usize) -> bool {
        let Some(limit) = self.limits[plunge] else { return true };
        let tip = |k: usize| self.plan.positions[k].tip;
        let beside = self.rows.before(plunge).zip(self.rows.after(plunge));
        beside.is_some_and(|(a, b)| (tip(a) - tip(b)).norm() <= limit)
    }

    /// Leaves `plunge` out.
    pub fn leave_out(&mut self, plunge: usize) {
        self.rows.leave_out(plunge);
    }
}
