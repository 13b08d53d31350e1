//! Sectional view of one position of a finished plan: a cut through its axis, along its row or in another
//! plane. For display only.
//!
//! Earlier cutters are drawn with sharp corners, the position's own cutter with its corner radius.
//!
//! Frame of the view: x along a direction perpendicular to the axis (see [`CutPlane`]), y along the axis of
//! the cutter, tip at (0, 0); mm.

use super::plan::{PlungePlan, Position};
use crate::geometry::{CutterSolid, Meridional, MeridionalCurve, Point, Vector, norm2};
use crate::part::{Blank, Impeller};
use crate::setup::Tool;

/// Distance from the plane beyond which the deepest contact does not count as shown, mm.
const BESIDE: f64 = 0.3;
/// Samples along x.
const SAMPLES: usize = 241;
/// Half width of the view in cutter radii.
const REACH: f64 = 2.2;
/// Number of cells across the core.
const PATCH: usize = 25;
/// Rings of points on which the deepest contact is searched: share of the core radius, number.
const CONTACT_RINGS: [(f64, u32); 4] = [(1.0, 192), (0.75, 64), (0.5, 32), (0.25, 8)];
/// Maximum steps and tolerance (mm) of the sphere tracing.
const MAX_STEPS: usize = 96;
const NEAR: f64 = 1e-4;

/// A point of the view: (x, y), mm.
pub type SectionPoint = [f64; 2];

/// Plane of a sectional view; each contains the axis of the cutter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutPlane {
    /// Along the feed direction of the row.
    #[default]
    Row,
    /// Across the row.
    Across,
    /// Through the point of the core that meets stock highest above the bottom; without contact as
    /// [`Self::Row`].
    Contact,
    /// Along the meridian of the hub, towards the inlet.
    Meridian,
}

impl CutPlane {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Row, Self::Across, Self::Contact, Self::Meridian];
}

/// Sectional view through the axis of a position.
#[derive(Clone, Debug)]
pub struct SectionView {
    /// The tip, origin of the view, in the frame of the part, mm.
    pub tip: Point,
    /// Unit axis, direction of y.
    pub axis: Vector,
    /// Unit feed direction, perpendicular to the axis.
    pub feed: Vector,
    /// The plane.
    pub plane: CutPlane,
    /// Unit direction of x in the disc of the core: its parts along and across the feed direction.
    pub x_in_disc: [f64; 2],
    /// Point of the core that meets stock highest above the bottom; `None` where it interferes with none.
    pub deepest: Option<PatchCell>,
    /// The finished hub.
    pub hub: Vec<SectionPoint>,
    /// The finished hub raised by the hub allowance.
    pub allowance: Vec<SectionPoint>,
    /// Top of the stock on the hub after all earlier positions.
    pub before: Vec<SectionPoint>,
    /// The same after this position.
    pub after: Vec<SectionPoint>,
    /// Stock that the core meets: intervals of y above the bottom at an x.
    pub contact: Vec<(f64, [f64; 2])>,
    /// The core's disc in cells, seen along the axis.
    pub patch: Vec<PatchCell>,
    /// The tool.
    pub tool: Tool,
    /// Angle between hub normal and axis in the plane of the view, rad: positive when the axis is inclined
    /// forward, in feed direction.
    pub lead_rad: f64,
    /// Step from the previous position in the same row, mm; 0 at the first. See [`step_before`].
    pub step: f64,
    /// Maximum height along y of the stock left on the hub within the radius of the cutter, mm.
    pub max_residual: f64,
}

/// A cell of the core's disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchCell {
    /// Coordinate along the feed direction, mm.
    pub x: f64,
    /// Coordinate across the feed direction, mm.
    pub across: f64,
    /// Height of stock above the bottom, mm; 0 where there is none.
    pub depth: f64,
}

/// Sectional view along the row through position `index` of `plan`, with a hub allowance of `allowance` mm;
/// `None` where the plan has no such position.
pub fn section_view(
    part: &Impeller,
    blank: &Blank,
    allowance: f64,
    plan: &PlungePlan,
    index: usize,
) -> Option<SectionView> {
    section_view_in(CutPlane::Row, part, blank, allowance, plan, index)
}

