//! The window's state: the document, the results and the look, with the rules that connect them. No drawing.

use std::path::PathBuf;
use std::sync::Arc;

use crate::gpu::flank::FlankColours;
use crate::io::InputError;
use crate::job::flank::FlankOutcome;
use crate::plunge::{PlungePlan, Position};
use crate::setup::AxisPolicy;

use super::document::{Document, Edited, OpenPart};
use super::engine::PartSource;
use super::look::{Arrangement, Filter, Look, REVEAL, TableColumn};
use super::planned::{DisplayPlan, Side};
use super::preview::PreviewCutters;
use super::results::Results;
use super::theme::Condition;

/// Positions that a playing timeline cuts per second.
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
    pub recoverable: Vec<PathBuf>,
    /// Recently opened projects, latest first.
    pub recents: Vec<PathBuf>,
    /// Latest message.
    pub notice: Option<Notice>,
    /// Part that is being opened.
    pub opening: Option<PartSource>,
}

/// A problem shown until it is dismissed or solved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// What is wrong, and where.
    pub message: String,
    /// What to do about it; may be empty.
    pub help: String,
    /// Whether planning caused it; the next successful plan removes it.
    pub of_plan: bool,
}

impl Problem {
    /// A problem that stays until it is dismissed.
    pub fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: what.into(), help: help.into(), of_plan: false }
    }

    /// A problem of planning, which the next successful plan removes.
    pub fn from_planning(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { of_plan: true, ..Self::new(what, help) }
    }
}

impl From<&InputError> for Problem {
    fn from(error: &InputError) -> Self {
        let bare = InputError { help: String::new(), ..error.clone() }.to_string();
        Self::new(bare.trim_end_matches("; "), error.help.clone())
    }
}

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
        self.problems.retain(|problem| !problem.of_plan);
        self.notice = None;
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
        self.problems.retain(|problem| !problem.of_plan);
        self.notice = None;
    }

    /// Largest over- or undercut of the walls, mm, while the view shows the walls instead of the stock on the
    /// hub.
    pub fn shown_deviation(&self) -> Option<f32> {
        let look = self.look.flank;
        let plan =
            &self.results.flank.as_ref().filter(|_| look.shown && look.colours == FlankColours::Walls)?.plan;
        Some((plan.max_overcut().max(plan.max_undercut()) as f32).max(1e-3))
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
        let coming = self.results.preview.as_ref().and_then(|coming| coming.planned.as_ref());
        let finished = coming.zip(self.pending_policy(side)).filter(|(planned, policy)| planned.has(*policy));
        finished.map(|(planned, policy)| ShownPlan { planned, policy }).or_else(|| self.last_whole_plan(side))
    }

    /// The last whole plan on a side; it may be older than the setup.
    pub fn last_whole_plan(&self, side: Side) -> Option<ShownPlan<'_>> {
        let planned = self.results.planned.as_ref()?;
        let wished = self.look.policies[side as usize].filter(|&policy| planned.has(policy));
        Some(ShownPlan { planned, policy: wished.unwrap_or_else(|| planned.default_policy(side)) })
    }

    /// Policy that a side will show when the running task finishes.
    fn pending_policy(&self, side: Side) -> Option<AxisPolicy> {
        let coming = self.results.preview.as_ref()?;
        let default = match side {
            Side::Before => AxisPolicy::Conventional,
            Side::After => coming.setup.plunge.axis,
        };
        Some(self.look.policies[side as usize].unwrap_or(default))
    }

    /// Preview cutters that a side shows instead of those of the last plan.
    pub fn preview_on(&self, side: Side) -> Option<&PreviewCutters> {
        let (coming, policy) = self.results.preview.as_ref().zip(self.pending_policy(side))?;
        if coming.planned.as_ref().is_some_and(|planned| planned.has(policy)) {
            return None;
        }
        coming.cutters(policy)
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
        // A running task does not change the scale of the last plan.
        let fitting = || {
            let first = || self.shown_on(self.look.side).map(|shown| shown.planned.range);
            self.results.planned.as_ref().map(|planned| planned.range).or_else(first).unwrap_or((0.0, 1.0))
        };
        self.look.range.unwrap_or_else(fitting)
    }

    fn keep_within_plan(&mut self) {
        let count = self.position_count();
        self.look.selected = self.look.selected.filter(|&k| k < count);
        self.look.cut_count = self.look.cut_count.map(|cut| cut.min(count));
    }

    /// Positions that pass the filter, in table order.
    pub fn rows(&self) -> Vec<usize> {
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let filter = self.look.filter;
        let passes = |position: &Position| match filter {
            Filter::All => true,
            Filter::Interfering => position.condition() == Condition::Interfering,
            Filter::Blocked => position.condition() == Condition::Blocked,
        };
        let passing = plan.positions.iter().enumerate().filter(|(_, p)| passes(p));
        let mut rows: Vec<(f64, usize)> = passing
            .map(|(k, p)| {
                let key = match self.look.sort.column {
                    TableColumn::Order => k as f64,
                    TableColumn::Row => p.section as f64 * 1e6 + p.row as f64,
                    TableColumn::Diameter => plan.sections.get(p.section).map_or(0.0, |s| s.tool.diameter),
                    TableColumn::Alpha => p.alpha_rad,
                    TableColumn::Contact => p.contact.depth,
                    // Without floor under the cutter: sort as the smallest.
                    TableColumn::Hub => {
                        Some(shown.stock(k)).filter(|s| s.is_finite()).map_or(-1.0, f64::from)
                    }
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
        let Some(shown) = self.shown() else { return };
        let positions = shown.plan().positions.iter().enumerate();
        let faults: Vec<usize> = positions.filter(|(_, p)| p.contact.interferes()).map(|(k, _)| k).collect();
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
        let steps = ((time - since) * PLAY_RATE).floor().clamp(0.0, 1e6);
        if steps >= 1.0 {
            self.look.playing = Some(since + steps / PLAY_RATE);
            self.step_timeline(steps as isize);
            if self.look.cut_count.is_none_or(|cut| cut >= self.position_count()) {
                self.look.playing = None;
            }
        }
        self.look.playing.map(|since| (since + 1.0 / PLAY_RATE - time).max(0.0))
    }

    /// Reports success in the status bar.
    pub fn report_done(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { tone: Tone::Done, text: text.into() });
    }

    /// Reports a problem; it stays until it is dismissed or solved.
    pub fn report_problem(&mut self, problem: Problem) {
        let text = if problem.help.is_empty() {
            problem.message.clone()
        } else {
            format!("{}; {}", problem.message, problem.help)
        };
        self.notice = Some(Notice { tone: Tone::Fault, text });
        self.problems.retain(|known| *known != problem);
        if self.problems.len() >= MAX_PROBLEMS {
            self.problems.remove(0);
        }
        self.problems.push(problem);
    }
}
