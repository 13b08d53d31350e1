//! The second pass over the rows of a section. The rows that are cut first have only what earlier sections
//! and they themselves removed to keep their cores free: beside a wall, where the axis cannot tilt as contact
//! asks, they stop short or leave places out. Once all rows are cut there is space beside them. The open
//! places of each row are searched again, from both of their ends.

use super::row_stages::RowStages;
use super::rows::{RowOf, RowPlaces, SHORT_RADII, cut_path, rows_of_stretch, with_row_search};
use crate::monitor::Monitor;
use crate::plunge::context::PlanContext;
use crate::plunge::cut::SectionCut;
use crate::plunge::error::PlanError;
use crate::setup::CutDirection;

/// Number of places before the open ones at which a path may begin.
const PLACES_BEFORE: usize = 2;
/// Number of places between two open ones that are cut again with them.
const MAX_GAP: usize = 2;

/// The open places of a row.
#[derive(Clone, Debug)]
pub(super) struct OpenRow {
    /// Index of the layout in its section, and of the row in the layout.
    at: (usize, usize),
    /// s of the places, and how far their plunge stops short, mm; infinite where there is none.
    places: Vec<(f64, f64)>,
}

impl OpenRow {
    /// The open `places` of the row `at`; `None` without any.
    pub fn new(at: (usize, usize), places: Vec<(f64, f64)>) -> Option<Self> {
        (!places.is_empty()).then_some(Self { at, places })
    }

    /// The runs of indices of `s` with open places, in the order of `s`.
    fn runs(&self, s: &[f64], step: f64) -> Vec<(usize, usize)> {
        let is_open = |at: f64| self.places.iter().any(|(open, _)| (open - at).abs() <= 0.5 * step);
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for k in (0..s.len()).filter(|&k| is_open(s[k])) {
            match runs.last_mut() {
                Some((_, last)) if k - *last <= MAX_GAP + 1 => *last = k,
                _ => runs.push((k, k)),
            }
        }
        runs
    }

    /// Takes the places near `s` that a plunge with `lift` (mm) cuts `better` (mm) deeper than before.
    fn take_deepened(&mut self, s: f64, lift: f64, step: f64, better: f64) -> Vec<f64> {
        let is_deepened = |(at, before): &(f64, f64)| (at - s).abs() <= 0.5 * step && lift < before - better;
        let taken = self.places.iter().filter(|place| is_deepened(place)).map(|(at, _)| *at).collect();
        self.places.retain(|place| !is_deepened(place));
        taken
    }
}

/// Cuts what it can of the `open` places of section `index`, after all of its rows in `cut`. When
/// stopped, what was found until then stays.
///
/// # Errors
/// As [`Planner::plan`](crate::plunge::Planner::plan).
pub(super) fn cut_open_places(
    context: &PlanContext,
    index: usize,
    open: &[OpenRow],
    cut: &mut SectionCut,
    monitor: &Monitor,
) -> Result<(), PlanError> {
    let layouts = context.layouts(index)?;
    let tool = context.tool_of_section(index)?;
    let back = match cut.feed {
        CutDirection::OutletToInlet => CutDirection::InletToOutlet,
        CutDirection::InletToOutlet => CutDirection::OutletToInlet,
    };
    // The last row has the most space beside it.
    for open in open.iter().rev() {
        let (number, row) = open.at;
        let layout = &layouts[number];
        let lambdas = rows_of_stretch(context, layout, tool);
        let row_of = RowOf { layout, lambdas: &lambdas, row };
        let mut open = open.clone();
        for feed in [cut.feed, back] {
            match cut_open_row(context, index, row_of, feed, &mut open, cut, monitor) {
                Err(PlanError::Cancelled(_)) if monitor.is_stopped() => return Ok(()),
                done => done?,
            }
        }
    }
    Ok(())
}

/// Cuts the `open` places of a row in direction `feed` and takes from them what was cut.
fn cut_open_row(
    context: &PlanContext,
    index: usize,
    row_of: RowOf,
    feed: CutDirection,
    open: &mut OpenRow,
    cut: &mut SectionCut,
    monitor: &Monitor,
) -> Result<(), PlanError> {
    if open.places.is_empty() {
        return Ok(());
    }
    let closing = &monitor.ignoring_stop();
    let lambda = row_of.layout.stretch.lambda_in_channel(row_of.lambdas[row_of.row]);
    with_row_search(context, index, row_of, feed, monitor, |search, RowPlaces { s, .. }| {
        let [first, second, ..] = s.as_slice() else { return Ok(()) };
        let step = (second - first).abs();
        let better = SHORT_RADII * search.candidates.maker.tool.radius();
        for (from, to) in open.runs(s, step) {
            let places = &s[from.saturating_sub(PLACES_BEFORE)..=to];
            let path = search.path(places, s[from], &cut.columns, &mut RowStages::default())?;
            let again = cut_path(context, path, search, lambda, &cut.columns, closing)?;
            let cut_at = |s: f64| again.row.lift_at(s).map(|lift| (s, lift));
            let lifts: Vec<(f64, f64)> = places.iter().filter_map(|&s| cut_at(s)).collect();
            let deepened: Vec<f64> =
                lifts.iter().flat_map(|&(s, lift)| open.take_deepened(s, lift, step, better)).collect();
            if deepened.is_empty() {
                continue;
            }
            let is_cut = |at: f64, s: f64| at == lambda && deepened.iter().any(|d| (d - s).abs() < 1e-9);
            cut.rows.iter_mut().for_each(|row| row.forget_open(is_cut));
            cut.columns = again.columns;
            let row = again.row.without_dropped();
            cut.rows.extend(row.split_where_axes_turn(context.setup.plunge.max_axis_change_rad));
        }
        Ok::<(), PlanError>(())
    })?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_places_next_to_each_other_are_cut_together() {
        let s: Vec<f64> = (0..12).map(|k| 1.0 - 0.1 * f64::from(k)).collect();
        let at = |k: usize| (s[k] + 0.02, f64::INFINITY);
        let open = OpenRow::new((0, 0), [0, 1, 4, 9, 10].map(at).to_vec()).expect("there are places");
        assert_eq!(open.runs(&s, 0.1), [(0, 4), (9, 10)], "two places between are cut again, four are not");
        assert!(OpenRow::new((0, 0), Vec::new()).is_none(), "nothing to do");
    }

    #[test]
    fn only_what_gets_deeper_is_taken() {
        let mut open = OpenRow::new((0, 0), vec![(0.5, f64::INFINITY), (0.4, 2.0)]).expect("two places");
        assert!(open.take_deepened(0.41, 1.8, 0.1, 0.5).is_empty(), "hardly deeper than before");
        assert_eq!(open.take_deepened(0.52, 3.0, 0.1, 0.5), [0.5], "a plunge where there was none");
        assert_eq!(open.take_deepened(0.41, 0.0, 0.1, 0.5), [0.4]);
        assert!(open.places.is_empty());
    }
}
