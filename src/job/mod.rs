//! The plunge planning job that window and command line share: from a request to a result, with progress and
//! cancellation.

pub mod assess;
mod channels;
mod edited;
pub mod flank;
mod goal;
mod machine;
pub mod machine_run;
mod nothing_cut;
mod part_cache;
pub mod post;
pub mod stage;
mod starved;
pub mod worker;

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

pub use crate::verify::Summary;
use edited::plan_with_edits;
use goal::{MetGoal, WholeInput};
use machine::{clock_of, machine_of};
use nothing_cut::nothing_cut;
use part_cache::PartCache;
pub use stage::{Listener, PlanStage};

use rayon::prelude::*;

use crate::error::UserError;
use crate::io::tool_library::plunge_cutters;
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, Workpiece};
use crate::plunge::sections::Resolved;
use crate::plunge::{
    EditReport, PlanError, Planner, PlungePlan, RowDensity, SectionCache, cutting_order, sections,
};
use crate::setup::{AxisPolicy, Goal, PlungeEdit, Setup, SetupFault};
use crate::stock::{
    FloorGrid, FloorSource, InaccessibleFloor, ResidualField, field_cutters, residual_field, statistics,
    stretches_of_setup,
};
use crate::tradeoff::PlanClock;

/// Cells of the residual field along s and λ with which results are reported; fine enough that one is well
/// below a pixel with the channel fitted to the view.
pub const FIELD_CELLS: usize = 512;

/// Share of the progress of planning `minimal` before its goal is met by plans with fewer plunges.
const FIRST_SHARE: f64 = 0.6;

/// Request for a plunge plan.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// The part.
    pub part: Arc<Impeller>,
    /// The setup as given by the user.
    pub setup: Setup,
    /// Axis policy of the result ("after"); "before" is always conventional.
    pub policy: AxisPolicy,
    /// Whether the other policies are also planned, for comparison.
    pub compare: bool,
    /// Cells of the residual field along s and λ.
    pub field_cells: usize,
}

/// A plan with its residual stock.
#[derive(Clone, Debug)]
pub struct PolicyResult {
    /// The plan.
    pub plan: PlungePlan,
    /// Residual stock on the channel floor after all positions.
    pub field: ResidualField,
    /// Summary figures of the plan.
    pub summary: Summary,
}

/// Result of a [`PlanRequest`].
#[derive(Clone, Debug)]
pub struct PlanOutcome {
    /// The part that was planned, with its blank.
    pub workpiece: Arc<Workpiece>,
    /// The setup with the default choices (tools, sections) filled in.
    pub setup: Setup,
    /// Why each section was chosen; `None` for sections given by the setup.
    pub reasons: Vec<Option<String>>,
    /// Floor grid of all fields.
    pub grid: Arc<FloorGrid>,
    /// What makes floor inaccessible, whichever the policy, the largest share first.
    pub inaccessible_floor: Vec<InaccessibleFloor>,
    /// Conventional plan.
    pub before: PolicyResult,
    /// Plan by the requested policy and goal.
    pub after: PolicyResult,
    /// The plan of `minimal` before plunges were left out for the goal and before edits; `None` where neither
    /// changed it, or it was not planned.
    pub whole: Option<PlungePlan>,
    /// The plan of `minimal` with fewer rows, if the goal needed it.
    pub sparse: Option<Arc<PlungePlan>>,
    /// How closely the rows of the plan of `minimal` lie that the goal chose.
    pub density: RowDensity,
    /// Whether no plan of `minimal` meets the goal; `after` comes nearest.
    pub misses_goal: bool,
    /// Plans by the other policies, if requested.
    pub others: Vec<PolicyResult>,
    /// What the edits of the setup did to the plan `after`; the other plans are as they were found.
    pub edits: EditReport,
    /// The edits of the setup whose locked plunges `after` was planned around; empty where the planner places
    /// all of them by itself.
    pub kept_locked: Vec<PlungeEdit>,
    /// What tells the time of plans: on the machine of the setup, if it gives one.
    pub clock: Arc<PlanClock>,
    /// Wall-clock time of the job, s.
    pub elapsed: f64,
}

