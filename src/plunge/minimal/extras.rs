//! Single plunges where the rows of a section left the most stock: between positions, between rows, and under
//! walls that lean over the channel.
//!
//! Greedy selection: from a pool of axes, denser than the rows and with tilt angles from that of the wall to
//! zero, the plunge with the largest gain is added repeatedly. Each is free of contact after the rows alone,
//! so they may be cut in any order.
//!
//! The selection is lazy: a gain only decreases while plunges are added, and stays the same where none was
//! added nearby, so an old gain is an upper bound. A foot is first evaluated with a few axes, and with all of
//! them once it is at the top of the heap; blades and contact of an axis are checked once it is at the top,
//! contact with a few lines of the core first. Most of the pool never gets that far.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use rayon::prelude::*;

use super::candidate::CandidateMaker;
use super::floor::{FloorHeightMap, Gain};
use super::path::SEARCH_LIFT_MARGIN_MM;
use crate::cutting::contact::{Columns, ContactSearch};
use crate::geometry::{CutterSolid, Point, ProximityGrid};
use crate::monitor::Cancelled;
use crate::part::Blank;
use crate::plunge::row::{RowMaker, Station};

/// Lead angles of the pool of a row: first one and step, degrees, and their number.
const FIRST_LEAD_DEG: f64 = -9.0;
const LEAD_STEP_DEG: f64 = 3.0;
const LEAD_COUNT: usize = 10;
/// Minimum gain of a plunge, as the thickness of a layer under its whole bottom, in cutter radii.
const MIN_GAIN_RADII: f64 = 0.0004;
/// Maximum lift of a plunge as a share of the depth by which it would lower the stock.
const MAX_LIFT_SHARE: f64 = 0.7;
/// Maximum lift of a plunge in cutter radii.
const MAX_LIFT_RADII: f64 = 0.3;
/// Tilt angles of the full evaluation, as shares from the row's own tilt angle (0) to zero tilt (1).
const TILT_SHARES: [f64; 5] = [1.0, 0.7, 0.4, 0.0, 1.4];
/// As [`TILT_SHARES`], for the coarse evaluation of a foot.
const COARSE_TILT_SHARES: [f64; 2] = [0.85, 0.2];
/// Lead angles of the pool beside a wall, from that of the conventional axis: step, degrees, and their
/// number.
const WALL_LEAD_STEP_DEG: f64 = 10.0;
const WALL_LEAD_COUNT: usize = 9;
/// Tilt angles by which axes beside a wall are turned off it, degrees; negative ones lean over more than it.
const WALL_TURNS_DEG: [f64; 5] = [0.0, -5.0, -10.0, -16.0, 10.0];
/// As [`WALL_TURNS_DEG`], for the coarse evaluation of a foot.
const COARSE_WALL_TURNS_DEG: [f64; 3] = [0.0, -8.0, 10.0];
/// Distance up to which a plunge may free another of contact, in cutter radii.
const NEAR_RADII: f64 = 2.0;
/// Distance beyond which two plunges share no cell of the floor, in cutter radii.
const APART_RADII: f64 = 4.5;
/// Share of the old gain down to which a gain counts as unchanged.
const UNCHANGED_SHARE: f64 = 0.999;
/// Estimated upper bound of the gain at a foot, as a multiple of the best gain of the coarse evaluation. It
/// is a heuristic: a few axes miss narrow residues.
const GAIN_BOUND_FACTOR: f64 = 1.2;
/// Added to the bound of [`GAIN_BOUND_FACTOR`], in minimum gains.
const GAIN_BOUND_MARGIN: f64 = 0.6;
/// Number of top entries that are re-evaluated in parallel.
const TOP_COUNT: usize = 16;
/// Maximum number of these that are refined.
const MAX_BATCH: usize = 8;
/// Number of these that are refined even if they are near each other.
const MIN_BATCH: usize = 6;

/// The axes that are tried at a foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoolFan {
    /// Those around the axes of a row.
    Row,
    /// Those beside a wall, inclined as far as they may be in all directions.
    Wall,
}

impl PoolFan {
    /// Number of lead angles.
    const fn lead_count(self) -> usize {
        match self {
            Self::Row => LEAD_COUNT,
            Self::Wall => WALL_LEAD_COUNT,
        }
    }

