//! Graphics device, compute kernel and renderer; independent of the window. It draws meshes, lines and
//! instances of cutters; `drawing` makes them of parts and plans. The kernel is the twin of the heightfield
//! in [`crate::stock`].

pub mod camera;
pub mod cutter_caps;
pub mod cutters;
pub mod device;
mod drawn_cutters;
pub mod image;
pub mod legend;
pub mod mesh;
mod mesh_buffers;
pub mod part_mesh;
pub mod pick;
mod pipelines;
pub mod renderer;
pub mod residual;
pub mod scene;
pub mod stock_floor;
mod surfaces;
mod target;
mod uniform;
pub mod view;

use crate::error::{ErrorCode, UserError};

pub use crate::palette::{ColourMap, Theme};
pub use camera::{Camera, Projection};
pub use cutters::{CutterFilter, CutterSet};
pub use device::{Gpu, GpuError, device_descriptor, pick_adapter};
pub use image::encode_png;
pub use renderer::{Picture, Renderer, draft_size};
pub use residual::ResidualKernel;
pub use scene::{FloorColours, FloorMeshes, Pick, Scene, SceneOptions, SectionPlane};
pub use stock_floor::{StockFloor, StockState};
pub use view::View;

/// The error of a word for colours that is none of those that `help` names.
pub(crate) fn unknown_colours(word: &str, help: &str) -> UserError {
    UserError::new(ErrorCode::UnknownName, format!("unknown colours \"{word}\""), help)
}
