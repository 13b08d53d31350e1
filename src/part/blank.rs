//! The blank: by default the turned body between hub and shroud, from the line of leading edges to the rim;
//! or any turned body, by its outline.

use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use rayon::prelude::*;

use super::blank_shape::{BlankFile, BlankShape};
use super::end_face::EndFace;
use super::impeller::Impeller;
use super::meridional_outline::MeridionalOutline;
use super::nose::HubNose;
use crate::geometry::{Circle, Meridional, MeridionalCurve, Point, Vector, norm2, search};

/// Tolerance of the intersection of a line with the border of the blank, mm.
const BORDER_TOLERANCE: f64 = 1e-6;

/// Least step along a line that is searched for the blank, mm, and as a share of its length.
const MIN_STRIDE: f64 = 0.01;
const MIN_STRIDE_SHARE: f64 = 1.0 / 2000.0;

/// Height above a given one from which on stock counts as above it, mm.
const ABOVE: f64 = 1e-3;
/// Free radius about the axis of a cylinder, in its radii, down to which balls are to show that it is clear.
const CLEAR_BALL_RADII: f64 = 1.25;

/// A turned blank. Without an outline of its own, its outline runs along the hub, up the rim (a straight line
/// between the trailing edges), back along the shroud, and down the line of leading edges.
#[derive(Clone, Debug)]
pub struct Blank {
    /// Hub between leading edge (less the extension) and rim; normal into the blank. With an outline, all of
    /// it.
    pub hub: MeridionalCurve,
    /// Shroud over the same range of s; normal out of the blank.
    pub shroud: MeridionalCurve,
    /// Leading-edge line and rim line, hub to shroud, and the signs that make their inside positive.
    ends: [(Meridional, Meridional); 2],
    end_signs: [f64; 2],
    r_max: f64,
    z_range: (f64, f64),
    coarse_shroud: CoarseHeights,
    /// Distances from hub and from shroud, mm, up to which a locally nearest point of the curve is the
    /// globally nearest one.
    single: (f64, f64),
    /// The hub upstream of the blank; it is never cut, but rapids keep clear of it.
    nose: Option<HubNose>,
    /// The outline of another shape than [`BlankShape::Edges`]; the body under the hub is within it.
    outline: Option<Arc<MeridionalOutline>>,
    /// The file that it comes from.
    file: Option<Arc<BlankFile>>,
}

/// Share of a curve's length on either side of a guess over which a projection is searched first.
const WARM_SEARCH_SHARE: f64 = 0.2;

impl Blank {
    /// The blank of `part` between the edges of its blades, extended by `inlet_extension` mm upstream of the
    /// leading edge.
    pub fn from_part(part: &Impeller, inlet_extension: f64) -> Self {
        Self::shaped(part, inlet_extension, &BlankShape::Edges)
    }

    /// The blank of `part` with a shape; see [`Self::from_part`].
    pub fn shaped(part: &Impeller, inlet_extension: f64, shape: &BlankShape) -> Self {
        let outline = shape.outline(part, inlet_extension).map(Arc::new);
        let piece = |path: &super::Flowpath| {
            let from = path.arc_at(0.0) - inlet_extension;
            path.curve().piece(from, path.arc_at(1.0))
        };
        let shroud = piece(&part.shroud);
        let hub = match &outline {
            Some(_) => part.hub.curve().piece(0.0, part.hub.arc_at(1.0)),
            None => piece(&part.hub),
        };
        let mut r_max = 0.0f64;
        let mut z_range = (f64::INFINITY, f64::NEG_INFINITY);
        for curve in [&hub, &shroud] {
            for i in 0..=128 {
                let p = curve.point(curve.length() * f64::from(i) / 128.0);
                r_max = r_max.max(p.r);
                z_range = (z_range.0.min(p.z), z_range.1.max(p.z));
            }
        }
        let ends =
            [(hub.point(0.0), shroud.point(0.0)), (hub.point(hub.length()), shroud.point(shroud.length()))];
        let inside = hub.point(0.5 * hub.length()).lerp(shroud.point(0.5 * shroud.length()), 0.5);
        let end_signs =
            ends.map(|(a, b)| ((inside.r - a.r) * (b.z - a.z) - (inside.z - a.z) * (b.r - a.r)).signum());
        if let Some(outline) = &outline {
            (r_max, z_range) = outline.bounds();
        }
        let (r_max, z_range) = (r_max + 0.1, (z_range.0 - 0.1, z_range.1 + 0.1));
        let coarse_shroud = CoarseHeights::new(&shroud, r_max, z_range);
        let single = (unique_foot_distance(&hub), unique_foot_distance(&shroud));
        let nose = HubNose::from_hub(part.hub.curve(), part.hub.arc_at(0.0) - inlet_extension);
        let file = match shape {
            BlankShape::File(file) => Some(Arc::clone(file)),
            _ => None,
        };
        Self { hub, shroud, ends, end_signs, r_max, z_range, coarse_shroud, single, nose, outline, file }
    }

