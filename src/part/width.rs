//! Width of a passage: the distance between its walls.

use super::channel::Passage;
use super::impeller::Impeller;
use super::probe::SideProbe;

/// Measures the width of a passage.
#[derive(Debug)]
pub struct PassageWidth<'a> {
    part: &'a Impeller,
    passage: &'a Passage,
    far_wall: SideProbe,
}

impl<'a> PassageWidth<'a> {
    /// Prepares measurements of `passage` of `part`.
    pub fn new(part: &'a Impeller, passage: &'a Passage) -> Self {
        Self { part, passage, far_wall: SideProbe::new(passage.walls[1].whole_side(), 0.0, 1.0) }
    }

    /// Distance from the wall at λ = 0 at (s, η) to the nearest point of the other wall, mm; on staggered
    /// blades the point at equal s is further away. `None` where the blade at λ = 0 does not extend to (s,
    /// η).
    pub fn at(&self, s: f64, eta: f64) -> Option<f64> {
        let wall = self.passage.walls[0].at(self.part, s, eta)?;
        if !self.passage.walls[0].is_blade_at(&wall) {
            return None;
        }
        let point = self.part.meridional(s, eta).at_angle(wall.theta);
        Some(self.far_wall.nearest_to_point(&point).distance)
    }

    /// Least width at `s` between hub and shroud, mm; infinite where the wall does not reach.
    pub fn min_width(&self, s: f64) -> f64 {
        (0..=4).filter_map(|j| self.at(s, f64::from(j) / 4.0)).fold(f64::INFINITY, f64::min)
    }
}
