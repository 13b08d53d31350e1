//! Time against stock: the curve of the plans of `minimal`, with the other policies beside it. The handle on
//! the curve is the time that a channel may take; the plan follows it.

use egui::{Id, ProgressBar, RichText, Ui};

use super::fields;
use super::goal::goal_rows;
use super::tradeoff_plot::{CurvePlace, Curves, Marker, plot, stock_at, total_at};
use crate::app::App;
use crate::app::model::figures::{format_duration, policy_label};
use crate::app::model::state::AppState;
use crate::app::views::theme::Condition;
use crate::report::words::NOT_ON_MACHINE;
use crate::setup::{AxisPolicy, Goal};
use crate::tradeoff::TradeoffPoint;

/// Least height of the plot, points.
const MIN_HEIGHT: f32 = 120.0;
/// Height of what stands below the plot before it is measured, points.
const BELOW: f32 = 84.0;
/// Number of other strategies that are planned for comparison; without it, one stands beside the curve.
const OTHERS_COMPARED: usize = 2;

impl App {
    /// Time against stock.
    pub(in crate::app) fn tradeoff(&mut self, ui: &mut Ui) {
        let points = self.weighing.points().cloned();
        let search = match self.weighing.progress() {
            Some(progress) => CurveSearch::Running((!self.weighing.is_held()).then_some(progress)),
            None if self.weighing.was_cancelled() => CurveSearch::Cancelled,
            None if !self.work.is_planning() && !can_be_weighed(&self.state) => CurveSearch::NoPlan,
            None => CurveSearch::Idle,
        };
        match show(ui, &mut self.state, points.as_deref(), search) {
            Some(CurveCommand::Cancel) => self.cancel_curve(),
            Some(CurveCommand::Restart) => {
                self.state.notice = None;
                self.weighing.restart();
            }
            Some(CurveCommand::Plan) => self.plan(),
            None => {}
        }
    }
}

/// Whether the last plan was finished, and is one of which the curve is found.
fn can_be_weighed(state: &AppState) -> bool {
    let planned = state.results.planned.as_ref();
    planned
        .is_some_and(|planned| planned.setup.plunge.axis == AxisPolicy::Minimal && !planned.is_unfinished())
}

/// State of the search for the curve.
#[derive(Clone, Copy)]
enum CurveSearch {
    Idle,
    /// With its progress, 0…1; `None` while it waits for another calculation.
    Running(Option<f64>),
    Cancelled,
    /// No plan to weigh is there or being calculated.
    NoPlan,
}

/// What the user asks of the search.
enum CurveCommand {
    Cancel,
    Restart,
    Plan,
}

fn place_of(point: &TradeoffPoint) -> CurvePlace {
    (point.time_s / 60.0, point.residual_p95)
}

/// The text in place of a missing curve: its progress, or why there is none.
fn waiting(ui: &mut Ui, state: &AppState, search: CurveSearch) -> Option<CurveCommand> {
    let is_minimal = state.document.edited.setup.plunge.axis == AxisPolicy::Minimal;
    ui.horizontal(|ui| match search {
        CurveSearch::Running(progress) => {
            let text = match progress {
                Some(progress) => format!("Weighing the plunges {:.0} %", 100.0 * progress),
                None => "Weighing the plunges: waiting…".to_owned(),
            };
            ui.add(ProgressBar::new(progress.unwrap_or(0.0) as f32).desired_width(200.0).text(text));
            ui.button("Cancel curve").clicked().then_some(CurveCommand::Cancel)
        }
        CurveSearch::Cancelled => {
            ui.label("The curve was cancelled.");
            ui.button("Calculate curve").clicked().then_some(CurveCommand::Restart)
        }
        CurveSearch::NoPlan if is_minimal => {
            ui.label("No plan of this setup was finished.");
            ui.button("Calculate it").clicked().then_some(CurveCommand::Plan)
        }
        CurveSearch::Idle if is_minimal => {
            ui.spinner();
            ui.label("Waiting for the plan…");
            None
        }
        CurveSearch::Idle | CurveSearch::NoPlan => {
            ui.label("Only plans of Min. stock leave a choice between time and stock.");
            None
        }
    })
    .inner
}

