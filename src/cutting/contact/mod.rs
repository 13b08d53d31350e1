//! Contact of the core: where the part of the cutter without cutting edges meets stock that no earlier plunge
//! removed. Plunges are half-infinite cylinders, the blank is a body of revolution. Contact is evaluated by
//! exact intervals along lines of the core, as in a dexel model.

mod columns;
mod crossed;
mod engagement;
mod index;
mod neighbours;
mod remainder;
mod standing;

pub use columns::{BlankTop, Columns, Earlier, PlungeColumn};
use crossed::CoreLine;
pub use engagement::{Engagement, engagement};
use neighbours::Neighbours;
use remainder::LineRemainder;
pub use standing::{StandingHeight, standing_height};

use rayon::prelude::*;

use crate::geometry::{Meridional, Point, search};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;

/// Rings of lines through the core: (share of the core radius, lines). Contact starts at the
/// rim of the core, so most lines are there.
const RINGS: [(f64, usize); 5] = [(1.0, 192), (0.75, 64), (0.5, 32), (0.25, 8), (0.0, 1)];
/// Fewer lines, for a first test: what fails it is not worth the full one.
const FIRST_RINGS: [(f64, usize); 5] = [(1.0, 48), (0.75, 24), (0.5, 16), (0.25, 8), (0.0, 1)];
/// Even fewer lines, for searches.
const SEARCH_RINGS: [(f64, usize); 3] = [(1.0, 24), (0.55, 8), (0.0, 1)];
/// Number of rim lines of the quick test, which are evaluated first.
const QUICK_LINES: usize = 8;
/// Contact depth that planning tolerates, mm: well below [`CONTACT_TOLERANCE`], so that rounding in a CL file
/// or the samples of another checker do not exceed it.
pub const PLANNED_CONTACT: f64 = 0.25 * CONTACT_TOLERANCE;
/// Depth below the bottom, mm, from which on entries are not distinguished.
const MAX_DEPTH_BELOW: f64 = 0.2;
/// Height above the bottom, mm, up to which stock counts for the contact area.
const AREA_HEIGHT: f64 = 0.02;

/// Contact of the core with stock during one plunge.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct CoreContact {
    /// Height above the final bottom up to which the core meets stock, mm; 0 when the core is free.
    pub depth: f64,
    /// Share of the core disc in stock at the end of the plunge, 0…1.
    pub area_share: f64,
}

/// Contact depth above which a plunge counts as interfering, mm.
pub const CONTACT_TOLERANCE: f64 = 0.02;

impl CoreContact {
    /// Whether the plunge interferes.
    pub fn interferes(&self) -> bool {
        self.depth > CONTACT_TOLERANCE
    }
}

/// Contact of the core of `column` with the stock of `blank` that `earlier` plunges left.
pub fn core_contact(column: &PlungeColumn, earlier: Earlier, blank: &Blank) -> CoreContact {
    contact_among(column, &mut Neighbours::around(column, earlier.near(column)), blank, None)
}

/// [`core_contact`] of each of `columns` after those before it.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn core_contacts(
    columns: &Columns,
    blank: &Blank,
    monitor: &Monitor,
) -> Result<Vec<CoreContact>, Cancelled> {
    let contact = |k: usize| {
        monitor.check()?;
        Ok(core_contact(&columns.as_slice()[k], columns.before(k), blank))
    };
    (0..columns.len()).into_par_iter().map(contact).collect()
}

/// Depth of [`core_contact`], mm, given the `earlier` plunges that may meet the core, in cutting order; and
/// for each of them whether it removed anything from a line. Without one that did not, the depth is the same.
pub fn core_contact_by<'c>(
    column: &PlungeColumn,
    earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    blank: &Blank,
) -> (f64, Vec<bool>) {
    let mut near = Neighbours::around(column, earlier);
    let mut removed = vec![false; near.count()];
    let depth = contact_among(column, &mut near, blank, Some(&mut removed)).depth;
    // The neighbours are latest first.
    removed.reverse();
    (depth, removed)
}

