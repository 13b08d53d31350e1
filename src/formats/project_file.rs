//! The project file: which part, its setup, the sets kept to compare, and where it was looked at from. JSON, so that
//! it reads in an editor; setups stand in it as the text of setup files.
//!
//! The part itself stays where it is: the file names it, relative to itself where it can, and holds a hash of what
//! it described, so that a part that changed since is noticed.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::InputError;
use super::native::write_native;
use super::setup_file::write_setup;
use super::source::{name_of, read_bytes};
use super::stored::{check_version, setup_within};
use crate::mesh::MeshOptions;
use crate::part::{PartDescription, Setup};

/// Version of the file; readers refuse newer ones.
pub const VERSION: u32 = 2;
/// Ending of project files.
pub const EXTENSION: &str = "vanecut";
/// Most sets a project may hold.
const MAX_SETS: usize = 1000;

/// Where the part of a project is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartPlace {
    /// A file.
    File(PathBuf),
    /// A mesh file, with what the user said about it.
    Mesh {
        /// The file.
        file: PathBuf,
        /// Roles, unit, axis and what else was chosen.
        choices: MeshOptions,
    },
    /// A sample that comes with the program.
    Sample(String),
}

impl PartPlace {
    /// The same with another path of the file.
    fn moved(&self, to: impl FnOnce(&Path) -> PathBuf) -> Self {
        match self {
            Self::File(file) => Self::File(to(file)),
            Self::Mesh { file, choices } => Self::Mesh { file: to(file), choices: choices.clone() },
            Self::Sample(name) => Self::Sample(name.clone()),
        }
    }
}

/// Where the part is looked at from; lengths mm, angles rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Viewpoint {
    /// Point in the middle of the picture.
    pub target: [f32; 3],
    /// Angle about the axis of rotation.
    pub yaw: f32,
    /// Angle above the horizon.
    pub pitch: f32,
    /// Distance from the target.
    pub distance: f32,
    /// Whether the rays are parallel.
    pub parallel: bool,
}

/// What was chosen of the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chosen {
    /// Whether the conventional plan was shown.
    #[serde(default)]
    pub before: bool,
    /// Position, counted from 0 in cutting order.
    #[serde(default)]
    pub position: Option<usize>,
    /// Number of positions that were cut; `None`: all.
    #[serde(default)]
    pub cut: Option<usize>,
}

/// What sets are compared by: what a setup came to when it was planned. Lengths mm, time s, share 0…1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Number of plunges.
    pub positions: usize,
    /// Plunges whose core meets stock.
    pub interferential: usize,
    /// Mean stock left on the hub.
    pub residual_mean: f64,
    /// Its 95th percentile.
    pub residual_p95: f64,
    /// Share of the reachable floor that no plunge reaches.
    pub uncut_share: f64,
    /// Estimate for one channel.
    pub time: f64,
}

/// A set that was kept to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredSet {
    /// Its name.
    pub name: String,
    /// The setup.
    pub setup: Setup,
    /// What it came to, if it was planned.
    pub figures: Option<Figures>,
}

