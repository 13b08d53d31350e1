//! The question before a project's file is replaced that another window or program has written.

use std::path::Path;

use egui::Ui;

use super::modal::{Question, choice};

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
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let question = Question {
        id: "changed on disk",
        width: 380.0,
        title: &format!("{name} was changed on disk"),
        text: "Another window or program has written it since this window read or saved it. Overwriting loses what was \
               saved there.",
    };
    let answers = [
        choice("Overwrite", ChangedAnswer::Overwrite),
        choice("Save as…", ChangedAnswer::SaveAs),
        choice("Cancel", ChangedAnswer::Cancel),
    ];
    question.ask(ui, answers, ChangedAnswer::Cancel)
}
