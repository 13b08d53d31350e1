//! Vertex and index buffers of meshes.

use bytemuck::Pod;

use super::device::Gpu;
use super::mesh::Mesh;

/// Vertex and index buffer. Clones share them.
#[derive(Clone, Debug)]
pub(super) struct MeshBuffers {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub count: u32,
}

impl MeshBuffers {
    pub(super) fn new(gpu: &Gpu, mesh: &Mesh) -> Self {
        Self {
            vertices: vertex_buffer(gpu, "floor corners", &mesh.vertices),
            indices: index_buffer(gpu, "floor triangles", &mesh.indices),
            count: mesh.indices.len() as u32,
        }
    }
}

pub(super) fn vertex_buffer<T: Pod>(gpu: &Gpu, label: &str, contents: &[T]) -> wgpu::Buffer {
    gpu.filled_buffer(label, bytemuck::cast_slice(contents), wgpu::BufferUsages::VERTEX)
}

pub(super) fn index_buffer(gpu: &Gpu, label: &str, indices: &[u32]) -> wgpu::Buffer {
    gpu.filled_buffer(label, bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX)
}
