//! Contact of the core (DESIGN section 3): where the part of the cutter without edges meets stock that no
//! earlier plunge removed. An exact question about half-infinite cylinders and the turned
//! blank, answered by intervals along lines of the core.

use super::plan::{CONTACT_TOLERANCE, CoreContact};
use super::slotting::DepthSurface;
use crate::geometry::cutter::column_interval;
use crate::geometry::{CutterSolid, Meridional, Point, Vector, frame_about, norm2, search};
use crate::part::Blank;

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

/// Rings of lines through the core: (share of the core radius, lines). Contact starts at the
/// rim of the core, so most lines are there.
const RINGS: [(f64, usize); 5] = [(1.0, 48), (0.75, 24), (0.5, 16), (0.25, 8), (0.0, 1)];
/// The same for searches.
const SEARCH_RINGS: [(f64, usize); 3] = [(1.0, 24), (0.55, 8), (0.0, 1)];
/// Uncovered stretches of one line that are kept apart.
const STRETCHES: usize = 12;
/// Newton steps towards a rounded corner, and the distance from it that counts as on it, mm.
const MAX_CORNER_STEPS: usize = 24;
const CORNER_TOLERANCE: f64 = 1e-9;
/// Contact a plan may have, mm: well below the tolerance of the verdict, so that rounding in a CL file or
/// another checker's samples do not tip it.
const PLANNED_CONTACT: f64 = 0.25 * CONTACT_TOLERANCE;
/// An entry this far below the bottom, mm, is as good as one further below.
const DEEP_ENTRY: f64 = -0.2;
/// Height above the bottom, mm, at which stock counts for the contact area.
const AREA_HEIGHT: f64 = 0.02;

/// Contact of `column`'s core with the stock of `blank` that `earlier` plunges left.
pub fn core_contact(column: &Column, earlier: &[Column], blank: &Blank) -> CoreContact {
    contact_up_to(column, &Neighbours::of(column, earlier), blank, &RINGS, f64::INFINITY)
}

/// Whether the contact is deeper than a planner may leave it: as [`core_contact`], but done at the first line
/// that says so.
pub fn core_interferes(column: &Column, earlier: &[Column], blank: &Blank) -> bool {
    let near = Neighbours::of(column, earlier);
    contact_up_to(column, &near, blank, &RINGS, PLANNED_CONTACT).depth > PLANNED_CONTACT
}

/// By how much a planned plunge must stop short for its core to be free, mm: the depth of [`core_contact`], 0 when it
/// is no deeper than a plan may leave it.
pub fn planned_contact(column: &Column, earlier: &[Column], blank: &Blank) -> f64 {
    let depth = core_contact(column, earlier, blank).depth;
    if depth > PLANNED_CONTACT { depth } else { 0.0 }
}

/// How far a search must lift a plunge for its core to be free: fewer lines than [`core_contact`], its
/// workspace kept from call to call.
#[derive(Debug, Default)]
pub struct ContactSearch {
    near: Neighbours,
}

impl ContactSearch {
    /// Contact depth of `column`, mm, 0 when it is no deeper than a plan may leave it. Any value above `enough`
    /// when it is deeper than that.
    pub fn depth<'c>(
        &mut self,
        column: &Column,
        earlier: impl DoubleEndedIterator<Item = &'c Column>,
        blank: &Blank,
        enough: f64,
    ) -> f64 {
        self.near.gather(column, earlier);
        let enough = enough.max(PLANNED_CONTACT);
        let depth = contact_up_to(column, &self.near, blank, &SEARCH_RINGS, enough).depth;
        if depth > PLANNED_CONTACT { depth } else { 0.0 }
    }
}

