//! Plunges that the user locked ([`PlungeChange::Lock`]): they are cut where they are, and the planner places
//! the others around them.
//!
//! A locked plunge takes the place of the nearest one of a row, where that is near and the core is free
//! there; the others are cut after the rows of their section. The depths of what follows in the row, later
//! rows, the second pass and added plunges are planned for the stock that the locked ones leave.

use super::context::PlanContext;
use super::cut::{CutRow, CutStation, PlannedRow, SectionCut, cut_row_around};
use super::edit_pose::position_at;
use super::error::PlanError;
use super::lane::AxisEnds;
use super::locked_plunge::LockedPlunge;
use super::placed_cutter::PlacedCutter;
use super::row::Station;
use super::spacing::step_limit;
use crate::cutting::contact::{BlankTop, Columns, Earlier, planned_contact};
use crate::monitor::Monitor;
use crate::setup::{PlungeChange, PlungeEdit, PlungePose, SectionKind, SectionSetup, Tool, tool_of};

/// Share of the step within which a locked plunge takes the place of one of the plan.
const NEAR_SHARE: f64 = 0.5;

/// Distance within which a locked plunge of `tool` takes the place of another one, mm, between the tips that
/// both would have if they did not stop short.
pub(super) fn replaced_within(context: &PlanContext, tool: &Tool) -> f64 {
    NEAR_SHARE * step_limit(&context.setup.plunge, tool, false)
}

/// The plunge of `tool` at `pose` that is locked and stops `lift` mm short.
fn locked_at(context: &PlanContext, tool: &Tool, pose: &PlungePose, lift: f64) -> LockedPlunge {
    let position = position_at(context, tool, pose, lift, (0, 0));
    let foot = pose.lifted(-lift).tip;
    let theta = foot.y.atan2(foot.x);
    let (s, axis) = (position.s, pose.axis);
    let station = Station {
        ends: AxisEnds { s_hub: s, s_shroud: s, theta_hub: theta, theta_shroud: theta },
        s_shroud_conventional: s,
        tip: foot,
        axis,
        contact_point: position.contact_point,
        alpha_rad: position.alpha_rad,
        blocked: None,
        limited_by: None,
    };
    let cutter = PlacedCutter {
        cutter: tool.placed(pose.tip, axis),
        hub_clearance: position.hub_clearance,
        blade_clearance: position.blade_clearance,
        lift,
    };
    LockedPlunge { station, cutter, lambda: position.lambda }
}

/// The plunges that `edits` lock, by section. Those of a tool that has several sections belong to the one on
/// whose stretch of the floor they are; those that open the blank are left out.
pub(super) fn locked_plunges(context: &PlanContext, edits: &[PlungeEdit]) -> Vec<Vec<LockedPlunge>> {
    let sections = &context.setup.plunge.sections;
    let mut locked: Vec<Vec<LockedPlunge>> = vec![Vec::new(); sections.len()];
    let mut known: Vec<PlungePose> = Vec::new();
    for edit in edits {
        let PlungeChange::Lock { tool: number, lift } = edit.change else { continue };
        let Ok(tool) = tool_of(context.setup, number) else { continue };
        if known.iter().any(|pose| pose.is(&edit.plunge)) {
            continue;
        }
        let plunge = locked_at(context, tool, &edit.plunge, lift);
        let outside = |section: &SectionSetup| {
            let (low, high) = (section.from.min(section.to), section.from.max(section.to));
            let s = plunge.station.ends.s_hub;
            (low - s).max(s - high).max(0.0)
        };
        let of_tool = sections.iter().enumerate();
        let of_tool = of_tool.filter(|(_, s)| s.tool == number && s.kind != SectionKind::Opening);
        let nearest = of_tool.min_by(|(_, a), (_, b)| outside(a).total_cmp(&outside(b)));
        if let Some((index, _)) = nearest {
            known.push(edit.plunge);
            locked[index].push(plunge);
        }
    }
    locked
}

