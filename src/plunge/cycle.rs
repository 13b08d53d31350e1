//! The loop of [plunge paper], fig. 16: conventional positions → step inspection → axis optimisation →
//! drop-cutter depth and safe height, repeated until it converges; then contact and clearances are measured.

use std::sync::Arc;

use rayon::prelude::*;

use super::assembly::{AssemblyRule, DropCause};
use super::links::raise_links;
use super::plan::{AddedPlunges, DropReason, Dropped, PlungePlan, Position, SectionPlan};
use super::row::Station;
use super::section_cache::SectionCache;
use super::section_layout::StretchLayout;
use super::sections::{MAX_POSITIONS, too_many_positions};
use crate::cutting::contact::{
    BlankTop, Columns, Earlier, PlungeColumn, core_contact, cuts_deeper_than, planned_contact,
};
use crate::cutting::retract::RetractSurface;
use crate::error::UserError;
use crate::geometry::{CutterSolid, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::setup::{
    AxisPolicy, CutDirection, SectionKind, SectionSetup, Setup, SetupFault, SetupPlace, Tool, tool_of,
};

/// Maximum number of lifts of one plunge; contact that remains is reported as interference.
const MAX_LIFTS: usize = 8;
/// Clearance added to the safety distance at a retract point, mm: between two samples of a link the distance
/// may dip by some µm.
const RETRACT_MARGIN: f64 = 0.02;
/// Gap left between a lifted core and the stock below it, mm.
const LIFT_MARGIN: f64 = 1e-3;

/// Why planning failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part and setup do not match.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<PlanError> for UserError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(cancelled) => cancelled.into(),
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// Planner for one part and one setup; holds what all policies share.
#[derive(Debug)]
pub struct Planner<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) setup: &'a Setup,
    /// The plunges of the sections that open the blank.
    pub(super) opening: Columns,
    /// Layout of each section, independent of the policy; empty for sections that do not cut rows.
    layouts: Vec<Result<Vec<StretchLayout<'a>>, PlanError>>,
}

/// A cutter at its final depth, with its clearances to the finished part, mm.
#[derive(Debug)]
struct PlacedCutter {
    cutter: CutterSolid,
    hub_clearance: f64,
    blade_clearance: f64,
    /// Distance by which it stops short of the hub allowance, mm.
    lift: f64,
}

/// A plan with final axes and depths; contact with stock and retract points are not computed yet.
#[derive(Debug)]
pub struct PlacedPlan {
    pub(super) plan: PlungePlan,
    /// Its plunges.
    pub(super) columns: Columns,
}

impl PlacedPlan {
    /// The plan without contact and retracts: contact is 0, retract points equal the tips.
    pub fn plan(&self) -> &PlungePlan {
        &self.plan
    }
}

/// One row, planned.
#[derive(Debug)]
pub(super) struct PlannedRow {
    pub stations: Vec<Station>,
    pub lambda: f64,
    pub iterations: usize,
    pub converged: bool,
    /// s at which the row has no position, and why.
    pub missing: Vec<(f64, DropCause)>,
}

impl PlannedRow {
    pub fn empty(lambda: f64) -> Self {
        Self { stations: Vec::new(), lambda, iterations: 0, converged: true, missing: Vec::new() }
    }
}

/// A planned row with the final position of every cutter.
#[derive(Debug)]
pub(super) struct CutRow {
    row: PlannedRow,
    /// One entry per station: the placed cutter, or why the station is dropped.
    placed: Vec<Result<PlacedCutter, DropReason>>,
}

impl CutRow {
    /// Number of positions, without the dropped ones.
    pub fn len(&self) -> usize {
        self.placed.iter().flatten().count()
    }

    /// λ of the row in the channel.
    pub fn lambda(&self) -> f64 {
        self.row.lambda
    }

    /// The cutters of the positions, without the dropped ones.
    pub fn cutters(&self) -> impl Iterator<Item = &CutterSolid> {
        self.placed.iter().flatten().map(|placed| &placed.cutter)
    }

