//! Buffers of all surfaces of a wheel, with the draw calls for them.

use bytemuck::{Pod, Zeroable};

use crate::gpu::device::Gpu;
use crate::gpu::mesh::Mesh;
use crate::gpu::mesh_buffers::{MeshBuffers, vertex_buffer};
use crate::gpu::part_mesh::{BladeMesh, PartMesh};

/// Instance of a surface rotated about Z. 16 bytes, matches `SurfaceIn` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SurfaceInstance {
    turn: [f32; 2],
    kind: u32,
    flags: u32,
}

/// Kinds of surface, in the order of the shader's greys.
const HUB: u32 = 0;
const FLOOR: u32 = 1;
const BLADE: u32 = 2;
const WALL: u32 = 3;
const SHROUD: u32 = 4;
/// Flag: faces the active channel.
const INNER: u32 = 1;
/// Flag: lies on the hub.
const ON_HUB: u32 = 2;

/// Draw group of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::gpu) enum DrawGroup {
    /// Drawn with the hub; a closed surface.
    Hub,
    /// Drawn with the hub, on which it lies.
    Floor,
    /// Drawn with the blades.
    Blades,
    /// Drawn with the blades; transparent when walls are cut away.
    CutAway,
    /// Never drawn; closes the blades at the hub for the parity test.
    Foot,
    /// Drawn with the shroud.
    Shroud,
}

/// One indexed draw call: a range of indices with a range of instances.
#[derive(Clone, Debug)]
pub(in crate::gpu) struct SurfaceDraw {
    pub layer: DrawGroup,
    pub indices: std::ops::Range<u32>,
    pub base_vertex: i32,
    pub instances: std::ops::Range<u32>,
}

/// Surfaces and edges of the wheel at one level of detail.
#[derive(Debug)]
pub(in crate::gpu) struct WheelBuffers {
    pub surfaces: MeshBuffers,
    pub instances: wgpu::Buffer,
    pub pieces: Vec<SurfaceDraw>,
    pub edges: wgpu::Buffer,
    pub edge_count: u32,
}

impl WheelBuffers {
    pub(super) fn new(gpu: &Gpu, part: &PartMesh) -> Self {
        let mut builder = WheelBuilder::default();
        let still = |kind, flags| SurfaceInstance { turn: [1.0, 0.0], kind, flags };
        builder.add(DrawGroup::Hub, &part.hub, &[still(HUB, 0)]);
        builder.add(DrawGroup::Floor, &part.floor, &[still(FLOOR, ON_HUB)]);
        builder.add_blade(&part.main, 2);
        for splitter in &part.splitters {
            builder.add_blade(splitter, 1);
        }
        builder.add(DrawGroup::Shroud, &part.shroud, &[still(SHROUD, 0)]);
        Self {
            surfaces: MeshBuffers::new(gpu, &builder.mesh),
            instances: vertex_buffer(gpu, "surface copies", &builder.instances),
            pieces: builder.pieces,
            edges: vertex_buffer(gpu, "edges", &part.edges),
            edge_count: part.edges.len() as u32,
        }
    }
}

/// Collects surfaces into shared buffers.
#[derive(Default)]
struct WheelBuilder {
    mesh: Mesh,
    instances: Vec<SurfaceInstance>,
    pieces: Vec<SurfaceDraw>,
}

impl WheelBuilder {
    fn load(&mut self, mesh: &Mesh) -> (std::ops::Range<u32>, i32) {
        let base_vertex = self.mesh.vertices.len() as i32;
        let first = self.mesh.indices.len() as u32;
        self.mesh.vertices.extend_from_slice(&mesh.vertices);
        self.mesh.indices.extend_from_slice(&mesh.indices);
        (first..self.mesh.indices.len() as u32, base_vertex)
    }

    fn add_instances(
        &mut self,
        layer: DrawGroup,
        loaded: &(std::ops::Range<u32>, i32),
        copies: &[SurfaceInstance],
    ) {
        if copies.is_empty() {
            return;
        }
        let first = self.instances.len() as u32;
        self.instances.extend_from_slice(copies);
        self.pieces.push(SurfaceDraw {
            layer,
            indices: loaded.0.clone(),
            base_vertex: loaded.1,
            instances: first..self.instances.len() as u32,
        });
    }

    fn add(&mut self, layer: DrawGroup, mesh: &Mesh, copies: &[SurfaceInstance]) {
        let loaded = self.load(mesh);
        self.add_instances(layer, &loaded, copies);
    }

    /// Adds a blade row whose first `lit` copies belong to the active channel: 2 walls, or 1 splitter inside
    /// it.
    fn add_blade(&mut self, blade: &BladeMesh, lit: usize) {
        let copy = |k: usize, kind, flags| SurfaceInstance {
            turn: [blade.rotations_rad[k].cos() as f32, blade.rotations_rad[k].sin() as f32],
            kind,
            flags,
        };
        let lit = lit.min(blade.rotations_rad.len());
        let pale: Vec<SurfaceInstance> =
            (lit..blade.rotations_rad.len()).map(|k| copy(k, BLADE, 0)).collect();
        for (side, mesh) in [&blade.suction, &blade.pressure].into_iter().enumerate() {
            let loaded = self.load(mesh);
            self.add_instances(DrawGroup::Blades, &loaded, &pale);
            for k in 0..lit {
                // Wall 0 bounds the channel with its suction side, wall 1 with its pressure side.
                if lit == 2 && side == k {
                    self.add_instances(DrawGroup::Blades, &loaded, &[copy(k, WALL, INNER)]);
                } else {
                    self.add_instances(DrawGroup::CutAway, &loaded, &[copy(k, WALL, 0)]);
                }
            }
        }
        let loaded = self.load(&blade.closing);
        self.add_instances(DrawGroup::Blades, &loaded, &pale);
        let near: Vec<SurfaceInstance> = (0..lit).map(|k| copy(k, WALL, 0)).collect();
        self.add_instances(DrawGroup::Blades, &loaded, &near);
        let foot = self.load(&blade.foot);
        let all: Vec<SurfaceInstance> = (0..blade.rotations_rad.len()).map(|k| copy(k, BLADE, 0)).collect();
        self.add_instances(DrawGroup::Foot, &foot, &all);
    }
}
