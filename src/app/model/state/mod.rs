//! The window's state: the document, the results and the look, with the rules that connect them. No drawing.

mod channels;
mod program;
mod selection;
mod solid;
mod table;
mod timeline;

use std::path::PathBuf;
use std::sync::Arc;

use crate::drawing::flank::{FlankColours, wall_scale_end};
use crate::job::flank::FlankOutcome;
use crate::plunge::Position;
use crate::report::words::missed_goal;
use crate::setup::{AxisPolicy, Setup};

use crate::app::model::document::{Document, Edited, OpenPart};
use crate::app::model::field_faults::{FaultyField, FieldFault, ReplacedValue};
use crate::app::model::flank_run::FlankRun;
use crate::app::model::look::{Arrangement, Look, Operation};
use crate::app::model::machine::{AxisDemand, ProgramOnMachine};
use crate::app::model::machine_list::MachineList;
use crate::app::model::part_source::PartSource;
use crate::app::model::planned::{DisplayPlan, Side};
use crate::app::model::preview::PreviewCutters;
use crate::app::model::problem::{Problem, Topic};
use crate::app::model::results::Results;
use crate::app::model::shown_channels::ShownChannels;
use crate::plunge::inspect::CutPlane;
use selection::KnownSelection;
pub use timeline::PLAY_RATE;

pub use crate::app::model::boundary::Boundary;
pub use crate::app::model::planned::ShownPlan;

/// Kind of a status bar message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Something was done.
    Done,
    /// Something failed; the text says what to do.
    Fault,
    /// What was typed is not taken, and why.
    Refusal,
}

/// A message of the status bar.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Kind of the message.
    pub tone: Tone,
    /// One line.
    pub text: String,
}

/// A recovery copy of a session that ended without closing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoveryCopy {
    /// Its file.
    pub path: PathBuf,
    /// Name of its project, or else its part.
    pub name: String,
    /// The same, and when it was changed last.
    pub title: String,
    /// File of the project; `None` where that was never saved.
    pub project: Option<PathBuf>,
    /// File of its part; `None` for a sample, or where the copy cannot be read.
    pub part: Option<PathBuf>,
}

/// The state of the window, apart from drawing.
pub struct AppState {
    /// What is edited.
    pub document: Document,
    /// What was computed.
    pub results: Results,
    /// How it is displayed.
    pub look: Look,
    /// The channels of the shown plan that are shown, if there is more than one; see
    /// [`Self::follow_channels`].
    channels: Option<ShownChannels>,
    /// The selection as it was followed last; see [`Self::follow_selection`].
    known_selection: Option<KnownSelection>,
    /// Whether all policies are planned, for comparison.
    pub compare: bool,
    /// Whether every edit is planned at once.
    pub auto_update: bool,
    /// Problems not dismissed yet, oldest first.
    pub problems: Vec<Problem>,
    /// Recovery copies of sessions that ended without closing.
    pub recoverable: Vec<RecoveryCopy>,
    /// Machine files that setups of this session name.
    pub machines: MachineList,
    /// Recently opened projects and parts, latest first.
    pub recents: Vec<PathBuf>,
    /// Latest message.
    pub notice: Option<Notice>,
    /// Part that is being opened.
    pub opening: Option<PartSource>,
}

/// Maximum number of problems kept.
const MAX_PROBLEMS: usize = 5;

impl Default for AppState {
    fn default() -> Self {
        Self {
            document: Document::default(),
            results: Results::default(),
            look: Look::default(),
            channels: None,
            known_selection: None,
            compare: false,
            auto_update: true,
            problems: Vec::new(),
            recoverable: Vec::new(),
            machines: MachineList::default(),
            recents: Vec::new(),
            notice: None,
            opening: None,
        }
    }
}

impl AppState {
    /// Whether the setup was edited after the last plan was requested.
    pub fn out_of_date(&self) -> bool {
        self.results.planned.as_ref().is_some_and(|planned| !planned.is_of(&self.document.edited.setup))
    }

    /// Whether a plan that was asked for with `asked` is one of the setup as it stands.
    pub fn is_current(&self, asked: &Setup) -> bool {
        let now = &self.document.edited.setup;
        let is_answered =
            |planned: &Arc<DisplayPlan>| planned.setup.equals_except_flank(asked) && planned.is_of(now);
        asked.equals_except_flank(now) || self.results.planned.as_ref().is_some_and(is_answered)
    }

    /// What keeps the last plan from the goal of the setup; `None` where it meets it, or is out of date.
    pub fn missed_goal(&self) -> Option<String> {
        let planned = self.results.planned.as_ref().filter(|_| !self.out_of_date())?;
        let text = missed_goal(&planned.outcome, |mm| self.look.units.length(mm, 2))?;
        Some(text.replacen("goal", "Goal", 1))
    }

