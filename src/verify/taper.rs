//! The edges of tapered cutters against the finished part: as cones, along every move. What they do below the
//! cone, and in stock, is judged as of a cylinder of the diameter at the tip.

use super::assembly::{AssemblyStep, clearances};
use super::fault::{Fault, near_blade, near_hub};
use crate::cutting::assembly::{AssemblySurroundings, blade_distance, hub_distance};
use crate::monitor::{Cancelled, Monitor};
use crate::part::FinishedPart;
use crate::setup::{AssemblyPart, AssemblySegment, ClearanceSetup, Setup, Tool};

/// Distance from its allowance that the edges of a tapered cutter may lack along a plunge, mm.
pub(super) const TAPER_TOLERANCE: f64 = 1e-3;

/// The cone of each tool, as a segment that keeps no clearance beyond the allowances.
fn cones_of(tools: &[Tool]) -> Vec<Vec<AssemblySegment>> {
    let segment = |(from, length, radii)| AssemblySegment { part: AssemblyPart::Holder, from, length, radii };
    tools.iter().map(|tool| tool.taper_cone().map(segment).into_iter().collect()).collect()
}

/// The faults of `steps`, each with its line, whose edges come nearer to the finished part than the
/// allowances less `tolerances` (hub and blades, mm).
///
/// # Errors
/// When cancelled.
pub(super) fn judge_tapers(
    steps: impl Iterator<Item = (AssemblyStep, usize)>,
    tools: &[Tool],
    (finished, setup): (&FinishedPart, &Setup),
    [of_hub, of_blade]: [f64; 2],
    monitor: &Monitor,
) -> Result<Vec<Fault>, Cancelled> {
    let cones = cones_of(tools);
    if cones.iter().all(Vec::is_empty) {
        return Ok(Vec::new());
    }
    let tapered: Vec<(AssemblyStep, usize)> =
        steps.filter(|(step, _)| !cones[step.tool].is_empty()).collect();
    let none = ClearanceSetup { shank: 0.0, holder: 0.0 };
    let around = AssemblySurroundings { clearances: none, ..AssemblySurroundings::new(finished, setup) };
    let moves: Vec<AssemblyStep> = tapered.iter().map(|(step, _)| *step).collect();
    let found = clearances(&moves, tools, &cones, &around, |_| false, monitor)?;
    let mut faults = Vec::new();
    for ((step, line), path) in tapered.iter().zip(found) {
        let clearance = path.least;
        let Some(pose) = clearance.worst.filter(|_| clearance.holder.missing > of_hub.min(of_blade)) else {
            continue;
        };
        for cone in &cones[step.tool] {
            let placed = cone.placed(&pose.0, &pose.1);
            let [hub, blade] = around.allowances;
            let findings = [
                near_hub(hub_distance(finished, &placed, hub), &setup.allowances, of_hub),
                near_blade(blade_distance(finished, &placed, blade), &setup.allowances, of_blade),
            ];
            let number = tools[step.tool].number;
            let help = format!("tool {number} is tapered: keep its edges, a cone, off the part");
            faults.extend(findings.into_iter().flatten().map(|f| f.with_help(help.clone()).at(*line)));
        }
    }
    Ok(faults)
}
