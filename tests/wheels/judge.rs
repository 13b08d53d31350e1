//! Invariants of the plans of a wheel with the default setup.

use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::job::flank::{FlankJob, FlankRequest};
use vanecut::job::{PlanOutcome, PlanRequest, PolicyResult, Summary, run};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::plunge::channels::count_tool_loads;
use vanecut::setup::{AxisPolicy, ChannelOrder, ChannelSequence, ChannelSetup, FlankStrategy, Setup, Tool};
use vanecut::toolpath::ClProgram;
use vanecut::verify::{JudgedCut, report_plunges, verify, verify_flank};

use super::sampled_tool::{Dice, WheelPoints, collisions, with_random_assembly};

/// Largest share of the accessible floor that may remain uncut without a reason.
const MAX_UNCUT: f64 = 0.03;
/// The same with a reason.
const MAX_EXPLAINED_UNCUT: f64 = 0.15;
/// Largest difference of a figure between a plan and its program, which has six decimals.
const SAME: f64 = 5e-6;
/// Cells of the floor's grid.
const CELLS: usize = 128;

/// All faults of the plans of `part`, one line each. With `twice` it is planned again, for the same programs.
pub fn faults(part: &Impeller, twice: bool) -> Vec<String> {
    let mut faults = plunge_faults(part, twice);
    faults.extend(flank_faults(part, twice));
    faults
}

fn plunge_faults(part: &Impeller, twice: bool) -> Vec<String> {
    let setup = Setup::for_part(part);
    let request = |compare: bool| PlanRequest {
        part: part.clone().into(),
        setup: setup.clone(),
        policy: AxisPolicy::Minimal,
        compare,
        field_cells: CELLS,
    };
    let outcome = match run(&request(true), &Monitor::default()) {
        Ok(outcome) => outcome,
        Err(error) => return vec![format!("no plan: {error}")],
    };
    let mut faults = Vec::new();
    for result in outcome.policies() {
        judge(part, &outcome, result, &mut faults);
    }
    faults.extend(channel_faults(outcome.clone()));
    let again = || run(&request(false), &Monitor::default()).map(|again| program_text(part, &again.after));
    if twice && again().ok() != Some(program_text(part, &outcome.after)) {
        faults.push("minimal: planned twice, the programs differ".to_owned());
    }
    faults
}

/// Checks the program of several channels of the requested plan: how many, and in what order, differs from
/// wheel to wheel.
fn channel_faults(mut outcome: PlanOutcome) -> Vec<String> {
    let plan = &outcome.after.plan;
    let (drawn, blades) = (plan.positions.len(), outcome.workpiece.part.blade_count);
    let channels = blades.min(2 + drawn / 4 % 4);
    outcome.setup.channels =
        ChannelSetup { order: ChannelOrder::ALL[drawn % 2], sequence: ChannelSequence::ALL[drawn / 2 % 2] };
    let order = outcome.setup.channels;
    let loads = count_tool_loads(plan, order.order, channels);
    let place = format!("{channels} channels, {}", order.words());
    let program = outcome.program_for_channels(&outcome.after, channels, &Monitor::default());
    let text = write_apt(&program.expect("not cancelled"));
    let report =
        read_apt_bytes("plunge.apt", text.as_bytes()).map_err(|e| e.to_string()).and_then(|program| {
            let (workpiece, setup) = (&outcome.workpiece, &outcome.setup);
            report_plunges(workpiece, setup, &program, CELLS, &Monitor::default()).map_err(|e| e.to_string())
        });
    let report = match report {
        Ok(report) => report,
        Err(error) => return vec![format!("{place}: {error}")],
    };
    let mut faults = Vec::new();
    let (verdict, summary) = (&report.verdict, &report.summary);
    if let Some(fault) = verdict.faults.first() {
        faults.push(format!("{place}: {} faults, line {}: {fault}", verdict.faults.len(), fault.line));
    }
    for (what, found, wanted) in [
        ("channels", verdict.channels, channels),
        ("positions", summary.positions, channels * plan.positions.len()),
        ("tool loads", summary.tool_loads, loads),
    ] {
        if found != wanted {
            faults.push(format!("{place}: {found} {what}, {wanted} are planned"));
        }
    }
    faults
}

fn program_text(part: &Impeller, result: &PolicyResult) -> String {
    write_apt(&ClProgram::of_plan(&part.name, &result.plan))
}