/// Draws plot, slider and figures; edits the goal of the setup.
fn show(
    ui: &mut Ui,
    state: &mut AppState,
    points: Option<&[TradeoffPoint]>,
    search: CurveSearch,
) -> Option<CurveCommand> {
    let curve: Vec<CurvePlace> = points.unwrap_or_default().iter().map(place_of).collect();
    let (Some(slowest), Some(fastest)) = (curve.first(), curve.last()) else {
        return waiting(ui, state, search);
    };
    let (fastest, slowest) = (fastest.0, slowest.0);
    let goal = state.document.edited.setup.plunge.goal;
    let limit = match goal {
        Goal::Stock { max_time_min } => max_time_min,
        Goal::Time { .. } | Goal::Balance | Goal::Total { .. } => None,
    };
    let totals: Vec<CurvePlace> = match goal {
        Goal::Total { finishing } => {
            let total = |point: &TradeoffPoint| (point.total_s(&finishing) / 60.0, point.residual_p95);
            points.unwrap_or_default().iter().map(total).collect()
        }
        _ => Vec::new(),
    };
    // The handle stands at what is asked for, else at what the plan takes.
    let planned = state.results.planned.as_ref().map(|planned| &planned.outcome);
    let now = planned.map_or(slowest, |outcome| outcome.after.summary.time_s() / 60.0);
    let handle = limit.unwrap_or(now).clamp(fastest, slowest);
    let others: Vec<Marker> = planned.map(|outcome| markers(&outcome.policies())).unwrap_or_default();
    let first = planned.and_then(|outcome| outcome.setup.tools.first()).cloned();
    fields::form(ui, "goal fields", |ui| {
        let (edited, known) = (&mut state.document.edited.setup.plunge.goal, &mut state.look.known_goals);
        goal_rows(ui, edited, known, Goal::default(), first.as_ref());
    });
    // The lines below are as high as they were in the frame before: in a narrow panel they wrap.
    let key = Id::unique("height below the curve");
    let below = ui.data(|data| data.get_temp::<f32>(key)).unwrap_or(BELOW);
    let height = (ui.available_height() - below).max(MIN_HEIGHT);
    // The figures of the plan itself, where that is what the handle stands for.
    let finishing_s = state.results.planned.as_ref().and_then(|planned| planned.finishing_time_s);
    // Another goal than that of the plan does not count it.
    let is_counted = matches!(goal, Goal::Total { .. }) && stands_at(handle, now, state);
    let total = finishing_s.filter(|_| is_counted).map(|seconds| now + seconds / 60.0);
    // That of the plan itself, too: it may lie beside the curve.
    let of_plan = planned.map(|outcome| outcome.after.summary.residual_p95);
    let stock = of_plan.filter(|_| stands_at(handle, now, state)).or_else(|| stock_at(&curve, handle));
    let total_of_plan = total.zip(stock);
    let curves = Curves { plunging: &curve, totals: &totals, total_of_plan, others: &others };
    let dragged = plot(ui, &curves, (handle, stock), height);
    let top = ui.cursor().top();
    let mut wanted = dragged;
    ui.horizontal(|ui| {
        let label = ui.label("Max time per channel").on_hover_text(TIME_TIP);
        let width = (ui.available_width() - 70.0).clamp(60.0, 220.0);
        ui.spacing_mut().slider_width = width;
        let (response, moved) = fields::slider(ui, handle, fastest..=slowest, 0.1);
        response.labelled_by(label.id).on_hover_text(TIME_TIP);
        wanted = wanted.or(moved);
        let text = limit.map_or_else(|| "none".to_owned(), |minutes| format!("{minutes:.1} min"));
        ui.label(text);
    });
    let shown = planned.map(|outcome| &outcome.after.summary);
    let shown = shown.map(|summary| (summary.time_s() / 60.0, summary.residual_p95));
    ui.label(words(&curve, handle, shown, state));
    if others.len() < OTHERS_COMPARED {
        ui.label(RichText::new("Other strategies: \"Compare all strategies\" under Axis strategies").weak());
    }
    if let Some(total) = total.or_else(|| total_at(&curve, handle, &totals)) {
        ui.label(format!("With semi-finishing {total:.1} min per channel"));
    }
    if let Some(refused) = planned.and_then(|outcome| refused_text(&outcome.policies())) {
        ui.label(RichText::new(refused).weak());
    }
    if let Some(missed) = state.missed_goal() {
        ui.label(RichText::new(missed).color(Condition::Blocked.text(ui.visuals())));
    }
    let measured = ui.cursor().top() - top;
    if (measured - below).abs() > 0.5 {
        ui.data_mut(|data| data.insert_temp(key, measured));
        ui.ctx().request_repaint();
    }
    if let Some(minutes) = wanted {
        // The right end of the curve is the plan of the least stock.
        let max_time_min = (minutes < slowest - 1e-9).then(|| (10.0 * minutes).round() / 10.0);
        state.document.edited.setup.plunge.goal = Goal::Stock { max_time_min };
    }
    None
}

