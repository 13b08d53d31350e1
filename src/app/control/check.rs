//! Checking of programs from anywhere.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::App;
use crate::app::model::checked::{CheckRequest, CheckedProgram};
use crate::app::model::file_purpose::FilePlace;
use crate::app::model::look::Operation;
use crate::app::model::problem::{Problem, Topic};
use crate::app::tasks::check::CheckError;
use crate::app::tasks::program_watch::LOOK_EVERY;
use crate::job::worker::Outcome;

impl App {
    /// Checks a program against the open part.
    pub(in crate::app) fn check_program(&mut self, path: PathBuf) {
        self.dialogs.note_folder(FilePlace::Work, &path);
        match self.state.check_request_of(path) {
            Some(request) => {
                self.state.look.operation = Operation::Program;
                self.submit_check(request);
            }
            None => self.state.report_problem(Problem::new(
                "A program is checked against a part, and none is open",
                "open the part, then the program",
            )),
        }
    }

    /// Checks the last program again.
    pub(in crate::app) fn check_again(&mut self) {
        if let Some(request) = self.check_of_last() {
            self.submit_check(request);
        }
    }

    /// The check of the program that was asked for last; of the one that is shown, where that one was not
    /// read and the message about it is dismissed.
    fn check_of_last(&self) -> Option<CheckRequest> {
        let is_refused = || self.state.problems.iter().any(|problem| problem.topic == Topic::Program);
        let is_meant = self.work.checker.is_busy() || self.state.results.checked.is_none() || is_refused();
        let asked = self.work.asked_check.as_ref().filter(|_| is_meant);
        let path = asked.map(|asked| asked.path.clone());
        path.and_then(|path| self.state.check_request_of(path)).or(self.state.check_request())
    }

    fn submit_check(&mut self, request: CheckRequest) {
        self.state.notice = None;
        self.work.asked_check = Some(request.clone());
        self.work.checker.submit(request);
    }

    /// Checks a program again that was checked against an older setup, or that could not be read with another
    /// control or machine, if auto-update is on. As flank plans, only once the mouse is released.
    pub(in crate::app) fn check_edits(&mut self, held: bool) {
        let follows = self.state.auto_update && !held && self.state.look.operation == Operation::Program;
        let is_known = self.state.results.checked.is_some();
        if !follows || is_known && !self.state.program_is_stale() {
            return;
        }
        // While another program is being read, or was not read, it is that one, and not the one that is still
        // shown.
        let now = self.check_of_last();
        let is_asked = self.work.asked_check.as_ref().zip(now.as_ref()).is_some_and(|(a, b)| a.is_same(b));
        if let Some(request) = now.filter(|_| !is_asked) {
            self.submit_check(request);
        }
    }

    /// Handles the result of a check.
    pub(in crate::app) fn take_checked(&mut self, outcome: Outcome<CheckedProgram, CheckError>) {
        if let (Outcome::Failed(CheckError::Input(_)) | Outcome::Panicked(_), Some(asked)) =
            (&outcome, &self.work.asked_check)
        {
            self.state.note_failed_check(&asked.path);
        }
        match outcome {
            Outcome::Done(checked) => {
                self.state.solve(Topic::Opening);
                let part = self.state.document.part.as_ref();
                if part.is_some_and(|part| Arc::ptr_eq(&part.impeller, &checked.request.part)) {
                    self.state.take_checked(checked);
                }
            }
            Outcome::Cancelled | Outcome::Failed(CheckError::Cancelled) => {
                self.state.report_done("Check cancelled");
            }
            Outcome::Failed(CheckError::Input(error)) => {
                let problem = Problem::from(&error);
                self.state.report_problem(Problem { topic: Topic::Program, ..problem });
            }
            Outcome::Panicked(what) => self.state.report_problem(Problem::about(
                Topic::Program,
                &format!("Check failed unexpectedly ({what})"),
                "report this with part and program",
            )),
        }
    }

    /// Looks now and then whether the file of the checked program was written again.
    pub(in crate::app) fn watch_program(&mut self, ctx: &egui::Context) {
        let checked = self.state.results.checked.as_deref();
        if checked.is_some() {
            ctx.request_repaint_after(LOOK_EVERY);
        }
        let time = ctx.input(|input| input.time);
        self.state.results.program_file = self.program_watch.follow(checked, time);
    }

    /// Closes the checked program.
    pub(in crate::app) fn close_program(&mut self) {
        self.work.checker.cancel();
        self.work.asked_check = None;
        (self.state.results.checked, self.state.results.recheck_failed) = (None, false);
        self.state.look.operation = Operation::Roughing;
        (self.state.look.finding, self.state.look.program_cut) = (None, None);
        self.state.look.playing = None;
    }
}