/// Notes in `removed`, if given, which neighbours removed anything from a line.
fn contact_among(
    column: &PlungeColumn,
    near: &mut Neighbours,
    blank: &Blank,
    removed: Option<&mut [bool]>,
) -> CoreContact {
    let stock = StockLines { removed, ..StockLines::new(column, near, blank) };
    contact_up_to(column, stock, &RINGS, f64::INFINITY)
}

/// Whether the core of `column` has more contact than planning tolerates, given the `earlier` plunges that
/// may meet it. On a quarter of the lines of [`core_contact`], and returns at the first such line: narrow
/// contact may be missed.
pub fn core_interferes<'c>(
    column: &PlungeColumn,
    earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    blank: &Blank,
) -> bool {
    let mut near = Neighbours::around(column, earlier);
    contact_up_to(column, StockLines::new(column, &mut near, blank), &FIRST_RINGS, PLANNED_CONTACT).depth
        > PLANNED_CONTACT
}

/// Whether a plunge, its whole cutter as `column`, removes stock more than `length` mm above its bottom after
/// the `earlier` plunges.
pub fn cuts_deeper_than(column: &PlungeColumn, length: f64, earlier: Earlier, blank: &Blank) -> bool {
    column.top > length && core_contact(column, earlier, blank).depth > length
}

/// Lift that frees the core of a planned plunge, mm: the depth of [`core_contact`], 0 when planning tolerates
/// it.
pub fn planned_contact(column: &PlungeColumn, earlier: Earlier, blank: &Blank) -> f64 {
    let depth = core_contact(column, earlier, blank).depth;
    if depth > PLANNED_CONTACT { depth } else { 0.0 }
}

/// Contact for searches, with fewer lines than [`core_contact`]. What earlier plunges left on each line is
/// cached, so that evaluating many transitions to a plunge costs only the plunges passed on them.
#[derive(Debug, Default)]
pub struct ContactSearch {
    near: Neighbours,
    /// What the plunges gathered in `near` left on each of the lines evaluated so far.
    left: Vec<Option<LineRemainder>>,
}

impl ContactSearch {
    /// The lines of the core of `column` after the `earlier` plunges that may meet it, in cutting order.
    pub fn among<'c, 's>(
        &'s mut self,
        column: &PlungeColumn,
        earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    ) -> SearchLines<'s> {
        self.near.gather(column, earlier);
        self.left.clear();
        self.left.resize(SEARCH_RINGS.iter().map(|(_, count)| count).sum(), None);
        SearchLines { column: *column, search: self }
    }

    /// The lines of the same core after additional `passed` plunges, in cutting order.
    pub fn after<'c, 's>(
        &'s mut self,
        column: &PlungeColumn,
        passed: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    ) -> SearchLines<'s> {
        self.near.set_passed(passed);
        SearchLines { column: *column, search: self }
    }
}

/// The lines of a core on which a search evaluates contact.
#[derive(Debug)]
pub struct SearchLines<'s> {
    column: PlungeColumn,
    search: &'s mut ContactSearch,
}

