//! Checks flank milling programs along all their moves: gouges, collisions of cutter and holder, stock left
//! on walls and floor.
//!
//! Stock is tracked twice: over the floor of a channel by the heightfield, which resolves thin layers, and by
//! the solid, which holds everything else that stands.

mod gouge;
mod standing;
mod steps;
mod stock;
mod uncovered;
mod walls;

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::assembly::{AssemblyDistances, assembly_findings, unknown_assemblies};
use super::fault::{
    Fault, FaultKind, Finding, beyond_machine, missing_feed, near_blade, near_hub, rapid_near_blank,
    stopped_spindle, tool_mismatch,
};
use super::too_deep;
use crate::cutting::assembly::{AssemblyClearance, AssemblySurroundings};
use crate::cutting::retract::bottom_clearance;
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Workpiece};
use crate::setup::{Setup, Tool};
use crate::stock::ResidualStatistics;
use crate::stock::solid::Contact;
use crate::toolpath::RAPID_MM_PER_MIN;
use crate::toolpath::{ClProgram, Motion, Move};
use gouge::{StepClearance, StepSurroundings};
use standing::StandingStock;
use steps::{CutterStep, steps_of};
use stock::{FloorCache, FloorResult, ProbeSample, StockCollision, StockProbe, evaluate_floor};
pub use uncovered::Uncovered;
use walls::wall_deviation;

/// Result of checking a flank program. Lengths mm; NaN where there is nothing to measure.
#[derive(Clone, Debug)]
pub struct FlankVerdict {
    /// Number of channels with cuts.
    pub channels: usize,
    /// Number of moves under feed.
    pub positions: usize,
    /// Number of tools used.
    pub tools: usize,
    /// Cutting length, and rapid length.
    pub cut_length: f64,
    /// See `cut_length`.
    pub rapid_length: f64,
    /// Estimated time, s, without tool changes and accelerations.
    pub time_estimate: f64,
    /// Least distance of the cutter to the finished hub, capped at 1 mm above the allowance.
    pub min_hub_clearance: f64,
    /// The same to the blades.
    pub min_blade_clearance: f64,
    /// Least distance of the bottom to the blank in rapids across it.
    pub min_retract_clearance: f64,
    /// Greatest turn of the axis in one move under feed, rad.
    pub max_axis_change_rad: f64,
    /// Greatest overcut: cut below the blades' allowance, noses and blunt trailing edges included.
    pub max_overcut: f64,
    /// Greatest undercut: stock left on a wall above its allowance, where cutters come near to it; without
    /// noses, blunt trailing edges, and the foot of the wall that the tool corner does not reach.
    pub max_undercut: f64,
    /// Share of the walls to which no cutter comes near, of the channel with the most of it, 0…1.
    pub unmilled_wall_share: f64,
    /// Shares of the floor on which more is left than the setup's scallop height, of the channel with the
    /// most of it.
    pub uncovered: Uncovered,
    /// Residual stock on the floor of that channel.
    pub layer: ResidualStatistics,
    /// Deepest cut: height above the bottom of the cutter of the stock over the floor that it removes at
    /// once, mm.
    pub deepest_cut: f64,
    /// Least distances of shank and holder to the finished part.
    pub assembly: AssemblyDistances,
    /// Remarks that are not faults.
    pub notes: Vec<String>,
    /// All faults, by line.
    pub faults: Vec<Fault>,
}

/// Gouge below the hub's allowance that is tolerated, mm: linear moves between positions deviate a little.
const HUB_TOLERANCE: f64 = 1e-3;
/// The same at the blades, where the best fit of a cylinder to a twisted wall cuts up to 5 µm too deep.
const BLADE_TOLERANCE: f64 = 5e-3 + HUB_TOLERANCE;
/// Height at which the flank of a cutter begins when its axis is tilted by 30°, in corner radii.
const TILTED_CORNER_RADII: f64 = 1.5;
/// Depth of a plausible cut, in layers of the setup.
const MAX_LAYERS: f64 = 4.0;
/// Depth of a plausible cut, in cutter diameters.
const MAX_DIAMETERS: f64 = 4.0;
/// Largest turn of the axis in one move under feed, rad: controllers may interpolate a larger one in another
/// manner than intended.
const MAX_TURN_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// Checks `program` against `workpiece` with the allowances of `setup`.
///
/// # Errors
/// When a cut cannot be checked because no tool with a diameter comes before it; the fault names the line.
pub fn verify_flank(
    workpiece: &Workpiece,
    setup: &Setup,
    program: &ClProgram,
) -> Result<FlankVerdict, Fault> {
    FlankVerifier::new(workpiece, setup).verdict(program)
}

