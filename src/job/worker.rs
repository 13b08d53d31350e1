//! A background thread with one slot for the newest request and one for the latest outcome.
//!
//! Nothing queues up, so that the window never waits: a newer request supersedes the running one, and an
//! outcome that was not fetched is overwritten by the next. [`Worker::cancel`] takes effect for the caller at
//! once; the thread itself stops as soon as the job checks its [`Monitor`], and any result it still returns
//! is dropped.
//!
//! A [`Worker::ranked`] has threads and a [`Precedence`] of its own: it waits where it is while others go
//! ahead.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use rayon::ThreadPoolBuilder;

use crate::monitor::{Monitor, Precedence};

/// Status of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// In the request slot, not started.
    Waiting = 0,
    /// The job is running.
    Running = 1,
    /// Finished with a result.
    Done = 2,
    /// Cancelled by the user.
    Cancelled = 3,
    /// Cancelled, or never started, because of a newer request.
    Superseded = 4,
    /// The job returned an error, or panicked.
    Failed = 5,
}

impl Status {
    fn from_u8(value: u8) -> Self {
        match value {
            0 => Self::Waiting,
            1 => Self::Running,
            2 => Self::Done,
            3 => Self::Cancelled,
            4 => Self::Superseded,
            _ => Self::Failed,
        }
    }
}

/// Handle of a request: its number, progress and status; cheap to clone.
#[derive(Clone, Debug)]
pub struct Ticket {
    number: u64,
    status: Arc<AtomicU8>,
    monitor: Arc<Monitor>,
}

impl Ticket {
    fn new(number: u64, monitor: Monitor) -> Self {
        let status = Arc::new(AtomicU8::new(Status::Waiting as u8));
        Self { number, status, monitor: Arc::new(monitor) }
    }

    /// Number of the request, counted from 1 within a worker.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Current status of the request.
    pub fn status(&self) -> Status {
        Status::from_u8(self.status.load(Ordering::Acquire))
    }

    /// Progress, 0…1.
    pub fn progress(&self) -> f64 {
        self.monitor.progress()
    }

    /// Whether a stop was requested and the job has not ended yet.
    pub fn is_stopping(&self) -> bool {
        self.status() == Status::Running && self.monitor.is_stopped()
    }

    fn set(&self, status: Status) {
        self.status.store(status as u8, Ordering::Release);
    }

    fn stop(&self, status: Status) {
        self.set(status);
        self.monitor.cancel();
    }
}

/// How a request ended. A superseded request has no outcome, only its [`Ticket::status`].
#[derive(Debug)]
pub enum Outcome<T, E> {
    /// The result.
    Done(T),
    /// Cancelled by the user; the last good result stays valid.
    Cancelled,
    /// The job returned an error.
    Failed(E),
    /// The job panicked, which is a bug, not bad input. Contains the panic's message.
    Panicked(String),
}

struct RequestQueue<R, T, E> {
    waiting: Option<(R, Ticket)>,
    running: Option<Ticket>,
    outcome: Option<(Ticket, Outcome<T, E>)>,
    requests: u64,
    shutting_down: bool,
}

struct WorkerShared<R, T, E> {
    queue: Mutex<RequestQueue<R, T, E>>,
    wake: Condvar,
    /// `None`: it goes on whatever else is busy.
    precedence: Option<Precedence>,
}

impl<R, T, E> WorkerShared<R, T, E> {
    /// Locks the queue. No code under the lock can panic, so a poisoned lock is still consistent.
    fn lock_queue(&self) -> MutexGuard<'_, RequestQueue<R, T, E>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set_busy(&self, is_busy: bool) {
        if let Some(precedence) = &self.precedence {
            precedence.set_busy(is_busy);
        }
    }
}

/// The background thread; dropping it cancels the job and joins the thread.
pub struct Worker<R, T, E> {
    shared: Arc<WorkerShared<R, T, E>>,
    thread: Option<JoinHandle<()>>,
    notify: Arc<dyn Fn() + Send + Sync>,
}

