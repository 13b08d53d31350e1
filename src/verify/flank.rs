//! Checks flank milling programs along all their moves: gouges, collisions of cutter and holder, stock left
//! on walls and floor.
//!
//! Stock is tracked over the floor of a channel by the heightfield: stock beside walls that lean away from
//! the channel is above no cell of the floor, so the check of rapids does not include it.

mod gouge;
mod steps;
mod stock;
mod uncovered;
mod walls;

use std::collections::HashMap;

use rayon::prelude::*;

use super::fault::{
    Fault, FaultKind, Finding, beyond_machine, near_blade, near_hub, other_tool, rapid_near_blank,
    without_feed,
};
use super::too_deep;
use crate::formats::apt::{ClProgram, Motion, Move};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Channel, Impeller, Setup, Tool};
use crate::plunge::choice::estimate::RAPID_FEED;
use crate::plunge::clearance::FinishedPart;
use crate::plunge::retract::bottom_clearance;
use crate::residual::ResidualStatistics;
use gouge::{Clearance, Surroundings};
use steps::{Step, steps_of};
use stock::{Floor, Place, Probe, Struck, floor_after};
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
    pub max_axis_change: f64,
    /// Greatest overcut: cut below the blades' allowance, noses and blunt trailing edges included.
    pub max_overcut: f64,
    /// Greatest undercut: stock left on a wall above its allowance, where cutters come near to it; without
    /// noses, blunt trailing edges, and the foot of the wall that the tool corner does not reach.
    pub max_undercut: f64,
    /// Shares of the floor on which more is left than the setup's scallop height, of the channel with the
    /// most of it.
    pub uncovered: Uncovered,
    /// Residual stock on the floor of that channel.
    pub layer: ResidualStatistics,
    /// Deepest cut: height above the bottom of the cutter of the stock over the floor that it removes at
    /// once, mm.
    pub deepest_cut: f64,
    /// All faults, by line.
    pub faults: Vec<Fault>,
}

/// Gouge below the hub's allowance that is tolerated, mm: linear moves between positions deviate a little.
const HUB_TOLERANCE: f64 = 1e-3;
/// The same at the blades, where the best fit of a cylinder to a twisted wall cuts up to 5 µm too deep.
const BLADE_TOLERANCE: f64 = 5e-3 + HUB_TOLERANCE;
/// Height at which the flank of a cutter begins when its axis is tilted by 30°, in corner radii.
const LEANING_CORNER: f64 = 1.5;
/// Depth of a plausible cut, in layers of the setup.
const MOST_LAYERS: f64 = 4.0;
/// Depth of a plausible cut, in cutter diameters.
const MOST_DIAMETERS: f64 = 4.0;
/// Largest turn of the axis in one move under feed, rad: controllers may interpolate a larger one in another
/// manner than intended.
const MOST_TURN: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// Whether a program mills with the flank: most of its moves under feed do not plunge along the axis.
pub fn is_flank(program: &ClProgram) -> bool {
    let (mut along, mut across) = (0usize, 0usize);
    for pair in program.moves.windows(2) {
        if !matches!(pair[1].motion, Motion::Feed(_)) || pair[0].tool != pair[1].tool {
            continue;
        }
        let step = Step {
            line: 0,
            tool: 0,
            feed: None,
            channel: 0,
            from: (pair[0].tip, pair[0].axis),
            to: (pair[1].tip, pair[1].axis),
        };
        if step.is_axial() { along += 1 } else { across += 1 }
    }
    across > along
}

/// Checks `program` against `part` with the allowances of `setup`.
///
/// # Errors
/// When a cut cannot be checked because no tool with a diameter comes before it; the fault names the line.
pub fn verify_flank(
    part: &Impeller,
    channel: &Channel,
    setup: &Setup,
    program: &ClProgram,
) -> Result<FlankVerdict, Fault> {
    FlankVerifier::new(part, channel, setup).verdict(program)
}

/// Checks programs against one part, one after another; the result of each step is cached.
pub struct FlankVerifier<'a> {
    part: &'a Impeller,
    channel: &'a Channel,
    setup: &'a Setup,
    blank: Blank,
    finished: FinishedPart<'a>,
    /// The tools of the last program, and the cache of steps with them.
    tools: Vec<Tool>,
    seen: HashMap<StepKey, Look>,
}

