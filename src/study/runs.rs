//! The runs of a study: every combination of its axes, each with the name of its result.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::file::{StudyAxis, StudyFile};
use crate::error::{ErrorCode, UserError};
use crate::io::part_file::read_part;
use crate::io::part_hash::PartHash;
use crate::io::setup_file::{locate_machine, read_setup_with_defaults, write_full_setup};
use crate::io::sha256::sha256_hex;
use crate::io::source::read_bytes;
use crate::io::table::Scalar;
use crate::io::{InputError, source};
use crate::part::Impeller;
use crate::setup::Setup;

/// Version of the result file. It is part of the names of runs: results of another version are not taken.
pub const RESULT_VERSION: u32 = 1;
/// Hexadecimal digits of the name of a run: 64 bits, by which 100,000 runs collide once in billions of
/// studies; a collision is found, since results hold their whole input.
const ID_DIGITS: usize = 16;

/// A part of a study.
#[derive(Clone, Debug)]
pub struct StudyPart {
    /// Path as written in the study file.
    pub shown: String,
    /// The part.
    pub part: Arc<Impeller>,
    /// SHA-256 of the part in the native format. Formats of several files have no bytes of their own.
    pub hash: String,
    /// The setup of an empty file.
    pub defaults: Setup,
}

/// One run: a value on each axis.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name of the run: the first digits of the SHA-256 of part, setup and version of the result.
    pub id: String,
    /// Index of the value on each axis.
    pub choice: Vec<u32>,
}

/// All runs of a study, in the order of its axes.
#[derive(Clone, Debug)]
pub struct RunList {
    /// The study file.
    pub file: StudyFile,
    /// The parts, in the order of their axis.
    pub parts: Vec<StudyPart>,
    /// The runs; all have different names.
    pub runs: Vec<Run>,
}

/// The complete input of a run.
#[derive(Clone, Debug)]
pub struct RunInput<'a> {
    /// The part.
    pub part: &'a StudyPart,
    /// The setup with its machine file located, or why there is none.
    pub setup: Result<Setup, UserError>,
    /// The complete setup as text; the text that is not a setup where there is none.
    pub setup_text: String,
}

impl RunList {
    /// Reads the parts of a study and lists its runs.
    ///
    /// # Errors
    /// When a part cannot be read, a value can never be used, no run is left, or two runs are the same.
    pub fn from_file(file: StudyFile) -> Result<Self, InputError> {
        let paths = &file.axes[file.part_axis()].values;
        let parts = paths.iter().map(|path| read(&file, path)).collect::<Result<Vec<_>, _>>()?;
        let choices = choices(&file);
        let mut list = Self { file, parts, runs: Vec::new() };
        let ids: Vec<(String, bool)> = choices.par_iter().map(|choice| list.id_of(choice)).collect();
        list.check_values(&choices, &ids)?;
        let fault = |what: String, help: &str| {
            Err(InputError::new(ErrorCode::StudyFile, &list.file.name, 0, what, help))
        };
        if choices.is_empty() {
            return fault("every run is excluded".to_owned(), "remove an [[exclude]]");
        }
        let mut places: HashMap<&str, usize> = HashMap::with_capacity(ids.len());
        for (place, (id, _)) in ids.iter().enumerate() {
            if let Some(first) = places.insert(id, place) {
                let shown = |place: usize| list.shown_choice(&choices[place]);
                let what = format!("two runs are the same: {} and {}", shown(first), shown(place));
                return fault(what, "remove the value that is given twice");
            }
        }
        list.runs = ids.into_iter().zip(choices).map(|((id, _), choice)| Run { id, choice }).collect();
        Ok(list)
    }

