//! Shank and holder of every move against the finished part, and against stock where a plunge ends.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::fault::{Fault, FaultKind, Finding};
use super::plunges::ProgramCut;
use crate::cutting::assembly::{AssemblyClearance, AssemblySurroundings, part_in_stock};
use crate::cutting::assembly_move::AssemblyMove;
use crate::cutting::assembly_path::PathClearance;
use crate::cutting::contact::Columns;
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::{AssemblyPart, AssemblySegment, Setup, Tool};
use crate::toolpath::{ClProgram, Move};

/// Moves that one thread looks at one after another.
const STEPS_IN_RUN: usize = 128;
/// Distance beyond the least one so far up to which distances are measured, mm: what is further off need not
/// be looked at again until the tool has moved by this.
const DISTANCE_AHEAD: f64 = 4.0;
/// Largest way of any point of a tool between two places at which distances are compared, mm, and largest
/// number of these places in a move.
const DISTANCE_SPACING: f64 = 0.25;
const MAX_PIECES: f64 = 4000.0;

/// Least distances of shank and holder to the finished part over a program, mm; infinite where no tool has
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssemblyDistances {
    /// Of the shank.
    pub shank: f64,
    /// Of the holder.
    pub holder: f64,
}

impl AssemblyDistances {
    /// Without any shank or holder.
    pub const NONE: Self = Self { shank: f64::INFINITY, holder: f64::INFINITY };
}

/// The faults of a move with these clearances of its tool.
pub(super) fn assembly_findings(
    tool: &Tool,
    clearance: &AssemblyClearance,
    around: &AssemblySurroundings,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if clearance.shank.collides() {
        let what = format!(
            "the shank of tool {} comes within {:.3} mm of the part: {:.3} mm short of allowance and \
             clearance",
            tool.number, clearance.shank.distance, clearance.shank.missing
        );
        let finding = Finding::new(FaultKind::ShankCollision, clearance.shank.missing, what);
        findings.push(finding.with_help("give a thinner shank, or a smaller clearance"));
    }
    if clearance.holder.collides() {
        let only = (!clearance.shank.collides()).then_some(clearance.worst).flatten();
        let overhang = only.and_then(|pose| around.stick_out(tool, pose, f64::INFINITY));
        let help = match overhang {
            Some(overhang) => format!("an overhang of {overhang} mm would do, instead of {}", tool.overhang),
            None => "no longer overhang frees it: tilt the axis, or give a thinner holder".to_owned(),
        };
        let what = format!(
            "the holder of tool {} comes within {:.3} mm of the part: {:.3} mm short of allowance and \
             clearance",
            tool.number, clearance.holder.distance, clearance.holder.missing
        );
        let finding = Finding::new(FaultKind::HolderCollision, clearance.holder.missing, what);
        findings.push(finding.with_help(help).with_overhang(overhang));
    }
    findings
}

/// A move of a tool with shank or holder, by the number of the tool.
#[derive(Clone, Copy)]
pub(super) struct AssemblyStep {
    pub(super) tool: usize,
    pub(super) from: (Point, Vector),
    pub(super) to: (Point, Vector),
}

/// What is spare at the ends of the last move of a tool, mm: a plunge is followed by a move from its start.
#[derive(Default)]
struct KnownEnds(Option<(AssemblyStep, [f64; 2])>);

impl KnownEnds {
    /// What is spare where `step` begins.
    fn at_start_of(&self, step: &AssemblyStep) -> Option<f64> {
        let (known, spare) = self.0.as_ref().filter(|(known, _)| known.tool == step.tool)?;
        [(known.to, spare[1]), (known.from, spare[0])].iter().find(|(at, _)| *at == step.from).map(|of| of.1)
    }

    /// Keeps what is spare at both ends of `step`.
    fn keep(&mut self, step: &AssemblyStep, spare: [f64; 2]) {
        self.0 = Some((*step, spare));
    }
}

/// The least distance found so far of shank or holder, mm.
struct LeastDistance(AtomicU64);