    /// Replaces the open part and its document; results of the previous part are dropped.
    pub fn open(&mut self, part: OpenPart, edited: Edited, path: Option<PathBuf>) {
        self.document.begin(part, edited, path);
        self.results = Results::default();
        self.look.begin();
        self.known_selection = None;
        self.problems.clear();
        self.notice = None;
    }

    /// Closes the open part.
    pub fn close(&mut self) {
        self.document = Document::default();
        self.results = Results::default();
        self.look.begin();
        self.known_selection = None;
        self.problems.clear();
        self.notice = None;
    }

    /// Stores a plan, in which the selection is followed. An unfinished plan does not
    /// replace a finished one of the same setup.
    pub fn take_plan(&mut self, planned: DisplayPlan) {
        let unfinished = planned.is_unfinished();
        let has_better = |known: &Arc<DisplayPlan>| {
            !known.is_unfinished() && known.setup.equals_except_flank(&planned.setup)
        };
        if unfinished && self.results.planned.as_ref().is_some_and(has_better) {
            self.plan_cancelled();
            return;
        }
        self.follow_selection();
        self.results.take(planned, self.look.units);
        self.keep_within_plan();
        self.follow_reordered();
        self.solve(Topic::Plan);
        self.solve(Topic::Stock);
        // One that was not taken is past.
        if self.document.edited.setup.machine.file.is_none() {
            self.solve(Topic::Machine);
        }
        self.notice = None;
        let fitted = self.results.planned.as_ref().map(|planned| planned.range);
        // Scales that follow every plan would give one colour another meaning in each.
        if !unfinished && self.look.range.is_none() {
            self.look.range = fitted;
        }
        if let Some(change) = self.results.tool_change.clone() {
            self.report_done(change);
        }
        if unfinished {
            self.report_done("Calculation cancelled: the best so far, not finished; recalculate (F5)");
        }
    }

    /// Reports that planning was cancelled without a new plan.
    pub fn plan_cancelled(&mut self) {
        let kept = if self.results.planned.is_some() { "; the last plan is kept" } else { "" };
        self.report_done(format!("Calculation cancelled{kept}"));
    }

    /// Reports that flank planning was cancelled. What was planned so far is not kept: only whole plans are
    /// judged, and freed from faulty moves.
    pub fn flank_cancelled(&mut self) {
        let kept = match self.results.flank.is_some() {
            true => "the last flank plan is kept",
            false => "an unfinished flank plan is not kept",
        };
        self.report_done(format!("Flank calculation cancelled; {kept}"));
    }

    /// Stores a flank plan, to be shown where flank milling is selected: the user may have gone on to another
    /// operation meanwhile.
    pub fn take_flank(&mut self, outcome: FlankOutcome) {
        (self.look.flank.cut, self.look.flank.pass) = (None, None);
        if self.look.operation == Operation::Flank {
            self.look.playing = None;
        }
        self.results.flank = Some(Arc::new(outcome));
        self.look.flank.shown = true;
        self.follow_flank_channels();
        self.solve(Topic::Flank);
        self.notice = None;
    }

    /// Upper end of the scale of the walls, which is symmetric, mm, while the view shows the walls instead of
    /// the stock on the hub.
    pub fn shown_deviation(&self) -> Option<f32> {
        let fitting = self.fitting_deviation()?;
        Some(self.look.wall_end.unwrap_or(fitting))
    }

    /// The same that fits the flank plan: its largest over- or undercut of the walls.
    pub fn fitting_deviation(&self) -> Option<f32> {
        let (outcome, _) = self.shown_flank().filter(|(_, colours)| *colours == FlankColours::Walls)?;
        Some(wall_scale_end(outcome.max_overcut().max(outcome.max_undercut()) as f32))
    }

    /// Flank plan and colouring that the views show; `None` while it is hidden.
    pub fn shown_flank(&self) -> Option<(&Arc<FlankOutcome>, FlankColours)> {
        let look = self.look.flank;
        let shown = self.look.operation == Operation::Flank && look.shown;
        self.results.flank.as_ref().filter(|_| shown).map(|outcome| (outcome, look.colours))
    }

    /// The flank plan that the views show, in the shown channels; `None` while it is hidden.
    pub fn shown_flank_run(&self) -> Option<&Arc<FlankRun>> {
        self.shown_flank().and(self.results.flank_run.as_ref())
    }

