//! Stage 5, continued: links between plunges stay above the blank.
//!
//! A link runs straight from retract point to retract point while the axis turns evenly. Where it would come
//! nearer to the blank than the safety distance, both its ends are pulled further back.

use rayon::prelude::*;

use super::plan::{PlungePlan, Position};
use super::retract::{NearBottom, bottom_clearance};
use crate::geometry::search;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;

/// Places looked at along a link, in cutter diameters, and the most of them.
const SAMPLE_DIAMETERS: f64 = 0.25;
/// See [`SAMPLE_DIAMETERS`].
const MAX_SAMPLES: usize = 400;
/// Times a link, and the whole plan, is looked at again.
const MAX_ROUNDS: usize = 20;

/// Pulls retract points back until links and retracts keep `safety` mm from `blank`, and measures what each
/// retract point keeps.
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
            // A tool change happens at home, far from the part.
            let tool = |k: usize| plan.sections[plan.positions[k].section].tool.number;
            tool(k) == tool(k + 1)
        })
        .collect();
    let mut bottoms: Vec<NearBottom> = plan
        .positions
        .par_iter()
        .map(|p| if monitor.is_cancelled() { NearBottom::NOWHERE } else { bottom_of(plan, p, blank) })
        .collect();
    for _ in 0..MAX_ROUNDS {
        monitor.check()?;
        let links = Links { plan, bottoms: &bottoms, blank, safety };
        let low: Vec<usize> = numbers
            .par_iter()
            .copied()
            .filter(|&k| !monitor.is_cancelled() && links.clearance(k) < safety)
            .collect();
        monitor.check()?;
        if low.is_empty() {
            break;
        }
        for k in low {
            raise(plan, &mut bottoms, k, blank, safety, monitor)?;
        }
    }
    let sections = &plan.sections;
    plan.positions.par_iter_mut().zip(bottoms).for_each(|(p, bottom)| {
        let tool = &sections[p.section].tool;
        p.retract_clearance = bottom.clearance;
        for _ in 1..MAX_ROUNDS {
            if p.retract_clearance >= safety || monitor.is_cancelled() {
                break;
            }
            // Flat ends of the blank between its circles: go on until it is really clear.
            p.retract += p.axis * (1.5 * (safety - p.retract_clearance) + 1e-3);
            p.retract_clearance = bottom_clearance(&tool.placed(p.retract, p.axis), blank);
        }
    });
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
    blank: &Blank,
    safety: f64,
    monitor: &Monitor,
) -> Result<(), Cancelled> {
    for round in 0..MAX_ROUNDS {
        monitor.check()?;
        let clearance = Links { plan, bottoms, blank, safety }.clearance(k);
        if clearance >= safety {
            break;
        }
        let lift = (1.0 + 0.3 * round as f64) * (safety - clearance) + 0.5 * safety.max(0.1);
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
    /// Of every position at its retract point.
    bottoms: &'a [NearBottom],
    blank: &'a Blank,
    safety: f64,
}

impl Links<'_> {
    /// Least distance of the bottom to the blank along the link after position `k`, mm; any of its distances below
    /// `safety` when there is one.
    fn clearance(&self, k: usize) -> f64 {
        let (a, b) = (&self.plan.positions[k], &self.plan.positions[k + 1]);
        let tool = &self.plan.sections[a.section].tool;
        let length = (b.retract - a.retract).norm();
        let samples = ((length / (SAMPLE_DIAMETERS * tool.diameter)).ceil() as usize).clamp(1, MAX_SAMPLES);
        let spacing = 1.0 / (samples + 1) as f64;
        let (motion, tilt) = (b.retract - a.retract, b.axis - a.axis);
        // Clearance at a share of the way, and its slope there.
        let look = |share: f64, known: Option<&NearBottom>| {
            let between = a.axis + tilt * share;
            let axis = between.normalize();
            let cutter = tool.placed(a.retract + motion * share, axis);
            let near = known.copied().unwrap_or_else(|| NearBottom::of(&cutter, self.blank));
            let turning = (tilt - axis * axis.dot(&tilt)) / between.norm();
            (near.clearance, near.growth(&cutter, &motion, &turning))
        };
        let at = |i: usize| match i {
            0 => look(0.0, Some(&self.bottoms[k])),
            i if i == samples + 1 => look(1.0, Some(&self.bottoms[k + 1])),
            i => look(spacing * i as f64, None),
        };
        let looks: Vec<(f64, f64)> = (0..samples + 2).into_par_iter().with_min_len(16).map(at).collect();
        let mut least = looks[1..=samples].iter().map(|look| look.0).fold(f64::INFINITY, f64::min);
        // Where it falls at one and rises at the next it comes nearer still between them.
        for (i, pair) in looks.windows(2).enumerate() {
            let (from, to) = (pair[0], pair[1]);
            if least < self.safety || from.1 >= 0.0 || to.1 <= 0.0 {
                continue;
            }
            let start = spacing * i as f64;
            let ends = ((start, from.1), (start + spacing, to.1));
            least = least.min(search::least_in_dip(|x| look(x, None), ends.0, ends.1, 0.02 * spacing));
        }
        least
    }
}
