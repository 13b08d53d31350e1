//! Runs a job from the command line, with progress on a terminal and Ctrl+C handling.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::time::Duration;

use crate::monitor::Monitor;

/// Exit code after a second Ctrl+C: 128 + SIGINT, the convention of shells.
const INTERRUPTED: i32 = 130;

/// The job that Ctrl+C stops.
static RUNNING: Mutex<Option<Arc<Monitor>>> = Mutex::new(None);

/// Runs a job, with its progress on a terminal, where `what` says what it does. The first Ctrl+C stops the
/// job: a planner keeps the best result found so far, a check ends without one. A second Ctrl+C ends the
/// program at once.
pub fn run_with_progress<T>(what: &str, job: impl FnOnce(&Monitor) -> T) -> T {
    static HANDLER: Once = Once::new();
    let monitor = Arc::new(Monitor::default());
    *running() = Some(Arc::clone(&monitor));
    HANDLER.call_once(set_handler);
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        if std::io::stderr().is_terminal() {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    std::thread::sleep(Duration::from_millis(100));
                    eprint!("\r{what}… {:3.0} %", 100.0 * monitor.progress());
                }
                eprint!("\r{:width$}\r", "", width = what.len() + 8);
            });
        }
        let result = job(&monitor);
        done.store(true, Ordering::Relaxed);
        *running() = None;
        result
    })
}

fn running() -> std::sync::MutexGuard<'static, Option<Arc<Monitor>>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Has Ctrl+C stop the running job. If no handler can be set, it ends the program as by default.
fn set_handler() {
    let _ = ctrlc::set_handler(|| {
        let asked = running().clone();
        if asked.as_ref().is_none_or(|asked| asked.is_stopped()) {
            #[expect(
                clippy::exit,
                clippy::disallowed_methods,
                reason = "the job did not react to the first one"
            )]
            std::process::exit(INTERRUPTED);
        }
        if let Some(asked) = asked {
            asked.stop();
        }
        eprintln!("\nstopping; Ctrl+C again ends at once");
    });
}