    /// The outline, where it is not that between hub and shroud.
    pub fn outline(&self) -> Option<&MeridionalOutline> {
        self.outline.as_deref()
    }

    /// The file that the blank comes from.
    pub fn file(&self) -> Option<&BlankFile> {
        self.file.as_deref()
    }

    /// Largest radius and range of heights, mm, rounded up by 0.1 mm.
    pub fn extent(&self) -> (f64, (f64, f64)) {
        (self.r_max, self.z_range)
    }

    /// Centre and radius of a ball, mm, that holds all that is solid before the first cut.
    pub fn ball(&self) -> (Point, f64) {
        let (mut radius, (mut low, mut high)) = self.extent();
        if let Some(nose) = &self.nose {
            let (of_nose, (from, to)) = nose.extent();
            (radius, low, high) = (radius.max(of_nose), low.min(from), high.max(to));
        }
        (Point::new(0.0, 0.0, 0.5 * (low + high)), norm2(radius, 0.5 * (high - low)))
    }

    /// Points along the leading-edge line and the rim line; revolved about Z they are circles that a cutter
    /// above the blank may touch.
    pub fn end_circles(&self) -> Vec<Meridional> {
        let steps = 6;
        self.ends
            .iter()
            .flat_map(|&(a, b)| (0..=steps).map(move |i| a.lerp(b, f64::from(i) / f64::from(steps))))
            .collect()
    }

    /// The circles of the leading-edge line and of the rim line at the hub.
    pub fn hub_circles(&self) -> [Meridional; 2] {
        self.ends.map(|(hub, _)| hub)
    }

    /// Height along `axis` (unit) above `centre`, mm, at which a disc of `radius` mm, lowered from above,
    /// touches the conical faces of the leading-edge line and of the rim line, between their circles; `None`
    /// where it misses both. Of a blank without an outline of its own.
    pub fn end_face_touch(&self, centre: &Point, axis: &Vector, radius: f64) -> Option<f64> {
        let touch = |(hub, shroud)| EndFace { hub, shroud }.touch_height(centre, axis, radius);
        self.ends.into_iter().filter_map(touch).max_by(f64::total_cmp)
    }

    /// Depth of `point` inside the blank, mm; negative outside. Near the outline it is the distance to the
    /// nearest bounding curve or line; its sign is correct everywhere.
    pub fn depth(&self, point: Meridional) -> f64 {
        self.depth_near(point, &mut None)
    }

    /// As [`Self::depth`]; `warm` holds the arc lengths on hub and shroud of the last call as a warm start.
    pub fn depth_near(&self, point: Meridional, warm: &mut Option<(f64, f64)>) -> f64 {
        if let Some(outline) = &self.outline {
            let (t, above_hub) = project(&self.hub, point, warm.map(|warm| warm.0), self.single.0);
            *warm = Some((t, 0.0));
            return above_hub.min(-outline.signed_distance(point).0);
        }
        // Early exit without a projection: the point is beyond one of the straight ends.
        let ends = self.ends_depth(point);
        if ends < 0.0 {
            return ends;
        }
        let (hub, shroud) = self.heights(point, warm);
        hub.min(-shroud).min(ends)
    }

    /// Depth inside the two straight ends of the outline.
    fn ends_depth(&self, point: Meridional) -> f64 {
        let side = |((a, b), sign): ((Meridional, Meridional), f64)| {
            let (dr, dz) = (b.r - a.r, b.z - a.z);
            sign * ((point.r - a.r) * dz - (point.z - a.z) * dr) / norm2(dr, dz)
        };
        side((self.ends[0], self.end_signs[0])).min(side((self.ends[1], self.end_signs[1])))
    }

