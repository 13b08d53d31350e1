//! Recovery copies: written while there are unsaved changes, offered after a session that ended without
//! closing.

use std::path::Path;
use std::time::Duration;

use egui::{Context, Ui};

use super::project::Session;
use super::unsaved::Pending;
use crate::app::App;
use crate::app::model::document::Edited;
use crate::app::model::file_purpose::FilePlace;
use crate::app::model::problem::Problem;
use crate::app::model::shop_library::ShopLibrary;
use crate::app::model::state::RecoveryCopy;
use crate::app::tasks::home::{self, LeftLibrary};
use crate::app::tasks::project::project_of;
use crate::app::views::recover::{self, RecoverAnswer};
use crate::io::project_file::{Project, write_project};
use crate::io::source::is_same_file;
use crate::job::worker::Outcome;

/// Least time between two recovery copies: half of the two seconds after which no edit may be lost, as an
/// edit waits for a frame, too.
const COPY_EVERY: Duration = Duration::from_secs(1);

/// Time between two looks for the copies of sessions that end while the start page is shown.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// How often they are looked for once a project or part is open: a session that was killed ends sooner, and
/// one that runs on is that of another window.
const LOOKS: u32 = 30;

impl App {
    /// Offers the copies of sessions that still ran at the start, or when the project or part was opened: one
    /// that was just killed may take seconds to end. Call once per frame.
    pub(in crate::app) fn look_for_copies(&mut self, ctx: &Context) {
        let is_open = self.state.document.part.is_some();
        let is_due = !is_open || (self.session.looks_left > 0 && !self.is_asking());
        let Some(at) = self.session.look_for_copies_at.filter(|_| is_due) else { return };
        let (now, every) = (ctx.input(|input| input.time), LOOK_EVERY.as_secs_f64());
        let Some(home) = self.session.home.as_ref().filter(|_| now >= at) else {
            ctx.request_repaint_after(Duration::from_secs_f64((at - now).clamp(0.0, every)));
            return;
        };
        let still_runs = home.has_running_session();
        self.state.recoverable = home.recoverable();
        self.session.look_for_copies_at = still_runs.then_some(now + every);
        if is_open {
            self.session.looks_left -= 1;
            self.take_copy_of_open();
        }
        ctx.request_repaint_after(LOOK_EVERY);
    }

    /// Whether `path` is a recovery copy that is offered.
    pub(in crate::app) fn is_recoverable(&self, path: &Path) -> bool {
        self.state.recoverable.iter().any(|copy| copy.path == path)
    }

    /// Continues with the recovery copy at `path`, whose content is open already.
    pub(super) fn take_recovered(&mut self, path: &Path, project: &Project) {
        // A relative path would be one of the folder that the program was started in then.
        let original = project.original.clone().filter(|original| original.is_absolute());
        self.state.document.path.clone_from(&original);
        self.state.document.mark_unsaved();
        // It is saved beside the project, or else the part, and not among the copies.
        let part = self.state.document.part.as_ref().and_then(|part| part.source.file());
        if let Some(beside) = original.or_else(|| part.map(|(file, _)| file.to_owned())) {
            self.dialogs.note_folder(FilePlace::Part, &beside);
        }
        self.state
            .report_done("Recovered unsaved changes of the last session; save the project to keep them");
        // Once the content is in this session's own recovery copy.
        if self.copy_now() {
            self.drop_recoverable(path);
        }
    }

    /// Looks for unsaved changes of the project, or of a session with the part, that was just opened.
    pub(super) fn find_copy_of_open(&mut self) {
        let Some(home) = &self.session.home else { return };
        // First, as a session may end in between.
        let runs = home.has_running_session();
        self.state.recoverable = home.recoverable();
        self.take_copy_of_open();
        let looks_on = runs && self.session.found.is_none();
        (self.session.look_for_copies_at, self.session.looks_left) = (looks_on.then_some(0.0), LOOKS);
    }

