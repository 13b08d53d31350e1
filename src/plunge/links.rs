//! Stage 5, continued: links between plunges stay above the blank.
//!
//! A link runs straight from retract point to retract point while the axis turns at a constant rate. Where it
//! would come nearer to the blank than the safety distance, or swing the tool through it, both its ends are
//! retracted further.

use rayon::prelude::*;

use super::plan::PlungePlan;
use crate::cutting::link::LinkMove;
use crate::cutting::retract::{NearBottom, RetractSurface, retract_clear};
use crate::geometry::{CutterSolid, Point};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;

/// Maximum number of iterations for one link, and for the whole plan.
const MAX_ITERATIONS: usize = 20;
/// Depth of the tool in the blank above which a link is raised, mm.
const MAX_TOOL_DEPTH: f64 = 1e-3;

/// `retracts`, the retract point of each position of `plan`, moved up its axis until links and retracts keep
/// `safety` mm from `blank`; each with the clearance of itself and its following link, mm.
///
/// # Errors
/// When `monitor` is cancelled.
pub(super) fn raise_links<E: Sync>(
    plan: &PlungePlan<E>,
    retracts: Vec<Point>,
    blank: &Blank,
    safety: f64,
    monitor: &Monitor,
) -> Result<Vec<(Point, f64)>, Cancelled> {
    let numbers: Vec<usize> = (0..plan.positions.len().saturating_sub(1))
        .filter(|&k| {
            // Tool changes take place at the home position, far from the part.
            let tool = |k: usize| plan.sections[plan.positions[k].section].tool.number;
            tool(k) == tool(k + 1)
        })
        .collect();
    let surfaces: Vec<RetractSurface> =
        plan.sections.iter().map(|s| RetractSurface::new(blank, s.tool.corner_radius)).collect();
    let mut links = Links { plan, retracts, bottoms: Vec::new(), blank, surfaces: &surfaces, safety };
    let bottom = |k| if monitor.is_cancelled() { NearBottom::NOWHERE } else { links.bottom(k) };
    links.bottoms = (0..plan.positions.len()).into_par_iter().map(bottom).collect();
    // Clearance of each link, mm.
    let mut kept = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        monitor.check()?;
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
            links.raise(k, monitor)?;
        }
    }
    let mut raised: Vec<(Point, f64)> =
        (0..plan.positions.len()).into_par_iter().map(|k| links.clear_retract(k)).collect();
    for (k, kept) in numbers.into_iter().zip(kept) {
        raised[k].1 = raised[k].1.min(kept);
    }
    monitor.check()?;
    Ok(raised)
}

/// The links of a plan over its blank.
struct Links<'a, E> {
    plan: &'a PlungePlan<E>,
    /// The retract point of every position.
    retracts: Vec<Point>,
    /// The bottom of every position at its retract point.
    bottoms: Vec<NearBottom>,
    blank: &'a Blank,
    /// Surface of the blank at the distance of the corner radius, per section.
    surfaces: &'a [RetractSurface<'a>],
    safety: f64,
}

impl<E> Links<'_, E> {
    /// The cutter of position `k` at its retract point.
    fn retracted(&self, k: usize) -> CutterSolid {
        let position = &self.plan.positions[k];
        self.plan.sections[position.section].tool.placed(self.retracts[k], position.axis)
    }

    /// The bottom of position `k` at its retract point.
    fn bottom(&self, k: usize) -> NearBottom {
        NearBottom::of(&self.retracted(k), self.blank)
    }

    /// The retract point of position `k`, moved up until it keeps the safety distance, and its clearance, mm.
    fn clear_retract(&self, k: usize) -> (Point, f64) {
        retract_clear(&self.retracted(k), self.bottoms[k].clearance, self.blank, self.safety)
    }

    /// Raises both ends of the link after position `k` until it is clear.
    fn raise(&mut self, k: usize, monitor: &Monitor) -> Result<(), Cancelled> {
        for round in 0..MAX_ITERATIONS {
            monitor.check()?;
            let (_, needed) = self.needed_lift(k);
            if needed <= 0.0 {
                break;
            }
            let lift = (1.0 + 0.3 * round as f64) * needed + 0.5 * self.safety.max(0.1);
            for end in k..=k + 1 {
                self.retracts[end] += self.plan.positions[end].axis * lift;
                self.bottoms[end] = self.bottom(end);
            }
        }
        Ok(())
    }

    /// Minimum distance of the bottom to the blank along the link after position `k`, mm, not refined further
    /// below `safety`; and what the link lacks of being clear: of the safety distance, or by the depth of the
    /// tool in the blank, mm.
    fn needed_lift(&self, k: usize) -> (f64, f64) {
        let (a, b) = (&self.plan.positions[k], &self.plan.positions[k + 1]);
        let tool = &self.plan.sections[a.section].tool;
        let (from, to) = ((self.retracts[k], a.axis), (self.retracts[k + 1], b.axis));
        let link = LinkMove { tool, blank: self.blank, from, to };
        let clearance = link.clearance([&self.bottoms[k], &self.bottoms[k + 1]], self.safety);
        if clearance < self.safety {
            return (clearance, self.safety - clearance);
        }
        let depth = link.max_tool_depth(&self.surfaces[a.section]);
        (clearance, if depth > MAX_TOOL_DEPTH { depth } else { 0.0 })
    }
}
