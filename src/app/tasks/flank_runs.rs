//! The flank plan in several channels: to find the links from channel to channel takes seconds for a whole
//! wheel.

use std::sync::Arc;

use super::Repaint;
use crate::app::model::flank_run::{FlankRun, WantedFlankRun};
use crate::app::tasks::latest::Latest;

/// Repeats the flank plan in its channels in the background.
pub(in crate::app) struct FlankRunWork(Latest<WantedFlankRun, Arc<FlankRun>>);

impl FlankRunWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("flank channels", repaint, |wanted: &WantedFlankRun| {
            Arc::new(FlankRun::new(&wanted.outcome, wanted.order, wanted.count))
        }))
    }

    /// Requests what is wanted, and returns it once it is there.
    pub(in crate::app) fn follow(&mut self, wanted: Option<WantedFlankRun>) -> Option<Arc<FlankRun>> {
        self.0.request(wanted.clone());
        let (of, run) = self.0.answer()?;
        wanted.filter(|wanted| wanted == of).map(|_| Arc::clone(run))
    }

    /// Whether channels are being repeated.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }
}