    /// Whether the selected operation is older than the setup.
    pub fn operation_is_stale(&self) -> bool {
        match self.look.operation {
            Operation::Roughing => self.out_of_date(),
            Operation::Flank => self.flank_is_stale(),
            Operation::Program => self.program_is_stale(),
        }
    }

    /// Whether what the flank plan depends on was edited after it was requested: of the plunges only where
    /// some open the channel for its passes.
    pub fn flank_is_stale(&self) -> bool {
        let Some(outcome) = &self.results.flank else { return false };
        let now = &self.document.edited.setup;
        let mut asked = outcome.setup.clone();
        // A tool that was chosen automatically, for a reason, does not count as a difference, unless another
        // one is chosen from the tools there are now.
        let is_chosen = outcome.plan.reason.is_some() && now.flank.tool.is_none();
        if is_chosen {
            asked.flank.tool = None;
        }
        let opens = outcome.plan.opening.is_some();
        // Edits by hand and sections are those of the roughing plan.
        asked.plunge.edits.clone_from(&now.plunge.edits);
        asked.plunge.sections.clone_from(&now.plunge.sections);
        asked.flank != now.flank
            || asked.allowances != now.allowances
            || asked.clearances != now.clearances
            || asked.machine != now.machine
            || opens && asked.plunge != now.plunge
            || !outcome.would_choose_from(now)
            || !outcome.would_open_with(now)
    }

    /// Policy that a side shows; `None` before there is a plan.
    pub fn policy(&self, side: Side) -> Option<AxisPolicy> {
        self.shown_on(side).map(|shown| shown.policy)
    }