/// Checks programs against one part, one after another; the result of each step is cached.
pub struct FlankVerifier<'a> {
    workpiece: &'a Workpiece,
    setup: &'a Setup,
    /// Search for contacts with stock that stands.
    standing: StandingStock,
    /// The floor, once one was cut.
    floor: Option<FloorCache>,
    /// The tools of the last program, and the cache of steps with them.
    tools: Vec<Tool>,
    cache: HashMap<StepKey, StepResult>,
    last: Option<LastProgram>,
}

/// What is known of the stock under the last program: a job first asks for its faults, then for its verdict.
struct LastProgram {
    /// Its steps, with their channels.
    steps: Vec<(StepKey, i64)>,
    floors: Vec<(i64, Arc<FloorResult>)>,
    /// Contacts with stock that stands, once they have been searched for.
    contacts: Option<Vec<Contact>>,
}

/// The steps of a program with their results.
struct ExaminedSteps {
    steps: Vec<CutterStep>,
    looks: Vec<StepResult>,
    faults: Vec<Fault>,
}

/// The steps of a program with their results, and what they leave.
struct ExaminedProgram {
    steps: Vec<CutterStep>,
    looks: Vec<StepResult>,
    /// The floor of each channel with cuts.
    channels: Vec<(i64, Arc<FloorResult>)>,
    faults: Vec<Fault>,
}

/// Cache key of a step: index of the tool, whether it is under feed, and the bits of both ends.
type StepKey = (usize, bool, [u64; 12]);

fn step_key(step: &CutterStep) -> StepKey {
    let ((p, a), (q, b)) = (step.from, step.to);
    let all = [p.x, p.y, p.z, a.x, a.y, a.z, q.x, q.y, q.z, b.x, b.y, b.z];
    (step.tool, step.feed.is_some(), all.map(f64::to_bits))
}

