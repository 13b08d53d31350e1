//! Extends the plan of one channel to several: order of the plunges, links between them, and contact over all
//! plunges in cutting order.

use super::cut::CORE_GAP_MM;
use super::evaluation::{MeasuredPlunges, evaluated};
use super::links::raise_links;
use super::plan::{Evaluation, PlungeMotion, PlungePlan, Position};
use crate::cutting::contact::{Columns, CoreContact, Engagement, core_contacts};
use crate::geometry::{Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::{ChannelOrder, ChannelSequence, ChannelSetup, SectionKind, Setup};
use crate::toolpath::{ChannelStep, OpenedPlaces, order_steps};

/// Maximum number of lifts of the plunges; contact that remains is reported as interference.
const MAX_ITERATIONS: usize = 8;
/// Shortest way down in rapid that is worth a move of its own, mm.
const MIN_DESCENT: f64 = 1.0;

/// Plan of the first `channels` channels of `part` in the sequence of `setup`, given the plan `one` of
/// channel 1. Links and approaches keep the distances of `setup` from `blank`.
///
/// The order is that of `setup`: tool by tool, so that no tool is loaded twice, and channel by channel with
/// each tool; or channel by channel. A plunge whose core meets stock only because of that order is lifted
/// clear; one that interferes in channel 1 as well is left unchanged.
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
    let (plunges, mut plan) = ordered_and_repeated(one, part, setup.channels, channels);
    if channels <= 1 {
        return Ok(plan);
    }
    let (contacts, columns) = free_cores(&mut plan, blank, monitor)?;
    let retracts: Vec<Point> = plan.positions.iter().map(|p| p.evaluation.retract).collect();
    // Those of channel 1 are on the safe side: where plunges of other channels come earlier, a plunge engages
    // less stock and its lead-out has more space.
    let motions: Vec<(Engagement, PlungeMotion)> =
        plan.positions.iter().map(|p| (p.evaluation.engagement, p.evaluation.motion)).collect();
    let measured = MeasuredPlunges { contacts, motions, retracts: retracts.clone() };
    let mut plan = evaluated(plan, measured, &columns, (part, blank), setup, monitor)?;
    descend_after_links(&mut plan, &plunges, &retracts, setup.channels.sequence);
    Ok(plan)
}

/// Lets the plunges at both ends of a link between channels that are no neighbours come down in rapid to
/// their own retract point, one of `retracts`. Links across the wheel raise these ends by half its diameter
/// and more: at the feed rate of a plunge that would take minutes each.
fn descend_after_links(
    plan: &mut PlungePlan,
    plunges: &[ChannelStep],
    retracts: &[Point],
    sequence: ChannelSequence,
) {
    if sequence == ChannelSequence::Adjacent {
        return;
    }
    let crosses = |k: usize| plunges.get(k + 1).is_some_and(|next| next.channel != plunges[k].channel);
    for (k, (position, own)) in plan.positions.iter_mut().zip(retracts).enumerate() {
        if !crosses(k) && !k.checked_sub(1).is_some_and(crosses) {
            continue;
        }
        let [height, raised] =
            [own, &position.evaluation.retract].map(|point| (point - position.tip).dot(&position.axis));
        let motion = &mut position.evaluation.motion;
        if motion.approach.is_none() && raised - height > MIN_DESCENT {
            motion.approach = Some(height);
        }
    }
}

/// The plunges of a program for the first `channels` channels of the sequence of `order`, in cutting order:
/// each a position of the plan `one` of channel 1. See [`order_steps`].
pub fn order_plunges(
    one: &PlungePlan,
    part: &Impeller,
    order: ChannelSetup,
    channels: usize,
) -> Vec<ChannelStep> {
    let opens = |p: &Position| one.sections[p.section].kind == SectionKind::Opening;
    let tool = |p: &Position| &one.sections[p.section].tool;
    let stretches = one.positions.chunk_by(|a, b| tool(a) == tool(b) && opens(a) == opens(b));
    let stretches: Vec<usize> = stretches.map(<[Position]>::len).collect();
    let mut opened = OpenedPlaces::default();
    order_steps(&stretches, order, channels, part.blade_count, |channel, index| {
        let p = &one.positions[index];
        !opens(p) || opened.open(&p.tip, part.pitch() * channel as f64)
    })
}

