//! Actions that would lose unsaved work, of the project or the tool library: they wait until it is saved or
//! discarded.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{Context, Ui};

use crate::app::App;
use crate::app::model::file_purpose::{FilePlace, Purpose};
use crate::app::model::panels::DockPanel;
use crate::app::model::part_source::PartSource;
use crate::app::model::shop_library::ShopLibrary;
use crate::app::tasks::files::WrittenLibrary;
use crate::app::tasks::open_task::OpenTask;
use crate::app::views::typed;
use crate::app::views::unsaved::{self, UnsavedAnswer, UnsavedWork};
use crate::study::StudyResults;

/// Action that waits until unsaved changes are saved or discarded.
#[derive(Clone, Debug)]
pub(in crate::app) enum Pending {
    /// Start a new project.
    New,
    /// Open a file.
    Open(PathBuf),
    /// Open a part, with a setup or its own defaults.
    OpenPart(PartSource, Option<PathBuf>),
    /// Open the run of a row of a study's results.
    OpenRun(Arc<StudyResults>, usize),
    /// Open another tool library.
    OpenLibrary(PathBuf),
    /// Close the window.
    Quit,
}

impl Pending {
    /// Whether it closes the open project.
    fn closes_project(&self) -> bool {
        !matches!(self, Self::OpenLibrary(_))
    }

    /// Whether it closes the tool library, which is none of a project.
    fn closes_library(&self) -> bool {
        matches!(self, Self::OpenLibrary(_) | Self::Quit)
    }
}

impl App {
    /// Runs an action that closes the open project or the tool library; asks first if there are unsaved
    /// changes.
    pub(in crate::app) fn run_guarded(&mut self, ctx: &Context, pending: Pending) {
        if pending.closes_project() && self.state.document.is_unsaved() {
            self.session.pending = Some((UnsavedWork::Project, pending));
        } else {
            self.run_past_project(ctx, pending);
        }
    }

    /// Goes on with an action once nothing of the project is lost.
    pub(super) fn run_past_project(&mut self, ctx: &Context, pending: Pending) {
        if pending.closes_library() && self.library.is_unsaved() {
            self.session.pending = Some((UnsavedWork::Library, pending));
        } else {
            self.run_pending(ctx, pending);
        }
    }

    fn run_pending(&mut self, ctx: &Context, pending: Pending) {
        match pending {
            Pending::New => {
                self.state.close();
                self.work.planner_cancel();
                self.hover = None;
            }
            Pending::Open(path) => self.open_file(path),
            Pending::OpenPart(source, setup) => self.open_files(Some(source), setup),
            Pending::OpenRun(results, row) => self.open_run(results, row, false),
            // The project stays open, with its recovery copy.
            Pending::OpenLibrary(path) => return self.submit_open(OpenTask::Library(path)),
            Pending::Quit => {
                self.session.closing = true;
                if let Some(home) = &self.session.home {
                    home.drop_library_copy();
                }
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
        if let Some(home) = &self.session.home {
            home.drop_copy();
        }
        self.session.copied = None;
    }

    /// Intercepts closing the window while there are unsaved changes.
    pub(in crate::app) fn watch_closing(&mut self, ctx: &Context) {
        if ctx.input(|input| input.viewport().close_requested()) && !self.session.closing {
            if self.state.document.is_unsaved() || self.library.is_unsaved() {
                ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
                self.run_guarded(ctx, Pending::Quit);
            } else if let Some(home) = &self.session.home {
                home.drop_copy();
            }
        }
    }

    /// Asks about unsaved changes, while that is due.
    pub(in crate::app) fn ask_unsaved(&mut self, ui: &Ui) {
        let project = self.state.document.name();
        let answer = self.session.pending.as_ref().and_then(|(work, _)| unsaved::ask(ui, *work, &project));
        let Some(answer) = answer else { return };
        let Some((work, pending)) = self.session.pending.take() else { return };
        match (answer, work) {
            (UnsavedAnswer::Save, UnsavedWork::Project) => {
                self.save_project(ui.ctx());
                self.session.after_saving = Some(pending);
            }
            (UnsavedAnswer::Save, UnsavedWork::Library) => {
                self.ask_for_library(ui.ctx());
                self.session.after_library = Some(pending);
            }
            (UnsavedAnswer::Discard, UnsavedWork::Project) => self.run_past_project(ui.ctx(), pending),
            (UnsavedAnswer::Discard, UnsavedWork::Library) => self.run_pending(ui.ctx(), pending),
            (UnsavedAnswer::Cancel, _) => {}
        }
    }

    /// Asks where to save the tool library. What waited for an earlier saving waits no longer.
    pub(in crate::app) fn ask_for_library(&mut self, ctx: &Context) {
        self.session.after_library = None;
        let path = self.library.library().and_then(|library| library.path.clone());
        if let Some(path) = &path {
            self.dialogs.note_folder(FilePlace::Shop, path);
        }
        let stem = path.as_ref().and_then(|path| path.file_stem()).unwrap_or("tools".as_ref());
        let name = format!("{}.toml", stem.to_string_lossy());
        self.dialogs.open_dialog(ctx, Purpose::SaveLibrary, name);
    }

    /// Records that the tool library was written, and continues with the pending action.
    pub(super) fn note_saved_library(&mut self, ctx: &Context, path: PathBuf, library: WrittenLibrary) {
        self.library.note_saved(path, library.given, library.written);
        if !self.library.is_unsaved()
            && let Some(pending) = self.session.after_library.take()
        {
            self.run_pending(ctx, pending);
        }
    }

    /// The tool library while its panel is open: no edit is taken back that nobody sees.
    pub(super) fn shown_library(&self) -> Option<&ShopLibrary> {
        self.library.library().filter(|_| self.state.look.panels.is_open(DockPanel::ToolLibrary))
    }

    /// Undoes the last change, of the project or of the tool library that is shown.
    pub(in crate::app) fn undo(&mut self, ctx: &Context) {
        typed::forget(ctx);
        let of_library = self.shown_library().and_then(ShopLibrary::changed_s);
        if of_library > self.state.document.changed_s() {
            self.library.undo();
            return;
        }
        let before = self.state.document.edited.sets.clone();
        self.state.document.undo();
        let sets = &self.state.document.edited.sets;
        // A variant that is gone is seen in its panel alone, and the setup is as it was.
        if let Some(gone) = before.get(sets.len()).filter(|_| before.starts_with(sets)) {
            self.state.report_done(format!("Saving \"{}\" is undone; Redo stores it again", gone.name));
        }
    }

    /// Redoes what was undone last, in the order in which it was done.
    pub(in crate::app) fn redo(&mut self, ctx: &Context) {
        typed::forget(ctx);
        let of_library = self.shown_library().and_then(ShopLibrary::undone_s);
        match (self.state.document.undone_s(), of_library) {
            (Some(project), Some(library)) if library < project => self.library.redo(),
            (None, Some(_)) => self.library.redo(),
            _ => self.state.document.redo(),
        }
    }
}
