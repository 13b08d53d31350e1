//! Background tasks: opening, planning, writing, and the handling of their results.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::unsaved::Pending;
use crate::app::App;
use crate::app::model::document::Edited;
use crate::app::model::field_faults::FaultyField;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::look::Operation;
use crate::app::model::panels::DockPanel;
use crate::app::model::part_source::PartSource;
use crate::app::model::problem::{Problem, Topic};
use crate::app::model::role_choices::hint_for_dialog;
use crate::app::model::shop_library::ShopLibrary;
use crate::app::tasks::engine::PlanTask;
use crate::app::tasks::files::{self, WriteTask};
use crate::app::tasks::open_task::OpenTask;
use crate::app::tasks::opening::Opened;
use crate::app::tasks::programs::OnFaults;
use crate::app::tasks::project::{edited_of, source_of};
use crate::app::tasks::work::PlanKey;
use crate::io::plan_inputs::is_plan_file;
use crate::job::JobError;
use crate::job::flank::{FlankOutcome, FlankRequest};
use crate::job::worker::Outcome;
use crate::part::BlankShape;
use crate::setup::SetupFault;
use crate::study::StudyResults;

/// Where options of a part's file are given that its notes ask for.
const IN_ROLES_DIALOG: &str = "If that is wrong: give it in File, Assign surfaces…";

impl App {
    /// Opens a project, setup or part file in the background.
    pub fn open_path(&mut self, path: PathBuf) {
        self.open_file(path);
    }

    pub(in crate::app) fn open_files(&mut self, part: Option<PartSource>, setup: Option<PathBuf>) {
        let open = self.state.document.part.as_ref();
        let defaults = Box::new(open.map(|part| part.defaults.clone()).unwrap_or_default());
        self.submit_open(OpenTask::Files { part, setup, defaults });
    }

    pub(in crate::app) fn submit_open(&mut self, task: OpenTask) {
        self.state.opening = match &task {
            OpenTask::Project(path, _) => Some(PartSource::File(path.clone())),
            OpenTask::Files { part, .. } => part.clone(),
            OpenTask::Nodes { source, .. } => Some(source.clone()),
            OpenTask::Blank(_)
            | OpenTask::Machine(_)
            | OpenTask::Library(_)
            | OpenTask::Study(_)
            | OpenTask::Run { .. } => None,
        };
        self.state.notice = None;
        self.work.opener.submit(task);
    }

    /// Plans the run of a row of a study's results.
    pub(in crate::app) fn open_run(&mut self, results: Arc<StudyResults>, row: usize, keeps_part: bool) {
        let open = self.state.document.part.as_ref().map(|part| part.hash.clone());
        self.submit_open(OpenTask::Run { results, row, open, keeps_part });
    }

    /// Opens a project, setup, part or study, or the part and setup of a plan, depending on the file.
    pub(in crate::app) fn open_file(&mut self, path: PathBuf) {
        if self.was_recovered_elsewhere(&path) {
            return;
        }
        if !self.is_recoverable(&path) {
            self.dialogs.note_folder(files::place_of(&path), &path);
        }
        if files::is_study(&path) {
            self.submit_open(OpenTask::Study(path));
        } else if files::is_program(&path) {
            self.check_program(path);
        } else if files::is_project(&path) {
            self.submit_open(OpenTask::Project(path, None));
        } else if files::is_setup(&path) {
            self.open_files(None, Some(path));
        } else if is_plan_file(&path) {
            self.open_files(Some(PartSource::File(path.clone())), Some(path));
        } else {
            self.open_files(Some(PartSource::File(path)), None);
        }
    }

    /// Plans with the current setup.
    pub(in crate::app) fn plan(&mut self) {
        // The same once more would only begin from the start.
        let runs = self.work.is_planning() && !self.work.planner.is_stopping();
        let is_same = |asked: &PlanKey| {
            !asked.draft && asked.compare == self.state.compare && self.state.is_current(&asked.setup)
        };
        if !(runs && self.work.asked.as_ref().is_some_and(is_same)) {
            self.submit_plan(false);
        }
    }

    /// Plans. A draft has one policy and a coarse field: while a slider moves, it is soon replaced.
    fn submit_plan(&mut self, draft: bool) {
        let Some(part) = &self.state.document.part else { return };
        self.state.notice = None;
        let asked = PlanKey {
            setup: self.state.document.edited.setup.clone(),
            compare: self.state.compare && !draft,
            draft,
        };
        self.work.tasks += 1;
        let task = PlanTask {
            number: self.work.tasks,
            part: Arc::clone(&part.impeller),
            setup: asked.setup.clone(),
            compare: asked.compare,
            draft,
            last: self.state.results.planned.clone(),
        };
        self.work.asked = Some(asked);
        self.work.submitted = Some(Instant::now());
        self.work.planner.submit(task);
    }