/// The positions of channel 1, rotated into each of the first `channels` channels of the sequence of `order`:
/// those of [`plan_channels`] before any is lifted, or a link raised. Row numbers continue from channel to
/// channel in that sequence.
pub fn repeat_for_channels(
    one: &PlungePlan,
    part: &Impeller,
    order: ChannelSetup,
    channels: usize,
) -> PlungePlan {
    ordered_and_repeated(one, part, order, channels).1
}

/// The plunges of [`order_plunges`], with the plan of [`repeat_for_channels`] that they make.
fn ordered_and_repeated(
    one: &PlungePlan,
    part: &Impeller,
    order: ChannelSetup,
    channels: usize,
) -> (Vec<ChannelStep>, PlungePlan) {
    let plunges = order_plunges(one, part, order, channels);
    let plan = repeat_plunges(one, part, &plunges, channels);
    (plunges, plan)
}

/// As [`plan_channels`], but plunges whose cores meet stock only in the order of several channels are not
/// lifted: the links from channel to channel are raised alone, in a small part of the time. For the time of a
/// program that is not written.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn link_channels(
    one: &PlungePlan,
    part: &Impeller,
    blank: &Blank,
    setup: &Setup,
    channels: usize,
    monitor: &Monitor,
) -> Result<PlungePlan, Cancelled> {
    let (plunges, mut plan) = ordered_and_repeated(one, part, setup.channels, channels);
    let retracts: Vec<Point> = plan.positions.iter().map(|p| p.evaluation.retract).collect();
    let mut pair = PlungePlan { positions: Vec::new(), ..one.clone() };
    for k in 0..plunges.len().saturating_sub(1) {
        if plunges[k].channel == plunges[k + 1].channel {
            continue;
        }
        pair.positions = plan.positions[k..=k + 1].to_vec();
        let ends = pair.positions.iter().map(|p| p.evaluation.retract).collect();
        let lead_outs: Vec<Vector> = pair.positions.iter().map(|p| p.evaluation.motion.lead_out).collect();
        let raised = raise_links(&pair, ends, &lead_outs, blank, setup.allowances.safety_distance, monitor)?;
        for (position, (retract, _)) in plan.positions[k..=k + 1].iter_mut().zip(raised) {
            position.evaluation.retract = retract;
        }
    }
    descend_after_links(&mut plan, &plunges, &retracts, setup.channels.sequence);
    Ok(plan)
}

/// The plunges of `channels` channels in their order.
fn repeat_plunges(one: &PlungePlan, part: &Impeller, plunges: &[ChannelStep], channels: usize) -> PlungePlan {
    let position = |&ChannelStep { channel, place, index }: &ChannelStep| {
        let (p, angle) = (&one.positions[index], part.pitch() * channel as f64);
        Position {
            tip: rotate_z(&p.tip, angle),
            axis: rotate_vector_z(&p.axis, angle),
            contact_point: rotate_z(&p.contact_point, angle),
            row: p.row + place * one.sections[p.section].rows,
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
        }
    };
    let mut plan = PlungePlan { positions: plunges.iter().map(position).collect(), ..one.clone() };
    for section in &mut plan.sections {
        section.rows *= channels;
    }
    plan
}

/// How often a tool is loaded in the program for `channels` channels, given the plan `one` of channel 1.
pub fn count_tool_loads(one: &PlungePlan, order: ChannelOrder, channels: usize) -> usize {
    let tool = |p: &Position| one.sections[p.section].tool.number;
    let of_one = one.positions.chunk_by(|a, b| tool(a) == tool(b)).count();
    match (order, one.positions.as_slice()) {
        (ChannelOrder::ChannelByChannel, [first, .., last]) => {
            // The first tool of a channel may be the last one of the channel before.
            let kept = usize::from(tool(first) == tool(last));
            of_one + channels.saturating_sub(1) * (of_one - kept)
        }
        _ => of_one,
    }
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
                let lift = contact.depth + CORE_GAP_MM;
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
