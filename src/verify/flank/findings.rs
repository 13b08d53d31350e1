//! Which results of a program are faults.

use std::sync::Arc;

use super::examine::StepResult;
use super::gouge::StepClearance;
use super::steps::CutterStep;
use super::stock::{FloorResult, StockCollision, StockProbe};
use super::{FlankVerifier, HUB_TOLERANCE};
use crate::cutting::assembly::AssemblySurroundings;
use crate::setup::{Setup, Tool};
use crate::toolpath::{ClProgram, Motion, Move, is_axial};
use crate::verify::assembly::assembly_findings;
use crate::verify::fault::{
    Fault, FaultKind, Finding, beyond_machine, missing_feed, near_blade, near_hub, rapid_near_blank,
    stopped_spindle, tool_mismatch,
};
use crate::verify::too_deep;

/// Depth of a plausible cut, in layers of the setup.
const MAX_LAYERS: f64 = 4.0;
/// Depth of a plausible cut, in cutter diameters.
const MAX_DIAMETERS: f64 = 4.0;
/// Largest turn of the axis in one move under feed, rad: controllers may interpolate a larger one in another
/// manner than intended.
const MAX_TURN_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

impl FlankVerifier<'_> {
    /// The faults of a step.
    pub(super) fn faults_of(
        &self,
        step: &CutterStep,
        look: &StepResult,
    ) -> impl Iterator<Item = Fault> + use<> {
        let stock = &self.setup.allowances;
        let StepClearance { hub, blade, holder } = look.clearance;
        let turns = step.feed.is_some() && step.turn() > MAX_TURN_RAD;
        let found = [
            near_hub(hub, stock, HUB_TOLERANCE),
            near_blade(blade, stock, self.blade_tolerance),
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
    pub(super) fn too_deep(&self, depth: f64, step: &CutterStep) -> Option<Fault> {
        let tool = &self.tools[step.tool];
        if depth > tool.overhang {
            return Some(too_deep(depth, tool).at(step.line));
        }
        // A plunge cuts beside the one before, along its whole length.
        let ((from, before), (to, axis)) = (step.from, step.to);
        let plunges = tool.is_flat() && is_axial(&(to - from), &before, &axis);
        (!plunges && depth > max_plausible_depth(tool, self.setup))
            .then(|| too_thick(depth, tool, self.setup).at(step.line))
    }

    /// Faults of the program as a whole: nothing cut, no feed rate, tools that differ from those of the
    /// setup.
    pub(super) fn program_faults(
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
    pub(super) fn fault(&self, line: usize) -> Fault {
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
