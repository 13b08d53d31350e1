//! Intersection of the lines of one core with earlier plunges.

use super::columns::PlungeColumn;
use super::remainder::LineRemainder;
use crate::geometry::cutter::column_interval;
use crate::geometry::{CutterSolid, Point, Vector, norm2};

/// Maximum Newton steps towards a rounded corner, and their tolerance, mm.
const MAX_CORNER_STEPS: usize = 24;
const CORNER_TOLERANCE: f64 = 1e-9;
/// Capacity of the list of [`Neighbours::entered_below`]; where more plunges are found, all are evaluated.
const MAX_ENTERED: usize = 24;

/// A line along the axis of a core, from its bottom upwards.
pub struct CoreLine {
    /// Start on the bottom, in the frame of the part; x and y are its coordinates in the plane of the bottom
    /// from its centre, mm.
    pub origin: Point,
    x: f64,
    y: f64,
    /// Unit direction.
    pub axis: Vector,
}

impl CoreLine {
    /// The point at a height, mm.
    pub fn at(&self, height: f64) -> Point {
        self.origin + self.axis * height
    }
}

/// An earlier plunge prepared for intersection with the lines of one core. The lines are parallel, so what
/// depends on the direction is computed once for all of them; the rest are polynomials in x and y of
/// [`CoreLine`].
#[derive(Clone, Copy, Debug)]
pub struct CrossedPlunge {
    cutter: CutterSolid,
    /// Its number among the gathered plunges, 0 for the latest.
    number: usize,
    /// Cosine of the angle between both axes.
    along: f64,
    /// Height above the bottom of the earlier plunge: constant, by x, by y.
    height: [f64; 3],
    /// The quadratic a h² + 2 b h + c, negative where height h of the line is inside the infinite cylinder.
    /// Coefficients of b: 1, x, y; of c: 1, x, y, x², xy, y².
    a: f64,
    b: [f64; 3],
    c: [f64; 6],
}

impl CrossedPlunge {
    fn new(number: usize, cutter: &CutterSolid, frame: &CoreFrame) -> Self {
        let CoreFrame { tip, axis, across: [e1, e2] } = frame;
        let across = |v: &Vector| v - cutter.axis * v.dot(&cutter.axis);
        let from_tip = tip - cutter.tip;
        let (d, p, p1, p2) = (across(axis), across(&from_tip), across(e1), across(e2));
        Self {
            cutter: *cutter,
            number,
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

    /// Interval of the line that the plunge would remove with a sharp corner.
    #[inline]
    pub fn removed_by_sharp(&self, line: &CoreLine) -> Option<(f64, f64)> {
        self.removed_by_sharp_below(f64::INFINITY, line)
    }

    /// As [`Self::removed_by_sharp`], if the interval begins below `reach` and ends above the bottom of the
    /// core. Most intervals that do not are rejected by the signs of the quadratic and its slope at these
    /// heights.
    #[inline]
    pub fn removed_by_sharp_below(&self, reach: f64, line: &CoreLine) -> Option<(f64, f64)> {
        let CoreLine { x, y, .. } = *line;
        let height = self.height[0] + self.height[1] * x + self.height[2] * y;
        if self.along > 0.0 && height + self.along * reach <= 0.0 {
            return None;
        }
        let b = self.b[0] + self.b[1] * x + self.b[2] * y;
        let [c0, cx, cy, cxx, cxy, cyy] = self.c;
        let c = c0 + (cx + cxx * x + cxy * y) * x + (cy + cyy * y) * y;
        // Outside at the bottom, and further away above it.
        if c >= 0.0 && b >= 0.0 {
            return None;
        }
        // Outside up to `reach`.
        if reach.is_finite() && self.a * reach + b <= 0.0 && (self.a * reach + 2.0 * b) * reach + c >= 0.0 {
            return None;
        }
        column_interval([self.a, b, c], height, self.along)
    }

    /// Interval that the plunge removes with its rounded corner, from that of a sharp one.
    #[inline]
    pub fn round_corner(&self, line: &CoreLine, low: f64, high: f64) -> Option<(f64, f64)> {
        if self.cutter.corner_radius == 0.0 {
            return Some((low, high));
        }
        let low = past_corner(&self.cutter, &line.origin, &line.axis, low, 1.0)?;
        let high = past_corner(&self.cutter, &line.origin, &line.axis, high, -1.0)?;
        (low < high).then_some((low, high))
    }
}

/// Where a core is at the end of its plunge: the centre of its bottom, its axis, and two directions
/// perpendicular to it.
#[derive(Clone, Copy, Debug, Default)]
pub struct CoreFrame {
    tip: Point,
    axis: Vector,
    across: [Vector; 2],
}

impl CoreFrame {
    /// The frame of the core of `cutter`. It turns with the plunge about Z, so that all channels give the
    /// same result.
    fn of(cutter: &CutterSolid) -> Self {
        let CutterSolid { tip, axis, .. } = *cutter;
        let outwards = Vector::new(tip.x, tip.y, 0.0).try_normalize(1e-9).unwrap_or_else(Vector::x);
        let helper = if axis.z.abs() < 0.9 { Vector::z() } else { outwards };
        let e1 = helper.cross(&axis).normalize();
        let e2 = axis.cross(&e1);
        Self { tip, axis, across: [e1, e2] }
    }

    /// The line of the core `rho` mm from its axis at angle `phi`.
    pub fn line(&self, rho: f64, phi: f64) -> CoreLine {
        let (sin, cos) = phi.sin_cos();
        self.line_at(rho * cos, rho * sin)
    }

    /// The line through a place on the bottom, by its coordinates from the centre, mm.
    pub fn line_at(&self, x: f64, y: f64) -> CoreLine {
        CoreLine { origin: self.tip + self.across[0] * x + self.across[1] * y, x, y, axis: self.axis }
    }
}

/// The earlier plunges that may meet a core column.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Latest first, until lines move those that they met to the front.
    columns: Vec<CrossedPlunge>,
    /// Plunges cut after all of `columns`.
    passed: Vec<CrossedPlunge>,
    frame: CoreFrame,
}

impl Neighbours {
    /// The neighbours of `column`: the `earlier` plunges that may meet it, in cutting order.
    pub fn of<'c>(column: &PlungeColumn, earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>) -> Self {
        let mut near = Self::default();
        near.gather(column, earlier);
        near
    }