/// The same in another plane.
pub fn section_view_in(
    plane: CutPlane,
    part: &Impeller,
    blank: &Blank,
    allowance: f64,
    plan: &PlungePlan,
    index: usize,
) -> Option<SectionView> {
    let position = plan.positions.get(index)?;
    let tool = &plan.sections.get(position.section)?.tool;
    let (axis, tip) = (position.axis, position.tip);
    let feed = feed_direction(part, plan, index);
    let side = axis.cross(&feed);
    let radius = tool.radius();
    let reach = REACH * radius;
    let earlier = earlier_cutters(plan, index, 2.0 * reach);
    let cutter = tool.placed(tip, axis);
    let column = AxisLines { part, blank, axis, earlier: &earlier };
    let at = |x: f64, across: f64| tip + feed * x + side * across;
    // Rounding that counts as free is not shown as contact.
    let interferes = position.evaluation.contact.interferes();
    let deepest = column.deepest_contact(tool.core_radius(), reach, &at).filter(|_| interferes);
    let x_in_disc = match plane {
        CutPlane::Row => [1.0, 0.0],
        CutPlane::Across => [0.0, 1.0],
        CutPlane::Contact => match deepest {
            Some(PatchCell { x, across, .. }) if norm2(x, across) > 1e-9 => {
                // x grows in feed direction, as in the view along the row.
                let length = norm2(x, across).copysign(if x < 0.0 { -1.0 } else { 1.0 });
                [x / length, across / length]
            }
            _ => [1.0, 0.0],
        },
        CutPlane::Meridian => {
            let inwards = towards_inlet(part, position);
            let flat = [inwards.dot(&feed), inwards.dot(&side)];
            let length = norm2(flat[0], flat[1]);
            if length > 1e-9 { [flat[0] / length, flat[1] / length] } else { [1.0, 0.0] }
        }
    };

    let mut view = SectionView {
        tip,
        axis,
        feed,
        plane,
        x_in_disc,
        deepest,
        hub: Vec::with_capacity(SAMPLES),
        allowance: Vec::new(),
        before: Vec::with_capacity(SAMPLES),
        after: Vec::with_capacity(SAMPLES),
        contact: Vec::new(),
        patch: Vec::new(),
        tool: tool.clone(),
        lead_rad: 0.0,
        step: step_before(plan, index),
        max_residual: 0.0,
    };
    for i in 0..SAMPLES {
        let x = reach * (2.0 * i as f64 / (SAMPLES - 1) as f64 - 1.0);
        let origin = at(x * x_in_disc[0], x * x_in_disc[1]);
        let Some(hub) = column.hub(&origin, 0.0, reach) else { continue };
        view.hub.push([x, hub]);
        view.allowance.extend(column.hub(&origin, allowance, reach).map(|y| [x, y]));
        let mut stock = column.stock(&origin, hub, reach);
        view.before.push([x, stock_top(&stock, hub)]);
        if interferes && x.abs() <= tool.core_radius() {
            let met = stock.iter().filter(|s| s[1] > 0.0).map(|s| (x, [s[0].max(0.0), s[1]]));
            view.contact.extend(met);
        }
        let taken = cutter.column_interval(radius, &origin, &axis);
        remove_interval(&mut stock, taken.map(|(low, high)| (low.max(view.bottom(x)), high)));
        let top = stock_top(&stock, hub);
        view.after.push([x, top]);
        if x.abs() < radius {
            view.max_residual = view.max_residual.max(top - hub);
        }
    }
    // The deepest contact is often a sliver at the rim, between two samples.
    if let Some(cell) = deepest.filter(|_| view.shows_deepest()) {
        view.contact.push((view.deepest_along(), [0.0, cell.depth]));
    }
    view.lead_rad = lead_angle(&view.hub);
    let core = tool.core_radius();
    for i in 0..PATCH {
        for j in 0..PATCH {
            let of = |k: usize| core * (2.0 * (k as f64 + 0.5) / PATCH as f64 - 1.0);
            let (x, across) = (of(i), of(j));
            if norm2(x, across) > core {
                continue;
            }
            let origin = at(x, across);
            let hub = column.hub(&origin, 0.0, reach).unwrap_or(-reach);
            let stock = column.stock(&origin, hub, reach);
            let top = stock.last().filter(|_| interferes).map_or(0.0, |s| s[1].max(0.0));
            view.patch.push(PatchCell { x, across, depth: top });
        }
    }
    Some(view)
}