/// Checks one plan and its written program.
fn judge(part: &Impeller, outcome: &PlanOutcome, result: &PolicyResult, faults: &mut Vec<String>) {
    let policy = result.plan.policy;
    let mut wrong = |what: String| faults.push(format!("{policy:?}: {what}"));
    let (summary, stock) = (&result.summary, &outcome.setup.allowances);
    if summary.positions == 0 {
        wrong("cuts nothing".to_owned());
    }
    // The other policies do not avoid interfering plunges.
    let is_free = matches!(policy, AxisPolicy::Minimal | AxisPolicy::Staircase);
    if is_free && summary.interfering > 0 {
        wrong(format!("{} plunges interfere", summary.interfering));
    }
    let clearances = [
        ("hub", summary.min_hub_clearance, stock.hub_allowance),
        ("blades", summary.min_blade_clearance, stock.blade_allowance),
        ("retract", summary.min_retract_clearance, stock.safety_distance),
    ];
    for (what, clearance, wanted) in clearances {
        if clearance < wanted - SAME {
            wrong(format!("{clearance} from the {what}, {wanted} is to be kept"));
        }
    }
    // `staircase` stops plunges above the hub on purpose.
    let stops_short = result.plan.positions.iter().any(|position| position.lift > 0.0);
    let explained = !result.plan.dropped.is_empty() || policy == AxisPolicy::Staircase && stops_short;
    if policy == AxisPolicy::Minimal && summary.uncut_share > MAX_EXPLAINED_UNCUT {
        wrong(format!("{:.3} of the reachable floor is uncut", summary.uncut_share));
    }
    if is_free && summary.uncut_share > MAX_UNCUT && !explained {
        wrong(format!("{:.3} of the reachable floor is uncut, and nothing says why", summary.uncut_share));
    }
    let program = match read_apt_bytes("plunge.apt", program_text(part, result).as_bytes()) {
        Ok(program) => program,
        Err(error) => return wrong(format!("its program is not readable: {error}")),
    };
    let verdict = match verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()) {
        Ok(verdict) => verdict,
        Err(fault) => return wrong(format!("its program cannot be judged: {fault}")),
    };
    if verdict.channels != 1 {
        wrong(format!("its program is found to work in {} channels", verdict.channels));
    }
    if let (true, Some(fault)) = (is_free, verdict.faults.first()) {
        wrong(format!("{} faults, line {}: {fault}", verdict.faults.len(), fault.line));
    }
    for ((name, planned), verified) in figures(summary).into_iter().zip(figures_of_cuts(&verdict.cuts)) {
        let same = (planned - verified).abs() <= SAME * planned.abs().max(1.0);
        if !(same || planned.is_nan() && verified.is_nan()) {
            wrong(format!("{name} is {planned} in the plan, {verified} in its program"));
        }
    }
}

