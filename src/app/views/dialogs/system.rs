//! The system's file dialog, through rfd. rfd returns the same for a dialog that was closed and for one that
//! never opened; the difference is the error it logs, on the thread that asked.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::Once;

use log::{LevelFilter, Log, Metadata, Record};

use crate::app::model::file_purpose::Purpose;

/// Answer of the system's dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SystemAnswer {
    /// A file was chosen.
    Chosen(PathBuf),
    /// The dialog was closed without a file.
    Closed,
    /// No dialog opened.
    NotOpened,
}

/// Opens the system's dialog and waits for its answer.
pub(super) fn show_dialog(purpose: Purpose, suggestion: &str, folder: Option<&Path>) -> SystemAnswer {
    ask(|| choose(purpose, suggestion, folder))
}

fn choose(purpose: Purpose, suggestion: &str, folder: Option<&Path>) -> Option<PathBuf> {
    let (name, extensions) = purpose.filter();
    let mut dialog = rfd::FileDialog::new().set_title(purpose.title()).add_filter(name, extensions);
    if let Some(folder) = folder {
        dialog = dialog.set_directory(folder);
    }
    if purpose.saves() { dialog.set_file_name(suggestion).save_file() } else { dialog.pick_file() }
}

/// Runs `dialog`, which shows a dialog of rfd on this thread, and says whether it opened.
fn ask(dialog: impl FnOnce() -> Option<PathBuf>) -> SystemAnswer {
    static LISTEN: Once = Once::new();
    LISTEN.call_once(|| {
        // The command line has no logger; in a program that has one, errors of rfd stay unheard.
        if log::set_logger(&DialogErrors).is_ok() {
            log::set_max_level(LevelFilter::Error);
        }
    });
    HAS_FAILED.set(false);
    match dialog() {
        Some(path) => SystemAnswer::Chosen(path),
        None if HAS_FAILED.get() => SystemAnswer::NotOpened,
        None => SystemAnswer::Closed,
    }
}

thread_local! {
    /// Whether rfd reported on this thread that its last means, zenity, failed too.
    static HAS_FAILED: Cell<bool> = const { Cell::new(false) };
}

/// Notes the errors of rfd; everything else is dropped.
struct DialogErrors;

impl Log for DialogErrors {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &Record<'_>) {
        // Errors of the portal come before, and zenity may still open a dialog.
        if self.enabled(record.metadata()) && record.args().to_string().contains("zenity") {
            HAS_FAILED.set(true);
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dialog_that_fails_slowly_is_no_closed_dialog() {
        let slow = || {
            // Starting the processes takes longer in a large program.
            std::thread::sleep(std::time::Duration::from_millis(200));
            log::error!(target: "rfd::backend", "Failed to pick file with zenity: not found");
            None
        };
        assert_eq!(ask(slow), SystemAnswer::NotOpened);
        assert_eq!(ask(|| None), SystemAnswer::Closed, "closed at once");
        let portal = || {
            log::error!(target: "rfd::backend", "Failed to connect to session bus");
            None
        };
        assert_eq!(ask(portal), SystemAnswer::Closed, "zenity took over and was closed");
        assert_eq!(ask(|| Some("a".into())), SystemAnswer::Chosen("a".into()));
    }
}
