//! More plunges where a section's rows left the most: between positions, between rows, and under walls that lean
//! over the channel.
//!
//! From a pool of axes, finer than the rows and free to lean from the wall's axis to upright, the one that takes
//! most is added, again and again. Each is free of contact after the rows alone, so that they may be cut in any order.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::candidate::CandidateMaker;
use super::floor::Floor;
use crate::geometry::CutterSolid;
use crate::monitor::Cancelled;
use crate::part::Blank;
use crate::plunge::contact::{Column, ContactSearch};
use crate::plunge::row::{RowMaker, Station};

/// Feed tilts tried: from, apart, degrees, and how many.
const TILT_FROM_DEG: f64 = -9.0;
const TILT_STEP_DEG: f64 = 3.0;
const TILTS: usize = 10;
/// Least gain of a plunge, as the thickness of a layer under the whole of its bottom, in cutter radii.
const LEAST_GAIN_RADII: f64 = 0.0005;
/// Most a plunge may stop short, as a share of what it would lower the stock by, and in cutter radii.
const MOST_LIFT_SHARE: f64 = 0.7;
/// See [`MOST_LIFT_SHARE`].
const MOST_LIFT_RADII: f64 = 0.3;
/// Ways to lean sideways, as shares of the way from the row's own lean to upright: all, and those that tell whether a
/// place is worth looking at; the share of the least gain that makes it so.
const FAN_SHARES: [f64; 5] = [1.0, 0.7, 0.4, 0.0, 1.4];
/// See [`FAN_SHARES`].
const COARSE_SHARES: [f64; 2] = [0.85, 0.2];
/// See [`FAN_SHARES`].
const WORTH: f64 = 0.5;
/// A plunge this near, in cutter radii, may free another of contact.
const NEAR_RADII: f64 = 2.0;
/// What one takes counts as unchanged down to this share.
const STILL: f64 = 0.999;
/// How many are looked at side by side, and how many are passed by for that.
const BATCH: usize = 12;
/// See [`BATCH`].
const PASSED: usize = 100;
/// Lift kept above what the search saw, mm.
const LIFT_MARGIN: f64 = 0.01;

/// A plunge that might be added.
#[derive(Clone, Copy, Debug)]
struct Extra {
    /// What it takes, mm³, when it was last looked at.
    gain: f64,
    /// Place in the pool: of two that gain the same, the first.
    index: usize,
    /// Index of its row.
    row: usize,
    station: Station,
    lift: f64,
    /// Whether blades and contact were looked at.
    checked: bool,
}

impl PartialEq for Extra {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Extra {}

impl PartialOrd for Extra {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Extra {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(other.index.cmp(&self.index))
    }
}

/// Looks for more plunges on a stretch.
pub struct ExtraSearch<'a> {
    /// Rows of the pool, by λ.
    rows: &'a [CandidateMaker<'a>],
    blank: &'a Blank,
    floor: Floor,
    /// The pool, by what they take. What one takes only falls while others are added.
    heap: BinaryHeap<Extra>,
    /// Those that contact does not allow yet.
    waiting: Vec<Extra>,
    /// What a plunge must take, mm³.
    least: f64,
}

