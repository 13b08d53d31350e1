//! The machinability of the open part, as `vanecut assess` has it, in the background.

use std::sync::Arc;

use super::Repaint;
use crate::app::model::state::AppState;
use crate::app::tasks::latest::Latest;
use crate::job::assess::AssessedPart;
use crate::part::Impeller;
use crate::setup::Setup;

/// A part, and the setup whose tools are to reach its floor.
#[derive(Clone)]
struct AssessRequest {
    part: Arc<Impeller>,
    setup: Setup,
}

impl PartialEq for AssessRequest {
    /// Parts are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.part, &other.part) && self.setup == other.setup
    }
}

/// Measures the part in the background, while its figures are shown.
pub(in crate::app) struct AssessWork(Latest<AssessRequest, Arc<AssessedPart>>);

impl AssessWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        let measure = |request: &AssessRequest| {
            Arc::new(AssessedPart::from_part(Arc::clone(&request.part), &request.setup))
        };
        Self(Latest::new("assess", repaint, measure))
    }

    /// Requests the figures of the open part with the current setup, if they are `wanted`.
    pub(in crate::app) fn follow(&mut self, state: &AppState, wanted: bool) {
        let part = state.document.part.as_ref().filter(|_| wanted);
        let request = part.map(|part| AssessRequest {
            part: Arc::clone(&part.impeller),
            setup: state.document.edited.setup.clone(),
        });
        self.0.request(request);
    }

    /// The figures that were measured last, which may be those of a setup before the last edit; `None` until
    /// there are some of the open part.
    pub(in crate::app) fn known(&self, state: &AppState) -> Option<&Arc<AssessedPart>> {
        let part = state.document.part.as_ref()?;
        let (request, assessed) = self.0.answer()?;
        Arc::ptr_eq(&request.part, &part.impeller).then_some(assessed)
    }

    /// Whether figures are being measured.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }
}
