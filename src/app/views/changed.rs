//! The question before a project's file is replaced that another window or program has written.

use std::path::Path;

use egui::{Modal, RichText, Ui};

use super::modal::is_dismissed;

/// Answer to the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangedAnswer {
    /// Replace what is there.
    Overwrite,
    /// Save under another name.
    SaveAs,
    /// Write nothing.
    Cancel,
}

/// Draws the question about the file at `path`; returns the answer once.
pub fn ask(ui: &Ui, path: &Path) -> Option<ChangedAnswer> {
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique("changed on disk")).show(ui.ctx(), |ui| {
        ui.set_width(380.0);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        ui.label(RichText::new(format!("{name} was changed on disk")).strong());
        ui.label(
            "Another window or program has written it since this window read or saved it. Overwriting loses what \
             was saved there.",
        );
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (name, meaning) in [
                ("Overwrite", ChangedAnswer::Overwrite),
                ("Save as…", ChangedAnswer::SaveAs),
                ("Cancel", ChangedAnswer::Cancel),
            ] {
                if ui.button(name).clicked() {
                    answer = Some(meaning);
                }
            }
        });
    });
    answer.or(is_dismissed(&modal).then_some(ChangedAnswer::Cancel))
}