impl PlanOutcome {
    /// Time that semi-finishing takes for what `result`, one of the results of this outcome, leaves in a channel, s;
    /// `None` where the goal does not count it.
    pub fn finishing_time_s(&self, result: &PolicyResult) -> Option<f64> {
        let Goal::Total { finishing } = self.setup.plunge.goal else { return None };
        let left = statistics(&self.grid, &result.field.heights, |_| true);
        let excess = left.excess_above(self.setup.allowances.hub_allowance);
        Some(finishing.time_s(excess.volume, excess.p95))
    }

    /// The result of every planned policy, in the order of [`AxisPolicy::ALL`].
    pub fn policies(&self) -> Vec<&PolicyResult> {
        // The requested plan first: with edits it differs from the one before even by the same policy.
        let all = || [&self.after, &self.before].into_iter().chain(&self.others);
        AxisPolicy::ALL.iter().filter_map(|policy| all().find(|r| r.plan.policy == *policy)).collect()
    }
}

/// Why a job has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JobError {
    /// Cancelled without a result; the caller keeps its last good one.
    #[error("cancelled")]
    Cancelled,
    /// Part and setup are incompatible: the fault and what to do about it.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<JobError> for UserError {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Cancelled => Cancelled.into(),
            JobError::Setup(fault) => fault.into(),
        }
    }
}

impl From<PlanError> for JobError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(_) => Self::Cancelled,
            PlanError::Setup(fault) => fault.into(),
        }
    }
}

/// Completes the setup: missing tools and sections are chosen from the program's tool library, by their times on the
/// machine of the setup if it names one.
///
/// # Errors
/// [`SetupFault`] when part and setup are incompatible, or the machine file is not valid.
pub fn resolve(setup: &Setup, workpiece: &Workpiece) -> Result<Resolved, SetupFault> {
    let machine = machine_of(setup)?;
    let resolved = sections::resolve(setup, plunge_cutters(), workpiece, machine.as_ref())?;
    Ok(cutting_order::arrange(workpiece, resolved))
}

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

/// Cached sections of the last plans.
#[derive(Debug, Default)]
struct PolicyCache {
    /// Of the plan of each policy.
    policies: HashMap<AxisPolicy, SectionCache>,
    /// Of the plan of `minimal` with fewer rows.
    sparse: SectionCache,
}

/// Plunge planner with a cache of the last plan's sections, so that only stale sections are planned again.
#[derive(Debug, Default)]
pub struct PlanJob {
    last: PartCache<PlanCache>,
}

/// What is known of the last plans of a part.
#[derive(Debug, Default)]
struct PlanCache {
    plans: PolicyCache,
    /// The same with sections cut from the inlet or from both ends of the channel.
    reordered: PolicyCache,
    /// The last finished outcome before its edits, with its request: an edit changes nothing else.
    unedited: Option<(PlanRequest, PlanOutcome)>,
    /// The same, planned around the last locked plunges that the planner did not place by itself.
    around: Option<(Vec<PlungeEdit>, PlanOutcome)>,
}

impl PlanCache {
    /// The outcome of `request`, which has no edits, if it is the last one.
    fn unedited(&self, request: &PlanRequest) -> Option<PlanOutcome> {
        let (known, outcome) = self.unedited.as_ref()?;
        let is_same = known.setup.plans_equal_channel(&request.setup)
            && (known.policy, known.field_cells) == (request.policy, request.field_cells)
            && known.compare == request.compare
            // Its file may have changed since.
            && machine_of(&request.setup).is_ok_and(|machine| outcome.clock.machine() == machine.as_ref());
        is_same.then(|| outcome.clone())
    }
}

impl PlanJob {
    /// Plans one channel. After a stop of `monitor` the requested plan is evaluated as far as it was found,
    /// see [`PlungePlan::is_unfinished`]; other unfinished plans are dropped.
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

/// A plan on its way through the job.
enum JudgedPlan {
    /// Its residual stock is computed.
    Measured(Box<PolicyResult>),
    /// It was ready before the floor grid; its residual stock is computed at the end.
    Evaluated(PlungePlan),
}

/// Like [`plan_with_edits`], for a request without edits.
fn plan(
    request: &PlanRequest,
    known: &mut PlanCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlanOutcome, JobError> {
    let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(&request.part)));
    let resolved = resolve(&request.setup, &workpiece)?;
    let outcome = plan_sections(request, &workpiece, resolved, &mut known.plans, monitor, listener)?;
    // What starves is a search of `minimal`; plans of other policies stay as they are.
    if request.policy != AxisPolicy::Minimal {
        return Ok(outcome);
    }
    let Some(turned) = starved::reordered(&outcome, &mut known.reordered, monitor)? else {
        return Ok(outcome);
    };
    // Its sections are known; a stop leaves the rest to be finished.
    let closing = &monitor.ignoring_stop().silent();
    let turned =
        plan_sections(request, &workpiece, turned, &mut known.reordered, closing, Listener::default());
    match turned {
        Err(JobError::Cancelled) => Err(JobError::Cancelled),
        turned => Ok(turned.unwrap_or(outcome)),
    }
}

