//! Pieces of a moving tool: what a slice of a body of revolution sweeps on a straight line, as an interval on
//! a ray.

mod place;

use super::outline::Outline;
use super::part::Action;
use crate::geometry::{Point, Vector, frame_about, norm2};

/// Newton steps to the rounded corner; the distance is convex along a ray, so they come closer without
/// passing it.
const CORNER_STEPS: usize = 40;
/// Distance from the corner at which they end, mm.
const CORNER_TOLERANCE: f64 = 1e-9;
/// Slack of the bounds of rays, for rounding, as a share of the lengths in them.
const SLACK: f64 = 1e-9;
/// Components of unit vectors below this count as 0.
const TINY: f64 = 1e-12;

/// A slice that moves on a straight line without turning.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Its outline.
    pub outline: Outline,
    /// Centre of its lower end where it starts, mm.
    pub base: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Its travel, mm; zero where it stands still.
    pub travel: Vector,
    /// What it does.
    pub action: Action,
    /// Number of its move.
    pub number: u32,
    /// Height of its lower end above that of the part of the tool it belongs to, mm.
    pub above: f64,
}

/// A piece with the rays of one direction expressed in its own frame.
pub struct PieceOnRays<'a> {
    piece: &'a Piece,
    frame: [Vector; 3],
    /// Ray direction and travel in the frame (across, across, along).
    ray: [f64; 3],
    travel: [f64; 3],
    moves: bool,
    /// Squared length of the travel across the axis.
    squared_across: f64,
}

/// The interval of a ray that a piece sweeps: coordinates, and the share of the travel at which they are
/// reached.
#[derive(Clone, Copy, Debug)]
pub struct SweptInterval {
    /// Where the ray enters, mm.
    pub low: f64,
    /// Share of the travel there, 0…1.
    pub low_share: f64,
    /// Where it leaves, mm.
    pub high: f64,
    /// Share of the travel there.
    pub high_share: f64,
}

impl SweptInterval {
    const NONE: Self = Self { low: f64::INFINITY, low_share: 0.0, high: f64::NEG_INFINITY, high_share: 0.0 };

    #[inline]
    fn add(&mut self, t: f64, share: f64) {
        if t < self.low {
            (self.low, self.low_share) = (t, share);
        }
        if t > self.high {
            (self.high, self.high_share) = (t, share);
        }
    }
}

/// Bounds of what a piece can sweep of a ray: the cylinder around it, cut off at the planes of its ends.
pub struct Extent {
    /// Directions across the axis of the piece, in its frame: along the rays, and at right angles to them.
    along: [f64; 2],
    aside: [f64; 2],
    /// The travel along them, from the lower to the higher end.
    moved: [(f64, f64); 2],
    /// Heights of the lower and the upper plane over the travel.
    heights: (f64, f64),
    squared_radius: f64,
    /// Rates across and along the axis on the way along a ray.
    across: f64,
    rise: f64,
}

impl Extent {
    /// Coordinates on the ray through `origin` (in the frame of the piece) between which the piece may sweep
    /// it; the first is greater where it does not.
    #[inline]
    pub fn on_ray(&self, origin: &[f64; 3]) -> (f64, f64) {
        let dot = |unit: &[f64; 2]| unit[0] * origin[0] + unit[1] * origin[1];
        let (at, side) = (dot(&self.along), dot(&self.aside));
        let [(back, front), (least, most)] = self.moved;
        let off = (least - side).max(side - most).max(0.0);
        let squared = self.squared_radius - off * off;
        if squared < 0.0 {
            return (f64::INFINITY, f64::NEG_INFINITY);
        }
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        if self.across > TINY {
            let half = squared.sqrt();
            (low, high) = ((back - half - at) / self.across, (front + half - at) / self.across);
        }
        if self.rise.abs() > TINY {
            let (p, q) = ((self.heights.0 - origin[2]) / self.rise, (self.heights.1 - origin[2]) / self.rise);
            (low, high) = (low.max(p.min(q)), high.min(p.max(q)));
        }
        (low, high)
    }
}

impl<'a> PieceOnRays<'a> {
    /// The piece for rays along coordinate `direction`.
    pub fn new(piece: &'a Piece, direction: usize) -> Self {
        let (x, y) = frame_about(&piece.axis);
        let frame = [x, y, piece.axis];
        let ray = frame.map(|unit| unit[direction]);
        let travel = frame.map(|unit| unit.dot(&piece.travel));
        let across = norm2(travel[0], travel[1]);
        let moves = across > TINY || travel[2].abs() > TINY;
        Self { piece, frame, ray, travel, moves, squared_across: across * across }
    }

    /// A point in the frame of the piece.
    #[inline]
    pub fn local(&self, point: &Point) -> [f64; 3] {
        let d = point - self.piece.base;
        [self.frame[0].dot(&d), self.frame[1].dot(&d), self.frame[2].dot(&d)]
    }