/// The steps of a program with their results.
struct Examined {
    steps: Vec<Step>,
    looks: Vec<Look>,
    /// The floor of each channel with cuts.
    channels: Vec<(i64, Floor)>,
    faults: Vec<Fault>,
}

/// Cache key of a step: index of the tool, whether it is under feed, and the bits of both ends.
type StepKey = (usize, bool, [u64; 12]);

fn key(step: &Step) -> StepKey {
    let ((p, a), (q, b)) = (step.from, step.to);
    let all = [p.x, p.y, p.z, a.x, a.y, a.z, q.x, q.y, q.z, b.x, b.y, b.z];
    (step.tool, step.feed.is_some(), all.map(f64::to_bits))
}

impl<'a> FlankVerifier<'a> {
    /// A verifier of programs that cut `part` with the allowances of `setup`.
    pub fn new(part: &'a Impeller, channel: &'a Channel, setup: &'a Setup) -> Self {
        Self {
            part,
            channel,
            setup,
            blank: Blank::of(part, setup.stock.inlet_extension),
            finished: FinishedPart::new(part, &channel.sides),
            tools: Vec::new(),
            seen: HashMap::new(),
        }
    }

    /// The faults of `program`, by line; `Ok(Err(…))` when the work is cancelled.
    ///
    /// # Errors
    /// As [`verify_flank`].
    pub fn faults(
        &mut self,
        program: &ClProgram,
        monitor: &Monitor,
    ) -> Result<Result<Vec<Fault>, Cancelled>, Fault> {
        Ok(self.examined(program, monitor)?.map(|examined| examined.faults))
    }

    /// The complete verdict on `program`.
    ///
    /// # Errors
    /// As [`verify_flank`].
    pub fn verdict(&mut self, program: &ClProgram) -> Result<FlankVerdict, Fault> {
        // The default monitor never cancels.
        let Ok(Examined { steps, looks, channels, faults }) = self.examined(program, &Monitor::default())?
        else {
            return Ok(FlankVerdict::of_nothing());
        };
        let Self { part, channel, setup, blank, finished, tools, .. } = self;
        let mut verdict = FlankVerdict {
            channels: channels.len(),
            positions: steps.iter().filter(|s| s.feed.is_some()).count(),
            tools: tools.len(),
            deepest_cut: channels
                .iter()
                .flat_map(|(_, floor)| &floor.depths)
                .map(|d| d.0)
                .fold(0.0, f64::max),
            faults,
            ..FlankVerdict::of_nothing()
        };
        for (step, look) in steps.iter().zip(&looks) {
            verdict.add(step, look);
        }
        for (index, (number, floor)) in channels.iter().enumerate() {
            let (uncovered, layer) = floor.figures(finished, channel, blank, setup);
            if index == 0 || uncovered.share() > verdict.uncovered.share() {
                (verdict.uncovered, verdict.layer) = (uncovered, layer);
            }
            let cuts: Vec<&Step> =
                steps.iter().filter(|s| s.channel == *number && s.feed.is_some()).collect();
            let corner = cuts.iter().map(|s| tools[s.tool].corner_radius).fold(0.0, f64::max);
            // With a tilted axis the flank begins above the corner radius.
            let uncut = setup.stock.hub_allowance + LEANING_CORNER * corner;
            let walls = wall_deviation(part, channel, tools, &cuts, setup.stock.blade_allowance, uncut);
            verdict.max_overcut = verdict.max_overcut.max(walls.overcut);
            verdict.max_undercut = verdict.max_undercut.max(walls.undercut);
        }
        verdict.max_overcut =
            verdict.max_overcut.max(setup.stock.blade_allowance - verdict.min_blade_clearance).max(0.0);
        Ok(verdict)
    }

