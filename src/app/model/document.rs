//! The document: the open part, its setup and the stored variants, with undo and the project file.

use std::path::PathBuf;
use std::sync::Arc;

use crate::io::part_hash::PartHash;
use crate::part::Impeller;
use crate::setup::Setup;

use crate::app::model::field_faults::ReplacedValue;
use crate::app::model::history::History;
use crate::app::model::part_source::PartSource;

/// An open part.
#[derive(Clone, Debug)]
pub struct OpenPart {
    /// Source of the part.
    pub source: PartSource,
    /// The part.
    pub impeller: Arc<Impeller>,
    /// Default setup of the part.
    pub defaults: Setup,
    /// Hashes of its description.
    pub hash: PartHash,
}

/// A stored variant of the setup.
#[derive(Clone, Debug, PartialEq)]
pub struct WhatIf {
    /// Name, editable.
    pub name: String,
    /// The setup.
    pub setup: Setup,
    /// As [`Edited::replaced`], in its setup.
    pub replaced: Vec<ReplacedValue>,
}

/// Everything that undo covers and the project file stores.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edited {
    /// The current setup.
    pub setup: Setup,
    /// Stored variants.
    pub sets: Vec<WhatIf>,
    /// Faulty values of the setup in the file, in whose place defaults stand until the field is edited. A
    /// saved project keeps them.
    pub replaced: Vec<ReplacedValue>,
}

/// Part, setup and variants, with the project file.
#[derive(Default)]
pub struct Document {
    /// The part.
    pub part: Option<OpenPart>,
    /// The edited content.
    pub edited: Edited,
    /// File of the project, absolute: recovery copies carry it to sessions that begin in another folder.
    /// `None` before it is saved.
    pub path: Option<PathBuf>,
    /// Hash of that file as this window read or wrote it last; `None` where it has not.
    pub on_disk: Option<u64>,
    /// Content as last saved or opened; `None`: never saved.
    saved: Option<Edited>,
    history: History<Edited>,
}

impl Document {
    /// Starts a document with a part; `edited` comes from a project or from the defaults.
    pub fn begin(&mut self, part: OpenPart, edited: Edited, path: Option<PathBuf>) {
        self.part = Some(part);
        self.saved = Some(edited.clone());
        self.edited = edited;
        self.path = path.map(absolute);
        self.on_disk = None;
        self.history = History::default();
    }

    /// What is edited, with other `defaults` of the part in place of its own.
    pub fn edited_with_defaults(&self, defaults: &Setup) -> Edited {
        let mut edited = self.edited.clone();
        if let Some(part) = &self.part {
            let variants = edited.sets.iter_mut().map(|variant| &mut variant.setup);
            for setup in std::iter::once(&mut edited.setup).chain(variants) {
                setup.follow_defaults(&part.defaults, defaults);
            }
        }
        edited
    }

    /// Name of its file; before it is saved, that of its part.
    pub fn name(&self) -> String {
        let file = self.path.as_ref().and_then(|path| path.file_name());
        let part = || self.part.as_ref().map_or_else(String::new, |part| part.impeller.name.clone());
        file.map_or_else(part, |file| file.to_string_lossy().into_owned())
    }

    /// Whether there are unsaved changes.
    pub fn is_unsaved(&self) -> bool {
        self.part.is_some() && self.saved.as_ref() != Some(&self.edited)
    }

    /// Records that `edited` was written to `path`, whose content then has this `hash`.
    pub fn note_saved(&mut self, path: PathBuf, edited: Edited, hash: u64) {
        self.path = Some(absolute(path));
        self.on_disk = Some(hash);
        self.saved = Some(edited);
    }

    /// Marks the content as never saved, e.g. after recovery.
    pub fn mark_unsaved(&mut self) {
        self.saved = None;
    }

    /// Call once per frame: changes that have been stable for a while become undo steps. `time` in seconds.
    pub fn watch(&mut self, time: f64) {
        self.history.watch(time, &self.edited);
    }

    /// Adds the current content as an undo step.
    pub fn step(&mut self) {
        self.history.add(&self.edited);
    }

    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        self.history.can_undo(&self.edited)
    }

    /// Whether there is something to redo.
    pub fn can_redo(&self) -> bool {
        self.history.can_redo(&self.edited)
    }

    /// When the change came about that undo takes back, on the window's clock, s.
    pub fn changed_s(&self) -> Option<f64> {
        self.history.changed_s(&self.edited)
    }

    /// Likewise for the one that redo makes again.
    pub fn undone_s(&self) -> Option<f64> {
        self.history.undone_s(&self.edited)
    }

    /// Undoes the last change.
    pub fn undo(&mut self) {
        if let Some(edited) = self.history.undo(&self.edited) {
            self.edited = edited;
        }
    }

    /// Redoes the last undone change.
    pub fn redo(&mut self) {
        if let Some(edited) = self.history.redo(&self.edited) {
            self.edited = edited;
        }
    }

    /// Stores the current setup as a variant with an unused name, as an undo step of its own. Returns the
    /// name.
    pub fn keep_set(&mut self) -> String {
        self.step();
        let taken = |name: &str| self.edited.sets.iter().any(|set| set.name == name);
        let name = (1..).map(|k| format!("Variant {k}")).find(|name| !taken(name)).unwrap_or_default();
        let Edited { setup, replaced, .. } = self.edited.clone();
        self.edited.sets.push(WhatIf { name: name.clone(), setup, replaced });
        self.step();
        name
    }
}

/// The path from the root; as it is where the current folder is unknown.
fn absolute(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}