impl<R, T, E> Worker<R, T, E>
where
    R: Send + 'static,
    T: Send + 'static,
    E: Send + 'static,
{
    /// Starts a thread called `name` that runs `job` for each request; `notify` is called, from any thread,
    /// after every outcome.
    ///
    /// # Panics
    /// If the system cannot start a thread.
    pub fn new(
        name: &str,
        job: impl Fn(&R, &Monitor) -> Result<T, E> + Send + Sync + 'static,
        notify: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        Self::start(name, None, job, notify)
    }

    /// The same for work that takes long: it waits while work is busy that goes ahead of it. It has threads
    /// of its own for the cores, as those that wait are of no use to others.
    ///
    /// # Panics
    /// If the system cannot start a thread.
    pub fn ranked(
        name: &str,
        precedence: Precedence,
        job: impl Fn(&R, &Monitor) -> Result<T, E> + Send + Sync + 'static,
        notify: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        Self::start(name, Some(precedence), job, notify)
    }

    fn start(
        name: &str,
        precedence: Option<Precedence>,
        job: impl Fn(&R, &Monitor) -> Result<T, E> + Send + Sync + 'static,
        notify: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let queue =
            RequestQueue { waiting: None, running: None, outcome: None, requests: 0, shutting_down: false };
        let shared = Arc::new(WorkerShared { queue: Mutex::new(queue), wake: Condvar::new(), precedence });
        let notify: Arc<dyn Fn() + Send + Sync> = Arc::new(notify);
        let thread = {
            let (shared, notify) = (Arc::clone(&shared), Arc::clone(&notify));
            std::thread::Builder::new()
                .name(name.to_owned())
                .spawn(move || run_requests(&shared, &job, notify.as_ref()))
                .expect("a process that may open a window may start a thread")
        };
        Self { shared, thread: Some(thread), notify }
    }

    /// Submits a request. A waiting or running one is superseded.
    pub fn submit(&self, request: R) -> Ticket {
        let mut queue = self.shared.lock_queue();
        queue.requests += 1;
        let monitor = self.shared.precedence.clone().map_or_else(Monitor::default, Monitor::with_precedence);
        let ticket = Ticket::new(queue.requests, monitor);
        self.shared.set_busy(true);
        if let Some(running) = queue.running.take() {
            running.stop(Status::Superseded);
        }
        if let Some((_, waiting)) = queue.waiting.replace((request, ticket.clone())) {
            waiting.stop(Status::Superseded);
        }
        drop(queue);
        self.shared.wake.notify_one();
        ticket
    }

    /// Cancels the waiting or running request, if any: [`Self::take_outcome`] returns the outcome at once,
    /// and any later result of that request is dropped.
    pub fn cancel(&self) {
        let mut queue = self.shared.lock_queue();
        let waiting = queue.waiting.take().map(|(_, ticket)| ticket);
        let running = queue.running.take();
        let Some(ticket) = waiting.or(running) else { return };
        ticket.stop(Status::Cancelled);
        queue.outcome = Some((ticket, Outcome::Cancelled));
        self.shared.set_busy(false);
        drop(queue);
        (self.notify)();
    }

    /// Requests that the running job ends with the best result found so far; the outcome follows once that
    /// result is complete. A request that waits, or was stopped before, is cancelled.
    pub fn stop(&self) {
        {
            let queue = self.shared.lock_queue();
            if let (None, Some(running)) = (&queue.waiting, &queue.running)
                && !running.is_stopping()
            {
                running.monitor.stop();
                return;
            }
        }
        self.cancel();
    }

    /// Whether a stop of the running job was requested.
    pub fn is_stopping(&self) -> bool {
        let queue = self.shared.lock_queue();
        queue.waiting.is_none() && queue.running.as_ref().is_some_and(Ticket::is_stopping)
    }

    /// Progress 0…1 of the waiting or running request; `None` when idle.
    pub fn progress(&self) -> Option<f64> {
        let queue = self.shared.lock_queue();
        match (&queue.waiting, &queue.running) {
            (Some(_), _) => Some(0.0),
            (None, Some(running)) => Some(running.progress()),
            (None, None) => None,
        }
    }

    /// Whether a request waits or runs.
    pub fn is_busy(&self) -> bool {
        self.progress().is_some()
    }

    /// Whether a request waits for work that goes ahead of it.
    pub fn is_held(&self) -> bool {
        self.is_busy() && self.shared.precedence.as_ref().is_some_and(Precedence::must_wait)
    }

    /// Whether an outcome waits to be taken.
    pub fn has_outcome(&self) -> bool {
        self.shared.lock_queue().outcome.is_some()
    }

    /// Takes the latest outcome, if it was not taken before.
    pub fn take_outcome(&self) -> Option<(Ticket, Outcome<T, E>)> {
        self.shared.lock_queue().outcome.take()
    }
}

impl<R, T, E> Drop for Worker<R, T, E> {
    fn drop(&mut self) {
        {
            let mut queue = self.shared.lock_queue();
            queue.shutting_down = true;
            queue.waiting = None;
            if let Some(running) = queue.running.take() {
                running.stop(Status::Cancelled);
            }
            self.shared.set_busy(false);
        }
        self.shared.wake.notify_all();
        if let Some(thread) = self.thread.take() {
            // A panic of the job is caught in the thread, so there is nothing to report.
            let _ = thread.join();
        }
    }
}

fn run_requests<R, T, E>(
    shared: &WorkerShared<R, T, E>,
    job: &(impl Fn(&R, &Monitor) -> Result<T, E> + Sync),
    notify: &(dyn Fn() + Send + Sync),
) where
    R: Send,
    T: Send,
    E: Send,
{
    // Made for the first request: most windows need few.
    let mut pool = None;
    loop {
        let (request, ticket) = {
            let mut queue = shared.lock_queue();
            loop {
                if queue.shutting_down {
                    return;
                }
                if let Some((request, ticket)) = queue.waiting.take() {
                    ticket.set(Status::Running);
                    queue.running = Some(ticket.clone());
                    break (request, ticket);
                }
                queue = shared.wake.wait(queue).unwrap_or_else(PoisonError::into_inner);
            }
        };
        if shared.precedence.is_some() && pool.is_none() {
            pool = ThreadPoolBuilder::new().build().ok();
        }
        let monitor = &*ticket.monitor;
        let answer = catch_unwind(AssertUnwindSafe(|| match &pool {
            Some(pool) => pool.install(move || job(&request, monitor)),
            None => job(&request, monitor),
        }));
        let mut queue = shared.lock_queue();
        // Cancelled or superseded meanwhile: the outcome or a newer request is already set.
        if queue.running.as_ref().is_none_or(|running| running.number != ticket.number) {
            continue;
        }
        queue.running = None;
        shared.set_busy(false);
        let end = match answer {
            Ok(Ok(result)) => Outcome::Done(result),
            Ok(Err(error)) => Outcome::Failed(error),
            Err(panic) => Outcome::Panicked(panic_text(panic.as_ref())),
        };
        ticket.set(if matches!(end, Outcome::Done(_)) { Status::Done } else { Status::Failed });
        queue.outcome = Some((ticket, end));
        drop(queue);
        notify();
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
#[path = "worker_tests.rs"]
mod tests;