    /// Where the core is.
    pub fn frame(&self) -> CoreFrame {
        self.frame
    }

    /// As [`Self::of`], reusing the existing allocation.
    pub fn gather<'c>(
        &mut self,
        column: &PlungeColumn,
        earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    ) {
        self.frame = CoreFrame::of(&column.cutter);
        self.columns.clear();
        self.passed.clear();
        let crossed =
            |(number, c): (usize, &PlungeColumn)| CrossedPlunge::new(number, &c.cutter, &self.frame);
        self.columns.extend(earlier.rev().enumerate().map(crossed));
    }

    /// Replaces the plunges cut after the gathered ones by `passed`, in cutting order.
    pub fn set_passed<'c>(&mut self, passed: impl DoubleEndedIterator<Item = &'c PlungeColumn>) {
        self.passed.clear();
        let crossed =
            |(number, c): (usize, &PlungeColumn)| CrossedPlunge::new(number, &c.cutter, &self.frame);
        self.passed.extend(passed.rev().enumerate().map(crossed));
    }

    /// Number of gathered plunges.
    pub fn count(&self) -> usize {
        self.columns.len()
    }

    /// Removes from `left` what the gathered plunges cut; stops as soon as further ones change nothing relevant.
    /// `note` gets the numbers of those that mattered, 0 for the latest.
    ///
    /// The order of the plunges does not matter. Those that did are moved to the front: the next line is
    /// mostly beside this one, and the same few plunges leave nothing of it.
    pub fn cut_line(
        &mut self,
        left: &mut LineRemainder,
        line: &CoreLine,
        deep: f64,
        mut note: impl FnMut(usize),
    ) {
        let mut front = 0;
        for index in 0..self.columns.len() {
            if left.is_complete(deep) {
                break;
            }
            if left.remove(&self.columns[index], line) {
                note(self.columns[index].number);
                self.columns.swap(index, front);
                front += 1;
            }
        }
    }

    /// Removes from `left` what the plunges after the gathered ones cut, as [`Self::cut_line`].
    pub fn cut_line_by_passed(&self, left: &mut LineRemainder, line: &CoreLine, deep: f64) {
        for crossed in &self.passed {
            if left.is_complete(deep) {
                break;
            }
            left.remove(crossed, line);
        }
    }

    /// Lowest height at which the line enters removed stock, mm, infinite if it does not, and the number of
    /// the plunge that removed it.
    pub fn first_entry(&self, line: &CoreLine) -> (f64, usize) {
        first_entry(self.passed.iter().chain(&self.columns), line)
    }

    /// The plunges that one of `lines` enters below `height`. On lines between these, the first entry is into
    /// one of them.
    pub fn entered_below(&self, height: f64, lines: &[CoreLine]) -> Entered<'_> {
        let mut entered = Entered { near: self, numbers: [0; MAX_ENTERED], count: 0 };
        for (number, crossed) in self.passed.iter().chain(&self.columns).enumerate() {
            let enters = |line| crossed.removed_by_sharp(line).is_some_and(|(low, _)| low < height);
            if lines.iter().any(enters) {
                if entered.count < MAX_ENTERED {
                    entered.numbers[entered.count] = number;
                }
                entered.count += 1;
            }
        }
        entered
    }

    /// Plunge `number` of passed and gathered ones, latest first.
    fn get(&self, number: usize) -> &CrossedPlunge {
        let later = self.passed.len();
        if number < later { &self.passed[number] } else { &self.columns[number - later] }
    }
}

/// The few plunges of [`Neighbours`] that some lines enter first.
pub struct Entered<'n> {
    near: &'n Neighbours,
    numbers: [usize; MAX_ENTERED],
    count: usize,
}

impl Entered<'_> {
    /// As [`Neighbours::first_entry`], among these plunges.
    pub fn first_entry(&self, line: &CoreLine) -> (f64, usize) {
        match self.numbers.get(..self.count) {
            Some(numbers) => first_entry(numbers.iter().map(|&number| self.near.get(number)), line),
            None => self.near.first_entry(line),
        }
    }
}

fn first_entry<'c>(plunges: impl Iterator<Item = &'c CrossedPlunge>, line: &CoreLine) -> (f64, usize) {
    let mut first = (f64::INFINITY, 0);
    for crossed in plunges {
        if let Some((low, high)) = crossed.removed_by_sharp(line)
            && low < first.0
            && let Some((low, high)) = crossed.round_corner(line, low, high)
            && high > 0.0
            && low < first.0
        {
            first = (low, crossed.number);
        }
    }
    first
}

/// Height at which the line crosses the surface of the rounded cutter, given the `height` at which it crosses
/// that of the sharp one, entering in direction `inwards` (±1) of the line. `None` when it misses the
/// corner.
///
/// The distance to a convex body is convex along a line, so Newton's method from outside converges
/// monotonically.
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
            // On the flat of the bottom and on the flank the rounded and the sharp cutter coincide.
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
