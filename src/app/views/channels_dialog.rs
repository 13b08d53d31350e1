//! The question of how many channels a program is for.

use egui::{Modal, RichText, Ui};

use super::count_field;
use super::modal::is_dismissed;
use crate::app::model::figures::format_duration;
use crate::job::Summary;

/// The dialog.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChannelsDialog {
    /// Chosen number of channels, and that of the part, while it is open.
    asked: Option<(usize, usize)>,
}

impl ChannelsDialog {
    /// Opens it for a part of `count` channels.
    pub fn open(&mut self, count: usize) {
        self.asked = Some((count, count));
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    /// Draws it; returns the number of channels once. `plan`: the plan of one channel.
    pub fn show(&mut self, ui: &Ui, plan: Option<&Summary>) -> Option<usize> {
        let (chosen, count) = self.asked.as_mut()?;
        let (mut save, mut cancel) = (false, false);
        let modal = Modal::new(egui::Id::unique("channels")).show(ui.ctx(), |ui| {
            ui.set_width(300.0);
            ui.label(RichText::new("Export CL of several channels").strong());
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                let label = ui.label("Channels");
                count_field::channels(ui, chosen, *count, label.id);
            });
            if let Some(plan) = plan {
                let whole = format_duration(plan.time_of_channels_s(*chosen, *count));
                let changes = if plan.machine_time.is_some() { "with" } else { "without" };
                ui.label(RichText::new(format!("Time {whole}, {changes} tool changes")).weak());
            }
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                save = ui.button("Save as…").clicked();
                cancel = ui.button("Cancel").clicked();
            });
        });
        let chosen = *chosen;
        if save || cancel || is_dismissed(&modal) {
            self.asked = None;
        }
        save.then_some(chosen)
    }
}
