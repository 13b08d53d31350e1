//! Progress reporting, stopping and cancelling of long computations, and precedence among several.

use crate::error::{ErrorCode, UserError};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, AtomicUsize, Ordering};
use std::time::Duration;

/// Interval at which a computation that waits for others looks whether it goes on.
const WAIT: Duration = Duration::from_millis(4);

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
#[derive(Debug)]
pub struct Monitor {
    shared: Arc<MonitorState>,
    /// Whether [`Self::stop`] is ignored.
    ignores_stop: bool,
    /// Whether reports are not passed on.
    is_silent: bool,
    /// Progress of the whole at the beginning and the end of the work that reports.
    span: [f64; 2],
}

impl Default for Monitor {
    fn default() -> Self {
        Self { shared: Arc::default(), ignores_stop: false, is_silent: false, span: [0.0, 1.0] }
    }
}

#[derive(Debug, Default)]
struct MonitorState {
    stopped: AtomicBool,
    cancelled: AtomicBool,
    permille: AtomicU32,
    /// What goes ahead of the computation; `None`: nothing does.
    precedence: Option<Precedence>,
}

impl Monitor {
    /// The token of a computation that waits, at its checks, while others that go ahead of it are busy.
    pub fn with_precedence(precedence: Precedence) -> Self {
        let state = MonitorState { precedence: Some(precedence), ..MonitorState::default() };
        Self { shared: Arc::new(state), ..Self::default() }
    }

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
        Self { ignores_stop: true, ..self.same() }
    }

    /// The same token for work beside the main one, whose progress does not count.
    pub fn silent(&self) -> Self {
        Self { is_silent: true, ..self.same() }
    }

    /// The same token for a span of the work: its progress 0…1 counts as `from`…`to` of this one.
    pub fn span(&self, from: f64, to: f64) -> Self {
        let [start, end] = self.span;
        Self { span: [from, to].map(|share| start + (end - start) * share), ..self.same() }
    }

    fn same(&self) -> Self {
        let Self { shared, ignores_stop, is_silent, span } = self;
        Self { shared: Arc::clone(shared), ignores_stop: *ignores_stop, is_silent: *is_silent, span: *span }
    }

    /// Counts `total` equal steps of the work, from any thread.
    pub fn steps(&self, total: usize) -> StepCount<'_> {
        StepCount { monitor: self, total, done: AtomicUsize::new(0) }
    }

    /// Returns an error once the computation must end; to be called every few milliseconds, and not while a
    /// lock is held that others need: it waits for those that go ahead.
    ///
    /// # Errors
    /// [`Cancelled`] after a cancel, or after a stop unless stops are ignored.
    pub fn check(&self) -> Result<(), Cancelled> {
        if let Some(precedence) = &self.shared.precedence {
            while precedence.must_wait() && !self.is_cancelled() {
                std::thread::sleep(WAIT);
            }
        }
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Reports progress, 0…1.
    pub fn report(&self, fraction: f64) {
        if self.is_silent {
            return;
        }
        self.shared.permille.store(self.permille_at(fraction), Ordering::Relaxed);
    }

    /// Progress of the whole at that of this work, 0…1000.
    fn permille_at(&self, fraction: f64) -> u32 {
        let [start, end] = self.span;
        let whole = start + (end - start) * fraction.clamp(0.0, 1.0);
        (whole * 1000.0) as u32
    }

    /// Progress, 0…1.
    pub fn progress(&self) -> f64 {
        f64::from(self.shared.permille.load(Ordering::Relaxed)) / 1000.0
    }
}

/// Precedence of a computation among others that may be busy at the same time: while one of lower rank is, it
/// waits at its checks, and goes on where it was.
#[derive(Clone, Debug)]
pub struct Precedence {
    all: Arc<[RankedWork]>,
    own: usize,
}

#[derive(Debug, Default)]
struct RankedWork {
    rank: AtomicU8,
    is_busy: AtomicBool,
}

impl Precedence {
    /// That of `N` computations among each other, idle and of the same rank.
    pub fn of_each<const N: usize>() -> [Self; N] {
        let all: Arc<[RankedWork]> = (0..N).map(|_| RankedWork::default()).collect();
        std::array::from_fn(|own| Self { all: Arc::clone(&all), own })
    }

    /// Sets the rank; the lowest goes ahead, equal ones share the cores.
    pub fn set_rank(&self, rank: u8) {
        self.all[self.own].rank.store(rank, Ordering::Relaxed);
    }

    /// Sets whether there is anything to compute.
    pub fn set_busy(&self, is_busy: bool) {
        self.all[self.own].is_busy.store(is_busy, Ordering::Relaxed);
    }

    /// Whether others go ahead now.
    pub fn must_wait(&self) -> bool {
        let rank = self.all[self.own].rank.load(Ordering::Relaxed);
        let is_ahead = |work: &RankedWork| {
            work.is_busy.load(Ordering::Relaxed) && work.rank.load(Ordering::Relaxed) < rank
        };
        self.all.iter().any(is_ahead)
    }
}

/// Steps of a computation, counted as they begin.
#[derive(Debug)]
pub struct StepCount<'a> {
    monitor: &'a Monitor,
    total: usize,
    done: AtomicUsize,
}

impl StepCount<'_> {
    /// Begins a step, and reports the progress.
    ///
    /// # Errors
    /// As [`Monitor::check`].
    pub fn begin(&self) -> Result<(), Cancelled> {
        self.monitor.check()?;
        let done = self.done.fetch_add(1, Ordering::Relaxed);
        if !self.monitor.is_silent {
            // The thread of a later step may get here first.
            let permille = self.monitor.permille_at(done as f64 / self.total.max(1) as f64);
            self.monitor.shared.permille.fetch_max(permille, Ordering::Relaxed);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_report_their_share_of_the_whole() {
        let monitor = Monitor::default();
        let second = monitor.span(0.5, 1.0);
        second.report(0.0);
        assert_eq!(monitor.progress(), 0.5);
        second.span(0.0, 0.5).report(1.0);
        assert_eq!(monitor.progress(), 0.75);
        second.silent().report(1.0);
        assert_eq!(monitor.progress(), 0.75, "work beside the main one does not count");
        let steps = second.steps(4);
        (0..3).for_each(|_| steps.begin().expect("goes on"));
        assert_eq!(monitor.progress(), 0.75, "two of four are done");
        monitor.cancel();
        assert!(steps.begin().is_err(), "parts end with the whole");
    }

    #[test]
    fn a_computation_waits_for_those_ahead_until_they_end_or_it_is_cancelled() {
        let [first, second, equal] = Precedence::of_each();
        second.set_rank(1);
        equal.set_rank(1);
        equal.set_busy(true);
        let monitor = Monitor::with_precedence(second);
        assert!(monitor.check().is_ok(), "equal ones go on together");
        first.set_busy(true);
        let is_done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                monitor.silent().check().expect("goes on");
                assert!(is_done.load(Ordering::SeqCst), "not before");
            });
            std::thread::sleep(5 * WAIT);
            is_done.store(true, Ordering::SeqCst);
            first.set_busy(false);
        });
        first.set_busy(true);
        monitor.cancel();
        assert!(monitor.check().is_err(), "a cancel does not wait");
    }
}
