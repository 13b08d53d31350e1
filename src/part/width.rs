//! Width of a passage: the distance between its walls.

use super::channel::{Passage, Wall};
use super::impeller::Impeller;
use super::probe::SideProbe;

/// Number of steps from hub to shroud at which widths are measured.
const HEIGHTS: u32 = 4;

/// η at which widths are measured.
fn heights() -> impl Iterator<Item = f64> {
    (0..=HEIGHTS).map(|j| f64::from(j) / f64::from(HEIGHTS))
}

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

    /// Distance from the point of `wall` (0: at λ = 0, 1: at λ = 1) at (s, η) to the nearest point of the
    /// other wall, mm. `None` where the blade at that wall does not extend to (s, η).
    pub fn distance_from(&self, wall: usize, s: f64, eta: f64) -> Option<f64> {
        let (near, far) = (&self.passage.walls[wall], &self.probes[1 - wall]);
        let place = near.at(self.part, s, eta).filter(|place| near.is_blade_at(place))?;
        let point = self.part.meridional(s, eta).at_angle(place.theta);
        Some(far.nearest_to_point(&point).distance)
    }

    /// [`Self::distance_from`] of both.
    fn distances(&self, s: f64, eta: f64) -> impl Iterator<Item = f64> + '_ {
        [0, 1].into_iter().filter_map(move |wall| self.distance_from(wall, s, eta))
    }

    /// Width at (s, η), mm: the larger of both distances, the same whichever wall is at λ = 0. On staggered
    /// blades, the point of one wall at equal s may face the middle of the other wall, and the other point
    /// look past the end of the first. `None` where neither blade extends to (s, η).
    pub fn at(&self, s: f64, eta: f64) -> Option<f64> {
        self.distances(s, eta).reduce(f64::max)
    }

    /// Least width at `s` between hub and shroud, mm; infinite where the walls do not reach.
    pub fn min_width(&self, s: f64) -> f64 {
        heights().filter_map(|eta| self.at(s, eta)).fold(f64::INFINITY, f64::min)
    }

    /// Least distance at `s` between the walls, from hub to shroud and from either wall, mm; infinite where
    /// they do not reach.
    pub fn least(&self, s: f64) -> f64 {
        heights().flat_map(|eta| self.distances(s, eta)).fold(f64::INFINITY, f64::min)
    }
}
