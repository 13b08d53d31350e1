//! The background threads of the window, with their latest requests.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Repaint;
use super::check::CheckError;
use super::engine::{Engine, PlanTask};
use super::files::{self, Unwritten, WriteTask, Written};
use super::home::LibraryCopy;
use super::open_task::OpenTask;
use super::opening::{Opened, open};
use crate::app::model::checked::{CheckRequest, CheckedProgram};
use crate::app::model::look::Operation;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::preview::PreviewSlot;
use crate::io::InputError;
use crate::job::JobError;
use crate::job::flank::{FlankOutcome, FlankRequest};
use crate::job::worker::{Outcome, Worker};
use crate::monitor::{Monitor, Precedence};
use crate::setup::Setup;

/// The background threads.
pub(in crate::app) struct Work {
    pub opener: Worker<OpenTask, Opened, InputError>,
    pub planner: Worker<PlanTask, DisplayPlan, JobError>,
    pub flanker: Worker<FlankRequest, FlankOutcome, JobError>,
    pub checker: Worker<CheckRequest, CheckedProgram, CheckError>,
    pub writer: Worker<WriteTask, Written, Unwritten>,
    /// Writes what is checked first; see [`WriteTask::is_checked_first`].
    pub judge: Worker<WriteTask, Written, Unwritten>,
    /// What waits for that, in turn: a worker knows one request.
    pub to_judge: VecDeque<WriteTask>,
    /// Other files that wait to be written, in turn.
    pub to_write: VecDeque<WriteTask>,
    /// Writes recovery copies of the tool library.
    pub copier: Worker<LibraryCopy, (), InputError>,
    /// What goes ahead of what.
    pub ranks: Ranks,
    /// Slot through which the planner passes its preview.
    pub preview: PreviewSlot,
    /// The last request to the planner.
    pub asked: Option<PlanKey>,
    /// Setup of the last request to the flank planner.
    pub asked_flank: Option<Setup>,
    /// The last request to the checker.
    pub asked_check: Option<CheckRequest>,
    /// Number of the planner's last task.
    pub tasks: u64,
    /// When it was submitted.
    pub submitted: Option<Instant>,
}

/// What goes ahead of what: all of it shares the cores. What goes behind waits where it is.
pub(in crate::app) struct Ranks {
    /// The curve of time against stock.
    pub curve: Precedence,
    planner: Precedence,
    flanker: Precedence,
    checker: Precedence,
}

impl Ranks {
    /// What is written in a moment.
    const WRITING: u8 = 0;
    /// Programs that are checked before they are written, and the calculations that the user looks at.
    const WANTED: u8 = 1;
    /// The check of the program that the user looks at.
    const CHECK: u8 = 2;
    /// What nobody looks at.
    const BESIDE: u8 = 3;

    /// Ranks the calculations: those of the selected operation go ahead, and of one that an export waits for.
    fn set(&self, selected: Operation, exported: Option<Operation>) {
        let wanted = |operation| operation == selected || Some(operation) == exported;
        for (work, operation, rank) in [
            (&self.planner, Operation::Roughing, Self::WANTED),
            (&self.flanker, Operation::Flank, Self::WANTED),
            (&self.checker, Operation::Program, Self::CHECK),
        ] {
            work.set_rank(if wanted(operation) { rank } else { Self::BESIDE });
        }
        self.curve.set_rank(Self::BESIDE);
    }
}

/// Interval at which the progress display is updated.
pub(in crate::app) const PROGRESS_EVERY: Duration = Duration::from_millis(60);

/// Time within which a superseded task may still end before the next one starts.
const ENDS_SOON: Duration = Duration::from_millis(400);

