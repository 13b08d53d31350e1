//! What was computed: the latest good plan, and the figures of sets that were planned before.

use std::sync::Arc;

use crate::formats::project_file::Figures;
use crate::job::Summary;
use crate::job::flank::FlankOutcome;
use crate::part::Setup;

use super::coming::Coming;
use super::planned::Planned;

/// What a plan came to.
fn figures_of(summary: &Summary) -> Figures {
    Figures {
        positions: summary.positions,
        interferential: summary.interferential,
        residual_mean: summary.residual_mean,
        residual_p95: summary.residual_p95,
        uncut_share: summary.uncut_share,
        time: summary.time_estimate,
    }
}

/// Figures kept at most; the oldest go first.
const MOST_FIGURES: usize = 64;

/// Everything computed of the part that is open.
#[derive(Debug, Default)]
pub struct Results {
    /// Latest good plan.
    pub planned: Option<Arc<Planned>>,
    /// What is known of the plan in the making, while there is one.
    pub coming: Option<Arc<Coming>>,
    /// Latest good flank plan.
    pub flank: Option<Arc<FlankOutcome>>,
    figures: Vec<(Setup, Figures)>,
}

impl Results {
    /// Takes a plan in, and notes its figures once it is finished.
    pub fn take(&mut self, planned: Planned) {
        // What a cancel left of a plan is not what its setup comes to.
        if !planned.is_unfinished() {
            self.note(planned.setup.clone(), figures_of(&planned.outcome.after.summary));
        }
        self.planned = Some(Arc::new(planned));
        self.coming = None;
    }

    /// Notes what a setup comes to.
    pub fn note(&mut self, setup: Setup, figures: Figures) {
        self.figures.retain(|(known, _)| *known != setup);
        if self.figures.len() >= MOST_FIGURES {
            self.figures.remove(0);
        }
        self.figures.push((setup, figures));
    }

    /// What a setup came to, if it was planned.
    pub fn figures(&self, setup: &Setup) -> Option<Figures> {
        self.figures.iter().find(|(known, _)| known == setup).map(|(_, figures)| *figures)
    }
}
