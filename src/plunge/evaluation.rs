//! The second half of planning: contact of the cores, retract points and links of a plan whose axes and
//! depths are final.

use rayon::prelude::*;

use super::cycle::{PlacedPlan, PlanError, Planner};
use super::links::raise_links;
use super::plan::{PlungePlan, Position};
use crate::cutting::contact::{Columns, core_contact};
use crate::cutting::retract::RetractSurface;
use crate::monitor::{Cancelled, Monitor};

/// Clearance added to the safety distance at a retract point, mm: between two samples of a link the distance
/// may dip by some µm.
const RETRACT_MARGIN: f64 = 0.02;

impl Planner<'_> {
    /// The second half of planning: contact of the cores, retract points and links. A stopped monitor is
    /// ignored here, so that partial plans are measured too.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled.
    pub fn evaluate(&self, placed: PlacedPlan, monitor: &Monitor) -> Result<PlungePlan, PlanError> {
        let PlacedPlan { mut plan, columns } = placed;
        let monitor = &monitor.ignoring_stop();
        self.measure(&mut plan, &columns, monitor)?;
        raise_links(&mut plan, &self.workpiece.blank, self.setup.allowances.safety_distance, monitor)?;
        Ok(plan)
    }

    /// Measures contact and computes the retract point of every position.
    fn measure(&self, plan: &mut PlungePlan, columns: &Columns, monitor: &Monitor) -> Result<(), PlanError> {
        let stock = &self.setup.allowances;
        let tops: Vec<RetractSurface> = plan
            .sections
            .iter()
            .map(|s| RetractSurface::new(&self.workpiece.blank, stock.safety_distance + s.tool.corner_radius))
            .collect();
        let sections = &plan.sections;
        let measured: Result<Vec<Position>, Cancelled> = plan
            .positions
            .par_iter()
            .enumerate()
            .map(|(k, position)| {
                monitor.check()?;
                let tool = &sections[position.section].tool;
                let column = &columns.as_slice()[k];
                let cutter = column.cutter;
                let lift = tops[position.section].height(
                    &cutter.tip,
                    &cutter.axis,
                    tool.radius() - tool.corner_radius,
                );
                let retract = cutter.tip + cutter.axis * (lift + RETRACT_MARGIN);
                let mut position = position.clone();
                position.retract = retract;
                position.contact = core_contact(column, columns.before(k), &self.workpiece.blank);
                Ok(position)
            })
            .collect();
        plan.positions = measured?;
        Ok(())
    }
}
