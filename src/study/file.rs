//! The study file, TOML: parts, a base setup, and what varies.
//!
//! ```toml
//! parts = ["impeller532.toml"]        # or part = "…"; beside the study file
//! base = "setup.toml"                 # or the setup itself as [setup]; absent: the defaults of each part
//! limit = 200                         # at most this many runs, picked evenly
//! [[axis]]                            # every combination of the values of all axes is a run
//! key = "plunge.step"                 # a key of the setup, or "policy", or "part"
//! values = [6, 8, 10]
//! [[axis]]
//! key = "tool.1.diameter"             # of the tool with this number
//! range = [20, 30, 5]                 # from, to, step
//! [[exclude]]                         # runs that have all these values are left out
//! policy = "staircase"
//! plunge.step = [6, 8]
//! ```

use std::path::{Path, PathBuf};

use super::setting::{canonical_key, range_values, same_value, set_in_setup, setup_tree};
use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::setup_file::{read_setup_with_defaults, setup_of_table};
use crate::io::source::{name_of, quote_for_message, read_bytes};
use crate::io::table::{Located, Scalar, TomlDocument, TomlTable, known_or_none};
use crate::setup::Setup;

/// Maximum number of runs of a study, before exclusions and its limit.
pub const MAX_RUNS: usize = 100_000;
/// Maximum number of axes.
const MAX_AXES: usize = 32;
/// The key of the axis of parts.
pub const PART: &str = "part";

/// What varies: a key of the setup, or the part.
#[derive(Clone, Debug)]
pub struct StudyAxis {
    /// Dotted path of the key in the setup, or `PART`.
    pub key: String,
    /// Its values; of the axis of parts, paths as written in the study file.
    pub values: Vec<Scalar>,
    /// Line of each value.
    pub lines: Vec<usize>,
}

/// A study file as read. The values of its axes are not yet checked against the setup.
#[derive(Clone, Debug)]
pub struct StudyFile {
    /// Name for messages.
    pub name: String,
    /// Folder that paths in the file are relative to.
    pub folder: PathBuf,
    /// The base setup.
    pub base: toml::Table,
    /// What varies, slowest first; one of them is `PART`.
    pub axes: Vec<StudyAxis>,
    /// Combinations that are left out: per entry, the indices of the values that match on each axis it names.
    pub excludes: Vec<Vec<(usize, Vec<usize>)>>,
    /// Maximum number of runs.
    pub limit: Option<usize>,
}

impl StudyFile {
    /// Reads a study file and its base setup.
    ///
    /// # Errors
    /// When a file cannot be read, a key is unknown, or a value is outside its range.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        Self::read_bytes(&name_of(path), &read_bytes(path)?, &folder)
    }

    /// Reads a study from bytes; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_bytes(name: &str, bytes: &[u8], folder: &Path) -> Result<Self, InputError> {
        let document = TomlDocument::new(name, bytes, ErrorCode::StudyFile)?;
        let tree = document.parse()?;
        let root = document.root(&tree);
        root.check_keys(&["part", "parts", "base", "setup", "axis", "exclude", "limit"])?;
        let base = base_setup(&root, name, bytes, folder)?;
        let axes = axes(&document, &root)?;
        let excludes =
            root.tables("exclude")?.iter().map(|table| exclude(table, &axes)).collect::<Result<_, _>>()?;
        let limit = root.whole("limit", 1, MAX_RUNS as u32)?.map(|limit| limit.value as usize);
        let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
        if count.is_none_or(|count| count > MAX_RUNS) {
            let counts: Vec<String> = axes.iter().map(|axis| axis.values.len().to_string()).collect();
            let what = format!("{} combinations are more than {MAX_RUNS} runs", counts.join(" × "));
            return Err(root
                .fault(what, "give fewer values, or make several studies of it")
                .with_code(ErrorCode::FileTooLarge));
        }
        Ok(Self { name: name.to_owned(), folder: folder.to_owned(), base, axes, excludes, limit })
    }

    /// Where the setups of runs stand: files that they name are relative to the study file.
    pub fn setup_path(&self) -> PathBuf {
        self.folder.join("(setup)")
    }

    /// The place of the axis of parts.
    pub fn part_axis(&self) -> usize {
        self.axes.iter().position(|axis| axis.key == PART).unwrap_or(0)
    }

    /// The setup of a run as TOML text: the base with one value of each axis, by their indices in `choice`.
    ///
    /// # Errors
    /// When a key does not fit the base.
    pub fn setup_text(&self, choice: &[u32]) -> Result<String, UserError> {
        let chosen = self.axes.iter().zip(choice);
        self.text_with(chosen.filter_map(|(axis, &value)| Some((axis, axis.values.get(value as usize)?))))
    }

    /// The base setup with these values as TOML text.
    ///
    /// # Errors
    /// As [`Self::setup_text`].
    pub fn text_with<'a>(
        &self,
        values: impl Iterator<Item = (&'a StudyAxis, &'a Scalar)>,
    ) -> Result<String, UserError> {
        let mut tree = self.base.clone();
        for (axis, value) in values.filter(|(axis, _)| axis.key != PART) {
            set_in_setup(&mut tree, &axis.key, value)?;
        }
        toml::to_string(&tree).map_err(|error| {
            let what = format!("the setup cannot be written ({error})");
            UserError::new(ErrorCode::StudyFile, what, "simplify it")
        })
    }
}

