//! How thoroughly `minimal` searches a section: where rows have many places, each of them is worth less, and
//! a search that leaves a few percent less stock takes minutes.

use super::section_layout::StretchLayout;
use super::spacing::step_limit;
use crate::geometry::{Point, Vector};
use crate::setup::{PlungeSetup, Tool};

/// Number of places in the rows of a plan from which on it has very many. A wheel whose passages the cutters
/// suit has a few hundred.
pub(super) const MANY_PLACES: f64 = 1000.0;
/// Equal parts of a row in which the speed of its axis is measured.
const SAMPLES: u32 = 8;

/// How thoroughly `minimal` searches a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Thoroughness {
    /// Both cutting directions, finer grids of lead angles where plunges stop short, a dense pool of added
    /// plunges down to a small gain.
    #[default]
    Full,
    /// One grid, half of the pool, added plunges only with twice the gain, and the other direction only where
    /// the first one is far from what is acceptable.
    Reduced,
}

impl Thoroughness {
    /// That of each section, by the number of places in its rows and in those before it: reduced from
    /// [`MANY_PLACES`] on. Later sections do not count: what is planned stays valid when they change.
    pub fn of_sections(places: impl Iterator<Item = f64>) -> Vec<Self> {
        let mut until_here = 0.0;
        let of_section = |places| {
            until_here += places;
            if until_here > MANY_PLACES { Self::Reduced } else { Self::Full }
        };
        places.map(of_section).collect()
    }

    /// Whether the search is thorough.
    pub fn is_full(self) -> bool {
        self == Self::Full
    }
}

/// Number of places in the rows of `layouts`, a step limit apart.
pub(super) fn row_places(layouts: &[StretchLayout], plunge: &PlungeSetup, tool: &Tool) -> f64 {
    let [at_wall, inside] = [true, false].map(|wall_row| step_limit(plunge, tool, wall_row));
    let places = |layout: &StretchLayout| {
        let walls = layout.rows.len().min(2);
        way_of_row(layout) * (walls as f64 / at_wall + (layout.rows.len() - walls) as f64 / inside)
    };
    layouts.iter().map(places).sum()
}

/// How far the axis of a row in the middle moves along `layout` where it moves fastest: positions are evenly
/// spaced in s. mm; 0 where it has no axes.
fn way_of_row(StretchLayout { stretch, lane, .. }: &StretchLayout) -> f64 {
    let axis_at = |i: u32| {
        let ends = lane.isoparametric(0.5, stretch.s_at(f64::from(i) / f64::from(SAMPLES)))?;
        let (foot, axis) = lane.line(&ends);
        Some((foot, lane.shroud_point(&ends), axis))
    };
    let axes: Vec<Option<(Point, Point, Vector)>> = (0..=SAMPLES).map(axis_at).collect();
    let apart = axes.windows(2).filter_map(|pair| {
        let [Some((foot, top, axis)), Some((next_foot, next_top, _))] = pair else { return None };
        let across = |way: Vector| (way - axis * way.dot(axis)).norm();
        Some(across(next_foot - foot).max(across(next_top - top)))
    });
    f64::from(SAMPLES) * apart.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_up_to_their_section() {
        use Thoroughness::{Full, Reduced};
        let of = |places: &[f64]| Thoroughness::of_sections(places.iter().copied());
        assert_eq!(of(&[600.0, 400.0, 0.0]), [Full; 3]);
        assert_eq!(of(&[600.0, 700.0, 0.0]), [Full, Reduced, Reduced], "rest milling after many places");
        assert_eq!(of(&[2000.0, 10.0]), [Reduced; 2]);
    }
}