const TIME_TIP: &str = "How long a channel may take, on the machine if the setup names one (else without tool changes and\n\
     accelerations): as much stock as fits that time is left.\n\
     At the right end: whatever the least stock takes. Moved under another goal, it makes this one the goal";

fn markers(policies: &[&crate::job::PolicyResult]) -> Vec<Marker> {
    let other = policies.iter().filter(|result| result.plan.policy != AxisPolicy::Minimal);
    other
        .filter(|result| !result.summary.is_refused && result.summary.residual_p95.is_finite())
        .map(|result| Marker {
            name: policy_label(result.plan.policy),
            at: (result.summary.time_s() / 60.0, result.summary.residual_p95),
            interferes: result.plan.count_interfering() > 0,
        })
        .collect()
}

/// The other policies whose plans the machine cannot run, and which have no place in the plot; `None` without
/// any.
fn refused_text(policies: &[&crate::job::PolicyResult]) -> Option<String> {
    let refused = policies.iter().filter(|result| result.summary.is_refused);
    let names: Vec<&str> = refused.map(|result| policy_label(result.plan.policy)).collect();
    (!names.is_empty()).then(|| format!("{}: {NOT_ON_MACHINE}", names.join(", ")))
}

/// Times that are nearer to each other than this are one, min: the handle moves by tenths.
const SAME_TIME_MIN: f64 = 0.05;

/// Whether the handle stands for the shown plan, which takes `now` min.
fn stands_at(handle: f64, now: f64, state: &AppState) -> bool {
    !state.out_of_date() || (handle - now).abs() < SAME_TIME_MIN
}

/// What the longest time of the curve leaves, at `slowest`, against the plan that is `shown`.
fn end_words(slowest: CurvePlace, shown: CurvePlace, length: impl Fn(f64) -> String) -> String {
    let ends_there = (slowest.0 - shown.0).abs() < SAME_TIME_MIN;
    // The same plan is not written twice: its stock is measured on another grid for the curve.
    if ends_there {
        return "where the curve ends".to_owned();
    }
    let takes_longer = slowest.0 > shown.0;
    match takes_longer && (slowest.1 >= shown.1 || length(slowest.1) == length(shown.1)) {
        true => format!("up to {:.1} min, where the curve ends, leave no less", slowest.0),
        false => format!("the curve ends at {:.1} min with {}", slowest.0, length(slowest.1)),
    }
}

/// What the time of the handle costs, against the `shown` plan; where that stands at the handle, what the
/// longest time of the curve would leave.
fn words(curve: &[CurvePlace], handle: f64, shown: Option<CurvePlace>, state: &AppState) -> String {
    let Some((slowest, stock)) = curve.first().copied().zip(stock_at(curve, handle)) else {
        return String::new();
    };
    let length = |mm: f64| state.look.units.length(mm, 2);
    let (now, known) = shown.filter(|place| place.0.is_finite()).unwrap_or(slowest);
    if stands_at(handle, now, state) {
        let longest = end_words(slowest, (now, known), length);
        // The limit of this goal counts from the allowance.
        let above = match state.document.edited.setup.plunge.goal {
            Goal::Time { .. } => {
                let allowance = state.document.edited.setup.allowances.hub_allowance;
                format!(", {} above the allowance", length(known - allowance))
            }
            _ => String::new(),
        };
        return format!(
            "{handle:.1} min per channel: hub stock {} (95 %{above}), the shown plan; {longest}",
            length(known)
        );
    }
    let wheel = state.document.part.as_ref().map_or(1, |part| part.impeller.blade_count) as f64;
    let saved = 60.0 * wheel * (now - handle);
    let change = match saved > 0.0 {
        true => format!("saves {}", format_duration(saved)),
        false => format!("takes {} more", format_duration(-saved)),
    };
    format!(
        "{handle:.1} min per channel: hub stock {} (95 %) instead of {}; {change} per wheel compared with the shown plan",
        length(stock),
        length(known),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_of_the_curve_that_leaves_no_less_is_said_to() {
        let words = |slowest, shown| end_words(slowest, shown, |mm| format!("{mm:.2} mm"));
        assert_eq!(
            words((107.9, 1.13), (88.3, 1.12)),
            "up to 107.9 min, where the curve ends, leave no less"
        );
        assert_eq!(
            words((107.9, 1.118), (88.3, 1.12)),
            "up to 107.9 min, where the curve ends, leave no less"
        );
        assert_eq!(words((107.9, 0.98), (88.3, 1.12)), "the curve ends at 107.9 min with 0.98 mm");
        assert_eq!(words((88.31, 1.13), (88.3, 1.12)), "where the curve ends");
        assert_eq!(words((80.0, 1.2), (88.3, 1.12)), "the curve ends at 80.0 min with 1.20 mm");
    }
}
