//! Time against stock: the curve of the plans of `minimal`, with the other policies beside it. The handle on
//! the curve is the time that a channel may take; the plan follows it.

use egui::{
    Align2, Color32, FontId, Painter, Pos2, ProgressBar, Rect, RichText, Role, Sense, Shape, Stroke, Ui,
    Vec2, WidgetInfo,
};

use super::fields;
use super::goal::goal_rows;
use crate::app::App;
use crate::app::model::figures::{format_duration, policy_label};
use crate::app::model::state::AppState;
use crate::app::views::theme::{self, Condition};
use crate::app::views::ticks::ticks;
use crate::app::views::units;
use crate::report::words::NOT_ON_MACHINE;
use crate::setup::{AxisPolicy, Goal};
use crate::tradeoff::TradeoffPoint;

/// Room for the scales at the left and below, and above and at the right, points.
const MARGIN: [Vec2; 2] = [Vec2::new(38.0, 32.0), Vec2::new(14.0, 10.0)];
/// Least height of the plot, points.
const MIN_HEIGHT: f32 = 120.0;
/// Height of the lines below the plot, points.
const BELOW: f32 = 84.0;
/// Totals are shown up to this multiple of the least: the few long ones would press the curve together.
const TOTALS_SHOWN: f64 = 1.6;
/// Height of the lines on semi-finishing and on other strategies, points.
const LINE: f32 = 20.0;
/// Number of other strategies that are planned for comparison; without it, one stands beside the curve.
const OTHERS_COMPARED: usize = 2;
/// Radius of the handle, points.
const HANDLE: f32 = 6.0;