    /// Takes a copy of the open project, or of its part where it is none, to ask about it.
    fn take_copy_of_open(&mut self) {
        let document = &self.state.document;
        let part = document.part.as_ref().and_then(|part| part.source.file()).map(|(file, _)| file);
        let is_it = |copy: &&RecoveryCopy| match &document.path {
            Some(path) => copy.project.as_deref().is_some_and(|project| is_same_file(project, path)),
            None => copy.part.as_deref().zip(part).is_some_and(|(of, part)| is_same_file(of, part)),
        };
        self.session.found = self.state.recoverable.iter().find(is_it).cloned();
        self.note_other_copies();
    }

    /// Says of copies of other projects and parts, once each, that they are there: they are offered on the
    /// start page, which a window that was started with a part does not show.
    fn note_other_copies(&mut self) {
        let Session { found, noted_copies, .. } = &mut self.session;
        let mut names = Vec::new();
        for RecoveryCopy { path, name, .. } in &self.state.recoverable {
            if found.as_ref().is_none_or(|found| found.path != *path) && !noted_copies.contains(path) {
                noted_copies.push(path.clone());
                names.push(name.as_str());
            }
        }
        if !names.is_empty() {
            // Without their age, which would not go on here.
            let names = names.join("; ");
            let what = format!("A session that ended without closing has left unsaved changes: {names}");
            self.state.report_problem(Problem::note(what, "Choose File > New to recover or discard them"));
        }
    }

    /// Whether the recovery copy at `path`, which is offered, is gone: another window has taken it over. Says
    /// so.
    pub(super) fn was_recovered_elsewhere(&mut self, path: &Path) -> bool {
        if !self.is_recoverable(path) || path.exists() {
            return false;
        }
        self.state.recoverable.retain(|copy| copy.path != path);
        let what = "Another window has recovered or discarded these unsaved changes";
        self.state.report_problem(Problem::unopened(what, "go on in that window"));
        true
    }

    /// Asks what to do with the unsaved changes of the opened project, while that is due.
    pub(in crate::app) fn ask_recover(&mut self, ui: &Ui) {
        let answer = self.session.found.as_ref().and_then(|copy| recover::ask(ui, copy));
        let Some(answer) = answer else { return };
        let Some(copy) = self.session.found.take() else { return };
        match answer {
            // Nothing was edited before the first look.
            RecoverAnswer::Recover if self.session.looks_left == LOOKS => self.open_file(copy.path),
            RecoverAnswer::Recover => self.run_guarded(ui.ctx(), Pending::Open(copy.path)),
            RecoverAnswer::Discard => self.drop_recoverable(&copy.path),
            RecoverAnswer::Later => {}
        }
    }

    /// Asks whether to discard the recovery copy at `path`: a click that is meant for another is easily made.
    pub(in crate::app) fn begin_discarding(&mut self, path: &Path) {
        self.session.discarding = self.state.recoverable.iter().find(|copy| copy.path == path).cloned();
    }

    /// Asks whether to discard a recovery copy, while that is due.
    pub(in crate::app) fn ask_discard(&mut self, ui: &Ui) {
        let answer = self.session.discarding.as_ref().and_then(|copy| recover::ask_discard(ui, copy));
        let Some(discards) = answer else { return };
        if let Some(copy) = self.session.discarding.take().filter(|_| discards) {
            self.drop_recoverable(&copy.path);
        }
    }

    /// Discards a recovery copy of another session.
    fn drop_recoverable(&mut self, path: &Path) {
        self.state.recoverable.retain(|copy| copy.path != path);
        home::remove_copy(path);
    }

