//! File dialogs that never block the window: the system dialog runs on its own thread. Where it does not open
//! (no portal, no D-Bus, no zenity), the window asks itself.

mod folders;
mod prompt;
mod system;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Context, Event, ImeEvent, Key, Ui};

use crate::app::model::file_purpose::{FilePlace, Purpose};
use crate::app::views::repaint;
use crate::io::InputError;

use folders::Folders;
use prompt::{Prompt, PromptAnswer};
pub use system::SystemAnswer;

/// Shows a file dialog, for a purpose, with a proposed name and the folder to start in, and waits for its
/// answer.
pub type FileDialog = Arc<dyn Fn(Purpose, &str, Option<&Path>) -> SystemAnswer + Send + Sync>;

/// Why a file must not be replaced, if it must not.
pub type ReplacedCheck<'a> = dyn Fn(Purpose, &Path) -> Result<(), InputError> + 'a;

/// Answer of the dialog thread, with the number of its request.
type AnswerSlot = Arc<Mutex<Option<(u64, Purpose, SystemAnswer)>>>;

/// The file dialogs; at most one is open.
pub struct Dialogs {
    slot: AnswerSlot,
    /// Number of the last request to a dialog thread.
    requests: u64,
    /// When the system dialog was asked for that is awaited.
    awaited: Option<Instant>,
    system: FileDialog,
    /// Whether the window asks itself, without trying the system dialog.
    own_only: bool,
    prompt: Option<Prompt>,
    /// What was typed since the request, before a dialog was there.
    typed: String,
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
            awaited: None,
            system: Arc::new(system::show_dialog),
            own_only: false,
            prompt: None,
            typed: String::new(),
            suggestion: String::new(),
            folders: Folders::default(),
            listing: prompt::FolderReader::new(&repaint(ctx)),
        }
    }

    /// Whether the window asks itself, without trying the system dialog.
    pub fn use_own_dialogs(&mut self) {
        self.own_only = true;
    }

    /// Asks `dialog` instead of that of the system.
    pub fn use_dialog(&mut self, dialog: FileDialog) {
        self.system = dialog;
    }

    /// Whether a file is asked for; shortcuts are disabled until that is answered: what is typed is meant as
    /// a name.
    pub fn is_asking(&self) -> bool {
        self.prompt.is_some() || self.awaited.is_some()
    }

    /// Whether the dialog of the system is awaited for longer than one takes that does not open.
    pub fn is_waiting(&self) -> bool {
        self.awaited.is_some_and(|asked| asked.elapsed() >= OPENING)
    }

    /// Keeps the keys of this frame from the window while no dialog that was asked for has taken them: what
    /// is typed begins the name in the window's own dialog, once that opens. Escape gives the keys back to
    /// the window, for a dialog of the system that never opens. To be called before any key is handled.
    pub fn take_typed(&mut self, ctx: &Context) {
        let is_awaited = self.awaited.is_some();
        if !is_awaited && self.prompt.as_ref().is_none_or(Prompt::is_drawn) {
            return;
        }
        let mut goes_on = false;
        let typed = &mut self.typed;
        ctx.input_mut(|input| {
            input.events.retain(|event| match event {
                Event::Text(text) | Event::Paste(text) | Event::Ime(ImeEvent::Commit(text)) => {
                    typed.extend(text.chars().filter(|c| !c.is_control()));
                    false
                }
                Event::Key { key: Key::Escape, pressed: true, .. } => {
                    goes_on = true;
                    // The window's own dialog is closed by it.
                    !is_awaited
                }
                Event::Key { key, pressed: true, .. } => {
                    if *key == Key::Backspace {
                        typed.pop();
                    }
                    false
                }
                _ => true,
            });
        });
        if goes_on && is_awaited {
            self.awaited = None;
            self.typed.clear();
        }
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
        self.typed.clear();
        if self.own_only || self.awaited.take().is_some() {
            self.requests += 1;
            self.start_prompt(purpose, "");
            return;
        }
        self.requests += 1;
        let number = self.requests;
        let folder = self.folders.start(purpose).map(Path::to_owned);
        // Then the status bar says what is awaited.
        ctx.request_repaint_after(OPENING);
        let (slot, ctx, show_dialog) = (Arc::clone(&self.slot), ctx.clone(), Arc::clone(&self.system));
        let ask = move || {
            let answer = show_dialog(purpose, &suggestion, folder.as_deref());
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some((number, purpose, answer));
            ctx.request_repaint();
        };
        match std::thread::Builder::new().name("file dialog".to_owned()).spawn(ask) {
            Ok(_) => self.awaited = Some(Instant::now()),
            Err(_) => self.start_prompt(purpose, NO_DIALOG),
        }
    }

    fn start_prompt(&mut self, purpose: Purpose, reason: &'static str) {
        let name = if purpose.saves() { self.suggestion.clone() } else { String::new() };
        self.prompt = Some(Prompt::new(purpose, name, self.folders.start(purpose), reason));
    }

    /// Draws the window's own dialog if it is open; returns the chosen file once. `check` refuses files that
    /// are not to be replaced: the window's own dialog says so before it asks whether to replace them.
    pub fn show(&mut self, ui: &Ui, check: &ReplacedCheck<'_>) -> Option<(Purpose, PathBuf)> {
        let answer = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some((number, purpose, answer)) = answer
            && number == self.requests
        {
            // Not awaited: Escape gave it up. A file that is chosen all the same is taken.
            let is_awaited = self.awaited.take().is_some();
            match answer {
                SystemAnswer::Chosen(path) => return Some(self.chosen(purpose, path)),
                SystemAnswer::Closed => {}
                SystemAnswer::NotOpened if is_awaited => self.start_prompt(purpose, NO_DIALOG),
                SystemAnswer::NotOpened => {}
            }
        }
        let Some(prompt) = &mut self.prompt else {
            self.listing.read(None);
            return None;
        };
        let purpose = prompt.purpose();
        if !self.typed.is_empty() {
            prompt.begin_with(&std::mem::take(&mut self.typed));
        }
        match prompt.show(ui, &mut self.listing, check)? {
            PromptAnswer::Cancelled => {
                self.prompt = None;
                None
            }
            PromptAnswer::Chosen(path) => {
                self.prompt = None;
                Some(self.chosen(purpose, path))
            }
        }
    }

    /// A file that is to be opened begins the next dialogs in its folder. One that is to be written does so
    /// once it is there: its folder may not exist.
    fn chosen(&mut self, purpose: Purpose, path: PathBuf) -> (Purpose, PathBuf) {
        if !purpose.saves() {
            self.folders.note(purpose.place(), &path);
        }
        (purpose, path)
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
