//! The project: saving, recovery copies, and what waits until unsaved changes are saved or discarded.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Context, Rect, Ui};

use crate::app::App;
use crate::app::model::document::Edited;
use crate::app::model::field_faults::FaultyField;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::look::REVEAL;
use crate::app::model::part_source::PartSource;
use crate::app::model::planned::Side;
use crate::app::model::problem::{Problem, Topic};
use crate::app::model::state::RecoveryCopy;
use crate::app::tasks::files::WriteTask;
use crate::app::tasks::home::{Home, Preferences};
use crate::app::tasks::lock::{HeldLock, LockTry};
use crate::app::tasks::project::project_of;
use crate::app::views::tour::WindowRegion;
use crate::app::views::unsaved::{self, UnsavedAnswer};
use crate::gpu::camera::{Camera, Projection};
use crate::io::project_file::{EXTENSION, PlanSelection, Project, write_project};
use crate::io::setup_file::SetupEntryFault;
use crate::study::StudyResults;

/// Number of faults of a project's setups that are shown one by one.
const MAX_REPORTED_FAULTS: usize = 4;

/// Action that waits until unsaved changes are saved or discarded.
#[derive(Clone, Debug)]
pub(in crate::app) enum Pending {
    /// Start a new project.
    New,
    /// Open a file.
    Open(PathBuf),
    /// Open a part.
    OpenPart(PartSource),
    /// Open the run of a row of a study's results.
    OpenRun(Arc<StudyResults>, usize),
    /// Close the window.
    Quit,
}

/// State of the session that is not part of [`AppState`].
#[derive(Default)]
pub(in crate::app) struct Session {
    pub(super) home: Option<Home>,
    /// Content of the recovery copy on disk.
    pub(super) copied: Option<Edited>,
    /// When the recovery copy was due last, s.
    pub(super) copied_at: Option<f64>,
    /// Recovery copy of the project that was opened, while it is asked what to do with it.
    pub(super) found: Option<RecoveryCopy>,
    pending: Option<Pending>,
    /// Action to run once the project is written.
    after_saving: Option<Pending>,
    /// Whether closing was confirmed.
    pub(super) closing: bool,
    /// Whether the tour was taken or skipped, in this session or before.
    knows_tour: bool,
    /// Whether the tour begins with the next part.
    offers_tour: bool,
    /// The open project's file, and its lock where no other window holds it.
    claim: Option<(PathBuf, Option<HeldLock>)>,
}

impl Session {
    /// Whether a question about unsaved changes, of this session or another, is open.
    pub(in crate::app) fn is_asking(&self) -> bool {
        self.pending.is_some() || self.found.is_some()
    }
}

impl App {
    /// Sets the folder for recent projects, recovery copies, preferences and layout, and reads them.
    pub fn set_home(&mut self, folder: PathBuf) {
        let home = Home::new(folder);
        self.state.recents = home.recents();
        self.state.recoverable = home.recoverable();
        let preferences = home.preferences();
        (self.state.look.mouse, self.state.look.units) = (preferences.mouse, preferences.units);
        self.session.knows_tour = preferences.knows_tour;
        if let Some(layout) = home.layout() {
            self.take_layout(&layout);
        }
        self.session.home = Some(home);
    }

    /// Offers the tour with the first part that is opened, unless it was taken or skipped before.
    pub fn offer_tour(&mut self) {
        self.session.offers_tour = !self.session.knows_tour;
    }

    /// Draws the tour while it is due. `place_of`: where the parts of the window are.
    pub(in crate::app) fn show_tour(&mut self, ui: &Ui, place_of: impl Fn(WindowRegion) -> Option<Rect>) {
        if self.state.document.part.is_some() && std::mem::take(&mut self.session.offers_tour) {
            self.tour.begin();
        }
        if self.tour.show(ui, place_of) {
            self.session.knows_tour = true;
            self.store_preferences();
        }
    }

    /// Stores the layout of the panels for the next start, once it has changed.
    pub(in crate::app) fn store_layout(&mut self, ctx: &Context) {
        let changed = self.changed_layout(ctx);
        if let Some((layout, home)) = changed.zip(self.session.home.as_ref()) {
            home.store_layout(&layout);
        }
    }

