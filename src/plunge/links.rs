//! Stage 5, continued: links between plunges stay above the blank.
//!
//! A link runs straight from retract point to retract point while the axis turns at a constant rate. Where it
//! would come nearer to the blank than the safety distance, or swing the tool through it, both its ends are
//! retracted further.

use rayon::prelude::*;

use super::plan::PlungePlan;
use crate::cutting::link::LinkMove;
use crate::cutting::retract::{NearBottom, RetractSurface, max_retract, retract_clear};
use crate::geometry::{CutterSolid, Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;

/// Maximum number of iterations for one link, and for the whole plan.
const MAX_ITERATIONS: usize = 20;

/// `retracts`, the retract point of each position of `plan`, moved up its axis until links and retracts keep
/// `safety` mm from `blank`; each with the clearance of itself and its following link, mm. A tool leaves a
/// position `lead_outs` (across the axis, mm) of its retract point.
///
/// # Errors
/// When `monitor` is cancelled.
pub(super) fn raise_links<E: Sync>(
    plan: &PlungePlan<E>,
    retracts: Vec<Point>,
    lead_outs: &[Vector],
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
    let mut links = Links {
        plan,
        raised: vec![0.0; retracts.len()],
        retracts,
        lead_outs,
        bottoms: Vec::new(),
        blank,
        surfaces: &surfaces,
        safety,
    };
    let bottom = |k| if monitor.is_cancelled() { [NearBottom::NOWHERE; 2] } else { links.bottoms_at(k) };
    links.bottoms = (0..plan.positions.len()).into_par_iter().map(bottom).collect();
    // Links are looked at from where the tool is clear of the blank: a retract that is raised after them
    // would leave by another link.
    let clear: Vec<Point> =
        (0..plan.positions.len()).into_par_iter().map(|k| links.clear_retract(k).0).collect();
    for (k, tip) in clear.into_iter().enumerate() {
        if tip != links.retracts[k] {
            links.retracts[k] = tip;
            links.bottoms[k] = links.bottoms_at(k);
        }
    }
    monitor.check()?;
    // Clearance of each link and what it lacks, mm, with its ends raised as in `seen`.
    let mut looks = vec![(safety, 0.0); numbers.len()];
    let mut seen: Option<Vec<f64>> = None;
    for _ in 0..MAX_ITERATIONS {
        monitor.check()?;
        let is_stale = |k: usize| seen.as_ref().is_none_or(|seen| seen[k..=k + 1] != links.raised[k..=k + 1]);
        looks.par_iter_mut().zip(&numbers).for_each(|(look, &k)| {
            if is_stale(k) && !monitor.is_cancelled() {
                *look = links.needed_lift(k);
            }
        });
        monitor.check()?;
        let low: Vec<usize> =
            numbers.iter().zip(&looks).filter(|(_, (_, lift))| *lift > 0.0).map(|(&k, _)| k).collect();
        if low.is_empty() {
            break;
        }
        let before = links.raised.clone();
        for k in low {
            links.raise(k, monitor)?;
        }
        if links.raised == before {
            break;
        }
        seen = Some(before);
    }
    let mut raised: Vec<(Point, f64)> =
        (0..plan.positions.len()).into_par_iter().map(|k| links.clear_retract(k)).collect();
    for (k, (clearance, _)) in numbers.into_iter().zip(looks) {
        raised[k].1 = raised[k].1.min(clearance);
    }
    monitor.check()?;
    Ok(raised)
}

/// The links of a plan over its blank.
struct Links<'a, E> {
    plan: &'a PlungePlan<E>,
    /// The retract point of every position.
    retracts: Vec<Point>,
    /// By how much each has been raised, mm.
    raised: Vec<f64>,
    /// Where the tool leaves every position, from its retract point, mm.
    lead_outs: &'a [Vector],
    /// The bottom of every position where the tool arrives, and where it leaves.
    bottoms: Vec<[NearBottom; 2]>,
    blank: &'a Blank,
    /// Surface of the blank at the distance of the corner radius, per section.
    surfaces: &'a [RetractSurface<'a>],
    safety: f64,
}

