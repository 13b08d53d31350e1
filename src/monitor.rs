//! Progress and cancel: what long work reports and obeys.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The work was cancelled; whoever asked for it keeps the last good result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Shared between the one who works and the one who watches.
///
/// Work can be told to end in two ways. After [`Self::stop`] it searches no further, but may make the best of what
/// it has found; work that knows no such thing takes it for a cancel. After [`Self::cancel`] nobody
/// wants anything of it any more.
#[derive(Debug, Default)]
pub struct Monitor {
    shared: Arc<Shared>,
    /// Whether only a cancel counts.
    closing: bool,
}

#[derive(Debug, Default)]
struct Shared {
    stopped: AtomicBool,
    cancelled: AtomicBool,
    permille: AtomicU32,
}

impl Monitor {
    /// Asks the work to end with what it has found; it searches no further within a few milliseconds.
    pub fn stop(&self) {
        self.shared.stopped.store(true, Ordering::Relaxed);
    }

    /// Asks the work to end at once, with nothing; it does within a few milliseconds.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked to end with what was found, and still wants it.
    pub fn is_stopped(&self) -> bool {
        self.shared.stopped.load(Ordering::Relaxed) && !self.shared.cancelled.load(Ordering::Relaxed)
    }

    /// Whether the work is to go no further.
    pub fn is_cancelled(&self) -> bool {
        self.shared.cancelled.load(Ordering::Relaxed)
            || !self.closing && self.shared.stopped.load(Ordering::Relaxed)
    }

    /// The same request as those see it who make something whole of what was found: for them only a cancel counts.
    pub fn closing(&self) -> Self {
        Self { shared: Arc::clone(&self.shared), closing: true }
    }

    /// To be called often from inside the work: an error once it is to go no further.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Reports progress, 0…1.
    pub fn report(&self, fraction: f64) {
        self.shared.permille.store((fraction.clamp(0.0, 1.0) * 1000.0) as u32, Ordering::Relaxed);
    }

    /// Progress, 0…1.
    pub fn progress(&self) -> f64 {
        f64::from(self.shared.permille.load(Ordering::Relaxed)) / 1000.0
    }
}
