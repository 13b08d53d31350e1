//! Collisions of a program with the stock that stands, by the solid.
//!
//! The heightfield knows the stock above the floor of one channel; the solid also that beside walls that lean
//! away and in the channels not cut yet, and it meets the whole length of shank and holder. In programs that
//! plunge beside it knows what passes along curves have left of the stock in the way of a core.

use super::super::fault::{FaultKind, Finding, core_in_stock};
use super::steps::CutterStep;
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn, core_contacts};
use crate::geometry::{CutterSolid, Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::Tool;
use crate::stock::solid::{
    Contact, SolidBlank, SolidError, SolidMove, SolidStock, SolidTool, ToolPart, ToolPose,
};

/// Spacing of the rays as a share of the largest diameter of the blank.
const SPACING_SHARE: f64 = 1.0 / 400.0;

/// Where parts of the tools that must not meet stock meet it; `number` of a contact is the index of its step.
///
/// # Errors
/// When cancelled.
pub(super) fn collisions(
    part: &Impeller,
    blank: &Blank,
    tools: &[Tool],
    steps: &[CutterStep],
    monitor: &Monitor,
) -> Result<Vec<Contact>, Cancelled> {
    let solid = SolidBlank::of(part, blank);
    let (low, high) = solid.bounds();
    let spacing = SPACING_SHARE * (high.x - low.x).max(high.y - low.y);
    let own = tools;
    let tools: Vec<SolidTool> = tools.iter().map(SolidTool::of).collect();
    let simulated = SolidStock::new(&solid, spacing)
        .and_then(|mut stock| stock.make_moves(&tools, &moves(part, steps), monitor));
    match simulated {
        Ok(contacts) => judge_cores(part, blank, own, steps, contacts, monitor),
        Err(SolidError::Cancelled(cancelled)) => Err(cancelled),
        // At this spacing a blank fits the memory allowed; stock in more pieces than that is not milling.
        Err(_) => Ok(Vec::new()),
    }
}

/// The steps where the program has them, in their channels.
fn moves(part: &Impeller, steps: &[CutterStep]) -> Vec<SolidMove> {
    (0u32..)
        .zip(steps)
        .map(|(number, step)| {
            let turn = part.pitch() * step.channel as f64;
            let pose = |(tip, axis): &(Point, Vector)| {
                if step.channel == 0 {
                    ToolPose { tip: *tip, axis: *axis }
                } else {
                    ToolPose { tip: rotate_z(tip, turn), axis: rotate_vector_z(axis, turn) }
                }
            };
            let (from, to) = (pose(&step.from), pose(&step.to));
            SolidMove { number, tool: step.tool, rapid: step.feed.is_none(), from, to }
        })
        .collect()
}

/// Replaces the contacts of cores by the exact ones where only plunges can have cut before: the solid
/// resolves no thin contact. Elsewhere a core is free where it is free after the plunges alone, and else the
/// solid decides.
fn judge_cores(
    part: &Impeller,
    blank: &Blank,
    tools: &[Tool],
    steps: &[CutterStep],
    contacts: Vec<Contact>,
    monitor: &Monitor,
) -> Result<Vec<Contact>, Cancelled> {
    let (cores, mut judged): (Vec<Contact>, Vec<Contact>) =
        contacts.into_iter().partition(|contact| contact.part == ToolPart::Core);
    let goes_in = |step: &CutterStep| {
        step.feed.is_some() && step.is_axial() && (step.to.0 - step.from.0).dot(&step.to.1) < 0.0
    };
    // A plunge is followed by its retract. What a pass follows is the approach to it, by a cutter for passes.
    let is_plunge = |k: usize| {
        let next = steps[k..].iter().find(|step| !goes_in(step));
        goes_in(&steps[k]) && next.is_none_or(|next| next.feed.is_none() || next.is_axial())
    };
    let plunges: Vec<usize> = (0..steps.len()).filter(|&k| is_plunge(k)).collect();
    if plunges.is_empty() {
        return Ok(judged);
    }
    let top = BlankTop::new(blank);
    let end = |k: usize| {
        let turn = part.pitch() * steps[k].channel as f64;
        let (tip, axis) = steps[k].to;
        tools[steps[k].tool].placed(rotate_z(&tip, turn), rotate_vector_z(&axis, turn))
    };
    let column = |k: usize| PlungeColumn::new(end(k), tools[steps[k].tool].core_radius(), &top);
    let columns: Columns = plunges.iter().map(|&k| column(k)).collect();
    let exact = core_contacts(&columns, blank, monitor)?;
    // What mills across its axis, as a column that contains its sweep.
    let passes: Vec<(usize, CutterSolid)> = (0..steps.len())
        .filter(|&k| steps[k].feed.is_some() && !steps[k].is_axial())
        .map(|k| {
            let (cutter, step) = (end(k), &steps[k]);
            let aside = step.length() + step.turn() * tools[step.tool].overhang;
            (k, CutterSolid { radius: cutter.radius + aside, ..cutter })
        })
        .collect();
    for ((&k, contact), column) in plunges.iter().zip(exact).zip(columns.as_slice()) {
        if !contact.interferes() {
            continue;
        }
        let before = passes.partition_point(|(pass, _)| *pass < k);
        let cutter = column.cutter;
        if passes[..before].iter().any(|(_, pass)| column.may_meet(pass)) {
            judged.extend(cores.iter().filter(|core| core.number as usize == k));
        } else {
            let depth = contact.depth;
            judged.push(Contact { number: k as u32, part: ToolPart::Core, depth, point: cutter.tip });
        }
    }
    judged.sort_by_key(|contact| (contact.number, contact.part));
    Ok(judged)
}

/// The fault of a contact in a step with tool number `tool`.
pub(super) fn finding(contact: &Contact, tool: u32) -> Finding {
    let depth = contact.depth;
    let (kind, what) = match contact.part {
        ToolPart::Cutter => (
            FaultKind::RapidInStock,
            format!(
                "the cutter meets stock in rapid, {depth:.2} mm deep; remove it first, or move under feed"
            ),
        ),
        ToolPart::Shank => (
            FaultKind::ShankCollision,
            format!(
                "the shank of tool {tool} runs {depth:.2} mm into remaining stock; remove it first, or give a \
                 thinner shank"
            ),
        ),
        ToolPart::Core => return core_in_stock(depth, None),
        ToolPart::Holder => (
            FaultKind::HolderInStock,
            format!(
                "the holder of tool {tool} runs {depth:.2} mm into remaining stock; remove it first, tilt the \
                 axis, or give the tool more overhang"
            ),
        ),
    };
    Finding::new(kind, depth, what)
}
