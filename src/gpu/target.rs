//! Render targets: creation, one render pass, reading back.

use glam::UVec2;

use super::device::{Gpu, GpuError};

/// Creates a texture of `size` with `samples` samples per pixel.
pub(super) fn create_texture(
    device: &wgpu::Device,
    label: &str,
    format: wgpu::TextureFormat,
    size: UVec2,
    samples: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Runs one render pass into `colour` with `draw`, after clearing colour (transparent), depth (1) and stencil
/// (0). A multisampled `colour` is resolved into `resolved`.
pub(super) fn run_render_pass(
    gpu: &Gpu,
    label: &str,
    colour: &wgpu::TextureView,
    resolved: Option<&wgpu::TextureView>,
    depth: &wgpu::TextureView,
    draw: impl FnOnce(&mut wgpu::RenderPass),
) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: resolved,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: if resolved.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0),
                    store: wgpu::StoreOp::Discard,
                }),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        draw(&mut pass);
    }
    gpu.queue.submit([encoder.finish()]);
}

/// Reads a texture of `size` back, `bytes` per pixel, top row first. Waits for the device.
///
/// # Errors
/// [`GpuError::Failed`] when the device fails.
pub(super) fn read_back(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    size: UVec2,
    bytes: u32,
) -> Result<Vec<u8>, GpuError> {
    let failed = |what: &dyn std::fmt::Display| GpuError::Failed(what.to_string());
    // wgpu requires rows of a copy to be padded to this alignment.
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
