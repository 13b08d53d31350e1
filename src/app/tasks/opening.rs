//! Opening of projects, parts, setups and blanks, on the background thread.

use std::path::{Path, PathBuf};

use super::engine::Engine;
use super::files::{build_part, content_hash};
use super::mesh_nodes::UnassignedRoles;
use super::open_task::OpenTask;
use super::part_meshes::PartMeshes;
use super::project::source_of;
use crate::app::model::document::OpenPart;
use crate::app::model::part_source::PartSource;
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::blank_file::read_blank_file;
use crate::io::machine_file::{is_built_in, read_machine};
use crate::io::part_hash::PartHash;
use crate::io::plan_inputs::{is_plan_file, read_plan_inputs};
use crate::io::project_file::{Project, read_project_bytes};
use crate::io::setup_file::{locate_machine, read_setup, read_setup_bytes};
use crate::io::shop_tools::{LibraryFormat, ToolLibrary, read_library};
use crate::io::source::read_bytes;
use crate::machine::MachineTool;
use crate::monitor::Monitor;
use crate::part::BlankFile;
use crate::setup::Setup;
use crate::study::StudyResults;

/// Result of an opening task.
#[derive(Default)]
pub(in crate::app) struct Opened {
    pub part: Option<(OpenPart, PartMeshes)>,
    pub setup: Option<(PathBuf, Setup)>,
    pub project: Option<(PathBuf, Project)>,
    /// Hash of the project's file, of a recovery copy that of the project that it is of.
    pub on_disk: Option<u64>,
    pub blank: Option<BlankFile>,
    /// A machine file, and its machine or why it is none.
    pub machine: Option<(PathBuf, Result<MachineTool, InputError>)>,
    pub library: Option<(PathBuf, ToolLibrary)>,
    pub study: Option<StudyResults>,
    /// Whether the setup is to be planned even where edits are not.
    pub is_run: bool,
    /// Whether it is a flank plan, so that flank milling is planned, too.
    pub is_flank_plan: bool,
    /// The part's file, if it is not what the run was planned with.
    pub changed_part: Option<PathBuf>,
    /// A project that is not opened yet, as its part is to be located.
    pub missing_part: Option<MissingPart>,
    /// A mesh file whose nodes need roles first.
    pub unassigned: Option<UnassignedRoles>,
}

/// A project whose part's file does not exist.
pub(in crate::app) struct MissingPart {
    /// Its file, or a recovery copy.
    pub project: PathBuf,
    /// Its file name, of a copy that of the project that it is of.
    pub name: String,
    /// The part as it was.
    pub source: PartSource,
}