/// Puts those of the `waiting` plunges into `row` that are near one of its stations and whose core is free in
/// its place. The first `before` of `columns` are cut before the row, the others are those of the row.
///
/// # Errors
/// When `monitor` is cancelled.
pub(super) fn lock_into_row(
    context: &PlanContext,
    (tool, max_lift_share): (&Tool, Option<f64>),
    row: CutRow,
    (columns, before): (&mut Columns, usize),
    waiting: &mut Vec<LockedPlunge>,
    monitor: &Monitor,
) -> Result<CutRow, PlanError> {
    let mut places = places_in(&row.stations, waiting, replaced_within(context, tool));
    if places.is_empty() {
        return Ok(row);
    }
    let blank = &context.workpiece.blank;
    loop {
        let mut planned = row.planned();
        for &(k, number) in &places {
            planned.stations[k] = waiting[number].station;
        }
        let fixed: Vec<(usize, PlacedCutter)> =
            places.iter().map(|&(k, number)| (k, waiting[number].cutter)).collect();
        columns.truncate(before);
        let cut = cut_row_around(context, planned, tool, max_lift_share, &fixed, columns, monitor)?;
        let is_free = |&(k, _): &(usize, usize)| {
            let column = before + cut.stations[..k].iter().filter(|at| at.placed.is_ok()).count();
            planned_contact(&columns.as_slice()[column], columns.before(column), blank) == 0.0
        };
        let free: Vec<(usize, usize)> = places.iter().copied().filter(is_free).collect();
        if free.len() == places.len() {
            let mut number = 0..;
            waiting.retain(|_| number.next().is_some_and(|n| !places.iter().any(|&(_, place)| place == n)));
            return Ok(cut);
        }
        places = free;
    }
}

/// Number of the station in whose place each of the `waiting` plunges goes that is within `reach` of one, and
/// its own number.
fn places_in(stations: &[CutStation], waiting: &[LockedPlunge], reach: f64) -> Vec<(usize, usize)> {
    let mut places: Vec<(usize, usize)> = Vec::new();
    for (number, plunge) in waiting.iter().enumerate() {
        let distance = |at: &CutStation| (at.station.tip - plunge.station.tip).norm();
        let near = stations.iter().enumerate().map(|(k, at)| (k, distance(at)));
        let near = near.filter(|(k, d)| *d <= reach && !places.iter().any(|(taken, _)| taken == k));
        if let Some((k, _)) = near.min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            places.push((k, number));
        }
    }
    places
}

/// Cuts the `waiting` plunges after the rows of section `index`: first those whose core is free, which may
/// free others, then what remains. Each is a row of its own.
///
/// # Errors
/// When `monitor` is cancelled, or the section's tool is missing.
pub(super) fn cut_waiting(
    context: &PlanContext,
    index: usize,
    mut waiting: Vec<LockedPlunge>,
    cut: &mut SectionCut,
    monitor: &Monitor,
) -> Result<(), PlanError> {
    if waiting.is_empty() {
        return Ok(());
    }
    let tool = context.tool_of_section(index)?;
    let top = BlankTop::new(&context.workpiece.blank);
    let is_free = |plunge: &LockedPlunge, earlier: Earlier| {
        planned_contact(&plunge.column(tool, &top), earlier, &context.workpiece.blank) == 0.0
    };
    loop {
        let mut later = Vec::new();
        let count = waiting.len();
        for plunge in waiting {
            monitor.check()?;
            if is_free(&plunge, cut.columns.all()) {
                cut.push_plunge(&plunge, tool, &top);
            } else {
                later.push(plunge);
            }
        }
        waiting = later;
        if waiting.len() == count || waiting.is_empty() {
            break;
        }
    }
    for plunge in waiting {
        cut.push_plunge(&plunge, tool, &top);
    }
    Ok(())
}

impl SectionCut {
    /// Cuts `plunge` last, as a row of its own.
    fn push_plunge(&mut self, plunge: &LockedPlunge, tool: &Tool, top: &BlankTop) {
        let row = PlannedRow { stations: vec![plunge.station], ..PlannedRow::empty(plunge.lambda) };
        self.rows.push(CutRow::new(row, [Ok(plunge.cutter)]));
        self.columns.push(plunge.column(tool, top));
    }
}