/// The base setup, from `base`, `[setup]`, or empty; checked as any setup.
fn base_setup(
    root: &TomlTable<'_>,
    name: &str,
    bytes: &[u8],
    folder: &Path,
) -> Result<toml::Table, InputError> {
    let inline = root.table("setup")?;
    match (root.string("base")?, inline) {
        (Some(base), Some(_)) => Err(root
            .fault_at(base.at, "both `base` and [setup] are given", "keep one of them")
            .with_code(ErrorCode::ConflictingKeys)),
        (Some(base), None) => {
            let path = folder.join(base.value);
            let bytes = read_bytes(&path)?;
            let name = name_of(&path);
            read_setup_with_defaults(&name, &bytes, &Setup::default())?;
            let mut tree = setup_tree(&name, &bytes)?;
            let beside = Path::new(base.value).parent().unwrap_or(Path::new(""));
            name_files_from(&mut tree, beside, folder);
            Ok(tree)
        }
        (None, Some(table)) => {
            setup_of_table(&table, &Setup::default())?;
            match setup_tree(name, bytes)?.remove("setup") {
                Some(toml::Value::Table(table)) => Ok(table),
                _ => Ok(toml::Table::new()),
            }
        }
        (None, None) => Ok(toml::Table::new()),
    }
}

/// Names the files of a base setup, which is in the folder `beside` of the study's `folder`, as seen from the
/// latter.
fn name_files_from(tree: &mut toml::Table, beside: &Path, folder: &Path) {
    for (table, key) in [("machine", "file"), ("stock", "blank")] {
        let named = tree.get_mut(table).and_then(|table| table.get_mut(key));
        let Some(toml::Value::String(file)) = named else { continue };
        let path = beside.join(&*file);
        // Other values are words.
        if folder.join(&path).is_file() {
            *file = path.to_string_lossy().into_owned();
        }
    }
}

/// All axes, with that of the parts first unless it has its own place.
fn axes(document: &TomlDocument<'_>, root: &TomlTable<'_>) -> Result<Vec<StudyAxis>, InputError> {
    let one =
        root.string("part")?.map(|part| Located { value: Scalar::Text(part.value.to_owned()), at: part.at });
    let many = root.strings("parts")?.map(|parts| {
        parts.into_iter().map(|part| Located { value: Scalar::Text(part.value.to_owned()), at: part.at })
    });
    let parts: Vec<Located<Scalar>> = one.into_iter().chain(many.into_iter().flatten()).collect();
    let mut axes = Vec::new();
    if !parts.is_empty() {
        axes.push(new_axis(document, root, PART.to_owned(), parts)?);
    }
    let tables = root.tables("axis")?;
    for table in &tables {
        let axis = axis(document, table)?;
        if axes.iter().any(|known: &StudyAxis| known.key == axis.key) {
            let what = format!("`{}` varies on two axes", axis.key);
            return Err(table
                .fault(what, "put all its values on one axis")
                .with_code(ErrorCode::ConflictingKeys));
        }
        if axes.len() == MAX_AXES {
            return Err(table
                .fault(format!("more than {MAX_AXES} axes"), "make several studies of it")
                .with_code(ErrorCode::FileTooLarge));
        }
        axes.push(axis);
    }
    if !axes.iter().any(|axis| axis.key == PART) {
        return Err(root
            .fault("the study has no part", "add part = \"FILE\" or parts = [\"FILE\", …]")
            .with_code(ErrorCode::MissingKey));
    }
    Ok(axes)
}

