//! More plunges where a section's rows left the most: between positions, between rows, and under walls that lean
//! over the channel.
//!
//! From a pool of axes, finer than the rows and free to lean from the wall's axis to upright, the one that takes
//! most is added, again and again. Each is free of contact after the rows alone, so that they may be cut in any order.
//!
//! Work is put off until it is needed: a place is looked at by a few axes, and by all of them once these are the best of
//! the pool; blades and contact of an axis are looked at once it is the best, contact by a few lines of the core before
//! all. As what an axis takes only falls while others are added, and stays where none was added near it, most of the pool
//! never gets so far.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use rayon::prelude::*;

use super::candidate::CandidateMaker;
use super::floor::{Floor, Gain};
use crate::geometry::{Cells, CutterSolid, Point};
use crate::monitor::Cancelled;
use crate::part::Blank;
use crate::plunge::contact::{Columns, ContactSearch};
use crate::plunge::row::{RowMaker, Station};

/// Feed tilts tried: from, apart, degrees, and how many.
const TILT_FROM_DEG: f64 = -9.0;
const TILT_STEP_DEG: f64 = 3.0;
const TILTS: usize = 10;
/// Least gain of a plunge, as the thickness of a layer under the whole of its bottom, in cutter radii.
const LEAST_GAIN_RADII: f64 = 0.0004;
/// Most a plunge may stop short, as a share of what it would lower the stock by, and in cutter radii.
const MOST_LIFT_SHARE: f64 = 0.7;
/// See [`MOST_LIFT_SHARE`].
const MOST_LIFT_RADII: f64 = 0.3;
/// Ways to lean sideways, as shares of the way from the row's own lean to upright: all, and those that tell whether a
/// place is worth looking at.
const FAN_SHARES: [f64; 5] = [1.0, 0.7, 0.4, 0.0, 1.4];
/// See [`FAN_SHARES`].
const COARSE_SHARES: [f64; 2] = [0.85, 0.2];
/// A plunge this near, in cutter radii, may free another of contact.
const NEAR_RADII: f64 = 2.0;
/// Plunges further apart than this, in cutter radii, share no cell of the floor.
const APART_RADII: f64 = 4.5;
/// What one takes counts as unchanged down to this share.
const STILL: f64 = 0.999;
/// What the best axis of a place may take: as a multiple of the best of the few that were looked at, and in least gains
/// on top, as a few miss what is narrow.
const EXPECTED: f64 = 1.2;
/// See [`EXPECTED`].
const EXPECTED_LEAST: f64 = 0.6;
/// How many of the best are looked at again side by side, how many of these closer at most, and how many at least where
/// they are near to each other.
const BEST: usize = 16;
/// See [`BEST`].
const BATCH: usize = 8;
/// See [`BEST`].
const FEWEST: usize = 6;
/// Lift kept above what the search saw, mm.
const LIFT_MARGIN: f64 = 0.01;

/// The cutter on one of the axes by which a place is looked at: the pool is large, and no more of the axis counts.
#[derive(Clone, Debug)]
struct Probe {
    cutter: CutterSolid,
    /// What it took when it was last looked at, mm³.
    gain: f64,
}

/// How far an entry of the pool was looked at.
#[derive(Clone, Debug)]
enum Look {
    /// A place, by a few of its axes.
    Place(Vec<Probe>),
    /// One axis, blades and contact not looked at.
    Axis(Station),
    /// An axis that blades allow, contact not looked at.
    Clear(Station),
    /// An axis that blades allow and that a few lines of its core hold back by `lift` mm at least.
    Held { station: Station, lift: f64 },
    /// A plunge that blades and contact allow when it stops `lift` mm short.
    Plunge { station: Station, lift: f64 },
}

/// A plunge that might be added, or a place for some.
#[derive(Clone, Debug)]
struct Extra {
    /// What it takes, mm³, when it was last looked at; of a place the most that is expected.
    gain: f64,
    /// Of two that gain the same, the first: place in the pool, and axis of it.
    order: (usize, usize),
    /// Index of its row.
    row: usize,
    /// s of its foot.
    s: f64,
    /// How many had been added when it was last looked at; `None` when it has to be looked at anyway.
    seen: Option<usize>,
    look: Look,
}

