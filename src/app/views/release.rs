//! The question before a program with something against it is written.

use egui::{Modal, RichText, Ui};

use super::modal::is_dismissed;
use super::theme::Condition;

/// Answer to the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseAnswer {
    /// Calculate the current setup; write nothing.
    Recalculate,
    /// Write the program.
    Export,
    /// Write nothing.
    Cancel,
}

/// Draws the question with what speaks against the program; returns the answer once. `can_change`: whether
/// calculating the plan again can change it.
pub fn ask(ui: &Ui, concerns: &[String], can_change: bool) -> Option<ReleaseAnswer> {
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique("release")).show(ui.ctx(), |ui| {
        ui.set_width(420.0);
        ui.label(RichText::new("Export this program?").strong());
        ui.add_space(4.0);
        let colour = Condition::Interfering.text(ui.visuals());
        for concern in concerns {
            ui.label(RichText::new(format!("• {concern}")).color(colour));
        }
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let tip = "Calculates the current setup; nothing is written";
            if can_change && ui.button("Recalculate").on_hover_text(tip).clicked() {
                answer = Some(ReleaseAnswer::Recalculate);
            }
            if ui.button("Export anyway").clicked() {
                answer = Some(ReleaseAnswer::Export);
            }
            if ui.button("Cancel").clicked() {
                answer = Some(ReleaseAnswer::Cancel);
            }
        });
    });
    answer.or(is_dismissed(&modal).then_some(ReleaseAnswer::Cancel))
}
