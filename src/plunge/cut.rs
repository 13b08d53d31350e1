//! Rows and sections as they are cut: every cutter at its final depth, free of the hub allowance and, where
//! the policy asks for it, lifted until its core is free of stock.

use rayon::prelude::*;

use super::assembly::{AssemblyRule, DropCause};
use super::context::PlanContext;
use super::error::PlanError;
use super::placed_cutter::PlacedCutter;
use super::reasons::{AddedPlunges, DropReason};
use super::row::Station;
use crate::cutting::contact::{BlankTop, Columns, Earlier, PlungeColumn, cuts_deeper_than, planned_contact};
use crate::geometry::{CutterSolid, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::setup::{CutDirection, SectionSetup, Tool};

/// Maximum number of lifts of one plunge; contact that remains is reported as interference.
const MAX_LIFTS: usize = 8;
/// Maximum number of raises of a cutter to the hub allowance; each is twice as much per missing depth.
const MAX_RAISES: u32 = 12;
/// First raise, in missing depths: on an axis oblique to the hub it gains less clearance than its length.
const RAISE_PER_DEPTH: f64 = 1.2;
/// Least raise, mm: where rounding is all that is missing.
const MIN_RAISE_MM: f64 = 1e-9;
/// Rounding of clearances from the blades, mm, that drops no station.
const CLEARANCE_ROUNDING_MM: f64 = 1e-6;
/// Share of the places of a section that contact leaves without a plunge where its rows starve.
const STARVED_SHARE: f64 = 2.0 / 3.0;
/// Gap left between a lifted core and the stock below it, mm.
pub(super) const CORE_GAP_MM: f64 = 1e-3;

/// One row, planned.
#[derive(Clone, Debug)]
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

/// A station of a row, and what became of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutStation {
    pub station: Station,
    /// The placed cutter, or why the station is dropped.
    pub placed: Result<PlacedCutter, DropReason>,
}

/// A planned row with the final position of every cutter.
#[derive(Debug)]
pub(super) struct CutRow {
    pub stations: Vec<CutStation>,
    pub lambda: f64,
    pub iterations: usize,
    pub converged: bool,
    /// See [`PlannedRow::missing`].
    pub missing: Vec<(f64, DropCause)>,
}

impl CutRow {
    /// `row` with what became of each of its stations.
    pub fn new(row: PlannedRow, placed: impl IntoIterator<Item = Result<PlacedCutter, DropReason>>) -> Self {
        let PlannedRow { stations, lambda, iterations, converged, missing } = row;
        let stations = stations.into_iter().zip(placed);
        let stations = stations.map(|(station, placed)| CutStation { station, placed }).collect();
        Self { stations, lambda, iterations, converged, missing }
    }

    /// The row as it was planned.
    pub fn planned(&self) -> PlannedRow {
        let Self { lambda, iterations, converged, .. } = *self;
        let stations = self.stations.iter().map(|at| at.station).collect();
        PlannedRow { stations, lambda, iterations, converged, missing: self.missing.clone() }
    }

    /// Number of positions, without the dropped ones.
    pub fn len(&self) -> usize {
        self.kept_stations().count()
    }

    /// The cutters of the positions, without the dropped ones.
    pub fn cutters(&self) -> impl Iterator<Item = &CutterSolid> {
        self.stations.iter().filter_map(|at| at.placed.as_ref().ok()).map(|placed| &placed.cutter)
    }

    /// The row turned about Z by `angle_rad`.
    pub fn turned(&self, angle_rad: f64) -> Self {
        let turned = |placed: PlacedCutter| {
            let CutterSolid { tip, axis, .. } = placed.cutter;
            let (tip, axis) = (rotate_z(&tip, angle_rad), rotate_vector_z(&axis, angle_rad));
            PlacedCutter { cutter: CutterSolid { tip, axis, ..placed.cutter }, ..placed }
        };
        let stations = self
            .stations
            .iter()
            .map(|at| CutStation { station: at.station.turned(angle_rad), placed: at.placed.map(turned) });
        Self { stations: stations.collect(), missing: self.missing.clone(), ..*self }
    }