impl Work {
    /// Starts the threads; each finished task repaints the window.
    pub(in crate::app) fn new(engine: &Engine, repaint: &Repaint) -> Self {
        let repaint = || {
            let repaint = Arc::clone(repaint);
            move || repaint()
        };
        let [to_open, to_plan, to_flank, to_check] = std::array::from_fn(|_| engine.clone());
        let preview = PreviewSlot::default();
        let plan = {
            let (slot, notify) = (preview.clone(), repaint());
            move |task: &PlanTask, monitor: &Monitor| to_plan.planned(task, monitor, &slot, &notify)
        };
        let [writes, judges, curve, plans, flanks, checks] = Precedence::of_each();
        writes.set_rank(Ranks::WRITING);
        judges.set_rank(Ranks::WANTED);
        let ranks = Ranks { curve, planner: plans.clone(), flanker: flanks.clone(), checker: checks.clone() };
        ranks.set(Operation::Roughing, None);
        Self {
            opener: Worker::new("open", move |task, monitor| open(&to_open, task, monitor), repaint()),
            planner: Worker::ranked("plan", plans, plan, repaint()),
            flanker: Worker::ranked(
                "flank",
                flanks,
                move |request, monitor| (to_flank.flank)(request, monitor),
                repaint(),
            ),
            checker: Worker::ranked(
                "check",
                checks,
                move |request, monitor| (to_check.check)(request, monitor),
                repaint(),
            ),
            writer: Worker::ranked("write", writes, files::write, repaint()),
            copier: Worker::new("copy", |copy: &LibraryCopy, _| copy.write(), repaint()),
            judge: Worker::ranked("judge", judges, files::write, repaint()),
            to_judge: VecDeque::new(),
            to_write: VecDeque::new(),
            ranks,
            preview,
            asked: None,
            asked_flank: None,
            asked_check: None,
            tasks: 0,
            submitted: None,
        }
    }

    /// Cancels planning and drops the results.
    pub(in crate::app) fn planner_cancel(&mut self) {
        self.planner.cancel();
        let _ = self.planner.take_outcome();
        self.flanker.cancel();
        let _ = self.flanker.take_outcome();
        self.checker.cancel();
        let _ = self.checker.take_outcome();
        self.asked = None;
        self.asked_flank = None;
        self.asked_check = None;
    }

    /// Whether the planner's task is worth waiting for while edits go on: as far as its progress tells, it
    /// ends soon.
    pub(in crate::app) fn plan_ends_soon(&self) -> bool {
        let Some((fraction, submitted)) = self.planner.progress().zip(self.submitted) else { return false };
        fraction > 0.0 && submitted.elapsed().mul_f64((1.0 - fraction) / fraction) <= ENDS_SOON
    }

    /// Whether the planner is running.
    pub(in crate::app) fn is_planning(&self) -> bool {
        self.planner.is_busy()
    }

    /// Whether an operation is being calculated; several may be at once.
    pub(in crate::app) fn is_calculating(&self, operation: Operation) -> bool {
        match operation {
            Operation::Roughing => self.planner.is_busy(),
            Operation::Flank => self.flanker.is_busy(),
            Operation::Program => self.checker.is_busy(),
        }
    }

    /// Whether the calculation of an operation waits for what goes ahead of it.
    pub(in crate::app) fn is_held(&self, operation: Operation) -> bool {
        match operation {
            Operation::Roughing => self.planner.is_held(),
            Operation::Flank => self.flanker.is_held(),
            Operation::Program => self.checker.is_held(),
        }
    }

