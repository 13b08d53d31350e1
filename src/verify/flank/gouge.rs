//! Clearance of cutter and holder from the finished part along a step.

use super::steps::CutterStep;
use crate::geometry::{CutterSolid, Meridional};
use crate::part::{ENDLESS, FinishedPart};
use crate::setup::Tool;

/// The finished part, prepared for the clearances of many steps.
pub(super) struct StepSurroundings<'a> {
    pub(super) finished: &'a FinishedPart,
    pub(super) tools: &'a [Tool],
    pub(super) hub_allowance: f64,
    pub(super) blade_allowance: f64,
}

/// Least distances, mm, capped at [`CLEARANCE_CAP`] above the allowances.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepClearance {
    pub(super) hub: f64,
    pub(super) blade: f64,
    /// Whether the holder meets a blade, its allowance, or the hub.
    pub(super) holder: bool,
}

/// Distance above the allowance at which clearances are capped, mm.
pub(super) const CLEARANCE_CAP: f64 = 1.0;
/// Depth of a holder in the allowance of a blade that is tolerated, mm.
const HOLDER_TOLERANCE: f64 = 0.01;
/// Largest travel, mm, and turn, rad, between two samples of a step.
const MAX_SAMPLE_TRAVEL: f64 = 1.0;
const MAX_SAMPLE_TURN_RAD: f64 = 1.5 * std::f64::consts::PI / 180.0;
/// Depth below an allowance that may stay hidden between two samples, as a share of the allowance …
const HIDDEN_SHARE: f64 = 0.1;
/// … and its limits, mm.
const HIDDEN_DEPTH: [f64; 2] = [0.005, 0.02];

impl StepClearance {
    pub(super) const FAR: Self = Self { hub: f64::INFINITY, blade: f64::INFINITY, holder: false };

    pub(super) fn worst_of(self, other: Self) -> Self {
        Self {
            hub: self.hub.min(other.hub),
            blade: self.blade.min(other.blade),
            holder: self.holder || other.holder,
        }
    }
}

