//! Collisions of a program with the stock that stands, by the solid.
//!
//! The heightfield knows the stock above the floor of one channel; the solid also that beside walls that lean away
//! and in the channels not cut yet, and it meets the whole length of shank and holder.

use super::super::fault::{FaultKind, Finding};
use super::steps::CutterStep;
use crate::geometry::{Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::Tool;
use crate::stock::solid::{
    Contact, SolidBlank, SolidError, SolidMove, SolidStock, SolidTool, ToolPart, ToolPose, TurnedOutline,
};

/// Spacing of the rays as a share of the largest diameter of the blank.
const SPACING_SHARE: f64 = 1.0 / 400.0;

/// Where parts of the tools that must not meet stock meet it; `number` of a contact is the index of its step. Cores
/// are left to the check of plunges.
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
    let solid = SolidBlank::Turned(TurnedOutline::of_blank(part, blank));
    let (low, high) = solid.bounds();
    let spacing = SPACING_SHARE * (high.x - low.x).max(high.y - low.y);
    let tools: Vec<SolidTool> = tools.iter().map(SolidTool::of).collect();
    let simulated = SolidStock::new(&solid, spacing)
        .and_then(|mut stock| stock.make_moves(&tools, &moves(part, steps), monitor));
    match simulated {
        Ok(mut contacts) => {
            contacts.retain(|contact| contact.part != ToolPart::Core);
            Ok(contacts)
        }
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
        ToolPart::Holder | ToolPart::Core => (
            FaultKind::HolderInStock,
            format!(
                "the holder of tool {tool} runs {depth:.2} mm into remaining stock; remove it first, tilt the \
                 axis, or give the tool more overhang"
            ),
        ),
    };
    Finding::new(kind, depth, what)
}
