//! Reading and writing files for the window, on the background threads.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::ErrorCode;
use crate::gpu::encode_png;
use crate::io::InputError;
use crate::io::gltf::{CutterNodes, GltfScene, PlanScene};
use crate::io::hash::{FNV_START, fnv1a};
use crate::io::part_file::{check_part_format, read_part, read_part_bytes, read_part_with};
use crate::io::part_hash::PartHash;
use crate::io::plan_inputs::{is_plan_file, read_plan_inputs};
use crate::io::project_file::EXTENSION;
use crate::io::setup_file::{looks_like_setup, write_setup_beside};
use crate::io::shop_tools::{LibraryTool, ToolLibrary, check_replaced_library, fusion_for, write_toml};
use crate::io::source::read_bytes;
use crate::io::write::{write_all_atomically, write_atomically};
use crate::job::assess::AssessedPart;
use crate::mesh::tessellate::{Fineness, Tessellation};
use crate::monitor::Monitor;
use crate::palette::ColourMap;
use crate::part::{Impeller, PartDescription};
use crate::report::ReportPage;
use crate::report::sheet::ProgramFile;
use crate::setup::{AxisPolicy, Setup};
use crate::verify::Fault;

use crate::app::model::document::Edited;
use crate::app::model::exported::ProgramPlan;
use crate::app::model::file_purpose::{FilePlace, PROGRAM_ENDINGS, Purpose};
use crate::app::model::library_state::LibraryState;
use crate::app::model::part_source::{PartSource, Sample};
use crate::app::model::planned::DisplayPlan;
use crate::app::model::solid::{SolidSource, StockMoment};
use crate::app::tasks::documents::{SheetTask, assessment, sheet};
use crate::app::tasks::programs::{
    FlankSource, NcTask, PlungeSource, ProgramSource, UnwrittenProgram, flank_text, nc_text, plunge_text,
};
use crate::app::tasks::solid::solid_bytes;

/// Name, description and file text of a sample part.
type Built = (&'static str, &'static str, &'static str);

/// The sample parts, compiled into the program.
const BUILT_IN: [Built; 3] = [
    (
        "impeller532",
        "17 blades, D 532 mm, outlet height 32 mm",
        include_str!("../../../assets/parts/impeller532.toml"),
    ),
    (
        "impeller9x9",
        "D 300 mm, 9 blades and 9 splitters",
        include_str!("../../../assets/parts/impeller9x9.toml"),
    ),
    (
        "pump6",
        "pump impeller, D 240 mm, 6 strongly wrapped blades",
        include_str!("../../../assets/parts/pump6.toml"),
    ),
];

/// The built-in sample parts.
pub fn samples() -> Vec<Sample> {
    BUILT_IN.iter().map(|&(name, about, _)| Sample { name, about }).collect()
}

/// Reads, trims and checks a part; returns it with the hashes of its description.
///
/// # Errors
/// [`InputError`] when the file cannot be read, the sample does not exist, or the part is invalid.
pub fn open_part(source: &PartSource) -> Result<(Arc<Impeller>, PartHash), InputError> {
    let (file, description) = match source {
        PartSource::File(path) if is_plan_file(path) => {
            (path.display().to_string(), read_plan_inputs(path)?.description)
        }
        PartSource::File(path) => (path.display().to_string(), read_part(path)?),
        PartSource::Mesh(path, options) => (path.display().to_string(), read_part_with(path, options)?),
        PartSource::Sample(name) => {
            let file = format!("{name}.toml");
            let Some((_, _, text)) = BUILT_IN.iter().find(|(known, ..)| known == name) else {
                let help = "choose one from the list";
                return Err(InputError::new(ErrorCode::UnknownName, &file, 0, "is not a sample part", help));
            };
            let description = read_part_bytes(&file, text.as_bytes(), "toml")?;
            (file, description)
        }
    };
    build_part(&file, &description)
}

/// Trims and checks the part of a file; returns it with the hashes of its description.
///
/// # Errors
/// [`InputError`] when the part is invalid.
pub fn build_part(
    file: &str,
    description: &PartDescription,
) -> Result<(Arc<Impeller>, PartHash), InputError> {
    let impeller = Impeller::build(description).map_err(|error| InputError::of_part(file, error))?;
    Ok((Arc::new(impeller), PartHash::from_part(description)))
}

/// Whether a file is a setup rather than a part: both may be TOML, but only a setup has one of these tables.
pub fn is_setup(path: &Path) -> bool {
    let toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    if !toml || std::fs::metadata(path).is_ok_and(|data| data.len() > LARGEST_SETUP) {
        return false;
    }
    let Ok(bytes) = read_bytes(path) else { return false };
    looks_like_setup(&bytes)
}

/// Maximum size of a file that is checked for setup tables, bytes: parsing a large part would block the UI
/// thread.
const LARGEST_SETUP: u64 = 256 * 1024;

/// Whether a file is a program, by its ending.
pub fn is_program(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| PROGRAM_ENDINGS.contains(&extension.as_str()))
}

