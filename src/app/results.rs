//! What was computed: the latest good plan, and the figures of sets that were planned before.

use std::sync::Arc;

use crate::job::Summary;
use crate::job::flank::FlankOutcome;
use crate::part::Setup;

use super::planned::Planned;

/// What sets are compared by. Lengths mm, time s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Number of plunges.
    pub positions: usize,
    /// Plunges whose core meets stock.
    pub interferential: usize,
    /// Stock left on the hub: mean.
    pub residual_mean: f64,
    /// Its 95th percentile.
    pub residual_p95: f64,
    /// Share of the reachable floor that no plunge reaches.
    pub uncut_share: f64,
    /// Estimate for one channel.
    pub time: f64,
}

impl From<&Summary> for Figures {
    fn from(summary: &Summary) -> Self {
        Self {
            positions: summary.positions,
            interferential: summary.interferential,
            residual_mean: summary.residual_mean,
            residual_p95: summary.residual_p95,
            uncut_share: summary.uncut_share,
            time: summary.time_estimate,
        }
    }
}

/// Figures kept at most; the oldest go first.
const MOST_FIGURES: usize = 64;

/// Everything computed of the part that is open.
#[derive(Debug, Default)]
pub struct Results {
    /// Latest good plan.
    pub planned: Option<Arc<Planned>>,
    /// Latest good flank plan.
    pub flank: Option<Arc<FlankOutcome>>,
    figures: Vec<(Setup, Figures)>,
}

impl Results {
    /// Takes a plan in, and notes its figures.
    pub fn take(&mut self, planned: Planned) {
        self.note(planned.setup.clone(), Figures::from(&planned.outcome.after.summary));
        self.planned = Some(Arc::new(planned));
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
