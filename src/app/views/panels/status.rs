//! The status bar: latest message, device, progress and Cancel.

use egui::{Button, Label, ProgressBar, RichText, Ui};

use crate::app::model::look::Operation;
use crate::app::model::state::{AppState, Tone};
use crate::app::views::command::Command;
use crate::app::views::theme::{self, Condition};

/// Input of the status bar besides the state.
#[derive(Clone, Debug, Default)]
pub struct Activity {
    /// Name and progress (0…1) of the running task.
    pub running: Option<(&'static str, f64)>,
    /// Whether it can be cancelled.
    pub can_cancel: bool,
    /// What computes the drawn stock.
    pub preview: String,
    /// Name and driver of the graphics device.
    pub device: String,
    /// Whether the system's file dialog is awaited, which keeps the keys from the window.
    pub awaits_file: bool,
}

/// Said while the system's file dialog is awaited.
const AWAITS_FILE: &str = "Waiting for the system's file dialog (Esc: go on without it)";

/// Width of the progress bar, points.
const BAR: f32 = 130.0;

/// Draws the bar; `true` when Cancel was pressed.
pub fn show(ui: &mut Ui, state: &AppState, activity: &Activity) -> bool {
    let mut cancel = false;
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        cancel = cancel_button(ui, activity.can_cancel, state.document.part.is_some());
        match activity.running {
            Some((what, fraction)) => {
                // What still runs is not done, whatever rounding says.
                let text = RichText::new(format!("{what} {:.0} %", (100.0 * fraction).min(99.0))).small();
                ui.add(ProgressBar::new(fraction as f32).desired_width(BAR).desired_height(16.0).text(text));
            }
            // Reserve the space, so that nothing moves when a task starts.
            None => {
                ui.allocate_space(egui::vec2(BAR, 16.0));
            }
        }
        ui.separator();
        let tip = format!(
            "What computes the stock that the 3D view draws; all figures come from the CPU\n\
             Graphics device: {}",
            activity.device
        );
        ui.label(RichText::new(&activity.preview).weak()).on_hover_text(tip);
        ui.separator();
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| message(ui, state, activity));
    });
    cancel
}

/// Draws Cancel; `true` when it was pressed. While nothing is open, nothing can be calculated: its space is
/// kept, so that nothing moves when a part is opened.
fn cancel_button(ui: &mut Ui, can_cancel: bool, is_open: bool) -> bool {
    let label = Command::Cancel.label();
    if !can_cancel && !is_open {
        let spacing = ui.spacing();
        let (padding, height) = (spacing.button_padding, spacing.interact_size.y);
        ui.allocate_space(egui::vec2(theme::width_of_text(ui, label) + 2.0 * padding.x, height));
        return false;
    }
    let button = ui.add_enabled(can_cancel, Button::new(label));
    button.on_hover_text(Command::Cancel.tip_with_keys(ui.ctx())).clicked()
}

fn flank_message(state: &AppState) -> RichText {
    match &state.results.flank {
        None if state.results.flank_is_running => RichText::new(state.results.words_without_flank()).weak(),
        None => RichText::new(format!("{} (F6)", state.results.words_without_flank())).weak(),
        Some(_) if state.flank_is_stale() => RichText::new("Setup edited: recalculate flank (F6)"),
        Some(outcome) => RichText::new(format!("Flank calculated in {:.1} s", outcome.elapsed)).weak(),
    }
}

fn message(ui: &mut Ui, state: &AppState, activity: &Activity) {
    let running = activity.running.map(|(what, _)| what);
    let text = match (&state.notice, &state.results.planned) {
        _ if activity.awaits_file => RichText::new(AWAITS_FILE).weak(),
        (Some(notice), _) => {
            let colour = Condition::Interfering.text(ui.visuals());
            match (notice.tone, state.problems.iter().filter(|problem| !problem.is_note()).count()) {
                (Tone::Done, _) => RichText::new(&notice.text),
                (Tone::Refusal, _) => {
                    RichText::new(&notice.text).color(Condition::Blocked.text(ui.visuals()))
                }
                (Tone::Fault, 0) => RichText::new(&notice.text).color(colour),
                // The message itself is over the 3D view.
                (Tone::Fault, 1) => RichText::new("1 problem: see the message").color(colour),
                (Tone::Fault, n) => RichText::new(format!("{n} problems: see the messages")).color(colour),
            }
        }
        (None, _) if running.is_some() => RichText::new(format!("{}…", running.unwrap_or_default())).weak(),
        (None, _) if state.look.operation == Operation::Flank => flank_message(state),
        (None, _) if state.look.operation == Operation::Program => {
            match (&state.results.checked, state.stale_check()) {
                (None, _) => RichText::new("No program is checked").weak(),
                (Some(_), Some(why)) => RichText::new(why.brief_words()),
                (Some(checked), None) => RichText::new(format!("Checked {}", checked.name())).weak(),
            }
        }
        (None, Some(_)) if state.out_of_date() => RichText::new("Setup edited: recalculate (F5)"),
        (None, Some(planned)) if planned.is_unfinished() => {
            RichText::new("Cancelled: the best so far; recalculate (F5)")
        }
        (None, Some(planned)) => {
            RichText::new(format!("Calculated in {:.1} s", planned.outcome.elapsed)).weak()
        }
        (None, None) => RichText::new("Ready").weak(),
    };
    let notice = state.notice.as_ref().filter(|_| !activity.awaits_file);
    let tip = notice.map(|notice| notice.text.clone());
    let label = ui.add(Label::new(text).truncate());
    if let Some(tip) = tip {
        label.on_hover_text(tip);
    }
}
