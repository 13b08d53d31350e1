//! Rows of the policies `conventional` and `monotone`: search for a start that is free of stock, and the loop
//! of stages 1 to 4 for one row.

use std::convert::Infallible;

use super::cut::PlannedRow;
use super::cycle::{PlanError, Planner};
use super::row::{RowMaker, Station};
use super::section_layout::RowLayout;
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn, core_interferes};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::{AxisPolicy, SetupPlace};

/// Iterations after which a row that still changes is reported as not converged.
const MAX_ITERATIONS: usize = 12;
/// Minimum lead angles of the first position that `monotone` tries after the unchanged one, degrees.
const START_LEADS_DEG: [f64; 17] =
    [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 18.0, 20.0];
/// Distances by which a start is moved out of the stock, tried in this order, in cutter radii.
const START_RETREATS: [f64; 8] = [0.0, 0.1, 0.2, 0.35, 0.55, 0.8, 1.2, 1.8];

/// Number of starts with which a row is planned to its end where none frees it of contact.
const MAX_FINISHED_STARTS: usize = 4;

/// What all attempts at one row share.
struct RowAttempts<'r> {
    maker: &'r RowMaker<'r>,
    layout: &'r RowLayout,
    /// Last s in cutting order.
    end: f64,
    earlier: &'r Columns,
    top: &'r BlankTop<'r>,
}

impl RowAttempts<'_> {
    /// Conventional stations from s = `start` on, cached.
    fn conventional(&self, start: f64) -> Result<Vec<Station>, Cancelled> {
        self.layout.conventional.get_or_make(start, || self.maker.conventional(start, self.end))
    }

    /// The conventional station at `s`, cached.
    fn first(&self, s: f64) -> Option<Station> {
        let make = || Ok::<_, Infallible>(self.maker.isoparametric(s));
        let Ok(station) = self.layout.firsts.get_or_make(s, make);
        station
    }
}

/// Start of a row.
#[derive(Clone, Copy)]
struct RowStart {
    s: f64,
    first: Station,
    /// Whether the first core column is free up to the top of the blank.
    free: bool,
}

/// Whether positions of a row may interfere.
enum Contacts<'c> {
    Allowed,
    /// The row ends at the first one; the number of positions before it is stored.
    None(&'c mut usize),
}

