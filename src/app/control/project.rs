//! The project: saving, its lock, and what is restored when it is opened.

use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::{Context, Rect, Ui};

use crate::app::App;
use crate::app::control::unsaved::Pending;
use crate::app::model::document::Edited;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::library_state::LibraryState;
use crate::app::model::look::REVEAL;
use crate::app::model::planned::Side;
use crate::app::model::problem::{Problem, Topic};
use crate::app::model::state::RecoveryCopy;
use crate::app::tasks::files::{ProjectTask, WriteTask, WrittenProject};
use crate::app::tasks::home::{Home, Preferences};
use crate::app::tasks::lock::{HeldLock, LockTry};
use crate::app::tasks::open_task::OpenTask;
use crate::app::tasks::opening::MissingPart;
use crate::app::tasks::project::{project_of, show_view_of};
use crate::app::views::changed::{self, ChangedAnswer};
use crate::app::views::missing_part::{self, MissingPartAnswer};
use crate::app::views::tour::WindowRegion;
use crate::app::views::unsaved::UnsavedWork;
use crate::gpu::camera::{Camera, Projection};
use crate::io::project_file::{EXTENSION, PlanSelection, Project, write_project};
use crate::io::source::is_same_file;

/// Number of faults of a project's setups that are shown one by one.
const MAX_REPORTED_FAULTS: usize = 4;

/// Time between two attempts to hold the lock of a project that another window has open, s.
const CLAIM_EVERY: f64 = 1.0;

/// [`Look::range`] and [`Look::wall_end`].
type ColourScales = (Option<(f32, f32)>, Option<f32>);

/// State of the session that is not part of [`AppState`].
#[derive(Default)]
pub(in crate::app) struct Session {
    pub(super) home: Option<Home>,
    /// Content of the recovery copy on disk, with the colour scales of hub and walls.
    pub(super) copied: Option<(Edited, ColourScales)>,
    /// When the recovery copy was due last, s.
    pub(super) copied_at: Option<f64>,
    /// When recovery copies of other sessions are looked for again, s; `None` where none of them runs.
    pub(super) look_for_copies_at: Option<f64>,
    /// How often they are still looked for while a project or part is open.
    pub(super) looks_left: u32,
    /// Tool library in its copy on disk, when that was due last, s, and the copy that another session has
    /// left.
    pub(super) copied_library: Option<LibraryState>,
    pub(super) library_copied_at: Option<f64>,
    pub(super) left_library: Option<PathBuf>,
    /// Recovery copy of the project that was opened, while it is asked what to do with it.
    pub(super) found: Option<RecoveryCopy>,
    /// Recovery copy of the start page, while it is asked whether to discard it.
    pub(super) discarding: Option<RecoveryCopy>,
    /// Recovery copies of other projects and parts that were said to be there.
    pub(super) noted_copies: Vec<PathBuf>,
    /// Action that waits for an answer about unsaved work, and about which.
    pub(super) pending: Option<(UnsavedWork, Pending)>,
    /// Action to run once the project is written.
    pub(super) after_saving: Option<Pending>,
    /// Action to run once the tool library is written.
    pub(super) after_library: Option<Pending>,
    /// A project that was opened, while it is asked where its part is.
    pub(super) missing_part: Option<MissingPart>,
    /// The same while its part is being located.
    located: Option<MissingPart>,
    /// The project's file, while it is asked whether to replace what another window or program has written
    /// there.
    pub(super) changed_on_disk: Option<PathBuf>,
    /// Whether closing was confirmed.
    pub(super) closing: bool,
    /// Whether the tour was taken or skipped, in this session or before.
    knows_tour: bool,
    /// Whether the tour begins with the next part.
    offers_tour: bool,
    /// The open project's file, and its lock where no other window holds it.
    claim: Option<(PathBuf, Option<HeldLock>)>,
    /// Time of the next attempt to hold its lock, while another window does.
    claim_again_at: Option<f64>,
}

