//! Opening of projects, parts, setups and blanks, on the background thread.

use std::path::PathBuf;

use super::engine::Engine;
use super::mesh_nodes::UnassignedRoles;
use super::open_task::OpenTask;
use super::part_meshes::PartMeshes;
use super::project::source_of;
use crate::app::model::document::OpenPart;
use crate::io::InputError;
use crate::io::blank_file::read_blank_file;
use crate::io::project_file::{Project, read_project};
use crate::io::setup_file::{locate_machine, read_setup};
use crate::io::shop_tools::{LibraryFormat, ToolLibrary, read_library};
use crate::monitor::Monitor;
use crate::part::BlankFile;
use crate::setup::Setup;

/// Result of an opening task.
#[derive(Default)]
pub(in crate::app) struct Opened {
    pub part: Option<(OpenPart, PartMeshes)>,
    pub setup: Option<(PathBuf, Setup)>,
    pub project: Option<(PathBuf, Project)>,
    pub blank: Option<BlankFile>,
    pub library: Option<(PathBuf, ToolLibrary)>,
    /// A mesh file whose nodes need roles first.
    pub unassigned: Option<UnassignedRoles>,
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
    let (source, setup, project) = match task {
        OpenTask::Project(path, instead) => {
            let mut project = read_project(path)?;
            let sets = project.sets.iter_mut().map(|set| &mut set.setup);
            std::iter::once(&mut project.setup).chain(sets).for_each(|setup| locate_machine(setup, path));
            let source = instead.clone().unwrap_or_else(|| source_of(&project));
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
        OpenTask::Library(path) => {
            let library = read_library(path, LibraryFormat::of_path(path)?)?;
            return Ok(Opened { library: Some((path.clone(), library)), ..Opened::default() });
        }
        OpenTask::Nodes(source) => {
            let nodes =
                source.mesh().map(|(path, said)| UnassignedRoles::read(path, &said, task.clone(), None));
            return Ok(Opened { unassigned: nodes.transpose()?, ..Opened::default() });
        }
    };
    let read = |defaults: Option<&Setup>| -> Result<Option<(PathBuf, Setup)>, InputError> {
        let Some((path, known)) = setup else { return Ok(None) };
        let mut setup = read_setup(path, defaults.unwrap_or(known))?;
        locate_machine(&mut setup, path);
        Ok(Some((path.clone(), setup)))
    };
    let Some(source) = source else {
        return Ok(Opened { setup: read(None)?, project, ..Opened::default() });
    };
    match (engine.open)(&source, monitor) {
        Ok((impeller, hash)) => {
            let mesh = PartMeshes::new(&impeller);
            let defaults = Setup::for_part(&impeller);
            let setup = read(Some(&defaults))?;
            let part = Some((OpenPart { source, impeller, defaults, hash }, mesh));
            Ok(Opened { part, setup, project, ..Opened::default() })
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
