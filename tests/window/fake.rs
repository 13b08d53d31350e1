//! A fast fake planner whose plan has known faults. The part is real.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, TryLockError};

use vanecut::app::model::checked::CheckRequest;
use vanecut::app::tasks::engine::Engine;
use vanecut::cutting::contact::CoreContact;
use vanecut::error::ErrorCode;
use vanecut::geometry::Vector;
use vanecut::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use vanecut::job::{JobError, Listener, PlanJob, PlanOutcome, PlanRequest, PolicyResult, Summary};
use vanecut::machine::MachineTime;
use vanecut::monitor::Monitor;
use vanecut::part::channel::Passage;
use vanecut::part::{Impeller, Workpiece};
use vanecut::plunge::{
    AddedPlunges, Blocked, EditReport, Evaluation, PlungePlan, Position, RowDensity, SectionPlan, StopReason,
};
use vanecut::setup::{
    AxisPolicy, CutDirection, SectionKind, SectionSetup, Setup, SetupFault, SetupPlace, Tool,
};
use vanecut::stock::{FloorGrid, field_cutters, residual_field};

/// Number of interfering plunges of the conventional plan at the automatic step.
pub const FAULTS: usize = 5;

/// While set, the planner runs until it is stopped, and returns an unfinished plan; a check of a program
/// begins again until it is cancelled.
pub type Slow = Arc<AtomicBool>;

/// The fake planner over the real samples.
pub fn engine() -> (Engine, Slow) {
    let slow = Slow::default();
    let stalls = Arc::clone(&slow);
    let plan = move |request: &PlanRequest, monitor: &Monitor, _: Listener| {
        while stalls.load(Ordering::SeqCst) {
            monitor.report(0.4);
            if monitor.is_stopped() {
                return Ok(unfinished(plan(request)?));
            }
            monitor.check().map_err(|_| JobError::Cancelled)?;
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        plan(request)
    };
    let stalls = Arc::clone(&slow);
    let check = move |request: &CheckRequest, monitor: &Monitor| {
        while stalls.load(Ordering::SeqCst) {
            // Only the check itself notices a cancel.
            vanecut::app::tasks::check::check(request, monitor)?;
        }
        vanecut::app::tasks::check::check(request, monitor)
    };
    let flank = Arc::new(cached_flank);
    (Engine { plan: Arc::new(plan), check: Arc::new(check), flank, ..Engine::default() }, slow)
}

/// Flank plans that were made or are being made, by name of the part and setup.
type FlankPlans = Vec<(String, Setup, Arc<Mutex<Option<FlankOutcome>>>)>;
static FLANK_PLANS: Mutex<FlankPlans> = Mutex::new(Vec::new());

/// The real flank planner; a plan that another test has asked for is not made again but waited for.
fn cached_flank(request: &FlankRequest, monitor: &Monitor) -> Result<FlankOutcome, JobError> {
    let FlankRequest { part, setup } = request;
    let place = flank_plan(&part.name, setup);
    let mut known = loop {
        match place.try_lock() {
            Ok(known) => break known,
            Err(TryLockError::Poisoned(known)) => break known.into_inner(),
            Err(TryLockError::WouldBlock) => {
                monitor.check().map_err(|_| JobError::Cancelled)?;
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        }
    };
    let outcome = match &*known {
        Some(outcome) => outcome.clone(),
        None => known.insert(FlankJob::default().run(request, monitor)?).clone(),
    };
    // It belongs to the part that is open.
    let workpiece = Arc::new(setup.allowances.workpiece_of(Arc::clone(part)));
    Ok(FlankOutcome { workpiece, ..outcome })
}

/// The place of the flank plan of a part with this setup.
fn flank_plan(part: &str, setup: &Setup) -> Arc<Mutex<Option<FlankOutcome>>> {
    let mut plans = FLANK_PLANS.lock().unwrap();
    if let Some((.., place)) = plans.iter().find(|(name, asked, _)| name == part && asked == setup) {
        return Arc::clone(place);
    }
    let place = Arc::default();
    plans.push((part.to_owned(), setup.clone(), Arc::clone(&place)));
    place
}

/// First plans that were made, by name of the part and request.
type FirstPlans = Vec<((String, PlanRequest), Arc<OnceLock<PlanOutcome>>)>;
static FIRST_PLANS: Mutex<FirstPlans> = Mutex::new(Vec::new());

/// The real planner. Its first plan is shared with other tests that begin with the same one; it reports no
/// stages.
pub fn shared_engine() -> Engine {
    let (job, is_first) = (PlanJob::default(), AtomicBool::new(true));
    let plan = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        if !is_first.swap(false, Ordering::SeqCst) {
            return job.run_with_listener(request, monitor, listener);
        }
        let place = first_plan(request);
        let outcome = place.get_or_init(|| {
            PlanJob::default().run(request, &Monitor::default()).expect("the first plan of a test")
        });
        // It belongs to the part that is open.
        let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(&request.part)));
        Ok(PlanOutcome { workpiece, ..outcome.clone() })
    };
    Engine { plan: Arc::new(plan), ..Engine::default() }
}

