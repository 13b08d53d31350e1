//! A plan with some of its plunges left out.

use super::cycle::{PlanError, Planner};
use super::links::raise_links;
use super::plan::{PlungePlan, Position};
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn};
use crate::monitor::Monitor;

impl Planner<'_> {
    /// `plan` with only the plunges that are `kept`, one flag each: contact, retract points and links are made
    /// anew, and a row is split where the axes of the plunges left in it differ by more than the setup allows.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled.
    pub fn keep_plunges(
        &self,
        plan: &PlungePlan,
        kept: &[bool],
        monitor: &Monitor,
    ) -> Result<PlungePlan, PlanError> {
        let limit = self.setup.plunge.max_axis_change_rad;
        let mut thinned = PlungePlan { positions: Vec::with_capacity(plan.positions.len()), ..plan.clone() };
        let mut rows = vec![0; plan.sections.len()];
        let mut last: Option<&Position> = None;
        for (position, _) in plan.positions.iter().zip(kept).filter(|(_, kept)| **kept) {
            let same_row = last.is_some_and(|last| {
                (last.section, last.row) == (position.section, position.row)
                    && last.axis.angle(&position.axis) <= limit
            });
            if !same_row {
                rows[position.section] += 1;
            }
            thinned.positions.push(Position { row: rows[position.section] - 1, ..position.clone() });
            last = Some(position);
        }
        for (index, (section, rows)) in thinned.sections.iter_mut().zip(rows).enumerate() {
            let count = |plan: &[Position]| plan.iter().filter(|p| p.section == index).count();
            if count(&plan.positions) > count(&thinned.positions) {
                section.added = None;
            }
            section.rows = rows;
        }
        let top = BlankTop::new(&self.blank);
        let column = |p: &Position| {
            let tool = &thinned.sections[p.section].tool;
            PlungeColumn::new(tool.placed(p.tip, p.axis), tool.core_radius(), &top)
        };
        let columns: Columns = thinned.positions.iter().map(column).collect();
        self.measure(&mut thinned, &columns, monitor)?;
        raise_links(&mut thinned, &self.blank, self.setup.allowances.safety_distance, monitor)?;
        Ok(thinned)
    }
}
