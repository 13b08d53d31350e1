//! The status bar: progress and Cancel always in the same place, the latest message, the device.

use egui::{Button, Label, ProgressBar, RichText, Ui};

use super::super::command::Command;
use super::super::state::{State, Tone};
use super::super::theme::Condition;

/// What the bar shows beside the state.
#[derive(Clone, Debug, Default)]
pub struct Activity {
    /// What runs, and how far it is (0…1).
    pub running: Option<(&'static str, f64)>,
    /// The device that draws.
    pub device: String,
}

/// Width of the progress bar, points.
const BAR: f32 = 130.0;

/// Draws the bar; `true` when Cancel was pressed.
pub fn show(ui: &mut Ui, state: &State, activity: &Activity) -> bool {
    let mut cancel = false;
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let button = ui.add_enabled(activity.running.is_some(), Button::new(Command::Cancel.label()));
        cancel = button.on_hover_text(Command::Cancel.tip_with_keys(ui.ctx())).clicked();
        match activity.running {
            Some((what, fraction)) => {
                let text = RichText::new(format!("{what} {:.0} %", 100.0 * fraction)).small();
                ui.add(ProgressBar::new(fraction as f32).desired_width(BAR).desired_height(16.0).text(text));
            }
            // The place stays: nothing moves when work begins.
            None => {
                ui.allocate_space(egui::vec2(BAR, 16.0));
            }
        }
        ui.separator();
        ui.label(RichText::new(&activity.device).weak()).on_hover_text("The device that draws the 3D view");
        ui.separator();
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| message(ui, state, activity));
    });
    cancel
}

fn message(ui: &mut Ui, state: &State, activity: &Activity) {
    let text = match (&state.notice, &state.results.planned) {
        (Some(notice), _) => {
            let text = RichText::new(&notice.text);
            match notice.tone {
                Tone::Done => text,
                Tone::Fault => text.color(Condition::Interferential.text(ui.visuals())),
            }
        }
        (None, _) if activity.running.is_some() => RichText::new("Working; the window stays yours").weak(),
        (None, Some(_)) if state.out_of_date() => RichText::new("Setup edited: plan again (F5)"),
        (None, Some(planned)) if planned.is_unfinished() => {
            RichText::new("Cancelled: the best so far; plan again (F5)")
        }
        (None, Some(planned)) => {
            RichText::new(format!("Planned in {:.0} ms", 1000.0 * planned.outcome.elapsed)).weak()
        }
        (None, None) => RichText::new("Ready").weak(),
    };
    let tip = state.notice.as_ref().map(|notice| notice.text.clone());
    let label = ui.add(Label::new(text).truncate());
    if let Some(tip) = tip {
        label.on_hover_text(tip);
    }
}