    /// Stores the preferences for the next start.
    pub(in crate::app) fn store_preferences(&self) {
        if let Some(home) = &self.session.home {
            let (mouse, units) = (self.state.look.mouse, self.state.look.units);
            home.store_preferences(&Preferences { mouse, units, knows_tour: self.session.knows_tour });
        }
    }

    /// Runs an action that closes the open project; asks first if there are unsaved changes.
    pub(in crate::app) fn run_guarded(&mut self, ctx: &Context, pending: Pending) {
        if self.state.document.is_unsaved() {
            self.session.pending = Some(pending);
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
            Pending::OpenPart(source) => self.open_files(Some(source), None),
            Pending::OpenRun(results, row) => self.open_run(results, row, false),
            Pending::Quit => {
                self.session.closing = true;
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
            if self.state.document.is_unsaved() {
                ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
                self.session.pending = Some(Pending::Quit);
            } else if let Some(home) = &self.session.home {
                home.drop_copy();
            }
        }
    }

    /// Asks about unsaved changes, while that is due.
    pub(in crate::app) fn ask_unsaved(&mut self, ui: &Ui) {
        if self.session.pending.is_none() {
            return;
        }
        let Some(answer) = unsaved::ask(ui) else { return };
        let pending = self.session.pending.take();
        match answer {
            UnsavedAnswer::Save => {
                self.save_project(ui.ctx());
                self.session.after_saving = pending;
            }
            UnsavedAnswer::Discard => {
                if let Some(pending) = pending {
                    self.run_pending(ui.ctx(), pending);
                }
            }
            UnsavedAnswer::Cancel => {}
        }
    }

    /// Saves the project to its file, or asks for one. What waited for an earlier saving waits no longer: that
    /// one was cancelled or has failed.
    pub(in crate::app) fn save_project(&mut self, ctx: &Context) {
        self.session.after_saving = None;
        match self.state.document.path.clone() {
            Some(path) => self.write_project(path),
            None => self.ask_for_project(ctx),
        }
    }

    /// Asks where to save the project.
    pub(in crate::app) fn ask_for_project(&mut self, ctx: &Context) {
        self.session.after_saving = None;
        self.dialogs.open_dialog(ctx, Purpose::SaveProject, self.suggest_project());
    }

    /// Proposed file name of the project: its own, else that of the part.
    fn suggest_project(&self) -> String {
        let own = self.state.document.path.as_ref().and_then(|path| path.file_name());
        if let Some(own) = own {
            return own.to_string_lossy().into_owned();
        }
        let name = self.state.document.part.as_ref().map_or("project", |part| part.impeller.name.as_str());
        format!("{name}.{EXTENSION}")
    }

    /// Writes the project to `path`.
    pub(in crate::app) fn write_project(&mut self, path: PathBuf) {
        let path = if path.extension().is_none() { path.with_extension(EXTENSION) } else { path };
        if let Some(project) = project_of(&self.state, self.view.current()) {
            let text = write_project(&project, &path);
            self.write(WriteTask::Project(path, text, Box::new(self.state.document.edited.clone())));
        }
    }

    /// Records that a project was written, and continues with the pending action.
    pub(in crate::app) fn note_saved(&mut self, ctx: &Context, path: PathBuf, edited: Edited) {
        self.note_recent(&path);
        self.state.document.note_saved(path, edited);
        if !self.state.document.is_unsaved() {
            if let Some(home) = &self.session.home {
                home.drop_copy();
            }
            self.session.copied = None;
            if let Some(pending) = self.session.after_saving.take() {
                self.run_pending(ctx, pending);
            }
        }
    }

    /// Holds the lock of the open project's file, and says so where another window has that file open.
    pub(in crate::app) fn claim_project(&mut self) {
        let path = self.state.document.path.as_ref();
        if self.session.claim.as_ref().map(|(claimed, _)| claimed) == path {
            return;
        }
        // The file that was open before is free for others.
        self.session.claim = None;
        let Some((path, home)) = path.cloned().zip(self.session.home.as_ref()) else { return };
        let lock = match home.hold_project(&path) {
            LockTry::Held(lock) => Some(lock),
            LockTry::Unknown => None,
            LockTry::HeldElsewhere => {
                self.state.report_problem(Problem::new(
                    format!("{} is open in another window", path.display()),
                    "close one of the two, or save under another name: what is saved last replaces the other",
                ));
                None
            }
        };
        self.session.claim = Some((path, lock));
    }

    /// Moves a project to the front of the recent projects.
    pub(in crate::app) fn note_recent(&mut self, path: &Path) {
        if let Some(home) = &self.session.home {
            self.state.recents = home.note_recent(path);
        }
    }

    /// Reports the faults in the setups of an opened project. The project then counts as changed: defaults stand
    /// in place of what is faulty.
    fn report_setup_faults(&mut self, faults: &[SetupEntryFault]) {
        for SetupEntryFault { error: fault, entry } in faults.iter().take(MAX_REPORTED_FAULTS) {
            let help = format!("{}; until then the default is used", fault.help);
            let problem = Problem::of(Topic::Other, &format!("{}: {}", fault.place(), fault.message), &help);
            let field = entry.as_ref().and_then(FaultyField::of_entry);
            self.state.report_problem(problem.with_code(fault.code).at_field(field, &fault.message));
        }
        if faults.len() > MAX_REPORTED_FAULTS {
            let message =
                format!("{} more faults in the setups of the project", faults.len() - MAX_REPORTED_FAULTS);
            self.state
                .report_problem(Problem::new(message, "look through setup and variants before you save"));
        }
        if !faults.is_empty() {
            self.state.document.mark_unsaved();
        }
    }

    /// Restores figures, view and selection of a project whose part and setup are open already.
    pub(in crate::app) fn take_project(&mut self, path: PathBuf, project: &Project) {
        for set in &project.sets {
            if let Some(figures) = set.figures {
                self.state.results.store_figures(set.setup.clone(), figures);
            }
        }
        let framing = self.pictures.as_ref().and_then(|pictures| pictures.framing());
        if let Some((v, framing)) = project.viewpoint.zip(framing) {
            let mut camera = Camera::standard(crate::gpu::View::Iso, framing, 1.0);
            camera.target = v.target.into();
            (camera.yaw_rad, camera.pitch_rad, camera.distance) = (v.yaw, v.pitch, v.distance);
            camera.projection = if v.parallel { Projection::Orthographic } else { Projection::Perspective };
            self.view.restore(camera);
        }
        // The next plan keeps the selection if it has that position.
        let PlanSelection { before, position, cut } = project.chosen;
        let look = &mut self.state.look;
        look.side = if before { Side::Before } else { Side::After };
        (look.selected, look.cut_count) = (position, cut);
        look.reveal_selection = if position.is_some() { REVEAL } else { 0 };
        let part = self.state.document.part.as_ref();
        if part.is_some_and(|part| part.hash.fnv1a != project.part_hash) {
            self.state.report_problem(Problem::new(
                format!("{}: the part changed after the project was saved", path.display()),
                "check setup and variants, then save the project again",
            ));
        }
        self.report_setup_faults(&project.setup_faults);
        if self.is_recoverable(&path) {
            self.take_recovered(&path, project);
        } else {
            self.note_recent(&path);
            self.find_copy_of(&path);
        }
    }

    /// How often all runs of a study were gone through for its plot.
    pub fn study_passes(&self) -> usize {
        self.study.passes()
    }

    /// The results of a study.
    pub(in crate::app) fn study_results(&mut self, ui: &mut Ui) {
        let Some((results, row)) = self.study.show(ui) else { return };
        let own = self.state.document.part.as_ref().map(|part| part.hash.sha256.as_str());
        if own.is_some() && own == results.field(row, "part_hash") {
            // An edit of the open project, which can be undone: nothing is closed, and nothing is lost.
            self.open_run(results, row, true);
        } else {
            self.run_guarded(ui.ctx(), Pending::OpenRun(results, row));
        }
    }
}
