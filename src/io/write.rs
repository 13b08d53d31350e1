//! Writes output files atomically: completely or not at all.

use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::InputError;
use super::source::name_of;
use crate::error::ErrorCode;

/// Writes `bytes` to `path` atomically: to a temporary file beside it, which is then renamed. On failure
/// an existing file is unchanged and no temporary file remains.
///
/// # Errors
/// When `path` is not a regular file, or the file cannot be written or renamed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    write_all_atomically(&[(path.to_owned(), bytes)])
}

/// Writes several files as [`write_atomically`] does; none is renamed before all are on the disk.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_all_atomically(files: &[(PathBuf, &[u8])]) -> Result<(), InputError> {
    let mut waiting = TemporaryFiles(Vec::new());
    for (path, bytes) in files {
        waiting.0.push(write_beside(path, bytes)?);
    }
    for ((path, _), temporary) in files.iter().zip(&waiting.0) {
        std::fs::rename(temporary, path).map_err(|error| failed(path, &error))?;
    }
    Ok(())
}

/// Temporary files that are not renamed yet; on drop, the remaining ones are removed.
struct TemporaryFiles(Vec<PathBuf>);

impl Drop for TemporaryFiles {
    fn drop(&mut self) {
        for temporary in &self.0 {
            // Renamed files no longer exist under this name, so the error is ignored.
            let _ = std::fs::remove_file(temporary);
        }
    }
}

/// That `path` is not replaced, since it `is` something else than what may be written there.
pub fn not_replaced(path: &Path, is: &str) -> InputError {
    fault(path, is.to_owned(), "name another file to write")
}

fn fault(path: &Path, what: String, help: &str) -> InputError {
    InputError::new(ErrorCode::FileNotWritten, &name_of(path), 0, what, help)
}

fn failed(path: &Path, error: &Error) -> InputError {
    let help = match error.kind() {
        // Of file systems that take no files of others, such as that of the processes.
        ErrorKind::NotFound if path.parent().is_some_and(Path::is_dir) => {
            "choose a folder that you may write to"
        }
        ErrorKind::NotFound | ErrorKind::NotADirectory => "make the folder first, or name another",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space on the disk",
        _ => "check the disk, or name another folder",
    };
    fault(path, format!("cannot be written: {error}"), help)
}

/// Writes `bytes` to a temporary file beside `path` and returns its path.
fn write_beside(path: &Path, bytes: &[u8]) -> Result<PathBuf, InputError> {
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        return Err(fault(path, "is a folder, not a file".to_owned(), "name a file in it"));
    };
    if path.exists() && !path.is_file() {
        return Err(fault(path, "is not a regular file".to_owned(), "name a file to write"));
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let (file, temporary) =
        create_beside(folder, &name.to_string_lossy()).map_err(|error| failed(path, &error))?;
    if let Err(error) = write_synced(file, bytes) {
        // Only the write error is reported, not a failure to remove the file.
        let _ = std::fs::remove_file(&temporary);
        return Err(failed(path, &error));
    }
    Ok(temporary)
}

/// Creates a new file in `folder` with a unique name.
fn create_beside(folder: &Path, name: &str) -> Result<(File, PathBuf), Error> {
    let process = std::process::id();
    let short: String = name.chars().take(40).collect();
    for attempt in 0..1000 {
        let path = folder.join(format!(".{short}.{process}-{attempt}.tmp"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
            Ok(file) => return Ok((file, path)),
        }
    }
    Err(Error::new(ErrorKind::AlreadyExists, "too many unfinished files in the folder"))
}

fn write_synced(mut file: File, bytes: &[u8]) -> Result<(), Error> {
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests make their own files")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn writes_and_replaces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_atomically(&path, b"old and longer").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[test]
    fn failures_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_atomically(&folder.path().join("no/such/a.json"), b"x").unwrap_err();
        assert_eq!(error.code, ErrorCode::FileNotWritten, "{error}");
        let error = write_atomically(folder.path(), b"x").unwrap_err();
        assert_eq!(error.code, ErrorCode::FileNotWritten, "{error}");
        assert!(write_atomically(&folder.path().join(".."), b"x").is_err());
        assert!(write_atomically(Path::new(""), b"x").is_err());
        assert!(names(folder.path()).is_empty());
    }
}