impl<'a> ExtraSearch<'a> {
    /// A pool of axes in `rows`, at `places` s along each, for what the plunges so far have left of `floor`.
    pub fn new(rows: &'a [CandidateMaker<'a>], places: &[f64], floor: Floor, blank: &'a Blank) -> Self {
        let radius = rows.first().map_or(0.0, |row| row.maker.tool.radius());
        let least = LEAST_GAIN_RADII * std::f64::consts::PI * radius.powi(3);
        let feet: Vec<(usize, f64)> =
            (0..rows.len()).flat_map(|row| places.iter().map(move |&s| (row, s))).collect();
        let mut pool: Vec<Extra> = feet
            .par_iter()
            .flat_map_iter(|&(row, s)| {
                let maker = rows[row].maker;
                let tilt = |j: usize| (TILT_FROM_DEG + TILT_STEP_DEG * j as f64).to_radians();
                let gain = |station: &Station| floor.gain(maker.part, &maker.cutter(station)).cost;
                let coarse = (0..TILTS).step_by(2).map(tilt);
                // Between axes that take next to nothing there is none that takes enough.
                let worth = !maker.monitor.is_cancelled()
                    && rows[row]
                        .fan(s, coarse, &COARSE_SHARES)
                        .iter()
                        .any(|station| gain(station) > WORTH * least);
                let fan =
                    if worth { rows[row].fan(s, (0..TILTS).map(tilt), &FAN_SHARES) } else { Vec::new() };
                let extra = move |station: Station| Extra {
                    gain: gain(&station),
                    index: 0,
                    row,
                    station,
                    lift: 0.0,
                    checked: false,
                };
                fan.into_iter().map(extra).filter(move |extra| extra.gain > least)
            })
            .collect();
        for (index, extra) in pool.iter_mut().enumerate() {
            extra.index = index;
        }
        Self { rows, blank, floor, heap: BinaryHeap::from(pool), waiting: Vec::new(), least }
    }

    /// Up to `most` stations by rows of the pool that take `times` the least or more, each row in cutting order, all of
    /// them free after the plunges of `columns`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn stations(
        &mut self,
        columns: &[Column],
        most: usize,
        times: f64,
    ) -> Result<Vec<Vec<Station>>, Cancelled> {
        let mut found: Vec<Vec<(f64, Station)>> = vec![Vec::new(); self.rows.len()];
        let Some(RowMaker { part, monitor, inward, tool, .. }) = self.rows.first().map(|row| row.maker)
        else {
            return Ok(Vec::new());
        };
        let radius = tool.radius();
        self.heap.extend(std::mem::take(&mut self.waiting));
        let mut count = 0;
        while let Some(mut extra) = self.heap.pop() {
            monitor.check()?;
            if extra.gain < times * self.least || count >= most {
                self.heap.push(extra);
                break;
            }
            if !extra.checked {
                self.heap.push(extra);
                self.check(columns);
                continue;
            }
            let cutter = self.cutter(&extra);
            let gain = self.floor.gain(part, &cutter).cost;
            if gain < STILL * extra.gain {
                // What was added since has taken part of it.
                extra.gain = gain;
                self.heap.push(extra);
                continue;
            }
            self.floor.cut(part, &cutter);
            found[extra.row].push((-extra.station.ends.s_hub * inward, extra.station));
            count += 1;
        }
        // After these, others beside them may be free that are not yet.
        let (held, rest) = self.heap.drain().partition(|extra| extra.lift > 0.0);
        self.heap = BinaryHeap::from(rest);
        self.waiting.extend::<Vec<Extra>>(held);
        let near = |a: &Station, b: &Station| (a.tip - b.tip).norm() < NEAR_RADII * radius;
        self.waiting.retain(|extra| found.iter().flatten().any(|(_, added)| near(&extra.station, added)));
        for extra in &mut self.waiting {
            (extra.lift, extra.checked) = (0.0, false);
            extra.gain = f64::INFINITY;
        }
        let in_order = |mut row: Vec<(f64, Station)>| {
            row.sort_by(|a, b| a.0.total_cmp(&b.0));
            row.into_iter().map(|(_, station)| station).collect()
        };
        Ok(found.into_iter().map(in_order).collect())
    }

    /// The cutter at the end of the plunge.
    fn cutter(&self, extra: &Extra) -> CutterSolid {
        let cutter = self.rows[extra.row].maker.cutter(&extra.station);
        CutterSolid { tip: cutter.tip + cutter.axis * extra.lift, ..cutter }
    }

    /// Looks at blades and contact of the best of the pool that were not looked at yet and are far from each other, and
    /// puts back what is left of them. The others wait: the first of them that is added takes part of theirs.
    fn check(&mut self, columns: &[Column]) {
        let Some(RowMaker { part, tool, .. }) = self.rows.first().map(|row| row.maker) else { return };
        let apart = tool.diameter;
        let mut batch: Vec<Extra> = Vec::with_capacity(BATCH);
        let mut passed: Vec<Extra> = Vec::with_capacity(PASSED);
        while batch.len() < BATCH
            && passed.len() < PASSED
            && let Some(mut next) = self.heap.pop()
        {
            let near = |other: &Extra| (next.station.tip - other.station.tip).norm() < apart;
            if next.checked || batch.iter().any(near) {
                passed.push(next);
                continue;
            }
            let gain = self.floor.gain(part, &self.cutter(&next)).cost;
            if gain < self.least {
                continue;
            }
            if gain < STILL * next.gain {
                next.gain = gain;
                self.heap.push(next);
            } else {
                batch.push(next);
            }
        }
        self.heap.extend(passed);
        let checked: Vec<Option<Extra>> = batch
            .into_par_iter()
            .map_init(ContactSearch::default, |search, extra| self.checked(extra, columns, search))
            .collect();
        for extra in checked.into_iter().flatten() {
            if extra.gain > 0.0 { self.heap.push(extra) } else { self.waiting.push(extra) }
        }
    }

    /// An extra made exact, with the lift that frees it; it takes nothing where that is too much. `None` where blades are in the
    /// way, or others have left too little.
    fn checked(&self, mut extra: Extra, columns: &[Column], search: &mut ContactSearch) -> Option<Extra> {
        let row = &self.rows[extra.row];
        let gain = |extra: &Extra| self.floor.gain(row.maker.part, &self.cutter(extra));
        let free = gain(&extra);
        if free.cost < self.least || row.maker.monitor.is_cancelled() {
            return None;
        }
        extra.station = row.maker.exact(&extra.station).filter(|station| row.allowed(station))?;
        // Lifted by more, it would take next to nothing.
        let enough = (MOST_LIFT_SHARE * free.drop).min(MOST_LIFT_RADII * row.maker.tool.radius());
        let depth = search.depth(&row.column(&extra.station), columns.iter(), self.blank, enough);
        extra.lift = if depth > 0.0 { depth + LIFT_MARGIN } else { 0.0 };
        extra.checked = true;
        extra.gain = if depth > enough { 0.0 } else { gain(&extra).cost };
        Some(extra)
    }
}
