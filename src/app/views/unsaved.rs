//! The question before unsaved changes are discarded.

use egui::Ui;

use super::modal::{Question, choice};

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

/// Draws the question about `work`, with the name of the project; returns the answer once.
pub fn ask(ui: &Ui, work: UnsavedWork, project: &str) -> Option<UnsavedAnswer> {
    let title = match work {
        UnsavedWork::Project => format!("Save the changes of {project}?"),
        UnsavedWork::Library => "Save the changes of the shop library?".to_owned(),
    };
    let (title, text) = (title.as_str(), "Unsaved changes will be lost.");
    let question = Question { id: "unsaved", width: 320.0, title, text };
    let answers = [
        choice("Save", UnsavedAnswer::Save),
        choice("Don't save", UnsavedAnswer::Discard),
        choice("Cancel", UnsavedAnswer::Cancel),
    ];
    question.ask(ui, answers, UnsavedAnswer::Cancel)
}
