//! The question before a program leaves the window: what is wrong with it.

use std::path::PathBuf;

use egui::{Modal, RichText, Ui};

use crate::plunge::DropReason;

use super::App;
use super::command::Command;
use super::dialogs::Purpose;
use super::panels::verdict::{MAX_GOOD_UNCUT_SHARE, format_percent};
use super::state::AppState;
use super::theme::Condition;

/// Clearance below its allowance that is rounding, mm.
const ROUNDING: f64 = 1e-3;

/// A program that waits for an answer.
#[derive(Debug)]
pub(super) struct ReleaseQuestion {
    purpose: Purpose,
    path: PathBuf,
    concerns: Vec<String>,
}

/// What speaks against running the program that `purpose` writes, the gravest first; none for other files.
fn concerns(state: &AppState, purpose: Purpose) -> Vec<String> {
    match purpose {
        Purpose::ExportCl { .. } => plunge_concerns(state),
        Purpose::ExportFlank => flank_concerns(state),
        _ => Vec::new(),
    }
}

fn plunge_concerns(state: &AppState) -> Vec<String> {
    let Some(shown) = state.last_whole_plan(state.look.side) else { return Vec::new() };
    let (plan, summary) = (shown.plan(), &shown.planned.result(shown.policy).summary);
    let allowances = &shown.planned.outcome.setup.allowances;
    let mut found = Vec::new();
    if summary.interfering > 0 {
        found.push(format!(
            "The core meets stock in {} of {} plunges, up to {:.2} mm deep",
            summary.interfering, summary.positions, summary.max_contact_depth
        ));
    }
    for (name, kept, wanted) in [
        ("hub", summary.min_hub_clearance, allowances.hub_allowance),
        ("blades", summary.min_blade_clearance, allowances.blade_allowance),
        ("blank at retracts", summary.min_retract_clearance, allowances.safety_distance),
    ] {
        if kept < wanted - ROUNDING {
            found.push(format!("Clearance to {name} is {kept:.3} mm, less than {wanted} mm"));
        }
    }
    let part = &shown.planned.outcome.workpiece.part;
    let machine = &shown.planned.outcome.setup.machine;
    let beyond = plan.positions.iter().filter(|p| machine.excess_tilt_rad(part, &p.axis) > 1e-6).count();
    if beyond > 0 {
        found.push(format!("{beyond} tool axes are beyond the reach of the machine"));
    }
    if state.out_of_date() {
        found.push("The setup was edited after this calculation".to_owned());
    }
    if plan.is_unfinished() {
        found.push("The calculation was cancelled: this is the best plan so far".to_owned());
    }
    for why in DropReason::ALL {
        let count = plan.dropped.iter().filter(|dropped| dropped.why == why).count();
        if count > 0 {
            found.push(format!("{count} positions are skipped {}", why.words()));
        }
    }
    if summary.uncut_share > MAX_GOOD_UNCUT_SHARE {
        found
            .push(format!("{} of the accessible floor is not machined", format_percent(summary.uncut_share)));
    }
    found
}

fn flank_concerns(state: &AppState) -> Vec<String> {
    let Some(outcome) = &state.results.flank else { return Vec::new() };
    let mut found: Vec<String> =
        outcome.faults.iter().take(3).map(|fault| format!("Move {}: {fault}", fault.line)).collect();
    if outcome.faults.len() > found.len() {
        found.push(format!("{} more faults", outcome.faults.len() - found.len()));
    }
    if outcome.verdict.is_none() {
        found.push("The program could not be verified".to_owned());
    }
    if state.flank_is_stale() {
        found.push("The setup was edited after this calculation".to_owned());
    }
    if !outcome.plan.uncut.is_empty() {
        found.push(format!("{} stretches of passes are left out", outcome.plan.uncut.len()));
    }
    found
}

impl App {
    /// Writes the chosen file; a program with something against it is asked about first.
    pub fn file_chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: PathBuf) {
        let concerns = concerns(&self.state, purpose);
        if concerns.is_empty() {
            self.use_file(ctx, purpose, path);
        } else {
            self.release = Some(ReleaseQuestion { purpose, path, concerns });
        }
    }

    /// Draws the question, while it is open.
    pub(super) fn ask_release(&mut self, ui: &Ui) {
        let Some(question) = &self.release else { return };
        let (mut again, mut anyway, mut cancel) = (false, false, false);
        let modal = Modal::new(egui::Id::unique("release")).show(ui.ctx(), |ui| {
            ui.set_width(420.0);
            ui.label(RichText::new("Export this program?").strong());
            ui.add_space(4.0);
            let colour = Condition::Interfering.text(ui.visuals());
            for concern in &question.concerns {
                ui.label(RichText::new(format!("• {concern}")).color(colour));
            }
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                again = ui
                    .button("Recalculate")
                    .on_hover_text("Calculates the current setup; nothing is written")
                    .clicked();
                anyway = ui.button("Export anyway").clicked();
                cancel = ui.button("Cancel").clicked();
            });
        });
        let closed = modal.should_close();
        if !(again || anyway || cancel || closed) {
            return;
        }
        let Some(ReleaseQuestion { purpose, path, .. }) = self.release.take() else { return };
        if again {
            let command = if purpose == Purpose::ExportFlank { Command::PlanFlank } else { Command::Plan };
            self.run_command(ui.ctx(), command);
        } else if anyway {
            self.use_file(ui.ctx(), purpose, path);
        }
    }
}
