//! The plunge planning job that window and command line share: from a request to a result, with progress and
//! cancellation.

pub mod assess;
mod cache;
mod channels;
mod edited;
pub mod flank;
pub mod flank_channels;
mod flank_check;
mod flank_preparation;
mod goal;
mod machine;
pub mod machine_run;
mod nothing_cut;
mod outcome;
mod part_cache;
mod planning;
pub mod post;
pub mod stage;
mod starved;
pub mod worker;

pub use crate::verify::Summary;
use cache::{PlanCache, PolicyCache};
use edited::plan_with_edits;
use outcome::measure_residual;
pub use outcome::{JobError, PlanOutcome, PlanRequest, PolicyResult};
use part_cache::PartCache;
pub use planning::resolve;
pub use stage::{Listener, PlanStage};

use crate::monitor::Monitor;

/// Cells of the residual field along s and λ with which results are reported; fine enough that one is well
/// below a pixel with the channel fitted to the view.
pub const FIELD_CELLS: usize = 512;

/// Plans one channel, without a cache of earlier plans.
///
/// ```
/// use vanecut::{job, monitor::Monitor, setup::{AxisPolicy, Setup}};
/// # let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
/// # let part = vanecut::part::Impeller::build(&part)?;
/// let request = job::PlanRequest {
///     setup: Setup::for_part(&part),
///     part: part.into(),
///     policy: AxisPolicy::Monotone,
///     compare: false,
///     field_cells: 64,
/// };
/// let outcome = job::run(&request, &Monitor::default())?;
/// assert!(outcome.after.summary.interfering < outcome.before.summary.interfering);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The errors of [`PlanJob::run`].
pub fn run(request: &PlanRequest, monitor: &Monitor) -> Result<PlanOutcome, JobError> {
    PlanJob::default().run(request, monitor)
}

/// Plunge planner with a cache of the last plan's sections, so that only stale sections are planned again.
#[derive(Debug, Default)]
pub struct PlanJob {
    last: PartCache<PlanCache>,
}

impl PlanJob {
    /// Plans one channel. After a stop of `monitor` the requested plan is evaluated as far as it was found,
    /// see [`is_unfinished`](crate::plunge::PlungePlan::is_unfinished); other unfinished plans are dropped.
    ///
    /// # Errors
    /// [`JobError::Cancelled`] after a cancel of `monitor`, or after a stop before anything was found;
    /// [`JobError::Setup`] when part and setup are incompatible.
    pub fn run(&self, request: &PlanRequest, monitor: &Monitor) -> Result<PlanOutcome, JobError> {
        self.run_with_listener(request, monitor, Listener::default())
    }

    /// Like [`Self::run`], reporting every stage to `listener`. The conventional plan, which is the fastest,
    /// is evaluated before the others begin.
    ///
    /// # Errors
    /// The errors of [`Self::run`].
    pub fn run_with_listener(
        &self,
        request: &PlanRequest,
        monitor: &Monitor,
        listener: Listener,
    ) -> Result<PlanOutcome, JobError> {
        self.last.with(&request.part, |known| plan_with_edits(request, known, monitor, listener))
    }
}