impl App {
    /// Time against stock.
    pub(in crate::app) fn tradeoff(&mut self, ui: &mut Ui) {
        let points = self.weighing.points().cloned();
        let search = match self.weighing.progress() {
            Some(progress) => CurveSearch::Running(progress),
            None if self.weighing.was_cancelled() => CurveSearch::Cancelled,
            None if !self.work.is_planning() && !can_be_weighed(&self.state) => CurveSearch::NoPlan,
            None => CurveSearch::Idle,
        };
        match show(ui, &mut self.state, points.as_deref(), search) {
            Some(CurveCommand::Cancel) => self.weighing.cancel(),
            Some(CurveCommand::Restart) => self.weighing.restart(),
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
    /// With its progress, 0…1.
    Running(f64),
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

/// A plan as a point: time of a channel in minutes, 95th percentile of the stock in mm.
type CurvePlace = (f64, f64);

fn place_of(point: &TradeoffPoint) -> CurvePlace {
    (point.time_s / 60.0, point.residual_p95)
}

/// The text in place of a missing curve: its progress, or why there is none.
fn waiting(ui: &mut Ui, state: &AppState, search: CurveSearch) -> Option<CurveCommand> {
    let is_minimal = state.document.edited.setup.plunge.axis == AxisPolicy::Minimal;
    ui.horizontal(|ui| match search {
        CurveSearch::Running(progress) => {
            let text = format!("Weighing the plunges {:.0} %", 100.0 * progress);
            ui.add(ProgressBar::new(progress as f32).desired_width(200.0).text(text));
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
    let more = [!totals.is_empty(), others.len() < OTHERS_COMPARED];
    let lines = LINE * more.into_iter().filter(|line| *line).count() as f32;
    let height = (ui.available_height() - BELOW - lines).max(MIN_HEIGHT);
    let curves = Curves { plunging: &curve, totals: &totals, others: &others };
    let dragged = plot(ui, &curves, handle, height);
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
    // The figure of the plan itself, where that is what the handle stands for.
    let finishing_s = state.results.planned.as_ref().and_then(|planned| planned.finishing_time_s);
    let total = finishing_s.filter(|_| stands_at(handle, now, state)).map(|seconds| now + seconds / 60.0);
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
    if let Some(minutes) = wanted {
        // The right end of the curve is the plan of the least stock.
        let max_time_min = (minutes < slowest - 1e-9).then(|| (10.0 * minutes).round() / 10.0);
        state.document.edited.setup.plunge.goal = Goal::Stock { max_time_min };
    }
    None
}

const TIME_TIP: &str = "How long a channel may take, on the machine if the setup names one (else without tool changes and\n\
     accelerations): as much stock as fits that time is left.\n\
     At the right end: whatever the least stock takes";

/// The plan of another policy in the plot.
struct Marker {
    name: &'static str,
    at: CurvePlace,
    interferes: bool,
}

fn markers(policies: &[&crate::job::PolicyResult]) -> Vec<Marker> {
    let other = policies.iter().filter(|result| result.plan.policy != AxisPolicy::Minimal);
    other
        .filter(|result| !result.summary.is_refused)
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

/// The two points of the curve beside a time of `minutes`, and how far it is from the first to the second,
/// 0…1.
fn between(curve: &[CurvePlace], minutes: f64) -> Option<([usize; 2], f64)> {
    let next = curve.iter().position(|(time, _)| *time <= minutes).unwrap_or(curve.len() - 1);
    let pair = [next.saturating_sub(1), next];
    let [slow, fast] = [curve.get(pair[0])?.0, curve.get(pair[1])?.0];
    let share = if slow > fast { (slow - minutes) / (slow - fast) } else { 0.0 };
    Some((pair, share.clamp(0.0, 1.0)))
}

/// Stock of the curve at a time of `minutes`, between its points.
fn stock_at(curve: &[CurvePlace], minutes: f64) -> Option<f64> {
    let ([slow, fast], share) = between(curve, minutes)?;
    Some(curve[slow].1 + (curve[fast].1 - curve[slow].1) * share)
}

/// Time with semi-finishing, `totals` for the points of `curve`, where plunging takes `minutes`.
fn total_at(curve: &[CurvePlace], minutes: f64, totals: &[CurvePlace]) -> Option<f64> {
    let ([slow, fast], share) = between(curve, minutes)?;
    let (slow, fast) = (totals.get(slow)?.0, totals.get(fast)?.0);
    Some(slow + (fast - slow) * share)
}

/// Times that are nearer to each other than this are one, min: the handle moves by tenths.
const SAME_TIME_MIN: f64 = 0.05;

/// Whether the handle stands for the shown plan, which takes `now` min.
fn stands_at(handle: f64, now: f64, state: &AppState) -> bool {
    !state.out_of_date() || (handle - now).abs() < SAME_TIME_MIN
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
        // The same plan is not written twice: its stock is measured on another grid for the curve.
        let longest = match (slowest.0 - now).abs() < SAME_TIME_MIN {
            true => "where the curve ends".to_owned(),
            false => format!("the curve ends at {:.1} min with {}", slowest.0, length(slowest.1)),
        };
        return format!(
            "{handle:.1} min per channel: hub stock {} (95 %), the shown plan; {longest}",
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

/// What the plot shows.
struct Curves<'a> {
    /// The plans of `minimal`, by falling time.
    plunging: &'a [CurvePlace],
    /// The same with the time of semi-finishing; empty where the goal does not count it.
    totals: &'a [CurvePlace],
    others: &'a [Marker],
}

impl Curves<'_> {
    /// Range of times, minutes. Totals much longer than the least are left out.
    fn times(&self) -> (f64, f64) {
        let least = self.totals.iter().map(|at| at.0).fold(f64::INFINITY, f64::min);
        let totals = self.totals.iter().map(|at| at.0.min(TOTALS_SHOWN * least));
        let all = self.plunging.iter().chain(self.others.iter().map(|other| &other.at));
        let all = all.map(|at| at.0).chain(totals);
        all.fold((f64::MAX, 0.0f64), |(low, high), time| (low.min(time), high.max(time)))
    }
}

/// Draws the plot; returns the time that the handle was dragged or clicked to.
fn plot(ui: &mut Ui, curves: &Curves, handle: f64, height: f32) -> Option<f64> {
    let &Curves { plunging: curve, totals, others } = curves;
    let size = Vec2::new(ui.available_width(), height);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Hub stock over time of a channel"));
    let inner = Rect::from_min_max(
        rect.min + Vec2::new(MARGIN[0].x, MARGIN[1].y),
        rect.max - Vec2::new(MARGIN[1].x, MARGIN[0].y),
    );
    let all = curve.iter().copied().chain(others.iter().map(|other| other.at));
    let (low, high) = curves.times();
    let top = 1.1 * all.map(|at| at.1).filter(|stock| stock.is_finite()).fold(0.1, f64::max);
    let span = (high - low).max(1e-3);
    // Some margin at both ends, so that handle and markers are not cut off.
    let (low, high) = (low - 0.05 * span, high + 0.08 * span);
    let place = |(time, stock): CurvePlace| {
        let across = ((time - low) / (high - low)) as f32;
        Pos2::new(
            inner.left() + inner.width() * across,
            inner.bottom() - inner.height() * (stock / top) as f32,
        )
    };
    let (painter, units) = (ui.painter_at(rect), units::display_units(ui));
    let font = FontId::proportional(theme::MIN_TEXT_SIZE);
    let (ink, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    painter.rect_filled(inner, 2.0, ui.visuals().extreme_bg_color);
    let (times, decimals) = ticks((low, high));
    for time in times {
        let (below, text) = (place((time, 0.0)) + Vec2::new(0.0, 2.0), format!("{time:.decimals$}"));
        painter.text(below, Align2::CENTER_TOP, text, font.clone(), weak);
    }
    // Round in the unit that is shown.
    let per_mm = units.of_mm(1.0);
    let (stocks, decimals) = ticks((0.0, top * per_mm));
    for stock in stocks {
        let left = place((low, stock / per_mm)) - Vec2::new(4.0, 0.0);
        let text = format!("{stock:.decimals$}");
        painter.text(left, Align2::RIGHT_CENTER, text, font.clone(), weak);
    }
    let below = Pos2::new(inner.center().x, rect.bottom());
    let axes = format!("min per channel; hub stock, 95 %, {}", units.length_unit());
    painter.text(below, Align2::CENTER_BOTTOM, axes, font.clone(), weak);
    let accent = theme::accent(ui.visuals());
    painter.line(curve.iter().map(|&at| place(at)).collect(), Stroke::new(1.6, accent));
    draw_totals(&painter.with_clip_rect(inner), totals, place, &font, ink);
    for other in others {
        let condition = if other.interferes { Condition::Interfering } else { Condition::Sound };
        let (at, colour) = (place(other.at), condition.text(ui.visuals()));
        painter.circle_stroke(at, 4.0, Stroke::new(1.6, colour));
        // The name goes to the side with more space.
        let (side, align) =
            if at.x > inner.center().x { (-7.0, Align2::RIGHT_CENTER) } else { (7.0, Align2::LEFT_CENTER) };
        painter.text(at + Vec2::new(side, 0.0), align, other.name, font.clone(), ink);
    }
    if let Some(stock) = stock_at(curve, handle) {
        let at = place((handle, stock));
        painter.vline(at.x, inner.y_range(), Stroke::new(1.0, accent.gamma_multiply(0.5)));
        let edge = if response.hovered() { ink } else { Color32::TRANSPARENT };
        painter.circle(at, HANDLE, accent, Stroke::new(1.5, edge));
    }
    let pointer = response.interact_pointer_pos().filter(|_| response.dragged() || response.clicked())?;
    let share = f64::from((pointer.x - inner.left()) / inner.width().max(1.0));
    let (fastest, slowest) = (curve.last()?.0, curve.first()?.0);
    Some((low + (high - low) * share).clamp(fastest, slowest))
}

/// Draws the curve with semi-finishing, and a mark at its least time.
fn draw_totals(
    painter: &Painter,
    totals: &[CurvePlace],
    place: impl Fn(CurvePlace) -> Pos2,
    font: &FontId,
    ink: Color32,
) {
    let Some(&least) = totals.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let line: Vec<Pos2> = totals.iter().map(|&at| place(at)).collect();
    painter.extend(Shape::dashed_line(&line, Stroke::new(1.4, ink), 5.0, 3.0));
    let at = place(least);
    painter.circle_filled(at, 3.0, ink);
    let text = format!("with semi-finishing: {:.1} min", least.0);
    painter.text(at + Vec2::new(8.0, -8.0), Align2::LEFT_BOTTOM, text, font.clone(), ink);
}

#[cfg(test)]
mod tests {
    use super::{stock_at, total_at};

    #[test]
    fn the_total_is_found_between_the_same_points() {
        let curve = [(100.0, 1.0), (60.0, 2.0)];
        let totals = [(110.0, 1.0), (90.0, 2.0)];
        assert_eq!(total_at(&curve, 80.0, &totals), Some(100.0));
        assert_eq!(total_at(&curve, 80.0, &[]), None, "the goal does not count it");
    }

    #[test]
    fn between_points_the_curve_is_straight() {
        let curve = [(100.0, 1.0), (60.0, 2.0), (50.0, 4.0)];
        for (minutes, stock) in
            [(120.0, 1.0), (100.0, 1.0), (80.0, 1.5), (60.0, 2.0), (55.0, 3.0), (40.0, 4.0)]
        {
            assert_eq!(stock_at(&curve, minutes), Some(stock), "{minutes} min");
        }
        assert_eq!(stock_at(&curve[..1], 70.0), Some(1.0));
    }
}
