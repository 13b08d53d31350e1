//! File dialogs that never block the window: the system dialog runs on its own thread. Where it does not open
//! (no portal, no D-Bus, no zenity), the window asks itself.

mod folders;
mod prompt;
mod system;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Context, Ui};

use crate::app::model::file_purpose::{FilePlace, Purpose};
use crate::app::views::repaint;

use folders::Folders;
use prompt::{Prompt, PromptAnswer};
use system::SystemAnswer;

/// Answer of the dialog thread, with the number of its request.
type AnswerSlot = Arc<Mutex<Option<(u64, Purpose, SystemAnswer)>>>;

/// The file dialogs; at most one is open.
pub struct Dialogs {
    slot: AnswerSlot,
    /// Number of the last request to a dialog thread.
    requests: u64,
    /// Whether the system dialog of the last request is open, and when it was asked for.
    open: bool,
    asked: Option<Instant>,
    /// Whether the window asks itself, without trying the system dialog.
    own_only: bool,
    prompt: Option<Prompt>,
    suggestion: String,
    folders: Folders,
    listing: prompt::FolderReader,
}

impl Dialogs {
    /// Dialogs of the window of `ctx`.
    pub fn new(ctx: &Context) -> Self {
        Self {
            slot: AnswerSlot::default(),
            requests: 0,
            open: false,
            asked: None,
            own_only: false,
            prompt: None,
            suggestion: String::new(),
            folders: Folders::default(),
            listing: prompt::FolderReader::new(&repaint(ctx)),
        }
    }

    /// Whether the window asks itself, without trying the system dialog.
    pub fn use_own_dialogs(&mut self) {
        self.own_only = true;
    }

    /// Whether the window's own dialog is open, or may open in a moment; shortcuts are disabled then: what is
    /// typed is meant as a name.
    pub fn is_asking(&self) -> bool {
        self.prompt.is_some() || (self.open && self.asked.is_some_and(|asked| asked.elapsed() < OPENING))
    }

    /// Whether an answer or a folder is awaited that comes without input.
    pub fn is_busy(&self) -> bool {
        self.listing.is_busy()
    }

    /// Opens a file dialog; `suggestion` is the proposed name when saving. A request while a system dialog is
    /// open means that the user does not see that one: the window asks itself then.
    pub fn open_dialog(&mut self, ctx: &Context, purpose: Purpose, suggestion: String) {
        if self.prompt.is_some() {
            return;
        }
        self.suggestion.clone_from(&suggestion);
        if self.own_only || self.open {
            self.open = false;
            self.requests += 1;
            self.start_prompt(purpose, "");
            return;
        }
        self.requests += 1;
        let number = self.requests;
        let folder = self.folders.start(purpose).map(Path::to_owned);
        let (slot, ctx) = (Arc::clone(&self.slot), ctx.clone());
        let ask = move || {
            let answer = system::ask(|| system::show_dialog(purpose, &suggestion, folder.as_deref()));
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some((number, purpose, answer));
            ctx.request_repaint();
        };
        match std::thread::Builder::new().name("file dialog".to_owned()).spawn(ask) {
            Ok(_) => (self.open, self.asked) = (true, Some(Instant::now())),
            Err(_) => self.start_prompt(purpose, NO_DIALOG),
        }
    }

    fn start_prompt(&mut self, purpose: Purpose, reason: &'static str) {
        let name = if purpose.saves() { self.suggestion.clone() } else { String::new() };
        self.prompt = Some(Prompt::new(purpose, name, self.folders.start(purpose), reason));
    }

    /// Draws the window's own dialog if it is open; returns the chosen file once.
    pub fn show(&mut self, ui: &Ui) -> Option<(Purpose, PathBuf)> {
        let answer = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some((number, purpose, answer)) = answer
            && number == self.requests
        {
            self.open = false;
            match answer {
                SystemAnswer::Chosen(path) => {
                    self.folders.note(purpose.place(), &path);
                    return Some((purpose, path));
                }
                SystemAnswer::Closed => {}
                SystemAnswer::NotOpened => self.start_prompt(purpose, NO_DIALOG),
            }
        }
        let Some(prompt) = &mut self.prompt else {
            self.listing.read(None);
            return None;
        };
        let purpose = prompt.purpose();
        match prompt.show(ui, &mut self.listing)? {
            PromptAnswer::Cancelled => {
                self.prompt = None;
                None
            }
            PromptAnswer::Chosen(path) => {
                self.prompt = None;
                self.folders.note(purpose.place(), &path);
                Some((purpose, path))
            }
        }
    }

    /// Starts the next dialog for files of this place in the folder of a file that was opened or written.
    pub fn note_folder(&mut self, place: FilePlace, file: &Path) {
        self.folders.note(place, file);
    }
}

/// How long a dialog of the system that does not open may take to say so.
const OPENING: Duration = Duration::from_secs(1);

/// Why the window asks itself.
const NO_DIALOG: &str = "The system's file dialog did not open";
