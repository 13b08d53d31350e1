//! Where the searches on the lines of a side begin, and what they find.

use crate::geometry::Point;

/// Lines of v in the grid of a side that is not ruled; a ruled one bends only by its twist.
pub(super) const MAX_V_LINES: usize = 9;
/// Largest number of lines of a search: those of the grid, and the ends of the range.
pub(super) const MAX_LINES: usize = MAX_V_LINES + 2;

/// Start value of the search on a line of v.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seed {
    pub v: f64,
    /// The nearest grid line.
    pub line: usize,
    /// Index in u of the nearest point of the grid line, and its distance, mm.
    pub index: usize,
    pub distance: f64,
    /// Lower bound on the distance of the part of the side around the grid line, mm.
    pub bound: f64,
}

/// Seeds of neighbouring lines.
pub(super) struct Seeds {
    pub lines: [Seed; MAX_LINES],
    pub count: usize,
    /// Distance of the nearest grid point, mm.
    pub nearest: f64,
    /// Lower bound on the distance of the side, mm.
    pub lower_bound: f64,
}

impl Default for Seeds {
    fn default() -> Self {
        Self {
            lines: [Seed::default(); MAX_LINES],
            count: 0,
            nearest: f64::INFINITY,
            lower_bound: f64::INFINITY,
        }
    }
}

impl Seeds {
    pub fn push(&mut self, seed: Seed) {
        self.lines[self.count] = seed;
        self.count += 1;
        self.nearest = self.nearest.min(seed.distance);
        self.lower_bound = self.lower_bound.min(seed.bound);
    }

    /// The lines between which the nearest point must be, if it is nearer than `cutoff` mm.
    pub fn near(&self, cutoff: f64) -> &[Seed] {
        let lines = &self.lines[..self.count];
        let limit = cutoff.min(self.nearest);
        let may = |seed: &Seed| seed.bound <= limit;
        let (Some(first), Some(last)) = (lines.iter().position(may), lines.iter().rposition(may)) else {
            return lines;
        };
        &lines[first.saturating_sub(1)..(last + 2).min(lines.len())]
    }
}

/// Nearest point on a line of the side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LineMinimum {
    pub v: f64,
    pub u: f64,
    pub point: Point,
    /// Signed distance, mm, and its derivative by v.
    pub distance: f64,
    pub slope: f64,
    /// [`DistanceQuery::height`] of the point.
    pub height: f64,
}

impl LineMinimum {
    /// The nearer of two, this one if they are equally near.
    pub fn nearer_of(&self, other: &Self) -> Self {
        if other.distance < self.distance { *other } else { *self }
    }
}