    /// Writes the recovery copy when it is due: an edit after a pause at once, and one of many soon; likewise
    /// with colour scales that are chosen anew. Removes it once the edits are undone. Call once per frame.
    pub(in crate::app) fn keep_copy(&mut self, ctx: &Context) {
        let session = &mut self.session;
        // Closing was confirmed: what was not saved is meant to go.
        let Some(home) = session.home.as_ref().filter(|_| !session.closing) else { return };
        if !self.state.document.is_unsaved() {
            if session.copied.take().is_some() {
                home.drop_copy();
            }
            return;
        }
        let scales = (self.state.look.range, self.state.look.wall_end);
        let is_it = |(edited, known): &(Edited, _)| *edited == self.state.document.edited && *known == scales;
        if session.copied.as_ref().is_some_and(is_it) {
            return;
        }
        let now = ctx.input(|input| input.time);
        let rest = session.copied_at.map_or(0.0, |at| COPY_EVERY.as_secs_f64() - (now - at));
        if rest <= 0.0 {
            session.copied_at = Some(now);
            self.copy_now();
        } else {
            ctx.request_repaint_after(Duration::from_secs_f64(rest));
        }
    }

    /// Goes on with the edits of the tool library of a session that ended without closing.
    pub(super) fn take_left_library(&mut self, left: LeftLibrary) {
        let LeftLibrary { original, content, copy } = left;
        self.library.take(ShopLibrary::recovered(original, content));
        self.session.left_library = Some(copy);
        self.state.report_done(
            "Edits of the shop library of the last session are back; save the library to keep them",
        );
    }

    /// Writes the copy of the edited tool library when it is due. Call once per frame.
    pub(in crate::app) fn keep_library_copy(&mut self, ctx: &Context) {
        self.collect_library_copy();
        let session = &mut self.session;
        let Some(home) = session.home.as_ref().filter(|_| !session.closing) else { return };
        let Some(library) = self.library.library().filter(|library| library.is_unsaved()) else {
            if session.copied_library.take().is_some() {
                home.drop_library_copy();
            }
            return;
        };
        if session.copied_library.as_ref() == Some(library.content()) {
            return;
        }
        let now = ctx.input(|input| input.time);
        let rest = session.library_copied_at.map_or(0.0, |at| COPY_EVERY.as_secs_f64() - (now - at));
        if rest > 0.0 {
            ctx.request_repaint_after(Duration::from_secs_f64(rest));
            return;
        }
        session.library_copied_at = Some(now);
        // Reported once; the next edit tries again.
        session.copied_library = Some(library.content().clone());
        self.work.copier.submit(home.library_copy(library.path.clone(), library.content().clone()));
    }

    /// What has become of the last copy of the tool library.
    fn collect_library_copy(&mut self) {
        match self.work.copier.take_outcome() {
            Some((_, Outcome::Done(()))) => {
                if let Some(left) = self.session.left_library.take() {
                    home::remove_copy(&left);
                }
            }
            Some((_, Outcome::Failed(error))) => self.state.report_problem(Problem::from(&error)),
            Some((_, Outcome::Panicked(what))) => {
                let what = format!("The copy of the shop library was not written ({what})");
                self.state.report_problem(Problem::new(what, "save the library"));
            }
            Some((_, Outcome::Cancelled)) | None => {}
        }
    }

    /// Writes the recovery copy, on the UI thread: it is small and written rarely. Returns whether it is
    /// written.
    pub(in crate::app) fn copy_now(&mut self) -> bool {
        let Some(home) = &self.session.home else { return false };
        let Some(mut project) = project_of(&self.state, self.view.current()) else { return false };
        project.original.clone_from(&self.state.document.path);
        project.original_hash = self.state.document.on_disk.filter(|_| project.original.is_some());
        let written = home.write_copy(&write_project(&project, home.copy()));
        // An error is reported once; the next change tries again.
        let look = &self.state.look;
        self.session.copied = Some((self.state.document.edited.clone(), (look.range, look.wall_end)));
        if let Err(error) = &written {
            let what = format!("No recovery copy was written. {}", Problem::from(error).message);
            self.state.report_problem(Problem::new(what, "save the project: a crash would lose the changes"));
        }
        written.is_ok()
    }
}
