//! Draw calls of surfaces: hub and blades, the floor with its values, the stock as a solid, and where the
//! section plane cuts these.

use super::mesh_buffers::MeshBuffers;
use super::pipelines::Pipelines;
use super::scene::{DrawGroup, FloorColours, Scene, SceneOptions, WheelBuffers};
use super::stock_floor::DrawnStock;

/// Whether a layer is drawn opaque.
pub(super) fn is_opaque(layer: DrawGroup, options: &SceneOptions) -> bool {
    match layer {
        DrawGroup::Hub | DrawGroup::Floor => options.show_hub,
        DrawGroup::Blades => options.show_blades,
        DrawGroup::CutAway => options.show_blades && !options.cut_away,
        DrawGroup::Shroud | DrawGroup::Foot => false,
    }
}

/// Draws the pieces of those layers for which `wanted` holds.
pub(super) fn draw_surfaces(
    pass: &mut wgpu::RenderPass,
    wheel: &WheelBuffers,
    wanted: &dyn Fn(DrawGroup) -> bool,
) {
    pass.set_vertex_buffer(0, wheel.surfaces.vertices.slice(..));
    pass.set_vertex_buffer(1, wheel.instances.slice(..));
    pass.set_index_buffer(wheel.surfaces.indices.slice(..), wgpu::IndexFormat::Uint32);
    for piece in wheel.pieces.iter().filter(|p| wanted(p.layer)) {
        pass.draw_indexed(piece.indices.clone(), piece.base_vertex, piece.instances.clone());
    }
}

/// Draws surfaces with a value per corner.
pub(super) fn draw_values(pass: &mut wgpu::RenderPass, wheel: &WheelBuffers, mesh: &MeshBuffers) {
    pass.set_vertex_buffer(0, mesh.vertices.slice(..));
    pass.set_vertex_buffer(1, wheel.instances.slice(..));
    pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..mesh.count, 0, 0..1);
}

/// Draws the floor with the heights that the compute kernel left in its buffer.
fn draw_stock(pass: &mut wgpu::RenderPass, pipelines: &Pipelines, wheel: &WheelBuffers, stock: &DrawnStock) {
    pass.set_vertex_buffer(2, stock.heights.slice(..));
    match &stock.less {
        Some(less) => {
            pass.set_pipeline(&pipelines.difference);
            pass.set_vertex_buffer(3, less.slice(..));
        }
        None => pass.set_pipeline(&pipelines.stock),
    }
    draw_values(pass, wheel, &stock.mesh);
}

/// Draws the stock as a solid.
pub(super) fn draw_solid(pass: &mut wgpu::RenderPass, solid: &MeshBuffers) {
    pass.set_vertex_buffer(0, solid.vertices.slice(..));
    pass.set_index_buffer(solid.indices.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..solid.count, 0, 0..1);
}

/// Draws the section plane where the stencil says that it is inside material.
fn draw_cap(pass: &mut wgpu::RenderPass, cap: &wgpu::RenderPipeline) {
    pass.set_pipeline(cap);
    pass.set_stencil_reference(0);
    pass.draw(0..4, 0..1);
}

/// Draws the section plane where it cuts material, if there is one.
pub(super) fn draw_section_cap(
    pass: &mut wgpu::RenderPass,
    wheel: &WheelBuffers,
    options: &SceneOptions,
    parity: &[wgpu::RenderPipeline; 2],
    cap: &wgpu::RenderPipeline,
) {
    if options.section.is_none() {
        return;
    }
    // One stencil bit per kind of solid, because the feet of blades reach a little into the hub.
    if options.show_hub {
        pass.set_pipeline(&parity[0]);
        draw_surfaces(pass, wheel, &|layer| layer == DrawGroup::Hub);
    }
    if options.show_blades {
        pass.set_pipeline(&parity[1]);
        let blade = |layer| matches!(layer, DrawGroup::Blades | DrawGroup::CutAway | DrawGroup::Foot);
        draw_surfaces(pass, wheel, &blade);
    }
    draw_cap(pass, cap);
}

/// Draws the section plane where it cuts the part within the stock, and where it cuts stock beside it.
pub(super) fn draw_solid_cap(
    pass: &mut wgpu::RenderPass,
    wheel: &WheelBuffers,
    options: &SceneOptions,
    pipelines: &Pipelines,
    solid: &MeshBuffers,
) {
    if options.section.is_none() {
        return;
    }
    let whole = SceneOptions { show_hub: true, show_blades: true, ..*options };
    // The part comes first: both caps lie in one plane, where what is drawn later does not show.
    draw_section_cap(pass, wheel, &whole, &pipelines.parity, &pipelines.cap);
    pass.set_pipeline(&pipelines.solid_parity);
    draw_solid(pass, solid);
    draw_cap(pass, &pipelines.solid_cap);
}

/// Draws hub and blades, and the floor with its values.
pub(super) fn draw_part(
    pass: &mut wgpu::RenderPass,
    pipelines: &Pipelines,
    scene: &Scene,
    options: &SceneOptions,
) {
    let wheel = scene.wheel(options);
    pass.set_pipeline(&pipelines.surface);
    draw_surfaces(pass, wheel, &|layer| is_opaque(layer, options));
    let values = || {
        let floor = scene.floor.as_ref()?;
        Some(floor.draft.as_ref().filter(|_| options.draft).unwrap_or(&floor.residual))
    };
    let (stock, floor) = match options.show_floor_colours {
        FloorColours::Residual => match scene.stock.as_ref().filter(|stock| stock.less.is_none()) {
            Some(stock) => (Some(stock), None),
            None => (None, values()),
        },
        FloorColours::Values => match scene.stock.as_ref().filter(|stock| stock.less.is_some()) {
            Some(stock) => (Some(stock), None),
            None => (None, values()),
        },
        FloorColours::Walls => (None, values()),
        FloorColours::Interference => (None, scene.contact.as_ref()),
        FloorColours::Plain => (None, None),
    };
    if let Some(stock) = stock {
        draw_stock(pass, pipelines, wheel, stock);
    }
    if let Some(floor) = floor {
        pass.set_pipeline(&pipelines.floor);
        draw_values(pass, wheel, floor);
    }
}
