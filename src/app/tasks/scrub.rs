//! Background computations for the display: stock at a timeline position, and the sectional view through the
//! selected position.

use std::sync::Arc;

use crate::part::Workpiece;
use crate::plunge::inspect::{CutPlane, SectionView, section_view_in};
use crate::setup::AxisPolicy;
use crate::stock::{field_cutters, residual_field};

use super::Repaint;
use crate::app::model::planned::{DisplayPlan, Side};
use crate::app::model::state::AppState;
use crate::app::tasks::latest::Latest;

/// A request about a plan: its first `count` positions, or the position with index `count`.
#[derive(Clone)]
pub(in crate::app) struct PlanPosition {
    planned: Arc<DisplayPlan>,
    policy: AxisPolicy,
    count: usize,
}

impl PartialEq for PlanPosition {
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count && self.policy == other.policy && Arc::ptr_eq(&self.planned, &other.planned)
    }
}

/// Stock at the timeline position, for the visible sides.
pub(in crate::app) struct TimelineStock(Latest<Vec<PlanPosition>, Vec<Arc<Vec<f32>>>>);

impl TimelineStock {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        let after = |place: &PlanPosition| {
            let cutters = field_cutters(place.planned.plan(place.policy));
            let cut = &cutters[..place.count.min(cutters.len())];
            Arc::new(residual_field(&place.planned.outcome.grid, cut).heights)
        };
        Self(Latest::new("scrub", repaint, move |places: &Vec<PlanPosition>| {
            places.iter().map(after).collect()
        }))
    }

    /// Requests the stock at the timeline position.
    pub(in crate::app) fn follow(&mut self, state: &AppState) {
        let places = state.look.cut_count.map(|count| {
            let sides = [Side::Before, Side::After].into_iter().filter(|&side| state.shows(side));
            sides
                .filter_map(|side| state.shown_on(side))
                .map(|shown| PlanPosition { planned: Arc::clone(shown.planned), policy: shown.policy, count })
                .collect()
        });
        self.0.request(places);
    }

    /// Whether a request is being computed.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }

    /// Heights per cell of a plan, mm, of the latest finished request; `None` before the first.
    pub(in crate::app) fn heights(
        &self,
        planned: &Arc<DisplayPlan>,
        policy: AxisPolicy,
    ) -> Option<Arc<Vec<f32>>> {
        let (places, heights) = self.0.answer()?;
        let of = |place: &PlanPosition| place.policy == policy && Arc::ptr_eq(&place.planned, planned);
        places.iter().position(of).and_then(|k| heights.get(k)).map(Arc::clone)
    }
}

/// The sectional view through the selected position.
pub(in crate::app) struct InspectedSection(Latest<(PlanPosition, CutPlane), Option<Arc<SectionView>>>);

impl InspectedSection {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        let look = |(place, plane): &(PlanPosition, CutPlane)| {
            let outcome = &place.planned.outcome;
            let allowance = outcome.setup.allowances.hub_allowance;
            let Workpiece { part, blank, .. } = &*outcome.workpiece;
            let plan = place.planned.plan(place.policy);
            section_view_in(*plane, part, blank, allowance, plan, place.count).map(Arc::new)
        };
        Self(Latest::new("section", repaint, look))
    }

    /// Requests the sectional view through the selected position.
    pub(in crate::app) fn follow(&mut self, state: &AppState) {
        let place = state.shown().zip(state.look.selected).map(|(shown, count)| PlanPosition {
            planned: Arc::clone(shown.planned),
            policy: shown.policy,
            count,
        });
        self.0.request(place.map(|place| (place, state.cut_plane())));
    }

    /// Whether a request is being computed.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }

    /// The latest finished sectional view, and the index of its position.
    pub(in crate::app) fn section(&self) -> Option<(usize, Arc<SectionView>)> {
        let ((place, _), view) = self.0.answer()?;
        view.as_ref().map(|view| (place.count, Arc::clone(view)))
    }
}
