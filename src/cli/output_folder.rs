//! The folder that a command writes to.

use std::path::Path;

use super::Failure;
use crate::error::ErrorCode;
use crate::io::write::write_all_atomically;
use crate::report::ReportPage;

/// Checks the output directory before planning, so that [`create_directory`] does not fail only after it.
///
/// # Errors
/// [`Failure::input`] when `folder` exists and is not a directory.
pub fn check_directory(folder: &Path) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        let help = "give one that can be written";
        return Err(Failure::input(ErrorCode::FileNotWritten, "is not a directory", help).at_path(folder));
    }
    Ok(())
}

/// Creates the output directory.
///
/// # Errors
/// [`Failure::input`] when it cannot be created.
pub fn create_directory(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        let what = format!("the directory cannot be created ({error})");
        Failure::input(ErrorCode::FileNotWritten, what, "give one that can be written").at_path(folder)
    })
}

/// Writes a document as `report.html` into `folder`.
///
/// # Errors
/// [`Failure::input`] when a file cannot be written.
pub fn write_report(folder: &Path, document: &ReportPage) -> Result<(), Failure> {
    Ok(write_all_atomically(&document.files_at(&folder.join("report.html")))?)
}