    fn examined(
        &mut self,
        program: &ClProgram,
        monitor: &Monitor,
    ) -> Result<Result<Examined, Cancelled>, Fault> {
        let (steps, tools) = steps_of(self.part, self.channel, program, self.setup)?;
        if tools != self.tools {
            self.seen.clear();
            self.tools = tools;
        }
        let looks = match self.looks(&steps, monitor) {
            Ok(looks) => looks,
            Err(cancelled) => return Ok(Err(cancelled)),
        };
        let mut faults: Vec<Fault> = Vec::new();
        for (step, look) in steps.iter().zip(&looks) {
            faults.extend(self.faults_of(step, look));
        }
        let mut numbers: Vec<i64> = steps.iter().filter(|s| s.feed.is_some()).map(|s| s.channel).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut channels = Vec::with_capacity(numbers.len());
        for number in numbers {
            if let Err(cancelled) = monitor.check() {
                return Ok(Err(cancelled));
            }
            let floor = self.floor(&steps, &looks, number);
            let ours: Vec<&Step> = steps.iter().filter(|s| s.channel == number).collect();
            faults.extend(floor.struck.iter().map(|struck| struck.fault(ours[struck.step].line)));
            faults.extend(floor.depths.iter().filter_map(|&(depth, step)| self.too_deep(depth, ours[step])));
            channels.push((number, floor));
        }
        faults.extend(self.senseless(program, &steps, &channels));
        faults.sort_by_key(|fault| fault.line);
        Ok(Ok(Examined { steps, looks, channels, faults }))
    }

    /// Results of all steps, from the cache where they are in it.
    fn looks(&mut self, steps: &[Step], monitor: &Monitor) -> Result<Vec<Look>, Cancelled> {
        let around = Surroundings {
            finished: &self.finished,
            tools: &self.tools,
            hub_allowance: self.setup.stock.hub_allowance,
            blade_allowance: self.setup.stock.blade_allowance,
        };
        let (seen, blank) = (&self.seen, &self.blank);
        let known: Vec<Option<&Look>> = steps.par_iter().map(|step| seen.get(&key(step))).collect();
        // Each end is evaluated once: the next step begins there.
        let ends: Vec<Option<Clearance>> = steps
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
            Ok(look(&steps[k], [before.and_then(|b| ends[b]), ends[k]], &around, blank))
        };
        let looks: Vec<Look> =
            (0..steps.len()).into_par_iter().map(looked).collect::<Result<_, Cancelled>>()?;
        self.seen.extend(steps.iter().zip(&looks).map(|(step, look)| (key(step), look.clone())));
        Ok(looks)
    }

    /// The floor of channel `number` after its steps.
    fn floor(&self, steps: &[Step], looks: &[Look], number: i64) -> Floor {
        let here: Vec<usize> = (0..steps.len()).filter(|&k| steps[k].channel == number).collect();
        let ours: Vec<&Step> = here.iter().map(|&k| &steps[k]).collect();
        let place = |(index, k): (usize, &usize)| {
            let look = &looks[*k];
            let at = move |what: Probe| move |&share: &f64| Place { step: index, share, what };
            let rapids = look.inside.iter().map(at(Probe::Rapid));
            rapids.chain(look.holder_inside.iter().map(at(Probe::Holder))).collect::<Vec<_>>()
        };
        let places: Vec<Place> = here.iter().enumerate().flat_map(place).collect();
        floor_after(&self.finished, self.channel, self.setup, &self.blank, &self.tools, &ours, &places)
    }

    /// The faults of a step.
    fn faults_of(&self, step: &Step, look: &Look) -> impl Iterator<Item = Fault> + use<> {
        let stock = &self.setup.stock;
        let Clearance { hub, blade, holder } = look.clearance;
        let turns = step.feed.is_some() && step.turn() > MOST_TURN;
        let found = [
            near_hub(hub, stock, HUB_TOLERANCE),
            near_blade(blade, stock, BLADE_TOLERANCE),
            holder.then(|| {
                let what = "the holder runs into a blade, its allowance, or the hub";
                Finding::new(FaultKind::HolderCollision, None, what)
            }),
            rapid_near_blank(look.retract, stock),
            beyond_machine(self.part, self.setup, &step.to.1),
            turns.then(|| {
                let turn = step.turn().to_degrees();
                let what = format!(
                    "turns the axis by {turn:.0}° in one move under feed; add intermediate positions"
                );
                Finding::new(FaultKind::AxisTurn, turn, what)
            }),
        ];
        let line = step.line;
        found.into_iter().flatten().map(move |finding| finding.at(line))
    }

    /// The fault of a cut `depth` mm deep, if any.
    fn too_deep(&self, depth: f64, step: &Step) -> Option<Fault> {
        let tool = &self.tools[step.tool];
        if depth > tool.overhang {
            return Some(too_deep(depth, tool).at(step.line));
        }
        (depth > most_depth(tool, self.setup)).then(|| too_thick(depth, tool, self.setup).at(step.line))
    }

    /// Faults of the program as a whole: nothing cut, no feed rate, tools that differ from those of the
    /// setup.
    fn senseless(&self, program: &ClProgram, steps: &[Step], channels: &[(i64, Floor)]) -> Vec<Fault> {
        let mut faults = Vec::new();
        if channels.iter().map(|(_, floor)| floor.removed).sum::<f64>() <= 0.0 {
            let first = steps.iter().find(|step| step.feed.is_some()).map_or(0, |step| step.line);
            let what = "the program cuts nothing of the part: no cut reaches stock over the floor; check its \
                        units and its origin";
            faults.push(Finding::new(FaultKind::CutsNothing, None, what).at(first));
        }
        let no_feed = |step: &&Move| step.tool.is_some() && step.motion == Motion::Feed(None);
        let without: Vec<usize> = program.moves.iter().filter(no_feed).map(|step| step.line).collect();
        faults.extend(without_feed(&without));
        for (index, tool) in self.tools.iter().enumerate() {
            let line = steps.iter().find(|step| step.tool == index).map(|step| step.line);
            faults.extend(line.and_then(|line| other_tool(line, tool, self.setup)));
        }
        faults
    }
}

