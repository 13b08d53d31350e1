//! Files that leave the window: programs, after a question where something speaks against them, and scenes.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};

use egui::Ui;

use super::background::panic_problem;
use super::replaced::check_replaced;
use crate::app::App;
use crate::app::model::figures::TimedPlan;
use crate::app::model::file_purpose::{Purpose, ending_of};
use crate::app::model::look::{Arrangement, DEFAULT_MACHINE, Operation};
use crate::app::model::planned::{DisplayPlan, Side};
use crate::app::model::post_target::PostTarget;
use crate::app::model::problem::{Problem, Topic, without_markdown};
use crate::app::model::release::{concerns, fault_lines, faulty_values};
use crate::app::model::results::Results;
use crate::app::model::state::ShownPlan;
use crate::app::tasks::documents::SheetTask;
use crate::app::tasks::files::{SceneTask, Unwritten, WriteError, WriteTask, Written};
use crate::app::tasks::programs::{FlankSource, NcTask, OnFaults, PlungeSource, ProgramSource};
use crate::app::views::command::Command;
use crate::app::views::nc_dialog::{NcAnswer, NcQuestion, TargetChoice};
use crate::app::views::picture_dialog::ExportSettings;
use crate::app::views::release::{self, Recalculation, ReleaseAnswer, ReleaseWords, Renewal};
use crate::io::shop_tools::{fusion_remarks, is_fusion_library};
use crate::job::flank::FlankOutcome;
use crate::job::worker::Outcome;
use crate::report::sheet::ProgramFile;
use crate::setup::Setup;
use crate::verify::Fault;

/// Maximum number of remarks on a library that are repeated when it is written.
const MAX_NOTES: usize = 4;

/// A program or library that waits for an answer.
#[derive(Debug)]
pub(in crate::app) struct ReleaseQuestion {
    purpose: Purpose,
    path: PathBuf,
    /// Number of channels of the program.
    channels: usize,
    concerns: Vec<String>,
    words: &'static ReleaseWords,
    /// The plans whose program was judged, if it is about its faults as it is written.
    judged: Option<ExportedPlans>,
    recalculation: Recalculation,
    /// The plans that it was about at first.
    plans: ExportedPlans,
    /// When what it says was replaced, s.
    renewed_at: Option<f64>,
}

/// The plans that there are.
#[derive(Debug, Clone, Default)]
struct ExportedPlans {
    plunges: Weak<DisplayPlan>,
    flank: Weak<FlankOutcome>,
}

impl ExportedPlans {
    fn of(results: &Results) -> Self {
        Self {
            plunges: results.planned.as_ref().map_or_else(Weak::new, Arc::downgrade),
            flank: results.flank.as_ref().map_or_else(Weak::new, Arc::downgrade),
        }
    }

    fn are_same(&self, other: &Self) -> bool {
        self.plunges.ptr_eq(&other.plunges) && self.flank.ptr_eq(&other.flank)
    }
}

/// An export that goes on once the plan follows the setup.
#[derive(Debug)]
pub(in crate::app) struct PostponedExport {
    pub(super) purpose: Purpose,
    path: PathBuf,
    /// The setup that is calculated for it.
    setup: Setup,
}

