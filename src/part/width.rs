//! Width of a passage: the distance between its walls.

use super::channel::{Passage, Wall};
use super::impeller::Impeller;
use super::probe::SideProbe;

/// Number of steps from hub to shroud at which widths are measured.
const HEIGHTS: u32 = 4;

/// Measures the width of a passage.
#[derive(Debug)]
pub struct PassageWidth<'a> {
    part: &'a Impeller,
    passage: &'a Passage,
    /// Of both walls, at λ = 0 and λ = 1.
    probes: [SideProbe; 2],
}

impl<'a> PassageWidth<'a> {
    /// Prepares measurements of `passage` of `part`.
    pub fn new(part: &'a Impeller, passage: &'a Passage) -> Self {
        let probe = |wall: &Wall| SideProbe::new(wall.whole_side(), 0.0, 1.0);
        Self { part, passage, probes: [probe(&passage.walls[0]), probe(&passage.walls[1])] }
    }

    /// Distances from the point of each wall at (s, η) to the nearest point of the other wall, mm. `None`
    /// where the blade at that wall does not extend to (s, η).
    pub fn from_walls(&self, s: f64, eta: f64) -> [Option<f64>; 2] {
        [0, 1].map(|near| {
            let wall = &self.passage.walls[near];
            let place = wall.at(self.part, s, eta).filter(|place| wall.is_blade_at(place))?;
            let point = self.part.meridional(s, eta).at_angle(place.theta);
            Some(self.probes[1 - near].nearest_to_point(&point).distance)
        })
    }

    /// Width at (s, η), mm: the larger of both distances, the same whichever wall is at λ = 0. On staggered
    /// blades, the point of one wall at equal s may face the middle of the other wall, and the other point
    /// look past the end of the first. `None` where neither blade extends to (s, η).
    pub fn at(&self, s: f64, eta: f64) -> Option<f64> {
        self.from_walls(s, eta).into_iter().flatten().reduce(f64::max)
    }

    /// Least width at `s` between hub and shroud, mm; infinite where the walls do not reach.
    pub fn min_width(&self, s: f64) -> f64 {
        (0..=HEIGHTS)
            .filter_map(|j| self.at(s, f64::from(j) / f64::from(HEIGHTS)))
            .fold(f64::INFINITY, f64::min)
    }

    /// Least distance at `s` between the walls, from hub to shroud and from either wall, mm; infinite where
    /// they do not reach.
    pub fn least(&self, s: f64) -> f64 {
        let distances = (0..=HEIGHTS).flat_map(|j| self.from_walls(s, f64::from(j) / f64::from(HEIGHTS)));
        distances.flatten().fold(f64::INFINITY, f64::min)
    }
}