    /// What becomes of an operation that is being calculated, in a word.
    pub(in crate::app) fn words_while_calculating(&self, operation: Operation) -> Option<&'static str> {
        let words = match operation {
            _ if self.is_held(operation) => "waiting…",
            Operation::Program => "checking…",
            Operation::Roughing | Operation::Flank => "calculating…",
        };
        self.is_calculating(operation).then_some(words)
    }

    /// Ranks the calculations by the selected operation, and one that an export waits for.
    pub(in crate::app) fn rank(&self, selected: Operation, exported: Option<Operation>) {
        self.ranks.set(selected, exported);
    }

    /// Whether a plan of an operation is calculated, or was and is not taken yet.
    pub(in crate::app) fn is_due(&self, operation: Operation) -> bool {
        self.is_calculating(operation)
            || match operation {
                Operation::Roughing => self.planner.has_outcome(),
                Operation::Flank => self.flanker.has_outcome(),
                Operation::Program => self.checker.has_outcome(),
            }
    }

    /// Name and progress (0…1) of the running task; of several, that of the selected operation, unless that
    /// waits for others, which go on.
    pub(in crate::app) fn running(&self, selected: Operation) -> Option<(&'static str, f64)> {
        let opening = self.opener.progress().map(|fraction| ("Opening", fraction));
        let what = if self.planner.is_stopping() { "Checking" } else { "Calculating" };
        let calculating = |operation| match operation {
            Operation::Roughing => self.planner.progress().map(|fraction| (what, fraction)),
            Operation::Flank => self.flanker.progress().map(|fraction| ("Calculating flank", fraction)),
            Operation::Program => self.checker.progress().map(|fraction| ("Checking program", fraction)),
        };
        let goes_on = Some(selected).filter(|&operation| !self.is_held(operation));
        let writing = || self.writer.progress().map(|fraction| ("Writing", fraction));
        let judging = || self.judge.progress().map(|fraction| ("Checking export", fraction));
        let calculated = opening.or_else(|| goes_on.and_then(calculating));
        calculated
            .or_else(judging)
            .or_else(writing)
            .or_else(|| std::iter::once(selected).chain(Operation::ALL).find_map(calculating))
    }

    /// Writes a file. It waits for those before it: none is lost, and the end of each is reported. Returns
    /// whether there is one that has to be checked first.
    pub(in crate::app) fn write(&mut self, task: WriteTask) -> bool {
        let is_checked = task.is_checked_first();
        let (worker, waiting) = match is_checked {
            true => (&self.judge, &mut self.to_judge),
            false => (&self.writer, &mut self.to_write),
        };
        let waits = worker.is_busy() || worker.has_outcome();
        if waits {
            waiting.push_back(task);
        } else {
            worker.submit(task);
        }
        waits && is_checked
    }

    /// What came of files that were to be written.
    pub(in crate::app) fn take_written(&mut self) -> Vec<Outcome<Written, Unwritten>> {
        let workers = [(&self.judge, &mut self.to_judge), (&self.writer, &mut self.to_write)];
        let ended = workers.into_iter().filter_map(|(worker, waiting)| {
            let (_, outcome) = worker.take_outcome()?;
            if let Some(next) = waiting.pop_front() {
                worker.submit(next);
            }
            Some(outcome)
        });
        ended.collect()
    }

    /// Whether there is anything to cancel: what is written in a moment is not.
    pub(in crate::app) fn can_cancel(&self) -> bool {
        self.opener.is_busy()
            || self.judge.is_busy()
            || Operation::ALL.into_iter().any(|operation| self.is_calculating(operation))
    }

    /// Cancels programs that are judged before they are written.
    pub(in crate::app) fn cancel_judging(&mut self) {
        self.to_judge.clear();
        self.judge.cancel();
    }
}

/// A request to the planner.
pub(in crate::app) struct PlanKey {
    pub setup: Setup,
    pub compare: bool,
    pub draft: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_in_a_moment_is_not_cancelled() {
        let folder = tempfile::tempdir().expect("a folder");
        let repaint: Repaint = Arc::new(|| ());
        let mut work = Work::new(&Engine::default(), &repaint);
        let (side, path) = (3000, folder.path().join("large.png"));
        let pixels = vec![7; 4 * (side * side) as usize];
        assert!(!work.write(WriteTask::Picture(path, side, side, pixels)), "nothing is before it");
        let running = work.running(Operation::Roughing).map(|(name, _)| name);
        assert_eq!((running, work.can_cancel()), (Some("Writing"), false));
    }
}
