//! Which floor the tools reach, and from which side [assessment paper, section I.D and fig. 6].
//!
//! A point of the hub floor is a *centre* when a tool can be placed on it: there is an axis whose cylinder
//! keeps the blade allowance from every blade side, whose cutter stays out of the hub further up, and whose
//! holder clears the blades and the turned blank, in which the neighbouring channels may still be solid: a
//! given shank and holder by their clearances, an assumed one without. Floor is *reached* where the bottom of
//! a tool on some centre covers it.
//!
//! An axis comes **from the outlet** when it is inclined by [`MIN_INCLINATION`] or more from the hub normal
//! of its foot towards the outlet (α ≤ −[`MIN_INCLINATION`]), so that the spindle is on the side of the
//! outlet. It comes **from the inlet** when it is inclined as much towards the inlet. An axis along the
//! normal reaches a point too, but from neither side. Inclinations along the flow range to `max_tilt` in both
//! directions; across the flow the axis is interpolated between the walls and pushed off the one it is too
//! near to. Rows that are cut from the outlet inwards need axes inclined towards the inlet, and vice versa:
//! where a point is reached from one side only, the map shows which cutting direction can work.
//!
//! The lift of a tilted tool bottom over a curved hub leaves stock but does not affect reach, so it is not
//! included.

use rayon::prelude::*;

pub use super::limits::{MIN_INCLINATION, ReachLimits, ReachSides};
use super::tool_placement::ReachObstacles;
use crate::geometry::{Meridional, Point, wrap_angle};
use crate::part::{BoundedPassage, Channel, Impeller, Passage, Workpiece};
use crate::setup::{SectionKind, Tool};

/// Rows along s.
const ROWS: usize = 40;
/// Cells across a passage.
const COLUMNS: usize = 24;
/// Number of points across a passage that are tested as centres, its middle among them; the borders between
/// them are found by bisection.
const CENTRES: usize = 15;
/// Bisections of a border: to 1/500 of the passage.
const BORDER_STEPS: usize = 5;

/// A section of the channel and its tool.
#[derive(Clone, Debug)]
pub struct ReachSection<'a> {
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// The tool.
    pub tool: &'a Tool,
    /// What it cuts.
    pub kind: SectionKind,
}

impl ReachSection<'_> {
    fn is_rest(&self) -> bool {
        self.kind == SectionKind::Rest
    }
}

/// A cell of the floor.
#[derive(Clone, Copy, Debug)]
pub struct FloorCell {
    /// λ of its middle, across the full channel.
    pub lambda: f64,
    /// Angle of its middle about Z, rad.
    pub theta: f64,
    /// Area, mm².
    pub area: f64,
    /// The sides from which its middle is reached.
    pub reached: ReachSides,
}

impl FloorCell {
    /// The cell with its λ across the channel between `walls` instead of across its passage.
    fn across(self, walls: [f64; 2], pitch: f64) -> Self {
        // Wall angles of different passages may differ by whole turns.
        let from_wall = wrap_angle(self.theta - walls[0] - 0.5 * pitch) + 0.5 * pitch;
        Self { lambda: from_wall / (walls[1] - walls[0]), ..self }
    }
}

/// Cells of the floor at one s, ordered by angle.
#[derive(Clone, Debug)]
pub struct ReachRow {
    /// s.
    pub s: f64,
    /// The cells of all passages at this s.
    pub cells: Vec<FloorCell>,
}

/// The reachability map.
#[derive(Clone, Debug)]
pub struct ReachMap {
    /// Rows from leading edge to rim, with the sides from which any tool reaches.
    pub rows: Vec<ReachRow>,
    /// Ends of each section, from the outlet end, and the index of its group among `groups`.
    sections: Vec<([f64; 2], usize)>,
    /// Rows with the sides from which the tools of sections that do not overlap reach: one group of all but
    /// rest milling, and one of each section of that.
    groups: Vec<Vec<ReachRow>>,
}

