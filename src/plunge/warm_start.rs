//! Warm start: a valid plan for a changed setup from the axes of the previous one, shown as a preview while
//! the full search runs. Each cutter is lowered onto the hub again and stops short where its core would meet
//! stock, as in `staircase`; axes along a wall turn until they clear it.

use std::sync::Arc;

use rayon::prelude::*;

use super::cut::{PlannedRow, SectionCut};
use super::cycle::{PlanError, Planner};
use super::minimal::MAX_LIFT_OF_DEPTH;
use super::plan::PlungePlan;
use super::row::Station;
use super::section_cache::SectionCache;
use super::section_layout::StretchLayout;
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, SectionKind, Tool, tool_of};

impl Planner<'_> {
    /// Plan with the axes of the last finished plan by `policy` in the cache `known`, fitted to this setup.
    /// `None` when there is none, or its sections had other cutters.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    pub fn warm_start(
        &self,
        policy: AxisPolicy,
        known: &SectionCache,
        monitor: &Monitor,
    ) -> Result<Option<PlungePlan>, PlanError> {
        let Some(before) = known.last_complete(self.setup)? else { return Ok(None) };
        let placed = rayon::scope(|_| {
            let mut cuts: Vec<Arc<SectionCut>> = Vec::with_capacity(before.len());
            for (index, before) in before.iter().enumerate() {
                let columns = cuts.last().map(|cut| cut.columns.clone()).unwrap_or_default();
                cuts.push(Arc::new(self.warm_start_section(index, before, columns, monitor)?));
            }
            self.assemble_plan(policy, cuts)
        })?;
        self.evaluate(placed, monitor).map(Some)
    }

    /// Section `index` with the axes it had `before`, after the plunges of `columns`.
    fn warm_start_section(
        &self,
        index: usize,
        before: &SectionCut,
        columns: Columns,
        monitor: &Monitor,
    ) -> Result<SectionCut, PlanError> {
        let section = &self.setup.plunge.sections[index];
        let tool = tool_of(self.setup, section.tool)?;
        if section.kind == SectionKind::Opening {
            return self.opening_section(index, columns, monitor);
        }
        let own;
        let layouts = match self.shared_layouts(index)? {
            [] => {
                own = self.section_layout(section)?;
                &own
            }
            layouts => layouts,
        };
        let mut cut = SectionCut { added: before.added, ..SectionCut::empty(before.feed, columns) };
        for row in &before.rows {
            let lambda = row.lambda();
            let stations: Vec<&Station> = row.stations().collect();
            let stations: Vec<Station> = stations
                .into_par_iter()
                .filter_map(|station| self.refit_station(station, lambda, layouts, tool, before, monitor))
                .filter(|station| {
                    self.setup.machine.excess_tilt_rad(&self.workpiece.part, &station.axis) <= 0.0
                })
                .collect();
            let row = PlannedRow { stations, iterations: 1, ..PlannedRow::empty(lambda) };
            let row = self.cut_row(row, tool, Some(MAX_LIFT_OF_DEPTH), &mut cut.columns, monitor)?;
            cut.rows.extend(row.split_where_axes_turn(self.setup.plunge.max_axis_change_rad));
        }
        Ok(cut)
    }

    /// Fits a station of the row at `lambda` of the channel again, keeping its axis where walls allow.
    fn refit_station(
        &self,
        station: &Station,
        lambda: f64,
        layouts: &[StretchLayout],
        tool: &Tool,
        before: &SectionCut,
        monitor: &Monitor,
    ) -> Option<Station> {
        let s = station.ends.s_hub;
        let away = |layout: &&StretchLayout| {
            let StretchLayout { stretch, .. } = layout;
            let (low, high) = stretch.lambdas;
            ((s - stretch.from).max(stretch.to - s).max(0.0), (low - lambda).max(lambda - high).max(0.0))
        };
        let order = |a: (f64, f64), b: (f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
        let layout = layouts.iter().min_by(|a, b| order(away(a), away(b)))?;
        // Only rows at a wall are fitted again; axes between the walls are kept.
        let walls = [0.0, 1.0];
        let at_wall = walls.into_iter().find(|&wall| layout.stretch.lambda_in_channel(wall) == lambda);
        let maker = self.row_maker(layout, tool, (at_wall.unwrap_or(0.5), 2), before.feed, monitor);
        let lowered = Station {
            s_shroud_conventional: station.s_shroud_conventional,
            ..maker.lower_to_hub(station.ends)
        };
        maker.exact(&lowered)
    }
}
