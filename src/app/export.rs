//! The 3D view as a picture file.

use std::path::PathBuf;

use egui::{DragValue, Modal, RichText, Ui};

use crate::gpu::legend::add_legend;
use crate::gpu::{GpuError, SceneOptions};

use super::App;
use super::dialogs::Purpose;
use super::files::{SceneTask, WriteTask};
use super::problem::Problem;

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

/// Maximum side length of a picture, pixels.
const MAX_SIDE: u32 = 8192;

/// The dialog with the settings of a picture.
#[derive(Default)]
pub(super) struct ExportDialog {
    open: bool,
}

impl ExportDialog {
    /// Opens it.
    pub(super) fn open(&mut self) {
        self.open = true;
    }

    /// Whether it is open.
    pub(super) fn is_open(&self) -> bool {
        self.open
    }

    /// Draws it; `true` when "Save as…" was clicked. `screen`: size of the view, pixels.
    fn show(&mut self, ui: &Ui, settings: &mut ExportSettings, screen: [u32; 2]) -> bool {
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
        if save || cancel || modal.should_close() {
            self.open = false;
        }
        save
    }
}

impl App {
    /// Settings of saved pictures.
    pub fn export_settings_mut(&mut self) -> &mut ExportSettings {
        &mut self.export
    }

    /// Draws the picture dialog.
    pub(super) fn ask_export(&mut self, ui: &Ui) {
        let screen = self.screen_size();
        let mut dialog = std::mem::take(&mut self.export_dialog);
        if dialog.show(ui, &mut self.export, screen) {
            let name = self.suggest_file_name("picture.png");
            self.dialogs.open_dialog(ui.ctx(), Purpose::SavePicture, name);
        }
        self.export_dialog = dialog;
    }

    fn screen_size(&self) -> [u32; 2] {
        let size = self.screen.size * self.screen.scale;
        [size.x, size.y].map(|side| (side.round() as u32).clamp(1, MAX_SIDE))
    }

    /// Writes the part as a glTF scene, with the plan of the active side.
    pub(super) fn export_scene(&mut self, path: PathBuf) {
        let Some(part) = &self.state.document.part else { return };
        let shown = self.state.last_whole_plan(self.state.look.side);
        let planned = shown.map(|shown| (shown.planned.clone(), shown.policy));
        let scene = SceneTask { part: part.impeller.clone(), planned, range: self.state.range() };
        self.write(WriteTask::Scene(path, scene));
    }

    /// Writes the view of the active side as a picture.
    pub(super) fn export_picture(&mut self, path: PathBuf) {
        let side = self.state.look.side;
        let Some(camera) = self.view.current() else { return };
        let settings = self.export;
        let options = SceneOptions { transparent: settings.transparent, ..self.options(side) };
        let size = settings.size.unwrap_or(self.screen_size());
        let content = self.content(side);
        let flank =
            self.state.shown_flank().map(|(outcome, colours)| (std::sync::Arc::clone(outcome), colours));
        let Some(picture) = self.pictures.as_mut().and_then(|pictures| pictures.side(side)) else { return };
        picture.load(content);
        picture.load_cutter_colours(self.state.look.layers.cutter_colours);
        // A file cannot show the badge of a preview, so leave the preview out.
        picture.load_preview(None);
        picture.load_flank(flank);
        match picture.export(&camera, &options, size) {
            Ok(mut picture) => {
                if settings.legend {
                    add_legend(&mut picture, &options);
                }
                self.write(WriteTask::Picture(path, picture.width, picture.height, picture.rgba));
            }
            Err(error) => self.state.report_problem(device_problem(&error)),
        }
    }
}

/// Problem message for a failure of the device.
pub(super) fn device_problem(error: &GpuError) -> Problem {
    Problem::new(error.to_string(), "save the project and restart with VANECUT_GPU=software")
}
