//! One step by itself: its clearances, and where it is inside the blank.

use super::gouge::{StepClearance, StepSurroundings};
use super::steps::CutterStep;
use crate::cutting::assembly::AssemblyClearance;
use crate::cutting::link::LinkMove;
use crate::cutting::retract::{bottom_clearance, bottom_is_inside};
use crate::part::Blank;

/// Result of a step.
#[derive(Clone)]
pub(super) struct StepResult {
    pub clearance: StepClearance,
    /// Of shank and holder that are given.
    pub assembly: AssemblyClearance,
    /// At the end of a step under feed.
    pub end: Option<StepClearance>,
    /// Least distance to the blank of a rapid that is not along the axis, where it is outside the blank, mm;
    /// infinite for other steps.
    pub retract: f64,
    /// Parameters 0…1 along a rapid at which it is inside the outline of the blank.
    pub inside: Vec<f64>,
    /// The same of the holder, under feed.
    pub holder_inside: Vec<f64>,
}

/// Examines a step: under feed for the clearance of the cut, in rapid for collisions. `ends` are the
/// clearances at both ends, where they are known, `assembly` that of shank and holder. A rapid that is
/// further than `safety` mm from the blank all the way is not looked at.
pub(super) fn examine_step(
    step: &CutterStep,
    ends: [Option<StepClearance>; 2],
    assembly: AssemblyClearance,
    around: &StepSurroundings,
    (blank, safety): (&Blank, f64),
) -> StepResult {
    let mut look = StepResult {
        clearance: StepClearance::FAR,
        assembly,
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
            bottom_is_inside(&tool.holder(tip, axis), blank)
        };
        // The holder is far above the cut: its middle and end represent the whole step.
        look.holder_inside = [0.5, 1.0].into_iter().filter(within).collect();
        return look;
    }
    // Retracting along its own axis, a cutter meets nothing that it has not cut.
    if step.length() == 0.0 && step.turn() == 0.0 || step.is_retract() {
        return look;
    }
    let tool = &around.tools[step.tool];
    if (LinkMove { tool, blank, from: step.from, to: step.to }).is_far(safety) {
        return look;
    }
    let radius = tool.radius();
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