impl<'a> FlankVerifier<'a> {
    /// A verifier of programs that cut `workpiece` with the allowances of `setup`.
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        Self::with_holder_margin(workpiece, setup, 0.0)
    }

    /// As [`Self::new`], for a planner: holders keep off stock by what the solid does not resolve, so that a
    /// finer one finds nothing either.
    pub fn for_planner(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        Self::with_holder_margin(workpiece, setup, 1.0)
    }

    fn with_holder_margin(workpiece: &'a Workpiece, setup: &'a Setup, holder_margin: f64) -> Self {
        let standing = StandingStock::new(holder_margin);
        let (tools, cache) = (Vec::new(), HashMap::new());
        Self { workpiece, setup, standing, floor: None, tools, cache, last: None }
    }

    /// The faults of `program`, by line; `Ok(Err(…))` when the work is cancelled. The floor is cut only by a
    /// program whose moves have no faults themselves, and collisions with standing stock are searched for
    /// only in one without other faults.
    ///
    /// # Errors
    /// As [`verify_flank`].
    pub fn faults(
        &mut self,
        program: &ClProgram,
        monitor: &Monitor,
    ) -> Result<Result<Vec<Fault>, Cancelled>, Fault> {
        let steps = match self.examined_steps(program, monitor)? {
            Ok(steps) => steps,
            Err(cancelled) => return Ok(Err(cancelled)),
        };
        if !steps.faults.is_empty() {
            return Ok(Ok(steps.faults));
        }
        let examined = match self.with_floors(program, steps, monitor) {
            Ok(examined) => examined,
            Err(cancelled) => return Ok(Err(cancelled)),
        };
        if !examined.faults.is_empty() {
            return Ok(Ok(examined.faults));
        }
        Ok(self.faults_in_standing_stock(&examined.steps, monitor))
    }

    /// The complete verdict on `program`.
    ///
    /// # Errors
    /// As [`verify_flank`].
    pub fn verdict(&mut self, program: &ClProgram) -> Result<FlankVerdict, Fault> {
        // The default monitor never cancels.
        let monitor = Monitor::default();
        let examined = self.examined_steps(program, &monitor)?;
        let Ok(ExaminedProgram { steps, looks, channels, mut faults }) =
            examined.and_then(|steps| self.with_floors(program, steps, &monitor))
        else {
            return Ok(FlankVerdict::empty());
        };
        for fault in self.faults_in_standing_stock(&steps, &monitor).unwrap_or_default() {
            if !faults.iter().any(|other| (other.line, other.kind) == (fault.line, fault.kind)) {
                faults.push(fault);
            }
        }
        faults.sort_by_key(|fault| fault.line);
        let Self { workpiece, setup, tools, .. } = self;
        let mut verdict = FlankVerdict {
            channels: channels.len(),
            positions: steps.iter().filter(|s| s.feed.is_some()).count(),
            tools: tools.len(),
            deepest_cut: channels
                .iter()
                .flat_map(|(_, floor)| &floor.depths)
                .map(|d| d.0)
                .fold(0.0, f64::max),
            notes: unknown_assemblies(program, setup).into_iter().collect(),
            faults,
            ..FlankVerdict::empty()
        };
        for (step, look) in steps.iter().zip(&looks) {
            verdict.add(step, look);
        }
        for (index, (number, floor)) in channels.iter().enumerate() {
            let (uncovered, layer) = floor.figures(workpiece, setup);
            if index == 0 || uncovered.share() > verdict.uncovered.share() {
                (verdict.uncovered, verdict.layer) = (uncovered, layer);
            }
            let cuts: Vec<&CutterStep> =
                steps.iter().filter(|s| s.channel == *number && s.feed.is_some()).collect();
            let corner = cuts.iter().map(|s| tools[s.tool].corner_radius).fold(0.0, f64::max);
            // With a tilted axis the flank begins above the corner radius.
            let uncut = setup.allowances.hub_allowance + TILTED_CORNER_RADII * corner;
            let walls = wall_deviation(
                &workpiece.part,
                &workpiece.channel,
                tools,
                &cuts,
                setup.allowances.blade_allowance,
                uncut,
            );
            verdict.max_overcut = verdict.max_overcut.max(walls.overcut);
            verdict.max_undercut = verdict.max_undercut.max(walls.undercut);
            verdict.unmilled_wall_share = verdict.unmilled_wall_share.max(walls.unmilled_share);
        }
        verdict.max_overcut =
            verdict.max_overcut.max(setup.allowances.blade_allowance - verdict.min_blade_clearance).max(0.0);
        Ok(verdict)
    }

    /// The faults where cutters in rapid, shanks and holders meet stock that stands: of the program that was
    /// examined last.
    fn faults_in_standing_stock(
        &mut self,
        steps: &[CutterStep],
        monitor: &Monitor,
    ) -> Result<Vec<Fault>, Cancelled> {
        let known = self.last.as_mut().and_then(|last| last.contacts.take());
        let contacts = match known {
            Some(known) => known,
            None => {
                let Workpiece { part, blank, .. } = self.workpiece;
                self.standing.collisions(part, blank, &self.tools, steps, monitor)?
            }
        };
        let fault = |contact: &Contact| {
            let step = &steps[contact.number as usize];
            standing::finding(contact, self.tools[step.tool].number).at(step.line)
        };
        let faults = contacts.iter().map(fault).collect();
        if let Some(last) = &mut self.last {
            last.contacts = Some(contacts);
        }
        Ok(faults)
    }

    /// The steps of `program` with the faults of each by itself.
    fn examined_steps(
        &mut self,
        program: &ClProgram,
        monitor: &Monitor,
    ) -> Result<Result<ExaminedSteps, Cancelled>, Fault> {
        let (steps, tools) = steps_of(&self.workpiece.part, &self.workpiece.channel, program, self.setup)?;
        if tools != self.tools {
            self.cache.clear();
            self.last = None;
            self.standing.forget();
            self.tools = tools;
        }
        let looks = match self.examine_steps(&steps, monitor) {
            Ok(looks) => looks,
            Err(cancelled) => return Ok(Err(cancelled)),
        };
        let mut faults: Vec<Fault> = Vec::new();
        for (step, look) in steps.iter().zip(&looks) {
            faults.extend(self.faults_of(step, look));
        }
        Ok(Ok(ExaminedSteps { steps, looks, faults }))
    }

    /// Adds the floors of a program, and the faults found there, to its examined steps.
    fn with_floors(
        &mut self,
        program: &ClProgram,
        ExaminedSteps { steps, looks, mut faults }: ExaminedSteps,
        monitor: &Monitor,
    ) -> Result<ExaminedProgram, Cancelled> {
        let channels = self.floors(&steps, &looks, monitor)?;
        for (number, floor) in &channels {
            let ours: Vec<&CutterStep> = steps.iter().filter(|s| s.channel == *number).collect();
            faults.extend(floor.collisions.iter().map(|struck| struck.fault(ours[struck.step].line)));
            faults.extend(floor.depths.iter().filter_map(|&(depth, step)| self.too_deep(depth, ours[step])));
        }
        faults.extend(self.program_faults(program, &steps, &channels));
        faults.sort_by_key(|fault| fault.line);
        Ok(ExaminedProgram { steps, looks, channels, faults })
    }

    /// Results of all steps, from the cache where they are in it.
    fn examine_steps(
        &mut self,
        steps: &[CutterStep],
        monitor: &Monitor,
    ) -> Result<Vec<StepResult>, Cancelled> {
        let segments: Vec<_> = self.tools.iter().map(|tool| tool.assembly.segments(tool.overhang)).collect();
        let around = StepSurroundings {
            finished: &self.workpiece.finished,
            tools: &self.tools,
            assembly: AssemblySurroundings::new(&self.workpiece.finished, self.setup),
            segments: &segments,
            hub_allowance: self.setup.allowances.hub_allowance,
            blade_allowance: self.setup.allowances.blade_allowance,
        };
        let (seen, blank) = (&self.cache, &self.workpiece.blank);
        let known: Vec<Option<&StepResult>> =
            steps.par_iter().map(|step| seen.get(&step_key(step))).collect();
        // Each end is evaluated once: the next step begins there.
        let ends: Vec<Option<StepClearance>> = steps
            .par_iter()
            .zip(&known)
            .map(|(step, known)| match known {
                _ if step.feed.is_none() => Ok(None),
                Some(known) => Ok(known.end),
                None => monitor.check().map(|()| Some(around.at(step, 1.0))),
            })
            .collect::<Result<_, Cancelled>>()?;
        let looked = |k: usize| {
            if let Some(known) = known[k] {
                return Ok(known.clone());
            }
            monitor.check()?;
            let before =
                k.checked_sub(1).filter(|&b| steps[b].tool == steps[k].tool && steps[b].to == steps[k].from);
            Ok(examine_step(&steps[k], [before.and_then(|b| ends[b]), ends[k]], &around, blank))
        };
        let looks: Vec<StepResult> =
            (0..steps.len()).into_par_iter().map(looked).collect::<Result<_, Cancelled>>()?;
        self.cache.extend(steps.iter().zip(&looks).map(|(step, look)| (step_key(step), look.clone())));
        Ok(looks)
    }

    /// The floors of all channels with cuts, after their steps.
    fn floors(
        &mut self,
        steps: &[CutterStep],
        looks: &[StepResult],
        monitor: &Monitor,
    ) -> Result<Vec<(i64, Arc<FloorResult>)>, Cancelled> {
        let keys: Vec<(StepKey, i64)> = steps.iter().map(|step| (step_key(step), step.channel)).collect();
        if let Some(last) = self.last.as_ref().filter(|last| last.steps == keys) {
            return Ok(last.floors.clone());
        }
        let mut numbers: Vec<i64> = steps.iter().filter(|s| s.feed.is_some()).map(|s| s.channel).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let floor = |number| {
            monitor.check()?;
            Ok((number, Arc::new(self.floor(steps, looks, number))))
        };
        let floors: Vec<(i64, Arc<FloorResult>)> =
            numbers.into_iter().map(floor).collect::<Result<_, Cancelled>>()?;
        self.last = Some(LastProgram { steps: keys, floors: floors.clone(), contacts: None });
        Ok(floors)
    }

    /// The floor of channel `number` after its steps.
    fn floor(&mut self, steps: &[CutterStep], looks: &[StepResult], number: i64) -> FloorResult {
        let here: Vec<usize> = (0..steps.len()).filter(|&k| steps[k].channel == number).collect();
        let ours: Vec<&CutterStep> = here.iter().map(|&k| &steps[k]).collect();
        let place = |(index, k): (usize, &usize)| {
            let look = &looks[*k];
            let at = move |what: StockProbe| move |&share: &f64| ProbeSample { step: index, share, what };
            let rapids = look.inside.iter().map(at(StockProbe::Rapid));
            rapids.chain(look.holder_inside.iter().map(at(StockProbe::Holder))).collect::<Vec<_>>()
        };
        let places: Vec<ProbeSample> = here.iter().enumerate().flat_map(place).collect();
        evaluate_floor(self.workpiece, self.setup, &self.tools, &ours, &places, &mut self.floor)
    }

    /// The faults of a step.
    fn faults_of(&self, step: &CutterStep, look: &StepResult) -> impl Iterator<Item = Fault> + use<> {
        let stock = &self.setup.allowances;
        let StepClearance { hub, blade, holder } = look.clearance;
        let turns = step.feed.is_some() && step.turn() > MAX_TURN_RAD;
        let found = [
            near_hub(hub, stock, HUB_TOLERANCE),
            near_blade(blade, stock, BLADE_TOLERANCE),
            holder.then(|| {
                let what = "the holder runs into a blade, its allowance, or the hub";
                Finding::new(FaultKind::HolderCollision, None, what)
            }),
            rapid_near_blank(look.retract, stock),
            beyond_machine(&self.workpiece.part, self.setup, &step.to.1),
            turns.then(|| {
                let turn = step.turn().to_degrees();
                let what = format!("turns the axis by {turn:.0}° in one move under feed");
                Finding::new(FaultKind::AxisTurn, turn, what).with_help("add intermediate positions")
            }),
        ];
        let around = AssemblySurroundings::new(&self.workpiece.finished, self.setup);
        let assembly = assembly_findings(&self.tools[step.tool], &look.assembly, &around);
        let line = step.line;
        found.into_iter().flatten().chain(assembly).map(move |finding| finding.at(line))
    }

    /// The fault of a cut `depth` mm deep, if any.
    fn too_deep(&self, depth: f64, step: &CutterStep) -> Option<Fault> {
        let tool = &self.tools[step.tool];
        if depth > tool.overhang {
            return Some(too_deep(depth, tool).at(step.line));
        }
        (depth > max_plausible_depth(tool, self.setup))
            .then(|| too_thick(depth, tool, self.setup).at(step.line))
    }

    /// Faults of the program as a whole: nothing cut, no feed rate, tools that differ from those of the
    /// setup.
    fn program_faults(
        &self,
        program: &ClProgram,
        steps: &[CutterStep],
        channels: &[(i64, Arc<FloorResult>)],
    ) -> Vec<Fault> {
        let mut faults = Vec::new();
        if channels.iter().map(|(_, floor)| floor.removed).sum::<f64>() <= 0.0 {
            let first = steps.iter().find(|step| step.feed.is_some()).map_or(0, |step| step.line);
            let what = "the program cuts nothing of the part: no cut reaches stock over the floor";
            let finding = Finding::new(FaultKind::CutsNothing, None, what);
            faults.push(finding.with_help("check its units and its origin").at(first));
        }
        let no_feed = |step: &&Move| step.tool.is_some() && step.motion == Motion::Feed(None);
        let without: Vec<usize> = program.moves.iter().filter(no_feed).map(|step| step.line).collect();
        faults.extend(missing_feed(&without));
        let cuts = steps.iter().filter(|step| step.feed.is_some()).map(|step| step.line);
        faults.extend(stopped_spindle(cuts, &program.stopped_spindle_lines));
        for (index, tool) in self.tools.iter().enumerate() {
            let line = steps.iter().find(|step| step.tool == index).map(|step| step.line);
            faults.extend(line.and_then(|line| tool_mismatch(line, tool, self.setup)));
        }
        faults
    }
}

