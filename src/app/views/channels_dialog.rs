//! The question of how many channels a program is for.

use egui::{Grid, Modal, RichText, Ui};

use super::channel_order;
use super::count_field;
use super::modal::{self, is_confirmed, is_dismissed};
use crate::app::model::figures::TimedPlan;
use crate::app::model::look::Operation;
use crate::setup::ChannelSetup;

/// The dialog.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChannelsDialog {
    /// Chosen number of channels, and that of the part, while it is open.
    asked: Option<(usize, usize)>,
}

impl ChannelsDialog {
    /// Opens it for a part of `count` channels, with `chosen` of them.
    pub fn open(&mut self, chosen: usize, count: usize) {
        self.asked = Some((chosen.clamp(1, count), count));
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    /// Draws it for the program of `operation`; returns the number of channels once. `plan`: the plan of one
    /// channel; `order`: that of the setup.
    pub fn show(
        &mut self,
        ui: &Ui,
        operation: Operation,
        plan: Option<&TimedPlan>,
        order: &mut ChannelSetup,
    ) -> Option<usize> {
        let (chosen, count) = self.asked.as_mut()?;
        let (mut save, mut cancel) = (is_confirmed(ui.ctx()), false);
        let modal = Modal::new(egui::Id::unique("channels")).show(ui.ctx(), |ui| {
            modal::fitting(ui, 340.0, |ui| {
                let title = format!("Export CL of several channels: {}", operation.label());
                ui.label(RichText::new(title).strong());
                ui.add_space(4.0);
                Grid::new("channels fields").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
                    let label = ui.label("Channels");
                    count_field::channels(ui, chosen, *count, label.id);
                    ui.end_row();
                    channel_order::rows(ui, order);
                });
                if let Some(time) = plan.and_then(|plan| plan.program_time(*chosen, *count)) {
                    ui.label(RichText::new(time).weak());
                }
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    save |= ui.button("Save as…").clicked();
                    cancel = ui.button("Cancel").clicked();
                });
            });
        });
        let chosen = *chosen;
        if save || cancel || is_dismissed(&modal) {
            self.asked = None;
        }
        save.then_some(chosen)
    }
}