/// Contact; the search may end as soon as the depth exceeds `enough`.
fn contact_up_to(
    column: &Column,
    near: &Neighbours,
    blank: &Blank,
    rings: &[(f64, usize)],
    enough: f64,
) -> CoreContact {
    if column.top <= 0.0 {
        return CoreContact::default();
    }
    let mut stock = StockLines { near, blank, top: column.top, warm: None };
    let line = |rho: f64, phi: f64| near.line(rho, phi);
    let mut depth = 0.0f64;
    let mut area = 0.0;
    // (value, angle) of the rim lines: entry into what is already removed, negative below the bottom.
    let mut rim = [(0.0f64, 0.0f64); RINGS[0].1];
    for (ring, &(share, count)) in rings.iter().enumerate() {
        let rho = share * column.core_radius;
        let mut hits = 0usize;
        for i in 0..count {
            let phi = std::f64::consts::TAU * i as f64 / count as f64;
            let line = line(rho, phi);
            // Only of the rim it matters how far below the bottom a line that is free of stock enters.
            let deep = if ring == 0 { DEEP_ENTRY } else { 0.0 };
            let (entry, highest) = stock.on_line(&line, deep);
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
    }
    // Between the lines of the rim the first entry may rise higher: follow it to its top.
    let rim = &rim[..rings[0].1];
    let count = rim.len();
    let step = std::f64::consts::TAU / count as f64;
    for i in 0..count {
        let (before, here, after) = (rim[(i + count - 1) % count].0, rim[i].0, rim[(i + 1) % count].0);
        if here < before || here < after || here < DEEP_ENTRY || !here.is_finite() {
            continue;
        }
        let (phi, _) = search::minimum(
            |phi| -near.first_entry(&line(column.core_radius, phi)),
            rim[i].1 - step,
            rim[i].1 + step,
            1e-4,
        );
        depth = depth.max(stock.on_line(&line(column.core_radius, phi), 0.0).1);
    }
    CoreContact { depth, area_share: area }
}

/// Share of the core disc each ring stands for: annuli midway between the rings.
fn ring_weight(rings: &[(f64, usize)], ring: usize) -> f64 {
    let border = |i: usize| 0.5 * (rings[i].0 + rings[i + 1].0);
    let outer = if ring == 0 { 1.0 } else { border(ring - 1) };
    let inner = if ring + 1 == rings.len() { 0.0 } else { border(ring) };
    outer * outer - inner * inner
}

/// A line along the axis of a core, from its bottom upwards.
struct CoreLine {
    /// Where it starts: on the bottom, and in the plane of the bottom from its centre, mm.
    origin: Point,
    x: f64,
    y: f64,
    /// Unit direction.
    axis: Vector,
}

impl CoreLine {
    fn at(&self, height: f64) -> Point {
        self.origin + self.axis * height
    }
}

/// An earlier plunge as the lines of one core meet it. They are parallel, so that what depends on the direction alone is
/// worked out once for all of them, and the rest are polynomials in x and y of [`CoreLine`].
#[derive(Clone, Copy, Debug)]
struct Crossed {
    cutter: CutterSolid,
    /// Cosine of the angle between both axes.
    along: f64,
    /// Height above the bottom of the earlier plunge: constant, by x, by y.
    height: [f64; 3],
    /// The quadratic a h² + 2 b h + c by which a height h on the line is inside the endless cylinder when it is negative: a;
    /// b constant, by x, by y; c constant, by x, y, x², xy, y².
    a: f64,
    b: [f64; 3],
    c: [f64; 6],
}

impl Crossed {
    fn new(cutter: &CutterSolid, tip: &Point, axis: &Vector, [e1, e2]: &[Vector; 2]) -> Self {
        let across = |v: &Vector| v - cutter.axis * v.dot(&cutter.axis);
        let from_tip = tip - cutter.tip;
        let (d, p, p1, p2) = (across(axis), across(&from_tip), across(e1), across(e2));
        Self {
            cutter: *cutter,
            along: axis.dot(&cutter.axis),
            height: [&from_tip, e1, e2].map(|v| v.dot(&cutter.axis)),
            a: d.norm_squared(),
            b: [&p, &p1, &p2].map(|v| v.dot(&d)),
            c: [
                p.norm_squared() - cutter.radius * cutter.radius,
                2.0 * p.dot(&p1),
                2.0 * p.dot(&p2),
                p1.norm_squared(),
                2.0 * p1.dot(&p2),
                p2.norm_squared(),
            ],
        }
    }

    /// Interval of the line that the plunge has removed, its rounded corner respected.
    #[inline]
    fn removed(&self, line: &CoreLine) -> Option<(f64, f64)> {
        let CoreLine { x, y, .. } = *line;
        let b = self.b[0] + self.b[1] * x + self.b[2] * y;
        let [c0, cx, cy, cxx, cxy, cyy] = self.c;
        let c = c0 + (cx + cxx * x + cxy * y) * x + (cy + cyy * y) * y;
        let height = self.height[0] + self.height[1] * x + self.height[2] * y;
        let (low, high) = column_interval([self.a, b, c], height, self.along)?;
        if self.cutter.corner_radius == 0.0 {
            return Some((low, high));
        }
        let low = past_corner(&self.cutter, &line.origin, &line.axis, low, 1.0)?;
        let high = past_corner(&self.cutter, &line.origin, &line.axis, high, -1.0)?;
        (low < high).then_some((low, high))
    }
}

/// The earlier plunges that can touch a core column, latest first.
#[derive(Debug, Default)]
struct Neighbours {
    columns: Vec<Crossed>,
    /// Centre of the core's bottom, its axis, and two directions across.
    tip: Point,
    axis: Vector,
    across: [Vector; 2],
}

impl Neighbours {
    fn of(column: &Column, earlier: &[Column]) -> Self {
        let mut near = Self::default();
        near.gather(column, earlier.iter());
        near
    }

    /// The line of the core `rho` mm from its axis at angle `phi`.
    fn line(&self, rho: f64, phi: f64) -> CoreLine {
        let (sin, cos) = phi.sin_cos();
        let (x, y) = (rho * cos, rho * sin);
        CoreLine { origin: self.tip + self.across[0] * x + self.across[1] * y, x, y, axis: self.axis }
    }

    fn gather<'c>(&mut self, column: &Column, earlier: impl DoubleEndedIterator<Item = &'c Column>) {
        // Above the blank nothing matters; distances between straight axes change evenly.
        let heights = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * column.top.min(1e4));
        let (e1, e2) = frame_about(&column.cutter.axis);
        (self.tip, self.axis, self.across) = (column.cutter.tip, column.cutter.axis, [e1, e2]);
        self.columns.clear();
        self.columns.extend(
            earlier
                .rev()
                .filter(|other| {
                    let slope = column.cutter.axis.cross(&other.cutter.axis).norm();
                    heights.iter().zip(&heights[1..]).any(|(&low, &high)| {
                        let middle = 0.5 * (low + high);
                        let d = column.cutter.tip + column.cutter.axis * middle - other.cutter.tip;
                        let flat = (d - other.cutter.axis * d.dot(&other.cutter.axis)).norm();
                        flat - slope * 0.5 * (high - low) < other.cutter.radius + column.core_radius
                    })
                })
                .map(|c| Crossed::new(&c.cutter, &self.tip, &self.axis, &self.across)),
        );
    }

    /// Lowest height on the line from which on something is already removed; infinite if nothing is.
    fn first_entry(&self, line: &CoreLine) -> f64 {
        let mut first = f64::INFINITY;
        for crossed in &self.columns {
            if let Some((low, high)) = crossed.removed(line)
                && high > 0.0
            {
                first = first.min(low);
            }
        }
        first
    }
}

