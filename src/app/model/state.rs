//! The window's state: the document, the results and the look, with the rules that connect them. No drawing.

use std::path::PathBuf;
use std::sync::Arc;

use crate::drawing::flank::FlankColours;
use crate::job::flank::FlankOutcome;
use crate::plunge::{PlungePlan, Position};
use crate::setup::AxisPolicy;

use crate::app::model::checked::{CheckRequest, CheckedProgram, ProgramFinding};
use crate::app::model::document::{Document, Edited, OpenPart};
use crate::app::model::look::{Arrangement, Filter, Look, Operation, REVEAL, TableColumn};
use crate::app::model::machine::{AxisDemand, PlanOnMachine};
use crate::app::model::part_source::PartSource;
use crate::app::model::planned::{DisplayPlan, Side};
use crate::app::model::preview::PreviewCutters;
use crate::app::model::problem::{Problem, Topic};
use crate::app::model::results::Results;
use crate::plunge::inspect::CutPlane;
use crate::plunge::plan::Condition;

/// Positions that a playing timeline cuts per second at speed 1.
pub const PLAY_RATE: f64 = 15.0;

/// Kind of a status bar message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Something was done.
    Done,
    /// Something failed; the text says what to do.
    Fault,
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
    /// Project or part, and when it was changed last.
    pub title: String,
}

/// The state of the window, apart from drawing.
pub struct AppState {
    /// What is edited.
    pub document: Document,
    /// What was computed.
    pub results: Results,
    /// How it is displayed.
    pub look: Look,
    /// Whether all policies are planned, for comparison.
    pub compare: bool,
    /// Whether every edit is planned at once.
    pub auto_update: bool,
    /// Problems not dismissed yet, oldest first.
    pub problems: Vec<Problem>,
    /// Recovery copies of sessions that ended without closing.
    pub recoverable: Vec<RecoveryCopy>,
    /// Recently opened projects, latest first.
    pub recents: Vec<PathBuf>,
    /// Latest message.
    pub notice: Option<Notice>,
    /// Part that is being opened.
    pub opening: Option<PartSource>,
}

/// Least range of the scale of the walls, mm: smaller deviations do not matter, and look so.
const MIN_DEVIATION: f32 = 0.02;

/// Maximum number of problems kept.
const MAX_PROBLEMS: usize = 5;

impl Default for AppState {
    fn default() -> Self {
        Self {
            document: Document::default(),
            results: Results::default(),
            look: Look::default(),
            compare: false,
            auto_update: true,
            problems: Vec::new(),
            recoverable: Vec::new(),
            recents: Vec::new(),
            notice: None,
            opening: None,
        }
    }
}

/// Where a timeline jumps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// The first plunge of a tool.
    Tool,
    /// The first plunge of a section.
    Section,
}

/// A plan that is shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownPlan<'a> {
    /// The set of plans it belongs to.
    pub planned: &'a Arc<DisplayPlan>,
    /// Policy of the plan.
    pub policy: AxisPolicy,
}

impl<'a> ShownPlan<'a> {
    /// The plan itself.
    pub fn plan(&self) -> &'a PlungePlan {
        self.planned.plan(self.policy)
    }

    /// Mean residual stock on the hub under a position's cutter, mm.
    pub fn stock(&self, position: usize) -> f32 {
        self.planned.stock(self.policy, position)
    }
}

impl AppState {
    /// Whether the setup was edited after the last plan was requested.
    pub fn out_of_date(&self) -> bool {
        self.results
            .planned
            .as_ref()
            .is_some_and(|planned| !planned.setup.equals_except_flank(&self.document.edited.setup))
    }

    /// Replaces the open part and its document; results of the previous part are dropped.
    pub fn open(&mut self, part: OpenPart, edited: Edited, path: Option<PathBuf>) {
        self.document.begin(part, edited, path);
        self.results = Results::default();
        self.look.begin();
        self.problems.clear();
        self.notice = None;
    }

    /// Closes the open part.
    pub fn close(&mut self) {
        self.document = Document::default();
        self.results = Results::default();
        self.look.begin();
        self.problems.clear();
        self.notice = None;
    }