/// Whether two stations have the same tip within 1e-4 mm and the same axis.
fn same_axis(a: &Station, b: &Station) -> bool {
    (a.tip - b.tip).norm() < 1e-4 && (a.axis - b.axis).norm() < 1e-6
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

impl Planner<'_> {
    /// Plans one row by `policy`. For `monotone` the first position stays unchanged if the row is then free
    /// of contact; otherwise its lead angle is raised to the smallest of some fixed angles that frees the
    /// row, or else the start with the fewest contacts is taken.
    pub(super) fn plan_row(
        &self,
        maker: &RowMaker,
        layout: &RowLayout,
        ends: (f64, f64),
        policy: AxisPolicy,
        earlier: &Columns,
        monitor: &Monitor,
    ) -> Result<PlannedRow, PlanError> {
        let top = BlankTop::new(&self.workpiece.blank);
        let attempts = RowAttempts { maker, layout, end: ends.1, earlier, top: &top };
        // For each retreat: shift of W that the previous lead angle needed, in s.
        let mut moved = [0.0; START_RETREATS.len()];
        if policy == AxisPolicy::Conventional {
            let Some(start) = self.find_free_start(&attempts, ends.0, None, &mut moved) else {
                monitor.check()?;
                return Ok(PlannedRow::empty(maker.lambda));
            };
            let row = self.converge_row(&attempts, policy, &start, Contacts::Allowed, monitor)?;
            return Ok(row.unwrap_or_else(|| PlannedRow::empty(maker.lambda)));
        }
        let leads = std::iter::once(None).chain(START_LEADS_DEG.iter().map(|d| Some(d.to_radians())));
        // Starts with the number of positions that each got free of contact.
        let mut tried: Vec<(usize, RowStart)> = Vec::new();
        for lead_rad in leads {
            monitor.check()?;
            let Some(start) = self.find_free_start(&attempts, ends.0, lead_rad, &mut moved) else { continue };
            // Below the jump of α from rear to front contact all lead angles give the same start.
            if tried.iter().any(|(_, t)| same_axis(&t.first, &start.first)) {
                continue;
            }
            let mut reached = 0;
            if start.free
                && let Some(row) =
                    self.converge_row(&attempts, policy, &start, Contacts::None(&mut reached), monitor)?
            {
                return Ok(row);
            }
            tried.push((reached, start));
        }
        // No start frees the row: of those that got furthest, take the one with the fewest contacts. The sort
        // is stable: of equal ones the smaller lead angle comes first.
        tried.sort_by_key(|(reached, _)| std::cmp::Reverse(*reached));
        tried.truncate(MAX_FINISHED_STARTS);
        let mut best: Option<(usize, PlannedRow)> = None;
        for (_, start) in &tried {
            if let Some(row) = self.converge_row(&attempts, policy, start, Contacts::Allowed, monitor)? {
                let contacts = self.count_contacts(&attempts, &row.stations);
                if best.as_ref().is_none_or(|b| contacts < b.0) {
                    best = Some((contacts, row));
                }
            }
        }
        Ok(best.map_or_else(|| PlannedRow::empty(maker.lambda), |b| b.1))
    }

    /// Iterates stages 1 to 4 until no position is added. `None` when a position interferes and contacts are
    /// not allowed; in that case the first position must be free.
    fn converge_row(
        &self,
        attempts: &RowAttempts,
        policy: AxisPolicy,
        start: &RowStart,
        mut contacts: Contacts,
        monitor: &Monitor,
    ) -> Result<Option<PlannedRow>, PlanError> {
        monitor.check()?;
        let max_tilt = self.setup.plunge.max_tilt_rad;
        let maker = attempts.maker;
        let mut conventional = attempts.conventional(start.s)?;
        let mut row = PlannedRow { converged: false, ..PlannedRow::empty(maker.lambda) };
        let mut known = CutSoFar::new(attempts.earlier, &self.workpiece.blank, attempts.top);
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
            let optimised = match policy {
                AxisPolicy::Monotone => {
                    let rest = conventional.get(1..).unwrap_or_default();
                    maker.monotone_after(start.first, rest, max_tilt, &mut accept)
                }
                _ => Some(conventional.clone()),
            };
            monitor.check()?;
            let Some(stations) = optimised else { return Ok(None) };
            row.stations = stations;
            row.converged = maker.inspect_steps(&row.stations, &mut conventional) == 0;
            self.check_count(conventional.len(), maker.tool, SetupPlace::Whole)?;
        }
        Ok(Some(row))
    }

    /// Moves the start of a row, with a lead angle of at least `lead_rad` (rad), out of the stock until its
    /// first core column is free; unmoved where no retreat frees it. `None` where there is no axis. `moved`
    /// holds the shifts of W for a smaller lead angle, in s, and is updated.
    fn find_free_start(
        &self,
        attempts: &RowAttempts,
        start: f64,
        lead_rad: Option<f64>,
        moved: &mut [f64; START_RETREATS.len()],
    ) -> Option<RowStart> {
        let maker = attempts.maker;
        let radius_s = maker.tool.radius() / self.workpiece.part.hub.length();
        let mut unmoved = None;
        for (radii, moved) in START_RETREATS.into_iter().zip(moved) {
            if maker.monitor.is_cancelled() {
                break;
            }
            let s = start + maker.direction_sign * radii * radius_s;
            let Some(mut first) = attempts.first(s) else { break };
            if let Some(lead_rad) = lead_rad {
                first = maker.with_min_lead_angle(&first, lead_rad, *moved, self.setup.plunge.max_tilt_rad);
                *moved = first.shroud_shift();
            }
            let column = PlungeColumn::new(maker.cutter(&first), maker.tool.core_radius(), attempts.top);
            if !core_interferes(&column, attempts.earlier.all().near(&column), &self.workpiece.blank) {
                return Some(RowStart { s, first, free: true });
            }
            unmoved = unmoved.or(Some(RowStart { s, first, free: false }));
        }
        unmoved
    }

    /// Number of interfering stations of a row.
    fn count_contacts(&self, attempts: &RowAttempts, stations: &[Station]) -> usize {
        let mut known = CutSoFar::new(attempts.earlier, &self.workpiece.blank, attempts.top);
        (1..=stations.len()).filter(|&k| known.interferes(attempts.maker, &stations[..k])).count()
    }
}