impl Default for LeastDistance {
    fn default() -> Self {
        Self(AtomicU64::new(f64::INFINITY.to_bits()))
    }
}

impl LeastDistance {
    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    fn add(&self, distance: f64) {
        let less = |bits: u64| (distance < f64::from_bits(bits)).then(|| distance.to_bits());
        // It fails where the distance is not less.
        let _ = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }
}

/// Least distances of shank and holder to the finished part over `steps` of tools with these `segments`: of
/// moves along the axis by what they sweep, of others at places at most [`DISTANCE_SPACING`] apart. `known`
/// has clearances of the steps, or nothing.
///
/// Branch and bound: a place is measured only where the distance at the last measured one, less the way
/// since, is below the least so far; and no further than that, and [`DISTANCE_AHEAD`] where a move may go
/// on. What was found first does not change the result.
///
/// # Errors
/// When cancelled.
pub(super) fn min_distances(
    steps: &[AssemblyStep],
    segments: &[Vec<AssemblySegment>],
    around: &AssemblySurroundings,
    known: &[PathClearance],
    monitor: &Monitor,
) -> Result<AssemblyDistances, Cancelled> {
    let least: [LeastDistance; 2] = Default::default();
    let count = monitor.steps(steps.len());
    for (part, least) in AssemblyPart::ALL.into_iter().zip(&least) {
        for path in known {
            let distance = path.least.of_part(part).distance;
            if (0.0..path.measured_to).contains(&distance) {
                least.add(distance);
            }
        }
    }
    let spare_of = |part: AssemblyPart, distance: f64| distance - least[part as usize].get();
    // What a distance, measured up to the least so far and `ahead`, is beyond the least.
    let measure = |part: AssemblyPart, ahead: f64, distance: &dyn Fn(f64) -> f64| {
        let best = &least[part as usize];
        let distance = distance(best.get() + ahead);
        best.add(distance);
        spare_of(part, distance)
    };
    let look = |segments: &[AssemblySegment], (tip, axis): (Point, Vector)| {
        segments.iter().fold(f64::INFINITY, |spare, segment| {
            let frustum = segment.placed(&tip, &axis);
            spare.min(measure(segment.part, DISTANCE_AHEAD, &|cap| around.frustum_distance(&frustum, cap)))
        })
    };
    // A lower bound on the distance of a part over a move along its axis, where one is known.
    let at_least = |index: usize, part: AssemblyPart| {
        let path = known.get(index).filter(|path| path.measured_to > 0.0)?;
        Some(path.least.of_part(part).distance.min(path.measured_to)).filter(|distance| *distance >= 0.0)
    };
    let scan = |(run, steps): (usize, &[AssemblyStep])| {
        let mut ends = KnownEnds::default();
        for (index, step) in steps.iter().enumerate() {
            count.begin()?;
            let index = run * STEPS_IN_RUN + index;
            let segments = &segments[step.tool];
            let moved = AssemblyMove::new(segments, step.from, step.to);
            let at_start = ends.at_start_of(step);
            if at_start.is_none_or(|spare| spare < moved.way)
                && let Some(swept) = moved.swept(segments)
            {
                let spare = swept.iter().fold(f64::INFINITY, |spare, piece| {
                    let of_move = at_least(index, piece.part).map(|distance| spare_of(piece.part, distance));
                    // What follows a plunge is the way back: distances ahead are of no use.
                    let measured = || measure(piece.part, 0.0, &|cap| around.swept_distance(piece, cap));
                    spare.min(of_move.filter(|spare| *spare >= 0.0).unwrap_or_else(measured))
                });
                ends.keep(step, [at_start.map_or(spare, |known| known.max(spare)), spare]);
                continue;
            }
            let start = at_start.unwrap_or_else(|| look(segments, step.from));
            let mut spare = start;
            let pieces = (moved.way / DISTANCE_SPACING).ceil().clamp(1.0, MAX_PIECES);
            for piece in 1..=pieces as usize {
                spare -= moved.way / pieces;
                if spare <= 0.0 {
                    spare = look(segments, moved.pose(piece as f64 / pieces));
                }
            }
            ends.keep(step, [start, spare]);
        }
        Ok(())
    };
    steps.par_chunks(STEPS_IN_RUN).enumerate().try_for_each(scan)?;
    let [shank, holder] = least.map(|least| least.get());
    Ok(AssemblyDistances { shank, holder })
}