/// The greatest plausible depth of a cut, mm: a few layers of the setup, or a few diameters of the cutter.
fn max_plausible_depth(tool: &Tool, setup: &Setup) -> f64 {
    (MAX_LAYERS * setup.flank.layer_depth).max(MAX_DIAMETERS * tool.diameter)
}

fn too_thick(depth: f64, tool: &Tool, setup: &Setup) -> Finding {
    let what = format!(
        "cuts {depth:.1} mm deep at once with a cutter of D {}, but the layers of the setup are {} mm deep",
        tool.diameter, setup.flank.layer_depth
    );
    Finding::new(FaultKind::TooDeep, depth, what).with_help("cut the layers above first")
}

impl StockCollision {
    /// The fault of the step at `line`.
    fn fault(&self, line: usize) -> Fault {
        let volume = self.volume;
        let (kind, what, help) = match self.what {
            StockProbe::Rapid => (
                FaultKind::RapidInStock,
                format!("moves in rapid through stock, about {volume:.0} mm³"),
                "remove it first, or move under feed",
            ),
            StockProbe::Holder => (
                FaultKind::HolderInStock,
                format!("the holder runs into remaining stock, about {volume:.0} mm³"),
                "remove it first, or give the tool more overhang",
            ),
        };
        Finding::new(kind, None, what).with_help(help).at(line)
    }
}