    /// The row turned about Z by `angle`, rad.
    pub fn turned(&self, angle: f64) -> Self {
        let turned = |placed: &PlacedCutter| {
            let CutterSolid { tip, axis, .. } = placed.cutter;
            let (tip, axis) = (rotate_z(&tip, angle), rotate_vector_z(&axis, angle));
            PlacedCutter { cutter: CutterSolid { tip, axis, ..placed.cutter }, ..*placed }
        };
        let placed = self.placed.iter().map(|placed| placed.as_ref().map(turned).map_err(|why| *why));
        Self {
            row: PlannedRow {
                stations: self.row.stations.iter().map(|station| station.turned(angle)).collect(),
                missing: self.row.missing.clone(),
                ..self.row
            },
            placed: placed.collect(),
        }
    }

    /// Lift of the plunge at an s of the hub, mm; `None` where there is none or it is dropped.
    pub fn lift_at(&self, s_hub: f64) -> Option<f64> {
        let is_there = |station: &Station| (station.ends.s_hub - s_hub).abs() < 1e-9;
        let at = self.row.stations.iter().position(is_there)?;
        self.placed[at].as_ref().ok().map(|placed| placed.lift)
    }

    /// Forgets the places that `is_cut` holds for, by λ and s, of those that are missing or dropped.
    pub fn forget_open(&mut self, is_cut: impl Fn(f64, f64) -> bool) {
        let lambda = self.row.lambda;
        self.row.missing.retain(|(s, _)| !is_cut(lambda, *s));
        let placed = std::mem::take(&mut self.placed);
        let stations = std::mem::take(&mut self.row.stations);
        for (station, placed) in stations.into_iter().zip(placed) {
            if placed.is_ok() || !is_cut(lambda, station.ends.s_hub) {
                self.row.stations.push(station);
                self.placed.push(placed);
            }
        }
    }

    /// The stations that are not dropped.
    pub fn stations(&self) -> impl Iterator<Item = &Station> {
        self.row
            .stations
            .iter()
            .zip(&self.placed)
            .filter(|(_, placed)| placed.is_ok())
            .map(|(station, _)| station)
    }

    /// The row without its dropped stations.
    pub fn without_dropped(mut self) -> Self {
        let placed = std::mem::take(&mut self.placed);
        let stations = std::mem::take(&mut self.row.stations);
        for (station, placed) in stations.into_iter().zip(placed).filter(|(_, placed)| placed.is_ok()) {
            self.row.stations.push(station);
            self.placed.push(placed);
        }
        self
    }

    /// The same positions in the same order, with a new row wherever the axis turns by more than `limit`
    /// (rad) between two consecutive positions that are not dropped.
    pub fn split_where_axes_turn(self, limit: f64) -> Vec<Self> {
        let PlannedRow { lambda, iterations, converged, missing, .. } = self.row;
        let empty = || Self {
            row: PlannedRow { iterations, converged, ..PlannedRow::empty(lambda) },
            placed: Vec::new(),
        };
        let mut rows = vec![empty()];
        rows[0].row.missing = missing;
        let mut last: Option<Vector> = None;
        for (station, placed) in self.row.stations.into_iter().zip(self.placed) {
            if let Ok(placed) = &placed {
                let axis = placed.cutter.axis;
                if last.is_some_and(|last| last.angle(&axis) > limit) {
                    rows.push(empty());
                }
                last = Some(axis);
            }
            if let Some(row) = rows.last_mut() {
                row.row.stations.push(station);
                row.placed.push(placed);
            }
        }
        rows
    }
}

/// A planned section with the final position of every cutter.
#[derive(Debug)]
pub(super) struct SectionCut {
    pub feed: CutDirection,
    pub rows: Vec<CutRow>,
    /// All plunges so far, those of earlier sections first.
    pub columns: Columns,
    /// See [`SectionPlan::added`].
    pub added: Option<AddedPlunges>,
}

impl SectionCut {
    /// A section without rows, to be cut after the plunges of `columns`.
    pub fn empty(feed: CutDirection, columns: Columns) -> Self {
        Self { feed, rows: Vec::new(), columns, added: None }
    }

