//! Panel "Policies": what each policy that was planned comes to, side by side.

use egui::{Grid, RichText, ScrollArea, Ui};

use crate::part::AxisPolicy;

use super::super::planned::Planned;
use super::super::theme::Condition;
use super::setup::policy_label;
use super::verdict::{duration, pair, percent};

/// Draws the switch and the table; a policy that is finished in the plan in the making, `coming`, stands there already.
pub fn show(ui: &mut Ui, compare: &mut bool, planned: Option<&Planned>, coming: Option<&Planned>) {
    ui.checkbox(compare, "Compare all policies")
        .on_hover_text("Plan by every policy next time, not only by the one that is chosen");
    let Some(whole) = planned.or(coming) else { return };
    // Wider than the panel on small screens: better scrolled than squeezing the picture.
    ScrollArea::horizontal().show(ui, |ui| table(ui, whole, coming));
}

fn table(ui: &mut Ui, planned: &Planned, coming: Option<&Planned>) {
    Grid::new("policies").num_columns(5).spacing([10.0, 2.0]).striped(true).show(ui, |ui| {
        for (name, tip) in [
            ("Policy", "How the axes are made"),
            ("Interf.", "Positions whose dead centre meets stock"),
            ("Stock mm", "Mean and 95th percentile of what is left on the hub"),
            ("Uncut", "Share of the floor that no position reaches"),
            ("Time", "One channel, from plunge feeds and rapids"),
        ] {
            ui.label(RichText::new(name).weak()).on_hover_text(tip);
        }
        ui.end_row();
        for policy in AxisPolicy::ALL {
            let of = [coming, Some(planned)].into_iter().flatten().find(|planned| planned.has(policy));
            let Some(s) = of.map(|planned| &planned.result(policy).summary) else { continue };
            let name = RichText::new(policy_label(policy));
            ui.label(if policy == planned.outcome.after.plan.policy { name.strong() } else { name });
            let sound = s.interferential == 0;
            let condition = if sound { Condition::Sound } else { Condition::Interferential };
            ui.label(RichText::new(s.interferential.to_string()).color(condition.text(ui.visuals())));
            ui.label(pair(s));
            ui.label(percent(s.uncut_share));
            ui.label(duration(s.time_estimate));
            ui.end_row();
        }
    });
}