    /// The complete input of a run.
    pub fn input(&self, choice: &[u32]) -> RunInput<'_> {
        let place = choice.get(self.file.part_axis()).map_or(0, |&index| index as usize);
        let part = &self.parts[place];
        let (setup, setup_text) = match self.file.setup_text(choice) {
            Err(error) => (Err(error), String::new()),
            Ok(text) => match self.read_setup(&text, &part.defaults) {
                Ok(mut setup) => {
                    let text = write_full_setup(&setup);
                    // Planning says what is wrong with a machine file.
                    let _ = locate_machine(&mut setup, &self.file.setup_path());
                    (Ok(setup), text)
                }
                Err(error) => (Err(error), text),
            },
        };
        RunInput { part, setup, setup_text }
    }

    /// Reads the setup of a run; files in it are relative to the study file.
    fn read_setup(&self, text: &str, defaults: &Setup) -> Result<Setup, UserError> {
        let name = self.file.setup_path().display().to_string();
        read_setup_with_defaults(&name, text.as_bytes(), defaults).map_err(|error| {
            // Lines of this text are those of no file, those of a file that it names are.
            let place = if error.file == name { String::new() } else { format!("{}: ", error.place()) };
            UserError::new(error.code, format!("{place}{}", error.message), error.help)
        })
    }

    /// Keys that vary, without the part.
    pub fn keys(&self) -> Vec<&str> {
        self.axes_but_part().map(|(_, axis)| axis.key.as_str()).collect()
    }

    /// Values of a run on the axes of [`Self::keys`].
    pub fn values(&self, choice: &[u32]) -> Vec<&Scalar> {
        self.axes_but_part()
            .filter_map(|(place, axis)| axis.values.get(*choice.get(place)? as usize))
            .collect()
    }

    fn axes_but_part(&self) -> impl Iterator<Item = (usize, &StudyAxis)> {
        let part = self.file.part_axis();
        self.file.axes.iter().enumerate().filter(move |(place, _)| *place != part)
    }

    /// A combination for a message, such as `plunge.step = 8, plunge.axis = minimal`.
    fn shown_choice(&self, choice: &[u32]) -> String {
        let pairs = self.keys().into_iter().zip(self.values(choice));
        let part = self.input(choice).part.shown.clone();
        let settings = pairs.map(|(key, value)| format!("{key} = {value}"));
        [part].into_iter().chain(settings).collect::<Vec<_>>().join(", ")
    }

    /// Name of a run, and whether its setup can be used.
    fn id_of(&self, choice: &[u32]) -> (String, bool) {
        let input = self.input(choice);
        // A setup that cannot be used has the values that make it so in its text, or in its message.
        let (usable, fault) = match &input.setup {
            Ok(_) => (true, String::new()),
            Err(error) => (false, error.to_string()),
        };
        let settings = if input.setup_text.is_empty() { self.shown_choice(choice) } else { String::new() };
        let mut whole = [
            &format!("vanecut study run {RESULT_VERSION}"),
            &input.part.hash,
            &input.setup_text,
            &fault,
            &settings,
        ]
        .map(String::as_str)
        .join("\n");
        // Times and goals go by what is in the machine file.
        let machine = input.setup.as_ref().ok().and_then(|setup| setup.machine.file.as_deref());
        if let Some(bytes) = machine.and_then(|file| read_bytes(Path::new(file)).ok()) {
            whole += &format!("\n{}", sha256_hex(&bytes));
        }
        let mut id = sha256_hex(whole.as_bytes());
        id.truncate(ID_DIGITS);
        (id, usable)
    }

    /// Refuses values that cannot be used in any run and are wrong by themselves, such as those of an unknown
    /// key. Values that fail in some combinations only make runs that fail.
    fn check_values(&self, choices: &[Vec<u32>], ids: &[(String, bool)]) -> Result<(), InputError> {
        let mut used: Vec<Vec<bool>> =
            self.file.axes.iter().map(|axis| vec![false; axis.values.len()]).collect();
        for (choice, _) in choices.iter().zip(ids).filter(|(_, (_, usable))| *usable) {
            for (used, &index) in used.iter_mut().zip(choice) {
                if let Some(used) = used.get_mut(index as usize) {
                    *used = true;
                }
            }
        }
        for (axis, used) in self.file.axes.iter().zip(&used) {
            for ((value, line), _) in
                axis.values.iter().zip(&axis.lines).zip(used).filter(|(_, used)| !**used)
            {
                // Errors of the path name it themselves.
                let read = self.file.text_with([(axis, value)].into_iter()).and_then(|text| {
                    self.read_setup(&text, &Setup::default()).map_err(|error| {
                        let what = format!("`{}`: {}", axis.key, error.message);
                        UserError::new(error.code, what, error.help)
                    })
                });
                if let Err(error) = read {
                    let UserError { code, message, help } = error;
                    return Err(InputError::new(code, &self.file.name, *line, message, help));
                }
            }
        }
        Ok(())
    }
}

/// Reads a part of the study.
fn read(file: &StudyFile, path: &Scalar) -> Result<StudyPart, InputError> {
    let shown = path.to_string();
    let path: PathBuf = file.folder.join(&shown);
    let description = read_part(&path)?;
    let part =
        Impeller::build(&description).map_err(|error| InputError::of_part(&source::name_of(&path), error))?;
    let hash = PartHash::from_part(&description).sha256;
    let defaults = Setup::for_part(&part);
    Ok(StudyPart { shown, part: Arc::new(part), hash, defaults })
}

/// All combinations that are not excluded, the last axis fastest; at most `limit`, picked evenly.
fn choices(file: &StudyFile) -> Vec<Vec<u32>> {
    let counts: Vec<usize> = file.axes.iter().map(|axis| axis.values.len()).collect();
    let count = counts.iter().product::<usize>();
    let decode = |mut number: usize| {
        let mut choice = vec![0; counts.len()];
        for (place, count) in counts.iter().enumerate().rev() {
            choice[place] = (number % count) as u32;
            number /= count;
        }
        choice
    };
    let excluded = |choice: &[u32]| {
        file.excludes
            .iter()
            .any(|exclude| exclude.iter().all(|(axis, values)| values.contains(&(choice[*axis] as usize))))
    };
    let kept: Vec<Vec<u32>> = (0..count).map(decode).filter(|choice| !excluded(choice)).collect();
    match file.limit {
        Some(limit) if limit < kept.len() => {
            (0..limit).filter_map(|k| kept.get(k * kept.len() / limit).cloned()).collect()
        }
        _ => kept,
    }
}
