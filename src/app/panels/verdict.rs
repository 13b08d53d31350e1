//! The verdict, one line: does it interfere, how much is left, is anything cut that should not be,
//! how long does it take.

use egui::{RichText, Ui};

use crate::job::Summary;
use crate::plunge::{NoPlace, PlungePlan};

use super::super::planned::Side;
use super::super::state::State;
use super::super::theme::{self, Condition};

/// A share below this reads as 0.0 %.
const LEAST_SHOWN: f64 = 0.0005;

/// Draws the line.
pub fn show(ui: &mut Ui, state: &State) {
    // Figures of one setup: those of a plan in the making stand in the views until it is whole.
    let Some((before, after)) = state.before_edit(Side::Before).zip(state.before_edit(Side::After)) else {
        ui.label(RichText::new("No plan yet").weak());
        return;
    };
    if state.out_of_date() {
        let text = RichText::new("Out of date:").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("The setup was edited after this plan");
    }
    let plan = after.plan();
    if plan.is_unfinished() {
        let text = RichText::new("Unfinished:").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text(
            "Planning was cancelled: this is the best so far. What it does not cut yet counts as uncut",
        );
    }
    let planned = after.planned;
    let (before, after) = (&planned.result(before.policy).summary, &planned.result(after.policy).summary);
    interferential(ui, plan, before, after);
    if after.blocked > 0 {
        let text =
            RichText::new(format!("{} blocked", after.blocked)).color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("Positions that could not get the axis the policy asks for");
    }
    let dropped = plan.dropped.len();
    if dropped > 0 {
        let left_out = |why: NoPlace| {
            let count = plan.dropped.iter().filter(|d| d.why == why).count();
            (count > 0).then(|| format!("{count} {}", why.words()))
        };
        let text = RichText::new(format!("{dropped} left out")).color(Condition::Blocked.text(ui.visuals()));
        let reasons: Vec<String> = NoPlace::ALL.into_iter().filter_map(left_out).collect();
        ui.label(text).on_hover_text(format!("Positions left out: {}", reasons.join(", ")));
    }
    ui.separator();
    figure(
        ui,
        "Hub stock",
        format!("{} to {} mm", pair(before), pair(after)),
        "Mean and 95th percentile of what is left on the hub, before and after",
    );
    let stock = &planned.setup.stock;
    ui.separator();
    clearance(ui, "Hub clearance", after.min_hub_clearance, stock.hub_allowance);
    clearance(ui, "blade", after.min_blade_clearance, stock.blade_allowance);
    ui.separator();
    figure(ui, "Uncut", percent(after.uncut_share), "Share of the reachable floor that no position reaches");
    if after.unreachable_share >= LEAST_SHOWN {
        let tip = "Share of the floor under walls that lean over it, out of reach of every axis";
        figure(ui, "Out of reach", percent(after.unreachable_share), tip);
    }
    ui.separator();
    figure(
        ui,
        "Time",
        duration(after.time_estimate),
        "One channel, from plunge feeds and rapids; without tool changes",
    );
}

fn interferential(ui: &mut Ui, plan: &PlungePlan, before: &Summary, after: &Summary) {
    let sound = after.interferential == 0;
    let colour = if sound { Condition::Sound } else { Condition::Interferential }.text(ui.visuals());
    let text = format!("Interferential {} to {}", before.interferential, after.interferential);
    let depths = format!(
        "Positions whose dead centre meets stock: {} of {} before (deepest {:.2} mm), {} of {} after (deepest {:.2} mm)",
        before.interferential,
        before.positions,
        before.max_contact_depth,
        after.interferential,
        after.positions,
        after.max_contact_depth,
    );
    ui.label(RichText::new(text).strong().color(colour)).on_hover_text(depths);
    if !plan.settled {
        let text = RichText::new("not settled").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("The planner's loop stopped before it came to rest");
    }
}

fn figure(ui: &mut Ui, name: &str, value: String, tip: &str) {
    ui.label(RichText::new(name).weak()).on_hover_text(tip);
    ui.label(value).on_hover_text(tip);
}

/// A clearance below the allowance (by more than 1 µm) is a cut where none should be.
fn clearance(ui: &mut Ui, name: &str, value: f64, allowance: f64) {
    let short = value < allowance - 1e-3;
    let tip = format!("Least distance of a cutter to the finished surface; the allowance is {allowance} mm");
    ui.label(RichText::new(name).weak()).on_hover_text(&tip);
    let text = if value.is_finite() { format!("{value:.2} mm") } else { "-".to_owned() };
    let colour = Condition::Interferential.text(ui.visuals());
    let text = if short {
        RichText::new(text + " (too little)").strong().color(colour)
    } else {
        RichText::new(text)
    };
    ui.label(text).on_hover_text(tip);
}

/// Mean and 95th percentile of the residual layer.
pub fn pair(summary: &Summary) -> String {
    let show = |v: f64| if v.is_finite() { format!("{v:.2}") } else { "-".to_owned() };
    format!("{}/{}", show(summary.residual_mean), show(summary.residual_p95))
}

/// A share as per cent.
pub fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.1} %", 100.0 * share) } else { "-".to_owned() }
}

/// Seconds as a person says them.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return "-".to_owned();
    }
    let minutes = seconds / 60.0;
    match minutes {
        m if m < 1.0 => format!("{seconds:.0} s"),
        m if m < 90.0 => format!("{m:.0} min"),
        m => format!("{:.1} h", m / 60.0),
    }
}

/// Height of the line, points.
pub const HEIGHT: f32 = theme::ROW_HEIGHT + 9.0;