/// Clearances of shank and holder over `steps` of `tools` with these `segments`: what lacks clearance, and
/// how much; of what does not, distances are mostly not found. `is_known` says which steps need no look.
///
/// # Errors
/// When cancelled.
pub(super) fn clearances(
    steps: &[AssemblyStep],
    tools: &[Tool],
    segments: &[Vec<AssemblySegment>],
    around: &AssemblySurroundings,
    is_known: impl Fn(usize) -> bool + Sync,
    monitor: &Monitor,
) -> Result<Vec<PathClearance>, Cancelled> {
    let count = monitor.steps(steps.len().div_ceil(STEPS_IN_RUN));
    let scan = |(run, steps): (usize, &[AssemblyStep])| {
        count.begin()?;
        let mut ends = KnownEnds::default();
        let mut found = Vec::with_capacity(steps.len());
        for (index, step) in steps.iter().enumerate() {
            let segments = &segments[step.tool];
            if segments.is_empty() || is_known(run * STEPS_IN_RUN + index) {
                found.push(PathClearance::FAR);
                continue;
            }
            let at_start = ends.at_start_of(step).unwrap_or(0.0);
            let moved = AssemblyMove::new(segments, step.from, step.to);
            let path = around.along(&tools[step.tool], segments, &moved, at_start);
            // What is spare over the whole of a move is so at its start.
            let over_move = if path.measured_to > 0.0 { path.slack } else { 0.0 };
            ends.keep(step, [at_start.max(over_move), path.slack]);
            found.push(path);
        }
        Ok(found)
    };
    let runs: Vec<Vec<PathClearance>> =
        steps.par_chunks(STEPS_IN_RUN).enumerate().map(scan).collect::<Result<_, Cancelled>>()?;
    Ok(runs.into_iter().flatten().collect())
}

/// Segments of shank and holder of each tool.
pub(super) fn segments_of(tools: &[Tool]) -> Vec<Vec<AssemblySegment>> {
    tools.iter().map(|tool| tool.assembly.segments(tool.overhang)).collect()
}

/// Move `k` of a program; `None` where no tool makes it.
pub(super) fn step_to(moves: &[Move], k: usize) -> Option<AssemblyStep> {
    let tool = moves[k].tool?;
    let before = k.checked_sub(1).map(|k| &moves[k]).filter(|before| before.tool == moves[k].tool);
    let to = (moves[k].tip, moves[k].axis);
    Some(AssemblyStep { tool, from: before.map_or(to, |before| (before.tip, before.axis)), to })
}