impl Session {
    /// Whether a question about unsaved changes, of this session or another, or about a changed file is open.
    pub(in crate::app) fn is_asking(&self) -> bool {
        self.pending.is_some()
            || self.found.is_some()
            || self.discarding.is_some()
            || self.changed_on_disk.is_some()
            || self.missing_part.is_some()
    }
}

impl App {
    /// Sets the folder for recent projects, recovery copies, preferences and layout, and reads them.
    pub fn set_home(&mut self, folder: PathBuf) {
        let home = Home::new(folder);
        home.sweep_locks();
        self.state.recents = home.recents();
        self.state.recoverable = home.recoverable();
        self.session.look_for_copies_at = home.has_running_session().then_some(0.0);
        let preferences = home.preferences();
        (self.state.look.mouse, self.state.look.units) = (preferences.mouse, preferences.units);
        self.session.knows_tour = preferences.knows_tour;
        if let Some(layout) = home.layout() {
            self.take_layout(&layout);
        }
        let left = home.left_library();
        self.session.home = Some(home);
        if let Some(left) = left {
            self.take_left_library(left);
        }
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

    /// Saves the project to its file, or asks for one. What waited for an earlier saving waits no longer:
    /// that one was cancelled or has failed.
    pub(in crate::app) fn save_project(&mut self, ctx: &Context) {
        self.session.after_saving = None;
        match self.state.document.path.clone() {
            Some(path) => self.write_project(path, false),
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

    /// Writes the project to `path`. `replaces`: even if its own file was changed on disk.
    pub(in crate::app) fn write_project(&mut self, path: PathBuf, replaces: bool) {
        let path = if path.extension().is_none() { path.with_extension(EXTENSION) } else { path };
        if let Some(project) = project_of(&self.state, self.view.current()) {
            let text = write_project(&project, &path);
            let document = &self.state.document;
            let is_own = document.path.as_ref().is_some_and(|own| is_same_file(own, &path));
            let known = document.on_disk.filter(|_| is_own && !replaces);
            let edited = document.edited.clone();
            self.write(WriteTask::Project(Box::new(ProjectTask { path, text, edited, known })));
        }
    }

    /// Asks about a project's file that was changed on disk, while that is due.
    pub(in crate::app) fn ask_changed(&mut self, ui: &Ui) {
        let answer = self.session.changed_on_disk.as_ref().and_then(|path| changed::ask(ui, path));
        let Some(answer) = answer else { return };
        let Some(path) = self.session.changed_on_disk.take() else { return };
        match answer {
            ChangedAnswer::Overwrite => self.write_project(path, true),
            ChangedAnswer::SaveAs => {
                let pending = self.session.after_saving.take();
                self.ask_for_project(ui.ctx());
                self.session.after_saving = pending;
            }
            ChangedAnswer::Cancel => self.session.after_saving = None,
        }
    }

    /// Asks where the part of an opened project is, while that is due.
    pub(in crate::app) fn ask_missing_part(&mut self, ui: &Ui) {
        let Some(missing) = &self.session.missing_part else { return };
        let Some(answer) = missing_part::ask(ui, &missing.name, &missing.source.shown()) else { return };
        self.session.located = self.session.missing_part.take();
        if answer == MissingPartAnswer::Locate {
            self.dialogs.open_dialog(ui.ctx(), Purpose::LocatePart, String::new());
        }
    }

    /// Opens the project whose part was located at `path`.
    pub(in crate::app) fn open_located(&mut self, path: PathBuf) {
        let Some(MissingPart { project, source, .. }) = self.session.located.take() else { return };
        self.submit_open(OpenTask::Project(project, Some(source.moved_to(path))));
    }

    /// Records that a project was written, and continues with the pending action.
    pub(in crate::app) fn note_saved(&mut self, ctx: &Context, written: WrittenProject) {
        let WrittenProject { path, edited, hash } = written;
        self.note_recent(&path);
        self.state.document.note_saved(path, edited, hash);
        if !self.state.document.is_unsaved() {
            if let Some(home) = &self.session.home {
                home.drop_copy();
            }
            self.session.copied = None;
            if let Some(pending) = self.session.after_saving.take() {
                self.run_past_project(ctx, pending);
            }
        }
    }

    /// Holds the lock of the open project's file, and says so where another window has that file open, until
    /// that closes it. Call once per frame.
    pub(in crate::app) fn claim_project(&mut self, ctx: &Context) {
        let path = self.state.document.path.as_ref();
        let is_known = self.session.claim.as_ref().map(|(claimed, _)| claimed) == path;
        let now = ctx.input(|input| input.time);
        if is_known {
            let Some(at) = self.session.claim_again_at else { return };
            ctx.request_repaint_after(Duration::from_secs_f64((at - now).clamp(0.0, CLAIM_EVERY)));
            if now < at {
                return;
            }
        }
        // The file that was open before is free for others.
        (self.session.claim, self.session.claim_again_at) = (None, None);
        let Some((path, home)) = path.cloned().zip(self.session.home.as_ref()) else {
            return self.state.withdraw(Topic::SharedProject);
        };
        let lock = match home.hold_project(&path) {
            LockTry::Held(lock) => Some(lock),
            LockTry::Unknown => None,
            LockTry::HeldElsewhere => {
                self.session.claim_again_at = Some(now + CLAIM_EVERY);
                ctx.request_repaint_after(Duration::from_secs_f64(CLAIM_EVERY));
                if !is_known {
                    self.state.withdraw(Topic::SharedProject);
                    let message = format!("{} is open in another window", path.display());
                    let help = "close one of the two, or save under another name; saving asks before it \
                                replaces work of the other";
                    let problem = Problem::new(message, help);
                    self.state.report_problem(Problem { topic: Topic::SharedProject, ..problem });
                }
                None
            }
        };
        if self.session.claim_again_at.is_none() {
            self.state.withdraw(Topic::SharedProject);
        }
        self.session.claim = Some((path, lock));
    }

    /// Moves a project, or a part that was opened by itself, to the front of the recent files.
    pub(in crate::app) fn note_recent(&mut self, path: &Path) {
        if let Some(home) = &self.session.home {
            self.state.recents = home.note_recent(path);
        }
    }

    /// Reports the faults in the setups of an opened project. The project does not count as changed: what is
    /// saved keeps the faulty values until they are edited.
    fn report_setup_faults(&mut self, project: &Project) {
        // Those of variants are at no field: the fields are of the current setup.
        let current = project.setup_faults.iter().map(Problem::of_replaced);
        let others = project.sets.iter().flat_map(|set| &set.faults);
        let others = others.map(|fault| Problem { field: None, ..Problem::of_replaced(fault) });
        let mut problems = current.chain(others);
        let shown: Vec<Problem> = problems.by_ref().take(MAX_REPORTED_FAULTS).collect();
        let rest: Vec<Problem> = problems.collect();
        for problem in shown {
            self.state.report_problem(problem);
        }
        if !rest.is_empty() {
            let word = if rest.len() == 1 { "fault" } else { "faults" };
            let message = format!("{} more {word} in the setups of the project", rest.len());
            let help = "check the setup and the variants before you export a program";
            self.state.report_problem(Problem::about(Topic::Project, &message, help));
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
        let PlanSelection { before, position, cut, channels, channels_cut, channel, .. } = project.chosen;
        let channel_count = self.channel_count();
        let look = &mut self.state.look;
        show_view_of(project, look);
        look.side = if before { Side::Before } else { Side::After };
        (look.selected, look.selected_channel, look.cut_count) = (position, channel, cut);
        look.shown_channels = channels.clamp(1, channel_count);
        look.channels_cut = channels_cut;
        look.reveal_selection = if position.is_some() { REVEAL } else { 0 };
        let part = self.state.document.part.as_ref();
        if part.is_some_and(|part| part.hash.fnv1a != project.part_hash) {
            self.state.report_problem(Problem::new(
                format!("{}: the part changed after the project was saved", path.display()),
                "check setup and variants, then save the project again",
            ));
        }
        self.report_setup_faults(project);
        if self.is_recoverable(&path) {
            self.take_recovered(&path, project);
        } else {
            self.note_recent(&path);
            self.find_copy_of_open();
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
