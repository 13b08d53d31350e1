//! Watches the file of the checked program, which a post or an editor may write again.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::Repaint;
use super::latest::Latest;
use crate::app::model::checked::{CheckedProgram, FileChange, FileStamp};

/// Interval at which the file is looked at.
pub(in crate::app) const LOOK_EVERY: Duration = Duration::from_secs(1);

/// One look at a file.
#[derive(Clone, PartialEq)]
struct FileLook {
    path: PathBuf,
    /// The file as it was checked.
    checked: Option<FileStamp>,
    /// Number of the interval.
    number: u64,
}

/// Looks at the file in the background: a folder in the network may be slow.
pub(in crate::app) struct ProgramWatch(Latest<FileLook, FileChange>);

impl ProgramWatch {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("program watch", repaint, change_of))
    }

    /// What became of the file of `checked` since then, as far as is known at `time`, s.
    pub(in crate::app) fn follow(&mut self, checked: Option<&CheckedProgram>, time: f64) -> FileChange {
        let number = (time / LOOK_EVERY.as_secs_f64()) as u64;
        let wanted = checked.map(|checked| FileLook {
            path: checked.request.path.clone(),
            checked: checked.stamp,
            number,
        });
        // A slow look is not given up for the next one.
        let is_of = |look: &FileLook| {
            checked.is_some_and(|checked| look.path == checked.request.path && look.checked == checked.stamp)
        };
        let pending = self.0.asked().filter(|look| self.0.is_busy() && is_of(look)).cloned();
        self.0.request(pending.or(wanted));
        self.0.answer().filter(|(look, _)| is_of(look)).map_or(FileChange::None, |(_, change)| *change)
    }
}

/// What the system says of a file; `None` if it is not there.
pub(super) fn stamp_of(path: &Path) -> Option<FileStamp> {
    let data = std::fs::metadata(path).ok()?;
    Some(FileStamp { written: data.modified().ok()?, size: data.len() })
}

fn change_of(look: &FileLook) -> FileChange {
    match (look.checked, stamp_of(&look.path)) {
        (None, _) => FileChange::None,
        (Some(_), None) => FileChange::Gone,
        (Some(checked), Some(now)) if checked == now => FileChange::None,
        (Some(_), Some(_)) => FileChange::Written,
    }
}
