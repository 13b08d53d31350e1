//! The checked program, and its selected fault.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::AppState;
use crate::app::model::checked::{CheckRequest, CheckedProgram, FileChange, ProgramFinding, StaleCheck};
use crate::app::model::look::{DEFAULT_MACHINE, Operation, REVEAL};
use crate::app::model::problem::Topic;

impl AppState {
    /// Stores a checked program and shows it, with its first fault selected.
    pub fn take_checked(&mut self, checked: CheckedProgram) {
        self.look.operation = Operation::Program;
        self.look.finding = None;
        // The same place as before where the program was checked again.
        let is_same = |known: &Arc<CheckedProgram>| known.request.path == checked.request.path;
        let cut = self.look.program_cut.filter(|_| self.results.checked.as_ref().is_some_and(is_same));
        self.look.program_cut = cut.map(|cut| cut.min(checked.program.moves.len()));
        self.solve(Topic::Program);
        self.notice = None;
        self.results.checked = Some(Arc::new(checked));
        self.results.recheck_failed = false;
    }

    /// The check of the program of the last check against the present setup.
    pub fn check_request(&self) -> Option<CheckRequest> {
        let checked = self.results.checked.as_ref()?;
        self.check_request_of(checked.request.path.clone())
    }

    /// The check of a program against the present setup; `None` without a part.
    pub fn check_request_of(&self, path: PathBuf) -> Option<CheckRequest> {
        let part = Arc::clone(&self.document.part.as_ref()?.impeller);
        let (machine, control) = (self.check_machine().to_owned(), self.look.check_control.clone());
        Some(CheckRequest { path, machine, control, part, setup: self.document.edited.setup.clone() })
    }

    /// Machine that NC code is read for: the one that was chosen or exported for, else that of the setup.
    pub fn check_machine(&self) -> &str {
        let of_setup = self.document.edited.setup.machine.file.as_deref();
        self.look.check_machine.as_deref().or(of_setup).unwrap_or(DEFAULT_MACHINE)
    }

    /// Notes that a check of the program at `path` failed.
    pub fn note_failed_check(&mut self, path: &Path) {
        let is_shown = self.results.checked.as_ref().is_some_and(|known| known.request.path == path);
        self.results.recheck_failed |= is_shown;
    }

    /// Whether the shown check may not hold any more; see [`Self::stale_check`].
    pub fn program_is_stale(&self) -> bool {
        self.stale_check().is_some()
    }

    /// Why the shown check may not hold any more: the setup was edited or the file written after it, or the
    /// program could not be checked again.
    pub fn stale_check(&self) -> Option<StaleCheck> {
        match self.results.program_file {
            _ if self.results.recheck_failed => Some(StaleCheck::NotChecked),
            FileChange::None => self.setup_differs_from_check().then_some(StaleCheck::SetupEdited),
            change => Some(StaleCheck::File(change)),
        }
    }

    /// Whether the setup was edited after the program was checked.
    fn setup_differs_from_check(&self) -> bool {
        let checked = self.results.checked.as_ref().zip(self.check_request());
        checked.is_some_and(|(checked, now)| {
            // APT is not posted for a machine: it is read alike whatever that is.
            let own = checked.request.clone();
            let now = match checked.on_machine {
                Some(_) => now,
                None => CheckRequest { machine: own.machine, control: own.control, ..now },
            };
            !checked.request.is_same(&now)
        })
    }

    /// The checked program, while it is shown.
    pub fn shown_program(&self) -> Option<&Arc<CheckedProgram>> {
        self.results.checked.as_ref().filter(|_| self.look.operation == Operation::Program)
    }

    /// The checked program whose moves are drawn: they would hide the stock that they leave.
    pub fn drawn_program(&self) -> Option<&Arc<CheckedProgram>> {
        self.shown_program().filter(|_| !self.look.layers.stock)
    }

    /// The selected fault of the shown program.
    pub fn selected_finding(&self) -> Option<&ProgramFinding> {
        self.shown_program()?.findings.get(self.look.finding?)
    }

    /// Selects a fault of the shown program, and zooms to it; the timeline goes to its place.
    pub fn select_finding(&mut self, index: Option<usize>) {
        self.look.finding = index;
        self.look.fly = index.is_some();
        self.look.reveal_finding = if index.is_some() { REVEAL } else { 0 };
        if let Some(first) = self.selected_finding().and_then(|finding| finding.first_move) {
            self.look.program_cut = Some(first + 1);
        }
    }

    /// Selects the fault `step` after the selected one, with wrap-around if `wraps`.
    pub(super) fn select_next_finding(&mut self, step: isize, wraps: bool) {
        let count = self.shown_program().map_or(0, |checked| checked.findings.len());
        let Some(last) = count.checked_sub(1) else { return };
        let next = match self.look.finding {
            None => {
                if step < 0 {
                    last
                } else {
                    0
                }
            }
            Some(now) if wraps => now.wrapping_add_signed(step + count as isize) % count,
            Some(now) => now.saturating_add_signed(step).min(last),
        };
        self.select_finding(Some(next));
    }
}
