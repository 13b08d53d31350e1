//! The grid of cells over a channel's hub floor.

use crate::geometry::{Meridional, search};
use crate::part::{Blank, Channel, Impeller};

/// Cells over the hub floor of one channel, `rows` along s (row 0 at s = 0, the leading edge;
/// last row at s = 1, the rim) times `columns` along λ (0 suction wall → 1 pressure wall).
/// Cell (i, j) is at index `i * columns + j` of every list. f32, mm.
#[derive(Clone, Debug)]
pub struct FloorGrid {
    /// Number of cells along s.
    pub rows: usize,
    /// Number of cells along λ.
    pub columns: usize,
    /// Foot of each cell's ray on the finished hub.
    pub points: Vec<[f32; 3]>,
    /// Unit normal of the hub at the foot, into the channel.
    pub normals: Vec<[f32; 3]>,
    /// Height of the blank above the foot along the normal: what is there before any cut.
    pub blank_heights: Vec<f32>,
    /// Area of each cell, mm².
    pub areas: Vec<f32>,
    /// Whether the cell belongs to the floor (not under a splitter, not within the blade allowance).
    pub floor: Vec<bool>,
}

impl FloorGrid {
    /// The floor of `channel` in `cells` × `cells`; the blank is what is there before the first cut.
    pub fn new(
        part: &Impeller,
        channel: &Channel,
        blank: &Blank,
        blade_allowance: f64,
        cells: usize,
    ) -> Self {
        let count = cells * cells;
        let mut grid = Self {
            rows: cells,
            columns: cells,
            points: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            blank_heights: Vec::with_capacity(count),
            areas: Vec::with_capacity(count),
            floor: Vec::with_capacity(count),
        };
        for i in 0..cells {
            grid.add_row(part, channel, blank, blade_allowance, (i as f64 + 0.5) / cells as f64);
        }
        grid
    }

    /// s of the middle of row `row`.
    pub fn s_of_row(&self, row: usize) -> f64 {
        (row as f64 + 0.5) / self.rows as f64
    }

    fn add_row(&mut self, part: &Impeller, channel: &Channel, blank: &Blank, allowance: f64, s: f64) {
        let hub = part.hub.at(s);
        let height = {
            let (foot, normal) = (hub.point.at_angle(0.0), hub.normal.direction_at_angle(0.0));
            let reach = 2.0 * part.rim_radius();
            first_exit(blank, |h| Meridional::of(&(foot + normal * h)), reach)
        };
        let angles = channel.full.wall_angles(part, s, 0.0);
        let [low, high] = angles.unwrap_or([0.0, part.pitch()]);
        // Walls run oblique to the meridian: the allowance takes more of the circumference then.
        let slope = |theta_s: f64| {
            let tangent = hub.point.r * theta_s / part.hub.length();
            (1.0 + tangent * tangent).sqrt() / hub.point.r
        };
        let margin =
            |wall: &crate::part::Wall| wall.at(part, s, 0.0).map_or(0.0, |w| allowance * slope(w.theta_s));
        let margins = [margin(&channel.full.walls[0]), margin(&channel.full.walls[1])];
        // What the splitter's foot covers, as angles from the low wall.
        let sign = part.pitch().signum();
        let covered = channel.splitter_s.filter(|[at_hub, _]| s >= *at_hub).and_then(|_| {
            let near = &channel.beside_splitter[0];
            let far = &channel.beside_splitter[1];
            let from = near.wall_angles(part, s, 0.0)?;
            let to = far.wall_angles(part, s, 0.0)?;
            let a = (from[1] - from[0]) * sign - margin(&near.walls[1]);
            let b = (high - low) * sign - (to[1] - to[0]) * sign + margin(&far.walls[0]);
            Some(a..b)
        });
        let width = (high - low).abs();
        let cell = width / self.columns as f64;
        let area = (cell * hub.point.r * part.hub.length() / self.rows as f64) as f32;
        let turn = (cell * sign).sin_cos();
        let mut direction = (low + 0.5 * cell * sign).sin_cos();
        for j in 0..self.columns {
            let across = (j as f64 + 0.5) * cell;
            let (sin, cos) = direction;
            self.points.push([(hub.point.r * cos) as f32, (hub.point.r * sin) as f32, hub.point.z as f32]);
            self.normals.push([
                (hub.normal.r * cos) as f32,
                (hub.normal.r * sin) as f32,
                hub.normal.z as f32,
            ]);
            self.blank_heights.push(height as f32);
            self.areas.push(area);
            let inside = across >= margins[0] && across <= width - margins[1];
            self.floor.push(inside && !covered.as_ref().is_some_and(|c| c.contains(&across)));
            direction = (sin * turn.1 + cos * turn.0, cos * turn.1 - sin * turn.0);
        }
    }
}

/// Height along a ray from the hub at which it first leaves the blank.
fn first_exit(blank: &Blank, at: impl Fn(f64) -> Meridional, reach: f64) -> f64 {
    let mut warm = None;
    let mut depth = |h: f64| blank.depth_near(at(h), &mut warm);
    let stride = reach / 400.0;
    let mut inside = (0.0, 0.0);
    let mut h = 1e-3;
    while h < reach {
        let here = (h, depth(h));
        if here.1 <= 0.0 {
            return if inside.1 > 0.0 { search::root_from(depth, inside, here, h, 1e-6) } else { inside.0 };
        }
        // The outline is at least as far off as the point is deep.
        inside = here;
        h += stride.max(here.1);
    }
    reach
}
