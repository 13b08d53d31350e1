//! Problem messages with location and remedy, shown until they are dismissed or solved.

use egui::{Frame, RichText, Ui};

use super::super::command::Command;
use super::super::state::AppState;
use super::super::theme::{self, Condition};

/// Draws the problems; returns the command that was pressed.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<Command> {
    let mut chosen = None;
    let mut dismissed = None;
    for (k, problem) in state.problems.iter().enumerate().rev() {
        ui.horizontal(|ui| {
            let mark = Condition::Interfering;
            let (rect, _) = ui.allocate_exact_size(egui::vec2(4.0, 18.0), egui::Sense::hover());
            ui.painter().rect_filled(rect, 0.0, mark.mark());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let dismiss = ui
                    .small_button("Dismiss")
                    .on_hover_text(Command::DismissProblems.tip_with_keys(ui.ctx()));
                if dismiss.clicked() {
                    dismissed = Some(k);
                }
                if state.document.can_undo() && ui.small_button("Undo the edit").clicked() {
                    chosen = Some(Command::Undo);
                }
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(
                        egui::Label::new(RichText::new(&problem.message).color(mark.text(ui.visuals())))
                            .truncate(),
                    )
                    .on_hover_text(&problem.message);
                    if !problem.help.is_empty() {
                        ui.add(
                            egui::Label::new(RichText::new(format!("Fix: {}", problem.help)).strong())
                                .truncate(),
                        );
                    }
                });
            });
        });
    }
    if let Some(k) = dismissed {
        state.problems.remove(k);
    }
    chosen
}

/// Frame of the panel.
pub fn frame(ui: &Ui) -> Frame {
    Frame::new().fill(theme::overlay(ui.visuals())).inner_margin(egui::Margin::symmetric(8, 3))
}