/// The place of the first plan for `request`.
fn first_plan(request: &PlanRequest) -> Arc<OnceLock<PlanOutcome>> {
    let mut known = FIRST_PLANS.lock().unwrap();
    if let Some((_, place)) = known.iter().find(|(key, _)| is_for(request, key)) {
        return Arc::clone(place);
    }
    let place = Arc::new(OnceLock::new());
    known.push(((request.part.name.clone(), request.clone()), Arc::clone(&place)));
    place
}

/// Whether a known plan, of a part of this name, is the one for `request`.
fn is_for(request: &PlanRequest, (name, other): &(String, PlanRequest)) -> bool {
    *name == request.part.name
        && other.setup == request.setup
        && (other.policy, other.compare) == (request.policy, request.compare)
        && other.field_cells == request.field_cells
}

/// Fake plans that were made, by name of the part and request.
static FAKE_PLANS: Mutex<Vec<((String, PlanRequest), PlanOutcome)>> = Mutex::new(Vec::new());

/// The fake plan for `request`, which other tests may have asked for before; it belongs to the part that is
/// open.
fn shared_fake_plan(request: &PlanRequest) -> PlanOutcome {
    let known = || FAKE_PLANS.lock().unwrap();
    let found = known().iter().find(|(key, _)| is_for(request, key)).map(|(_, plan)| plan.clone());
    if let Some(outcome) = found {
        let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(&request.part)));
        return PlanOutcome { workpiece, ..outcome };
    }
    // Two tests that ask at once both make it: to wait could last for ever, as threads of one pool do both.
    let outcome = fake_plan(request);
    known().push(((request.part.name.clone(), request.clone()), outcome.clone()));
    outcome
}

/// The plan with its first row only, as if the planner was stopped after it.
fn unfinished(mut outcome: PlanOutcome) -> PlanOutcome {
    let plan = &mut outcome.after.plan;
    plan.positions.retain(|position| position.row == 0);
    plan.sections[0].rows = 1;
    plan.sections[0].added = Some(AddedPlunges::UNFINISHED);
    outcome
}

fn plan(request: &PlanRequest) -> Result<PlanOutcome, JobError> {
    if request.setup.allowances.hub_allowance > 15.0 {
        let what = format!("`hub_allowance` is {}, too much", request.setup.allowances.hub_allowance);
        let fault = SetupFault::new(ErrorCode::HubAllowance, what, "make hub_allowance smaller");
        return Err(fault.at(SetupPlace::Stock("hub_allowance")).into());
    }
    if request.setup.allowances.hub_allowance > 10.0 {
        let what = "the hub allowance of 12 mm leaves no channel at s 0.31".to_owned();
        return Err(SetupFault::new(ErrorCode::HubAllowance, what, "make it smaller").into());
    }
    Ok(shared_fake_plan(request))
}