/// Plans by `policy`, and reports the stages of the plan.
fn plan_in_stages(
    planner: &Planner,
    policy: AxisPolicy,
    known: &mut SectionCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlungePlan, PlanError> {
    let placed = planner.place_plunges(policy, known, monitor)?;
    listener.notify(|| PlanStage::Placed(placed.plan().clone()));
    let plan = planner.evaluate(placed, monitor)?;
    listener.notify(|| PlanStage::Evaluated(plan.clone()));
    Ok(plan)
}

/// Plans the sections of `resolved`.
fn plan_sections(
    request: &PlanRequest,
    workpiece: &Arc<Workpiece>,
    Resolved { setup, reasons }: Resolved,
    known: &mut PolicyCache,
    monitor: &Monitor,
    listener: Listener,
) -> Result<PlanOutcome, JobError> {
    let started = std::time::Instant::now();
    // A goal that asks for less time than the least stock takes has `minimal` plan twice.
    let may_plan_twice = request.policy == AxisPolicy::Minimal && setup.plunge.goal != Goal::default();
    let first_share = if may_plan_twice { FIRST_SHARE } else { 1.0 };
    let (monitor, for_goal) = (&monitor.span(0.0, first_share), &monitor.span(first_share, 1.0));
    listener.notify(|| PlanStage::Resolved {
        workpiece: Arc::clone(workpiece),
        setup: setup.clone(),
        reasons: reasons.clone(),
    });
    let planner = Planner::new(workpiece, &setup);
    let clock = Arc::new(PlanClock::new(clock_of(&setup, workpiece)?));
    // The conventional plan and the grid are needed for every result, so they are completed even after a
    // stop.
    let closing = &monitor.ignoring_stop();
    let judged = |policy, known: &mut SectionCache, monitor: &Monitor| {
        plan_in_stages(&planner, policy, known, monitor, listener)
    };
    let measured = |plan: PlungePlan, grid: &Arc<FloorGrid>| -> Result<PolicyResult, PlanError> {
        closing.check()?;
        let result = measure_residual(plan, grid, &clock);
        listener.notify(|| PlanStage::Measured(Arc::clone(grid), result.clone()));
        Ok(result)
    };
    // Preview by warm start: the axes of the last plan, fitted to the new setup, are close to the result and
    // give live feedback while a slider is dragged. Failures are reported by the plan itself.
    let searched = known.policies.entry(request.policy).or_default();
    if listener.has_callback()
        && request.policy == AxisPolicy::Minimal
        && searched.valid_prefix(&setup)? < setup.plunge.sections.len()
        && let Ok(Some(plan)) = planner.warm_start(request.policy, searched, closing)
    {
        listener.notify(|| PlanStage::Preview(plan));
    }
    // Then the conventional plan alone on all cores, as it is ready first.
    let known_conventional = known.policies.entry(AxisPolicy::Conventional).or_default();
    let before = judged(AxisPolicy::Conventional, known_conventional, &closing.silent())?;
    // The other policies take most of the time.
    monitor.report(0.1);
    let ready = OnceLock::new();
    let conventional = || -> Result<(PolicyResult, Arc<FloorGrid>, Vec<InaccessibleFloor>), PlanError> {
        let cutters = stretches_of_setup(&setup);
        let source = FloorSource::of_setup(workpiece, &setup, &cutters);
        let (grid, inaccessible_floor) = FloorGrid::with_causes(&source, request.field_cells);
        let grid = Arc::new(grid);
        let result = measured(before, &grid)?;
        // Cannot fail: this is the only place that sets it.
        let _ = ready.set(Arc::clone(&grid));
        Ok((result, grid, inaccessible_floor))
    };
    let wanted = |policy: &&AxisPolicy| {
        **policy != AxisPolicy::Conventional && (request.compare || **policy == request.policy)
    };
    let mut policies: Vec<(AxisPolicy, SectionCache)> = AxisPolicy::ALL
        .iter()
        .filter(wanted)
        .map(|&policy| (policy, known.policies.remove(&policy).unwrap_or_default()))
        .collect();
    let asked = || -> Result<Vec<JudgedPlan>, PlanError> {
        let asked = policies.par_iter_mut().map(|(policy, known)| {
            let plan = match *policy == request.policy {
                true => judged(*policy, known, monitor),
                false => judged(*policy, known, &monitor.silent()),
            };
            let cancelled = matches!(plan, Err(PlanError::Cancelled(_)));
            if *policy == request.policy {
                if cancelled {
                    // Without the requested plan the others are useless.
                    monitor.cancel();
                }
            } else if cancelled && monitor.is_stopped() || plan.as_ref().is_ok_and(PlungePlan::is_unfinished)
            {
                return Ok(None);
            }
            let plan = plan?;
            Ok(Some(match ready.get() {
                Some(grid) => JudgedPlan::Measured(Box::new(measured(plan, grid)?)),
                None => JudgedPlan::Evaluated(plan),
            }))
        });
        asked.filter_map(Result::transpose).collect()
    };
    let (before, asked) = rayon::join(conventional, asked);
    known.policies.extend(policies);
    let ((mut before, grid, inaccessible_floor), asked) = (before?, asked?);
    let mut others = asked
        .into_iter()
        .map(|judged| match judged {
            JudgedPlan::Measured(result) => Ok(*result),
            JudgedPlan::Evaluated(plan) => measured(plan, &grid),
        })
        .collect::<Result<Vec<PolicyResult>, _>>()?;
    // Plans are compared by one clock.
    let asked = others.iter().find(|result| result.plan.policy == request.policy).unwrap_or(&before);
    let clock = match (clock.machine(), asked.summary.machine_time) {
        (Some(_), None) => {
            for result in others.iter_mut().chain([&mut before]) {
                (result.summary.machine_time, result.summary.is_refused) = (None, false);
            }
            Arc::new(clock.after_refusal())
        }
        _ => clock,
    };
    // The search of `minimal` adds plunges as long as they remove anything; the goal says which are worth it.
    let (mut whole, mut density, mut met) = (None, RowDensity::Dense, MetGoal::default());
    if let Some(minimal) = others.iter_mut().find(|result| result.plan.policy == AxisPolicy::Minimal) {
        let (plan, clock) = (&minimal.plan, &clock);
        let input = WholeInput { workpiece, setup: &setup, plan, grid: &grid, locks: &[], clock };
        met = goal::meet_goal(input, &mut known.sparse, for_goal)?;
        if let Some((plan, rows)) = met.plan.take() {
            density = rows;
            whole = Some(std::mem::replace(minimal, measure_residual(plan, &grid, clock)).plan);
        }
    }
    let after = match others.iter().position(|result| result.plan.policy == request.policy) {
        Some(index) => others.remove(index),
        None => before.clone(),
    };
    if after.plan.positions.is_empty() {
        return Err(JobError::Setup(nothing_cut(&after.plan, &setup, &workpiece.part)));
    }
    let elapsed = started.elapsed().as_secs_f64();
    Ok(PlanOutcome {
        workpiece: Arc::clone(workpiece),
        setup,
        reasons,
        grid,
        inaccessible_floor,
        before,
        after,
        whole,
        sparse: met.sparse,
        density,
        misses_goal: met.misses_goal,
        others,
        edits: EditReport::default(),
        kept_locked: Vec::new(),
        clock,
        elapsed,
    })
}

/// Computes the residual stock and the summary of a plan.
fn measure_residual(plan: PlungePlan, grid: &FloorGrid, clock: &PlanClock) -> PolicyResult {
    let field = residual_field(grid, &field_cutters(&plan));
    let machine_time = clock.machine_time(&plan);
    let is_refused = clock.timing().is_some() && machine_time.is_none();
    let summary = Summary { machine_time, is_refused, ..Summary::of(&plan, grid, &field) };
    PolicyResult { plan, field, summary }
}