    /// The steps in the frame from a ray to its neighbours along both coordinates `across`.
    pub fn steps(&self, across: (usize, usize), spacing: f64) -> ([f64; 3], [f64; 3]) {
        (self.frame.map(|unit| unit[across.0] * spacing), self.frame.map(|unit| unit[across.1] * spacing))
    }

    /// Number of the piece's move.
    pub fn number(&self) -> u32 {
        self.piece.number
    }

    /// What the piece does.
    pub fn action(&self) -> Action {
        self.piece.action
    }

    /// Bounds of what the piece can sweep of any ray, or of the rays up to `beside` mm from any.
    pub fn extent(&self, beside: f64) -> Extent {
        let [ex, ey, rise] = self.ray;
        let across = norm2(ex, ey);
        let along = if across > TINY { [ex / across, ey / across] } else { [1.0, 0.0] };
        let aside = [-along[1], along[0]];
        let outline = &self.piece.outline;
        let [vx, vy, vz] = self.travel;
        let size = 1.0 + outline.radius + outline.length + vx.abs() + vy.abs() + vz.abs() + beside;
        let slack = SLACK * size;
        let moved = [along, aside].map(|unit| {
            let moved = unit[0] * vx + unit[1] * vy;
            (moved.min(0.0) - slack, moved.max(0.0) + slack)
        });
        Extent {
            along,
            aside,
            moved,
            heights: (vz.min(0.0) - beside - slack, vz.max(0.0) + outline.length + beside + slack),
            squared_radius: (outline.radius + beside + slack).powi(2),
            across,
            rise,
        }
    }

    /// The interval that the piece sweeps of the ray through `origin` (in the frame).
    ///
    /// The pairs (t, share) for which the point t of the ray is in the piece at this share of its travel are
    /// a convex set, bounded by a conic section and four lines. The extreme t are where the conic's tangent
    /// is parallel to the share, or on one of the lines; these are evaluated in closed form.
    #[inline]
    pub fn interval(&self, origin: &[f64; 3]) -> Option<SweptInterval> {
        let outline = &self.piece.outline;
        let mut found = SweptInterval::NONE;
        if !self.moves {
            let (low, high) = self.standing(origin)?;
            return Some(SweptInterval { low, low_share: 0.0, high, high_share: 0.0 });
        }
        let [vx, vy, vz] = self.travel;
        let moved = [origin[0] - vx, origin[1] - vy, origin[2] - vz];
        for (origin, share) in [(origin, 0.0), (&moved, 1.0)] {
            if let Some((low, high)) = self.standing(origin) {
                found.add(low, share);
                found.add(high, share);
            }
        }
        let [ex, ey, ez] = self.ray;
        let [ox, oy, oz] = *origin;
        // On the planes of both ends.
        for height in [0.0, outline.length] {
            let radius = outline.radius_at(height);
            let squared = radius * radius;
            if vz.abs() > TINY {
                // The share at which the point t of the ray is in the plane.
                let (a, b) = ((oz - height) / vz, ez / vz);
                let (px, py, qx, qy) = (ox - a * vx, oy - a * vy, ex - b * vx, ey - b * vy);
                let Some((mut low, mut high)) =
                    roots(qx * qx + qy * qy, px * qx + py * qy, px * px + py * py - squared)
                else {
                    continue;
                };
                clip(a, b, 0.0, 1.0, &mut low, &mut high);
                if low <= high && low.is_finite() && high.is_finite() {
                    found.add(low, (a + b * low).clamp(0.0, 1.0));
                    found.add(high, (a + b * high).clamp(0.0, 1.0));
                }
            } else if ez.abs() > TINY {
                let t = (height - oz) / ez;
                let (x, y) = (ox + t * ex, oy + t * ey);
                let share = ((x * vx + y * vy) / self.squared_across).clamp(0.0, 1.0);
                let (x, y) = (x - share * vx, y - share * vy);
                if x * x + y * y <= squared {
                    found.add(t, share);
                }
            }
        }
        // On the envelope of the outline: where its rate of change along the travel is 0.
        let (alpha, beta, gamma) = (outline.alpha, outline.beta, outline.gamma);
        let ss = self.squared_across + alpha * vz * vz;
        if ss.abs() > TINY * TINY {
            let ts = -(ex * vx + ey * vy + alpha * ez * vz);
            let tt = ex * ex + ey * ey + alpha * ez * ez;
            let t1 = ox * ex + oy * ey + alpha * oz * ez + beta * ez;
            let s1 = -(ox * vx + oy * vy + alpha * oz * vz + beta * vz);
            let c = ox * ox + oy * oy + alpha * oz * oz + 2.0 * beta * oz + gamma;
            // share = −(ts t + s1) / ss, put into the conic. Of a cone it may be a hyperbola; both roots are
            // points of the cone all the same.
            let (a, b, c) = (tt - ts * ts / ss, t1 - ts * s1 / ss, c - s1 * s1 / ss);
            let discriminant = b * b - a * c;
            if a.abs() > 1e-18 && discriminant > 0.0 {
                let root = discriminant.sqrt();
                for t in [(-b - root) / a, (-b + root) / a] {
                    let share = -(ts * t + s1) / ss;
                    let z = oz + t * ez - share * vz;
                    if (0.0..=1.0).contains(&share) && (0.0..=outline.length).contains(&z) {
                        found.add(t, share);
                    }
                }
            }
        }
        (found.low < found.high).then_some(found)
    }

