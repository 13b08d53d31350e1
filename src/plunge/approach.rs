//! Rapid approach: a plunge comes down in rapid as far as earlier plunges have removed the stock, and feeds
//! from there.

use rayon::prelude::*;

use super::plan::{PlungeMotion, PlungePlan};
use crate::cutting::approach::ApproachRule;
use crate::cutting::contact::{BlankTop, Columns, Engagement};
use crate::geometry::Point;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::{AssemblySegment, Setup};
use crate::toolpath::RAPID_MM_PER_MIN;

/// Distance that approaches keep beyond the required ones, mm: above the rounding of a program, and what a
/// measurement of the stock may find more of.
const MARGIN: f64 = 0.02;
/// Time that an approach saves at least, s: a further block of the program, with its stop, costs as much.
const MIN_SAVED_S: f64 = 0.5;

/// Adds, if the setup asks for it, to the `motions` of `plan`, whose plunges are `columns` with these
/// `retracts`, the height above its tip at which the rapid down of each ends and its feed begins, in place of
/// one that they have.
///
/// # Errors
/// When `monitor` is cancelled.
pub(super) fn add_approaches<E: Sync>(
    plan: &PlungePlan<E>,
    retracts: &[(Point, f64)],
    motions: &mut [(Engagement, PlungeMotion)],
    columns: &Columns,
    blank: &Blank,
    setup: &Setup,
    monitor: &Monitor,
) -> Result<(), Cancelled> {
    if !setup.plunge.rapid_approach {
        motions.iter_mut().for_each(|(_, motion)| motion.approach = None);
        return Ok(());
    }
    let top = BlankTop::new(blank);
    let distance = setup.allowances.safety_distance + MARGIN;
    let segments: Vec<Vec<AssemblySegment>> =
        plan.sections.iter().map(|section| section.tool.assembly.segments(section.tool.overhang)).collect();
    let approach = |(k, (_, motion)): (usize, &mut (Engagement, PlungeMotion))| {
        monitor.check()?;
        let position = &plan.positions[k];
        let tool = &plan.sections[position.section].tool;
        let rule = ApproachRule {
            tool,
            segments: &segments[position.section],
            blank,
            top: &top,
            below: distance,
            aside: distance,
            clearances: setup.clearances,
        };
        let from = (retracts[k].0 - position.tip).dot(&position.axis);
        let slower = 1.0 / motion.feed_mm_per_min.unwrap_or(tool.plunge_feed) - 1.0 / RAPID_MM_PER_MIN;
        let highest = from - MIN_SAVED_S / 60.0 / slower.max(1e-9);
        if highest <= 0.0 {
            motion.approach = None;
            return Ok(());
        }
        let height = rule.height((position.tip, position.axis), columns.before(k), highest).at_most;
        motion.approach = (height <= highest).then_some(height);
        Ok(())
    };
    motions.par_iter_mut().enumerate().try_for_each(approach)
}
