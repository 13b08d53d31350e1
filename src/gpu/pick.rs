//! What is under the pointer: the scene drawn once more into a handful of pixels, each holding the number of its
//! position, and read back.

use glam::UVec2;

use super::device::{Gpu, GpuError};
use super::pipelines::{DEPTH_FORMAT, ID_FORMAT};

/// Pixels a side that are looked at.
pub const WINDOW: u32 = 9;
/// How far from the pointer a cutter may be, pixels.
pub const REACH: u32 = WINDOW / 2;

/// Where ids are drawn.
#[derive(Debug)]
pub struct PickTarget {
    ids: wgpu::Texture,
    depth: wgpu::Texture,
}

impl PickTarget {
    /// Textures of [`WINDOW`] × [`WINDOW`].
    pub fn new(device: &wgpu::Device) -> Self {
        let texture = |label, format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: WINDOW, height: WINDOW, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        Self {
            ids: texture("ids", ID_FORMAT, attachment | wgpu::TextureUsages::COPY_SRC),
            depth: texture("depth of ids", DEPTH_FORMAT, attachment),
        }
    }

    /// Draws ids with `draw`: 0 nothing, else the number of the position counted from 1.
    pub fn draw(&self, gpu: &Gpu, draw: impl FnOnce(&mut wgpu::RenderPass)) {
        let (view, depth) =
            (self.ids.create_view(&Default::default()), self.depth.create_view(&Default::default()));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("ids"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(1.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            draw(&mut pass);
        }
        gpu.queue.submit([encoder.finish()]);
    }

    /// The position nearest to the middle of the window, if any.
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

/// The id nearest to the middle of a square window.
fn nearest_id(ids: &[u32]) -> Option<u32> {
    let apart = |k: usize| {
        let (x, y) = (k as u32 % WINDOW, k as u32 / WINDOW);
        x.abs_diff(REACH).pow(2) + y.abs_diff(REACH).pow(2)
    };
    let hits = (0..ids.len()).filter(|&k| ids[k] > 0 && apart(k) <= REACH * REACH);
    hits.min_by_key(|&k| apart(k)).map(|k| ids[k] - 1)
}

/// Reads a texture of `size` back, `bytes` a pixel, top row first.
///
/// # Errors
/// [`GpuError::Failed`] when the device fails.
pub fn read_back(gpu: &Gpu, texture: &wgpu::Texture, size: UVec2, bytes: u32) -> Result<Vec<u8>, GpuError> {
    let failed = |what: &dyn std::fmt::Display| GpuError::Failed(what.to_string());
    // Rows in a copy are padded to a multiple the interface prescribes.
    let row = (size.x * bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(row) * u64::from(size.y),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
        },
        wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    let (send, receive) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        let _ = send.send(result);
    });
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(&e))?;
    receive.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
    if let Some(error) = gpu.take_errors().first() {
        return Err(failed(error));
    }
    let mapped = buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
    let width = (size.x * bytes) as usize;
    Ok(mapped.chunks_exact(row as usize).flat_map(|row| &row[..width]).copied().collect())
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
        assert_eq!(nearest_id(&ids), None, "the corner is out of reach");
        ids[at(REACH + 3, REACH)] = 4;
        assert_eq!(nearest_id(&ids), Some(3));
        ids[at(REACH, REACH)] = 1;
        assert_eq!(nearest_id(&ids), Some(0), "under the pointer itself");
    }
}
