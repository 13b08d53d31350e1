//! The functions of the program that the window calls: opening a part and planning it. Tests replace them.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::io::InputError;
use crate::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use crate::job::{JobError, Listener, PlanJob, PlanOutcome, PlanRequest, PlanStage};
use crate::mesh::MeshOptions;
use crate::monitor::Monitor;
use crate::part::Impeller;
use crate::setup::Setup;

use super::planned::{DisplayPlan, program_of};
use super::preview::{PlanPreview, PreviewSlot};

/// Source of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartSource {
    /// A file.
    File(PathBuf),
    /// A mesh file, with the options the user set for it.
    Mesh(PathBuf, MeshOptions),
    /// A built-in sample, by name.
    Sample(String),
}

impl PartSource {
    /// The file with its mesh options; `None` for a sample.
    pub fn file(&self) -> Option<(&Path, MeshOptions)> {
        match self {
            Self::File(path) => Some((path, MeshOptions::default())),
            Self::Mesh(path, options) => Some((path, options.clone())),
            Self::Sample(_) => None,
        }
    }

    /// The file with its mesh options, if it is a mesh file.
    pub fn mesh(&self) -> Option<(&Path, MeshOptions)> {
        let is_mesh = |path: &Path| {
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            matches!(extension.as_str(), "glb" | "gltf")
        };
        self.file().filter(|(path, _)| is_mesh(path))
    }

    /// Display name.
    pub fn shown(&self) -> String {
        match self {
            Self::File(path) | Self::Mesh(path, _) => path.display().to_string(),
            Self::Sample(name) => name.clone(),
        }
    }
}

/// A built-in sample part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Name; also the part file's name without extension.
    pub name: &'static str,
    /// Short description.
    pub about: &'static str,
}

/// Opens a part; returns it with a hash of its description.
pub type OpenFn = dyn Fn(&PartSource, &Monitor) -> Result<(Arc<Impeller>, u64), InputError> + Send + Sync;
/// Plans a part and reports the stages to the listener.
pub type PlanFn = dyn Fn(&PlanRequest, &Monitor, Listener) -> Result<PlanOutcome, JobError> + Send + Sync;

/// Plans flank milling passes.
pub type FlankFn = dyn Fn(&FlankRequest, &Monitor) -> Result<FlankOutcome, JobError> + Send + Sync;

/// The functions that the window calls.
#[derive(Clone)]
pub struct Engine {
    /// Opens a part.
    pub open: Arc<OpenFn>,
    /// Plans a part.
    pub plan: Arc<PlanFn>,
    /// Plans its flank milling passes.
    pub flank: Arc<FlankFn>,
    /// Sample parts that `open` accepts.
    pub samples: Vec<Sample>,
}

impl Default for Engine {
    /// The real functions and samples.
    fn default() -> Self {
        Self {
            open: Arc::new(|source, _| super::files::open_part(source)),
            plan: {
                let job = PlanJob::default();
                Arc::new(move |request, monitor, listener| job.run_with_listener(request, monitor, listener))
            },
            flank: {
                let job = FlankJob::default();
                Arc::new(move |request, monitor| job.run(request, monitor))
            },
            samples: super::files::samples(),
        }
    }
}

/// A task of the planning thread.
pub(super) struct PlanTask {
    /// Counts up; stages of older tasks are discarded.
    pub number: u64,
    pub part: Arc<Impeller>,
    pub setup: Setup,
    /// Whether all policies are planned.
    pub compare: bool,
    /// Whether to plan a draft with a coarse residual field.
    pub draft: bool,
    /// The plan of the same part that is shown.
    pub last: Option<Arc<DisplayPlan>>,
}

/// Cells of the residual field along s and λ: fine enough that a cell is well below a pixel with the channel
/// fitted to the view.
const FIELD_CELLS: usize = 512;
/// Cells of the residual field while a slider moves.
const DRAFT_CELLS: usize = 160;

impl Engine {
    /// Plans and prepares everything the panels show, so that the UI thread only draws. After each stage it
    /// puts a preview in `slot` and calls `notify`.
    ///
    /// # Errors
    /// [`JobError`] when the setup cannot be planned or the task is cancelled.
    pub(super) fn planned(
        &self,
        task: &PlanTask,
        monitor: &Monitor,
        slot: &PreviewSlot,
        notify: &(dyn Fn() + Sync),
    ) -> Result<DisplayPlan, JobError> {
        let request = PlanRequest {
            part: Arc::clone(&task.part),
            setup: task.setup.clone(),
            policy: task.setup.plunge.axis,
            compare: task.compare,
            field_cells: if task.draft { DRAFT_CELLS } else { FIELD_CELLS },
        };
        let last = task.last.clone().filter(|last| Arc::ptr_eq(&last.outcome.workpiece.part, &task.part));
        let coming = PlanPreview::new(task.number, task.setup.clone(), last.clone());
        let coming = Mutex::new(coming);
        let listen = |stage: PlanStage| {
            if monitor.is_cancelled() {
                return;
            }
            let lock = || coming.lock().unwrap_or_else(PoisonError::into_inner);
            let (floor, known) = {
                let mut coming = lock();
                (coming.floor_of(&stage), coming.programs())
            };
            // Sorted without the lock, so that other policies can report their stages.
            let program = floor.and_then(|floor| Some(program_of(stage.cutters()?, &floor, &known)));
            let mut coming = lock();
            coming.add_stage(stage, program);
            slot.put(coming.clone());
            drop(coming);
            notify();
        };
        let outcome = (self.plan)(&request, monitor, Listener::new(&listen))?;
        let coming = coming.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (floor, known) = coming.into_floor(&outcome);
        Ok(DisplayPlan::new(request.setup, outcome, &floor, &known))
    }
}