    /// The interval of the ray through `origin` in the piece where it starts.
    #[inline]
    fn standing(&self, origin: &[f64; 3]) -> Option<(f64, f64)> {
        let outline = &self.piece.outline;
        let [ex, ey, ez] = self.ray;
        let [ox, oy, oz] = *origin;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        clip(oz, ez, 0.0, outline.length, &mut low, &mut high);
        if low > high {
            return None;
        }
        let (alpha, beta) = (outline.alpha, outline.beta);
        let a = ex * ex + ey * ey + alpha * ez * ez;
        let b = ox * ex + oy * ey + alpha * oz * ez + beta * ez;
        let c = ox * ox + oy * oy + alpha * oz * oz + 2.0 * beta * oz + outline.gamma;
        if a > 1e-18 {
            let discriminant = b * b - a * c;
            if discriminant <= 0.0 {
                return None;
            }
            let root = discriminant.sqrt();
            low = low.max((-b - root) / a);
            high = high.min((-b + root) / a);
        } else {
            // The ray runs more along the axis than the cone: between the planes of its ends it leaves the
            // cone at most once.
            let value = |t: f64| (a * t + 2.0 * b) * t + c;
            if !(low.is_finite() && high.is_finite()) {
                return None;
            }
            match (value(low) <= 0.0, value(high) <= 0.0) {
                (true, true) => {}
                (false, false) => return None,
                (starts, _) => {
                    let discriminant = (b * b - a * c).max(0.0).sqrt();
                    let candidates = if a < -1e-18 {
                        [(-b - discriminant) / a, (-b + discriminant) / a]
                    } else {
                        [-0.5 * c / b; 2]
                    };
                    let inside = candidates.into_iter().find(|t| (low..=high).contains(t));
                    let t = inside?;
                    if starts { high = t } else { low = t }
                }
            }
        }
        if low >= high {
            return None;
        }
        match outline.corner {
            Some(corner) => self.round_corner(origin, corner, (low, high)),
            None => Some((low, high)),
        }
    }

    /// Distance of the point `t` of a ray from a rounded corner, negative inside, and its rate along the ray.
    #[inline]
    fn corner_distance(&self, origin: &[f64; 3], (flat, corner): (f64, f64), t: f64) -> (f64, f64) {
        let [ex, ey, ez] = self.ray;
        let (x, y, z) = (origin[0] + t * ex, origin[1] + t * ey, origin[2] + t * ez);
        let radial = (x * x + y * y).sqrt();
        let (out, down) = (radial - flat, corner - z);
        let out_rate = if radial > TINY { (x * ex + y * ey) / radial } else { 0.0 };
        if out <= 0.0 && down <= 0.0 {
            return (-corner, 0.0);
        }
        if out <= 0.0 {
            return (down - corner, -ez);
        }
        if down <= 0.0 {
            return (out - corner, out_rate);
        }
        let length = (out * out + down * down).sqrt();
        (length - corner, (out * out_rate - down * ez) / length)
    }

    /// Narrows the interval in the cylinder around a rounded corner to that in the corner.
    fn round_corner(
        &self,
        origin: &[f64; 3],
        corner: (f64, f64),
        (mut low, mut high): (f64, f64),
    ) -> Option<(f64, f64)> {
        for at_high in [false, true] {
            let t = if at_high { &mut high } else { &mut low };
            for _ in 0..CORNER_STEPS {
                let (distance, rate) = self.corner_distance(origin, corner, *t);
                if distance <= CORNER_TOLERANCE {
                    break;
                }
                if at_high == (rate <= 0.0) {
                    return None;
                }
                *t -= distance / rate;
            }
        }
        (low < high).then_some((low, high))
    }
}

/// The interval between the roots of a t² + 2 b t + c, where it is negative; all t where it is negative
/// everywhere.
#[inline]
fn roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    if a > 1e-18 {
        let discriminant = b * b - a * c;
        if discriminant <= 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        Some(((-b - root) / a, (-b + root) / a))
    } else {
        (c <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY))
    }
}

/// Narrows [`low`, `high`] to the t with `least` ≤ a + b t ≤ `most`; `low` > `high` where there is none.
#[inline]
fn clip(a: f64, b: f64, least: f64, most: f64, low: &mut f64, high: &mut f64) {
    if b.abs() > TINY {
        let (p, q) = ((least - a) / b, (most - a) / b);
        *low = low.max(p.min(q));
        *high = high.min(p.max(q));
    } else if a < least || a > most {
        *high = f64::NEG_INFINITY;
        *low = f64::INFINITY;
    }
}
