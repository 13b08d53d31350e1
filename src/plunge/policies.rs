//! Which policy plans a section, and where it decides the axes.
//!
//! | policy | what it does | where |
//! |---|---|---|
//! | `conventional` | axes along the walls; cores may meet stock | `converge_row` in `row_plan` |
//! | `staircase` | the same axes; plunges stop short of stock | `converge_row`, then `cut_row` in `cut` |
//! | `monotone` | the lead angle grows along the row | `plan_row` in `row_plan`, [`super::monotone`] |
//! | `minimal` | the lead angles that leave least, cores free | `minimal_section` in `minimal` |
//!
//! Rest-milling sections are cut by `minimal` only (`rest_section`), those that open the blank are the
//! same for all policies (`opening_section`).

use rayon::prelude::*;

use super::cut::{PlannedRow, SectionCut};
use super::cycle::{PlanError, Planner};
use super::plan::DropReason;
use super::section_layout::StretchLayout;
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, CutDirection, SectionKind, tool_of};

impl Planner<'_> {
    /// Plans section `index` by `policy` after the plunges of `columns`.
    pub(super) fn plan_section(
        &self,
        index: usize,
        policy: AxisPolicy,
        columns: Columns,
        monitor: &Monitor,
    ) -> Result<SectionCut, PlanError> {
        let section = &self.setup.plunge.sections[index];
        match (policy, section.kind) {
            (_, SectionKind::Opening) => return self.opening_section(index, columns, monitor),
            (AxisPolicy::Minimal, SectionKind::Rest) => return self.rest_section(index, columns, monitor),
            (_, SectionKind::Rest) => {
                return Ok(SectionCut::empty(
                    section.cut_direction.unwrap_or(CutDirection::OutletToInlet),
                    columns,
                ));
            }
            (_, SectionKind::Rows) => {}
        }
        let layouts = self.shared_layouts(index)?;
        if policy == AxisPolicy::Minimal {
            return self.minimal_section(index, layouts, &columns, monitor);
        }
        let (axes, max_lift) = match policy {
            AxisPolicy::Staircase => (AxisPolicy::Conventional, Some(1.0)),
            other => (other, None),
        };
        let tool = tool_of(self.setup, section.tool)?;
        let rows = match self.plan_section_rows(index, layouts, axes, &columns, monitor) {
            Err(PlanError::Cancelled(_)) if monitor.is_stopped() => {
                return Ok(SectionCut::not_started(section, columns));
            }
            rows => rows?,
        };
        let mut cut =
            SectionCut::empty(section.cut_direction.unwrap_or(CutDirection::OutletToInlet), columns);
        for row in rows {
            cut.rows.push(self.cut_row(row, tool, max_lift, &mut cut.columns, &monitor.ignoring_stop())?);
        }
        Ok(cut)
    }

    /// Rows of section `index` by a policy that plans each row on its own.
    fn plan_section_rows(
        &self,
        index: usize,
        layouts: &[StretchLayout],
        policy: AxisPolicy,
        earlier: &Columns,
        monitor: &Monitor,
    ) -> Result<Vec<PlannedRow>, PlanError> {
        let section = &self.setup.plunge.sections[index];
        let tool = tool_of(self.setup, section.tool)?;
        let feed = section.cut_direction.unwrap_or(CutDirection::OutletToInlet);
        let mut rows = Vec::new();
        for layout in layouts {
            let made: Vec<Result<Vec<PlannedRow>, PlanError>> = layout
                .rows
                .par_iter()
                .map(|row_ground| {
                    let place = (row_ground.lambda, layout.rows.len());
                    let maker = self.row_maker(layout, tool, place, feed, monitor);
                    let ends = self.row_ends(index, &layout.stretch, feed.sign_along_s());
                    let runs = row_ground.runs.get_or_make(ends.0, || maker.runs(ends.0, ends.1))?;
                    let lambda = layout.stretch.lambda_in_channel(row_ground.lambda);
                    let mut rows = Vec::with_capacity(runs.stretches.len());
                    for &stretch in &runs.stretches {
                        let row = self.plan_row(&maker, row_ground, stretch, policy, earlier, monitor)?;
                        rows.push(PlannedRow { lambda, ..row });
                    }
                    if !runs.missing.is_empty() {
                        let missing = runs.missing.iter().map(|&s| (s, DropReason::Blades.into())).collect();
                        rows.push(PlannedRow { missing, ..PlannedRow::empty(lambda) });
                    }
                    Ok(rows)
                })
                .collect();
            for made in made {
                rows.extend(made?);
            }
        }
        Ok(rows)
    }
}