    /// Stores a plan. The selection is kept if the new plan has that position. An unfinished plan does not
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
        self.results.take(planned);
        self.keep_within_plan();
        self.solve(Topic::Plan);
        self.solve(Topic::Stock);
        self.notice = None;
        let fitted = self.results.planned.as_ref().map(|planned| planned.range);
        // Scales that follow every plan would give one colour another meaning in each.
        if !unfinished && self.look.range.is_none() {
            self.look.range = fitted;
        }
        if let Some(change) = &self.results.tool_change {
            self.report_done(format!("Tools chosen anew: {change}"));
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

    /// Stores a flank plan and shows it.
    pub fn take_flank(&mut self, outcome: FlankOutcome) {
        self.results.flank = Some(Arc::new(outcome));
        self.look.flank.shown = true;
        self.look.operation = Operation::Flank;
        self.solve(Topic::Flank);
        self.notice = None;
    }

    /// Largest over- or undercut of the walls, mm, while the view shows the walls instead of the stock on the
    /// hub.
    pub fn shown_deviation(&self) -> Option<f32> {
        let (outcome, _) = self.shown_flank().filter(|(_, colours)| *colours == FlankColours::Walls)?;
        let plan = &outcome.plan;
        Some((plan.max_overcut().max(plan.max_undercut()) as f32).max(MIN_DEVIATION))
    }

    /// Flank plan and colouring that the views show; `None` while it is hidden.
    pub fn shown_flank(&self) -> Option<(&Arc<FlankOutcome>, FlankColours)> {
        let look = self.look.flank;
        let shown = self.look.operation == Operation::Flank && look.shown;
        self.results.flank.as_ref().filter(|_| shown).map(|outcome| (outcome, look.colours))
    }

    /// Whether the selected operation is older than the setup.
    pub fn operation_is_stale(&self) -> bool {
        match self.look.operation {
            Operation::Roughing => self.out_of_date(),
            Operation::Flank => self.flank_is_stale(),
            Operation::Program => self.program_is_stale(),
        }
    }

    /// Stores a checked program and shows it, with its first fault selected.
    pub fn take_checked(&mut self, checked: CheckedProgram) {
        self.look.operation = Operation::Program;
        self.look.finding = None;
        self.solve(Topic::Program);
        self.notice = None;
        self.results.checked = Some(Arc::new(checked));
    }

    /// The check of the program of the last check against the present setup.
    pub fn check_request(&self) -> Option<CheckRequest> {
        let checked = self.results.checked.as_ref()?;
        self.check_request_of(checked.request.path.clone())
    }

    /// The check of a program against the present setup; `None` without a part.
    pub fn check_request_of(&self, path: PathBuf) -> Option<CheckRequest> {
        let part = Arc::clone(&self.document.part.as_ref()?.impeller);
        let machine = self.look.check_machine.clone();
        Some(CheckRequest { path, machine, part, setup: self.document.edited.setup.clone() })
    }

    /// Whether the setup was edited after the program was checked.
    pub fn program_is_stale(&self) -> bool {
        let checked = self.results.checked.as_ref().zip(self.check_request());
        checked.is_some_and(|(checked, now)| !checked.request.is_same(&now))
    }

    /// The checked program, while it is shown.
    pub fn shown_program(&self) -> Option<&Arc<CheckedProgram>> {
        self.results.checked.as_ref().filter(|_| self.look.operation == Operation::Program)
    }

    /// The selected fault of the shown program.
    pub fn selected_finding(&self) -> Option<&ProgramFinding> {
        self.shown_program()?.findings.get(self.look.finding?)
    }

    /// Selects a fault of the shown program, and zooms to it.
    pub fn select_finding(&mut self, index: Option<usize>) {
        self.look.finding = index;
        self.look.fly = index.is_some();
    }

    /// Selects the fault `step` after the selected one, with wrap-around if `wraps`.
    fn select_next_finding(&mut self, step: isize, wraps: bool) {
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

    /// Whether allowances, tool or flank fields were edited after the flank plan was requested.
    pub fn flank_is_stale(&self) -> bool {
        let Some(outcome) = &self.results.flank else { return false };
        let now = &self.document.edited.setup;
        let mut asked = outcome.setup.clone();
        // A tool that was chosen automatically does not count as a difference.
        if now.flank.tool.is_none() {
            asked.flank.tool = None;
        }
        asked.flank != now.flank
            || asked.allowances != now.allowances
            || !now.tools.is_empty() && !now.tools.contains(&outcome.plan.tool)
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
        let wished = self.look.policies[side].filter(|&policy| planned.has(policy));
        Some(ShownPlan { planned, policy: wished.unwrap_or_else(|| planned.default_policy(side)) })
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
        let stale = |shown: ShownPlan| !shown.planned.setup.equals_except_flank(&self.document.edited.setup);
        self.shown_on(side).is_some_and(stale)
    }

    /// Whether a side is visible.
    pub fn shows(&self, side: Side) -> bool {
        self.look.arrangement != Arrangement::One || self.look.side == side
    }

    /// Plan of the active side, which table and sectional view describe.
    pub fn shown(&self) -> Option<ShownPlan<'_>> {
        self.shown_on(self.look.side)
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

    /// Makes `side` active; the selection is kept if that plan has the position.
    pub fn show(&mut self, side: Side) {
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

    /// Time of the program at the position of the timeline and at its end, s.
    pub fn clock(&self) -> Option<(f64, f64)> {
        let shown = self.shown()?;
        let count = shown.plan().positions.len();
        let at = |cut| shown.planned.time_after(shown.policy, cut);
        at(self.look.cut_count.unwrap_or(count)).zip(at(count))
    }

    fn keep_within_plan(&mut self) {
        let count = self.position_count();
        self.look.selected = self.look.selected.filter(|&k| k < count);
        self.look.cut_count = self.look.cut_count.map(|cut| cut.min(count));
    }

    /// The shown plan on the machine of the setup, once it is known.
    pub fn on_machine(&self) -> Option<&Arc<PlanOnMachine>> {
        self.results.on_machine.as_ref()?.as_ref().ok()
    }

    /// What a position of the shown plan asks of the axes of the machine.
    pub fn axis_demand(&self, position: usize) -> Option<&AxisDemand> {
        self.on_machine()?.demands.get(position)
    }

    /// Positions that pass the filter, in table order.
    pub fn rows(&self) -> Vec<usize> {
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let filter = self.look.filter;
        let passes = |k: usize, position: &Position| match filter {
            Filter::All => true,
            Filter::Interfering => position.condition() == Condition::Interfering,
            Filter::Blocked => position.condition() == Condition::Blocked,
            Filter::AxisWarnings => self.axis_demand(k).is_some_and(AxisDemand::is_warning),
        };
        let passing = plan.positions.iter().enumerate().filter(|(k, p)| passes(*k, p));
        let mut rows: Vec<(f64, usize)> = passing
            .map(|(k, p)| {
                let key = match self.look.sort.column {
                    TableColumn::Order => k as f64,
                    TableColumn::Row => p.section as f64 * 1e6 + p.row as f64,
                    TableColumn::Diameter => plan.sections.get(p.section).map_or(0.0, |s| s.tool.diameter),
                    TableColumn::Alpha => p.alpha_rad,
                    TableColumn::Contact => p.evaluation.contact.depth,
                    // Without floor under the cutter: sort as the smallest.
                    TableColumn::Hub => {
                        Some(shown.stock(k)).filter(|s| s.is_finite()).map_or(-1.0, f64::from)
                    }
                    TableColumn::Axes => self.axis_demand(k).map_or(0.0, AxisDemand::weight),
                };
                (key, k)
            })
            .collect();
        let descending = self.look.sort.descending;
        rows.sort_by(|a, b| {
            let order = a.0.total_cmp(&b.0);
            (if descending { order.reverse() } else { order }).then(a.1.cmp(&b.1))
        });
        rows.into_iter().map(|(_, k)| k).collect()
    }

    /// Scrolls the table to the selected position; clears a filter that hides it.
    pub fn show_in_table(&mut self) {
        if self.look.selected.is_some_and(|k| !self.rows().contains(&k)) {
            self.look.filter = Filter::All;
        }
        self.look.reveal_selection = REVEAL;
    }

    /// Selects the row `step` below the selected one in table order, clamped to the first and last row.
    pub fn select_next_row(&mut self, step: isize) {
        if self.look.operation == Operation::Program {
            self.select_next_finding(step, false);
            return;
        }
        let rows = self.rows();
        let Some(last) = rows.len().checked_sub(1) else { return };
        let now = self.look.selected.and_then(|k| rows.iter().position(|&row| row == k));
        let next = match now {
            None => 0,
            Some(now) => now.saturating_add_signed(step).min(last),
        };
        self.look.select_and_zoom(rows.get(next).copied());
    }

    /// Selects the next or previous interfering plunge in cutting order, with wrap-around.
    pub fn select_next_fault(&mut self, forward: bool) {
        if self.look.operation == Operation::Program {
            self.select_next_finding(if forward { 1 } else { -1 }, true);
            return;
        }
        let Some(shown) = self.shown() else { return };
        let positions = shown.plan().positions.iter().enumerate();
        let faults: Vec<usize> =
            positions.filter(|(_, p)| p.evaluation.contact.interferes()).map(|(k, _)| k).collect();
        let Some((&first, &last)) = faults.first().zip(faults.last()) else { return };
        let next = match (self.look.selected, forward) {
            (None, true) => first,
            (None, false) => last,
            (Some(now), true) => faults.iter().copied().find(|&k| k > now).unwrap_or(first),
            (Some(now), false) => faults.iter().copied().rev().find(|&k| k < now).unwrap_or(last),
        };
        self.look.select_and_zoom(Some(next));
    }

    /// Moves the timeline by `step` positions and selects the position cut last. From the end it starts at
    /// the selected position, if there is one.
    pub fn step_timeline(&mut self, step: isize) {
        let count = self.position_count();
        if count == 0 {
            return;
        }
        let now = self.look.cut_count.unwrap_or_else(|| match self.look.selected {
            Some(k) => k + 1,
            None => count,
        });
        self.set_timeline(Some(now.saturating_add_signed(step).min(count)));
    }

    /// Indices of the first positions of each section, or after each tool change.
    pub fn boundaries(&self, of: Boundary) -> Vec<usize> {
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let key = |position: &Position| match of {
            Boundary::Section => position.section as u32,
            Boundary::Tool => plan.sections.get(position.section).map_or(0, |s| s.tool.number),
        };
        let keys: Vec<u32> = plan.positions.iter().map(key).collect();
        (0..keys.len()).filter(|&k| k == 0 || keys[k - 1] != keys[k]).collect()
    }

    /// Moves the timeline to the first plunge of the next or previous tool or section, and selects it. At the
    /// end of the timeline it starts from the selected position, else forward from the blank, backward from
    /// the end.
    pub fn jump_to_boundary(&mut self, of: Boundary, forward: bool) {
        let now = self.look.cut_count.or(self.look.selected.map(|k| k + 1));
        let mut cuts = self.boundaries(of).into_iter().map(|k| k + 1);
        let next = match (now, forward) {
            (None, true) => cuts.next(),
            (None, false) => cuts.next_back(),
            (Some(now), true) => cuts.find(|&cut| cut > now),
            (Some(now), false) => cuts.rfind(|&cut| cut < now),
        };
        if next.is_some() {
            self.set_timeline(next);
        }
    }

    /// Sets the timeline to after `cut` positions; `None`: the end, with the selection unchanged.
    pub fn set_timeline(&mut self, cut: Option<usize>) {
        let count = self.position_count();
        self.look.cut_count = cut.map(|cut| cut.min(count));
        if let Some(cut) = self.look.cut_count {
            self.look.selected = cut.checked_sub(1);
            self.look.reveal_selection = if cut > 0 { REVEAL } else { 0 };
        }
    }

    /// Starts or stops playing; starts from the blank when the timeline is at the end. `time` in seconds.
    pub fn play(&mut self, time: f64) {
        if self.look.playing.take().is_some() || self.position_count() == 0 {
            return;
        }
        if self.look.cut_count.is_none_or(|cut| cut >= self.position_count()) {
            self.set_timeline(Some(0));
        }
        self.look.playing = Some(time);
    }

    /// Advances a playing timeline; returns the seconds until its next step.
    pub fn advance(&mut self, time: f64) -> Option<f64> {
        let since = self.look.playing?;
        let rate = PLAY_RATE * self.look.play_speed;
        let steps = ((time - since) * rate).floor().clamp(0.0, 1e6);
        if steps >= 1.0 {
            self.look.playing = Some(since + steps / rate);
            let at_end = |state: &Self| state.look.cut_count.is_none_or(|cut| cut >= state.position_count());
            if at_end(self) && self.look.play_loop {
                self.set_timeline(Some(0));
            } else {
                self.step_timeline(steps as isize);
            }
            if at_end(self) && !self.look.play_loop {
                self.look.playing = None;
            }
        }
        self.look.playing.map(|since| (since + 1.0 / rate - time).max(0.0))
    }

    /// Reports success in the status bar.
    pub fn report_done(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { tone: Tone::Done, text: text.into() });
    }

    /// Reports a problem; it stays until it is dismissed or solved. A problem of a calculation replaces the
    /// one of the calculation before: while a value is dragged, each step would add another.
    pub fn report_problem(&mut self, problem: Problem) {
        self.notice = Some(Notice { tone: Tone::Fault, text: problem.text() });
        self.problems.retain(|known| {
            *known != problem && (problem.topic == Topic::Other || known.topic != problem.topic)
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

    fn solve(&mut self, topic: Topic) {
        self.problems.retain(|problem| problem.topic != topic);
    }
}