impl<E> Links<'_, E> {
    /// Where the tool leaves position `k`.
    fn exit(&self, k: usize) -> Point {
        self.retracts[k] + self.lead_outs[k]
    }

    /// The cutter of position `k` with its tip at a point.
    fn cutter(&self, k: usize, tip: Point) -> CutterSolid {
        let position = &self.plan.positions[k];
        self.plan.sections[position.section].tool.placed(tip, position.axis)
    }

    /// The bottom of position `k` where the tool arrives, and where it leaves.
    fn bottoms_at(&self, k: usize) -> [NearBottom; 2] {
        let arrives = NearBottom::from_cutter(&self.cutter(k, self.retracts[k]), self.blank);
        let leaves = match self.lead_outs[k] == Vector::zeros() {
            true => arrives,
            false => NearBottom::from_cutter(&self.cutter(k, self.exit(k)), self.blank),
        };
        [arrives, leaves]
    }

    /// The retract point of position `k`, moved up until it, and where the tool leaves, keep the safety
    /// distance, and the clearance, mm.
    fn clear_retract(&self, k: usize) -> (Point, f64) {
        let [arrives, leaves] = self.bottoms[k].map(|bottom| bottom.clearance);
        let cutter = self.cutter(k, self.retracts[k]);
        let (tip, clearance) = retract_clear(&cutter, arrives, self.blank, self.safety);
        if self.lead_outs[k] == Vector::zeros() {
            return (tip, clearance);
        }
        let exit = self.exit(k);
        let (raised, left) = retract_clear(&self.cutter(k, exit), leaves, self.blank, self.safety);
        let raise = (raised - exit).dot(&cutter.axis).max((tip - self.retracts[k]).dot(&cutter.axis));
        (self.retracts[k] + cutter.axis * raise, clearance.min(left))
    }

    /// Raises both ends of the link after position `k` until it is clear.
    fn raise(&mut self, k: usize, monitor: &Monitor) -> Result<(), Cancelled> {
        let limit = max_retract(self.blank);
        for round in 0..MAX_ITERATIONS {
            monitor.check()?;
            let (_, needed) = self.needed_lift(k);
            if needed <= 0.0 || self.raised[k].max(self.raised[k + 1]) >= limit {
                break;
            }
            let lift = (1.0 + 0.3 * round as f64) * needed + 0.5 * self.safety.max(0.1);
            for end in k..=k + 1 {
                let lift = lift.min(limit - self.raised[end]).max(0.0);
                self.lift(end, lift);
                // Further up it may come near to an edge of the blank.
                let (clear, _) = self.clear_retract(end);
                let more = (clear - self.retracts[end]).dot(&self.plan.positions[end].axis);
                if more > 0.0 {
                    self.lift(end, more);
                }
            }
        }
        Ok(())
    }

    /// Moves the retract point of position `k` up its axis, by `mm`.
    fn lift(&mut self, k: usize, mm: f64) {
        self.raised[k] += mm;
        self.retracts[k] += self.plan.positions[k].axis * mm;
        self.bottoms[k] = self.bottoms_at(k);
    }

    /// [`LinkMove::needed_lift`] of the link after position `k`.
    fn needed_lift(&self, k: usize) -> (f64, f64) {
        let (a, b) = (&self.plan.positions[k], &self.plan.positions[k + 1]);
        let tool = &self.plan.sections[a.section].tool;
        let (from, to) = ((self.exit(k), a.axis), (self.retracts[k + 1], b.axis));
        let link = LinkMove { tool, blank: self.blank, from, to };
        let ends = [&self.bottoms[k][1], &self.bottoms[k + 1][0]];
        link.needed_lift(ends, &self.surfaces[a.section], self.safety)
    }
}
