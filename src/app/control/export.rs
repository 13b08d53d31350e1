//! Files that leave the window: programs, after a question where something speaks against them; scenes and
//! pictures.

use std::path::PathBuf;

use egui::Ui;

use crate::app::App;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::problem::Problem;
use crate::app::model::release::concerns;
use crate::app::tasks::files::{SceneTask, WriteTask};
use crate::app::views::command::Command;
use crate::app::views::picture_dialog::ExportSettings;
use crate::app::views::release::{self, ReleaseAnswer};
use crate::gpu::image::MAX_SIDE;
use crate::gpu::legend::add_legend;
use crate::gpu::{GpuError, SceneOptions};

/// A program that waits for an answer.
#[derive(Debug)]
pub(in crate::app) struct ReleaseQuestion {
    purpose: Purpose,
    path: PathBuf,
    concerns: Vec<String>,
}

impl App {
    /// Writes the chosen file; a program with something against it is asked about first.
    pub fn file_chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: PathBuf) {
        let concerns = concerns(&self.state, purpose);
        if concerns.is_empty() {
            self.use_file(ctx, purpose, path);
        } else {
            self.release = Some(ReleaseQuestion { purpose, path, concerns });
        }
    }

    /// Asks about a program, while that is due.
    pub(in crate::app) fn ask_release(&mut self, ui: &Ui) {
        let answer = self.release.as_ref().and_then(|question| release::ask(ui, &question.concerns));
        let Some(answer) = answer else { return };
        let Some(ReleaseQuestion { purpose, path, .. }) = self.release.take() else { return };
        match answer {
            ReleaseAnswer::Recalculate => {
                let command =
                    if purpose == Purpose::ExportFlank { Command::PlanFlank } else { Command::Plan };
                self.run_command(ui.ctx(), command);
            }
            ReleaseAnswer::Export => self.use_file(ui.ctx(), purpose, path),
            ReleaseAnswer::Cancel => {}
        }
    }

    /// Settings of saved pictures.
    pub fn export_settings_mut(&mut self) -> &mut ExportSettings {
        &mut self.export
    }

    /// Asks how many channels a program is for, while that is due.
    pub(in crate::app) fn ask_channels(&mut self, ui: &Ui) {
        let shown = self.state.last_whole_plan(self.state.look.side);
        let time = shown.map(|shown| shown.planned.result(shown.policy).summary.time_estimate);
        if let Some(channels) = self.channels_dialog.show(ui, time) {
            self.ask_for_cl_file(ui.ctx(), channels);
        }
    }

    /// Draws the picture dialog.
    pub(in crate::app) fn ask_export(&mut self, ui: &Ui) {
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
    pub(in crate::app) fn export_scene(&mut self, path: PathBuf) {
        let Some(part) = &self.state.document.part else { return };
        let shown = self.state.last_whole_plan(self.state.look.side);
        let planned = shown.map(|shown| (shown.planned.clone(), shown.policy));
        let scene = SceneTask { part: part.impeller.clone(), planned, range: self.state.range() };
        self.write(WriteTask::Scene(path, scene));
    }

    /// Writes the view of the active side as a picture.
    pub(in crate::app) fn export_picture(&mut self, path: PathBuf) {
        let side = self.state.look.side;
        let Some(camera) = self.view.current() else { return };
        let settings = self.export;
        let options = SceneOptions { transparent: settings.transparent, ..self.options(side) };
        let size = settings.size.unwrap_or(self.screen_size());
        let content = self.content(side);
        let program = self.state.shown_program().cloned();
        let (flank, tool) = (self.flank_content(), self.shown_tool());
        let Some(picture) = self.pictures.as_mut().and_then(|pictures| pictures.side(side)) else { return };
        picture.load(content);
        let look = &self.state.look;
        picture.load_cutter_colours(look.layers.cutter_colours, &look.hidden_classes);
        // A file cannot show the badge of a plan under way, so its preview is left out.
        picture.load_preview(tool.as_ref());
        picture.load_flank(flank);
        picture.load_program(program.as_ref());
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
pub(in crate::app) fn device_problem(error: &GpuError) -> Problem {
    Problem::new(error.to_string(), "save the project and restart with VANECUT_GPU=software")
}
