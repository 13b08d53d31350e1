//! What the policies that plan row by row share: a section of rows, a start that is free of stock, and the
//! loop of stages 1 to 4 for one row. The policies `conventional`, `staircase` and `monotone` say which axes
//! the rows get.

use std::convert::Infallible;

use rayon::prelude::*;

use super::context::PlanContext;
use super::cut::{PlannedRow, SectionCut, cut_row};
use super::error::PlanError;
use super::locked::{cut_waiting, lock_into_row};
use super::reasons::DropReason;
use super::row::{RowMaker, Station};
use super::row_places::{row_ends, row_maker};
use super::section_layout::{RowLayout, StretchLayout};
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn, core_interferes};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::SetupPlace;

/// Iterations after which a row that still changes is reported as not converged.
const MAX_ITERATIONS: usize = 12;
/// Distances by which a start is moved out of the stock, tried in this order, in cutter radii.
pub(super) const START_RETREATS: [f64; 8] = [0.0, 0.1, 0.2, 0.35, 0.55, 0.8, 1.2, 1.8];

/// How a policy plans one row.
pub(super) type PlanRow = dyn Fn(&RowAttempts) -> Result<PlannedRow, PlanError> + Sync;

/// Plans section `index` after the plunges of `columns`: each row on its own by `plan_row`, then they are cut
/// one after the other. With `max_lift_share` plunges stop short of stock, see [`cut_row`].
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn cut_rows(
    context: &PlanContext,
    index: usize,
    columns: Columns,
    max_lift_share: Option<f64>,
    plan_row: &PlanRow,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    let section = context.section(index);
    let layouts = context.layouts(index)?;
    let tool = context.tool_of_section(index)?;
    let feed = section.direction();
    let rows = match plan_rows(context, index, layouts, &columns, plan_row, monitor) {
        Err(PlanError::Cancelled(_)) if monitor.is_stopped() => {
            return Ok(SectionCut::not_started(section, columns));
        }
        rows => rows?,
    };
    let mut cut = SectionCut::empty(feed, columns);
    let (mut waiting, closing) = (context.locked(index), &monitor.ignoring_stop());
    for row in rows {
        let before = cut.columns.len();
        let row = cut_row(context, row, tool, max_lift_share, &mut cut.columns, closing)?;
        let columns = (&mut cut.columns, before);
        let count = waiting.len();
        let row = lock_into_row(context, (tool, max_lift_share), row, columns, &mut waiting, closing)?;
        if waiting.len() < count {
            cut.rows.extend(row.split_where_axes_turn(context.setup.plunge.max_axis_change_rad));
        } else {
            cut.rows.push(row);
        }
    }
    cut_waiting(context, index, waiting, &mut cut, closing)?;
    Ok(cut)
}