impl Extra {
    /// Where it is, nearly.
    fn foot(&self) -> Option<&Point> {
        match &self.look {
            Look::Place(few) => few.first().map(|probe| &probe.cutter.tip),
            Look::Axis(station) | Look::Clear(station) => Some(&station.tip),
            Look::Held { station, .. } | Look::Plunge { station, .. } => Some(&station.tip),
        }
    }

    /// Its axis, if contact holds that back.
    fn held(&self) -> Option<Station> {
        match self.look {
            Look::Held { station, .. } => Some(station),
            Look::Plunge { station, lift } if lift > 0.0 => Some(station),
            _ => None,
        }
    }
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
        self.gain.total_cmp(&other.gain).then(other.order.cmp(&self.order))
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
    /// Tips of those that were added.
    added: Cells,
    /// What a plunge must take, mm³.
    least: f64,
}

impl<'a> ExtraSearch<'a> {
    /// A pool of axes at `feet`, each a row of `rows` and an s, for what the plunges so far have left of `floor`.
    pub fn new(
        rows: &'a [CandidateMaker<'a>],
        feet: &[(usize, f64)],
        floor: Floor,
        blank: &'a Blank,
    ) -> Self {
        let radius = rows.first().map_or(0.0, |row| row.maker.tool.radius());
        let least = LEAST_GAIN_RADII * std::f64::consts::PI * radius.powi(3);
        let added = Cells::new(APART_RADII * radius);
        let (heap, waiting) = (BinaryHeap::new(), Vec::new());
        let mut search = Self { rows, blank, floor, heap, waiting, added, least };
        let place = |(index, &(row, s)): (usize, &(usize, f64))| {
            let maker = &rows[row];
            if maker.maker.monitor.is_cancelled() {
                return None;
            }
            let few = maker.fan(s, (0..TILTS).step_by(2).map(tilt), &COARSE_SHARES).into_iter();
            let probe = |station| Probe { cutter: maker.maker.cutter(&station), gain: f64::INFINITY };
            let look = Look::Place(few.map(probe).collect());
            search.still_worth(Extra { gain: f64::INFINITY, order: (index, 0), row, s, seen: None, look })
        };
        let pool: Vec<Extra> = feet.par_iter().enumerate().filter_map(place).collect();
        search.heap = BinaryHeap::from(pool);
        search
    }

    /// The floor after all plunges that were found.
    pub fn floor(&self) -> &Floor {
        &self.floor
    }

    /// Up to `most` stations by rows of the pool that take `times` the least or more, each row in cutting order, all of
    /// them free after the plunges of `columns`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn stations(
        &mut self,
        columns: &Columns,
        most: usize,
        times: f64,
    ) -> Result<Vec<Vec<Station>>, Cancelled> {
        let mut found: Vec<Vec<(f64, Station)>> = vec![Vec::new(); self.rows.len()];
        let Some(RowMaker { part, monitor, inward, tool, .. }) = self.rows.first().map(|row| row.maker)
        else {
            return Ok(Vec::new());
        };
        let mut added = Cells::new(NEAR_RADII * tool.radius());
        self.heap.extend(std::mem::take(&mut self.waiting));
        let mut count = 0;
        while let Some(best) = self.heap.pop() {
            match monitor.check() {
                // What was found until now stands for itself.
                Err(_) if monitor.is_stopped() => break,
                checked => checked?,
            }
            if best.gain < times * self.least || count >= most {
                self.heap.push(best);
                break;
            }
            let Look::Plunge { station, lift } = best.look else {
                self.heap.push(best);
                self.look_closer(columns);
                continue;
            };
            let Some(now) = self.still_worth(best.clone()) else { continue };
            if now.gain < STILL * best.gain {
                // What was added since has taken part of it.
                self.heap.push(now);
                continue;
            }
            let cutter = self.cutter(best.row, &station, lift);
            self.floor.cut(part, &cutter);
            self.added.push(cutter.tip);
            added.push(station.tip);
            found[best.row].push((-station.ends.s_hub * inward, station));
            count += 1;
        }
        // After these, others beside them may be free that are not yet.
        let (held, rest) = self.heap.drain().partition(|extra| extra.held().is_some());
        self.heap = BinaryHeap::from(rest);
        self.waiting.extend::<Vec<Extra>>(held);
        for mut extra in std::mem::take(&mut self.waiting) {
            if let Some(station) = extra.held()
                && added.any_near(&station.tip, 0)
            {
                (extra.look, extra.gain, extra.seen) = (Look::Clear(station), f64::INFINITY, None);
                self.waiting.push(extra);
            }
        }
        let in_order = |mut row: Vec<(f64, Station)>| {
            row.sort_by(|a, b| a.0.total_cmp(&b.0));
            row.into_iter().map(|(_, station)| station).collect()
        };
        Ok(found.into_iter().map(in_order).collect())
    }

    /// The cutter at the end of a plunge in row `row` that stops `lift` mm short.
    fn cutter(&self, row: usize, station: &Station, lift: f64) -> CutterSolid {
        let cutter = self.rows[row].maker.cutter(station);
        CutterSolid { tip: cutter.tip + cutter.axis * lift, ..cutter }
    }

    /// What a plunge would take now.
    fn gain(&self, row: usize, station: &Station, lift: f64) -> Gain {
        self.floor.gain(self.rows[row].maker.part, &self.cutter(row, station, lift))
    }

    /// An entry with what it takes now; `None` when that is too little.
    fn still_worth(&self, mut extra: Extra) -> Option<Extra> {
        let Extra { row, seen, gain, .. } = extra;
        let changed = |tip: &Point| seen.is_none_or(|seen| self.added.any_near(tip, seen));
        let now = |station: &Station, lift: f64, before: f64| {
            if changed(&station.tip) { self.gain(row, station, lift).cost } else { before }
        };
        let (gain, least) = match &mut extra.look {
            Look::Place(few) => {
                let part = self.rows[row].maker.part;
                for probe in few.iter_mut().filter(|probe| changed(&probe.cutter.tip)) {
                    probe.gain = self.floor.gain(part, &probe.cutter).cost;
                }
                // Between axes that take next to nothing there is none that takes enough.
                let most = few.iter().map(|probe| probe.gain).fold(0.0, f64::max);
                (EXPECTED * most + EXPECTED_LEAST * self.least, self.least)
            }
            Look::Axis(station) | Look::Clear(station) => (now(station, 0.0, gain), self.least),
            Look::Held { station, lift } | Look::Plunge { station, lift } => (now(station, *lift, gain), 0.0),
        };
        (extra.gain, extra.seen) = (gain, Some(self.added.len()));
        (gain > least).then_some(extra)
    }

    /// Looks again at the best of the pool, and closer at those that still take what they did: those far from each other
    /// first, as of near ones the first that is added takes part of what the others would.
    fn look_closer(&mut self, columns: &Columns) {
        let apart = self.rows.first().map_or(0.0, |row| row.maker.tool.diameter);
        let mut best: Vec<Extra> = Vec::with_capacity(BEST);
        let mut planned: Vec<Extra> = Vec::new();
        while best.len() < BEST
            && let Some(next) = self.heap.pop()
        {
            if matches!(next.look, Look::Plunge { .. }) { planned.push(next) } else { best.push(next) }
        }
        self.heap.extend(planned);
        let again: Vec<Option<(f64, Extra)>> =
            best.into_par_iter().map(|extra| Some((extra.gain, self.still_worth(extra)?))).collect();
        let mut batch: Vec<Extra> = Vec::with_capacity(BATCH);
        let mut near: Vec<Extra> = Vec::with_capacity(BEST);
        for (before, extra) in again.into_iter().flatten() {
            let is_near =
                |other: &Extra| extra.foot().zip(other.foot()).is_some_and(|(a, b)| (a - b).norm() < apart);
            if extra.gain < STILL * before || batch.len() == BATCH {
                self.heap.push(extra);
            } else if batch.iter().any(is_near) {
                near.push(extra);
            } else {
                batch.push(extra);
            }
        }
        for extra in near {
            if batch.len() < FEWEST { batch.push(extra) } else { self.heap.push(extra) }
        }
        let closer: Vec<Vec<Extra>> = batch
            .into_par_iter()
            .map_init(ContactSearch::default, |search, extra| self.closer(extra, columns, search))
            .collect();
        for extra in closer.into_iter().flatten() {
            // What contact does not allow takes nothing.
            if extra.gain > 0.0 { self.heap.push(extra) } else { self.waiting.push(extra) }
        }
    }

    /// All axes of a place, or an axis looked at closer.
    fn closer(&self, extra: Extra, columns: &Columns, search: &mut ContactSearch) -> Vec<Extra> {
        let Extra { row, s, order, .. } = extra;
        let makes = &self.rows[row];
        match extra.look {
            Look::Place(_) => {
                // The most work of all: half of it for whoever has none.
                let axes = |tilts: Range<usize>| -> Vec<Extra> {
                    let fan = makes.fan(s, tilts.clone().map(tilt), &FAN_SHARES);
                    let from = tilts.start * FAN_SHARES.len();
                    let axis = |(number, station)| Extra {
                        order: (order.0, from + number),
                        seen: None,
                        look: Look::Axis(station),
                        ..extra
                    };
                    let axes = fan.into_iter().enumerate().map(axis);
                    axes.filter_map(|axis| self.still_worth(axis)).collect()
                };
                let (mut some, more) = rayon::join(|| axes(0..TILTS / 2), || axes(TILTS / 2..TILTS));
                some.extend(more);
                some
            }
            Look::Axis(station) if !makes.maker.monitor.is_cancelled() => makes
                .maker
                .exact(&station)
                .filter(|station| makes.allowed(station))
                .map(|station| self.freed(Extra { look: Look::Clear(station), ..extra }, columns, search))
                .into_iter()
                .collect(),
            Look::Clear(_) | Look::Held { .. } => vec![self.freed(extra, columns, search)],
            Look::Axis(_) | Look::Plunge { .. } => vec![extra],
        }
    }

    /// An axis that blades allow, with the lift that frees it; it takes nothing where that is too much.
    fn freed(&self, extra: Extra, columns: &Columns, search: &mut ContactSearch) -> Extra {
        let (Look::Clear(station) | Look::Held { station, .. }) = extra.look else { return extra };
        let Extra { row, .. } = extra;
        let makes = &self.rows[row];
        let free = self.gain(row, &station, 0.0);
        // Lifted by more, it would take next to nothing.
        let enough = (MOST_LIFT_SHARE * free.drop).min(MOST_LIFT_RADII * makes.maker.tool.radius());
        let column = makes.column(&station);
        let mut lines = search.among(&column, columns.all().near(&column));
        let lifted = |depth: f64| {
            let lift = if depth > 0.0 { depth + LIFT_MARGIN } else { 0.0 };
            (lift, if depth > enough { 0.0 } else { self.gain(row, &station, lift).cost })
        };
        if matches!(extra.look, Look::Clear(_)) {
            let (lift, gain) = lifted(lines.depth_by_few(self.blank, enough));
            if gain < STILL * free.cost {
                return Extra { gain, look: Look::Held { station, lift }, ..extra };
            }
        }
        let (lift, gain) = lifted(lines.depth(self.blank, enough));
        Extra { gain, look: Look::Plunge { station, lift }, ..extra }
    }
}

/// Feed tilt number `j`, rad.
fn tilt(j: usize) -> f64 {
    (TILT_FROM_DEG + TILT_STEP_DEG * j as f64).to_radians()
}
