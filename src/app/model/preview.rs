//! Preview of a running plan: the results so far, and the slot that passes them from the planner to the
//! window.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::drawing::cutters::{evaluated_cutters, placed_cutters};
use crate::gpu::cutters::DrawnCutter;
use crate::job::{PlanOutcome, PlanStage, PolicyResult};
use crate::part::Workpiece;
use crate::plunge::{EditReport, PlungePlan, RowDensity, Unevaluated};
use crate::setup::{AxisPolicy, Setup};
use crate::stock::{FieldProgram, FloorGrid, FloorLevels};

use crate::app::model::planned::DisplayPlan;

/// Plan of a policy before its residual stock is computed.
#[derive(Clone, Debug)]
pub enum PreviewPlan {
    /// The axes of the last plan, fitted to the new setup.
    WarmStart(Arc<PlungePlan>),
    /// Core contact is not checked yet: no plunge may be shown as sound.
    Placed(Arc<PlungePlan<Unevaluated>>),
    /// Core contact is checked.
    Evaluated(Arc<PlungePlan>),
}

/// Cutters that a view shows instead of those of its plan.
#[derive(Clone, Debug)]
pub struct ShownCutters {
    /// The cutters as they are drawn.
    pub cutters: Arc<[DrawnCutter]>,
    /// The cutters over the floor of the last plan, for a preview of their stock on the device.
    pub program: Option<Arc<FieldProgram>>,
}

impl ShownCutters {
    /// Whether they are the same cutters; they are immutable, so pointer equality suffices.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.cutters, &other.cutters)
    }
}

/// Cutters of a policy's plan before its residual stock is computed.
#[derive(Clone, Debug)]
pub struct PreviewCutters {
    /// The plan so far.
    pub plan: PreviewPlan,
    /// Its cutters.
    pub shown: ShownCutters,
}

impl PreviewCutters {
    fn new(plan: PreviewPlan, program: Option<Arc<FieldProgram>>) -> Self {
        let cutters = match &plan {
            PreviewPlan::WarmStart(plan) | PreviewPlan::Evaluated(plan) => evaluated_cutters(plan),
            PreviewPlan::Placed(plan) => placed_cutters(plan),
        };
        Self { plan, shown: ShownCutters { cutters: cutters.into(), program } }
    }

    /// The plan, if core contact is checked.
    fn evaluated(&self) -> Option<&PlungePlan> {
        match &self.plan {
            PreviewPlan::WarmStart(plan) | PreviewPlan::Evaluated(plan) => Some(plan),
            PreviewPlan::Placed(_) => None,
        }
    }

    /// Whether core contact is checked.
    pub fn is_checked(&self) -> bool {
        self.evaluated().is_some()
    }

    /// Whether the axes are those of the last plan.
    pub fn is_warm_start(&self) -> bool {
        matches!(self.plan, PreviewPlan::WarmStart(_))
    }

    /// Policy of the plan.
    pub fn policy(&self) -> AxisPolicy {
        match &self.plan {
            PreviewPlan::WarmStart(plan) | PreviewPlan::Evaluated(plan) => plan.policy,
            PreviewPlan::Placed(plan) => plan.policy,
        }
    }

    /// Number of plunges.
    pub fn count(&self) -> usize {
        match &self.plan {
            PreviewPlan::WarmStart(plan) | PreviewPlan::Evaluated(plan) => plan.positions.len(),
            PreviewPlan::Placed(plan) => plan.positions.len(),
        }
    }

    /// Number of interfering plunges; `None` while contact is not checked.
    pub fn interfering_count(&self) -> Option<usize> {
        self.evaluated().map(PlungePlan::count_interfering)
    }
}

/// Preview of a running plan.
#[derive(Clone, Debug)]
pub struct PlanPreview {
    /// Number of the task; see [`crate::app::tasks::engine::PlanTask`].
    pub(in crate::app) task: u64,
    /// The setup as requested.
    pub setup: Setup,
    /// Latest stage of each policy, in order of arrival.
    cutters: Vec<PreviewCutters>,
    /// The finished policies, as a plan.
    pub planned: Option<Arc<DisplayPlan>>,
    /// The plan shown before.
    last: Option<Arc<DisplayPlan>>,
    resolved: Option<ResolvedRequest>,
    /// The floor of [`Self::planned`].
    floor: Option<Arc<FloorLevels>>,
    /// The plunges of the stages so far, sorted into the tiles of a floor.
    programs: Vec<Arc<FieldProgram>>,
}

/// What a plan is calculated for.
#[derive(Clone, Debug)]
struct ResolvedRequest {
    workpiece: Arc<Workpiece>,
    setup: Setup,
    /// See [`PlanOutcome::reasons`].
    reasons: Vec<Option<String>>,
}

impl PlanPreview {
    /// An empty preview. `last` is the plan of that part shown before.
    pub(in crate::app) fn new(task: u64, setup: Setup, last: Option<Arc<DisplayPlan>>) -> Self {
        let (cutters, programs) = (Vec::new(), Vec::new());
        Self { task, setup, cutters, planned: None, last, resolved: None, floor: None, programs }
    }

