//! The results of a study, to be looked at: read from its folder or from its merged table, with the way back
//! from a row to the run.

use std::path::{Path, PathBuf};

use super::merge::merge;
use super::pareto::Table;
use super::result::{FIGURES, RunResult, RunStatus, result_path};
use crate::error::ErrorCode;
use crate::io::InputError;

/// List of runs in the folder of a study.
const LIST: &str = "study.json";
/// Maximum number of folders beside a table in which its runs are looked for.
const MAX_FOLDERS: usize = 10_000;

/// Results of a study.
#[derive(Clone, Debug)]
pub struct StudyResults {
    /// What was opened.
    pub path: PathBuf,
    /// A row for each run.
    pub table: Table,
    /// Number of runs without a result; `None` where only the table is known.
    pub missing: Option<usize>,
    /// The study's folder, with the results of the runs; `None` where it was not found.
    pub folder: Option<PathBuf>,
}

impl StudyResults {
    /// Reads the results in the folder of a study, given by itself or its `study.json`, or those of the table
    /// that `vanecut study merge` wrote. The folder of a table is looked for beside it.
    ///
    /// # Errors
    /// When `path` is neither a study nor its table, or cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let folder = match path.file_name() {
            _ if path.is_dir() => Some(path.to_owned()),
            Some(name) if name == LIST => Some(path.parent().unwrap_or(Path::new("")).to_owned()),
            _ => None,
        };
        if let Some(folder) = folder {
            let merged = merge(&folder)?;
            let table = Table::read_bytes(&path.display().to_string(), merged.text.as_bytes())?;
            let missing = Some(merged.missing.len());
            return Ok(Self { path: path.to_owned(), table, missing, folder: Some(folder) });
        }
        let table = Table::read(path)?;
        let mut results = Self { path: path.to_owned(), table, missing: None, folder: None };
        results.folder = results.folder_beside();
        Ok(results)
    }

    /// The folder that holds the result of the first row: that of the table, or one in it.
    fn folder_beside(&self) -> Option<PathBuf> {
        let id = self.field(0, "id")?;
        let own = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let own = own.unwrap_or(Path::new(".")).to_owned();
        let mut folders = vec![own.clone()];
        let within = std::fs::read_dir(&own).into_iter().flatten().flatten().map(|entry| entry.path());
        // Files beside the table, however many, do not count.
        let mut within: Vec<PathBuf> = within.filter(|path| path.is_dir()).take(MAX_FOLDERS).collect();
        within.sort();
        folders.extend(within);
        folders.into_iter().find(|folder| result_path(folder, id).is_file())
    }

    /// A field of a row; `None` where the table has no such column.
    pub fn field(&self, row: usize, column: &str) -> Option<&str> {
        let place = self.table.column(column)?;
        self.table.rows.get(row)?.get(place).map(String::as_str)
    }

    /// A figure of a row; `None` where it has none.
    pub fn figure(&self, row: usize, figure: &str) -> Option<f64> {
        self.field(row, figure)?.parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// The keys that vary.
    pub fn keys(&self) -> Vec<&str> {
        let other = ["id", "part", "status", "policy", "tools", "error", "part_hash", "program"];
        let is_key = |column: &&str| !other.contains(column) && !FIGURES.contains(column);
        let mut keys: Vec<&str> = self.table.columns.iter().map(String::as_str).filter(is_key).collect();
        let several_parts = self.table.rows.first().is_some_and(|first| {
            let part = self.table.column("part");
            let of = |row: &Vec<String>| part.and_then(|place| row.get(place).cloned());
            self.table.rows.iter().any(|row| of(row) != of(first))
        });
        if several_parts {
            keys.insert(0, "part");
        }
        keys
    }

    /// Whether a row has a plan.
    pub fn has_plan(&self, row: usize) -> bool {
        self.field(row, "status").is_some_and(|status| status != RunStatus::Error.name())
    }

    /// The result file of a row, and what is in it.
    ///
    /// # Errors
    /// When the folder of the study was not found, or the result cannot be read.
    pub fn run(&self, row: usize) -> Result<(PathBuf, RunResult), InputError> {
        let found = self.folder.as_ref().zip(self.field(row, "id"));
        let Some((folder, id)) = found else {
            let name = self.path.display().to_string();
            let what = "the folder with the runs of this table is not beside it";
            let help = "open the folder of the study instead: its study.json";
            return Err(InputError::new(ErrorCode::StudyResults, &name, 0, what, help));
        };
        let path = result_path(folder, id);
        RunResult::read(&path).map(|run| (path, run))
    }

    /// The file of a run's part. Its path is relative to the study file, which stands above the folder of the
    /// results or beside it. `None` if that file does not exist.
    pub fn part_file(&self, run: &RunResult) -> Option<PathBuf> {
        self.file_of_study(&run.part)
    }

    /// The file that a study names: relative to the study file, as [`Self::part_file`].
    pub fn file_of_study(&self, name: &str) -> Option<PathBuf> {
        let folder = self.folder.as_deref()?;
        let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let above = absolute.ancestors().take(4).map(|base| base.join(name));
        let here = std::iter::once(PathBuf::from(name));
        above.chain(here).find(|path| path.is_file())
    }
}
