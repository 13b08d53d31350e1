//! Plunges in cutting order, with a spatial index of their columns.

use super::index::{AxisQuery, PlungeIndex};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::CutterSolid;
use crate::part::Blank;

/// A plunge, as needed for contact.
#[derive(Clone, Copy, Debug)]
pub struct PlungeColumn {
    /// The cutter at its final depth.
    pub cutter: CutterSolid,
    /// Radius of the core, mm.
    pub core_radius: f64,
    /// Height above the tip from which on the core column is clear of the whole blank, mm.
    pub top: f64,
}

impl PlungeColumn {
    /// The column of a plunge into `blank`, with a core of `core_radius` mm.
    pub fn new(cutter: CutterSolid, core_radius: f64, blank: &BlankTop) -> Self {
        Self { cutter, core_radius, top: blank.above(&cutter, core_radius) }
    }

    /// The column when the plunge stops `lift` mm short.
    pub fn lifted(mut self, lift: f64) -> Self {
        self.cutter.tip += self.cutter.axis * lift;
        self.top -= lift;
        self
    }
}

/// Computes up to which height core columns can meet stock.
#[derive(Debug)]
pub struct BlankTop<'a> {
    blank: &'a Blank,
    /// The shroud, and the circles of the ends of the blank; `None` for a blank with an outline.
    surface: Option<DepthSurface<'a>>,
}

impl<'a> BlankTop<'a> {
    /// The top of `blank`.
    pub fn new(blank: &'a Blank) -> Self {
        // A small offset gives the circles of the outline a finite thickness.
        let surface = || DepthSurface::new(&blank.shroud, 0.01).with_edges(blank.hub_circles());
        let surface = blank.outline().is_none().then(surface);
        Self { blank, surface }
    }

    fn above(&self, cutter: &CutterSolid, core_radius: f64) -> f64 {
        let Some(surface) = &self.surface else {
            let touch = self.blank.outline_touch(&cutter.tip, &cutter.axis, core_radius.max(1e-6), 0.0);
            return touch.unwrap_or(0.0);
        };
        let radius = core_radius.max(1e-6);
        let shroud = surface.touch(&cutter.tip, &cutter.axis, radius).map(|touch| touch.height);
        let faces = self.blank.end_face_touch(&cutter.tip, &cutter.axis, radius);
        let found = shroud.into_iter().chain(faces).max_by(f64::total_cmp);
        // The search for the shroud may end where the axis crosses it before, or on the far side.
        let is_clear =
            |&top: &f64| !self.blank.has_stock_above(&cutter.tip, &cutter.axis, radius, top.max(0.0));
        found.filter(is_clear).unwrap_or_else(|| self.blank.exit_height(&cutter.tip, &cutter.axis, radius))
    }
}

/// Plunges in cutting order.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    all: Vec<PlungeColumn>,
    index: PlungeIndex,
}

impl Columns {
    /// Adds the next plunge.
    pub fn push(&mut self, column: PlungeColumn) {
        self.index.push(&column.cutter);
        self.all.push(column);
    }

    /// Removes all but the first `count` plunges.
    pub fn truncate(&mut self, count: usize) {
        self.all.truncate(count);
        self.index.truncate(count);
    }

    /// Number of plunges.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are no plunges.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The plunges.
    pub fn as_slice(&self) -> &[PlungeColumn] {
        &self.all
    }

    /// All plunges, as those cut before a further one.
    pub fn all(&self) -> Earlier<'_> {
        self.before(self.all.len())
    }

    /// The plunges cut before number `k`.
    pub fn before(&self, k: usize) -> Earlier<'_> {
        Earlier { columns: self, count: k }
    }
}

impl Extend<PlungeColumn> for Columns {
    fn extend<I: IntoIterator<Item = PlungeColumn>>(&mut self, columns: I) {
        columns.into_iter().for_each(|column| self.push(column));
    }
}

