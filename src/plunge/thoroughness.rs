//! How thoroughly `minimal` searches a section. Where rows have very many places, a full search takes minutes
//! and leaves only a few percent less stock.

use super::lane::AxisEnds;
use super::section_layout::StretchLayout;
use super::spacing::step_limit;
use crate::setup::{PlungeSetup, Tool};

/// Number of places in rows that counts as very many. Where the cutters suit the passages, a wheel has a few
/// hundred.
pub(super) const MANY_PLACES: f64 = 1000.0;
/// Equal parts of a row in which the speed of its axis is measured.
const SAMPLES: u32 = 8;

/// How thoroughly `minimal` searches a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Thoroughness {
    /// Both cutting directions, finer grids of lead angles where plunges stop short, a dense pool of added
    /// plunges down to a small gain.
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

/// Length in mm over which the axis of a row in the middle of `layout` would move if it moved as fast
/// everywhere as where it moves fastest: positions are evenly spaced in s. 0 where the row has no axes.
fn way_of_row(StretchLayout { stretch, lane, .. }: &StretchLayout) -> f64 {
    let axis_at = |i: u32| lane.isoparametric(0.5, stretch.s_at(f64::from(i) / f64::from(SAMPLES)));
    let axes: Vec<Option<AxisEnds>> = (0..=SAMPLES).map(axis_at).collect();
    let spacings = axes.windows(2).filter_map(|pair| {
        let (axis, next) = (pair[0].as_ref()?, pair[1].as_ref()?);
        Some(lane.spacing(lane.line(axis), next))
    });
    f64::from(SAMPLES) * spacings.fold(0.0, f64::max)
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
