//! The dialog with the settings of a saved picture.

use egui::{DragValue, Modal, RichText, Ui};

use super::modal::is_dismissed;
use crate::gpu::image::MAX_SIDE;

/// Settings of a saved picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExportSettings {
    /// Width and height in pixels; `None`: current size of the view.
    pub size: Option<[u32; 2]>,
    /// Whether the background is transparent.
    pub transparent: bool,
    /// Whether the legend is included.
    pub legend: bool,
}

/// The dialog with the settings of a picture.
#[derive(Default)]
pub(in crate::app) struct ExportDialog {
    open: bool,
}

impl ExportDialog {
    /// Opens it.
    pub(in crate::app) fn open(&mut self) {
        self.open = true;
    }

    /// Whether it is open.
    pub(in crate::app) fn is_open(&self) -> bool {
        self.open
    }

    /// Draws it; `true` when "Save as…" was clicked. `screen`: size of the view, pixels.
    pub(in crate::app) fn show(&mut self, ui: &Ui, settings: &mut ExportSettings, screen: [u32; 2]) -> bool {
        if !self.open {
            return false;
        }
        let (mut save, mut cancel) = (false, false);
        let modal = Modal::new(egui::Id::unique("save picture")).show(ui.ctx(), |ui| {
            ui.set_width(300.0);
            ui.label(RichText::new("Save the 3D view as a picture").strong());
            let mut as_shown = settings.size.is_none();
            ui.checkbox(&mut as_shown, "Current view size");
            let mut size = settings.size.unwrap_or(screen);
            ui.add_enabled_ui(!as_shown, |ui| {
                ui.horizontal(|ui| {
                    for (side, name) in size.iter_mut().zip(["Width", "Height"]) {
                        let label = ui.label(name);
                        let field = DragValue::new(side).range(16..=MAX_SIDE).suffix(" px");
                        ui.add(field).labelled_by(label.id);
                    }
                });
            });
            settings.size = (!as_shown).then_some(size);
            ui.checkbox(&mut settings.transparent, "Transparent background");
            ui.checkbox(&mut settings.legend, "Include legend");
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                save = ui.button("Save as…").clicked();
                cancel = ui.button("Cancel").clicked();
            });
        });
        if save || cancel || is_dismissed(&modal) {
            self.open = false;
        }
        save
    }
}