    /// The floor over which a stage is drawn, for [`crate::app::model::planned::program_of`].
    pub(in crate::app) fn floor_of(&mut self, stage: &PlanStage) -> Option<Arc<FloorLevels>> {
        match stage {
            PlanStage::Resolved { .. } => None,
            PlanStage::Preview(_) | PlanStage::Placed(_) | PlanStage::Evaluated(_) => {
                self.last.as_ref().map(|last| Arc::clone(&last.floor))
            }
            PlanStage::Measured(grid, _) => {
                let allowances = &self.setup.allowances;
                let known = self.floor.clone().filter(|floor| floor.is_of(grid));
                let last = || self.last.as_ref()?.floor_of(grid, allowances);
                let floor = known.or_else(last).unwrap_or_else(|| Arc::new(FloorLevels::new(grid)));
                Some(self.floor.insert(floor)).cloned()
            }
        }
    }

    /// The floor over which the finished plan is drawn, and the plunges sorted so far.
    pub(in crate::app) fn into_floor(
        self,
        outcome: &PlanOutcome,
    ) -> (Arc<FloorLevels>, Vec<Arc<FieldProgram>>) {
        let grid = &outcome.grid;
        let known = self.floor.filter(|floor| floor.is_of(grid));
        let last = || self.last.as_ref()?.floor_of(grid, &outcome.setup.allowances);
        (known.or_else(last).unwrap_or_else(|| Arc::new(FloorLevels::new(grid))), self.programs)
    }

    /// The plunges sorted so far.
    pub(in crate::app) fn programs(&self) -> Vec<Arc<FieldProgram>> {
        self.programs.clone()
    }

    /// Adds a stage; `program` is its plan over [`Self::floor_of`].
    pub(in crate::app) fn add_stage(&mut self, stage: PlanStage, program: Option<Arc<FieldProgram>>) {
        if let Some(program) = &program {
            self.programs.push(Arc::clone(program));
        }
        match stage {
            PlanStage::Resolved { workpiece, setup, reasons } => {
                self.resolved = Some(ResolvedRequest { workpiece, setup, reasons });
            }
            PlanStage::Preview(plan) => self.take_cutters(PreviewPlan::WarmStart(plan.into()), program),
            // The warm-start plan is shown already, and its contact is checked.
            PlanStage::Placed(plan) if self.has_warm_start(plan.policy) => {}
            PlanStage::Placed(plan) => self.take_cutters(PreviewPlan::Placed(plan.into()), program),
            PlanStage::Evaluated(plan) => self.take_cutters(PreviewPlan::Evaluated(plan.into()), program),
            // The conventional result arrives first. The requested policy is skipped: the finished plan
            // follows at once.
            PlanStage::Measured(_, result)
                if result.plan.policy == self.setup.plunge.axis && self.planned.is_some() => {}
            PlanStage::Measured(grid, result) => self.take_result(grid, result),
        }
    }

    fn take_cutters(&mut self, plan: PreviewPlan, program: Option<Arc<FieldProgram>>) {
        let cutters = PreviewCutters::new(plan, program);
        self.cutters.retain(|known| known.policy() != cutters.policy());
        self.cutters.push(cutters);
    }

    /// Whether the cutters of a policy are those of its warm start.
    fn has_warm_start(&self, policy: AxisPolicy) -> bool {
        self.cutters.iter().any(|known| known.is_warm_start() && known.policy() == policy)
    }

    /// Whether core contact is checked for any policy.
    pub(in crate::app) fn has_checked_stage(&self) -> bool {
        self.cutters.iter().any(PreviewCutters::is_checked)
    }

    fn take_result(&mut self, grid: Arc<FloorGrid>, result: PolicyResult) {
        let Some(ResolvedRequest { workpiece, setup, reasons }) = self.resolved.clone() else { return };
        let outcome = match &self.planned {
            Some(planned) => {
                let mut outcome = (*planned.outcome).clone();
                outcome.others.push(result);
                outcome
            }
            None => PlanOutcome {
                workpiece,
                setup,
                reasons,
                grid,
                inaccessible_floor: Vec::new(),
                before: result.clone(),
                after: result,
                whole: None,
                sparse: None,
                density: RowDensity::Dense,
                misses_goal: false,
                others: Vec::new(),
                edits: EditReport::default(),
                kept_locked: Vec::new(),
                clock: Arc::default(),
                elapsed: 0.0,
            },
        };
        let Some(floor) = &self.floor else { return };
        self.planned = Some(Arc::new(DisplayPlan::new(self.setup.clone(), outcome, floor, &self.programs)));
    }

    /// The cutters to show where `policy` is awaited: its own as soon as there are any, else the latest.
    pub fn cutters(&self, policy: AxisPolicy) -> Option<&PreviewCutters> {
        let own = self.cutters.iter().find(|known| known.policy() == policy);
        own.or_else(|| self.cutters.iter().rfind(|known| !known.is_warm_start()))
    }
}

/// Single-entry slot for the latest preview; a newer one replaces it, nothing queues up.
#[derive(Clone, Debug, Default)]
pub(in crate::app) struct PreviewSlot(Arc<Mutex<Option<Arc<PlanPreview>>>>);

impl PreviewSlot {
    fn latest(&self) -> MutexGuard<'_, Option<Arc<PlanPreview>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the content by `preview`.
    pub(in crate::app) fn put(&self, preview: PlanPreview) {
        *self.latest() = Some(Arc::new(preview));
    }

    /// Takes the content out.
    pub(in crate::app) fn take(&self) -> Option<Arc<PlanPreview>> {
        self.latest().take()
    }
}
