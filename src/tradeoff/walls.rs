//! The plunges of rows along the walls of a channel, as plunges are left out.

use crate::plunge::PlungePlan;
use crate::plunge::spacing::scallop_step;
use crate::setup::{SectionKind, Setup};

/// A plunge of a wall row and those beside it on the wall that are still in the plan.
#[derive(Clone, Copy, Debug, Default)]
struct WallPlunge {
    before: Option<usize>,
    after: Option<usize>,
    /// Largest distance of the two, mm.
    limit: f64,
}

/// What keeps the scallop along walls within its limit: the rows beside them. Added plunges and those of rest
/// milling cut deeper into what these leave, so that a wall is no rougher without them.
pub(super) struct WallRows<'a> {
    plan: &'a PlungePlan,
    /// By plunge; `None` for those that are not in a wall row.
    plunges: Vec<Option<WallPlunge>>,
}

impl<'a> WallRows<'a> {
    /// Links the plunges of each wall and section in the order of s. A row may be split where axes turn, and
    /// a second pass may cut in between.
    pub fn new(plan: &'a PlungePlan, setup: &Setup) -> Self {
        let mut plunges = vec![None; plan.positions.len()];
        for (index, section) in plan.sections.iter().enumerate() {
            if section.kind != SectionKind::Rows {
                continue;
            }
            let limit =
                scallop_step(&setup.plunge, &section.tool).min(setup.plunge.step.unwrap_or(f64::INFINITY));
            let of_section: Vec<usize> =
                (0..plan.positions.len()).filter(|&k| plan.positions[k].section == index).collect();
            let added = section.added.map_or(0, |added| added.count).min(of_section.len());
            let of_rows = &of_section[..of_section.len() - added];
            for wall in [0.0, 1.0] {
                let lambda = |k: usize| plan.positions[k].lambda;
                let mut row: Vec<usize> = of_rows.iter().copied().filter(|&k| lambda(k) == wall).collect();
                row.sort_by(|&a, &b| plan.positions[a].s.total_cmp(&plan.positions[b].s));
                for (i, &k) in row.iter().enumerate() {
                    let before = i.checked_sub(1).map(|i| row[i]);
                    plunges[k] = Some(WallPlunge { before, after: row.get(i + 1).copied(), limit });
                }
            }
        }
        Self { plan, plunges }
    }

    /// Whether the plunges along its wall stay close enough without `plunge`. The ends of a row stay.
    pub fn stay_smooth_without(&self, plunge: usize) -> bool {
        let Some(WallPlunge { before, after, limit }) = self.plunges[plunge] else { return true };
        let tip = |k: usize| self.plan.positions[k].tip;
        before.zip(after).is_some_and(|(a, b)| (tip(a) - tip(b)).norm() <= limit)
    }

    /// Leaves `plunge` out.
    pub fn leave_out(&mut self, plunge: usize) {
        let Some(WallPlunge { before, after, .. }) = self.plunges[plunge].take() else { return };
        if let Some(beside) = before.and_then(|k| self.plunges[k].as_mut()) {
            beside.after = after;
        }
        if let Some(beside) = after.and_then(|k| self.plunges[k].as_mut()) {
            beside.before = before;
        }
    }
}