impl SearchLines<'_> {
    /// Contact depth, mm; 0 when planning tolerates it. If it exceeds `enough` (mm), any value above `enough`
    /// may be returned.
    pub fn depth(&mut self, blank: &Blank, enough: f64) -> f64 {
        let enough = enough.max(PLANNED_CONTACT);
        let ContactSearch { near, left } = &mut *self.search;
        let mut stock = StockLines::new(&self.column, near, blank);
        stock.kept = Some(left);
        let depth = contact_up_to(&self.column, stock, &SEARCH_RINGS, enough).depth;
        if depth > PLANNED_CONTACT { depth } else { 0.0 }
    }

    /// Lower bound on [`Self::depth`] from a few of the lines, usually close to it.
    pub fn depth_by_few(&mut self, blank: &Blank, enough: f64) -> f64 {
        if self.column.top <= 0.0 {
            return 0.0;
        }
        let ContactSearch { near, left } = &mut *self.search;
        let mut stock = StockLines::new(&self.column, near, blank);
        stock.kept = Some(left);
        let lines = SEARCH_RINGS[0].1;
        let deep = deep_entry(&self.column);
        let mut deepest = 0.0f64;
        for k in 0..QUICK_LINES {
            let number = k * (lines / QUICK_LINES);
            let phi = std::f64::consts::TAU * number as f64 / lines as f64;
            let line = stock.near.frame().line(self.column.core_radius, phi);
            deepest = deepest.max(stock.on_cached_line(number, &line, deep).1);
            if deepest > enough.max(PLANNED_CONTACT) {
                break;
            }
        }
        if deepest > PLANNED_CONTACT { deepest } else { 0.0 }
    }
}

/// Contact on the lines of `rings`; may return as soon as the depth exceeds `enough`.
fn contact_up_to(
    column: &PlungeColumn,
    mut stock: StockLines,
    rings: &[(f64, usize)],
    enough: f64,
) -> CoreContact {
    if column.top <= 0.0 {
        return CoreContact::default();
    }
    let frame = stock.near.frame();
    let line = |rho: f64, phi: f64| frame.line(rho, phi);
    let mut depth = 0.0f64;
    let mut area = 0.0;
    let deep_rim = deep_entry(column);
    // (entry, angle) of the rim lines: height at which the line enters removed stock, negative below the
    // bottom.
    let mut rim = [(0.0f64, 0.0f64); RINGS[0].1];
    let mut before = 0;
    for (ring, &(share, count)) in rings.iter().enumerate() {
        let rho = share * column.core_radius;
        let mut hits = 0usize;
        // With a finite `enough`, interleave the lines so that the early exit triggers soonest.
        let parts = if ring == 0 && enough.is_finite() { QUICK_LINES } else { 1 };
        for k in 0..count {
            let i = k % parts * (count / parts) + k / parts;
            let phi = std::f64::consts::TAU * i as f64 / count as f64;
            let line = line(rho, phi);
            // Only for rim lines the entry below the bottom is needed, for the refinement below.
            let deep = if ring == 0 { deep_rim } else { 0.0 };
            let (entry, highest) = stock.on_cached_line(before + i, &line, deep);
            depth = depth.max(highest);
            if depth > enough {
                return CoreContact { depth, area_share: area };
            }
            if entry > AREA_HEIGHT && stock.is_stock(&line.at(0.5 * AREA_HEIGHT)) {
                hits += 1;
            }
            if ring == 0 {
                rim[i] = (entry, phi);
            }
        }
        area += hits as f64 / count as f64 * ring_weight(rings, ring);
        before += count;
    }
    // Between rim lines the first entry may be higher: search its local maxima.
    let rim = &rim[..rings[0].1];
    let count = rim.len();
    let step = std::f64::consts::TAU / count as f64;
    for i in 0..count {
        let (before, here, after) = (rim[(i + count - 1) % count].0, rim[i].0, rim[(i + 1) % count].0);
        if here < before || here < after || here < deep_rim || !here.is_finite() {
            continue;
        }
        // Bound of the maximum: twice the rise of the steeper side.
        let most = here + 2.0 * (here - before).max(here - after);
        // A search skips maxima whose bound does not exceed the depth.
        if enough.is_finite() && most <= depth {
            continue;
        }
        let angle = rim[i].1;
        let around = [angle - step, angle, angle + step].map(|phi| line(column.core_radius, phi));
        let entered = stock.near.entered_below(most, &around);
        let mut removed = stock.removed.as_deref_mut();
        let rising = |phi: f64| {
            let (height, first) = entered.first_entry(&line(column.core_radius, phi));
            if let Some(removed) = removed.as_deref_mut().filter(|_| height.is_finite()) {
                removed[first] = true;
            }
            -height
        };
        let (phi, _) = search::minimum(rising, angle - step, angle + step, 1e-4);
        depth = depth.max(stock.on_line(&line(column.core_radius, phi), 0.0).1);
    }
    CoreContact { depth, area_share: area }
}

