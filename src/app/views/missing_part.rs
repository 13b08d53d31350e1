//! The question where the part of a project is, whose file was moved or renamed.

use std::path::Path;

use egui::{Modal, RichText, Ui};

use super::modal::is_dismissed;

/// Answer to the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingPartAnswer {
    /// Ask for its file.
    Locate,
    /// Do not open the project.
    Cancel,
}

/// Draws the question about the `part` of `project`; returns the answer once.
pub fn ask(ui: &Ui, project: &Path, part: &str) -> Option<MissingPartAnswer> {
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique("missing part")).show(ui.ctx(), |ui| {
        ui.set_width(420.0);
        let name = project.file_name().unwrap_or_default().to_string_lossy();
        ui.label(RichText::new(format!("The part of {name} is not found")).strong());
        ui.label(format!("It was {part}. If it was moved or renamed, show where it is now."));
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (name, meaning) in
                [("Locate…", MissingPartAnswer::Locate), ("Cancel", MissingPartAnswer::Cancel)]
            {
                if ui.button(name).clicked() {
                    answer = Some(meaning);
                }
            }
        });
    });
    answer.or(is_dismissed(&modal).then_some(MissingPartAnswer::Cancel))
}
