//! Checks flank milling programs along all their moves: gouges, collisions of cutter and holder, stock left
//! on walls and floor.
//!
//! Stock is tracked twice: over the floor of a channel by the heightfield, which resolves thin layers, and by
//! the solid, which holds everything else that stands.

mod examine;
mod findings;
mod gouge;
mod known;
mod standing;
mod steps;
mod stock;
mod uncovered;
mod verdict;
mod walls;

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::assembly::{
    AssemblyDistances, AssemblyStep, clearances, min_distances, segments_of, unjudged_tools,
};
use super::fault::{Fault, VerifyError};
use super::taper::judge_tapers;
use crate::cutting::assembly::AssemblySurroundings;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::setup::{Setup, Tool};
use crate::stock::solid::{Contact, ToolPart};
use crate::toolpath::ClProgram;
use examine::{StepResult, examine_step};
use gouge::{StepClearance, StepSurroundings};
use standing::StandingStock;
use steps::{CutterStep, floor_steps, steps_of};
use stock::{FloorCache, FloorResult, ProbeSample, SKIM_DEPTH, StockProbe, Sweep, evaluate_floor};
pub use uncovered::Uncovered;
pub use verdict::FlankVerdict;
use walls::wall_deviation;

/// Gouge below the hub's allowance that is tolerated, mm: linear moves between positions deviate a little.
const HUB_TOLERANCE: f64 = 1e-3;
/// The same at the blades, where the best fit of a cylinder to a twisted wall cuts up to 5 µm too deep.
const BLADE_TOLERANCE: f64 = 5e-3 + HUB_TOLERANCE;
/// The same for a planner, mm: below 5 µm by more than what a clearance along a move errs by.
const PLANNED_BLADE_TOLERANCE: f64 = 4.9e-3;
/// Height at which the flank of a cutter begins when its axis is tilted by 30°, in corner radii.
const TILTED_CORNER_RADII: f64 = 1.5;
/// Progress at which the moves, the floors and the solid stock are judged; the walls remain.
const DONE: [f64; 3] = [0.3, 0.5, 0.85];

/// Checks `program` against `workpiece` with the allowances of `setup`.
///
/// # Errors
/// When a cut cannot be checked because no tool with a diameter comes before it: the fault names the line;
/// when cancelled.
pub fn verify_flank(
    workpiece: &Workpiece,
    setup: &Setup,
    program: &ClProgram,
    monitor: &Monitor,
) -> Result<FlankVerdict, VerifyError> {
    FlankVerifier::with(workpiece, setup, Strictness::VERIFY, false).verdict(program, monitor)
}

/// Checks programs against one part, one after another; the result of each step is cached.
pub struct FlankVerifier<'a> {
    workpiece: &'a Workpiece,
    setup: &'a Setup,
    /// Whether another program may follow.
    keeps: bool,
    /// How far a cut may go below the allowance of a blade without being a fault, mm.
    blade_tolerance: f64,
    /// Search for contacts with stock that stands.
    standing: StandingStock,
    /// Width of the rim of a cutter whose stock does not count for the depth of a cut, mm.
    rim_tolerance: f64,
    /// The floor, once one was cut.
    floor: Option<FloorCache>,
    /// The tools of the last program, and the cache of steps with them.
    tools: Vec<Tool>,
    cache: HashMap<StepKey, StepResult>,
    last: Option<LastProgram>,
    /// Lines of rapids of the last program that come near to standing stock.
    grazing: Vec<usize>,
}

/// How close to its limits a program may come.
#[derive(Clone, Copy)]
struct Strictness {
    /// Share of what the solid does not resolve by which shanks and holders keep off stock.
    margin: f64,
    /// See [`FlankVerifier::rim_tolerance`].
    rim_tolerance: f64,
    /// See [`FlankVerifier::blade_tolerance`].
    blade_tolerance: f64,
}

impl Strictness {
    /// A planner's: what keeps to it does so after rounding too.
    const PLAN: Self = Self { margin: 1.0, rim_tolerance: 0.0, blade_tolerance: PLANNED_BLADE_TOLERANCE };
    const VERIFY: Self = Self { margin: 0.0, rim_tolerance: SKIM_DEPTH, blade_tolerance: BLADE_TOLERANCE };
}

