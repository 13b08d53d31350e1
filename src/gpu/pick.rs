//! GPU picking: the scene is drawn again into a small window about the pointer, each pixel holding the
//! number of its position, and read back.

use glam::UVec2;

use super::device::{Gpu, GpuError};
use super::pipelines::{DEPTH_FORMAT, ID_FORMAT};
use super::target::{self, read_back};

/// Side of the pick window, pixels.
pub const WINDOW: u32 = 9;
/// Largest distance between the pointer and a picked cutter, pixels.
pub const PICK_RADIUS: u32 = WINDOW / 2;

/// Render target for ids.
#[derive(Debug)]
pub struct PickTarget {
    ids: wgpu::Texture,
    depth: wgpu::Texture,
}

impl PickTarget {
    /// Creates textures of [`WINDOW`] × [`WINDOW`] pixels.
    pub fn new(device: &wgpu::Device) -> Self {
        let texture = |label, format, usage| {
            target::create_texture(device, label, format, UVec2::splat(WINDOW), 1, usage)
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        Self {
            ids: texture("ids", ID_FORMAT, attachment | wgpu::TextureUsages::COPY_SRC),
            depth: texture("depth of ids", DEPTH_FORMAT, attachment),
        }
    }

    /// Draws ids with `draw`: 0 for none, else the number of the position, counted from 1.
    pub fn draw(&self, gpu: &Gpu, draw: impl FnOnce(&mut wgpu::RenderPass)) {
        let [ids, depth] = [&self.ids, &self.depth].map(|t| t.create_view(&Default::default()));
        target::run_render_pass(gpu, "ids", &ids, None, &depth, draw);
    }

    /// Index of the position nearest to the middle of the window, if any.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when the device fails.
    pub fn nearest(&self, gpu: &Gpu) -> Result<Option<u32>, GpuError> {
        let bytes = read_back(gpu, &self.ids, UVec2::splat(WINDOW), 4)?;
        let ids: Vec<u32> =
            bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        Ok(nearest_id(&ids))
    }
}

/// Index (id − 1) of the position nearest to the middle of a square window.
fn nearest_id(ids: &[u32]) -> Option<u32> {
    let apart = |k: usize| {
        let (x, y) = (k as u32 % WINDOW, k as u32 / WINDOW);
        x.abs_diff(PICK_RADIUS).pow(2) + y.abs_diff(PICK_RADIUS).pow(2)
    };
    let hits = (0..ids.len()).filter(|&k| ids[k] > 0 && apart(k) <= PICK_RADIUS * PICK_RADIUS);
    hits.min_by_key(|&k| apart(k)).map(|k| ids[k] - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_id_nearest_to_the_pointer_counts_and_far_ones_do_not() {
        let at = |x: u32, y: u32| (y * WINDOW + x) as usize;
        let mut ids = vec![0; (WINDOW * WINDOW) as usize];
        assert_eq!(nearest_id(&ids), None);
        ids[at(0, 0)] = 9;
        assert_eq!(nearest_id(&ids), None, "the corner is beyond the pick radius");
        ids[at(PICK_RADIUS + 3, PICK_RADIUS)] = 4;
        assert_eq!(nearest_id(&ids), Some(3));
        ids[at(PICK_RADIUS, PICK_RADIUS)] = 1;
        assert_eq!(nearest_id(&ids), Some(0), "under the pointer itself");
    }
}
