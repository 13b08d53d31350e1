//! Opening: plunges along the axis of rotation that remove what stands above the shroud in the way of the
//! tools of the channel.
//!
//! A blank that is higher than the shroud, as a cylinder is, would have the plunges of the channel begin at
//! its outside: deeper than their tools are long. Rows lie in planes through the axis of rotation and run
//! from the outside inwards, each plunge down to the shroud. They are those of one pitch, repeated all
//! around; a row that is not needed further inwards, where rows come closer, ends there. A plan keeps the
//! plunges that a tool of a later section comes near, with those before them in their rows.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::context::PlanContext;
use super::cut::{PlannedRow, SectionCut, cut_row};
use super::cycle::{PlacedPlan, PlanError, assemble_all};
use super::evaluation::evaluate;
use super::lane::AxisEnds;
use super::minimal::MAX_LIFT_OF_DEPTH;
use super::plan::{PlungePlan, Unevaluated};
use super::row::Station;
use super::spacing::{step_limit, stepover};
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn};
use crate::cutting::retract::RetractSurface;
use crate::geometry::{Meridional, Point, Vector};
use crate::monitor::Monitor;
use crate::part::{Blank, Impeller};
use crate::setup::{AxisPolicy, CutDirection, SectionKind, Setup, Tool};

/// Gap between core and blank at the start of a row, and above the allowance on the blade tips, mm.
const MARGIN: f64 = 0.05;
/// Depth of stock that is worth a plunge, in cutter radii.
const MIN_DEPTH_RADII: f64 = 0.1;
/// Maximum number of times that the rows of a pitch are doubled.
const MAX_DOUBLINGS: u32 = 12;

/// What stands above the shroud of a part.
#[derive(Debug)]
pub struct Opening<'a> {
    part: &'a Impeller,
    setup: &'a Setup,
    blank: &'a Blank,
    /// The blank that ends at the shroud.
    below: Blank,
}

/// A row of plunges from the outside inwards, in a plane through the axis of rotation.
#[derive(Clone, Debug)]
pub struct OpeningRow {
    /// Share of the pitch by which it is turned from the plane y = 0.
    pub share: f64,
    /// Tips in cutting order.
    pub tips: Vec<Point>,
    /// Height of the stock above each tip, mm.
    pub depths: Vec<f64>,
}

impl<'a> Opening<'a> {
    /// What stands above the shroud of `part` in `blank`.
    pub fn new(part: &'a Impeller, blank: &'a Blank, setup: &'a Setup) -> Self {
        Self { part, setup, blank, below: Blank::of(part, setup.allowances.inlet_extension) }
    }

    /// The rows of one pitch with `tool`.
    pub fn rows(&self, tool: &Tool) -> Vec<OpeningRow> {
        let outside = self.blank.extent().0 + tool.core_radius().max(0.0) + MARGIN;
        let pitch = self.part.pitch();
        let gap = outside * pitch.abs() / stepover(&self.setup.plunge, tool);
        let doublings = gap.log2().ceil().clamp(0.0, f64::from(MAX_DOUBLINGS)) as u32;
        let count = 1u32 << doublings;
        let places = self.places(tool, outside);
        let row = |number: u32| {
            let share = f64::from(number) / f64::from(count);
            // Distance of the two rows beside it, which are of coarser doublings, in pitches: the row is
            // needed where that exceeds the stepover.
            let without = f64::from(2u32 << number.trailing_zeros().min(doublings)) / f64::from(count);
            let is_needed =
                |r: f64| number == 0 || without * pitch.abs() * r > stepover(&self.setup.plunge, tool);
            let kept = places.iter().take_while(|(p, _)| is_needed(p.r));
            let (tips, depths) = kept.map(|(p, depth)| (p.at_angle(share * pitch), *depth)).unzip();
            OpeningRow { share, tips, depths }
        };
        (0..count).map(row).collect()
    }

