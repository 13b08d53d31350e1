//! The 3D view as a picture file.

use std::path::PathBuf;

use crate::gpu::GpuError;

use super::App;
use super::files::WriteTask;
use super::state::Problem;

impl App {
    /// Writes the view of the side that is shown.
    pub(super) fn export_picture(&mut self, path: PathBuf) {
        let (Some(camera), options) = (self.view.current(), self.options(self.state.look.side)) else {
            return;
        };
        let size = self.glass.size * self.glass.scale;
        let size = [size.x.round().max(1.0) as u32, size.y.round().max(1.0) as u32];
        let side = self.state.look.side;
        let content = self.content(side);
        let Some(picture) = self.pictures.as_mut().and_then(|pictures| pictures.side(side)) else { return };
        picture.load(content);
        match picture.export(&camera, &options, size) {
            Ok(picture) => {
                let task = WriteTask::Picture(path, picture.width, picture.height, picture.rgba);
                self.write(task);
            }
            Err(error) => self.state.fault(device_problem(&error)),
        }
    }
}

/// What to do when the device fails.
pub(super) fn device_problem(error: &GpuError) -> Problem {
    Problem::new(error.to_string(), "save the project and start again with VANECUT_GPU=software")
}
