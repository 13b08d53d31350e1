//! Which floor a cutter reaches, and from which side (paper C, section I.D and fig. 6).
//!
//! A place of the hub floor is a *centre* when a cutter can stand on it: there is an axis whose cylinder keeps the blade
//! allowance from every blade side, whose column stays out of the hub further up, and whose holder clears the blades
//! and the turned blank, in which the neighbouring channels may still be solid. Floor is *reached* where the bottom of
//! a cutter on some centre covers it.
//!
//! An axis comes **from the outlet** when it leans by [`LEAN`] or more from the hub normal of its foot towards the outlet
//! (α ≤ −[`LEAN`]): cutter and spindle stand on the outlet's side. It comes **from the inlet** when it leans as much
//! towards the inlet. An axis along the normal reaches a place too, but from neither side. Tilts run to `max_tilt`
//! both ways; sideways the axis is laid between the walls and pushed off the one it comes too near to.
//! Rows that are fed from the outlet inwards want axes that lean towards the inlet, and the other way round: where a
//! place is had from one side only, the map tells which feed can work.
//!
//! The lift that a tilted bottom needs over a curved hub is a matter of the stock it leaves, not of reach, and
//! is not asked for here.

use rayon::prelude::*;

use crate::geometry::{CutterSolid, Meridional, Point, Vector, frame_about, wrap_angle};
use crate::part::{Blank, Channel, Impeller, Passage, SideProbe, Tool};

/// A stretch of the channel and the cutter that is to work in it.
#[derive(Clone, Debug)]
pub struct Stretch<'a> {
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// The cutter.
    pub tool: &'a Tool,
}

/// What bounds the axes.
#[derive(Clone, Copy, Debug)]
pub struct ReachLimits {
    /// Stock that stays on the hub, mm.
    pub hub_allowance: f64,
    /// Stock that stays on the blades, mm.
    pub blade_allowance: f64,
    /// Largest angle between axis and hub normal along the flow, rad.
    pub max_tilt: f64,
}

/// From where a place can be had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// From the outlet.
    pub outlet: bool,
    /// From the inlet.
    pub inlet: bool,
    /// With an axis along the hub normal.
    pub upright: bool,
}

impl Sides {
    /// With whatever axis.
    pub fn any(self) -> bool {
        self.outlet || self.inlet || self.upright
    }

    /// From both sides.
    pub fn both(self) -> bool {
        self.outlet && self.inlet
    }
}

/// A piece of the floor.
#[derive(Clone, Copy, Debug)]
pub struct FloorCell {
    /// Its middle on the hub.
    pub point: Point,
    /// mm².
    pub area: f64,
    /// From where its middle is reached.
    pub reached: Sides,
}

/// Cells of the floor at one s, ordered by angle.
#[derive(Clone, Debug)]
pub struct FloorRow {
    /// s.
    pub s: f64,
    /// The cells of all passages that are there.
    pub cells: Vec<FloorCell>,
}

/// The reachability map.
#[derive(Clone, Debug)]
pub struct ReachMap {
    /// Rows from leading edge to rim.
    pub rows: Vec<FloorRow>,
}

/// Rows along s.
const ROWS: usize = 48;
/// Cells across a passage.
const COLUMNS: usize = 24;
/// Places across a passage that are tried as centres, its middle among them; the borders between them are found
/// by bisection.
const CENTRES: usize = 15;
/// Bisections of a border: a hundredth of the passage.
const BORDER_STEPS: usize = 4;
/// Least lean of an axis that comes from one side, and step of the tilts tried, rad.
pub const LEAN: f64 = 7.5 * std::f64::consts::PI / 180.0;
/// Pushes of an axis between the walls before it counts as blocked.
const PUSHES: usize = 5;

