//! The verdict line: interfering plunges, residual stock, clearances, share not machined, time.

use egui::{RichText, Ui};

use super::figures::{divide, divided_figure, figure, keep_together};
use crate::job::PolicyResult;
use crate::plunge::{Breach, DropReason};
use crate::setup::falls_short;
use crate::stock::InaccessibleFloor;

use crate::app::model::figures::{
    MAX_GOOD_UNCUT_SHARE, format_percent, format_plan_times, format_residual, interfering_words, times_tip,
};
use crate::app::model::look::Operation;
use crate::app::model::planned::{DisplayPlan, Side};
use crate::app::model::state::AppState;
use crate::app::model::units::{DisplayUnits, decimals_beside};
use crate::app::model::verdict;
use crate::app::views::theme::{self, Condition};
use crate::app::views::units;

/// Shares below this would show as 0.0 %.
const MIN_SHOWN_SHARE: f64 = 0.0005;

/// Draws the line of the selected operation. Where it is too long, it breaks between figures, and not within
/// one.
pub fn show(ui: &mut Ui, state: &AppState) {
    ui.horizontal_wrapped(|ui| {
        // Lines as close as those of a text.
        ui.spacing_mut().item_spacing.y = 0.0;
        match state.look.operation {
            Operation::Roughing => roughing(ui, state),
            Operation::Flank => super::flank_results::verdict(ui, state),
            Operation::Program => super::program::verdict(ui, state),
        }
    });
}

fn roughing(ui: &mut Ui, state: &AppState) {
    // Both sides from one whole plan: figures of a running task appear only in the views.
    let Some((before, after)) = state.last_whole_plan(Side::Before).zip(state.last_whole_plan(Side::After))
    else {
        ui.label(RichText::new(state.results.words_without_plan()).weak());
        return;
    };
    if state.out_of_date() {
        let text = RichText::new("Out of date:").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("The setup was edited after this calculation");
    }
    let plan = after.plan();
    if plan.is_unfinished() {
        let text = RichText::new("Unfinished:").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text(
            "The calculation was cancelled: the best so far. Floor not cut yet counts as not machined",
        );
    }
    if let Some(missed) = state.missed_goal() {
        let text = RichText::new("Goal cannot be met").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text(missed);
    }
    let (planned, units) = (after.planned, state.look.units);
    let (before, after) = (planned.result(before.policy), planned.result(after.policy));
    interferential(ui, state, before, after);
    let (before, after) = (&before.summary, &after.summary);
    if let Some(words) = state.unapplied_words() {
        let text = RichText::new(words).color(Condition::Blocked.text(ui.visuals()));
        ui.label(text)
            .on_hover_text("The plan no longer has the plunge that was edited. The tab \"By hand\" of a position lists the reasons");
    }
    let dropped = plan.dropped.len();
    // Those that were left out follow beside their reasons.
    let blocked = after.blocked.map_or(0, |blocked| blocked.saturating_sub(dropped));
    if blocked > 0 {
        let text = RichText::new(format!("{blocked} blocked")).color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("Positions that cannot have the axis of the strategy");
    }
    if dropped > 0 {
        let left_out = |why: DropReason| {
            let count = plan.dropped.iter().filter(|d| d.why == why).count();
            (count > 0).then(|| format!("{count} {}", why.words()))
        };
        let text = RichText::new(format!("{dropped} skipped")).color(Condition::Blocked.text(ui.visuals()));
        let reasons: Vec<String> = DropReason::ALL.into_iter().filter_map(left_out).collect();
        ui.label(text).on_hover_text(format!("Skipped positions: {}", reasons.join(", ")));
    }
    divided_figure(
        ui,
        "Residual",
        format!(
            "{} to {} {}",
            format_residual(before, units),
            format_residual(after, units),
            units.length_unit()
        ),
        "Residual stock on the hub: mean and 95th percentile, before and after",
    );
    let stock = &planned.setup.allowances;
    clearance(ui, "Hub clearance", after.min_hub_clearance, stock.hub_allowance, divide);
    clearance(ui, "blade", after.min_blade_clearance, stock.blade_allowance, keep_together);
    let tip = "Share of the accessible floor that is not cut";
    let share = format_percent(after.uncut_share);
    divide(ui, &["Not machined", &share]);
    ui.label(RichText::new("Not machined").weak()).on_hover_text(tip);
    let share = RichText::new(share);
    let share = match after.uncut_share > MAX_GOOD_UNCUT_SHARE {
        true => share.strong().color(Condition::Blocked.text(ui.visuals())),
        false => share,
    };
    ui.label(share).on_hover_text(tip);
    if after.inaccessible_share >= MIN_SHOWN_SHARE {
        let share = format_percent(after.inaccessible_share);
        figure(ui, "Inaccessible", share, &inaccessible_tip(planned, units));
    }
    divided_figure(
        ui,
        "Time",
        format_plan_times(after, planned.outcome.workpiece.part.blade_count),
        times_tip(after),
    );
}