    /// Plans edits automatically if auto-update is on. `held`: a mouse button is down, so that more edits
    /// will follow.
    pub(in crate::app) fn plan_edits(&mut self, held: bool) {
        self.plan_flank_edits(held);
        self.check_edits(held);
        let (true, Some(asked)) = (self.state.auto_update, &self.work.asked) else { return };
        let same = self.state.is_current(&asked.setup);
        let enough = held || (!asked.draft && asked.compare == self.state.compare);
        if same && enough {
            return;
        }
        // While a slider is held, let the task finish if it soon ends. Also wait for its first checked stage:
        // otherwise continuous movement would restart planning before anything is shown.
        let lacks_stage = || {
            let preview = self.state.results.preview.as_ref();
            !preview.is_some_and(|p| p.task == self.work.tasks && p.has_checked_stage())
        };
        let worth_waiting = self.work.is_planning() && (lacks_stage() || self.work.plan_ends_soon());
        if !(held && worth_waiting) {
            self.submit_plan(held);
        }
    }

    /// Stores the latest preview; previews of finished or superseded tasks are dropped.
    fn collect_preview(&mut self) {
        let preview = self.work.preview.take().filter(|preview| preview.task == self.work.tasks);
        if !self.work.planner.is_busy() {
            self.state.results.preview = None;
        } else if preview.is_some() {
            self.state.results.preview = preview;
        }
    }

    /// Name and progress (0…1) of the running task that the user can cancel.
    pub fn running_task(&self) -> Option<(&'static str, f64)> {
        let curve = || self.weighing.progress().map(|fraction| ("Weighing plunges", fraction));
        self.work.running(self.state.look.operation).or_else(curve)
    }

    /// Stops opening and planning; the planner returns its best plan so far, or nothing at the second call.
    /// What is written in a moment is not cancelled.
    pub(in crate::app) fn cancel(&mut self) {
        // The curve goes on while what the status bar shows is cancelled.
        if self.work.running(self.state.look.operation).is_none() {
            self.weighing.cancel();
        }
        self.work.opener.cancel();
        self.work.planner.stop();
        self.work.flanker.cancel();
        self.work.checker.cancel();
        self.work.cancel_judging();
    }

    /// Cancels the search for the curve of time against stock, and nothing else.
    pub(in crate::app) fn cancel_curve(&mut self) {
        self.weighing.cancel();
        self.state.report_done("Curve cancelled");
    }

    /// Plans flank milling passes with the current setup.
    pub(in crate::app) fn plan_flank(&mut self) {
        let Some(part) = &self.state.document.part else { return };
        let setup = self.state.document.edited.setup.clone();
        // The same once more would only begin from the start.
        if self.work.flanker.is_busy() && self.work.asked_flank.as_ref() == Some(&setup) {
            return;
        }
        self.state.notice = None;
        self.work.asked_flank = Some(setup.clone());
        self.work.flanker.submit(FlankRequest { part: Arc::clone(&part.impeller), setup });
    }

    /// Plans a flank plan again that is older than the setup, if auto-update is on. Unlike plunges it is
    /// planned only once the mouse is released, as it has no drafts.
    fn plan_flank_edits(&mut self, held: bool) {
        let setup = &self.state.document.edited.setup;
        let follows = self.state.auto_update && !held && self.state.look.operation == Operation::Flank;
        if follows && self.state.flank_is_stale() && self.work.asked_flank.as_ref() != Some(setup) {
            self.plan_flank();
        }
    }

    fn take_flank(&mut self, end: Outcome<FlankOutcome, JobError>) {
        match end {
            Outcome::Done(outcome) => {
                let part = self.state.document.part.as_ref();
                if part.is_some_and(|part| Arc::ptr_eq(&part.impeller, &outcome.workpiece.part)) {
                    self.state.take_flank(outcome);
                }
            }
            Outcome::Cancelled | Outcome::Failed(JobError::Cancelled) => {
                self.state.flank_cancelled();
            }
            Outcome::Failed(JobError::Setup(fault)) => {
                self.report_setup_fault(Topic::Flank, &fault);
            }
            Outcome::Panicked(what) => {
                self.state.report_problem(panic_problem(Topic::Flank, "Flank calculation", &what));
            }
        }
    }

    /// Reports why a setup cannot be planned, at its field too.
    fn report_setup_fault(&mut self, topic: Topic, fault: &SetupFault) {
        let field = FaultyField::of_place(fault.place, &self.state.document.edited.setup);
        let problem = Problem::about(topic, &fault.message, &fault.help);
        self.state.report_problem(problem.with_code(fault.code).at_field(field, &fault.message));
    }

