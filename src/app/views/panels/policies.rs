//! Panel "Axis strategies": figures of each planned policy.

use egui::{Align, Layout, RichText, Ui};

use crate::job::PolicyResult;
use crate::setup::AxisPolicy;

use crate::app::model::figures::{
    INTERFERING_TIP, MAX_GOOD_UNCUT_SHARE, TimeUnits, format_percent, format_residual, policy_label,
    policy_tip, times_tip,
};
use crate::app::model::planned::DisplayPlan;
use crate::app::views::command::Command;
use crate::app::views::theme::{Condition, width_of_text};
use crate::app::views::units;

/// Draws the switch and the figures; a policy that the running task has finished, in its `preview`, goes
/// first. Those of `planned` are marked where it `is_stale`.
pub fn show(
    ui: &mut Ui,
    compare: &mut bool,
    (planned, is_stale): (Option<&DisplayPlan>, bool),
    preview: Option<&DisplayPlan>,
) {
    ui.checkbox(compare, Command::CompareAll.label())
        .on_hover_text("The next calculation plans every strategy, not only the chosen one");
    let Some(whole) = planned.or(preview) else { return };
    let channels = whole.outcome.workpiece.part.blade_count;
    let shown = |policy: AxisPolicy| {
        let (of, is_stale) = match preview.filter(|preview| preview.has(policy)) {
            Some(preview) => (preview, false),
            None => (whole, is_stale),
        };
        of.has(policy).then(|| (of.result(policy), is_stale))
    };
    let shown: Vec<(&PolicyResult, bool)> = AxisPolicy::ALL.into_iter().filter_map(shown).collect();
    let times = TimeUnits::of_plans(shown.iter().map(|(result, _)| &result.summary), channels);
    for (result, is_stale) in shown {
        let policy = result.plan.policy;
        let name = RichText::new(policy_label(policy));
        let is_asked = policy == whole.outcome.after.plan.policy;
        let name = if is_asked { name.strong() } else { name };
        lines(ui, name, result, (&times.plan_text(&result.summary, channels), is_stale));
    }
}

/// Figures of a policy in three lines, four where the panel is narrow; a table would be wider than it.
fn lines(ui: &mut Ui, name: RichText, result: &PolicyResult, (times, is_stale): (&str, bool)) {
    let summary = &result.summary;
    let count = result.plan.count_interfering();
    let verdict = format!("{count} interfering");
    let (verdict, condition) = match count {
        _ if is_stale => (format!("Out of date: {verdict}"), Condition::Blocked),
        0 => (verdict, Condition::Sound),
        _ => (verdict, Condition::Interfering),
    };
    let room = ui.available_width() - ui.spacing().item_spacing.x;
    let is_one_line = width_of_text(ui, name.text()) + width_of_text(ui, &verdict) <= room;
    let verdict = RichText::new(verdict).color(condition.text(ui.visuals()));
    ui.horizontal(|ui| {
        ui.label(name).on_hover_text(policy_tip(result.plan.policy));
        if is_one_line {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.label(verdict.clone()).on_hover_text(INTERFERING_TIP);
            });
        }
    });
    if !is_one_line {
        ui.label(verdict).on_hover_text(INTERFERING_TIP);
    }
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let units = units::display_units(ui);
        let residual = format!("{} {}", format_residual(summary, units), units.length_unit());
        ui.label(RichText::new(residual).weak())
            .on_hover_text("Residual stock on the hub: mean and 95th percentile");
        let uncut = RichText::new(format!("{} not machined", format_percent(summary.uncut_share)));
        let uncut = match summary.uncut_share > MAX_GOOD_UNCUT_SHARE {
            true => uncut.color(Condition::Blocked.text(ui.visuals())),
            false => uncut.weak(),
        };
        ui.label(uncut).on_hover_text("Share of the accessible floor that is not machined");
    });
    ui.label(RichText::new(times).weak()).on_hover_text(times_tip(summary));
}