/// What is known of the stock under the last program: a job first asks for its faults, then for its verdict.
struct LastProgram {
    /// Its steps, with their channels.
    steps: Vec<(StepKey, i64)>,
    floors: Option<Vec<(i64, Arc<FloorResult>)>>,
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

/// The keys of steps, with their channels.
fn keys_of(steps: &[CutterStep]) -> Vec<(StepKey, i64)> {
    steps.iter().map(|step| (step_key(step), step.channel)).collect()
}

fn step_key(step: &CutterStep) -> StepKey {
    let ((p, a), (q, b)) = (step.from, step.to);
    let all = [p.x, p.y, p.z, a.x, a.y, a.z, q.x, q.y, q.z, b.x, b.y, b.z];
    (step.tool, step.feed.is_some(), all.map(f64::to_bits))
}

impl<'a> FlankVerifier<'a> {
    /// A verifier of programs that cut `workpiece` with the allowances of `setup`.
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        Self::with(workpiece, setup, Strictness::VERIFY, true)
    }

    /// As [`Self::new`], for a planner, whose program is judged again after its numbers were rounded: shanks
    /// and holders keep off stock by what the solid does not resolve, so that a finer one finds nothing
    /// either, cuts are not too deep even at the rim of the cutter, and no blade is overcut by more than
    /// 5 µm.
    pub fn for_planner(workpiece: &'a Workpiece, setup: &'a Setup) -> Self {
        Self::with(workpiece, setup, Strictness::PLAN, true)
    }

    /// A verifier that `keeps` what another program may begin with, or judges one only.
    fn with(workpiece: &'a Workpiece, setup: &'a Setup, strictness: Strictness, keeps: bool) -> Self {
        let Strictness { margin, rim_tolerance, blade_tolerance } = strictness;
        let standing = StandingStock::new(margin, keeps);
        let (tools, cache) = (Vec::new(), HashMap::new());
        Self {
            workpiece,
            setup,
            keeps,
            blade_tolerance,
            standing,
            rim_tolerance,
            floor: None,
            tools,
            cache,
            last: None,
            grazing: Vec::new(),
        }
    }

    /// The faults of `program`, by line. The floor is cut only by a program whose moves have no faults
    /// themselves, and collisions with standing stock are searched for only in one without other faults. For
    /// planners, of whose work it is a part: it reports no progress.
    ///
    /// # Errors
    /// As [`verify_flank`].
    pub fn faults(&mut self, program: &ClProgram, monitor: &Monitor) -> Result<Vec<Fault>, VerifyError> {
        let monitor = &monitor.silent();
        let steps = self.examined_steps(program, monitor)?;
        if !steps.faults.is_empty() {
            return Ok(steps.faults);
        }
        let examined = self.with_floors(program, steps, monitor)?;
        if !examined.faults.is_empty() {
            return Ok(examined.faults);
        }
        Ok(self.faults_in_standing_stock(&examined.steps, monitor)?)
    }