impl ReachMap {
    /// Map of the floor of `channel`.
    pub fn new(part: &Impeller, channel: &Channel, stretches: &[Stretch<'_>], limits: &ReachLimits) -> Self {
        let search = Search {
            part,
            sides: channel.sides.iter().map(|side| SideProbe::new(side, 0.0, 1.0)).collect(),
            blank: Blank::of(part, 0.0),
            limits: *limits,
        };
        let s_of = |row: usize| (row as f64 + 0.5) / ROWS as f64;
        let centres: Vec<Centre> = (0..ROWS)
            .into_par_iter()
            .flat_map_iter(|row| {
                let s = s_of(row);
                let stretch = stretches.iter().find(|x| (x.to..=x.from).contains(&s));
                stretch.map(|x| search.centres(channel, s, x.tool)).unwrap_or_default()
            })
            .collect();
        let rows = (0..ROWS)
            .into_par_iter()
            .map(|row| FloorRow { s: s_of(row), cells: search.cells(channel, s_of(row), &centres) })
            .collect();
        Self { rows }
    }

    /// Share of the floor, by area, whose sides are as `wanted`; NaN without floor.
    pub fn share(&self, wanted: impl Fn(Sides) -> bool) -> f64 {
        share(self.rows.iter().flat_map(|row| &row.cells), wanted)
    }

    /// The cell nearest to a point of the floor.
    pub fn nearest(&self, s: f64, theta: f64) -> Option<&FloorCell> {
        let row = self.rows.get(((s * ROWS as f64).max(0.0) as usize).min(ROWS - 1))?;
        let off = |cell: &FloorCell| wrap_angle(cell.point.y.atan2(cell.point.x) - theta).abs();
        row.cells.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

impl FloorRow {
    /// Share of the row, by area, whose sides are as `wanted`; NaN without floor.
    pub fn share(&self, wanted: impl Fn(Sides) -> bool) -> f64 {
        share(self.cells.iter(), wanted)
    }
}

fn share<'c>(cells: impl Iterator<Item = &'c FloorCell>, wanted: impl Fn(Sides) -> bool) -> f64 {
    let (mut had, mut all) = (0.0, 0.0);
    for cell in cells {
        all += cell.area;
        if wanted(cell.reached) {
            had += cell.area;
        }
    }
    had / all
}

/// A place on which a cutter can stand.
#[derive(Clone, Copy, Debug)]
struct Centre {
    point: Point,
    radius: f64,
    sides: Sides,
}

/// An axis in the meridional plane, to be laid between the walls: where it aims, and the walls' angles there.
struct Aim {
    /// Point on the axis about as high as the shroud.
    top: Meridional,
    /// Angles of the walls at that point.
    walls: [f64; 2],
}

/// The aims of one place in s; those towards one side least tilted first.
struct Aims {
    upright: Option<Aim>,
    outlet: Vec<Aim>,
    inlet: Vec<Aim>,
}

struct Search<'a> {
    part: &'a Impeller,
    sides: Vec<SideProbe>,
    blank: Blank,
    limits: ReachLimits,
}

impl Search<'_> {
    /// The passages that are there at `s` on the hub.
    fn passages<'c>(&self, channel: &'c Channel, s: f64) -> &'c [Passage] {
        match channel.splitter_s {
            Some([hub, _]) if s >= hub => &channel.beside_splitter,
            _ => std::slice::from_ref(&channel.full),
        }
    }

    /// Places across the channel at `s` on which `tool` can stand, the ends of each run of them included.
    fn centres(&self, channel: &Channel, s: f64, tool: &Tool) -> Vec<Centre> {
        let mut found = Vec::new();
        for passage in self.passages(channel, s) {
            let Some(walls) = passage.wall_angles(self.part, s, 0.0) else { continue };
            let aims = self.aims(passage, s);
            let sides_at = |lambda: f64| self.sides_at(&aims, s, walls, lambda, tool);
            let mut add = |lambda: f64, sides: Sides| {
                if sides.any() {
                    found.push(Centre { point: self.foot(s, walls, lambda), radius: tool.radius(), sides });
                }
            };
            // Nothing stands on the walls themselves.
            let mut last = (0.0, Sides::default());
            for k in 1..=CENTRES + 1 {
                let lambda = k as f64 / (CENTRES + 1) as f64;
                let here = (lambda, if k <= CENTRES { sides_at(lambda) } else { Sides::default() });
                if here.1 != last.1 {
                    let (mut low, mut high) = (last, here);
                    for _ in 0..BORDER_STEPS {
                        let middle = 0.5 * (low.0 + high.0);
                        let sides = sides_at(middle);
                        if sides == low.1 { low = (middle, sides) } else { high = (middle, sides) }
                    }
                    add(low.0, low.1);
                    add(high.0, high.1);
                }
                add(here.0, here.1);
                last = here;
            }
        }
        found
    }

    /// A point of the hub allowance surface.
    fn foot(&self, s: f64, walls: [f64; 2], lambda: f64) -> Point {
        let hub = self.part.hub.at(s);
        let raised = |p: f64, n: f64| p + self.limits.hub_allowance * n;
        Meridional { r: raised(hub.point.r, hub.normal.r), z: raised(hub.point.z, hub.normal.z) }
            .at_angle(walls[0] + lambda * (walls[1] - walls[0]))
    }

    /// What to aim at from `s`, both ways.
    fn aims(&self, passage: &Passage, s: f64) -> Aims {
        let hub = self.part.hub.at(s);
        let depth = hub.point.distance(self.part.shroud.point(s));
        let aim = |alpha: f64| {
            let height = depth / alpha.cos().max(0.3);
            let (sin, cos) = alpha.sin_cos();
            let along = |n: f64, t: f64| height * (cos * n - sin * t);
            let top = Meridional {
                r: hub.point.r + along(hub.normal.r, hub.tangent.r),
                z: hub.point.z + along(hub.normal.z, hub.tangent.z),
            };
            let s_top = self.part.shroud.s_at(self.part.shroud.curve().project(top).0);
            Some(Aim { top, walls: passage.wall_angles(self.part, s_top, 1.0)? })
        };
        let steps = (self.limits.max_tilt / LEAN + 1e-9).floor() as usize;
        let towards = |sign: f64| (1..=steps).filter_map(|k| aim(sign * LEAN * k as f64)).collect();
        Aims { upright: aim(0.0), outlet: towards(-1.0), inlet: towards(1.0) }
    }

    fn sides_at(&self, aims: &Aims, s: f64, walls: [f64; 2], lambda: f64, tool: &Tool) -> Sides {
        let foot = self.foot(s, walls, lambda);
        // Across the hub a wall is never further off than along the circumference.
        let around = lambda.min(1.0 - lambda) * (walls[1] - walls[0]).abs() * foot.x.hypot(foot.y);
        if around < tool.radius() + self.limits.blade_allowance {
            return Sides::default();
        }
        let stands = |aim: &Aim| self.stands(&foot, aim, lambda, tool);
        Sides {
            outlet: aims.outlet.iter().any(stands),
            inlet: aims.inlet.iter().any(stands),
            upright: aims.upright.as_ref().is_some_and(stands),
        }
    }

    /// Whether a cutter stands at `foot` with an axis that leans as `aim` along the flow.
    fn stands(&self, foot: &Point, aim: &Aim, lambda: f64, tool: &Tool) -> bool {
        let mut theta = aim.walls[0] + lambda * (aim.walls[1] - aim.walls[0]);
        for _ in 0..PUSHES {
            let top = aim.top.at_angle(theta);
            let Some(axis) = (top - foot).try_normalize(1e-9) else { return false };
            let Some(push) = self.push(&tool.placed(*foot, axis), &top) else {
                return self.column_clears_hub(foot, &axis, tool) && self.holder_clears(foot, &axis, tool);
            };
            if !push.is_finite() || push.abs() > self.part.pitch().abs() {
                return false;
            }
            theta += push;
        }
        false
    }

    /// By what angle the upper end `top` of an axis must turn about Z to clear the blade side that is too near
    /// by most; `None` where all are clear, NaN where turning does not help.
    fn push(&self, cutter: &CutterSolid, top: &Point) -> Option<f64> {
        const MARGIN: f64 = 1e-3;
        let wanted = self.limits.blade_allowance;
        let near = self
            .sides
            .iter()
            .filter_map(|side| side.nearest_below(cutter, wanted))
            .filter(|near| near.distance < wanted)
            .min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let up = (near.point - cutter.tip).dot(&cutter.axis);
        let away = cutter.tip + cutter.axis * up - near.point;
        let share = up / (top - cutter.tip).norm();
        let gain = share * away.normalize().dot(&Vector::new(-top.y, top.x, 0.0));
        Some(if share > 0.02 { (wanted - near.distance + MARGIN) / gain } else { f64::NAN })
    }

    /// Whether the cutter stays out of the hub above its bottom: a leaning column may meet the hub again.
    fn column_clears_hub(&self, foot: &Point, axis: &Vector, tool: &Tool) -> bool {
        let curve = self.part.hub.curve();
        let radius = tool.radius();
        let (from, steps) = (2.0 * radius, 8);
        (0..=steps).all(|i| {
            let up = from + (tool.overhang - from).max(0.0) * f64::from(i) / f64::from(steps);
            let (t, distance) = curve.project(Meridional::of(&(foot + axis * up)));
            // Beyond its ends the hub has an edge, not a surface.
            distance.abs() >= radius && (distance > 0.0 || t <= 0.0 || t >= curve.length())
        })
    }

    /// Whether the holder clears blades, hub and the turned blank.
    fn holder_clears(&self, foot: &Point, axis: &Vector, tool: &Tool) -> bool {
        let radius = 0.5 * tool.holder_diameter();
        let holder =
            CutterSolid { tip: foot + axis * tool.overhang, axis: *axis, radius, corner_radius: 0.0 };
        let (e1, e2) = frame_about(axis);
        let around = 12;
        let rim = |k: i32, up: f64| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(around)).sin_cos();
            Meridional::of(&(holder.tip + axis * up + (e1 * cos + e2 * sin) * radius))
        };
        let mut warm = None;
        let outside = |p: Meridional, warm: &mut Option<f64>| self.blank.clearance(p, warm) >= 0.0;
        let mut bottom_clear = true;
        for up in [0.0, 2.0 * radius] {
            for k in 0..around {
                bottom_clear &= outside(rim(k, up), &mut warm);
            }
        }
        bottom_clear
            && self
                .sides
                .iter()
                .all(|side| side.nearest_below(&holder, 0.0).is_none_or(|n| n.distance >= 0.0))
    }

    /// The floor at `s` outside the blade allowance, with what the cutters on `centres` reach of it.
    fn cells(&self, channel: &Channel, s: f64, centres: &[Centre]) -> Vec<FloorCell> {
        let hub = self.part.hub.at(s);
        let mut cells = Vec::new();
        for passage in self.passages(channel, s) {
            let Some(walls) = passage.wall_angles(self.part, s, 0.0) else { continue };
            let across = (walls[1] - walls[0]).abs() * hub.point.r;
            let area = across / COLUMNS as f64 * self.part.hub.length() / ROWS as f64;
            for j in 0..COLUMNS {
                let lambda = (j as f64 + 0.5) / COLUMNS as f64;
                let point = hub.point.at_angle(walls[0] + lambda * (walls[1] - walls[0]));
                let allowance = self.limits.blade_allowance;
                let near_wall = |side: &SideProbe| side.nearest_to_point(&point).distance < allowance;
                // Only beside a wall is there anything to measure.
                let beside = lambda.min(1.0 - lambda) * across < 4.0 * allowance;
                if beside && self.sides.iter().any(near_wall) {
                    continue;
                }
                let mut reached = Sides::default();
                for centre in centres.iter().filter(|c| (c.point - point).norm() <= c.radius) {
                    reached.outlet |= centre.sides.outlet;
                    reached.inlet |= centre.sides.inlet;
                    reached.upright |= centre.sides.upright;
                }
                cells.push(FloorCell { point, area, reached });
            }
        }
        cells
    }
}
