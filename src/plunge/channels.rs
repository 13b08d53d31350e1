//! Extends the plan of one channel to several: order of the plunges, links between them, and contact over all
//! plunges in cutting order.

use std::collections::HashSet;

use super::cut::LIFT_MARGIN;
use super::evaluation::{MeasuredPlunges, evaluated};
use super::plan::{Evaluation, PlungeMotion, PlungePlan, Position};
use crate::cutting::contact::{Columns, CoreContact, Engagement, core_contacts};
use crate::geometry::{Point, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::{SectionKind, Setup};

/// Maximum number of lifts of the plunges; contact that remains is reported as interference.
const MAX_ITERATIONS: usize = 8;
/// Distance within which two plunges above the shroud are the same, mm.
const SAME_PLACE: f64 = 1e-3;

/// Plan of the first `channels` channels of `part`, given the plan `one` of channel 1. Links and approaches
/// keep the distances of `setup` from `blank`. Row numbers continue from channel to channel.
///
/// The order is tool by tool, so that no tool is loaded twice, and channel by channel with each tool. A
/// plunge whose core meets stock only because of that order is lifted clear; one that interferes in channel 1
/// as well is left unchanged.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn plan_channels(
    one: &PlungePlan,
    part: &Impeller,
    blank: &Blank,
    setup: &Setup,
    channels: usize,
    monitor: &Monitor,
) -> Result<PlungePlan, Cancelled> {
    let mut plan = repeat_for_channels(one, part, channels);
    if channels <= 1 {
        return Ok(plan);
    }
    let (contacts, columns) = free_cores(&mut plan, blank, monitor)?;
    let retracts = plan.positions.iter().map(|p| p.evaluation.retract).collect();
    // Those of channel 1 are on the safe side: where plunges of other channels come earlier, a plunge engages
    // less stock and its lead-out has more space.
    let motions: Vec<(Engagement, PlungeMotion)> =
        plan.positions.iter().map(|p| (p.evaluation.engagement, p.evaluation.motion)).collect();
    let measured = MeasuredPlunges { contacts, motions, retracts };
    evaluated(plan, measured, &columns, (part, blank), setup, monitor)
}

/// The positions of channel 1, rotated into each channel: those of [`plan_channels`] before any is lifted, or
/// a link raised.
pub fn repeat_for_channels(one: &PlungePlan, part: &Impeller, channels: usize) -> PlungePlan {
    let mut plan =
        PlungePlan { positions: Vec::with_capacity(channels * one.positions.len()), ..one.clone() };
    let tool = |p: &Position| &one.sections[p.section].tool;
    let opens = |p: &Position| one.sections[p.section].kind == SectionKind::Opening;
    // Above the shroud neighbouring channels share plunges.
    let mut opened = HashSet::new();
    for stretch in one.positions.chunk_by(|a, b| tool(a) == tool(b) && opens(a) == opens(b)) {
        for channel in 0..channels {
            let angle = part.pitch() * channel as f64;
            let is_new = |p: &&Position| !opens(p) || opened.insert(place(&rotate_z(&p.tip, angle)));
            plan.positions.extend(stretch.iter().filter(is_new).map(|p| Position {
                tip: rotate_z(&p.tip, angle),
                axis: rotate_vector_z(&p.axis, angle),
                contact_point: rotate_z(&p.contact_point, angle),
                row: p.row + channel * one.sections[p.section].rows,
                evaluation: Evaluation {
                    retract: rotate_z(&p.evaluation.retract, angle),
                    engagement: Engagement {
                        towards_stock: rotate_vector_z(&p.evaluation.engagement.towards_stock, angle),
                        ..p.evaluation.engagement
                    },
                    motion: p.evaluation.motion.rotated_z(angle),
                    ..p.evaluation
                },
                ..p.clone()
            }));
        }
    }
    for section in &mut plan.sections {
        section.rows *= channels;
    }
    plan
}

/// Key by which equal points are found: coordinates in units of [`SAME_PLACE`], which is far below the
/// distance of two plunges and far above rounding.
fn place(point: &Point) -> [i64; 3] {
    [point.x, point.y, point.z].map(|x| (x / SAME_PLACE).round() as i64)
}

/// Contact in cutting order, after plunges that interfere only in this order are lifted, and the plunges.
fn free_cores(
    plan: &mut PlungePlan,
    blank: &Blank,
    monitor: &Monitor,
) -> Result<(Vec<CoreContact>, Columns), Cancelled> {
    let lone: Vec<bool> = plan.positions.iter().map(|p| p.evaluation.contact.interferes()).collect();
    let mut columns = plan.columns(blank);
    let mut contacts = core_contacts(&columns, blank, monitor)?;
    for _ in 0..MAX_ITERATIONS {
        let mut lifted = false;
        for ((position, contact), lone) in plan.positions.iter_mut().zip(&contacts).zip(&lone) {
            if contact.interferes() && !lone {
                let lift = contact.depth + LIFT_MARGIN;
                position.tip += position.axis * lift;
                position.lift += lift;
                lifted = true;
            }
        }
        if !lifted {
            break;
        }
        columns = plan.columns(blank);
        contacts = core_contacts(&columns, blank, monitor)?;
    }
    monitor.check()?;
    Ok((contacts, columns))
}
