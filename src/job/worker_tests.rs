//! Requests to the background thread: newest first, cancelled, stopped, and behind others.

use super::*;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use std::time::{Duration, Instant};

/// What takes longer hangs, on however busy a machine.
const HANG: Duration = Duration::from_secs(120);

/// A job by request number: 1 runs until stopped, 2 fails, 3 panics, 5 runs until stopped and then
/// completes a partial result; any other number is returned at once.
fn fake(request: &u32, monitor: &Monitor) -> Result<u32, &'static str> {
    match request {
        1 => loop {
            monitor.report(0.5);
            monitor.check().map_err(|_| "stopped")?;
            std::thread::sleep(Duration::from_millis(1));
        },
        2 => Err("no"),
        3 => panic!("broken on purpose"),
        5 => {
            while monitor.check().is_ok() {
                std::thread::sleep(Duration::from_millis(1));
            }
            let slow = Instant::now();
            while monitor.ignoring_stop().check().is_ok() && slow.elapsed() < Duration::from_millis(100) {
                std::thread::sleep(Duration::from_millis(1));
            }
            monitor.ignoring_stop().check().map_err(|_| "stopped")?;
            Ok(50)
        }
        n => Ok(*n),
    }
}

fn until<T>(mut what: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = what() {
            return found;
        }
        assert!(start.elapsed() < HANG, "nothing happens");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn answers_and_notifies() {
    let calls = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&calls);
    let worker = Worker::new("test", fake, move || {
        counter.fetch_add(1, Ordering::SeqCst);
    });
    let ticket = worker.submit(7);
    let (ended, end) = until(|| worker.take_outcome());
    assert!(matches!(end, Outcome::Done(7)), "{end:?}");
    assert_eq!(ended.number(), ticket.number(), "the end belongs to the request");
    assert_eq!(ticket.status(), Status::Done, "status of a finished request");
    until(|| (calls.load(Ordering::SeqCst) == 1).then_some(()));
    assert!(worker.take_outcome().is_none(), "an end is fetched once");
    assert!(!worker.is_busy(), "idle afterwards");
}

#[test]
fn cancel_does_not_wait_for_the_job() {
    // Job 4 ignores the cancel until it is released.
    let released = Arc::new(AtomicBool::new(false));
    let gate = Arc::clone(&released);
    let job = move |request: &u32, monitor: &Monitor| {
        while *request == 4 && !gate.load(Ordering::SeqCst) {
            std::thread::sleep(Duration::from_millis(1));
        }
        fake(request, monitor)
    };
    let worker = Worker::new("test", job, || ());
    for stubborn in [1, 4] {
        let ticket = worker.submit(stubborn);
        until(|| (ticket.status() == Status::Running).then_some(()));
        worker.cancel();
        let (_, end) = worker.take_outcome().expect("the end is there at once");
        assert!(matches!(end, Outcome::Cancelled), "{end:?}");
        assert_eq!(ticket.status(), Status::Cancelled, "status of a cancelled request");
        assert!(!worker.is_busy(), "idle after a cancel");
    }
    // The late result of the job is dropped, and the worker accepts requests.
    released.store(true, Ordering::SeqCst);
    worker.submit(7);
    let (_, end) = until(|| worker.take_outcome());
    assert!(matches!(end, Outcome::Done(7)), "{end:?}");
}

#[test]
fn a_stopped_request_ends_with_what_it_has() {
    let worker = Worker::new("test", fake, || ());
    let running = |request: u32| {
        let ticket = worker.submit(request);
        until(|| (ticket.status() == Status::Running).then_some(()));
        worker.stop();
        ticket
    };
    let ticket = running(5);
    assert!(worker.is_stopping() && ticket.is_stopping(), "on its way to an end");
    let (_, end) = until(|| worker.take_outcome());
    assert!(matches!(end, Outcome::Done(50)), "{end:?}");
    assert!(!worker.is_busy() && !worker.is_stopping(), "idle afterwards");
    // A job without partial results is cancelled by a stop.
    running(1);
    assert!(matches!(until(|| worker.take_outcome()).1, Outcome::Failed("stopped")), "it has nothing");
    // A second stop cancels the partial result.
    running(5);
    worker.stop();
    let (_, end) = worker.take_outcome().expect("the end is there at once");
    assert!(matches!(end, Outcome::Cancelled), "{end:?}");
    // A newer request does not wait for an older one to complete.
    let stopped = running(5);
    worker.submit(7);
    assert_eq!(stopped.status(), Status::Superseded, "its partial result is dropped");
    assert!(matches!(until(|| worker.take_outcome()).1, Outcome::Done(7)), "the newest request's result");
}

