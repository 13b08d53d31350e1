//! Pictures of the view as files, and faults of the device that draws them.

use std::path::PathBuf;

use egui::Ui;

use crate::app::App;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::look::Arrangement;
use crate::app::model::planned::Side;
use crate::app::model::problem::Problem;
use crate::app::tasks::files::WriteTask;
use crate::gpu::camera::Camera;
use crate::gpu::device::DEVICE_LOST_PREFIX;
use crate::gpu::image::MAX_SIDE;
use crate::gpu::legend::add_legend;
use crate::gpu::{GpuError, Picture, SceneOptions};

impl App {
    /// Notes how long the first picture took.
    pub(in crate::app) fn note_first_picture(&mut self) {
        if let (Some(start), None) = (self.start, self.first_picture) {
            let is_timing = std::env::var_os("VANECUT_TIMES").is_some();
            if let Some(pictures) = self.pictures.as_ref().filter(|_| is_timing) {
                pictures.wait();
            }
            let took = start.elapsed();
            self.first_picture = Some(took);
            if is_timing {
                eprintln!("vanecut: first picture after {:.0} ms", 1e3 * took.as_secs_f64());
            }
        }
    }

    /// Handles errors reported by the graphics device.
    pub(in crate::app) fn collect_device_faults(&mut self, ctx: &egui::Context) {
        let errors = self.pictures.as_ref().map(|pictures| pictures.take_errors()).unwrap_or_default();
        let lost = errors.iter().find(|error| error.starts_with(DEVICE_LOST_PREFIX));
        let Some(error) = lost.or(errors.last()) else { return };
        let line = error.lines().next().unwrap_or_default();
        // Save the work first, whatever happens to the device.
        self.copy_now();
        if lost.is_some() && self.hand_over(ctx, line) {
            return;
        }
        let problem = Problem::new(
            format!("The graphics device reports: {line}"),
            "save the project and restart with VANECUT_GPU=software",
        );
        if lost.is_some() {
            // The window itself may not be able to draw any more.
            eprintln!("vanecut: {}; {}", problem.message, problem.help);
            self.pictures = None;
            self.hover = None;
            "no 3D view".clone_into(&mut self.device);
        }
        self.state.report_problem(problem);
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

    /// Writes the view as a picture, with both plans where it shows both.
    pub(in crate::app) fn export_picture(&mut self, path: PathBuf) {
        let Some(camera) = self.view.current() else { return };
        let size = self.export.size.unwrap_or(self.screen_size());
        match self.drawn_view(&camera, size) {
            Ok(None) => {}
            Ok(Some(picture)) => {
                self.write(WriteTask::Picture(path, picture.width, picture.height, picture.rgba));
            }
            Err(error) => self.state.report_problem(Problem::of_device(&error)),
        }
    }

    /// The view in pixels; `None` while nothing can be drawn.
    fn drawn_view(
        &mut self,
        camera: &Camera,
        [width, height]: [u32; 2],
    ) -> Result<Option<Picture>, GpuError> {
        let look = &self.state.look;
        let border = (f64::from(look.wipe) * f64::from(width)).round() as u32;
        let (widths, columns) = match look.shown_arrangement() {
            Arrangement::One => {
                let side = look.side;
                let drawn = self.drawn_side(side, camera, [width, height])?;
                return Ok(drawn.map(|picture| self.with_legend(picture, side)));
            }
            Arrangement::Both => {
                let widths = [width / 2, width - width / 2];
                (widths, widths.map(|width| 0..width))
            }
            Arrangement::Wipe => ([width; 2], [0..border, border..width]),
        };
        let before = self.drawn_side(Side::Before, camera, [widths[0], height])?;
        let after = self.drawn_side(Side::After, camera, [widths[1], height])?;
        let Some((before, after)) = before.zip(after) else { return Ok(None) };
        let [left, right] = columns;
        let (before, after) = (before.columns(left), after.columns(right));
        let scale = |side| {
            let SceneOptions { map, range_mm, show_floor_colours, .. } = self.picture_options(side);
            (map, range_mm, show_floor_colours)
        };
        // One legend is enough where both have the same scale.
        Ok(Some(if scale(Side::Before) == scale(Side::After) {
            self.with_legend(Picture::beside(&before, &after), Side::Before)
        } else {
            let [before, after] = [(before, Side::Before), (after, Side::After)]
                .map(|(part, side)| self.with_legend(part, side));
            Picture::beside(&before, &after)
        }))
    }

    /// The picture of a side with its legend, where that is asked for.
    fn with_legend(&self, mut picture: Picture, side: Side) -> Picture {
        if self.export.legend {
            add_legend(&mut picture, &self.picture_options(side));
        }
        picture
    }

    fn drawn_side(
        &mut self,
        side: Side,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<Option<Picture>, GpuError> {
        let options = self.picture_options(side);
        let content = self.content(side);
        let program = self.state.drawn_program().cloned();
        let (flank, tool) = (self.flank_content(), self.shown_tool());
        let Some(picture) = self.pictures.as_mut().and_then(|pictures| pictures.side(side)) else {
            return Ok(None);
        };
        picture.load(content);
        let look = &self.state.look;
        picture.load_cutter_colours(
            look.layers.cutter_colours,
            &look.hidden_classes,
            &self.state.plans_in_view(),
        );
        // A file cannot show the badge of a plan under way, so its preview is left out.
        picture.load_preview(tool.as_ref());
        picture.load_flank(flank);
        picture.load_program(program.as_ref());
        picture.export(camera, &options, size).map(Some)
    }

    fn picture_options(&self, side: Side) -> SceneOptions {
        SceneOptions { transparent: self.export.transparent, ..self.options(side) }
    }
}