    /// Signed distances from hub and shroud, positive away from the hub body.
    fn heights(&self, point: Meridional, warm: &mut Option<(f64, f64)>) -> (f64, f64) {
        let guess = warm.unzip();
        let (th, above_hub) = project(&self.hub, point, guess.0, self.single.0);
        let (ts, above_shroud) = project(&self.shroud, point, guess.1, self.single.1);
        *warm = Some((th, ts));
        (above_hub, above_shroud)
    }

    /// Distance from `point` (outside) to the blank's top: shroud, leading-edge line and rim line, and to the
    /// hub upstream of them. Negative where it is solid. `warm` as in [`Self::is_solid`].
    pub fn clearance(&self, point: Meridional, warm: &mut Option<f64>) -> f64 {
        self.nearest_top(point, warm).0
    }

    /// As [`Self::clearance`], with the nearest point of the top.
    pub fn nearest_top(&self, point: Meridional, warm: &mut Option<f64>) -> (f64, Meridional) {
        if let Some(outline) = &self.outline {
            let nearest = outline.signed_distance(point);
            let nose = self.nose.as_ref().filter(|_| nearest.0 > 0.0);
            return nose.and_then(|nose| nose.nearer_than(point, nearest.0)).unwrap_or(nearest);
        }
        let (t, shroud) = self.on_shroud(point, *warm);
        *warm = Some(t);
        let mut nearest = (shroud.abs(), self.shroud.point(t));
        for end in self.ends.map(|(a, b)| point.nearest_on_segment(a, b)) {
            if end.0 < nearest.0 {
                nearest = end;
            }
        }
        if shroud < 0.0 && self.ends_depth(point) > 0.0 {
            return (-nearest.0, nearest.1);
        }
        self.nose.as_ref().and_then(|nose| nose.nearer_than(point, nearest.0)).unwrap_or(nearest)
    }

    /// Signed distance from the shroud, positive outside.
    fn above_shroud(&self, point: Meridional, warm: &mut Option<f64>) -> f64 {
        let (t, height) = self.on_shroud(point, *warm);
        *warm = Some(t);
        height
    }

    /// Arc length and signed distance of the point of the shroud nearest to `point`; `warm` is an optional
    /// warm start.
    fn on_shroud(&self, point: Meridional, warm: Option<f64>) -> (f64, f64) {
        project(&self.shroud, point, warm, self.single.1)
    }

    /// Whether `point` is further than `distance` mm from everything that is solid before the first cut;
    /// where that takes a search, false.
    pub fn is_far(&self, point: Meridional, distance: f64) -> bool {
        if self.nose.as_ref().is_some_and(|nose| !nose.is_beyond(point, distance)) {
            return false;
        }
        if let Some(outline) = &self.outline {
            return outline.signed_distance(point).0 > distance;
        }
        let ends = self.ends_depth(point);
        // Between the lines of both ends, the shroud alone is in the way to the solid below it.
        ends < -distance || ends >= 0.0 && self.on_shroud(point, None).1 > distance
    }

    /// Whether `point` is solid before the first cut: under the shroud and between the ends, blank or hub
    /// body. `warm` holds the arc length on the shroud of the last call as a warm start.
    pub fn is_solid(&self, point: Meridional, warm: &mut Option<f64>) -> bool {
        match &self.outline {
            Some(outline) => outline.contains(point),
            None => self.free_radius(point, warm).is_none(),
        }
    }

    /// Radius of a ball about `point` that is certainly free of solid, mm; `None` if the point is solid.
    /// `warm` as in [`Self::is_solid`].
    fn free_radius(&self, point: Meridional, warm: &mut Option<f64>) -> Option<f64> {
        let ends = self.ends_depth(point);
        if ends < 0.0 {
            return Some(-ends);
        }
        let above = self.coarse_shroud.above(point).unwrap_or_else(|| self.above_shroud(point, warm));
        (above >= 0.0).then_some(above)
    }

