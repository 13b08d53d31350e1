//! Progress reporting, stopping and cancelling of long computations.

use crate::error::{ErrorCode, UserError};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The computation was cancelled; the caller keeps its last good result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl From<Cancelled> for UserError {
    fn from(_: Cancelled) -> Self {
        Self::new(ErrorCode::Cancelled, "cancelled", "")
    }
}

/// Progress and cancellation token, shared between a computation and its observer.
///
/// There are two ways to end a computation. After [`Self::stop`] it ends the search and may return the best
/// result found so far; a computation without partial results treats it as a cancel. After [`Self::cancel`]
/// it ends without a result.
///
/// ```
/// let monitor = vanecut::monitor::Monitor::default();
/// assert!(monitor.check().is_ok());
/// monitor.cancel();
/// assert!(monitor.check().is_err(), "all work with this monitor ends at its next check");
/// ```
#[derive(Debug, Default)]
pub struct Monitor {
    shared: Arc<MonitorState>,
    /// Whether [`Self::stop`] is ignored.
    ignores_stop: bool,
    /// Whether reports are not passed on.
    is_silent: bool,
}

#[derive(Debug, Default)]
struct MonitorState {
    stopped: AtomicBool,
    cancelled: AtomicBool,
    permille: AtomicU32,
}

impl Monitor {
    /// Requests an early end with the best result found so far; the search ends within a few milliseconds.
    pub fn stop(&self) {
        self.shared.stopped.store(true, Ordering::Relaxed);
    }

    /// Requests an end without a result, within a few milliseconds.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether a stop, but no cancel, was requested.
    pub fn is_stopped(&self) -> bool {
        self.shared.stopped.load(Ordering::Relaxed) && !self.shared.cancelled.load(Ordering::Relaxed)
    }

    /// Whether the computation must end: cancelled, or stopped unless stops are ignored.
    pub fn is_cancelled(&self) -> bool {
        self.shared.cancelled.load(Ordering::Relaxed)
            || !self.ignores_stop && self.shared.stopped.load(Ordering::Relaxed)
    }

    /// The same token for the steps that complete a partial result: a stop is ignored, only a cancel is an
    /// error.
    pub fn ignoring_stop(&self) -> Self {
        Self { shared: Arc::clone(&self.shared), ignores_stop: true, is_silent: self.is_silent }
    }

    /// The same token for work beside the main one, whose progress does not count.
    pub fn silent(&self) -> Self {
        Self { shared: Arc::clone(&self.shared), ignores_stop: self.ignores_stop, is_silent: true }
    }

    /// Returns an error once the computation must end; to be called every few milliseconds.
    ///
    /// # Errors
    /// [`Cancelled`] after a cancel, or after a stop unless stops are ignored.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Reports progress, 0…1.
    pub fn report(&self, fraction: f64) {
        if self.is_silent {
            return;
        }
        self.shared.permille.store((fraction.clamp(0.0, 1.0) * 1000.0) as u32, Ordering::Relaxed);
    }

    /// Progress, 0…1.
    pub fn progress(&self) -> f64 {
        f64::from(self.shared.permille.load(Ordering::Relaxed)) / 1000.0
    }
}
