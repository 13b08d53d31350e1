//! The question before unsaved changes are discarded.

use egui::{Modal, RichText, Ui};

/// Answer to the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnsavedAnswer {
    /// Save, then go on.
    Save,
    /// Go on without saving.
    Discard,
    /// Stay.
    Cancel,
}

/// Draws the question; returns the answer once.
pub fn ask(ui: &Ui) -> Option<UnsavedAnswer> {
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique("unsaved")).show(ui.ctx(), |ui| {
        ui.set_width(320.0);
        ui.label(RichText::new("Save the changes of this project?").strong());
        ui.label("Unsaved changes will be lost.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (name, meaning) in [
                ("Save", UnsavedAnswer::Save),
                ("Don't save", UnsavedAnswer::Discard),
                ("Cancel", UnsavedAnswer::Cancel),
            ] {
                if ui.button(name).clicked() {
                    answer = Some(meaning);
                }
            }
        });
    });
    answer.or(modal.should_close().then_some(UnsavedAnswer::Cancel))
}