/// Looks for stock on lines of one core.
struct StockLines<'a> {
    near: &'a Neighbours,
    blank: &'a Blank,
    top: f64,
    /// Where on the shroud the last look was.
    warm: Option<f64>,
}

impl StockLines<'_> {
    fn is_stock(&mut self, point: &Point) -> bool {
        self.blank.is_solid(Meridional::of(point), &mut self.warm)
    }

    /// (height from which on something is already removed, or any below `deep` where no stock is left, highest stock) on the line from the bottom
    /// upwards, mm above it; infinite and 0 where there is none.
    fn on_line(&mut self, line: &CoreLine, deep: f64) -> (f64, f64) {
        let mut open = [(0.0f64, self.top); STRETCHES];
        let mut count = 1;
        let mut first = f64::INFINITY;
        for crossed in &self.near.columns {
            let Some((low, high)) = crossed.removed(line) else { continue };
            if high > 0.0 {
                first = first.min(low);
            }
            if count == 0 {
                if first <= deep {
                    break;
                }
                continue;
            }
            let mut kept = [(0.0, 0.0); STRETCHES];
            let mut n = 0;
            for &(a, b) in &open[..count] {
                for piece in [(a, b.min(low)), (a.max(high), b)] {
                    if piece.0 < piece.1 && n < STRETCHES {
                        kept[n] = piece;
                        n += 1;
                    }
                }
            }
            (open, count) = (kept, n);
        }
        let mut highest = 0.0f64;
        for &(a, b) in open[..count].iter().filter(|(a, b)| b - a > 1e-9 && *b > 0.0) {
            if b <= highest {
                continue;
            }
            if let Some(h) = self.blank.highest_inside(&line.origin, &line.axis, a, b, &mut self.warm) {
                highest = highest.max(h);
            }
        }
        (first, highest)
    }
}

/// Where the line passes the surface of the rounded cutter, given where it passes that of the sharp one: at
/// `height`, going inwards in direction `inwards` (±1) of the line. `None` when it passes the corner by.
///
/// The distance to a convex body is convex along a line, so that Newton's steps from outside come closer without
/// passing it.
fn past_corner(
    cutter: &CutterSolid,
    origin: &Point,
    direction: &Vector,
    height: f64,
    inwards: f64,
) -> Option<f64> {
    if !height.is_finite() {
        return Some(height);
    }
    let rising = direction.dot(&cutter.axis);
    let mut h = height;
    for _ in 0..MAX_CORNER_STEPS {
        let d = origin + direction * h - cutter.tip;
        let z = d.dot(&cutter.axis);
        let radial = d - cutter.axis * z;
        let distance = radial.norm();
        let out = distance - (cutter.radius - cutter.corner_radius);
        let down = cutter.corner_radius - z;
        if out <= 0.0 || down <= 0.0 {
            // On the flat of the bottom or on the flank both are the same.
            return Some(h);
        }
        let length = norm2(out, down);
        let gap = length - cutter.corner_radius;
        if gap <= CORNER_TOLERANCE {
            return Some(h);
        }
        let rate = (out * radial.dot(direction) / distance - down * rising) / length;
        if rate * inwards >= 0.0 {
            return None;
        }
        h -= gap / rate;
    }
    Some(h)
}
