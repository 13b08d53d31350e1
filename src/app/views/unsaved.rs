//! The question before unsaved changes are discarded.

use egui::{Modal, RichText, Ui};

use super::modal::is_dismissed;

/// What would be lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnsavedWork {
    /// The open project.
    Project,
    /// The tool library of the shop.
    Library,
}

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

/// Draws the question about `work`; returns the answer once.
pub fn ask(ui: &Ui, work: UnsavedWork) -> Option<UnsavedAnswer> {
    let title = match work {
        UnsavedWork::Project => "Save the changes of this project?",
        UnsavedWork::Library => "Save the changes of the shop library?",
    };
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique("unsaved")).show(ui.ctx(), |ui| {
        ui.set_width(320.0);
        ui.label(RichText::new(title).strong());
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
    answer.or(is_dismissed(&modal).then_some(UnsavedAnswer::Cancel))
}
