//! The functions of the program that the window calls: opening a part and planning it. Tests replace them.

use std::sync::{Arc, Mutex, PoisonError};

use crate::io::InputError;
use crate::io::part_hash::PartHash;
use crate::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use crate::job::{FIELD_CELLS, JobError, Listener, PlanJob, PlanOutcome, PlanRequest, PlanStage};
use crate::monitor::Monitor;
use crate::part::Impeller;
use crate::setup::Setup;

use super::check::{CheckError, check};
use crate::app::model::checked::{CheckRequest, CheckedProgram};
use crate::app::model::part_source::{PartSource, Sample};
use crate::app::model::planned::{DisplayPlan, program_of};
use crate::app::model::preview::{PlanPreview, PreviewSlot};

/// Opens a part; returns it with the hashes of its description.
pub type OpenFn =
    dyn Fn(&PartSource, &Monitor) -> Result<(Arc<Impeller>, PartHash), InputError> + Send + Sync;
/// Plans a part and reports the stages to the listener.
pub type PlanFn = dyn Fn(&PlanRequest, &Monitor, Listener) -> Result<PlanOutcome, JobError> + Send + Sync;

/// Plans flank milling passes.
pub type FlankFn = dyn Fn(&FlankRequest, &Monitor) -> Result<FlankOutcome, JobError> + Send + Sync;

/// Checks a program from anywhere.
pub type CheckFn = dyn Fn(&CheckRequest, &Monitor) -> Result<CheckedProgram, CheckError> + Send + Sync;

/// The functions that the window calls.
#[derive(Clone)]
pub struct Engine {
    /// Opens a part.
    pub open: Arc<OpenFn>,
    /// Plans a part.
    pub plan: Arc<PlanFn>,
    /// Plans its flank milling passes.
    pub flank: Arc<FlankFn>,
    /// Checks a program.
    pub check: Arc<CheckFn>,
    /// Sample parts that `open` accepts.
    pub samples: Vec<Sample>,
}

impl Default for Engine {
    /// The real functions and samples.
    fn default() -> Self {
        Self {
            open: Arc::new(|source, _| crate::app::tasks::files::open_part(source)),
            plan: {
                let job = PlanJob::default();
                Arc::new(move |request, monitor, listener| job.run_with_listener(request, monitor, listener))
            },
            flank: {
                let job = FlankJob::default();
                Arc::new(move |request, monitor| job.run(request, monitor))
            },
            check: Arc::new(check),
            samples: crate::app::tasks::files::samples(),
        }
    }
}

/// A task of the planning thread.
pub(in crate::app) struct PlanTask {
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

/// Cells of the residual field while a slider moves.
const DRAFT_CELLS: usize = 160;

impl Engine {
    /// Plans and prepares everything the panels show, so that the UI thread only draws. After each stage it
    /// puts a preview in `slot` and calls `notify`.
    ///
    /// # Errors
    /// [`JobError`] when the setup cannot be planned or the task is cancelled.
    pub(in crate::app) fn planned(
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
        let preview = PlanPreview::new(task.number, task.setup.clone(), last.clone());
        let preview = Mutex::new(preview);
        let listen = |stage: PlanStage| {
            if monitor.is_cancelled() {
                return;
            }
            let lock = || preview.lock().unwrap_or_else(PoisonError::into_inner);
            let (floor, known) = {
                let mut preview = lock();
                (preview.floor_of(&stage), preview.programs())
            };
            // Sorted without the lock, so that other policies can report their stages.
            let program = floor.and_then(|floor| Some(program_of(stage.cutters()?, &floor, &known)));
            let mut preview = lock();
            preview.add_stage(stage, program);
            slot.put(preview.clone());
            drop(preview);
            notify();
        };
        let outcome = (self.plan)(&request, monitor, Listener::new(&listen))?;
        let preview = preview.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (floor, known) = preview.into_floor(&outcome);
        Ok(DisplayPlan::new(request.setup, outcome, &floor, &known))
    }
}
