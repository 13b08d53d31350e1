//! What is edited: the part that is open, its setup, the sets kept to compare; with undo, and with the file
//! all of it belongs to.

use std::path::PathBuf;
use std::sync::Arc;

use egui::util::undoer::Undoer;

use crate::part::{Impeller, Setup};

use super::engine::PartSource;

/// The part that is open.
#[derive(Clone, Debug)]
pub struct OpenPart {
    /// Where it came from.
    pub source: PartSource,
    /// The part.
    pub impeller: Arc<Impeller>,
    /// What an empty setup means for it.
    pub defaults: Setup,
    /// Hash of what it describes; see [`crate::formats::project_file`].
    pub hash: u64,
}

/// A setup that was kept, to be compared with others.
#[derive(Clone, Debug, PartialEq)]
pub struct WhatIf {
    /// Name, to be edited.
    pub name: String,
    /// The setup.
    pub setup: Setup,
}

/// Everything that undo takes back and the project file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edited {
    /// The setup in work.
    pub setup: Setup,
    /// Sets that were kept.
    pub sets: Vec<WhatIf>,
}

/// Part, setup and sets, with their file.
#[derive(Default)]
pub struct Document {
    /// The part.
    pub part: Option<OpenPart>,
    /// What the user edits.
    pub edited: Edited,
    /// File of the project, once it has one.
    pub path: Option<PathBuf>,
    /// What the disk, or the start, has of it; `None`: nothing.
    saved: Option<Edited>,
    undoer: Undoer<Edited>,
}

impl Document {
    /// Begins anew with a part; `edited` is what belongs to it, from a project or by default.
    pub fn begin(&mut self, part: OpenPart, edited: Edited, path: Option<PathBuf>) {
        self.part = Some(part);
        self.saved = Some(edited.clone());
        self.edited = edited;
        self.path = path;
        self.undoer = Undoer::default();
    }

    /// Whether something would be lost with the window.
    pub fn is_unsaved(&self) -> bool {
        self.part.is_some() && self.saved.as_ref() != Some(&self.edited)
    }

    /// `edited` as it was written is now on the disk.
    pub fn note_saved(&mut self, path: PathBuf, edited: Edited) {
        self.path = Some(path);
        self.saved = Some(edited);
    }

    /// Counts what is there as never saved: it came from a recovered file.
    pub fn mark_unsaved(&mut self) {
        self.saved = None;
    }

    /// To be called once a frame: changes that have come to rest become steps to undo. `time` in seconds.
    pub fn watch(&mut self, time: f64) {
        self.undoer.feed_state(time, &self.edited);
    }

    /// Makes what is there a step to undo.
    pub fn step(&mut self) {
        self.undoer.add_undo(&self.edited);
    }

    /// Whether there is something to take back.
    pub fn can_undo(&self) -> bool {
        self.undoer.has_undo(&self.edited)
    }

    /// Whether there is something to make again.
    pub fn can_redo(&self) -> bool {
        self.undoer.has_redo(&self.edited)
    }

    /// Takes the last change back.
    pub fn undo(&mut self) {
        if let Some(edited) = self.undoer.undo(&self.edited) {
            self.edited = edited.clone();
        }
    }

    /// Makes it again.
    pub fn redo(&mut self) {
        if let Some(edited) = self.undoer.redo(&self.edited) {
            self.edited = edited.clone();
        }
    }

    /// Keeps the setup as it stands under a fresh name.
    pub fn keep_set(&mut self) {
        let taken = |name: &str| self.edited.sets.iter().any(|set| set.name == name);
        let name = (1..).map(|k| format!("Set {k}")).find(|name| !taken(name)).unwrap_or_default();
        self.edited.sets.push(WhatIf { name, setup: self.edited.setup.clone() });
    }
}
