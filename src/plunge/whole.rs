//! From the plan of one channel to that of several: the order of their plunges, the links between them, and contact over
//! all plunges as they are cut.

use rayon::prelude::*;

use super::contact::{BlankTop, Column, Columns, core_contact};
use super::links::raise_links;
use super::plan::{PlungePlan, Position};
use crate::geometry::{rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};

/// Times that plunges are lifted before their contact is left to the verdict.
const MAX_ROUNDS: usize = 8;
/// Air left between a freed core and the stock below it, mm.
const LIFT_MARGIN: f64 = 1e-3;

/// The plan of the first `channels` channels of `part`, whose `one` is that of channel 1, from `blank` with links `safety` mm
/// above it. Rows count on from channel to channel.
///
/// Tool by tool, so that none is loaded twice, and channel by channel with each. A plunge whose core meets stock only because
/// of that order stops short by as much; one that interferes in channel 1 as well stays as it is.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn plan_channels(
    one: &PlungePlan,
    part: &Impeller,
    blank: &Blank,
    safety: f64,
    channels: usize,
    monitor: &Monitor,
) -> Result<PlungePlan, Cancelled> {
    let mut plan = repeated(one, part, channels);
    if channels > 1 {
        free_cores(&mut plan, blank, monitor)?;
        raise_links(&mut plan, blank, safety, monitor)?;
    }
    Ok(plan)
}

/// The positions of channel 1, turned into each channel.
fn repeated(one: &PlungePlan, part: &Impeller, channels: usize) -> PlungePlan {
    let mut plan =
        PlungePlan { positions: Vec::with_capacity(channels * one.positions.len()), ..one.clone() };
    let tool = |p: &Position| &one.sections[p.section].tool;
    for stretch in one.positions.chunk_by(|a, b| tool(a) == tool(b)) {
        for channel in 0..channels {
            let angle = part.pitch() * channel as f64;
            plan.positions.extend(stretch.iter().map(|p| Position {
                tip: rotate_z(&p.tip, angle),
                axis: rotate_vector_z(&p.axis, angle),
                retract: rotate_z(&p.retract, angle),
                contact_point: rotate_z(&p.contact_point, angle),
                row: p.row + channel * one.sections[p.section].rows,
                ..p.clone()
            }));
        }
    }
    for section in &mut plan.sections {
        section.rows *= channels;
    }
    plan
}

/// Measures contact in cutting order, and lifts plunges that interfere here and did not in their own channel.
fn free_cores(plan: &mut PlungePlan, blank: &Blank, monitor: &Monitor) -> Result<(), Cancelled> {
    let top = BlankTop::new(blank);
    let lone: Vec<bool> = plan.positions.iter().map(|p| p.contact.interferes()).collect();
    for round in 0..=MAX_ROUNDS {
        monitor.check()?;
        let column = |p: &Position| {
            let tool = &plan.sections[p.section].tool;
            Column::new(tool.placed(p.tip, p.axis), tool.core_radius(), &top)
        };
        let columns: Columns = plan.positions.iter().map(column).collect();
        let contact = |k: usize| {
            let column = &columns.as_slice()[k];
            (!monitor.is_cancelled()).then(|| core_contact(column, columns.before(k), blank))
        };
        let contacts: Vec<_> = (0..columns.len()).into_par_iter().map(contact).collect();
        let mut lifted = false;
        for ((position, contact), lone) in plan.positions.iter_mut().zip(contacts).zip(&lone) {
            let Some(contact) = contact else { continue };
            position.contact = contact;
            if contact.interferes() && !lone && round < MAX_ROUNDS {
                let lift = contact.depth + LIFT_MARGIN;
                position.tip += position.axis * lift;
                position.lift += lift;
                lifted = true;
            }
        }
        if !lifted {
            break;
        }
    }
    monitor.check()
}