/// Result of a step.
#[derive(Clone)]
struct StepResult {
    clearance: StepClearance,
    /// Of shank and holder that are given.
    assembly: AssemblyClearance,
    /// At the end of a step under feed.
    end: Option<StepClearance>,
    /// Least distance to the blank of a rapid that is not along the axis, where it is outside the blank, mm;
    /// infinite for other steps.
    retract: f64,
    /// Parameters 0…1 along a rapid at which it is inside the outline of the blank.
    inside: Vec<f64>,
    /// The same of the holder, under feed.
    holder_inside: Vec<f64>,
}

/// Examines a step: under feed for the clearance of the cut, in rapid for collisions. `ends` are the
/// clearances at both ends, where they are known.
fn examine_step(
    step: &CutterStep,
    ends: [Option<StepClearance>; 2],
    around: &StepSurroundings,
    blank: &Blank,
) -> StepResult {
    let mut look = StepResult {
        clearance: StepClearance::FAR,
        assembly: around.assembly_along(step),
        end: ends[1],
        retract: f64::INFINITY,
        inside: Vec::new(),
        holder_inside: Vec::new(),
    };
    if step.feed.is_some() {
        look.clearance = around.along(step, ends);
        let tool = &around.tools[step.tool];
        let within = |share: &f64| {
            let (tip, axis) = step.at(*share);
            bottom_clearance(&tool.holder(tip, axis), blank) < 0.0
        };
        // The holder is far above the cut: its middle and end represent the whole step.
        look.holder_inside = [0.5, 1.0].into_iter().filter(within).collect();
        return look;
    }
    // Retracting along its own axis, a cutter meets nothing that it has not cut.
    if step.length() == 0.0 && step.turn() == 0.0 || step.is_retract() {
        return look;
    }
    let radius = around.tools[step.tool].radius();
    let samples = (step.length() / (0.5 * radius)).max(step.turn() / 0.02).ceil().clamp(1.0, 400.0);
    let axial = step.is_axial();
    for k in 0..=samples as usize {
        let share = k as f64 / samples;
        let clearance = bottom_clearance(&step.cutter(around.tools, share), blank);
        if clearance < 0.0 {
            look.inside.push(share);
            look.clearance = look.clearance.worst_of(around.at(step, share));
        } else if !axial {
            look.retract = look.retract.min(clearance);
        }
    }
    look
}