    /// Handles the results of finished tasks.
    pub(in crate::app) fn collect(&mut self, ctx: &egui::Context) {
        if let Some((_, end)) = self.work.opener.take_outcome() {
            self.state.opening = None;
            self.roles.enable();
            match end {
                Outcome::Done(opened) => {
                    self.state.solve(Topic::Opening);
                    self.take_opened(opened);
                }
                Outcome::Cancelled => self.state.report_done("Opening cancelled"),
                Outcome::Failed(error) => self.state.report_problem(Problem::of_opening(&error)),
                Outcome::Panicked(what) => {
                    self.state.report_problem(panic_problem(Topic::Opening, "Opening", &what));
                }
            }
        }
        if let Some((_, end)) = self.work.planner.take_outcome() {
            match end {
                Outcome::Done(planned) => {
                    // Drop the plan of a part that was replaced meanwhile.
                    let part = self.state.document.part.as_ref();
                    if part.is_some_and(|part| Arc::ptr_eq(&part.impeller, &planned.outcome.workpiece.part)) {
                        self.state.take_plan(planned);
                    }
                }
                Outcome::Cancelled | Outcome::Failed(JobError::Cancelled) => self.state.plan_cancelled(),
                Outcome::Failed(JobError::Setup(fault)) => {
                    self.report_setup_fault(Topic::Plan, &fault);
                }
                Outcome::Panicked(what) => {
                    self.state.report_problem(panic_problem(Topic::Plan, "Calculation", &what));
                }
            }
        }
        self.collect_preview();
        if let Some((_, end)) = self.work.flanker.take_outcome() {
            self.take_flank(end);
        }
        if let Some((_, end)) = self.work.checker.take_outcome() {
            self.take_checked(end);
        }
        for end in self.work.take_written() {
            self.take_written(ctx, end);
        }
        self.collect_device_faults(ctx);
    }

    fn take_opened(&mut self, opened: Opened) {
        let Opened {
            part,
            setup,
            project,
            on_disk,
            blank,
            machine,
            library,
            study,
            is_run,
            is_flank_plan,
            changed_part,
            missing_part,
            unassigned,
        } = opened;
        if let Some(results) = study {
            let name = results.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            self.state.report_done(format!("Opened {name}: {} runs", results.table.rows.len()));
            self.study.take(results);
            self.state.look.panels.open(DockPanel::Study);
            return;
        }
        if let Some((path, content)) = library {
            let count = content.tools.len();
            self.state.report_done(format!("Opened {}: {count} tools", path.display()));
            self.library.take(ShopLibrary::new(Some(path), content));
            self.state.look.panels.open(DockPanel::ToolLibrary);
            return;
        }
        if missing_part.is_some() {
            self.session.missing_part = missing_part;
            return;
        }
        if let Some(unassigned) = unassigned {
            self.roles.ask(unassigned);
            return;
        }
        let new_part = part.is_some();
        if let Some((part, mesh)) = part {
            self.roles.close();
            self.work.planner_cancel();
            // Roles that are not stored in a file yet count as unsaved changes.
            let chosen = matches!(part.source, PartSource::Mesh(..))
                && project.as_ref().is_none_or(|(_, project)| source_of(project) != part.source);
            let same = chosen && part.source.file().is_some_and(|(path, _)| self.is_of_open_part(path));
            // Tools and limits of another part would mislead, so its setup is dropped with it.
            let edited = match (&project, &setup) {
                (Some((_, project)), _) => edited_of(project),
                (None, Some((_, setup))) => Edited { setup: setup.clone(), ..Edited::default() },
                // The same file with other roles or in another unit keeps its setup, but for the defaults.
                (None, None) if same => self.state.document.edited_with_defaults(&part.defaults),
                (None, None) => Edited { setup: part.defaults.clone(), ..Edited::default() },
            };
            let own = self.state.document.path.clone().filter(|_| same);
            let path = project.as_ref().map(|(path, _)| path.clone()).or(own);
            let source_now = Some(part.source.clone());
            let on_disk = on_disk.or(self.state.document.on_disk.filter(|_| same));
            self.state.open(part, edited, path);
            self.state.document.on_disk = on_disk;
            let is_moved =
                project.as_ref().is_some_and(|(_, project)| Some(source_of(project)) != source_now);
            if chosen || is_moved {
                self.state.document.mark_unsaved();
            }
            let part = self.state.document.part.as_ref();
            for note in part.map(|part| part.impeller.notes.clone()).unwrap_or_default() {
                let shown = hint_for_dialog(&note);
                let help = if shown == note { "" } else { IN_ROLES_DIALOG };
                self.state.report_problem(Problem::note(shown, help));
            }
            self.view.reset();
            self.hover = None;
            if let Some(pictures) = &mut self.pictures {
                pictures.set_part(mesh);
            }
        }
        if let Some((path, setup)) = setup {
            self.state.report_done(format!("Opened {}", path.display()));
            // Undo brings back what was there.
            self.state.document.step();
            self.state.document.edited.setup = setup;
        }
        if let Some(blank) = blank {
            self.state.report_done(format!("Opened {}", blank.path.display()));
            self.state.document.edited.setup.allowances.blank = BlankShape::File(Arc::new(blank));
            return;
        }
        if let Some((path, read)) = machine {
            return self.take_machine(&path, read);
        }
        let was_flank = project.as_ref().is_some_and(|(_, project)| project.chosen.flank);
        if let Some((path, project)) = project {
            self.take_project(path, &project);
        } else if let Some((path, _)) = self.state.document.part.as_ref().and_then(|part| part.source.file())
            && new_part
        {
            let path = path.to_owned();
            self.note_recent(&path);
            self.find_copy_of_open();
        }
        if let Some(file) = changed_part {
            self.state.report_problem(Problem::new(
                format!("{}: the part changed after the study was run", file.display()),
                "compare the figures of the plan with those of the run, or run the study again",
            ));
        }
        if is_run {
            self.state.look.operation = Operation::Roughing;
        }
        // The first plan of a part starts automatically.
        if new_part || is_run || self.state.results.planned.is_none() {
            self.plan();
        }
        if is_flank_plan || was_flank {
            self.state.look.operation = Operation::Flank;
            self.plan_flank();
        }
    }

