//! Merges the results of a study into one table. The table is a function of the results alone: it is the same
//! byte for byte whatever shards computed them, in whatever order.

use std::path::Path;

use super::csv::write_record;
use super::result::{FIGURES, Manifest, RunResult, result_path};
use crate::error::ErrorCode;
use crate::io::{InputError, source};

/// Columns before those of the keys that vary.
pub(super) const HEAD: [&str; 3] = ["id", "part", "status"];
/// Columns after the figures.
pub(super) const TAIL: [&str; 5] = ["policy", "tools", "error", "part_hash", "program"];

/// A merged study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Merged {
    /// The table as CSV, a row for each run that has a result, in the order of the study.
    pub text: String,
    /// Number of its rows.
    pub rows: usize,
    /// Names of runs without a whole result.
    pub missing: Vec<String>,
}

/// Merges the results in the study's `folder`.
///
/// # Errors
/// When it is not the folder of a study, or its list of runs is damaged.
pub fn merge(folder: &Path) -> Result<Merged, InputError> {
    let manifest = Manifest::read(folder)?;
    let keys = || manifest.keys.iter().map(String::as_str);
    let mut merged = Merged { text: String::new(), rows: 0, missing: Vec::new() };
    write_record(&mut merged.text, HEAD.into_iter().chain(keys()).chain(FIGURES).chain(TAIL));
    let mut program: Option<String> = None;
    for id in &manifest.runs {
        let path = result_path(folder, id);
        let Some(result) = RunResult::read(&path).ok().filter(|result| result.id == *id) else {
            merged.missing.push(id.clone());
            continue;
        };
        let first = program.get_or_insert_with(|| result.program.clone());
        if *first != result.program {
            let what = format!("is of vanecut {}, results before it of {first}", result.program);
            let help = "run the study again with one version, which redoes the others";
            return Err(InputError::new(ErrorCode::StudyResults, &source::name_of(&path), 0, what, help));
        }
        write_record(&mut merged.text, row(&result, keys()).iter().map(String::as_str));
        merged.rows += 1;
    }
    Ok(merged)
}

fn row<'k>(result: &RunResult, keys: impl Iterator<Item = &'k str>) -> Vec<String> {
    let mut row = vec![result.id.clone(), result.part.clone(), result.status.name().to_owned()];
    row.extend(keys.map(|key| result.varied.get(key).map_or(String::new(), ToString::to_string)));
    let figure = |name: &str| result.figures.get(name).copied().flatten();
    row.extend(FIGURES.iter().map(|name| figure(name).map_or(String::new(), |value| value.to_string())));
    let tools: Vec<String> = result.tools.iter().map(ToString::to_string).collect();
    row.extend([
        result.policy.clone().unwrap_or_default(),
        tools.join(" "),
        result.error.clone().unwrap_or_default(),
        result.part_hash.clone(),
        result.program.clone(),
    ]);
    row
}
