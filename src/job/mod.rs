//! The planning job that window and command line share: request in, result out, progress and
//! cancel between.

pub mod flank;
pub mod stage;
pub mod worker;

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

pub use crate::verify::Summary;
pub use stage::{Listener, Stage};

use rayon::prelude::*;

use crate::formats::tool_library::plunge_cutters;
use crate::monitor::Monitor;
use crate::part::{AxisPolicy, Channel, Impeller, Setup};
use crate::plunge::sections::{self, Resolved, SetupFault};
use crate::plunge::{KnownSections, PlanError, Planner, PlungePlan};
use crate::residual::{
    FloorGrid, FloorSource, ResidualField, cutters_of, residual_field, stretches_of_setup,
};

/// What to plan.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// The part.
    pub part: Arc<Impeller>,
    /// The setup as the programmer gave it.
    pub setup: Setup,
    /// Policy of the result ("after"); "before" is always conventional.
    pub policy: AxisPolicy,
    /// Whether the other policies are planned as well, for comparison.
    pub compare: bool,
    /// Cells of the residual field along s and λ.
    pub field_cells: usize,
}

/// A plan with what it leaves.
#[derive(Clone, Debug)]
pub struct PolicyResult {
    /// The plan.
    pub plan: PlungePlan,
    /// Stock left on the hub after all positions.
    pub field: ResidualField,
    /// The numbers that decide.
    pub summary: Summary,
}

/// Result of a [`PlanRequest`].
#[derive(Clone, Debug)]
pub struct PlanOutcome {
    /// The part that was planned.
    pub part: Arc<Impeller>,
    /// The setup with everything that was chosen by default filled in (tools, sections).
    pub setup: Setup,
    /// For each section why it was chosen; `None` where the setup gave it.
    pub reasons: Vec<Option<String>>,
    /// Floor grid both fields stand on.
    pub grid: Arc<FloorGrid>,
    /// Conventional plan.
    pub before: PolicyResult,
    /// Plan by the policy asked for.
    pub after: PolicyResult,
    /// Plans by the other policies, when they were asked for.
    pub others: Vec<PolicyResult>,
    /// Wall time of the work, s.
    pub elapsed: f64,
}