    /// Plan on a side: the running task's once that side is finished, otherwise the last whole plan.
    pub fn shown_on(&self, side: Side) -> Option<ShownPlan<'_>> {
        let preview = self.results.preview.as_ref().and_then(|preview| preview.planned.as_ref());
        let finished =
            preview.zip(self.pending_policy(side)).filter(|(planned, policy)| planned.has(*policy));
        finished.map(|(planned, policy)| ShownPlan { planned, policy }).or_else(|| self.last_whole_plan(side))
    }

    /// The last whole plan on a side; it may be older than the setup.
    pub fn last_whole_plan(&self, side: Side) -> Option<ShownPlan<'_>> {
        let planned = self.results.planned.as_ref()?;
        let wanted = self.look.policies[side].filter(|&policy| planned.has(policy));
        Some(ShownPlan { planned, policy: wanted.unwrap_or_else(|| planned.default_policy(side)) })
    }

    /// Policy that a side will show when the running task finishes.
    fn pending_policy(&self, side: Side) -> Option<AxisPolicy> {
        let preview = self.results.preview.as_ref()?;
        let default = match side {
            Side::Before => AxisPolicy::Conventional,
            Side::After => preview.setup.plunge.axis,
        };
        Some(self.look.policies[side].unwrap_or(default))
    }

    /// Preview cutters that a side shows instead of those of the last plan.
    pub fn preview_on(&self, side: Side) -> Option<&PreviewCutters> {
        let (preview, policy) = self.results.preview.as_ref().zip(self.pending_policy(side))?;
        if preview.planned.as_ref().is_some_and(|planned| planned.has(policy)) {
            return None;
        }
        preview.cutters(policy)
    }

    /// Whether what a side shows is older than the setup.
    pub fn is_stale(&self, side: Side) -> bool {
        let stale = |shown: ShownPlan| !shown.planned.is_of(&self.document.edited.setup);
        self.shown_on(side).is_some_and(stale)
    }

    /// Whether a side is visible.
    pub fn shows(&self, side: Side) -> bool {
        self.look.shown_arrangement() != Arrangement::One || self.look.side == side
    }

    /// Plan of the active side, which table and sectional view describe.
    pub fn shown(&self) -> Option<ShownPlan<'_>> {
        self.shown_on(self.look.side)
    }

    /// The plans that the views show, those of both sides where both are visible.
    pub fn plans_in_view(&self) -> Vec<ShownPlan<'_>> {
        let sides = [Side::Before, Side::After].into_iter().filter(|side| self.shows(*side));
        sides.filter_map(|side| self.shown_on(side)).collect()
    }

    /// The selected position.
    pub fn selected(&self) -> Option<&Position> {
        self.shown()?.plan().positions.get(self.look.selected?)
    }

    /// Plane of the sectional view: the chosen one, else the one that explains the selected position.
    pub fn cut_plane(&self) -> CutPlane {
        let interferes = self.selected().is_some_and(|position| position.evaluation.contact.interferes());
        let explaining = if interferes { CutPlane::Contact } else { CutPlane::Row };
        self.look.sectional.plane.unwrap_or(explaining)
    }

    /// Number of positions of the shown plan.
    pub fn position_count(&self) -> usize {
        self.shown().map_or(0, |shown| shown.plan().positions.len())
    }

    /// Makes `side` active; the selection is followed to its plan.
    pub fn show(&mut self, side: Side) {
        self.follow_selection();
        self.look.side = side;
        self.keep_within_plan();
    }

    /// Ends of the colour scale, mm.
    pub fn range(&self) -> (f32, f32) {
        self.look.range.unwrap_or_else(|| self.fitting_range())
    }

    /// Ends of the colour scale that fit the last plan, mm.
    pub fn fitting_range(&self) -> (f32, f32) {
        // A running task does not change the scale of the last plan.
        let first = || self.shown_on(self.look.side).map(|shown| shown.planned.range);
        self.results.planned.as_ref().map(|planned| planned.range).or_else(first).unwrap_or((0.0, 1.0))
    }

    fn keep_within_plan(&mut self) {
        self.follow_selection();
        let count = self.position_count();
        self.look.selected = self.look.selected.filter(|&k| k < count);
        self.look.cut_count = self.look.cut_count.map(|cut| cut.min(count));
    }

    /// The shown plan on the machine of the setup, once it is known.
    pub fn on_machine(&self) -> Option<&Arc<ProgramOnMachine>> {
        self.results.on_machine.as_ref()?.as_ref().ok()
    }

    /// What a position of the shown plan asks of the axes of the machine.
    pub fn axis_demand(&self, position: usize) -> Option<&AxisDemand> {
        self.on_machine()?.demands.get(position)
    }

    /// Reports success in the status bar.
    pub fn report_done(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { tone: Tone::Done, text: text.into() });
    }

    /// Reports in the status bar alone why an input was not taken: it is gone with the next message.
    pub fn report_refusal(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { tone: Tone::Refusal, text: text.into() });
    }

    /// Reports a problem; it stays until it is dismissed or solved. A problem of a calculation replaces the
    /// one of the calculation before: while a value is dragged, each step would add another.
    pub fn report_problem(&mut self, problem: Problem) {
        if !problem.is_note() {
            self.notice = Some(Notice { tone: Tone::Fault, text: problem.text() });
        }
        self.problems.retain(|known| {
            *known != problem && (!problem.topic.is_of_calculation() || known.topic != problem.topic)
        });
        if self.problems.len() >= MAX_PROBLEMS {
            self.problems.remove(0);
        }
        self.problems.push(problem);
    }

    /// Removes a problem; its message leaves the status bar, too.
    pub fn dismiss_problem(&mut self, index: usize) {
        if index < self.problems.len() {
            self.problems.remove(index);
        }
        self.notice = self.notice.take().filter(|notice| notice.tone != Tone::Fault);
    }

    /// Removes all problems.
    pub fn dismiss_problems(&mut self) {
        self.problems.clear();
        self.notice = self.notice.take().filter(|notice| notice.tone != Tone::Fault);
    }

    /// What is wrong with single fields. Those of a project file stay when their messages are dismissed.
    pub fn field_faults(&self) -> Arc<[FieldFault]> {
        let replaced: Vec<&FieldFault> =
            self.document.edited.replaced.iter().filter_map(|value| value.field.as_ref()).collect();
        let reported = self.problems.iter().filter_map(|problem| problem.field.as_ref());
        let others = reported.filter(|fault| !replaced.contains(fault));
        replaced.iter().copied().chain(others).cloned().collect()
    }

    /// Ends the problems of fields that were edited: the default no longer stands for what was faulty. One of
    /// a calculation ends with the next.
    pub fn end_field_faults(&mut self, edited: &[FaultyField]) {
        let is_ended = |problem: &Problem| {
            !problem.topic.is_of_calculation()
                && problem.field.as_ref().is_some_and(|fault| edited.contains(&fault.field))
        };
        self.problems.retain(|problem| !is_ended(problem));
        let is_edited =
            |value: &ReplacedValue| value.field.as_ref().is_some_and(|f| edited.contains(&f.field));
        self.document.edited.replaced.retain(|value| !is_edited(value));
    }

    /// Removes the problems of a topic: it is solved.
    pub fn solve(&mut self, topic: Topic) {
        self.problems.retain(|problem| problem.topic != topic);
    }

    /// Removes the problems of a topic that are past; their message leaves the status bar, too.
    pub fn withdraw(&mut self, topic: Topic) {
        let count = self.problems.len();
        self.solve(topic);
        if self.problems.len() < count {
            self.notice = self.notice.take().filter(|notice| notice.tone != Tone::Fault);
        }
    }
}
