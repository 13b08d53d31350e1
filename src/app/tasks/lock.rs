//! Files that are locked as long as a session, or its open project, lasts. The system unlocks them however
//! the session ends, at once; a process number would not tell that.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// A lock file that this session holds; removed when it is dropped.
#[derive(Debug)]
pub(in crate::app) struct HeldLock {
    _file: File,
    path: PathBuf,
}

impl Drop for HeldLock {
    fn drop(&mut self) {
        // A file that stays is not locked, so it says nothing.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Result of trying to hold a lock.
#[derive(Debug)]
pub(in crate::app) enum LockTry {
    /// It is held now.
    Held(HeldLock),
    /// Another session, or another window of this one, holds it.
    HeldElsewhere,
    /// The file cannot be made or locked here, so nothing is known.
    Unknown,
}

/// Tries to hold the lock file at `path`; its folder is made.
pub(in crate::app) fn try_hold(path: PathBuf) -> LockTry {
    if let Some(folder) = path.parent() {
        // If this fails, so does the next step.
        let _ = std::fs::create_dir_all(folder);
    }
    let Ok(file) = File::create(&path) else { return LockTry::Unknown };
    match file.try_lock() {
        Ok(()) => LockTry::Held(HeldLock { _file: file, path }),
        Err(TryLockError::WouldBlock) => LockTry::HeldElsewhere,
        Err(TryLockError::Error(_)) => LockTry::Unknown,
    }
}

/// Whether anyone holds the lock file at `path`.
pub(in crate::app) fn is_held(path: &Path) -> bool {
    File::open(path).is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}
