//! What the window asks of the rest of the program, as plain functions: opening a part and planning
//! it. Tests put stand-ins here.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::formats::InputError;
use crate::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use crate::job::{JobError, Listener, PlanJob, PlanOutcome, PlanRequest, Stage};
use crate::mesh::MeshOptions;
use crate::monitor::Monitor;
use crate::part::{Impeller, Setup};

use super::coming::{Coming, Slot};
use super::planned::Planned;

/// Where a part comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartSource {
    /// A file.
    File(PathBuf),
    /// A mesh file, with what the user said about it.
    Mesh(PathBuf, MeshOptions),
    /// A sample that is built into the program, by its name.
    Sample(String),
}

impl PartSource {
    /// The file, with what is said about it where it is a mesh; `None` for a sample.
    pub fn file(&self) -> Option<(&Path, MeshOptions)> {
        match self {
            Self::File(path) => Some((path, MeshOptions::default())),
            Self::Mesh(path, options) => Some((path, options.clone())),
            Self::Sample(_) => None,
        }
    }

    /// The file, if its part is made of a mesh.
    pub fn mesh(&self) -> Option<(&Path, MeshOptions)> {
        let is_mesh = |path: &Path| {
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            matches!(extension.as_str(), "glb" | "gltf")
        };
        self.file().filter(|(path, _)| is_mesh(path))
    }

    /// The name it is shown by.
    pub fn shown(&self) -> String {
        match self {
            Self::File(path) | Self::Mesh(path, _) => path.display().to_string(),
            Self::Sample(name) => name.clone(),
        }
    }
}

/// A sample part that is built into the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Name, also that of the part file without its extension.
    pub name: &'static str,
    /// What it shows, in a few words.
    pub about: &'static str,
}

/// Opens a part; with a hash of what it describes.
pub type OpenFn = dyn Fn(&PartSource, &Monitor) -> Result<(Arc<Impeller>, u64), InputError> + Send + Sync;
/// Plans a part, and tells the stages.
pub type PlanFn = dyn Fn(&PlanRequest, &Monitor, Listener) -> Result<PlanOutcome, JobError> + Send + Sync;

/// Plans flank curves.
pub type FlankFn = dyn Fn(&FlankRequest, &Monitor) -> Result<FlankOutcome, JobError> + Send + Sync;

/// The functions.
#[derive(Clone)]
pub struct Engine {
    /// Opens a part.
    pub open: Arc<OpenFn>,
    /// Plans a part.
    pub plan: Arc<PlanFn>,
    /// Plans its flank curves.
    pub flank: Arc<FlankFn>,
    /// Sample parts that `open` knows.
    pub samples: Vec<Sample>,
}

impl Default for Engine {
    /// The real ones.
    fn default() -> Self {
        Self {
            open: Arc::new(|source, _| super::files::open_part(source)),
            plan: {
                let job = PlanJob::default();
                Arc::new(move |request, monitor, listener| job.run_telling(request, monitor, listener))
            },
            flank: {
                let job = FlankJob::default();
                Arc::new(move |request, monitor| job.run(request, monitor))
            },
            samples: super::files::samples(),
        }
    }
}

/// What the planning thread works on.
pub(super) struct PlanTask {
    /// Counts up; a stage of an older task is of no interest.
    pub number: u64,
    pub part: Arc<Impeller>,
    pub setup: Setup,
    /// Whether all policies are planned.
    pub compare: bool,
    /// Whether a coarse field will do.
    pub draft: bool,
}

/// Cells of the residual field along s and λ: the field of the speed goals, and fine enough that a
/// cell is well below a pixel with the channel fitted.
const FIELD_CELLS: usize = 512;
/// The same while a slider moves.
const DRAFT_CELLS: usize = 160;

impl Engine {
    /// Plans and prepares everything the panels show, so that the UI thread only draws. What is known meanwhile is left
    /// in `slot`, and `notify` called.
    pub(super) fn planned(
        &self,
        task: &PlanTask,
        monitor: &Monitor,
        slot: &Slot,
        notify: &(dyn Fn() + Sync),
    ) -> Result<Planned, JobError> {
        let request = PlanRequest {
            part: Arc::clone(&task.part),
            setup: task.setup.clone(),
            policy: task.setup.plunge.axis,
            compare: task.compare,
            field_cells: if task.draft { DRAFT_CELLS } else { FIELD_CELLS },
        };
        let coming = Mutex::new(Coming::new(task.number, Arc::clone(&task.part), task.setup.clone()));
        let listen = |stage: Stage| {
            if monitor.is_cancelled() {
                return;
            }
            let mut coming = coming.lock().unwrap_or_else(PoisonError::into_inner);
            coming.add(stage);
            slot.put(coming.clone());
            notify();
        };
        let outcome = (self.plan)(&request, monitor, Listener::new(&listen))?;
        Ok(Planned::new(request.setup, outcome))
    }
}
