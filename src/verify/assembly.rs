//! Shank and holder of every move against the finished part, and against stock where a plunge ends.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::fault::{Fault, FaultKind, Finding};
use super::{ProgramCut, TOOL_TOLERANCE};
use crate::cutting::assembly::{AssemblyClearance, AssemblySurroundings, depth_in_stock};
use crate::cutting::contact::Columns;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::{AssemblyPart, AssemblySegment, Setup, Tool};
use crate::toolpath::{ClProgram, Move};

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

    /// The lesser of each.
    pub(super) fn add(&mut self, clearance: &AssemblyClearance) {
        self.shank = self.shank.min(clearance.shank.distance);
        self.holder = self.holder.min(clearance.holder.distance);
    }
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
        let help = match only.and_then(|pose| around.stick_out(tool, pose)) {
            Some(overhang) => format!("an overhang of {overhang} mm would do, instead of {}", tool.overhang),
            None => "no longer overhang frees it: tilt the axis, or give a thinner holder".to_owned(),
        };
        let what = format!(
            "the holder of tool {} comes within {:.3} mm of the part: {:.3} mm short of allowance and \
             clearance",
            tool.number, clearance.holder.distance, clearance.holder.missing
        );
        let finding = Finding::new(FaultKind::HolderCollision, clearance.holder.missing, what);
        findings.push(finding.with_help(help));
    }
    findings
}

/// The least distance found so far of the part of a tool that is further off, mm: larger ones need not be
/// measured.
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

    fn add(&self, clearance: &AssemblyClearance) {
        // Positive numbers are in the order of their bits.
        let further = clearance.shank.distance.max(clearance.holder.distance).max(0.0);
        self.0.fetch_min(further.to_bits(), Ordering::Relaxed);
    }
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
    let segments: Vec<Vec<AssemblySegment>> =
        tools.iter().map(|tool| tool.assembly.segments(tool.overhang)).collect();
    let moves = &program.moves;
    // A move back on the way of the one before is as clear as that.
    let goes_back = |k: usize| {
        let is_same = |a: &Move, b: &Move| a.tool == b.tool && a.tip == b.tip && a.axis == b.axis;
        k >= 2 && is_same(&moves[k], &moves[k - 2]) && moves[k - 1].tool == moves[k].tool
    };
    let least = LeastDistance::default();
    let measure = |k: usize| {
        let step = &moves[k];
        let number = step.tool.filter(|&number| !segments[number].is_empty() && !goes_back(k))?;
        let before = k.checked_sub(1).map(|k| &moves[k]).filter(|b| b.tool == step.tool);
        let to = (step.tip, step.axis);
        let from = before.map_or(to, |before| (before.tip, before.axis));
        let clearance = around.along(&tools[number], &segments[number], from, to, least.get());
        least.add(&clearance);
        Some(clearance)
    };
    let count = monitor.steps(moves.len());
    let measured: Vec<Option<AssemblyClearance>> = (0..moves.len())
        .into_par_iter()
        .map(|k| count.begin().map(|()| measure(k)))
        .collect::<Result<_, Cancelled>>()?;
    let judged: Vec<(AssemblyClearance, Vec<Fault>)> = (0..moves.len())
        .into_par_iter()
        .filter_map(|k| {
            let mut own = k;
            while goes_back(own) {
                own -= 1;
            }
            let clearance = measured[own]?;
            let findings = assembly_findings(&tools[moves[k].tool?], &clearance, around);
            Some((clearance, findings.into_iter().map(|finding| finding.at(moves[k].line)).collect()))
        })
        .collect();
    let mut least = AssemblyDistances::NONE;
    let mut faults = Vec::new();
    for (clearance, found) in judged {
        least.add(&clearance);
        faults.extend(found);
    }
    Ok((least, faults))
}

/// The fault of plunge `k` if at its end the holder, or a shank thicker than the cutter, is in stock that
/// neither it nor an earlier plunge removed.
pub(super) fn holder_in_stock(
    cut: &ProgramCut,
    k: usize,
    columns: &Columns,
    blank: &Blank,
) -> Option<Finding> {
    let (tool, cutter) = (&cut.tool, &cut.cutter);
    if tool.assembly.is_empty() {
        return None;
    }
    for segment in tool.assembly.segments(tool.overhang) {
        let widest = segment.radii[0].max(segment.radii[1]);
        if widest <= tool.radius() {
            continue;
        }
        let placed = segment.placed(&cutter.tip, &cutter.axis);
        let depth = depth_in_stock(&placed, columns.before(k + 1), None, blank);
        if depth > TOOL_TOLERANCE {
            let (kind, name) = match segment.part {
                AssemblyPart::Shank => (FaultKind::ShankCollision, "shank"),
                AssemblyPart::Holder => (FaultKind::HolderCollision, "holder"),
            };
            let what = format!(
                "the {name} of tool {} runs {depth:.1} mm into stock that no plunge before it removed",
                tool.number
            );
            return Some(Finding::new(kind, depth, what).with_help("cut in steps, or give more overhang"));
        }
    }
    None
}

/// Tools of a program whose shank and holder are unknown, while the setup knows those of others: a remark. Of
/// programs that mill along curves their holder is assumed, of others it is not looked at.
pub fn unknown_assemblies(program: &ClProgram, setup: &Setup) -> Option<String> {
    if setup.tools.iter().all(|tool| tool.assembly.is_empty()) {
        return None;
    }
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
