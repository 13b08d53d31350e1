//! What is to be opened.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::model::part_source::PartSource;
use crate::io::part_hash::PartHash;
use crate::setup::Setup;
use crate::study::StudyResults;

/// A task of the opening thread.
#[derive(Clone)]
pub(in crate::app) enum OpenTask {
    /// A project; optionally with another source of its part.
    Project(PathBuf, Option<PartSource>),
    /// A part, a setup, or both.
    Files {
        part: Option<PartSource>,
        setup: Option<PathBuf>,
        /// Values of keys absent from the setup, unless a part is opened with it.
        defaults: Box<Setup>,
    },
    /// A blank.
    Blank(PathBuf),
    /// A machine file.
    Machine(PathBuf),
    /// A tool library.
    Library(PathBuf),
    /// Results of a study: its folder, the list in it, or its table.
    Study(PathBuf),
    /// The run of a row of a study's results, to be planned. `open`: hash of the part that is open;
    /// `keeps_part`: whether only a run of that part may be opened, as nothing was asked about unsaved
    /// changes.
    Run { results: Arc<StudyResults>, row: usize, open: Option<PartHash>, keeps_part: bool },
    /// The nodes of a mesh file, for the roles dialog. `roles_by_shape`: as
    /// [`crate::part::PartDescription::roles_by_shape`] of the part that the file opened as.
    Nodes { source: PartSource, roles_by_shape: bool },
}

impl OpenTask {
    /// The same task with another source of the part.
    pub(in crate::app) fn with_part(self, source: PartSource) -> Self {
        match self {
            Self::Project(path, _) => Self::Project(path, Some(source)),
            Self::Files { setup, defaults, .. } => Self::Files { part: Some(source), setup, defaults },
            Self::Blank(_)
            | Self::Machine(_)
            | Self::Library(_)
            | Self::Study(_)
            | Self::Run { .. }
            | Self::Nodes { .. } => Self::Files { part: Some(source), setup: None, defaults: Box::default() },
        }
    }
}