/// The greatest plausible depth of a cut, mm: a few layers of the setup, or a few diameters of the cutter.
fn most_depth(tool: &Tool, setup: &Setup) -> f64 {
    (MOST_LAYERS * setup.flank.layer_depth).max(MOST_DIAMETERS * tool.diameter)
}

fn too_thick(depth: f64, tool: &Tool, setup: &Setup) -> Finding {
    let what = format!(
        "cuts {depth:.1} mm deep at once with a cutter of D {}; the layers of the setup are {} mm deep: cut \
         the layers above first",
        tool.diameter, setup.flank.layer_depth
    );
    Finding::new(FaultKind::TooDeep, depth, what)
}

impl Struck {
    /// The fault of the step at `line`.
    fn fault(&self, line: usize) -> Fault {
        let volume = self.volume;
        let (kind, what) = match self.what {
            Probe::Rapid => (
                FaultKind::RapidInStock,
                format!(
                    "moves in rapid through stock, about {volume:.0} mm³; remove it first, or move under \
                     feed"
                ),
            ),
            Probe::Holder => (
                FaultKind::HolderInStock,
                format!(
                    "the holder runs into remaining stock, about {volume:.0} mm³; remove it first, or give \
                     the tool more overhang"
                ),
            ),
        };
        Finding::new(kind, volume, what).at(line)
    }
}

/// Result of a step.
#[derive(Clone)]
struct Look {
    clearance: Clearance,
    /// At the end of a step under feed.
    end: Option<Clearance>,
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
fn look(step: &Step, ends: [Option<Clearance>; 2], around: &Surroundings, blank: &Blank) -> Look {
    let mut look = Look {
        clearance: Clearance::FAR,
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
    if step.length() == 0.0 && step.turn() == 0.0 || step.is_way_out() {
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
            look.clearance = look.clearance.and(around.at(step, share));
        } else if !axial {
            look.retract = look.retract.min(clearance);
        }
    }
    look
}

impl FlankVerdict {
    /// The verdict on a program without moves.
    fn of_nothing() -> Self {
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
            max_axis_change: 0.0,
            max_overcut: 0.0,
            max_undercut: f64::NAN,
            uncovered: Uncovered::default(),
            layer: ResidualStatistics::default(),
            deepest_cut: 0.0,
            faults: Vec::new(),
        }
    }

    fn add(&mut self, step: &Step, look: &Look) {
        let length = step.length();
        match step.feed {
            Some(feed) => {
                self.cut_length += length;
                self.time_estimate += length / feed.max(1e-6) * 60.0;
                self.max_axis_change = self.max_axis_change.max(step.turn());
                self.min_hub_clearance = self.min_hub_clearance.min(look.clearance.hub);
                self.min_blade_clearance = self.min_blade_clearance.min(look.clearance.blade);
            }
            None => {
                self.rapid_length += length;
                self.time_estimate += length / RAPID_FEED * 60.0;
                self.min_retract_clearance = self.min_retract_clearance.min(look.retract);
            }
        }
    }
}