impl SectionView {
    /// Height of the cutter's bottom at `x` within its radius, mm: 0 except on the rounded corner.
    pub fn bottom(&self, x: f64) -> f64 {
        let corner = self.tool.corner_radius;
        let beyond = (x.abs() - (self.tool.radius() - corner)).clamp(0.0, corner);
        corner - (corner * corner - beyond * beyond).max(0.0).sqrt()
    }

    /// Signed distance of the deepest contact from the plane of the view, mm; 0 without contact.
    pub fn deepest_beside(&self) -> f64 {
        let [along, across] = self.x_in_disc;
        self.deepest.map_or(0.0, |cell| cell.across * along - cell.x * across)
    }

    /// Whether the deepest contact lies in the plane of the view, or so near to it that it is drawn there.
    pub fn shows_deepest(&self) -> bool {
        self.deepest_beside().abs() < BESIDE
    }

    /// x of the deepest contact, mm; 0 without contact.
    pub fn deepest_along(&self) -> f64 {
        let [along, across] = self.x_in_disc;
        self.deepest.map_or(0.0, |cell| cell.x * along + cell.across * across)
    }

    /// Maximum contact depth in the plane of the view, mm.
    pub fn contact_in_plane(&self) -> f64 {
        self.contact.iter().map(|(_, [_, top])| *top).fold(0.0, f64::max)
    }

    /// Maximum contact depth over the core, mm.
    pub fn contact_depth(&self) -> f64 {
        self.patch.iter().map(|cell| cell.depth).fold(0.0, f64::max)
    }
}

/// Unit feed direction of the row at position `index`, perpendicular to its axis.
pub fn feed_direction(part: &Impeller, plan: &PlungePlan, index: usize) -> Vector {
    let position = &plan.positions[index];
    let neighbour = |k: Option<usize>| {
        let other = plan.positions.get(k?)?;
        (other.section == position.section && other.row == position.row).then_some(other)
    };
    let (before, after) = (neighbour(index.checked_sub(1)), neighbour(Some(index + 1)));
    let along = match (before, after) {
        (Some(a), Some(b)) => b.tip - a.tip,
        (Some(a), None) => position.tip - a.tip,
        (None, Some(b)) => b.tip - position.tip,
        // The only position of its row: along the meridian, towards the inlet.
        (None, None) => towards_inlet(part, position),
    };
    let flat = along - position.axis * along.dot(&position.axis);
    if flat.norm() > 1e-9 { flat.normalize() } else { crate::geometry::frame_about(&position.axis).0 }
}

/// Unit tangent of the hub along its meridian at a position, towards the inlet.
fn towards_inlet(part: &Impeller, position: &Position) -> Vector {
    let theta = position.tip.y.atan2(position.tip.x);
    -part.hub.at(position.s).tangent.direction_at_angle(theta)
}

/// Step from the previous position of the row to position `index`: the larger of the distances of the axes at
/// both tips, mm; 0 at the first of a row.
pub fn step_before(plan: &PlungePlan, index: usize) -> f64 {
    let Some(here) = plan.positions.get(index) else { return 0.0 };
    let Some(before) = index.checked_sub(1).and_then(|k| plan.positions.get(k)) else { return 0.0 };
    if before.section != here.section || before.row != here.row {
        return 0.0;
    }
    let off = |p: &Position, q: &Position| {
        let d = q.tip - p.tip;
        (d - p.axis * d.dot(&p.axis)).norm()
    };
    off(before, here).max(off(here, before))
}

/// Range of indices of the row that position `index` belongs to.
pub fn row_of(plan: &PlungePlan, index: usize) -> std::ops::Range<usize> {
    run_around(&plan.positions, index, |position| (position.section, position.row))
}

/// Range of indices around `index` of the items with the same key as that one, without a gap; empty where
/// `index` is out of range.
pub(super) fn run_around<T, K: PartialEq>(
    items: &[T],
    index: usize,
    key: impl Fn(&T) -> K,
) -> std::ops::Range<usize> {
    let Some(here) = items.get(index).map(&key) else { return 0..0 };
    let same = |item: &&T| key(item) == here;
    let start = index - items[..index].iter().rev().take_while(same).count();
    let end = index + items[index..].iter().take_while(same).count();
    start..end
}

/// Cutters of the positions before `index` that may meet its column.
fn earlier_cutters(plan: &PlungePlan, index: usize, reach: f64) -> Vec<CutterSolid> {
    let here = &plan.positions[index];
    let placed = plan.positions[..index].iter().filter_map(|p| {
        let tool = &plan.sections.get(p.section)?.tool;
        Some(tool.placed(p.tip, p.axis))
    });
    // Axes differ by some ten degrees over the depth of a channel; cutters further away cannot be met.
    placed.filter(|c| (c.tip - here.tip).norm() < 4.0 * reach + c.radius).collect()
}