impl FromIterator<PlungeColumn> for Columns {
    fn from_iter<I: IntoIterator<Item = PlungeColumn>>(columns: I) -> Self {
        let mut all = Self::default();
        all.extend(columns);
        all
    }
}

/// The first `count` plunges: those cut before another one.
#[derive(Clone, Copy, Debug)]
pub struct Earlier<'a> {
    columns: &'a Columns,
    count: usize,
}

impl<'a> Earlier<'a> {
    /// The plunges that may have removed stock from the core of `column`, in cutting order.
    pub fn near(self, column: &PlungeColumn) -> impl DoubleEndedIterator<Item = &'a PlungeColumn> + use<'a> {
        let all = &self.columns.all;
        self.numbers_near(column).into_iter().map(|number| &all[number as usize])
    }

    /// As [`Self::near`], by their numbers.
    pub fn numbers_near(self, column: &PlungeColumn) -> Vec<u32> {
        self.columns.index.near(&column.core_query(), self.count)
    }
}

impl PlungeColumn {
    /// Whether the core of this column is close enough to the axis of `other` to meet its column.
    pub fn may_meet(&self, other: &CutterSolid) -> bool {
        self.core_query().meets(&other.tip, &other.axis, other.radius + self.core_radius)
    }

    /// Index query for its core.
    fn core_query(&self) -> AxisQuery {
        let CutterSolid { tip, axis, .. } = self.cutter;
        AxisQuery { tip, axis, reach: self.core_radius, top: self.top.max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};

    /// Deterministic pseudorandom numbers from 0 to 1.
    fn dice(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A random plunge on a field of 600 mm, inclined by up to about 50°.
    fn column(seed: &mut u64) -> PlungeColumn {
        let mut between = |from: f64, to: f64| from + (to - from) * dice(seed);
        let tip = Point::new(between(-300.0, 300.0), between(-300.0, 300.0), between(-20.0, 20.0));
        let axis = Vector::new(between(-0.8, 0.8), between(-0.8, 0.8), 1.0).normalize();
        let radius = [4.0, 15.0][usize::from(between(0.0, 1.0) > 0.5)];
        let cutter = CutterSolid { tip, axis, radius, corner_radius: 0.0 };
        PlungeColumn { cutter, core_radius: 0.6 * radius, top: between(10.0, 200.0) }
    }

    /// `count` plunges, each beside the one before, as in rows.
    fn row(count: usize, seed: &mut u64) -> Vec<PlungeColumn> {
        let first = column(seed);
        let mut beside = |step: f64| Vector::from_fn(|_, _| step * (dice(seed) - 0.5));
        let mut cutter = first.cutter;
        let mut next = || {
            cutter.tip += Vector::new(4.0, 0.0, 0.0) + beside(2.0);
            cutter.axis = (cutter.axis + beside(0.1)).normalize();
            PlungeColumn { cutter, ..first }
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn those_near_a_core_are_found_among_the_first_ones() {
        let mut seed = 7;
        let mut columns: Columns = (0..3000).map(|_| column(&mut seed)).collect();
        // Removed columns are not found, those added later are.
        columns.truncate(1000);
        columns.extend((0..500).map(|_| column(&mut seed)));
        (0..20).for_each(|_| columns.extend(row(50, &mut seed)));
        let mut found = 0;
        for k in (0..columns.len()).step_by(37) {
            let column = &columns.as_slice()[k];
            let number = |near: &PlungeColumn| columns.as_slice().iter().position(|c| std::ptr::eq(c, near));
            let near: Vec<usize> = columns.before(k).near(column).filter_map(number).collect();
            found += near.len();
            let met: Vec<usize> =
                (0..k).filter(|&n| column.may_meet(&columns.as_slice()[n].cutter)).collect();
            assert_eq!(near, met, "those that plunge {k} meets, in cutting order");
        }
        assert!(found > 300, "{found} were found");
    }
}
