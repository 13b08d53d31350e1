//! The question what to do with unsaved changes of an opened project that a session left behind.

use egui::{Modal, RichText, Ui};

use super::modal::is_dismissed;
use crate::app::model::state::RecoveryCopy;

/// Answer to the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecoverAnswer {
    /// Continue with the unsaved changes.
    Recover,
    /// Remove them.
    Discard,
    /// Keep both for now.
    Later,
}

/// Draws the question about `copy`; returns the answer once.
pub fn ask(ui: &Ui, copy: &RecoveryCopy) -> Option<RecoverAnswer> {
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique("recover")).show(ui.ctx(), |ui| {
        ui.set_width(360.0);
        ui.label(RichText::new(format!("Unsaved changes of {}", copy.title)).strong());
        ui.label("A session with this project ended without closing.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (name, tip, meaning) in [
                ("Recover", "Continues with the unsaved changes", RecoverAnswer::Recover),
                ("Discard", "Continues with the project as it was saved", RecoverAnswer::Discard),
                ("Not now", "Continues with the project as it was saved; asks again", RecoverAnswer::Later),
            ] {
                if ui.button(name).on_hover_text(tip).clicked() {
                    answer = Some(meaning);
                }
            }
        });
    });
    answer.or(is_dismissed(&modal).then_some(RecoverAnswer::Later))
}