    /// Tips of a row that runs through, with the height of the stock above each.
    fn places(&self, tool: &Tool, outside: f64) -> Vec<(Meridional, f64)> {
        let axis = self.part.out_of_inlet();
        let (corner, up) = (tool.corner_radius, axis.z);
        let gap = self.setup.allowances.blade_allowance + MARGIN;
        let surface = RetractSurface::new(&self.below, gap + corner);
        // Beyond the rim down to where the hub ends.
        let floor = self.part.hub.point(1.0).z + up * (self.setup.allowances.hub_allowance + MARGIN);
        let inner = self.part.hub.point(0.0).r;
        let step = step_limit(&self.setup.plunge, tool, false);
        let count = ((outside - inner) / step).floor().max(0.0) as usize;
        let place = |k: usize| {
            let r = outside - step * k as f64;
            let base = Point::new(r, 0.0, floor);
            let height = surface.height(&base, &axis, tool.radius() - corner);
            let tip = base + axis * (height - corner).max(0.0);
            let depth = self.blank.outline_touch(&tip, &axis, tool.radius(), 0.0)?;
            (depth > MIN_DEPTH_RADII * tool.radius()).then_some((Meridional { r, z: tip.z }, depth))
        };
        (0..=count).filter_map(place).collect()
    }
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
        rows.push(cut_row(context, row, tool, Some(MAX_LIFT_OF_DEPTH), &mut own, monitor)?);
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
    let (place, theta) = (Meridional::of(&tip), tip.y.atan2(tip.x));
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

/// `plan` with its `columns` without the plunges above the shroud that no tool of another section comes
/// near. `None` where it has none of them.
pub(super) fn with_needed_opening(
    context: &PlanContext,
    plan: &PlungePlan<Unevaluated>,
    columns: &Columns,
) -> Option<(PlungePlan<Unevaluated>, Columns)> {
    let is_opening = |section: usize| plan.sections[section].kind == SectionKind::Opening;
    let count = plan.positions.iter().take_while(|p| is_opening(p.section)).count();
    if count == 0 {
        return None;
    }
    let top = BlankTop::new(&context.workpiece.blank);
    let others = plan.positions[count..].iter().map(|position| {
        let tool = &plan.sections[position.section].tool;
        reach_column(tool, (position.tip, position.axis), context.setup, &top)
    });
    Some(keep_near(plan, columns, count, others))
}

/// The plunges above the shroud that `tool` comes near at one of `poses`, tips with unit axes.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn opening_for(
    context: &PlanContext,
    tool: &Tool,
    poses: impl Iterator<Item = (Point, Vector)>,
    monitor: &Monitor,
) -> Result<PlungePlan, PlanError> {
    let cut = Arc::new(opening_section(context, 0, Columns::default(), monitor)?);
    let PlacedPlan { plan, columns } = assemble_all(context, AxisPolicy::Conventional, &[cut])?;
    let top = BlankTop::new(&context.workpiece.blank);
    let near = poses.map(|pose| reach_column(tool, pose, context.setup, &top));
    let (plan, columns) = keep_near(&plan, &columns, plan.positions.len(), near);
    evaluate(context, PlacedPlan { plan, columns }, monitor)
}

/// What `tool` sweeps on its way into and out of a pose, with its holder all the way down: a column that is
/// as wide.
fn reach_column(tool: &Tool, (tip, axis): (Point, Vector), setup: &Setup, top: &BlankTop) -> PlungeColumn {
    let reach = tool.radius().max(0.5 * tool.holder_diameter()) + setup.clearances.holder;
    PlungeColumn::new(tool.placed(tip, axis), reach, top)
}

/// `plan` with its `columns`, of whose first `count` plunges, which are above the shroud, only those are kept
/// that come near to one of the columns of `others`, with those before them in their rows.
fn keep_near(
    plan: &PlungePlan<Unevaluated>,
    columns: &Columns,
    count: usize,
    others: impl Iterator<Item = PlungeColumn>,
) -> (PlungePlan<Unevaluated>, Columns) {
    // Number of plunges to keep of each row: up to the last one that is needed.
    let mut needed: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let mut number_in_row = Vec::with_capacity(count);
    for (k, position) in plan.positions[..count].iter().enumerate() {
        let before = k.checked_sub(1).map(|k| &plan.positions[k]);
        let same = before.is_some_and(|b| (b.section, b.row) == (position.section, position.row));
        number_in_row.push(if same { number_in_row[k - 1] + 1 } else { 0 });
    }
    for column in others {
        for near in columns.before(count).numbers_near(&column) {
            let near = near as usize;
            let other = &plan.positions[near];
            let kept = needed.entry((other.section, other.row)).or_default();
            *kept = (*kept).max(number_in_row[near] + 1);
        }
    }
    let mut kept = PlungePlan { positions: Vec::with_capacity(plan.positions.len()), ..plan.clone() };
    let mut left = Columns::default();
    let mut rows = vec![0; plan.sections.len()];
    let mut last = None;
    for (k, (position, column)) in plan.positions.iter().zip(columns.as_slice()).enumerate() {
        let place = (position.section, position.row);
        if k < count && needed.get(&place).is_none_or(|kept| number_in_row[k] >= *kept) {
            continue;
        }
        left.push(*column);
        let mut position = position.clone();
        if k < count {
            rows[place.0] += usize::from(last != Some(place));
            last = Some(place);
            position.row = rows[place.0] - 1;
        }
        kept.positions.push(position);
    }
    for (section, rows) in kept.sections.iter_mut().zip(rows) {
        if section.kind == SectionKind::Opening {
            section.rows = rows;
        }
    }
    (kept, left)
}