    /// Number of axes per lead angle in the full evaluation.
    const fn tilt_count(self) -> usize {
        match self {
            Self::Row => TILT_SHARES.len(),
            Self::Wall => WALL_TURNS_DEG.len(),
        }
    }

    /// Stations at `s` with some of the lead angles, for the full evaluation.
    fn full(self, maker: &CandidateMaker, s: f64, leads: Range<usize>) -> Vec<Station> {
        match self {
            Self::Row => maker.axis_fan(s, leads.map(lead_rad), &TILT_SHARES),
            Self::Wall => maker.wall_fan(s, leads.map(wall_lead_rad), &WALL_TURNS_DEG),
        }
    }

    /// The few stations at `s` of the coarse evaluation.
    fn coarse(self, maker: &CandidateMaker, s: f64) -> Vec<Station> {
        match self {
            Self::Row => maker.axis_fan(s, (0..LEAD_COUNT).step_by(2).map(lead_rad), &COARSE_TILT_SHARES),
            Self::Wall => {
                let leads = (1..WALL_LEAD_COUNT).step_by(3);
                maker.wall_fan(s, leads.map(wall_lead_rad), &COARSE_WALL_TURNS_DEG)
            }
        }
    }
}

/// A cutter of the coarse evaluation. The pool is large, so only the cutter of the axis is stored.
#[derive(Clone, Debug)]
struct CoarseProbe {
    cutter: CutterSolid,
    /// Gain of its last evaluation, mm³.
    gain: f64,
}

/// How far an entry of the pool has been evaluated.
#[derive(Clone, Debug)]
enum PoolStage {
    /// A foot, with the few axes of the coarse evaluation.
    Foot(Vec<CoarseProbe>),
    /// One axis, blades and contact not checked.
    Axis(Station),
    /// An axis that clears the blades, contact not checked.
    Clear(Station),
    /// An axis that clears the blades and needs at least `lift` mm by a few lines of its core.
    ContactLimited { station: Station, lift: f64 },
    /// A plunge that is free of blades and contact when it stops `lift` mm short.
    Plunge { station: Station, lift: f64 },
}

/// An entry of the pool: a plunge that may be added, or a foot for several.
#[derive(Clone, Debug)]
struct PoolEntry {
    /// Gain of the last evaluation, mm³; for a foot its estimated upper bound.
    gain: f64,
    /// Tie-break: index of the foot in the pool, and of the axis at it; the first wins.
    order: (usize, usize),
    /// Index of its row.
    row: usize,
    /// s of its foot.
    s: f64,
    /// Number of added plunges at the last evaluation; `None` when it has to be evaluated anyway.
    seen: Option<usize>,
    look: PoolStage,
}

impl PoolEntry {
    /// Approximate position.
    fn foot(&self) -> Option<&Point> {
        match &self.look {
            PoolStage::Foot(few) => few.first().map(|probe| &probe.cutter.tip),
            PoolStage::Axis(station) | PoolStage::Clear(station) => Some(&station.tip),
            PoolStage::ContactLimited { station, .. } | PoolStage::Plunge { station, .. } => {
                Some(&station.tip)
            }
        }
    }

    /// Its station, if contact limits that.
    fn contact_limited_station(&self) -> Option<Station> {
        match self.look {
            PoolStage::ContactLimited { station, .. } => Some(station),
            PoolStage::Plunge { station, lift } if lift > 0.0 => Some(station),
            _ => None,
        }
    }
}

impl PartialEq for PoolEntry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for PoolEntry {}

impl PartialOrd for PoolEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for PoolEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(other.order.cmp(&self.order))
    }
}

/// Lazy greedy search for more plunges on a stretch.
pub struct ExtraSearch<'a> {
    /// Rows of the pool, by λ.
    rows: &'a [CandidateMaker<'a>],
    fan: PoolFan,
    blank: &'a Blank,
    floor: FloorHeightMap,
    /// Entries of the pool that are not plunges yet, and those that are. Gains only decrease while plunges
    /// are added.
    heap: BinaryHeap<PoolEntry>,
    plunges: BinaryHeap<PoolEntry>,
    /// Entries that contact does not allow yet.
    waiting: Vec<PoolEntry>,
    /// Tips of the added plunges.
    added: ProximityGrid,
    /// Minimum gain of a plunge, mm³.
    min_gain: f64,
}

