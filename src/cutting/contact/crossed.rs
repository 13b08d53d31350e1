//! Intersection of the lines of one core with one earlier plunge.

use crate::geometry::cutter::column_interval;
use crate::geometry::{CutterSolid, Point, Vector, norm2};

/// Maximum Newton steps towards a rounded corner, and their tolerance, mm.
const MAX_CORNER_STEPS: usize = 24;
const CORNER_TOLERANCE: f64 = 1e-9;

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
    pub(super) number: usize,
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

/// A line of the core relative to an earlier plunge, see [`CrossedPlunge`].
#[derive(Clone, Copy, Debug)]
pub struct LineQuadratic {
    b: f64,
    c: f64,
    /// Height of its start above the bottom of the earlier plunge, mm.
    height: f64,
}

impl CrossedPlunge {
    pub(super) fn new(number: usize, cutter: &CutterSolid, frame: &CoreFrame) -> Self {
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
        self.interval(self.quadratic_below(f64::INFINITY, line)?)
    }

    /// What tells the interval of a line that the plunge would remove with a sharp corner, unless that
    /// certainly begins above `reach` or ends below the bottom of the core: the signs of the quadratic and
    /// its slope at these heights reject most intervals.
    #[inline(always)]
    pub fn quadratic_below(&self, reach: f64, line: &CoreLine) -> Option<LineQuadratic> {
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
        Some(LineQuadratic { b, c, height })
    }

    /// The interval that a quadratic of [`Self::quadratic_below`] tells.
    #[inline]
    pub fn interval(&self, LineQuadratic { b, c, height }: LineQuadratic) -> Option<(f64, f64)> {
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
    pub(super) fn from_cutter(cutter: &CutterSolid) -> Self {
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