/// Casts lines parallel to the axis of the position.
struct AxisLines<'a> {
    part: &'a Impeller,
    blank: &'a Blank,
    axis: Vector,
    earlier: &'a [CutterSolid],
}

impl AxisLines<'_> {
    /// Height at which the line through `origin` meets the hub raised by `offset`, if it does within `reach`.
    fn hub(&self, origin: &Point, offset: f64, reach: f64) -> Option<f64> {
        sphere_trace(self.part.hub.curve(), offset, origin, &self.axis, reach)
    }

    /// The point of a core of `core` mm radius that meets stock highest, from points on rings; contact is
    /// highest at the rim, where stock ends. `at` places a point of the disc.
    fn deepest_contact(&self, core: f64, reach: f64, at: &impl Fn(f64, f64) -> Point) -> Option<PatchCell> {
        let mut deepest: Option<PatchCell> = None;
        for (share, lines) in CONTACT_RINGS {
            for k in 0..lines {
                let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / f64::from(lines)).sin_cos();
                let (x, across) = (share * core * cosine, share * core * sine);
                let origin = at(x, across);
                let hub = self.hub(&origin, 0.0, reach).unwrap_or(-reach);
                let depth = self.stock(&origin, hub, reach).last().map_or(0.0, |s| s[1].max(0.0));
                if depth > deepest.map_or(0.0, |cell| cell.depth) {
                    deepest = Some(PatchCell { x, across, depth });
                }
            }
        }
        deepest
    }

    /// Intervals of stock on the line, lowest first: from the hub up to the blank, less what earlier cutters
    /// removed.
    fn stock(&self, origin: &Point, hub: f64, reach: f64) -> Vec<[f64; 2]> {
        let high = hub + 40.0 * reach;
        let Some(top) = self.blank.highest_inside(origin, &self.axis, hub, high, &mut None) else {
            return Vec::new();
        };
        let mut stock = vec![[hub, top]];
        for cutter in self.earlier {
            remove_interval(&mut stock, cutter.column_interval(cutter.radius, origin, &self.axis));
        }
        stock
    }
}

/// Removes an interval from ordered intervals.
fn remove_interval(stock: &mut Vec<[f64; 2]>, taken: Option<(f64, f64)>) {
    let Some((low, high)) = taken else { return };
    let old = std::mem::take(stock);
    for [a, b] in old {
        if high <= a || low >= b {
            stock.push([a, b]);
            continue;
        }
        if low > a {
            stock.push([a, low]);
        }
        if high < b {
            stock.push([high, b]);
        }
    }
}

/// Top of the stock on the hub.
fn stock_top(stock: &[[f64; 2]], hub: f64) -> f64 {
    stock.first().filter(|s| s[0] <= hub + 1e-6).map_or(hub, |s| s[1])
}

/// Height at which a line from above meets the surface of revolution at `offset` from `curve`, by sphere
/// tracing: the distance to the curve never exceeds that to the surface along the line. `None` beyond the
/// ends of the curve.
fn sphere_trace(
    curve: &MeridionalCurve,
    offset: f64,
    origin: &Point,
    axis: &Vector,
    reach: f64,
) -> Option<f64> {
    let mut h = 0.5 * reach;
    let (mut guess, _) = curve.project(Meridional::from_point(&(origin + axis * h)));
    for _ in 0..MAX_STEPS {
        let (t, d) = curve.project_near(Meridional::from_point(&(origin + axis * h)), guess, 2.0 * reach);
        guess = t;
        let above = d - offset;
        if above.abs() < NEAR {
            let inside = t > 1e-6 && t < curve.length() - 1e-6;
            return inside.then_some(h);
        }
        h -= above;
        if h < -2.0 * reach {
            return None;
        }
    }
    None
}

/// Angle between the normal of the hub line at x = 0 and the y direction, rad.
fn lead_angle(hub: &[SectionPoint]) -> f64 {
    let Some(at) = hub.iter().position(|p| p[0] >= 0.0) else { return 0.0 };
    let (a, b) = (hub[at.saturating_sub(2)], hub[(at + 2).min(hub.len() - 1)]);
    (b[1] - a[1]).atan2(b[0] - a[0])
}