impl<'a> ExtraSearch<'a> {
    /// A pool of axes at `feet` (index into `rows`, s) for the stock that the plunges so far have left on
    /// `floor`.
    pub fn new(
        rows: &'a [CandidateMaker<'a>],
        fan: PoolFan,
        feet: &[(usize, f64)],
        floor: FloorHeightMap,
        blank: &'a Blank,
    ) -> Self {
        let radius = rows.first().map_or(0.0, |row| row.maker.tool.radius());
        let least = MIN_GAIN_RADII * std::f64::consts::PI * radius.powi(3);
        let added = ProximityGrid::new(APART_RADII * radius);
        let (heap, plunges, waiting) = (BinaryHeap::new(), BinaryHeap::new(), Vec::new());
        let mut search = Self { rows, fan, blank, floor, heap, plunges, waiting, added, min_gain: least };
        let place = |(index, &(row, s)): (usize, &(usize, f64))| {
            let maker = &rows[row];
            if maker.maker.monitor.is_cancelled() {
                return None;
            }
            let few = fan.coarse(maker, s).into_iter();
            let probe = |station| CoarseProbe { cutter: maker.maker.cutter(&station), gain: f64::INFINITY };
            let look = PoolStage::Foot(few.map(probe).collect());
            search.with_current_gain(PoolEntry {
                gain: f64::INFINITY,
                order: (index, 0),
                row,
                s,
                seen: None,
                look,
            })
        };
        let pool: Vec<PoolEntry> = feet.par_iter().enumerate().filter_map(place).collect();
        search.heap = BinaryHeap::from(pool);
        search
    }

    /// The floor after all found plunges.
    pub fn floor(&self) -> &FloorHeightMap {
        &self.floor
    }

    /// As [`Self::floor`], at the end of the search.
    pub fn into_floor(self) -> FloorHeightMap {
        self.floor
    }

    /// Up to `most` stations with a gain of at least `times` the minimum one, by rows of the pool, each row
    /// in cutting order. All of them are free of contact after the plunges of `columns`.
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
        let Some(RowMaker { part, monitor, direction_sign: inward, tool, .. }) =
            self.rows.first().map(|row| row.maker)
        else {
            return Ok(Vec::new());
        };
        let mut added = ProximityGrid::new(NEAR_RADII * tool.radius());
        for entry in std::mem::take(&mut self.waiting) {
            self.keep(entry);
        }
        let mut count = 0;
        while let Some(best) = self.take_best() {
            match monitor.check() {
                // When stopped, the plunges found so far are the result.
                Err(_) if monitor.is_stopped() => break,
                checked => checked?,
            }
            if best.gain < times * self.min_gain || count >= most {
                self.keep(best);
                break;
            }
            let PoolStage::Plunge { station, lift } = best.look else {
                self.keep(best);
                self.refine_top(columns);
                continue;
            };
            let Some(now) = self.with_current_gain(best.clone()) else { continue };
            if now.gain < UNCHANGED_SHARE * best.gain {
                // Plunges added since have taken part of its gain.
                self.keep(now);
                continue;
            }
            let cutter = self.cutter(best.row, &station, lift);
            self.floor.cut(part, &cutter);
            self.added.push(cutter.tip);
            added.push(station.tip);
            found[best.row].push((-station.ends.s_hub * inward, station));
            count += 1;
        }
        // The added plunges may free others near them of contact: these are evaluated again.
        let all = self.heap.drain().chain(self.plunges.drain());
        let (held, rest): (Vec<PoolEntry>, Vec<PoolEntry>) =
            all.partition(|extra| extra.contact_limited_station().is_some());
        for extra in rest {
            self.keep(extra);
        }
        self.waiting.extend(held);
        for mut extra in std::mem::take(&mut self.waiting) {
            if let Some(station) = extra.contact_limited_station()
                && added.any_near(&station.tip, 0)
            {
                (extra.look, extra.gain, extra.seen) = (PoolStage::Clear(station), f64::INFINITY, None);
                self.waiting.push(extra);
            }
        }
        let in_order = |mut row: Vec<(f64, Station)>| {
            row.sort_by(|a, b| a.0.total_cmp(&b.0));
            row.into_iter().map(|(_, station)| station).collect()
        };
        Ok(found.into_iter().map(in_order).collect())
    }

    /// Puts an entry into the pool.
    fn keep(&mut self, entry: PoolEntry) {
        let is_plunge = matches!(entry.look, PoolStage::Plunge { .. });
        if is_plunge { self.plunges.push(entry) } else { self.heap.push(entry) }
    }

    /// Takes the entry with the largest gain out of the pool.
    fn take_best(&mut self) -> Option<PoolEntry> {
        if self.plunges.peek() > self.heap.peek() { self.plunges.pop() } else { self.heap.pop() }
    }

    /// The cutter at the end of a plunge in row `row` that stops `lift` mm short.
    fn cutter(&self, row: usize, station: &Station, lift: f64) -> CutterSolid {
        let cutter = self.rows[row].maker.cutter(station);
        CutterSolid { tip: cutter.tip + cutter.axis * lift, ..cutter }
    }

    /// Current gain of a plunge.
    fn gain(&self, row: usize, station: &Station, lift: f64) -> Gain {
        self.floor.gain(self.rows[row].maker.part, &self.cutter(row, station, lift))
    }

    /// The entry with its current gain; `None` when that is below the minimum.
    fn with_current_gain(&self, mut extra: PoolEntry) -> Option<PoolEntry> {
        let PoolEntry { row, seen, gain, .. } = extra;
        let changed = |tip: &Point| seen.is_none_or(|seen| self.added.any_near(tip, seen));
        let now = |station: &Station, lift: f64, before: f64| {
            if changed(&station.tip) { self.gain(row, station, lift).cost } else { before }
        };
        let (gain, least) = match &mut extra.look {
            PoolStage::Foot(few) => {
                let part = self.rows[row].maker.part;
                for probe in few.iter_mut().filter(|probe| changed(&probe.cutter.tip)) {
                    probe.gain = self.floor.gain(part, &probe.cutter).cost;
                }
                // Between axes with hardly any gain no axis has a sufficient one.
                let most = few.iter().map(|probe| probe.gain).fold(0.0, f64::max);
                (GAIN_BOUND_FACTOR * most + GAIN_BOUND_MARGIN * self.min_gain, self.min_gain)
            }
            PoolStage::Axis(station) | PoolStage::Clear(station) => (now(station, 0.0, gain), self.min_gain),
            PoolStage::ContactLimited { station, lift } | PoolStage::Plunge { station, lift } => {
                (now(station, *lift, gain), 0.0)
            }
        };
        (extra.gain, extra.seen) = (gain, Some(self.added.len()));
        (gain > least).then_some(extra)
    }

    /// Re-evaluates the top of the pool and refines the entries whose gain is unchanged. Entries far from
    /// each other come first: of near ones the first that is added takes part of the gain of the others.
    fn refine_top(&mut self, columns: &Columns) {
        let apart = self.rows.first().map_or(0.0, |row| row.maker.tool.diameter);
        let mut best: Vec<PoolEntry> = Vec::with_capacity(TOP_COUNT);
        best.extend(std::iter::from_fn(|| self.heap.pop()).take(TOP_COUNT));
        let again: Vec<Option<(f64, PoolEntry)>> =
            best.into_par_iter().map(|extra| Some((extra.gain, self.with_current_gain(extra)?))).collect();
        let mut batch: Vec<PoolEntry> = Vec::with_capacity(MAX_BATCH);
        let mut near: Vec<PoolEntry> = Vec::with_capacity(TOP_COUNT);
        for (before, extra) in again.into_iter().flatten() {
            let is_near = |other: &PoolEntry| {
                extra.foot().zip(other.foot()).is_some_and(|(a, b)| (a - b).norm() < apart)
            };
            if extra.gain < UNCHANGED_SHARE * before || batch.len() == MAX_BATCH {
                self.heap.push(extra);
            } else if batch.iter().any(is_near) {
                near.push(extra);
            } else {
                batch.push(extra);
            }
        }
        for extra in near {
            if batch.len() < MIN_BATCH { batch.push(extra) } else { self.heap.push(extra) }
        }
        let closer: Vec<Vec<PoolEntry>> = batch
            .into_par_iter()
            .map_init(ContactSearch::default, |search, extra| self.refine(extra, columns, search))
            .collect();
        for extra in closer.into_iter().flatten() {
            // An entry that contact does not allow has no gain.
            if extra.gain > 0.0 { self.keep(extra) } else { self.waiting.push(extra) }
        }
    }

    /// Refines an entry: a foot into all of its axes, an axis into a checked plunge.
    fn refine(&self, extra: PoolEntry, columns: &Columns, search: &mut ContactSearch) -> Vec<PoolEntry> {
        let PoolEntry { row, s, order, .. } = extra;
        let makes = &self.rows[row];
        match extra.look {
            PoolStage::Foot(_) => {
                // Hot spot: split so that an idle worker can steal half of it.
                let axes = |tilts: Range<usize>| -> Vec<PoolEntry> {
                    let from = tilts.start * self.fan.tilt_count();
                    let fan = self.fan.full(makes, s, tilts);
                    let axis = |(number, station)| PoolEntry {
                        order: (order.0, from + number),
                        seen: None,
                        look: PoolStage::Axis(station),
                        ..extra
                    };
                    let axes = fan.into_iter().enumerate().map(axis);
                    axes.filter_map(|axis| self.with_current_gain(axis)).collect()
                };
                let count = self.fan.lead_count();
                let (mut some, more) = rayon::join(|| axes(0..count / 2), || axes(count / 2..count));
                some.extend(more);
                some
            }
            PoolStage::Axis(station) if !makes.maker.monitor.is_cancelled() => makes
                .maker
                .exact(&station)
                .filter(|station| makes.is_allowed(station) && makes.is_long_enough(station))
                .map(|station| {
                    self.checked_for_contact(
                        PoolEntry { look: PoolStage::Clear(station), ..extra },
                        columns,
                        search,
                    )
                })
                .into_iter()
                .collect(),
            PoolStage::Clear(_) | PoolStage::ContactLimited { .. } => {
                vec![self.checked_for_contact(extra, columns, search)]
            }
            PoolStage::Axis(_) | PoolStage::Plunge { .. } => vec![extra],
        }
    }

    /// An axis that clears the blades, with the lift that frees its core; the gain is 0 where the lift is too
    /// large.
    fn checked_for_contact(
        &self,
        extra: PoolEntry,
        columns: &Columns,
        search: &mut ContactSearch,
    ) -> PoolEntry {
        let (PoolStage::Clear(station) | PoolStage::ContactLimited { station, .. }) = extra.look else {
            return extra;
        };
        let PoolEntry { row, .. } = extra;
        let makes = &self.rows[row];
        let free = self.gain(row, &station, 0.0);
        // With a larger lift it would have hardly any gain.
        let enough = (MAX_LIFT_SHARE * free.drop).min(MAX_LIFT_RADII * makes.maker.tool.radius());
        let column = makes.column(&station);
        let mut lines = search.among(&column, columns.all().near(&column));
        let lifted = |depth: f64| match depth {
            depth if depth <= 0.0 => (0.0, free.cost),
            depth if depth > enough => (depth + SEARCH_LIFT_MARGIN_MM, 0.0),
            depth => {
                let lift = depth + SEARCH_LIFT_MARGIN_MM;
                (lift, self.gain(row, &station, lift).cost)
            }
        };
        if matches!(extra.look, PoolStage::Clear(_)) {
            let (lift, gain) = lifted(lines.depth_by_few(self.blank, enough));
            if gain < UNCHANGED_SHARE * free.cost {
                return PoolEntry { gain, look: PoolStage::ContactLimited { station, lift }, ..extra };
            }
        }
        let (lift, gain) = lifted(lines.depth(self.blank, enough));
        PoolEntry { gain, look: PoolStage::Plunge { station, lift }, ..extra }
    }
}

/// Lead angle number `j` of the pool, rad.
fn lead_rad(j: usize) -> f64 {
    (FIRST_LEAD_DEG + LEAD_STEP_DEG * j as f64).to_radians()
}

/// Lead angle number `j` of the pool beside a wall, from that of the conventional axis, rad.
fn wall_lead_rad(j: usize) -> f64 {
    (WALL_LEAD_STEP_DEG * (j as f64 - 0.5 * (WALL_LEAD_COUNT - 1) as f64)).to_radians()
}
