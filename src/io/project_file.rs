//! The project file: the part, its setup, the what-if sets to compare, and the view. It is JSON, so that
//! it can be read in an editor; setups are embedded as the text of setup files.
//!
//! The part is not embedded: the file gives its path, relative to the project file where possible, and a
//! hash of the part description, so that a later change of the part is detected.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::InputError;
use super::setup_file::{
    SetupEntry, SetupEntryFault, TolerantSetup, beside, read_setup_tolerantly, relative, write_setup,
};
use super::source::{Source, name_of, read_bytes};
use super::stored::{check_version, inside};
use crate::error::ErrorCode;
use crate::mesh::MeshOptions;
use crate::setup::Setup;

/// Version of the file format; newer files are rejected.
pub const VERSION: u32 = 5;
/// Extension of project files.
pub const EXTENSION: &str = "vanecut";
/// What the current setup is called in messages.
const CURRENT: &str = "setup";
/// Maximum number of sets in a project.
const MAX_SETS: usize = 1000;

/// Where the part of a project comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartLocation {
    /// A file.
    File(PathBuf),
    /// A mesh file, with the user's options for it.
    Mesh {
        /// The file.
        file: PathBuf,
        /// Roles, unit, axis and other options.
        choices: MeshOptions,
    },
    /// A sample that comes with the program.
    Sample(String),
}

impl PartLocation {
    /// The same with its file path replaced by `to(path)`.
    fn with_path(&self, to: impl FnOnce(&Path) -> PathBuf) -> Self {
        match self {
            Self::File(file) => Self::File(to(file)),
            Self::Mesh { file, choices } => Self::Mesh { file: to(file), choices: choices.clone() },
            Self::Sample(name) => Self::Sample(name.clone()),
        }
    }
}

/// The camera of the view; lengths mm, angles rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Viewpoint {
    /// Point at the centre of the view, part frame, mm.
    pub target: [f32; 3],
    /// Angle about the rotation axis, rad.
    pub yaw: f32,
    /// Angle above the horizon, rad.
    pub pitch: f32,
    /// Distance from the target, mm.
    pub distance: f32,
    /// Whether the projection is parallel.
    pub parallel: bool,
}

/// What of the plan was selected and displayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSelection {
    /// Whether the conventional plan was shown.
    #[serde(default)]
    pub before: bool,
    /// Position, counted from 0 in cutting order.
    #[serde(default)]
    pub position: Option<usize>,
    /// Number of positions of channel 1 displayed as cut; `None`: all.
    #[serde(default)]
    pub cut: Option<usize>,
    /// Number of channels that were displayed.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub channels: usize,
    /// Number of plunges of all these that were displayed as cut; `None`: all, or one channel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels_cut: Option<usize>,
    /// Channel of the position, in pitches ahead of channel 1.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub channel: usize,
    /// Whether flank milling was selected, and not roughing.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub flank: bool,
}

impl Default for PlanSelection {
    fn default() -> Self {
        Self {
            before: false,
            position: None,
            cut: None,
            channels: 1,
            channels_cut: None,
            channel: 0,
            flank: false,
        }
    }
}