fn axis(document: &TomlDocument<'_>, table: &TomlTable<'_>) -> Result<StudyAxis, InputError> {
    table.check_keys(&["key", "values", "range"])?;
    let key = table.string("key")?.ok_or_else(|| {
        table
            .fault("the axis has no `key`", "give the key of a setup that varies, such as \"plunge.step\"")
            .with_code(ErrorCode::MissingKey)
    })?;
    let canonical = canonical_key(key.value).map_err(|error| table.locate(key.at, error))?;
    let values = match (table.scalars("values")?, table.numbers("range")?) {
        (Some(values), None) => values,
        (None, Some(range)) => {
            let values =
                range_values(&range.value, MAX_RUNS).map_err(|error| table.locate(range.at, error))?;
            values.into_iter().map(|value| Located { value, at: range.at }).collect()
        }
        (Some(_), Some(range)) => {
            return Err(table
                .fault_at(range.at, "the axis has `values` and `range`", "keep one of them")
                .with_code(ErrorCode::ConflictingKeys));
        }
        (None, None) => {
            let what = format!("the axis of `{canonical}` has no values");
            return Err(table
                .fault(what, "add values = […] or range = [from, to, step]")
                .with_code(ErrorCode::MissingKey));
        }
    };
    new_axis(document, table, canonical, values)
}

/// An axis with its values checked: some, none twice, and of the parts all texts.
fn new_axis(
    document: &TomlDocument<'_>,
    table: &TomlTable<'_>,
    key: String,
    values: Vec<Located<Scalar>>,
) -> Result<StudyAxis, InputError> {
    if values.is_empty() {
        return Err(table
            .fault(format!("the axis of `{key}` has no values"), "give one or more")
            .with_code(ErrorCode::MissingKey));
    }
    if values.len() > MAX_RUNS {
        let what = format!("the axis of `{key}` has {} values", values.len());
        return Err(table.fault(what, format!("give at most {MAX_RUNS}")).with_code(ErrorCode::FileTooLarge));
    }
    let mut shown = std::collections::HashSet::new();
    for value in &values {
        if !shown.insert(value.value.to_string()) {
            let what = format!("`{key}` has the value {} twice", quote_for_message(&value.value.to_string()));
            return Err(table
                .fault_at(value.at, what, "remove one of them")
                .with_code(ErrorCode::ConflictingKeys));
        }
        if key == PART && !matches!(value.value, Scalar::Text(_)) {
            return Err(table
                .fault_at(value.at, "a part is not a text", "give the path of a part file")
                .with_code(ErrorCode::ValueType));
        }
    }
    let lines = values.iter().map(|value| document.line(value.at)).collect();
    Ok(StudyAxis { key, values: values.into_iter().map(|value| value.value).collect(), lines })
}

/// One `[[exclude]]`: the axes it names and the values on them.
fn exclude(table: &TomlTable<'_>, axes: &[StudyAxis]) -> Result<Vec<(usize, Vec<usize>)>, InputError> {
    let keys = table.dotted_scalars()?;
    if keys.is_empty() {
        return Err(table.fault("the exclusion is empty", "give values of axes that are left out together"));
    }
    let mut matched: Vec<(usize, Vec<usize>)> = Vec::new();
    for (written, values) in keys {
        let at = values.first().map(|value| value.at);
        let fault = |what: String, help: String| match at {
            Some(at) => table.fault_at(at, what, help),
            None => table.fault(what, help),
        };
        let key = canonical_key(&written).unwrap_or_else(|_| written.clone());
        let Some(index) = axes.iter().position(|axis| axis.key == key) else {
            let names: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
            let what = format!("{} is not an axis of the study", quote_for_message(&written));
            return Err(fault(what, known_or_none("axis", &key, &names)).with_code(ErrorCode::UnknownKey));
        };
        if matched.iter().any(|(known, _)| *known == index) {
            return Err(fault(format!("`{key}` is given twice"), "keep one of them".to_owned())
                .with_code(ErrorCode::ConflictingKeys));
        }
        let mut indices = Vec::with_capacity(values.len());
        for value in &values {
            let place = axes[index].values.iter().position(|known| same_value(known, &value.value));
            indices.push(place.ok_or_else(|| {
                let shown = quote_for_message(&value.value.to_string());
                let what = format!("{shown} is not a value on the axis of `{key}`");
                table.fault_at(value.at, what, "give values of the axis, or remove it")
            })?);
        }
        matched.push((index, indices));
    }
    Ok(matched)
}