/// Runs an opening task. A mesh file that is not a valid part is returned with its nodes and the error.
///
/// # Errors
/// [`InputError`] when a file cannot be read or is invalid.
pub(in crate::app) fn open(
    engine: &Engine,
    task: &OpenTask,
    monitor: &Monitor,
) -> Result<Opened, InputError> {
    let mut on_disk = None;
    let (source, setup, project) = match task {
        OpenTask::Project(path, instead) => {
            let bytes = read_bytes(path)?;
            let mut project = read_project_bytes(path, &bytes)?;
            on_disk = match (&project.original, project.original_hash) {
                (None, _) => Some(content_hash(&bytes)),
                // Another window may have saved it before the copy was written, too.
                (Some(_), Some(known)) => Some(known),
                // Saved after the copy was written, it is not what that is of: no project is empty.
                (Some(original), None) if is_newer(original, path) => Some(content_hash(&[])),
                (Some(original), None) => read_bytes(original).ok().map(|bytes| content_hash(&bytes)),
            };
            let sets = project.sets.iter_mut().map(|set| &mut set.setup);
            for setup in std::iter::once(&mut project.setup).chain(sets) {
                // A project opens whatever its machine file is; planning says what is wrong with it.
                let _ = locate_machine(setup, path);
            }
            let source = instead.clone().unwrap_or_else(|| source_of(&project));
            if source.file().is_some_and(|(file, _)| !file.exists()) {
                // A recovery copy is known by the project that it is of.
                let named = project.original.as_ref().unwrap_or(path).file_name().unwrap_or_default();
                let name = named.to_string_lossy().into_owned();
                let missing_part = MissingPart { project: path.clone(), name, source };
                return Ok(Opened { missing_part: Some(missing_part), ..Opened::default() });
            }
            (Some(source), None, Some((path.clone(), project)))
        }
        OpenTask::Files { part, setup, defaults } => {
            (part.clone(), setup.as_ref().map(|path| (path, defaults.as_ref())), None)
        }
        OpenTask::Blank(path) => {
            let path = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            let blank = read_blank_file(&path.display().to_string(), &path)?;
            return Ok(Opened { blank: Some(blank), ..Opened::default() });
        }
        OpenTask::Machine(path) => {
            let path = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            let machine = read_machine(&path);
            return Ok(Opened { machine: Some((path, machine)), ..Opened::default() });
        }
        OpenTask::Library(path) => {
            let library = read_library(path, LibraryFormat::of_path(path)?)?;
            return Ok(Opened { library: Some((path.clone(), library)), ..Opened::default() });
        }
        OpenTask::Study(path) => {
            return Ok(Opened { study: Some(StudyResults::read(path)?), ..Opened::default() });
        }
        OpenTask::Run { results, row, open, keeps_part } => {
            return open_run(engine, results, *row, open.as_ref(), *keeps_part, monitor);
        }
        OpenTask::Nodes { source, roles_by_shape } => {
            let nodes =
                source.mesh().map(|(path, said)| UnassignedRoles::read(path, &said, task.clone(), None));
            let mut unassigned = nodes.transpose()?;
            if let Some(unassigned) = unassigned.as_mut().filter(|_| *roles_by_shape) {
                unassigned.forget_named_roles();
            }
            return Ok(Opened { unassigned, ..Opened::default() });
        }
    };
    // A plan is the part and the setup, and may be long: it is read once.
    let plan = match (&source, setup) {
        (Some(PartSource::File(part)), Some((path, _))) if part == path && is_plan_file(path) => {
            Some(read_plan_inputs(path)?)
        }
        _ => None,
    };
    let read = |defaults: Option<&Setup>| -> Result<Option<(PathBuf, Setup)>, InputError> {
        let Some((path, known)) = setup else { return Ok(None) };
        let of_plan = match &plan {
            Some(plan) => Some(plan.setup.clone()),
            None if is_plan_file(path) => Some(read_plan_inputs(path)?.setup),
            None => None,
        };
        if let Some(mut setup) = of_plan {
            // As in a project: planning says what is wrong with its machine.
            let _ = locate_machine(&mut setup, path);
            return Ok(Some((path.clone(), setup)));
        }
        let mut setup = read_setup(path, defaults.unwrap_or(known))?;
        locate_machine(&mut setup, path)?;
        Ok(Some((path.clone(), setup)))
    };
    let Some(source) = source else {
        return Ok(Opened { setup: read(None)?, project, on_disk, ..Opened::default() });
    };
    let opened = match (&plan, &source) {
        (Some(plan), PartSource::File(path)) => build_part(&path.display().to_string(), &plan.description),
        _ => (engine.open)(&source, monitor),
    };
    match opened {
        Ok((impeller, hash)) => {
            let mesh = PartMeshes::new(&impeller);
            let defaults = Setup::for_part(&impeller);
            let setup = read(Some(&defaults))?;
            let part = Some((OpenPart { source, impeller, defaults, hash }, mesh));
            let is_flank_plan = plan.as_ref().is_some_and(|plan| plan.is_flank);
            Ok(Opened { part, setup, project, on_disk, is_flank_plan, ..Opened::default() })
        }
        Err(error) => {
            let nodes = source
                .mesh()
                .and_then(|(path, said)| UnassignedRoles::read(path, &said, task.clone(), Some(&error)).ok());
            match nodes {
                Some(unassigned) => Ok(Opened { unassigned: Some(unassigned), ..Opened::default() }),
                // Roles cannot solve this error.
                None => Err(error),
            }
        }
    }
}

/// Whether a file was written after another one.
fn is_newer(file: &Path, other: &Path) -> bool {
    let written = |path: &Path| std::fs::metadata(path).and_then(|data| data.modified()).ok();
    written(file).zip(written(other)).is_some_and(|(file, other)| file > other)
}

/// Opens the setup of a run, with its part unless that is `open` already.
///
/// # Errors
/// [`InputError`] when the run or its part cannot be read.
fn open_run(
    engine: &Engine,
    results: &StudyResults,
    row: usize,
    open: Option<&PartHash>,
    keeps_part: bool,
    monitor: &Monitor,
) -> Result<Opened, InputError> {
    let (path, run) = results.run(row)?;
    let name = path.display().to_string();
    let mut setup = read_setup_bytes(&format!("{name} (setup)"), run.setup.as_bytes())?;
    // The run names its machine file as the study did.
    let machine = setup.machine.file.as_deref().filter(|name| !is_built_in(name));
    if let Some(file) = machine.and_then(|name| results.file_of_study(name)) {
        setup.machine.file = Some(file.to_string_lossy().into_owned());
    }
    locate_machine(&mut setup, &path)?;
    let setup = Some((path, setup));
    if open.is_some_and(|open| open.sha256 == run.part_hash) {
        return Ok(Opened { setup, is_run: true, ..Opened::default() });
    }
    if keeps_part {
        let what = "the part of this run is not the one that the table of the study names".to_owned();
        let help = "merge the results of the study again, and open its table";
        return Err(InputError::new(ErrorCode::StudyResults, &name, 0, what, help));
    }
    let Some(file) = results.part_file(&run) else {
        let what = format!("the part of this run, {}, is not found, and the open one is another", run.part);
        let help = "open the part first, as it was when the study was run, then the run";
        return Err(InputError::new(ErrorCode::FileUnreadable, &name, 0, what, help));
    };
    let source = PartSource::File(file.clone());
    let (impeller, hash) = (engine.open)(&source, monitor)?;
    let mesh = PartMeshes::new(&impeller);
    let defaults = Setup::for_part(&impeller);
    let changed_part = (hash.sha256 != run.part_hash).then_some(file);
    let part = Some((OpenPart { source, impeller, defaults, hash }, mesh));
    Ok(Opened { part, setup, is_run: true, changed_part, ..Opened::default() })
}