fn fake_plan(request: &PlanRequest) -> PlanOutcome {
    let workpiece = Arc::new(request.setup.allowances.workpiece_of(Arc::clone(&request.part)));
    let Workpiece { part, channel, .. } = &*workpiece;
    let passage = &channel.full;
    let tool = Tool {
        number: 1,
        // The larger the step, the smaller the tool: the program chooses anew.
        diameter: if request.setup.plunge.step.is_some_and(|step| step > 20.0) { 20.0 } else { 30.0 },
        corner_radius: 0.0,
        insert_width: 10.0,
        overhang: 120.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    };
    let grid = Arc::new(grid(part, passage));
    let result = |policy: AxisPolicy| {
        let plan = plunges(request, passage, &tool, policy);
        let height = if policy == AxisPolicy::Conventional { 2.6 } else { 1.1 };
        let field = residual_field(&grid, &field_cutters(&plan));
        let summary = summary(&plan, height);
        PolicyResult { plan, field, summary }
    };
    let mut setup = request.setup.clone();
    let section = |tool: u32, kind: SectionKind| SectionSetup {
        tool,
        from: 1.0,
        to: 0.5,
        cut_direction: Some(CutDirection::OutletToInlet),
        kind,
    };
    if setup.tools.is_empty() {
        setup.tools = vec![tool.clone(), rest_tool(&tool)];
        setup.plunge.sections = vec![section(1, SectionKind::Rows), section(2, SectionKind::Rest)];
    }
    PlanOutcome {
        reasons: vec![None, None],
        workpiece: Arc::clone(&workpiece),
        setup,
        grid: Arc::clone(&grid),
        inaccessible_floor: Vec::new(),
        before: result(AxisPolicy::Conventional),
        after: result(request.policy),
        whole: None,
        sparse: None,
        density: RowDensity::Dense,
        misses_goal: false,
        others: if request.compare {
            let other =
                |policy: &&AxisPolicy| **policy != AxisPolicy::Conventional && **policy != request.policy;
            AxisPolicy::ALL.iter().filter(other).map(|&policy| result(policy)).collect()
        } else {
            Vec::new()
        },
        edits: EditReport::default(),
        kept_locked: Vec::new(),
        clock: Default::default(),
        elapsed: 0.084,
    }
}

/// Two rows from the rim to the middle of the channel. With the conventional policy the last plunges of the
/// first row interfere; with any other policy one is blocked.
fn plunges(request: &PlanRequest, passage: &Passage, tool: &Tool, policy: AxisPolicy) -> PlungePlan {
    let per_row = (160.0 / request.setup.plunge.step.unwrap_or(tool.insert_width)).ceil() as usize;
    let mut positions = Vec::new();
    for (row, lambda) in [0.32, 0.68].into_iter().enumerate() {
        for k in 0..per_row {
            let s = 1.0 - 0.5 * k as f64 / per_row as f64;
            let at = |eta| passage.point(&request.part, s, lambda, eta).expect("inside the channel").point;
            let conventional = policy == AxisPolicy::Conventional;
            // Conventional plunges end higher above the hub.
            let (tip, top) = (at(if conventional { 0.05 } else { 0.02 }), at(1.0));
            let axis: Vector = (top - tip).normalize();
            let interferes = conventional && row == 0 && k + FAULTS >= per_row;
            positions.push(Position {
                tip,
                axis,
                section: 0,
                row,
                s,
                lambda,
                alpha_rad: (2.0 + 0.4 * k as f64).to_radians() * if conventional { -1.0 } else { 1.0 },
                contact_point: tip,
                lift: 0.0,
                blocked: (!conventional && row == 1 && k == 1).then_some(Blocked::Walls),
                limited_by: None,
                hub_clearance: 0.5,
                blade_clearance: 0.5,
                evaluation: Evaluation {
                    contact: CoreContact { depth: if interferes { 2.56 } else { 0.0 }, area_share: 0.2 },
                    retract: top + axis * 6.0,
                    retract_clearance: 2.0,
                    engagement: Default::default(),
                    motion: Default::default(),
                    breach: None,
                },
            });
        }
    }
    let section = SectionPlan {
        tool: tool.clone(),
        from: 1.0,
        to: 0.5,
        feed: CutDirection::OutletToInlet,
        rows: 2,
        kind: SectionKind::Rows,
        added: None,
    };
    // A smaller tool for the rest that finds nothing to do.
    let rest = SectionPlan {
        tool: rest_tool(tool),
        rows: 0,
        kind: SectionKind::Rest,
        added: Some(AddedPlunges { count: 0, stopped: StopReason::NothingWorthwhile }),
        ..section.clone()
    };
    PlungePlan {
        policy,
        sections: vec![section, rest],
        positions,
        dropped: Vec::new(),
        iterations: 2,
        converged: true,
    }
}