/// Judges all moves of a plunge program against the finished part.
///
/// # Errors
/// When cancelled.
pub(super) fn judge_moves(
    program: &ClProgram,
    setup: &Setup,
    around: &AssemblySurroundings,
    monitor: &Monitor,
) -> Result<(AssemblyDistances, Vec<Fault>), Cancelled> {
    let tools: Vec<Tool> = program.tools.iter().map(|tool| tool.completed(setup)).collect();
    let segments = segments_of(&tools);
    let moves = &program.moves;
    // A move back on the way of the one before is as clear as that.
    let goes_back = |k: usize| {
        let is_same = |a: &Move, b: &Move| a.tool == b.tool && a.tip == b.tip && a.axis == b.axis;
        k >= 2 && is_same(&moves[k], &moves[k - 2]) && moves[k - 1].tool == moves[k].tool
    };
    let step = |k: usize| step_to(moves, k).filter(|step| !segments[step.tool].is_empty() && !goes_back(k));
    let steps: Vec<Option<AssemblyStep>> = (0..moves.len()).map(step).collect();
    let given: Vec<AssemblyStep> = steps.iter().flatten().copied().collect();
    let found = clearances(&given, &tools, &segments, around, |_| false, &monitor.span(0.0, 0.5))?;
    let least = min_distances(&given, &segments, around, &found, &monitor.span(0.5, 1.0))?;
    let mut found = found.into_iter().map(|path| path.least);
    let measured: Vec<Option<AssemblyClearance>> =
        steps.iter().map(|step| step.and_then(|_| found.next())).collect();
    let judged: Vec<Vec<Fault>> = (0..moves.len())
        .into_par_iter()
        .filter_map(|k| {
            let mut own = k;
            while goes_back(own) {
                own -= 1;
            }
            let findings = assembly_findings(&tools[moves[k].tool?], &measured[own]?, around);
            Some(findings.into_iter().map(|finding| finding.at(moves[k].line)).collect())
        })
        .collect();
    Ok((least, judged.into_iter().flatten().collect()))
}

/// The fault of plunge `k` if at its end the holder, or a shank thicker than the cutter, is in stock that
/// neither it nor an earlier plunge removed.
pub(super) fn holder_in_stock(
    cut: &ProgramCut,
    k: usize,
    columns: &Columns,
    blank: &Blank,
) -> Option<Finding> {
    let tool = &cut.tool;
    let (part, depth) = part_in_stock(tool, &cut.cutter, columns.before(k + 1), blank)?;
    let (kind, help) = match part {
        AssemblyPart::Shank => {
            (FaultKind::ShankCollision, "cut in steps, or give a thinner shank".to_owned())
        }
        AssemblyPart::Holder => {
            let overhang = (tool.overhang + depth).ceil();
            (FaultKind::HolderCollision, format!("cut in steps, or give an overhang of {overhang} mm"))
        }
    };
    let (name, number) = (part.name(), tool.number);
    let what =
        format!("the {name} of tool {number} runs {depth:.1} mm into stock that no plunge before it removed");
    Some(Finding::new(kind, depth, what).with_help(help))
}

/// What is not judged of the tools of a program: a remark on tapered ones, and on those whose shank and
/// holder are unknown.
pub fn unjudged_tools(program: &ClProgram, setup: &Setup) -> Option<String> {
    let used = |index: usize| program.moves.iter().any(|step| step.tool == Some(index));
    let tapered: Vec<String> = program
        .tools
        .iter()
        .enumerate()
        .filter(|(index, tool)| tool.completed(setup).is_tapered() && used(*index))
        .map(|(_, tool)| tool.number.to_string())
        .collect();
    let tapered = (!tapered.is_empty()).then(|| {
        format!(
            "tapered, judged as cones against the part, as cylinders in stock: tool {}",
            tapered.join(", ")
        )
    });
    let remarks = [tapered, unknown_assemblies(program, setup)];
    let remarks: Vec<String> = remarks.into_iter().flatten().collect();
    (!remarks.is_empty()).then(|| remarks.join("; "))
}

/// Tools of a program whose shank and holder are unknown: a remark. Of programs that mill along curves their
/// holder is assumed, of others it is not looked at.
fn unknown_assemblies(program: &ClProgram, setup: &Setup) -> Option<String> {
    let used = |index: usize| program.moves.iter().any(|step| step.tool == Some(index));
    let unknown: Vec<String> = program
        .tools
        .iter()
        .enumerate()
        .filter(|(index, tool)| tool.completed(setup).assembly.is_empty() && used(*index))
        .map(|(_, tool)| tool.number.to_string())
        .collect();
    (!unknown.is_empty()).then(|| {
        let numbers = unknown.join(", ");
        if program.mills_along_curves() {
            return format!(
                "shank and holder are unknown, a holder of twice the diameter is assumed: tool {numbers}; \
                 give them in the setup"
            );
        }
        format!("shank and holder are unknown and were not checked: tool {numbers}; give them in the setup")
    })
}
