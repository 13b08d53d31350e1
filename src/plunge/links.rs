//! Stage 5, continued: links between plunges stay above the blank.
//!
//! A link runs straight from retract point to retract point while the axis turns at a constant rate. Where it
//! would come nearer to the blank than the safety distance, or swing the tool through it, both its ends are
//! retracted further.

use rayon::prelude::*;

use super::plan::{PlungePlan, Position};
use crate::cutting::link::LinkMove;
use crate::cutting::retract::{NearBottom, RetractSurface, retract_clear};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;

/// Maximum number of iterations for one link, and for the whole plan.
const MAX_ITERATIONS: usize = 20;
/// Depth of the tool in the blank above which a link is raised, mm.
const MAX_TOOL_DEPTH: f64 = 1e-3;

/// Moves retract points up their axes until links and retracts keep `safety` mm from `blank`, and measures
/// the clearance of each retract point and its following link.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn raise_links(
    plan: &mut PlungePlan,
    blank: &Blank,
    safety: f64,
    monitor: &Monitor,
) -> Result<(), Cancelled> {
    let numbers: Vec<usize> = (0..plan.positions.len().saturating_sub(1))
        .filter(|&k| {
            // Tool changes take place at the home position, far from the part.
            let tool = |k: usize| plan.sections[plan.positions[k].section].tool.number;
            tool(k) == tool(k + 1)
        })
        .collect();
    let mut bottoms: Vec<NearBottom> = plan
        .positions
        .par_iter()
        .map(|p| if monitor.is_cancelled() { NearBottom::NOWHERE } else { bottom_of(plan, p, blank) })
        .collect();
    let surfaces: Vec<RetractSurface> =
        plan.sections.iter().map(|s| RetractSurface::new(blank, s.tool.corner_radius)).collect();
    // Clearance of each link, mm.
    let mut kept = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        monitor.check()?;
        let links = Links { plan, bottoms: &bottoms, blank, surfaces: &surfaces, safety };
        let lift = |&k: &usize| if monitor.is_cancelled() { (safety, 0.0) } else { links.needed_lift(k) };
        let looks: Vec<(f64, f64)> = numbers.par_iter().map(lift).collect();
        monitor.check()?;
        let low: Vec<usize> =
            numbers.iter().zip(&looks).filter(|(_, (_, lift))| *lift > 0.0).map(|(&k, _)| k).collect();
        kept = looks.into_iter().map(|(clearance, _)| clearance).collect();
        if low.is_empty() {
            break;
        }
        for k in low {
            raise(plan, &mut bottoms, k, (blank, &surfaces), safety, monitor)?;
        }
    }
    let sections = &plan.sections;
    plan.positions.par_iter_mut().zip(bottoms).for_each(|(p, bottom)| {
        let tool = &sections[p.section].tool;
        let cutter = tool.placed(p.retract, p.axis);
        (p.retract, p.retract_clearance) = retract_clear(&cutter, bottom.clearance, blank, safety);
    });
    for (k, kept) in numbers.into_iter().zip(kept) {
        let position = &mut plan.positions[k];
        position.retract_clearance = position.retract_clearance.min(kept);
    }
    monitor.check()
}

/// The bottom of a position at its retract point.
fn bottom_of(plan: &PlungePlan, position: &Position, blank: &Blank) -> NearBottom {
    let tool = &plan.sections[position.section].tool;
    NearBottom::of(&tool.placed(position.retract, position.axis), blank)
}

/// Raises both ends of the link after position `k` until it is clear.
fn raise(
    plan: &mut PlungePlan,
    bottoms: &mut [NearBottom],
    k: usize,
    (blank, surfaces): (&Blank, &[RetractSurface]),
    safety: f64,
    monitor: &Monitor,
) -> Result<(), Cancelled> {
    for round in 0..MAX_ITERATIONS {
        monitor.check()?;
        let (_, needed) = Links { plan, bottoms, blank, surfaces, safety }.needed_lift(k);
        if needed <= 0.0 {
            break;
        }
        let lift = (1.0 + 0.3 * round as f64) * needed + 0.5 * safety.max(0.1);
        for end in k..=k + 1 {
            let position = &mut plan.positions[end];
            position.retract += position.axis * lift;
            bottoms[end] = bottom_of(plan, &plan.positions[end], blank);
        }
    }
    Ok(())
}

/// The links of a plan over its blank.
struct Links<'a> {
    plan: &'a PlungePlan,
    /// The bottom of every position at its retract point.
    bottoms: &'a [NearBottom],
    blank: &'a Blank,
    /// Surface of the blank at the distance of the corner radius, per section.
    surfaces: &'a [RetractSurface<'a>],
    safety: f64,
}

impl Links<'_> {
    /// Minimum distance of the bottom to the blank along the link after position `k`, mm, not refined further
    /// below `safety`; and what the link lacks of being clear: of the safety distance, or by the depth of the
    /// tool in the blank, mm.
    fn needed_lift(&self, k: usize) -> (f64, f64) {
        let (a, b) = (&self.plan.positions[k], &self.plan.positions[k + 1]);
        let tool = &self.plan.sections[a.section].tool;
        let link = LinkMove { tool, blank: self.blank, from: (a.retract, a.axis), to: (b.retract, b.axis) };
        let clearance = link.clearance([&self.bottoms[k], &self.bottoms[k + 1]], self.safety);
        if clearance < self.safety {
            return (clearance, self.safety - clearance);
        }
        let depth = link.max_tool_depth(&self.surfaces[a.section]);
        (clearance, if depth > MAX_TOOL_DEPTH { depth } else { 0.0 })
    }
}