/// A project.
#[derive(Clone, Debug, PartialEq)]
pub struct Project {
    /// Where the part is. In a file read back, relative places are resolved against the file's folder.
    pub part: PartPlace,
    /// [`part_hash`] of what it described.
    pub part_hash: u64,
    /// The setup in work.
    pub setup: Setup,
    /// Sets that were kept.
    pub sets: Vec<StoredSet>,
    /// Where it was looked at from.
    pub viewpoint: Option<Viewpoint>,
    /// What was chosen of the plan.
    pub chosen: Chosen,
    /// File the project itself belongs to, in copies that were saved by themselves.
    pub original: Option<PathBuf>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProjectFile {
    vanecut_project: u32,
    part: PartPlace,
    part_hash: String,
    setup: String,
    #[serde(default)]
    sets: Vec<SetFile>,
    #[serde(default)]
    viewpoint: Option<Viewpoint>,
    #[serde(default)]
    chosen: Chosen,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    original: Option<PathBuf>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SetFile {
    name: String,
    setup: String,
    #[serde(default)]
    figures: Option<Figures>,
}

/// Hash of what a part file describes, the same for every file that describes the same part.
pub fn part_hash(part: &PartDescription) -> u64 {
    // FNV-1a: small, and the same on every machine and in every version.
    let start = 0xcbf2_9ce4_8422_2325u64;
    write_native(part)
        .bytes()
        .fold(start, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Text of a project file that is to stand at `path`: the part is named relative to it where it lies in the same
/// folder or below.
pub fn write_project(project: &Project, path: &Path) -> String {
    let part = project.part.moved(|part| relative(part, path));
    let file = ProjectFile {
        vanecut_project: VERSION,
        part,
        part_hash: format!("{:016x}", project.part_hash),
        setup: write_setup(&project.setup),
        sets: project
            .sets
            .iter()
            .map(|set| SetFile {
                name: set.name.clone(),
                setup: write_setup(&set.setup),
                // JSON has no NaN; figures without a value are as good as none.
                figures: set.figures.filter(|f| f.residual_mean.is_finite() && f.residual_p95.is_finite()),
            })
            .collect(),
        viewpoint: project.viewpoint,
        chosen: project.chosen,
        original: project.original.clone(),
    };
    let mut text = serde_json::to_string_pretty(&file).unwrap_or_default();
    text.push('\n');
    text
}

fn relative(part: &Path, path: &Path) -> PathBuf {
    let folder = |path: &Path| std::path::absolute(path).ok();
    let (Some(whole), Some(own)) = (folder(part), folder(path)) else { return part.to_owned() };
    let beside = own.parent().and_then(|folder| whole.strip_prefix(folder).ok().map(Path::to_owned));
    beside.unwrap_or(whole)
}

/// Reads a project file.
///
/// # Errors
/// As [`read_project_bytes`], or when the file cannot be read.
pub fn read_project(path: &Path) -> Result<Project, InputError> {
    read_project_bytes(path, &read_bytes(path)?)
}

/// Reads a project file that stands at `path`.
///
/// # Errors
/// What is wrong and where, when the bytes are no project of a known version.
pub fn read_project_bytes(path: &Path, bytes: &[u8]) -> Result<Project, InputError> {
    let name = name_of(path);
    let fault = |line: usize, what: String, cure: &str| InputError::new(&name, line, what, cure);
    // The version first: a newer file may hold what this program does not know.
    #[derive(Deserialize)]
    struct Version {
        vanecut_project: u32,
    }
    let broken = |e: serde_json::Error| {
        fault(e.line(), format!("this is no project file ({e})"), "open a file that was saved as a project")
    };
    let version: Version = serde_json::from_slice(bytes).map_err(broken)?;
    check_version(&name, "project", version.vanecut_project, VERSION)?;
    let file: ProjectFile = serde_json::from_slice(bytes).map_err(broken)?;
    if file.sets.len() > MAX_SETS {
        let what = format!("{} sets are more than {MAX_SETS}", file.sets.len());
        return Err(fault(0, what, "take some out"));
    }
    let part_hash = u64::from_str_radix(&file.part_hash, 16)
        .map_err(|_| fault(0, "part_hash is no hexadecimal number".to_owned(), "save the project again"))?;
    let setup = |what: &str, text: &str| setup_within(&name, what, text);
    let sets = file.sets.iter().map(|set| {
        Ok(StoredSet { name: set.name.clone(), setup: setup(&set.name, &set.setup)?, figures: set.figures })
    });
    let is_relative = |part: &Path| {
        let first = part.components().next();
        first.is_some_and(|c| matches!(c, Component::Normal(_) | Component::ParentDir | Component::CurDir))
    };
    let part = file.part.moved(|part| match is_relative(part) {
        true => path.parent().unwrap_or(Path::new("")).join(part),
        false => part.to_owned(),
    });
    Ok(Project {
        part,
        part_hash,
        setup: setup("setup", &file.setup)?,
        sets: sets.collect::<Result<_, InputError>>()?,
        viewpoint: file.viewpoint.filter(Viewpoint::is_usable),
        chosen: file.chosen,
        original: file.original,
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
    use crate::mesh::{Role, Unit};
    use crate::part::Rotation;

    fn project() -> Project {
        let mut setup = Setup::default();
        setup.plunge.step = Some(7.5);
        Project {
            part: PartPlace::File("/parts/wheel.toml".into()),
            part_hash: 0x1234_5678_9abc_def0,
            setup: setup.clone(),
            sets: vec![StoredSet {
                name: "Set 1".to_owned(),
                setup,
                figures: Some(Figures {
                    positions: 120,
                    interferential: 0,
                    residual_mean: 0.83,
                    residual_p95: 1.5,
                    uncut_share: 0.01,
                    time: 900.0,
                }),
            }],
            viewpoint: Some(Viewpoint {
                target: [1.0, 2.0, 3.0],
                yaw: 0.5,
                pitch: 0.25,
                distance: 400.0,
                parallel: true,
            }),
            chosen: Chosen { before: true, position: Some(16), cut: None },
            original: None,
        }
    }

    #[test]
    fn a_project_comes_back_as_it_was_written() {
        let choices = MeshOptions {
            roles: vec![("Body 3".to_owned(), Role::Hub), ("#7".to_owned(), Role::Ignored)],
            unit: Some(Unit::Inch),
            axis: Some(Axis::Y),
            blades: Some(9),
            rotation: Some(Rotation::Clockwise),
        };
        for place in [
            PartPlace::File("/parts/wheel.toml".into()),
            PartPlace::Sample("pump6".to_owned()),
            PartPlace::Mesh { file: "/parts/tuning/wheel.glb".into(), choices },
            PartPlace::Mesh { file: "/parts/wheel.glb".into(), choices: MeshOptions::default() },
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
        let first = format!("{}\n}}\n", &text[..from]).replace("project\": 2", "project\": 1");
        let read = read_project_bytes(path, first.as_bytes()).expect("reads");
        assert_eq!(read, Project { chosen: Chosen::default(), ..project() });
    }

    #[test]
    fn a_part_beside_the_project_moves_with_it() {
        let text = write_project(&project(), Path::new("/parts/wheel.vanecut"));
        assert!(text.contains("\"wheel.toml\""), "{text}");
        let moved =
            read_project_bytes(Path::new("/elsewhere/wheel.vanecut"), text.as_bytes()).expect("reads");
        assert_eq!(moved.part, PartPlace::File("/elsewhere/wheel.toml".into()));
    }

    #[test]
    fn bad_files_are_named_with_what_to_do() {
        let path = Path::new("p.vanecut");
        let text = write_project(&project(), path);
        for (bytes, word) in [
            (String::new(), "no project file"),
            ("{\"vanecut_project\": 1}".to_owned(), "no project file"),
            (text.replace("\"vanecut_project\": 2", "\"vanecut_project\": 99"), "newer vanecut"),
            (text.replace("step = 7.5", "stepp = 7.5"), "step"),
            (text.replace("123456789abcdef0", "xyz"), "hexadecimal"),
        ] {
            let error = read_project_bytes(path, bytes.as_bytes()).expect_err("is refused").to_string();
            assert!(error.starts_with("p.vanecut") && error.contains(word), "{error}");
        }
    }

    #[test]
    fn the_hash_tells_parts_apart() {
        let read =
            |text: &str| crate::formats::read_part_bytes("p.toml", text.as_bytes(), "toml").expect("reads");
        let text = include_str!("../../assets/parts/pump6.toml");
        let (a, b) = (read(text), read(&format!("# a remark\n{text}")));
        assert_eq!(part_hash(&a), part_hash(&b), "remarks do not count");
        let mut other = a.clone();
        other.blade_count += 1;
        assert_ne!(part_hash(&a), part_hash(&other));
    }
}
