//! The result file of a run, and the list of runs beside them.
//!
//! A study's folder holds `study.json`, the names of all runs in order, and `runs/ID.json`, one a run.
//! Lengths are mm, angles degrees, times seconds.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::runs::{RESULT_VERSION, Run, RunInput, RunList};
use crate::error::ErrorCode;
use crate::io::source::read_bytes;
use crate::io::table::Scalar;
use crate::io::write::write_atomically;
use crate::io::{InputError, source};

/// Version of the program, whose results are not mixed with those of another.
pub const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");

/// The figure of the time on the machine of the setup; there is none without a machine.
pub const MACHINE_TIME: &str = "machine_time";
/// Figures of a run, in the order of columns; names as in `vanecut plan --json`, and `faults`, the number of
/// faults that `verify` finds in the program.
pub const FIGURES: [&str; 21] = [
    "positions",
    "rows",
    "sections",
    "time_estimate",
    MACHINE_TIME,
    "residual_mean",
    "residual_p95",
    "residual_max",
    "uncut_share",
    "unreachable_share",
    "interferential",
    "max_contact_depth",
    "faults",
    "blocked",
    "min_hub_clearance",
    "min_blade_clearance",
    "min_retract_clearance",
    "max_axis_change",
    "cut_length",
    "rapid_length",
    "rounds",
];

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RunStatus {
    /// A plan without faults.
    Done,
    /// A plan whose program has faults, as `verify` finds them.
    Faults,
    /// A plan whose planning loop did not converge.
    #[serde(rename = "unsettled")]
    NotConverged,
    /// No plan: part and setup do not go together.
    Error,
}

impl RunStatus {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Faults => "faults",
            Self::NotConverged => "unsettled",
            Self::Error => "error",
        }
    }
}

/// Result of a run, as it is in its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// [`RESULT_VERSION`].
    pub vanecut_study_run: u32,
    /// `PROGRAM_VERSION`.
    pub program: String,
    /// Name of the run.
    pub id: String,
    /// Path of the part as in the study file.
    pub part: String,
    /// SHA-256 of the part.
    pub part_hash: String,
    /// The value of each key that varies.
    pub varied: BTreeMap<String, Scalar>,
    /// The complete setup, as a setup file.
    pub setup: String,
    /// How the run ended.
    pub status: RunStatus,
    /// Why there is no plan, or the first fault of its program.
    pub error: Option<String>,
    /// Axis policy of the plan.
    pub policy: Option<String>,
    /// Diameters of the tools in the order of the sections.
    pub tools: Vec<f64>,
    /// Figures by the names in `FIGURES`; null where there is nothing to measure.
    pub figures: BTreeMap<String, Option<f64>>,
    /// Wall-clock time, s. The only value that is not the same each time.
    pub elapsed: f64,
}

/// Path of the result of the run `id` in the study's `folder`.
pub fn result_path(folder: &Path, id: &str) -> PathBuf {
    folder.join("runs").join(format!("{id}.json"))
}

impl RunResult {
    /// The result of a run in `folder`, if there is a whole one of this input and this program.
    pub fn existing(folder: &Path, run: &Run, input: &RunInput<'_>) -> Option<Self> {
        let result = Self::read(&result_path(folder, &run.id)).ok()?;
        let same = result.id == run.id
            && result.program == PROGRAM_VERSION
            && result.part_hash == input.part.hash
            && result.setup == input.setup_text
            // Earlier programs had fewer.
            && FIGURES.iter().all(|name| result.figures.contains_key(*name));
        same.then_some(result)
    }

    /// Reads a result file.
    ///
    /// # Errors
    /// When it cannot be read, is damaged, or is of another version.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let bytes = read_bytes(path)?;
        let fault = |line, what: String| {
            InputError::new(
                ErrorCode::StudyResults,
                &source::name_of(path),
                line,
                what,
                "run the study again, which redoes it",
            )
        };
        let result: Self = serde_json::from_slice(&bytes)
            .map_err(|error| fault(error.line(), format!("is not the result of a run ({error})")))?;
        if result.vanecut_study_run != RESULT_VERSION {
            let version = result.vanecut_study_run;
            return Err(fault(0, format!("is a result of version {version}, not {RESULT_VERSION}")));
        }
        Ok(result)
    }

    /// Writes the result into the study's `folder`, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), InputError> {
        write_atomically(&result_path(folder, &self.id), json_text(self).as_bytes())
    }
}

/// `study.json`: what the results in the folder belong to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`RESULT_VERSION`].
    pub vanecut_study: u32,
    /// Keys that vary.
    pub keys: Vec<String>,
    /// Names of all runs, in order.
    pub runs: Vec<String>,
}

/// Path of the manifest in the study's `folder`.
fn manifest_path(folder: &Path) -> PathBuf {
    folder.join("study.json")
}

impl Manifest {
    /// The manifest of a study.
    pub fn from_list(list: &RunList) -> Self {
        Self {
            vanecut_study: RESULT_VERSION,
            keys: list.keys().into_iter().map(str::to_owned).collect(),
            runs: list.runs.iter().map(|run| run.id.clone()).collect(),
        }
    }

    /// Reads the manifest of the study in `folder`.
    ///
    /// # Errors
    /// When there is none, it is damaged, or of another version.
    pub fn read(folder: &Path) -> Result<Self, InputError> {
        let path = manifest_path(folder);
        let name = source::name_of(&path);
        if !path.exists() {
            let what = "is not there, so that this is not the folder of a study";
            return Err(InputError::new(
                ErrorCode::StudyResults,
                &name,
                0,
                what,
                "give the DIR of `vanecut study STUDY.toml -o DIR`",
            ));
        }
        let manifest: Self = serde_json::from_slice(&read_bytes(&path)?).map_err(|error| {
            let what = format!("is not the list of a study's runs ({error})");
            InputError::new(
                ErrorCode::StudyResults,
                &name,
                error.line(),
                what,
                "run the study again, which writes it anew",
            )
        })?;
        let is_name = |id: &String| !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_hexdigit());
        if manifest.vanecut_study != RESULT_VERSION || !manifest.runs.iter().all(is_name) {
            let what = format!("is not a list of version {RESULT_VERSION}");
            return Err(InputError::new(
                ErrorCode::StudyResults,
                &name,
                0,
                what,
                "run the study again, which writes it anew",
            ));
        }
        Ok(manifest)
    }

    /// Writes the manifest into `folder`, unless it is there. Shards write the same bytes.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), InputError> {
        let text = json_text(self);
        let path = manifest_path(folder);
        if read_bytes(&path).is_ok_and(|bytes| bytes == text.as_bytes()) {
            return Ok(());
        }
        write_atomically(&path, text.as_bytes())
    }
}

fn json_text(value: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}