    /// Highest h in [`low`, `high`] at which `origin + h · direction` (unit) is solid: steps down by free
    /// radii (sphere tracing), then refines the border by bracketed root finding. Chords shorter than
    /// 0.01 mm, or than 1/2000 of the line, may be missed where it grazes the blank. With an outline the
    /// crossings are exact. `warm` as in [`Self::is_solid`].
    pub fn highest_inside(
        &self,
        origin: &Point,
        direction: &Vector,
        low: f64,
        high: f64,
        warm: &mut Option<f64>,
    ) -> Option<f64> {
        let (low, high) = self.clip(origin, direction, 0.0, (low, high))?;
        if let Some(outline) = &self.outline {
            return outline.highest_inside(origin, direction, low, high);
        }
        let stride = (MIN_STRIDE_SHARE * (high - low)).max(MIN_STRIDE);
        let mut free_radius =
            |h: f64| self.free_radius(Meridional::from_point(&(origin + direction * h)), warm);
        let mut above = None;
        let mut h = high;
        while let Some(clear) = free_radius(h) {
            if h <= low {
                return None;
            }
            above = Some(h);
            h = (h - stride.max(clear)).max(low);
        }
        let Some(outside) = above else { return Some(h) };
        // Signed distance from the bounds of the blank, smooth except where two of them meet; its root is the
        // border.
        let mut out = |h: f64| {
            let point = Meridional::from_point(&(origin + direction * h));
            self.above_shroud(point, warm).max(-self.ends_depth(point))
        };
        let (inside, outside) = ((h, out(h)), (outside, out(outside)));
        if inside.1 < 0.0 && outside.1 > 0.0 {
            let guess = inside.0 + (outside.0 - inside.0) * inside.1 / (inside.1 - outside.1);
            return Some(search::root_from(out, inside, outside, guess, BORDER_TOLERANCE));
        }
        Some(h)
    }

    /// Whether there is stock above the height `low` mm over `origin` on the line along `direction` (unit),
    /// or on one of eight lines at `radius` mm about it. What is less than 1 µm above it does not count.
    pub fn has_stock_above(&self, origin: &Point, direction: &Vector, radius: f64, low: f64) -> bool {
        let (low, mut warm) = (low + ABOVE, None);
        let Some(high) = self.clear_height(origin, direction, radius, low, &mut warm) else { return false };
        let rim = Circle::new(origin, direction, radius);
        let beside = (0..8).map(|i| rim.point_and_derivative((FRAC_PI_4 * f64::from(i)).sin_cos()).0);
        std::iter::once(*origin)
            .chain(beside)
            .any(|line| self.highest_inside(&line, direction, low, high, &mut warm).is_some())
    }

    /// A height above `origin` from which on a cylinder of `radius` mm about the line along `direction`
    /// (unit) is clear of stock, by balls about its axis; `None` where that is so from `low` on.
    fn clear_height(
        &self,
        origin: &Point,
        direction: &Vector,
        radius: f64,
        low: f64,
        warm: &mut Option<f64>,
    ) -> Option<f64> {
        let (low, mut high) = self.clip(origin, direction, radius, (low, f64::INFINITY))?;
        while high > low {
            let at = Meridional::from_point(&(origin + direction * high));
            let free = self.free_radius(at, warm).unwrap_or(0.0);
            if free <= (CLEAR_BALL_RADII * radius).max(radius + MIN_STRIDE) {
                return Some(high);
            }
            high -= free - radius;
        }
        None
    }

    /// Height above which a cylinder of `radius` mm about the line `origin + h · direction` (unit) has
    /// certainly left the blank, mm; 0 where it does not enter it.
    pub fn exit_height(&self, origin: &Point, direction: &Vector, radius: f64) -> f64 {
        self.clip(origin, direction, radius, (0.0, f64::INFINITY)).map_or(0.0, |(_, high)| high)
    }

    /// Height along `axis` (unit) above `centre` at which a disc of `radius` mm, lowered from above, touches
    /// the outline raised by `offset` mm; `None` where it misses it, or the blank has no outline of its own.
    pub fn outline_touch(&self, centre: &Point, axis: &Vector, radius: f64, offset: f64) -> Option<f64> {
        let outline = self.outline.as_ref()?;
        let everywhere = (f64::NEG_INFINITY, f64::INFINITY);
        let range = self.clip(centre, axis, radius + offset, everywhere)?;
        outline.touch_height(
            centre,
            axis,
            (radius, offset),
            (range.0 - offset - radius, range.1 + offset + radius),
        )
    }