impl PlanOutcome {
    /// Every policy that was planned, from what shops do today to ours.
    pub fn policies(&self) -> Vec<&PolicyResult> {
        let all = || [&self.before, &self.after].into_iter().chain(&self.others);
        AxisPolicy::ALL.iter().filter_map(|policy| all().find(|r| r.plan.policy == *policy)).collect()
    }
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JobError {
    /// Cancelled, and there is nothing to show for it; keep the last good result.
    #[error("cancelled")]
    Cancelled,
    /// The part and the setup do not go together: what, and what to do.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<PlanError> for JobError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(_) => Self::Cancelled,
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// The setup with everything filled in that it leaves open, from the program's tool library.
///
/// # Errors
/// When part and setup do not go together.
pub fn resolve(setup: &Setup, part: &Impeller, channel: &Channel) -> Result<Resolved, SetupFault> {
    sections::resolve(setup, plunge_cutters(), part, channel)
}

/// Plans one channel. The one way to a plan for window and command line alike.
///
/// # Errors
/// As [`PlanJob::run`].
pub fn run(request: &PlanRequest, monitor: &Monitor) -> Result<PlanOutcome, JobError> {
    PlanJob::default().run(request, monitor)
}

/// By policy the sections that were planned last.
type Known = HashMap<AxisPolicy, KnownSections>;

/// Plans channels and remembers the sections of the last plan, so that only stale ones are planned again.
#[derive(Debug, Default)]
pub struct PlanJob {
    last: Mutex<Option<(Arc<Impeller>, Known)>>,
}

impl PlanJob {
    /// Plans one channel. Once `monitor` is told to stop, the plan asked for is judged as far as it is found, see
    /// [`PlungePlan::is_unfinished`]; others that are not finished are left out.
    ///
    /// # Errors
    /// [`JobError::Cancelled`] soon after `monitor` is told so, or to stop where nothing was found yet;
    /// [`JobError::Setup`] when part and setup do not go together.
    pub fn run(&self, request: &PlanRequest, monitor: &Monitor) -> Result<PlanOutcome, JobError> {
        self.run_telling(request, monitor, Listener::default())
    }

    /// As [`Self::run`]; `listener` is told of every stage. The conventional plan, which takes least, is judged before
    /// others begin.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_telling(
        &self,
        request: &PlanRequest,
        monitor: &Monitor,
        listener: Listener,
    ) -> Result<PlanOutcome, JobError> {
        let part = &request.part;
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last.take().filter(|(known, _)| Arc::ptr_eq(known, part)).map(|(_, known)| known);
        let mut known = known.unwrap_or_default();
        let outcome = plan(request, &mut known, monitor, listener);
        *last = Some((part.clone(), known));
        outcome
    }
}

/// As [`PlanJob::run_telling`], with what is `known`.
fn plan(
    request: &PlanRequest,
    known: &mut Known,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlanOutcome, JobError> {
    let started = std::time::Instant::now();
    let part = &request.part;
    let channel = Channel::of(part);
    let Resolved { setup, reasons } = resolve(&request.setup, part, &channel)?;
    listener.tell(|| Stage::Resolved(setup.clone(), reasons.clone()));
    let planner = Planner::new(part, &channel, &setup);
    // What every plan is judged beside and by is made even after a stop.
    let closing = &monitor.closing();
    let judged = |policy, known: &mut KnownSections, monitor: &Monitor| -> Result<PlungePlan, PlanError> {
        let placed = planner.place(policy, known, monitor)?;
        listener.tell(|| Stage::Placed(placed.plan().clone()));
        let plan = planner.judge(placed, monitor)?;
        listener.tell(|| Stage::Judged(plan.clone()));
        Ok(plan)
    };
    let measured = |plan: PlungePlan, grid: &Arc<FloorGrid>| -> Result<PolicyResult, PlanError> {
        closing.check()?;
        let result = with_field(plan, grid);
        listener.tell(|| Stage::Measured(Arc::clone(grid), result.clone()));
        Ok(result)
    };
    // Axes that were searched for are near what will be found: a hand on a slider sees what it does to them at once. What
    // keeps them from it the plan itself will tell.
    let searched = known.entry(request.policy).or_default();
    if listener.is_listening()
        && request.policy == AxisPolicy::Minimal
        && searched.holding(&setup)? < setup.plunge.sections.len()
        && let Ok(Some(plan)) = planner.carried(request.policy, searched, closing)
    {
        listener.tell(|| Stage::Carried(plan));
    }
    // Then, on all processors, what is ready soonest.
    let known_conventional = known.entry(AxisPolicy::Conventional).or_default();
    let before = judged(AxisPolicy::Conventional, known_conventional, closing)?;
    // The way to the others is the long one.
    monitor.report(0.1);
    let ready = OnceLock::new();
    let conventional = || -> Result<(PolicyResult, Arc<FloorGrid>), PlanError> {
        let cutters = stretches_of_setup(&setup);
        let (blank, stock) = (planner.blank(), &setup.stock);
        let source = FloorSource { part, channel: &channel, blank, stock, cutters: &cutters };
        let grid = Arc::new(FloorGrid::new(&source, request.field_cells));
        let result = measured(before, &grid)?;
        // Nobody else sets it.
        let _ = ready.set(Arc::clone(&grid));
        Ok((result, grid))
    };
    let wanted = |policy: &&AxisPolicy| {
        **policy != AxisPolicy::Conventional && (request.compare || **policy == request.policy)
    };
    let mut policies: Vec<(AxisPolicy, KnownSections)> = AxisPolicy::ALL
        .iter()
        .filter(wanted)
        .map(|&policy| (policy, known.remove(&policy).unwrap_or_default()))
        .collect();
    // A plan that is there before the grid is measured at the end.
    let asked = || -> Result<Vec<Result<PolicyResult, PlungePlan>>, PlanError> {
        let asked = policies.par_iter_mut().map(|(policy, known)| {
            let plan = judged(*policy, known, monitor);
            let cancelled = matches!(plan, Err(PlanError::Cancelled(_)));
            if *policy == request.policy {
                if cancelled {
                    // With nothing to judge nobody needs the rest.
                    monitor.cancel();
                }
            } else if cancelled && monitor.is_stopped() || plan.as_ref().is_ok_and(PlungePlan::is_unfinished)
            {
                return Ok(None);
            }
            let plan = plan?;
            Ok(Some(match ready.get() {
                Some(grid) => Ok(measured(plan, grid)?),
                None => Err(plan),
            }))
        });
        asked.filter_map(Result::transpose).collect()
    };
    let (before, asked) = rayon::join(conventional, asked);
    known.extend(policies);
    let ((before, grid), asked) = (before?, asked?);
    let mut others = asked
        .into_iter()
        .map(|plan| plan.or_else(|plan| measured(plan, &grid)))
        .collect::<Result<Vec<PolicyResult>, _>>()?;
    let after = match others.iter().position(|result| result.plan.policy == request.policy) {
        Some(index) => others.remove(index),
        None => before.clone(),
    };
    if after.plan.positions.is_empty() {
        let tilt = setup.machine.max_axis_tilt.to_degrees();
        return Err(JobError::Setup(SetupFault::new(
            format!("no plunge has an axis that blades, tilt limits and the machine ({tilt:.0}°) allow"),
            "allow more tilt, or use smaller cutters",
        )));
    }
    monitor.report(1.0);
    let elapsed = started.elapsed().as_secs_f64();
    Ok(PlanOutcome { part: part.clone(), grid, before, after, others, elapsed, setup, reasons })
}

/// Adds to a plan what it leaves on the hub.
fn with_field(plan: PlungePlan, grid: &FloorGrid) -> PolicyResult {
    let field = residual_field(grid, &cutters_of(&plan));
    let summary = Summary::of(&plan, grid, &field);
    PolicyResult { plan, field, summary }
}
