//! The question what to do with unsaved changes of an opened project that a session left behind.

use egui::Ui;

use super::modal::{Question, choice};
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
    let question = Question {
        id: "recover",
        width: 360.0,
        title: &format!("Unsaved changes of {}", copy.title),
        text: "A session with this project or part ended without closing.",
    };
    let answers = [
        ("Recover", "Continues with the unsaved changes", RecoverAnswer::Recover),
        ("Discard", "Removes them, and continues with what is open", RecoverAnswer::Discard),
        ("Not now", "Continues with what is open; asks again", RecoverAnswer::Later),
    ];
    question.ask(ui, answers, RecoverAnswer::Later)
}

/// Asks whether to remove `copy`; returns the answer once.
pub fn ask_discard(ui: &Ui, copy: &RecoveryCopy) -> Option<bool> {
    let question = Question {
        id: "discard recovery copy",
        width: 360.0,
        title: &format!("Discard the unsaved changes of {}?", copy.title),
        text: "They are nowhere else.",
    };
    question.ask(ui, [choice("Discard", true), choice("Cancel", false)], false)
}