#[test]
fn newer_request_supersedes() {
    let worker = Worker::new("test", fake, || ());
    let first = worker.submit(1);
    until(|| (first.status() == Status::Running).then_some(()));
    let second = worker.submit(1);
    let third = worker.submit(9);
    let (ended, end) = until(|| worker.take_outcome());
    assert!(matches!(end, Outcome::Done(9)), "{end:?}");
    assert_eq!(ended.number(), third.number(), "only the newest ends visibly");
    assert_eq!(first.status(), Status::Superseded, "the running one");
    assert_eq!(second.status(), Status::Superseded, "the waiting one");
}

#[test]
fn failure_and_panic_are_distinguished() {
    let worker = Worker::new("test", fake, || ());
    worker.submit(2);
    assert!(matches!(until(|| worker.take_outcome()).1, Outcome::Failed("no")), "an error is an error");
    let ticket = worker.submit(3);
    let (_, end) = until(|| worker.take_outcome());
    assert!(matches!(&end, Outcome::Panicked(text) if text == "broken on purpose"), "{end:?}");
    assert_eq!(ticket.status(), Status::Failed, "a panic counts as failed");
    worker.submit(7);
    assert!(matches!(until(|| worker.take_outcome()).1, Outcome::Done(7)), "the thread survives a panic");
}

#[test]
fn drop_stops_the_job_and_joins() {
    let alive = Arc::new(());
    let inside = Arc::clone(&alive);
    let worker = Worker::new(
        "test",
        move |request: &u32, monitor: &Monitor| {
            let _inside = &inside;
            fake(request, monitor)
        },
        || (),
    );
    let ticket = worker.submit(1);
    until(|| (ticket.status() == Status::Running).then_some(()));
    // The job runs until it is stopped: without a stop this would not end.
    drop(worker);
    assert_eq!(Arc::strong_count(&alive), 1, "the thread is gone");
}

#[test]
fn ranked_work_waits_where_it_is_and_goes_on() {
    let [first, second] = Precedence::of_each();
    second.set_rank(1);
    let steps = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&steps);
    let count = move |wanted: &usize, monitor: &Monitor| -> Result<usize, &'static str> {
        while counter.load(Ordering::SeqCst) < *wanted {
            monitor.check().map_err(|_| "stopped")?;
            counter.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(*wanted)
    };
    let ahead = Worker::ranked("ahead", first, fake, || ());
    let behind = Worker::ranked("behind", second, count, || ());
    behind.submit(1000);
    until(|| (steps.load(Ordering::SeqCst) > 5).then_some(()));
    assert!(!behind.is_held());
    ahead.submit(1);
    std::thread::sleep(Duration::from_millis(20));
    let then = steps.load(Ordering::SeqCst);
    std::thread::sleep(Duration::from_millis(40));
    assert!(steps.load(Ordering::SeqCst) <= then + 1 && behind.is_held(), "it waits");
    ahead.cancel();
    assert!(matches!(ahead.take_outcome(), Some((_, Outcome::Cancelled))));
    assert!(matches!(until(|| behind.take_outcome()).1, Outcome::Done(1000)), "it goes on");
    // One that waits can be cancelled, and dropped.
    ahead.submit(1);
    behind.submit(2000);
    behind.cancel();
    assert!(matches!(behind.take_outcome(), Some((_, Outcome::Cancelled))));
    behind.submit(2000);
    drop(behind);
    ahead.submit(3);
    assert!(matches!(until(|| ahead.take_outcome()).1, Outcome::Panicked(_)), "from its own threads");
}

#[test]
fn cancel_without_work_is_silent() {
    let worker = Worker::new("test", fake, || ());
    worker.cancel();
    assert!(worker.take_outcome().is_none(), "nothing was cancelled");
}
