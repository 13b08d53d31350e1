//! Plunges in cutting order, and which of them are near.

use crate::geometry::{CutterSolid, Point, Vector};
use crate::part::Blank;
use crate::plunge::slotting::DepthSurface;

/// A plunge as contact sees it.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// The cutter at its final depth.
    pub cutter: CutterSolid,
    /// Radius of the core, mm.
    pub core_radius: f64,
    /// Height above the tip, mm, above which the core column is clear of the whole blank.
    pub top: f64,
}

impl Column {
    /// A plunge into `blank`.
    pub fn new(cutter: CutterSolid, core_radius: f64, blank: &BlankTop) -> Self {
        Self { cutter, core_radius, top: blank.above(&cutter, core_radius) }
    }

    /// The column of a plunge that stops `lift` mm short.
    pub fn lifted(mut self, lift: f64) -> Self {
        self.cutter.tip += self.cutter.axis * lift;
        self.top -= lift;
        self
    }
}

/// Finds how far up core columns can meet stock.
#[derive(Debug)]
pub struct BlankTop<'a> {
    surface: DepthSurface<'a>,
}

impl<'a> BlankTop<'a> {
    /// For columns in `blank`.
    pub fn new(blank: &'a Blank) -> Self {
        // A hair's breadth keeps the circles of the outline from being infinitely thin.
        Self { surface: DepthSurface::new(&blank.shroud, 0.01).with_edges(blank.end_circles()) }
    }

    fn above(&self, cutter: &CutterSolid, core_radius: f64) -> f64 {
        self.surface
            .touch(&cutter.tip, &cutter.axis, core_radius.max(1e-6))
            .map_or(f64::INFINITY, |t| t.height)
    }
}

/// Plunges of one block: neighbours in cutting order are neighbours on the hub.
const BLOCK: usize = 32;
/// How far up an axis is looked at at most, mm.
const FURTHEST: f64 = 1e4;

/// What holds all plunges of a block.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// First tip and first axis.
    tip: Point,
    axis: Vector,
    /// Largest distance of a tip from the first one, of an axis from the first one, and largest radius.
    aside: f64,
    turned: f64,
    radius: f64,
}

/// Plunges in cutting order.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    all: Vec<Column>,
    /// One for each [`BLOCK`] of `all`.
    blocks: Vec<Block>,
}

impl Columns {
    /// Adds the next plunge.
    pub fn push(&mut self, column: Column) {
        let cutter = &column.cutter;
        if self.all.len().is_multiple_of(BLOCK) {
            let (tip, axis, radius) = (cutter.tip, cutter.axis, cutter.radius);
            self.blocks.push(Block { tip, axis, aside: 0.0, turned: 0.0, radius });
        } else if let Some(block) = self.blocks.last_mut() {
            block.aside = block.aside.max((cutter.tip - block.tip).norm());
            block.turned = block.turned.max((cutter.axis - block.axis).norm());
            block.radius = block.radius.max(cutter.radius);
        }
        self.all.push(column);
    }

    /// Forgets all but the first `count`.
    pub fn truncate(&mut self, count: usize) {
        self.all.truncate(count);
        self.blocks.truncate(count.div_ceil(BLOCK));
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The plunges.
    pub fn as_slice(&self) -> &[Column] {
        &self.all
    }

    /// All of them as what was cut before another one.
    pub fn all(&self) -> Earlier<'_> {
        self.before(self.all.len())
    }

    /// What was cut before number `k`.
    pub fn before(&self, k: usize) -> Earlier<'_> {
        Earlier { columns: &self.all[..k], blocks: &self.blocks }
    }
}

impl Extend<Column> for Columns {
    fn extend<I: IntoIterator<Item = Column>>(&mut self, columns: I) {
        columns.into_iter().for_each(|column| self.push(column));
    }
}

impl FromIterator<Column> for Columns {
    fn from_iter<I: IntoIterator<Item = Column>>(columns: I) -> Self {
        let mut all = Self::default();
        all.extend(columns);
        all
    }
}

/// Plunges that were cut before another one.
#[derive(Clone, Copy, Debug)]
pub struct Earlier<'a> {
    columns: &'a [Column],
    blocks: &'a [Block],
}

impl<'a> Earlier<'a> {
    /// Those that may have removed some of the core of `column`, in cutting order.
    pub fn near(self, column: &Column) -> impl DoubleEndedIterator<Item = &'a Column> + use<'a> {
        self.around(&column.cutter, column.core_radius, column.top)
    }

    /// Those that may remove something within `reach` mm of the axis of `cutter`, from its tip to `top` mm above, in
    /// cutting order. Some that do not are among them.
    pub fn around(
        self,
        cutter: &CutterSolid,
        reach: f64,
        top: f64,
    ) -> impl DoubleEndedIterator<Item = &'a Column> + use<'a> {
        let cutter = *cutter;
        self.columns
            .chunks(BLOCK)
            .zip(self.blocks)
            .filter(move |(_, block)| block.is_near(&cutter, reach, top))
            .flat_map(|(columns, _)| columns)
    }
}

impl Block {
    fn is_near(&self, cutter: &CutterSolid, reach: f64, top: f64) -> bool {
        // How far over the first tip of the block its plunges are asked about bounds how far its axes part.
        let top = top.min(FURTHEST);
        let parted = |height: f64| {
            let over = (cutter.tip + cutter.axis * height - self.tip).norm() + self.aside;
            self.aside + self.turned * over
        };
        let spread = parted(0.0).max(parted(top));
        within(cutter, &self.tip, &self.axis, reach + self.radius + spread, top)
    }
}

impl Column {
    /// Whether the core of this column comes near enough to `other` for that to have removed some of it.
    pub fn may_meet(&self, other: &CutterSolid) -> bool {
        let reach = other.radius + self.core_radius;
        within(&self.cutter, &other.tip, &other.axis, reach, self.top)
    }
}

/// Whether the axis of `cutter`, up to `top` mm above its tip, comes within `reach` mm of the line through `tip` along `axis`.
fn within(cutter: &CutterSolid, tip: &Point, axis: &Vector, reach: f64, top: f64) -> bool {
    // The square of the distance at height h: a h² + 2 b h + c.
    let from_tip = cutter.tip - tip;
    let (along, up) = (cutter.axis.dot(axis), from_tip.dot(axis));
    let a = 1.0 - along * along;
    let b = from_tip.dot(&cutter.axis) - up * along;
    let c = from_tip.norm_squared() - up * up;
    // Above the blank nothing matters.
    let h = if a > 1e-12 { (-b / a).min(top.min(FURTHEST)).max(0.0) } else { 0.0 };
    (a * h + 2.0 * b) * h + c < reach * reach
}