/// The engine, with its roughing plans changed.
pub fn with_changed_plans(
    engine: Engine,
    change: impl Fn(&mut PlanOutcome) + Send + Sync + 'static,
) -> Engine {
    let inner = Arc::clone(&engine.plan);
    let plan = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        let mut outcome = inner(request, monitor, listener)?;
        change(&mut outcome);
        Ok(outcome)
    };
    Engine { plan: Arc::new(plan), ..engine }
}

/// The engine, whose flank planner waits until the flag is cleared.
pub fn with_held_flank(engine: Engine) -> (Engine, Arc<AtomicBool>) {
    let held = Arc::new(AtomicBool::new(true));
    let (inner, waits) = (Arc::clone(&engine.flank), Arc::clone(&held));
    let flank = move |request: &FlankRequest, monitor: &Monitor| {
        while waits.load(Ordering::SeqCst) {
            monitor.check().map_err(|_| JobError::Cancelled)?;
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        inner(request, monitor)
    };
    (Engine { flank: Arc::new(flank), ..engine }, held)
}

/// The engine, with its flank plans changed.
pub fn with_changed_flank(
    engine: Engine,
    change: impl Fn(&mut FlankOutcome) + Send + Sync + 'static,
) -> Engine {
    let inner = Arc::clone(&engine.flank);
    let flank = move |request: &FlankRequest, monitor: &Monitor| {
        let mut outcome = inner(request, monitor)?;
        change(&mut outcome);
        Ok(outcome)
    };
    Engine { flank: Arc::new(flank), ..engine }
}

/// The engine, whose flank plans have few passes, whatever the setup asks for: for tests of plans that no
/// other test has.
pub fn with_few_passes(engine: Engine) -> Engine {
    let inner = Arc::clone(&engine.flank);
    let flank = move |request: &FlankRequest, monitor: &Monitor| {
        let mut coarse = request.clone();
        (coarse.setup.flank.layer_depth, coarse.setup.flank.scallop_height) = (20.0, 1.0);
        let mut outcome = inner(&coarse, monitor)?;
        outcome.setup.flank.layer_depth = request.setup.flank.layer_depth;
        outcome.setup.flank.scallop_height = request.setup.flank.scallop_height;
        Ok(outcome)
    };
    Engine { flank: Arc::new(flank), ..engine }
}

/// The fake planner, whose tools have a shank and a holder.
pub fn engine_with_holder() -> Engine {
    let (engine, _) = engine();
    let held = move |outcome: &mut PlanOutcome| {
        for plan in [&mut outcome.before.plan, &mut outcome.after.plan] {
            for section in &mut plan.sections {
                section.tool.assembly.shank = vec![[24.0, 40.0]];
                section.tool.assembly.holder = vec![[40.0, 50.0, 25.0], [63.0, 63.0, 20.0]];
            }
        }
    };
    with_changed_plans(engine, held)
}

/// The fake planner, whose plans have `count` sections of as many tools: the plunges in turn.
pub fn engine_of_sections(count: usize) -> Engine {
    let (engine, _) = engine();
    let divided = move |outcome: &mut PlanOutcome| {
        for plan in [&mut outcome.before.plan, &mut outcome.after.plan] {
            let first = plan.sections[0].clone();
            let of = |k: usize| {
                let tool = Tool { number: 1 + k as u32, ..first.tool.clone() };
                SectionPlan { tool, ..first.clone() }
            };
            plan.sections = (0..count).map(of).collect();
            let positions = plan.positions.len();
            for (k, position) in plan.positions.iter_mut().enumerate() {
                position.section = k * count / positions;
            }
        }
        outcome.reasons = vec![None; count];
    };
    with_changed_plans(engine, divided)
}

/// The fake planner on a machine that takes `time` for each plan.
pub fn engine_on_machine(time: MachineTime) -> Engine {
    let (engine, _) = engine();
    let timed = move |outcome: &mut PlanOutcome| {
        outcome.after.summary.machine_time = Some(time);
    };
    with_changed_plans(engine, timed)
}

/// The fake planner on a machine that takes `time` for the plan that is asked for, and refuses all others.
pub fn engine_that_refuses_others(time: MachineTime) -> Engine {
    let engine = engine_on_machine(time);
    let refused = move |outcome: &mut PlanOutcome| {
        outcome.before.summary.is_refused = true;
    };
    with_changed_plans(engine, refused)
}

fn rest_tool(tool: &Tool) -> Tool {
    Tool { number: 2, diameter: 16.0, insert_width: 5.0, ..tool.clone() }
}

fn summary(plan: &PlungePlan, mean: f64) -> Summary {
    let faults = plan.positions.iter().filter(|p| p.evaluation.contact.interferes()).count();
    Summary {
        positions: plan.positions.len(),
        interfering: faults,
        max_contact_depth: if faults > 0 { 2.56 } else { 0.0 },
        residual_mean: mean,
        residual_p95: 1.6 * mean,
        residual_max: 2.0 * mean,
        uncut_share: 0.012,
        inaccessible_share: 0.0,
        min_hub_clearance: 0.5,
        min_blade_clearance: 0.5,
        min_retract_clearance: 2.0,
        max_axis_change_rad: 0.02,
        cut_length: 2000.0,
        rapid_length: 4000.0,
        time_estimate: 1080.0,
        feed_time: 1056.0,
        machine_time: None,
        tool_loads: 1,
        wheel_time_s: None,
        further_tool_changes_s: 0.0,
        is_refused: false,
        blocked: Some(plan.positions.iter().filter(|p| p.blocked.is_some()).count()),
    }
}

fn grid(part: &Impeller, passage: &Passage) -> FloorGrid {
    let (rows, columns) = (64, 32);
    let mut grid = FloorGrid {
        rows,
        columns,
        points: Vec::new(),
        normals: Vec::new(),
        blank_heights: vec![40.0; rows * columns],
        areas: vec![12.0; rows * columns],
        floor: vec![true; rows * columns],
        reachable: vec![true; rows * columns],
    };
    for i in 0..rows {
        for j in 0..columns {
            let (s, lambda) = (i as f64 / (rows - 1) as f64, j as f64 / (columns - 1) as f64);
            let at = |eta| passage.point(part, s, lambda, eta).expect("inside the channel").point;
            let (foot, normal) = (at(0.0), (at(0.01) - at(0.0)).normalize());
            grid.points.push([foot.x as f32, foot.y as f32, foot.z as f32]);
            grid.normals.push([normal.x as f32, normal.y as f32, normal.z as f32]);
        }
    }
    grid
}
