//! The policy `monotone`: stage 3 by the rule of [plunge paper], axis optimisation, step 3: α grows from
//! position to position in cutting order.
//!
//! The first position of a row stays unchanged (or gets a minimum lead angle). Then every W moves along the
//! row's shroud curve, against the cutting direction, by the smallest amount for which α exceeds that of the
//! previous position. The paper walks a discretisation of that curve in steps of 1e-5; here the amount is
//! found by bracketing and root finding.

use super::context::PlanContext;
use super::cut::{PlannedRow, SectionCut};
use super::error::PlanError;
use super::reasons::Blocked;
use super::row::{RowMaker, Station};
use super::row_plan::{Contacts, RowAttempts, RowStart, START_RETREATS, cut_rows};
use crate::cutting::contact::Columns;
use crate::geometry::search;
use crate::monitor::Monitor;

/// Minimum growth of α, rad: it makes "greater" well defined in floating point.
pub const MIN_GROWTH_RAD: f64 = 1e-9;
/// Tolerance of the position of W on the shroud curve, as a fraction of its length.
const SHROUD_TOLERANCE: f64 = 1e-6;
/// Distance by which W may pass the trimmed ends of the shroud curve, in s.
const SHROUD_OVERRUN: f64 = 0.5;

/// Minimum lead angles of the first position that are tried after the unchanged one, degrees.
const START_LEADS_DEG: [f64; 17] =
    [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 18.0, 20.0];
/// Number of starts with which a row is planned to its end where none frees it of contact.
const MAX_FINISHED_STARTS: usize = 4;

/// Plans section `index` after the plunges of `columns`.
///
/// # Errors
/// As [`Planner::plan`](super::Planner::plan).
pub(super) fn plan_section(
    context: &PlanContext,
    index: usize,
    columns: Columns,
    monitor: &Monitor,
) -> Result<SectionCut, PlanError> {
    cut_rows(context, index, columns, None, &plan_row, monitor)
}

/// Plans one row. The first position stays unchanged if the row is then free of contact; otherwise its lead
/// angle is raised to the smallest of some fixed angles that frees the row, or else the start with the fewest
/// contacts is taken.
fn plan_row(row: &RowAttempts) -> Result<PlannedRow, PlanError> {
    let maker = row.maker;
    let max_tilt_rad = row.context.setup.plunge.max_tilt_rad;
    let from = |start: &RowStart, contacts: Contacts| {
        row.converge(start, contacts, |conventional, accept| {
            let rest = conventional.get(1..).unwrap_or_default();
            maker.monotone_after(start.first, rest, max_tilt_rad, accept)
        })
    };
    // For each retreat: shift of W that the previous lead angle needed, in s.
    let mut moved_s = [0.0; START_RETREATS.len()];
    // Starts with the number of positions that each got free of contact.
    let mut tried: Vec<(usize, RowStart)> = Vec::new();
    for lead_rad in std::iter::once(None).chain(START_LEADS_DEG.iter().map(|d| Some(d.to_radians()))) {
        maker.monitor.check()?;
        let start = row.find_free_start(|retreat, first| {
            let Some(lead_rad) = lead_rad else { return first };
            let first = maker.with_min_lead_angle(&first, lead_rad, moved_s[retreat], max_tilt_rad);
            moved_s[retreat] = first.shroud_shift();
            first
        });
        let Some(start) = start else { continue };
        // Below the jump of α from rear to front contact all lead angles give the same start.
        if tried.iter().any(|(_, t)| same_axis(&t.first, &start.first)) {
            continue;
        }
        let mut reached = 0;
        if start.free
            && let Some(planned) = from(&start, Contacts::None(&mut reached))?
        {
            return Ok(planned);
        }
        tried.push((reached, start));
    }
    // No start frees the row: of those that got furthest, take the one with the fewest contacts. The sort is
    // stable: of equal ones the smaller lead angle comes first.
    tried.sort_by_key(|(reached, _)| std::cmp::Reverse(*reached));
    tried.truncate(MAX_FINISHED_STARTS);
    let mut best: Option<(usize, PlannedRow)> = None;
    for (_, start) in &tried {
        if let Some(planned) = from(start, Contacts::Allowed)? {
            let contacts = row.count_contacts(&planned.stations);
            if best.as_ref().is_none_or(|b| contacts < b.0) {
                best = Some((contacts, planned));
            }
        }
    }
    Ok(best.map_or_else(|| PlannedRow::empty(maker.lambda), |b| b.1))
}

/// Whether two stations have the same tip within 1e-4 mm and the same axis.
fn same_axis(a: &Station, b: &Station) -> bool {
    (a.tip - b.tip).norm() < 1e-4 && (a.axis - b.axis).norm() < 1e-6
}