/// Whether a path is that of a study's results: its table, its folder, or the list in that.
pub fn is_study(path: &Path) -> bool {
    let is_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    is_table || path.file_name().is_some_and(|name| name == "study.json") || path.join("study.json").is_file()
}

/// Whether a file is a project.
pub fn is_project(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

/// Where a file lies that is opened, by its kind.
pub fn place_of(path: &Path) -> FilePlace {
    if is_study(path) || is_program(path) {
        FilePlace::Work
    } else if is_setup(path) {
        FilePlace::Setups
    } else {
        FilePlace::Part
    }
}

/// Whether opening a file closes the project: all but setups, programs and results of studies do.
pub fn closes_project(path: &Path) -> bool {
    place_of(path) == FilePlace::Part
}

/// What the window opens.
const CAN_OPEN: &str = "open a part (.toml, .geomTurbo, .inf of TurboGrid, .step, .stl, .glb or .gltf), a project \
     (.vanecut), a setup (.toml), a plan.json or flank.json, a program (.apt, .nc, .mpf, .h or the like), or results of \
     a study (.csv or their folder)";

/// Checks that a file is of a kind that the window opens, without reading all of it.
///
/// # Errors
/// When it is a folder, or has another extension.
pub fn check_openable(path: &Path) -> Result<(), InputError> {
    let fault = |what: String| {
        let name = path.display().to_string();
        Err(InputError::new(ErrorCode::FileFormat, &name, 0, what, CAN_OPEN))
    };
    if is_study(path) || is_program(path) || is_project(path) || is_plan_file(path) {
        return Ok(());
    }
    if path.is_dir() {
        return fault("this is a folder".to_owned());
    }
    match check_part_format(path) {
        Ok(()) => Ok(()),
        Err(error) => fault(error.message),
    }
}

/// Result of a write task.
pub struct Written {
    /// What it is for.
    pub purpose: Purpose,
    /// Its file, the first where there are several.
    pub file: PathBuf,
    /// Message for the status bar.
    pub text: String,
    /// A project that was written; `None` for other files.
    pub project: Option<WrittenProject>,
    /// A tool library that was written; `None` for other files.
    pub library: Option<WrittenLibrary>,
    /// What plan a program is of, and its file; `None` for other files.
    pub program: Option<(ProgramPlan, ProgramFile)>,
}

/// A tool library that was written.
pub struct WrittenLibrary {
    /// As it was to be written.
    pub given: LibraryState,
    /// As it was written: some tools may have got other numbers.
    pub written: LibraryState,
}

/// A project that was written.
pub struct WrittenProject {
    /// Its file.
    pub path: PathBuf,
    /// What it stores.
    pub edited: Edited,
    /// Hash of the file; see [`content_hash`].
    pub hash: u64,
}

/// A project to be written.
pub struct ProjectTask {
    /// Its file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// What that stores.
    pub edited: Edited,
    /// Hash of the file as this window read or wrote it last: a file with other content stays as it is.
    /// `None`: it is replaced whatever it holds.
    pub known: Option<u64>,
}

impl ProjectTask {
    /// Whether another window or program has written the file since this window knows it. A file that is gone
    /// is not: writing loses nothing.
    fn is_changed_on_disk(&self) -> bool {
        let Some(known) = self.known else { return false };
        read_bytes(&self.path).is_ok_and(|now| content_hash(&now) != known && now != self.text.as_bytes())
    }
}

/// A file that was not written.
#[derive(Debug)]
pub struct Unwritten {
    /// What it is for.
    pub purpose: Purpose,
    /// Why.
    pub error: WriteError,
}

/// Why a file was not written.
#[derive(Debug)]
pub enum WriteError {
    /// The project's file was written by another window or program; see [`ProjectTask::known`].
    ChangedOnDisk(PathBuf),
    /// It cannot be written.
    Failed(InputError),
    /// A program of several channels has faults, which are asked about first.
    Faulty {
        /// The file.
        path: PathBuf,
        /// The faults.
        faults: Vec<Fault>,
    },
    /// The program was cancelled while it was judged.
    Cancelled,
}

impl WriteError {
    /// Of a program for the file `path`.
    fn of_program(unwritten: UnwrittenProgram, path: &Path) -> Self {
        match unwritten {
            UnwrittenProgram::Cancelled => Self::Cancelled,
            UnwrittenProgram::Faulty(faults) => Self::Faulty { path: path.to_owned(), faults },
            UnwrittenProgram::Failed(error) => Self::from(error),
        }
    }
}

impl From<InputError> for WriteError {
    fn from(error: InputError) -> Self {
        Self::Failed(error)
    }
}

/// Hash by which the content of a file is known again.
pub fn content_hash(bytes: &[u8]) -> u64 {
    fnv1a(FNV_START, bytes.iter().copied())
}

/// Content of a glTF scene.
pub struct SceneTask {
    /// The part.
    pub part: Arc<Impeller>,
    /// The plan and its shown policy.
    pub planned: Option<(Arc<DisplayPlan>, AxisPolicy)>,
    /// Ends of the colour scale of the stock, mm.
    pub range: (f32, f32),
}

/// A file to write, with its path.
pub enum WriteTask {
    /// A project.
    Project(Box<ProjectTask>),
    /// The setup.
    Setup(PathBuf, Box<Setup>),
    /// A tool library, as our TOML or as Fusion JSON by extension.
    Library(PathBuf, LibraryState),
    /// A plunge program as APT.
    Cl(PathBuf, PlungeSource),
    /// A program as NC code.
    Nc(PathBuf, NcTask),
    /// The flank plan as APT.
    Flank(PathBuf, FlankSource),
    /// A glTF scene.
    Scene(PathBuf, SceneTask),
    /// The stock as a solid at a moment. STL or glTF by extension.
    Stock(PathBuf, SolidSource, StockMoment),
    /// A setup sheet, with its pictures.
    Sheet(PathBuf, SheetTask),
    /// The page of an assessment, with its pictures.
    Assessment(PathBuf, Arc<AssessedPart>),
    /// A picture: width, height, RGBA.
    Picture(PathBuf, u32, u32, Vec<u8>),
}

impl WriteTask {
    /// What its file is for.
    pub fn purpose(&self) -> Purpose {
        match self {
            Self::Project(_) => Purpose::SaveProject,
            Self::Setup(..) => Purpose::SaveSetup,
            Self::Library(..) => Purpose::SaveLibrary,
            Self::Cl(_, source) => Purpose::ExportCl { channels: source.channels },
            Self::Nc(_, NcTask { source, target }) => {
                Purpose::ExportNc { operation: source.operation(), dialect: target.dialect }
            }
            Self::Flank(_, source) => Purpose::ExportFlank { channels: source.channels },
            Self::Scene(..) => Purpose::ExportScene { side: None },
            Self::Stock(..) => Purpose::ExportStock { side: None },
            Self::Sheet(_, task) => Purpose::ExportSheet { operation: task.source.operation() },
            Self::Assessment(..) => Purpose::SaveAssessment,
            Self::Picture(..) => Purpose::SavePicture,
        }
    }

    /// Whether its program is checked first, which can be cancelled: that of a flank plan in several
    /// channels, which takes as long as to plan it, one with shanks or holders, and that of a setup sheet.
    /// Everything else takes a moment.
    pub fn is_checked_first(&self) -> bool {
        match self {
            Self::Cl(_, source) => source.is_judged(),
            Self::Nc(_, NcTask { source: ProgramSource::Plunges(source), .. }) => source.is_judged(),
            Self::Flank(_, source) => source.channels > 1,
            Self::Nc(_, NcTask { source: ProgramSource::Flank(source), .. }) => source.channels > 1,
            Self::Sheet(_, SheetTask { source: ProgramSource::Flank(source), .. }) => source.channels > 1,
            Self::Sheet(_, SheetTask { source: ProgramSource::Plunges(_), .. }) => true,
            _ => false,
        }
    }
}

/// Writes a file atomically.
///
/// # Errors
/// [`Unwritten`] when the file cannot be made or written, is a project that was changed on disk, or a
/// program that is asked about first; when `monitor` is cancelled.
pub fn write(task: &WriteTask, monitor: &Monitor) -> Result<Written, Unwritten> {
    let purpose = task.purpose();
    write_file(task, purpose, monitor).map_err(|error| Unwritten { purpose, error })
}

fn write_file(task: &WriteTask, purpose: Purpose, monitor: &Monitor) -> Result<Written, WriteError> {
    // What the message says beside the path.
    let mut about = String::new();
    let (mut program, mut saved_library) = (None, None);
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (path, bytes) = match task {
        WriteTask::Project(project) if project.is_changed_on_disk() => {
            return Err(WriteError::ChangedOnDisk(project.path.clone()));
        }
        WriteTask::Project(project) => (&project.path, project.text.clone().into_bytes()),
        WriteTask::Setup(path, setup) => (path, write_setup_beside(setup, path).into_bytes()),
        WriteTask::Library(path, library) => {
            let is_fusion = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
            let given = library.clone();
            let (text, written) = if is_fusion {
                let merged = fusion_for(path, library)?;
                about = moved_words(library, &merged.library);
                let is_as_given = merged.library == **library;
                (merged.text, if is_as_given { given.clone() } else { merged.library.into() })
            } else {
                check_replaced_library(path)?;
                (write_toml(library), given.clone())
            };
            saved_library = Some(WrittenLibrary { given, written });
            (path, text.into_bytes())
        }
        WriteTask::Cl(path, source) => {
            let text =
                plunge_text(source, monitor).map_err(|unwritten| WriteError::of_program(unwritten, path))?;
            program = Some((source.plan(), ProgramFile::apt(name(path))));
            (path, text.into_bytes())
        }
        WriteTask::Nc(path, content) => {
            let written = nc_text(path, content, monitor)
                .map_err(|unwritten| WriteError::of_program(unwritten, path))?;
            about = written.about;
            program = Some((content.source.plan(), written.file));
            (path, written.text.into_bytes())
        }
        WriteTask::Flank(path, source) => {
            let (text, words) =
                flank_text(source, monitor).map_err(|unwritten| WriteError::of_program(unwritten, path))?;
            about = words;
            program = Some((source.plan(), ProgramFile::apt(name(path))));
            (path, text.into_bytes())
        }
        WriteTask::Scene(path, scene) => (path, scene_bytes(scene)),
        WriteTask::Stock(path, source, moment) => (path, stock_bytes(path, source, *moment)?),
        WriteTask::Sheet(path, task) => {
            let page =
                sheet(path, task, monitor).map_err(|unwritten| WriteError::of_program(unwritten, path))?;
            return Ok(write_document(path, purpose, &page)?);
        }
        WriteTask::Assessment(path, assessed) => {
            return Ok(write_document(path, purpose, &assessment(path, assessed)?)?);
        }
        WriteTask::Picture(path, width, height, rgba) => {
            let png = encode_png(*width, *height, rgba).map_err(|error| {
                let (file, help) = (path.display().to_string(), "resize the window and try again");
                InputError::new(ErrorCode::Picture, &file, 0, error.to_string(), help)
            })?;
            (path, png)
        }
    };
    write_atomically(path, &bytes)?;
    let project = match task {
        WriteTask::Project(project) => Some(WrittenProject {
            path: project.path.clone(),
            edited: project.edited.clone(),
            hash: content_hash(&bytes),
        }),
        _ => None,
    };
    Ok(Written {
        purpose,
        file: path.clone(),
        text: format!("Wrote {}{about}", path.display()),
        project,
        library: saved_library,
        program,
    })
}

/// What numbers tools of a library have got in the file it was written to, where those that they had are
/// taken there; empty where all keep theirs.
fn moved_words(given: &ToolLibrary, written: &ToolLibrary) -> String {
    let numbers = |(given, written): (&Arc<LibraryTool>, &Arc<LibraryTool>)| {
        (given.tool.number != written.tool.number).then_some((given.tool.number, written.tool.number))
    };
    let moved: Vec<(u32, u32)> = given.tools.iter().zip(&written.tools).filter_map(numbers).collect();
    match moved[..] {
        [] => String::new(),
        [(was, is)] => format!("; T{was} is T{is} in the file: its number was taken"),
        [.., (_, last)] => {
            format!("; {} tools have new numbers in the file, up to T{last}: theirs were taken", moved.len())
        }
    }
}

fn write_document(path: &Path, purpose: Purpose, document: &ReportPage) -> Result<Written, InputError> {
    write_all_atomically(&document.files_at(path))?;
    Ok(Written {
        purpose,
        file: path.to_owned(),
        text: format!("Wrote {} and its pictures, in mm", path.display()),
        project: None,
        library: None,
        program: None,
    })
}

fn scene_bytes(scene: &SceneTask) -> Vec<u8> {
    let shape = Tessellation::new(&scene.part, &Fineness::default());
    let Some((planned, policy)) = &scene.planned else {
        return GltfScene::of_part(&scene.part, &shape).glb();
    };
    let result = planned.result(*policy);
    let shown = PlanScene {
        part: &scene.part,
        shape: &shape,
        setup: &planned.outcome.setup,
        plan: &result.plan,
        grid: &planned.outcome.grid,
        heights: &result.field.heights,
        range: scene.range,
        map: ColourMap::default(),
        cutters: CutterNodes::default(),
    };
    GltfScene::of_plan(&shown).glb()
}

fn stock_bytes(path: &Path, source: &SolidSource, moment: StockMoment) -> Result<Vec<u8>, InputError> {
    let fault = |code: ErrorCode, message: String, help: &str| {
        InputError::new(code, &path.display().to_string(), 0, message, help)
    };
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let is_scene = match extension.as_str() {
        "stl" => false,
        "glb" => true,
        _ => {
            let what = "is not a format of solids".to_owned();
            return Err(fault(ErrorCode::FileFormat, what, "give a .stl or .glb file"));
        }
    };
    solid_bytes(source, moment, is_scene)
        .map_err(|message| fault(ErrorCode::StockSpacing, message, "recalculate and try again"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_opens_under_its_own_name() {
        for sample in samples() {
            let (part, _) = open_part(&PartSource::Sample(sample.name.to_owned())).expect("a sample opens");
            assert_eq!(part.name, sample.name, "the list and the file agree");
        }
    }
}
