//! File dialogs that never block the window: the system dialog runs on its own thread. Where there is none
//! (no portal, no D-Bus), a text field for the path replaces it.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Context, Key, Ui};

use crate::io::project_file::EXTENSION;

/// Purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A part to open.
    OpenPart,
    /// A project to open.
    OpenProject,
    /// Target of a project.
    SaveProject,
    /// A setup to open.
    OpenSetup,
    /// Target of a setup.
    SaveSetup,
    /// Target of the CL file of the shown plunge plan.
    ExportCl {
        /// Whether the program is for all channels, or for the first only.
        all_channels: bool,
    },
    /// Target of the flank plan's CL file.
    ExportFlank,
    /// Target of the glTF scene.
    ExportScene,
    /// Target of the stock as a solid.
    ExportStock,
    /// Target of the picture.
    SavePicture,
}

impl Purpose {
    fn title(self) -> &'static str {
        match self {
            Self::OpenPart => "Open part",
            Self::OpenProject => "Open project",
            Self::SaveProject => "Save project",
            Self::OpenSetup => "Open setup",
            Self::SaveSetup => "Save setup",
            Self::ExportCl { all_channels: false } => "Export CL (APT)",
            Self::ExportCl { all_channels: true } => "Export CL of all channels (APT)",
            Self::ExportFlank => "Export flank CL (APT)",
            Self::ExportScene => "Export scene",
            Self::ExportStock => "Export stock",
            Self::SavePicture => "Save picture",
        }
    }

    fn saves(self) -> bool {
        matches!(
            self,
            Self::SaveProject
                | Self::SaveSetup
                | Self::ExportCl { .. }
                | Self::ExportFlank
                | Self::ExportScene
                | Self::ExportStock
                | Self::SavePicture
        )
    }

    fn filter(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::OpenPart => ("Impellers", &["toml", "geomTurbo", "geomturbo", "inf", "glb", "gltf"]),
            Self::OpenProject | Self::SaveProject => ("Projects", &[EXTENSION]),
            Self::OpenSetup | Self::SaveSetup => ("Setups", &["toml"]),
            Self::ExportCl { .. } | Self::ExportFlank => ("APT cutter location", &["apt", "cl"]),
            Self::ExportScene => ("glTF scenes", &["glb"]),
            Self::ExportStock => ("Solids", &["stl", "glb"]),
            Self::SavePicture => ("Pictures", &["png"]),
        }
    }
}

/// The replacement for a system dialog: a text field for the path.
#[derive(Clone, Debug)]
struct Prompt {
    purpose: Purpose,
    path: String,
    fresh: bool,
}

/// Answer of the dialog thread: purpose, path unless it was closed, and time taken.
type AnswerSlot = Arc<Mutex<Option<(Purpose, Option<PathBuf>, Duration)>>>;

/// The file dialogs; at most one is open.
#[derive(Default)]
pub struct Dialogs {
    slot: AnswerSlot,
    open: bool,
    prompt: Option<Prompt>,
    suggestion: String,
}

/// A system dialog that returns without a path in less than this never opened.
const MIN_DIALOG_TIME: Duration = Duration::from_millis(150);

impl Dialogs {
    /// Opens a file dialog; `suggestion` is the proposed name when saving.
    pub fn open_dialog(&mut self, ctx: &Context, purpose: Purpose, suggestion: String) {
        if self.open || self.prompt.is_some() {
            return;
        }
        self.suggestion.clone_from(&suggestion);
        let (slot, ctx) = (Arc::clone(&self.slot), ctx.clone());
        let ask = move || {
            let start = Instant::now();
            let (name, extensions) = purpose.filter();
            let dialog = rfd::FileDialog::new().set_title(purpose.title()).add_filter(name, extensions);
            let chosen = if purpose.saves() {
                dialog.set_file_name(suggestion).save_file()
            } else {
                dialog.pick_file()
            };
            let answer = Some((purpose, chosen, start.elapsed()));
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = answer;
            ctx.request_repaint();
        };
        match std::thread::Builder::new().name("file dialog".to_owned()).spawn(ask) {
            Ok(_) => self.open = true,
            Err(_) => self.start_prompt(purpose),
        }
    }

    fn start_prompt(&mut self, purpose: Purpose) {
        let path = if purpose.saves() { self.suggestion.clone() } else { String::new() };
        self.prompt = Some(Prompt { purpose, path, fresh: true });
    }

    /// Draws the path prompt if it is open; returns the chosen file once.
    pub fn show(&mut self, ui: &Ui) -> Option<(Purpose, PathBuf)> {
        let answer = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some((purpose, chosen, took)) = answer {
            self.open = false;
            match chosen {
                Some(path) => return Some((purpose, path)),
                None if took < MIN_DIALOG_TIME => self.start_prompt(purpose),
                None => {}
            }
        }
        let prompt = self.prompt.as_mut()?;
        let (chosen, close) = prompt.show(ui);
        let purpose = prompt.purpose;
        if close {
            self.prompt = None;
        }
        chosen.map(|path| (purpose, path))
    }
}

impl Prompt {
    fn show(&mut self, ui: &Ui) -> (Option<PathBuf>, bool) {
        let (mut chosen, mut close) = (None, false);
        egui::Window::new(self.purpose.title())
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ui.ctx(), |ui| {
                let label = ui.label("No system file dialog found; enter a path");
                let field = egui::TextEdit::singleline(&mut self.path).desired_width(380.0);
                let field = ui.add(field).labelled_by(label.id);
                if std::mem::take(&mut self.fresh) {
                    field.request_focus();
                }
                let enter = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
                let escape = ui.input(|i| i.key_pressed(Key::Escape));
                ui.horizontal(|ui| {
                    let ready = !self.path.trim().is_empty();
                    let verb = if self.purpose.saves() { "Save" } else { "Open" };
                    let go = ui.add_enabled(ready, egui::Button::new(verb)).clicked();
                    if ready && (go || enter) {
                        chosen = Some(PathBuf::from(self.path.trim()));
                    }
                    close = ui.button("Cancel").clicked() || escape || chosen.is_some();
                });
            });
        (chosen, close)
    }
}