/// Height, mm, below which entries of rim lines are not distinguished, so that a line is finished once it
/// entered there. It is the distance between two rim lines: between two such entries, a crest of stock with
/// flanks of up to 45° stays below the bottom of the core.
fn deep_entry(column: &PlungeColumn) -> f64 {
    let apart = std::f64::consts::TAU * column.core_radius / RINGS[0].1 as f64;
    -apart.min(MAX_DEPTH_BELOW)
}

/// Share of the core disc that each ring represents: annuli with borders midway between the rings.
fn ring_weight(rings: &[(f64, usize)], ring: usize) -> f64 {
    let border = |i: usize| 0.5 * (rings[i].0 + rings[i + 1].0);
    let outer = if ring == 0 { 1.0 } else { border(ring - 1) };
    let inner = if ring + 1 == rings.len() { 0.0 } else { border(ring) };
    outer * outer - inner * inner
}

/// Finds stock on lines of one core.
struct StockLines<'a> {
    near: &'a mut Neighbours,
    blank: &'a Blank,
    top: f64,
    /// Warm start: shroud position of the last query.
    warm: Option<f64>,
    /// Cache for lines that are evaluated more than once.
    kept: Option<&'a mut [Option<LineRemainder>]>,
    /// Whether each of the gathered plunges removed anything from a line; without a cache.
    removed: Option<&'a mut [bool]>,
}

impl<'a> StockLines<'a> {
    fn new(column: &PlungeColumn, near: &'a mut Neighbours, blank: &'a Blank) -> Self {
        Self { near, blank, top: column.top, warm: None, kept: None, removed: None }
    }

    fn is_stock(&mut self, point: &Point) -> bool {
        self.blank.is_solid(Meridional::from_point(point), &mut self.warm)
    }

    /// (first entry into removed stock, highest stock) on the line, mm above the bottom; infinite and 0 where
    /// there is none. Where no stock is left, an entry below `deep` may be any such value.
    fn on_line(&mut self, line: &CoreLine, deep: f64) -> (f64, f64) {
        let mut left = LineRemainder::whole(self.top);
        self.near.cut_line_by_passed(&mut left, line, deep);
        match &mut self.removed {
            Some(removed) => self.near.cut_line(&mut left, line, deep, |number| removed[number] = true),
            None => self.near.cut_line(&mut left, line, deep, |_| {}),
        }
        (left.first, self.highest(&left, line))
    }

    /// As [`Self::on_line`], for line `number` of the cache.
    fn on_cached_line(&mut self, number: usize, line: &CoreLine, deep: f64) -> (f64, f64) {
        let Some(kept) = &mut self.kept else { return self.on_line(line, deep) };
        let gathered = kept[number].get_or_insert_with(|| {
            let mut left = LineRemainder::whole(self.top);
            self.near.cut_line(&mut left, line, deep, |_| {});
            left
        });
        if gathered.is_complete(deep) {
            return (gathered.first, 0.0);
        }
        let mut left = *gathered;
        self.near.cut_line_by_passed(&mut left, line, deep);
        (left.first, self.highest(&left, line))
    }

    /// The highest stock in what is left of a line, mm above the bottom.
    fn highest(&mut self, left: &LineRemainder, line: &CoreLine) -> f64 {
        let mut highest = 0.0f64;
        for &(a, b) in left.open[..left.count].iter().filter(|(a, b)| b - a > 1e-9 && *b > 0.0) {
            if b <= highest {
                continue;
            }
            if let Some(h) = self.blank.highest_inside(&line.origin, &line.axis, a, b, &mut self.warm) {
                highest = highest.max(h);
            }
        }
        highest
    }
}