fn one() -> usize {
    1
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_one(count: &usize) -> bool {
    *count == 1
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Results of planning a setup, by which sets are compared. Lengths mm, time s, share 0…1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetFigures {
    /// Number of plunges.
    pub positions: usize,
    /// Number of plunges whose core meets stock, or that exceed an allowance or the reach of the machine.
    pub interferential: usize,
    /// Mean residual stock on the channel floor, mm.
    pub residual_mean: f64,
    /// Its 95th percentile, mm.
    pub residual_p95: f64,
    /// Share of the accessible floor that no plunge cuts.
    pub uncut_share: f64,
    /// Machining time of one channel, s.
    pub time: f64,
    /// The same of all channels; `None` in projects of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheel_time: Option<f64>,
}

impl SetFigures {
    /// Whether all of them are numbers.
    fn is_known(&self) -> bool {
        let wheel = self.wheel_time.unwrap_or(0.0);
        [self.residual_mean, self.residual_p95, self.uncut_share, self.time, wheel]
            .into_iter()
            .all(f64::is_finite)
    }
}

/// A what-if set kept for comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredSet {
    /// Its name.
    pub name: String,
    /// The setup.
    pub setup: Setup,
    /// Its results, if it was planned.
    pub figures: Option<SetFigures>,
    /// As [`Project::setup_faults`], in its setup.
    pub faults: Vec<SetupEntryFault>,
}

/// A project.
#[derive(Clone, Debug, PartialEq)]
pub struct Project {
    /// Where the part comes from. When read, relative paths are resolved against the project's folder.
    pub part: PartLocation,
    /// [`PartHash::fnv1a`](super::part_hash::PartHash::fnv1a) of its description.
    pub part_hash: u64,
    /// The current setup.
    pub setup: Setup,
    /// Sets kept for comparison.
    pub sets: Vec<StoredSet>,
    /// The camera of the view.
    pub viewpoint: Option<Viewpoint>,
    /// What of the plan was selected and displayed.
    pub chosen: PlanSelection,
    /// Which layers of the view were shown, and by what they were coloured, as the window writes it; `None`
    /// in projects of older versions.
    pub layers: Option<serde_json::Value>,
    /// In recovery copies that were saved automatically, the project file they belong to.
    pub original: Option<PathBuf>,
    /// In such a copy, the hash of that file as the session knew it, if it did.
    pub original_hash: Option<u64>,
    /// Faulty entries of the current setup, each with its default in its place. The file keeps them until
    /// somebody has given another value.
    pub setup_faults: Vec<SetupEntryFault>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProjectFile {
    vanecut_project: u32,
    part: PartLocation,
    part_hash: String,
    setup: String,
    #[serde(default)]
    sets: Vec<SetFile>,
    #[serde(default)]
    viewpoint: Option<Viewpoint>,
    #[serde(default)]
    chosen: PlanSelection,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    layers: Option<serde_json::Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    original: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    original_hash: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    replaced: Vec<ReplacedFile>,
}

/// A fault of the setup that was read, in whose place its default stands.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReplacedFile {
    code: String,
    file: String,
    line: usize,
    message: String,
    help: String,
    /// Table, index and key of the entry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    entry: Option<(String, usize, Option<String>)>,
}

impl ReplacedFile {
    fn new(SetupEntryFault { error, entry }: &SetupEntryFault) -> Self {
        let entry = entry.as_ref().map(|e| (e.table.clone(), e.index, e.key.clone()));
        let (code, line) = (error.code.name().to_owned(), error.line);
        let (file, message, help) = (error.file.clone(), error.message.clone(), error.help.clone());
        Self { code, file, line, message, help, entry }
    }

    fn fault(self) -> SetupEntryFault {
        let code = ErrorCode::named(&self.code).unwrap_or(ErrorCode::PlanFile);
        let entry = self.entry.map(|(table, index, key)| SetupEntry { table, index, key });
        SetupEntryFault {
            error: InputError::new(code, &self.file, self.line, self.message, self.help),
            entry,
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SetFile {
    name: String,
    setup: String,
    #[serde(default)]
    figures: Option<SetFigures>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    replaced: Vec<ReplacedFile>,
}

/// Writes a project file (JSON) to be saved at `path`: the part's path is relative to it if the part is
/// in the same folder or below.
pub fn write_project(project: &Project, path: &Path) -> String {
    let part = project.part.with_path(|part| relative(part, path));
    let file = ProjectFile {
        vanecut_project: VERSION,
        part,
        part_hash: format!("{:016x}", project.part_hash),
        setup: write_setup(&beside(&project.setup, path)),
        sets: project
            .sets
            .iter()
            .map(|set| SetFile {
                name: set.name.clone(),
                setup: write_setup(&beside(&set.setup, path)),
                // JSON has no NaN; figures without a value are omitted.
                figures: set.figures.filter(SetFigures::is_known),
                replaced: set.faults.iter().map(ReplacedFile::new).collect(),
            })
            .collect(),
        viewpoint: project.viewpoint,
        chosen: project.chosen,
        layers: project.layers.clone(),
        original: project.original.clone(),
        original_hash: project.original_hash.map(|hash| format!("{hash:016x}")),
        replaced: project.setup_faults.iter().map(ReplacedFile::new).collect(),
    };
    let mut text = serde_json::to_string_pretty(&file).unwrap_or_default();
    text.push('\n');
    text
}

/// Reads a project file.
///
/// # Errors
/// As [`read_project_bytes`], or when the file cannot be read.
pub fn read_project(path: &Path) -> Result<Project, InputError> {
    read_project_bytes(path, &read_bytes(path)?)
}

/// Reads a project file from bytes; `path` is where it is saved.
///
/// # Errors
/// When the bytes are not a project file of a supported version. Faults in its setups do not keep it from
/// being opened: they are in [`Project::setup_faults`] and [`StoredSet::faults`].
pub fn read_project_bytes(path: &Path, bytes: &[u8]) -> Result<Project, InputError> {
    let name = name_of(path);
    let fault =
        |line: usize, what: String, help: &str| InputError::new(ErrorCode::PlanFile, &name, line, what, help);
    // The version is checked first: a newer file may have keys that this version does not support.
    #[derive(Deserialize)]
    struct Version {
        vanecut_project: u32,
    }
    let source = Source::new(&name, ErrorCode::PlanFile);
    let broken =
        |e: serde_json::Error| source.not_json(&e, "a project file", "open a project file (.vanecut)");
    let version: Version = serde_json::from_slice(bytes).map_err(broken)?;
    check_version(&name, "project", version.vanecut_project, VERSION)?;
    let file: ProjectFile = serde_json::from_slice(bytes).map_err(broken)?;
    if file.sets.len() > MAX_SETS {
        let what = format!("{} sets, more than {MAX_SETS}", file.sets.len());
        return Err(fault(0, what, "remove some").with_code(ErrorCode::FileTooLarge));
    }
    let hash = |key: &str, text: &str| {
        u64::from_str_radix(text, 16)
            .map_err(|_| fault(0, format!("{key} is not a hexadecimal number"), "save the project again"))
    };
    let part_hash = hash("part_hash", &file.part_hash)?;
    let original_hash = file.original_hash.as_deref().map(|text| hash("original_hash", text)).transpose()?;
    // What was faulty before, and what is now.
    let read_setup = |what: &str, text: &str, replaced: Vec<ReplacedFile>| {
        let TolerantSetup { setup, faults } = read_setup_tolerantly(&inside(&name, what), text)?;
        let known = replaced.into_iter().map(ReplacedFile::fault);
        Ok::<_, InputError>((setup, known.chain(faults).collect::<Vec<_>>()))
    };
    let (setup, setup_faults) = read_setup(CURRENT, &file.setup, file.replaced)?;
    let mut sets = Vec::with_capacity(file.sets.len());
    for SetFile { name, setup, figures, replaced } in file.sets {
        let known_count = replaced.len();
        let (setup, faults) = read_setup(&name, &setup, replaced)?;
        // Figures are those of a setup as it was.
        sets.push(StoredSet {
            name,
            setup,
            figures: figures.filter(|_| faults.len() == known_count),
            faults,
        });
    }
    let is_relative = |part: &Path| {
        let first = part.components().next();
        first.is_some_and(|c| matches!(c, Component::Normal(_) | Component::ParentDir | Component::CurDir))
    };
    let part = file.part.with_path(|part| match is_relative(part) {
        true => path.parent().unwrap_or(Path::new("")).join(part),
        false => part.to_owned(),
    });
    Ok(Project {
        part,
        part_hash,
        setup,
        sets,
        viewpoint: file.viewpoint.filter(Viewpoint::is_usable),
        chosen: file.chosen,
        layers: file.layers,
        original: file.original,
        original_hash,
        setup_faults,
    })
}

impl Viewpoint {
    fn is_usable(&self) -> bool {
        let all = [self.yaw, self.pitch, self.distance].into_iter().chain(self.target);
        all.into_iter().all(f32::is_finite) && self.distance > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::axis::Axis;
    use crate::mesh::{LengthUnit, Role};
    use crate::part::Rotation;

    fn project() -> Project {
        let mut setup = Setup::default();
        setup.plunge.step = Some(7.5);
        Project {
            part: PartLocation::File("/parts/wheel.toml".into()),
            part_hash: 0x1234_5678_9abc_def0,
            setup: setup.clone(),
            sets: vec![StoredSet {
                name: "Set 1".to_owned(),
                setup,
                figures: Some(SetFigures {
                    positions: 120,
                    interferential: 0,
                    residual_mean: 0.83,
                    residual_p95: 1.5,
                    uncut_share: 0.01,
                    time: 900.0,
                    wheel_time: Some(15_000.0),
                }),
                faults: Vec::new(),
            }],
            viewpoint: Some(Viewpoint {
                target: [1.0, 2.0, 3.0],
                yaw: 0.5,
                pitch: 0.25,
                distance: 400.0,
                parallel: true,
            }),
            chosen: PlanSelection {
                before: true,
                position: Some(16),
                cut: Some(12),
                channels: 3,
                channels_cut: Some(29),
                channel: 1,
                flank: true,
            },
            layers: Some(serde_json::json!({ "hub": true })),
            original: None,
            original_hash: None,
            setup_faults: Vec::new(),
        }
    }

    #[test]
    fn a_project_comes_back_as_it_was_written() {
        let choices = MeshOptions {
            roles: vec![("Body 3".to_owned(), Role::Hub), ("#7".to_owned(), Role::Ignored)],
            unit: Some(LengthUnit::Inch),
            axis: Some(Axis::Y),
            blades: Some(9),
            rotation: Some(Rotation::Clockwise),
        };
        for place in [
            PartLocation::File("/parts/wheel.toml".into()),
            PartLocation::Sample("pump6".to_owned()),
            PartLocation::Mesh { file: "/parts/tuning/wheel.glb".into(), choices },
            PartLocation::Mesh { file: "/parts/wheel.glb".into(), choices: MeshOptions::default() },
        ] {
            let project = Project { part: place, ..project() };
            let path = Path::new("/parts/tuning/wheel.vanecut");
            let text = write_project(&project, path);
            assert_eq!(read_project_bytes(path, text.as_bytes()), Ok(project));
        }
    }

    #[test]
    fn a_project_of_the_first_version_still_opens() {
        let path = Path::new("/parts/wheel.vanecut");
        let text = write_project(&project(), path);
        let from = text.find(",\n  \"chosen\"").expect("it is written last");
        let first = format!("{}\n}}\n", &text[..from]).replace("project\": 3", "project\": 1");
        let read = read_project_bytes(path, first.as_bytes()).expect("reads");
        assert_eq!(read, Project { chosen: PlanSelection::default(), layers: None, ..project() });
    }

    #[test]
    fn a_part_beside_the_project_moves_with_it() {
        let text = write_project(&project(), Path::new("/parts/wheel.vanecut"));
        assert!(text.contains("\"wheel.toml\""), "{text}");
        let moved =
            read_project_bytes(Path::new("/elsewhere/wheel.vanecut"), text.as_bytes()).expect("reads");
        assert_eq!(moved.part, PartLocation::File("/elsewhere/wheel.toml".into()));
    }

    #[test]
    fn bad_files_are_named_with_what_to_do() {
        let path = Path::new("p.vanecut");
        let text = write_project(&project(), path);
        for (bytes, word) in [
            (String::new(), "not a project file"),
            ("{\"vanecut_project\": 1}".to_owned(), "not a project file"),
            (text.replace("\"vanecut_project\": 5", "\"vanecut_project\": 99"), "newer vanecut"),
            (text.replacen("version = 2", "version = 77", 1), "newer vanecut"),
            (text.replace("123456789abcdef0", "xyz"), "hexadecimal"),
        ] {
            let error = read_project_bytes(path, bytes.as_bytes()).expect_err("is refused").to_string();
            assert!(error.starts_with("p.vanecut") && error.contains(word), "{error}");
        }
        let cut_off = read_project_bytes(path, &text.as_bytes()[..text.len() / 2]).expect_err("is refused");
        assert_eq!(cut_off.code, ErrorCode::FileCutOff, "{cut_off}");
    }

    #[test]
    fn a_faulty_setup_opens_with_its_faults() {
        let path = Path::new("p.vanecut");
        let text = write_project(&project(), path).replace("step = 7.5", "step = -7.5");
        let read = read_project_bytes(path, text.as_bytes()).expect("opens");
        let place = |faults: &[SetupEntryFault]| faults.iter().map(|f| f.error.place()).collect::<Vec<_>>();
        let named = [place(&read.setup_faults), place(&read.sets[0].faults)].concat();
        assert_eq!((read.setup.plunge.step, read.sets[0].setup.plunge.step), (None, None));
        assert_eq!(read.sets[0].figures, None, "they are those of another setup");
        assert!(named.len() == 2 && named[0].starts_with("p.vanecut (setup):"), "{named:?}");
        assert!(named[1].starts_with("p.vanecut (Set 1):"), "{named:?}");
        let key = |faults: &[SetupEntryFault]| faults[0].entry.as_ref().and_then(|entry| entry.key.clone());
        assert_eq!(
            (key(&read.setup_faults), key(&read.sets[0].faults)),
            (Some("step".into()), Some("step".into()))
        );
        let mut saved = Project { setup_faults: Vec::new(), ..read.clone() };
        saved.sets[0].faults.clear();
        let again = read_project_bytes(path, write_project(&saved, path).as_bytes()).expect("opens");
        assert!(
            again.setup_faults.is_empty() && again.sets[0].faults.is_empty() && again.setup == read.setup,
            "saved, it has no faults"
        );
        let again = read_project_bytes(path, write_project(&read, path).as_bytes()).expect("reads");
        assert_eq!(again, read, "the file keeps what was faulty");
    }
}