    /// Lift of the plunge at an s of the hub, mm; `None` where there is none or it is dropped.
    pub fn lift_at(&self, s_hub: f64) -> Option<f64> {
        let is_there = |at: &&CutStation| (at.station.ends.s_hub - s_hub).abs() < 1e-9;
        self.stations.iter().find(is_there)?.placed.ok().map(|placed| placed.lift)
    }

    /// Removes those missing or dropped places for which `is_cut`(λ, s) is true.
    pub fn forget_open(&mut self, is_cut: impl Fn(f64, f64) -> bool) {
        let lambda = self.lambda;
        self.missing.retain(|(s, _)| !is_cut(lambda, *s));
        self.stations.retain(|at| at.placed.is_ok() || !is_cut(lambda, at.station.ends.s_hub));
    }

    /// The stations that are not dropped.
    pub fn kept_stations(&self) -> impl Iterator<Item = &Station> {
        self.stations.iter().filter(|at| at.placed.is_ok()).map(|at| &at.station)
    }

    /// The row without its dropped stations.
    pub fn without_dropped(mut self) -> Self {
        self.stations.retain(|at| at.placed.is_ok());
        self
    }

    /// The same positions in the same order, with a new row wherever the axis turns by more than
    /// `max_turn_rad` between two consecutive positions that are not dropped.
    pub fn split_where_axes_turn(self, max_turn_rad: f64) -> Vec<Self> {
        let Self { stations, lambda, iterations, converged, missing } = self;
        let row = |missing| Self { stations: Vec::new(), lambda, iterations, converged, missing };
        let mut rows = vec![row(missing)];
        let mut last: Option<Vector> = None;
        for at in stations {
            if let Ok(placed) = &at.placed {
                let axis = placed.cutter.axis;
                if last.is_some_and(|last| last.angle(&axis) > max_turn_rad) {
                    rows.push(row(Vec::new()));
                }
                last = Some(axis);
            }
            if let Some(row) = rows.last_mut() {
                row.stations.push(at);
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
    /// See [`SectionPlan::added`](super::plan::SectionPlan::added).
    pub added: Option<AddedPlunges>,
}

impl SectionCut {
    /// A section without rows, to be cut after the plunges of `columns`.
    pub fn empty(feed: CutDirection, columns: Columns) -> Self {
        Self { feed, rows: Vec::new(), columns, added: None }
    }

    /// As [`Self::empty`], for a section that planning did not reach before it was stopped.
    pub fn not_started(section: &SectionSetup, columns: Columns) -> Self {
        let feed = section.direction();
        Self { added: Some(AddedPlunges::UNFINISHED), ..Self::empty(feed, columns) }
    }

    /// Records that the row at `lambda` has no position at the s in `missing`.
    pub fn note_missing(&mut self, lambda: f64, missing: Vec<(f64, DropCause)>) {
        if !missing.is_empty() {
            self.rows.push(CutRow::new(PlannedRow { missing, ..PlannedRow::empty(lambda) }, []));
        }
    }

    /// Removes what was dropped from the rows from index `first` on, which were added: an added plunge that
    /// is dropped is not reported as missing. Returns the number of plunges that remain in them.
    pub fn drop_hindered_rows(&mut self, first: usize) -> usize {
        let added: Vec<CutRow> = self.rows.drain(first..).collect();
        self.rows.extend(added.into_iter().map(CutRow::without_dropped).filter(|row| row.len() > 0));
        self.rows[first..].iter().map(CutRow::len).sum()
    }

    /// Whether contact left most places of its rows without a plunge: behind them no core is free either, and
    /// a smaller cutter finds as few.
    pub fn is_starved(&self) -> bool {
        let contact = |row: &CutRow| {
            let missing = row.missing.iter().filter(|(_, cause)| cause.why == DropReason::Contact);
            let dropped = row.stations.iter().filter(|at| matches!(at.placed, Err(DropReason::Contact)));
            missing.count() + dropped.count()
        };
        let placed: usize = self.rows.iter().map(CutRow::len).sum();
        let starved: usize = self.rows.iter().map(contact).sum();
        !self.columns.is_empty() && starved as f64 > STARVED_SHARE * (starved + placed) as f64
    }

    /// Whether planning was stopped before the section was finished.
    pub fn is_unfinished(&self) -> bool {
        self.added.is_some_and(AddedPlunges::is_unfinished)
    }
}

/// `cutter`, raised along its axis where it violates the hub allowance by rounding, and its clearance from
/// the finished hub, mm.
pub(super) fn raise_to_allowance(context: &PlanContext, mut cutter: CutterSolid) -> (CutterSolid, f64) {
    let mut hub_clearance = context.workpiece.finished.hub_clearance(&cutter);
    for doubling in 0..MAX_RAISES {
        let deep = context.setup.allowances.hub_allowance - hub_clearance;
        if deep <= 0.0 {
            break;
        }
        cutter.tip += cutter.axis * (RAISE_PER_DEPTH * deep * f64::from(1 << doubling) + MIN_RAISE_MM);
        hub_clearance = context.workpiece.finished.hub_clearance(&cutter);
    }
    (cutter, hub_clearance)
}

/// The cutter of a station with its measured clearances to the finished part, if the machine reaches its
/// axis. Lifts the bottom where it violates the hub allowance by rounding.
fn place_cutter(context: &PlanContext, station: &Station, tool: &Tool) -> Result<PlacedCutter, DropReason> {
    if context.setup.machine.excess_tilt_rad(&context.workpiece.part, &station.axis) > 0.0 {
        return Err(DropReason::Machine);
    }
    let stock = &context.setup.allowances;
    let (cutter, hub_clearance) = raise_to_allowance(context, tool.placed(station.tip, station.axis));
    let blade_clearance = context.workpiece.finished.blade_clearance(&cutter);
    if blade_clearance < stock.blade_allowance - CLEARANCE_ROUNDING_MM {
        return Err(DropReason::Blades);
    }
    Ok(PlacedCutter { cutter, hub_clearance, blade_clearance, lift: 0.0 })
}

/// Places the cutters of a row and adds them to `columns`. With `max_lift_share` each plunge stops short
/// where its core would meet stock, and is dropped where that takes more than this share of its depth in
/// the blank.
pub(super) fn cut_row(
    context: &PlanContext,
    row: PlannedRow,
    tool: &Tool,
    max_lift_share: Option<f64>,
    columns: &mut Columns,
    monitor: &Monitor,
) -> Result<CutRow, PlanError> {
    cut_row_around(context, row, tool, max_lift_share, &[], columns, monitor)
}

/// As [`cut_row`]; the cutters of `fixed`, with the numbers of their stations, are placed already and are
/// neither lifted nor dropped.
pub(super) fn cut_row_around(
    context: &PlanContext,
    row: PlannedRow,
    tool: &Tool,
    max_lift_share: Option<f64>,
    fixed: &[(usize, PlacedCutter)],
    columns: &mut Columns,
    monitor: &Monitor,
) -> Result<CutRow, PlanError> {
    let top = BlankTop::new(&context.workpiece.blank);
    let rule = context.assembly_rule(tool);
    let place = |station| {
        monitor.check()?;
        let placed = place_cutter(context, station, tool);
        // In a blank that stands above the shroud the depth of the plunge depends on the earlier ones:
        // `drop_hindered` checks it.
        if context.workpiece.blank.outline().is_some() {
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
    if context.workpiece.blank.outline().is_some() {
        drop_hindered(context, &mut placed, tool, rule.as_ref(), columns, monitor)?;
    }
    for &(k, cutter) in fixed {
        placed[k] = Ok(cutter);
    }
    let column = |placed: &PlacedCutter| PlungeColumn::new(placed.cutter, tool.core_radius(), &top);
    let deep: Vec<Option<PlungeColumn>> = placed.par_iter().map(|p| p.as_ref().ok().map(column)).collect();
    let Some(share) = max_lift_share else {
        columns.extend(deep.into_iter().flatten());
        return Ok(CutRow::new(row, placed));
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
                || planned_contact(column, columns.before(k), &context.workpiece.blank) == 0.0
        })
        .collect();
    columns.truncate(first);
    let mut changed: Vec<PlungeColumn> = Vec::new();
    let is_fixed = |k: usize| fixed.iter().any(|(fixed, _)| *fixed == k);
    let deep_ones = placed.iter_mut().zip(&deep).enumerate();
    let deep_ones = deep_ones.filter_map(|(k, (place, deep))| Some((is_fixed(k), place, deep.as_ref()?)));
    for ((is_fixed, place, deep), free) in deep_ones.zip(free) {
        monitor.check()?;
        if is_fixed || free && !changed.iter().any(|other| deep.may_meet(&other.cutter)) {
            columns.push(*deep);
            continue;
        }
        let unlifted = std::mem::replace(place, Err(DropReason::Contact));
        *place = unlifted.and_then(|p| lift_clear(context, p, tool, share, columns.all(), &top));
        if !place.as_ref().is_ok_and(|placed| placed.lift == 0.0) {
            changed.push(*deep);
        }
        columns.extend(place.as_ref().ok().map(column));
    }
    Ok(CutRow::new(row, placed))
}

/// Drops the cutters of a row that cut deeper than the tool is long, or whose shank or holder is not
/// clear, after the plunges of `columns` and those before them in the row.
fn drop_hindered(
    context: &PlanContext,
    placed: &mut [Result<PlacedCutter, DropReason>],
    tool: &Tool,
    rule: Option<&AssemblyRule>,
    columns: &mut Columns,
    monitor: &Monitor,
) -> Result<(), Cancelled> {
    let top = BlankTop::new(&context.workpiece.blank);
    let first = columns.len();
    // Repeated until no plunge is dropped: stock that a dropped one would have removed is in the way of those
    // after it.
    loop {
        let cutters = placed.iter().flatten().map(|placed| placed.cutter);
        columns.extend(cutters.map(|cutter| PlungeColumn::new(cutter, tool.radius(), &top)));
        let why: Vec<Option<DropReason>> = (first..columns.len())
            .into_par_iter()
            .map(|k| {
                monitor.check()?;
                let column = &columns.as_slice()[k];
                if cuts_deeper_than(column, tool.overhang, columns.before(k), &context.workpiece.blank) {
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
/// [`DropReason::Contact`] when that takes more than the share `max_lift_share` of its depth in the blank.
fn lift_clear(
    context: &PlanContext,
    mut placed: PlacedCutter,
    tool: &Tool,
    max_lift_share: f64,
    earlier: Earlier,
    top: &BlankTop,
) -> Result<PlacedCutter, DropReason> {
    let unlifted = placed.cutter.tip;
    let depth = PlungeColumn::new(placed.cutter, tool.core_radius(), top).top;
    for _ in 0..MAX_LIFTS {
        let column = PlungeColumn::new(placed.cutter, tool.core_radius(), top);
        let contact = planned_contact(&column, earlier, &context.workpiece.blank);
        if contact == 0.0 {
            break;
        }
        let lift = (placed.cutter.tip - unlifted).norm() + contact;
        if lift >= max_lift_share * depth - CORE_GAP_MM {
            return Err(DropReason::Contact);
        }
        placed.cutter.tip += placed.cutter.axis * (contact + CORE_GAP_MM);
    }
    placed.lift = (placed.cutter.tip - unlifted).norm();
    if placed.lift > 0.0 {
        placed.hub_clearance = context.workpiece.finished.hub_clearance(&placed.cutter);
        placed.blade_clearance = context.workpiece.finished.blade_clearance(&placed.cutter);
    }
    Ok(placed)
}
