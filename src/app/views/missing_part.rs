//! The question where the part of a project is, whose file was moved or renamed.

use std::path::Path;

use egui::Ui;

use super::modal::{Question, choice};

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
    let name = project.file_name().unwrap_or_default().to_string_lossy();
    let question = Question {
        id: "missing part",
        width: 420.0,
        title: &format!("The part of {name} is not found"),
        text: &format!("It was {part}. If it was moved or renamed, show where it is now."),
    };
    let answers = [choice("Locate…", MissingPartAnswer::Locate), choice("Cancel", MissingPartAnswer::Cancel)];
    question.ask(ui, answers, MissingPartAnswer::Cancel)
}