impl App {
    /// Writes the chosen file; a program with something against it is asked about first.
    pub fn file_chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: PathBuf) {
        if let Err(error) = check_replaced(&self.state, purpose, &path) {
            return self.state.report_problem(Problem::of_writing(purpose, &error));
        }
        let concerns = match purpose {
            Purpose::SaveLibrary => self.library_losses(&path),
            _ => concerns(&self.state, purpose, self.channels_of(purpose)),
        };
        if concerns.is_empty() {
            self.use_file(ctx, purpose, path, OnFaults::Ask);
        } else {
            self.ask_about(purpose, path, concerns);
        }
    }

    fn ask_about(&mut self, purpose: Purpose, path: PathBuf, concerns: Vec<String>) {
        let words = match purpose {
            Purpose::SaveLibrary if is_fusion_library(&path) => &release::EXISTING_LIBRARY,
            Purpose::SaveLibrary => &release::LIBRARY,
            Purpose::ExportSheet { .. } => &release::SHEET,
            Purpose::ExportScene { .. } => &release::SCENE,
            Purpose::ExportStock { .. } => &release::STOCK,
            _ => &release::PROGRAM,
        };
        let channels = self.channels_of(purpose);
        let recalculation = match self.can_change(purpose) {
            true => Recalculation::Offered,
            false => Recalculation::None,
        };
        let (judged, renewed_at, plans) = (None, None, ExportedPlans::of(&self.state.results));
        self.release = Some(ReleaseQuestion {
            purpose,
            path,
            channels,
            concerns,
            words,
            judged,
            recalculation,
            plans,
            renewed_at,
        });
    }

    /// Whether calculating the plan of a file again can change it.
    fn can_change(&self, purpose: Purpose) -> bool {
        match purpose.planned_operation() {
            Some(Operation::Flank) => self.state.flank_is_stale(),
            Some(Operation::Roughing) => {
                let planned = self.state.results.planned.as_ref();
                self.state.out_of_date() || planned.is_some_and(|planned| planned.is_unfinished())
            }
            // No plan is in a tool library.
            Some(Operation::Program) | None => false,
        }
    }

    /// Keeps the open question about the plan that is there now: a calculation may end while it is asked.
    fn renew_question(&mut self, time: f64) {
        let Some(question) = &self.release else { return };
        if question.purpose == Purpose::SaveLibrary || question.judged.is_some() {
            return;
        }
        let now = concerns(&self.state, question.purpose, question.channels);
        let can_change = self.can_change(question.purpose);
        let Some(question) = &mut self.release else { return };
        let was_offered = question.recalculation == Recalculation::Offered;
        if now == question.concerns && can_change == was_offered {
            return;
        }
        question.concerns = now;
        // The button keeps its place.
        question.recalculation = match can_change {
            true => Recalculation::Offered,
            false if was_offered => Recalculation::Done,
            false => question.recalculation,
        };
        question.renewed_at = Some(time);
    }

    /// Number of channels of the program that `purpose` writes.
    fn channels_of(&self, purpose: Purpose) -> usize {
        match purpose {
            Purpose::ExportCl { channels } | Purpose::ExportFlank { channels } => channels,
            Purpose::ExportNc { .. } => self.nc_dialog.question().map_or(1, |question| question.channels),
            Purpose::ExportSheet { operation } => self.exported_programs(operation).0,
            _ => 1,
        }
    }

    /// What the setup sheet of `operation` is for: the number of channels of the program that was exported
    /// last of its plan, and the files with that number.
    fn exported_programs(&self, operation: Operation) -> (usize, Vec<ProgramFile>) {
        let Results { exported, flank, .. } = &self.state.results;
        let found = match operation {
            Operation::Flank => flank.as_ref().map(|outcome| exported.of_flank(outcome)),
            Operation::Roughing | Operation::Program => {
                let shown = self.state.last_whole_plan(self.state.look.side);
                shown.map(|shown| exported.of_plunges(shown.planned, shown.policy))
            }
        };
        found.unwrap_or((1, Vec::new()))
    }

    /// Asks about a program that has faults as it would be written.
    pub(in crate::app) fn ask_about_faults(&mut self, purpose: Purpose, path: PathBuf, faults: &[Fault]) {
        self.ask_about(purpose, path, fault_lines(faults));
        if let Some(question) = &mut self.release {
            question.judged = Some(ExportedPlans::of(&self.state.results));
        }
    }

    /// Handles the end of a file that was to be written.
    pub(super) fn take_written(&mut self, ctx: &egui::Context, end: Outcome<Written, Unwritten>) {
        match end {
            Outcome::Done(written) => {
                self.state.solve(Topic::Writing(written.purpose.kind()));
                self.state.report_done(written.text);
                self.dialogs.note_folder(written.purpose.place(), &written.file);
                if let Some((plan, file)) = written.program {
                    self.state.results.exported.note(plan, file);
                }
                if let Some(project) = written.project {
                    self.note_saved(ctx, project);
                }
                if let Some(library) = written.library {
                    self.note_saved_library(ctx, written.file, library);
                }
            }
            Outcome::Cancelled => self.note_cancelled_writing(),
            Outcome::Failed(Unwritten { purpose, error }) => match error {
                WriteError::Cancelled => self.note_cancelled_writing(),
                WriteError::Faulty { path, faults } => self.ask_about_faults(purpose, path, &faults),
                WriteError::ChangedOnDisk(path) => self.session.changed_on_disk = Some(path),
                WriteError::Failed(error) => {
                    self.state.report_problem(Problem::of_writing(purpose, &error));
                }
            },
            Outcome::Panicked(what) => {
                self.state.report_problem(panic_problem(Topic::Other, "Writing", &what));
            }
        }
    }

    fn note_cancelled_writing(&mut self) {
        if self.work.judge.is_busy() {
            // The next one, which was chosen since, goes on.
            self.state.notice = None;
        } else {
            self.state.report_done("Writing cancelled");
        }
    }

    /// What a file at `path` would not hold of the shop library.
    fn library_losses(&self, path: &Path) -> Vec<String> {
        let is_fusion = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
        let Some(library) = self.library.library().filter(|_| is_fusion) else { return Vec::new() };
        let is_new = !is_fusion_library(path);
        let mut lines = fusion_remarks(library.content(), is_new);
        // What was left out when it was opened is in no file that is written anew.
        let notes = library.content().notes.iter().take(if is_new { MAX_NOTES } else { 0 });
        lines.extend(notes.map(|note| without_markdown(note)));
        lines
    }

    /// Asks about a program, while that is due.
    pub(in crate::app) fn ask_release(&mut self, ui: &Ui) {
        let time = ui.input(|input| input.time);
        self.renew_question(time);
        let plans = ExportedPlans::of(&self.state.results);
        let answer = self.release.as_ref().and_then(|question| {
            let has_new_plan = !question.plans.are_same(&plans);
            let since = question.renewed_at.map(|at| time - at);
            let renewal = since.map(|since_s| Renewal { since_s, has_new_plan });
            let file = question.path.file_name().unwrap_or_default().to_string_lossy();
            let words = (question.words, &*file);
            release::ask(ui, words, &question.concerns, question.recalculation, renewal)
        });
        let Some(answer) = answer else { return };
        let Some(ReleaseQuestion { purpose, path, judged, .. }) = self.release.take() else { return };
        match answer {
            ReleaseAnswer::Recalculate => {
                let is_flank = purpose.planned_operation() == Some(Operation::Flank);
                let command = if is_flank { Command::PlanFlank } else { Command::Plan };
                self.run_command(ui.ctx(), command);
                let setup = self.state.document.edited.setup.clone();
                self.postponed = Some(PostponedExport { purpose, path, setup });
            }
            ReleaseAnswer::Export => {
                // Another plan that took its place meanwhile is judged and asked about by itself.
                let is_judged = judged.is_some_and(|judged| judged.are_same(&plans));
                let on_faults = if is_judged { OnFaults::Write } else { OnFaults::Ask };
                self.use_file(ui.ctx(), purpose, path, on_faults);
            }
            ReleaseAnswer::Cancel => {}
        }
    }

    /// Goes on with an export whose plan was calculated again; it ends if the setup is edited meanwhile, or
    /// if the calculation is cancelled or fails.
    pub(in crate::app) fn go_on_with_export(&mut self, ctx: &egui::Context) {
        let Some(waiting) = &self.postponed else { return };
        let operation = waiting.purpose.planned_operation().unwrap_or(Operation::Roughing);
        let goes_on = waiting.setup == self.state.document.edited.setup;
        if goes_on && self.work.is_due(operation) {
            return;
        }
        let Some(PostponedExport { purpose, path, .. }) = self.postponed.take() else { return };
        let is_new = match operation {
            Operation::Flank => self.state.results.flank.is_some() && !self.state.flank_is_stale(),
            _ => {
                let planned = self.state.results.planned.as_ref();
                !self.state.out_of_date() && planned.is_some_and(|planned| !planned.is_unfinished())
            }
        };
        if goes_on && is_new {
            self.file_chosen(ctx, purpose, path);
        } else {
            let why = if goes_on { "no finished plan" } else { "the setup was edited meanwhile" };
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            self.state.report_refusal(format!("{file} is not written: {why}"));
        }
    }

    /// Settings of saved pictures.
    pub fn export_settings_mut(&mut self) -> &mut ExportSettings {
        &mut self.export
    }

    /// Asks how many channels a program is for, while that is due.
    pub(in crate::app) fn ask_channels(&mut self, ui: &Ui) {
        let operation = self.exported_operation().unwrap_or(Operation::Roughing);
        let plan = match operation {
            Operation::Flank => self.state.results.flank.clone().map(TimedPlan::Flank),
            Operation::Roughing | Operation::Program => {
                self.state.last_whole_plan(self.state.look.side).map(|shown| {
                    TimedPlan::Plunges(Box::new(shown.planned.result(shown.policy).summary.clone()))
                })
            }
        };
        let order = &mut self.state.document.edited.setup.channels;
        if let Some(channels) = self.channels_dialog.show(ui, operation, plan.as_ref(), order) {
            self.ask_for_cl_file(ui.ctx(), channels);
        }
    }

    /// The shown plunge plan as a program of that number of channels.
    pub(in crate::app) fn shown_plunges(&self, channels: usize, on_faults: OnFaults) -> Option<PlungeSource> {
        let ShownPlan { planned, policy } = self.state.last_whole_plan(self.state.look.side)?;
        Some(PlungeSource { planned: Arc::clone(planned), policy, channels, on_faults })
    }

    /// The flank plan as a program of that number of channels, in the order of the setup.
    pub(in crate::app) fn flank_source(&self, channels: usize, on_faults: OnFaults) -> Option<FlankSource> {
        let outcome = self.state.results.flank.clone()?;
        let order = self.state.document.edited.setup.channels;
        let judged = Arc::clone(&self.judged_flank);
        Some(FlankSource { outcome, channels, order, judged, on_faults })
    }

    /// The plan of `operation` as a program of that number of channels.
    fn program_source(
        &self,
        operation: Operation,
        channels: usize,
        on_faults: OnFaults,
    ) -> Option<ProgramSource> {
        match operation {
            Operation::Flank => self.flank_source(channels, on_faults).map(ProgramSource::Flank),
            Operation::Roughing | Operation::Program => {
                self.shown_plunges(channels, on_faults).map(ProgramSource::Plunges)
            }
        }
    }

    /// Operations that have a plan to write.
    pub(in crate::app) fn planned_operations(&self) -> Vec<Operation> {
        let roughing = self.state.last_whole_plan(self.state.look.side).map(|_| Operation::Roughing);
        let flank = self.state.results.flank.as_ref().map(|_| Operation::Flank);
        roughing.into_iter().chain(flank).collect()
    }

    /// Why the plan of the selected operation cannot be exported; `None` where it can, and for other
    /// commands.
    pub(in crate::app) fn why_not_exported(&self, command: Command) -> Option<String> {
        use Command as C;
        if !matches!(command, C::ExportCl | C::ExportClSome | C::ExportClAll | C::ExportSheet) {
            return None;
        }
        let operation = self.state.look.operation;
        if self.state.document.part.is_none() {
            Some("No plan to export: open a part first".to_owned())
        } else if operation == Operation::Program {
            Some("A checked program is a file already: select the operation whose plan to export".to_owned())
        } else if self.planned_operations().contains(&operation) {
            None
        } else if self.work.is_calculating(operation) {
            Some(format!("{} is still being calculated: export it when that is done", operation.label()))
        } else {
            Some(format!("{} has no plan to export yet: calculate it first", operation.label()))
        }
    }

    /// The operation that is exported: the selected one, or else the first that has a plan.
    pub(in crate::app) fn exported_operation(&self) -> Option<Operation> {
        let operations = self.planned_operations();
        let selected = Some(self.state.look.operation).filter(|selected| operations.contains(selected));
        selected.or(operations.first().copied())
    }

    /// Writes the setup sheet of the plan of `operation`, which names the programs that were written of it.
    pub(in crate::app) fn export_sheet(&mut self, operation: Operation, path: PathBuf, on_faults: OnFaults) {
        let (channels, files) = self.exported_programs(operation);
        let Some(source) = self.program_source(operation, channels, on_faults) else { return };
        let remarks = faulty_values(&self.state).map(|words| format!("{words}.")).into_iter().collect();
        self.write(WriteTask::Sheet(path, SheetTask { source, files, remarks }));
    }

    /// Asks where an NC program is to run: on the machine of the setup, or on the one that was asked for
    /// last.
    pub(in crate::app) fn ask_for_nc_target(&mut self) {
        let Some(part) = self.state.document.part.as_ref().map(|part| part.hash.clone()) else { return };
        let operations = self.planned_operations();
        let last = self.nc_dialog.question().cloned();
        let machine = self.state.document.edited.setup.machine.file.clone();
        let of_setup = machine.as_deref().unwrap_or(DEFAULT_MACHINE);
        let own = match PostTarget::of_machine(of_setup) {
            Ok(own) => own,
            Err(error) => return self.state.report_problem(Problem::from(&error)),
        };
        let mut target = last.as_ref().map_or(own, |last| last.target.clone());
        // What was asked for last was chosen, or seen at least.
        let is_example = machine.is_none() && last.as_ref().is_none_or(|last| last.is_example);
        let other = machine.filter(|machine| *machine != target.machine);
        let Some(operation) = self.exported_operation() else { return };
        let channel_count = self.channel_count();
        // The machine stays from part to part; what the program is a part of does not.
        let last = last.filter(|last| last.part == part);
        target.is_subprogram &= last.is_some();
        let channels = last.map_or(self.state.look.shown_channels, |last| last.channels);
        let channels = channels.clamp(1, channel_count);
        let machines = self.state.machines.clone();
        self.nc_dialog.open(NcQuestion {
            operations,
            operation,
            channels,
            channel_count,
            target,
            machines,
            is_example,
            part,
        });
        // What was chosen for another machine stays.
        if let Some(machine) = other {
            self.nc_dialog.take(TargetChoice::Machine(machine));
        }
    }

    /// Draws the question where an NC program is to run, while that is due.
    pub(in crate::app) fn ask_nc_target(&mut self, ui: &Ui) {
        match self.nc_dialog.show(ui, &mut self.state.document.edited.setup.channels) {
            Some(NcAnswer::Save) => {
                let Some(question) = self.nc_dialog.question() else { return };
                let (operation, dialect) = (question.operation, question.target.dialect);
                let purpose = Purpose::ExportNc { operation, dialect };
                let ending = ending_of(dialect, question.target.is_subprogram);
                // Main program and subprogram are two files. Siemens takes no hyphens in their names.
                let of_kind = if question.target.is_subprogram { "_subprogram" } else { "" };
                let ending = format!("{of_kind}.{ending}");
                let name = match operation {
                    Operation::Flank => self.suggest_flank_name(question.channels, &ending),
                    _ => self.suggest_plunge_name(question.channels, &ending),
                };
                self.dialogs.open_dialog(ui.ctx(), purpose, name);
            }
            Some(NcAnswer::OpenPost) => {
                self.dialogs.open_dialog(ui.ctx(), Purpose::OpenPost, String::new());
            }
            None => {}
        }
    }

    /// Goes on with the question where an NC program is to run, with the post that was chosen for it.
    pub(in crate::app) fn take_post(&mut self, path: &Path) {
        self.nc_dialog.take_post(&path.to_string_lossy());
    }

    /// Writes the plan of `operation` as NC code for the machine that was chosen for it.
    pub(in crate::app) fn export_nc(&mut self, operation: Operation, path: PathBuf, on_faults: OnFaults) {
        let Some(question) = self.nc_dialog.question() else { return };
        let Some(source) = self.program_source(operation, question.channels, on_faults) else { return };
        let target = question.target.clone();
        // What is written is read back for the same machine.
        self.state.look.check_machine = Some(target.machine.clone());
        self.state.look.check_control = Some(target.control.clone());
        self.write(WriteTask::Nc(path, NcTask { source, target }));
    }

    /// Asks where to write the scene (`stock` false) or the stock. Where both plans are shown, title and
    /// proposed name say which one it is of: the active one.
    pub(super) fn ask_for_model(&mut self, ctx: &egui::Context, stock: bool) {
        let look = &self.state.look;
        let side = (look.shown_arrangement() != Arrangement::One).then_some(look.side);
        let of_side = side.map_or(String::new(), |side| format!("-{}", side.label().to_lowercase()));
        let (purpose, name) = match stock {
            true => (Purpose::ExportStock { side }, format!("stock{of_side}.stl")),
            false => (Purpose::ExportScene { side }, format!("scene{of_side}.glb")),
        };
        self.dialogs.open_dialog(ctx, purpose, self.suggest_file_name(&name));
    }

    /// Writes the part as a glTF scene, with the plan of a side; `None`: of the active one.
    pub(in crate::app) fn export_scene(&mut self, path: PathBuf, side: Option<Side>) {
        let Some(part) = &self.state.document.part else { return };
        let shown = self.state.last_whole_plan(side.unwrap_or(self.state.look.side));
        let planned = shown.map(|shown| (shown.planned.clone(), shown.policy));
        let scene = SceneTask { part: part.impeller.clone(), planned, range: self.state.range() };
        self.write(WriteTask::Scene(path, scene));
    }
}
