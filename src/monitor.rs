//! Progress and cancel: what long work reports and obeys.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The work was cancelled; whoever asked for it keeps the last good result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Shared between the one who works and the one who watches.
#[derive(Debug, Default)]
pub struct Monitor {
    cancelled: AtomicBool,
    permille: AtomicU32,
}

impl Monitor {
    /// Asks the work to stop; it does within a few milliseconds.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// To be called often from inside the work: an error once cancelled.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Reports progress, 0…1.
    pub fn report(&self, fraction: f64) {
        self.permille.store((fraction.clamp(0.0, 1.0) * 1000.0) as u32, Ordering::Relaxed);
    }

    /// Progress, 0…1.
    pub fn progress(&self) -> f64 {
        f64::from(self.permille.load(Ordering::Relaxed)) / 1000.0
    }
}
