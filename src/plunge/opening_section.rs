//! The sections that open the blank, and the context of planning with their plunges.

use super::context::PlanContext;
use super::cut::{PlannedRow, SectionCut, cut_row};
use super::error::PlanError;
use super::lane::AxisEnds;
use super::minimal::MINIMAL_MAX_LIFT_SHARE;
use super::opening::Opening;
use super::row::Station;
use super::row_density::RowDensity;
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn};
use crate::geometry::{Meridional, Point, Vector};
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::setup::{CutDirection, SectionKind, Setup};

/// The context of planning `workpiece` with a complete `setup`, by `minimal` in rows of this `density`.
pub(super) fn plan_context<'a>(
    workpiece: &'a Workpiece,
    setup: &'a Setup,
    density: RowDensity,
) -> PlanContext<'a> {
    let mut context = PlanContext::new(workpiece, setup, density);
    // A section that cannot be planned is reported with its place when it is.
    context.opening = opening_columns(&context).unwrap_or_default();
    context
}

/// Plans section `index`, which opens the blank, after the plunges of `columns`: all around the wheel.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn opening_section(
    context: &PlanContext,
    index: usize,
    mut columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    let tool = context.tool_of_section(index)?;
    let mut rows = Vec::new();
    for row in Opening::new(&context.workpiece.part, &context.workpiece.blank, context.setup).rows(tool) {
        let stations = row.tips.iter().map(|tip| station_above(context, *tip)).collect();
        let row = PlannedRow { stations, iterations: 1, ..PlannedRow::empty(row.share) };
        // Each row on its own, so that it is free of contact whichever others a plan keeps.
        let mut own = Columns::default();
        rows.push(cut_row(context, row, tool, Some(MINIMAL_MAX_LIFT_SHARE), &mut own, monitor)?);
    }
    let top = BlankTop::new(&context.workpiece.blank);
    let mut cut = SectionCut::empty(CutDirection::OutletToInlet, Columns::default());
    for channel in 0..context.workpiece.part.blade_count {
        for row in &rows {
            let turned = row.turned(context.workpiece.part.pitch() * channel as f64);
            let row = if channel == 0 { turned } else { turned.without_dropped() };
            columns.extend(row.cutters().map(|c| PlungeColumn::new(*c, tool.core_radius(), &top)));
            cut.rows.push(row);
        }
    }
    cut.columns = columns;
    Ok(cut)
}

/// The plunges of all sections that open the blank.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn opening_columns(context: &PlanContext) -> Result<Columns, PlanError> {
    let mut columns = Columns::default();
    for (index, section) in context.setup.plunge.sections.iter().enumerate() {
        if section.kind == SectionKind::Opening {
            columns = opening_section(context, index, columns, &Monitor::default())?.columns;
        }
    }
    Ok(columns)
}

/// The station of a plunge above the shroud.
fn station_above(context: &PlanContext, tip: Point) -> Station {
    let (place, theta) = (Meridional::from_point(&tip), tip.y.atan2(tip.x));
    let [s_hub, s_shroud] = [&context.workpiece.part.hub, &context.workpiece.part.shroud]
        .map(|path| path.s_at(path.curve().project(place).0).clamp(0.0, 1.0));
    let axis: Vector = context.workpiece.part.out_of_inlet();
    let normal = context.workpiece.part.hub.normal(s_hub).direction_at_angle(theta);
    Station {
        ends: AxisEnds { s_hub, theta_hub: theta, s_shroud, theta_shroud: theta },
        s_shroud_conventional: s_shroud,
        tip,
        axis,
        contact_point: tip,
        alpha_rad: axis.angle(&normal),
        blocked: None,
        limited_by: None,
    }
}
