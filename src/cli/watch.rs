//! Long work on the command line: its progress on a terminal, and Ctrl+C.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::monitor::Monitor;

/// Exit code of a program that Ctrl+C ends at once, as shells count it.
const INTERRUPTED: i32 = 130;

/// Runs a job, with its progress on a terminal. Ctrl+C asks the job to end with what it has found, a second one ends the
/// program at once.
pub fn watched<T>(job: impl FnOnce(&Monitor) -> T) -> T {
    let monitor = Arc::new(Monitor::default());
    let asked = Arc::clone(&monitor);
    // Where there can be no handler, Ctrl+C ends the program as ever.
    let _ = ctrlc::set_handler(move || {
        if asked.is_stopped() {
            std::process::exit(INTERRUPTED);
        }
        asked.stop();
        eprintln!("\nstopping with what is found; Ctrl+C again ends at once");
    });
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        if std::io::stderr().is_terminal() {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    std::thread::sleep(Duration::from_millis(100));
                    eprint!("\rplanning… {:3.0} %", 100.0 * monitor.progress());
                }
                eprint!("\r                 \r");
            });
        }
        let result = job(&monitor);
        done.store(true, Ordering::Relaxed);
        result
    })
}