    /// The complete verdict on `program`.
    ///
    /// # Errors
    /// As [`verify_flank`].
    pub fn verdict(&mut self, program: &ClProgram, monitor: &Monitor) -> Result<FlankVerdict, VerifyError> {
        let [moves_done, floors_done, solid_done] = DONE;
        let examined = self.examined_steps(program, &monitor.span(0.0, moves_done))?;
        let ExaminedProgram { steps, looks, channels, mut faults } =
            self.with_floors(program, examined, &monitor.span(moves_done, floors_done))?;
        for fault in self.faults_in_standing_stock(&steps, &monitor.span(floors_done, solid_done))? {
            if !faults.iter().any(|other| (other.line, other.kind) == (fault.line, fault.kind)) {
                faults.push(fault);
            }
        }
        faults.sort_by_key(|fault| fault.line);
        let distances = self.assembly_distances(&steps, &monitor.silent())?;
        let Self { workpiece, setup, tools, .. } = self;
        let mut verdict = FlankVerdict {
            channels: channels.len(),
            positions: steps.iter().filter(|s| s.feed.is_some()).count(),
            tools: tools.len(),
            tool_loads: program.tool_loads(),
            deepest_cut: channels
                .iter()
                .flat_map(|(_, floor)| &floor.depths)
                .map(|d| d.0)
                .fold(0.0, f64::max),
            assembly: distances,
            notes: unjudged_tools(program, setup).into_iter().collect(),
            faults,
            ..FlankVerdict::empty()
        };
        for (step, look) in steps.iter().zip(&looks) {
            verdict.add(step, look);
        }
        let closing = monitor.span(solid_done, 1.0);
        let count = closing.steps(channels.len());
        for (index, (number, floor)) in channels.iter().enumerate() {
            count.begin()?;
            let (uncovered, layer) = floor.figures(workpiece, setup, &closing)?;
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
                &closing,
            )?;
            verdict.max_overcut = verdict.max_overcut.max(walls.overcut);
            verdict.max_undercut = verdict.max_undercut.max(walls.undercut);
            if index == 0 || walls.unmilled_share > verdict.unmilled_wall_share {
                verdict.unmilled_wall_share = walls.unmilled_share;
                verdict.unmilled_walls = walls.unmilled_walls;
            }
            if index == 0 {
                verdict.walls = walls.maps;
            }
        }
        verdict.max_overcut =
            verdict.max_overcut.max(setup.allowances.blade_allowance - verdict.min_blade_clearance).max(0.0);
        Ok(verdict)
    }

    /// Least distances of shanks and holders that are given.
    fn assembly_distances(
        &self,
        steps: &[CutterStep],
        monitor: &Monitor,
    ) -> Result<AssemblyDistances, Cancelled> {
        let segments = segments_of(&self.tools);
        let has_assembly = |step: &&CutterStep| !segments[step.tool].is_empty();
        let moves: Vec<AssemblyStep> =
            steps.iter().filter(has_assembly).map(CutterStep::assembly_step).collect();
        let around = AssemblySurroundings::new(&self.workpiece.finished, self.setup);
        min_distances(&moves, &segments, &around, &[], monitor)
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
        let resolved = self.standing.resolved;
        let around =
            AssemblySurroundings::new(&self.workpiece.finished, self.setup).with_blank(&self.workpiece.blank);
        let grazes = |contact: &&Contact| contact.part == ToolPart::Cutter && contact.depth <= resolved;
        let fault = |contact: &Contact| {
            let step = &steps[contact.number as usize];
            let tool = &self.tools[step.tool];
            let overhang = standing::overhang_for(contact, tool, step, &around);
            standing::finding(contact, tool.number, overhang).at(step.line)
        };
        let faults = contacts.iter().filter(|contact| !grazes(contact)).map(fault).collect();
        self.grazing = contacts.iter().filter(grazes).map(|c| steps[c.number as usize].line).collect();
        if let Some(last) = &mut self.last {
            last.contacts = Some(contacts);
        }
        Ok(faults)
    }

    /// The steps of `program`; what is known of programs with other tools is forgotten.
    ///
    /// # Errors
    /// Those of [`steps_of`].
    fn steps_of(&mut self, program: &ClProgram) -> Result<Vec<CutterStep>, Fault> {
        let (steps, tools) = steps_of(&self.workpiece.part, &self.workpiece.channel, program, self.setup)?;
        if tools != self.tools {
            self.cache.clear();
            self.last = None;
            self.standing.forget();
            self.tools = tools;
        }
        self.grazing.clear();
        Ok(steps)
    }

    /// The steps of `program` with the faults of each by itself.
    fn examined_steps(
        &mut self,
        program: &ClProgram,
        monitor: &Monitor,
    ) -> Result<ExaminedSteps, VerifyError> {
        let steps = self.steps_of(program)?;
        let looks = self.examine_steps(&steps, monitor)?;
        let mut faults: Vec<Fault> = Vec::new();
        for (step, look) in steps.iter().zip(&looks) {
            faults.extend(self.faults_of(step, look));
        }
        faults.extend(judge_tapers(
            steps.iter().map(|step| (step.assembly_step(), step.line)),
            &self.tools,
            (&self.workpiece.finished, self.setup),
            [HUB_TOLERANCE, self.blade_tolerance],
            &monitor.silent(),
        )?);
        Ok(ExaminedSteps { steps, looks, faults })
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
            let ours = floor_steps(&self.workpiece.part, &steps, *number);
            let ours: Vec<&CutterStep> = ours.iter().map(|(_, step)| &**step).collect();
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
        let around = StepSurroundings {
            finished: &self.workpiece.finished,
            tools: &self.tools,
            hub_allowance: self.setup.allowances.hub_allowance,
            blade_allowance: self.setup.allowances.blade_allowance,
        };
        let (seen, blank) = (&self.cache, &self.workpiece.blank);
        let safety = self.setup.allowances.safety_distance;
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
        let is_known = |k: usize| known[k].is_some();
        let assembly = AssemblySurroundings::new(&self.workpiece.finished, self.setup);
        let moves: Vec<AssemblyStep> = steps.iter().map(CutterStep::assembly_step).collect();
        let assemblies = clearances(
            &moves,
            &self.tools,
            &segments_of(&self.tools),
            &assembly,
            is_known,
            &monitor.silent(),
        )?;
        let count = monitor.steps(steps.len());
        let looked = |k: usize| {
            count.begin()?;
            if let Some(known) = known[k] {
                return Ok(known.clone());
            }
            let before =
                k.checked_sub(1).filter(|&b| steps[b].tool == steps[k].tool && steps[b].to == steps[k].from);
            let ends = [before.and_then(|b| ends[b]), ends[k]];
            Ok(examine_step(&steps[k], ends, assemblies[k].least, &around, (blank, safety)))
        };
        let looks: Vec<StepResult> =
            (0..steps.len()).into_par_iter().map(looked).collect::<Result<_, Cancelled>>()?;
        let is_new: Vec<bool> = known.iter().map(Option::is_none).collect();
        let new = steps.iter().zip(&looks).zip(is_new).filter(|(_, is_new)| *is_new);
        self.cache.extend(new.map(|((step, look), _)| (step_key(step), look.clone())));
        Ok(looks)
    }

    /// The floors of all channels with cuts, after their steps.
    fn floors(
        &mut self,
        steps: &[CutterStep],
        looks: &[StepResult],
        monitor: &Monitor,
    ) -> Result<Vec<(i64, Arc<FloorResult>)>, Cancelled> {
        let keys = keys_of(steps);
        if let Some(LastProgram { steps: known, floors: Some(floors), .. }) = &self.last
            && *known == keys
        {
            return Ok(floors.clone());
        }
        let contacts = self.known_contacts(&keys);
        let mut numbers: Vec<i64> = steps.iter().filter(|s| s.feed.is_some()).map(|s| s.channel).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let count = monitor.steps(numbers.len());
        let floor = |number| {
            count.begin()?;
            Ok((number, Arc::new(self.floor(steps, looks, number))))
        };
        let floors: Vec<(i64, Arc<FloorResult>)> =
            numbers.into_iter().map(floor).collect::<Result<_, Cancelled>>()?;
        self.last = Some(LastProgram { steps: keys, floors: Some(floors.clone()), contacts });
        Ok(floors)
    }

    /// The floor of channel `number` after its steps.
    fn floor(&mut self, steps: &[CutterStep], looks: &[StepResult], number: i64) -> FloorResult {
        let here = floor_steps(&self.workpiece.part, steps, number);
        let ours: Vec<&CutterStep> = here.iter().map(|(_, step)| &**step).collect();
        let place = |(index, (k, _)): (usize, &(usize, Cow<CutterStep>))| {
            // A step of another channel is looked at in that.
            let look = Some(&looks[*k]).filter(|_| steps[*k].channel == number);
            let at = move |what: StockProbe| move |&share: &f64| ProbeSample { step: index, share, what };
            let rapids = look.iter().flat_map(|look| look.inside.iter().map(at(StockProbe::Rapid)));
            let holders = look.iter().flat_map(|look| look.holder_inside.iter().map(at(StockProbe::Holder)));
            rapids.chain(holders).collect::<Vec<_>>()
        };
        let places: Vec<ProbeSample> = here.iter().enumerate().flat_map(place).collect();
        let sweep = Sweep { tools: &self.tools, steps: &ours, places: &places, rim: self.rim_tolerance };
        evaluate_floor(self.workpiece, self.setup, &sweep, (&mut self.floor, self.keeps))
    }
}