impl FlankVerdict {
    /// The verdict on a program without moves.
    fn empty() -> Self {
        Self {
            channels: 0,
            positions: 0,
            tools: 0,
            cut_length: 0.0,
            rapid_length: 0.0,
            time_estimate: 0.0,
            min_hub_clearance: f64::NAN,
            min_blade_clearance: f64::NAN,
            min_retract_clearance: f64::NAN,
            max_axis_change_rad: 0.0,
            max_overcut: 0.0,
            max_undercut: f64::NAN,
            unmilled_wall_share: 0.0,
            uncovered: Uncovered::default(),
            layer: ResidualStatistics::default(),
            deepest_cut: 0.0,
            assembly: AssemblyDistances::NONE,
            notes: Vec::new(),
            faults: Vec::new(),
        }
    }

    fn add(&mut self, step: &CutterStep, look: &StepResult) {
        let length = step.length();
        self.assembly.add(&look.assembly);
        match step.feed {
            Some(feed) => {
                self.cut_length += length;
                self.time_estimate += length / feed.max(1e-6) * 60.0;
                self.max_axis_change_rad = self.max_axis_change_rad.max(step.turn());
                self.min_hub_clearance = self.min_hub_clearance.min(look.clearance.hub);
                self.min_blade_clearance = self.min_blade_clearance.min(look.clearance.blade);
            }
            None => {
                self.rapid_length += length;
                self.time_estimate += length / RAPID_MM_PER_MIN * 60.0;
                self.min_retract_clearance = self.min_retract_clearance.min(look.retract);
            }
        }
    }
}
