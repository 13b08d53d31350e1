//! The second half of planning: contact of the cores, retract points and links of a plan whose axes and
//! depths are final. Every [`Evaluation`] of the planner is made here.

use rayon::prelude::*;

use super::approach::add_approaches;
use super::context::PlanContext;
use super::error::PlanError;
use super::links::raise_links;
use super::motion::{motions, with_lead_outs};
use super::plan::{Evaluation, PlungeMotion, PlungePlan};
use super::reasons::Breach;
use super::whole_plan::PlacedPlan;
use crate::cutting::contact::{Columns, CoreContact, Engagement, core_contact};
use crate::cutting::retract::RetractSurface;
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::Setup;

/// Clearance added to the safety distance at a retract point, mm: between two samples of a link the distance
/// may dip by some µm.
const RETRACT_MARGIN: f64 = 0.02;

/// The second half of planning: contact of the cores, retract points and links. A stopped monitor is
/// ignored here, so that partial plans are measured too.
///
/// # Errors
/// [`PlanError::Cancelled`] when the monitor is cancelled.
pub(super) fn evaluate(
    context: &PlanContext,
    placed: PlacedPlan,
    monitor: &Monitor,
) -> Result<PlungePlan, PlanError> {
    let PlacedPlan { plan, columns } = placed;
    Ok(measure(context, plan, &columns, &monitor.ignoring_stop())?)
}

/// As [`evaluate`] of `plan`, whose plunges are `columns`; a stop ends it, too.
///
/// # Errors
/// When `monitor` is cancelled or stopped.
pub(super) fn measure<E: Sync>(
    context: &PlanContext,
    plan: PlungePlan<E>,
    columns: &Columns,
    monitor: &Monitor,
) -> Result<PlungePlan, Cancelled> {
    let (blank, safety) = (&context.workpiece.blank, context.setup.allowances.safety_distance);
    let tops: Vec<RetractSurface> = plan
        .sections
        .iter()
        .map(|section| RetractSurface::new(blank, safety + section.tool.corner_radius))
        .collect();
    let measured: Result<Vec<(CoreContact, Point)>, Cancelled> = plan
        .positions
        .par_iter()
        .enumerate()
        .map(|(k, position)| {
            monitor.check()?;
            let tool = &plan.sections[position.section].tool;
            let column = &columns.as_slice()[k];
            let cutter = column.cutter;
            let lift =
                tops[position.section].height(&cutter.tip, &cutter.axis, tool.radius() - tool.corner_radius);
            let retract = cutter.tip + cutter.axis * (lift + RETRACT_MARGIN);
            Ok((core_contact(column, columns.before(k), blank), retract))
        })
        .collect();
    let (contacts, retracts): (Vec<CoreContact>, Vec<Point>) = measured?.into_iter().unzip();
    let motions = motions(context, &plan, columns, monitor)?;
    let measured = MeasuredPlunges { contacts, motions, retracts };
    Ok(with_lead_outs(
        context,
        evaluated(plan, measured, columns, (&context.workpiece.part, blank), context.setup, monitor)?,
    ))
}

/// What is measured of each position of a plan by itself and those before it.
pub(super) struct MeasuredPlunges {
    pub contacts: Vec<CoreContact>,
    pub motions: Vec<(Engagement, PlungeMotion)>,
    /// Retract points over the blank, before links are raised.
    pub retracts: Vec<Point>,
}

/// `plan`, whose plunges are `columns`, with what was `measured` of its positions; their retract points
/// raised until links keep the safety distance from the blank, and with rapid approaches from there.
///
/// # Errors
/// When `monitor` is cancelled.
pub(super) fn evaluated<E: Sync>(
    plan: PlungePlan<E>,
    measured: MeasuredPlunges,
    columns: &Columns,
    (part, blank): (&Impeller, &Blank),
    setup: &Setup,
    monitor: &Monitor,
) -> Result<PlungePlan, Cancelled> {
    let MeasuredPlunges { contacts, mut motions, retracts } = measured;
    let lead_outs: Vec<Vector> = motions.iter().map(|(_, motion)| motion.lead_out).collect();
    let raised = raise_links(&plan, retracts, &lead_outs, blank, setup.allowances.safety_distance, monitor)?;
    add_approaches(&plan, &raised, &mut motions, columns, blank, setup, monitor)?;
    let breaches: Vec<Option<Breach>> = plan.positions.iter().map(|p| p.breach(part, setup)).collect();
    Ok(plan.with_evaluations(|k| {
        let (retract, retract_clearance) = raised[k];
        let (engagement, motion) = motions[k];
        let (contact, breach) = (contacts[k], breaches[k]);
        Evaluation { contact, retract, retract_clearance, engagement, motion, breach }
    }))
}
