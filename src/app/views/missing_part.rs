//! The question where the part of a project is, whose file was moved or renamed.

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

/// Draws the question about the `part` of the project of this `name`; returns the answer once.
pub fn ask(ui: &Ui, name: &str, part: &str) -> Option<MissingPartAnswer> {
    let question = Question {
        id: "missing part",
        width: 420.0,
        title: &format!("The part of {name} is not found"),
        text: &format!("It was {part}. If it was moved or renamed, show where it is now."),
    };
    let answers = [choice("Locate…", MissingPartAnswer::Locate), choice("Cancel", MissingPartAnswer::Cancel)];
    question.ask(ui, answers, MissingPartAnswer::Cancel)
}