/// What makes floor inaccessible, the largest share first.
fn inaccessible_tip(planned: &DisplayPlan, units: DisplayUnits) -> String {
    let line = |floor: &InaccessibleFloor| {
        let (share, tool) = (format_percent(floor.share), units.diameter(floor.diameter));
        let (words, from, to) = (floor.obstacle.words(), floor.from, floor.to);
        format!("\n{share} for {tool}: {words}, s = {from:.2} to {to:.2}")
    };
    let known = planned.outcome.inaccessible_floor.iter().filter(|floor| floor.share >= MIN_SHOWN_SHARE);
    format!("Share of the floor that no tool axis reaches{}", known.map(line).collect::<String>())
}

fn interferential(ui: &mut Ui, state: &AppState, before: &PolicyResult, after: &PolicyResult) {
    let colour = verdict::of_plunges(state, after).0.text(ui.visuals());
    let text = interfering_words([before, after]);
    let (plan, before, after) = (&after.plan, &before.summary, &after.summary);
    let depths = format!(
        "Core meets stock: {} of {} plunges before (deepest {}), {} of {} after (deepest {})",
        before.interfering,
        before.positions,
        units::display_units(ui).length(before.max_contact_depth, 2),
        after.interfering,
        after.positions,
        units::display_units(ui).length(after.max_contact_depth, 2),
    );
    let breach = |k: Breach| plan.positions.iter().filter(|p| p.evaluation.breach == Some(k)).count();
    let breaches = Breach::ALL.map(|kind| (breach(kind), kind.words()));
    let breaches = breaches.iter().filter(|(count, _)| *count > 0);
    let lines: String = breaches.map(|(count, words)| format!("\n{count} after: {words}")).collect();
    ui.label(RichText::new(text).strong().color(colour)).on_hover_text(depths + &lines);
    if !plan.converged {
        let text = RichText::new("not converged").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("The plan loop stopped at its iteration limit before it converged");
    }
}

/// Draws a clearance, mm; one that misses the allowance by more than rounding is a gouge and is highlighted.
/// `begin`: what stands before its words, or begins the next line.
fn clearance(ui: &mut Ui, name: &str, value: f64, allowance: f64, begin: fn(&mut Ui, &[&str])) {
    let short = falls_short(value, allowance);
    let decimals = decimals_beside(allowance);
    let units = units::display_units(ui);
    let allowance = format!("{} {}", units.short(allowance, 6), units.length_unit());
    let tip = format!("Least distance of a cutter to the finished surface; the allowance is {allowance}");
    let text = units.known_length(value, decimals) + if short { " (too little)" } else { "" };
    begin(ui, &[name, &text]);
    ui.label(RichText::new(name).weak()).on_hover_text(&tip);
    let colour = Condition::Interfering.text(ui.visuals());
    let text = RichText::new(text);
    let text = if short { text.strong().color(colour) } else { text };
    ui.label(text).on_hover_text(tip);
}

/// Height of the verdict in a window `width` points wide: one line, or more where one is too narrow for all
/// that may have to be said. It depends on nothing else, so that no verdict moves the picture.
pub fn height(width: f32) -> f32 {
    let lines = match width {
        ..520.0 => 4.0,
        520.0..800.0 => 3.0,
        800.0..1700.0 => 2.0,
        _ => 1.0,
    };
    lines * (theme::ROW_HEIGHT + 3.0) + 6.0
}