    /// As [`Self::empty`], for a section that planning did not reach before it was stopped.
    fn not_started(section: &SectionSetup, columns: Columns) -> Self {
        let feed = section.cut_direction.unwrap_or(CutDirection::OutletToInlet);
        Self { added: Some(AddedPlunges::UNFINISHED), ..Self::empty(feed, columns) }
    }

    /// Records that the row at `lambda` has no position at the s in `missing`.
    pub fn note_missing(&mut self, lambda: f64, missing: Vec<(f64, DropCause)>) {
        if !missing.is_empty() {
            let row = PlannedRow { missing, ..PlannedRow::empty(lambda) };
            self.rows.push(CutRow { row, placed: Vec::new() });
        }
    }

    /// Whether planning was stopped before the section was finished.
    pub fn is_unfinished(&self) -> bool {
        self.added.is_some_and(AddedPlunges::is_unfinished)
    }
}

impl<'a> Planner<'a> {
    /// Planner for `workpiece` with a `setup` completed by [`super::sections::resolve`].
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        let mut planner = Self { workpiece, setup, opening: Columns::default(), layouts: Vec::new() };
        let shared = |section: &SectionSetup| match section.kind {
            SectionKind::Rows => planner.section_layout(section),
            SectionKind::Rest | SectionKind::Opening => Ok(Vec::new()),
        };
        planner.layouts = setup.plunge.sections.par_iter().map(shared).collect();
        // A section that cannot be planned is reported with its place when it is.
        planner.opening = planner.opening_columns().unwrap_or_default();
        planner
    }

    /// Layout of section `index`, the same for all policies; empty for one that does not cut rows.
    ///
    /// # Errors
    /// When the section's tool is missing.
    pub(super) fn shared_layouts(&self, index: usize) -> Result<&[StretchLayout<'a>], PlanError> {
        self.layouts[index].as_deref().map_err(PlanError::clone)
    }

    /// The workpiece that it plans for.
    pub fn workpiece(&self) -> &Workpiece {
        self.workpiece
    }

    /// Plans one channel by `policy`. When the monitor is stopped, the plan consists of what was found until
    /// then: all finished sections and the finished part of the current one, with contact and clearances.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] when the monitor is cancelled, or stopped before any position was found;
    /// [`PlanError::Setup`] when part and setup do not match.
    pub fn plan(&self, policy: AxisPolicy, monitor: &Monitor) -> Result<PlungePlan, PlanError> {
        self.plan_cached(policy, &mut SectionCache::default(), monitor)
    }

    /// As [`Self::plan`], reusing the sections in `known` that are still valid: the cache from earlier plans
    /// of the same part by the same policy. Finished sections are stored in it, even if planning is
    /// cancelled.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn plan_cached(
        &self,
        policy: AxisPolicy,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<PlungePlan, PlanError> {
        let plan = self.evaluate(self.place_plunges(policy, known, monitor)?, monitor)?;
        monitor.report(1.0);
        Ok(plan)
    }

    /// The first half of planning: positions, axes and depths.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn place_plunges(
        &self,
        policy: AxisPolicy,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<PlacedPlan, PlanError> {
        // Enters the rayon pool once; otherwise every small parallel task would cross threads.
        rayon::scope(|_| self.place_plunges_in_pool(policy, known, monitor))
    }

    /// [`Self::place_plunges`], running on a thread of the pool.
    fn place_plunges_in_pool(
        &self,
        policy: AxisPolicy,
        known: &mut SectionCache,
        monitor: &Monitor,
    ) -> Result<PlacedPlan, PlanError> {
        let mut cuts: Vec<Arc<SectionCut>> = Vec::new();
        known.invalidate(self.setup)?;
        let sections = &self.setup.plunge.sections;
        for (index, section) in sections.iter().enumerate() {
            self.report_section(index, 0.0, monitor);
            let tool = tool_of(self.setup, section.tool)?;
            let place = SetupPlace::Section { index, tool: tool.number };
            let make = |before: Option<&SectionCut>| {
                let columns = before.map(|cut| cut.columns.clone()).unwrap_or_default();
                self.plan_section(index, policy, columns, monitor).map_err(|error| match error {
                    PlanError::Setup(fault) if fault.place == SetupPlace::Whole => fault.at(place).into(),
                    other => other,
                })
            };
            let cut = match cuts.last().filter(|last| last.is_unfinished()) {
                Some(last) => Arc::new(SectionCut::not_started(section, last.columns.clone())),
                None => known.get_or_make(index, self.setup, make)?,
            };
            cuts.push(cut);
            let planned = cuts.iter().flat_map(|cut| &cut.rows).map(|row| row.placed.len()).sum();
            self.check_count(planned, tool, place)?;
        }
        known.store_complete(sections.len());
        let placed = self.assemble_plan(policy, cuts)?;
        monitor.report(0.85);
        Ok(placed)
    }

    /// Reports that a share (0…1) of the work on section `index` is done.
    pub(super) fn report_section(&self, index: usize, share: f64, monitor: &Monitor) {
        let done = (index as f64 + share) / self.setup.plunge.sections.len() as f64;
        monitor.report(0.1 + 0.7 * done);
    }

    /// Assembles the plan of these sections, with those plunges above the shroud that it needs.
    pub(super) fn assemble_plan(
        &self,
        policy: AxisPolicy,
        cuts: Vec<Arc<SectionCut>>,
    ) -> Result<PlacedPlan, PlanError> {
        let PlacedPlan { plan, columns } = self.assemble_all(policy, &cuts)?;
        let (plan, columns) = self.with_needed_opening(&plan, &columns).unwrap_or((plan, columns));
        Ok(PlacedPlan { plan, columns })
    }

    /// Assembles the plan of these sections with all their plunges.
    pub(super) fn assemble_all(
        &self,
        policy: AxisPolicy,
        cuts: &[Arc<SectionCut>],
    ) -> Result<PlacedPlan, PlanError> {
        let mut plan = PlungePlan {
            policy,
            sections: Vec::new(),
            positions: Vec::new(),
            dropped: Vec::new(),
            iterations: 0,
            converged: true,
        };
        for (index, (section, cut)) in self.setup.plunge.sections.iter().zip(cuts).enumerate() {
            let tool = tool_of(self.setup, section.tool)?;
            let rule = self.assembly_rule(tool);
            plan.sections.push(SectionPlan {
                tool: tool.clone(),
                from: section.from,
                to: section.to,
                feed: cut.feed,
                rows: cut.rows.len(),
                kind: section.kind,
                added: cut.added,
            });
            for (row_index, CutRow { row, placed }) in cut.rows.iter().enumerate() {
                plan.iterations = plan.iterations.max(row.iterations);
                plan.converged &= row.converged;
                let missing = row.missing.iter();
                plan.dropped.extend(missing.map(|&(s, DropCause { why, stick_out })| Dropped {
                    section: index,
                    row: row_index,
                    s,
                    why,
                    stick_out,
                }));
                for (station, placed) in row.stations.iter().zip(placed) {
                    let placed = match placed {
                        Ok(placed) => placed,
                        Err(why) => {
                            let s = station.ends.s_hub;
                            let cause = match &rule {
                                Some(rule) => rule.cause(*why, (station.tip, station.axis)),
                                None => (*why).into(),
                            };
                            let DropCause { why, stick_out } = cause;
                            plan.dropped.push(Dropped { section: index, row: row_index, s, why, stick_out });
                            continue;
                        }
                    };
                    plan.positions.push(Position {
                        tip: placed.cutter.tip,
                        hub_clearance: placed.hub_clearance,
                        blade_clearance: placed.blade_clearance,
                        lift: placed.lift,
                        ..Position::unmeasured(station, index, row_index, row.lambda)
                    });
                }
            }
        }
        if plan.positions.is_empty() && plan.is_unfinished() {
            return Err(Cancelled.into());
        }
        let columns = cuts.last().map(|cut| cut.columns.clone()).unwrap_or_default();
        Ok(PlacedPlan { plan, columns })
    }

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

    /// The rule for shank and holder of `tool`; `None` where neither is given.
    pub(super) fn assembly_rule<'r>(&'r self, tool: &'r Tool) -> Option<AssemblyRule<'r>> {
        AssemblyRule::new(tool, &self.workpiece.finished, &self.workpiece.blank, self.setup)
            .map(|rule| rule.after(self.opening.all()))
    }

    /// The cutter of a station with its measured clearances to the finished part. Lifts the bottom where it
    /// violates the hub allowance by rounding.
    fn place_cutter(&self, station: &Station, tool: &Tool) -> Result<PlacedCutter, DropReason> {
        let stock = &self.setup.allowances;
        let mut cutter = tool.placed(station.tip, station.axis);
        let mut hub_clearance = self.workpiece.finished.hub_clearance(&cutter);
        for doubling in 0..12 {
            let deep = stock.hub_allowance - hub_clearance;
            if deep <= 0.0 {
                break;
            }
            // On an axis oblique to the hub a lift raises the clearance by only part of itself.
            cutter.tip += cutter.axis * (1.2 * deep * f64::from(1 << doubling) + 1e-9);
            hub_clearance = self.workpiece.finished.hub_clearance(&cutter);
        }
        let blade_clearance = self.workpiece.finished.blade_clearance(&cutter);
        if blade_clearance < stock.blade_allowance - 1e-6 {
            return Err(DropReason::Blades);
        }
        Ok(PlacedCutter { cutter, hub_clearance, blade_clearance, lift: 0.0 })
    }

    /// Places the cutters of a row and adds them to `columns`. With `max_lift` each plunge stops short where
    /// its core would meet stock, and is dropped where that takes more than this share of its depth in the
    /// blank.
    pub(super) fn cut_row(
        &self,
        row: PlannedRow,
        tool: &Tool,
        max_lift: Option<f64>,
        columns: &mut Columns,
        monitor: &Monitor,
    ) -> Result<CutRow, PlanError> {
        let top = BlankTop::new(&self.workpiece.blank);
        let rule = self.assembly_rule(tool);
        let place = |station| {
            monitor.check()?;
            let placed = self.place_cutter(station, tool);
            // In a blank above the shroud it depends on the earlier plunges.
            if self.workpiece.blank.outline().is_some() {
                return Ok(placed);
            }
            Ok(placed.and_then(|placed| {
                if PlungeColumn::new(placed.cutter, tool.radius(), &top).top > tool.overhang {
                    return Err(DropReason::Overhang);
                }
                let pose = (placed.cutter.tip, placed.cutter.axis);
                match rule.as_ref().and_then(|rule| rule.obstacle(pose)) {
                    Some(why) => Err(why),
                    None => Ok(placed),
                }
            }))
        };
        let mut placed = row
            .stations
            .par_iter()
            .map(place)
            .collect::<Result<Vec<Result<PlacedCutter, DropReason>>, Cancelled>>()?;
        if self.workpiece.blank.outline().is_some() {
            self.drop_hindered(&mut placed, tool, rule.as_ref(), columns, monitor)?;
        }
        let column = |placed: &PlacedCutter| PlungeColumn::new(placed.cutter, tool.core_radius(), &top);
        let deep: Vec<Option<PlungeColumn>> =
            placed.par_iter().map(|p| p.as_ref().ok().map(column)).collect();
        let Some(share) = max_lift else {
            columns.extend(deep.into_iter().flatten());
            return Ok(CutRow { row, placed });
        };
        // In parallel, as if all earlier plunges reached their full depth; then in sequence those that meet
        // stock and those near a plunge that was lifted or dropped.
        let first = columns.len();
        columns.extend(deep.iter().flatten().copied());
        let free: Vec<bool> = (first..columns.len())
            .into_par_iter()
            .map(|k| {
                let column = &columns.as_slice()[k];
                monitor.is_cancelled()
                    || planned_contact(column, columns.before(k), &self.workpiece.blank) == 0.0
            })
            .collect();
        columns.truncate(first);
        let mut changed: Vec<PlungeColumn> = Vec::new();
        let deep_ones =
            placed.iter_mut().zip(&deep).filter_map(|(place, deep)| Some((place, deep.as_ref()?)));
        for ((place, deep), free) in deep_ones.zip(free) {
            monitor.check()?;
            if free && !changed.iter().any(|other| deep.may_meet(&other.cutter)) {
                columns.push(*deep);
                continue;
            }
            let unlifted = std::mem::replace(place, Err(DropReason::Contact));
            *place = unlifted.and_then(|p| self.lift_clear(p, tool, share, columns.all(), &top));
            if !place.as_ref().is_ok_and(|placed| placed.lift == 0.0) {
                changed.push(*deep);
            }
            columns.extend(place.as_ref().ok().map(column));
        }
        Ok(CutRow { row, placed })
    }

    /// Drops the cutters of a row that cut deeper than the tool is long, or whose shank or holder is not
    /// clear, after the plunges of `columns` and those before them in the row.
    fn drop_hindered(
        &self,
        placed: &mut [Result<PlacedCutter, DropReason>],
        tool: &Tool,
        rule: Option<&AssemblyRule>,
        columns: &mut Columns,
        monitor: &Monitor,
    ) -> Result<(), Cancelled> {
        let top = BlankTop::new(&self.workpiece.blank);
        let first = columns.len();
        // What a plunge that is dropped would have removed stands for those after it.
        loop {
            let cutters = placed.iter().flatten().map(|placed| placed.cutter);
            columns.extend(cutters.map(|cutter| PlungeColumn::new(cutter, tool.radius(), &top)));
            let why: Vec<Option<DropReason>> = (first..columns.len())
                .into_par_iter()
                .map(|k| {
                    monitor.check()?;
                    let column = &columns.as_slice()[k];
                    if cuts_deeper_than(column, tool.overhang, columns.before(k), &self.workpiece.blank) {
                        return Ok(Some(DropReason::Overhang));
                    }
                    let pose = (column.cutter.tip, column.cutter.axis);
                    Ok(rule.and_then(|rule| rule.after(columns.before(k + 1)).obstacle(pose)))
                })
                .collect::<Result<_, Cancelled>>()?;
            columns.truncate(first);
            if why.iter().all(Option::is_none) {
                return Ok(());
            }
            for (place, why) in placed.iter_mut().filter(|place| place.is_ok()).zip(why) {
                if let Some(why) = why {
                    *place = Err(why);
                }
            }
        }
    }

    /// The cutter, lifted until its core is free of the stock that `earlier` plunges left.
    ///
    /// # Errors
    /// [`DropReason::Contact`] when that takes more than the share `max_lift` of its depth in the blank.
    fn lift_clear(
        &self,
        mut placed: PlacedCutter,
        tool: &Tool,
        max_lift: f64,
        earlier: Earlier,
        top: &BlankTop,
    ) -> Result<PlacedCutter, DropReason> {
        let unlifted = placed.cutter.tip;
        let depth = PlungeColumn::new(placed.cutter, tool.core_radius(), top).top;
        for _ in 0..MAX_LIFTS {
            let column = PlungeColumn::new(placed.cutter, tool.core_radius(), top);
            let contact = planned_contact(&column, earlier, &self.workpiece.blank);
            if contact == 0.0 {
                break;
            }
            let lift = (placed.cutter.tip - unlifted).norm() + contact;
            if lift >= max_lift * depth - LIFT_MARGIN {
                return Err(DropReason::Contact);
            }
            placed.cutter.tip += placed.cutter.axis * (contact + LIFT_MARGIN);
        }
        placed.lift = (placed.cutter.tip - unlifted).norm();
        if placed.lift > 0.0 {
            placed.hub_clearance = self.workpiece.finished.hub_clearance(&placed.cutter);
            placed.blade_clearance = self.workpiece.finished.blade_clearance(&placed.cutter);
        }
        Ok(placed)
    }

    /// Plans section `index` by `policy` after the plunges of `columns`.
    fn plan_section(
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

    pub(super) fn check_count(
        &self,
        positions: usize,
        tool: &Tool,
        place: SetupPlace,
    ) -> Result<(), PlanError> {
        if positions <= MAX_POSITIONS {
            return Ok(());
        }
        Err(too_many_positions(positions as f64, &self.setup.plunge, tool, place).into())
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
