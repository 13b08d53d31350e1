//! Panel "Policies": what each policy that was planned comes to, side by side.

use egui::{Align, Layout, RichText, Ui};

use crate::job::Summary;
use crate::part::AxisPolicy;

use super::super::planned::Planned;
use super::super::theme::Condition;
use super::setup::policy_label;
use super::verdict::{duration, pair, percent};

/// Draws the switch and the figures; a policy that is finished in the plan in the making, `coming`, stands there already.
pub fn show(ui: &mut Ui, compare: &mut bool, planned: Option<&Planned>, coming: Option<&Planned>) {
    ui.checkbox(compare, "Compare all policies")
        .on_hover_text("Plan by every policy next time, not only by the one that is chosen");
    let Some(whole) = planned.or(coming) else { return };
    for policy in AxisPolicy::ALL {
        let of = [coming, Some(whole)].into_iter().flatten().find(|planned| planned.has(policy));
        let Some(summary) = of.map(|planned| &planned.result(policy).summary) else { continue };
        let name = RichText::new(policy_label(policy));
        let is_asked = policy == whole.outcome.after.plan.policy;
        lines(ui, if is_asked { name.strong() } else { name }, summary);
    }
}

/// What a policy comes to, in two lines: a table of all figures is wider than the panel.
fn lines(ui: &mut Ui, policy: RichText, summary: &Summary) {
    ui.horizontal(|ui| {
        ui.label(policy);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let count = summary.interferential;
            let condition = if count == 0 { Condition::Sound } else { Condition::Interferential };
            ui.label(RichText::new(format!("{count} interferential")).color(condition.text(ui.visuals())))
                .on_hover_text("Positions whose dead centre meets stock");
        });
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (figure, tip) in [
            (format!("{} mm", pair(summary)), "Mean and 95th percentile of what is left on the hub"),
            (
                format!("{} uncut", percent(summary.uncut_share)),
                "Share of the reachable floor that no position reaches",
            ),
            (duration(summary.time_estimate), "One channel, from plunge feeds and rapids"),
        ] {
            ui.label(RichText::new(figure).weak()).on_hover_text(tip);
        }
    });
}