impl StepSurroundings<'_> {
    fn blade(&self, cutter: &CutterSolid, tool: &Tool) -> f64 {
        let cap = self.blade_allowance + CLEARANCE_CAP;
        self.finished.wheel_clearance_below(cutter, tool.overhang, cap)
    }

    fn hub(&self, cutter: &CutterSolid) -> f64 {
        let cap = self.hub_allowance + CLEARANCE_CAP;
        let centre = cutter.tip + cutter.axis * cutter.corner_radius;
        let (_, distance) = self.finished.hub.curve().project(Meridional::from_point(&centre));
        if distance.abs() > 2.5 * cutter.radius + cap {
            cap
        } else {
            self.finished.hub_clearance(cutter).min(cap)
        }
    }

    /// Whether the assumed holder meets the part; one that is given is judged by
    /// [`clearances`](crate::verify::assembly::clearances).
    fn holder_meets(&self, cutter: &CutterSolid, tool: &Tool) -> bool {
        if !tool.assembly.holder.is_empty() {
            return false;
        }
        let holder = tool.holder(cutter.tip, cutter.axis);
        let (_, distance) = self.finished.hub.curve().project(Meridional::from_point(&holder.tip));
        !self.finished.clears_wheel(&holder, ENDLESS, self.blade_allowance - HOLDER_TOLERANCE)
            || (distance < holder.radius && self.finished.hub_clearance(&holder) < 0.0)
    }

    /// Clearance at the parameter `share`, 0…1, of a step.
    pub(super) fn at(&self, step: &CutterStep, share: f64) -> StepClearance {
        let cutter = step.cutter(self.tools, share);
        let tool = &self.tools[step.tool];
        let holder = self.holder_meets(&cutter, tool);
        StepClearance { hub: self.hub(&cutter), blade: self.blade(&cutter, tool), holder }
    }

    /// Least clearance along a step; `ends` are the clearances at both ends, where they are known. What may
    /// come nearer than an allowance between two samples, by [`Self::sag`], is looked at more closely.
    pub(super) fn along(&self, step: &CutterStep, ends: [Option<StepClearance>; 2]) -> StepClearance {
        let pieces = (step.length() / MAX_SAMPLE_TRAVEL)
            .max(step.turn() / MAX_SAMPLE_TURN_RAD)
            .ceil()
            .clamp(1.0, 2000.0);
        let mut least = ends[0].unwrap_or_else(|| self.at(step, 0.0));
        let mut before = least;
        for k in 0..pieces as usize {
            let (from, to) = (k as f64 / pieces, (k + 1) as f64 / pieces);
            let known = ends[1].filter(|_| k + 1 == pieces as usize);
            let after = known.unwrap_or_else(|| self.at(step, to));
            least = least.worst_of(after).worst_of(self.between(step, [from, to], [before, after]));
            before = after;
        }
        least
    }

    /// Least clearance between two samples of a step, at the shares `range`; halves the piece until no more
    /// than [`HIDDEN_DEPTH`] can be hidden between two samples, then evaluates the minimum of a parabola.
    fn between(
        &self,
        step: &CutterStep,
        [from, to]: [f64; 2],
        [before, after]: [StepClearance; 2],
    ) -> StepClearance {
        let share = to - from;
        let may_fall =
            |allowance: f64, distance: f64| distance < allowance + self.sag(step, allowance, share);
        if !may_fall(self.blade_allowance, before.blade.min(after.blade))
            && !may_fall(self.hub_allowance, before.hub.min(after.hub))
        {
            return StepClearance::FAR;
        }
        let halfway = 0.5 * (from + to);
        let middle = self.at(step, halfway);
        let min_allowance = self.blade_allowance.min(self.hub_allowance);
        let hidden = (HIDDEN_SHARE * min_allowance).clamp(HIDDEN_DEPTH[0], HIDDEN_DEPTH[1]);
        if self.sag(step, min_allowance, 0.5 * share) > hidden {
            let first = self.between(step, [from, halfway], [before, middle]);
            let second = self.between(step, [halfway, to], [middle, after]);
            return middle.worst_of(first).worst_of(second);
        }
        let lowest = [(before.hub, middle.hub, after.hub), (before.blade, middle.blade, after.blade)]
            .map(|(a, m, b)| lowest_share(a, m, b));
        lowest
            .into_iter()
            .flatten()
            .fold(middle, |least, lowest| least.worst_of(self.at(step, from + share * lowest)))
    }

    /// How far the distance to the part may fall below those at both ends of a `share` of a step, mm, if both
    /// are at least `allowance`. A point of the part at a distance d from the rounded corner is d and the
    /// corner radius from the circle in the middle of it; when the cutter goes past, it is nearest half way,
    /// and by Pythagoras not nearer than the leg of a triangle whose other leg is half the way. The same
    /// holds for the column with the cutter's radius and the way of its upper end.
    fn sag(&self, step: &CutterStep, allowance: f64, share: f64) -> f64 {
        let tool = &self.tools[step.tool];
        let (way, turn) = (share * step.length(), share * step.turn());
        let fall = |rounding: f64, reach: f64| {
            let leg = allowance.max(0.0) + rounding;
            leg.hypot(0.5 * (way + turn * reach)) - leg + 0.125 * turn * turn * reach
        };
        fall(tool.corner_radius, tool.corner_radius).max(fall(tool.radius(), tool.overhang))
    }
}

/// Where in [0, 1] the parabola with these values at 0, ½ and 1 has its minimum, unless that is near one of
/// them.
fn lowest_share(start: f64, middle: f64, end: f64) -> Option<f64> {
    let (slope, bend) = (4.0 * middle - 3.0 * start - end, 2.0 * (start - 2.0 * middle + end));
    let share = -0.5 * slope / bend;
    (bend > 1e-12 && share > 0.02 && share < 0.98 && (share - 0.5).abs() > 0.02).then_some(share)
}
