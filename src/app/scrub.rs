//! Background computations for the display: stock at a timeline position, and the sectional view through the
//! selected position.

use std::sync::Arc;

use crate::part::{AxisPolicy, Blank};
use crate::plunge::inspect::{SectionView, section_view};
use crate::residual::{cutters_of, residual_field};

use super::latest::Latest;
use super::planned::{Planned, Side};
use super::state::State;

/// A request about a plan: its first `count` positions, or the position with index `count`.
#[derive(Clone)]
pub(super) struct Place {
    planned: Arc<Planned>,
    policy: AxisPolicy,
    count: usize,
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count && self.policy == other.policy && Arc::ptr_eq(&self.planned, &other.planned)
    }
}

/// Stock at the timeline position, for the visible sides.
pub(super) struct Scrubbed(Latest<Vec<Place>, Vec<Arc<Vec<f32>>>>);

impl Scrubbed {
    /// Starts the thread.
    pub(super) fn new(ctx: &egui::Context) -> Self {
        let after = |place: &Place| {
            let cutters = cutters_of(place.planned.plan(place.policy));
            let cut = &cutters[..place.count.min(cutters.len())];
            Arc::new(residual_field(&place.planned.outcome.grid, cut).heights)
        };
        Self(Latest::new("scrub", ctx, move |places: &Vec<Place>| places.iter().map(after).collect()))
    }

    /// Requests the stock at the timeline position.
    pub(super) fn follow(&mut self, state: &State) {
        let places = state.look.cut.map(|count| {
            let sides = [Side::Before, Side::After].into_iter().filter(|&side| state.shows(side));
            sides
                .filter_map(|side| state.on(side))
                .map(|shown| Place { planned: Arc::clone(shown.planned), policy: shown.policy, count })
                .collect()
        });
        self.0.follow(places);
    }

    /// Whether a request is being computed.
    pub(super) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }

    /// Heights per cell of a plan, mm, of the latest finished request; `None` before the first.
    pub(super) fn heights(&self, planned: &Arc<Planned>, policy: AxisPolicy) -> Option<Arc<Vec<f32>>> {
        let (places, heights) = self.0.answer()?;
        let of = |place: &Place| place.policy == policy && Arc::ptr_eq(&place.planned, planned);
        places.iter().position(of).and_then(|k| heights.get(k)).map(Arc::clone)
    }
}

/// The sectional view through the selected position.
pub(super) struct Inspected(Latest<Place, Option<Arc<SectionView>>>);

impl Inspected {
    /// Starts the thread.
    pub(super) fn new(ctx: &egui::Context) -> Self {
        let look = |place: &Place| {
            let outcome = &place.planned.outcome;
            let stock = &outcome.setup.stock;
            let blank = Blank::of(&outcome.part, stock.inlet_extension);
            let plan = place.planned.plan(place.policy);
            section_view(&outcome.part, &blank, stock.hub_allowance, plan, place.count).map(Arc::new)
        };
        Self(Latest::new("section", ctx, look))
    }

    /// Requests the sectional view through the selected position.
    pub(super) fn follow(&mut self, state: &State) {
        let place = state.shown().zip(state.look.selected).map(|(shown, count)| Place {
            planned: Arc::clone(shown.planned),
            policy: shown.policy,
            count,
        });
        self.0.follow(place);
    }

    /// Whether a request is being computed.
    pub(super) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }

    /// The latest finished sectional view, and the index of its position.
    pub(super) fn section(&self) -> Option<(usize, Arc<SectionView>)> {
        let (place, view) = self.0.answer()?;
        view.as_ref().map(|view| (place.count, Arc::clone(view)))
    }
}
