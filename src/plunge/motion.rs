//! How the plunges of a finished plan are moved: feed rate by engagement, interruptions that break the chip,
//! and the lead-out at the end.
//!
//! The lead-out follows the rule of Siemens' cycles (840D sl, operating manual, roughing plunge cutting):
//! where less than half of the circumference is engaged, the tool lifts at 45° against the bisector of the
//! engaged arc before it retracts; otherwise straight along its axis. It is taken only where the cutter keeps
//! its allowances, shank and holder their clearances, and the core and body of the cutter meet no stock on
//! it; shortened where that helps.

use rayon::prelude::*;

use super::assembly::AssemblyRule;
use super::context::PlanContext;
use super::plan::{Pecking, PlungeMotion, PlungePlan, Position};
use crate::cutting::contact::{
    BlankTop, CONTACT_TOLERANCE, Columns, Earlier, Engagement, PlungeColumn, core_contact, engagement,
};
use crate::geometry::{CutterSolid, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::setup::Tool;
use crate::setup::cutting_data::feed_by_engagement;

/// Shares of the wanted lead-out that are tried.
const LEAD_OUT_SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Points of a lead-out that are checked: half a radius apart at most.
const LEAD_OUT_PLACES: usize = 4;
/// Radius of the body of a cutter above its edges, in radii: bodies are relieved.
const BODY_SHARE: f64 = 0.95;
/// Largest engaged arc with a lead-out, rad.
const MAX_LEAD_OUT_ARC_RAD: f64 = std::f64::consts::PI;

/// Engagement and motion of each plunge of `plan`, whose `columns` are given.
///
/// # Errors
/// When `monitor` is cancelled.
pub(super) fn motions<E: Sync>(
    context: &PlanContext,
    plan: &PlungePlan<E>,
    columns: &Columns,
    monitor: &Monitor,
) -> Result<Vec<(Engagement, PlungeMotion)>, Cancelled> {
    let rules: Vec<Option<AssemblyRule>> =
        plan.sections.iter().map(|section| context.assembly_rule(&section.tool)).collect();
    let top = BlankTop::new(&context.workpiece.blank);
    let motion = |(k, position): (usize, &Position<E>)| {
        monitor.check()?;
        let tool = &plan.sections[position.section].tool;
        let whole = PlungeColumn::new(tool.placed(position.tip, position.axis), tool.radius(), &top);
        let engaged = engagement(&whole, columns.before(k), &context.workpiece.blank);
        let rule = rules[position.section].as_ref();
        let lead_out = context.setup.plunge.lead_out.and_then(|length| {
            lead_out(context, length, tool, &whole, &engaged, rule, columns.before(k + 1), &top)
        });
        let motion = PlungeMotion {
            feed_mm_per_min: feed_for(context, tool, &engaged),
            lead_out: lead_out.unwrap_or_default(),
            pecking: context
                .setup
                .plunge
                .peck
                .filter(|depth| whole.top > *depth)
                .map(|depth| Pecking { from: whole.top, depth }),
            approach: None,
        };
        Ok((engaged, motion))
    };
    plan.positions.par_iter().enumerate().map(motion).collect()
}

/// `plan` with the distances of its cutters to hub and blades over their lead-outs, too.
pub(super) fn with_lead_outs(context: &PlanContext, mut plan: PlungePlan) -> PlungePlan {
    if context.setup.plunge.lead_out.is_none() {
        return plan;
    }
    let finished = &context.workpiece.finished;
    let sections = &plan.sections;
    plan.positions.par_iter_mut().for_each(|position| {
        let (motion, tip, axis) = (position.evaluation.motion, position.tip, position.axis);
        let tool = &sections[position.section].tool;
        let travel = motion.led_out(tip, &axis) - tip;
        // As densely as `verify` samples a move; without a lead-out only the end of the plunge.
        let steps = (travel.norm() / (0.5 * tool.radius())).ceil() as usize;
        let at = |k: usize| tool.placed(tip + travel * (k as f64 / steps.max(1) as f64), axis);
        let cutters: Vec<CutterSolid> = (0..=steps).map(at).collect();
        let least = |distance: &dyn Fn(&CutterSolid) -> f64| {
            cutters.iter().map(distance).fold(f64::INFINITY, f64::min)
        };
        position.hub_clearance = least(&|cutter| finished.hub_clearance(cutter));
        position.blade_clearance = least(&|cutter| finished.blade_clearance(cutter));
    });
    plan
}

/// Feed rate by the engagement of a plunge, mm/min; `None`: that of the tool.
fn feed_for(context: &PlanContext, tool: &Tool, engaged: &Engagement) -> Option<f64> {
    if !context.setup.plunge.adapt_feed || engaged.max_arc_rad <= 0.0 {
        return None;
    }
    let range = context.setup.allowances.cutting_data().map(|data| data.feed_range_for(tool.diameter));
    feed_by_engagement(tool, engaged.max_arc_rad, engaged.is_interrupted, range)
}

/// The lead-out across the axis, at most `length` mm and the radius of the cutter long, after the plunges
/// `until` this one; `None` where it is half engaged or more, or no lead-out is free.
#[expect(clippy::too_many_arguments, reason = "one plunge with all that may be in its way")]
fn lead_out(
    context: &PlanContext,
    length: f64,
    tool: &Tool,
    whole: &PlungeColumn,
    engaged: &Engagement,
    rule: Option<&AssemblyRule>,
    until: Earlier,
    top: &BlankTop,
) -> Option<Vector> {
    let bottom_arc = engaged.bottom_arc_rad;
    if bottom_arc <= 0.0 || bottom_arc >= MAX_LEAD_OUT_ARC_RAD || engaged.towards_stock.norm() < 0.5 {
        return None;
    }
    let axis = whole.cutter.axis;
    let allowances = &context.setup.allowances;
    let finished = &context.workpiece.finished;
    let body = tool.core_radius().max(BODY_SHARE * tool.radius());
    let is_free = |tip| {
        let cutter = CutterSolid { tip, ..whole.cutter };
        let column = PlungeColumn::new(cutter, body, top);
        finished.clears(&cutter, allowances.blade_allowance)
            && finished.hub_clearance(&cutter) >= allowances.hub_allowance
            && rule.is_none_or(|rule| rule.obstacle((tip, axis)).is_none())
            && core_contact(&column, until, &context.workpiece.blank).depth <= CONTACT_TOLERANCE
    };
    // Beyond its radius the cutter has left the arc that it engaged.
    let length = length.min(tool.radius());
    LEAD_OUT_SHARES.into_iter().map(|share| -engaged.towards_stock * (share * length)).find(|off| {
        (1..=LEAD_OUT_PLACES).all(|k| {
            let share = k as f64 / LEAD_OUT_PLACES as f64;
            is_free(whole.cutter.tip + (off + axis * off.norm()) * share)
        })
    })
}