/// Rows of section `index`, each planned on its own.
fn plan_rows(
    context: &PlanContext,
    index: usize,
    layouts: &[StretchLayout],
    earlier: &Columns,
    plan_row: &PlanRow,
    monitor: &Monitor,
) -> Result<Vec<PlannedRow>, PlanError> {
    let tool = context.tool_of_section(index)?;
    let feed = context.section(index).direction();
    let top = BlankTop::new(&context.workpiece.blank);
    let mut rows = Vec::new();
    for layout in layouts {
        let made: Vec<Result<Vec<PlannedRow>, PlanError>> = layout
            .rows
            .par_iter()
            .map(|row_layout| {
                let place = (row_layout.lambda, layout.rows.len());
                let maker = row_maker(context, layout, tool, place, feed, monitor);
                let ends = row_ends(context, index, &layout.stretch, feed.sign_along_s());
                let runs = row_layout.runs.get_or_make(ends.0, || maker.runs(ends.0, ends.1))?;
                let lambda = layout.stretch.lambda_in_channel(row_layout.lambda);
                let mut rows = Vec::with_capacity(runs.stretches.len());
                for &ends in &runs.stretches {
                    let row =
                        RowAttempts { context, maker: &maker, layout: row_layout, ends, earlier, top: &top };
                    rows.push(PlannedRow { lambda, ..plan_row(&row)? });
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

/// A row to plan: what all attempts at it share.
pub(super) struct RowAttempts<'r> {
    pub context: &'r PlanContext<'r>,
    pub maker: &'r RowMaker<'r>,
    layout: &'r RowLayout,
    /// First and last s in cutting order.
    ends: (f64, f64),
    earlier: &'r Columns,
    top: &'r BlankTop<'r>,
}

/// Start of a row.
#[derive(Clone, Copy)]
pub(super) struct RowStart {
    s: f64,
    pub first: Station,
    /// Whether the first core column is free up to the top of the blank.
    pub free: bool,
}

/// Whether positions of a row may interfere.
pub(super) enum Contacts<'c> {
    Allowed,
    /// The row ends at the first one; the number of positions before it is stored.
    None(&'c mut usize),
}

impl RowAttempts<'_> {
    /// Conventional stations from s = `start` on, cached.
    fn conventional(&self, start: f64) -> Result<Vec<Station>, Cancelled> {
        self.layout.conventional.get_or_make(start, || self.maker.conventional(start, self.ends.1))
    }

    /// The conventional station at `s`, cached.
    fn first(&self, s: f64) -> Option<Station> {
        let make = || Ok::<_, Infallible>(self.maker.isoparametric(s));
        let Ok(station) = self.layout.firsts.get_or_make(s, make);
        station
    }

    /// Moves the start of the row out of the stock until the core column of its first station is free. If no
    /// retreat frees it, the row starts at its original start. `None` if no axis exists there. `inclined`
    /// tilts the conventional first station for the retreat with the given index in [`START_RETREATS`].
    pub fn find_free_start(&self, mut inclined: impl FnMut(usize, Station) -> Station) -> Option<RowStart> {
        let maker = self.maker;
        let radius_s = maker.tool.radius() / self.context.workpiece.part.hub.length();
        let mut unmoved = None;
        for (retreat, radii) in START_RETREATS.into_iter().enumerate() {
            if maker.monitor.is_cancelled() {
                break;
            }
            let s = self.ends.0 + maker.direction_sign * radii * radius_s;
            let Some(first) = self.first(s) else { break };
            let first = inclined(retreat, first);
            let column = PlungeColumn::new(maker.cutter(&first), maker.tool.core_radius(), self.top);
            if !core_interferes(&column, self.earlier.all().near(&column), &self.context.workpiece.blank) {
                return Some(RowStart { s, first, free: true });
            }
            unmoved = unmoved.or(Some(RowStart { s, first, free: false }));
        }
        unmoved
    }

    /// Iterates stages 1 to 4 until no position is added. `optimised` gives the axes of the policy from the
    /// conventional stations, stage 3; it ends with `None` where the function that it is given, to be called
    /// with the row so far after each position, returns `false`. `None` when a position interferes and
    /// contacts are not allowed; in that case the first position must be free.
    ///
    /// # Errors
    /// When planning is cancelled, or part and setup do not match.
    pub fn converge(
        &self,
        start: &RowStart,
        mut contacts: Contacts,
        optimised: impl Fn(&[Station], &mut dyn FnMut(&[Station]) -> bool) -> Option<Vec<Station>>,
    ) -> Result<Option<PlannedRow>, PlanError> {
        let maker = self.maker;
        let monitor = maker.monitor;
        monitor.check()?;
        let mut conventional = self.conventional(start.s)?;
        let mut row = PlannedRow { converged: false, ..PlannedRow::empty(maker.lambda) };
        let mut known = self.cut_so_far();
        while row.iterations < MAX_ITERATIONS && !row.converged {
            row.iterations += 1;
            known.clear_row();
            let mut accept = |stations: &[Station]| {
                !monitor.is_cancelled()
                    && match &mut contacts {
                        Contacts::Allowed => true,
                        Contacts::None(reached) => {
                            let is_free = known.last_is_free(maker, stations);
                            **reached = stations.len() - usize::from(!is_free);
                            is_free
                        }
                    }
            };
            let stations = optimised(&conventional, &mut accept);
            monitor.check()?;
            let Some(stations) = stations else { return Ok(None) };
            row.stations = stations;
            row.converged = maker.inspect_steps(&row.stations, &mut conventional) == 0;
            self.context.check_count(conventional.len(), maker.tool, SetupPlace::Whole)?;
        }
        Ok(Some(row))
    }

    /// Number of interfering stations of the row.
    pub fn count_contacts(&self, stations: &[Station]) -> usize {
        let mut known = self.cut_so_far();
        (1..=stations.len()).filter(|&k| known.interferes(self.maker, &stations[..k])).count()
    }

    /// What is cut before the row.
    fn cut_so_far(&self) -> CutSoFar<'_> {
        CutSoFar::new(self.earlier, &self.context.workpiece.blank, self.top)
    }
}

/// Plunges cut before the next position of a row: earlier sections and the row so far.
struct CutSoFar<'e> {
    earlier: &'e Columns,
    row: Columns,
    blank: &'e Blank,
    top: &'e BlankTop<'e>,
}

impl<'e> CutSoFar<'e> {
    fn new(earlier: &'e Columns, blank: &'e Blank, top: &'e BlankTop<'e>) -> Self {
        Self { earlier, row: Columns::default(), blank, top }
    }

    /// Clears the row.
    fn clear_row(&mut self) {
        self.row = Columns::default();
    }

    /// Whether the last of `stations` interferes; adds it to the row.
    fn interferes(&mut self, maker: &RowMaker, stations: &[Station]) -> bool {
        let Some(last) = stations.last() else { return false };
        let column = PlungeColumn::new(maker.cutter(last), maker.tool.core_radius(), self.top);
        let before = self.earlier.all().near(&column).chain(self.row.all().near(&column));
        let interferes = core_interferes(&column, before, self.blank);
        self.row.push(column);
        interferes
    }

    /// Whether the last of `stations` is free, given that the first one is; adds it to the row.
    fn last_is_free(&mut self, maker: &RowMaker, stations: &[Station]) -> bool {
        if let [first] = stations {
            self.row.push(PlungeColumn::new(maker.cutter(first), maker.tool.core_radius(), self.top));
            return true;
        }
        !self.interferes(maker, stations)
    }
}