impl RowMaker<'_> {
    /// Lead angle, rad: α in cutting direction, positive when the axis is inclined towards the uncut side.
    fn lead_angle(&self, station: &Station) -> f64 {
        station.alpha_rad * self.direction_sign
    }

    /// Applies the rule to a conventional row. `start_rad` is the minimum lead angle of the first position,
    /// `None` to leave it unchanged. Axes are inclined by at most `max_tilt_rad` from the conventional
    /// ones. `accept` is called with the row so far after each position; `None` when it returns `false`.
    pub fn monotone(
        &self,
        conventional: &[Station],
        start_rad: Option<f64>,
        max_tilt_rad: f64,
        accept: &mut dyn FnMut(&[Station]) -> bool,
    ) -> Option<Vec<Station>> {
        let Some((first, rest)) = conventional.split_first() else { return Some(Vec::new()) };
        let first =
            start_rad.map_or(*first, |lead_rad| self.with_min_lead_angle(first, lead_rad, 0.0, max_tilt_rad));
        self.monotone_after(first, rest, max_tilt_rad, accept)
    }

    /// As [`Self::monotone`], with a final `first` position and the conventional `rest`.
    pub fn monotone_after(
        &self,
        first: Station,
        rest: &[Station],
        max_tilt_rad: f64,
        accept: &mut dyn FnMut(&[Station]) -> bool,
    ) -> Option<Vec<Station>> {
        let mut row: Vec<Station> = Vec::with_capacity(rest.len() + 1);
        row.push(first);
        let mut previous = first;
        for station in rest {
            if !accept(&row) {
                return None;
            }
            let min_lead_rad = self.lead_angle(&previous) + MIN_GROWTH_RAD;
            previous = self.with_min_lead_angle(station, min_lead_rad, previous.shroud_shift(), max_tilt_rad);
            row.push(previous);
        }
        accept(&row).then_some(row)
    }

    /// The station with W moved by the smallest amount for which its lead angle is at least `min_lead_rad`.
    /// Where that is impossible, the last one that blades, shroud and tilt limit allow, marked as blocked.
    /// `likely_s` is the amount the neighbour needed: the first guess of the bracket.
    pub fn with_min_lead_angle(
        &self,
        from: &Station,
        min_lead_rad: f64,
        likely_s: f64,
        max_tilt_rad: f64,
    ) -> Station {
        if self.lead_angle(from) >= min_lead_rad {
            return *from;
        }
        let moved = |amount: f64| -> Result<Station, Blocked> {
            let s_shroud = from.s_shroud_conventional - amount * self.direction_sign;
            if !(-SHROUD_OVERRUN..=1.0 + SHROUD_OVERRUN).contains(&s_shroud) {
                return Err(Blocked::ShroudEnd);
            }
            let station = self.draft(from.ends.s_hub, s_shroud).ok_or(Blocked::Walls)?;
            if station.axis.angle(&from.axis) > max_tilt_rad {
                return Err(Blocked::TiltLimit);
            }
            Ok(Station { s_shroud_conventional: from.s_shroud_conventional, ..station })
        };
        // The bracket holds (amount, lead angle minus `min_lead_rad`): drafts are cheap to compute again.
        let excess = |amount: f64| moved(amount).map(|s| self.lead_angle(&s) - min_lead_rad);
        let unit = 1.0 / self.part.shroud.length();
        let mut low = (0.0, self.lead_angle(from) - min_lead_rad);
        let mut step = likely_s.max(0.5 * unit);
        let mut stride = (0.02 * likely_s).max(0.3 * unit);
        let high = loop {
            match excess(step) {
                Ok(more) if more >= 0.0 => break (step, more),
                Ok(less) => {
                    low = (step, less);
                    step += stride;
                    stride *= 1.7;
                }
                Err(_) if step - low.0 > 1e-4 => {
                    step = 0.5 * (low.0 + step);
                    stride = 0.25 * (step - low.0);
                }
                Err(why) => {
                    let last = moved(low.0).ok().and_then(|s| self.exact(&s));
                    return Station { blocked: Some(why), ..last.unwrap_or(*from) };
                }
            }
        };
        if low.0 == 0.0
            && high.0 > 2.0 * stride
            && let Some(less) = excess(high.0 - stride).ok().filter(|&less| less < 0.0)
        {
            low = (high.0 - stride, less);
        }
        let guess = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let missing = |amount: f64| excess(amount).unwrap_or(f64::NEG_INFINITY);
        let root = search::root_from(missing, low, high, guess, SHROUD_TOLERANCE);
        // The exact wall axis shifts α a little: increase the amount until it suffices.
        let mut amount = root;
        let mut nudge = SHROUD_TOLERANCE;
        for _ in 0..24 {
            if let Some(station) = moved(amount).ok().and_then(|s| self.exact(&s))
                && self.lead_angle(&station) >= min_lead_rad
            {
                return station;
            }
            amount += nudge;
            nudge *= 2.0;
        }
        Station { blocked: Some(Blocked::Walls), ..*from }
    }
}