    /// The part of a line within `aside` mm of the height range and outer cylinder of the blank; elsewhere it
    /// cannot meet the blank.
    fn clip(
        &self,
        origin: &Point,
        direction: &Vector,
        aside: f64,
        (mut low, mut high): (f64, f64),
    ) -> Option<(f64, f64)> {
        let (z_range, r_max) = ((self.z_range.0 - aside, self.z_range.1 + aside), self.r_max + aside);
        if direction.z.abs() > 1e-12 {
            let (a, b) = ((z_range.0 - origin.z) / direction.z, (z_range.1 - origin.z) / direction.z);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        } else if origin.z < z_range.0 || origin.z > z_range.1 {
            return None;
        }
        let a = direction.x * direction.x + direction.y * direction.y;
        let b = origin.x * direction.x + origin.y * direction.y;
        let c = origin.x * origin.x + origin.y * origin.y - r_max * r_max;
        if a > 1e-18 {
            let discriminant = b * b - a * c;
            if discriminant <= 0.0 {
                return None;
            }
            low = low.max((-b - discriminant.sqrt()) / a);
            high = high.min((-b + discriminant.sqrt()) / a);
        } else if c > 0.0 {
            return None;
        }
        (low < high).then_some((low, high))
    }
}

/// Nearest point of `curve` as (arc length, signed distance). Searches near `guess` first and accepts that
/// result only where it is certainly the global one: inside the search range, and no further away than
/// `single`.
fn project(curve: &MeridionalCurve, point: Meridional, guess: Option<f64>, single: f64) -> (f64, f64) {
    if let Some(guess) = guess {
        let reach = WARM_SEARCH_SHARE * curve.length();
        let (t, distance) = curve.project_near(point, guess, reach);
        if distance.abs() <= single && (t - guess).abs() < reach - 1e-9 * curve.length() {
            return (t, distance);
        }
    }
    curve.project(point)
}

/// Greatest distance from `curve` up to which a point found by a warm search is certainly the globally
/// nearest: half the shortest chord between points further apart along the curve than that search reaches,
/// less the sample spacing.
fn unique_foot_distance(curve: &MeridionalCurve) -> f64 {
    const PLACES: usize = 64;
    let spacing = curve.length() / PLACES as f64;
    let apart = (WARM_SEARCH_SHARE * PLACES as f64).floor() as usize - 1;
    let at: Vec<Meridional> = (0..=PLACES).map(|i| curve.point(spacing * i as f64)).collect();
    let far = |i: usize| at[(i + apart).min(PLACES + 1)..].iter().map(move |b| (i, b));
    let chords = (0..=PLACES).flat_map(far).map(|(i, b)| at[i].distance(*b));
    (0.5 * (chords.fold(f64::INFINITY, f64::min) - spacing)).max(0.0)
}

/// Signed heights above a curve at the nodes of a coarse grid of the meridional plane. Between two points a
/// height changes by at most their distance, so one lookup decides most queries of above or below.
#[derive(Clone, Debug)]
struct CoarseHeights {
    heights: Vec<f64>,
    z_from: f64,
    spacing: (f64, f64),
}

impl CoarseHeights {
    const NODES: usize = 65;

    fn new(curve: &MeridionalCurve, r_max: f64, z_range: (f64, f64)) -> Self {
        let cells = (Self::NODES - 1) as f64;
        let spacing = (r_max / cells, (z_range.1 - z_range.0) / cells);
        let height = |node: usize| {
            let (i, j) = (node / Self::NODES, node % Self::NODES);
            let node = Meridional { r: spacing.0 * i as f64, z: z_range.0 + spacing.1 * j as f64 };
            curve.project(node).1
        };
        let heights = (0..Self::NODES * Self::NODES).into_par_iter().with_min_len(64).map(height).collect();
        Self { heights, z_from: z_range.0, spacing }
    }

    /// A lower bound on the height above the curve, or below it where negative, with the correct sign; `None`
    /// near the curve and outside the grid.
    #[inline]
    fn above(&self, point: Meridional) -> Option<f64> {
        let (x, y) = (point.r / self.spacing.0, (point.z - self.z_from) / self.spacing.1);
        let limit = (Self::NODES - 1) as f64;
        if !((0.0..=limit).contains(&x) && (0.0..=limit).contains(&y)) {
            return None;
        }
        let (i, j) = (x.round(), y.round());
        let to_node = norm2((x - i) * self.spacing.0, (y - j) * self.spacing.1);
        let height = self.heights[i as usize * Self::NODES + j as usize];
        (height.abs() > to_node).then(|| height - to_node.copysign(height))
    }
}