/// The figures of plunges to be compared between plan and program; those of motion and floor are compared by
/// the tests of the command line.
fn figures(summary: &Summary) -> [(&'static str, f64); 5] {
    [
        ("positions", summary.positions as f64),
        ("interfering", summary.interfering as f64),
        ("contact depth", summary.max_contact_depth),
        ("hub clearance", summary.min_hub_clearance),
        ("blade clearance", summary.min_blade_clearance),
    ]
}

/// The same of the cuts of a program.
fn figures_of_cuts(cuts: &[JudgedCut]) -> [f64; 5] {
    let least = |of: fn(&JudgedCut) -> f64| cuts.iter().map(of).fold(f64::NAN, f64::min);
    [
        cuts.len() as f64,
        cuts.iter().filter(|cut| cut.contact.interferes()).count() as f64,
        cuts.iter().map(|cut| cut.contact.depth).fold(0.0, f64::max),
        least(|cut| cut.hub_clearance),
        least(|cut| cut.blade_clearance),
    ]
}

/// Most that a flank program cuts below the allowance of a blade, mm.
pub const MAX_OVERCUT: f64 = 0.005;

fn flank_faults(part: &Impeller, twice: bool) -> Vec<String> {
    let request = FlankRequest { part: part.clone().into(), setup: Setup::for_part(part) };
    let planned = || FlankJob::default().run(&request, &Monitor::default());
    let outcome = match planned() {
        Ok(outcome) => outcome,
        Err(error) => return vec![format!("no flank plan: {error}")],
    };
    let text = |outcome: &vanecut::job::flank::FlankOutcome| {
        let plan = &outcome.plan;
        write_apt(&ClProgram::of_flank(&part.name, &plan.tool, &plan.moves))
    };
    let mut faults = Vec::new();
    if twice && planned().ok().map(|again| text(&again)) != Some(text(&outcome)) {
        faults.push("flank: planned twice, the programs differ".to_owned());
    }
    let verdict = read_apt_bytes("flank.apt", text(&outcome).as_bytes())
        .map_err(|error| error.to_string())
        .and_then(|program| {
            verify_flank(
                &outcome.setup.allowances.workpiece_of(part.clone()),
                &outcome.setup,
                &program,
                &Monitor::default(),
            )
            .map_err(|fault| fault.to_string())
        });
    match verdict {
        Err(error) => faults.push(format!("flank: its program cannot be judged: {error}")),
        Ok(verdict) => {
            if let Some(fault) = verdict.faults.first() {
                faults.push(format!("flank: {} faults, line {}: {fault}", verdict.faults.len(), fault.line));
            }
            if verdict.max_overcut > MAX_OVERCUT {
                faults.push(format!("flank: {} mm overcut", verdict.max_overcut));
            }
        }
    }
    faults
}

/// What shanks and holders of random assemblies run into, by points of the wheel: in the plunge programs of
/// every policy, and in the flank programs of `schemes`, one line each.
pub fn assembly_faults(part: &Impeller, seed: u64, schemes: &[FlankStrategy]) -> Vec<String> {
    let mut dice = Dice::new(seed);
    let mut faults = Vec::new();
    let mut request = PlanRequest {
        part: part.clone().into(),
        setup: Setup::for_part(part),
        policy: AxisPolicy::Minimal,
        compare: true,
        field_cells: CELLS,
    };
    let workpiece = request.setup.allowances.workpiece_of(part.clone());
    let points = WheelPoints::from_workpiece(&workpiece);
    let chosen = match vanecut::job::resolve(&request.setup, &workpiece) {
        Ok(resolved) => resolved.setup,
        Err(fault) => return vec![format!("no tools: {fault}")],
    };
    request.setup.tools = chosen.tools.iter().map(|tool| with_random_assembly(tool, &mut dice)).collect();
    let tools = |tools: &[Tool]| format!("{:?}", tools.iter().map(|tool| &tool.assembly).collect::<Vec<_>>());
    match run(&request, &Monitor::default()) {
        // Where no tool reaches anything, that is said.
        Err(error) => faults.extend(unexplained(&error.to_string())),
        Ok(outcome) => {
            for result in outcome.policies() {
                let program = ClProgram::of_plan(&part.name, &result.plan);
                let found = collisions(&workpiece, &points, &outcome.setup, &program);
                let policy = result.plan.policy;
                faults.extend(found.into_iter().map(|what| format!("{policy:?}: {what}")));
            }
            if !faults.is_empty() {
                faults.push(tools(&outcome.setup.tools));
            }
        }
    }
    let setup = Setup::for_part(part);
    let ball =
        vanecut::flank::choice::choose_tool(&workpiece, &setup, vanecut::io::tool_library::flank_cutters());
    let Ok(ball) = ball else { return faults };
    let ball = with_random_assembly(&ball.tool, &mut dice);
    for &strategy in schemes {
        let mut setup = Setup { tools: vec![ball.clone()], ..setup.clone() };
        setup.flank.strategy = strategy;
        setup.flank.tool = Some(ball.number);
        let request = FlankRequest { part: part.clone().into(), setup };
        match FlankJob::default().run(&request, &Monitor::default()) {
            Err(error) => faults.extend(unexplained(&error.to_string())),
            Ok(outcome) => {
                let plan = &outcome.plan;
                let program = ClProgram::of_flank(&part.name, &plan.tool, &plan.moves);
                let program = program.after_opening(plan.opening.as_ref());
                let found = collisions(&workpiece, &points, &outcome.setup, &program);
                faults.extend(found.into_iter().map(|what| format!("{strategy:?}: {what}")));
            }
        }
    }
    if !faults.is_empty() {
        faults.push(tools(&[ball]));
    }
    faults
}

/// The message of a refusal, unless it says what to change about the tool.
fn unexplained(message: &str) -> Option<String> {
    let says = ["overhang", "holder", "shank", "cutter"].iter().any(|word| message.contains(word));
    (!says).then(|| format!("refused without naming a tool: {message}"))
}
