//! The list of operations: one is selected, and only that one is shown and edited.

use egui::{Button, Role, Ui, WidgetInfo};

use crate::app::model::figures::{TimeUnits, format_duration};
use crate::app::model::look::Operation;
use crate::app::model::planned::Side;
use crate::app::model::state::AppState;
use crate::app::model::verdict::{self, count_faults};
use crate::app::views::command::Command;
use crate::app::views::list_keys;
use crate::app::views::theme::Condition;
use crate::job::PolicyResult;

/// State of an operation, in words and as a condition.
fn status(
    state: &AppState,
    operation: Operation,
    running: Option<&'static str>,
    units: TimeUnits,
) -> (String, Option<Condition>) {
    let times = |(channel_s, wheel_s): (f64, Option<f64>)| match wheel_s {
        Some(wheel) => format!("{}, wheel {}", units.channel.text(channel_s), units.wheel.text(wheel)),
        None => units.channel.text(channel_s),
    };
    let (times, (condition, wrong), is_stale) = match operation {
        Operation::Roughing => {
            let Some(shown) = state.last_whole_plan(Side::After) else { return unplanned(running) };
            let result = shown.planned.result(shown.policy);
            (times(roughing_times(state, result)), verdict::of_plunges(state, result), state.out_of_date())
        }
        Operation::Program => {
            let Some(checked) = &state.results.checked else {
                return (running.unwrap_or("not checked").to_owned(), None);
            };
            let verdict = match checked.findings.len() {
                0 => (Condition::Sound, None),
                count => (Condition::Interfering, Some(count_faults(count))),
            };
            (format_duration(checked.time_s()), verdict, state.program_is_stale())
        }
        Operation::Flank => {
            let Some(outcome) = &state.results.flank else { return unplanned(running) };
            (
                times((outcome.time_s(), outcome.wheel_time_s)),
                verdict::of_flank(state, outcome),
                state.flank_is_stale(),
            )
        }
    };
    if let Some(running) = running {
        (running.to_owned(), None)
    } else if is_stale {
        ("out of date".to_owned(), Some(Condition::Blocked))
    } else {
        (wrong.unwrap_or(times), Some(condition))
    }
}

/// Time of a channel, and of the wheel, s.
fn roughing_times(state: &AppState, result: &PolicyResult) -> (f64, Option<f64>) {
    let channels = state.document.part.as_ref().map_or(1, |part| part.impeller.blade_count);
    (result.summary.time_s(), Some(result.summary.time_of_channels_s(channels, channels)))
}

/// Units of the times of both operations, which stand below each other.
fn units(state: &AppState) -> TimeUnits {
    let roughing = state.last_whole_plan(Side::After).map(|shown| shown.planned.result(shown.policy));
    let roughing = roughing.map(|result| roughing_times(state, result));
    let flank = state.results.flank.as_ref().map(|outcome| (outcome.time_s(), outcome.wheel_time_s));
    let times = roughing.into_iter().chain(flank);
    TimeUnits::for_all(
        &times.map(|(channel, wheel)| (channel, wheel.unwrap_or(f64::NAN))).collect::<Vec<_>>(),
    )
}

fn unplanned(running: Option<&'static str>) -> (String, Option<Condition>) {
    (running.unwrap_or("not calculated").to_owned(), None)
}

/// Draws the list; returns the operation that was clicked. `running`: words for an operation that is being
/// calculated.
pub fn show(
    ui: &mut Ui,
    state: &AppState,
    running: impl Fn(Operation) -> Option<&'static str>,
) -> Option<Operation> {
    let mut clicked = None;
    let mut shown = Vec::new();
    let units = units(state);
    let all = [
        (Operation::Roughing, Command::Plan),
        (Operation::Flank, Command::PlanFlank),
        (Operation::Program, Command::CheckAgain),
    ];
    let has_program = state.results.checked.is_some() || state.look.operation == Operation::Program;
    for (operation, command) in all {
        if operation == Operation::Program && !has_program {
            continue;
        }
        let selected = state.look.operation == operation;
        let (words, condition) = status(state, operation, running(operation), units);
        let visuals = ui.visuals();
        let colour = match condition {
            // The colours of conditions are too pale on that of the selection.
            _ if selected => visuals.selection.stroke.color,
            Some(condition) => condition.text(visuals),
            None => visuals.weak_text_color(),
        };
        let button = Button::selectable(selected, operation.label())
            .right_text(egui::RichText::new(&words).color(colour))
            .min_size(egui::vec2(ui.available_width(), 22.0));
        let response = ui.add(button);
        let name = format!("{}: {words}", operation.label());
        response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, selected, &name));
        let response = response.on_hover_text(command.tip_with_keys(ui.ctx()));
        if response.clicked() {
            clicked = Some(operation);
        }
        shown.push((operation, response));
    }
    for (at, (_, response)) in shown.iter().enumerate() {
        if let Some(to) = list_keys::moved(at, list_keys::step(ui, response), shown.len()) {
            shown[to].1.request_focus();
            clicked = Some(shown[to].0);
        }
    }
    clicked
}