    /// Reads or writes a chosen file in the background; `on_faults` of a program.
    pub(in crate::app) fn use_file(
        &mut self,
        ctx: &egui::Context,
        purpose: Purpose,
        path: PathBuf,
        on_faults: OnFaults,
    ) {
        match purpose {
            Purpose::OpenPart | Purpose::OpenProject => self.open_guarded(ctx, path),
            Purpose::LocatePart => self.open_located(path),
            Purpose::SaveProject => self.write_project(path, false),
            Purpose::OpenSetup => self.open_files(None, Some(path)),
            Purpose::CheckProgram => self.check_program(path),
            Purpose::OpenStudy => self.submit_open(OpenTask::Study(path)),
            Purpose::OpenBlank => self.submit_open(OpenTask::Blank(path)),
            Purpose::OpenMachine => self.submit_open(OpenTask::Machine(path)),
            Purpose::OpenLibrary => self.run_guarded(ctx, Pending::OpenLibrary(path)),
            Purpose::SaveLibrary => {
                if let Some(library) = self.library.library() {
                    self.write(WriteTask::Library(path, library.content().clone()));
                }
            }
            Purpose::SaveSetup => {
                self.write(WriteTask::Setup(path, Box::new(self.state.document.edited.setup.clone())));
            }
            Purpose::ExportCl { channels } => {
                if let Some(source) = self.shown_plunges(channels, on_faults) {
                    self.write(WriteTask::Cl(path, source));
                }
            }
            Purpose::ExportFlank { channels } => {
                if let Some(source) = self.flank_source(channels, on_faults) {
                    self.write(WriteTask::Flank(path, source));
                }
            }
            Purpose::ExportNc { operation, .. } => self.export_nc(operation, path, on_faults),
            Purpose::OpenPost => self.take_post(&path),
            Purpose::OpenPostOfCheck => {
                self.state.look.check_control = Some(path.to_string_lossy().into_owned());
            }
            Purpose::ExportSheet { operation } => self.export_sheet(operation, path, on_faults),
            Purpose::SaveAssessment => {
                if let Some(assessed) = self.assessing.known(&self.state) {
                    let assessed = Arc::clone(assessed);
                    self.write(WriteTask::Assessment(path, assessed));
                }
            }
            Purpose::ExportScene { side } => self.export_scene(path, side),
            Purpose::ExportStock { side } => {
                let side = side.unwrap_or(self.state.look.side);
                if let Some(source) = self.state.solid_source(side) {
                    let moment = self.state.stock_moment(&source);
                    self.write(WriteTask::Stock(path, source, moment));
                }
            }
            Purpose::SavePicture => self.export_picture(path),
        }
    }

    pub(in crate::app) fn write(&mut self, task: WriteTask) {
        let kind = task.purpose().kind();
        // What was wrong with the last attempt is said again if it still is.
        self.state.solve(Topic::Writing(kind));
        self.state.notice = None;
        if self.work.write(task) {
            self.state.report_done(format!("The {kind} waits for the export that is being checked"));
        }
    }

    /// Lets work go ahead that the user waits for.
    pub(in crate::app) fn rank_work(&self) {
        let exported = self.postponed.as_ref().and_then(|export| export.purpose.planned_operation());
        self.work.rank(self.state.look.operation, exported);
    }
}

/// Problem message for a panic of a background task.
pub(super) fn panic_problem(topic: Topic, what: &str, message: &str) -> Problem {
    Problem::about(
        topic,
        &format!("{what} failed unexpectedly ({message})"),
        "change the setup, or report this with the part file",
    )
}