impl ReachMap {
    /// The map of the channel floor of `workpiece`.
    pub fn new(workpiece: &Workpiece, sections: &[ReachSection<'_>], limits: &ReachLimits) -> Self {
        let surroundings = ReachObstacles::new(workpiece, limits);
        let first: Vec<&ReachSection> = sections.iter().filter(|section| !section.is_rest()).collect();
        let rest = sections.iter().filter(|section| section.is_rest()).map(|section| vec![section]);
        let groups = std::iter::once(first).chain(rest);
        let groups: Vec<Vec<ReachRow>> =
            groups.map(|group| rows_of(workpiece, &group, &surroundings, limits)).collect();
        let mut last = 0;
        let group_of = |section: &ReachSection| {
            last += usize::from(section.is_rest());
            ([section.from, section.to], if section.is_rest() { last } else { 0 })
        };
        let sections = sections.iter().map(group_of).collect();
        let rows = groups[1..].iter().fold(groups[0].clone(), |mut rows, group| {
            rows.iter_mut().zip(group).for_each(|(row, other)| row.add(other));
            rows
        });
        Self { rows, sections, groups }
    }

    /// Share of the floor, by area, whose sides satisfy `wanted`; NaN without floor.
    pub fn share(&self, wanted: impl Fn(ReachSides) -> bool) -> f64 {
        share(self.rows.iter().flat_map(|row| &row.cells), wanted)
    }

    /// As [`Self::share`], of the floor of a section, by its index among those that the map was made of: what
    /// its tool reaches, and near its ends those of the sections beside it.
    pub fn share_of_section(&self, index: usize, wanted: impl Fn(ReachSides) -> bool) -> f64 {
        let ([from, to], group) = self.sections[index];
        let rows = self.groups[group].iter().filter(|row| (to..=from).contains(&row.s));
        share(rows.flat_map(|row| &row.cells), wanted)
    }

    /// The cell of the row at `s` nearest to `lambda` across the full channel.
    pub fn nearest(&self, s: f64, lambda: f64) -> Option<&FloorCell> {
        let row = self.rows.get(((s * ROWS as f64).max(0.0) as usize).min(ROWS - 1))?;
        let off = |cell: &FloorCell| (cell.lambda - lambda).abs();
        row.cells.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

/// The rows with the sides from which the tools of `sections`, which do not overlap, reach. Rest milling has
/// no cells beyond its section.
fn rows_of(
    workpiece: &Workpiece,
    sections: &[&ReachSection<'_>],
    surroundings: &ReachObstacles<'_>,
    limits: &ReachLimits,
) -> Vec<ReachRow> {
    let Workpiece { part, channel, .. } = workpiece;
    let s_of = |row: usize| (row as f64 + 0.5) / ROWS as f64;
    let holds = |section: &ReachSection, s: f64| (section.to..=section.from).contains(&s);
    let strips: Vec<Vec<FloorStrip>> = (0..ROWS)
        .into_par_iter()
        .map(|row| {
            let s = s_of(row);
            let tool = sections.iter().find(|section| holds(section, s)).map(|section| section.tool);
            let passages = passages_at(channel, s);
            passages.filter_map(|passage| FloorStrip::new(part, passage, s, tool, surroundings)).collect()
        })
        .collect();
    let mut centres = Vec::new();
    for (row, here) in strips.iter().enumerate() {
        // Where the splitter begins, the passages of one row have no successors in the next.
        let next = strips.get(row + 1).filter(|next| next.len() == here.len());
        for (k, strip) in here.iter().enumerate() {
            centres.extend(strip.centres(next.map(|next| &next[k])));
        }
    }
    (0..ROWS)
        .into_par_iter()
        .map(|row| {
            let s = s_of(row);
            let is_rest_elsewhere = sections.iter().any(|section| section.is_rest() && !holds(section, s));
            let walls = channel.full.wall_angles(part, s, 0.0).filter(|_| !is_rest_elsewhere);
            let Some(walls) = walls else { return ReachRow { s, cells: Vec::new() } };
            let cells = strips[row].iter().flat_map(|strip| strip.cells(&centres, surroundings, limits));
            let cells = cells.map(|cell| cell.across(walls, part.pitch())).collect();
            ReachRow { s, cells }
        })
        .collect()
}

impl ReachRow {
    /// Adds the sides from which other tools reach the same cells; nothing where `other` has none.
    fn add(&mut self, other: &Self) {
        for (cell, other) in self.cells.iter_mut().zip(&other.cells) {
            cell.reached = cell.reached.or(other.reached);
        }
    }

    /// Share of the row, by area, whose sides satisfy `wanted`; NaN without floor.
    pub fn share(&self, wanted: impl Fn(ReachSides) -> bool) -> f64 {
        share(self.cells.iter(), wanted)
    }
}

fn share<'c>(cells: impl Iterator<Item = &'c FloorCell>, wanted: impl Fn(ReachSides) -> bool) -> f64 {
    let (mut had, mut all) = (0.0, 0.0);
    for cell in cells {
        all += cell.area;
        if wanted(cell.reached) {
            had += cell.area;
        }
    }
    had / all
}

/// A line on the hub whose points are all centres; its ends may coincide.
struct CentreLine {
    ends: [Point; 2],
    radius: f64,
    sides: ReachSides,
}

impl CentreLine {
    /// Whether the bottom of a tool on the line covers `point`.
    fn cover(&self, point: &Point) -> bool {
        let (along, to) = (self.ends[1] - self.ends[0], point - self.ends[0]);
        let share = (to.dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (to - along * share).norm_squared() <= self.radius * self.radius
    }
}

/// The floor of one passage at one s.
struct FloorStrip {
    hub: Meridional,
    /// Angles of the walls.
    walls: [f64; 2],
    /// Area of a cell, mm².
    cell_area: f64,
    /// Radius of the tool there, mm.
    radius: f64,
    /// Tested points, by λ across the passage, with the sides from which a tool can be placed there. Between
    /// two of them the sides common to both apply.
    places: Vec<(f64, ReachSides)>,
}

/// The passages at `s` on the hub, from the first wall to the second.
fn passages_at(channel: &Channel, s: f64) -> impl Iterator<Item = &Passage> {
    let here = move |bounded: &BoundedPassage| bounded.begins[0] <= s && s < bounded.ends[0];
    channel.bounded_passages().into_iter().filter(here).map(|bounded| &channel.passages[bounded.index])
}

impl FloorStrip {
    /// Tests `tool` across `passage` at `s`; without a tool there are no centres. `None` where a wall does
    /// not extend to `s`.
    fn new(
        part: &Impeller,
        passage: &Passage,
        s: f64,
        tool: Option<&Tool>,
        surroundings: &ReachObstacles<'_>,
    ) -> Option<Self> {
        let hub = part.hub.point(s);
        let walls = passage.wall_angles(part, s, 0.0)?;
        let across = (walls[1] - walls[0]).abs() * hub.r;
        let cell_area = across / COLUMNS as f64 * part.hub.length() / ROWS as f64;
        let places = tool.map_or_else(Vec::new, |tool| {
            let aims = surroundings.inclinations(passage, s);
            sample_sides(|lambda| surroundings.sides_at(&aims, s, walls, lambda, tool))
        });
        Some(Self { hub, walls, cell_area, radius: tool.map_or(0.0, Tool::radius), places })
    }

    fn theta(&self, lambda: f64) -> f64 {
        self.walls[0] + lambda * (self.walls[1] - self.walls[0])
    }

    fn point(&self, lambda: f64) -> Point {
        self.hub.at_angle(self.theta(lambda))
    }

    /// Centres of this strip, each with the line to its neighbour on the `next` strip of the passage: beside
    /// a wall oblique to the rows, tools between the rows cover floor that those on them do not.
    fn centres(&self, next: Option<&Self>) -> Vec<CentreLine> {
        let free = |strip: &Self| -> Vec<(f64, ReachSides)> {
            strip.places.iter().filter(|(_, sides)| sides.any).copied().collect()
        };
        let neighbours = next.map(free).unwrap_or_default();
        let mut centres = Vec::new();
        for (lambda, sides) in free(self) {
            let point = self.point(lambda);
            centres.push(CentreLine { ends: [point; 2], radius: self.radius, sides });
            let off = |place: &&(f64, ReachSides)| (place.0 - lambda).abs();
            let nearest = neighbours.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            if let (Some(next), Some(place)) = (next, nearest.filter(|p| off(p) < 1.0 / CENTRES as f64)) {
                let ends = [point, next.point(place.0)];
                centres.push(CentreLine {
                    ends,
                    radius: self.radius.min(next.radius),
                    sides: sides.and(place.1),
                });
            }
        }
        centres
    }

    /// The sides from which a tool can be placed at `lambda`, by the tested points.
    fn sides(&self, lambda: f64) -> ReachSides {
        let above = self.places.partition_point(|(at, _)| *at < lambda);
        match (above.checked_sub(1).and_then(|below| self.places.get(below)), self.places.get(above)) {
            (Some((_, below)), Some((_, above))) => below.and(*above),
            _ => ReachSides::default(),
        }
    }

    /// The cells outside the blade allowance, with the sides from which tools on `centres` reach them.
    fn cells(
        &self,
        centres: &[CentreLine],
        surroundings: &ReachObstacles<'_>,
        limits: &ReachLimits,
    ) -> Vec<FloorCell> {
        let across = (self.walls[1] - self.walls[0]).abs() * self.hub.r;
        let cell = |j: usize| {
            let lambda = (j as f64 + 0.5) / COLUMNS as f64;
            let point = self.point(lambda);
            // The exact distance is needed only beside a wall.
            let beside = lambda.min(1.0 - lambda) * across < 4.0 * limits.blade_allowance;
            if beside && surroundings.blade_distance(&point) < limits.blade_allowance {
                return None;
            }
            let covering = centres.iter().filter(|c| c.cover(&point));
            let reached = covering.fold(self.sides(lambda), |sides, centre| sides.or(centre.sides));
            Some(FloorCell { lambda, theta: self.theta(lambda), area: self.cell_area, reached })
        };
        (0..COLUMNS).filter_map(cell).collect()
    }
}

/// Points across a passage with the result of `sides_at`: evenly spaced, and both sides of every border
/// between them.
fn sample_sides(sides_at: impl Fn(f64) -> ReachSides) -> Vec<(f64, ReachSides)> {
    // No tool fits on the walls themselves.
    let mut places = vec![(0.0, ReachSides::default())];
    for k in 1..=CENTRES + 1 {
        let lambda = k as f64 / (CENTRES + 1) as f64;
        let here = (lambda, if k <= CENTRES { sides_at(lambda) } else { ReachSides::default() });
        let (mut low, mut high) = (places[places.len() - 1], here);
        if low.1 != high.1 {
            for _ in 0..BORDER_STEPS {
                let middle = 0.5 * (low.0 + high.0);
                let sides = sides_at(middle);
                if sides == low.1 { low = (middle, sides) } else { high = (middle, sides) }
            }
            places.extend([low, high]);
        }
        places.push(here);
    }
    places
}
