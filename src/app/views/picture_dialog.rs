//! The dialog with the settings of a saved picture.

use egui::{Modal, RichText, Ui};

use super::modal::{self, is_confirmed, is_dismissed};
use super::typed::{self, TypedLimits};
use crate::app::model::number::Quantity;
use crate::app::model::units::DisplayUnits;
use crate::gpu::image::MAX_SIDE;

/// Least side of a saved picture, pixels.
const MIN_SIDE: u32 = 16;
/// Name of the size, and value that the note on it goes by: two fields share a line below them.
const SIZE: &str = "Size of the picture";
const BOTH: f64 = 0.0;

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
        let (mut save, mut cancel) = (is_confirmed(ui.ctx()), false);
        let modal = Modal::new(egui::Id::unique("save picture")).show(ui.ctx(), |ui| {
            modal::fitting(ui, 300.0, |ui| {
                ui.label(RichText::new("Save the 3D view as a picture").strong());
                let mut as_shown = settings.size.is_none();
                ui.checkbox(&mut as_shown, "Current view size");
                let mut size = settings.size.unwrap_or(screen);
                let (form, mut at) = (ui.scope_id(), egui::Rect::NOTHING);
                let limits = TypedLimits {
                    quantity: Quantity::Count,
                    units: DisplayUnits::Metric,
                    range: f64::from(MIN_SIDE)..=f64::from(MAX_SIDE),
                    why_least: "",
                    why_most: ", what graphics devices can draw",
                    show: &|pixels: f64| format!("{pixels:.0} px"),
                };
                ui.add_enabled_ui(!as_shown, |ui| {
                    ui.horizontal(|ui| {
                        for (side, name) in size.iter_mut().zip(["Width", "Height"]) {
                            let label = ui.label(name);
                            let (field, said) = typed::limited_field(ui, side, &limits, 1.0);
                            typed::keep(ui, form, SIZE, BOTH, said);
                            at = at.union(field.labelled_by(label.id).rect);
                        }
                    });
                    typed::show(ui, form, SIZE, BOTH, at);
                });
                settings.size = (!as_shown).then_some(size);
                ui.checkbox(&mut settings.transparent, "Transparent background");
                ui.checkbox(&mut settings.legend, "Include legend");
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    save |= ui.button("Save as…").clicked();
                    cancel = ui.button("Cancel").clicked();
                });
            });
        });
        if save || cancel || is_dismissed(&modal) {
            self.open = false;
        }
        save
    }
}
